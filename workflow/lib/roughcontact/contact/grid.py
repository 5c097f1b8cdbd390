"""One grid of the problem: its operators, its passes over memory, and the workspace they need."""

from dataclasses import dataclass

import numpy as np

from roughcontact.contact.coarsening import ELONGATED, grid_pitches, has_separate_lines, hierarchy, stencil
from roughcontact.contact.elasticity.halfspace import HalfSpace
from roughcontact.contact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.contact.interpolation import Interpolation
from roughcontact.contact.line_search import LineSearch
from roughcontact.contact.state import (
    State,
    contact_mean,
    mean_product,
    norm,
    project_to_load,
    scale_below_cap,
    scale_to_load,
)
from roughcontact.kernels.array_api import CLOSED
from roughcontact.kernels.arrays import (
    SINGLE,
    Array,
    as_precision,
    empty,
    get_precision,
    n_elements,
    namespace,
)
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.protocol import Factors, Heights, Weights

# The load that the projection removes is redistributed to the contact around it, in up to so many passes,
# until the rest, as a share of the load, is small enough to be shared by all of the contact. Profiles need
# many passes, because the displacement beside a line contact does not decay, and so do cells far longer than
# wide, where it hardly decays.
MAX_PASSES, SMALL_REST = 12, 0.01
LONG, MAX_PASSES_OF_LONG, SMALL_REST_OF_LONG = 8.0, 50, 1e-3
MAX_PASSES_OF_PROFILES, SMALL_REST_OF_PROFILES = 100, 1e-5
MAX_SCALING = 2.0  # factor up to which the points below the cap make up for missing load
# Share of the local stiffness that predicts which points lose their contact: those around them yield, too.
STIFFNESS_SHARE = 0.25
SMALL_CHANGE = 0.1  # of the residual's norm; smaller changes are added to it


@dataclass(frozen=True)
class Residual:
    """The residual r of a state, interpolated and transformed: half of the preconditioner."""

    spectrum: Array  # of G^-1 P r, overwritten by any application of the operator
    precision: str
    energy: float  # <r, M r>, a mean over the grid
    certifies: bool  # r is the gap on all of the contact, so that its energy bounds the error


@dataclass(frozen=True)
class PreconditionedResidual:
    """M r (ny, nx), by which a step corrects the pressure: `field` + `passed` + the distributed `coarse`."""

    field: Array
    passed: Array
    coarse: Array
    mean: float  # over the active set
    energy: float  # <r, M r>


