"""Robust statistics: scale and weights of residuals, medians of rows."""

import numpy as np

# Limit in standard deviations for which Tukey's biweight has 95 % of the efficiency of least squares on
# normal residuals (Holland, Welsch, Comm. Statist. A6 (1977) 813).
_BIWEIGHT = 4.685


def robust_scale(residual: np.ndarray, *, overwrite: bool = False) -> float:
    """Return 1.4826 times the median absolute residual (Davies and Gather 1993, J. Am. Stat. Assoc. 88, 782).

    This is the standard deviation of normal residuals; `overwrite` saves memory by overwriting them.

    Examples
    --------
    >>> import numpy as np
    >>> robust_scale(np.array([-1.0, 0.5, 1.0, 100.0]))
    1.4826
    """
    sizes = np.abs(residual, out=residual if overwrite else None)
    return 1.4826 * float(np.median(sizes, overwrite_input=True))


def biweight(residual: np.ndarray, scale: float) -> np.ndarray:
    """Return Tukey's biweight (1 - (r / (4.685 s))^2)^2 of residuals r of scale s, 0 beyond 4.685 s.

    Beaton and Tukey (1974), Technometrics 16, 147; Holland and Welsch (1977), Comm. Stat. A 6, 813, for the
    constant.

    Examples
    --------
    >>> import numpy as np
    >>> print(np.round(biweight(np.array([0.0, 1.0, 4.685, 9.0]), 1.0), 3))
    [1.    0.911 0.    0.   ]
    """
    weights = np.asarray(residual / (_BIWEIGHT * scale))
    np.square(weights, out=weights)
    np.subtract(1, weights, out=weights)
    np.maximum(weights, 0, out=weights)
    return np.square(weights, out=weights)


def row_medians(values: np.ndarray, *, empty: float = np.nan) -> np.ndarray:
    """Return the median (ny,) of each row over its measured points; `empty` of rows without.

    Examples
    --------
    >>> import numpy as np
    >>> row_medians(np.array([[1.0, np.nan, 3.0], [np.nan, np.nan, np.nan]]), empty=0.0)
    array([2., 0.])
    """
    medians = np.full(len(values), empty)
    has_points = ~np.isnan(values).all(axis=1)
    medians[has_points] = np.nanmedian(values[has_points], axis=1)
    return medians
