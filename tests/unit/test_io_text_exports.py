"""Text as programs and spreadsheets export it: headings, units, counts, empty cells, lines cut off."""

import json
import re

import numpy as np
import pytest
from measured_files import GIVEN, refuses, saved, steps, warnings_of
from shared_data import DATA

from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map

X = 0.5 * np.arange(12)
Z = np.array([1.5, -2.25, 3.0, 0.5, 4.0, 5.5, -6.75, 7.0, 0.25, 9.0, 10.5, -1.0])
MORE = DATA.parent / "more_data"


def trace(separator=";", comma=False, columns=(X, Z)):
    text = "".join(separator.join(f"{value:g}" for value in row) + "\n" for row in zip(*columns, strict=True))
    return text.replace(".", ",") if comma else text


def assert_trace(height, lateral=1e-3, vertical=1e-6):
    assert height.shape == (1, 12)
    np.testing.assert_allclose(height.values[0], Z * vertical, rtol=1e-14)
    np.testing.assert_allclose(height.x, X * lateral, rtol=1e-12)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"])
def test_headings_of_a_spreadsheet_in_german(read, encoding):
    text = "Messweg [mm];Höhe [µm]\n" + trace(comma=True) + ";\n;\n"
    assert_trace(read(text.replace("\n", "\r\n"), encoding=encoding))


@pytest.mark.parametrize(
    "heading",
    [
        "x (mm);z (µm)",
        "X_[mm];Z_[um]",
        "x/mm;z/µm",
        "x in mm;y in µm",
        "Lateral mm;Raw Micrometer",
        "mm lateral;µm height",
        "mm;um",
        "Distance;Height\nmm;um",
        "Distance;Height\nmm;um\nA;B",
        '"x (mm)";"z (µm)"',
    ],
)
def test_units_of_headings_in_both_orders(read, heading):
    assert_trace(read(f"made on Monday\n{heading}\n" + trace()))


@pytest.mark.parametrize(
    "heading", ["x (mm) z (µm)", "x in mm  z in µm", "mm µm", "# x [mm]\tz [µm]", "x z\nmm um"]
)
def test_units_of_headings_between_blanks(read, heading):
    assert_trace(read(f"{heading}\n" + trace("   ")))


def test_columns_by_their_names(read):
    number = np.arange(12)
    for heading, columns in (
        ("index,x in mm,y in µm", (number, X, Z)),
        ("Nr.,Weg (mm),Höhe (µm)", (number + 1, X, Z)),
        (",x (mm),z (µm)", (number, X, Z)),
        ("z (µm),x (mm)", (Z, X)),
    ):
        assert_trace(read(heading + "\n" + trace(",", columns=columns)))
    x, y = number % 4, number // 4
    for heading, columns in (
        ("z (µm);y (mm);x (mm)", (Z, y, x)),
        ("x (mm);y (mm);z (µm);quality", (x, y, Z, 0 * Z)),
        ("no;x (mm);y (mm);z (µm)", (number, x, y, Z)),
    ):
        height = read(heading + "\n" + trace(columns=columns))
        np.testing.assert_allclose(height.values, Z.reshape(3, 4) * 1e-6, rtol=1e-14)
        np.testing.assert_allclose(height.x, 1e-3 * np.arange(4), atol=1e-15)
        np.testing.assert_allclose(height.y, 1e-3 * np.arange(3), atol=1e-15)


def test_entries_without_quotes_above_quoted_cells(refused):
    rows = '"1.5","2.25","3.5","4.5"\n' * 4
    refused(f"Width: 1,234 µm\nHeight: 4 µm\n{rows}", "line 1 says 'Width: 1,234 µm': its mark may be")


def test_quoted_cells_with_decimal_commas(read):
    rows = "".join(f'"{x:g}","{z:g}"\n'.replace(".", ",") for x, z in zip(X, Z, strict=True))
    assert_trace(read('"x","z"\n"mm","um"\n' + rows))


def test_empty_cells_around_a_table(read, refused):
    text = trace().replace("\n", ";" * 300 + "\n") + (";" * 302 + "\n") * 2000
    assert_trace(read(text, unit="mm", height_unit="um"))
    # an empty cell within the table is a missing point, also the last one of a row
    height = read("1;2;3;4\n5;6;7;\n;8;9;1\n", **GIVEN)
    np.testing.assert_array_equal(
        np.isnan(height.values[::-1]), np.array([[0, 0, 0, 0], [0, 0, 0, 1], [1, 0, 0, 0]], dtype=bool)
    )
    closed = read("0,500\t2\t9.91E+37\t\n5\t6\t\t\n", **GIVEN)
    np.testing.assert_array_equal(np.isnan(closed.values[::-1]), [[False, False, True]] * 2)
    # but where the last line alone ends so, it is incomplete
    refused("1;2;3;4\n5;6;7;8\n9;8;7;", "the last line is incomplete", **GIVEN)


