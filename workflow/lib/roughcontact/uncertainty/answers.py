"""Uncertainty of the engineering answers: contact conductance and critical constrictions of the gap.

They are computed from the same solutions as the four headline quantities and have the same uncertainty
sources except the solver, to whose tolerance they are insensitive.
"""

from collections.abc import Callable, Mapping

import numpy as np
import xarray as xr

from roughcontact.contact.dataset import influence_of, layers_of
from roughcontact.contact.response import linear_response
from roughcontact.maps import spacing
from roughcontact.sealing.percolation import half_way_levels, percolation_columns
from roughcontact.uncertainty.headline import QUANTITIES, fields_of, headline

# names of `roughcontact.variables`
CONSTRICTIONS = ("critical_constriction_x", "critical_constriction_y")
ANSWERS = ("conductance_per_conductivity", *CONSTRICTIONS)
Column = tuple[str, np.ndarray]  # dimension and values of a variable
_TOLERANCE = 3e-2  # of the linear response: the relative error of the conductance is about its square
_LOGARITHM_FLOOR = 1e-2  # of the window's result: the logarithm of smaller values is meaningless
_GROWTH_UNCERTAINTY = 0.25  # relative uncertainty of the change expected from growing heights
_GROOVE_AREA_LIMIT = 0.2  # of the window: random valleys, of waves up to a third of the map, take up more


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
    return headline(contact).assign(answers_of(contact))


def answers_of(contact: xr.Dataset, statistics: xr.Dataset | None = None) -> dict[str, Column]:
    """Return the answers of each load, with their dimension, as of `headline_and_answers`.

    They are taken from `contact_statistics` of the same solution where these are given.
    """
    if statistics is not None:
        known = {name: statistics[name].values for name in ANSWERS}
        known[ANSWERS[0]] = np.where(np.isfinite(known[ANSWERS[0]]), known[ANSWERS[0]], np.nan)
        return {name: ("load", values) for name, values in known.items()}
    steps, influence, rows = spacing(contact["pressure"]), influence_of(contact), []
    layered = layers_of(contact) is not None
    for pressure, gap in fields_of(contact):
        touching = pressure > 0
        # the conductance of layers is another problem than their stiffness
        compliance = (
            0.0 if layered else linear_response(touching, steps, 1.0, _TOLERANCE, influence=influence)
        )
        narrowest = percolation_columns(np.where(touching, 0.0, gap))
        rows.append({ANSWERS[0]: 1 / compliance if compliance > 0 else np.nan, **narrowest})
    return {name: ("load", np.array([row[name] for row in rows])) for name in ANSWERS}


def answers_present(found: xr.Dataset) -> list[str]:
    """Return the names of the answers that a dataset contains.

    Parameters
    ----------
    found : Dataset
        quantities along `load`.

    Returns
    -------
    list of str

    Examples
    --------
    >>> import xarray as xr
    >>> answers_present(xr.Dataset({"mean_gap": 1.0, "critical_constriction_x": 2.0}))
    ['critical_constriction_x']
    """
    return [name for name in ANSWERS if name in found]


def quantities_in(found: xr.Dataset) -> tuple[str, ...]:
    """Return the names of the headline quantities, and of the answers that a dataset contains.

    Examples
    --------
    >>> import xarray as xr
    >>> quantities_in(xr.Dataset({"critical_constriction_x": 2.0}))[-2:]
    ('mean_contact_pressure', 'critical_constriction_x')
    """
    return *QUANTITIES, *answers_present(found)


def counter_of(found: xr.Dataset) -> Callable[[xr.Dataset], xr.Dataset]:
    """Return the function that computes from a solution the quantities that a dataset contains.

    Examples
    --------
    >>> import xarray as xr
    >>> counter_of(xr.Dataset()) is headline
    True
    """
    return headline_and_answers if answers_present(found) else headline


def half_length_constrictions(contact: xr.Dataset) -> xr.Dataset:
    """Return the critical constrictions of gap paths half as long as the map, at each load.

    Parameters
    ----------
    contact : Dataset
        as `solve_contact` returns it, with its fields.

    Returns
    -------
    Dataset
        dim load: `{name}_half_way` (m) for each critical constriction in `ANSWERS`, as
        `roughcontact.sealing.percolation.half_way_levels` defines it.

    Examples
    --------
    >>> import xarray as xr
    >>> fields = {"pressure": [[[0.0, 3.0], [0.0, 0.0]]], "gap": [[[0.5, 0.0], [0.2, 0.3]]]}
    >>> contact = xr.Dataset({name: (("load", "y", "x"), values) for name, values in fields.items()})
    >>> half_length_constrictions(contact)["critical_constriction_y_half_way"].item()
    0.5
    """
    rows = [half_way_levels(np.where(pressure > 0, 0.0, gap)) for pressure, gap in fields_of(contact)]
    return xr.Dataset({f"{name}_half_way": ("load", [row[name] for row in rows]) for name in CONSTRICTIONS})


