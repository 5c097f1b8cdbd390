"""Settings and table together: every mistake in both is in one message, nothing is expanded without end."""

import time

import pytest

from roughcontact.errors import SettingsError
from roughcontact.study.study import read_study

GOOD = {"surfaces": "surfaces.tsv", "contact": {"contact_modulus": 1e9}}


def study(tmp_path, config, *rows):
    (tmp_path / "surfaces.tsv").write_text("\n".join(["surface\tpath\tunit\tresample", *rows]) + "\n")
    (tmp_path / "ground.txt").write_text("1 2\n3 4\n")
    return read_study(config, [tmp_path], measured_in=[tmp_path])


def test_settings_and_table_are_returned(tmp_path):
    cases, surfaces = study(tmp_path, GOOD, "ground\tground.txt\tum\tlinear")
    assert cases[""]["contact"]["contact_modulus"] == 1e9
    assert surfaces["ground"].read_arguments == {"unit": "um", "resample": "linear"}


def test_the_mistakes_of_both_are_in_one_message(tmp_path):
    with pytest.raises(SettingsError) as caught:
        study(
            tmp_path,
            GOOD | {"levle": {}, "statistics": {"gap_bins": 0}},
            "ground\tground.txt\ttorr\tcubic",
            "ground\tground.txt\tum\t",
            "absent\tnowhere.x3p\tum\t",
        )
    lines = str(caught.value).splitlines()
    assert lines[0] == "mistakes in the settings:"
    for start in (
        "  levle: unknown key, did you mean level?",
        "  statistics.gap_bins = 0: must not be less than 1",
        "mistakes in the table of surfaces",
        "  line 2, unit: unknown length unit 'torr'",
        "  line 2, resample = 'cubic': choose linear",
        "  line 3, surface = ground: occurs twice",
        "  line 4, path = 'nowhere.x3p': no such file; correct the path or put # before the row",
    ):
        assert any(line.startswith(start) for line in lines), (start, lines)


@pytest.mark.parametrize("where", ["level", "cases", "unknown"])
def test_a_billion_aliases_are_refused_in_a_second(tmp_path, where):
    leaves = [1.0] * 10
    for _ in range(9):  # what &a and *a make of a few lines
        leaves = [leaves] * 10
    loop = {}
    loop["again"] = loop
    start = time.process_time()
    for value in ({"s_filter": leaves}, {"a": {"contact": {"mean_pressure": leaves}}}, loop):
        with pytest.raises(SettingsError, match="more than 100000 values: look for aliases"):
            study(tmp_path, GOOD | {where: value}, "ground\tground.txt\tum\t")
    assert time.process_time() - start < 1


@pytest.mark.parametrize("shifts", [3, 2, 0])
def test_a_name_that_a_pair_needs_is_among_the_mistakes(tmp_path, shifts):
    """Of any number of placements: with more of them no name of the study has to change."""
    (tmp_path / "surfaces.tsv").write_text(
        "surface\tpath\tcounter_face\nseal\tground.txt\tground.txt\nseal-3\tground.txt\t\n"
    )
    (tmp_path / "ground.txt").write_text("1 2\n3 4\n")
    with pytest.raises(SettingsError, match="levle: unknown key") as caught:
        read_study(GOOD | {"levle": {}, "composite": {"shifts": shifts}}, [tmp_path], measured_in=[tmp_path])
    assert "line 3, surface = seal-3: the pair seal needs this name" in str(caught.value)


def test_a_first_row_that_is_no_place_is_named(tmp_path):
    (tmp_path / "surfaces.tsv").write_text(
        "surface\tpath\tfirst_row\tcounter_face\tcounter_face_first_row\na\tground.txt\tup\tground.txt\tleft\n"
        "b\tground.txt\t\t\ttop\n"
    )
    (tmp_path / "ground.txt").write_text("1 2\n3 4\n")
    with pytest.raises(SettingsError) as caught:
        read_study(GOOD, [tmp_path], measured_in=[tmp_path])
    message = str(caught.value)
    assert "line 2, first_row = 'up': choose top or bottom" in message
    assert "line 2, counter_face_first_row = 'left': choose top or bottom" in message
    assert "line 3, counter_face_first_row: is of a counter_face; name its file, or use first_row" in message
