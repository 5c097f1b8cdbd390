"""Stresses below the surface: a wave, Hertz, equilibrium, and the load at which a body yields there."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

import roughcontact as rc
from roughcontact import height_map, self_affine_surface, write_dataset
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.variables import describe
from roughcontact.contact.elasticity.subsurface import subsurface_stress, tresca, von_mises
from roughcontact.results.collect import collect_statistics, summary_table
from roughcontact.statistics import subsurface
from roughcontact.statistics.targets import target_loads
from roughcontact.surface.synthetic import rough_reference_surface, westergaard_surface
from validation import closed_forms, depth_integral

SOFT = {"youngs_modulus": 2e9, "poissons_ratio": 0.4, "yield_stress": 5e7}
HARD = {"youngs_modulus": 2e11, "poissons_ratio": 0.3, "yield_stress": 4e8}


def rough_pressure(shape=(24, 30)):
    """Return a pressure with all waves of a map, none negative."""
    return np.random.default_rng(0).random(shape)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("along_x", [True, False])
def test_wave(ratio, along_x):
    points = 64
    wave = np.cos(2 * np.pi * 3 * np.arange(points) / points) * np.ones((4, 1))
    steps = (0.7, 0.2)
    q = 2 * np.pi * 3 / (points * 0.2)
    stress_at = subsurface_stress(
        wave if along_x else wave.T, steps if along_x else steps[::-1], poissons_ratio=ratio
    )
    for depth in (0.0, 0.2 / q, 1 / q, 2.5 / q):
        stress = stress_at(depth)
        reference = closed_forms.wave_von_mises(q * depth, ratio)
        assert von_mises(stress).max() == pytest.approx(reference, rel=1e-12, abs=1e-14)
        reference = closed_forms.wave_tresca(q * depth, ratio)
        assert tresca(stress).max() == pytest.approx(reference, rel=1e-12, abs=1e-14)
    assert np.abs(stress_at(1 / q)[4 if along_x else 3]).max() == pytest.approx(np.exp(-1), rel=1e-12)


def test_the_surface_carries_the_pressure_and_no_shear():
    pressure = rough_pressure()
    stress = subsurface_stress(pressure, (1.0, 2.0), poissons_ratio=0.3)(0.0)
    np.testing.assert_allclose(stress[2], -pressure, atol=1e-12)
    np.testing.assert_allclose(stress[3:5], 0, atol=1e-12)


def test_stresses_are_in_equilibrium():
    """Their divergence vanishes: two of its terms by Fourier series, the third by differences in depth."""
    shape, steps, depth, step = (32, 48), (1.0, 0.8), 3.0, 1e-4
    pressure = np.fft.irfft2(
        np.fft.rfft2(rough_pressure(shape)) * (np.hypot(*np.indices((32, 25))) < 9), s=shape
    )
    stress_at = subsurface_stress(pressure, steps, poissons_ratio=0.27)
    xx, yy, zz, yz, xz, xy = stress_at(depth)
    slope = (stress_at(depth + step) - stress_at(depth - step)) / (2 * step)
    qy, qx = (2j * np.pi * np.fft.fftfreq(n, d) for n, d in zip(shape, steps, strict=True))

    def along(field, axis):
        return np.fft.ifft2(np.fft.fft2(field) * (qy[:, None] if axis == "y" else qx)).real

    for divergence in (
        along(xx, "x") + along(xy, "y") + slope[4],
        along(xy, "x") + along(yy, "y") + slope[3],
        along(xz, "x") + along(yz, "y") + slope[2],
    ):
        assert np.abs(divergence).max() < 1e-7 * np.abs(slope).max()
    assert np.abs(zz).max() > 0


@pytest.mark.parametrize("shape", [(12, 16), (13, 16), (12, 17), (13, 17)])
def test_stresses_turn_with_the_pressure(shape):
    """With all waves of the grid, those at the Nyquist limit included."""
    pressure, (dy, dx) = rough_pressure(shape), (1.0, 0.7)
    xx, yy, zz, yz, xz, xy = subsurface_stress(pressure, (dy, dx), poissons_ratio=0.3)(0.4)
    for turned, steps, reference in (
        (pressure.T, (dx, dy), [part.T for part in (yy, xx, zz, xz, yz, xy)]),
        (pressure[:, ::-1], (dy, dx), [part[:, ::-1] for part in (xx, yy, zz, yz, -xz, -xy)]),
        (pressure[::-1], (dy, dx), [part[::-1] for part in (xx, yy, zz, -yz, xz, -xy)]),
    ):
        stresses = subsurface_stress(turned, steps, poissons_ratio=0.3)(0.4)
        np.testing.assert_allclose(stresses, reference, atol=1e-12)


def test_invariants_of_any_stress():
    tensor = np.random.default_rng(3).standard_normal((3, 3, 50))
    tensor += tensor.swapaxes(0, 1)
    stress = np.array([tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))])
    deviator = tensor - np.einsum("iik->k", tensor) / 3 * np.eye(3)[:, :, None]
    np.testing.assert_allclose(von_mises(stress), np.sqrt(1.5 * (deviator**2).sum(axis=(0, 1))))
    principal = np.linalg.eigvalsh(np.moveaxis(tensor, -1, 0))
    np.testing.assert_allclose(tresca(stress), np.ptp(principal, axis=1))
    assert (tresca(stress) <= 2 / np.sqrt(3) * von_mises(stress) * (1 + 1e-12)).all()


def test_closed_form_of_hertz_has_the_numbers_of_johnson():
    """0.62 p0 at 0.48 a for ν = 0.3 (Johnson 1985, section 3.4)."""
    optimum = minimize_scalar(
        lambda z: -closed_forms.hertz_von_mises(z, 0.3), bounds=(0.1, 2), method="bounded"
    )
    assert -optimum.fun == pytest.approx(0.62, abs=5e-3)
    assert optimum.x == pytest.approx(0.48, abs=5e-3)


@pytest.mark.parametrize("ratio", [0.3, 0.45])
def test_hertz(ratio):
    """The copies of the contact press with its mean pressure, 0.004 p0: the rest is Johnson's."""
    points, radius = 256, 0.06
    x = (np.arange(points) + 0.27) / points - 0.5
    pressure = np.sqrt(np.maximum(1 - (x[:, None] ** 2 + x[None, :] ** 2) / radius**2, 0))
    columns = subsurface.stress_columns(pressure, (1 / points, 1 / points), poissons_ratio=ratio)
    best = minimize_scalar(
        lambda z: -closed_forms.hertz_von_mises(z, ratio), bounds=(0.1, 2), method="bounded"
    )
    assert columns["max_von_mises_stress"] == pytest.approx(-best.fun, abs=0.004)
    assert columns["max_von_mises_depth"] == pytest.approx(best.x * radius, rel=0.02)
    assert columns["max_tresca_stress"] == pytest.approx(-best.fun, abs=0.004)
    assert columns["max_von_mises_x"] == pytest.approx(0.5, abs=0.01)
    assert columns["max_von_mises_y"] == pytest.approx(0.5, abs=0.01)
    axis = subsurface.profile_depths(pressure.shape, (1 / points, 1 / points)) / radius
    inside = (axis > 0.3) & (axis < 1.5)
    reference = closed_forms.hertz_von_mises(axis[inside], ratio)
    np.testing.assert_allclose(columns["von_mises_profile"][inside], reference, atol=0.006)


