"""The parts of the solver by themselves: certificate, state, line search, safe step, iteration, sweep."""

import dataclasses

import array_api_strict
import numpy as np
import pytest
from known_surfaces import self_affine
from scipy.optimize import minimize_scalar

from roughcontact.arguments.maps import height_map
from roughcontact.contact import certificate
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.grid import Grid
from roughcontact.contact.iteration import Iterate, first_guess_on_grid, solve_on_grid
from roughcontact.contact.line_search import LineSearch, minimize_between
from roughcontact.contact.nested_iteration import COARSE_TOLERANCE, _highest_part, first_guess, nested_heights
from roughcontact.contact.problem import nondimensionalise
from roughcontact.contact.projected_gradient import project_to_load, projected_gradient_step
from roughcontact.contact.state import contact_mean, norm, scale_below_cap, scale_to_load
from roughcontact.contact.sweep import sweep
from roughcontact.kernels.arrays import DOUBLE, SINGLE, empty, namespace
from roughcontact.surface.synthetic import rough_reference_surface

LENGTHS = (1.0, 1.0)
EPS = {SINGLE: 2.0**-23, DOUBLE: 2.0**-52}


def rough(points=32, seed=0):
    """Return dimensionless heights of unit rms gradient."""
    surface = self_affine((points, points), 1 / points, (4 / points, 0.5), rms_gradient=1.0, seed=seed)
    return surface.values


def symbol(shape, lengths=LENGTHS):
    """Return |q|/2 over the full plane."""
    qy, qx = (2 * np.pi * np.fft.fftfreq(n, length / n) for n, length in zip(shape, lengths, strict=True))
    return np.hypot(qy[:, None], qx[None, :]) / 2


def energy_norm(field, *, inverse=False):
    """Return ||.||_G, or ||.||_{G^-1}, by sums over all waves."""
    power = np.abs(np.fft.fft2(field) / field.size) ** 2
    stiffness = symbol(field.shape)
    stiffness[0, 0] = 1.0
    power[0, 0] = 0.0
    return float(np.sqrt((power * (stiffness if inverse else 1 / stiffness)).sum()))


def solved(grid, load, tolerance=1e-12):
    """Return the converged state of a load."""
    start = np.full(grid.shape, load)
    return solve_on_grid(grid, start, load, tolerance=tolerance).state


# the error bound


@pytest.mark.parametrize("load", [0.02, 0.2, 0.8])
@pytest.mark.parametrize("steps", [1, 2, 3])
def test_the_bound_is_never_below_the_error_and_hardly_above(load, steps):
    """Far from convergence, too; twice the bound, or nine tenths of it, would not pass."""
    grid = Grid(rough(64), LENGTHS)
    exact = solved(grid, load).pressure
    iterate = solve_on_grid(grid, np.full(grid.shape, load), load, tolerance=1e-12, max_steps=steps)
    error = energy_norm(iterate.state.pressure - exact) / energy_norm(iterate.state.pressure)
    assert 1e-7 < error < 1
    assert 1.0 <= iterate.error_bound / error < 1.6


def test_the_bound_of_ten_maps_is_sharp_in_the_mean():
    ratios = []
    for seed in range(10):
        grid = Grid(rough(64, seed), LENGTHS)
        exact = solved(grid, 0.1).pressure
        iterate = solve_on_grid(grid, np.full(grid.shape, 0.1), 0.1, tolerance=1e-2)
        error = energy_norm(iterate.state.pressure - exact) / energy_norm(iterate.state.pressure)
        ratios.append(iterate.error_bound / error)
    assert min(ratios) >= 1
    assert np.median(ratios) < 1.05
    assert max(ratios) < 1.1


def test_the_norm_that_the_bound_takes_is_that_of_a_residual_that_certifies():
    """Compared with sums over waves of the projected, interpolated residual."""
    grid = Grid(rough(), LENGTHS)
    state, _ = grid.evaluate(scale_to_load(np.random.default_rng(0).random(grid.shape) - 0.5, 0.2))
    residual = grid.residual(state, precision=DOUBLE)
    interpolated = grid.interpolator(DOUBLE).field.copy()
    assert np.sqrt(residual.energy) == pytest.approx(energy_norm(interpolated, inverse=True), rel=1e-10)
    allowed = np.where(state.pressure > 0, state.gap, np.minimum(interpolated, state.gap))
    bound = certificate.error_bound(grid, state, residual) * state.norm
    exact = energy_norm(allowed, inverse=True)
    floor = certificate.rounding_floor(grid.halfspace, state) * state.norm
    assert bound - floor >= exact * (1 + 1e-4) * (1 - 1e-10)
    assert bound - floor <= exact * 1.2


