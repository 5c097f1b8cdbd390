"""Settings: generated files in step with the models, models in step with the verbs, all mistakes at once."""

import inspect
import json
import re
from pathlib import Path

import pytest
import yaml
from case_tables import cases_of
from pydantic import ValidationError

from roughcontact.arguments.settings.generated import default_yaml, json_schema
from roughcontact.arguments.settings.models import Contact, Settings
from roughcontact.arguments.settings.resolve import contact_modulus, resolve
from roughcontact.contact.loads import plan_loads
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import SettingsError
from roughcontact.report.page import write_report
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.statistics.targets import target_loads
from roughcontact.surface.faces.positions import relative_positions
from roughcontact.surface.levelling.level import level
from roughcontact.surface.window.periodic_window import periodic_window
from roughcontact.uncertainty.budget import error_budget

ROOT = Path(__file__).parents[2]
STEEL = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}


def only(config):
    """Return the settings of a configuration without cases."""
    return resolve(config)[""]


def mistakes(config):
    """Return the lines of the message that `config` provokes, without the heading."""
    with pytest.raises(SettingsError) as caught:
        resolve(config)
    heading, *lines = str(caught.value).split("\n")
    assert heading == "mistakes in the settings:"
    return [line.strip() for line in lines]


@pytest.mark.parametrize(
    ("name", "generate"),
    [("config/config.yaml", default_yaml), ("workflow/schemas/config.schema.json", json_schema)],
)
def test_generated_files_are_in_step(name, generate):
    assert (ROOT / name).read_text(encoding="utf-8") == generate(), (
        f"{name} is old: run `PYTHONPATH=workflow/lib python -m roughcontact.arguments.settings .`"
    )
    assert generate().endswith("}\n")  # a file of lines: `cat` and `printf >>` go on below


def test_default_configuration_says_nothing_but_the_defaults():
    written = yaml.safe_load(default_yaml())
    shipped = {key: written["contact"][key] for key in ("bodies", "mean_pressure")}
    assert only(written) == only({"contact": shipped})
    documented = default_yaml()
    for section in ("level", "composite", "window", "contact", "statistics", "uncertainty", "report"):
        for key, field in Settings.model_fields[section].annotation.model_fields.items():
            assert f"{key}:" in documented
            assert field.description.split()[0] in documented


@pytest.mark.parametrize("values_by_section", [None, {}])
def test_the_template_has_every_key_of_the_schema(values_by_section):
    """Each under the one that holds it: keys of bodies and of their layers, too."""
    schema = json.loads(json_schema())
    text = default_yaml(values=values_by_section).replace("# ", "")  # a key may be a comment
    keys = re.findall(r"^( *)([a-z_]+):(?: |$)", text, re.MULTILINE)
    above, documented = [], set()
    for indent, key in keys:
        above = [(depth, name) for depth, name in above if depth < len(indent)] + [(len(indent), key)]
        documented.add(tuple(name for _, name in above))

    def keys_of(part, route=()):
        if "$ref" in part:
            part = schema["$defs"][part["$ref"].rpartition("/")[2]]
        for name, below in part.get("properties", {}).items():
            yield (*route, name)
            yield from keys_of(below, (*route, name))
        for type_ in (*part.get("anyOf", ()), *([part["items"]] if "items" in part else ())):
            yield from keys_of(type_, route)

    required = set(keys_of(schema))
    assert ("contact", "bodies", "layers", "electrical_resistivity") in required
    assert required <= documented


@pytest.mark.parametrize(
    ("section", "verb"), [("level", level), ("window", periodic_window), ("statistics", contact_statistics)]
)
def test_a_section_is_the_keyword_arguments_of_its_verb(section, verb):
    arguments = {
        name: parameter.default
        for name, parameter in inspect.signature(verb).parameters.items()
        if parameter.kind is parameter.KEYWORD_ONLY
    }
    arguments.pop("bodies", None)  # of the section contact
    arguments.pop("surface", None)  # known already to who counts several loads
    arguments.pop("correct_for", None)  # of the section instrument
    assert Settings.model_fields[section].annotation().model_dump() == arguments


