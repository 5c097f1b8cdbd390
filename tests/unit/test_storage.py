"""Result files are written whole or not at all, described, and the same for the same content."""

import json
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import pandas as pd
import pytest
import xarray as xr

import roughcontact
from roughcontact import errors
from roughcontact.arguments.maps import height_map
from roughcontact.arguments.variables import describe
from roughcontact.contact.solve import solve_contact
from roughcontact.io.read import read_height_map
from roughcontact.results.selection import read_statistics
from roughcontact.results.storage import (
    opened_dataset,
    provenance,
    read_dataset,
    write_dataset,
    write_table,
    write_text,
    written_load_by_load,
)
from roughcontact.surface.synthetic import rough_reference_surface

PRESSURE_BINS = {"units": "Pa", "long_name": "pressure", "bounds": "pressure_bin_bounds"}


def small():
    return xr.Dataset({"gap": (("y", "x"), np.arange(6.0).reshape(2, 3))}, coords={"y": [0.0, 1.0]})


def test_what_is_written_is_read_and_described(tmp_path):
    write_dataset(small().assign_attrs(provenance({"level": {"form": "plane"}})), tmp_path / "a" / "gap.nc")
    read = read_dataset(tmp_path / "a" / "gap.nc")
    np.testing.assert_array_equal(read["gap"], small()["gap"])
    assert read["gap"].attrs == {"units": "m", "long_name": "gap between the deformed surfaces"}
    assert read.attrs["settings"] == '{"level": {"form": "plane"}}'


@pytest.mark.parametrize("as_dataset", [False, True])
def test_lengths_in_another_unit_are_converted(tmp_path, as_dataset):
    axes = {axis: (axis, [0.0, 0.5, 1.0], {"units": "um"}) for axis in "yx"}
    height = xr.DataArray(np.eye(3), axes, ("y", "x"), "height", {"units": "nm"})
    write_dataset(height.to_dataset() if as_dataset else height, tmp_path / "map.nc")
    dataset = read_dataset(tmp_path / "map.nc")
    np.testing.assert_allclose(dataset["height"], 1e-9 * np.eye(3))
    np.testing.assert_allclose(dataset["x"], [0.0, 5e-7, 1e-6])
    assert dataset.attrs.get("units", "m") == "m"


def test_a_file_is_defined_as_xarray_would_define_it(tmp_path):
    """Variables in one pass are those of `to_netcdf` in order, type, attributes, and room.

    Random digits are written as they are: compression takes longer than the solution and saves a sixth.
    """
    gap = np.random.default_rng(0).random((2, 2500, 2))
    axes = {"x": [0.0, 1.0], "source": ["solver", "window"], "mean_pressure": ("load", [1.0, 2.0])}
    columns = {
        "pressure": (("load", "y", "x"), np.maximum(gap - 0.7, 0.0)),
        "gap": (("load", "y", "x"), gap),
        "verdict": ("load", np.int8([0, 2])),
        "mean_gap_uncertainty": (("load", "source"), np.float32([[np.nan, 1.0], [2.0, 3.0]])),
        "pressure_density": (("load", "pressure_bin"), np.ones((2, 3))),
        "pressure_bin_bounds": (("pressure_bin", "bounds"), np.zeros((3, 2))),
    }
    bins = xr.Variable("pressure_bin", [1.0, 2.0, 3.0], PRESSURE_BINS)
    dataset = xr.Dataset(columns, axes | {"pressure_bin": bins, "contact_modulus": 1e9})
    dataset = describe(dataset.assign_attrs(settings="{}", threads=2))
    write_dataset(dataset, tmp_path / "own.nc")
    encoding = {name: {"_FillValue": None} for name in dataset.coords} | {
        "pressure": {"chunksizes": (1, 512, 2), "zlib": True, "complevel": 1, "_FillValue": np.nan},
        "gap": {"chunksizes": (1, 512, 2), "_FillValue": np.nan},
    }
    dataset.to_netcdf(tmp_path / "theirs.nc", engine="netcdf4", encoding=encoding)
    definitions = []
    for name in ("own.nc", "theirs.nc"):
        with netCDF4.Dataset(tmp_path / name) as file:
            file.set_auto_maskandscale(False)
            parts = (
                (n, v.dtype, v.dimensions, v.__dict__, v.chunking(), v.filters(), v[...].tolist())
                for n, v in file.variables.items()
            )
            sizes = {key: dimension.size for key, dimension in file.dimensions.items()}
            definitions.append(repr([*parts, sizes, file.__dict__]))
    assert definitions[0] == definitions[1]