@pytest.mark.parametrize("length", [2, 5, 16, 512], ids="{} points long".format)
@pytest.mark.parametrize("limit", [0.1, 0.3, 0.5, 0.6])
def test_volume_above_yield_of_a_wave(limit, length):
    """Plane strain, ν = 0.5: √3 qz e^(-qz), the same along x, is above the limit between two depths.

    The limits go up to 0.94 of the largest stress, the waves from the shortest one to the whole window.
    """
    wave = np.cos(2 * np.pi * np.arange(512 - 512 % length) / length)[None, :]
    q = 2 * np.pi / length
    columns = subsurface.stress_columns(wave, (1.0, 1.0), poissons_ratio=0.5, yield_stress=limit)
    z = np.linspace(0, 8, 100001)
    between = z[np.sqrt(3) * z * np.exp(-z) > limit]
    reference = closed_forms.wave_volume_above(limit)
    assert reference == pytest.approx(between[-1] - between[0], rel=1e-3)
    assert columns["volume_above_yield"] * q == pytest.approx(reference, rel=0.005)


@pytest.mark.parametrize("share", [0.6, 0.8, 0.95])
def test_volume_above_yield_that_changes_along_a_wave(share):
    """At ν = 0.2 the stress is e^(-qz) √(0.36 cos²(qx) + 3 (qz)²), largest below crests and troughs."""
    ratio, q = 0.2, 2 * np.pi / 360
    wave = np.cos(q * np.arange(360))[None, :]
    reduced = np.linspace(0, 8, 8001)
    limit = share * closed_forms.wave_von_mises(reduced, ratio).max()
    columns = subsurface.stress_columns(wave, (1.0, 1.0), poissons_ratio=ratio, yield_stress=limit)

    def share_above(z):
        cosine_squared = ((limit * np.exp(z)) ** 2 - 3 * z**2) / (1 - 2 * ratio) ** 2
        return 2 / np.pi * np.arccos(np.sqrt(np.clip(cosine_squared, 0, 1)))

    reference = quad(share_above, 0, 8, limit=500, epsabs=1e-4)[0]
    assert columns["volume_above_yield"] * q == pytest.approx(reference, rel=0.005)


