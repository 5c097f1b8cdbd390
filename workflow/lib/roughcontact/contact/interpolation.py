"""Interpolation (prolongation) P of a residual from the active set C to the whole grid, and its transpose.

The operator restricted to C has the exact inverse: continue the residual with the least elastic energy, apply
G^-1, keep the values on C (the Schur complement). P approximates that by a V-cycle on a hierarchy of grids
(Briggs, Henson and McCormick 2000, A Multigrid Tutorial, chapter 3): an empty cell takes the mean of its
eight neighbours, weighted by the inverse cube of the distance, the decay of G^-1, and by the linear size of
the contact in each. P^T G^-1 P was measured to be at most 1.15 times the exact inverse, three times it where
pixels are far longer than wide.

With layers of the factor f at the size of a cell, 1/weight - 1 is divided by f, two springs in series;
without that the iterations took up to seven times as many transforms. On grids whose cells bend, under a film
far stiffer than its base, sweeps smooth the kinks, which made P^T G^-1 P up to 4.5 times the inverse: to
twice.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from roughcontact.contact.coarsening import grid_pitches, has_separate_lines, hierarchy, stencil
from roughcontact.contact.elasticity.medium import HALF_SPACES, Medium
from roughcontact.kernels.arrays import Array, empty, namespace
from roughcontact.kernels.protocol import Arrangement, Cells, Factors, Weights

# Wavenumbers, over the inverse pitch of a cell, whose factor counts for it where the base makes the surface
# stiffer, and where it makes it softer than its own material is
STIFFER, SOFTER = 0.4, 1.0
# Power of |q| in the stiffness above which cells bend (1: half-space, 4: plate), and the sweeps that smooth
# them. Below 1.6 films of five times the modulus of their base take more transforms, from 2 on stiffer ones
STEEP, SWEEPS = 1.6, 3
MAX_SCATTERED = 32  # cells along an axis; in cells so large the contacts of rough surfaces are far apart


@dataclass
class CoarseGrid:
    """One coarser grid of the hierarchy, with fields of its cells."""

    factors: Factors  # (fy, fx), from the next finer grid
    arrangement: Arrangement  # of the contacts in its cells
    weights: Weights
    # the next four lie in one memory with those of the other grids
    empty: Array  # share of a cell that counts as gap
    gain: Array  # weight of a cell over the mean weight of its parts
    cell_means: Array
    work: Array
    line_gain: Array | None  # mean over the contact of a line over that of the line
    spares: Sequence[Array] = ()


class Interpolation:
    """The linear map P from fields (ny, nx) that are zero outside the active set C to the whole grid.

    The rows of P on C are those of the identity; the `medium` is in the unit of the `lengths` (Ly, Lx) of the
    periodic cell. `values` and `field` are workspace for a field and P of it.
    """

    def __init__(
        self,
        like: Array,
        precision: str,
        lengths: tuple[float, float],
        kernels: Any,  # of `kernels_for`
        medium: Medium = HALF_SPACES,
    ):
        self.kernels, xp = kernels, namespace(like)
        self.values, self.field = (empty(like, precision) for _ in range(2))
        self.active: Array = None
        pitches = grid_pitches(like.shape, lengths)
        self.weights = stencil(pitches, like.shape)
        plan = hierarchy(like.shape, lengths)
        bounds = np.cumsum([0, *(int(np.prod(coarser.shape)) for coarser in plan)]).tolist()
        # the grids lie one after the other, so that all the small ones can be passed in one call
        stores = [empty(like, precision, (bounds[-1],)) for _ in range(4)]
        self.grids = []
        for coarser, (start, stop) in zip(plan, pairwise(bounds), strict=True):
            gaps, gain, means, work = (xp.reshape(store[start:stop], coarser.shape) for store in stores)
            line_gain = empty(like, precision, coarser.shape) if coarser.collapses_lines else None
            arrangement, weights = _arrangement(coarser.shape), stencil(coarser.pitches, coarser.shape)
            fields = gaps, gain, means, work, line_gain
            self.grids.append(CoarseGrid(coarser.factors, arrangement, weights, *fields))
        # a grid of one cell has no axis with neighbours
        along = [axis for axis, cells in enumerate(like.shape) if cells > 1] or [0]
        sizes = np.array([min(p[axis] for axis in along) for p in (pitches, *(c.pitches for c in plan))])
        self._factors = _factors(medium, 1 / sizes[1:]).tolist()
        bending = (_power(medium, 1 / sizes) > STEEP).tolist() if plan else [False]
        self.bends = any(bending)
        self._spares = [empty(like, precision) for _ in range(2)] if bending[0] else []
        # of the cells of the finest coarser grid; the whole grid is one where there is none
        self.factors: Factors = plan[0].factors if plan else like.shape
        self.share, self.cell_means = (
            (self.grids[0].work, self.grids[0].cell_means)
            if plan
            else (empty(like, precision, (1, 1)), empty(like, precision, (1, 1)))
        )
        for grid, bends in zip(self.grids, bending[1:], strict=False):
            if bends and grid.line_gain is None:
                grid.spares = [empty(like, precision, tuple(grid.work.shape)) for _ in range(2)]
        coarsest = plan[-1].shape if plan else tuple(like.shape)
        self.sweeps = max(coarsest)  # as many as cells along it, so that each cell hears of all others
        self._sweep_work = [empty(like, precision, coarsest) for _ in range(2)]
        # the one call for all small grids knows neither lines nor cells that bend
        single_grids = has_separate_lines(plan) or self.bends
        self._small = None if single_grids else kernels.small_grids(self.grids, stores, bounds)

    def interpolate(self, *, share_known: bool) -> None:
        """Put P of `values`, zero at the inactive points, into `field`.

        `share_known`: a kernel has written the shares and means of the cells.
        """
        self.set_active(self.values, share_known=share_known)
        self.prolong(self.values, self.field, cell_means_known=share_known)

    def set_active(self, active: Array, *, share_known: bool = False) -> None:
        """Let C be the points where `active` is not zero; that array must not change while C is used.

        `share_known`: a kernel has written the share of C in the cells of the finest coarser grid to `share`.
        """
        kernels, xp, self.active = self.kernels, namespace(active), active
        if not share_known:
            kernels.block_mean(xp.astype(active != 0, active.dtype), self.factors, self.share)
        # the share of contact in every cell comes into `work`, the mean weight of its parts into `empty`
        for number, grid in enumerate(self.grids):
            if self._small is not None and number == self._small.first:
                self._small.weigh()
                break
            fine_share = grid.empty if number else self.share
            coarser = self.grids[number + 1] if number + 1 < len(self.grids) else None
            if grid.line_gain is None:
                next_cells: Cells = (1, 1), *self._sweep_work  # which nothing needs
                if coarser is not None:
                    next_cells = coarser.factors, coarser.empty, coarser.work
                shares, fields = (fine_share, grid.work), (grid.empty, grid.gain)
                kernels.weigh(*shares, grid.factors, grid.arrangement, *fields, next_cells)
                continue
            # every line that is in contact at all counts as one full cell
            is_filled = xp.astype(fine_share > 0, fine_share.dtype)
            grid.line_gain[...] = is_filled / xp.where(is_filled > 0, fine_share, xp.ones_like(is_filled))
            grid.gain[...], grid.empty[...] = is_filled, 1 - is_filled
            if coarser is not None:
                kernels.block_mean(is_filled, coarser.factors, coarser.work)
                coarser.empty[...] = coarser.work
        if any(factor != 1 for factor in self._factors):
            self._reweigh(self._factors)

    def _reweigh(self, factors: list[float]) -> None:
        """Change the weights of all cells by the factors of the medium at their sizes."""
        xp = namespace(self.active)
        finer = self.active
        for grid, factor in zip(self.grids, factors, strict=True):
            cell_share, weight = grid.work, 1 - grid.empty  # of the finest grid: the share
            if grid is not self.grids[0]:
                self.kernels.block_mean(finer, grid.factors, cell_share)
            share = xp.where(cell_share > 0, cell_share, xp.ones_like(cell_share))
            if grid.line_gain is None:
                # the odds of contact against gap are multiplied by the factor
                weight = factor * weight / (1 + (factor - 1) * weight)
                grid.gain[...] = weight / share
                grid.empty[...] = 1 - weight
            else:
                grid.line_gain[...] = weight / share
            finer = weight

    def prolong(self, values: Array, out: Array, *, cell_means_known: bool = False) -> None:
        """Write P `values` to `out`; both of shape (ny, nx), the values zero outside C.

        `cell_means_known`: a kernel has written the means of the values over the cells of the finest coarser
        grid to `cell_means`.
        """
        kernels = self.kernels
        if not self.grids:
            gaps = self._gaps()
            kernels.fill(values, gaps, self._sweep(values, gaps, self.weights), self.weights, out)
            return
        if not cell_means_known:
            kernels.block_mean(values, self.factors, self.cell_means)
        if self._small is None or self._small.first:  # else they are weighed with the others
            self.cell_means *= self.grids[0].gain
        kernels.fill_from(values, self.active, self._prolonged(0), self.factors, self.weights, out)
        if self._spares:
            out[...] = self._smooth(values, self._gaps(), out, self.weights, SWEEPS, self._spares)

    def restrict(self, field: Array, scratch: Array) -> float:
        """Overwrite `field` by P^T `field`, zero outside C, and return its sum.

        `scratch`, like `field`, is overwritten.
        """
        coarse_load = self.restricted_to_coarse(field, scratch)
        return self.kernels.finish_restriction(field, scratch, coarse_load, self.factors, self.active)

    def redistribute(
        self, removed_load: Array, pressure: Array, cap: float, scratch: Array
    ) -> tuple[float, float]:
        """Add the load P^T `removed_load`, zero on C, to the pressure; return its excess and projected sum.

        The excess is beyond [0, `cap`]; the load and `scratch` are overwritten.
        """
        coarse_load = self.restricted_to_coarse(removed_load, scratch)
        if self._spares:
            scratch += removed_load  # which holds, on C, the load from all sweeps but the last
        return self.kernels.redistribute(pressure, scratch, coarse_load, self.factors, self.active, cap)

    def _prolonged(self, number: int) -> Array:
        """Return the values of a grid, given its `cell_means`, for the empty cells of the next finer grid."""
        kernels, grid = self.kernels, self.grids[number]
        if self._small is not None and number == self._small.first:
            self._small.prolong(self.sweeps, *self._sweep_work)
            return grid.cell_means
        if grid.line_gain is not None:
            grid.cell_means *= grid.line_gain
        if number + 1 == len(self.grids):
            means = self._sweep(grid.cell_means, grid.empty, grid.weights)
        else:
            coarser, means = self.grids[number + 1], grid.work
            kernels.block_mean(grid.cell_means, coarser.factors, coarser.cell_means)
            coarser.cell_means *= coarser.gain
            kernels.mix(grid.cell_means, grid.empty, self._prolonged(number + 1), coarser.factors, means)
            if grid.spares:
                means = self._smooth(grid.cell_means, grid.empty, means, grid.weights, SWEEPS, grid.spares)
        if grid.line_gain is not None:
            return means
        kernels.neighbours(means, grid.weights, grid.cell_means)
        return grid.cell_means

    def _sweep(self, cell_means: Array, gaps: Array, weights: Weights) -> Array:
        """Return the mixed field of the coarsest grid, whose neighbours' means are the next step."""
        means = cell_means + gaps * _mean_over_contact(cell_means, gaps)
        return self._smooth(cell_means, gaps, means, weights, self.sweeps - 1, self._sweep_work)

    def _smooth(
        self,
        cell_means: Array,
        gaps: Array,
        means: Array,
        weights: Weights,
        sweeps: int,
        spares: Sequence[Array],
    ) -> Array:
        """Return the `means` field of a grid after sweeps, in one of its `spares`."""
        for sweep in range(sweeps):
            self.kernels.fill(cell_means, gaps, means, weights, spares[sweep % 2])
            means = spares[sweep % 2]
        return means

    def _smooth_back(
        self, total: Array, gaps: Array, weights: Weights, sweeps: int, spares: Sequence[Array]
    ) -> Array:
        """Add to `total` its products with the transposes of the sweeps, and return the last of them."""
        outgoing = total
        for sweep in range(sweeps):
            self.kernels.empty_neighbours(outgoing, gaps, weights, spares[sweep % 2])
            outgoing = spares[sweep % 2]
            total += outgoing
        return outgoing

    def restricted_to_coarse(self, field: Array, scratch: Array) -> Array:
        """Write the load that P^T hands to the neighbours to `scratch`; return that from the coarser grid.

        What is left of P^T `field` is `finish_restriction`. Where cells bend, `field` is changed, too.
        """
        kernels = self.kernels
        if not self.grids:
            gaps = self._gaps()
            kernels.empty_neighbours(field, gaps, self.weights, scratch)
            self._sweep_back(scratch, gaps, self.weights)
            self.share[...] = 0
            return self.share
        outgoing = field
        if self._spares:
            outgoing = self._smooth_back(field, self._gaps(), self.weights, SWEEPS, self._spares)
        kernels.empty_from(outgoing, self.active, self.weights, scratch, self.factors, self.cell_means)
        return self._restricted(0)

    def _restricted(self, number: int) -> Array:
        """Return the transpose of `_prolonged`: from the `cell_means` of a grid to the load they receive."""
        kernels, grid = self.kernels, self.grids[number]
        if self._small is not None and number == self._small.first:
            self._small.restrict(self.sweeps, *self._sweep_work)
            return grid.work
        if grid.line_gain is not None:
            grid.work[...] = grid.cell_means
        else:
            kernels.neighbours(grid.cell_means, grid.weights, grid.work)
        if number + 1 == len(self.grids):
            self._sweep_back(grid.work, grid.empty, grid.weights)
            grid.work *= grid.gain
        else:
            coarser, outgoing = self.grids[number + 1], grid.work
            if grid.spares:
                outgoing = self._smooth_back(grid.work, grid.empty, grid.weights, SWEEPS, grid.spares)
            kernels.gather(outgoing, grid.empty, coarser.factors, coarser.cell_means)
            kernels.spread(grid.work, grid.gain, self._restricted(number + 1), coarser.factors)
        if grid.line_gain is not None:
            grid.work *= grid.line_gain
        return grid.work

    def _gaps(self) -> Array:
        """Return 1 outside C and 0 on it."""
        xp = namespace(self.active)
        return xp.astype(self.active == 0, self.active.dtype)

    def _sweep_back(self, total: Array, gaps: Array, weights: Weights) -> None:
        """Apply the transpose of `_sweep` to `total`."""
        outgoing = self._smooth_back(total, gaps, weights, self.sweeps - 1, self._sweep_work)
        total += _mean_over_contact(gaps * outgoing, gaps)


