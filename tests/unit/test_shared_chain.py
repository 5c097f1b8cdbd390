"""Every file of the catalogue as a new user would take it: name and path, all settings at their defaults."""

import csv
import json
import warnings

import numpy as np
import pytest
from shared_data import DATA
from test_io_shared import FILES, NAMES, READ

from roughcontact.contact.solve import solve_contact
from roughcontact.errors import HeightMapError, HeightMapWarning, InputFileError
from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map
from roughcontact.statistics import checks
from roughcontact.statistics.contact_statistics import contact_statistics, with_uncertainty
from roughcontact.statistics.outcome import REVIEW, worst_result
from roughcontact.statistics.outcome import VERDICTS as WORDS
from roughcontact.statistics.theory import persson_area
from roughcontact.surface.levelling.level import level
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window.periodic_window import periodic_window
from roughcontact.uncertainty.budget import error_budget

pytestmark = pytest.mark.shared_data

LARGEST = 160  # points along a side that are solved: the middle of the map
LOAD = 0.05
# checks that speak of how small that part is, of what any lens leaves out, or of a load not asked for
# on a material that was not named: no matter of the file
OF_THE_PART = {"Longest wave", "Band", "Plasticity"}

# What the checks must say of a file, beyond what is common to all: verdict, and checks that ask for a look.
VERDICTS = {
    # focus variation, which averages over several pixels: their spectra end before the pixel
    "KautschukInfiniteFocus.x3p": ("review", {"Smoothed"}),
    "al3d-1.al3d": ("review", {"Smoothed"}),
    "tmd-1.tmd": ("use", set()),
    "matrix-3.txt": ("use", set()),
    # made by hand: 4 x 4 points, heights of metres on a field of centimetres
    "ISO5436-sample1.x3p": ("do not use", {"Points in contact", "Reading the file"}),
    "ISO5436-sample4_bin.x3p": ("do not use", {"Points in contact", "Reading the file"}),
    "mnt-2.mnt": ("review", {"Form"}),  # a bow of 100 times the roughness
    # particles on a smooth surface, and 3000 points far off all others, are noted
    "spot_1-1000nm.ibw": ("use", set()),
    "bcrf-1.bcrf": ("use", set()),
    "plu-1.plu": ("review", {"Quantisation"}),  # steps of 4 nm on a roughness of 18 nm; no ± is asked for
    "x3p-2.x3p": ("use", set()),  # pixels that are not square are noted
}


@pytest.fixture(scope="module")
def catalogue():
    """The rows of the catalogue by name of the file."""
    with (DATA / "CATALOG.tsv").open(encoding="utf-8", newline="") as file:
        return {row["file"]: row for row in csv.DictReader(file, delimiter="\t")}


def test_no_file_is_left_out(catalogue):
    assert set(FILES) == set(catalogue)


@pytest.mark.parametrize("name", NAMES["refused"])
def test_what_is_no_map_is_refused_in_one_sentence(name):
    for verb in (inspect_file, read_height_map):
        with pytest.raises(InputFileError, match=FILES[name]["refused"]) as caught:
            verb(DATA / name)
        assert "\n" not in str(caught.value)
        assert name in str(caught.value)
        assert len(str(caught.value)) < 300


@pytest.mark.parametrize("name", NAMES["given"])
def test_a_file_that_is_silent_says_what_to_give(name):
    with pytest.raises(InputFileError, match="in the table of surfaces") as caught:
        read_height_map(DATA / name)
    words = str(caught.value).partition("; give ")[2].partition(" in the table")[0]
    arguments_asked = set(words.replace("(or unit)", "").replace(",", " ").split())
    assert arguments_asked <= {
        *FILES[name]["given"],
        "unit",
        "height_unit",
    }  # that of heights has an answer of its own
    assert inspect_file(DATA / name)["problem"] == str(caught.value)


def test_a_map_that_is_mostly_missing_is_refused_with_its_share():
    height = read_height_map(DATA / "sur-3.sur")
    with pytest.raises(HeightMapError, match=r"88\.9 % of the points are missing.*level\.max_missing"):
        level(height)


@pytest.mark.parametrize("name", [name for name in READ if name != "sur-3.sur"])
def test_from_the_file_to_the_verdict(name, catalogue):
    options = FILES[name].get("given", {})
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # nothing that a user could not read
        warnings.simplefilter("ignore", HeightMapWarning)  # of maps of a few points
        height = read_height_map(DATA / name, **options)
        contents = inspect_file(DATA / name, **options)
        part = _middle(height)
        levelled = level(part)
        window = periodic_window(levelled)
        gradient = rms_gradient(window)
        contact = {"contact_modulus": 1e9, "mean_pressure": [LOAD * 1e9 * gradient]}
        statistics = solve_contact(window, **contact, reduce=contact_statistics)
        budget = error_budget(levelled, window, {"level": {}, "window": {}, "contact": contact}, sources=[])
        statistics = with_uncertainty(statistics, budget)
    assert contents["problem"] is None
    rms_height = float(
        FILES[name].get("otherwise", {}).get("rms") or float(catalogue[name]["rms_height_um"]) * 1e-6
    )
    assert float(np.nanstd(height)) == pytest.approx(rms_height, rel=1e-4)
    # off its plane, and without what stands out, a part has no more than there was
    assert 0 < levelled.attrs["Sq"] <= float(np.nanstd(part)) * 1.0001
    assert levelled.attrs["outliers_rejected"] < 0.01 * part.size
    # the steps of a map of some points do not make its gradient
    assert window.size < 64 or 0.3 < gradient / window.attrs["rms_gradient_before"] < 3
    assert float(statistics["converged"][0]) == 1
    area = float(statistics["relative_contact_area"][0])
    assert 0.5 * persson_area(LOAD) < area < 10 * persson_area(LOAD)
    assert float(statistics["contact_on_filled_points"][0]) < 0.1
    outcome = checks.surface_checks(
        statistics, height=height.attrs, levelled=levelled.attrs, window=window.attrs, points=window.size
    )
    looks = {check.name for check in outcome if check.outcome == REVIEW}
    # a sentence for each suspicion of the reader, and no number that no one can read
    reading = next(check.sentence for check in outcome if check.name == "Reading the file")
    assert (reading == "Read without a warning.") == (height.attrs["ingest_warnings"] == "[]")
    assert not any("nan" in check.sentence.split() for check in outcome)
    if name in VERDICTS:
        verdict, wanted_looks = VERDICTS[name]
        of_the_file = [check for check in outcome if check.name not in OF_THE_PART]
        assert WORDS[worst_result(of_the_file)] == verdict
        assert wanted_looks <= looks
    assert json.loads(levelled.attrs["form_removed"])["slope_x"]["units"] == "1" or 1 in height.shape


def _middle(height):
    """Return the middle of a map, no larger than what is solved here; of a profile all of it."""
    if 1 in height.shape:
        return height
    starts = [max(0, (n - LARGEST) // 2) for n in height.shape]
    return height.isel({d: slice(s, s + LARGEST) for d, s in zip("yx", starts, strict=True)})