def test_sum_over_depths_has_the_volume_of_a_wave():
    """The sum that rough maps are held against, and its stress below a pressure with all waves."""
    for along, shape in (((7.0, 1.0), (1, 64)), ((1.0, 0.5), (64, 3))):
        wave = np.cos(2 * np.pi * np.arange(64) / 64).reshape(-1, 1 if shape[1] == 3 else 64)
        limits = [0.3, 0.6]
        largest, volumes = depth_integral.volume_above(
            wave * np.ones(shape), along, poissons_ratio=0.5, limits=limits
        )
        assert largest == pytest.approx(np.sqrt(3) / np.e, rel=1e-4)
        reference = [closed_forms.wave_volume_above(limit) for limit in limits]
        np.testing.assert_allclose(volumes * 2 * np.pi / 64, reference, rtol=2e-3)
    for shape in ((24, 31), (15, 16)):
        pressure, steps = rough_pressure(shape), (1.3, 0.7)
        stress_at = subsurface_stress(pressure, steps, poissons_ratio=0.27)
        for depth in (0.0, 0.4, 3.0):
            stress = depth_integral.von_mises_below(pressure, steps, depth, poissons_ratio=0.27)
            np.testing.assert_allclose(stress, von_mises(stress_at(depth)), atol=1e-14)


def rough_contact(shape, step, load, **surface):
    """Return the pressure of a self-affine surface of unit gradient and modulus."""
    height = self_affine_surface(shape, step, rms_gradient=1.0, **surface)
    contact = rc.solve_contact(height, contact_modulus=1.0, mean_pressure=load, tolerance=1e-5)
    return contact["pressure"].values[0]


@pytest.mark.cases
def test_rough_maps_have_the_stresses_of_hundreds_of_depths(shape, step, load, surface):
    pressure, steps, ratio = rough_contact(shape, step, load, **surface), (np.max(step), 1.0), 0.3
    columns = subsurface.stress_columns(pressure, steps, poissons_ratio=ratio)
    limits = [share * columns["max_von_mises_stress"] for share in (0.6, 0.8, 0.95)]
    largest, volumes = depth_integral.volume_above(pressure, steps, poissons_ratio=ratio, limits=limits)
    assert columns["max_von_mises_stress"] == pytest.approx(largest, rel=1e-3)
    for limit, volume in zip(limits, volumes, strict=True):
        above = subsurface.stress_columns(pressure, steps, poissons_ratio=ratio, yield_stress=limit)
        assert above["volume_above_yield"] == pytest.approx(volume, rel=0.005)
    stress_at = subsurface_stress(pressure, steps, poissons_ratio=ratio)
    least_stress = 0.86 * columns["max_von_mises_stress"]  # √3/2 of the largest stress of Tresca, or more
    stresses_nearby = map(stress_at, columns["max_von_mises_depth"] * np.geomspace(0.3, 3, 120))
    shears = [
        tresca(stress[:, von_mises(stress) >= least_stress]).max(initial=0) for stress in stresses_nearby
    ]
    assert columns["max_tresca_stress"] == pytest.approx(max(shears), rel=1e-3)


