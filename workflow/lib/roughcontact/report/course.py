"""The course of a contact over a distance or a speed, on the page: a part of it, and its charts."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import TITLES, UNITS
from roughcontact.report.charts import Axis, Chart, curves_chart
from roughcontact.report.units import interval_values, unit_of

_BEFORE = {"wear": "Before sliding", "sliding": "At rest"}  # course -> the contact of which all else is


def course_section(
    name: str, file: str | Path, folder: Path, *, images: Mapping[str, str], sentences: Sequence[str]
) -> dict[str, Any]:
    """Return what the template of a course needs: pictures by label, sentences, the link from `folder`."""
    link = Path(os.path.relpath(file, folder)).as_posix()
    return {"name": name, "images": images, "sentences": sentences, "link": link}


def answer_with_courses(line: str, courses: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the answer of a surface before its `line` of the contact at rest: that of wear or of sliding.

    Examples
    --------
    >>> answer_with_courses("At 1 MPa: ...", {"wear": {"sentences": ["Run in after 3 m: so. Proven: that."]}})
    'Run in after 3 m: so. Before sliding, at 1 MPa: ...'
    """
    for name, before in _BEFORE.items():
        if name in courses:
            first, *_ = courses[name]["sentences"][0].partition(". ")
            line = f"{first}. {before}, {line[:1].lower()}{line[1:]}" if line else f"{first}."
    return line


def course_chart(course: xr.Dataset, result: str, abscissa: np.ndarray, x_axis: Axis) -> Chart:
    """Draw one result with its interval over a single dimension, along a logarithmic axis."""
    (dimension,) = course[result].dims
    unit = unit_of(course.isel({dimension: 0}), UNITS[result])
    # a hardness along the course is no limit of a single contact
    curves = interval_values(course.drop_vars("hardness", errors="ignore"), result)
    curve = [values * unit.factor for values in curves]
    return curves_chart(x_axis, abscissa, f"{TITLES[result]} ({unit.symbol})", {"": curve})
