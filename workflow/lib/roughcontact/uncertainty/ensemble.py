"""Ensemble members: solutions to a wider tolerance, at few loads, of which only some quantities are kept."""

import contextlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.fields import solved_fields
from roughcontact.contact.solve import elasticity
from roughcontact.errors import HeightMapError
from roughcontact.kernels.arrays import DOUBLE, SINGLE
from roughcontact.maps import RIM, spacing
from roughcontact.uncertainty.headline import quantities_of
from roughcontact.uncertainty.scales import AREA, at_all_loads, from_scale, to_scale
from roughcontact.window.finite_body import finite_body

Values = Mapping[str, np.ndarray]  # quantity -> array (load)
LOADS = 3  # at which a member is solved: both ends and the middle
MARGIN = 0.25  # of a change that is computed, by which its truth may be larger
TOLERANCE = 1e-3  # of the pressure of members, whose change or scatter counts; in single precision


def loads_of(contact: Mapping[str, Any]) -> np.ndarray:
    """Return the mean pressures (load; Pa) of keyword arguments of `solve_contact`."""
    return np.atleast_1d(np.asarray(contact["mean_pressure"], float))


def solve_member(
    window: xr.DataArray,
    contact: Mapping[str, Any],
    *,
    names: Sequence[str],
    loads: np.ndarray | None = None,
    tolerance: float = TOLERANCE,
) -> dict[str, np.ndarray]:
    """Return quantities of a window, each an array of the loads of the indices `loads`, by default all.

    The tolerance of the pressure is that of `contact` where this is wider; a load that misses it is NaN. A
    window whose heights are rounding errors only, after levelling, is solved as flat.
    """
    pressures = loads_of(contact) if loads is None else loads_of(contact)[loads]
    tolerance = max(tolerance, contact.get("tolerance", 0.0))
    contact, steps, unit = {**contact, "mean_pressure": pressures}, spacing(window), 1.0
    left_out: list[type[Exception]] = []
    if contact.get("boundary") == "free":
        rim = max(1, round(RIM * contact["pitch"] / steps[1]))
        window = finite_body(window, **contact["form"], rim=rim)
        unit = window.size * steps[0] * steps[1] / contact["area"]  # the area counts over that of the map
        left_out = [HeightMapError]  # from the load on under which the contact leaves the map
    single = tolerance >= TOLERANCE or contact.get("precision") == "single"
    solutions = solved_fields(window, contact, tolerance=tolerance, precision=SINGLE if single else DOUBLE)
    layered = elasticity(contact.get("contact_modulus"), contact.get("bodies")).layers is not None
    values = {name: np.full(pressures.shape, np.nan) for name in names}
    with contextlib.suppress(*left_out):
        for solution in solutions:
            if solution.error_bound > tolerance:
                continue
            quantities = quantities_of(
                solution.pressure,
                solution.gap,
                names,
                steps=steps,
                influence=contact.get("influence", "sampled"),
                layered=layered,
            )
            for name in names:
                values[name][solution.load_index] = quantities[name] * (unit if name == AREA else 1.0)
    return values


def solve_members(
    windows: Iterable[xr.DataArray], number: int, contact: Mapping[str, Any], names: Iterable[str]
) -> dict[str, np.ndarray]:
    """Return quantities of so many windows, each an array (member, load) with NaN but at `few_loads`."""
    load = loads_of(contact)
    solved = few_loads(load)
    members = {name: np.full((number, load.size), np.nan) for name in names}
    for index, window in enumerate(windows):
        member = solve_member(window, contact, names=[*members], loads=solved)
        for name, results in member.items():
            members[name][index, solved] = results
    return members


def solve_again(window: xr.DataArray, contact: Mapping[str, Any], values: Values) -> dict[str, np.ndarray]:
    """Return the results of a changed window, the change from `values` interpolated between few loads."""
    load = loads_of(contact)
    solved = few_loads(load)
    solved_values = solve_member(window, contact, names=list(values), loads=solved)
    return {
        name: carried_to_all_loads(name, solved_values[name], solved, load, values[name]) for name in values
    }


def few_loads(load: np.ndarray, count: int = LOADS) -> np.ndarray:
    """Return the indices of at most `count` loads: both ends, and those nearest to even steps of ln p."""
    if load.size <= count:
        return np.arange(load.size)
    logarithms = np.log(load)
    even = np.linspace(logarithms.min(), logarithms.max(), count)
    return np.unique(np.abs(logarithms[:, None] - even).argmin(axis=0))


def carried_to_all_loads(
    name: str, values: np.ndarray, solved: np.ndarray, load: np.ndarray, result: np.ndarray
) -> np.ndarray:
    """Return a quantity of a member (load), whose change from the result is interpolated on its scale."""
    if solved.size == load.size:
        return values
    middle = to_scale(name, result)
    change = at_all_loads(to_scale(name, values) - middle[solved], solved, load)
    return from_scale(name, middle + change)


def measured_slices(levelled: xr.DataArray, periodic: xr.DataArray) -> dict[str, slice]:
    """Return the rows ("y") and columns ("x") of a map in its window; blends and mirror images aside."""
    if "periodisation" not in periodic.attrs:  # a map that is its own window
        return {axis: slice(0, n) for axis, n in zip("yx", levelled.shape, strict=True)}
    mirrored = periodic.attrs["periodisation"] == "mirror"
    slices = {}
    for axis, n, step in zip("yx", periodic.shape, spacing(levelled), strict=True):
        first = round(periodic.attrs[f"window_offset_{axis}"] / step)
        slices[axis] = slice(first, first + (n // 2 if mirrored and n > 1 else n))
    return slices
