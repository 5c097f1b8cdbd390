"""Running-in in a run: the worn faces and their contact over the distance, with the ± of each answer.

The sources, on the scale of each answer, added by their squares: what half as many steps and a solver of
ten times the tolerance change, which the bound of the heights does not say of a contact area; twice what
pixels half as large change, what the instrument does, and both ends of stated loads, moduli, hardness and
scales, on one part; and the scatter of the parts of the window, each worn by itself. The
wear coefficient counts only through its product with the distance, so that its range moves the axis of
distances alone, and with it the distance at which the face is run in.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.answers import AREA, CONDUCTANCE, GAP, PEAK, PRESSURE
from roughcontact.arguments.variables import describe
from roughcontact.contact.solve import NEAR_HARDNESS
from roughcontact.statistics.running_in import run_in
from roughcontact.surface.window.instrument import stated_instrument
from roughcontact.uncertainty.combination import symmetric
from roughcontact.uncertainty.course import change, components_of_parts, runs_at_ends, with_ends
from roughcontact.uncertainty.inputs import stiffer

DISTANCE = "running_in_distance"
ANSWERS = (AREA, PRESSURE, PEAK, GAP, CONDUCTANCE)
TOLERANCE = 0.02  # of the heights, over their rms
FEW_STEPS = {"tolerance": 2 * TOLERANCE, "solver_tolerance": 1e-3}
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
    wear, contact = settings["wear"], settings["contact"]
    run: Callable[..., xr.Dataset] = partial(
        run_in,
        wear_coefficient=wear["coefficient"],
        sliding_distance=[0.0, *wear["distance"]],
        mean_pressure=mean_pressure,
        hardness=contact["hardness"],
        influence=contact["influence"],
        zero_frequency=contact["zero_frequency"],
        bodies=contact["bodies"] or None,
        contact_modulus=None if contact["bodies"] else contact["contact_modulus"],
        threads=threads,
    )
    worn = run(window, tolerance=TOLERANCE, statistics=settings["statistics"])
    fewer = partial(run, statistics=_ANSWERS_ALONE, **FEW_STEPS)
    instrument = stated_instrument(window, settings["instrument"])

    def at_end(
        part: xr.DataArray, *, contact_modulus: float = 1.0, hardness: float = 1.0, **inputs: float
    ) -> xr.Dataset:
        """Return the course with inputs so many times as large."""
        limit, load = contact["hardness"], inputs.get("mean_pressure", 1.0) * mean_pressure
        changed = {"bodies": stiffer(contact["bodies"], contact_modulus)}
        if not contact["bodies"]:
            changed = {"contact_modulus": contact_modulus * contact["contact_modulus"]}
        if limit:  # a contact of which all yields carries no more
            changed |= {"hardness": hardness * limit}
            load = min(load, (1 - 2 * NEAR_HARDNESS) * hardness * limit)
        return fewer(part, mean_pressure=load, **changed)

    of_parts = components_of_parts(
        window,
        fewer,
        (*ANSWERS, DISTANCE),
        instrument=instrument,
        as_measured=as_measured,
        ends_of_inputs=runs_at_ends(at_end, contact, instrument),
    )
    coarse = fewer(window)
    of_steps = {name: symmetric(np.abs(change(name, coarse, worn))) for name in of_parts}
    worn = with_ends(worn, [of_parts, of_steps])
    worn[f"{DISTANCE}_lower"] /= wear["coefficient_factor"]
    worn[f"{DISTANCE}_upper"] *= wear["coefficient_factor"]
    return describe(worn)
