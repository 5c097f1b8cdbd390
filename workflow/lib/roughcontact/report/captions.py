"""Captions and alternative texts of the charts: their main numbers in words.

They are taken from the statistics of one surface, with its loads rising.
"""

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr

from roughcontact.quantities import Unit, number, percent
from roughcontact.report.glance import is_limited
from roughcontact.report.units import unit_of


def area_caption(numbers: xr.Dataset) -> str:
    """Return the contact area at the lowest and at the highest load."""
    text = _at_extreme_loads(numbers, "relative_contact_area", "{} of the area touch", percent)
    if "area_xu" in numbers and np.isfinite(xu := _last(numbers, "area_xu")):
        text += f"; the theory of Xu et al. says {percent(xu)} there"
    return f"{text}."


def gap_caption(numbers: xr.Dataset) -> str:
    """Return the mean gap at the lowest and at the highest load."""
    gaps, rms = numbers["mean_gap"].values, float(numbers["rms_height"])
    text = _at_extreme_loads(numbers, "mean_gap", "The mean gap is {}", unit_of(numbers, "m").text)
    shares = " and ".join(dict.fromkeys(number(float(gap) / rms) for gap in (gaps[0], gaps[-1])))
    return f"{text}: {shares} of the rms height."


def pressure_caption(numbers: xr.Dataset) -> str:
    """Return mean and largest pressure at the lowest and highest load, and where the hardness is reached."""
    largest, pressure = numbers["max_pressure"].values, unit_of(numbers, "Pa").text
    text = _at_extreme_loads(numbers, "mean_contact_pressure", "Mean pressure in contact {}", pressure)
    limited = [index for index in range(largest.size) if is_limited(numbers, index)]
    peak = limited[0] if limited else int(largest.argmax())
    load, maximum = (pressure(float(values[peak])) for values in (numbers["mean_pressure"].values, largest))
    if limited:
        return f"{text}; largest {maximum}, the hardness, from {load} on."
    return f"{text}; largest {maximum} at {load}."


def distribution_caption(numbers: xr.Dataset) -> str:
    """Return the scatter of the pressure over the contact at the highest load.

    Examples
    --------
    >>> loads = {"mean_pressure": ("load", [5e6]), "relative_contact_area_pixels": ("load", [0.025])}
    >>> distribution_caption(xr.Dataset(loads | {"pressure_std": ("load", [5e7])}))
    'At 5.00 MPa the pressure scatters by 25.0 % of its mean over the contact.'
    """
    load = _last_load(numbers)
    if is_limited(numbers, -1) and (share := _last(numbers, "area_share_above_hardness")) > 0:
        return f"At {load} {percent(share)} of the contact carry the hardness."
    mean = _last(numbers, "mean_pressure") / _last(numbers, "relative_contact_area_pixels")  # of the pixels
    scatter = _last(numbers, "pressure_std") / mean
    return f"At {load} the pressure scatters by {percent(scatter)} of its mean over the contact."


def patch_caption(numbers: xr.Dataset) -> str:
    """Return the number of patches at the highest load and the area of the largest.

    Examples
    --------
    >>> found = {"mean_pressure": ("load", [5e6]), "contact_clusters": ("load", [12])}
    >>> areas = {"largest_patch_area": ("load", [2e-11]), "relative_contact_area_pixels": ("load", [0.1])}
    >>> window = {"window_length_x": 2e-5, "window_length_y": 2e-5}
    >>> patch_caption(xr.Dataset(found | areas | window))
    'At 5.00 MPa 12 patches touch; the largest, 20.0 µm², has 50.0 % of the contact.'
    """
    window = float(numbers["window_length_x"] * numbers["window_length_y"])
    largest = _last(numbers, "largest_patch_area")
    share = percent(largest / (_last(numbers, "relative_contact_area_pixels") * window))
    count = int(_last(numbers, "contact_clusters"))
    load, area = _last_load(numbers), unit_of(numbers, "m2").text(largest)
    if count == 1:
        return f"At {load} a single patch of {area} touches."
    return f"At {load} {count} patches touch; the largest, {area}, has {share} of the contact."


def open_caption(numbers: xr.Dataset) -> str:
    """Return the mean gap where the surfaces do not touch, at the highest load.

    Examples
    --------
    >>> found = {"mean_pressure": ("load", [5e6]), "mean_gap": ("load", [1e-7])}
    >>> open_caption(xr.Dataset(found | {"relative_contact_area": ("load", [0.5])}))
    'At 5.00 MPa 50.0 % of the area are apart, by 0.200 µm on average.'
    """
    load, open_share = _last_load(numbers), 1 - _last(numbers, "relative_contact_area")
    if open_share <= 0:
        return f"At {load} nothing is apart."
    mean = unit_of(numbers, "m").text(_last(numbers, "mean_gap") / open_share)
    return f"At {load} {percent(open_share)} of the area are apart, by {mean} on average."


def reading_of(numbers: xr.Dataset, *names: str) -> str:
    """Return how the bars of these quantities in a figure are to be read, where there are any."""
    available = [name for name in names if f"{name}_lower" in numbers]
    arrow = any(
        (numbers[f"{name}_lower"].notnull() & numbers[f"{name}_upper"].isnull()).any() for name in available
    )
    return f"Bars: the ±{'; an arrow: nothing bounds it upwards' * arrow}." if available else ""


def comparison_caption(
    series: Sequence[tuple[str, np.ndarray, np.ndarray]], pressure: Unit | None = None
) -> str:
    """Return the surfaces with least and most contact at the highest common load of (name, loads, areas).

    Loads rise, mean pressures (Pa) in the unit `pressure`, or relative ones without. Empty for one surface,
    and where loads do not overlap.
    """
    if len(series) < 2:
        return ""
    highest = min(float(loads[-1]) for _, loads, _ in series)
    if highest < max(float(loads[0]) for _, loads, _ in series):
        return ""
    between = any(np.abs(loads / highest - 1).min() > 1e-6 for _, loads, _ in series)
    areas = [float(np.interp(highest, loads, areas)) for _, loads, areas in series]
    load = f"p̄ = {pressure.text(highest)}" if pressure else f"p′ = {number(highest)}"
    extremes = int(np.argmin(areas)), int(np.argmax(areas))
    shares = [percent(areas[index]) for index in extremes]
    if shares[0] == shares[1]:
        return f"At {load}, {shares[0]} of the area touch in all."
    lowest, maximum = (
        f"{share} ({series[surface][0]})" for share, surface in zip(shares, extremes, strict=True)
    )
    note = ", interpolated between the loads solved" if between else ""
    return f"At {load}, {lowest} to {maximum} of the area touch{note}."


def _last(numbers: xr.Dataset, name: str) -> float:
    """Return a number at the highest load; a selection of all variables would take as long as a chart."""
    return float(numbers[name].values[-1])


def _last_load(numbers: xr.Dataset) -> str:
    """Return the highest mean pressure."""
    return unit_of(numbers, "Pa").text(_last(numbers, "mean_pressure"))


def _at_extreme_loads(numbers: xr.Dataset, name: str, sentence: str, show: Callable[[float], str]) -> str:
    """Return a `sentence` on a number at the lowest load, and that at the highest where there are two."""
    values, loads = numbers[name].values, numbers["mean_pressure"].values
    pressure = unit_of(numbers, "Pa").text
    text = f"{sentence.format(show(float(values[0])))} at {pressure(float(loads[0]))}"
    return text if loads.size == 1 else f"{text}, {show(float(values[-1]))} at {pressure(float(loads[-1]))}"
