"""How the heights of a surface grow with the length over which it is measured.

A map shows waves up to its own length. What longer ones add is told by the map and its parts: let S(l) be the
mean deviation from the form (Sa) of squares of the length l, each levelled by itself. A stationary surface
has S constant once l exceeds its waves, a self-affine one S ~ l^H, a bow l^2. With the slopes

    s1 = log2 S(L)/S(L/2),   s2 = log2 S(L/2)/S(L/4)

a surface e times as long as the map has e^a times its S, a = s1 sqrt(s1/s2): the last slope, and how it has
been changing. The slopes of a single map are noisy; that is why half of the change is carried on (the
root), by at most a factor of 1.5.

The mean deviation stands here for its square because the mean gap is a mean height, and because a few deep
pits or high spikes, which make up most of a mean square, hide in that how the rest grows.
"""

import json
import math

import numpy as np
import xarray as xr

from roughcontact.levelling.polynomial import fit_polynomial

_MOST = 2.0  # exponent of a bow
_LEAST_SLOPE = 0.02
_MOST_CHANGE = 1.5  # of the slope
_POINTS = 256  # along each side: mean deviations of long waves need no more


def growth_exponent(height: xr.DataArray) -> float:
    """Return the exponent a: a surface e times as long has e^a times the mean deviation of the map.

    Parameters
    ----------
    height : DataArray (y, x), m
        levelled, without missing points; parts are levelled by a polynomial of the same order.

    Returns
    -------
    float, 0 to 2
        0 for a map that is long against its waves, or flat.

    Examples
    --------
    >>> from roughcontact.references.synthetic import self_affine_surface, westergaard_surface
    >>> short = westergaard_surface((1, 256), 1.0, amplitude=1.0, wavelength=8.0)
    >>> growth_exponent(short.assign_attrs(form="plane"))
    0.0
    >>> bow = (short["x"] - 128.0) ** 2 + 0.0 * short
    >>> round(growth_exponent(bow.assign_attrs(form="plane")), 1)
    2.0
    """
    steps = tuple(-(-n // _POINTS) for n in height.shape)
    values = height.values[:: steps[0], :: steps[1]]
    order = form_order(height)
    whole, half, quarter = (_mean_deviation(values, k, order) for k in (1, 2, 4))
    # less than this is rounding
    if min(half, quarter) <= 1e-9 * whole:
        return 0.0
    last, before = math.log2(whole / half), max(math.log2(half / quarter), _LEAST_SLOPE)
    if last <= 0:
        return 0.0
    return min(_MOST, last * math.sqrt(min(last / before, _MOST_CHANGE)))


def form_order(levelled: xr.DataArray) -> int:
    """Return the order of the polynomial that levels a part of a map as the map was levelled.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.

    Returns
    -------
    int
        0 where only the mean was taken off, or nothing; 1 for a plane; 2 for a sphere or a cylinder.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> form_order(rough_reference_surface(64).assign_attrs(form="sphere"))
    2
    """
    form = levelled.attrs.get("form", "plane")
    if form == "polynomial":
        # the coefficients are called c_i_j; a plane has none, but slopes
        terms = (name.split("_") for name in json.loads(levelled.attrs["form_removed"]))
        return max((int(term[1]) + int(term[2]) for term in terms if term[0] == "c"), default=1)
    return {"none": 0, "mean": 0, "plane": 1}.get(form, 2)


def _mean_deviation(values: np.ndarray, cuts: int, order: int) -> float:
    """Return the mean deviation (rms over the parts) of parts 1/cuts long that overlap by half."""
    starts, sides = [], []
    for n in values.shape:
        side = max(1, n // cuts)
        sides.append(side)
        starts.append(np.linspace(0, n - side, 2 * cuts - 1 if n > 1 else 1).round().astype(int))
    coordinates = tuple(np.arange(side, dtype=float) for side in sides)
    squares = []
    for top in starts[0]:
        for left in starts[1]:
            part = values[top : top + sides[0], left : left + sides[1]]
            form, _ = fit_polynomial(part, coordinates, order=order)
            squares.append(np.mean(np.abs(part - form)) ** 2)
    return math.sqrt(np.mean(squares))
