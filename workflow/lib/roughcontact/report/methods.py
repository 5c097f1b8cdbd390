"""The paragraph of methods for a paper: what was done to a map, and the answers, from its statistics."""

import json
import math
from typing import Any

import xarray as xr

from roughcontact.bodies import have_layers
from roughcontact.profiles.surface import is_drawn, surfaces_behind
from roughcontact.quantities import prefix, with_interval
from roughcontact.report.asked import bodies_in_words
from roughcontact.report.tables import is_finite_body
from roughcontact.report.template import paragraph, template
from roughcontact.report.units import interval_at
from roughcontact.uncertainty.measurands import measurand_in_words

_ANSWERS = {"relative_contact_area": "%", "mean_contact_pressure": "Pa", "mean_gap": "m"}  # in these units
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
    attrs, contact = statistics.attrs, settings["contact"]
    lengths = [float(statistics[f"window_length_{axis}"]) for axis in "xy"]
    rising = statistics["mean_pressure"].argsort().values.tolist()
    selected = [rising[0], rising[len(rising) // 2], rising[-1]] if len(rising) > _MOST_LOADS else rising
    text = template("methods.txt").render(
        {name: settings[name] for name in ("level", "window", "contact")},
        attrs=attrs,
        form=settings.get("form") or {},
        sha256=[f"{text[:8]}…" for text in str(attrs.get("source_sha256", "")).split(" + ") if text],
        sides=[length for length in lengths if math.isfinite(length)],
        periodisation=attrs.get("periodisation", settings["window"]["method"]),
        drawn_from=surfaces_behind(statistics) if is_drawn(statistics) else "",
        **{name: float(statistics[name]) for name in ("rms_height", "rms_gradient", "contact_modulus")},
        bodies=bodies_in_words(contact),
        layered=have_layers(contact["bodies"]),
        free=contact.get("boundary") == "free",
        finite=is_finite_body(statistics),
        bound=_rounded_up(float(statistics["error_bound"].max())),
        loads=[_answers(statistics, index) for index in selected],
        measurand=_measurand(statistics, settings["uncertainty"]),
        version=versions["roughcontact"],
        commit=str(attrs.get("commit", ""))[:7],
    )
    return paragraph(text)


def _rounded_up(bound: float) -> float:
    """Return a bound with two digits, never a smaller one."""
    last_digit = 10.0 ** (math.floor(math.log10(bound)) - 1) if bound > 0 else 1.0
    return math.ceil(bound / last_digit * (1 - 1e-9)) * last_digit


def _answers(statistics: xr.Dataset, index: int) -> dict[str, Any]:
    """Return a load, and the answers there with their intervals in words."""
    answers: dict[str, Any] = {
        name: float(statistics[name][index]) for name in ("mean_pressure", "force") if name in statistics
    }
    for name, unit in _ANSWERS.items():
        interval = interval_at(statistics, name, index)
        factor, symbol = (100.0, unit) if unit == "%" else prefix(interval[0], unit)
        answers[name] = f"{with_interval(*(factor * end for end in interval))} {symbol}"
    return answers


def _measurand(statistics: xr.Dataset, uncertainty: dict[str, Any]) -> str:
    """Return what the intervals are for, nothing where there are none."""
    if "relative_contact_area_lower" not in statistics:
        return ""
    if is_finite_body(statistics):
        positions = statistics.attrs.get("window_reason")
        return f"this body{', also at other positions on its roughness' if positions else ''}"
    if "window" not in uncertainty["sources"]:
        return "this map alone"
    return measurand_in_words(uncertainty["extent"] if uncertainty["measurand"] == "longer" else None)
