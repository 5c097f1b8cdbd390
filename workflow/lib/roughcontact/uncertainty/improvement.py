"""What would halve the interval of what a surface is asked for: one line, from the components of it."""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import scipy
import xarray as xr

from roughcontact.arguments.answers import ALLOWED_VALUES, ANSWERS, ENDS
from roughcontact.arguments.measurement import Instrument, json_attribute
from roughcontact.arguments.quantities import counted_noun, percent, quantity
from roughcontact.arguments.variables import names_asked
from roughcontact.statistics.kinds import load_in_words, reason_without_flow
from roughcontact.statistics.precision import precision_in_words, relative_half_width
from roughcontact.uncertainty.calibration import ALONE, scatter_between_maps, table
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.random_effects import student
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, from_scale, to_scale

_TYPICAL_AREA = 0.1  # the load with the contact area nearest to it is improved
_MAX_MAPS = 100
_NARROW = 0.01  # relative half-width that nobody need halve, as that of full contact
_PLANNED = 0.1  # relative half-width that the number of places is told for
ADVICE = {
    "solver": "set the tolerance of the solver to a tenth",
    "discretisation": "measure with pixels half as large",
    "instrument": "repeat the measurement and average, or calibrate the instrument",
    "material": "state contact modulus and load twice as narrowly",
    "hardness": "measure the hardness, and state it with its uncertainty",
    "unresolved": "measure with pixels half as large, this map then being its overview",
}
_WORTHWHILE = 0.9  # of the half-width, above which nothing is promised
_OVERVIEW = "measure an overview, a field three times as long at a quarter of the magnification"
_LONGER_FIELD = "measure a field 3 times as long"


def half_width_of_mean(windows: Sequence[float], maps: int, shared_error: float, name: str = AREA) -> float:
    """Return the median relative half-width of the mean of so many maps, as a group of them will have.

    `windows` are the relative half-widths of the source `window` of one map, and of one elsewhere;
    `shared_error` is that of what all maps share.
    """
    of_map, elsewhere = windows
    scatter, expected = scatter_between_maps(name, (of_map + (maps - 1) * elsewhere) / maps)
    measured = maps - 1.0
    square = 2 * scipy.special.gammaincinv(measured / 2, 0.5)  # median of chi-square
    variance = scatter**2 * (expected + square) / (expected + measured)
    return math.hypot(float(student(np.array(expected + measured)) * np.sqrt(variance / maps)), shared_error)


def maps_for(target: float, windows: Sequence[float], shared_error: float, name: str = AREA) -> int | None:
    """Return how many maps in all have a mean of this relative half-width; None for more than a hundred."""
    widths = ((n, half_width_of_mean(windows, n, shared_error, name)) for n in range(2, _MAX_MAPS + 1))
    return next((n for n, width in widths if width <= target), None)


def planning_line(statistics: xr.Dataset) -> str:
    """Return how many places of this size make what is asked for known to ± 10 %; empty if it is already."""
    subject = _subject(statistics)
    shared_error, size = subject.shared_error, subject.size
    # of a number known worse than to itself nobody plans a tenth
    beyond_plans = subject.name in CONSTRICTIONS and not subject.half_width < 1
    if subject.half_width <= _PLANNED or beyond_plans or not math.isfinite(subject.of_places[0]):
        return ""
    if places := maps_for(_PLANNED, subject.of_places, shared_error, subject.name):
        return f"{counted_noun(places, subject.noun)} {size} in all"
    if shared_error < _PLANNED:
        return f"more than {_MAX_MAPS} {subject.noun}s {size}"
    largest = max(subject.widths.keys() - {"window"}, key=subject.widths.__getitem__)
    width = f"is ± {percent(shared_error, digits=2)}" if math.isfinite(shared_error) else "has no bound"
    return f"no number of {subject.noun}s, the {largest} alone {width}"


def add_halving(statistics: xr.Dataset, *, overview: bool = False) -> xr.Dataset:
    """Return the statistics with the attributes `halve` and `places`, by the arguments of `halving_line`.

    `halved` says whose interval that is, of several loads with the one that these are of.
    """
    lines = {"halve": halving_line(statistics, overview=overview), "places": planning_line(statistics)}
    if any(lines.values()):
        lines["halved"] = _asked_number(statistics)[1]
        if statistics.sizes.get("load", 1) > 1:
            load = float(statistics["mean_pressure"][_typical_load(statistics)])
            lines["halved"] += f" at {load_in_words(load, statistics)[1]}"
    return statistics.assign_attrs({name: line for name, line in lines.items() if line})


