"""Texts that hold more than one thing: tables, traces, named columns, statements, positions."""

import json
import re

import numpy as np
import pytest

from roughcontact.io.inspection import inspect_file

RNG = np.random.default_rng(3)
ONE, TWO = (np.round(RNG.normal(size=(8, 10)), 3) for _ in range(2))  # nm
X, Y = 0.5 * np.arange(10), 0.25 * np.arange(8)  # µm
GIVEN = {"dx": 0.5, "dy": 0.25, "unit": "um", "height_unit": "nm"}
NM = {"unit": "um", "height_unit": "nm"}


def table(*columns, separator="\t"):
    rows = np.column_stack(columns)
    return "".join(separator.join(f"{value:g}" for value in row) + "\n" for row in rows)


def grid(heights):
    return np.tile(X, 8), np.repeat(Y, 10), heights.ravel()


def notes(height):
    return height.attrs["ingest_warnings"]


def assert_heights(height, heights, step=0.5e-6):
    np.testing.assert_allclose(height.values, 1e-9 * heights, rtol=1e-12)
    assert float(height.x[1] - height.x[0]) == pytest.approx(step, rel=1e-9)


# ---------------------------------------------------------------- tables


@pytest.mark.parametrize(
    ("between", "words"),
    [
        ("\n", "a second table begins at line 10"),
        ("\n\n\n", "a second table begins at line 12"),
        ("\t" * 9 + "\nScan 2" + "\t" * 9 + "\n", "a second table begins at line 10"),
        ("# second scan\n", "a second table begins at line 10"),
        ("Scan 2\n", "a second table begins at line 9"),
    ],
)
def test_a_second_table_without_headings_is_refused(refused, between, words):
    refused(table(ONE) + between + table(TWO), words, **GIVEN)


def test_an_empty_column_divides_maps_beside_one_another(refused):
    text = table(ONE, np.full(8, np.nan), TWO).replace("nan", "")
    refused(text, "line 1 .* has an empty column", **GIVEN)


def test_tables_with_headings_are_channels_in_their_units(read, refused, tmp_path):
    head = "# Channel: {}\n# Width: 5 µm\n# Height: 2 µm\n# Value units: {}\n"
    text = head.format("Phase", "deg") + table(TWO) + "\n" + head.format("Topography", "nm") + table(ONE)
    height = read(text)
    assert_heights(height, ONE[::-1])
    assert height.attrs["channel"] == "Topography"
    assert json.loads(height.attrs["channels"]) == ["Phase", "Topography"]
    refused(text, "channel 'Phase' holds no heights", channel="Phase")
    found = inspect_file(tmp_path / "map.dat")["channels"]
    assert [each["height_unit"] for each in found] == ["deg", "nm"]
    words = "Forward" + "\t" * 9 + "\n" + table(ONE) + "\nBackward\n" + table(TWO)
    assert_heights(read(words, **GIVEN), ONE[::-1])
    assert_heights(read(words, **GIVEN, channel="Backward"), TWO[::-1])


def test_points_at_the_positions_of_others_name_the_line(refused):
    refused(table(*grid(ONE)) + table(*grid(TWO)), "the first is that in line 81", **NM)
    headed = "x [um]\ty [um]\tz [nm]\n"
    refused(
        (headed + table(*grid(ONE))) + (headed + table(*grid(TWO))),
        r"2 tables below one another .*line 82.*channel",
    )


# ---------------------------------------------------------------- traces


def test_a_falling_profile_is_turned(read):
    assert_heights(read(table(X[::-1], ONE[0]), **NM), ONE[:1, ::-1])


# ---------------------------------------------------------------- named columns


@pytest.mark.parametrize(
    ("heading", "columns"),
    [
        ("y [µm];z [nm]", (X, ONE[0])),
        ("距離（mm）；高さ（nm）", (X / 1e3, ONE[0])),
        ("Counter;Altitude (nm);Encoder (µm)", (np.arange(10) + 37, ONE[0], X)),
        (";x (µm);z (nm)", (np.arange(10), X, ONE[0])),
        ("Zeit (s);Weg (mm);Höhe (µm)", (3 * X, X / 1e3, ONE[0] / 1e3)),
    ],
)
def test_profiles_by_the_names_of_their_columns(read, heading, columns):
    assert_heights(read(f"{heading}\n{table(*columns, separator=';')}"), ONE[:1])


