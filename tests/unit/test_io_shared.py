"""Real instrument files: each one of the catalogue is read right, or refused in one clear sentence.

Expected numbers are the catalogue's; where the catalogue is wrong or silent, the table below has its own and
says why.
"""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from roughcontact.errors import InputFileError
from roughcontact.io import inspect_file, read_height_map
from roughcontact.io.units import metres

DATA = Path(__file__).parents[2].parent / "shared" / "data"

pytestmark = [
    pytest.mark.shared_data,
    pytest.mark.skipif(not (DATA / "CATALOG.tsv").is_file(), reason="no folder of real instrument files"),
]

FILES = (
    *(
        "al3d-1.al3d",
        "frt-1.frt",
        "mnt-2.mnt",
        "nms-1.nms",
        "opd-1.opd",
        "plu-1.plu",
        "sur-2.sur",
        "sur-3.sur",
    ),
    *("x3p-2.x3p", "metropro-1.dat", "mi-1.mi", "nid-1.nid", "di-3.di", "spot_1-1000nm.ibw", "matrix-4.txt"),
    *("xyz-2.txt", "tmd-1.tmd", "sdf-1.sdf", "di_corrupted.di", "nonsense_txt_file.txt", "wrongnpyfile.npy"),
    *(
        "opdx-3.opdx",
        "stp-1.stp",
        "bcrf-1.bcrf",
        "example_ps.tiff",
        "csv-1.csv",
        "KautschukInfiniteFocus.x3p",
    ),
    *("ISO5436-sample1.x3p", "ISO5436-sample4_bin.x3p", "test_1.opd", "test_uncompressed.sur"),
    *("valid_zygo_dat_file.dat", "test1.txt", "Hamby252_Barrel1_Bullet1_Land4.x3p", "sample-land.x3p"),
    *("grid.nid", "sample-land-cran.x3p", "di-1.di", "thermal.nid", "matrix-3.txt", "AFM.txt"),
)

REFUSED = {
    "di_corrupted.di": "looks like Bruker/Veeco/DI Nanoscope, but is damaged, cut off",
    "nonsense_txt_file.txt": "text without a table of numbers",
    "wrongnpyfile.npy": "the format is not known",  # its first byte was turned into three
    "thermal.nid": "holds no map",  # force curves only
}

# What the table of surfaces must give for files that do not say it.
GIVEN = {
    "xyz-2.txt": {"unit": "um"},
    "test1.txt": {"unit": "mm", "height_unit": "um"},  # steps of 5 µm, heights around 480 µm
    "AFM.txt": {"dx": 2, "dy": 2, "unit": "nm"},
    "csv-1.csv": {"height_unit": "um"},  # the column names say microns for x only
}

# Where the catalogue is wrong or silent: nx, ny, field along x and y (m), rms height (m), missing share.
OTHERWISE = {
    # the header's steps are nanometres: the field is 160 µm, not 160 m
    "nms-1.nms": {"size_x": 160e-6, "size_y": 160e-6},
    # points x y z; the unit is given
    "xyz-2.txt": {"size_x": 4e-6, "size_y": 4e-6, "rms": 0.494872e-6},
    "test1.txt": {"size_x": 505e-6, "size_y": 505e-6},
    # eight points 38.6 nm apart: the catalogue has seven steps, and no unit
    "csv-1.csv": {"size_x": 8 / 7 * 0.2703e-6, "size_y": None},
    "opdx-3.opdx": {"size_y": None},
    # heights are said to be in nm; the steps are given
    "AFM.txt": {"size_x": 1024e-9, "size_y": 1024e-9, "rms": 4.136829e-9},
    # one missing point is an empty element; the size is 4 increments of 16.016 mm
    "ISO5436-sample1.x3p": {
        **{"nx": 4, "ny": 4, "size_x": 0.064064, "size_y": 0.064064, "rms": 0.6105091545, "missing": 1 / 16},
    },
    # the same map as sample-land-cran.x3p, as doubles, its root element misnamed and in a folder
    "sample-land.x3p": {
        **{"nx": 918, "ny": 256, "size_x": 0.00236844, "size_y": 0.00066048, "rms": 34.3342749e-6},
        "missing": 0.107621868,
    },
}

CHANNELS = {
    "mi-1.mi": "Topography",
    "nid-1.nid": "Scan forward (Z-Axis)",
    "grid.nid": "Scan forward (Z-Axis)",
    "di-1.di": "Height#1",
    "di-3.di": "ZSensor",
    "spot_1-1000nm.ibw": "HeightTrace",
    "matrix-3.txt": "ZSensor",
    "opdx-3.opdx": "Height",
}

