"""Ensemble members: solutions to a wide tolerance that keep only the quantities of the error budget."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.contact.solve import MOST_LOAD, solve_contact
from roughcontact.maps import spacing
from roughcontact.uncertainty.answers import CONSTRICTIONS, quantities_in
from roughcontact.uncertainty.headline import headline
from roughcontact.uncertainty.representative_loads import interpolate_over_loads, representative_loads

_OVERRIDDEN = ("tolerance", "fields", "reduce", "progress")  # arguments that a member sets itself

Count = Callable[[xr.Dataset], xr.Dataset]


class Member(NamedTuple):
    """Result of one ensemble member.

    Attributes
    ----------
    values : dict
        quantity -> array (load).
    work : float
        number of FFT pairs times number of points.
    """

    values: dict[str, np.ndarray]
    work: float


def solve_member(
    window: xr.DataArray,
    contact: Mapping[str, Any],
    *,
    tolerance: float,
    count: Count = headline,
    result: xr.Dataset | None = None,
) -> Member:
    """Solve one window of an ensemble without keeping its fields.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic. A window whose heights are rounding errors only, after levelling, is solved as flat.
    contact : dict
        keyword arguments of `solve_contact`. A load that misses the tolerance raises or, with `on_failure` =
        "flag", is NaN.
    tolerance : float
        relative tolerance of the pressure, unless `contact` has a wider one.
    count : callable
        function that computes the quantities of a solution: `headline` or `headline_and_answers`.
    result : Dataset, optional
        that of the main window at the same loads. Closely spaced loads are then not all solved
        (`roughcontact.uncertainty.representative_loads`), and the others interpolated.

    Returns
    -------
    Member

    Raises
    ------
    ConvergenceError
        as `solve_contact`.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [0.1]}
    >>> found = solve_member(rough_reference_surface(64), problem, tolerance=1e-2)
    >>> found.values["relative_contact_area"].round(2)
    array([0.34])
    """
    if np.max(contact["mean_pressure"]) > 0.5 * MOST_LOAD * contact["contact_modulus"] * _gradient(window):
        window = xr.zeros_like(window)
    load = np.atleast_1d(np.asarray(contact["mean_pressure"], float))
    solved = np.arange(load.size)
    if result is not None:
        solved = representative_loads(load, result["relative_contact_area"].values)
    arguments = solver_arguments({**contact, "mean_pressure": load[solved]}, tolerance=tolerance)
    found = solve_contact(window, **arguments, reduce=count)
    converged = found["converged"].values == 1
    values = {name: np.where(converged, found[name].values, np.nan) for name in quantities_in(found)}
    if result is not None:
        values = at_all_loads(values, solved, result)
    return Member(values, float(found["operator_applications"].sum()) * window.size)


def at_all_loads(
    values: Mapping[str, np.ndarray], solved: np.ndarray, result: xr.Dataset
) -> dict[str, np.ndarray]:
    """Return values or half-widths at all loads of a result from those at the loads `solved`.

    Their ratio to the result is interpolated over the logarithm of the load; of constrictions, which may
    vanish, the value itself.

    Examples
    --------
    >>> load = {"mean_pressure": ("load", [1.0, 2.0, 4.0])}
    >>> result = xr.Dataset({"mean_gap": ("load", [3.0, 2.0, 1.0])}, coords=load)
    >>> at_all_loads({"mean_gap": np.array([0.3, 0.3])}, np.array([0, 2]), result)["mean_gap"]
    array([0.3, 0.4, 0.3])
    """
    load = result["mean_pressure"].values
    return {
        name: interpolate_over_loads(
            each, solved, load, np.ones(load.shape) if name in CONSTRICTIONS else result[name].values
        )
        for name, each in values.items()
    }


def _gradient(window: xr.DataArray) -> float:
    """Return the rms gradient from first differences, which never exceeds the spectral one."""
    heights = window.values
    steps = (
        np.diff(heights, axis=axis, append=heights.take([0], axis)) / pitch
        for axis, pitch in enumerate(spacing(window))
    )
    return math.sqrt(sum(float(np.mean(step**2)) for step in steps))


def solver_arguments(contact: Mapping[str, Any], *, tolerance: float) -> dict[str, Any]:
    """Return the keyword arguments of `solve_contact` for an ensemble member.

    Fields and progress are left out, and the tolerance is replaced.

    Parameters
    ----------
    contact : dict
        keyword arguments of `solve_contact` for the main solution.
    tolerance : float
        relative tolerance of the pressure, unless `contact` has a wider one.

    Returns
    -------
    dict

    Examples
    --------
    >>> solver_arguments({"contact_modulus": 1.0, "tolerance": 1e-6, "fields": True}, tolerance=1e-3)
    {'contact_modulus': 1.0, 'tolerance': 0.001}
    """
    own = {key: value for key, value in contact.items() if key not in _OVERRIDDEN}
    return own | {"tolerance": max(tolerance, contact.get("tolerance", 0.0))}


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
    mirrored = periodic.attrs["periodisation"] == "mirror"
    shown = {}
    for d, n, step in zip("yx", periodic.shape, spacing(levelled), strict=True):
        first = round(periodic.attrs[f"window_offset_{d}"] / step)
        shown[d] = slice(first, first + (n // 2 if mirrored and n > 1 else n))
    return shown


def rescaled_to(result: np.ndarray, values: np.ndarray, *, base: np.ndarray) -> np.ndarray:
    """Return the main result plus the members' deviations from their own reference, rescaled to it.

    Absolute values depend on window size and grid, relative deviations much less. The scale factor is limited
    to 0.5 ... 2, because the gap vanishes close to full contact.

    Parameters
    ----------
    result : array (load)
        values of the main window.
    values : array (member, load)
    base : array (load)
        reference value of the members.

    Returns
    -------
    array (member, load)

    Examples
    --------
    >>> import numpy as np
    >>> rescaled_to(np.array([0.2]), np.array([[0.11], [0.09]]), base=np.array([0.1])).round(3)
    array([[0.22],
           [0.18]])
    """
    ratio = np.divide(result, base, out=np.ones_like(base), where=base != 0)
    return result + np.clip(ratio, 0.5, 2.0) * (values - base)
