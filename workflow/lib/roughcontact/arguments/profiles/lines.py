"""What lay and shape of a map say of it: rows that are profiles, and the surfaces behind these."""

import xarray as xr

from roughcontact.arguments.maps import dimensions
from roughcontact.arguments.profiles.lays import lay_facts
from roughcontact.errors import HeightMapError


def are_lines(height: xr.DataArray) -> bool:
    """Return whether the rows of a map (y, x) are profiles, no surface behind them and no areal map."""
    is_window = "window_reason" in height.attrs
    return dimensions(height.shape) == 1 or (lay_facts(height.attrs).has_surface_behind and not is_window)


def have_lines(height: xr.DataArray) -> bool:
    """Return whether the rows of an array are profiles, one or several."""
    return dimensions(height.shape) == 1 or "profiles" in height.attrs


def check_lines(height: xr.DataArray) -> None:
    """Raise HeightMapError for an areal map with a lay, which profiles have."""
    lay = height.attrs.get("lay")
    if lay and not have_lines(height):
        points = f"{height.shape[1]} x {height.shape[0]}"
        raise HeightMapError(
            f"lay = {lay}: is of profiles, and this is a map of {points} points; leave it out"
        )


def check_single_map(height: xr.DataArray) -> None:
    """Raise an error for a map with a lay, which profiles have, and for profiles without a surface behind."""
    check_lines(height)
    if height.attrs.get("profiles", 1) > 1:
        lay = height.attrs.get("lay", "not stated")
        raise HeightMapError(
            f"lay = {lay}: several profiles have one answer where lay = none, or with others "
            "along the lay; name these as well, or one profile"
        )
