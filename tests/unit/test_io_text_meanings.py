"""A number of a text is used where its meaning is stated, in words of several languages; else it is asked."""

import json

import numpy as np
import pytest
from measured_files import cells, holds, points, warnings_of

ONE = np.round(np.random.default_rng(11).normal(size=(8, 10)), 3)  # nm
ROWS, STEPS = cells(ONE), "dx: 0.5 µm\ndy: 0.25 µm\n"


def is_right(height, heights=ONE[::-1]):
    holds(height, 1e-9 * heights, 0.5e-6, 0.25e-6, rtol=1e-12)


@pytest.mark.cases
def test_a_size_is_read_in_the_words_around_it(read, lines):
    is_right(read(f"{lines}\n{ROWS}"))


@pytest.mark.cases
def test_the_letter_of_an_axis_names_a_column(read, heading):
    is_right(read(f"{heading}\n{cells(points(ONE, 0.5, 0.25), ';')}"), ONE)


def test_an_order_of_sides_that_is_not_known_is_asked_about(refusal):
    refusal(f"Pixel size (v1, v2): 0.25 x 0.5 µm\nZ unit: nm\n{ROWS}", "does not say its size.*line 1 says")


def test_an_error_of_heights_has_no_unit_of_theirs(refusal):
    refusal(f"{STEPS}Height error [nm]\n{ROWS}", "does not say the unit of its heights .*Height error")


@pytest.mark.parametrize(
    "names", ["Posición Y Coordenada X Cota", "Position Y Position X Altitude", "Y pos. X pos. Height"]
)
def test_names_of_two_words_between_blanks(read, refusal, names):
    rows = "\n".join(f"{0.25 * j:g} {0.5 * i:g} {ONE[j, i]:g}" for j in range(8) for i in range(10))
    is_right(read(f"{names}\nµm µm nm\n{rows}"), ONE)
    refusal(f"Position Y Position Altitude\nµm µm nm\n{rows}", "write each name without blanks")


def test_an_abbreviation_before_a_number_names_no_columns(refusal):
    profile = "\n".join(f"{row} {0.5 * row} {height}" for row, height in enumerate(ONE.ravel(), 1))
    refusal(f"# Measurement no.: 17\n{profile}", "name the columns in a line above them, as x, z1, z2")


def test_words_behind_decimal_commas_lose_no_point(read):
    rows = cells(points(ONE, 0.5, 0.25), " ").replace(".", ",").splitlines()
    is_right(read("X Y Z status\nµm µm nm\n" + "\n".join(f"{row} ok" for row in rows)), ONE)


@pytest.mark.parametrize(
    "line", ["1 pas = 0,1 nm", "1 单位 = 0.1 nm", "Passo Z: 0.1 nm", "Z resolution: 0.1 nm"]
)
def test_the_height_of_one_step_counts_whole_numbers(read, refusal, line):
    counts = np.round(100 * ONE)
    height = read(f"{STEPS}{line}\n{cells(counts)}")
    is_right(height, 0.1 * counts[::-1])
    assert f"line 3 says '{line}': all heights are whole numbers" in warnings_of(height)
    refusal(f"{STEPS}{line}\n{cells(ONE)}", "does not say the unit of its heights .*line 3 says")


def test_a_unit_of_lengths_is_none_of_heights(refusal):
    header = "Bildbreite = 3\nBildhöhe = 2\nLängeneinheit = um\n"
    refusal(header + cells(1e-6 * ONE), "does not say the unit of its heights")


def test_the_height_of_one_step_is_none_of_the_steps_of_the_user(refusal):
    """Its line was a doubt about the steps, and answered with them."""
    answers = {"dx": "1 um", "dy": "1 um", "height_unit": "nm"}
    refusal(f"# 1 passo = 10 nm\n{cells(np.round(100 * ONE))}", "all heights are whole numbers", **answers)


@pytest.mark.parametrize(
    "line", ["Scale factor: 0.1 nm", "z_scale = 0.1 nm", "Skalierung: 0,1", "gain: 100", "Множитель: 0.1"]
)
def test_a_factor_above_counts_is_asked_about(read, refusal, line):
    text = f"{STEPS}Z unit: nm\n{line}\n{cells(np.round(100 * ONE))}"
    refusal(text, "all heights are whole numbers, as counts are")
    assert read(text, ignore_lines=4).attrs["missing_points"] == 0


