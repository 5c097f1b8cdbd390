"""Uncertainty and sensitivity due to load, modulus and scales, against solutions at their ends."""

import math

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

from roughcontact import SettingsError, error_budget, evaluate, self_affine_surface, solve_contact
from roughcontact.arguments.ranges import ends
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.surface.synthetic import westergaard_surface
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.inputs import input_uncertainty, stiffer
from roughcontact.uncertainty.scales import (
    ANSWERS,
    AREA,
    CONSTRICTIONS,
    QUANTITIES,
    from_scale,
    headline_names,
    to_scale,
)

MODULUS, GRADIENT, THICKNESS = 1e9, 0.1, 3e-6
INPUTS = ("mean_pressure", "contact_modulus", "amplification_z", "amplification_xy", "hardness")
SOURCES_OF_INPUTS = {"material": INPUTS[:2], "instrument": INPUTS[2:4], "hardness": INPUTS[4:]}
PROBLEMS = ("elastic", "hardness", "layers")
LOADS = {"one": [0.13], "many": [0.3, 0.05, 0.13]}  # over E* g; in any order


@pytest.fixture(scope="module")
def surface() -> xr.DataArray:
    """Return a periodic self-affine surface with 8 points per shortest wave."""
    return self_affine((72, 72), 0.4e-6, (3.2e-6, 14.4e-6), rms_gradient=GRADIENT, seed=3)


def problem(kind: str, loads: list[float], source: str = "", factor: float = 1.0) -> dict:
    """Return the keyword arguments of `solve_contact`, with load or modulus `factor` times as large."""
    scale = {source: factor}
    modulus = scale.get("contact_modulus", 1.0) * MODULUS
    arguments = {
        "contact_modulus": modulus,
        "mean_pressure": [scale.get("mean_pressure", 1.0) * load * MODULUS * GRADIENT for load in loads],
        "tolerance": 1e-6,
    }
    if kind == "hardness":
        arguments["hardness"] = scale.get("hardness", 1.0) * 0.6 * MODULUS * GRADIENT
    if kind == "layers":  # on a base four times as stiff; both incompressible
        moduli = {"youngs_modulus": 0.75 * modulus, "poissons_ratio": 0.5}
        stiff = {"youngs_modulus": 3 * modulus, "poissons_ratio": 0.5}
        arguments["bodies"] = [stiff | {"layers": [moduli | {"thickness": THICKNESS}]}]
    return arguments


def solved_at(window: xr.DataArray, kind: str, loads: list[float], source: str, factor: float) -> xr.Dataset:
    """Return the results with one input `factor` times as large."""
    if source == "amplification_z":
        window = factor * window
    if source == "amplification_xy":
        window = window.assign_coords({d: factor * window[d] for d in "xy"})
    return solve_contact(window, **problem(kind, loads, source, factor), reduce=budget_inputs)


def budget_of(window: xr.DataArray, kind: str, loads: list[float], source: str, width: float) -> xr.Dataset:
    """Return the error budget of one input with a stated uncertainty."""
    contact, instrument = problem(kind, loads), {}
    if source.startswith("amplification"):
        instrument[source] = width
    else:
        contact[f"{source}_uncertainty"] = width
    settings = {"level": {}, "window": {}, "contact": contact, "instrument": instrument}
    return error_budget(window, window, settings, sources=[*SOURCES_OF_INPUTS])


@pytest.mark.parametrize("loads", LOADS)
@pytest.mark.parametrize("kind", PROBLEMS)
@pytest.mark.parametrize("source", INPUTS)
def test_the_half_widths_are_the_changes_to_both_ends(surface, source, kind, loads):
    width = 0.3 if source == "hardness" else 0.05  # that of the hardness is solved more coarsely
    result = budget_of(surface, kind, LOADS[loads], source, width)
    base, lower, upper = (
        solved_at(surface, kind, LOADS[loads], source, f) for f in (1.0, 1 - width, 1 + width)
    )
    (source_of_input,) = (key for key, inputs in SOURCES_OF_INPUTS.items() if source in inputs)
    others = [key for key in SOURCES_OF_INPUTS if key != source_of_input]
    assert result["relative_contact_area_uncertainty"].sel(source=others).isnull().all()
    for name in (*QUANTITIES, *ANSWERS):
        if kind == "layers" and name == ANSWERS[0]:  # is not known of layers
            continue
        parts = result[f"{name}_components"].sel(source=source_of_input)
        changes = np.stack([result_at_end[name] - base[name] for result_at_end in (lower, upper)])
        changes *= (result[f"{name}_estimate"] / base[name]).values if name == "mean_contact_pressure" else 1
        full_range = np.ptp(np.vstack([changes, 0 * changes[:1]]), axis=0)
        share = 0.2 if name in CONSTRICTIONS else 0.05
        rounding = 1e-9 * base[name].values.max()
        expected = {"down": -changes.min(axis=0), "up": changes.max(axis=0)}
        for side, change in expected.items():
            deviation = np.abs(parts.sel(component=side).values - np.maximum(change, 0.0))
            assert (deviation <= share * full_range + rounding).all(), (name, side)


