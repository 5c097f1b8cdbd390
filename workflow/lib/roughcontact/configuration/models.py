"""The settings: the keys of the configuration, their units and defaults.

A section is exactly the keyword arguments of its function (`level(height, **settings["level"])`), so that
each quantity has one name.
"""

import math
from types import NoneType
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator
from pydantic.json_schema import WithJsonSchema
from pydantic_core import PydanticCustomError

from roughcontact.choices import (
    HIGHEST_ORDER,
    SMALLEST_TOLERANCE,
    Boundary,
    Extra,
    Fill,
    HeadlineMeasurand,
    Influence,
    LevelForm,
    LineAlignment,
    LoadTarget,
    OnFailure,
    Placement,
    Precision,
    UncertaintySource,
    WindowMethod,
    ZeroFrequency,
)
from roughcontact.configuration.plausible import Range, bare_number
from roughcontact.materials import HARDEST, LEAST_LOAD, RIGID, SOFTEST, STIFFEST
from roughcontact.units import carries_unit


def _not_boolean(value: Any) -> Any:
    """Reject true and false for a number: Python takes them for 1 and 0."""
    if isinstance(value, bool):
        raise ValueError("must be a number")
    return value


def _relative_load(value: Any) -> Any:
    """Reject a pressure, with or without its unit, for a load relative to the modulus."""
    if carries_unit(value):
        raise ValueError("has no unit; a load with one is mean_pressure")
    if _MOST_RELATIVE < bare_number(value) < math.inf:
        raise ValueError(
            "is in units of E* x rms gradient, in which contact is full from about 1 on; did you mean "
            "mean_pressure?"
        )
    return value


def _as_list(value: Any) -> Any:
    """Return a single value as a list of one."""
    return value if isinstance(value, list | tuple | NoneType) else [value]


def _largest_load(value: Any) -> Any:
    """Return no load in particular for true, nothing for false, and a single load as a list of one."""
    single = value[0] if isinstance(value, list) and len(value) == 1 else value
    single = {"true": True, "false": False}.get(single, single) if isinstance(single, str) else single
    return ([] if single else None) if isinstance(single, bool) else _as_list(value)