@pytest.mark.cases
def test_what_may_turn_scale_or_thin_the_map_is_said(read, line, check):
    height = read(f"{STEPS}Z unit: nm\n{line}\n{ROWS}")
    assert f"line 4 says {line!r}, which is not used: check {check}" in warnings_of(height)


@pytest.mark.parametrize("line", ["Nicht gemessen", "Points non mesurés", "Bad pixels", "Sin datos"])
def test_a_negative_number_of_missing_points_marks_them(read, refusal, line):
    table, other = ONE.copy(), ONE.copy()
    table[2, 3], other[2, 3] = -9999, 12
    height = read(f"{STEPS}Z unit: nm\n{line}: -9999\n{cells(table)}")
    is_right(height, np.where(table == -9999, np.nan, table)[::-1])
    # how many there are, or their marker, where a point has this height: that is asked
    count = f"{STEPS}Z unit: nm\n{line}: 12\n{cells(other)}"
    refusal(count, "line 4 .*there is 1 point with that height: give missing_value .* or ignore_lines = 4")
    is_right(read(count, ignore_lines=4), other[::-1])
    is_right(read(count, missing_value=12), np.where(other == 12, np.nan, other)[::-1])


def test_a_number_of_zero_is_asked_where_several_points_have_that_height(read, refusal):
    table = ONE.copy()
    table[2, 3] = 0
    one = f"{STEPS}Z unit: nm\nMissing points: 0\n{cells(table)}"
    is_right(read(one), table[::-1])
    assert "there is 1 point with that height: if missing, give missing_value" in warnings_of(read(one))
    table[5, 3] = 0
    refusal(f"{STEPS}Z unit: nm\nMissing points: 0\n{cells(table)}", "there are 2 points with that height")


@pytest.mark.parametrize("line", ["Invalid data are set to 9000", "points without signal are 9000"])
def test_a_conspicuous_number_of_invalid_points_is_their_marker_in_any_words(read, refusal, line):
    table = ONE.copy()
    table[2:5, 3] = 9000
    text = f"{STEPS}Z unit: nm\n{line}\n{cells(table)}"
    is_right(read(text), np.where(table == 9000, np.nan, table)[::-1])
    assert f"line 4 says '{line}': 3 points with that height are missing" in warnings_of(read(text))
    # without a word of missing points it is asked
    refusal(text.replace(line, "9000 se pone en los huecos"), "there are 3 points with that height: give mis")
    counts = cells(np.round(ONE))  # whole numbers agree with any other by chance
    read(f"{STEPS}Z unit: nm\nOperator 2\n{counts}")


@pytest.mark.cases
def test_the_order_of_the_rows_is_read(read, line, row):
    height = read(f"{STEPS}Z unit: nm\n{line}\n{ROWS}")
    is_right(height, ONE if row == "bottom" else ONE[::-1])
    assert height.attrs["first_row"] == row
    assert "first_row_assumed" not in height.attrs or not height.attrs["first_row_assumed"]
    sources = json.loads(height.attrs["ingest_sources"])
    assert sources["first_row"] == "line 4"
    assert not sources["not used"]
    assert "first_row" not in warnings_of(height)


def test_half_of_a_profile_is_no_whole_one(refusal):
    text = "x [mm];z [nm]\n" + "".join(f"{n};{z}\n" for n, z in enumerate(ONE[0]))
    refusal(f"Number of points: 20\n{text}", "the file says 20 points, the table has 10 rows of 2 numbers")


def test_words_of_validity_do_not_hide_a_marker(read, refusal):
    table = ONE.copy()
    table[2:4, 3] = -2500
    refusal(f"{STEPS}Z unit: nm\nno signal -> -2500\n{cells(table)}", "there are 2 points with that height")


@pytest.mark.cases
def test_usual_lines_of_a_header_cause_no_warning(read, line):
    assert "line 4" not in warnings_of(read(f"{STEPS}Z unit: nm\n{line}\n{ROWS}"))


