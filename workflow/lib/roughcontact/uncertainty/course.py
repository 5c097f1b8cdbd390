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
from roughcontact.surface.window.instrument import stated_instrument
from roughcontact.surface.window.periodic_window import subwindow
from roughcontact.surface.window.transfer import undone
from roughcontact.uncertainty import combination
from roughcontact.uncertainty.combination import Component, Components, half_widths, symmetric
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.inputs import AMPLIFICATIONS, INPUTS, amplified, instrument_components, varied
from roughcontact.uncertainty.overview import own_place, windows_of_places
from roughcontact.uncertainty.random_effects import student
from roughcontact.uncertainty.scales import to_scale
from roughcontact.uncertainty.subwindows import divided, relevelled

MAX_PARTS = 9

Run = partial[xr.Dataset]  # the course on a window, whose arguments, by their names, may be replaced


def with_ends(course: xr.Dataset, causes: Iterable[Components]) -> xr.Dataset:
    """Return a course with both ends of its answers, by the independent causes of their ±."""
    for name, total in combination.sum_of_causes(causes).items():
        bounds = combination.interval_bounds(name, to_scale(name, course[name].values), total)
        for end, bound in zip(ENDS[1:], bounds, strict=True):
            course = course.assign({f"{name}{end}": (course[name].dims, bound)})
    return course


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


def scatter_of_mean(members: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the half-width of the mean of members, on the scales, by Student's t."""
    factor = float(student(np.array(len(members) - 1))) / math.sqrt(len(members))
    return factor * xr.concat(members, "member").std("member", ddof=1, skipna=False)


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
        the course on another window.
    names : sequence of str
        the answers.
    settings : mapping
        sections `contact` and `instrument` of the settings.
    as_measured : DataArray, optional
        the window before a correction for the instrument.
    inputs : iterable of str
        those that count (`uncertainty.inputs`).
    """
    parts = levelled_parts(window)
    part, instrument = parts[0], stated_instrument(window, settings["instrument"])
    courses = [run(each) for each in parts]
    on_parts = [on_scales(course, names) for course in courses]
    causes = [components_of(symmetric, 2 * abs(on_scales(run(refined(part, 2)), names) - on_parts[0]))]
    if len(parts) > 1:
        scatter = scatter_of_mean(on_parts)
        # the largest pressure is that of one part, and scatters as in one; all others are means
        causes.append(components_of(symmetric, scatter.assign({PEAK: math.sqrt(len(parts)) * scatter[PEAK]})))

    def values_of(course: xr.Dataset) -> dict[str, np.ndarray]:
        return {name: course[name].values for name in names}

    def solve(face: xr.DataArray, *_: Any, **__: Any) -> dict[str, np.ndarray]:
        return values_of(run(face))

    result = Result(part, {"mean_pressure": np.nan}, values_of(courses[0]), solve)
    measured_part = None if as_measured is None else levelled_parts(as_measured)[0]
    causes += instrument_components(result, instrument, measured_part, undone(part, instrument))[0]
    for key in inputs:
        factors = ends(1.0, settings["contact"].get(name_of_range(key)) or instrument.get(key))
        if factors[0] == factors[1]:
            continue
        if key in AMPLIFICATIONS:
            at_ends = [run(amplified(part, key, factor)) for factor in factors]
        else:
            at_ends = [run(part, **varied(run.keywords, key, factor)) for factor in factors]
        both = (
            xr.concat([on_parts[0], *(on_scales(course, names) for course in at_ends)], "end") - on_parts[0]
        )
        causes.append(
            components_of(lambda change: half_widths(-change.min(axis=0), change.max(axis=0)), both)
        )
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
    touching = run.keywords["mean_pressure"] * (rms_gradient(windows[0]) / rms_gradient(window))
    without_peak = [name for name in names if name != PEAK]
    of_map, *of_places = (on_scales(run(piece, mean_pressure=touching), without_peak) for piece in windows)
    changes = [of_place - of_map for of_place in of_places]
    return [
        components_of(combination.one_sided, xr.concat(changes, "place").mean("place", skipna=False)),
        components_of(symmetric, scatter_of_mean(changes)),
    ]
