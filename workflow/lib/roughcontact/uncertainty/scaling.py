"""Uncertainty of load, contact modulus and amplification, from the solved curve alone.

The elastic contact of a surface depends on one number, the load over modulus times slope. With heights a,
lengths b, modulus c and load d times as large, every result follows from the solution at the load
p d b/(c a):

    A(p) = A0,   u = a u0,   p_c = p d/A,   p_max = (c a/b) p_max0,   K/E* = kappa0/b,   gap height = a c0

(Persson 2001, J. Chem. Phys. 115, 3840, for the area; exact for a linear elastic half-space without
hardness). With layers that holds for all but the lengths. The sensitivity of the logarithm of a result to
the logarithm of an input is therefore its explicit power plus the power of the input in the load times s = d
ln Q/d ln p, the slope of the solved curve. No further solution is needed.
"""

import numpy as np
import scipy
import xarray as xr

from roughcontact.uncertainty.answers import ANSWERS, CONSTRICTIONS, quantities_in
from roughcontact.uncertainty.headline import QUANTITIES

AREA, GAP, PEAK, PRESSURE = QUANTITIES
CONDUCTANCE = ANSWERS[0]
_MAX_AREA = 1 - 1e-6  # keeps erfinv finite: hardly a point is open
# Power of an input in the load p d b/(c a).
_POWER_IN_LOAD = {
    "mean_pressure": 1.0,
    "contact_modulus": -1.0,
    "amplification_z": -1.0,
    "amplification_xy": 1.0,
}
# Explicit power of an input in a result; constrictions scale as the mean gap.
_EXPLICIT_POWER = {
    ("mean_pressure", PRESSURE): 1.0,
    ("contact_modulus", PEAK): 1.0,
    ("amplification_z", GAP): 1.0,
    ("amplification_z", PEAK): 1.0,
    ("amplification_xy", PEAK): -1.0,
    ("amplification_xy", CONDUCTANCE): -1.0,
}
# Slopes assumed where a single load was solved: proportional growth of area and conductance at small loads, a
# peak that hardly grows, a gap that falls with the logarithm of the load.
_SINGLE_LOAD_SLOPES = {AREA: 1.0, GAP: -0.5, PEAK: 0.1, CONDUCTANCE: 1.0}


def effort(area: np.ndarray) -> np.ndarray:
    """Return x = erfinv(A) of a contact area, by Persson's law the load over E* g up to a factor.

    Parameters
    ----------
    area : array
        relative contact area.

    Returns
    -------
    array
        finite for full contact.

    Examples
    --------
    >>> import numpy as np
    >>> effort(np.array([0.0, 0.5])).round(3)
    array([0.   , 0.477])
    """
    return scipy.special.erfinv(np.clip(area, 0.0, _MAX_AREA))


def log_slopes(solved: xr.Dataset) -> dict[str, np.ndarray]:
    """Return d ln Q/d ln p of each result at each load; of the area that of its effort.

    Parameters
    ----------
    solved : Dataset
        `QUANTITIES` and answers along `load`, with `mean_pressure`, and `contact_modulus`.

    Returns
    -------
    dict
        quantity -> array (load); 0 where the quantity vanishes. A single load takes the slopes of small
        loads.

    Examples
    --------
    >>> import xarray as xr
    >>> solved = xr.Dataset({name: ("load", [0.1, 0.2]) for name in QUANTITIES})
    >>> solved["mean_pressure"] = ("load", [1.0, 2.0])
    >>> log_slopes(solved)["max_pressure"].round(3).tolist()
    [1.0, 1.0]
    """
    load = np.log(solved["mean_pressure"].values)
    order = np.argsort(load)
    slopes = {}
    for name in quantities_in(solved):
        if name == PRESSURE:
            continue
        values = solved[name].values
        values = effort(values) if name == AREA else values
        positive = np.nan_to_num(values) > 0
        slope = np.full(load.shape, _SINGLE_LOAD_SLOPES.get(name, _SINGLE_LOAD_SLOPES[GAP]))
        if np.unique(load[positive]).size > 1:
            kept = order[positive[order]]
            slope[kept] = np.gradient(np.log(values[kept]), load[kept])
        slopes[name] = np.where(positive, slope, 0.0)
    if CONDUCTANCE in solved and "contact_modulus" in solved:
        # of the gap it is exact: d u/d p = -1/K
        stiffness = solved[CONDUCTANCE].values * float(solved["contact_modulus"])
        gap = solved[GAP].values
        usable = (gap > 0) & (stiffness > 0)
        exact = -np.exp(load) / np.where(usable, stiffness * gap, 1.0)
        slopes[GAP] = np.where(usable, exact, slopes[GAP])
    return slopes


