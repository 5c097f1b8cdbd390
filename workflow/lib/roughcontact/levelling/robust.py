"""Robust statistics: the scale of residuals and the weight of each."""

import numpy as np

# Tukey's biweight gives 95 % of the efficiency of least squares on normal residuals with this many standard
# deviations (Holland, Welsch, Comm. Statist. A6 (1977) 813).
_BIWEIGHT = 4.685


def robust_scale(residual) -> float:
    """Return the standard deviation of normal residuals, from the median of their absolute values."""
    return 1.4826 * float(np.median(np.abs(residual)))


def biweight(residual, scale) -> np.ndarray:
    """Return Tukey's biweight (1 - (r / (4.685 s))^2)^2 of each residual, 0 beyond 4.685 s."""
    return np.maximum(1 - (residual / (_BIWEIGHT * scale)) ** 2, 0) ** 2
