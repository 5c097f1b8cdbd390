"""Growth of the roughness amplitude with the measured length.

A map contains waves up to its own length. The contribution of longer waves is extrapolated from the map and
its subwindows. Let S(l) be the mean deviation from the form (Sa) of squares of length l, each levelled
separately. A stationary surface has a constant S once l exceeds its longest wavelength, a self-affine surface
has S ~ l^H, a parabolic bow has S ~ l^2. With the slopes

    s1 = log2 S(L)/S(L/2),   s2 = log2 S(L/2)/S(L/4)

a surface e times as long as the map has e^a times its S, where a = s1 sqrt(s1/s2): the last slope,
extrapolated by its own trend. Because the slopes of a single map are noisy, only half of the logarithmic
trend is extrapolated (hence the root), and by at most a factor of sqrt(1.5).

S is the mean deviation rather than the rms deviation for two reasons: the mean gap is a mean height, and a
mean square is dominated by a few deep pits or high spikes, so that the growth of the remaining surface would
be masked by them.
"""

import json
import math

import numpy as np
import xarray as xr

from roughcontact.levelling.polynomial import fit_polynomial

_MAX_EXPONENT = 2.0  # exponent of a parabolic bow
_MIN_SLOPE = 0.02
_MAX_SLOPE_RATIO = 1.5  # upper limit of s1/s2
_MAX_POINTS_PER_SIDE = 256  # sufficient for the mean deviation, which long waves dominate


def growth_exponent(height: xr.DataArray) -> float:
    """Return the exponent a: a surface e times as long has e^a times the mean deviation of the map.

    Parameters
    ----------
    height : DataArray (y, x), m
        levelled, without missing points. Subwindows are levelled by a polynomial of the same order.

    Returns
    -------
    float, 0 to 2
        0 for a flat map and for a map much longer than its longest wavelength.

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
    steps = tuple(-(-n // _MAX_POINTS_PER_SIDE) for n in height.shape)
    values = height.values[:: steps[0], :: steps[1]]
    order = form_order(height)
    whole, half, quarter = (_mean_deviation(values, k, order) for k in (1, 2, 4))
    # smaller deviations are rounding errors
    if min(half, quarter) <= 1e-9 * whole:
        return 0.0
    last, before = math.log2(whole / half), max(math.log2(half / quarter), _MIN_SLOPE)
    if last <= 0:
        return 0.0
    return min(_MAX_EXPONENT, last * math.sqrt(min(last / before, _MAX_SLOPE_RATIO)))


def form_order(levelled: xr.DataArray) -> int:
    """Return the polynomial order that levels a subwindow as the whole map was levelled.

    Parameters
    ----------
    levelled : DataArray (y, x), m
        from `level`.

    Returns
    -------
    int
        0 where nothing or only the mean was subtracted; 1 for a plane; 2 for a sphere or a cylinder.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> form_order(rough_reference_surface(64).assign_attrs(form="sphere"))
    2
    """
    form = levelled.attrs.get("form", "plane")
    if form == "polynomial":
        # coefficients are named c_i_j; the record of a plane has slopes instead
        terms = (name.split("_") for name in json.loads(levelled.attrs["form_removed"]))
        return max((int(term[1]) + int(term[2]) for term in terms if term[0] == "c"), default=1)
    return {"none": 0, "mean": 0, "plane": 1}.get(form, 2)


def _mean_deviation(values: np.ndarray, cuts: int, order: int) -> float:
    """Return the mean deviation of half-overlapping subwindows 1/cuts as long, as an rms over them."""
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