def _set_aside(solved: xr.Dataset) -> set[str]:
    """Return the inputs that the law does not cover: lengths beside thicknesses of layers, which stay."""
    return {"amplification_xy"} if "bodies" in solved.attrs else set()


def _sensitivities(slopes: dict[str, np.ndarray], source: str) -> dict[str, np.ndarray]:
    """Return d ln Q/d ln(input), of the area that of its effort; the pressure in contact follows from it."""
    found = {}
    for name, slope in slopes.items():
        like = GAP if name in CONSTRICTIONS else name
        found[name] = _EXPLICIT_POWER.get((source, like), 0.0) + _POWER_IN_LOAD[source] * slope
    return found


def log_sensitivities(solved: xr.Dataset) -> xr.Dataset:
    """Return the sensitivity of each result to load, modulus and scales: percent by percent.

    Parameters
    ----------
    solved : Dataset
        as of `log_slopes`.

    Returns
    -------
    Dataset
        `{quantity}_sensitivity` (load, input), d ln Q/d ln(input).

    Examples
    --------
    >>> import xarray as xr
    >>> solved = xr.Dataset({name: ("load", [0.01, 0.02]) for name in QUANTITIES})
    >>> solved["mean_pressure"] = ("load", [1.0, 2.0])
    >>> log_sensitivities(solved)["relative_contact_area_sensitivity"].round(2).values[0].tolist()
    [1.0, -1.0, -1.0, 1.0]
    """
    inputs = [name for name in _POWER_IN_LOAD if name not in _set_aside(solved)]
    area = solved[AREA].values
    x = effort(area)
    # d ln A/d ln x of A = erf(x)
    slope = np.where(area > 0, 2 / np.sqrt(np.pi) * x * np.exp(-(x**2)) / np.where(area > 0, area, 1.0), 0.0)
    columns: dict[str, list[np.ndarray]] = {}
    slopes = log_slopes(solved)
    for source in inputs:
        found = _sensitivities(slopes, source)
        found[AREA] = slope * found[AREA]
        found[PRESSURE] = _EXPLICIT_POWER.get((source, PRESSURE), 0.0) - found[AREA]
        for name, values in found.items():
            columns.setdefault(name, []).append(values)
    return xr.Dataset(
        {
            f"{name}_sensitivity": (("load", "input"), np.stack(each, axis=1))
            for name, each in columns.items()
        },
        coords={"input": inputs},
    )


