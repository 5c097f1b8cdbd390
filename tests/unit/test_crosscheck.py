"""The cross-check: another program solves the same problem, and whatever goes wrong with it is said."""

import os
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact import HeightMapError, SettingsError, height_map
from roughcontact.surface import synthetic
from validation import closed_forms
from validation.crosscheck import CrossCheckError, crosscheck, main, table
from validation.rough import ensemble_map

MODULUS = 2e9
OTHER_CODE = Path(__file__).parents[1] / "other_code.py"
OTHER_PYTHON = os.environ.get("CROSSCHECK_PYTHON")


@pytest.fixture
def python_other(tmp_path):
    """A program that behaves like a Python with another code, in a folder with a space in its name."""
    path = tmp_path / "other code" / "python"
    path.parent.mkdir()
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" "{OTHER_CODE}" "$@"\n')
    path.chmod(0o755)
    return str(path)


def solved(height, *, fields=True):
    """Return (contact, statistics) at two loads."""
    gradient = rc.contact_statistics(rc.solve_contact(height, contact_modulus=MODULUS, mean_pressure=MODULUS))
    unit = MODULUS * float(gradient["rms_gradient"])
    contact = rc.solve_contact(
        height, contact_modulus=MODULUS, mean_pressure=[0.3 * unit, 0.05 * unit], tolerance=1e-9
    )
    statistics = rc.contact_statistics(contact)
    return (contact if fields else contact.drop_dims(["y", "x"])), statistics


MAPS = {
    "map": self_affine((20, 16), (2e-6, 1e-6), (8e-6, 16e-6), rms_gradient=0.1, seed=1),
    "odd rows": self_affine((45, 36), (2e-6, 1e-6), (6e-6, 24e-6), rms_gradient=0.1, seed=1),
    "odd": self_affine((15, 21), 1e-6, (5e-6, 15e-6), rms_gradient=0.1, seed=2),
    "row": synthetic.westergaard_surface((1, 32), 1e-6, amplitude=1e-6, wavelength=32e-6),
    "column": height_map(1e-6 * np.cos(2 * np.pi * np.arange(32) / 32)[:, None], 1e-6),
}


def assert_equal_results(result, statistics):
    """The other code's numbers are ours to seven digits."""
    assert result["other_max_pressure"].values == pytest.approx(statistics["max_pressure"].values, rel=1e-7)
    assert result["other_mean_gap"].values == pytest.approx(statistics["mean_gap"].values, rel=1e-7)
    own_area = statistics["relative_contact_area_pixels"].values
    assert result["other_contact_area_pixels"].values == pytest.approx(own_area, abs=1e-12)


@pytest.mark.parametrize("kind", MAPS)
def test_another_program_finds_the_same(python_other, kind):
    contact, statistics = solved(MAPS[kind])
    result = crosscheck(MAPS[kind], contact, statistics, code="tamaas", python=python_other)
    assert result.attrs == {"code": "Tamaas", "version": "tamaas 1.0"}
    assert_equal_results(result, statistics)
    assert (result["pressure_difference"] < 1e-7).all()
    assert (result["contact_difference"] == 0).all()
    assert result["mean_pressure"].values.tolist() == statistics["mean_pressure"].values.tolist()


def test_without_fields_the_numbers_are_compared(python_other):
    contact, statistics = solved(MAPS["map"], fields=False)
    result = crosscheck(MAPS["map"], contact, statistics, code="contactmechanics", python=python_other)
    assert_equal_results(result, statistics)
    assert np.isnan(result["pressure_difference"]).all()
    assert np.isnan(result["contact_difference"]).all()


def test_a_difference_is_shown(python_other):
    contact, statistics = solved(MAPS["map"])
    contact["pressure"][0] = contact["pressure"][0] * 1.01
    result = crosscheck(MAPS["map"], contact, statistics, code="tamaas", python=python_other)
    assert float(result["pressure_difference"][0]) == pytest.approx(0.01 / 1.01, rel=1e-5)


