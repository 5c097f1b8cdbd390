"""Text matrices, lists of points and profiles: written here in the variants that programs write."""

import json
import re

import numpy as np
import pytest
from measured_files import GIVEN, cells, holds, points, refuses, saved, steps, warnings_of

from roughcontact import HeightMapError, SettingsError, inspect_file, read_height_map

# no symmetry, so that a mirrored or transposed map is told from the right one
HEIGHTS = np.array([[1.5, -2.25, 3.0, 0.5], [4.0, 5.5, -6.75, 7.0], [0.25, 9.0, 10.5, -1.0]])
UPPER_FIRST = HEIGHTS[::-1]  # as a matrix is read
MATRIX = cells(HEIGHTS)
SIZES = "# Width: 4 µm\n# Height: 3 µm\n"


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "utf-16", "utf-8-sig"])
def test_header_as_gwyddion_writes_it(read, encoding):
    header = "# Channel: Topo\n# Width: 4.00 µm\n# Height: 3,00 µm\n# Value units: nm\n"
    height = read(header + MATRIX, encoding=encoding)
    holds(height, 1e-9 * UPPER_FIRST)
    np.testing.assert_allclose(height.x, [0.5e-6, 1.5e-6, 2.5e-6, 3.5e-6], rtol=1e-12)
    np.testing.assert_allclose(height.y, [0.5e-6, 1.5e-6, 2.5e-6], rtol=1e-12)
    assert height.dims == ("y", "x")
    attributes = {"channel": "Topo", "first_row": "top", "missing_points": 0}
    assert height.attrs.items() >= attributes.items()


def test_conversion_factor_and_counts_in_the_header(read):
    header = "h=3 w=4\npixel size=3.5e-007 m\ndata unit=rad\nheight conversion factor (-> m)=2.5e-008\n"
    holds(read(header + cells(HEIGHTS, " ")), 2.5e-8 * UPPER_FIRST, 3.5e-7, 3.5e-7)


def test_inspection_gives_channel_and_map_the_same_heights_where_the_header_has_a_factor(tmp_path):
    header = "h=3 w=4\npixel size=3.5e-007 m\ndata unit=rad\nheight conversion factor (-> m)=2.5e-008\n"
    contents = inspect_file(saved(tmp_path, header + cells(HEIGHTS, " ")))
    (channel,), found = contents["channels"], contents["map"]
    assert channel["height_unit"] == "m"
    for key in ("lowest", "highest"):
        assert channel[key] == pytest.approx(found[key], rel=1e-12)
    assert channel["rms_height"] == pytest.approx(2.5e-8 * np.std(UPPER_FIRST), rel=1e-12)


def test_counts_with_their_value_in_nanometres(read):
    header = "# x-pixels = 4\n# y-pixels = 3\n# x-length = 2000\n# y-length = 1500\n# Bit2nm = 0.01\n"
    holds(read(header + MATRIX, unit="nm"), 1e-11 * UPPER_FIRST, 500e-9, 500e-9)


def test_missing_points_become_nan_and_are_counted(read):
    text = "ncols 4\nnrows 2\ncellsize 2\nNODATA_value -9999\n1 2 -9999 4\nBAD 6 nan 8.5\n"
    height = read(text, unit="mm", height_unit="um")
    holds(height, 1e-6 * np.array([[np.nan, 6, np.nan, 8.5], [1, 2, np.nan, 4]]), 2e-3, 2e-3)
    assert (height.attrs["missing_points"], height.attrs["missing_share"]) == (3, 0.375)


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
@pytest.mark.parametrize("index", [0, 5])
def test_what_programs_write_for_a_missing_point(read, gap, index):
    heights, expected = HEIGHTS.astype(object), HEIGHTS.copy()
    heights.flat[index], expected.flat[index] = gap, np.nan
    holds(read(cells(heights, form="{}"), **GIVEN), 1e-6 * expected[::-1])


def test_a_line_drawn_below_headings_is_no_row_of_the_map(read):
    text = "a      b      c     d\n------ ------ ----- -----\n" + cells(HEIGHTS, " ")
    holds(read(text, **GIVEN), 1e-6 * UPPER_FIRST)


def test_exponents_of_fortran(read):
    height = read(cells(HEIGHTS, " ", "{:.3E}").replace("E", "D"), **GIVEN)
    holds(height, 1e-6 * UPPER_FIRST)
    assert "unit of its heights: they are taken in um, as x and y" in warnings_of(height)


def headed_points(heading):
    return heading + "\n" + cells(points(HEIGHTS, dy=2), ",")


