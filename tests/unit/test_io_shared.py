"""Real instrument files: each one of the catalogue is read right, or refused in one clear sentence.

Expected numbers are those of the catalogue. The table `real_files.json` has for each file what has to be
given beside it, and what is right where the catalogue is wrong or silent, with the reason:

- `otherwise`: nx, ny, field along x and y (m), rms height (m), missing share;
- `second_reader`: heights at (ny//5, nx//7), (ny//3, 6 nx//7) and (4 ny//5, nx//5) minus the height at
  (ny//2, nx//2), m, as surfalize 0.19.2 reads them; its scale corrected where a third reader shows it to be
  wrong (Zygo: factor 8, TMD: factor 1000). No two of these points are images of each other, so that a
  mirrored map fails;
- `gwyddion`: dx, dy (m), missing points, and heights at the same points minus that in the middle (m) of
  Gwyddion 2.62; `more_missing`: points that it takes for heights;
- `instrument`: what Gwyddion or the bytes of the file say of instrument, lens, date and serial number;
  `silent`: what a file does not say, though something in it looks like it;
- `first_row`: bottom of the picture, by a standard or by positions; all others begin at the top.
"""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from measured_files import holds, refuses, steps, warnings_of
from shared_data import DATA

from roughcontact import inspect_file, read_height_map
from roughcontact.io.units import metres

pytestmark = pytest.mark.shared_data

FILES = json.loads(Path(__file__).with_name("real_files.json").read_text(encoding="utf-8"))
READ = [name for name in FILES if "refused" not in FILES[name]]
KEYS = ("given", "refused", "second_reader", "gwyddion", "instrument", "silent")
NAMES = {key: [name for name in FILES if key in FILES[name]] for key in KEYS}


def read(name):
    return read_height_map(DATA / name, **FILES[name].get("given", {}))


def in_order_of_the_file(height):
    """Return the heights with the first row of the file first: for a picture the upper one."""
    return height.values if "first_row" in FILES[height.attrs["source_file"]] else height.values[::-1]