@pytest.mark.parametrize(
    ("python", "message"),
    [("/nowhere/python", "'/nowhere/python' does not start"), (sys.executable, "No module named 'tamaas'")],
)
def test_a_code_that_does_not_run_is_named(python, message):
    contact, statistics = solved(MAPS["row"])
    with pytest.raises(CrossCheckError, match=message):
        crosscheck(MAPS["row"], contact, statistics, code="tamaas", python=python)


def test_a_flat_map_and_an_unknown_code_are_refused():
    flat = height_map(np.zeros((4, 4)), 1e-6)
    contact = rc.solve_contact(flat, contact_modulus=MODULUS, mean_pressure=1e6)
    with pytest.raises(HeightMapError, match="flat"):
        crosscheck(flat, contact, rc.contact_statistics(contact), code="tamaas", python=sys.executable)
    with pytest.raises(SettingsError, match="'abaqus'"):
        crosscheck(flat, contact, rc.contact_statistics(contact), code="abaqus", python=sys.executable)
    with pytest.raises(SettingsError, match=r"python = '': .* a Python that has Tamaas"):
        crosscheck(flat, contact, rc.contact_statistics(contact), code="tamaas", python="")


def test_no_other_code_is_imported():
    """Tamaas is AGPL: it is run by its own Python, never imported by this package."""
    folders = [Path(rc.__file__).parent, Path(closed_forms.__file__).parent]
    importing = [
        path.name
        for folder in folders
        for path in folder.rglob("*.py")
        if "tamaas as" in path.read_text() or "import ContactMechanics" in path.read_text()
    ]
    assert importing == ["outside.py"]


@pytest.fixture
def results(tmp_path):
    """The folder of a finished run."""
    contact, statistics = solved(MAPS["map"])
    folder = tmp_path / "results/ground"
    for name, result in (("window", MAPS["map"].to_dataset(name="height")), ("contact", contact)):
        rc.write_dataset(result, folder / f"{name}.nc")
    rc.write_dataset(statistics, folder / "statistics.nc")
    return folder


def test_the_command_writes_and_prints_the_differences(python_other, results, capsys):
    assert main([str(results), "--python", python_other]) == 0
    differences = pd.read_csv(results / "crosscheck.csv")
    assert differences["points_that_differ"].tolist() == [0, 0]
    assert (differences["pressure_rms_difference"] < 1e-7).all()
    printed, _ = capsys.readouterr()
    assert "solved by Tamaas tamaas 1.0" in printed


def test_the_command_says_why_another_code_does_not_run(results, capsys):
    assert main([str(results), "--python", sys.executable]) == 1
    assert "ERROR: Tamaas did not solve the problem: " in capsys.readouterr().err
    assert not (results / "crosscheck.csv").exists()


def test_differences_are_relative_to_this_program():
    """Peak 2 % less and gap 3 % more at the lower load; no gap at the higher one."""
    statistics = xr.Dataset(
        {
            "relative_contact_area_pixels": ("load", [0.05, 0.2]),
            "max_pressure": ("load", [1e8, 2e8]),
            "mean_gap": ("load", [1e-6, 0.0]),
        }
    )
    other_result = xr.Dataset(
        {
            "other_max_pressure": ("load", [0.98e8, 2e8]),
            "other_mean_gap": ("load", [1.03e-6, 1e-9]),
            "other_contact_area_pixels": ("load", [0.0625, 0.2]),
            "contact_difference": ("load", [7.0, np.nan]),
            "pressure_difference": ("load", [4.2e-3, np.nan]),
        },
        coords={"mean_pressure": ("load", [1e6, 4e6])},
    )
    differences = table(statistics, other_result)
    assert differences["max_pressure_difference"].values == pytest.approx([-0.02, 0])
    assert differences["mean_gap_difference"].values == pytest.approx([0.03, 0])
    assert differences["pixels_by_the_other_code"].tolist() == [0.0625, 0.2]


