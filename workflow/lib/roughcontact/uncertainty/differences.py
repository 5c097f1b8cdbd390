"""Differences between groups of maps, and between two results that share their map, area or faces.

They are ratios of the second to the first: all numbers are logarithms here, the scale of a gap. Of errors
with the half-widths u1 and u2 and the correlation r, what is shared cancels:
u² = (u2 - r u1)² + (1 - r²) u1² (JCGM 100:2008, 5.2.2).
"""

import math
from collections.abc import Collection, Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ENDS
from roughcontact.arguments.quantities import percent
from roughcontact.arguments.si import as_declared
from roughcontact.errors import SettingsError
from roughcontact.statistics.kinds import check_sizes
from roughcontact.statistics.load_pairs import common_loads, interpolated, paired_loads
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.groups import check_alike, scaled_components
from roughcontact.uncertainty.headline import headline_names
from roughcontact.uncertainty.improvement import ADVICE
from roughcontact.uncertainty.members import SHARED
from roughcontact.uncertainty.random_effects import (
    SIGNIFICANCE,
    Effects,
    adjust_over_loads,
    holm,
    maps_needed,
    p_value,
    random_effects,
    student,
    welch,
)
from roughcontact.uncertainty.scales import CONSTRICTIONS, GAP, extend_to_loads, to_scale

RELEVANT = 0.1  # relative difference that matters, unless another one is stated
DIFFER = "differ"
_MAX_MAPS = 500  # maps: more are not asked for
_MIN_DIFFERENCE = 1e-4  # relative difference: no smaller one is named
_MORE_PLACES = "measure several places of each"
_RATIOS = tuple(f"ratio{suffix}" for suffix in ENDS)
_ALL_CASES = 3  # up to so many, every two are compared


@as_declared
def compare_groups(
    first: xr.Dataset, second: xr.Dataset, *, relevant: float = RELEVANT, paired: bool = False
) -> xr.Dataset:
    """Return the ratios of the results of two groups of maps, with their intervals, and whether they differ.

    Parameters
    ----------
    first, second : Dataset
        from `group_statistics`, of two parts or more each.
    relevant : float
        relative difference that matters: smaller ones need not be found.
    paired : bool
        whether both are of the same maps, by name, under two cases (or of the same places, before and after):
        they are then compared map by map, at the loads that `paired_loads` finds, if any.

    Returns
    -------
    Dataset
        dims (quantity, load): `ratio` of the second to the first, `ratio_lower`, `ratio_upper` (95 % interval
        of this ratio), `p_value` (Welch's test [1]_, adjusted for all loads [2]_), and `outcome`:
        "differ", "do not differ by more than x", or "inconclusive", with what would decide.
        Coordinates `quantity`, `mean_pressure` (load; Pa). Narrowest places, which may be closed, are left
        out.

    Raises
    ------
    SettingsError
        for groups of a single part, of the same map, without a common load, and for paired ones of others.

    References
    ----------
    .. [1] Welch (1947), The generalization of Student's problem, Biometrika 34, 28.
    .. [2] Hochberg (1988), A sharper Bonferroni procedure for multiple tests of significance, Biometrika 75.

    Examples
    --------
    >>> from roughcontact.uncertainty.groups import group_statistics
    >>> def made(*gaps):
    ...     loads = {"mean_pressure": ("load", [1e6])}
    ...     return group_statistics([xr.Dataset({"mean_gap": ("load", [gap]), **loads}) for gap in gaps])
    >>> found = compare_groups(made(1.0, 1.1, 0.9), made(2.0, 2.1, 1.9)).isel(load=0, quantity=0)
    >>> round(found["ratio"].item(), 2), found["outcome"].item()
    (2.01, 'differ')
    >>> compare_groups(made(1.0, 1.5, 0.7), made(1.1, 1.6, 0.8))["outcome"].values.tolist()
    [['inconclusive: about 306 more maps per group needed']]
    """
    for group in (first, second):
        if not isinstance(group, xr.Dataset) or "map" not in group.dims:
            raise SettingsError("compare_groups: give two results of group_statistics")
    if not relevant > 0:
        raise SettingsError(f"relevant = {relevant:g}: give a relative difference above 0", keys=["relevant"])
    try:
        compared = _compared(first, second, paired=paired)
    except SettingsError as error:
        raise SettingsError(f"compare_groups: {error}") from error
    return _judged({"": compared}, relevant)[""]


