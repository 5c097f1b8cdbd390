"""One grid of the problem: its operators, its passes over memory, and the workspace they need."""

from dataclasses import dataclass

import numpy as np

from roughcontact.choices import Influence
from roughcontact.contact.coarsening import ELONGATED, has_separate_lines, hierarchy, pitches_of, stencil
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
from roughcontact.elasticity.halfspace import HalfSpace
from roughcontact.kernels.arrays import SINGLE, Array, empty, in_precision, precision_of
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.protocol import Factors, Weights

# What the projection takes away is redistributed to the contact around, in several passes: at most so many,
# until the rest, as a share of the load, is so small that all of the contact may share it. Under a profile
# that is dear, because the displacement beside a line contact does not decay; in a cell so much longer than
# wide it hardly does so either.
MOST_PASSES, SMALL_REST = 12, 0.01
LONG, MOST_PASSES_OF_LONG, SMALL_REST_OF_LONG = 8.0, 50, 1e-3
MOST_PASSES_OF_PROFILES, SMALL_REST_OF_PROFILES = 100, 1e-5
MOST_SCALED = 2.0  # factor up to which the points below the cap make up for what is missing in the load
# Of the local stiffness, where it is foreseen which points lose their contact: those around give way, too.
YIELDING = 0.25
SMALL_CHANGE = 0.1  # of the residual's norm, that is simply added to it


@dataclass(frozen=True)
class Residual:
    """The residual r of a state, interpolated and transformed: half of the preconditioner.

    Attributes
    ----------
    spectrum : array
        of G^-1 P r. The next residual, and any application of the operator, overwrites it.
    precision : str
        of the spectrum.
    energy : float
        <r, M r>, a mean over the grid.
    active : int
        number of points in the active set, where r may differ from zero.
    certifies : bool
        whether r is the gap on all of the contact, so that its energy bounds the error.
    """

    spectrum: Array
    precision: str
    energy: float
    active: int
    certifies: bool


@dataclass(frozen=True)
class PreconditionedResidual:
    """M r, the preconditioned residual of a state, by which a step corrects the pressure.

    Attributes
    ----------
    field : array (ny, nx)
        zero at the inactive points. The next residual overwrites it.
    mean : float
        over the active set.
    """

    field: Array
    mean: float


