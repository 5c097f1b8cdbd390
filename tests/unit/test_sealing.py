"""The gap as a path: regions around the period, the narrowest place, flow factors, leak rate."""

import itertools
import json

import numpy as np
import pytest
import scipy.sparse as sp
from known_surfaces import self_affine
from scipy.integrate import quad
from scipy.ndimage import label
from scipy.optimize import brentq
from scipy.sparse.linalg import splu

import roughcontact as rc
from roughcontact.arguments.maps import height_map
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.variables import describe
from roughcontact.kernels.compiled import Regions
from roughcontact.statistics.sealing import flow as flow_module
from roughcontact.statistics.sealing.connectivity import connected_regions, percolates, region_sizes
from roughcontact.statistics.sealing.flow import flow_columns, leak_columns
from roughcontact.statistics.sealing.multigrid import Network, multigrid
from roughcontact.statistics.sealing.percolation import half_way_levels, percolation_columns
from roughcontact.surface.synthetic import rough_reference_surface
from validation import closed_forms

SQUARE = (1e-6, 1e-6)


def rough_gap(points, *, closed, seed=0):
    """Return a gap of a self-affine map that is cut off where it is closed."""
    height = self_affine((points, points), 1.0, (points / 8, points / 2), rms_height=1.0, seed=seed).values
    return np.maximum(np.quantile(height, 1 - closed) - height, 0)


def directions_of_loops(inside):
    """Return along which axes a walker can come back to where it started in another copy of the map."""
    ny, nx = inside.shape
    wraps = [False, False]
    for start in itertools.product(range(ny), range(nx)):
        if not inside[start]:
            continue
        seen, stack = {start: start}, [start]
        while stack:
            y, x = stack.pop()
            for step_y, step_x in ((0, 1), (1, 0), (0, -1), (-1, 0)):
                position = y + step_y, x + step_x
                cell = position[0] % ny, position[1] % nx
                if not inside[cell]:
                    continue
                if cell not in seen:
                    seen[cell] = position
                    stack.append(position)
                else:
                    wraps[0] |= seen[cell][0] != position[0]
                    wraps[1] |= seen[cell][1] != position[1]
    return tuple(wraps)


@pytest.mark.parametrize("seed", range(60))
def test_regions_around_the_period_are_those_of_a_walker(seed):
    generator = np.random.default_rng(seed)
    shape = tuple(generator.integers(1, 8, 2))
    inside = generator.random(shape) < generator.uniform(0.3, 0.9)
    assert percolates(inside) == directions_of_loops(inside)


@pytest.mark.parametrize(("turns_y", "turns_x"), [(1, 2), (2, 1), (1, -3), (3, 1)])
def test_a_path_that_runs_around_several_times(turns_y, turns_x):
    """One closed channel that winds around both axes: a single region, open along both."""
    points = 60
    t = np.linspace(0, 1, 4000, endpoint=False)
    inside = np.zeros((points, points), bool)
    y, x = (np.floor(t * turns * points).astype(int) % points for turns in (turns_y, turns_x))
    inside[y, x] = True
    inside[np.roll(y, 1), x] = True  # corners
    assert region_sizes(inside).size == 1
    assert percolates(inside) == (True, True)


def test_a_profile_runs_around_along_the_axis_it_does_not_vary_along():
    assert percolates(np.array([[True, False, False]])) == (True, False)
    assert percolates(np.array([[False], [True], [True]])) == (False, True)
    assert percolates(np.zeros((3, 3), bool)) == (False, False)
    assert percolates(np.ones((3, 3), bool)) == (True, True)


def test_regions_are_numbered_with_what_they_do():
    region, around = connected_regions(np.array([[1, 1, 1], [0, 0, 0], [0, 1, 0], [0, 0, 0]]) == 1)
    assert region.max() == len(around) - 1 == 2
    assert not around[0].any()
    assert around[region[0, 0]].tolist() == [False, True]
    assert not around[region[2, 1]].any()


