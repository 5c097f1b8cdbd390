"""The quantities of the error budget: contact area, mean gap, largest pressure, mean pressure in contact.

Besides the answers: contact conductance, and the narrowest places of the gap along both axes.
"""

from collections.abc import Collection, Container, Iterator
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.contact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.contact.response import linear_response
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.statistics.sealing.percolation import percolation_columns
from roughcontact.uncertainty import scales
from roughcontact.uncertainty.scales import CONSTRICTIONS


def headline_values(
    pressure: np.ndarray,
    gap: np.ndarray,
    names: Collection[str],
    elasticity: Elasticity = HALF_SPACE,
    *,
    steps: tuple[float, float],
    border: int = 0,
    approach: float = np.nan,
) -> dict[str, float]:
    """Return quantities of one load from pressure (Pa) and gap (m), as `contact_statistics` defines them.

    `steps` are (dy, dx; m), `border` is that of `relative_contact_area`, `approach` (m) that since the first
    touch. The conductance is NaN in full contact, where it is infinite, and of layered bodies.

    Examples
    --------
    >>> pressure, gap = np.array([[0.0, 3.0, 1.0, 0.0]]), np.array([[0.5, 0.0, 0.0, 0.3]])
    >>> headline_values(pressure, gap, ("mean_gap", "max_pressure"), steps=(1.0, 1.0))
    {'mean_gap': 0.2, 'max_pressure': 3.0}
    """
    touching = pressure > 0
    values = {
        scales.AREA: relative_contact_area(touching, border=border),
        scales.GAP: float(gap[~touching].sum(dtype=float)) / gap.size,
        scales.PEAK: float(pressure.max()),
        scales.APPROACH: approach,
    }
    if scales.PRESSURE in names:
        values[scales.PRESSURE] = float(pressure[touching].mean(dtype=float))
    if scales.CONDUCTANCE in names:
        of_unit = Elasticity(influence=elasticity.influence)
        is_conducting = elasticity.medium.is_homogeneous  # as it displaces
        compliance = linear_response(touching, steps, of_unit) if is_conducting else 0.0
        values[scales.CONDUCTANCE] = 1 / compliance if compliance > 0 else np.nan
    if CONSTRICTIONS[0] in names:
        values |= percolation_columns(np.where(touching, 0.0, gap))
    return {name: values[name] for name in names}


def headline_names(dataset: Container[Any]) -> tuple[str, ...]:
    """Return the names of the headline quantities and the answers that a dataset contains."""
    return tuple(name for name in scales.ALL if name in dataset)


def iterate_fields(contact: xr.Dataset) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield pressure (Pa) and gap (m), arrays (ny, nx), of each load of a solution."""
    yield from zip(contact["pressure"].values, contact["gap"].values, strict=True)