@pytest.mark.parametrize(
    ("width", "height_word"),
    [
        ("Width", "Height"),
        ("Breite", "Höhe"),
        ("Largeur", "Hauteur"),
        ("Larghezza", "Altezza"),
        ("Ширина", "Высота"),
    ],
)
@pytest.mark.parametrize("columns", [2, 3])
def test_a_header_with_the_size_wins_over_the_number_of_columns(read, width, height_word, columns):
    heights = np.random.default_rng(columns).normal(size=(12, columns))
    rows = "\n".join(" ".join(f"{value:.9f}" for value in row) for row in heights).replace(".", ",")
    header = f"# {width}: 30,0 µm\n# {height_word}: 60,0 µm\n# Value units: nm\n"
    height = read(header + rows)
    np.testing.assert_allclose(height.values[::-1], heights * 1e-9, atol=1e-18)
    assert steps(height) == pytest.approx([30e-6 / columns, 5e-6])
    assert height.attrs["first_row"] == "top"


def test_a_list_of_points_below_a_header_with_the_size_stays_one(read):
    rows = "".join(f"{i} {j} {i * j}\n" for j in range(3) for i in range(4))
    height = read("# Width: 4 µm\n# Height: 3 µm\n" + rows, unit="um")
    assert height.shape == (3, 4)
    assert float(height.max()) == pytest.approx(6e-6)


def test_three_columns_are_a_map_where_both_steps_are_given(tmp_path):
    for rows in (
        ["1,5\t2,5\t3,5"] * 4,
        ["1,5\t2,5\t3,5", "4,5\t5,5\t6,5", "1,25\t7,5\t9,5", "0,5\t2,5\t3,5"],
    ):
        path = saved(tmp_path, "\n".join(rows) + "\n")
        height = read_height_map(path, dx=2, dy=3, unit="um", height_unit="nm")
        expected = np.array([[float(cell.replace(",", ".")) for cell in row.split("\t")] for row in rows])
        np.testing.assert_allclose(height.values[::-1], 1e-9 * expected, rtol=1e-14)
        assert steps(height) == pytest.approx([2e-6, 3e-6])
        assert height.attrs["first_row"] == "top"
        assert "read as a map of 4 rows of 3, because dx and dy are given" in height.attrs["ingest_warnings"]
        refuses(r"map of 3 columns.*give dx, dy and unit", path, unit="um")


def test_steps_do_not_make_a_map_of_points_or_of_a_profile(refused):
    uneven = "".join(f"{a} {b} {a * b + 1}\n" for b in range(4) for a in (0.0, 1.0, 2.3, 3.0, 4.0))
    refused(uneven, "resample = linear", **GIVEN)
    profile = "".join(f"{a} {a * a}\n" for a in (0.0, 1.0, 2.3, 3.0, 4.0))
    refused(profile, "resample = linear", **GIVEN)


def test_an_index_without_a_name_is_doubted(refused):
    text = trace("\t", columns=(np.arange(12), X, Z))
    refused(text, "the first column counts the rows: delete it if it is no x", unit="um")


def test_one_height_in_each_line_is_a_profile(tmp_path):
    path = saved(tmp_path, "".join(f"{z:g}\n" for z in Z))
    found = inspect_file(path)
    assert "give dx, unit" in found["problem"]
    assert (found["channels"][0]["ny"], found["channels"][0]["nx"]) == (1, 12)
    height = read_height_map(path, dx=0.5, unit="mm", height_unit="um")
    np.testing.assert_allclose(height.values, Z[None, :] * 1e-6, rtol=1e-14)
    assert read_height_map(path, dx=0.5, dy=1, unit="mm").shape == (12, 1)


def test_a_count_above_the_table(read, refused):
    assert_trace(read("mm µm\n12\n" + trace(" ")))
    refused("mm µm\n13\n" + trace(" "), "the file says 13 points, the table has 12 rows; it was cut off")
    matrix = "4 3\n" + "1 2 3 5\n" * 3
    assert read(matrix, **GIVEN).shape == (3, 4)
    refused(matrix[:-8], r"4 and 3.* 2 rows of 4", **GIVEN)


