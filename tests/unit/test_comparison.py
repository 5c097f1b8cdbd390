"""Two runs side by side."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from roughcontact import InputFileError, compare_statistics, height_map, write_dataset
from roughcontact.interface.program import main
from roughcontact.results.collect import collect_statistics

LOADS = [1e6, 5e6]


def statistics(*, gaps=(2e-7, 1e-7), half_width=3e-9, loads=LOADS, area=(0.1, 0.3)):
    """Return statistics of one surface: a gap with an uncertainty, an area without one."""
    numbers = {
        "mean_gap": ("load", list(gaps)),
        "relative_contact_area": ("load", list(area)),
        "iterations": ("load", [2] * len(loads)),
        "rms_height": 1e-7,
    }
    if half_width is not None:
        components = np.tile([[half_width / 2, half_width]], (len(loads), 1))
        numbers["mean_gap_uncertainty"] = (("load", "source"), components)
    coordinates = {"mean_pressure": ("load", list(loads)), "source": ["window", "combined"]}
    return xr.Dataset(numbers, coords=coordinates)


def different(earlier, later, **options):
    """Return quantity and pressure of all that differs."""
    table = compare_statistics(earlier, later, **options)
    return list(table[table["differs"]][["quantity", "mean_pressure"]].itertuples(index=False, name=None))


def test_a_change_counts_beyond_the_root_of_both_squares():
    limit = np.hypot(3e-9, 4e-9)
    for change, differences in ((0.999 * limit, []), (1.001 * limit, [("mean_gap", 1e6)])):
        for sign in (-1, 1):
            changed = statistics(gaps=(2e-7 + sign * change, 1e-7), half_width=4e-9)
            assert different(statistics(), changed) == differences


def test_each_end_of_an_interval_counts_on_its_side():
    earlier, later = statistics(half_width=5e-9), statistics(gaps=(2.04e-7, 1e-7), half_width=5e-9)
    assert different(earlier, later) == []
    # towards the other run's gap both intervals are narrow, away from it they are wide
    earlier["mean_gap_lower"], earlier["mean_gap_upper"] = earlier.mean_gap - 5e-9, earlier.mean_gap + 1e-9
    later["mean_gap_lower"], later["mean_gap_upper"] = later.mean_gap - 1e-9, later.mean_gap + 5e-9
    assert different(earlier, later) == [("mean_gap", 1e6)]
    assert different(later, earlier) == [("mean_gap", 1e6)]


def test_a_share_judges_every_number_and_no_count_of_work():
    changed = statistics(gaps=(2.02e-7, 1e-7), area=(0.1, 0.3 * 1.02)).assign(iterations=("load", [9, 9]))
    table = compare_statistics(statistics(), changed, share=0.015)
    assert sorted(set(table["quantity"])) == ["mean_gap", "relative_contact_area", "rms_height"]
    assert different(statistics(), changed, share=0.015) == [("relative_contact_area", 5e6)]
    assert different(statistics(), changed, share=0.03) == []


def test_missing_numbers_are_equal_to_missing_ones_only():
    nothing = statistics(area=(np.nan, 0.3))
    assert different(nothing, nothing, share=0.01) == []
    assert different(nothing, statistics(), share=0.01) == [("relative_contact_area", 1e6)]


def test_a_number_that_got_lost_or_has_no_end_differs(tmp_path, capsys):
    earlier = statistics()
    lost = earlier.drop_vars(["mean_gap", "mean_gap_uncertainty", "rms_height"])
    assert different(earlier, lost) == [("mean_gap", load) for load in LOADS]
    assert len(different(earlier, lost, share=0.01)) == 4
    assert different(lost, earlier, share=0.01) == []
    endless = statistics(gaps=(np.inf, 1e-7))
    assert different(earlier, endless) == [("mean_gap", 1e6)]
    assert different(endless, endless) == []
    files = [str(tmp_path / name) for name in ("before.nc", "lost.nc", "endless.nc")]
    for dataset, file in zip((earlier, lost, endless), files, strict=True):
        write_dataset(dataset, file)
    assert main(["compare", *files[:2]]) == 1
    assert capsys.readouterr().out.splitlines()[0] == "at 1.00 MPa  mean_gap  200 nm → nothing"
    assert main(["compare", files[0], files[2], "--share", "0.1"]) == 1
    assert capsys.readouterr().out.splitlines()[0] == "at 1.00 MPa  mean_gap  200 nm → ∞ m"


def test_a_load_of_one_run_alone_differs():
    shifted = statistics(gaps=(2e-7,), area=(0.1,), loads=[1e6 * (1 + 5e-4)])
    assert different(statistics(), shifted) == [("mean_pressure", 5e6)]
    assert different(shifted, statistics()) == [("mean_pressure", 5e6)]


def test_loads_belong_together_by_value():
    """In whatever order they are, and beside loads that the other run lacks."""
    turned = statistics(gaps=(1e-7, 2e-7), area=(0.3, 0.1), loads=LOADS[::-1])
    assert different(statistics(), turned, share=1e-6) == []
    partly_common = statistics(gaps=(9e-7, 1e-7), area=(0.01, 0.3), loads=[1e4, 5e6])
    assert different(statistics(), partly_common, share=1e-6) == [
        ("mean_pressure", 1e6),
        ("mean_pressure", 1e4),
    ]


@pytest.mark.parametrize("share", [1e-6, None])
def test_loads_of_other_bodies_belong_together_by_their_relative_pressure(share):
    """And are named by the pressure that they had in the run before."""
    earlier = statistics().assign(relative_pressure=("load", [0.01, 0.05]))
    later = statistics(gaps=(1e-7, 2e-7), area=(0.3, 0.1), loads=[15e6, 3e6])
    later = later.assign(relative_pressure=("load", [0.05, 0.01]))
    table = compare_statistics(earlier, later, share=share)
    assert list(table["mean_pressure"].unique()) == LOADS
    assert not table["differs"].any()
    lost = compare_statistics(earlier, later.drop_vars(["mean_gap", "mean_gap_uncertainty"]), share=share)
    assert list(lost["mean_pressure"].unique()) == LOADS


def test_a_load_that_was_left_out_does_not_bring_others_together():
    def run(modulus, *loads):
        """A gap that the load alone decides, and a relative pressure."""
        same = statistics(gaps=loads, loads=loads, area=loads)
        return same.assign_coords(relative_pressure=("load", np.divide(loads, modulus)))

    assert different(run(1e9, 1e6, 2e6, 4e6), run(2e9, 2e6, 4e6)) == [("mean_pressure", 1e6)]
    # a target that comes at twice the load, beside a stated load
    assert different(run(1e9, 2e6, 3e6), run(2e9, 2e6, 6e6)) == [("mean_gap", 3e6)]


def test_surfaces_belong_together_by_name(tmp_path):
    def run(folder, **surfaces):
        for name, dataset in surfaces.items():
            write_dataset(dataset, tmp_path / folder / f"{name}.nc")
        files = {name: tmp_path / folder / f"{name}.nc" for name in surfaces}
        return collect_statistics(
            [{"surface": name, "case": None, "statistics": file} for name, file in files.items()]
        )

    ground, polished = statistics(), statistics(gaps=(4e-7, 3e-7))
    earlier = run("before", ground=ground, polished=polished)
    assert different(earlier, run("same", polished=polished, ground=ground)) == []
    table = compare_statistics(earlier, run("less", ground=polished))
    differing = table[table["differs"]]
    assert list(differing["surface"]) == ["ground", "ground", "polished", "polished"]
    assert list(differing["quantity"]) == ["mean_gap", "mean_gap", "mean_pressure", "mean_pressure"]
    with pytest.raises(InputFileError, match="single surface"):
        compare_statistics(earlier, ground)


def test_what_cannot_be_judged_is_an_error():
    with pytest.raises(InputFileError, match="give the share by which"):
        compare_statistics(statistics(half_width=None), statistics())


def test_the_verb(tmp_path, capsys):
    files = [str(tmp_path / name) for name in ("before.nc", "after.nc")]
    write_dataset(statistics(), files[0])
    write_dataset(statistics(gaps=(2e-7, 1.1e-7)), files[1])
    assert main(["compare", files[0], files[0]]) == 0
    assert capsys.readouterr().out == "0 of 2 numbers differ by more than their ±\n"
    assert main(["compare", *files]) == 1
    output = capsys.readouterr().out.splitlines()
    assert output[0] == "at 5.00 MPa  mean_gap  100 nm → 110 nm  +10 %, 4.24 nm allowed"
    assert output[1] == "1 of 2 numbers differs by more than its ±"
    write_dataset(statistics(loads=(1e6, 7e6)), files[1])
    assert main(["compare", *files]) == 1
    last = capsys.readouterr().out.splitlines()[-1]
    assert last == "0 of 1 numbers differ by more than their ±; 2 loads of one run only"
    write_dataset(statistics(gaps=(2e-7, 1.1e-7)), files[1])
    assert main(["compare", *files, "--share", "0.2"]) == 0
    capsys.readouterr()
    assert main(["compare", *files, "--json"]) == 1
    assert [row["differs"] for row in json.loads(capsys.readouterr().out)] == [False, True]
    assert main(["compare", files[0], str(tmp_path / "nowhere.nc")]) == 2
    assert "nowhere.nc" in capsys.readouterr().err
    assert main(["compare", *files, "--share", "5"]) == 2
    assert "--share 5" in capsys.readouterr().err


def test_what_is_no_statistics_is_refused_in_one_sentence(tmp_path, capsys):
    good, absent, table_file, damaged = (
        str(tmp_path / name) for name in ("a.nc", "b.nc", "summary.csv", "c.nc")
    )
    write_dataset(statistics(), good)
    Path(table_file).write_text("surface,mean_gap_m\n")
    Path(damaged).write_bytes(Path(good).read_bytes()[:3000])
    heights = str(tmp_path / "height.nc")
    write_dataset(height_map([[1e-6, 2e-6], [3e-6, 1e-6]], 1e-6), heights)
    groups = str(tmp_path / "groups.nc")
    write_dataset(xr.Dataset(coords={"mean_pressure": (("group", "load"), [[1e5, 1e6]])}), groups)
    for path, why in (
        (absent, "no such file"),
        (str(tmp_path), "is a folder"),
        (table_file, "is damaged, or no file of a run"),
        (damaged, "is damaged, or no file of a run"),
        (heights, "holds no statistics of contacts"),
        (groups, "holds no statistics of contacts"),
    ):
        assert main(["compare", good, path]) == 2
        assert capsys.readouterr().err.startswith(
            f"roughcontact: {path}: {why}; name the statistics.nc of a run"
        )
