"""Thermal and electrical conductance of a contact, from its stiffness."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from roughcontact.arguments.ranges import ends, name_of_range, weighted
from roughcontact.arguments.settings.needs import check_needs
from roughcontact.arguments.stacks import half_spaces, materials_in, top_material
from roughcontact.contact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.contact.elasticity.media import conduction
from roughcontact.errors import SettingsError

Bodies = Sequence[Mapping[str, Any]]
# what passes -> the property of bodies that decides, and the power of it that adds up in series
_TRANSPORTS = {"thermal": ("thermal_conductivity", -1), "electrical": ("electrical_resistivity", 1)}


def conductance_columns(
    stiffness: npt.ArrayLike, *, contact_modulus: float, bodies: Bodies | None = None
) -> dict[str, np.ndarray]:
    """Return the conductances of a contact of the `stiffness` K (Pa/m) by nominal area.

    A spot constricts heat and current as it does the displacement (Barber 2003, Proc. R. Soc. A 459, 53): per
    conductivity K/E* (1/m), of heat 2 k1 k2/(k1 + k2) times that (W/(m2 K)), of current 2 K/(E* (ρ1 + ρ2))
    (S/m2), without films, gas and radiation. With layers heat and current take another way than the
    displacement (`conductors`).
    """
    # Barber (2003): conductance over conductivity is stiffness over E*, for any rough contact of half-spaces
    per_conductivity = np.asarray(stiffness, float) / contact_modulus
    columns = {"conductance_per_conductivity": per_conductivity}
    for transport, (name, power) in _TRANSPORTS.items():
        # two half-spaces in series: the harmonic mean of conductivities, the mean of resistivities
        if (values := _body_properties(half_spaces(bodies), name)) is not None:
            columns[f"{transport}_conductance"] = 2 / (values**power).sum() * per_conductivity
    return columns


_OF_JOINT = {
    *("gas_conductivity", "temperature_jump", "film_thickness", "film_conductivity"),
    *("area", "heat_flow", "allowed_resistance", "allowed_temperature_drop"),
}


def conductivity_ranges(bodies: Bodies | None) -> dict[str, tuple[float, float, float]]:
    """Return mean thermal conductivity and electrical resistivity of bodies, each with the ends of its range.

    Those of current and heat through both half-spaces in series: 2/(1/k1 + 1/k2), (ρ1 + ρ2)/2. With layers
    they are of the surfaces, and the widest of the ranges, which no share of a layer exceeds, is that of all.
    Only properties with a range are in it.

    Examples
    --------
    >>> copper = {"electrical_resistivity": 1.7e-8, "electrical_resistivity_uncertainty": [0.1]}
    >>> [round(1e9 * rho, 2) for rho in conductivity_ranges([copper, copper])["electrical_resistivity"]]
    [17.0, 15.8, 18.2]
    """
    results: dict[str, tuple[float, float, float]] = {}
    materials = [material for body in bodies or () for material in materials_in(body)]
    for name, power in _TRANSPORTS.values():
        ranges = [material.get(name_of_range(name)) for material in materials]
        values = _body_properties([top_material(body) for body in bodies or ()], name)
        if values is None or not any(ranges):
            continue
        relative = [ends(1.0, shares) for shares in ranges]
        # layers: no closed form for the share of each, so that all ends are taken at once
        if len(half_spaces(bodies)) < len(bodies or ()):
            mean = float(np.mean(values**power)) ** power
            lowest, highest = zip(*relative, strict=True)
            results[name] = mean, mean * min(lowest), mean * max(highest)
            continue
        # the ends of 1/k are those of k, exchanged
        shares = [(1 - pair[::power][0] ** power, pair[::power][1] ** power - 1) for pair in relative]
        mean, *bounds = (total / 2 for total in weighted(list(values**power), shares))
        lower, upper = sorted(bound**power for bound in bounds)
        results[name] = mean**power, lower, upper
    return results


def gas_arguments(joint: Mapping[str, Any] | None) -> dict[str, float] | None:
    """Return the arguments of `gas_columns` for a joint, or raise SettingsError for half of one.

    None where neither gas nor film is stated; the gas of a joint with a film alone conducts nothing.
    """
    values = {key: value for key, value in (joint or {}).items() if value is not None}
    if unknown := values.keys() - _OF_JOINT:
        text = f"joint has {', '.join(sorted(unknown))}: takes {', '.join(sorted(_OF_JOINT))}"
        raise SettingsError(text, keys=["joint"])
    check_needs("joint", values)
    if not values.keys() & {"gas_conductivity", "film_thickness"}:
        return None
    return {"conductivity": values.get("gas_conductivity", 0.0), "jump": values.get("temperature_jump", 1.0)}


def gas_columns(gap: np.ndarray, *, conductivity: float, jump: float) -> dict[str, float]:
    """Return the thermal conductance of a gas in the gap (m; 0 in contact) by area: k <1/(g + M)>, W/(m2 K).

    M is the temperature jump at both walls (Yovanovich 1982; Song, Yovanovich, Goodman 1993, ASME J. Heat
    Transf. 115, 533); radiation is left out: below 10 W/(m2 K) at room temperature.
    """
    # gas and solid contact side by side; the jump is that of temperature at both walls
    is_open = gap > 0
    return {"gas_conductance": conductivity * float(np.sum(1 / (gap[is_open] + jump))) / gap.size}


def resistances_and_joint(
    columns: Mapping[str, np.ndarray], joint: Mapping[str, float | None] | None
) -> dict[str, np.ndarray]:
    """Return the resistances of the conductances by area among columns, and with a joint its own.

    Spots are in series with a film on their area, and gas beside them; `columns` has `gas_conductance` and
    `relative_contact_area`.
    """
    results: dict[str, np.ndarray] = {}
    with np.errstate(divide="ignore"):
        for transport in _TRANSPORTS:
            if f"{transport}_conductance" in columns:
                results[f"{transport}_resistance"] = 1 / columns[f"{transport}_conductance"]
        if joint and "thermal_resistance" in results and "gas_conductance" in columns:
            # in a film over the contact all heat passes through the area that touches
            film = (joint.get("film_thickness") or 0.0) / (joint.get("film_conductivity") or 1.0)
            resistance = results["thermal_resistance"] + film / columns["relative_contact_area"]
            results["joint_conductance"] = 1 / resistance + columns["gas_conductance"]
    return results


def conductors(bodies: Bodies | None, elasticity: Elasticity = HALF_SPACE) -> dict[str, Elasticity]:
    """Return bodies with layers as conductors, by the name of the conductance whose property all state.

    Examples
    --------
    >>> film = {"thickness": 1e-6, "thermal_conductivity": 1.0}
    >>> list(conductors([{"thermal_conductivity": 50.0, "layers": [film]}, {"thermal_conductivity": 50.0}]))
    ['thermal_conductance']
    """
    if bodies is None or len(half_spaces(bodies)) == len(bodies):
        return {}
    pairs = {transport: conduction(bodies, name, elasticity) for transport, (name, _) in _TRANSPORTS.items()}
    return {f"{transport}_conductance": pair for transport, pair in pairs.items() if pair is not None}


def knudsen_resistance_ratio(knudsen: npt.ArrayLike) -> np.ndarray:
    """Return the resistance of a round spot over Holm's ρ/(2a), by its Knudsen number λ/a.

    Electrons that cross it without a collision add that of Sharvin, 4 ρλ/(3π a²). Wexler (1966), Proc. Phys.
    Soc. 89, 927; Nikolić and Allen (1999), Phys. Rev. B 60, 3963.
    """
    ratio = np.asarray(knudsen, float)
    return (1 + 0.83 * ratio) / (1 + 1.33 * ratio) + 8 / (3 * np.pi) * ratio


def _body_properties(bodies: Bodies, name: str) -> np.ndarray | None:
    """Return a property of the two bodies, None unless both state it."""
    values = [value for body in bodies if (value := body.get(name)) is not None]
    return np.array(values) if len(values) == 2 else None
