"""One answer of several maps: of the maps of a part, the parts of a batch, the placements of two faces.

On the scale of a quantity U² = (t s)² + U_shared², with the standard uncertainty s of the mean of the maps
and Student's t (`random_effects`); the scatter that the bank expects of maps, each a unit of its own, from
their source `window` counts for some degrees of freedom (`moderated`); U_shared, of discretisation,
instrument, material and hidden waves, is averaged over the maps and added once (JCGM 100:2008, 5.2). Window
and solver are left out: the scatter holds them. For the next map the variance of a single one is added. The
group is what the maps are samples of, without waves longer than a map.
"""

import hashlib
from collections.abc import Iterable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ENDS, QUANTITIES
from roughcontact.arguments.kinds import KIND_FACTS
from roughcontact.arguments.measurement import json_attributes
from roughcontact.arguments.quantities import number, quantity
from roughcontact.errors import SettingsError
from roughcontact.io.instrument_kinds import of_name
from roughcontact.statistics import load_pairs
from roughcontact.statistics.kinds import check_sizes, size_of_body
from roughcontact.surface.window.band import is_limited_by_grid
from roughcontact.uncertainty import combination, random_effects
from roughcontact.uncertainty.calibration import ALONE, scatter_between_maps
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.members import MEMBERS, Members
from roughcontact.uncertainty.scales import ALL, from_scale, headline_names, to_scale

MIN_FOR_INTERVAL = 3  # parts, or maps, below which there is a range instead of an interval
_SAME = 1e-6  # relative, of moduli
# largest ratio of the limits of the bands of two maps: a tenth at the short end changes the area by 2 % (at a
# Hurst exponent of 0.8); the long end matters to the gap alone, and windows differ in size
_SAME_BAND = {"shortest": 1.1, "longest": 2.0}
# ratio of two loads between which a tenth of the areas and gaps of nine measured maps are interpolated by
# more than 6 %, of the conductances by more than 20 %; ten times apart 20 and 50 %
_FAR_APART = 3.5
_FURTHER = ("", "_next", "_next_part")  # the group, the next map, the next part
_WINDOW = SOURCES.index("window")
_OF_HARDNESS = ("hardness", "hardness_lower", "hardness_upper")


def needed_for_groups(names: Iterable[str]) -> list[str]:
    """Return those variables of a file of statistics that groups, and differences of maps, are made of.

    Examples
    --------
    >>> needed_for_groups(["mean_gap", "mean_gap_lower", "mean_gap_density", "iterations"])
    ['mean_gap', 'mean_gap_lower']
    """
    alone = (f"_{ALONE}{suffix}" for suffix in ENDS)
    suffixes = (*ENDS, "_map_lower", "_map_upper", *alone, "_components", "_parts")
    needed = {f"{name}{suffix}" for name in ALL for suffix in suffixes}
    needed |= {"mean_pressure", "contact_modulus", "rms_height", *_OF_HARDNESS, *load_pairs.OF_SLOPE}
    needed |= {name for facts in KIND_FACTS for name in facts.own_numbers}
    return [name for name in names if name in needed]


