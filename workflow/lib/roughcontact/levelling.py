"""Levelling: outliers out, form off, holes filled; what was done is recorded as numbers with units."""

import json

import numpy as np
import xarray as xr

from roughcontact.checking import check_choice, check_map
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.filling import fill_harmonic, find_holes
from roughcontact.form import fit_form
from roughcontact.fourier import spacing
from roughcontact.outliers import find_outliers

FORMS = ("none", "mean", "plane", "polynomial")
FILLS = ("harmonic", "none")

_ROUNDING = 16 * np.finfo(float).eps  # of a height less its form, relative to the form


def level(
    height: xr.DataArray,
    *,
    form: str = "plane",
    order: int = 2,
    robust: bool = False,
    outlier_threshold: float | None = 6.0,
    fill: str = "harmonic",
    max_missing: float = 0.4,
) -> xr.DataArray:
    """Reject outliers, remove the form and fill the missing points of a measured height map.

    Parameters
    ----------
    height : DataArray (y, x), m
        as measured; NaN where not measured.
    form : {"none", "mean", "plane", "polynomial"}
        what is taken off.
    order : int, 1 or more
        total order of the polynomial, x^i y^j with i + j <= order.
    robust : bool
        fit so that deep valleys and high spikes have no weight (Tukey's biweight); else least squares.
    outlier_threshold : float or None
        isolated spikes that stand off their surroundings by more than this many local standard deviations
        are taken for missing; None keeps every point. See `roughcontact.outliers`.
    fill : {"harmonic", "none"}
        how holes are filled. Missing regions that touch the border are never filled.
    max_missing : float, 0 to 1
        largest share of the map that may be missing, rejected outliers included.

    Returns
    -------
    DataArray (y, x), m, with the attributes of `height` and `form`, `form_removed` (JSON),
    `outliers_rejected`, `outlier_kinds` (JSON), `filled_points`, `filled_share`, `largest_hole` (points),
    `fill_method`, and the coordinate `filled(y, x)`.

    Raises
    ------
    HeightMapError
        a map without heights, of one pixel, or with more missing than `max_missing`.
    SettingsError
        an option that has no meaning.
    """
    check_choice("level.form", form, FORMS)
    check_choice("level.fill", fill, FILLS)
    if form == "polynomial" and (order != int(order) or order < 1):
        raise SettingsError(f"level.order = {order!r}: give a whole number of 1 or more")
    if outlier_threshold is not None and not outlier_threshold > 0:
        raise SettingsError(
            f"level.outlier_threshold = {outlier_threshold!r}: give a positive number, or null to keep every "
            "point"
        )
    if not 0 <= max_missing <= 1:
        raise SettingsError(f"level.max_missing = {max_missing!r}: give a share from 0 to 1")
    values = check_map(height)

    kinds = {}
    if outlier_threshold is not None:
        outliers, kinds = find_outliers(values, threshold=outlier_threshold)
        values = np.where(outliers, np.nan, values)
    missing = np.isnan(values)
    _check_missing(missing, height, kinds, max_missing)

    removed = {}
    if form != "none":
        surface, removed = fit_form(
            values,
            (height["y"].values, height["x"].values),
            order={"mean": 0, "plane": 1}.get(form, order),
            robust=robust,
        )
        values = values - surface
        # a plane, or a map that never varied, is flat: what the subtraction leaves is rounding
        if np.nanmax(np.abs(values)) <= _ROUNDING * np.nanmax(np.abs(surface)):
            values = np.where(missing, np.nan, 0.0)

    labels, sizes = find_holes(missing)
    filled = np.zeros(values.shape, dtype=np.int8)
    if fill == "harmonic" and sizes.size:
        values = fill_harmonic(values, labels, spacing(height))
        filled[labels > 0] = 1

    attrs = height.attrs | {
        "units": "m",
        "form": form,
        "form_removed": json.dumps(removed),
        "outliers_rejected": int(sum(kinds.values())),
        "outlier_kinds": json.dumps(kinds),
        "filled_points": int(filled.sum()),
        "filled_share": float(filled.mean()),
        "largest_hole": int(sizes.max(initial=0)),
        "fill_method": fill,
    }
    coords = {"y": height["y"], "x": height["x"], "filled": (("y", "x"), filled)}
    return xr.DataArray(values, dims=("y", "x"), coords=coords, name="height", attrs=attrs)


def _check_missing(missing, height, kinds, max_missing):
    share = missing.mean()
    if share <= max_missing and not missing.all():
        return
    name = height.attrs.get("source_file") or "the map"
    rejected = sum(kinds.values())
    also = f" ({rejected} of them rejected as outliers)" if rejected else ""
    raise HeightMapError(
        f"{name}: {100 * share:.1f} % of the points are missing{also}, more than level.max_missing = "
        f"{max_missing:g} allows: cut the map to its measured part, or raise level.max_missing"
    )
