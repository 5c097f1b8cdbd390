"""The validation: a wrong number makes it fail, a line that does not hold is marked."""

import csv
import importlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from roughcontact import SettingsError, solve_contact
from roughcontact.arguments.maps import spacing
from roughcontact.surface import synthetic
from validation import __main__ as command
from validation import closed_forms, convergence, page, paper
from validation.lines import Evidence, Line, LineText, Section, compare
from validation.page import DeviationError
from validation.sections import validate

ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "data_samples/sandblasted.x3p"
EVIDENCE = Evidence("1 + 1 = 2", "Peano (1889)", "closed_forms.hertz", "tests/unit/test_reference.py")


def line_of(what, value, reference, *, measure="relative"):
    """Return the line of a comparison with a tolerance of a tenth."""
    return compare(LineText(what, measure, "for the test", EVIDENCE), value, reference, 0.1)


def test_a_line_that_does_not_hold_is_marked_and_fails(tmp_path):
    good, bad = line_of("right", 2.0, 2.0), line_of("wrong", 2.5, 2.0)
    part = Section("sums", "Sums", "Sums of small numbers.", [good, bad])
    page.write_page(tmp_path / "page.html", [part])
    html = (tmp_path / "page.html").read_text()
    assert "1 of 2 lines do not hold" in html
    assert html.count('<tr class="failed">') == 1
    with pytest.raises(
        DeviationError, match=r"wrong: 2\.50000 instead of 2, deviation 0\.25 .* tolerance 0\.10"
    ):
        page.check([part], "page.html")


@pytest.mark.parametrize(("value", "status"), [(2.0, 0), (2.5, 1)])
def test_the_command_leaves_page_and_table_and_fails_where_a_line_does_not_hold(
    value, status, tmp_path, monkeypatch, capsys
):
    part = Section("sums", "Sums", "Sums of small numbers.", [line_of("a sum", value, 2.0)])
    monkeypatch.setattr(command, "compute", lambda **_: [part])
    assert command.main(["--directory", str(tmp_path)]) == status
    printed, complaint = capsys.readouterr()
    assert ("all 1 lines hold" in printed) == (status == 0)
    assert ("a sum: 2.50000 instead of 2" in complaint) == (status == 1)
    folder = tmp_path / "results/validation"
    with (folder / "lines.csv").open(newline="", encoding="utf-8") as file:
        assert [row["holds"] for row in csv.DictReader(file)] == [["yes", "no"][status]]
    assert ("1 of 1 lines do not hold" in (folder / "validation.html").read_text()) == (status == 1)


@pytest.mark.parametrize("measure", ["largest", "rms"])
def test_a_deviation_that_is_no_number_does_not_hold(measure):
    assert not line_of("nan", np.nan, 1.0).holds
    assert not line_of("nan", [1.0, np.nan], [1.0, 1.0], measure=measure).holds


def test_measures_of_a_deviation():
    assert line_of("relative", 11.0, 10.0).deviation == pytest.approx(0.1)
    assert line_of("absolute", 11.0, 10.0, measure="absolute").deviation == pytest.approx(1.0)
    largest = line_of("field", [1.0, 5.0, 2.0], [1.0, 4.0, 2.0], measure="largest")
    assert (largest.reference, largest.value, largest.deviation) == (4.0, 5.0, 0.25)
    rms = line_of("field", [3.0, 5.0], [3.0, 4.0], measure="rms")
    assert rms.deviation == pytest.approx(np.sqrt(1 / 25))
    assert (rms.reference, rms.value) == pytest.approx((np.sqrt(12.5), np.sqrt(17)))
    assert replace(rms, tolerance=rms.deviation).holds


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("JGH_CONTACT_SHARE", {0.05: 0.11294, 0.1: 0.19061, 0.3: 0.52418, 0.5: 0.70423, 0.9: 0.95063}),
        ("jgh_contact_share_low", lambda r: 0.9 * np.pi * (3 * np.asarray(r) / (8 * np.pi)) ** (2 / 3)),
        (
            "westergaard_energy",
            lambda *a: 1.01 * a[0] * np.pi * min(a[3], 1) ** 2 * (0.25 - np.log(a[3]) / 2),
        ),
    ],
)
def test_a_wrong_reference_is_noticed(monkeypatch, name, wrong):
    monkeypatch.setattr(closed_forms, name, wrong)
    part = validate("waves", finest_grid=256)
    with pytest.raises(DeviationError):
        page.check([part], "page.html")


