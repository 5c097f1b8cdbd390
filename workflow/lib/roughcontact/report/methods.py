"""The paragraph of methods for a paper: what was done to a map, and the answers, from its statistics."""

import math
from typing import Any

import xarray as xr

from roughcontact.arguments.answers import AREA, ENDS, GAP, PRESSURE, UNITS
from roughcontact.arguments.choices import PERIODIC_BY
from roughcontact.arguments.kinds import facts_of
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import Unit, prefix, quantity
from roughcontact.arguments.stacks import properties_of_bodies
from roughcontact.report.asked import bodies_in_words
from roughcontact.report.budget_plots import largest_parts
from roughcontact.report.template import paragraph, template
from roughcontact.report.units import quantity_text, unit_of
from roughcontact.statistics.kinds import facts_of_numbers
from roughcontact.uncertainty.subwindows import MEASURAND_IN_WORDS

_MAX_LOADS = 3  # whose answers a paragraph has: the lowest, one between, the highest


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
    attrs, settings = statistics.attrs, json_attribute(statistics.attrs, "settings")
    lengths = [float(statistics[f"window_length_{axis}"]) for axis in "xy"]
    rising = statistics["mean_pressure"].argsort().values.tolist()
    indices = [rising[0], rising[len(rising) // 2], rising[-1]] if len(rising) > _MAX_LOADS else rising
    text = template("methods.txt").render(
        settings | {key: settings.get(key) or {} for key in ("form", "surface")},
        attrs=attrs,
        sha256=[f"{text[:8]}…" for text in str(attrs.get("source_sha256", "")).split(" + ") if text],
        sides=[length for length in lengths if math.isfinite(length)],
        periodisation=attrs.get("periodisation", settings["window"]["method"]),
        periodic_by=PERIODIC_BY,
        **{name: float(statistics[name]) for name in ("rms_height", "rms_gradient", "contact_modulus")},
        bodies=bodies_in_words(settings["contact"]),
        layered=bool(properties_of_bodies(settings["contact"]["bodies"])),
        kind=facts_of(settings["contact"]),
        bound=_rounded_up(float(statistics["error_bound"].max())),
        loads=[_answers(statistics, index) for index in indices],
        measurand=interval_measurand(statistics, settings["uncertainty"]),
        largest=largest_parts(statistics.isel(load=indices)),
        hardness=_range_of_hardness(statistics),
        over_overview=f"{GAP}_alone_lower" in statistics,
        version=json_attribute(attrs, "versions")["roughcontact"],
        commit=str(attrs.get("commit", ""))[:7],
    )
    return paragraph(text)


def _range_of_hardness(statistics: xr.Dataset) -> str:
    """Return what the intervals hold of the hardness."""
    if "hardness_lower" not in statistics:
        return "without its uncertainty"
    hardness, *bounds = (float(statistics[f"hardness{suffix}"]) for suffix in ENDS)
    unit = Unit(*prefix(hardness, "Pa"))  # of loads on rubber it would be thousands of them
    return f"in the intervals {unit.ends(*bounds)}"


def _rounded_up(bound: float) -> float:
    """Return a bound with two digits, never a smaller one."""
    last_digit = 10.0 ** (math.floor(math.log10(bound)) - 1) if bound > 0 else 1.0
    return math.ceil(bound / last_digit * (1 - 1e-9)) * last_digit


def _answers(statistics: xr.Dataset, index: int) -> dict[str, str]:
    """Return a load, and the answers there with their intervals in words."""
    answers = {
        name: quantity_text(statistics, name, unit_of(statistics, UNITS[name]), index)
        for name in ("mean_pressure", AREA, PRESSURE, GAP)
    }
    if "force" in statistics:
        answers["force"] = quantity(float(statistics["force"][index]), "N")
    return answers


def interval_measurand(statistics: xr.Dataset, uncertainty: dict[str, Any]) -> str:
    """Return what the intervals are for, nothing where there are none."""
    if "relative_contact_area_lower" not in statistics:
        return ""
    if facts_of_numbers(statistics).form_is_meant:
        positions = "window_reason" in statistics.attrs
        return f"this body{', also at other positions on its roughness' * positions}"
    return MEASURAND_IN_WORDS if "window" in uncertainty["sources"] else "this map alone"
