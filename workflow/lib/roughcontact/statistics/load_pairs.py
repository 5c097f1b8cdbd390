"""Which loads of two results are the same, and results at loads between: one rule for all comparisons.

Loads are paired by what they are, never by their order: by mean pressure, or relative to E* g where more of
them agree so, the rest by the other of both. Two are the same where they agree to a thousandth: an area is
nearly proportional to its load, and no interval of one is as narrow. Only where all results have the same
stated loads, which targets turn into other pressures, are they taken as they were stated.
"""

from collections.abc import Sequence
from itertools import chain

import numpy as np
import numpy.typing as npt
import scipy
import xarray as xr

from roughcontact.arguments.answers import GAP
from roughcontact.arguments.quantities import quantity
from roughcontact.errors import SettingsError
from roughcontact.statistics.kinds import facts_of_numbers

SAME_LOAD = 1e-3  # relative
_STIFFNESSES = "loading_stiffness", "contact_stiffness"
OF_SLOPE = *_STIFFNESSES, f"{GAP}_as_solved"  # that of the gap over the load


def paired_loads(
    dataset: xr.Dataset, counterpart: xr.Dataset, *, as_stated: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of the loads of two results that belong together, in the order of the first.

    With `as_stated` equally many loads are paired by `place`, that of a load among the stated ones. Without
    a relative pressure that over E* counts.

    Examples
    --------
    >>> steel, rubber = (xr.Dataset({"mean_pressure": ("load", loads)}) for loads in ([1.0, 2.0], [2.0, 4.0]))
    >>> [indices.tolist() for indices in paired_loads(steel, rubber)]
    [[1], [0]]
    >>> moduli = {"contact_modulus": 10.0}, {"contact_modulus": 20.0}
    >>> both = [data.assign(modulus) for data, modulus in zip((steel, rubber), moduli)]
    >>> [indices.tolist() for indices in paired_loads(*both)]
    [[0, 1], [0, 1]]
    """
    both = dataset, counterpart
    pascals = [data["mean_pressure"].values for data in both]
    if as_stated and pascals[0].size == pascals[1].size:
        first, second = (np.argsort(data.get("place", data["mean_pressure"]).values) for data in both)
        return first, second
    # loads that are equal in Pa, or in units of E*: the sort of which more are equal counts first
    relative = [
        np.asarray(data.get("relative_pressure", load / float(data.get("contact_modulus", np.nan))))
        for data, load in zip(both, pascals, strict=True)
    ]
    equal_loads = [np.argwhere(same_load(a[:, None], b)).tolist() for a, b in (pascals, relative)]
    partners: dict[int, int] = {}
    for index, partner in chain(*sorted(equal_loads, key=len, reverse=True)):
        if index not in partners and partner not in partners.values():
            partners[index] = partner
    ordered = sorted(partners)
    return np.array(ordered, int), np.array([partners[index] for index in ordered], int)


def same_load(loads: np.ndarray, reference: np.ndarray | float) -> np.ndarray:
    """Return which loads are the same; NaN is none.

    Examples
    --------
    >>> same_load(np.array([1.0, 1.0005, 2.0, np.nan]), 1.0).tolist()
    [True, True, False, False]
    """
    return np.isclose(loads, reference, rtol=SAME_LOAD, atol=0.0)


def common_loads(label: str, names: Sequence[str], datasets: Sequence[xr.Dataset]) -> np.ndarray:
    """Return the loads (Pa, rising) at which all maps are known, some of them by interpolation."""
    map_loads = [data["mean_pressure"].values.astype(float) for data in datasets]
    low, high = max(value[0] for value in map_loads), min(value[-1] for value in map_loads)
    if low > high * (1 + SAME_LOAD):  # the maps have no range in common
        lowest = names[[value[0] for value in map_loads].index(low)]
        last = names[[value[-1] for value in map_loads].index(high)]
        raise SettingsError(
            f"{label}: no load in common, {lowest} begins at {quantity(low, 'Pa', digits=5)} and {last} ends "
            f"at {quantity(high, 'Pa', digits=5)}; solve them at the same mean_pressure, or at more loads"
        )
    all_loads = np.sort(np.concatenate(map_loads))
    all_loads = all_loads[(all_loads >= low * (1 - SAME_LOAD)) & (all_loads <= high * (1 + SAME_LOAD))]
    distinct = all_loads[np.r_[True, np.diff(all_loads) > SAME_LOAD * all_loads[:-1]]]
    # as many loads as the map with most of them has: more would be interpolated from too few
    limit = max(value.size for value in map_loads)
    if distinct.size <= limit:
        return distinct
    solved_by_all = np.all([same_load(distinct[:, None], value).any(axis=1) for value in map_loads], axis=0)
    # those that some map was solved at: of states far apart, as first yield and a target, no curve is known
    spread = np.linspace(0, distinct.size - 1, limit).round().astype(int)
    return distinct[np.union1d(np.flatnonzero(solved_by_all), spread)]


def widest_step(map_loads: np.ndarray, loads: np.ndarray) -> float:
    """Return the ratio of the loads of a map, rising, between which others lie; the largest, 1 for none.

    Examples
    --------
    >>> widest_step(np.array([1.0, 10.0, 20.0]), np.array([10.0, 15.0]))
    2.0
    """
    between = loads[~same_load(loads[:, None], map_loads).any(axis=1)]
    above = np.clip(np.searchsorted(map_loads, between), 1, map_loads.size - 1)
    return float((map_loads[above] / map_loads[above - 1]).max(initial=1.0))


def loads_reaching(goals: npt.ArrayLike, loads: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the loads at which a number that rises with them first reaches goals; NaN beyond the loads.

    Between two loads it is the power law through both.

    Examples
    --------
    >>> loads_reaching([3.0, 5.0], np.array([1.0, 4.0]), np.array([2.0, 4.5])).round(2)
    array([ 2., nan])
    """
    order = np.argsort(loads)
    loads, values = loads[order], values[order]
    # where it falls, what lower loads have reached counts
    is_record = np.append(True, values[1:] > np.maximum.accumulate(values)[:-1])
    with np.errstate(divide="ignore"):  # of a number that is zero at all loads
        logarithms = np.log(goals), np.log(values[is_record]), np.log(loads[is_record])
    return np.exp(np.interp(*logarithms, left=np.nan, right=np.nan))


def slopes_of(name: str, data: xr.Dataset) -> np.ndarray | None:
    """Return d ln(mean gap)/d ln(load) of a map, by its stiffness (load); None of any other number.

    That of a body of finite size is of its approach.
    """
    stiffnesses = [data[key].values for key in _STIFFNESSES if key in data]
    if name != GAP or not stiffnesses or facts_of_numbers(data).own_numbers:
        return None
    gap = data.get(f"{GAP}_as_solved", data[GAP]).values
    with np.errstate(divide="ignore", invalid="ignore"):  # of a closed gap
        return -data["mean_pressure"].values / (stiffnesses[0] * gap)


def interpolated(
    map_loads: np.ndarray, loads: np.ndarray, values: np.ndarray, slopes: np.ndarray | None = None
) -> np.ndarray:
    """Return numbers (load, ...), known at a map's own rising loads, at others within their range.

    Else they are interpolated (monotone cubic in the logarithm, with the `slopes` in it that are known); NaN
    or infinite, where a neighbour is.

    Examples
    --------
    >>> interpolated(np.array([1.0, 100.0]), np.array([1.0, 10.0]), np.array([2.0, 4.0]))
    array([2., 3.])
    """
    nearest = np.abs(map_loads[None, :] - loads[:, None]).argmin(axis=1)
    if same_load(map_loads[nearest], loads).all():
        return values[nearest]
    finite, logarithms = np.isfinite(values), np.log(map_loads)
    numbers = np.where(finite, values, 0.0)
    inside = np.clip(np.log(loads), *logarithms[[0, -1]])  # up to rounding
    curve = scipy.interpolate.PchipInterpolator(logarithms, numbers)
    if slopes is not None:
        # up to three times the chords beside it the curve is monotone (Fritsch and Carlson 1980)
        chords = np.pad(np.abs(np.diff(numbers) / np.diff(logarithms)), 1, constant_values=np.inf)
        steepest = 3 * np.minimum(chords[:-1], chords[1:])
        slopes = np.where(np.isfinite(slopes), slopes, curve(logarithms, 1)).clip(-steepest, steepest)
        curve = scipy.interpolate.CubicHermiteSpline(logarithms, numbers, slopes)
    next_index = np.clip(np.searchsorted(map_loads, loads), 1, map_loads.size - 1)
    # what is not finite at a neighbour is not finite between
    unknown = np.where(finite, 0.0, values)  # 0, NaN or infinite
    return curve(inside) + unknown[next_index] + unknown[next_index - 1]