class Grid:
    """The heights (ny, nx) on one grid, dimensionless, with the operators and passes that act on them.

    A height counts as (height - `reference`) / `unit`, without a copy; `lengths` of the periodic cell and the
    thicknesses of layers share a unit; `cap` is the hardness, the largest pressure allowed, or infinity.
    """

    def __init__(
        self,
        heights: Array,
        lengths: tuple[float, float],
        elasticity: Elasticity = HALF_SPACE,
        *,
        reference: float = 0.0,
        unit: float = 1.0,
        threads: int = 1,
    ):
        self.cap = elasticity.hardness
        self.shape = tuple(heights.shape)
        self.halfspace = HalfSpace(heights.shape, lengths, elasticity, threads=threads, like=heights)
        self.kernels = kernels_for(heights, threads=threads)
        self._given, self._reference, self._unit = heights, reference, unit
        self._single: Array | None = None
        self._interpolations: dict[str, Interpolation] = {}
        self._line_axis: int | None = None  # of the lines that are contacts of their own
        if has_separate_lines(hierarchy(heights.shape, lengths)):
            self._line_axis = 0 if lengths[0] / heights.shape[0] < lengths[1] / heights.shape[1] else 1
        pitches = [d for d, n in zip(grid_pitches(self.shape, lengths), self.shape, strict=True) if n > 1]
        self._elongated = max(pitches) > ELONGATED * min(pitches)
        self._passes = MAX_PASSES, SMALL_REST
        if min(self.shape) == 1:
            self._passes = MAX_PASSES_OF_PROFILES, SMALL_REST_OF_PROFILES
        elif max(lengths) >= LONG * min(lengths):
            self._passes = MAX_PASSES_OF_LONG, SMALL_REST_OF_LONG
        single = self.rounded_heights(SINGLE)
        self._height_size = norm(single, single)  # a part of the scale of rounding (`State.size`)

    def evaluate(
        self, pressure: Array, *, former: State | None = None, out: Array | None = None
    ) -> tuple[State, LineSearch]:
        """Return the state of a feasible `pressure` by a fresh application of G, and the line search to it.

        `former` has the same load (None: the pressure is unchanged); `out` (ny, nx) receives the separation.
        """
        precision = get_precision(pressure)
        if precision == SINGLE:
            heights: Heights = self.rounded_heights(SINGLE), 0.0, 1.0
        else:
            self._single = None  # the copy is no longer needed
            heights = self._given, self._reference, self._unit
        separation = self.halfspace.displacement(pressure, out=out)
        before = pressure, pressure, 0.0  # without a former state the line to this one has no length
        if former is not None:
            before = former.pressure, former.separation, former.offset
        work, square, total, count, slope, slope_after = self.kernels.measure(
            separation, heights, before, pressure, self.cap
        )
        size = n_elements(pressure)
        state = State(
            pressure=pressure,
            separation=separation,
            offset=total / count if count else contact_mean(pressure, separation, cap=self.cap),
            norm=float(np.sqrt(max(work, 0) / size)),  # rounding may turn a small energy negative
            size=float(np.sqrt(square / size)) + self._height_size,
            free_share=1.0 if self.cap == np.inf else max(count, 1) / size,
        )
        return state, LineSearch(slope / size, slope_after / size)

    def residual(self, state: State, *, precision: str, predict: bool = False) -> Residual:
        """Return the residual of `state` in a precision, valid until the next: half an application of G^-1.

        `predict` leaves out points that are predicted to lose contact: for a first guess, whose contact is
        too large.
        """
        interpolation = self.interpolator(precision)
        values, field = interpolation.values, interpolation.field
        cells = interpolation.factors, interpolation.share, interpolation.cell_means
        self.kernels.masked_residual(state.pressure, state.separation, state.offset, self.cap, values, cells)
        if interpolation.bends:
            self._foresee_violations(state, interpolation)
        interpolation.interpolate(share_known=not interpolation.bends)
        # a stencil of neighbours predicts too little where pixels are far longer than wide
        predict = predict and not self._elongated
        if predict:
            weights, stiffness = self._local_stiffness()
            self.kernels.predict_active(
                state.pressure, field, weights, STIFFNESS_SHARE * stiffness, self.cap, values, cells
            )
            interpolation.interpolate(share_known=True)
        spectrum, energy = self.halfspace.pressure_spectrum(field)
        return Residual(spectrum, precision, energy, certifies=not predict)

    def precondition(self, residual: Residual) -> PreconditionedResidual:
        """Return M r for the last `residual`: the other half of the application."""
        interpolation = self.interpolator(residual.precision)
        field, scratch = interpolation.field, self.halfspace.scratch(residual.precision)
        self.halfspace.spectrum_to_field(residual.spectrum, residual.precision, out=field)
        if self._line_axis is None:
            # P keeps a constant, so that the sum of P^T is that of the field, whose mean is zero
            coarse, mean = interpolation.restricted_to_coarse(field, scratch), 0.0
        else:
            active = int(namespace(field).count_nonzero(interpolation.values))
            mean = interpolation.restrict(field, scratch) / max(active, 1)
            coarse = interpolation.share
            coarse[...], scratch[...] = 0, 0
        return PreconditionedResidual(field, scratch, coarse, mean, residual.energy)

    def advance(
        self,
        state: State,
        correction: PreconditionedResidual,
        length: float,
        mean_pressure: float,
        out: Array,
    ) -> Array:
        """Return [p - length (M r - mean)], projected onto [0, cap] with its load kept, in `out`.

        The load that the projection changes goes to the contact beside it by P^T, until little is left; lines
        that are contacts of their own keep their loads. Where the cap prevents such a step, it is one along
        the projected gradient. The field of the correction is overwritten.
        """
        kernels, cap = self.kernels, self.cap
        interpolation, removed_load = self.interpolator(get_precision(correction.field)), correction.field
        values = interpolation.values
        safe = 0.0
        if cap < np.inf:  # half the stiffness of the residual, <r, M r> / <r, r>, while that is there
            square = mean_product(values, values)
            safe = 0.5 * correction.energy / square if square > 0 else 0.0
        cells = interpolation.factors, interpolation.share
        kernels.advance(
            *(state.pressure, removed_load, correction.passed, correction.coarse, interpolation.factors),
            *(correction.mean, length, cap, out, values, interpolation.share),
        )
        free = values  # the same array: no longer a residual, but 1 between the bounds and 0 elsewhere
        line_loads = None if self._line_axis is None else self._line_sums(out) + self._line_sums(removed_load)
        total = 0.0
        max_passes, small_share = self._passes
        for number in range(max_passes):
            if number > 0:
                kernels.project(out, cap, removed_load, free, *cells)  # the pass above has projected once
            interpolation.set_active(free, share_known=True)
            scratch = self.halfspace.scratch(get_precision(removed_load))
            outside, total = interpolation.redistribute(removed_load, out, cap, scratch)
            if outside <= small_share * total:
                break
        if total <= 0:  # a load far below the residual was lost to rounding: stay, safe steps follow
            return scale_to_load(state.pressure, mean_pressure, cap=cap, precision=get_precision(out))
        if cap == np.inf and line_loads is None:
            kernels.rescale(out, mean_pressure * n_elements(out) / total, cap)
            return out
        kernels.rescale(out, 1.0, cap)
        if line_loads is not None:
            self._restore_line_loads(out, line_loads)
        if cap < np.inf and not 1 / MAX_SCALING < scale_below_cap(out, mean_pressure, cap) < MAX_SCALING:
            # Too many or too few points are at the cap for the others to make up: the gap is a better guide
            # to those that belong there, as in a step along the projected gradient.
            pressure, gap = (
                as_precision(a, get_precision(out), copy=False) for a in (state.pressure, state.gap)
            )
            out = project_to_load(pressure - safe * gap, mean_pressure, cap=cap)
        return scale_to_load(out, mean_pressure, cap=cap)

    def precondition_on(self, contact: Array | None, residual: Array) -> Array:
        """Return M `residual`, zero outside the set where `contact` is not zero; None: the last set."""
        interpolation = self.interpolator(get_precision(residual))
        field = interpolation.field
        if contact is not None:
            interpolation.set_active(as_precision(contact, get_precision(residual)))
        interpolation.prolong(residual, field)
        self.halfspace.pressure(field, out=field)
        interpolation.restrict(field, self.halfspace.scratch(get_precision(field)))
        return field

    def residual_norm(self, state: State, residual: Residual) -> float:
        """Return a bound of ||r||_{G^-1} for the residual that certifies `state`, overwritten by it.

        It is that of the interpolated residual, projected onto those that the certificate admits.
        """
        field = self.interpolator(residual.precision).field
        norm_of_interpolated = float(np.sqrt(residual.energy))
        squares = self.kernels.project_residual(
            state.pressure, state.separation, state.offset, self.cap, field
        )
        # bounded by the mean square times the largest |q|/2; only where that is large the projected residual
        # is transformed
        change = float(np.sqrt(squares / n_elements(field) * self.halfspace.largest_stiffness))
        if change <= SMALL_CHANGE * norm_of_interpolated:
            return norm_of_interpolated + change
        return float(np.sqrt(self.halfspace.pressure_spectrum(field)[1]))

    def refine(self, coarse: Array, factors: Factors, out: Array) -> None:
        """Write the pressure `coarse` of the next coarser grid, refined to this one, to `out`.

        `out` is in single precision. Fine detail of the heights is added with the pressure that it would have
        in full contact.
        """
        weights, stiffness = self._local_stiffness()
        self.kernels.refine(coarse, factors, self.rounded_heights(SINGLE), weights, stiffness, self.cap, out)

    def rounded_heights(self, precision: str) -> Array:
        """Return the dimensionless heights in a precision; in single precision they are kept."""
        if precision == SINGLE and self._single is not None:
            return self._single
        if self._reference == 0 and self._unit == 1:
            heights = as_precision(self._given, precision, copy=False)
        else:
            heights = empty(self._given, precision)
            self.kernels.make_dimensionless(self._given, self._reference, self._unit, heights)
        if precision == SINGLE:
            self._single = heights
        return heights

    def release(self) -> None:
        """Release the memory of all workspaces; they are allocated again on demand.

        The last residual and all arrays in these workspaces become invalid.
        """
        self._single = None
        self._interpolations.clear()
        self.halfspace.release()

    def _local_stiffness(self) -> tuple[Weights, float]:
        """Return the stencil of neighbours, and the pressure per height of a point above their mean.

        It is exact in full contact, for the shortest wave along the finer axis, whose wavenumber is pi/pitch.
        """
        pitches = grid_pitches(self.shape, self.halfspace.lengths)
        weights = across_y, across_x, diagonal = stencil(pitches, self.shape)
        pitch, across = min(
            (d, w) for d, w, n in zip(pitches, (across_y, across_x), self.shape, strict=True) if n > 1
        )
        # a single point is for the most part the shortest wave of the grid
        factor = float(self.halfspace.elasticity.medium.factor(np.array([np.pi / pitch]))[0])
        return weights, 0.5 * np.pi / pitch / (4 * across + 8 * diagonal) / factor

    def _foresee_violations(self, state: State, interpolation: Interpolation) -> None:
        """Put the points of a bound into the active set that a correction makes violate it."""
        values, no_load, at_cap = interpolation.values, state.pressure <= 0, state.pressure >= self.cap
        xp = namespace(values)
        values[...] = xp.where(no_load | at_cap, xp.zeros_like(values), values)
        interpolation.interpolate(share_known=False)
        gap = as_precision(state.gap, get_precision(values), copy=False)
        gap = xp.where(gap == 0, xp.full_like(gap, CLOSED), gap)
        # a stiff film a little too low overlaps far and wide, and lifts off: points without pressure that
        # will overlap, points at the cap whose gap will open
        foreseen = (no_load & (gap < interpolation.field)) | (at_cap & (gap > interpolation.field))
        values[...] = xp.where(foreseen, gap, values)

    def _restore_line_loads(self, pressure: Array, line_loads: Array) -> None:
        """Scale every line of `pressure` to the load that it had; points at the cap stay there."""
        xp = namespace(pressure)
        free = xp.where(pressure < self.cap, pressure, xp.zeros_like(pressure))
        free_load, at_cap = self._line_sums(free), self._line_sums(pressure - free)
        factor = xp.clip(line_loads - at_cap, 0, None) / xp.where(
            free_load > 0, free_load, xp.ones_like(free_load)
        )
        if float(xp.sum(factor * free_load)) > 0:  # all at the cap, or no load: there is nothing to scale
            pressure += free * xp.astype(factor - 1, pressure.dtype)

    def _line_sums(self, field: Array) -> Array:
        """Return the sums, in double precision, over the lines that are contacts of their own."""
        xp = namespace(field)
        return xp.sum(field, axis=self._line_axis, keepdims=True, dtype=xp.float64)

    def interpolator(self, precision: str) -> Interpolation:
        """Return the interpolation in a precision, with its workspace."""
        if precision not in self._interpolations:
            self._interpolations[precision] = Interpolation(
                self._given, precision, self.halfspace.lengths, self.kernels, self.halfspace.elasticity.medium
            )
        return self._interpolations[precision]
