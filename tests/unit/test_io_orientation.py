"""Every map is right-handed, whatever the file: an F, written in every format that can be, reads as an F.

The picture of the surface is F, its first row the upper one. A file of a format that begins at the top of the
picture holds F as it is, one that begins at the bottom holds F[::-1]. Formats that only their instruments
write are compared with other readers in test_io_shared.py.
"""

import io

import numpy as np
import pytest
import scipy.io
import xarray as xr
from measured_files import array, gsf, gwy, jpk, keyence, refuses, tmd, x3p

from roughcontact.errors import SettingsError
from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map
from roughcontact.results.storage import write_dataset

LETTER = np.array([[1, 1, 1, 1], [1, 0, 0, 0], [1, 1, 1, 0], [1, 0, 0, 0], [1, 0, 0, 0]], dtype=float)
F = (LETTER + 0.01 * np.arange(20).reshape(5, 4)) * 1e-6  # m; every point tells where it is
DX, DY = 2e-6, 3e-6
STEPS = {"dx": 2.0, "dy": 3.0, "unit": "um", "height_unit": "m"}


def points(order):
    y, x = np.indices(F.shape)
    table = np.column_stack([2.0 * x.ravel(), 3.0 * (4 - y).ravel(), 1e6 * F.ravel()])[order]
    return (
        "x (um)\ty (um)\tz (um)\n" + "".join("\t".join(map(repr, map(float, row))) + "\n" for row in table)
    ).encode()


def lines(rows, header=""):
    return (header + "".join("\t".join(f"{value:.9e}" for value in row) + "\n" for row in rows)).encode()


def beside_positions(rows, y, x):
    """A matrix with its positions in the first row and column, and nothing in the corner."""
    head = "\t" + "\t".join(map(str, x)) + "\n"
    return (
        head
        + "".join(
            f"{at}\t" + "\t".join(map(repr, map(float, row))) + "\n" for at, row in zip(y, rows, strict=True)
        )
    ).encode()


def mat(rows):
    stream = io.BytesIO()
    scipy.io.savemat(stream, {"z": rows})
    return stream.getvalue()


def netcdf(rows, y=None):
    metres = {"units": "m"}
    coords = {} if y is None else {"y": ("y", y, metres), "x": ("x", DX * np.arange(4), metres)}
    dataset = xr.Dataset({"height": (("y", "x"), rows, metres)}, coords=coords)
    return bytes(dataset.to_netcdf(engine="scipy"))


def northwest(main):
    return main.replace(b"</Record1>", b"</Record1><Record2><Origin>NW</Origin></Record2>", 1)


def backwards(main):
    """Make the increment along y negative."""
    before, cy, after = main.partition(b"<CY>")
    return before + cy + after.replace(b"<Increment>", b"<Increment>-", 1)


def sdf(rows, mark="aISO-1.0"):
    """ISO 25178-71 in ASCII, by its published description."""
    header = {
        "ManufacID": "maker",
        "CreateDate": "010120200000",
        "ModDate": "010120200000",
        "NumPoints": 4,
        "NumProfiles": 5,
        "Xscale": DX,
        "Yscale": DY,
        "Zscale": 1e-12,
        "Zresolution": -1,
        "Compression": 0,
        "DataType": 6,
        "CheckType": 0,
    }
    text = mark + "\n" + "".join(f"{key} = {value}\n" for key, value in header.items()) + "*\n"
    return (
        text + "".join(" ".join(str(round(value * 1e12)) for value in row) + "\n" for row in rows) + "*\n"
    ).encode()


GWYDDION_TEXT = "# Channel: F\n# Width: 8 µm\n# Height: 15 µm\n# Value units: m\n"
ARC_INFO = "ncols 4\nnrows 5\nxllcorner 0\nyllcorner 0\ncellsize 2\n"
DOWN = F[::-1]  # a file that begins at the bottom of the picture
UPWARDS, DOWNWARDS = 3.0 * np.arange(5), 3.0 * np.arange(5)[::-1]
ACROSS = 2.0 * np.arange(4)
COUNTS = np.rint(F * 1e12).astype(np.int32)  # pm

