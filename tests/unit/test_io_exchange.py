"""X3P, SDF, NumPy and netCDF files: written by other libraries here, read back by the project."""

import hashlib
import json
import re

import numpy as np
import pytest
import sdfio
import x3pio
import xarray as xr
from measured_files import GIVEN, archive, array, gsf, holds, labelled, members, refuses, warnings_of, x3p

from roughcontact import HeightMapError, InputFileError, inspect_file, read_height_map, write_dataset

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


def gsf_bytes(**changed):
    return gsf(HEIGHTS, **({"XReal": 4 * DX, "YReal": 3 * DY, "Title": "T"} | changed))


def infinite(main):
    assert b"<Datum />" in main or b"<Datum/>" in main
    return re.sub(rb"<Datum ?/>", b"<Datum>INF</Datum>", main)


def renamed(main):
    """Call the root element ISO5436, as some tools do."""
    return main.replace(b"ISO5436_2", b"ISO5436")


@pytest.mark.parametrize(
    ("options", "rtol"),
    [
        ({}, 1e-12),
        ({"storage": x3pio.DataStorage.XML}, 1e-12),
        ({"z_type": x3pio.DataType.INT32}, 1e-6),
        ({"z_type": x3pio.DataType.FLOAT32}, 1e-6),
        ({"folder": "one/"}, 1e-12),  # of the archive
        ({"folder": "one/two/"}, 1e-12),
        ({"edit": renamed}, 1e-12),
        ({"edit": infinite, "storage": x3pio.DataStorage.XML}, 1e-12),
    ],
)
def test_x3p(read, options, rtol):
    data = x3p_bytes(**options)
    height = read(data)
    check(height, rtol=rtol)
    assert height.attrs["source_sha256"] == hashlib.sha256(data).hexdigest()
    assert height.attrs["source_file"] == "map.dat"


@pytest.mark.parametrize("encoding", [b"UTF-1.0", b"hex", b"rot13"])
def test_x3p_of_an_unknown_encoding_or_of_one_that_is_no_text_is_refused(refusal, tmp_path, encoding):
    def encoded(main):
        return b'<?xml version="1.0" encoding="' + encoding + b'"?>' + main.partition(b"?>")[2]

    refusal(x3p_bytes(edit=encoded), words := r"map\.dat: not readable as X3P .*encoding")
    with pytest.raises(InputFileError, match=words):
        inspect_file(tmp_path / "map.dat")


def test_x3p_whose_numbers_were_changed_is_refused(refusal):
    content = members(x3p_bytes())
    (name,) = (member_name for member_name in content if member_name.endswith("data.bin"))
    refusal(archive(content | {name: content[name][:-1] + b"\0"}), "not readable as X3P")


def test_x3p_layers_profile_and_points(read, refusal, tmp_path):
    data = x3p(np.stack([HEIGHTS, 2 * HEIGHTS]), DX, DY)
    assert read(data).attrs["channel"] == "layer 1"
    holds(read(data, channel="layer 2"), 2 * HEIGHTS, DX, DY)
    refusal(data, r"no channel is named 'layer 3'; the file has 'layer 1', 'layer 2'", channel="layer 3")
    holds(read(x3p(HEIGHTS[0], DX)), HEIGHTS[:1], DX)
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


def test_x3p_with_stored_positions(read, refusal):
    heights = np.nan_to_num(HEIGHTS)
    x, y = np.meshgrid(1e-5 + DX * np.arange(4), DY * np.arange(3))
    for turned in (1, -1):  # rising and falling along both axes
        positions = (axis[::turned, ::turned] for axis in (x, y))
        holds(read(stored_positions(*positions, heights[::turned, ::turned])), heights, DX, DY)
    uneven = {"not evenly spaced": 1e5 * x**2, "not lie on a rectangular grid": x + 0.2 * y}
    for words, along in uneven.items():
        data = stored_positions(along, y, 0.1 * along)
        refusal(data, f"{words}.*resample = linear")
        plane = read(data, resample="linear")
        assert np.isfinite(plane).any()
        np.testing.assert_allclose((plane - 0.1 * plane.x).fillna(0), 0, atol=1e-15)


