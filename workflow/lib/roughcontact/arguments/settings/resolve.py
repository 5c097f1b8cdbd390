"""From the content of a YAML file to checked settings of each case, or one error that lists all mistakes."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from itertools import chain
from typing import Any

from pydantic import ValidationError

from roughcontact.arguments.bodies import check_bodies
from roughcontact.arguments.kinds import facts_of_settings, named_settings
from roughcontact.arguments.materials import contact_modulus
from roughcontact.arguments.named_materials import TRANSPORT, modulus_uncertainty, named_bodies
from roughcontact.arguments.ranges import OF_BODIES, ends, name_of_range, shares_of_range
from roughcontact.arguments.settings.messages import dotted, mistake, name_mistake, named, setting_error
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.settings.needs import unmet_needs
from roughcontact.arguments.settings.plausible import implausible_together
from roughcontact.arguments.stacks import located_materials, properties_of_bodies
from roughcontact.errors import SettingsError

# keys of `contact` of which only one may be given: a case that gives one replaces the other of the base
_ALTERNATIVES = (("contact_modulus", "bodies"), ("mean_pressure", "relative_pressure", "force"))
# what steel on PEEK is written as
_BODIES = "bodies: [steel, {youngs_modulus: 4 GPa, poissons_ratio: 0.4}]"
# what each course needs; the last of them rises
_COURSES = {"wear": ("coefficient", "distance"), "sliding": ("speed",)}
_RIGID = 0.01  # share of a rigid face in the displacement
# keys that are the same for all cases
_COMMON = ("surfaces", "composite", "report", "cases")

Mistakes = Iterator[tuple[str, str]]  # the dotted name of a setting, and the text after it


def resolve(config: Mapping[str, Any], *, origin: str = "the settings") -> dict[str, dict[str, Any]]:
    """Check a raw configuration and return the full settings (SI) of every case by name; "" without cases.

    `contact_modulus` and the `hardness` of the softer body are derived from bodies. The message of a
    `SettingsError` from `origin` lists all mistakes, each with key, value, rule and the nearest valid key.
    """
    # a section without keys is None in YAML
    base = {key: {} if value is None else value for key, value in config.items()}
    base.setdefault("contact", {})
    cases = base.pop("cases", {})
    mistakes = [SettingsError(f"{place}{text}", place=place) for place, text in _mistakes_in_cases(cases)]
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


def _resolve_case(name: str, base: dict, overrides: dict) -> tuple[dict[str, Any], list[SettingsError]]:
    """Return the settings of one case, and the mistakes in them."""

    def in_case(found: Iterable[tuple[str, str]]) -> list[SettingsError]:
        # what a case states of a section may be wrong only beside the rest of it
        return [
            setting_error(key, text, case=name if key.partition(".")[0] in overrides else "")
            for key, text in found
        ]

    combination = _merge(base, overrides)
    mistakes = in_case(_mistakes_in_alternatives(combination))
    no_bodies: list[SettingsError] = []
    try:
        relaxation_mistakes = _complete_bodies(combination["contact"])
    except SettingsError as error:
        no_bodies = in_case([("contact.bodies", f": {error}")])
        mistakes += no_bodies
        combination["contact"] = combination["contact"] | {"bodies": None}
    try:
        settings = Settings.model_validate(combination).model_dump(mode="json", exclude={"cases"})
    except ValidationError as error:
        return {}, [*mistakes, *(mistake(name, overrides, detail) for detail in error.errors())]
    if no_bodies:  # of what is formally right nothing more can be checked without them
        return {}, mistakes
    contact = settings["contact"]
    try:
        if contact["bodies"]:
            check_bodies(contact["bodies"], where="contact.bodies")
    except SettingsError as error:
        (key,) = error.keys
        return settings, [*mistakes, *in_case([(key, str(error).removeprefix(key))])]
    # plausibility only of what is formally right: else one slip has two messages
    if not mistakes:
        mistakes += [named(name, overrides, *doubt) for doubt in implausible_together(combination, contact)]
    _derive(contact)
    properties, defaults = properties_of_bodies(contact["bodies"]), Settings().model_dump(mode="json")
    further = (
        _mistakes_in_bodies(contact["bodies"] or ()),
        relaxation_mistakes,
        facts_of_settings(settings).mistakes(settings, defaults, properties),
        _mistakes_in_loads(contact),
        _mistakes_in_needs(settings),
        _mistakes_in_statistics(settings),
        _mistakes_in_creep(contact),
        _mistakes_in_courses(settings),
        _mistakes_in_pressures(settings),
        _mistakes_in_sliding(settings["sliding"], contact),
    )
    return settings, mistakes + in_case(chain(*further))


def _complete_bodies(contact: Any) -> list[tuple[str, str]]:
    """Give bodies, not checked yet, the properties of the materials that they name, and those at rest.

    What is wrong with the relaxation of a body that states its modulus hides nothing else: it is returned.
    """
    mistakes: list[tuple[str, str]] = []
    if not isinstance(contact, dict) or not isinstance(contact.get("bodies"), list):
        return mistakes
    # a hardness of the contact goes before those of the table
    has_hardness = contact.get("hardness") is not None
    no_hardness = {"hardness": None, name_of_range("hardness"): None} if has_hardness else {}
    contact["bodies"] = bodies = named_bodies(contact["bodies"])
    for index, body in enumerate(bodies):
        if isinstance(body, dict):
            bodies[index] = body | no_hardness
            if body.get("relaxation"):
                from roughcontact.arguments import relaxation  # with all that reads tables

                bodies[index] = relaxation.with_modulus_at_rest(bodies[index])
                try:
                    if body.get("youngs_modulus") is not None:  # without, it was read for that
                        relaxation.relaxation_of(body["relaxation"])
                except SettingsError as error:
                    mistakes.append(("contact.bodies", f": {error}"))
    return mistakes


def _mistakes_in_loads(contact: Mapping[str, Any]) -> Mistakes:
    """Yield what is wrong with the loads, and those that are to be found."""
    for key in (*_ALTERNATIVES[1], "target_area", "target_gap", "target", "unload"):
        values = contact[key] or ()
        if twice := [value for i, value in enumerate(values) if value in values[:i]]:
            yield f"contact.{key}", f": {twice[0]} occurs twice; state each load once"
    yields = any(material["yield_stress"] for _, material in located_materials(contact["bodies"]))
    if "first_yield" in (contact["target"] or ()) and not (contact["hardness"] or yields):
        yield "contact.target", ": first_yield needs the yield_stress of a body, or a hardness"


def _mistakes_in_needs(settings: Mapping[str, Any]) -> Mistakes:
    """Yield the settings of which nothing is stated that they need."""
    bodies, facts = settings["contact"]["bodies"] or (), facts_of_settings(settings)
    of_bodies = (*TRANSPORT, "relaxation", "creep_modulus")
    properties = {name for name in of_bodies if any(body[name] for body in bodies)}
    for key, text in unmet_needs(settings, properties):
        # what is excluded needs nothing
        if not (facts.reason_against(key) or facts.reason_against(key.rpartition(".")[0])):
            name, equals, value = key.partition(" = ")
            yield name, f"{equals}{value}: {text}"


def _mistakes_in_statistics(settings: Mapping[str, Any]) -> Mistakes:
    """Yield what is asked of the statistics twice, or although the hardness excludes it."""
    statistics, hardness = settings["statistics"], settings["contact"]["hardness"]
    if (statistics["friction"] or {}).get("tangential_load") and hardness is not None:
        text = (
            f": stick and slip are of elastic bodies, and the hardness is {hardness:g} Pa; leave "
            "tangential_load out, or the hardness, which of a material by its name is "
            "{material: steel, hardness: null}"
        )
        yield "statistics.friction.tangential_load", text
    stated = {name for name, value in named_settings({"statistics": statistics}) if value is not None}
    for key in sorted(stated):
        name = key.rpartition(".allowed_")[2]
        if f"statistics.requirement.{name}" in stated:
            yield key, f": is the same limit as requirement.{name}; state one of them"


def _mistakes_in_creep(contact: Mapping[str, Any]) -> Mistakes:
    """Yield what is wrong with the times after which bodies have crept."""
    bodies = contact["bodies"] or ()
    creeping = [body for body in bodies if body["creep_modulus"]]
    if (creeping or contact["time"]) and properties_of_bodies(bodies):
        key = "creep_modulus" if creeping else "time"
        yield "contact.bodies", f": layers creep otherwise than a body; leave {key} out"
    if contact["time"] and creeping:
        yield "contact.time", ": is of a relaxation; a creep_modulus has its own times"
    if contact["time"]:
        yield from _mistakes_in_times(bodies, contact["time"])
    if len({tuple(body["creep_modulus"]) for body in creeping}) > 1:
        yield "contact.bodies", ": both creep moduli need the same times, in the same order"


def _mistakes_in_times(bodies: Sequence[Mapping[str, Any]], times: Sequence[float]) -> Mistakes:
    """Yield the times at which the relaxation of a body does not tell its creep."""
    from roughcontact.arguments import relaxation  # with all that reads tables

    for stated in (body["relaxation"] for body in bodies if body["relaxation"]):
        try:
            series = relaxation.relaxation_of(stated)
            for time in times:
                series.creep_modulus(time)
        except SettingsError as error:
            if "time" in error.keys:  # else it is told of the body
                yield "contact.time", f": {error}"


def _mistakes_in_courses(settings: Mapping[str, Any]) -> Mistakes:
    """Yield what wear or sliding lacks where it has any setting, and distances or speeds out of order."""
    for section, keys in _COURSES.items():
        values = settings[section]
        if any(values[key] for key in (*keys, "mean_pressure")):
            needs = f"{section} needs the {' and the '.join(keys)}"
            yield from ((f"{section}.{key}", f": missing; {needs}") for key in keys if not values[key])
        rising = values[keys[-1]] or []
        if rising != sorted({*rising}):
            yield f"{section}.{keys[-1]}", f": give each {keys[-1]} once, in rising order"


def _mistakes_in_pressures(settings: Mapping[str, Any]) -> Mistakes:
    """Yield pressures that the hardness does not bear."""
    hardness = settings["contact"]["hardness"]
    for section, key in (("contact", "mean_pressure"), ("contact", "unload"), ("wear", "mean_pressure")):
        value = settings[section][key]
        largest = max(value, default=0.0) if isinstance(value, list) else value or 0.0
        if hardness and largest >= hardness:
            text = f" = {largest:g} Pa is not below the hardness {hardness:g} Pa: no contact carries it"
            yield f"{section}.{key}", text


def _mistakes_in_sliding(sliding: Mapping[str, Any], contact: Mapping[str, Any]) -> Mistakes:
    """Yield what is wrong with the sliding of rubber, beside that it has layers or no relaxation."""
    if len({angle % 360 for angle in sliding["direction"]}) < len(sliding["direction"]):
        yield "sliding.direction", ": give each direction once"
    bodies = contact["bodies"] or ()
    relaxing = [body for body in bodies if body["relaxation"]]
    if not sliding["speed"] or not relaxing or properties_of_bodies(bodies):
        return
    if len(relaxing) > 1:
        text = ": needs the relaxation of one of the bodies alone: bodies: [{relaxation: dma.csv}, rigid]"
        yield "sliding.speed", text
    elif contact_modulus(bodies) < (1 - _RIGID) * contact_modulus(relaxing):
        text = ": the face is taken to be rigid, and gives way by more than a percent of what the rubber does"
        yield "sliding.speed", text
    # that of a stiff face by its name limits nothing
    softer = [body["hardness"] for body in bodies if not body["relaxation"]]
    if contact["hardness"] and contact["hardness"] not in softer:
        text = (
            f": rubber that slides does not flow, and the hardness is {contact['hardness']:g} Pa; leave it "
            "out, or state that of the face, in bodies"
        )
        yield "sliding.speed", text


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


def _mistakes_in_cases(cases: Any) -> Mistakes:
    """Yield the mistakes in the mapping of cases itself, whatever the settings in it."""
    if not isinstance(cases, dict):
        yield "cases", f" = {cases!r}: must be a mapping from names to settings"
        return
    # folders on macOS and Windows do not tell capitals apart
    small = Counter(str(name).lower() for name in cases)
    for name, overrides in cases.items():
        case_key = f"cases.{name}"
        if small[str(name).lower()] > 1:
            yield case_key, ": another case has this name but for capitals; rename one"
        if wrong := name_mistake(str(name)):
            yield case_key, f": {wrong}"
        if not isinstance(name, str):
            yield case_key, ": a name is text, put it in quotes"
        if not isinstance(overrides, dict):
            yield case_key, f" = {overrides!r}: must be a group of settings that differ from those above"
            continue
        for key in _COMMON:
            if key in overrides:
                yield f"{case_key}.{key}", ": is common to all cases, set it at the top"


def _mistakes_in_alternatives(settings: Mapping[str, Any]) -> Mistakes:
    """Yield the mistakes in settings of the contact, not checked yet, that exclude one another."""
    contact = settings["contact"]
    if not isinstance(contact, dict):
        return
    given_keys = {key for key, value in contact.items() if value is not None}
    elasticity, loads = ([key for key in keys if key in given_keys] for keys in _ALTERNATIVES)
    if len(elasticity) != 1:
        yield (
            "contact",
            f": {' and '.join(elasticity) or 'no elasticity'} given; give either contact_modulus "
            "(E* in Pa) or bodies (two of a material's name, or youngs_modulus in Pa and poissons_ratio)"
            + ("" if elasticity else f": {_BODIES}"),
        )
    if len(loads) > 1:
        units = {"mean_pressure": "Pa", "relative_pressure": "no unit", "force": "N"}
        loads_text = " and ".join(f"{key} ({units[key]})" for key in loads)
        yield "contact", f": {loads_text} given; give one of them or neither"
    yield from facts_of_settings(settings).mistakes_in_loads(given_keys)
    bodies = contact["bodies"] if isinstance(contact.get("bodies"), list) else []
    of_bodies = any(isinstance(body, dict) and body.get("hardness") is not None for body in bodies)
    if "hardness" in given_keys and of_bodies:
        text = "hardness given of the contact and of a body; give it of the bodies (the softer counts) or of"
        yield "contact", f": {text} the contact"


def _mistakes_in_bodies(bodies: Sequence[Mapping[str, Any]]) -> Mistakes:
    """Yield the properties that only some materials state, although they need to be stated for all."""
    # a mistake in a body comes before one in its layers
    located = sorted(located_materials(bodies), key=lambda entry: len(entry[0]))
    materials = {dotted(("contact", *location)): material for location, material in located}
    for place, material in materials.items():
        for name in OF_BODIES:
            if material.get(key := name_of_range(name)) is not None and material[name] is None:
                yield f"{place}.{key}", f": needs {name}, or leave it out"
    advice = "the other body has it; give it for both or neither"
    if len(materials) > len(bodies):
        advice = "another material has it; give it for all or none"
    for name in TRANSPORT:
        for place, material in materials.items():
            if material[name] is None and any(other[name] is not None for other in materials.values()):
                yield f"{place}.{name}", f": missing, though {advice}"


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
