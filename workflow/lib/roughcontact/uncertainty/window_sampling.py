"""Uncertainty from the window: a map is a sample of its surface, another place would give another result.

The window is cut into parts (3 x 3), each of which is levelled, made periodic and solved at the same mean
pressures as the window itself. Let the window have m times the points of a part, and r = sqrt(m) times its
length (r = m for a profile). Two things are learned from the parts.

* Scatter. Parts that are longer than the waves of the surface are independent samples, so that the variance
  of the window's result is 1/m of that among the parts. With waves up to 0.6 of the window that is what
  windows do: docs/explanation/uncertainty.md.
* Size. Where the mean of the parts differs from the result by d, small windows are biased: they miss long
  waves, and more of them lies near a seam. A bias that falls as 1/length leaves d/(r - 1) in the window.
  Twice that is taken for the half-width of a uniform distribution (JCGM 100:2008, 4.3.7).

The largest pressure is no mean: it grows with the window without end. Its uncertainty is that of the largest
pressure in windows of this size. The largest of n normal numbers lies at sqrt(2 ln n) and scatters as
1/sqrt(2 ln n) standard deviations (Gumbel, Statistics of Extremes, 1958): scatter times value is the same in
any window, which carries the scatter of the parts' peaks over to that of the window's.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from scipy.special import stdtrit

from roughcontact.choices import LevelForm
from roughcontact.errors import SettingsError
from roughcontact.levelling.level import level
from roughcontact.maps import spacing
from roughcontact.quantities import percent
from roughcontact.uncertainty.ensemble import scale_to, shown_part, solve_member
from roughcontact.uncertainty.headline import QUANTITIES
from roughcontact.window.periodic_window import periodic_window

_TOLERANCE = 1e-2  # of the pressure: 0.4 % of a part's area (rms), where parts differ by 5 % and more
_LEAST_POINTS = 12  # along the side of a part
_LEAST_WAVES = 2  # of the shortest wavelength that is kept, along the side of a part
_BIAS = 2.0  # half-width of what the size may leave, over d/(r - 1)
_COVERAGE = 0.95
_STILL_GROWING = 0.3  # share by which the size may leave the mean gap off: then waves are too long

Part = dict[str, slice]  # rows ("y") and columns ("x") of a map


def window_uncertainty(
    levelled: xr.DataArray,
    *,
    window: Mapping[str, Any],
    contact: Mapping[str, Any],
    solved: xr.Dataset,
    number: int = 9,
) -> xr.Dataset:
    """Return the expanded uncertainty of the result of a window as a sample of its surface.

    U^2 = (t s)^2 / m + (2 b)^2 / 3 [1]_ with s the standard deviation of the parts' results, scaled to the
    result of the window, t of Student for 95 % and one less than their number, b = 2 d/(r - 1); largest
    pressure: U = t s (mean of the parts' peaks) / peak [2]_, s as it is. The head of this module explains
    all.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.
    window, contact : dict
        keyword arguments of `periodic_window` and `solve_contact` (loads included) that led to the result.
    solved : Dataset
        the result: `QUANTITIES` along `load`.
    number : int
        parts at most, 4 or more; 9 cut a map into 3 x 3 and a profile into 9.

    Returns
    -------
    Dataset
        along `load` the expanded uncertainty of each of the four quantities, NaN where the window is too
        small to be cut; along (member, load) the results of the parts as they are, `{name}_members`; along
        `member` the parts' `member_offset_y`, `member_offset_x`, `member_length_y`, `member_length_x` (m, in
        the map, with the band that making them periodic takes). Attributes: `coverage_factor` (t),
        `degrees_of_freedom`, `map_share` (of the map that the parts cover), `reason` (what was done, in
        words), `flag` (what is wrong with it, in words; empty where nothing is), `work` (FFT pairs times
        points).

    Raises
    ------
    SettingsError
        where `number` is below 4.
    ConvergenceError
        where the solve of a part misses its tolerance.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement, 4.3.7 and 5.1.2.
    .. [2] Gumbel (1958), Statistics of Extremes.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.uncertainty.headline import headline
    >>> levelled = level(rough_reference_surface(64))
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> solved = solve_contact(levelled, **problem, reduce=headline)
    >>> found = window_uncertainty(levelled, window={}, contact=problem, solved=solved)
    >>> found.sizes["member"], round(found.attrs["coverage_factor"], 2)
    (9, 2.31)
    """
    if number != int(number) or number < 4:
        raise SettingsError(f"windows = {number!r}: give a whole number of 4 or more")
    whole = shown_part(levelled, periodic_window(levelled, **window))
    parts = _cut(whole, spacing(levelled), int(number), window.get("shortest_wavelength") or 0.0)
    form: LevelForm = "none" if levelled.attrs["form"] in ("none", "mean") else "plane"
    own = {**window, "placement": "largest", "min_share": 0.0}
    members, points = [], []
    for part in parts:
        again = level(levelled.isel(part), form=form, outlier_threshold=None, fill="none")
        periodic = periodic_window(again, **own)
        points.append(math.prod(_sides(shown_part(again, periodic))))
        members.append(solve_member(periodic, contact, tolerance=_TOLERANCE))
    sides = _sides(whole)
    more = float(math.prod(sides) / np.mean(points))
    freedom = len(parts) - 1
    factor = float(stdtrit(freedom, (1 + _COVERAGE) / 2)) if freedom else math.nan
    dims = sum(n > 1 for n in sides)
    result: dict[str, tuple] = {}
    bias = {}
    for name in QUANTITIES:
        values = np.array([member.values[name] for member in members])
        half_width, bias[name] = _half_width(name, values, solved[name].values, more, factor, dims)
        result |= {name: ("load", half_width), f"{name}_members": (("member", "load"), values)}
    incomplete = bool(np.isnan(result["mean_gap"][1]).any())
    grows = bool((bias["mean_gap"] > _STILL_GROWING * _open(solved)).any())
    covered = sum(math.prod(levelled.isel(part).shape) for part in parts) / levelled.size
    return xr.Dataset(
        result | _places(levelled, parts),
        coords={"mean_pressure": ("load", np.asarray(solved["mean_pressure"].values, float))},
        attrs={
            "coverage_factor": factor,
            "degrees_of_freedom": freedom,
            "map_share": covered,
            "reason": _reason(levelled, parts, covered),
            "flag": _flag(levelled, parts, incomplete, grows),
            "work": sum(member.work for member in members),
        },
    )


def _half_width(
    name: str, values: np.ndarray, result: np.ndarray, more: float, factor: float, dims: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the expanded uncertainty of a quantity (load), and what the size of the window may leave of it.

    values: (member, load); more: points of the window over those of a part.
    """
    if len(values) < 2:
        return np.full(result.shape, np.nan), np.full(result.shape, np.nan)
    mean = values.mean(axis=0)
    if name == "max_pressure":
        return factor * values.std(axis=0, ddof=1) * np.minimum(1, mean / result), np.zeros(result.shape)
    scatter = scale_to(result, values, base=mean).std(axis=0, ddof=1) / math.sqrt(more)
    bias = _BIAS * np.abs(mean - result) / (more ** (1 / dims) - 1)
    return np.hypot(factor * scatter, 2 * bias / math.sqrt(3)), bias


