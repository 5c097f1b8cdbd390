"""Choices and limits: settings, verbs and tables of functions take the same words and the same tolerances."""

import math
import subprocess
import sys
from typing import Literal, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from pydantic import ValidationError

from roughcontact import SettingsError, error_budget, height_map, level, periodic_window, solve_contact
from roughcontact.arguments import choices
from roughcontact.arguments.choices import check_choice
from roughcontact.arguments.settings.models import Contact, Level, Uncertainty, Window
from roughcontact.contact.elasticity.halfspace import zero_frequency_compliance
from roughcontact.contact.elasticity.influence import INFLUENCE
from validation.crosscheck import CODES, OutsideCode

SECTIONS = [(Level, level), (Window, periodic_window), (Contact, solve_contact)]
WORDS = {name: kind for name, kind in vars(choices).items() if get_origin(kind) is Literal}


@pytest.mark.parametrize(("section", "verb"), SECTIONS, ids=lambda function: function.__name__)
def test_a_setting_takes_the_words_of_its_verb(section, verb):
    chosen = {
        key: field.annotation
        for key, field in section.model_fields.items()
        if get_origin(field.annotation) is Literal
    }
    assert chosen
    hints = get_type_hints(verb)
    assert chosen == {key: hints[key] for key in chosen}


def test_sources_of_the_settings_are_those_of_the_verb():
    assert get_args(get_type_hints(error_budget)["sources"]) == get_args(
        Uncertainty.model_fields["sources"].annotation
    )


def test_every_word_has_what_it_names():
    assert tuple(INFLUENCE) == get_args(choices.Influence)
    assert tuple(CODES) == get_args(OutsideCode)
    for rule in get_args(choices.ZeroFrequency):
        assert zero_frequency_compliance(rule, lengths=(1.0, 1.0)) >= 0


@pytest.mark.parametrize(("section", "verb"), SECTIONS, ids=lambda function: function.__name__)
def test_a_verb_refuses_a_word_that_the_settings_refuse(section, verb):
    surface = height_map(np.random.default_rng(0).standard_normal((4, 4)), 1.0)
    problem = {"contact_modulus": 1.0, "mean_pressure": 1.0} if verb is solve_contact else {}
    for key, field in section.model_fields.items():
        if get_origin(field.annotation) is Literal:
            with pytest.raises(SettingsError, match=f"{key} = 'nothing': .*{get_args(field.annotation)[-1]}"):
                verb(surface, **problem, **{key: "nothing"})
            with pytest.raises(ValidationError):
                section(**{key: "nothing"})


@pytest.mark.parametrize(
    ("tolerance", "valid"),
    [
        (choices.MIN_TOLERANCE, True),
        (math.nextafter(choices.MIN_TOLERANCE, 0), False),
        (math.nextafter(1, 0), True),
        (1, False),
    ],
)
def test_settings_and_solver_take_the_same_tolerances(tolerance, valid):
    surface = height_map(np.random.default_rng(0).standard_normal((4, 4)), 1.0)

    def accepted(refusal, verb, **options):
        try:
            verb(**options, tolerance=tolerance)
        except refusal:
            return False
        return True

    assert accepted(ValidationError, Contact) is valid
    problem = {"window": surface, "contact_modulus": 1.0, "mean_pressure": 1.0, "on_failure": "flag"}
    assert accepted(SettingsError, solve_contact, **problem) is valid


def test_the_smallest_tolerance_is_what_rounding_leaves_of_the_smallest_maps():
    surface = height_map([[1.0, 0.0]], 1.0)
    problem = {"contact_modulus": 1.0, "mean_pressure": 0.5}
    solved = solve_contact(surface, **problem, tolerance=choices.MIN_TOLERANCE)
    assert 0.5 * choices.MIN_TOLERANCE < float(solved["rounding_floor"][0]) < choices.MIN_TOLERANCE


@pytest.mark.cases
def test_a_word_that_is_none_is_refused_with_the_valid_ones(kind, value, message):
    for word in get_args(WORDS[kind]):
        check_choice("key", word, WORDS[kind])
    with pytest.raises(SettingsError) as caught:
        check_choice("key", value, WORDS[kind])
    assert str(caught.value).startswith(message)


def test_settings_and_choices_import_nothing_heavy():
    """Snakemake reads the settings in every job, before anything is computed."""
    program = (
        "import sys, roughcontact.arguments.settings.resolve, roughcontact.study.table.columns\n"
        "print(*sys.modules.keys() & {'numpy', 'scipy', 'xarray', 'pandas', 'netCDF4'})"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.split() == []
