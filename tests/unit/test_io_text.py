"""Text matrices, lists of points and profiles: written here in the variants that programs write."""

import json
import re

import numpy as np
import pytest
from measured_files import GIVEN, refuses, saved, steps, warnings_of

from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map

# no symmetry, so that a mirrored or transposed map is told from the right one
HEIGHTS = np.array([[1.5, -2.25, 3.0, 0.5], [4.0, 5.5, -6.75, 7.0], [0.25, 9.0, 10.5, -1.0]])


def matrix(heights=HEIGHTS, separator="\t", comma=False):
    text = "\n".join(separator.join(f"{value:g}" for value in row) for row in heights) + "\n"
    return text.replace(".", ",") if comma else text


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "utf-16", "utf-8-sig"])
def test_header_as_gwyddion_writes_it(read, encoding):
    header = "# Channel: Topo\n# Width: 4.00 µm\n# Height: 3,00 µm\n# Value units: nm\n"
    height = read(header + matrix(), encoding=encoding)
    np.testing.assert_allclose(height.values[::-1], HEIGHTS * 1e-9, rtol=1e-15)
    np.testing.assert_allclose(height.x, [0.5e-6, 1.5e-6, 2.5e-6, 3.5e-6], rtol=1e-12)
    np.testing.assert_allclose(height.y, [0.5e-6, 1.5e-6, 2.5e-6], rtol=1e-12)
    assert height.dims == ("y", "x")
    assert height.attrs["channel"] == "Topo"
    assert height.attrs["first_row"] == "top"
    assert height.attrs["missing_points"] == 0


def test_conversion_factor_and_counts_in_the_header(read):
    header = "h=3 w=4\npixel size=3.5e-007 m\ndata unit=rad\nheight conversion factor (-> m)=2.5e-008\n"
    height = read(header + matrix(separator=" "))
    np.testing.assert_allclose(height.values[::-1], HEIGHTS * 2.5e-8, rtol=1e-15)
    assert steps(height) == pytest.approx([3.5e-7, 3.5e-7], rel=1e-12)


def test_counts_with_their_value_in_nanometres(read):
    header = "# x-pixels = 4\n# y-pixels = 3\n# x-length = 2000\n# y-length = 1500\n# Bit2nm = 0.01\n"
    height = read(header + matrix(), unit="nm")
    np.testing.assert_allclose(height.values[::-1], HEIGHTS * 1e-11, rtol=1e-15)


def test_missing_points_become_nan_and_are_counted(read):
    text = "ncols 4\nnrows 2\ncellsize 2\nNODATA_value -9999\n1 2 -9999 4\nBAD 6 nan 8.5\n"
    height = read(text, unit="mm", height_unit="um")
    expected = np.array([[1, 2, np.nan, 4], [np.nan, 6, np.nan, 8.5]]) * 1e-6
    np.testing.assert_allclose(height.values[::-1], expected, rtol=1e-15)
    assert height.attrs["missing_points"] == 3
    assert height.attrs["missing_share"] == 0.375
    assert float(height.x[1] - height.x[0]) == pytest.approx(2e-3, rel=1e-12)


GAPS = (
    "NaN - --- *** **** ? #N/A #NV #DIV/0! #NAME? -1.#IND 1.#QNAN nan(ind) -Infinity <NA> \\N 1E+38 "
    "1.70141e+38 1.701410009e38 3.40282e38 9.91E+37 -9.90000000E+37 9.96920996838687e+36 "
    "-1.79769313486232e+308"
)


def test_a_gap_in_named_columns_without_positions_stays_where_it_is(read):
    rows = ["z1 (nm);z2 (nm)", "1;1", "2;NaN", "NaN;3", "4;5", ";7", ";9"]
    for name, profile in (("z1", [1, 2, np.nan, 4]), ("z2", [1, np.nan, 3, 5, 7, 9])):
        height = read("\n".join(rows), dx=1, unit="um", channel=name)
        np.testing.assert_allclose(height.values, [1e-9 * np.array(profile)])


@pytest.mark.parametrize("gap", GAPS.split())
@pytest.mark.parametrize("place", [0, 5])
def test_what_programs_write_for_a_missing_point(read, gap, place):
    heights = HEIGHTS.astype(object)
    heights.flat[place] = gap
    text = "\n".join("\t".join(map(str, row)) for row in heights)
    height = read(text, **GIVEN)
    expected = HEIGHTS * 1e-6
    expected.flat[place] = np.nan
    np.testing.assert_allclose(height.values[::-1], expected, rtol=1e-15)


def test_a_line_drawn_below_headings_is_no_row_of_the_map(read):
    text = "a      b      c     d\n------ ------ ----- -----\n" + matrix(separator=" ")
    assert read(text, **GIVEN).shape == HEIGHTS.shape


