"""What a run solves over a distance or a speed: a face that wears, rubber that slides, each with its ±.

The `uncertainty.sources` that the settings name, on the scale of each answer, added by their squares: twice
what pixels half as large change, what the instrument does, and both ends of stated loads, moduli, hardness
and scales, on one part; and the scatter of the parts of the window, each by itself.

Of wear, as its solver, what half as many steps and a solver of ten times the tolerance change, which the
bound of the heights does not say of a contact area. The wear coefficient counts only through its product with
the distance, so that its range moves the axis of distances alone, and with it the distance at which the face
is run in.

Of sliding, the bound of the solver, of the friction alone; what the places of an overview change; and, as the
material, the share of the friction at frequencies beyond the table of the relaxation, as if nothing were
known there. Waves that the map does not resolve are not in it: `friction_share_of_octave` shows what the
shortest ones carry.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, CONDUCTANCE, ENDS, FRICTION, GAP, PEAK, PRESSURE
from roughcontact.arguments.bodies import relaxing_body
from roughcontact.arguments.kinds import Sections
from roughcontact.arguments.maps import refined, side_lengths, spacing
from roughcontact.arguments.ranges import ends, name_of_range
from roughcontact.arguments.relaxation import relaxation_of
from roughcontact.arguments.variables import describe
from roughcontact.statistics.precision import widened
from roughcontact.statistics.running_in import run_in
from roughcontact.statistics.sliding import BY_AREA, sliding_friction
from roughcontact.surface.faces.placing import measured_rectangle
from roughcontact.surface.levelling.forms import form_order
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window.instrument import stated_instrument
from roughcontact.surface.window.periodic_window import subwindow
from roughcontact.surface.window.transfer import undone
from roughcontact.uncertainty import combination
from roughcontact.uncertainty.budget import OF_MATERIAL
from roughcontact.uncertainty.combination import Component, Components, half_widths, symmetric
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.inputs import (
    HARDNESS,
    INPUTS,
    add_correction_source,
    instrument_components,
    varied,
)
from roughcontact.uncertainty.overview import own_place, windows_of_places
from roughcontact.uncertainty.random_effects import student
from roughcontact.uncertainty.scales import to_scale
from roughcontact.uncertainty.subwindows import divided, relevelled

DISTANCE = "running_in_distance"
WORN = (AREA, PRESSURE, PEAK, GAP, CONDUCTANCE, DISTANCE)
SLID = (FRICTION, AREA, PRESSURE, PEAK, GAP)
# of a part: the tolerance is twice that of the face
FEW_STEPS: dict[str, Any] = {"tolerance": 0.04, "solver_tolerance": 1e-3}
_ANSWERS_ALONE = {"flow": "never", "stress": "never"}  # statistics of a part
COARSE = 1e-3  # tolerance of sliding over a part
_OF_THE_CONTACT = ("contact_modulus", "bodies", "hardness", "influence", "zero_frequency")

Run = partial[xr.Dataset]  # the course on a window, whose arguments, by their names, may be replaced


class Face(NamedTuple):
    """What is solved, and the maps that tell how well it is known (y, x; m)."""

    window: xr.DataArray
    as_measured: xr.DataArray | None = None  # the window before a correction for the instrument
    levelled: xr.DataArray | None = None  # the map of which it is a part
    overviews: Sequence[xr.DataArray] = ()  # around that map


def worn_in_a_run(face: Face, settings: Sections, *, mean_pressure: float, threads: int = 1) -> xr.Dataset:
    """Return what `run_in` makes of the face by the settings, with the ends of the intervals.

    Its first distance is 0. `{answer}_lower` and `{answer}_upper` are over `sliding_distance`, those of
    `running_in_distance` are numbers, NaN where a part has none.
    """
    wear, contact = settings["wear"], settings["contact"]
    arguments = {"wear_coefficient": wear["coefficient"], "sliding_distance": [0.0, *wear["distance"]]}
    arguments |= {key: contact[key] for key in _OF_THE_CONTACT} | {"mean_pressure": mean_pressure}
    run: Run = partial(run_in, threads=threads, **arguments)
    coarse = partial(run, statistics=_ANSWERS_ALONE, **FEW_STEPS)
    worn = run(face.window, statistics=settings["statistics"])
    causes = causes_of_parts(face, coarse, WORN, settings)
    if "solver" in settings["uncertainty"]["sources"]:
        of_steps = on_scales(coarse(face.window), WORN) - on_scales(worn, WORN)
        causes.append(components_of(symmetric, abs(of_steps)))
    worn = with_ends(worn, WORN, causes)
    worn[f"{DISTANCE}_lower"] /= wear["coefficient_factor"]
    worn[f"{DISTANCE}_upper"] *= wear["coefficient_factor"]
    return describe(worn)


def slid_in_a_run(face: Face, settings: Sections, *, mean_pressure: float, threads: int = 1) -> xr.Dataset:
    """Return what `sliding_friction` makes of the face by the settings, with the ends of the intervals."""
    statistics, bodies = settings["statistics"], settings["contact"]["bodies"]
    rubber = relaxing_body(bodies)
    (stiff,) = (body for body in bodies if body is not rubber)
    arguments = {key: settings["sliding"][key] for key in ("speed", "direction")}
    # read once
    arguments["relaxation"] = relaxation_of(rubber["relaxation"], poissons_ratio=rubber["poissons_ratio"])
    run: Run = partial(sliding_friction, mean_pressure=mean_pressure, threads=threads, **arguments)
    conductivities = [body.get("thermal_conductivity") for body in (stiff, rubber)]
    friction = statistics["friction"] or {}
    slid = run(
        face.window,
        shear_strength=friction.get("shear_strength"),
        seal=statistics["seal"],
        thermal_conductivity=None if None in conductivities else conductivities,
    )
    coarse = partial(run, tolerance=COARSE, fields=False)
    causes = causes_of_parts(face, coarse, SLID, settings)
    bound = slid["hysteretic_friction_bound"] / slid[FRICTION]
    shares = {"solver": bound, "material": slid["friction_share_beyond_table"]}
    sources = settings["uncertainty"]["sources"]
    causes += [{FRICTION: symmetric(share.values)} for source, share in shares.items() if source in sources]
    causes += causes_of_places(face, coarse, SLID) if "window" in sources else []
    slid = with_ends(slid, SLID, causes)
    if BY_AREA in slid:
        by_area = [slid[BY_AREA] * (slid[f"{AREA}{suffix}"] / slid[AREA]) for suffix in ENDS]
        bounds = widened(by_area, ends(1.0, friction.get("shear_strength_uncertainty")))
        slid = with_bounds(slid, BY_AREA, bounds)
    return describe(slid)


def with_ends(course: xr.Dataset, names: Iterable[str], causes: Iterable[Components]) -> xr.Dataset:
    """Return a course with both ends of these answers, by the independent causes of their ±; NaN without."""
    totals = combination.sum_of_causes(causes)
    for name in names:
        value = to_scale(name, course[name].values)
        total = totals.get(name, np.full((4, *value.shape), np.nan))
        course = with_bounds(course, name, combination.interval_bounds(name, value, total))
    return course


def with_bounds(course: xr.Dataset, name: str, bounds: Iterable[Any]) -> xr.Dataset:
    """Return a course with both ends of an answer."""
    dims, suffixes = course[name].dims, ENDS[1:]
    return course.assign({name + key: (dims, np.asarray(b)) for key, b in zip(suffixes, bounds, strict=True)})


def on_scales(course: xr.Dataset, names: Iterable[str]) -> xr.Dataset:
    """Return answers of a course, each on its scale; NaN for closed gaps and infinite conductances."""
    scaled_course = course[[*names]].map(lambda answer: to_scale(answer.name, answer.values))
    return scaled_course.where(np.isfinite(scaled_course))


def components_of(form: Callable[[np.ndarray], Component], changes: xr.Dataset) -> Components:
    """Return the components of this form of all answers, from their changes on the scales."""
    return {str(name): form(change.values) for name, change in changes.items()}


def scatter_of_mean(members: Sequence[xr.Dataset]) -> xr.Dataset:
    """Return the half-width of the mean of members, on the scales, by Student's t."""
    factor = float(student(np.array(len(members) - 1))) / math.sqrt(len(members))
    return factor * xr.concat(members, "member").std("member", ddof=1, skipna=False)


