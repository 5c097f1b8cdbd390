"""The ± of what runs over a distance or a speed: by the parts of the window, and by finer pixels on one."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ENDS, PEAK
from roughcontact.arguments.maps import refined, spacing
from roughcontact.surface.window.periodic_window import subwindow
from roughcontact.uncertainty.random_effects import student
from roughcontact.uncertainty.scales import from_scale, to_scale
from roughcontact.uncertainty.subwindows import divided, relevelled

MAX_PARTS = 9


def levelled_parts(window: xr.DataArray) -> list[xr.DataArray]:
    """Return the parts of a window, each levelled by a plane and periodic."""
    region = {axis: slice(0, points) for axis, points in zip("yx", window.shape, strict=True)}
    areas = divided(region, spacing(window), MAX_PARTS)
    return [subwindow(relevelled(window.isel(area), 1)) for area in areas]


def squared_change(name: str, other: xr.Dataset, course: xr.Dataset) -> np.ndarray:
    """Return the squared change of an answer from a course to another one, on its scale."""
    with np.errstate(invalid="ignore"):
        return (to_scale(name, other[name].values) - to_scale(name, course[name].values)) ** 2


def squared_widths(
    window: xr.DataArray, run: Callable[[xr.DataArray], xr.Dataset], names: Sequence[str]
) -> dict[str, np.ndarray]:
    """Return the squared half-widths of answers by the courses on the parts of a window, on the scales.

    Twice what pixels half as large change on the first part, which stands for all, and Student's factor of
    the scatter of the parts.
    """
    cut = levelled_parts(window)
    courses, finer = [run(part) for part in cut], run(refined(cut[0], 2))
    squares = {}
    for name in names:
        squares[name] = 4 * squared_change(name, finer, courses[0])
        if len(courses) > 1:
            with np.errstate(invalid="ignore"):
                scatter = np.var([to_scale(name, course[name].values) for course in courses], axis=0, ddof=1)
            # the largest pressure is that of one part, and scatters as in one; all others are means
            averaged = 1 if name == PEAK else len(courses)
            squares[name] += float(student(np.array(len(courses) - 1.0))) ** 2 * scatter / averaged
    return squares


def with_ends(course: xr.Dataset, squares: Mapping[str, np.ndarray]) -> xr.Dataset:
    """Return a course with both ends of answers, by their squared half-widths on the scales.

    Closed gaps and infinite conductances have no scale, and no ends.
    """
    with np.errstate(invalid="ignore"):
        ends = {
            f"{name}{suffix}": (
                course[name].dims,
                from_scale(name, to_scale(name, course[name].values) + sign * np.sqrt(square)),
            )
            for name, square in squares.items()
            for suffix, sign in zip(ENDS[1:], (-1, 1), strict=True)
        }
    return course.assign(ends)
