"""Files made to hang a reader, to fill the memory, or to bring in what lies elsewhere."""

import json
import resource
import time
from contextlib import contextmanager
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pytest
import xarray as xr
from hostile import FILES, HEIGHTS
from measured_files import GIVEN, holds, labelled, matlab, refuses, saved
from test_io_instruments import surf

from roughcontact import inspect_file, read_height_map
from roughcontact.io import channels, inspection
from roughcontact.io.channels import Channel, MeasuredFile
from roughcontact.io.readers import digital_surf, netcdf
from roughcontact.io.readers import matlab as matlab_reader


@contextmanager
def no_more_than(gigabytes):
    """Limit the memory of this process by what is asked for, not by what is touched."""
    limit_before = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + int(gigabytes * 2**30), limit_before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limit_before)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a coordinate of 10¹⁰ points", "10000000000 points, more than the 134217728"),
        ("20 coordinates of 10⁸ points", "coordinates of 2000000032 points, more than the 33554432"),
    ],
)
def test_coordinates_and_variables_too_long_are_never_read(tmp_path, name, message):
    path = tmp_path / "map.nc"
    FILES[f"netCDF: {name}"][0](path)
    assert path.stat().st_size < 30_000
    with no_more_than(1):
        refuses(message, path)


def test_positions_and_uneven_maps_are_counted_over_all_variables(tmp_path, monkeypatch):
    file = xr.Dataset({f"z{number}": labelled(HEIGHTS) for number in range(5)})
    file.to_netcdf(tmp_path / "even.nc")
    uneven = file.assign_coords(x=("x", 1e-6 * np.arange(16.0) ** 2, {"units": "m"}))
    uneven.to_netcdf(tmp_path / "uneven.nc")
    monkeypatch.setattr(netcdf, "MAX_POINTS", 1000)  # five maps of 256 points, with 32 positions each
    holds(read_height_map(tmp_path / "even.nc", channel="z4"), HEIGHTS)
    refuses("positions, more than the 1000 that are read", tmp_path / "uneven.nc")


def series(count):
    """Return profiles of Digital Surf, one in a row."""
    return surf(np.arange(2 * count).reshape(count, 2), 4)


def pages(count):
    """Return a variable of MATLAB with so many pages, and beside it others."""
    return matlab(
        {f"v{number}": np.eye(3) for number in range(4)} | {"z": np.arange(4.0 * count).reshape(2, 2, -1)}
    )


def tables(count):
    """Return a text with so many tables below one another."""
    return "".join(f"Map {number} (um)\n1 2 3 4\n5 6 7 8\n2 3 4 5\n" for number in range(count)).encode()


def maps(count):
    """Return a netCDF variable with a third axis."""
    return bytes(xr.Dataset({"z": (("t", "y", "x"), np.arange(4.0 * count).reshape(-1, 2, 2))}).to_netcdf())


def traces(count):
    """Return a list of profiles below one another."""
    return b"x (um);z (um)\n" + b"".join(b"%d;%d\n" % (n % 4, n * 7919 % 97) for n in range(4 * count))


@pytest.mark.parametrize("make_file", [series, pages, tables, maps, traces])
def test_more_than_ten_thousand_channels_are_refused_before_they_are_made(refusal, monkeypatch, make_file):
    channels_made = []
    check = channels.Channel.__post_init__
    monkeypatch.setattr(
        channels.Channel, "__post_init__", lambda self: channels_made.append(1) or check(self)
    )
    refusal(make_file(10_001), "more than the 10000 that are read; save some in a file of")
    assert len(channels_made) < 30_100


@pytest.mark.parametrize(
    ("make_file", "module", "name", "count"),
    [(series, digital_surf, "_counts", 1), (pages, matlab_reader, "_load", 5), (maps, xr, "open_dataset", 1)],
)
def test_inspection_reads_what_holds_many_channels_once(
    tmp_path, monkeypatch, make_file, module, name, count
):
    calls = []
    load = getattr(module, name)
    monkeypatch.setattr(module, name, lambda *given, **options: calls.append(1) or load(*given, **options))
    contents = inspect_file(saved(tmp_path, make_file(300)), dx=1, dy=1, unit="um", height_unit="um")
    assert len(contents["channels"]) >= 300
    assert all("rms_height" in channel for channel in contents["channels"])
    assert len(calls) == count


def test_of_large_channels_inspection_reads_the_first_ones(tmp_path, monkeypatch):
    monkeypatch.setattr(inspection, "MAX_POINTS", 400)
    contents = inspect_file(saved(tmp_path, pages(300)), channel="z(:,:,300)", dx=1, dy=1, unit="um")
    read = [channel["name"] for channel in contents["channels"] if "rms_height" in channel]
    assert read[:2] == ["z(:,:,1)", "z(:,:,2)"]
    assert read[-1] == "z(:,:,300)"
    assert len(read) == 101


