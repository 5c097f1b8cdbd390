"""One answer of several maps: of the maps of a part, the parts of a batch, the placements of two faces.

On the scale of a quantity U² = (t s)² + U_shared², with the standard uncertainty s of the mean of the maps
and Student's t (`random_effects`); U_shared, of discretisation, instrument, material and hidden waves, is
averaged over the maps and added once (JCGM 100:2008, 5.2). Window and solver are left out: the scatter holds
them. For the next map the variance of a single one is added. The group is what the maps are samples of,
without waves longer than a map.
"""

import hashlib
import json
from collections.abc import Iterable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import scipy
import xarray as xr

from roughcontact.errors import SettingsError
from roughcontact.io.instrument_kinds import of_name
from roughcontact.quantities import quantity
from roughcontact.uncertainty.combination import (
    SOURCES,
    Ends,
    added_up,
    component_from_units,
    ends_of,
    half_widths,
    limited,
)
from roughcontact.uncertainty.headline import quantities_in
from roughcontact.uncertainty.random_effects import grubbs_outliers, random_effects, student
from roughcontact.uncertainty.scales import (
    ANSWERS,
    CONSTRICTIONS,
    QUANTITIES,
    from_scale,
    to_scale,
)

SHARED = ("discretisation", "instrument", "material", "unresolved")
# the placements of two faces share their maps, and with them the places where these were measured
SHARED_BY_PLACEMENTS = (*SHARED, "window")
HEIGHTS = CONSTRICTIONS  # narrowest places: evaluated on their own scale
MIN_FOR_INTERVAL = 3  # parts, or maps, below which there is a range instead of an interval
SAME_LOAD = 1e-6  # relative
_GRID = "the grid"  # `band_reason` where no setting limits the band
# largest ratio of the limits of the bands of two maps: a tenth at the short end changes the area by 2 % (at a
# Hurst exponent of 0.8); the long end matters to the gap alone, and windows differ in size
_SAME_BAND = {"shortest": 1.1, "longest": 2.0}
_ENDS = ("lower", "upper")
_FURTHER = ("next_lower", "next_upper", "next_part_lower", "next_part_upper")


class Scaled(NamedTuple):
    """A quantity of several maps on its scale, at the loads (Pa) of their group."""

    values: np.ndarray  # (map, load)
    # (load, source, component), mean of the maps: half-widths and shifts, down and up, by `SOURCES`
    shared: np.ndarray
    load: np.ndarray
    hardness: float | None  # Pa


def needed_for_groups(names: Iterable[str]) -> list[str]:
    """Return those variables of a file of statistics that groups, and differences of maps, are made of.

    Examples
    --------
    >>> needed_for_groups(["mean_gap", "mean_gap_lower", "mean_gap_density", "iterations"])
    ['mean_gap', 'mean_gap_lower']
    """
    ends = ("", "_lower", "_upper", "_components", "_parts")
    endings = {f"{name}{end}" for name in (*QUANTITIES, *ANSWERS) for end in ends}
    needed_names = {*endings, "mean_pressure", "contact_modulus", "hardness", "rms_height"}
    needed_names |= {"force", "contact_radius"}  # of bodies of finite size
    return [name for name in names if name in needed_names]


