"""Which sources belong to the interval of which measurand."""

import numpy as np
import pytest
import xarray as xr

from roughcontact.uncertainty.combination import one_sided
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.intervals import interval_columns
from roughcontact.uncertainty.scales import AREA, GAP, from_scale, to_scale
from roughcontact.uncertainty.subwindows import Scatter


@pytest.mark.parametrize("measurand", ["", "next_", "longer_", "map_"])
def test_waves_of_the_band_that_the_instrument_hides_belong_to_every_measurand(measurand):
    area, gap, nothing = np.array([0.05]), np.array([1e-7]), (np.zeros(1), np.zeros(1))
    alike = Scatter({GAP: gap[None]}, arms={AREA: nothing, GAP: nothing})  # all places give the same
    hidden = one_sided(np.array([-0.3]))  # a tip: the true area is smaller
    columns = interval_columns(
        Result(xr.DataArray(), {"mean_pressure": [0.01]}, {AREA: area, GAP: gap}),
        {AREA: area, GAP: gap},
        {AREA: to_scale(AREA, area), GAP: to_scale(GAP, gap)},
        {"unresolved": {AREA: hidden}},
        scatter=alike,
        octave={},
    )
    lower, upper = (columns[f"{AREA}_{measurand}{end}"][1] for end in ("lower", "upper"))
    np.testing.assert_allclose(lower, from_scale(AREA, to_scale(AREA, area) - 0.3), rtol=1e-12)
    np.testing.assert_allclose(upper, area, rtol=1e-12)
