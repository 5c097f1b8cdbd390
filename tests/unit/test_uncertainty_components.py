"""The table of components makes the intervals up again; bands, grooves, transports that follow."""

import re

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact import HeightMapError, error_budget, height_map, with_uncertainty
from roughcontact.report.budget_plots import beyond_in_words
from roughcontact.statistics.decisions import TIGHT, gap_is_closed
from roughcontact.surface.synthetic import rough_reference_surface
from roughcontact.uncertainty.combination import uncertainty_table
from roughcontact.uncertainty.scales import AREA, CONDUCTANCE, GAP, PEAK, PRESSURE, to_scale

CONTACT = {"contact_modulus": 1.0, "mean_pressure": [0.05]}


def budget_of(height, **settings):
    """Return the budget of a map that is levelled and made periodic by default settings."""
    settings = {"level": {}, "window": {}, "contact": CONTACT} | settings
    levelled = rc.level(height, **settings["level"])
    return error_budget(levelled, rc.periodic_window(levelled, **settings["window"]), settings)


@pytest.fixture(scope="module")
def rough():
    return self_affine((96, 96), 1.0, (4.0, 24.0), hurst=0.7, rms_gradient=0.3, seed=8)[:80, :80]


@pytest.fixture(scope="module")
def stated(rough):
    """A budget in which every source has a share: noise, scales, modulus and load are stated."""
    contact = CONTACT | {"contact_modulus_uncertainty": 0.05, "mean_pressure_uncertainty": 0.02}
    instrument = {"noise": 0.01 * float(rough.std()), "amplification_z": 0.02, "resolution": 6.0}
    return budget_of(rough, contact=contact, instrument=instrument)


@pytest.mark.parametrize("name", [AREA, GAP, PEAK, PRESSURE, CONDUCTANCE])
def test_the_interval_is_that_of_its_components(stated, name):
    """On the scale: half-widths of 95 % (1.96 u) as squares, shifts as they are (JCGM 100, 5.1.2)."""
    table = uncertainty_table(stated)
    rows = table[(table["quantity"] == name) & (table["source"] != "combined")]
    assert set(rows["source"]) >= {"discretisation", "window", "instrument", "material", "unresolved"}
    (combined,) = table[(table["quantity"] == name) & (table["source"] == "combined")].to_dict("records")
    value = combined["value"]
    for side, sign in (("lower", -1), ("upper", 1)):

        def moved(by, sign=sign):
            return sign * (to_scale(name, value + sign * by) - to_scale(name, np.float64(value)))

        widths = moved(rows["coverage_factor"] * rows[f"standard_uncertainty_{side}"])
        total = np.sqrt(np.sum(widths**2)) + np.sum(moved(rows[f"one_sided_{side}"]))
        assert sign * (to_scale(name, combined[side]) - to_scale(name, value)) == pytest.approx(total)


def test_a_band_chosen_in_the_settings_has_no_unresolved_waves(rough):
    """A shortest wave of six pixels: neither waves that a lens hides, nor an octave beyond the band."""
    lens = {"resolution": 24.0}
    by_pixels, hidden = budget_of(rough), budget_of(rough, instrument=lens)
    chosen = budget_of(rough, instrument=lens, window={"shortest_wavelength": 6.0})
    assert hidden[f"{AREA}_lower"].item() == 0 < chosen[f"{AREA}_lower"].item()
    assert by_pixels[f"{AREA}_octave_lower"].item() < by_pixels[f"{AREA}_lower"].item()
    for name in (AREA, GAP, PEAK, PRESSURE):
        assert not chosen[f"{name}_components"].sel(source="unresolved").any()
        for side in ("lower", "upper"):
            assert chosen[f"{name}_octave_{side}"].item() == chosen[f"{name}_{side}"].item()


def test_an_octave_that_nothing_tells_of_has_no_interval(rough):
    """Neither where `unresolved` is not asked for, nor on a map too small to leave its last octave out."""
    levelled = rc.level(rough)
    settings = {"level": {}, "window": {}, "contact": CONTACT}
    with_solver = error_budget(levelled, levelled, settings, sources=["solver"])
    for budget in (with_solver, budget_of(rough[:14, :14])):
        for name in (AREA, GAP, PEAK, PRESSURE):
            assert np.isfinite(budget[f"{name}_map_lower"]).all()
            assert np.isnan(budget[f"{name}_octave_lower"]).all()
            assert np.isnan(budget[f"{name}_octave_upper"]).all()


def test_grooves_leave_the_narrowest_place_without_upper_end():
    """Deep grooves along y: elsewhere they may be wider; on this map they are what they are."""
    x = np.arange(96)
    ridges = -3.0 * np.exp(-(((x % 24) - 12) ** 2) / 4) + 0.05 * rough_reference_surface(96).values
    result = budget_of(height_map(ridges, 1.0))
    assert "Grooves or valleys lead out of the map along y" in result.attrs["window_reason"]
    assert np.isnan(result["critical_constriction_y_upper"].item())
    assert np.isfinite(result["critical_constriction_y_map_upper"].item())
    assert np.isfinite(result["critical_constriction_x_upper"].item())


