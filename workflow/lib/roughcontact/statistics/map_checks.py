"""Checks of the map: whether the solved window stands for the surface that was measured.

`height`, `levelled` and `window` are the attributes of the map as measured, levelled and made periodic.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from roughcontact.arguments.checking import MAX_GRADIENT
from roughcontact.arguments.kinds import facts_of
from roughcontact.arguments.lays import lay_facts
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import counted_noun, number, percent, quantity
from roughcontact.statistics.outcome import Check, failed, not_made, noted, passed, review
from roughcontact.statistics.selected_loads import Statistics
from roughcontact.surface.levelling.record import rejected_by_kind

FILLED_IN_CONTACT = (0.01, 0.1)  # share of the contact on points not measured: review, fail
REJECTED_LOAD = 0.02  # share of the load that rejected points would carry if they were kept
ROW_JITTER = 0.01  # rms shift of the rows, of the rms height, from which on it moves the contact
_LAY, _ALONG = 0.3, 5.0  # texture aspect ratio of a lay; degrees off the rows
GRADIENT_CHANGE = 0.1  # relative change of the rms gradient by periodisation
HEIGHT_CHANGE = 0.5  # rms change of the heights by periodisation, of their rms
FORM = 0.8  # share of the mean square height that a second-order polynomial makes up
STEEP_PLACES = 0.5  # share of the mean square gradient that the steepest 1 % of the points make up
# Autocorrelation lengths along the shorter side of the window: the correlation of a wave falls to 0.2 within
# 0.22 of its length, so that a window of fewer holds less than one of the longest waves.
LENGTHS = 5
WINDOW_SHARE = 0.5  # share of the measured area that was used
# Ratio of the pixels of two faces: review, fail. The coarser one lacks the waves in between: with H = 0.8
# (mean square gradient ~ pixel^-0.4, area ~ 1 / gradient) two faces of the same roughness have areas 7 % too
# large with a ratio of 2, and 20 % with 10, beyond which the finer face decides alone, or a unit is wrong.
FACE_PITCHES = (2.0, 10.0)
FACE_SHARE = 0.25  # of the larger face: half of each side
STEEP = (0.3, 0.6)  # rms gradient: small-slope elasticity is an approximation, a rough one

Attributes = Mapping[str, Any]


def missing_points(statistics: Statistics, height: Attributes, attrs: Attributes) -> Check:
    """Check that hardly any contact lies on points that were not measured."""
    missing, fill = height.get("missing_share", 0.0), attrs.get("filled_share", 0.0)
    removals = attrs.get("outliers_rejected", 0)
    if not (missing or removals or fill):
        return passed("Every point was measured.")
    in_contact = float(statistics["contact_on_filled_points"].max())
    doubtful, wrong = FILLED_IN_CONTACT
    coverage = f"{percent(missing)} of the points were not" if missing else "Every point was"
    points = f"{coverage} measured; {removals} were rejected as outliers; {percent(fill)} were filled in"
    if not in_contact > doubtful:  # false also of NaN
        return passed(f"{points}, and at most {percent(in_contact)} of the contact lies on them.")
    return (failed if in_contact > wrong else review)(
        f"Up to {percent(in_contact)} of the contact lies on points that were filled in: "
        f"{points[0].lower()}{points[1:]}.",
        explanation="The contact there is that of the filling, not of the surface.",
        advice="Measure these places again.",
    )


def outliers(statistics: Statistics, attrs: Attributes) -> Check:
    """Check that hardly any load would lie on rejected points, by `rejected_load_share`.

    Examples
    --------
    >>> import xarray as xr
    >>> shares = xr.Dataset({"rejected_load_share": ("load", [0.11, 0.04])})
    >>> outliers(shares, {"outliers_rejected": 138, "outlier_kinds": '{"spike": 138}'}).outcome
    'review'
    """
    removals = attrs.get("outliers_rejected", 0)
    if not removals:
        return passed("No point was rejected.")
    they, was, noun, lie, are = "they", "were", "outliers", "they lie", "they are errors"
    if removals == 1:
        they, was, noun, lie, are = "it", "was", "an outlier", "it lies", "it is an error"
    kinds = rejected_by_kind(attrs)
    text = f"{counted_noun(removals, 'point')} {was} rejected as {noun}" + (f" ({kinds})" if kinds else "")
    shares = statistics["rejected_load_share"].values if "rejected_load_share" in statistics else np.nan
    if np.isnan(shares).all():  # levelled without keeping the rejected heights
        return review(f"{text}. The load that {they} would carry if {they} were kept is not known.")
    share = float(np.nanmax(shares))  # of the load with the largest share
    text += f"; if {they} were kept, {they} would carry {percent(share)} of the load"
    text += " at most" if statistics.sizes["load"] > 1 else ""
    if share <= REJECTED_LOAD:
        return passed(f"{text}.")
    return review(
        f"{text}: the result depends on whether {are} of the measurement.",
        advice=f"See where {lie}, or keep every point (level.outlier_threshold: none).",
    )


def scan_lines(attrs: Attributes, statistics: Statistics | None = None) -> Check:
    """Check that rows are not shifted against one another, which a lay along them hides, or were aligned."""
    jitter, evidence = percent(attrs.get("row_jitter", 0.0)), attrs.get("row_jitter_evidence", "none")
    alignment = attrs.get("line_alignment", "none")
    if evidence == "none":
        finding = "No random shift of the rows against one another was found."
        if statistics is not None and _lay_along_rows(statistics):
            finding += (
                " The lay runs along the rows: beside grooves a few rows wide small shifts would not show."
            )
        return passed(finding)
    text = f"The rows are shifted against one another, by {jitter} of the rms height (rms)"
    if evidence == "doubtful":
        text = f"The rows share shifts of {jitter} of the rms height (rms)"
        text += ", which may be drift of the scanner or a lay along the rows"
    is_aligned, by_user = alignment != "none", attrs.get("line_alignment_by") == "user"
    if is_aligned:
        text += f"; they were aligned {'as asked ' if by_user else ''}({alignment})"
    # what the user asked for is no finding
    if (is_aligned and by_user) or attrs.get("row_jitter", 0.0) <= ROW_JITTER:
        return passed(f"{text}.")
    if not is_aligned:
        return review(
            f"{text}: it may carry much of the load.",
            advice="Compare with every row aligned (level.line_alignment: jitter).",
        )
    return review(f"{text}.", advice="Compare without that (level.line_alignment: none).")


def _lay_along_rows(statistics: Statistics) -> bool:
    """Return whether the strongest waves run from row to row, and the map has a lay."""
    isotropy, direction = (float(statistics.get(name, np.nan)) for name in ("Str", "Std"))
    # Std of 90 degrees: strongest waves along y, ridges along x
    return isotropy <= _LAY and abs(direction - 90) <= _ALONG


def form(attrs: Attributes, window: Attributes) -> Check | None:
    """Check that no bow decides where the surfaces touch; of a body of finite size, that none counts twice.

    Examples
    --------
    >>> form({"form": "plane"}, {"form_share": 0.9}).outcome
    'review'
    """
    share, kind = window.get("form_share", 0.0), facts_of(window)
    is_added = kind.adds_form(window)
    if kind.form_is_meant and not is_added:
        return None
    text = f"A bow (second-order polynomial) makes up {percent(share)} of the mean square height"
    text += " of the window"
    if share <= FORM:
        return passed(f"{text}.")
    if is_added:
        return review(
            f"{text}, and the radius of the form adds another: what is in the map already counts twice.",
            advice="Leave the radius out (form.radius), or subtract the form (level.form: polynomial).",
        )
    remedy = "Remove it (level.form: polynomial), unless it belongs to the contact."
    if attrs.get("form") in ("polynomial", "sphere", "cylinder"):
        remedy = "Compare another way to make it periodic (window.method): it came with this one."
    return review(f"{text}: form, not roughness, decides where the surfaces touch.", advice=remedy)


def periodicity(window: Attributes) -> Check:
    """Check that making the window periodic changed neither heights nor gradient by much.

    Examples
    --------
    >>> periodicity({"periodisation": "none"}).sentence
    'The window was periodic already: nothing was changed.'
    """
    method = window.get("periodisation", "none")
    if method == "none":
        return passed("The window was periodic already: nothing was changed.")
    gradient_before, gradient_after = window["rms_gradient_before"], window["rms_gradient_after"]
    # a correction, and waves removed afterwards, on request, are not due to periodisation
    removed_gradient = window.get("band_removed_rms_gradient", 0.0)
    gradient_after = float(window.get("rms_gradient_uncorrected", np.hypot(gradient_after, removed_gradient)))
    change = gradient_after / gradient_before - 1 if gradient_before > 0 else 0.0
    relative = window.get("periodisation_relative_change", 0.0)
    text = f"Making the window periodic ({method}) changed the heights by {percent(relative)} of their rms"
    text += f" and the rms gradient by {percent(change)}."
    effects = []
    if abs(change) > GRADIENT_CHANGE:
        effects.append("Peak pressures follow the gradient.")
    if relative > HEIGHT_CHANGE:
        effects.append("Opposite edges do not match, and joining them moved the contact.")
    if not effects:
        return passed(text)
    return review(
        text, explanation=" ".join(effects), advice="Compare another way to make it periodic (window.method)."
    )


def window_share(window: Attributes) -> Check:
    """Check that the window covers most of the measured map.

    Examples
    --------
    >>> window_share({"window_share": 0.81}).sentence
    'The solved window covers 81.0 % of the measured map.'
    """
    share = window.get("window_share", 1.0)
    text = f"The solved window covers {percent(share)} of the measured map."
    if not share < WINDOW_SHARE:  # false also of NaN
        return passed(text)
    return review(text, explanation="The rest was cropped away.", advice="See the frame on the levelled map.")


def faces(attrs: Attributes, window: Attributes) -> Check | None:
    """Check that two faces have about the same pixels and sizes; none for a single face.

    Examples
    --------
    >>> faces({}, {}) is None
    True
    >>> pair = {"face_pitches": [1e-6, 3e-6], "covered_share_of_larger": 0.8}
    >>> [faces(pair, {"band_shortest": limit}).outcome for limit in (2e-6, 6e-6)]
    ['review', 'passed']
    """
    if "face_pitches" not in attrs:
        return None
    pitches, share = attrs["face_pitches"], float(attrs["covered_share_of_larger"])
    ratio, limit = max(pitches) / min(pitches), 2 * max(pitches)
    pixels = "The faces have pixels of " + " and ".join(quantity(float(pitch), "m") for pitch in pitches)
    # waves shorter than the coarser face resolves are not solved: nothing is missing
    if ratio > FACE_PITCHES[0] and window.get("band_shortest", 0.0) < limit * (1 - 1e-6):
        # half of the mean square gradient is that of the coarser face
        too_large = percent(float(np.sqrt(2 / (1 + ratio**-0.4))) - 1)
        return (failed if ratio > FACE_PITCHES[1] else review)(
            f"{pixels}: the coarser one has no wave shorter than {quantity(limit, 'm')}, so that areas are "
            f"{too_large} or more too large if both are equally rough.",
            advice="Check the unit of dx and dy, measure both alike, or solve the waves of both "
            f"(window.shortest_wavelength: {quantity(limit, 'm')}).",
        )
    if share < FACE_SHARE:
        return review(
            f"Only {percent(share)} of the larger face is solved, as far as the smaller one reaches: longer "
            "waves, which make gaps larger, are missing.",
            advice="Check the unit of dx and dy, or measure more of it.",
        )
    return passed(f"{pixels}, and {percent(share)} of the larger one is solved.")


def longest_wave(statistics: Statistics) -> Check:
    """Check that the window holds the longest waves of the surface."""
    length = float(statistics["Sal"])
    if np.isnan(length):
        return passed("The map is flat: there is no wave.")
    # a profile has a length alone
    side = float(np.nanmin([float(statistics[f"window_length_{axis}"]) for axis in "xy"]))
    text = f"The window is {number(side / length, digits=2)} autocorrelation lengths (Sal) long"
    if not side < LENGTHS * length:
        return passed(f"{text}: it holds the longest waves.")
    return review(
        f"{text}: it is shorter than the longest waves of the surface, and another window would give other "
        "numbers.",
        advice="Measure a larger field, or remove long waves (level.l_filter).",
    )


def sample(statistics: Statistics) -> Check:
    """Check by `window_flag` of `with_uncertainty` that the map shows how far results hold beyond it.

    Examples
    --------
    >>> import xarray as xr
    >>> sample(xr.Dataset(attrs={"window_flag": "The map is too small."})).outcome
    'review'
    """
    if "window_flag" not in statistics.attrs:
        return not_made("the surface beyond the map is not in the error budget (uncertainty.sources).")
    if flag := statistics.attrs["window_flag"]:
        advice = statistics.attrs.get("window_advice", "")
        return review(flag.removesuffix(advice).rstrip(), advice=advice)
    return passed("The map gives no sign that the surface beyond it differs: see the sources of the ±.")


def lay(statistics: Statistics, window: Attributes) -> Check | None:
    """Check that it is stated of a profile whether it is one of ridges or of an isotropic surface."""
    if warnings := json_attribute(window, "profile_warnings"):
        return review(" ".join(warnings))
    if finding := lay_facts(window).finding:
        return passed(finding.format(stretch=number(window.get("stretch", 1.0))))
    # a map has both lengths, and needs no statement
    if not np.isnan([statistics[f"window_length_{axis}"] for axis in "xy"]).any():
        return None
    areas = ""
    if "relative_contact_area_if_isotropic" in statistics:
        ridges = ", ".join(map(percent, statistics["relative_contact_area"].values))
        isotropic = ", ".join(map(percent, statistics["relative_contact_area_if_isotropic"].values))
        areas = f"Contact area of endless ridges, as shown: {ridges}; of an isotropic surface: {isotropic}."
    return review(
        "Nothing states the lay of the profile.",
        explanation=areas,
        advice="State lay = across (turned, ground: ridges) or lay = none (blasted, etched, lapped: "
        "isotropic).",
    )


def band(window: Attributes) -> Check:
    """Check that no wave is solved that the instrument is known not to resolve.

    Examples
    --------
    >>> lens = {"reliable_wavelength": 5e-6, "reliable_reason": "the lens", "band_shortest": 2e-6}
    >>> band(lens).outcome
    'review'
    """
    shortest, reliable = (window.get(name, 0.0) for name in ("band_shortest", "reliable_wavelength"))
    reason = window.get("reliable_reason", "two pixels")
    if reason == "two pixels":
        return not_made("the file does not say which waves the instrument resolves (its numerical aperture).")
    if shortest >= reliable * (1 - 1e-6):
        return passed("No wave is solved that the instrument is known not to resolve.")
    return review(
        f"Waves down to {quantity(shortest, 'm')} are solved; {reason} resolves {quantity(reliable, 'm')}.",
        explanation="Shorter waves are partly noise, and peaks are partly smoothed.",
        advice="Compare without the doubtful waves (window.reliable_band).",
    )


def slope(statistics: Statistics) -> Check:
    """Check that the slopes are small, as the half-space theory assumes.

    Examples
    --------
    >>> import xarray as xr
    >>> slope(xr.Dataset({"rms_gradient": 0.12})).sentence
    'The rms gradient is 0.120: small, as the half-space theory assumes.'
    """
    gradient = float(statistics["rms_gradient"])
    text = f"The rms gradient is {number(gradient)}"
    approximate, rough = STEEP
    if gradient > MAX_GRADIENT:
        return failed(
            f"{text}: no rough surface is so steep.", advice="Check the units of heights and steps."
        )
    if gradient > approximate:
        return (review if gradient > rough else noted)(
            f"{text}: steep for a theory of small slopes, an error of the model that the ± leaves out.",
            advice="Treat the numbers as estimates.",
        )
    return passed(f"{text}: small, as the half-space theory assumes.")


def steep_places(window: Attributes) -> Check:
    """Check that a few steep places do not make up the rms gradient.

    Examples
    --------
    >>> steep_places({"steepest_share": 0.08}).sentence
    'The steepest 1 % of the points make up 8.00 % of the mean square gradient.'
    """
    share = window.get("steepest_share", 0.0)
    text = f"The steepest 1 % of the points make up {percent(share)} of the mean square gradient"
    if share <= STEEP_PLACES:
        return passed(f"{text}.")
    spikes = "Remove spikes by a lower threshold (level.outlier_threshold)."
    if threshold := window.get("outlier_threshold"):
        spikes = f"Spikes beyond {number(threshold, digits=2)} standard deviations are removed already."
    return noted(
        f"{text}: steps, defects or dust.",
        explanation="A load relative to the gradient is high for the rest of the surface.",
        advice=f"Give loads as mean_pressure. {spikes}",
    )


def reading(height: Attributes, attrs: Attributes) -> Check:
    """Check that the file was read without a warning; what the user asked for is a note."""
    if not (warnings := json_attribute(height, "ingest_warnings")):
        return passed("Read without a warning.")
    # the same sentences, with what levelling did about them: the check of the outliers judges them
    spikes = json_attribute(height, "ingest_spikes") if attrs.get("outlier_threshold") else {}
    findings = dict(zip(warnings, warnings, strict=True)) | spikes
    if spikes:
        success = "and removed" if attrs.get("outliers_rejected") else "in vain: none was removed"
        findings[[*spikes][-1]] += f"; isolated ones were searched for {success}"
    files = tuple(f"{name}: " for name in height.get("source_file", "").split(" + "))  # not capitalised
    text = " ".join(
        f"{finding[0] if finding.startswith(files) else finding[0].upper()}{finding[1:].rstrip('.')}."
        for finding in findings.values()
    )
    facts = {*json_attribute(height, "ingest_facts"), *spikes}
    return (noted if facts.issuperset(warnings) else review)(text)
