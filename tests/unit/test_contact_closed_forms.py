"""The solver against solutions that nobody here computed."""

import json

import numpy as np
import pytest
from known_surfaces import self_affine
from shared_data import DATA

import roughcontact as rc
from roughcontact.arguments.maps import height_map
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.surface import synthetic
from validation import closed_forms
from validation.surfaces import sum_wave_surface

MODULUS = 3e9


def pressures_and_gaps(contact):
    return contact["pressure"].values[0], contact["gap"].values[0], contact["contact"].values[0] > 0


@pytest.mark.parametrize("ratio", [0.05, 0.3, 0.5, 0.9])
@pytest.mark.parametrize("shape", [(1, 512), (512, 1), (6, 512)])
def test_westergaard_wave(shape, ratio):
    n, wavelength, amplitude = 512, 2e-3, 1e-6
    x = np.arange(n) * wavelength / n
    wave = amplitude * np.cos(2 * np.pi * x / wavelength)
    heights = wave[:, None] if shape[1] == 1 else np.broadcast_to(wave, shape)
    full = closed_forms.westergaard_full_contact_pressure(amplitude, wavelength, MODULUS)
    contact = rc.solve_contact(
        height_map(heights, wavelength / n),
        contact_modulus=MODULUS,
        mean_pressure=ratio * full,
        tolerance=1e-8,
    )
    pressure, gap, touching = pressures_and_gaps(contact)
    assert abs(touching.mean() - closed_forms.westergaard_contact_share(ratio)) <= 1 / n
    profile = pressure[:, 0] if shape[1] == 1 else pressure[0]
    exact = closed_forms.westergaard_pressure(x, wavelength, ratio * full, ratio)
    # the square-root edge is resolved to a pixel: an error of first order, a few 1e-3 here
    assert np.linalg.norm(profile - exact) <= 0.01 * np.linalg.norm(exact)
    assert pressure.max() == pytest.approx(2 * full * np.sqrt(ratio), rel=1e-4)
    assert gap.mean() == pytest.approx(
        closed_forms.westergaard_mean_gap(amplitude, ratio), rel=2e-4, abs=1e-5 * amplitude
    )


def test_full_contact_of_a_rough_map_is_exact():
    height = self_affine((96, 80), (1e-6, 1.5e-6), (8e-6, 60e-6), hurst=0.7, rms_gradient=0.1, seed=3)
    steps = (1e-6, 1.5e-6)
    fluctuation = closed_forms.full_contact_fluctuation(height.values, steps, MODULUS)
    threshold = -fluctuation.min()
    contact = rc.solve_contact(
        height, contact_modulus=MODULUS, mean_pressure=[threshold * (1 + 1e-9), 10 * threshold]
    )
    for load in range(2):
        piece = contact.isel(load=load)
        exact = float(piece["mean_pressure"]) + fluctuation
        np.testing.assert_allclose(piece["pressure"], exact, rtol=0, atol=1e-12 * exact.max())
        assert (piece["contact"] == 1).all()
        assert abs(float(piece["gap"].mean())) <= 1e-12 * np.ptp(height.values)
        assert float(piece["iterations"]) == 0
        assert float(piece["operator_applications"]) <= 3
        assert float(piece["pressure"].std()) == pytest.approx(MODULUS * 0.1 / 2, rel=1e-12)


def test_seed_figures_full_contact_of_the_wave():
    """Seed paper, eq. 4 and figures 2 and 3: mean pressure 2 P and 4 P, P = pi E* D / wavelength."""
    n, wavelength, amplitude = 64, 1e-3, 1e-6
    height = sum_wave_surface(
        (n, n), wavelength / n, amplitudes=(amplitude, amplitude), wavelengths=(wavelength, wavelength)
    )
    unit = np.pi * MODULUS * amplitude / wavelength
    contact = rc.solve_contact(height, contact_modulus=MODULUS, mean_pressure=[2 * unit, 4 * unit])
    wave = np.cos(2 * np.pi * np.arange(n) / n)
    for load, factor in enumerate((2, 4)):
        exact = factor * unit + unit * (wave[:, None] + wave[None, :])
        np.testing.assert_allclose(contact["pressure"][load], exact, rtol=0, atol=1e-12 * exact.max())


JGH = {0.05: 0.11294, 0.1: 0.19061, 0.3: 0.51418, 0.5: 0.70423, 0.9: 0.95063}
JGH_PEAK_AND_GAP = {0.1: (8.83885, 0.38475), 0.5: (2.95866, 0.04508)}


