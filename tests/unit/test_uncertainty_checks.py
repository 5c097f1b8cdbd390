"""Flags in words that belong to the error budget: long waves, the instrument's band, plasticity."""

import json

import numpy as np
import pytest
from known_surfaces import self_affine

from roughcontact import contact_statistics, solve_contact
from roughcontact.statistics import checks, map_checks
from roughcontact.statistics.outcome import FAILED, NOT_MADE, NOTE, PASSED, REVIEW, worst_result
from roughcontact.uncertainty.combination import SOURCES


def found(longest, window=(), budget=None, *, levelled=(), statistics=(), **contact):
    """Return {name: check} of a surface with such a longest wave (sides) and sources of its interval."""
    height = self_affine((96, 96), 1e-6, (8e-6, longest * 96e-6), rms_gradient=0.1, seed=2)
    solved = solve_contact(height, contact_modulus=1e9, mean_pressure=2e7, **contact)
    statistics = contact_statistics(solved).assign(dict(statistics))
    if budget is not None:
        half_widths = [[0.01 if source in budget else np.nan for source in SOURCES]]
        statistics = statistics.assign_coords(source=list(SOURCES))
        statistics["relative_contact_area_uncertainty"] = (("load", "source"), half_widths)
    outcome = checks.surface_checks(
        statistics, height={}, levelled=dict(levelled), window=dict(window), points=96 * 96
    )
    return {check.name: check for check in outcome}


@pytest.mark.parametrize(("longest", "outcome"), [(0.2, PASSED), (1.0, REVIEW)])
def test_a_window_shorter_than_its_waves_asks_for_a_look(longest, outcome):
    assert found(longest)["Longest wave"].outcome == outcome


def test_what_the_interval_includes_is_a_note():
    check = found(1.0, budget=["window"])["Longest wave"]
    assert check.outcome == NOTE
    assert check.sentence.endswith("The ± includes it.")
    assert found(1.0, budget=["solver"])["Longest wave"].outcome == REVIEW
    edges = {"periodisation": "mirror", "rms_gradient_before": 1.0, "rms_gradient_after": 0.5}
    assert found(0.2, edges, budget=["solver"])["Periodic window"].outcome == REVIEW
    assert found(0.2, edges, budget=["window"])["Periodic window"].outcome == NOTE
    assert worst_result([check]) == PASSED


@pytest.mark.parametrize("budget", [None, ["solver", "discretisation"]])
def test_rejected_points_are_a_note_with_and_without_an_interval(budget):
    statistics = {"rejected_load_share": ("load", [0.3])}
    levelled = {"outliers_rejected": 12}
    check = found(0.2, budget=budget, levelled=levelled, statistics=statistics)["Outliers"]
    assert check.outcome == NOTE
    assert "depends on whether they are errors" in check.sentence
    assert worst_result([check]) == PASSED


@pytest.mark.parametrize(("share", "outcome"), [(0.005, PASSED), (0.05, NOTE), (0.2, FAILED)])
def test_contact_on_filled_points_is_a_note_until_it_fails(share, outcome):
    statistics = {"contact_on_filled_points": ("load", [share])}
    levelled = {"filled_share": 0.01}
    assert found(0.2, levelled=levelled, statistics=statistics)["Missing points"].outcome == outcome


@pytest.mark.parametrize(
    ("budget", "words"), [(["discretisation"], "The ± includes it."), (["unresolved"], "with finer pixels.")]
)
def test_coarse_patches_are_a_note(budget, words):
    statistics = {"relative_contact_area_pixels": ("load", [0.9])}
    check = found(0.2, budget=budget, statistics=statistics)["Resolution"]
    assert check.outcome == NOTE
    assert check.sentence.endswith(words)


