"""The correction for the pixel size: nearer to a finer solution and to the closed form."""

import numpy as np
import pytest
from known_surfaces import self_affine

from roughcontact.arguments.maps import height_map, refined
from roughcontact.contact.solve import solve_contact
from roughcontact.statistics.contact_geometry import PERIMETER_CORRECTION
from roughcontact.surface import synthetic
from roughcontact.uncertainty import discretisation
from roughcontact.uncertainty.budget_inputs import budget_inputs
from roughcontact.uncertainty.discretisation import _edge_noise, discretisation_error
from roughcontact.uncertainty.ensemble import Result
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, PEAK, to_scale

NAMES = (AREA, GAP, PEAK)


def corrected(window, loads, names=NAMES):
    """Return the results on their scales, the corrections and the half-widths, by quantity."""
    contact = {"contact_modulus": 1.0, "mean_pressure": loads, "tolerance": 1e-6}
    solved = solve_contact(window, **contact)
    inputs = budget_inputs(solved)
    values = {name: inputs[name].values for name in NAMES}
    share = (solved["pressure"].values > 0).mean((1, 2))
    result = Result(window, contact, values)
    correction, width = discretisation_error(result, pixel_share=share)
    return {name: (to_scale(name, values[name]), correction[name], width[name][1]) for name in names}


def test_the_correction_leads_nearer_to_a_finer_solution():
    """The median error, on pixels a quarter as large, of smooth and rough surfaces and a profile."""
    error_plain, error_corrected = {name: [] for name in NAMES}, {name: [] for name in NAMES}
    for shape, hurst, shortest, seed in (
        ((64, 64), 0.8, 8.0, 1),
        ((64, 64), 0.8, 4.0, 2),
        ((64, 64), 0.4, 4.0, 3),
        ((48, 96), 0.7, 6.0, 4),
        ((1, 512), 0.8, 8.0, 5),
    ):
        window = self_affine(shape, 1.0, (shortest, 24.0), hurst=hurst, rms_gradient=1.0, seed=seed)
        loads = [0.05, 0.3]
        fine = solve_contact(
            refined(window, 4), contact_modulus=1.0, mean_pressure=loads, tolerance=1e-5, reduce=budget_inputs
        )
        for name, (plain, correction, _) in corrected(window, loads).items():
            truth = to_scale(name, fine[name].values)
            error_plain[name].extend(np.abs(plain - truth))
            error_corrected[name].extend(np.abs(plain + correction - truth))
    for name in NAMES:
        assert np.median(error_corrected[name]) < 0.7 * np.median(error_plain[name]), name


def test_an_error_by_the_square_of_the_pixel_is_taken_off():
    coarse = np.array([0.3, -0.02])  # a quarter of it with pixels half as large
    correction, width = discretisation.extrapolated(AREA, coarse / 4 - coarse)
    assert coarse + correction == pytest.approx(0.0, abs=1e-15)
    assert width == pytest.approx(0.75 * np.abs(coarse))


def test_a_part_of_a_profile_has_so_many_points_along_it():
    profile = self_affine((1, 4096), 1.0, (8.0, 64.0), rms_gradient=0.1)
    assert discretisation.highest_part(profile, 1024).shape == (1, 1024)


@pytest.mark.parametrize("height", [0.1, 1.0, 4.0])
def test_the_peak_of_a_needle_is_nearer_to_a_finer_solution_which_is_in_its_interval(height):
    """One point that stands out, by so many rms heights: its peak rises to several times the solved one."""
    window = synthetic.rough_reference_surface(64)
    window[20, 30] = window.max() + height * window.std()
    loads = [0.001, 0.01, 0.1]
    fine = solve_contact(
        refined(window, 8), contact_modulus=1.0, mean_pressure=loads, tolerance=1e-4, reduce=budget_inputs
    )
    truth = to_scale(PEAK, fine[PEAK].values)
    plain, correction, width = corrected(window, loads)[PEAK]
    assert (np.exp(truth - plain)[0] > 1.5).all()
    assert (np.abs(plain + correction - truth) < np.abs(plain - truth)).all()
    assert (np.abs(plain + correction - truth) < width).all()


def test_the_area_of_a_wave_is_that_of_westergaard():
    """The loaded share of a wave, p̄/p* = sin²(π A/2) (Westergaard 1939)."""
    amplitude, share = 0.01, 0.5
    wave = synthetic.westergaard_surface((1, 32), 1 / 32, amplitude=amplitude, wavelength=1.0)
    load = share * np.pi * amplitude
    plain, correction, half_width = corrected(wave, [load])[AREA]
    truth = to_scale(AREA, 2 / np.pi * np.arcsin(np.sqrt(share)))
    assert abs(plain + correction - truth).item() <= half_width.item() < 0.1


def test_narrowest_places_are_not_corrected_and_what_is_flat_has_nothing_to_correct():
    flat = height_map(np.zeros((32, 32)), 1.0)
    contact = {"contact_modulus": 1.0, "mean_pressure": [1.0]}
    values = {AREA: np.ones(1), GAP: np.zeros(1), PEAK: np.ones(1), CONSTRICTIONS[0]: np.zeros(1)}
    correction, _ = discretisation_error(Result(flat, contact, values), pixel_share=np.ones(1))
    assert [correction[name].item() for name in values] == pytest.approx([0.0] * 4, abs=1e-6)
    rough = synthetic.rough_reference_surface(48)
    values = {AREA: np.full(1, 0.3), GAP: np.full(1, 0.1), CONSTRICTIONS[0]: np.full(1, 0.1)}
    correction, components = discretisation_error(
        Result(rough, contact | {"mean_pressure": [0.05]}, values), pixel_share=np.full(1, 0.32)
    )
    width = components[CONSTRICTIONS[0]][1].item()
    assert correction[CONSTRICTIONS[0]].item() == 0 < width
    # a length scales with the heights, whatever the unit
    low = rough * 1e-6
    small = {name: values[name] * (1 if name == AREA else 1e-6) for name in values}
    problem = contact | {"mean_pressure": [0.05e-6]}
    _, components = discretisation_error(Result(low, problem, small), pixel_share=np.full(1, 0.32))
    assert components[CONSTRICTIONS[0]][1].item() == pytest.approx(1e-6 * width, rel=1e-3)


def test_the_part_of_a_large_window_surrounds_its_highest_point():
    window = self_affine((256, 300), 1.0, (8.0, 64.0), rms_gradient=0.5, seed=1)
    window[5, 299] = window.max() + 1e-3  # the part lies across both seams of the period
    part, _ = discretisation.periodic_interpolant(window)
    assert part.shape == (128, 150)
    around = np.roll(window.values, (64 - 5, 75 - 299), (0, 1))[:128, :150]
    inside = (slice(20, -20), slice(20, -20))  # the seams are blended
    assert np.corrcoef(part.values[inside].ravel(), around[inside].ravel())[0, 1] > 0.9
    assert discretisation.periodic_interpolant(window[:128, :128])[0].shape == (128, 128)


def test_the_edge_of_the_contact_lies_by_chance_in_its_pixels():
    """Half a pixel by the root of the number of switches, which the correction by the perimeter tells."""
    area, points = 0.2, 64 * 64
    share = np.array([area + 0.03])
    width = _edge_noise(np.array([area]), share, points)
    switches = 0.03 / PERIMETER_CORRECTION * points
    expected = to_scale(AREA, area + 0.5 * np.sqrt(switches) / points) - to_scale(AREA, area)
    assert width.item() == pytest.approx(expected.item())
    assert _edge_noise(np.array([area]), np.array([area]), points).item() == 0
