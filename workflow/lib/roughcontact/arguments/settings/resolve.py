"""From the content of a YAML file to checked settings of each case, or one error that lists all mistakes."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from itertools import chain, starmap
from typing import Any

from pydantic import ValidationError

from roughcontact.arguments.bodies import check_bodies
from roughcontact.arguments.kinds import facts_of_settings
from roughcontact.arguments.materials import contact_modulus
from roughcontact.arguments.named_materials import modulus_uncertainty, named_bodies
from roughcontact.arguments.ranges import OF_BODIES, ends, name_of_range, shares_of_range
from roughcontact.arguments.settings.messages import mistake, name_mistake, named
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.settings.plausible import implausible_together
from roughcontact.arguments.stacks import located_materials, properties_of_bodies
from roughcontact.errors import SettingsError

# keys of `contact` of which only one may be given: a case that gives one replaces the other of the base
_ALTERNATIVES = (("contact_modulus", "bodies"), ("mean_pressure", "relative_pressure", "force"))
# what steel on PEEK is written as
_BODIES = "bodies: [steel, {youngs_modulus: 4 GPa, poissons_ratio: 0.4}]"
# key of `statistics`, what it needs one of, and what is wrong without
_SHEAR, _STRENGTH, _SPEED = (f"friction.{key}" for key in ("tangential_load", "shear_strength", "speed"))
_CONDUCTING = ("thermal_conductivity",), "needs the thermal_conductivity of both bodies"
_RESISTING = ("electrical_resistivity",), "needs the electrical_resistivity of both bodies"
_OF_AREA = ("joint.area", "area"), "needs the area of the joint"
_NEEDS = (
    *((f"joint.{key}", *_CONDUCTING) for key in ("gas_conductivity", "film_thickness", "heat_flow")),
    ("joint.gas_conductivity", ("joint.temperature_jump",), "needs temperature_jump, or leave both out"),
    ("joint.temperature_jump", ("joint.gas_conductivity",), "needs gas_conductivity, or leave both out"),
    ("joint.allowed_resistance", *_RESISTING),
    ("joint.allowed_resistance", *_OF_AREA),
    ("joint.allowed_temperature_drop", ("joint.heat_flow",), "needs the heat_flow through the joint"),
    ("joint.heat_flow", *_OF_AREA),
    ("seal.allowed_leak", ("seal.perimeter",), "needs the perimeter of the seal"),
    ("requirement.leak", ("seal.perimeter",), "needs the perimeter of the seal"),
    ("requirement.resistance", *_RESISTING),
    ("requirement.resistance", *_OF_AREA),
    ("requirement.temperature_drop", ("joint.heat_flow",), "needs the heat_flow through the joint"),
    ("requirement.thermal_resistance", *_CONDUCTING),
    ("requirement.contact_resistance", *_RESISTING),
    ("seal.mean_free_path", ("seal.outlet_pressure",), "is of a gas; give its outlet_pressure, too"),
    ("joint.film_thickness", ("joint.film_conductivity",), "needs film_conductivity, or leave both out"),
    ("joint.film_conductivity", ("joint.film_thickness",), "needs film_thickness, or leave both out"),
    ("friction", (_SHEAR, _STRENGTH, _SPEED), "has no result; add tangential_load, shear_strength or speed"),
    (_SHEAR, ("friction.coefficient",), "needs the coefficient"),
    (f"{_STRENGTH}_uncertainty", (_STRENGTH,), "needs the shear_strength"),
    (_SPEED, ("friction.coefficient", _STRENGTH), "needs the coefficient or shear_strength"),
    (_SPEED, *_CONDUCTING),
    ("friction.thermal_diffusivity", (_SPEED,), "is of sliding; give the speed as well, or leave it out"),
)
_RIGID = 0.01  # share of a rigid face in the displacement
# keys that are the same for all cases
_COMMON = ("surfaces", "composite", "report", "cases")


def resolve(config: Mapping[str, Any], *, origin: str = "the settings") -> dict[str, dict[str, Any]]:
    """Check a raw configuration and return the full settings (SI) of every case by name; "" without cases.

    `contact_modulus` and the `hardness` of the softer body are derived from bodies. The message of a
    `SettingsError` from `origin` lists all mistakes, each with key, value, rule and the nearest valid key.
    """
    # a section without keys is None in YAML
    base = {key: {} if value is None else value for key, value in config.items()}
    base.setdefault("contact", {})
    cases = base.pop("cases", {})
    mistakes = [*_mistakes_in_cases(cases)]
    if mistakes or not cases:
        cases = {"": {}}
    settings_by_case = {}
    for name, overrides in cases.items():
        settings_by_case[name], errors = _resolve_case(name, base, overrides)
        mistakes += errors
    if mistakes:
        # a mistake above the cases is found in each of them
        distinct = {str(error): error for error in mistakes}
        lines = [f"mistakes in {origin}:", *(f"  {text}" for text in distinct)]
        raise SettingsError("\n".join(lines), mistakes=list(distinct.values()))
    return settings_by_case


def _mistake(key: str, text: str) -> SettingsError:
    """Return the error of a setting, by its dotted name, and of the text after that name."""
    names = re.sub(r"\[\d+\]", "", key).split(".")
    setting = names[2:4] if names[0] == "cases" else names[:2]  # without the case
    return SettingsError(f"{key}{text}", keys=[".".join(setting)] * (len(setting) == 2), place=key)


def _resolve_case(name: str, base: dict, overrides: dict) -> tuple[dict[str, Any], list[SettingsError]]:
    """Return the settings of one case, and the mistakes in them."""
    combination = _merge(base, overrides)
    where = f"cases.{name}.contact" if "contact" in overrides else "contact"
    mistakes = [*_mistakes_in_alternatives(combination, where)]
    contact_section = combination["contact"] if isinstance(combination["contact"], dict) else {}
    stated_bodies = contact_section.get("bodies")
    try:
        if isinstance(stated_bodies, list):
            # a hardness of the contact goes before those of the table
            has_hardness = contact_section.get("hardness") is not None
            no_hardness = {"hardness": None, name_of_range("hardness"): None} if has_hardness else {}
            contact_section["bodies"] = [
                body | no_hardness if isinstance(body, dict) else body for body in named_bodies(stated_bodies)
            ]
            if any(isinstance(body, dict) and body.get("relaxation") for body in contact_section["bodies"]):
                from roughcontact.arguments.relaxation import (
                    with_modulus_at_rest,  # with all that reads tables
                )

                contact_section["bodies"] = [*map(with_modulus_at_rest, contact_section["bodies"])]
    except SettingsError as error:
        # without bodies nothing else can be checked
        return {}, [*mistakes, _mistake(f"{where}.bodies", f": {error}")]
    try:
        settings = Settings.model_validate(combination).model_dump(mode="json", exclude={"cases"})
    except ValidationError as error:
        return {}, [*mistakes, *(mistake(name, overrides, detail) for detail in error.errors())]
    contact = settings["contact"]
    try:
        if contact["bodies"]:
            check_bodies(contact["bodies"], where=f"{where}.bodies")
    except SettingsError as error:
        layer = SettingsError(str(error), keys=error.keys, place="".join(error.keys[:1]))
        return settings, [*mistakes, layer]
    # plausibility only of what is formally right: else one slip has two messages
    if not mistakes:
        mistakes += [named(name, overrides, *doubt) for doubt in implausible_together(combination, contact)]
    _derive(contact)
    further = (
        _mistakes_in_bodies(contact["bodies"], where),
        starmap(_mistake, _settings_of_other_kinds(settings)),
        _mistakes_in_loads(contact, where),
        _mistakes_in_statistics(settings),
        _mistakes_in_relaxation(contact["bodies"] or (), stated_bodies or (), where),
        _mistakes_in_creep(contact, where),
        _mistakes_in_wear(settings["wear"], contact),
        _mistakes_in_sliding(settings["sliding"], contact),
    )
    return settings, [*mistakes, *chain(*further)]


def _mistakes_in_loads(contact: Mapping[str, Any], where: str) -> Iterator[SettingsError]:
    """Yield what is wrong with the loads, those that are to be found, and the one that is taken off."""
    hardness, unload = contact["hardness"], contact["unload"]
    for key in (*_ALTERNATIVES[1], "target_area", "target_gap", "target", "unload"):
        values = contact[key] or ()
        if twice := [value for i, value in enumerate(values) if value in values[:i]]:
            yield _mistake(f"{where}.{key}", f": {twice[0]} occurs twice; state each load once")
        if key in ("mean_pressure", "unload") and hardness and max(values, default=0.0) >= hardness:
            text = f" {max(values):g} Pa is not below the hardness {hardness:g} Pa: no contact carries it"
            yield _mistake(f"{where}.{key}", text)
    if contact["hardness_uncertainty"] is not None and not hardness:
        yield _mistake(f"{where}.hardness_uncertainty", ": needs a hardness, or leave it out")
    yields = hardness or any(material["yield_stress"] for _, material in located_materials(contact["bodies"]))
    if "first_yield" in (contact["target"] or ()) and not yields:
        yield _mistake(f"{where}.target", ": first_yield needs the yield_stress of a body, or a hardness")
    if unload is None:
        return
    if hardness is None:
        yield _mistake(
            f"{where}.unload",
            ": needs a hardness, since an elastic contact is unloaded the way it was loaded; "
            "state contact.hardness, or that of a body, or leave unload out",
        )
    if not contact["keep_fields"]:
        yield _mistake(
            f"{where}.unload", ": needs the maps of the contact; leave keep_fields at true, or unload out"
        )


def _mistakes_in_statistics(settings: Mapping[str, Any]) -> Iterator[SettingsError]:
    """Yield what is asked of the statistics although what it needs is not stated, or is excluded."""
    contact, statistics = settings["contact"], settings["statistics"]
    given_keys = {key for key, value in statistics.items() if value is not None}
    for section in given_keys & {"seal", "joint", "friction", "requirement"}:
        given_keys |= {f"{section}.{key}" for key, value in statistics[section].items() if value is not None}
    given_keys |= {"area"} if contact["area"] else set()
    for key in ("thermal_conductivity", "electrical_resistivity"):
        if any(body[key] for body in contact["bodies"] or ()):
            given_keys.add(key)
    facts = facts_of_settings(settings)
    for key, prerequisites, text in _NEEDS:
        # what is excluded needs nothing
        excluded = any(facts.reason_against(f"statistics.{name}") for name in (key, key.partition(".")[0]))
        if key in given_keys and not given_keys & {*prerequisites} and not excluded:
            yield _mistake(f"statistics.{key}", f": {text}")
    if statistics["stress"] == "always" and not contact["bodies"]:
        yield _mistake("statistics.stress", " = 'always': needs contact.bodies, for their Poisson's ratios")
    if "seal" in given_keys and statistics["flow"] == "never":
        yield _mistake(
            "statistics.seal", ": leaks by the flow, and statistics.flow = 'never'; leave one of them out"
        )
    if _SHEAR in given_keys and contact["hardness"] is not None:
        yield _mistake(
            "statistics.friction.tangential_load",
            f": stick and slip are of elastic bodies, and the hardness is "
            f"{contact['hardness']:g} Pa; leave tangential_load out, or the hardness, which of a material by "
            "its name is {material: steel, hardness: null}",
        )
    for name in (key.partition(".")[2] for key in given_keys if key.startswith("requirement.")):
        if allowed_keys := [key for key in given_keys if key.rpartition(".")[2] == f"allowed_{name}"]:
            yield _mistake(
                f"statistics.{allowed_keys[0]}",
                f": is the same limit as requirement.{name}; state one of them",
            )


def _mistakes_in_relaxation(
    bodies: Sequence[Mapping[str, Any]], as_stated: Sequence[Any], where: str
) -> Iterator[SettingsError]:
    """Yield what is wrong with the relaxation of a body with a modulus: without, it was read for that."""
    for body, statement in zip(bodies, as_stated, strict=True):
        if body["relaxation"] and statement.get("youngs_modulus") is not None:
            from roughcontact.arguments.relaxation import relaxation_of  # with all that reads tables

            try:
                relaxation_of(body["relaxation"])
            except SettingsError as error:
                yield _mistake(f"{where}.bodies", f": {error}")


def _mistakes_in_creep(contact: Mapping[str, Any], where: str) -> Iterator[SettingsError]:
    """Yield what is wrong with the times after which bodies have crept."""
    bodies = contact["bodies"] or ()
    creeping = [body for body in bodies if body["creep_modulus"]]
    if (creeping or contact["time"]) and properties_of_bodies(bodies):
        key = "creep_modulus" if creeping else "time"
        yield _mistake(f"{where}.bodies", f": layers creep otherwise than a body; leave {key} out")
    if contact["time"] and creeping:
        yield _mistake(f"{where}.time", ": is of a relaxation; a creep_modulus has its own times")
    elif contact["time"] and not any(body["relaxation"] for body in bodies):
        yield _mistake(f"{where}.time", ": needs the relaxation of a body")
    if len({tuple(body["creep_modulus"]) for body in creeping}) > 1:
        yield _mistake(f"{where}.bodies", ": both creep moduli need the same times, in the same order")


def _mistakes_in_wear(wear: Mapping[str, Any], contact: Mapping[str, Any]) -> Iterator[SettingsError]:
    """Yield what is wrong with the wear of the face."""
    wear_keys = {key for key in ("coefficient", "distance", "mean_pressure") if wear[key] is not None}
    if wear_keys and not {"coefficient", "distance"} <= wear_keys:
        missing = ({"coefficient", "distance"} - wear_keys).pop()
        yield _mistake(f"wear.{missing}", ": missing; wear needs the coefficient and the distance")
    distances = wear["distance"] or ()
    if [*distances] != sorted({*distances}):
        yield _mistake("wear.distance", ": give each distance once, in rising order")
    load, hardness = wear["mean_pressure"], contact["hardness"]
    if load and hardness and load >= hardness:
        text = f" = {load:g} Pa is not below the hardness {hardness:g} Pa: no contact carries it"
        yield _mistake("wear.mean_pressure", text)


def _mistakes_in_sliding(sliding: Mapping[str, Any], contact: Mapping[str, Any]) -> Iterator[SettingsError]:
    """Yield what is wrong with the sliding of rubber."""
    speeds, bodies = sliding["speed"] or (), contact["bodies"] or ()
    relaxing = [body for body in bodies if body["relaxation"]]
    if sliding["mean_pressure"] is not None and not speeds:
        yield _mistake("sliding.speed", ": missing; sliding needs it")
    if speeds and len(relaxing) != 1:
        text = ": needs the relaxation of one of the bodies: bodies: [{relaxation: dma.csv}, rigid]"
        yield _mistake("sliding.speed", text)
    elif speeds and properties_of_bodies(bodies):
        yield _mistake("sliding.speed", ": is of bodies without layers")
    elif speeds and contact_modulus(bodies) < (1 - _RIGID) * contact_modulus(relaxing):
        text = ": the face is taken to be rigid, and gives way by more than a percent of what the rubber does"
        yield _mistake("sliding.speed", text)
    if speeds and contact["influence"] != "sampled":
        yield _mistake("sliding.speed", ": rubber that slides is solved with contact.influence: sampled")
    # that of a stiff face by its name limits nothing
    softer = [body["hardness"] for body in bodies if not body["relaxation"]]
    if speeds and contact["hardness"] and contact["hardness"] not in softer:
        text = (
            f": rubber that slides does not flow, and the hardness is {contact['hardness']:g} Pa; leave it "
            "out, or state that of the face, in bodies"
        )
        yield _mistake("sliding.speed", text)
    if [*speeds] != sorted({*speeds}):
        yield _mistake("sliding.speed", ": give each speed once, in rising order")
    if len({*sliding["direction"]}) < len(sliding["direction"]):
        yield _mistake("sliding.direction", ": give each direction once")


def _derive(contact: dict[str, Any]) -> None:
    """Add what follows from others: E* and the hardness, with their ranges, and pressures from forces."""
    if bodies := contact["bodies"]:
        contact["contact_modulus"] = contact_modulus(bodies)
        if contact["contact_modulus_uncertainty"] is None:
            contact["contact_modulus_uncertainty"] = modulus_uncertainty(bodies)
        if hard := [body for body in bodies if body["hardness"] is not None]:
            contact["hardness"] = min(body["hardness"] for body in hard)  # the softer body flows first
            if contact["hardness_uncertainty"] is None and any(body["hardness_uncertainty"] for body in hard):
                limits = [ends(body["hardness"], body["hardness_uncertainty"]) for body in hard]
                lowest, highest = map(min, zip(*limits, strict=True))
                contact["hardness_uncertainty"] = shares_of_range(contact["hardness"], lowest, highest)
    if contact["force"] and contact["area"]:
        contact["mean_pressure"] = [force / contact["area"] for force in contact["force"]]


def _mistakes_in_cases(cases: Any) -> Iterator[SettingsError]:
    """Yield the mistakes in the mapping of cases itself, whatever the settings in it."""
    if not isinstance(cases, dict):
        yield _mistake("cases", f" = {cases!r}: must be a mapping from names to settings")
        return
    # folders on macOS and Windows do not tell capitals apart
    small = Counter(str(name).lower() for name in cases)
    for name, overrides in cases.items():
        if small[str(name).lower()] > 1:
            yield _mistake(f"cases.{name}", ": another case has this name but for capitals; rename one")
        if wrong := name_mistake(str(name)):
            yield _mistake(f"cases.{name}", f": {wrong}")
        if not isinstance(name, str):
            yield _mistake(f"cases.{name}", ": a name is text, put it in quotes")
        if not isinstance(overrides, dict):
            yield _mistake(
                f"cases.{name}", f" = {overrides!r}: must be a group of settings that differ from those above"
            )
            continue
        for key in _COMMON:
            if key in overrides:
                yield _mistake(f"cases.{name}.{key}", ": is common to all cases, set it at the top")


def _mistakes_in_alternatives(settings: Mapping[str, Any], where: str) -> Iterator[SettingsError]:
    """Yield the mistakes in settings of the contact, not checked yet, that exclude one another."""
    contact = settings["contact"]
    if not isinstance(contact, dict):
        return
    given_keys = {key for key, value in contact.items() if value is not None}
    elasticity, loads = ([key for key in keys if key in given_keys] for keys in _ALTERNATIVES)
    if len(elasticity) != 1:
        yield _mistake(
            f"{where}",
            (
                f": {' and '.join(elasticity) or 'no elasticity'} given; give either contact_modulus "
                "(E* in Pa) or bodies (two of a material's name, or youngs_modulus in Pa and poissons_ratio)"
            )
            + ("" if elasticity else f": {_BODIES}"),
        )
    if len(loads) > 1:
        units = {"mean_pressure": "Pa", "relative_pressure": "no unit", "force": "N"}
        loads_text = " and ".join(f"{key} ({units[key]})" for key in loads)
        yield _mistake(f"{where}", f": {loads_text} given; give one of them or neither")
    yield from starmap(_mistake, facts_of_settings(settings).mistakes_in_loads(given_keys, where))
    bodies = contact["bodies"] if isinstance(contact.get("bodies"), list) else []
    if "hardness" in given_keys and any(
        isinstance(body, dict) and body.get("hardness") is not None for body in bodies
    ):
        yield _mistake(
            f"{where}",
            ": hardness given of the contact and of a body; give it of the bodies (the softer "
            "counts) or of the contact",
        )


def _settings_of_other_kinds(settings: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the settings that do not apply to the kind of problem, and why."""
    properties = properties_of_bodies(settings["contact"]["bodies"])
    defaults = Settings().model_dump(mode="json")
    yield from facts_of_settings(settings).mistakes(settings, defaults, properties)


