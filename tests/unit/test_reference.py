"""The closed forms, held against each other, against quadrature and against published numbers."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import special
from scipy.integrate import quad

from validation import closed_forms
from validation.axisymmetric import ring_contact, rings
from validation.layered_sphere import rigid_base_factor, sphere_on_layer

D, WAVELENGTH, MODULUS = 1.5e-6, 2e-3, 3e9
FULL = closed_forms.westergaard_full_contact_pressure(D, WAVELENGTH, MODULUS)


def integral(function, points=()):
    """Return the mean of an even, periodic function of x over one wavelength."""
    edges = [0.0, *points, WAVELENGTH / 2]
    parts = [quad(function, a, b, epsabs=0, epsrel=1e-11)[0] for a, b in pairwise(edges)]
    return sum(parts) / (WAVELENGTH / 2)


@pytest.mark.parametrize("ratio", [0.01, 0.3, 0.9])
def test_westergaard_pressure_carries_the_load_over_the_contact(ratio):
    half_width = closed_forms.westergaard_contact_share(ratio) * WAVELENGTH / 2

    def pressure(x):
        return float(closed_forms.westergaard_pressure(x, WAVELENGTH, ratio * FULL, ratio))

    assert integral(pressure, [half_width]) == pytest.approx(ratio * FULL, rel=1e-9)
    assert pressure(0.999 * half_width) > 0
    assert pressure(1.001 * half_width) == 0
    assert pressure(0.0) == pytest.approx(2 * ratio * FULL / np.sqrt(ratio), rel=1e-12)


@pytest.mark.parametrize("ratio", [0.01, 0.3, 0.9])
def test_westergaard_gap_closes_at_the_edge_and_has_the_stated_mean(ratio):
    half_width = closed_forms.westergaard_contact_share(ratio) * WAVELENGTH / 2

    def gap(x):
        return float(closed_forms.westergaard_gap(x, WAVELENGTH, D, ratio))

    assert gap(0.999 * half_width) == 0
    assert 0 < gap(1.01 * half_width) < 0.05 * D
    assert integral(gap, [half_width]) == pytest.approx(closed_forms.westergaard_mean_gap(D, ratio), rel=1e-8)


def test_westergaard_gap_without_load_is_that_of_the_undeformed_wave():
    x = np.linspace(0, WAVELENGTH, 50)
    expected = D - D * np.cos(2 * np.pi * x / WAVELENGTH)
    np.testing.assert_allclose(closed_forms.westergaard_gap(x, WAVELENGTH, D, 0.0), expected, atol=1e-12 * D)
    assert closed_forms.westergaard_mean_gap(D, 0.0) == D


@pytest.mark.parametrize("ratio", [0.02, 0.4, 0.8, 1.7])
def test_westergaard_surface_under_its_pressure_leaves_its_gap(ratio):
    """The displacement by the Fourier sum, the heights and the gap must fit: u - h - gap is one constant."""
    n = 1 << 15
    x = (np.arange(n) + 0.5) * WAVELENGTH / n
    pressure = closed_forms.westergaard_pressure(x, WAVELENGTH, ratio * FULL, ratio)
    q = 2 * np.pi * np.fft.rfftfreq(n, WAVELENGTH / n)
    symbol = np.concatenate([[0.0], 2 / (MODULUS * q[1:])])
    spectrum = np.fft.rfft(pressure)
    remainder = np.fft.irfft(symbol * spectrum, n) - D * np.cos(2 * np.pi * x / WAVELENGTH)
    remainder -= closed_forms.westergaard_gap(x, WAVELENGTH, D, min(ratio, 1.0))
    assert np.ptp(remainder) < 2e-6 * D
    energy = np.sum(symbol * np.abs(spectrum / n) ** 2)
    assert energy == pytest.approx(closed_forms.westergaard_energy(D, WAVELENGTH, MODULUS, ratio), rel=2e-6)


@pytest.mark.parametrize("ratio", [0.05, 0.5, 0.95])
def test_westergaard_energy_gap_and_stiffness_belong_together(ratio):
    """dU/dū = -p̄ and dp̄/dū = -stiffness, by central differences."""
    step = 1e-5 * ratio
    gap = [closed_forms.westergaard_mean_gap(D, r) for r in (ratio - step, ratio + step)]
    energy = [
        closed_forms.westergaard_energy(D, WAVELENGTH, MODULUS, r) for r in (ratio - step, ratio + step)
    ]
    assert (energy[1] - energy[0]) / (gap[1] - gap[0]) == pytest.approx(-ratio * FULL, rel=1e-6)
    stiffness = closed_forms.westergaard_stiffness(D, WAVELENGTH, MODULUS, ratio)
    assert 2 * step * FULL / (gap[0] - gap[1]) == pytest.approx(stiffness, rel=1e-6)


def test_westergaard_mean_displacement_of_the_wave_in_its_other_form():
    """With a the half width over λ: (ū - D)/(2D) = -1/2 + cos²(πa)/2 + sin²(πa) ln sin(πa)."""
    for ratio in (0.01, 0.4, 0.99):
        a = closed_forms.westergaard_contact_share(ratio) / 2
        sine = np.sin(np.pi * a)
        closed_form = -0.5 + np.cos(np.pi * a) ** 2 / 2 + sine**2 * np.log(sine)
        assert (closed_forms.westergaard_mean_gap(D, ratio) - D) / (2 * D) == pytest.approx(
            closed_form, rel=1e-12
        )


def test_westergaard_full_contact():
    assert closed_forms.westergaard_contact_share(1.0) == 1.0
    assert closed_forms.westergaard_contact_share(3.0) == 1.0
    assert closed_forms.westergaard_mean_gap(D, 2.0) == 0.0
    assert closed_forms.westergaard_stiffness(D, WAVELENGTH, MODULUS, 1.0) == np.inf
    assert closed_forms.westergaard_energy(D, WAVELENGTH, MODULUS, 5.0) == pytest.approx(
        D * FULL / 4, rel=1e-14
    )


def test_jgh_asymptotes_meet_the_tabulated_shares():
    shares = closed_forms.JGH_CONTACT_SHARE
    assert closed_forms.jgh_contact_share_low(0.05) == pytest.approx(shares[0.05], rel=0.09)
    assert closed_forms.jgh_contact_share_high(0.9) == pytest.approx(shares[0.9], abs=2e-3)
    ratios = np.array(sorted(shares))
    assert (np.diff([shares[r] for r in ratios]) > 0).all()


def test_jgh_low_load_is_two_hertz_contacts_per_square():
    """Near a crest the product wave has curvature D (2π/λ)²; a square of side λ holds two crests."""
    ratio, length = 1e-3, 1.0
    amplitude, modulus = 0.01, 1.0
    full = closed_forms.jgh_full_contact_pressure(amplitude, length, modulus)
    radius = 1 / (amplitude * (2 * np.pi / length) ** 2)
    contact = closed_forms.hertz(ratio * full * length**2 / 2, radius, modulus)
    share = 2 * np.pi * contact["contact_radius"] ** 2 / length**2
    assert closed_forms.jgh_contact_share_low(ratio) == pytest.approx(share, rel=1e-12)


def test_hertz_energy_is_the_work_of_the_force():
    force, radius, modulus = 0.7, 3e-3, 5e9
    steps = np.linspace(0, 1, 20001) ** 1.5 * force
    approach = np.array([closed_forms.hertz(f, radius, modulus)["approach"] for f in steps])
    work = np.trapezoid(steps, approach)
    result = closed_forms.hertz(force, radius, modulus)
    assert result["energy"] == pytest.approx(work, rel=1e-6)
    mean = force / (np.pi * result["contact_radius"] ** 2)
    assert result["max_pressure"] == pytest.approx(1.5 * mean, rel=1e-12)


def test_lattice_constant_by_an_ewald_sum():
    """The potential at a point of a square lattice of charges in a uniform background is -3.9002649."""
    from scipy.special import erfc

    n = np.arange(-6, 7)
    distance = np.hypot(*np.meshgrid(n, n))[np.hypot(*np.meshgrid(n, n)) > 0]
    # splitting width √π: both sums are then the same, and converge within a few shells
    terms = erfc(np.sqrt(np.pi) * distance) / distance
    potential = 2 * terms.sum() - 4
    assert potential == pytest.approx(-np.pi * closed_forms.LATTICE_CONSTANT, rel=1e-12)


def test_zero_frequency_of_nogi_and_kato_by_quadrature():
    from scipy.integrate import dblquad

    ly, lx, modulus = 0.7, 1.9, 2.5
    value = dblquad(lambda y, x: 1 / np.hypot(x, y), 0, np.pi / lx, 0, np.pi / ly, epsabs=1e-9)[0]
    expected = lx * ly / (4 * np.pi**2) * 2 / modulus * 4 * value
    assert closed_forms.nogi_kato_zero_frequency(ly, lx, modulus) == pytest.approx(expected, rel=1e-7)
    assert closed_forms.nogi_kato_zero_frequency(1, 1, 1) == pytest.approx(
        closed_forms.NOGI_KATO_CONSTANT, rel=1e-14
    )
    assert pytest.approx(1.12220, abs=5e-6) == closed_forms.NOGI_KATO_CONSTANT


def test_periodic_hertz_tends_to_hertz():
    hertz = closed_forms.hertz(1e-3, 1e-3, 1e9)
    repeated = closed_forms.periodic_hertz(1e-3, 1e-3, 1e9, period=1.0)
    for name in ("contact_radius", "max_pressure"):
        assert repeated[name] == pytest.approx(hertz[name], rel=1e-9)
    shift = closed_forms.LATTICE_CONSTANT * 1e-3 / (1e9 * 1.0)
    assert repeated["approach"] == pytest.approx(hertz["approach"] - shift, rel=1e-9)
    assert repeated["energy"] == pytest.approx(hertz["energy"] - 1e-3 * shift / 2, rel=1e-9)


def test_periodic_hertz_energy_is_the_work_of_the_force():
    radius, modulus, period = 3e-3, 5e9, 1e-3  # a_H/L up to 0.1: every correction has a say
    force = 0.7 * (0.1 * period) ** 3 * 4 * modulus / (3 * radius)
    steps = np.linspace(0, 1, 20001) ** 1.5 * force
    approach = np.array([closed_forms.periodic_hertz(f, radius, modulus, period)["approach"] for f in steps])
    work = np.trapezoid(steps, approach)
    result = closed_forms.periodic_hertz(force, radius, modulus, period)
    assert result["energy"] == pytest.approx(work, rel=1e-6)


def test_periodic_hertz_peak_and_radius_carry_the_force():
    """To first order: (2/3)π a² p0 is the force, whatever the neighbours do."""
    result = closed_forms.periodic_hertz(1.0, 0.75, 1.0, period=50.0)  # a_H = 0.825, x³ = 4.5e-6
    force = 2 / 3 * np.pi * result["contact_radius"] ** 2 * result["max_pressure"]
    assert force == pytest.approx(1.0, rel=1e-10)


def test_sum_of_inverse_cubes_over_the_square_lattice():
    """Direct sum to 400 shells, and the integral of 1/r³ beyond."""
    n = np.arange(-400, 401)
    distance = np.hypot(*np.meshgrid(n, n))
    inside = distance[(distance > 0) & (distance <= 400)]
    total = (inside**-3.0).sum() + 2 * np.pi / 400
    assert total == pytest.approx(closed_forms.LATTICE_CUBES, rel=1e-5)


def test_hertz_displacement_is_the_approach_less_the_sphere():
    force, radius, modulus = 0.7, 3e-3, 5e9
    hertz = closed_forms.hertz(force, radius, modulus)
    r = np.linspace(0, hertz["contact_radius"], 9)
    displacement = closed_forms.hertz_displacement(r, hertz["contact_radius"], hertz["max_pressure"], modulus)
    np.testing.assert_allclose(displacement, hertz["approach"] - r**2 / (2 * radius), rtol=1e-12)


@pytest.mark.parametrize("wavenumber", [1e-2, 0.7, 3.0, 20.0])
def test_hertz_spectrum_by_quadrature(wavenumber):
    from scipy.special import j0

    a, p0 = 1.3, 2.0

    def ring(t):  # r = a sin t takes the edge out of the root
        return 2 * np.pi * a**2 * p0 * np.cos(t) ** 2 * np.sin(t) * j0(wavenumber * a * np.sin(t))

    value = quad(ring, 0, np.pi / 2, epsabs=0, epsrel=1e-10)[0]
    assert closed_forms.hertz_spectrum(wavenumber, a, p0) == pytest.approx(value, rel=1e-7)


@pytest.mark.parametrize("shape", [(16, 24), (15, 21), (1, 32)])
def test_full_contact_flattens_the_map(shape):
    heights = np.random.default_rng(3).standard_normal(shape) * 1e-6
    steps = (2e-6, 3e-6)
    pressure = closed_forms.full_contact_fluctuation(heights, steps, MODULUS)
    qy = 2 * np.pi * np.fft.fftfreq(shape[0], steps[0])[:, None]
    qx = 2 * np.pi * np.fft.fftfreq(shape[1], steps[1])[None, :]
    q = np.hypot(qy, qx)
    q[0, 0] = np.inf
    displaced = np.fft.ifft2(2 / (MODULUS * q) * np.fft.fft2(pressure)).real
    np.testing.assert_allclose(displaced, heights - heights.mean(), atol=1e-12 * np.ptp(heights))
    energy = np.mean(pressure * displaced) / 2
    assert closed_forms.full_contact_energy(heights, steps, MODULUS) == pytest.approx(energy, rel=1e-12)


def test_full_contact_of_the_wave_is_westergaards():
    n = 64
    x = np.arange(n) * WAVELENGTH / n
    heights = np.tile(D * np.cos(2 * np.pi * x / WAVELENGTH), (4, 1))
    steps = (WAVELENGTH / n, WAVELENGTH / n)
    pressure = closed_forms.full_contact_fluctuation(heights, steps, MODULUS)
    assert -pressure.min() == pytest.approx(FULL, rel=1e-12)
    assert closed_forms.full_contact_energy(heights, steps, MODULUS) == pytest.approx(D * FULL / 4, rel=1e-12)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_a_sphere_on_a_layer_between_hertz_and_springs(nu):
    thick = sphere_on_layer(0.1, 2.0, 1e3, nu)
    hertz = closed_forms.hertz(0.1**3 * 4 / 6, 2.0, 1.0)
    assert thick.approach == pytest.approx(hertz["approach"], rel=1e-3)
    assert thick.force == pytest.approx(0.1**3 * 4 / 6, rel=1e-3)
    if nu < 0.5:  # springs of t (1 - 2 nu)/((1 - nu)^2 E*): delta = a²/2R, F = pi a⁴/(4 R spring)
        thin = sphere_on_layer(0.1, 2.0, 2e-3, nu)
        spring = 2e-3 * (1 - 2 * nu) / (1 - nu) ** 2
        assert thin.approach == pytest.approx(0.1**2 / 4, rel=5e-3)
        assert thin.force == pytest.approx(np.pi * 0.1**4 / 8 / spring, rel=0.03)


@pytest.mark.slow
def test_the_equation_of_a_sphere_on_a_layer_is_fulfilled_by_displacements():
    """The pressure that belongs to phi, by its Hankel transform, displaces the surface to the sphere."""
    a, radius, thickness, nu = 0.8, 3.0, 1.0, 0.4
    solution = sphere_on_layer(a, radius, thickness, nu)
    x, weight = np.polynomial.legendre.leggauss(300)
    x, weight = (x + 1) * a / 2, weight * a / 2
    q, share = np.polynomial.legendre.leggauss(4000)
    q, share = (q + 1) * 100, share * 100
    factor = rigid_base_factor(q * thickness, nu)
    kernel = 2 / np.pi * ((1 - factor) * share * np.cos(np.outer(x, q))) @ np.cos(np.outer(q, x))
    phi = np.linalg.solve(np.eye(300) - kernel * weight, (solution.approach - x**2 / radius) / np.pi)
    assert 2 * np.pi * weight @ phi == pytest.approx(solution.force, rel=1e-6)
    # p(q) = 2 pi int phi cos(qx) dx transforms the pressure, u(r) = int 2 f p(q) J0(qr) dq / 2 pi
    transform = 2 * np.pi * np.cos(np.outer(q, x)) @ (phi * weight)
    for r in (0.0, 0.3, 0.6):
        displaced = (2 * factor * transform * special.j0(q * r) * share).sum() / (2 * np.pi)
        assert displaced == pytest.approx(solution.approach - r**2 / (2 * radius), rel=2e-3)


@pytest.mark.parametrize(
    ("nu", "ratios"), [(0.5, (1.857, 3.371, 6.085)), (0.3, (1.591, 2.416, 3.546))], ids=["0.5", "0.3"]
)
def test_a_layer_stiffens_a_sphere_as_computed_elsewhere(nu, ratios):
    for size, expected in zip((0.5, 1.0, 1.6), ratios, strict=True):
        solution = sphere_on_layer(size, 10.0, 1.0, nu)
        hertz = 4 / 3 * np.sqrt(10.0) * solution.approach**1.5
        assert solution.force / hertz == pytest.approx(expected, abs=6e-4)


def test_the_edge_of_a_uniform_pressure_closes_the_gap_of_a_flattened_summit():
    """At the edge of the circle the displacement is that of point loads, summed along chords from there."""
    load, radius, hardness, modulus = 0.3, 5.0, 0.02, 1.5
    edge = np.sqrt(load / (np.pi * hardness))
    chords, _ = quad(lambda angle: 2 * edge * np.cos(angle), -np.pi / 2, np.pi / 2)
    displaced = hardness / (np.pi * modulus) * chords  # a point load F displaces by F/(pi E* r)
    approach = closed_forms.flattened_summit_approach(load, radius, hardness, modulus)
    assert approach == pytest.approx(edge**2 / (2 * radius) + displaced, rel=1e-12)


@pytest.mark.parametrize("share", [0.01, 0.3, 0.9])
def test_flat_punches_carry_a_flattened_summit(share):
    """Punches of radius t with the pressure 1/sqrt(t^2 - r^2) add up to one that is uniform over a circle."""
    radius = closed_forms.flattened_summit_radius(share)
    carried, _ = quad(lambda t: 4 / np.pi * t**2 / np.sqrt(1 - t**2), 0, radius)
    assert carried == pytest.approx(share, rel=1e-9)


def test_rings_give_hertz_and_the_flattened_sphere():
    """The elastic end, alone and repeated, and the end at which the whole contact is at the hardness."""
    body, radius, load = rings(np.linspace(0, 0.3, 601)), 2.0, 2e-3
    shape = -(body.radius**2) / (2 * radius)
    for period in (np.inf, 1.0):
        hertz = closed_forms.hertz(load, radius, 1.0)
        repeated = closed_forms.periodic_hertz(load, radius, 1.0, 1.0)
        shift = closed_forms.LATTICE_CONSTANT * load  # the rings leave the uniform part out
        reference = hertz["approach"] if period == np.inf else repeated["approach"] + shift
        contact = ring_contact(body, shape, load, period=period)
        assert contact.approach == pytest.approx(reference, rel=1e-5)
        assert not contact.depth.any()
    hardness = 0.01
    flattened = ring_contact(body, shape, load, hardness=hardness)
    edge = np.sqrt(load / hardness / np.pi)
    assert np.sqrt(body.area @ (flattened.pressure > 0) / np.pi) == pytest.approx(edge, abs=1e-3)
    expected = closed_forms.flattened_summit_approach(load, radius, hardness, 1.0)
    assert flattened.approach == pytest.approx(expected, rel=5e-3)
    assert body.area @ flattened.pressure == pytest.approx(load, rel=1e-9)


def test_the_energy_of_a_cycle_at_small_loads_is_that_of_johnson():
    """Johnson (1985), eq. (7.58): it falls with the third power of the load, by (2 - nu)/(18 a G mu P)."""
    share, ratio = 1e-3, 0.3
    energy = closed_forms.mindlin_deresiewicz_energy(share, 1.0, 1.0, shear_modulus=1.0, poissons_ratio=ratio)
    assert energy == pytest.approx((2 - ratio) / 18 * share**3, rel=0.01)


@pytest.mark.parametrize("ratio", [0.05, 0.5, 0.95])
def test_westergaards_ridges_under_hertz_by_quadrature(ratio):
    share = quad(lambda s: 2 * s * closed_forms.westergaard_contact_share(ratio * s), 0, 1)[0]
    stiffness = quad(lambda s: 2 * s * closed_forms.westergaard_stiffness(1.0, np.pi, 1.0, ratio * s), 0, 1)[
        0
    ]
    np.testing.assert_allclose(closed_forms.westergaard_under_hertz(ratio), (share, stiffness), rtol=1e-8)
