"""Materials by name: elastic constants, hardness, yield stress, conductivity, resistivity, with ranges."""

import math
import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from importlib import resources
from typing import Any, NamedTuple

from roughcontact.errors import SettingsError

_SI = {"GPa": 1e9, "MPa": 1e6, "nOhm_m": 1e-9}
_TRANSPORT = ("thermal_conductivity", "electrical_resistivity")  # of use only where both bodies state them


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
        or another name of the same material; capitals, spaces and hyphens do not matter.

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
    return {"name": _row(name)["name"]} | {key: entry.value for key, entry in properties.items()}


def named_bodies(bodies: Sequence[Any]) -> list[Any]:
    """Return bodies with names of materials replaced by their properties; what a mapping states goes before.

    Conductivity and resistivity are taken from the table only where all bodies and layers have them; the
    hardness is that of the outermost layer with a name.
    """
    stated = [{"material": body} if isinstance(body, str) else body for body in bodies]
    full: list[Any] = []
    pairs: list[tuple[Any, Any]] = []
    for body in stated:
        layers = body.get("layers") if isinstance(body, Mapping) else None
        if not isinstance(layers, list) or not all(isinstance(layer, Mapping) for layer in layers or [None]):
            full.append(_named(body))
        else:  # the hardness of the table is that of the base
            named = [_named(layer, omitted=("hardness",)) for layer in layers]
            hardness = {key: value for key, value in _named(layers[0]).items() if key == "hardness"}
            full.append(hardness | _named(body, omitted=("hardness",)) | {"layers": named})
            pairs += zip(layers, named, strict=True)
    pairs += zip(stated, full, strict=True)
    for name in _TRANSPORT:
        if not all(isinstance(body, Mapping) and body.get(name) is not None for _, body in pairs):
            for original, body in pairs:
                if isinstance(original, Mapping) and "material" in original and name not in original:
                    body.pop(name, None)
    return full


def _named(body: Any, *, omitted: Sequence[str] = ()) -> Any:
    """Return a body or a layer with the properties of its `material`, but for those that are omitted."""
    if not isinstance(body, Mapping) or not isinstance(body.get("material"), str):
        return body
    properties = {key: value for key, value in material(body["material"]).items() if key not in omitted}
    return properties | {key: value for key, value in body.items() if key != "material"}


def modulus_uncertainty(
    stated: Sequence[str | Mapping[str, Any]], bodies: Sequence[Mapping[str, Any]]
) -> float | None:
    """Return the relative uncertainty of E* by the ranges of the named materials, None without a named one.

    The half-ranges of Young's moduli of the surfaces, weighted by their shares in 1/E*, add in quadrature.
    """
    total, uncertain = 0.0, []
    for name, body in zip(stated, bodies, strict=True):
        surface = (body.get("layers") or [body])[0]
        compliance = (1 - surface["poissons_ratio"] ** 2) / surface["youngs_modulus"]
        total += compliance
        source = {"material": name} if isinstance(name, str) else (name.get("layers") or [name])[0]
        if "youngs_modulus" not in source and source.get("material"):
            value, lowest, highest = _properties(source["material"])["youngs_modulus"]
            uncertain.append(compliance * (highest - lowest) / (2 * value))
    return round(math.hypot(*uncertain) / total, 3) if uncertain else None


def material_names() -> list[str]:
    """Return the names of the table, without the further names of the same material."""
    return [row["name"] for row in _table()]


def _properties(name: str) -> dict[str, Property]:
    """Return value and range (SI) of each property that the table states of a material."""
    properties = {}
    for heading, text in _row(name).items():
        unit = next((unit for unit in _SI if heading.endswith(unit)), "")
        key = re.sub("_(GPa|MPa|W_m-1_K-1|nOhm_m)$", "", heading)
        if text and key not in ("name", "aliases", "source"):
            # as decimal numbers are written: 1.4 GPa is 1400000000 Pa, not 1399999999.9999998
            value, lowest, highest = (
                float(f"{float(number_text) * _SI.get(unit, 1.0):.6g}") for number_text in text.split()
            )
            properties[key] = Property(value, lowest, highest)
    return properties


def _row(name: str) -> dict[str, str]:
    """Return the row of the table that has a name, or an error with the nearest names."""
    rows = {_plain(alias): row for row in _table() for alias in (row["name"], *row["aliases"].split(","))}
    rows.pop("", None)  # of a material without another name
    if (row := rows.get(_plain(name))) is not None:
        return row
    close = [rows[alias]["name"] for alias in get_close_matches(_plain(name), rows, n=3, cutoff=0.6)]
    suggestion = (
        f"did you mean {' or '.join(dict.fromkeys(close))}?"
        if close
        else "known are " + ", ".join(material_names())
    )
    raise SettingsError(
        f"{name!r} is no material of the table, {suggestion}; or give youngs_modulus and poissons_ratio"
    )


def _plain(name: str) -> str:
    """Return a name in small letters, without spaces, hyphens and underscores."""
    return re.sub(r"[\s_-]", "", str(name).lower())


@cache
def _table() -> list[dict[str, str]]:
    """Return the rows of `materials.tsv` by the words of its heading."""
    text = resources.files("roughcontact").joinpath("materials.tsv").read_text(encoding="utf-8")
    heading, *lines = (line.split("\t") for line in text.splitlines() if not line.startswith("#"))
    return [dict(zip(heading, line, strict=True)) for line in lines]
