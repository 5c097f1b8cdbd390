"""The figures of the report that show maps: heights, contact pressure, gap; those of profiles are lines."""

from typing import Literal

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.patches import Rectangle

from roughcontact.maps import side_lengths
from roughcontact.quantities import prefix
from roughcontact.report.figures import COLOURS, as_png, as_svg, new_figure, new_picture

_NOT_MEASURED = "#ff4fa3"
_NO_CONTACT = "#e4e4e4"
_CONTACT = "#ffffff"
_MAP_POINTS = 1200  # along the longer side of a drawn map; finer maps are thinned

Frame = tuple[float, float, float, float]  # x, y, length x, length y


def height_map(height: xr.DataArray, *, rectangle: Frame | None = None) -> str:
    """Draw a height map, points that were not measured in pink; a profile is drawn as a line.

    Parameters
    ----------
    height : DataArray (y, x), m
        NaN where not measured.
    rectangle : (x, y, length x, length y), m, or None
        outline of the window on the map, from the map's first corner.

    Returns
    -------
    str
        source of the image, a data URI.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map as labelled
    >>> height_map(labelled(np.array([[0.0, 1e-6, 0.0]]), 1e-6)).partition(",")[0]
    'data:image/svg+xml;base64'
    """
    if 1 in height.shape:
        return _profile(height, [(height.values.ravel(), "height", COLOURS[0])], label="height", unit="m")
    values = height.values - np.nanmean(height.values)
    lowest, highest = np.nanpercentile(values, [0.1, 99.9])  # spikes must not take all the colours
    return _map(
        height,
        values,
        label="height",
        unit="m",
        colours="viridis",
        bad=_NOT_MEASURED,
        limits=(lowest, highest),
        extend="both",
        frame=rectangle,
    )


def pressure_map(height: xr.DataArray, pressure: np.ndarray) -> str:
    """Draw the contact pressure over the window, no contact in grey; a profile is drawn as a line.

    Parameters
    ----------
    height : DataArray (y, x), m
        the window, for its coordinates.
    pressure : array (ny, nx), Pa

    Returns
    -------
    str
        source of the image, a data URI.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.maps import height_map as labelled
    >>> pressure = np.array([[0.0, 2e6, 0.0]])
    >>> pressure_map(labelled(np.array([[0.0, 1e-6, 0.0]]), 1e-6), pressure).partition(",")[0]
    'data:image/svg+xml;base64'
    """
    if 1 in pressure.shape:
        return _profile(height, [(pressure.ravel(), "pressure", COLOURS[1])], label="pressure", unit="Pa")
    return _map(
        height,
        np.where(pressure > 0, pressure, np.nan),
        label="pressure",
        unit="Pa",
        colours="viridis",
        bad=_NO_CONTACT,
        limits=(0, np.percentile(pressure[pressure > 0], 99.5)),  # a few peaks must not take all the colours
        extend="max",
    )


def gap_map(height: xr.DataArray, gap: np.ndarray, pressure: np.ndarray) -> str:
    """Draw the gap over the window with the contact in white; a profile shows both faces as lines.

    Parameters
    ----------
    height : DataArray (y, x), m
        the window.
    gap : array (ny, nx), m
    pressure : array (ny, nx), Pa
        positive where the surfaces touch.

    Returns
    -------
    str
        source of the image, a data URI.
    """
    if 1 in gap.shape:
        faces = [
            (height.values.ravel(), "rough surface", COLOURS[0]),
            ((height.values + gap).ravel(), "deformed surface", COLOURS[1]),
        ]
        return _profile(height, faces, label="height", unit="m")
    # full contact leaves no gap to scale by
    widest = gap[pressure == 0].max(initial=0.0) or np.ptp(height.values)
    return _map(
        height,
        np.where(pressure > 0, np.nan, gap),
        label="gap",
        unit="m",
        colours="cividis",
        bad=_CONTACT,
        limits=(0, widest),
    )


def _map(
    height: xr.DataArray,
    values: np.ndarray,
    *,
    label: str,
    unit: str,
    colours: str,
    bad: str,
    limits: tuple[float, float],
    extend: Literal["neither", "both", "max"] = "neither",
    frame: Frame | None = None,
) -> str:
    """Draw values over the extent of `height`; NaN in the colour `bad`, an arrow where colours end early.

    The first row is drawn where the instrument's own software draws it. A map finer than the picture is
    drawn as it looks from afar: colours, not values, are averaged, so that the contact keeps its share.
    """
    lengths = side_lengths(height)
    factor, length_unit = prefix(max(lengths), "m")
    ly, lx = (length * factor for length in lengths)
    scale, value_unit = prefix(max(abs(limits[0]), abs(limits[1])), unit)
    with new_picture(ly / lx) as picture:
        axes = picture.axes
        image = axes.imshow(
            np.ma.masked_invalid(values[:: _stride(values.shape[0]), :: _stride(values.shape[1])] * scale),
            origin="lower",
            extent=(0, lx, 0, ly),
            cmap=matplotlib.colormaps[colours].with_extremes(bad=bad),
            vmin=limits[0] * scale,
            vmax=limits[1] * scale if limits[1] > limits[0] else limits[0] * scale + 1,
            interpolation="auto",
            interpolation_stage="rgba",
            aspect="auto",
        )
        if height.attrs.get("first_row") == "top":
            axes.invert_yaxis()
        if frame is not None:
            x, y, width, depth = (value * factor for value in frame)
            for colour, line in (("white", 3.0), ("#d00000", 1.5)):
                outline = Rectangle((x, y), width, depth, fill=False, edgecolor=colour, linewidth=line)
                axes.add_patch(outline)
        axes.set_xlabel(f"x ({length_unit})")
        axes.set_ylabel(f"y ({length_unit})" + ("" if picture.in_scale else ", not to scale"))
        picture.add_colour_bar(image, f"{label} ({value_unit})", extend=extend)
        return as_png(picture.figure)


def _profile(height: xr.DataArray, lines: list[tuple[np.ndarray, str, str]], *, label: str, unit: str) -> str:
    """Draw one or more lines (values, name, colour) along a profile, gaps where values are missing."""
    along = "x" if height.sizes["x"] > 1 else "y"
    position = height[along].values - height[along].values[0]
    factor, length_unit = prefix(float(position[-1]), "m")
    scale, value_unit = prefix(float(np.nanmax([np.nanmax(np.abs(line[0])) for line in lines])), unit)
    with new_figure(4.0, 2.6) as figure:
        axes = figure.add_subplot()
        for values, name, colour in lines:
            axes.plot(position * factor, values * scale, color=colour, linewidth=0.9, label=name)
        axes.set_xlabel(f"{along} ({length_unit})")
        axes.set_ylabel(f"{label} ({value_unit})")
        if len(lines) > 1:
            axes.legend()
        return as_svg(figure)


def _stride(points: int) -> int:
    """Return from how many points one is drawn where there are so many along a side."""
    return -(-points // _MAP_POINTS)
