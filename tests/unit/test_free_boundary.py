"""Bodies of finite size on the half-space, against Hertz, Sneddon, Love, and solutions of their own."""

from itertools import pairwise

import numpy as np
import pytest
from free_bodies import rough_body
from scipy.integrate import dblquad, quad
from scipy.special import j0, jv

import roughcontact as rc
from roughcontact.arguments.maps import height_map
from roughcontact.contact.elasticity.closed_forms import hertz, hertz_ellipse
from roughcontact.contact.elasticity.free_space import FADE, TruncatedKernel, love, transform_of_pixels
from roughcontact.contact.elasticity.halfspace import HalfSpace
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.layers import LayeredPair
from roughcontact.contact.elasticity.media import elastic_medium
from roughcontact.kernels.fourier import wavevectors

POINTS = 256
STEEL = {"boundary": "free", "contact_modulus": 1.0}


def coordinates(points=POINTS):
    """Return x and y of a square of side 1, in pixels' centres, from its middle."""
    x = (np.arange(points) + 0.5) / points - 0.5
    return np.meshgrid(x, x)


def paraboloid(radius_x, radius_y, points=POINTS):
    x, y = coordinates(points)
    return height_map(-(x**2) / (2 * radius_x) - y**2 / (2 * radius_y), 1 / points)


def rough_body_map(seed, points):
    """Return the map of a rough ball, block or ellipsoid, and a force over E*."""
    heights, force = rough_body(seed, points)
    return height_map(heights, 1 / points), force


@pytest.mark.parametrize("influence", ["sampled", "elements"])
def test_kernel_is_positive(influence):
    kernel = TruncatedKernel(0.4, Elasticity(influence=influence))
    assert kernel(*wavevectors((120, 96), (1 / 96, 1 / 96)), (1 / 96, 1 / 96)).min() > 0


def test_kernel_of_elements_is_exact_up_to_its_reach():
    shape, spacing = (120, 96), (1 / 96, 1 / 96)
    kernel = TruncatedKernel(0.4, Elasticity(influence="elements"))
    symbol = kernel(*wavevectors(shape, spacing), spacing)
    symbol[0, 0] = kernel.mean_displacement(shape, spacing)
    response = np.fft.irfft2(symbol, shape)[:30, :20]
    np.testing.assert_allclose(response, love((30, 20), spacing), rtol=1e-12)


