"""Text tables in which a row, a separator of thousands or a row number may be taken for something else."""

import numpy as np
import pytest
from measured_files import warnings_of

from roughcontact.errors import InputFileError
from roughcontact.io.plausibility import suspicions
from roughcontact.io.read import read_height_map

# nanometres, without symmetry; with values below one and of four digits, which show the decimal sign
ROUGH = np.round(400.0 * np.random.default_rng(11).standard_normal((12, 16)), 2)
ROUGH[3, 4] = 0.25
COUNTS = np.random.default_rng(12).integers(1_000, 99_999, (12, 16))  # whole numbers of nanometres


def rows_of(heights=ROUGH, form="{:g}"):
    return [[form.format(value) for value in row] for row in heights]


def text_of(rows, separator="\t"):
    return "".join(separator.join(row) + "\n" for row in rows)


def marked(word, *places, separator="\t"):
    """Return the text of the map with a word at some places (row, column)."""
    rows = rows_of()
    for row, column in places:
        rows[row][column] = word
    return text_of(rows, separator)


def without(*places):
    heights = ROUGH.copy()
    for place in places:
        heights[place] = np.nan
    return heights


def grouped(heights, mark):
    """Return whole numbers with a mark between the thousands."""
    return (
        rows_of(heights, "{:,}")
        if mark == ","
        else [[f"{n:,}".replace(",", mark) for n in row] for row in heights]
    )


def read(tmp_path, text, **arguments):
    path = tmp_path / "map.txt"
    path.write_text(text, encoding="utf-8")
    return read_height_map(path, **({"dx": 1, "dy": 1, "unit": "um", "height_unit": "nm"} | arguments))


CORNER = (0, 0)
LOST = r"line 1 has as many cells as the rows of the table below it.*{}.*write NaN for a missing point"
NO_ROW = "line {} is no row of numbers"
THOUSANDS = "every number has three digits behind its '{}'"
ONE_TABLE = "in one table.*separators of thousands"