@pytest.mark.parametrize("grid", [128, 300, 32768])
def test_a_grid_that_does_not_serve_is_named(grid):
    with pytest.raises(SettingsError, match=f"finest_grid = {grid}"):
        validate("waves", finest_grid=grid)


def test_a_part_that_there_is_not():
    with pytest.raises(SettingsError, match=r"'wave'.*waves"):
        validate("wave")


def test_the_papers_part_needs_a_sample():
    with pytest.raises(SettingsError, match="needs a sample"):
        validate("paper", finest_grid=256)


def test_fitted_order_of_a_power_law():
    sizes = np.array([64, 128, 512])
    assert convergence.fitted_order(sizes, 7 * sizes**-1.7) == pytest.approx(1.7, rel=1e-12)


def test_the_scatter_of_a_fitted_order():
    """Errors that are rms of so many normal numbers: the fitted orders scatter as the formula says."""
    sizes, cases = np.array([32, 64, 128, 256]), 24
    errors = np.random.default_rng(1).standard_normal((4000, cases, sizes.size))
    orders = [convergence.fitted_order(sizes, rms) for rms in np.sqrt((errors**2).mean(axis=1))]
    assert np.std(orders) == pytest.approx(convergence.slope_scatter(sizes, cases), rel=0.05)


def test_the_gap_of_a_pressure_is_that_of_the_solver():
    height = synthetic.rough_reference_surface(64)
    contact = solve_contact(height, contact_modulus=2.0, mean_pressure=0.1, tolerance=1e-10)
    gap = closed_forms.gap_left_by(contact["pressure"].values[0], height.values, spacing(height), 2.0)
    np.testing.assert_allclose(gap, contact["gap"].values[0], atol=1e-10 * np.ptp(height.values))


def test_the_series_of_figure_1_has_the_mean_of_a_hertz_contact_in_its_middle():
    """With the lattice value at q = 0 and a wide period the middle must approach as a single contact does."""
    period = 200.0
    zero = closed_forms.LATTICE_CONSTANT * period
    (middle,) = paper.hertz_displacement_by_series(np.zeros(1), period, zero)
    assert middle == pytest.approx(
        np.pi / 2, rel=2e-3
    )  # u(0) = π p₀ a/(2E*), tail of the sum beyond 2048 waves


def test_consistency_of_the_closed_forms():
    """Westergaard: energy, gap and stiffness belong together, as `consistency` asks of the solver."""
    ratio, step = 0.3, 1e-6
    full = closed_forms.westergaard_full_contact_pressure(1.0, 1.0, 1.0)
    low, high = ratio * (1 - step), ratio * (1 + step)
    energy = [closed_forms.westergaard_energy(1.0, 1.0, 1.0, r) for r in (low, high)]
    gap = [closed_forms.westergaard_mean_gap(1.0, r) for r in (low, high)]
    assert -(energy[1] - energy[0]) / (gap[1] - gap[0]) == pytest.approx(ratio * full, rel=1e-6)
    stiffness = -2 * step * ratio * full / (gap[1] - gap[0])
    assert stiffness == pytest.approx(closed_forms.westergaard_stiffness(1.0, 1.0, 1.0, ratio), rel=1e-6)


def test_the_page_of_the_documentation_shows_the_kept_lines_as_the_page_of_the_validation_does(monkeypatch):
    """Each row of the kept table is shown, rounded as the page rounds it, and holds."""
    monkeypatch.syspath_prepend(ROOT / "docs")
    page_table = importlib.import_module("generated").validation()
    with (ROOT / "docs/explanation/validation.csv").open(newline="", encoding="utf-8") as file:
        kept_rows = list(csv.DictReader(file))
    table = [
        [cell.strip() for cell in row.split(" | ")] for row in page_table.split("\n") if row.startswith("| ")
    ]
    table = {row[0].removeprefix("| "): [cell.removesuffix(" |") for cell in row[1:]] for row in table}
    for row in kept_rows:
        values = [float(row[name]) for name in ("reference", "value", "deviation")]
        line = Line(row["what"], *values, row["measure"], float(row["tolerance"]), row["reason"], EVIDENCE)
        cells = page.cells(line)
        expected_cells = [cells[name] for name in ("reference", "value", "deviation", "tolerance")]
        assert table[row["what"].replace("*", "\\*")] == expected_cells
        assert line.holds
