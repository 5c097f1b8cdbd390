"""Texts that hold more than one thing: tables, traces, named columns, statements, positions."""

import json
import re

import numpy as np
import pytest
from measured_files import cells, holds, points, warnings_of

from roughcontact.io.inspection import inspect_file

RNG = np.random.default_rng(3)
ONE, TWO = (np.round(RNG.normal(size=(8, 10)), 3) for _ in range(2))  # nm
X, Y = 0.5 * np.arange(10), 0.25 * np.arange(8)  # µm
NM = {"unit": "um", "height_unit": "nm"}
GIVEN = NM | {"dx": 0.5, "dy": 0.25}
WORN = {"resample": "linear", "height_unit": "nm"}
# a matrix, alone and beside its positions along x, along y, and both; a list of points; a profile
ROWS, ABOVE, BESIDE = cells(ONE), cells([X, *ONE]), cells(np.column_stack([Y, ONE]))
BOTH = "\t" + ABOVE.partition("\n")[0] + "\n" + BESIDE
POINTS, TRACE = cells(points(ONE, 0.5, 0.25)), cells(zip(X, ONE[0], strict=True), ";")


def columns(*values, separator=";"):
    return cells(np.column_stack(values), separator)


def holds_nm(height, heights):
    """Require heights (nm) at steps of 0.5 µm and 0.25 µm."""
    holds(height, 1e-9 * heights, *(0.5e-6, 0.25e-6)[: min(len(heights), 2)], rtol=1e-12)


# ---------------------------------------------------------------- tables


def test_tables_with_headings_are_channels_in_their_units(read, refusal, tmp_path):
    head = "# Channel: {}\n# Width: 5 µm\n# Height: 2 µm\n# Value units: {}\n"
    text = head.format("Phase", "deg") + cells(TWO) + "\n" + head.format("Topography", "nm") + ROWS
    height = read(text)
    holds_nm(height, ONE[::-1])
    assert height.attrs["channel"] == "Topography"
    assert json.loads(height.attrs["channels"]) == ["Phase", "Topography"]
    refusal(text, "channel 'Phase' holds no heights", channel="Phase")
    channels = inspect_file(tmp_path / "map.dat")["channels"]
    assert [channel["height_unit"] for channel in channels] == ["deg", "nm"]
    words = "Forward" + "\t" * 9 + "\n" + ROWS + "\nBackward\n" + cells(TWO)
    holds_nm(read(words, **GIVEN), ONE[::-1])
    holds_nm(read(words, **GIVEN, channel="Backward"), TWO[::-1])


# ---------------------------------------------------------------- named columns


@pytest.mark.parametrize(
    ("heading", "values", "channel"),
    [
        ("X1 (um);Z1 (nm);X2 (um);Z2 (nm)", (X, ONE[0], X, TWO[0]), "Z2"),
        ("x [um];y [nm];x [um];y [nm]", (X, ONE[0], X, TWO[0]), "y (2)"),
        ("Distance (mm);Total (nm);Roughness (nm)", (X / 1e3, ONE[0], TWO[0]), "Roughness"),
    ],
)
def test_several_columns_of_heights_are_asked_about(read, refusal, heading, values, channel):
    text, name = f"{heading}\n{columns(*values)}", re.escape(channel)
    for options in ({}, GIVEN):
        refusal(
            text,
            rf"2 columns that may be heights: .*{channel.split()[0]}'.*channel.* are '[^']*{name}",
            **options,
        )
    refusal(text, rf"no channel is named 'all'; .* are '[^']*{name}", channel="all")
    holds_nm(read(text, channel=channel), TWO[:1])


def test_points_that_a_column_calls_invalid_are_missing(read):
    height = read("x (µm);z (nm);valid\n" + columns(X, ONE[0], X != 1))
    holds_nm(height, np.where(X == 1, np.nan, ONE[0])[None])


def test_columns_without_positions_are_profiles(read, refusal):
    text = "Profil 1 [nm];Profil 2 [nm];Profil 3 [nm]\n" + columns(ONE[0], TWO[0], ONE[1])
    refusal(text, "3 columns that may be heights", **GIVEN)
    holds_nm(read(text, channel="Profil 2", dx=0.5, unit="um"), TWO[:1])


