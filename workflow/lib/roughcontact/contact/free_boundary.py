"""Bodies of finite size on the half-space: no neighbours, one certified solution.

In a cell about twice as wide as a region around the contact the kernel that is cut off beyond its diameter is
exact (`contact.elasticity.free_space`). A coarse solution gives the region; where the gap beyond it
shows that more of the map touches, it grows and is solved again.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.finite_body import form_radii
from roughcontact.arguments.maps import sides_around
from roughcontact.arguments.quantities import quantity
from roughcontact.contact.dataset import FieldsInUnits, limit_to_hardness
from roughcontact.contact.elasticity.energy import elastic_energy
from roughcontact.contact.elasticity.fade import FADE
from roughcontact.contact.elasticity.free_space import TruncatedKernel, transform_of_pixels
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.problem import Problem
from roughcontact.contact.sweep import sweep
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.kernels.fourier import wavevectors

COARSEST = 64  # points along the longer side of the map that shows where the contact is
COARSE_TOLERANCE = 0.03  # of the coarse solution, which tells where the contact is and nothing else
MARGIN, MIN_MARGIN = 0.04, 3  # of the region beside the contact, over its width; in points
MIN_FORCE = 1e-15  # over E* times the longer side times the range of heights
MAX_PASSES = 12  # regions; each is larger than the one before
SAFETY = 0.95  # of the tolerance, where a first solution has missed it
DEPTH = 4.0  # of the padding below the heights, over the deepest possible gap of a smooth body
CELL_DIVISOR = 16  # of the points along a cell, for coarser grids of whole cells


class Region(NamedTuple):
    """A disc within a rectangle of the map: the points that may touch."""

    sides: tuple[slice, slice]  # of the rectangle
    mask: np.ndarray  # (ny, nx), of the disc in it
    reach: float  # diameter of the disc, m


class FreeSolution(NamedTuple):
    """The contact of the map under one force; errors are relative, in the energy norm."""

    pressure: np.ndarray  # (ny, nx), Pa
    gap: np.ndarray  # (ny, nx), m
    approach: float  # absolute, m
    error_bound: float
    floor: float  # of rounding
    steps: int
    applications: float  # of the operator, weighted by size over that of the map
    passes: int  # solutions
    norm: float  # root of the elastic energy over that of the periodic contact


def free_solutions(
    problem: Problem,
    forces: Sequence[float],
    material: Elasticity,
    *,
    window: xr.DataArray,
    tolerance: float,
    threads: int,
    **_: Any,
) -> Iterator[tuple[FieldsInUnits, Any, float]]:
    """Yield fields, solution and approach (m) of each of the rising forces (N) on a map, the `window`.

    Other options of the solver do not apply.
    """
    heights = np.asarray(problem.heights)
    if min(heights.shape) < 4:
        raise HeightMapError(
            f"a finite body is a map, this one has {heights.shape[0]} x {heights.shape[1]} points: the "
            "approach of an endless ridge is infinite; solve a profile with boundary: periodic"
        )
    lowest = MIN_FORCE * material.modulus * float(max(problem.lengths_in_metres) * np.ptp(heights))
    if forces[0] < lowest:
        raise SettingsError(
            f"force {forces[0]:g} N: below {lowest:.2g} N the contact is lost in the rounding of the heights",
            keys=("force",),
        )
    body = FreeBody(heights, problem.spacing, material, threads)
    for force in forces:
        solution = body.solve(force, tolerance=tolerance)
        if not window.attrs.get("form_edges"):  # beyond which there is nothing
            body.check_border(solution.pressure, force, form_radii(window.attrs))
        pressure, gap = solution.pressure, solution.gap
        yield_share = limit_to_hardness(pressure, gap, material.hardness)
        contact, total = (pressure > 0).astype(np.int8), float(pressure.sum())
        fields = FieldsInUnits(pressure, gap, contact, float(gap.min()), total, yield_share)
        yield fields, solution, solution.approach


@dataclass(frozen=True)
class FreeBody:
    """A map (ny, nx; m) with pixels `spacing` (dy, dx; m), pressed on a half-space or layers."""

    heights: np.ndarray
    spacing: tuple[float, float]
    elasticity: Elasticity
    threads: int = 1

    def solve(self, force: float, *, tolerance: float) -> FreeSolution:
        """Return the contact under a force (N)."""
        region, ratio = self._first_region(force)
        # a bound of the cell times the ratio of the norms is that of the body
        cell_tolerance, steps, applications = tolerance / ratio, 0, 0.0
        for passes in range(1, MAX_PASSES + 1):
            solution = self._solve_region(region, force, tolerance=cell_tolerance)
            steps, applications = steps + solution.steps, applications + solution.applications
            # what touches at the rim of the region may touch beyond it
            touching = (solution.pressure > 0) | (solution.gap < 0)
            if (touching & ~region.mask).any():
                region = self._region(touching, MIN_MARGIN)
            elif solution.error_bound <= tolerance or solution.error_bound > cell_tolerance * solution.norm:
                return solution._replace(steps=steps, applications=applications, passes=passes)
            else:
                cell_tolerance = SAFETY * tolerance / solution.norm
        raise HeightMapError(f"the region of contact still grows after {MAX_PASSES} solutions")

    def _solve_region(self, region: Region, force: float, *, tolerance: float) -> FreeSolution:
        """Return the contact of a region in a cell without images, to the tolerance of its own norm."""
        heights, mask, (dy, dx) = self.heights[region.sides], region.mask[region.sides], self.spacing
        inside, (ny, nx) = heights[mask], heights.shape
        modulus, hardness = self.elasticity.modulus, self.elasticity.hardness
        carrying = (np.count_nonzero(inside > inside.min()) or inside.size) * dy * dx  # none beyond edges
        if force >= (max_force := hardness * carrying):
            raise SettingsError(
                f"force {force:g} N is not below what the body carries at the hardness {hardness:g} Pa: "
                f"stay below {max_force:.3g} N",
                keys=("force",),
            )
        shape = self._cell(heights.shape, region.reach)
        # the unit length of the periodic problem: the root of the area of its cell
        unit = float(np.sqrt(shape[0] * dy * (shape[1] * dx)))
        mean_pressure, highest = force / unit**2, float(inside.max())
        low = inside.min() - DEPTH * (np.ptp(inside) + force / (self.softest * region.reach))
        cell = np.full(shape, low)
        cell[:ny, :nx] = np.where(mask, heights, low)
        # the mean pressure is the unit
        problem = Problem(cell, self.spacing, highest, gradient=mean_pressure / modulus)
        kernel = TruncatedKernel(region.reach / unit, self.elasticity.scaled(unit))
        of_cell = Elasticity(influence=kernel, hardness=hardness / mean_pressure)
        (solution,) = sweep(problem, [1.0], of_cell, tolerance=tolerance, threads=self.threads)
        state = solution.state
        # the operators leave q = 0 out; in free space the mean has a value
        mean_displacement = state.offset + kernel.mean_displacement(shape, (dy / unit, dx / unit))
        approach = highest - problem.scale * mean_displacement
        pressure = np.zeros(self.heights.shape)
        pressure[region.sides] = state.pressure[:ny, :nx] * mean_pressure
        # outside the region by the displacement of the pressure, inside it as it was certified
        gap = self._displacement(pressure, region.sides) - self.heights + approach
        gap[region.mask] = (state.gap[:ny, :nx] * problem.scale)[mask]
        energy = elastic_energy(pressure, self.spacing, self.elasticity)
        norm = state.norm * float(np.sqrt(force * problem.scale))
        ratio = norm / float(np.sqrt(2 * energy * pressure.size * np.prod(self.spacing)))
        applications = solution.applications * cell.size / self.heights.size
        bound, floor = solution.error_bound * ratio, solution.floor * ratio
        return FreeSolution(pressure, gap, approach, bound, floor, solution.steps, applications, 1, ratio)

    def _first_region(self, force: float) -> tuple[Region, float]:
        """Return the region of contact by a coarse solution, and the ratio of its norms."""
        factor = -(-max(self.heights.shape) // COARSEST)
        if factor == 1:
            return self._region(np.ones(self.heights.shape, bool), 0), 1.0
        ny, nx = self.heights.shape
        # the last block may be incomplete: it repeats the border
        heights = np.pad(self.heights, [(0, -ny % factor), (0, -nx % factor)], mode="edge")
        blocks = heights.reshape(-(-ny // factor), factor, -1, factor).mean(axis=(1, 3))
        wide = self.spacing[0] * factor, self.spacing[1] * factor
        # threads do not pay for so few points
        coarse = replace(self, heights=blocks, spacing=wide, threads=1)
        solution = coarse.solve(force, tolerance=COARSE_TOLERANCE)
        touching = (solution.pressure > 0).repeat(factor, axis=0).repeat(factor, axis=1)
        return self._region(touching[:ny, :nx], factor), solution.norm

    def _region(self, touching: np.ndarray, margin: int) -> Region:
        """Return the region around all points that touch, with a margin of at least so many points."""
        sides = sides_around(touching, lambda width: max(margin, int(MARGIN * width)))
        y, x = np.ogrid[sides]
        distance = np.hypot((y - y.mean()) * self.spacing[0], (x - x.mean()) * self.spacing[1])
        radius = float(distance[touching[sides]].max()) + margin * max(self.spacing)
        mask = np.zeros(touching.shape, bool)
        # a disc, because the kernel is exact up to one distance in all directions
        mask[sides] = distance <= radius * (1 + MARGIN)
        return Region(sides, mask, 2 * float(distance[mask[sides]].max()))

    def elastic_displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Return the displacement (ny, nx; m) of points under a pressure, by the kernel of the solution."""
        sides = sides_around(pressure > 0, lambda width: 0)
        ny, nx = points = pressure[sides].shape
        reach = float(np.hypot(*np.multiply(points, self.spacing)))
        shape, kernel = self._cell(points, reach), TruncatedKernel(reach, self.elasticity)
        symbol = kernel(*wavevectors(shape, self.spacing), self.spacing)
        # the symbol is infinite there, for operators that leave the mean out
        symbol[0, 0] = kernel.mean_displacement(shape, self.spacing)
        in_cell = np.fft.irfft2(np.fft.rfft2(pressure[sides], shape) * symbol, shape)
        displacement = np.zeros(pressure.shape)
        displacement[sides] = in_cell[:ny, :nx] / self.elasticity.modulus
        return displacement

    def _cell(self, points: tuple[int, ...], reach: float) -> tuple[int, int]:
        """Return the points of a cell in which no image acts on a rectangle of so many points."""
        from scipy import fft  # imported late: solves of periodic maps need nothing of scipy

        wide = (np.add(points, FADE * reach / np.array(self.spacing)) + 1) / CELL_DIVISOR
        ny, nx = (CELL_DIVISOR * fft.next_fast_len(int(np.ceil(n))) for n in wide)
        return ny, nx

    def _displacement(self, pressure: np.ndarray, sides: tuple[slice, slice]) -> np.ndarray:
        """Return the displacement (ny, nx; m) by a pressure within `sides`, that of Love's pixels."""
        from scipy import fft

        # each offset between a loaded point and one of the map has its own element of the transform
        shape = tuple(
            # even sides, as `transform_of_pixels` needs them
            2 * fft.next_fast_len(max(side.stop, n - side.start))
            for n, side in zip(pressure.shape, sides, strict=True)
        )
        with fft.set_workers(self.threads):
            symbol = transform_of_pixels(shape, self.spacing, medium=self.elasticity.medium)
            displacement = fft.irfft2(fft.rfft2(pressure[sides], shape) * symbol, shape)
        # the transform counts from the first loaded point
        displacement = np.roll(displacement, [side.start for side in sides], (0, 1))
        return displacement[tuple(map(slice, pressure.shape))] / self.elasticity.modulus

    def check_border(self, pressure: np.ndarray, force: float, radii: Sequence[float]) -> None:
        """Raise HeightMapError where the contact reaches the border of a map on a form of `radii` (m)."""
        if not (pressure[[0, -1]].any() or pressure[:, [0, -1]].any()):
            return
        sides = [n * d for n, d in zip(pressure.shape, self.spacing, strict=True)]
        # without a stated form: a parabola through the mean profile along each axis
        curvatures = [1 / radius for radius in radii] or [
            -2 * np.polyfit(np.linspace(-side, side, n) / 2, self.heights.mean(axis=1 - axis), 2)[0]
            for axis, (n, side) in enumerate(zip(pressure.shape, sides, strict=True))
        ]
        remedy = "surround it by lower heights, at least a row or column, or set form.edges: true"
        advice = f"state form.radius of a rounded body; where the body ends there, {remedy}"
        if min(curvatures) * max(sides) > 1e-9:  # a paraboloid fits
            radius = float(np.prod(curvatures) ** -0.5)
            contact_radius = (3 * force * radius / (4 * self.softest)) ** (1 / 3)
            # a tenth wider than the contact, and than the map that was too small
            larger = (quantity(max(2.2 * contact_radius, 1.1 * side), "m") for side in reversed(sides))
            advice = (
                f"a map of {' × '.join(larger)} would do (a ball of its mean radius of "
                f"curvature, {quantity(radius, 'm')}, touches over {quantity(2 * contact_radius, 'm')}); or "
                f"lower the force; where the body itself ends there, {remedy}; where roughness is small "
                "against its form, form.local_scale with boundary: periodic"
            )
        field = " × ".join(quantity(side, "m") for side in reversed(sides))
        raise HeightMapError(
            f"under {quantity(force, 'N')} the contact reaches the border of the map, {field}, and what lies "
            f"beyond is not known: {advice}"
        )

    @property
    def softest(self) -> float:
        """The modulus (Pa) by which the most compliant wave is displaced."""
        return self.elasticity.modulus / self.elasticity.medium.largest_factor
