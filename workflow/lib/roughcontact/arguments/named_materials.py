"""Materials by name: elastic constants, hardness, yield stress, conductivity, resistivity, temperatures."""

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from itertools import product
from typing import Any, NamedTuple

from roughcontact.arguments.materials import RIGID
from roughcontact.arguments.ranges import OF_BODIES, name_of_range, shares_of_range, weighted
from roughcontact.arguments.rows import rows_beside
from roughcontact.arguments.stacks import located_materials, materials_in
from roughcontact.arguments.units import celsius
from roughcontact.errors import SettingsError

_SI = {"GPa": 1e9, "MPa": 1e6, "W_m-1_K-1": 1.0, "nOhm_m": 1e-9}  # units of headings
_GENT, _SHORE_A, _DEGREES = "Gent", (20, 95), 5  # source of moduli of elastomers; limits, tolerance
_HARDNESS = ("hardness", name_of_range("hardness"))
_TEMPERATURE = "temperature_degC"
TRANSPORT = ("thermal_conductivity", "electrical_resistivity")  # of use only where both bodies state them


class Property(NamedTuple):
    """A property of a material (SI): its value, and the range of what is sold under the name."""

    value: float
    lowest: float
    highest: float


def material(name: str) -> dict[str, Any]:
    """Return the properties of a material at room temperature, as the settings take them for a body.

    Parameters
    ----------
    name : str
        or another name of the same material; capitals, spaces and hyphens do not matter. An elastomer may
        have its hardness behind it, ``"NBR 60 Shore A"``: its modulus is then that of Gent (1958).

    Returns
    -------
    dict
        `name`, `youngs_modulus` (Pa), `poissons_ratio` and, where the table `materials.tsv` states them,
        `hardness` (Pa), `yield_stress` (Pa), `thermal_conductivity` (W m-1 K-1), `electrical_resistivity`
        (Ohm m). The table also has their ranges and sources.

    Raises
    ------
    SettingsError
        for a name that is not in the table; it names the nearest ones.

    Examples
    --------
    >>> material("Structural steel")["youngs_modulus"]
    207000000000.0
    >>> "hardness" in material("NBR")
    False
    """
    properties = _properties(name)
    row, shore_a = _row_and_hardness(name)
    hardness = "" if shore_a is None else f" {shore_a:g} Shore A"
    return {"name": row["name"] + hardness} | {key: entry.value for key, entry in properties.items()}


def named_bodies(bodies: Sequence[Any]) -> list[Any]:
    """Return bodies with names of materials replaced by their properties; what a mapping states goes before.

    Conductivity and resistivity are taken from the table only where all bodies and layers have them; the
    hardness is that of the outermost layer with a name. What the table states has its range. A body may be
    called rigid.
    """
    rigid = {"name": "rigid", "youngs_modulus": RIGID, "poissons_ratio": 0.0}
    mappings = [{"material": body} if isinstance(body, str) else body for body in bodies]
    mappings = [rigid if body == {"material": "rigid"} else body for body in mappings]
    full: list[Any] = []
    pairs: list[tuple[Any, Any]] = []
    for body in mappings:
        layers = body.get("layers") if isinstance(body, Mapping) else None
        if not isinstance(layers, list) or not all(isinstance(layer, Mapping) for layer in layers or [None]):
            full.append(_named(body))
        else:  # the hardness of the table is that of the base
            full_layers = [_named(layer, exclude=_HARDNESS) for layer in layers]
            hardness = {key: value for key, value in _named(layers[0]).items() if key in _HARDNESS}
            full.append(hardness | _named(body, exclude=_HARDNESS) | {"layers": full_layers})
            pairs += zip(layers, full_layers, strict=True)
    pairs += zip(mappings, full, strict=True)
    for name in TRANSPORT:
        if not all(isinstance(body, Mapping) and body.get(name) is not None for _, body in pairs):
            for original, body in pairs:
                if isinstance(original, Mapping) and "material" in original and name not in original:
                    body.pop(name, None)
                    body.pop(name_of_range(name), None)
    return full


