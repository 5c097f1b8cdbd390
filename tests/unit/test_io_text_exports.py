"""Text as programs and spreadsheets export it: headings, units, counts, empty cells, lines cut off."""

import re
from itertools import product

import numpy as np
import pytest
from measured_files import GIVEN, cells, holds, points, refuses, saved, steps, warnings_of
from shared_data import DATA

from roughcontact import InputFileError, inspect_file, read_height_map
from roughcontact.io.text import columns, header

NUMBER = np.arange(12)
X = 0.5 * NUMBER
Z = np.array([1.5, -2.25, 3.0, 0.5, 4.0, 5.5, -6.75, 7.0, 0.25, 9.0, 10.5, -1.0])
GRID = np.multiply.outer(range(3), range(4))
UM = {"unit": "um"}
MORE = DATA.parent / "more_data"


def trace(separator=";", columns=(X, Z)):
    return cells(np.column_stack(columns), separator)


def assert_trace(height):
    holds(height, 1e-6 * Z[None], rtol=1e-14)
    np.testing.assert_allclose(height.x, 1e-3 * X, rtol=1e-12)


@pytest.mark.parametrize(
    ("encoding", "headings"),
    [
        *((code, "Messweg [mm];Höhe [µm]") for code in ("utf-8", "utf-8-sig", "utf-16", "utf-16-le")),
        *((code, "Messweg [mm];Höhe [µm]") for code in ("utf-16-be", "latin-1", "cp437")),
        ("gb18030", "位置 [mm];高度 [μm]"),
        ("cp932", "位置 [ミリメートル];高さ [μm]"),
        ("cp949", "위치 [mm];높이 [㎛]"),
        ("cp1251", "Положение [мм];Высота [мкм]"),
        ("cp1250", "Położenie [mm];Wysokość [µm]"),
    ],
)
def test_headings_of_a_spreadsheet_in_each_encoding(read, encoding, headings):
    text = f"{headings}\n" + trace().replace(".", ",") + ";\n;\n"
    assert_trace(read(text.replace("\n", "\r\n"), encoding=encoding))


@pytest.mark.cases
@pytest.mark.parametrize("has_second", [False, True])
def test_optical_profilers_in_six_languages(read, encoding, words, has_second):
    """Pixel, numbers of points and unit above a titled table, perhaps with a second one below."""
    step, columns, rows, unit, height, light = words.split(";")
    head = [f'"{step}","0.5","μm"', f'"{columns}","4"', f'"{rows}","3"', f'"{unit}","μm"', "", f'"{height}"']
    head = [line.replace("μ", "µ") if encoding == "cp1252" else line for line in head]
    table = [",".join(f'"{value}"' for value in row) for row in GRID + 0.5]
    lines = [*head, *table, *["", f'"{light}"', *table][: len(table) * 2 * has_second]]
    height = read("\r\n".join(lines) + "\r\n", encoding=encoding)
    holds(height, 1e-6 * (GRID[::-1] + 0.5), 0.5e-6, 0.5e-6, rtol=1e-12)


@pytest.mark.parametrize(
    "lines",
    [
        [
            '"","V1","V2","V3","V4","V5","V6","V7","V8"',
            *(f'"{j}",1,2,4,5,7,6,2,{j * j}' for j in range(1, 12)),
        ],
        ["V1 V2 V3 V4 V5 V6 V7 V8", *(f"{j} 1 2 4 5 7 6 2 {j * j}" for j in range(1, 12))],
    ],
)
def test_a_matrix_of_r_has_numbered_rows_and_columns(read, lines):
    height = read("\n".join(lines) + "\n", **GIVEN)
    holds(height, 1e-6 * np.array([[1, 2, 4, 5, 7, 6, 2, j * j] for j in range(11, 0, -1)]))
    assert "is taken as numbers or positions, and left out" in warnings_of(height)


def test_the_distances_of_a_sensor_above_a_stage_are_heights(read):
    assert_trace(read("位置 (mm);距离 (μm)\n" + trace(), encoding="gb18030"))


