"""Means, intervals and tests of numbers (map, load) that scatter between parts and between their maps.

The model is y_ij = mean + part_i + map_ij, each load by itself, on a scale of symmetric scatter, the mean
that of the means of the parts: exact for equally many maps, else the approximation of Thomas and Hultquist
(1978, Ann. Statist. 6, 582) by the harmonic mean of their numbers (Burdick and Graybill 1992, Confidence
Intervals on Variance Components, chapter 4; Searle, Casella and McCulloch 1992, Variance Components, chapter
3; JCGM 100:2008, H.5).
"""

from bisect import bisect_left
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

COVERAGE = 0.95
SIGNIFICANCE = 0.05  # of a difference, over all that are tested together
POWER = 0.9  # with which the maps that are asked for would show the difference
_OUTLIER_SIGNIFICANCE = 0.01  # significance of an outlier, ISO 5725-2:1994, 7.3.4
_MAX_MAPS = 1000  # that are asked for


class Effects(NamedTuple):
    """Mean and scatter of numbers (load,), on their scale."""

    units: int  # what scatters independently: parts, or maps without parts of several
    mean: np.ndarray  # of the means of the parts
    error: np.ndarray  # standard uncertainty of the mean
    freedom: np.ndarray  # its degrees of freedom
    next_map: np.ndarray  # standard deviation about `mean` of the next map of another part
    next_map_freedom: np.ndarray
    next_part: np.ndarray  # of the mean of the next part, of as many maps; or NaN
    between: np.ndarray  # standard deviation between parts; NaN where unknown
    within: np.ndarray  # between the maps of a part; NaN where unknown


def random_effects(values: np.ndarray, part_names: Sequence[str]) -> Effects:
    """Return mean and scatter of the numbers of maps (map, load), each of a part."""
    names, index, counts = np.unique(np.asarray(part_names, str), return_inverse=True, return_counts=True)
    if names.size in (1, len(values)):  # nothing to tell parts from maps by
        index, counts = np.arange(len(values)), np.ones(len(values), int)
    averages = np.stack([values[index == label].mean(axis=0) for label in range(counts.size)])
    units, harmonic, mean = counts.size, float(1 / np.mean(1 / counts)), averages.mean(axis=0)
    freedom = np.full(values.shape[1], max(units - 1.0, 0.0))
    nan_values = np.full(values.shape[1], np.nan)
    scatter = averages.var(axis=0, ddof=1) if units > 1 else nan_values  # of the means of the parts
    next_part = scatter * (1 + 1 / units)
    next_map, of_map, between, within = next_part, freedom, np.sqrt(scatter), nan_values
    if names.size == 1:
        between, within = within, between
    if has_parts := bool(counts.max() > 1):
        within_freedom = len(values) - units
        residual = np.sum((values - averages[index]) ** 2, axis=0) / within_freedom
        map_variance = (1 - 1 / harmonic) * residual  # a single map scatters more than the mean of a part
        next_map = next_part + map_variance
        with np.errstate(invalid="ignore", divide="ignore"):
            # as of Satterthwaite, 1946
            of_map = next_map**2 / (next_part**2 / freedom + map_variance**2 / within_freedom)
        of_map = np.where(np.isfinite(of_map), of_map, freedom)
        between, within = np.sqrt(np.maximum(scatter - residual / harmonic, 0.0)), np.sqrt(residual)
    return Effects(
        units=units,
        mean=mean,
        error=np.sqrt(scatter / units),
        freedom=freedom,
        next_map=np.sqrt(next_map),
        next_map_freedom=of_map,
        next_part=np.sqrt(next_part) if has_parts else nan_values,
        between=between,
        within=within,
    )


def moderated(effects: Effects, scatter: np.ndarray, freedom: np.ndarray) -> Effects:
    """Return the effects of units whose scatter (load) is expected, which counts for some degrees of freedom.

    Expected and measured variances are averaged by their degrees of freedom, which add up: the moderated t of
    Smyth (2004, Stat. Appl. Genet. Mol. Biol. 3, 3).

    Examples
    --------
    >>> two = moderated(random_effects(np.array([[1.0], [3.0]]), "ab"), np.array([1.0]), np.array([3.0]))
    >>> [round(each.item(), 3) for each in (two.error, two.freedom, two.next_map)]
    [0.791, 4.0, 1.369]
    """
    total = effects.freedom + freedom
    variance = (effects.freedom * effects.error**2 * effects.units + freedom * scatter**2) / total
    next_map = np.sqrt(variance * (1 + 1 / effects.units))
    return effects._replace(
        error=np.sqrt(variance / effects.units), freedom=total, next_map=next_map, next_map_freedom=total
    )


def student(freedom: np.ndarray, coverage: float = COVERAGE) -> np.ndarray:
    """Return Student's factor of a two-sided interval; NaN without degrees of freedom.

    Examples
    --------
    >>> student(np.array([0.0, 2.0, 9.0])).round(2)
    array([ nan, 4.3 , 2.26])
    """
    positive = np.where(np.asarray(freedom, float) > 0, freedom, np.nan)
    return scipy.special.stdtrit(positive, (1 + coverage) / 2)


