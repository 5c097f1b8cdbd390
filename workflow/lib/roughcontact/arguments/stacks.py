"""What the bodies of a contact consist of: layers from the surface inwards, and what bears them."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any


def layers_in(body: Mapping[str, Any]) -> Sequence[Mapping[str, Any]]:
    """Return the layers of a body from the surface inwards: mostly none.

    Examples
    --------
    >>> len(layers_in({"youngs_modulus": 2e11})), len(layers_in({"layers": [{"thickness": 1e-3}]}))
    (0, 1)
    """
    return body.get("layers") or ()


def materials_in(body: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return the materials of a body from the surface inwards, without a rigid base.

    Examples
    --------
    >>> len(materials_in({"base": "rigid", "layers": [{"thickness": 1e-3}]}))
    1
    """
    return [*layers_in(body), *([] if body.get("base") == "rigid" else [body])]


def top_material(body: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the material at the surface of a body: that of its first layer, or its own.

    Examples
    --------
    >>> top_material({"base": "rigid", "layers": [{"thickness": 1e-3, "youngs_modulus": 2e6}]})["thickness"]
    0.001
    """
    return [*layers_in(body), body][0]


def located_materials(
    bodies: Sequence[Mapping[str, Any]] | None,
) -> Iterator[tuple[tuple[str | int, ...], Mapping[str, Any]]]:
    """Yield location and properties of each material of bodies, from the surface inwards, with rigid bases.

    Examples
    --------
    >>> [where for where, _ in located_materials([{"layers": [{"thickness": 1e-3}]}])]
    [('bodies', 0, 'layers', 0), ('bodies', 0)]
    """
    for index, body in enumerate(bodies or ()):
        for position, layer in enumerate(layers_in(body)):
            yield ("bodies", index, "layers", position), layer
        yield ("bodies", index), body


def properties_of_bodies(bodies: Sequence[Mapping[str, Any]] | None) -> tuple[str, ...]:
    """Return what one of the bodies has, if there are any, that may exclude settings: "layers", or nothing.

    Examples
    --------
    >>> properties_of_bodies(None), properties_of_bodies([{"layers": [{"thickness": 1e-6}]}, {}])
    ((), ('layers',))
    """
    return ("layers",) if any(map(layers_in, bodies or ())) else ()


def half_spaces(bodies: Sequence[Mapping[str, Any]] | None) -> list[Mapping[str, Any]]:
    """Return those of the bodies, if there are any, that have no layers.

    Examples
    --------
    >>> len(half_spaces([{"layers": [{"thickness": 1e-6}]}, {"youngs_modulus": 2e11}]))
    1
    """
    return [body for body in bodies or () if not layers_in(body)]


def bodies_for_solver(bodies: Sequence[Mapping[str, Any]] | None) -> dict[str, Any]:
    """Return the argument `bodies` of `solve_contact`, where E* does not say all of them: with layers.

    Examples
    --------
    >>> bodies_for_solver([{"youngs_modulus": 2e11, "poissons_ratio": 0.3}])
    {}
    """
    return {"bodies": bodies} if properties_of_bodies(bodies) else {}
