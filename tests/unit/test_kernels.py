"""The passes over the grid: plain against compiled, on NumPy and on another array library."""

import inspect
import warnings
from concurrent.futures import ThreadPoolExecutor
from struct import Struct

import array_api_strict
import numpy as np
import pytest
from option_pairs import every_pair
from scipy import ndimage

from roughcontact.kernels import array_api, choose, compiled
from roughcontact.kernels import threads as job_threads
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.compiled import Compiled
from roughcontact.kernels.protocol import Arrangement

# shape of the grid and factors to the coarser one
GRIDS = [
    ((8, 12), (2, 2)),
    ((40, 54), (2, 3)),
    ((9, 25), (3, 5)),
    ((7, 11), (7, 1)),
    ((10, 9), (5, 3)),
    ((1, 12), (1, 2)),
    ((15, 1), (5, 1)),
    ((2, 20), (1, 5)),
    ((2, 6), (2, 3)),
    ((4, 6), (1, 6)),
]
# where the last cells lack parts, as in the hierarchy of the interpolation
PARTIAL = [((9, 13), (2, 2)), ((1, 7), (1, 2)), ((5, 40), (2, 1)), ((7, 10), (5, 3))]
SINGLE, DOUBLE = np.float32, np.float64
# of pressure and residual; mixed, as in iterative refinement
PRECISIONS = {"single": (SINGLE, SINGLE), "double": (DOUBLE, DOUBLE), "mixed": (DOUBLE, SINGLE)}
WEIGHTS = (0.11, 0.23, 0.08)
OFFSET = 0.1


@pytest.fixture(autouse=True)
def _threads_for_fields_of_any_size(monkeypatch):
    monkeypatch.setattr(job_threads, "MIN_POINTS", 1)


