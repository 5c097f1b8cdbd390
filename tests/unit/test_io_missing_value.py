"""A number that marks missing points, stated by the user: argument, table, command line, one call."""

import json

import numpy as np
import pytest
from measured_files import array, cells, refuses, warnings_of

import roughcontact as rc
from roughcontact.command_line.program import main
from roughcontact.configuration.surfaces import read_surfaces
from roughcontact.errors import SettingsError
from roughcontact.io.inspection import inspect_file

HEIGHTS = np.round(np.random.default_rng(4).normal(size=(14, 20)), 3)
MARKED = HEIGHTS.copy()
MARKED[2, 3:9], MARKED[7, 7] = -25400, 99
GIVEN = {"dx": 1, "dy": 1, "unit": "um", "height_unit": "nm"}


@pytest.fixture
def path(tmp_path):
    np.savetxt(tmp_path / "map.txt", MARKED, fmt="%g")
    return tmp_path / "map.txt"


def test_stated_markers_are_missing_points_and_the_suspicion_names_the_way(path):
    bare = rc.read_height_map(path, **GIVEN)
    assert bare.attrs["missing_points"] == 0
    assert "missing_value states it" in warnings_of(bare)
    for stated, missing in (("-25400", 6), (-25400, 6), (99.0, 1), ("-25400 99", 7)):
        height = rc.read_height_map(path, **GIVEN, missing_value=stated)
        assert height.attrs["missing_points"] == missing
        kept = np.isfinite(height.values)
        np.testing.assert_allclose(height.values[kept], 1e-9 * MARKED[::-1][kept], rtol=1e-14)
        assert f"{missing} points are {stated} and taken as missing" in warnings_of(height)
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
    (found,) = json.loads(capsys.readouterr().out)
    assert found["map"]["missing_points"] == 7
    assert found == json.loads(json.dumps([inspect_file(path, **GIVEN, missing_value="-25400 99")]))[0]
    contact = {"contact_modulus": 1e9, "relative_pressure": 0.1}
    chosen = {"contact": contact, "uncertainty": {"sources": ["solver"]}}
    stated = rc.evaluate(path, **chosen, **GIVEN, missing_value="-25400 99")
    read = rc.evaluate(rc.read_height_map(path, **GIVEN, missing_value="-25400 99"), **chosen)
    assert float(stated["rms_height"]) == float(read["rms_height"])
    with pytest.raises(SettingsError, match="missing_value: of a file, the source is a map"):
        rc.evaluate(rc.read_height_map(path, **GIVEN), **chosen, missing_value=99)


def test_the_marker_of_the_table(path, tmp_path):
    table = tmp_path / "surfaces.tsv"
    table.write_text("surface\tpath\tmissing_value\na\tmap.txt\t-25400 99\n", encoding="utf-8")
    given = read_surfaces(table)["a"].read_arguments
    assert given == {"missing_value": "-25400 99"}
    assert rc.read_height_map(path, **GIVEN, **given).attrs["missing_points"] == 7
