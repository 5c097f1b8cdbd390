"""Height parameters of a levelled map, periodic or not."""

import math

import numpy as np
import xarray as xr

from roughcontact.maps import spacing


def height_parameters(height: xr.DataArray) -> dict[str, float]:
    """Return the height parameters of ISO 25178-2, and Sdq, of a levelled map that need not be periodic.

    With z the height above the mean of all measured points:

    * `Sa` = mean |z|, `Sq` = sqrt(mean z^2), m
    * `Ssk` = mean z^3 / Sq^3, `Sku` = mean z^4 / Sq^4; NaN for a flat map
    * `Sp` = max z, `Sv` = -min z, `Sz` = Sp + Sv, m
    * `Sdq` = sqrt(mean (dz/dx)^2 + mean (dz/dy)^2) with the differences of neighbouring points, each
      direction averaged over its own pairs of measured points. It depends on the pitch
      (`parameters.rms_gradient` is spectral).

    Parameters
    ----------
    height : DataArray (y, x), m
        NaN where missing; such points do not count.

    Returns
    -------
    dict of float
        `Sa`, `Sq`, `Sp`, `Sv`, `Sz` in m, the others without unit.

    References
    ----------
    .. [1] ISO 25178-2:2021, 4.1 and 4.2.

    Examples
    --------
    >>> from roughcontact.maps import height_map
    >>> found = height_parameters(height_map([[1.0, -1.0, 1.0, -1.0]], 0.5))
    >>> [found[name] for name in ("Sa", "Sq", "Ssk", "Sku", "Sz", "Sdq")]
    [1.0, 1.0, 0.0, 1.0, 2.0, 4.0]
    """
    values = height.values
    z = values[~np.isnan(values)]
    z = z - z[0]  # exactly zero for a flat map, wherever it lies
    z -= z.mean()
    sq = math.sqrt(np.mean(z**2))
    slopes = 0.0
    for axis, pitch in enumerate(spacing(height)):
        steps = np.diff(values, axis=axis)
        steps = steps[~np.isnan(steps)]
        if steps.size:
            slopes += float(np.mean((steps / pitch) ** 2))
    return {
        "Sa": float(np.mean(np.abs(z))),
        "Sq": sq,
        "Ssk": float(np.mean((z / sq) ** 3)) if sq > 0 else math.nan,
        "Sku": float(np.mean((z / sq) ** 4)) if sq > 0 else math.nan,
        "Sp": float(z.max()),
        "Sv": float(-z.min()),
        "Sz": float(np.ptp(z)),
        "Sdq": math.sqrt(slopes),
    }
