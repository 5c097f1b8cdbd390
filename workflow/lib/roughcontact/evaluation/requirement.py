"""The roughness that meets a requirement: how large Sq may be, for a texture that is otherwise as measured.

The heights of the window, and with them Sq, are multiplied until a number is just what is allowed. Each
factor is solved, with the bound that every solution has, so that hardness, layers, film and gas are in it.
(For elastic half-spaces the load curve would do: heights s times as large have s times the gap at s times
the load.)
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ALLOWED_VALUES, ENDS
from roughcontact.statistics.allowed import compared_ends, with_allowed

MAX_FACTOR = 32.0  # on the heights: beyond it the surface is another one
_TOLERANCE = 0.002  # of the logarithm of the factor: half a percent of a leak, the steepest number


def with_largest_roughness(
    statistics: xr.Dataset,
    settings: Mapping[str, Any],
    evaluate: Callable[[float, float], xr.Dataset],
    *,
    area: float | None = None,
) -> xr.Dataset:
    """Return statistics with the largest Sq (m) with which each requirement holds, at each load.

    Parameters
    ----------
    statistics : Dataset
        of `with_allowed`, from the same settings and area.
    settings : mapping
        the section `statistics` of the settings (SI).
    evaluate : callable
        factor on the heights, mean pressure (Pa) -> `contact_statistics` of that map under that load.
    area : float, m2, optional
        of the contact.

    Returns
    -------
    Dataset
        with `{name}_largest_Sq` (load; m) and its ends for each requirement that is stated: NaN where no
        factor up to `MAX_FACTOR` decides. The number is taken to be as well known, in proportion, at the
        other roughness.

    Examples
    --------
    A gap in proportion to the heights, known to ± 10 %, of which 1 µm is allowed:

    >>> gaps = {f"mean_gap{suffix}": ("load", [gap]) for suffix, gap in zip(ENDS, (5e-7, 4.5e-7, 5.5e-7))}
    >>> statistics = xr.Dataset(gaps | {"Sq": 2e-7}, {"mean_pressure": ("load", [1e6])})
    >>> settings = {"requirement": {"gap": 1e-6}}
    >>> solved = with_allowed(statistics, settings)
    >>> found = with_largest_roughness(solved, settings, lambda factor, load: statistics * factor)
    >>> [round(float(found[f"gap_largest_Sq{suffix}"][0]) * 1e9) for suffix in ENDS]
    [400, 364, 444]
    """

    @cache  # of all requirements
    def evaluated(exponent: float, load: float) -> xr.Dataset:
        return with_allowed(evaluate(float(np.exp(exponent)), load), settings, area=area)

    def logarithm(exponent: float, *, name: str, load: float) -> float:
        with np.errstate(divide="ignore"):
            return float(np.log(compared_ends(evaluated(exponent, load), name)[0, 0]))

    columns: dict[str, Any] = {}
    for name, largest in (settings.get("requirement") or {}).items():
        if largest is None or f"{name}_holds" not in statistics:
            continue
        limit = float(statistics[f"allowed_{name}"]) ** ALLOWED_VALUES[name].sense
        factors = [
            _largest_factors(partial(logarithm, name=name, load=load), span, limit)
            for load, span in zip(
                statistics["mean_pressure"].values, compared_ends(statistics, name).T, strict=True
            )
        ]
        sizes = np.transpose(factors) * float(statistics["Sq"])
        names = (f"{name}_largest_Sq{suffix}" for suffix in ENDS)
        columns |= {key: ("load", row) for key, row in zip(names, sizes, strict=True)}
    return statistics.assign(columns)


def _largest_factors(logarithm: Callable[[float], float], span: Sequence[float], limit: float) -> list[float]:
    """Return the factors at which a number reaches its limit: by its value, its upper and its lower end.

    `logarithm` is that of the number by that of the factor, with which it rises.
    """
    value, lower, upper = span
    points = {0.0: logarithm(0.0)}
    with np.errstate(divide="ignore", invalid="ignore"):
        # what the solution without corrections has to reach; where nothing leaks yet, the limit itself
        targets = np.log(limit) + [
            points[0.0] - np.log(bound) if bound > 0 and value > 0 else shift
            for bound, shift in ((value, 0.0), (upper, np.nan), (lower, np.nan))
        ]
    return [float(np.exp(_exponent(logarithm, points, target))) for target in targets]


def _exponent(logarithm: Callable[[float], float], points: dict[float, float], target: float) -> float:
    """Return where a rising function reaches a target; `points` are known ones, and new ones join them."""
    from scipy.optimize import brentq  # of a job that asks for it alone

    if np.isnan(target):
        return np.nan
    for step in (np.log(2.0), -np.log(2.0)):
        while all((number > target) == (step < 0) for number in points.values()):
            exponent = (max if step > 0 else min)(points) + step
            if abs(exponent) > np.log(MAX_FACTOR) + 1e-9:
                return np.nan
            points[exponent] = logarithm(exponent)
    highest = min(exponent for exponent, number in points.items() if number > target)
    lowest = max((exponent for exponent, number in points.items() if number <= target and exponent < highest))

    def excess(exponent: float) -> float:
        points[exponent] = logarithm(exponent)
        return float(np.clip(points[exponent] - target, -1e3, 1e3))

    return float(brentq(excess, lowest, highest, xtol=_TOLERANCE))
