"""The error budget as a whole: combination, sources left out, coverage, what the report says."""

import numpy as np
import pytest
import xarray as xr
from scipy import special

from roughcontact.contact.dataset import joined
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import SettingsError
from roughcontact.levelling.level import level
from roughcontact.maps import height_map
from roughcontact.quantities import with_interval
from roughcontact.references import synthetic
from roughcontact.report.budget_plots import shown_budget
from roughcontact.results.collect import summary_table
from roughcontact.results.storage import read_dataset, write_dataset
from roughcontact.statistics.contact_statistics import contact_statistics, with_uncertainty
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.combination import (
    SOURCES,
    Component,
    component,
    ends_of,
    limited,
    monotonic,
    uncertainty_table,
)
from roughcontact.uncertainty.headline import headline
from roughcontact.uncertainty.scales import QUANTITIES
from roughcontact.validation.coverage import measured_cases
from roughcontact.window.periodic_window import periodic_window

CONTACT = {"contact_modulus": 1.0, "mean_pressure": [0.02, 0.002], "tolerance": 1e-4}
SETTINGS = {"level": {}, "window": {}, "contact": CONTACT}


@pytest.fixture(scope="module")
def height():
    return synthetic.self_affine_surface(
        (128, 128), 1e-6, hurst=0.8, shortest=6e-6, longest=3e-5, rms_gradient=0.1, seed=4
    )[:96, :100]


@pytest.fixture(scope="module")
def maps(height):
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
    for name, (half_width, error, _) in measured_cases(8, master_points=256, seed=11).items():
        assert np.mean(error <= half_width) >= 0.9, name


def gap_components(*pairs):
    """Return components of the gap, each with half-widths down and up (of its logarithm)."""
    return [component(np.array([float(down)]), np.array([float(up)])) for down, up in pairs]


def test_half_widths_add_as_squares_on_the_scale_below_and_above():
    lower, upper = ends_of("mean_gap", np.log([2.0]), gap_components((0.3, 0.0), (0.4, 0.2)))
    assert lower.item() == pytest.approx(2 * np.exp(-0.5))
    assert upper.item() == pytest.approx(2 * np.exp(0.2))


def test_shifts_of_known_direction_are_added_to_their_side():
    nothing, one = np.zeros(1), np.ones(1)
    shifted = Component(nothing, 0.3 * one, nothing, 0.1 * one)
    lower, upper = ends_of("mean_gap", np.log([2.0]), [shifted, *gap_components((0, 0.4))])
    assert lower.item() == pytest.approx(2.0)
    assert upper.item() == pytest.approx(2 * np.exp(0.6))


def test_arms_apart_from_the_result_move_it_to_the_nearer_end():
    """The truth lies 0.2 to 0.5 above: another half-width of 0.3 reaches down from 0.2."""
    lower, upper = ends_of(
        "mean_gap", np.zeros(1), gap_components((0.3, 0.4)), (-0.2 * np.ones(1), 0.5 * np.ones(1))
    )
    assert np.log(lower).item() == pytest.approx(0.2 - 0.3)
    assert np.log(upper).item() == pytest.approx(0.2 + np.hypot(0.4, 0.3))


def test_the_area_is_combined_by_the_inverse_of_the_error_function():
    area = np.array([0.3])
    lower, upper = ends_of("relative_contact_area", np.log(special.erfinv(area)), gap_components((0.5, 0.5)))
    assert special.erfinv(lower).item() == pytest.approx(special.erfinv(0.3) * np.exp(-0.5))
    assert upper.item() < 1


def test_an_infinite_arm_bounds_nothing_and_limits_are_physical():
    load = np.array([1.0, 2.0])
    ends = np.array([0.0, 0.5]), np.array([np.inf, 50.0])
    value = np.array([3.0, 4.0])
    lower, upper = limited("max_pressure", ends, value=value, load=load, hardness=None)
    np.testing.assert_array_equal(lower, load)
    np.testing.assert_array_equal(upper, [np.nan, 50.0])
    _, upper = limited("max_pressure", ends, value=value, load=load, hardness=10.0)
    np.testing.assert_array_equal(upper, [10.0, 10.0])
    lower, upper = limited("relative_contact_area", ends, value=0.1 * value, load=load, hardness=None)
    np.testing.assert_array_equal(lower, [0.0, 0.4])  # a result lies in its own interval
    np.testing.assert_array_equal(upper, [1.0, 1.0])


