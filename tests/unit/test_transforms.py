"""The transforms in C against those of NumPy in double precision, and on several threads against one."""

import subprocess
import sys

import numpy as np
import pytest

from roughcontact.kernels import fft, threads
from roughcontact.kernels.arrays import DOUBLE, SINGLE

# every factor of a length, alone and with others; blocks of rows and columns that are full, and that are not
SHAPES = [(16, 16), (16, 81), (125, 64), (96, 250), (20, 16), (243, 18), (150, 128), (512, 24)]


def shown(shape, seed=0):
    return np.random.default_rng(seed).standard_normal(shape)


def plan_of(field, precision, *, allowed=1):
    plan = fft.make_plan(field, precision, threads=allowed)
    assert type(plan) is fft.CompiledPlan
    return plan


@pytest.fixture(autouse=True)
def _threads_for_fields_of_any_size(monkeypatch):
    monkeypatch.setattr(threads, "MIN_POINTS", 1)


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE])
@pytest.mark.parametrize("shape", SHAPES)
def test_there_and_back(shape, precision):
    field = shown(shape).astype(precision)
    plan, original = plan_of(field, precision), field.copy()
    exact = np.fft.rfft2(field.astype(np.longdouble))
    # the error of one number is that of a sum of log2 n of them, each about as large as the whole transform
    error = 2 * np.finfo(precision).eps * np.sqrt(np.log2(field.size)) * field.std()
    spectrum = plan.forward(field)
    assert spectrum.dtype == np.result_type(precision, np.complex64)
    assert np.abs(spectrum - exact).max() <= 2 * error * np.sqrt(field.size)
    np.testing.assert_array_equal(field, original)
    back = np.full_like(field, np.nan)
    plan.inverse(spectrum, back)
    assert np.abs(back - field).max() <= 4 * error


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE])
def test_what_is_imaginary_in_real_waves_is_left_out_as_numpy_does(precision):
    field = shown((32, 40)).astype(precision)
    rng, plan = np.random.default_rng(1), plan_of(field, precision)
    any_numbers = rng.standard_normal((32, 21)) + 1j * rng.standard_normal((32, 21))
    expected = np.fft.irfft2(any_numbers, s=field.shape)
    spectrum = plan.spectrum
    spectrum[...] = any_numbers
    plan.inverse(spectrum, field)
    np.testing.assert_allclose(field, expected, rtol=0, atol=20 * np.finfo(precision).eps)


def test_arrays_may_lie_in_memory_in_any_order_and_be_read_only():
    field = shown((32, 40))
    plan, original = plan_of(field, DOUBLE), field.copy()
    expected = plan.forward(field).copy()
    field.flags.writeable = False
    np.testing.assert_array_equal(plan.forward(field), expected)
    np.testing.assert_array_equal(plan.forward(np.asfortranarray(field)), expected)
    back = np.full((40, 32), np.nan).T
    plan.inverse(np.asfortranarray(expected), back)
    np.testing.assert_allclose(back, original, rtol=0, atol=1e-14)


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE])
def test_no_digit_depends_on_the_threads(precision):
    field = shown((250, 384)).astype(precision)
    transforms = []
    for allowed in (1, 2, 3):
        plan, back = plan_of(field, precision, allowed=allowed), np.empty_like(field)
        spectrum = plan.forward(field).copy()
        plan.inverse(plan.spectrum, back)
        transforms.append((spectrum, back))
    for spectrum, back in transforms[1:]:
        np.testing.assert_array_equal(spectrum, transforms[0][0])
        np.testing.assert_array_equal(back, transforms[0][1])


@pytest.mark.parametrize("shape", [(1, 512), (512, 8), (128, 7 * 16), (131, 128)])
def test_profiles_and_awkward_lengths_are_left_to_scipy(shape):
    assert type(fft.make_plan(shown(shape), DOUBLE)) is fft.ScipyPlan


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE])
def test_both_precisions_lie_in_the_memory_of_the_higher_one(precision):
    field = shown((64, 48))
    higher = plan_of(field, DOUBLE)
    lower = fft.make_plan(field, precision, share=higher)
    assert np.shares_memory(lower.spectrum, higher.spectrum)
    values = field.astype(precision)
    np.testing.assert_allclose(lower.forward(values), np.fft.rfft2(field), atol=1e-3)


def test_a_solve_of_a_usual_map_imports_nothing_of_scipy():
    """It takes a fifth of the time to a first solution."""
    program = """
import sys
import roughcontact as rc
from roughcontact.arguments.maps import height_map
import numpy as np
heights = np.random.default_rng(0).standard_normal((48, 64))
rc.solve_contact(height_map(heights, 1.0), contact_modulus=1.0, mean_pressure=0.1)
print([name for name in sys.modules if name.partition(".")[0] == "scipy"])
"""
    process = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert process.stdout == "[]\n"
