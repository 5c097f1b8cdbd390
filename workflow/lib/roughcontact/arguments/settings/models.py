"""The settings: the keys of the configuration, their units and defaults.

A section is exactly the keyword arguments of its function (`level(height, **settings["level"])`), so that
each quantity has one name.
"""

import math
import re
from functools import cache, partial
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue

from roughcontact.arguments import choices
from roughcontact.arguments.materials import MAX_FRICTION, MAX_HARDNESS, MIN_LOAD, RIGID, SOFTEST, STIFFEST
from roughcontact.arguments.ranges import with_shares
from roughcontact.arguments.settings.plausible import Range, Spelling, bare_number, setting_base
from roughcontact.arguments.units import carries_unit, printed

T = TypeVar("T")


def _not_boolean(value: Any) -> Any:
    """Reject true and false for a number: Python takes them for 1 and 0."""
    if isinstance(value, bool):
        raise ValueError("must be a number")
    return value


def _without_sign(value: Any, *, signs: tuple[str, ...]) -> Any:
    """Return a limit without the sign before it, or reject another one than the `signs`."""
    if not isinstance(value, str):
        return value
    limit = value.strip().lstrip("<>≤≥=").strip()
    if value.strip().removesuffix(limit).strip() not in ("", *signs):
        raise ValueError(f"is a limit of the other side; write {signs[0]} {limit}")
    return limit


def _relative_load(value: Any) -> Any:
    """Reject a pressure, with or without its unit, for a load relative to the modulus."""
    if carries_unit(value) and "," in value:  # as in 0,1
        raise ValueError("write a decimal point, not a comma")
    if carries_unit(value):
        raise ValueError("has no unit; a load with one is mean_pressure")
    if _MAX_RELATIVE < bare_number(value) < math.inf:
        raise ValueError(
            "is in units of E* x rms gradient, in which contact is full from about 1 on; did you mean "
            "mean_pressure?"
        )
    return value


class OneOrMore(Spelling):
    """Takes a single value for a list of one, in the schema further ones as well; of a field type."""

    def __init__(self, *further: JsonSchemaValue):
        self.further = further

    def convert(self, value: Any) -> Any:
        """Return a single value as a list of one."""
        return value if isinstance(value, list | tuple | NoneType) else [value]

    def widen(self, schema: JsonSchemaValue) -> JsonSchemaValue:
        """Admit what may stand in the list beside it."""
        item_schemas = schema["items"].get("anyOf", [schema["items"]])
        return {"anyOf": [*self.further, *item_schemas, schema]}


class OrNone(Spelling):
    """Takes the word none for no value, of a setting whose default is a number."""

    def convert(self, value: Any) -> Any:
        """Return no value for the word."""
        return None if value == "none" else value

    def widen(self, schema: JsonSchemaValue) -> JsonSchemaValue:
        """Admit the word beside the value."""
        return {"anyOf": [*schema["anyOf"], {"const": "none"}]}


class OrRange(Spelling):
    """Admits, in the schema, both ends of a range for the value of a property, which `with_shares` reads."""

    def widen(self, schema: JsonSchemaValue) -> JsonSchemaValue:
        """Return the schema of the value, or of two."""
        return {"anyOf": [*schema["anyOf"], {"type": "array", "items": schema, "minItems": 2, "maxItems": 2}]}


def _half_range(shares: Any) -> Any:
    """Return one number for a range about the middle."""
    return sum(shares) / 2 if isinstance(shares, list) and len(shares) == 2 else shares


def _leaves_a_rest(shares: list[float]) -> list[float]:
    """Reject a range that reaches down to nothing."""
    if shares[0] >= 1:
        raise ValueError("must be less than 1 below the value")
    return shares


def _largest_load(value: Any) -> Any:
    """Return no load in particular for true, nothing for false, and a single load as a list of one."""
    single = value[0] if isinstance(value, list) and len(value) == 1 else value
    single = {"true": True, "false": False}.get(single, single) if isinstance(single, str) else single
    return ([] if single else None) if isinstance(single, bool) else _ONE_OR_MORE.convert(value)


def _ways(value: Any) -> Any:
    """Return the angles (degree) of both ways for the words."""
    return [0.0, 180.0] if value == "both ways" else value