@pytest.mark.parametrize("loads", LOADS)
@pytest.mark.parametrize("kind", PROBLEMS)
@pytest.mark.parametrize("input_name", ["contact_modulus", "mean_pressure"])
def test_sensitivities_are_slopes_of_what_is_stated_and_of_nothing_else(surface, kind, loads, input_name):
    result = budget_of(surface, kind, LOADS[loads], input_name, 0.04)
    assert list(result["input"].values) == list(INPUTS)
    smaller, larger = (solved_at(surface, kind, LOADS[loads], input_name, f) for f in (0.96, 1.04))
    for name in (*QUANTITIES, *ANSWERS):
        with np.errstate(divide="ignore", invalid="ignore"):
            true = np.log((larger[name] / smaller[name]).values) / math.log(1.04 / 0.96)
        slopes = result[f"{name}_sensitivity"]
        slope = slopes.sel(input=input_name).values
        is_known = np.isfinite(slope)
        assert slope[is_known] == pytest.approx(true[is_known], rel=0.05, abs=0.06), name
        assert is_known.all() or name not in QUANTITIES
        assert slopes.drop_sel(input=input_name).isnull().all()


def test_a_wave_has_the_slopes_of_westergaard():
    """p̄/p* = sin²(π A/2) with p* = π E* D/λ: A depends on p̄ λ/(E* D)."""
    wave = westergaard_surface((1, 16384), 1 / 16384, amplitude=0.01, wavelength=1.0)
    ratio = np.array([0.1, 0.5])
    contact = {"contact_modulus": 1.0, "mean_pressure": ratio * math.pi * 0.01, "tolerance": 1e-6}
    solved = solve_contact(wave, **contact, reduce=budget_inputs)
    uncertainties = dict.fromkeys(INPUTS[:4], 0.1)
    sensitivities, components = input_uncertainty(Result(wave, contact, {}), solved, uncertainties)
    solved_area = to_scale(AREA, solved[AREA].values)

    def area(load):
        return 2 / np.pi * np.arcsin(np.sqrt(load))

    slope = np.sqrt(ratio / (1 - ratio)) / (np.pi * area(ratio))
    for column, (source, power) in enumerate(zip(INPUTS[:4], (1, -1, -1, 1), strict=True)):
        assert sensitivities[AREA][:, column] == pytest.approx(power * slope, rel=0.02), source
        areas = np.sort([area(ratio * factor**power) for factor in (0.9, 1.1)], axis=0)
        for sign, half_width, area_at_end in zip((-1, 1), components[source][AREA][:2], areas, strict=True):
            moved = np.abs(from_scale(AREA, solved_area + sign * half_width) - solved[AREA].values)
            assert moved == pytest.approx(np.abs(area_at_end - area(ratio)), rel=0.02), (source, sign)


def test_a_load_that_may_exceed_the_hardness_reaches_full_contact(surface):
    result = budget_of(surface, "hardness", [0.57], "mean_pressure", 0.1)
    assert result["relative_contact_area_upper"].item() == pytest.approx(1.0, abs=1e-3)
    assert result["mean_gap_lower"].item() == pytest.approx(
        0.0, abs=1e-3 * result["mean_gap_estimate"].item()
    )
    assert result["mean_contact_pressure_upper"].item() <= 0.6 * MODULUS * GRADIENT


@pytest.mark.parametrize("load", [0.13, 0.3])
def test_load_modulus_and_hardness_make_up_all_scales_of_pressure(surface, load):
    """All three times c: pressures are c times as large, areas, gaps and places are the same."""
    contact = problem("hardness", [load])
    solved = solve_contact(surface, **contact, reduce=budget_inputs)
    values = {name: solved[name].values for name in headline_names(solved) if name != "mean_contact_pressure"}
    ranges = dict.fromkeys(("mean_pressure", "contact_modulus", "hardness"), 0.1)
    slopes, _ = input_uncertainty(Result(surface, contact, values), solved, ranges)
    columns = [INPUTS.index(source) for source in ranges]
    for name in QUANTITIES:
        power = 1 if name in ("max_pressure", "mean_contact_pressure") else 0
        assert slopes[name][0, columns].sum() == pytest.approx(power, abs=0.06), name
    assert slopes[AREA][0, INPUTS.index("hardness")] < -0.1