def compare(height, expected):
    """Compare the heights at the three points of the table minus that in the middle."""
    values = in_order_of_the_file(height)
    ny, nx = values.shape
    points = [(ny // 5, nx // 7), (ny // 3, 6 * nx // 7), (4 * ny // 5, nx // 5)]
    differences = [values[point] - values[ny // 2, nx // 2] for point in points]
    close = {"rtol": 1e-5, "atol": 1e-6 * np.nanstd(values)}
    np.testing.assert_allclose(differences, np.array(expected, dtype=float), **close)


def catalogue():
    with (DATA / "CATALOG.tsv").open(encoding="utf-8") as stream:
        return {row["file"]: row for row in csv.DictReader(stream, delimiter="\t")}


def expected(name) -> dict:
    row = catalogue()[name]
    numbers = {key: float(row[key]) if row[key] else None for key in ("nx", "ny", "size_x", "size_y")}
    if row["unit"] not in ("", "none"):
        for key in ("size_x", "size_y"):
            numbers[key] = numbers[key] and numbers[key] * metres(row["unit"])
    numbers["rms"] = 1e-6 * float(row["rms_height_um"]) if row["rms_height_um"] else None
    numbers["missing"] = float(row["missing_share"]) if row["missing_share"] else 0.0
    return numbers | FILES[name].get("otherwise", {})


def test_the_table_names_every_file_of_the_catalogue():
    assert sorted(FILES) == sorted(catalogue())


@pytest.mark.parametrize("name", READ)
def test_size_heights_and_missing_points(name):
    numbers = expected(name)
    height = read(name)
    ny, nx = height.shape
    assert (nx, ny) == (numbers["nx"], numbers["ny"])
    assert nx * float(height.x[1] - height.x[0]) == pytest.approx(numbers["size_x"], rel=1e-5)
    if numbers["size_y"] is not None:
        assert ny * float(height.y[1] - height.y[0]) == pytest.approx(numbers["size_y"], rel=1e-5)
    assert float(height.std()) == pytest.approx(numbers["rms"], rel=1e-5)
    assert height.attrs["missing_share"] == pytest.approx(numbers["missing"], rel=1e-5)
    assert height.attrs["missing_points"] == int(np.isnan(height.values).sum())
    assert height.attrs["channel"] == FILES[name].get("channel", height.attrs["channel"])
    assert len(height.attrs["source_sha256"]) == 64
    assert height.attrs["y_axis"] == "up"
    assert height.attrs["first_row"] == FILES[name].get("first_row", "top")
    assert height.attrs["first_row_assumed"] == (name == "AFM.txt")


@pytest.mark.parametrize("name", NAMES["refused"])
def test_other_files_are_refused_in_a_sentence(name):
    message = refuses(FILES[name]["refused"], DATA / name)
    assert name in message
    assert len(message) < 400


@pytest.mark.parametrize("name", NAMES["given"])
def test_files_that_do_not_say_their_units_are_refused_without_them(name):
    refuses("in the table of surfaces", DATA / name)
    assert "in the table of surfaces" in inspect_file(DATA / name)["problem"]


@pytest.mark.parametrize("name", NAMES["second_reader"])
def test_orientation_and_scale_against_a_second_reader(name):
    compare(read(name), FILES[name]["second_reader"])


@pytest.mark.parametrize("name", NAMES["gwyddion"])
def test_steps_heights_and_missing_points_against_gwyddion(name):
    dx, dy, missing, heights = FILES[name]["gwyddion"]
    height = read(name)
    compare(height, heights)
    assert steps(height) == pytest.approx([dx, dy], rel=1e-8)
    assert height.attrs["missing_points"] == missing + FILES[name].get("more_missing", 0)


def test_a_profile_against_gwyddion():
    height = read_height_map(DATA / "opdx-3.opdx")
    np.testing.assert_allclose(height.values[0, :3], [1.37183058e-9, 1.31224077e-9, 1.31728306e-9], rtol=1e-8)
    assert float(height.std()) == pytest.approx(5.3075085771e-9, rel=1e-9)
    assert float(height.x[-1] - height.x[0]) == pytest.approx(4.99666888628e-5, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "skip", "factor"),
    [("AFM.txt", 1, 1e-9), ("matrix-4.txt", 4, 2.91818e-8), ("matrix-3.txt", 4, 1)],
)
def test_matrices_of_numbers_against_numpy(name, skip, factor):
    table = np.loadtxt(DATA / name, skiprows=skip, encoding="latin-1") * factor
    holds(read(name), table[::-1], rtol=1e-12)


def test_bytes_of_a_binary_map_without_a_second_reader():
    """The coin: floats behind a header of 80 bytes; size and heights in mm."""
    data = (DATA / "tmd-1.tmd").read_bytes()
    size = np.frombuffer(data, "<f4", 2, offset=64)
    values = np.frombuffer(data, "<f4", 300 * 300, offset=80).reshape(300, 300)
    height = read_height_map(DATA / "tmd-1.tmd")
    np.testing.assert_allclose(height.values[::-1], 1e-3 * values, rtol=1e-6)
    assert 300 * float(height.x[1] - height.x[0]) == pytest.approx(1e-3 * size[0], rel=1e-6)


def without_plane(values):
    y, x = np.indices(values.shape)
    plane = np.column_stack([np.ones(values.size), x.ravel(), y.ravel()])
    flat = values.ravel() - plane @ np.linalg.lstsq(plane, values.ravel(), rcond=None)[0]
    return flat.reshape(values.shape)


def test_a_map_and_its_export_as_text_are_one():
    """matrix-3.txt is the first channel of di-3.di, exported by other software with the plane removed."""
    binary = read_height_map(DATA / "di-3.di")
    text = read_height_map(DATA / "matrix-3.txt")
    # the text has five digits of heights of about 1e-7 m
    np.testing.assert_allclose(without_plane(binary.values), without_plane(text.values), rtol=0, atol=1e-11)
    np.testing.assert_allclose(binary.x, text.x, rtol=1e-9)
    assert binary.attrs["first_row"] == text.attrs["first_row"] == "top"


def test_the_same_map_packed_in_two_ways():
    """One archive holds its files in a folder, as doubles; the other at the top, in single precision."""
    folder, top = (read_height_map(DATA / f"sample-land{name}.x3p") for name in ("", "-cran"))
    np.testing.assert_allclose(folder.values, top.values, rtol=1e-6, atol=1e-11)
    np.testing.assert_allclose(folder.x, top.x, rtol=1e-9)


def test_lists_of_points_against_numpy():
    table = np.loadtxt(DATA / "test1.txt", delimiter=",")
    height = read("test1.txt")
    column, row = np.rint(table[:, :2].T / 0.005).astype(int)
    np.testing.assert_allclose(height.values[row, column], 1e-6 * table[:, 2], rtol=1e-12)
    trace = np.loadtxt(DATA / "csv-1.csv", delimiter=",", skiprows=1)
    profile = read("csv-1.csv")
    np.testing.assert_allclose(profile.values[0], 1e-6 * trace[:, 1], rtol=1e-12)
    np.testing.assert_allclose(profile.x, 1e-6 * trace[:, 0], rtol=2e-3)  # positions are rounded to 0.1 nm


@pytest.mark.parametrize("name", ["opd-1.opd", "x3p-2.x3p"])
def test_windows_of_the_solved_references(name):
    """The windows [i, j, nx, ny] of the reference solutions have the stated rms height, plane removed."""
    reference = json.loads((DATA / "cross_solver_reference.json").read_text(encoding="utf-8"))
    height = read_height_map(DATA / name)
    cases = [case for case in reference if case["file"] == name]
    assert cases
    for case in cases:
        i, j, nx, ny = case["window"]
        window = in_order_of_the_file(height)[j : j + ny, i : i + nx]
        residual = without_plane(window)
        assert residual.std() == pytest.approx(case["rms_height"], rel=1e-9)
        assert steps(height) == pytest.approx([case["dx"][0], case["dx"][1]], rel=1e-9)


@pytest.mark.parametrize("name", READ)
def test_files_cut_at_60_percent_are_refused(name, tmp_path):
    data = (DATA / name).read_bytes()
    (tmp_path / name).write_bytes(data[: int(0.6 * len(data))])
    message = refuses(re.escape(name), tmp_path / name, **FILES[name].get("given", {}))
    assert len(message) < 400 + len(str(tmp_path))


def test_another_channel_can_be_named():
    path = DATA / "di-3.di"
    height = read_height_map(path, channel="height")
    assert height.attrs["channel"] == "Height"
    assert json.loads(height.attrs["channels"]) == ["ZSensor", "AmplitudeError", "Phase", "Height"]
    refuses(r"no channel is named 'Topo'; the file has 'ZSensor', 'AmplitudeError'", path, channel="Topo")
    refuses("channel 'Friction#1' holds no heights", DATA / "mi-1.mi", channel="Friction#1")
    amplitude = read_height_map(DATA / "spot_1-1000nm.ibw", channel="AmplitudeTrace")
    assert "read as heights on request (by its name no topography)" in amplitude.attrs["ingest_warnings"]


def test_inspection_lists_channels_instrument_and_choice():
    contents = inspect_file(DATA / "spot_1-1000nm.ibw")
    assert contents["format"] == "Igor binary wave"
    assert contents["channel"] == "HeightTrace"
    assert "first height channel of 8" in contents["channel_choice"]
    heights = [channel["name"] for channel in contents["channels"] if channel["is_height"]]
    assert heights == ["HeightTrace", "HeightRetrace"]
    assert contents["instrument"]["name"] == "Cypher"
    assert contents["channels"][0]["rms_height"] == pytest.approx(0.0894548e-6, rel=1e-5)
    assert contents["problem"] is None


@pytest.mark.parametrize("name", NAMES["instrument"])
def test_instrument_lens_date_and_serial_are_kept(name):
    instrument = json.loads(read_height_map(DATA / name).attrs["instrument"])
    assert instrument.items() >= FILES[name]["instrument"].items()
    assert instrument == inspect_file(DATA / name)["instrument"]


@pytest.mark.parametrize("name", NAMES["silent"])
def test_what_only_looks_like_a_serial_number_or_a_date(name):
    instrument = inspect_file(DATA / name)["instrument"]
    assert FILES[name]["silent"] not in instrument
    assert "DS-781758056" not in instrument.values()


@pytest.mark.cases
def test_suspicions(name, words):
    notes = warnings_of(read_height_map(DATA / name))
    assert words in notes if words else notes == ""


@pytest.mark.parametrize("name", ["nms-1.nms", "mi-1.mi", "frt-1.frt", "plu-1.plu", "stp-1.stp", "sur-2.sur"])
def test_converted_line_ends_are_refused(name, tmp_path):
    """A binary file that was transferred as text would open as noise."""
    data = (DATA / name).read_bytes()
    (tmp_path / name).write_bytes(data.replace(b"\r\n", b"\n").replace(b"\n", b"\r\n"))
    refuses("it was transferred as text", tmp_path / name)


@pytest.mark.cases
def test_a_header_that_speaks_of_the_sign_is_passed_on(name, position, change, words, tmp_path):
    data = bytearray((DATA / name).read_bytes())
    stop = position + len(change)
    assert data[position:stop] == (b"No\0" if change == b"Yes" else b"\0")
    data[position:stop] = change
    (tmp_path / name).write_bytes(data)
    assert words in warnings_of(read_height_map(tmp_path / name))
    assert not any(words in note for note in inspect_file(DATA / name)["warnings"])