# name -> text, the heights in nm that are right, or the pattern of the refusal, and words of a warning
DIALECTS = {
    # a word in the first row, or a damaged number
    "unknown word in the corner": (marked("n.b.", CORNER), LOST.format("'n.b.'")),
    "unknown word inside the first row": (marked("trou", (0, 7)), LOST.format("'trou'")),
    "unknown word at the end of the first row": (marked("§", (0, 15)), LOST.format("'§'")),
    "two decimal points": (marked("1..2", (0, 3)), LOST.format(r"'1\.\.2'")),
    "letter O for zero": (marked("1O.5", (0, 3)), LOST.format(r"'1O\.5'")),
    "underscore": (marked("1_000", (0, 3)), LOST.format("'1_000'")),
    "lost separator": (marked("1.5", (0, 3)).replace("1.5\t", "1.5x", 1), LOST.format("'1.5x")),
    "hash in the corner": (marked("#", CORNER), LOST.format("'#'")),
    "hash in the corner, blanks": (marked("#", CORNER, separator=" "), LOST.format("'#'")),
    "unknown words in four rows": (
        marked("n.b.", *((row, 2) for row in range(4))),
        "line 4 has as many cells",
    ),
    "a first row of unknown words": (
        marked("n.b.", *((0, place) for place in range(16))),
        LOST.format("'n.b.'"),
    ),
    "a first row of more unknown words than numbers": (
        marked("n.b.", *((0, place) for place in range(12))),
        LOST.format("'n.b.'"),
    ),
    "units of all columns": ("\t".join(["nm"] * 16) + "\n" + text_of(rows_of()), ROUGH),
    "one name of all columns": ("\t".join(["Profile"] * 16) + "\n" + text_of(rows_of()), ROUGH),
    "below a title": ("scan of Monday\n\n" + marked("n.b.", CORNER), "line 3 has as many cells"),
    "semicolons and commas": (
        marked("n.b.", CORNER, separator=";").replace(".", ","),
        LOST.format("'n,b,'|'n.b.'"),
    ),
    "unknown word in a later row": (marked("n.b.", (8, 3)), NO_ROW.format(9)),
    "hash at the beginning of a later row": (marked("#", (8, 0)), NO_ROW.format(9)),
    "known word in the first row": (marked("out", CORNER), without(CORNER), "'out' occurs in 1 cell"),
    "known word in the last row": (
        marked("Ungültig", (11, 15)),
        without((11, 15)),
        "'Ungültig' occurs in 1 cell",
    ),
    "known word at both ends": (
        marked("undefined", CORNER, (11, 15)),
        without(CORNER, (11, 15)),
        "'undefined' occurs in 2 cells",
    ),
    "No Data in the first row": (marked("No Data", CORNER), without(CORNER)),
    "No Data in the first row, blanks": (marked("No Data", CORNER, separator=" "), without(CORNER)),
    "out of range in the first row": (marked("Out of range", (0, 2)), without((0, 2)), "'outofrange' occurs"),
    # lines that are headings
    "a comment of numbers": ("# " + "\t".join(map(str, range(16))) + "\n" + text_of(rows_of()), ROUGH),
    "an entry with a word for missing points": ("Masked\t12\n" + text_of(rows_of()), ROUGH),
    "names of all columns": (
        "\t".join(f"c{place}" for place in range(16)) + "\n" + text_of(rows_of()),
        ROUGH,
    ),
    "an entry of as many cells": ("Scan:\t" + "\t".join(["1"] * 15) + "\n" + text_of(rows_of()), ROUGH),
    # thousands
    "thousands with commas, tabs": (text_of(grouped(COUNTS, ",")), COUNTS / 1e3, THOUSANDS.format(",")),
    "thousands with points, semicolons": (
        text_of(grouped(COUNTS, "."), ";"),
        COUNTS / 1e3,
        THOUSANDS.format("."),
    ),
    "thousands with commas, quoted": (
        text_of([[f'"{cell}"' for cell in row] for row in grouped(COUNTS, ",")], ","),
        COUNTS / 1e3,
        THOUSANDS.format(","),
    ),
    "thousands and smaller numbers, points": (text_of(grouped(COUNTS // 40, "."), ";"), ONE_TABLE),
    "thousands and smaller numbers, commas": (text_of(grouped(COUNTS // 40, ",")), ONE_TABLE),
    "thousands with commas beside decimal points": (
        text_of(
            [[f"{value:.1f}" if value < 900 else f"{value:,.0f}" for value in row] for row in COUNTS / 40]
        ),
        ONE_TABLE,
    ),
    "thousands with points, decimal commas": (
        text_of(
            [[f"{value:,.2f}".translate(str.maketrans(",.", ".,")) for value in row] for row in COUNTS], ";"
        ),
        r"line 1 is no row of numbers \(\d+\.\d+,00\); write the numbers without separators of thousands",
    ),
    "decimal commas between commas": (
        text_of(rows_of(ROUGH / 1e3, "{:.5f}"), ".").replace(".", ","),
        "the comma in .* may be a decimal sign or a separator",
    ),
    "a phrase between commas": (
        text_of(rows_of(ROUGH), ",") + "1.5,Not valid" + ",0.5" * 14 + "\n" + text_of(rows_of(ROUGH), ","),
        r"line 13 is no row of numbers \(Not valid\); write NaN for a missing point",
    ),
    "three decimals, some below one": (text_of(rows_of(ROUGH, "{:.3f}")), ROUGH),
    "three decimals, commas, some below one": (text_of(rows_of(ROUGH, "{:.3f}")).replace(".", ","), ROUGH),
    # numbers of rows and columns
    "row numbers from 1": (
        text_of([[str(number), *row] for number, row in enumerate(rows_of(), start=1)]),
        ROUGH,
        "the first column (1, 2, 3 ...) is taken as numbers or positions, and left out",
    ),
    "row numbers from 0": (
        text_of([[str(number), *row] for number, row in enumerate(rows_of())], " "),
        ROUGH,
        "the first column (0, 1, 2 ...) is taken as numbers or positions, and left out",
    ),
    "column numbers from 0": (
        text_of([[*map(str, range(16))], *rows_of()]),
        ROUGH,
        "the first row (0, 1, 2 ...) is taken as numbers or positions, and left out",
    ),
}
DOUBTS = ("occurs in", "three digits", "is taken as")


@pytest.mark.parametrize("name", DIALECTS)
def test_a_dialect_is_right_or_refused_or_named(tmp_path, name):
    text, right, *warnings = DIALECTS[name]
    if isinstance(right, str):
        with pytest.raises(InputFileError, match=rf"map\.txt: .*{right}"):
            read(tmp_path, text)
        return
    height = read(tmp_path, text)
    np.testing.assert_allclose(height.values[::-1], right * 1e-9, rtol=1e-14)
    said = warnings_of(height)
    assert all(warning in said for warning in warnings)
    assert warnings or not any(words in said for words in DOUBTS)


def test_the_refusal_of_a_row_above_the_table(tmp_path):
    with pytest.raises(InputFileError) as caught:
        read(tmp_path, "Width: 16 um\nHeight: 12 um\n" + marked("n.b.", (0, 7)))
    assert str(caught.value) == (
        f"{tmp_path / 'map.txt'}: line 3 has as many cells as the rows of the table below it, and 'n.b.' in "
        "place of a number: correct it, write NaN for a missing point, or delete the line if it is no row of "
        "the map"
    )


@pytest.mark.parametrize("title", ["Scan 512 512", "# 4 3", "points 12.5 7.5"])
def test_a_title_of_two_numbers_above_a_list_of_points_is_a_heading(tmp_path, title):
    points = "".join(f"{i} {j} {ROUGH[j, i]:g}\n" for j in range(3) for i in range(4))
    height = read(tmp_path, f"{title}\n{points}", dx=None, dy=None)
    np.testing.assert_allclose(height.values, ROUGH[:3, :4] * 1e-9, rtol=1e-14)


def test_the_first_point_of_a_list_is_no_heading(tmp_path):
    points = [[f"{i / 2}", f"{j / 2}", f"{ROUGH[j, i]:g}"] for j in range(3) for i in range(4)]
    with pytest.raises(InputFileError, match=LOST.format("'n.b.'")):
        read(tmp_path, text_of([[*points[0][:2], "n.b."], *points[1:]]), dx=None, dy=None)
    height = read(tmp_path, text_of([[*points[0][:2], "undef"], *points[1:]]), dx=None, dy=None)
    expected = ROUGH[:3, :4] * 1e-9
    expected[0, 0] = np.nan
    np.testing.assert_allclose(height.values, expected, rtol=1e-14)
    assert "'undef' occurs in 1 cell" in warnings_of(height)


def test_a_length_of_the_header_shows_the_decimal_sign(tmp_path):
    table = text_of(rows_of(COUNTS / 1e3, "{:.3f}"))
    assert THOUSANDS.format(".") in warnings_of(read(tmp_path, table))
    height = read(tmp_path, "Width: 16.5 um\nHeight: 12.0 um\n" + table, dx=None, dy=None)
    assert "three digits" not in warnings_of(height)
    np.testing.assert_allclose(height.values[::-1], COUNTS * 1e-12, rtol=1e-14)


def test_positions_that_count_are_no_row_numbers(tmp_path):
    profile = "".join(f"{place}\t{value:g}\n" for place, value in enumerate(ROUGH[0]))
    assert "is taken as" not in warnings_of(read(tmp_path, profile, dx=None, dy=None))
    assert "is taken as" not in warnings_of(
        read(tmp_path, text_of(rows_of(np.add.outer(np.arange(9), np.arange(9)))))
    )


@pytest.mark.parametrize("shape", [(9, 13), (10, 10), (11, 18)])
def test_one_point_at_the_extreme_of_a_small_map_is_no_saturation(shape):
    height = 1e-7 * np.random.default_rng(5).standard_normal(shape)
    assert not [doubt.finding for doubt in suspicions(height, 1e-6, 1e-6) if "exactly" in doubt.finding]
    order = np.argsort(height, axis=None)
    height.flat[order[-2]] = height.max()
    (saturated,) = [doubt.finding for doubt in suspicions(height, 1e-6, 1e-6) if "exactly" in doubt.finding]
    assert "exactly the highest height" in saturated
