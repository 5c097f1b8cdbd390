"""Interpolation of irregular points to an even grid, only where the user asks for it.

Interpolation between points lowers slopes and with them the pressures, so it is never done by default.
"""

from dataclasses import replace
from math import prod

import numpy as np

from roughcontact.errors import HeightMapError, InputFileError
from roughcontact.io.channels import Channel
from roughcontact.io.guards import check_points, refusal
from roughcontact.io.request import Request
from roughcontact.io.scale import given_step
from roughcontact.io.units import is_length, metres

_REACH = 2.0  # steps from the nearest point beyond which a grid point counts as not measured


def resample_evenly(channel: Channel, request: Request) -> tuple[Channel, Request, list[str]]:
    """Return the channel on an even grid, the request less the steps used, and how it was resampled.

    Heights are linear within the triangles of Delaunay (1934, Bulletin de l'Académie des Sciences de l'URSS
    6, 793), of a profile between neighbours; none outside, or further than two steps from any point. A step
    that is not given is sqrt(area / number), the same along x and y. The list of sentences is empty where the
    channel was not resampled.

    Examples
    --------
    >>> from roughcontact.io.channels import Points
    >>> x = np.array([0.0, 1.0, 3.0, 4.0])
    >>> points = Points(x, None, 10 * x, "the positions along x are not evenly spaced")
    >>> trace = Channel("height", (1, 4), lambda: None, points=points)
    >>> gridded, _, done = resample_evenly(trace, Request(resample="linear", dx=2.0, unit="m"))
    >>> gridded.read(), gridded.dx
    (array([[ 0., 20., 40.]]), 2.0)
    """
    if channel.points is None:
        return channel, request, []
    x, y, z, uneven = channel.points
    if request.resample is None:
        raise refusal("uneven positions", uneven=uneven)
    positions = [x] if y is None else [x, y]
    steps = [given_step("dx", request), given_step("dy", request)]
    if any(steps):  # positions and steps in `unit`
        if request.unit is None and not is_length(channel.lateral_unit):
            raise InputFileError("the file does not say the unit of its positions; give unit", keys=["unit"])
        unit = request.unit or "m"
        factor = metres(channel.lateral_unit) / metres(unit) if is_length(channel.lateral_unit) else 1.0
        positions = [coords * factor for coords in positions]
        steps = [step and step / metres(unit) for step in steps]
        channel = replace(channel, lateral_unit=unit)
    if z.size < 2 + len(positions):
        raise HeightMapError(f"{z.size} points are too few to be resampled; measure again")
    along, heights = _interpolated(positions, z, steps)
    dx, dy = [*(float(axis[1] - axis[0]) for axis in along), None][:2]
    first_x, first_y = [*(float(axis[0]) for axis in along), None][:2]
    channel = replace(channel, shape=heights.shape, read=heights.copy, points=None)
    channel = replace(channel, dx=dx, dy=dy, first_x=first_x, first_y=first_y)
    size = " x ".join(str(axis.size) for axis in reversed(along))
    how = f"{z.size} points interpolated linearly to {size} on an even grid"
    note = f"{uneven}: resampled as asked, {how}, which lowers slopes and peak pressures"
    return channel, replace(request, dx=None, dy=None), [note]


def _interpolated(positions, z, steps):
    """Return the positions of the grid along x (and y), and the heights (ny, nx) there."""
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import QhullError, cKDTree

    extent = np.prod([np.ptp(coords) for coords in positions])
    if not extent > 0:
        raise HeightMapError("all points lie on one line; give the file as a profile (x, z)")
    mean = extent / (z.size - 1) if len(positions) == 1 else np.sqrt(extent / z.size)
    dx, dy = steps
    steps = (dx or dy or mean, dy or dx or mean)[: len(positions)]
    along = [_grid(coords, step) for coords, step in zip(positions, steps, strict=True)]
    check_points((prod(axis.size for axis in along[1:]), along[0].size))
    # in steps from the middle: the triangulation matches the grid, and rounding errors are small
    middle = [coords.mean() for coords in positions]
    points = (np.column_stack(positions) - middle) / steps
    grid = np.meshgrid(*((axis - low) / step for axis, low, step in zip(along, middle, steps, strict=True)))
    if len(positions) == 1:
        order = np.argsort(positions[0], kind="stable")
        heights = np.interp(along[0], positions[0][order], z[order])
    else:
        try:
            heights = LinearNDInterpolator(points, z)(*grid)
        except QhullError as error:
            raise HeightMapError("all points lie on one line; give the file as a profile") from error
    # triangles span holes in the data, where nothing was measured
    distance, _ = cKDTree(points).query(np.column_stack([coords.ravel() for coords in grid]), workers=1)
    heights[distance.reshape(heights.shape) > _REACH] = np.nan
    return along, np.atleast_2d(heights)


def _grid(positions, step):
    """Return the points of an even grid within the positions, centred among them."""
    low, high = positions.min(), positions.max()
    # a field of exactly so many steps may be one rounding error short of them
    intervals = int(np.floor((high - low) / step * (1 + 1e-9)))
    if intervals < 1:
        raise HeightMapError(f"a step of {step:g} is longer than the field of {high - low:g}")
    return (low + high) / 2 + step * (np.arange(intervals + 1) - intervals / 2)
