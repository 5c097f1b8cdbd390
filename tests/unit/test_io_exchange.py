"""X3P, SDF, NumPy and netCDF files: written by other libraries here, read back by the project."""

import hashlib
import json
import re

import netCDF4
import numpy as np
import pytest
import sdfio
import x3pio
import xarray as xr
from measured_files import GIVEN, archive, gsf, members, refuses, saved, steps, x3p

from roughcontact.errors import HeightMapError, InputFileError
from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map
from roughcontact.results.storage import write_dataset

HEIGHTS = np.array([[1.5, -2.25, 3.0, 0.5], [4.0, np.nan, -6.75, 7.0], [0.25, 9.0, 10.5, -1.0]]) * 1e-6
DX, DY = 2e-6, 3e-6


def check(height, first_row="bottom", rtol=1e-12):
    """Size, orientation, units and the count of missing points of the map above, as the file has its rows."""
    np.testing.assert_allclose(height.values[:: -1 if first_row == "top" else 1], HEIGHTS, rtol=rtol)
    np.testing.assert_allclose(height.x, DX * (0.5 + np.arange(4)), rtol=1e-12)
    np.testing.assert_allclose(height.y, DY * (0.5 + np.arange(3)), rtol=1e-12)
    assert height.name == "height"
    assert height.dims == ("y", "x")
    assert height.attrs["units"] == "m"
    assert height.attrs["first_row"] == first_row
    assert height.attrs["missing_points"] == 1
    assert height.attrs["missing_share"] == pytest.approx(1 / 12)