@pytest.mark.parametrize(
    ("header", "rows"),
    [
        ("z in µm", "0 1 start; 1 2 ; 2 3 "),
        ("z in µm\nNODATA;1e30", "0 1 ok; 1 2 ok; 2 3 ok;;EOF"),
        ("z in µm", "0 1 ok;;1 2 ok;;2 3 ok"),
    ],
    ids=["three words", "a marker alone", "gaps"],
)
def test_a_column_of_words_takes_nothing_else_along(read, header, rows):
    height = read(header + "\n" + rows.replace(";", "\n"), unit="mm")
    holds(height, 1e-6 * np.array([[1.0, 2.0, 3.0]]), rtol=1e-12)
    assert "column 3" in warnings_of(height)


def test_a_first_row_that_begins_with_a_missing_point_is_a_row(read):
    height = read("NaN;-2,44;3,1;0,5\n-3,25;2,18;1,5;2\n", **GIVEN)
    holds(height, 1e-6 * np.array([[-3.25, 2.18, 1.5, 2], [np.nan, -2.44, 3.1, 0.5]]), rtol=1e-12)


@pytest.mark.cases
def test_a_column_of_heights_may_begin_with_missing_points(read, text):
    height = read(text, **GIVEN)
    holds(height, 1e-6 * np.array([[np.nan, np.nan, 1.5, 2.5, 3]]), rtol=1e-12)


@pytest.mark.parametrize("x", [0, 5])
def test_a_profile_may_begin_with_a_point_without_a_height(read, x):
    height = read(f"Operator: X\nx [mm];z [µm]\n{x};\n{x + 1};1.5\n{x + 2};2.5\n{x + 3};3\n")
    holds(height, 1e-6 * np.array([[np.nan, 1.5, 2.5, 3]]), 1e-3, rtol=1e-12)


def test_a_wave_of_igor_has_x_along_its_rows(read, refusal):
    head = "IGOR\nWAVES/D/N=(5,4)\th\nBEGIN\n"
    tail = 'END\nX SetScale/P x 0,2e-6,"m", h; SetScale/P y 0,1,"um", h; SetScale d 0,0,"nm", h\n'
    heights = np.arange(20.0).reshape(4, 5) ** 2
    holds(read(head + cells(heights.T) + tail), 1e-9 * heights, 2e-6, 1e-6, rtol=1e-12)
    refusal(head + cells(heights.T).replace("\t1\n", "\n") + "1\n" + tail, "a damaged Igor text")
    profile = 'IGOR\nWAVES/D h\nBEGIN\n{}END\nX SetScale/P x 0,2e-6,"m", h; SetScale y 0,0,"nm", h\n'
    holds(read(profile.format(cells(heights[:1].T))), 1e-9 * heights[:1], 2e-6, rtol=1e-12)


def test_an_empty_quoted_cell_at_the_end_of_a_file_is_a_missing_point(read):
    rows = '"1","2","3","4"\n' * 3 + '"5","6","7",""\n'
    holds(read(f'"Height"\n{rows}', **GIVEN), 1e-6 * np.array([[5, 6, 7, np.nan], *[[1, 2, 3, 4]] * 3]))


@pytest.mark.parametrize(
    ("footer", "noted"),
    [
        *((word, "") for word in ("EOF", "*** End of data ***", "-- Ende --", "结束", "# Ra = 0.25")),
        ("Ra;0,25;µm\nMean: 3,5", r"below the table, line 14 ('Ra;0,25;µm') and 1 line more is left out"),
        ("Total points: 12", ""),
        ("Total points: 13", "line 14 ('Total points: 13')"),
    ],
)
@pytest.mark.parametrize("line_end", ["", "\n"])
def test_lines_below_a_table_are_left_out_and_said(read, refusal, footer, noted, line_end):
    height = read(f"x [mm];z [µm]\n{trace()}{footer}{line_end}")
    assert_trace(height)
    assert noted in warnings_of(height)
    assert bool(noted) == ("below the table" in warnings_of(height))
    refusal(f"x [mm];y [mm];z [µm]\n{trace(columns=(X, X, Z))}6;over;2.5;2.5\n{footer}", "no row of numbers")


