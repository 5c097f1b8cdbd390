"""The header of CDF-5, checked before the netCDF library reads it: files by that library, whole and not."""

import netCDF4
import numpy as np
import pytest

from roughcontact.errors import InputFileError
from roughcontact.io import classic
from roughcontact.io.read import read_height_map

HEIGHTS = np.arange(12.0).reshape(4, 3)


def written(path, *, records=0):
    """Write a map with coordinates, attributes, a number, and so many records of two further variables."""
    with netCDF4.Dataset(path, "w", format="NETCDF3_64BIT_DATA") as file:
        file.title, file.numbers = "a map", np.arange(100, 103, dtype="i8")
        for axis, count in (("y", 4), ("x", 3), ("t", None)):
            file.createDimension(axis, count)
        height = file.createVariable("height", "f8", ("y", "x"))
        height[:], height.units = HEIGHTS, "um"
        for axis, count in (("x", 3), ("y", 4)):
            positions = file.createVariable(axis, "f8", (axis,))
            positions[:], positions.units = np.arange(count), "um"
        file.createVariable("number", "i4", ())[...] = 3
        if records:
            one, three = (
                file.createVariable("one", "i2", ("t",)),
                file.createVariable("three", "i2", ("t", "x")),
            )
            one[:], three[:] = np.arange(records), np.ones((records, 3))
    return path


@pytest.mark.parametrize("records", [0, 1, 5])
def test_whole_files_are_read(tmp_path, records):
    path = written(tmp_path / "map.nc", records=records)
    np.testing.assert_allclose(read_height_map(path).values, 1e-6 * HEIGHTS, rtol=1e-15)


@pytest.mark.parametrize("records", [0, 5])
def test_cut_files_are_refused(tmp_path, records):
    path = written(tmp_path / "map.nc", records=records)
    whole = path.read_bytes()
    for length in range(4, len(whole) - 3):  # the last bytes may be what fills up to a multiple of four
        path.write_bytes(whole[:length])
        with pytest.raises(InputFileError, match="damaged or cut off netCDF file"):
            classic.check_header(path)


def test_counts_beyond_the_file_are_refused_before_the_library_sees_them(tmp_path):
    path = written(tmp_path / "map.nc", records=2)
    whole = path.read_bytes()
    places = [place for place in range(16, 500, 4) if 0 < int.from_bytes(whole[place : place + 8]) < 20]
    assert len(places) > 20
    refused = 0
    for place in places:
        path.write_bytes(whole[:place] + (2**62).to_bytes(8) + whole[place + 8 :])
        try:
            classic.check_header(path)
        except InputFileError:
            refused += 1
    assert refused == len(places)