def test_johnson_greenwood_higginson_wave():
    """Corrected shares within 5e-4, peak and mean gap within 1e-4, of an independent code at 512 squared."""
    n, amplitude = 512, 0.01
    shift = (np.arange(n) + 0.37) / n
    heights = amplitude * np.cos(2 * np.pi * shift)[None, :] * np.cos(2 * np.pi * (shift + 0.24 / n))[:, None]
    full = closed_forms.jgh_full_contact_pressure(amplitude, 1.0, 1.0)
    contact = rc.solve_contact(
        height_map(heights, 1 / n),
        contact_modulus=1.0,
        mean_pressure=[ratio * full for ratio in JGH],
        tolerance=1e-5,
        threads=2,
    )
    for load, (ratio, share) in enumerate(JGH.items()):
        piece = contact.isel(load=load)
        assert relative_contact_area(piece["contact"].values > 0) == pytest.approx(share, abs=5e-4)
        if ratio in JGH_PEAK_AND_GAP:
            peak, gap = JGH_PEAK_AND_GAP[ratio]
            assert float(piece["pressure"].max()) / (ratio * full) == pytest.approx(peak, rel=1e-4)
            assert float(piece["gap"].mean()) / amplitude == pytest.approx(gap, rel=1e-4)


ROUGH = {0.05: (0.11614, 0.99125), 0.2: (0.36845, 0.32548), 1.0: (0.96078, 0.00458)}


def test_rough_reference_case():
    height = synthetic.rough_reference_surface(512)
    gradient, rms = 0.55501825, 0.023699516
    contact = rc.solve_contact(
        height,
        contact_modulus=1.0,
        mean_pressure=[relative * gradient for relative in ROUGH],
        tolerance=1e-5,
        threads=2,
    )
    for load, (area, gap) in enumerate(ROUGH.values()):
        piece = contact.isel(load=load)
        assert relative_contact_area(piece["contact"].values > 0) == pytest.approx(area, abs=5e-4)
        assert float(piece["gap"].mean()) / rms == pytest.approx(gap, abs=2e-5)


def test_periodic_hertz_contact():
    """A paraboloid per square period: radius, peak and approach with the lattice corrections."""
    n, period, radius, force = 512, 1.0, 10.0, 1e-5  # a = 0.042 L: corrections of order (a/L)^3
    x = (np.arange(n) + 0.5) / n - 0.5
    heights = -(x[None, :] ** 2 + x[:, None] ** 2) / (2 * radius)
    exact = closed_forms.periodic_hertz(force, radius, 1.0, period)
    kwargs = {"contact_modulus": 1.0, "mean_pressure": force / period**2, "tolerance": 1e-6}
    height = height_map(heights, period / n)
    contact = rc.solve_contact(height, **kwargs)
    area = relative_contact_area(contact["contact"].values[0] > 0)
    assert np.sqrt(area / np.pi) == pytest.approx(exact["contact_radius"], rel=5e-3)
    assert float(contact["pressure"].max()) == pytest.approx(exact["max_pressure"], rel=2e-3)
    # gap = u - h + approach with the crest at h = 0: the approach is minus the indentation
    assert -float(contact["approach"][0]) == pytest.approx(exact["approach"], rel=3e-5)
    free = rc.solve_contact(height, zero_frequency="lattice", **kwargs)
    indentation = closed_forms.hertz(force, radius, 1.0)["approach"]
    assert -float(free["approach"][0]) == pytest.approx(indentation, rel=5e-3)


@pytest.mark.shared_data
def test_measured_maps_on_which_two_other_codes_agree():
    """Tamaas 2.9.0 and ContactMechanics 1.8.3 agree on these to 5e-9 of the peak pressure."""
    for case in json.loads((DATA / "cross_solver_reference.json").read_text()):
        height = rc.read_height_map(DATA / case["file"])
        if height.attrs["first_row"] == "top":  # windows are counted in the rows of the file
            height = height.isel(y=slice(None, None, -1)).assign_coords(y=height["y"].values)
        i, j, nx, ny = case["window"]
        y, x = np.mgrid[:ny, :nx]
        design = np.column_stack([np.ones(nx * ny), x.ravel(), y.ravel()])
        # counted from the first row of the file, which may be the last one of the map
        parts = [rows[j : j + ny, i : i + nx] for rows in (height.values, height.values[::-1])]
        off_plane = [
            part - (design @ np.linalg.lstsq(design, part.ravel(), rcond=None)[0]).reshape(ny, nx)
            for part in parts
        ]
        values = min(off_plane, key=lambda part: abs(part.std() - case["rms_height"]))
        assert values.std() == pytest.approx(case["rms_height"], rel=1e-6)
        dx, dy = case["dx"]
        contact = rc.solve_contact(
            height_map(values, (dy, dx)),
            contact_modulus=1.0,
            mean_pressure=case["mean_pressure_over_contact_modulus"],
            tolerance=1e-8,
        )
        pressure, gap, touching = pressures_and_gaps(contact)
        assert touching.mean() == case["area_pixels"]
        assert pressure.max() == pytest.approx(case["max_pressure"], rel=1e-7)
        assert (pressure**2).mean() == pytest.approx(case["mean_p2"], rel=1e-7)
        assert (pressure**3).mean() == pytest.approx(case["mean_p3"], rel=1e-7)
        assert gap.mean() == pytest.approx(case["mean_gap"], rel=1e-7)
