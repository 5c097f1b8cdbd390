"""A short run of random dialects: none is read wrong in silence, and one that were would be noticed."""

from dialects import counted, outcome, text_of


def test_no_dialect_is_read_wrong_in_silence(tmp_path):
    found, wrong = counted(150, 1, tmp_path)
    assert wrong == []
    assert found["read right"] > 100
    assert found.total() == 150


def test_a_wrong_reading_is_noticed(tmp_path):
    text = text_of(3)
    assert outcome(text, tmp_path) == "read right"
    other = text._replace(heights=text.heights + 1e-9)
    assert outcome(other, tmp_path) == "wrong in silence"
