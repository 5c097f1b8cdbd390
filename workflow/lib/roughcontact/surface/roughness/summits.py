"""Summits of a periodic map: their statistics, and one that stands out."""

import math
from itertools import product

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions, spacing
from roughcontact.arguments.si import as_si
from roughcontact.kernels import fourier
from roughcontact.kernels.arrays import DOUBLE
from roughcontact.kernels.fft import make_plan

_SUMMIT, _SPIKE = (3, 15), (1, 9)  # points along each side: of the mean at the top, and around it
_COMPARED = 40  # highest summits whose heights say how far the first may be above the second


@as_si
def summit_statistics(height: xr.DataArray) -> dict[str, float]:
    """Return density (1/m^2), mean radius, height std and mean height (m) of a periodic map's summits.

    A summit is a point higher than its eight neighbours, its curvature -(h_xx + h_yy) / 2, spectral
    (Greenwood and Williamson 1966, Proc. R. Soc. A 295, 300); all are NaN for a profile, and the last three
    without summits.
    """
    names = ("density", "mean_radius", "height_std", "mean_height")
    if dimensions(height.shape) == 1:
        return dict.fromkeys(names, math.nan)
    values = height.values.astype(float)
    values -= values.mean()
    summit = _is_summit(values)
    count = int(summit.sum())
    dy, dx = spacing(height)
    result = dict.fromkeys(names, math.nan) | {"density": count / (values.size * dy * dx)}
    if count:
        heights = values[summit]
        result |= {"height_std": float(heights.std()), "mean_height": float(heights.mean())}
        qy, qx = fourier.wavevectors(values.shape, (dy, dx))
        plan = make_plan(values, DOUBLE)
        spectrum = plan.forward(values)
        # half of the Laplacian in place: no second spectrum of a large map
        for row, along_y in enumerate(qy[:, 0]):
            spectrum[row] *= (along_y**2 + qx[0] ** 2) / 2
        plan.inverse(spectrum, values)
        # positive at a summit, as the curvature of a ball is
        result["mean_radius"] = float(1 / values[summit].mean())
    return result


@as_si
def summit_that_stands_out(height: xr.DataArray, *, images: int = 1) -> dict[str, float]:
    """Return the summit or spike farthest above its surroundings in a periodic map (m), and the chance of it.

    The spacings of the highest of many heights, the i-th times i, are exponential and independent (Rényi
    1953, Acta Math. Acad. Sci. Hung. 4, 191); the first one over the sum of the others tells by what chance
    the highest is as far above the next (Likeš 1967, Metrika 11, 46). `summit_over_next` is infinite without
    another; the position is in m. `images` is the number of mirror images along each axis that make up the
    map, of which one is searched.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> bumps = np.zeros((64, 64))
    >>> bumps[20, 40], bumps[50, 10], bumps[50, 40] = 3.0, 2.0, 1.0
    >>> found = summit_that_stands_out(height_map(bumps, 1e-6))
    >>> round(found["summit_over_next"], 12), round(found["summit_chance"], 12)
    (1.5, 0.666666666667)
    """
    values = height.values.astype(float, copy=False)
    rankings = [_highest(values, *sides, images) for sides in (_SUMMIT, _SPIKE)]
    if not all(heights[0] for heights, _ in rankings):  # fewer than one summit: a flat map
        return {}
    chance, inverse, position = min(
        (_chance(heights), heights[1] / heights[0], candidate) for heights, candidate in rankings
    )
    return {
        "summit_chance": chance,
        "summit_over_next": 1 / inverse if inverse else math.inf,
        **{f"summit_{axis}": float(height[axis][i]) for axis, i in zip("yx", position, strict=True)},
    }


def _highest(values: np.ndarray, top: int, around: int, images: int) -> tuple[list[float], tuple[int, ...]]:
    """Return the greatest heights of tops above their surroundings, 0 where there are no more.

    With them comes the place of the first.
    """
    from scipy.ndimage import uniform_filter

    above = uniform_filter(values, top, mode="wrap") - uniform_filter(values, around, mode="wrap")
    # a mirrored map has each summit several times
    above = above[tuple(slice(max(n // images, 1)) for n in above.shape)]
    rounding = 1e-12 * float(np.abs(values).max(initial=0.0))
    reach = np.arange(-(around // 2), around // 2 + 1)
    heights = np.zeros(_COMPARED)
    first: tuple[int, ...] = ()
    for rank in range(_COMPARED):
        position = tuple(map(int, np.unravel_index(above.argmax(), above.shape)))
        if not above[position] > rounding:
            break
        heights[rank], first = above[position], first or position
        # its neighbourhood is one summit
        above[np.ix_(*((i + reach) % n for i, n in zip(position, above.shape, strict=True)))] = -np.inf
    return heights.tolist(), first


def _chance(heights: list[float]) -> float:
    """Return the chance that the first of an exponential tail is as far above the second."""
    tail = [height for height in heights if height]
    if len(tail) < 3:
        return float(len(tail) - 1)  # alone, or one of two, of which neither stands out
    # spacings of an exponential tail, times their rank, are alike (Rényi)
    spacings = np.arange(1, len(tail)) * -np.diff(tail)
    remaining = float(spacings[1:].sum())
    return (1 + float(spacings[0]) / remaining) ** -(len(tail) - 2) if remaining else float(spacings[0] == 0)


def _is_summit(values: np.ndarray) -> np.ndarray:
    """Return the mask of points higher than their eight neighbours; of equal neighbours one counts."""
    (ny, nx), around = values.shape, np.pad(values, 1, mode="wrap")
    summit = np.ones(values.shape, dtype=bool)
    for y, x in product(range(3), repeat=2):
        neighbour = around[y : y + ny, x : x + nx]
        if (y, x) < (1, 1):
            summit &= values > neighbour
        elif (y, x) > (1, 1):
            summit &= values >= neighbour
    return summit