def width_of_next(values: np.ndarray) -> np.ndarray:
    """Return how far from the mean of numbers (number, load) a further one lies; infinite where unknown.

    Examples
    --------
    >>> width_of_next(np.array([[1.0, -np.inf], [2.0, 4.0], [3.0, 5.0]])).round(2)
    array([4.97,  inf])
    """
    count = np.sum(np.isfinite(values), axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        width = student(count - 1) * np.sqrt(1 + 1 / count) * np.nanstd(values, axis=0, ddof=1)
    return np.where(np.isnan(width), np.inf, width)


def welch(a: Effects, b: Effects) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the difference of two means, its standard uncertainty, and degrees of freedom (Welch 1947).

    It is second less first; the two may scatter differently (Biometrika 34, 28).

    Examples
    --------
    >>> one, two = (random_effects(np.array(v)[:, None], "abc") for v in ([1.0, 2.0, 3.0], [4.0, 6.0, 8.0]))
    >>> [round(each.item(), 3) for each in welch(one, two)]
    [4.0, 1.291, 2.941]
    """
    squares = [value.error**2 for value in (a, b)]
    with np.errstate(invalid="ignore", divide="ignore"):
        fourth = squares[0] ** 2 / a.freedom + squares[1] ** 2 / b.freedom
        freedom = sum(squares) ** 2 / fourth
    error = np.sqrt(sum(squares))
    return b.mean - a.mean, error, np.where(error > 0, freedom, a.freedom + b.freedom)


def p_value(difference: np.ndarray, error: np.ndarray, freedom: np.ndarray) -> np.ndarray:
    """Return the two-sided p-value of no difference, by Student's distribution; NaN where unknown.

    Examples
    --------
    >>> p_value(np.array([2.776]), np.array([1.0]), np.array([4.0])).round(3)
    array([0.05])
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(error > 0, np.abs(difference) / error, np.where(difference == 0, 0.0, np.inf))
    bound = 2 * scipy.special.stdtr(np.maximum(freedom, 1e-9), -ratio)
    return np.where(np.isnan(error) | np.isnan(difference) | ~(freedom > 0), np.nan, bound)


def adjust_over_loads(p_values: np.ndarray) -> np.ndarray:
    """Return p-values (load,) adjusted for all loads of a pair of groups; those that are NaN do not count.

    The step-up procedure of Hochberg (1988, Biometrika 75, 800), which holds where tests go together, as
    those of loads do (Sarkar 1998, Ann. Statist. 26, 494).

    Examples
    --------
    >>> adjust_over_loads(np.array([0.01, np.nan, 0.04])), adjust_over_loads(np.array([0.01, 0.011]))
    (array([0.02,  nan, 0.04]), array([0.011, 0.011]))
    """
    order = np.argsort(p_values)[: np.isfinite(p_values).sum()][::-1]  # the largest first
    result = np.full(p_values.shape, np.nan)
    result[order] = np.minimum.accumulate(np.arange(1, order.size + 1) * p_values[order])
    return result


def holm(p_values: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return p-values adjusted for all families that are tested together; those that are NaN do not count.

    Holm (1979), Scand. J. Statist. 6, 65, where each family is a single number.

    Examples
    --------
    >>> [each.item() for each in holm([np.array([p]) for p in (0.01, 0.04, np.nan, 0.03)])]
    [0.03, 0.06, nan, 0.06]
    """
    largest = np.array([np.nanmax(value, initial=-1.0) for value in p_values])
    # of a family of several numbers any may be true while another is not: it counts up to its largest
    results = []
    for index, p_value_of_family in enumerate(p_values):
        larger = np.sort(np.delete(largest, index))[::-1]
        adjusted_family = p_value_of_family.astype(float)
        for count, competitor in enumerate(larger[larger >= 0], start=2):
            adjusted_family = np.maximum(adjusted_family, count * np.minimum(p_value_of_family, competitor))
        results.append(np.minimum(adjusted_family, 1.0))
    return results


def maps_needed(spread: float, difference: float, *, pairs: bool = False) -> int:
    """Return how many maps of each of two groups, 2 to 1000, show a difference with a probability of `POWER`.

    `spread` is the standard deviation between maps, or of `pairs` differences (Cohen 1988, Statistical Power
    Analysis for the Behavioral Sciences, chapter 2).

    Examples
    --------
    `power.t.test` of R has 22.02 for a difference of one standard deviation (power 0.9, two-sided 0.05).

    >>> maps_needed(1.0, 1.0), maps_needed(0.1, 0.3)
    (23, 4)
    """

    def sufficient(count: int) -> bool:
        freedom = count - 1.0 if pairs else 2.0 * (count - 1)
        shift = difference / spread * np.sqrt(count if pairs else count / 2)
        limit = scipy.special.stdtrit(freedom, 1 - SIGNIFICANCE / 2)
        return bool(1 - scipy.special.nctdtr(freedom, shift, limit) >= POWER)

    return 2 + bisect_left(range(2, _MAX_MAPS), True, key=sufficient) if spread > 0 else 2


def grubbs_outliers(values: np.ndarray) -> np.ndarray:
    """Return which numbers (map, load) stand off, at most one of each load, by Grubbs's test at 1 %.

    None of fewer than four, and none beside equal numbers: those are at a physical limit.
    Grubbs (1969), Technometrics 11, 1; ISO 5725-2:1994, 7.3.4.

    Examples
    --------
    >>> grubbs_outliers(np.array([[1.0], [1.1], [0.9], [1.05], [3.0]])).ravel().tolist()
    [False, False, False, False, True]
    """
    count = len(values)
    if count < 4:
        return np.zeros(values.shape, bool)
    square = student(np.array(count - 2), 1 - _OUTLIER_SIGNIFICANCE / count) ** 2
    limit = (count - 1) / np.sqrt(count) * np.sqrt(square / (count - 2 + square))
    distance = np.abs(values - values.mean(axis=0))
    largest = distance == distance.max(axis=0)
    # equal numbers differ by rounding alone
    rounding = 1e-9 * np.abs(values).max(axis=0)
    scatter = np.maximum(values.std(axis=0, ddof=1), rounding)
    distinct = (np.diff(np.sort(values, axis=0), axis=0) > rounding).all(axis=0)
    return largest & distinct & (distance > limit * scatter)
