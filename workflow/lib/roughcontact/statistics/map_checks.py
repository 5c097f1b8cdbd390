"""Checks of the map: whether the solved window stands for the surface that was measured.

`height`, `levelled` and `window` are the attributes of the map as measured, levelled and made periodic.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from roughcontact.arguments.checking import MAX_GRADIENT
from roughcontact.arguments.choices import PERIODIC_BY
from roughcontact.arguments.kinds import facts_of
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.profiles.lays import lay_facts
from roughcontact.arguments.quantities import counted_noun, number, percent, quantity
from roughcontact.statistics.outcome import Check, judge
from roughcontact.statistics.selected_loads import Statistics, largest_of_loads
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
    in_contact = largest_of_loads(statistics["contact_on_filled_points"])
    doubtful, wrong = FILLED_IN_CONTACT
    cases = {
        "all measured": not (missing or removals or fill),
        "many": in_contact > wrong,
        "some": in_contact > doubtful,
        "few of all measured": not missing,
    }
    facts = {"missing": missing, "removals": removals, "fill": fill, "in_contact": in_contact}
    measured = f"{percent(missing)} of the points were not" if missing else "every point was"
    return judge("Missing points", cases, measured=measured, **facts)


def outliers(statistics: Statistics, attrs: Attributes) -> Check:
    """Check that hardly any load would lie on rejected points, by `rejected_load_share`.

    Examples
    --------
    >>> import xarray as xr
    >>> shares = xr.Dataset({"rejected_load_share": ("load", [0.11, 0.04])})
    >>> outliers(shares, {"outliers_rejected": 138, "outlier_kinds": '{"spike": 138}'}).outcome
    'review'
    """
    removals, kinds = attrs.get("outliers_rejected", 0), rejected_by_kind(attrs)
    # levelled without keeping the rejected heights it is not known
    share = largest_of_loads(statistics.get("rejected_load_share", np.nan))
    cases = {"none": not removals, "unknown": np.isnan(share), "carry": share > REJECTED_LOAD}
    at_most = " at most" if statistics.sizes["load"] > 1 else ""
    facts = {"points": counted_noun(removals, "point"), "kinds": f" ({kinds})" if kinds else ""}
    return judge("Outliers", cases, **facts, share=share, at_most=at_most)


def scan_lines(attrs: Attributes, statistics: Statistics | None = None) -> Check:
    """Check that rows are not shifted against one another, which a lay along them hides, or were aligned."""
    jitter, evidence = attrs.get("row_jitter", 0.0), attrs.get("row_jitter_evidence", "none")
    alignment, by_user = attrs.get("line_alignment", "none"), attrs.get("line_alignment_by") == "user"
    is_found, is_aligned, is_small = evidence != "none", alignment != "none", jitter <= ROW_JITTER
    shift = f"are shifted against one another, by {percent(jitter)} of the rms height (rms)"
    if evidence == "doubtful":
        shift = f"share shifts of {percent(jitter)} of the rms height (rms)"
        shift += ", which may be drift of the scanner or a lay along the rows"
    cases = {
        "none, lay along rows": not is_found and statistics is not None and _lay_along_rows(statistics),
        "none": not is_found,
        # what the user asked for is no finding
        "aligned as asked": is_aligned and by_user,
        "small, aligned": is_small and is_aligned,
        "small": is_small,
        "aligned": is_aligned,
    }
    return judge("Scan lines", cases, shift=shift, alignment=alignment)


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
    is_fitted = attrs.get("form") in ("polynomial", "sphere", "cylinder")
    cases = {"small": share <= FORM, "counted twice": is_added, "came back": is_fitted}
    return judge("Form", cases, share=share)


def periodicity(window: Attributes) -> Check:
    """Check that making the window periodic changed neither heights nor gradient by much.

    Examples
    --------
    >>> periodicity({"periodisation": "none"}).sentence
    'The window was periodic already: nothing was changed.'
    """
    gradient_before = window.get("rms_gradient_before", 0.0)
    gradient_after = window.get("rms_gradient_after", 0.0)
    # a correction, and waves removed afterwards, on request, are not due to periodisation
    removed_gradient = window.get("band_removed_rms_gradient", 0.0)
    gradient_after = float(window.get("rms_gradient_uncorrected", np.hypot(gradient_after, removed_gradient)))
    change = gradient_after / gradient_before - 1 if gradient_before > 0 else 0.0
    relative = window.get("periodisation_relative_change", 0.0)
    method = window.get("periodisation", "none")
    steeper, moved = abs(change) > GRADIENT_CHANGE, relative > HEIGHT_CHANGE
    cases = {"periodic": method == "none", "both": steeper and moved, "gradient": steeper, "heights": moved}
    return judge(
        "Periodic window", cases, method=PERIODIC_BY.get(method, method), relative=relative, change=change
    )


def window_share(window: Attributes) -> Check:
    """Check that the window covers most of the measured map.

    Examples
    --------
    >>> window_share({"window_share": 0.81}).sentence
    'The solved window covers 81.0 % of the measured map.'
    """
    share = window.get("window_share", 1.0)
    return judge("Window", {"cropped": share < WINDOW_SHARE}, share=share)


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
    # waves shorter than the coarser face resolves are not solved: nothing is missing
    are_missing = window.get("band_shortest", 0.0) < limit * (1 - 1e-6)
    too_coarse, far_too_coarse = (ratio > limit_of_ratio and are_missing for limit_of_ratio in FACE_PITCHES)
    # half of the mean square gradient is that of the coarser face
    too_large = np.sqrt(2 / (1 + ratio**-0.4)) - 1
    pixels = " and ".join(quantity(float(pitch), "m") for pitch in pitches)
    cases = {"far too coarse": far_too_coarse, "too coarse": too_coarse, "too small": share < FACE_SHARE}
    return judge("Faces", cases, pixels=pixels, limit=limit, too_large=too_large, share=share)


def longest_wave(statistics: Statistics) -> Check:
    """Check that the window holds the longest waves of the surface."""
    length = float(statistics["Sal"])
    # a profile has a length alone
    side = float(np.nanmin([float(statistics[f"window_length_{axis}"]) for axis in "xy"]))
    cases = {"flat": np.isnan(length), "short": side < LENGTHS * length}
    return judge("Longest wave", cases, lengths=side / length)


def sample(statistics: Statistics) -> Check:
    """Check by `window_flag` of `with_uncertainty` that the map shows how far results hold beyond it.

    Examples
    --------
    >>> import xarray as xr
    >>> sample(xr.Dataset(attrs={"window_flag": "The map is too small."})).outcome
    'review'
    """
    flag, advice = (statistics.attrs.get(f"window_{name}") for name in ("flag", "advice"))
    cases = {"not in the budget": flag is None, "flagged": flag}
    finding = (flag or "").removesuffix(advice or "").rstrip()
    return judge("Sample", cases, finding=finding, advice=advice or "")


def lay(statistics: Statistics, window: Attributes) -> Check | None:
    """Check that it is stated of a profile whether it is one of ridges or of an isotropic surface."""
    warnings, statement = json_attribute(window, "profile_warnings"), lay_facts(window).finding
    # a map has both lengths, and needs no statement
    is_stated = bool(warnings or statement)
    if not is_stated and not np.isnan([statistics[f"window_length_{axis}"] for axis in "xy"]).any():
        return None
    has_both = not is_stated and "relative_contact_area_if_isotropic" in statistics
    names = ("relative_contact_area", "relative_contact_area_if_isotropic") if has_both else ()
    areas = [", ".join(map(percent, statistics[name].values)) for name in names]
    return judge(
        "Lay",
        {"warnings": warnings, "statement": statement, "both areas": has_both},
        warnings=" ".join(warnings),
        statement=statement.format(stretch=number(window.get("stretch", 1.0))),
        areas=areas,
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
    cases = {"unknown": reason == "two pixels", "reliable": shortest >= reliable * (1 - 1e-6)}
    return judge("Band", cases, shortest=shortest, reason=reason, reliable=reliable)


def slope(statistics: Statistics) -> Check:
    """Check that the slopes are small, as the half-space theory assumes.

    Examples
    --------
    >>> import xarray as xr
    >>> slope(xr.Dataset({"rms_gradient": 0.12})).sentence
    'The rms gradient is 0.120: small, as the half-space theory assumes.'
    """
    gradient, (approximate, rough) = float(statistics["rms_gradient"]), STEEP
    cases = {
        "impossible": gradient > MAX_GRADIENT,
        "rough": gradient > rough,
        "approximate": gradient > approximate,
    }
    return judge("Slopes", cases, gradient=gradient)


def steep_places(window: Attributes) -> Check:
    """Check that a few steep places do not make up the rms gradient.

    Examples
    --------
    >>> steep_places({"steepest_share": 0.08}).sentence
    'The steepest 1 % of the points make up 8.00 % of the mean square gradient.'
    """
    share, threshold = window.get("steepest_share", 0.0), window.get("outlier_threshold")
    cases = {"few": share <= STEEP_PLACES, "without spikes": threshold}
    return judge("Steep places", cases, share=share, threshold=threshold)


def reading(height: Attributes, attrs: Attributes) -> Check:
    """Check that the file was read without a warning; what the user asked for is a note."""
    warnings = json_attribute(height, "ingest_warnings")
    # the same sentences, with what levelling did about them: the check of the outliers judges them
    spikes = json_attribute(height, "ingest_spikes") if warnings and attrs.get("outlier_threshold") else {}
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
    cases = {"nothing": not warnings, "facts": facts.issuperset(warnings)}
    return judge("Reading the file", cases, text=text)