def test_exponents_of_fortran(read):
    text = "\n".join(" ".join(f"{v:.3E}".replace("E", "D") for v in row) for row in HEIGHTS)
    height = read(text, **GIVEN)
    np.testing.assert_allclose(height.values[::-1], HEIGHTS * 1e-6, rtol=1e-15)


def headed_points(heading):
    rows = [f"{i},{2 * j},{HEIGHTS[j, i]}" for j in range(3) for i in range(4)]
    return heading + "\n" + "\n".join(rows) + "\n"


def test_two_spellings_of_one_unit(read):
    height = read(headed_points("x (µm),y (micron),z (nm)"))
    np.testing.assert_allclose(height.values, HEIGHTS * 1e-9, rtol=1e-15)
    converted = read(headed_points("x (µm),y (mm),z (nm)"))
    np.testing.assert_allclose(converted.y, 1e3 * height.y, rtol=1e-12)
    np.testing.assert_allclose(converted.x, height.x, rtol=1e-12)


def test_a_column_of_depths_is_named(read):
    height = read(headed_points("x (µm),y (µm),Depth (nm)"))
    np.testing.assert_allclose(height.values, HEIGHTS * 1e-9, rtol=1e-15)
    assert re.search("'Depth'.*change their sign", warnings_of(height))
    height = read(headed_points("x (µm),y (µm),z (nm)"))
    assert "change their sign" not in warnings_of(height)


def test_points_with_a_fourth_column_are_no_map(read, tmp_path):
    rows = [f"{i} {j} {HEIGHTS[j, i]} {7 * i + j}" for j in range(3) for i in range(4)]
    path = saved(tmp_path, "\n".join(rows))
    refuses(r"begin anew at line 5.*name the columns", path, **GIVEN)
    height = read("x y z intensity\n" + "\n".join(rows), unit="um")
    np.testing.assert_allclose(height.values, HEIGHTS * 1e-6, rtol=1e-15)


def test_bare_numbers_are_refused_with_what_to_give(tmp_path):
    path = saved(tmp_path, matrix())
    refuses(r"map of 3 x 4 points that does not say its size; give dx, dy, unit", path)
    refuses("give dx, dy, unit", path, unit="um")
    refuses("give dx, dy, unit", path, dx=1, unit="um")
    refuses("dx = 1 is given without a unit", path, error=SettingsError, dx=1, dy=1)
    refuses(r"dx = -1 must be a positive number", path, error=SettingsError, dx=-1, dy=1, unit="um")
    refuses(
        r"unknown length unit 'milimeter'; did you mean 'millimeter'",
        path,
        error=SettingsError,
        dx=1,
        dy=1,
        unit="milimeter",
    )


def test_height_unit_of_the_file_stands_beside_the_unit_of_the_steps(tmp_path):
    path = saved(tmp_path, "\\Exported image units: nm\n" + matrix())
    height = read_height_map(path, **GIVEN)
    np.testing.assert_allclose(height.values[::-1], HEIGHTS * 1e-9, rtol=1e-15)
    assert "given by the user" not in warnings_of(height)


def test_arguments_win_over_the_file_and_say_so(tmp_path):
    header = "# Width: 4 µm\n# Height: 3 µm\n# Value units: nm\n"
    path = saved(tmp_path, header + matrix())
    height = read_height_map(path, dx=2, dy=1, unit="um", height_unit="pm")
    np.testing.assert_allclose(height.values[::-1], HEIGHTS * 1e-12, rtol=1e-15)
    assert float(height.x[1] - height.x[0]) == pytest.approx(2e-6, rel=1e-12)
    notes = warnings_of(height)
    assert "dx = 2e-06 m as given by the user, where the file says 1e-06 m" in notes
    assert "the heights are taken in pm as given by the user, where the file says nm" in notes
    assert "dy =" not in notes.replace("the pixels are not square: dx = 2e-06 m, dy = 1e-06 m", "")


def test_values_that_are_no_lengths_are_refused(tmp_path):
    path = saved(tmp_path, "# Width: 4 µm\n# Height: 3 µm\n# Value units: V\n" + matrix())
    refuses(r"no channel of this file holds heights .*values in V, no length", path)


def test_cut_matrices_are_refused(read, refused):
    rng = np.random.default_rng(3)
    square = rng.standard_normal((20, 20))
    text = "# Width: 20 µm\n# Height: 20 µm\n# Value units: nm\n" + matrix(square)
    whole = read(text)
    assert whole.shape == (20, 20)
    refused(text[: int(0.6 * len(text))], "the file was cut off")
    lines = text.splitlines(keepends=True)
    refused("".join(lines[: 3 + 12]), r"seems to be cut off\. If it is whole, give dx, dy and unit")
    kept = read("".join(lines[: 3 + 12]), **GIVEN)
    assert kept.shape == (12, 20)
    refused("ncols 4\nnrows 5\ncellsize 1\n" + matrix(separator=" "), "header says 5 rows, the file has 3")