Number = Annotated[float, BeforeValidator(_not_boolean)]
Count = Annotated[int, BeforeValidator(_not_boolean)]
Positive = Annotated[Number, Field(gt=0)]
RelativeUncertainty = Annotated[Number, Field(ge=0, lt=1)]
HalfRange = Annotated[RelativeUncertainty, BeforeValidator(_half_range)]
# below and above the value, or one for both
RelativeRange = Annotated[
    list[Annotated[Number, Field(ge=0, lt=100)]],
    Field(min_length=1, max_length=2),
    AfterValidator(_leaves_a_rest),
    OneOrMore(),
]
_MAX_RELATIVE = 100.0  # load in units of E* g; any surface is in full contact long before
_ONE_OR_MORE = OneOrMore()
# of values of a type: those of which each is solved, those of one solution, a range, limits with their sign
Solved = Annotated[list[T], Field(min_length=1, max_length=1000), _ONE_OR_MORE]
Series = Annotated[list[T], Field(min_length=1, max_length=100), _ONE_OR_MORE]
Ranged = Annotated[T, OrRange()]
AtMost = Annotated[T, BeforeValidator(partial(_without_sign, signs=("<=", "≤")))]
AtLeast = Annotated[T, BeforeValidator(partial(_without_sign, signs=(">=", "≥")))]
# quantities with a dimension: a bare number in SI units, in a plausible range, or a number with its unit
Length = Annotated[Positive, Range("m", 1e-10, 0.1, above="longer than any map, layer or seal")]
Height = Annotated[Positive, Range("m", 1e-12, 1e-3)]  # also of tips, and pixels
Modulus = Annotated[
    Positive, Range("Pa", SOFTEST, STIFFEST, "softer than any gel", "stiffer than diamond", rigid=RIGID)
]
Strength = Annotated[
    Positive, Range("Pa", 1e5, MAX_HARDNESS * STIFFEST, "softer than any foam", "harder than diamond")
]
_LOAD_WORDS = ("next to no load", "more than any contact bears")
Pressure = Annotated[Positive, Range("Pa", MIN_LOAD, STIFFEST, *_LOAD_WORDS, likely_factors=(1e6, 1e3))]
# aerogels to diamond; metals to conductive polymers
Conductivity = Annotated[Positive, Range("W m-1 K-1", 1e-3, 1e4)]
Resistivity = Annotated[Positive, Range("Ohm m", 1e-9, 0.1)]
Area = Annotated[Positive, Range("m2", 1e-14, 1e3)]
Time = Annotated[Positive, Range("s", 1e-9, 1e11)]
Speed = Annotated[Positive, Range("m s-1", 1e-9, 1e3)]
# of what is allowed: bubbles a year to open pipes; welded contacts to insulators
Flow = Annotated[Positive, Range("m3 s-1", 1e-18, 1.0)]
Resistance = Annotated[Positive, Range("Ohm", 1e-9, 1e6)]
TemperatureDrop = Annotated[Positive, Range("K", 1e-6, 5e3)]
RelativeLoad = Annotated[Positive, BeforeValidator(_relative_load)]
Force = Annotated[Positive, Range("N", 1e-9, 1e8)]
Loads = Solved[Pressure]
Slid = Annotated[Positive, Range("m", 1e-9, 1e9)]
ThermalResistance = Annotated[Positive, Range("m2 K W-1", 1e-12, 10.0)]  # times area, as the next one
ContactResistance = Annotated[Positive, Range("Ohm m2", 1e-18, 1.0)]
Angle = Annotated[Number, Range("degree", -720, 720)]
Directions = Annotated[
    Annotated[list[Angle], Field(min_length=1, max_length=36), OneOrMore({"const": "both ways"})],
    BeforeValidator(_ways),
]
Radius = Annotated[Positive, Range("m", 1e-9, 1e3)]
Radii = Annotated[list[Radius], Field(min_length=1, max_length=2), _ONE_OR_MORE]
Targets = Annotated[
    list[choices.LoadTarget], Field(min_length=1, max_length=len(get_args(choices.LoadTarget))), _ONE_OR_MORE
]
UnloadedFrom = Annotated[
    Annotated[list[Pressure], Field(max_length=1000), OneOrMore({"type": "boolean"})] | None,
    BeforeValidator(_largest_load),
]


def _example(value: Any) -> Any:
    """Return the field of a setting that is absent by default, with an example."""
    return Field(default=None, examples=[value])


def _section() -> Any:
    """Return the field of a section, empty by default: for an instance its own validator would be built."""
    return Field(default_factory=dict, validate_default=True)


