"""The limits of the checks: what lies at a limit passes, what lies just beyond asks for a look or fails."""

import ast
import inspect
import json
from collections import defaultdict

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.arguments import materials
from roughcontact.arguments.answers import ANSWERS
from roughcontact.statistics import (
    checks,
    contact_checks,
    instrument_checks,
    local_scale_checks,
    map_checks,
    outcome,
)
from roughcontact.statistics.outcome import (
    FAILED,
    NOT_MADE,
    NOTE,
    PASSED,
    REVIEW,
    Check,
    brief_reason,
)
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import rough_reference_surface, self_affine_surface


def per_load(**columns):
    """Return a dataset of columns along the loads."""
    return xr.Dataset({name: ("load", np.atleast_1d(values)) for name, values in columns.items()})


def test_the_table_of_checks_has_each_case_of_the_code_and_no_more():
    cases = defaultdict(set)
    for module in (contact_checks, instrument_checks, local_scale_checks, map_checks):
        functions = [node for node in ast.parse(inspect.getsource(module)).body if hasattr(node, "args")]
        for node in (inner for function in functions for inner in ast.walk(function)):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "judge":
                function = next(whole for whole in functions if node in ast.walk(whole))
                dictionaries = [
                    part.value
                    for part in ast.walk(function)
                    if isinstance(part, ast.Assign) and getattr(part.targets[0], "id", "") == "cases"
                ]
                literal = [node.args[1]] if isinstance(node.args[1], ast.Dict) else dictionaries
                cases[node.args[0].value] |= {key.value for each in literal for key in each.keys}
    assert {name: {*rows} - {""} for name, rows in outcome._CASES.items()} == cases
    rows = [row for rows in outcome._CASES.values() for row in rows.values()]
    assert {row.outcome for row in rows} == {PASSED, NOTE, REVIEW, FAILED, NOT_MADE}
    assert {answer for row in rows for answer in row.answers} == {*ANSWERS}


def test_a_doubt_of_the_modulus_without_another_unit_ends_its_sentence():
    softer_than_all = per_load(mean_pressure=1e-12).assign(contact_modulus=1e-12)
    assert contact_checks.units(softer_than_all).sentence == (
        "Contact modulus: 1.00 pPa is softer than any gel (1.00 kPa)."
    )


@pytest.mark.parametrize("load_settings", [{}, {"target_area": 0.01}])
def test_the_unit_of_a_load_that_nobody_stated_is_not_doubted(load_settings):
    smooth = rough_reference_surface(64) * 1e-6
    contact = {"contact_modulus": "1 GPa"}
    solved = rc.evaluate(smooth, contact=contact | load_settings, uncertainty={"sources": []})
    loads = solved["mean_pressure"].values
    relative = rc.evaluate(
        smooth, contact=contact | {"relative_pressure": 0.005}, uncertainty={"sources": []}
    )
    assert contact_checks.units(relative).outcome == REVIEW
    assert loads.min() < materials.MIN_LOAD
    for statistics in (solved, solved.isel(load=[0])):
        check = contact_checks.units(statistics)
        assert (check.outcome, check.sentence) == (
            PASSED,
            "A contact modulus of 1.00 GPa is that of real materials; no load is stated.",
        )
    assert "Units" not in {reason["check"] for reason in json.loads(solved.attrs["reasons"])}
    assert "Units" in {reason["check"] for reason in json.loads(relative.attrs["reasons"])}


@pytest.mark.parametrize(("counted", "outcome"), [(100, PASSED), (99, REVIEW)])
def test_a_hundred_points_in_contact_are_enough(counted, outcome):
    statistics = per_load(relative_contact_area_pixels=[counted / 4096, 0.5])
    assert contact_checks.contact_points(statistics, 4096).outcome == outcome


