"""Differences between groups of maps, and between two results that share their map, area or faces.

They are ratios of the second to the first: all numbers are logarithms here, the scale of a gap. Of errors
with the half-widths u1 and u2 and the correlation r, what is shared cancels:
u² = (u2 - r u1)² + (1 - r²) u1² (JCGM 100:2008, 5.2.2).
"""

import math
from collections.abc import Collection, Mapping, Sequence
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ENDS
from roughcontact.arguments.quantities import percent
from roughcontact.arguments.si import as_declared
from roughcontact.errors import SettingsError
from roughcontact.statistics.kinds import check_sizes
from roughcontact.statistics.load_pairs import common_loads, interpolated, paired_loads, slopes_of
from roughcontact.uncertainty import random_effects
from roughcontact.uncertainty.combination import SIGNS, SOURCES
from roughcontact.uncertainty.groups import check_alike, scaled_components
from roughcontact.uncertainty.improvement import ADVICE
from roughcontact.uncertainty.members import SHARED
from roughcontact.uncertainty.scales import CONSTRICTIONS, GAP, headline_names, to_scale

RELEVANT = 0.1  # relative difference that matters, unless another one is stated
DIFFER = "differ"
_MAX_MAPS = 500  # maps: more are not asked for
_MIN_DIFFERENCE = 1e-4  # relative difference: no smaller one is named
_MORE_PLACES = "measure several places of each"
_RATIOS = tuple(f"ratio{suffix}" for suffix in ENDS)
_ALL_CASES = 3  # up to so many, every two are compared
COMPARED = (*_RATIOS, "p_value", "outcome")
# what an outcome is told from: of groups also the standard deviation of a part (of a pair of maps), and the
# half-width that more maps make no smaller; the index of the source with the largest part in what differs
_COLUMNS = (*_RATIOS, "p_value", "spread", "shared", "largest_source")


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
    count = min(data.sizes["load"] for data in (first, second))
    maps = [data.isel(load=slice(count)) for data in (first, second)]
    return _compare_two_maps(maps)[[*_RATIOS]].drop_attrs()


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


def _of_map(name: str, data: xr.Dataset, loads: np.ndarray | None, of_place: bool) -> tuple[np.ndarray, ...]:
    """Return value (load), components (load, source, component), deviations of subwindows (load, member).

    An interval without components stands in a single source, with NaN where there is none. Of this place
    alone the source `window` has what the interval of the map between its borders leaves to it, and the value
    is without what an overview shows of others. Numbers are interpolated to the `loads`, if any.
    """

    def reach(endings: Sequence[str]) -> np.ndarray:
        """Return how far the ends of an interval lie below and above the value (side, load)."""
        bounds = [to_scale(GAP, data.get(f"{name}{key}", np.nan * data[name]).values) for key in endings]
        return SIGNS[:2] * (np.array(bounds) - value)

    fine_map = data.get(f"{name}_alone", data[name])  # NaN of a map beside others with an overview
    value = _logarithm((fine_map.fillna(data[name]) if of_place else data[name]).values)
    widths = scaled_components(name, data, scale=GAP)
    if f"{name}_components" not in data:
        widths[:, 0, :2] = reach(ENDS[1:]).T
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
    if loads is None:
        return value, widths, deviations.T
    at_loads = partial(interpolated, data["mean_pressure"].values, loads)
    return at_loads(value, slopes_of(name, data)), at_loads(widths), at_loads(deviations.T)


def _compare_two_maps(
    maps: Sequence[xr.Dataset], loads: np.ndarray | None = None, *, of_place: bool = False
) -> xr.Dataset:
    """Return the comparison of two maps, of this place alone or not, without a judgement.

    They have the same loads in order, or their numbers are interpolated to the `loads`.
    """
    at_loads = maps[0]["mean_pressure"].values if loads is None else loads
    rows = {}
    for name in _names(*maps):
        numbers = [_of_map(name, data, loads, of_place=of_place) for data in maps]
        values, widths, deviations = zip(*numbers, strict=True)
        correlations = np.tile(_source_correlations(*maps), (at_loads.size, 1))
        correlations[:, SOURCES.index("window")] = _correlations(deviations)
        if any(f"{name}_components" not in data for data in maps):
            correlations = 0 * correlations  # nothing is known of what they share
        rows[name] = _row(widths, correlations, values[1] - values[0])
    return _table(rows, at_loads, of_place=of_place)


