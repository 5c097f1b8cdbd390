"""How warm sliding makes the contact: flash temperatures from the pressure."""

from collections.abc import Sequence

import numpy as np
import scipy
import xarray as xr

from roughcontact.arguments.checking import check_periodic_solution, check_positive
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.si import as_si
from roughcontact.arguments.variables import describe
from roughcontact.errors import SettingsError
from roughcontact.kernels.fourier import wavevectors


@as_si
def flash_temperature(
    contact: xr.Dataset,
    *,
    friction_coefficient: float,
    speed: float | str,
    thermal_conductivity: Sequence[float | str],
    thermal_diffusivity: float | str | None = None,
) -> xr.Dataset:
    """Return by how much sliding along x warms the contact above the mean temperature of the surfaces.

    The heat mu p v that each point makes flows into both bodies. A wave of heat of wavevector q warms a
    half-space at rest by its amplitude over k|q|, and one that slides at the speed v by that over k sqrt(q^2
    + i q_x v/kappa) [1]_ [2]_, exact at any speed. Both surfaces count as equally warm everywhere, also
    across the gap: exact at rest, and within 1 % where k differs 100-fold. Between like bodies less than 1 %
    at a Péclet number v a/(2 kappa) up to 2, a patch of radius a is too cool by 4 % (its maximum) and 7 %
    (its mean) at 10, by 12 and 18 % at 50, against dense solutions with heat in the contact alone.

    Parameters
    ----------
    contact : Dataset
        of `solve_contact`, with its maps.
    friction_coefficient : float
        mu, positive.
    speed : float, m/s
        v, of the second body over the rough one.
    thermal_conductivity : sequence of two, W/(m K)
        k of the rough body, in which the heat stays where it is made, and of the sliding one.
    thermal_diffusivity : float, m2/s, optional
        kappa of the sliding body; without it sliding is slow, v l far below kappa for all wavelengths l.

    Returns
    -------
    Dataset
        over `load`: `temperature_rise` (y, x) K, its mean over the contact and its maximum.

    Raises
    ------
    SettingsError
        for a property that is not positive, or a contact that does not serve.

    References
    ----------
    .. [1] Carslaw and Jaeger (1959), Conduction of Heat in Solids, section 10.7.
    .. [2] Jaeger (1942), Moving sources of heat and the temperature at sliding contacts, J. Proc. R. Soc. New
       South Wales 76, 203.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> contact = solve_contact(rough_reference_surface(64), contact_modulus=1e9, mean_pressure=1e7)
    >>> warm = flash_temperature(
    ...     contact, friction_coefficient=0.2, speed=0.01, thermal_conductivity=[50.0, 0.3]
    ... )
    >>> bool(warm["max_flash_temperature"] > warm["mean_flash_temperature"])
    True
    """
    check_periodic_solution(contact)
    numbers = {"friction_coefficient": friction_coefficient, "speed": speed}
    heat = [check_positive(name, value, unit="SI units") for name, value in numbers.items()]
    if np.shape(thermal_conductivity) != (2,):
        raise SettingsError(f"thermal_conductivity = {thermal_conductivity!r}: give that of both bodies")
    still, sliding = (check_positive("thermal_conductivity", k, unit="W/(m K)") for k in thermal_conductivity)
    qy, qx = wavevectors(contact["height"].shape, spacing(contact["height"]))
    square = qy**2 + qx**2
    advection = 0.0
    if thermal_diffusivity is not None:
        advection = heat[1] / check_positive("thermal_diffusivity", thermal_diffusivity, unit="m2/s")
    conducts = still * np.sqrt(square) + sliding * np.sqrt(square + 1j * qx * advection)
    conducts[0, 0] = np.inf  # the mean flows away into the bodies
    pressure = contact["pressure"]
    spectrum = scipy.fft.rfft2(heat[0] * heat[1] * pressure.values)
    rise = pressure.copy(data=scipy.fft.irfft2(spectrum / conducts, s=pressure.shape[1:]))
    fields = {"temperature_rise": rise, "mean_flash_temperature": rise.where(pressure > 0).mean(("y", "x"))}
    return describe(xr.Dataset(fields | {"max_flash_temperature": rise.max(("y", "x"))}))
