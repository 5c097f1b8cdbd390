"""Maps of heights, contact pressure and gap; profiles are drawn as lines."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions, side_lengths
from roughcontact.arguments.profiles.lines import are_lines
from roughcontact.arguments.quantities import Unit, height_unit
from roughcontact.report.charts import COLOURS, Axis, Chart
from roughcontact.report.colours import colour_scale, coloured
from roughcontact.report.units import length_unit

_MEGAPASCALS = Unit(1e-6, "MPa")
_WIDTH = 240.0  # of a square picture, pixels
_HIGHEST = 330.0  # of a picture, pixels
_MAX_ASPECT = 4.0  # longer pictures are drawn out of scale

Frame = tuple[float, float, float, float]  # x, y, length x, length y
Fields = tuple[np.ndarray, np.ndarray]  # pressure (Pa) and gap (m) of a load


class Field(NamedTuple):
    """What a map shows, and how: its colours, the colour of points without a value and what they are."""

    label: str
    colours: str
    bad: str = "#ffffff"
    bad_word: str = ""


_HEIGHT = Field("height", "viridis", "#ff4fa3", "not measured")
_PRESSURE = Field("pressure", "viridis", "#e4e4e4", "no contact")
_GAP = Field("gap", "cividis", "#ffffff", "contact")


def height_map(
    height: xr.DataArray,
    *,
    rectangle: Frame | None = None,
    along: Unit | None = None,
    like: xr.DataArray | None = None,
) -> Chart:
    """Draw a height map (y, x; m), points that were not measured in pink; profiles are drawn as lines.

    `rectangle` (m from the first corner) outlines the window; `along` is the unit of lengths; the colours are
    those of the heights `like` these.
    """
    like = height if like is None else like
    unit = height_unit(float(like.std()))
    if are_lines(height):
        profiles = height.values if height.shape[1] > 1 else height.values.T
        lines = {f"profile {index}": values for index, values in enumerate(profiles, 1)}
        return _profile(height, lines, "height", unit, along=along)
    outline = None
    if rectangle is not None:
        x, y, width, depth = rectangle
        outline = np.array([x, x + width, x + width, x, x]), np.array([y, y, y + depth, y + depth, y])
    # heights relative to the mean: the scale of a file far from zero says nothing
    values = height.values - np.nanmean(height.values)
    # a few spikes must not take up the colour scale
    scale = like.values - np.nanmean(like.values)
    lowest, highest = (float(limit) for limit in np.nanpercentile(scale, [0.1, 99.9]))
    return _map(_HEIGHT, height, values, (lowest, highest), unit=unit, outline=outline, along=along)


def common_limits(loads: Iterable[Fields]) -> tuple[float, float]:
    """Return the highest pressure (Pa) and the widest gap (m) of the colour scales of several loads."""
    highest = widest = 0.0
    for pressure, gap in loads:
        touching = pressure > 0
        highest = max(highest, _most(pressure[touching]))
        widest = max(widest, _most(gap[~touching]))
        del pressure, gap  # before the next ones are made
    return highest or 1.0, widest


def _most(values: np.ndarray) -> float:
    """Return the value that all but the highest do not exceed, 0 of none: a few peaks take no colours."""
    return float(np.percentile(values, 99.5, overwrite_input=True)) if values.size else 0.0


def pressure_map(
    height: xr.DataArray,
    pressure: np.ndarray,
    *,
    highest: float | None = None,
    unit: Unit = _MEGAPASCALS,
    ellipse: Mapping[str, float] | None = None,
) -> Chart:
    """Draw the contact pressure (Pa) over the window, no contact in grey; a profile is drawn as a line.

    `ellipse` (its semi-axes `axis_x`, `axis_y` in m) is outlined; `highest` (Pa) has the last colour.
    """
    if dimensions(pressure.shape) == 1:
        return _profile(height, {"pressure": pressure.ravel()}, "pressure", unit, colours=COLOURS[1:])
    highest = common_limits([(pressure, pressure)])[0] if highest is None else highest
    outline = None
    if ellipse:
        # the ellipse in which smooth bodies would touch
        angle, (ly, lx) = np.linspace(0, 2 * np.pi, 181), side_lengths(height)
        outline = lx / 2 + ellipse["axis_x"] * np.cos(angle), ly / 2 + ellipse["axis_y"] * np.sin(angle)
    values = np.where(pressure > 0, pressure, np.nan)
    return _map(_PRESSURE, height, values, (0, highest), unit=unit, outline=outline)


def gap_map(
    height: xr.DataArray, gap: np.ndarray, pressure: np.ndarray, *, widest: float | None = None
) -> Chart:
    """Draw the gap (m) over the window, contact in white; a profile shows both faces as lines."""
    unit = height_unit(float(height.std()))
    if dimensions(gap.shape) == 1:
        faces = {"rough surface": height.values.ravel(), "deformed surface": (height.values + gap).ravel()}
        return _profile(height, faces, "height", unit)
    # the gap (m) of the last colour; in full contact there is none for the scale
    widest = widest or common_limits([(pressure, gap)])[1] or float(np.ptp(height.values))
    return _map(_GAP, height, np.where(pressure > 0, np.nan, gap), (0, widest), unit=unit)


def _map(
    field: Field,
    height: xr.DataArray,
    values: np.ndarray,
    limits: tuple[float, float],
    *,
    unit: Unit,
    outline: tuple[np.ndarray, np.ndarray] | None = None,
    along: Unit | None = None,
) -> Chart:
    """Draw the values of a field over the extent of `height`, an arrow where some lie beyond the colours.

    Pictures of one shape come out alike.
    """
    lengths = side_lengths(height)
    factor, of_lengths = along or length_unit(max(lengths))
    y, x = (Axis(f"{name} ({of_lengths})", 0.0, n * factor) for name, n in zip("yx", lengths, strict=True))
    low, high = (limit * unit.factor for limit in limits)
    # a flat map has no range, and a colour bar needs one
    bar = Axis(f"{field.label} ({unit.symbol})", low, high if high > low else low + 1e-6 * unit.factor)
    aspect = y.high / x.high
    if not 1 / _MAX_ASPECT <= aspect <= _MAX_ASPECT:
        aspect, y = 1.0, Axis(f"{y.label}, not to scale", y.low, y.high)
    width = min(_WIDTH, _HIGHEST / aspect)
    margins = (84.0, 14.0, _WIDTH - width + 106.0, 53.0)
    chart = Chart(x, y, size=(84.0 + _WIDTH + 106.0, width * aspect + 67.0), margins=margins, grid=False)
    colours, numbers = colour_scale(field.colours), values * unit.factor
    source, coarse = coloured(numbers[::-1], (bar.low, bar.high), field.colours, bad=field.bad)  # y upwards
    chart.note("picture", source=source, smooth=not coarse)
    chart.reading = {"value": bar.reading(), "colours": colours, "bad": [field.bad, field.bad_word]}
    chart.reading |= {"points": list(values.shape[::-1])}
    chart.note("values", values=numbers, bar=bar, colours=field.colours, bad=field.bad)
    chart.colour_bar(bar, colours, (bool((values < limits[0]).any()), bool((values > limits[1]).any())))
    if outline is not None:
        # white below red: visible on every colour
        for colour, width in (("#ffffff", 4.0), ("#d00000", 2.0)):
            chart.line(outline[0] * factor, outline[1] * factor, colour=colour, width=width)
    return chart


def _profile(
    height: xr.DataArray,
    lines: Mapping[str, np.ndarray],
    label: str,
    unit: Unit,
    *,
    along: Unit | None = None,
    colours: Sequence[str] = COLOURS,
) -> Chart:
    """Draw values by their names along a profile, gaps where they are missing; no more than `colours`."""
    axis = "x" if height.sizes["x"] > 1 else "y"
    position = height[axis].values - height[axis].values[0]  # from the first point, as on the map
    factor, of_lengths = along or length_unit(max(side_lengths(height)))
    names = [*lines][: len(colours)]
    all_values = np.concatenate([lines[name] for name in names])
    low, high = (float(limit(all_values)) * unit.factor for limit in (np.nanmin, np.nanmax))
    # some room above and below, also for a flat profile
    room = (high - low) * 0.06 or 1e-6 * unit.factor
    x = Axis(f"{axis} ({of_lengths})", 0.0, float(position[-1]) * factor)
    chart = Chart(x, Axis(f"{label} ({unit.symbol})", low - room, high + room), size=(430.0, 290.0))
    for name, colour in zip(names, colours, strict=False):
        legend = name if len(names) > 1 else ""
        chart.line(position * factor, lines[name] * unit.factor, colour=colour, width=1.1, label=legend)
    return chart
