"""A short run of texts that hold more than one thing: each is read right, or asked about."""

from mixtures import KINDS, counted, mixture, outcome


def test_no_mixture_is_read_wrong_or_refused_for_another_reason(tmp_path):
    outcomes, wrong = counted(240, 5, tmp_path)
    assert [(text.kind, result) for text, result in wrong] == []
    assert outcomes["read right"] > 100
    assert outcomes["asked"] > 60
    assert outcomes.total() == 240


def test_a_wrong_reading_is_noticed(tmp_path):
    texts = [mixture(number) for number in range(10 * len(KINDS))]
    text = next(text for text in texts if outcome(text, tmp_path) == "read right")
    assert outcome(text._replace(heights=text.heights * 1.001), tmp_path).startswith("wrong")
    text_asked_about = next(text for text in texts if outcome(text, tmp_path) == "asked")
    assert outcome(text_asked_about._replace(asked="another reason"), tmp_path).startswith(
        "refused otherwise"
    )