def group_statistics(
    datasets: Sequence[xr.Dataset],
    *,
    names: Sequence[str] | None = None,
    parts: Sequence[str] | None = None,
    group: str = "",
    placements: bool = False,
) -> xr.Dataset:
    """Return one answer of several maps of a finish, with its interval.

    Maps with a ± of their own, each of its own part or all of one, have intervals; else three parts (maps,
    where each is of its own part) or more have them, two the range of their maps. A single map keeps its own
    numbers. Loads are those that all maps have; where these differ, also
    others within their common range, those of single maps, to which the other ones are interpolated
    (monotone cubic in the logarithm of the load, on the scale of the quantity, of the gap with the slope that
    its stiffness is), never beyond.

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
        one; `{quantity}_shared` (source, component, load): half-widths and shifts, mean of the maps;
        `stands_off` (map, load): 1 for a map that stands off the others in any quantity. Coordinates `map`,
        `part` (map), `content` (map; equal for copies), `mean_pressure` (load; Pa). Attributes: `group`,
        `members` ("maps", "bodies" or "placements"), `remarks` (JSON: list of sentences).

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
    >>> [f"{found[f'mean_gap{suffix}'].item():.2e}" for suffix in ("_lower", "", "_upper")]
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
    datasets = [_drop_padding(data) for data in datasets]
    size = size_of_body(datasets[0])
    kind = "placements" if placements else "maps" if np.isnan(size) else "bodies"
    contents = [_content(data) for data in datasets]
    for name, content in zip(names, contents, strict=True):
        twin = names[contents.index(content)]
        if content and twin != name and not MEMBERS[kind].may_be_equal:
            raise SettingsError(
                f"{label}: {twin} and {name} have the same results, as copies of one map have, which says "
                "nothing new; leave one out"
            )
    check_alike(label, names, datasets)
    loads = load_pairs.common_loads(label, names, datasets)
    quantities = [name for name in headline_names(datasets[0]) if all(name in data for data in datasets)]
    hardness = {key: float(datasets[0][key]) for key in _OF_HARDNESS if key in datasets[0]}
    hardest = hardness.get("hardness_upper", hardness.get("hardness", np.inf))
    maps = _Maps(datasets, parts, loads, MEMBERS[kind], hardest)
    columns: dict[str, tuple] = {}
    is_outlier = np.zeros((len(datasets), loads.size), bool)
    for name in quantities:
        values, components, *alone_components = maps.on_scale(name)
        shared = components.mean(axis=0)
        if len(datasets) == 1:
            numbers = maps.own_numbers(name)
        else:
            numbers = maps.numbers(name, values, shared, alone_components)
        in_units = combination.component_in_units(name, numbers[""], np.moveaxis(shared, 0, -1))
        is_unknown = np.isnan(values)
        of_maps = np.where(is_unknown, maps.at_loads(name), from_scale(name, values))
        # a closed gap and the conductance of full contact have no finite logarithm
        is_limit = is_unknown.any(axis=0) & ~np.isnan(of_maps).any(axis=0)
        if is_limit.any() and len(datasets) > 1:
            for ending, column in maps.range_of(name, of_maps).items():
                numbers[ending] = np.where(is_limit, column, numbers[ending])
        columns |= {f"{name}{ending}": ("load", column) for ending, column in numbers.items()}
        columns[f"{name}_of_maps"] = (("map", "load"), of_maps)
        shared_columns = np.where(np.isinf(in_units), np.nan, in_units)
        columns[f"{name}_shared"] = (("source", "component", "load"), shared_columns)
        is_outlier |= random_effects.grubbs_outliers(values)
    columns["stands_off"] = (("map", "load"), is_outlier.astype(np.int8))
    single_numbers = {"contact_modulus": float(datasets[0].get("contact_modulus", np.nan)), **hardness}
    if all("rms_height" in data for data in datasets):
        single_numbers["rms_height"] = float(np.median([float(data["rms_height"]) for data in datasets]))
    columns |= {key: ((), number) for key, number in single_numbers.items()}
    coordinates = {
        "source": [*SOURCES],
        "component": [*combination.SIDES],
        "mean_pressure": ("load", loads),
        "map": np.array(names, object),
        "part": ("map", np.array(parts, object)),
        "content": ("map", np.array(contents, object)),
    }
    answer = xr.Dataset(columns, coordinates, {"group": group, "body_size": size, "members": kind})
    remarks = _remarks(answer, datasets, MEMBERS[kind])
    return answer.assign_attrs(json_attributes({"remarks": remarks}))


def is_range(answer: xr.Dataset) -> bool:
    """Return whether a group has a range instead of intervals, by `group_statistics`.

    Examples
    --------
    >>> is_range(xr.Dataset(coords={"map": ["a", "b", "c"], "part": ("map", ["p", "q", "q"])}))
    True
    """
    if any(answer[name].notnull().any() for name in answer if str(name).endswith("_next_lower")):
        return False
    parts = len(set(answer["part"].values))
    return 1 < (answer.sizes["map"] if parts == 1 else parts) < MIN_FOR_INTERVAL


def _drop_padding(data: xr.Dataset) -> xr.Dataset:
    """Return a map, loads rising, without what only others of its run have: loads, and a budget of NaN."""
    data = data.isel(load=np.isfinite(data["mean_pressure"].values)).sortby("mean_pressure")
    no_budget = [name for name in headline_names(data) if np.isnan(data.get(f"{name}_lower", 0.0)).all()]
    padding = [f"{name}{key}" for name in no_budget for key in (*ENDS[1:], "_components")]
    return data.drop_vars(padding, errors="ignore")


def _content(dataset: xr.Dataset) -> str:
    """Return a digest of the numbers of a map, to nine digits; empty where its rms height is not known."""
    if "rms_height" not in dataset:
        return ""
    names = ["rms_height", "mean_pressure", *headline_names(dataset)]
    digits = " ".join(f"{value:.8e}" for name in names for value in dataset[name].values.flat)
    return hashlib.sha256(digits.encode()).hexdigest()[:16]


class _Maps(NamedTuple):
    """The maps of a group, at the loads that all of them have."""

    datasets: Sequence[xr.Dataset]
    parts: Sequence[str]  # that each map is of
    loads: np.ndarray  # Pa
    members: Members
    hardest: float  # upper end of the hardness (Pa)

    def at_loads(self, name: str) -> np.ndarray:
        """Return a number (map, load) of all maps."""
        series = [(data["mean_pressure"].values, self.loads, data[name].values) for data in self.datasets]
        return np.stack([load_pairs.interpolated(*of_map) for of_map in series])

    def on_scale(self, name: str) -> list[np.ndarray]:
        """Return values (map, load) and components (map, load, source, component) of a quantity on its scale.

        Then come values and half-widths (map, load) by the window of the maps without what overviews show.
        """
        results = []
        for data in self.datasets:
            value, suffixes = to_scale(name, data[name].values), ENDS if f"{name}_{ALONE}" in data else ()
            columns = [scaled_components(name, data)]
            columns += [to_scale(name, data[f"{name}_{ALONE}{suffix}"].values) for suffix in suffixes]
            at_loads = partial(load_pairs.interpolated, data["mean_pressure"].values, self.loads)
            value = at_loads(np.where(np.isinf(value), np.nan, value), load_pairs.slopes_of(name, data))
            components, *alone = map(at_loads, columns)
            components[:, _WINDOW, :2] = self.possible(name, value, components[:, _WINDOW, :2])
            of_map = value, components[:, _WINDOW, :2].mean(axis=1)
            if alone:
                without_overview = alone[0], (alone[2] - alone[1]) / 2
                pairs = zip(without_overview, of_map, strict=True)
                # NaN of a map beside others with an overview
                of_map = tuple(np.where(np.isfinite(alone[0]), *pair) for pair in pairs)
            results.append((value, components, *of_map))
        return [np.stack(column) for column in zip(*results, strict=True)]

    def possible(self, name: str, value: np.ndarray, widths: np.ndarray) -> np.ndarray:
        """Return half-widths (load, side) of a value on its scale, cut where the hardness bounds both ends.

        Maps scatter no further: the peaks of all that flow are alike.
        """
        if (limits := QUANTITIES[name].limits) is None or np.isinf(self.hardest):
            return widths
        lowest, highest = (to_scale(name, 0 * self.loads + cut) for cut in limits(self.loads, self.hardest))
        return np.fmin(widths, np.maximum(np.stack([value - lowest, highest - value], axis=1), 0.0))

    def own_numbers(self, name: str) -> dict[str, np.ndarray]:
        """Return the numbers (load) of a quantity of a single map, by their endings: what it was."""
        (data,) = self.datasets
        endings = (*(f"{key}{suffix}" for key in _FURTHER for suffix in ENDS[1:]), "_between", "_within")
        own = {suffix: data[f"{name}{suffix}"].values for suffix in ENDS if f"{name}{suffix}" in data}
        return dict.fromkeys(endings, np.full(self.loads.shape, np.nan)) | own

    def numbers(
        self, name: str, values: np.ndarray, shared: np.ndarray, alone_components: Sequence[np.ndarray]
    ) -> dict[str, np.ndarray]:
        """Return the numbers (load) of a quantity of several maps, by their endings.

        `values` and `alone` are of `on_scale`, `shared` (load, source, component) is the mean of its
        components.
        """
        effects, is_expected = self.effects(name, values, shared[:, _WINDOW, :2].mean(axis=1))
        # of an overview the value is a mean over its places, which scatters less than the next map
        of_single, _ = self.effects(name, alone_components[0], alone_components[1].mean(axis=0))
        next_map = random_effects.student(of_single.next_map_freedom) * of_single.next_map
        factor = random_effects.student(effects.freedom)
        own_width = {"mean": factor * effects.error, "next_map": next_map}[self.members.interval]
        widths = own_width, next_map, factor * effects.next_part
        of_scatter = [combination.symmetric(width) for width in widths]
        if effects.units < MIN_FOR_INTERVAL and not is_expected.all():
            # a range, from map to map, beyond which what they share reaches
            extremes = values.min(axis=0), values.max(axis=0)
            range_ = combination.added_up(combination.one_sided(end - effects.mean) for end in extremes)
            of_scatter = [range_, *np.full((2, *range_.shape), np.nan)]
        shared_components = np.moveaxis(shared, 0, 2)[[SOURCES.index(key) for key in self.members.shared]]
        value = from_scale(name, effects.mean)
        columns = {"": value, "_between": effects.between, "_within": effects.within}
        for key, component in zip(_FURTHER, of_scatter, strict=True):
            total = combination.added_up([component, *shared_components])
            bounds = combination.interval_bounds(name, effects.mean, total)
            limits = combination.limited(name, bounds, value, self.loads, self.hardest)
            for suffix, limit in zip(ENDS[1:], limits, strict=True):
                columns[f"{key}{suffix}"] = np.where(np.isnan(component[0]), np.nan, limit)  # no interval
        return columns

    def range_of(self, name: str, of_maps: np.ndarray) -> dict[str, np.ndarray]:
        """Return the median (load) of a number of maps, and the range of their intervals, by endings."""
        has_ends = all(f"{name}{suffix}" in data for data in self.datasets for suffix in ENDS[1:])
        lower, upper = (self.at_loads(f"{name}{suffix}") if has_ends else of_maps for suffix in ENDS[1:])
        middle = np.median(of_maps, axis=0)
        return dict(zip(ENDS, (middle, lower.min(axis=0), upper.max(axis=0)), strict=True))

    def effects(
        self, name: str, values: np.ndarray, half_width: np.ndarray
    ) -> tuple[random_effects.Effects, np.ndarray]:
        """Return mean and scatter of the maps (map, load) on the scale, and whether the bank expects this.

        `half_width` (load) is that of the source `window` of a map, which tells how maps of the bank scatter.
        """
        effects = random_effects.random_effects(values, self.parts)
        is_expected = np.isfinite(half_width) & (half_width > 0)
        is_expected &= self.members.has_calibrated_scatter and effects.units == len(values)
        if is_expected.any():
            scatter, freedom = scatter_between_maps(name, np.where(is_expected, half_width, 0.0))
            effects = random_effects.moderated(effects, scatter, np.where(is_expected, freedom, 0.0))
        return effects, is_expected


def scaled_components(name: str, data: xr.Dataset, ending: str = "components", scale: str = "") -> np.ndarray:
    """Return the components (load, source, component) of a quantity on its scale; 0 where unknown.

    They are half-widths, infinite where unbounded, and shifts, a known bias among them, down and up. The
    scale may be that of another quantity, `ending` "shared" is of what the maps of a group share.
    """
    values = data[name].values.astype(float)
    if f"{name}_{ending}" not in data:
        return np.zeros((values.size, len(SOURCES), 4))
    columns = data[f"{name}_{ending}"].transpose("source", "component", "load")
    in_units = columns.values[: len(SOURCES)]  # not of what they make together
    # an unbounded half-width is NaN in the file
    sides = [np.nan_to_num(side, nan=np.inf) for side in in_units]
    scaled = [combination.component_from_units(scale or name, values, side) for side in sides]
    return np.stack(scaled).transpose(2, 0, 1)


def check_alike(label: str, names: Sequence[str], datasets: Sequence[xr.Dataset]) -> None:
    """Reject maps that do not answer the same question, in one sentence."""
    for key, symbol in (("contact_modulus", "E*"), ("hardness", "H")):
        values = [float(data.get(key, np.nan)) for data in datasets]
        for name, value in zip(names, values, strict=True):
            if not np.isclose(value, values[0], rtol=_SAME, equal_nan=True):
                lhs, rhs = (quantity(v, "Pa") if v > 0 else "none" for v in (values[0], value))
                raise SettingsError(
                    f"{label}: {names[0]} was solved with {symbol} = {lhs} and {name} with {rhs}; solve "
                    "them with the same bodies, or put them into two groups"
                )
    check_sizes(label, datasets)
    pairs = [*zip(names, datasets, strict=True)]
    for noun, limit in _SAME_BAND.items():
        key = f"band_{noun}"
        limits = {name: float(data.attrs[key]) for name, data in pairs if key in data.attrs}
        low, high = (choose(limits, key=limits.__getitem__, default="") for choose in (min, max))
        if limits and limits[high] > limit * limits[low]:
            band = limits[high if noun == "shortest" else low]
            raise SettingsError(
                f"{label}: its maps hold different waves, the {noun} of {low} is "
                f"{quantity(limits[low], 'm')}, that of {high} {quantity(limits[high], 'm')}; state one band "
                f"for all (window: {noun}_wavelength: {quantity(band, 'm')}), or compare them as two groups"
            )
    instruments = {data.attrs.get("measured_by", ""): name for name, data in pairs}
    instruments.pop("", None)
    # a band that the settings state, and not the pixels
    has_band = not any(is_limited_by_grid(data.attrs) for data in datasets)
    if len(instruments) > 1 and not has_band:
        lhs, rhs = (
            f"{name} was measured by {of_name(instrument).words}"
            for instrument, name in [*instruments.items()][:2]
        )
        raise SettingsError(
            f"{label}: {lhs}, {rhs}, which do not resolve the same waves; state a band that both "
            "resolve (window: shortest_wavelength), or compare them as two groups"
        )


def _remarks(answer: xr.Dataset, datasets: Sequence[xr.Dataset], members: Members) -> list[str]:
    """Return what a reader of a group has to know, in sentences."""
    names, part_names = answer["map"].values, answer["part"].values
    loads, is_outlier = answer["mean_pressure"].values, answer["stands_off"].values > 0
    units = len(set(part_names)) if len(set(part_names)) > 1 else len(names)
    noun = f"{members.noun}s" if units == len(names) else "parts"
    sentences = ["A single map: its own numbers and intervals."] if len(names) == 1 else []
    if is_range(answer):
        sentences.append(
            f"Two {noun}: a range, from the lowest to the highest of the {members.noun}s, and what these "
            f"share; three {noun} or more have an interval."
        )
    elif units == MIN_FOR_INTERVAL - 1:
        sentences.append(
            "Two maps: their interval rests on how maps of other surfaces scatter; three or more show it."
        )
    if len(set(part_names)) == 1 < len(names):
        sentences.append(
            f"All maps are of the part {part_names[0]}: the interval says nothing of other parts."
        )
    map_loads = [data["mean_pressure"].values for data in datasets]
    if any(value.size != loads.size or not load_pairs.same_load(value, loads).all() for value in map_loads):
        sentences.append(
            f"The maps were solved at different loads: they are compared from {quantity(loads[0], 'Pa')} to "
            f"{quantity(loads[-1], 'Pa')}, which all of them reach, and interpolated there."
        )
    if (step := max(load_pairs.widest_step(value, loads) for value in map_loads)) > _FAR_APART:
        sentences.append(
            f"Some of these lie between loads of a map that are {number(step, digits=2)} times apart, where "
            "area and gap may be off by a fifth, a conductance by half: solve the maps at the same "
            "mean_pressure."
        )
    sentences += [
        f"{name} stands off the others (Grubbs's test, 1 %) at {int(row.sum())} of {loads.size} loads; it is "
        "included."
        for name, row in zip(names, is_outlier, strict=True)
        if row.any()
    ]
    return sentences