def group_statistics(
    datasets: Sequence[xr.Dataset],
    *,
    names: Sequence[str] | None = None,
    parts: Sequence[str] | None = None,
    group: str = "",
    placements: bool = False,
) -> xr.Dataset:
    """Return one answer of several maps of a finish, with its interval.

    Three parts (maps, where each is of its own part) or more have intervals, two have the range of their
    maps; a single map keeps its own numbers. Loads are those that all maps have; where these differ, also
    others within their common range, at which maps are interpolated (monotone cubic in the logarithm of the
    load, on the scale of the quantity), never beyond.

    Parameters
    ----------
    datasets : sequence of Dataset
        statistics of one map each, as `evaluate` or `read_statistics` returns them.
    names : sequence of str, optional
        names of the maps; "1", "2" ... by default.
    parts : sequence of str, optional
        the part that each map is of; each is its own part by default.
    group : str
        name of the group, for messages.
    placements : bool
        whether the maps are placements of the same two faces: the window part is then shared as well, and
        the interval is that of the next placement of newly measured faces.

    Returns
    -------
    Dataset
        along `load`, of each quantity that all maps have: `{quantity}` (back from the mean on its scale),
        `{quantity}_lower` and `_upper` of the 95 % interval of the mean, `{quantity}_next_lower` and
        `_next_upper` for the next map (of another part), `{quantity}_next_part_lower` and `_upper` for the
        mean of the next part, NaN without parts of several maps; `{quantity}_of_maps` (map, load);
        `{quantity}_between`, `{quantity}_within`: standard deviations on the scale, between parts and within
        one; `{quantity}_shared` (load, source, component): half-widths and shifts on the scale, mean of the
        maps; `stands_off` (map, load): 1 for a map that stands off the others in any quantity. Coordinates
        `map`, `part` (map), `content` (map; equal for copies), `mean_pressure` (load; Pa). Attributes:
        `group`, `remarks` (JSON: list of sentences).

    Raises
    ------
    SettingsError
        for no map, for copies of one, for different contact moduli, bands or kinds of instrument, and for
        maps without a common load.

    References
    ----------
    .. [1] Searle, Casella and McCulloch (1992), Variance Components, Wiley.
    .. [2] JCGM 100:2008, Guide to the expression of uncertainty in measurement, H.5.

    Examples
    --------
    >>> loads = {"mean_pressure": ("load", [1e6]), "contact_modulus": 1e9}
    >>> maps = [xr.Dataset({"mean_gap": ("load", [gap]), **loads}) for gap in (1e-6, 2e-6, 4e-6)]
    >>> found = group_statistics(maps)
    >>> [f"{found[f'mean_gap{end}'].item():.2e}" for end in ("_lower", "", "_upper")]
    ['3.57e-07', '2.00e-06', '1.12e-05']
    """
    if not len(datasets) or not all(isinstance(data, xr.Dataset) for data in datasets):
        raise SettingsError(
            "group_statistics: give the statistics of one or more maps, as evaluate returns them"
        )
    names = [str(index + 1) for index in range(len(datasets))] if names is None else [*map(str, names)]
    parts = names if parts is None else [*map(str, parts)]
    if not len(names) == len(parts) == len(datasets) == len(set(names)):
        raise SettingsError(
            f"group_statistics: {len(datasets)} maps, {len(names)} names, {len(parts)} parts; give one name "
            "of its own and one part for each map"
        )
    label = f"group {group}" if group else "the group"
    for name, data in zip(names, datasets, strict=True):
        if data["mean_pressure"].dims != ("load",):
            raise SettingsError(
                f"{label}: {name} holds several surfaces; select one of them for each map (.sel(surface=...))"
            )
    datasets = [_without_padding(data) for data in datasets]
    contents = [_content(data) for data in datasets]
    for name, content in () if placements else zip(names, contents, strict=True):
        if content and (copied := names[contents.index(content)]) != name:
            raise SettingsError(
                f"{label}: {copied} and {name} have the same results, as copies of one map have, which says "
                "nothing new; leave one out"
            )
    check_alike(label, names, datasets)
    loads = common_loads(label, names, datasets)
    quantities = [name for name in quantities_in(datasets[0]) if all(name in data for data in datasets)]
    columns: dict[str, tuple] = {}
    is_outlier = np.zeros((len(datasets), loads.size), bool)
    hardness = float(datasets[0].get("hardness", np.nan))
    for name in quantities:
        of_maps, shared = zip(*(scaled_at(name, data, loads) for data in datasets), strict=True)
        limit = hardness if np.isfinite(hardness) else None
        scaled = Scaled(np.stack(of_maps), np.mean(shared, axis=0), loads, limit)
        if len(datasets) == 1:
            columns |= _columns_of_map(name, datasets[0], scaled)
            continue
        quantity_columns, apart = _columns_of_maps(name, scaled, parts, placements=placements)
        columns |= quantity_columns
        is_outlier |= apart
        if placements and len(datasets) < MIN_FOR_INTERVAL:
            columns |= _hull(name, datasets, loads)
    columns["stands_off"] = (("map", "load"), is_outlier.astype(np.int8))
    columns["contact_modulus"] = ((), float(datasets[0].get("contact_modulus", np.nan)))
    if np.isfinite(hardness):
        columns["hardness"] = ((), hardness)
    if all("rms_height" in data for data in datasets):
        columns["rms_height"] = ((), float(np.median([float(data["rms_height"]) for data in datasets])))
    coordinates = {
        "source": [*SOURCES],
        "component": ["down", "up", "shift_down", "shift_up"],
        "mean_pressure": ("load", loads),
        "map": np.array(names, object),
        "part": ("map", np.array(parts, object)),
        "content": ("map", np.array(contents, object)),
    }
    remarks = _remarks(datasets, names, parts, loads, is_outlier, placements=placements)
    attrs = {"group": group, "remarks": json.dumps(remarks, ensure_ascii=False)}
    return xr.Dataset(columns, coordinates, attrs | {"body_size": _body_size(datasets[0])})


