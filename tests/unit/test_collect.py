"""Statistics of several surfaces and cases in one dataset and one table."""

import json
import re
import warnings

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from roughcontact.arguments.maps import height_map
from roughcontact.arguments.variables import ANSWERS, VARIABLES
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import InputFileError, SettingsError
from roughcontact.evaluation.evaluate import evaluate
from roughcontact.results.collect import (
    append_failures,
    collect_statistics,
    column_name,
    summary,
    summary_table,
    table,
)
from roughcontact.results.selection import read_statistics
from roughcontact.results.storage import read_dataset, write_dataset, write_table
from roughcontact.statistics.contact_statistics import contact_statistics, with_uncertainty
from roughcontact.surface.synthetic import rough_reference_surface


def write_statistics(path, loads, *, bins=3, scale=1.0):
    """Write a small statistics file whose numbers say where they come from."""
    loads = np.asarray(loads, float)
    bounds = np.arange(bins + 1.0) * scale
    dataset = xr.Dataset(
        {
            "relative_contact_area": ("load", loads / 1e7),
            "contact_clusters": ("load", np.arange(loads.size) + 5),
            "contact_stiffness": ("load", loads * 2),
            "pressure_density": (("load", "pressure_bin"), np.full((loads.size, bins), 1 / (bins * scale))),
            "rms_height": scale * 1e-6,
        },
        coords={
            "mean_pressure": ("load", loads),
            "pressure_bin_centre": ("pressure_bin", (bounds[1:] + bounds[:-1]) / 2),
            "pressure_bin_bounds": (("pressure_bin", "bounds"), np.column_stack([bounds[:-1], bounds[1:]])),
        },
    )
    write_dataset(dataset, path)
    return path


def test_surfaces_with_different_loads_and_bins(tmp_path):
    entries = [
        {"surface": "b", "case": None, "statistics": write_statistics(tmp_path / "b.nc", [1e5, 2e5, 4e5])},
        {
            "surface": "a",
            "case": None,
            "statistics": write_statistics(tmp_path / "a.nc", [3e5], bins=5, scale=2.0),
        },
    ]
    collected = collect_statistics(entries)
    assert dict(collected.sizes) == {"surface": 2, "load": 3, "pressure_bin": 5, "bounds": 2}
    assert list(collected["surface_name"].values) == ["b", "a"]
    assert float(collected.sel(surface="a")["rms_height"]) == 2e-6
    np.testing.assert_array_equal(collected["mean_pressure"], [[1e5, 2e5, 4e5], [3e5, np.nan, np.nan]])
    np.testing.assert_array_equal(collected["rms_height"], [1e-6, 2e-6])
    np.testing.assert_array_equal(collected["pressure_bin_bounds"][1, :, 1], [2, 4, 6, 8, 10])
    assert np.isnan(collected["pressure_density"][0, :, 3:]).all()

    table = summary_table(collected)
    assert list(table["surface"]) == ["b", "b", "b", "a"]
    assert list(table["mean_pressure_Pa"]) == [1e5, 2e5, 4e5, 3e5]
    assert list(table["contact_clusters"]) == [5, 6, 7, 5]
    assert table["contact_clusters"].dtype.kind == "i"
    assert list(table["rms_height_m"]) == [1e-6, 1e-6, 1e-6, 2e-6]
    assert list(table.columns[:3]) == ["surface", "mean_pressure_Pa", "relative_contact_area"]
    assert "contact_stiffness_Pa_per_m" in table
    assert not [name for name in table if "density" in name or "bin" in name]


def test_collected_file_and_table_can_be_read_again(tmp_path):
    entries = [
        {"surface": name, "case": None, "statistics": write_statistics(tmp_path / f"{name}.nc", loads)}
        for name, loads in (("a", [1e5, 1.0 / 3]), ("b", [2e5]))
    ]
    collected = collect_statistics(entries)
    write_dataset(collected, tmp_path / "all.nc")
    reread = read_dataset(tmp_path / "all.nc")
    assert list(reread["surface_name"].values) == ["a", "b"]
    pd.testing.assert_frame_equal(summary_table(reread), summary_table(collected))

    write_table(summary_table(collected), tmp_path / "table.csv")
    assert b"\r" not in (tmp_path / "table.csv").read_bytes()
    table = pd.read_csv(tmp_path / "table.csv")
    pd.testing.assert_frame_equal(table, summary_table(collected))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.nc", "all.nc", "b.nc", "table.csv"]


