"""Text tables in which a row, a separator of thousands or a row number may be taken for something else."""

import numpy as np
import pytest
from measured_files import cells, holds, points, warnings_of

from roughcontact.io.plausibility import suspicions

# nanometres, without symmetry; with values below one and of four digits, which show the decimal sign
ROUGH = np.round(400.0 * np.random.default_rng(11).standard_normal((12, 16)), 2)
ROUGH[3, 4] = 0.25
COUNTS = np.random.default_rng(12).integers(1_000, 99_999, (12, 16))  # whole numbers of nanometres
NM = {"unit": "um", "height_unit": "nm"}
GIVEN = NM | {"dx": 1, "dy": 1}


def marked(word, *indices, separator="\t"):
    """Return the text of the map with a word at some places (row, column)."""
    table = ROUGH.astype(object)
    for index in indices:
        table[index] = word
    return cells(table, separator, "{}")


def without(*indices):
    heights = ROUGH.copy()
    for index in indices:
        heights[index] = np.nan
    return heights


def grouped(numbers, mark, separator, form="{:,}"):
    """Return numbers with a mark between the thousands."""
    return cells(numbers, "|", form).replace(",", mark).replace("|", separator)


def numbered(numbers, separator="\t"):
    """Return the text of the map with a number before each row."""
    return cells(([number, *row] for number, row in zip(numbers, ROUGH, strict=False)), separator)


TEXT, CSV = cells(ROUGH), cells(ROUGH, ",")
CORNER, END = ENDS = (0, 0), (11, 15)
LOST = (
    r"line 1 (?:has as many cells as the rows of the table|is no row of numbers).*{}.*write NaN for a missing"
)
NO_ROW = "line {} is no row of numbers"
THOUSANDS = "every number has three digits behind its '{}'"
ONE_TABLE = "in one table.*separators of thousands"
LEFT_OUT = "the first {} ({} ...) is taken as numbers or positions, and left out"