def is_range(answer: xr.Dataset) -> bool:
    """Return whether a group has a range instead of intervals, by `group_statistics`.

    Examples
    --------
    >>> is_range(xr.Dataset(coords={"map": ["a", "b", "c"], "part": ("map", ["p", "q", "q"])}))
    True
    """
    parts = len(set(answer["part"].values))
    return 1 < (answer.sizes["map"] if parts == 1 else parts) < MIN_FOR_INTERVAL


def _without_padding(data: xr.Dataset) -> xr.Dataset:
    """Return a map, loads rising, without what only others of its run have: loads, and a budget of NaN."""
    data = data.isel(load=np.isfinite(data["mean_pressure"].values)).sortby("mean_pressure")
    no_budget = [name for name in quantities_in(data) if np.isnan(data.get(f"{name}_lower", 0.0)).all()]
    padding = [f"{name}_{key}" for name in no_budget for key in (*_ENDS, "components")]
    return data.drop_vars(padding, errors="ignore")


def _content(dataset: xr.Dataset) -> str:
    """Return a digest of the numbers of a map, to nine digits; empty where its rms height is not known."""
    if "rms_height" not in dataset:
        return ""
    names = ["rms_height", "mean_pressure", *(name for name in quantities_in(dataset) if name in dataset)]
    digits = " ".join(f"{value:.8e}" for name in names for value in dataset[name].values.flat)
    return hashlib.sha256(digits.encode()).hexdigest()[:16]


def _columns_of_maps(
    name: str, scaled: Scaled, part_names: Sequence[str], *, placements: bool
) -> tuple[dict[str, tuple], np.ndarray]:
    """Return the columns of a quantity of several maps, and which of these stand off (map, load)."""
    effects = random_effects(scaled.values, part_names)
    sources = SHARED_BY_PLACEMENTS if placements else SHARED
    undefined = np.full(effects.mean.shape, np.nan)
    columns = {"": from_scale(name, effects.mean), **dict.fromkeys(_FURTHER, undefined)}
    if effects.units < MIN_FOR_INTERVAL:
        # a range, from map to map
        widths = {"": (effects.mean - scaled.values.min(axis=0), scaled.values.max(axis=0) - effects.mean)}
    else:
        mean = student(effects.freedom) * effects.error
        further = student(effects.next_map_freedom) * effects.next_map
        widths = {
            "": (further if placements else mean,) * 2,
            "next_": (further,) * 2,
            "next_part_": (student(effects.freedom) * effects.next_part,) * 2,
        }
    for key, widths_of_interval in widths.items():
        ends = _ends(name, effects.mean, widths_of_interval, scaled, sources)
        columns |= {f"{key}{end}": values for end, values in zip(_ENDS, ends, strict=True)}
    columns |= {"between": effects.between, "within": effects.within}
    return _named(name, columns, scaled), grubbs_outliers(scaled.values)


def _hull(name: str, datasets: Sequence[xr.Dataset], loads: np.ndarray) -> dict[str, tuple]:
    """Return the range of the intervals of maps: from the lowest end to the highest."""
    columns = {}
    for end, outermost in (("lower", np.min), ("upper", np.max)):
        of_maps = [
            at_loads(data["mean_pressure"].values, loads, data.get(f"{name}_{end}", data[name]).values)
            for data in datasets
        ]
        columns[f"{name}_{end}"] = ("load", outermost(of_maps, axis=0))
    return columns


def _columns_of_map(name: str, dataset: xr.Dataset, scaled: Scaled) -> dict[str, tuple]:
    """Return the columns of a quantity of a single map: what it was."""
    undefined = np.full(dataset.sizes["load"], np.nan)
    columns = {"": dataset[name].values}
    columns |= {end: dataset.get(f"{name}_{end}", dataset[name] * np.nan).values for end in _ENDS}
    return _named(name, columns | dict.fromkeys((*_FURTHER, "between", "within"), undefined), scaled)


def _named(name: str, columns: dict[str, np.ndarray], scaled: Scaled) -> dict[str, tuple]:
    """Return the columns of a quantity under their names, with what they come from."""
    shared = np.where(np.isinf(scaled.shared), np.nan, scaled.shared)
    return {
        **{f"{name}_{key}" if key else name: ("load", column) for key, column in columns.items()},
        f"{name}_of_maps": (("map", "load"), from_scale(name, scaled.values)),
        f"{name}_shared": (("load", "source", "component"), shared),
    }


