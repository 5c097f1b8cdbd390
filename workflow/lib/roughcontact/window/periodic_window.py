"""The periodic window: the part of a levelled map that is solved, made periodic."""

import json
import math
from functools import partial

import numpy as np
import xarray as xr

from roughcontact.checking import check_choice, check_map
from roughcontact.choices import Placement, WindowMethod
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.levelling.forms import form_from_record
from roughcontact.levelling.polynomial import share_of_form
from roughcontact.maps import spacing
from roughcontact.roughness.parameters import interior_rms_gradient, rms_gradient, steepest_share
from roughcontact.window import periodisation
from roughcontact.window.band import limit_band
from roughcontact.window.search import search_window

_FADES = ("smooth-cross-fade", "cross-fade")  # need a band beyond the window

# The solver halves a grid while both sides are even; a side should come down to about this many points.
_COARSE = 32
# What one further halving is worth, as a share of the side.
_HALVING = 0.02
# Candidates of the search that are kept in the record, besides the largest rectangle.
_KEPT = 6


def periodic_window(
    levelled: xr.DataArray,
    *,
    placement: Placement = "largest",
    method: WindowMethod = "smooth-cross-fade",
    width: float = 0.1,
    min_share: float = 0.05,
    shortest_wavelength: float | None = None,
    longest_wavelength: float | None = None,
    reliable_band: bool = False,
) -> xr.DataArray:
    """Cut out a rectangle without missing points and make it periodic.

    The rectangle is the largest one, or the best one of a search (`roughcontact.window.search`). Its sides
    are numbers whose Fourier transform is fast; those of the largest one halve well, too. A map that is
    periodic already, as it is or with the form put back that levelling took off, is left as it is.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`; NaN where missing.
    placement : {"largest", "search"}
        the largest rectangle without missing points, or the position and size with the best score.
    method : {"smooth-cross-fade", "periodic-plus-smooth", "cross-fade", "mirror", "taper", "raw"}
        see `roughcontact.window.periodisation`; raw changes nothing and leaves the steps at the seams.
    width : float, 0 to 0.5
        share of the side over which the two cross-fades blend or `taper` falls; the other methods have none.
    min_share : float, 0 to 1
        least share of the map that the rectangle must have.
    shortest_wavelength, longest_wavelength : float (m) or None
        waves outside this band are taken out of the window; None sets no limit.
    reliable_band : bool
        waves that are shorter than the map shows reliably are taken out. See `roughcontact.window.band`.

    Returns
    -------
    DataArray (y, x), m, with the attributes of `levelled` and `periodisation`, `periodisation_rms_change`
    (m), `periodisation_relative_change` (of the rms height), `rms_gradient_before` (of the part that was
    cut out, without its edges), `rms_gradient_after` (of the window as it is solved),
    `form_share` (of the mean square height of the window, the part that a second-order polynomial makes up),
    `steepest_share` (of its mean square gradient, the part that the steepest 1 % of the points make up),
    `band_shortest`, `band_longest` (m, the waves that are left), `band_reason` (what limits them),
    `band_removed_rms_height` (m), `band_removed_rms_gradient`, `reliable_wavelength` (m), `window_offset_x`,
    `window_offset_y` (m), `window_share`, `window_reason`, and after a search `window_scores` (JSON: the best
    candidates and the largest rectangle, with the parts of their scores); the coordinate `filled` is cut as
    well.

    Raises
    ------
    HeightMapError
        no rectangle of two points, or none as large as `min_share`.
    SettingsError
        an option that has no meaning.
    """
    check_choice("window.placement", placement, Placement)
    check_choice("window.method", method, WindowMethod)
    if not 0 <= width <= 0.5:
        raise SettingsError(f"window.width = {width!r}: give a share of the side from 0 to 0.5")
    if not 0 <= min_share <= 1:
        raise SettingsError(f"window.min_share = {min_share!r}: give a share from 0 to 1")
    values = check_map(levelled)
    waves = {"shortest": shortest_wavelength, "longest": longest_wavelength, "reliable": reliable_band}
    unchanged = _already_periodic(levelled, values, waves)
    if unchanged is not None:
        return unchanged

    fade = width if method in _FADES else 0.0
    flags = (
        levelled["filled"].values if "filled" in levelled.coords else np.zeros(values.shape, dtype=np.int8)
    )
    start, sides = _largest(levelled, values, fade, min_share)
    scores = None
    if placement == "search":
        found = search_window(values, flags, (start, sides), friendly=is_friendly, band=partial(_band, fade))
        least = min_share * values.size
        found = [c for c in found if _points(c.sides, fade) >= least]
        scores = _scores(found, (start, sides), fade, spacing(levelled))
        start, sides = found[0].start, found[0].sides
    band = [_band(fade, side) for side in sides]
    used = [side + b for side, b in zip(sides, band, strict=True)]
    cut = levelled.isel({d: slice(s, s + u) for d, s, u in zip("yx", start, used, strict=True)})
    flags = flags[tuple(slice(s, s + u) for s, u in zip(start, used, strict=True))]
    heights = np.asarray(cut.values, dtype=float)
    step = spacing(levelled)

    # the part that stays, where it stays
    kept = tuple(slice(b // 2, b // 2 + side) for b, side in zip(band, sides, strict=True))
    before = heights[kept]
    if method == "mirror":
        after, flags = periodisation.mirror(heights), periodisation.mirror(flags)
    elif method in _FADES:
        fading = periodisation.cross_fade(flags.astype(float), band)
        flags = (fading > 1e-9).astype(np.int8)
        if method == "cross-fade":
            after = periodisation.cross_fade(heights, band)
        else:
            after = periodisation.smooth_cross_fade(heights, band, step)
    elif method == "taper":
        after = periodisation.taper(heights, width)
    elif method == "periodic-plus-smooth":
        after = periodisation.periodic_plus_smooth(heights, step)
    else:
        after = heights
    before_map = cut.isel(y=kept[0], x=kept[1])
    coords = {
        d: xr.Variable(d, before_map[d].values[0] + s * np.arange(n), cut[d].attrs)
        for d, s, n in zip("yx", step, after.shape, strict=True)
    }
    change = after[: before.shape[0], : before.shape[1]] - before
    window = _record(
        after,
        coords | {"filled": (("y", "x"), flags)},
        levelled.attrs,
        waves=waves,
        method=method,
        change=float(np.sqrt(np.mean(change**2))),
        gradient_before=interior_rms_gradient(before_map),
        offset=[(s + k.start) * d for s, k, d in zip(start, kept, step, strict=True)],
        share=used[0] * used[1] / values.size,
        reason=_reason(values, used, after.shape, method, searched=scores is not None),
    )
    return window if scores is None else window.assign_attrs(window_scores=scores)


def is_friendly(side: int) -> bool:
    """Return whether a side has no prime factor above 5, or is at most 32 points long."""
    return math.isfinite(_side_score(side))


def _band(fade, side):
    """Return the points of the band that a side needs for blending."""
    return round(fade * side) if side > 1 else 0


def _points(sides, fade):
    """Return the points of the map that a window and its bands need."""
    return math.prod(side + _band(fade, side) for side in sides)


def _largest(levelled, values, fade, min_share):
    """Return start and sides of the window in the largest rectangle without missing points."""
    fitting = friendly_sides(max(values.shape), extra=fade)
    y0, x0, height, breadth = largest_rectangle(~np.isnan(values), fitting)
    sides = int(fitting[height]), int(fitting[breadth])
    used = [side + _band(fade, side) for side in sides]
    _check_window(levelled, used, used[0] * used[1] / values.size, min_share)
    # in the middle of the rectangle
    return (y0 + (height - used[0]) // 2, x0 + (breadth - used[1]) // 2), sides


def _scores(found, largest, fade, step):
    """Return the record of a search: the best sizes and the largest rectangle, as JSON."""
    own = [c for c in found if (c.start, c.sides) == largest]
    shown = found[:_KEPT] + [c for c in own if c not in found[:_KEPT]]
    rows = [
        {
            "points": list(c.sides),
            "offset": [(s + _band(fade, n) // 2) * d for s, n, d in zip(c.start, c.sides, step, strict=True)],
            "largest_rectangle": (c.start, c.sides) == largest,
            "score": c.score,
            **c.parts,
        }
        for c in shown
    ]
    return json.dumps(rows)


def friendly_sides(longest: int, *, extra: float = 0.0) -> np.ndarray:
    """Return for each number of points 0 ... longest the best side of a window that fits into it.

    Sides have no prime factor above 5. Among those the largest is taken, but one that can be halved once
    more, down to 32 points, may be 2 % shorter. Up to 32 points any side is good.

    Parameters
    ----------
    longest : int
    extra : float
        share of the side that must fit in besides (the band of a cross-fade).

    Returns
    -------
    sides : int array (longest + 1,)
    """
    sides = np.zeros(longest + 1, dtype=int)
    best, best_score = 0, -math.inf
    for points in range(1, longest + 1):
        side = points if extra == 0 else _largest_side(points, extra)
        score = _side_score(side)
        if score >= best_score:
            best, best_score = side, score
        sides[points] = best
    return sides


def _largest_side(points, extra):
    """Return the largest side for which side + round(extra side) <= points."""
    side = int(points / (1 + extra)) + 1
    while side > 1 and side + round(extra * side) > points:
        side -= 1
    return side


def _side_score(side):
    if side <= _COARSE:
        return math.log(side)
    rest = side
    for factor in (2, 3, 5):
        while rest % factor == 0:
            rest //= factor
    if rest > 1:
        return -math.inf
    coarsest = side
    while coarsest % 2 == 0 and coarsest > _COARSE:
        coarsest //= 2
    return math.log(side) - _HALVING * max(0.0, math.log2(coarsest / _COARSE))


def largest_rectangle(good, sides) -> tuple[int, int, int, int]:
    """Return (y0, x0, height, width) of the rectangle of good points that holds the largest window.

    Row by row, the tallest column of good points that ends in each cell is widened as far as it goes; one of
    these holds the largest rectangle. The work is a few array operations per row.

    Parameters
    ----------
    good : bool array (ny, nx)
    sides : int array
        `sides[n]` is the side of the window that fits into n points; its area is what counts.

    Notes
    -----
    The maximal rectangle problem: Vandevoorde, Dr. Dobb's Journal 23(4) (1998).
    """
    ny, nx = good.shape
    columns = np.arange(nx)
    tall = np.zeros(nx, dtype=int)
    left = np.zeros(nx, dtype=int)
    right = np.full(nx, nx)
    best, best_area = (0, 0, 0, 0), 0
    for row in range(ny):
        here = good[row]
        if not here.any():
            tall[:], left[:], right[:] = 0, 0, nx
            continue
        # one past the last bad cell to the left, and the first bad cell to the right
        from_left = np.maximum.accumulate(np.where(here, 0, columns + 1))
        to_right = np.minimum.accumulate(np.where(here, nx, columns)[::-1])[::-1]
        tall = np.where(here, tall + 1, 0)
        left = np.where(here, np.maximum(left, from_left), 0)
        right = np.where(here, np.minimum(right, to_right), nx)
        area = np.where(here, sides[tall] * sides[right - left], 0)
        column = int(np.argmax(area))
        if area[column] > best_area:
            best_area = int(area[column])
            y0, x0 = row + 1 - tall[column], left[column]
            best = (int(y0), int(x0), int(tall[column]), int(right[column] - x0))
    return best


def _already_periodic(levelled, values, waves):
    """Return the map as a window where it is periodic, with or without its form; else None."""
    attrs = dict(levelled.attrs)
    removed = json.loads(attrs.get("form_removed", "{}"))
    form = form_from_record(removed, levelled["y"].values, levelled["x"].values)
    found = periodisation.periodic_heights(values, form)
    if found is None:
        return None
    values, put_back = found
    reason = "The map is periodic as it is; it was left alone."
    if put_back:
        reason = (
            "The map is periodic as measured: the form that levelling had taken off was put back but for its "
            "mean, and the map left alone."
        )
        attrs |= {"form": "mean", "form_removed": json.dumps({"mean": removed["mean"]})}
    flags = levelled.coords.get("filled", np.zeros(values.shape, dtype=np.int8))
    coords = {"y": levelled["y"], "x": levelled["x"], "filled": (("y", "x"), np.asarray(flags))}
    return _record(
        values,
        coords,
        attrs,
        waves=waves,
        method="none",
        change=0.0,
        gradient_before=None,
        offset=(0.0, 0.0),
        share=1.0,
        reason=reason,
    )


def _record(values, coords, attrs, *, waves, method, change, gradient_before, offset, share, reason):
    periodic = xr.DataArray(values, dims=("y", "x"), coords=coords, name="height", attrs=attrs)
    whole_gradient, rms = rms_gradient(periodic), float(np.std(values))
    window = limit_band(periodic, **waves)
    window.attrs |= {
        "periodisation": method,
        "periodisation_rms_change": change,
        "periodisation_relative_change": change / rms if rms > 0 else 0.0,
        "rms_gradient_before": whole_gradient if gradient_before is None else gradient_before,
        "rms_gradient_after": rms_gradient(window),
        "steepest_share": steepest_share(window),
        "form_share": share_of_form(window.values, (window["y"].values, window["x"].values)),
        "window_offset_x": float(offset[1]),
        "window_offset_y": float(offset[0]),
        "window_share": float(share),
        "window_reason": reason,
    }
    return window


def _check_window(levelled, used, share, min_share):
    name = levelled.attrs.get("source_file") or "the map"
    if used[0] * used[1] < 2:
        raise HeightMapError(f"{name}: no two neighbouring points are measured: fill it with level.fill")
    if share < min_share:
        raise HeightMapError(
            f"{name}: the largest rectangle without missing points has {used[1]} x {used[0]} points, "
            f"{100 * share:.1f} % of the map, less than window.min_share = {min_share:g}: fill the holes "
            "(level.fill), cut the map to its measured part, or lower window.min_share"
        )


def _reason(values, used, solved, method, *, searched):
    ny, nx = values.shape
    if (ny, nx) == tuple(used):
        text = f"The whole map of {nx} x {ny} points is used"
    else:
        missing = np.isnan(values).any()
        if searched:
            why = "the best score of the search"
        elif missing:
            why = "the largest rectangle without missing points, with sides that transform and halve well"
        else:
            why = "sides that transform and halve well"
        text = f"{used[1]} x {used[0]} of {nx} x {ny} points are used: {why}"
    text += f"; made periodic by {method}" if method != "raw" else "; its edges are left as they are"
    if tuple(solved) != tuple(used):
        text += f", which leaves {solved[1]} x {solved[0]} points"
    return text + "."
