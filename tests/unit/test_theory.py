"""The theories at their limits, and against independent quadrature and published numbers."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erf

from roughcontact.statistics import theory


def test_persson_slope_and_full_contact():
    assert theory.persson_area(1e-9) / 1e-9 == pytest.approx(np.sqrt(8 / np.pi), rel=1e-12)
    assert theory.persson_area(np.inf) == 1.0


@pytest.mark.parametrize("load", [1e-12, 1e-4, 0.05, 0.3, 1.0, 4.0])
def test_xu_solves_its_equation(load):
    area = float(theory.xu_area(load))
    assert area == pytest.approx(erf(np.sqrt(2) * load / np.sqrt(0.42 + 0.58 * area)), rel=1e-13)


def test_xu_limits_and_shape():
    assert theory.xu_area(1e-9) / 1e-9 == pytest.approx(np.sqrt(8 / np.pi / 0.42), rel=1e-8)
    np.testing.assert_array_equal(theory.xu_area([0.0, np.inf]), [0.0, 1.0])
    assert theory.xu_area(np.ones((2, 3))).shape == (2, 3)


@pytest.mark.parametrize(("load", "area"), [(0.05, 0.11614), (0.2, 0.36845), (1.0, 0.96078)])
def test_xu_is_within_four_percent_of_a_deterministic_solution(load, area):
    """The areas are those of an independent code on a band-limited random surface at 1024 x 1024 points."""
    assert theory.xu_area(load) == pytest.approx(area, rel=0.04)


def test_bush_gibson_thomas_slope_and_where_it_ends():
    assert theory.bush_gibson_thomas_area(1e-3) == pytest.approx(np.sqrt(2 * np.pi) * 1e-3, rel=1e-14)
    assert np.isnan(theory.bush_gibson_thomas_area([1.0, np.inf])).all()


SUMMITS = {"density": 2.0e9, "mean_radius": 4e-5, "height_std": 3e-7, "mean_height": 1e-7}
MODULUS = 1e11


@pytest.mark.parametrize("separation", [-2.0, 0.5, 3.0])
def test_greenwood_williamson_against_quadrature(separation):
    def moment(order):
        def density(u):
            return u**order * np.exp(-((separation + u) ** 2) / 2) / np.sqrt(2 * np.pi)

        return quad(density, 0, np.inf, epsabs=0, epsrel=1e-11)[0]

    scale = SUMMITS["density"] * SUMMITS["mean_radius"] * SUMMITS["height_std"]
    area = np.pi * scale * moment(1)
    pressure = 4 / 3 * MODULUS * scale * np.sqrt(SUMMITS["height_std"] / SUMMITS["mean_radius"]) * moment(1.5)
    found = theory.greenwood_williamson_area(pressure, SUMMITS, contact_modulus=MODULUS)
    assert found == pytest.approx(area, rel=1e-5)


def test_greenwood_williamson_rises_and_ends_at_full_contact():
    loads = np.geomspace(1e2, 1e12, 60)
    area = theory.greenwood_williamson_area(loads, SUMMITS, contact_modulus=MODULUS)
    inside = area[np.isfinite(area)]
    assert inside.size > 20
    assert (np.diff(inside) > 0).all()
    assert np.nanmax(area) <= 1
    assert np.isnan(area[-1])


@pytest.mark.parametrize("missing", [{"height_std": 0.0}, {"height_std": np.nan}, {"mean_radius": np.nan}])
def test_greenwood_williamson_needs_a_spread_of_summits(missing):
    area = theory.greenwood_williamson_area([1e5, 1e6], SUMMITS | missing, contact_modulus=MODULUS)
    assert np.isnan(area).all()