# a text below the field before it; parsing the source takes eight times as long
_TEXT_BELOW = re.compile(r'^    (\w+): (?:(?!^    \w|""").)*?^    """(.*?)"""', re.MULTILINE | re.DOTALL)


@cache
def _texts_below_fields() -> dict[str, dict[str, str]]:
    """Return class -> field -> text; for each class pydantic would look for this file in all modules."""
    sections = Path(__file__).read_text(encoding="utf-8").split("\nclass ")[1:]
    return {section.partition("(")[0]: dict(_TEXT_BELOW.findall(section)) for section in sections}


class Section(BaseModel):
    """A group of settings, each described below it; unknown keys, infinities and NaN are mistakes."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False, defer_build=True)

    @classmethod
    def __pydantic_init_subclass__(cls, **_: Any) -> None:
        """Let each description be the text below the field, in one line, and its unit."""
        for name, text in _texts_below_fields().get(cls.__name__, {}).items():
            field = cls.model_fields[name]
            base = setting_base(field)
            unit_text = f"; a number alone is in {printed(base)}" if base else ""
            field.description = " ".join(text.split()) + unit_text

    @model_validator(mode="before")
    @classmethod
    def _ranges(cls, values: Any) -> Any:
        """Let the value of a property be both ends of a range."""
        return with_shares(values, cls.model_fields)


class Level(Section):
    """Levelling: remove outliers, align scan lines, remove form and waviness, fill in missing points."""

    form: choices.LevelForm = "plane"
    """form that is fitted to the map and subtracted"""
    order: Count = Field(default=2, ge=1, le=choices.MAX_ORDER)
    """total order of the polynomial, x^i y^j with i + j <= order"""
    robust: bool = False
    """fit without weight on deep valleys and high spikes (otherwise least squares)"""
    outlier_threshold: Annotated[Positive | None, OrNone()] = 6.0
    """isolated spikes that deviate from their surroundings by more than this many local standard deviations
    are treated as missing; none keeps every point"""
    line_alignment: choices.LineAlignment = "auto"
    """how rows (scan lines) are shifted to match one another; jitter: by their random jumps from row to row;
    auto: as jitter where the rows clearly jump, otherwise not; median: the median of each row to the same
    height; matched-steps: the median step from row to row to zero"""
    scar_threshold: Positive | None = _example(4.0)
    """for scanned maps: pieces of one to four rows that deviate from the rows before and after by more than
    this many standard deviations are treated as missing (4 is a good start); narrow grooves along x look the
    same; left empty: every point is kept"""
    s_filter: Length | None = _example("2.5 µm")
    """nesting index of the S-filter (areal Gaussian, ISO 16610-61): shorter waves are removed; left empty:
    they are kept"""
    l_filter: Length | None = _example("0.8 mm")
    """nesting index of the L-filter (areal Gaussian, ISO 16610-61): longer waves are removed; left empty:
    they are kept"""
    fill: choices.Fill = "harmonic"
    """how missing points are filled in; those at the border are cropped instead"""
    max_missing: Number = Field(default=0.4, ge=0, le=1)
    """largest share of missing points; a map with more is rejected"""


class Composite(Section):
    """Relative positions of two measured faces that touch (column counter_face of the table)."""

    shifts: Count = Field(default=5, ge=1, le=100)
    """random shifts for each rotation; each is solved"""
    rotations: list[Angle] = Field(default_factory=lambda: [0.0], min_length=1, max_length=360)
    """angles by which the counter-face is rotated on the face, from x towards y"""
    overlap: Number = Field(default=0.75, gt=0, le=1)
    """minimum share of each side of the smaller map that the other one covers"""
    seed: Count = Field(default=0, ge=0, lt=2**32)
    """of the random shifts"""


class Form(Section):
    """The nominal form of a body of finite size, of which the map is the roughness (boundary: free)."""

    radius: Radii | None = _example("5 mm")
    """of the body; two of an ellipsoid, along x and y; left empty: the map itself is the body"""
    edges: bool = False
    """whether the body ends where the map does, with sharp edges: a flat punch, a chip, a pin"""
    local_scale: bool = False
    """for a map smaller than the contact (boundary: periodic): each place under the nominal pressure of the
    smooth body (Hertz), given its radius and force; roughness small against the form"""


class Window(Section):
    """The periodic window for the solver."""

    placement: choices.Placement = "largest"
    """part of the map that is solved; largest: the largest rectangle without missing points; whole-periods:
    shortened to a whole number of periods of a texture that repeats"""
    method: choices.WindowMethod = "smooth-cross-fade"
    """how that part is made periodic; docs/explanation/surface.md compares them"""
    width: Number = Field(default=0.1, gt=0, le=0.5)
    """share of the side over which the two cross-fades blend or taper falls; other methods ignore it"""
    min_share: Number = Field(default=0.05, ge=0, le=1)
    """minimum share of the map that the window must cover; smaller ones are rejected"""
    shortest_wavelength: Length | None = _example("2 µm")
    """shorter waves are removed from the window; left empty: they are kept; the cutoff is sharp, so that
    steps and particles ring: the S-filter of the levelling is smooth"""
    longest_wavelength: Length | None = _example("100 µm")
    """longer waves are removed from the window; left empty: they are kept"""
    reliable_band: bool = False
    """remove waves that are shorter than the instrument resolves (two pixels, or the limit of the lens if the
    file states its numerical aperture)"""


# of bodies and layers: `resolve` replaces it by the properties of the material
MATERIAL = FieldInfo(
    annotation=str,
    default=None,
    description="name of a material of the table; others state their modulus and Poisson's ratio",
    examples=["steel"],
)


def _drop_required(schema: dict[str, Any]) -> None:
    """Require no elastic constants in the schema: a rigid base has none, a named material brings them."""
    schema["required"] = [key for key in schema["required"] if key == "thickness"]
    schema["properties"]["material"] = {"type": "string", "description": MATERIAL.description}


def _or_names(schema: dict[str, Any]) -> None:
    """Admit names of materials for bodies in the schema: `resolve` replaces them."""
    (bodies,) = (schema_of_type for schema_of_type in schema["anyOf"] if schema_of_type["type"] == "array")
    bodies["items"] = {"anyOf": [bodies["items"], {"type": "string"}]}


class Layer(Section):
    """A bonded layer of a body: a coating, a sheet."""

    model_config = ConfigDict(json_schema_extra=_drop_required)

    name: str | None = Field(default=None, max_length=64, examples=["DLC"])
    """for the report"""
    thickness: Length = Field(examples=["2 µm"])
    """of the layer"""
    youngs_modulus: Ranged[Modulus] = Field(examples=["180 GPa"])
    """Young's modulus of the layer"""
    poissons_ratio: Number = Field(gt=-1, le=0.5, examples=[0.2])
    """Poisson's ratio of the layer, no unit"""
    yield_stress: Strength | None = _example("4 GPa")
    """of the layer in tension: as that of a body, which with layers is that of its base"""
    thermal_conductivity: Ranged[Conductivity] | None = _example(2.0)
    """of the layer"""
    electrical_resistivity: Ranged[Resistivity] | None = _example(1.0e-3)
    """of the layer"""
    youngs_modulus_uncertainty: RelativeRange | None = _example(0.1)
    """as that of a body, as the two below"""
    thermal_conductivity_uncertainty: RelativeRange | None = _example(0.3)
    """of the layer"""
    electrical_resistivity_uncertainty: RelativeRange | None = _example(0.3)
    """of the layer"""


