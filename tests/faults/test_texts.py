"""A short run of texts as people and programs write them, and that a wrong reading would be noticed."""

import pytest
from texts import counted, outcome


@pytest.fixture(scope="module")
def read_texts(tmp_path_factory):
    return counted(220, 5, tmp_path_factory.mktemp("texts"))


def test_no_text_is_read_wrong_in_silence(read_texts):
    wrong = [(text.kind, words) for text, result, words in read_texts if result.isupper()]
    assert wrong == []


def test_most_texts_that_state_all_are_read_at_once(read_texts):
    outcomes = [result for text, result, _ in read_texts if text.full]
    assert len(outcomes) > 100
    assert outcomes.count("read") >= 0.85 * len(outcomes)


def test_a_wrong_reading_is_noticed(read_texts, tmp_path):
    text = next(text for text, result, _ in read_texts if result == "read" and text.heights.shape[0] > 1)
    for wrong in (
        text._replace(heights=1.001 * text.heights),
        text._replace(heights=text.heights[:-1]),
        text._replace(steps=(2 * text.steps[0], text.steps[1])),
        text._replace(word="no such word"),
    ):
        assert outcome(wrong, tmp_path)[0] == "WRONG IN SILENCE"
