"""The error budget as a whole: combination, sources left out, coverage, what the report says."""

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

from roughcontact.arguments.maps import spacing
from roughcontact.contact.dataset import joined
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import SettingsError
from roughcontact.report.budget_plots import present_sources, shown_budget
from roughcontact.results.collect import summary_table
from roughcontact.results.storage import read_dataset, write_dataset
from roughcontact.statistics.contact_statistics import contact_statistics, with_uncertainty
from roughcontact.surface.levelling.level import level
from roughcontact.surface.window.periodic_window import periodic_window
from roughcontact.uncertainty.budget import SOURCES, error_budget
from roughcontact.uncertainty.budget_inputs import budget_inputs, headline_values, iterate_fields
from roughcontact.uncertainty.scales import QUANTITIES
from validation.coverage import measured_cases
from validation.masters import FAULTS

CONTACT = {"contact_modulus": 1.0, "mean_pressure": [0.02, 0.002], "tolerance": 1e-4}
SETTINGS = {"level": {}, "window": {}, "contact": CONTACT}


@pytest.fixture(scope="module")
def maps():
    height = self_affine((128, 128), 1e-6, (6e-6, 3e-5), rms_gradient=0.1, seed=4)[:96, :100]
    levelled = level(height)
    return levelled, periodic_window(levelled)


@pytest.fixture(scope="module")
def budget(maps):
    return error_budget(*maps, SETTINGS)


@pytest.fixture(scope="module")
def statistics(maps, budget):
    return with_uncertainty(solve_contact(maps[1], **CONTACT, reduce=contact_statistics), budget)


@pytest.mark.nightly
def test_the_combined_interval_covers_the_surface_that_was_measured():
    """The largest pressure is not promised with spikes that levelling leaves."""
    for name, (half_width, error, _) in measured_cases(8, master_points=256, seed=11).items():
        inside = error <= half_width
        if name == "max_pressure":
            by_map = inside.reshape(8, -1)
            inside = by_map[[FAULTS[index % len(FAULTS)] != "spikes" for index in range(8)]]
        assert np.mean(inside) >= 0.9, name


def test_every_source_has_its_place(budget):
    assert list(budget["source"].values) == [*SOURCES, "combined"]
    for name in QUANTITIES:
        parts = budget[f"{name}_uncertainty"]
        assert np.all(parts.sel(source=["discretisation", "window", "combined"]) > 0)
        assert np.all(parts.sel(source="combined") >= 0.999999 * parts.max("source"))
        # at the default tolerance the solver does not matter
        assert np.all(parts.sel(source="solver") < 0.2 * parts.sel(source="combined"))
        assert name == "mean_contact_pressure" or budget[f"{name}_parts"].dims == ("member", "load")


def test_sources_may_be_left_out(maps, budget):
    partial_budget = error_budget(*maps, SETTINGS, sources=["discretisation"])
    name = "mean_gap_uncertainty"
    assert np.isnan(partial_budget[name].sel(source=["solver", "window"])).all()
    xr.testing.assert_allclose(
        partial_budget[name].sel(source="discretisation"), budget[name].sel(source="discretisation")
    )
    xr.testing.assert_equal(
        partial_budget[name].sel(source="discretisation", drop=True),
        partial_budget[name].sel(source="combined", drop=True),
    )
    assert list(error_budget(*maps, SETTINGS, sources=[]).data_vars) == ["rejected_load_share"]
    with pytest.raises(SettingsError, match="did you mean 'window'"):
        error_budget(*maps, SETTINGS, sources=["windows"])


def test_the_file_of_the_budget_is_whole(budget, tmp_path):
    write_dataset(budget, tmp_path / "uncertainty.nc")
    back = read_dataset(tmp_path / "uncertainty.nc")
    xr.testing.assert_allclose(back, budget)
    assert back["max_pressure_uncertainty"].attrs["units"] == "Pa"
    assert "squares" in back["max_pressure_uncertainty"].attrs["comment"]


def test_statistics_and_summary_carry_the_budget(statistics, budget):
    xr.testing.assert_equal(statistics["mean_gap_uncertainty"], budget["mean_gap_uncertainty"])
    expanded = statistics.expand_dims("surface").assign_coords(
        surface_name=("surface", np.array(["a"], object))
    )
    table = summary_table(expanded)
    combined = budget["max_pressure_uncertainty"].sel(source="combined").values
    np.testing.assert_array_equal(table["max_pressure_uncertainty_Pa"], combined)
    for side in ("lower", "upper"):
        np.testing.assert_array_equal(table[f"mean_gap_{side}_m"], budget[f"mean_gap_{side}"].values)
    area = budget["relative_contact_area_uncertainty"]
    for source in SOURCES:
        column = table[f"relative_contact_area_uncertainty_from_{source}"]
        np.testing.assert_array_equal(column, area.sel(source=source).values)
    budget_of_others = budget.assign_coords(mean_pressure=("load", [1.0, 2.0]))
    with pytest.raises(SettingsError, match="other loads"):
        with_uncertainty(statistics, budget_of_others)


def test_the_budget_belongs_to_the_numbers_of_the_statistics(maps, budget, statistics):
    contact, names = solve_contact(maps[1], **CONTACT), QUANTITIES
    quantities = [
        headline_values(*fields, names, steps=spacing(maps[1])) for fields in iterate_fields(contact)
    ]
    for name in QUANTITIES:
        as_solved = [of_load[name] for of_load in quantities]
        np.testing.assert_allclose(as_solved, budget[f"{name}_as_solved"], rtol=1e-12)
        np.testing.assert_array_equal(statistics[name], budget[f"{name}_estimate"])


def test_the_report_says_what_the_uncertainty_is_made_of(statistics):
    budget_on_page = shown_budget(statistics)
    assert any(
        "the mean of maps of this size all over the surface" in note for note in budget_on_page["notes"]
    )
    assert len(budget_on_page["images"]) == 4
    assert all(image.startswith("data:image/svg") for _, image in budget_on_page["images"])
    without_window = statistics.copy(deep=True)
    del without_window.attrs["window_reason"]
    for name in QUANTITIES:
        without_window[f"{name}_uncertainty"].loc[{"source": "window"}] = np.nan
    assert "window" not in present_sources(without_window)
    assert any("Not in the ±: window" in note for note in shown_budget(without_window)["notes"])
    assert shown_budget(statistics.drop_dims("source")) is None


def test_a_solution_that_is_counted_is_not_solved_again(maps, budget):
    """The budget from statistics is that of an own solution; the stiffness is more accurate in statistics."""
    statistics, inputs = [], []

    def count(contact):
        statistics.append(contact_statistics(contact))
        inputs.append(budget_inputs(contact, statistics[-1]))
        return xr.Dataset()

    solve_contact(maps[1], **CONTACT, reduce=count)
    solved = joined(inputs[::-1])  # counted from the lower load up
    result = error_budget(*maps, SETTINGS, solved=solved)
    for name in QUANTITIES:
        for side in ("lower", "upper"):
            np.testing.assert_allclose(result[f"{name}_{side}"], budget[f"{name}_{side}"], rtol=1e-12)
    for side in ("lower", "upper"):
        name = f"conductance_per_conductivity_{side}"
        np.testing.assert_allclose(result[name], budget[name], rtol=0.02)
