"""The limits of every setting, and the sentence for every way to miss them."""

import math
import re
from typing import get_args, get_origin

import pytest
import yaml
from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from case_tables import cases_of

from roughcontact.arguments import checking
from roughcontact.arguments.choices import MIN_TOLERANCE
from roughcontact.arguments.ranges import OF_BODIES, name_of_range
from roughcontact.arguments.settings.fields import section_model
from roughcontact.arguments.settings.models import Section, Settings
from roughcontact.arguments.settings.plausible import Range
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.errors import SettingsError

SMALLEST = math.ulp(0.0)
# with its unit: meant as it stands
SMALLEST_PRESSURE, SMALLEST_LENGTH = f"{SMALLEST} Pa", f"{SMALLEST} m"
ABOVE_ONE, BELOW_ONE = math.nextafter(1, 2), math.nextafter(1, 0)
STEEL = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "hardness": None}
# what else may be said of a body, where it is said of both
MORE = {"yield_stress": 4e8, "thermal_conductivity": 50.0, "electrical_resistivity": 2e-7}
MORE |= dict.fromkeys(("base", "layers", "creep_modulus", "relaxation"))
MORE |= {"name": "steel"} | {name_of_range(name): None for name in OF_BODIES}
SERIES = {"long_time_modulus": 1e6, "moduli": 1e6, "times": 1.0}
COATING = {"thickness": 1e-6, "youngs_modulus": 2e11, "poissons_ratio": 0.2}
COATING |= {"thermal_conductivity": 2.0, "electrical_resistivity": 1e-3}
SEAL = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 2e-3, "perimeter": 0.1}
SEAL |= {"outlet_pressure": 1e5}
JOINT = {
    "area": 1e-4,
    "heat_flow": 1.0,
    "gas_conductivity": 0.026,
    "temperature_jump": 4e-7,
    "film_thickness": 1e-8,
    "film_conductivity": 2.0,
}
FRICTION = {"coefficient": 0.2, "shear_strength": "50 MPa", "speed": "1 m/s"}
REQUIREMENT = {"gap": 1e-6}
NESTED = {"seal": SEAL, "joint": JOINT, "friction": FRICTION, "requirement": REQUIREMENT}
ENDLESS = [math.inf, -math.inf, math.nan]

