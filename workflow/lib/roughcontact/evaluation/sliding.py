"""Friction of sliding rubber in a run, over the speed, with the ± of each answer.

The sources, on the scale of each answer: the bound of the solver, of the friction alone; twice what pixels
half as large change, what the instrument does, and both ends of stated loads, moduli and scales, on one part;
the scatter of the parts of the window, and what the places of an overview change; and the share of the
friction at frequencies beyond the table of the relaxation, as if nothing were known there.
Waves that the map does not resolve are not in it:
`friction_share_of_octave` shows what the shortest ones carry.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import xarray as xr

from roughcontact.arguments.answers import AREA, ENDS, FRICTION, GAP, PEAK, PRESSURE
from roughcontact.arguments.bodies import relaxing_body
from roughcontact.arguments.ranges import ends
from roughcontact.arguments.variables import describe
from roughcontact.statistics.precision import widened
from roughcontact.statistics.sliding import sliding_friction
from roughcontact.uncertainty.combination import symmetric
from roughcontact.uncertainty.course import causes_of_parts, causes_of_places, with_ends
from roughcontact.uncertainty.inputs import HARDNESS, INPUTS

ANSWERS = (FRICTION, AREA, PRESSURE, PEAK, GAP)
COARSE = 1e-3  # tolerance of a part
_BY_AREA = "adhesive_friction_coefficient"
_INPUTS = [name for name in INPUTS if name != HARDNESS]  # nothing in a rubber flows
_OF_A_SEAL = ("viscosity", "pressure_difference", "width", "outlet_pressure", "mean_free_path")


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
    sliding, statistics, bodies = settings["sliding"], settings["statistics"], settings["contact"]["bodies"]
    rubber, load = relaxing_body(bodies), mean_pressure

    def run(
        face: xr.DataArray, *, mean_pressure: float = 1.0, contact_modulus: float = 1.0, **options: Any
    ) -> xr.Dataset:
        """Return the course on a face, with load and moduli so many times as large."""
        course = sliding_friction(
            face,
            relaxation=rubber["relaxation"],
            speed=sliding["speed"],
            direction=sliding["direction"],
            poissons_ratio=rubber["poissons_ratio"],
            # linear: stiffer rubber is a lighter load, whose pressures are multiplied
            mean_pressure=mean_pressure * load / contact_modulus,
            threads=threads,
            **options,
        )
        return course.assign({name: contact_modulus * course[name] for name in (PRESSURE, PEAK)})

    (stiff,) = (body for body in bodies if body is not rubber)
    conductivities = [body.get("thermal_conductivity") for body in (stiff, rubber)]
    friction, seal = statistics["friction"] or {}, statistics["seal"]
    slid = run(
        window,
        shear_strength=friction.get("shear_strength"),
        seal=seal and {key: seal[key] for key in _OF_A_SEAL if seal.get(key) is not None},
        thermal_conductivity=None if None in conductivities else conductivities,
    )
    shares = slid["hysteretic_friction_bound"] / slid[FRICTION], slid["friction_share_beyond_table"]
    coarse = partial(run, tolerance=COARSE, fields=False)
    causes = causes_of_parts(window, coarse, ANSWERS, settings, as_measured=as_measured, inputs=_INPUTS)
    causes += [{FRICTION: symmetric(share.values)} for share in shares]
    if overviews and levelled is not None:
        causes += causes_of_places(window, coarse, ANSWERS, levelled, overviews)
    slid = with_ends(slid, ANSWERS, causes)
    if _BY_AREA in slid:
        by_area = [slid[_BY_AREA] * (slid[f"{AREA}{end}"] / slid[AREA]) for end in ENDS]
        bounds = widened(by_area, ends(1.0, friction.get("shear_strength_uncertainty")))
        slid = slid.assign({f"{_BY_AREA}{end}": bound for end, bound in zip(ENDS[1:], bounds, strict=True)})
    return describe(slid)