# name -> text, the heights in nm that are right, or the pattern of the refusal, and words of a warning
DIALECTS = {
    # a word in the first row, or a damaged number
    "unknown word in the corner": (marked("n.b.", CORNER), LOST.format("n.b.")),
    "unknown word inside the first row": (marked("trou", (0, 7)), LOST.format("trou")),
    "unknown word at the end of the first row": (marked("§", (0, 15)), LOST.format("§")),
    "two decimal points": (marked("1..2", (0, 3)), LOST.format(r"1\.\.2")),
    "letter O for zero": (marked("1O.5", (0, 3)), LOST.format(r"1O\.5")),
    "underscore": (marked("1_000", (0, 3)), LOST.format("1_000")),
    "lost separator": (marked("1.5", (0, 3)).replace("1.5\t", "1.5x", 1), LOST.format("1.5x")),
    "hash in the corner": (marked("#", CORNER), LOST.format("#")),
    "hash in the corner, blanks": (marked("#", CORNER, separator=" "), LOST.format("#")),
    "unknown word in four rows": (marked("n.b.", (0, 2), (1, 2), (2, 2), (3, 2)), LOST.format("n.b.")),
    "first row of unknown words": (marked("n.b.", *np.ndindex(1, 16)), LOST.format("n.b.")),
    "first row of more words than numbers": (marked("n.b.", *np.ndindex(1, 12)), LOST.format("n.b.")),
    "units of all columns": ("nm\t" * 15 + "nm\n" + TEXT, ROUGH),
    "one name of all columns": ("Profile\t" * 15 + "Profile\n" + TEXT, ROUGH),
    "below a title": ("scan of Monday\n\n" + marked("n.b.", CORNER), "line 3 has as many cells"),
    "semicolons and commas": (marked("n.b.", CORNER, separator=";").replace(".", ","), LOST.format("n.b.")),
    "unknown word in a later row": (marked("n.b.", (8, 3)), NO_ROW.format(9)),
    "hash at the beginning of a later row": (marked("#", (8, 0)), NO_ROW.format(9)),
    "known word in the first row": (marked("out", CORNER), without(CORNER), "'out' occurs in 1 cell"),
    "known word at the end": (marked("Ungültig", END), without(END), "'Ungültig' occurs in 1 cell"),
    "known word at both ends": (marked("undefined", *ENDS), without(*ENDS), "'undefined' occurs in 2 cells"),
    "No Data in the first row": (marked("No Data", CORNER), without(CORNER)),
    "No Data in the first row, blanks": (marked("No Data", CORNER, separator=" "), without(CORNER)),
    "out of range in the first row": (marked("Out of range", (0, 2)), without((0, 2)), "'outofrange' occurs"),
    # lines that are headings
    "a comment of numbers": ("# " + cells([range(16)]) + TEXT, ROUGH),
    "an entry with a word for missing points": ("Masked\t12\n" + TEXT, ROUGH),
    "names of all columns": (cells([range(16)], form="c{}") + TEXT, ROUGH),
    "an entry of as many cells": ("Scan:" + "\t1" * 15 + "\n" + TEXT, ROUGH),
    # thousands
    "thousands with commas, tabs": (grouped(COUNTS, ",", "\t"), COUNTS / 1e3, THOUSANDS.format(",")),
    "thousands with points, semicolons": (grouped(COUNTS, ".", ";"), COUNTS / 1e3, THOUSANDS.format(".")),
    "thousands, quoted": (grouped(COUNTS, ",", ",", '"{:,}"'), COUNTS / 1e3, THOUSANDS.format(",")),
    "thousands and smaller numbers, points": (grouped(COUNTS // 40, ".", ";"), ONE_TABLE),
    "thousands and smaller numbers, commas": (grouped(COUNTS // 40, ",", "\t"), ONE_TABLE),
    "thousands with commas beside decimal points": (
        cells(([f"{n:.1f}" if n < 900 else f"{n:,.0f}" for n in row] for row in COUNTS / 40), form="{}"),
        ONE_TABLE,
    ),
    "thousands with points, decimal commas": (
        cells(COUNTS, ";", "{:,.2f}").translate(str.maketrans(",.", ".,")),
        COUNTS,
    ),
    "decimal commas between commas": (
        cells(ROUGH / 1e3, ",", "{:.5f}").replace(".", ","),
        "the comma in .* may be a decimal sign or a separator",
    ),
    "a phrase between commas": (
        CSV + "1.5,Not valid" + ",0.5" * 14 + "\n" + CSV,
        r"line 13 is no row of numbers \(Not valid\); write NaN for a missing point",
    ),
    "three decimals, some below one": (cells(ROUGH, form="{:.3f}"), ROUGH),
    "three decimals, commas, some below one": (cells(ROUGH, form="{:.3f}").replace(".", ","), ROUGH),
    # numbers of rows and columns
    "row numbers from 1": (numbered(range(1, 13)), ROUGH, LEFT_OUT.format("column", "1, 2, 3")),
    "row numbers from 0": (numbered(range(12), " "), ROUGH, LEFT_OUT.format("column", "0, 1, 2")),
    "column numbers from 0": (cells([range(16)]) + TEXT, ROUGH, LEFT_OUT.format("row", "0, 1, 2")),
}
DOUBTS = ("occurs in", "three digits", "is taken as")


@pytest.mark.parametrize("name", DIALECTS)
def test_a_dialect_is_right_or_refused_or_named(read, refusal, name):
    text, right, *warnings = DIALECTS[name]
    if isinstance(right, str):
        refusal(text, rf"map\.dat: .*{right}", **GIVEN)
        return
    height = read(text, **GIVEN)
    holds(height, 1e-9 * right[::-1], rtol=1e-14)
    messages = warnings_of(height)
    assert all(warning in messages for warning in warnings)
    assert warnings or not any(words in messages for words in DOUBTS)


def test_the_refusal_of_a_row_above_the_table(refusal, tmp_path):
    assert refusal("Width: 16 um\nHeight: 12 um\n" + marked("n.b.", (0, 0)), "line 3", **GIVEN) == (
        f"{tmp_path / 'map.dat'}: line 3 has as many cells as the rows of the table below it, and 'n.b.' in "
        "place of a number: correct it, write NaN for a missing point, or delete the line if it is no row of "
        "the map"
    )


@pytest.mark.parametrize("title", ["Scan 512 512", "# 4 3", "points 12.5 7.5"])
def test_a_title_of_two_numbers_above_a_list_of_points_is_a_heading(read, title):
    holds(read(f"{title}\n{cells(points(ROUGH[:3, :4]), ' ')}", **NM), 1e-9 * ROUGH[:3, :4])


def test_the_first_point_of_a_list_is_no_heading(read, refusal):
    first_line, remainder = cells(points(ROUGH[:3, :4], 0.5, 0.5)).split("\n", 1)
    beginning = first_line.rpartition("\t")[0]
    refusal(f"{beginning}\tn.b.\n{remainder}", LOST.format("n.b."), **NM)
    height = read(f"{beginning}\tundef\n{remainder}", **NM)
    holds(height, 1e-9 * without(CORNER)[:3, :4])
    assert "'undef' occurs in 1 cell" in warnings_of(height)


def test_a_length_of_the_header_shows_the_decimal_sign(read):
    table = cells(COUNTS / 1e3, form="{:.3f}")
    assert THOUSANDS.format(".") in warnings_of(read(table, **GIVEN))
    height = read("Width: 16.5 um\nHeight: 12.0 um\n" + table, **NM)
    assert "three digits" not in warnings_of(height)
    holds(height, 1e-12 * COUNTS[::-1], rtol=1e-14)


def test_positions_that_count_are_no_row_numbers(read):
    assert "is taken as" not in warnings_of(read(cells(enumerate(ROUGH[0])), **NM))
    assert "is taken as" not in warnings_of(read(cells(np.add.outer(np.arange(9), np.arange(9))), **GIVEN))


@pytest.mark.parametrize("shape", [(9, 13), (10, 10), (11, 18)])
def test_one_point_at_the_extreme_of_a_small_map_is_no_saturation(shape):
    height = 1e-7 * np.random.default_rng(5).standard_normal(shape)
    assert "exactly" not in str(suspicions(height, 1e-6, 1e-6))
    height.flat[np.argsort(height, axis=None)[-2]] = height.max()
    (saturated,) = [doubt.finding for doubt in suspicions(height, 1e-6, 1e-6) if "exactly" in doubt.finding]
    assert "exactly the highest height" in saturated


def test_an_empty_cell_at_the_end_of_a_later_row_is_a_missing_point(read):
    text = cells(ROUGH[:4, :4], ";").replace(f"{ROUGH[1, 3]}\n", "\n", 1)
    assert text.count(";\n") == 1
    holds(read(text, **GIVEN), 1e-9 * without((1, 3))[:4, :4][::-1])


def test_a_line_that_is_half_words_is_a_heading(read):
    holds(read("scan 1 of 2\n" + cells(ROUGH[:3, :4], " "), **GIVEN), 1e-9 * ROUGH[:3, :4][::-1])


@pytest.mark.parametrize(("lines_with_result", "is_channel"), [(2, True), (1, False)])
def test_results_beside_remarks_are_heights_where_half_the_rows_have_them(
    read, lines_with_result, is_channel
):
    results = ["0.25"] * lines_with_result + [""] * (4 - lines_with_result)
    rows = [f"{x};{1.5 + x};kept;{result}" for x, result in enumerate(results)]
    height = read("\n".join(["x (um);z (nm);note;R", *rows]), unit="um")
    holds(height, [1e-9 * (1.5 + np.arange(4))])
    assert ("the first height channel of 2" in warnings_of(height)) == is_channel
