"""Scatter of the results within a map: its subwindows, each solved as if it had been measured alone.

On a stationary surface the map, n times as large, scatters s/sqrt(n), s the scatter of n subwindows longer
than its longest wave; most surfaces differ on every length. The variances of the rms gradient of 4, 9, 16 and
36 subwindows are fitted by var(n) = a + b n, a, b >= 0, var(1) being that of maps of this size. This, the
scatter of the solved subwindows (3 x 3), their trend and Str are the features of the calibrated arms
(`calibration`).
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import scipy
import xarray as xr

from roughcontact.errors import SettingsError
from roughcontact.levelling.forms import form_order
from roughcontact.levelling.polynomial import fit_polynomial
from roughcontact.maps import spacing
from roughcontact.roughness.texture import texture_parameters
from roughcontact.uncertainty.calibration import Features
from roughcontact.uncertainty.ensemble import Result, Values, measured_slices
from roughcontact.uncertainty.scales import CONSTRICTIONS, to_scale
from roughcontact.window.periodic_window import subwindow

_MIN_POINTS_PER_SIDE = 12  # of a subwindow
_CUTS = (2, 3, 4, 6)  # of the sides, for statistics without a solution
_LEAST_SCATTER = 0.02  # of a logarithm, and of a result that is not closed; less is chance

Slices = dict[str, slice]  # rows ("y") and columns ("x") of a map


class Scatter(NamedTuple):
    """What the subwindows of a map, or other members, show of each quantity."""

    members: dict[str, np.ndarray]  # results (member, few loads), NaN where one missed its tolerance
    features: Mapping[str, Features] = MappingProxyType({})  # (load) of calibrated arms
    slices: Sequence[Slices] = ()  # rows and columns of each subwindow in the map
    # of surfaces behind profiles: how far the truth lies below and above, and mean of the members less the
    # result (load), on the scale; of places in mean gaps
    arms: Mapping[str, tuple[np.ndarray, np.ndarray]] = MappingProxyType({})
    shift: Values = MappingProxyType({})
    reason: str = ""  # what the members are, if no subwindows
    of_positions: bool = False  # other positions, which say nothing of this one
    open_ended: Mapping[str, np.ndarray] = MappingProxyType({})  # whether grooves lead out of the map (load)


def scatter_of_subwindows(
    result: Result, levelled: xr.DataArray, *, arguments: Mapping[str, Any], number: int = 9
) -> Scatter:
    """Return the scatter of the results of at most `number` (4 or more) subwindows of a map.

    `arguments` are those of `periodic_window` that led from the levelled map to the window.
    """
    if number != int(number) or number < 4:
        raise SettingsError(f"windows = {number!r}: give a whole number of 4 or more")
    region = measured_slices(levelled, result.window)
    slices = divided(region, spacing(levelled), int(number), arguments.get("shortest_wavelength") or 0.0)
    order, few = form_order(levelled), result.few
    if len(slices) < 2:
        unknown = np.full((len(slices), few.size), np.nan)
        return Scatter(dict.fromkeys(result.values, unknown), slices=slices)
    subwindows = (subwindow(_relevelled(levelled.isel(area), order), **arguments) for area in slices)
    members = result.members(subwindows)
    measured, aspect = levelled.isel(region), texture_parameters(result.window)["Str"]
    common = {
        "gradient": _at_the_size_of_the_map(_gradient_variances(measured.values, spacing(measured))),
        "lay": 0.5 if math.isnan(aspect) else aspect,
    }
    features: dict[str, Features] = dict.fromkeys(result.values, common)
    for name in result.values.keys() - {*CONSTRICTIONS}:
        spread, trend = _spread_and_trend(name, members[name], result.values[name][few])
        of_members = {"scatter": np.log(spread), "trend": trend}
        features[name] = common | {key: result.at_all_loads(each) for key, each in of_members.items()}
    return Scatter(members, features, slices)


def _spread_and_trend(name: str, members: np.ndarray, result: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return standard deviation and mean of the members (member, load) about the result, on the scale."""
    positive = np.where(result > 0, result, 1.0)
    clipped = np.where(np.isnan(members), positive, np.fmax(members, _LEAST_SCATTER * positive))
    deviations = to_scale(name, clipped) - to_scale(name, positive)
    return np.hypot(np.std(deviations, axis=0, ddof=1), _LEAST_SCATTER), deviations.mean(axis=0)