def make_fields(shape, factors, precisions, cap):
    """Return random fields as the iteration has them; about a third carries no pressure."""
    rng = np.random.default_rng(shape)
    outer, inner = precisions
    coarse_shape = tuple(-(-n // f) for n, f in zip(shape, factors, strict=True))

    def random(size, dtype):
        return rng.standard_normal(size).astype(dtype)

    top = outer(cap)
    fields = {
        "pressure": np.clip(random(shape, outer) + outer(0.4), 0, top),
        "start": np.clip(random(shape, outer) + outer(0.4), 0, top),
        "heights": random(shape, outer),
        "separation": random(shape, outer),
        "before": random(shape, outer),
        "correction": random(shape, inner),
        "values": random(shape, inner),
        "field": random(shape, inner),
        "passed": random(shape, inner),
        "active": (rng.standard_normal(shape) * (rng.random(shape) < 0.5)).astype(inner),
        "share": (rng.random(shape) * (rng.random(shape) < 0.8)).astype(inner),
        "gain": rng.random(shape).astype(inner),
        "coarse": random(coarse_shape, inner),
        "coarse_pressure": np.clip(random(coarse_shape, inner), 0, None),
        "symbol": (0.1 + rng.random((shape[0], shape[1] // 2 + 1))).astype(inner),
    }
    spectrum = random(fields["symbol"].shape, inner) + 1j * random(fields["symbol"].shape, inner)
    fields["spectrum"] = spectrum.astype(np.result_type(inner, np.complex64))
    fields["mark"] = np.full(shape, -1, np.int8)
    fields["waves"], fields["along_x"] = rng.random((2, spectrum.shape[1]))
    fields["counts"] = fields["waves"].astype(inner)
    fields["along_y"] = rng.random(len(spectrum))
    fields["symbol"][0, 0] = np.inf  # as that of the half-space
    fields["outer_out"], fields["inner_out"], fields["other_out"] = (
        np.full(shape, np.nan, dtype) for dtype in (outer, inner, inner)
    )
    fields["squares_y"], fields["squares_x"] = (rng.integers(0, 3, n).astype(inner) for n in shape)
    fields["weight"] = np.where(fields["share"] > 0, rng.random(shape), 0).astype(inner)
    fields["coarse_out"], fields["other_coarse_out"] = np.full((2, *coarse_shape), np.nan, inner)
    return fields


def outs(fields):
    """Return the outputs of a kernel that also gives the share and the means of cells."""
    return fields["coarse_out"], fields["other_coarse_out"]


def weigh(engine, fields, factors, arrangement):
    """Weigh cells of six parts each, with a next coarser grid."""
    weights = fields["weight"], fields["share"], (2, 3), arrangement
    engine.weigh(*weights, fields["inner_out"], fields["other_out"], (factors, *outs(fields)))


# every kernel, called with what it is for
CALLS = {
    "multiply": lambda k, f, factors, cap: k.multiply(f["spectrum"], f["symbol"]),
    "divide": lambda k, f, factors, cap: k.divide(f["spectrum"], f["symbol"], f["counts"]),
    "measure": lambda k, f, factors, cap: k.measure(
        f["separation"], (f["heights"], 0.3, 0.8), (f["start"], f["before"], OFFSET), f["pressure"], cap
    ),
    "slope_power": lambda k, f, factors, cap: k.slope_power(
        f["spectrum"], f["waves"], f["along_y"], f["along_x"]
    ),
    "extent": lambda k, f, factors, cap: k.extent(f["heights"]),
    "restore_units": lambda k, f, factors, cap: k.restore_units(
        f["pressure"], f["separation"], OFFSET, 0.7, 0.3, f["mark"]
    ),
    "make_dimensionless": lambda k, f, factors, cap: k.make_dimensionless(
        f["heights"], 0.3, 0.8, f["inner_out"]
    ),
    "masked_residual": lambda k, f, factors, cap: k.masked_residual(
        f["pressure"], f["separation"], OFFSET, cap, f["inner_out"], (factors, *outs(f))
    ),
    "advance": lambda k, f, factors, cap: k.advance(
        *(f["pressure"], f["correction"], f["passed"], f["coarse"], factors),
        *(0.2, 0.87, cap, f["outer_out"], f["active"], f["coarse_out"]),
    ),
    "predict_active": lambda k, f, factors, cap: k.predict_active(
        f["pressure"], f["passed"], WEIGHTS, 0.3, cap, f["active"], (factors, *outs(f))
    ),
    "redistribute": lambda k, f, factors, cap: k.redistribute(
        f["pressure"], f["passed"], f["coarse"], factors, f["active"], cap
    ),
    "project": lambda k, f, factors, cap: k.project(
        f["start"], cap / 2, f["inner_out"], f["other_out"], factors, f["coarse_out"]
    ),
    "inverse_root": lambda k, f, factors, cap: k.inverse_root(f["squares_y"], f["squares_x"], f["inner_out"]),
    "product": lambda k, f, factors, cap: k.product(f["field"], f["passed"]),
    "rescale": lambda k, f, factors, cap: k.rescale(f["separation"], 0.7, cap),
    "project_residual": lambda k, f, factors, cap: k.project_residual(
        f["pressure"], f["separation"], OFFSET, cap, f["values"]
    ),
    "block_mean": lambda k, f, factors, cap: k.block_mean(f["field"], factors, f["coarse_out"]),
    "weigh": lambda k, f, factors, cap: weigh(k, f, factors, Arrangement.UNKNOWN),
    "weigh scattered": lambda k, f, factors, cap: weigh(k, f, factors, Arrangement.SCATTERED),
    "weigh along a line": lambda k, f, factors, cap: weigh(k, f, factors, Arrangement.ALONG_A_LINE),
    "mix": lambda k, f, factors, cap: k.mix(f["values"], f["share"], f["coarse"], factors, f["inner_out"]),
    "neighbours": lambda k, f, factors, cap: k.neighbours(f["field"], WEIGHTS, f["inner_out"]),
    "fill": lambda k, f, factors, cap: k.fill(f["values"], f["share"], f["field"], WEIGHTS, f["inner_out"]),
    "empty_neighbours": lambda k, f, factors, cap: k.empty_neighbours(
        f["field"], f["share"], WEIGHTS, f["inner_out"]
    ),
    "fill_from": lambda k, f, factors, cap: k.fill_from(
        f["values"], f["active"], f["coarse"], factors, WEIGHTS, f["inner_out"]
    ),
    "empty_from": lambda k, f, factors, cap: k.empty_from(
        f["field"], f["active"], WEIGHTS, f["inner_out"], factors, f["coarse_out"]
    ),
    "gather": lambda k, f, factors, cap: k.gather(f["field"], f["share"], factors, f["coarse_out"]),
    "spread": lambda k, f, factors, cap: k.spread(f["field"], f["gain"], f["coarse"], factors),
    "finish_restriction": lambda k, f, factors, cap: k.finish_restriction(
        f["field"], f["passed"], f["coarse"], factors, f["active"]
    ),
    "refine": lambda k, f, factors, cap: k.refine(
        f["coarse_pressure"], factors, f["field"], WEIGHTS, 0.6, cap, f["inner_out"]
    ),
}
# kernels whose result depends on the cap
BOUNDED = [
    *("measure", "masked_residual", "predict_active", "advance", "redistribute", "project", "rescale"),
    *("project_residual", "refine"),
]
# kernels without a coarser grid
ONE_GRID = [
    *("multiply", "divide", "measure", "slope_power", "extent", "restore_units", "make_dimensionless"),
    *("inverse_root", "product", "rescale", "project_residual", "neighbours", "fill", "empty_neighbours"),
]
NESTED = ["refine"]  # grids of whole cells
TWO_GRIDS = [name for name in CALLS if name not in ONE_GRID + NESTED]
# all parities, long rows, one row, one column, two rows
SHAPES = [grid for grid in GRIDS if grid[0] in {(8, 12), (40, 54), (7, 11), (1, 12), (15, 1), (2, 6)}]


def outcome(name, engine, fields, factors, cap, convert=np.array):
    """Return the numbers that a kernel returns and every field after the call, as NumPy arrays."""
    fields = {key: convert(field) for key, field in fields.items()}
    returned = CALLS[name](engine, fields, factors, cap)
    numbers = () if returned is None else returned if isinstance(returned, tuple) else (returned,)
    return numbers, {key: np.asarray(field) for key, field in fields.items()}


def assert_same(actual, expected, precisions):
    """Equal to the rounding of the coarser precision; fields of order one."""
    eps = max(float(np.finfo(precision).eps) for precision in precisions)
    for key, field in expected[1].items():
        assert actual[1][key].dtype == field.dtype
        np.testing.assert_allclose(actual[1][key], field, rtol=16 * eps, atol=16 * eps, err_msg=key)
    size = expected[1]["pressure"].size
    assert len(actual[0]) == len(expected[0])
    for number, reference in zip(actual[0], expected[0], strict=True):
        if isinstance(reference, int):
            assert number == reference
        else:
            assert number == pytest.approx(reference, rel=4 * eps, abs=16 * eps * size)


def test_every_kernel_stands_here():
    twins = {name for name in vars(Compiled) if not name.startswith("_") and name.islower()}
    twins.remove("small_grids")  # against what they replace, in test_interpolation
    assert twins == {name.split()[0] for name in CALLS}
    for name in [*twins, "small_grids"]:
        plain = list(inspect.signature(getattr(array_api, name)).parameters)
        assert list(inspect.signature(getattr(Compiled, name)).parameters) == ["self", *plain]


@pytest.mark.parametrize(
    ("name", "grid", "precisions", "cap"),
    [
        (name, grid, precisions, cap if name in BOUNDED else np.inf)
        for names, grids in ((ONE_GRID, SHAPES), (TWO_GRIDS, GRIDS + PARTIAL), (NESTED, GRIDS))
        for name, grid, precisions, cap in every_pair(names, grids, list(PRECISIONS), [0.9, np.inf])
    ],
    ids=str,
)
def test_plain_and_compiled_agree(name, grid, precisions, cap):
    (shape, factors), precisions = grid, PRECISIONS[precisions]
    fields = make_fields(shape, factors, precisions, cap)
    with np.errstate(all="raise"):
        expected = outcome(name, array_api, fields, factors, cap)
    changed = any(
        not np.array_equal(expected[1][key], field, equal_nan=True) for key, field in fields.items()
    )
    assert changed or expected[0]
    for threads in (1, 2):
        assert_same(outcome(name, Compiled(threads), fields, factors, cap), expected, precisions)
    strict = outcome(name, array_api, fields, factors, cap, convert=array_api_strict.asarray)
    assert_same(strict, expected, precisions)


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE])
@pytest.mark.parametrize("shape", [(5, 5), (5, 200), (70, 5), (9, 133), (40, 68)])
def test_medians_are_those_of_scipy(shape, precision):
    rng = np.random.default_rng(0)
    for values in (
        rng.standard_normal(shape),
        rng.integers(0, 4, shape),
        np.add.outer(*map(np.arange, shape)),
    ):
        field = values.astype(precision)
        expected = ndimage.median_filter(field, size=5)[2:-2, 2:-2]
        np.testing.assert_array_equal(compiled.median_filter(field), expected)


def test_compiled_kernels_are_chosen_for_numpy_arrays_and_threads_for_large_ones(monkeypatch):
    field = np.zeros((6, 7))
    monkeypatch.setattr(job_threads, "MIN_POINTS", field.size)
    assert kernels_for(field, threads=2).threads == 2
    assert kernels_for(field[1:], threads=2).threads == 1
    assert kernels_for(array_api_strict.asarray(field)) is array_api


def test_plain_kernels_serve_where_there_is_no_library(monkeypatch, tmp_path):
    field = np.zeros((6, 7))
    monkeypatch.setattr(compiled, "LIBRARY", tmp_path / "none.so")
    compiled.library.cache_clear()
    choose.library_available.cache_clear()
    try:
        with pytest.warns(UserWarning, match="none.so.*Install a C compiler"):
            assert kernels_for(field) is array_api
        with warnings.catch_warnings():  # it is said once
            warnings.simplefilter("error")
            assert kernels_for(field) is array_api
    finally:
        compiled.library.cache_clear()
        choose.library_available.cache_clear()


def test_a_library_of_other_sources_is_not_used(monkeypatch):
    monkeypatch.setitem(compiled._structs, "mix", Struct("PPPPqqq"))  # as it would be with one number less
    compiled.library.cache_clear()
    try:
        with pytest.raises(OSError, match="built from other sources"):
            compiled.library()
    finally:
        compiled.library.cache_clear()


def test_arrays_that_do_not_suit_are_refused():
    field, out = np.zeros((8, 12)), np.zeros((4, 6))
    Compiled().block_mean(field, (2, 2), out)
    with pytest.raises(TypeError, match="not C contiguous"):
        Compiled().block_mean(np.zeros((12, 8)).T, (2, 2), out)
    with pytest.raises(TypeError, match="block_mean: arrays with items of"):
        Compiled().block_mean(field.astype(np.float32), (2, 2), out)
    single = np.zeros((8, 12), np.float32)
    with pytest.raises(TypeError, match="advance: there is no pass for precisions dff"):
        Compiled().advance(*(field, single, single, single, (1, 1), 0.0, 1.0, np.inf, single, single, single))


def test_the_same_bits_whatever_else_runs():
    """Sums depend on the number of threads asked for, not on how many there were for them."""
    rng = np.random.default_rng(7)
    field, factors = rng.standard_normal((300, 400)), (2, 2)
    (passed, active), coarse = rng.standard_normal((2, 300, 400)), rng.standard_normal((150, 200))

    def summed(threads):
        return Compiled(threads).finish_restriction(field.copy(), passed, coarse, factors, active)

    for threads in (1, 2, 5):
        result_alone = summed(threads)
        with ThreadPoolExecutor(4) as pool:
            assert set(pool.map(summed, [threads] * 40)) == {result_alone}


ENGINES = {"plain": array_api, "one thread": Compiled(1), "two threads": Compiled(2)}
of_every_engine = pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)


@of_every_engine
def test_the_active_set_is_where_the_gap_should_vanish(engine):
    # columns: no pressure, pressure below the cap, at the cap; rows: overlap, touch, gap
    pressure = np.array([[0.0, 0.5, 1.0]] * 3)
    separation = np.array([[-1.0] * 3, [0.0] * 3, [2.0] * 3]) + 0.25
    values = np.empty((3, 3))
    cells = (3, 3), np.empty((1, 1)), np.empty((1, 1))
    engine.masked_residual(pressure, separation, 0.25, 1.0, values, cells)
    assert cells[1] == pytest.approx(5 / 9)
    assert cells[2] == pytest.approx(2 / 9)
    np.testing.assert_array_equal(values, [[-1, -1, 0], [0, array_api.CLOSED, 0], [0, 2, 2]])
    moved, free = np.empty((3, 3)), values.copy()
    correction = np.array([[-2.0, -0.2, 9], [9, 0.1, 9], [9, 2, 0.3]])
    # the coarse cell shares 0.9 among nine, which the neighbours take back
    passed, share = np.full((3, 3), -0.1), np.array([[0.9]])
    engine.advance(*(pressure, correction, passed, share, (3, 3)), *(0.1, 0.5, 1.0, moved, free, share))
    assert share == pytest.approx(3 / 9)
    # before holding: [1.05, 0.65, 1], [0, 0.5, 1], [0, -0.45, 0.9]
    np.testing.assert_allclose(moved, [[1, 0.65, 1], [0, 0.5, 1], [0, 0, 0.9]])
    np.testing.assert_allclose(correction, [[0.05, 0, 0], [0, 0, 0], [0, -0.45, 0]], atol=1e-15)
    np.testing.assert_array_equal(free, [[0, 1, 0], [0, 1, 0], [0, 0, 1]])
    assert np.abs(correction).sum() == pytest.approx(0.5)
    # the coarse cell shares 0.9 among nine; only the free points receive
    passed, coarse = np.array([[9, 0.5, 9], [9, -0.7, 9], [9, 9, -0.25]]), np.array([[0.9]])
    outside, total = engine.redistribute(moved, passed, coarse, (3, 3), free, 1.0)
    np.testing.assert_allclose(moved, [[1, 1.25, 1], [0, -0.1, 1], [0, 0, 0.75]], atol=1e-15)
    assert outside == pytest.approx(0.25 + 0.1)
    assert total == pytest.approx(1 + 1 + 1 + 1 + 0.75)
    rescaled = moved.copy()
    engine.project(moved, 1.0, correction, free, (3, 3), share)
    assert share == pytest.approx(1 / 9)
    np.testing.assert_allclose(moved, [[1, 1, 1], [0, 0, 1], [0, 0, 0.75]])
    np.testing.assert_allclose(correction, [[0, 0.25, 0], [0, -0.1, 0], [0, 0, 0]], atol=1e-15)
    np.testing.assert_array_equal(free, [[0, 0, 0], [0, 0, 0], [0, 0, 1]])
    engine.rescale(rescaled, 0.5, 1.0)
    np.testing.assert_allclose(rescaled, 0.5 * moved)
    projected = np.full((3, 3), 0.5)
    assert engine.project_residual(pressure, separation, 0.25, 1.0, projected) == 1.5**2 + 0.5**2 + 1.5**2
    np.testing.assert_array_equal(projected, [[-1, 0.5, 0.5], [0, 0.5, 0.5], [0.5, 0.5, 2]])


def step(engine, pressure, correction, cap, out, values):
    """Take a whole step, of mean zero, with a correction to which nothing is added."""
    nothing, cells = np.zeros_like(correction), (np.zeros((1, 1), correction.dtype), pressure.shape)
    engine.advance(pressure, correction, nothing, *cells, 0.0, 1.0, cap, out, values, cells[0])


@of_every_engine
def test_points_that_are_foreseen_to_carry_nothing_leave_the_active_set(engine):
    """And give their load away in the next step; a point at the cap stays whatever is foreseen."""
    pressure = np.array([[0.0, 0.0, 0.1, 0.1, 0.5, 1.0]])
    residual = np.array([[-2.0, -1.0, 3.0, 0.0, 0.0, 9.0]])
    values = np.array([[-2.0, -1.0, 3.0, 0.0, 0.5, 9.0]])  # the fourth is inactive as it is
    # less the mean of both neighbours: -6, -1.5, 3.5, -1.5, -4.5, 10
    cells = (1, 6), np.empty((1, 1)), np.empty((1, 1))
    engine.predict_active(pressure, residual, (0.0, 0.5, 0.0), 0.1, 1.0, values, cells)
    assert cells[1] == pytest.approx(4 / 6)
    assert cells[2] == pytest.approx(6.5 / 6)
    np.testing.assert_array_equal(values, [[-2, -1, 0, 0, 0.5, 9]])
    moved, removed = np.empty((1, 6)), np.zeros((1, 6))
    step(engine, pressure, removed, 1.0, moved, values)
    np.testing.assert_array_equal(moved, [[0, 0, 0, 0, 0.5, 1]])
    np.testing.assert_array_equal(removed, [[0, 0, 0.1, 0.1, 0, 0]])
    np.testing.assert_array_equal(values, [[0, 0, 0, 0, 1, 0]])


@of_every_engine
@pytest.mark.parametrize("inner", [SINGLE, DOUBLE])
@pytest.mark.parametrize("cap", [0.3, 0.9])
def test_points_at_the_cap_are_there_in_the_precision_of_the_next_pressure(engine, inner, cap):
    assert float(np.float32(0.3)) > 0.3
    assert float(np.float32(0.9)) < 0.9
    pressure = np.array([[0.0, 0.1, cap, cap]], SINGLE)
    free = np.array([[0.0, 0.1, 0.0, 0.5]], inner)  # the last one leaves the cap
    moved, correction = np.empty((1, 4)), np.full((1, 4), 0.05, inner)
    step(engine, pressure, correction, cap, moved, free)
    np.testing.assert_allclose(moved, [[0, 0.05, cap, cap - 0.05]], rtol=1e-6)
    assert moved[0, 2] == cap
    np.testing.assert_array_equal(correction, 0)
    np.testing.assert_array_equal(free, [[0, 1, 0, 1]])


@of_every_engine
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_missing_values_are_counted_wherever_they_lie(engine, value):
    for shape in ((1, 7), (5, 1), (6, 9)):
        for index in np.ndindex(shape):
            field = np.ones(shape)
            field[index] = field[0, 0] = value
            assert engine.extent(field)[2] == (1 if index == (0, 0) else 2)


@of_every_engine
@pytest.mark.parametrize(("shape", "factors"), GRIDS + PARTIAL)
def test_sums_and_means_are_transposes(engine, shape, factors):
    """Mixing and gathering, filling and its transpose: equal inner products with random fields."""
    f = make_fields(shape, factors, (DOUBLE, DOUBLE), np.inf)
    zero = np.zeros(shape)
    mixed, gathered = np.empty(shape), np.empty_like(f["coarse"])
    engine.mix(zero, f["share"], f["coarse"], factors, mixed)
    engine.gather(f["field"], f["share"], factors, gathered)
    assert np.vdot(mixed, f["field"]) == pytest.approx(np.vdot(f["coarse"], gathered), rel=1e-12)
    filled, passed = np.empty(shape), np.empty(shape)
    engine.fill(zero, f["share"], f["values"], WEIGHTS, filled)
    engine.empty_neighbours(f["field"], f["share"], WEIGHTS, passed)
    assert np.vdot(filled, f["field"]) == pytest.approx(np.vdot(f["values"], passed), rel=1e-12)
    means, spread = np.empty_like(f["coarse"]), np.zeros(shape)
    engine.block_mean(f["gain"] * f["field"], factors, means)
    engine.spread(spread, f["gain"], f["coarse"], factors)
    assert np.vdot(means, f["coarse"]) == pytest.approx(np.vdot(f["field"], spread), rel=1e-12)


@of_every_engine
@pytest.mark.parametrize(("shape", "factors"), GRIDS)
def test_passes_in_one_sweep_equal_the_passes_one_by_one(engine, shape, factors):
    f = make_fields(shape, factors, (DOUBLE, DOUBLE), np.inf)
    mixed, actual, expected = np.empty((3, *shape))
    empty = np.where(f["active"] == 0, 1.0, 0.0)
    array_api.mix(f["values"], empty, f["coarse"], factors, mixed)
    array_api.fill(f["values"], empty, mixed, WEIGHTS, expected)
    engine.fill_from(f["values"], f["active"], f["coarse"], factors, WEIGHTS, actual)
    np.testing.assert_allclose(actual, expected, rtol=1e-13, atol=1e-13)
    coarse, gathered = np.empty_like(f["coarse"]), np.empty_like(f["coarse"])
    array_api.empty_neighbours(f["field"], empty, WEIGHTS, expected)
    array_api.gather(expected, empty, factors, gathered)
    engine.empty_from(f["field"], f["active"], WEIGHTS, actual, factors, coarse)
    np.testing.assert_allclose(actual, expected, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(coarse, gathered, rtol=1e-13, atol=1e-13)


@of_every_engine
@pytest.mark.parametrize("arrangement", [Arrangement.UNKNOWN, Arrangement.SCATTERED])
def test_weights_lie_between_one_piece_and_pieces_far_apart(engine, arrangement):
    # cells of 2 x 2 parts, in rows: none, one part, two, all four in contact, four with a hundredth each
    parts, share = np.array([[[0, 0.25, 0.5, 1, 0.1]], [[0, 0.25, 0.5, 1, 0.01]]])
    empty, gain, weight, passed = np.empty((4, 1, 5))
    engine.weigh(parts, share, (2, 2), arrangement, empty, gain, ((1, 1), weight, passed))
    np.testing.assert_array_equal(passed, share)
    np.testing.assert_allclose(weight[0, :2], [0, 0.5])  # the size of a single part is its own
    assert 0.5**0.5 < weight[0, 2] < 1
    assert weight[0, 3] == pytest.approx(1)
    # a disc of all the area, and four discs that do not feel each other
    scattered = arrangement == Arrangement.SCATTERED
    assert (0.15 if scattered else 0.1) < weight[0, 4] < (0.2 if scattered else 0.15)
    np.testing.assert_allclose(empty, 1 - weight)
    np.testing.assert_allclose(gain * parts, weight)


@of_every_engine
def test_neighbours_of_a_wave(engine):
    """A wave keeps its form: the means multiply it by the weights' own symbol."""
    ny, nx, ky, kx = 12, 15, 5, 3
    y, x = 2 * np.pi * ky / ny, 2 * np.pi * kx / nx
    wave = np.cos(y * np.arange(ny)[:, None] + x * np.arange(nx)[None, :] + 0.3)
    actual = np.empty_like(wave)
    engine.neighbours(wave, WEIGHTS, actual)
    across_y, across_x, diagonal = WEIGHTS
    symbol = 2 * across_y * np.cos(y) + 2 * across_x * np.cos(x) + 4 * diagonal * np.cos(y) * np.cos(x)
    np.testing.assert_allclose(actual, symbol * wave, atol=1e-14)


@pytest.mark.parametrize(
    ("grid", "engine", "precision", "cap"),
    every_pair(GRIDS, list(ENGINES), ["float32", "float64"], [0.7, np.inf]),
    ids=str,
)
def test_refined_pressure_keeps_the_load_of_every_cell_and_the_cap(grid, engine, precision, cap):
    (shape, factors), precision = grid, np.dtype(precision).type
    fields = make_fields(shape, factors, (precision, precision), np.inf)
    coarse, fine = np.minimum(fields["coarse_pressure"], precision(cap)), np.full(shape, np.nan, precision)
    # detail that takes all between nothing and, without a cap, everything to the highest point of its cell
    for stiffness in (0.0, 0.6, 1e3) if cap < np.inf else (0.0, 0.6, 1e3, 1e20):
        ENGINES[engine].refine(coarse, factors, fields["field"], WEIGHTS, stiffness, cap, fine)
        means = np.empty_like(coarse)
        array_api.block_mean(fine, factors, means)
        np.testing.assert_allclose(means, coarse, rtol=64 * np.finfo(precision).eps)
        assert fine.min() >= 0
        assert fine.max() <= precision(cap)
        full = np.repeat(np.repeat(coarse == precision(cap), factors[0], 0), factors[1], 1)
        assert (fine[full] == precision(cap)).all()


@of_every_engine
def test_refined_pressure_of_a_cell_that_is_closed_or_touches_at_one_point(engine):
    """Under a wave of the shortest length: full contact where the load closes the gap, else only on top."""
    heights = np.tile([[0.3, -0.3]], (4, 6))
    weights = (0.0, 0.5, 0.0)  # then the detail is twice the height
    fine = np.empty_like(heights)
    engine.refine(np.full((2, 6), 2.0), (2, 2), heights, weights, 3.0, np.inf, fine)
    np.testing.assert_allclose(fine, 2 + 6 * heights, rtol=1e-14)
    engine.refine(np.full((2, 6), 0.5), (2, 2), heights, weights, 3.0, np.inf, fine)
    np.testing.assert_allclose(fine, np.tile([[1.0, 0.0]], (4, 6)), rtol=1e-14)


@of_every_engine
def test_refined_pressure_finds_the_edge_between_the_cells(engine):
    """The pressure sqrt(a² - x²) under a cylinder: far nearer than by repeating the cells."""
    n, factor, edge = 32, 8, 0.3

    def pressure(size):
        x = (np.arange(size) + 0.5) / size - 0.5
        # mean over the cell, by many points
        points = x[:, None] + (np.arange(64) + 0.5) / 64 / size - 0.5 / size
        return np.sqrt(np.maximum(edge**2 - points**2, 0)).mean(axis=1)[None, :]

    coarse, exact = pressure(n), pressure(n * factor)
    fine = np.empty_like(exact)
    engine.refine(coarse, (1, factor), np.zeros_like(fine), WEIGHTS, 1.0, np.inf, fine)
    error = np.abs(fine - exact).mean()
    assert error < 0.15 * np.abs(np.repeat(coarse, factor, axis=1) - exact).mean()
    assert abs(np.count_nonzero(fine) - np.count_nonzero(exact)) <= 4


@of_every_engine
def test_line_contacts_weigh_as_conductors_in_parallel_behind_the_logarithm_of_the_distance(engine):
    def weigh(parts, factors):
        (empty, gain), weight = np.empty((2, *parts.shape)), np.empty_like(parts)
        arrangement = Arrangement.ALONG_A_LINE
        engine.weigh(parts, parts, factors, arrangement, empty, gain, ((1, 1), weight, parts.copy()))
        np.testing.assert_allclose(empty, 1 - weight)
        return weight

    # one point in ever larger cells: the reciprocal of its weight grows by the same each time
    weight = np.ones((1, 1))
    for doublings in range(1, 6):
        # the mean over a cell in contact and one that is not
        weight = weigh(weight / 2, (1, 2))
        assert 1 / weight[0, 0] == pytest.approx(1 + doublings / 2)
    # cells in full contact stay so, those without any too, whatever the factor
    for factors in ((1, 2), (1, 3), (5, 1)):
        np.testing.assert_array_equal(weigh(np.array([[1.0, 0.0]]), factors), [[1.0, 0.0]])
