"""The error bound at the rounding of the result, against solutions in extended precision.

The matrix of G is a sum over waves that knows nothing of the solver. With the points at the hardness and
those without pressure known, the pressure is the solution of a linear system; both are found by trial.
"""

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st

import roughcontact as rc
from roughcontact.arguments.maps import height_map

MORE = np.longdouble
SHAPES = [(1, 2), (2, 1), (1, 3), (2, 2), (3, 2), (4, 4), (1, 9), (5, 7), (8, 8)]
REGULAR = {
    "checkerboard": np.indices((8, 8)).sum(0) % 2,
    "stripes": np.indices((6, 6))[1] % 2,
    "one high point": np.eye(1, 36).reshape(6, 6),
}
quietly = pytest.mark.filterwarnings("ignore::roughcontact.errors.HeightMapWarning")
slowly = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])


def symbol(shape):
    """Return 2/|q| of a grid of unit spacing, 0 for q = 0."""
    q = 2 * np.pi * np.hypot(np.fft.fftfreq(shape[0])[:, None], np.fft.fftfreq(shape[1])[None, :])
    return np.divide(2, q, out=np.zeros_like(q), where=q > 0)


def matrix(shape):
    """Return the matrix of G, in extended precision."""
    (y, x), factors = (np.arange(n, dtype=MORE) for n in shape), symbol(shape).astype(MORE)
    turn = 2 * np.arccos(MORE(-1))
    along_y, along_x = (np.exp(1j * turn * np.outer(n, n) / len(n)) for n in (y, x))
    kernel = (along_y @ factors @ along_x).real / factors.size
    rows, columns = np.divmod(np.arange(factors.size), shape[1])
    return kernel[(rows[:, None] - rows) % shape[0], (columns[:, None] - columns) % shape[1]]


def extended_pressure(heights, load, hardness=np.inf):
    """Return the pressure that carries a load, None where no set of points is found or none is free."""
    operator, target = matrix(heights.shape), heights.ravel().astype(MORE)
    size, full, none = target.size, np.zeros(target.size, bool), np.zeros(target.size, bool)
    for _ in range(100):
        free = ~(full | none)
        if not free.any():
            return None
        system = np.block(
            [[operator[np.ix_(free, free)], -np.ones((free.sum(), 1))], [np.ones((1, free.sum())), 0]]
        )
        cap = MORE(0 if hardness == np.inf else hardness)
        given_ = np.append(
            target[free] - operator[np.ix_(free, full)].sum(1) * cap, size * MORE(load) - cap * full.sum()
        )
        solution = np.zeros(free.sum() + 1, MORE)
        for _ in range(6):  # iterative refinement
            solution += np.linalg.solve(system.astype(float), (given_ - system @ solution).astype(float))
        pressure = np.where(full, cap, 0 * target)
        pressure[free] = solution[:-1]
        gap = operator @ pressure - target - solution[-1]
        changed = (
            (full & (gap <= 0)) | (free & (pressure > hardness)),
            (none & (gap >= 0)) | (free & (pressure < 0)),
        )
        if (changed[0] == full).all() and (changed[1] == none).all():
            return pressure.reshape(heights.shape)
        full, none = changed
    return None


def bound_and_error(heights, relative, *, hardness=np.inf, **options):
    """Return the bound of a solution and its true relative error in the norm of the elastic energy."""
    (ny, nx), power = heights.shape, np.abs(np.fft.fft2(heights)) ** 2
    gradient = np.sqrt(
        (power * np.divide(2, symbol((ny, nx)), out=0 * power, where=symbol((ny, nx)) > 0) ** 2).sum()
    )
    load = relative * gradient / heights.size
    given_ = {} if hardness == np.inf else {"hardness": hardness * load}
    contact = rc.solve_contact(
        height_map(heights, 1.0),
        contact_modulus=1.0,
        mean_pressure=load,
        on_failure="flag",
        **given_,
        **options,
    )
    exact = extended_pressure(heights, load, *given_.values())
    if exact is None:
        return None
    pressure = contact["pressure"].values[0]

    def energy_norm(field):
        return np.sqrt((np.abs(np.fft.fft2(field)) ** 2 * symbol(field.shape)).sum())

    difference = (pressure.astype(MORE) - exact).astype(float)
    return float(contact["error_bound"][0]), energy_norm(difference) / energy_norm(pressure.astype(float))


@quietly
@pytest.mark.parametrize("precision", ["single", "double"])
@pytest.mark.parametrize("relative", [0.5, 10.0, 1e2, 1e3, 1e4, 1e5])
@pytest.mark.parametrize("kind", REGULAR)
def test_the_bound_holds_on_regular_maps_whose_roundings_are_alike(kind, relative, precision):
    tolerance = {"single": 1e-4, "double": 1e-12}[precision]
    bound, error = bound_and_error(1.0 * REGULAR[kind], relative, precision=precision, tolerance=tolerance)
    assert error <= bound


@quietly
@slowly
@given(
    shape=st.sampled_from(SHAPES),
    seed=st.integers(0, 10**6),
    exponent=st.floats(-1, 5),
    hardness=st.sampled_from([np.inf, np.inf, 1.00001, 1.0001, 1.01, 1.5]),
    precision=st.sampled_from(["single", "double"]),
)
@example(shape=(3, 2), seed=14149, exponent=3.5625, hardness=1.0001, precision="single")
def test_the_bound_is_never_below_the_error(shape, seed, exponent, hardness, precision):
    heights = np.random.default_rng(seed).standard_normal(shape)
    tolerance = {"single": 1e-4, "double": 1e-12}[precision]
    result = bound_and_error(
        heights, 10**exponent, hardness=hardness, precision=precision, tolerance=tolerance
    )
    assume(result is not None)
    bound, error = result
    assert error <= bound


@quietly
def test_the_bound_of_full_contact_in_double_precision_is_not_that_of_single():
    bound, error = bound_and_error(np.random.default_rng(1).standard_normal((8, 8)), 10.0, tolerance=1e-12)
    assert error <= bound <= 1e-12
