"""Labelled height maps: construction, pitches, and interpolation to a finer grid."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from roughcontact.arguments.measurement import attributes_of_record
from roughcontact.arguments.si import convert_quantity, unit_of, warn_of_metres
from roughcontact.arguments.units import carries_unit, unit_factor, unknown_unit
from roughcontact.errors import HeightMapError, SettingsError


def height_map(
    values: npt.ArrayLike,
    spacing: float | str | Sequence[float | str],
    *,
    unit: str | None = None,
    height_unit: str | None = None,
    channel: str = "height",
    instrument: Mapping[str, object] | None = None,
) -> xr.DataArray:
    """Label an array of heights as a height map, in metres.

    Parameters
    ----------
    values : array (ny, nx), or (nx,) of a profile
        heights, positive outwards, row 0 at the smallest y; NaN or masked where not measured. Of a DataArray
        its attribute `units` counts and its coordinates do not.
    spacing : float or (dy, dx)
        pitch of the points, which are the centres of cells; text may carry a unit of its own, ``"1.5 um"``.
    unit : str, optional
        of the pitch, and of the heights unless `height_unit` is given: m by default.
    height_unit : str, optional
        of the heights.
    channel : str
        name of the heights.
    instrument : dict, optional
        any description of the measurement; it is stored as JSON.

    Returns
    -------
    DataArray (y, x), m
        the first cell centre lies at half a pitch.

    Raises
    ------
    HeightMapError
        for an array of another shape, or of other values than real numbers.
    SettingsError
        for an unknown unit, or a pitch that is no positive number.

    Warns
    -----
    HeightMapWarning
        without a unit, of a field above 1 m or an rms height above 1 mm.

    Examples
    --------
    >>> height = height_map([[0.0, 40.0, 80.0]], 0.5, unit="um", height_unit="nm")
    >>> height.dims, height.shape, height["x"].values, height.values, height.attrs["units"]
    (('y', 'x'), (1, 3), array([2.50e-07, 7.50e-07, 1.25e-06]), array([[0.e+00, 4.e-08, 8.e-08]]), 'm')
    """
    if hasattr(values, "magnitude") or hasattr(spacing, "magnitude"):
        raise SettingsError(
            "quantities of pint would lose their unit: give numbers (.magnitude) and the unit"
        )
    if isinstance(values, xr.DataArray):
        height_unit = height_unit or unit_of(values.attrs)
        values = values.transpose("y", "x") if {*values.dims} == {"y", "x"} else values
    try:  # a profile is a map of one row
        heights = np.atleast_2d(np.asarray(values))
    except ValueError as error:
        raise HeightMapError(f"values are no map of real numbers (ny, nx): {error}") from error
    if heights.ndim != 2 or not heights.size or heights.dtype.kind not in "fiu":
        raise HeightMapError(
            f"values of shape {heights.shape} and type {heights.dtype} are no map of real numbers (ny, nx)"
        )
    if np.ma.isMaskedArray(values):  # `numpy.asarray` drops the mask
        heights = np.where(np.ma.getmaskarray(values), np.nan, heights)
    # an empty text is no unit, as in a table
    units = {"unit": "m" if unit in (None, "") else unit}
    units["height_unit"] = units["unit"] if height_unit in (None, "") else height_unit
    for name, stated in units.items():
        if unit_factor(stated, "m") is None:
            raise SettingsError(f"{name} = {stated!r}: {unknown_unit(stated, 'm')}", keys=[name])
    lateral, vertical = (unit_factor(stated, "m") or 1.0 for stated in units.values())
    dy, dx = pitches(spacing, lateral)
    heights = heights.astype(float, copy=False)
    heights = heights if vertical == 1 else heights * vertical  # a large map is not copied
    ny, nx = heights.shape
    missing = int(np.isnan(heights).sum())
    record: dict[str, Any] = {"units": "m", "source_file": "", "source_sha256": "", "source_format": "array"}
    record |= {"channel": channel, "channels": [channel], "instrument": instrument or {}}
    record |= {"missing_points": missing, "missing_share": missing / heights.size, "ingest_warnings": []}
    # cell centres: the border of the map is half a pixel before
    y = xr.Variable("y", (np.arange(ny) + 0.5) * dy, {"units": "m"})
    x = xr.Variable("x", (np.arange(nx) + 0.5) * dx, {"units": "m"})
    if unit in (None, "") and not any(map(carries_unit, np.ravel(spacing))):
        warn_of_metres((y.values, x.values), heights, stacklevel=3)
    return xr.DataArray(heights, {"y": y, "x": x}, ("y", "x"), "height", attributes_of_record(record))


def pitches(spacing: float | str | Sequence[float | str], factor: float = 1.0) -> tuple[float, float]:
    """Return the pitches (dy, dx; m) from one for both axes or from two; a number alone times a factor."""
    try:
        steps = np.broadcast_to(np.asarray(spacing, dtype=object), 2)
        if any(isinstance(step, bool) for step in steps):
            raise TypeError("a truth value is no length")
        dy, dx = (
            convert_quantity("m", "spacing", step) if carries_unit(step) else float(step) * factor
            for step in steps
        )
    except SettingsError:
        raise
    except (TypeError, ValueError) as error:
        raise SettingsError(
            f"spacing = {spacing!r}: give the pitch of the points, a number or text with its unit (1.5 um), "
            "or both pitches (dy, dx)",
            keys=["spacing"],
        ) from error
    if not (0 < dy < np.inf and 0 < dx < np.inf):
        raise SettingsError(f"spacing = {spacing!r}: give positive numbers", keys=["spacing"])
    return dy, dx


def spacing(height: xr.DataArray) -> tuple[float, float]:
    """Return the pitches (dy, dx) of an evenly spaced map, from its coordinates and in their unit."""
    steps = {}
    for axis in ("y", "x"):
        values = height.get_index(axis).values  # thirty times as fast as height[axis]
        if values.size > 1:
            steps[axis] = float(values[-1] - values[0]) / (values.size - 1)
    if not steps:
        return 1.0, 1.0
    # the pitch of a single cell is that of the other axis: a profile does not vary across, and no result may
    # depend on its width
    only_step = next(iter(steps.values()))
    return steps.get("y", only_step), steps.get("x", only_step)


def merged(height: xr.DataArray, count: int) -> xr.DataArray:
    """Return a map (y, x) whose pixels are the means of so many along each axis; a rest at the end is cut.

    Its axes begin at the first point. On small maps `coarsen` of xarray takes a hundred times as long.

    Examples
    --------
    >>> import numpy as np
    >>> merged(height_map(np.arange(10.0).reshape(2, 5), 1.0), 2).values
    array([[3., 5.]])
    """
    ny, nx = (points // count for points in height.shape)
    blocks = height.values[: ny * count, : nx * count].reshape(ny, count, nx, count)
    thinned = height[: ny * count : count, : nx * count : count]
    return thinned.copy(deep=False, data=blocks.mean(axis=(1, 3)))


def side_lengths(height: xr.DataArray) -> tuple[float, float]:
    """Return the lengths (y, x) of both sides of an evenly spaced map, one pitch for a single cell.

    Examples
    --------
    >>> import numpy as np
    >>> side_lengths(height_map(np.zeros((2, 5)), (3.0, 1.0)))
    (6.0, 5.0)
    """
    (ny, nx), (dy, dx) = height.shape, spacing(height)
    return ny * dy, nx * dx


def dimensions(shape: Sequence[int]) -> int:
    """Return along how many axes a map of this shape varies: 2, or 1 of a profile.

    Examples
    --------
    >>> dimensions((64, 64)), dimensions((1, 512))
    (2, 1)
    """
    return max(1, sum(points > 1 for points in shape))


def areal_only(shape: Sequence[int]) -> float:
    """Return 1, or NaN of a profile: the factor of numbers that need an area, which no line has.

    Examples
    --------
    >>> areal_only((64, 64)), areal_only((1, 512))
    (1.0, nan)
    """
    return math.nan if dimensions(shape) == 1 else 1.0


def refined(window: xr.DataArray, factor: int) -> xr.DataArray:
    """Return a periodic map (y, x; m) at `factor` times as many points per axis, by its Fourier series."""
    values = window.values
    for axis, points in enumerate(values.shape):
        if points == 1 or factor == 1:
            continue
        spectrum = np.fft.rfft(values, axis=axis)
        if points % 2 == 0:
            # the Nyquist wave is shared between both signs: the series is real and interpolates
            np.moveaxis(spectrum, axis, 0)[-1] /= 2
        values = np.fft.irfft(spectrum, points * factor, axis=axis) * factor
    steps = [step / factor if n > 1 else step for n, step in zip(window.shape, spacing(window), strict=True)]
    return height_map(values, steps, unit="m")


def sides_around(points: np.ndarray, margin: Callable[[int], int]) -> tuple[slice, slice]:
    """Return rows and columns of the rectangle around points (ny, nx; bool), with a margin by its width."""
    sides = []
    for line, n in zip(points.nonzero(), points.shape, strict=True):
        start, last = int(line.min()), int(line.max())
        wider = margin(last - start)
        sides.append(slice(max(start - wider, 0), min(last + wider + 1, n)))
    return sides[0], sides[1]