# setting: what is just within its limits, what is just beyond
LIMITS = {
    "level.order": ([1, 12], [0, 13]),
    "level.max_missing": ([0, 1], [-SMALLEST, ABOVE_ONE]),
    "composite.shifts": ([1, 100], [0, 101]),
    "composite.rotations": ([[0], [-400.0, 400.0], [1.0] * 360], [[], [1.0] * 361]),
    "composite.overlap": ([SMALLEST, 1], [0, ABOVE_ONE]),
    "composite.seed": ([0, 2**32 - 1], [-1, 2**32]),
    "window.width": ([SMALLEST, 0.5], [0, math.nextafter(0.5, 1)]),
    "window.min_share": ([0, 1], [-SMALLEST, ABOVE_ONE]),
    "form.radius": ([1e-6, [1e-6], [1.0, 2.0]], [0, [], [1, -1], [1, 2, 3]]),
    "contact.bodies": ([[STEEL | MORE] * 2], [[], [STEEL], [STEEL] * 3]),
    "contact.bodies.youngs_modulus": ([f"{checking.SMALLEST} Pa"], [0, -1]),
    "contact.bodies.poissons_ratio": ([math.nextafter(-1, 0), 0.5], [-1, math.nextafter(0.5, 1)]),
    "contact.bodies.creep_modulus": ([{"3600.0": 1e9}, None], [{-1: 1e9}, {"1 h": 0}]),
    "contact.time": ([[1.0], [f"{SMALLEST} s", "1 h"]], [0, [], [1, -1]]),
    "contact.bodies.layers.thickness": ([1e-9], [0, -1]),
    "contact.bodies.layers.youngs_modulus": ([1e9], [0, -1]),
    "contact.bodies.layers.poissons_ratio": ([math.nextafter(-1, 0), 0.5], [-1, math.nextafter(0.5, 1)]),
    "contact.force": ([f"{SMALLEST} N", [f"{SMALLEST} N"], [1.0, 2.0]], [0, [], [1, -1]]),
    "contact.mean_pressure": (
        [SMALLEST_PRESSURE, [SMALLEST_PRESSURE], [1e5, 2e5, 3e5], None],
        [0, [], [0], [1e6, -1]],
    ),
    "contact.relative_pressure": ([SMALLEST, [SMALLEST], [1, 2, 3], None], [0, [], [0], [1, -1]]),
    "contact.target_area": ([[SMALLEST], [0.5, BELOW_ONE], None], [0, 1, [], [0.5, 1]]),
    "contact.target_gap": ([[SMALLEST_LENGTH], [1e-7, 2e-7], None], [0, [], [1e-7, -1]]),
    "contact.unload": ([[SMALLEST_PRESSURE], [1e5, 2e5], None], [0, [0], [1e6, -1]]),
    "contact.target": ([["percolation"], None], [[], "yield"]),
    "contact.tolerance": ([MIN_TOLERANCE, BELOW_ONE], [math.nextafter(MIN_TOLERANCE, 0), 1]),
    "statistics.pressure_bins": ([1, 1000], [0, 1001, 1e19]),
    "statistics.gap_bins": ([1, 1000], [0, 1001]),
    "statistics.requirement.gap": ([SMALLEST_LENGTH, None], [0, -1, ">= 1 um"]),
    "statistics.requirement.contact_area": ([SMALLEST, BELOW_ONE, None], [0, 1, "<= 0.5"]),
    "statistics.friction.tangential_load": ([[SMALLEST], [1], None], [0, [], ABOVE_ONE]),
    "uncertainty.windows": ([4, 400], [3, 401]),
    "uncertainty.sources": ([[], ["window"]], [["lens"], "window"]),
    "instrument.numerical_aperture": ([SMALLEST, 1.6, None], [0, math.nextafter(1.6, 2)]),
    "instrument.amplification_z": ([0, BELOW_ONE, None], [-SMALLEST, 1]),
    "instrument.amplification_xy": ([0, BELOW_ONE, None], [-SMALLEST, 1]),
    "contact.contact_modulus_uncertainty": ([0, BELOW_ONE, None], [-SMALLEST, 1]),
    "contact.mean_pressure_uncertainty": ([0, BELOW_ONE, None], [-SMALLEST, 1]),
    **dict.fromkeys(
        (
            "contact.hardness_uncertainty",
            "contact.bodies.youngs_modulus_uncertainty",
            "contact.bodies.hardness_uncertainty",
            "contact.bodies.thermal_conductivity_uncertainty",
            "contact.bodies.electrical_resistivity_uncertainty",
            "contact.bodies.layers.youngs_modulus_uncertainty",
            "contact.bodies.layers.thermal_conductivity_uncertainty",
            "contact.bodies.layers.electrical_resistivity_uncertainty",
            "statistics.friction.shear_strength_uncertainty",
        ),
        ([[0], [BELOW_ONE], [0.5, 3], None], [1, [], [1, 1]]),
    ),
    "wear.coefficient_factor": ([1, 3.5], [BELOW_ONE, 0]),
    "wear.distance": ([f"{SMALLEST} m", [f"{SMALLEST} m"], [1.0, 2.0]], [0, [], [1, -1]]),
    "sliding.direction": ([-400.0, [0.0, 180.0], [float(k) for k in range(36)]], [[], [1.0] * 37]),
    "sliding.speed": ([f"{SMALLEST} m/s", [f"{SMALLEST} m/s"], [1.0, 2.0]], [0, [], [1, -1]]),
    "surfaces": (["s"], [""]),
}
# above nothing
LIMITS |= {
    f"{section}.{name}": (
        [f"{SMALLEST} {unit}" if unit else SMALLEST, *([None] if optional else [])],
        [0, -1],
    )
    for unit, section, names, optional in cases_of("test_settings_limits", "POSITIVE")[1]
    for name in names.split()
}
OTHERS = {
    "composite.rotations",
    "contact.bodies",
    "contact.target",
    "uncertainty.sources",
    "surfaces",
}
NUMBERS = [key for key in LIMITS if key not in OTHERS]
COUNTS = [
    "level.order",
    "composite.shifts",
    "composite.seed",
    "statistics.pressure_bins",
    "statistics.gap_bins",
    "uncertainty.windows",
]