def test_equal_content_gives_equal_bytes(tmp_path):
    for name in ("one.nc", "two.nc"):
        write_dataset(rough_reference_surface(128), tmp_path / name)
    assert (tmp_path / "one.nc").read_bytes() == (tmp_path / "two.nc").read_bytes()


def test_a_failure_leaves_what_was_there(tmp_path):
    path = tmp_path / "gap.nc"
    write_dataset(small(), path)
    content_before = path.read_bytes()
    with pytest.raises(
        errors.RoughContactError, match=r"no description for the output variables \['slope'\]"
    ):
        write_dataset(small().rename(gap="slope"), path)
    unwritable = small().assign_attrs(note=object())
    with pytest.raises(TypeError):
        write_dataset(unwritable, path)
    assert path.read_bytes() == content_before
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
    for name, words in (
        ("gap.nc", r"not readable as netCDF .*; delete it \(of a surface: its folder\) and run again"),
        ("absent.nc", "no such file; check the path"),
    ):
        with pytest.raises(errors.InputFileError, match=f"{name}: {words}"):
            read_dataset(tmp_path / name)


def test_a_name_that_looks_like_a_formula_is_text_to_a_spreadsheet(tmp_path):
    names = ["-1-HYP", "=cmd()", "+1", "@A1", "ground-1", ""]
    table = pd.DataFrame({"surface": names, "load": [-1.5, 1, 2, 3, 4, np.nan]})
    write_table(table, tmp_path / "summary.csv")
    read = pd.read_csv(tmp_path / "summary.csv", keep_default_na=False)
    assert list(read["surface"]) == ["'-1-HYP", "'=cmd()", "'+1", "'@A1", "ground-1", ""]
    assert read["load"][0] == "-1.5"  # a number stays one


@pytest.mark.skipif(os.name == "nt", reason="the separator of the system")
def test_a_folder_that_netcdf_cannot_name_is_the_reason(tmp_path):
    with pytest.raises(
        errors.OutputFileError, match="backslash in its path for a separator: rename that folder"
    ):
        write_dataset(small(), tmp_path / "a\\b" / "gap.nc")


def test_a_full_disk_is_named_and_what_was_there_stays(disk):
    small_disk = disk("size=64k")
    large = xr.Dataset({"gap": (("y", "x"), np.random.default_rng(0).random((100, 200)))})
    write_dataset(small(), small_disk / "gap.nc")
    content_before = (small_disk / "gap.nc").read_bytes()
    with pytest.raises(
        errors.OutputFileError, match=r"gap.nc: cannot be written, the disk is full \(.* MB free\)"
    ):
        write_dataset(large, small_disk / "gap.nc")
    height = height_map(np.zeros((100, 200)), 1e-6)
    maps = large.rename(gap="pressure").expand_dims(load=1).assign_coords(height.coords)
    with (
        pytest.raises(errors.OutputFileError, match=r"contact.nc: .*disk is full"),
        written_load_by_load(small_disk / "contact.nc", [1.0], height) as file,
    ):
        file.write_maps(maps.assign_coords(mean_pressure=("load", [1.0])))
    with pytest.raises(errors.OutputFileError, match=r"a.txt: .*disk is full"):
        write_text("a" * 100_000, small_disk / "a.txt")
    assert [path.name for path in small_disk.iterdir()] == ["gap.nc"]
    assert (small_disk / "gap.nc").read_bytes() == content_before


def test_the_limit_of_the_size_of_files_is_named(tmp_path):
    """As a shell sets it by `ulimit -f`; netCDF says of it that there is an error of HDF."""
    large = xr.Dataset({"gap": (("y", "x"), np.random.default_rng(0).random((100, 200)))})
    limit_before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limit_before[1]))
    try:
        for write in (lambda path: write_dataset(large, path), lambda path: write_text("a" * 30_000, path)):
            with pytest.raises(
                errors.OutputFileError, match=r"gap.nc: cannot be written, a limit .*ulimit -f"
            ):
                write(tmp_path / "gap.nc")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit_before)
    assert not list(tmp_path.iterdir())


def test_a_read_only_folder_is_named(disk):
    small_disk = disk("size=64k,ro")
    for write in (lambda path: write_dataset(small(), path), lambda path: write_text("a", path)):
        for name in ("gap.nc", "new/gap.nc"):
            with pytest.raises(errors.OutputFileError, match=rf"{name}: cannot be written, .* is read-only"):
                write(small_disk / name)


