"""The groups of maps on the page: their answers at two or three loads and pictures, and those of several."""

from collections.abc import Collection, Mapping, Sequence
from operator import itemgetter

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ALLOWED_VALUES, ANSWERS, AREA, ENDS, PEAK, TITLES, USUAL
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import Unit, percent
from roughcontact.arguments.variables import has_number
from roughcontact.report import allowed, glance
from roughcontact.report.charts import series_style
from roughcontact.report.differences import IN_LINE, Load, Row, differences_in_words, nearest_load
from roughcontact.report.glance import Cell
from roughcontact.report.load_plots import compare_areas
from roughcontact.report.template import sentence
from roughcontact.report.units import common_pressure, hardness_reached, stated_loads
from roughcontact.statistics.outcome import VERDICTS
from roughcontact.uncertainty.group_tables import NamedGroup
from roughcontact.uncertainty.groups import is_range
from roughcontact.uncertainty.scales import from_scale, to_scale

_HEADINGS = {name: TITLES[name] for name in (glance.LOAD, AREA)}
_HEADINGS |= {"next": "area of the next map", "scatter": "scatter s"}

Key = tuple[str, str | None]  # surface and case


def name_under(surface: str, *cases: str | None) -> str:
    """Return the name of a surface, under a case or several, on the page."""
    return " · ".join(filter(None, [str(surface), ", ".join(filter(None, cases))]))


def group_headings(columns: Collection[str] = ()) -> dict[str, str]:
    """Return the headings of the columns of groups: of the area, the usual numbers, and `columns`.

    Examples
    --------
    >>> [*group_headings(["conductance", "sealing"]).values()][4:]
    ['pressure in contact', 'mean gap', 'conductance']
    """
    names = {*USUAL, *columns} - {AREA}
    rows = [row for name, row in ANSWERS.items() if name in names]
    return _HEADINGS | {row.quantity: row.heading for row in rows if row.quantity}


def answer_of_several(
    groups: Sequence[NamedGroup],
    differences: Sequence[Row],
    series: Mapping[Key, xr.Dataset],
    last: Mapping[Key, int],
) -> str:
    """Return what several surfaces, or groups of maps, are asked for, in one line.

    `differences` are rows of `comparison_rows`, `series` has the statistics of each surface, loads rising,
    and `last` the load at which it is asked.
    """
    # members of a group that is compared with no other: nobody asked for that
    alone = [group for group in groups if not group.members.is_compared]
    uncompared = {name_under(name, group.case) for group in alone for name in group.answer["map"].values}
    compared = [row for row in differences if not uncompared & {row["first"], row["second"]}]
    line = differences_in_words(compared)
    if line or groups or not series:
        return line or groups_in_words(groups, series)
    return surfaces_in_words({name_under(*key): (data, last[key]) for key, data in series.items()})


def group_rows(
    groups: Sequence[NamedGroup],
    verdicts: Mapping[Key, str] | None = None,
    columns: Collection[str] = (),
) -> list[Row]:
    """Return for each group its `name`, what it is `of`, its `remarks`, and `rows` of `group_cells`.

    `verdicts` are those of the maps, by name and case, in words; `columns` are what these are asked for.
    """
    if not groups:
        return []
    units = glance.glance_units([group.answer for group in groups])
    return [
        {
            "name": group.label,
            "of": group.members.in_words(group.answer.sizes["map"], len({*group.answer["part"].values}))
            + _verdicts(group, verdicts or {}),
            "remarks": json_attribute(group.answer.attrs, "remarks"),
            "rows": [group_cells(group.answer, of_group, index, columns) for index in loads],
        }
        for group, of_group, loads in zip(groups, units, _shown(groups), strict=True)
    ]


def _shown(groups: Sequence[NamedGroup]) -> list[list[int]]:
    """Return for each group the loads that are shown."""
    answers = [group.answer for group in groups]
    return glance.shared_loads(answers) or [glance.shown_loads(answer[AREA].values) for answer in answers]


def group_picture(groups: Sequence[NamedGroup]) -> str:
    """Return the image of the groups and each of their maps at two or three loads."""
    loads = zip(groups, _shown(groups), strict=True)
    displayed = {group.label: group.answer.isel(load=shown) for group, shown in loads}
    styles = {label: series_style(index) for index, label in enumerate(displayed)}
    return compare_areas(displayed, styles)