def test_names_that_are_equal_are_numbered():
    file = MeasuredFile("kind", [Channel("z", (1, 2), lambda: None) for _ in range(10_000)], "top")
    assert [file.channels[number].name for number in (0, 1, 9_999)] == ["z", "z (2)", "z (10000)"]


def test_a_good_map_beside_what_is_too_long_is_read(tmp_path):
    path = tmp_path / "map.nc"
    FILES["netCDF: six variables of 11 585²"][0](path)
    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("n", 10**12)
        file.createVariable("n", "f8", ("n",), chunksizes=(1024,))
        file.createVariable("trace", "f4", ("n",), chunksizes=(1024,)).units = "m"
    with no_more_than(0.9):
        height = read_height_map(path)
        contents = inspect_file(path)
    np.testing.assert_array_equal(height.values, HEIGHTS)
    assert contents["channel"] == "height"
    assert {channel["name"] for channel in contents["channels"]} >= {"height", "trace", "z0"}
    refuses("variable 'trace' has 1000000000000 points, more than", path, channel="trace", height_unit="m")


@pytest.mark.parametrize(
    "line",
    ["a" + 4000 * " " + "b", "Pixel size: 2" + 4000 * " " + "x", 4000 * "a" + ": 5 µm", 2000 * "a "],
    ids=["blanks", "a number and blanks", "a long name", "many words"],
)
def test_a_long_line_above_a_table_takes_no_time(read, line):
    start = time.process_time()
    holds(read(f"{line}\n" * 5 + "1 2\n3 4\n", **GIVEN), [[3e-6, 4e-6], [1e-6, 2e-6]])
    assert time.process_time() - start < 2


def test_deep_brackets_in_an_attribute(tmp_path):
    FILES["netCDF: 200 000 brackets in an attribute"][0](tmp_path / "map.nc")
    height = read_height_map(tmp_path / "map.nc")
    np.testing.assert_array_equal(height.values, HEIGHTS)
    assert json.loads(height.attrs["instrument"]) == {}


@pytest.mark.parametrize("name", ["external storage", "link into another file", "virtual array"])
@pytest.mark.parametrize("kind", ["plain", "zygo", "jpk"])
def test_numbers_of_other_files_are_refused(tmp_path, name, kind):
    path = tmp_path / "map.h5"
    FILES[f"HDF5: {name}"][0](path)
    with h5py.File(path, "a") as file:
        if kind == "zygo":
            file.create_group("MetaData")
        elif kind == "jpk":
            file.attrs["file-format-info"] = "JPK SCAN"
    refuses("which is refused: any file of this computer", path, **GIVEN, height_unit="m")


NO_END = "which is refused: the file may have no end"
# name of a file -> words of its refusal
AT_ONCE = {
    # each of these four ends a process that hands it to the netCDF library
    "HDF5: a group that contains itself": NO_END,
    "HDF5: a link in a circle": NO_END,
    "HDF5: groups doubled 40 times": NO_END,
    "HDF5: 5000 groups deep": NO_END,
    "TIFF: a page that is its own next one": "damaged TIFF: its pages form a loop",
    "TIFF: a page outside the file": "a page lies outside the file",
    "X3P: 250 MB of blanks": "no description of a map is so long",
}


@pytest.mark.parametrize("name", AT_ONCE)
def test_what_may_hang_a_reader_is_refused_at_once(tmp_path, name):
    path = tmp_path / "map.nc"
    FILES[name][0](path)
    start = time.process_time()
    refuses(AT_ONCE[name], path)
    assert time.process_time() - start < 1


def test_hdf5_of_another_kind_is_named_with_its_arrays(tmp_path):
    with h5py.File(tmp_path / "map.h5", "w") as file:
        file["scan/a/heights"] = HEIGHTS
        file["scan/a/time"] = 3.0
    words = r"neither netCDF nor .*it has /scan/a/heights \(16 x 16\), /scan/a/time \(1\); save"
    refuses(words, tmp_path / "map.h5")


def test_an_axis_scale_that_is_a_single_number_is_refused(tmp_path):
    with h5py.File(tmp_path / "map.h5", "w") as file:
        file["heights"], file["step"] = HEIGHTS, 1e-6
        file["step"].make_scale("x")
        file["heights"].dims[1].attach_scale(file["step"])
    refuses(r"/step of this HDF5 file is the scale of an axis but a single", tmp_path / "map.h5")


def test_a_heap_of_hdf5_without_an_end_is_refused(tmp_path):
    path = tmp_path / "map.nc"
    labelled(np.eye(5), "um", "z").to_netcdf(path, engine="netcdf4")
    assert read_height_map(path).shape == (5, 5)
    data = bytearray(path.read_bytes())
    position = data.find(b"GCOL") + 16
    while int.from_bytes(data[position : position + 2], "little"):  # the objects before the free space
        size = int.from_bytes(data[position + 8 : position + 16], "little")
        position += 16 + size + -size % 8
    data[position + 8 : position + 16] = bytes(8)
    path.write_bytes(data)
    refuses("a heap without an end", path)