SECOND, NAMES = "a second table begins at line {}", "x [um]\ty [um]\tz [nm]\n"
OTHERS, THREE = cells(points(TWO, 0.5, 0.25)), columns(X, ONE[0], TWO[0])
WORDS_IN_ROW = "line 1 has as many cells.*'{}'"
# a text that may be several things, or that contradicts itself: words of the refusal, and what is given
REFUSED = [
    (f"{ROWS}\n{cells(TWO)}", SECOND.format(10), GIVEN),
    (f"{ROWS}\n\n\n{cells(TWO)}", SECOND.format(12), GIVEN),
    (ROWS + "\t" * 9 + "\nScan 2" + "\t" * 9 + "\n" + cells(TWO), SECOND.format(10), GIVEN),
    (f"{ROWS}# second scan\n{cells(TWO)}", SECOND.format(10), GIVEN),
    (f"{ROWS}Scan 2\n{cells(TWO)}", SECOND.format(9), GIVEN),
    (columns(ONE, np.full(8, np.nan), TWO).replace("nan", ""), "line 1 .* has an empty column", GIVEN),
    (POINTS + OTHERS, "the first is that in line 81", NM),
    (NAMES + POINTS + NAMES + OTHERS, r"2 tables below one another .*line 82.*channel", NM),
    ("nx: 10\nny: 8\ndx: 0.5 µm\n" + columns(ONE.ravel()), "a column of 80 numbers, where the header", GIVEN),
    ("a;b;c;d (V)\n" + columns(X, *ONE[:3]), r"which of the 4 columns 'a', .*'d \(V\)'.*name them x", GIVEN),
    ("mm;unworn;worn\n" + columns(X, *ONE[:2]), "which of the 3 columns 'unworn', 'worn'", WORN),
    (f"x (µm);z (nm)\n{THREE}", "'x .µm.;z .nm.' names 2 columns, .* line 2 on, has", GIVEN),
    (f"Index;x (µm);y (µm);z (nm)\n{THREE}", "names 4 columns, .* line 2 on, has", GIVEN),
    ("x y z i\n" + THREE.replace(";", " "), "'x y z i' names 4 columns", GIVEN),
    ("x (µm);y (µm);z (nm)\n" + columns(X, ONE[0]), "names 3 columns, .* line 2 on, has 2", GIVEN),
    ("x;y;z\n" + columns(X, *ONE[:3]), "'x;y;z' names 3 columns, .* line 2 on, has 4", GIVEN),
    ("Profil 1;Profil 2\n" + columns(X, *ONE[:2]), "'Profil 1;Profil 2' names 2 columns", GIVEN),
    (columns(X, *ONE[:3]), r"first of 4 columns holds positions: of 3 profiles.*or .* a map", NM),
    ("dx: 0.5 µm\n" + columns(X, *ONE[:3]), "holds positions: of 3 profiles", NM),
    ("n/b\t" * 9 + "n/b\n" + ROWS, WORDS_IN_ROW.format("n/b"), GIVEN),
    ("Foo\t" * 9 + "Foo\n" + ROWS, WORDS_IN_ROW.format("Foo"), GIVEN),
    (f"Z unit: nm\nValue units: µm\n{ROWS}", "line 1 says .*, line 2 says .*correct one", GIVEN),
    (f"Z unit: µm\nHeight (nm)\n{ROWS}", "'Z unit: µm', line 2 says 'Height .nm.': they do not agree", GIVEN),
    ("x (µm);z (nm)\nmm;nm\n" + TRACE, "'x .µm.;z .nm.' and the units below it, 'µm' and 'mm'", GIVEN),
    (f"nx: 10\nColumns: 11\n{ROWS}", "line 1 says .*, line 2 says", GIVEN),
    (f"X unit: mm\nY unit: µm\n{ROWS}", "line 1 says .*, line 2 says", GIVEN),
    (f"Bit2nm: 1\nZ unit: µm\n{ROWS}", "line 1 says .*, line 2 says", GIVEN),
    (f"Z scale (nm/LSB): 0.01\n{ROWS}", "line 1 says 'Z scale .*: name a factor", GIVEN),
    (f"Z scale: 0.001\nZ unit: nm\n{ROWS}", "line 1 says 'Z scale: 0.001': name a factor", GIVEN),
    (f"Width: 12 px\nHeight: 8 px\n{ROWS}", "the header says 12 columns, the file has 10", GIVEN),
    (f"Image size: 10 x 9 pixels\n{ROWS}", "the header says 9 rows, the file has 8", GIVEN),
    (THREE, "do not lie on an even grid .*name the columns .*as x, z1, z2", GIVEN),
    (THREE, "do not lie on an even grid .*name the columns .*as x, z1, z2", WORN),
    ("Nr;z (nm)\n" + columns([*range(1, 6)] * 2, ONE[0]), "'Nr' begins anew or repeats at line 7", GIVEN),
    (cells([*ONE, X]), "positions begin anew at line 9", GIVEN),
    (
        "x (µm);z1 (nm);z2 (nm)\n" + THREE[3:],
        "the point in line 2 has no position",
        GIVEN | {"channel": "z1"},
    ),
    ("x;z\n;1\n" + TRACE, "the point in line 2 has no position", NM),
    ((ROWS + "\n" + cells(TWO)).replace("\n", "\n\n"), SECOND.format(19), GIVEN),
]