class Body(Section):
    """One of the two bodies."""

    model_config = ConfigDict(json_schema_extra=_drop_required)

    name: str | None = Field(default=None, max_length=64, examples=["steel"])
    """of the material, for the report"""
    youngs_modulus: Ranged[Modulus] | None = Field(examples=["210 GPa"])
    """Young's modulus E; it, the hardness and the conductivities may be ranges, [1.1 GPa, 1.8 GPa]"""
    poissons_ratio: Annotated[Number, Field(gt=-1, le=0.5)] | None = Field(examples=[0.3])
    """Poisson's ratio, no unit"""
    creep_modulus: dict[Time, Modulus] | None = _example({"1 h": "2.1 GPa", "1000 h": "1.4 GPa"})
    """stress over strain after a time under a constant stress, moduli by times: the results then include
    area, gap, conductance and leak after these times (docs/how-to/after-ten-years.md)"""
    relaxation: str | dict[str, Any] | None = _example("measured/dma.csv")
    """of a rubber: a name, the path of a table of storage and loss modulus over frequency, or a Prony series
    {long_time_modulus, moduli, times}; {table, wlf, reference_temperature, temperature} for another
    temperature (docs/how-to/rubber.md); without Young's modulus that is E' at the lowest frequency or the
    long-time modulus, without Poisson's ratio that is 0.5"""
    base: Literal["rigid"] | None = None
    """rigid: the layers lie on a base that does not give way, and the body has no elastic constants of its
    own"""
    layers: list[Layer] | None = Field(
        default=None,
        max_length=50,
        examples=[[{"thickness": "2 µm", "youngs_modulus": "180 GPa", "poissons_ratio": 0.2}]],
    )
    """bonded layers from the surface inwards, each with thickness, Young's modulus, Poisson's ratio and, if
    known, yield stress"""
    hardness: Ranged[Strength] | None = _example("2 GPa")
    """largest pressure that its surface carries before it yields (indentation hardness)"""
    yield_stress: Strength | None = _example("400 MPa")
    """in tension: the results then include the stresses below the surface and the load at which it yields
    there"""
    thermal_conductivity: Ranged[Conductivity] | None = _example(50.0)
    """of both bodies: the results then include the thermal contact conductance"""
    electrical_resistivity: Ranged[Resistivity] | None = _example(2.0e-7)
    """of both bodies: the results then include the electrical contact conductance"""
    youngs_modulus_uncertainty: RelativeRange | None = _example(0.05)
    """instead of a range, relative, expanded (95 %), no unit, one number or one below and one above, as those
    below; it is part of the ±"""
    hardness_uncertainty: RelativeRange | None = _example([0.2, 0.3])
    """of the hardness"""
    thermal_conductivity_uncertainty: RelativeRange | None = _example(0.1)
    """of the thermal conductivity"""
    electrical_resistivity_uncertainty: RelativeRange | None = _example(0.1)
    """of the electrical resistivity"""

    @model_validator(mode="before")
    @classmethod
    def _rigid(cls, values: Any) -> Any:
        """Let a rigid base do without elastic constants."""
        if isinstance(values, dict) and values.get("base") is not None:
            return {"youngs_modulus": None, "poissons_ratio": None} | values
        return values