def _gradient_variances(heights: np.ndarray, steps: tuple[float, float]) -> dict[int, float]:
    """Return number of pieces of a map (m) -> variance of ln(rms gradient) between them."""
    squares = np.zeros([max(n - 1, 1) for n in heights.shape])
    for axis, step in enumerate(steps):
        if heights.shape[axis] > 1:
            slope = np.diff(heights, axis=axis) / step
            squares += slope[: squares.shape[0], : squares.shape[1]] ** 2
    variances = {}
    for cuts in _CUTS:
        if any(1 < n < cuts * _MIN_POINTS_PER_SIDE - 1 for n in squares.shape):
            continue
        pieces = [squares]
        for axis in (axis for axis, n in enumerate(squares.shape) if n > 1):
            pieces = [half for piece in pieces for half in np.array_split(piece, cuts, axis=axis)]
        logarithms = [0.5 * math.log(max(piece.mean(), 1e-300)) for piece in pieces]
        variances[len(pieces)] = float(np.var(logarithms, ddof=1))
    return variances


def _at_the_size_of_the_map(variances: Mapping[int, float]) -> float:
    """Return ln of the standard deviation that maps of this size are expected to have, from var(n) = a + b n.

    Each variance has a relative error of sqrt(2/(n - 1)), and is weighted by its inverse.
    """
    if len(variances) < 2:
        return math.log(0.1)
    number, variance = (np.array(column, float) for column in zip(*variances.items(), strict=True))
    weight = np.sqrt(number - 1) / np.maximum(variance, 1e-6)
    columns = np.column_stack([np.ones(number.size), number])
    (a, b), _ = scipy.optimize.nnls(columns * weight[:, None], variance * weight)
    return 0.5 * math.log(a + b + 1e-4)


def _relevelled(area: xr.DataArray, order: int) -> xr.DataArray:
    """Return a subwindow of a levelled map with the same form removed again; no other step is repeated."""
    if not order:
        return area
    coordinates = [np.arange(n, dtype=float) for n in area.shape]
    return area.copy(data=area.values - fit_polynomial(area.values, coordinates, order=order)[0])


def divided(region: Slices, step: tuple[float, float], number: int, shortest: float = 0.0) -> list[Slices]:
    """Return the subwindows of a window, with the largest product of their number and squareness.

    `step` is the pitch (dy, dx), `shortest` the shortest wavelength that is kept (m): a subwindow has
    `_MIN_POINTS_PER_SIDE` points along each side, and two such waves.
    """
    sides = [region[axis].stop - region[axis].start for axis in "yx"]
    limits = [
        max(1, int(n / max(_MIN_POINTS_PER_SIDE, 2 * shortest / s))) if n > 1 else 1
        for n, s in zip(sides, step, strict=True)
    ]

    def score(cut: Iterable[int]) -> tuple[float, tuple[int, ...]]:
        lengths = [n * s / k for n, s, k in zip(sides, step, cut, strict=True)]
        return math.prod(cut) * (1.0 if 1 in sides else min(lengths) / max(lengths)), tuple(cut)

    pairs = product(*(range(1, min(number, limit) + 1) for limit in limits))
    cuts = [cut for cut in pairs if math.prod(cut) <= number]
    rows, columns = (
        [slice(region[axis].start + i * n // k, region[axis].start + (i + 1) * n // k) for i in range(k)]
        for axis, n, k in zip("yx", sides, max(cuts, key=score), strict=True)
    )
    return [{"y": y, "x": x} for y, x in product(rows, columns)]