def configured(key, value):
    """Return the smallest configuration in which the setting `key` has this value."""
    if key == "contact.bodies":
        return {"contact": {"bodies": value}}
    if key.startswith("contact.bodies.layers."):
        layer = COATING | {key.rpartition(".")[2]: value}
        return {"contact": {"bodies": [STEEL | MORE, STEEL | MORE | {"layers": [layer]}]}}
    if key == "contact.bodies.creep_modulus":  # by times
        value = {value: 1e9} if isinstance(value, float | str) else value
        value = {"1 h": value} if isinstance(value, bool) else value
    if key == "contact.time":
        return {"contact": {"bodies": [{"relaxation": SERIES}, "rigid"], "time": value}}
    if key.startswith("contact.bodies."):
        hard = {"hardness": 1e9} if key.endswith("hardness_uncertainty") else {}
        return {"contact": {"bodies": [STEEL | MORE, STEEL | MORE | hard | {key.rpartition(".")[2]: value}]}}
    if key.startswith("statistics.") and key.count(".") == 2:
        _, section, name = key.split(".")
        needed = {"seal": SEAL, "joint": JOINT} if section == "requirement" else {}
        return {
            "contact": {"bodies": [STEEL | MORE] * 2},
            "statistics": needed | {section: NESTED[section] | {name: value}},
        }
    config = {"contact": {"contact_modulus": 1e9}}
    if key == "form.radius":
        free = {"contact_modulus": 1e9, "boundary": "free", "force": 1.0}
        return {"form": {"radius": value}, "contact": free}
    if key in ("contact.force", "contact.area"):
        config["contact"] |= {"force": "1 N", "area": "1e-6 m2"}
    if key in ("contact.unload", "contact.hardness_uncertainty"):
        config["contact"] |= {"hardness": 1e10}
    if key.startswith("wear."):
        config["wear"] = {"coefficient": 1e-16, "distance": 1.0}
    if key.startswith("sliding."):
        config["contact"] = {"bodies": [{"relaxation": SERIES}, "rigid"]}
        config["sliding"] = {"speed": 1.0}
    *section, name = key.split(".")
    (config.setdefault(section[0], {}) if section else config)[name] = value
    return config


def without_unit(value):
    """Return a value in a base unit, or each of a list, without that unit."""
    if isinstance(value, list):
        return [without_unit(entry) for entry in value]
    written = isinstance(value, str) and value[:1].isdigit() and " " in value
    if value == "1 h":
        return 3600.0
    return float(value.partition(" ")[0]) if written else value


def said(config):
    """Return the one line that `config` provokes, and the settings that the error names."""
    with pytest.raises(SettingsError) as caught:
        resolve(config)
    (mistake,) = caught.value.mistakes
    assert str(caught.value) == f"mistakes in the settings:\n  {mistake}"
    return str(mistake), mistake.keys


def limited(section=Settings, above=""):
    """Yield the names of all settings with a limit in their type or in their field."""
    for name, field in section.model_fields.items():
        kinds, limits = [field.annotation], list(field.metadata)
        while kinds:
            kind = kinds.pop()
            limits += getattr(kind, "__metadata__", ())
            if isinstance(kind, type) and issubclass(kind, Section):
                yield from limited(kind, f"{above}{name}.")
            kinds += get_args(kind)
        if any(
            isinstance(getattr(limit, "metadata", [limit])[0], Ge | Gt | Le | Lt | MinLen) for limit in limits
        ):
            yield f"{above}{name}"


