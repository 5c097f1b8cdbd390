"""Ensemble members: solutions to a wide tolerance of which only some quantities are kept."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.fields import solved_fields
from roughcontact.contact.solve import elasticity
from roughcontact.kernels.arrays import DOUBLE, SINGLE
from roughcontact.maps import spacing
from roughcontact.uncertainty.headline import quantities_of

_SINGLE_PRECISION_FROM = 1e-4  # tolerance from which rounding in single precision does not count


def solve_member(
    window: xr.DataArray,
    contact: Mapping[str, Any],
    *,
    tolerance: float,
    names: Sequence[str],
    loads: np.ndarray | None = None,
) -> dict[str, np.ndarray]:
    """Solve one window of an ensemble; its fields are not kept.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic. A window whose heights are rounding errors only, after levelling, is solved as flat.
    contact : dict
        keyword arguments of `solve_contact`.
    tolerance : float
        relative tolerance of the pressure, unless `contact` has a wider one.
    names : sequence of str
        quantities that are asked for.
    loads : array of int, optional
        indices of the loads that are solved; all by default.

    Returns
    -------
    dict
        quantity -> array (load), of the loads that are solved; NaN for a load that misses the tolerance.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> member = solve_member(
    ...     rough_reference_surface(64), problem, tolerance=1e-2, names=["relative_contact_area"]
    ... )
    >>> member["relative_contact_area"].round(2)
    array([0.34])
    """
    pressures = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    pressures = pressures if loads is None else pressures[loads]
    tolerance = max(tolerance, contact.get("tolerance", 0.0))
    influence = contact.get("influence", "sampled")
    layered = elasticity(contact.get("contact_modulus"), contact.get("bodies"))[1] is not None
    values = {name: np.full(pressures.shape, np.nan) for name in names}
    single = tolerance >= _SINGLE_PRECISION_FROM or contact.get("precision") == "single"
    precision = SINGLE if single else DOUBLE
    problem = {**contact, "mean_pressure": pressures}
    for solution in solved_fields(window, problem, tolerance=tolerance, precision=precision):
        if solution.error_bound > tolerance:
            continue
        row = quantities_of(
            solution.pressure,
            solution.gap,
            names,
            steps=spacing(window),
            influence=influence,
            layered=layered,
        )
        for name in names:
            values[name][solution.load_index] = row[name]
    return values


def measured_slices(levelled: xr.DataArray, periodic: xr.DataArray) -> dict[str, slice]:
    """Return the rows and columns of a map that its periodic window contains.

    Blended bands and mirror images do not count.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        the map.
    periodic : DataArray (y, x), m
        the window, from `periodic_window` of that map.

    Returns
    -------
    dict
        ``{"y": slice, "x": slice}``, indices into the map.

    Examples
    --------
    >>> from roughcontact.levelling.level import level
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> from roughcontact.window.periodic_window import periodic_window
    >>> levelled = level(rough_reference_surface(64)[:40])
    >>> mirrored = periodic_window(levelled, method="mirror")
    >>> mirrored.shape, measured_slices(levelled, mirrored)
    ((80, 128), {'y': slice(0, 40, None), 'x': slice(0, 64, None)})
    """
    if "periodisation" not in periodic.attrs:  # a map that is its own window
        return {d: slice(0, n) for d, n in zip("yx", levelled.shape, strict=True)}
    mirrored = periodic.attrs["periodisation"] == "mirror"
    shown = {}
    for d, n, step in zip("yx", periodic.shape, spacing(levelled), strict=True):
        first = round(periodic.attrs[f"window_offset_{d}"] / step)
        shown[d] = slice(first, first + (n // 2 if mirrored and n > 1 else n))
    return shown


def form_order(levelled: xr.DataArray) -> int:
    """Return the polynomial order that levels a subwindow as the whole map was levelled.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.

    Returns
    -------
    int
        0 where nothing or only the mean was subtracted; 1 for a plane; 2 for a sphere or a cylinder.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> form_order(rough_reference_surface(64).assign_attrs(form="sphere"))
    2
    """
    form = levelled.attrs.get("form", "plane")
    if form == "polynomial":
        # coefficients are named c_i_j; the record of a plane has slopes instead
        terms = (name.split("_") for name in json.loads(levelled.attrs["form_removed"]))
        return max((int(term[1]) + int(term[2]) for term in terms if term[0] == "c"), default=1)
    return {"none": 0, "mean": 0, "plane": 1}.get(form, 2)
