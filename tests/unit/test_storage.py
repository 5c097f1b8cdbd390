"""Result files are written whole or not at all, described, and the same for the same content."""

import numpy as np
import pytest
import xarray as xr

from roughcontact.errors import InputFileError, RoughContactError
from roughcontact.references.synthetic import rough_reference_surface
from roughcontact.results.storage import provenance, read_dataset, write_dataset, write_text


def small():
    return xr.Dataset({"gap": (("y", "x"), np.arange(6.0).reshape(2, 3))}, coords={"y": [0.0, 1.0]})


def test_what_is_written_is_read_and_described(tmp_path):
    write_dataset(small().assign_attrs(provenance({"level": {"form": "plane"}})), tmp_path / "a" / "gap.nc")
    read = read_dataset(tmp_path / "a" / "gap.nc")
    np.testing.assert_array_equal(read["gap"], small()["gap"])
    assert read["gap"].attrs == {"units": "m", "long_name": "gap between the deformed surfaces"}
    assert read.attrs["settings"] == '{"level": {"form": "plane"}}'


def test_equal_content_gives_equal_bytes(tmp_path):
    for name in ("one.nc", "two.nc"):
        write_dataset(rough_reference_surface(128), tmp_path / name)
    assert (tmp_path / "one.nc").read_bytes() == (tmp_path / "two.nc").read_bytes()


def test_a_failure_leaves_what_was_there(tmp_path):
    path = tmp_path / "gap.nc"
    write_dataset(small(), path)
    before = path.read_bytes()
    with pytest.raises(RoughContactError, match=r"no description for the output variables \['slope'\]"):
        write_dataset(small().rename(gap="slope"), path)
    unwritable = small().assign_attrs(note=object())
    with pytest.raises(TypeError):
        write_dataset(unwritable, path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_what_a_killed_job_left_is_written_over(tmp_path):
    for name, write in (
        ("gap.nc", lambda path: write_dataset(small(), path)),
        ("a.txt", lambda path: write_text("a", path)),
    ):
        (tmp_path / f".{name}.partial").write_text("half a file")
        write(tmp_path / name)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.txt", "gap.nc"]
    assert read_dataset(tmp_path / "gap.nc")["gap"].size == 6
    assert (tmp_path / "a.txt").read_text() == "a"


def test_a_file_that_is_no_netcdf_is_named(tmp_path):
    (tmp_path / "gap.nc").write_text("no")
    for name in ("gap.nc", "absent.nc"):
        with pytest.raises(
            InputFileError, match=rf"{name}: not readable as netCDF .*; delete it and run again"
        ):
            read_dataset(tmp_path / name)
