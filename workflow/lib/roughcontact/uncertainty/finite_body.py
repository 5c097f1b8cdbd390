"""The error budget of a body of finite size: that of its roughness, whose changes are solved on its form.

Instead of periodic sampling there are other positions of the roughness under the form: if the results of n
have the standard deviation s on the scale of a quantity, a further one lies within t s √(1 + 1/n) of their
mean (Student's 95 %).
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.choices import UncertaintySource
from roughcontact.maps import radii_of, roughness_of, spacing
from roughcontact.references.closed_forms import hertz_ellipse
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.inputs import STIFFNESS
from roughcontact.uncertainty.random_effects import width_of_next
from roughcontact.uncertainty.scales import ANSWERS, to_scale
from roughcontact.uncertainty.subwindows import Scatter

_FEWEST = 2  # further positions
_REACH = 1.6  # semi-axes of Hertz's ellipse, between the middle of the form and the border of the roughness


def finite_body_budget(
    window: xr.DataArray,
    settings: Mapping[str, Mapping[str, Any]],
    *,
    sources: Sequence[UncertaintySource],
    windows: int,
    solved: xr.Dataset,
) -> xr.Dataset:
    """Return the `error_budget` of a body (y, x; m) from its `budget_inputs`."""
    roughness, steps = roughness_of(window), spacing(window)
    form = {"radius": radii_of(window), "edges": "form_edges" in window.attrs}
    contact = {**settings["contact"], "mean_pressure": solved["mean_pressure"].values, "form": form}
    contact |= {"area": window.size * steps[0] * steps[1], "pitch": steps[1]}
    shifts = _shifts(roughness, contact, windows - 1)
    # a single further position says nothing of others
    meaningless = ("unresolved", "window")[: 1 if len(shifts) >= _FEWEST else 2]
    budget = error_budget(
        roughness,
        roughness,
        {**settings, "window": {}, "contact": contact},
        sources=[source for source in sources if source not in meaningless],
        windows=windows,
        solved=solved.drop_vars([STIFFNESS, *ANSWERS], errors="ignore"),
        scatter_of=partial(scatter_of_positions, shifts),
    )
    ends = [name for name in budget if "_longer_" in str(name)]  # positions have no longer waves
    return budget.assign({name: xr.full_like(budget[name], np.nan) for name in ends})


def scatter_of_positions(
    shifts: Sequence[tuple[int, int]], result: Result, roughness: xr.DataArray, **_: Any
) -> Scatter:
    """Return the scatter of the results of a body over other positions of its form on the roughness."""
    few = result.few
    members = result.members(
        roughness.copy(data=np.roll(roughness.values, shift, (0, 1))) for shift in shifts
    )
    arms = {}
    for name, value in result.values.items():
        changes = to_scale(name, np.vstack([value[few], members[name]])) - to_scale(name, value[few])
        mean, width = np.nanmean(changes, axis=0), width_of_next(changes)
        below, above = (result.at_all_loads(np.maximum(width + sign * mean, 0.0)) for sign in (-1, 1))
        arms[name] = below, above
    reason = (
        f"The ± is for this body at another position on the roughness: {len(shifts)} further positions on "
        "the map were solved; it holds no waves longer than the map."
    )
    return Scatter(members, arms=arms, reason=reason, of_positions=True)


def _shifts(roughness: xr.DataArray, contact: Mapping[str, Any], number: int) -> list[tuple[int, int]]:
    """Return shifts (rows, columns) of the roughness under the form, those along both axes first."""
    radius = contact["form"]["radius"]
    if not radius or contact["form"]["edges"] or contact.get("bodies"):
        return []
    smooth = hertz_ellipse(float(max(contact["force"])), radius, contact["contact_modulus"])
    moves = []
    for axis, n, step in zip("yx", roughness.shape, spacing(roughness), strict=True):
        semi_axis = smooth[f"axis_{axis}"]
        room = n * step / 2 - _REACH * semi_axis
        points = int(room / step)
        moves.append((points, -points, 0) if room >= semi_axis else (0,))
    return [(rows, columns) for rows in moves[0] for columns in moves[1] if rows or columns][:number]
