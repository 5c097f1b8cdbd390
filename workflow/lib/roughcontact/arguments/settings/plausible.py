"""Slips of unit: bare numbers beyond those of all materials, loads and maps, alone or beside one another.

A bare number is in the base unit. A value with its unit is never questioned.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_args

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core.core_schema import CoreSchema, no_info_before_validator_function

from roughcontact.arguments import materials
from roughcontact.arguments.materials import Doubt
from roughcontact.arguments.quantities import quantity
from roughcontact.arguments.stacks import located_materials, top_material
from roughcontact.arguments.units import carries_unit, convert_to_base_unit, printed

Location = tuple[str | int, ...]
_OF_FORCES: dict[str | int, str] = {"force": "N", "area": "m2"}
_BARE_NUMBER_RULE = "A bare number is in {unit}: write the unit behind it, even if the number is correct"


class Spelling(ABC):
    """Further ways to write a value of a field type: how they are read, and their place in the schema."""

    def convert(self, value: Any) -> Any:
        """Return a value as the field has it."""
        return value

    @abstractmethod
    def widen(self, schema: JsonSchemaValue) -> JsonSchemaValue:
        """Return the schema that admits them as well."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_before_validator_function(self.convert, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return self.widen(handler(schema))


@dataclass(frozen=True)
class Range(Spelling):
    """The values of a quantity that are plausible as bare numbers; a validator of a field type.

    A value below `lowest` or above `highest` is in doubt, and is what `below` and `above` say; from `rigid`
    on it stands for something else. `likely_factors` are those of a value too low, the likeliest first.

    Examples
    --------
    >>> length = Range("m", 1e-10, 0.1, above="longer than any map")
    >>> length.convert("2 m"), length.convert(2e-6)
    (2.0, 2e-06)
    >>> try:
    ...     length.convert(0.8)
    ... except ValueError as error:
    ...     print(str(error).partition(" A bare")[0])
    800 mm is longer than any map (100 mm); did you mean 800 µm or 800 nm?
    """

    base: str
    lowest: float
    highest: float
    below: str = "less than is plausible"
    above: str = "more than is plausible"
    rigid: float = math.inf
    likely_factors: tuple[float, ...] = (1e9, 1e6, 1e3)

    def convert(self, value: Any) -> Any:
        """Return a value in the base unit; raise a ValueError with a question for an implausible number."""
        number = abs(bare_number(value)) if self.lowest < 0 else bare_number(value)  # angles may be negative
        if self.highest < number < self.rigid:
            reason, limit = self.above, self.highest
        elif 0 < number < self.lowest:
            reason, limit = self.below, self.lowest
        else:
            return convert_to_base_unit(value, self.base)
        # slips of unit: GPa, MPa, kPa where it is too low, mm, µm, nm where it is too high
        factors = self.likely_factors if limit == self.lowest else (1e-3, 1e-6, 1e-9)
        unit = printed(self.base)
        reason = f"is {reason} ({quantity(limit, unit)})"
        doubt = materials.doubt_about(number, reason, factors, max(self.lowest, 0), self.highest, unit)
        raise ValueError(f"{doubt.question()} {_BARE_NUMBER_RULE.format(unit=unit)}")

    def widen(self, schema: JsonSchemaValue) -> JsonSchemaValue:
        """Admit a text, the number with its unit, beside the number."""
        return {"anyOf": [schema, {"type": "string"}]}


def nested_types(annotation: Any) -> list[Any]:
    """Return an annotation, all types within it, and what is noted with them."""
    return [annotation, *(type_ for argument in get_args(annotation) for type_ in nested_types(argument))]


def setting_base(field: FieldInfo) -> str:
    """Return the base unit of a setting that may carry its unit; empty for a plain number and for words.

    Examples
    --------
    >>> from roughcontact.arguments.settings.models import Level
    >>> setting_base(Level.model_fields["s_filter"]), setting_base(Level.model_fields["max_missing"])
    ('m', '')
    """
    metadata = (*field.metadata, *nested_types(field.annotation))
    bases = {range_.base for range_ in metadata if isinstance(range_, Range)}
    return bases.pop() if len(bases) == 1 else ""  # moduli by times have two


def bare_number(value: Any) -> float:
    """Return a number without a unit, NaN for anything else."""
    try:
        return math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def implausible_together(raw: Mapping[str, Any], contact: Mapping[str, Any]) -> list[tuple[Location, str]]:
    """Return location and question for each modulus, hardness and load (SI) that others contradict.

    A number is not judged beside a modulus that is in doubt itself.
    """
    questions: list[tuple[Location, str]] = []

    def judge(doubt: Doubt | None, *where: str | int) -> None:
        location: Location = ("contact", *where)
        written = value_at(raw, ".".join(map(str, location)))
        if doubt and not carries_unit(written):
            unit = _OF_FORCES.get(where[0], "Pa")
            question = doubt.question() if unit == "Pa" else f"force by area, {doubt.question()}"
            rule = _BARE_NUMBER_RULE.format(unit=printed(unit))
            questions.append((location, f" = {written!r}: {question} {rule}"))

    loads, hardness, area = contact["mean_pressure"] or (), contact["hardness"], contact["area"]
    if contact["force"] and area:
        loads = [force / area for force in contact["force"]]
    for where, material in located_materials(contact["bodies"]):
        if (modulus := material["youngs_modulus"]) is not None:  # all but a rigid base
            judge(materials.doubt_of_body(modulus, material["poissons_ratio"]), *where, "youngs_modulus")
        if (of_body := material.get("hardness")) is not None:  # it is that of its surface
            stiffness = top_material(material)["youngs_modulus"]
            judge(materials.doubt_of_hardness(of_body, stiffness), *where, "hardness")
    if contact["bodies"]:
        modulus = materials.contact_modulus(contact["bodies"])
    else:
        modulus = contact["contact_modulus"]
        judge(materials.doubt_of_gel(modulus, [*loads, hardness or 0.0]), "contact_modulus")
    if questions:  # a doubtful modulus makes every load doubtful: one question is enough
        return questions
    if hardness is not None:
        judge(materials.doubt_of_hardness(hardness, modulus), "hardness")
    for index, load in enumerate(loads):
        keys: Location = ("force", index) if area else ("mean_pressure", index)
        if area and carries_unit(value_at(raw, f"contact.force.{index}")):
            keys = ("area",)
        judge(materials.doubt_of_load(load, modulus), *keys)
    return questions


def value_at(config: Any, name: str) -> Any:
    """Return what settings hold under a dotted name, an empty text where they hold nothing.

    A value alone may stand for a list of one, and a name for a body.

    Examples
    --------
    >>> value_at({"contact": {"bodies": ["steel", {"hardness": "1 GPa"}]}}, "contact.bodies.1.hardness")
    '1 GPa'
    """
    for key in name.split("."):
        if isinstance(config, list | tuple) and key.isdecimal():
            config = config[int(key)] if int(key) < len(config) else ""
        elif isinstance(config, Mapping):
            config = config.get(key, "")
        elif key != "material" and not key.isdecimal():
            return ""
    return config