@pytest.mark.parametrize("file_format", list(sdfio.FileFormat))
@pytest.mark.parametrize("revision", [sdfio.Revision.ISO_1_0, sdfio.Revision.ISO_2_0, sdfio.Revision.BCR_1_0])
def test_sdf(refusal, tmp_path, file_format, revision):
    path = tmp_path / "map.txt"
    metadata = sdfio.Metadata(revision=revision, manufacturer_id="maker", data_type=sdfio.DataType.INT32)
    sdfio.write(path, HEIGHTS, x_scale=DX, y_scale=DY, format=file_format, metadata=metadata)
    height = read_height_map(path)
    check(height, rtol=1e-6)
    assert json.loads(height.attrs["instrument"])["vendor"] == "maker"
    data = path.read_bytes()
    refusal(data[: int(0.6 * len(data))], "not readable as SDF")
    refusal(data + data, "a second SDF follows the first one")


@pytest.mark.parametrize("order", "CF")
def test_npy_needs_units(read, refusal, order):
    data = array(np.array(1e6 * HEIGHTS, order=order))
    refusal(data, "give dx, dy, unit")
    check(read(data, dx=2, dy=3, unit="um"))
    check(read(data, dx=2e-3, dy=3e-3, unit="mm", height_unit="micrometre"))


def test_npy_of_a_profile_in_whole_numbers(read):
    holds(read(array(np.arange(6, dtype=np.int16)), dx=1, unit="nm"), 1e-9 * np.arange(6.0)[None], 1e-9)