def test_units_of_points(read):
    holds(read(headed_points("x (µm),y (micron),z (nm)")), 1e-9 * HEIGHTS, 1e-6, 2e-6)
    holds(read(headed_points("x (µm),y (mm),z (nm)")), 1e-9 * HEIGHTS, 1e-6, 2e-3)
    # of inches in a row of their own, "in" is a unit between blanks and no word between a name and its unit
    inches = read("x y z\nin in in\n" + cells(points(HEIGHTS, dy=2), " "))
    holds(inches, 0.0254 * HEIGHTS, 0.0254, 0.0508)


@pytest.mark.parametrize(("name", "doubted"), [("Depth", True), ("z", False)])
def test_a_column_of_depths_is_named(read, name, doubted):
    height = read(headed_points(f"x (µm),y (µm),{name} (nm)"))
    holds(height, 1e-9 * HEIGHTS)
    assert bool(re.search("'Depth'.*change their sign", warnings_of(height))) == doubted


def test_points_with_a_fourth_column_are_no_map(read, refusal):
    text = cells(np.column_stack([points(HEIGHTS), np.arange(12)]), " ")
    refusal(text, r"begin anew at line 5.*name the columns", **GIVEN)
    holds(read("x y z intensity\n" + text, unit="um"), 1e-6 * HEIGHTS)


def test_bare_numbers_are_refused_with_what_to_give(tmp_path):
    path, wrong = saved(tmp_path, MATRIX), {"error": SettingsError} | GIVEN
    refuses(
        r"map of 3 x 4 points that does not say its size, nor .* heights; give dx, dy, unit, height_unit in",
        path,
    )
    refuses("give dx, dy, unit, height_unit in", path, unit="um")
    refuses("give dx, dy, unit, height_unit in", path, dx=1, unit="um")
    refuses("its size; give dx, dy, unit in", path, height_unit="nm")
    refuses("give unit, height_unit in", saved(tmp_path, "0 1.5\n1 2.5\n2 2\n", "profile.txt"))
    refuses("dx = 1 is given without a unit", path, error=SettingsError, dx=1, dy=1)
    refuses(r"dx = -1 must be a positive finite number in um", path, **wrong | {"dx": -1})
    refuses(
        "unknown length unit 'milimeter'; did you mean 'millimeter'", path, **wrong | {"unit": "milimeter"}
    )


def test_height_unit_of_the_file_stands_beside_the_unit_of_the_steps(read):
    height = read("\\Exported image units: nm\n" + MATRIX, **GIVEN)
    holds(height, 1e-9 * UPPER_FIRST)
    assert "given by the user" not in warnings_of(height)


@pytest.mark.cases
def test_the_unit_of_the_heights_in_words(read, line):
    holds(read(f"{line}\n1 2\n3 4\n", dx=1, dy=1, unit="um"), [[3e-9, 4e-9], [1e-9, 2e-9]])


def test_arguments_win_over_the_file_and_say_so(read):
    height = read(f"{SIZES}# Value units: nm\n{MATRIX}", dx=2, dy=1, unit="um", height_unit="pm")
    holds(height, 1e-12 * UPPER_FIRST, 2e-6, 1e-6)
    notes = warnings_of(height)
    assert "dx = 2e-06 m as given by the user, where the file says 1e-06 m" in notes
    assert "the heights are taken in pm as given by the user, where the file says nm" in notes
    assert "dy =" not in notes.replace("the pixels are not square: dx = 2e-06 m, dy = 1e-06 m", "")


def test_cut_matrices_are_refused(read, refusal):
    square = np.random.default_rng(3).standard_normal((20, 20))
    text = "# Width: 20 µm\n# Height: 20 µm\n# Value units: nm\n" + cells(square)
    assert read(text).shape == (20, 20)
    refusal(text[: int(0.6 * len(text))], "the file was cut off")
    shorter = "".join(text.splitlines(keepends=True)[: 3 + 12])
    refusal(shorter, r"seems to be cut off\. If it is whole, give dx, dy and unit")
    assert read(shorter, **GIVEN).shape == (12, 20)