def compare_all(
    groups: Mapping[str, xr.Dataset],
    *,
    cases: Sequence[tuple[str, str]] = (),
    same_area_pairs: Sequence[Sequence[str]] = (),
) -> tuple[dict[tuple[str, str], xr.Dataset], list[str]]:
    """Return the comparisons of every two groups by their names, and a sentence for each that is left out.

    The p-values are adjusted for all loads and pairs together. `cases` are pairs of the same maps under two
    cases, compared instead; groups of the areas in `same_area_pairs`, in two or more states, are compared map
    by map.
    """
    results, omissions = {}, []
    maps_of_place: dict[str, set[str]] = {}  # by each of them
    for same_area in same_area_pairs:
        chain = {name for map_ in same_area for name in maps_of_place.get(map_, {map_})}
        maps_of_place |= dict.fromkeys(chain, chain)
    for pair in cases or combinations(groups, 2):
        first, second = (groups[name].assign_attrs(group=name) for name in pair)
        maps, later_maps = ([*group["map"].values] for group in (first, second))
        places = [maps_of_place.get(later, ()) for later in later_maps]
        earlier = ["".join(name for name in maps if name in place) for place in places]
        if (is_same_area := sorted(earlier) == sorted(maps)) and not cases:
            second = second.assign_coords(map=earlier)
        elif any(earlier) and not cases:
            omissions.append(
                f"{' and '.join(pair)} place by place: not all maps have one of their place in the other, "
                "and no more, so that they are compared as groups of different places; leave out the others"
            )
        try:
            results[pair] = _compared(first, second, paired=bool(cases) or is_same_area)
        except SettingsError as error:
            omissions.append(str(error))
    return _judged(results), omissions


def case_pairs(names: Sequence[str]) -> list[tuple[str, str]]:
    """Return the pairs of cases that are compared: every two of up to three, of more each with the first.

    Examples
    --------
    >>> case_pairs(["a", "b", "c"])
    [('a', 'b'), ('a', 'c'), ('b', 'c')]
    >>> case_pairs(["a", "b", "c", "d"])
    [('a', 'b'), ('a', 'c'), ('a', 'd')]
    """
    pairs = list(combinations(names, 2))
    return pairs if len(names) <= _ALL_CASES else pairs[: len(names) - 1]


def case_differences(first: xr.Dataset, second: xr.Dataset) -> xr.Dataset:
    """Return the ratios of two results of one map, area or pair of faces, without what both share.

    `ratio`, `ratio_lower`, `ratio_upper` (quantity, load) are those of the second to the first, loads in
    order; NaN without a positive number, uncertainty or bound. Errors are as correlated as the results of the
    same parts of the window, those of the solver independent, those of the material where the moduli differ.
    """
    return _compare_two_maps((first, second)).table(_RATIOS)


def compare_maps(
    pairs: Mapping[tuple[str, str], tuple[xr.Dataset, xr.Dataset]],
    *,
    of_place: Collection[tuple[str, str]] = (),
) -> tuple[dict[tuple[str, str], xr.Dataset], list[str]]:
    """Return the comparisons of maps of the same area, or placements of the same faces, by their names.

    Each is `case_differences` at common mean pressures, with `p_value` (that the ratio is 1, adjusted for all
    loads and pairs) and `outcome` of `compare_groups`; a sentence comes with each pair that cannot be
    compared. Those in `of_place` are about this place alone, without what other places would give.
    """
    results, omissions = {}, []
    for pair, maps in pairs.items():
        try:
            check_alike(label := " and ".join(pair), pair, maps)
            by_load = [data.sortby("mean_pressure") for data in maps]
            loads = common_loads(label, pair, by_load)
            results[pair] = _compare_two_maps(by_load, loads, of_place=pair in of_place)
        except SettingsError as error:
            omissions.append(str(error))
    return _judged(results), omissions