ONES, POINTS = array(np.ones((50, 50))), np.column_stack([*map(np.ravel, np.indices((3, 4))), np.ones(12)])
TRACE = np.vstack([np.arange(9), np.random.default_rng(1).normal(size=9)])
# a file, words of its refusal, what is given
REFUSED = [
    # X3P, whose checksum counts whatever the root element
    (x3p_bytes(edit=renamed, restate=False), "map.dat: The MD5 checksum of main.xml does not match", {}),
    # NumPy
    (array(np.ones((3, 3), complex)), "values of type complex128", GIVEN),
    (array(np.full((3, 3), "a")), "values of type <U1", GIVEN),
    (array(np.ones((3, 3), bool)), "values of type bool", GIVEN),
    (array(np.ones((2, 3, 3))), r"an array of shape \(2, 3, 3\)", GIVEN),
    (array(np.ones((0, 3))), r"an array of shape \(0, 3\)", GIVEN),
    (array(POINTS), "points, not heights; save", GIVEN),
    (array(TRACE), "points, not heights; save", GIVEN),
    (array(np.full((3, 3), np.nan)), "all 9 points", GIVEN | {"error": HeightMapError}),
    (ONES[: len(ONES) // 2], "NumPy", GIVEN),
    (ONES.replace(b"(50, 50)", b"(90000, 90000)"), "NumPy", GIVEN),
    # Gwyddion Simple Field
    (gsf_bytes(ZUnits=None), "give height_unit", {}),
    (gsf_bytes(XReal=None, YReal=None, XYUnits=None), "give dx, dy, unit", {}),
    (gsf_bytes(ZUnits="V"), "values in V", {}),
    (gsf_bytes()[:-5], "cut off", {}),
    (gsf_bytes() + b"1234", "changed", {}),
    (gsf_bytes(XRes=5), "header needs", {}),
    (gsf_bytes(XRes=None), "no size in its header", {}),
    (gsf_bytes(YRes="many"), "no size in its header", {}),
    (gsf_bytes(YRes=-3), "its header is damaged", {}),
    (gsf_bytes(YReal="nan"), "its header is damaged", {}),
    (gsf_bytes(XRes=10**9, YRes=10**9), "points", {}),
    (gsf_bytes()[:40], "size in its header|damaged", {}),
]


@pytest.mark.parametrize(("data", "words", "options"), REFUSED, ids=[words for _, words, _ in REFUSED])
def test_what_is_damaged_incomplete_or_no_map_is_refused(refusal, data, words, options):
    refusal(data, words, **options)


def test_positions_in_an_array_are_said(read):
    heights = np.random.default_rng(2).normal(size=(9, 12))
    message = "the first row (0, 0.5, 1 ...) may be positions"
    assert message in warnings_of(read(array(np.vstack([np.arange(12) / 2, heights])), **GIVEN))
    assert message not in warnings_of(read(array(heights), **GIVEN))


def test_npy_never_unpickles(refusal, tmp_path):
    marker = tmp_path / "ran"

    class Payload:
        def __reduce__(self):
            return (marker.write_text, ("",))

    refusal(array(np.array([[Payload()]], dtype=object)), "not readable as a NumPy array", **GIVEN)
    assert not marker.exists()


def test_own_netcdf_comes_back_as_it_was(read, tmp_path):
    original = read(x3p_bytes())
    write_dataset(original, tmp_path / "height.nc")
    check(reread := read_height_map(tmp_path / "height.nc"))
    np.testing.assert_array_equal(reread.values, original.values)


def foreign(
    path, heights=HEIGHTS, *, dims=("y", "x"), units=("mm", "mm", "nm"), netcdf="NETCDF4", **positions
):
    """Write a map of another program in netCDF: its heights in nm, its positions in mm."""
    x, y, z = ({"units": unit} if unit else {} for unit in units)
    coordinates = {"x": 1e3 * DX * (0.5 + np.arange(4)), "y": 1e3 * DY * (0.5 + np.arange(3))} | positions
    axes = {"x": ("x", coordinates["x"], x), "y": ("y", coordinates["y"], y)}
    xr.Dataset({"topo": (dims, 1e9 * heights, z)}, axes).to_netcdf(path, format=netcdf)
    return path


@pytest.mark.parametrize("netcdf", ["NETCDF4", "NETCDF3_64BIT"])
def test_foreign_netcdf_in_its_own_units_and_directions(tmp_path, netcdf):
    path = tmp_path / "map.dat"
    check(read_height_map(foreign(path, netcdf=netcdf)))
    check(read_height_map(foreign(path, HEIGHTS.T, dims=("x", "y"), netcdf=netcdf)))
    falling = 1e3 * DY * (2.5 - np.arange(3))
    check(read_height_map(foreign(path, HEIGHTS[::-1], y=falling, netcdf=netcdf)))


def test_foreign_netcdf_with_other_units_or_none(tmp_path):
    path = tmp_path / "map.nc"
    check(read_height_map(foreign(path, units=("mm", "millimeter", "nm"))))
    refuses("axes x and y have different units", foreign(path, units=("mm", "um", "nm")))
    refuses("does not say its lateral unit", foreign(path, units=("", "", "nm")))
    check(read_height_map(path, unit="mm"))
    refuses("give height_unit", foreign(path, units=("mm", "mm", "")))
    check(read_height_map(path, height_unit="nm"))
    refuses("values in K", foreign(path, units=("mm", "mm", "K")))
    refuses("positions along x are not evenly spaced", foreign(path, x=[1, 2, 3.4, 4]))


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
    labelled(stored, "nm", "z", **limits, **packing).to_netcdf(path)
    expected = stored * packing.get("scale_factor", 1.0) + packing.get("add_offset", 0.0)
    expected[1, 0] = np.nan
    expected[1, 1] = np.nan if kind == "i2" else 8.0
    holds(read_height_map(path), 1e-9 * expected, rtol=1e-12)
    labelled(stored, "nm", "z", valid_range="5 to 9").to_netcdf(path)
    refuses("the valid_range, valid_min or valid_max of 'z' is no number", path)


@pytest.mark.parametrize("title", ["T", "Ti", "Tit", "Titl"])  # bytes of padding
def test_gwyddion_simple_field(read, title):
    height = read(gsf_bytes(Title=title))
    check(height, first_row="top", rtol=1e-7)
    assert height.attrs["channel"] == title


def test_numbers_by_peak_of_the_load_are_no_profiles(tmp_path):
    maps = ("peak", "y", "x"), np.stack([HEIGHTS, 2 * HEIGHTS]), {"units": "m"}
    numbers = "peak", [1e8, 2e8], {"units": "Pa"}
    xr.Dataset({"residual_height": maps, "peak_pressure": numbers}).to_netcdf(tmp_path / "residual.nc")
    listed = inspect_file(tmp_path / "residual.nc")["channels"]
    assert [channel["name"] for channel in listed] == ["residual_height[peak=0]", "residual_height[peak=1]"]


@pytest.mark.parametrize("dims", [("point",), ("row", "line")])
def test_netcdf_with_positions_that_are_no_coordinates(tmp_path, dims):
    shape = (-1, 4)[: len(dims)]
    variables = zip("yxz", (*np.indices((3, 4)), np.ones((3, 4))), strict=True)
    dataset = xr.Dataset({name: (dims, values.reshape(shape)) for name, values in variables})
    dataset.to_netcdf(tmp_path / "map.nc")
    refuses("the positions x and y of 'z' are variables over its axes", tmp_path / "map.nc", **GIVEN)


def test_inspect_names_channels_and_suspicions(read, tmp_path):
    read(x3p_bytes())
    contents = inspect_file(tmp_path / "map.dat")
    assert contents["format"] == "X3P (ISO 25178-72)"
    assert contents["problem"] is None
    assert contents["channels"][0]["missing_points"] == 1
    assert contents["channels"][0]["rms_height"] == pytest.approx(np.nanstd(HEIGHTS), rel=1e-9)
    assert any("pixels are not square" in warning for warning in contents["warnings"])
