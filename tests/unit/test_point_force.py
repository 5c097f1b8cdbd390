"""Stresses below a pressure without neighbours, against Hertz's and the sum of Boussinesq's point forces."""

import numpy as np
import pytest

from roughcontact.contact.elasticity.point_force import TAPER, PointForce, half_space_amplitudes
from roughcontact.contact.elasticity.subsurface import subsurface_stress


def huber(r, z, a, nu):
    """Return the stresses (rr, tt, zz, rz; tension positive) over p0 below Hertz's pressure (Huber 1904)."""
    s = r**2 + z**2 - a**2
    u = (s + np.sqrt(s**2 + 4 * a**2 * z**2)) / 2
    root, angle = np.sqrt(u), np.arctan(a / np.sqrt(u))
    cone, depth = (1 - 2 * nu) / 3 * a**2 / r**2 * (1 - (z / root) ** 3), z / root
    bulk = depth**3 * a**2 * u / (u**2 + a**2 * z**2)
    rr = cone + bulk + depth * ((1 - nu) * u / (a**2 + u) + (1 + nu) * root / a * angle - 2)
    tt = -cone - depth * (2 * nu + (1 - nu) * u / (a**2 + u) - (1 + nu) * root / a * angle)
    return rr, tt, -bulk, -r * z**2 / (u**2 + a**2 * z**2) * a**2 * root / (u + a**2)


@pytest.mark.parametrize("a", [0.3, 0.45])
@pytest.mark.parametrize("depth", [0.1, 0.48, 1.0, 4.0])
def test_hertz_on_and_off_the_axis(a, depth):
    n, nu, z = 256, 0.3, depth * a
    x = (np.arange(n) + 0.5) / n - 0.5
    r = np.hypot(x[:, None], x)
    pressure = np.sqrt(np.maximum(1 - (r / a) ** 2, 0))
    xx, yy, zz, yz, xz, xy = subsurface_stress(pressure, (1 / n, 1 / n), poissons_ratio=nu, images=False)(z)
    rr, tt, normal, shear = huber(r, z, a, nu)
    cos, sin = x / r, x[:, None] / r
    expected = (rr * cos**2 + tt * sin**2, rr * sin**2 + tt * cos**2, normal, shear * sin, shear * cos)
    for component, exact in zip((xx, yy, zz, yz, xz), expected, strict=True):
        np.testing.assert_allclose(component, exact, atol=1e-3)
    np.testing.assert_allclose(xy, (rr - tt) * cos * sin, atol=1e-3)
    # on the axis, Johnson (1985), eq. (3.45)
    middle = slice(n // 2 - 1, n // 2 + 1)
    axis_r = -(1 + nu) * (1 - depth * np.arctan(1 / depth)) + 0.5 / (1 + depth**2)
    assert zz[middle, middle].mean() == pytest.approx(-1 / (1 + depth**2), abs=3e-4)
    assert xx[middle, middle].mean() == pytest.approx(axis_r, abs=3e-4)


def test_points_of_any_pressure_act_as_point_forces():
    """Four pixels below the surface the sum of Boussinesq's stresses, of an oblong map and uneven pixels."""
    shape, (dy, dx), nu, z = (20, 70), (1.0, 1.4), 0.25, 5.0
    pressure = np.random.default_rng(5).random(shape) * np.hanning(20)[:, None] * np.hanning(70)
    stress = subsurface_stress(pressure, (dy, dx), poissons_ratio=nu, images=False)(z)
    y, x = np.indices(shape) * np.array([dy, dx])[:, None, None]
    for row, column in ((0, 0), (9, 35), (19, 69), (4, 60)):
        across, along = y[row, column] - y, x[row, column] - x
        r2 = across**2 + along**2
        big = np.sqrt(r2 + z**2)
        force = pressure * dy * dx / (2 * np.pi)
        slope = (1 - 2 * nu) / (big * (big + z))
        rr, tt = slope - 3 * z * r2 / big**5, -slope + (1 - 2 * nu) * z / big**3
        cos2, sin2 = (np.divide(v**2, r2, out=np.full(shape, 0.5), where=r2 > 0) for v in (along, across))
        tangent = np.divide(along * across, r2, out=np.zeros(shape), where=r2 > 0)
        exact = [
            (force * component).sum()
            for component in (
                rr * cos2 + tt * sin2,
                rr * sin2 + tt * cos2,
                -3 * z**3 / big**5,
                -3 * z**2 * across / big**5,
                -3 * z**2 * along / big**5,
                (rr - tt) * tangent,
            )
        ]
        np.testing.assert_allclose(stress[:, row, column], exact, atol=2e-5)


def test_short_waves_do_not_notice_the_fade():
    """Waves of a length of the reach over 20 to 30 have the amplitudes of the half-space."""
    q = np.linspace(140.0, 199.0, 8)
    for depth in (0.0, 0.01, 0.03):
        faded = PointForce(q, 1.0, 1e-3).amplitudes(depth, 0.3)
        np.testing.assert_allclose(faded, half_space_amplitudes(q * depth, 0.3), atol=2e-5)


def test_mean_stress_of_a_cell_is_that_of_the_faded_force():
    """At q = 0 the normal stress of a force on a disc: all of it but what passes beyond."""
    normal, shear, along, crests = PointForce(np.array([0.0]), 1.0, 1e-3).amplitudes(0.2, 0.3)[:, 0]
    beyond_reach, beyond_end = ((0.2 / np.hypot(0.2, r)) ** 3 for r in (1.0, TAPER))
    assert 1 - beyond_reach < -normal < 1 - beyond_end
    assert shear == 0
    assert along == crests