def all_fields(section=Settings, above=""):
    """Yield name, field, and all that type and field say of each setting, of sections below as well."""
    for name, field in section.model_fields.items():
        kinds, constraints = [field.annotation], list(field.metadata)
        while kinds:
            kind = kinds.pop()
            constraints += [kind, *getattr(kind, "__metadata__", ())]
            kinds += get_args(kind)
            if isinstance(kind, type) and issubclass(kind, Section):
                yield from all_fields(kind, f"{above}{name}.")
        limits = [
            limit for constraint in constraints for limit in getattr(constraint, "metadata", [constraint])
        ]
        yield f"{above}{name}", field, constraints + limits


def test_every_setting_with_a_unit_has_a_range_in_which_bare_numbers_are_plausible():
    """A new key with a unit in its description, or a type with a unit, needs one."""
    ranges = {
        name: constraint
        for name, _, constraints in all_fields()
        for constraint in constraints
        if isinstance(constraint, Range)
    }
    assert len(ranges) >= 25
    for name, field, _ in all_fields():
        text = f"{field.description or ''},"
        units = re.search(r"\b(Pa s|Pa|m|degrees|W m-1 K-1|Ohm m|J m-2)\b[,:;)]", text)
        if units and not section_model(field) and "no unit" not in field.description:
            assert name in ranges, name
    for name, plausible in ranges.items():
        for slip in (plausible.highest * 1e6, plausible.lowest / 1e6 if plausible.lowest > 0 else -1e4):
            if slip >= plausible.rigid:
                continue
            listed = name in (
                "contact.mean_pressure",
                "contact.force",
                "form.radius",
                "contact.target_gap",
                "contact.unload",
                "contact.time",
                "wear.distance",
                "sliding.speed",
                "sliding.direction",
                "composite.rotations",
            )
            (line, _) = said(configured(name, [slip] if listed else slip))
            assert "write the unit behind it, even if the number is correct" in line
            with_unit = f"{slip:.17e} {plausible.base}"
            if name != "contact.unload" or slip < 1e9:  # loads above the hardness are refused
                resolve(configured(name, [with_unit] if listed else with_unit))


def test_every_count_and_every_list_has_an_upper_limit():
    """But for words, which may be given once each, and bodies, of which there are two."""
    counted = 0
    for name, _, constraints in all_fields():
        if int in constraints:
            counted += 1
            assert any(isinstance(constraint, Le | Lt) for constraint in constraints), name
            assert any(isinstance(constraint, Ge | Gt) for constraint in constraints), name
        if any(get_origin(constraint) is list for constraint in constraints):
            counted += 1
            assert any(isinstance(constraint, MaxLen) for constraint in constraints), name
    assert counted >= 15


@pytest.mark.cases
def test_a_slip_of_unit_is_asked_for_with_what_was_meant(key, value, meant):
    line, keys = said(configured(key, value))
    number = value[0] if isinstance(value, list) else value
    assert f" = {number!r}: " in line
    assert meant in line.partition("?")[0]
    assert keys == (".".join(key.split(".")[:2]),)


def test_the_table_names_every_setting_that_has_a_limit():
    assert set(limited()) <= set(LIMITS)
    assert len(set(limited())) >= 20


@pytest.mark.parametrize("key", LIMITS)
def test_what_is_within_the_limits_is_kept(key):
    for value in LIMITS[key][0]:
        settings = resolve(configured(key, value))[""]
        for part in key.split("."):
            settings = settings[-1][part] if isinstance(settings, list) else settings[part]
        several = (
            key.endswith(
                ("_pressure", "force", "form.radius", "distance", "sliding.speed", "sliding.direction")
            )
            and key not in ("wear.mean_pressure", "sliding.mean_pressure")
            and not key.startswith("statistics")
        )
        loads = several and isinstance(value, float | str)
        assert settings == without_unit([value] if loads else value)


