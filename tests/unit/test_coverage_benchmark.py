"""The benchmark of coverage counts what it says, and leaves out what is no map."""

import intervals
import numpy as np
import pytest

from roughcontact.contact.solve import solve_contact
from roughcontact.levelling.level import level
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.results.storage import write_dataset
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.uncertainty.headline import QUANTITIES
from roughcontact.window.periodic_window import periodic_window


def part(inside, *, verdict=0):
    """Return a row whose truth, 1.1, is inside an interval of the result, 1, at the first loads."""
    upper = [1.2] * inside + [1.05] * (3 - inside)
    of_each = {"truth": [1.1] * 3, "result": [1.0] * 3, "lower": [0.8] * 3, "upper": upper}
    of_each |= {"resolved_lower": [1.05] * 3, "resolved_upper": [1.15] * 3, "verdict": [verdict] * 3}
    return {"reasons": []} | dict.fromkeys(QUANTITIES, of_each)


def test_shares_are_counted():
    parts = [part(3), part(1, verdict=1), part(2)]
    results = intervals.results_of([{"group": "large", "name": "one.sur", "parts": parts}])
    counted = intervals.counted(results)
    assert counted["area inside (%)"] == counted["peak inside (%)"] == pytest.approx(100 * 6 / 9)
    # outside: two of the part to review, one of another
    assert counted["silent (%)"] == pytest.approx(100 / 9)
    assert results["error"].values == pytest.approx(0.1)
    assert counted["gap width"] == pytest.approx(np.median([0.2] * 6 + [0.125] * 3) / 0.1)


def test_tables_name_surfaces_and_all_of_each_group():
    found = [
        {"group": "large", "name": "one.sur", "parts": [part(3), {"refused": "too much is missing"}]},
        {"group": "small", "name": "two.x3p", "parts": [part(2)]},
        {"group": "made", "name": "worn", "longest": 1 / 3, "seed": 1, "parts": [part(3)]},
    ]
    tables = intervals.tables(found)
    rows = tables["surfaces"].set_index(["group", "surface"])
    assert rows.index.get_level_values(1).tolist() == [
        "one.sur",
        "all",
        "two.x3p",
        "all",
        "worn",
        "all",
        "0.333",
        "all",
    ]
    assert rows.loc[("large", "one.sur"), ["parts", "area inside (%)", "area width"]].tolist() == [
        "1",
        "100",
        "2.0",
    ]
    assert rows.loc[("small", "all"), "gap inside (%)"] == "67"
    assert tables["loads"].loc[4].tolist() == ["small", "area", "100", "100", "0"]
    resolved = tables["resolved"].set_index("group").loc["small"]
    assert resolved[["gap inside (%)", "gap"]].tolist() == ["100", "0.5"]
    verdicts = tables["verdicts"].set_index(["group", "quantity"])
    assert verdicts.loc[("small", "all")].tolist() == ["100.0", "66.7", "0.0"]


def test_files_that_are_no_maps_are_left_out(tmp_path):
    words = tmp_path / "notes.txt"
    words.write_text("no numbers here")
    assert intervals.real_map(words) is None
    small = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=8e-6, longest=3e-5, rms_gradient=0.1)
    write_dataset(small.to_dataset(name="height"), tmp_path / "small.nc")
    assert intervals.real_map(tmp_path / "small.nc") is None


def test_the_true_pressure_in_contact_is_the_load_over_the_area():
    """Of a map that is coarse for its contact, where the mean over whole pixels falls short of it by far."""
    height = self_affine_surface((64, 64), 1e-6, hurst=0.8, shortest=4e-6, longest=3e-5, rms_gradient=0.1)
    solved = solve_contact(
        height, contact_modulus=1.0, mean_pressure=[0.002, 0.01], reduce=contact_statistics
    )
    truth = intervals.truth_of(solved)
    assert truth["mean_gap"] == solved["mean_gap"].values.tolist()
    area = np.array(truth["relative_contact_area"])
    np.testing.assert_allclose(np.array(truth["mean_contact_pressure"]) * area, [0.002, 0.01], rtol=1e-12)
    assert (solved["mean_contact_pressure"] < 0.97 * np.array(truth["mean_contact_pressure"])).all()


def test_a_part_is_measured_with_its_interval():
    height = self_affine_surface((96, 96), 1e-6, hurst=0.8, shortest=8e-6, longest=3e-5, rms_gradient=0.1)
    levelled = level(height[:80, :80])
    assert periodic_window(levelled).size < 6400
    truth = {name: [1.0, 1.0] for name in QUANTITIES}
    row = intervals.measure(height[:80, :80], [0.002, 0.01], truth)
    for name in QUANTITIES:
        assert (np.array(row[name]["lower"]) < row[name]["result"]).all()
        assert (np.array(row[name]["upper"]) > row[name]["result"]).all()
        assert (np.array(row[name]["resolved_lower"]) >= row[name]["lower"]).all()
        upper = np.nan_to_num(row[name]["upper"], nan=np.inf)
        assert (np.array(row[name]["resolved_upper"]) <= upper * (1 + 1e-12)).all()
    empty = height.copy()
    empty[:, ::2] = np.nan
    assert "missing" in intervals.measure(empty, [0.002], truth)["refused"]