def test_ragged_rows_and_words_name_the_line(refused):
    refused("1 2 3 4\n1 2 3\n1 2 3 4\n", "row 2 has 3 numbers where the others have 4")
    refused("1 2 3 4\n1 2 3 4\n1 2 x 4\n1 2 3 4\n", r"line 3 is no row of numbers \(x\); write NaN")


def test_ambiguous_comma_is_refused(read, refused):
    text = "1,5\n2,5\n3\n4,5\n"
    refused(text, "may be a decimal sign or a separator", dx=1, unit="um")
    assert read(text + "4,05\n", dx=1, unit="um").shape == (
        1,
        5,
    )  # no number is 05


def points(order="row", scale=1.0):
    rows, columns = HEIGHTS.shape
    indices = [(j, i) for j in range(rows) for i in range(columns)]
    if order == "column":
        indices.sort(key=lambda index: (index[1], index[0]))
    if order == "shuffled":
        indices = [indices[k] for k in np.random.default_rng(0).permutation(len(indices))]
    return [(scale * (2 + 0.5 * i), scale * (1 + 0.25 * j), HEIGHTS[j, i]) for j, i in indices]


def test_list_of_points_with_named_columns_and_a_hole(read):
    lines = ["X (mm);Y (mm);Z (µm)"] + [f"{x:g};{y:g};{z:g}" for x, y, z in points()]
    del lines[6]
    height = read("\n".join(lines).replace(".", ","))
    expected = HEIGHTS * 1e-6
    expected[1, 1] = np.nan
    np.testing.assert_allclose(height.values, expected, rtol=1e-15)
    assert height.attrs["missing_points"] == 1


def test_rounded_positions_are_even(read):
    x = np.round(np.arange(30) / 3, 3)
    text = "".join(f"{a:.3f},{b:.3f},{a * b + a:.4f}\n" for b in x for a in x)
    height = read(text, unit="um")
    assert height.shape == (30, 30)
    assert height.attrs["missing_points"] == 0
    assert float(height.x[1] - height.x[0]) == pytest.approx(1e-6 / 3, rel=1e-4)


def test_uneven_points_are_refused_with_a_way_out(refused):
    x = np.array([0.0, 1.0, 2.3, 3.0, 4.0])
    text = "".join(f"{a} {b} {a * b + 1}\n" for b in range(4) for a in x)
    refused(text, r"even.*resample = linear", unit="um")
    scattered = np.random.default_rng(1).random((50, 3))
    text = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in scattered)
    refused(text, r"even.*resample = linear", unit="um")
    doubled = "".join(f"{a} {b} 1.5\n" for b in (0, 1, 1) for a in range(4))
    refused(doubled, "several points of the list have the same position", unit="um")


@pytest.mark.parametrize("order", ["row", "column"])
def test_cut_list_of_points_is_refused(refused, order):
    text = "".join("{:g} {:g} {:g}\n".format(*point) for point in points(order)[:-1])
    refused(text, "ends in the middle of a grid line", unit="mm")


def test_profile_with_unit_in_the_column_name(refused, tmp_path):
    text = "X_(microns),y1\n" + "".join(
        f"{0.5 * i:.4f},{z}\n" for i, z in enumerate(HEIGHTS.ravel(), start=1)
    )
    path = saved(tmp_path, text)
    refuses("does not say the unit of its heights; give height_unit", path)
    height = read_height_map(path, height_unit="nm")
    assert height.shape == (1, 12)
    np.testing.assert_allclose(height.values[0], HEIGHTS.ravel() * 1e-9, rtol=1e-15)
    np.testing.assert_allclose(height.x, 0.5e-6 * np.arange(1, 13), rtol=1e-12)
    uneven = text.replace("2.5000,", "2.7000,")
    refused(uneven, "not evenly spaced", height_unit="nm")


def test_one_line_is_a_profile_and_one_number_no_map(read, refused):
    height = read("1.5 2.5 3.5 7\n", dx=1, unit="um")
    assert height.shape == (1, 4)
    refused("1.5\n", "single point", error=HeightMapError, **GIVEN)
    refused(
        "nan nan nan\nnan nan nan\n", "all 6 points of the map are missing", error=HeightMapError, **GIVEN
    )


def test_text_without_numbers(refused):
    refused("Dear all\nhere is the map\n", r"text without a table of numbers; it starts with 'Dear all'")


def test_inspect_says_what_is_missing(tmp_path):
    found = inspect_file(saved(tmp_path, "# Value units: nm\n" + matrix()))
    assert "give dx, dy, unit" in found["problem"]
    assert found["channel"] == "height"
    (channel,) = found["channels"]
    assert (channel["ny"], channel["nx"], channel["height_unit"], channel["dx"]) == (3, 4, "nm", None)
    assert channel["rms_height"] == pytest.approx(HEIGHTS.std(), rel=1e-12)
    assert json.loads(json.dumps(found)) == found
