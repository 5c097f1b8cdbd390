"""Interpolation of irregular points to an even grid, only where the user asks for it.

Interpolation between points lowers slopes and with them the pressures, so it is never done by default.
"""

from dataclasses import replace

import numpy as np

from roughcontact.checking import check_choice
from roughcontact.choices import Resampling
from roughcontact.errors import HeightMapError, InputFileError
from roughcontact.io.channels import Channel, Points
from roughcontact.io.guards import check_points
from roughcontact.io.request import Request
from roughcontact.io.scale import given_steps
from roughcontact.io.units import is_length, metres

_REACH = 2.0  # steps from the nearest point beyond which a grid point counts as not measured


def on_even_grid(channel: Channel, request: Request) -> tuple[Channel, Request, list[str]]:
    """Return the channel on an even grid, the request less the steps used, and how it was resampled.

    The list of sentences is empty where it was not resampled.
    """
    points = channel.points
    if points is None:
        return channel, request, []
    if request.resample is None and channel.otherwise is not None:
        columns = channel.otherwise.shape[1]
        raise InputFileError(
            f"{columns} columns of numbers without names: a map of {columns} columns, then "
            f"give dx, dy and unit; or points ({points.uneven}), then give resample = linear to interpolate "
            "to an even grid (table of surfaces or arguments)"
        )
    if request.resample is None:
        raise InputFileError(
            f"{points.uneven}; give resample = linear (table of surfaces or argument) to "
            "interpolate to an even grid, or interpolate and export it with the instrument's software"
        )
    check_choice("resample", request.resample, Resampling)
    steps = given_steps(request)
    if any(steps):  # positions and steps in `unit`
        unit = request.unit or "m"
        factor = metres(channel.lateral_unit) / metres(unit) if is_length(channel.lateral_unit) else 1.0
        y = None if points.y is None else points.y * factor
        points = points._replace(x=points.x * factor, y=y)
        steps = steps[0] and steps[0] / metres(unit), steps[1] and steps[1] / metres(unit)
        channel = replace(channel, lateral_unit=unit)
    gridded, description = resampled(channel, points, steps)
    return gridded, replace(request, dx=None, dy=None), [description]


def resampled(
    channel: Channel, points: Points, steps: tuple[float | None, float | None]
) -> tuple[Channel, str]:
    """Return a channel on an even grid of steps (dx, dy), in its units, and a sentence that says how.

    Heights are linear within the triangles of Delaunay (1934, Bulletin de l'Académie des Sciences de l'URSS
    6, 793), of a profile between neighbours; none outside, or further than two steps from any point. A step
    of None is sqrt(area / number), the same along x and y.

    Examples
    --------
    >>> x = np.array([0.0, 1.0, 3.0, 4.0])
    >>> points = Points(x, None, 10 * x, "the positions along x are not evenly spaced")
    >>> trace = Channel("height", (1, 4), lambda: None, points=points)
    >>> gridded, done = resampled(trace, points, (2.0, None))
    >>> gridded.read(), gridded.dx
    (array([[ 0., 20., 40.]]), 2.0)
    """
    x, y, z, uneven = points
    if z.size < (3 if y is None else 4):
        raise HeightMapError(f"{z.size} points are too few to be resampled; measure again")
    along_x, along_y, heights = (_profile if y is None else _map)(x, y, z, steps)
    gridded = replace(
        channel,
        shape=heights.shape,
        read=heights.copy,
        dx=float(along_x[1] - along_x[0]),
        dy=None if y is None else float(along_y[1] - along_y[0]),
        first_x=float(along_x[0]),
        first_y=None if y is None else float(along_y[0]),
        points=None,
        otherwise=None,
    )
    size = f"{heights.shape[1]}" if y is None else f"{heights.shape[0]} x {heights.shape[1]}"
    return gridded, (
        f"{uneven}: resampled as asked, {z.size} points interpolated linearly to {size} on an even "
        "grid, which lowers slopes and peak pressures"
    )


def _profile(x, _, z, steps):
    """Return the positions of the grid and the heights (1, nx) there, linear between neighbours."""
    order = np.argsort(x, kind="stable")
    x, z = x[order], z[order]
    step = steps[0] or (x[-1] - x[0]) / (x.size - 1)
    grid = _grid(x, step)
    check_points((1, grid.size))
    heights = np.interp(grid, x, z)
    nearest = np.clip(np.searchsorted(x, grid), 1, x.size - 1)
    away = np.minimum(np.abs(grid - x[nearest - 1]), np.abs(grid - x[nearest]))
    heights[away > _REACH * step] = np.nan
    return grid, None, heights[None, :]


def _map(x, y, z, steps):
    """Return the positions of the grid along x and y and the heights (ny, nx) there."""
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import QhullError, cKDTree

    area = np.ptp(x) * np.ptp(y)
    if not area > 0:
        raise HeightMapError("all points lie on one line; give the file as a profile (x, z)")
    dx, dy = steps
    dx = dx or dy or np.sqrt(area / z.size)
    dy = dy or dx
    along_x, along_y = _grid(x, dx), _grid(y, dy)
    check_points((along_y.size, along_x.size))
    # in steps from the middle: the triangulation matches the grid, and rounding errors are small
    scaled = np.column_stack([(x - x.mean()) / dx, (y - y.mean()) / dy])
    grid = np.meshgrid((along_x - x.mean()) / dx, (along_y - y.mean()) / dy)
    try:
        heights = LinearNDInterpolator(scaled, z)(*grid)
    except QhullError as error:
        raise HeightMapError("all points lie on one line; give the file as a profile") from error
    distance, _ = cKDTree(scaled).query(
        np.column_stack([coordinates.ravel() for coordinates in grid]), workers=1
    )
    heights[distance.reshape(heights.shape) > _REACH] = np.nan
    return along_x, along_y, heights


def _grid(positions, step):
    """Return the points of an even grid within the positions, centred among them."""
    low, high = positions.min(), positions.max()
    intervals = int(np.floor((high - low) / step * (1 + 1e-9)))
    if intervals < 1:
        raise HeightMapError(f"a step of {step:g} is longer than the field of {high - low:g}")
    return (low + high) / 2 + step * (np.arange(intervals + 1) - intervals / 2)
