"""Summits of a periodic map."""

import math

import numpy as np
import xarray as xr

from roughcontact import fourier
from roughcontact.maps import spacing


def summit_statistics(height: xr.DataArray) -> dict[str, float]:
    """Return what the model of Greenwood and Williamson [1]_ asks about the summits of a map.

    A summit is a point higher than its eight neighbours, over the periodic boundary; its curvature is the
    spectral mean curvature -(h_xx + h_yy) / 2 there.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.

    Returns
    -------
    dict of float
        `density` (m^-2), `mean_radius` (m, 1 / mean curvature), `height_std` (m, standard deviation of the
        summit heights), `mean_height` (m, above the mean plane). A profile has no summits: all NaN; so are
        the last three where there is no summit.

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
        spectrum = np.fft.rfft2(values)
        spectrum *= fourier.wavenumbers(values.shape, (dy, dx)) ** 2 / 2
        curvature = np.fft.irfft2(spectrum, s=values.shape)[summit]
        result["mean_radius"] = float(1 / curvature.mean())
        result["height_std"] = float(values[summit].std())
        result["mean_height"] = float(values[summit].mean())
    return result


def _is_summit(values: np.ndarray) -> np.ndarray:
    """Return where a point is higher than its eight neighbours; of equal neighbours one counts."""
    summit = np.ones(values.shape, dtype=bool)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            neighbour = np.roll(values, (dy, dx), axis=(0, 1))
            if (dy, dx) > (0, 0):
                summit &= values > neighbour
            elif (dy, dx) < (0, 0):
                summit &= values >= neighbour
    return summit
