"""Power spectra against closed forms and against SurfaceTopography."""

import warnings

import numpy as np
import pytest
from known_surfaces import self_affine
from scipy.ndimage import map_coordinates

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.kernels.waves import wave_power
from roughcontact.surface.roughness.spectrum import angular_spectrum, isotropic_spectrum
from roughcontact.surface.synthetic import self_affine_surface


def area(height):
    return np.prod([n * d for n, d in zip(height.shape, spacing(height), strict=True) if n > 1])


def whole_plane(height):
    """Return the power spectrum C = A |h(q)|^2 of all waves of a map, in the layout of `numpy.fft.fft2`."""
    return area(height) * np.abs(np.fft.fft2(height.values - height.values.mean()) / height.size) ** 2


@pytest.mark.parametrize("shape", [(96, 128), (1, 256), (256, 1)])
def test_the_public_spectrum_makes_up_the_mean_square_height(shape):
    """The integral of C q dq / (2 pi), of a profile of C dq / pi."""
    length = max(shape) * 1e-6
    height = self_affine(shape, 1e-6, (4e-6, length / 8), rms_height=2e-7, seed=3)
    in_micrometres = height.copy(data=1e6 * height.values).assign_attrs(units="um")
    spectrum = rc.power_spectrum(in_micrometres)
    weight = spectrum["wavenumber"] / (2 * np.pi) if 1 not in shape else 1 / np.pi
    mean_square = float((spectrum * weight).sum()) * 2 * np.pi / length
    assert mean_square == pytest.approx(4e-14, rel=1e-9 if 1 in shape else 0.03)
    assert spectrum.attrs["units"] == ("m3" if 1 in shape else "m4")
    assert spectrum.sel(wavenumber=1.5e6, method="nearest") > 0


@pytest.mark.parametrize("shape", [(32, 48), (33, 40), (30, 41), (27, 35), (1, 64), (1, 9), (64, 1)])
def test_the_half_plane_stands_for_all_waves(shape):
    height = height_map(np.random.default_rng(1).standard_normal(shape) + 5, (2e-6, 1e-6))
    full = whole_plane(height)[:, : shape[1] // 2 + 1] / area(height)
    np.testing.assert_allclose(wave_power(height.values), full, rtol=1e-9, atol=1e-12 * full.max())


@pytest.mark.parametrize("shape", [(32, 48), (33, 40), (30, 41), (27, 35)])
def test_directions_are_those_of_the_whole_plane(shape):
    """Against sums along rays through all waves, shifted so that the longest lie in the middle."""
    noise = np.fft.fft2(np.random.default_rng(2).standard_normal(shape))
    qy, qx = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(shape, (2e-6, 1e-6), strict=True))
    dqy, dqx = (2 * np.pi / (n * d) for n, d in zip(shape, (2e-6, 1e-6), strict=True))
    min_step, max_step = min(dqy, dqx), max(dqy, dqx)
    # without those longer than the shorter side, which are counted otherwise
    noise[np.hypot(qy[:, None], qx[None, :]) < max_step * (1 - 1e-9)] = 0
    height = height_map(np.fft.ifft2(noise).real, (2e-6, 1e-6))
    power = whole_plane(height)
    radius = np.arange(1, np.pi / 2e-6 / min_step) * min_step
    radius = radius[radius >= max_step * (1 - 1e-9)]
    theta, power_by_angle = angular_spectrum(height, step=7.5)
    across = np.deg2rad(theta)[:, None]
    coordinates = [
        radius * np.sin(across) / dqy + shape[0] // 2,
        radius * np.cos(across) / dqx + shape[1] // 2,
    ]
    rays = map_coordinates(np.fft.fftshift(power), coordinates, order=1, mode="nearest")
    expected = 2 * (rays * radius).sum(axis=1) * min_step / (2 * np.pi) ** 2
    np.testing.assert_allclose(power_by_angle, expected, rtol=1e-9)


