"""How heights grow with the length: surfaces whose exponent is known by construction."""

import numpy as np
import pytest

from roughcontact.levelling.level import level
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface, turned_surface
from roughcontact.uncertainty.growth import form_order, growth_exponent


def exponents(hurst, longest, *, points=1024, part=256):
    """Return the exponents of the quarters of a self-affine surface."""
    master = self_affine_surface(
        (points, points), 1.0, hurst=hurst, shortest=4.0, longest=longest, rms_height=1.0, seed=3
    )
    starts = range(0, points, part)
    return [growth_exponent(level(master[y : y + part, x : x + part])) for y in starts for x in starts]


def test_a_stationary_surface_does_not_grow():
    assert max(exponents(0.8, longest=32.0)) < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("hurst", [0.3, 0.5, 0.8])
def test_a_self_affine_surface_grows_by_its_hurst_exponent(hurst):
    """Waves four times as long as the map: the mean of 16 maps, each of which is a single sample of them."""
    assert np.mean(exponents(hurst, longest=1024.0)) == pytest.approx(hurst, abs=0.15)


@pytest.mark.parametrize(("order", "expected"), [(2, 2.0), (1, 1.0)])
def test_a_form_grows_by_its_order(order, expected):
    x = np.arange(256.0)
    form = height_map((x**order)[None, :] + (x**order)[:, None], 1.0).assign_attrs(form="none")
    if order == 2:
        form = level(form)
    assert growth_exponent(form) == pytest.approx(expected, abs=0.02)


def test_parts_are_levelled_like_the_map():
    """A bow on roughness: growing while a plane is taken off, gone with a polynomial of its order."""
    rough = self_affine_surface(
        (256, 256), 1.0, hurst=0.8, shortest=4.0, longest=32.0, rms_height=1.0, seed=1
    )
    bow = rough + 20 * ((rough["x"] / 256 - 0.5) ** 2 + (rough["y"] / 256 - 0.5) ** 2)
    assert growth_exponent(level(bow)) > 1
    flat = level(bow, form="polynomial", order=2)
    assert form_order(flat) == 2
    assert growth_exponent(flat) < 0.05


def test_one_spike_does_not_hide_the_growth():
    """A point of 300 standard deviations: most of the mean square, next to nothing of the mean deviation."""
    surface = self_affine_surface(
        (512, 512), 1.0, hurst=0.8, shortest=4.0, longest=512.0, rms_height=1.0, seed=2
    )[:128, :128]
    spiked = surface.copy()
    spiked[40, 70] = 300.0
    found = [growth_exponent(level(map_, outlier_threshold=None)) for map_ in (surface, spiked)]
    assert found[0] > 0.5
    assert found[1] == pytest.approx(found[0], rel=0.3)


def test_a_profile_and_a_flat_map():
    profile = turned_surface((1, 900), 1.0, feed=30.0, nose_radius=100.0)
    assert growth_exponent(level(profile)) < 0.05
    assert growth_exponent(level(height_map(np.zeros((64, 64)), 1.0))) == 0.0


@pytest.mark.parametrize("shape", [(2, 300), (3, 3), (300, 3), (1, 3)])
def test_maps_of_few_rows_have_parts_of_one_row(shape):
    heights = np.random.default_rng(5).normal(size=shape)
    assert 0 <= growth_exponent(level(height_map(heights, 1.0), outlier_threshold=None)) <= 2
    assert growth_exponent(height_map(np.ones(shape), 1.0).assign_attrs(form="plane")) == 0.0