def test_a_damaged_result_is_named(tmp_path):
    """Whichever bit of its content is turned, by all that reads results and by the reader of maps."""
    path = tmp_path / "height.nc"
    heights = np.random.default_rng(0).random((16, 16))
    write_dataset(height_map(heights, 1e-6), path)
    undamaged = path.read_bytes()
    for position in np.random.default_rng(1).integers(0, undamaged.rindex(b"\nroughcontact"), 60):
        path.write_bytes(
            undamaged[:position]
            + bytes([undamaged[position] ^ 1 << int(position) % 8])
            + undamaged[position + 1 :]
        )
        for read in (read_dataset, lambda path: opened_dataset(path).__enter__()):
            with pytest.raises(errors.InputFileError, match=r"height\.nc: .*; delete it .* and run again"):
                read(path)
    path.write_bytes(undamaged.replace(heights[3, 5].tobytes(), heights[3, 6].tobytes()))
    for read in (read_dataset, read_height_map):
        with pytest.raises(
            errors.InputFileError, match="damaged, or changed by another program, since it was"
        ):
            read(path)


def test_a_result_that_another_program_has_written_is_read(tmp_path):
    path = tmp_path / "gap.nc"
    write_dataset(small(), path)
    read_dataset(path).to_netcdf(tmp_path / "own.nc")
    xr.testing.assert_identical(read_dataset(tmp_path / "own.nc"), read_dataset(path))
    with h5py.File(path, "r+") as file:  # which cuts off the checksum
        file["gap"][0, 0] = 7.0
    assert read_dataset(path)["gap"][0, 0] == 7.0


@pytest.mark.parametrize("kind", [errors.SettingsError, FileNotFoundError, MemoryError])
def test_an_error_of_something_else_within_an_open_file_passes_as_it_is(tmp_path, kind):
    write_dataset(small(), tmp_path / "gap.nc")
    with pytest.raises(kind, match=r"^level\.order = 0$"), opened_dataset(tmp_path / "gap.nc"):
        raise kind("level.order = 0")


def test_a_file_says_what_it_is_and_what_computed_it():
    settings = [{"level": 1, "contact": 2}, {"contact": 2, "level": 1}]
    assert provenance(settings[0]) == provenance(settings[1])
    attrs_of_height = provenance({}, stage="height", subject="ground")
    attrs = provenance({}, stage="window", subject="ground", history=attrs_of_height["history"])
    assert attrs["title"] == "Periodic window: ground"
    assert attrs["history"].splitlines() == [
        f"Heights as measured by {attrs['source']}",
        f"Periodic window by {attrs['source']}",
    ]
    assert {"numpy", "scipy", "h5py", "SurfaceTopography", "python"} <= set(json.loads(attrs["versions"]))
    # that loads come in the order of their pressures concerns files of loads alone
    assert "comment" not in attrs
    assert "pressure" in provenance({}, stage="statistics")["comment"]


def test_the_commit_is_that_of_the_checkout_and_of_no_folder_around_it(tmp_path):
    """An environment often lies within the checkout of something else."""
    package = Path(roughcontact.__file__).parent
    git = ["git", "-c", "user.name=a", "-c", "user.email=a@b"]
    ask = "from roughcontact.results.storage import provenance; print(provenance({}).get('commit'))"
    for location, is_checkout in (("workflow/lib", True), ("venv/lib/site-packages", False)):
        checkout = tmp_path / location.partition("/")[0]
        copy = tmp_path / checkout / location / "roughcontact"
        shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))
        subprocess.run([*git, "init", "-q", checkout], check=True)
        subprocess.run([*git, "commit", "-q", "--allow-empty", "-m", "a"], check=True, cwd=checkout)
        ask_git = ["git", "-C", checkout, "rev-parse", "HEAD"]
        head = subprocess.run(ask_git, capture_output=True, text=True, check=True)
        command = [sys.executable, "-c", ask]
        variables = os.environ | {"PYTHONPATH": str(copy.parent)}
        commit = subprocess.run(
            command, env=variables, capture_output=True, text=True, check=True
        ).stdout.strip()
        assert commit == (head.stdout.strip() if is_checkout else "None")


def test_axes_are_named_and_bounds_are_described_by_their_bins(tmp_path):
    bins = {
        "pressure_bin_centre": ("pressure_bin", [1.0, 3.0], {"bounds": "pressure_bin_bounds"}),
        "pressure_bin_bounds": (("pressure_bin", "bounds"), [[0.0, 2.0], [2.0, 4.0]]),
    }
    write_dataset(small().assign_coords(x=[0.0, 1.0, 2.0], **bins), tmp_path / "gap.nc")
    read = read_dataset(tmp_path / "gap.nc")
    assert [read[name].attrs["axis"] for name in "xy"] == ["X", "Y"]
    assert "long_name" not in read["pressure_bin_bounds"].attrs
    assert read["pressure_bin_centre"].attrs["bounds"] == "pressure_bin_bounds"