def test_the_bound_without_a_transform_is_a_bound_from_the_stiffest_wave():
    grid = Grid(rough(), LENGTHS)
    state, _ = grid.evaluate(scale_to_load(np.random.default_rng(1).random(grid.shape) - 0.5, 0.3))
    gap = np.where(state.pressure > 0, state.gap, np.minimum(state.gap, 0))  # penetrations alone where p = 0
    expected = np.sqrt(np.mean(gap**2) * symbol(grid.shape).max()) * (1 + 1e-4) / energy_norm(state.pressure)
    floor = certificate.rounding_floor(grid.halfspace, state)
    assert certificate.bound_without_transform(grid, state) == pytest.approx(expected + floor, rel=1e-6)
    assert certificate.bound_without_transform(grid, state) > energy_norm(gap, inverse=True) / state.norm


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE])
def test_what_rounding_hides_is_added_to_the_bound(precision):
    grid = Grid(rough(), LENGTHS)
    state, _ = grid.evaluate(scale_to_load(rough().astype(precision), 0.2))
    floor = certificate.rounding_floor(grid.halfspace, state)
    assert certificate.relative_bound(grid.halfspace, state, 0.0) == floor > 0
    residual = 3 * floor * state.norm
    assert certificate.relative_bound(grid.halfspace, state, residual) == pytest.approx(4 * floor, rel=1e-3)


