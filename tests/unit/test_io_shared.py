"""Real instrument files: each one of the catalogue is read right, or refused in one clear sentence.

Expected numbers are the catalogue's; where the catalogue is wrong or silent, the table below has its own and
says why.
"""

import csv
import json

import numpy as np
import pytest
from shared_data import DATA

from roughcontact.errors import InputFileError
from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map
from roughcontact.io.units import metres

pytestmark = pytest.mark.shared_data

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
    # The header sets the counts below 5 apart as no heights (first_valid), and one whole line of 500 points
    # carries the count 0, beside 33 missing lines: it was not scanned. SurfaceTopography and Gwyddion
    # know only the count 1 as missing and read that line as 0 m, 77 µm below all others.
    "frt-1.frt": {"missing": (76456 + 500) / 250000, "rms": 2.504539e-6},
    # heights are said to be in nm; the steps are given
    "AFM.txt": {"size_x": 1024e-9, "size_y": 1024e-9, "rms": 4.136829e-9},
    # one missing point is an empty element; the size is 4 increments of 16.016 mm
    "ISO5436-sample1.x3p": {
        "nx": 4,
        "ny": 4,
        "size_x": 0.064064,
        "size_y": 0.064064,
        "rms": 0.6105091545,
        "missing": 1 / 16,
    },
    # the same map as sample-land-cran.x3p, as doubles, its root element misnamed and in a folder
    "sample-land.x3p": {
        "nx": 918,
        "ny": 256,
        "size_x": 0.00236844,
        "size_y": 0.00066048,
        "rms": 34.3342749e-6,
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
    "nms-1.nms": [-8.39012783e-07, 8.98862699e-07, -3.69125117e-08],
    "tmd-1.tmd": [9.36037031e-05, 3.68813453e-05, 0.000143076861],
    "test_uncompressed.sur": [-3.3610633e-08, -1.09475683e-07, 1.74253542e-07],
    "Hamby252_Barrel1_Bullet1_Land4.x3p": [-8.5677496e-05, -1.2227534e-05, -7.3085126e-05],
}


# Gwyddion 2.62: dx, dy (m), missing points, heights at the same points as above minus that in the middle (m).
GWYDDION = {
    "ISO5436-sample1.x3p": (0.016016, 0.016016, 1, [1.04367851, np.nan, 1.23285654]),
    "ISO5436-sample4_bin.x3p": (0.016016, 0.016016, 1, [1.043, np.nan, 1.232]),
    "KautschukInfiniteFocus.x3p": (
        2.27998421e-06,
        2.27979452e-06,
        5296,
        [7.42733232e-06, 1.98471071e-06, 9.72818543e-06],
    ),
    "al3d-1.al3d": (4.38027e-07, 4.38027e-07, 0, [1.23903155e-05, -8.94069672e-08, -2.14576721e-06]),
    "bcrf-1.bcrf": (1.8514625e-06, 1.85146333e-06, 0, [-9.05990601e-09, -7.26318359e-09, -6.96563721e-09]),
    "di-1.di": (9.765625e-10, 9.765625e-10, 0, [7.2762307e-09, 2.36942263e-08, 2.38736579e-08]),
    "di-3.di": (3.90625e-08, 3.90625e-08, 0, [3.98338366e-07, -1.20627764e-07, 5.48308019e-08]),
    "example_ps.tiff": (1.953125e-09, 1.953125e-09, 0, [-8.43841979e-09, -1.00016182e-08, -1.08261568e-08]),
    "frt-1.frt": (2.4e-05, 2.4e-05, 76456, [-5.70329905e-06, 8.6916715e-07, -1.88482315e-06]),
    "grid.nid": (1.171875e-08, 1.171875e-08, 0, [9.81686185e-08, 4.19329229e-08, -7.5548072e-08]),
    "metropro-1.dat": (1.09825203e-06, 1.09825203e-06, 0, [-1.15555114e-07, 6.84667966e-08, -8.74012752e-08]),
    "mi-1.mi": (7.8125e-08, 7.8125e-08, 0, [3.81768036e-08, -4.00369263e-08, 2.29415131e-08]),
    "nid-1.nid": (7.8125e-08, 7.8125e-08, 0, [3.66045833e-07, -2.36214743e-07, 1.79334084e-07]),
    "opd-1.opd": (1.96733032e-07, 1.96733032e-07, 116, [1.21023241e-09, 4.17797972e-09, -6.16048089e-09]),
    "plu-1.plu": (1.66000009e-06, 1.66000009e-06, 0, [-3.57421875e-06, 3.484375e-06, -2.90234375e-06]),
    "sample-land-cran.x3p": (2.58e-06, 2.58e-06, 25292, [-7.10476015e-05, np.nan, -6.0158276e-05]),
    "sdf-1.sdf": (1e-06, 1e-06, 0, [1.508e-08, 1.508e-08, -5.04e-09]),
    "spot_1-1000nm.ibw": (
        7.84313725e-08,
        7.84313725e-08,
        0,
        [1.0622054e-07, -1.08634822e-07, 1.09026956e-07],
    ),
    "stp-1.stp": (2.34375e-09, 2.34375e-09, 0, [-3.56081034e-09, -9.8222533e-11, -3.53569043e-09]),
    "sur-2.sur": (3.48400022e-06, 3.48400022e-06, 0, [9.30000011e-09, 1.44000002e-08, -9.50000011e-09]),
    "test_1.opd": (1.6342412e-06, 1.90661467e-06, 809, [1.91423729e-06, 4.68474576e-07, -6.16610169e-07]),
    "valid_zygo_dat_file.dat": (
        0.000117924203,
        0.000117924203,
        47241,
        [-9.76776827e-08, 6.63833599e-08, 6.14492658e-08],
    ),
    "x3p-2.x3p": (1.2765651e-07, 3.14582114e-07, 0, [-4.04768e-08, -1.258867e-07, 2.7231e-09]),
}
# Points that it takes for heights: those with the marker of Digital Surf (zmin - 2), which surfalize and
# SurfaceTopography know, and the line of FRT that was not scanned.
MORE_MISSING = {"sur-2.sur": 117, "frt-1.frt": 500}

