"""Probability densities over logarithmic bins whose bounds do not depend on the loads."""

import numpy as np

PRESSURE_DECADES = (-3, 3)  # in units of E* g
GAP_DECADES = (-4, 0)  # in units of the peak-to-valley height, which no gap exceeds
PATCH_BINS = 5  # per factor of ten of the area of a patch, from one pixel on
PATCH_DECADES = (0, 9)  # up to more points than a map can have, so that the bins of all maps are as many
_BLOCK = 2**16  # values that are counted at a time: few enough to stay in the cache


def logarithmic_edges(decades: tuple[int, int], per_decade: int) -> np.ndarray:
    """Return the bounds of bins: 0, then `per_decade` per factor of ten between two powers of ten."""
    low, high = decades
    return np.concatenate([[0.0], 10.0 ** np.linspace(low, high, (high - low) * int(per_decade) + 1)])


def density(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the probability density of values in bins with rising `edges`; NaN where there are no values.

    Values beyond the bounds count in the first and last bin, those on a bound above it: it always integrates
    to 1.
    """
    if values.size == 0:
        return np.full(edges.size - 1, np.nan)
    inner, counts = edges[1:-1], np.zeros(edges.size - 1, int)
    # bounds by search: logarithms of all values would take longer
    for block in np.array_split(values.ravel(), -(-values.size // _BLOCK)):
        counts += np.bincount(np.searchsorted(inner, block, side="right"), minlength=counts.size)
    return counts / (values.size * np.diff(edges))
