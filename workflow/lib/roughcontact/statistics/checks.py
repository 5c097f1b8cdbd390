"""What to trust: each check of a surface's result, with its outcome in words.

A check passes, asks for a look (the number may be off, and the sentence says by what), or fails (do not use
the number). The verdict on a surface is that of its worst check.
"""

import json
from typing import NamedTuple

import numpy as np
import xarray as xr

from roughcontact.quantities import number, percent, quantity

PASSED, LOOK, FAILED = "passed", "look", "failed"
VERDICTS = {PASSED: "trust", LOOK: "look at", FAILED: "do not trust"}

CONTACT_POINTS = 100  # fewer: the contact is a handful of pixels
OVERCOUNT = 0.2  # excess of the counted over the corrected area: patches are a few pixels across
FILLED_IN_CONTACT = (0.01, 0.1)  # share of the contact on points that were not measured: look, fail
GRADIENT_CHANGE = 0.1  # relative change of the rms gradient by periodisation
HEIGHT_CHANGE = 0.5  # rms change of the heights by periodisation, of their rms
FORM = 0.8  # share of the mean square height that a second-order polynomial makes up
STEEP_PLACES = 0.5  # share of the mean square gradient that the steepest 1 % of the points make up
# Autocorrelation lengths along the shorter side of the window: the correlation of a wave falls to 0.2 within
# 0.22 of its length, so that a window of fewer holds less than one of the longest waves.
LENGTHS = 5
WINDOW_SHARE = 0.5  # share of the measured area that was used
STEEP = 0.3  # rms gradient from which small-slope elasticity is a rough approximation
TOO_STEEP = 3.0  # rms gradient that no rough surface has: a unit is wrong
HARDEST = 0.1  # hardness over contact modulus that no material exceeds (diamond comes near)


class Check(NamedTuple):
    """One check: its name, its outcome (passed, look, failed), and a sentence with the numbers."""

    name: str
    outcome: str
    sentence: str


def surface_checks(statistics: xr.Dataset, *, height: dict, levelled: dict, window: dict, points: int):
    """Return the list of checks of one surface under one case.

    Parameters
    ----------
    statistics : Dataset
        As `contact_statistics` returns it.
    height, levelled, window : dict
        Attributes of the map as measured, levelled, and made periodic.
    points : int
        Number of points of the window.
    """
    return [
        _convergence(statistics),
        _contact_points(statistics, points),
        _resolution(statistics),
        _missing(statistics, height, levelled),
        _form(levelled, window),
        _periodicity(window),
        _window(window),
        _longest_wave(statistics),
        _band(window),
        _plasticity(statistics),
        _load_range(statistics),
        _slope(statistics),
        _steep_places(window),
        _reading(height),
    ]


def verdict(checks) -> str:
    """Return the worst outcome among the checks."""
    outcomes = {check.outcome for check in checks}
    return next(outcome for outcome in (FAILED, LOOK, PASSED) if outcome in outcomes)


def load_flags(statistics: xr.Dataset, points: int) -> list[list[str]]:
    """Return for each load the words that warn of its numbers (mostly none)."""
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
        if _overcount(load) > OVERCOUNT:
            words.append("coarse patches")
        if load["contact_on_filled_points"] > FILLED_IN_CONTACT[0]:
            words.append("contact on filled points")
        if load["mean_contact_pressure"] > HARDEST * load["contact_modulus"]:
            words.append("beyond hardness")
        flags.append(words)
    return flags


def _convergence(statistics):
    failed, loads = int((statistics["converged"] == 0).sum()), statistics.sizes["load"]
    bound = number(float(statistics["error_bound"].max()), digits=2)
    tolerance = number(float(statistics.attrs["tolerance"]), digits=1)
    if failed:
        text = (
            f"{failed} of {loads} loads missed the tolerance of {tolerance}; the error bound reaches {bound}."
        )
        return Check("Solver", FAILED, text)
    return Check(
        "Solver", PASSED, f"All loads converged: error bound at most {bound}, tolerance {tolerance}."
    )