@pytest.mark.parametrize("shape", [(12, 120), (120, 12), (24, 120), (60, 120), (120, 120), (1, 120)])
def test_a_wave_in_a_window_of_any_shape(shape):
    """The wave goes along the longer side: √3/e at the depth 1/q, whatever the shorter one."""
    length, step = max(shape), 1e-6
    axis = shape.index(length) if shape[0] != shape[1] else 1
    wave = np.expand_dims(np.cos(2 * np.pi * np.arange(length) / length), 1 - axis) * np.ones(shape)
    limit = 0.8 * np.sqrt(3) / np.e
    columns = subsurface.stress_columns(
        2e8 + 1e8 * wave, (step, step), poissons_ratio=0.5, yield_stress=1e8 * limit
    )
    q = 2 * np.pi / (length * step)
    assert columns["max_von_mises_stress"] == pytest.approx(1e8 * np.sqrt(3) / np.e, rel=1e-4)
    assert columns["max_von_mises_depth"] == pytest.approx(1 / q, rel=0.01)
    assert columns["volume_above_yield"] * q == pytest.approx(closed_forms.wave_volume_above(limit), rel=0.01)


@pytest.mark.parametrize(
    ("rows", "dy"),
    [(5, 0.3), (16, 1.0), (300, 20.0)],
    ids=["a strip", "square pixels", "longer along the lay"],
)
def test_an_extruded_profile_has_the_stresses_of_the_profile(rows, dy):
    profile = rough_contact((1, 200), 1.0, 0.05, hurst=0.8, shortest=4, longest=200)
    reference = subsurface.stress_columns(profile, (1.0, 1.0), poissons_ratio=0.3)
    limit = 0.8 * reference["max_von_mises_stress"]
    reference = subsurface.stress_columns(profile, (1.0, 1.0), poissons_ratio=0.3, yield_stress=limit)
    columns = subsurface.stress_columns(
        np.repeat(profile, rows, axis=0), (dy, 1.0), poissons_ratio=0.3, yield_stress=limit
    )
    for name in ("max_von_mises_stress", "max_tresca_stress"):
        assert columns[name] == pytest.approx(reference[name], rel=2e-4)
    assert columns["max_von_mises_x"] == reference["max_von_mises_x"]
    assert columns["max_von_mises_depth"] == pytest.approx(reference["max_von_mises_depth"], rel=0.01)
    assert columns["volume_above_yield"] == pytest.approx(reference["volume_above_yield"], rel=0.005)