@pytest.mark.parametrize("sign", [" ", "'", "\u00a0", "\u202f", "’"])
@pytest.mark.parametrize("separator", [";", "\t"])
def test_separators_of_thousands_that_are_no_decimal_sign(read, sign, separator):
    heights = 1000 * Z
    table = "".join(f"{x:g}|{z:,.2f}\n".replace(",", sign) for x, z in zip(X, heights, strict=True))
    assert_trace(read("x [mm]|z [µm]\n".replace("|", separator) + table.replace("|", separator)) / 1000)
    quoted = "".join(f'"{x:g}","{z:,.2f}"\n' for x, z in zip(X, heights, strict=True))
    assert_trace(read(f'"x [mm]","z [µm]"\n{quoted}') / 1000)
    german = "".join(f"{x:g};{z:,.2f}\n".replace(".", "|") for x, z in zip(X, heights, strict=True))
    german = german.replace(",", ".").replace("|", ",")
    assert_trace(read(f"x [mm];z [µm]\n{german}") / 1000)


def test_a_semicolon_begins_a_remark_above_rows_without_it(read):
    assert_trace(read("; mirror M1\n; 1301\n" + trace(" "), unit="mm", height_unit="um"))
    holds(read(";1;2\n;3;4\n", **GIVEN), [[3e-6, 4e-6], [1e-6, 2e-6]])


def test_the_end_of_a_file_of_dos_and_a_blank_line_without_end(read):
    assert_trace(read("x (mm);z (µm)\n" + trace() + "\x1a", encoding="cp1252"))
    assert_trace(read("x (mm)  z (µm)\n" + trace(" ") + "   "))


@pytest.mark.cases
def test_units_of_headings_in_both_orders(read, heading):
    assert_trace(read(f"made on Monday\n{heading}\n" + trace(";" if ";" in heading else "   ")))


@pytest.mark.parametrize(
    ("heading", "columns"),
    [
        ("index,x in mm,y in µm", (NUMBER, X, Z)),
        ("Nr.,Weg (mm),Höhe (µm)", (NUMBER + 1, X, Z)),
        (",x (mm),z (µm)", (NUMBER, X, Z)),
        ("z (µm),x (mm)", (Z, X)),
        ("x (mm),z (µm)", (X[::-1], Z[::-1])),  # falling positions
        ("y [mm];z [µm]", (X, Z)),
        ("距離（mm）；高さ（µm）", (X, Z)),
        ("Counter;Altitude (µm);Encoder (mm)", (NUMBER + 37, Z, X)),
        ("Zeit (s);Weg (mm);Höhe (µm)", (3 * X, X, Z)),
    ],
)
def test_columns_of_a_profile_by_their_names(read, heading, columns):
    assert_trace(read(heading + "\n" + trace("," if "," in heading else ";", columns)))