def _contact_points(statistics, points):
    counts = np.rint(statistics["relative_contact_area_pixels"].values * points).astype(int)
    few = int((counts < CONTACT_POINTS).sum())
    if few:
        text = (
            f"{few} of {counts.size} loads have fewer than {CONTACT_POINTS} points in contact (down to "
            f"{counts.min()}): their areas and pressures are coarse. Use higher loads or a finer map."
        )
        return Check("Points in contact", LOOK, text)
    return Check("Points in contact", PASSED, f"At least {counts.min()} points in contact at every load.")


def _overcount(statistics):
    """Return by which share the counted pixels exceed the corrected area; infinite where none is left."""
    counted, corrected = (statistics[f"relative_contact_area{kind}"] for kind in ("_pixels", ""))
    return (counted / corrected.where(corrected > 0) - 1).fillna(np.inf)


def _resolution(statistics):
    resolution = float(statistics["points_per_shortest_wavelength"][0])
    if np.isnan(resolution):
        return Check("Resolution", PASSED, "The map is flat: there is no wave to resolve.")
    over = _overcount(statistics).values
    coarse = int((over > OVERCOUNT).sum())
    waves = f"The shortest wave of the map has {number(resolution, digits=2)} points"
    if coarse:
        text = (
            f"At {coarse} of {over.size} loads the contact patches are only a few points across: counting "
            f"points overstates the area by up to {percent(over.max())}, and the correction is coarse. "
            f"{waves}."
        )
        return Check("Resolution", LOOK, text)
    text = (
        f"Counting points overstates the area by at most {percent(over.max())}; this is corrected. {waves}."
    )
    return Check("Resolution", PASSED, text)


def _missing(statistics, height, levelled):
    missing, rejected = height.get("missing_share", 0.0), levelled.get("outliers_rejected", 0)
    filled = levelled.get("filled_share", 0.0)
    in_contact = float(statistics["contact_on_filled_points"].max())
    look, fail = FILLED_IN_CONTACT
    outcome = FAILED if in_contact > fail else LOOK if in_contact > look else PASSED
    if not (missing or rejected or filled):
        return Check("Missing points", PASSED, "Every point was measured.")
    measured = (
        f"{percent(missing)} of the points were not measured" if missing else "Every point was measured"
    )
    text = (
        f"{measured}; {rejected} were rejected as outliers; {percent(filled)} were filled in, and at most "
        f"{percent(in_contact)} of the contact lies on them."
    )
    if outcome != PASSED:
        text += " The contact there is that of the filling, not of the surface."
    return Check("Missing points", outcome, text)


def _form(levelled, window):
    share = window.get("form_share", 0.0)
    text = (
        f"A bow (second-order polynomial) makes up {percent(share)} of the mean square height of the window"
    )
    if share <= FORM:
        return Check("Form", PASSED, f"{text}.")
    if levelled.get("form") in ("polynomial", "sphere", "cylinder"):
        way_out = "It came with the periodic window: compare another window.method."
    else:
        way_out = "Take it off with level.form: polynomial, unless it belongs to the contact."
    return Check("Form", LOOK, f"{text}: form, not roughness, decides where the surfaces touch. {way_out}")


def _periodicity(window):
    method = window.get("periodisation", "none")
    if method == "none":
        return Check("Periodic window", PASSED, "The window was periodic already: nothing was changed.")
    before, after = window["rms_gradient_before"], window["rms_gradient_after"]
    # waves that were taken out afterwards, on request, are no fault of periodisation
    after = float(np.hypot(after, window.get("band_removed_rms_gradient", 0.0)))
    change = after / before - 1 if before > 0 else 0.0
    relative = window.get("periodisation_relative_change", 0.0)
    text = (
        f"Making the window periodic ({method}) changed the heights by {percent(relative)} of their rms and "
        f"the rms gradient by {percent(change)}."
    )
    if abs(change) > GRADIENT_CHANGE:
        text += " Peak pressures follow the gradient."
    if relative > HEIGHT_CHANGE:
        text += " Opposite edges do not fit together, and closing them moved the contact."
    if abs(change) > GRADIENT_CHANGE or relative > HEIGHT_CHANGE:
        return Check("Periodic window", LOOK, f"{text} Compare another window.method.")
    return Check("Periodic window", PASSED, text)


def _window(window):
    share = window.get("window_share", 1.0)
    text = f"The solved window covers {percent(share)} of the measured map."
    if share < WINDOW_SHARE:
        text += " The rest was cropped away: see the frame on the levelled map."
        return Check("Window", LOOK, text)
    return Check("Window", PASSED, text)