def test_stresses_below_ridges_are_those_of_their_waves():
    """The closed form on the axis, against the waves of Westergaard's pressure taken one by one."""
    points, ratio = 4096, 0.3
    z = np.array([0.003, 0.03, 0.1, 0.3, 1.0])
    for load in (0.05, 0.5, 1.0):
        pressure = closed_forms.westergaard_pressure(np.arange(points) / points, 1.0, load, load)
        waves = np.fft.rfft(pressure)[1:, None].real / points * 2
        waves[-1] /= 2
        reduced = 2 * np.pi * np.arange(1, points // 2 + 1)[:, None] * z
        lateral = ratio / (1 - ratio) * load
        across = -load - (waves * (1 + reduced) * np.exp(-reduced)).sum(axis=0)
        along = -lateral - (waves * (1 - reduced) * np.exp(-reduced)).sum(axis=0)
        crest = -lateral - 2 * ratio * (waves * np.exp(-reduced)).sum(axis=0)
        none = np.zeros_like(z)
        reference = von_mises(np.array([along, crest, across, none, none, none]))
        np.testing.assert_allclose(
            closed_forms.westergaard_von_mises(z, load, ratio), reference, rtol=1e-4, atol=1e-6
        )


@pytest.fixture(scope="module")
def ridges():
    """Return ridges in a window ten times as long as wide, and their largest stress at a fifth of p*."""
    height = westergaard_surface((16, 160), 1e-6, amplitude=1e-6, wavelength=160e-6)
    full = closed_forms.westergaard_full_contact_pressure(1e-6, 160e-6, 1e9)
    z = np.linspace(0.01, 0.3, 3001)
    return height, full, full * closed_forms.westergaard_von_mises(z, 0.2, 0.3).max()


def test_the_load_of_first_yield_in_a_long_window(ridges):
    """Searched for, and between two loads."""
    height, full, stress = ridges
    bodies = [{"poissons_ratio": 0.3, "yield_stress": stress}, {}]
    (load,) = target_loads(height, contact_modulus=1e9, target="first_yield", bodies=bodies)
    assert load / full == pytest.approx(0.2, rel=5e-3)
    contact = rc.solve_contact(height, contact_modulus=1e9, mean_pressure=[0.15 * full, 0.25 * full])
    statistics = subsurface.add_subsurface_yield(
        rc.contact_statistics(contact, bodies=bodies, flow="never"), bodies
    )
    assert statistics["first_subsurface_yield_pressure"].item() / full == pytest.approx(0.2, rel=0.01)
    np.testing.assert_array_equal(statistics["depth"], subsurface.profile_depths(height.shape, (1e-6, 1e-6)))


def test_depths_reach_below_the_longest_wave_and_begin_within_the_first_pixel():
    for shape, steps in (
        ((12, 120), (1.0, 1.0)),
        ((120, 12), (1.0, 1.0)),
        ((30, 60), (2.0, 2.0)),
        ((1, 120), (7, 1)),
    ):
        depths = subsurface.profile_depths(shape, steps)
        assert depths[0] == 0
        assert np.count_nonzero((depths > 0) & (depths < 0.5 * steps[1])) >= 5
        assert depths[-1] == pytest.approx(240)
        assert closed_forms.wave_von_mises(2 * np.pi * depths[-1] / 120, 0.0) < 1e-4
        assert (np.diff(depths, 2) > 0).all()


def test_no_volume_above_a_yield_stress_that_is_not_reached():
    wave = np.cos(2 * np.pi * np.arange(64) / 64)[None, :]
    none = subsurface.stress_columns(wave, (1.0, 1.0), poissons_ratio=0.5, yield_stress=0.64)
    assert none["volume_above_yield"] == 0
    assert closed_forms.wave_volume_above(0.64) == 0
    assert "volume_above_yield" not in subsurface.stress_columns(wave, (1.0, 1.0), poissons_ratio=0.5)


def test_the_mean_pressure_strains_all_of_the_body_or_nothing():
    """Its stress p̄ (1 - 2ν)/(1 - ν) acts at every depth: there is no end of what is above a lower limit."""
    flat = np.full((4, 32), 7.0)
    stress = subsurface.stress_columns(flat, (1.0, 1.0), poissons_ratio=0.3)["max_von_mises_stress"]
    assert stress == pytest.approx(7 * 0.4 / 0.7)
    wave = flat + np.cos(2 * np.pi * np.arange(32) / 32)
    for pressure in (flat, wave):
        columns = subsurface.stress_columns(
            pressure, (1.0, 1.0), poissons_ratio=0.3, yield_stress=0.99 * stress
        )
        assert columns["volume_above_yield"] == np.inf
    assert (
        subsurface.stress_columns(flat, (1.0, 1.0), poissons_ratio=0.3, yield_stress=1.01 * stress)[
            "volume_above_yield"
        ]
        == 0
    )
    columns = subsurface.stress_columns(wave, (1.0, 1.0), poissons_ratio=0.3, yield_stress=1.01 * stress)
    assert 0 < columns["volume_above_yield"] < 64


def test_the_body_that_yields_first():
    assert subsurface.strained_body([HARD, SOFT]) is SOFT
    without_yield = {name: value for name, value in HARD.items() if name != "yield_stress"}
    assert subsurface.strained_body([without_yield, SOFT | {"yield_stress": None}])["youngs_modulus"] == 2e9
    assert (
        subsurface.strained_body([without_yield | {"yield_stress": 1e8}, SOFT | {"yield_stress": None}])[
            "yield_stress"
        ]
        == 1e8
    )
    assert subsurface.strained_body(None) is None


UNKNOWN = {"youngs_modulus": 2e11, "poissons_ratio": 0.3}
FILM = {"thickness": 1e-6, "youngs_modulus": 4e11, "poissons_ratio": 0.2}


@pytest.mark.parametrize(
    ("bodies", "words"),
    [
        ([HARD, SOFT | {"name": "PEEK"}], "body 2 (PEEK), of the lowest yield stress stated"),
        (
            [HARD | {"layers": [FILM]}, HARD | {"layers": [FILM | {"yield_stress": 1e8}]}],
            "body 2, of the lowest yield stress stated",
        ),
        ([UNKNOWN, UNKNOWN | {"layers": [FILM]}], "body 2, the only one with layers"),
        ([{"base": "rigid", "layers": [FILM]}, UNKNOWN | {"layers": [FILM]}], "body 2, of the softer base"),
        ([UNKNOWN, SOFT | {"yield_stress": None}], "body 2, the softer one"),
        ([HARD, HARD], "body 1, the first of two alike"),
        ([SOFT], "body 1, the only elastic one"),
    ],
)
def test_the_words_name_the_body_that_is_strained(bodies, words):
    assert subsurface.strained_body_in_words(bodies) == words
    assert subsurface.strained_body(bodies) is bodies[int(words[5]) - 1]


@pytest.fixture(scope="module")
def contact():
    surface = rough_reference_surface(64)
    height = height_map(1e-5 * surface.values, 1e-5 / 64).assign_coords(
        x=surface["x"].values * 1e-5 + 3e-6, y=surface["y"].values * 1e-5
    )
    return rc.solve_contact(height, contact_modulus=2.3e9, mean_pressure=[1e5, 1e6, 1e8])


def test_stresses_in_the_statistics(contact, tmp_path):
    limit = {"poissons_ratio": 0.4, "yield_stress": 3e8}
    stats = rc.contact_statistics(contact, bodies=[limit, {"poissons_ratio": 0.3}], flow="never")
    stats = describe(subsurface.add_subsurface_yield(stats, [limit, {}]))
    assert stats["von_mises_profile"].dims == ("load", "depth")
    assert (stats["von_mises_profile"].max("depth") <= stats["max_von_mises_stress"] * (1 + 1e-12)).all()
    assert (stats["max_von_mises_stress"] < stats["max_pressure"]).all()
    assert stats["max_von_mises_stress"].attrs["units"] == "Pa"
    assert stats["depth"].attrs["units"] == "m"
    assert contact["x"].min() <= stats["max_von_mises_x"].min()
    assert stats["max_von_mises_x"].max() <= contact["x"].max()
    first_yield = stats["first_subsurface_yield_pressure"].item()
    stress = stats["max_von_mises_stress"].values
    bracket = int(np.argmax(stress >= 3e8))
    assert 1 <= bracket <= 2
    assert contact["mean_pressure"][bracket - 1] < first_yield < contact["mean_pressure"][bracket]
    write_dataset(stats, tmp_path / "statistics.nc")
    collected = collect_statistics([{"surface": "a", "case": None, "statistics": tmp_path / "statistics.nc"}])
    np.testing.assert_allclose(collected["profile_depth"].isel(surface=0), stats["depth"])
    table = summary_table(collected)
    assert "max_von_mises_stress_Pa" in table
    assert "profile_depth_m" not in table


def test_load_by_load_is_all_at_once(contact):
    bodies = [SOFT, HARD]
    statistics = rc.contact_statistics(contact, bodies=bodies, flow="never")
    for load in range(3):
        statistics_of_load = rc.contact_statistics(contact.isel(load=[load]), bodies=bodies, flow="never")
        assert (
            statistics_of_load["max_von_mises_stress"].item()
            == statistics["max_von_mises_stress"][load].item()
        )
        np.testing.assert_array_equal(statistics_of_load["depth"], statistics["depth"])


def test_no_yield_between_the_loads(contact):
    for limit in (1.0, 1e15):
        bodies = [{"poissons_ratio": 0.3, "yield_stress": limit}] * 2
        stats = rc.contact_statistics(contact, bodies=bodies, flow="never")
        assert np.isnan(subsurface.add_subsurface_yield(stats, bodies)["first_subsurface_yield_pressure"])


def test_stresses_are_computed_where_they_are_asked_for(contact):
    plain = [{"poissons_ratio": 0.3}] * 2
    assert "max_von_mises_stress" not in rc.contact_statistics(contact, bodies=plain, flow="never")
    statistics = rc.contact_statistics(contact, bodies=plain, flow="never", stress="always")
    assert "max_von_mises_stress" in statistics
    assert subsurface.add_subsurface_yield(statistics, plain).identical(statistics)
    never = rc.contact_statistics(contact, bodies=[SOFT, HARD], flow="never", stress="never")
    assert "max_von_mises_stress" not in never
    assert subsurface.add_subsurface_yield(never, [SOFT, HARD]).identical(never)
    with pytest.raises(rc.SettingsError, match="stress = 'always' needs bodies"):
        rc.contact_statistics(contact, stress="always")


def test_settings_that_cannot_give_stresses():
    with pytest.raises(rc.SettingsError, match=r"statistics.stress = 'always': needs contact.bodies"):
        resolve({"contact": {"contact_modulus": 1e9}, "statistics": {"stress": "always"}})
    config = {"contact": {"bodies": [HARD, SOFT]}, "statistics": {"stress": "always"}}
    assert resolve(config)[""]["contact"]["bodies"][1]["yield_stress"] == 5e7
