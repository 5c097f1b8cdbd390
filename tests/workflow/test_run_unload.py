"""The load is taken off in a run: residual.nc, its section of the page, the residual surface solved again."""

import json

import numpy as np
import pytest
from small_project import TABLE, project_of_cases

from roughcontact import read_dataset, read_height_map

CONTACT = {
    "contact_modulus": "100 GPa",
    "hardness": "3 GPa",
    "mean_pressure": ["20 MPa", "100 MPa", "200 MPa"],
}
CASES = {
    "plain": {},
    "once": {"contact": {"unload": True}},
    "twice": {"contact": {"unload": ["100 MPa", "200 MPa"]}},
}


@pytest.mark.slow
def test_what_the_load_leaves_goes_from_the_settings_to_the_page(tmp_path, checkout):
    project = project_of_cases(tmp_path / "project", checkout, CONTACT, CASES)
    project.succeed()
    # the cases differ in what follows the contact, which is solved once
    assert not project.path("results/plain/ground/residual.nc").exists()
    assert not project.path("results/once/ground/contact.nc").exists()
    loaded = read_dataset(project.path("results/plain/ground/statistics.nc"))
    once, twice = (
        read_dataset(project.path(f"results/{case}/ground/residual.nc")) for case in ("once", "twice")
    )
    assert once["mean_pressure"].values.tolist() == [2e8, 1e8, 2e7]
    assert float(once["relative_contact_area"][0]) == pytest.approx(
        float(loaded["relative_contact_area"][2]), rel=5e-3
    )
    assert float(once["relative_contact_area"][2]) > 1.2 * float(loaded["relative_contact_area"][0])
    assert float(once["rms_gradient"]) < float(once["rms_gradient_before_load"])
    np.testing.assert_allclose(twice["height"][1], once["height"], atol=1e-15)
    assert twice["peak_pressure"].values.tolist() == [1e8, 2e8]
    assert np.isfinite(twice["mean_pressure"].values).sum(axis=1).tolist() == [2, 3]
    page = project.path("results/report.html").read_text()
    section = page[page.index('<section id="unloading">') :]
    # what is left of the load is asked for, and answered first
    answer = json.loads(project.path("results/once/ground/panel.json").read_text())["answer"]
    assert answer.startswith("After 200 MPa the contact area as solved at 20.0 MPa is ")
    assert " on unloading. On loading, at " in answer
    assert section.count("the contact area as solved at") == 3
    for curve in ("contact area", "mean gap", "elastic stiffness"):
        assert section.count(f"{curve} on loading and on unloading") == 2
    assert "conductance on loading" not in section  # no conductivity is stated
    assert 'href="once/ground/residual.nc"' in section
    assert project.jobs() == {}
    # the file is a map like any other, which a study can solve
    height = read_height_map(project.path("results/once/ground/residual.nc"))
    np.testing.assert_array_equal(height.values, once["height"].values)
    project.write(
        project.settings | {"cases": {"again": {"contact": {"hardness": None}}}},
        [TABLE[0], "again\tresults/once/ground/residual.nc"],
    )
    project.succeed()
    second_result = read_dataset(project.path("results/again/again/statistics.nc"))
    areas = second_result["relative_contact_area_pixels"].values
    np.testing.assert_allclose(areas, once["relative_contact_area_pixels"].values[::-1], rtol=0.02)
