"""Rubber slides over a face in a run: sliding.nc, its section of the page, and a table that is replaced."""

import numpy as np
import pytest
from small_project import project_of_cases

from roughcontact.arguments.answers import FRICTION
from roughcontact.report.summary import read_summary
from roughcontact.results.storage import read_dataset

CONTACT = {"bodies": [{"relaxation": "dma.csv"}, "rigid"], "mean_pressure": ["20 kPa", "50 kPa"]}
SLIDING = {"speed": ["0.1 mm/s", "10 mm/s", "1 m/s"]}
CASES = {"plain": {}, "rubber": {"sliding": SLIDING}}


def write_table(path, factor=1.0):
    """Write the table of a standard linear solid from 3 to 30 MPa."""
    frequency = np.geomspace(1, 1e7, 40)
    phase = 2j * np.pi * frequency * 1e-4
    young = factor * (3 + 27 * phase / (1 + phase))
    rows = [f"{f:.6g},{e.real:.6g},{e.imag:.6g}" for f, e in zip(frequency, young, strict=True)]
    path.write_text("\n".join(["f (Hz),E' (MPa),E'' (MPa)", *rows]) + "\n")


@pytest.mark.slow
def test_sliding_goes_from_the_settings_to_the_page(tmp_path, checkout):
    project = project_of_cases(tmp_path / "project", checkout, CONTACT, CASES)
    refused = project.run()
    assert refused.returncode != 0
    assert "relaxation = dma.csv: not read as a table" in refused.stderr
    write_table(project.path("dma.csv"))
    project.succeed()
    assert not project.path("results/plain/ground/sliding.nc").exists()
    assert not project.path("results/rubber/ground/contact.nc").exists()  # solved once
    slid = read_dataset(project.path("results/rubber/ground/sliding.nc"))
    assert slid["speed"].values.tolist() == [1e-4, 1e-2, 1.0]
    assert float(slid["mean_pressure"]) == 5e4  # the largest load
    assert slid[f"{FRICTION}_lower"].isnull().all()  # without sources of the ±
    answer = read_summary(project.path("results/rubber/ground/panel.html"))["answer"]
    assert answer.startswith("At 50.0 kPa the friction of the hysteresis is highest at ")
    assert ". At rest, at 50.0 kPa: contact area " in answer
    page = project.path("results/report.html").read_text()
    section = page[page.index('<section id="sliding">') :]
    assert section.count("the friction of the hysteresis is highest at") == 1
    assert 'href="rubber/ground/sliding.nc"' in section
    assert project.jobs() == {}
    write_table(project.path("dma.csv"), factor=2.0)
    assert set(project.jobs()) >= {"slide", "report"}