@pytest.mark.parametrize(
    ("heading", "columns", "wanted"),
    [
        ("X1 (um);Z1 (nm);X2 (um);Z2 (nm)", (X, ONE[0], X, TWO[0]), "Z2"),
        ("Distance (mm);Total (nm);Roughness (nm)", (X / 1e3, ONE[0], TWO[0]), "Roughness"),
    ],
)
def test_several_columns_of_heights_are_asked_about(read, refused, heading, columns, wanted):
    text = f"{heading}\n{table(*columns, separator=';')}"
    for given in ({}, GIVEN):
        refused(text, rf"2 columns that may be heights: .*{wanted}.*channel.* are '[^']*{wanted}", **given)
    refused(text, rf"no channel is named 'all'; .* are '[^']*{wanted}", channel="all")
    assert_heights(read(text, channel=wanted), TWO[:1])


def test_points_that_a_column_calls_invalid_are_missing(read):
    height = read("x (µm);z (nm);valid\n" + table(X, ONE[0], X != 1, separator=";"))
    assert_heights(height, np.where(X == 1, np.nan, ONE[0])[None])


def test_columns_without_positions_are_profiles(read, refused):
    text = "Profil 1 [nm];Profil 2 [nm];Profil 3 [nm]\n" + table(ONE[0], TWO[0], ONE[1], separator=";")
    refused(text, "3 columns that may be heights", **GIVEN)
    assert_heights(read(text, channel="Profil 2", dx=0.5, unit="um"), TWO[:1])


def test_a_column_of_all_points_of_a_map_is_refused(refused):
    sizes = "nx: 10\nny: 8\ndx: 0.5 µm\n" + table(ONE.ravel())
    refused(sizes, "a column of 80 numbers, where the header states a size along y", **GIVEN)


def test_unknown_names_are_no_map(refused):
    refused(
        "a;b;c;d (V)\n" + table(X, ONE[0], ONE[1], ONE[2], separator=";"),
        r"which of the 4 columns 'a', 'b', 'c', 'd \(V\)'.*name them x",
        **GIVEN,
    )
    worn = "mm;unworn;worn\n" + table(X, ONE[0], ONE[1], separator=";")
    refused(worn, "which of the 3 columns 'unworn', 'worn'", resample="linear", height_unit="nm")


@pytest.mark.parametrize(
    ("heading", "columns"),
    [
        ("x (µm);z (nm)", (X, ONE[0], TWO[0])),
        ("Index;x (µm);y (µm);z (nm)", (X, ONE[0], TWO[0])),
        ("x y z i", (X, ONE[0], TWO[0])),
        ("x (µm);y (µm);z (nm)", (X, ONE[0])),
        ("x;y;z", (X, *ONE[:3])),
        ("Profil 1;Profil 2", (X, *ONE[:2])),
    ],
)
def test_a_heading_of_fewer_or_more_names_than_columns_is_refused(read, refused, heading, columns):
    text = heading + "\n" + table(*columns, separator=";" if ";" in heading else " ")
    named = len(heading.replace(";", "\n").replace(" ", "" if ";" in heading else "\n").split())
    refused(text, f"'{re.escape(heading)}' names {named} columns, .* line 2 on, has", **GIVEN)
    assert read("Height profile\n" + table(ONE), **GIVEN).shape == ONE.shape


def test_columns_of_points_in_several_units(read):
    text = "x [mm]\ty [um]\tz [nm]\tI\n" + table(
        X.repeat(8) / 1e3, np.tile(Y, 10), ONE.T.ravel(), ONE.T.ravel()
    )
    height = read(text)
    assert_heights(height, ONE)
    assert float(height.y[1] - height.y[0]) == pytest.approx(0.25e-6, rel=1e-9)
    assert json.loads(height.attrs["channels"]) == ["z", "I"]
    x, y, z = grid(ONE)
    assert_heights(read("# columns: x z y\n" + table(x, z, y, separator=" "), **NM), ONE)


def test_double_tabs_separate_cells(read):
    text = "WSxM file copyright UAM\nWSxM ASCII XYZ file\nX[um]\t\tY[um]\t\tZ[nm]\n"
    assert_heights(read(text + table(*grid(ONE), separator="\t\t")), ONE)


@pytest.mark.parametrize("word", ["n/d", "Foo"])
def test_a_first_row_of_an_unknown_word_is_not_dropped(refused, word):
    refused("\t".join([word] * 10) + "\n" + table(ONE), f"line 1 has as many cells.*'{word}'", **GIVEN)


