"""Differences between groups of maps, and between two results that share their map, area or faces.

They are ratios of the second to the first, tested on the scales of `groups`, with intervals of their
logarithms. Of errors with the half-widths u1 and u2 and the correlation r, what is shared cancels:
u² = (u2 - r u1)² + (1 - r²) u1² (JCGM 100:2008, 5.2.2).
"""

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
from roughcontact.uncertainty.combination import SIGNS, SOURCES
from roughcontact.uncertainty.groups import check_alike, needed_for_groups, scaled_components
from roughcontact.uncertainty.headline import headline_names
from roughcontact.uncertainty.improvement import ADVICE
from roughcontact.uncertainty.members import SHARED
from roughcontact.uncertainty.random_effects import (
    SIGNIFICANCE,
    Effects,
    adjust_over_loads,
    correlation_at_least,
    holm,
    maps_needed,
    p_value,
    random_effects,
    student,
    welch,
)
from roughcontact.uncertainty.scales import CONSTRICTIONS, extend_to_loads, from_scale, to_scale

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
    .. [2] Galwey (2009), A new measure of the effective number of tests, Genet. Epidemiol. 33, 559-568.

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
    return _compare_two_maps(first, second).table(_RATIOS)


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
            check_alike(" and ".join(pair), pair, maps)
            results[pair] = _compare_two_maps(*_at_common_loads(pair, maps), of_place=pair in of_place)
        except SettingsError as error:
            omissions.append(str(error))
    return _judged(results), omissions


