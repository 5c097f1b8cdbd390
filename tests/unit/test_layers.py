"""The symbol of layered bodies: against Navier's equations solved otherwise, closed forms, and limits."""

import itertools
import math

import navier
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roughcontact.contact.elasticity.influence import Elasticity, elements
from roughcontact.contact.elasticity.layers import (
    Layer,
    LayeredPair,
    Material,
    Stack,
    body_stack,
    compliance_factor,
)
from roughcontact.contact.elasticity.media import elastic_medium
from roughcontact.contact.elasticity.medium import HALF_SPACES
from roughcontact.kernels.fourier import wavevectors

RATIOS = (0.0, 0.01, 0.1, 0.5, 1.0, 2.0, 10.0, 100.0)  # of Young's moduli, layer over base; 0: rigid base
DEPTHS = (1e-4, 1e-3, 0.03, 0.3, 0.999, 1.001, 3.0, 30.0, 1e3)  # |q| t
POISSON = ((0.0, 0.5), (0.3, 0.3), (0.45, 0.2), (0.5, 0.3))  # of layer and base


def one_layer(ratio: float, nu: float, base_nu: float, *, thickness: float = 1.0) -> Stack:
    base = None if ratio == 0 else Material(1 / ratio, base_nu)
    return Stack((Layer(thickness, Material(1.0, nu)),), base)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize(("nu", "base_nu"), POISSON)
def test_one_layer_is_the_solution_of_naviers_equations(ratio: float, nu: float, base_nu: float):
    body = one_layer(ratio, nu, base_nu)
    base = None if body.base is None else tuple(body.base)
    factors = compliance_factor(np.array(DEPTHS), body)
    expected = [navier.surface_compliance(q, [(1.0, 1.0, nu)], base) * q / 2 / (1 - nu**2) for q in DEPTHS]
    np.testing.assert_allclose(factors, expected, rtol=1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_any_stack_is_the_solution_of_naviers_equations(seed: int):
    rng = np.random.default_rng(seed)
    layers = navier.random_layers(rng, 2, 4)
    base = None if seed % 3 == 0 else (float(10 ** rng.uniform(-2, 2)), float(rng.uniform(0, 0.5)))
    q = 10 ** rng.uniform(-3, 2, 3)
    body = Stack(tuple(Layer(t, Material(e, nu)) for t, e, nu in layers), base and Material(*base))
    compliances = compliance_factor(q, body) * 2 / (q * body.surface.plane_modulus)
    expected = [navier.surface_compliance(float(wavenumber), layers, base) for wavenumber in q]
    np.testing.assert_allclose(compliances, expected, rtol=1e-12)


def closed_form(x: np.ndarray, nu: float, base_nu: float, shear_ratio: float) -> np.ndarray:
    """Return the factor of one layer in closed form; the shear ratio is that of the layer over the base.

    Airy's function is (a + bz)e^(-z) + (c + dz)e^z in the layer and (e + fz)e^(-z) in the base, q = 1. Four
    conditions at the interface, no shear and unit pressure at the surface give the constants, and the
    displacement w of the surface: the factor is w mu/(1 - nu), of the layer.
    """
    lam = 1 - 4 * (1 - nu) / (1 + shear_ratio * (3 - 4 * base_nu))
    kappa = (shear_ratio - 1) / (shear_ratio + 3 - 4 * nu)
    decay = np.exp(-2 * x)
    above = 1 + 4 * kappa * x * decay - lam * kappa * decay**2
    return above / (1 - (lam + kappa + 4 * kappa * x**2) * decay + lam * kappa * decay**2)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize(("nu", "base_nu"), POISSON)
def test_one_layer_has_a_closed_form(ratio: float, nu: float, base_nu: float):
    x = np.geomspace(0.05, 50, 40)  # the closed form cancels below
    shear_ratio = ratio * (1 + base_nu) / (1 + nu)
    factors = compliance_factor(x, one_layer(ratio, nu, base_nu))
    np.testing.assert_allclose(factors, closed_form(x, nu, base_nu, shear_ratio), rtol=1e-9)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.5])
