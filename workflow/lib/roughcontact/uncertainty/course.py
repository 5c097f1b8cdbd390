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
    Component,
    Components,
    half_widths,
    interval_bounds,
    one_sided,
    sum_of_causes,
    symmetric,
)
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.inputs import AMPLIFICATIONS, INPUTS, amplified
from roughcontact.uncertainty.instrument import instrument_components
from roughcontact.uncertainty.overview import own_place, windows_of_places
from roughcontact.uncertainty.random_effects import student
from roughcontact.uncertainty.scales import to_scale
from roughcontact.uncertainty.subwindows import divided, relevelled

MAX_PARTS = 9

Run = Callable[..., xr.Dataset]  # the course on a window, with inputs, by their names, so many times as large


def with_ends(course: xr.Dataset, names: Sequence[str], causes: Iterable[Components]) -> xr.Dataset:
    """Return a course with both ends of these answers, by the independent causes of their ±."""
    columns: dict[str, tuple] = {}
    for name, total in sum_of_causes(causes).items():
        bounds = interval_bounds(name, to_scale(name, course[name].values), total)
        columns |= {f"{name}{k}": (course[name].dims, end) for k, end in zip(ENDS[1:], bounds, strict=True)}
    return course.assign(columns)


def levelled_parts(window: xr.DataArray) -> list[xr.DataArray]:
    """Return the parts of a window, each levelled by a plane and periodic."""
    region = {axis: slice(0, points) for axis, points in zip("yx", window.shape, strict=True)}
    areas = divided(region, spacing(window), MAX_PARTS)
    return [subwindow(relevelled(window.isel(area), 1)) for area in areas]


def on_scales(course: xr.Dataset, names: Iterable[str]) -> xr.Dataset:
    """Return answers of a course, each on its scale; NaN for closed gaps and infinite conductances."""
    scaled = course[[*names]].map(lambda answer: to_scale(answer.name, answer.values))
    return scaled.where(np.isfinite(scaled))


def components_of(form: Callable[[np.ndarray], Component], changes: xr.Dataset) -> Components:
    """Return the components of this form of all answers, from their changes on the scales."""
    return {str(name): form(change.values) for name, change in changes.items()}


def causes_of_parts(
    window: xr.DataArray,
    run: Run,
    names: Sequence[str],
    settings: Mapping[str, Mapping[str, Any]],
    *,
    as_measured: xr.DataArray | None = None,
    inputs: Iterable[str] = INPUTS,
) -> list[Components]:
    """Return what the parts of a window tell, on the scales of the answers.

    These are Student's factor of their scatter, and on the first part, which stands for all, twice what
    pixels half as large change, what noise, lens, tip and rounding of the instrument do
    (`instrument_components`), and both ends of each input whose range the `settings` of the contact or the
    instrument state. Closed gaps and infinite conductances have no scale, and no ends.

    Parameters
    ----------
    window : DataArray (y, x; m)
        the face.
    run : callable
        the course on another window, with inputs by their names (`uncertainty.inputs`) as factors of what is
        stated.
    names : sequence of str
        the answers.
    settings : mapping
        sections `contact` and `instrument` of the settings.
    as_measured : DataArray, optional
        the window before a correction for the instrument.
    inputs : iterable of str
        those of which `run` takes a factor.
    """
    cut = levelled_parts(window)
    part, instrument = cut[0], stated_instrument(window, settings["instrument"])
    courses = [run(each) for each in cut]
    on_part, *on_others = (on_scales(course, names) for course in courses)
    finer = on_scales(run(refined(part, 2)), names)
    causes = [components_of(symmetric, 2 * abs(finer - on_part))]
    if on_others:
        factor = float(student(np.array(float(len(on_others)))))
        scatter = factor * xr.concat([on_part, *on_others], "part").std("part", ddof=1, skipna=False)
        # the largest pressure is that of one part, and scatters as in one; all others are means
        means = scatter.drop_vars(PEAK) / math.sqrt(len(courses))
        causes.append(components_of(symmetric, scatter[[PEAK]].merge(means)))

    def solve(other: xr.DataArray, *_: Any, **__: Any) -> dict[str, np.ndarray]:
        course = run(other)
        return {name: course[name].values for name in names}

    values = {name: courses[0][name].values for name in names}
    result = Result(part, {"mean_pressure": np.nan}, values, solve)
    measured_part = None if as_measured is None else levelled_parts(as_measured)[0]
    causes += instrument_components(result, instrument, measured_part, undone(part, instrument))[0]
    for key in inputs:
        low, high = ends(1.0, settings["contact"].get(name_of_range(key)) or instrument.get(key))
        if low < high:
            at_ends = (
                run(amplified(part, key, factor)) if key in AMPLIFICATIONS else run(part, **{key: factor})
                for factor in (low, high)
            )
            changes = xr.concat([on_part, *(on_scales(course, names) for course in at_ends)], "end") - on_part
            causes.append(components_of(lambda c: half_widths(-c.min(axis=0), c.max(axis=0)), changes))
    return causes


def causes_of_places(
    window: xr.DataArray,
    run: Run,
    names: Iterable[str],
    levelled: xr.DataArray,
    overviews: Sequence[xr.DataArray],
) -> list[Components]:
    """Return what the places of the largest overview change from that of the map: mean and scatter.

    The overviews lie around `levelled`, of which the window is a part. Their load is that of the map by the
    gradient, so that coarser pixels touch as much. Of the largest pressure an overview tells less.
    """
    fine = measured_rectangle(levelled)
    overview = max(overviews, key=lambda field: math.prod(side_lengths(field)))
    own, _ = own_place(fine, overview, overviews)
    pieces = [own, *(overview.isel(place) for place in windows_of_places(own.shape, overview))]
    windows = [subwindow(relevelled(piece, form_order(fine))) for piece in pieces]
    touching = rms_gradient(windows[0]) / rms_gradient(window)
    of_map, *of_places = (
        on_scales(run(piece, mean_pressure=touching), [name for name in names if name != PEAK])
        for piece in windows
    )
    factor = float(student(np.array(len(of_places) - 1.0))) / math.sqrt(len(of_places))
    changes = xr.concat(of_places, "place") - of_map
    return [
        components_of(one_sided, changes.mean("place", skipna=False)),
        components_of(symmetric, factor * changes.std("place", ddof=1, skipna=False)),
    ]