def test_an_order_of_rows_that_is_doubtful_or_stated_twice_is_not_used(read, refusal):
    origin = read(f"{STEPS}Z unit: nm\nUrsprung unten links\n{ROWS}")
    assert "line 4 says 'Ursprung unten links', which is not used: check first_row" in warnings_of(origin)
    doubtful = read(f"{STEPS}Z unit: nm\nfirst line not at the bottom\n{ROWS}")
    is_right(doubtful)
    assert "line 4 says 'first line not at the bottom', which is not used" in warnings_of(doubtful)
    twice = f"{STEPS}Z unit: nm\nFirst row: top\nrow 1 is the bottom\n{ROWS}"
    refusal(twice, "line 4 .*, line 5 .*: they do not agree")


TABLES_OF_PROGRAMS = {
    "R, write.table": '"x_um" "z_nm"\n' + "".join(f'"{n + 1}" {0.5 * n} {z}\n' for n, z in enumerate(ONE[0])),
    "R, decimal comma": '"x_um" "z_nm"\n'
    + "".join(f'"{n + 1}" {0.5 * n} {z}\n'.replace(".", ",") for n, z in enumerate(ONE[0])),
    "Origin": "Position\tHeight\nµm\tnm\nTrack 1\tLevelled\n"
    + "".join(f"{0.5 * n}\t{z}\n" for n, z in enumerate(ONE[0])),
}


@pytest.mark.parametrize("text", TABLES_OF_PROGRAMS.values(), ids=TABLES_OF_PROGRAMS)
def test_profiles_as_programs_write_their_headings(read, text):
    holds(read(text), 1e-9 * ONE[:1], 0.5e-6, rtol=1e-12)


@pytest.mark.cases
def test_headers_as_programs_write_them(read, lines):
    is_right(read(lines + (ROWS if '"' not in lines else cells(ONE, ","))))


def test_pixels_to_nanometres(read):
    holds(read(f"# heights in nm\n# pixel_to_nm_scaling: 500\n{ROWS}"), 1e-9 * ONE[::-1], 0.5e-6, 0.5e-6)


def test_positions_that_the_corner_names_are_no_numbers_of_rows(read):
    table = cells(np.column_stack([np.arange(8), ONE]), ";")
    x = ";".join(f"{0.5 * column:g}" for column in range(10))
    height = read(f"Heights in nm\ny\\x [µm];{x}\n{table}")
    holds(height, 1e-9 * ONE, 0.5e-6, 1e-6, rtol=1e-12)
    assert json.loads(height.attrs["ingest_sources"])["dy"] == "positions"


def test_steps_that_are_doubted_are_asked_with_the_unit_of_heights(refusal):
    text = f"X Size: 10\nY Size: 8\n{ROWS}"
    refusal(text, "10 columns: a size without a unit, or their number; .* give dx, dy, unit and height_unit")


def test_lines_that_were_wrapped_are_asked_about_or_said(read, refusal):
    random = np.random.default_rng(5)
    kernel = np.exp(-8 * np.hypot(*np.meshgrid(np.fft.fftfreq(12), np.fft.fftfreq(10))))
    smooth = np.fft.ifft2(np.fft.fft2(random.normal(size=(10, 12))) * kernel).real
    sizes = "Width: 5 µm\nHeight: 2 µm\nZ unit: nm\n"
    refusal(sizes + cells(np.round(smooth.reshape(20, 6), 4)), "2 lines each go on where the one above ends")
    rough = np.round(random.normal(size=(20, 6)), 4)
    assert "pixels of 8.33 : 1 by the size alone" in warnings_of(read(sizes + cells(rough)))