def test_what_one_load_bounds_it_bounds_at_the_others():
    load = np.array([3.0, 1.0, 2.0])
    ends = np.array([1.0, 3.0, 2.0]), np.array([9.0, 5.0, 7.0])
    lower, upper = monotonic("mean_gap", ends, load)  # falls with the load
    np.testing.assert_array_equal(lower, [1.0, 3.0, 2.0])
    np.testing.assert_array_equal(upper, [5.0, 5.0, 5.0])
    lower, upper = monotonic("relative_contact_area", ends, load)
    np.testing.assert_array_equal(lower, [3.0, 3.0, 3.0])
    np.testing.assert_array_equal(upper, [9.0, 5.0, 7.0])
    assert monotonic("mean_contact_pressure", ends, load) is ends


@pytest.mark.parametrize("shape", [(1, 22), (20, 20)])
def test_a_map_too_small_for_parts_has_an_open_interval(shape):
    sides = [min(256, 256 * (n - 1) + 1) for n in shape]
    height = synthetic.self_affine_surface(
        sides, 1e-6, hurst=0.8, shortest=4e-6, longest=256e-6, rms_gradient=0.1
    )
    levelled = level(height.isel(y=slice(shape[0]), x=slice(shape[1])))
    found = error_budget(levelled, periodic_window(levelled), SETTINGS)
    assert "too small" in found.attrs["window_flag"]
    for name, lowest, highest in [
        ("relative_contact_area", 0.0, 1.0),
        ("mean_gap", 0.0, np.nan),
        ("max_pressure", found["mean_pressure"].values, np.nan),
    ]:
        np.testing.assert_array_equal(found[f"{name}_lower"], np.broadcast_to(lowest, 2))
        np.testing.assert_array_equal(found[f"{name}_upper"], np.broadcast_to(highest, 2))
        assert np.isnan(found[f"{name}_uncertainty"].sel(source="combined")).all()
        # what is known of this map by itself
        assert np.isfinite(found[f"{name}_map_lower"]).all()
    table = uncertainty_table(found)
    assert np.isinf(table[table["source"].isin(["window", "combined"])]["standard_uncertainty_lower"]).all()


def test_the_corrected_result_lies_in_every_interval_of_the_band(budget):
    for name in QUANTITIES:
        for measurand in ("", "next_", "map_"):
            assert (budget[f"{name}_{measurand}lower"] < budget[f"{name}_estimate"]).all()
            assert (budget[f"{name}_{measurand}upper"] > budget[f"{name}_estimate"]).all()
        assert (budget[f"{name}_lower"] >= 0).all()
        # another map scatters more than the mean of all, and this map less
        width = {
            m: np.log(budget[f"{name}_{m}upper"] / budget[f"{name}_{m}lower"]) for m in ("", "next_", "map_")
        }
        assert (width["map_"] < width[""]).all()
        assert (width[""] < width["next_"]).all()


def test_the_pressure_in_contact_is_the_load_over_the_area(budget):
    over_area = budget["mean_pressure"] / budget["relative_contact_area_estimate"]
    np.testing.assert_allclose(budget["mean_contact_pressure_estimate"], over_area, rtol=1e-12)
    assert (budget["mean_contact_pressure_as_solved"] < over_area).all()  # a mean over whole pixels


def test_a_surface_as_long_as_the_map_is_the_surface_in_its_band(maps, budget):
    settings = SETTINGS | {"contact": CONTACT}
    found = error_budget(*maps, settings, sources=["window"], extent=1.0)
    for name in QUANTITIES:
        for end in ("lower", "upper"):
            np.testing.assert_allclose(found[f"{name}_longer_{end}"], found[f"{name}_{end}"], rtol=1e-12)
    # longer waves add to the gap, and to nothing so much
    assert (budget["mean_gap_longer_upper"] > budget["mean_gap_upper"]).all()
    with pytest.raises(SettingsError, match=r"extent = 0\.5"):
        error_budget(*maps, settings, extent=0.5)


