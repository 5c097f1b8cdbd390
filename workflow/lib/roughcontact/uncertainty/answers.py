"""The answers that have an interval beside the four headline numbers: conductance and narrowest places.

They are counted in the solutions that are made for those anyway, and have the same sources but that of the
solver, whose tolerance they do not feel.
"""

import numpy as np
import xarray as xr

from roughcontact.contact.dataset import influence_of
from roughcontact.contact.response import linear_response
from roughcontact.maps import spacing
from roughcontact.sealing.percolation import half_way_levels, percolation_columns
from roughcontact.uncertainty.headline import fields_of, headline

# names of `roughcontact.variables`
ANSWERS = ("conductance_per_conductivity", "critical_constriction_x", "critical_constriction_y")
_TOLERANCE = 3e-2  # of the response: the conductance is good to about its square
_NEXT_TO_NOTHING = 1e-2  # of the window's result: less has no logarithm that says anything
_OF_THE_GROWTH = 0.25  # of what growth of the heights is expected to change: how far that may be off
_GROOVE = 0.2  # of the window: valleys at random, of waves up to a third of the map, take up more


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
    steps, influence, rows = spacing(contact["pressure"]), influence_of(contact), []
    for pressure, gap in fields_of(contact):
        touching = pressure > 0
        compliance = linear_response(touching, steps, 1.0, _TOLERANCE, influence=influence)
        narrowest = percolation_columns(np.where(touching, 0.0, gap))
        rows.append({ANSWERS[0]: 1 / compliance if compliance > 0 else np.nan, **narrowest})
    return headline(contact).assign({name: ("load", [row[name] for row in rows]) for name in ANSWERS})


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


def half_ways(contact: xr.Dataset) -> xr.Dataset:
    """Return how narrow the best ways through the gap are that are half as long as the map, at each load.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset
        dim load: for the narrowest places in `ANSWERS` `{name}_half_way` (m), as
        `roughcontact.sealing.percolation.half_way_levels` defines them.

    Examples
    --------
    >>> import xarray as xr
    >>> fields = {"pressure": [[[0.0, 3.0], [0.0, 0.0]]], "gap": [[[0.5, 0.0], [0.2, 0.3]]]}
    >>> contact = xr.Dataset({name: (("load", "y", "x"), values) for name, values in fields.items()})
    >>> half_ways(contact)["critical_constriction_y_half_way"].item()
    0.5
    """
    rows = [half_way_levels(np.where(pressure > 0, 0.0, gap)) for pressure, gap in fields_of(contact)]
    return xr.Dataset({f"{name}_half_way": ("load", [row[name] for row in rows]) for name in ANSWERS[1:]})


def grooved(window: xr.DataArray) -> list[str]:
    """Return which of the narrowest places lie in grooves, or valleys, that run out of the map.

    The best ways through the valleys that are half as long as the map are looked for. Where heights are
    scattered at random they take up about half of its area, since that much has to be open before anything
    percolates [1]_; a groove leads there with little of it.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.

    Returns
    -------
    list of str
        of the names in `ANSWERS`; none of a profile, which shows no ways.

    References
    ----------
    .. [1] Dapp, Lücke, Persson and Müser (2012), Self-affine elastic contacts: percolation and leakage, Phys.
       Rev. Lett. 108, 244301.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface, westergaard_surface
    >>> grooved(westergaard_surface((64, 64), 1e-6, amplitude=1e-6, wavelength=32e-6))
    ['critical_constriction_y']
    >>> grooved(rough_reference_surface(64))
    []
    """
    if 1 in window.shape:
        return []
    depth = window.values.max() - window.values
    levels = half_way_levels(depth)
    return [name for name in ANSWERS[1:] if np.mean(depth >= levels[name]) < _GROOVE]


def of_other_places(
    name: str,
    values: np.ndarray,
    result: np.ndarray,
    *,
    factor: float,
    going_on: float = 0.0,
    grown: np.ndarray | None = None,
    half_way: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far below and above an answer it lies elsewhere, from the scatter of parts and from growth.

    Of the conductance the logarithm scatters, of a narrowest place, which may be closed, the height itself.
    As the answer changed from the parts to the window it may go on to change, in a direction that is not
    known. What higher heights are expected to change has a direction (they conduct less and leave wider
    gaps), so that it is added as it is and not as a square ([1]_, F.2.4.5), and may be off by a quarter.
    Ways that are half as long as the map, which nothing outside it and no seam of the period ends, may go on.

    Parameters
    ----------
    name : str
        one of `ANSWERS`.
    values : array (member, load)
        of the parts; NaN for a part in full contact, which conducts without end.
    result : array (load,)
    factor : float
        from one standard deviation of the parts to the half-width.
    going_on : float
        how much of its change from the parts to the window an answer may change from there to the surface.
    grown : array (load,), optional
        the answer of the window with its heights as high as they are expected to be.
    half_way : array (load,), optional
        how narrow ways half as long as the map are.

    Returns
    -------
    down, up : arrays (load,)
        NaN for less than two parts; up infinite where a part conducts without end.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement.

    Examples
    --------
    >>> parts, result = np.array([[1.0], [np.e]]), np.array([2.0])
    >>> down, up = of_other_places(ANSWERS[0], parts, result, factor=np.sqrt(2))
    >>> f"{down[0]:.3f} {up[0]:.3f}"
    '1.264 3.437'
    """
    if len(values) < 2:
        return np.full(result.shape, np.nan), np.full(result.shape, np.nan)
    conducts = name == ANSWERS[0]
    whole, parts, higher = result, values, result if grown is None else grown
    if conducts:
        whole, parts, higher = (
            np.log(np.maximum(v, _NEXT_TO_NOTHING * result)) for v in (whole, parts, higher)
        )
    shift = np.nan_to_num(np.maximum(whole - higher if conducts else higher - whole, 0.0))
    without_end = np.isnan(parts).any(axis=0) if conducts else np.zeros(result.shape, bool)
    # what conducts without end says nothing of how much less it may be
    known = np.where(np.isnan(parts), whole, parts) if conducts else parts
    change = np.abs(whole - known.mean(axis=0))
    half_width = np.hypot(factor * known.std(axis=0, ddof=1), going_on * change)
    doubt = _OF_THE_GROWTH * shift
    if conducts:
        up = np.where(without_end, np.inf, result * np.expm1(half_width))
        return -result * np.expm1(-shift - np.hypot(half_width, doubt)), up
    beyond = 0.0 if half_way is None else np.maximum(half_way - result, 0.0)
    return np.minimum(half_width, result), shift + np.hypot(np.hypot(half_width, doubt), beyond)
