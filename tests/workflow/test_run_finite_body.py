"""A ball and a punch with the roughness of a measured map, from the settings to the report."""

import numpy as np
import pytest
import xarray as xr
from small_project import SETTINGS, TABLE, project_with_maps

import roughcontact as rc
from roughcontact.contact.elasticity.closed_forms import hertz
from roughcontact.results.storage import read_dataset

FREE = {"contact_modulus": "1 GPa", "boundary": "free", "force": ["1 mN", "2 mN"]}
SETTINGS_OF_BODIES = {
    **{key: value for key, value in SETTINGS.items() if key != "contact"},
    "contact": FREE,
    "cases": {
        "ball": {"form": {"radius": "1 mm"}},
        "punch": {"form": {"edges": True}},
        "local": {"contact": {"boundary": "periodic"}, "form": {"radius": "1 mm", "local_scale": True}},
    },
}


@pytest.mark.slow
def test_bodies_of_finite_size_go_from_the_settings_to_the_report(tmp_path, checkout):
    project = project_with_maps(tmp_path / "project", checkout, SETTINGS_OF_BODIES, TABLE[:2])
    project.succeed()
    for case in ("ball", "punch"):
        folder = project.path(f"results/{case}/ground")
        statistics = read_dataset(folder / "statistics.nc").load()
        contact = read_dataset(folder / "contact.nc").load()
        window = read_dataset(folder / "window.nc")["height"].load()
        directly = rc.solve_contact(window, **FREE)
        xr.testing.assert_allclose(contact["pressure"], directly["pressure"])
        np.testing.assert_allclose(statistics["force"], [1e-3, 2e-3])
        assert ("hertz_radius" in statistics) == (case == "ball")
        assert (np.diff(statistics["contact_area"]) > 0).all()
    local = read_dataset(project.path("results/local/ground/statistics.nc")).load()
    np.testing.assert_allclose(local["force"], [1e-3, 2e-3])
    exact = [hertz(force, 1e-3, 1e9)["max_pressure"] for force in (1e-3, 2e-3)]
    np.testing.assert_allclose(local["mean_pressure"], exact)
    assert (local["local_contact_area"] < np.pi * local["hertz_radius"] ** 2).all()
    assert (local["local_contact_area_lower"] < local["local_contact_area"]).all()
    summary = project.path("results/summary.csv").read_text()
    assert "local_contact_area_upper_m2" in summary
    assert "local_conductance_per_conductivity_lower_m," in summary
    page = project.path("results/report.html").read_text()
    assert "Body of finite size" in page
    assert "on a body of finite size" in page
    panel = project.path("results/local/ground/panel.html").read_text()
    assert "Whole contact, each place as the map there" in panel
