"""Profiles from the table to the report, with each lay that may be stated."""

import json

import numpy as np
import pandas as pd
import pytest
from known_surfaces import self_affine
from small_project import SETTINGS, Project

from roughcontact import evaluate, read_dataset, read_height_map


@pytest.fixture(scope="module")
def project(tmp_path_factory, checkout):
    """Return a finished project with three profiles of one surface as ridges, as a surface, and unstated."""
    project = Project(tmp_path_factory.mktemp("profiles"), checkout)
    surface = self_affine((128, 128), 1.0, (8, 32), rms_gradient=0.1, seed=1)
    columns = {"x (um)": np.arange(128.0)} | {f"z{k} (um)": surface.values[40 * k] for k in (1, 2, 3)}
    pd.DataFrame(columns).to_csv(project.path("measured/stylus.csv"), index=False)
    table = [
        "surface\tpath\tchannel\tlay",
        "ridges\tmeasured/stylus.csv\tz1\tacross",
        "surface\tmeasured/stylus.csv\tz1; z2; z3\tnone",
        "unstated\tmeasured/stylus.csv\tz1\t",
    ]
    settings = {**SETTINGS, "uncertainty": {"sources": ["solver", "window"], "windows": 4}}
    project.write(settings=settings, table=table)
    project.succeed()
    return project


def test_the_lay_decides_what_is_solved(project):
    shapes = {
        name: read_dataset(project.path(f"results/{name}/window.nc"))["height"].shape
        for name in ("ridges", "surface", "unstated")
    }
    assert shapes["ridges"] == shapes["unstated"]
    assert shapes["ridges"][0] == 1
    assert shapes["surface"] == (128, 128)
    assert read_dataset(project.path("results/surface/height.nc"))["height"].shape == (3, 128)


def test_the_report_asks_for_the_lay_with_both_numbers(project):
    statistics = read_dataset(project.path("results/unstated/statistics.nc"))
    reasons = [
        reason["text"] for reason in json.loads(statistics.attrs["reasons"]) if reason["check"] == "Lay"
    ]
    assert "of an isotropic surface" in reasons[0]
    assert "State lay = across" in project.path("results/report.html").read_text()
    with_lay = read_dataset(project.path("results/ridges/statistics.nc"))
    assert not [reason for reason in json.loads(with_lay.attrs["reasons"]) if reason["check"] == "Lay"]


def test_profiles_along_a_lay_stretch_the_surface_of_those_across_it(project):
    """The rows give what the same profiles give in Python; another profile along makes them again."""
    table = [
        "surface\tpath\tchannel\tlay\tgroup",
        "over\tmeasured/stylus.csv\tz1; z2\tacross\tfinish",
        "with\tmeasured/along.csv\t\talong\tfinish",
    ]
    positions, heights = np.arange(0, 256, 2.0), 0.5 * np.sin(np.arange(0, 256, 2.0) / 9)
    pd.DataFrame({"x (um)": positions, "z (um)": heights}).to_csv(
        project.path("measured/along.csv"), index=False
    )
    settings = {**SETTINGS, "uncertainty": {"sources": ["solver", "window"], "windows": 4}}
    project.write(settings=settings, table=table)
    project.succeed()
    rows = pd.read_csv(project.path("results/summary.csv"))
    assert set(rows["surface"]) == {"over"}
    across = [read_height_map(project.path("measured/stylus.csv"), channel=z) for z in ("z1", "z2")]
    along = read_height_map(project.path("measured/along.csv"))
    sections = {name: settings[name] for name in ("level", "contact", "uncertainty") if name in settings}
    python = evaluate(across, along=along, lay="across", **sections)
    statistics = read_dataset(project.path("results/over/statistics.nc"))
    for name in ("relative_contact_area", "relative_contact_area_upper", "mean_gap"):
        np.testing.assert_allclose(statistics[name], python[name], rtol=1e-6)
    measured = project.path("measured/along.csv")
    pd.read_csv(measured).assign(**{"z (um)": 2 * heights}).to_csv(measured, index=False)
    assert project.jobs() == {"prepare": 1, "contact": 1, "panel": 1, "report": 1}


def test_mistakes_in_the_lay_are_named_before_anything_runs(project):
    project.write(table=["surface\tpath\tlay", "a\tmeasured/stylus.csv\talong"])
    run = project.run("--dry-run")
    assert run.returncode != 0
    assert "a profile along the lay runs on one ridge" in run.stderr
