"""Friction of a solved contact: stick under a tangential load, friction from the area, flash temperature."""

from collections.abc import Mapping, Sequence
from typing import Any

import xarray as xr

from roughcontact.arguments.ranges import Shares, ends
from roughcontact.arguments.stacks import half_spaces
from roughcontact.contact.flash_temperature import flash_temperature
from roughcontact.contact.partial_slip import APPROXIMATION, partial_slip
from roughcontact.errors import SettingsError


def friction_statistics(
    contact: xr.Dataset,
    relative_area: float,
    bodies: Sequence[Mapping[str, Any]] | None = None,
    *,
    coefficient: float | None = None,
    tangential_load: Sequence[float] | None = None,
    shear_strength: float | None = None,
    shear_strength_uncertainty: Shares | None = None,
    speed: float | None = None,
    thermal_diffusivity: float | None = None,
) -> xr.Dataset:
    """Return the friction of one load: stick and slip, coefficient from the area, flash temperatures (K).

    μ = τ A/p̄ of the `shear_strength` τ (Pa, with its range; Bowden and Tabor 1950); the heat μ v p at
    `speed` (m/s), with the stated `coefficient` or this one, goes into both bodies, the second of which moves
    along x (`flash_temperature`).
    """
    columns, load = xr.Dataset(), float(contact["mean_pressure"].item())
    if shear_strength is not None:
        # a junction shears at its strength, whatever the pressure
        columns["friction_coefficient"] = "load", [shear_strength * relative_area / load]
        if shear_strength_uncertainty is not None:
            bounds = ends(shear_strength, shear_strength_uncertainty)
            columns["shear_strength"] = shear_strength
            columns["shear_strength_lower"], columns["shear_strength_upper"] = bounds
    if tangential_load is not None:
        assert coefficient is not None  # `check_needs`
        slip = partial_slip(
            contact,
            friction_coefficient=coefficient,
            tangential_load=tangential_load,
            poissons_ratio=_equivalent_ratio(bodies),
        )
        columns = columns.merge(_drop_maps(slip).expand_dims("load"))
        columns.attrs["slip_approximation"] = APPROXIMATION
    if speed is not None:
        conductivities = [k for body in half_spaces(bodies) if (k := body.get("thermal_conductivity"))]
        # flash temperatures are those of two half-spaces
        if len(conductivities) != 2:
            raise SettingsError(
                "friction.speed: needs the thermal_conductivity of both bodies, without layers",
                keys=["statistics.friction.speed"],
            )
        if coefficient is None:
            coefficient = columns["friction_coefficient"].item()
            # so that the temperatures follow the interval of the area
            columns.attrs["flash_temperature_by"] = "shear_strength"
        warm = flash_temperature(
            contact,
            friction_coefficient=coefficient,
            speed=speed,
            thermal_conductivity=conductivities,
            thermal_diffusivity=thermal_diffusivity,
        )
        columns = columns.merge(_drop_maps(warm))
    return columns


def _equivalent_ratio(bodies: Sequence[Mapping[str, Any]] | None) -> float | None:
    """Return Poisson's ratio of two like bodies with the same tangential over normal compliance.

    Mindlin (1949), Johnson (1985), eq. 7.44: E*/4 Σ (2 - ν)/G of two bodies, (2 - ν)/(2 - 2ν) of like ones.
    """
    materials = [
        (body["youngs_modulus"], body["poissons_ratio"])
        for body in half_spaces(bodies)
        if body.get("youngs_modulus") and body.get("poissons_ratio") is not None
    ]
    if len(materials) != 2:
        return None
    # compliances of a half-space, normal (1 - nu^2)/E and tangential (2 - nu)(1 + nu)/(2 E)
    normal = sum((1 - ratio**2) / modulus for modulus, ratio in materials)
    tangential = sum((2 - ratio) * (1 + ratio) / modulus for modulus, ratio in materials) / 2
    compliance = tangential / normal
    # Mindlin's ratio (2 - nu)/(2 (1 - nu)), solved for nu
    return 2 * (compliance - 1) / (2 * compliance - 1)


def _drop_maps(dataset: xr.Dataset) -> xr.Dataset:
    """Return the numbers of a result, without its maps and the coordinates of the contact."""
    return dataset.drop_dims(("y", "x")).reset_coords(drop=True)
