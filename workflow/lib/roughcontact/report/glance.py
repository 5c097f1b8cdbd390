"""The table at a glance: the main answers for each surface at two or three loads, with their intervals."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, number, percent, quantity, with_interval
from roughcontact.report.tables import UNITS, as_the_area, has_number, is_finite_body, is_profile
from roughcontact.report.units import interval_at, middle_of, unit_of
from roughcontact.statistics.contact_checks import rubber_like, yield_flags
from roughcontact.statistics.outcome import FAILED, VERDICTS
from roughcontact.statistics.precision import gap_is_decided, precision_in_words, yield_is_decided
from roughcontact.variables import ANSWERS, Numbers, values_at_load

AREAS = (0.01, 0.1, 0.3)  # the loads with contact areas nearest to these are shown
NOT_JUDGED = "not judged"
IN_WORDS = "seals?", "yields?"  # headings of the columns that hold no number
HEADINGS = (
    "mean pressure\N{NO-BREAK SPACE}p̄",
    "contact area\N{NO-BREAK SPACE}A/A₀",
    "pressure in contact",
    "mean\N{NO-BREAK SPACE}gap\N{NO-BREAK SPACE}ū",
    *IN_WORDS,
    "largest pressure",
    "conductance",
)

_NO_INTERVAL = "no ±"
_ONE_SIDED, _TWO_SIDED = "in all of the ±", "either in the ±"  # of a yes or no
_COMMON_UNIT_RATIO = 100.0  # ratio of rms heights up to which one unit does for all


class Cell(NamedTuple):
    """One cell of the table: the answer, details, how well it is known, its verdict unless that is *use*."""

    text: str
    details: str = ""
    outcome: str = ""
    precision: str = ""


def shown_loads(areas: np.ndarray) -> list[int]:
    """Return the indices of the two or three loads of a surface that are shown, loads rising.

    Examples
    --------
    >>> shown_loads(np.array([0.002, 0.011, 0.04, 0.08, 0.2, 0.7]))
    [1, 3, 4]
    >>> shown_loads(np.array([1e-5, 1e-4, 1e-3, 2e-3]))
    [0, 3]
    """
    if areas.size <= 3:
        return list(range(areas.size))
    # those with the areas nearest to `AREAS`, by ratio
    logarithm = np.log(np.maximum(areas, 1e-300))
    result = {int(np.abs(logarithm - np.log(area)).argmin()) for area in AREAS}
    if len(result) == 1:
        result |= {0, areas.size - 1}
    return sorted(result)


def usable_loads(numbers: xr.Dataset) -> list[int]:
    """Return the indices of the loads that are shown of a surface; of loads that nobody stated usable ones.

    Planned loads may lie beyond what the material bears: those are left to the tables of all loads.
    """
    areas, usable = numbers["relative_contact_area"].values, np.arange(numbers.sizes["load"])
    if numbers.attrs.get("loads") == "found" and "verdict" in numbers:
        usable = np.flatnonzero(numbers["verdict"].values != list(VERDICTS).index(FAILED))
    if not usable.size:
        return shown_loads(areas)
    return usable[shown_loads(areas[usable])].tolist()


def loads_to_compare(results: Sequence[xr.Dataset], area: float = 0.1) -> list[int]:
    """Return for each of many surfaces the index of the load at which they are compared, loads rising.

    The median area there is nearest to `area`, by ratio; with other numbers of loads each has its own.
    """
    areas = [result["relative_contact_area"].values for result in results]
    if len({result.size for result in areas}) == 1:
        areas = [np.median(areas, axis=0)] * len(areas)
    deviation = [np.abs(np.log(np.maximum(result, 1e-300)) - np.log(area)) for result in areas]
    return [int(result.argmin()) for result in deviation]


def glance_units(results: Sequence[xr.Dataset]) -> list[dict[str, Unit]]:
    """Return for each surface the units in the table by name of the variable.

    Lengths have that of all unless the rms heights differ more than `_COMMON_UNIT_RATIO` times.
    """
    rms = [value for result in results if (value := float(result.get("rms_height", 0.0))) > 0]
    common_units = middle_of(results) if not rms or max(rms) <= _COMMON_UNIT_RATIO * min(rms) else None
    return [
        {
            name: unit_of(result if unit == "Pa" or common_units is None else common_units, unit)
            for name, unit in UNITS.items()
        }
        for result in results
    ]


def glance_rows(
    numbers: xr.Dataset, units: Mapping[str, Unit] | None = None, indices: Sequence[int] | None = None
) -> list[list[Cell]]:
    """Return for two or three loads of a surface, loads rising, the cells below `HEADINGS`.

    An absent or NaN number counts as not asked for; `units` and `indices` default to those of this surface.
    """
    units = glance_units([numbers])[0] if units is None else units
    indices = shown_loads(numbers["relative_contact_area"].values) if indices is None else indices
    plain = {str(name): variable.values for name, variable in numbers.variables.items()}
    return [
        [
            _load_cell(plain, units, index),
            *_judged(
                [
                    interval_cell(plain, "relative_contact_area", units, index),
                    interval_cell(plain, "mean_contact_pressure", units, index),
                    interval_cell(plain, "mean_gap", units, index),
                    _seals(plain, units, index),
                    _yields(values_at_load(numbers, index)),
                    largest_cell(plain, units, index),
                    _conducts(plain, units, index),
                ],
                plain,
                index,
            ),
        ]
        for index in indices
    ]


def _load_cell(numbers: Numbers, units: Mapping[str, Unit], index: int) -> Cell:
    """Return the mean pressure of a load, with the force where that is what was stated."""
    cell = interval_cell(numbers, "mean_pressure", units, index)._replace(outcome=outcome_of(numbers, index))
    if not has_number(numbers, "force"):
        return cell
    return cell._replace(details=quantity(float(numbers["force"][index]), "N"))


def _judged(cells: Sequence[Cell], numbers: Numbers, index: int) -> list[Cell]:
    """Return the cells of a load with their verdicts, where they are known; what is not judged has none."""
    return [
        cell._replace(outcome=outcome_of(numbers, index, answer)) if cell.text != NOT_JUDGED else cell
        for cell, answer in zip(cells, ANSWERS, strict=True)  # in the order of the columns
    ]


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
    """Return a number of a load and its interval."""
    factor, unit_label = units[name]
    value, lower, upper = (number * factor for number in interval_at(numbers, name, index))
    if not has_number(numbers, f"{name}_lower"):
        has_area = has_number(numbers, "relative_contact_area_lower")
        if name.endswith(("_conductance", "_resistance")) and has_area:
            return Cell(f"{as_the_area(numbers, name, units[name], index)} {unit_label}", _NO_INTERVAL)
        return Cell(f"{number(value)} {unit_label}")
    text, _, interval = with_interval(value, lower, upper).partition(" ")
    precision = precision_in_words(value, lower, upper, Unit(1.0, unit_label))
    return Cell(f"{text} {unit_label}", interval.strip("()"), precision=precision)


def _seals(numbers: Numbers, units: Mapping[str, Unit], index: int) -> Cell:
    """Return whether the gap is closed to a fluid, else leak rate and narrowest place."""
    if not has_number(numbers, "gap_percolates_x"):
        return Cell(NOT_JUDGED, "a body of finite size" if is_finite_body(numbers) else "")
    if is_profile(numbers):
        return Cell(NOT_JUDGED, "a profile does not tell")
    is_open = [axis for axis in ("x", "y") if float(numbers[f"gap_percolates_{axis}"][index])]
    decided = [gap_is_decided(numbers, axis)[index] for axis in "xy"]
    doubted = [axis for axis, one_sided in zip("xy", decided, strict=True) if one_sided == 0]
    precision = "" if np.isnan(decided).any() else _TWO_SIDED if doubted else _ONE_SIDED
    displayed = [axis for axis in "xy" if axis in is_open + doubted]
    doubt, details = " (in doubt)" if doubted else "", [] if is_open else ["gap closed along x and y"]
    for sentence, name in (("leak rate", "leak_rate"), ("narrowest place", "critical_constriction")):
        if displayed and has_number(numbers, f"{name}_x"):
            result = {axis: _unbroken(numbers, f"{name}_{axis}", units, index) for axis in displayed}
            if len(displayed) == 2 and len(set(result.values())) == 1:  # one place decides both ways
                result = {"x and y": result["x"]}
            details.append(f"{sentence} {', '.join(f'{text} ({axis})' for axis, text in result.items())}")
    if not is_open:
        return Cell(f"seals{doubt}", "; ".join(details), precision=precision)
    closed = {"x": "y", "y": "x"}[is_open[0]]
    answer = "leaks" if len(is_open) == 2 else f"seals along {closed}, leaks along {is_open[0]}"
    return Cell(answer + doubt, "; ".join(details), precision=precision)


def _unbroken(numbers: Numbers, name: str, units: Mapping[str, Unit], index: int) -> str:
    """Return a number of a load with its interval before its unit, joined by no-break spaces."""
    value, *ends = interval_at(numbers, name, index)
    if not np.isfinite([value, *ends]).any():
        return "not known"
    return f"{units[name].interval(value, *ends)} {units[name].symbol}".replace(" ", "\N{NO-BREAK SPACE}")


def _yields(load: Mapping[str, Any]) -> Cell:
    """Return whether a body yields at a load, at its surface or below."""
    below = float(load.get("volume_above_yield", np.nan)) > 0  # infinite where all of the body yields
    if has_number(load, "hardness"):
        share, decided = float(load["load_share_above_hardness"]), float(yield_is_decided(load))
        if share == 0 and below:
            return Cell("yes", "below the surface")
        precision = "" if np.isnan(decided) else _ONE_SIDED if decided else _TWO_SIDED
        doubt = " (in doubt)" if decided == 0 else ""
        limited = float(load.get("max_pressure", 0.0)) >= float(load["hardness"]) * (1 - 1e-9)
        details = "hardness just reached" if limited else "hardness nowhere reached"
        details = f"{percent(share)} of the load flows" if share > 0 else details
        return Cell(f"{'yes' if share > 0 else 'no'}{doubt}", details, precision=precision)
    if below or has_number(load, "volume_above_yield"):
        return Cell("yes", "below the surface") if below else Cell("no", "yield stress nowhere reached")
    if rubber_like(load):
        return Cell(NOT_JUDGED, "rubber-like")
    flags = yield_flags({name: value for name, value in load.items() if name != "hardness"})
    would = {"metals flow": "; metals would", "beyond hardness": "; any material would"}
    return Cell(NOT_JUDGED, "no hardness stated" + would.get(" ".join(flags), ""))


def largest_cell(numbers: Numbers, units: Mapping[str, Unit], index: int) -> Cell:
    """Return the largest pressure of a load; a pressure that is limited has no interval of its own."""
    if is_limited(numbers, index):
        largest = float(numbers["max_pressure"][index])
        return Cell(units["max_pressure"].text(largest), "the hardness")
    return interval_cell(numbers, "max_pressure", units, index)


def is_limited(numbers: Numbers, index: int) -> bool:
    """Return whether the largest pressure of a load is the hardness.

    Examples
    --------
    >>> is_limited(xr.Dataset({"max_pressure": ("load", [2e8, 3e8]), "hardness": 3e8}), 1)
    True
    """
    if not has_number(numbers, "hardness"):
        return False
    return bool(float(numbers["max_pressure"][index]) >= float(numbers["hardness"]) * (1 - 1e-9))


def _conducts(numbers: Numbers, units: Mapping[str, Unit], index: int) -> Cell:
    """Return the conductance of heat or of current, or that by conductivity."""
    for name, sentence in (
        ("thermal_conductance", "heat"),
        ("electrical_conductance", "current"),
        ("conductance_per_conductivity", "by conductivity"),
    ):
        if has_number(numbers, name):
            text, interval, _, precision = interval_cell(numbers, name, units, index)
            details = [f"{interval}, {sentence}" if interval else sentence]
            if (second := name.replace("conductance", "resistance")) in numbers:
                cell = interval_cell(numbers, second, units, index)
                details.append(
                    cell.text if interval == _NO_INTERVAL else _unbroken(numbers, second, units, index)
                )
            return Cell(text, "; ".join(details), precision=precision)
    return Cell(NOT_JUDGED)
