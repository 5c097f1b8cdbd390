"""Scatter of the results within a map: its subwindows, each solved as if it had been measured alone.

What other places of the surface would show is told by the scatter s of the subwindows (3 x 3), and by how it
falls with their size. On a stationary surface subwindows that are longer than its longest wave are
independent samples: the variance of a mean over n of them is 1/n, and the map, n times as large, scatters
s/sqrt(n). On most measured surfaces places differ on every length: waviness, wear, a scratch. The rms
gradient and the rms height of 4, 9, 16 and 36 subwindows need no solution; their variances are fitted by

    var(n) = a + b n,   a, b >= 0

and var(1) is what is expected of maps of this size. Both, the scatter of the solved subwindows and the
texture aspect ratio Str, which tells a lay, are the features of the calibrated arms (`calibration`).
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import scipy
import xarray as xr

from roughcontact.errors import SettingsError
from roughcontact.levelling.polynomial import fit_polynomial
from roughcontact.maps import spacing
from roughcontact.roughness.texture import texture_parameters
from roughcontact.uncertainty.ensemble import form_order, measured_slices, solve_member
from roughcontact.uncertainty.loads import at_all_loads, few_loads
from roughcontact.uncertainty.scales import CONSTRICTIONS, GAP, to_scale
from roughcontact.window.periodic_window import subwindow

_TOLERANCE = 1e-2  # of the pressure: 0.4 % of the area (rms), where subwindows differ by 5 % and more
_LOADS = 4  # at which subwindows are solved
_MIN_POINTS_PER_SIDE = 12  # of a subwindow
_MIN_WAVES_PER_SIDE = 2  # side of a subwindow over the shortest wavelength that is kept
_CUTS = (2, 3, 4, 6)  # of the sides, for statistics without a solution
_LEAST_SCATTER = 0.02  # of a logarithm; less is chance
_LARGEST_TREND = 3.0  # of a logarithm; more is a closed gap
_LEAST_SHARE = 0.01  # of the result: the logarithm of smaller values is meaningless

Slices = dict[str, slice]  # rows ("y") and columns ("x") of a map


class Scatter(NamedTuple):
    """What the subwindows of a map show.

    Attributes
    ----------
    members : dict
        quantity -> results (member, load) of the subwindows, NaN at loads that were not solved.
    features : dict
        quantity -> the features (load) of its calibrated arms; empty where the map is too small.
    slices : list
        rows and columns of each subwindow in the map.
    incomplete : bool
        whether the solution of a subwindow missed its tolerance.
    lay : float
        texture aspect ratio Str of the window, 0.5 where it has none.
    """

    members: dict[str, np.ndarray]
    features: dict[str, dict[str, Any]]
    slices: list[Slices]
    incomplete: bool = False
    lay: float = 0.5


def scatter_of_subwindows(
    levelled: xr.DataArray,
    window: xr.DataArray,
    *,
    contact: Mapping[str, Any],
    arguments: Mapping[str, Any],
    values: Mapping[str, np.ndarray],
    number: int = 9,
) -> Scatter:
    """Return the scatter of the results of a map's subwindows.

    Parameters
    ----------
    levelled, window : DataArray (y, x), m
        the levelled map and its periodic window.
    contact, arguments : mapping
        keyword arguments of `solve_contact` and `periodic_window` that led to the result.
    values : mapping
        quantity -> array (load) of the window.
    number : int
        most subwindows that are solved, 4 or more; 9 divides a map into 3 x 3 and a profile into 9.

    Raises
    ------
    SettingsError
        where `number` is below 4.

    Examples
    --------
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.window.periodic_window import periodic_window
    >>> levelled = level(rough_reference_surface(64))
    >>> window, problem = periodic_window(levelled), {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> values = solve_member(window, problem, tolerance=1e-2, names=["relative_contact_area"])
    >>> found = scatter_of_subwindows(levelled, window, contact=problem, arguments={}, values=values)
    >>> found.members["relative_contact_area"].shape
    (9, 1)
    """
    if number != int(number) or number < 4:
        raise SettingsError(f"windows = {number!r}: give a whole number of 4 or more")
    whole = measured_slices(levelled, window)
    slices = divided(whole, spacing(levelled), int(number), arguments.get("shortest_wavelength") or 0.0)
    load = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    names, solved = list(values), few_loads(load, _LOADS)
    members = {name: np.full((len(slices), load.size), np.nan) for name in names}
    if len(slices) < 2:
        return Scatter(members, {}, slices)
    order = form_order(levelled)
    for index, part in enumerate(slices):
        periodic = subwindow(_relevelled(levelled.isel(part), order), **arguments)
        member = solve_member(periodic, contact, tolerance=_TOLERANCE, names=names, loads=solved)
        for name in names:
            members[name][index, solved] = member[name]
    common = _common_features(levelled.isel(whole), window, order)
    features = {}
    gap = values[GAP][solved] if GAP in values else np.ones(solved.size)
    for name in names:
        spread, trend = _spread_and_trend(name, members[name][:, solved], values[name][solved], gap)
        features[name] = common | {
            "scatter": at_all_loads(np.log(spread), solved, load),
            "trend": at_all_loads(trend, solved, load),
        }
    incomplete = bool(np.isnan(members[GAP][:, solved]).any()) if GAP in names else False
    return Scatter(members, features, slices, incomplete, common["lay"])


def _spread_and_trend(
    name: str, members: np.ndarray, result: np.ndarray, gap: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return standard deviation and mean of the members (member, load) about the result, on the scale.

    Narrowest places are counted in mean gaps.
    """
    if name in CONSTRICTIONS:
        known = np.where(np.isnan(members), result, members)
        deviations = (known - result) / np.where(gap > 0, gap, 1.0)
    else:
        positive = np.where(result > 0, result, 1.0)
        known = np.where(np.isnan(members), positive, np.fmax(members, _LEAST_SHARE * positive))
        deviations = to_scale(name, known) - to_scale(name, positive)
    spread = np.hypot(np.std(deviations, axis=0, ddof=1), _LEAST_SCATTER)
    return spread, np.clip(deviations.mean(axis=0), -_LARGEST_TREND, _LARGEST_TREND)


def _common_features(measured: xr.DataArray, window: xr.DataArray, order: int) -> dict[str, float]:
    """Return the features of a map that are those of all quantities and loads."""
    gradients, heights = _scatter_by_number(measured, order)
    aspect = texture_parameters(window)["Str"]
    return {
        "gradient": _at_the_size_of_the_map(gradients),
        "height": _at_the_size_of_the_map(heights),
        "lay": 0.5 if math.isnan(aspect) else aspect,
    }


def _scatter_by_number(measured: xr.DataArray, order: int) -> tuple[dict[int, float], dict[int, float]]:
    """Return the variances of ln rms gradient and ln rms height between so many subwindows."""
    heights, steps = measured.values, spacing(measured)
    squares = np.zeros([max(n - 1, 1) for n in heights.shape])
    for axis, step in enumerate(steps):
        if heights.shape[axis] > 1:
            slope = np.diff(heights, axis=axis) / step
            squares += slope[: squares.shape[0], : squares.shape[1]] ** 2
    gradients, deviations = {}, {}
    for cuts in _CUTS:
        pieces = [cuts if n > 1 else 1 for n in heights.shape]
        if any(n // k < _MIN_POINTS_PER_SIDE for n, k in zip(heights.shape, pieces, strict=True) if k > 1):
            continue
        number = math.prod(pieces)
        parts = [_cut(values, pieces) for values in (squares, heights)]
        gradients[number] = _log_variance([0.5 * math.log(max(part.mean(), 1e-300)) for part in parts[0]])
        deviations[number] = _log_variance(
            [0.5 * math.log(max(_variance_about_form(part, order), 1e-300)) for part in parts[1]]
        )
    return gradients, deviations


def _cut(values: np.ndarray, pieces: list[int]) -> list[np.ndarray]:
    """Return the pieces of an array, cut so many times along each axis."""
    return [
        piece
        for rows in np.array_split(values, pieces[0], axis=0)
        for piece in np.array_split(rows, pieces[1], axis=1)
    ]


def _variance_about_form(heights: np.ndarray, order: int) -> float:
    """Return the mean square of heights about their own polynomial form."""
    coordinates = [np.arange(n, dtype=float) for n in heights.shape]
    form, _ = fit_polynomial(heights, coordinates, order=max(order, 1))
    return float(np.mean((heights - form) ** 2))


def _log_variance(logarithms: list[float]) -> float:
    """Return the variance of some logarithms."""
    return float(np.var(logarithms, ddof=1))


def _at_the_size_of_the_map(variances: Mapping[int, float]) -> float:
    """Return ln of the standard deviation that maps of this size are expected to have, from var(n) = a + b n.

    Each variance has a relative error of sqrt(2/(n - 1)), and is weighted by its inverse.
    """
    if len(variances) < 2:
        return math.log(0.1)
    number, variance = (np.array(column, float) for column in zip(*variances.items(), strict=True))
    weight = np.sqrt(number - 1) / np.maximum(variance, 1e-6)
    (a, b), _ = scipy.optimize.nnls(
        np.column_stack([np.ones(number.size), number]) * weight[:, None], variance * weight
    )
    return 0.5 * math.log(a + b + 1e-4)


def _relevelled(part: xr.DataArray, order: int) -> xr.DataArray:
    """Return a subwindow of a levelled map with the same form removed again; no other step is repeated."""
    if not order:
        return part
    form, _ = fit_polynomial(part.values, (part["y"].values, part["x"].values), order=order)
    return part.copy(data=part.values - form)


def divided(whole: Slices, step: tuple[float, float], number: int, shortest: float = 0.0) -> list[Slices]:
    """Return the subwindows of a window, with the largest product of their number and squareness.

    `step` is the pitch (dy, dx), `shortest` the shortest wavelength that is kept (m).
    """
    sides = [whole[d].stop - whole[d].start for d in "yx"]
    most = [
        max(1, int(n / max(_MIN_POINTS_PER_SIDE, _MIN_WAVES_PER_SIDE * shortest / s))) if n > 1 else 1
        for n, s in zip(sides, step, strict=True)
    ]
    cuts = [
        (ky * kx * _squareness(sides[0] * step[0] / ky, sides[1] * step[1] / kx, sides), ky, kx)
        for ky in range(1, min(number, most[0]) + 1)
        for kx in range(1, min(number // ky, most[1]) + 1)
    ]
    _, *cut = max(cuts)
    edges = [whole[d].start + np.arange(k + 1) * n // k for d, n, k in zip("yx", sides, cut, strict=True)]
    return [
        {"y": slice(int(top), int(bottom)), "x": slice(int(left), int(right))}
        for top, bottom in zip(edges[0][:-1], edges[0][1:], strict=True)
        for left, right in zip(edges[1][:-1], edges[1][1:], strict=True)
    ]


def _squareness(length_y: float, length_x: float, sides: list[int]) -> float:
    """Return the shorter side of a subwindow over the longer one; 1 for a profile."""
    return 1.0 if 1 in sides else min(length_y, length_x) / max(length_y, length_x)