def _verdicts(group: NamedGroup, verdicts: Mapping[Key, str]) -> str:
    """Return how many maps of a group have each verdict."""
    of_maps = [verdicts.get((str(name), group.case)) for name in group.answer["map"].values]
    counts = {label: of_maps.count(label) for label in VERDICTS.values()}
    text = ", ".join(f"{label} {count}" for label, count in counts.items() if count)
    return f" ({text})" if text else ""


def group_cells(
    answer: xr.Dataset, units: Mapping[str, Unit], index: int, columns: Collection[str] = ()
) -> list[Cell]:
    """Return the cells of a group at a load, by `group_headings`."""
    cells = {
        "mean_pressure": Cell(units["mean_pressure"].text(float(answer["mean_pressure"][index]))),
        "next": Cell(_range(answer, AREA, "_next", units, index)),
        "scatter": _scatter(answer.isel(load=index)),
    }
    return [cells.get(name) or _mean(answer, name, units, index) for name in group_headings(columns)]


def _mean(answer: xr.Dataset, name: str, units: Mapping[str, Unit], index: int) -> Cell:
    """Return the mean of a group with its ±; with the range of its maps where these are two."""
    if name not in answer or not np.isfinite(float(answer[name][index])):
        return Cell("–")
    if is_range(answer) and not (name == PEAK and hardness_reached(answer)[index]):
        text = units[name].text(float(answer[name][index]))
        return Cell(text, f"range {_range(answer, name, '', units, index)}")
    return glance.interval_cell(answer, name, units, index)


def _range(answer: xr.Dataset, name: str, prefix: str, units: Mapping[str, Unit], index: int) -> str:
    """Return an interval by its ends."""
    return units[name].ends(*(float(answer[f"{name}{prefix}{end}"][index]) for end in ENDS[1:]))


def _scatter(load: xr.Dataset) -> Cell:
    """Return the standard deviations of the area between parts and between maps, over their mean."""
    deviations = {"parts": float(load[f"{AREA}_between"]), "maps": float(load[f"{AREA}_within"])}
    mean = float(load[AREA])
    texts = {}
    for name, value in deviations.items():
        if np.isfinite(value):  # on the scale of the area
            lower, upper = from_scale(AREA, to_scale(AREA, np.array(mean)) + np.array([-value, value]))
            texts[name] = percent(round(float(upper - lower) / 2 / mean, 12))  # equal ones differ by rounding
    texts_by_name = [f"{name} {text}" for name, text in texts.items()]
    return Cell(", ".join(texts.values() if len(texts) == 1 else texts_by_name) or "–")


def groups_in_words(groups: Sequence[NamedGroup], maps: Mapping[Key, xr.Dataset]) -> str:
    """Return the contact area of up to three groups at the last load shown, and for how many maps what holds.

    `maps` has the statistics of each map by its name and case, loads rising.
    """
    sentences = []
    for group, loads_shown in zip(groups, _shown(groups), strict=True) if len(groups) <= IN_LINE else ():
        answer, index = group.answer, loads_shown[-1]
        (load, area, *_) = group_cells(answer, glance.glance_units([answer])[0], index)
        known = ", ".join(filter(None, (area.details, area.known)))
        of_maps = {str(name): maps[str(name), group.case] for name in answer["map"].values}
        pressure = float(answer["mean_pressure"][index])
        loads = {name: (data, nearest_load(data, pressure)) for name, data in of_maps.items()}
        words = [*holding_in_words(loads), f"contact area {area.text}{f' ({known})' if known else ''}"]
        sentences.append(f"{group.label} at {load.text}: {', '.join(words)}")
    return f"{'; '.join(sentences)}." if sentences else ""


def holding_in_words(results: Mapping[str, Load]) -> list[str]:
    """Return for which surfaces, by name, what all of them are allowed holds at a load of each.

    Examples
    --------
    >>> seal = xr.Dataset({"allowed_leak": 1e-9, "leak_holds": ("load", [np.nan, 1.0])})
    >>> leaky = seal.assign(leak_holds=("load", [0.0, 0.0]))
    >>> holding_in_words({"ground": (seal, 1), "turned": (leaky, 1)})
    ['leak of at most 3.60 ml/h: holds for ground, does not hold for turned']
    >>> holding_in_words({"ground": (seal, 0), "turned": (seal, 0)})
    ['leak of at most 3.60 ml/h: not decided for all 2']
    """
    all_data = [data for data, _ in results.values()]
    sentences = []
    for name in allowed.stated_allowed(all_data[0]):
        limits = {float(data[f"allowed_{name}"]) if f"{name}_holds" in data else None for data in all_data}
        if len(limits) > 1:
            continue
        words = {
            surface: allowed.HOLDING.get(float(data[f"{name}_holds"][index]), allowed.NOT_DECIDED)
            for surface, (data, index) in results.items()
        }
        limit = allowed.limit_in_words(all_data[0], name)
        sentences.append(f"{ALLOWED_VALUES[name].words} {limit}: {_by_word(words, [*allowed.DECISIONS])}")
    return sentences


