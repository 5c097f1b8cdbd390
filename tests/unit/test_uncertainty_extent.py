"""Which sources belong to the interval of which measurand."""

import numpy as np
import pytest

from roughcontact.uncertainty.combination import one_sided
from roughcontact.uncertainty.intervals import Intervals
from roughcontact.uncertainty.scales import AREA, GAP, from_scale, to_scale


@pytest.mark.parametrize("measurand", ["", "next_", "longer_", "map_"])
def test_waves_of_the_band_that_the_instrument_hides_belong_to_every_measurand(measurand):
    area = np.array([0.05])
    hidden = one_sided(np.array([-0.3]))  # a tip: the true area is smaller
    intervals = Intervals({"unresolved": {AREA: hidden}}, None, {}, {}, np.array([0.01]), 3.0, None)
    columns = intervals.columns(AREA, {AREA: area, GAP: np.ones(1)}, {AREA: to_scale(AREA, area)})
    lower, upper = (columns[f"{AREA}_{measurand}{end}"][1] for end in ("lower", "upper"))
    np.testing.assert_allclose(lower, from_scale(AREA, to_scale(AREA, area) - 0.3), rtol=1e-12)
    np.testing.assert_allclose(upper, area, rtol=1e-12)