# Heights at (ny//5, nx//7), (ny//3, 6 nx//7) and (4 ny//5, nx//5) minus the height at (ny//2, nx//2), m, as
# surfalize 0.19.2 reads them; its scale corrected where a third reader shows it to be wrong (Zygo: factor 8,
# TMD: factor 1000). No two of these points are images of each other, so that a mirrored map fails.
SECOND_READER = {
    "al3d-1.al3d": [1.23903155e-05, -8.94069672e-08, -2.14576721e-06],
    "nms-1.nms": [-8.39012783e-07, 8.98862699e-07, -3.69125117e-08],
    "sur-2.sur": [9.30000011e-09, 1.44000002e-08, -9.50000011e-09],
    "x3p-2.x3p": [-4.04768e-08, -1.258867e-07, 2.7231e-09],
    "metropro-1.dat": [-1.15555114e-07, 6.84667966e-08, -8.74012752e-08],
    "valid_zygo_dat_file.dat": [-9.76776827e-08, 6.63833599e-08, 6.14492658e-08],
    "tmd-1.tmd": [9.36037031e-05, 3.68813453e-05, 0.000143076861],
    "KautschukInfiniteFocus.x3p": [7.42733232e-06, 1.98471071e-06, 9.72818543e-06],
    "test_1.opd": [1.91423729e-06, 4.68474576e-07, -6.16610169e-07],
    "test_uncompressed.sur": [-3.3610633e-08, -1.09475683e-07, 1.74253542e-07],
    "Hamby252_Barrel1_Bullet1_Land4.x3p": [-8.5677496e-05, -1.2227534e-05, -7.3085126e-05],
}


def catalogue():
    with open(DATA / "CATALOG.tsv", encoding="utf-8") as stream:
        return {row["file"]: row for row in csv.DictReader(stream, delimiter="\t")}


def expected(name) -> dict:
    row = catalogue()[name]
    numbers = {key: float(row[key]) if row[key] else None for key in ("nx", "ny", "size_x", "size_y")}
    if row["unit"] not in ("", "none"):
        for key in ("size_x", "size_y"):
            numbers[key] = numbers[key] and numbers[key] * metres(row["unit"])
    numbers["rms"] = 1e-6 * float(row["rms_height_um"]) if row["rms_height_um"] else None
    numbers["missing"] = float(row["missing_share"]) if row["missing_share"] else 0.0
    return numbers | OTHERWISE.get(name, {})


def test_the_table_names_every_file_of_the_catalogue():
    assert sorted(FILES) == sorted(catalogue())


@pytest.mark.parametrize("name", [name for name in FILES if name not in REFUSED])
def test_size_heights_and_missing_points(name):
    numbers = expected(name)
    height = read_height_map(DATA / name, **GIVEN.get(name, {}))
    ny, nx = height.shape
    assert (nx, ny) == (numbers["nx"], numbers["ny"])
    assert nx * float(height.x[1] - height.x[0]) == pytest.approx(numbers["size_x"], rel=1e-5)
    if numbers["size_y"] is not None:
        assert ny * float(height.y[1] - height.y[0]) == pytest.approx(numbers["size_y"], rel=1e-5)
    assert float(height.std()) == pytest.approx(numbers["rms"], rel=1e-5)
    assert height.attrs["missing_share"] == pytest.approx(numbers["missing"], rel=1e-5)
    assert height.attrs["missing_points"] == int(np.isnan(height.values).sum())
    assert height.attrs["channel"] == CHANNELS.get(name, height.attrs["channel"])
    assert len(height.attrs["source_sha256"]) == 64


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_other_files_are_refused_in_a_sentence(name):
    with pytest.raises(InputFileError, match=REFUSED[name]) as caught:
        read_height_map(DATA / name)
    assert name in str(caught.value)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("name", sorted(GIVEN))
def test_files_that_do_not_say_their_units_are_refused_without_them(name):
    with pytest.raises(InputFileError, match="in the table of surfaces"):
        read_height_map(DATA / name)
    assert "in the table of surfaces" in inspect_file(DATA / name)["problem"]