@pytest.mark.parametrize(("excess", "outcome"), [(0.1999, PASSED), (0.2001, REVIEW)])
def test_counting_may_overstate_the_area_by_a_fifth(excess, outcome):
    statistics = per_load(
        points_per_shortest_wavelength=8.0,
        relative_contact_area=0.1,
        relative_contact_area_pixels=0.1 * (1 + excess),
    )
    assert contact_checks.resolution(statistics).outcome == outcome


@pytest.mark.parametrize(
    ("share", "outcome"), [(0.01, PASSED), (0.0101, REVIEW), (0.1, REVIEW), (0.1001, FAILED)]
)
def test_contact_on_points_that_were_not_measured(share, outcome):
    statistics = per_load(contact_on_filled_points=[0.0, share])
    check = map_checks.missing_points(statistics, {"missing_share": 0.02}, {"filled_share": 0.02})
    assert check.outcome == outcome
    assert ("that of the filling" in check.sentence) == (outcome != PASSED)


@pytest.mark.parametrize(
    ("check", "window", "outcome"),
    [
        (map_checks.window_share, {"window_share": 0.5}, PASSED),
        (map_checks.window_share, {"window_share": 0.499}, REVIEW),
        (map_checks.window_share, {}, PASSED),
        (map_checks.steep_places, {"steepest_share": 0.5}, PASSED),
        (map_checks.steep_places, {"steepest_share": 0.501}, NOTE),
        (map_checks.band, {"reliable_reason": "the lens", "band_shortest": 4e-6}, PASSED),
    ],
)
def test_limits_of_the_window(check, window, outcome):
    assert check(window).outcome == outcome


@pytest.mark.parametrize(("share", "outcome"), [(0.8, PASSED), (0.801, REVIEW)])
@pytest.mark.parametrize(
    ("taken_off", "way_out"),
    [("plane", "level.form"), ("polynomial", "window.method"), ("sphere", "window.method")],
)
def test_a_bow_may_make_up_four_fifths(share, outcome, taken_off, way_out):
    check = map_checks.form({"form": taken_off}, {"form_share": share})
    assert check.outcome == outcome
    assert (way_out in check.sentence) == (outcome == REVIEW)


@pytest.mark.parametrize(
    ("gradient_before", "gradient_after", "removed", "heights", "outcome"),
    [
        (1.0, 1.0999, 0.0, 0.5, PASSED),
        (1.0, 1.1001, 0.0, 0.0, REVIEW),
        (1.0, 0.8999, 0.0, 0.0, REVIEW),
        (1.0, 1.0, 0.0, 0.501, REVIEW),
        (1.0, 0.6, 0.8, 0.0, PASSED),  # what the band took out was asked for
        (0.0, 1.0, 0.0, 0.0, PASSED),
    ],
)
def test_periodisation_may_change_the_gradient_by_a_tenth(
    gradient_before, gradient_after, removed, heights, outcome
):
    check = map_checks.periodicity(
        {
            "periodisation": "mirror",
            "rms_gradient_before": gradient_before,
            "rms_gradient_after": gradient_after,
            "band_removed_rms_gradient": removed,
            "periodisation_relative_change": heights,
        }
    )
    assert check.outcome == outcome


@pytest.mark.parametrize(
    ("gradient", "outcome"), [(0.3, PASSED), (0.301, NOTE), (0.601, REVIEW), (3.0, REVIEW), (3.01, FAILED)]
)
def test_limits_of_the_slope(gradient, outcome):
    assert map_checks.slope(xr.Dataset({"rms_gradient": gradient})).outcome == outcome


@pytest.mark.parametrize(
    ("length_y", "aspect", "outcome"),
    [(5.0, 0.5, PASSED), (4.99, 0.5, REVIEW), (np.nan, np.nan, PASSED)],  # a profile has a length alone
)
def test_five_autocorrelation_lengths_are_enough(length_y, aspect, outcome):
    statistics = xr.Dataset({"Sal": 1.0, "Str": aspect, "window_length_x": 9.0, "window_length_y": length_y})
    assert map_checks.longest_wave(statistics).outcome == outcome


