"""From the content of a YAML file to checked settings of each case, or one error that lists all mistakes."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from itertools import chain
from typing import Any

from pydantic import ValidationError

from roughcontact.bodies import check_bodies, have_layers
from roughcontact.configuration.messages import mistake, name_mistake, named
from roughcontact.configuration.models import Settings, Window
from roughcontact.configuration.plausible import implausible_together
from roughcontact.errors import SettingsError
from roughcontact.materials import contact_modulus
from roughcontact.named_materials import modulus_uncertainty, named_bodies

# keys of `contact` of which only one may be given: a case that gives one replaces the other of the base
_ALTERNATIVES = (("contact_modulus", "bodies"), ("mean_pressure", "relative_pressure", "force"))
# what steel on PEEK is written as
_BODIES = "bodies: [steel, {youngs_modulus: 4 GPa, poissons_ratio: 0.4}]"
# key of `statistics`, what it needs one of, and what is wrong without
_SHEAR, _STRENGTH, _SPEED = (f"friction.{key}" for key in ("tangential_load", "shear_strength", "speed"))
_CONDUCTING = ("thermal_conductivity",), "needs the thermal_conductivity of both bodies"
_NEEDS = (
    ("joint", *_CONDUCTING),
    ("joint.film_thickness", ("joint.film_conductivity",), "needs film_conductivity, or leave both out"),
    ("joint.film_conductivity", ("joint.film_thickness",), "needs film_thickness, or leave both out"),
    ("friction", (_SHEAR, _STRENGTH, _SPEED), "has no result; add tangential_load, shear_strength or speed"),
    (_SHEAR, ("friction.coefficient",), "needs the coefficient"),
    (_SPEED, ("friction.coefficient", _STRENGTH), "needs the coefficient or shear_strength"),
    (_SPEED, *_CONDUCTING),
    ("friction.thermal_diffusivity", (_SPEED,), "is of sliding; give the speed as well, or leave it out"),
)
# keys that a body of finite size does not take
_OF_PERIODIC_MAPS = {
    "window": [key for key in Window.model_fields if key != "min_share"],
    "contact": ["zero_frequency", "precision", "area", "target_area", "target_gap", "target", "unload"],
    "statistics": ["seal", "work_of_adhesion"],
    "uncertainty": ["measurand"],
    "instrument": ["correct"],
}
_PERIODIC = "is for periodic maps, and boundary = free; leave it out"
_FILTERS = "; level.s_filter and level.l_filter remove waves"
# keys that are the same for all cases
_COMMON = ("surfaces", "composite", "report", "cases")


def resolve(config: Mapping[str, Any], *, origin: str = "the settings") -> dict[str, dict[str, Any]]:
    """Check a raw configuration and return the full settings (SI) of every case by name; "" without cases.

    `contact_modulus` and the `hardness` of the softer body are derived from bodies. The message of a
    `SettingsError` from `origin` lists all mistakes, each with key, value, rule and the nearest valid key.
    """
    base = {key: {} if value is None else value for key, value in config.items()}
    base.setdefault("contact", {})
    cases = base.pop("cases", {})
    mistakes = [*map(_error, _mistakes_in_cases(cases))]
    if mistakes or not cases:
        cases = {"": {}}
    resolved = {}
    for name, overrides in cases.items():
        resolved[name], errors = _resolve_case(name, base, overrides)
        mistakes += errors
    if mistakes:
        distinct = {str(error): error for error in mistakes}
        lines = [f"mistakes in {origin}:", *(f"  {text}" for text in distinct)]
        raise SettingsError("\n".join(lines), mistakes=list(distinct.values()))
    return resolved


def _error(text: str) -> SettingsError:
    """Return the error of a sentence that begins with its setting."""
    return SettingsError(text, keys=re.findall(r"^(?:cases\.[^.:]*\.)?((?!cases\.)\w+\.\w+)", text))


def _resolve_case(name: str, base: dict, overrides: dict) -> tuple[dict[str, Any], list[SettingsError]]:
    """Return the settings of one case, and the mistakes in them."""
    merged = _merge(base, overrides)
    where = f"cases.{name}.contact" if "contact" in overrides else "contact"
    mistakes = [*map(_error, _mistakes_in_alternatives(merged, where))]
    stated = merged["contact"] if isinstance(merged["contact"], dict) else {}
    stated_bodies = stated.get("bodies")
    try:
        if isinstance(stated_bodies, list):
            # a hardness of the contact goes before those of the table
            without = {"hardness": None} if stated.get("hardness") is not None else {}
            stated["bodies"] = [
                body | without if isinstance(body, dict) else body for body in named_bodies(stated_bodies)
            ]
    except SettingsError as error:
        return {}, [*mistakes, _error(f"{where}.bodies: {error}")]
    try:
        settings = Settings.model_validate(merged).model_dump(mode="json", exclude={"cases"})
    except ValidationError as error:
        return {}, [*mistakes, *(mistake(name, overrides, detail) for detail in error.errors())]
    contact = settings["contact"]
    try:
        _check_layers(contact["bodies"], where)
    except SettingsError as error:
        return settings, [*mistakes, error]
    if not mistakes:
        mistakes += [named(name, overrides, *doubt) for doubt in implausible_together(merged, contact)]
    _derive(contact, stated_bodies or ())
    further = (
        _mistakes_in_bodies(contact["bodies"], where),
        _mistakes_in_finite_bodies(settings),
        _mistakes_in_loads(contact, where),
        _mistakes_in_statistics(settings),
    )
    return settings, [*mistakes, *map(_error, chain(*further))]


def _mistakes_in_loads(contact: Mapping[str, Any], where: str) -> Iterator[str]:
    """Yield what is wrong with the loads, those that are to be found, and the one that is taken off."""
    hardness, unload = contact["hardness"], contact["unload"]
    for key in (*_ALTERNATIVES[1], "target_area", "target_gap", "target", "unload"):
        values = contact[key] or ()
        if twice := [value for i, value in enumerate(values) if value in values[:i]]:
            yield f"{where}.{key}: {twice[0]} occurs twice; state each load once"
        if key in ("mean_pressure", "unload") and hardness and max(values, default=0.0) >= hardness:
            yield (
                f"{where}.{key} {max(values):g} Pa is not below the hardness {hardness:g} Pa: no contact "
                "carries it"
            )
    materials = [material for body in contact["bodies"] or () for material in (body, *(body["layers"] or ()))]
    yields = hardness or any(material["yield_stress"] for material in materials)
    if "first_yield" in (contact["target"] or ()) and not yields:
        yield f"{where}.target: first_yield needs the yield_stress of a body, or a hardness"
    if unload is None:
        return
    if hardness is None:
        yield (
            f"{where}.unload: needs a hardness, since an elastic contact is unloaded the way it was loaded; "
            "state contact.hardness, or that of a body, or leave unload out"
        )
    if not contact["keep_fields"]:
        yield f"{where}.unload: needs the maps of the contact; leave keep_fields at true, or unload out"


def _mistakes_in_statistics(settings: Mapping[str, Any]) -> Iterator[str]:
    """Yield what is asked of the statistics although what it needs is not stated, or is excluded."""
    contact, statistics = settings["contact"], settings["statistics"]
    stated = {key for key, value in statistics.items() if value is not None}
    for section in stated & {"joint", "friction"}:
        stated |= {f"{section}.{key}" for key, value in statistics[section].items() if value is not None}
    if any(body["thermal_conductivity"] for body in contact["bodies"] or ()):
        stated.add("thermal_conductivity")
    for key, required, text in _NEEDS:
        if key in stated and not stated & {*required}:
            yield f"statistics.{key}: {text}"
    if statistics["stress"] == "always" and not contact["bodies"]:
        yield "statistics.stress = 'always': needs contact.bodies, for their Poisson's ratios"
    if "seal" in stated and statistics["flow"] == "never":
        yield "statistics.seal: leaks by the flow, and statistics.flow = 'never'; leave one of them out"
    if have_layers(contact["bodies"]):
        for key in sorted({_SHEAR, _SPEED} & stated):
            yield f"statistics.{key}: its results are those of half-spaces, without layers; leave it out"
    if _SHEAR in stated and contact["hardness"] is not None:
        yield (
            f"statistics.friction.tangential_load: stick and slip are of elastic bodies, and the hardness is "
            f"{contact['hardness']:g} Pa; leave tangential_load out, or give moduli without a hardness"
        )


def _derive(contact: dict[str, Any], stated_bodies: Sequence[Any]) -> None:
    """Add the numbers that follow from others: E*, its uncertainty, the hardness, pressures from forces."""
    if bodies := contact["bodies"]:
        contact["contact_modulus"] = contact_modulus(bodies)
        if contact["contact_modulus_uncertainty"] is None:
            contact["contact_modulus_uncertainty"] = modulus_uncertainty(stated_bodies, bodies)
        if hardness := [body["hardness"] for body in bodies if body["hardness"] is not None]:
            contact["hardness"] = min(hardness)  # the softer body flows first
    if contact["force"] and contact["area"]:
        contact["mean_pressure"] = [force / contact["area"] for force in contact["force"]]


def _mistakes_in_cases(cases: Any) -> Iterator[str]:
    """Yield the mistakes in the mapping of cases itself, whatever the settings in it."""
    if not isinstance(cases, dict):
        yield f"cases = {cases!r}: must be a mapping from names to settings"
        return
    small = Counter(str(name).lower() for name in cases)
    for name, overrides in cases.items():
        if small[str(name).lower()] > 1:
            yield f"cases.{name}: another case has this name but for capitals; rename one"
        if wrong := name_mistake(str(name)):
            yield f"cases.{name}: {wrong}"
        if not isinstance(name, str):
            yield f"cases.{name}: a name is text, put it in quotes"
        if not isinstance(overrides, dict):
            yield f"cases.{name} = {overrides!r}: must be a group of settings that differ from those above"
            continue
        for key in _COMMON:
            if key in overrides:
                yield f"cases.{name}.{key}: is common to all cases, set it at the top"


def _mistakes_in_alternatives(settings: Mapping[str, Any], where: str) -> Iterator[str]:
    """Yield the mistakes in settings of the contact, not checked yet, that exclude one another."""
    contact, form = settings["contact"], settings.get("form")
    if not isinstance(contact, dict):
        return
    stated = {key for key, value in contact.items() if value is not None}
    elasticity, loads = ([key for key in keys if key in stated] for keys in _ALTERNATIVES)
    if len(elasticity) != 1:
        yield (
            f"{where}: {' and '.join(elasticity) or 'no elasticity'} given; give either contact_modulus "
            "(E* in Pa) or bodies (two of a material's name, or youngs_modulus in Pa and poissons_ratio)"
        ) + ("" if elasticity else f": {_BODIES}")
    if len(loads) > 1:
        units = {"mean_pressure": "Pa", "relative_pressure": "no unit", "force": "N"}
        loads_text = " and ".join(f"{key} ({units[key]})" for key in loads)
        yield f"{where}: {loads_text} given; give one of them or neither"
    if contact.get("boundary") == "free":
        if "force" not in stated:
            pressure = f" instead of the {loads[0]}" if loads else ""
            yield f"{where}.force: missing, though boundary is free; give the force in N{pressure}"
    elif len(stated & {"force", "area"}) == 1 and not (isinstance(form, dict) and form.get("local_scale")):
        missing, present = ("area", "force") if "force" in stated else ("force", "area")
        yield f"{where}.{missing}: missing, though {present} is given; mean pressure is force by area"
    bodies = contact["bodies"] if isinstance(contact.get("bodies"), list) else []
    if "hardness" in stated and any(
        isinstance(body, dict) and body.get("hardness") is not None for body in bodies
    ):
        yield (
            f"{where}: hardness given of the contact and of a body; give it of the bodies (the softer "
            "counts) or of the contact"
        )


def _mistakes_in_finite_bodies(settings: Mapping[str, Any]) -> Iterator[str]:
    """Yield what is asked of a body of finite size, or of its form, although it is not solved."""
    form, contact, statistics = settings["form"], settings["contact"], settings["statistics"]
    free, layered = contact["boundary"] == "free", have_layers(contact["bodies"])
    if form["local_scale"]:
        periodic = (contact[key] for key in ("area", "target_area", "target_gap", "target"))
        unfit = form["edges"] or free or layered or any(periodic)
        if unfit or not form["radius"] or not contact["force"]:
            yield (
                "form.local_scale = true: takes form.radius and contact.force of a periodic map; leave out "
                "form.edges, contact.boundary = free, contact.area, targets and layers"
            )
        return
    if not free:
        for key, value in form.items():
            if value:
                yield f"form.{key} = {value!r}: is of contact.boundary = free; set that, too"
        return
    if layered and contact["influence"] != "sampled":
        yield "contact.influence: layers of a finite body are solved with 'sampled'; leave it out"
    if layered and statistics["stress"] == "always":
        yield "statistics.stress = 'always': stresses in layers are those of periodic maps"
    if names := [key for key in ("speed", "tangential_load") if (statistics["friction"] or {}).get(key)]:
        yield f"statistics.friction: {' and '.join(names)} {_PERIODIC}"
    defaults = Settings().model_dump()
    for section, keys in _OF_PERIODIC_MAPS.items():
        for key in keys:
            if (value := settings[section][key]) != defaults[section][key]:
                yield f"{section}.{key} = {value!r}: {_PERIODIC}{_FILTERS if 'wave' in key else ''}"


def _mistakes_in_bodies(bodies: Sequence[Mapping[str, Any]] | None, where: str) -> list[str]:
    """Return the properties that only some materials state, although they need to be stated for all."""
    materials = {f"{where}.bodies[{index}]": body for index, body in enumerate(bodies or ())}
    layers = {
        f"{key}.layers[{number}]": layer
        for key, body in materials.items()
        for number, layer in enumerate(body["layers"] or ())
    }
    advice = "another material has it; give it for all or none"
    advice = advice if layers else "the other body has it; give it for both or neither"
    return [
        f"{key}.{name}: missing, though {advice}"
        for name in ("thermal_conductivity", "electrical_resistivity")
        for key, material in (materials | layers).items()
        if material[name] is None
        and any(second[name] is not None for second in (materials | layers).values())
    ]


def _check_layers(bodies: Sequence[Mapping[str, Any]] | None, where: str) -> None:
    """Raise an error for bodies whose layers, base and elastic constants contradict one another."""
    constants = ("youngs_modulus", "poissons_ratio")
    if any(body["base"] or body["layers"] or None in map(body.get, constants) for body in bodies or ()):
        check_bodies(bodies or (), where=f"{where}.bodies")


def _merge(base: Any, overrides: Any) -> Any:
    """Return `base` updated by `overrides`, mapping by mapping; other values are replaced as a whole."""
    if not (isinstance(base, dict) and isinstance(overrides, dict)):
        return deepcopy(overrides)
    merged = deepcopy(base)
    for keys in _ALTERNATIVES:
        if any(overrides.get(key) is not None for key in keys):
            for key in keys:
                merged.pop(key, None)
    if "force" in base and "force" not in merged and "force" not in overrides:
        merged.pop("area", None)  # which carried the force
    for key, value in overrides.items():
        merged[key] = _merge(merged.get(key), value)
    return merged