def add_overview_line(statistics: xr.Dataset) -> xr.Dataset:
    """Return the statistics with the attribute `overview`: how well they are known with and without it.

    It is of gap and area at the load whose contact area is nearest to 10 %.
    """
    if f"{AREA}_alone_lower" not in statistics:
        return statistics
    load, phrases = _typical_load(statistics), []
    for name, word in ((GAP, "gap"), (AREA, "contact area")):
        columns = (statistics[f"{name}{ending}"] for ending in (*ENDS, "_alone_lower", "_alone_upper"))
        value, *bounds = (float(column.values[load]) for column in columns)
        now, by_map = (precision_in_words(value, low, high) for low, high in (bounds[:2], bounds[2:]))
        if now != by_map:
            phrases.append(f"{word} known {now} ({by_map} without the overview)")
    return statistics.assign_attrs(overview="; ".join(phrases)) if phrases else statistics


def _typical_load(statistics: xr.Dataset) -> int:
    """Return the index of the load whose contact area is nearest to the typical one."""
    areas = np.maximum(statistics[AREA].values, 1e-300)
    return int(np.abs(np.log(areas / _TYPICAL_AREA)).argmin())


def halving_line(statistics: xr.Dataset, *, overview: bool = False) -> str:
    """Return what would halve the interval of what is asked for; empty without one, or if it is narrow.

    That is a leak, a conductance, a number that something is allowed of, else the contact area, at the load
    whose contact area is nearest to 10 %. `overview` says whether a coarser map around this one can be
    measured, where there is none.
    """
    subject = _subject(statistics)
    half_width, widths = subject.half_width, subject.widths
    if math.isnan(subject.value) or half_width <= _NARROW:
        return ""
    actions, advice = _advice(statistics)
    if not math.isfinite(half_width) or math.isinf(subject.of_places[0]):
        return "; ".join([*actions, _LONGER_FIELD])
    if "window" in widths:
        advice["window"] = _more_places(subject)
        if overview and subject.name == AREA and f"{AREA}_alone_lower" not in statistics:
            by_overview = _by_the_bank(table()["overview_promise"], widths["window"], subject.value)
            promised = math.hypot(subject.shared_error, by_overview)
            if promised < _WORTHWHILE * half_width:
                text = f"{_OVERVIEW} (to about ± {percent(promised, digits=2)})"
                advice["window"] = f"{text}, or {advice['window'].removeprefix('measure ')}"
    by_size = sorted(widths, key=widths.__getitem__, reverse=True)
    for rank, source in enumerate(by_size, start=1):
        actions.append(advice[source])
        if math.hypot(*(widths[name] for name in by_size[rank:])) <= half_width / 2:
            break
    return "; ".join(dict.fromkeys(actions))


def _advice(statistics: xr.Dataset) -> tuple[list[str], dict[str, str]]:
    """Return what comes first, if anything, and source -> what halves its part, by checks and settings."""
    attrs, advice = statistics.attrs, {**ADVICE}
    doubtful_checks = {entry["check"] for entry in json_attribute(attrs, "reasons")}
    if not Instrument.read(attrs).properties():
        advice["instrument"] = (  # of rounded heights, or a suspected noise
            "export the heights in finer steps, or measure the same place twice, which tells the noise"
        )
    if "Smoothed" in doubtful_checks:
        advice = dict.fromkeys(advice, "state the numerical aperture of the lens")
    if "Isolated peak" not in doubtful_checks or "summit_x" not in attrs:
        return [], advice
    x, y = (quantity(float(attrs[f"summit_{axis}"]), "m") for axis in "xy")
    return [f"clean the summit at ({x}, {y})"], advice


def _half_width_elsewhere(of_window: float, name: str, value: float) -> float:
    """Return the relative half-width by the window of another place, from that of the window of a map."""
    # of no other number the bank tells how those of other places differ
    return _by_the_bank(table()["groups"]["other_places"], of_window, value) if name == AREA else of_window