@pytest.mark.parametrize("seed", range(20))
def test_the_constriction_is_the_highest_level_that_is_open(seed):
    """Against every level in turn."""
    generator = np.random.default_rng(seed)
    gap = np.maximum(generator.random((9, 7)) - 0.2, 0)
    columns = percolation_columns(gap)
    for axis, name in ((0, "y"), (1, "x")):
        levels = [level for level in np.unique(gap[gap > 0]) if directions_of_loops(gap >= level)[axis]]
        assert columns[f"critical_constriction_{name}"] == max(levels, default=0.0)
        assert columns[f"gap_percolates_{name}"] == bool(levels)


@pytest.mark.parametrize("seed", range(40))
def test_runs_and_labels_tell_the_same_of_every_level(seed):
    """Also of equal heights, of single rows and columns, and where nothing or everything is open."""
    generator = np.random.default_rng(seed)
    for precision, levels in itertools.product((np.float32, np.float64), (3, 100, None)):
        gap = generator.random(generator.integers(1, 40, 2))
        gap = np.round(gap * levels) / levels if levels else gap
        gap[generator.random(gap.shape) < generator.uniform(0, 0.6)] = 0
        regions = Regions(gap.astype(precision))
        for level in np.unique(gap.astype(precision))[:50]:
            assert regions.percolates(float(level)) == percolates(gap.astype(precision) >= level)


