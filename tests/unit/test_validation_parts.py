"""All parts of the validation at their smallest size: they hold, and every line has its evidence."""

import csv
import importlib
import re
from pathlib import Path

import pytest

from validation import SECTIONS, page
from validation.__main__ import compute
from validation.sections import validate

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def parts():
    """All parts at the smallest size, computed as the command does it."""
    return {part.name: part for part in compute(finest_grid=256)}


@pytest.mark.parametrize("name", SECTIONS)
def test_parts_hold_at_a_small_size(parts, name):
    part = parts[name]
    assert part.name == name
    assert part.lines
    assert [line.what for line in part.lines if not line.holds] == []


def test_no_two_lines_are_called_the_same(parts):
    names = [line.what for part in parts.values() for line in part.lines]
    assert len(set(names)) == len(names) > 100


def test_the_evidence_of_every_line_is_there(parts):
    for evidence in {line.evidence for part in parts.values() for line in part.lines}:
        assert evidence.formula
        assert evidence.source
        for name in re.findall(r"[\w.]+\.\w+", evidence.code):
            module, _, function = name.rpartition(".")
            home = module if module.split(".")[0] == "validation" else f"roughcontact.{module}"
            assert hasattr(importlib.import_module(home), function), name
        file, _, test = evidence.test.partition("::")
        assert f"def {test}(" in (ROOT / file).read_text(), evidence.test


def test_every_evidence_of_the_table_has_a_line(parts):
    table = ROOT / "validation/tables/evidence.tsv"
    with table.open(newline="", encoding="utf-8") as file:
        table_rows = [row[2:] for row in csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE)][1:]
    used = {line.evidence for part in parts.values() for line in part.lines}
    assert {tuple(row) for row in table_rows} == {(e.formula, e.source, e.code, e.test) for e in used}


def test_the_papers_figures_carry_their_deviation(parts):
    titles = [figure.title for figure in parts["paper"].figures]
    assert titles[:4] == ["Figure 1", "Figure 2", "Figure 3a", "Figure 3b"]
    full = [line for line in parts["paper"].lines if line.what.startswith(("Fig. 2", "Fig. 3"))]
    assert len(full) == 2
    assert all(line.deviation < 1e-13 for line in full)


def test_the_page_states_all_of_every_line(parts, tmp_path):
    page.write_page(tmp_path / "page.html", list(parts.values()))
    html = (tmp_path / "page.html").read_text()
    lines = [line for part in parts.values() for line in part.lines]
    assert f"all {len(lines)} lines hold" in html
    assert html.count('<tr class="passed">') == len(lines)
    assert 'class="failed"' not in html
    assert "://" not in re.sub(r'http://www.w3.org/[^"]*', "", html)  # nothing from the network
    for column in ("reference", "ours", "deviation", "tolerance"):
        assert html.count(f'data-label="{column}"') == len(lines)
    assert page.check(list(parts.values()), "page.html") == len(lines)


def test_the_table_keeps_every_digit(parts, tmp_path):
    page.write_table(tmp_path / "lines.csv", list(parts.values()))
    with (tmp_path / "lines.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    lines = [line for part in parts.values() for line in part.lines]
    assert [float(row["value"]) for row in rows] == [line.value for line in lines]
    assert {row["holds"] for row in rows} == {"yes"}


def test_a_part_is_the_same_twice(parts):
    second_time = validate("hertz", finest_grid=256)
    assert second_time == parts["hertz"]


def test_the_kept_table_has_the_lines_of_this_version(parts):
    """The kept table is a copy of results/validation/lines.csv: copy it again where this fails."""
    with (ROOT / "docs/explanation/validation.csv").open(newline="", encoding="utf-8") as file:
        kept_names = [row["what"] for row in csv.DictReader(file)]

    def without_sizes(names):
        return [re.sub(r"\d+ to \d+ points|at \d+ points", "", name) for name in names]

    names = [line.what for part in parts.values() for line in part.lines]
    assert without_sizes(kept_names) == without_sizes(names)
