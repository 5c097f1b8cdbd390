"""The operators of the half-space against sums over waves, and the rules for q = 0 against closed forms."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

from roughcontact.contact.elasticity.halfspace import HalfSpace, zero_frequency_compliance
from roughcontact.errors import SettingsError
from roughcontact.kernels import fft

# even, odd, not square, profiles, two rows, and one above the size from which threads are started
CELLS = [
    ((8, 12), (1.0, 1.0)),
    ((9, 7), (0.4, 2.5)),
    ((6, 5), (3.0, 0.2)),
    ((1, 16), (0.1, 10.0)),
    ((15, 1), (10.0, 0.1)),
    ((2, 10), (1.0, 1.0)),
    ((18, 20), (1.0, 2.0)),
]
PRECISIONS = [np.float32, np.float64]


def by_direct_sums(field, lengths, symbol):
    """Return the field with every wave exp(i q r) multiplied by symbol(|q|), q = 0 left out: no FFT."""
    (ny, nx), (ly, lx) = field.shape, lengths
    i, j = np.arange(ny)[:, None], np.arange(nx)[None, :]
    result = np.zeros(field.shape, dtype=complex)
    for ky in range(-((ny - 1) // 2), ny // 2 + 1):
        for kx in range(-((nx - 1) // 2), nx // 2 + 1):
            if (ky, kx) != (0, 0):
                # whole turns are taken off first: they would cost digits
                wave = np.exp(2j * math.pi * (ky * i % ny / ny + kx * j % nx / nx))
                q = 2 * math.pi * math.hypot(ky / ly, kx / lx)
                result += np.vdot(wave, field) / field.size * symbol(q) * wave
    assert np.abs(result.imag).max() <= 1e-12 * np.abs(result).max()
    return result.real


@pytest.fixture(params=["compiled", "scipy"])
def transforms(request, monkeypatch):
    monkeypatch.setattr(fft, "MIN_SIDE", {"compiled": 1, "scipy": math.inf}[request.param])


@pytest.mark.parametrize("dtype", PRECISIONS)
@pytest.mark.parametrize(("shape", "lengths"), CELLS)
def test_both_operators_equal_sums_over_waves(shape, lengths, dtype, transforms):
    field = np.random.default_rng(1).standard_normal(shape).astype(dtype) + dtype(3)
    original = field.copy()
    halfspace = HalfSpace(shape, lengths)
    rounding = 8 * np.finfo(dtype).eps * np.abs(field).max()
    softest = max(length / math.pi for length, n in zip(lengths, shape, strict=True) if n > 1)
    for apply, symbol, largest in (
        (halfspace.displacement, lambda q: 2 / q, softest),
        (halfspace.pressure, lambda q: q / 2, halfspace.largest_stiffness),
    ):
        exact = by_direct_sums(field.astype(float), lengths, symbol)
        applied = apply(field)
        assert applied.dtype == dtype
        np.testing.assert_allclose(applied, exact, rtol=0, atol=rounding * largest)
        np.testing.assert_array_equal(field, original)
    assert halfspace.applications == 2


@pytest.mark.parametrize("dtype", PRECISIONS)
@pytest.mark.parametrize(("shape", "lengths"), CELLS)
def test_half_an_application_tells_the_energy_and_the_other_half_the_pressure(
    shape, lengths, dtype, transforms
):
    field = np.random.default_rng(3).standard_normal(shape).astype(dtype) + dtype(1)
    halfspace = HalfSpace(shape, lengths)
    spectrum, energy = halfspace.pressure_spectrum(field)
    assert halfspace.applications == 0.5
    exact = by_direct_sums(field.astype(float), lengths, lambda q: q / 2)
    largest = halfspace.largest_stiffness
    rounding = float(8 * np.finfo(dtype).eps * np.abs(field).max())
    assert energy == pytest.approx(np.mean(field.astype(float) * exact), abs=rounding * largest)
    back = halfspace.spectrum_to_field(spectrum, dtype.__name__)
    assert halfspace.applications == 1
    np.testing.assert_allclose(back, exact, rtol=0, atol=rounding * largest)


@pytest.mark.parametrize("dtype", PRECISIONS)
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(
    ("shape", "lengths"), [*CELLS, ((600, 450), (1.0, 0.7)), ((1, 270000), (1e-3, 1.0))], ids=str
)
def test_one_operator_is_the_inverse_of_the_other(shape, lengths, threads, dtype, transforms):
    halfspace = HalfSpace(shape, lengths, threads=threads)
    field = np.random.default_rng(2).standard_normal(shape)
    field = (field - field.mean()).astype(dtype)
    eps = np.finfo(dtype).eps
    soft = halfspace.displacement(field).copy()
    assert abs(soft.mean(dtype=float)) <= 4 * eps * np.abs(soft).max()
    tolerance = 8 * eps * np.abs(soft).max() * halfspace.largest_stiffness
    np.testing.assert_allclose(halfspace.pressure(soft), field, rtol=0, atol=tolerance)
    stiff = halfspace.pressure(field).copy()
    softest = max(length / math.pi for length, n in zip(lengths, shape, strict=True) if n > 1)
    tolerance = 8 * eps * np.abs(stiff).max() * softest
    np.testing.assert_allclose(halfspace.displacement(stiff), field, rtol=0, atol=tolerance)


def test_a_uniform_field_gives_nothing():
    halfspace = HalfSpace((6, 8), (1.0, 1.0))
    for apply in (halfspace.displacement, halfspace.pressure):
        assert np.abs(apply(np.full((6, 8), 7.0))).max() <= 1e-14


@pytest.mark.parametrize("shape", [(8, 6), (9, 7), (1, 12)])
@pytest.mark.parametrize("first_precision", PRECISIONS)
def test_precisions_take_turns(shape, first_precision, transforms):
    """Both lie in the same memory, whichever comes first: every application reads and writes its own."""
    field = np.random.default_rng(3).standard_normal(shape)
    expected = {
        dtype: HalfSpace(shape, (1.0, 1.0)).pressure(field.astype(dtype)).copy() for dtype in PRECISIONS
    }
    halfspace = HalfSpace(shape, (1.0, 1.0))
    for dtype in (first_precision, *PRECISIONS, *PRECISIONS[::-1]):
        np.testing.assert_array_equal(halfspace.pressure(field.astype(dtype)), expected[dtype])
        halfspace.scratch(np.dtype(dtype).name)[...] = np.nan
        out = np.empty(shape, dtype)
        assert halfspace.pressure(field.astype(dtype), out=out) is out
        np.testing.assert_array_equal(out, expected[dtype])


@pytest.mark.parametrize(("shape", "lengths"), CELLS)
def test_stiffness_for_estimates_of_rounding(shape, lengths):
    """The mean and the largest of |q|/2, and of 2/|q|, over the half plane of the real transform."""
    (ny, nx), (ly, lx) = shape, lengths
    stiffness = [
        math.pi * math.hypot(min(ky, ny - ky) / ly, kx / lx) for ky in range(ny) for kx in range(nx // 2 + 1)
    ]
    halfspace = HalfSpace(shape, lengths)
    assert halfspace.mean_stiffness == pytest.approx(np.mean(stiffness), rel=1e-6)
    assert halfspace.largest_stiffness == pytest.approx(max(stiffness), rel=1e-6)
    compliance = [0, *(1 / value for value in stiffness[1:])]
    assert halfspace.compliances == pytest.approx((np.mean(compliance), max(compliance)), rel=1e-6)


def alternating(term, count=40):
    """Return the sum of (-1)^k term(k), k >= 0, by the scheme of Cohen, Villegas and Zagier (2000)."""
    d = (3 + math.sqrt(8)) ** count
    d = 0.5 * (d + 1 / d)
    b, c, total = -1.0, -d, 0.0
    for k in range(count):
        c = b - c
        total += c * term(k)
        b *= (k + count) * (k - count) / ((k + 0.5) * (k + 1))
    return total / d


def test_lattice_rule_is_the_lattice_sum():
    """Sum of 1/distance over the square lattice, 4 zeta(1/2) beta(1/2) (Borwein and others 2013)."""
    zeta = alternating(lambda k: (k + 1) ** -0.5) / (1 - math.sqrt(2))
    beta = alternating(lambda k: (2 * k + 1) ** -0.5)
    constant = -4 * zeta * beta
    compliance = zero_frequency_compliance("lattice", lengths=(2.5, 2.5))
    assert compliance == pytest.approx(2.5 * constant / math.pi, rel=1e-14)


@pytest.mark.parametrize("lengths", [(1.0, 1.0), (2.0, 0.5), (0.01, 3.0)])
def test_nogi_kato_rule_is_the_mean_over_the_cell(lengths):
    ly, lx = lengths
    a, b = math.pi / lx, math.pi / ly
    quarter, _ = dblquad(lambda t, angle: 2.0, 0, math.atan2(b, a), 0, lambda angle: a / math.cos(angle))
    second_half, _ = dblquad(
        lambda t, angle: 2.0, math.atan2(b, a), math.pi / 2, 0, lambda angle: b / math.sin(angle)
    )
    mean = (quarter + second_half) / (a * b)  # 2/|q| in polar coordinates is 2 dq dangle
    assert zero_frequency_compliance("nogi-kato", lengths=lengths) == pytest.approx(mean, rel=1e-9)


def test_rules_that_need_no_sum_and_rules_that_do_not_exist():
    assert zero_frequency_compliance("zero", lengths=(2.0, 1.0)) == 0
    # 4 asinh(1) / pi of a square
    assert zero_frequency_compliance("nogi-kato", lengths=(1.0, 1.0)) == pytest.approx(
        4 * math.asinh(1) / math.pi, rel=1e-14
    )
    with pytest.raises(
        SettingsError, match=r"square period, this one is 1 m x 2 m; use 'zero' or 'nogi-kato'"
    ):
        zero_frequency_compliance("lattice", lengths=(2.0, 1.0))
    with pytest.raises(SettingsError, match=r"zero_frequency = 'kato': .*choose zero, nogi-kato or lattice"):
        zero_frequency_compliance("kato", lengths=(1.0, 1.0))
