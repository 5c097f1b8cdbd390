"""The ± of what runs over a distance or a speed: by parts, an overview, finer pixels, the instrument."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ENDS, PEAK
from roughcontact.arguments.maps import refined, side_lengths, spacing
from roughcontact.arguments.ranges import ends, name_of_range
from roughcontact.surface.faces.placing import measured_rectangle
from roughcontact.surface.levelling.forms import form_order
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window.periodic_window import subwindow
from roughcontact.surface.window.transfer import undone
from roughcontact.uncertainty.combination import (
    Components,
    half_widths,
    interval_bounds,
    one_sided,
    sum_of_causes,
    symmetric,
)
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.inputs import AMPLIFICATIONS, INPUTS
from roughcontact.uncertainty.instrument import instrument_components
from roughcontact.uncertainty.overview import own_place, windows_of_places
from roughcontact.uncertainty.random_effects import student
from roughcontact.uncertainty.scales import to_scale
from roughcontact.uncertainty.subwindows import divided, relevelled

MAX_PARTS = 9

Run = Callable[[xr.DataArray], xr.Dataset]  # the course on a window


def levelled_parts(window: xr.DataArray) -> list[xr.DataArray]:
    """Return the parts of a window, each levelled by a plane and periodic."""
    region = {axis: slice(0, points) for axis, points in zip("yx", window.shape, strict=True)}
    areas = divided(region, spacing(window), MAX_PARTS)
    return [subwindow(relevelled(window.isel(area), 1)) for area in areas]


def change(name: str, other: xr.Dataset, course: xr.Dataset) -> np.ndarray:
    """Return the change of an answer from a course to another one, on its scale."""
    with np.errstate(invalid="ignore"):
        return to_scale(name, other[name].values) - to_scale(name, course[name].values)


def runs_at_ends(
    run: Callable[..., xr.Dataset],
    contact: Mapping[str, Any],
    instrument: Mapping[str, Any],
    *,
    inputs: Iterable[str] = INPUTS,
) -> list[tuple[Run, Run]]:
    """Return the courses at both ends of each input whose range is stated of the contact or the instrument.

    `run` takes a window and, by their names (`uncertainty.inputs`), inputs over what is stated; those of the
    scales of the map are in the window already.
    """
    limits = {key: contact.get(name_of_range(key)) or instrument.get(key) for key in inputs}

    def at(window: xr.DataArray, *, key: str, factor: float) -> xr.Dataset:
        if key not in AMPLIFICATIONS:
            return run(window, **{key: factor})
        heights, lengths = (factor if key == name else 1.0 for name in AMPLIFICATIONS)
        scaled = {axis: lengths * window[axis] for axis in window.dims}
        return run(window.copy(data=heights * window.values).assign_coords(scaled))

    return [
        (partial(at, key=key, factor=low), partial(at, key=key, factor=high))
        for key, shares in limits.items()
        for low, high in [ends(1.0, shares)]
        if low < high
    ]


def components_of_parts(
    window: xr.DataArray,
    run: Run,
    names: Sequence[str],
    *,
    instrument: Mapping[str, Any],
    as_measured: xr.DataArray | None = None,
    ends_of_inputs: Iterable[tuple[Run, Run]] = (),
) -> Components:
    """Return the components of answers by the courses on the parts of a window.

    Student's factor of the scatter of the parts; and on the first part, which stands for all, twice what
    pixels half as large change, what noise, lens, tip and rounding of an instrument do
    (`instrument_components`), and both ends of each stated input (`runs_at_ends`). `as_measured` is the
    window before a correction for the instrument.
    """
    cut = levelled_parts(window)
    courses, finer = [run(part) for part in cut], run(refined(cut[0], 2))
    causes: list[Components] = [
        {name: symmetric(2 * np.abs(change(name, finer, courses[0]))) for name in names}
    ]
    if len(courses) > 1:
        factor = float(student(np.array(len(courses) - 1.0)))
        for name in names:
            with np.errstate(invalid="ignore"):
                scatter = np.std([to_scale(name, course[name].values) for course in courses], axis=0, ddof=1)
            # the largest pressure is that of one part, and scatters as in one; all others are means
            averaged = 1 if name == PEAK else len(courses)
            causes.append({name: symmetric(factor * scatter / np.sqrt(averaged))})

    def solve(part: xr.DataArray, *_: Any, **__: Any) -> dict[str, np.ndarray]:
        course = run(part)
        return {name: course[name].values for name in names}

    values = {name: courses[0][name].values for name in names}
    result = Result(cut[0], {"mean_pressure": np.nan}, values, solve)
    before = None if as_measured is None else levelled_parts(as_measured)[0]
    causes += instrument_components(result, instrument, before, undone(cut[0], instrument))[0]
    for runs in ends_of_inputs:
        at_ends = courses[0], *(end(cut[0]) for end in runs)
        changes = {name: np.array([change(name, course, courses[0]) for course in at_ends]) for name in names}
        causes.append({k: half_widths(-both.min(axis=0), both.max(axis=0)) for k, both in changes.items()})
    return sum_of_causes(causes)


def components_of_places(
    window: xr.DataArray,
    run: Callable[..., xr.Dataset],
    names: Iterable[str],
    *,
    levelled: xr.DataArray | None,
    overviews: Sequence[xr.DataArray],
    load: float,
) -> list[Components]:
    """Return what the places of the largest overview (y, x; m) change from that of the map: mean and scatter.

    `run` takes a window and its mean pressure, the `load` (Pa) by the gradient, so that places of coarser
    pixels touch as much as the map. Of the largest pressure an overview tells less than the map.
    """
    if levelled is None or not overviews:
        return []
    fine = measured_rectangle(levelled)
    overview = max(overviews, key=lambda field: math.prod(side_lengths(field)))
    own, _ = own_place(fine, overview, overviews)
    pieces = [own, *(overview.isel(place) for place in windows_of_places(own.shape, overview))]
    windows = [subwindow(relevelled(piece, form_order(fine))) for piece in pieces]
    touching = load * rms_gradient(windows[0]) / rms_gradient(window)
    of_map, *others = (run(piece, mean_pressure=touching) for piece in windows)
    factor = float(student(np.array(len(others) - 1.0))) / math.sqrt(len(others))
    changes = {
        name: np.array([change(name, other, of_map) for other in others]) for name in names if name != PEAK
    }
    return [
        {name: one_sided(numbers.mean(axis=0)) for name, numbers in changes.items()},
        {name: symmetric(factor * numbers.std(axis=0, ddof=1)) for name, numbers in changes.items()},
    ]


def with_ends(course: xr.Dataset, causes: Iterable[Components]) -> xr.Dataset:
    """Return a course with both ends of answers, by the independent causes of their ±.

    Closed gaps and infinite conductances have no scale, and no ends.
    """
    columns: dict[str, tuple] = {}
    for name, total in sum_of_causes(causes).items():
        bounds = interval_bounds(name, to_scale(name, course[name].values), total)
        columns |= {f"{name}{k}": (course[name].dims, end) for k, end in zip(ENDS[1:], bounds, strict=True)}
    return course.assign(columns)
