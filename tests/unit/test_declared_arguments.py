"""Public functions refuse arguments of another kind than they declare, by name, value and way out."""

import inspect
import re

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.errors import SettingsError

SURFACE = {"hurst": 0.8, "shortest": 4e-6, "longest": 24e-6, "rms_height": 2e-7}
FACE = rc.self_affine_surface((24, 24), 1e-6, **SURFACE, seed=1)
PROFILE = rc.self_affine_surface((1, 256), 1e-6, **SURFACE, seed=1)
LOADED = {"contact_modulus": 1e9, "mean_pressure": 2e6}
WEAR = LOADED | {"wear_coefficient": 1e-15, "sliding_distance": 1.0}
RUBBER = {"long_time_modulus": "3 MPa", "moduli": ["10 MPa"], "times": [1e-4]}
SLIDING = {"relaxation": RUBBER, "mean_pressure": 1e6, "speed": 0.1}


@pytest.fixture(scope="module")
def calls():
    """Return each public function with arguments by which it works, by name."""
    contact = rc.solve_contact(FACE, **LOADED)
    load = {"mean_pressure": ("load", [1e6])}
    groups = [
        rc.group_statistics([xr.Dataset({"mean_gap": ("load", [gap]), **load}) for gap in gaps])
        for gaps in ((1.0, 1.1, 0.9), (2.0, 2.1, 1.9))
    ]
    problem = {"window": {}, "contact": LOADED | {"mean_pressure": [2e6]}}
    return {
        "level": ((FACE,), {}),
        "periodic_window": ((FACE,), {}),
        "solve_contact": ((FACE,), LOADED),
        "run_in": ((FACE,), WEAR),
        "sliding_friction": ((FACE,), SLIDING),
        "contact_statistics": ((contact,), {}),
        "first_yield_pressure": ((FACE,), {"contact_modulus": 1e9, "hardness": 5e7}),
        "error_budget": ((FACE, FACE, problem), {"sources": ["solver"]}),
        "compare_groups": (groups, {}),
        "compare_statistics": ((contact, contact), {}),
        "self_affine_surface": (((16, 16), 1e-6), SURFACE | {"longest": 16e-6}),
        "relative_positions": ((FACE, FACE), {}),
        "composite": ((FACE, FACE), {}),
        "height_map": ((FACE.values, 1e-6), {}),
        "evaluate": ((PROFILE,), LOADED | {"lay": "across", "uncertainty": {"sources": []}}),
    }


@pytest.mark.parametrize("wrong", ["x", "  ", "1,5 MPa", float("nan"), [1.0, 2.0], {}, True])
def test_no_number_or_switch_passes_as_another_kind(calls, wrong):
    tried = 0
    for function, (positional, options) in calls.items():
        for name, argument in inspect.signature(getattr(rc, function)).parameters.items():
            declared = {*str(argument.annotation).replace("<class '", "").replace("'>", "").split(" | ")}
            if not declared <= {"float", "int", "bool", "None"} or ("bool" in declared and wrong is True):
                continue
            with pytest.raises(SettingsError, match=rf"^(\w+\.)?{name} = ") as caught:
                getattr(rc, function)(*positional, **options | {name: wrong})
            assert any(way in str(caught.value) for way in ("give", "unit", "write")), (function, name)
            tried += 1
    assert tried >= 25


@pytest.mark.cases
def test_a_number_without_meaning_is_refused(calls, function, wrong):
    (positional, options), (name, _) = calls[function], *wrong.items()
    with pytest.raises(SettingsError, match=f"^{name} = .*(give|must be)"):
        getattr(rc, function)(*positional, **options | wrong)


def test_numbers_of_other_libraries_and_numbers_as_text_are_numbers():
    expected = rc.solve_contact(FACE, **LOADED)["pressure"].values
    for tolerance in (np.float32(1e-4), np.array(1e-4), "1e-4", xr.DataArray(1e-4)):
        found = rc.solve_contact(FACE, **LOADED, tolerance=tolerance, threads=np.int64(1), fields=np.True_)
        assert found["pressure"].values == pytest.approx(expected, rel=1e-3, abs=1e-3 * expected.max())


@pytest.mark.parametrize(
    ("function", "name", "wrong"),
    [
        ("relative_positions", "shifts", 2.5),
        ("relative_positions", "seed", 1.5),
        ("relative_positions", "seed", -1),
        *(("relative_positions", "rotations", wrong) for wrong in (30, "30", None, ["x"], [None])),
        *(("composite", "shift", wrong) for wrong in (1, None, (None, 0), (1, 2, 3))),
        ("height_map", "unit", 0),
        ("height_map", "height_unit", 0),
        *(("height_map", "spacing", wrong) for wrong in (None, "x", (1, "x"), (1, 2, 3), True)),
        *(("with_interval", name, wrong) for name in ("value", "lower", "upper") for wrong in (None, "x")),
        *(("evaluate", "along", wrong) for wrong in (1, None, float("nan"), "profile.txt")),
        *(("evaluate", "overview", wrong) for wrong in (1, [1], [None], True)),
        *(("evaluate", "overview_position", wrong) for wrong in (1, None, ["x"])),
    ],
)
def test_no_exception_of_python_names_what_is_wrong(calls, function, name, wrong):
    positional, options = (calls | {"with_interval": ((1.0, 0.9, 1.1), {})})[function]
    called = getattr(rc, function)
    given = inspect.signature(called).bind(*positional, **options).arguments
    further = given.pop("options", {})
    with pytest.raises(SettingsError, match=rf"\b{name} (=|is of type) ") as caught:
        called(**given | further | {name: wrong})
    assert re.search(r"give|accepted are", str(caught.value)), caught.value


def test_rows_of_unlike_length_are_no_map():
    with pytest.raises(rc.HeightMapError, match="values are no map of real numbers"):
        rc.height_map([[1, 2], [3]], 1e-6)