# ---------------------------------------------------------------- headers


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["Pixel size: 0.5 µm", "Width: 10 µm"], "line 1 says .*, line 2 says .*10 columns"),
        (["Width: 5 µm", "Width: 6 µm", "Height: 2 µm"], "line 1 says .*, line 2 says"),
        (["dx = 0.5 µm", "dy = 0.25 µm", "XY unit: mm"], "line 1 says .*, line 3 says .*units do not agree"),
        (["Width: 5 mm", "Height: 2 µm"], "line 1 says .*, line 2 says .*units make pixels"),
        (["Width: 1,234 µm", "Height: 2 µm"], "line 1 says 'Width: 1,234 µm'.*separate thousands"),
        (["Width (mm): 5 µm", "Height: 2 µm"], r"line 1 says 'Width \(mm\): 5 µm'"),
        (["Width: 10", "Height: 8", "Unit: µm"], "line 1 says 'Width: 10', and there are 10 columns"),
        (["Scan size: 20 µm", "Width: 5 µm", "Height: 2 µm"], "line 1 says .*, line 2 says"),
        (["Resolution: 0.35 µm"], "give dx, dy, unit"),
        (["X range: 0 .. 5 µm", "Y range: 0 - 2 µm"], "give dx, dy, unit"),
        (["Width: 5 x 2 µm"], "give dx, dy, unit"),
        (["Pixel size: 0.5 µm 0.25 µm 0.001 µm"], "give dx, dy, unit"),
        (["Pixel size: 1/2 µm"], "give dx, dy, unit"),
        (["Pixel size: 1 234 nm"], "give dx, dy, unit"),
        (["Pixel size: 2 px/µm"], "line 1 says 'Pixel size: 2 px/µm': 'px/µm' is no unit of length"),
        (["Step: 0.5 µm"], "give dx, dy, unit"),
        (["Length: 5 µm", "Width: 5 µm", "Height: 3 µm"], "line 3 says .* or the range of its heights"),
        (["dx: 0.5 µm", "Höhe: 3 µm"], "line 1 says .*, line 2 says .* range of its heights"),
        (["Spacing: 0.5 µm", "Track spacing: 0.25 µm"], "line 2 says .*, line 1 says"),
        (["Camera pixel size: 6.5 µm", "Pixel size: 6.5 µm (camera)"], "give dx, dy, unit"),
    ],
)
def test_statements_that_do_not_agree_are_asked_about(read, refused, lines, words):
    text = "\n".join([*lines, "Z unit: nm"]) + "\n" + table(ONE)
    refused(text, f"{words}.*give dx, dy|{words}")
    assert_heights(read(text, dx=0.5, dy=0.25, unit="um"), ONE[::-1])


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["Z unit: nm", "Value units: µm"], "line 1 says .*, line 2 says .*correct one"),
        (["Z unit: µm", "Height (nm)"], "line 1 says 'Z unit: µm', and a heading of the heights 'nm'"),
        (["nx: 10", "Columns: 11"], "line 1 says .*, line 2 says"),
        (["X unit: mm", "Y unit: µm"], "line 1 says .*, line 2 says"),
        (["Bit2nm: 1", "Z unit: µm"], "line 1 says .*, line 2 says"),
        (["Z scale (nm/LSB): 0.01"], "line 1 says 'Z scale .*: name a factor"),
        (["Z scale: 0.001", "Z unit: nm"], "line 1 says 'Z scale: 0.001': name a factor"),
        (["Width: 12 px", "Height: 8 px"], "the header says 12 columns, the file has 10"),
        (["Image size: 10 x 9 pixels"], "the header says 9 rows, the file has 8"),
    ],
)
def test_other_statements_that_do_not_agree_are_refused(refused, lines, words):
    refused("\n".join(lines) + "\n" + table(ONE), words, **GIVEN)


@pytest.mark.parametrize(
    "lines",
    [
        ["Width: 5 µm", "Height: 2 µm", "Pixel size: 0.5 µm x 0.25 µm", "nx: 10"],
        ["dx=0.0005 mm, dy=0.00025 mm", "Width: 5 µm"],
        ["Width: 5 µm", "Height: 1.75 µm"],  # from the first line to the last one
        ["dx = 0,5 µm; dy = 0,25 µm"],
        ["Width (µm): 5", "Height (µm): 2", "Image size: 10 x 8 pixels", "Scan size: 5 µm"],
        ["Pixel size (µm): 0.5 x 0.25", "Resolution: 0.35 µm"],
        ["Scan size: 5x2 µm", "Resolution: 10 x 8"],
        ["Image size, 5 µm × 2 µm"],
        ["Pixel size: 0.5 by 0.25 µm", "Field of view: 5; 2 µm"],
        ["Pixel size: 0.5, 0.25 µm", "Z scale: 1"],
        ["Pixel size: 0.5 µm / 0.25 µm", "Z scale: 300 nm"],
        ["Pixel size: 0.5 µm 0.25 µm"],
        ["Point spacing: 0.5 µm", "Line spacing: 0.25 µm", "Camera pixel size: 6.5 µm"],
        ["X size: 5 µm", "Height: 2 µm", "Z inverted: no", "Bad pixels: 7"],
        ["dx: 0.5 µm +/- 0.01 µm", "dy: 0.25 µm"],
        ["Pixel size X: 0.5 µm", "Pixel size Y: 0.25 µm", "X range: 0 .. 5 µm"],
        ["幅： 5 µm", "高さ： 2 µm"],
        ["X Amplitude: 5000nm", "Y Amplitude: 2000nm", "Lens resolution: 0.35 µm"],
    ],
)
def test_statements_that_agree_are_used(read, lines):
    height = read("\n".join([*lines, "Z unit: nm"]) + "\n" + table(ONE))
    assert_heights(height, ONE[::-1])


