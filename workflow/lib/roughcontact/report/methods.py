"""The paragraph of methods for a paper: what was done to a map, and the answers, from its statistics."""

import json
import math
from collections.abc import Mapping
from typing import Any

import xarray as xr

from roughcontact.bodies import have_layers
from roughcontact.profiles.surface import is_drawn, surfaces_behind
from roughcontact.quantities import number, prefix, quantity, with_interval
from roughcontact.report.asked import bodies_in_words
from roughcontact.report.tables import is_finite_body
from roughcontact.report.units import interval_at
from roughcontact.uncertainty.measurands import measurand_in_words

_FORMS = {
    "none": "were taken as measured",
    "mean": "were taken relative to their mean",
    "plane": "were levelled by a least-squares plane",
    "polynomial": "were freed of a least-squares polynomial of order {order}",
}
_ANSWERS = {
    "relative_contact_area": ("a true contact area of", "% of the nominal area"),
    "mean_contact_pressure": ("a mean pressure in contact of", "Pa"),
    "mean_gap": ("a mean gap of", "m"),
}
_MOST_LOADS = 3  # whose answers a paragraph has: the lowest, one between, the highest


def methods_paragraph(statistics: xr.Dataset) -> str:
    """Return a paragraph of methods and answers of one surface, from its statistics.

    Examples
    --------
    >>> from roughcontact import evaluate, self_affine_surface
    >>> height = self_affine_surface(
    ...     (64, 64), (1e-6, 1e-6), hurst=0.8, rms_height=1e-7, shortest=8e-6, longest=3.2e-5
    ... )
    >>> statistics = evaluate(height, contact={"bodies": ["steel", "copper"], "mean_pressure": "20 MPa"})
    >>> methods_paragraph(statistics).split(". ")[1][:56]
    'A window of 64.0 µm × 64.0 µm was periodic as measured; '
    """
    settings, versions = (json.loads(statistics.attrs[name]) for name in ("settings", "versions"))
    commit = str(statistics.attrs.get("commit", ""))[:7]
    version = f"{versions['roughcontact']}{f' (commit {commit})' if commit else ''}"
    sentences = [
        _levelling(statistics, settings["level"]),
        _window(statistics, settings["window"], settings.get("form") or {}),
        _contact(statistics, settings["contact"]),
        *_answers(statistics, settings["uncertainty"]),
        f"All was computed with roughcontact {version}; its CITATION.cff says how to cite it.",
    ]
    return " ".join(sentences)


def _levelling(statistics: xr.Dataset, level: Mapping[str, Any]) -> str:
    """Return what was done to the heights."""
    sha256 = [f"{text[:8]}…" for text in str(statistics.attrs.get("source_sha256", "")).split(" + ") if text]
    source = f" (SHA-256 {' and '.join(sha256)})" if sha256 else ""
    text = _FORMS.get(level["form"], f"were freed of a least-squares {level['form']}").format(**level)
    steps = [f"The measured heights{source} {text}"]
    if level["outlier_threshold"]:
        threshold = number(level["outlier_threshold"], digits=2)
        steps.append(f"outliers beyond {threshold} robust standard deviations rejected")
    steps += [
        f"an {name[0].upper()}-filter of cut-off {quantity(level[name], 'm')} applied"
        for name in ("s_filter", "l_filter")
        if level[name]
    ]
    if level["fill"] != "none":
        steps.append(f"missing points filled ({level['fill']})")
    if len(sha256) > 1 and "lay" not in statistics.attrs:  # not several profiles
        steps.append("the two faces added at one of their relative positions")
    return f"{', '.join(steps)}."


