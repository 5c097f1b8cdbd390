"""What the intervals are for: which sources belong to which, what is known without other places."""

import numpy as np
import pytest
import xarray as xr

from roughcontact import error_budget, level, periodic_window
from roughcontact.surface.synthetic import rough_reference_surface
from roughcontact.uncertainty.calibration import JOINT, MEASURANDS
from roughcontact.uncertainty.combination import one_sided
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.intervals import interval_columns
from roughcontact.uncertainty.scales import AREA, GAP, from_scale, to_scale
from roughcontact.uncertainty.subwindows import Scatter

QUANTITIES = ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure")
SETTINGS = {"window": {}, "contact": {"contact_modulus": 1.0, "mean_pressure": [0.02, 0.1]}}


def columns_of(area, gap, members, components):
    """Return the intervals of an area and a gap (m) at one load, where other places differ by nothing."""
    values, nothing = {AREA: np.array([area]), GAP: np.array([gap])}, (np.zeros(1), np.zeros(1))
    arms = {key: dict.fromkeys(values, nothing) for key in (*MEASURANDS, JOINT)}
    return interval_columns(
        Result(xr.DataArray(), {"mean_pressure": [0.01]}, values),
        values,
        {name: to_scale(name, value) for name, value in values.items()},
        components,
        scatter=Scatter({GAP: np.array(members)[:, None]}, arms=arms),
        octave={},
    )


@pytest.mark.parametrize("measurand", ["", "next_", "map_", "joint_"])
def test_waves_of_the_band_that_the_instrument_hides_belong_to_every_measurand(measurand):
    hidden = one_sided(np.array([-0.3]))  # a tip: the true area is smaller
    columns = columns_of(0.05, 1e-7, [1e-7], {"unresolved": {AREA: hidden}})
    lower, upper = (columns[f"{AREA}_{measurand}{side}"][1] for side in ("lower", "upper"))
    np.testing.assert_allclose(lower, from_scale(AREA, to_scale(AREA, 0.05) - 0.3), rtol=1e-12)
    np.testing.assert_allclose(upper, 0.05, rtol=1e-12)


def test_a_closed_gap_may_be_as_open_as_that_of_a_part_of_the_map():
    columns = columns_of(1.0, 0.0, [0.0, 2e-9], {})
    assert [columns[f"{GAP}_{side}"][1].item() for side in ("lower", "upper")] == [0.0, 2e-9]


def test_without_other_places_there_is_no_interval_for_them():
    height = level(rough_reference_surface(96))
    budget = error_budget(height, periodic_window(height), SETTINGS, sources=["solver"])
    for name in QUANTITIES:
        assert np.isfinite(budget[f"{name}_map_upper"]).all()
        assert budget[f"{name}_next_lower"].isnull().all()
        assert budget[f"{name}_next_upper"].isnull().all()
        assert f"{name}_joint_lower" not in budget  # of which only an overview tells
