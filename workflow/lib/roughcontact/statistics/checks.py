"""What to trust: every check of a surface's result, and the words that warn of single loads.

A check passes, asks for a look (the number may be off, and the sentence says by what), or fails (do not use
the number); one that could not be made says so and never passes. The verdict on a surface, or on one load of
it, is that of its worst check. The checks stand with their limits in
`contact_checks`, `map_checks` and `instrument_checks`; who shows them finds all that is needed here.
"""

import json

import xarray as xr

from roughcontact.statistics import contact_checks, instrument_checks, map_checks
from roughcontact.statistics.contact_checks import CONTACT_POINTS, OVERCOUNT, overcount
from roughcontact.statistics.map_checks import (
    FILLED_IN_CONTACT,
    FORM,
    GRADIENT_CHANGE,
    HEIGHT_CHANGE,
    LENGTHS,
    REJECTED_LOAD,
    ROW_JITTER,
    STEEP,
    STEEP_PLACES,
    TOO_STEEP,
    WINDOW_SHARE,
    Attributes,
)
from roughcontact.statistics.outcome import (
    FAILED,
    LOOK,
    NOT_MADE,
    PASSED,
    VERDICTS,
    Check,
    reason,
    reasons,
    verdict,
)

__all__ = [
    "CONTACT_POINTS",
    "FAILED",
    "FILLED_IN_CONTACT",
    "FORM",
    "GRADIENT_CHANGE",
    "HEIGHT_CHANGE",
    "LENGTHS",
    "LOOK",
    "NOT_MADE",
    "OVERCOUNT",
    "PASSED",
    "REJECTED_LOAD",
    "ROW_JITTER",
    "STEEP",
    "STEEP_PLACES",
    "TOO_STEEP",
    "VERDICTS",
    "WINDOW_SHARE",
    "Check",
    "load_flags",
    "load_verdicts",
    "reason",
    "reasons",
    "surface_checks",
    "verdict",
    "with_verdicts",
]


def surface_checks(
    statistics: xr.Dataset, *, height: Attributes, levelled: Attributes, window: Attributes, points: int
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
    return [
        contact_checks.units(statistics),
        contact_checks.convergence(statistics),
        contact_checks.contact_points(statistics, points),
        contact_checks.resolution(statistics),
        instrument_checks.smoothed(window),
        instrument_checks.noise(statistics, window),
        instrument_checks.isolated_peak(statistics),
        map_checks.missing_points(statistics, height, levelled),
        map_checks.outliers(statistics, levelled),
        map_checks.scan_lines(levelled, statistics),
        map_checks.form(levelled, window),
        map_checks.periodicity(window),
        map_checks.window_share(window),
        map_checks.longest_wave(statistics),
        map_checks.sample(statistics),
        map_checks.band(window),
        contact_checks.plasticity(statistics),
        contact_checks.load_range(statistics),
        map_checks.slope(statistics),
        map_checks.steep_places(window),
        instrument_checks.height_unit(height, window),
        instrument_checks.pixel_size(height, window),
        map_checks.reading(height, levelled),
    ]


def load_flags(statistics: xr.Dataset, points: int) -> list[list[str]]:
    """Return for each load the words that warn of its numbers (mostly none).

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
    flags = []
    for index in range(statistics.sizes["load"]):
        load = statistics.isel(load=index)
        share = float(load["relative_contact_area_pixels"])
        words = []
        if not load["converged"]:
            words.append("not converged")
        if share * points < CONTACT_POINTS:
            words.append("few contact points")
        if share == 1:
            words.append("full contact")
        if overcount(load) > OVERCOUNT:
            words.append("coarse patches")
        if load["contact_on_filled_points"] > FILLED_IN_CONTACT[0]:
            words.append("contact on filled points")
        if load.get("rejected_load_share", 0.0) > REJECTED_LOAD:
            words.append("rejected points carry load")
        words += contact_checks.yield_flags(load)
        flags.append(words)
    return flags


def load_verdicts(statistics: xr.Dataset, window: xr.DataArray) -> list[tuple[str, list[str]]]:
    """Return for each load the verdict of all checks of the surface at this load alone, and its reasons.

    Parameters
    ----------
    statistics : Dataset
        complete, the error budget beside the numbers.
    window : DataArray (y, x), m
        the map that was solved, with the attributes that reading, levelling and windowing left.

    Returns
    -------
    list (load) of (verdict, reasons)
        a word of `VERDICTS`, and a line for each check that did not pass.
    """
    attrs, verdicts = window.attrs, []
    for index in range(statistics.sizes["load"]):
        alone = statistics.isel(load=[index])
        found = surface_checks(alone, height=attrs, levelled=attrs, window=attrs, points=window.size)
        verdicts.append((VERDICTS[verdict(found)], [reason(check) for check in reasons(found)]))
    return verdicts


def with_verdicts(statistics: xr.Dataset, window: xr.DataArray) -> xr.Dataset:
    """Return the statistics with the verdict on each load, and its reasons, in their attribute `verdicts`.

    Parameters
    ----------
    statistics, window
        as of `load_verdicts`.

    Returns
    -------
    Dataset
        its attribute is JSON: a list (load) of [verdict, [reason, ...]].
    """
    found = load_verdicts(statistics, window)
    return statistics.assign_attrs(verdicts=json.dumps(found, ensure_ascii=False))