class Grid:
    """The heights on one grid, dimensionless, with all that acts on them.

    A height counts as (height - `reference`) / `unit`: the map itself is neither changed nor copied.

    Parameters
    ----------
    heights : array (ny, nx)
        the map.
    lengths : (Ly, Lx)
        of the periodic cell.
    reference, unit : float
        what makes the heights dimensionless.
    cap : float
        largest pressure allowed (the hardness), or infinity.
    influence : {"sampled", "elements"}
        symbol of the operator (`roughcontact.elasticity.influence`).
    threads : int
        of transforms and passes.
    """

    def __init__(
        self,
        heights: Array,
        lengths: tuple[float, float],
        *,
        reference: float = 0.0,
        unit: float = 1.0,
        cap: float = np.inf,
        influence: Influence = "sampled",
        threads: int = 1,
    ):
        self.cap = cap
        self.shape = tuple(heights.shape)
        self.halfspace = HalfSpace(heights.shape, lengths, influence=influence, threads=threads, like=heights)
        self.kernels = kernels_for(heights, threads=threads)
        self._given, self._reference, self._unit = heights, reference, unit
        self._single: Array | None = None
        self._workspaces: dict[str, Workspace] = {}
        self._line_axis: int | None = None  # of the lines that are contacts of their own
        if has_separate_lines(hierarchy(heights.shape, lengths)):
            self._line_axis = 0 if lengths[0] / heights.shape[0] < lengths[1] / heights.shape[1] else 1
        pitches = [d for d, n in zip(pitches_of(self.shape, lengths), self.shape, strict=True) if n > 1]
        self._elongated = max(pitches) > ELONGATED * min(pitches)
        self._passes = MOST_PASSES, SMALL_REST
        if min(self.shape) == 1:
            self._passes = MOST_PASSES_OF_PROFILES, SMALL_REST_OF_PROFILES
        elif max(lengths) >= LONG * min(lengths):
            self._passes = MOST_PASSES_OF_LONG, SMALL_REST_OF_LONG
        single = self.heights_in(SINGLE)
        self._height_size = norm(single, single)

    def evaluate(
        self, pressure: Array, *, before: State | None = None, out: Array | None = None
    ) -> tuple[State, LineSearch]:
        """Return the state of a feasible `pressure`, and the energy on the line to it from `before`.

        Parameters
        ----------
        pressure : array (ny, nx)
            its precision is that of all.
        before : State, optional
            of equal load; without it nothing has changed.
        out : array (ny, nx), optional
            for the separation.

        Returns
        -------
        state : State
            by a fresh application of G.
        line : LineSearch
            from `before` to the state.
        """
        precision = precision_of(pressure)
        if precision == SINGLE:
            heights, reference, unit = self.heights_in(SINGLE), 0.0, 1.0
        else:
            self._single = None  # the copy is needed no more
            heights, reference, unit = self._given, self._reference, self._unit
        separation = self.halfspace.displacement(pressure, out=out)
        start = (
            (pressure, pressure, 0.0)
            if before is None
            else (before.pressure, before.separation, before.offset)
        )
        work, square, total, count, slope, slope_after = self.kernels.measure(
            separation, heights, reference, unit, *start, pressure, self.cap
        )
        size = pressure.size
        state = State(
            pressure=pressure,
            separation=separation,
            offset=total / count if count else contact_mean(pressure, separation, cap=self.cap),
            norm=float(np.sqrt(max(work, 0) / size)),
            size=float(np.sqrt(square / size)) + self._height_size,
        )
        return state, LineSearch(slope / size, slope_after / size)

    def residual(self, state: State, *, precision: str, predict: bool = False) -> Residual:
        """Return the residual of `state` in a precision: half of an application of G^-1.

        Parameters
        ----------
        state : State
            a feasible pressure and its separation.
        precision : str
            `SINGLE` or `DOUBLE`.
        predict : bool
            leave those points out of the active set that are foreseen to lose their contact: for a first
            guess, whose contact is too large. Not where pixels are far longer than wide, which a stencil of
            neighbours tells too little of.

        Returns
        -------
        Residual
            valid until the next one.
        """
        workspace = self._workspace_in(precision)
        active = self.kernels.masked_residual(
            state.pressure, state.separation, state.offset, self.cap, workspace.values
        )
        self._interpolate(workspace)
        predict = predict and not self._elongated
        if predict:
            weights, stiffness = self._local_stiffness()
            active = self.kernels.predict_active(
                state.pressure, workspace.field, weights, YIELDING * stiffness, self.cap, workspace.values
            )
            self._interpolate(workspace)
        spectrum, energy = self.halfspace.pressure_spectrum(workspace.field)
        return Residual(spectrum, precision, energy, active, certifies=not predict)

    def precondition(self, residual: Residual) -> PreconditionedResidual:
        """Return M r for the last `residual`: the other half of the application.

        Parameters
        ----------
        residual : Residual
            the last one.

        Returns
        -------
        PreconditionedResidual
        """
        workspace = self._workspace_in(residual.precision)
        self.halfspace.field_of(residual.spectrum, residual.precision, out=workspace.field)
        return PreconditionedResidual(workspace.field, self._restrict(workspace) / max(residual.active, 1))

    def advance(
        self,
        state: State,
        correction: PreconditionedResidual,
        length: float,
        mean_pressure: float,
        out: Array,
    ) -> Array:
        """Return the pressure after a step, in the array `out`.

        That is p - length (M r - mean) on the active set, projected onto [0, cap]. The load that the
        projection adds or takes away is redistributed to the contact beside it: P^T hands it on, until little
        is left (`roughcontact.contact.iteration`). Lines that are contacts of their own keep their loads.
        Where the cap leaves no such step, it is one along the projected gradient. The field of the correction
        is lost.

        Parameters
        ----------
        state : State
            where the step begins.
        correction : PreconditionedResidual
            M r of that state.
        length : float
            of the step.
        mean_pressure : float
            prescribed, dimensionless.
        out : array (ny, nx)
            is written.

        Returns
        -------
        array (ny, nx)
        """
        kernels, cap = self.kernels, self.cap
        workspace = self._workspace_in(precision_of(correction.field))
        interpolation, taken, values = workspace.interpolation, correction.field, workspace.values
        safe = 0.0
        if cap < np.inf:  # half the stiffness of the residual, <r, M r> / <r, r>, while both are there
            square = mean_product(values, values)
            safe = 0.5 * mean_product(values, taken) / square if square > 0 else 0.0
        kernels.advance(state.pressure, taken, correction.mean, length, cap, out, values)
        free = values  # the same array: no residual any more, but 1 between the bounds and 0 elsewhere
        line_loads = None if self._line_axis is None else self._line_sums(out) + self._line_sums(taken)
        total = 0.0
        most, small = self._passes
        for number in range(most):
            if number > 0:
                kernels.project(out, cap, taken, free)
            interpolation.set_active(free)
            scratch = self.halfspace.scratch(precision_of(taken))
            outside, total = interpolation.redistribute(taken, out, cap, scratch)
            if outside <= small * total:
                break
        if total <= 0:  # rounding has eaten a load far below the residual: stay, and leave it to safe steps
            return scale_to_load(state.pressure, mean_pressure, cap=cap, precision=precision_of(out))
        if cap == np.inf and line_loads is None:
            kernels.rescale(out, mean_pressure * out.size / total, cap)
            return out
        kernels.rescale(out, 1.0, cap)
        if line_loads is not None:
            self._restore_line_loads(out, line_loads)
        if cap < np.inf and not 1 / MOST_SCALED < scale_below_cap(out, mean_pressure, cap) < MOST_SCALED:
            # Too much or too little has come to the cap for the others to make up: the gap tells better which
            # points belong there, as in a step along the projected gradient.
            pressure, gap = (
                in_precision(a, precision_of(out), copy=False) for a in (state.pressure, state.gap)
            )
            out = project_to_load(pressure - safe * gap, mean_pressure, cap=cap)
        return scale_to_load(out, mean_pressure, cap=cap)

    def last_residual(self, precision: str) -> tuple[Array, Array]:
        """Return the last residual in a precision and the map of its active set.

        Parameters
        ----------
        precision : str
            `SINGLE` or `DOUBLE`.

        Returns
        -------
        residual : array (ny, nx)
        active : array (ny, nx) of bool
        """
        workspace = self._workspace_in(precision)
        return workspace.values, workspace.values != 0

    def precondition_on(self, contact: Array, residual: Array) -> Array:
        """Return M `residual`, shape (ny, nx), for a given contact set; the residual is zero outside it.

        Parameters
        ----------
        contact : array (ny, nx)
            not zero on the contact set.
        residual : array (ny, nx)
            zero outside it.

        Returns
        -------
        array (ny, nx)
        """
        interpolation = self._workspace_in(precision_of(residual)).interpolation
        interpolation.set_active(in_precision(contact, precision_of(residual)))
        return self.precondition_on_last_set(residual)

    def precondition_on_last_set(self, residual: Array) -> Array:
        """Return M `residual`, shape (ny, nx), for the active set of the last residual in its precision.

        Parameters
        ----------
        residual : array (ny, nx)
            zero outside the active set.

        Returns
        -------
        array (ny, nx)
        """
        workspace = self._workspace_in(precision_of(residual))
        workspace.interpolation.prolong(residual, workspace.field)
        self.halfspace.pressure(workspace.field, out=workspace.field)
        self._restrict(workspace)
        return workspace.field

    def residual_norm(self, state: State, residual: Residual) -> float:
        """Return a bound of ||r||_{G^-1} for the residual that certifies `state`, the last `residual` given.

        That is the interpolated residual, projected onto what the certificate allows
        (`roughcontact.contact.certificate`). What the projection takes away is bounded by its mean square
        times the largest |q|/2; only where this is no small change is the projected residual transformed
        itself. The residual cannot be preconditioned after that.

        Parameters
        ----------
        state : State
            a feasible pressure and its separation.
        residual : Residual
            of the state.

        Returns
        -------
        float
            dimensionless.
        """
        interpolated = self._workspace_in(residual.precision).field
        norm_of_interpolated = float(np.sqrt(residual.energy))
        squares = self.kernels.project_residual(
            state.pressure, state.separation, state.offset, self.cap, interpolated
        )
        change = float(np.sqrt(squares / interpolated.size * self.halfspace.largest_stiffness))
        if change <= SMALL_CHANGE * norm_of_interpolated:
            return norm_of_interpolated + change
        return float(np.sqrt(self.halfspace.pressure_spectrum(interpolated)[1]))

    def refine(self, coarse: Array, factors: Factors, out: Array) -> None:
        """Put the pressure `coarse` of the next coarser grid onto this one, in single precision, into `out`.

        Detail of the heights takes the pressure that it would take in full contact.

        Parameters
        ----------
        coarse : array
            pressure over the coarser grid's cells.
        factors : (int, int)
            fy and fx, to the coarser grid.
        out : array (ny, nx)
            is written.
        """
        weights, stiffness = self._local_stiffness()
        self.kernels.refine(coarse, factors, self.heights_in(SINGLE), weights, stiffness, self.cap, out)

    def heights_in(self, precision: str) -> Array:
        """Return the dimensionless heights in a precision; in single precision they are kept.

        Parameters
        ----------
        precision : str
            `SINGLE` or `DOUBLE`.

        Returns
        -------
        array (ny, nx)
        """
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

    def release(self) -> None:
        """Give the memory of all workspaces back; what is wanted again is made anew.

        The last residual and all arrays that were lent end with it.
        """
        self._single = None
        self._workspaces.clear()
        self.halfspace.release()

    def _local_stiffness(self) -> tuple[Weights, float]:
        """Return the stencil of neighbours, and the pressure over what a point stands out from their mean.

        Exactly so in full contact, for the shortest wave along the finer axis, whose wavenumber is pi/pitch.
        """
        pitches = pitches_of(self.shape, self.halfspace.lengths)
        weights = across_y, across_x, diagonal = stencil(pitches, self.shape)
        pitch, across = min(
            (d, w) for d, w, n in zip(pitches, (across_y, across_x), self.shape, strict=True) if n > 1
        )
        return weights, 0.5 * np.pi / pitch / (4 * across + 8 * diagonal)

    def _interpolate(self, workspace: "Workspace") -> None:
        """Put P of the workspace's values, zero at the inactive points, into its field."""
        workspace.interpolation.set_active(workspace.values)
        workspace.interpolation.prolong(workspace.values, workspace.field)

    def _restrict(self, workspace: "Workspace") -> float:
        """Put P^T of the workspace's field, zero at the inactive points, into it; return its sum."""
        field = workspace.field
        return workspace.interpolation.restrict(field, self.halfspace.scratch(precision_of(field)))

    def _restore_line_loads(self, pressure: Array, line_loads: Array) -> None:
        """Scale every line of `pressure` to the load that it had; points at the cap stay there."""
        xp = pressure.__array_namespace__()
        free = xp.where(pressure < self.cap, pressure, xp.zeros_like(pressure))
        found, at_cap = self._line_sums(free), self._line_sums(pressure - free)
        factor = xp.clip(line_loads - at_cap, 0, None) / xp.where(found > 0, found, xp.ones_like(found))
        if float(xp.sum(factor * found)) > 0:
            pressure += free * xp.astype(factor - 1, pressure.dtype)

    def _line_sums(self, field: Array) -> Array:
        """Return the sums, in double precision, over the lines that are contacts of their own."""
        xp = field.__array_namespace__()
        return xp.sum(field, axis=self._line_axis, keepdims=True, dtype=xp.float64)

    def _workspace_in(self, precision: str) -> "Workspace":
        if precision not in self._workspaces:
            like = self._given
            interpolation = Interpolation(like, precision, self.halfspace.lengths, self.kernels)
            self._workspaces[precision] = Workspace(
                interpolation, *(empty(like, precision) for _ in range(2))
            )
        return self._workspaces[precision]


@dataclass(frozen=True)
class Workspace:
    """What an application of M = P^T G^-1 P works in: P, the residual, and M of it."""

    interpolation: Interpolation
    values: Array
    field: Array
