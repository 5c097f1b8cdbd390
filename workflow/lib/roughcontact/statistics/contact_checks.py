"""Checks of the solved contact: is its pressure to be trusted, and are its patches well resolved."""

import numpy as np
import xarray as xr

from roughcontact.quantities import number, percent, quantity
from roughcontact.statistics.outcome import FAILED, LOOK, PASSED, Check

CONTACT_POINTS = 100  # fewer: the contact is a handful of pixels
OVERCOUNT = 0.2  # excess of the counted over the corrected area: patches are a few pixels across


def convergence(statistics: xr.Dataset) -> Check:
    """Check that every load reached the tolerance of the solver.

    Parameters
    ----------
    statistics : Dataset
        as `contact_statistics` returns it.

    Returns
    -------
    Check

    Examples
    --------
    >>> import xarray as xr
    >>> reached = {"converged": ("load", [1]), "error_bound": ("load", [3e-5])}
    >>> one = xr.Dataset(reached, attrs={"tolerance": 1e-4})
    >>> convergence(one).sentence
    'All loads converged: error bound at most 3.0×10⁻⁵, tolerance 1×10⁻⁴.'
    """
    failed, loads = int((statistics["converged"] == 0).sum()), statistics.sizes["load"]
    bound = number(float(statistics["error_bound"].max()), digits=2)
    tolerance = number(float(statistics.attrs["tolerance"]), digits=1)
    if failed:
        text = (
            f"{failed} of {loads} loads missed the tolerance of {tolerance}; the error bound reaches {bound}."
        )
        return Check("Solver", FAILED, text)
    return Check(
        "Solver", PASSED, f"All loads converged: error bound at most {bound}, tolerance {tolerance}."
    )


def contact_points(statistics: xr.Dataset, points: int) -> Check:
    """Check that the contact is more than a handful of pixels at every load.

    Parameters
    ----------
    statistics : Dataset
        as `contact_statistics` returns it.
    points : int
        number of points of the window.

    Returns
    -------
    Check

    Examples
    --------
    >>> import xarray as xr
    >>> contact_points(xr.Dataset({"relative_contact_area_pixels": ("load", [0.02])}), 1024).outcome
    'look'
    """
    counts = np.rint(statistics["relative_contact_area_pixels"].values * points).astype(int)
    few = int((counts < CONTACT_POINTS).sum())
    if few:
        text = (
            f"{few} of {counts.size} loads have fewer than {CONTACT_POINTS} points in contact (down to "
            f"{counts.min()}): their areas and pressures are coarse. Use higher loads or a finer map."
        )
        return Check("Points in contact", LOOK, text)
    return Check("Points in contact", PASSED, f"At least {counts.min()} points in contact at every load.")


def overcount(statistics: xr.Dataset) -> xr.DataArray:
    """Return by which share the counted pixels exceed the corrected area.

    Parameters
    ----------
    statistics : Dataset
        as `contact_statistics` returns it.

    Returns
    -------
    DataArray (load)
        infinite where nothing is left of the area.

    Examples
    --------
    >>> import xarray as xr
    >>> areas = {"relative_contact_area_pixels": ("load", [0.11]), "relative_contact_area": ("load", [0.1])}
    >>> overcount(xr.Dataset(areas)).round(3).values
    array([0.1])
    """
    counted, corrected = (statistics[f"relative_contact_area{kind}"] for kind in ("_pixels", ""))
    return (counted / corrected.where(corrected > 0) - 1).fillna(np.inf)


def resolution(statistics: xr.Dataset) -> Check:
    """Check that the contact patches are more than a few points across.

    Parameters
    ----------
    statistics : Dataset
        as `contact_statistics` returns it.

    Returns
    -------
    Check
    """
    resolution = float(statistics["points_per_shortest_wavelength"][0])
    if np.isnan(resolution):
        return Check("Resolution", PASSED, "The map is flat: there is no wave to resolve.")
    over = overcount(statistics).values
    coarse = int((over > OVERCOUNT).sum())
    waves = f"The shortest wave of the map has {number(resolution, digits=2)} points"
    if coarse:
        text = (
            f"At {coarse} of {over.size} loads the contact patches are only a few points across: counting "
            f"points overstates the area by up to {percent(over.max())}, and the correction is coarse. "
            f"{waves}."
        )
        return Check("Resolution", LOOK, text)
    text = (
        f"Counting points overstates the area by at most {percent(over.max())}; this is corrected. {waves}."
    )
    return Check("Resolution", PASSED, text)


def plasticity(statistics: xr.Dataset) -> Check:
    """Check that no point carries the hardness of the softer body.

    The plasticity index E* g / H goes along: mostly elastic below 0.3, mostly plastic above 3.

    Parameters
    ----------
    statistics : Dataset
        as `contact_statistics` returns it.

    Returns
    -------
    Check
    """
    share = statistics["yielded_area"].values if "yielded_area" in statistics else np.zeros(1)
    loads = int((share > 0).sum())
    if not loads:
        return Check("Plasticity", PASSED, "No pressure reached a hardness; without one, none was asked for.")
    hardness = float(statistics["max_pressure"].max())
    index = float(statistics["contact_modulus"]) * float(statistics["rms_gradient"]) / hardness
    text = (
        f"At {loads} of {share.size} loads up to {percent(share.max())} of the area carries the hardness of "
        f"{quantity(hardness, 'Pa')}: the surface is flattened there. Plasticity index E* g / H = "
        f"{number(index, digits=2)} (mostly elastic below 0.3, mostly plastic above 3)."
    )
    return Check("Plasticity", LOOK, text)


def load_range(statistics: xr.Dataset) -> Check:
    """Check that not all loads are in full contact.

    Parameters
    ----------
    statistics : Dataset
        as `contact_statistics` returns it.

    Returns
    -------
    Check

    Examples
    --------
    >>> import xarray as xr
    >>> areas = xr.DataArray([0.11, 1.0], dims="load")
    >>> both = xr.Dataset({"relative_contact_area_pixels": areas, "relative_contact_area": areas})
    >>> load_range(both).sentence
    'The contact covers 11.0 % to 100 % of the area.'
    """
    full = int((statistics["relative_contact_area_pixels"] == 1).sum())
    loads = statistics.sizes["load"]
    if full == loads:
        return Check(
            "Load range", LOOK, "Full contact at every load: lower ones would show how it comes about."
        )
    low, high = (float(f(statistics["relative_contact_area"])) for f in (np.min, np.max))
    text = f"The contact covers {percent(low)} to {percent(high)} of the area."
    return Check("Load range", PASSED, text)