_STEEL = {"name": "steel", "youngs_modulus": "210 GPa", "poissons_ratio": 0.3}
_STEEL |= {"hardness": "2 GPa", "thermal_conductivity": 50.0}
_PEEK = {"name": "PEEK", "youngs_modulus": "4 GPa", "poissons_ratio": 0.4}
_PEEK |= {"hardness": "0.3 GPa", "thermal_conductivity": 0.3}


class Contact(Section):
    """The contact problem: contact_modulus or bodies, mean_pressure or relative_pressure or neither."""

    contact_modulus: Ranged[Modulus] | None = _example("115 GPa")
    """plane-strain contact modulus E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; 115 GPa for steel on
    steel"""
    bodies: list[Body] | None = Field(
        default=None, min_length=2, max_length=2, json_schema_extra=_or_names, examples=[[_STEEL, _PEEK]]
    )
    """the two bodies, instead of contact_modulus: names of materials ([steel, PEEK]), or Young's moduli (Pa),
    Poisson's ratios and optional properties, to which material: steel adds those of a name"""
    mean_pressure: Loads | None = _example(["1 MPa", "2 MPa", "5 MPa", "10 MPa", "20 MPa", "50 MPa"])
    """nominal pressure, one number or a list; if no load is given, log-spaced loads are planned"""
    relative_pressure: Solved[RelativeLoad] | None = _example([0.01, 0.05, 0.2])
    """nominal pressure / (E* x rms gradient of the window), no unit, one number or a list"""
    boundary: choices.Boundary = "periodic"
    """periodic: the map repeats; free: a body of finite size (section form) under a force"""
    force: Solved[Force] | None = _example("50 N")
    """one number or a list: on a body of finite size; with an area, or on a local scale (form), instead of a
    mean pressure"""
    area: Area | None = _example("3 cm²")
    """nominal area that carries the force"""
    target_area: Solved[Annotated[Number, Field(gt=0, lt=1)]] | None = _example([0.1])
    """relative contact area whose load is found and solved, in addition to the given loads; one number or a
    list"""
    target_gap: Solved[Height] | None = _example(["0.2 µm"])
    """mean gap whose load is found and solved, in addition to the given loads; one number or a list"""
    target: Targets | None = _example(["percolation"])
    """further states whose load is found and solved: percolation, at which the gap closes along x and along
    y; first_yield, at which a body begins to yield (its yield stress below the surface, otherwise the
    hardness)"""
    time: Series[Time] | None = _example(["1 h", "1000 h"])
    """times after which a body has crept by its relaxation; those of a creep modulus stand there"""
    contact_modulus_uncertainty: HalfRange | None = _example(0.05)
    """of the contact modulus, relative, expanded (95 %), no unit; it is part of the ±"""
    mean_pressure_uncertainty: RelativeUncertainty | None = _example(0.02)
    """of the loads, relative, expanded (95 %), no unit; it is part of the ±"""
    tolerance: Number = Field(default=1e-4, ge=choices.MIN_TOLERANCE, lt=1)
    """largest accepted error_bound (relative, energy norm), no unit"""
    zero_frequency: choices.ZeroFrequency = "zero"
    """mean displacement in the approach: zero, nogi-kato (its mean over the q = 0 cell), lattice (one contact
    per window in free space); pressure and area do not depend on it"""
    hardness: Ranged[Strength] | None = _example("2 GPa")
    """largest pressure that the softer body carries before it yields (indentation hardness): the upper limit
    of the pressure; not given here if bodies state theirs; without any: elastic throughout"""
    hardness_uncertainty: RelativeRange | None = _example([0.2, 0.3])
    """of the hardness, relative, expanded (95 %), no unit, one number or one below and one above; it is part
    of the ±; not given: the range of the bodies"""
    unload: UnloadedFrom = _example(True)
    """take a load off after it was reached, and write the surface that flow has left and the contact on the
    way back to residual.nc; true: the largest load; or loads; needs a hardness"""
    influence: choices.Influence = "sampled"
    """elastic influence function: sampled (exact for each wave of the grid) or elements (pressure constant on
    every pixel)"""
    precision: choices.Precision = "double"
    """of the result: double, or single for maps that fill the memory"""
    keep_fields: bool = True
    """keep the maps of pressure, gap and contact of every load in contact.nc"""
    on_failure: choices.OnFailure = "raise"
    """consequence for a load that misses the tolerance: raise (the surface fails) or flag (the load is kept
    with converged = 0)"""