@pytest.mark.parametrize(
    "line",
    ["dz: 0.01", "Z resolution: 0.01 nm", "Vertical step = 0.01 nm", "1 count = 0.01 nm", "Z-Faktor 0,01"],
)
def test_a_factor_that_is_not_understood_is_asked_about_above_counts(read, refused, line):
    text = f"{line}\nZ unit: nm\n" + table(np.round(100 * ONE))
    refused(text, f"line 1 says '{line}', and all heights are whole numbers.*'Z factor'", **GIVEN)
    assert_heights(read(text.replace("Z unit: nm", "Z factor: 0.01 nm"), **GIVEN), np.round(ONE[::-1], 2))
    assert "line 1" not in notes(read(f"{line}\n" + table(ONE), **GIVEN))
    read("Photon counts: 30\nBit resolution: 16\n" + table(np.round(100 * ONE)), **GIVEN)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("Bad pixel: -9", "line 1 says 'Bad pixel: -9', and there are 2 points .* give missing_value"),
        ("Fehlwert -9", "2 points with that height"),
        ("Z inverted: yes", "'Z inverted: yes', which is not followed: check first_row, the sign"),
        ("Origin: bottom left", "which is not followed"),
        ("Data: Deflection", "which is not followed"),
        ("Binning: 2x2", "'Binning: 2x2', which is not followed: check the steps dx and dy"),
        ("Pixel size: 0.5 µm\nAspect ratio: 2", "line 2 .* which is not followed: check the steps"),
        ("Spacing: 0.5 µm", "line 1 says 'Spacing: 0.5 µm': taken as the step along x and along y"),
        ("Channel: Phase", "channel 'Phase' is read as heights, which by its name it does not hold"),
    ],
)
def test_statements_that_are_not_understood_are_said(read, line, words):
    heights = np.where(np.arange(80).reshape(8, 10) % 41 == 3, -9, ONE)
    height = read(f"{line}\n" + table(heights), **GIVEN)
    assert re.search(words, notes(height))
    assert_heights(height, heights[::-1])
    assert not re.search(
        "not followed|that height|taken as",
        notes(read("Bad pixels: 3\nInverted: no\nBinning: 1\nPixel size: 0.5 µm\n" + table(ONE), **GIVEN)),
    )


@pytest.mark.parametrize(
    "heading",
    ["rho;phi;z", "theta (deg);z (nm)", "Frequency;z", "Time;z", "Zeit (s);Höhe (nm)", "Load;Depth"],
)
def test_columns_of_other_quantities_are_no_positions(refused, heading):
    columns = grid(ONE) if heading.count(";") == 2 else (X, ONE[0])
    refused(heading + "\n" + table(*columns, separator=";"), "which of the . columns|give dx", **NM)


@pytest.mark.parametrize("name", ["z*1000", "z x10^-3", "-z", "Ra", "Amplitude", "z inverted"])
def test_a_heading_of_changed_or_other_heights_is_said(read, name):
    height = read(f"x (µm);{name} (nm)\n" + table(X, ONE[0], separator=";"))
    assert f"the heights are those of the column '{name}', as they are" in notes(height)


def test_empty_columns_beside_a_matrix_are_said(read):
    text = "".join(";" + line for line in table(ONE, separator=";").splitlines(keepends=True))
    height = read(text, **GIVEN)
    assert_heights(height, ONE[::-1])
    assert "1 column of empty cells beside the table is left out" in notes(height)


