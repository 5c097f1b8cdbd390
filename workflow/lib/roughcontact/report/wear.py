"""Running-in on the page: maps before and after, the contact over the distance, when it settles."""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, CONDUCTANCE, ENDS, GAP, PEAK, TITLES
from roughcontact.arguments.quantities import number
from roughcontact.report.charts import Axis, Chart, curves_chart, log_axis
from roughcontact.report.course import course_chart, course_section
from roughcontact.report.template import sentence
from roughcontact.report.units import unit_of
from roughcontact.results.storage import read_dataset
from roughcontact.statistics.decisions import CLOSED

_DRAWN = (AREA, PEAK, GAP, CONDUCTANCE, "leak_rate_x", "leak_rate_y")
_HEIGHTS = {"Sq": "root mean square", "Spk": "reduced peaks", "Svk": "reduced dales"}


def wear_section(name: str, _: xr.Dataset, worn: str | Path, folder: Path) -> dict[str, Any]:
    """Return pictures by label, the sentence of a worn face, and the link from `folder`."""
    from roughcontact.report.map_plots import height_map  # with all that levels maps, for few pages

    over = read_dataset(worn)
    before, after = over.isel(sliding_distance=0), over.isel(sliding_distance=-1)
    last = {str(name): value.values.item() for name, value in after.variables.items() if not value.dims}
    faces = {"before wear": before, f"after {number(last['sliding_distance'])} m": after}
    images = {
        f"heights {text}": height_map(face["height"], like=before["height"]).source()
        for text, face in faces.items()
    }
    charts = {TITLES[result]: course_chart(over, result, *_axis(over)) for result in _DRAWN if result in over}
    charts["height parameters"] = _parameters(over)
    images |= {f"{label} over the distance": chart.source() for label, chart in charts.items()}
    settled = [over[f"running_in_distance{suffix}"].item() for suffix in ENDS]
    areas, heights = ([face[name].item() for face in (before, after)] for name in (AREA, "Sq"))
    text = sentence("runs_in", last, settled, areas, heights)
    return course_section(name, worn, folder, images=images, sentences=[text])


def _axis(over: xr.Dataset) -> tuple[np.ndarray, Axis]:
    """Return the distances (m) and their axis; the face as it is stands at the left end."""
    distances = over["sliding_distance"].values.copy()
    distances[distances == 0] = distances[distances > 0].min() / 3
    return distances, log_axis("sliding distance s (m), leftmost: 0", distances, room=1.3)


def _parameters(over: xr.Dataset) -> Chart:
    """Draw height parameters against the distance."""
    distances, x_axis = _axis(over)
    unit = unit_of(over.isel(sliding_distance=0), "m")
    # finer than atoms nothing is known
    heights = over[[*_HEIGHTS]].where(over[[*_HEIGHTS]] >= CLOSED) * unit.factor
    curves = {f"{name}, {words}": [heights[name].values] for name, words in _HEIGHTS.items()}
    return curves_chart(x_axis, distances, f"height ({unit.symbol})", curves)