@pytest.mark.parametrize(
    ("exponent", "share", "instrument", "outcome"),
    [
        (-1.0, 0.6, {}, REVIEW),
        (-1.0, 0.4, {}, NOTE),
        (-1.8, 0.6, {}, NOTE),  # as waves of a rough surface may end
        (-1.0, 0.6, {"instrument_noise": 2e-9}, NOTE),
    ],
)
def test_noise_is_a_note_unless_it_is_a_guess_and_most_of_the_gradient(exponent, share, instrument, outcome):
    white = {"top_exponent": exponent, "noise_floor": 2e-9, "noise_gradient_share": share}
    assert found(0.2, white | instrument, budget=["instrument"])["Noise"].outcome == outcome


@pytest.mark.parametrize(
    ("step", "budget", "outcome"),
    [
        (0.0, [], PASSED),
        (2e-9, [], PASSED),
        (2.1e-9, [], REVIEW),
        (4e-8, ["instrument"], NOTE),
        (4.1e-8, ["instrument"], REVIEW),  # beyond what the interval was held against
    ],
)
def test_steps_of_the_heights_are_a_note_where_the_interval_holds(step, budget, outcome):
    heights = {"quantisation_step": step, "Sq": 1e-7}
    assert found(0.2, heights, budget=budget)["Quantisation"].outcome == outcome


def test_waves_beyond_the_lens_ask_for_a_look():
    lens = {
        "band_shortest": 2e-6,
        "reliable_wavelength": 5e-6,
        "reliable_reason": "the lens (numerical aperture 0.1)",
    }
    check = found(0.2, lens)["Band"]
    assert check.outcome == REVIEW
    assert "5.00 µm" in check.sentence
    assert found(0.2, lens | {"band_shortest": 5e-6})["Band"].outcome == PASSED
    pixels = lens | {"reliable_reason": "two pixels"}
    assert found(0.2, pixels)["Band"].outcome == NOT_MADE


def test_a_hardness_that_is_reached_is_noted_with_the_plasticity_index():
    assert found(0.2, hardness=8e8)["Plasticity"].outcome == PASSED
    check = found(0.2, hardness=8e7)["Plasticity"]
    assert check.outcome == NOTE  # the settings ask for it
    assert "80.0 MPa" in check.sentence
    assert np.isclose(1e9 * 0.1 / 8e7, 1.25)
    assert "1.2" in check.sentence or "1.3" in check.sentence


def test_what_the_user_asked_for_and_which_channel_was_chosen_are_notes():
    chosen, doubt = "channel 'Height', the first of 2, was read", "all heights are equal"
    spikes = "3 points lie far above all others"
    for warnings, threshold, outcome in (
        ([], None, PASSED),
        ([chosen], None, NOTE),
        ([chosen, spikes], None, REVIEW),
        ([chosen, spikes], 10.0, NOTE),  # the check of the outliers judges them
        ([chosen, doubt], 10.0, REVIEW),
    ):
        height = {"warnings": warnings, "facts": [chosen], "spikes": {s: s for s in {spikes} & {*warnings}}}
        height = {f"ingest_{name}": json.dumps(value) for name, value in height.items()}
        assert map_checks.reading(height, {"outlier_threshold": threshold}).outcome == outcome


def test_the_name_of_a_file_keeps_its_letters():
    warnings = ["a1.txt: no unit of heights", "no pixel size"]
    read = {"ingest_warnings": json.dumps(warnings), "source_file": "b.txt + a1.txt"}
    assert map_checks.reading(read, {}).sentence == "a1.txt: no unit of heights. No pixel size."


def test_removed_spikes_are_told_once():
    findings = [f"{count} points lie far {side} all others" for count, side in ((3, "above"), (1, "below"))]
    spikes = {f"{finding}; advice": finding for finding in findings}
    read = {"ingest_warnings": json.dumps([*spikes]), "ingest_spikes": json.dumps(spikes)}
    assert map_checks.reading(read, {}).sentence.count("; advice") == 2
    for rejected, result in ((4, "and removed"), (0, "in vain: none was removed")):
        check = map_checks.reading(read, {"outlier_threshold": 6.0, "outliers_rejected": rejected})
        assert check.sentence == (
            "3 points lie far above all others. 1 points lie far below all others; "
            f"isolated ones were searched for {result}."
        )
