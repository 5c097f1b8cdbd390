"""Differences between groups of maps, and between two results that share their map, place or faces.

Both are evaluated on the scales of `groups`, as ratios of the second to the first. What two results share
cancels: of errors with the half-widths u1 and u2 and the correlation r the difference keeps ([1]_, 5.2.2)

    u² = (u2 - r u1)² + (1 - r²) u1²

References
----------
.. [1] JCGM 100:2008, Guide to the expression of uncertainty in measurement.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
import xarray as xr

from roughcontact.errors import SettingsError
from roughcontact.quantities import percent
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.ensemble import at_all_loads
from roughcontact.uncertainty.groups import (
    HEIGHTS,
    SAME_LOAD,
    SHARED,
    at_loads,
    check_alike,
    common_loads,
    from_scale,
    needed_for_groups,
    scaled_components,
    to_scale,
)
from roughcontact.uncertainty.headline import quantities_in
from roughcontact.uncertainty.random_effects import (
    SIGNIFICANCE,
    correlation_at_least,
    holm,
    maps_needed,
    over_loads,
    p_value,
    random_effects,
    student,
    welch,
)

RELEVANT = 0.1  # relative difference that matters, unless another one is stated
DIFFER = "differ"
_MOST = 500  # maps: more are not asked for
_LEAST = 1e-4  # relative difference: no smaller one is named
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
        they are then compared map by map, at the loads that `shared_loads` finds, if any.

    Returns
    -------
    Dataset
        dims (quantity, load): `ratio` of the second to the first, `ratio_lower`, `ratio_upper` (95 % interval
        of this ratio), `p_value` (Welch's test [1]_, adjusted for all loads [2]_), and `outcome`:
        "differ", "do not differ by more than x", or "cannot tell", with the number of maps that would.
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
    [['cannot tell: 306 more maps of each would']]
    """
    return _judged([_compared(first, second, paired=paired)], relevant)[0]


def compare_all(
    groups: Mapping[str, xr.Dataset],
    *,
    relevant: float = RELEVANT,
    cases: Sequence[tuple[str, str]] = (),
    same_places: Sequence[Sequence[str]] = (),
) -> tuple[dict[tuple[str, str], xr.Dataset], list[str]]:
    """Return the comparisons of every two groups by their names, and a sentence for each that is left out.

    The p-values are adjusted for all loads and pairs together. `cases` are pairs of names of the same maps
    under two cases, compared instead of every two groups; `same_places` are names of every two maps of the
    same place: two groups of the same places are compared map by map.
    """
    found, left_out = {}, []
    both = {*map(tuple, same_places), *(tuple(pair)[::-1] for pair in same_places)}
    for pair in cases or combinations(groups, 2):
        one, two = (groups[name].assign_attrs(group=name) for name in pair)
        earlier = [
            "".join(other for other in one["map"].values if (other, name) in both)
            for name in two["map"].values
        ]
        paired = bool(cases) or sorted(earlier) == sorted(one["map"].values)
        try:
            found[pair] = _compared(
                one, two if cases or not paired else two.assign_coords(map=earlier), paired=paired
            )
        except SettingsError as error:
            left_out.append(str(error))
    return dict(zip(found, _judged(list(found.values()), relevant), strict=True)), left_out


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


def shared_loads(datasets: Sequence[xr.Dataset]) -> list[np.ndarray]:
    """Return the places of the loads that all datasets share, for each of them, in the order of the first.

    Loads are the same by mean pressure, or by pressure relative to E* g (to E*, where g is not known), by
    whichever more of them are.

    Examples
    --------
    >>> steel, rubber = (xr.Dataset({"mean_pressure": ("load", loads)}) for loads in ([1.0, 2.0], [2.0, 4.0]))
    >>> [places.tolist() for places in shared_loads([steel, rubber])]
    [[1], [0]]
    >>> moduli = {"contact_modulus": 10.0}, {"contact_modulus": 20.0}
    >>> both = [data.assign(known) for data, known in zip((steel, rubber), moduli)]
    >>> [places.tolist() for places in shared_loads(both)]
    [[0, 1], [0, 1]]
    """
    in_pascal = [data["mean_pressure"] for data in datasets]
    relative = [
        data.get("relative_pressure", load / data.get("contact_modulus", np.nan))
        for data, load in zip(datasets, in_pascal, strict=True)
    ]
    found = []
    for loads in (in_pascal, relative):
        same = [np.isclose(loads[0].values[:, None], other.values, rtol=SAME_LOAD, atol=0) for other in loads]
        shared = np.all([each.any(axis=1) for each in same], axis=0)
        found.append([each[shared].argmax(axis=1) for each in same])
    return max(found, key=lambda places: places[0].size)