def _ends(
    name: str,
    mean: np.ndarray,
    widths: tuple[np.ndarray, np.ndarray],
    scaled: Scaled,
    sources: Sequence[str],
) -> Ends:
    """Return both ends of an interval of half-widths, with what the maps share; NaN where not bounded."""
    components = np.moveaxis(scaled.shared, 0, 2)[[SOURCES.index(source) for source in sources]]
    ends = ends_of(name, mean, added_up([half_widths(*widths), *components]))
    value = from_scale(name, mean)
    limits = limited(name, ends, value=value, load=scaled.load, hardness=scaled.hardness or np.inf)
    return limits[0] + 0 * widths[0], limits[1] + 0 * widths[1]  # NaN without an interval


def scaled_components(name: str, dataset: xr.Dataset) -> np.ndarray:
    """Return the components (load, source, component) of a quantity of a map on its scale; 0 where unknown.

    They are half-widths, infinite where unbounded, and shifts, a known bias among them, down and up.
    """
    values = dataset[name].values.astype(float)
    if f"{name}_components" not in dataset:
        return np.zeros((values.size, len(SOURCES), 4))
    in_units = dataset[f"{name}_components"].transpose("source", "component", "load").values[: len(SOURCES)]
    # an unbounded half-width is NaN in the file
    components = [component_from_units(name, values, np.nan_to_num(side, nan=np.inf)) for side in in_units]
    return np.stack(components).transpose(2, 0, 1)