@pytest.mark.parametrize("key", LIMITS)
def test_what_is_beyond_the_limits_is_refused_by_its_name(key):
    for value in LIMITS[key][1]:
        line, keys = said(configured(key, value))
        assert line.startswith(key.replace("bodies.", "bodies[1].").replace("layers.", "layers[0]."))
        assert keys == (".".join(key.split(".")[:2]),)


@pytest.mark.parametrize("value", ENDLESS, ids=str)
@pytest.mark.parametrize("key", NUMBERS)
def test_infinities_and_nan_are_no_numbers(key, value):
    line, _ = said(configured(key, value))
    assert f" = {value!r}: must be a finite number" in line


@pytest.mark.parametrize("value", ENDLESS, ids=str)
@pytest.mark.parametrize("key", ["contact.mean_pressure", "contact.relative_pressure", "composite.rotations"])
def test_infinities_and_nan_are_no_numbers_in_lists_either(key, value):
    line, _ = said(configured(key, [1e6 if key == "contact.mean_pressure" else 1.0, value]))
    assert line.startswith(f"{key}[1] = {value!r}: ")


@pytest.mark.parametrize("value", [True, False])
@pytest.mark.parametrize("key", [key for key in NUMBERS if key != "contact.unload"])  # true: the largest load
def test_true_and_false_are_no_numbers(key, value):
    assert f" = {value}: must be a number" in said(configured(key, value))[0]


@pytest.mark.parametrize("key", COUNTS)
def test_a_count_is_a_whole_number(key):
    assert f"{key} = 5.5: must be a whole number" in said(configured(key, 5.5))[0]
    assert f"{key} = 'many': " in said(configured(key, "many"))[0]
    section, name = key.split(".")
    lowest, highest = LIMITS[key][0]
    assert resolve(configured(key, str(highest)))[""][section][name] == highest > lowest


@pytest.mark.parametrize(
    ("contact", "line"),
    [
        (
            {},
            (
                "contact: no elasticity given; give either contact_modulus (E* in Pa) or bodies (two of a "
                "material's name, or youngs_modulus in Pa and poissons_ratio): bodies: [steel, "
                "{youngs_modulus: 4 GPa, poissons_ratio: 0.4}]"
            ),
        ),
        (
            {"contact_modulus": 1e9, "bodies": [STEEL, STEEL]},
            (
                "contact: contact_modulus and bodies given; give either contact_modulus (E* in Pa) or bodies "
                "(two of a material's name, or youngs_modulus in Pa and poissons_ratio)"
            ),
        ),
        (
            {"contact_modulus": 1e9, "mean_pressure": 1e6, "relative_pressure": 1},
            "contact: mean_pressure (Pa) and relative_pressure (no unit) given; give one of them or neither",
        ),
    ],
)
def test_what_excludes_each_other_is_said_in_one_sentence(contact, line):
    assert said({"contact": contact}) == (line, ())
    case = {"contact": {"tolerance": 0.1} | contact}
    assert said({"cases": {"one": case}}) == (line.replace("contact:", "cases.one.contact:", 1), ())
    # what is wrong above the cases is named there, once
    assert said({"contact": contact, "cases": {"one": {}, "two": {}}}) == (line, ())


@pytest.mark.cases
def test_settings_that_do_not_fit_have_one_sentence(settings, words):
    assert re.search(words, said(yaml.safe_load(f"{{{settings}}}"))[0])


def test_a_list_of_too_many_loads_is_not_shown_whole():
    line, _ = said({"contact": {"contact_modulus": "1 GPa", "mean_pressure": [*range(90_000)]}})
    assert re.search(r"\[0, 1, [0-9, ]+1[0-9,]+ \.\.\.: a list of 90000, more than the 1000", line)