def test_no_default_changes_by_mistake():
    """Each default that decides a number, written once more: another one changes results of all users."""
    defaults = dict(cases_of("test_settings", "test_no_default_changes_by_mistake")[1])
    sections = Settings().model_dump(mode="json", exclude={"surfaces", "cases"})
    assert defaults == {
        f"{section}.{key}": value
        for section, values in sections.items()
        for key, value in values.items()
        if value is not None
    }


def test_composite_section_is_the_keyword_arguments_of_the_ensemble():
    parameters = inspect.signature(relative_positions).parameters.values()
    arguments = {
        parameter.name: parameter.default
        for parameter in parameters
        if parameter.kind is parameter.KEYWORD_ONLY
    }
    assert Settings().composite.model_dump() == arguments | {"rotations": list(arguments["rotations"])}


def test_uncertainty_section_is_the_keyword_arguments_of_its_verb():
    arguments = inspect.signature(error_budget).parameters
    defaults = Settings.model_fields["uncertainty"].annotation().model_dump()
    assert tuple(defaults["sources"]) == arguments["sources"].default
    assert defaults["windows"] == arguments["windows"].default
    of_the_chain = {"solved", "scatter_of", "refine"}
    named = {n for n, p in arguments.items() if p.kind is p.KEYWORD_ONLY}
    assert set(defaults) == named - of_the_chain


def test_contact_section_is_the_keyword_arguments_of_its_verbs():
    verbs = (plan_loads, target_loads, solve_contact)
    arguments = {
        name: parameter for verb in verbs for name, parameter in inspect.signature(verb).parameters.items()
    }
    of_the_run = {"window", "solver", "bodies", "fields", "reduce", "arrays", "threads", "progress"}
    of_the_load = {"area", "time"}  # mean pressure is force by area; what comes after a time
    of_the_budget = {f"{name}_uncertainty" for name in ("contact_modulus", "mean_pressure", "hardness")}
    assert (
        set(Contact.model_fields) - {"bodies", "keep_fields", "unload", *of_the_budget, *of_the_load}
        == set(arguments) - of_the_run
    )
    for name in ("tolerance", "zero_frequency", "on_failure"):
        assert Contact.model_fields[name].default == arguments[name].default
    assert "title" in inspect.signature(write_report).parameters


def test_every_description_of_a_quantity_names_its_unit():
    fields = Contact.model_fields
    for name in ("contact_modulus", "mean_pressure"):
        assert "Pa" in fields[name].description


def test_numbers_as_yaml_reads_them():
    settings = only(yaml.safe_load("contact: {contact_modulus: 1e9, mean_pressure: [1e5, 2.0E6, 300]}"))
    assert settings["contact"]["contact_modulus"] == 1e9
    assert settings["contact"]["mean_pressure"] == [1e5, 2e6, 300.0]
    assert only({"contact": {"contact_modulus": 1e9, "relative_pressure": "1e-2"}})["contact"][
        "relative_pressure"
    ] == [0.01]


def test_two_bodies_give_the_contact_modulus():
    assert contact_modulus([STEEL, STEEL]) == pytest.approx(2.1e11 / (2 * (1 - 0.09)), rel=1e-15)
    settings = only({"contact": {"bodies": [STEEL, {"youngs_modulus": 1e6, "poissons_ratio": 0.5}]}})
    assert settings["contact"]["contact_modulus"] == pytest.approx(1e6 / 0.75, rel=1e-4)


@pytest.mark.cases
def test_a_key_that_is_no_text_is_named(text, line):
    (mistake,) = mistakes(yaml.safe_load(text))
    assert mistake.startswith(line)


def test_all_mistakes_at_once():
    lines = mistakes({"level": {"form": 3, "ordr": 2}, "contact": {"tolerance": 7}, "windows": {}})
    assert sorted(line.split(":")[0].split(" ")[0] for line in lines) == [
        "contact",
        "contact.tolerance",
        "level.form",
        "level.ordr",
        "windows",
    ]


def test_an_unknown_material_hides_no_other_mistake():
    contact = {"bodies": ["Stahl", "steel"], "mean_pressure": ["2,5 MPa"]}
    lines = mistakes({"contact": contact, "statistics": {"joint": {"area": "3 kg"}}})
    names = ["contact.bodies", "contact.mean_pressure[0]", "statistics.joint.area"]
    assert [line.split(":")[0].split(" ")[0] for line in lines] == names
    (alone,) = mistakes({"contact": contact | {"mean_pressure": "2.5 MPa"}})
    assert alone.startswith("contact.bodies: 'Stahl' is no material of the table")


