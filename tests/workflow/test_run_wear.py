"""A face slides in a run: worn.nc, its section of the page, the worn surface solved again."""

import numpy as np
import pytest
from small_project import project_of_cases

from roughcontact import read_dataset, read_height_map
from roughcontact.report.summary import read_summary

CONTACT = {"contact_modulus": "100 GPa", "mean_pressure": ["20 MPa", "100 MPa"]}
WEAR = {"coefficient": "1e-7 mm³/(N m)", "distance": ["1 mm", "10 mm", "100 mm"]}
CASES = {"plain": {}, "worn": {"wear": WEAR, "uncertainty": {"sources": ["discretisation"]}}}
COATED = {"youngs_modulus": "115 GPa", "poissons_ratio": 0.3}
COATED |= {"layers": [{"thickness": "1 nm", "youngs_modulus": "200 GPa", "poissons_ratio": 0.2}]}


@pytest.mark.slow
def test_wear_goes_from_the_settings_to_the_page(tmp_path, checkout):
    project = project_of_cases(tmp_path / "project", checkout, CONTACT, CASES)
    project.succeed()
    # the cases differ in what follows the contact, which is solved once
    assert not project.path("results/plain/ground/worn.nc").exists()
    assert not project.path("results/worn/ground/contact.nc").exists()
    loaded = read_dataset(project.path("results/plain/ground/statistics.nc"))
    worn = read_dataset(project.path("results/worn/ground/worn.nc"))
    assert worn["sliding_distance"].values.tolist() == [0.0, 1e-3, 1e-2, 0.1]
    before, area = (data["relative_contact_area_pixels"].values for data in (loaded, worn))
    assert area[0] == pytest.approx(before[1], rel=1e-3)  # at the largest load
    np.testing.assert_allclose(worn["worn_volume"], 1e-16 * 1e8 * worn["sliding_distance"], rtol=1e-12)
    assert (worn["relative_contact_area_lower"] <= worn["relative_contact_area"]).all()
    first = "No running-in is seen: up to 0.100 m the contact area nowhere grows by 10 % while the distance"
    answer = read_summary(project.path("results/worn/ground/panel.html"))["answer"]
    assert answer.startswith(first)
    assert "hardly begun to wear. Before sliding, at 100 MPa: contact area " in answer
    page = project.path("results/report.html").read_text()
    section = page[page.index('<section id="wear">') :]
    assert section.count("the face has lost 1.00 nm in the mean") == 1
    assert "contact area over the distance" in section
    assert 'href="worn/ground/worn.nc"' in section
    assert project.jobs() == {}
    # the worn heights are a map like any other, which a study can solve
    file, last = project.path("results/worn/ground/worn.nc"), "height[sliding_distance=3]"
    height = read_height_map(file, channel=last)
    np.testing.assert_array_equal(height.values, worn["height"].values[-1])


@pytest.mark.slow
def test_a_wear_that_comes_to_nothing_costs_nothing_else(tmp_path, checkout):
    contact = {"bodies": [COATED, "rigid"], "mean_pressure": "100 MPa"}
    project = project_of_cases(tmp_path / "project", checkout, contact, {"worn": {"wear": WEAR}})
    project.succeed()
    reason = "the outermost layer of the first body is 1.00 nm thick; give shorter distances. "
    answer = read_summary(project.path("results/worn/ground/panel.html"))["answer"]
    assert answer.startswith("Wear is not known: ")
    assert f"{reason}Before sliding, at 100 MPa: contact area " in answer
    assert "warning: sliding_distance: after" in project.path("logs/worn/ground/wear.log").read_text()
    page = project.path("results/report.html").read_text()
    section = page[page.index('<section id="wear">') :].partition("</section>")[0]
    assert reason.strip() in section
    assert "<img" not in section
    assert project.rows("summary.csv")[0]["relative_contact_area"]
    assert project.jobs() == {}
