"""Energy of full conformity beside a work of adhesion."""

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.variables import describe
from roughcontact.contact.elasticity.energy import conforming_energy
from roughcontact.contact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.statistics.adhesion import adhesion_in_words, adhesion_numbers
from roughcontact.surface.synthetic import rough_reference_surface
from validation import closed_forms

ROUGH = rough_reference_surface(64)


@pytest.mark.parametrize("shape", [(24, 30), (25, 31), (1, 40)])
def test_energy_is_the_work_of_full_contact(shape):
    """Against the closed form written apart, and against half of pressure times displacement."""
    height = np.random.default_rng(1).standard_normal(shape) + 7.0
    steps = (0.3, 0.5)
    energy = conforming_energy(height, steps, Elasticity(3.0))
    assert energy == pytest.approx(closed_forms.full_contact_energy(height, steps, 3.0), rel=1e-12)
    pressure = closed_forms.full_contact_fluctuation(height, steps, 3.0)
    assert energy == pytest.approx((pressure * (height - height.mean())).mean() / 2, rel=1e-10)


def test_it_is_the_energy_of_the_solved_contact_when_all_of_it_touches():
    contact = rc.solve_contact(ROUGH, contact_modulus=2.0, mean_pressure=10.0)
    stats = describe(rc.contact_statistics(contact, work_of_adhesion=0.5))
    assert stats["elastic_energy"].item() == pytest.approx(stats["conforming_energy"].item(), rel=1e-10)
    remaining_energy = 0.5 - stats["conforming_energy"].item()
    assert stats["effective_work_of_adhesion"].item() == pytest.approx(remaining_energy)
    assert stats["effective_work_of_adhesion"].attrs["units"] == "J m-2"
    assert "effective_work_of_adhesion" not in rc.contact_statistics(contact)


def test_words():
    numbers = adhesion_numbers(ROUGH, HALF_SPACE, work_of_adhesion=1.0)
    assert adhesion_in_words(xr.Dataset(numbers)).startswith("sticky: of the work of adhesion (1000 mJ/m²)")
    numbers = adhesion_numbers(ROUGH, Elasticity(1e6), work_of_adhesion=0.05)
    assert adhesion_in_words(xr.Dataset(numbers)).startswith("not sticky: pressing the surfaces flat costs")
    assert adhesion_in_words(xr.Dataset(adhesion_numbers(ROUGH, HALF_SPACE))) == ""


def test_work_of_adhesion_in_the_settings():
    settings = resolve({"contact": {"contact_modulus": 1e9}, "statistics": {"work_of_adhesion": "50 mJ/m²"}})
    assert settings[""]["statistics"]["work_of_adhesion"] == pytest.approx(0.05)