def dressed(text, how):
    """Return a text whose rows of numbers are written as some programs do; its lines stay where they are."""

    def written(line):
        mark = "\t" if "\t" in line else ";"
        cells_of_line = line.split(mark)
        if len(cells_of_line) == 1 or not re.fullmatch(r"(?:[-+\d.,;eE\s]|nan)+", line):
            return line
        return {
            "plain": line,
            "quoted": mark.join(f'"{cell}"' for cell in cells_of_line),
            "apart": f" {mark} ".join(cells_of_line),
            "closed": line + mark,
            "decimal commas": line.replace(".", ","),
        }[how]

    return ("\n" if how == "plain" else "\r\n").join(map(written, text.split("\n")))


@pytest.mark.parametrize("how", ["plain", "quoted", "apart", "closed", "decimal commas"])
@pytest.mark.parametrize(("text", "words", "options"), REFUSED, ids=[words for _, words, _ in REFUSED])
def test_what_may_be_several_things_or_contradicts_itself_is_refused(refusal, text, words, options, how):
    refusal(dressed(text, how), words, **options)


def test_a_title_names_no_columns(read):
    holds_nm(read("Height profile\n" + ROWS, **GIVEN), ONE[::-1])


def test_columns_of_points_in_several_units(read):
    x, y, z = points(ONE, 0.5, 0.25).reshape(8, 10, 3).swapaxes(0, 1).reshape(80, 3).T  # column by column
    height = read("x [mm]\ty [um]\tz [nm]\tI\n" + columns(x / 1e3, y, z, z, separator="\t"))
    holds_nm(height, ONE)
    assert json.loads(height.attrs["channels"]) == ["z", "I"]
    holds_nm(read("x;z\n;nm\n" + TRACE, unit="um"), ONE[:1])
    holds_nm(read("# columns: x z y\n" + columns(x, z, y, separator=" "), **NM), ONE)


# ---------------------------------------------------------------- headers


@pytest.mark.cases
def test_statements_that_do_not_agree_are_asked_about(read, refusal, lines, words):
    text = f"{lines}\nZ unit: nm\n{ROWS}"
    refusal(text, words)
    holds_nm(read(text, dx=0.5, dy=0.25, unit="um"), ONE[::-1])


@pytest.mark.cases
def test_statements_that_agree_are_used(read, lines):
    for how in ("plain", "quoted", "apart", "closed"):
        holds_nm(read(dressed(f"{lines}\nZ unit: nm\n{ROWS}", how)), ONE[::-1])


@pytest.mark.cases
@pytest.mark.parametrize("separator", [" ", ",", ";", "\t"])
def test_a_line_gives_the_units_of_the_axes(read, line, separator):
    holds_nm(read(f"{line}\n{cells(points(ONE, 0.5, 0.25), separator)}"), ONE)


@pytest.mark.parametrize("line", ["Height: nm", "Heights = nm", "Höhe;nm", '"Hauteur","nm"', "高さ: nm"])
def test_heights_with_a_unit_but_no_number_have_that_unit(read, line):
    holds_nm(read(f"dx: 0.5 µm\ndy: 0.25 µm\n{line}\n{ROWS}"), ONE[::-1])


