"""Sliding rubber on the page: friction over the speed, the pressure where it is highest, shares of waves."""

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, ENDS, FRICTION, GAP, TITLES
from roughcontact.arguments.relaxation import MAX_MISFIT
from roughcontact.report.charts import Axis, Chart, curves_chart, log_axis
from roughcontact.report.course import course_chart, course_section
from roughcontact.report.template import sentence
from roughcontact.report.units import interval_values
from roughcontact.results.storage import read_dataset

_LINES = {
    "persson_friction_coefficient": "theory of Persson (2001)",
    "adhesive_friction_coefficient": "of the shear strength of the contact area, alone",
}
WARM = 10.0  # K, by which the loss of a rubber shifts by half a decade of frequency


def sliding_section(name: str, _: xr.Dataset, sliding: str | Path, folder: Path) -> dict[str, Any]:
    """Return pictures by label, the sentence of the friction, and the link from `folder`."""
    from roughcontact.report.map_plots import pressure_map  # with all that levels maps, for few pages

    over = read_dataset(sliding)
    highest = over.isel(speed=int(over[FRICTION].values.argmax()))
    image = pressure_map(xr.zeros_like(highest["pressure"]), highest["pressure"].values)
    images = {
        "coefficient of friction over the speed": _friction(over).source(),
        f"pressure at {highest['speed'].item():.3g} m/s": image.source(),
        "share of the friction by wavelength": _octaves(highest).source(),
    }
    speed = over["speed"].values
    images |= {
        f"{TITLES[result]} over the speed": course_chart(over, result, speed, _speed_axis(speed)).source()
        for result in (AREA, GAP)
    }
    peak = {suffix: highest[f"{FRICTION}{suffix}"].item() for suffix in ENDS}
    numbers = {str(key): highest[key].item() for key in highest.variables if highest[key].ndim == 0}
    text = sentence("slides", numbers, [*peak.values()], _misfit(over), _warm_from(over))
    return course_section(name, sliding, folder, images=images, sentences=[text])


def _misfit(over: xr.Dataset) -> float:
    """Return by how much the table of the rubber differs from every linear material, 0 if that is little."""
    misfit = float(over.attrs["relaxation_misfit"])
    return misfit if misfit > MAX_MISFIT else 0.0


def _warm_from(over: xr.Dataset) -> tuple[float, float] | None:
    """Return the speed (m/s) from which on the contact is 10 K warmer, and the highest; None: not known."""
    if "max_flash_temperature" not in over:
        return None
    warmer, speed = over["max_flash_temperature"].values, over["speed"].values
    above = np.flatnonzero(warmer >= WARM)
    if not above.size or above[0] == 0:
        return (float(speed[0]) if above.size else np.inf), float(speed[-1])
    pair = slice(above[0] - 1, above[0] + 1)  # between two speeds by power laws
    return float(np.exp(np.interp(np.log(WARM), *np.log([warmer[pair], speed[pair]])))), float(speed[-1])


def _speed_axis(speed: np.ndarray) -> Axis:
    """Return the axis of speeds (m/s)."""
    return log_axis("sliding speed v (m/s)", speed, room=1.3)


def _friction(over: xr.Dataset) -> Chart:
    """Draw the coefficient of friction with its interval against the speed, and theories beside it."""
    speed, curves = over["speed"].values, {"hysteresis, as solved": interval_values(over, FRICTION)}
    curves |= {label: [over[name].values] for name, label in _LINES.items() if name in over}
    return curves_chart(_speed_axis(speed), speed, "coefficient of friction μ", curves)


def _octaves(highest: xr.Dataset) -> Chart:
    """Draw the share of the friction that each octave of wavelengths makes."""
    wavelength, shares = highest["octave_wavelength"].values * 1e6, highest["friction_share_of_octave"].values
    x_axis = log_axis("octave of waves below (µm)", wavelength, room=1.3)
    chart = Chart(x_axis, Axis("share of the friction (%)", 0.0, 110 * float(shares.max() or 1.0)))
    chart.series(0, wavelength, 100 * shares, label="")
    return chart