Number = Annotated[float, BeforeValidator(_not_boolean)]
Count = Annotated[int, BeforeValidator(_not_boolean)]
Positive = Annotated[Number, Field(gt=0)]
RelativeUncertainty = Annotated[Number, Field(ge=0, lt=1)]
_MOST_RELATIVE = 100.0  # load in units of E* g; any surface is in full contact long before
_LISTED = Field(min_length=1, max_length=1000)  # each is solved
# quantities with a dimension: a bare number in SI units, in a plausible range, or a number with its unit
_POSITIVE = {"type": "number", "exclusiveMinimum": 0}
_WITH_UNIT = {"anyOf": [_POSITIVE, {"type": "string"}]}
_SCHEMA = WithJsonSchema(_WITH_UNIT)
Length = Annotated[
    Positive, BeforeValidator(Range("m", 1e-10, 0.1, above="longer than any map, layer or seal")), _SCHEMA
]
Height = Annotated[Positive, BeforeValidator(Range("m", 1e-12, 1e-3)), _SCHEMA]  # also of tips, and pixels
LightWavelength = Annotated[Positive, BeforeValidator(Range("m", 1e-8, 1e-4)), _SCHEMA]
Modulus = Annotated[
    Positive,
    BeforeValidator(
        Range("Pa", SOFTEST, STIFFEST, "softer than any gel", "stiffer than diamond", rigid=RIGID)
    ),
    _SCHEMA,
]
Strength = Annotated[
    Positive,
    BeforeValidator(Range("Pa", 1e5, HARDEST * STIFFEST, "softer than any foam", "harder than diamond")),
    _SCHEMA,
]
Pressure = Annotated[
    Positive,
    BeforeValidator(
        Range(
            "Pa",
            LEAST_LOAD,
            STIFFEST,
            "next to no load",
            "more than any contact bears",
            likely_factors=(1e6, 1e3),
        )
    ),
    _SCHEMA,
]
# aerogels to diamond; metals to conductive polymers; air to cold oil; liquids on polymers to clean metals
Conductivity = Annotated[Positive, BeforeValidator(Range("W m-1 K-1", 1e-3, 1e4)), _SCHEMA]
Resistivity = Annotated[Positive, BeforeValidator(Range("Ohm m", 1e-9, 0.1)), _SCHEMA]
Force = Annotated[Positive, BeforeValidator(Range("N", 1e-9, 1e8)), _SCHEMA]
Area = Annotated[Positive, BeforeValidator(Range("m2", 1e-14, 1e3)), _SCHEMA]
Viscosity = Annotated[Positive, BeforeValidator(Range("Pa s", 5e-6, 10)), _SCHEMA]
Speed = Annotated[Positive, BeforeValidator(Range("m s-1", 1e-9, 1e3)), _SCHEMA]
Diffusivity = Annotated[Positive, BeforeValidator(Range("m2 s-1", 1e-8, 1e-2)), _SCHEMA]
Work = Annotated[Positive, BeforeValidator(Range("J m-2", 1e-5, 10)), _SCHEMA]
Angle = Annotated[
    Number,
    BeforeValidator(Range("degree", -720, 720)),
    WithJsonSchema({"type": ["number", "string"]}),
]
Shares = Annotated[list[Annotated[Number, Field(gt=0, lt=1)]], _LISTED, BeforeValidator(_as_list)]
Gaps = Annotated[list[Height], _LISTED, BeforeValidator(_as_list)]
RelativeLoads = Annotated[
    list[Annotated[Positive, BeforeValidator(_relative_load)]],
    _LISTED,
    BeforeValidator(_as_list),
    WithJsonSchema({"anyOf": [_POSITIVE, {"type": "array", "minItems": 1, "items": _POSITIVE}]}),
]
_LIST_SCHEMA = WithJsonSchema(
    {"anyOf": [*_WITH_UNIT["anyOf"], {"type": "array", "minItems": 1, "items": _WITH_UNIT}]}
)
UnloadedFrom = Annotated[
    Annotated[list[Pressure], Field(max_length=1000)] | None,
    BeforeValidator(_largest_load),
    WithJsonSchema({"anyOf": [{"type": "boolean"}, *_LIST_SCHEMA.json_schema["anyOf"], {"type": "null"}]}),
]
Loads = Annotated[list[Pressure], _LISTED, BeforeValidator(_as_list), _LIST_SCHEMA]
Radii = Annotated[
    list[Annotated[Positive, BeforeValidator(Range("m", 1e-9, 1e3)), _SCHEMA]],
    Field(min_length=1, max_length=2),
    BeforeValidator(_as_list),
    _LIST_SCHEMA,
]
Forces = Annotated[list[Force], _LISTED, BeforeValidator(_as_list), _LIST_SCHEMA]


def _optional(description: str, *, example: Any) -> Any:
    """Return the field of a setting that is absent by default."""
    return Field(default=None, description=description, examples=[example])


