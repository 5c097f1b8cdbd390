"""What a run solves over a distance or a speed: a face that wears, rubber that slides, each with its ±.

The sources, on the scale of each answer, added by their squares (`uncertainty.course`): twice what pixels
half as large change, what the instrument does, and both ends of stated loads, moduli, hardness and scales, on
one part; and the scatter of the parts of the window, each by itself.

Of wear, what half as many steps and a solver of ten times the tolerance change, which the bound of the
heights does not say of a contact area. The wear coefficient counts only through its product with the
distance, so that its range moves the axis of distances alone, and with it the distance at which the face is
run in.

Of sliding, the bound of the solver, of the friction alone; what the places of an overview change; and the
share of the friction at frequencies beyond the table of the relaxation, as if nothing were known there. Waves
that the map does not resolve are not in it: `friction_share_of_octave` shows what the shortest ones carry.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import xarray as xr

from roughcontact.arguments.answers import AREA, CONDUCTANCE, ENDS, FRICTION, GAP, PEAK, PRESSURE
from roughcontact.arguments.bodies import relaxing_body
from roughcontact.arguments.ranges import ends
from roughcontact.arguments.relaxation import relaxation_of
from roughcontact.arguments.variables import describe
from roughcontact.statistics.precision import widened
from roughcontact.statistics.running_in import run_in
from roughcontact.statistics.sliding import BY_AREA, sliding_friction
from roughcontact.uncertainty import course
from roughcontact.uncertainty.combination import symmetric
from roughcontact.uncertainty.inputs import HARDNESS, INPUTS

DISTANCE = "running_in_distance"
WORN = (AREA, PRESSURE, PEAK, GAP, CONDUCTANCE, DISTANCE)
SLID = (FRICTION, AREA, PRESSURE, PEAK, GAP)
TOLERANCE = 0.02  # of the worn heights, over their rms
FEW_STEPS: dict[str, Any] = {"tolerance": 2 * TOLERANCE, "solver_tolerance": 1e-3}
_ANSWERS_ALONE = {"flow": "never", "stress": "never"}  # statistics of a part
COARSE = 1e-3  # tolerance of sliding over a part
_OF_THE_CONTACT = ("contact_modulus", "bodies", "hardness", "influence", "zero_frequency")
_OF_A_SEAL = ("viscosity", "pressure_difference", "width", "outlet_pressure", "mean_free_path")


def worn_in_a_run(
    window: xr.DataArray,
    settings: Mapping[str, Mapping[str, Any]],
    *,
    mean_pressure: float,
    as_measured: xr.DataArray | None = None,
    threads: int = 1,
) -> xr.Dataset:
    """Return what `run_in` makes of the window by the settings, with the ends of the intervals.

    `as_measured` is the window before a correction for the instrument.

    Its first distance is 0. `{answer}_lower` and `{answer}_upper` are over `sliding_distance`, those of
    `running_in_distance` are numbers, NaN where a part has none.
    """
    wear, contact = settings["wear"], settings["contact"]
    arguments = {"wear_coefficient": wear["coefficient"], "sliding_distance": [0.0, *wear["distance"]]}
    arguments |= {key: contact[key] for key in _OF_THE_CONTACT} | {"mean_pressure": mean_pressure}
    run: course.Run = partial(run_in, threads=threads, **arguments)
    coarse = partial(run, statistics=_ANSWERS_ALONE, **FEW_STEPS)
    worn = run(window, tolerance=TOLERANCE, statistics=settings["statistics"])
    of_steps = course.on_scales(coarse(window), WORN) - course.on_scales(worn, WORN)
    causes = course.causes_of_parts(window, coarse, WORN, settings, as_measured=as_measured)
    worn = course.with_ends(worn, [course.components_of(symmetric, abs(of_steps)), *causes])
    worn[f"{DISTANCE}_lower"] /= wear["coefficient_factor"]
    worn[f"{DISTANCE}_upper"] *= wear["coefficient_factor"]
    return describe(worn)


def slid_in_a_run(
    window: xr.DataArray,
    settings: Mapping[str, Mapping[str, Any]],
    *,
    mean_pressure: float,
    as_measured: xr.DataArray | None = None,
    levelled: xr.DataArray | None = None,
    overviews: Sequence[xr.DataArray] = (),
    threads: int = 1,
) -> xr.Dataset:
    """Return what `sliding_friction` makes of the window by the settings, with the ends of the intervals.

    `as_measured` is the window before a correction for the instrument, `levelled` the map of which it is a
    part, for the `overviews` around that.
    """
    statistics, bodies = settings["statistics"], settings["contact"]["bodies"]
    rubber = relaxing_body(bodies)
    (stiff,) = (body for body in bodies if body is not rubber)
    arguments = {key: settings["sliding"][key] for key in ("speed", "direction")}
    # read once
    arguments["relaxation"] = relaxation_of(rubber["relaxation"], poissons_ratio=rubber["poissons_ratio"])
    run: course.Run = partial(sliding_friction, mean_pressure=mean_pressure, threads=threads, **arguments)
    conductivities = [body.get("thermal_conductivity") for body in (stiff, rubber)]
    friction, seal = statistics["friction"] or {}, statistics["seal"]
    slid = run(
        window,
        shear_strength=friction.get("shear_strength"),
        seal=seal and {key: seal[key] for key in _OF_A_SEAL if seal.get(key) is not None},
        thermal_conductivity=None if None in conductivities else conductivities,
    )
    coarse = partial(run, tolerance=COARSE, fields=False)
    inputs = [name for name in INPUTS if name != HARDNESS]  # nothing in a rubber flows
    causes = course.causes_of_parts(window, coarse, SLID, settings, as_measured=as_measured, inputs=inputs)
    shares = slid["hysteretic_friction_bound"] / slid[FRICTION], slid["friction_share_beyond_table"]
    causes += [{FRICTION: symmetric(share.values)} for share in shares]
    if overviews and levelled is not None:
        causes += course.causes_of_places(window, coarse, SLID, levelled, overviews)
    slid = course.with_ends(slid, causes)
    if BY_AREA in slid:
        by_area = [slid[BY_AREA] * (slid[f"{AREA}{end}"] / slid[AREA]) for end in ENDS]
        bounds = widened(by_area, ends(1.0, friction.get("shear_strength_uncertainty")))
        slid = slid.assign({f"{BY_AREA}{end}": bound for end, bound in zip(ENDS[1:], bounds, strict=True)})
    return describe(slid)
