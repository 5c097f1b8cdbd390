"""Bodies of finite size on the half-space: no neighbours, one certified solution.

In a cell about twice as wide as a region around the contact the kernel that is cut off beyond its diameter is
exact (`roughcontact.elasticity.free_space`). A coarse solution gives the region; where the gap beyond it
shows that more of the map touches, it grows and is solved again.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.choices import Influence
from roughcontact.contact.certificate import rounding_floor
from roughcontact.contact.dataset import of_one_load, unit_of_pressure
from roughcontact.contact.grid import Grid
from roughcontact.contact.iteration import solve_on_grid
from roughcontact.contact.nested_iteration import first_guess, nested_heights
from roughcontact.contact.problem import nondimensionalise, on_host
from roughcontact.contact.state import State
from roughcontact.elasticity.energy import elastic_energy
from roughcontact.elasticity.free_space import (
    FADE,
    TruncatedKernel,
    change_by_layers,
    distances,
    even_transform,
    love,
)
from roughcontact.elasticity.layers import LayeredPair
from roughcontact.errors import ConvergenceError, HeightMapError, SettingsError
from roughcontact.kernels.arrays import DOUBLE, SINGLE

COARSEST = 64  # points along the longer side of the map that shows where the contact is
COARSE_TOLERANCE = 0.03
MARGIN, MIN_MARGIN = 0.04, 3  # of the region beside the contact, over its width; in points
MAX_PASSES = 12  # regions; each is larger than the one before
SAFETY = 0.95  # of the tolerance, where a first solution has missed it
DEPTH = 4.0  # of the padding below the heights, over the deepest possible gap of a smooth body
CELL_DIVISOR = 16  # of the points along a cell, for coarser grids of whole cells


@dataclass(frozen=True)
class FreeSolution:
    """The contact of a finite body under one force; errors are relative, in the energy norm."""

    pressure: np.ndarray  # (ny, nx), Pa
    gap: np.ndarray  # (ny, nx), m
    approach: float  # absolute, m
    error_bound: float
    floor: float  # of rounding
    steps: int
    applications: float  # of the operator, weighted by size over that of the map
    passes: int  # solutions


@dataclass
class Region:
    """A disc within a rectangle of the map: the points that may touch.

    `rows`, `columns`: slices of the map; `mask` (rows, columns): of the disc; `reach` in m: its diameter.
    """

    rows: slice
    columns: slice
    mask: np.ndarray
    reach: float


def free_datasets(
    window: xr.DataArray,
    forces: Sequence[float],
    *,
    tolerance: float,
    hardness: float | None,
    give_up: bool,
    **material: Any,
) -> Iterator[xr.Dataset]:
    """Yield the dataset of each force (N), with `load` of size 1 and the variables of contact.nc.

    `mean_pressure` is the force over the area of the map; `material`: further arguments of `FreeBody`. Raises
    `ConvergenceError`: where `give_up` and a force misses the tolerance.
    """
    window = on_host(window)
    problem = nondimensionalise(window, threads=material["threads"])
    if min(window.shape) < 4:
        raise HeightMapError(
            f"a finite body is a map, this one has {window.shape[0]} x {window.shape[1]} points: the "
            "approach of an endless ridge is infinite; solve a profile with boundary: periodic"
        )
    limit = np.inf if hardness is None else hardness
    body = FreeBody(np.asarray(window.values, float), problem.spacing, hardness=limit, **material)
    attrs = {"tolerance": tolerance, "influence": body.influence, "boundary": "free"}
    attrs |= {"bodies": json.dumps(body.layers.as_settings())} if body.layers else {}
    for force in forces:
        solution = body.solve(force, tolerance=tolerance)
        if give_up and solution.error_bound > tolerance:
            raise ConvergenceError(
                f"force {force:g} N: the error bound stopped at {solution.error_bound:.2g}, above the "
                f"tolerance {tolerance:g} (rounding allows {solution.floor:.1g}): raise the tolerance or set "
                "on_failure: flag"
            )
        pressure, mean = solution.pressure, force / float(window.size * np.prod(problem.spacing))
        yielded = pressure >= limit
        gap = np.where(yielded, 0.0, solution.gap)
        numbers = {
            "relative_pressure": mean / unit_of_pressure(problem, body.modulus)
            if not problem.flat
            else np.inf,
            "approach": solution.approach,
            "iterations": solution.steps,
            "operator_applications": solution.applications,
            "error_bound": solution.error_bound,
            "rounding_floor": solution.floor,
            "yielded_area": float(yielded.mean()),
            "max_penetration": max(0.0, -float(gap.min())),
            "converged": np.int8(solution.error_bound <= tolerance),
            "load_error": abs(float(pressure.mean()) / mean - 1),
        }
        maps = {"pressure": pressure, "gap": gap, "contact": (pressure > 0).astype(np.int8)}
        loaded = {"mean_pressure": mean, "force": force}
        yield of_one_load(window, maps, numbers, loaded, modulus=body.modulus, hardness=hardness, attrs=attrs)


@dataclass(frozen=True)
class FreeBody:
    """A map (ny, nx; m) with pixels `spacing` (dy, dx; m), pressed on a half-space of modulus E* (Pa)."""

    heights: np.ndarray
    spacing: tuple[float, float]
    modulus: float
    hardness: float = np.inf  # Pa
    influence: Influence = "sampled"
    layers: LayeredPair | None = None
    threads: int = 1

    def solve(self, force: float, *, tolerance: float) -> FreeSolution:
        """Return the contact under a force (N)."""
        region, ratio = self._first_region(force)
        start, cell_tolerance, steps, applications, passes = None, tolerance / ratio, 0, 0.0, 0
        while passes < MAX_PASSES:
            passes += 1
            cell = Cell(self, region, force)
            solved = cell.solve(start, tolerance=cell_tolerance)
            pressure = np.zeros(self.heights.shape)
            pressure[region.rows, region.columns] = cell.pressure
            steps, applications = steps + cell.steps, applications + cell.applications / pressure.size
            ratio = self._norm_ratio(cell.energy, pressure)
            bound = solved * ratio
            gap = self._gap(cell, region, pressure)
            # what touches at the rim of the region may touch beyond it
            touching = (pressure > 0) | (gap < 0)
            outside = touching.copy()
            outside[region.rows, region.columns] &= ~region.mask
            if not outside.any():
                if bound <= tolerance or cell.is_stuck:
                    break
                cell_tolerance *= SAFETY * tolerance / bound
            else:
                region = self._region(touching, MIN_MARGIN)
            start = pressure
        else:
            raise HeightMapError(f"the region of contact still grows after {MAX_PASSES} solutions")
        self._check_border(pressure, force)
        floor = cell.floor * ratio
        return FreeSolution(pressure, gap, cell.approach, bound, floor, steps, applications, passes)

    def _first_region(self, force: float) -> tuple[Region, float]:
        """Return the region of contact by a coarse solution, and the ratio of its norms."""
        factor = -(-max(self.heights.shape) // COARSEST)
        if factor == 1:
            return self._region(np.ones(self.heights.shape, bool), 0), 1.0
        ny, nx = (-(-n // factor) for n in self.heights.shape)
        padding = [(0, ny * factor - self.heights.shape[0]), (0, nx * factor - self.heights.shape[1])]
        blocks = np.pad(self.heights, padding, mode="edge").reshape(ny, factor, nx, factor)
        coarse_spacing = self.spacing[0] * factor, self.spacing[1] * factor
        coarse = replace(self, heights=blocks.mean(axis=(1, 3)), spacing=coarse_spacing, threads=1)
        cell = Cell(coarse, coarse._region(np.ones((ny, nx), bool), 0), force)
        cell.solve(None, tolerance=COARSE_TOLERANCE)
        touching = np.repeat(np.repeat(cell.pressure > 0, factor, axis=0), factor, axis=1)
        ratio = coarse._norm_ratio(cell.energy, cell.pressure)
        return self._region(touching[: self.heights.shape[0], : self.heights.shape[1]], factor), ratio

    def _region(self, touching: np.ndarray, margin: int) -> Region:
        """Return the region around all points that touch, with a margin of at least so many points."""
        ends = []
        for line, n in zip(np.nonzero(touching), touching.shape, strict=True):
            first, last = int(line.min()), int(line.max())
            widening = max(margin, int(MARGIN * (last - first))) if margin else 0
            ends.append((max(first - widening, 0), min(last + widening + 1, n)))
        (top, bottom), (left, right) = ends
        y, x = (
            (np.arange(*pair) - 0.5 * (sum(pair) - 1)) * d for pair, d in zip(ends, self.spacing, strict=True)
        )
        distance = np.hypot(y[:, None], x)
        radius = float(distance[touching[top:bottom, left:right]].max()) + margin * max(self.spacing)
        mask = distance <= radius * (1 + MARGIN)
        return Region(slice(top, bottom), slice(left, right), mask, 2 * float(distance[mask].max()))

    def _norm_ratio(self, energy: float, pressure: np.ndarray) -> float:
        """Return the norm of the pressure in its cell, of that energy (J), over that in the window."""
        elastic: dict[str, Any] = {"influence": self.influence, "layers": self.layers}
        of_window = elastic_energy(pressure, self.spacing, contact_modulus=self.modulus, **elastic)
        return float(np.sqrt(energy / (of_window * pressure.size * np.prod(self.spacing))))

    def _gap(self, cell: "Cell", region: Region, pressure: np.ndarray) -> np.ndarray:
        """Return the gap (ny, nx) in m: that of the solution in the region, that of Love's pixels beyond."""
        from scipy import fft  # imported late: solves of periodic maps need nothing of scipy

        sides = region.rows, region.columns
        # each offset between a loaded point and one of the map has its own element of the transform
        sizes = [2 * max(side.stop, n - side.start) for n, side in zip(pressure.shape, sides, strict=True)]
        shape = 2 * fft.next_fast_len(sizes[0] // 2), 2 * fft.next_fast_len(sizes[1] // 2)
        with fft.set_workers(self.threads):
            spectrum = fft.rfft2(pressure[sides], shape) * _free_symbol(shape, self.spacing, self.layers)
            displacement = fft.irfft2(spectrum, shape)
        displacement = np.roll(displacement, [side.start for side in sides], (0, 1))
        map_sides = tuple(slice(n) for n in pressure.shape)
        gap = displacement[map_sides] / self.modulus - self.heights + cell.approach
        gap[sides][region.mask] = cell.gap[region.mask]
        return gap

    def _check_border(self, pressure: np.ndarray, force: float) -> None:
        """Raise HeightMapError where the contact reaches the border of the map."""
        if not (pressure[[0, -1]].any() or pressure[:, [0, -1]].any()):
            return
        sides = [n * d for n, d in zip(pressure.shape, self.spacing, strict=True)]
        radius = self._radius_of_curvature()
        if radius is None:
            advice = "surround it by lower heights, at least a row or column, where the body ends there"
        else:
            contact_radius = (3 * force * radius / (4 * self.softest)) ** (1 / 3)
            side = max(2.2 * contact_radius, 1.1 * min(sides))
            advice = (
                f"a map of {side:.3g} m x {side:.3g} m would do (a ball of its mean radius of curvature, "
                f"{radius:.3g} m, touches over {2 * contact_radius:.3g} m); or lower the force; where the "
                "body itself ends there, surround it by lower heights; where roughness is small against its "
                "form, form.local_scale with boundary: periodic"
            )
        raise HeightMapError(
            f"under {force:g} N the contact reaches the border of the map, {sides[1]:.3g} m x "
            f"{sides[0]:.3g} m, and what lies beyond is not known: {advice}"
        )

    def _radius_of_curvature(self) -> float | None:
        """Return the geometric mean radius (m) of the paraboloid that fits; None where it is not convex."""
        sides = [(n - 1) / 2 * d for n, d in zip(self.heights.shape, self.spacing, strict=True)]
        curvatures = []
        for axis, side in enumerate(sides):
            line = self.heights.mean(axis=1 - axis)
            curvatures.append(-2 * np.polyfit(np.linspace(-side, side, line.size), line, 2)[0])
        curved = min(curvatures) * max(sides) > 1e-9
        return float(1 / np.sqrt(curvatures[0] * curvatures[1])) if curved else None

    @property
    def softest(self) -> float:
        """The modulus (Pa) by which the most compliant wave is displaced."""
        if self.layers is None:
            return self.modulus
        q = np.geomspace(1e-3 / self.layers.thickest, 1e2 / self.layers.thinnest, 64)
        return self.modulus / max(1.0, float(self.layers.factor(q).max()))


class Cell:
    """The periodic problem of a region: its heights in a cell where no image acts on it."""

    def __init__(self, body: FreeBody, region: Region, force: float):
        from scipy import fft

        self.body, self.region = body, region
        heights = body.heights[region.rows, region.columns]
        ny, nx = (
            CELL_DIVISOR
            * int(fft.next_fast_len(int(np.ceil((n + FADE * region.reach / d + 1) / CELL_DIVISOR))))
            for n, d in zip(heights.shape, body.spacing, strict=True)
        )
        self.shape = ny, nx
        lengths = [n * d for n, d in zip(self.shape, body.spacing, strict=True)]
        self.unit_length = float(np.sqrt(lengths[0] * lengths[1]))
        self.lengths = lengths[0] / self.unit_length, lengths[1] / self.unit_length
        self.mean_pressure = force / (lengths[0] * lengths[1])
        if self.mean_pressure * np.prod(self.shape) >= body.hardness * region.mask.sum():
            raise SettingsError(
                f"force {force:g} N is not below what the body carries at the hardness {body.hardness:g} Pa",
                keys=("force",),
            )
        inside = heights[region.mask]
        lowest, highest = float(inside.min()), float(inside.max())
        low = lowest - DEPTH * (highest - lowest + force / (body.softest * region.reach))
        self.heights = np.full(self.shape, low)
        self.heights[: heights.shape[0], : heights.shape[1]] = np.where(region.mask, heights, low)
        self.reference = highest
        # the unit of height g L and that of pressure E* g, with the dimensionless load 1
        self.gradient = self.mean_pressure / body.modulus
        self.kernel = TruncatedKernel(
            body.influence,
            region.reach / self.unit_length,
            body.layers and body.layers.scaled(self.unit_length),
        )

    def _grid(self, heights: np.ndarray, *, reference: float = 0.0, unit: float = 1.0) -> Grid:
        """Return the grid of heights, which count as (height - reference)/unit."""
        return Grid(
            heights,
            self.lengths,
            reference=reference,
            unit=unit,
            cap=self.body.hardness / self.mean_pressure,
            influence=self.kernel,
            threads=self.body.threads,
        )

    def solve(self, start: np.ndarray | None, *, tolerance: float) -> float:
        """Solve to a tolerance, from a pressure (of the map) or from coarser grids; return the bound."""
        scale = self.gradient * self.unit_length
        finest = self._grid(self.heights, reference=self.reference, unit=scale)
        ny, nx = self.region.mask.shape
        self.steps, applications = 0, 0.0
        if start is None:
            nested = nested_heights(finest.heights_in(SINGLE), self.lengths)
            grids = [finest, *(self._grid(heights) for _, heights in nested)]
            fluctuation = grids[-1].halfspace.pressure(grids[-1].heights_in(SINGLE))
            guess, self.steps = first_guess(grids, [factors for factors, _ in nested], 1.0, fluctuation)
            applications = sum(grid.halfspace.applications * np.prod(grid.shape) for grid in grids[1:])
        else:
            guess = np.zeros(self.shape)
            guess[:ny, :nx] = start[self.region.rows, self.region.columns] / self.mean_pressure
        solution = solve_on_grid(finest, guess, 1.0, tolerance=tolerance, finish=DOUBLE)
        state: State = solution.state
        self.steps += solution.steps
        self.applications = float(applications + finest.halfspace.applications * np.prod(self.shape))
        spacing = self.body.spacing[0] / self.unit_length, self.body.spacing[1] / self.unit_length
        mean = self.kernel.mean_displacement(self.shape, spacing)
        self.approach = self.reference - scale * (state.offset + mean)
        self.pressure = state.pressure[:ny, :nx] * self.mean_pressure
        self.gap = state.gap[:ny, :nx] * scale
        area = np.prod(self.shape) * np.prod(self.body.spacing)
        self.energy = 0.5 * state.norm**2 * self.mean_pressure * scale * float(area)
        self.floor = rounding_floor(finest.halfspace, state)
        self.is_stuck = solution.error_bound > tolerance
        return solution.error_bound


@lru_cache(maxsize=2)
def _free_symbol(
    shape: tuple[int, int], spacing: tuple[float, float], layers: LayeredPair | None
) -> np.ndarray:
    """Return the transform of Love's kernel, and of what layers change of it, exact up to half of a grid."""
    quarter = shape[0] // 2 + 1, shape[1] // 2 + 1
    response = love(quarter, spacing)
    if layers is not None:
        response += change_by_layers(layers, distances(quarter, spacing)) * spacing[0] * spacing[1]
    return even_transform(response, shape)
