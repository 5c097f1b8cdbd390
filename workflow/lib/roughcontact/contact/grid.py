"""One grid of the problem: its operators, its passes over memory, and the room they need."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from roughcontact.contact.extension import Extension, coarsening, collapse, pitches_of
from roughcontact.contact.state import State, Way, contact_mean, norm, scale_to_load
from roughcontact.halfspace import HalfSpace
from roughcontact.kernels import DOUBLE, SINGLE, empty, in_precision, kernels_for, precision_of

BLOCK = 16  # cells along the finer axis over which a step keeps the load
SMALL_CHANGE = 0.1  # of the residual's norm, that is simply added to it


@dataclass(frozen=True)
class Product:
    """M r, the preconditioned residual of a state: `field` (ny, nx) zero at the settled points.

    `mean` is that over the `unsettled` points; `energy` = <r, M r>, a mean over the grid. The next
    preconditioning overwrites the field.
    """

    field: np.ndarray
    mean: float
    unsettled: int
    energy: float


class Grid:
    """The heights (ny, nx) on a cell of `lengths` = (Ly, Lx), dimensionless, with all that acts on them.

    A height counts as (height - `reference`) / `unit`: the map itself is neither changed nor copied. `cap` is
    the largest pressure allowed (the hardness), or infinity.
    """

    def __init__(
        self,
        heights,
        lengths,
        *,
        reference: float = 0.0,
        unit: float = 1.0,
        cap: float = np.inf,
        influence: str = "sampled",
        threads: int = 1,
    ):
        self.cap = cap
        self.shape = tuple(heights.shape)
        self.halfspace = HalfSpace(heights.shape, lengths, influence=influence, threads=threads, like=heights)
        self.kernels = kernels_for(heights, threads=threads)
        self._given, self._reference, self._unit = heights, reference, unit
        self._single = None
        self._rooms = {}
        self._block = load_block(self.shape, lengths)
        blocks = tuple(n // b for n, b in zip(heights.shape, self._block, strict=True))
        self._loads = empty(heights, DOUBLE, blocks), empty(heights, DOUBLE, blocks)
        single = self.heights_in(SINGLE)
        self._height_size = norm(single, single)

    def evaluate(self, pressure, *, before: State | None = None, room=None) -> tuple[State, Way]:
        """Return the state of a feasible `pressure` by a fresh application of G, and the way from `before`.

        All in the precision of `pressure`; `room` is an array for the separation.
        """
        precision = precision_of(pressure)
        if precision == SINGLE:
            heights = self.heights_in(SINGLE), 0.0, 1.0
        else:
            self._single = None  # the copy is needed no more
            heights = self._given, self._reference, self._unit
        separation = self.halfspace.displacement(pressure, out=room)
        # without a state before, nothing has changed
        start = (
            (pressure, pressure, 0.0)
            if before is None
            else (before.pressure, before.separation, before.level)
        )
        work, square, total, count, slope, slope_after = self.kernels.measure(
            separation, *heights, *start, pressure, self.cap
        )
        size = pressure.size
        state = State(
            pressure=pressure,
            separation=separation,
            level=total / count if count else contact_mean(pressure, separation, cap=self.cap),
            norm=float(np.sqrt(max(work, 0) / size)),
            size=float(np.sqrt(square / size)) + self._height_size,
        )
        return state, Way(slope / size, slope_after / size)

    def precondition(self, state: State, *, precision: str) -> Product:
        """Return M r for the residual r of `state`, in a precision; one application of G^-1."""
        rooms = self._rooms_in(precision)
        unsettled = self.kernels.remainder(
            state.pressure, state.separation, state.level, self.cap, rooms.values
        )
        rooms.extension.choose(rooms.values)
        total, energy = self._apply(rooms, rooms.values)
        return Product(rooms.field, total / max(unsettled, 1), unsettled, energy / rooms.values.size)

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
        xp = found.__array_namespace__()
        share = xp.clip(wanted, 0, None) / xp.where(found > 0, found, xp.ones_like(found))
        share = xp.where(found > 0, share, xp.zeros_like(found))
        if self.cap < np.inf:
            self.kernels.rescale(out, share, self._block, self.cap)
            return scale_to_load(out, mean_pressure, cap=self.cap)
        share *= mean_pressure * out.size / float(xp.sum(share * found))
        self.kernels.rescale(out, share, self._block, self.cap)
        return out

    def last_residual(self, precision: str) -> tuple:
        """Return the residual of the last `precondition` in a precision and the map of unsettled points."""
        rooms = self._rooms_in(precision)
        return rooms.values, rooms.values != 0

    def precondition_on(self, contact, residual):
        """Return M `residual`, shape (ny, nx), for a given contact set; the residual is zero outside it."""
        extension = self._rooms_in(precision_of(residual)).extension
        extension.choose(in_precision(contact, precision_of(residual)))
        return self.precondition_on_last_set(residual)

    def precondition_on_last_set(self, residual):
        """Return M `residual`, shape (ny, nx), for the set of the last preconditioning in its precision."""
        rooms = self._rooms_in(precision_of(residual))
        self._apply(rooms, residual)
        return rooms.field

    def _apply(self, rooms, residual) -> tuple[float, float]:
        """Put M `residual` into the rooms' field; return the sums of it and of it times the residual."""
        rooms.extension.extend(residual, rooms.field)
        self.halfspace.pressure(rooms.field, out=rooms.field)
        scratch = self.halfspace.scratch(precision_of(residual))
        return rooms.extension.transpose(rooms.field, residual, scratch)

    def residual_norm(self, state: State, product: Product) -> float:
        """Return a bound of ||r||_{G^-1} for the residual that certifies `state`, its `product` given.

        The extended residual of `precondition` is held to what the certificate allows
        (`roughcontact.contact.certificate`). What that takes away is bounded by its mean square times the
        largest |q|/2; only where this is no small change is the held residual transformed itself. The
        field of the product is lost.
        """
        rooms = self._rooms_in(precision_of(product.field))
        extended = rooms.field
        rooms.extension.extend(rooms.values, extended)
        norm_of_extended = np.sqrt(max(product.energy, 0.0))
        taken = self.kernels.hold(state.pressure, state.separation, state.level, self.cap, extended)
        taken = np.sqrt(taken / extended.size * self.halfspace.largest_stiffness)
        if taken <= SMALL_CHANGE * norm_of_extended:
            return norm_of_extended + taken
        return norm(extended, self.halfspace.pressure(extended))

    def heights_in(self, precision: str):
        """Return the dimensionless heights in a precision; in single precision they are kept."""
        if precision == SINGLE and self._single is not None:
            return self._single
        if self._reference == 0 and self._unit == 1:
            heights = in_precision(self._given, precision, copy=False)
        else:
            heights = empty(self._given, precision)
            self.kernels.make_dimensionless(self._given, self._reference, self._unit, heights)
        if precision == SINGLE:
            self._single = heights
        return heights

    def _rooms_in(self, precision):
        if precision not in self._rooms:
            like = self._given
            extension = Extension(like, precision, self.halfspace.lengths, self.kernels)
            self._rooms[precision] = Rooms(extension, *(empty(like, precision) for _ in range(2)))
        return self._rooms[precision]


@dataclass(frozen=True)
class Rooms:
    """What an application of M = W^T G^-1 W works in: W, the residual, and M of it."""

    extension: Extension
    values: np.ndarray
    field: np.ndarray


@lru_cache(maxsize=64)
def load_block(shape, lengths) -> tuple[int, int]:
    """Return the cells (by, bx) of the blocks over which a step keeps the load.

    About `BLOCK` cells along the finer axis, as far as the numbers of cells have factors, and square; lines
    far apart keep their loads each (`roughcontact.contact.extension.collapse`).
    """
    block = [1, 1]
    while max(block) < BLOCK:
        cells = [n // b for n, b in zip(shape, block, strict=True)]
        pitches = pitches_of(cells, lengths)
        factors = coarsening(pitches, cells)
        if factors == (1, 1):
            factors = collapse(pitches, cells)
        if factors == (1, 1):
            break
        block = [b * f for b, f in zip(block, factors, strict=True)]
    return block[0], block[1]
