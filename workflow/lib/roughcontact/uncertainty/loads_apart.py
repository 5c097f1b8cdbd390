"""What changes with the load only little by little is not asked at every one of many loads.

A few of them are chosen; what was found there is carried over to the others as a share of the quantity.
"""

from itertools import pairwise

import numpy as np

_FAR = 4.0  # of two loads between which all are left out: the larger over the smaller
_MOSTLY_CLOSED = 0.5  # share of contact beyond which no load is left out, as the gap closes quickly there


def loads_apart(load: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return which loads are to be asked, so that all others lie between two of them that are not far apart.

    Parameters
    ----------
    load : array (n,), Pa
        in any order.
    share : array (n,)
        of the area that is in contact at each.

    Returns
    -------
    array of int
        indices in ascending order: the least and the largest load, all beyond half of the area in contact,
        and as few others as leave no ratio above 4 between those with loads left out between them.

    Examples
    --------
    >>> load = np.array([1.0, 2.0, 4.0, 8.0, 100.0])
    >>> loads_apart(load, load / 200)
    array([0, 2, 3, 4])
    """
    order = np.argsort(load)
    chosen = [order[0]]
    for index, after in pairwise(order[1:]):
        if load[after] > _FAR * load[chosen[-1]] or share[after] > _MOSTLY_CLOSED:
            chosen.append(index)
    return np.sort([*chosen, *order[1:][-1:]])


def interpolated(found: np.ndarray, chosen: np.ndarray, load: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Return what was found at some loads for all of them, for what is smooth over the load.

    Parameters
    ----------
    found : array (m,)
        at the chosen loads, in the unit of the quantity.
    chosen : array (m,) of int
        what `loads_apart` returns.
    load : array (n,), Pa
    value : array (n,)
        the quantity at each load, above zero.

    Returns
    -------
    array (n,)
        the shares of the quantity are linear over the logarithm of the load; NaN beside one that is NaN.

    Examples
    --------
    >>> interpolated(np.array([0.1, 0.6]), np.array([0, 2]), np.array([1.0, 2.0, 4.0]), np.array([1, 2, 3]))
    array([0.1, 0.3, 0.6])
    """
    by_load = np.argsort(load[chosen])
    order = chosen[by_load]
    return value * np.interp(np.log(load), np.log(load[order]), found[by_load] / value[order])


def largest_beside(
    found: np.ndarray, chosen: np.ndarray, load: np.ndarray, value: np.ndarray, *, own: bool = False
) -> np.ndarray:
    """Return what was found at some loads for all of them, for what may be small at one of them by chance.

    Parameters
    ----------
    found : array (m,)
        at the chosen loads, in the unit of the quantity.
    chosen : array (m,) of int
        what `loads_apart` returns.
    load : array (n,), Pa
    value : array (n,)
        the quantity at each load.
    own : bool
        whether a chosen load keeps what was found there.

    Returns
    -------
    array (n,)
        the largest share of the quantity at the two chosen loads on each side, of which a chosen load itself
        is the first; NaN where the first is NaN on one side.

    Examples
    --------
    >>> chosen, load, value = np.array([0, 2]), np.array([1.0, 2.0, 4.0]), np.array([1.0, 2.0, 3.0])
    >>> largest_beside(np.array([0.1, 0.6]), chosen, load, value)
    array([0.2, 0.4, 0.6])
    >>> largest_beside(np.array([0.1, 0.6]), chosen, load, value, own=True)
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
    """Return value over base, and 1 where there is no base above zero.

    Parameters
    ----------
    value, base : array
        the latter of the shape of the result.

    Returns
    -------
    array

    Examples
    --------
    >>> ratio(np.array([3.0, 3.0]), np.array([2.0, 0.0]))
    array([1.5, 1. ])
    """
    return np.divide(value, base, out=np.ones(base.shape), where=base > 0)
