"""One grid of the problem: its operators, its passes over memory, and the room they need."""

from dataclasses import dataclass

import numpy as np

from roughcontact.contact.interpolation import Extension, lines_apart, pyramid
from roughcontact.contact.state import State, Way, contact_mean, norm, scale_to_load
from roughcontact.elasticity.halfspace import HalfSpace
from roughcontact.kernels.arrays import SINGLE, empty, in_precision, precision_of
from roughcontact.kernels.choose import kernels_for

MOST_PASSES = 5  # in which what holding the pressure takes away is given to the contact around
SMALL_REST = 0.05  # of the load, that the last pass may leave to be shared by all of the contact
SMALL_CHANGE = 0.1  # of the residual's norm, that is simply added to it


@dataclass(frozen=True)
class Residual:
    """The residual r of a state, extended: the `spectrum` of G^-1 W r in a `precision`.

    `energy` = <r, M r>, a mean over the grid; `unsettled` counts the points where r may differ from zero. The
    next residual, and any application of the operator, overwrites the spectrum.
    """

    spectrum: np.ndarray
    precision: str
    energy: float
    unsettled: int


@dataclass(frozen=True)
class Product:
    """M r, the preconditioned residual of a state: `field` (ny, nx) zero at the settled points.

    `mean` is that over the unsettled points. The next residual overwrites the field.
    """

    field: np.ndarray
    mean: float


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
        self._along = None  # the axis of the lines that are contacts of their own
        if lines_apart(pyramid(self.shape, lengths)):
            self._along = 0 if lengths[0] / self.shape[0] < lengths[1] / self.shape[1] else 1
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

    def residual(self, state: State, *, precision: str) -> Residual:
        """Return the residual of `state` in a precision: half of an application of G^-1."""
        rooms = self._rooms_in(precision)
        unsettled = self.kernels.remainder(
            state.pressure, state.separation, state.level, self.cap, rooms.values
        )
        rooms.extension.choose(rooms.values)
        rooms.extension.extend(rooms.values, rooms.field)
        spectrum, energy = self.halfspace.pressure_spectrum(rooms.field)
        return Residual(spectrum, precision, energy, unsettled)

    def precondition(self, residual: Residual) -> Product:
        """Return M r for the last `residual`: the other half of the application."""
        rooms = self._rooms_in(residual.precision)
        self.halfspace.field_of(residual.spectrum, residual.precision, out=rooms.field)
        return Product(rooms.field, self._transpose(rooms) / max(residual.unsettled, 1))

    def advance(self, state: State, product: Product, length: float, mean_pressure: float, out):
        """Return the pressure after a step, in the array `out`.

        That is p - length (M r - mean) on the unsettled points, held between 0 and the cap. The load that
        holding adds or takes away is taken over by the contact beside it: W^T hands it on, until little is
        left (`roughcontact.contact.iteration`). Lines that are contacts of their own keep their loads. The
        field of the product is lost.
        """
        kernels, rooms, cap = self.kernels, self._rooms_in(precision_of(product.field)), self.cap
        taken, free = product.field, rooms.values
        known = state.pressure, state.separation, product.field, state.level, product.mean
        kernels.advance(*known, length, cap, out, free)
        line_loads = None if self._along is None else self._line_sums(out) + self._line_sums(taken)
        for number in range(MOST_PASSES):
            if number > 0:
                kernels.bound(out, cap, taken, free)
            rooms.extension.choose(free)
            scratch = self.halfspace.scratch(precision_of(taken))
            outside, total = rooms.extension.give(taken, out, cap, scratch)
            if outside <= SMALL_REST * total:
                break
        if total <= 0:  # rounding has eaten a load far below the residual: stay, and leave it to safe steps
            out[...] = in_precision(state.pressure, precision_of(out), copy=False)
            return scale_to_load(out, mean_pressure, cap=cap)
        if cap == np.inf and line_loads is None:
            kernels.rescale(out, mean_pressure * out.size / total, cap)
            return out
        kernels.rescale(out, 1.0, cap)
        if line_loads is not None:
            xp = out.__array_namespace__()
            found = self._line_sums(out)
            factor = xp.clip(line_loads, 0, None) / xp.where(found > 0, found, xp.ones_like(found))
            if float(xp.sum(factor * found)) > 0:
                out *= xp.astype(factor, out.dtype)
        return scale_to_load(out, mean_pressure, cap=cap)

    def _line_sums(self, field):
        """Return the sums, in double precision, over the lines that are contacts of their own."""
        xp = field.__array_namespace__()
        return xp.sum(field, axis=self._along, keepdims=True, dtype=xp.float64)

    def last_residual(self, precision: str) -> tuple:
        """Return the last residual in a precision and the map of unsettled points."""
        rooms = self._rooms_in(precision)
        return rooms.values, rooms.values != 0

    def precondition_on(self, contact, residual):
        """Return M `residual`, shape (ny, nx), for a given contact set; the residual is zero outside it."""
        extension = self._rooms_in(precision_of(residual)).extension
        extension.choose(in_precision(contact, precision_of(residual)))
        return self.precondition_on_last_set(residual)

    def precondition_on_last_set(self, residual):
        """Return M `residual`, shape (ny, nx), for the set of the last residual in its precision."""
        rooms = self._rooms_in(precision_of(residual))
        rooms.extension.extend(residual, rooms.field)
        self.halfspace.pressure(rooms.field, out=rooms.field)
        self._transpose(rooms)
        return rooms.field

    def _transpose(self, rooms) -> float:
        """Put W^T of the rooms' field, zero at the settled points, into it; return its sum."""
        return rooms.extension.transpose(rooms.field, self.halfspace.scratch(precision_of(rooms.field)))

    def residual_norm(self, state: State, residual: Residual) -> float:
        """Return a bound of ||r||_{G^-1} for the residual that certifies `state`, the last `residual` given.

        That is the extended residual, held to what the certificate allows
        (`roughcontact.contact.certificate`). What holding takes away is bounded by its mean square times the
        largest |q|/2; only where this is no small change is the held residual transformed itself. The
        residual cannot be preconditioned after that.
        """
        extended = self._rooms_in(residual.precision).field
        norm_of_extended = np.sqrt(residual.energy)
        taken = self.kernels.hold(state.pressure, state.separation, state.level, self.cap, extended)
        taken = np.sqrt(taken / extended.size * self.halfspace.largest_stiffness)
        if taken <= SMALL_CHANGE * norm_of_extended:
            return norm_of_extended + taken
        return np.sqrt(self.halfspace.pressure_spectrum(extended)[1])

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