class Seal(Section):
    """A seal of which the surface is part, and the sealed fluid."""

    viscosity: Annotated[Positive, Range("Pa s", 5e-6, 10)] = Field(examples=["1 mPa s"])
    """of the fluid, dynamic"""
    pressure_difference: Pressure = Field(examples=["1 bar"])
    """of the fluid between both sides of the seal"""
    width: Length = Field(examples=["2 mm"])
    """of the seal in the direction of the flow"""
    perimeter: Annotated[Positive, Range("m", 1e-9, 1e3)] | None = _example("120 mm")
    """length of the seal across the flow: the results then include the leak of the whole seal"""
    allowed_leak: Flow | None = _example("1 ml/h")
    """largest leak of the whole seal: the results then say whether, and from which load on, it holds; needs
    the perimeter"""
    outlet_pressure: Pressure | None = _example("1 bar")
    """absolute pressure behind the seal: the fluid is then an ideal gas, which expands on its way, and the
    leak its volume at this pressure; left empty: a liquid"""
    mean_free_path: Length | None = _example("68 nm")
    """of the molecules of the gas at the outlet pressure: the leak then includes slip; 68 nm for air at 1
    bar"""


class Joint(Section):
    """What conducts heat beside the metal, and what the joint as a whole may do."""

    area: Area | None = _example("4 mm²")
    """nominal area of the joint: the results then include the resistances of the whole joint, and its force;
    left empty: the nominal area that carries the force of the contact"""
    allowed_resistance: Resistance | None = _example("1 mΩ")
    """largest electrical resistance of the whole joint: the results then say whether, and from which load on,
    it holds; needs the area and the electrical resistivity of both bodies"""
    allowed_temperature_drop: TemperatureDrop | None = _example("2 K")
    """largest temperature drop across the joint: as the allowed resistance; needs the area, the heat flow and
    the thermal conductivity of both bodies"""
    heat_flow: Annotated[Positive, Range("W", 1e-9, 1e9)] | None = _example("5 W")
    """through the whole joint: the results then include the temperature drop; needs the area"""
    gas_conductivity: Conductivity | None = _example(0.026)
    """of the gas in the gap; left empty: a vacuum"""
    temperature_jump: Length | None = _example("0.37 µm")
    """sum of the temperature jump distances of gas and both faces; for air at 1 bar and metals about 0.37
    µm"""
    film_thickness: Length | None = _example("5 nm")
    """of an oxide or a coating on the spots"""
    film_conductivity: Conductivity | None = _example(2.0)
    """of that film"""


