"""Points that lie on no even grid, interpolated to one: only where the user asks for it.

Interpolation between points lowers slopes and with them the pressures, so it never happens by itself.
"""

import numpy as np

from roughcontact.errors import HeightMapError
from roughcontact.io.channels import Channel
from roughcontact.io.guards import check_points

_REACH = 2.0  # steps from the nearest point, beyond which a grid point counts as not measured


def resampled(channel: Channel, steps: tuple[float | None, float | None], where) -> tuple[Channel, str]:
    """Return a channel on an even grid and a sentence that says what was done.

    Heights are linear within the triangles of Delaunay's triangulation (of a profile: between neighbours).
    Outside them, and further than two steps from any point, the grid stays without heights.

    Parameters
    ----------
    channel : Channel
        With `points`.
    steps : (dx, dy), in the channel's lateral unit
        Of the even grid; None: the mean distance of the points, sqrt(area / number), the same along x and y.
    where : path, for messages

    Raises
    ------
    HeightMapError
        for fewer than four points, or points on one line.

    Source: B. Delaunay (1934), Bull. Acad. Sci. URSS 793; SciPy's LinearNDInterpolator.
    """
    x, y, z = channel.points
    if z.size < (3 if y is None else 4):
        raise HeightMapError(f"{where}: {z.size} points are too few to be resampled; measure again")
    along_x, along_y, heights = (_profile if y is None else _map)(x, y, z, steps, where)
    gridded = Channel(
        channel.name,
        heights.shape,
        lambda: heights.copy(),
        height_unit=channel.height_unit,
        dx=float(along_x[1] - along_x[0]),
        dy=None if y is None else float(along_y[1] - along_y[0]),
        lateral_unit=channel.lateral_unit,
        first_x=float(along_x[0]),
        first_y=None if y is None else float(along_y[0]),
        no_height=channel.no_height,
        notes=list(channel.notes),
    )
    size = f"{heights.shape[1]}" if y is None else f"{heights.shape[0]} x {heights.shape[1]}"
    return gridded, (
        f"{channel.uneven}: resampled as asked, {z.size} points interpolated linearly to {size} on an even "
        "grid, which lowers slopes and peak pressures"
    )


def _profile(x, _, z, steps, where):
    order = np.argsort(x, kind="stable")
    x, z = x[order], z[order]
    step = steps[0] or (x[-1] - x[0]) / (x.size - 1)
    grid = _grid(x, step, where)
    check_points((1, grid.size), where)
    heights = np.interp(grid, x, z)
    nearest = np.clip(np.searchsorted(x, grid), 1, x.size - 1)
    away = np.minimum(np.abs(grid - x[nearest - 1]), np.abs(grid - x[nearest]))
    heights[away > _REACH * step] = np.nan
    return grid, None, heights[None, :]


def _map(x, y, z, steps, where):
    from scipy.interpolate import LinearNDInterpolator
    from scipy.spatial import QhullError, cKDTree

    area = np.ptp(x) * np.ptp(y)
    if not area > 0:
        raise HeightMapError(f"{where}: all points lie on one line; give the file as a profile (x, z)")
    dx, dy = steps
    dx = dx or dy or np.sqrt(area / z.size)
    dy = dy or dx
    along_x, along_y = _grid(x, dx, where), _grid(y, dy, where)
    check_points((along_y.size, along_x.size), where)
    # in steps and from the middle, so that triangles are those of the grid and rounding is small
    scaled = np.column_stack([(x - x.mean()) / dx, (y - y.mean()) / dy])
    grid = np.meshgrid((along_x - x.mean()) / dx, (along_y - y.mean()) / dy)
    try:
        heights = LinearNDInterpolator(scaled, z)(*grid)
    except QhullError as error:
        raise HeightMapError(f"{where}: all points lie on one line; give the file as a profile") from error
    distance, _ = cKDTree(scaled).query(np.column_stack([part.ravel() for part in grid]), workers=1)
    heights[distance.reshape(heights.shape) > _REACH] = np.nan
    return along_x, along_y, heights


def _grid(positions, step, where):
    """Return the points of an even grid within the positions, centred among them."""
    low, high = positions.min(), positions.max()
    intervals = int(np.floor((high - low) / step * (1 + 1e-9)))
    if intervals < 1:
        raise HeightMapError(f"{where}: a step of {step:g} is longer than the field of {high - low:g}")
    return (low + high) / 2 + step * (np.arange(intervals + 1) - intervals / 2)