def test_cases_come_first_and_may_lack_a_surface(tmp_path):
    entries = [
        {
            "surface": surface,
            "case": case,
            "statistics": write_statistics(tmp_path / f"{case}{surface}.nc", loads),
        }
        for case, surface, loads in (("soft", "a", [1e5]), ("soft", "b", [2e5]), ("hard", "a", [5e5, 6e5]))
    ]
    collected = collect_statistics(entries)
    assert collected["relative_contact_area"].dims == ("case", "surface", "load")
    assert list(collected["case_name"].values) == ["soft", "hard"]
    assert np.isnan(collected["mean_pressure"].values[1, 1]).all()
    table = summary_table(collected)
    assert list(zip(table["case"], table["surface"], table["mean_pressure_Pa"], strict=True)) == [
        ("soft", "a", 1e5),
        ("soft", "b", 2e5),
        ("hard", "a", 5e5),
        ("hard", "a", 6e5),
    ]


def test_a_table_of_many_columns_is_made_without_a_word():
    """Pandas warns of a table that was put together column by column from the hundredth on."""
    names = [name for name, (unit, _) in VARIABLES.items() if unit in ("1", "m", "Pa")]
    assert len(names) > 40
    columns = {f"{name}_from_{source}": name for name in names for source in ("solver", "window", "all")}
    values = np.arange(2.0 * len(columns)).reshape(-1, 1, 2)
    statistics = xr.Dataset(
        {name: (("surface", "load"), value) for name, value in zip(columns, values, strict=True)},
        coords={
            "surface_name": ("surface", np.array(["a"], object)),
            "mean_pressure": (("surface", "load"), [[1e5, 2e5]]),
        },
        attrs={"verdicts": json.dumps({"": {"a": [["use", []], ["use", []]]}})},
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        table = summary_table(statistics)
    assert table.shape == (2, 2 + len(columns) + 2)
    np.testing.assert_array_equal(table.iloc[:, 2:-2].to_numpy(float).T, values[:, 0])


def test_of_the_budget_the_table_has_the_whole_and_the_parts_of_the_area():
    sources = ["window", "solver", "combined"]
    area, gap = np.array([[[0.01, 0.02, 0.03]]]), np.array([[[1e-9, 2e-9, 4e-9]]])
    statistics = xr.Dataset(
        {
            "relative_contact_area": (("surface", "load"), [[0.1]]),
            "relative_contact_area_uncertainty": (("surface", "load", "source"), area),
            "mean_gap_uncertainty": (("surface", "load", "source"), gap),
        },
        coords={
            "surface_name": ("surface", np.array(["a"], object)),
            "mean_pressure": (("surface", "load"), [[1e5]]),
            "source": np.array(sources, object),
        },
    )
    assert summary_table(statistics).to_dict("records") == [
        {
            "surface": "a",
            "mean_pressure_Pa": 1e5,
            "relative_contact_area": 0.1,
            "relative_contact_area_uncertainty": 0.03,
            "relative_contact_area_uncertainty_from_window": 0.01,
            "relative_contact_area_uncertainty_from_solver": 0.02,
            "mean_gap_uncertainty_m": 4e-9,
        }
    ]


def test_missing_file_is_named(tmp_path):
    with pytest.raises(InputFileError, match=r"gone\.nc"):
        collect_statistics([{"surface": "a", "case": None, "statistics": tmp_path / "gone.nc"}])


@pytest.mark.parametrize("case", [None, "steel"])
def test_what_failed_stands_below_with_its_case_and_its_reason(case):
    of_case = {"case": [case]} if case else {}
    summary = pd.DataFrame(of_case | {"surface": ["ground"], "mean_gap_m": [2e-7], "verdict": ["use"]})
    failure = {"surface": "turned", "case": case, "reason": "turned.txt: is empty"}
    table = append_failures(summary, [failure])
    assert list(table.columns) == [*summary.columns, "reasons"]
    expected = {"surface": "turned", "verdict": "failed", "reasons": "turned.txt: is empty"}
    last = table.iloc[-1].dropna().to_dict()
    assert last == expected | ({"case": case} if case else {})
    assert append_failures(summary, []) is summary


@pytest.mark.parametrize("cases", [[None], ["steel", "peek"]])
def test_every_load_has_its_verdict_and_its_reasons(tmp_path, cases):
    verdicts = {
        ("a", None): [["review", ["Plasticity: it flows", "Form: a bow, a dome"]], ["use", []]],
        ("b", None): [["do not use", ["Solver: missed"]]],
    }
    entries, expected = [], []
    for case in cases:
        for surface, loads in (("a", [1e5, 2e5]), ("b", [3e5])):
            path = write_statistics(tmp_path / f"{surface}-{case}.nc", loads)
            verdicts_of_surface = verdicts[surface, None]
            codes = [["use", "review", "do not use"].index(word) for word, _ in verdicts_of_surface]
            judged = read_dataset(path).assign(verdict=("load", np.array(codes, np.int8)))
            of_checks = [{"check": "Form", "loads": [0], "text": "A bow."}] if surface == "a" else []
            words = {"verdicts": json.dumps(verdicts_of_surface), "reasons": json.dumps(of_checks)}
            write_dataset(judged.assign_attrs(words), path)
            entries.append({"surface": surface, "case": case, "statistics": path})
            expected += [(word, " | ".join(reasons)) for word, reasons in verdicts_of_surface]
    collected = collect_statistics(entries)
    np.testing.assert_array_equal(
        collected["verdict"].values, np.broadcast_to([[1, 0], [2, np.nan]], collected["verdict"].shape)
    )
    assert json.loads(collected.attrs["reasons"])[cases[0] or ""]["b"] == []
    table = summary_table(collected)
    assert list(table.columns)[-2:] == ["verdict", "reasons"]
    assert list(zip(table["verdict"], table["reasons"], strict=True)) == expected
    write_table(table, tmp_path / "summary.csv")
    reread = pd.read_csv(tmp_path / "summary.csv", keep_default_na=False)
    assert list(reread["reasons"]) == [reasons for _, reasons in expected]


def test_files_of_surfaces_are_concatenated_without_a_word(tmp_path):
    """Each has bins of its own scale; they belong together in their order."""
    paths = [tmp_path / "a.nc", tmp_path / "b.nc"]
    for path, scale in zip(paths, (1e-6, 3e-7), strict=True):
        wave = height_map(scale * np.cos(np.linspace(0, 2 * np.pi, 64, endpoint=False))[None], 1e-6)
        contact = solve_contact(wave, contact_modulus=1e9, mean_pressure=[1e5, 2e5 * (scale / 1e-6)])
        write_dataset(contact_statistics(contact), path)
    files = [xr.open_dataset(path) for path in paths]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        together = xr.concat(files, dim=pd.Index(["a", "b"], name="surface"))
    sizes = {dim: together.sizes[dim] for dim in ("surface", "load", "pressure_bin", "gap_bin", "patch_bin")}
    assert sizes == {"surface": 2, "load": 2, **{dim: files[0].sizes[dim] for dim in list(sizes)[2:]}}
    widths = together["pressure_bin_bounds"].diff("bounds").squeeze("bounds")
    np.testing.assert_allclose((together["pressure_density"] * widths).sum("pressure_bin"), 1, rtol=1e-12)
    np.testing.assert_allclose(together.sel(surface="b")["mean_pressure"], [1e5, 6e4])


@pytest.fixture
def two_surfaces(tmp_path):
    """The file of a run of two surfaces, each with loads of its own, and its path."""
    entries = [
        {"surface": name, "case": None, "statistics": write_statistics(tmp_path / f"{name}.nc", loads)}
        for name, loads in (("b", [1e5, 2e5, 4e5]), ("a", [3e5]))
    ]
    write_dataset(collect_statistics(entries), tmp_path / "all.nc")
    return tmp_path / "all.nc"


def test_loads_are_selected_by_their_pressure(two_surfaces):
    statistics = read_statistics(two_surfaces)
    nearest = statistics.sel(mean_pressure=3.5e5, method="nearest")
    assert nearest["mean_pressure"].values.tolist() == [4e5, 3e5]
    assert nearest["relative_contact_area"].values.tolist() == [0.04, 0.03]
    surface_b = statistics.sel(surface="b")
    assert surface_b.sel(mean_pressure=2e5)["relative_contact_area"].item() == 0.02
    several = surface_b.sel(mean_pressure=[3.9e5, 0], method="nearest")
    assert several["mean_pressure"].values.tolist() == [4e5, 1e5]
    assert surface_b["contact_clusters"].isel(load=slice(1, None)).sel(mean_pressure=2e5).item() == 6
    assert read_statistics(two_surfaces.with_name("b.nc")).sel(mean_pressure=1e5)["contact_clusters"] == 5


@pytest.mark.parametrize(
    ("selection", "error"),
    [
        ({"mean_pressure": 2e5}, "= 200000.0 Pa is none of the loads 100000, 200000, 300000, 400000; try"),
        ({"mean_pressure": 2e5, "method": "nearest", "tolerance": 1e4}, "is none of the loads"),
    ],
)
def test_a_load_that_a_surface_does_not_have_is_refused(two_surfaces, selection, error):
    with pytest.raises(KeyError, match=error):
        read_statistics(two_surfaces).sel(**selection)


def test_numbers_of_other_loads_are_not_taken_from_one_another(two_surfaces):
    areas_b, areas_a = (
        read_statistics(two_surfaces).sel(surface=name)["relative_contact_area"] for name in "ba"
    )
    assert (areas_b - areas_b).values.tolist() == [0, 0, 0]
    with pytest.raises(NotImplementedError, match="alignment"):
        areas_b - areas_a


def test_another_way_of_selecting_is_refused(two_surfaces):
    with pytest.raises(ValueError, match="method = 'pad' is not one of"):
        read_statistics(two_surfaces).sel(mean_pressure=2e5, method="pad")
    with pytest.raises(ValueError, match="give a pressure or a list of them"):
        read_statistics(two_surfaces).sel(mean_pressure=[[2e5]])


def test_every_unit_of_a_number_by_load_has_its_place_in_the_head_of_the_table():
    """No unit is lost, and none of two variables is written alike."""
    units = {unit for unit, _ in VARIABLES.values() if unit and unit != "1"}
    heads = {unit: column_name("number", unit) for unit in units}
    assert len({*heads.values()}) == len(units)
    assert all(re.fullmatch(r"number(_[A-Za-z]+[0-9]?)+", head) for head in heads.values()), heads


def test_a_seal_and_the_ends_of_its_leak_rate_stand_in_the_table(tmp_path):
    height = height_map(1e-6 * np.random.default_rng(1).standard_normal((16, 16)), 1e-6)
    seal = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}
    numbers = contact_statistics(solve_contact(height, contact_modulus=1e9, mean_pressure=1e7), seal=seal)
    bounds = {
        f"critical_constriction_x_{side}": ("load", [height])
        for side, height in (("lower", 0.0), ("upper", 1e-6))
    }
    write_dataset(with_uncertainty(numbers, xr.Dataset(bounds, coords=numbers.coords)), tmp_path / "one.nc")
    entry = {"surface": "one", "case": None, "statistics": tmp_path / "one.nc"}
    table = summary_table(collect_statistics([entry]))
    assert table["leak_rate_by_cube_per_m_s"].item() == pytest.approx(1e5 / (12 * 1e-3 * 1e-3))
    assert table["leak_rate_x_lower_m2_per_s"].item() == 0
    assert table["leak_rate_x_upper_m2_per_s"].item() > 0


