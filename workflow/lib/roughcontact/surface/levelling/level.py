"""Levelling of a height map, with a record of every step."""

from collections import Counter
from collections.abc import Mapping

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_map
from roughcontact.arguments.choices import MAX_ORDER, Fill, LevelForm, LineAlignment
from roughcontact.arguments.maps import side_lengths, spacing
from roughcontact.arguments.measurement import json_attribute, json_attributes
from roughcontact.arguments.si import as_si
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.io.instrument_kinds import PROBE, STYLUS, of_name
from roughcontact.io.plausibility import quantisation_step
from roughcontact.surface.levelling.curved import fit_curved_form
from roughcontact.surface.levelling.filling import fill_harmonic, find_holes
from roughcontact.surface.levelling.filters import gaussian_mean_surface
from roughcontact.surface.levelling.outliers import find_outliers
from roughcontact.surface.levelling.polynomial import fit_polynomial, subtract_form
from roughcontact.surface.levelling.row_jitter import RowJitter, find_row_jitter
from roughcontact.surface.levelling.scan_lines import find_scars, line_offsets
from roughcontact.surface.roughness.heights import height_parameters, record_summit
from roughcontact.surface.roughness.traces import repeated_heights

_MAX_SCALE_RATIO = 1e4  # pixel over nesting index, or nesting index over side: beyond it the unit is wrong

_POINTS_OF_A_TERM = 4  # at least, of a polynomial: with as many points as terms no height is left


