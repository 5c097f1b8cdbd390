"""The ± of what runs over a distance or a speed: by the parts of the window, and by finer pixels on one."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import PEAK
from roughcontact.arguments.maps import spacing
from roughcontact.surface.levelling.polynomial import fit_polynomial
from roughcontact.surface.window.periodic_window import subwindow
from roughcontact.uncertainty.random_effects import student
from roughcontact.uncertainty.scales import from_scale, to_scale
from roughcontact.uncertainty.subwindows import divided

MAX_PARTS = 9


def levelled_parts(window: xr.DataArray) -> list[xr.DataArray]:
    """Return the parts of a window, each levelled by a plane and periodic."""
    region = {axis: slice(0, points) for axis, points in zip("yx", window.shape, strict=True)}
    parts = []
    for area in divided(region, spacing(window), MAX_PARTS):
        part = window.isel(area)
        axes = [np.arange(points, dtype=float) for points in part.shape]
        parts.append(
            subwindow(part.copy(data=part.values - fit_polynomial(part.values.copy(), axes, order=1)[0]))
        )
    return parts


def squared_change(name: str, other: xr.Dataset, course: xr.Dataset) -> np.ndarray:
    """Return the squared change of an answer from a course to another one, on its scale."""
    with np.errstate(invalid="ignore"):
        return (to_scale(name, other[name].values) - to_scale(name, course[name].values)) ** 2


def squared_width(name: str, parts: Sequence[xr.Dataset], finer: xr.Dataset) -> np.ndarray:
    """Return the squared half-width of an answer by its courses on the parts of a window, on its scale.

    Twice what pixels half as large change (`finer`) on the first part, which stands for all, and Student's
    factor of the scatter of the parts.
    """
    square = 4 * squared_change(name, finer, parts[0])
    if len(parts) > 1:
        with np.errstate(invalid="ignore"):
            scatter = np.var([to_scale(name, part[name].values) for part in parts], axis=0, ddof=1)
        # the largest pressure is that of one part, and scatters as in one; all others are means
        averaged = 1 if name == PEAK else len(parts)
        square = square + float(student(np.array(len(parts) - 1.0))) ** 2 * scatter / averaged
    return square


def with_ends(course: xr.Dataset, squares: Mapping[str, np.ndarray]) -> xr.Dataset:
    """Return a course with both ends of answers, by their squared half-widths on the scales.

    Closed gaps and infinite conductances have no scale, and no ends.
    """
    with np.errstate(invalid="ignore"):
        ends = {
            f"{name}_{end}": (
                course[name].dims,
                from_scale(name, to_scale(name, course[name].values) + sign * np.sqrt(square)),
            )
            for name, square in squares.items()
            for end, sign in (("lower", -1), ("upper", 1))
        }
    return course.assign(ends)