@pytest.mark.skipif(OTHER_PYTHON is None, reason="CROSSCHECK_PYTHON names no Python with the other codes")
@pytest.mark.parametrize("code", ["tamaas", "contactmechanics"])
@pytest.mark.parametrize("kind", MAPS)
def test_the_other_codes_themselves(code, kind):
    contact, statistics = solved(MAPS[kind])
    result = crosscheck(MAPS[kind], contact, statistics, code=code, python=OTHER_PYTHON)
    assert_equal_results(result, statistics)
    assert (result["contact_difference"] == 0).all()


@pytest.mark.skipif(OTHER_PYTHON is None, reason="CROSSCHECK_PYTHON names no Python with the other codes")
@pytest.mark.parametrize("code", ["tamaas", "contactmechanics"])
def test_the_stored_numbers_of_the_other_codes(code):
    """Where the numbers of `closed_forms.OUTSIDE_CODES` come from: repeat them."""
    height = ensemble_map(256, seed=0)
    loads = list(closed_forms.OUTSIDE_CODES)
    contact = rc.solve_contact(height, contact_modulus=1.0, mean_pressure=loads, tolerance=1e-9)
    statistics = rc.contact_statistics(contact)
    other_result = crosscheck(height, contact, statistics, code=code, python=OTHER_PYTHON)
    for index, (points, peak, gap) in enumerate(closed_forms.OUTSIDE_CODES.values()):
        assert round(float(other_result["other_contact_area_pixels"][index]) * height.size) == points
        assert float(other_result["other_max_pressure"][index]) == pytest.approx(peak, rel=1e-7)
        assert float(other_result["other_mean_gap"][index]) == pytest.approx(gap, rel=1e-7)


SHEET = {"thickness": 3e-6, "youngs_modulus": 2e9, "poissons_ratio": 0.45}
RIGID = {"youngs_modulus": 1e20, "poissons_ratio": 0.3}


def solved_on_a_sheet(counter_body=RIGID):
    """Return map, contact and statistics of a layer on a rigid base."""
    height = MAPS["map"]
    bodies = [{"base": "rigid", "layers": [SHEET]}, counter_body]
    contact = rc.solve_contact(height, bodies=bodies, mean_pressure=[3e6, 2e7], tolerance=1e-9)
    return height, contact, rc.contact_statistics(contact)


def test_a_layer_on_a_rigid_base_is_what_another_code_finds(python_other):
    height, contact, statistics = solved_on_a_sheet()
    result = crosscheck(height, contact, statistics, code="contactmechanics", python=python_other)
    assert_equal_results(result, statistics)
    assert not result["contact_difference"].any()
    assert (result["pressure_difference"] < 1e-6).all()


@pytest.mark.skipif(not OTHER_PYTHON, reason="needs CROSSCHECK_PYTHON, the Python of another code")
@pytest.mark.parametrize(("nu", "thickness"), [(nu, t) for nu in (0.3, 0.45) for t in (0.02, 0.05, 0.1)])
def test_contactmechanics_finds_the_same_on_a_layer(nu, thickness):
    height = ensemble_map(128, seed=round(100 * (nu + thickness)))
    sheet = {"thickness": thickness, "youngs_modulus": 1.0, "poissons_ratio": nu}
    bodies = [{"base": "rigid", "layers": [sheet]}, RIGID]
    contact = rc.solve_contact(height, bodies=bodies, mean_pressure=0.1, tolerance=1e-9)
    statistics = rc.contact_statistics(contact, flow="never")
    result = crosscheck(height, contact, statistics, code="contactmechanics", python=OTHER_PYTHON)
    assert_equal_results(result, statistics)
    assert not result["contact_difference"].any()
    assert (result["pressure_difference"] < 1e-7).all()


@pytest.mark.parametrize(
    ("code", "counter_body"), [("tamaas", RIGID), ("contactmechanics", RIGID | {"youngs_modulus": 1e11})]
)
def test_layers_that_no_other_code_solves_are_refused(code, counter_body, python_other):
    height, contact, statistics = solved_on_a_sheet(counter_body)
    with pytest.raises(SettingsError, match="one layer on a rigid base"):
        crosscheck(height, contact, statistics, code=code, python=python_other)