def test_a_rigid_base_has_a_closed_form(nu: float):
    x, k = np.geomspace(0.05, 50, 40), 3 - 4 * nu  # that of one layer for a shear ratio to 0
    expected = (k * np.sinh(2 * x) - 2 * x) / (k * np.cosh(2 * x) + 2 * x**2 + 5 - 12 * nu + 8 * nu**2)
    np.testing.assert_allclose(compliance_factor(x, one_layer(0.0, nu, 0.3)), expected, rtol=1e-9)


@pytest.mark.parametrize(("ratio", "nu"), list(itertools.product((0.0, 0.1, 50.0), (0.2, 0.5))))
def test_a_layer_cut_into_three_is_the_layer(ratio: float, nu: float):
    q, layered = np.geomspace(1e-3, 1e2, 60), one_layer(ratio, nu, 0.3)
    cut = Stack(tuple(Layer(t, layered.layers[0].material) for t in (0.1, 0.6, 0.3)), layered.base)
    np.testing.assert_allclose(compliance_factor(q, cut), compliance_factor(q, layered), rtol=1e-12)
    assert len(cut.merged().layers) == 1


@pytest.mark.parametrize("ratio", [0.01, 0.3, 3.0, 100.0])
def test_long_waves_feel_the_base_and_short_ones_the_layer(ratio: float):
    body = one_layer(ratio, 0.4, 0.2)
    short, long = compliance_factor(np.array([60.0, 1e-9]), body)
    assert short == pytest.approx(1, rel=1e-14)
    assert body.base is not None
    assert long == pytest.approx(body.surface.plane_modulus / body.base.plane_modulus, rel=1e-6)


def test_a_thin_layer_on_a_rigid_base_is_a_bed_of_springs():
    nu, x = 0.3, 1e-6
    springs = (1 + nu) * (1 - 2 * nu) / (1 - nu)  # t/E: no way to give way sideways
    compliance = compliance_factor(np.array([x]), one_layer(0.0, nu, 0.3))[0] * 2 * (1 - nu**2) / x
    assert compliance == pytest.approx(springs, rel=1e-10)
    pair = LayeredPair((one_layer(0.0, nu, 0.3),))
    assert pair.mean_compliance(elastic=False) == pytest.approx(springs, rel=1e-14)


@pytest.mark.parametrize("ratio", [0.02, 0.5, 4.0, 60.0])
def test_the_mean_compliance_is_the_limit_of_the_symbol(ratio: float):
    body = one_layer(ratio, 0.45, 0.25)
    assert body.base is not None
    q = 1e-5 / max(1, ratio)
    difference = navier.surface_compliance(q, [(1.0, 1.0, 0.45)], tuple(body.base))
    difference -= 2 / (q * body.base.plane_modulus)
    pair = LayeredPair((body,))
    assert pair.mean_compliance(elastic=True) == pytest.approx(difference, rel=3e-3)
    assert pair.mean_compliance(elastic=False) == 0


def test_two_bodies_add_their_displacements():
    film, rubber, steel = one_layer(20.0, 0.2, 0.3), one_layer(0.0, 0.5, 0.3), Stack((), Material(5.0, 0.3))
    q = np.geomspace(1e-2, 1e2, 30)
    compliances = [compliance_factor(q, body) / body.surface.plane_modulus for body in (film, rubber)]
    for bodies, expected in (
        ((film, rubber), compliances[0] + compliances[1]),
        ((film, steel), compliances[0] + 1 / Material(5.0, 0.3).plane_modulus),
    ):
        pair = LayeredPair(bodies)
        np.testing.assert_allclose(pair.factor(q) / pair.modulus, expected, rtol=1e-13)


