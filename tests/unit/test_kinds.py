"""Facts of the kinds of problem: each rule has one sentence, for functions and settings alike."""

from itertools import chain

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.arguments import kinds
from roughcontact.arguments.settings.fields import fields_at
from roughcontact.arguments.settings.models import Friction, Joint, Seal, Settings
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.evaluation.kinds import KINDS, kind_of
from roughcontact.evaluation.kinds.finite_body import FiniteBody
from roughcontact.evaluation.kinds.local_scale import LocalScale
from roughcontact.evaluation.kinds.periodic_map import PeriodicMap
from roughcontact.evaluation.kinds.profiles.ridges import Ridges
from roughcontact.evaluation.kinds.profiles.surface_behind import SurfaceBehindProfiles

BALL = rc.height_map(-np.add.outer(np.linspace(-1, 1, 16) ** 2, np.linspace(-1, 1, 16) ** 2), 0.1, unit="m")
FREE = {"contact_modulus": "1 GPa", "boundary": "free", "force": "1 N"}
# arguments without a setting, and what functions ask for by these names
OF_FUNCTIONS = {
    "run_in",
    "sliding_friction",
    "force",
    "mean_pressure",
    "arrays",
    "solution",
    "contact_table",
    "surface behind profiles",
}


@pytest.mark.parametrize("options", [{"zero_frequency": "lattice"}, {"precision": "single"}])
def test_functions_and_settings_refuse_with_the_same_sentence(options):
    (name,) = options
    with pytest.raises(rc.SettingsError) as of_function:
        rc.solve_contact(BALL, **FREE, **options)
    with pytest.raises(rc.SettingsError) as of_settings:
        resolve({"contact": FREE | options})
    reason = kinds.FINITE_BODY.reason_against(f"contact.{name}")
    assert str(of_function.value) == f"{name}, boundary 'free': {reason}"
    assert str(of_settings.value).splitlines()[1:] == [f"  contact.{name} = {options[name]!r}: {reason}"]


def test_every_rule_is_of_a_setting_that_there_is():
    names = {f"{section}.{key}" for section in Settings.model_fields for key in fields_at([section])}
    groups = {"friction": Friction, "joint": Joint, "seal": Seal}
    names |= {f"statistics.{name}.{key}" for name, group in groups.items() for key in group.model_fields}
    names |= {*Settings.model_fields}
    for facts in kinds.KIND_FACTS:
        rules = {*chain.from_iterable(facts.excluded.values()), *facts.admitted}
        rules -= OF_FUNCTIONS
        assert {rule.partition(" = ")[0] for rule in rules} <= names


def test_facts_by_the_word_of_settings_and_results():
    assert kinds.facts_of({"boundary": "free"}) is kinds.FINITE_BODY
    assert kinds.facts_of({}) is kinds.facts_of({"boundary": ["no word"]}) is kinds.PERIODIC_MAP
    assert kinds.facts_of_settings({"form": {"local_scale": True}, "contact": None}) is kinds.LOCAL_SCALE
    assert (
        kinds.facts_of_settings({"form": "no section", "contact": {"boundary": "free"}}) is kinds.FINITE_BODY
    )


def test_the_force_on_a_map_is_its_pressure_times_its_area():
    assert kinds.FINITE_BODY.arguments(3.0, 2.0) == {"boundary": "free", "force": 6.0}
    assert kinds.FINITE_BODY.coordinates(6.0, 2.0) == {"mean_pressure": 3.0, "force": 6.0}
    assert kinds.PERIODIC_MAP.arguments(3.0, 2.0) == {"boundary": "periodic", "mean_pressure": 3.0}
    assert kinds.PERIODIC_MAP.coordinates(3.0, 2.0) == {"mean_pressure": 3.0}


@pytest.mark.parametrize(
    ("height", "settings", "kind"),
    [
        (BALL, {}, PeriodicMap),
        (BALL, {"contact": {"boundary": "free"}}, FiniteBody),
        (BALL[:1], {}, Ridges),
        (BALL[:1].assign_attrs(lay="none"), {}, SurfaceBehindProfiles),
        (BALL, {"form": {"local_scale": True}}, LocalScale),
    ],
)
def test_the_kind_of_a_map(height, settings, kind):
    assert type(kind_of(height, settings)) is kind


def test_a_new_kind_is_a_module_and_a_line():
    """The last kind includes all maps, so that one is always found; none stands there twice."""
    assert KINDS[-1].includes(BALL, {})
    assert len({*KINDS}) == len(KINDS)