class Requirement(Section):
    """What the surface has to meet; the results say whether it holds, and up to which Sq it would."""

    thermal_resistance: AtMost[ThermalResistance] | None = _example("<= 2e-6 m² K/W")
    """thermal resistance times area at most, with film and gas; needs the thermal conductivity of both
    bodies"""
    contact_resistance: AtMost[ContactResistance] | None = _example("<= 10 µΩ mm²")
    """electrical resistance times area at most; needs the electrical resistivity of both bodies"""
    gap: AtMost[Annotated[Positive, Range("m", 1e-12, 0.01)]] | None = _example("<= 0.5 µm")
    """mean gap at most"""
    contact_area: AtLeast[Annotated[Positive, Field(lt=1)]] | None = _example(">= 0.1")
    """relative contact area at least, no unit"""
    leak: AtMost[Flow] | None = _example("<= 1 ml/h")
    """leak of the whole seal at most; needs a seal with its perimeter"""
    resistance: AtMost[Resistance] | None = _example("<= 1 mΩ")
    """electrical resistance of the whole joint at most; needs the area of the joint"""
    temperature_drop: AtMost[TemperatureDrop] | None = _example("<= 2 K")
    """temperature drop across the joint at most; needs area and heat flow of the joint"""
    pressure: AtMost[Strength] | None = _example("<= 1 GPa")
    """largest pressure in the contact at most"""


class Friction(Section):
    """A tangential load, or sliding; see docs/how-to/friction.md."""

    coefficient: Annotated[Number, Field(gt=0, le=MAX_FRICTION)] | None = _example(0.2)
    """coefficient of friction mu, no unit"""
    tangential_load: Series[Annotated[Number, Field(gt=0, le=1)]] | None = _example([0.3, 0.6])
    """Q/(mu P), below the load of sliding; 1 is full slip; needs the coefficient"""
    shear_strength: Ranged[Strength] | None = _example("50 MPa")
    """of the contact: the coefficient of friction follows from the area"""
    shear_strength_uncertainty: RelativeRange | None = _example(0.2)
    """of the shear strength, as that of the hardness"""
    speed: Speed | None = _example("1 m/s")
    """of sliding along x: flash temperatures are added; needs the thermal conductivity of both bodies"""
    thermal_diffusivity: Annotated[Positive, Range("m2 s-1", 1e-8, 1e-2)] | None = _example("14 mm²/s")
    """of the second body, which slides; left empty: the temperature of slow sliding, an upper limit"""


class Statistics(Section):
    """Statistics of the contact, and quantities derived from it; see docs/explanation/answers.md."""

    pressure_bins: Count = Field(default=20, ge=1, le=1000)
    """bins of the pressure density, per factor of ten"""
    gap_bins: Count = Field(default=20, ge=1, le=1000)
    """bins of the gap density, per factor of ten"""
    flow: choices.Extra = "auto"
    """whether the flow of a fluid through the gap is solved, which takes longer than the contact itself;
    auto: if a seal is given"""
    stress: choices.Extra = "auto"
    """whether the stresses below the surface are computed (needs bodies); auto: if one of them states its
    yield stress"""
    work_of_adhesion: Annotated[Positive, Range("J m-2", 1e-5, 10)] | None = _example("50 mJ/m²")
    """of flat surfaces: the results then include whether it suffices to press the roughness flat"""
    seal: Seal | None = _example({"viscosity": "1 mPa s", "pressure_difference": "1 bar", "width": "2 mm"})
    """a seal, whose leak rate the results then include: viscosity and pressure difference of the fluid, width
    of the seal; what it is allowed to leak"""
    joint: Joint | None = _example({"gas_conductivity": 0.026, "temperature_jump": "0.37 µm"})
    """a joint: gas in the gap beside the spots, a film on them (both bodies state their thermal
    conductivity); its area, what it is allowed to resist"""
    allowed_pressure: Strength | None = _example("1 GPa")
    """largest pressure in the contact: the results then say whether, and up to which load, it holds"""
    requirement: Requirement | None = _example({"thermal_resistance": "<= 2e-6 m² K/W"})
    """what the surface has to meet: the results then say whether it holds, and the largest Sq of this texture
    with which it does; see docs/how-to/requirement.md"""
    friction: Friction | None = _example({"coefficient": 0.2, "tangential_load": [0.3, 0.6]})
    """stick and slip under a tangential load, friction from the area, flash temperatures"""


