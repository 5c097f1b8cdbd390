"""A map with a coarser map of a larger field around it, in the workflow, the program, and a plain call."""

import json
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine
from small_project import ROOT, Project

import roughcontact as rc
from roughcontact import read_dataset
from roughcontact.arguments.answers import ENDS, FRICTION
from roughcontact.surface.faces.placing import recorded_place, separate_overviews

SETTINGS = {
    "surfaces": "surfaces.tsv",
    "contact": {"contact_modulus": "1e9", "mean_pressure": [1e7], "tolerance": "1e-5"},
    "uncertainty": {"sources": ["solver", "window"]},
}
TABLE = ("surface\tpath\tunit\tdx\tdy\toverview", "ground\tmeasured/fine.npy\tum\t1\t1\tmeasured/field.txt")
OF_TWO_POSITIONS = (
    f"{TABLE[0]}\toverview_position\tgroup",
    f"{TABLE[1]}\t\tface",
    "second\tmeasured/second.npy\tum\t1\t1\tmeasured/other.txt; measured/field.txt\t{position}\tface".format(
        position="108 108 um; elsewhere"
    ),
)
HEADER = "# Width: 216 um\n# Height: 216 um\n# Value units: um\n"


def write_pair(folder, *, elsewhere=False):
    """Write two maps of 72 x 72 points, and the field around each, text with the top row first."""
    surface = self_affine((300, 300), 1.0, (6, 200), rms_gradient=0.1, seed=7)
    for first, names in ((0, ("fine.npy", "field.txt")), (84, ("second.npy", "other.txt"))):
        field = surface[first : first + 216, first : first + 216]
        fine = field.values[72:144, 72:144]
        np.save(folder / names[0], fine[::-1].T if elsewhere else fine)
        coarse = field.coarsen(y=3, x=3).mean().values
        rows = "\n".join("\t".join(f"{height:.6g}" for height in row) for row in coarse[::-1])
        (folder / names[1]).write_text(HEADER + rows + "\n")


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """Return a project whose run has finished."""
    project = Project(tmp_path_factory.mktemp("overview"), ROOT)
    write_pair(project.path("measured"))
    project.write(SETTINGS, OF_TWO_POSITIONS)
    project.succeed()
    return project


def test_a_run_gives_what_evaluate_gives(project):
    found = xr.load_dataset(project.path("results/ground/statistics.nc"))
    fine = rc.read_height_map(project.path("measured/fine.npy"), unit="um", dx=1, dy=1)
    field = rc.read_height_map(project.path("measured/field.txt"), unit="um")
    options = {key: value for key, value in SETTINGS.items() if key != "surfaces"}
    expected = rc.evaluate(fine, overview=field, **options)
    for name in ("mean_gap", "mean_gap_lower", "mean_gap_upper", "mean_gap_alone_upper", "mean_gap_joint"):
        assert found[name].values == pytest.approx(expected[name].values, rel=1e-6)
    assert found.attrs["overview"] == expected.attrs["overview"]
    assert "gap known to" in found.attrs["overview"]


def test_page_and_log_say_what_it_brought(project):
    page = project.path("results/report.html").read_text()
    assert "without the overview" in page
    assert "The map lies at (" in project.path("logs/ground/prepare_with_overview.log").read_text()


def test_the_overview_is_read_and_placed_once(project):
    first, second = (
        json.loads(project.path(f"logs/ground/{rule}.json").read_text())["sources"]
        for rule in ("prepare_with_overview", "contact")
    )
    assert set(first) == {"measured/fine.npy", "measured/field.txt"}
    assert second == {}
    (overview,) = separate_overviews(read_dataset(project.path("results/ground/overview.nc")))
    place = recorded_place(overview)
    assert [place.y, place.x] == pytest.approx([107.5e-6, 107.5e-6], abs=1e-6)  # middle of the map


def test_several_overviews_and_positions_have_one_answer_and_are_drawn(project):
    found = xr.load_dataset(project.path("results/second/statistics.nc"))
    log = project.path("logs/second/prepare_with_overview.log").read_text()
    assert "measured/other.txt: The map lies at (" in log
    assert "measured/field.txt: Another position of the face" in log
    assert found.attrs["window_reason"].count("An overview") == 2
    panel = project.path("results/second/panel.html").read_text()
    assert panel.count("<figcaption>Overview") + panel.count(">Overview") >= 2
    (group,) = project.rows("groups.csv")
    gaps = [
        xr.load_dataset(project.path(f"results/{name}/statistics.nc"))["mean_gap"].item()
        for name in ("ground", "second")
    ]
    # of several positions each is the surface over its overviews, and the group their mean
    assert float(group["mean_gap"]) == pytest.approx(np.sqrt(np.prod(gaps)), rel=1e-6)


def test_another_overview_makes_the_result_again(project):
    assert project.jobs() == {}
    path = project.path("measured/field.txt")
    path.write_text(path.read_text().rstrip("\n") + "\n\n")
    assert project.jobs() == {"prepare_with_overview": 2, "contact": 2, "panel": 2, "report": 1}
    path.write_text(path.read_text().rstrip("\n") + "\n")


def test_the_program_takes_it_as_an_option(project):
    words = [sys.executable, "-m", "roughcontact.interface", "solve", "measured/fine.npy", "--json"]
    words += ["--unit", "um", "--dx", "1", "--dy", "1", "--contact-modulus", "1e9"]
    words += [
        "--relative-pressure",
        "0.1",
        "--uncertainty-sources",
        "window",
        "--overview",
        "measured/field.txt",
        "-o",
        "page.html",
    ]
    run = subprocess.run(words, cwd=project.folder, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert "without the overview" in json.loads(run.stdout)["overview"]
    assert "Overview, the map in it" in project.path("page.html").read_text()


def test_an_overview_of_another_place_is_refused_before_anything_is_solved(tmp_path):
    project = Project(tmp_path, ROOT)
    write_pair(project.path("measured"), elsewhere=True)
    project.write(SETTINGS, TABLE)
    run = project.run()
    assert run.returncode != 0
    assert "overview: field.txt does not show the place of fine.npy: it fits best at (" in run.stderr
    assert "(surfaces.tsv, line 2)" in run.stderr
    assert not project.path("results/ground/contact.nc").exists()


@pytest.mark.slow
def test_rubber_slides_over_a_map_with_an_overview(tmp_path):
    """The places of the overview are part of the ± of the friction, as in a plain call."""
    project = Project(tmp_path / "project", ROOT)
    write_pair(project.path("measured"))
    bodies = [{"relaxation": "EPDM-70"}, "rigid"]
    contact = {"contact": {"bodies": bodies, "mean_pressure": 5e4}, "sliding": {"speed": 0.1}}
    project.write(SETTINGS | contact, TABLE)
    project.succeed()
    slid = read_dataset(project.path("results/ground/sliding.nc"))
    friction, lower, upper = (slid[f"{FRICTION}{end}"].item() for end in ENDS)
    assert 0 < lower < friction < upper
    project.write(SETTINGS | contact, [line.rpartition("\t")[0] for line in TABLE])
    project.succeed()
    alone = read_dataset(project.path("results/ground/sliding.nc"))
    assert alone[f"{FRICTION}_upper"].item() / alone[f"{FRICTION}_lower"].item() < upper / lower