def test_a_table_has_the_columns_of_the_summary(tmp_path):
    height = rough_reference_surface(64)
    result = evaluate(height, contact={"contact_modulus": 1e9, "mean_pressure": [2e8, 4e7]})
    write_dataset(result, tmp_path / "statistics.nc")
    entries = [
        {"surface": name, "case": case, "statistics": tmp_path / "statistics.nc"}
        for case in ("soft", "hard")
        for name in ("ground", "turned")
    ]
    for cases in (False, True):
        run = collect_statistics(entries if cases else [{**e, "case": None} for e in entries[:2]])
        full_table = summary_table(run)
        pd.testing.assert_frame_equal(table(run), full_table)
        at = {"surface": "turned"} | ({"case": "hard"} if cases else {})
        rows = full_table[(full_table[list(at)] == list(at.values())).all(axis=1)].reset_index(drop=True)
        assert len(rows) == 2
        pd.testing.assert_frame_equal(table(run.sel(at)), rows)
        numbers = rows.drop(columns=list(at))
        pd.testing.assert_frame_equal(table(result), numbers)
        pd.testing.assert_frame_equal(table(read_statistics(tmp_path / "statistics.nc")), numbers)
    assert table(result)["mean_pressure_Pa"].tolist() == [2e8, 4e7]
    assert set(table(result)["verdict"]) <= {"use", "review", "do not use"}
    with pytest.raises(SettingsError, match="select rows of the table"):
        table(result.isel(load=[1]))
    # without verdicts the loads may be any
    numbers = result.drop_attrs()[["mean_gap"]].isel(load=[1])
    assert table(numbers)["mean_gap_m"].tolist() == [result["mean_gap"].values[1]]


