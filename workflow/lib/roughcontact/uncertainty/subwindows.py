"""Scatter of the results within a map, of its subwindows as if each was measured alone, and its words.

On a stationary surface the map, n times as large, scatters s/sqrt(n), s the scatter of n subwindows longer
than its longest wave; most surfaces differ on every length. The variances of the rms gradient of 4, 9, 16 and
36 subwindows are fitted by var(n) = a + b n, a, b >= 0, var(1) being that of maps of this size. This, the
scatter of the solved subwindows (3 x 3) and their trend are the features of the calibrated arms
(`calibration`).
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments import quantities
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.rows import rows_beside
from roughcontact.errors import SettingsError
from roughcontact.surface.levelling.forms import form_order
from roughcontact.surface.levelling.polynomial import fit_polynomial
from roughcontact.surface.window.periodic_window import subwindow
from roughcontact.uncertainty.calibration import Features, Measurand
from roughcontact.uncertainty.ensemble import Result, Values, measured_slices
from roughcontact.uncertainty.scales import AREA, GAP, PEAK, to_scale

_MIN_POINTS_PER_SIDE = 12  # of a subwindow
_CUTS = (2, 3, 4, 6)  # of the sides, for statistics without a solution
_POINTS_IN_MEMORY = 2**22  # of a map that is read from its file
_MIN_SCATTER = 0.02  # of a logarithm, and of a result that is not closed; less is chance
MEASURAND_IN_WORDS = "the mean of maps of this size all over the surface, in the band of waves of this map"
_KURTOSIS_LIMIT = 8.0  # above it a few places hold most of the mean square height
_SENTENCES = {case: sentences for case, *sentences in rows_beside(__file__, "sample.tsv")}
_LAY_LIMIT = 0.07  # texture aspect ratio below which the subwindows along a lay hold the same ridges

Slices = dict[str, slice]  # rows ("y") and columns ("x") of a map


class Scatter(NamedTuple):
    """What the subwindows of a map, or other members, show of each quantity."""

    members: dict[str, np.ndarray]  # results (member, load), NaN where one missed its tolerance
    features: Mapping[str, Features] = MappingProxyType({})  # (load) of calibrated arms
    slices: Sequence[Slices] = ()  # rows and columns of each subwindow in the map
    # of surfaces behind profiles and of overviews: how far the truth of each measurand lies below and above,
    # what they move the result by, and the joint from there (load), on the scale; places in mean gaps
    arms: Mapping[Measurand, Mapping[str, tuple[np.ndarray, np.ndarray]]] = MappingProxyType({})
    shift: Values = MappingProxyType({})
    joint: Values = MappingProxyType({})
    overview: str = ""  # what it is, in words
    reason: str = ""  # what the members are, if no subwindows
    of_positions: bool = False  # other positions, which say nothing of this one
    open_ended: Mapping[str, np.ndarray] = MappingProxyType({})  # whether grooves lead out of the map (load)


def scatter_of_subwindows(
    result: Result, levelled_map: xr.DataArray, *, arguments: Mapping[str, Any], number: int = 9
) -> Scatter:
    """Return the scatter of the results of at most `number` (4 or more) subwindows of a map.

    `arguments` are those of `periodic_window` that led from the levelled map to the window.
    """
    if number != int(number) or number < 4:
        raise SettingsError(f"windows = {number!r}: give a whole number of 4 or more")
    region = measured_slices(levelled_map, result.window)
    slices = divided(region, spacing(levelled_map), int(number), arguments.get("shortest_wavelength") or 0.0)
    order = form_order(levelled_map)
    if len(slices) < 2:
        nan_values = np.full((len(slices), result.load.size), np.nan)
        return Scatter(dict.fromkeys(result.values, nan_values), slices=slices)
    subwindows = (subwindow(relevelled(levelled_map.isel(area), order), **arguments) for area in slices)
    members = result.members(subwindows)
    deviations = {name: _deviations(name, members[name], result.values[name]) for name in (AREA, PEAK)}
    spread = np.hypot(np.std(deviations[AREA], axis=0, ddof=1), _MIN_SCATTER)
    common: Features = {"gradient": gradient_scatter(levelled_map.isel(region)), "scatter": np.log(spread)}
    features = dict.fromkeys(result.values, common)
    features[PEAK] = {**common, "trend": deviations[PEAK].mean(axis=0)}
    return Scatter(members, features, slices)


def _deviations(name: str, members: np.ndarray, result: np.ndarray) -> np.ndarray:
    """Return by how much the members (member, load) differ from the result, on the scale."""
    positive = np.where(result > 0, result, 1.0)
    positive_members = np.where(np.isnan(members), positive, np.fmax(members, _MIN_SCATTER * positive))
    return to_scale(name, positive_members) - to_scale(name, positive)


def gradient_scatter(height: xr.DataArray) -> float:
    """Return ln of the scatter of ln(rms gradient) that maps (m) of its size are expected to have.

    It is extrapolated from the variances between pieces of it.
    """
    squares, steps = np.zeros([max(n - 1, 1) for n in height.shape]), spacing(height)
    number = max(1, _POINTS_IN_MEMORY // height.shape[1])
    for start in range(0, len(squares), number):  # a large map is read from its file a few rows at a time
        rows, block = height[start : start + number + 1].values, squares[start : start + number]
        for axis, step in enumerate(steps):
            if rows.shape[axis] > 1:
                slope = np.diff(rows, axis=axis) / step
                block += slope[: block.shape[0], : block.shape[1]] ** 2
    variances = {}
    for cuts in _CUTS:
        if any(1 < n < cuts * _MIN_POINTS_PER_SIDE - 1 for n in squares.shape):
            continue
        pieces = [squares]
        for axis in (axis for axis, n in enumerate(squares.shape) if n > 1):
            pieces = [half for piece in pieces for half in np.array_split(piece, cuts, axis=axis)]
        logarithms = [0.5 * math.log(max(piece.mean(), 1e-300)) for piece in pieces]
        variances[len(pieces)] = float(np.var(logarithms, ddof=1))
    return _extrapolate_deviation(variances)


def _extrapolate_deviation(variances: Mapping[int, float]) -> float:
    """Return ln of the standard deviation that maps are expected to have, from variances var(n) = a + b n.

    Each variance has a relative error of sqrt(2/(n - 1)), and is weighted by its inverse.
    """
    if len(variances) < 2:
        return math.log(0.1)
    number, variance = (np.array(column, float) for column in zip(*variances.items(), strict=True))
    weight = np.sqrt(number - 1) / np.maximum(variance, 1e-6)
    columns = np.column_stack([np.ones(number.size), number])
    rows, right = columns * weight[:, None], variance * weight
    a, b = np.linalg.lstsq(rows, right)[0]
    if min(a, b) < 0:  # which no variance is: the other one alone, as by nnls, whose import takes long
        a, b = rows.T @ right / (rows**2).sum(axis=0) * (b < a, a < b)
    return 0.5 * math.log(a + b + 1e-4)


def relevelled(area: xr.DataArray, order: int) -> xr.DataArray:
    """Return a subwindow of a levelled map with the same form removed again; no other step is repeated."""
    if not order:
        return area
    coordinates = [np.arange(n, dtype=float) for n in area.shape]
    return area.copy(deep=False, data=area.values - fit_polynomial(area.values, coordinates, order=order)[0])


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
        # equal ones differ by rounding
        return round(math.prod(cut) * (1.0 if 1 in sides else min(lengths) / max(lengths)), 9), tuple(cut)

    pairs = product(*(range(1, min(number, limit) + 1) for limit in limits))
    best = max((cut for cut in pairs if math.prod(cut) <= number), key=score)
    pieces = []
    for axis, n, k in zip("yx", sides, best, strict=True):
        borders = [region[axis].start + i * n // k for i in range(k + 1)]
        pieces.append(map(slice, borders[:-1], borders[1:]))
    return [{"y": y, "x": x} for y, x in product(*pieces)]


def sample_attributes(scatter: Scatter, height: xr.DataArray, *, aspect: float) -> dict[str, Any]:
    """Return what is said of the members of a map of a texture aspect ratio, and what they do not tell.

    `window_advice`, with which `window_flag` ends, is what to do about that.
    """
    has_failure = np.isnan(scatter.members[GAP]).any()
    if scatter.reason:
        flag = "The solution of a surface missed the tolerance." if has_failure else ""
        return {"window_reason": scatter.reason, "window_flag": flag}
    ny, nx = height.isel(scatter.slices[0]).shape
    coverage = sum(math.prod(height.isel(area).shape) for area in scatter.slices) / height.size
    kurtosis = height.attrs.get("Sku", 3.0)
    facts = {
        "measurand": MEASURAND_IN_WORDS,
        "points": f"{nx} × {ny} points",
        "parts": len(scatter.slices),
        "share": quantities.percent(coverage),
        "axes": " and ".join(name[-1] for name in scatter.open_ended),
        "kurtosis": quantities.number(kurtosis),
    }
    if len(scatter.slices) == 1:
        return {"window_reason": _SENTENCES["undivided"][0].format(**facts), **_flagged("small", facts)}
    reasons = [_SENTENCES["divided"][0].format(**facts), scatter.overview]
    if scatter.open_ended:
        reasons.append(_SENTENCES["grooves"][0].format(**facts))
    cases = {"failed": has_failure, "pits": kurtosis > _KURTOSIS_LIMIT, "lay": aspect < _LAY_LIMIT}
    deficiency = next((case for case, holds in cases.items() if holds), "none")
    return {"window_reason": " ".join(filter(None, reasons)), **_flagged(deficiency, facts)}


def _flagged(case: str, facts: Mapping[str, Any]) -> dict[str, str]:
    """Return the attributes of a deficiency, and what to do about it, by its row of the table."""
    flag, advice = (text.format(**facts) for text in _SENTENCES[case])
    return {"window_flag": f"{flag} {advice}".strip(), "window_advice": advice}
