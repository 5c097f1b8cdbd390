"""Flags in words that belong to the error budget: long waves, the instrument's band, plasticity."""

import numpy as np
import pytest

from roughcontact.contact.solve import solve_contact
from roughcontact.references import synthetic
from roughcontact.statistics import checks
from roughcontact.statistics.contact_statistics import contact_statistics


def found(longest, window=(), **contact):
    """Return {name: check} of a surface with such a longest wave (sides)."""
    height = synthetic.self_affine_surface(
        (96, 96), 1e-6, hurst=0.8, shortest=8e-6, longest=longest * 96e-6, rms_gradient=0.1, seed=2
    )
    solved = solve_contact(height, contact_modulus=1e9, mean_pressure=2e7, **contact)
    statistics = contact_statistics(solved)
    outcome = checks.surface_checks(statistics, height={}, levelled={}, window=dict(window), points=96 * 96)
    return {check.name: check for check in outcome}


@pytest.mark.parametrize(("longest", "outcome"), [(0.2, checks.PASSED), (1.0, checks.LOOK)])
def test_a_window_shorter_than_its_waves_asks_for_a_look(longest, outcome):
    assert found(longest)["Longest wave"].outcome == outcome


def test_waves_beyond_the_lens_ask_for_a_look():
    lens = {
        "band_shortest": 2e-6,
        "reliable_wavelength": 5e-6,
        "reliable_reason": "the lens (numerical aperture 0.1)",
    }
    check = found(0.2, lens)["Band"]
    assert check.outcome == checks.LOOK
    assert "5.00 µm" in check.sentence
    assert found(0.2, lens | {"band_shortest": 5e-6})["Band"].outcome == checks.PASSED
    pixels = lens | {"reliable_reason": "two pixels"}
    assert found(0.2, pixels)["Band"].outcome == checks.NOT_MADE


def test_a_hardness_that_is_reached_asks_for_a_look_with_the_plasticity_index():
    assert found(0.2, hardness=8e8)["Plasticity"].outcome == checks.PASSED
    check = found(0.2, hardness=8e7)["Plasticity"]
    assert check.outcome == checks.LOOK
    assert "80.0 MPa" in check.sentence
    assert np.isclose(1e9 * 0.1 / 8e7, 1.25)
    assert "1.2" in check.sentence or "1.3" in check.sentence