class Section(BaseModel):
    """A group of settings; unknown keys, infinities and NaN are mistakes."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Level(Section):
    """Levelling: remove outliers, align scan lines, remove form and waviness, fill in missing points."""

    form: LevelForm = Field(default="plane", description="form that is fitted to the map and subtracted")
    order: Count = Field(
        default=2,
        ge=1,
        le=HIGHEST_ORDER,
        description="total order of the polynomial, x^i y^j with i + j <= order",
    )
    robust: bool = Field(
        default=False,
        description="fit without weight on deep valleys and high spikes (otherwise least squares)",
    )
    outlier_threshold: Positive | None = Field(
        default=6.0,
        description="isolated spikes that deviate from their surroundings by more than this many local "
        "standard deviations are treated as missing; null keeps every point",
    )
    line_alignment: LineAlignment = Field(
        default="auto",
        description="how rows (scan lines) are shifted to match one another; jitter: by their random jumps "
        "from row to row; auto: as jitter where the rows clearly jump, otherwise not; median: the median of "
        "each row to the same height; matched-steps: the median step from row to row to zero",
    )
    scar_threshold: Positive | None = _optional(
        "for scanned maps: pieces of one to four rows that deviate from the rows before and "
        "after by more than this many standard deviations are treated as missing (4 is a good start); narrow "
        "grooves along x look the same; null keeps every point",
        example=4.0,
    )
    s_filter: Length | None = _optional(
        "nesting index of the S-filter (areal Gaussian, ISO 16610-61), m: shorter waves are "
        "removed; null keeps them",
        example="2.5 um",
    )
    l_filter: Length | None = _optional(
        "nesting index of the L-filter (areal Gaussian, ISO 16610-61), m: longer waves are "
        "removed; null keeps them",
        example="0.8 mm",
    )
    fill: Fill = Field(
        default="harmonic",
        description="how missing points are filled in; those at the border are cropped instead",
    )
    max_missing: Number = Field(
        default=0.4, ge=0, le=1, description="largest share of missing points; a map with more is rejected"
    )


class Composite(Section):
    """Relative positions of two measured faces that touch (column counter_face of the table)."""

    shifts: Count = Field(
        default=5, ge=1, le=100, description="random shifts for each rotation; each is solved"
    )
    rotations: list[Angle] = Field(
        default_factory=lambda: [0.0],
        min_length=1,
        max_length=360,
        description="angles by which the counter-face is rotated on the face, degrees, from x towards y",
    )
    overlap: Number = Field(
        default=0.75,
        gt=0,
        le=1,
        description="minimum share of each side of the smaller map that the other one covers",
    )
    seed: Count = Field(default=0, ge=0, lt=2**32, description="of the random shifts")


class Form(Section):
    """The nominal form of a body of finite size, of which the map is the roughness (boundary: free)."""

    radius: Radii | None = _optional(
        "of the body, m; two of an ellipsoid, along x and y; null: the map itself is the body", example="5 mm"
    )
    edges: bool = Field(
        default=False,
        description="whether the body ends where the map does, with sharp edges: a flat punch, a chip, a pin",
    )
    local_scale: bool = Field(
        default=False,
        description="for a map smaller than the contact (boundary: periodic): each place under the nominal "
        "pressure of the smooth body (Hertz), given its radius and force; roughness small against the form",
    )


class Window(Section):
    """The periodic window for the solver."""

    placement: Placement = Field(
        default="largest",
        description="part of the map that is solved; largest: the largest rectangle without missing points; "
        "whole-periods: shortened to a whole number of periods of a texture that repeats",
    )
    method: WindowMethod = Field(
        default="smooth-cross-fade",
        description="how that part is made periodic; docs/explanation/surface.md compares them",
    )
    width: Number = Field(
        default=0.1,
        gt=0,
        le=0.5,
        description="share of the side over which the two cross-fades blend or taper falls; other methods "
        "ignore it",
    )
    min_share: Number = Field(
        default=0.05,
        ge=0,
        le=1,
        description="minimum share of the map that the window must cover; smaller ones are rejected",
    )
    shortest_wavelength: Length | None = _optional(
        "shorter waves are removed from the window, m; null keeps them; the cutoff is sharp, so "
        "that steps and particles ring: level.s_filter is smooth",
        example="2 um",
    )
    longest_wavelength: Length | None = _optional(
        "longer waves are removed from the window, m; null keeps them", example="100 um"
    )
    reliable_band: bool = Field(
        default=False,
        description="remove waves that are shorter than the instrument resolves (two pixels, or the "
        "limit of the lens if the file states its numerical aperture)",
    )


def _without_required(schema: dict[str, Any]) -> None:
    """Require no elastic constants in the schema: a rigid base has none, a named material brings them."""
    schema["required"] = [key for key in schema["required"] if key == "thickness"]
    schema["properties"]["material"] = {"type": "string", "description": "name of a material of the table"}


def _or_names(schema: dict[str, Any]) -> None:
    """Admit names of materials for bodies in the schema: `resolve` replaces them."""
    (bodies,) = (schema_of_type for schema_of_type in schema["anyOf"] if schema_of_type["type"] == "array")
    bodies["items"] = {"anyOf": [bodies["items"], {"type": "string"}]}


class Layer(Section):
    """A bonded layer of a body: a coating, a sheet."""

    model_config = ConfigDict(json_schema_extra=_without_required)

    name: str | None = Field(default=None, max_length=64, description="for the report", examples=["DLC"])
    thickness: Length = Field(description="of the layer, m", examples=["2 um"])
    youngs_modulus: Modulus = Field(description="Young's modulus of the layer, Pa", examples=["180 GPa"])
    poissons_ratio: Number = Field(
        gt=-1, le=0.5, description="Poisson's ratio of the layer, no unit", examples=[0.2]
    )
    yield_stress: Strength | None = _optional(
        "of the layer in tension, Pa: as that of a body, which with layers is that of its base",
        example="4 GPa",
    )
    thermal_conductivity: Conductivity | None = _optional("of the layer, W m-1 K-1", example=2.0)
    electrical_resistivity: Resistivity | None = _optional("of the layer, Ohm m", example=1.0e-3)


class Body(Section):
    """One of the two bodies."""

    model_config = ConfigDict(json_schema_extra=_without_required)

    name: str | None = Field(
        default=None, max_length=64, description="of the material, for the report", examples=["steel"]
    )
    youngs_modulus: Modulus | None = Field(description="Young's modulus E, Pa", examples=["210 GPa"])
    poissons_ratio: Annotated[Number, Field(gt=-1, le=0.5)] | None = Field(
        description="Poisson's ratio, no unit", examples=[0.3]
    )
    base: Literal["rigid"] | None = Field(
        default=None,
        description="rigid: the layers lie on a base that does not give way, and the body has no elastic "
        "constants of its own",
    )
    layers: list[Layer] | None = Field(
        default=None,
        max_length=50,
        description="bonded layers from the surface inwards, each with thickness (m), youngs_modulus (Pa), "
        "poissons_ratio and, if known, yield_stress (Pa)",
        examples=[[{"thickness": "2 um", "youngs_modulus": "180 GPa", "poissons_ratio": 0.2}]],
    )
    hardness: Strength | None = _optional(
        "largest pressure that its surface carries before it yields (indentation hardness), Pa",
        example="2 GPa",
    )
    yield_stress: Strength | None = _optional(
        "in tension, Pa: the results then include the stresses below the surface and the load at "
        "which it yields there",
        example="400 MPa",
    )
    thermal_conductivity: Conductivity | None = _optional(
        "W m-1 K-1, of both bodies: the results then include the thermal contact conductance", example=50.0
    )
    electrical_resistivity: Resistivity | None = _optional(
        "Ohm m, of both bodies: the results then include the electrical contact conductance", example=2.0e-7
    )

    @model_validator(mode="before")
    @classmethod
    def _rigid(cls, values: Any) -> Any:
        """Let a rigid base do without elastic constants."""
        if isinstance(values, dict) and values.get("base") is not None:
            return {"youngs_modulus": None, "poissons_ratio": None} | values
        return values


class Contact(Section):
    """The contact problem: contact_modulus or bodies, mean_pressure or relative_pressure or neither."""

    contact_modulus: Modulus | None = _optional(
        "plane-strain contact modulus E*, Pa, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; 115 GPa "
        "for steel on steel",
        example="115 GPa",
    )
    bodies: list[Body] | None = Field(
        default=None,
        min_length=2,
        max_length=2,
        description="the two bodies, instead of contact_modulus: names of materials ([steel, PEEK]), or "
        "Young's moduli (Pa), Poisson's ratios and optional properties, to which material: steel adds those "
        "of a name",
        json_schema_extra=_or_names,
        examples=[
            [
                {
                    "name": "steel",
                    "youngs_modulus": "210 GPa",
                    "poissons_ratio": 0.3,
                    "hardness": "2 GPa",
                    "thermal_conductivity": 50.0,
                },
                {
                    "name": "PEEK",
                    "youngs_modulus": "4 GPa",
                    "poissons_ratio": 0.4,
                    "hardness": "0.3 GPa",
                    "thermal_conductivity": 0.3,
                },
            ]
        ],
    )
    mean_pressure: Loads | None = _optional(
        "nominal pressure, Pa, one number or a list; if no load is given, log-spaced loads are planned",
        example=["1 MPa", "2 MPa", "5 MPa", "10 MPa", "20 MPa", "50 MPa"],
    )
    relative_pressure: RelativeLoads | None = _optional(
        "nominal pressure / (E* x rms gradient of the window), no unit, one number or a list",
        example=[0.01, 0.05, 0.2],
    )
    boundary: Boundary = Field(
        default="periodic",
        description="periodic: the map repeats; free: a body of finite size (section form) under a force",
    )
    force: Forces | None = _optional(
        "N, one number or a list: on a body of finite size; with area, or form.local_scale, "
        "instead of mean_pressure",
        example="50 N",
    )
    area: Area | None = _optional("nominal area that carries the force, m2", example="3 cm2")
    target_area: Shares | None = _optional(
        "relative contact area whose load is found and solved, in addition to the given loads; "
        "one number or a list",
        example=[0.1],
    )
    target_gap: Gaps | None = _optional(
        "mean gap, m, whose load is found and solved, in addition to the given loads; one number or a list",
        example=["0.2 µm"],
    )
    target: (
        Annotated[
            list[LoadTarget],
            Field(min_length=1, max_length=len(get_args(LoadTarget))),
            BeforeValidator(_as_list),
        ]
        | None
    ) = _optional(
        "further states whose load is found and solved: percolation, at which the gap closes "
        "along x and along y; first_yield, at which a body begins to yield (its yield_stress below the "
        "surface, otherwise the hardness)",
        example=["percolation"],
    )
    contact_modulus_uncertainty: RelativeUncertainty | None = _optional(
        "of the contact modulus, relative, expanded (95 %), no unit; it is part of the ±", example=0.05
    )
    mean_pressure_uncertainty: RelativeUncertainty | None = _optional(
        "of the loads, relative, expanded (95 %), no unit; it is part of the ±", example=0.02
    )
    tolerance: Number = Field(
        default=1e-4,
        ge=SMALLEST_TOLERANCE,
        lt=1,
        description="largest accepted error_bound (relative, energy norm), no unit",
    )
    zero_frequency: ZeroFrequency = Field(
        default="zero",
        description="mean displacement in the approach: zero, nogi-kato (its mean over the q = 0 cell), "
        "lattice (one contact per window in free space); pressure and area do not depend on it",
    )
    hardness: Strength | None = _optional(
        "largest pressure that the softer body carries before it yields (indentation hardness), "
        "Pa: the upper limit of the pressure; not given here if bodies state theirs; without "
        "any: elastic throughout",
        example="2 GPa",
    )
    unload: UnloadedFrom = _optional(
        "take a load off after it was reached, and write the surface that flow has left and the "
        "contact on the way back to residual.nc; true: the largest load; or loads, Pa; needs a hardness",
        example=True,
    )
    influence: Influence = Field(
        default="sampled",
        description="elastic influence function: sampled (exact for each wave of the grid) or elements "
        "(pressure constant on every pixel)",
    )
    precision: Precision = Field(
        default="double", description="of the result: double, or single for maps that fill the memory"
    )
    keep_fields: bool = Field(
        default=True, description="keep the maps of pressure, gap and contact of every load in contact.nc"
    )
    on_failure: OnFailure = Field(
        default="raise",
        description="consequence for a load that misses the tolerance: raise (the surface fails) or flag "
        "(the load is kept with converged = 0)",
    )


class Seal(Section):
    """A seal of which the surface is part, and the sealed fluid."""

    viscosity: Viscosity = Field(description="of the fluid, dynamic, Pa s", examples=["1 mPa s"])
    pressure_difference: Pressure = Field(
        description="of the fluid between both sides of the seal, Pa", examples=["1 bar"]
    )
    width: Length = Field(description="of the seal in the direction of the flow, m", examples=["2 mm"])


class Joint(Section):
    """What conducts heat beside the metal: the gas in the gap, and a film on the spots in contact."""

    gas_conductivity: Conductivity = Field(description="of the gas, W m-1 K-1", examples=[0.026])
    temperature_jump: Length = Field(
        description="sum of the temperature jump distances of gas and both faces, m; for air at 1 bar and "
        "metals about 0.37 um",
        examples=["0.37 um"],
    )
    film_thickness: Length | None = _optional("of an oxide or a coating on the spots, m", example="5 nm")
    film_conductivity: Conductivity | None = _optional("of that film, W m-1 K-1", example=2.0)


class Friction(Section):
    """A tangential load, or sliding; see docs/how-to/friction.md."""

    coefficient: Positive | None = _optional("coefficient of friction mu, no unit", example=0.2)
    tangential_load: (
        Annotated[
            list[Annotated[Number, Field(gt=0, le=1)]],
            Field(min_length=1, max_length=100),
            BeforeValidator(_as_list),
        ]
        | None
    ) = _optional(
        "Q/(mu P), below the load of sliding; 1 is full slip; needs the coefficient", example=[0.3, 0.6]
    )
    shear_strength: Strength | None = _optional(
        "of the contact, Pa: the coefficient of friction follows from the area", example="50 MPa"
    )
    speed: Speed | None = _optional(
        "of sliding along x, m/s: flash temperatures are added; needs thermal_conductivity of both bodies",
        example="1 m/s",
    )
    thermal_diffusivity: Diffusivity | None = _optional(
        "of the second body, which slides, m2/s; null: the temperature of slow sliding, an upper limit",
        example="14 mm2/s",
    )


class Statistics(Section):
    """Statistics of the contact, and quantities derived from it; see docs/explanation/answers.md."""

    pressure_bins: Count = Field(
        default=20, ge=1, le=1000, description="bins of the pressure density, per factor of ten"
    )
    gap_bins: Count = Field(
        default=20, ge=1, le=1000, description="bins of the gap density, per factor of ten"
    )
    flow: Extra = Field(
        default="auto",
        description="whether the flow of a fluid through the gap is solved; auto: for maps of up to 65536 "
        "points, and if a seal is given; larger ones take longer than the contact itself",
    )
    stress: Extra = Field(
        default="auto",
        description="whether the stresses below the surface are computed (needs bodies); auto: if one of "
        "them states its yield_stress",
    )
    work_of_adhesion: Work | None = _optional(
        "of flat surfaces, J m-2: the results then include whether it suffices to press the roughness flat",
        example="50 mJ/m2",
    )
    seal: Seal | None = _optional(
        "a seal, whose leak rate the results then include: viscosity (Pa s) and pressure "
        "difference (Pa) of the fluid, width (m) of the seal",
        example={"viscosity": "1 mPa s", "pressure_difference": "1 bar", "width": "2 mm"},
    )
    joint: Joint | None = _optional(
        "a joint, whose heat conductance the results then include: gas in the gap beside the "
        "spots, a film on them; both bodies state their thermal_conductivity",
        example={"gas_conductivity": 0.026, "temperature_jump": "0.37 um"},
    )
    friction: Friction | None = _optional(
        "stick and slip under a tangential load, friction from the area, flash temperatures",
        example={"coefficient": 0.2, "tangential_load": [0.3, 0.6]},
    )


class Uncertainty(Section):
    """The error budget: the sources of the ± of a headline number; see docs/explanation/uncertainty.md."""

    sources: list[UncertaintySource] = Field(
        default_factory=lambda: list(get_args(UncertaintySource)),
        max_length=len(get_args(UncertaintySource)),
        description="list of the sources of the ±; the empty list [] omits the error budget",
    )
    windows: Count = Field(
        default=9,
        ge=4,
        le=400,
        description="number of subwindows that are solved separately, for the source window",
    )
    measurand: HeadlineMeasurand = Field(
        default="surface",
        description="what the ± is for: the surface, in the band of waves of the map, or a longer one",
    )
    extent: Annotated[Number, Field(ge=1)] = Field(
        default=3.0,
        description="length of the surface of the longer interval, over that of the map",
    )

    @field_validator("sources", mode="before")
    @classmethod
    def _without_processing(cls, sources: Any) -> Any:
        """Name the way out for a source that older files list."""
        if isinstance(sources, list) and "processing" in sources:
            raise PydanticCustomError(
                "no_processing",
                "processing is a source no more: the calibration of window includes it; leave it out",
            )
        return sources


class Instrument(Section):
    """What is known of the instrument, for the ±; columns of the table of surfaces prevail."""

    noise: Height | None = _optional("measurement noise N_M, rms, m", example="2 nm")
    resolution: Height | None = _optional(
        "topographic spatial resolution W_R, m: the wavelength of which half is transmitted", example="1.5 um"
    )
    numerical_aperture: Annotated[Number, Field(gt=0, le=1.6)] | None = _optional(
        "of the lens, no unit", example=0.55
    )
    wavelength: LightWavelength | None = _optional("of the light, m; null: 550 nm", example="520 nm")
    tip_radius: Height | None = _optional("of a stylus or a probe, m", example="2 um")
    amplification_z: RelativeUncertainty | None = _optional(
        "uncertainty of the height scale, relative, expanded (95 %), no unit", example=0.01
    )
    amplification_xy: RelativeUncertainty | None = _optional(
        "uncertainty of the lateral scale, relative, expanded (95 %), no unit", example=0.005
    )
    finer_spectrum: str | None = Field(
        default=None,
        min_length=1,
        description="path of a finer map or profile of the same finish, whose spectrum continues that of "
        "the map",
        examples=["measured/afm-patch.nid"],
    )
    correct: bool = Field(
        default=False,
        description="whether the map is corrected for noise, and resolution or lens, as far as they are "
        "known: the results are then those of the corrected map, and say so; else only the ± includes them",
    )


class Report(Section):
    """The page with the results."""

    title: str = Field(default="Contact of rough surfaces", description="title of the page")


class Settings(Section):
    """Settings of roughcontact."""

    surfaces: str = Field(
        default="config/surfaces.tsv",
        min_length=1,
        description="path of the table of surfaces, tab-separated, one row each; see config/README.md",
    )
    level: Level = Field(default_factory=Level)
    composite: Composite = Field(default_factory=Composite)
    window: Window = Field(default_factory=Window)
    form: Form = Field(default_factory=Form)
    contact: Contact = Field(default_factory=Contact)
    statistics: Statistics = Field(default_factory=Statistics)
    uncertainty: Uncertainty = Field(default_factory=Uncertainty)
    instrument: Instrument = Field(default_factory=Instrument)
    report: Report = Field(default_factory=Report)
    cases: dict[str, dict[str, Any]] = Field(
        default_factory=dict,
        description="a study: name of a case -> settings that differ from those above; every surface runs "
        "under every case, results go to results/{case}/{surface}",
        examples=[{"soft": {"contact": {"contact_modulus": "1 GPa"}}}],
    )