# What Gwyddion or the bytes of the file say of instrument, lens, date and serial number.
INSTRUMENT = {
    "al3d-1.al3d": {"kind": "optical profiler", "vendor": "Alicona Imaging"},
    "di-1.di": {
        "name": "Dimension V",
        "scanner_serial": "Hybrid 306",
        "acquisition_time": "2016-01-12T09:57:48",
    },
    "di-3.di": {
        "name": "Dimension Icon",
        "scanner_serial": "1BEC3",
        "acquisition_time": "2014-12-15T13:33:51",
    },
    "example_ps.tiff": {"kind": "scanning probe microscope", "vendor": "Park Systems", "probe": "NCHR"},
    "frt-1.frt": {"vendor": "FRT", "serial": "SN_1036", "acquisition_time": "2023-03-10T15:57:20"},
    "grid.nid": {"name": "SH_B", "serial": "096-20-011", "acquisition_time": "2020-08-20T16:30:46"},
    "nid-1.nid": {"name": "DriveAFM", "serial": "091-21-061", "acquisition_time": "2022-11-03T11:46:25"},
    "mi-1.mi": {"acquisition_time": "2014-02-18T15:00:51"},
    "nms-1.nms": {"vendor": "NanoFocus", "acquisition_time": "2022-02-09T13:25"},
    "opd-1.opd": {"lens": "50 X", "numerical_aperture": 0.55, "acquisition_time": "2015-07-07T16:19:48"},
    "test_1.opd": {"serial": "NT1106279", "lens": "5 X", "acquisition_time": "2009-10-26T11:16:55"},
    "opdx-3.opdx": {"kind": "stylus profiler", "name": "Dektak Profiler"},
    "plu-1.plu": {"lens": "Nikon CFI Plan Interferential 10X", "acquisition_time": "2023-03-10T16:35:59"},
    "metropro-1.dat": {"lens": "20X Mirau", "serial": "59407", "acquisition_time": "2011-07-23T16:49:36"},
    "valid_zygo_dat_file.dat": {"serial": "652222", "acquisition_time": "2015-04-24T19:54:52"},
    "spot_1-1000nm.ibw": {"name": "Cypher", "acquisition_time": "2019-10-24T12:14:13"},
    "stp-1.stp": {"serial": "24", "acquisition_time": "2011-03-11T20:23:46.484000"},
    "sur-3.sur": {"acquisition_time": "2023-06-22T10:08:53"},
    "test_uncompressed.sur": {"sample": "* DVD *"},
    "sdf-1.sdf": {"acquisition_time": "2010-01-04T08:53:00+00:00"},
    "KautschukInfiniteFocus.x3p": {"vendor": "Alicona Imaging GmbH", "serial": "H271106000"},
    "Hamby252_Barrel1_Bullet1_Land4.x3p": {"name": "usurf", "lens": "20x"},
    "sample-land-cran.x3p": {
        "serial": "350262016",
        "lens": "Nikon - EPI 20X",
        "acquisition_time": "2018-09-15T17:46:09+00:00",
    },
}
# words that a file does not say, though something in it looks like it
SILENT = {
    "mnt-2.mnt": "serial",  # that in the file is the licence of the software
    "x3p-2.x3p": "acquisition_time",  # 1970-01-01 is a clock that was never set
    "sur-2.sur": "acquisition_time",  # 0. 0. 0
    "spot_1-1000nm.ibw": "serial",
}


# Files that begin at the bottom of their picture, by their standard or their positions; others at the top.
BOTTOM = {
    *("x3p-2.x3p", "KautschukInfiniteFocus.x3p", "ISO5436-sample1.x3p", "ISO5436-sample4_bin.x3p"),
    *("Hamby252_Barrel1_Bullet1_Land4.x3p", "sdf-1.sdf", "xyz-2.txt", "test1.txt", "csv-1.csv"),
}


