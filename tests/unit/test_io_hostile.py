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
from hostile import FILES, HEIGHTS
from measured_files import GIVEN, labelled, refuses

from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map


@contextmanager
def no_more_than(gigabytes):
    """Limit the memory of this process by what is asked for, not by what is touched."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + int(gigabytes * 2**30), before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def test_coordinates_and_variables_too_long_are_never_read(tmp_path):
    path = tmp_path / "map.nc"
    FILES["netCDF: a coordinate of 10¹⁰ points"][0](path)
    assert path.stat().st_size < 20_000
    with no_more_than(1):
        refuses("10000000000 points, more than the 134217728", path)


def test_a_good_map_beside_what_is_too_long_is_read(tmp_path):
    path = tmp_path / "map.nc"
    FILES["netCDF: six variables of 11 585²"][0](path)
    with netCDF4.Dataset(path, "a") as file:
        file.createDimension("n", 10**12)
        file.createVariable("n", "f8", ("n",), chunksizes=(1024,))
        file.createVariable("trace", "f4", ("n",), chunksizes=(1024,)).units = "m"
    with no_more_than(0.9):
        height = read_height_map(path)
        found = inspect_file(path)
    np.testing.assert_array_equal(height.values, HEIGHTS)
    assert found["channel"] == "height"
    assert {each["name"] for each in found["channels"]} >= {"height", "trace", "z0"}
    refuses("variable 'trace' has 1000000000000 points, more than", path, channel="trace", height_unit="m")


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
    whole = bytearray(path.read_bytes())
    place = whole.find(b"GCOL") + 16
    while int.from_bytes(whole[place : place + 2], "little"):  # the objects before the free space
        size = int.from_bytes(whole[place + 8 : place + 16], "little")
        place += 16 + size + -size % 8
    whole[place + 8 : place + 16] = bytes(8)
    path.write_bytes(whole)
    refuses("a heap without an end", path)
