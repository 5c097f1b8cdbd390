"""The solver against the pressures that two other codes find, point by point.

They are kept with the heights in other_codes_pressures.csv, which says where they come from.
"""

from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.arguments.maps import height_map

SHAPE, PITCHES = (40, 32), (1.0, 0.75)
LOADS = [0.02, 0.1, 0.4]
HEIGHTS, *COLUMNS = np.loadtxt(
    Path(__file__).with_name("other_codes_pressures.csv"), delimiter=",", unpack=True
).reshape(-1, *SHAPE)
PRESSURES = {"Tamaas": COLUMNS[:3], "ContactMechanics": COLUMNS[3:]}


@pytest.mark.parametrize("code", PRESSURES)
@pytest.mark.parametrize("load", range(len(LOADS)))
def test_every_pixel_and_every_pressure_are_those_of_another_code(code, load):
    problem = {"contact_modulus": 1.0, "mean_pressure": LOADS[load], "tolerance": 1e-10}
    contact = rc.solve_contact(height_map(HEIGHTS, PITCHES), **problem)
    pressure, reference = contact["pressure"].values[0], PRESSURES[code][load]
    assert 0.01 < (reference > 0).mean() < 0.99
    np.testing.assert_array_equal(pressure > 0, reference > 0)
    np.testing.assert_allclose(pressure, reference, rtol=0, atol=2e-9 * reference.max())


def test_the_other_codes_agree_with_one_another():
    for tamaas, contactmechanics in zip(*PRESSURES.values(), strict=True):
        np.testing.assert_array_equal(tamaas > 0, contactmechanics > 0)
        np.testing.assert_allclose(tamaas, contactmechanics, rtol=0, atol=1e-9 * tamaas.max())