def test_a_declared_number_of_points_is_compared(read, refused):
    rows = "".join(f"{i} {j} {i * j}\n" for j in range(3) for i in range(4))
    header = "nx: 4\nny: 3\n"
    assert read(header + rows, unit="um").shape == (3, 4)
    refused(
        header + rows[: rows.index("0 2")],
        "the header says 3 rows, the points make 2; it was cut off",
        unit="um",
    )
    assert read("samples: 12\n" + trace(), unit="um").shape == (1, 12)
    refused("samples: 13\n" + trace(), r"13 columns.* 12", unit="um")


def matrix(rows, columns, width, height):
    heights = np.random.default_rng(rows).normal(size=(rows, columns))
    text = "\n".join("\t".join(f"{value:.4f}" for value in row) for row in heights)
    return f"# Width: {width} µm\n# Height: {height} µm\n# Value units: nm\n{text}\n"


@pytest.mark.parametrize(
    ("rows", "columns", "width", "height"),
    [
        (159, 160, "10.00", "10.00"),
        (159, 160, "10", "10"),
        (255, 256, "10.00", "10.00"),
        (79, 160, "10.00", "10.00"),  # every second line
        (119, 60, "5.00", "10.00"),
        (12, 20, "20", "20"),
        (100, 160, "10.00", "10.00"),
    ],
)
def test_a_matrix_of_lost_lines_is_refused(refused, rows, columns, width, height):
    refused(matrix(rows, columns, width, height), "give dx, dy and unit")


@pytest.mark.parametrize(
    ("rows", "columns", "width", "height"),
    [
        (160, 160, "10.00", "10.00"),
        (3, 4, "10", "10"),  # pixels of 2.5 µm × 3.3 µm
        (20, 30, "10", "10"),
        (30, 40, "10", "10"),
        (30, 20, "10", "10"),
        (30, 20, "10", "17.3"),
        (80, 160, "10.00", "10.00"),
        (300, 100, "9.9", "29.9"),  # sizes from the first point to the last one
        (305, 75, "10.0", "40.7"),  # rounded sizes
    ],
)
def test_pixels_of_any_shape_are_read(read, rows, columns, width, height):
    found = read(matrix(rows, columns, width, height))
    assert found.shape == (rows, columns)
    assert float(found.y[1] - found.y[0]) == pytest.approx(1e-6 * float(height) / rows)


def test_positions_rounded_to_their_last_digit_are_even(read, refused):
    x = np.round(0.15625 * np.arange(400), 1)
    z = np.sin(x)
    rows = "".join(f"{a:.1f},{b:.5f},,\n" for a, b in zip(x, z, strict=True))
    height = read("Lateral um,Raw Micrometer,\n" + rows)
    assert float(height.x[1] - height.x[0]) == pytest.approx(0.15625e-6, rel=1e-4)
    assert any("even up to the rounding" in note for note in json.loads(height.attrs["ingest_warnings"]))
    gaps = np.delete(np.arange(400), np.random.default_rng(2).integers(1, 399, 60))
    rows = "".join(f"{a} {a % 7}\n" for a in gaps)
    refused(rows, "not evenly spaced", unit="um")


def test_an_export_of_a_laser_microscope(read):
    header = (
        '"Model","VK-X1000"\n"Output image data","Height"\n"XY calibration","692.3","nm/pixel"\n'
        '"Horizontal","4"\n"Vertical","3"\n"Unit","um"\n"Height"\n'
    )
    height = read(header + '"1.5","2.5","3.5","4.75"\n' * 3)
    np.testing.assert_allclose(height.values[1], [1.5e-6, 2.5e-6, 3.5e-6, 4.75e-6], rtol=1e-14)
    assert float(height.x[1] - height.x[0]) == pytest.approx(692.3e-9)


def test_text_without_an_end_of_its_header(refused):
    refused("so it goes\n" * 100_002 + "1 2 3\n", "without a table of numbers in its first 100000 lines")


@pytest.mark.parametrize("form", ["{:.2f}", "{:.5e}", "{:.4f}"])
@pytest.mark.parametrize("columns", [5, 1])
def test_a_file_that_ends_within_a_number_is_refused(read, refused, form, columns):
    heights = np.random.default_rng(2).normal(size=(6, columns)) + 5
    if columns == 1:
        heights = np.column_stack([np.arange(6), heights])
    text = "".join(" ".join(map(form.format, row)) + "\n" for row in heights)
    given = GIVEN if columns > 1 else {"unit": "um"}
    for whole in (text, text[:-1], text[: text.rindex(" ")] + " NaN"):
        assert read(whole, **given).size == 6 * columns
    for end in range(text.rindex(" ") + 2, len(text) - 1):
        words = rf"line 6 ends the file in '{re.escape(text[text.rindex(' ') + 1 : end])}'.*it was cut off"
        refused(text[:end], words, **given)


