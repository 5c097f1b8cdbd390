"""The roughness that meets a requirement: how large Sq may be, for a texture that is otherwise as measured.

Linear bodies need no further solution: with heights s times as large all displacements and pressures are so,
and a number at the load p is s^n times that of the map at p/s, n its power of the heights: 1 of the gap,
0 of the contact area and the conductance, 3 of a leak. The load curve that was solved has it. Hardness, gas
and slip bring in a pressure or a length that stays: there each factor is solved, with the bound that every
solution has, from the factor of the curve on, as where the curve ends or has too few loads.
"""

from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ALLOWED_VALUES, ENDS
from roughcontact.statistics.allowed import compared_ends, with_allowed
from roughcontact.statistics.decisions import is_lifted

MAX_FACTOR = 32.0  # on the heights: beyond it the surface is another one
_TOLERANCE = 0.002  # of the logarithm of the factor: half a percent of a leak, the steepest number
_DENSE = 0.35  # of it between two loads: a factor of 1.4, between which the curve is known to a percent
_STEP = 0.05  # of it, the first one from the factor of the curve; each is twice as long as the last
# lengths of them do not grow with the heights
_STAYS = (("joint", "gas_conductivity"), ("seal", "mean_free_path"))


def with_largest_roughness(
    statistics: xr.Dataset,
    settings: Mapping[str, Any],
    evaluate: Callable[[float, float], xr.Dataset],
    *,
    area: float | None = None,
    linear: bool = False,
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
    linear : bool
        whether displacements are in proportion to pressures, without a hardness.

    Returns
    -------
    Dataset
        with `{name}_largest_Sq` (load; m) and its ends for each requirement that is stated: NaN where no
        factor up to `MAX_FACTOR` decides. The ends are those of the curve; of a number that is solved for,
        it is taken to be as well known, in proportion, at the other roughness.

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
        return float(np.log(compared_ends(evaluated(exponent, load), name)[0, 0]))

    scales = linear and not any((settings.get(part) or {}).get(key) for part, key in _STAYS)
    loads = statistics["mean_pressure"].values
    columns: dict[str, Any] = {}
    for name, largest in (settings.get("requirement") or {}).items():
        if largest is None or f"{name}_holds" not in statistics:
            continue
        allowed, exponents = ALLOWED_VALUES[name], np.full((len(ENDS), loads.size), np.nan)
        limit = allowed.sense * np.log(float(statistics[f"allowed_{name}"]))
        with np.errstate(divide="ignore", invalid="ignore"):  # closed gaps, ends that are not known
            # the upper end of a number is the lower one of the factor
            ends = np.log(compared_ends(statistics, name))[[0, 2, 1]]
            for index, load in enumerate(loads):
                solved, shift = partial(logarithm, name=name, load=load), 0.0
                for end, numbers in enumerate(ends):
                    on_curve, is_dense = _on_curve(np.log(load / loads), numbers, allowed.power, limit)
                    found = start = on_curve + shift
                    # between few loads the value is solved for, and its ends go with it
                    if not (scales and np.isfinite(found) and (is_dense or end > 0)):
                        found = _solved_for(solved, limit, ends[0, index], numbers[index], start=start)
                    if end == 0:
                        shift = found - on_curve
                    exponents[end, index] = found
        exponents[:, is_lifted(statistics, name)] = np.nan  # no roughness holds what the fluid lifts
        sizes = np.exp(exponents) * float(statistics["Sq"])
        columns |= {f"{name}_largest_Sq{end}": ("load", row) for end, row in zip(ENDS, sizes, strict=True)}
    return statistics.assign(columns)


def _on_curve(exponents: np.ndarray, numbers: np.ndarray, power: int, limit: float) -> tuple[float, bool]:
    """Return where the numbers of a load curve reach a limit, and whether its loads are close to each other.

    All are logarithms: of the factors with which each load is the one in question, and of the numbers. NaN
    where the curve does not reach the limit.
    """
    from scipy.interpolate import PchipInterpolator  # of a job that asks for it alone

    order = np.argsort(exponents)
    rising, exponents = (numbers + power * exponents)[order], exponents[order]
    known = np.isfinite(rising) & (np.diff(np.fmax.accumulate(rising), prepend=-np.inf) > 0)
    rising, exponents = rising[known], exponents[known]
    if rising.size < 2 or not rising[0] <= limit <= rising[-1]:
        return np.nan, False
    above = max(1, int(np.searchsorted(rising, limit)))
    width = exponents[above] - exponents[above - 1]
    return float(PchipInterpolator(rising, exponents)(limit)), width < _DENSE


def _solved_for(
    solved: Callable[[float], float], limit: float, value: float, end: float, *, start: float
) -> float:
    """Return where a rising number reaches its limit by an end, NaN where it does not.

    All are logarithms. `solved` are solutions without corrections, which the distance of the end holds.
    """
    from scipy.optimize import brentq  # of a job that asks for it alone

    is_open = np.isfinite([value, end]).all()
    if np.isnan(end) or not (is_open or value == end):
        return np.nan
    target = limit + solved(0.0) - end if is_open else limit  # where nothing leaks yet, the limit itself

    def excess(exponent: float) -> float:
        return float(np.clip(solved(exponent) - target, -1e3, 1e3))

    farthest = np.log(MAX_FACTOR)
    inside = float(np.clip(np.nan_to_num(start), -farthest, farthest))
    step = (_STEP if np.isfinite(start) else 4 * _STEP) * (1 if excess(inside) <= 0 else -1)
    while step * inside < abs(step) * farthest:
        outside = float(np.clip(inside + step, -farthest, farthest))
        if (excess(outside) > 0) == (step > 0):
            return float(brentq(excess, inside, outside, xtol=_TOLERANCE))
        inside, step = outside, 2 * step
    return np.nan
