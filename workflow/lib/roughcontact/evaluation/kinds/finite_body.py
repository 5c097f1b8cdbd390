"""A body of finite size on a half-space, loaded by a force.

Its ± is that of its roughness, whose changes are solved on its form. Instead of periodic sampling there are
other positions of the roughness under the form: if the results of n have the standard deviation s on the
scale of a quantity, a further one lies within t s √(1 + 1/n) of their mean (Student's 95 %).
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import scipy
import xarray as xr

from roughcontact.arguments.finite_body import ends_at_edges, form_radii, recover_roughness
from roughcontact.arguments.kinds import FINITE_BODY
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.contact.elasticity.closed_forms import hertz_ellipse
from roughcontact.contact.solve import solve_contact
from roughcontact.evaluation.kinds.periodic_map import PeriodicMap, Settings, SolvedMap
from roughcontact.surface.preparation.finite_body import FiniteBodyPreparation
from roughcontact.surface.window.finite_body import finite_body
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.calibration import MEASURANDS
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.random_effects import width_of_next
from roughcontact.uncertainty.scales import ANSWERS, to_scale
from roughcontact.uncertainty.subwindows import Scatter

_FEWEST = 2  # further positions
_REACH = 1.6  # semi-axes of Hertz's ellipse, between the middle of the form and the border of the roughness


class FiniteBody(FiniteBodyPreparation, PeriodicMap):
    """A ball, a block: the map is its roughness, on a form or within edges."""

    facts = FINITE_BODY

    def loads(self, window: xr.DataArray, settings: Settings, solver: Mapping[str, Any]) -> dict[str, Any]:
        """Return boundary and forces."""
        return {"boundary": self.facts.boundary, self.facts.load: settings["contact"][self.facts.load]}

    def budget(self, solution: SolvedMap) -> xr.Dataset:
        """Return the error budget of the roughness, solved on its form."""
        window, settings, inputs = solution.window, solution.settings, solution.inputs
        inputs = solve_contact(window, **solution.solver, reduce=budget_inputs) if inputs is None else inputs
        roughness, steps = recover_roughness(window), spacing(window)
        form: dict[str, Any] = {"radius": form_radii(window.attrs), "edges": ends_at_edges(window.attrs)}
        contact = {**solution.contact, "mean_pressure": inputs["mean_pressure"].values}
        contact |= {"on_form": partial(finite_body, **form), "area": window.size * steps[0] * steps[1]}
        windows = settings["uncertainty"]["windows"]
        shifts = [] if form["edges"] else _shifts(roughness, contact, form["radius"], windows - 1)
        # a single further position says nothing of others
        meaningless = ("unresolved", "window")[: 1 if len(shifts) >= _FEWEST else 2]
        return error_budget(
            roughness,
            roughness,
            {**settings, "window": {}, "contact": contact},
            sources=[source for source in settings["uncertainty"]["sources"] if source not in meaningless],
            windows=windows,
            solved=inputs.drop_vars(ANSWERS, errors="ignore"),
            scatter_of=partial(scatter_of_positions, shifts),
            refine=halved_pixels,
        )

    def add_improvement(self, statistics: xr.Dataset) -> xr.Dataset:
        """Return the statistics as they are: a longer map does not bring the positions nearer together."""
        return statistics


def scatter_of_positions(
    shifts: Sequence[tuple[int, int]], result: Result, roughness: xr.DataArray, **_: Any
) -> Scatter:
    """Return the scatter of the results of a body over other positions of its form on the roughness."""
    rolled = (np.roll(roughness.values, shift, (0, 1)) for shift in shifts)
    members = result.members(roughness.copy(data=heights) for heights in rolled)
    arms = {}
    for name, value in result.values.items():
        changes = to_scale(name, np.vstack([value, members[name]])) - to_scale(name, value)
        mean, width = np.nanmean(changes, axis=0), width_of_next(changes)
        arms[name] = np.maximum(width - mean, 0.0), np.maximum(width + mean, 0.0)
    reason = (
        f"The ± is for this body at another position on the roughness: {len(shifts)} further positions on "
        "the map were solved; it holds no waves longer than the map."
    )
    return Scatter(members, arms=dict.fromkeys(MEASURANDS, arms), reason=reason, of_positions=True)


def halved_pixels(roughness: xr.DataArray) -> tuple[xr.DataArray, xr.DataArray]:
    """Return a map that is not periodic, with its borders, and on pixels half as large, by cubic splines."""
    points = [np.arange(n) for n in roughness.shape]
    finer = [np.clip(np.arange(2 * n) / 2 - 0.25, 0, n - 1) for n in roughness.shape]
    heights = scipy.interpolate.RectBivariateSpline(*points, roughness.values)(*finer)
    return roughness, height_map(heights, [step / 2 for step in spacing(roughness)], unit="m")


def _shifts(
    roughness: xr.DataArray, contact: Mapping[str, Any], radius: Sequence[float], number: int
) -> list[tuple[int, int]]:
    """Return shifts (rows, columns) of the roughness under the form, those along both axes first."""
    if not radius or contact.get("bodies"):
        return []
    smooth = hertz_ellipse(float(max(contact["force"])), radius, contact["contact_modulus"])
    moves = []
    for axis, n, step in zip("yx", roughness.shape, spacing(roughness), strict=True):
        semi_axis = smooth[f"axis_{axis}"]
        room = n * step / 2 - _REACH * semi_axis
        points = int(room / step)
        moves.append((points, -points, 0) if room >= semi_axis else (0,))
    return [(rows, columns) for rows in moves[0] for columns in moves[1] if rows or columns][:number]
