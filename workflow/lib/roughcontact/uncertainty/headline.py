"""The quantities of the error budget, computed from pressure and gap on their own.

Four are the headline: contact area, mean gap, largest pressure, mean pressure in contact. Three are answers
of engineering: contact conductance, and the narrowest places of the gap along both axes.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from roughcontact.choices import Influence
from roughcontact.contact.dataset import influence_of, layers_of
from roughcontact.contact.response import linear_response
from roughcontact.maps import spacing
from roughcontact.sealing.percolation import percolation_columns
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.uncertainty.scales import (
    ANSWERS,
    AREA,
    CONDUCTANCE,
    CONSTRICTIONS,
    GAP,
    PEAK,
    PRESSURE,
    QUANTITIES,
)

_RESPONSE_TOLERANCE = (
    3e-2  # of the linear response: the relative error of the conductance is about its square
)


def quantities_of(
    pressure: np.ndarray,
    gap: np.ndarray,
    names: Sequence[str],
    *,
    steps: tuple[float, float],
    influence: Influence = "sampled",
    layered: bool = False,
) -> dict[str, float]:
    """Return quantities of one load, as `contact_statistics` defines them.

    Parameters
    ----------
    pressure, gap : array (ny, nx), Pa and m
    names : sequence of str
        of `QUANTITIES` and `ANSWERS`.
    steps : (dy, dx), m
    influence : {"sampled", "elements"}
        that the contact was solved with.
    layered : bool
        whether the bodies have layers, whose conductance is another problem than their stiffness: NaN.

    Examples
    --------
    >>> pressure, gap = np.array([[0.0, 3.0, 1.0, 0.0]]), np.array([[0.5, 0.0, 0.0, 0.3]])
    >>> quantities_of(pressure, gap, ("mean_gap", "max_pressure"), steps=(1.0, 1.0))
    {'mean_gap': 0.2, 'max_pressure': 3.0}
    """
    touching = pressure > 0
    found: dict[str, float] = {}
    if AREA in names:
        found[AREA] = relative_contact_area(touching)
    if GAP in names:
        found[GAP] = float(gap[~touching].sum(dtype=float)) / gap.size
    if PEAK in names:
        found[PEAK] = float(pressure.max())
    if PRESSURE in names:
        found[PRESSURE] = float(pressure[touching].mean(dtype=float))
    if CONDUCTANCE in names:
        compliance = (
            0.0
            if layered
            else linear_response(touching, steps, 1.0, _RESPONSE_TOLERANCE, influence=influence)
        )
        found[CONDUCTANCE] = 1 / compliance if compliance > 0 else np.nan
    if CONSTRICTIONS[0] in names:
        narrowest = percolation_columns(np.where(touching, 0.0, gap))
        found |= {name: narrowest[name] for name in CONSTRICTIONS}
    return found


def headline(contact: xr.Dataset) -> xr.Dataset:
    """Return the four headline quantities of each load, as `contact_statistics` defines them.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset
        dim load: `relative_contact_area` (1), `mean_gap` (m), `max_pressure` and `mean_contact_pressure`
        (Pa).

    Examples
    --------
    >>> import xarray as xr
    >>> fields = {"pressure": [[[0.0, 3.0, 1.0, 0.0]]], "gap": [[[0.5, 0.0, 0.0, 0.3]]]}
    >>> found = headline(xr.Dataset({name: (("load", "y", "x"), v) for name, v in fields.items()}))
    >>> [round(found[name].item(), 3) for name in ("mean_gap", "max_pressure", "mean_contact_pressure")]
    [0.2, 3.0, 2.0]
    """
    rows = [quantities_of(*fields, QUANTITIES, steps=(1.0, 1.0)) for fields in fields_of(contact)]
    return xr.Dataset({name: ("load", [row[name] for row in rows]) for name in QUANTITIES})


def headline_and_answers(contact: xr.Dataset) -> xr.Dataset:
    """Return headline quantities and answers of each load, as `contact_statistics` defines them.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset
        dim load: those of `headline` and `ANSWERS`; NaN for the infinite conductance of full contact,
        and for that of bodies with layers.

    Examples
    --------
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.references.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 64), 1 / 64, amplitude=0.1, wavelength=1.0)
    >>> problem = {"contact_modulus": 1.0, "mean_pressure": [0.15]}
    >>> found = solve_contact(wave, **problem, reduce=headline_and_answers)
    >>> found["critical_constriction_x"].item(), found["critical_constriction_y"].item() > 0
    (0.0, True)
    """
    names, steps = (*QUANTITIES, *ANSWERS), spacing(contact["pressure"])
    influence, layered = influence_of(contact), layers_of(contact) is not None
    rows = [
        quantities_of(*fields, names, steps=steps, influence=influence, layered=layered)
        for fields in fields_of(contact)
    ]
    return xr.Dataset({name: ("load", [row[name] for row in rows]) for name in names})


def quantities_in(found: xr.Dataset) -> tuple[str, ...]:
    """Return the names of the headline quantities, and of the answers that a dataset contains.

    Examples
    --------
    >>> import xarray as xr
    >>> quantities_in(xr.Dataset({"critical_constriction_x": 2.0}))[-2:]
    ('mean_contact_pressure', 'critical_constriction_x')
    """
    return *QUANTITIES, *(name for name in ANSWERS if name in found)


def fields_of(contact: xr.Dataset) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield pressure and gap of each load of a solution.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Yields
    ------
    pressure : array (ny, nx), Pa
    gap : array (ny, nx), m
    """
    yield from zip(contact["pressure"].values, contact["gap"].values, strict=True)
