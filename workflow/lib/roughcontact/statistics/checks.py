"""All checks of a surface, their verdict, and the warnings of single loads.

A check passes, notes what the interval includes, warns (`review`: the interval may be wrong, the sentence
says by how much, and what to do), or fails (do not use the result); one that cannot be made says so and never
passes. The verdict on an answer is that of the worst check that concerns it; that on a load or a surface
is the verdict on contact area and pressure in contact. The checks and their limits stand in
`contact_checks`, `map_checks` and `instrument_checks`.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ANSWERS
from roughcontact.arguments.kinds import FINITE_BODY, facts_of
from roughcontact.arguments.measurement import Instrument, json_attributes
from roughcontact.arguments.variables import describe, values_at_load
from roughcontact.statistics import contact_checks, instrument_checks, map_checks, outcome
from roughcontact.statistics.contact_checks import CONTACT_POINTS, OVERCOUNT, overcount
from roughcontact.statistics.local_scale_checks import local_scale
from roughcontact.statistics.map_checks import FILLED_IN_CONTACT, REJECTED_LOAD, Attributes
from roughcontact.statistics.outcome import Check
from roughcontact.statistics.selected_loads import SelectedLoads, Statistics

# warnings that told nothing of where results of measured maps lie outside their intervals
_NOTES = ("Resolution", "Missing points", "Outliers")
# source of the interval -> warnings of what it evaluates
_IN_THE_INTERVAL = {
    "discretisation": ("Resolution",),
    "window": ("Periodic window", "Form", "Scan lines", "Window", "Longest wave"),
    "instrument": ("Band", "Noise", "Quantisation"),
}
# a limit of the window beyond which the interval does not hold either
_BEYOND_THE_INTERVAL: dict[str, Callable[[Attributes], bool]] = {
    "Noise": instrument_checks.is_mostly_noise,
    "Quantisation": instrument_checks.is_too_coarse,
    "Form": lambda window: facts_of(window).adds_form(window),
}
# checks of what a body of finite size does not have: its form and edges are meant
_NOT_OF_BODIES = (
    *("Periodic window", "Window", "Longest wave", "Sample", "Load range", "Slopes", "Steep places"),
)


def surface_checks(
    statistics: Statistics, *, height: Attributes, levelled: Attributes, window: Attributes, points: int
) -> list[Check]:
    """Return the checks of one surface under one case, in the order of the report.

    Parameters
    ----------
    statistics : Dataset
        as `contact_statistics` returns it.
    height, levelled, window : mapping
        attributes of the map as measured, levelled, and made periodic.
    points : int
        number of points of the window.

    Returns
    -------
    list of Check
    """
    # the table of surfaces prevails over the settings
    window = {**Instrument.read(statistics.attrs).attributes(), **window}
    checks = (
        contact_checks.units(statistics),
        contact_checks.convergence(statistics),
        contact_checks.contact_points(statistics, points),
        contact_checks.resolution(statistics),
        contact_checks.layers(statistics, points),
        contact_checks.mean_free_path(statistics),
        local_scale(statistics),
        contact_checks.fluid(statistics),
        instrument_checks.smoothed(window),
        instrument_checks.noise(window),
        instrument_checks.quantisation(window),
        instrument_checks.isolated_peak(statistics, window),
        map_checks.missing_points(statistics, height, levelled),
        map_checks.outliers(statistics, levelled),
        map_checks.scan_lines(levelled, statistics),
        map_checks.form(levelled, window),
        map_checks.periodicity(window),
        map_checks.window_share(window),
        map_checks.faces(levelled, window),
        map_checks.longest_wave(statistics),
        map_checks.sample(statistics),
        map_checks.lay(statistics, window),
        map_checks.band(window),
        contact_checks.plasticity(statistics),
        contact_checks.load_range(statistics),
        map_checks.slope(statistics),
        map_checks.steep_places(window),
        instrument_checks.height_unit(height, window),
        instrument_checks.pixel_size(height, window),
        map_checks.reading(height, levelled),
    )
    omitted = _NOT_OF_BODIES if facts_of(statistics.attrs) is FINITE_BODY else ()
    made = (check for check in checks if check is not None and check.name not in omitted)
    return [_noted(check, statistics, window) for check in made]


def _noted(check: Check, statistics: Statistics, window: Attributes) -> Check:
    """Return a warning as a note where the interval includes what it says, or the settings ask for it."""
    is_beyond = _BEYOND_THE_INTERVAL.get(check.name)
    if check.outcome != outcome.REVIEW or (is_beyond and is_beyond(window)):
        return check
    note = check._replace(outcome=outcome.NOTE)
    budget = statistics.get("relative_contact_area_uncertainty")
    if budget is not None:
        of_check = [check.name in _IN_THE_INTERVAL.get(source, ()) for source in statistics["source"].values]
        # an interval without an end includes nothing
        if any(of_check) and np.isfinite(budget[:, of_check]).all():
            return note._replace(advice=f"{check.advice} The ± includes it.".lstrip())
    # where the contact was solved with a hardness, flow is in the numbers
    is_solved = check.name == "Plasticity" and "hardness" in statistics
    return note if is_solved or check.name in _NOTES else check


def load_flags(statistics: xr.Dataset, points: int) -> list[list[str]]:
    """Return the warnings of each load in a word or two (mostly none).

    Parameters
    ----------
    statistics : Dataset
        as `contact_statistics` returns it.
    points : int
        number of points of the window.

    Returns
    -------
    list (load) of lists of str
    """
    share = statistics["relative_contact_area_pixels"].values
    # limits as those of the checks of the same names
    words = {
        "not converged": statistics["converged"].values == 0,
        "few contact points": share * points < CONTACT_POINTS,
        "full contact": share == 1,
        "coarse patches": overcount(statistics) > OVERCOUNT,
        "contact on filled points": statistics["contact_on_filled_points"].values > FILLED_IN_CONTACT[0],
        "rejected points carry load": statistics.get("rejected_load_share", 0 * share) > REJECTED_LOAD,
    }
    return [
        [word for word, applies in words.items() if applies[load]]
        + [*filter(None, [contact_checks.yielding(values_at_load(statistics, load))])]
        for load in range(share.size)
    ]


def window_checks(statistics: Statistics, window: xr.DataArray) -> list[Check]:
    """Return the checks (`surface_checks`) of a window that has the attributes of the maps it comes from.

    Parameters
    ----------
    statistics : Dataset
        as `contact_statistics` returns it.
    window : DataArray (y, x), m
        the map that was solved, with the attributes that reading, levelling and windowing left.

    Returns
    -------
    list of Check
    """
    attrs = window.attrs
    return surface_checks(statistics, height=attrs, levelled=attrs, window=attrs, points=window.size)


def add_verdicts(statistics: xr.Dataset, window: xr.DataArray) -> xr.Dataset:
    """Return the statistics with the verdict on each load and the reasons for it.

    Parameters
    ----------
    statistics : Dataset
        complete, the error budget beside the numbers.
    window : DataArray (y, x), m
        the map that was solved, with the attributes that reading, levelling and windowing left.

    Returns
    -------
    Dataset
        with the flag `verdict` (load), of contact area and pressure in contact: 0 use, 1 review, 2 do not
        use; the same for each of `ANSWERS`, `{answer}_verdict`. The attributes are JSON: `reasons` is a list
        of ``{"check": name, "loads": [index, ...], "text": sentence}``, the checks that did not pass and at
        which loads; `verdicts` is a list (load) of [word of `VERDICTS`, [reason, ...]], a reason for each
        check that did not pass.
    """
    # each load by itself for its verdict, all together for the sentences
    loads = range(statistics.sizes["load"])
    by_load = [window_checks(SelectedLoads(statistics, [load]), window) for load in loads]
    together = window_checks(SelectedLoads(statistics, [*loads]), window)
    grades = list(outcome.VERDICTS)
    words = [outcome.VERDICTS[outcome.worst_result(checks)] for checks in by_load]
    texts = [[outcome.reason_text(check) for check in outcome.not_passed(checks)] for checks in by_load]

    def flags(*answers: str) -> tuple[str, np.ndarray]:
        results = [outcome.worst_result(checks, *answers) for checks in by_load]
        return "load", np.array([*map(grades.index, results)], np.int8)

    of_answers = {f"{answer}_verdict": flags(answer) for answer in ANSWERS}
    result = describe(statistics.assign(of_answers | {"verdict": flags()}))
    reasons, verdicts = _reasons_with_loads(by_load, together), [*zip(words, texts, strict=True)]
    return result.assign_attrs(json_attributes({"reasons": reasons, "verdicts": verdicts}))


def _reasons_with_loads(by_load: list[list[Check]], together: list[Check]) -> list[dict[str, Any]]:
    """Return each check that did not pass, in the order of the report, with its loads and one sentence.

    The sentence is that of the check of all loads together; where that passes, that of the first load.
    """
    # by name: a load may lack the check, as that of currents in full contact
    doubts = [{check.name: check for check in outcome.not_passed(checks)} for checks in by_load]
    reasons = []
    for check in together:
        of_loads = {load: at_load[check.name] for load, at_load in enumerate(doubts) if check.name in at_load}
        if warnings := outcome.not_passed([check, *of_loads.values()]):
            reasons.append({"check": check.name, "loads": [*of_loads], "text": warnings[0].sentence})
    return reasons