@pytest.mark.parametrize("line", ["Points x: 0.5 µm", "Columns: 5 µm", "Samples: 0.5 µm"])
def test_a_number_of_points_with_a_unit_of_length_is_asked_about(refusal, line):
    refusal(f"{line}\ndy: 0.25 µm\nZ unit: nm\n{ROWS}", "which is not used")


def test_units_that_may_be_those_of_other_axes_are_asked_about(refusal):
    table = cells(points(ONE, 0.5, 0.25))
    for line in ("Units: um, nm, nm", "Units: um, nm, um"):
        refusal(f"{line}\n{table}", "does not say its lateral unit")


def test_units_of_three_axes_above_a_matrix_in_its_positions(read):
    corner = "\t" + ABOVE.partition("\n")[0] + "\n" + BESIDE
    femto_scan = read(f"FemtoScan Data File\num\tum\tnm\n{corner}")
    holds_nm(femto_scan, ONE)
    sources = json.loads(femto_scan.attrs["ingest_sources"])
    assert (sources["unit"], sources["height_unit"], sources["not used"]) == ("line 2", "line 2", [])


def test_a_stated_size_is_that_of_all_lines(read):
    height = read("Width: 5 µm\nHeight: 1.75 µm\nZ unit: nm\n" + ROWS)
    holds(height, 1e-9 * ONE[::-1], 0.5e-6, 1.75e-6 / 8, rtol=1e-12)


@pytest.mark.parametrize(
    "line",
    ["dz: 0.01", "Z resolution: 0.01 nm", "Vertical step = 0.01 nm", "Z-Faktor 0,01"],
)
def test_a_factor_that_is_not_understood_is_asked_about_above_counts(read, refusal, line):
    counts = cells(np.round(100 * ONE))
    refusal(
        f"{line}\nZ unit: nm\n{counts}",
        f"line 1 says '{line}', and all heights are whole numbers.*'Z factor'",
        **GIVEN,
    )
    holds_nm(read(f"{line}\nZ factor: 0.01 nm\n{counts}", **GIVEN), np.round(ONE[::-1], 2))
    # above heights with decimals a factor in words is a doubt, a resolution is none
    assert ("line 1" in warnings_of(read(f"{line}\n{ROWS}", **GIVEN))) == line.startswith("Z-Faktor")
    read(f"Photon counts: 30\nBit resolution: 16\n{counts}", **GIVEN)


@pytest.mark.cases
def test_statements_that_are_not_understood_are_said(read, line, words):
    height = read(f"{line}\n{ROWS}", **GIVEN)
    assert re.search(words, warnings_of(height))
    holds_nm(height, ONE[::-1])
    assert not re.search(
        "not used|that height|taken as",
        warnings_of(read("Bad pixels: 3\nInverted: no\nBinning: 1\nPixel size: 0.5 µm\n" + ROWS, **GIVEN)),
    )


@pytest.mark.parametrize(
    "heading",
    ["rho;phi;z", "theta (deg);z (nm)", "Frequency;z", "Time;z", "Zeit (s);Höhe (nm)", "Load;Depth"],
)
def test_columns_of_other_quantities_are_no_positions(refusal, heading):
    text = POINTS.replace("\t", ";") if heading.count(";") == 2 else TRACE
    refusal(f"{heading}\n{text}", "which of the . columns|give dx", **NM)


@pytest.mark.parametrize("name", ["z*1000", "z x10^-3", "-z", "Ra", "Amplitude", "z inverted", "Gray_Value"])
def test_a_heading_of_changed_or_other_heights_is_said(read, name):
    height = read(f"x (µm);{name} (nm)\n{TRACE}")
    assert f"the heights are those of the column '{name}', as they are" in warnings_of(height)


PROFILE = list(zip(X, ONE[0], strict=True))


