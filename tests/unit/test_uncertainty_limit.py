"""The upper end of the mean gap: limited in rms heights of the map, where the logarithm has no limit."""

import numpy as np
import pytest

from roughcontact.uncertainty.calibration import arms, limit_of_gap, table
from roughcontact.uncertainty.intervals import window_components
from roughcontact.uncertainty.scales import AREA, GAP, from_scale
from roughcontact.uncertainty.subwindows import Scatter

FEATURES = {"gradient": 1.0, "scatter": 0.0}  # of a map unlike its places
LOADS = np.array(table()["limit_of_gap"]["surface"]["load"])


def upper_end(gap, rms_height, measurand="surface"):
    """Return the upper end of the gap (load; m) at the loads of the bank."""
    middle = {AREA: LOADS, GAP: np.log(gap)}
    scatter = Scatter({}, dict.fromkeys(middle, FEATURES))
    components = window_components(scatter, middle, gap, rms_height=rms_height)
    return gap * np.exp(components[measurand][GAP][1])


def test_a_nearly_closed_gap_is_no_larger_than_so_many_rms_heights_more():
    gap, rms_height = np.array([1e-6, 3e-7, 1e-10]), 1e-6
    limit = gap + np.array(table()["limit_of_gap"]["surface"]["up"]) * rms_height
    unlimited = gap * np.exp(arms("surface", GAP, FEATURES, from_scale(AREA, LOADS))[1])
    assert upper_end(gap, rms_height) == pytest.approx(np.minimum(limit, unlimited))
    assert (unlimited > limit)[1:].all()  # the limit is what bounds it


def test_the_limit_says_nothing_of_this_map_and_of_loads_lighter_than_those_of_the_bank():
    area = from_scale(AREA, np.array([LOADS[0] - 1, *LOADS]))
    assert np.isinf(limit_of_gap("map", area, 1.0)).all()
    assert np.isinf(limit_of_gap("surface", area, 1.0)).tolist() == [True, False, False, False]


def test_other_places_alone_may_be_further_off_than_their_mean():
    known = table()["limit_of_gap"]
    assert all(known["next"]["up"] > np.array(known["surface"]["up"]))