@pytest.mark.parametrize("shape", [(12, 10), (8, 14)])
def test_transform_of_an_even_field(shape):
    quarter = love((shape[0] // 2 + 1, shape[1] // 2 + 1), (0.1, 0.3))
    rows, columns = (np.minimum(np.arange(n), n - np.arange(n)) for n in shape)
    np.testing.assert_allclose(
        transform_of_pixels(shape, (0.1, 0.3)), np.fft.rfft2(quarter[np.ix_(rows, columns)]), atol=1e-12
    )


def test_sampled_symbol_is_the_transform_of_the_kernel():
    """2 times the integral of J0(q r), the kernel 1/(pi r) in polar coordinates, with the linear fade."""
    qy, qx = wavevectors((64, 64), (1 / 64, 1 / 64))
    reach, outer = 0.4, 0.4 * FADE
    symbol = TruncatedKernel(reach)(qy, qx, (1 / 64, 1 / 64))
    for row, column in ((0, 1), (1, 1), (0, 3), (7, 20), (32, 32)):
        q = np.hypot(qy[row, 0], qx[0, column])
        exact = quad(lambda r, q: 2 * j0(q * r), 0, reach, args=(q,), limit=200)[0]
        fade = quad(lambda r, q: 2 * j0(q * r) * (outer - r), reach, outer, args=(q,), limit=200)[0]
        assert symbol[row, column] == pytest.approx(exact + fade / (outer - reach), rel=1e-7)


def test_love_is_the_integral_over_a_pixel():
    dy, dx = 0.5, 0.2
    integral, _ = dblquad(
        lambda y, x: 1 / np.pi / np.hypot(2 * dy + y, 3 * dx + x), -dx / 2, dx / 2, -dy / 2, dy / 2
    )
    assert love((4, 5), (dy, dx))[2, 3] == pytest.approx(integral, rel=1e-9)


@pytest.mark.parametrize("ratio", [0.15, 0.2, 0.3, 0.4, 0.45])
def test_ball(ratio):
    radius, x = 10.0, coordinates()[0]
    force = 4 * ratio**3 / (3 * radius)
    exact = hertz(force, radius, 1.0)
    contact = rc.solve_contact(paraboloid(radius, radius), force=force, tolerance=1e-6, **STEEL)
    assert -contact["approach"].item() == pytest.approx(exact["approach"], rel=1e-5)
    assert contact["pressure"].max().item() == pytest.approx(exact["max_pressure"], rel=1e-3)
    area = rc.contact_statistics(contact, flow="never")["relative_contact_area"].item()
    assert np.sqrt(area / np.pi) == pytest.approx(ratio, rel=2e-3)
    # the gap beside the contact, Johnson (1985), eq. (3.42a)
    r = np.hypot(x, x.T)
    out = r > 1.2 * ratio
    r = r[out]
    bulge = (2 - (r / ratio) ** 2) * np.arcsin(ratio / r) + np.sqrt((r / ratio) ** 2 - 1)
    gap = ratio**2 / radius * (bulge / np.pi - 1) + r**2 / (2 * radius)
    np.testing.assert_allclose(contact["gap"].values[0][out], gap, atol=3e-5 * exact["approach"])


def test_a_map_that_whole_blocks_do_not_cover():
    """Its contact is first looked for in blocks of 3 points: 190 and 187 of them leave one."""
    radius = 10.0
    ball = paraboloid(radius, radius, 190)[:, 1:-2]
    force = 4 * 0.2**3 / (3 * radius)
    contact = rc.solve_contact(ball, force=force, tolerance=1e-5, **STEEL)
    assert -contact["approach"].item() == pytest.approx(hertz(force, radius, 1.0)["approach"], rel=1e-4)


@pytest.mark.parametrize(("radius_x", "radius_y"), [(10.0, 4.0), (2.0, 40.0)])
def test_ellipse(radius_x, radius_y):
    force = 4e-4
    exact = hertz_ellipse(force, (radius_x, radius_y), 1.0)
    contact = rc.solve_contact(paraboloid(radius_x, radius_y), force=force, tolerance=1e-6, **STEEL)
    assert -contact["approach"].item() == pytest.approx(exact["approach"], rel=2e-5)
    assert contact["pressure"].max().item() == pytest.approx(exact["max_pressure"], rel=1e-3)
    area = rc.contact_statistics(contact, flow="never")["relative_contact_area"].item()
    assert area == pytest.approx(np.pi * exact["major"] * exact["minor"], rel=4e-3)


@pytest.mark.parametrize("longer", [1e6, 1e9, 1e14])
def test_a_long_ellipse_is_a_cylinder(longer):
    """Johnson (1985), section 4.2: p0 = E* b/(2 R); the ellipse differs by (b/a)^2 ln(a/b)."""
    smooth = hertz_ellipse(1.0, (5e-3 * longer, 5e-3), 1e11)
    assert smooth["max_pressure"] == pytest.approx(1e11 * smooth["minor"] / 0.01, rel=20 / longer + 1e-14)


def test_flat_punch_with_edges():
    """F = 2 E* a δ (Sneddon 1965): the edges of a disc of pixels are half a pixel inside, about."""
    x, y = coordinates()
    inside = np.hypot(x, y) < 0.3
    disc = np.where(inside, 0.0, -0.1)
    contact = rc.solve_contact(height_map(disc, 1 / POINTS), force=1e-3, tolerance=1e-6, **STEEL)
    radius = np.sqrt(inside.mean() / np.pi)
    assert 1e-3 / -contact["approach"].item() / (2 * radius) == pytest.approx(1, abs=0.15 / (POINTS * radius))
    assert (contact["contact"].values[0] == inside).all()
    pressure = contact["pressure"].values[0][np.hypot(x, y) < 0.2]
    exact = 1e-3 / (2 * np.pi * radius * np.sqrt(radius**2 - (x**2 + y**2)[np.hypot(x, y) < 0.2]))
    np.testing.assert_allclose(pressure, exact, rtol=8e-3)


def free_norm(pressure):
    """Return the root of the mean of p times its displacement without neighbours, by direct convolution."""
    n = pressure.shape[0]
    kernel = TruncatedKernel(1.5)
    symbol = kernel(*wavevectors((4 * n, 4 * n), (1 / n, 1 / n)), (1 / n, 1 / n))
    symbol[0, 0] = kernel.mean_displacement((4 * n, 4 * n), (1 / n, 1 / n))
    displacement = np.fft.irfft2(symbol * np.fft.rfft2(pressure, (4 * n, 4 * n)))[:n, :n]
    return np.sqrt((displacement * pressure).mean())


@pytest.mark.parametrize("seed", range(6))
def test_bound_is_above_the_error(seed):
    body, force = rough_body_map(seed, 96)
    exact = rc.solve_contact(body, force=force, tolerance=1e-9, **STEEL)["pressure"].values[0]
    periodic = HalfSpace((96, 96), (1.0, 1.0))
    norm = np.sqrt((exact * periodic.displacement(exact)).mean())
    for tolerance in (0.1, 1e-2, 1e-4):
        contact = rc.solve_contact(body, force=force, tolerance=tolerance, **STEEL)
        error = contact["pressure"].values[0] - exact
        assert contact["error_bound"].item() <= tolerance
        periodic_error = np.sqrt((error * periodic.displacement(error)).mean())
        for size in (free_norm(error), periodic_error):
            assert size / norm <= contact["error_bound"].item() <= 1.5 * size / norm


def test_asperity_far_from_the_contact_of_coarse_grid():
    """A spike that means of blocks do not show is in contact all the same."""
    ball = paraboloid(5.0, 5.0)
    spiked = ball.copy()
    spiked[20, 200] = 0.001
    contact = rc.solve_contact(spiked, force=1e-4, tolerance=1e-6, **STEEL)
    assert contact["contact"].values[0, 20, 200] == 1
    assert contact["gap"].values.min() > 1e-6 * contact["approach"].item()
    assert rc.solve_contact(ball, force=1e-4, **STEEL)["contact"].values[0, 20, 200] == 0


def test_numbers_do_not_depend_on_units_and_orientation():
    body, force = rough_body_map(3, 96)
    contact = rc.solve_contact(body, force=force, **STEEL)
    small = height_map(body.values * 1e-6, 1e-6 / 96)
    scaled = rc.solve_contact(small, boundary="free", contact_modulus="1 GPa", force=force * 1e-12 * 1e9)
    np.testing.assert_allclose(scaled["pressure"].values, contact["pressure"].values * 1e9, rtol=1e-6, atol=1)
    assert scaled["approach"].item() == pytest.approx(contact["approach"].item() * 1e-6, rel=1e-9)
    turned = rc.solve_contact(body.copy(data=body.values.T), force=force, **STEEL)
    np.testing.assert_allclose(turned["pressure"].values[0].T, contact["pressure"].values[0], atol=2e-4)


def test_pixels_longer_than_wide():
    x = (np.arange(128) + 0.5) / 128 - 0.5
    y = (np.arange(64) + 0.5) / 64 - 0.5
    ball = height_map(-(y[:, None] ** 2 + x**2) / 20, (1 / 64, 1 / 128))
    force = 4 * 0.3**3 / 30
    contact = rc.solve_contact(ball, force=force, **STEEL)
    assert -contact["approach"].item() == pytest.approx(0.3**2 / 10, rel=1e-4)


def test_hardness_limits_the_pressure():
    force, ball = 4 * 0.2**3 / 30, paraboloid(10.0, 10.0, 128)
    elastic = rc.solve_contact(ball, force=force, **STEEL)
    limit = 0.6 * elastic["pressure"].max().item()
    contact = rc.solve_contact(ball, force=force, hardness=limit, **STEEL)
    assert contact["pressure"].max().item() == pytest.approx(limit)
    assert contact["error_bound"].item() <= 1e-4
    assert contact["pressure"].values.mean() == pytest.approx(force)
    assert contact["contact"].sum() > elastic["contact"].sum()
    with pytest.raises(rc.SettingsError, match=r"force .* hardness"):
        rc.solve_contact(ball, force=2 * limit, hardness=limit, **STEEL)


BASE = {"youngs_modulus": 2.0, "poissons_ratio": 0.3}
FILM = {"youngs_modulus": 8.0, "poissons_ratio": 0.25, "thickness": 0.05}


@pytest.mark.parametrize(
    "body",
    [
        BASE | {"layers": [FILM]},
        BASE | {"layers": [FILM | {"thickness": 0.6}]},
        BASE | {"layers": [FILM | {"thickness": 1e-6}]},
        BASE | {"layers": [FILM | {"youngs_modulus": 0.2, "thickness": 0.02}]},
        BASE | {"layers": [FILM | {"youngs_modulus": 200.0, "thickness": 2.0}]},
        BASE | {"layers": [FILM, FILM | {"youngs_modulus": 1.0, "thickness": 0.1}]},
        {"base": "rigid", "layers": [FILM | {"poissons_ratio": 0.45, "thickness": 0.1}]},
    ],
)
def test_layers_displace_as_the_integral_of_their_compliance(body):
    """Below p = (1 - r^2/a^2)^2, of transform 16 pi a^2 J3(qa)/(qa)^3, by Hankel integrals."""
    pair, cell, step, a = elastic_medium([body]), (320, 320), 1 / 128, 0.4
    x = (np.arange(128) - 63.5) * step
    r = np.hypot(x[:, None], x)
    pressure = np.zeros(cell)
    pressure[:128, :128] = np.maximum(1 - (r / a) ** 2, 0) ** 2
    kernel = TruncatedKernel(1.15, Elasticity(medium=pair))
    symbol = kernel(*wavevectors(cell, (step, step)), (step, step))
    symbol[0, 0] = kernel.mean_displacement(cell, (step, step))
    assert symbol.min() > 0
    displacement = np.fft.irfft2(symbol * np.fft.rfft2(pressure), cell)
    edges = np.linspace(1e-12, 1200, 241)
    for column in (64, 90, 127):
        exact = 0.0
        for interval in pairwise(edges):
            exact += quad(
                lambda q, at=r[64, column]: (
                    16 * a**2 * pair.factor(np.array([q]))[0] * jv(3, q * a) / (q * a) ** 3 * j0(q * at)
                ),
                *interval,
                limit=200,
            )[0]
        assert displacement[64, column] == pytest.approx(exact, abs=2e-7 * displacement[64, 64])


@pytest.mark.parametrize("thickness", [0.05, 1e-4])
def test_thin_layers_take_no_more_waves_than_thick_ones(thickness, monkeypatch):
    counts, factor = [], LayeredPair.factor
    monkeypatch.setattr(LayeredPair, "factor", lambda self, q: counts.append(q.size) or factor(self, q))
    pair = elastic_medium([BASE | {"layers": [FILM | {"thickness": thickness}]}])
    change = pair.change_of_point_force(np.array([0.3, 1.5]))
    assert sum(counts) < 50_000
    # far from a thin film the base alone counts; E* is that of the film
    softer = (8.0 / (1 - 0.25**2)) / (2.0 / (1 - 0.3**2))
    np.testing.assert_allclose(1 + change * np.pi * [0.3, 1.5], softer, rtol=thickness)


def test_layers_of_the_material_of_their_base_and_far_thicker_than_the_contact_change_nothing():
    force, ball = 4 * 0.2**3 / 30, paraboloid(10.0, 10.0, 128)
    half_space = rc.solve_contact(ball, boundary="free", bodies=[BASE], force=force)
    film = BASE | {"layers": [FILM | {"youngs_modulus": 2.0002, "poissons_ratio": 0.3}]}
    contact = rc.solve_contact(ball, boundary="free", bodies=[film], force=force)
    assert contact["approach"].item() == pytest.approx(half_space["approach"].item(), rel=1e-4)
    thick = {"youngs_modulus": 1.0, "poissons_ratio": 0.3, "layers": [BASE | {"thickness": 60.0}]}
    contact = rc.solve_contact(ball, boundary="free", bodies=[thick], force=force)
    np.testing.assert_allclose(contact["pressure"].values, half_space["pressure"].values, atol=1e-4)


@pytest.mark.parametrize("body", [BASE | {"layers": [FILM]}, {"base": "rigid", "layers": [FILM]}])
@pytest.mark.parametrize("hardness", [None, 0.1])
def test_bound_is_above_the_error_with_layers(body, hardness):
    rough, force = rough_body_map(3, 96)
    problem = {"boundary": "free", "bodies": [body], "force": force, "hardness": hardness}
    exact = rc.solve_contact(rough, tolerance=1e-9, **problem)["pressure"].values[0]
    layers = elastic_medium([body])
    periodic = HalfSpace((96, 96), (1.0, 1.0), Elasticity(medium=layers))
    norm = np.sqrt((exact * periodic.displacement(exact)).mean())
    cell = (400, 400)  # where the images do not reach
    kernel = TruncatedKernel(1.5, Elasticity(medium=layers))
    symbol = kernel(*wavevectors(cell, (1 / 96, 1 / 96)), (1 / 96, 1 / 96))
    symbol[0, 0] = kernel.mean_displacement(cell, (1 / 96, 1 / 96))
    for tolerance in (0.1, 1e-2, 1e-4):
        contact = rc.solve_contact(rough, tolerance=tolerance, **problem)
        error = contact["pressure"].values[0] - exact
        displacement = np.fft.irfft2(symbol * np.fft.rfft2(error, cell), cell)[:96, :96]
        size = np.sqrt((displacement * error).mean())
        assert size / norm <= contact["error_bound"].item() <= tolerance


def test_layers_with_pixels_of_constant_pressure_are_refused():
    with pytest.raises(rc.SettingsError, match=r"influence, .*layers of a finite body"):
        rc.solve_contact(
            paraboloid(10.0, 10.0, 32),
            boundary="free",
            bodies=[BASE | {"layers": [FILM]}],
            force=1e-3,
            influence="elements",
        )


def test_forces_keep_their_order():
    forces = [1e-3, 1e-4]
    contact = rc.solve_contact(paraboloid(10.0, 10.0, 64), force=forces, **STEEL)
    assert contact["force"].values.tolist() == forces
    np.testing.assert_allclose(contact["pressure"].mean(("y", "x")), forces)
    assert contact["mean_pressure"].values.tolist() == forces  # over an area of 1


def test_contact_at_the_border_is_refused_with_a_size():
    with pytest.raises(
        rc.HeightMapError, match=r"border of the map, [\d.]+ m × [\d.]+ m, .* a map of (1\.\d+) m"
    ) as caught:
        rc.solve_contact(paraboloid(10.0, 10.0, 64), force=4 * 0.55**3 / 30, **STEEL)
    side = float(str(caught.value).partition("a map of ")[2].split(" m")[0])
    assert 1.1 < side < 1.5
    # no side becomes smaller
    words = "map, 1.00 m × 250 mm, .* a map of 1.10 m × 452 mm would do"
    strip = paraboloid(10.0, 10.0, 64).isel(y=slice(24, 40))
    with pytest.raises(rc.HeightMapError, match=words):
        rc.solve_contact(strip, force=4 * 0.2**3 / 30, **STEEL)
    block = height_map(np.zeros((64, 64)), 1 / 64)
    with pytest.raises(rc.HeightMapError, match="surround it by lower heights"):
        rc.solve_contact(block, force=1e-3, **STEEL)


@pytest.mark.cases
def test_options_that_do_not_fit(options, message):
    with pytest.raises(rc.SettingsError, match=message):
        rc.solve_contact(paraboloid(10.0, 10.0, 32), **STEEL | {"force": 1e-3} | options)


def test_profiles_are_refused():
    profile = height_map(-(np.linspace(-1, 1, 64)[None, :] ** 2), 1 / 64)
    with pytest.raises(rc.HeightMapError, match=r"endless ridge .* boundary: periodic"):
        rc.solve_contact(profile, force=1e-3, **STEEL)