def _by_word(words: Mapping[str, str], order: Sequence[str] = ()) -> str:
    """Return which surfaces, by name, have which word; of many how many.

    Examples
    --------
    >>> _by_word({"a": "leaks", "b": "seals", "c": "leaks"}), _by_word({"a": "leaks", "b": "leaks"})
    ('leaks for a and c, seals for b', 'leaks for all 2')
    """
    by_word = {word: [name for name in words if words[name] == word] for word in [*order, *words.values()]}
    return sentence("by_word", by_word, len(words), IN_LINE)


def surfaces_in_words(results: Mapping[str, Load]) -> str:
    """Return of several surfaces, by name, what is allowed of all, else the least and the largest result.

    It is that at a load of each, of the first number that they are asked for; empty without one.

    Examples
    --------
    >>> areas = {"a": 0.3, "b": 0.1, "c": 0.2}
    >>> loads = {"mean_pressure": ("load", [1e6]), "contact_modulus": 1e9}
    >>> results = {name: (xr.Dataset(loads | {AREA: ("load", [area])}), 0) for name, area in areas.items()}
    >>> surfaces_in_words(results)
    'At 1.00 MPa: contact area from 10.0 % (b) to 30.0 % (a).'
    >>> surfaces_in_words({name: results["a"] for name in ("a", "d")})
    'At 1.00 MPa: contact area 30.0 % of all 2.'
    """
    all_data = [data for data, _ in results.values()]
    pressure = common_pressure(all_data)
    rising = sorted(results.values(), key=lambda at_load: float(at_load[0]["mean_pressure"][at_load[1]]))
    texts = [stated_loads(data, pressure).texts[index] for data, index in rising]
    head = f"At {texts[0]}" if len({*texts}) == 1 else f"At {texts[0]} to {texts[-1]}, each at its own load"
    if sentences := holding_in_words(results):
        return f"{head} {'; '.join(sentences)}."
    columns = glance.asked_columns(all_data)
    if glance.HEADINGS[columns[0]] in glance.IN_WORDS:  # a yes or no: which surfaces it is of
        words = {}
        for name, (data, index) in results.items():
            cell = glance.glance_rows(data, indices=[index])[0][columns[0]]
            is_open = cell.precision == allowed.NOT_DECIDED
            words[name] = f"{cell.text} ({cell.precision})" if is_open else cell.text
        return f"{head}: {_by_word(words)}."
    if "conductance" in columns:  # which is one of several numbers
        columns = [*columns, *glance.conductances(all_data[0])]
    columns_compared = _known_of_all(columns, all_data)[:1]
    if columns_compared == ["thermal_conductance"]:  # who asks for a joint of metals may mean current
        of_current = ["total_electrical_resistance", "electrical_resistance"]
        columns_compared += _known_of_all(of_current, all_data)[:1]
    ranges = [text for name in columns_compared if (text := _range_in_words(name, results))]
    return f"{head}: {'; '.join(ranges)}." if ranges else ""


def _known_of_all(names: Sequence[str], results: Sequence[xr.Dataset]) -> list[str]:
    """Return the names of numbers that all results have."""
    return [name for name in names if all(has_number(data, name) for data in results)]


def _range_in_words(name: str, results: Mapping[str, Load]) -> str:
    """Return the least and the largest of a number at a load of each surface; empty where none is known."""
    all_units = glance.glance_units([data for data, _ in results.values()])
    texts = [
        (float(data[name][index]), surface, glance.interval_cell(data, name, units, index).text)
        for (surface, (data, index)), units in zip(results.items(), all_units, strict=True)
    ]
    # the conductance of full contact is infinite
    rising = sorted((text for text in texts if not np.isnan(text[0])), key=itemgetter(0))
    return sentence("ranges", TITLES[name], rising)