def _by_the_bank(line: Sequence[float], of_window: float, area: float) -> float:
    """Return the relative half-width that follows from that of the window, by a line of their logarithms."""
    constant, power = line
    step = np.array([-1e-3, 1e-3])  # on the scale, over which d ln A is taken
    slope = float(np.diff(np.log(from_scale(AREA, to_scale(AREA, np.array(area)) + step)))[0] / np.ptp(step))
    return slope * math.exp(constant) * (of_window / slope) ** power


class _Subject(NamedTuple):
    """A number whose interval is to be halved, with relative half-widths; infinite where nothing bounds it.

    Those of a leak are three times those of its narrowest place, whose cube it is.
    """

    name: str
    value: float = math.nan
    half_width: float = math.nan
    widths: Mapping[str, float] = MappingProxyType({})  # by source
    of_places: tuple[float, float] = (math.nan, math.nan)  # by the window, of this map and of another place
    shared_error: float = 0.0  # by all other sources
    size: str = "of this size"  # what further places have to be
    noun: str = "place"


def _asked_number(statistics: xr.Dataset) -> tuple[list[str], str]:
    """Return the names of the numbers of which one is asked for, and what they are in words."""
    answers = [*names_asked(statistics)]
    answers += [limit.answer for name, limit in ALLOWED_VALUES.items() if f"{name}_holds" in statistics]
    candidates = {"sealing": ([*CONSTRICTIONS], "leak")}
    candidates |= {key: ([row.quantity], row.words) for key, row in ANSWERS.items() if row.quantity}
    for name, (numbers, words) in candidates.items():
        is_judged = name != "sealing" or not reason_without_flow(statistics)
        if name in answers and is_judged and f"{numbers[0]}_components" in statistics:
            return numbers, words
    return [AREA], ANSWERS[AREA].words


def _subject(statistics: xr.Dataset) -> _Subject:
    """Return the number that is asked for, at the typical load; of both ways of a leak the less known one."""
    names, _ = _asked_number(statistics)
    if f"{names[0]}_components" not in statistics:
        return _Subject(names[0])
    at_load = statistics.isel(load=_typical_load(statistics))
    ways = [_subject_at_load(at_load, name) for name in names]
    return max(ways, key=lambda subject: np.nan_to_num(subject.half_width, nan=-1.0))


def _subject_at_load(at_load: xr.Dataset, name: str) -> _Subject:
    """Return a number at a load, not known where it has no value, as a leak through a closed gap."""
    value, lower, upper = (float(at_load[f"{name}{suffix}"]) for suffix in ENDS)
    if not value > 0:
        return _Subject(name)
    power = 3.0 if name in CONSTRICTIONS else 1.0
    is_unbounded = at_load[f"{name}_components"].isnull().any("component").values
    widths = np.where(is_unbounded, np.inf, at_load[f"{name}_uncertainty"].values / value * power)
    by_source = dict(zip(at_load["source"].values, widths.tolist(), strict=True))
    by_source = {source: by_source[source] for source in SOURCES if not math.isnan(by_source[source])}
    of_window = by_source.get("window", math.nan)
    is_profile = "profiles" in at_load.attrs or not math.isfinite(at_load.get("window_length_y", 1.0))
    noun, size = ("profile", "of this length") if is_profile else ("place", "of this size")
    size += ", each with its overview" * (f"{name}_{ALONE}" in at_load)
    return _Subject(
        name,
        value,
        half_width=power * float(relative_half_width(value, lower, upper)),
        widths=by_source,
        of_places=(of_window, _half_width_elsewhere(of_window, name, value)),
        shared_error=math.hypot(*(width for source, width in by_source.items() if source != "window")),
        size=size,
        noun=noun,
    )


def _more_places(subject: _Subject) -> str:
    """Return how many more maps halve the interval."""
    target = subject.half_width / 2
    if subject.shared_error >= target:
        target = math.hypot(subject.shared_error, subject.of_places[0] / 2)
    maps = maps_for(target, subject.of_places, subject.shared_error, subject.name)
    if maps is None:
        return f"measure more {subject.noun}s"
    half_width = half_width_of_mean(subject.of_places, maps, subject.shared_error, subject.name)
    text = f" (their mean: to about ± {percent(half_width, digits=2)})" if half_width < 1 else ""
    return f"measure {counted_noun(maps - 1, f'more {subject.noun}')} {subject.size}{text}"
