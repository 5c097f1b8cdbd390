"""The target `validation`: a page with every line, and a run that fails where a line does not hold."""

import csv
import shutil

import pytest
from small_project import ROOT, SETTINGS, Project, write_maps

pytestmark = pytest.mark.slow  # all parts are computed twice; in one process they are in test_validation.py

SMALL = SETTINGS | {"validation": {"finest_grid": 256}}


@pytest.fixture(scope="module")
def validated(tmp_path_factory, checkout):
    """A project in which the validation has run once, at its smallest size, with a checkout of its own."""
    own = tmp_path_factory.mktemp("own")
    shutil.copytree(checkout, own, dirs_exist_ok=True)
    (own / "data_samples").mkdir()
    shutil.copy(ROOT / "data_samples/sandblasted.x3p", own / "data_samples")
    project = Project(tmp_path_factory.mktemp("validated") / "study", own)
    write_maps(project.path("measured"))  # a missing one is a mistake of the table, whatever is asked for
    project.write(SMALL)
    project.first = project.run("validation")
    return project


def lines(project):
    """Return the rows of the table of lines."""
    with project.path("results/validation/lines.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_target_leaves_a_page_and_a_table_and_nothing_of_the_surfaces(validated):
    assert validated.first.returncode == 0, validated.first.stderr
    rows = lines(validated)
    assert {row["holds"] for row in rows} == {"yes"}
    assert f"all {len(rows)} lines hold" in validated.first.stderr
    html = validated.path("results/validation/validation.html").read_text()
    assert html.count('<tr class="passed">') == len(rows) > 100
    assert [path.name for path in validated.path("results").iterdir()] == ["validation"]


def test_a_second_run_computes_nothing_but_looks_again(validated):
    assert validated.jobs("validation") == {"validation": 1}


def test_a_wrong_number_makes_it_fail_and_the_page_shows_where(validated):
    source = validated.checkout / "workflow/lib/roughcontact/references/closed_forms.py"
    right = source.read_text()
    assert "0.05: 0.11294" in right
    source.write_text(right.replace("0.05: 0.11294", "0.05: 0.12294"))
    run = validated.run("validation")
    source.write_text(right)
    assert run.returncode != 0
    wrong = [row for row in lines(validated) if row["holds"] == "no"]
    assert [row["what"] for row in wrong] == ["Product wave, r = 0.05: contact area"]
    assert float(wrong[0]["reference"]) == 0.12294
    assert "1 of " in run.stderr
    assert "Product wave, r = 0.05: contact area: 0.113" in run.stderr
    html = validated.path("results/validation/validation.html").read_text()
    assert html.count('<tr class="failed">') == 1
    assert "What does not hold" in html