@pytest.mark.parametrize(
    "line",
    [
        *("Values above 5 are invalid", "Werte über 5 sind ungültig", "Valid range: -5 to 5"),
        *("Points higher than 5 nm were not measured", "Les valeurs au-dessus de 5 sont invalides"),
    ],
)
def test_a_limit_of_what_is_valid_is_asked_about_where_heights_lie_beyond(read, refusal, line):
    table = ONE.copy()
    table[2, 3] = table[5, 7] = 9000
    head = f"{STEPS}Z unit: nm\n{line}\n"
    message = f"line 4 says '{line}', and there are 2 points beyond it: give missing_value .*ignore_lines = 4"
    refusal(head + cells(table), message)
    is_right(read(head + cells(table), missing_value=9000), np.where(table == 9000, np.nan, table)[::-1])
    is_right(read(head + cells(table), ignore_lines=4), table[::-1])
    assert np.abs(ONE).max() < 5
    is_right(read(head + ROWS), ONE[::-1])


@pytest.mark.cases
def test_what_people_write_above_a_map(read, head):
    is_right(read("\n".join("# " + line for line in head.splitlines()) + "\n" + ROWS), ONE[::-1])


def test_words_beside_an_entry_that_may_concern_the_map_are_not_skipped(refusal):
    refusal(f"Binned, pixel 0.5 x 0.25 µm, heights in nm\n{ROWS}", "'Binned, .* is not used.; give dx, dy")


@pytest.mark.parametrize("unit", ["a.u.", "%", "[counts]", "-"])
def test_units_of_other_columns_in_a_line_of_units(read, unit):
    table = np.column_stack([points(ONE, 0.5, 0.25), np.full(ONE.size, 7)])
    is_right(read(f"X;Y;Z;Intensity\nµm;µm;nm;{unit}\n{cells(table, ';')}"), ONE)


@pytest.mark.cases
def test_a_line_above_headings_that_they_do_not_agree_with_is_said(read, line):
    table = cells(np.column_stack([np.arange(10.0) / 2, ONE[0]]), ";")
    height = read(f"{line}\nx [µm];z [nm]\n{table}")
    holds(height, 1e-9 * ONE[:1], 0.5e-6, rtol=1e-12)
    assert f"line 1 says {line[:60]!r}, which is not used: check" in warnings_of(height)
    assert "line" not in warnings_of(read(f"x: µm, z: nm\nx [µm];z [nm]\n{table}"))


@pytest.mark.parametrize(
    ("text", "z"),
    [
        ("Punktabstand: 0,5 µm\nHöhe [nm]\n" + cells(ONE[:1].T + 20).replace(".", ","), ONE[:1] + 20),
        (
            "Scan Length,4.5,um\nX (um),Z (nm)\n"
            + cells(np.column_stack([np.arange(10) / 2, np.arange(10)]), ","),
            [range(10)],
        ),
        (
            "# units: nm\n# format: x y z\n"
            + cells(np.column_stack([500.0 * np.arange(10), 0 * ONE[0], ONE[0]])),
            ONE[:1],
        ),
    ],
)
def test_profiles_whose_header_says_how_they_are_written(read, text, z):
    height = read(text)
    np.testing.assert_allclose(height.values, 1e-9 * np.asarray(z), rtol=1e-12)
    assert float(height.x[1] - height.x[0]) == pytest.approx(0.5e-6, rel=1e-9)


def test_steps_in_double_precision_of_fortran(read):
    is_right(read(f"dx = 0.5D-06 m   dy = 0.2500D-06 m\n高さデータ[nm]\n{ROWS}"))


def test_what_stands_far_behind_in_a_line_is_said(read):
    line = "polished, " * 40 + "scan direction backward"
    warnings = warnings_of(read(f"{STEPS}Z unit: nm\n{line}\n{ROWS}"))
    assert "backward', which is not used: check first_row" in warnings
    assert not warnings_of(read(f"{STEPS}Z unit: nm\n# {' '.join(map(str, range(300)))}\n{ROWS}"))


@pytest.mark.parametrize(
    "heading", ["Y_um , X_um , Z_nm", "Y_µm, 位置_µm, Z_nm", "y in µm, x in µm, z in nm"]
)
def test_names_between_commas_and_blanks_keep_their_order(read, heading):
    y, x = np.divmod(np.arange(ONE.size), ONE.shape[1])
    height = read(f"{heading}\n{cells(np.column_stack([y / 4, x / 2, ONE.ravel()]), ' , ')}")
    is_right(height, ONE)