def test_a_uniform_pressure_is_right_where_it_leaves_no_residual_and_unknown_elsewhere():
    grid = Grid(rough(), LENGTHS)
    state, _ = grid.evaluate(np.full(grid.shape, 0.5))
    state = dataclasses.replace(state, norm=0.0)
    assert certificate.relative_bound(grid.halfspace, state, 0.0) == 0.0
    assert certificate.relative_bound(grid.halfspace, state, 1e-300) == np.inf
    assert certificate.rounding_floor(grid.halfspace, state) == 0.0


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE])
@pytest.mark.parametrize("cap", [np.inf, 0.5])
def test_the_floor_is_the_norm_of_white_noise_of_the_size_of_rounding(precision, cap):
    """That of separation and pressure, and the largest norm of what the unit rounds."""
    grid = Grid(rough(), LENGTHS, Elasticity(hardness=cap))
    state, _ = grid.evaluate(scale_to_load(rough().astype(precision), 0.2, cap=cap))
    stiffness = symbol(grid.shape)[:, : grid.shape[1] // 2 + 1]
    stiffness[0, 0] = np.inf
    compliance, stiffness = 1 / stiffness, np.where(np.isinf(stiffness), 0, stiffness)
    free = np.mean((state.pressure > 0) & (state.pressure < cap)) if cap < np.inf else 1
    pressure = np.sqrt(np.mean(state.pressure.astype(float) ** 2))
    transforms = state.size * np.sqrt(stiffness.mean()) + pressure * np.sqrt(compliance.mean())
    by_unit = pressure * np.sqrt(compliance.max() / free)
    expected = (np.sqrt(np.log2(state.pressure.size)) * transforms + by_unit) / state.norm
    for precision_asked, eps in ((None, EPS[precision]), (SINGLE, EPS[SINGLE])):
        assert certificate.rounding_floor(grid.halfspace, state, precision_asked) == pytest.approx(
            eps * expected, rel=1e-3
        )
    noise = np.random.default_rng(0).standard_normal((64, *grid.shape))
    for inverse, values in ((True, stiffness), (False, compliance)):
        norms = [energy_norm(field - field.mean(), inverse=inverse) ** 2 for field in noise]
        assert np.sqrt(np.mean(norms) / values.mean()) == pytest.approx(1, rel=0.05)


def test_a_result_is_in_the_precision_asked_for_even_where_the_steps_need_more():
    """Else a file in single precision would round it again, after its bound."""
    problem = nondimensionalise(rough_reference_surface(64), precision=SINGLE, threads=1)
    single, exact = (
        next(sweep(problem, [1e-7], tolerance=tolerance, precision=precision, threads=1))
        for precision, tolerance in ((SINGLE, 1e-4), (DOUBLE, 1e-10))
    )
    pressure, separation = single.state.pressure, single.state.separation
    assert pressure.dtype == separation.dtype == np.float32
    assert exact.floor < single.floor < 1e-4  # the steps were in double precision
    error = energy_norm(pressure - exact.state.pressure) / energy_norm(pressure)
    assert error <= single.error_bound + exact.error_bound <= 1.1e-4


# states and the line between two of them


def test_a_state_holds_what_sums_over_waves_give():
    heights = rough()
    grid = Grid(heights, LENGTHS)
    pressure = scale_to_load(np.random.default_rng(2).random(grid.shape) - 0.6, 0.1)
    state, line = grid.evaluate(pressure)
    stiffness = symbol(grid.shape)
    stiffness[0, 0] = np.inf
    displaced = np.fft.ifft2(np.fft.fft2(pressure) / stiffness).real
    np.testing.assert_allclose(state.separation, displaced - heights, atol=1e-13)
    assert state.norm == pytest.approx(energy_norm(pressure), rel=1e-12)
    assert state.offset == pytest.approx((displaced - heights)[pressure > 0].mean(), rel=1e-12)
    assert state.size == pytest.approx(
        np.sqrt(np.mean(displaced**2)) + np.sqrt(np.mean(heights**2)), rel=1e-6
    )
    np.testing.assert_array_equal(state.gap, state.separation - state.offset)
    assert (line.slope, line.slope_after) == (0, 0)  # nothing has changed


def elastic_energy(grid, pressure, heights):
    return 0.5 * energy_norm(pressure) ** 2 - float(np.mean(pressure * heights))


def test_the_line_search_finds_the_least_energy_between_two_states():
    heights = rough()
    grid = Grid(heights, LENGTHS)
    rng = np.random.default_rng(3)
    start, _ = grid.evaluate(scale_to_load(rng.random(grid.shape) - 0.5, 0.2))
    stop, line = grid.evaluate(scale_to_load(heights - 0.5 * heights.max(), 0.2), former=start)

    def energy(share):
        moved = start.pressure + share * (stop.pressure - start.pressure)
        return elastic_energy(grid, moved, heights)

    step = 1e-4
    assert line.slope == pytest.approx((energy(step) - energy(-step)) / (2 * step), rel=1e-6)
    assert line.slope_after == pytest.approx((energy(1 + step) - energy(1 - step)) / (2 * step), rel=1e-6)
    best = minimize_scalar(energy, bracket=(0, 1)).x
    assert line.minimizer == pytest.approx(best, abs=1e-6)
    assert line.descends == (energy(1) < energy(0))
    lower = minimize_between(start, stop, line, cap=np.inf)
    fresh, _ = grid.evaluate(lower.pressure)
    np.testing.assert_allclose(lower.separation, fresh.separation, atol=1e-13)
    assert lower.norm == pytest.approx(fresh.norm, rel=1e-10)
    assert lower.offset == pytest.approx(fresh.offset, rel=1e-10)


@pytest.mark.parametrize(
    ("slope", "curvature", "minimizer", "descends"),
    [(-1.0, -0.5, 2.0, True), (-1.0, 1.0, 0.5, False), (-1.0, 3.0, 0.25, False), (-2.0, -2.0, np.inf, True)],
)
def test_minimizer_and_descent_of_known_parabolas(slope, curvature, minimizer, descends):
    line = LineSearch(slope, curvature)
    assert line.minimizer == minimizer
    assert line.descends is descends


def test_no_state_lies_below_one_from_which_the_energy_rises():
    grid = Grid(rough(), LENGTHS)
    state, _ = grid.evaluate(np.full(grid.shape, 0.5))
    assert minimize_between(state, state, LineSearch(0.0, 1.0), cap=np.inf) is None
    assert minimize_between(state, state, LineSearch(1e-300, 1.0), cap=np.inf) is None


def test_the_offset_where_no_point_is_free():
    pressure = np.array([[2.0, 2.0, 0.0, 0.0]])
    separation = np.array([[-3.0, -1.0, 2.0, 5.0]])
    # any value between the highest at the cap and the lowest without pressure
    assert contact_mean(pressure, separation, cap=2.0) == pytest.approx(0.5)
    assert contact_mean(pressure[:, :2], separation[:, :2], cap=2.0) == -1.0
    assert contact_mean(pressure, separation, cap=3.0) == -2.0


@pytest.mark.cases
def test_scaling_to_a_load(pressure, load, cap, expected):
    scaled = scale_to_load(np.array([pressure]), load, cap=cap)
    np.testing.assert_allclose(scaled, [expected], atol=1e-14)


@pytest.mark.parametrize("cap", [0.3, 0.9])
def test_scaling_keeps_points_at_the_cap_through_a_change_of_precision(cap):
    assert float(np.float32(0.3)) > 0.3
    assert float(np.float32(0.9)) < 0.9
    for precision_before, precision_after in (
        ("float32", "float64"),
        ("float64", "float32"),
        ("float32", "float32"),
    ):
        pressure = np.array([0.0, 0.1 * cap, 0.2 * cap, cap, cap], precision_before)
        scaled = scale_to_load(pressure, 0.55 * cap, cap=cap, precision=precision_after)
        assert scaled.dtype == precision_after
        np.testing.assert_array_equal(scaled >= cap, [False, False, False, True, True])
        np.testing.assert_allclose(scaled / cap, [0, 0.25, 0.5, 1, 1], rtol=1e-6)
        assert not np.shares_memory(scaled, pressure)


@pytest.mark.parametrize("lengths", [LENGTHS, (0.1, 10.0)], ids=["square", "separate lines"])
@pytest.mark.parametrize("like", [np.asarray, array_api_strict.asarray], ids=["compiled", "plain"])
@pytest.mark.parametrize("cap", [0.3, 0.35])
def test_a_step_that_changes_the_precision_leaves_points_at_the_cap(lengths, like, cap):
    assert float(np.float32(0.3)) > 0.3
    assert float(np.float32(0.35)) < 0.35
    heights = like(rough())
    grid = Grid(heights, lengths, Elasticity(hardness=cap))
    uniform = namespace(heights).full_like(heights, 0.1)
    pressure, _ = first_guess_on_grid(grid, uniform, 0.1, tolerance=0.01)
    state, _ = grid.evaluate(pressure)
    at_cap = np.asarray(state.pressure) == np.float32(cap)
    stay = at_cap & (np.asarray(state.gap) < 0)
    assert stay.sum() > 20
    correction = grid.precondition(grid.residual(state, precision="float32"))
    out = empty(heights, "float64")
    moved = np.asarray(grid.advance(state, correction, 0.5, 0.1, out))
    assert moved.dtype == np.float64
    assert moved.max() == cap
    assert (moved[stay] == cap).all()
    assert moved.mean() == pytest.approx(0.1, rel=1e-12)


@pytest.mark.cases
def test_the_factor_below_the_cap_that_makes_up_the_load(pressure, load, expected):
    assert scale_below_cap(np.array(pressure), load, 1.0) == expected


@pytest.mark.parametrize("precision", [SINGLE, DOUBLE])
@pytest.mark.parametrize("cap", [0.3, 2.0, np.inf])
@pytest.mark.parametrize("spread", [1e-3, 1.0, 1e3])
def test_projection_to_a_load_is_the_nearest_feasible_field(precision, cap, spread):
    """What it takes is the same where the pressure is free, no more at zero, and no less at the cap."""
    target = spread * np.random.default_rng(5).standard_normal((30, 40)).astype(precision)
    projection = project_to_load(target, 0.2, cap=cap)
    assert projection.dtype == precision
    assert projection.mean(dtype=float) == pytest.approx(0.2, rel=4 * EPS[precision] * max(1, spread))
    assert ((projection >= 0) & (projection <= cap)).all()
    difference = (target - projection).astype(float)
    assert difference[projection < cap].max() <= difference[projection > 0].min() + 8 * EPS[precision] * (
        spread + 1
    )


def test_a_load_at_the_cap_is_refused():
    with pytest.raises(ValueError, match="cannot be carried below the cap 2"):
        scale_to_load(np.ones(4), 2.0, cap=2.0)


def test_a_norm_of_rounding_is_zero_and_not_a_root_of_less():
    assert norm(np.array([[1.0]]), np.array([[-1e-30]])) == 0.0
    assert norm(np.array([[3.0, 4.0]]), np.array([[3.0, 4.0]])) == pytest.approx(np.sqrt(12.5))


# the safe step


@pytest.mark.parametrize("cap", [np.inf, 0.6])
def test_safe_steps_alone_converge_downhill(cap):
    heights = rough(16)
    grid = Grid(heights, LENGTHS, Elasticity(hardness=cap))
    load = 0.2
    exact = solved(grid, load, 1e-10).pressure
    state, _ = grid.evaluate(np.full(grid.shape, load))
    energies, errors = [], []
    for _ in range(300):
        lower = projected_gradient_step(grid, state, load)
        if lower is None:
            break
        state = lower
        energies.append(elastic_energy(grid, state.pressure, heights))
        errors.append(energy_norm(state.pressure - exact))
        assert state.pressure.min() >= 0
        assert state.pressure.max() <= cap * (1 + 1e-14)
        assert state.pressure.mean() == pytest.approx(load, rel=1e-12)
    assert (np.diff(energies) <= 1e-15 * abs(energies[0])).all()
    assert errors[-1] < 1e-3 * errors[0]


def test_there_is_no_safe_step_from_the_solution_of_a_flat_map():
    grid = Grid(np.zeros((8, 8)), LENGTHS)
    state, _ = grid.evaluate(np.full(grid.shape, 0.5))
    assert projected_gradient_step(grid, state, 0.5) is None


# the iteration and what is around it


def test_the_iteration_ends_by_its_tolerance_its_steps_or_the_floor():
    grid = Grid(rough(64), LENGTHS)
    start = np.full(grid.shape, 0.2)
    enough = solve_on_grid(grid, start.copy(), 0.2, tolerance=1e-6)
    assert enough.error_bound <= 1e-6
    assert enough.state.pressure.dtype == np.float64
    cut = solve_on_grid(grid, start.copy(), 0.2, tolerance=1e-6, max_steps=1)
    assert cut.steps == 1
    assert cut.error_bound > 1e-6
    floor = solve_on_grid(grid, start.copy(), 0.2, tolerance=1e-16)
    assert 1e-16 < floor.error_bound <= 4 * certificate.rounding_floor(grid.halfspace, floor.state)
    single = solve_on_grid(grid, start.copy(), 0.2, tolerance=1e-3, finish=SINGLE)
    assert single.state.pressure.dtype == np.float32
    assert single.error_bound <= 1e-3


@pytest.mark.parametrize("load", [0.05, 0.5])
def test_every_step_lowers_the_energy(load):
    heights = rough(64)
    grid = Grid(heights, LENGTHS)
    iterate = Iterate(grid, np.full(grid.shape, load), load, tolerance=1e-10, finish=DOUBLE)
    energies = []
    for step in range(8):
        iterate.measure(step)
        energies.append(elastic_energy(grid, iterate.state.pressure.astype(float), heights))
        assert iterate.state.pressure.min() >= 0
        iterate.choose_precision()
        iterate.advance()
    # to the rounding of the first steps, in single precision
    assert (np.diff(energies) <= 1e-6 * abs(energies[-1])).all()
    assert energies[0] - energies[-1] > 1e-3 * abs(energies[-1])


def test_a_stalled_iteration_is_noticed():
    grid = Grid(rough(), LENGTHS)
    iterate = Iterate(grid, np.full(grid.shape, 0.2), 0.2, tolerance=1e-3, finish=DOUBLE)
    iterate.measure(0)
    assert not iterate.has_stalled(20)
    assert iterate.has_stalled(21)


def test_a_residual_that_leaves_points_out_certifies_nothing():
    """Its energy is no bound; what `certify` says of the state is that of all of its contact."""
    grid = Grid(rough(64), LENGTHS)
    start = np.random.default_rng(0).random(grid.shape)
    iterate = Iterate(grid, start, 0.1, tolerance=1.0, finish=SINGLE)
    plain = grid.residual(iterate.state, precision=SINGLE)
    values = grid.interpolator(SINGLE).values
    active = np.count_nonzero(values)
    full_bound = certificate.error_bound(grid, iterate.state, plain)
    iterate.measure(0)
    assert not iterate.residual.certifies
    assert np.count_nonzero(values) < active
    assert iterate.bound < 0.98 * full_bound
    assert not iterate.has_stalled(0)
    iterate.certify()
    assert iterate.bound == pytest.approx(full_bound, rel=1e-6)
    long_pixels = Grid(rough(64), (8.0, 0.125))
    state, _ = long_pixels.evaluate(start)
    assert long_pixels.residual(state, precision=DOUBLE, predict=True).certifies


def test_the_contact_that_is_predicted_is_nearer_to_the_true_one():
    """Of a first guess from a coarser grid: fewer of its points are out of contact in the end."""
    heights = rough(128)
    grid = Grid(heights, LENGTHS)
    (factors, coarse), *_ = nested_heights(heights.astype(np.float32), LENGTHS)
    grids = [grid, Grid(coarse, LENGTHS)]
    guess, _ = first_guess(grids, [factors], 0.05, grids[-1].halfspace.pressure(coarse))
    state, _ = grid.evaluate(guess)
    contact = solved(grid, 0.05).pressure > 0
    wrong = []
    for predict in (False, True):
        grid.residual(state, precision=DOUBLE, predict=predict)
        wrong.append(np.count_nonzero((grid.interpolator(DOUBLE).values != 0) != contact))
    assert wrong[1] < 0.75 * wrong[0]


def test_the_coarsest_grid_starts_from_the_highest_part_of_a_pressure():
    field = np.random.default_rng(0).standard_normal((16, 16)).astype(SINGLE)
    for mean in (1e-12, 1e-3, 0.4, 50.0):  # one point, a few, most, all
        part = _highest_part(field, mean)
        assert part.mean(dtype=float) == pytest.approx(mean, rel=1e-5)
        inside = part > 0
        assert inside.any()
        np.testing.assert_allclose(np.ptp((field - part)[inside]), 0, atol=1e-5)
        assert field[~inside].max(initial=-np.inf) <= (field - part)[inside].min() + 1e-6


def test_a_first_guess_is_as_good_as_it_is_said_to_be():
    heights = rough(256)
    fine = Grid(heights, LENGTHS)
    nested = nested_heights(heights.astype(np.float32), LENGTHS)
    assert [coarse.shape for _, coarse in nested] == [(128, 128), (32, 32)]
    by_two = [coarse.shape for _, coarse in nested_heights(np.zeros((256, 256), np.float32), (4.0, 0.25))]
    assert by_two == [(256, 128), (256, 64), (256, 32)]
    np.testing.assert_allclose(nested[0][1], heights.reshape(128, 2, 128, 2).mean((1, 3)), atol=1e-6)
    grids = [fine, *(Grid(coarse, LENGTHS) for _, coarse in nested)]
    fluctuation = grids[-1].halfspace.pressure(nested[-1][1])
    guess, steps = first_guess(grids, [factors for factors, _ in nested], 0.1, fluctuation)
    exact = solved(fine, 0.1, 1e-8).pressure
    assert steps > 0
    assert guess.mean() == pytest.approx(0.1, rel=1e-5)
    assert energy_norm(guess - exact) < 0.15 * energy_norm(exact)
    guess_improved, _ = first_guess_on_grid(fine, guess, 0.1, tolerance=COARSE_TOLERANCE)
    assert energy_norm(guess_improved - exact) < 2 * COARSE_TOLERANCE * energy_norm(exact)


def test_a_sweep_counts_every_application_and_solves_each_load_as_if_alone():
    surface = height_map(1e-6 * rough(128), (1e-6, 1e-6))
    problem = nondimensionalise(surface)
    loads = [0.05, 0.1, 3.0]
    together = list(sweep(problem, loads, tolerance=1e-5, threads=1))
    for load, solution in zip(loads, together, strict=True):
        (single,) = sweep(problem, [load], tolerance=1e-5, threads=1)
        np.testing.assert_array_equal(solution.state.pressure, single.state.pressure)
        assert solution.steps == single.steps
        assert solution.error_bound == single.error_bound <= 1e-5
        assert solution.state.pressure.mean() == pytest.approx(load, rel=1e-10)
    full = together[-1]
    assert full.steps == 0  # closed form
    assert full.state.pressure.min() > 0
    assert full.state.pressure.std() == pytest.approx(0.5, rel=1e-3)  # g/2 in units of E* g
    assert together[0].applications > together[0].steps >= 2


def test_a_flat_map_takes_no_application():
    (solution,) = sweep(
        nondimensionalise(height_map(np.zeros((4, 6)), 1e-6)), [0.7], tolerance=1e-4, threads=1
    )
    assert (solution.state.pressure == 0.7).all()
    assert (solution.applications, solution.steps, solution.error_bound) == (0, 0, 0)


@pytest.mark.parametrize("hurst", [-0.5, 0.5, 0.8])  # white noise, a random walk, a rough profile
@pytest.mark.parametrize("load", [0.03, 0.3])
def test_long_profiles_take_few_applications(hurst, load):
    """The displacement beside a line contact does not decay: what is handed on must not be lost far away."""
    points = 2**14
    waves = np.fft.rfftfreq(points, 1 / points)
    amplitude = np.where(waves > 0, np.maximum(waves, 1), np.inf) ** -(hurst + 0.5)
    noise = np.fft.rfft(np.random.default_rng(5).standard_normal(points))
    profile = height_map(np.fft.irfft(amplitude * noise, n=points)[None, :], 1.0)
    (solution,) = sweep(nondimensionalise(profile), [load], tolerance=1e-4, threads=1)
    assert solution.error_bound <= 1e-4
    assert solution.applications <= 20
