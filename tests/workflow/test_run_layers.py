"""Bodies with layers from the settings to the report, beside the same bodies without them."""

import json

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml
from small_project import SETTINGS, TABLE, project_with_maps

from roughcontact import read_dataset, solve_contact

STEEL = {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3}
FILM = {"thickness": "6 um", "youngs_modulus": "700 GPa", "poissons_ratio": 0.2}
KNOWN = {"thermal_conductivity": 50.0, "yield_stress": "700 MPa"}
SHEET = {"thickness": "20 um", "youngs_modulus": "3 MPa", "poissons_ratio": 0.5}
SETTINGS_OF_BODIES = {
    **{key: value for key, value in SETTINGS.items() if key != "contact"},
    "uncertainty": {"windows": 4},
    "cases": {
        "plain": {"contact": {"bodies": [STEEL, STEEL], "mean_pressure": "200 MPa"}},
        "coated": {
            "contact": {
                "bodies": [
                    STEEL | KNOWN | {"layers": [FILM | KNOWN | {"yield_stress": "9 GPa"}]},
                    STEEL | {"thermal_conductivity": 50.0},
                ],
                "mean_pressure": "200 MPa",
            }
        },
        "sheet": {
            "contact": {"bodies": [{"base": "rigid", "layers": [SHEET]}, STEEL], "mean_pressure": "50 kPa"}
        },
    },
}


@pytest.mark.slow
def test_layers_go_from_the_settings_to_the_report(tmp_path, checkout):
    project = project_with_maps(tmp_path / "project", checkout, SETTINGS_OF_BODIES, TABLE[:2])
    project.succeed("--logger", "roughcontact")
    results_by_case = {
        case: read_dataset(project.path(f"results/{case}/ground/statistics.nc")).load()
        for case in SETTINGS_OF_BODIES["cases"]
    }
    plain, coated, sheet = results_by_case.values()
    assert "bodies" not in plain.attrs
    # E* is that of the surfaces, and the film is pressed into the softer base
    assert coated["contact_modulus"] > plain["contact_modulus"]
    assert coated["relative_contact_area"] < plain["relative_contact_area"]
    for case in (coated, sheet):
        assert np.isnan(case["area_persson"]).all()
        assert np.isnan(case["conductance_per_conductivity"]).all()
        assert case["converged"].all()
        assert (case["relative_contact_area_lower"] < case["relative_contact_area"]).all()
    assert coated["material_von_mises_stress"].dims == ("load", "material")
    assert (coated["interface_shear_stress"] > 0).all()
    assert (coated["thermal_conductance"] > 0).all()
    assert "thermal_conductance_lower" not in coated
    contact = read_dataset(project.path("results/sheet/ground/contact.nc"))
    # the cases differ in the contact alone: the first one keeps the window of all
    window = read_dataset(project.path("results/plain/ground/window.nc"))["height"]
    bodies = [
        {"base": "rigid", "layers": [{"thickness": 2e-5, "youngs_modulus": 3e6, "poissons_ratio": 0.5}]},
        {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3},
    ]
    directly = solve_contact(window, bodies=bodies, mean_pressure=5e4)
    xr.testing.assert_allclose(contact["pressure"], directly["pressure"], rtol=1e-4)
    page = project.path("results/report.html").read_text()
    assert "20.0 µm of 3.00 MPa (ν 0.50) over a rigid base on 210 GPa (ν 0.30)" in page
    assert "Not judged with layers" in page
    collected = read_dataset(project.path("results/statistics.nc"))
    together = collected["material_von_mises_stress"].sel(case="coated").values.ravel()
    np.testing.assert_array_equal(together, coated["material_von_mises_stress"].values.ravel())
    panel = project.path("results/coated/ground/panel.html").read_text()
    assert "von Mises in the base" in panel
    assert "shear below layer 1" in panel
    assert "Stress below the surface: body 1, of the lowest yield stress stated" in panel
    bands = json.loads(collected.attrs["bands"])
    assert bands["coated"]["ground"]["stresses_of"] == "body 1, of the lowest yield stress stated"
    summary = pd.read_csv(project.path("results/summary.csv"))
    assert set(summary["case"]) == set(results_by_case)


def test_bad_layers_stop_a_run_before_it_starts(tmp_path, checkout):
    wrong = yaml.safe_load(yaml.safe_dump(SETTINGS_OF_BODIES))
    wrong["cases"]["coated"]["contact"]["bodies"][0]["layers"][0]["thickness"] = "0 um"
    wrong["cases"]["sheet"]["contact"]["bodies"][0]["layers"] = []
    run = project_with_maps(tmp_path / "project", checkout, wrong, TABLE[:2]).run("--dry-run")
    assert run.returncode != 0
    assert "cases.coated.contact.bodies[0].layers[0].thickness" in run.stderr
    assert "cases.sheet.contact.bodies[0].base = 'rigid': needs layers" in run.stderr
    assert "Traceback" not in run.stderr
