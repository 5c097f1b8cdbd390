"""The ± of what runs over a distance or a speed: by parts, an overview, finer pixels, the instrument."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import ENDS, PEAK
from roughcontact.arguments.maps import refined, side_lengths, spacing
from roughcontact.arguments.ranges import ends, name_of_range
from roughcontact.surface.faces.placing import measured_rectangle
from roughcontact.surface.levelling.forms import form_order
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window.instrument import stated_instrument
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

Run = Callable[..., xr.Dataset]  # the course on a window, with inputs, by their names, so many times as large


def with_ends(
    course: xr.Dataset,
    window: xr.DataArray,
    run: Run,
    names: Sequence[str],
    settings: Mapping[str, Mapping[str, Any]],
    *,
    inputs: Iterable[str] = INPUTS,
    as_measured: xr.DataArray | None = None,
    levelled: xr.DataArray | None = None,
    overviews: Sequence[xr.DataArray] = (),
    causes: Iterable[Components] = (),
) -> xr.Dataset:
    """Return the course of a window with both ends of answers, by the independent causes of their ±.

    These are Student's factor of the scatter of the parts; on the first part, which stands for all, twice
    what pixels half as large change, what noise, lens, tip and rounding of the instrument do
    (`instrument_components`), and both ends of each input whose range the `settings` of the contact or the
    instrument state; the places of the largest overview; and `causes` of the course itself. Closed gaps and
    infinite conductances have no scale, and no ends.

    Parameters
    ----------
    course, window : Dataset, DataArray (y, x; m)
        the answers and the face that has them.
    run : callable
        the course on another window, with inputs by their names (`uncertainty.inputs`) as factors of what is
        stated; it may be coarser than `course`.
    names : sequence of str
        the answers.
    settings : mapping
        sections `contact` and `instrument` of the settings.
    inputs : iterable of str
        those of which `run` takes a factor.
    as_measured, levelled : DataArray, optional
        the window before a correction for the instrument; the map of which it is a part.
    overviews : sequence of DataArray
        coarser maps around `levelled`.
    causes : iterable of components
        half-widths by answer.
    """
    of_parts = _components_of_parts(window, run, names, settings, inputs, as_measured)
    of_places = _components_of_places(window, run, names, levelled, overviews)
    columns: dict[str, tuple] = {}
    for name, total in sum_of_causes([*of_parts, *of_places, *causes]).items():
        bounds = interval_bounds(name, to_scale(name, course[name].values), total)
        columns |= {f"{name}{k}": (course[name].dims, end) for k, end in zip(ENDS[1:], bounds, strict=True)}
    return course.assign(columns)


def levelled_parts(window: xr.DataArray) -> list[xr.DataArray]:
    """Return the parts of a window, each levelled by a plane and periodic."""
    region = {axis: slice(0, points) for axis, points in zip("yx", window.shape, strict=True)}
    areas = divided(region, spacing(window), MAX_PARTS)
    return [subwindow(relevelled(window.isel(area), 1)) for area in areas]


def change(name: str, other: xr.Dataset, course: xr.Dataset) -> np.ndarray:
    """Return the change of an answer from a course to another one, on its scale."""
    with np.errstate(invalid="ignore"):
        return to_scale(name, other[name].values) - to_scale(name, course[name].values)


def _components_of_parts(
    window: xr.DataArray,
    run: Run,
    names: Sequence[str],
    settings: Mapping[str, Mapping[str, Any]],
    inputs: Iterable[str],
    as_measured: xr.DataArray | None,
) -> list[Components]:
    """Return what the parts tell: their scatter, and on the first one pixels, instrument, stated ranges."""
    cut = levelled_parts(window)
    part, instrument = cut[0], stated_instrument(window, settings["instrument"])
    courses, finer = [run(each) for each in cut], run(refined(part, 2))
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

    def solve(other: xr.DataArray, *_: Any, **__: Any) -> dict[str, np.ndarray]:
        course = run(other)
        return {name: course[name].values for name in names}

    values = {name: courses[0][name].values for name in names}
    result = Result(part, {"mean_pressure": np.nan}, values, solve)
    before = None if as_measured is None else levelled_parts(as_measured)[0]
    causes += instrument_components(result, instrument, before, undone(part, instrument))[0]
    for key in inputs:
        shares = settings["contact"].get(name_of_range(key)) or instrument.get(key)
        low, high = ends(1.0, shares)
        if low < high:
            at_ends = courses[0], *(_at_factor(run, part, key, factor) for factor in (low, high))
            both = {name: [change(name, end, courses[0]) for end in at_ends] for name in names}
            causes.append({k: half_widths(-np.min(v, axis=0), np.max(v, axis=0)) for k, v in both.items()})
    return causes


def _at_factor(run: Run, window: xr.DataArray, key: str, factor: float) -> xr.Dataset:
    """Return the course with an input so many times as large; those of the scales are in the window."""
    if key not in AMPLIFICATIONS:
        return run(window, **{key: factor})
    heights, lengths = (factor if key == name else 1.0 for name in AMPLIFICATIONS)
    scaled = {axis: lengths * window[axis] for axis in window.dims}
    return run(window.copy(data=heights * window.values).assign_coords(scaled))


def _components_of_places(
    window: xr.DataArray,
    run: Run,
    names: Sequence[str],
    levelled: xr.DataArray | None,
    overviews: Sequence[xr.DataArray],
) -> list[Components]:
    """Return what the places of the largest overview change from that of the map: mean and scatter.

    Their load is that of the map by the gradient, so that coarser pixels touch as much. Of the largest
    pressure an overview tells less than the map.
    """
    if levelled is None or not overviews:
        return []
    fine = measured_rectangle(levelled)
    overview = max(overviews, key=lambda field: math.prod(side_lengths(field)))
    own, _ = own_place(fine, overview, overviews)
    pieces = [own, *(overview.isel(place) for place in windows_of_places(own.shape, overview))]
    windows = [subwindow(relevelled(piece, form_order(fine))) for piece in pieces]
    touching = rms_gradient(windows[0]) / rms_gradient(window)
    of_map, *others = (run(piece, mean_pressure=touching) for piece in windows)
    factor = float(student(np.array(len(others) - 1.0))) / math.sqrt(len(others))
    changes = {
        name: np.array([change(name, other, of_map) for other in others]) for name in names if name != PEAK
    }
    return [
        {name: one_sided(numbers.mean(axis=0)) for name, numbers in changes.items()},
        {name: symmetric(factor * numbers.std(axis=0, ddof=1)) for name, numbers in changes.items()},
    ]