def test_cases_lie_over_the_settings_above():
    cases = resolve(
        {
            "contact": {"contact_modulus": "1e9", "mean_pressure": 1e5},
            "level": {"form": "mean"},
            "cases": {
                "base": {},
                "steel": {"contact": {"bodies": [STEEL, STEEL]}},
                "light": {"contact": {"relative_pressure": 0.01}, "level": {"robust": True}},
            },
        }
    )
    assert list(cases) == ["base", "steel", "light"]
    assert cases["steel"]["contact"]["contact_modulus"] == pytest.approx(1.1538e11, rel=1e-4)
    assert cases["steel"]["contact"]["mean_pressure"] == [1e5]
    assert cases["light"]["contact"]["mean_pressure"] is None
    assert cases["light"]["level"] == cases["base"]["level"] | {"robust": True}


def test_what_all_cases_give_need_not_stand_above():
    cases = resolve(
        {"cases": {name: {"contact": {"contact_modulus": value}} for name, value in (("a", 1e9), ("b", 2e9))}}
    )
    assert [case["contact"]["contact_modulus"] for case in cases.values()] == [1e9, 2e9]


@pytest.mark.cases
def test_cases_that_are_none(cases, message):
    (line,) = mistakes({"contact": {"contact_modulus": 1e9}, "cases": cases})
    assert line.startswith(message)


def test_schema_is_json_and_knows_every_key():
    schema = json.loads(json_schema())
    assert set(schema["properties"]) == set(Settings.model_fields)
    assert set(schema["$defs"]["Contact"]["properties"]) == set(Contact.model_fields)
    assert schema["$defs"]["Contact"]["additionalProperties"] is False


@pytest.mark.cases
def test_an_editor_and_the_program_agree_on_what_is_admitted(section, key, good, bad):
    jsonschema = pytest.importorskip("jsonschema")
    validator = jsonschema.Draft202012Validator(json.loads(json_schema()))
    for value, admitted in ((good, True), (bad, False)):
        assert validator.is_valid({section: {key: value}}) == admitted
        try:
            Settings.model_validate({section: {key: value}})
        except ValidationError:
            assert not admitted
        else:
            assert admitted


@pytest.mark.cases
def test_names_of_cases_are_names_of_folders(name, line):
    with pytest.raises(SettingsError) as caught:
        resolve({"contact": {"contact_modulus": 1e9}, "cases": {name: {}}})
    assert [str(mistake) for mistake in caught.value.mistakes] == [line]
    assert list(resolve({"contact": {"contact_modulus": 1e9}, "cases": {"Az-09": {}}})) == ["Az-09"]


def test_cases_that_are_one_folder_on_other_systems_are_named():
    lines_of_message = mistakes(
        {"contact": {"contact_modulus": 1e9}, "cases": {"soft": {}, "hard": {}, "Soft": {}}}
    )
    message = "another case has this name but for capitals; rename one"
    assert lines_of_message == [f"cases.soft: {message}", f"cases.Soft: {message}"]


@pytest.mark.parametrize("key", ["surfaces", "composite", "report", "cases"])
def test_what_is_common_to_all_cases_is_set_at_the_top(key):
    (line,) = mistakes({"contact": {"contact_modulus": 1e9}, "cases": {"a": {key: {}}}})
    assert line == f"cases.a.{key}: is common to all cases, set it at the top"


def test_wrong_cases_leave_the_settings_above_to_be_checked():
    lines = mistakes({"contact": {"contact_modulus": 0}, "cases": {"a b": {"level": {"order": 0}}}})
    assert [line.split(":")[0] for line in lines] == ["cases.a b", "contact.contact_modulus = 0"]


def test_groups_that_are_empty_in_the_file_have_their_defaults():
    plain = only({"contact": {"contact_modulus": 1e9}})
    assert only({"contact": {"contact_modulus": 1e9}, "level": None, "cases": None}) == plain
    assert mistakes({"contact": None})[0].startswith("contact: no elasticity given")