def _compared(first: xr.Dataset, second: xr.Dataset, *, paired: bool) -> xr.Dataset:
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
        if paired:
            effects = [random_effects.random_effects(values[1] - values[0], part_names[0])]
            difference, error, freedom = effects[0].mean, effects[0].error, effects[0].freedom
        else:
            effects = [random_effects.random_effects(*pair) for pair in zip(values, part_names, strict=True)]
            difference, error, freedom = random_effects.welch(*effects)
        units = min(effect.units for effect in effects)
        spread = np.sqrt(np.mean([effect.error**2 * effect.units for effect in effects], axis=0))
        rows[name] = _row(shared, correlation, difference, (error, freedom, spread))
    noun = "part" if any(1 < len(set(names)) < len(names) for names in part_names) else "map"
    return _table(rows, loads, paired=paired, units=units, noun=noun)


def _row(
    widths: Sequence[np.ndarray],
    correlation: np.ndarray,
    difference: np.ndarray,
    by_maps: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None,
) -> dict[str, np.ndarray]:
    """Return what tells two results apart in a quantity (load), from the difference of their logarithms.

    `widths` are the components of both, `by_maps` its standard uncertainty by the scatter of the maps of
    groups, with its degrees of freedom, and their standard deviation; of two maps all is in the `widths`.
    """
    unshared_widths = _unshared(widths, correlation)
    half_widths = [np.sqrt(squares.sum(axis=-1)) + shifts.sum(axis=-1) for squares, shifts in unshared_widths]
    by_source = [np.sqrt(squares) + shifts for squares, shifts in unshared_widths]
    if by_maps:
        error, freedom, spread = by_maps
        scatter = random_effects.student(freedom) * error
    else:
        scatter, freedom, spread = (np.full(difference.shape, number) for number in (0.0, np.inf, np.nan))
        error = np.where(difference > 0, *half_widths) / random_effects.student(freedom)  # towards none
    below, above = (np.hypot(scatter, side) for side in half_widths)
    with np.errstate(invalid="ignore", over="ignore"):  # of closed gaps and unbounded ends, NaN below
        ratios = np.exp([difference, difference - below, difference + above])
    p_values = random_effects.p_value(difference, error, freedom)
    return {
        **dict(zip(_RATIOS, np.where(np.isfinite(ratios), ratios, np.nan), strict=True)),
        "p_value": random_effects.adjust_over_loads(p_values),
        "spread": spread,
        "shared": np.maximum(*half_widths),
        "largest_source": np.nan_to_num(np.maximum(*by_source), nan=0.0).argmax(axis=1),
    }


def _table(rows: Mapping[str, Mapping[str, np.ndarray]], loads: np.ndarray, **attrs: Any) -> xr.Dataset:
    """Return a comparison (quantity, load) of two results from its rows, without a judgement.

    Attributes are, of groups, the `units` (maps or parts, by their `noun`) of the smaller one, and whether
    they are `paired`; of two maps, whether they are `of_place`, and of no other.
    """
    dims, shape = ("quantity", "load"), (len(rows), loads.size)
    columns = {key: (dims, np.reshape([row[key] for row in rows.values()], shape)) for key in _COLUMNS}
    labels = {"quantity": np.array([*rows], object), "mean_pressure": ("load", loads)}
    return xr.Dataset(columns, labels, attrs)


def _judged(comparisons: Mapping[Any, xr.Dataset], relevant: float = RELEVANT) -> dict[Any, xr.Dataset]:
    """Return the comparisons with p-values adjusted for all of them, and with outcomes."""
    for name in {name for data in comparisons.values() for name in data["quantity"].values}:
        family = [data["p_value"] for data in comparisons.values() if name in data["quantity"]]
        adjusted = random_effects.holm([table.loc[name].values for table in family])
        for of_pair, p_values in zip(family, adjusted, strict=True):
            of_pair.loc[name] = p_values
    judged = {}
    for key, data in comparisons.items():
        rows = data[[*_COLUMNS]].to_dataframe(dim_order=["quantity", "load"]).to_dict("records")
        outcomes = np.array([_outcome(row, data.attrs, relevant) for row in rows], object)
        outcomes = outcomes.reshape(data["ratio"].shape)
        judged[key] = data.assign(outcome=(("quantity", "load"), outcomes))[[*COMPARED]].drop_attrs()
    return judged