def scaling_uncertainty(solved: xr.Dataset, inputs: dict[str, float]) -> xr.Dataset:
    """Return the uncertainty of each result due to relative uncertainties of independent inputs.

    Parameters
    ----------
    solved : Dataset
        the result, as of `log_slopes`.
    inputs : dict
        input -> expanded relative uncertainty (95 %).

    Returns
    -------
    Dataset
        along `load`, `{name}`, `{name}_down` and `{name}_up`: half-widths of the 95 % interval, in the unit
        of the quantity.

    References
    ----------
    JCGM 100:2008, Guide to the expression of uncertainty in measurement, 5.1.

    Examples
    --------
    >>> import xarray as xr
    >>> solved = xr.Dataset({name: ("load", [0.01, 0.02]) for name in QUANTITIES})
    >>> solved["mean_pressure"] = ("load", [1.0, 2.0])
    >>> found = scaling_uncertainty(solved, {"contact_modulus": 0.05})
    >>> (found["relative_contact_area"] / solved["relative_contact_area"]).values.round(3).tolist()
    [0.051, 0.051]
    """
    squares: dict[str, np.ndarray] = {}
    slopes = log_slopes(solved)
    inputs = {source: width for source, width in inputs.items() if source not in _set_aside(solved)}
    for source, width in inputs.items():
        for name, sensitivity in _sensitivities(slopes, source).items():
            squares[name] = squares.get(name, 0.0) + (width * sensitivity) ** 2
    logarithms = {name: np.sqrt(square) for name, square in squares.items()}
    relative_load = inputs.get("mean_pressure", 0.0)
    return half_widths(solved, {name: (w, w) for name, w in logarithms.items()}, relative_load=relative_load)


def half_widths(
    solved: xr.Dataset,
    logarithms: dict[str, tuple[np.ndarray, np.ndarray]],
    *,
    relative_load: float = 0.0,
    ending: str = "",
) -> xr.Dataset:
    """Return half-widths in the unit of each result from those of its logarithm.

    Parameters
    ----------
    solved : Dataset
        the result: quantities along `load`, with `mean_pressure`.
    logarithms : dict
        quantity -> half-widths (load) below and above, of ln Q; of the area those of ln erfinv(A). The
        pressure in contact is the load over the area.
    relative_load : float
        relative uncertainty of the load, which counts for the pressure in contact by itself.
    ending : str
        inserted into the names: `{name}{ending}_down`.

    Returns
    -------
    Dataset
        along `load`: `{name}{ending}_down` and `{name}{ending}_up`, and `{name}`, the larger one.

    Examples
    --------
    >>> import numpy as np, xarray as xr
    >>> solved = xr.Dataset({"mean_gap": ("load", [2.0]), "mean_pressure": ("load", [1.0])})
    >>> found = half_widths(solved, {"mean_gap": (np.array([0.0]), np.log([1.5]))})
    >>> found["mean_gap_down"].item(), found["mean_gap_up"].item()
    (0.0, 1.0)
    """
    widths: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for name, (down, up) in logarithms.items():
        value = solved[name].values
        if name == AREA:
            x = effort(value)
            low, high = (scipy.special.erf(x * np.exp(change)) for change in (-down, up))
            # where nothing changes, erf and erfinv leave a rounding error of either sign
            widths[name] = (
                np.where(np.equal(down, 0), 0.0, np.maximum(value - low, 0.0)),
                np.where(np.equal(up, 0), 0.0, np.maximum(high - value, 0.0)),
            )
            widths[PRESSURE] = _pressure_half_widths(solved, *widths[name], relative_load)
        else:
            with np.errstate(over="ignore"):
                factor = np.expm1(up)
            widths[name] = -value * np.expm1(-down), _product(value, factor)
    found: dict[str, tuple[str, np.ndarray]] = {}
    for name, (down, up) in widths.items():
        found |= {f"{name}{ending}_down": ("load", down), f"{name}{ending}_up": ("load", up)}
        found[name] = ("load", np.maximum(down, up))
    return xr.Dataset(found)


def _pressure_half_widths(
    solved: xr.Dataset, down: np.ndarray, up: np.ndarray, relative_load: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the half-widths of the pressure in contact, the load over either end of the area."""
    area, pressure = solved[AREA].values, solved[PRESSURE].values
    area = np.where(area > 0, area, 1.0)
    with np.errstate(divide="ignore"):
        above = np.where(area > down, down / (area - down), np.inf)
    below = up / (area + up)
    return pressure * np.hypot(below, relative_load), pressure * np.hypot(above, relative_load)


def _product(value: np.ndarray, factor: np.ndarray) -> np.ndarray:
    """Return the product; zero times infinity is zero."""
    with np.errstate(over="ignore"):
        return value * np.where(value == 0, 0.0, factor)