# what the file is: its bytes, what must be given, where its first row lies, whether that is only assumed
FILES = {
    "list of points": (points(np.arange(20)), {}, "bottom", False),
    "list of points, shuffled": (points(np.random.default_rng(0).permutation(20)), {}, "bottom", False),
    "text of Gwyddion": (lines(F, GWYDDION_TEXT), {}, "top", False),
    "grid of Arc/Info": (lines(F, ARC_INFO), {"unit": "um", "height_unit": "m"}, "top", False),
    "numbers without a header": (lines(F), STEPS, "top", True),
    "numbers, said to begin at the bottom": (lines(DOWN), STEPS | {"first_row": "bottom"}, "bottom", False),
    "matrix beside rising positions": (
        beside_positions(1e6 * DOWN, UPWARDS, ACROSS),
        {"unit": "um"},
        "bottom",
        False,
    ),
    "matrix beside falling positions": (
        beside_positions(1e6 * F[:, ::-1], DOWNWARDS, ACROSS[::-1]),
        {"unit": "um"},
        "bottom",
        False,
    ),
    "NumPy": (array(DOWN), STEPS, "bottom", True),
    "NumPy, said to begin at the top": (array(F), STEPS | {"first_row": "top"}, "top", False),
    "MATLAB": (mat(DOWN), STEPS, "bottom", True),
    "MATLAB, said to begin at the top": (mat(F), STEPS | {"first_row": "top"}, "top", False),
    "netCDF, y rises": (netcdf(DOWN, DY * np.arange(5)), {}, "bottom", False),
    "netCDF, y falls": (netcdf(F, DY * np.arange(5)[::-1]), {}, "bottom", False),
    "netCDF without positions": (netcdf(DOWN), STEPS, "bottom", True),
    "X3P": (x3p(DOWN, DX, DY), {}, "bottom", False),
    "X3P, origin at the upper left": (x3p(F, DX, DY, edit=northwest), {}, "top", False),
    "X3P, negative increment": (x3p(F, DX, DY, edit=backwards), {}, "bottom", False),
    "X3P, both": (x3p(F, DX, DY, edit=lambda main: northwest(backwards(main))), {}, "bottom", False),
    "SDF": (sdf(DOWN), {}, "bottom", False),
    "SDF of the BCR": (sdf(F, mark="aBCR-1.0"), {}, "bottom", False),  # its reader turns the rows
    "Gwyddion Simple Field": (gsf(F, XReal=8e-6, YReal=15e-6), {}, "top", False),
    "Gwyddion": (gwy({"Height": (F, "m")}, (8e-6, 15e-6)), {}, "top", False),
    "TrueMap": (tmd(1e3 * F, (8e-3, 15e-3)), {}, "top", False),
    "Keyence": (keyence(COUNTS, 2_000_000, 3_000_000, 1), {}, "top", False),
    "JPK in HDF5": (
        jpk(COUNTS[::-1].reshape(-1, 1), ilength=4, jlength=5, ulength=4 * DX, vlength=5 * DY),
        {},
        "bottom",
        False,
    ),
}


@pytest.mark.parametrize("kind", FILES)
def test_an_f_reads_as_an_f(tmp_path, kind):
    data, given, first_row, assumed = FILES[kind]
    path = tmp_path / "map.dat"
    path.write_bytes(data)
    height = read_height_map(path, **given)
    # drawn with y upwards, as the report draws it, the picture is the F that was meant
    np.testing.assert_allclose(height.values[::-1], F, rtol=1e-5, atol=1e-12)
    assert np.all(np.diff(height.y) > 0)
    assert np.all(np.diff(height.x) > 0)
    assert (height.attrs["first_row"], height.attrs["first_row_assumed"]) == (first_row, assumed)
    found = inspect_file(path, **given)
    assert (found["first_row"], found["first_row_assumed"]) == (first_row, assumed)


@pytest.mark.parametrize("kind", ["text of Gwyddion", "X3P"])
def test_a_map_that_was_written_comes_back_upright(tmp_path, kind):
    data, given, first_row, _ = FILES[kind]
    (tmp_path / "map.dat").write_bytes(data)
    height = read_height_map(tmp_path / "map.dat", **given)
    write_dataset(height, tmp_path / "height.nc")
    again = read_height_map(tmp_path / "height.nc")
    np.testing.assert_array_equal(again.values, height.values)
    assert again.attrs["first_row"] == "bottom"  # of that file
    assert height.attrs["first_row"] == first_row


def test_the_user_wins_over_the_file_with_a_warning(tmp_path):
    path = tmp_path / "map.x3p"
    path.write_bytes(x3p(F, DX, DY))
    height = read_height_map(path, first_row="top")
    np.testing.assert_allclose(height.values[::-1], F, rtol=1e-9)
    assert (
        "first_row = top is given, the file has its first row at the bottom"
        in height.attrs["ingest_warnings"]
    )
    refuses("first_row = 'upper'", path, error=SettingsError, first_row="upper")


def test_a_profile_has_no_up_and_down(tmp_path):
    path = tmp_path / "profile.npy"
    path.write_bytes(array(F[0]))
    height = read_height_map(path, dx=1.0, unit="um", height_unit="m", first_row="top")
    np.testing.assert_array_equal(height.values[0], F[0])
    assert not height.attrs["first_row_assumed"]