def constrictions_in_grooves(window: xr.DataArray) -> list[str]:
    """Return the critical constrictions that lie in grooves, or valleys, leading out of the map.

    The criterion is the area that is open at the level where paths half as long as the map first percolate.
    Random heights percolate when about half of the area is open [1]_, a groove with much less.

    Parameters
    ----------
    window : DataArray (y, x), m
        periodic.

    Returns
    -------
    list of str
        names from `ANSWERS`; empty for a profile, which has no paths.

    References
    ----------
    .. [1] Dapp, Lücke, Persson and Müser (2012), Self-affine elastic contacts: percolation and leakage, Phys.
       Rev. Lett. 108, 244301.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface, westergaard_surface
    >>> constrictions_in_grooves(westergaard_surface((64, 64), 1e-6, amplitude=1e-6, wavelength=32e-6))
    ['critical_constriction_y']
    >>> constrictions_in_grooves(rough_reference_surface(64))
    []
    """
    if 1 in window.shape:
        return []
    depth = window.values.max() - window.values
    levels = half_way_levels(depth)
    return [name for name in CONSTRICTIONS if np.mean(depth >= levels[name]) < _GROOVE_AREA_LIMIT]


def interval_from_subwindows(
    name: str,
    values: np.ndarray,
    result: np.ndarray,
    *,
    factor: float,
    extent_factor: float = 0.0,
    grown: np.ndarray | None = None,
    half_way: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the half-widths below and above an answer, from the scatter of subwindows and from growth.

    Scatter is evaluated on the logarithm of a conductance, and on the value of a constriction, which may be
    zero. The trend from the subwindows to the window may continue towards the whole surface; its sign is not
    assumed. The effect of growing heights has a known sign (lower conductance, wider gaps): it is
    added linearly, not in quadrature ([1]_, F.2.4.5), with a relative uncertainty of one quarter. A
    constriction may rise to that of paths half as long as the map, since neither the border of the map nor
    the seam of the periodic window interrupts these.

    Parameters
    ----------
    name : str
        one of `ANSWERS`.
    values : array (member, load)
        results of the subwindows; NaN for a subwindow in full contact, whose conductance is infinite.
    result : array (load,)
        result of the window.
    factor : float
        half-width over the standard deviation of the subwindows.
    extent_factor : float
        possible change from the window to the surface, over the change from the subwindows to the window.
    grown : array (load,), optional
        result of the window with its heights scaled by their expected growth.
    half_way : array (load,), optional
        critical constriction of paths half as long as the map.

    Returns
    -------
    down, up : arrays (load,)
        NaN for fewer than two subwindows; `up` is infinite where the conductance of a subwindow is.

    References
    ----------
    .. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement.

    Examples
    --------
    >>> parts, result = np.array([[1.0], [np.e]]), np.array([2.0])
    >>> down, up = interval_from_subwindows(ANSWERS[0], parts, result, factor=np.sqrt(2))
    >>> f"{down[0]:.3f} {up[0]:.3f}"
    '1.264 3.437'
    """
    if len(values) < 2:
        return np.full(result.shape, np.nan), np.full(result.shape, np.nan)
    conducts = name == ANSWERS[0]
    whole, parts, higher = result, values, result if grown is None else grown
    if conducts:
        whole, parts, higher = (
            np.log(np.maximum(v, _LOGARITHM_FLOOR * result)) for v in (whole, parts, higher)
        )
    shift = np.nan_to_num(np.maximum(whole - higher if conducts else higher - whole, 0.0))
    without_end = np.isnan(parts).any(axis=0) if conducts else np.zeros(result.shape, bool)
    # a subwindow of infinite conductance says nothing about the lower end: the window's value stands in
    known = np.where(np.isnan(parts), whole, parts) if conducts else parts
    change = np.abs(whole - known.mean(axis=0))
    half_width = np.hypot(factor * known.std(axis=0, ddof=1), extent_factor * change)
    doubt = _GROWTH_UNCERTAINTY * shift
    if conducts:
        up = np.where(without_end, np.inf, result * np.expm1(half_width))
        return -result * np.expm1(-shift - np.hypot(half_width, doubt)), up
    beyond = 0.0 if half_way is None else np.maximum(half_way - result, 0.0)
    return np.minimum(half_width, result), shift + np.hypot(np.hypot(half_width, doubt), beyond)


def with_common_lower_end(
    half_widths: Mapping[str, tuple[np.ndarray, np.ndarray]], solved: xr.Dataset
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the half-widths of the constrictions of a surface without a lay, lower ends in common.

    On a large surface without a lay the gap percolates along both axes at the same level [1]_; that of a map
    depends on where its few walls lie, and may be closed along one axis by chance alone. The lower end along
    each axis is therefore the lower one of both.

    Parameters
    ----------
    half_widths : mapping
        quantity -> half-widths below and above (load).
    solved : Dataset
        the result.

    Returns
    -------
    dict
        the constrictions among the quantities, both of which or none are present.

    References
    ----------
    .. [1] Stauffer and Aharony (1994), Introduction to Percolation Theory, 2nd ed., chapter 4.

    Examples
    --------
    >>> x, y = CONSTRICTIONS
    >>> solved = xr.Dataset({x: ("load", [3.0]), y: ("load", [1.0])})
    >>> found = with_common_lower_end({x: (np.ones(1), np.ones(1)), y: (np.ones(1), np.ones(1))}, solved)
    >>> found[x][0].item(), found[y][0].item()
    (3.0, 1.0)
    """
    names = [name for name in CONSTRICTIONS if name in half_widths]
    if not names:
        return {}
    lowest = np.min([solved[name].values - half_widths[name][0] for name in names], axis=0)
    return {name: (solved[name].values - lowest, half_widths[name][1]) for name in names}