def _at_common_loads(names: Sequence[str], maps: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Return what comparisons need of two maps at the mean pressures that both reach, loads rising.

    Between their own loads quantities are interpolated on their scale.
    """
    maps = [data.sortby("mean_pressure") for data in maps]
    loads = common_loads(" and ".join(names), names, maps)

    def at_loads(name: str, by_load: xr.Variable) -> tuple[Any, np.ndarray]:
        by_load = by_load.transpose("load", ...)
        has_scale, own_loads = name in headline_names(data), data["mean_pressure"].values
        values = to_scale(name, by_load.values) if has_scale else by_load.values
        values = interpolated(own_loads, loads, values)
        return by_load.dims, from_scale(name, values) if has_scale else values

    results = []
    for data in maps:
        needed = data[needed_for_groups(map(str, data.variables))]
        columns = {k: at_loads(str(k), v) for k, v in needed.variables.items() if "load" in v.dims}
        results.append(needed.drop_vars([*columns]).assign(columns).assign(mean_pressure=("load", loads)))
    return results


def _value(name: str, data: xr.Dataset, *, of_place: bool = False) -> np.ndarray:
    """Return a quantity (load) on its scale; of this place alone without what an overview shows of others."""
    fine_map = data.get(f"{name}_alone", data[name])  # NaN of a map beside others with an overview
    return to_scale(name, (fine_map.fillna(data[name]) if of_place else data[name]).values)


def _widths(name: str, data: xr.Dataset, *, of_place: bool = False) -> np.ndarray:
    """Return the components (load, source, component) of a map; of an interval that has none its half-widths.

    These stand in a single source; NaN where there is no interval. For this place alone the source `window`
    has what the interval of the map between its borders leaves to it.
    """
    if f"{name}_components" in data:
        components = scaled_components(name, data)
        return _of_place(name, data, components) if of_place else components
    components = np.zeros((data.sizes["load"], len(SOURCES), 4))
    components[:, 0, :2] = np.transpose(_reach(name, data, ENDS[1:]))
    return components


def _reach(
    name: str, data: xr.Dataset, endings: Sequence[str], *, of_place: bool = False
) -> list[np.ndarray]:
    """Return how far the ends of an interval lie below and above its value (load), on the scale."""
    middle = _value(name, data, of_place=of_place)
    bounds = [to_scale(name, data.get(f"{name}{suffix}", data[name] * np.nan).values) for suffix in endings]
    return [middle - bounds[0], bounds[1] - middle]


def _of_place(name: str, data: xr.Dataset, components: np.ndarray) -> np.ndarray:
    """Return components (load, source, component), those of the source `window` of this map alone."""
    window = SOURCES.index("window")
    other_sources = np.delete(components, window, axis=1)
    result = components.copy()
    result[:, window, 2:] = 0.0
    for side, reach in enumerate(_reach(name, data, ("_map_lower", "_map_upper"), of_place=True)):
        reach_of_widths = np.maximum(reach - other_sources[..., 2 + side].sum(axis=1), 0.0)
        remainder = np.sqrt(np.maximum(reach_of_widths**2 - (other_sources[..., side] ** 2).sum(axis=1), 0.0))
        result[:, window, side] = np.fmin(remainder, components[:, window, side])
    return result


class _Compared(NamedTuple):
    """The ratios of two groups, and what a judgement of them needs."""

    # quantity -> (load,): `ratio` and its ends, `p_value` (adjusted for loads), `largest_source`, the index
    # of that with the largest part in what differs, or is shared; of groups also, on the scale, `spread`, the
    # standard deviation of a part (of a pair of maps), `shared`, the half-width that more maps would not make
    # smaller, and `mean` of the first group
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


def _compare_two_maps(first: xr.Dataset, second: xr.Dataset, *, of_place: bool = False) -> _Compared:
    """Return the comparison of two maps, of this place alone or not, without a judgement."""
    loads = min(first.sizes["load"], second.sizes["load"])
    maps = [data.isel(load=slice(loads)) for data in (first, second)]
    zeros, rows = np.zeros(loads), {}
    for name in _names(*maps):
        values = [_value(name, data, of_place=of_place) for data in maps]
        widths = [_widths(name, data, of_place=of_place) for data in maps]
        correlations = _correlations(name, *maps)
        difference, half_widths = values[1] - values[0], _unshared_half_widths(widths, correlations)
        towards_none = np.where(difference > 0, *half_widths) / student(np.array(np.inf))
        p_values = p_value(difference, towards_none, zeros + np.inf)
        rows[name] = _ratios(name, values, widths, correlations, scatter=zeros)
        # nothing is known of how the errors at two loads go together
        rows[name]["p_value"] = adjust_over_loads(p_values, np.eye(loads))
    return _Compared(rows, maps[0]["mean_pressure"].values, of_place=of_place)


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

    def contrast_of(values: Sequence[np.ndarray]) -> list[Effects]:
        """Return the effects of both groups, or of the changes of pairs."""
        contrasts = [values[1] - values[0]] if paired else values
        return [random_effects(*numbers) for numbers in zip(contrasts, part_names, strict=False)]

    rows, units = {}, 0
    for name in _names(*groups):
        values, shared = zip(*(_scaled_numbers(name, data, loads) for data in groups), strict=True)
        contrast = contrast_of(values)
        # a ratio is of logarithms
        _, log_error, log_freedom = _difference(contrast_of([_logarithm(name, each) for each in values]))
        means = [random_effects(*numbers).mean for numbers in zip(values, part_names, strict=True)]
        units = min(effects.units for effects in contrast)
        deviations = np.concatenate([effects.deviations for effects in contrast])
        load_correlation = correlation_at_least(deviations, len(deviations) - len(contrast))
        rows[name] = _ratios(name, means, shared, correlation, scatter=student(log_freedom) * log_error)
        rows[name] |= {
            "p_value": adjust_over_loads(p_value(*_difference(contrast)), load_correlation),
            "spread": np.sqrt(np.mean([effects.error**2 * effects.units for effects in contrast], axis=0)),
            "shared": np.maximum(*_unshared_half_widths(shared, correlation)),
            "mean": means[0],
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
    mean = np.array(numbers["mean"])
    relevant_bounds = to_scale(name, from_scale(name, mean) * np.array([1 - relevant, 1 + relevant]))
    target = float(np.nanmin(np.abs(relevant_bounds - mean)))
    missing_maps = max(maps_needed(numbers["spread"], target, pairs=comparison.paired) - comparison.maps, 1)
    plural = "s" if missing_maps > 1 else ""
    count = f"more than {_MAX_MAPS}" if missing_maps > _MAX_MAPS else f"about {missing_maps}"
    group = "" if comparison.paired else " per group"
    more_maps = f"{count} more {comparison.noun}{plural}{group} needed"
    if numbers["shared"] < target:
        return more_maps
    advice = ADVICE.get(cause, "state what they share")
    shared_error = f"all maps share errors above {percent(relevant)}; {advice}"
    pairs = 1 if comparison.paired else 2  # whose scatter adds
    freedom = np.array(pairs * (comparison.maps - 1.0))
    of_scatter = student(freedom) * numbers["spread"] * np.sqrt(pairs / comparison.maps)
    causes = [shared_error, more_maps]
    return "; and ".join(causes[::-1] if of_scatter > numbers["shared"] else causes)


def _names(one_group: xr.Dataset, another: xr.Dataset) -> list[str]:
    """Return the quantities of both that have ratios."""
    shared = {*headline_names(another)} - {*CONSTRICTIONS}
    return [name for name in headline_names(one_group) if name in shared]


def _scaled_numbers(name: str, group: xr.Dataset, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the maps of a group on their scale (map, load), and what these share."""
    load, of_maps = group["mean_pressure"].values, to_scale(name, group[f"{name}_of_maps"].values)
    is_shared = np.isin(SOURCES, (*SHARED, "solver"))[:, None]
    shared_widths = np.where(is_shared, np.nan_to_num(group[f"{name}_shared"].values, nan=np.inf), 0.0)
    return interpolated(load, loads, of_maps.T).T, interpolated(load, loads, shared_widths)


def _source_correlations(one_group: xr.Dataset, another: xr.Dataset) -> np.ndarray:
    """Return the correlations (source) of the errors of two results that were measured and solved alike."""
    moduli = [float(data.get("contact_modulus", np.nan)) for data in (one_group, another)]
    independent = {"solver"} | ({"material"} if moduli[0] != moduli[1] else set())
    return np.array([0.0 if source in independent else 1.0 for source in SOURCES])


def _correlations(name: str, one_group: xr.Dataset, another: xr.Dataset) -> np.ndarray:
    """Return the correlations (load, source) of the errors of one map under two cases."""
    correlations = np.tile(_source_correlations(one_group, another), (one_group.sizes["load"], 1))
    if any(f"{name}_components" not in data for data in (one_group, another)):
        return 0 * correlations  # nothing is known of what they share
    a, b = (_deviations(name, data) for data in (one_group, another))
    of_window = np.zeros(len(correlations))  # where the subwindows are not the same
    if a.shape == b.shape:
        with np.errstate(invalid="ignore", divide="ignore"):
            of_solved = np.sum(a * b, axis=0) / np.sqrt(np.sum(a**2, axis=0) * np.sum(b**2, axis=0))
        if (indices := np.flatnonzero(np.isfinite(of_solved))).size:
            # interpolated between the loads at which the subwindows were solved
            of_window = extend_to_loads(of_solved[indices], indices, one_group["mean_pressure"].values)
    correlations[:, SOURCES.index("window")] = np.clip(of_window, -1.0, 1.0)
    return correlations


def _deviations(name: str, data: xr.Dataset) -> np.ndarray:
    """Return the deviations (member, load) of the subwindows from their mean, on the scale."""
    missing = np.full((0, data.sizes["load"]), np.nan)
    values = data[f"{name}_parts"].transpose(..., "load").values if f"{name}_parts" in data else missing
    values = to_scale(name, values[np.isfinite(values).any(axis=1)])  # the others are padding
    return values - (values.mean(axis=0) if len(values) else 0.0)


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
    name: str,
    values: Sequence[np.ndarray],
    widths: Sequence[np.ndarray],
    correlation: np.ndarray,
    *,
    scatter: np.ndarray,
) -> dict[str, np.ndarray]:
    """Return ratio, both ends of its interval, and its largest source, from two values with their components.

    All are (load,), and those that are given on the scale; `scatter` is the half-width of the difference of
    logarithms by the scatter of the maps.
    """
    mean, second_mean = (_logarithm(name, number) for number in values)
    # an area near the whole moves less than its scale: what both share changes their ratio
    on_logarithm = [
        SIGNS[:, 0] * (_logarithm(name, value[:, None, None] + SIGNS[:, 0] * sides) - middle[:, None, None])
        for value, middle, sides in zip(values, (mean, second_mean), widths, strict=True)
    ]
    below, above = (np.hypot(scatter, side) for side in _unshared_half_widths(on_logarithm, correlation))
    difference = second_mean - mean
    with np.errstate(invalid="ignore", over="ignore"):  # of closed gaps and unbounded ends, NaN below
        bounds = difference, difference - below, difference + above
        ratios = np.exp(mean + np.array(bounds)) / np.exp(mean)
    row = dict(zip(_RATIOS, np.where(np.isfinite(ratios), ratios, np.nan), strict=True))
    by_source = _unshared_half_widths([sides[:, :, None] for sides in widths], correlation[..., None])
    return row | {"largest_source": np.nan_to_num(np.maximum(*by_source), nan=0.0).argmax(axis=1)}


def _logarithm(name: str, values: np.ndarray) -> np.ndarray:
    """Return the logarithm of a quantity from its scale."""
    with np.errstate(divide="ignore"):  # of an unbounded end
        return np.log(from_scale(name, values))
