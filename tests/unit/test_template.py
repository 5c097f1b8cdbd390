"""Templates: compiled once, and again when they change."""

import sys

import jinja2
import pytest

from roughcontact.report import template as module
from roughcontact.report.allowed import DECISIONS, Sentence
from roughcontact.report.template import template


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of templates, and none compiled yet: `tmp_path / "compiled"` keeps them."""
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(sys, "pycache_prefix", str(tmp_path / "compiled"))
    (tmp_path / "templates").mkdir()
    (tmp_path / "templates/words.txt").write_text("Area {{ area | percent }}.")
    module._environment.cache_clear()
    yield tmp_path / "templates"
    module._environment.cache_clear()


def rendered(folder):
    """Return the filled template as a new process would."""
    module._environment.cache_clear()
    return template("words.txt", folder=folder).render(area=0.125)


def test_a_compiled_template_is_not_compiled_again(folder, monkeypatch):
    assert rendered(folder) == "Area 12.5 %."
    assert len([*folder.parent.rglob("compiled/**/template.*-*.pyc")]) == 1
    monkeypatch.setattr(jinja2.Environment, "compile", None)
    assert rendered(folder) == "Area 12.5 %."


def test_a_template_that_has_changed_is_compiled_again(folder):
    assert rendered(folder) == "Area 12.5 %."
    (folder / "words.txt").write_text("Share {{ area | percent }}.")
    assert rendered(folder) == "Share 12.5 %."


@pytest.mark.parametrize("content", [b"", b"not compiled by Jinja"])
def test_a_damaged_compiled_template_is_compiled_again(folder, content):
    rendered(folder)
    (compiled,) = folder.parent.rglob("compiled/**/template.*-*.pyc")
    compiled.write_bytes(content)
    assert rendered(folder) == "Area 12.5 %."


def test_a_folder_that_keeps_nothing_changes_nothing(folder, monkeypatch):
    (folder.parent / "file").write_text("")
    monkeypatch.setattr(sys, "pycache_prefix", str(folder.parent / "file/compiled"))
    assert rendered(folder) == "Area 12.5 %."


def test_nothing_is_kept_where_python_keeps_nothing(folder, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert rendered(folder) == "Area 12.5 %."
    assert not (folder.parent / "compiled").exists()


def test_an_answer_has_a_line_for_each_sentence_and_marks_what_is_decided():
    """A decision has its colour wherever it stands; the same word elsewhere, as in a name, has none."""
    answer = [
        Sentence("Leak 0.5 ml/h of at most 1.00 ml/h: ", "holds", ", from 1.00 MPa on."),
        Sentence("At 2.00 MPa: holds, as <b> says. Gap: not decided."),
    ]
    marked = template("cell.html").module.answered(answer, DECISIONS)
    assert str(marked) == (
        '<span class="answer">Leak 0.5 ml/h of at most 1.00 ml/h: <b class="passed">holds</b>, from 1.00 MPa '
        'on.</span><span class="answer">At 2.00 MPa: holds, as &lt;b&gt; says. Gap: not decided.</span>'
    )
    failing = Sentence("Gap of at least 1 µm: ", "does not hold", " (lifted).")
    assert '<b class="failed">does not hold</b>' in template("cell.html").module.answered(
        [failing], DECISIONS
    )