@pytest.mark.parametrize("separator", [";", "\t", ","])
@pytest.mark.cases
def test_words_beside_a_table_are_left_out_with_a_word(read, separator, heading, cell, words):
    rows = [f"{x:g};{z:g};{word.replace('|', ';')}" for (x, z), word in zip(PROFILE, cell, strict=True)]
    closing = ";" * ("|" in cell[0])
    text = "\n".join([f"x [µm];z [nm];{heading}{closing}", *rows, ""])
    height = read(text.replace(";", separator))
    holds_nm(height, ONE[:1])
    assert re.search(words, warnings_of(height))


@pytest.mark.parametrize("word", ["over", ">250", "OL", "n.d.", "1.2*", "3.1 nm"])
@pytest.mark.parametrize("row", [0, 1, 4])
def test_a_word_for_a_height_drops_no_row(refusal, word, row):
    lines = cells(PROFILE, ";").splitlines()
    lines[row] = lines[row].partition(";")[0] + ";" + word
    refusal("\n".join(lines), rf"line {row + 1} is no row of numbers \({re.escape(word)}\)", **NM)
    if " " not in word:
        refusal("\n".join(lines).replace(";", " "), rf"line {row + 1} is no row of numbers", **NM)


EMPTY, INDENTED = "\t" * 9 + "\n", "".join(f"\t{row}\n" for row in ROWS.splitlines())


@pytest.mark.parametrize(("text", "what"), [(INDENTED, "1 column"), (EMPTY + ROWS + 2 * EMPTY, "3 lines")])
def test_empty_cells_beside_a_matrix_are_said(read, text, what):
    height = read(text, **GIVEN)
    holds_nm(height, ONE[::-1])
    assert re.search(rf"{what} of empty cells beside the table (is|are) left out", warnings_of(height))
    assert "empty cells" not in warnings_of(read(f"\n{ROWS}\n\n", **GIVEN))


def test_a_heading_that_contradicts_the_positions_is_said(read):
    warnings = warnings_of(read(f"dx: 2 µm\nx (µm);z (nm)\n{TRACE}"))
    assert "line 1 says 'dx: 2 µm'" in warnings
    assert "the positions are used" in warnings
    assert "the positions" not in warnings_of(read(f"dx: 500 nm\nx (µm);z (nm)\n{TRACE}"))  # the same step


@pytest.mark.cases
@pytest.mark.parametrize("heading", ["x (µm);z (nm)", "z nm", "Height [nm]"])
def test_a_header_that_contradicts_the_unit_of_a_column_is_refused(refusal, line, words, heading):
    table = TRACE if ";" in heading else columns(ONE[0])
    refusal(f"{line}\n{heading}\n{table}", words, dx=0.5, unit="um")


def test_a_marker_of_the_header_is_none_of_positions(read):
    heights = np.where(np.arange(10) == 3, 0, ONE[0])
    height = read("NODATA: 0\nx (µm);z (nm)\n" + columns(X, heights))
    holds_nm(height, np.where(heights == 0, np.nan, heights)[None])


# ---------------------------------------------------------------- positions beside a matrix


def test_positions_in_the_first_row_and_column(read, refusal):
    text = BOTH[1:].replace("\t", " ")  # without a corner
    closed = "y/x" + BOTH.replace("\n", "\t\n")
    german = ("y/x" + BOTH).replace("\t", ";").replace(".", ",")
    for variant in (text, closed, closed.replace("\t\n", "\n", 1), german):
        holds_nm(read(variant, **NM), ONE)
    assert "'y (mm)' in the corner is not used: check" in warnings_of(read("y (mm)" + BOTH, **NM))
    refusal(text.replace("1.5", "9", 1), "line 1 has 10 numbers where the others have 11", **NM)
    uneven = "the first {} of the table, from line 1 on, holds positions that are not even"
    refusal(text.replace("1.5", "1.9", 1), uneven.format("row"), **NM)
    squares = cells(np.column_stack([np.r_[9, Y**2], [X, *ONE]]))
    refusal("\t" + squares[2:], uneven.format("column"), **NM)


def test_positions_and_steps_of_the_user_that_differ_are_said(read):
    text = "\t" + cells(np.column_stack([np.r_[9, Y / 1e3], [X / 1e3, *ONE]]))[2:]
    message = "dx = 5e-07 m as given by the user, where the file says 5e-10 m"
    assert message in warnings_of(read(text, **GIVEN))
    counted = cells(points(ONE))
    for names in ("", "X\tY\tValue\n"):
        message = "count from 0 on: if they number the points, give dx and dy"
        assert message in warnings_of(read(names + counted, **NM))
    holds_nm(read(counted, **GIVEN), ONE)