@pytest.mark.parametrize("shape", [(12, 120), (13, 121), (30, 120), (3, 120), (120, 12), (121, 13), (2, 9)])
def test_waves_longer_than_the_shorter_side_keep_their_power_and_run_along_the_longer_one(shape):
    longer, shorter = max(shape), min(shape)
    orders = np.arange(1, min((longer - 1) // shorter, longer // 2) + 1)
    amplitudes = np.random.default_rng(3).uniform(0.5, 1, orders.size)
    coordinate = np.arange(longer)
    wave = sum(
        a * np.cos(2 * np.pi * k * coordinate / longer) for a, k in zip(amplitudes, orders, strict=True)
    )
    lines = np.broadcast_to(wave, (shorter, longer))
    theta, power = angular_spectrum(height_map(lines if shape[1] == longer else lines.T, 1e-6), step=0.01)
    assert theta[np.argmax(power)] == (0 if shape[1] == longer else 90)
    assert power.sum() * np.deg2rad(0.01) == pytest.approx(wave.var(), rel=1e-4)
    # nothing farther off than the next wave that the map could tell from the longest one
    middle = 0 if shape[1] == longer else 90
    angle = np.abs((theta - middle + 90) % 180 - 90)
    is_outside = angle > np.rad2deg(np.arctan(longer / shorter)) + 0.01
    assert (power[is_outside] < 1e-12 * power.max()).all()


def test_a_single_wave():
    """a cos(q x): |h(q)|^2 = a^2/4 at +q and at -q, and nothing elsewhere."""
    ny, nx, a = 20, 30, 3e-7
    x = np.arange(nx)[None, :] + np.zeros((ny, 1))
    height = height_map(a * np.cos(2 * np.pi * 4 * x / nx + 0.4), (2e-6, 1e-6))
    power = wave_power(height.values)
    assert power[0, 4] == pytest.approx(a**2 / 4, rel=1e-12)
    assert power.sum() == pytest.approx(power[0, 4], rel=1e-12)
    q, of_shells = isotropic_spectrum(height)
    assert q[of_shells.argmax()] == pytest.approx(2 * np.pi * 4 / 30e-6, rel=0.05)


@pytest.mark.parametrize("hurst", [0.3, 0.8])
def test_slope_of_a_self_affine_surface(hurst):
    """C(q) ~ q^(-2 - 2H) for a surface, q^(-1 - 2H) for a profile (Persson et al. 2005)."""
    options = {"hurst": hurst, "shortest": 6e-6, "longest": 400e-6, "rms_height": 1e-6}
    for shape, slope in (((256, 320), -2 - 2 * hurst), ((1, 4096), -1 - 2 * hurst)):
        height = self_affine_surface(shape, (1.5e-6, 1e-6), **options)
        q, power = isotropic_spectrum(height)
        inside = (q > 2 * np.pi / 100e-6) & (q < 2 * np.pi / 10e-6)
        exponent = np.polyfit(np.log(q[inside]), np.log(power[inside]), 1)[0]
        assert exponent == pytest.approx(slope, abs=0.05)


def test_other_software_finds_the_same_spectrum():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from SurfaceTopography import Topography
    height = self_affine((96, 128), (2.0, 1.1), (4.0, 100.0), hurst=0.7, rms_height=1.0, seed=3)
    topography = Topography(height.values.T, (140.8, 192.0), periodic=True)
    q, averaged, areal = topography.power_spectrum_from_area(
        collocation=np.arange(0.5, 32) * 2 * np.pi / 192, return_map=True
    )
    full = area(height) * wave_power(height.values)
    np.testing.assert_allclose(full, np.asarray(areal).T[:, : full.shape[1]], rtol=1e-9, atol=1e-20)
    ours_q, ours = isotropic_spectrum(height)
    shared = [int(np.argmin(np.abs(ours_q - value))) for value in q[:30]]
    np.testing.assert_allclose(ours[shared], averaged[:30], rtol=1e-9, atol=1e-20)


@pytest.mark.parametrize("shape", [(40, 60), (2, 60)])
def test_shells_end_at_the_nyquist_limit_of_the_coarser_pitch(shape):
    height = height_map(np.random.default_rng(1).standard_normal(shape), (3.0, 1.0))
    q, power = isotropic_spectrum(height)
    assert (np.diff(q) > 0).all()
    assert q[-1] <= np.pi / 3 * 1.03
    assert (power > 0).all()


@pytest.mark.parametrize(("across", "direction"), [((0, 1), 0.0), ((1, 0), 90.0)])
def test_the_wave_as_long_as_a_square_map_has_a_direction(across, direction):
    """Of a cos(q r) its direction holds 2 A |h|^2 q dq / (2 pi)^2: |h| = a/2, q = dq, A dq^2 = (2 pi)^2."""
    y, x = np.indices((48, 48)) / 48
    height = height_map(3e-7 * np.cos(2 * np.pi * (across[0] * y + across[1] * x)), 1e-6)
    theta, power = angular_spectrum(height)
    assert theta[np.argmax(power)] == direction
    assert power.max() == pytest.approx((3e-7) ** 2 / 2, rel=1e-9)


def test_directions_turn_with_the_map():
    """Of a map with x and y exchanged they are counted from y, of its mirror image the other way round."""
    values = np.random.default_rng(4).standard_normal((41, 35))
    theta, power = angular_spectrum(height_map(values, (1e-6, 2e-6)))
    for seen, steps, direction in (
        (values.T, (2e-6, 1e-6), 90 - theta),
        (values[:, ::-1], (1e-6, 2e-6), -theta),
    ):
        _, spectrum = angular_spectrum(height_map(seen, steps))
        order = np.argsort(direction % 180)
        np.testing.assert_allclose(spectrum, power[order], rtol=1e-12)


def test_white_noise_is_the_same_in_all_directions():
    height = height_map(np.random.default_rng(2).standard_normal((400, 400)), 1.0)
    theta, power = angular_spectrum(height)
    assert theta.size == 360
    assert power.std() / power.mean() < 0.15
    # the circle within the Nyquist limits holds pi/4 of the waves
    assert power.sum() * np.deg2rad(0.5) == pytest.approx(np.pi / 4, rel=2e-2)