@pytest.mark.parametrize("name", sorted(SECOND_READER))
def test_orientation_and_scale_against_a_second_reader(name):
    height = read_height_map(DATA / name).values
    ny, nx = height.shape
    points = [(ny // 5, nx // 7), (ny // 3, 6 * nx // 7), (4 * ny // 5, nx // 5)]
    found = [height[point] - height[ny // 2, nx // 2] for point in points]
    np.testing.assert_allclose(found, SECOND_READER[name], rtol=1e-5, atol=1e-6 * np.nanstd(height))


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


@pytest.mark.parametrize("name", ["opd-1.opd", "x3p-2.x3p"])
def test_windows_of_the_solved_references(name):
    """The windows [i, j, nx, ny] of the reference solutions have the stated rms height, plane removed."""
    reference = json.loads((DATA / "cross_solver_reference.json").read_text(encoding="utf-8"))
    height = read_height_map(DATA / name)
    cases = [case for case in reference if case["file"] == name]
    assert cases
    for case in cases:
        i, j, nx, ny = case["window"]
        window = height.values[j : j + ny, i : i + nx]
        rest = without_plane(window)
        assert rest.std() == pytest.approx(case["rms_height"], rel=1e-9)
        assert float(height.x[1] - height.x[0]) == pytest.approx(case["dx"][0], rel=1e-9)
        assert float(height.y[1] - height.y[0]) == pytest.approx(case["dx"][1], rel=1e-9)


@pytest.mark.parametrize("name", [name for name in FILES if name not in REFUSED])
def test_files_cut_at_60_percent_are_refused(name, tmp_path):
    data = (DATA / name).read_bytes()
    (tmp_path / name).write_bytes(data[: int(0.6 * len(data))])
    with pytest.raises(InputFileError) as caught:
        read_height_map(tmp_path / name, **GIVEN.get(name, {}))
    assert len(str(caught.value)) < 400 + len(str(tmp_path))


def test_another_channel_can_be_named():
    path = DATA / "di-3.di"
    height = read_height_map(path, channel="height")
    assert height.attrs["channel"] == "Height"
    assert json.loads(height.attrs["channels"]) == ["ZSensor", "AmplitudeError", "Phase", "Height"]
    with pytest.raises(
        InputFileError, match=r"no channel is named 'Topo'; the file has 'ZSensor', 'AmplitudeError'"
    ):
        read_height_map(path, channel="Topo")
    with pytest.raises(InputFileError, match="channel 'Phase' holds no heights"):
        read_height_map(path, channel="Phase")
    with pytest.raises(InputFileError, match="channel 'Friction#1' holds no heights"):
        read_height_map(DATA / "mi-1.mi", channel="Friction#1")
    amplitude = read_height_map(DATA / "spot_1-1000nm.ibw", channel="AmplitudeTrace")
    assert "at the user's word (by its name no topography)" in amplitude.attrs["ingest_warnings"]


def test_inspection_lists_channels_instrument_and_choice():
    found = inspect_file(DATA / "spot_1-1000nm.ibw")
    assert found["format"] == "Igor binary wave"
    assert found["channel"] == "HeightTrace"
    assert "first height channel of 8" in found["channel_choice"]
    heights = [channel["name"] for channel in found["channels"] if channel["is_height"]]
    assert heights == ["HeightTrace", "HeightRetrace"]
    assert found["instrument"]["name"] == "Cypher"
    assert found["channels"][0]["rms_height"] == pytest.approx(0.0894548e-6, rel=1e-5)
    assert found["problem"] is None


def test_lens_date_and_serial_are_kept():
    instrument = json.loads(read_height_map(DATA / "sample-land-cran.x3p").attrs["instrument"])
    assert instrument["serial"] == "350262016"
    assert instrument["probe"] == "Nikon - EPI 20X"
    assert instrument["acquisition_time"].startswith("2018-09-15T17:46:09")
    lens = json.loads(read_height_map(DATA / "plu-1.plu").attrs["instrument"])
    assert lens["objective"] == "Nikon CFI Plan Interferential 10X"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("frt-1.frt", "far below all others"),  # missing points that the file left at 0
        ("ISO5436-sample1.x3p", "more than the field"),
        ("test_1.opd", "pixels are not square"),
        ("example_ps.tiff", None),
        ("metropro-1.dat", None),
    ],
)
def test_suspicions(name, words):
    notes = json.loads(read_height_map(DATA / name).attrs["ingest_warnings"])
    if words is None:
        assert notes == []
    else:
        assert any(words in note for note in notes)


@pytest.mark.parametrize("name", ["nms-1.nms", "mi-1.mi", "frt-1.frt", "plu-1.plu", "stp-1.stp", "sur-2.sur"])
def test_converted_line_ends_are_refused(name, tmp_path):
    """A binary file that was transferred as text would open as noise."""
    data = (DATA / name).read_bytes()
    (tmp_path / name).write_bytes(data.replace(b"\r\n", b"\n").replace(b"\n", b"\r\n"))
    with pytest.raises(InputFileError, match="it was transferred as text"):
        read_height_map(tmp_path / name)