PAIR = {"face_pitches": [1e-6, 2e-6], "covered_share_of_larger": 0.25}


@pytest.mark.parametrize(
    ("levelled", "shortest", "outcome", "message"),
    [
        (PAIR, 2e-6, PASSED, "pixels of 1.00 µm and 2.00 µm, and 25.0 % of the larger one"),
        (PAIR | {"face_pitches": [2.01e-6, 1e-6]}, 2e-6, REVIEW, "2.01 µm and 1.00 µm: the coarser"),
        (PAIR | {"face_pitches": [1e-6, 9.99e-6]}, 2e-6, REVIEW, "areas are 19.6 % or more too large"),
        (
            PAIR | {"face_pitches": [1e-6, 1e-3]},
            2e-6,
            FAILED,
            "1.00 µm and 1.00 mm: the coarser one has no wave",
        ),
        (PAIR | {"face_pitches": [1e-6, 1e-3]}, 2e-3, PASSED, "pixels of 1.00 µm and 1.00 mm, and"),
        # 8 of 48 µm
        (
            PAIR | {"covered_share_of_larger": 1 / 36},
            2e-6,
            REVIEW,
            "Only 2.78 % of the larger face is solved",
        ),
    ],
)
def test_faces_of_unlike_pixels_or_sizes_are_named(levelled, shortest, outcome, message):
    check = map_checks.faces(levelled, {"band_shortest": shortest})
    assert check.outcome == outcome
    assert message in check.sentence
    assert ("window.shortest_wavelength: " in check.sentence) == ("coarser" in check.sentence)


def test_two_equally_rough_faces_are_as_much_too_smooth_as_the_check_says():
    """The area goes as 1 / g (Persson 2001), the mean square gradient of both faces adds up."""
    waves = {"hurst": 0.8, "longest": 1024e-6, "rms_height": 1e-6}
    square = {
        ratio: rms_gradient(self_affine_surface((1024, 1024), 1e-6, **waves, shortest=2e-6 * ratio)) ** 2
        for ratio in (1, 2, 10)
    }
    for ratio, claimed in ((2, 0.07), (10, 0.2)):
        excess = np.sqrt(2 * square[1] / (square[1] + square[ratio])) - 1
        assert claimed <= round(excess, 2) < 1.3 * claimed


def test_words_of_a_load_at_each_limit():
    limits = {
        "relative_contact_area_pixels": 0.12,
        "relative_contact_area": 0.1,
        "contact_on_filled_points": 0.01,
        "mean_contact_pressure": 0.1e9,
    }
    at_the_limit = per_load(converged=1, max_pressure=0.2e9, **limits).assign(contact_modulus=1e9)
    at_the_limit["relative_contact_area"] = at_the_limit["relative_contact_area_pixels"] / 1.199
    assert checks.load_flags(at_the_limit, 1000) == [["metals would yield"]]
    slightly_more = per_load(
        converged=0, max_pressure=0.2e9, **{name: 1.01 * value for name, value in limits.items()}
    )
    slightly_more["relative_contact_area"] = slightly_more["relative_contact_area_pixels"] / 1.201
    assert checks.load_flags(slightly_more.assign(contact_modulus=1e9), 800) == [
        [
            "not converged",
            "few contact points",
            "coarse patches",
            "contact on filled points",
            "any material would yield",
        ]
    ]


@pytest.mark.parametrize(("letters", "finding"), [(55, ""), (65, "Much of the gradient may be noise. ")])
def test_a_reason_has_what_to_do_in_place_of_a_finding_that_is_too_long_and_is_never_cut(letters, finding):
    check = Check("Noise", REVIEW, "Much of the gradient may be noise.", advice="Measure the noise.")
    assert brief_reason(check, letters) == f"Noise: {finding}Measure the noise"
    assert brief_reason(check._replace(advice=""), 10) == "Noise: Much of the gradient may be noise"
