"""Differences between groups of maps, and between two results that share their map, area or faces.

They are ratios of the second to the first, tested on the scales of `groups`, with intervals of their
logarithms. Of errors with the half-widths u1 and u2 and the correlation r, what is shared cancels:
u² = (u2 - r u1)² + (1 - r²) u1² (JCGM 100:2008, 5.2.2).
"""

from collections.abc import Collection, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.quantities import percent
from roughcontact.errors import SettingsError
from roughcontact.statistics.load_pairs import common_loads, interpolated, paired_loads
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.groups import (
    HEIGHTS,
    SHARED,
    check_alike,
    check_sizes,
    from_scale,
    needed_for_groups,
    scaled_components,
    to_scale,
)
from roughcontact.uncertainty.headline import headline_names
from roughcontact.uncertainty.improvement import ADVICE
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
from roughcontact.uncertainty.scales import AREA, extend_to_loads

RELEVANT = 0.1  # relative difference that matters, unless another one is stated
DIFFER = "differ"
_MAX_MAPS = 500  # maps: more are not asked for
_MIN_DIFFERENCE = 1e-4  # relative difference: no smaller one is named
_MORE_PLACES = "measure several places of each"
_ALL_CASES = 3  # up to so many, every two are compared


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
    try:
        compared = _compared(first, second, paired=paired)
    except SettingsError as error:
        raise SettingsError(f"compare_groups: {error}") from error
    return _add_test_results([compared], relevant)[0]


