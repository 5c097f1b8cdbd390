"""Summits of a periodic map."""

import math

import numpy as np
import xarray as xr

from roughcontact import fourier
from roughcontact.kernels.arrays import DOUBLE
from roughcontact.kernels.fft import make_plan
from roughcontact.maps import spacing

_POINTS_PER_BLOCK = 2**16  # few enough to stay in the cache


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