def test_a_case_replaces_what_it_excludes_and_nothing_else():
    above = {"contact": {"bodies": [STEEL, STEEL], "relative_pressure": [0.1, 0.2], "tolerance": 0.1}}
    own_case = {"contact": {"contact_modulus": 5e9, "mean_pressure": None}}
    config = above | {"cases": {"own": own_case, "as-above": {}}}
    cases = resolve(config)
    assert cases["own"]["contact"]["bodies"] is None
    assert cases["own"]["contact"]["contact_modulus"] == 5e9
    assert cases["own"]["contact"]["relative_pressure"] == [0.1, 0.2]  # null gives nothing
    assert cases["own"]["contact"]["tolerance"] == 0.1
    assert cases["as-above"] == only(above)
    assert "cases" not in cases["own"]
    assert config == above | {"cases": {"own": own_case, "as-above": {}}}  # as it was
    assert cases["own"]["window"] is not cases["as-above"]["window"]


def test_a_mistake_is_named_where_it_stands():
    lines = mistakes(
        {
            "contact": {"bodies": [STEEL, {"youngs_modulus": 1e9}]},
            "level": {"order": 0},
            "cases": {
                "one": {"level": {"robust": 7}},
                "two": {"contact": {"bodies": [STEEL, {}]}},
                "three": {"window": 3},
            },
        }
    )
    assert [line.split(" = ")[0].split(": ")[0] for line in lines] == [
        "level.order",
        "cases.one.level.robust",
        "contact.bodies[1].poissons_ratio",
        "cases.two.contact.bodies[1].youngs_modulus",
        "cases.two.contact.bodies[1].poissons_ratio",
        "cases.three.window",
    ]


def test_a_mistake_above_the_cases_is_not_named_as_that_of_a_case_that_gives_other_keys():
    bodies = [STEEL, {"youngs_modulus": -1, "poissons_ratio": 0.2}]
    (line,) = mistakes({"contact": {"bodies": bodies}, "cases": {"fine": {"contact": {"tolerance": 0.1}}}})
    assert line.startswith("contact.bodies[1].youngs_modulus = -1: ")


def test_cases_after_one_that_is_none_are_checked_as_well():
    config = {"contact": {"contact_modulus": 1e9}, "cases": {"a": 3, "b": {"report": {}}, "c": {"cases": {}}}}
    assert [line.split(":")[0] for line in mistakes(config)] == [
        "cases.a = 3",
        "cases.b.report",
        "cases.c.cases",
    ]


def test_force_and_area_are_another_way_to_state_the_mean_pressure():
    contact = resolve(
        {"contact": {"contact_modulus": "1 GPa", "force": ["30 N", "1.5 kN"], "area": "3 cm2"}}
    )[""]
    assert contact["contact"]["mean_pressure"] == pytest.approx([1e5, 5e6])
    pressed = {"contact_modulus": "1 GPa", "mean_pressure": "1 MPa"}
    cases = resolve(
        {"contact": pressed, "cases": {"bolt": {"contact": {"force": "30 N", "area": "300 mm2"}}}}
    )
    assert cases["bolt"]["contact"]["mean_pressure"] == pytest.approx([1e5])
    bolt = {"contact_modulus": "1 GPa", "force": "30 N", "area": "300 mm2"}
    loads = [{"mean_pressure": "1 MPa"}, {"relative_pressure": 0.1}, {"force": "60 N"}]
    cases = resolve(
        {"contact": bolt, "cases": {f"case-{i}": {"contact": load} for i, load in enumerate(loads)}}
    )
    contacts = [case["contact"] for case in cases.values()]
    assert [case["mean_pressure"] for case in contacts] == [[1e6], None, pytest.approx([2e5])]
    assert [case["area"] for case in contacts] == [None, None, pytest.approx(3e-4)]


def test_unload_names_loads_or_the_largest():
    contact = {"contact_modulus": "100 GPa", "mean_pressure": "10 MPa", "hardness": "2 GPa"}
    read = [
        resolve({"contact": contact | {"unload": value}})[""]["contact"]["unload"]
        for value in (True, False, "5 MPa", ["5 MPa", 1e7])
    ]
    assert read == [[], None, [5e6], [5e6, 1e7]]