def compare_all(
    groups: Mapping[str, xr.Dataset],
    *,
    relevant: float = RELEVANT,
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
    for earlier_map, later_map in same_area_pairs:
        chain = {name for map_ in (earlier_map, later_map) for name in maps_of_place.get(map_, {map_})}
        maps_of_place |= dict.fromkeys(chain, chain)
    for pair in cases or combinations(groups, 2):
        first_group, second_group = (groups[name].assign_attrs(group=name) for name in pair)
        maps = list(first_group["map"].values)
        earlier = [
            "".join(map_name for map_name in maps if map_name in maps_of_place.get(name, ()))
            for name in second_group["map"].values
        ]
        is_paired = bool(cases) or sorted(earlier) == sorted(maps)
        if any(earlier) and not is_paired:
            omissions.append(
                f"{' and '.join(pair)} place by place: not all maps have one of their place in the other, "
                "and no more, so that they are compared as groups of different places; leave out the others"
            )
        try:
            results[pair] = _compared(
                first_group,
                second_group if cases or not is_paired else second_group.assign_coords(map=earlier),
                paired=is_paired,
            )
        except SettingsError as error:
            omissions.append(str(error))
    return dict(zip(results, _add_test_results(list(results.values()), relevant), strict=True)), omissions


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
    return _compare_two_maps(first, second).table


def compare_maps(
    pairs: Mapping[tuple[str, str], tuple[xr.Dataset, xr.Dataset]],
    *,
    relevant: float = RELEVANT,
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
            common = _select_common_loads(pair, maps)
            results[pair] = _compare_two_maps(*common, of_place=pair in of_place)
        except SettingsError as error:
            omissions.append(str(error))
    return dict(zip(results, _add_test_results(list(results.values()), relevant), strict=True)), omissions


def _select_common_loads(names: Sequence[str], maps: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Return what comparisons need of two maps, loads rising, at the mean pressures that both reach."""
    maps = [data.sortby("mean_pressure") for data in maps]
    loads = common_loads(" and ".join(names), names, maps)
    tables = []
    for data in maps:
        load, quantities = data["mean_pressure"].values, headline_names(data)
        part, columns = data[needed_for_groups(map(str, data.variables))], {}
        for name in [name for name, variable in part.variables.items() if "load" in variable.dims]:
            by_load = part[name].transpose("load", ...)
            values = to_scale(name, by_load.values) if name in quantities else by_load.values
            values = interpolated(load, loads, values)
            columns[name] = by_load.dims, from_scale(name, values) if name in quantities else values
        tables.append(part.drop_vars([*columns]).assign(columns).assign(mean_pressure=("load", loads)))
    return tables


def _widths(name: str, data: xr.Dataset, *, of_place: bool = False) -> np.ndarray:
    """Return the components (load, source, component) of a map; of an interval that has none its half-widths.

    These stand in a single source; NaN where there is no interval. For this place alone the source `window`
    has what the interval of the map between its borders leaves to it.
    """
    if f"{name}_components" in data:
        components = scaled_components(name, data)
        return _of_place(name, data, components) if of_place else components
    components = np.zeros((data.sizes["load"], len(SOURCES), 4))
    middle = to_scale(name, data[name].values)
    for side, (bound, sign) in enumerate((("lower", -1.0), ("upper", 1.0))):
        values = data.get(f"{name}_{bound}", data[name] * np.nan).values
        components[:, 0, side] = sign * (to_scale(name, values) - middle)
    return components


def _of_place(name: str, data: xr.Dataset, components: np.ndarray) -> np.ndarray:
    """Return components (load, source, component), those of the source `window` of this map alone."""
    window, middle = SOURCES.index("window"), to_scale(name, data[name].values)
    others = np.delete(components, window, axis=1)
    result = components.copy()
    result[:, window, 2:] = 0.0
    for side, (bound, sign) in enumerate((("lower", -1.0), ("upper", 1.0))):
        reach = sign * (to_scale(name, data[f"{name}_map_{bound}"].values) - middle)
        reach = np.maximum(reach - others[..., 2 + side].sum(axis=1), 0.0)
        left = np.sqrt(np.maximum(reach**2 - (others[..., side] ** 2).sum(axis=1), 0.0))
        result[:, window, side] = np.fmin(left, components[:, window, side])
    return result


class _Compared(NamedTuple):
    """The ratios of two groups, and what a judgement of them needs, arrays (quantity, load)."""

    table: xr.Dataset
    p_value: np.ndarray
    load_correlations: list[np.ndarray]  # of each quantity, of the scatter (load, load), at least
    # all that follows is of groups alone
    paired: bool = True
    maps: int = 0  # or parts, of the smaller group
    noun: str = ""  # what more of would tell
    spread: np.ndarray = np.empty(0)  # standard deviation of a part (of a pair of maps), on the scale
    shared: np.ndarray = np.empty(0)  # half-width, on the scale, that more maps would not make smaller
    largest_source: np.ndarray = np.empty(0)  # index of that with the largest part in it, also of two maps
    mean: np.ndarray = np.empty(0)  # of the first group, on the scale
    of_place: bool = False  # two maps of one place, and no other


def _compare_two_maps(first: xr.Dataset, second: xr.Dataset, *, of_place: bool = False) -> _Compared:
    """Return the comparison of two maps, of this place alone or not, without a judgement."""
    loads = min(first.sizes["load"], second.sizes["load"])
    first_data, second_data = (data.isel(load=slice(loads)) for data in (first, second))
    names, zeros = _names(first_data, second_data), np.zeros(loads)
    rows, p_values, causes = [], [], []
    for name in names:
        x0, x1 = (to_scale(name, data[name].values) for data in (first_data, second_data))
        first_widths, second_widths = (
            _widths(name, data, of_place=of_place) for data in (first_data, second_data)
        )
        widths = first_widths, second_widths
        correlations = _correlations(name, first_data, second_data)
        half_widths = _unshared_half_widths(*widths, correlations)
        rows.append(_ratios(name, (x0, x1), widths, correlations, scatter=zeros))
        towards_none = np.where(x1 > x0, *half_widths) / student(np.array(np.inf))
        p_values.append(p_value(x1 - x0, towards_none, zeros + np.inf))
        causes.append(_largest_source(*widths, correlations))
    table = _table(names, first_data["mean_pressure"].values, rows)
    # nothing is known of how the errors at two loads go together
    p, largest = (np.reshape(values, (len(names), loads)) for values in (p_values, causes))
    return _Compared(table, p, [np.eye(loads)] * len(names), of_place=of_place, largest_source=largest)


def _compared(first: xr.Dataset, second: xr.Dataset, *, paired: bool) -> _Compared:
    """Return the comparison of two groups, without a judgement."""
    labels = [
        data.attrs.get("group") or noun for data, noun in ((first, "the first"), (second, "the second"))
    ]
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
    correlation = _source_correlations(first, second)
    names = _names(first, second)
    count = 0
    rows, columns, load_correlations = [], [], []
    part_names = [list(data["part"].values) for data in groups]
    for name in names:
        values, (shared_widths, second_shared) = zip(
            *(_scaled_numbers(name, data, loads) for data in groups), strict=True
        )
        of_groups = _effects(values, part_names)
        contrast = _effects([values[1] - values[0]], part_names[:1]) if paired else of_groups
        difference, error, freedom = _difference(contrast)
        deviations = np.concatenate([effects.deviations for effects in contrast])
        spread = np.sqrt(np.mean([effects.error**2 * effects.units for effects in contrast], axis=0))
        count = min(effects.units for effects in contrast)
        half_widths = _unshared_half_widths(shared_widths, second_shared, correlation)
        load_correlations.append(correlation_at_least(deviations, len(deviations) - len(contrast)))
        scatter = student(freedom) * error
        if name == AREA:  # on the logarithm instead
            logs = [_logarithm(name, of_maps) for of_maps in values]
            of_logs = _effects([logs[1] - logs[0]] if paired else logs, part_names[: len(contrast)])
            _, log_error, log_freedom = _difference(of_logs)
            scatter = student(log_freedom) * log_error
        means = [effects.mean for effects in of_groups]
        rows.append(_ratios(name, means, (shared_widths, second_shared), correlation, scatter=scatter))
        largest = _largest_source(shared_widths, second_shared, correlation)
        columns.append(
            (p_value(difference, error, freedom), spread, np.maximum(*half_widths), largest, means[0])
        )
    has_parts = any(1 < len(set(data["part"].values)) < data.sizes["map"] for data in groups)
    table = _table(names, loads, rows)
    p_values, *numbers = np.moveaxis(np.reshape(columns, (len(names), 5, loads.size)), 1, 0)
    noun = "part" if has_parts else "map"
    return _Compared(table, p_values, load_correlations, paired, count, noun, *numbers)


def _add_test_results(comparisons: Sequence[_Compared], relevant: float) -> list[xr.Dataset]:
    """Return the comparisons with p-values adjusted for all of them and their loads, and with outcomes."""
    adjusted_p = [np.full(comparison.p_value.shape, np.nan) for comparison in comparisons]
    rows_by_quantity: dict[str, list[tuple[int, int]]] = {}
    for pair, comparison in enumerate(comparisons):
        for row, name in enumerate(comparison.table["quantity"].values):
            rows_by_quantity.setdefault(name, []).append((pair, row))
    for pairs in rows_by_quantity.values():
        together = [
            adjust_over_loads(comparisons[pair].p_value[row], comparisons[pair].load_correlations[row])
            for pair, row in pairs
        ]
        for (pair, row), values in zip(pairs, holm(together), strict=True):
            adjusted_p[pair][row] = values
    return [
        comparison.table.assign(
            p_value=(("quantity", "load"), values),
            outcome=(("quantity", "load"), _outcomes(comparison, values, relevant)),
        )
        for comparison, values in zip(comparisons, adjusted_p, strict=True)
    ]


def _outcomes(comparison: _Compared, p_values: np.ndarray, relevant: float) -> np.ndarray:
    """Return for each ratio whether the groups differ, in words."""
    labels = np.full(p_values.shape, "", object)
    bounds = np.stack([comparison.table[f"ratio_{bound}"].values for bound in ("lower", "upper")])
    for index in np.ndindex(*p_values.shape):
        low, high = bounds[(slice(None), *index)]
        if not np.isfinite([low, high, p_values[index]]).all():
            labels[index] = "inconclusive: no interval"
        elif p_values[index] < SIGNIFICANCE and not low <= 1 <= high:
            labels[index] = DIFFER
        elif (largest_ratio := max(1 - low, high - 1)) <= relevant:
            labels[index] = f"do not differ by more than {percent(max(largest_ratio, _MIN_DIFFERENCE))}"
        else:
            labels[index] = f"inconclusive: {_what_decides(comparison, index, relevant)}"
    return labels


def _what_decides(comparison: _Compared, index: tuple[int, ...], relevant: float) -> str:
    """Return what would show a difference that matters: more maps, or a smaller error that all maps share."""
    if not comparison.maps:
        ratio, upper = (float(comparison.table[key].values[index]) for key in ("ratio", "ratio_upper"))
        cause = SOURCES[int(comparison.largest_source[index])]
        way = ADVICE.get(cause, "measure a longer field") if comparison.of_place else _MORE_PLACES
        return f"errors that differ are up to {percent(upper / ratio - 1)}, most by the {cause}; {way}"
    name = str(comparison.table["quantity"].values[index[0]])
    mean = comparison.mean[index]
    relevant_bounds = to_scale(name, from_scale(name, mean) * np.array([1 - relevant, 1 + relevant]))
    target = float(np.nanmin(np.abs(relevant_bounds - mean)))
    shared_error = ""
    if comparison.shared[index] >= target:
        advice = ADVICE.get(SOURCES[int(comparison.largest_source[index])], "state what they share")
        shared_error = f"all maps share errors above {percent(relevant)}; {advice}"
    needed_maps = maps_needed(float(comparison.spread[index]), target, pairs=comparison.paired)
    missing_maps = max(needed_maps - comparison.maps, 1)
    plural = "s" if missing_maps > 1 else ""
    count = f"more than {_MAX_MAPS}" if missing_maps > _MAX_MAPS else str(missing_maps)
    about, group = "about " * (missing_maps <= _MAX_MAPS), "" if comparison.paired else " per group"
    more_maps = f"{about}{count} more {comparison.noun}{plural}{group} needed"
    if not shared_error:
        return more_maps
    pairs = 1 if comparison.paired else 2  # whose scatter adds
    freedom = np.array(pairs * (comparison.maps - 1.0))
    of_scatter = student(freedom) * comparison.spread[index] * np.sqrt(pairs / comparison.maps)
    causes = [shared_error, more_maps]
    return "; and ".join(causes[::-1] if of_scatter > comparison.shared[index] else causes)


def _names(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """Return the quantities of both that have ratios."""
    return [
        name for name in headline_names(first) if name in first and name in second and name not in HEIGHTS
    ]


def _scaled_numbers(name: str, group: xr.Dataset, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the maps of a group on their scale (map, load), and what these share."""
    load = group["mean_pressure"].values
    of_maps = to_scale(name, group[f"{name}_of_maps"].values)
    shared_widths = group[f"{name}_shared"].values
    is_shared = np.array([source in (*SHARED, "solver") for source in SOURCES])[:, None]
    shared_widths = np.where(is_shared, np.where(np.isnan(shared_widths), np.inf, shared_widths), 0.0)
    return interpolated(load, loads, of_maps.T).T, interpolated(load, loads, shared_widths)


def _source_correlations(first: xr.Dataset, second: xr.Dataset) -> np.ndarray:
    """Return the correlations (source) of the errors of two results that were measured and solved alike."""
    moduli = [float(data.get("contact_modulus", np.nan)) for data in (first, second)]
    independent = {"solver"} | ({"material"} if moduli[0] != moduli[1] else set())
    return np.array([0.0 if source in independent else 1.0 for source in SOURCES])


def _correlations(name: str, first: xr.Dataset, second: xr.Dataset) -> np.ndarray:
    """Return the correlations (load, source) of the errors of one map under two cases."""
    correlations = np.tile(_source_correlations(first, second), (first.sizes["load"], 1))
    if any(f"{name}_components" not in data for data in (first, second)):
        return 0 * correlations  # nothing is known of what they share
    first_deviations, second_deviations = (_deviations(name, data) for data in (first, second))
    correlations[:, SOURCES.index("window")] = _correlation(
        first_deviations, second_deviations, first["mean_pressure"].values
    )
    return correlations


def _deviations(name: str, data: xr.Dataset) -> np.ndarray:
    """Return the deviations (member, load) of the subwindows from their mean, on the scale."""
    none = np.empty((0, data.sizes["load"]))
    if f"{name}_parts" not in data:
        return none
    subwindow_values = data[f"{name}_parts"].transpose(..., "load")
    finite = np.isfinite(subwindow_values.values).any(axis=1)  # the others are padding
    if not finite.any():
        return none
    values = to_scale(name, subwindow_values.values[finite])
    return values - values.mean(axis=0)


def _correlation(a: np.ndarray, b: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Return the correlation (load,) of deviations; 0 where the subwindows are not the same.

    Between loads at which the subwindows were solved it is interpolated.
    """
    if a.shape != b.shape:
        return np.zeros(load.shape)
    with np.errstate(invalid="ignore", divide="ignore"):
        size = np.sqrt(np.sum(a**2, axis=0) * np.sum(b**2, axis=0))
        correlation = np.sum(a * b, axis=0) / size
    indices = np.flatnonzero(np.isfinite(correlation))
    if not indices.size:
        return np.zeros(load.shape)
    return np.clip(extend_to_loads(correlation[indices], indices, load), -1.0, 1.0)


def _unshared_half_widths(
    a: np.ndarray, b: np.ndarray, correlation: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the half-widths (load,) of a difference, down and up, from (load, source, component)."""
    widths = []
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
    return widths[0], widths[1]


def _largest_source(a: np.ndarray, b: np.ndarray, correlation: np.ndarray) -> np.ndarray:
    """Return the index (load,) of the source with the largest part in a difference."""
    by_source = [
        np.maximum(*_unshared_half_widths(a[:, [k]], b[:, [k]], correlation[..., [k]]))
        for k in range(len(SOURCES))
    ]
    return np.nan_to_num(by_source, nan=0.0).argmax(axis=0)


def _effects(values: Sequence[np.ndarray], parts: Sequence[Sequence[str]]) -> list[Effects]:
    """Return the random effects of each group, of values (map, load)."""
    return [random_effects(of_maps, names) for of_maps, names in zip(values, parts, strict=True)]


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
) -> list[np.ndarray]:
    """Return ratio and both ends of its interval (load,), from two values and their components on the scale.

    `scatter` is the half-width (load,) of the difference of logarithms by the scatter of the maps.
    """
    mean, second_mean = (_logarithm(name, number) for number in values)
    difference = second_mean - mean
    a, b = (_log_widths(name, *pair) for pair in zip(values, widths, strict=True))
    below, above = (np.hypot(scatter, side) for side in _unshared_half_widths(a, b, correlation))
    with np.errstate(invalid="ignore", over="ignore"):  # of closed gaps and unbounded ends, NaN below
        bounds = difference, difference - below, difference + above
        ratios = [np.exp(mean + values) / np.exp(mean) for values in bounds]
    return [np.where(np.isfinite(values), values, np.nan) for values in ratios]


def _logarithm(name: str, values: np.ndarray) -> np.ndarray:
    """Return the logarithm of a quantity from its scale, which is that of most."""
    if name != AREA:
        return values
    with np.errstate(divide="ignore"):  # of an unbounded area
        return np.log(from_scale(name, values))


def _log_widths(name: str, mean: np.ndarray, widths: np.ndarray) -> np.ndarray:
    """Return half-widths (load, source, component) on the logarithm from those on the scale."""
    if name != AREA:
        return widths
    # an area near the whole moves less than its scale: what both share changes their ratio
    signs, middle = np.array([-1.0, 1.0, -1.0, 1.0]), mean[:, None, None]
    return signs * (_logarithm(name, middle + signs * widths) - _logarithm(name, middle))


def _table(names: Sequence[str], loads: np.ndarray, rows: Sequence[Sequence[np.ndarray]]) -> xr.Dataset:
    """Return ratios and their ends, a row for each quantity, as a dataset."""
    keys = ("ratio", "ratio_lower", "ratio_upper")
    arrays = np.reshape(rows, (len(names), len(keys), loads.size))
    return xr.Dataset(
        {key: (("quantity", "load"), arrays[:, index]) for index, key in enumerate(keys)},
        {"quantity": np.array(names, object), "mean_pressure": ("load", loads)},
    )
