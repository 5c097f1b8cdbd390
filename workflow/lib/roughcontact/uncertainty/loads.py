"""Loads at which members of ensembles are solved, and their numbers at the others."""

import numpy as np

from roughcontact.uncertainty.scales import from_scale, to_scale


def few_loads(load: np.ndarray, most: int) -> np.ndarray:
    """Return the indices of at most so many loads: the ends, and those nearest to even steps of ln p between.

    Examples
    --------
    >>> few_loads(np.array([1.0, 2.0, 4.0, 8.0, 64.0]), 3)
    array([0, 3, 4])
    """
    logarithms = np.log(load)
    even = np.linspace(logarithms.min(), logarithms.max(), most)
    return (
        np.unique(np.abs(logarithms[:, None] - even).argmin(axis=0))
        if load.size > most
        else np.arange(load.size)
    )


def at_all_loads(values: np.ndarray, solved: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Return numbers at all loads from those at the loads of the indices `solved`, linear in ln p.

    NaN between two loads of which one is NaN.

    Examples
    --------
    >>> at_all_loads(np.array([0.1, 0.3]), np.array([0, 2]), np.array([1.0, 2.0, 4.0]))
    array([0.1, 0.2, 0.3])
    """
    order = solved[np.argsort(load[solved])]
    rank = np.argsort(load[solved])
    return np.interp(np.log(load), np.log(load[order]), np.asarray(values, float)[rank])


def carried_to_all_loads(
    name: str, values: np.ndarray, solved: np.ndarray, load: np.ndarray, result: np.ndarray
) -> np.ndarray:
    """Return a quantity of a member at all loads: its change from the result is interpolated on its scale.

    Parameters
    ----------
    values : array (solved,)
        of the member.
    solved : array of int
        indices of its loads.
    load, result : array (load,)
        mean pressures, Pa, and the quantity of the result.
    """
    if solved.size == load.size:
        return values
    own = to_scale(name, result)
    change = at_all_loads(to_scale(name, values) - own[solved], solved, load)
    return from_scale(name, own + change)