def x3p_bytes(**options):
    return x3p(HEIGHTS, DX, DY, **options)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"storage": x3pio.DataStorage.XML},
        {"z_type": x3pio.DataType.INT32},
        {"z_type": x3pio.DataType.FLOAT32},
    ],
)
def test_x3p(tmp_path, options):
    path = saved(tmp_path, x3p_bytes(**options))
    height = read_height_map(path)
    check(height, rtol=1e-6)
    assert height.attrs["source_sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert height.attrs["source_file"] == "map.dat"


@pytest.mark.parametrize("folder", ["one/", "one/two/"])
def test_x3p_in_a_folder_of_the_archive(read, folder):
    check(read(x3p_bytes(folder=folder)))


def test_x3p_with_another_root_element(read, refused):
    """Some tools call the root element ISO5436; a wrong checksum of that main.xml is still noticed."""

    def renamed(main):
        return main.replace(b"ISO5436_2", b"ISO5436")

    check(read(x3p_bytes(edit=renamed)))
    wrong = x3p_bytes(edit=renamed, restate=False)
    refused(wrong, r"map.dat: the checksum of main.xml does not match")


@pytest.mark.parametrize("encoding", [b"UTF-1.0", b"hex", b"rot13"])
def test_x3p_of_an_unknown_encoding_or_of_one_that_is_no_text_is_refused(tmp_path, encoding):
    def encoded(main):
        return b'<?xml version="1.0" encoding="' + encoding + b'"?>' + main.partition(b"?>")[2]

    path = saved(tmp_path, x3p_bytes(edit=encoded))
    for read in (read_height_map, inspect_file):
        with pytest.raises(InputFileError, match=r"map\.dat: not readable as X3P .*encoding"):
            read(path)


def test_x3p_infinite_heights_are_missing(read):
    def infinite(main):
        assert b"<Datum />" in main or b"<Datum/>" in main
        return re.sub(rb"<Datum ?/>", b"<Datum>INF</Datum>", main)

    check(read(x3p_bytes(storage=x3pio.DataStorage.XML, edit=infinite)))


def test_x3p_whose_numbers_were_changed_is_refused(refused):
    (name, data) = next(
        (name, data) for name, data in members(x3p_bytes()).items() if name.endswith("data.bin")
    )
    changed = archive(members(x3p_bytes()) | {name: data[:-1] + b"\0"})
    refused(changed, "not readable as X3P")


def test_x3p_layers_profile_and_points(read, tmp_path):
    path = saved(tmp_path, x3p(np.stack([HEIGHTS, 2 * HEIGHTS]), DX, DY))
    assert read_height_map(path).attrs["channel"] == "layer 1"
    second = read_height_map(path, channel="layer 2")
    np.testing.assert_allclose(second.values, 2 * HEIGHTS, rtol=1e-12)
    refuses(r"no channel is named 'layer 3'; the file has 'layer 1', 'layer 2'", path, channel="layer 3")
    profile = read(x3p(HEIGHTS[0], DX))
    assert profile.shape == (1, 4)
    np.testing.assert_allclose(profile.values[0], HEIGHTS[0], rtol=1e-12)
    x3pio.write_points(tmp_path / "points.x3p", np.random.default_rng(0).random((10, 3)))
    refuses(r"point cloud.*resample = linear", tmp_path / "points.x3p")


def stored_positions(x, y, heights):
    """X3P whose main.xml has positions (ny, nx; m) beside the heights."""
    data = iter(zip(x.ravel(), y.ravel(), heights.ravel(), strict=True))

    def absolute(main):
        axes, opening, numbers = main.partition(b"<MatrixDimension>")
        axes = re.sub(rb"<AxisType>I(.*?<Increment>)[^<]*", rb"<AxisType>A\g<1>1.0", axes, flags=re.DOTALL)
        points = (b";".join(str(float(value)).encode() for value in point) for point in data)
        return axes + opening + re.sub(rb"(?<=<Datum>)[^<]*", lambda _: next(points), numbers)

    return x3p(heights, storage=x3pio.DataStorage.XML, edit=absolute)


def test_x3p_with_stored_positions(read, tmp_path):
    heights = np.nan_to_num(HEIGHTS)
    x, y = np.meshgrid(1e-5 + DX * np.arange(4), DY * np.arange(3))
    for turned in (1, -1):  # rising and falling along both axes
        positions = (axis[::turned, ::turned] for axis in (x, y))
        height = read(stored_positions(*positions, heights[::turned, ::turned]))
        np.testing.assert_allclose(height.values, heights, rtol=1e-12)
        assert steps(height) == pytest.approx([DX, DY], rel=1e-9)
    uneven = {"not evenly spaced": 1e5 * x**2, "not lie on a rectangular grid": x + 0.2 * y}
    for words, along in uneven.items():
        path = saved(tmp_path, stored_positions(along, y, 0.1 * along))
        refuses(f"{words}.*resample = linear", path)
        plane = read_height_map(path, resample="linear")
        assert np.isfinite(plane).any()
        np.testing.assert_allclose((plane - 0.1 * plane.x).fillna(0), 0, atol=1e-15)


@pytest.mark.parametrize("file_format", list(sdfio.FileFormat))
@pytest.mark.parametrize("revision", [sdfio.Revision.ISO_1_0, sdfio.Revision.ISO_2_0, sdfio.Revision.BCR_1_0])
def test_sdf(refused, tmp_path, file_format, revision):
    path = tmp_path / "map.txt"
    metadata = sdfio.Metadata(revision=revision, manufacturer_id="maker", data_type=sdfio.DataType.INT32)
    sdfio.write(path, HEIGHTS, x_scale=DX, y_scale=DY, format=file_format, metadata=metadata)
    height = read_height_map(path)
    check(height, rtol=1e-6)
    assert json.loads(height.attrs["instrument"])["vendor"] == "maker"
    data = path.read_bytes()
    refused(data[: int(0.6 * len(data))], "not readable as SDF")
    refused(data + data, "a second SDF follows the first one")


def test_npy_needs_units(tmp_path):
    path = tmp_path / "map.npy"
    for array in (HEIGHTS, np.asfortranarray(HEIGHTS)):
        np.save(path, array * 1e6)
        refuses("give dx, dy, unit", path)
        check(read_height_map(path, dx=2, dy=3, unit="um"))
        check(read_height_map(path, dx=2e-3, dy=3e-3, unit="mm", height_unit="micrometre"))
    np.save(path, np.arange(6, dtype=np.int16))
    assert read_height_map(path, dx=1, unit="nm").shape == (1, 6)


@pytest.mark.parametrize(
    ("array", "words"),
    [
        (np.ones((3, 3), complex), "values of type complex128"),
        (np.full((3, 3), "a"), "values of type <U1"),
        (np.ones((3, 3), bool), "values of type bool"),
        (np.ones((2, 3, 3)), r"an array of shape \(2, 3, 3\)"),
        (np.ones((0, 3)), r"an array of shape \(0, 3\)"),
        (np.column_stack([*map(np.ravel, np.indices((3, 4))), np.ones(12)]), "points, not heights; save"),
        (np.vstack([np.arange(9), np.random.default_rng(1).normal(size=9)]), "points, not heights; save"),
    ],
)
def test_npy_of_other_things(tmp_path, array, words):
    path = tmp_path / "map.npy"
    np.save(path, array)
    refuses(words, path, **GIVEN)


def test_positions_in_an_array_are_said(tmp_path):
    heights = np.random.default_rng(2).normal(size=(9, 12))
    for array, said in ((np.vstack([np.arange(12) / 2, heights]), True), (heights, False)):
        np.save(tmp_path / "map.npy", array)
        height = read_height_map(tmp_path / "map.npy", **GIVEN)
        assert ("the first row (0, 0.5, 1 ...) may be positions" in height.attrs["ingest_warnings"]) == said


def test_npy_never_unpickles(tmp_path):
    marker = tmp_path / "ran"

    class Payload:
        def __reduce__(self):
            return (marker.write_text, ("",))

    path = tmp_path / "map.npy"
    np.save(path, np.array([[Payload()]], dtype=object), allow_pickle=True)
    refuses("not readable as a NumPy array", path, **GIVEN)
    assert not marker.exists()


def test_npy_cut_off_or_claiming_too_much(refused, tmp_path):
    path = tmp_path / "map.npy"
    np.save(path, np.ones((50, 50)))
    data = path.read_bytes()
    refused(data[: len(data) // 2], "NumPy", **GIVEN)
    refused(data.replace(b"(50, 50)", b"(90000, 90000)"), "NumPy", **GIVEN)
    np.save(path, np.full((3, 3), np.nan))
    refuses("all 9 points", path, error=HeightMapError, **GIVEN)


def test_own_netcdf_comes_back_as_it_was(read, tmp_path):
    first = read(x3p_bytes())
    write_dataset(first, tmp_path / "height.nc")
    again = read_height_map(tmp_path / "height.nc")
    np.testing.assert_array_equal(again.values, first.values)
    np.testing.assert_allclose(again.x, first.x, rtol=1e-12)
    np.testing.assert_allclose(again.y, first.y, rtol=1e-12)


def foreign(values=HEIGHTS * 1e9, dims=("y", "x"), units="nm", x=None, y=None, lateral="mm"):
    x = 1e3 * DX * (0.5 + np.arange(4)) if x is None else x
    y = 1e3 * DY * (0.5 + np.arange(3)) if y is None else y
    attrs = {"units": lateral} if lateral else {}
    return xr.Dataset(
        {"topo": (dims, values, {"units": units} if units else {})},
        coords={"x": ("x", x, attrs), "y": ("y", y, attrs)},
    )


@pytest.mark.parametrize("netcdf", ["NETCDF4", "NETCDF3_64BIT"])
def test_foreign_netcdf_in_its_own_units_and_directions(tmp_path, netcdf):
    path = tmp_path / "map.dat"
    foreign().to_netcdf(path, format=netcdf)
    check(read_height_map(path))
    foreign(dims=("x", "y"), values=HEIGHTS.T * 1e9).to_netcdf(path, format=netcdf)
    check(read_height_map(path))
    upside_down = foreign(values=HEIGHTS[::-1] * 1e9, y=1e3 * DY * (2.5 - np.arange(3)))
    upside_down.to_netcdf(path, format=netcdf)
    check(read_height_map(path))


def test_foreign_netcdf_with_two_spellings_of_one_unit(tmp_path):
    path = tmp_path / "map.nc"
    axes = foreign()
    axes["y"].attrs["units"] = "millimeter"
    axes.to_netcdf(path)
    check(read_height_map(path))
    axes["y"].attrs["units"] = "um"
    axes.to_netcdf(path)
    refuses("axes x and y have different units", path)


@pytest.mark.parametrize(
    ("kind", "limits", "packing"),
    [
        ("f8", {"valid_min": -1e4}, {}),
        ("f8", {"valid_range": np.array([-1e4, 1e4])}, {}),
        ("i2", {"valid_range": np.array([-300, 400], "i2")}, {"scale_factor": 0.25, "add_offset": 100.0}),
        ("i2", {"valid_min": -1e3, "valid_max": 200.0}, {"scale_factor": 0.25, "add_offset": 100.0}),
    ],
)
def test_values_outside_their_valid_range_are_missing(tmp_path, kind, limits, packing):
    path = tmp_path / "map.nc"
    stored = np.array([[-300, 7, 400], [-30000, 401 if kind == "i2" else 8, -299]], kind)
    with netCDF4.Dataset(path, "w") as file:
        for axis, size in (("y", 2), ("x", 3)):
            file.createDimension(axis, size)
            file.createVariable(axis, "f8", (axis,))[:] = np.arange(size)
            file[axis].units = "um"
        variable = file.createVariable("z", kind, ("y", "x"))
        variable.setncatts({"units": "nm"} | limits | packing)
        variable.set_auto_maskandscale(False)
        variable[:] = stored
    expected = stored * packing.get("scale_factor", 1.0) + packing.get("add_offset", 0.0)
    expected[1, 0] = np.nan
    expected[1, 1] = np.nan if kind == "i2" else 8.0
    np.testing.assert_allclose(read_height_map(path).values, 1e-9 * expected, rtol=1e-12)
    with netCDF4.Dataset(path, "a") as file:
        file["z"].setncattr("valid_range", "5 to 9")
    refuses("the valid_range, valid_min or valid_max of 'z' is no number", path)


def gsf_bytes(**changed):
    return gsf(HEIGHTS, **({"XReal": 4 * DX, "YReal": 3 * DY, "Title": "T"} | changed))


@pytest.mark.parametrize("title", ["T", "Ti", "Tit", "Titl"])
def test_gwyddion_simple_field(read, title):
    height = read(gsf_bytes(Title=title))
    check(height, first_row="top", rtol=1e-7)
    assert height.attrs["channel"] == title


def test_gwyddion_simple_field_that_leaves_things_out(refused):
    refused(gsf_bytes(ZUnits=None), "give height_unit")
    refused(gsf_bytes(XReal=None, YReal=None, XYUnits=None), "give dx, dy, unit")
    refused(gsf_bytes(ZUnits="V"), "values in V")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (gsf_bytes()[:-5], "cut off"),
        (gsf_bytes() + b"1234", "changed"),
        (gsf_bytes(XRes=5), "header needs"),
        (gsf_bytes(XRes=None), "no size in its header"),
        (gsf_bytes(YRes="many"), "no size in its header"),
        (gsf_bytes(YRes=-3), "damaged"),
        (gsf_bytes(YReal="nan"), "damaged"),
        (gsf_bytes(XRes=10**9, YRes=10**9), "points"),
        (gsf_bytes()[:40], "size in its header|damaged"),
    ],
)
def test_gwyddion_simple_field_that_is_damaged(refused, data, said):
    refused(data, said)


def test_numbers_by_peak_of_the_load_are_no_profiles(tmp_path):
    maps = xr.DataArray(np.stack([HEIGHTS, 2 * HEIGHTS]), dims=("peak", "y", "x"), attrs={"units": "m"})
    numbers = xr.DataArray([1e8, 2e8], dims="peak", attrs={"units": "Pa"})
    xr.Dataset({"residual_height": maps, "peak_pressure": numbers}).to_netcdf(tmp_path / "residual.nc")
    listed = inspect_file(tmp_path / "residual.nc")["channels"]
    assert [channel["name"] for channel in listed] == ["residual_height[peak=0]", "residual_height[peak=1]"]


def test_foreign_netcdf_without_units(tmp_path):
    path = tmp_path / "map.nc"
    foreign(lateral=None).to_netcdf(path)
    refuses("does not say its lateral unit", path)
    check(read_height_map(path, unit="mm"))
    foreign(units=None).to_netcdf(path)
    refuses("give height_unit", path)
    check(read_height_map(path, height_unit="nm"))
    foreign(units="K").to_netcdf(path)
    refuses("values in K", path)
    foreign(x=[1, 2, 3.4, 4]).to_netcdf(path)
    refuses("positions along x are not evenly spaced", path)


@pytest.mark.parametrize("dims", [("point",), ("row", "line")])
def test_netcdf_with_positions_that_are_no_coordinates(tmp_path, dims):
    shape = (-1, 4)[: len(dims)]
    variables = zip("yxz", (*np.indices((3, 4)), np.ones((3, 4))), strict=True)
    dataset = xr.Dataset({name: (dims, values.reshape(shape)) for name, values in variables})
    dataset.to_netcdf(tmp_path / "map.nc")
    refuses("the positions x and y of 'z' are variables over its axes", tmp_path / "map.nc", **GIVEN)


def test_inspect_names_channels_and_suspicions(tmp_path):
    found = inspect_file(saved(tmp_path, x3p_bytes()))
    assert found["format"] == "X3P (ISO 25178-72)"
    assert found["problem"] is None
    assert found["channels"][0]["missing_points"] == 1
    assert found["channels"][0]["rms_height"] == pytest.approx(np.nanstd(HEIGHTS), rel=1e-9)
    assert any("pixels are not square" in warning for warning in found["warnings"])
