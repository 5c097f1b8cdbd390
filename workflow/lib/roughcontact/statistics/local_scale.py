"""The contact of a form that is wider than its map: each place as the map under Hertz's pressure there."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.solve import SOLVER_SETTINGS, solve_contact
from roughcontact.errors import SettingsError
from roughcontact.references.closed_forms import hertz_ellipse
from roughcontact.statistics.contact_geometry import relative_contact_area

_NODES = 6  # of Gauss and Jacobi, over the pressure
_AREA, _GAP = "relative_contact_area", "mean_gap"


def hertz_pressures(contact: Mapping[str, Any], radius: Sequence[float]) -> list[float]:
    """Return the largest nominal pressure (Pa) of a form, of one radius or two (m), under each force (N)."""
    smooth = hertz_ellipse(1.0, (radius[0], radius[-1]), contact["contact_modulus"])
    pressures = [smooth["max_pressure"] * force ** (1 / 3) for force in contact["force"]]
    if max(pressures) >= (hardness := contact.get("hardness") or np.inf):
        raise SettingsError(
            f"contact.force = {max(contact['force']):g} N: the smooth form has a pressure of "
            f"{max(pressures):.3g} Pa (Hertz), not below the hardness {hardness:g} Pa; stay below "
            f"{(hardness / smooth['max_pressure']) ** 3:.3g} N",
            keys=["force", "hardness"],
        )
    return pressures


def with_whole_contact(
    statistics: xr.Dataset,
    window: xr.DataArray,
    contact: Mapping[str, Any],
    radius: Sequence[float],
    *,
    threads: int = 1,
) -> xr.Dataset:
    """Return the statistics at `hertz_pressures` with force, area (m2) and mean gap (m) of the whole contact.

    Of the area of Hertz's ellipse the share 2 s ds is under s times the largest pressure, whatever its axes.
    """
    from scipy.special import roots_jacobi  # imported late, as few maps are of a form

    smooth = hertz_ellipse(1.0, (radius[0], radius[-1]), contact["contact_modulus"])
    largest, (roots, weights) = statistics["mean_pressure"], roots_jacobi(_NODES, 0, 1)
    loads, scale = np.outer(largest, (1 + roots) / 2), largest / smooth["max_pressure"]
    solver = {key: contact[key] for key in ("contact_modulus", *SOLVER_SETTINGS)} | {"threads": threads}
    curve = solve_contact(window, **solver, mean_pressure=loads.ravel().tolist(), reduce=_area_and_gap)
    share, gap = (curve[name].values.reshape(loads.shape) @ weights / 2 for name in (_AREA, _GAP))
    # pixels too large for the area in the middle are so everywhere
    corrected = statistics[_AREA] / statistics.get(f"{_AREA}_as_solved", statistics[_AREA])
    hertz_area = np.pi * smooth["major"] * smooth["minor"] * scale**2
    return statistics.assign(
        force=scale**3,
        hertz_radius=np.sqrt(hertz_area / np.pi),
        hertz_approach=smooth["approach"] * scale**2,
        local_contact_area=hertz_area * share * corrected,
        local_mean_gap=("load", gap),
    )


def _area_and_gap(contact: xr.Dataset) -> xr.Dataset:
    """Return contact area and mean gap of one load."""
    touching = contact["pressure"].values[0] > 0
    gap = np.where(touching, 0.0, contact["gap"].values[0]).mean()
    return xr.Dataset({_AREA: ("load", [relative_contact_area(touching)]), _GAP: ("load", [gap])})