def test_shorter_waves_take_area_off_and_raise_the_peak(budget):
    for name, down in (("relative_contact_area", True), ("max_pressure", False)):
        band, octave = (
            [budget[f"{name}_{m}{end}"].values for end in ("lower", "upper")] for m in ("", "octave_")
        )
        assert (octave[0] < band[0]).all() if down else (octave[1] > band[1]).all()


def test_neither_units_nor_the_order_of_loads_matter(height, budget):
    """Heights and pitch a thousandth as large, with another modulus; loads reversed."""
    loads = np.array(CONTACT["mean_pressure"])
    for factor, modulus, order in ((1.0, 1.0, slice(None, None, -1)), (1e-3, 1e9, slice(None))):
        other = height_map(factor * height.values, factor * 1e-6)
        levelled = level(other)
        contact = CONTACT | {"contact_modulus": modulus, "mean_pressure": list(modulus * loads[order])}
        found = error_budget(levelled, periodic_window(levelled), SETTINGS | {"contact": contact})
        for end in ("lower", "upper", "next_upper", "octave_lower"):
            area, gap = (
                found[f"{name}_{end}"].values[order] for name in ("relative_contact_area", "mean_gap")
            )
            np.testing.assert_allclose(area, budget[f"relative_contact_area_{end}"], rtol=1e-3)
            np.testing.assert_allclose(gap, factor * budget[f"mean_gap_{end}"], rtol=1e-3)


def test_one_load_has_the_interval_that_it_has_among_others(maps, budget):
    alone = error_budget(
        *maps, SETTINGS | {"contact": CONTACT | {"mean_pressure": CONTACT["mean_pressure"][0]}}
    )
    for end in ("lower", "upper"):
        name = f"relative_contact_area_{end}"
        assert alone[name].item() == pytest.approx(budget[name][0].item(), rel=1e-3)


def test_a_full_contact_is_closed_elsewhere_as_far_as_its_subwindows_are(maps):
    contact = {"contact_modulus": 1.0, "mean_pressure": [0.5, 5.0]}
    found = error_budget(*maps, SETTINGS | {"contact": contact})
    np.testing.assert_array_equal(found["relative_contact_area_estimate"], [1.0, 1.0])
    np.testing.assert_array_equal(found["mean_gap_estimate"], [0.0, 0.0])
    np.testing.assert_array_equal(found["mean_gap_lower"], [0.0, 0.0])
    widest = np.nanmax(found["mean_gap_parts"].values, axis=0)
    np.testing.assert_allclose(found["mean_gap_upper"], widest)


def test_every_source_has_its_place(budget):
    assert list(budget["source"].values) == [*SOURCES, "combined"]
    for name in QUANTITIES:
        parts = budget[f"{name}_uncertainty"]
        assert np.all(parts.sel(source=["discretisation", "window", "combined"]) > 0)
        assert np.all(parts.sel(source="combined") >= 0.999999 * parts.max("source"))
        # at the default tolerance the solver does not matter
        assert np.all(parts.sel(source="solver") < 0.2 * parts.sel(source="combined"))
        assert budget[f"{name}_parts"].dims == ("member", "load")


