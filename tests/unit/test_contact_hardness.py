"""Contact whose pressure stops at a hardness: against a dense reference solution, and its limits."""

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine
from scipy.optimize import lsq_linear

import roughcontact as rc

MODULUS = 1e9


def dense_solution(heights, lengths, *, shift, hardness):
    """Return the pressure with 0 <= p <= hardness of least energy for heights raised by `shift`, E* = 1.

    The mean displacement has stiffness 1 instead of none, so that the load follows from the shift. Bounded
    least squares of the root of the operator (Stark and Parker 1995, Comput. Stat. 10, 129), by SciPy.
    """
    ny, nx = heights.shape
    waves = np.fft.fftfreq(ny, lengths[0] / ny)[:, None], np.fft.fftfreq(nx, lengths[1] / nx)
    q = 2 * np.pi * np.hypot(*waves)
    root = np.sqrt(np.where(q > 0, 2 / np.where(q > 0, q, 1), 1.0))
    columns = np.fft.fft2(np.eye(ny * nx).reshape(-1, ny, nx))
    matrix = np.fft.ifft2(columns * root).real.reshape(ny * nx, ny * nx)
    raised = np.fft.ifft2(np.fft.fft2(heights + shift) / root).real.ravel()
    solution = lsq_linear(matrix, raised, bounds=(0, hardness), tol=1e-14, method="bvls")
    return solution.x.reshape(heights.shape)


@pytest.mark.parametrize(
    "seed", [*range(20), *(pytest.param(n, marks=pytest.mark.slow) for n in range(20, 260))]
)
def test_random_maps_equal_a_dense_solution(seed):
    generator = np.random.default_rng(seed)
    shape = tuple(generator.integers(2, 12, 2))
    heights = generator.standard_normal(shape)
    if seed % 3 == 0:
        heights = np.round(2 * heights) / 2  # plateaus
    pitch = (float(10 ** generator.uniform(-1, 1)), 1.0)
    lengths = (shape[0] * pitch[0], shape[1] * pitch[1])
    shift = -heights.max() + np.ptp(heights) * 10 ** generator.uniform(-1.5, 0)
    elastic = dense_solution(heights, lengths, shift=shift, hardness=np.inf)
    hardness = 0.6 * elastic.max()
    exact = dense_solution(heights, lengths, shift=shift, hardness=hardness)
    window = xr.DataArray(
        heights,
        dims=("y", "x"),
        coords={axis: (np.arange(n) + 0.5) * d for axis, n, d in zip("yx", shape, pitch, strict=True)},
    )
    contact = rc.solve_contact(
        window, contact_modulus=1.0, mean_pressure=exact.mean(), tolerance=1e-9, hardness=hardness
    )
    pressure = contact["pressure"].values[0]
    np.testing.assert_allclose(pressure, exact, rtol=0, atol=1e-7 * hardness)
    at_hardness = exact >= hardness * (1 - 1e-9)
    in_contact = exact > 1e-12 * hardness  # less is the rounding of the dense solution
    np.testing.assert_array_equal(pressure >= hardness * (1 - 1e-14), at_hardness)
    # a load that is exactly what these points bear: its own rounding tells whether they reach the hardness
    yielded = pressure == hardness if np.array_equal(at_hardness, in_contact) else at_hardness
    assert float(contact["yielded_area"][0]) == pytest.approx(yielded.mean(), abs=1e-12)
    assert (contact["gap"].values[0][pressure == hardness] == 0).all()
    assert (contact["contact"].values[0] == in_contact).mean() > 1 - 1.5 / exact.size


def rough():
    return self_affine((128, 128), 1e-6, (8e-6, 64e-6), rms_gradient=0.1, seed=2)


def test_hardness_above_the_peak_changes_nothing_and_a_low_one_makes_the_area_plastic():
    window, load = rough(), {"contact_modulus": MODULUS, "mean_pressure": 1e6, "tolerance": 1e-6}
    elastic = rc.solve_contact(window, **load)
    peak = float(elastic["pressure"].max())
    same = rc.solve_contact(window, hardness=1.01 * peak, **load)
    np.testing.assert_allclose(same["pressure"], elastic["pressure"], rtol=0, atol=1e-5 * peak)
    assert float(same["yielded_area"][0]) == 0
    soft = rc.solve_contact(window, hardness=0.05 * peak, **load)
    # nearly all of the contact has yielded: area = load / hardness (Bowden and Tabor 1950)
    assert float(soft["contact"].mean()) == pytest.approx(1e6 / (0.05 * peak), rel=0.02)
    assert float(soft["pressure"].max()) <= 0.05 * peak
    assert float(soft["load_error"][0]) < 1e-12


def test_a_load_that_no_contact_carries_is_refused():
    with pytest.raises(rc.SettingsError, match=r"2e\+06 Pa .* 1e\+06 Pa"):
        rc.solve_contact(rough(), contact_modulus=MODULUS, mean_pressure=2e6, hardness=1e6)
    with pytest.raises(rc.SettingsError, match="hardness = -1"):
        rc.solve_contact(rough(), contact_modulus=MODULUS, mean_pressure=2e6, hardness=-1)


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
def test_a_hardness_that_single_precision_rounds_takes_no_more_than_others(seed):
    """The first steps are taken in single precision, where the hardness is another number."""
    profile = self_affine((1, 1024), 1e-6, (8e-6, 256e-6), rms_gradient=0.1, seed=seed)
    unit = 0.1 * MODULUS
    rounded = np.float32(0.7)
    assert float(rounded) < 0.7
    iterations = [
        float(
            rc.solve_contact(
                profile, contact_modulus=MODULUS, mean_pressure=1e7, hardness=hardness * unit, fields=False
            )["operator_applications"][0]
        )
        for hardness in (0.7, float(rounded))
    ]
    assert iterations[0] <= iterations[1] + 2
    assert iterations[0] <= 14.1


@pytest.mark.parametrize("ratio", [1.2, 2.0, 5.0, 20.0])
@pytest.mark.parametrize("relative", [0.003, 0.03, 0.3])
def test_a_hardness_near_the_load_takes_no_more_than_another(relative, ratio):
    """Where nearly all of the contact has yielded, too."""
    window, load = rough(), relative * 0.1 * MODULUS
    contact = rc.solve_contact(
        window, contact_modulus=MODULUS, mean_pressure=load, hardness=ratio * load, fields=False
    )
    assert float(contact["operator_applications"][0]) <= 20.5
