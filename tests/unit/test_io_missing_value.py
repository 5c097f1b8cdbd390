"""A number that marks missing points, stated by the user: argument, table, command line, one call."""

import json

import numpy as np
import pytest
from measured_files import array, cells, refuses, warnings_of

import roughcontact as rc
from roughcontact import SettingsError, inspect_file
from roughcontact.interface.program import main
from roughcontact.study.table.read import read_surfaces

HEIGHTS = np.round(np.random.default_rng(4).normal(size=(14, 20)), 3)
MARKED = HEIGHTS.copy()
MARKED[2, 3:9], MARKED[7, 7] = -25400, 99
GIVEN = {"dx": 1, "dy": 1, "unit": "um", "height_unit": "nm"}


@pytest.fixture
def path(tmp_path):
    np.savetxt(tmp_path / "map.txt", MARKED, fmt="%g")
    return tmp_path / "map.txt"


def test_a_usual_marker_among_few_or_large_heights_is_named_until_it_is_stated(tmp_path):
    heights = 1e4 * HEIGHTS  # some are lower than the marker
    heights[2, 3:5] = -9999
    (tmp_path / "map.txt").write_text(cells(heights))
    (tmp_path / "profile.txt").write_text(cells(np.c_[:40, np.r_[HEIGHTS[0], HEIGHTS[1, :18], -9999, -9999]]))
    for name in ("map.txt", "profile.txt"):
        options = GIVEN if name == "map.txt" else {"unit": "um", "height_unit": "nm"}
        warnings = warnings_of(rc.read_height_map(tmp_path / name, **options))
        assert "2 points are -9999: if that marks missing points, missing_value states it" in warnings
        height = rc.read_height_map(tmp_path / name, **options, missing_value=-9999)
        assert "if that marks" not in warnings_of(height)
        assert height.attrs["missing_points"] == 2


def test_stated_markers_are_missing_points_and_the_suspicion_names_the_way(path):
    bare = rc.read_height_map(path, **GIVEN)
    assert bare.attrs["missing_points"] == 0
    assert "missing_value states it" in warnings_of(bare)
    for marker, missing in (("-25400", 6), (-25400, 6), (99.0, 1), ("-25400 99", 7)):
        height = rc.read_height_map(path, **GIVEN, missing_value=marker)
        assert height.attrs["missing_points"] == missing
        is_finite = np.isfinite(height.values)
        np.testing.assert_allclose(height.values[is_finite], 1e-9 * MARKED[::-1][is_finite], rtol=1e-14)
        assert f"{missing} points are {marker} and taken as missing" in warnings_of(height)
    assert "far below" not in warnings_of(height)  # with both markers
    words = r"missing_value = 'none'.*separated by blanks"
    refuses(words, path, error=SettingsError, **GIVEN, missing_value="none")


def test_markers_of_single_precision_and_of_uneven_points(read):
    values = HEIGHTS.astype("f4")
    values[3, 3] = np.float32(-32767.9)
    assert read(array(values), **GIVEN, missing_value="-32767.9").attrs["missing_points"] == 1
    x = np.cumsum(np.random.default_rng(5).uniform(1, 2, 40))
    z = np.where(np.arange(40) % 7 == 3, -9999, 0.1 * x)
    text = cells(zip(x, z, strict=True), " ", "{}")
    height = read(text, unit="um", resample="linear", missing_value=-9999)
    np.testing.assert_allclose(height.values[0], 0.1 * height.x, rtol=1e-9)


def test_the_marker_of_the_command_line_and_of_one_call(path, capsys):
    options = ["--dx", "1", "--dy", "1", "--unit", "um", "--height-unit", "nm", "--missing-value=-25400 99"]
    assert main(["inspect", str(path), "--json", *options]) == 0
    (contents,) = json.loads(capsys.readouterr().out)
    assert contents["map"]["missing_points"] == 7
    assert contents == json.loads(json.dumps([inspect_file(path, **GIVEN, missing_value="-25400 99")]))[0]
    contact = {"contact_modulus": 1e9, "relative_pressure": 0.1}
    chosen = {"contact": contact, "uncertainty": {"sources": ["solver"]}}
    statistics = rc.evaluate(path, **chosen, **GIVEN, missing_value="-25400 99")
    read = rc.evaluate(rc.read_height_map(path, **GIVEN, missing_value="-25400 99"), **chosen)
    assert float(statistics["rms_height"]) == float(read["rms_height"])
    with pytest.raises(SettingsError, match="missing_value: of a file, the source is a map"):
        rc.evaluate(rc.read_height_map(path, **GIVEN), **chosen, missing_value=99)


def test_the_marker_of_the_table(path, tmp_path):
    table = tmp_path / "surfaces.tsv"
    table.write_text("surface\tpath\tmissing_value\na\tmap.txt\t-25400 99\n", encoding="utf-8")
    options = read_surfaces(table)["a"].read_arguments
    assert options == {"missing_value": "-25400 99"}
    assert rc.read_height_map(path, **GIVEN, **options).attrs["missing_points"] == 7