def in_order_of_the_file(height):
    """Return the heights with the first row of the file first: for a picture the upper one."""
    return height.values if height.attrs["source_file"] in BOTTOM else height.values[::-1]


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
    assert height.attrs["y_axis"] == "up"
    assert height.attrs["first_row"] == ("bottom" if name in BOTTOM else "top")
    assert height.attrs["first_row_assumed"] == (name == "AFM.txt")


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
    height = in_order_of_the_file(read_height_map(DATA / name))
    ny, nx = height.shape
    points = [(ny // 5, nx // 7), (ny // 3, 6 * nx // 7), (4 * ny // 5, nx // 5)]
    found = [height[point] - height[ny // 2, nx // 2] for point in points]
    np.testing.assert_allclose(found, SECOND_READER[name], rtol=1e-5, atol=1e-6 * np.nanstd(height))


@pytest.mark.parametrize("name", sorted(GWYDDION))
def test_steps_heights_and_missing_points_against_gwyddion(name):
    dx, dy, missing, heights = GWYDDION[name]
    height = read_height_map(DATA / name)
    values = in_order_of_the_file(height)
    ny, nx = values.shape
    points = [(ny // 5, nx // 7), (ny // 3, 6 * nx // 7), (4 * ny // 5, nx // 5)]
    found = [values[point] - values[ny // 2, nx // 2] for point in points]
    np.testing.assert_allclose(found, heights, rtol=1e-5, atol=1e-6 * np.nanstd(values))
    assert float(height.x[1] - height.x[0]) == pytest.approx(dx, rel=1e-8)
    assert float(height.y[1] - height.y[0]) == pytest.approx(dy, rel=1e-8)
    assert height.attrs["missing_points"] == missing + MORE_MISSING.get(name, 0)


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
    height = read_height_map(DATA / name, **GIVEN.get(name, {}))
    table = np.loadtxt(DATA / name, skiprows=skip, encoding="latin-1") * factor
    np.testing.assert_allclose(height.values[::-1], table, rtol=1e-12)


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
    height = read_height_map(DATA / "test1.txt", **GIVEN["test1.txt"])
    column, row = np.rint(table[:, :2].T / 0.005).astype(int)
    np.testing.assert_allclose(height.values[row, column], 1e-6 * table[:, 2], rtol=1e-12)
    trace = np.loadtxt(DATA / "csv-1.csv", delimiter=",", skiprows=1)
    profile = read_height_map(DATA / "csv-1.csv", **GIVEN["csv-1.csv"])
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
    assert "read as heights on request (by its name no topography)" in amplitude.attrs["ingest_warnings"]


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


@pytest.mark.parametrize("name", sorted(INSTRUMENT))
def test_instrument_lens_date_and_serial_are_kept(name):
    instrument = json.loads(read_height_map(DATA / name).attrs["instrument"])
    assert {word: instrument.get(word) for word in INSTRUMENT[name]} == INSTRUMENT[name]
    assert instrument == inspect_file(DATA / name)["instrument"]


@pytest.mark.parametrize("name", sorted(SILENT))
def test_what_only_looks_like_a_serial_number_or_a_date(name):
    instrument = inspect_file(DATA / name)["instrument"]
    assert SILENT[name] not in instrument
    assert "DS-781758056" not in instrument.values()


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("frt-1.frt", "4 points lie far below all others"),  # and no more: those at 0 are missing
        ("plu-1.plu", None),  # its step of 3.91 nm is judged with the statistics
        ("ISO5436-sample1.x3p", "more than the field"),
        ("test_1.opd", "pixels are not square"),
        ("example_ps.tiff", None),
        ("metropro-1.dat", None),  # its two spikes are found when it is levelled
        ("tmd-1.tmd", None),
        ("nms-1.nms", None),
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


def test_a_wyko_map_that_was_inverted_is_passed_on(tmp_path):
    data = bytearray((DATA / "test_1.opd").read_bytes())
    place = 1067456  # of the value of Data_Invert, 10 characters
    assert data[place : place + 10].rstrip(b"\0") == b"No"
    data[place : place + 3] = b"Yes"
    (tmp_path / "inverted.opd").write_bytes(data)
    words = "the map was inverted or mirrored"
    assert any(words in note for note in inspect_file(tmp_path / "inverted.opd")["warnings"])
    assert not any(words in note for note in inspect_file(DATA / "test_1.opd")["warnings"])


@pytest.mark.parametrize(
    ("name", "place", "words"),
    [
        ("sur-3.sur", 288, "an imprint (replica) was measured"),
        ("sur-3.sur", 290, "the map was inverted or mirrored"),
        ("metropro-1.dat", 233, "the map was inverted or mirrored"),
    ],
)
def test_a_header_that_speaks_of_the_sign_is_passed_on(name, place, words, tmp_path):
    data = bytearray((DATA / name).read_bytes())
    assert data[place] == 0
    data[place] = 1
    (tmp_path / name).write_bytes(data)
    notes = json.loads(read_height_map(tmp_path / name).attrs["ingest_warnings"])
    assert any(words in note for note in notes)
    assert not any(words in note for note in inspect_file(DATA / name)["warnings"])