def _named(body: Any, *, exclude: Sequence[str] = ()) -> Any:
    """Return a body or a layer with the properties of its `material`, but for those that are omitted."""
    if not isinstance(body, Mapping) or not isinstance(body.get("material"), str):
        return body
    properties = material(body["material"])
    for key, entry in _properties(body["material"]).items():
        if key in OF_BODIES and key not in body:  # a value that is stated has the range that is stated
            properties[name_of_range(key)] = shares_of_range(*entry)
    properties = {key: value for key, value in properties.items() if key not in exclude}
    return properties | {key: value for key, value in body.items() if key != "material"}


def modulus_uncertainty(bodies: Sequence[Mapping[str, Any]]) -> float | None:
    """Return the relative uncertainty of E* by the ranges of Young's moduli, None without any.

    The half-ranges of both bodies, weighted by their shares in 1/E*, add in quadrature. A body with layers
    has the largest half-range and, whatever the wave, a compliance between those of its materials: the
    largest of the sums over these ends counts.
    """
    key, corners, half_ranges = name_of_range("youngs_modulus"), [], []
    for body in bodies:
        materials = materials_in(body)
        compliances = [(1 - entry["poissons_ratio"] ** 2) / entry["youngs_modulus"] for entry in materials]
        corners.append((0.0 if body.get("base") == "rigid" else min(compliances), max(compliances)))
        ranges = [entry[key] for entry in materials if entry.get(key)]
        half_ranges.append(max((sum(shares) / len(shares) for shares in ranges), default=0.0))
    if not any(half_ranges):
        return None
    sums = [weighted(compliances, half_ranges) for compliances in product(*corners) if any(compliances)]
    return round(max(1 - lower / total for total, lower, _ in sums), 3)


def temperature_limits(bodies: Sequence[Mapping[str, Any]] | None) -> dict[str, dict[str, float]]:
    """Return for each name of bodies and layers the `lowest` and `highest` temperature (°C) of the table.

    `stated` is that of a relaxation, in °C or in K. Materials without a range in the table are left out.

    Examples
    --------
    >>> temperature_limits([{"name": "NBR 60 Shore A"}, {"name": "mine"}])
    {'NBR 60 Shore A': {'lowest': -50.0, 'highest': 150.0}}
    """
    limits = {}
    for _, body in located_materials(bodies):
        name = str(body.get("name"))
        if text := _row_and_hardness(name)[0].get(_TEMPERATURE):
            limits[name] = dict(zip(("lowest", "highest"), map(float, text.split()), strict=True))
            relaxation = body.get("relaxation")
            if isinstance(relaxation, Mapping) and relaxation.get("temperature") is not None:
                limits[name]["stated"] = celsius(relaxation["temperature"])
    return limits


def material_names() -> list[str]:
    """Return the names of the table, without the further names of the same material."""
    return [row["name"] for row in _table()]


def compound(name: Any) -> dict[str, Any]:
    """Return the relaxation of a rubber by its name, empty where `compounds.tsv` has none of this name.

    Examples
    --------
    >>> compound("PIB")["reference_temperature"], compound("dma.csv")
    (25.0, {})
    """
    row = _names("compounds.tsv").get(_plain(name), {}) if isinstance(name, str) else {}
    cells = {key: text for key, text in row.items() if key not in ("name", "aliases", "source") and text}
    numbers = {key: [*map(float, text.split())] for key, text in cells.items()}
    name_of_row = {"name": row["name"]} if row else {}
    return name_of_row | {key: values if len(values) > 1 else values[0] for key, values in numbers.items()}


def compound_names() -> list[str]:
    """Return the names of the rubbers whose relaxation is in `compounds.tsv`."""
    return [row["name"] for row in _table("compounds.tsv")]


