"""What the ± is for: the surface in the band of the map, or a longer one."""

import numpy as np
import pytest

from roughcontact.errors import SettingsError
from roughcontact.levelling.level import level
from roughcontact.references.synthetic import rough_reference_surface
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.combination import uncertainty_table
from roughcontact.window.periodic_window import periodic_window

QUANTITIES = ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure")
SETTINGS = {"window": {}, "contact": {"contact_modulus": 1.0, "mean_pressure": [0.02, 0.1]}}


@pytest.fixture(scope="module")
def budgets():
    """Budgets of one surface for both measurands, with an `extent` that is not the default."""
    height = level(rough_reference_surface(96))
    window = periodic_window(height)
    return {
        measurand: error_budget(
            height, window, SETTINGS, sources=["solver", "window"], measurand=measurand, extent=5.0
        )
        for measurand in ("surface", "longer")
    }


@pytest.mark.parametrize("name", QUANTITIES)
def test_the_longer_surface_can_be_asked_for(budgets, name):
    surface, longer = budgets["surface"], budgets["longer"]
    for end in ("lower", "upper"):
        np.testing.assert_array_equal(longer[f"{name}_{end}"], surface[f"{name}_longer_{end}"])
        for kept in ("next", "longer", "map"):  # the others stay what they are
            np.testing.assert_array_equal(longer[f"{name}_{kept}_{end}"], surface[f"{name}_{kept}_{end}"])
    assert not np.array_equal(longer[f"{name}_upper"], surface[f"{name}_upper"])
    ends = (
        longer[f"{name}_estimate"] - longer[f"{name}_lower"],
        longer[f"{name}_upper"] - longer[f"{name}_estimate"],
    )
    half = longer[f"{name}_uncertainty"].sel(source="combined")
    np.testing.assert_allclose(half, np.fmax(*ends), rtol=1e-12)


def test_components_are_those_of_the_measurand(budgets):
    tables = {key: uncertainty_table(budget).set_index("source") for key, budget in budgets.items()}
    of_window = {key: table.loc["window", "standard_uncertainty_upper"] for key, table in tables.items()}
    assert not np.array_equal(of_window["surface"], of_window["longer"])


def test_without_other_places_there_is_no_interval_for_them():
    height = level(rough_reference_surface(96))
    budget = error_budget(height, periodic_window(height), SETTINGS, sources=["solver"])
    for name in QUANTITIES:
        assert np.isfinite(budget[f"{name}_map_upper"]).all()
        for key in ("next", "longer"):
            assert budget[f"{name}_{key}_lower"].isnull().all()
            assert budget[f"{name}_{key}_upper"].isnull().all()


def test_the_sentence_says_what_it_is_for(budgets):
    assert "all over the surface" in budgets["surface"].attrs["window_reason"]
    assert "for the surface over 5 times the length of the map." in budgets["longer"].attrs["window_reason"]


def test_an_unknown_measurand_is_named():
    height = rough_reference_surface(64)
    with pytest.raises(SettingsError, match=r"uncertainty\.measurand.*'map'.*longer"):
        error_budget(height, height, SETTINGS, measurand="map")
