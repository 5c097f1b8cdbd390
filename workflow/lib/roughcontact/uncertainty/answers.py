"""The answers that have an interval beside the four headline numbers: conductance and narrowest places.

They are counted in the solutions that are made for those anyway, and have the same sources but that of the
solver, whose tolerance they do not feel.
"""

import numpy as np
import xarray as xr

from roughcontact.contact.response import linear_response
from roughcontact.maps import spacing
from roughcontact.sealing.percolation import percolation_columns
from roughcontact.uncertainty.headline import fields_of, headline

# names of `roughcontact.variables`
ANSWERS = ("conductance_per_conductivity", "critical_constriction_x", "critical_constriction_y")
_TOLERANCE = 3e-2  # of the response: the conductance is good to about its square
_NEXT_TO_NOTHING = 1e-2  # of the window's result: less has no logarithm that says anything
_GROWTH_REACH = 1.5  # of the growth of the heights that is expected: how far conductance may fall


def headline_and_answers(contact: xr.Dataset) -> xr.Dataset:
    """Return the four quantities of each load, and the answers, as `contact_statistics` defines them.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset
        dim load: those of `headline`, and `ANSWERS`; the conductance of full contact is infinite, and NaN.

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
    steps = spacing(contact["pressure"])
    compliances = [
        linear_response(pressure > 0, steps, 1.0, _TOLERANCE) for pressure, _ in fields_of(contact)
    ]
    conductances = [1 / compliance if compliance > 0 else np.nan for compliance in compliances]
    return headline_and_narrowest(contact).assign({ANSWERS[0]: ("load", conductances)})


def headline_and_narrowest(contact: xr.Dataset) -> xr.Dataset:
    """Return the four quantities of each load, and the narrowest places on the way through the gap.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset
        dim load: those of `headline`, `critical_constriction_x` and `critical_constriction_y` (m).

    Examples
    --------
    >>> import xarray as xr
    >>> fields = {"pressure": [[[0.0, 3.0], [0.0, 0.0]]], "gap": [[[0.5, 0.0], [0.2, 0.3]]]}
    >>> contact = xr.Dataset({name: (("load", "y", "x"), values) for name, values in fields.items()})
    >>> found = headline_and_narrowest(contact)
    >>> found["critical_constriction_x"].item(), found["critical_constriction_y"].item()
    (0.2, 0.2)
    """
    rows = [percolation_columns(np.where(pressure > 0, 0.0, gap)) for pressure, gap in fields_of(contact)]
    return headline(contact).assign({name: ("load", [row[name] for row in rows]) for name in ANSWERS[1:]})


def answers_in(found: xr.Dataset) -> list[str]:
    """Return the names of the answers that were counted.

    Parameters
    ----------
    found : Dataset

    Returns
    -------
    list of str

    Examples
    --------
    >>> import xarray as xr
    >>> answers_in(xr.Dataset({"mean_gap": 1.0, "critical_constriction_x": 2.0}))
    ['critical_constriction_x']
    """
    return [name for name in ANSWERS if name in found]


def of_other_places(
    name: str,
    values: np.ndarray,
    result: np.ndarray,
    *,
    factor: float,
    growth: float,
    going_on: float = 0.0,
    added: np.ndarray | float = 0.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far below and above an answer it lies elsewhere, from the scatter of parts and from growth.

    Of the conductance the logarithm scatters; it is K(p) at n times the heights what it was at the n-th part
    of the load, and K about proportional to it, so that higher heights conduct less. Of a narrowest place,
    which may be closed, the height itself scatters, and grows with the others. As the answer changed from the
    parts to the window it may go on to change, in a direction that is not known.

    Parameters
    ----------
    name : str
        one of `ANSWERS`.
    values : array (member, load)
        of the parts.
    result : array (load,)
    factor : float
        from one standard deviation of the parts to the half-width.
    growth : float
        logarithm of the growth of the heights, which takes conductance away.
    going_on : float
        how much of its change from the parts to the window an answer may change from there to the surface.
    added : array (load,)
        what a narrowest place may grow by with the heights.

    Returns
    -------
    down, up : arrays (load,)
        NaN for less than two parts.

    Examples
    --------
    >>> parts, result = np.array([[1.0], [np.e]]), np.array([2.0])
    >>> down, up = of_other_places(ANSWERS[0], parts, result, factor=np.sqrt(2), growth=0.0)
    >>> f"{down[0]:.3f} {up[0]:.3f}"
    '1.264 3.437'
    """
    if len(values) < 2:
        return np.full(result.shape, np.nan), np.full(result.shape, np.nan)
    logarithmic = name == ANSWERS[0]
    whole, parts = result, values
    if logarithmic:
        whole, parts = np.log(result), np.log(np.maximum(values, _NEXT_TO_NOTHING * result))
    change = np.abs(whole - parts.mean(axis=0))
    half_width = np.hypot(factor * parts.std(axis=0, ddof=1), going_on * change)
    if logarithmic:
        lost = _GROWTH_REACH * max(growth, 0.0)
        return -result * np.expm1(-np.hypot(half_width, lost)), result * np.expm1(half_width)
    return np.minimum(half_width, result), np.hypot(half_width, added)
