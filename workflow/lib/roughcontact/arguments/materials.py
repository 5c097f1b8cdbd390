"""Plausible ranges of moduli, loads and hardness of real materials, and detection of wrong units.

A `Doubt` suggests the value that was meant in another unit; the caller decides whether it is an error.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from roughcontact.arguments.quantities import number, quantity
from roughcontact.arguments.stacks import top_material

# Young's moduli: the softest gels and tissues (Levental, Georges and Janmey 2007, Soft Matter 3, 299) to
# diamond, 1.14e12 Pa (Klein and Cardinale 1993, Diamond Relat. Mater. 2, 918), with some room
SOFTEST, STIFFEST = 1e3, 1.5e12
RIGID = 1e15  # Young's modulus that stands for a rigid body, not for a material
GEL = 1e6  # softer solids are mostly water
GEL_POISSONS_RATIO = 0.45  # minimum for gels: like water, they are nearly incompressible
# Below, solids are rubber-like (or foams) and take strains of order one; above, strains of a few percent at
# most (Ashby 2011, Materials Selection in Mechanical Design, chart of modulus and strength)
RUBBER = 1e8
# hardness over modulus: metals yield at strains of 0.001 to 0.01 (Ashby 2011) and flow in an indent at three
# times their yield stress (Tabor 1951, The Hardness of Metals; Johnson 1985, Contact Mechanics, chapter 6;
# less in a deep one: Jackson and Green 2005, J. Tribol. 127, 343). E* of two like bodies is 0.55 E, which
# makes 0.005 to 0.05 E*: mild steel on steel bears 0.013, hardened 0.065. Below the surface yield begins
# sooner, at a largest pressure of 1.6 yield stresses: the largest shear is 0.31 of it (Johnson, section 3.4)
METALS = (0.01, 0.03)
MAX_HARDNESS = 0.1  # upper limit for all materials; diamond, glasses and glassy polymers come close
MIN_HARDNESS = 1e-4  # lower limit for all materials; pure indium and lead have about 0.001
# a mean pressure of 100 Pa is the weight of a centimetre of water, or of a sheet of metal
MIN_LOAD = 100.0
MIN_RELATIVE_LOAD = 1e-8  # mean pressure over contact modulus: 1 kPa on steel
# the same; above this value a load below `MIN_LOAD` is plausible: on real surfaces a thousandth of the area
# is in contact
SOFT_RELATIVE_LOAD = 1e-4
MAX_FRICTION = 5.0  # coefficient of friction: soft rubber on clean glass comes to 3 or 4
ROOM = 20.0  # °C, at which properties of the table hold
HOTTEST = 4e3  # K, where no solid is left: tungsten melts at 3.7e3 K, carbon sublimes at 3.9e3 K

_GIGA, _MEGA, _KILO = 1e9, 1e6, 1e3


class Doubt(NamedTuple):
    """Reason why a value is implausible, and the values that may have been intended."""

    reason: str
    candidates: tuple[float, ...]
    unit: str = "Pa"

    def question(self) -> str:
        """Return the doubt as the second half of a sentence."""
        likely = " or ".join(quantity(value, self.unit) for value in self.candidates[:2])
        return f"{self.reason}; did you mean {likely}?" if likely else f"{self.reason}."


def contact_modulus(bodies: Sequence[Mapping[str, Any]]) -> float:
    """Return E* (Pa) of two bodies, 1/E* = sum of (1 - nu^2)/E at the surface (Johnson 1985, eq. (4.4))."""
    surfaces = [top_material(body) for body in bodies]
    # two half-spaces in series; of a coated body the layer at its surface
    return 1 / sum((1 - surface["poissons_ratio"] ** 2) / surface["youngs_modulus"] for surface in surfaces)


def doubt_of_modulus(modulus: float) -> Doubt | None:
    """Return a doubt about an implausible contact modulus E* (Pa), or None.

    Examples
    --------
    >>> doubt_of_modulus(115.0).question()
    '115 Pa is softer than any gel (1.00 kPa); did you mean 115 GPa or 115 MPa?'
    >>> doubt_of_modulus(1.15e11) is None
    True
    """
    if modulus < SOFTEST:
        # as if GPa or MPa were taken for Pa
        reason = f"is softer than any gel ({quantity(SOFTEST, 'Pa')})"
        return doubt_about(modulus, reason, (_GIGA, _MEGA), SOFTEST, STIFFEST)
    if modulus > STIFFEST:
        return doubt_about(modulus, "is stiffer than diamond", (1 / _KILO, 1 / _MEGA), GEL, STIFFEST)
    return None


def doubt_of_gel(modulus: float, pressures: Sequence[float]) -> Doubt | None:
    """Return a doubt about an E* (Pa) as soft as a gel, which does not bear the pressures (Pa), or None.

    Examples
    --------
    >>> doubt_of_gel(1.15e5, [1e6]).question()
    '115 kPa is as soft as a gel, which does not bear 1.00 MPa; did you mean 115 GPa or 115 MPa?'
    >>> doubt_of_gel(1.15e5, [1e3]) is None
    True
    """
    highest = max(pressures, default=0.0)
    if not SOFTEST <= modulus < GEL or highest <= modulus:
        return None
    reason = f"is as soft as a gel, which does not bear {quantity(highest, 'Pa')}"
    return doubt_about(modulus, reason, (_MEGA, _KILO), max(GEL, highest / MAX_HARDNESS), STIFFEST)


def doubt_of_body(youngs_modulus: float, poissons_ratio: float) -> Doubt | None:
    """Return a doubt about an implausible Young's modulus (Pa) of a body, or None, as for a rigid one."""
    if youngs_modulus >= RIGID:
        return None  # it stands for no material
    if SOFTEST <= youngs_modulus < GEL and poissons_ratio < GEL_POISSONS_RATIO:
        reason = f"is as soft as a gel, which has a Poisson's ratio near 0.5, not {poissons_ratio:g}"
        return doubt_about(youngs_modulus, reason, (_GIGA, _MEGA), GEL, STIFFEST)
    return doubt_of_modulus(youngs_modulus)