def _window(statistics: xr.Dataset, window: Mapping[str, Any], form: Mapping[str, Any]) -> str:
    """Return the window that was solved, and its roughness."""
    lengths = [float(statistics[f"window_length_{axis}"]) for axis in "xy"]
    size = " × ".join(quantity(length, "m") for length in lengths if math.isfinite(length))
    noun = "window" if all(map(math.isfinite, lengths)) else "profile"
    created = statistics.attrs.get("periodisation", window["method"])
    periodisation = "was periodic as measured" if created == "none" else f"was made periodic ({created})"
    if is_drawn(statistics):
        periodisation = f"was drawn at random from {surfaces_behind(statistics)}"
    radii = " and ".join(quantity(radius, "m") for radius in form.get("radius") or ())
    body = f"a body of finite size{f' of radius {radii}' if radii else ''}"
    if form.get("edges"):
        body += " that ends with sharp edges where the map does"
    local = form.get("local_scale")
    steps = [f"A {noun} of {size} {periodisation if local or not form else f'is the roughness of {body}'}"]
    if local:
        steps.append(f"solved under Hertz's largest pressures on {body}")
    steps += [
        f"waves {side} than {quantity(window[key], 'm')} were removed"
        for side, key in (("shorter", "shortest_wavelength"), ("longer", "longest_wavelength"))
        if window[key]
    ]
    height, gradient = (float(statistics[name]) for name in ("rms_height", "rms_gradient"))
    return (
        f"{', '.join(steps)}; its rms height is {quantity(height, 'm')}, its rms gradient {number(gradient)}."
    )


def _contact(statistics: xr.Dataset, contact: Mapping[str, Any]) -> str:
    """Return the problem and how it was solved."""
    modulus = quantity(float(statistics["contact_modulus"]), "Pa")
    bodies = f" of {bodies_in_words(contact)}" if contact["bodies"] else ""
    hardness = contact["hardness"]
    limit = f", the pressure limited to the hardness of {quantity(hardness, 'Pa')}" if hardness else ""
    solids = "bodies with layers" if have_layers(contact["bodies"]) else "half-spaces"
    free = contact.get("boundary") == "free"
    load, cell = ("force", "without neighbours") if free else ("mean pressure", "of one period")
    bound = float(statistics["error_bound"].max())
    last_digit = 10.0 ** (math.floor(math.log10(bound)) - 1) if bound > 0 else 1.0
    rounded_up = number(math.ceil(bound / last_digit * (1 - 1e-9)) * last_digit, digits=2)
    return (
        f"The frictionless contact{bodies} under a prescribed {load} (E* = {modulus}{limit}) was "
        f"solved for elastic {solids} {cell} by fast Fourier transforms on the grid of the window; the "
        f"relative error of the pressures in the energy norm is proved to be at most {rounded_up}."
    )


def _answers(statistics: xr.Dataset, uncertainty: Mapping[str, Any]) -> list[str]:
    """Return the answers at a few loads, and what their intervals are for."""
    rising = statistics["mean_pressure"].argsort().values.tolist()
    selected = [rising[0], rising[len(rising) // 2], rising[-1]] if len(rising) > _MOST_LOADS else rising
    sentences, free = [], is_finite_body(statistics)
    for index in selected:
        answers = []
        for name, (text, unit) in _ANSWERS.items():
            interval = interval_at(statistics, name, index)
            factor, unit_label = (100.0, unit) if unit.startswith("%") else prefix(interval[0], unit)
            answers.append(f"{text} {with_interval(*(factor * end for end in interval))} {unit_label}")
        applied = f"mean pressure of {quantity(float(statistics['mean_pressure'][index]), 'Pa')}"
        force = quantity(float(statistics["force"][index]), "N") if "force" in statistics else ""
        if force:
            applied += f", Hertz's largest under {force},"
        if free:
            applied = f"force of {force}"
            answers[0] = answers[0].replace("nominal area", "area of the map")
        sentences.append(f"A {applied} gives {', '.join(answers[:-1])} and {answers[-1]}.")
    if "relative_contact_area_lower" in statistics:
        extent = uncertainty["extent"] if uncertainty["measurand"] == "longer" else None
        measurand = measurand_in_words(extent)
        if free:
            positions = statistics.attrs.get("window_reason")
            measurand = f"this body{', also at other positions on its roughness' if positions else ''}"
        sentences.append(f"The intervals hold 95 % and are for {measurand}.")
    return sentences