def case_differences(first: xr.Dataset, second: xr.Dataset) -> xr.Dataset:
    """Return the ratios of the results of one map under two cases, without what both share.

    The two may also be maps of the same place, measured again, or placements of the same two faces. Loads are
    compared in order, first with first. The errors of both are taken as correlated as the results of the same
    parts of the window (`window`) are; those of the solver are independent, those of the material where the
    moduli differ; all others are the same.

    `ratio`, `ratio_lower` and `ratio_upper` (quantity, load) are those of the second to the first; NaN where
    a number is not positive, has no uncertainty, or nothing bounds the difference.

    Examples
    --------
    >>> gap = xr.Dataset({"mean_gap": ("load", [2e-6]), "mean_pressure": ("load", [1e6])})
    >>> case_differences(gap, gap * 2)["ratio"].item()
    2.0
    """
    return _of_two(first, second).table


def compare_maps(
    pairs: Mapping[tuple[str, str], tuple[xr.Dataset, xr.Dataset]], *, relevant: float = RELEVANT
) -> tuple[dict[tuple[str, str], xr.Dataset], list[str]]:
    """Return the comparisons of maps of the same place, or of placements of the same faces, by their names.

    Each is `case_differences` at the mean pressures that both have, or reach by interpolation, with `p_value`
    (that the ratio is 1, of a normal error of this interval, adjusted for all loads and pairs) and `outcome`,
    as of `compare_groups`. With them comes a sentence for each pair that cannot be compared.

    Examples
    --------
    >>> def gap(value):
    ...     sides = {"mean_gap": 1.0, "mean_gap_lower": 0.98, "mean_gap_upper": 1.02}
    ...     numbers = {name: ("load", [value * by]) for name, by in sides.items()}
    ...     return xr.Dataset({"mean_pressure": ("load", [1e6]), **numbers})
    >>> found, _ = compare_maps({("a", "b"): (gap(1.0), gap(1.5))})
    >>> found["a", "b"]["outcome"].item()
    'differ'
    """
    found, left_out = {}, []
    for pair, maps in pairs.items():
        try:
            check_alike(" and ".join(pair), pair, maps)
            found[pair] = _of_two(*_at_common_loads(pair, maps))
        except SettingsError as error:
            left_out.append(str(error))
    return dict(zip(found, _judged(list(found.values()), relevant), strict=True)), left_out


