"""Check the bodies of a contact: half-spaces, and layers on an elastic or a rigid base."""

from collections.abc import Mapping, Sequence
from typing import Any

from roughcontact.arguments.checking import check_positive
from roughcontact.arguments.named_materials import compound, named_bodies
from roughcontact.arguments.stacks import layers_in
from roughcontact.errors import SettingsError

_MATERIAL = ("youngs_modulus", "poissons_ratio")


def relaxing_body(bodies: Sequence[Mapping[str, Any]] | None) -> Mapping[str, Any]:
    """Return the body, if there is one, whose relaxation is stated, else an empty one.

    Examples
    --------
    >>> relaxing_body([{"name": "granite"}, {"name": "tread", "relaxation": "dma.csv"}])["name"]
    'tread'
    """
    return next((body for body in bodies or () if body.get("relaxation") is not None), {})


def relaxation_table(bodies: Sequence[Mapping[str, Any]] | None) -> str:
    """Return the path of the table that states the relaxation of a body; empty without one, and for a name.

    Examples
    --------
    >>> relaxation_table([{"relaxation": {"table": "dma.csv", "wlf": [8.86, 101.6]}}]), relaxation_table(None)
    ('dma.csv', '')
    """
    relaxation = relaxing_body(bodies).get("relaxation", "")
    table = relaxation.get("table", "") if isinstance(relaxation, Mapping) else relaxation
    return "" if compound(table) else table


def check_bodies(bodies: Sequence[str | Mapping[str, Any]], *, where: str = "bodies") -> list[dict[str, Any]]:
    """Return one or two bodies (named, or with Pa, m, layers from the surface inwards) as checked numbers.

    Examples
    --------
    >>> sheet = {"thickness": "2e-3", "youngs_modulus": 3e6, "poissons_ratio": 0.5}
    >>> (rubber,) = check_bodies([{"base": "rigid", "layers": [sheet]}])
    >>> rubber["layers"][0]["thickness"]
    0.002
    """
    if isinstance(bodies, Mapping | str) or not 1 <= len(bodies) <= 2:
        raise SettingsError(
            f"{where} = {bodies!r}: give a list of two bodies, or of one on a rigid counter-body",
            keys=[where],
        )
    # a second body that is not given is rigid; other properties are kept as they are
    return [_checked(body, f"{where}[{index}]") for index, body in enumerate(named_bodies(bodies))]


def _checked(body: Mapping[str, Any], where: str) -> dict[str, Any]:
    """Return one body whose numbers are checked."""
    base, layers = body.get("base"), layers_in(body)
    elastic_names = [name for name in _MATERIAL if body.get(name) is not None]
    key, mistake = f"{where}.base", ""
    if isinstance(layers, Mapping):
        key, mistake = f"{where}.layers", ": must be a list of layers, from the surface inwards"
    elif base not in (None, "rigid"):
        mistake = (
            f" = {base!r}: must be 'rigid'; an elastic base is the body itself, with youngs_modulus and "
            "poissons_ratio, and what lies above it is in layers"
        )
    elif base == "rigid" and not layers:
        mistake = " = 'rigid': needs layers; a body rigid as a whole has youngs_modulus 1e20 and no base"
    elif base == "rigid" and elastic_names:
        mistake = (
            f" = 'rigid' and {' and '.join(elastic_names)} given; give one of them: the elastic constants "
            "of a layer belong to it, in layers"
        )
    if mistake:
        raise SettingsError(f"{key}{mistake}", keys=[key])
    complete_body = {**body, **({} if base == "rigid" else _material(body, where))}
    complete_body["layers"] = []
    for number, layer in enumerate(layers):
        layer_key = f"{where}.layers[{number}]"
        thickness = check_positive(
            f"{layer_key}.thickness", _stated(layer, "thickness", layer_key, " (m)"), unit="m"
        )
        complete_body["layers"].append({**layer, "thickness": thickness, **_material(layer, layer_key)})
    return complete_body


def _material(values: Mapping[str, Any], where: str) -> dict[str, float]:
    """Return the elastic constants of a body or a layer."""
    remedy = "" if "layers[" in where else "; a rigid base of layers has base: rigid instead"
    modulus, ratio = (_stated(values, name, where, remedy) for name in _MATERIAL)
    modulus = check_positive(f"{where}.youngs_modulus", modulus, unit="Pa")
    return {
        "youngs_modulus": modulus,
        "poissons_ratio": check_poissons_ratio(f"{where}.poissons_ratio", ratio),
    }


def _stated(values: Mapping[str, Any], name: str, where: str, remedy: str) -> Any:
    """Return a value of a body or a layer, or raise a SettingsError with the remedy where it is missing."""
    if values.get(name) is None:
        raise SettingsError(f"{where}.{name}: missing{remedy}", keys=[f"{where}.{name}"])
    return values[name]


def check_poissons_ratio(name: str, value: Any) -> float:
    """Return a Poisson's ratio as a float, or raise a SettingsError that names it."""
    try:
        ratio = float(value)
    except (TypeError, ValueError):
        ratio = float("nan")
    if not -1 < ratio <= 0.5:
        raise SettingsError(
            f"{name} = {value!r}: must lie above -1 and be at most 0.5, that of an incompressible material",
            keys=[name],
        )
    return ratio