def modulus_of_hardness(shore_a: float) -> float:
    """Return Young's modulus (Pa) of an elastomer by its hardness in Shore A, from 20 to 95.

    Gent (1958), Rubber Chem. Technol. 31, 896: the force of the spring on the truncated cone of the gauge,
    over the indentation of an elastic half-space.

    Examples
    --------
    >>> f"{modulus_of_hardness(70) / 1e6:.2f}"
    '5.52'
    """
    return 1e6 * 0.0981 * (56 + 7.62336 * shore_a) / (0.137505 * (254 - 2.54 * shore_a))


def _properties(name: str) -> dict[str, Property]:
    """Return value and range (SI) of each property that the table states of a material.

    The modulus by a hardness in Shore A is that of `modulus_of_hardness`, with five degrees on either side.
    """
    row, shore_a = _row(name), _row_and_hardness(name)[1]
    properties = {}
    for heading, text in row.items():
        key, *unit = re.split(f"_({'|'.join(_SI)})$", heading)
        if text and key not in ("name", "aliases", "source", _TEMPERATURE):
            factor = _SI[unit[0]] if unit else 1.0
            # as decimal numbers are written: 1.4 GPa is 1400000000 Pa, not 1399999999.9999998
            numbers = (float(f"{float(cell) * factor:.6g}") for cell in text.split())
            properties[key] = Property(*numbers)
    if shore_a is not None:
        if _GENT not in row["source"]:
            raise SettingsError(f"{name!r}: {row['name']} is no elastomer with a hardness in Shore A")
        if not _SHORE_A[0] <= shore_a <= _SHORE_A[1]:
            raise SettingsError(f"{name!r}: Shore A is from {_SHORE_A[0]} to {_SHORE_A[1]}")
        moduli = (float(f"{modulus_of_hardness(shore_a + step):.3g}") for step in (0, -_DEGREES, _DEGREES))
        properties["youngs_modulus"] = Property(*moduli)
    return properties


def _row_and_hardness(name: str) -> tuple[dict[str, str], float | None]:
    """Return the row of a material, an empty one for an unknown name, and the Shore A behind the name."""
    rows = _names()
    match = re.fullmatch(r"(.*[^\W\d])[\s-]+(\d+)\s*(?:sh(?:ore)?\s*-?\s*A)?\s*", str(name), re.IGNORECASE)
    if match and _plain(name) not in rows and _plain(match[1]) in rows:
        return rows[_plain(match[1])], float(match[2])
    return rows.get(_plain(name), {}), None


def _row(name: str) -> dict[str, str]:
    """Return the row of the table that has a name, or an error with the nearest names."""
    if row := _row_and_hardness(name)[0]:
        return row
    rows = _names()
    close = [rows[alias]["name"] for alias in get_close_matches(_plain(name), rows, n=3, cutoff=0.6)]
    hint = f"did you mean {' or '.join(dict.fromkeys(close))}?"
    suggestion = hint if close else f"known are {', '.join(material_names())}"
    raise SettingsError(
        f"{name!r} is no material of the table, {suggestion}; or give youngs_modulus and poissons_ratio"
    )


def _names(file: str = "materials.tsv") -> dict[str, dict[str, str]]:
    """Return the rows of a table by all names of the materials, as `_plain` writes them."""
    rows = {_plain(alias): row for row in _table(file) for alias in (row["name"], *row["aliases"].split(","))}
    rows.pop("", None)  # of a material without another name
    return rows


def _plain(name: str) -> str:
    """Return a name in small letters, without spaces, hyphens and underscores."""
    return re.sub(r"[\s_-]", "", str(name).lower())


@cache
def _table(file: str = "materials.tsv") -> list[dict[str, str]]:
    """Return the rows of a table by the words of its heading."""
    heading, *rows = rows_beside(__file__, file)
    return [dict(zip(heading, row, strict=True)) for row in rows]