def test_a_summary_has_each_quantity_with_its_interval(tmp_path):
    bodies = ["steel", {"youngs_modulus": "4 GPa", "poissons_ratio": 0.4, "thermal_conductivity": 0.3}]
    seal = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}
    result = evaluate(
        rough_reference_surface(64), bodies=bodies, mean_pressure=[2e8, 4e7], statistics={"seal": seal}
    )
    rows_of_summary = summary(result)
    assert [*rows_of_summary] == ["quantity", "load", "value", "lower", "upper", "known", "verdict"]
    rows = rows_of_summary.set_index(["quantity", "load"])
    verdicts = ["use", "review", "do not use"]
    for name, answer in {
        "relative_contact_area": "relative_contact_area",
        "mean_gap": "mean_gap",
        "critical_constriction_x": "sealing",
        "leak_rate_y": "sealing",
        "conductance_per_conductivity": "conductance",
        "thermal_resistance": "conductance",
        "max_pressure": "max_pressure",
    }.items():
        for load, pressure in enumerate((2e8, 4e7)):
            row = rows.loc[name, pressure]
            for column, suffix in (("value", ""), ("lower", "_lower"), ("upper", "_upper")):
                np.testing.assert_equal(row[column], result[f"{name}{suffix}"].values[load])
            assert row["verdict"] == verdicts[result[f"{answer}_verdict"].values[load]]
            if name in ANSWERS:
                np.testing.assert_equal(row["known"], result[f"{name}_known"].values[load])
    assert not rows_of_summary["quantity"].str.contains("next|octave|map|_lower|_upper").any()
    with pytest.raises(SettingsError, match="no interval with a verdict; give the result of evaluate"):
        summary(result[["mean_gap"]])
    write_dataset(result, tmp_path / "statistics.nc")
    entries = [
        {"surface": name, "case": None, "statistics": tmp_path / "statistics.nc"} for name in ("a", "b")
    ]
    run = summary(collect_statistics(entries))
    assert run["surface"].unique().tolist() == ["a", "b"]
    pd.testing.assert_frame_equal(
        run[run["surface"] == "b"].drop(columns="surface").reset_index(drop=True), rows_of_summary
    )


def test_the_summary_of_a_finite_body_is_by_its_force():
    x = np.linspace(-1, 1, 48) * 0.3e-3
    ball = height_map(-(x[:, None] ** 2 + x**2) / 20e-3, x[1] - x[0])
    result = evaluate(
        ball, contact_modulus="1 GPa", boundary="free", force=["1 N", "2 N"], level={"form": "none"}
    )
    assert summary(result)["load"].unique().tolist() == [1.0, 2.0]