def test_a_heading_that_contradicts_the_positions_is_said(read, refused):
    said = notes(read("dx: 2 µm\nx (µm);z (nm)\n" + table(X, ONE[0], separator=";")))
    assert "line 1 says 'dx: 2 µm'" in said
    assert "the positions are used" in said
    for line, words in (
        ("Z unit: µm", "'µm'"),
        ("Z factor: 0.1", "a factor"),
        ("Z factor: 1 µm", "a factor"),
    ):
        text = f"{line}\nx (µm);z (nm)\n" + table(X, ONE[0], separator=";")
        refused(text, f"a column is in 'nm', and the header says {words}")


def test_a_marker_of_the_header_is_none_of_positions(read):
    heights = np.where(np.arange(10) == 3, 0, ONE[0])
    height = read("NODATA: 0\nx (µm);z (nm)\n" + table(X, heights, separator=";"))
    assert_heights(height, np.where(heights == 0, np.nan, heights)[None])


# ---------------------------------------------------------------- positions beside a matrix


def test_positions_without_a_corner(read, refused):
    text = " ".join(f"{x:g}" for x in X) + "\n" + table(Y, ONE, separator=" ")
    assert_heights(read(text, **NM), ONE)
    closed = "y/x\t" + (table(X[None]) + table(Y, ONE)).replace("\n", "\t\n")
    assert_heights(read(closed, **NM), ONE)
    assert_heights(read(closed.replace("\t\n", "\n", 1), **NM), ONE)
    rows = [["y/x", *(f"{x:.3f}" for x in X)]] + [
        [f"{y:.3f}", *(f"{z:.6f}" for z in line)] for y, line in zip(Y, ONE, strict=True)
    ]
    german = "\n".join(";".join(row) for row in rows).replace(".", ",")
    assert_heights(read(german, **NM), ONE)
    refused(text.replace("1.5", "9", 1), "line 1 has 10 numbers where the others have 11", **NM)
    uneven = "the first row of the table, from line 1 on, holds positions that are not even"
    refused(text.replace("1.5", "1.9", 1), uneven, **NM)
    refused("\t" + table(np.r_[9, Y**2], np.vstack([X, ONE]))[2:], uneven.replace("row", "column"), **NM)


def test_empty_rows_above_and_below_a_table_are_said(read):
    empty = "\t" * 9 + "\n"
    assert "3 lines of empty cells beside the table are left out" in notes(
        read(empty + table(ONE) + 2 * empty, **GIVEN)
    )
    assert "empty cells" not in notes(read("\n" + table(ONE) + "\n\n", **GIVEN))


def test_positions_and_steps_of_the_user_that_differ_are_said(read):
    text = "\t" + table(np.r_[9, Y / 1e3], np.vstack([X / 1e3, ONE]))[2:]
    assert "dx = 5e-07 m as given by the user, where the file says 5e-10 m" in notes(read(text, **GIVEN))
    counted = table(np.tile(np.arange(10), 8), np.repeat(np.arange(8), 10), ONE.ravel())
    for names in ("", "X\tY\tValue\n"):
        assert "count from 0 on: if they number the points, give dx and dy" in notes(
            read(names + counted, **NM)
        )
    assert_heights(read(counted, **GIVEN), ONE)


def test_positions_in_the_first_row_or_column_alone(read, refused):
    first_row, first_column = table(np.vstack([X, ONE])), table(Y, ONE)
    assert_heights(read(first_row, **GIVEN), ONE[::-1])
    assert_heights(read(first_row, dy=0.25, **NM), ONE[::-1])
    refused(first_row, "give dy, unit", **NM)
    assert_heights(read(first_column, **GIVEN), ONE)
    header = "Width: 5 µm\nHeight: 2 µm\nZ unit: nm\n"
    assert_heights(read(header + first_row), ONE[::-1])
    refused(
        header.replace("5", "50") + first_row,
        r"taken as positions along x: line 4 says .*, line 1 says 'Width",
    )
    assert read("nx: 10\nny: 9\n" + first_row, **GIVEN).shape == (9, 10)
    assert "may be positions along x" in notes(read("nx: 10\nny: 9\n" + first_row, **GIVEN))


def test_a_column_of_positions_beside_few_others_is_asked_about(refused):
    refused(table(X, *ONE[:3]), r"first of 4 columns holds positions: of 3 profiles.*or .* a map", **NM)
    refused("dx: 0.5 µm\n" + table(X, *ONE[:3]), "holds positions: of 3 profiles", **NM)


def test_lines_of_a_tilted_plane_are_heights(read):
    plane = np.add.outer(0.3 * np.arange(8), 0.2 * np.arange(10))
    height = read(table(plane), **GIVEN)
    assert height.shape == (8, 10)
    assert "positions" not in notes(height)
    assert_heights(read(table(np.vstack([X, plane])), **GIVEN), plane[::-1])
