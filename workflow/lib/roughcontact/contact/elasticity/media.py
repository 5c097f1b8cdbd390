"""The medium of two bodies: the first of `MEDIA` that they are, else half-spaces."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.layers import conducting_pair, layered_pair
from roughcontact.contact.elasticity.medium import HALF_SPACES, Medium

Bodies = Sequence[Mapping[str, Any]]

# bodies of the settings (Pa, m) -> their medium, None where they are none of this sort
MEDIA: Sequence[Callable[[Bodies], Medium | None]] = (layered_pair,)


def elastic_medium(bodies: Bodies | None) -> Medium:
    """Return the medium of bodies of the settings (Pa, m; layers from the surface inwards).

    Examples
    --------
    >>> elastic_medium([{"youngs_modulus": 2e11, "poissons_ratio": 0.3}]) is HALF_SPACES
    True
    """
    return next(filter(None, (medium(bodies or ()) for medium in MEDIA)), HALF_SPACES)


def conduction(bodies: Bodies, name: str, elasticity: Elasticity) -> Elasticity | None:
    """Return `elasticity` for bodies as conductors: a flux warms them as a pressure displaces elastic ones.

    None unless all their materials state the property, `thermal_conductivity` (W m-1 K-1) or
    `electrical_resistivity` (Ohm m).
    """
    pair = conducting_pair(bodies, name)
    return None if pair is None else replace(elasticity, modulus=pair.modulus, medium=pair)
