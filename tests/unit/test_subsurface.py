"""Stresses below the surface: a wave, Hertz, equilibrium, and the load at which a body yields there."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import roughcontact as rc
from roughcontact.configuration.resolve import resolve
from roughcontact.elasticity.subsurface import subsurface_stress, tresca, von_mises
from roughcontact.maps import height_map
from roughcontact.references import closed_forms
from roughcontact.references.synthetic import rough_reference_surface
from roughcontact.results.collect import collect_statistics, summary_table
from roughcontact.results.storage import write_dataset
from roughcontact.statistics.subsurface import (
    profile_depths,
    strained_body,
    stress_columns,
    with_subsurface_yield,
)
from roughcontact.variables import describe

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
        known = closed_forms.wave_von_mises(q * depth, ratio)
        assert von_mises(stress).max() == pytest.approx(known, rel=1e-12, abs=1e-14)
        known = closed_forms.wave_tresca(q * depth, ratio)
        assert tresca(stress).max() == pytest.approx(known, rel=1e-12, abs=1e-14)
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

    for left in (
        along(xx, "x") + along(xy, "y") + slope[4],
        along(xy, "x") + along(yy, "y") + slope[3],
        along(xz, "x") + along(yz, "y") + slope[2],
    ):
        assert np.abs(left).max() < 1e-7 * np.abs(slope).max()
    assert np.abs(zz).max() > 0


@pytest.mark.parametrize("shape", [(12, 16), (13, 16), (12, 17), (13, 17)])
def test_stresses_turn_with_the_pressure(shape):
    """With all waves of the grid, those at the Nyquist limit included."""
    pressure, (dy, dx) = rough_pressure(shape), (1.0, 0.7)
    xx, yy, zz, yz, xz, xy = subsurface_stress(pressure, (dy, dx), poissons_ratio=0.3)(0.4)
    for turned, steps, known in (
        (pressure.T, (dx, dy), [part.T for part in (yy, xx, zz, xz, yz, xy)]),
        (pressure[:, ::-1], (dy, dx), [part[:, ::-1] for part in (xx, yy, zz, yz, -xz, -xy)]),
        (pressure[::-1], (dy, dx), [part[::-1] for part in (xx, yy, zz, -yz, xz, -xy)]),
    ):
        found = subsurface_stress(turned, steps, poissons_ratio=0.3)(0.4)
        np.testing.assert_allclose(found, known, atol=1e-12)


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
    found = minimize_scalar(
        lambda z: -closed_forms.hertz_von_mises(z, 0.3), bounds=(0.1, 2), method="bounded"
    )
    assert -found.fun == pytest.approx(0.62, abs=5e-3)
    assert found.x == pytest.approx(0.48, abs=5e-3)


@pytest.mark.parametrize("ratio", [0.3, 0.45])
def test_hertz(ratio):
    """The copies of the contact press with its mean pressure, 0.004 p0: the rest is Johnson's."""
    points, radius = 256, 0.06
    x = (np.arange(points) + 0.27) / points - 0.5
    pressure = np.sqrt(np.maximum(1 - (x[:, None] ** 2 + x[None, :] ** 2) / radius**2, 0))
    found = stress_columns(pressure, (1 / points, 1 / points), poissons_ratio=ratio)
    best = minimize_scalar(
        lambda z: -closed_forms.hertz_von_mises(z, ratio), bounds=(0.1, 2), method="bounded"
    )
    assert found["max_von_mises_stress"] == pytest.approx(-best.fun, abs=0.004)
    assert found["max_von_mises_depth"] == pytest.approx(best.x * radius, rel=0.02)
    assert found["max_tresca_stress"] == pytest.approx(-best.fun, abs=0.004)
    assert found["max_von_mises_x"] == pytest.approx(0.5, abs=0.01)
    assert found["max_von_mises_y"] == pytest.approx(0.5, abs=0.01)
    axis = profile_depths(pressure.shape, (1 / points, 1 / points)) / radius
    inside = (axis > 0.3) & (axis < 1.5)
    known = closed_forms.hertz_von_mises(axis[inside], ratio)
    np.testing.assert_allclose(found["von_mises_profile"][inside], known, atol=0.006)


@pytest.mark.parametrize("limit", [0.1, 0.3, 0.5])
def test_volume_above_yield_of_a_wave(limit):
    """Plane strain, ν = 0.5: √3 qz e^(-qz), the same along x, is above the limit between two depths."""
    points, waves = 512, 8
    wave = np.cos(2 * np.pi * waves * np.arange(points) / points)[None, :]
    q = 2 * np.pi * waves / points
    found = stress_columns(wave, (1.0, 1.0), poissons_ratio=0.5, yield_stress=limit)
    z = np.linspace(0, 8, 100001)
    between = z[np.sqrt(3) * z * np.exp(-z) > limit]
    known = closed_forms.wave_volume_above(limit)
    assert known == pytest.approx(between[-1] - between[0], rel=1e-3)
    assert found["volume_above_yield"] * q == pytest.approx(known, rel=0.05)


