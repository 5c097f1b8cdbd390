"""The solver on maps nobody chose, against a dense solver of quadratic programs that knows nothing of it."""

import certificate
import numpy as np
import xarray as xr
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import roughcontact as rc
from roughcontact.contact.loads import plan_loads

shapes = st.tuples(st.integers(1, 12), st.integers(1, 12)).filter(lambda shape: shape[0] * shape[1] > 1)


@st.composite
def maps(draw):
    shape = draw(shapes)
    smooth = draw(st.booleans())
    heights = draw(hnp.arrays(float, shape, elements=st.floats(-1, 1, width=16)))
    if smooth:
        heights = np.cumsum(np.cumsum(heights, axis=0), axis=1)
    pitch = tuple(10.0 ** draw(st.floats(-1.5, 1.5)) for _ in range(2))
    if 1 in shape:  # across a profile nothing varies: its width has no meaning
        pitch = (max(pitch),) * 2
    return heights, pitch


@settings(max_examples=250, deadline=None)
@given(map_and_pitch=maps(), depth=st.floats(0.01, 3))
def test_random_maps_equal_a_dense_solution(map_and_pitch, depth):
    heights, pitch = map_and_pitch
    assume(np.ptp(heights) > 1e-3)
    shape = heights.shape
    window = xr.DataArray(
        heights,
        dims=("y", "x"),
        coords={axis: (np.arange(n) + 0.5) * d for axis, n, d in zip("yx", shape, pitch, strict=True)},
    )
    exact = certificate.dense_pressure(window, depth * np.ptp(heights))
    assume(exact.mean() > 1e-6)
    root, _ = certificate.dense_root(shape, pitch)
    contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=exact.mean(), tolerance=1e-8)
    pressure = contact["pressure"].values[0]
    assert pressure.min() >= 0
    assert np.isclose(pressure.mean(), exact.mean(), rtol=1e-12)

    def energy_norm(field):
        return np.linalg.norm(root @ (field - field.mean()).ravel())

    # the dense solver's own rounding is 1e-10 of the largest pressure
    scale = energy_norm(exact) + 1e-2 * np.linalg.norm(exact)
    assert energy_norm(pressure - exact) <= 1.01e-8 * energy_norm(exact) + 1e-10 * scale


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    relative=st.floats(0.003, 0.8),
    exponent=st.floats(-7, -2),
    shape=st.sampled_from([(64, 64), (1, 512), (45, 60), (2, 128), (37, 41)]),
    stretch=st.sampled_from([1.0, 5.0]),
)
def test_the_error_bound_holds_and_is_nearly_sharp(seed, relative, exponent, shape, stretch):
    rng = np.random.default_rng(seed)
    pitch = (1.0 if shape[0] == 1 else stretch, 1.0)
    q = np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1])[None, :])
    amplitude = np.where((q > 0) & (q < 0.25), np.maximum(q, 3 / max(shape)), np.inf) ** -1.8
    heights = np.fft.irfft2(amplitude * np.fft.rfft2(rng.standard_normal(shape)), s=shape)
    window = xr.DataArray(
        heights,
        dims=("y", "x"),
        coords={axis: (np.arange(n) + 0.5) * d for axis, n, d in zip("yx", shape, pitch, strict=True)},
    )
    gradient = plan_loads(window, contact_modulus=1.0, relative_pressure=1.0)[0]
    load = {"contact_modulus": 1.0, "mean_pressure": relative * gradient}
    tolerance = 10.0**exponent
    loose = rc.solve_contact(window, tolerance=tolerance, **load)
    bound = float(loose["error_bound"][0])
    assert bound <= tolerance
    tight = rc.solve_contact(window, tolerance=max(1e-4 * bound, 1e-12), **load, on_failure="flag")
    q = (
        2
        * np.pi
        * np.hypot(np.fft.fftfreq(shape[0], pitch[0])[:, None], np.fft.fftfreq(shape[1], pitch[1])[None, :])
    )
    q[0, 0] = np.inf

    def energy_norm(field):
        return np.sqrt((np.abs(np.fft.fft2(field)) ** 2 * 2 / q).sum())

    converged = tight["pressure"].values[0]
    error = energy_norm(loose["pressure"].values[0] - converged) / energy_norm(loose["pressure"].values[0])
    remaining_bound = float(tight["error_bound"][0])
    assert remaining_bound <= max(1e-2 * bound, 1e-11)
    assert error <= bound + remaining_bound
