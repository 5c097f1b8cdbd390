"""The periodic window: the part of a levelled map that is solved, made periodic."""

import json
from collections.abc import Mapping, Sequence

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
from roughcontact.window.rectangle import largest_rectangle
from roughcontact.window.search import Candidate, search_window
from roughcontact.window.sides import band_points, friendly_sides, used_points

_FADES = ("smooth-cross-fade", "cross-fade")  # need a band beyond the window

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
    shortest_wavelength, longest_wavelength : float or None, m
        waves outside this band are taken out of the window; None sets no limit.
    reliable_band : bool
        waves that are shorter than the map shows reliably are taken out. See `roughcontact.window.band`.

    Returns
    -------
    DataArray (y, x), m
        with the coordinate `filled` of the part that was cut out, the attributes of `levelled`, and

        * `periodisation`, `periodisation_rms_change` (m), `periodisation_relative_change` (of the rms height)
        * `rms_gradient_before` (of the part that was cut out, without its edges), `rms_gradient_after` (of
          the window as it is solved)
        * `form_share` (of the mean square height of the window, the part that a second-order polynomial
          makes up), `steepest_share` (of its mean square gradient, the part that the steepest 1 % of the
          points make up)
        * `band_shortest`, `band_longest` (m, the waves that are left), `band_reason` (what limits them),
          `band_removed_rms_height` (m), `band_removed_rms_gradient`, `reliable_wavelength` (m)
        * `window_offset_x`, `window_offset_y` (m), `window_share`, `window_reason`, and after a search
          `window_scores` (JSON: the best candidates and the largest rectangle, with the parts of their
          scores)

    Raises
    ------
    HeightMapError
        no rectangle of two points, or none as large as `min_share`.
    SettingsError
        an option that has no meaning.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact.references.synthetic import self_affine_surface
    >>> large = self_affine_surface((200, 200), 1e-6, hurst=0.8, shortest=8e-6, longest=1e-4, rms_height=1e-7)
    >>> measured = large.isel(y=slice(110), x=slice(130))
    >>> window = rc.periodic_window(rc.level(measured), method="smooth-cross-fade")
    >>> window.shape, round(float(window.attrs["window_share"]), 3)
    ((100, 108), 0.915)
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
    start, sides = _largest(levelled, values, fade, min_share)
    missing = bool(np.isnan(values).any())
    scores = None
    if placement == "search":
        found = search_window(values, _flags(levelled), (start, sides), fade=fade)
        least = min_share * values.size
        found = [c for c in found if used_points(c.sides, fade) >= least]
        scores = _scores(found, (start, sides), fade, spacing(levelled))
        start, sides = found[0].start, found[0].sides
    del values  # of a large map there is no room for what is needed no more
    band = [band_points(side, fade) for side in sides]
    used = [side + b for side, b in zip(sides, band, strict=True)]
    cut = levelled.isel({d: slice(s, s + u) for d, s, u in zip("yx", start, used, strict=True)})
    step = spacing(levelled)

    # the part that stays, where it stays
    kept = tuple(slice(b // 2, b // 2 + side) for b, side in zip(band, sides, strict=True))
    before = cut.isel(y=kept[0], x=kept[1])
    after, flags = _made_periodic(cut, method, band, width, step)
    coords = {
        d: xr.Variable(d, before[d].values[0] + s * np.arange(n), cut[d].attrs)
        for d, s, n in zip("yx", step, after.shape, strict=True)
    }
    change = _rms_difference(after[: before.shape[0], : before.shape[1]], before.values)
    window = _record(
        after,
        coords | {"filled": (("y", "x"), flags)},
        levelled.attrs,
        waves=waves,
        method=method,
        change=change,
        gradient_before=interior_rms_gradient(before),
        offset=[(s + k.start) * d for s, k, d in zip(start, kept, step, strict=True)],
        share=used[0] * used[1] / levelled.size,
        reason=_reason(
            levelled.shape, used, after.shape, method, missing=missing, searched=scores is not None
        ),
    )
    return window if scores is None else window.assign_attrs(window_scores=scores)


def _flags(levelled: xr.DataArray) -> np.ndarray:
    """Return which points of the map were filled in."""
    if "filled" in levelled.coords:
        return levelled["filled"].values
    return np.zeros(levelled.shape, dtype=np.int8)


def _largest(
    levelled: xr.DataArray, values: np.ndarray, fade: float, min_share: float
) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return start and sides of the window in the largest rectangle without missing points."""
    fitting = friendly_sides(max(values.shape), fade=fade)
    y0, x0, height, breadth = largest_rectangle(~np.isnan(values), fitting)
    sides = int(fitting[height]), int(fitting[breadth])
    used = [side + band_points(side, fade) for side in sides]
    _check_window(levelled, used, used[0] * used[1] / values.size, min_share)
    # in the middle of the rectangle
    return (y0 + (height - used[0]) // 2, x0 + (breadth - used[1]) // 2), sides


def _made_periodic(
    cut: xr.DataArray, method: str, band: list[int], width: float, step: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the heights of a part of the map made periodic, and which of them rest on filled points."""
    heights, flags = np.asarray(cut.values, dtype=float), _flags(cut)
    if method == "mirror":
        return periodisation.mirror(heights), periodisation.mirror(flags)
    if method == "taper":
        return periodisation.taper(heights, width), flags
    if method == "periodic-plus-smooth":
        return periodisation.periodic_plus_smooth(heights, step), flags
    if method == "raw":
        return heights, flags
    if flags.any():  # a blended point rests on a filled one where that one has a weight
        flags = (periodisation.cross_fade(flags.astype(float), band) > 1e-9).astype(np.int8)
    else:
        flags = np.zeros([n - b for n, b in zip(flags.shape, band, strict=True)], dtype=np.int8)
    if method == "cross-fade":
        return periodisation.cross_fade(heights, band), flags
    return periodisation.smooth_cross_fade(heights, band, step), flags


def _scores(
    found: list[Candidate],
    largest: tuple[tuple[int, int], tuple[int, int]],
    fade: float,
    step: tuple[float, float],
) -> str:
    """Return the record of a search: the best sizes and the largest rectangle, as JSON."""
    own = [c for c in found if (c.start, c.sides) == largest]
    shown = found[:_KEPT] + [c for c in own if c not in found[:_KEPT]]
    rows = [
        {
            "points": list(c.sides),
            "offset": [
                (s + band_points(n, fade) // 2) * d for s, n, d in zip(c.start, c.sides, step, strict=True)
            ],
            "largest_rectangle": (c.start, c.sides) == largest,
            "score": c.score,
            **c.parts,
        }
        for c in shown
    ]
    return json.dumps(rows)


def _already_periodic(levelled: xr.DataArray, values: np.ndarray, waves: Mapping) -> xr.DataArray | None:
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
    coords = {"y": levelled["y"], "x": levelled["x"], "filled": (("y", "x"), _flags(levelled))}
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


def _record(
    values: np.ndarray,
    coords: Mapping,
    attrs: Mapping,
    *,
    waves: Mapping,
    method: str,
    change: float,
    gradient_before: float | None,
    offset: Sequence[float],
    share: float,
    reason: str,
) -> xr.DataArray:
    """Return the window limited to its band, with everything that was done to it in its attributes."""
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


def _check_window(levelled: xr.DataArray, used: Sequence[int], share: float, min_share: float) -> None:
    """Raise HeightMapError where the largest rectangle is none, or smaller than was asked for."""
    name = levelled.attrs.get("source_file") or "the map"
    if used[0] * used[1] < 2:
        raise HeightMapError(f"{name}: no two neighbouring points are measured: fill it with level.fill")
    if share < min_share:
        raise HeightMapError(
            f"{name}: the largest rectangle without missing points has {used[1]} x {used[0]} points, "
            f"{100 * share:.1f} % of the map, less than window.min_share = {min_share:g}: fill the holes "
            "(level.fill), cut the map to its measured part, or lower window.min_share"
        )


def _rms_difference(one: np.ndarray, other: np.ndarray) -> float:
    """Return the root mean square difference of two maps."""
    difference = one - other
    return float(np.sqrt(np.mean(np.square(difference, out=difference))))


def _reason(
    shape: Sequence[int],
    used: Sequence[int],
    solved: Sequence[int],
    method: str,
    *,
    missing: bool,
    searched: bool,
) -> str:
    """Return in words which part of the map is used, why, and how it was made periodic."""
    ny, nx = shape
    if (ny, nx) == tuple(used):
        text = f"The whole map of {nx} x {ny} points is used"
    else:
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