def test_no_volume_above_a_yield_stress_that_is_not_reached():
    wave = np.cos(2 * np.pi * np.arange(64) / 64)[None, :]
    none = stress_columns(wave, (1.0, 1.0), poissons_ratio=0.5, yield_stress=0.64)
    assert none["volume_above_yield"] == 0
    assert closed_forms.wave_volume_above(0.64) == 0
    assert "volume_above_yield" not in stress_columns(wave, (1.0, 1.0), poissons_ratio=0.5)


def test_stresses_in_layers_of_pressure_alone_fill_the_layers():
    """A pressure without waves is above a lower limit all the way down, and nowhere above a higher one."""
    flat = np.full((4, 32), 1.0)
    depth = profile_depths(flat.shape, (1.0, 1.0))[-1]
    stress = stress_columns(flat, (1.0, 1.0), poissons_ratio=0.3)["max_von_mises_stress"]
    for limit, known in ((0.99 * stress, depth), (1.01 * stress, 0.0)):
        found = stress_columns(flat, (1.0, 1.0), poissons_ratio=0.3, yield_stress=limit)
        assert found["volume_above_yield"] == pytest.approx(known, rel=1e-12)


def test_the_body_that_yields_first():
    assert strained_body([HARD, SOFT]) is SOFT
    without = {name: value for name, value in HARD.items() if name != "yield_stress"}
    assert strained_body([without, SOFT | {"yield_stress": None}])["youngs_modulus"] == 2e9
    assert (
        strained_body([without | {"yield_stress": 1e8}, SOFT | {"yield_stress": None}])["yield_stress"] == 1e8
    )
    assert strained_body(None) is None


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
    stats = describe(with_subsurface_yield(stats, [limit, {}]))
    assert stats["von_mises_profile"].dims == ("load", "depth")
    assert (stats["von_mises_profile"].max("depth") <= stats["max_von_mises_stress"] * (1 + 1e-12)).all()
    assert (stats["max_von_mises_stress"] < stats["max_pressure"]).all()
    assert stats["max_von_mises_stress"].attrs["units"] == "Pa"
    assert stats["depth"].attrs["units"] == "m"
    assert contact["x"].min() <= stats["max_von_mises_x"].min()
    assert stats["max_von_mises_x"].max() <= contact["x"].max()
    first = stats["first_subsurface_yield_pressure"].item()
    stress = stats["max_von_mises_stress"].values
    bracket = int(np.argmax(stress >= 3e8))
    assert 1 <= bracket <= 2
    assert contact["mean_pressure"][bracket - 1] < first < contact["mean_pressure"][bracket]
    write_dataset(stats, tmp_path / "statistics.nc")
    collected = collect_statistics([{"surface": "a", "case": None, "statistics": tmp_path / "statistics.nc"}])
    np.testing.assert_allclose(collected["profile_depth"].isel(surface=0), stats["depth"])
    table = summary_table(collected)
    assert "max_von_mises_stress_Pa" in table
    assert "profile_depth_m" not in table


def test_load_by_load_is_all_at_once(contact):
    bodies = [SOFT, HARD]
    whole = rc.contact_statistics(contact, bodies=bodies, flow="never")
    for load in range(3):
        one = rc.contact_statistics(contact.isel(load=[load]), bodies=bodies, flow="never")
        assert one["max_von_mises_stress"].item() == whole["max_von_mises_stress"][load].item()
        np.testing.assert_array_equal(one["depth"], whole["depth"])


def test_no_yield_between_the_loads(contact):
    for limit in (1.0, 1e15):
        bodies = [{"poissons_ratio": 0.3, "yield_stress": limit}] * 2
        stats = rc.contact_statistics(contact, bodies=bodies, flow="never")
        assert np.isnan(with_subsurface_yield(stats, bodies)["first_subsurface_yield_pressure"])


def test_stresses_are_computed_where_they_are_asked_for(contact):
    plain = [{"poissons_ratio": 0.3}] * 2
    assert "max_von_mises_stress" not in rc.contact_statistics(contact, bodies=plain, flow="never")
    asked = rc.contact_statistics(contact, bodies=plain, flow="never", stress="always")
    assert "max_von_mises_stress" in asked
    assert with_subsurface_yield(asked, plain).identical(asked)
    never = rc.contact_statistics(contact, bodies=[SOFT, HARD], flow="never", stress="never")
    assert "max_von_mises_stress" not in never
    assert with_subsurface_yield(never, [SOFT, HARD]).identical(never)
    with pytest.raises(rc.SettingsError, match="stress = 'always' needs bodies"):
        rc.contact_statistics(contact, stress="always")


def test_settings_that_cannot_give_stresses():
    with pytest.raises(rc.SettingsError, match=r"statistics.stress = 'always': needs contact.bodies"):
        resolve({"contact": {"contact_modulus": 1e9}, "statistics": {"stress": "always"}})
    given = {"contact": {"bodies": [HARD, SOFT]}, "statistics": {"stress": "always"}}
    assert resolve(given)[""]["contact"]["bodies"][1]["yield_stress"] == 5e7
