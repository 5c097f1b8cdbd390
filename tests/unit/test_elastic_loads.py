"""Planned loads of a steep surface are those that it bears elastically."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.surface.synthetic import self_affine_surface

STEEL = "115 GPa"


def rough(gradient):
    """Return a random map (m)."""
    waves = {"hurst": 0.8, "shortest": 8e-6, "longest": 64e-6, "rms_gradient": gradient}
    return self_affine_surface((128, 128), 1e-6, **waves, seed=3)


def plateau(gradient):
    """Return a map whose flat tops touch at low pressure and whose flanks are steep (m)."""
    height = rough(gradient)
    return height.copy(data=np.minimum(height.values, np.quantile(height.values, 0.6)))


@pytest.mark.parametrize(("gradient", "fewest"), [(0.02, 7), (0.15, 4), (0.2, 4)])
def test_every_planned_load_stays_below_what_materials_bear(gradient, fewest):
    statistics = rc.evaluate(plateau(gradient), contact={"contact_modulus": STEEL})
    assert (statistics["mean_contact_pressure"] < 0.1 * 115e9).all()
    assert statistics.sizes["load"] >= fewest
    assert (np.diff(statistics["mean_pressure"]) > 0).all()


def test_planned_loads_of_two_moduli_are_the_same_over_them():
    steep, undisturbed = rough(0.25)[:64, :64], {"uncertainty": {"sources": []}}
    stiff, soft = (
        rc.evaluate(steep, contact={"contact_modulus": modulus}, **undisturbed)["relative_pressure"].values
        for modulus in (115e9, 77.7e9)
    )
    np.testing.assert_allclose(stiff, soft, rtol=1e-9)
    assert stiff.size == 4
    assert stiff[-1] < 0.02  # no step of the plan


def test_a_surface_too_steep_at_every_load_says_so():
    statistics = rc.evaluate(rough(1.0), contact={"contact_modulus": STEEL}, uncertainty={"sources": []})
    assert (statistics["verdict"] == 2).all()
    assert "At every load the contact is beyond what any material bears" in statistics.attrs["reasons"]


def test_loads_that_are_stated_stay():
    statistics = rc.evaluate(
        plateau(0.2),
        contact={"contact_modulus": STEEL, "relative_pressure": [0.01, 2.0]},
        uncertainty={"sources": []},
    )
    assert statistics["verdict"].values.tolist() != [0, 0]
    assert statistics.sizes["load"] == 2
