"""Ensemble members: solutions to a wider tolerance, of which only some quantities are kept."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, GAP
from roughcontact.arguments.kinds import facts_of
from roughcontact.arguments.maps import spacing
from roughcontact.contact.fields import solved_fields
from roughcontact.contact.solve import elasticity
from roughcontact.kernels.arrays import DOUBLE, SINGLE
from roughcontact.surface.levelling.rejected import rejected_points, restore_rejected
from roughcontact.surface.window.periodic_window import periodic_window
from roughcontact.uncertainty.budget_inputs import headline_values
from roughcontact.uncertainty.scales import CONSTRICTIONS, from_scale, to_scale

Values = Mapping[str, np.ndarray]  # quantity -> array (load)
MARGIN = 0.25  # of a change that is computed, by which its truth may be larger
TOLERANCE = 1e-3  # of the pressure of members, whose change or scatter counts; in single precision


def loads_of(contact: Mapping[str, Any]) -> np.ndarray:
    """Return the mean pressures (load; Pa) of keyword arguments of `solve_contact`."""
    return np.atleast_1d(np.asarray(contact["mean_pressure"], float))


def solve_member(
    window: xr.DataArray, contact: Mapping[str, Any], *, names: Collection[str], tolerance: float = TOLERANCE
) -> dict[str, np.ndarray]:
    """Return quantities of a window, each an array (load).

    The tolerance of the pressure is that of `contact` where this is wider; a load that misses it is NaN. A
    window whose heights are rounding errors only, after levelling, is solved as flat. `contact` may have a
    form on which the window is put (`on_form`), and the `area` (m2) of which areas are shares.
    """
    pressures = loads_of(contact)
    tolerance = max(tolerance, contact.get("tolerance", 0.0))
    contact, steps = {**contact, "mean_pressure": pressures}, spacing(window)
    if on_form := contact.get("on_form"):
        window = on_form(window)
    area, highest = window.size * steps[0] * steps[1], float(window.values.max())
    unit = area / contact.get("area", area)  # the contact area counts over that of the map
    single = tolerance >= TOLERANCE or contact.get("precision") == "single"
    solutions = solved_fields(window, contact, tolerance=tolerance, precision=SINGLE if single else DOUBLE)
    material, border = elasticity(**contact), facts_of(contact).border
    values = {name: np.full(pressures.shape, np.nan) for name in names}
    for load, pressure, gap, approach in solutions:
        numbers = headline_values(
            pressure, gap, names, material, steps=steps, border=border, approach=highest - approach
        )
        for name, value in numbers.items():
            values[name][load] = value * (unit if name == AREA else 1.0)
    return values


def measured_slices(levelled_map: xr.DataArray, periodic: xr.DataArray) -> dict[str, slice]:
    """Return the rows ("y") and columns ("x") of a map in its window; blends and mirror images aside."""
    if "periodisation" not in periodic.attrs:  # a map that is its own window
        return {axis: slice(0, n) for axis, n in zip("yx", levelled_map.shape, strict=True)}
    is_mirror = periodic.attrs["periodisation"] == "mirror"
    slices = {}
    for axis, n, step in zip("yx", periodic.shape, spacing(levelled_map), strict=True):
        start = round(periodic.attrs[f"window_offset_{axis}"] / step)
        slices[axis] = slice(start, start + (n // 2 if is_mirror and n > 1 else n))
    return slices


class Result(NamedTuple):
    """The results of a window, whose changes are the uncertainty: what every source solves again."""

    window: xr.DataArray  # (y, x), m
    contact: Mapping[str, Any]  # arguments of `solve_contact`
    values: Values  # without the pressure in contact, which follows from the area
    solve: Callable[..., dict[str, np.ndarray]] = solve_member

    @property
    def load(self) -> np.ndarray:
        """The mean pressures (load; Pa)."""
        return loads_of(self.contact)

    @property
    def hardness(self) -> float:
        """The largest pressure (Pa) that a point bears."""
        return self.contact.get("hardness") or math.inf

    def again(self, window: xr.DataArray, **options: float) -> dict[str, np.ndarray]:
        """Return the results of another window (load), solved with these options."""
        return self.solve(window, self.contact, names=self.values, **options)

    def again_by_part(self, part: xr.DataArray, part_results: Values) -> dict[str, np.ndarray]:
        """Return the results of a changed window (load) by those of a part of it, and of that `before`."""
        changes = self.changes_of_part(part_results, self.again(part)).items()
        return {
            name: from_scale(name, to_scale(name, self.values[name]) + change) for name, change in changes
        }

    def changes(self, results: Values) -> dict[str, np.ndarray]:
        """Return other results less these, on the scales: -inf for a gap that closes, 0 where unknown."""
        changes = {}
        for name, value in self.values.items():
            reference, values = to_scale(name, value), to_scale(name, results[name])
            closes = np.isfinite(reference) & np.isnan(values) & (results[name] == 0)
            with np.errstate(invalid="ignore"):  # between infinite conductances
                changes[name] = np.where(closes, -np.inf, np.nan_to_num(values - reference))
        return changes

    def changes_of_part(self, base: Values, variant: Values) -> dict[str, np.ndarray]:
        """Return the changes (load) on the scales by those of a part of the window."""
        changes = {}
        for name in base:
            change = to_scale(name, variant[name]) - to_scale(name, base[name])
            if name in CONSTRICTIONS:  # a length, as the gap beside it
                with np.errstate(divide="ignore", invalid="ignore"):
                    change = change * self.values[GAP] / base[GAP]
            # full contact: nothing is open, nothing changes
            changes[name] = np.where(np.isfinite(change), change, 0.0)
        return changes

    def members(self, windows: Iterable[xr.DataArray]) -> dict[str, np.ndarray]:
        """Return the results of other windows (member, load), each load in one piece of memory."""
        results = [self.again(window) for window in windows]
        return {name: np.array([member[name] for member in results], order="F") for name in self.values}


def rejected_load_share(
    levelled_map: xr.DataArray, *, window: Mapping[str, Any], contact: Mapping[str, Any]
) -> np.ndarray:
    """Return the share (load) of the load that the rejected points would carry if they were kept.

    The map with them is made periodic and solved again; points blended with one count. NaN where a load
    misses the tolerance or rejected heights are unknown, 0 without rejected points.
    """
    loads = loads_of(contact)
    if "rejected_height" not in levelled_map.coords and levelled_map.attrs.get("outliers_rejected", 0):
        return np.full(loads.shape, np.nan)
    copy = levelled_map.copy(deep=False)  # heights loaded into the copy are freed before the solve
    if not rejected_points(copy).any():
        return np.zeros(loads.shape)
    # periodisation carries the marks into the window, blended edges included
    restored_map = periodic_window(restore_rejected(copy), **window)
    del copy
    is_rejected = restored_map["filled"].values != 0
    if not is_rejected.any():
        return np.zeros(loads.shape)
    share, tolerance = np.full(loads.shape, np.nan), max(TOLERANCE, contact.get("tolerance", 0.0))
    for load, pressure, *_ in solved_fields(restored_map, contact, tolerance=tolerance):
        share[load] = pressure[is_rejected].sum(dtype=float) / pressure.sum(dtype=float)
    return share