def scaled_at(name: str, dataset: xr.Dataset, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a quantity of a map and its components on its scale at some loads (Pa)."""
    of_map = to_scale(name, dataset[name].values), scaled_components(name, dataset)
    values, components = (at_loads(dataset["mean_pressure"].values, loads, numbers) for numbers in of_map)
    return values, components


def at_loads(map_loads: np.ndarray, loads: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return numbers (load, ...), known at a map's own rising loads, at others within their range.

    Else they are interpolated (monotone cubic in the logarithm); NaN or infinite, where a neighbour is.

    Examples
    --------
    >>> at_loads(np.array([1.0, 100.0]), np.array([1.0, 10.0]), np.array([2.0, 4.0]))
    array([2., 3.])
    """
    nearest = np.abs(map_loads[None, :] - loads[:, None]).argmin(axis=1)
    if np.allclose(map_loads[nearest], loads, rtol=SAME_LOAD, atol=0.0):
        return values[nearest]
    finite = np.isfinite(values)
    within = np.clip(np.log(loads), *np.log(map_loads[[0, -1]]))  # up to rounding
    curve = scipy.interpolate.PchipInterpolator(np.log(map_loads), np.where(finite, values, 0.0))
    next_index = np.clip(np.searchsorted(map_loads, loads), 1, map_loads.size - 1)
    unknown = np.where(finite, 0.0, values)  # 0, NaN or infinite
    return curve(within) + unknown[next_index] + unknown[next_index - 1]


def common_loads(label: str, names: Sequence[str], datasets: Sequence[xr.Dataset]) -> np.ndarray:
    """Return the loads (Pa, rising) at which all maps are known, some of them by interpolation."""
    map_loads = [data["mean_pressure"].values.astype(float) for data in datasets]
    low, high = max(value[0] for value in map_loads), min(value[-1] for value in map_loads)
    if low > high * (1 + SAME_LOAD):
        first, last = (
            names[[value[index] for value in map_loads].index(end)] for index, end in ((0, low), (-1, high))
        )
        raise SettingsError(
            f"{label}: no load in common, {first} begins at {quantity(low, 'Pa', digits=5)} and {last} ends "
            f"at {quantity(high, 'Pa', digits=5)}; solve them at the same mean_pressure, or at more loads"
        )
    all_loads = np.sort(np.concatenate(map_loads))
    all_loads = all_loads[(all_loads >= low * (1 - SAME_LOAD)) & (all_loads <= high * (1 + SAME_LOAD))]
    distinct = all_loads[np.r_[True, np.diff(all_loads) > SAME_LOAD * all_loads[:-1]]]
    limit = max(value.size for value in map_loads)
    if distinct.size <= limit:
        return distinct
    is_same = partial(np.isclose, rtol=SAME_LOAD, atol=0.0)
    known = np.all([np.any(is_same(distinct[:, None], value), axis=1) for value in map_loads], axis=0)
    grid = np.geomspace(low, high, limit)
    return np.sort(np.r_[distinct[known], grid[~np.any(is_same(grid[:, None], distinct[known]), axis=1)]])


def check_sizes(label: str, datasets: Sequence[xr.Dataset]) -> None:
    """Reject bodies of finite size beside periodic maps, or on maps, or groups of maps, of other size."""
    sizes = [_body_size(data) for data in datasets]
    if len({np.isfinite(size) for size in sizes}) > 1:
        raise SettingsError(
            f"{label}: a body of finite size and one without end, whose relative area and mean gap at a mean "
            "pressure are not the same numbers; give both the same contact.boundary"
        )
    if max(sizes) > min(sizes) * (1 + SAME_LOAD):
        raise SettingsError(
            f"{label}: its maps differ in size, over which the mean pressure and the relative area of a body "
            "of finite size are taken, so that equal forces are other loads; cut them to one size"
        )


def _body_size(data: xr.Dataset) -> float:
    """Return the size (m²) of the maps of a body of finite size; NaN for a periodic map."""
    if "contact_radius" not in data:
        return float(data.attrs.get("body_size", np.nan))
    size = data["force"] / data["mean_pressure"]
    return float(size.where(np.isfinite(data["contact_radius"]))[0])


def check_alike(label: str, names: Sequence[str], datasets: Sequence[xr.Dataset]) -> None:
    """Reject maps that do not answer the same question, in one sentence."""
    for key, symbol in (("contact_modulus", "E*"), ("hardness", "H")):
        values = [float(data.get(key, np.nan)) for data in datasets]
        for name, value in zip(names, values, strict=True):
            if not np.isclose(value, values[0], rtol=SAME_LOAD, equal_nan=True):
                first, second = (quantity(v, "Pa") if v > 0 else "none" for v in (values[0], value))
                raise SettingsError(
                    f"{label}: {names[0]} was solved with {symbol} = {first} and {name} with {second}; solve "
                    "them with the same bodies, or put them into two groups"
                )
    check_sizes(label, datasets)
    named = [*zip(names, datasets, strict=True)]
    for noun, limit in _SAME_BAND.items():
        key = f"band_{noun}"
        limits = {name: float(data.attrs[key]) for name, data in named if key in data.attrs}
        low, high = (choose(limits, key=limits.__getitem__, default="") for choose in (min, max))
        if limits and limits[high] > limit * limits[low]:
            band = limits[high if noun == "shortest" else low]
            raise SettingsError(
                f"{label}: its maps hold different waves, the {noun} of {low} is "
                f"{quantity(limits[low], 'm')}, that of {high} {quantity(limits[high], 'm')}; state one band "
                f"for all (window: {noun}_wavelength: {quantity(band, 'm')}), or compare them as two groups"
            )
    instruments = {data.attrs.get("measured_by", ""): name for name, data in named}
    instruments.pop("", None)
    # a band that the settings state, and not the pixels
    stated = all(data.attrs.get("band_reason", _GRID) != _GRID for data in datasets)
    if len(instruments) > 1 and not stated:
        first, second = (
            f"{name} was measured by {of_name(instrument).words}"
            for instrument, name in [*instruments.items()][:2]
        )
        raise SettingsError(
            f"{label}: {first}, {second}, which do not resolve the same waves; state a band that both "
            "resolve (window: shortest_wavelength), or compare them as two groups"
        )


def _remarks(
    datasets: Sequence[xr.Dataset],
    names: Sequence[str],
    part_names: Sequence[str],
    loads: np.ndarray,
    is_outlier: np.ndarray,
    *,
    placements: bool,
) -> list[str]:
    """Return what a reader of a group has to know, in sentences."""
    units = len(set(part_names)) if len(set(part_names)) > 1 else len(names)
    noun = "placements" if placements else "maps" if units == len(names) else "parts"
    sentences = ["A single map: its own numbers and intervals."] if len(names) == 1 else []
    if 1 < units < MIN_FOR_INTERVAL:
        source = "their intervals" if placements else "the maps, and what these share"
        sentences.append(
            f"Two {noun}: a range, from the lowest to the highest of {source}; three {noun} or more have an "
            "interval."
        )
    if len(set(part_names)) == 1 < len(names):
        sentences.append(
            f"All maps are of the part {part_names[0]}: the interval says nothing of other parts."
        )
    map_loads = [data["mean_pressure"].values for data in datasets]
    if any(value.size != loads.size or not np.allclose(value, loads, rtol=SAME_LOAD) for value in map_loads):
        sentences.append(
            f"The maps were solved at different loads: they are compared from {quantity(loads[0], 'Pa')} to "
            f"{quantity(loads[-1], 'Pa')}, which all of them reach, and interpolated there."
        )
    sentences += [
        f"{name} stands off the others (Grubbs's test, 1 %) at {int(row.sum())} of {loads.size} loads; it is "
        "included."
        for name, row in zip(names, is_outlier, strict=True)
        if row.any()
    ]
    return sentences
