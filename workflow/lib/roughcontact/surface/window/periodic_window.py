"""The periodic window: the part of a levelled map that is made periodic and solved."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_map
from roughcontact.arguments.choices import PERIODIC_BY, Placement, WindowMethod
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.measurement import json_attribute, json_attributes
from roughcontact.arguments.si import as_si
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.surface.levelling.forms import form_from_record
from roughcontact.surface.levelling.polynomial import share_of_form
from roughcontact.surface.roughness.heights import record_summit, renew_parameters
from roughcontact.surface.roughness.parameters import interior_rms_gradient, rms_gradient, steepest_share
from roughcontact.surface.roughness.summits import summit_that_stands_out
from roughcontact.surface.roughness.traces import instrument_traces
from roughcontact.surface.window import periodisation
from roughcontact.surface.window.band import in_band, limit_band
from roughcontact.surface.window.lay import lay_period, side_of_whole_periods
from roughcontact.surface.window.rectangle import largest_rectangle
from roughcontact.surface.window.sides import band_points, friendly_sides
from roughcontact.surface.window.transfer import corrected, share_of_noise

_BLENDING_METHODS = ("smooth-cross-fade", "cross-fade")  # need a band in addition to the window


class _Cut(NamedTuple):
    """The part of a map that becomes its window, in points along y and x."""

    start: list[int]
    sides: list[int]
    band: list[int]  # beyond the sides, over which both ends are blended
    shortened: bool  # to whole periods

    @property
    def used(self) -> list[int]:
        return [side + band for side, band in zip(self.sides, self.band, strict=True)]


@as_si
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
    correct_for: Mapping[str, Any] | None = None,
) -> xr.DataArray:
    """Cut out a rectangle without missing points and make it periodic.

    The rectangle is the largest one without missing points whose sides have a fast Fourier transform. A map
    that is already periodic, as it is or with the form restored that levelling removed, is not changed.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`; NaN where missing.
    placement : {"largest", "whole-periods"}
        ``whole-periods`` shortens a side across grooves or rows of dimples to a whole number of their periods
        (`roughcontact.surface.window.lay`), if a period repeats along it.
    method : {"smooth-cross-fade", "periodic-plus-smooth", "cross-fade", "mirror", "taper", "raw"}
        see `surface.window.periodisation`; `raw` changes nothing and keeps the steps at the seams.
    width : float, 0 to 0.5
        share of the side over which the two cross-fades blend or `taper` falls off; unused by other methods.
    min_share : float, 0 to 1
        minimum share of the map that the rectangle must cover.
    shortest_wavelength, longest_wavelength : float or None, m
        waves outside this band are removed from the window; None sets no limit.
    reliable_band : bool
        whether waves that the map does not resolve reliably are removed; see `surface.window.band`.
    correct_for : mapping, optional
        noise and transfer of an instrument that the window is corrected for, before waves are removed:
        `roughcontact.surface.window.transfer.corrected`. Its attributes then have `corrected_for`, in words.

    Returns
    -------
    DataArray (y, x), m
        with the coordinate `filled` of the cut-out, the attributes of `levelled`, and

        * `periodisation`, `periodisation_rms_change` (m), `periodisation_relative_change` (over the rms
          height)
        * `rms_gradient_before` (of the cut-out, without its edges), `rms_gradient_after` (of the window as it
          is solved)
        * `form_share` (contribution of a second-order polynomial to the mean square height of the window),
          `steepest_share` (contribution of the steepest 1 % of the points to its mean square gradient)
        * `band_shortest`, `band_longest` (m, limits of the remaining waves), `band_reason` (what limits
          them), `band_removed_rms_height` (m), `band_removed_rms_gradient`, `reliable_wavelength` (m)
        * what the instrument left in the map before waves were removed, by
          `roughcontact.surface.roughness.traces.instrument_traces`, and the summit that stands out, by
          `roughcontact.surface.roughness.summits.summit_that_stands_out`
        * `window_offset_x`, `window_offset_y` (m), `window_share`, `window_reason`

    Raises
    ------
    HeightMapError
        where no rectangle has two points, or none covers `min_share`.
    SettingsError
        for an invalid option.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact.surface.synthetic import self_affine_surface
    >>> large = self_affine_surface((200, 200), 1e-6, hurst=0.8, shortest=8e-6, longest=1e-4, rms_height=1e-7)
    >>> measured = large.isel(y=slice(110), x=slice(130))
    >>> window = rc.periodic_window(rc.level(measured), method="smooth-cross-fade")
    >>> window.shape, round(float(window.attrs["window_share"]), 3)
    ((100, 108), 0.923)
    """
    if not 0 <= width <= 0.5:
        raise SettingsError(f"window.width = {width!r}: give a share of the side from 0 to 0.5")
    if not 0 <= min_share <= 1:
        raise SettingsError(f"window.min_share = {min_share!r}: give a share from 0 to 1")
    values = check_map(levelled)
    levelled = renew_parameters(levelled)
    waves = {"shortest_wavelength": shortest_wavelength, "longest_wavelength": longest_wavelength}
    waves |= {"reliable_band": reliable_band}
    if already := _already_periodic(levelled, values):
        window, reason = already
        return _record(window, waves, correct_for, {"window_reason": reason})

    fade = width if method in _BLENDING_METHODS else 0.0
    cut = _largest_cut(levelled, values, fade, min_share, whole_periods=placement == "whole-periods")
    missing = bool(np.isnan(values).any())
    del values  # memory may not hold more than is needed of a large map
    periodic_map = _cut_out(levelled, cut, method=method, width=width)
    offsets = [s + b // 2 for s, b in zip(cut.start, cut.band, strict=True)]
    cut_map = levelled.isel({d: slice(o, o + n) for d, o, n in zip("yx", offsets, cut.sides, strict=True)})
    # over the cut alone: a mirrored map is larger, and its images change nothing
    change = periodic_map.values[: cut_map.shape[0], : cut_map.shape[1]] - cut_map.values
    offset = [points * step for points, step in zip(offsets, spacing(levelled), strict=True)]
    changes = {
        "periodisation": method,
        "periodisation_rms_change": float(np.sqrt(np.mean(np.square(change, out=change)))),
        # without the seams, which the part does not have where it was measured
        "rms_gradient_before": interior_rms_gradient(cut_map),
        **{f"window_offset_{axis}": float(along) for axis, along in zip("yx", offset, strict=True)},
        "window_share": float(math.prod(cut.used) / levelled.size),
        "window_reason": _reason(levelled.shape, cut, periodic_map.shape, method, missing=missing),
    }
    return _record(periodic_map.assign_attrs(levelled.attrs), waves, correct_for, changes)


def subwindow(
    part: xr.DataArray,
    *,
    method: WindowMethod = "smooth-cross-fade",
    width: float = 0.1,
    correct_for: Mapping[str, Any] | None = None,
    **band: Any,
) -> xr.DataArray:
    """Return a part (y, x; m; no NaN) as the window it would be if measured alone, without a record.

    The options are those of `periodic_window`, of which placement and least share do not count.
    """
    fade = width if method in _BLENDING_METHODS else 0.0
    cut, steps = _largest_cut(part, part.values, fade, 0.0), spacing(part)
    heights = part.values[tuple(slice(s, s + u) for s, u in zip(cut.start, cut.used, strict=True))]
    heights = _made_periodic(heights, method, cut.band, width, steps)
    # of plain axes: labelling takes longer than the solution of a small window
    axes = {d: s * np.arange(n) for d, s, n in zip("yx", steps, heights.shape, strict=True)}
    attrs = {**part.attrs, "periodisation": method}
    periodic_part = xr.DataArray(heights, axes, ("y", "x"), "height", attrs)
    return in_band(corrected(periodic_part, correct_for) if correct_for else periodic_part, **band)


def _cut_out(height: xr.DataArray, cut: _Cut, *, method: WindowMethod, width: float) -> xr.DataArray:
    """Return the cut-out made periodic."""
    step, band = spacing(height), cut.band
    part = height.isel({d: slice(s, s + u) for d, s, u in zip("yx", cut.start, cut.used, strict=True)})
    heights = _made_periodic(part.values, method, band, width, step)
    coords = {
        # from the first point in even steps, as a mirrored map has no coordinates to take over
        d: xr.Variable(d, part[d].values[b // 2] + s * np.arange(n), part[d].attrs)
        for d, b, s, n in zip("yx", band, step, heights.shape, strict=True)
    }
    coords["filled"] = xr.Variable(("y", "x"), _filled_in_window(part, method, band))
    return xr.DataArray(heights, dims=("y", "x"), coords=coords, name="height")


def _filled_points(height: xr.DataArray) -> np.ndarray:
    """Return the mask of filled points of a map."""
    return np.asarray(height.coords.get("filled", np.zeros(height.shape, dtype=np.int8)))


def _largest_cut(
    levelled_map: xr.DataArray,
    values: np.ndarray,
    fade: float,
    min_share: float,
    *,
    whole_periods: bool = False,
) -> _Cut:
    """Return the window in the largest rectangle."""
    fitting = friendly_sides(max(values.shape), fade=fade)
    y0, x0, height, breadth = largest_rectangle(~np.isnan(values), fitting)
    rectangle = values[y0 : y0 + height, x0 : x0 + breadth]
    longest = sides = [int(fitting[height]), int(fitting[breadth])]
    if whole_periods:
        sides = [side_of_whole_periods(n, lay_period(rectangle, axis)) for axis, n in enumerate(longest)]
    band = [band_points(side, fade, length=n) for side, n in zip(sides, (height, breadth), strict=True)]
    cut = _Cut([y0, x0], sides, band, sides != longest)
    _check_window(levelled_map, cut.used, min_share)
    centres = [_centre(lines, n) for lines, n in zip((rectangle, rectangle.T), cut.used, strict=True)]
    return cut._replace(start=[y0 + centres[0], x0 + centres[1]])


def _centre(rectangle: np.ndarray, rows: int) -> int:
    """Return the first row of the central `rows`; of two placements the one whose end rows differ less.

    A mirrored map then has the mirrored window, and the smaller step is the better seam.
    """
    margin, odd = divmod(len(rectangle) - rows, 2)
    if not odd:
        return margin
    steps = [np.sum((rectangle[top + rows - 1] - rectangle[top]) ** 2) for top in (margin, margin + 1)]
    return margin + int(steps[1] < (1 - 1e-9) * steps[0])  # rounding does not decide


def _made_periodic(
    heights: np.ndarray, method: str, band: list[int], width: float, step: tuple[float, float]
) -> np.ndarray:
    """Return the heights of a cut-out made periodic."""
    heights = np.asarray(heights, dtype=float)
    if method == "mirror":
        return periodisation.mirror(heights)
    if method == "taper":
        return periodisation.taper(heights, width)
    if method == "periodic-plus-smooth":
        return periodisation.periodic_plus_smooth(heights, step)
    if method == "raw":
        return heights
    if method == "cross-fade":
        return periodisation.cross_fade(heights, band)
    return periodisation.smooth_cross_fade(heights, band, step)


def _filled_in_window(part: xr.DataArray, method: str, band: list[int]) -> np.ndarray:
    """Return the mask of the points of a cut-out made periodic that depend on filled ones."""
    flags = _filled_points(part)
    if method == "mirror":
        return periodisation.mirror(flags)
    # a blended point counts as filled where a filled one contributes to it, by more than rounding
    faded = periodisation.cross_fade(flags.astype(float), band) if any(band) else flags
    return (faded > 1e-9).astype(np.int8)


def _already_periodic(height: xr.DataArray, values: np.ndarray) -> tuple[xr.DataArray, str] | None:
    """Return the map as a window if it is periodic, with or without its form, and why; otherwise None."""
    attrs = dict(height.attrs)
    form_record = json_attribute(attrs, "form_removed")
    form = form_from_record(form_record, height["y"].values, height["x"].values)
    periodic = periodisation.periodic_heights(values, form)
    if periodic is None:
        return None
    values, is_form_restored = periodic
    reason = "The map is periodic as it is; it was left alone."
    if is_form_restored:
        reason = (
            "The map is periodic as measured: the form that levelling removed was restored, except for its "
            "mean, and the map was left alone."
        )
        attrs |= {"form": "mean", **json_attributes({"form_removed": {"mean": form_record["mean"]}})}
    coords = {"y": height["y"], "x": height["x"], "filled": (("y", "x"), _filled_points(height))}
    return xr.DataArray(values, dims=("y", "x"), coords=coords, name="height", attrs=attrs), reason


def _record(
    periodic: xr.DataArray, waves: Mapping, correct_for: Mapping[str, Any] | None, changes: dict[str, Any]
) -> xr.DataArray:
    """Return the band-limited window with a record of all changes, if there were any, in its attributes."""
    whole_gradient, rms = rms_gradient(periodic), float(np.std(periodic.values))
    window = as_measured = limit_band(periodic, **waves)
    # the band is cut after the correction, which restores waves beyond it, too
    if correct_for:
        window = limit_band(corrected(periodic, correct_for), **waves)
        window.attrs["rms_gradient_uncorrected"] = whole_gradient
    if traces := instrument_traces(periodic):
        traces["noise_gradient_share"] = share_of_noise(as_measured, traces["noise_floor"])
    window.attrs |= traces
    images = 2 if changes.get("periodisation") == "mirror" else 1
    window.attrs |= summit_that_stands_out(window, images=images)
    change = changes.get("periodisation_rms_change", 0.0)
    unchanged: dict[str, Any] = {
        "periodisation": "none",
        "periodisation_rms_change": 0.0,
        "periodisation_relative_change": change / rms if rms > 0 else 0.0,
        "rms_gradient_before": whole_gradient,
        "rms_gradient_after": rms_gradient(window),
        "steepest_share": steepest_share(window),
        "form_share": share_of_form(window.values, (window["y"].values, window["x"].values)),
        "window_offset_x": 0.0,
        "window_offset_y": 0.0,
        "window_share": 1.0,
    }
    window.attrs |= unchanged | changes
    return record_summit(window)


def _check_window(height: xr.DataArray, used: Sequence[int], min_share: float) -> None:
    """Raise HeightMapError where the largest rectangle is empty or smaller than requested."""
    name, share = height.attrs.get("source_file") or "the map", math.prod(used) / height.size
    if used[0] * used[1] < 2:
        raise HeightMapError(f"{name}: no two neighbouring points are measured: fill it with level.fill")
    if share < min_share:
        raise HeightMapError(
            f"{name}: the largest rectangle without missing points has {used[1]} x {used[0]} points, "
            f"{100 * share:.1f} % of the map, less than window.min_share = {min_share:g}: fill the holes "
            "(level.fill), cut the map to its measured part, or lower window.min_share"
        )


def _reason(
    shape: Sequence[int], cut: _Cut, solved_shape: Sequence[int], method: str, *, missing: bool
) -> str:
    """Return a sentence on the part of the map that is used, the reason, and the periodisation."""
    (ny, nx), used = shape, cut.used
    why = "sides that suit the solver"
    if cut.shortened:
        why = "a whole number of periods of its texture"
    elif missing:
        why = f"the largest rectangle without missing points, with {why}"
    text = f"{used[1]} × {used[0]} of {nx} × {ny} points are used: {why}"
    if [ny, nx] == used:
        text = f"The whole map of {nx} × {ny} points is used"
    text += (
        f"; made periodic by {PERIODIC_BY[method]}" if method != "raw" else "; its edges are left as they are"
    )
    if [*solved_shape] != used:
        text += f", which leaves {solved_shape[1]} × {solved_shape[0]} points"
    return text + "."
