"""The table at a glance: the main answers for each surface at two or three loads, with their intervals."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import (
    ALLOWED_VALUES,
    ANSWERS,
    AREA,
    ASKED_BY,
    CONDUCTANCE,
    ENDS,
    GAP,
    PEAK,
    PRESSURE,
    QUANTITIES,
    TITLES,
    TOTALS,
    UNITS,
    USUAL,
)
from roughcontact.arguments.quantities import Unit, percent, quantity
from roughcontact.arguments.variables import Numbers, has_number, names_asked
from roughcontact.report.allowed import Sentence, allowed_in_words, fluid_in_words, stated_allowed
from roughcontact.report.template import sentence
from roughcontact.report.units import (
    common_pressure,
    hardness_reached,
    interval_at,
    lacks_interval,
    largest_source,
    median_numbers,
    number_text,
    quantity_text,
    unit_of,
)
from roughcontact.statistics import decisions
from roughcontact.statistics.contact_checks import rubber_like, yielding
from roughcontact.statistics.kinds import facts_of_numbers, reason_without_flow
from roughcontact.statistics.load_pairs import same_load
from roughcontact.statistics.outcome import FAILED, VERDICTS, Check
from roughcontact.statistics.precision import is_known, precision_in_words

AREAS = (0.01, 0.1)  # the loads with contact areas nearest to these are shown, and the heaviest
NOT_JUDGED = "not judged"
LOAD = "mean_pressure"  # name of the first column
HEADINGS = {LOAD: TITLES[LOAD]} | {name: answer.heading for name, answer in ANSWERS.items()}
HEADINGS |= {name: TITLES.get(name, name) for name in ASKED_BY if name not in ANSWERS}
IN_WORDS = [answer.heading for answer in ANSWERS.values() if not answer.quantity]  # they hold no number

CLOSED_IN_WORDS = "closed (< 1 nm)"
_NO_INTERVAL = "no ±"
_DECIDED, _NOT_DECIDED = "decided", "not decided"  # of a yes or no
_CURRENT, _JOINT = (CONDUCTANCE, "electrical_resistivity"), ("joint_conductance", "thermal_conductivity")
# a number in proportion to a property of the bodies -> the one whose sources its ± has, and that property
_FACTORS = {
    "friction_coefficient": (AREA, "shear_strength"),
    "thermal_conductance": (CONDUCTANCE, "thermal_conductivity"),
    "electrical_conductance": _CURRENT,
    **dict.fromkeys(("electrical_resistance", "total_electrical_resistance"), _CURRENT),
    **dict.fromkeys(("joint_conductance", "joint_resistance", "temperature_drop"), _JOINT),
}
# the conductances of a joint, of which the first that is known is shown, in words
_CONDUCTANCES = {
    "joint_conductance": "heat through the joint",
    "thermal_conductance": "heat",
    "electrical_conductance": "current",
    CONDUCTANCE: "by conductivity",
}
_COMMON_UNIT_RATIO = 100.0  # ratio of rms heights up to which one unit does for all


class Remark(NamedTuple):
    """What a number rests on: a property that counts as exact, or makes most of its ±."""

    subject: str
    is_exact: bool = True

    def __str__(self) -> str:
        of_exact = f"uncertainty of the {self.subject} not included"
        return of_exact if self.is_exact else f"uncertainty mainly from the {self.subject}"


class Cell(NamedTuple):
    """One cell of the table: the answer, details, its verdict unless that is *use*, how well it is known."""

    text: str
    details: str = ""  # the interval, or the number behind a yes or no
    outcome: str = ""
    precision: str = ""
    remarks: tuple[Remark, ...] = ()
    further: tuple[str, ...] = ()  # details that only the table has
    totals: tuple[str, ...] = ()  # of the whole joint
    allowed: tuple[str, ...] = ()  # whether what is allowed holds

    @property
    def all_details(self) -> str:
        """All details in one text."""
        return "; ".join(filter(None, (self.details, *self.further, *self.totals, *self.allowed)))

    @property
    def known(self) -> str:
        """How well the answer is known, with the remarks."""
        return ", ".join(filter(None, (self.precision, *map(str, self.remarks))))


def shown_loads(areas: np.ndarray) -> list[int]:
    """Return the indices of the two or three loads of a surface that are shown, loads rising.

    Examples
    --------
    >>> shown_loads(np.array([0.002, 0.011, 0.04, 0.08, 0.2, 0.7]))
    [1, 3, 5]
    >>> shown_loads(np.array([1e-5, 1e-4, 1e-3, 2e-3]))
    [0, 3]
    """
    if areas.size <= 3:
        return list(range(areas.size))
    # those with the areas nearest to `AREAS`, by ratio
    logarithm, last = np.log(np.maximum(areas, 1e-300)), areas.size - 1
    result = {int(np.abs(logarithm - np.log(area)).argmin()) for area in AREAS} | {last}
    return sorted(result if len(result) > 1 else {0, last})


def usable_loads(numbers: xr.Dataset) -> list[int]:
    """Return the indices of the loads that are shown of a surface; of loads that nobody stated usable ones.

    Planned loads may lie beyond what the material bears: those are left to the tables of all loads.
    """
    areas, usable = numbers[AREA].values, np.arange(numbers.sizes["load"])
    if numbers.attrs.get("loads") == "planned" and "verdict" in numbers:
        usable = np.flatnonzero(numbers["verdict"].values != list(VERDICTS).index(FAILED))
    if not usable.size:
        return shown_loads(areas)
    return usable[shown_loads(areas[usable])].tolist()


def shared_loads(results: Sequence[xr.Dataset], key: str = LOAD) -> list[list[int]]:
    """Return for each of several surfaces the indices of the loads at which all are shown, loads rising.

    Loads are the same by the variable `key`. Surfaces that share less than two, and not all of any, are
    shown at their own: nothing is returned.

    Examples
    --------
    >>> loads, areas = ([1e5, 2e5, 3e5, 4e5], [2e5, 4e5, 8e5]), ([0.01, 0.02, 0.03, 0.04], [0.1, 0.2, 0.3])
    >>> names = ("mean_pressure", "relative_contact_area")
    >>> results = [xr.Dataset({n: ("load", v) for n, v in zip(names, both)}) for both in zip(loads, areas)]
    >>> shared_loads(results), shared_loads([results[0], results[1].isel(load=[0, 2])])
    ([[1, 3], [0, 1]], [])
    """
    keys = [numbers[key].values for numbers in results]
    first_loads, *other_loads = keys or [np.array([])]
    shared = [load for load in first_loads if all(same_load(load, loads).any() for loads in other_loads)]
    if not other_loads or len(shared) < min(2, *(loads.size for loads in keys)):
        return []
    indices = np.array([[int(np.abs(loads - load).argmin()) for load in shared] for loads in keys])
    areas = [numbers[AREA].values[loads] for numbers, loads in zip(results, indices, strict=True)]
    return np.sort(indices[:, shown_loads(np.median(areas, axis=0))]).tolist()


def asked_columns(results: Sequence[xr.Dataset]) -> list[str]:
    """Return the names of the columns of what any of some surfaces is asked for.

    The largest pressure that is allowed is asked for beside the usual numbers.

    Examples
    --------
    >>> seal, bearing = xr.Dataset({"leak_rate_x": ("load", [1e-9])}), xr.Dataset({"allowed_pressure": 1e9})
    >>> [[HEADINGS[name] for name in asked_columns([result])] for result in (seal, bearing)]
    [['seals?'], ['contact area', 'pressure in contact', 'mean gap', 'largest pressure']]
    >>> [HEADINGS[name] for name in asked_columns([xr.Dataset({"joint_area": 1e-6})])]
    ['conductance']
    >>> [HEADINGS[name] for name in asked_columns([xr.Dataset({"contact_radius": ("load", [5e-5])})])]
    ['contact radius', 'largest pressure']
    """
    columns: set[str] = set()
    for numbers in results:
        names = names_asked(numbers)
        columns |= names if names - {PEAK} else {*USUAL, *names}
    return [name for name in (*USUAL, *ASKED_BY) if name in columns]


def headings_of(columns: Sequence[str], results: Sequence[xr.Dataset]) -> list[str]:
    """Return the headings of the load, as it is stated for some surfaces, and of these columns."""
    return [load_heading(results), *(_heading(name, results) for name in columns)]


def _heading(name: str, results: Sequence[xr.Dataset]) -> str:
    """Return the heading of a column: of a conductance the number of which all allow something."""
    words = {
        TITLES[limited[0]] if (limited := _limited(numbers, name)) else HEADINGS[name] for numbers in results
    }
    return words.pop() if len(words) == 1 else HEADINGS[name]


def verdict_on_asked(numbers: xr.Dataset, indices: Sequence[int], verdict: str) -> str:
    """Return the worst of a verdict on a surface and those on what is asked in particular, at some loads.

    Examples
    --------
    >>> seal = xr.Dataset({"leak_rate_x": ("load", [1e-9]), "sealing_verdict": ("load", [1])})
    >>> verdict_on_asked(seal, [0], "passed")
    'review'
    """
    names = {*asked_columns([numbers])} - {*USUAL}
    outcomes = [outcome_of(numbers, index, name) for name in names for index in indices]
    return max(verdict, *filter(None, outcomes), key=[*VERDICTS].index) if any(outcomes) else verdict


def main_doubt(numbers: xr.Dataset, doubts: Sequence[Check]) -> Check | None:
    """Return the first of some checks that concerns what is asked for, contact area or pressure in contact.

    Examples
    --------
    >>> gap, area = Check("Sample", "review", "Small.", (GAP,)), Check("Noise", "review", "High.", (AREA,))
    >>> rubbing = xr.Dataset({"friction_coefficient": ("load", [0.2])})
    >>> main_doubt(rubbing, [gap, area]).name, main_doubt(xr.Dataset(), [gap, area]).name
    ('Noise', 'Sample')
    """
    answers = {*asked_columns([numbers]), AREA, PRESSURE}
    return next((check for check in doubts if answers & {*check.answers}), None)


def load_heading(results: Sequence[xr.Dataset]) -> str:
    """Return the heading of the first column: what the loads of some surfaces are stated as.

    Examples
    --------
    >>> ball, seal = xr.Dataset({"force": ("load", [5.0])}), xr.Dataset({"mean_pressure": ("load", [1e6])})
    >>> load_heading([ball]), load_heading([seal]), load_heading([ball, seal])
    ('force', 'mean pressure', 'load')
    """
    headings = {"force" if has_number(numbers, "force") else HEADINGS[LOAD] for numbers in results}
    return headings.pop() if len(headings) == 1 else "load"


def slip_in_words(numbers: xr.Dataset, index: int) -> str:
    """Return how much of the contact sticks at a normal load, empty where that, or Q, is not known.

    Examples
    --------
    >>> shares = {"stick_share": (("load", "tangential_load"), [[0.75, 0.4]]), "tangential_load": [0.3, 0.6]}
    >>> slip_in_words(xr.Dataset(shares), 0)
    'With the stated μ 75.0 % of the contact sticks at Q = 0.300 μP, 40.0 % at Q = 0.600 μP.'
    """
    if not {"stick_share", "tangential_load"} <= {*numbers.variables}:
        return ""
    loads, shares = numbers["tangential_load"].values, numbers["stick_share"].values[index]
    return sentence("sticks", list(zip(loads, shares, strict=True)))


def answer_line(numbers: xr.Dataset, index: int, cells: Mapping[str, Cell], *, alone: bool = False) -> str:
    """Return the `answer_sentences` of a surface at a load in one line."""
    return " ".join(map(str, answer_sentences(numbers, index, cells, alone=alone)))


def answer_sentences(
    numbers: xr.Dataset, index: int, cells: Mapping[str, Cell], *, alone: bool = False
) -> list[Sentence]:
    """Return what a surface is asked for at a load, whose cells of `glance_rows` these are.

    Whether what is allowed holds comes first. Sentences that are `alone` have all that the cells have.
    """
    words, cells_asked = [], {name: cells[name] for name in asked_columns([numbers])}
    names_allowed = stated_allowed(numbers)
    allowed = [allowed_in_words(numbers, name, index) for name in names_allowed]
    remarks = Counter(remark for cell in cells_asked.values() for remark in cell.remarks)
    repeated = [remark for remark, count in remarks.items() if count > 1]
    for name, cell in cells_asked.items():
        if not alone and {*_limited(numbers, name)} & {*TOTALS}:
            continue  # the first sentence has it
        subject = ANSWERS[name].words if name in ANSWERS else HEADINGS[name]
        subject = _heading(name, [numbers]) if _limited(numbers, name) else subject
        if HEADINGS[name] in IN_WORDS and cell.text != NOT_JUDGED:
            subject = ""
        known = [cell.precision, *(str(remark) for remark in cell.remarks if remark not in repeated)]
        if alone:
            verdict = "" if cell.outcome == cells[LOAD].outcome else VERDICTS.get(cell.outcome, "")
            known = [cell.details, *cell.further, *cell.totals, *known, verdict]
        else:
            known = [cell.details, *known, *([] if allowed else cell.totals)]
        text = f"{subject} {cell.text}".lstrip()
        if precision := ", ".join(filter(None, known)):
            # what is closed has the parentheses already
            text = f"{text[:-1]}, {precision})" if cell.text == CLOSED_IN_WORDS else f"{text} ({precision})"
        words.append(text)
    at_load = f"At {cells[LOAD].text}: {', '.join(words)}"
    line = Sentence("; ".join([at_load, *map(str, repeated)]), detail=".")
    capital = [Sentence(f"{text[0].upper()}{text[1:]}", word, f"{rest}.") for text, word, rest in allowed]
    slip = slip_in_words(numbers, index)
    return [*capital, *([line] if words else []), *([Sentence(slip)] if slip else [])]


def glance_units(results: Sequence[xr.Dataset]) -> list[dict[str, Unit]]:
    """Return for each surface the units in the table by name of the variable.

    Pressures have that of all, and lengths unless the rms heights differ over `_COMMON_UNIT_RATIO` times.
    """
    rms = [value for result in results if (value := float(result.get("rms_height", 0.0))) > 0]
    common = median_numbers(results) if not rms or max(rms) <= _COMMON_UNIT_RATIO * min(rms) else None
    pressure = common_pressure(results)
    return [
        {name: pressure if unit == "Pa" else unit_of(common or result, unit) for name, unit in UNITS.items()}
        for result in results
    ]


def glance_rows(
    numbers: xr.Dataset, units: Mapping[str, Unit] | None = None, indices: Sequence[int] | None = None
) -> list[dict[str, Cell]]:
    """Return for two or three loads of a surface, loads rising, the cells by the names in `HEADINGS`.

    An absent or NaN number counts as not asked for; `units` and `indices` default to those of this surface.
    """
    units = glance_units([numbers])[0] if units is None else units
    indices = shown_loads(numbers[AREA].values) if indices is None else indices
    plain = {str(name): variable.values for name, variable in numbers.variables.items()}
    return [{name: _cell(plain, name, units, index) for name in HEADINGS} for index in indices]


def _cell(numbers: Numbers, name: str, units: Mapping[str, Unit], index: int) -> Cell:
    """Return the cell of a column at a load, with what is allowed, and the verdict on what is judged."""
    if name in _CELLS:
        cell = _CELLS[name](numbers, units, index)
    elif name in (LOAD, *ANSWERS) or has_number(numbers, name):
        cell = interval_cell(numbers, name, units, index)
    else:
        cell = Cell(NOT_JUDGED)
    if cell.text == NOT_JUDGED:
        return cell
    names = stated_allowed(numbers, name)
    allowed = tuple(str(allowed_in_words(numbers, key, index, brief=True)) for key in names)
    return cell._replace(allowed=allowed, outcome=outcome_of(numbers, index, "" if name == LOAD else name))


def _load_cell(numbers: Numbers, units: Mapping[str, Unit], index: int) -> Cell:
    """Return the mean pressure of a load, or the force that was stated, of a nominal area with both."""
    cell = interval_cell(numbers, LOAD, units, index)
    if not has_number(numbers, "force"):
        return cell
    # that of a body of finite size is over a map of any size
    pressure = "" if facts_of_numbers(numbers).own_numbers else cell.text
    return cell._replace(text=quantity(float(numbers["force"][index]), "N"), details=pressure)


def outcome_of(numbers: Numbers, index: int, answer: str = "") -> str:
    """Return the verdict on a load, or an answer at it, a key of `VERDICTS`; empty for *use* or unknown.

    Examples
    --------
    >>> outcome_of(xr.Dataset({"mean_gap_verdict": ("load", [0, 1])}), 1, "mean_gap")
    'review'
    """
    name = f"{answer}_verdict" if answer else "verdict"
    code = float(numbers[name][index]) if name in numbers else 0.0
    return list(VERDICTS)[int(code)] if code > 0 else ""


def interval_cell(numbers: Numbers, name: str, units: Mapping[str, Unit], index: int) -> Cell:
    """Return a number of a load, its interval, and how well it is known; of a limited one the limit."""
    unit, has_range = units[name], "hardness_lower" in numbers
    text, _, interval = number_text(numbers, name, unit, index).partition(" ")
    shown = f"{text} {unit.symbol}".rstrip()
    if name == PEAK and not has_range and hardness_reached(numbers)[index]:
        return Cell(shown, "the hardness as stated")
    if lacks_interval(numbers, name):
        return Cell(shown, _NO_INTERVAL)
    limited = name in QUANTITIES and QUANTITIES[name].limits is not None and PEAK in numbers
    share = numbers.get("load_share_above_hardness")  # of a group of maps it is not known
    flows = limited and bool((hardness_reached(numbers) if share is None else np.greater(share, 0))[index])
    value, lower, upper = interval_at(numbers, name, index)
    remarks = [Remark("hardness")] if flows and not has_range else []
    if cause := _largest_cause(numbers, name, index):
        remarks.append(Remark(cause, is_exact=False))
    _, factor_name = _FACTORS.get(name, ("", ""))
    if factor_name and f"{factor_name}_lower" not in numbers:
        remarks.append(Remark(_in_words(factor_name)))
    if name == GAP and min(value, upper) < decisions.CLOSED:  # a NaN end is no smaller
        open_elsewhere = f"up to {unit.text(upper)}" if upper >= decisions.CLOSED else ""
        return Cell(CLOSED_IN_WORDS, open_elsewhere, precision="" if open_elsewhere else _DECIDED)
    remarks = remarks if is_known(value, lower, upper) else []
    precision = precision_in_words(value, lower, upper)
    return Cell(shown, interval.strip("()"), precision=precision, remarks=tuple(remarks))


def _in_words(name: str) -> str:
    """Return the name of a property without what it is a property of: "resistivity", "shear strength"."""
    return name.removeprefix("thermal_").removeprefix("electrical_").replace("_", " ")


def _largest_cause(numbers: Numbers, name: str, index: int) -> str:
    """Return the property that makes most of the ± of a number at a load; empty for another cause.

    Examples
    --------
    >>> widths = {"relative_contact_area_uncertainty": [[0.03, 0.02]], "source": ["hardness", "combined"]}
    >>> numbers = widths | {"relative_contact_area": [0.1], "shear_strength": 1e8}
    >>> range_of_strength = {"shear_strength_lower": 6e7, "shear_strength_upper": 1.2e8}
    >>> [_largest_cause(n, "friction_coefficient", 0) for n in (numbers, numbers | range_of_strength)]
    ['hardness', 'shear strength']
    """
    base, factor_name = _FACTORS.get(name, (name, ""))
    if not (source := largest_source(numbers, base, index)):
        return ""
    if f"{factor_name}_lower" in numbers:
        value, lower, upper = (float(numbers[f"{factor_name}{end}"]) for end in ENDS)
        row = list(np.asarray(numbers["source"])).index(source)
        width = float(numbers[f"{base}_uncertainty"][index][row]) / float(numbers[base][index])
        if max(upper - value, value - lower) / value > width:
            return _in_words(factor_name)
    return source if source == "hardness" else ""


def _seals(numbers: Numbers, units: Mapping[str, Unit], index: int) -> Cell:
    """Return whether the gap is closed to a fluid, else leak rate and narrowest place."""
    if (reason := reason_without_flow(numbers)) or not has_number(numbers, "gap_percolates_x"):
        return Cell(NOT_JUDGED, reason)
    if lifts := fluid_in_words(numbers, index):
        return Cell("leaks", lifts, precision=_DECIDED)
    closed_axes = {axis: decisions.gap_is_closed(numbers, axis)[index] for axis in "xy"}
    open_axes = [axis for axis in "xy" if float(numbers[f"gap_percolates_{axis}"][index])]

    def leaks(axis: str) -> bool:
        """Return whether a gap that is not decided counts as open: it is wider than what counts as closed."""
        opening = interval_at(numbers, f"critical_constriction_{axis}", index)[0]
        return axis in open_axes and not opening <= decisions.closed_opening(numbers, axis)[index]

    leaking = [a for a in "xy" if closed_axes[a] == 0 or (np.isnan(closed_axes[a]) and leaks(a))]
    judged = [axis for axis in "xy" if has_number(numbers, f"critical_constriction_{axis}_lower")]
    undecided = [axis for axis in judged if np.isnan(closed_axes[axis])]
    precision = "" if len(judged) < 2 else _NOT_DECIDED if undecided else _DECIDED
    axes_shown = [axis for axis in "xy" if axis in leaking + undecided]
    details = [] if leaking or open_axes else ["gap closed along x and y"]
    if not leaking and open_axes and not undecided:
        tight = units["leak_rate_x"].text(decisions.TIGHT)
        details.append(f"leaks less than {tight}, which counts as nothing")
    for words, name in (("leak rate", "leak_rate"), ("narrowest place", "critical_constriction")):
        if axes_shown and has_number(numbers, f"{name}_x"):
            result = {axis: _unbroken(numbers, f"{name}_{axis}", units, index) for axis in axes_shown}
            if len(axes_shown) == 2 and len(set(result.values())) == 1:  # one place decides both ways
                result = {"x and y": result["x"]}
            details.append(f"{words} {', '.join(f'{text} ({axis})' for axis, text in result.items())}")
    answer = {"": "seals", "x": "seals along y, leaks along x", "y": "seals along x, leaks along y"}
    first, *further = details or [""]
    text = answer.get("".join(leaking), "leaks")
    return Cell(text, first, precision=precision, further=tuple(further))


def _unbroken(numbers: Numbers, name: str, units: Mapping[str, Unit], index: int) -> str:
    """Return a number of a load with its interval before its unit, joined by no-break spaces."""
    value, *bounds = interval_at(numbers, name, index)
    if not np.isfinite([value, *bounds]).any():
        return "not known"
    return quantity_text(numbers, name, units[name], index).replace(" ", "\N{NO-BREAK SPACE}")


def _yields(numbers: Numbers, units: Mapping[str, Unit], index: int) -> Cell:
    """Return whether a body yields at a load, at its surface or below."""
    # infinite where all of the body yields
    below = float(numbers["volume_above_yield"][index]) if "volume_above_yield" in numbers else np.nan
    if has_number(numbers, "hardness"):
        share = float(numbers["load_share_above_hardness"][index])
        if share == 0 and below > 0:
            return Cell("yes", "below the surface")
        decision = decisions.is_yielding(numbers)[index]
        has_interval = has_number(numbers, f"{PEAK}_lower") or has_number(numbers, f"{PEAK}_upper")
        precision = "" if not has_interval else _NOT_DECIDED if np.isnan(decision) else _DECIDED
        if share > 0:
            return Cell("yes", f"yielded asperities carry {percent(share)} of the load", precision=precision)
        is_reached = PEAK in numbers and hardness_reached(numbers)[index]
        details = f"hardness {'just' if is_reached else 'nowhere'} reached"
        return Cell("yes" if decision == 1 else "no", details, precision=precision)
    if not np.isnan(below):
        return Cell("yes", "below the surface") if below else Cell("no", "yield stress nowhere reached")
    if rubber_like(numbers):
        return Cell(NOT_JUDGED, "rubber-like")
    pressures = {name: numbers[name][index] for name in (PRESSURE, PEAK)}
    would = yielding(pressures | {"contact_modulus": numbers["contact_modulus"]})
    return Cell(NOT_JUDGED, "; ".join(filter(None, ("no hardness stated", would))))


def conductances(numbers: Numbers) -> list[str]:
    """Return the conductances that are known, the one that answers first."""
    return [name for name in _CONDUCTANCES if has_number(numbers, name)]


def _conducts(numbers: Numbers, units: Mapping[str, Unit], index: int) -> Cell:
    """Return the conductance of the joint, of heat or of current, or that by conductivity, and resistances.

    That of current is there unless a film, a gas or a flow of heat says that heat alone is asked for. Where
    something is allowed of a resistance, or of the drop of temperature, it is that number alone.
    """
    if limited := _limited(numbers, "conductance"):
        return interval_cell(numbers, limited[0], units, index)
    if not (name := next(iter(conductances(numbers)), "")):
        return Cell(NOT_JUDGED)
    main = interval_cell(numbers, name, units, index)
    of_heat = name == "joint_conductance" or "temperature_drop" in numbers
    names = dict.fromkeys((name, name if of_heat else "electrical_conductance"))
    kinds = ("electrical" if key.startswith("electrical") else "thermal" for key in names)

    def known(keys: Iterable[str], ending: str = "") -> tuple[str, ...]:
        return tuple(_unbroken(numbers, key, units, index) + ending for key in keys if key in numbers)

    further = known(key.replace("conductance", "resistance") for key in names)
    totals = (f"total_{kind}_resistance" for kind in kinds if "joint_area" in numbers)
    details = ", ".join(filter(None, (main.details, _CONDUCTANCES[name])))
    return main._replace(details=details, further=further, totals=known(totals, " of the joint"))


def _limited(numbers: Numbers, answer: str) -> list[str]:
    """Return the numbers of a conductance of which something is allowed, first the one that is shown."""
    names = stated_allowed(numbers, answer) if answer == "conductance" else []
    return [ALLOWED_VALUES[name].numbers[0] for name in names]


# of the answers that are more than a number with its interval
_CELLS: dict[str, Callable[[Numbers, Mapping[str, Unit], int], Cell]] = {
    LOAD: _load_cell,
    "sealing": _seals,
    "yield": _yields,
    "conductance": _conducts,
}
