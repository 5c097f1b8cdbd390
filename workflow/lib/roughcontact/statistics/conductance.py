"""Thermal and electrical conductance of a contact, from its stiffness."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from roughcontact.bodies import have_layers
from roughcontact.elasticity.layers import ConductingPair, conducting_pair
from roughcontact.errors import SettingsError

Bodies = Sequence[Mapping[str, Any]]
_TRANSPORTS = {"thermal": "thermal_conductance", "electrical": "electrical_conductance"}


def conductance_columns(
    stiffness: npt.ArrayLike, *, contact_modulus: float, bodies: Bodies | None = None, layered: bool = False
) -> dict[str, np.ndarray]:
    """Return the conductances of a contact of the `stiffness` K (Pa/m) by nominal area.

    A spot constricts heat and current as it does the displacement (Barber 2003, Proc. R. Soc. A 459, 53): per
    conductivity K/E* (1/m), of heat 2 k1 k2/(k1 + k2) times that (W/(m2 K)), of current 2 K/(E* (ρ1 + ρ2))
    (S/m2), without films, gas and radiation. NaN with layers, whose heat and current take another way than
    the displacement (`conductors`).
    """
    per_conductivity = np.asarray(stiffness, float) / contact_modulus
    if layered:
        return {"conductance_per_conductivity": np.full_like(per_conductivity, np.nan)}
    columns = {"conductance_per_conductivity": per_conductivity}
    if have_layers(bodies):
        return columns
    if (conductivities := _body_properties(bodies, "thermal_conductivity")) is not None:
        columns["thermal_conductance"] = 2 / (1 / conductivities).sum() * per_conductivity
    if (resistivities := _body_properties(bodies, "electrical_resistivity")) is not None:
        columns["electrical_conductance"] = 2 / resistivities.sum() * per_conductivity
    return columns


def gas_of(joint: Mapping[str, Any] | None) -> dict[str, float] | None:
    """Return the arguments of `gas_columns` for a joint, or raise SettingsError for half of one."""
    stated = {key: value for key, value in (joint or {}).items() if value is not None}
    if not stated:
        return None
    film = stated.keys() & {"film_thickness", "film_conductivity"}
    if len(film) == 1:
        raise SettingsError(
            "joint: a film needs film_thickness and film_conductivity; give both or neither", keys=["joint"]
        )
    if stated.keys() - film != {"gas_conductivity", "temperature_jump"}:
        raise SettingsError(
            f"joint has {', '.join(stated)}: give gas_conductivity and temperature_jump of the gas, and "
            "film_thickness and film_conductivity where there is a film",
            keys=["joint"],
        )
    return {"conductivity": stated["gas_conductivity"], "jump": stated["temperature_jump"]}


def gas_columns(gap: np.ndarray, *, conductivity: float, jump: float) -> dict[str, float]:
    """Return the thermal conductance of a gas in the gap (m; 0 in contact) by area: k <1/(g + M)>, W/(m2 K).

    M is the temperature jump at both walls (Yovanovich 1982; Song, Yovanovich, Goodman 1993, ASME J. Heat
    Transf. 115, 533); radiation is left out: below 10 W/(m2 K) at room temperature.
    """
    is_open = gap > 0
    return {"gas_conductance": conductivity * float(np.sum(1 / (gap[is_open] + jump))) / gap.size}


def resistances_and_joint(
    conductances: dict[str, np.ndarray],
    columns: Mapping[str, np.ndarray],
    joint: Mapping[str, float | None] | None,
) -> dict[str, np.ndarray]:
    """Return conductances by area with their resistances, and with a joint its own.

    Spots are in series with a film on their area, and gas beside them; `columns` has `gas_conductance`,
    `relative_contact_area`, and the conductances of bodies with layers.
    """
    layered = {name: columns[name] for name in _TRANSPORTS.values() if name in columns}
    results = layered | conductances
    with np.errstate(divide="ignore"):
        results |= {
            f"{transport}_resistance": 1 / results[name]
            for transport, name in _TRANSPORTS.items()
            if name in results
        }
        if joint and "thermal_resistance" in results:
            film = (joint.get("film_thickness") or 0.0) / (joint.get("film_conductivity") or 1.0)
            resistance = results["thermal_resistance"] + film / columns["relative_contact_area"]
            results["joint_conductance"] = 1 / resistance + columns["gas_conductance"]
    return results


def conductors(bodies: Bodies | None) -> dict[str, ConductingPair]:
    """Return bodies with layers as conductors, by the name of the conductance whose property all state.

    Examples
    --------
    >>> film = {"thickness": 1e-6, "thermal_conductivity": 1.0}
    >>> list(conductors([{"thermal_conductivity": 50.0, "layers": [film]}, {"thermal_conductivity": 50.0}]))
    ['thermal_conductance']
    """
    if not bodies or not have_layers(bodies):
        return {}
    properties = {"thermal": "thermal_conductivity", "electrical": "electrical_resistivity"}
    pairs = {transport: conducting_pair(bodies, name) for transport, name in properties.items()}
    return {_TRANSPORTS[transport]: pair for transport, pair in pairs.items() if pair is not None}


def over_holms_resistance(knudsen: npt.ArrayLike) -> np.ndarray:
    """Return the resistance of a round spot over Holm's ρ/(2a), by its Knudsen number λ/a.

    Electrons that cross it without a collision add that of Sharvin, 4 ρλ/(3π a²). Wexler (1966), Proc. Phys.
    Soc. 89, 927; Nikolić and Allen (1999), Phys. Rev. B 60, 3963.
    """
    ratio = np.asarray(knudsen, float)
    return (1 + 0.83 * ratio) / (1 + 1.33 * ratio) + 8 / (3 * np.pi) * ratio


def _body_properties(bodies: Bodies | None, name: str) -> np.ndarray | None:
    """Return a property of the two bodies, None unless both state it."""
    values = [value for body in bodies or () if (value := body.get(name)) is not None]
    return np.array(values) if len(values) == 2 else None