@given(
    ratio=st.floats(-3, 3).map(lambda x: 10.0**x),
    nu=st.floats(-0.9, 0.5),
    base_nu=st.floats(-0.9, 0.5),
    x=st.floats(-6, 3).map(lambda x: 10.0**x),
    rigid=st.booleans(),
)
@settings(deadline=None, max_examples=200)
def test_the_symbol_is_positive_and_between_those_of_its_materials(ratio, nu, base_nu, x, rigid):
    body = one_layer(0.0 if rigid else ratio, nu, base_nu)
    factor = compliance_factor(np.array([x]), body)[0]
    assert math.isfinite(factor)
    assert factor > 0
    if rigid:  # never softer than without the base
        assert factor <= max(1.0, 2 / (3 - 4 * nu)) * (1 + 1e-12)


def test_many_wavenumbers_are_interpolated_to_rounding():
    pair = LayeredPair((one_layer(30.0, 0.2, 0.4, thickness=0.01), Stack((), Material(1.0, 0.3))))
    q = np.geomspace(1, 1e4, 40000)
    parts = np.concatenate([pair.factor(part) for part in np.array_split(q, 8)])
    np.testing.assert_allclose(pair.factor(q), parts, rtol=1e-12)


def test_settings_and_layers_tell_the_same():
    body = {"base": "rigid", "layers": [{"thickness": 1e-3, "youngs_modulus": 2e6, "poissons_ratio": 0.5}]}
    steel = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
    pair = elastic_medium([body, steel])
    assert pair is not None
    assert elastic_medium(pair.as_settings()) == pair
    assert pair.scaled(1e-3).thinnest == 1.0
    assert pair.thickest == 1e-3
    like_its_base = steel | {"layers": [steel | {"thickness": 1e-6}]}
    assert elastic_medium([like_its_base, steel]) is HALF_SPACES
    assert body_stack(body).base is None


@pytest.mark.parametrize(("ratio", "thickness"), [(0.0, 0.05), (20.0, 0.01), (0.1, 0.2)])
def test_elements_are_the_sum_over_the_aliases(ratio: float, thickness: float):
    shape, spacing = (96, 64), (1 / 96, 1 / 64)
    pair = LayeredPair((one_layer(ratio, 0.3, 0.4, thickness=thickness),))
    qy, qx = wavevectors(shape, spacing)
    compliances = elements(qy, qx, spacing, pair)
    orders = np.arange(-200, 201)
    weights = np.where(np.abs(orders) == 200, 0.5, 1.0)
    for row, column in ((0, 1), (1, 0), (3, 7), (40, 20), (48, 32)):
        y, x = (q + 2 * np.pi * orders / d for q, d in zip((qy[row, 0], qx[0, column]), spacing, strict=True))
        alias = np.hypot(y[:, None], x)
        every = 2 / alias * np.concatenate([pair.factor(line) for line in alias]).reshape(alias.shape)
        shares = [np.sinc(q * d / (2 * np.pi)) * weights for q, d in zip((y, x), spacing, strict=True)]
        assert compliances[row, column] == pytest.approx((every * np.outer(*shares)).sum(), rel=2e-6)


@pytest.mark.parametrize("influence", ["sampled", "elements"])
def test_a_layer_that_hardly_differs_has_nearly_the_symbol_of_the_half_space(influence):
    shape, spacing = (40, 48), (1 / 40, 1 / 48)
    pair = LayeredPair((Stack((Layer(0.1, Material(1 + 1e-9, 0.3)),), Material(1.0, 0.3)),))
    qy, qx = wavevectors(shape, spacing)
    with_layer, half_space = (
        Elasticity(1.0, influence, medium).symbol(qy, qx, spacing) for medium in (pair, HALF_SPACES)
    )
    np.testing.assert_allclose(with_layer.ravel()[1:], half_space.ravel()[1:], rtol=1e-6)
