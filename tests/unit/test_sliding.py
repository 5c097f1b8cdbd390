"""Steady sliding over a viscoelastic half-space: closed forms, a dense solution, time stepping, and laws."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.arguments.maps import refined
from roughcontact.statistics.sliding import MAX_CONTACTS, sliding_contact

PITCH = 1e-6  # m
LOAD = 1e5  # Pa
SLOW, FAST = 1e6, 1e7  # Pa, moduli at rest and at once


def solid(slow=SLOW, fast=FAST, time=1.0):
    """Return the compliance (1/Pa) of a standard linear solid, a spring before a Kelvin body."""
    return lambda frequency: 1 / fast + (1 / slow - 1 / fast) / (1 + 1j * frequency * time)


def rough(points=32, seed=1, **options):
    arguments = {"hurst": 0.8, "rms_gradient": 0.3, "longest": 24e-6, "shortest": 6e-6} | options
    return rc.self_affine_surface((points, points), PITCH, seed=seed, **arguments)


def slide(face, velocity, compliance=None, load=LOAD, tolerance=1e-4, **options):
    compliance = compliance or solid()
    return sliding_contact(face, compliance, velocity, load, tolerance=tolerance, **options)


def area(contact):
    return np.mean(contact.pressure > 0)


@pytest.mark.parametrize(("across", "points"), [(False, 128), (True, 127)])
def test_a_wave_in_full_contact_has_its_friction_in_closed_form(across, points):
    """Under h = a cos(q x) the pressure is q/2 times E* of the frequency q v: μ = q² a² Im E*/(4 p̄)."""
    length, amplitude = 1e-3, 1e-6
    wave = amplitude * np.cos(2 * np.pi * np.arange(points) / points) + np.zeros((8, 1))
    face = rc.height_map(wave.T if across else wave, length / points)
    q = 2 * np.pi / length
    speed = 0.3 / q
    contact = slide(face, (0, -speed) if across else (speed, 0), load=2e5)
    exact = (q * amplitude) ** 2 * (1 / solid()(q * speed)).imag / (4 * 2e5)
    assert contact.pressure.min() > 0
    assert contact.friction == pytest.approx(exact, rel=1e-4)
    assert abs(contact.friction - exact) <= contact.friction_bound


@pytest.mark.parametrize(("speed", "modulus", "shape"), [(1e-12, SLOW, (32, 32)), (1e6, FAST, (1, 64))])
def test_slow_and_fast_sliding_are_elastic(speed, modulus, shape):
    """At any speed waves across the path are at rest: with the fast modulus alone, ridges across it are."""
    arguments = {"hurst": 0.8, "rms_gradient": 0.3, "longest": 24e-6, "shortest": 6e-6, "seed": 1}
    face = rc.self_affine_surface(shape, PITCH, **arguments)
    elastic = rc.solve_contact(face, contact_modulus=modulus, mean_pressure=LOAD, tolerance=1e-8)
    contact = slide(face, (speed, 0), tolerance=1e-7)
    difference = contact.pressure - elastic["pressure"].values[0]
    assert np.abs(difference).max() < 1e-4 * elastic["pressure"].values.max()
    np.testing.assert_allclose(contact.gap, elastic["gap"].values[0], atol=1e-5 * np.ptp(face.values))
    assert 0 < contact.friction < 1e-4


def dense_operator(shape, compliance, velocity):
    """Return u = A p (points, points; m/Pa) a sum over waves; at the Nyquist limit they run both ways."""
    ny, nx = shape
    y, x = np.mgrid[:ny, :nx]
    kernel = np.zeros(shape)
    for m in range(-(ny // 2), ny // 2 + 1):
        for n in range(-(nx // 2), nx // 2 + 1):
            if m == n == 0:
                continue
            weight = (1 - 0.5 * (2 * abs(m) == ny)) * (1 - 0.5 * (2 * abs(n) == nx))
            qy, qx = 2 * np.pi * m / (ny * PITCH), 2 * np.pi * n / (nx * PITCH)
            symbol = 2 * complex(compliance(velocity[0] * qx + velocity[1] * qy)) / np.hypot(qy, qx)
            phase = PITCH * (qy * y + qx * x)
            kernel += weight * (symbol.real * np.cos(phase) - symbol.imag * np.sin(phase)) / y.size
    return kernel[np.subtract.outer(y.ravel(), y.ravel()) % ny, np.subtract.outer(x.ravel(), x.ravel()) % nx]


def dense_pressure(operator, heights, load):
    """Return p >= 0 of a mean with A p - h - c >= 0, none where p > 0, by an active set."""
    h = heights.ravel()
    active = h > np.quantile(h, 0.3)
    for _ in range(200):
        inside = np.flatnonzero(active)
        system = np.ones((inside.size + 1, inside.size + 1))
        system[:-1, :-1], system[:-1, -1], system[-1, -1] = operator[np.ix_(inside, inside)], -1.0, 0.0
        scale = np.abs(operator).max()
        system[:-1, :-1] /= scale
        answer = np.linalg.solve(system, np.append(h[inside] / scale, load * h.size))
        pressure = np.zeros(h.size)
        pressure[inside] = answer[:-1]
        gap = operator @ pressure - h - answer[-1] * scale
        changed = np.where(active, pressure > 0, gap < 0)
        if (changed == active).all():
            assert pressure.min() >= 0
            assert gap.min() > -1e-9 * np.ptp(h)
            return pressure.reshape(heights.shape)
        active = changed
    raise AssertionError("the active set does not settle")


def symmetric_norm(operator, pressure):
    """Return the root of <p, S p>, S the symmetric part."""
    return np.sqrt(pressure.ravel() @ operator @ pressure.ravel())


def random_case(seed):
    rng = np.random.default_rng(seed)
    shape = (16, 16) if seed % 4 else (15, 16)
    heights = np.fft.irfft2(
        np.fft.rfft2(rng.standard_normal(shape))
        / (1 + 16 * np.add.outer(np.fft.fftfreq(shape[0]) ** 2, np.fft.rfftfreq(shape[1]) ** 2)) ** 2,
        s=shape,
    )
    heights *= 1e-7 * 10 ** rng.uniform(-1, 1)
    moduli = 10 ** rng.uniform(0, 1.2, 3)
    times = 10 ** rng.uniform(-3, 3, 3)

    def compliance(frequency):
        frequency = np.asarray(frequency)[..., None]
        return 1e-6 / (1 + (moduli * 1j * frequency * times / (1 + 1j * frequency * times)).sum(-1))

    angle, speed = rng.uniform(0, 2 * np.pi), PITCH * 10 ** rng.uniform(-3, 3)
    velocity = speed * np.cos(angle), speed * np.sin(angle)
    load = 10 ** rng.uniform(-1, 1) * 1e6 * np.std(heights) / PITCH
    return rc.height_map(heights, PITCH), compliance, velocity, load


def test_the_bound_is_never_below_the_error_of_a_dense_solution():
    """48 random faces, materials, speeds and directions; the bounds of pressure and friction."""
    ratios, frictions = [], []
    for seed in range(48):
        face, compliance, velocity, load = random_case(seed)
        operator = dense_operator(face.shape, compliance, velocity)
        exact = dense_pressure(operator, face.values, load)
        tolerance = 10.0 ** -(1 + seed % 3)
        contact = slide(face, velocity, compliance, load, tolerance)
        error = symmetric_norm(operator, contact.pressure - exact) / symmetric_norm(
            operator, contact.pressure
        )
        assert contact.error_bound <= tolerance
        assert error <= contact.error_bound * (1 + 1e-9) + 1e-9
        close = slide(face, velocity, compliance, load, 1e-8)
        assert symmetric_norm(operator, close.pressure - exact) < 1e-7 * symmetric_norm(operator, exact)
        assert abs(contact.friction - close.friction) <= contact.friction_bound + close.friction_bound
        ratios.append(contact.error_bound / max(error, 1e-12))
        frictions.append(close.friction)
        assert contact.contacts <= MAX_CONTACTS
    assert min(frictions) >= 0
    assert np.median(ratios) < 5


def stepped(face, speed, *, steps, slow=SLOW, fast=FAST, time=1.0, load=LOAD):
    """Return friction and contact area of the solid along x, stepped in time, so many steps a pixel.

    The creep strain z of the Kelvin body follows each point; it is exact for the parabola of the pressure
    through the ends of a step and of the one before. All is seen from the face, whose points are odd in
    number along x: what moves with the half-space is shifted by a phase, exactly.
    """
    points = face.shape[1]
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(face.shape[0], PITCH)[:, None], np.fft.rfftfreq(points, PITCH))
    q[0, 0] = np.inf
    derivative = 2j * np.pi * np.fft.rfftfreq(points, PITCH)
    shift = np.exp(-derivative * PITCH / steps)
    step = PITCH / steps / speed / time
    decay = np.exp(-step)
    first = 1 - (1 - decay) / step  # moments of the step under the weight step exp(-step (1 - s))
    second = 1 - 2 * first / step
    of_ends = (second - first) / 2, 1 - decay - second, (second + first) / 2
    earlier, early, late = (1 / slow - 1 / fast) * np.array(of_ends)

    def filtered(field, symbol):
        return np.fft.irfft(np.fft.rfft(field) * symbol, n=points)

    strain, before_that, before = np.zeros(face.shape), np.full(face.shape, load), np.full(face.shape, load)
    frictions, areas, period = [], [], points * steps
    for _ in range(period + max(period, int(8 / step))):  # until the strain has forgotten its beginning
        strain, before_that, before = filtered(np.stack([strain, before_that, before]), shift)
        crept = strain * decay + early * before + earlier * before_that
        raised = face.values - np.fft.irfft2(np.fft.rfft2(crept) * 2 / q, s=face.shape)
        contact = rc.solve_contact(
            face.copy(data=raised), contact_modulus=1 / (1 / fast + late), mean_pressure=load, tolerance=1e-3
        )
        before_that, before = before, contact["pressure"].values[0]
        strain = crept + late * before
        slope = filtered(face.values + contact["gap"].values[0], derivative)  # of the half-space
        frictions.append(np.mean(before * slope) / load)
        areas.append(np.mean(before > 0))
    return np.mean(frictions[-period:]), np.mean(areas[-period:])


def stepped_case(seed, shortest=16):
    """Return the face, speed, solid and load of a random case whose waves have so many points or more."""
    rng = np.random.default_rng(seed)
    gradient, hurst = rng.uniform(0.05, 0.5), rng.uniform(0.5, 0.9)
    face = rough(45, seed=seed, longest=45e-6, shortest=shortest * PITCH, hurst=hurst, rms_gradient=gradient)
    material = {"slow": SLOW, "fast": SLOW * rng.uniform(2, 10), "time": 1.0}
    return face, 10 ** rng.uniform(-6, -4.5), material, SLOW * gradient * 10 ** rng.uniform(-0.5, 0.3)


def differences_from_stepping(seed, shortest=16):
    """Return the relative difference from a pixel a step, and from half a pixel."""
    face, speed, material, load = stepped_case(seed, shortest)
    contact = slide(face, (speed, 0), solid(**material), load)
    by_pixels, by_halves = (stepped(face, speed, steps=steps, load=load, **material) for steps in (1, 2))
    assert area(contact) == pytest.approx(by_halves[1], abs=0.005)
    return [contact.friction / friction - 1 for friction, _ in (by_pixels, by_halves)]


@pytest.mark.parametrize("seed", [1, 3])
def test_friction_is_that_of_the_solid_stepped_in_time(seed):
    by_pixels, by_halves = differences_from_stepping(seed)
    assert abs(by_pixels) < 5e-3
    assert abs(by_halves) < 1.5e-3


@pytest.mark.slow
@pytest.mark.parametrize(("shortest", "limits"), [(16, (5e-3, 1.5e-3)), (8, (1.2e-2, 3e-3))])
def test_friction_of_random_solids_stepped_in_time(shortest, limits):
    """What is left is of the stepping: half the step leaves a quarter of it, and both together next to none.

    Waves of eight points are short ones for steps of a point.
    """
    differences = np.array([differences_from_stepping(seed, shortest) for seed in range(20)])
    assert (np.abs(differences).max(axis=0) < limits).all()
    by_pixels, by_halves = differences.T
    assert np.abs(by_halves - (by_pixels - by_halves) / 3).max() < 2e-3


@pytest.mark.parametrize("load", [0.03, 0.3, 3.0])
@pytest.mark.parametrize("rate", [0.05, 0.3, 1.0])
def test_a_loss_factor_of_two_takes_few_contacts(load, rate):
    """The loss factor of a solid whose moduli differ 17.94-fold is 2 at most."""
    compliance = solid(1e6, 17.94e6)
    frequencies = np.geomspace(1e-3, 1e3, 1001)
    assert np.max(-compliance(frequencies).imag / compliance(frequencies).real) == pytest.approx(2, abs=1e-3)
    contact = slide(rough(64), (rate * 24e-6 / (2 * np.pi), 0), compliance, load * 3e5)
    assert contact.error_bound <= 1e-4
    assert contact.contacts <= 30


def test_laws_of_scaling():
    face, speed = rough(), 3e-6
    contact = slide(face, (speed, 0), tolerance=1e-8)
    assert contact.friction > 0.05
    larger = rc.height_map(2 * face.values, 2 * PITCH)  # twice as large, twice as fast
    assert slide(larger, (2 * speed, 0), tolerance=1e-8).friction == pytest.approx(contact.friction, rel=1e-6)
    slower = slide(face, (speed / 5, 0), solid(time=5.0), tolerance=1e-8)
    assert slower.friction == pytest.approx(contact.friction, rel=1e-6)
    steeper = slide(face.copy(data=3 * face.values), (speed, 0), load=3 * LOAD, tolerance=1e-8)
    assert steeper.friction == pytest.approx(3 * contact.friction, rel=1e-6)
    stiffer = slide(face, (speed, 0), solid(3 * SLOW, 3 * FAST), 3 * LOAD, tolerance=1e-8)
    assert stiffer.friction == pytest.approx(contact.friction, rel=1e-6)


def test_direction_turns_and_reflects_with_the_map():
    face, speed = rough(), 3e-6
    along_x = slide(face, (speed, 0), tolerance=1e-8)
    turned = slide(rc.height_map(face.values.T, PITCH), (0, speed), tolerance=1e-8)
    np.testing.assert_allclose(turned.pressure.T, along_x.pressure, atol=1.0)
    reflected = slide(rc.height_map(face.values[:, ::-1], PITCH), (-speed, 0), tolerance=1e-8)
    assert reflected.friction == pytest.approx(along_x.friction, rel=1e-7)
    back = slide(face, (-speed, 0), tolerance=1e-8)
    assert abs(back.friction / along_x.friction - 1) > 0.005
    oblique = slide(face, (0.6 * speed, 0.8 * speed), tolerance=1e-8)
    assert oblique.friction == pytest.approx(along_x.friction, rel=0.3)


def test_work_on_the_face_is_what_the_half_space_dissipates():
    face = refined(rough(), 4)
    contact = slide(face, (3e-6, 0), tolerance=1e-8)
    frequencies = 2j * np.pi * np.fft.rfftfreq(face.shape[1], PITCH / 4)
    slope = np.fft.irfft(np.fft.rfft(face.values, axis=1) * frequencies, n=face.shape[1], axis=1)
    work = np.mean(contact.pressure * slope) / LOAD
    assert contact.friction == pytest.approx(work, rel=2e-3)
    assert contact.friction_of_waves.min() >= 0
    assert contact.friction_of_waves.sum() == pytest.approx(contact.friction)


def test_a_flat_face_has_no_friction():
    contact = slide(rc.height_map(np.zeros((8, 8)), PITCH), (1e-6, 0))
    assert contact.friction == contact.friction_bound == 0.0