def _at_common_loads(names: Sequence[str], maps: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Return what comparisons need of two maps, loads rising, at the mean pressures that both reach."""
    loads = common_loads(" and ".join(names), names, maps)
    found = []
    for data in maps:
        own, quantities = data["mean_pressure"].values, quantities_in(data)
        kept, columns = data[needed_for_groups(map(str, data.variables))], {}
        for name in [name for name, variable in kept.variables.items() if "load" in variable.dims]:
            known = kept[name].transpose("load", ...)
            values = to_scale(name, known.values) if name in quantities else known.values
            values = at_loads(own, loads, values)
            columns[name] = known.dims, from_scale(name, values) if name in quantities else values
        found.append(kept.drop_vars([*columns]).assign(columns).assign(mean_pressure=("load", loads)))
    return found


def _widths(name: str, data: xr.Dataset) -> np.ndarray:
    """Return the components (load, source, component) of a map; of an interval that has none its half-widths.

    These stand in a single source; NaN where there is no interval.
    """
    if f"{name}_components" in data:
        return scaled_components(name, data)
    found = np.zeros((data.sizes["load"], len(SOURCES), 4))
    middle = to_scale(name, data[name].values)
    for place, (end, sign) in enumerate((("lower", -1.0), ("upper", 1.0))):
        values = data.get(f"{name}_{end}", data[name] * np.nan).values
        found[:, 0, place] = sign * (to_scale(name, values) - middle)
    return found


class _Compared(NamedTuple):
    """The ratios of two groups, and what a judgement of them needs, arrays (quantity, load)."""

    table: xr.Dataset
    p_value: np.ndarray
    spread: np.ndarray  # standard deviation of a part (a pair of maps, where they are paired), on the scale
    shared: np.ndarray  # half-width, on the scale, that more maps would not make smaller
    mean: np.ndarray  # of the first group, on the scale
    parts: int  # of the smaller group; 0 for two maps, of which more would not tell
    noun: str  # what more of would tell
    paired: bool
    alike: list[np.ndarray]  # of each quantity, correlations (load, load) of the scatter, at least


def _of_two(first: xr.Dataset, second: xr.Dataset) -> _Compared:
    """Return the comparison of two maps, without a judgement."""
    loads = min(first.sizes["load"], second.sizes["load"])
    one, two = (data.isel(load=slice(loads)) for data in (first, second))
    names, nothing = _names(one, two), np.zeros(loads)
    rows, p_values = [], []
    for name in names:
        before, after = (to_scale(name, data[name].values) for data in (one, two))
        left = _left(_widths(name, one), _widths(name, two), _correlations(name, one, two))
        rows.append(_ratios(name, before, after - before, nothing, left))
        towards_none = np.where(after > before, *left) / student(np.array(np.inf))
        p_values.append(p_value(after - before, towards_none, nothing + np.inf))
    table = _table(names, one["mean_pressure"].values, rows)
    found = np.reshape(p_values, (len(names), loads))
    # nothing is known of how the errors at two loads go together
    alike, none = [np.eye(loads)] * len(names), np.zeros(found.shape)
    return _Compared(table, found, none, none, none, parts=0, noun="", paired=True, alike=alike)


def _compared(first: xr.Dataset, second: xr.Dataset, *, paired: bool) -> _Compared:
    """Return the comparison of two groups, without a judgement."""
    words = [data.attrs.get("group") or noun for data, noun in ((first, "the first"), (second, "the second"))]
    for word, data in zip(words, (first, second), strict=True):
        if data.sizes["map"] < 2:
            raise SettingsError(
                f"compare_groups: {word} has a single map, whose scatter is not known; add maps, or compare "
                "both maps with compare_statistics"
            )
    if paired and set(first["map"].values) != set(second["map"].values):
        raise SettingsError(
            f"compare_groups: {words[0]} and {words[1]} are not of the same maps; leave `paired` out"
        )
    for name, content in () if paired else zip(first["map"].values, first["content"].values, strict=True):
        if content and content in second["content"]:
            copied = second["map"].values[second["content"].values == content][0]
            raise SettingsError(
                f"compare_groups: {name} of {words[0]} and {copied} of {words[1]} have the same results, as "
                "copies of one map have; leave one out"
            )
    if paired:
        second = second.sel(map=first["map"].values)
        same = shared_loads([first, second])
        if same[0].size:
            first, second = first.isel(load=same[0]), second.isel(load=same[1])
            second = second.assign_coords(mean_pressure=first["mean_pressure"])
    groups = first, second
    loads = common_loads(" and ".join(words), words, groups)
    correlation = _alike(first, second)
    names = _names(first, second)
    parts = 0
    rows, columns, alike = [], [], []
    of_parts = [list(data["part"].values) for data in groups]
    for name in names:
        (values, shared), (others, of_others) = (_at(name, data, loads) for data in groups)
        one, two = random_effects(values, of_parts[0]), random_effects(others, of_parts[1])
        if paired:
            change = random_effects(others - values, of_parts[0])
            off = change.deviations
            difference, error, freedom = change.mean, change.error, change.freedom
            spread, parts = error * math.sqrt(change.units), change.units
        else:
            difference, error, freedom = welch(one, two)
            off = np.concatenate([one.deviations, two.deviations])
            spread = np.sqrt((one.error**2 * one.units + two.error**2 * two.units) / 2)
            parts = min(one.units, two.units)
        width, left = student(freedom) * error, _left(shared, of_others, correlation)
        alike.append(correlation_at_least(off, len(off) - (1 if paired else 2)))
        rows.append(_ratios(name, one.mean, difference, width, left))
        columns.append((p_value(difference, error, freedom), spread, np.maximum(*left), one.mean))
    nested = any(1 < len(set(data["part"].values)) < data.sizes["map"] for data in groups)
    table = _table(names, loads, rows)
    p_values, spreads, lefts, means = (
        np.reshape([column[place] for column in columns], (len(names), loads.size)) for place in range(4)
    )
    noun = "part" if nested else "map"
    return _Compared(
        table, p_values, spreads, lefts, means, parts=parts, noun=noun, paired=paired, alike=alike
    )


def _judged(found: Sequence[_Compared], relevant: float) -> list[xr.Dataset]:
    """Return the comparisons with p-values adjusted for all of them and their loads, and with outcomes."""
    adjusted = [np.full(one.p_value.shape, np.nan) for one in found]
    places: dict[str, list[tuple[int, int]]] = {}
    for pair, one in enumerate(found):
        for row, name in enumerate(one.table["quantity"].values):
            places.setdefault(name, []).append((pair, row))
    for each in places.values():
        together = [over_loads(found[pair].p_value[row], found[pair].alike[row]) for pair, row in each]
        for (pair, row), values in zip(each, holm(together), strict=True):
            adjusted[pair][row] = values
    return [
        one.table.assign(
            p_value=(("quantity", "load"), values),
            outcome=(("quantity", "load"), _outcomes(one, values, relevant)),
        )
        for one, values in zip(found, adjusted, strict=True)
    ]


def _outcomes(found: _Compared, p_values: np.ndarray, relevant: float) -> np.ndarray:
    """Return for each ratio whether the groups differ, in words."""
    words = np.full(p_values.shape, "", object)
    ends = np.stack([found.table[f"ratio_{end}"].values for end in ("lower", "upper")])
    for place in np.ndindex(*p_values.shape):
        low, high = ends[(slice(None), *place)]
        if not np.isfinite([low, high, p_values[place]]).all():
            words[place] = "cannot tell: no interval"
        elif p_values[place] < SIGNIFICANCE and not low <= 1 <= high:
            words[place] = DIFFER
        elif (most := max(1 - low, high - 1)) <= relevant:
            words[place] = f"do not differ by more than {percent(max(most, _LEAST))}"
        else:
            words[place] = f"cannot tell: {_more(found, place, relevant)}"
    return words


def _more(found: _Compared, place: tuple[int, ...], relevant: float) -> str:
    """Return how many more maps would show a difference that matters."""
    name = str(found.table["quantity"].values[place[0]])
    mean = found.mean[place]
    ends = to_scale(name, from_scale(name, mean) * np.array([1 - relevant, 1 + relevant]))
    target = float(np.nanmin(np.abs(ends - mean)))
    if not found.parts:
        ratio, upper = (float(found.table[key].values[place]) for key in ("ratio", "ratio_upper"))
        return f"errors that they do not share are up to {percent(upper / ratio - 1)}"
    if found.shared[place] >= target:
        return f"all maps share errors of more than {percent(relevant)}; more maps would not help"
    needed = maps_needed(float(found.spread[place]), target, paired=found.paired)
    more = max(needed - found.parts, 1)
    count = f"more than {_MOST}" if more > _MOST else str(more)
    return f"{count} more {found.noun}{'s' if more > 1 else ''}{'' if found.paired else ' of each'} would"


def _names(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """Return the quantities of both that have ratios."""
    return [name for name in quantities_in(first) if name in first and name in second and name not in HEIGHTS]


def _at(name: str, group: xr.Dataset, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the maps of a group on their scale (map, load), and what these share."""
    own = group["mean_pressure"].values
    of_maps = to_scale(name, group[f"{name}_of_maps"].values)
    shared = group[f"{name}_shared"].values
    kept = np.array([source in (*SHARED, "solver") for source in SOURCES])[:, None]
    shared = np.where(kept, np.where(np.isnan(shared), np.inf, shared), 0.0)
    return at_loads(own, loads, of_maps.T).T, at_loads(own, loads, shared)


def _alike(first: xr.Dataset, second: xr.Dataset) -> np.ndarray:
    """Return the correlations (source) of the errors of two results that were measured and solved alike."""
    moduli = [float(data.get("contact_modulus", np.nan)) for data in (first, second)]
    independent = {"solver"} | ({"material"} if moduli[0] != moduli[1] else set())
    return np.array([0.0 if source in independent else 1.0 for source in SOURCES])


def _correlations(name: str, first: xr.Dataset, second: xr.Dataset) -> np.ndarray:
    """Return the correlations (load, source) of the errors of one map under two cases."""
    found = np.tile(_alike(first, second), (first.sizes["load"], 1))
    if any(f"{name}_components" not in data for data in (first, second)):
        return 0 * found  # nothing is known of what they share
    one, two = (_deviations(name, data) for data in (first, second))
    found[:, SOURCES.index("window")] = _correlation(one, two, first["mean_pressure"].values)
    return found


def _deviations(name: str, data: xr.Dataset) -> np.ndarray:
    """Return the deviations (member, load) of the subwindows from their mean, on the scale."""
    if f"{name}_parts" not in data:
        return np.empty((0, data.sizes["load"]))
    members = data[f"{name}_parts"].transpose(..., "load")
    known = np.isfinite(members.values).any(axis=1)  # the others are padding
    scaled = to_scale(name, members.values[known])
    return scaled - scaled.mean(axis=0)


def _correlation(first: np.ndarray, second: np.ndarray, load: np.ndarray) -> np.ndarray:
    """Return the correlation (load,) of deviations; 0 where the subwindows are not the same.

    Between loads at which the subwindows were solved it is interpolated.
    """
    if first.shape != second.shape:
        return np.zeros(load.shape)
    with np.errstate(invalid="ignore", divide="ignore"):
        size = np.sqrt(np.sum(first**2, axis=0) * np.sum(second**2, axis=0))
        found = np.sum(first * second, axis=0) / size
    solved = np.flatnonzero(np.isfinite(found))
    return (
        np.clip(at_all_loads(found[solved], solved, load), -1.0, 1.0) if solved.size else np.zeros(load.shape)
    )


def _left(first: np.ndarray, second: np.ndarray, correlation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the half-widths (load,) of a difference, down and up, from (load, source, component)."""
    widths = []
    for side, other in ((0, 1), (1, 0)):
        # of the first error, the side that goes along with this one, and the one that goes against it
        along = np.where(correlation >= 0, first[..., side], first[..., other])
        with np.errstate(invalid="ignore"):
            squares = (second[..., side] - correlation * along) ** 2
            squares = squares + np.where(
                correlation**2 < 1, (1 - correlation**2) * first[..., other] ** 2, 0.0
            )
            shifts = np.maximum(second[..., 2 + side] - first[..., 2 + side], 0.0)
            shifts = shifts + np.maximum(first[..., 2 + other] - second[..., 2 + other], 0.0)
            widths.append(np.sqrt(squares.sum(axis=-1)) + shifts.sum(axis=-1))
    return widths[0], widths[1]


def _ratios(
    name: str,
    mean: np.ndarray,
    difference: np.ndarray,
    width: np.ndarray,
    left: tuple[np.ndarray, np.ndarray],
) -> list[np.ndarray]:
    """Return ratio and both ends of its interval (load,), from a difference on the scale."""
    down, up = (np.hypot(width, each) for each in left)
    base = from_scale(name, mean)
    ratios = [
        from_scale(name, mean + each) / base for each in (difference, difference - down, difference + up)
    ]
    return [np.where(np.isfinite(each), each, np.nan) for each in ratios]


def _table(names: Sequence[str], loads: np.ndarray, rows: Sequence[Sequence[np.ndarray]]) -> xr.Dataset:
    """Return ratios and their ends, a row for each quantity, as a dataset."""
    keys = ("ratio", "ratio_lower", "ratio_upper")
    arrays = np.reshape(rows, (len(names), len(keys), loads.size))
    return xr.Dataset(
        {key: (("quantity", "load"), arrays[:, place]) for place, key in enumerate(keys)},
        {"quantity": np.array(names, object), "mean_pressure": ("load", loads)},
    )
