"""Files that have gained or lost bytes: refused where heights may have moved, else named."""

import numpy as np
import pytest
from fuzz_readers import GIVEN, SEEDS
from measured_files import array, holds, labelled, matlab, refuses, warnings_of
from shared_data import DATA

from roughcontact import InputFileError, inspect_file, read_height_map
from roughcontact.io import classic

MORE = DATA.parent / "more_data"
CHECKED = ("npy", "netcdf 3", "netcdf 4", "netcdf 5", "jpk_hdf5", "tmd", "sdf")
# real files whose headers say where the last byte lies
REAL = (
    *("al3d-1.al3d", "bcrf-1.bcrf", "di-1.di", "di-3.di", "example_ps.tiff", "frt-1.frt", "grid.nid"),
    *("metropro-1.dat", "mi-1.mi", "nid-1.nid", "nms-1.nms", "opd-1.opd", "stp-1.stp", "sur-2.sur"),
    *("sur-3.sur", "test_1.opd", "test_uncompressed.sur", "tmd-1.tmd", "valid_zygo_dat_file.dat"),
    *("SBS-PMMA.nid", "Veeco_20160622.003", "circles_holes.nid", "gelsight-testing.tmd"),
)


def changed(data, share, inserted):
    """Return bytes with some more, or without so many, at a share of their length."""
    at = int(share * len(data))
    inserted_bytes, lost = (inserted, 0) if isinstance(inserted, bytes) else (b"", inserted)
    return data[:at] + inserted_bytes + data[at + lost :]


@pytest.fixture(params=CHECKED)
def file_and_options(request, tmp_path):
    path = tmp_path / "map.npy"
    SEEDS[request.param](path)
    return path, GIVEN if request.param == "npy" else {}


def test_bytes_inserted_or_lost_are_refused(file_and_options):
    path, options = file_and_options
    content = path.read_bytes()
    for share in (0.6, 0.99):
        for inserted in (bytes(range(1, 101)), 100):
            path.write_bytes(changed(content, share, inserted))
            refuses(r"map\.npy: ", path, **options)


def test_padding_is_named_and_moves_nothing(file_and_options):
    path, options = file_and_options
    right = read_height_map(path, **options)
    size = path.stat().st_size
    path.write_bytes(path.read_bytes() + bytes(96))
    padded = read_height_map(path, **options)
    np.testing.assert_array_equal(padded.values, right.values)
    message = (
        f"the file has {size + 96} bytes where its header needs {size}; the last 96 of them are all 0 and"
    )
    assert message in warnings_of(padded)
    assert message not in warnings_of(right)


def test_the_refusal_and_the_way_out(read, refusal, tmp_path):
    heights, options = np.arange(20.0).reshape(4, 5), {"dx": 1, "dy": 1, "unit": "um"}
    data, path = array(heights) + b"0123456789", tmp_path / "map.dat"
    message = refusal(data, "298 bytes", **options)
    assert message == (
        f"{path}: 298 bytes where its header needs 288: not readable as NumPy array, because it was changed "
        "or damaged after it was written; export it again, or, where you know the change, give checksum = "
        "ignore (table of surfaces or argument)"
    )
    assert inspect_file(path, **options)["problem"] == message
    height = read(data, checksum="ignore", **options)
    holds(height, 1e-6 * heights)
    assert "298 bytes where its header needs 288: read nevertheless, as asked" in warnings_of(height)
    refusal(data[:270], "not readable as a NumPy array", checksum="ignore", **options)


def test_what_follows_a_variable_of_matlab_is_refused(refusal):
    content = matlab({"z": np.random.default_rng(1).standard_normal((20, 30))})
    for data in (changed(content, 0.6, bytes(range(100))), content + b"\1\2\3", content + bytes(64)):
        refusal(data, r"damaged MATLAB file: .* copy or save it again", **GIVEN)


