"""Settings: what may stand in the configuration, in which unit, and what is said where it does not fit.

A section is exactly the keyword arguments of its verb (`level(height, **settings["level"])`), so that there
is one word for one thing. `resolve` turns the raw mapping of a YAML file into checked plain dictionaries, one
per case, or raises one error that lists all mistakes. `python -m roughcontact.configuration FOLDER` writes
the default configuration and its JSON schema, both generated from the models below.
"""

import json
import re
import textwrap
from copy import deepcopy
from difflib import get_close_matches
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic.json_schema import WithJsonSchema

from roughcontact.choices import (
    SMALLEST_TOLERANCE,
    Fill,
    Influence,
    LevelForm,
    LineAlignment,
    OnFailure,
    OutsideCode,
    Placement,
    Precision,
    UncertaintySource,
    WindowMethod,
    ZeroFrequency,
)
from roughcontact.errors import SettingsError

NAME = re.compile(r"[A-Za-z0-9-]+")
NAME_RULE = "letters, digits and hyphens only"


def _not_boolean(value):
    """Refuse true and false where a number is meant: Python takes them for 1 and 0."""
    if isinstance(value, bool):
        raise ValueError("must be a number")
    return value


def _as_list(value):
    """Take one load for a list of one."""
    return value if isinstance(value, list | tuple | NoneType) else [value]


Number = Annotated[float, BeforeValidator(_not_boolean)]
Count = Annotated[int, BeforeValidator(_not_boolean)]
Positive = Annotated[Number, Field(gt=0)]
Loads = Annotated[
    list[Positive],
    Field(min_length=1),
    BeforeValidator(_as_list),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "number", "exclusiveMinimum": 0},
                {"type": "array", "minItems": 1, "items": {"type": "number", "exclusiveMinimum": 0}},
            ]
        }
    ),
]