def _of_map(
    name: str, data: xr.Dataset, loads: np.ndarray | None, *, of_place: bool
) -> tuple[np.ndarray, ...]:
    """Return value (load), components (load, source, component), deviations of subwindows (load, member).

    An interval without components stands in a single source, with NaN where there is none. Of this place
    alone the source `window` has what the interval of the map between its borders leaves to it, and the value
    is without what an overview shows of others. Numbers are interpolated to the `loads`, if any.
    """

    def reach(endings: Sequence[str]) -> list[np.ndarray]:
        """Return how far the ends of an interval lie below and above the value (load)."""
        bounds = (to_scale(GAP, data.get(f"{name}{key}", np.nan * data[name]).values) for key in endings)
        return [sign * (bound - value) for sign, bound in zip((-1, 1), bounds, strict=True)]

    fine_map = data.get(f"{name}_alone", data[name])  # NaN of a map beside others with an overview
    value = to_scale(GAP, (fine_map.fillna(data[name]) if of_place else data[name]).values)
    widths = scaled_components(name, data, scale=GAP)
    if f"{name}_components" not in data:
        widths[:, 0, :2] = np.transpose(reach(ENDS[1:]))
    elif of_place:
        window = SOURCES.index("window")
        other_sources, of_window = np.delete(widths, window, axis=1), widths[:, window, :2].copy()
        widths[:, window] = 0.0
        for side, width in enumerate(reach(("_map_lower", "_map_upper"))):
            of_widths = np.maximum(width - other_sources[..., 2 + side].sum(axis=1), 0.0)
            square = of_widths**2 - (other_sources[..., side] ** 2).sum(axis=1)
            widths[:, window, side] = np.fmin(np.sqrt(np.maximum(square, 0.0)), of_window[:, side])
    missing = np.full((0, value.size), np.nan)
    parts = data[f"{name}_parts"].transpose(..., "load").values if f"{name}_parts" in data else missing
    parts = to_scale(GAP, parts[np.isfinite(parts).any(axis=1)])  # the others are padding
    deviations = parts - (parts.mean(axis=0) if len(parts) else 0.0)
    numbers, own_loads = (value, widths, deviations.T), data["mean_pressure"].values
    return numbers if loads is None else tuple(interpolated(own_loads, loads, values) for values in numbers)


class _Compared(NamedTuple):
    """The ratios of two groups, and what a judgement of them needs."""

    # quantity -> (load,): `ratio` and its ends, `p_value` (adjusted for loads), `largest_source`, the index
    # of that with the largest part in what differs, or is shared; of groups also `spread`, the standard
    # deviation of a part (of a pair of maps), and `shared`, the half-width that more maps make no smaller
    rows: Mapping[str, dict[str, np.ndarray]]
    load: np.ndarray  # Pa
    paired: bool = True
    maps: int = 0  # or parts, of the smaller group; 0 for two maps
    noun: str = ""  # what more of would tell
    of_place: bool = False  # two maps of one place, and no other

    def table(self, keys: Sequence[str]) -> xr.Dataset:
        """Return some of the columns as a dataset."""
        shape = len(self.rows), self.load.size
        arrays = {key: np.reshape([row[key] for row in self.rows.values()], shape) for key in keys}
        return xr.Dataset(
            {key: (("quantity", "load"), array) for key, array in arrays.items()},
            {"quantity": np.array([*self.rows], object), "mean_pressure": ("load", self.load)},
        )


def _compare_two_maps(
    maps: Sequence[xr.Dataset], loads: np.ndarray | None = None, *, of_place: bool = False
) -> _Compared:
    """Return the comparison of two maps, of this place alone or not, without a judgement.

    They have the `loads` in order, or their numbers are interpolated there.
    """
    if loads is None:
        count = min(data.sizes["load"] for data in maps)
        maps = [data.isel(load=slice(count)) for data in maps]
    at_loads = maps[0]["mean_pressure"].values if loads is None else loads
    zeros, rows = np.zeros(at_loads.size), {}
    for name in _names(*maps):
        numbers = [_of_map(name, data, loads, of_place=of_place) for data in maps]
        values, widths, deviations = zip(*numbers, strict=True)
        correlations = np.tile(_source_correlations(*maps), (zeros.size, 1))
        correlations[:, SOURCES.index("window")] = _correlations(deviations, at_loads)
        if any(f"{name}_components" not in data for data in maps):
            correlations = 0 * correlations  # nothing is known of what they share
        difference, half_widths = values[1] - values[0], _unshared_half_widths(widths, correlations)
        towards_none = np.where(difference > 0, *half_widths) / student(np.array(np.inf))
        p_values = p_value(difference, towards_none, zeros + np.inf)
        rows[name] = _ratios(difference, widths, correlations, scatter=zeros)
        rows[name]["p_value"] = adjust_over_loads(p_values)
    return _Compared(rows, at_loads, of_place=of_place)