def _outcome(numbers: Mapping[Any, float], row: Mapping[str, Any], relevant: float) -> str:
    """Return whether two results differ in a quantity under a load, in words, from numbers of `_table`."""
    _, low, high = (numbers[key] for key in _RATIOS)
    if not np.isfinite([low, high, numbers["p_value"]]).all():
        return "inconclusive: no interval"
    if numbers["p_value"] < random_effects.SIGNIFICANCE and not low <= 1 <= high:
        return DIFFER
    if (largest_ratio := max(1 - low, high - 1)) <= relevant:
        return f"do not differ by more than {percent(max(largest_ratio, _MIN_DIFFERENCE))}"
    return f"inconclusive: {_what_decides(numbers, row, relevant)}"


def _what_decides(numbers: Mapping[Any, float], row: Mapping[str, Any], relevant: float) -> str:
    """Return what would show a difference that matters: more maps, or a smaller error that all maps share."""
    cause = SOURCES[int(numbers["largest_source"])]
    if "of_place" in row:
        errors = percent(numbers["ratio_upper"] / numbers["ratio"] - 1)
        way = ADVICE.get(cause, "measure a longer field") if row["of_place"] else _MORE_PLACES
        return f"errors that differ are up to {errors}, most by the {cause}; {way}"
    target = math.log1p(relevant)
    maps = random_effects.maps_needed(numbers["spread"], target, pairs=row["paired"])
    missing_maps = max(maps - row["units"], 1)
    count = f"more than {_MAX_MAPS}" if missing_maps > _MAX_MAPS else f"about {missing_maps}"
    nouns, group = "s" if missing_maps > 1 else "", "" if row["paired"] else " per group"
    more_maps = f"{count} more {row['noun']}{nouns}{group} needed"
    if numbers["shared"] < target:
        return more_maps
    advice = ADVICE.get(cause, "state what they share")
    # no number of maps tells alone
    return f"{more_maps}, and smaller errors that all maps share (above {percent(relevant)}): {advice}"


def _names(one: xr.Dataset, another: xr.Dataset) -> list[str]:
    """Return the quantities of both that have ratios."""
    return [name for name in headline_names(one) if name in another and name not in CONSTRICTIONS]


def _of_group(name: str, group: xr.Dataset, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of the maps of a group (map, load), and the components that these share."""
    load, of_maps = group["mean_pressure"].values, _logarithm(group[f"{name}_of_maps"].values)
    is_shared = np.isin(SOURCES, (*SHARED, "solver"))[:, None]
    shared = np.where(is_shared, scaled_components(name, group, ending="shared", scale=GAP), 0.0)
    return interpolated(load, loads, of_maps.T).T, interpolated(load, loads, shared)


def _logarithm(values: np.ndarray) -> np.ndarray:
    """Return the logarithm of numbers, NaN of zero and of infinity, as of a conductance in full contact."""
    return to_scale(GAP, np.where(np.isinf(values), np.nan, values))


def _source_correlations(one_group: xr.Dataset, another: xr.Dataset) -> np.ndarray:
    """Return the correlations (source) of the errors of two results that were measured and solved alike."""
    moduli = [float(data.get("contact_modulus", np.nan)) for data in (one_group, another)]
    independent = {"solver"} | ({"material"} if moduli[0] != moduli[1] else set())
    return np.array([0.0 if source in independent else 1.0 for source in SOURCES])


def _correlations(deviations: Sequence[np.ndarray]) -> np.ndarray:
    """Return the correlations (load) of the deviations (load, member) of the subwindows of two results."""
    a, b = deviations
    if a.shape != b.shape:  # the subwindows are not the same
        return np.zeros(len(a))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlations = np.sum(a * b, axis=1) / np.sqrt(np.sum(a**2, axis=1) * np.sum(b**2, axis=1))
    return np.clip(np.nan_to_num(correlations), -1.0, 1.0)


def _unshared(pair: Sequence[np.ndarray], correlation: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return squares and shifts (load, source) of a difference, down and up, from components of two results.

    The components are (load, source, component).
    """
    (a, b), sides = pair, []
    for side, opposite in ((0, 1), (1, 0)):
        # of the first error, the side that goes along with this one, and the one that goes against it
        along = np.where(correlation >= 0, a[..., side], a[..., opposite])
        with np.errstate(invalid="ignore"):
            squares = (b[..., side] - correlation * along) ** 2
            independent = (1 - correlation**2) * a[..., opposite] ** 2
            squares = squares + np.where(correlation**2 < 1, independent, 0.0)
            shifts = np.maximum(b[..., 2 + side] - a[..., 2 + side], 0.0)
            shifts = shifts + np.maximum(a[..., 2 + opposite] - b[..., 2 + opposite], 0.0)
        sides.append((squares, shifts))
    return sides
