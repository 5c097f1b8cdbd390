"""One grid of the problem: its operators, its passes over memory, and the room they need."""

from dataclasses import dataclass

import numpy as np

from roughcontact.contact.extension import Extension, coarsening, collapse
from roughcontact.contact.state import State, Way, contact_mean, norm, scale_to_load
from roughcontact.halfspace import HalfSpace
from roughcontact.kernels import kernels_for

BLOCK = 16  # cells along the finer axis over which a step keeps the load
SMALL_CHANGE = 0.1  # of the residual's norm, that is simply added to it


@dataclass(frozen=True)
class Product:
    """M r, the preconditioned residual of a state: `field` (ny, nx) zero at the settled points.

    `mean` is that over the `unsettled` points; `energy` = <r, M r>, a mean over the grid. The field lies in a
    buffer that the next application of an operator overwrites.
    """

    field: np.ndarray
    mean: float
    unsettled: int
    energy: float


class Grid:
    """The heights H (ny, nx) on a cell of `lengths` = (Ly, Lx), dimensionless, with all that acts on them.

    `cap` is the largest pressure allowed (the hardness), or infinity.
    """

    def __init__(
        self, heights, lengths, *, cap: float = np.inf, influence: str = "sampled", threads: int = 1
    ):
        self.heights = heights
        self._heights_in = {heights.dtype: heights}
        self.cap = cap
        self.halfspace = HalfSpace(heights.shape, lengths, influence=influence, threads=threads)
        self.kernels = kernels_for(heights, threads=threads)
        self._extensions = {}
        self._block = load_block(heights.shape, lengths)
        blocks = [n // b for n, b in zip(heights.shape, self._block, strict=True)]
        self._loads = np.empty(blocks), np.empty(blocks)
        self._height_size = float(np.sqrt(np.mean(heights * heights)))

    @property
    def shape(self):
        return self.halfspace.shape

    def evaluate(self, pressure, *, before: State | None = None, room=None) -> tuple[State, Way]:
        """Return the state of a feasible `pressure` by a fresh application of G, and the way from `before`.

        All in the precision of `pressure`; `room` is an array for the separation.
        """
        dtype = pressure.dtype
        heights = self.heights_in(dtype)
        displaced = self.halfspace.displacement(pressure)
        if room is None or room.dtype != dtype:
            room = displaced.__array_namespace__().empty_like(displaced)
        start = (
            (pressure, room, 0.0) if before is None else (before.pressure, before.separation, before.level)
        )
        work, square, total, count, slope, slope_after = self.kernels.measure(
            displaced, heights, *start, pressure, room, self.cap
        )
        size = pressure.size
        state = State(
            pressure=pressure,
            separation=room,
            level=total / count if count else contact_mean(pressure, room, cap=self.cap),
            norm=float(np.sqrt(max(work, 0) / size)),
            size=float(np.sqrt(square / size)) + self._height_size,
        )
        return state, Way(slope / size, slope_after / size)

    def precondition(self, state: State, *, dtype) -> Product:
        """Return M r for the residual r of `state`, in the precision `dtype`; one application of G^-1."""
        extension, values = self._extension(dtype)
        unsettled = self.kernels.remainder(
            state.pressure, state.separation, state.level, self.cap, values, extension.empty[0]
        )
        extension.complete()
        field, total, energy = self._apply(extension, values)
        return Product(field, total / max(unsettled, 1), unsettled, energy / values.size)

    def advance(self, state: State, product: Product, length: float, mean_pressure: float, out):
        """Return the pressure after a step, in the array `out`.

        That is p - length (M r - mean) on the unsettled points, held between 0 and the cap and scaled.
        """
        wanted, found = self._loads
        self.kernels.advance(
            state.pressure,
            state.separation,
            product.field,
            state.level,
            product.mean,
            length,
            self.cap,
            self._block,
            out,
            wanted,
            found,
        )
        # What holding the pressure at its bounds adds or takes away is made good nearby: a factor common to
        # all of the surface would be an error of long waves, which weigh most.
        share = np.divide(np.maximum(wanted, 0), found, out=np.zeros_like(found), where=found > 0)
        if self.cap < np.inf:
            self.kernels.rescale(out, share, self._block, self.cap)
            return scale_to_load(out, mean_pressure, cap=self.cap)
        share *= mean_pressure * out.size / float((share * found).sum())
        self.kernels.rescale(out, share, self._block, self.cap)
        return out

    def last_residual(self, dtype) -> tuple:
        """Return the residual of the last `precondition` in `dtype` and the map of its unsettled points."""
        extension, values = self._extension(np.dtype(dtype))
        return values, extension.empty[0] == 0

    def precondition_on(self, contact, residual):
        """Return M `residual`, shape (ny, nx), for a given contact set; the residual is zero outside it."""
        extension, _ = self._extension(residual.dtype)
        extension.empty[0][...] = ~contact
        extension.complete()
        return self.precondition_on_last_set(residual)

    def precondition_on_last_set(self, residual):
        """Return M `residual`, shape (ny, nx), for the set of the last preconditioning in its precision."""
        extension, _ = self._extension(residual.dtype)
        return self._apply(extension, residual)[0]

    def _apply(self, extension, residual) -> tuple:
        """Return M `residual`, its sum, and that of its product with the residual."""
        extended = self.halfspace.room(residual.dtype)
        extension.extend(residual, extended)
        field = self.halfspace.pressure(extended)
        return field, *extension.transpose(field, residual)

    def residual_norm(self, state: State, product: Product) -> float:
        """Return a bound of ||r||_{G^-1} for the residual that certifies `state`, its `product` given.

        The extended residual of `precondition` is held to what the certificate allows
        (`roughcontact.contact.certificate`). What that takes away is bounded by its mean square times the
        largest |q|/2; only where this is no small change is the held residual transformed itself.
        """
        extended = self.halfspace.room(product.field.dtype)
        norm_of_extended = np.sqrt(max(product.energy, 0.0))
        taken = self.kernels.hold(state.pressure, state.separation, state.level, self.cap, extended)
        taken = np.sqrt(taken / extended.size * self.halfspace.largest_stiffness)
        if taken <= SMALL_CHANGE * norm_of_extended:
            return norm_of_extended + taken
        return norm(extended, self.halfspace.pressure(extended))

    def heights_in(self, dtype):
        """Return the heights in the precision `dtype`, made once."""
        if dtype not in self._heights_in:
            self._heights_in[dtype] = self.heights.__array_namespace__().astype(self.heights, dtype)
        return self._heights_in[dtype]

    def _extension(self, dtype):
        if dtype not in self._extensions:
            like = self.halfspace.room(dtype)
            extension = Extension(like, self.halfspace.lengths, self.kernels)
            self._extensions[dtype] = extension, like.__array_namespace__().empty_like(like)
        return self._extensions[dtype]


def load_block(shape, lengths) -> tuple[int, int]:
    """Return the cells (by, bx) of the blocks over which a step keeps the load.

    About `BLOCK` cells along the finer axis, as far as the numbers of cells have factors, and square; lines
    far apart keep their loads each (`roughcontact.contact.extension.collapse`).
    """
    block = [1, 1]
    while max(block) < BLOCK:
        cells = [n // b for n, b in zip(shape, block, strict=True)]
        pitches = [length / n for length, n in zip(lengths, cells, strict=True)]
        factors = coarsening(pitches, cells)
        if factors == (1, 1):
            factors = collapse(pitches, cells)
        if factors == (1, 1):
            break
        block = [b * f for b, f in zip(block, factors, strict=True)]
    return block[0], block[1]