def test_a_surface_that_is_its_own_mirror_image_has_equal_ends_along_x_and_y():
    rough = rough_reference_surface(96).values
    result = budget_of(height_map(rough + rough.T, 1.0 / 96))
    for side in ("lower", "upper", "next_lower", "next_upper"):
        bounds = [result[f"critical_constriction_{axis}_{side}"].item() for axis in "xy"]
        assert bounds[0] == pytest.approx(bounds[1], rel=1e-3)
    assert result["critical_constriction_x_lower"].item() < result["critical_constriction_x_upper"].item()


def test_leak_rates_go_as_the_cube_of_the_narrowest_place_and_conductances_as_theirs():
    """Ends 0.5 and 1.5 of the narrowest place: 0.125 and 3.375 of the leak; K/E* times a constant."""
    loads = {"mean_pressure": ("load", [1e6, 2e6])}
    numbers = {"critical_constriction_x": [2e-6, 0.0], "leak_rate_x": [8e-12, 0.0]}
    numbers |= {CONDUCTANCE: [1e4, 2e4], "thermal_conductance": [3e5, 6e5]}
    statistics = xr.Dataset({name: ("load", values) for name, values in numbers.items()}, coords=loads)
    statistics["leak_rate_by_cube"] = 1e6
    bounds = {"critical_constriction_x_lower": [1e-6, 0.0], "critical_constriction_x_upper": [3e-6, 1e-6]}
    bounds |= {f"{CONDUCTANCE}_lower": [5e3, 1e4], f"{CONDUCTANCE}_upper": [4e4, np.nan]}
    budget = xr.Dataset({name: ("load", values) for name, values in bounds.items()}, coords=loads)
    result = with_uncertainty(statistics, budget)
    np.testing.assert_allclose(result["leak_rate_x_lower"], [1e-12, 0.0])
    np.testing.assert_allclose(result["leak_rate_x_upper"], [27e-12, 1e-12])
    np.testing.assert_allclose(result["thermal_conductance_lower"], [1.5e5, 3e5])
    np.testing.assert_allclose(result["thermal_conductance_upper"], [1.2e6, np.nan])
    np.testing.assert_allclose(result["thermal_resistance_lower"], [1 / 1.2e6, 0.0])
    np.testing.assert_allclose(result["thermal_resistance_upper"], [1 / 1.5e5, 1 / 3e5])


def test_a_gap_that_is_certainly_closed_leaks_no_more_than_what_counts_as_nothing():
    """Nine parts are closed: no allowed leak can be undecided beside a seal that is decided."""
    loads = {"mean_pressure": ("load", [1e6, 2e6])}
    narrowest = ("critical_constriction_x", "critical_constriction_x_lower", "leak_rate_x")
    statistics = xr.Dataset({name: ("load", [0.0, 0.0]) for name in narrowest}, coords=loads)
    parts = np.where(np.arange(9)[:, None] < [[5, 0]], 3e-6, 0.0)  # of the lighter load five are open
    statistics["critical_constriction_x_parts"] = ("member", "load"), parts
    bounds = {"critical_constriction_x_upper": ("load", [2e-6, 2e-6])}
    result = with_uncertainty(statistics.assign(leak_rate_by_cube=1e6), xr.Dataset(bounds, coords=loads))
    np.testing.assert_array_equal(gap_is_closed(result, "x"), [np.nan, 1])
    np.testing.assert_allclose(result["leak_rate_x_upper"], [8e-12, TIGHT])


def test_a_map_that_was_not_levelled_is_told_from_the_one_of_the_window(rough):
    """Missing points in the window, and the map before `level`, are refused; nothing is guessed."""
    settings = {"level": {}, "window": {}, "contact": CONTACT}
    raw = rough + 0.01 * rough["x"]
    levelled = rc.level(raw)
    window = rc.periodic_window(levelled)
    with pytest.raises(
        HeightMapError, match="pass the map that level returned, of which the window is a part"
    ):
        error_budget(raw, window, settings)
    holes = levelled.copy()
    holes[40, 45] = np.nan
    with pytest.raises(HeightMapError, match="has 1 missing points where the window lies: pass the map"):
        error_budget(holes, window, settings)


def test_screen_and_page_say_what_lies_beyond_the_map(rough):
    """A line of the screen each: shorter waves, the next map, with the ends of the result."""
    result = rc.evaluate(rough, contact={"contact_modulus": "1 GPa", "mean_pressure": "15 MPa"})
    lines = beyond_in_words(result)
    assert list(lines) == ["With waves one octave shorter", "Of the next map"]
    bounds = [100 * result[f"{AREA}_next_{side}"].item() for side in ("lower", "upper")]
    assert [float(text) for text in re.findall(r"[\d.]+", lines["Of the next map"])[:2]] == pytest.approx(
        bounds, abs=0.06
    )