def test_a_last_number_shorter_than_all_others_is_doubted(read):
    text = "1.5 2.25 3 4.25\n0.25 3.125 1 4.75\n2 5.5 0 60.5\n3 7.5 1 8.25\n4 9 1 1.25"
    assert "ends the file" not in warnings_of(read(text, **GIVEN))
    cut = warnings_of(read(text[:-2], **GIVEN))
    assert "line 5 ends the file in '1.', without the end of a line: if the file was cut off" in cut
    assert "ends the file" not in warnings_of(read(text[:-2] + "\n", **GIVEN))


@pytest.mark.shared_data
@pytest.mark.parametrize(
    ("name", "shape", "step"),
    [
        ("dektak-1.csv", (1, 9600), 1.5e-3 / 9600),
        ("gwyddion-export-english.txt", (4, 3), 12.34e-6 / 3),
        ("gwyddion-export-german.txt", (4, 3), 12.34e-6 / 3),
        ("csv-2.csv", (1, 8), 1e-6 / 12),
        ("csv-3.csv", (1, 8), 1e-6 / 12),
        ("matrix-6.txt", (3, 4), 2.5e-6),
    ],
)
def test_real_exports(name, shape, step):
    height = read_height_map(MORE / name)
    assert height.shape == shape
    assert float(height.x[1] - height.x[0]) == pytest.approx(step, rel=1e-4)
    if name == "dektak-1.csv":  # as SurfaceTopography reads it
        assert 1e6 * float(height.std()) == pytest.approx(4.764, abs=5e-4)


@pytest.mark.shared_data
def test_a_real_export_of_uneven_positions():
    refuses("resample = linear", MORE / "xy-2.txt")
    height = read_height_map(MORE / "xy-2.txt", resample="linear")
    assert 1e-5 < float(height.x[0]) < float(height.x[-1]) < 4.3e-5


def test_a_heading_above_a_matrix_gives_the_unit_of_its_heights(read):
    heights = np.arange(20.0).reshape(4, 5) ** 2
    matrix = "\n".join(" ".join(map(str, row)) for row in heights)
    for heading in ("Height(nm)", "# Height Sensor [nm]", '"Z (nm)"'):
        height = read(f"made on Monday\n{heading}\n{matrix}\n", **GIVEN)
        np.testing.assert_allclose(height.values[::-1], 1e-9 * heights, rtol=1e-14)
    size = read(f"Width: 5 mm\nHeight: 4 mm\n{matrix}\n", height_unit="um")
    np.testing.assert_allclose(size.values[::-1], 1e-6 * heights, rtol=1e-14)


def test_the_text_export_of_a_binary_format_is_read_as_text(read):
    matrix = "\n".join("1.5 2.5 3.5 4.5" for _ in range(5))
    head = "\\*File list\n\\Version: 0x09200201\n\\*Ciao image list\n\\Data offset: 80\n\\Data length: 40\n"
    height = read(f"{head}Height(nm)\n{matrix}\n", **GIVEN)
    assert height.shape == (5, 4)
    assert height.values[0, 1] == pytest.approx(2.5e-9)
    points = "".join(f"{10 * x}\t{10 * y}\t{x * y}\n" for y in range(4) for x in range(3))
    head = "WSxM file copyright UAM\nWSxM ASCII XYZ file\nX[nm]\tY[nm]\tZ[nm]\n\n"
    height = read(head + points)
    np.testing.assert_allclose(height.values, 1e-9 * np.outer(range(4), range(3)), rtol=1e-14)
    assert float(height.x[1] - height.x[0]) == pytest.approx(10e-9)


def test_units_of_axes_in_the_header_of_a_stylus_profiler(read):
    head = "[Meta Data]\nScan Length=60\nHorizontal Units=mm\nVertical Units=um\n[Scan Data]\n"
    assert_trace(read(head + trace("\t")))


def test_a_line_that_is_no_row_of_numbers_names_the_way_out(tmp_path):
    path = saved(tmp_path, "1 2\nProfile1 3 0\nCX A 120 MM 1.0 D\nEOR\n12\n13\n14\n")
    refuses(r"line 2 is no row of numbers .* export the map as X3P or SDF", path)