def test_positions_in_the_first_row_or_column_alone(read, refusal):
    holds_nm(read(ABOVE, **GIVEN), ONE[::-1])
    holds_nm(read(ABOVE, dy=0.25, **NM), ONE[::-1])
    refusal(ABOVE, "give dy, unit", **NM)
    holds_nm(read(BESIDE, **GIVEN), ONE)
    header = "Width: {} µm\nHeight: 2 µm\nZ unit: nm\n"
    holds_nm(read(header.format(5) + ABOVE), ONE[::-1])
    words = r"taken as positions along x: line 4 says .*, line 1 says 'Width"
    refusal(header.format(50) + ABOVE, words)
    height = read("nx: 10\nny: 9\n" + ABOVE, **GIVEN)
    holds_nm(height, np.array([X, *ONE])[::-1])
    assert "may be positions along x" in warnings_of(height)


def test_lines_of_a_tilted_plane_are_heights(read):
    plane = np.add.outer(0.3 * np.arange(8), 0.2 * np.arange(10))
    height = read(cells(plane), **GIVEN)
    holds_nm(height, plane[::-1])
    assert "positions" not in warnings_of(height)
    holds_nm(read(cells([X, *plane]), **GIVEN), plane[::-1])


# ---------------------------------------------------------------- sources, and lines that nothing uses


def matrix(*lines, heights=ONE):
    return "\n".join([*lines, cells(heights)])


SIZED = ("Width: 5 µm", "Height: 2 µm", "Z unit: nm")


def test_what_a_map_needs_has_a_source(read, tmp_path):
    height = read(matrix(*SIZED, "Operator 7"), missing_value=-9999)
    origins = json.loads(height.attrs["ingest_sources"])
    assert origins == inspect_file(tmp_path / "map.dat", missing_value=-9999)["sources"]
    lines = {"dx": "line 1", "dy": "line 2", "unit": "line 1", "height_unit": "line 3"}
    assert origins.items() >= lines.items()
    assert origins["missing_value"] == "stated by the user"
    assert origins["not used"] == ["line 4: Operator 7"]
    profile = read(f"x [µm];z [nm]\n{TRACE}", first_row="top")
    origins = json.loads(profile.attrs["ingest_sources"])
    assert [origins[key] for key in ("dx", "unit", "height_unit")] == ["positions", "headings", "headings"]
    assert "dy" not in origins


@pytest.mark.cases
def test_a_step_of_any_name_that_the_size_contradicts_is_asked_about(read, refusal, line):
    refusal(matrix(*SIZED, line), f"line 4 says {re.escape(repr(line))}, .* agree.*dx, dy and unit")
    holds_nm(read(matrix(*SIZED, line), **GIVEN), ONE[::-1])


@pytest.mark.cases
def test_a_length_that_nothing_uses_is_named(read, line, doubted):
    height = read(matrix(*SIZED, line))
    holds_nm(height, ONE[::-1])
    assert (f"line 4 says '{line}', which is not used: check the steps" in warnings_of(height)) == (
        doubted == "doubted"
    )
    assert "line 4" not in warnings_of(read(matrix(*SIZED, line), ignore_lines="4"))


@pytest.mark.parametrize(
    "line", ["all peaks are nm", "NB: nm", "Units: µm, mm, nm", "wafer 7, heights in nm, pixel 0.5 um"]
)
def test_a_unit_of_the_steps_is_not_that_of_heights_which_a_line_contradicts(read, refusal, line):
    for text, options in ((matrix("# " + line), {"dx": 0.5, "dy": 0.25}), ("# " + line + "\n" + POINTS, {})):
        message = f"unit of its heights .line 1 says '# {line}', which is not used.*give .*height_unit"
        refusal(text, message)
        refusal(text, message, unit="um", **options)
        holds_nm(read(text, **NM, **options, first_row="bottom"), ONE)


