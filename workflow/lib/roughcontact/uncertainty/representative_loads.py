"""Representative loads: quantities that vary slowly with the load are computed at a subset of the loads.

Their values relative to a known quantity are then transferred to the remaining loads.
"""

from itertools import pairwise

import numpy as np

_MAX_LOAD_RATIO = 4.0  # of two consecutive representative loads, where loads between them are skipped
_MAX_SPARSE_AREA = 0.5  # contact area above which no load is skipped, because the gap closes quickly there


def representative_loads(load: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return the indices of a subset of loads whose consecutive ratios are limited.

    Parameters
    ----------
    load : array (n,), Pa
        in any order.
    share : array (n,)
        relative contact area at each load.

    Returns
    -------
    array of int
        indices in ascending order: the smallest and the largest load, all loads above half of full contact,
        and as few others as keep the ratio of two consecutive representative loads at 4 or less wherever
        loads between them are skipped.

    Examples
    --------
    >>> load = np.array([1.0, 2.0, 4.0, 8.0, 100.0])
    >>> representative_loads(load, load / 200)
    array([0, 2, 3, 4])
    """
    order = np.argsort(load)
    chosen = [order[0]]
    for index, after in pairwise(order[1:]):
        if load[after] > _MAX_LOAD_RATIO * load[chosen[-1]] or share[after] > _MAX_SPARSE_AREA:
            chosen.append(index)
    return np.sort([*chosen, *order[1:][-1:]])


def interpolate_over_loads(
    found: np.ndarray, chosen: np.ndarray, load: np.ndarray, value: np.ndarray
) -> np.ndarray:
    """Return values at all loads, interpolated between the representative ones.

    Parameters
    ----------
    found : array (m,)
        values at the representative loads, in the unit of the reference quantity; they vary smoothly with
        the load.
    chosen : array (m,) of int
        indices of the representative loads, from `representative_loads`.
    load : array (n,), Pa
    value : array (n,)
        reference quantity at each load; where it is not positive, 1 is taken.

    Returns
    -------
    array (n,)
        the ratio to the reference quantity is linear in the logarithm of the load; NaN between two
        representative loads of which one is NaN.

    Examples
    --------
    >>> chosen, load, value = np.array([0, 2]), np.array([1.0, 2.0, 4.0]), np.array([1, 2, 3])
    >>> interpolate_over_loads(np.array([0.1, 0.6]), chosen, load, value)
    array([0.1, 0.3, 0.6])
    """
    by_load = np.argsort(load[chosen])
    order, base = chosen[by_load], np.where(value > 0, value, 1.0)
    return base * np.interp(np.log(load), np.log(load[order]), found[by_load] / base[order])


def maximum_of_neighbours(
    found: np.ndarray, chosen: np.ndarray, load: np.ndarray, value: np.ndarray, *, own: bool = False
) -> np.ndarray:
    """Return values at all loads, each the relative maximum over the neighbouring representative loads.

    The maximum is a safe choice for values that may be small at a single load by chance.

    Parameters
    ----------
    found : array (m,)
        values at the representative loads, in the unit of the reference quantity.
    chosen : array (m,) of int
        indices of the representative loads, from `representative_loads`.
    load : array (n,), Pa
    value : array (n,)
        reference quantity at each load.
    own : bool
        whether a representative load keeps its own value.

    Returns
    -------
    array (n,)
        the largest ratio to the reference quantity at the two nearest representative loads on each side,
        times the reference quantity; a representative load is its own nearest neighbour on both sides. NaN
        where a nearest neighbour is NaN.

    Examples
    --------
    >>> chosen, load, value = np.array([0, 2]), np.array([1.0, 2.0, 4.0]), np.array([1.0, 2.0, 3.0])
    >>> maximum_of_neighbours(np.array([0.1, 0.6]), chosen, load, value)
    array([0.2, 0.4, 0.6])
    >>> maximum_of_neighbours(np.array([0.1, 0.6]), chosen, load, value, own=True)
    array([0.1, 0.4, 0.6])
    """
    by_load = np.argsort(load[chosen])
    order = chosen[by_load]
    after = np.searchsorted(load[order], load)
    before = np.where(load[order[after]] > load, after - 1, after)
    sides = np.stack([before, after, before - 1, after + 1]).clip(0, order.size - 1)
    carried = found[by_load][sides] * ratio(value, value[order[sides]])
    largest = np.where(np.isnan(carried[:2]).any(axis=0), np.nan, np.fmax.reduce(carried))
    return np.where((before == after) & own, carried[0], largest)


def ratio(value: np.ndarray, base: np.ndarray) -> np.ndarray:
    """Return value / base, and 1 where base is not positive.

    Parameters
    ----------
    value, base : array
        `base` has the shape of the result.

    Returns
    -------
    array

    Examples
    --------
    >>> ratio(np.array([3.0, 3.0]), np.array([2.0, 0.0]))
    array([1.5, 1. ])
    """
    return np.divide(value, base, out=np.ones(base.shape), where=base > 0)
