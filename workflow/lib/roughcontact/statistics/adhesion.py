"""Balance of adhesion: the energy of pressing the surfaces flat against their work of adhesion."""

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import spacing
from roughcontact.arguments.quantities import Unit, number
from roughcontact.contact.elasticity.energy import conforming_energy
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.errors import SettingsError

_ENERGY = Unit(1e3, "mJ/m²")


def adhesion_numbers(
    height: xr.DataArray,
    elasticity: Elasticity,
    *,
    work_of_adhesion: float | None = None,
    power: np.ndarray | None = None,
) -> dict[str, float]:
    """Return the energy U of full conformity (J/m2) of a periodic map (y, x; m), and w - U, the work left.

    Surfaces stick in full contact where the work of adhesion w exceeds U (Persson and Tosatti 2001, J. Chem.
    Phys. 115, 5597). Roughness sticks by patches long before, by the slope of its shortest waves (Pastewka
    and Robbins 2014, PNAS 111, 3298; disputed by Ciavarella 2016, arXiv 1602.02555). `power` (ny, nx // 2 +
    1; m2) is that of the waves, if known.
    """
    energy = conforming_energy(height.values, spacing(height), elasticity, power=power)
    if work_of_adhesion is None:
        return {"conforming_energy": energy}
    if not work_of_adhesion >= 0:
        raise SettingsError(f"work_of_adhesion = {work_of_adhesion:g}: give 0 or more J/m2")
    return {"conforming_energy": energy, "effective_work_of_adhesion": work_of_adhesion - energy}


def adhesion_in_words(statistics: xr.Dataset) -> str:
    """Return in words whether surfaces stick by the balance of energies; empty without work of adhesion."""
    if "effective_work_of_adhesion" not in statistics:
        return ""
    energy = float(statistics["conforming_energy"])
    remaining = float(statistics["effective_work_of_adhesion"])
    work = energy + remaining
    paid = _ENERGY.text(work)
    if remaining > 0:  # a positive work is left
        return (
            f"sticky: of the work of adhesion ({paid}) {_ENERGY.text(remaining)} is left when the surfaces "
            "are pressed flat"
        )
    return (
        f"not sticky: pressing the surfaces flat costs {_ENERGY.text(energy)}, "
        f"{number(energy / work, digits=2)} times the work of adhesion ({paid})"
    )
