"""Areal Gaussian filter of ISO 16610-61 for maps with edges and missing points.

A filter that removes short waves is an S-filter, one that removes long waves an L-filter (ISO 25178-3).
"""

from collections.abc import Sequence

import numpy as np

# alpha = sqrt(ln 2 / pi) of ISO 16610-61: 50 % transmission at the nesting index
_ALPHA_SQUARED = np.log(2) / np.pi
_CUTOFF = 1.25  # radius in nesting indices, where the weight has fallen to exp(-pi (1.25 / alpha)^2) = 2e-10
_REGULARISATION = 1e-11  # of the variance of the positions; sets undetermined slopes to zero


def gaussian_mean_surface(values: np.ndarray, spacing: Sequence[float], nesting_index: float) -> np.ndarray:
    """Return the mean surface (ny, nx; m) of a map by the areal Gaussian filter of ISO 16610-61:2015.

    The weight at the distance r is exp(-pi (r / (alpha lambda_c))^2), alpha^2 = ln 2 / pi. Near edges and
    holes (NaN) the local plane of Cleveland (1979, J. Am. Stat. Assoc. 74, 829) retains the moments, as of
    ISO 16610-28:2016.
    """
    is_measured = ~np.isnan(values)
    offset = float(values[is_measured].mean())
    # a large mean height would take the digits of the waves
    heights = np.where(is_measured, values - offset, 0.0)
    kernels = [_kernels(n, d, nesting_index) for n, d in zip(values.shape, spacing, strict=True)]
    if is_measured.all():
        # each moment of the weights is a product of one along y and one along x
        along_y, along_x = (
            [_correlate(np.ones((1, n)), kernel, axis=1)[0] for kernel in axis]
            for n, axis in zip(values.shape, kernels, strict=True)
        )
        moment = {(j, i): along_y[j][:, None] * along_x[i] for j, i in _MOMENTS}
    else:
        moment = _moments(is_measured.astype(float), kernels, _MOMENTS)
    # of the heights the mean and both first moments suffice for a local plane
    of_heights = _moments(heights, kernels, _MOMENTS[:3])

    weight = np.where(is_measured, moment[0, 0], 1.0)
    middle_y, middle_x = moment[1, 0] / weight, moment[0, 1] / weight
    mean = of_heights[0, 0] / weight
    # variances of the positions, and their covariances with the heights
    longest = max(n * d for n, d in zip(values.shape, spacing, strict=True))
    regularisation = _REGULARISATION * min(_ALPHA_SQUARED * nesting_index**2 / (2 * np.pi), longest**2 / 12)
    vyy = moment[2, 0] / weight - middle_y**2 + regularisation
    vxx = moment[0, 2] / weight - middle_x**2 + regularisation
    vxy = moment[1, 1] / weight - middle_y * middle_x
    cy = of_heights[1, 0] / weight - middle_y * mean
    cx = of_heights[0, 1] / weight - middle_x * mean
    determinant = np.where(is_measured, vyy * vxx - vxy**2, 1.0)
    slope_y = (vxx * cy - vxy * cx) / determinant
    slope_x = (vyy * cx - vxy * cy) / determinant
    smooth = mean - slope_y * middle_y - slope_x * middle_x + offset
    return np.where(is_measured, smooth, np.nan)


_MOMENTS = ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1))  # powers of y and x


def _kernels(points: int, pitch: float, nesting_index: float) -> list[np.ndarray]:
    """Return the weights along one axis, times the distance to the powers 0, 1, 2."""
    reach = min(points - 1, int(np.ceil(_CUTOFF * nesting_index / pitch)))
    distance = pitch * np.arange(-reach, reach + 1)
    weights = np.exp(-np.pi / _ALPHA_SQUARED * (distance / nesting_index) ** 2)
    return [weights * distance**power for power in range(3)]


def _correlate(field: np.ndarray, kernel: np.ndarray, *, axis: int) -> np.ndarray:
    """Return sum_k kernel[k] field[i + k] along an axis, with zeros beyond the border."""
    from scipy.signal import oaconvolve

    if kernel.size == 1:
        return field * kernel[0]
    reversed_kernel = kernel[::-1].reshape((-1, 1) if axis == 0 else (1, -1))
    return oaconvolve(field, reversed_kernel, mode="same", axes=axis)


def _moments(
    field: np.ndarray, kernels: list[list[np.ndarray]], powers: Sequence[tuple[int, int]]
) -> dict[tuple[int, int], np.ndarray]:
    """Return the sums of field times weight times y^j x^i over the surroundings of each point."""
    along_x = {i: _correlate(field, kernels[1][i], axis=1) for i in {i for _, i in powers}}
    return {(j, i): _correlate(along_x[i], kernels[0][j], axis=0) for j, i in powers}