def _longest_wave(statistics):
    length = float(statistics["Sal"])
    sides = [float(statistics[f"window_length_{axis}"]) for axis in "xy"]
    # a profile is as wide as a pixel, and has no aspect ratio
    side = max(sides) if np.isnan(statistics["Str"]) else min(sides)
    if np.isnan(length):
        return Check("Longest wave", PASSED, "The map is flat: there is no wave to be too long.")
    text = f"The window is {number(side / length, digits=2)} autocorrelation lengths (Sal) long"
    if side < LENGTHS * length:
        text += (
            ": it is shorter than the longest waves of the surface, which another window would show "
            "otherwise. Measure a larger field, or take long waves off (level.l_filter)."
        )
        return Check("Longest wave", LOOK, text)
    return Check("Longest wave", PASSED, f"{text}: it holds the longest waves.")


def _band(window):
    shortest, reliable = (window.get(name, 0.0) for name in ("band_shortest", "reliable_wavelength"))
    reason = window.get("reliable_reason", "two pixels")
    if reason == "two pixels" or shortest >= reliable * (1 - 1e-6):
        return Check("Band", PASSED, "No wave is solved that the instrument is known not to resolve.")
    text = (
        f"Waves down to {quantity(shortest, 'm')} are solved; {reason} resolves {quantity(reliable, 'm')}. "
        "What is shorter is partly noise, and peaks are partly rounded off: compare window.reliable_band."
    )
    return Check("Band", LOOK, text)


def _plasticity(statistics):
    share = statistics["yielded_area"].values if "yielded_area" in statistics else np.zeros(1)
    loads = int((share > 0).sum())
    if not loads:
        return Check("Plasticity", PASSED, "No pressure reached a hardness; without one, none was asked for.")
    hardness = float(statistics["max_pressure"].max())
    index = float(statistics["contact_modulus"]) * float(statistics["rms_gradient"]) / hardness
    text = (
        f"At {loads} of {share.size} loads up to {percent(share.max())} of the area carries the hardness of "
        f"{quantity(hardness, 'Pa')}: the surface is flattened there. Plasticity index E* g / H = "
        f"{number(index, digits=2)} (mostly elastic below 0.3, mostly plastic above 3)."
    )
    return Check("Plasticity", LOOK, text)


def _load_range(statistics):
    full = int((statistics["relative_contact_area_pixels"] == 1).sum())
    loads = statistics.sizes["load"]
    if full == loads:
        return Check(
            "Load range", LOOK, "Full contact at every load: lower ones would show how it comes about."
        )
    low, high = (float(f(statistics["relative_contact_area"])) for f in (np.min, np.max))
    text = f"The contact covers {percent(low)} to {percent(high)} of the area."
    return Check("Load range", PASSED, text)


def _slope(statistics):
    gradient = float(statistics["rms_gradient"])
    text = f"The rms gradient is {number(gradient)}"
    if gradient > TOO_STEEP:
        text += ": no rough surface is so steep. Check the units of heights and steps."
        return Check("Slopes", FAILED, text)
    if gradient > STEEP:
        text += ": steep for a theory of small slopes. Treat the numbers as estimates."
        return Check("Slopes", LOOK, text)
    return Check("Slopes", PASSED, f"{text}: small, as the half-space theory assumes.")


def _steep_places(window):
    share = window.get("steepest_share", 0.0)
    text = f"The steepest 1 % of the points make up {percent(share)} of the mean square gradient"
    if share <= STEEP_PLACES:
        return Check("Steep places", PASSED, f"{text}.")
    text += (
        ": steps, defects, dust or spikes. A load relative to the gradient is high for the rest of the "
        "surface. Give loads as mean_pressure, and compare level.outlier_threshold."
    )
    return Check("Steep places", LOOK, text)


def _reading(height):
    warnings = json.loads(height.get("ingest_warnings", "[]"))
    if warnings:
        sentences = (f"{warning[0].upper()}{warning[1:].rstrip('.')}." for warning in warnings)
        return Check("Reading the file", LOOK, " ".join(sentences))
    return Check("Reading the file", PASSED, "Read without a warning.")
