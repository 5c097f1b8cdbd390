"""The same place measured twice: before and after something was done to it, or as a repeat, in a run."""

import json
import re
import shutil

import numpy as np
import pytest
from small_project import SETTINGS, Project

from roughcontact import read_dataset, self_affine_surface

NOISE = 2e-9  # m
HEADER = "surface\tpath\tunit\theight_unit\tdx\tdy\tbefore\trepeat_of"
ROWS = {name: f"{name}\tmeasured/{name}.npy\tum\tum\t1\t1\t" for name in ("new", "again", "worn")}
PLACES = [HEADER, f"{ROWS['new']}\t", f"{ROWS['again']}\tnew", f"{ROWS['worn']}new\t"]
AS_REPEAT = [HEADER, f"{ROWS['new']}\t", f"{ROWS['worn'].replace('worn.npy', 'flat.npy')}\tnew"]
LOADS = SETTINGS | {"contact": {"contact_modulus": "10 MPa", "mean_pressure": ["20 kPa", "100 kPa"]}}


@pytest.fixture(scope="module")
def worn(tmp_path_factory, checkout):
    """A finished project: a place, measured twice, and once more after its top 10 % were flattened."""
    project = Project(tmp_path_factory.mktemp("project"), checkout)
    waves = {"hurst": 0.8, "shortest": 4e-6, "longest": 48e-6, "rms_height": 300e-9}
    field = self_affine_surface((192, 192), 1e-6, **waves, seed=3)
    generator = np.random.default_rng(1)
    flattened = field.clip(max=float(field.quantile(0.9)))
    new, beside = field[:128, :128], flattened[6:134, 3:131]  # where the part was put back
    heights = {"new": new, "again": new, "worn": beside, "flat": flattened[:128, :128]}
    for name, height in heights.items():
        noise = NOISE * generator.standard_normal(height.shape)
        np.save(project.path(f"measured/{name}.npy"), 1e6 * (height.values + noise))
    project.write(LOADS, PLACES)
    project.succeed()
    return project


def stated(project, name):
    return read_dataset(project.path(f"results/{name}/height.nc"))["height"].attrs


@pytest.mark.slow
def test_wear_is_a_difference_and_no_noise(worn):
    compared = worn.rows("comparisons.csv")
    outcomes = {
        (row["first"], row["second"], float(row["mean_pressure_Pa"])): row["outcome"]
        for row in compared
        if row["quantity"] == "relative_contact_area"
    }
    assert outcomes["new", "worn", 2e4] == "differ"
    assert outcomes["new", "again", 2e4].startswith("do not differ by more than ")
    for name in ("new", "again"):
        assert stated(worn, name)["instrument_noise"] == pytest.approx(NOISE, rel=0.1)
    assert "instrument_noise" not in stated(worn, "worn")
    heights = [read_dataset(worn.path(f"results/{name}/height.nc"))["height"] for name in ("new", "worn")]
    assert heights[0].shape == heights[1].shape == (122, 125)
    (found, cropped) = json.loads(heights[1].attrs["ingest_warnings"])
    assert re.fullmatch(
        r"the place of new, shifted by \((2\.9|3\.0)\d µm, (5\.9|6\.0)\d µm\),.* correlation 0\.9\d", found
    )
    assert cropped == "cropped to 125 × 122 of 128 × 128 points, which all maps of the place show"


@pytest.mark.slow
def test_another_place_is_refused_before_anything_is_solved(worn):
    np.save(worn.path("measured/elsewhere.npy"), np.load(worn.path("measured/new.npy"))[::-1, ::-1])
    row = "elsewhere\tmeasured/elsewhere.npy\tum\tum\t1\t1\tnew\t"
    worn.write(LOADS, [HEADER, f"{ROWS['new']}\t", row])
    run = worn.run()
    assert run.returncode != 0
    assert "before: elsewhere.npy does not show the place of new.npy: its middle fits " in run.stderr


@pytest.mark.slow
def test_wear_that_is_called_a_repeat_is_named_and_gives_no_noise(worn):
    worn.write(LOADS, AS_REPEAT)
    assert worn.jobs() == {"prepare": 2, "contact": 2, "panel": 2, "report": 1}
    run = worn.succeed()
    for name, partner in (("new", "worn"), ("worn", "new")):
        attrs = stated(worn, name)
        assert "instrument_noise" not in attrs
        (message,) = json.loads(attrs["ingest_warnings"])
        assert message.startswith(f"the repeats {name} and {partner} differ by ")
        assert "not as by noise: " in message
        assert f"warning: {message}" in run.stderr
    (reason,) = {row["reasons"] for row in worn.rows("summary.csv") if row["surface"] == "worn"}
    assert "Reading the file: The repeats worn and new differ by " in reason
    assert "The repeats worn and new differ by " in worn.path("results/report.html").read_text()


@pytest.mark.slow
def test_copies_in_a_group_have_no_answer(worn):
    header = HEADER.replace("before\trepeat_of", "group")
    for name in "abcd":
        shutil.copy(worn.path("measured/new.npy"), worn.path(f"measured/{name}.npy"))
    rows = [f"{name}\tmeasured/{name}.npy\tum\tum\t1\t1\tfinish" for name in "abcd"]
    worn.write(LOADS | {"uncertainty": {"sources": ["solver"]}}, [header, *rows])
    run = worn.succeed()
    message = "group finish: a and b have the same results, as copies of one map have"
    assert message in run.stderr
    assert message in worn.path("results/report.html").read_text()
    assert worn.rows("groups.csv") == []