def test_length_and_width_are_both_asked_about(read, refusal):
    text = matrix("Length: 5 µm", "Width: 2 µm", "Z unit: nm")
    for options in ({}, {"dy": 0.25, "unit": "um"}):
        refusal(text, "line 1 says 'Length: 5 µm', which is not used.; give dx, dy, unit", **options)
    holds_nm(read(text, **GIVEN), ONE[::-1])


@pytest.mark.parametrize(
    "line", ["Z-Werte in 0,1 nm", "1 Digit = 0,1 nm", "Height in 0.1 nm", "Z sensitivity 0.1 nm/inc"]
)
def test_the_length_of_one_count_is_its_factor(read, line):
    counts = np.round(100 * ONE)
    holds_nm(read(matrix(line, heights=counts), **GIVEN), counts[::-1] / 10)


@pytest.mark.cases
def test_a_factor_above_counts_is_asked_about_in_any_words(read, refusal, line):
    counts = np.round(100 * ONE)
    refusal(
        matrix(line, heights=counts), f"line 1 says '{re.escape(line)}', and all heights are whole", **GIVEN
    )
    holds_nm(read(matrix(line, heights=counts), **GIVEN, ignore_lines=1), counts[::-1])


def test_volts_are_no_lengths(refusal):
    witec = ["ScanUnit=µm", "ScanWidth=5", "ScanHeight=2", "DataUnit=V"]
    refusal(matrix(*witec), "values in V, no length", **GIVEN | {"height_unit": ""})
    spip = ["x-length = 5000", "y-length = 2000", "Bit2nm = 1.0", "z-unit = V"]
    refusal(matrix(*spip), "line 3 says 'Bit2nm = 1.0', line 4 says 'z-unit = V'", unit="nm")


def test_markers_of_programs(read):
    heights = np.where(ONE < -1.5, -9999, ONE)
    right = np.where(ONE < -1.5, np.nan, ONE)[::-1]
    holds_nm(
        read(
            matrix(*SIZED, heights=np.where(heights < -999, -99999.9999, ONE)).replace(
                "-100000", "-99999.9999"
            )
        ),
        right,
    )
    arc = ["ncols 10.0000001", "nrows 8", "xllcorner 0", "yllcorner 0", "cellsize 0.25"]
    height = read(matrix(*arc, heights=heights), **NM)
    np.testing.assert_allclose(height.values, 1e-9 * right, rtol=1e-12)


@pytest.mark.parametrize("count", [2, 3])
def test_wrapped_lines_are_asked_about(read, refusal, count):
    y, x = np.indices((12, 24))
    smooth = 300 * np.sin(0.31 * x + 0.2) * np.cos(0.1 * y) + 7.3 * x
    lines = ("Width: 12 µm", "Height: 12 µm", "Z unit: nm")
    refusal(
        matrix(*lines, heights=smooth.reshape(12 * count, -1)),
        f"{count} lines each go on where the one above",
    )
    read(matrix(*lines, heights=smooth))


def test_a_number_of_points_in_a_phrase_shows_that_lines_are_missing(read, refusal):
    head = "pixel size 0.5 µm, 10 x 12 points, heights in nm"
    refusal(f"{head}\n{ROWS}", "says 10 and 12 points, the table has 8 rows of 10 numbers; it was cut off")
    message = "line 1 says '10 x 12 points of steel', which is not used: check the steps"
    assert message in warnings_of(read("10 x 12 points of steel\n" + ROWS, **GIVEN))


def test_a_named_column_without_cells_and_a_section_are_no_columns(read):
    rows = TRACE.replace("\n", ";\n")
    for above in ("", "Date;3.2.2026;\n;;\n"):
        holds_nm(read(f"{above}x [µm];z [nm];Comment\n{rows}"), ONE[:1])
    column = cells(ONE[:1].T)
    holds_nm(read(f"[Profile]\nStep x: 0.5 µm\nZ unit: nm\n[Data]\n{column}"), ONE[:1])


def test_a_column_of_the_points_of_a_map_is_no_profile(read, refusal):
    column = cells(ONE.reshape(-1, 1))
    refusal(
        f"pixel size: 0.5 µm\nheights in nm\n10 x 8 points\n{column}", "says 10 x 8 points: write each row"
    )
    head = "Points: 80\nNumber of points: 80\npixel size: 0.5 µm\nheights in nm\n"
    assert read(head + column).shape == (1, 80)
