"""Running-in in a run: the worn faces and their contact over the distance, with the ± of each answer.

The sources, on the scale of each answer, added by their squares: what half as many steps and a solver of
ten times the tolerance change, which the bound of the heights does not say of a contact area; twice what
pixels half as large change, what the instrument does, and both ends of stated loads, moduli, hardness and
scales, on one part; and the scatter of the parts of the window, each worn by itself. The
wear coefficient counts only through its product with the distance, so that its range moves the axis of
distances alone, and with it the distance at which the face is run in.
"""

from collections.abc import Mapping
from functools import partial
from typing import Any

import xarray as xr

from roughcontact.arguments.answers import AREA, CONDUCTANCE, GAP, PEAK, PRESSURE
from roughcontact.arguments.variables import describe
from roughcontact.contact.solve import NEAR_HARDNESS
from roughcontact.statistics.running_in import run_in
from roughcontact.uncertainty.combination import symmetric
from roughcontact.uncertainty.course import Run, causes_of_parts, components_of, on_scales, with_ends
from roughcontact.uncertainty.inputs import stiffer

DISTANCE = "running_in_distance"
ANSWERS = (AREA, PRESSURE, PEAK, GAP, CONDUCTANCE)
TOLERANCE = 0.02  # of the heights, over their rms
FEW_STEPS: dict[str, Any] = {"tolerance": 2 * TOLERANCE, "solver_tolerance": 1e-3}
_ANSWERS_ALONE = {"flow": "never", "stress": "never"}  # statistics of a part


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
    wear, contact, load = settings["wear"], settings["contact"], mean_pressure

    def run(
        face: xr.DataArray,
        *,
        mean_pressure: float = 1.0,
        contact_modulus: float = 1.0,
        hardness: float = 1.0,
        **options: Any,
    ) -> xr.Dataset:
        """Return the course on a face, with inputs so many times as large."""
        bodies, pressure, hardest = contact["bodies"], mean_pressure * load, contact["hardness"]
        if hardest:  # a contact of which all yields carries no more
            hardest *= hardness
            pressure = min(pressure, (1 - 2 * NEAR_HARDNESS) * hardest)
        return run_in(
            face,
            contact_modulus=None if bodies else contact_modulus * contact["contact_modulus"],
            bodies=stiffer(bodies, contact_modulus),
            mean_pressure=pressure,
            hardness=hardest,
            wear_coefficient=wear["coefficient"],
            sliding_distance=[0.0, *wear["distance"]],
            influence=contact["influence"],
            zero_frequency=contact["zero_frequency"],
            threads=threads,
            **options,
        )

    coarse: Run = partial(run, statistics=_ANSWERS_ALONE, **FEW_STEPS)
    names = (*ANSWERS, DISTANCE)
    worn, fewer = run(window, tolerance=TOLERANCE, statistics=settings["statistics"]), coarse(window)
    of_steps = components_of(symmetric, abs(on_scales(fewer, names) - on_scales(worn, names)))
    causes = [of_steps, *causes_of_parts(window, coarse, names, settings, as_measured=as_measured)]
    worn = with_ends(worn, names, causes)
    worn[f"{DISTANCE}_lower"] /= wear["coefficient_factor"]
    worn[f"{DISTANCE}_upper"] *= wear["coefficient_factor"]
    return describe(worn)