@as_si
def level(
    height: xr.DataArray,
    *,
    form: LevelForm = "plane",
    order: int = 2,
    robust: bool = False,
    outlier_threshold: float | None = 6.0,
    line_alignment: LineAlignment = "auto",
    scar_threshold: float | None = None,
    s_filter: float | None = None,
    l_filter: float | None = None,
    fill: Fill = "harmonic",
    max_missing: float = 0.4,
) -> xr.DataArray:
    """Reject outliers, align scan lines, remove form and waviness, fill the missing points of a height map.

    Parameters
    ----------
    height : DataArray (y, x), m
        as measured; NaN where not measured.
    form : {"none", "mean", "plane", "polynomial", "sphere", "cylinder"}
        form to remove.
    order : int
        total order of the polynomial, from 1 to 12: x^i y^j with i + j <= order.
    robust : bool
        whether the form is fitted robustly, without weight for deep valleys and high spikes (Tukey's
        biweight), rather than by least squares.
    outlier_threshold : float or None
        isolated spikes that deviate from their surroundings by more than this number of local standard
        deviations are rejected; None keeps every point. See `roughcontact.surface.levelling.outliers`.
    line_alignment : {"auto", "none", "jitter", "median", "matched-steps"}
        how rows (scan lines) are aligned; `auto`: as `jitter` if there is clear evidence of random row
        shifts, otherwise as `none`. See `roughcontact.surface.levelling.row_jitter` and
        `roughcontact.surface.levelling.scan_lines`.
    scar_threshold : float or None
        pieces of scan lines that deviate from the lines before and after by more than this number of
        standard deviations are rejected; None keeps every point.
    s_filter, l_filter : float or None, m
        nesting indices: areal Gaussian filters remove waves shorter than `s_filter` and longer than
        `l_filter` after the form. See `roughcontact.surface.levelling.filters`.
    fill : {"harmonic", "none"}
        how holes are filled. Missing regions that touch the border are never filled.
    max_missing : float, 0 to 1
        maximum share of missing points, rejected points included.

    Returns
    -------
    DataArray (y, x), m
        with the attributes of `height` and `form`, `form_removed` (JSON), `outlier_threshold` (0 where every
        point was kept), `outliers_rejected`, `outlier_kinds` (JSON), `line_alignment` (as applied),
        `line_alignment_by` (default, user), `row_jitter` (rms shift of the rows over `Sq` without it) and
        `row_jitter_evidence` (none, doubtful, clear), `line_shift_rms` (m), `filters_removed` (JSON),
        `filled_points`, `filled_share`, `largest_hole` (points), `fill_method`, `repeated_heights` (1 for
        quantised heights, more after a median filter), `quantisation_step` (m, of which all heights as
        measured are multiples; 0 where they are not), the height parameters of the measured points (`Sa`,
        `Sq`, `Ssk`, `Sku`, `Sp`, `Sv`, `Sz`, `Sdq`; m and 1), and the coordinates
        `filled(y, x)`, for aligned lines `line_offset(y)` (m, subtracted from each row), and for rejected
        points `rejected_height(y, x)` (m, levelled height of the rejected points; NaN elsewhere).

    Raises
    ------
    HeightMapError
        for a map without heights, of one pixel, or with a larger share of missing points than `max_missing`;
        for a map that a sphere or cylinder does not fit; for an L-filter that removes all waves.
    SettingsError
        for an invalid option.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact.arguments.maps import height_map
    >>> tilt = 1e-9 * np.arange(40.0) + np.zeros((30, 1))
    >>> values = tilt + 1e-9 * np.random.default_rng(0).standard_normal((30, 40))
    >>> values[10:12, 20:24] = np.nan
    >>> levelled = rc.level(height_map(values, 1e-6), form="plane")
    >>> levelled.attrs["filled_points"], f"{levelled.attrs['Sq']:.2g} m"
    (8, '9.7e-10 m')
    """
    _check_options(form, order, max_missing)
    _check_positive("every point", outlier_threshold=outlier_threshold, scar_threshold=scar_threshold)
    values = check_map(height)
    step = spacing(height)
    nesting_indices = {"s_filter": s_filter, "l_filter": l_filter}
    _check_nesting_indices(height, s_filter, l_filter)

    outlier_kinds: Counter[str] = Counter()
    if outlier_threshold is not None:
        _reject_outliers(values, outlier_threshold, outlier_kinds)
    jitter, applied_alignment, offsets = _alignment(values, height, line_alignment)
    if applied_alignment != "none":
        values = values - offsets[:, None]
        if outlier_threshold is not None:  # outliers that the shifts of the lines masked
            _reject_outliers(values, outlier_threshold, outlier_kinds)
    if scar_threshold is not None and (scars := find_scars(values, threshold=scar_threshold)).any():
        outlier_kinds["scar"] = int(scars.sum())
        values[scars] = np.nan
    missing = np.isnan(values)
    _check_missing(missing, height, outlier_kinds.total(), max_missing)
    # positions and heights of rejected points only: memory may not hold another copy of a large map
    is_rejected = missing & np.isfinite(height.values)
    rejected_heights = height.values[is_rejected] - offsets[np.nonzero(is_rejected)[0]]

    form_record: dict[str, dict] = {}
    if form != "none":
        surface, form_record = _fit(values, height, form, order, robust)
        rejected_heights -= surface[is_rejected]
        values = subtract_form(values, surface)
        del surface
    # the heights that rejected points would have, for the load that they would carry
    if rejected_heights.size and (s_filter or l_filter):
        restored_heights = values.copy()
        restored_heights[is_rejected] = rejected_heights
        rejected_heights = _filter(restored_heights, step, nesting_indices)[0][is_rejected]
        del restored_heights
    values, filters = _filter(values, step, nesting_indices)
    # before holes are filled: of measured points alone
    parameters = height_parameters(height.copy(data=values))

    labels, sizes = find_holes(missing)
    fill_flags = np.zeros(values.shape, dtype=np.int8)
    if fill == "harmonic" and sizes.size:
        values = fill_harmonic(values, labels, step)
        fill_flags[labels > 0] = 1

    attrs = height.attrs | {
        "units": "m",
        "form": form,
        **json_attributes({"form_removed": form_record, "outlier_kinds": outlier_kinds}),
        "outlier_threshold": float(outlier_threshold or 0.0),
        "outliers_rejected": outlier_kinds.total(),
        "line_alignment": applied_alignment,
        "line_alignment_by": "default" if line_alignment == "auto" else "user",
        "row_jitter": _relative_jitter(jitter.rms, parameters["Sq"], is_aligned=applied_alignment != "none"),
        "row_jitter_evidence": jitter.evidence,
        "line_shift_rms": float(np.sqrt(np.mean(offsets**2))),
        # of a map that was levelled before, what was removed then as well
        **json_attributes({"filters_removed": json_attribute(height.attrs, "filters_removed") | filters}),
        "filled_points": int(fill_flags.sum()),
        "filled_share": float(fill_flags.mean()),
        "largest_hole": int(sizes.max(initial=0)),
        "fill_method": fill,
        # in double: differences of integers, and of half precision, may leave their range
        "repeated_heights": repeated_heights(np.asarray(height.values, dtype=float)),
        "quantisation_step": quantisation_step(np.asarray(height.values, dtype=float)) or 0.0,
    }
    coords = {"y": height["y"], "x": height["x"], "filled": (("y", "x"), fill_flags)}
    if applied_alignment != "none":
        coords["line_offset"] = ("y", offsets)
    if rejected_heights.size:
        restored_heights = np.full(values.shape, np.nan)
        restored_heights[is_rejected] = rejected_heights
        coords["rejected_height"] = (("y", "x"), restored_heights)
    return record_summit(
        xr.DataArray(values, dims=("y", "x"), coords=coords, name="height", attrs=attrs | parameters)
    )


def _check_options(form: str, order: int, max_missing: float) -> None:
    """Raise SettingsError for an invalid option."""
    if form == "polynomial" and not 1 <= order <= MAX_ORDER:
        raise SettingsError(f"level.order = {order!r}: give a whole number from 1 to {MAX_ORDER}")
    if not 0 <= max_missing <= 1:
        raise SettingsError(f"level.max_missing = {max_missing!r}: give a share from 0 to 1")


def _check_positive(what_stays: str, **options: float | None) -> None:
    """Raise SettingsError for an option that is neither positive nor None, with which `what_stays` stays."""
    for name, value in options.items():
        if value is not None and not 0 < value < np.inf:
            raise SettingsError(
                f"level.{name} = {value!r}: give a positive number, or null to keep {what_stays}"
            )