def _factors(medium: Medium, q: np.ndarray) -> np.ndarray:
    """Return the factors of cells of the pitch 1/q."""
    return np.minimum(medium.factor(STIFFER * q), 1) * np.maximum(medium.factor(SOFTER * q), 1)


def _power(medium: Medium, q: np.ndarray) -> np.ndarray:
    """Return the power of |q| with which the stiffness rises: 1 of a half-space, 4 of a plate."""
    step = 1.1
    # stiffness goes as |q| over the factor; its power by a central difference over ln |q|
    power: np.ndarray = 1 - np.log(medium.factor(q * step) / medium.factor(q / step)) / (2 * np.log(step))
    return power


def _arrangement(shape: tuple[int, int]) -> Arrangement:
    """Return how contacts lie in the cells of a coarse grid."""
    if min(shape) == 1:
        return Arrangement.ALONG_A_LINE
    return Arrangement.SCATTERED if max(shape) <= MAX_SCATTERED else Arrangement.UNKNOWN


def _mean_over_contact(field: Array, gaps: Array) -> float:
    """Return the sum of `field` over that of the weights, 1 - `gaps`."""
    xp = namespace(field)
    weight = float(xp.sum(1 - gaps))
    return float(xp.sum(field)) / weight if weight > 0 else 0.0
