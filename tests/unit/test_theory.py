"""The theories at their limits, and against independent quadrature and published numbers."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import erf

from roughcontact.contact.elasticity.closed_forms import hertz
from roughcontact.statistics import theory
from roughcontact.statistics.finite_body import greenwood_tripp


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
    areas = theory.greenwood_williamson_area(pressure, SUMMITS, contact_modulus=MODULUS)
    assert areas == pytest.approx(area, rel=1e-5)


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


BALL = hertz(1e-4, 1.0, 1.0)  # E* = 1, R = 1


def rough_ball(alpha, mu, tip=1e-3):
    """Return spread and density of summits for the numbers of Johnson (1985), eqs. (13.49), (13.50)."""
    spread = alpha * BALL["approach"]
    summits = {"density": mu / (8 / 3 * spread * np.sqrt(2 * tip)), "mean_radius": tip, "height_std": spread}
    return summits, greenwood_tripp(1e-4, 1.0, summits, contact_modulus=1.0)


@pytest.mark.parametrize("mu", [4.0, 17.0])
def test_greenwood_tripp_of_a_smooth_ball_is_hertz(mu):
    _, ball = rough_ball(1e-5, mu)
    assert ball["max_pressure"] == pytest.approx(BALL["max_pressure"], rel=3e-4)
    assert ball["loaded_radius"] == pytest.approx(BALL["contact_radius"], rel=3e-4)
    assert np.isnan(ball["contact_area"])  # more than touches: summits so near are not independent


def test_greenwood_tripp_leaves_hertz_where_it_is_published():
    """Below α = 0.05 the error of Hertz is at most about 7 % (Johnson 1985, p. 421), for μ = 4 and 17."""
    errors = [1 - rough_ball(0.05, mu)[1]["max_pressure"] / BALL["max_pressure"] for mu in (4.0, 17.0)]
    assert max(errors) == pytest.approx(0.07, abs=0.005)
    assert min(errors) > 0.03


def test_greenwood_tripp_of_hard_balls():
    """Without displacement of the bulk: F = 2π R s c ∫ F_{3/2} dt from t0 on, with p(0) = c F_{3/2}(t0)."""
    summits, ball = rough_ball(1e4, 4.0)
    spread = summits["height_std"]
    scale = 4 / 3 * summits["density"] * np.sqrt(summits["mean_radius"]) * spread**1.5

    def moment(order, t):
        return quad(lambda u: u**order * np.exp(-((t + u) ** 2) / 2), 0, 12)[0] / np.sqrt(2 * np.pi)

    t = brentq(lambda t: moment(1.5, t) - ball["max_pressure"] / scale, -2, 8)
    assert 2 * np.pi * spread * scale * moment(2.5, t) / 2.5 == pytest.approx(1e-4, rel=3e-3)
    area = np.pi * summits["density"] * summits["mean_radius"] * spread
    assert ball["contact_area"] == pytest.approx(2 * np.pi * spread * area * moment(2, t) / 2, rel=3e-3)


@pytest.mark.parametrize(
    "summits",
    [
        {"density": 0.0, "mean_radius": np.nan, "height_std": 0.0},
        {"density": 6e10, "mean_radius": 1e9, "height_std": 9e-23},  # rounding
    ],
)
def test_greenwood_tripp_needs_a_spread_of_summits(summits):
    assert np.isnan([*greenwood_tripp(0.5, 3e-3, summits, contact_modulus=1e11).values()]).all()
