"""Two cases share a stage where all settings up to it are equal."""

from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.settings.stages import SECTIONS, owner, stage_settings


def owners(overrides, **contact):
    """Return, for each stage, whose it is in a case with these overrides next to a case without any."""
    cases = resolve(
        {"contact": {"contact_modulus": 1e9, **contact}, "cases": {"base": {}, "other": overrides}}
    )
    return [owner(cases, "other", stage) for stage in SECTIONS]


def test_a_case_owns_what_it_changes_and_all_that_follows():
    assert owners({}) == ["base"] * 7
    assert owners({"statistics": {"gap_bins": 5}}) == ["base"] * 6 + ["other"]
    assert owners({"uncertainty": {"sources": []}}) == ["base"] * 5 + ["other"] * 2
    assert owners({"contact": {"tolerance": 0.1}}) == ["base"] * 4 + ["other"] * 3
    assert owners({"window": {"method": "raw"}}) == ["base"] * 2 + ["other"] * 5
    assert owners({"level": {"form": "mean"}}) == ["base"] + ["other"] * 6


def test_a_value_that_is_written_out_is_the_default():
    assert (
        owners({"level": {"form": "plane"}, "contact": {"contact_modulus": "1000000000.0"}}) == ["base"] * 7
    )


def test_without_fields_contact_and_statistics_are_one():
    stages = dict(zip(SECTIONS, owners({"statistics": {"gap_bins": 5}}, keep_fields=False), strict=True))
    assert [stage for stage, case in stages.items() if case == "other"] == ["contact", "statistics"]


def test_settings_of_a_stage_leave_out_what_comes_later():
    (settings,) = resolve({"contact": {"contact_modulus": 1e9}}).values()
    assert stage_settings(settings, "height") == {}
    assert list(stage_settings(settings, "window")) == ["level", "window"]


def test_whether_fields_are_kept_is_nothing_to_the_error_budget():
    stages = dict(zip(SECTIONS, owners({"contact": {"keep_fields": False}}), strict=True))
    assert [stage for stage, case in stages.items() if case == "other"] == ["contact", "statistics"]


def test_the_first_case_that_agrees_computes():
    sections = {"one": {}, "two": {"level": {"form": "mean"}}, "three": {"level": {"form": "mean"}}}
    cases = resolve({"contact": {"contact_modulus": 1e9}, "cases": sections})
    assert [owner(cases, case, "levelled") for case in cases] == ["one", "two", "two"]
    assert [owner(cases, case, "height") for case in cases] == ["one", "one", "one"]