class Section(BaseModel):
    """A group of settings; unknown keys, infinities and NaN are mistakes."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Level(Section):
    """Levelling: outliers out, scan lines aligned, form and waviness off, missing points filled in."""

    form: LevelForm = Field("plane", description="what is fitted to the measured map and taken off")
    order: Count = Field(2, ge=1, description="total order of the polynomial, x^i y^j with i + j <= order")
    robust: bool = Field(
        False, description="fit so that deep valleys and high spikes have no weight (else least squares)"
    )
    outlier_threshold: Positive | None = Field(
        6.0,
        description="isolated spikes that stand off their surroundings by more than this many local standard "
        "deviations are taken for missing; null keeps every point",
    )
    line_alignment: LineAlignment = Field(
        "none",
        description="for scanned maps: how rows are shifted to match one another; median: each row's median "
        "to the same height; matched-steps: the median step from row to row to zero",
    )
    scar_threshold: Positive | None = Field(
        None,
        description="for scanned maps: pieces of one to four rows that stick out against the rows before and "
        "after by more than this many standard deviations are taken for missing (4 is a good start); narrow "
        "grooves along x look the same; null keeps every point",
        examples=[4.0],
    )
    s_filter: Positive | None = Field(
        None,
        description="nesting index of the S-filter (areal Gaussian, ISO 16610-61), m: shorter waves are "
        "taken off; null keeps them",
        examples=[2.5e-6],
    )
    l_filter: Positive | None = Field(
        None,
        description="nesting index of the L-filter (areal Gaussian, ISO 16610-61), m: longer waves are taken "
        "off; null keeps them",
        examples=[8.0e-4],
    )
    fill: Fill = Field(
        "harmonic",
        description="how missing points are filled in; those at the border are cut off instead",
    )
    max_missing: Number = Field(
        0.4, ge=0, le=1, description="largest share of missing points; a map with more is refused"
    )


class Composite(Section):
    """Two measured faces that touch (column counter_face of the table): how they are laid on one another."""

    shifts: Count = Field(5, ge=1, description="random shifts for each rotation; each is solved")
    rotations: list[Number] = Field(
        default_factory=lambda: [0.0],
        min_length=1,
        description="angles by which the counter-face is turned on the face, degrees, from x towards y",
    )
    overlap: Number = Field(
        0.75,
        gt=0,
        le=1,
        description="least share of each side of the smaller map that the other one covers",
    )
    seed: Count = Field(0, ge=0, description="of the random shifts")


class Window(Section):
    """The periodic window that is solved."""

    placement: Placement = Field(
        "largest",
        description="which part of the map is solved; largest: the largest rectangle without missing points; "
        "search: the position and size with the best score, whole periods of a lay included",
    )
    method: WindowMethod = Field(
        "smooth-cross-fade",
        description="how that part is made periodic; docs/explanation/window.md compares them",
    )
    width: Number = Field(
        0.1,
        gt=0,
        le=0.5,
        description="share of the side over which the two cross-fades blend or taper falls; no other method "
        "has it",
    )
    min_share: Number = Field(
        0.05, ge=0, le=1, description="least share of the map that the window must have; else it is refused"
    )
    shortest_wavelength: Positive | None = Field(
        None,
        description="shorter waves are taken out of the window, m; null keeps them; the cut is sharp, so "
        "that steps and particles ring: level.s_filter is soft",
        examples=[2.0e-6],
    )
    longest_wavelength: Positive | None = Field(
        None, description="longer waves are taken out of the window, m; null keeps them", examples=[1.0e-4]
    )
    reliable_band: bool = Field(
        False,
        description="take out the waves that are shorter than the instrument resolves (two pixels, or the "
        "limit of the lens where the file states its numerical aperture)",
    )


class Body(Section):
    """One elastic body."""

    youngs_modulus: Positive = Field(description="Young's modulus E, Pa", examples=[2.1e11])
    poissons_ratio: Number = Field(gt=-1, le=0.5, description="Poisson's ratio, no unit", examples=[0.3])


class Contact(Section):
    """The contact problem: contact_modulus or bodies, mean_pressure or relative_pressure or neither."""

    contact_modulus: Positive | None = Field(
        None,
        description="plane-strain contact modulus E*, Pa, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; 1.154e11 "
        "for steel on steel",
        examples=[1.154e11],
    )
    bodies: list[Body] | None = Field(
        None,
        min_length=2,
        max_length=2,
        description="the two bodies, instead of contact_modulus: Young's moduli in Pa, Poisson's ratios",
        examples=[
            [
                {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3},
                {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3},
            ]
        ],
    )
    mean_pressure: Loads | None = Field(
        None,
        description="nominal pressure, Pa, one number or a list; where no load is given, loads are planned, "
        "log-spaced",
        examples=[[1.0e6, 1.0e7, 1.0e8]],
    )
    relative_pressure: Loads | None = Field(
        None,
        description="nominal pressure / (E* x rms gradient of the window), no unit, one number or a list",
        examples=[[0.01, 0.05, 0.2]],
    )
    tolerance: Number = Field(
        1e-4,
        ge=SMALLEST_TOLERANCE,
        lt=1,
        description="largest error_bound that is accepted (relative, energy norm), no unit",
    )
    zero_frequency: ZeroFrequency = Field(
        "zero",
        description="mean displacement in the approach: zero, nogi-kato (its mean over the q = 0 patch), "
        "lattice (one contact per window in free space); pressure and area do not depend on it",
    )
    hardness: Number | None = Field(
        None,
        gt=0,
        description="largest pressure the softer body carries before it yields, Pa; none: elastic throughout",
        examples=[2.0e9],
    )
    influence: Influence = Field(
        "sampled",
        description="elastic influence function: sampled (exact for each wave of the grid) or elements "
        "(pressure constant on every pixel)",
    )
    precision: Precision = Field(
        "double", description="of the result: double, or single for maps that fill the memory"
    )
    keep_fields: bool = Field(
        True, description="keep the maps of pressure, gap and contact of every load in contact.nc"
    )
    on_failure: OnFailure = Field(
        "raise",
        description="what happens to a load that misses the tolerance: raise (the surface fails) or flag "
        "(the load is kept with converged = 0)",
    )


class Statistics(Section):
    """What is counted in the contact."""

    pressure_bins: Count = Field(20, ge=1, description="bins of the pressure density, per factor of ten")
    gap_bins: Count = Field(20, ge=1, description="bins of the gap density, per factor of ten")


class Uncertainty(Section):
    """The error budget: what the ± of a headline number is made of; see docs/explanation/uncertainty.md."""

    sources: list[UncertaintySource] = Field(
        default_factory=lambda: list(get_args(UncertaintySource)),
        description="a list of what goes into the ±; the empty list [] leaves the error budget out",
    )
    windows: Count = Field(
        9, ge=4, description="parts of the window that are solved by themselves, for the source window"
    )


class Report(Section):
    """The page that shows it."""

    title: str = Field("Contact of rough surfaces", description="title of the page")


class Crosscheck(Section):
    """Cross-check of every result by another code, an outside program; see docs/explanation/validation.md."""

    code: Literal["none", OutsideCode] = Field(
        "none", description="the other code; its differences stand in the report, load by load"
    )
    python: str | None = Field(
        None,
        description="path of the Python that has the other code",
        examples=["/opt/tamaas/bin/python"],
    )


class Validation(Section):
    """The target `validation`: the program against closed forms and published numbers."""

    finest_grid: Count = Field(
        2048,
        ge=256,
        description="points along the finest grid, a power of 2 from 256 on; tolerances follow the grid",
    )


class Settings(Section):
    """Settings of roughcontact."""

    surfaces: str = Field(
        "config/surfaces.tsv",
        min_length=1,
        description="path of the table of surfaces, tab-separated, one row each; see config/README.md",
    )
    level: Level = Field(default_factory=Level)
    composite: Composite = Field(default_factory=Composite)
    window: Window = Field(default_factory=Window)
    contact: Contact = Field(default_factory=Contact)
    statistics: Statistics = Field(default_factory=Statistics)
    uncertainty: Uncertainty = Field(default_factory=Uncertainty)
    report: Report = Field(default_factory=Report)
    crosscheck: Crosscheck = Field(default_factory=Crosscheck)
    validation: Validation = Field(default_factory=Validation)
    cases: dict[str, dict[str, Any]] = Field(
        default_factory=dict,
        description="a study: name of a case -> settings that differ from those above; every surface runs "
        "under every case, results go to results/{case}/{surface}",
        examples=[{"soft": {"contact": {"contact_modulus": 1.0e9}}}],
    )


# keys of `contact` of which only one may be given: a case that gives one replaces the other of the base
_ALTERNATIVES = (("contact_modulus", "bodies"), ("mean_pressure", "relative_pressure"))
# keys that are the same for all cases
_COMMON = ("surfaces", "composite", "report", "crosscheck", "validation", "cases")


def contact_modulus(bodies: list[dict]) -> float:
    """Return the plane-strain contact modulus of two bodies, 1/E* = sum (1 - nu^2)/E.

    Parameters
    ----------
    bodies
        two mappings with `youngs_modulus` (Pa) and `poissons_ratio` (1).

    Returns
    -------
    float
        E* in Pa.

    K. L. Johnson, Contact Mechanics (1985), eq. (4.4).
    """
    return 1 / sum((1 - body["poissons_ratio"] ** 2) / body["youngs_modulus"] for body in bodies)


def resolve(config: dict) -> dict[str, dict]:
    """Check a raw configuration and return the full settings of every case, as plain dictionaries.

    Parameters
    ----------
    config
        what the YAML file says: nested mappings, numbers possibly as text ("1e9").

    Returns
    -------
    dict
        name of the case -> settings, every key present, `contact.contact_modulus` always in Pa; without
        `cases` there is the one entry "".

    Raises
    ------
    SettingsError
        one message that lists all mistakes, each with its key, the value, the rule and the nearest valid key.
    """
    base = {key: {} if value is None else value for key, value in config.items()}
    base.setdefault("contact", {})
    cases = base.pop("cases", {})
    mistakes = [SettingsError(mistake) for mistake in _mistakes_in_cases(cases)]
    if mistakes or not cases:
        cases = {"": {}}
    resolved = {}
    for name, overrides in cases.items():
        merged = _merge(base, overrides)
        where = f"cases.{name}.contact" if "contact" in overrides else "contact"
        mistakes += [SettingsError(mistake) for mistake in _mistakes_in_choice(merged["contact"], where)]
        try:
            settings = Settings.model_validate(merged).model_dump(mode="json", exclude={"cases"})
        except ValidationError as error:
            for detail in error.errors():
                key = _dotted([part for part in detail["loc"] if not isinstance(part, int)][:2])
                mistakes.append(SettingsError(_sentence(name, overrides, detail), keys=[key]))
            continue
        if settings["crosscheck"]["code"] != "none" and not settings["crosscheck"]["python"]:
            code = settings["crosscheck"]["code"]
            mistakes.append(SettingsError(f"crosscheck.python: missing (path of the Python that has {code})"))
        if settings["contact"]["bodies"]:
            settings["contact"]["contact_modulus"] = contact_modulus(settings["contact"]["bodies"])
        resolved[name] = settings
    if mistakes:
        each = {str(mistake): mistake for mistake in mistakes}
        lines = ["mistakes in the settings:", *(f"  {sentence}" for sentence in each)]
        raise SettingsError("\n".join(lines), mistakes=list(each.values()))
    return resolved


def nearest(word: str, valid) -> str:
    """Return the end of a sentence that names the valid word nearest to `word`, or all of them."""
    close = get_close_matches(str(word).lower(), valid, n=1, cutoff=0.6)
    return f"did you mean {close[0]}?" if close else f"valid are {', '.join(valid)}"


def _mistakes_in_cases(cases) -> list[str]:
    """Return what is wrong with the mapping of cases as such, whatever the settings in it."""
    if not isinstance(cases, dict):
        return [f"cases = {cases!r}: must be a mapping from names to settings"]
    mistakes = []
    for name, overrides in cases.items():
        if not NAME.fullmatch(str(name)):
            mistakes.append(f"cases.{name}: a name has {NAME_RULE} (it becomes a folder)")
        if not isinstance(name, str):
            mistakes.append(f"cases.{name}: a name is text, put it in quotes")
        if not isinstance(overrides, dict):
            mistakes.append(
                f"cases.{name} = {overrides!r}: must be a group of settings that differ from those above"
            )
            continue
        mistakes += [
            f"cases.{name}.{key}: is common to all cases, set it at the top"
            for key in _COMMON
            if key in overrides
        ]
    return mistakes


def _mistakes_in_choice(contact, where: str) -> list[str]:
    """Return what is wrong with the settings of which one excludes the other."""
    if not isinstance(contact, dict):
        return []
    given = [[key for key in keys if contact.get(key) is not None] for keys in _ALTERNATIVES]
    mistakes = []
    if len(given[0]) != 1:
        mistakes.append(
            f"{where}: {' and '.join(given[0]) or 'no elasticity'} given; give either contact_modulus (E* in "
            "Pa) or bodies (two of youngs_modulus in Pa and poissons_ratio)"
        )
    if len(given[1]) == 2:
        mistakes.append(
            f"{where}: mean_pressure (Pa) and relative_pressure (no unit) given; give one of them or neither"
        )
    return mistakes


def _merge(base, overrides):
    """Return `base` with `overrides` laid over it, mapping by mapping; anything else is replaced whole."""
    if not (isinstance(base, dict) and isinstance(overrides, dict)):
        return deepcopy(overrides)
    merged = deepcopy(base)
    for keys in _ALTERNATIVES:
        if any(overrides.get(key) is not None for key in keys):
            for key in keys:
                merged.pop(key, None)
    for key, value in overrides.items():
        merged[key] = _merge(merged.get(key), value)
    return merged


def _sentence(case: str, overrides: dict, detail: dict) -> str:
    """Return one mistake that pydantic found as a sentence: key, value, rule, way out."""
    location, value = detail["loc"], detail["input"]
    key = _dotted(location)
    if case and location[0] in overrides and _given(overrides, location):
        key = f"cases.{case}.{key}"
    context = detail.get("ctx", {})
    match detail["type"]:
        case "extra_forbidden":
            return f"{key}: unknown key, {nearest(location[-1], list(_fields(location[:-1])))}"
        case "missing":
            return f"{key}: missing ({_description(location)})"
        case "value_error":
            rule = str(context["error"])
        case "literal_error":
            rule = f"unknown choice, {nearest(value, _choices(location))}"
        case "greater_than":
            rule = f"must be greater than {context['gt']:g}"
        case "greater_than_equal":
            rule = f"must not be less than {context['ge']:g}"
        case "less_than":
            rule = f"must be less than {context['lt']:g}"
        case "less_than_equal":
            rule = f"must not be greater than {context['le']:g}"
        case "too_short" | "too_long" if location[-1] == "bodies":
            rule = "needs exactly two bodies"
        case "too_short":
            rule = "the list is empty, give at least one number or leave the key out"
        case "model_type" | "dict_type":
            rule = "must be a group of settings (indented lines `key: value`)"
        case kind if kind.startswith("bool"):
            rule = "must be true or false"
        case kind if kind.startswith(("float", "finite")):
            rule = "must be a finite number"
        case kind if kind.startswith("int"):
            rule = "must be a whole number"
        case kind if kind.startswith("string"):
            rule = "must be text"
        case _:
            rule = detail["msg"]
    meaning = _description(location)
    return f"{key} = {value!r}: {rule}" + (f" ({meaning})" if meaning else "")


def _dotted(location) -> str:
    """Return ("contact", "bodies", 0, "poissons_ratio") as contact.bodies[0].poissons_ratio."""
    text = ""
    for part in location:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def _given(overrides, location) -> bool:
    """Return whether the overrides of a case reach down to `location` (or to the group it is missing in)."""
    for part in location[:-1]:
        if isinstance(part, int) or not isinstance(overrides, dict):
            return True
        overrides = overrides.get(part, {})
    return not isinstance(overrides, dict) or location[-1] in overrides


def _inner(annotation):
    """Return the types within an annotation, unions and annotated types and lists taken apart."""
    origin = get_origin(annotation)
    if origin is Annotated:
        return _inner(get_args(annotation)[0])
    if origin in (Union, UnionType, list):
        return [kind for part in get_args(annotation) for kind in _inner(part)]
    return [annotation]


def _fields(location) -> dict:
    """Return the fields of the section at `location`."""
    fields = Settings.model_fields
    for part in location:
        if isinstance(part, int):
            continue
        kinds = _inner(fields[part].annotation) if part in fields else []
        fields = next((k.model_fields for k in kinds if isinstance(k, type) and issubclass(k, BaseModel)), {})
    return fields


def _field(location):
    """Return the field that `location` names (list positions left out), None where there is none."""
    names = [part for part in location if not isinstance(part, int)]
    return _fields(names[:-1]).get(names[-1])


def _description(location) -> str:
    """Return the description, with the unit, of the setting at `location`."""
    field = _field(location)
    return (field.description or "") if field else ""


def _choices(location) -> list[str]:
    """Return the words that the setting at `location` may take."""
    return [word for kind in _inner(_field(location).annotation) for word in get_args(kind)]


def default_yaml() -> str:
    """Return the default configuration: every key with its default, its meaning and its unit."""
    head = (
        "# yaml-language-server: $schema=../workflow/schemas/config.schema.json\n"
        "# Settings of roughcontact with their defaults, written by `python -m roughcontact.configuration`.\n"
        "# For a run of your own copy this file, change it, and hand it over with `--configfile`. A key\n"
        "# that is left out has its default. config/README.md explains settings and table of surfaces.\n"
    )
    return head + "\n".join(_yaml(Settings, ""))


def _yaml(model, indent: str) -> list[str]:
    """Return the lines of one section; settings without a default are shown as a comment with an example."""
    lines = []
    for name, field in model.model_fields.items():
        section = next(
            (k for k in _inner(field.annotation) if isinstance(k, type) and issubclass(k, Section)), None
        )
        if section and model is Settings:
            lines += ["", f"# {section.__doc__}"]
            inside = _yaml(section, indent + "  ")
            lines += [f"{name}:", *inside] if section.model_fields else [f"{name}: {{}}"]
            continue
        text = field.description
        choices = [word for kind in _inner(field.annotation) for word in get_args(kind)]
        if choices and all(isinstance(word, str) for word in choices):
            text += f"; one of {', '.join(choices)}"
        if model is Settings:
            lines.append("")
        lines += [f"{indent}# {line}" for line in textwrap.wrap(text, 112 - len(indent))]
        value = field.get_default(call_default_factory=True)
        shown = name == "contact_modulus"  # has no default, yet the shipped configuration must run
        comment = "" if shown or value not in (None, {}) else "# "
        if comment or shown:
            value = field.examples[0]
        lines.append(f"{indent}{comment}{name}: {_flow(value)}")
    return lines


def _flow(value) -> str:
    """Return a value in YAML's one-line spelling, floats such that YAML 1.1 reads them as floats."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(v)}" for key, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, float):
        mantissa, _, exponent = f"{value:.6g}".partition("e")
        return mantissa + ("" if "." in mantissa else ".0") + (f"e{exponent}" if exponent else "")
    return json.dumps(value) if not isinstance(value, str) else value


def json_schema() -> str:
    """Return the JSON schema of the configuration, for editors that complete and check YAML."""
    schema = Settings.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    return json.dumps(schema, indent=2) + "\n"


def write_generated(root: Path) -> None:
    """Write config/config.yaml and workflow/schemas/config.schema.json below `root`."""
    for name, text in (
        ("config/config.yaml", default_yaml()),
        ("workflow/schemas/config.schema.json", json_schema()),
    ):
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