@pytest.mark.parametrize("seed", range(10))
def test_half_ways_lead_from_edge_to_edge(seed):
    """Against every level in turn, by labels of a half that is not periodic."""
    gap = np.maximum(np.random.default_rng(seed).random((12, 9)) - 0.1, 0)
    for axis, across in (("y", gap), ("x", gap.T)):
        half = len(across) // 2
        open_from_edge_to_edge = []
        for start in (0, (len(across) - half) // 2, len(across) - half):
            for level in np.unique(across[across > 0]):
                labels, _ = label(across[start : start + half] >= level)
                if np.intersect1d(labels[0][labels[0] > 0], labels[-1]).size:
                    open_from_edge_to_edge.append(level)
        assert half_way_levels(gap)[f"critical_constriction_{axis}"] == max(open_from_edge_to_edge)


def test_half_of_a_single_row_is_a_point():
    levels = half_way_levels(np.array([[1.0, 3.0, 2.0, 4.0]]))
    assert levels == {"critical_constriction_x": 2.0, "critical_constriction_y": 4.0}


def test_random_points_percolate_at_the_published_threshold():
    """Sites of a square lattice percolate from a share of 0.5927 on (Stauffer and Aharony 1994)."""
    columns = percolation_columns(np.random.default_rng(5).random((700, 700)))
    assert columns["critical_constriction_x"] == pytest.approx(1 - 0.5927, abs=0.012)
    assert columns["critical_constriction_y"] == pytest.approx(1 - 0.5927, abs=0.012)


def test_constriction_of_crossed_waves_is_their_saddle():
    """Of 1 + (cos x + cos y)/2: between two valleys, where one cosine is 1 and the other -1."""
    x = 2 * np.pi * np.arange(200) / 200
    gap = 1 + 0.5 * (np.cos(x)[None, :] + np.cos(x)[:, None])
    columns = percolation_columns(gap)
    assert columns["critical_constriction_x"] == pytest.approx(1.0, abs=1e-12)
    assert columns["critical_constriction_y"] == columns["critical_constriction_x"]


@pytest.mark.parametrize("depth", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("steps", [SQUARE, (3e-6, 1e-6)])
def test_sinusoidal_channel_along_and_across(depth, steps):
    """Along <g³>/ū³ = 1 + 3ε²/2; across 1/(ū³ <g⁻³>) = (1 − ε²)^(5/2)/(1 + ε²/2)."""
    gap = 2e-7 * (1 + depth * np.cos(2 * np.pi * np.arange(128) / 128)) * np.ones((6, 1))
    along, across = closed_forms.channel_flow_factors(depth)
    columns = flow_columns(gap, steps, tolerance=1e-10)
    assert columns["flow_factor_yy"] == pytest.approx(along, rel=1e-9)
    assert columns["flow_factor_xx"] == pytest.approx(across, rel=1e-9)
    assert columns["flow_factor_xy"] == pytest.approx(0, abs=1e-9)
    turned = flow_columns(gap.T, steps[::-1], tolerance=1e-10)
    assert turned["flow_factor_xx"] == pytest.approx(along, rel=1e-9)


@pytest.mark.parametrize("depth", [0.2, 0.7])
def test_closed_form_of_the_channels_by_quadrature(depth):
    cubes, inverse = (quad(lambda t, n=n: (1 + depth * np.cos(t)) ** n, 0, np.pi)[0] / np.pi for n in (3, -3))
    assert closed_forms.channel_flow_factors(depth) == pytest.approx((cubes, 1 / inverse), rel=1e-10)
    squares = quad(lambda t: (1 + depth * np.cos(t)) ** -2, 0, np.pi)[0] / np.pi
    assert closed_forms.driven_share(depth) == pytest.approx(1 - squares / inverse, rel=1e-10)


def test_channels_at_an_angle_lead_the_flow_aside():
    """Channels along the diagonal: half the sum of both factors, and half their difference beside it."""
    points, depth = 256, 0.5
    phase = 2 * np.pi * (np.arange(points)[:, None] + np.arange(points)[None, :]) / points
    columns = flow_columns(1 + depth * np.cos(phase), SQUARE, tolerance=1e-8)
    along, across = closed_forms.channel_flow_factors(depth)
    assert columns["flow_factor_xx"] == pytest.approx((along + across) / 2, rel=1e-3)
    assert columns["flow_factor_yy"] == pytest.approx((along + across) / 2, rel=1e-3)
    assert columns["flow_factor_xy"] == pytest.approx((across - along) / 2, rel=1e-3)


def test_checkerboard_conducts_the_geometric_mean():
    """Dykhne (1970): two phases alike in all but their conductivity. It converges slowly at the corners."""
    deviations = []
    for points in (32, 128):
        board = np.indices((points, points)) // (points // 2)
        gap = np.where(board.sum(axis=0) % 2, 1.0, 3.0) ** (1 / 3)
        columns = flow_columns(gap, SQUARE, tolerance=1e-9)
        deviations.append(columns["flow_factor_xx"] * gap.mean() ** 3 / np.sqrt(3.0) - 1)
        assert columns["flow_factor_yy"] == pytest.approx(columns["flow_factor_xx"], rel=1e-6)
    assert abs(deviations[1]) < 2e-3
    assert abs(deviations[1]) < abs(deviations[0]) / 3


def test_keller_duality_on_a_rough_gap():
    """Keller (1964): 1/k conducts as k does, turned by 90° and divided by the determinant."""
    height = self_affine((128, 128), 1.0, (16.0, 64.0), rms_height=0.3, seed=3).values
    results = []
    for sign in (1, -1):
        gap = np.exp(sign * height / 3)
        columns = flow_columns(gap, SQUARE, tolerance=1e-8)
        results.append([columns[f"flow_factor_{name}"] * gap.mean() ** 3 for name in ("xx", "yy", "xy")])
    conductances, dual = np.array(results)
    determinant = conductances[0] * conductances[1] - conductances[2] ** 2
    np.testing.assert_allclose(dual, conductances / determinant, atol=3e-3)


def dense_flow(gap):
    """Return the flow factors of a network of cells, solved densely by least squares."""
    ny, nx = gap.shape
    number = np.arange(gap.size).reshape(gap.shape)
    cubed = (gap / gap.mean()) ** 3
    rows, drops = [], []
    for axis in (0, 1):
        ahead, target = np.roll(cubed, -1, axis), np.roll(number, -1, axis)
        for index in itertools.product(range(ny), range(nx)):
            if cubed[index] > 0 and ahead[index] > 0:
                root = np.sqrt(2 / (1 / cubed[index] + 1 / ahead[index]))
                row = np.zeros(gap.size)
                row[number[index]] -= root
                row[target[index]] += root
                rows.append(row)
                drops.append([root * (axis == 0), root * (axis == 1)])
    rows, drops = np.array(rows), np.array(drops, float)
    pressure = np.linalg.lstsq(rows, -drops, rcond=1e-13)[0]
    flow_field = drops + rows @ pressure
    return flow_field.T @ flow_field / gap.size


@pytest.mark.parametrize(("closed", "seed"), [(0.0, 1), (0.15, 2), (0.3, 0), (0.35, 5), (0.4, 3)])
def test_rough_gap_with_contact_against_a_dense_solution(closed, seed):
    gap = rough_gap(24, closed=closed, seed=seed)
    reference = dense_flow(gap)
    columns = flow_columns(gap, SQUARE, tolerance=1e-10)
    scale = max(reference[0, 0], reference[1, 1])
    assert columns["flow_factor_xx"] == pytest.approx(reference[1, 1], rel=1e-6, abs=1e-9 * scale)
    assert columns["flow_factor_yy"] == pytest.approx(reference[0, 0], rel=1e-6, abs=1e-9 * scale)
    assert columns["flow_factor_xy"] == pytest.approx(reference[0, 1], abs=1e-6 * scale)


def test_the_preconditioner_knows_no_unit_of_the_conductance():
    """Of links over nine powers of ten, and of the same a million times as strong."""
    points, generator = 40, np.random.default_rng(6)
    positions = np.argwhere(np.ones((points, points)))
    number = np.arange(points**2).reshape(points, points)
    link_ends = np.concatenate(
        [np.stack([number, np.roll(number, -1, axis)]).reshape(2, -1) for axis in (0, 1)], 1
    )
    conductance = 10 ** generator.uniform(-9, 0, link_ends.shape[1])
    residual = generator.standard_normal(points**2)
    residual -= residual.mean()
    corrections = []
    for factor in (1.0, 2.0**20):
        _, cycle = multigrid(Network(*link_ends, factor * conductance, points**2), positions)
        corrections.append(cycle(residual) * factor)
    np.testing.assert_allclose(
        corrections[1], corrections[0], rtol=1e-6, atol=1e-9 * np.abs(corrections[0]).max()
    )


def test_near_the_percolation_threshold_against_a_direct_solution():
    """Conductances over fifteen powers of ten, a single narrow place: the multigrid must not miss it."""
    gap = rough_gap(96, closed=0.41, seed=2)
    around = percolation_columns(gap)
    assert around["gap_percolates_x"] or around["gap_percolates_y"]
    columns = flow_columns(gap, SQUARE, tolerance=1e-7)
    region, winds = connected_regions(gap > 0)
    is_open = winds[region].any(axis=-1)
    number = np.cumsum(is_open).reshape(gap.shape) - 1
    cubed = np.where(is_open, gap / gap.mean(), 0) ** 3
    size = number.max() + 1
    forces, links = np.zeros((size, 2)), []
    for axis in (0, 1):
        ahead, target = np.roll(cubed, -1, axis), np.roll(number, -1, axis)
        linked = (cubed > 0) & (ahead > 0)
        c = 2 / (1 / cubed[linked] + 1 / ahead[linked])
        links.append((axis, number[linked], target[linked], c))
        forces[:, axis] += np.bincount(number[linked], c, size) - np.bincount(target[linked], c, size)
    weights = sum(sp.coo_array((c, (start, stop)), shape=(size, size)).tocsr() for _, start, stop, c in links)
    weights = weights + weights.T
    matrix = (sp.diags_array(weights.sum(axis=1)) - weights).tocsc()[1:, 1:]
    scale = sp.diags_array(1 / np.sqrt(matrix.diagonal()))
    factors = splu((scale @ matrix @ scale).tocsc())
    solution = np.zeros((size, 2))
    solution[1:] = scale @ factors.solve(scale @ forces[1:])
    for axis, name in ((0, "yy"), (1, "xx")):
        flux = 0.0
        for link_axis, start, stop, c in links:
            drop = solution[stop, axis] - solution[start, axis] + (link_axis == axis)
            flux += (c * drop**2).sum()
        reference = flux / gap.size
        if around[f"gap_percolates_{name[0]}"]:
            assert columns[f"flow_factor_{name}"] == pytest.approx(reference, rel=1e-4)
        else:
            assert columns[f"flow_factor_{name}"] == 0
            assert reference < 1e-12


def network_flow(network, uniform_drop, carried, *of_solver, **limits):
    """Return what `flow._driven_flow` does, by elimination of a network point by point without a subtraction.

    Grassmann, Taksar and Heyman (1985), Oper. Res. 33, 1107: each potential is exact to rounding.
    """
    links = np.zeros((network.size, network.size))
    for ends in ((network.start, network.stop), (network.stop, network.start)):
        np.add.at(links, ends, network.conductance)
    np.fill_diagonal(links, 0)
    force, potential = -network.inflow(network.conductance * uniform_drop), np.zeros(network.size)
    for last in range(network.size - 1, 0, -1):
        shares = links[last, :last] / max(links[last, :last].sum(), 1e-300)
        links[:last, :last] += np.outer(links[last, :last], shares)
        force[:last] += force[last] * shares
    for last in range(1, network.size):
        if total := links[last, :last].sum():
            potential[last] = (force[last] + links[last, :last] @ potential[:last]) / total
    drops = uniform_drop + potential[network.stop] - potential[network.start]
    return drops, float(carried @ drops)


@pytest.mark.parametrize(("steps", "factorised"), [(0, 2**20), (20, 0), (20, 2**20)])
@pytest.mark.parametrize(("closed", "power"), [(0.3, 1), (0.41, 1), (0.2, 2), (0.3, 2)])
def test_flow_of_steep_gaps_against_an_elimination(monkeypatch, closed, power, steps, factorised):
    """Conductances over up to thirty powers of ten, by factors, by aggregates, by both in turn."""
    monkeypatch.setattr(flow_module, "_FEW_STEPS", steps)
    monkeypatch.setattr(flow_module, "_MAX_FACTORISED", factorised)
    gap = rough_gap(32, closed=closed, seed=2) ** power
    columns = flow_columns(gap, SQUARE, tolerance=1e-9)
    monkeypatch.setattr(flow_module, "_driven_flow", network_flow)
    reference = flow_columns(gap, SQUARE)
    for name, value in columns.items():
        # as exact as `flow_columns` says
        accuracy = 2e-4 if name.startswith("shear") else 1e-6
        assert value == pytest.approx(reference[name], rel=1e-5, abs=accuracy), name


def test_tripps_factor_is_what_channels_along_and_across_let_through():
    """Half the waves along and half across, to second order: σ² = ε²/2 of each."""
    depth = 1e-3
    along, across = closed_forms.channel_flow_factors(depth)
    reference = closed_forms.isotropic_flow_factor(depth / np.sqrt(2))
    assert (along + across) / 2 - 1 == pytest.approx(reference - 1, rel=1e-5)


def test_effective_medium_of_two_phases():
    """Half of each conducts their geometric mean (Dykhne 1970), whatever the contrast; and it closes."""
    for high in (2.0, 1e4):
        gap = np.cbrt(np.where(np.arange(100) % 2, 1.0, high))[:, None]
        factor = closed_forms.effective_medium_flow_factor(gap) * gap.mean() ** 3
        assert factor == pytest.approx(np.sqrt(high), rel=1e-9)
    assert closed_forms.effective_medium_flow_factor(np.array([1.0, 0.0, 0.0])) == 0
    assert closed_forms.effective_medium_flow_factor(np.ones(5)) == pytest.approx(1)


def test_parallel_plates_and_nothing_at_all():
    plates = flow_columns(np.full((16, 12), 3e-7), (1e-6, 2e-6))
    assert plates["flow_factor_xx"] == pytest.approx(1, rel=1e-12)
    assert plates["flow_factor_yy"] == pytest.approx(1, rel=1e-12)
    assert abs(plates["flow_factor_xy"]) < 1e-12
    closed = flow_columns(np.zeros((8, 8)), SQUARE)
    assert {value for name, value in closed.items() if name.startswith("flow")} == {0.0}
    assert closed["shear_flow_x"] == closed["shear_flow_y"] == 1  # all moves with the rough face
    assert set(percolation_columns(np.zeros((8, 8))).values()) == {0}


def test_units_do_not_matter():
    gap = rough_gap(48, closed=0.2, seed=1)
    reference, scaled = flow_columns(gap, SQUARE), flow_columns(1e-9 * gap, (1e3, 1e3))
    assert scaled == pytest.approx(reference, rel=1e-9)


def test_a_gap_of_single_precision_has_the_same_flow():
    gap = rough_gap(64, closed=0.2)
    assert flow_columns(gap.astype(np.float32), SQUARE) == pytest.approx(flow_columns(gap, SQUARE), rel=1e-5)


def test_leak_rate_of_a_seal():
    """Poiseuille: a slit of width b lets b h³ Δp/(12 η w) through."""
    columns = leak_columns(
        np.array([2e-6]),
        {"flow_factor_xx": np.array([0.5]), "flow_factor_yy": np.array([0.0])},
        viscosity=1e-3,
        pressure_difference=4e5,
        width=5e-3,
    )
    assert columns["leak_rate_x"] == pytest.approx(0.5 * 8e-18 * 4e5 / (12 * 1e-3 * 5e-3))
    assert columns["leak_rate_y"] == 0


@pytest.fixture(scope="module")
def contact():
    height = self_affine((64, 64), 1e-6, (8e-6, 32e-6), rms_height=1e-7, seed=0)
    return rc.solve_contact(height, contact_modulus=1e9, mean_pressure=[1e6, 5e6, 3e7])


def test_sealing_in_the_statistics(contact):
    seal = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}
    stats = describe(rc.contact_statistics(contact, seal=seal))
    factors = stats["flow_factor_xx"].values
    assert (np.diff(factors) < 0).all()
    assert factors[-1] == stats["gap_percolates_x"][-1] == stats["critical_constriction_x"][-1] == 0
    expected = factors * stats["mean_gap"] ** 3 * 1e5 / (12 * 1e-3 * 1e-3)
    np.testing.assert_allclose(stats["leak_rate_x"], expected, rtol=1e-12)
    assert stats["leak_rate_x"].attrs["units"] == "m2 s-1"
    assert (stats["critical_constriction_x"] <= contact["gap"].max(("y", "x"))).all()


def test_the_flow_is_solved_for_where_that_is_asked_for(contact):
    assert "flow_factor_xx" not in rc.contact_statistics(contact, flow="never")
    assert "flow_factor_xx" not in rc.contact_statistics(contact)
    flat_map = height_map(np.zeros((300, 300)), 1e-6)
    flat = rc.solve_contact(flat_map, contact_modulus=1e9, mean_pressure=1e6)
    assert "flow_factor_xx" in rc.contact_statistics(flat, flow="always")
    seal = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}
    assert rc.contact_statistics(flat, seal=seal)["leak_rate_y"].item() == 0
    with pytest.raises(rc.SettingsError, match="did you mean 'always'"):
        rc.contact_statistics(contact, flow="alway")