@pytest.mark.parametrize(
    ("heading", "columns"),
    [
        ("z (µm);y (mm);x (mm)", (Z, NUMBER // 4, NUMBER % 4)),
        ("x (mm);y (mm);z (µm);quality", (NUMBER % 4, NUMBER // 4, Z, 0 * Z)),
        ("no;x (mm);y (mm);z (µm)", (NUMBER, NUMBER % 4, NUMBER // 4, Z)),
    ],
)
def test_columns_of_points_by_their_names(read, heading, columns):
    height = read(heading + "\n" + trace(columns=columns))
    holds(height, 1e-6 * Z.reshape(3, 4), rtol=1e-14)
    np.testing.assert_allclose(height.x, 1e-3 * np.arange(4), atol=1e-15)
    np.testing.assert_allclose(height.y, 1e-3 * np.arange(3), atol=1e-15)


def test_quoted_cells_with_decimal_commas(read):
    rows = cells(zip(X, Z, strict=True), ";", '"{:g}"').replace(".", ",").replace(";", ",")
    assert_trace(read('"x","z"\n"mm","um"\n' + rows))


def test_empty_cells_around_a_table(read, refusal):
    text = trace().replace("\n", ";" * 300 + "\n") + (";" * 302 + "\n") * 2000
    assert_trace(read(text, unit="mm", height_unit="um"))
    assert_trace(read(";x (mm);z (µm)\n;" + trace().replace("\n", "\n;")[:-1]))
    # an empty cell within the table is a missing point, also the last one of a row
    height = read("1;2;3;4\n5;6;7;\n;8;9;1\n", **GIVEN)
    np.testing.assert_array_equal(np.argwhere(np.isnan(height.values[::-1])), [[1, 3], [2, 0]])
    closed = read("0,500\t2\t9.91E+37\t\n5\t6\t\t\n", **GIVEN)
    np.testing.assert_array_equal(np.isnan(closed.values), [[False, False, True]] * 2)
    # but where the last line alone ends so, it is incomplete
    refusal("1;2;3;4\n5;6;7;8\n9;8;7;", "the last line is incomplete", **GIVEN)


@pytest.mark.parametrize(
    "words", ["Width Height", "Breite Höhe", "Largeur Hauteur", "Larghezza Altezza", "Ширина Высота"]
)
@pytest.mark.parametrize("columns", [2, 3])
def test_a_header_with_the_size_wins_over_the_number_of_columns(read, words, columns):
    heights = np.random.default_rng(columns).normal(size=(12, columns))
    header = "# {}: 30,0 µm\n# {}: 60,0 µm\n# Value units: nm\n".format(*words.split())
    height = read(header + cells(heights, " ", "{:.9f}").replace(".", ","))
    holds(height, 1e-9 * np.round(heights, 9)[::-1], 30e-6 / columns, 5e-6)
    assert height.attrs["first_row"] == "top"


def test_a_list_of_points_below_a_header_with_the_size_stays_one(read):
    holds(read("# Width: 4 µm\n# Height: 3 µm\n" + cells(points(GRID), " "), unit="um"), 1e-6 * GRID)


THREE = [[1.5, 2.5, 3.5], [4.5, 5.5, 6.5], [1.25, 7.5, 9.5], [0.5, 2.5, 3.5]]


@pytest.mark.parametrize("rows", [THREE, THREE[:1] * 4])
def test_three_columns_are_a_map_where_a_line_counts_them(tmp_path, rows):
    text, given = cells(rows).replace(".", ","), {"dx": 2, "dy": 3, "unit": "um", "height_unit": "nm"}
    height = read_height_map(saved(tmp_path, "nx: 3\n" + text), **given)
    holds(height, 1e-9 * np.array(rows)[::-1], 2e-6, 3e-6)
    assert height.attrs["first_row"] == "top"
    refuses("of a map a line above says 'nx: 3'|have the same position", saved(tmp_path, text), **given)


def test_one_height_in_each_line_is_a_profile(tmp_path):
    path = saved(tmp_path, cells(Z[:, None]))
    contents = inspect_file(path)
    assert "give dx, unit" in contents["problem"]
    assert (contents["channels"][0]["ny"], contents["channels"][0]["nx"]) == (1, 12)
    holds(read_height_map(path, dx=0.5, unit="mm", height_unit="um"), 1e-6 * Z[None], rtol=1e-14)
    assert read_height_map(path, dx=0.5, dy=1, unit="mm").shape == (1, 12)


# a text that states how many points it has, and what is given; the same with another number or fewer rows
PROFILE, MATRIX, LIST = trace(" "), "1 2 3 5\n" * 3, cells(points(GRID), " ")
NUMBERED, SIZED = "mm µm\n{}\n" + PROFILE, "nx: 4\nny: 3\n" + LIST
STATED = [
    (
        NUMBERED.format(12),
        {},
        NUMBERED.format(13),
        "the file says 13 points, the table has 12 rows of 2 numbers; it was cut",
    ),
    (f"samples: 12\n{PROFILE}", UM, f"samples: 13\n{PROFILE}", "13 columns.* 12"),
    (f"4 3\n{MATRIX}", GIVEN, f"4 3\n{MATRIX[8:]}", "4 and 3.* 2 rows of 4"),
    (SIZED, UM, SIZED[:-24], "the header says 3 rows, the points make 2; it was cut off"),
]


@pytest.mark.parametrize(("right", "options", "wrong", "words"), STATED, ids=[words for *_, words in STATED])
def test_a_declared_number_of_points_is_compared(read, refusal, right, options, wrong, words):
    assert read(right, **options).shape == ((1, 12) if PROFILE in right else (3, 4))
    refusal(wrong, words, **options)


def matrix(rows, columns, width, height):
    heights = np.random.default_rng(rows).normal(size=(rows, columns))
    header = f"# Width: {width} µm\n# Height: {height} µm\n# Value units: nm\n"
    return header + cells(heights, form="{:.4f}")


@pytest.mark.cases
def test_a_matrix_of_lost_lines_is_refused(refusal, rows, columns, width, height):
    refusal(matrix(rows, columns, width, height), "give dx, dy and unit")


@pytest.mark.cases
def test_pixels_of_any_shape_are_read(read, rows, columns, width, height):
    height_map = read(matrix(rows, columns, width, height))
    assert height_map.shape == (rows, columns)
    assert steps(height_map)[1] == pytest.approx(1e-6 * float(height) / rows)


def test_positions_rounded_to_their_last_digit_are_even(read, refusal):
    x = 0.15625 * np.arange(400)
    rows = "".join(f"{a:.1f},{np.sin(a):.5f},,\n" for a in x)
    height = read("Lateral um,Raw Micrometer,\n" + rows)
    assert steps(height) == pytest.approx([0.15625e-6], rel=1e-4)
    assert "even up to the rounding" in warnings_of(height)
    gaps = np.delete(np.arange(400), np.random.default_rng(2).integers(1, 399, 60))
    refusal(cells(zip(gaps, gaps % 7, strict=True), " "), "not evenly spaced", unit="um")


def test_an_export_of_a_laser_microscope(read):
    header = (
        '"Model","VK-X1000"\n"Output image data","Height"\n"XY calibration","692.3","nm/pixel"\n'
        '"Horizontal","4"\n"Vertical","3"\n"Unit","um"\n"Height"\n'
    )
    heights = 1e-6 * np.array([[1.5, 2.5, 3.5, 4.75]] * 3)
    holds(read(header + '"1.5","2.5","3.5","4.75"\n' * 3), heights, 692.3e-9, 692.3e-9)


@pytest.mark.parametrize("form", ["{:.2f}", "{:.5e}", "{:.4f}"])
@pytest.mark.parametrize("columns", [5, 1])
def test_a_file_that_ends_within_a_number_is_refused(read, refusal, form, columns):
    heights = np.random.default_rng(2).normal(size=(6, columns)) + 5
    if columns == 1:
        heights = np.column_stack([np.arange(6), heights])
    text = cells(heights, " ", form)
    options = GIVEN if columns > 1 else {"unit": "um"}
    for text_read in (text, text[:-1], text[: text.rindex(" ")] + " NaN"):
        assert read(text_read, **options).size == 6 * columns
    for stop in range(text.rindex(" ") + 2, len(text) - 1):
        words = rf"line 6 ends the file in '{re.escape(text[text.rindex(' ') + 1 : stop])}'.*it was cut off"
        refusal(text[:stop], words, **options)


def test_a_last_number_shorter_than_all_others_is_doubted(read):
    text = "1.5 2.25 3 4.25\n0.25 3.125 1 4.75\n2 5.5 0 60.5\n3 7.5 1 8.25\n4 9 1 1.25"
    assert "ends the file" not in warnings_of(read(text, **GIVEN))
    cut = warnings_of(read(text[:-2], **GIVEN))
    assert "line 5 ends the file in '1.', without the end of a line: if the file was cut off" in cut
    assert "ends the file" not in warnings_of(read(text[:-2] + "\n", **GIVEN))


@pytest.mark.parametrize("line_end", ["", "\n", "\n\n", "\n  ", "\n\n \t"])
def test_blank_lines_between_the_last_rows_and_at_the_end(read, line_end):
    """As of gnuplot's blocks; the last line may have no end."""
    heights = np.arange(1.0, 9.0).reshape(4, 2) / 8
    rows = cells(points(heights), " ", "{:.3f}").splitlines(keepends=True)
    text = "x (um)  y (um)  z (um)\n" + "\n".join("".join(rows[start : start + 2]) for start in (0, 2, 4, 6))
    holds(read(text.rstrip("\n") + line_end), 1e-6 * heights)


def test_a_line_of_many_entries_is_looked_at_once(read, monkeypatch):
    calls = []
    cells_of = columns._cells
    monkeypatch.setattr(columns, "_cells", lambda *arguments: calls.append(1) or cells_of(*arguments))
    line = "dx = 1 um, " * 50_000
    assert read(f"{line}\n{cells(GRID)}", **GIVEN).shape == (3, 4)
    assert len(calls) < 100


def test_lines_that_repeat_others_are_compared_once(read, monkeypatch):
    calls = []
    agree = header._agree
    monkeypatch.setattr(header, "_agree", lambda *arguments: calls.append(1) or agree(*arguments))
    lines = "Width: 4 um\nHeight: 3 um\ndx = 1 um\n" * 300
    assert read(f"{lines}{cells(GRID)}", height_unit="um").shape == (3, 4)
    assert len(calls) < 2000  # of 90 000 pairs
    with pytest.raises(InputFileError, match="line 902 says 'Width: 5 um': they do not agree for 4 columns"):
        read(f"{lines}\nWidth: 5 um\n{cells(GRID)}", height_unit="um")


@pytest.mark.shared_data
@pytest.mark.cases
def test_real_exports(name, shape, step):
    height = read_height_map(MORE / name)
    assert height.shape == shape
    assert steps(height)[0] == pytest.approx(step, rel=1e-4)
    if name == "dektak-1.csv":  # as SurfaceTopography reads it
        assert 1e6 * float(height.std()) == pytest.approx(4.764, abs=5e-4)


@pytest.mark.shared_data
def test_a_real_export_of_uneven_positions():
    refuses("resample = linear", MORE / "xy-2.txt")
    height = read_height_map(MORE / "xy-2.txt", resample="linear")
    assert 1e-5 < float(height.x[0]) < float(height.x[-1]) < 4.3e-5


@pytest.mark.parametrize("heading", ["Height(nm)", "# Height Sensor [nm]", '"Z (nm)"'])
def test_a_heading_above_a_matrix_gives_the_unit_of_its_heights(read, heading):
    heights = np.arange(20.0).reshape(4, 5) ** 2
    headed = read(f"made on Monday\n{heading}\n{cells(heights, ' ')}", **GIVEN)
    holds(headed, 1e-9 * heights[::-1], rtol=1e-14)
    sized = read(f"Width: 5 mm\nHeight: 4 mm\n{cells(heights, ' ')}", height_unit="um")
    holds(sized, 1e-6 * heights[::-1], rtol=1e-14)


def test_the_text_export_of_a_binary_format_is_read_as_text(read):
    head = "\\*File list\n\\Version: 0x09200201\n\\*Ciao image list\n\\Data offset: 80\n\\Data length: 40\n"
    height = read(f"{head}Height(nm)\n" + "1.5 2.5 3.5 4.5\n" * 5, **GIVEN)
    holds(height, 1e-9 * np.array([[1.5, 2.5, 3.5, 4.5]] * 5))
    head = "WSxM file copyright UAM\nWSxM ASCII XYZ file\n"
    for separator in ("\t", "\t\t"):
        heading = separator.join(["X[nm]", "Y[nm]", "Z[nm]\n\n"])
        holds(read(head + heading + cells(points(GRID, 10, 10), separator)), 1e-9 * GRID, 10e-9, 10e-9)


DATES = ["2026-11-30", "30.11.2026", "11/30/2026", "2026-11-30 08:30:{:02d}", "2026/11/30T08:30:{:02d}.25"]
LABELS = ["Row {}", "Zeile_{}", "y{}", "12:00:0{}", "2026-11-2{} 08:30:00.5"]


@pytest.mark.parametrize(("label", "separator"), [*product(LABELS, ";\t,"), *product(DATES, ";\t, ")])
def test_labels_and_dates_in_front_of_rows_are_left_out_and_said(read, label, separator):
    rows = [separator.join([label.format(row), *map(str, numbers)]) for row, numbers in enumerate(GRID)]
    height = read("\n".join(["Rows: 3", *rows]), **GIVEN, height_unit="nm")
    holds(height, 1e-9 * GRID[::-1], 1e-6, 1e-6)
    first_word = label.format(0) if separator != " " else label.format(0).split()[0]
    assert f"column 1 ('{first_word}') holds words and is left out" in warnings_of(height)


def test_dates_of_digits_alone_are_no_heights(read):
    table = np.round(np.random.default_rng(4).normal(size=(5, 7)), 3)
    table[:4, 6] = np.nan  # a column that is nearly empty stays
    rows = ["\t".join(["20261130", *("" if z != z else f"{z}" for z in line)]) for line in table]
    height = read("\n".join(["dx: 1 µm", "dy: 1 µm", "Z unit: nm", *rows]) + "\n")
    holds(height, 1e-9 * table[::-1], 1e-6, 1e-6, rtol=1e-12)
    assert "column 1 ('20261130') holds dates and is left out" in warnings_of(height)
    profile = "".join(f"20261130;{x};{z}\n" for x, z in zip(X, Z, strict=True))
    assert_trace(read(profile, unit="mm", height_unit="um"))


@pytest.mark.parametrize("date", [*DATES, "20261130"])
@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("is_first", [True, False])
def test_dates_beside_a_profile(read, date, separator, is_first):
    names, rows = ["Date", "x [mm]", "z [µm]"], [[f"{x}", f"{z}"] for x, z in zip(X, Z, strict=True)]
    lines = [names, *([date.format(number), *row] for number, row in enumerate(rows))]
    assert_trace(
        read("\n".join(separator.join(line if is_first else [*line[1:], line[0]]) for line in lines) + "\n")
    )


def test_the_label_of_the_unit_of_y_is_that_of_the_heights_of_labview(read):
    head = "LabVIEW Measurement\nY_Unit_Label\tnm\t\nX_Unit_Label\tm\t\nX_Value\tHeight\n"
    holds(read(head + trace("\t", (1e-6 * X, Z))), 1e-9 * Z[None], 0.5e-6, rtol=1e-14)


def test_labelled_parameters_above_a_table_are_no_rows(read):
    markers = "Marker 1;0.5;1.5\nMarker 2;1.5;2.5\n"
    assert_trace(read(f"{markers}x [mm];z [µm]\n{trace()}"))


def test_the_time_of_day_beside_a_profile(read):
    stamps = [f"12:00:{row:02d}.25;{x};{z}" for row, (x, z) in enumerate(zip(X, Z, strict=True))]
    assert_trace(read("\n".join(["Zeit;Weg [mm];Höhe [µm]", *stamps])))


def test_the_units_of_both_axes_in_the_corner(read, refusal):
    heights = np.arange(20.0).reshape(4, 5) ** 2
    table = cells(np.column_stack([0.25 * np.arange(4), heights]))
    text = "\t" + "\t".join(f"{0.5 * column}" for column in range(5)) + "\n" + table
    for corner in ("Y[µm]\\X[µm]", "y (µm) / x (µm)", "Zeile/Spalte [µm]"):
        holds(read(f"Z unit: nm\n{corner}{text}"), 1e-9 * heights, 0.5e-6, 0.25e-6)
    for corner in ("X[µm]\\Y[µm]", "Y[µm]\\X[mm]", "y (µm)"):
        refusal(f"Z unit: nm\n{corner}{text}", "does not say its lateral unit")


def test_a_row_of_empty_cells_is_one_of_as_many_as_are_stated(read, refusal):
    first, second, third = cells(GRID, ",").splitlines()
    text = f"{first}\n,,,\n{second}\n{third}"
    heights = np.insert(GRID.astype(float), 1, np.nan, axis=0)
    holds(read(f"Rows: 4\n{text}", **GIVEN, height_unit="nm"), 1e-9 * heights[::-1])
    refusal(text, "a second table begins at line 3; .* or write NaN where a row is missing", **GIVEN)


def test_blanks_between_thousands_beside_commas_between_cells(read):
    rows = "".join(
        f"{x:.1f},{z:,.1f}\n".replace(",", " ").replace(" ", ",", 1)
        for x, z in zip(X, 4e3 + 1e3 * Z, strict=True)
    )
    height = read("x (mm),z (nm)\n" + rows)
    holds(height, 1e-9 * (4e3 + 1e3 * Z[None]), 0.5e-3)


@pytest.mark.parametrize("form", ["{} resolution,{},µm", "{}-Auflösung: {} µm/px", "Resolution {} (µm): {}"])
def test_the_resolution_along_each_axis_is_its_step(read, form):
    lines = [form.format(*each) for each in (("X", 0.5), ("Y", 0.25))]
    text = "\n".join(["Z unit: nm", *lines, cells(GRID, ",")])
    holds(read(text), 1e-9 * GRID[::-1], 0.5e-6, 0.25e-6)
    read(text.replace("µm/px", "").replace(",µm", "").replace("µm", ""), **GIVEN)  # of the lens, or points
