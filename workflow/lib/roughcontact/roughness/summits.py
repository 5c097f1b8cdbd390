"""Summits of a periodic map: their statistics, and one that stands out."""

import math

import numpy as np
import xarray as xr

from roughcontact import fourier
from roughcontact.kernels.arrays import DOUBLE
from roughcontact.kernels.fft import make_plan
from roughcontact.maps import spacing

_POINTS_PER_BLOCK = 2**16  # few enough to stay in the cache
_SUMMIT, _SPIKE = (3, 15), (1, 9)  # points along each side: of the mean at the top, and around it


def summit_statistics(height: xr.DataArray) -> dict[str, float]:
    """Return the summit statistics of a periodic map (m) for the model of Greenwood and Williamson [1]_.

    A summit is a point higher than its eight neighbours, with periodic boundaries; its curvature is the
    spectral mean curvature -(h_xx + h_yy) / 2 at the point.

    Returns
    -------
    dict of float
        `density` (m^-2), `mean_radius` (m, 1 / mean curvature), `height_std` (m, standard deviation of the
        summit heights), `mean_height` (m, above the mean plane). All are NaN for a profile, and the last
        three without summits.

    References
    ----------
    .. [1] Greenwood, J. A., Williamson, J. B. P. (1966), Proc. R. Soc. A 295, 300.

    Examples
    --------
    >>> from roughcontact.references.synthetic import product_wave_surface
    >>> wave = product_wave_surface((64, 64), 1.0, amplitude=1.0, wavelength=64.0)
    >>> found = summit_statistics(wave)  # two crests, of the radius (64 / (2 pi))^2
    >>> round(found["density"] * 64**2, 6), round(found["mean_radius"] * (2 * math.pi / 64) ** 2, 6)
    (2.0, 1.0)
    """
    names = ("density", "mean_radius", "height_std", "mean_height")
    if min(height.shape) == 1:
        return dict.fromkeys(names, math.nan)
    values = height.values - height.values.mean()
    summit = _is_summit(values)
    count = int(summit.sum())
    dy, dx = spacing(height)
    result = dict.fromkeys(names, math.nan) | {"density": count / (values.size * dy * dx)}
    if count:
        heights = values[summit]
        qy, qx = fourier.wavevectors(values.shape, (dy, dx))
        plan = make_plan(values, DOUBLE)
        spectrum = plan.forward(values)
        for row, along_y in enumerate(qy[:, 0]):
            spectrum[row] *= (along_y**2 + qx[0] ** 2) / 2
        plan.inverse(spectrum, values)
        result["mean_radius"] = float(1 / values[summit].mean())
        result["height_std"] = float(heights.std())
        result["mean_height"] = float(heights.mean())
    return result


def summit_that_stands_out(height: xr.DataArray, *, images: int = 1) -> dict[str, float]:
    """Return the summit highest above its surroundings, and how much higher than the next one it is.

    The height of a summit is the mean of 3 x 3 points less that of the 15 x 15 points around, the height of a
    spike a point less the mean of the 9 x 9 points around.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.
    images : int
        number of mirror images along each axis that make up the map, of which one is searched.

    Returns
    -------
    dict
        `summit_over_next`, the ratio of the heights of the two highest summits that do not overlap, infinite
        where there is no second one; `spike_over_next`, the same of spikes; `summit_x`, `summit_y` (m), the
        place of that with the larger ratio. Empty for a map without summits.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map
    >>> bumps = np.zeros((64, 64))
    >>> bumps[20, 40], bumps[50, 10] = 3.0, 2.0
    >>> round(summit_that_stands_out(height_map(bumps, 1e-6))["summit_over_next"], 12)
    1.5
    """
    values = height.values.astype(float, copy=False)
    summit, spike = (_over_next(values, *sides, images) for sides in (_SUMMIT, _SPIKE))
    if not summit[0]:
        return {}
    _, place = max(summit, spike)
    y, x = (float(height[axis][i]) for axis, i in zip(("y", "x"), place, strict=True))
    return {"summit_over_next": summit[0], "spike_over_next": spike[0], "summit_x": x, "summit_y": y}


def _over_next(values: np.ndarray, top: int, around: int, images: int) -> tuple[float, tuple[int, ...]]:
    """Return how much higher above its surroundings the highest top is than the next, and its place.

    0 for a map without any.
    """
    from scipy.ndimage import uniform_filter

    above = uniform_filter(values, top, mode="wrap") - uniform_filter(values, around, mode="wrap")
    above = above[tuple(slice(max(n // images, 1)) for n in above.shape)]
    place = tuple(int(i) for i in np.unravel_index(above.argmax(), above.shape))
    highest, rounding = float(above[place]), 1e-12 * float(np.abs(values).max(initial=0.0))
    if not highest > rounding:
        return 0.0, place
    reach = np.arange(-(around // 2), around // 2 + 1)
    above[np.ix_(*((i + reach) % n for i, n in zip(place, above.shape, strict=True)))] = -np.inf
    following = float(above.max())
    return highest / following if following > rounding else math.inf, place


def _is_summit(values: np.ndarray) -> np.ndarray:
    """Return the mask of points higher than their eight neighbours; of equal neighbours one counts."""
    (ny, nx), step = values.shape, max(1, _POINTS_PER_BLOCK // values.shape[1])
    summit = np.ones(values.shape, dtype=bool)
    columns = np.arange(-1, nx + 1) % nx
    for start in range(0, ny, step):
        own = summit[start : start + step]
        around = values[np.arange(start - 1, start + len(own) + 1) % ny][:, columns]
        middle = around[1:-1, 1:-1]
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                neighbour = around[1 - dy : len(own) + 1 - dy, 1 - dx : nx + 1 - dx]
                if (dy, dx) > (0, 0):
                    own &= middle > neighbour
                elif (dy, dx) < (0, 0):
                    own &= middle >= neighbour
    return summit
