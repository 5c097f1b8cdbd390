"""Made surfaces of many kinds, and the faults of maps cut out of them."""

import numpy as np
import pytest

from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.roughness.texture import texture_parameters
from validation.masters import FAULTS, KINDS, cut_out, master_surface


@pytest.mark.parametrize("kind", KINDS)
def test_a_master_is_periodic_and_of_known_gradient(kind):
    surface = master_surface(kind, 192, longest=0.25, seed=3)
    assert surface.shape == (192, 192)
    assert float(rms_gradient(surface)) == pytest.approx(0.1)
    for axis in (0, 1):
        inside = np.abs(np.diff(surface.values, axis=axis)).max()
        seam = np.abs(surface.values.take(0, axis) - surface.values.take(-1, axis)).max()
        assert seam <= 1.5 * inside


def test_kinds_are_what_their_names_say():
    def skewness(kind):
        surface = master_surface(kind, 256, longest=0.1, seed=1)
        return float((surface**3).mean() / (surface**2).mean() ** 1.5)

    assert skewness("worn") < -0.8
    assert skewness("honed") < -0.5
    assert skewness("dimpled") < -0.2
    assert skewness("eroded") > 0.8
    assert skewness("grainy") > 0.8
    assert abs(skewness("random")) < 0.3
    texture = {
        kind: texture_parameters(master_surface(kind, 256, longest=0.1, seed=1))["Str"] for kind in KINDS
    }
    assert max(texture["ground"], texture["turned"]) < 0.3 < texture["random"]


@pytest.mark.parametrize("fault", FAULTS)
def test_a_map_is_a_part_of_its_master_with_a_fault(fault):
    master = master_surface("random", 192, longest=0.25, seed=2)
    cut = cut_out(master, 96, np.random.default_rng(5), fault=fault)
    assert 0.01 <= float(cut.isnull().mean()) < 0.05
    # the place is the first that the generator gives
    start = np.random.default_rng(5).integers(0, 192, 2)
    part = np.roll(master.values, -start, (0, 1))[:96, :96]
    order = 2 if fault == "bow" else 1
    y, x = (axis / 96 - 0.5 for axis in np.mgrid[:96, :96])
    terms = [y**i * x**j for i in range(order + 1) for j in range(order + 1 - i)]
    deviation, is_measured = cut.values - part, ~np.isnan(cut.values)
    matrix = np.column_stack([term[is_measured] for term in terms])
    residual = (
        deviation[is_measured] - matrix @ np.linalg.lstsq(matrix, deviation[is_measured], rcond=None)[0]
    )
    spikes = np.abs(residual) > 3 * part.std()
    assert spikes.sum() == (0 if fault != "spikes" else pytest.approx(10, abs=2))
    if fault != "spikes":
        np.testing.assert_allclose(residual, 0, atol=1e-9 * part.std())