def _check_nesting_indices(height: xr.DataArray, short: float | None, long: float | None) -> None:
    """Raise SettingsError for indices in the wrong order, or far from any length of the map: a wrong unit."""
    _check_positive("the short waves", s_filter=short)
    _check_positive("the long waves", l_filter=long)
    if short and long and short >= long:
        raise SettingsError(
            f"level.s_filter = {short:g} m is not below level.l_filter = {long:g} m: no wave would remain",
            keys=("level.s_filter", "level.l_filter"),
        )
    finest, longest = min(spacing(height)), max(side_lengths(height))
    for name, value in (("s_filter", short), ("l_filter", long)):
        if value is not None and not finest / _MAX_SCALE_RATIO <= value <= longest * _MAX_SCALE_RATIO:
            raise SettingsError(
                f"level.{name} = {value:g} m is far from the pixels of {finest:g} m and the sides of "
                f"{longest:g} m of this map: check the unit",
                keys=[f"level.{name}"],
            )


def _alignment(values: np.ndarray, height: xr.DataArray, method: str) -> tuple[RowJitter, str, np.ndarray]:
    """Return the row jitter found, the alignment applied, and the offsets (ny,) to subtract."""
    kind = of_name(json_attribute(height.attrs, "instrument").get("kind"))
    jitter = find_row_jitter(values, is_scan=kind in (PROBE, STYLUS))  # which measure line by line
    if method == "auto":
        method = "jitter" if jitter.evidence == "clear" else "none"
    if method == "none":
        return jitter, method, np.zeros(len(values))
    return jitter, method, jitter.offsets if method == "jitter" else line_offsets(values, method=method)


def _relative_jitter(jitter: float, rms_height: float, *, is_aligned: bool) -> float:
    """Return the rms shift of the rows over the rms height of the map without it."""
    rms_without_jitter = rms_height if is_aligned else float(np.sqrt(max(rms_height**2 - jitter**2, 0.0)))
    return jitter / rms_without_jitter if rms_without_jitter > 0 else 0.0


def _reject_outliers(values: np.ndarray, threshold: float, outlier_kinds: Counter[str]) -> None:
    """Set outliers to NaN, in place, and add their numbers to `outlier_kinds`."""
    outliers, counts = find_outliers(values, threshold=threshold)
    outlier_kinds.update(counts)
    values[outliers] = np.nan


def _fit(
    values: np.ndarray, height: xr.DataArray, form: str, order: int, robust: bool
) -> tuple[np.ndarray, dict[str, dict]]:
    """Return the form (ny, nx) and its record."""
    coordinates = height["y"].values, height["x"].values
    if form == "polynomial":
        (ny, nx), points = values.shape, int(np.isfinite(values).sum())
        terms = sum(1 + min(order - j, nx - 1) for j in range(min(order, ny - 1) + 1))
        if points < _POINTS_OF_A_TERM * terms:
            raise SettingsError(
                f"level.order = {order}: a polynomial of {terms} terms leaves next to nothing of {points} "
                "measured points; lower the order, or level by the mean"
            )
    if form not in ("sphere", "cylinder"):
        order = {"mean": 0, "plane": 1}.get(form, order)
        return fit_polynomial(values, coordinates, order=order, robust=robust)
    try:
        return fit_curved_form(values, coordinates, shape=form, robust=robust)
    except HeightMapError as error:
        raise HeightMapError(f"{height.attrs.get('source_file') or 'the map'}: {error}") from error


def _filter(
    values: np.ndarray, step: tuple[float, float], nesting_indices: Mapping[str, float | None]
) -> tuple[np.ndarray, dict[str, dict]]:
    """Return the filtered heights, and a record of what was removed: nesting index and rms, in m."""
    record = {}
    for name, index in nesting_indices.items():
        if index is None:
            continue
        pixels = 2 * max(step)
        if name == "l_filter" and index < pixels:
            raise HeightMapError(
                f"level.l_filter = {index:g} m is less than two pixels ({pixels:g} m): no wave would remain"
            )
        smooth = gaussian_mean_surface(values, step, index)
        passband, difference = (smooth, values - smooth) if name == "s_filter" else (values - smooth, smooth)
        difference = difference[~np.isnan(difference)]
        record[name] = {
            "nesting_index": {"value": float(index), "units": "m"},
            "rms_removed": {"value": float(np.sqrt(np.mean(difference**2))), "units": "m"},
        }
        values = passband
    return values, record


def _check_missing(missing: np.ndarray, height: xr.DataArray, rejections: int, max_missing: float) -> None:
    """Raise HeightMapError where too many points are missing."""
    share = missing.mean()
    if share <= max_missing and not missing.all():
        return
    name = height.attrs.get("source_file") or "the map"
    also = f" ({rejections} of them rejected as outliers or scars)" if rejections else ""
    raise HeightMapError(
        f"{name}: {100 * share:.1f} % of the points are missing{also}, more than level.max_missing = "
        f"{max_missing:g} allows: cut the map to its measured part, or raise level.max_missing"
    )