def levelled_parts(window: xr.DataArray, number: int = 9) -> list[xr.DataArray]:
    """Return at most `number` parts of a window, each levelled by a plane and periodic."""
    region = {axis: slice(0, points) for axis, points in zip("yx", window.shape, strict=True)}
    areas = divided(region, spacing(window), number)
    return [subwindow(relevelled(window.isel(area), 1)) for area in areas]


def _windows_elsewhere(
    window: xr.DataArray, levelled: xr.DataArray, overviews: Sequence[xr.DataArray]
) -> list[tuple[xr.DataArray, float]]:
    """Return the own place of a map in its largest overview and all other places of that, as windows.

    Beside each is the factor of the load by the gradient, with which its coarser pixels touch as much.
    """
    fine = measured_rectangle(levelled)
    overview = max(overviews, key=lambda field: math.prod(side_lengths(field)))
    footprint, _ = own_place(fine, overview, overviews)
    fields = [overview.isel(region) for region in windows_of_places(footprint.shape, overview)]
    windows = [subwindow(relevelled(piece, form_order(fine))) for piece in (footprint, *fields)]
    factor = rms_gradient(windows[0]) / rms_gradient(window)
    return [(elsewhere, factor) for elsewhere in windows]


def causes_of_parts(face: Face, run: Run, names: Sequence[str], settings: Sections) -> list[Components]:
    """Return what the parts of a window tell, on the scales of the answers.

    These are Student's factor of their scatter, and on the first part, which stands for all, twice what
    pixels half as large change, what noise, lens, tip and rounding of the instrument do
    (`instrument_components`), and both ends of each input whose range the `settings` of the contact or the
    instrument state. Closed gaps and infinite conductances have no scale, and no ends.

    Parameters
    ----------
    face : Face
        its window is divided.
    run : callable
        the course on another window.
    names : sequence of str
        the answers.
    settings : mapping
        sections `contact` and `instrument` of the settings, and of `uncertainty` the `sources`.
    """
    if not (sources := add_correction_source(settings["uncertainty"]["sources"], face.window)):
        return []
    parts = levelled_parts(face.window)
    part, instrument = parts[0], stated_instrument(face.window, settings["instrument"])
    courses = [run(piece) for piece in (parts if "window" in sources else parts[:1])]
    on_parts = [on_scales(course, names) for course in courses]
    causes = []
    if "discretisation" in sources:
        finer = on_scales(run(refined(part, 2)), names)
        causes.append(components_of(symmetric, 2 * abs(finer - on_parts[0])))
    if len(courses) > 1:
        scatter = scatter_of_mean(on_parts)
        # the largest pressure is that of one part, and scatters as in one; all others are means
        causes.append(components_of(symmetric, scatter.assign({PEAK: math.sqrt(len(parts)) * scatter[PEAK]})))

    def values_of(course: xr.Dataset) -> dict[str, np.ndarray]:
        return {name: course[name].values for name in names}

    def solve(window: xr.DataArray, *_: Any, **__: Any) -> dict[str, np.ndarray]:
        return values_of(run(window))

    if "instrument" in sources:
        result = Result(part, {"mean_pressure": np.nan}, values_of(courses[0]), solve)
        measured_part = None if face.as_measured is None else levelled_parts(face.as_measured)[0]
        causes += instrument_components(result, instrument, measured_part, undone(part, instrument))[0]
    for key in (key for key in INPUTS if OF_MATERIAL.get(key, "instrument") in sources):
        factors = ends(1.0, settings["contact"].get(name_of_range(key)) or instrument.get(key))
        # nothing in a rubber flows
        if factors[0] < factors[1] and (key != HARDNESS or HARDNESS in run.keywords):
            arguments = {"window": part, **run.keywords}
            at_ends = [on_scales(run(**varied(arguments, key, factor)), names) for factor in factors]
            changes = xr.concat([on_parts[0], *at_ends], "end") - on_parts[0]
            causes.append(components_of(lambda c: half_widths(-c.min(axis=0), c.max(axis=0)), changes))
    return causes


def causes_of_places(face: Face, run: Run, names: Iterable[str]) -> list[Components]:
    """Return what the places of the largest overview, if any, change from that of the map: mean and scatter.

    Of the largest pressure an overview tells less.
    """
    if not face.overviews or face.levelled is None:
        return []
    without_peak = [name for name in names if name != PEAK]
    load = run.keywords["mean_pressure"]
    of_map, *of_places = (
        on_scales(run(window, mean_pressure=load * factor), without_peak)
        for window, factor in _windows_elsewhere(face.window, face.levelled, face.overviews)
    )
    changes = [of_place - of_map for of_place in of_places]
    return [
        components_of(combination.one_sided, xr.concat(changes, "place").mean("place", skipna=False)),
        components_of(symmetric, scatter_of_mean(changes)),
    ]


COURSES = {"wear": worn_in_a_run, "sliding": slid_in_a_run}  # by the sections of their settings