def test_a_seal_in_the_settings():
    seal = {"viscosity": "20 mPa s", "pressure_difference": "200 bar", "width": "0.5 mm"}
    settings = resolve({"contact": {"contact_modulus": 1e9}, "statistics": {"seal": seal}})[""]
    stated = {key: value for key, value in settings["statistics"]["seal"].items() if value is not None}
    assert stated == pytest.approx({"viscosity": 0.02, "pressure_difference": 2e7, "width": 5e-4})


def test_a_gap_closes_near_42_percent_of_contact():
    """Isotropic self-affine surfaces: Dapp et al. (2012) find 0.42, Wang and Müser (2020) 0.415."""
    closing = []
    for seed in range(6):
        height = self_affine((128, 128), 1.0, (8.0, 32.0), rms_height=1e-3, seed=seed)

        def openness(load, height=height):
            solved = rc.solve_contact(height, contact_modulus=1.0, mean_pressure=load, tolerance=1e-3)
            touching = solved["pressure"].values[0] > 0
            openness.area = touching.mean()
            return 0.5 if any(percolates(~touching)) else -0.5

        brentq(openness, 1e-5, 1e-2, xtol=1e-6)
        closing.append(openness.area)
    assert np.mean(closing) == pytest.approx(0.42, abs=0.04)