def test_sources_may_be_left_out(maps, budget):
    few = error_budget(*maps, SETTINGS, sources=["discretisation"])
    name = "mean_gap_uncertainty"
    assert np.isnan(few[name].sel(source=["solver", "window", "material"])).all()
    xr.testing.assert_allclose(
        few[name].sel(source="discretisation"), budget[name].sel(source="discretisation")
    )
    xr.testing.assert_equal(
        few[name].sel(source="discretisation", drop=True), few[name].sel(source="combined", drop=True)
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
    one = statistics.expand_dims("surface").assign_coords(surface_name=("surface", np.array(["a"], object)))
    table = summary_table(one)
    combined = budget["max_pressure_uncertainty"].sel(source="combined").values
    np.testing.assert_array_equal(table["max_pressure_uncertainty_Pa"], combined)
    for end in ("lower", "upper"):
        np.testing.assert_array_equal(table[f"mean_gap_{end}_m"], budget[f"mean_gap_{end}"].values)
    area = budget["relative_contact_area_uncertainty"]
    for source in SOURCES:
        column = table[f"relative_contact_area_uncertainty_from_{source}"]
        np.testing.assert_array_equal(column, area.sel(source=source).values)
    other = budget.assign_coords(mean_pressure=("load", [1.0, 2.0]))
    with pytest.raises(SettingsError, match="other loads"):
        with_uncertainty(statistics, other)


def test_the_budget_belongs_to_the_numbers_of_the_statistics(maps, statistics):
    found = solve_contact(maps[1], **CONTACT, reduce=headline)
    for name in QUANTITIES:
        np.testing.assert_allclose(found[name], statistics[f"{name}_as_solved"], rtol=1e-12)


def test_no_pressure_rises_above_the_hardness(maps):
    hardness = 0.12
    contact = CONTACT | {"hardness": hardness}
    found = error_budget(*maps, SETTINGS | {"contact": contact})
    for name in ("max_pressure", "mean_contact_pressure"):
        for measurand in ("", "next_", "longer_", "octave_", "map_"):
            assert (found[f"{name}_{measurand}upper"] <= hardness * (1 + 1e-12)).all()
    assert found["max_pressure_estimate"].values[0] == pytest.approx(hardness)


def test_the_report_says_what_the_uncertainty_is_made_of(statistics):
    shown = shown_budget(statistics)
    assert len(shown["rows"]) == 2
    area = 100 * float(statistics["relative_contact_area"][0])
    ends = (100 * float(statistics[f"relative_contact_area_{end}"][0]) for end in ("lower", "upper"))
    assert shown["rows"][0][1] == with_interval(area, *ends)
    assert any("for the mean of maps of this size all over the surface" in note for note in shown["notes"])
    assert shown["rows"][0][-1] in shown["header"]
    assert len(shown["images"]) == 4
    assert len(shown["magnification"]) == 5  # and the conductance
    assert all(image.startswith("data:image/svg") for _, image in shown["images"])
    left_out = statistics.copy(deep=True)
    del left_out.attrs["window_reason"]
    for name in QUANTITIES:
        left_out[f"{name}_uncertainty"].loc[{"source": "window"}] = np.nan
    assert "window" not in shown_budget(left_out)["header"]
    assert any("Not in the ±: window" in note for note in shown_budget(left_out)["notes"])
    assert shown_budget(statistics.drop_dims("source")) is None


@pytest.mark.parametrize(
    ("value", "half_width", "text"),
    [
        (0.0413, 0.0021, "0.0413 ± 0.0021"),
        (0.5, 0.0996, "0.50 ± 0.10"),
        (123456.0, 2345.0, "123500 ± 2300"),
        (-2.0, 0.5, "−2.00 ± 0.50"),
        (3e-12, 1e-13, "3.00×10⁻¹² ± 1.0×10⁻¹³"),
    ],
)
def test_a_value_has_as_many_places_as_its_uncertainty(value, half_width, text):
    assert with_interval(value, value - half_width, value + half_width) == text


def test_a_solution_that_is_counted_is_not_solved_again(maps, budget):
    """The budget from statistics is that of an own solution; the stiffness is more accurate in statistics."""
    statistics, inputs = [], []

    def count(contact):
        statistics.append(contact_statistics(contact))
        inputs.append(budget_inputs(contact, statistics[-1]))
        return xr.Dataset()

    solve_contact(maps[1], **CONTACT, reduce=count)
    solved = joined(inputs[::-1])  # counted from the lower load up
    found = error_budget(*maps, SETTINGS, solved=solved)
    for name in QUANTITIES:
        for end in ("lower", "upper"):
            np.testing.assert_allclose(found[f"{name}_{end}"], budget[f"{name}_{end}"], rtol=1e-12)
    for end in ("lower", "upper"):
        name = f"conductance_per_conductivity_{end}"
        np.testing.assert_allclose(found[name], budget[name], rtol=0.02)
