"""Pages of the benchmarks are filled from their tables, digit by digit."""

import pages
import pandas as pd
import pytest


def test_every_page_is_what_its_tables_say():
    """A number that was edited by hand, on a page or in a table, is found here."""
    for path, text in pages.rendered().items():
        assert path.read_text("utf-8") == text, f"{path.name}: run `python benchmarks/pages.py`"


def test_numbers_keep_their_digits():
    frame = pd.DataFrame(
        {"time": [3932.4, 0.01234, None], "share": [0.5, 12.345, 1.0], "map": ["a", "b", None]}
    )
    assert pages.text(frame, {"share": ".1f"}).values.tolist() == [
        ["3930", "0.5", "a"],
        ["0.0123", "12.3", "b"],
        ["", "1.0", ""],
    ]


def test_rows_are_chosen_and_shown():
    rows = [
        {"threads": "1", "map": "a_b", "time": "7", "other": ""},
        {"threads": "2", "map": "c", "time": "", "other": ""},
    ]
    assert pages.only(rows, threads="2") == {"map": "c", "time": "", "other": ""}
    assert pages.table(rows).splitlines()[2:] == ["| 1 | a\\_b | 7 |", "| 2 | c | – |"]
    with pytest.raises(ValueError, match="not enough values"):
        pages.only(rows, threads="3")


def test_a_block_is_written_between_its_marks():
    page = "before\n<!-- speed: written -->\nold\n<!-- end of speed -->\nafter\n"
    assert pages.with_block(page, "speed", "new\n") == page.replace("old", "new")
    with pytest.raises(ValueError, match="no lines <!-- speed"):
        pages.with_block("no marks\n", "speed", "new\n")


def test_the_figure_is_drawn(tmp_path):
    pages.draw(pages.read(pages.RESULTS / "speed")["race"], tmp_path / "speed.png")
    assert (tmp_path / "speed.png").stat().st_size > 10_000
