"""The influence functions, and what the choice of one changes."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.contact.elasticity import influence
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.kernels.fourier import wavevectors
from roughcontact.surface.synthetic import rough_reference_surface
from roughcontact.uncertainty.budget_inputs import headline_values, solver_uncertainty
from roughcontact.uncertainty.scales import CONDUCTANCE


def loves_rectangle(x, y, dy, dx):
    """Return the displacement at (x, y) under a unit pressure on a pixel, E* = 1 (Love 1929)."""

    def corner(u, v):
        return u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v))

    a, b = x + dx / 2, x - dx / 2
    c, d = y + dy / 2, y - dy / 2
    return (corner(a, c) - corner(b, c) - corner(a, d) + corner(b, d)) / np.pi


@pytest.mark.parametrize(("dy", "dx"), [(1.0, 1.0), (0.5, 1.0)])
def test_elements_are_loves_rectangle_over_all_periods(dy, dx):
    """Differences of displacement converge when the images are summed; the rest of the sum falls as 1/R."""
    n = 16
    shape = round(n / dy), round(n / dx)
    symbol = influence.elements(*wavevectors(shape, (dy, dx)), (dy, dx))
    symbol[0, 0] = 0
    kernel = np.fft.irfft2(symbol, s=shape)

    def difference(j, i, reach):
        x, y = np.meshgrid(*2 * [n * np.arange(-reach, reach + 1)])
        return (loves_rectangle(x, y, dy, dx) - loves_rectangle(x + i * dx, y + j * dy, dy, dx)).sum()

    for j, i in [(0, 1), (3, 2), (8, 8)]:
        near, far = difference(j, i, 30), difference(j, i, 60)
        assert kernel[0, 0] - kernel[j, i] == pytest.approx(2 * far - near, abs=2e-5)


def test_elements_are_softer_in_the_middle_and_stiffer_at_the_end_of_the_spectrum():
    """Ratio to 2/|q| at half Nyquist and at Nyquist along an axis: the known -4 % and +17 %."""
    qy, qx = wavevectors((4, 8), (1.0, 1.0))
    ratio = influence.elements(qy, qx, (1.0, 1.0))[0] / influence.sampled(qy, qx, (1.0, 1.0))[0]
    assert ratio[2] == pytest.approx(0.9586, abs=1e-4)
    assert ratio[4] == pytest.approx(1.1662, abs=1e-4)


def test_the_choice_matters_less_the_finer_the_grid():
    differences = []
    for n in (64, 128, 256):
        wave = 1e-2 * np.cos(2 * np.pi * (np.arange(n) + 0.5) / n)
        window = height_map(np.tile(wave, (n, 1)), 1.0 / n)
        load = {"contact_modulus": 1.0, "mean_pressure": 3e-3}
        peaks = [
            float(rc.solve_contact(window, influence=name, **load)["pressure"].max())
            for name in ("sampled", "elements")
        ]
        differences.append(abs(peaks[1] / peaks[0] - 1))
    assert differences[0] > differences[1] > differences[2]
    assert differences[2] < 5e-3
    with pytest.raises(rc.SettingsError, match="influence = 'love'"):
        rc.solve_contact(window, influence="love", **load)


def test_the_numbers_of_a_contact_are_of_the_operator_that_solved_it():
    """Stiffness by differences of loads, energy by pressure times height: nothing but the solution."""
    height, loads = rough_reference_surface(64), 0.05 * np.array([0.9999, 1, 1.0001])
    problem = {"contact_modulus": 1.0, "mean_pressure": loads, "tolerance": 1e-10}
    for name in ("sampled", "elements"):
        contact = rc.solve_contact(height, influence=name, **problem)
        statistics = rc.contact_statistics(contact, flow="never")
        below, _, above = statistics["mean_gap"].values
        stiffness = (loads[2] - loads[0]) / (below - above)
        assert statistics["contact_stiffness"][1].item() == pytest.approx(stiffness, rel=1e-3)
        # where there is pressure the surface follows the heights, and its mean displacement is zero
        pressed_in = (contact["pressure"] * (height - contact["approach"])).mean(("y", "x"))
        np.testing.assert_allclose(statistics["elastic_energy"], pressed_in / 2, rtol=1e-7)
        fields = contact["pressure"][1].values, contact["gap"][1].values
        of_load = headline_values(*fields, (CONDUCTANCE,), Elasticity(influence=name), steps=spacing(height))
        assert of_load[CONDUCTANCE] == pytest.approx(stiffness, rel=2e-3)
        energy = statistics["elastic_energy"].values
        np.testing.assert_allclose(
            solver_uncertainty(contact, energy=energy)["mean_gap"],
            contact["error_bound"] * energy / loads,
            rtol=1e-9,
        )
