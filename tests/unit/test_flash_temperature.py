"""Flash temperatures against Carslaw and Jaeger: a Hertzian source, and waves at any speed."""

import numpy as np
import pytest

import roughcontact as rc


@pytest.fixture(scope="module")
def ball():
    """Return radius, largest pressure and solution of a Hertzian contact."""
    points, curvature_radius, radius = 512, 2.0, 0.06
    x = (np.arange(points) - points / 2 + 0.5) / points
    height = rc.height_map(-(x[:, None] ** 2 + x[None] ** 2) / (2 * curvature_radius), 1 / points)
    load = 4 * radius**3 / (3 * curvature_radius)
    contact = rc.solve_contact(height, contact_modulus=1.0, mean_pressure=load, tolerance=1e-8)
    return x, radius, 3 * load / (2 * np.pi * radius**2), contact


def test_a_slow_hertzian_source(ball):
    """q0 sqrt(1 - r2/a2) warms its middle by pi q0 a/(4k); the surface falls as 1 - r2/(2 a2) of that."""
    x, radius, largest, contact = ball
    friction, speed, conductivities = 0.3, 2.0, [3.0, 1.0]
    warm = rc.flash_temperature(
        contact, friction_coefficient=friction, speed=speed, thermal_conductivity=conductivities
    )["temperature_rise"].values[0]
    middle = np.pi * friction * speed * largest * radius / (4 * sum(conductivities))
    # the mean is left out, and with it what the neighbours in a square period add: a lattice sum
    heat = friction * speed * contact["pressure"].values.mean()
    warm_contact = warm + 3.900265 * heat / (2 * np.pi * sum(conductivities))
    assert warm_contact.max() == pytest.approx(middle, rel=1e-3)
    r = np.hypot(x[:, None], x)
    inside = r < 0.9 * radius
    np.testing.assert_allclose(
        warm_contact[inside], middle * (1 - r[inside] ** 2 / (2 * radius**2)), atol=1e-3 * middle
    )


@pytest.mark.parametrize("direction", ["x", "y"])
@pytest.mark.parametrize("peclet", [None, 0.1, 10.0, 1e4])
def test_a_wave_of_heat_is_exact_at_any_speed(direction, peclet):
    """exp(i q x) in a solid that moves: temperature exp(i q x - s z), s^2 = q^2 + i q_x v/kappa."""
    points, wavelength = 64, 1e-3
    x = np.arange(points) / points
    wave = np.cos(2 * np.pi * (x[None] if direction == "x" else x[:, None])) * np.ones((points, points))
    height = rc.height_map(1e-7 * wave, wavelength / points)
    contact = rc.solve_contact(height, contact_modulus=1e9, mean_pressure=1e7, tolerance=1e-8)
    assert (contact["pressure"] > 0).all()
    friction, speed, (still, sliding), q = 0.2, 0.5, (50.0, 0.3), 2 * np.pi / wavelength
    diffusivity = None if peclet is None else speed / q / peclet
    warm = rc.flash_temperature(
        contact,
        friction_coefficient=friction,
        speed=speed,
        thermal_conductivity=[still, sliding],
        thermal_diffusivity=diffusivity,
    )["temperature_rise"].values[0]
    carried = (peclet or 0.0) * (direction == "x")
    phase = np.exp(2j * np.pi * (x[None] if direction == "x" else x[:, None]))
    amplitude = friction * speed * 1e9 * q / 2 * 1e-7
    expected = (amplitude * phase / (q * (still + sliding * np.sqrt(1 + 1j * carried)))).real
    np.testing.assert_allclose(warm, expected * np.ones((points, points)), atol=1e-9 * np.abs(expected).max())


@pytest.mark.cases
def test_how_much_too_cool_heat_across_the_gap_makes_a_patch(conductivities, peclet, largest, mean):
    """Against equal temperatures in the contact alone, which heat alone enters: a dense solution."""
    n, length, radius, diffusivity = 96, 1e-3, 5e-5, 14e-6
    x = (np.arange(n) - n / 2 + 0.5) * length / n
    ball = rc.height_map(-(x[:, None] ** 2 + x**2) / 2e-3, length / n)
    load = 4 * 1e9 * radius**3 / 3e-3 / length**2
    contact = rc.solve_contact(ball, contact_modulus=1e9, mean_pressure=load, tolerance=1e-6)
    speed, touching = 2 * diffusivity * peclet / radius, np.nonzero(contact["pressure"].values[0])
    q_y, q_x = (2 * np.pi * np.fft.fftfreq(n, length / n)[index] for index in np.ix_(range(n), range(n)))
    square = q_y**2 + q_x**2
    square[0, 0] = 1e30  # the mean flows away
    rows, columns = (np.subtract.outer(indices, indices) % n for indices in touching)
    rises = [
        np.fft.ifft2(1 / (k * np.sqrt(square + 1j * q_x * v / diffusivity))).real[rows, columns]
        for k, v in zip(conductivities, (0.0, speed), strict=True)
    ]
    heat = 0.2 * speed * contact["pressure"].values[0][touching]
    exact = rises[0] @ np.linalg.solve(rises[0] + rises[1], rises[1] @ heat)
    warm = rc.flash_temperature(
        contact,
        friction_coefficient=0.2,
        speed=speed,
        thermal_conductivity=conductivities,
        thermal_diffusivity=diffusivity,
    )
    assert warm["max_flash_temperature"].item() / exact.max() == pytest.approx(largest, abs=0.01)
    assert warm["mean_flash_temperature"].item() / exact.mean() == pytest.approx(mean, abs=0.01)


def test_what_has_no_meaning_is_refused(ball):
    contact = ball[3]
    good = {"friction_coefficient": 0.3, "speed": "1 m/s", "thermal_conductivity": [50.0, 50.0]}
    assert rc.flash_temperature(contact, **good)["max_flash_temperature"] > 0
    conductivities = [{"thermal_conductivity": conductivity} for conductivity in ([50.0], 50.0)]
    for wrong in ({"speed": 0.0}, {"friction_coefficient": -1}, *conductivities):
        with pytest.raises(rc.SettingsError, match=next(iter(wrong))):
            rc.flash_temperature(contact, **good | wrong)