def _compared(first: xr.Dataset, second: xr.Dataset, *, paired: bool) -> _Compared:
    """Return the comparison of two groups, without a judgement."""
    labels = [first.attrs.get("group") or "the first", second.attrs.get("group") or "the second"]
    for label, data in zip(labels, (first, second), strict=True):
        if data.sizes["map"] < 2:
            raise SettingsError(
                f"{label} has a single map, whose scatter is not known; add maps, or compare "
                "both maps by `roughcontact compare`"
            )
    if paired and set(first["map"].values) != set(second["map"].values):
        raise SettingsError(
            f"{labels[0]} and {labels[1]} are not of the same maps; solve those "
            "that one of them lacks (in Python: or leave `paired` out)"
        )
    for name, content in () if paired else zip(first["map"].values, first["content"].values, strict=True):
        if content and content in second["content"]:
            twin = second["map"].values[second["content"].values == content][0]
            raise SettingsError(
                f"{name} of {labels[0]} and {twin} of {labels[1]} have the same results, "
                "as copies of one map have; leave one out"
            )
    if paired:
        second = second.sel(map=first["map"].values)
        matching = paired_loads(first, second)
        if matching[0].size:
            first, second = first.isel(load=matching[0]), second.isel(load=matching[1])
            second = second.assign_coords(mean_pressure=first["mean_pressure"])
    groups = first, second
    check_sizes(" and ".join(labels), groups)
    loads = common_loads(" and ".join(labels), labels, groups)
    short = [label for label, data in zip(labels, groups, strict=True) if data.sizes["load"] <= 2]
    if short and paired and not matching[0].size:  # a chord misses a gap by more than paired maps scatter
        raise SettingsError(
            f"{' and '.join(labels)}: no load in common, and {short[0]} has two loads alone, "
            "between which a difference is not known; solve them at the same mean_pressure, or at more loads"
        )
    correlation, part_names = _source_correlations(*groups), [list(data["part"].values) for data in groups]
    rows, units = {}, 0
    for name in _names(*groups):
        values, shared = zip(*(_of_group(name, data, loads) for data in groups), strict=True)
        contrasts = [values[1] - values[0]] if paired else values
        effects = [random_effects(*pair) for pair in zip(contrasts, part_names, strict=False)]
        units = min(effect.units for effect in effects)
        difference, error, freedom = _difference(effects)
        rows[name] = _ratios(difference, shared, correlation, scatter=student(freedom) * error)
        rows[name] |= {
            "p_value": adjust_over_loads(p_value(difference, error, freedom)),
            "spread": np.sqrt(np.mean([effect.error**2 * effect.units for effect in effects], axis=0)),
            "shared": np.maximum(*_unshared_half_widths(shared, correlation)),
        }
    has_parts = any(1 < len(set(names)) < len(names) for names in part_names)
    return _Compared(rows, loads, paired, units, "part" if has_parts else "map")


def _judged(comparisons: Mapping[Any, _Compared], relevant: float = RELEVANT) -> dict[Any, xr.Dataset]:
    """Return the comparisons with p-values adjusted for all of them, and with outcomes."""
    for name in {name for comparison in comparisons.values() for name in comparison.rows}:
        family = [comparison.rows[name] for comparison in comparisons.values() if name in comparison.rows]
        for row, p_values in zip(family, holm([row["p_value"] for row in family]), strict=True):
            row["p_value"] = p_values
    for comparison in comparisons.values():
        for name, row in comparison.rows.items():
            outcomes = [_outcome(comparison, name, load, relevant) for load in range(comparison.load.size)]
            row["outcome"] = np.array(outcomes, object)
    return {
        key: comparison.table((*_RATIOS, "p_value", "outcome")) for key, comparison in comparisons.items()
    }


def _outcome(comparison: _Compared, name: str, load: int, relevant: float) -> str:
    """Return whether the groups differ in a quantity under a load, in words."""
    numbers = {key: float(column[load]) for key, column in comparison.rows[name].items() if key != "outcome"}
    _, low, high = (numbers[key] for key in _RATIOS)
    if not np.isfinite([low, high, numbers["p_value"]]).all():
        return "inconclusive: no interval"
    if numbers["p_value"] < SIGNIFICANCE and not low <= 1 <= high:
        return DIFFER
    if (largest_ratio := max(1 - low, high - 1)) <= relevant:
        return f"do not differ by more than {percent(max(largest_ratio, _MIN_DIFFERENCE))}"
    return f"inconclusive: {_what_decides(comparison, name, numbers, relevant)}"


def _what_decides(comparison: _Compared, name: str, numbers: Mapping[str, float], relevant: float) -> str:
    """Return what would show a difference that matters: more maps, or a smaller error that all maps share."""
    cause = SOURCES[int(numbers["largest_source"])]
    if not comparison.maps:
        errors = percent(numbers["ratio_upper"] / numbers["ratio"] - 1)
        way = ADVICE.get(cause, "measure a longer field") if comparison.of_place else _MORE_PLACES
        return f"errors that differ are up to {errors}, most by the {cause}; {way}"
    target = math.log1p(relevant)
    missing_maps = max(maps_needed(numbers["spread"], target, pairs=comparison.paired) - comparison.maps, 1)
    count = f"more than {_MAX_MAPS}" if missing_maps > _MAX_MAPS else f"about {missing_maps}"
    nouns, group = "s" if missing_maps > 1 else "", "" if comparison.paired else " per group"
    more_maps = f"{count} more {comparison.noun}{nouns}{group} needed"
    if numbers["shared"] < target:
        return more_maps
    advice = ADVICE.get(cause, "state what they share")
    # no number of maps tells alone
    return f"all maps share errors above {percent(relevant)}; {advice}; and {more_maps}"