def doubt_of_load(mean_pressure: float, contact_modulus: float) -> Doubt | None:
    """Return a doubt about a mean pressure (Pa) that is implausible at this E* (Pa), or None.

    Examples
    --------
    >>> doubt_of_load(1.0, 1.15e11).question()
    '1.00 Pa is next to no load on a contact modulus of 115 GPa; did you mean 1.00 MPa?'
    >>> doubt_of_load(2.0, 1e4) is None
    True

    Steel under 2 MPa, with both numbers in MPa.

    >>> doubt_of_load(2.0, 1.15e5).reason
    '2.00 Pa is next to no load on a contact modulus of 115 kPa (115 GPa, were it given in MPa)'
    """
    # a soft body bears little: the weight of a sheet is a load for it
    lightest = max(MIN_RELATIVE_LOAD * contact_modulus, min(MIN_LOAD, SOFT_RELATIVE_LOAD * contact_modulus))
    modulus_text = quantity(contact_modulus, "Pa")
    if mean_pressure > contact_modulus:
        reason = f"is more than any contact bears at a contact modulus of {modulus_text}"
        factors: Sequence[float] = (1 / _KILO, 1 / _MEGA)
    elif mean_pressure < lightest:
        reason = f"is next to no load on a contact modulus of {modulus_text}"
        if SOFTEST <= contact_modulus < GEL:
            reason += f" ({quantity(_MEGA * contact_modulus, 'Pa')}, were it given in MPa)"
        factors = (_MEGA, _KILO)
    else:
        return None
    return doubt_about(mean_pressure, reason, factors, lightest, MAX_HARDNESS * contact_modulus)


def doubt_of_hardness(hardness: float, modulus: float) -> Doubt | None:
    """Return a doubt about a hardness (Pa) implausible beside a modulus (Pa) of one of the bodies, or None.

    Examples
    --------
    >>> doubt_of_hardness(2.0, 1.15e11).question()
    '2.00 Pa is 1.7×10⁻¹¹ of the modulus, softer than lead; did you mean 2.00 GPa?'
    """
    lowest, highest = MIN_HARDNESS * modulus, MAX_HARDNESS * modulus
    if hardness < lowest:
        reason = f"is {number(hardness / modulus, digits=2)} of the modulus, softer than lead"
        return doubt_about(hardness, reason, (_GIGA, _MEGA), lowest, highest)
    # the modulus is no upper limit: it may be that of the other body
    if hardness > MAX_HARDNESS * STIFFEST:
        return doubt_about(hardness, "is harder than diamond", (1 / _KILO, 1 / _MEGA), lowest, highest)
    return None


def doubt_about(
    value: float, reason: str, factors: Sequence[float], lower: float, upper: float, unit: str = "Pa"
) -> Doubt:
    """Return a doubt about a value, with what it is in other units as far as that is within limits."""
    candidates = (value * factor for factor in factors)
    likely = tuple(candidate for candidate in candidates if lower <= candidate <= upper)
    return Doubt(f"{quantity(value, unit)} {reason}", likely, unit)
