"""The course of a contact over a distance or a speed, on the page: a part of it, and its charts."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ENDS, TITLES, UNITS
from roughcontact.report.charts import COLOURS, Axis, Chart, log_axis
from roughcontact.report.units import unit_of


def course_section(
    name: str, file: str | Path, folder: Path, *, images: Mapping[str, str], sentences: Sequence[str]
) -> dict[str, Any]:
    """Return what the template of a course needs: pictures by label, sentences, the link from `folder`."""
    link = Path(os.path.relpath(file, folder)).as_posix()
    return {"name": name, "images": images, "sentences": sentences, "link": link}


def course_chart(course: xr.Dataset, result: str, abscissa: np.ndarray, x_axis: Axis) -> Chart:
    """Draw one result with its interval over a single dimension, along a logarithmic axis."""
    (dimension,) = course[result].dims
    unit = unit_of(course.isel({dimension: 0}), UNITS[result])
    values, lower, upper = (
        course[name].values * unit.factor
        if (name := f"{result}{suffix}") in course
        else np.full(abscissa.shape, np.nan)
        for suffix in ENDS
    )
    plotted = np.concatenate([values, lower, upper])
    chart = Chart(x_axis, log_axis(f"{TITLES[result]} ({unit.symbol})", plotted, room=1.3))
    chart.bars(abscissa, lower, upper, colour=COLOURS[0])
    chart.line(abscissa, values, colour=COLOURS[0])
    return chart
