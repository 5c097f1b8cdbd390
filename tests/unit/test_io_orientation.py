"""Every map is right-handed, whatever the file: an F, written in every format that can be, reads as an F.

The picture of the surface is F, its first row the upper one. A file of a format that begins at the top of the
picture holds F as it is, one that begins at the bottom holds F[::-1]. Formats that only their instruments
write are compared with other readers in test_io_shared.py.
"""

import measured_files as made
import numpy as np
import pytest
import xarray as xr
from measured_files import cells, holds, points, warnings_of

from roughcontact import SettingsError, inspect_file, read_height_map, write_dataset

LETTER = np.array([[1, 1, 1, 1], [1, 0, 0, 0], [1, 1, 1, 0], [1, 0, 0, 0], [1, 0, 0, 0]], dtype=float)
F = (LETTER + 0.01 * np.arange(20).reshape(5, 4)) * 1e-6  # m; every point tells where it is
DOWN = F[::-1]  # a file that begins at the bottom of the picture
DX, DY = 2e-6, 3e-6
STEPS = {"dx": 2.0, "dy": 3.0, "unit": "um", "height_unit": "m"}


def xyz(order):
    return "x (um)\ty (um)\tz (um)\n" + cells(points(1e6 * DOWN, 2, 3)[order], form="{}")


def lines(rows, header=""):
    return header + cells(rows, form="{:.9e}")


def beside_positions(rows, y, x):
    """A matrix with its positions in the first row and column, and nothing in the corner."""
    return "\t" + cells([x]) + cells(np.column_stack([y, 1e6 * rows]), form="{}")


def netcdf(rows, y=None):
    metres = {"units": "m"}
    coords = {} if y is None else {"y": ("y", y, metres), "x": ("x", DX * np.arange(4), metres)}
    dataset = xr.Dataset({"height": (("y", "x"), rows, metres)}, coords=coords)
    return bytes(dataset.to_netcdf(engine="scipy"))


def northwest(main):
    return main.replace(b"</Record1>", b"</Record1><Record2><Origin>NW</Origin></Record2>", 1)


def backwards(main):
    """Make the increment along y negative."""
    head, cy, tail = main.partition(b"<CY>")
    return head + cy + tail.replace(b"<Increment>", b"<Increment>-", 1)


GWYDDION_TEXT = "# Channel: F\n# Width: 8 µm\n# Height: 15 µm\n# Value units: m\n"
ARC_INFO = "ncols 4\nnrows 5\nxllcorner 0\nyllcorner 0\ncellsize 2\n"
X, Y, UM = 2.0 * np.arange(4), 3.0 * np.arange(5), {"unit": "um"}
COUNTS = np.rint(F * 1e12).astype(np.int32)  # pm
FRAME = {"ilength": 4, "jlength": 5, "ulength": 4 * DX, "vlength": 5 * DY}

# what the file is: its bytes, what must be given, where its first row lies, whether that is only assumed
FILES = {
    "list of points": (xyz(np.arange(20)), {}, "bottom", False),
    "list of points, shuffled": (xyz(np.random.default_rng(0).permutation(20)), {}, "bottom", False),
    "text of Gwyddion": (lines(F, GWYDDION_TEXT), {}, "top", False),
    "grid of Arc/Info": (lines(F, ARC_INFO), {"unit": "um", "height_unit": "m"}, "top", False),
    "numbers without a header": (lines(F), STEPS, "top", True),
    "numbers, said to begin at the bottom": (lines(DOWN), STEPS | {"first_row": "bottom"}, "bottom", False),
    "matrix beside rising positions": (beside_positions(DOWN, Y, X), UM, "bottom", False),
    "matrix beside falling positions": (beside_positions(F[:, ::-1], Y[::-1], X[::-1]), UM, "bottom", False),
    "NumPy": (made.array(DOWN), STEPS, "bottom", True),
    "NumPy, said to begin at the top": (made.array(F), STEPS | {"first_row": "top"}, "top", False),
    "MATLAB": (made.matlab({"z": DOWN}), STEPS, "bottom", True),
    "MATLAB, said to begin at the top": (made.matlab({"z": F}), STEPS | {"first_row": "top"}, "top", False),
    "netCDF, y rises": (netcdf(DOWN, DY * np.arange(5)), {}, "bottom", False),
    "netCDF, y falls": (netcdf(F, DY * np.arange(5)[::-1]), {}, "bottom", False),
    "netCDF without positions": (netcdf(DOWN), STEPS, "bottom", True),
    "X3P": (made.x3p(DOWN, DX, DY), {}, "bottom", False),
    "X3P, origin at the upper left": (made.x3p(F, DX, DY, edit=northwest), {}, "top", False),
    "X3P, negative increment": (made.x3p(F, DX, DY, edit=backwards), {}, "bottom", False),
    "X3P, both": (made.x3p(F, DX, DY, edit=lambda main: northwest(backwards(main))), {}, "bottom", False),
    "SDF": (made.sdf(DOWN * 1e12, DX, DY, 1e-12), {}, "bottom", False),
    # its reader turns the rows
    "SDF of the BCR": (made.sdf(F * 1e12, DX, DY, 1e-12, "aBCR-1.0"), {}, "bottom", False),
    "Gwyddion Simple Field": (made.gsf(F, XReal=8e-6, YReal=15e-6), {}, "top", False),
    "Gwyddion": (made.gwy({"Height": (F, "m")}, (8e-6, 15e-6)), {}, "top", False),
    "TrueMap": (made.tmd(1e3 * F, (8e-3, 15e-3)), {}, "top", False),
    "Keyence": (made.keyence(COUNTS, 2_000_000, 3_000_000, 1), {}, "top", False),
    "JPK in HDF5": (made.jpk(COUNTS[::-1].reshape(-1, 1), **FRAME), {}, "bottom", False),
}


@pytest.mark.parametrize("kind", FILES)
def test_an_f_reads_as_an_f(read, tmp_path, kind):
    data, options, first_row, assumed = FILES[kind]
    height = read(data, **options)
    # drawn with y upwards, as the report draws it, the picture is the F that was meant
    np.testing.assert_allclose(height.values[::-1], F, rtol=1e-5, atol=1e-12)
    assert np.all(np.diff(height.y) > 0)
    assert np.all(np.diff(height.x) > 0)
    assert (height.attrs["first_row"], height.attrs["first_row_assumed"]) == (first_row, assumed)
    contents = inspect_file(tmp_path / "map.dat", **options)
    assert (contents["first_row"], contents["first_row_assumed"]) == (first_row, assumed)
    # and what was written comes back upright
    write_dataset(height, tmp_path / "height.nc")
    reread = read_height_map(tmp_path / "height.nc")
    np.testing.assert_array_equal(reread.values, height.values)
    assert reread.attrs["first_row"] == "bottom"  # of that file


def test_the_user_wins_over_the_file_with_a_warning(read, refusal):
    height = read(made.x3p(F, DX, DY), first_row="top")
    holds(height, DOWN, DX, DY, rtol=1e-9)
    assert "first_row = top is given, the file has its first row at the bottom" in warnings_of(height)
    refusal(made.x3p(F, DX, DY), "first_row = 'upper'", error=SettingsError, first_row="upper")


def test_a_profile_has_no_up_and_down(read):
    height = read(made.array(F[0]), dx=1.0, unit="um", height_unit="m", first_row="top")
    np.testing.assert_array_equal(height.values[0], F[0])
    assert not height.attrs["first_row_assumed"]