@pytest.mark.parametrize("kind", ["NETCDF3_CLASSIC", "NETCDF3_64BIT", "NETCDF3_64BIT_DATA"])
def test_a_classic_header_that_contradicts_itself_is_refused(tmp_path, kind):
    path = tmp_path / "map.nc"
    heights = np.random.default_rng(1).standard_normal((40, 50))
    labelled(heights).to_netcdf(path, format=kind, engine="netcdf4")
    content = path.read_bytes()
    count = 8 if kind.endswith("DATA") else 4
    for number in (40, 50, 8 * 40 * 50):  # two axes, bytes of a variable
        position = content.index(number.to_bytes(count, "big"), 8)
        for number_written in (number - 1, number + 1, number // 2):
            path.write_bytes(
                content[:position] + number_written.to_bytes(count, "big") + content[position + count :]
            )
            refuses("damaged or cut off netCDF file", path)


@pytest.mark.shared_data
@pytest.mark.parametrize("name", REAL)
def test_a_real_file_is_as_long_as_its_header_says(name, tmp_path):
    source = DATA / name if (DATA / name).exists() else MORE / name
    content = source.read_bytes()
    right = read_height_map(source)
    assert "where its header needs" not in warnings_of(right)
    path = tmp_path / name
    # one byte alone is never padding; bytes that differ are none either
    for data in (
        changed(content, 0.6, bytes(range(250)) * 4),
        changed(content, 0.6, 100),
        content + b"behind it",
    ):
        path.write_bytes(data)
        refuses(name.replace(".", r"\."), path)
    path.write_bytes(content + bytes(512))
    padded = read_height_map(path)
    np.testing.assert_array_equal(padded.values, right.values)
    assert "512 of them are all 0 and are taken for padding behind the heights" in warnings_of(padded)


@pytest.mark.shared_data
@pytest.mark.parametrize(
    ("name", "position", "message"),
    [
        ("metropro-1.dat", 75, "its header counts .* bytes of heights, which are no 307200 points"),
        ("spot_1-1000nm.ibw", 150, "the checksum of its header does not match its content"),
    ],
)
def test_headers_that_contradict_themselves_are_refused(name, position, message, tmp_path):
    data = bytearray((DATA / name).read_bytes())
    data[position] ^= 4
    (tmp_path / name).write_bytes(data)
    refuses(f"{message}: not readable as .* give checksum = ignore", tmp_path / name)
    assert "read nevertheless" in warnings_of(read_height_map(tmp_path / name, checksum="ignore"))


@pytest.mark.parametrize("marker", [9.91e37, -9.9e37, 9.96921e36, 3.40282347e38, 1.70141e38])
@pytest.mark.parametrize("kind", ["<f4", "<f8"])
def test_numbers_beyond_all_heights_are_missing_points(read, marker, kind):
    heights = np.arange(20.0).reshape(4, 5)
    heights[1, 2] = marker
    height = read(array(heights.astype(kind)), **GIVEN)
    assert np.flatnonzero(np.isnan(height.values)).tolist() == [7]


# ---------------------------------------------------------------- the header of CDF-5


CLASSIC = np.arange(12.0).reshape(4, 3)


def written(path, records):
    """Write a map with coordinates, attributes, a number, and so many records of two further variables."""
    dataset = labelled(CLASSIC, "um").to_dataset().assign(number=np.int32(3))
    if records:
        numbers, three = np.arange(records, dtype="i2"), np.ones((records, 3))
        dataset = dataset.assign(one=("t", numbers), three=(("t", "x"), three))
    dataset = dataset.assign_attrs(title="a map", numbers=np.arange(100, 103))
    unlimited = ["t"] if records else []
    dataset.to_netcdf(path, format="NETCDF3_64BIT_DATA", engine="netcdf4", unlimited_dims=unlimited)
    return path


@pytest.mark.parametrize("records", [0, 1, 5])
def test_whole_files_are_read_and_cut_ones_refused(tmp_path, records):
    path = written(tmp_path / "map.nc", records=records)
    holds(read_height_map(path), 1e-6 * CLASSIC)
    content = path.read_bytes()
    for length in range(4, len(content) - 3):  # the last bytes may be what fills up to a multiple of four
        path.write_bytes(content[:length])
        with pytest.raises(InputFileError, match="damaged or cut off netCDF file"):
            classic.check_header(path)


def test_counts_beyond_the_file_are_refused_before_the_library_sees_them(tmp_path):
    path = written(tmp_path / "map.nc", records=2)
    content = path.read_bytes()
    positions = [
        position
        for position in range(16, 500, 4)
        if 0 < int.from_bytes(content[position : position + 8]) < 20
    ]
    assert len(positions) > 20
    for position in positions:
        path.write_bytes(content[:position] + (2**62).to_bytes(8) + content[position + 8 :])
        with pytest.raises(InputFileError):
            classic.check_header(path)