def _names(one_group: xr.Dataset, another: xr.Dataset) -> list[str]:
    """Return the quantities of both that have ratios."""
    shared = {*headline_names(another)} - {*CONSTRICTIONS}
    return [name for name in headline_names(one_group) if name in shared]


def _of_group(name: str, group: xr.Dataset, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the maps of a group (map, load), and the components that these share."""
    load, of_maps = group["mean_pressure"].values, to_scale(GAP, group[f"{name}_of_maps"].values)
    is_shared = np.isin(SOURCES, (*SHARED, "solver"))[:, None]
    shared = np.where(is_shared, scaled_components(name, group, ending="shared", scale=GAP), 0.0)
    return interpolated(load, loads, of_maps.T).T, interpolated(load, loads, shared)


def _source_correlations(one_group: xr.Dataset, another: xr.Dataset) -> np.ndarray:
    """Return the correlations (source) of the errors of two results that were measured and solved alike."""
    moduli = [float(data.get("contact_modulus", np.nan)) for data in (one_group, another)]
    independent = {"solver"} | ({"material"} if moduli[0] != moduli[1] else set())
    return np.array([0.0 if source in independent else 1.0 for source in SOURCES])


def _correlations(deviations: Sequence[np.ndarray], load: np.ndarray) -> np.ndarray:
    """Return the correlations (load) of the deviations (load, member) of the subwindows of two results."""
    (a, b), of_window = deviations, np.zeros(load.size)
    if a.shape == b.shape:  # else the subwindows are not the same
        with np.errstate(invalid="ignore", divide="ignore"):
            of_solved = np.sum(a * b, axis=1) / np.sqrt(np.sum(a**2, axis=1) * np.sum(b**2, axis=1))
        if (indices := np.flatnonzero(np.isfinite(of_solved))).size:
            # interpolated between the loads at which the subwindows were solved
            of_window = extend_to_loads(of_solved[indices], indices, load)
    return np.clip(of_window, -1.0, 1.0)


def _unshared_half_widths(pair: Sequence[np.ndarray], correlation: np.ndarray) -> list[np.ndarray]:
    """Return the half-widths (load,) of a difference, down and up, from two of (load, source, component)."""
    (a, b), widths = pair, []
    for side, opposite in ((0, 1), (1, 0)):
        # of the first error, the side that goes along with this one, and the one that goes against it
        along = np.where(correlation >= 0, a[..., side], a[..., opposite])
        with np.errstate(invalid="ignore"):
            squares = (b[..., side] - correlation * along) ** 2
            independent = (1 - correlation**2) * a[..., opposite] ** 2
            squares = squares + np.where(correlation**2 < 1, independent, 0.0)
            shifts = np.maximum(b[..., 2 + side] - a[..., 2 + side], 0.0)
            shifts = shifts + np.maximum(a[..., 2 + opposite] - b[..., 2 + opposite], 0.0)
            widths.append(np.sqrt(squares.sum(axis=-1)) + shifts.sum(axis=-1))
    return widths


def _difference(effects: Sequence[Effects]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the difference of two groups, or the mean change of pairs, its standard error and freedom."""
    if len(effects) == 2:
        return welch(*effects)
    (change,) = effects
    return change.mean, change.error, change.freedom


def _ratios(
    difference: np.ndarray, widths: Sequence[np.ndarray], correlation: np.ndarray, *, scatter: np.ndarray
) -> dict[str, np.ndarray]:
    """Return ratio, both ends of its interval, and its largest source, from a difference (load).

    `widths` are the components of both, `scatter` the half-width by the scatter of the maps (load).
    """
    below, above = (np.hypot(scatter, side) for side in _unshared_half_widths(widths, correlation))
    with np.errstate(invalid="ignore", over="ignore"):  # of closed gaps and unbounded ends, NaN below
        ratios = np.exp([difference, difference - below, difference + above])
    row = dict(zip(_RATIOS, np.where(np.isfinite(ratios), ratios, np.nan), strict=True))
    by_source = _unshared_half_widths([sides[:, :, None] for sides in widths], correlation[..., None])
    return row | {"largest_source": np.nan_to_num(np.maximum(*by_source), nan=0.0).argmax(axis=1)}