def _mistakes_in_bodies(bodies: Sequence[Mapping[str, Any]] | None, where: str) -> list[SettingsError]:
    """Return the properties that only some materials state, although they need to be stated for all."""
    # a mistake in a body comes before one in its layers
    materials = sorted(located_materials(bodies), key=lambda located: len(located[0]))  # bodies first
    advice = "the other body has it; give it for both or neither"
    if len(materials) > len(bodies or ()):
        advice = "another material has it; give it for all or none"
    without_value = [
        _mistake(f"{where}{_key(location)}.{key}", f": needs {name}, or leave it out")
        for location, material in materials
        for name in OF_BODIES
        if material.get(key := name_of_range(name)) is not None and material[name] is None
    ]
    return without_value + [
        _mistake(f"{where}{_key(location)}.{name}", f": missing, though {advice}")
        for name in ("thermal_conductivity", "electrical_resistivity")
        for location, material in materials
        if material[name] is None and any(counter_body[name] is not None for _, counter_body in materials)
    ]


def _key(location: Iterable[str | int]) -> str:
    """Return a location below a section as text, ".bodies[0].layers[1]"."""
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in location)


def _merge(base: Any, overrides: Any) -> Any:
    """Return `base` updated by `overrides`, mapping by mapping; other values are replaced as a whole."""
    if not (isinstance(base, dict) and isinstance(overrides, dict)):
        return deepcopy(overrides)
    result = deepcopy(base)
    # a case that states a modulus replaces the bodies of the base
    for keys in _ALTERNATIVES:
        if any(overrides.get(key) is not None for key in keys):
            for key in keys:
                result.pop(key, None)
    if "force" in base and "force" not in result and "force" not in overrides:
        result.pop("area", None)  # which carried the force
    for key, value in overrides.items():
        result[key] = _merge(result.get(key), value)
    return result