VOLTS = f"{SIZES}# Value units: V\n{MATRIX}"
QUOTED = "Width: 1,234 µm\nHeight: 4 µm\n" + '"1.5","2.25","3.5","4.5"\n' * 4
OTHER_ROWS = "1 2\nProfile1 3 0\nCX A 120 MM 1.0 D\nEOR\n12\n13\n14\n"
INDEXED = cells((n, 0.5 * n, height) for n, height in enumerate(HEIGHTS.flat))
LIST = points(HEIGHTS, 0.5, 0.25)
BY_COLUMN = LIST[np.lexsort(LIST.T[1::-1])]
UM, MM, NO_MAP = {"unit": "um"}, {"unit": "mm"}, GIVEN | {"error": HeightMapError}
AXIS = (0.0, 1.0, 2.3, 3.0, 4.0)
UNEVEN = "".join(f"{a} {b} {a * b + 1}\n" for b in range(4) for a in AXIS)
# a text, words of the refusal, what is given
NO_MAPS = [
    ("ncols 4\nnrows 5\ncellsize 1\n" + cells(HEIGHTS, " "), "header says 5 rows, the file has 3", {}),
    ("1 2 3 4\n1 2 3\n1 2 3 4\n", "row 2 has 3 numbers where the others have 4", {}),
    ("1 2 3 4\n1 2 3 4\n1 2 x 4\n1 2 3 4\n", r"line 3 is no row of numbers \(x\); write NaN", {}),
    (VOLTS, r"no channel of this file holds heights .*values in V, no length", {}),
    ("Dear all\nhere is it\n", "text without a table of numbers; it starts with 'Dear all'", {}),
    ("1,5\n2,5\n3\n4,5\n", "may be a decimal sign or a separator", UM | {"dx": 1}),
    (QUOTED, "line 1 says 'Width: 1,234 µm': its mark may be", {}),
    (OTHER_ROWS, r"line 2 is no row of numbers .* export the map as X3P or SDF", {}),
    ("so it goes\n" * 10_002 + "1 2 3\n", "without a table of numbers in its first 10000 lines; delete", {}),
    (INDEXED, "or delete the first one if it counts the rows", UM),
    (cells(LIST[:-1], " "), "ends in the middle of a grid line", MM),
    (cells(BY_COLUMN[:-1], " "), "ends in the middle of a grid line", MM),
    (UNEVEN, "even.*resample = linear", UM),
    (UNEVEN, "even.*resample = linear", GIVEN),
    ("".join(f"{a} {a * a}\n" for a in AXIS), "resample = linear", GIVEN),  # steps make no map of a profile
    ("1.5\n", "single point", NO_MAP),
    ("nan nan nan\nnan nan nan\n", "all 6 points of the map are missing", NO_MAP),
]


@pytest.mark.parametrize(("text", "words", "options"), NO_MAPS, ids=[words for _, words, _ in NO_MAPS])
def test_texts_that_are_no_map(refusal, text, words, options):
    refusal(text, words, **options)


def test_one_line_is_a_profile_and_no_number_is_05(read):
    holds(read("1.5 2.5 3.5 7\n", dx=1, unit="um"), 1e-6 * np.array([[1.5, 2.5, 3.5, 7]]))
    assert read("1,5\n2,5\n3\n4,5\n4,05\n", dx=1, unit="um").shape == (1, 5)


def test_list_of_points_with_named_columns_and_a_hole(read):
    table = points(HEIGHTS, 0.5, 0.25) + np.array([2, 1, 0])
    height = read("X (mm);Y (mm);Z (µm)\n" + cells(np.delete(table, 5, axis=0), ";").replace(".", ","))
    holds(height, 1e-6 * np.where(HEIGHTS == 5.5, np.nan, HEIGHTS), 5e-4, 2.5e-4)
    assert height.attrs["missing_points"] == 1


def test_rounded_positions_are_even(read):
    x = np.round(np.arange(30) / 3, 3)
    height = read("".join(f"{a:.3f},{b:.3f},{a * b + a:.4f}\n" for b in x for a in x), unit="um")
    assert height.shape == (30, 30)
    assert height.attrs["missing_points"] == 0
    assert steps(height) == pytest.approx([1e-6 / 3, 1e-6 / 3], rel=1e-4)


def test_profile_with_unit_in_the_column_name(tmp_path):
    x = 0.5 * np.arange(1, 13)
    path = saved(tmp_path, "X_(microns),y1\n" + cells(np.column_stack([x, HEIGHTS.ravel()]), ","))
    refuses("does not say the unit of its heights; give height_unit", path)
    height = read_height_map(path, height_unit="nm")
    holds(height, 1e-9 * HEIGHTS.reshape(1, 12))
    np.testing.assert_allclose(height.x, 1e-6 * x, rtol=1e-12)


def test_inspect_says_what_is_missing(tmp_path):
    contents = inspect_file(saved(tmp_path, "# Value units: nm\n" + MATRIX))
    assert "give dx, dy, unit" in contents["problem"]
    assert contents["channel"] == "height"
    (channel,) = contents["channels"]
    assert (channel["ny"], channel["nx"], channel["height_unit"], channel["dx"]) == (3, 4, "nm", None)
    assert channel["rms_height"] == pytest.approx(HEIGHTS.std(), rel=1e-12)
    assert json.loads(json.dumps(contents)) == contents