def _sides(part: Part) -> list[int]:
    """Return the points (ny, nx) of a part."""
    return [part[d].stop - part[d].start for d in "yx"]


def _cut(whole: Part, step: tuple[float, float], number: int, shortest: float) -> list[Part]:
    """Return the parts of a window as {dim: slice}: where their number times their squareness is largest."""
    sides = _sides(whole)
    most = [
        max(1, int(n / max(_LEAST_POINTS, _LEAST_WAVES * shortest / s))) if n > 1 else 1
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
    """Return the shorter length of a part over the longer one; 1 for a profile."""
    return 1.0 if 1 in sides else min(length_y, length_x) / max(length_y, length_x)


def _places(levelled: xr.DataArray, parts: list[Part]) -> dict[str, tuple]:
    """Return the variables that say where the parts lie in the map."""
    found = {}
    for d, step in zip("yx", spacing(levelled), strict=True):
        found[f"member_offset_{d}"] = ("member", [part[d].start * step for part in parts])
        found[f"member_length_{d}"] = ("member", [(part[d].stop - part[d].start) * step for part in parts])
    return found


def _reason(levelled: xr.DataArray, parts: list[Part], covered: float) -> str:
    """Return what was done, in words."""
    ny, nx = levelled.isel(parts[0]).shape
    if len(parts) == 1:
        return f"The window of {nx} x {ny} points is too small to be cut into parts."
    return (
        f"{len(parts)} parts of about {nx} x {ny} points, {percent(covered)} of the map, each levelled, made "
        "periodic and solved by itself; their scatter, and how far their mean is from the whole."
    )


def _open(solved: xr.Dataset) -> np.ndarray:
    """Return the mean gap (load), infinite in full contact."""
    gap = solved["mean_gap"].values
    return np.where(gap > 0, gap, np.inf)


def _flag(levelled: xr.DataArray, parts: list[Part], incomplete: bool, grows: bool) -> str:
    """Return what is wrong with the ensemble, in words; empty where nothing is."""
    ny, nx = levelled.isel(parts[0]).shape
    if len(parts) == 1:
        return (
            f"The map is too small to tell how far its result stands for the surface: {nx} x {ny} points "
            "make no ensemble of windows. Measure more places, or a larger one."
        )
    if incomplete:
        return "Part of the ensemble of windows missed the tolerance."
    if grows:
        return (
            "The mean gap grows with the window: the surface has waves about as long as the window or "
            "longer. The interval holds for waves up to the length of the map."
        )
    return ""
