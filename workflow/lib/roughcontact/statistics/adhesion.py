"""Balance of adhesion: the energy of pressing the surfaces flat against their work of adhesion."""

import numpy as np
import xarray as xr

from roughcontact.elasticity.energy import conforming_energy
from roughcontact.elasticity.layers import LayeredPair
from roughcontact.maps import spacing
from roughcontact.quantities import Unit, number

_ENERGY = Unit(1e3, "mJ/m²")


def adhesion_numbers(
    height: xr.DataArray,
    *,
    contact_modulus: float,
    work_of_adhesion: float | None = None,
    power: np.ndarray | None = None,
    layers: LayeredPair | None = None,
) -> dict[str, float]:
    """Return the energy of full conformity, and the effective work of adhesion.

    Surfaces stick in full contact where their work of adhesion w exceeds the elastic energy U of full
    conformity: w - U is the effective work of adhesion [1]_. It is a balance of two end states, without a
    range of the adhesion and without the states between. Roughness sticks by patches long before all of it
    conforms: a criterion by the slope of the shortest waves says so [2]_, and is disputed [3]_.

    `height` (y, x) in m: periodic; `contact_modulus` in Pa: E*; `work_of_adhesion` in J/m2: w, of flat
    surfaces; `power` (ny, nx // 2 + 1) in m2: of the waves of the map
    (`roughcontact.kernels.waves.wave_power`), where that is known already; `layers`: of the bodies; E* is
    then that of their surfaces. Returns `conforming_energy` (J/m2), and with a work of adhesion
    `effective_work_of_adhesion` (J/m2).

    References
    ----------
    .. [1] Persson and Tosatti (2001), The effect of surface roughness on the adhesion of elastic solids,
       J. Chem. Phys. 115, 5597.
    .. [2] Pastewka and Robbins (2014), Contact between rough surfaces and a criterion for macroscopic
       adhesion, PNAS 111, 3298.
    .. [3] Ciavarella (2016), arXiv 1602.02555.

    Examples
    --------
    >>> from roughcontact.references.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 64), 1e-5 / 64, amplitude=1e-7, wavelength=1e-5)
    >>> found = adhesion_numbers(wave, contact_modulus=1e6, work_of_adhesion=0.05)
    >>> f"{found['conforming_energy']:.5f} {found['effective_work_of_adhesion']:.5f}"
    '0.00079 0.04921'
    """
    energy = conforming_energy(
        height.values, spacing(height), contact_modulus=contact_modulus, power=power, layers=layers
    )
    if work_of_adhesion is None:
        return {"conforming_energy": energy}
    return {"conforming_energy": energy, "effective_work_of_adhesion": work_of_adhesion - energy}


def adhesion_in_words(statistics: xr.Dataset) -> str:
    """Return whether surfaces stick by the balance of energies, in words; empty without a work of adhesion.

    Examples
    --------
    >>> numbers = {"conforming_energy": 2.0, "effective_work_of_adhesion": -1.95}
    >>> adhesion_in_words(xr.Dataset(numbers))
    'not sticky: pressing the surfaces flat costs 2000 mJ/m², 40 times the work of adhesion (50.0 mJ/m²)'
    """
    if "effective_work_of_adhesion" not in statistics:
        return ""
    energy, remaining = (
        float(statistics[name]) for name in ("conforming_energy", "effective_work_of_adhesion")
    )
    work = energy + remaining
    paid = _ENERGY.text(work)
    if remaining > 0:
        return (
            f"sticky: of the work of adhesion ({paid}) {_ENERGY.text(remaining)} is left when the surfaces "
            "are pressed flat"
        )
    return (
        f"not sticky: pressing the surfaces flat costs {_ENERGY.text(energy)}, "
        f"{number(energy / work, digits=2)} times the work of adhesion ({paid})"
    )