def test_numbers_may_be_missing_and_coordinates_may_not(tmp_path):
    """CF conventions, 2.5.1: what other programs take for missing."""
    write_dataset(small(), tmp_path / "gap.nc")
    with h5py.File(tmp_path / "gap.nc") as file:
        assert np.isnan(file["gap"].attrs["_FillValue"])
        assert "_FillValue" not in file["y"].attrs


def test_loads_come_in_any_order_and_may_be_alike(tmp_path):
    problem = {"contact_modulus": 1.0, "mean_pressure": [0.2, 0.05, 0.2]}
    height = rough_reference_surface(96)
    path = tmp_path / "contact.nc"
    with written_load_by_load(path, problem["mean_pressure"], height) as file:
        solved = solve_contact(height, **problem, reduce=file.write_maps)
        assert not path.exists()
        file.complete(solved.assign(height=height))
    at_once = solve_contact(height, **problem)
    write_dataset(at_once, tmp_path / "at_once.nc")
    with opened_dataset(path) as dataset:
        assert dataset["pressure"].encoding["chunksizes"] == (1, 96, 96)
        xr.testing.assert_identical(dataset.load(), read_dataset(tmp_path / "at_once.nc"))


@pytest.mark.parametrize("shape", [(520, 1030), (512, 1024), (1, 5000), (3, 2)])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_maps_are_read_as_they_were_whoever_reads_them(tmp_path, shape, dtype):
    """Noise, zeros, what repeats, missing points; pieces that reach beyond the edge of the map."""
    rng = np.random.default_rng(1)
    gap = rng.standard_normal(shape).astype(dtype)
    pressure = np.where(rng.random(shape) < 0.1, np.abs(gap), 0).astype(dtype)
    gap[0, 0], pressure[-1] = np.nan, 1.5
    maps = {"pressure": pressure, "gap": gap, "contact": (pressure > 0).astype(np.int8)}
    height = height_map(np.zeros(shape), 1e-6)
    with written_load_by_load(tmp_path / "contact.nc", [2.0, 1.0], height) as file:
        for load, sign in ((1.0, 1), (2.0, -1)):
            fields = {name: (("load", "y", "x"), sign * values[None]) for name, values in maps.items()}
            file.write_maps(
                xr.Dataset(fields, coords={"mean_pressure": ("load", [load])} | dict(height.coords))
            )
        numbers = xr.Dataset(coords={"mean_pressure": ("load", [2.0, 1.0])})
        file.complete(numbers.assign(height=height))
    dataset = read_dataset(tmp_path / "contact.nc")
    with h5py.File(tmp_path / "contact.nc") as file_of_hdf5:
        for name, values in maps.items():
            for load, sign in ((1, 1), (0, -1)):
                assert dataset[name].dtype == values.dtype
                np.testing.assert_array_equal(dataset[name][load], sign * values)
                np.testing.assert_array_equal(file_of_hdf5[name][load], sign * values)


def test_what_repeats_takes_little_room(tmp_path):
    height = height_map(np.zeros((512, 1024)), 1e-6)
    maps = xr.Dataset({"pressure": (("load", "y", "x"), np.ones((1, 512, 1024)))}, coords=height.coords)
    with written_load_by_load(tmp_path / "contact.nc", [1.0], height) as file:
        file.write_maps(maps.assign_coords(mean_pressure=("load", [1.0])))
        file.complete(xr.Dataset(coords={"mean_pressure": ("load", [1.0])}))
    assert (tmp_path / "contact.nc").stat().st_size < 0.02 * maps["pressure"].nbytes


def test_a_solution_that_fails_half_way_leaves_no_file(tmp_path):
    loads, height = [0.05, 0.2], rough_reference_surface(64)
    with (
        pytest.raises(errors.ConvergenceError),
        written_load_by_load(tmp_path / "a.nc", loads, height) as file,
    ):
        solve_contact(
            height,
            contact_modulus=1.0,
            mean_pressure=loads,
            tolerance=1e-7,
            precision="single",
            reduce=file.write_maps,
        )
    assert list(tmp_path.iterdir()) == []


def test_a_file_without_loads_is_no_file_of_statistics(tmp_path):
    path = tmp_path / "map.nc"
    write_dataset(height_map(np.zeros((4, 4)), 1e-6), path)
    with pytest.raises(errors.InputFileError, match=r"map\.nc: has no loads .*no file of statistics"):
        read_statistics(path)
