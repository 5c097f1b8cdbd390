"""Numbers of settings that meet, computed a second way: solved back, by a limit, by another name."""

import warnings

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.evaluation.courses import Face, worn_in_a_run
from roughcontact.evaluation.pipeline import run_chain
from roughcontact.statistics.unloading import evaluate_unloading

PITCH = (1.5e-6, 1e-6)
AS_IT_IS = {"level": {"form": "none", "line_alignment": "none", "outlier_threshold": None}}
BODY = {"youngs_modulus": 2e9, "poissons_ratio": 0.3}
LAYER = {"youngs_modulus": 5e9, "poissons_ratio": 0.2, "thickness": 3e-6}
COATED = BODY | {"layers": [LAYER]}


def rough(points=(32, 36), seed=3):
    return self_affine(points, PITCH, (6e-6, 24e-6), rms_gradient=0.05, seed=seed)


def evaluated(contact, height=None, *, sources=(), window=None, **sections):
    """Return the statistics of a periodic map as it is."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return rc.evaluate(
            rough() if height is None else height,
            **AS_IT_IS,
            window={} if contact.get("boundary") else {"method": "raw"},
            contact={"tolerance": 1e-6} | contact,
            uncertainty={"sources": [*sources]},
            **sections,
        )


@pytest.mark.cases
def test_what_has_crept_is_the_contact_of_the_creep_modulus_under_the_same_load(loads, form):
    creeping = BODY | {"creep_modulus": {"3600": 8e8}}
    result = evaluated({"bodies": [creeping, BODY]} | loads, form=form, sources=["solver"])
    same_load = loads if "force" in loads else {"mean_pressure": result["mean_pressure"].values.tolist()}
    softer = evaluated({"bodies": [BODY | {"youngs_modulus": 8e8}, BODY]} | same_load, form=form)
    names = [name for name in result if str(name).endswith("_after")]
    assert "mean_gap_after" in names
    for name in names:
        expected = softer[name.removesuffix("_after")].values
        np.testing.assert_allclose(result[name].values[:, 0], expected, rtol=1e-4, err_msg=name)


def test_a_table_of_bodies_that_creep_is_refused():
    creeping = BODY | {"creep_modulus": {"3600": 8e8}}
    with pytest.raises(rc.SettingsError, match="each time has a table of its own"):
        rc.contact_table(rough(), bodies=[creeping, BODY], loads=3)


@pytest.mark.parametrize("place", [0, 1, "layers", "base"])
def test_the_range_of_any_modulus_is_part_of_the_interval(place):
    """A range of the base of a layer, or of the other body, as one of the surface; to first order."""
    share = 0.06

    def bodies(factor, *, shares=None):
        ranged = {"youngs_modulus_uncertainty": shares}
        changed, layer = (
            {**entry, "youngs_modulus": factor * entry["youngs_modulus"]} for entry in (BODY, LAYER)
        )
        layers = {"layers": {"layers": [layer | ranged]}, "base": {"layers": [LAYER]}}.get(place, {})
        if place == "layers":
            return [BODY | layers, BODY]
        pair = [changed | ranged | layers, BODY]
        return pair[::-1] if place == 1 else pair

    result = evaluated({"bodies": bodies(1.0, shares=share), "mean_pressure": [2e6]}, sources=["material"])
    for factor in (1 - share, 1 + share):
        end = evaluated({"bodies": bodies(factor), "mean_pressure": [2e6]})
        for name in ("relative_contact_area", "mean_gap", "max_pressure"):
            lower, upper, value = (float(result[f"{name}{key}"][0]) for key in ("_lower", "_upper", ""))
            assert lower < 0.999 * value < 1.001 * value < upper
            assert 0.998 * lower <= float(end[name][0]) <= 1.002 * upper, name


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"contact": {"boundary": "free"}}, "joint.area = 1e-06: resistances of a finite body are over"),
        ({"form": {"local_scale": True}}, "joint.area = 1e-06: numbers by area and width"),
    ],
)
def test_totals_of_an_area_that_the_contact_does_not_have_are_refused(settings, words):
    conducting = BODY | {"thermal_conductivity": 20.0}
    contact = {"bodies": [conducting] * 2, "force": [0.01]} | settings.get("contact", {})
    form = {"radius": [5e-3]} | settings.get("form", {})
    joint = {"joint": {"area": 1e-6, "heat_flow": 1.0}}
    with pytest.raises(rc.SettingsError, match=words):
        resolve({"contact": contact, "form": form, "statistics": joint})


CONDUCTOR = {"thermal_conductivity": 20.0, "electrical_resistivity": 1e-7}
ASKED = {
    "seal": {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 2e-3, "perimeter": 0.1},
    "joint": {"gas_conductivity": 0.026, "temperature_jump": 3.7e-7, "area": 1e-6, "heat_flow": 0.2},
}
STACKS = {
    "half-spaces": {"bodies": [BODY | CONDUCTOR] * 2},
    "elements": {"bodies": [BODY | CONDUCTOR] * 2, "influence": "elements", "zero_frequency": "nogi-kato"},
    "layers": {"bodies": [BODY | CONDUCTOR | {"layers": [LAYER | CONDUCTOR]}, BODY | CONDUCTOR]},
    "rigid base": {
        "bodies": [CONDUCTOR | {"base": "rigid", "layers": [LAYER | CONDUCTOR]}, BODY | CONDUCTOR]
    },
    "single": {"bodies": [BODY | CONDUCTOR] * 2, "precision": "single", "tolerance": 1e-4},
}
OF_THE_WORK = {"operator_applications", "error_bound", "rounding_floor", "max_penetration", "load_error"}
# of the roughness, which flow has changed, or of what flows
OF_THE_MAP = {"yielded_area", "relative_pressure", "points_per_shortest_wavelength"}
OF_THE_MAP |= {f"area_{theory}" for theory in ("greenwood_williamson", "bush_gibson_thomas", "persson", "xu")}


@pytest.mark.parametrize("stack", STACKS)
def test_what_starts_from_a_contact_starts_with_its_numbers(stack, tmp_path):
    """The face before any distance, and the residual surface under the load that made it."""
    contact = {"mean_pressure": [1e6, 4e6], "hardness": 6e7, "tolerance": 1e-6, "unload": True}
    full = resolve(
        AS_IT_IS
        | {"contact": contact | STACKS[stack], "window": {"method": "raw"}, "statistics": ASKED}
        | {"uncertainty": {"sources": []}, "wear": {"coefficient": 1e-14, "distance": [1e-9]}}
    )[""]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        chain = run_chain(rough(), full, fields=tmp_path / "contact.nc")
        worn = worn_in_a_run(Face(chain.window), full, mean_pressure=4e6).isel(sliding_distance=0)
        with xr.open_dataset(tmp_path / "contact.nc") as solved:
            residual = evaluate_unloading(solved.load(), chain.window, full)
    loaded = chain.statistics.isel(load=1)
    assert float(loaded["load_share_above_hardness"]) > 0.01
    of_map = {str(name) for name, data in chain.statistics.variables.items() if "load" not in data.dims}
    unloaded = residual.isel(load=int(residual["mean_pressure"].values.argmax()))
    for result, excluded in ((worn, set()), (unloaded, of_map | OF_THE_MAP)):
        names = [
            str(name)
            for name, data in loaded.variables.items()
            if data.ndim == 0 and data.dtype.kind == "f" and name in result and result[name].ndim == 0
        ]
        assert {"mean_gap", "approach", "joint_conductance", "leak_rate_x"} <= {*names}
        for name in {*names} - OF_THE_WORK - excluded:
            np.testing.assert_allclose(result[name], loaded[name], rtol=1e-3, err_msg=name)


# what is required -> the number that is compared, and its power with which it rises with the roughness
REQUIRED = {
    "thermal_resistance": ("joint_conductance", -1),
    "contact_resistance": ("electrical_resistance", 1),
    "gap": ("mean_gap", 1),
    "contact_area": ("relative_contact_area", -1),
    "leak": ("total_leak_rate_x", 1),
    "resistance": ("total_electrical_resistance", 1),
    "temperature_drop": ("temperature_drop", 1),
    "pressure": ("max_pressure", 1),
}


@pytest.mark.parametrize(
    ("stack", "keys"),
    [
        ("elements", [*REQUIRED][:4]),
        ("layers", [*REQUIRED][4:]),
        ("rigid base", ["contact_area", "temperature_drop"]),
    ],
)
def test_with_the_largest_roughness_each_number_is_what_is_required(stack, keys):
    height, contact = rough((20, 24)), STACKS[stack] | {"mean_pressure": [1e6], "hardness": 2e9}
    asked = ASKED if "leak" in keys else {"joint": ASKED["joint"]}

    def rising(key, factor):
        """Return the number of a map whose heights are larger by a factor."""
        name, power = REQUIRED[key]
        result = evaluated(contact, factor * height, statistics=asked)
        names = {name, name.replace("_rate_x", "_rate_y")}
        return max(float(result[number][0]) ** power for number in names)

    required = {key: 1.15 * rising(key, 1.0) for key in keys}
    stated = {key: 1 / limit if key == "contact_area" else limit for key, limit in required.items()}
    result = evaluated(contact, height, statistics=asked | {"requirement": stated})
    for key, limit in required.items():
        factor = float(result[f"{key}_largest_Sq"][0] / result["Sq"])
        # of so few points the contact may change by a whole one in between
        below, above = (rising(key, factor * step) for step in (0.997, 1.003))
        assert below <= 1.001 * limit <= 1.002 * above < 1.5 * limit, key


@pytest.mark.parametrize("stack", STACKS)
def test_the_load_of_a_target_has_what_was_asked_for(stack):
    contact = STACKS[stack] | {"hardness": 2e8}
    targets = {"target_area": [0.1], "target_gap": [1.5e-7], "target": ["percolation", "first_yield"]}
    result = evaluated(contact | targets)
    loads = result["mean_pressure"].values
    assert float(result["relative_contact_area"][0]) == pytest.approx(0.1, rel=0.01)
    assert float(result["mean_gap"][1]) == pytest.approx(1.5e-7, rel=1e-3)
    yields, *closing = range(2, loads.size)  # first yields stand before events of which there may be none
    assert float(result["max_pressure"][yields]) == pytest.approx(2e8, rel=2e-3)
    lighter = evaluated(contact | {"mean_pressure": [0.999 * loads[index] for index in closing]})
    for axis in "xy":
        assert 0 in result[f"gap_percolates_{axis}"].values[closing]
    opened = [lighter[f"gap_percolates_{axis}"].values for axis in "xy"]
    closed = [result[f"gap_percolates_{axis}"].values[closing] for axis in "xy"]
    assert (np.subtract(opened, closed).max(axis=0) == 1).all()  # each load closes an axis


@pytest.mark.parametrize("contact", [{}, {"hardness": 5e7}, {"boundary": "free"}])
@pytest.mark.parametrize("alone", [[0.01], [0.02, 0.4]])
def test_the_answer_at_a_load_depends_on_no_other_load(contact, alone):
    """The corrected results with their correction, in a list of eight loads and by themselves."""
    loads = np.array([0.4, 0.003, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3])
    unit = 5e7 if contact else 1.0
    key = "force" if "boundary" in contact else "mean_pressure" if contact else "relative_pressure"
    unit *= 1e-10 if key == "force" else 1.0
    height = rough((144, 160))
    few, many = (
        evaluated(
            contact | {"contact_modulus": 1e9, key: (unit * np.array(values)).tolist()},
            height=height,
            sources=["solver", "discretisation"],
            form={"radius": [2e-3]} if key == "force" else {},
        )
        for values in (alone, loads)
    )
    same = [int(np.flatnonzero(loads == load)[0]) for load in alone]
    assert "relative_contact_area_as_solved" in few
    for name in ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure"):
        for suffix in ("", "_as_solved", "_estimate"):
            actual, expected = few[f"{name}{suffix}"], many[f"{name}{suffix}"].isel(load=same)
            np.testing.assert_allclose(actual, expected, rtol=1e-9, err_msg=name + suffix)
