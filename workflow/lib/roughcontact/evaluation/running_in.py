"""Running-in in a run: the worn faces and their contact over the distance, with the ± of each answer.

Three sources, on the scale of each answer, added by their squares: what half as many steps and a solver of
ten times the tolerance change, which the bound of the heights does not say of a contact area; twice what
pixels half as large change, on one part; and the scatter of the parts of the window, each worn by itself. The
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
from roughcontact.statistics.running_in import run_in
from roughcontact.uncertainty.combination import symmetric
from roughcontact.uncertainty.course import change, components_of_parts, with_ends

DISTANCE = "running_in_distance"
ANSWERS = (AREA, PRESSURE, PEAK, GAP, CONDUCTANCE)
TOLERANCE = 0.02  # of the heights, over their rms
FEW_STEPS = {"tolerance": 2 * TOLERANCE, "solver_tolerance": 1e-3}
_ANSWERS_ALONE = {"flow": "never", "stress": "never"}  # statistics of a part


def worn_in_a_run(
    window: xr.DataArray, settings: Mapping[str, Mapping[str, Any]], *, mean_pressure: float, threads: int = 1
) -> xr.Dataset:
    """Return what `run_in` makes of the window by the settings, with the ends of the intervals.

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
    of_parts, coarse = components_of_parts(window, fewer, (*ANSWERS, DISTANCE)), fewer(window)
    of_steps = {name: symmetric(np.abs(change(name, coarse, worn))) for name in of_parts}
    worn = with_ends(worn, [of_parts, of_steps])
    worn[f"{DISTANCE}_lower"] /= wear["coefficient_factor"]
    worn[f"{DISTANCE}_upper"] *= wear["coefficient_factor"]
    return describe(worn)