@pytest.mark.parametrize("metal", ["steel", "copper", "gold"])
def test_intervals_of_metals_hold_the_solutions_at_the_ends_of_their_hardness(metal):
    """Steep summits flow: A = p/H, whose ends are those of the table."""
    steep = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=8e-6, longest=32e-6, rms_gradient=0.5)
    bodies = [metal, metal]
    stated = resolve({"contact": {"bodies": bodies}})[""]["contact"]
    lowest, highest = ends(stated["hardness"], stated["hardness_uncertainty"])
    loads = [0.02 * lowest, 0.2 * lowest]
    result = evaluate(steep, contact={"bodies": bodies, "mean_pressure": loads})
    for hardness in (lowest, highest):
        exact = {"contact_modulus": stated["contact_modulus"], "hardness": hardness, "mean_pressure": loads}
        at_end = evaluate(steep, contact=exact, uncertainty={"sources": ["solver", "discretisation"]})
        for name in QUANTITIES:
            rounding = 2e-3 * at_end[name]
            assert (at_end[name] >= result[f"{name}_lower"] - rounding).all(), (name, hardness)
            assert (at_end[name] <= result[f"{name}_upper"] + rounding).all(), (name, hardness)
    flows = result["load_share_above_hardness"] > 0.95
    assert flows.all()
    by_hardness = result["relative_contact_area_components"].sel(source="hardness")
    share = by_hardness / result["relative_contact_area"]
    assert share.sel(component="up").values == pytest.approx(stated["hardness"] / lowest - 1, rel=0.02)
    assert share.sel(component="down").values == pytest.approx(1 - stated["hardness"] / highest, rel=0.02)
    widths = result["relative_contact_area_uncertainty"].isel(load=-1, source=slice(-1))
    assert widths["source"][widths.argmax("source")] == "hardness"


@pytest.mark.slow
@pytest.mark.parametrize("key", ["youngs_modulus", "thermal_conductivity", "electrical_resistivity"])
@pytest.mark.parametrize("metal", ["steel", "copper", "gold"])
def test_intervals_of_metals_hold_the_solutions_at_the_ends_of_a_property_of_a_body(metal, key):
    """No places of the map are among the sources, whose scatter would hide what a property does."""
    steep = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=8e-6, longest=32e-6, rms_gradient=0.5)
    stated = resolve({"contact": {"bodies": [metal, metal]}})[""]["contact"]["bodies"][0]
    names = ("youngs_modulus", "poissons_ratio", "hardness", "thermal_conductivity", "electrical_resistivity")
    body = {name: stated[name] for name in names}
    loads = [0.02 * stated["hardness"], 0.2 * stated["hardness"]]
    sources = {"sources": ["solver", "discretisation", "material", "hardness"]}
    result = evaluate(steep, contact={"bodies": [metal, metal], "mean_pressure": loads}, uncertainty=sources)
    for end in ends(stated[key], stated[f"{key}_uncertainty"]):
        contact = {"bodies": [body | {key: end}, body], "mean_pressure": loads}
        at_end = evaluate(steep, contact=contact, uncertainty={"sources": ["solver", "discretisation"]})
        for name in (*QUANTITIES, "thermal_conductance", "electrical_conductance"):
            rounding = 2e-3 * at_end[name]
            assert (at_end[name] >= result[f"{name}_lower"] - rounding).all(), (name, end)
            assert (at_end[name] <= result[f"{name}_upper"] + rounding).all(), (name, end)


def test_an_end_that_cannot_be_solved_bounds_nothing(surface):
    contact = problem("elastic", [0.1]) | {"on_failure": "flag"}
    solved = solve_contact(surface, **contact, reduce=budget_inputs)
    beyond_rounding = contact | {"tolerance": 1e-15}
    sensitivities, components = input_uncertainty(
        Result(surface, beyond_rounding, {}), solved, {"contact_modulus": 0.1}
    )
    for name in headline_names(solved):
        assert np.isinf(components["contact_modulus"][name][:2]).all(), name
        assert np.isnan(sensitivities[name][:, INPUTS.index("contact_modulus")]).all(), name


@pytest.mark.parametrize("width", [-0.1, 1.0])
def test_an_impossible_uncertainty_is_refused(surface, width):
    with pytest.raises(SettingsError, match=f"contact_modulus = {width:g}.*below 1"):
        budget_of(surface, "elastic", [0.1], "contact_modulus", width)


def test_the_moduli_of_layers_on_a_rigid_base_have_a_range_as_well():
    bodies = [
        {"base": "rigid", "youngs_modulus": None, "layers": [{"youngs_modulus": 2.0, "thickness": 3.0}]}
    ]
    expected = [
        {"base": "rigid", "youngs_modulus": None, "layers": [{"youngs_modulus": 2.5, "thickness": 3.0}]}
    ]
    assert stiffer(bodies, 1.25) == expected