def test_where_rounding_stops_the_iteration_there_is_no_flow_factor():
    """Gaps of 1e-8 of the others, which rounding leaves in contact, ask for steps that it swallows."""
    contact = rc.solve_contact(
        rough_reference_surface(128), contact_modulus=1.0, mean_pressure=0.1, tolerance=1e-6
    )
    gap, pressure = (contact[name].values[0] for name in ("gap", "pressure"))
    clean, noisy = (
        flow_columns(values / gap.mean(), (1.0, 1.0), tolerance=1e-7)
        for values in (np.where(pressure > 0, 0.0, gap), gap)
    )
    for name in ("flow_factor_xx", "flow_factor_yy"):
        assert clean[name] > 0
        assert np.isnan(noisy[name]) or noisy[name] == pytest.approx(clean[name], rel=1e-4), name


@pytest.mark.cases
def test_a_fluid_that_lifts_the_seal_or_is_a_gas_is_named(viscosity, difference, doubted, words):
    seal = {"viscosity": viscosity, "pressure_difference": difference, "width": 1e-3}
    height = self_affine((64, 64), 1e-6, (8e-6, 32e-6), rms_height=1e-7, seed=0)
    contact = {"contact_modulus": 1e9, "mean_pressure": [1e6, 5e6, 2e7]}
    statistics = rc.evaluate(height, contact=contact, statistics={"seal": seal}, uncertainty={"sources": []})
    reasons = [reason for reason in json.loads(statistics.attrs["reasons"]) if reason["check"] == "Fluid"]
    assert [load for reason in reasons for load in reason["loads"]] == doubted
    assert words in "".join(reason["text"] for reason in reasons)
    lifted = statistics["mean_pressure"].values < difference
    assert (statistics["verdict"].values[lifted] >= 1).all()
    assert (statistics["sealing_verdict"].values[doubted] >= 1).all()
    if viscosity < 1e-4:  # the contact of a gas's seal is what it is
        flags_elsewhere = [
            json.loads(statistics.attrs["verdicts"])[load][1] for load in np.flatnonzero(~lifted)
        ]
        assert all(any("viscosity of a gas" in text for text in flags) for flags in flags_elsewhere)


def test_a_solution_reduced_to_its_statistics_keeps_the_fluid():
    fluid = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}
    problem = {"contact_modulus": 1e9, "mean_pressure": [1e6, 1e7]}
    statistics = rc.solve_contact(
        rough_reference_surface(48),
        **problem,
        reduce=lambda contact: rc.contact_statistics(contact, seal=fluid),
    )
    assert {key: statistics.attrs[f"seal_{key}"] for key in fluid} == fluid
    assert statistics.attrs["tolerance"] == 1e-4