class Wear(Section):
    """Running-in: wear of the face by sliding against a smooth one; see docs/how-to/running-in.md."""

    # hard coatings in oil to soft polymers on rough steel
    coefficient: Annotated[Positive, Range("Pa-1", 1e-22, 1e-8)] | None = _example("1e-7 mm³/(N m)")
    """wear coefficient k, worn volume over load and distance; left empty: no wear"""
    coefficient_factor: Annotated[Number, Field(ge=1, le=1e6)] = 1.0
    """factor by which the coefficient may be higher or lower (95 %), no unit: it moves the distances alone"""
    distance: Series[Slid] | None = _example(["0.1 m", "1 m", "10 m", "100 m"])
    """sliding distances whose faces and contacts are written to worn.nc, rising; needs the coefficient"""
    mean_pressure: Pressure | None = _example("20 MPa")
    """nominal pressure of sliding; left empty: the largest load of the contact"""


class Sliding(Section):
    """Friction of rubber that slides over the face; see docs/how-to/rubber.md."""

    speed: Series[Speed] | None = _example(["1 mm/s", "10 mm/s", "0.1 m/s", "1 m/s"])
    """speeds at which it slides, rising; one of the bodies states its relaxation; left empty: no sliding"""
    direction: Directions = Field(default_factory=lambda: [0.0])
    """in which it slides over the face, from x towards y: one, several, or both ways (0 and 180)"""
    mean_pressure: Pressure | None = _example("0.5 MPa")
    """nominal pressure of sliding; left empty: the largest load of the contact"""


class Uncertainty(Section):
    """The error budget: the sources of the ± of a headline number; see docs/explanation/uncertainty.md."""

    sources: list[choices.UncertaintySource] = Field(
        default_factory=lambda: list(get_args(choices.UncertaintySource)),
        max_length=len(get_args(choices.UncertaintySource)),
    )
    """list of the sources of the ±; the empty list [] omits the error budget"""
    windows: Count = Field(default=9, ge=4, le=400)
    """number of subwindows that are solved separately, for the source window"""


class Instrument(Section):
    """What is known of the instrument, for the ±; columns of the table of surfaces prevail."""

    noise: Height | None = _example("2 nm")
    """measurement noise N_M, rms"""
    resolution: Height | None = _example("1.5 µm")
    """topographic spatial resolution W_R: the wavelength of which half is transmitted"""
    numerical_aperture: Annotated[Number, Field(gt=0, le=1.6)] | None = _example(0.55)
    """of the lens, no unit"""
    wavelength: Annotated[Positive, Range("m", 1e-8, 1e-4)] | None = _example("520 nm")
    """of the light; left empty: 550 nm"""
    tip_radius: Height | None = _example("2 µm")
    """of a stylus or a probe"""
    amplification_z: RelativeUncertainty | None = _example(0.01)
    """uncertainty of the height scale, relative, expanded (95 %), no unit"""
    amplification_xy: RelativeUncertainty | None = _example(0.005)
    """uncertainty of the lateral scale, relative, expanded (95 %), no unit"""
    correct: bool = False
    """whether the map is corrected for noise, and resolution or lens, as far as they are known: the results
    are then those of the corrected map, and say so; else only the ± includes them"""


class Report(Section):
    """The page with the results."""

    title: str = "Contact of rough surfaces"
    """title of the page"""


class Settings(Section):
    """Settings of roughcontact."""

    surfaces: str = Field(default="config/surfaces.tsv", min_length=1)
    """path of the table of surfaces, tab-separated, one row each; see config/README.md"""
    level: Level = _section()
    composite: Composite = _section()
    window: Window = _section()
    form: Form = _section()
    contact: Contact = _section()
    statistics: Statistics = _section()
    uncertainty: Uncertainty = _section()
    instrument: Instrument = _section()
    wear: Wear = _section()
    sliding: Sliding = _section()
    report: Report = _section()
    cases: dict[str, dict[str, Any]] = Field(
        default_factory=dict, examples=[{"soft": {"contact": {"contact_modulus": "1 GPa"}}}]
    )
    """a study: name of a case -> settings that differ from those above; every surface runs under every case,
    results go to results/{case}/{surface}"""
