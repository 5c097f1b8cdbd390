"""Statistics of hand-made contacts and of closed-form solutions fed in as if the solver had made them."""

from collections import deque

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad

from roughcontact.arguments.named_materials import material
from roughcontact.contact.flash_temperature import flash_temperature
from roughcontact.contact.solve import solve_contact
from roughcontact.errors import SettingsError
from roughcontact.results.storage import opened_dataset, read_dataset, write_dataset
from roughcontact.statistics import contact_geometry
from roughcontact.statistics.contact_statistics import (
    contact_statistics,
    statistics_function,
    with_uncertainty,
)
from roughcontact.statistics.sealing.connectivity import region_sizes
from roughcontact.surface.synthetic import rough_reference_surface
from validation import closed_forms
from validation.surfaces import product_wave_surface

C = (np.pi - 1 + np.log(2)) / 24
D, WAVELENGTH, MODULUS = 1.5e-6, 2e-3, 3e9
FULL = closed_forms.westergaard_full_contact_pressure(D, WAVELENGTH, MODULUS)


def solution(pressure, gap, height, steps, *, modulus=MODULUS):
    """Return fields of one or more loads as a contact dataset."""
    dy, dx = steps
    ny, nx = height.shape
    return xr.Dataset(
        {
            "pressure": (("load", "y", "x"), pressure),
            "gap": (("load", "y", "x"), gap),
            "height": (("y", "x"), height),
            "contact_modulus": modulus,
        },
        coords={
            "mean_pressure": ("load", pressure.mean(axis=(1, 2))),
            "y": np.arange(ny) * dy,
            "x": np.arange(nx) * dx,
        },
        attrs={"tolerance": 1e-4, "zero_frequency": "zero"},
    )


def westergaard(ratios, *, rows, points=1024):
    """Return Westergaard's solution, crests between the points, rows of it side by side."""
    x = (np.arange(points) + 0.5) * WAVELENGTH / points
    pressure = [closed_forms.westergaard_pressure(x, WAVELENGTH, r * FULL, r) for r in ratios]
    gap = [closed_forms.westergaard_gap(x, WAVELENGTH, D, min(r, 1.0)) for r in ratios]
    fields = (np.repeat(np.array(field)[:, None], rows, axis=1) for field in (pressure, gap))
    height = np.tile(D * np.cos(2 * np.pi * x / WAVELENGTH), (rows, 1))
    return solution(*fields, height, (3e-6, WAVELENGTH / points))


def disc(points, radius, steps, centre=(0.37, 0.11)):
    """Return where the cell centres lie inside a disc, in a period just large enough."""
    dy, dx = steps
    y, x = ((np.arange(n) - n // 2 + c) * d for n, c, d in zip(points, centre, (dy, dx), strict=True))
    return np.hypot(*np.meshgrid(y, x, indexing="ij")) < radius


# --- area and perimeter ------------------------------------------------------------------------------------


@pytest.mark.parametrize("shift", [0, 9])
def test_corrected_area_of_a_square_wherever_it_lies(shift):
    touching = np.zeros((10, 12), bool)
    touching[2:5, 3:6] = True
    touching = np.roll(touching, (shift, shift), (0, 1))
    assert contact_geometry.count_switches(touching) == (6, 6)
    assert contact_geometry.relative_contact_area(touching) == pytest.approx((9 - 12 * C) / 120, rel=1e-14)


def test_corrected_area_of_everything_and_of_one_column():
    assert contact_geometry.relative_contact_area(np.ones((5, 7), bool)) == 1.0
    column = np.zeros((5, 7), bool)
    column[:, 2] = True
    assert contact_geometry.relative_contact_area(column) == pytest.approx((5 - 10 * C) / 35, rel=1e-14)


def test_corrected_area_of_a_profile_is_that_of_many_equal_rows():
    row = np.random.default_rng(0).random((1, 60)) < 0.4
    extruded = np.repeat(row, 5, axis=0)
    assert contact_geometry.relative_contact_area(row) == pytest.approx(
        contact_geometry.relative_contact_area(extruded)
    )


@pytest.mark.parametrize("steps", [(1.0, 1.0), (1.0, 0.4), (0.25, 1.0)])
def test_disc(steps):
    radius = 60.0
    points = tuple(int(2 * radius / d) + 9 for d in steps)
    touching = disc(points, radius, steps)
    area = contact_geometry.relative_contact_area(touching) * points[0] * points[1] * steps[0] * steps[1]
    # the rows and columns through a disc number 2 r/dy and 2 r/dx, with two switches each
    switches = 4 * radius / steps[0] + 4 * radius / steps[1]
    assert sum(contact_geometry.count_switches(touching)) == pytest.approx(switches, rel=0.02)
    expected = np.pi * radius**2 - C * switches * steps[0] * steps[1]
    assert area == pytest.approx(expected, rel=1e-3)
    assert area == pytest.approx(np.pi * radius**2, rel=6e-3)
    assert contact_geometry.contact_perimeter(touching, steps) == pytest.approx(2 * np.pi * radius, rel=0.02)


def test_perimeter_of_an_ellipse_and_of_lines():
    steps = (0.5, 1.0)
    # stretching x by three makes an ellipse of a disc
    touching = disc((500, 400), 100.0, (0.5, 1 / 1.5), centre=(0.2, 0.4))
    circumference = quad(lambda t: np.hypot(150 * np.sin(t), 100 * np.cos(t)), 0, 2 * np.pi)[0]
    assert contact_geometry.contact_perimeter(touching, steps) == pytest.approx(circumference, rel=0.01)
    ridges = np.zeros((40, 30), bool)
    ridges[:, 3:7] = True
    assert contact_geometry.contact_perimeter(ridges, steps) == pytest.approx(2 * 40 * 0.5, rel=1e-14)
    assert contact_geometry.contact_perimeter(ridges.T, steps) == pytest.approx(2 * 40 * 1.0, rel=1e-14)
    diagonal = (np.add.outer(np.arange(40), np.arange(40)) % 40) < 10
    assert contact_geometry.contact_perimeter(diagonal, (1.0, 1.0)) == pytest.approx(
        2 * 40 * np.sqrt(2) * np.pi / (2 * np.sqrt(2)), rel=1e-12
    )
    assert contact_geometry.contact_perimeter(np.ones((4, 4), bool), steps) == 0.0


def test_perimeter_does_not_depend_on_how_often_a_map_is_repeated():
    touching = np.random.default_rng(5).random((24, 18)) < 0.3
    perimeter = contact_geometry.contact_perimeter(touching, (1.0, 0.7))
    assert contact_geometry.contact_perimeter(np.tile(touching, (2, 3)), (1.0, 0.7)) == pytest.approx(
        6 * perimeter, rel=1e-13
    )


# --- clusters ----------------------------------------------------------------------------------------------


def flood(touching):
    """Count the patches by walking, the period included: slow and plain."""
    unvisited = set(zip(*np.nonzero(touching), strict=True))
    ny, nx = touching.shape
    patches = 0
    while unvisited:
        patches += 1
        queue = deque([unvisited.pop()])
        while queue:
            i, j = queue.popleft()
            for near in (((i + 1) % ny, j), ((i - 1) % ny, j), (i, (j + 1) % nx), (i, (j - 1) % nx)):
                if near in unvisited:
                    unvisited.remove(near)
                    queue.append(near)
    return patches


@pytest.mark.cases
def test_clusters_of_hand_made_masks(rows, patches):
    touching = np.array([[cell == "#" for cell in row] for row in rows])
    assert region_sizes(touching).size == patches
    assert region_sizes(touching.T).size == patches


@pytest.mark.parametrize("seed", range(20))
def test_clusters_against_a_walk_and_under_shifts(seed):
    rng = np.random.default_rng(seed)
    touching = rng.random(rng.integers(1, 14, 2)) < rng.uniform(0.2, 0.7)
    patches = flood(touching)
    assert region_sizes(touching).size == patches
    assert region_sizes(np.roll(touching, (3, 5), (0, 1))).size == patches


# --- closed forms fed in -----------------------------------------------------------------------------------


@pytest.mark.parametrize("rows", [1, 4])
def test_westergaard_all_numbers(rows):
    points = (
        8192  # sampling the edge, where the pressure rises like a square root, costs (points in contact)^-1.5
    )
    ratios = np.array([0.05, 0.4, 0.9])
    stats = contact_statistics(westergaard(ratios, rows=rows, points=points))
    share = np.array([closed_forms.westergaard_contact_share(r) for r in ratios])
    length = rows * 3e-6 if rows > 1 else np.nan  # a profile is as wide as one likes

    np.testing.assert_allclose(stats["relative_contact_area_pixels"], share, atol=1.01 / points)
    np.testing.assert_allclose(
        stats["relative_contact_area"], stats["relative_contact_area_pixels"] - 2 * C / points, rtol=1e-13
    )
    np.testing.assert_allclose(stats["contact_perimeter"], 2 * length, rtol=1e-12)
    np.testing.assert_array_equal(stats["contact_clusters"], 1)
    np.testing.assert_allclose(stats["mean_pressure"], ratios * FULL, rtol=5e-5)
    np.testing.assert_allclose(stats["mean_contact_pressure"], ratios * FULL / share, rtol=1e-3)
    np.testing.assert_allclose(stats["max_pressure"], 2 * FULL * np.sqrt(ratios), rtol=2e-6)
    np.testing.assert_allclose(stats["mean_gap"], closed_forms.westergaard_mean_gap(D, ratios), rtol=1e-6)
    energy = [closed_forms.westergaard_energy(D, WAVELENGTH, MODULUS, r) for r in ratios]
    np.testing.assert_allclose(stats["elastic_energy"], energy, rtol=2e-4)
    stiffness = [closed_forms.westergaard_stiffness(D, WAVELENGTH, MODULUS, r) for r in ratios]
    np.testing.assert_allclose(stats["contact_stiffness"], stiffness, rtol=2e-3)

    for ratio, std, mean in zip(ratios, stats["pressure_std"], stats["mean_contact_pressure"], strict=True):
        half = closed_forms.westergaard_contact_share(ratio) * WAVELENGTH / 2
        square = quad(
            lambda x, r=ratio: closed_forms.westergaard_pressure(x, WAVELENGTH, r * FULL, r) ** 2, 0, half
        )
        expected = np.sqrt(square[0] / half - float(mean) ** 2)
        assert float(std) == pytest.approx(expected, rel=2e-3)

    assert float(stats["rms_height"]) == pytest.approx(D / np.sqrt(2), rel=1e-12)
    gradient = np.sqrt(2) * np.pi * D / WAVELENGTH
    assert float(stats["rms_gradient"]) == pytest.approx(gradient, rel=1e-12)
    np.testing.assert_allclose(
        stats["relative_pressure"], stats["mean_pressure"] / (MODULUS * gradient), rtol=1e-12
    )
    assert float(stats["window_length_x"]) == pytest.approx(WAVELENGTH, rel=1e-12)
    assert float(stats["window_length_y"]) == pytest.approx(length, rel=1e-12, nan_ok=True)
    np.testing.assert_allclose(stats["points_per_shortest_wavelength"], points)


def test_westergaard_pressure_distribution():
    """Half the contact has a pressure above that at half of the half width, and so on."""
    ratio = 0.5
    stats = contact_statistics(westergaard([ratio], rows=1, points=1 << 15))
    bounds = stats["pressure_bin_bounds"].values
    below = np.cumsum(stats["pressure_density"].values[0] * np.diff(bounds).ravel())
    half = closed_forms.westergaard_contact_share(ratio) * WAVELENGTH / 2
    x = np.linspace(0, half, 200001)
    pressure = closed_forms.westergaard_pressure(x, WAVELENGTH, ratio * FULL, ratio)  # falls from the crest
    for share, bound in zip(below, bounds[:, 1], strict=True):
        position = np.interp(-bound, -pressure, x) if bound < pressure[0] else 0.0
        assert share == pytest.approx(1 - position / half, abs=3e-4)


def test_densities_are_whole_whatever_the_pressures():
    rng = np.random.default_rng(1)
    pressure = np.exp(rng.normal(0, 12, (3, 16, 16))) * (rng.random((3, 16, 16)) < 0.6)
    gap = np.where(pressure > 0, 0.0, rng.random(pressure.shape) * 1e-6)
    height = rng.standard_normal((16, 16)) * 1e-6
    stats = contact_statistics(solution(pressure, gap, height, (1e-6, 2e-6)), pressure_bins=7, gap_bins=3)
    for name in ("pressure", "gap"):
        bounds = stats[f"{name}_bin_bounds"].values
        assert bounds[0, 0] == 0.0
        np.testing.assert_array_equal(bounds[1:, 0], bounds[:-1, 1])
        integral = (stats[f"{name}_density"].values * np.diff(bounds).ravel()).sum(axis=1)
        np.testing.assert_allclose(integral, 1.0, rtol=1e-13)
        np.testing.assert_allclose(stats[f"{name}_bin_centre"], bounds.mean(axis=1))
    assert stats.sizes["pressure_bin"] == 6 * 7 + 1
    assert stats.sizes["gap_bin"] == 4 * 3 + 1


def test_the_bins_are_scaled_by_the_surface():
    """Pressures to 1000 E* g, gaps to the peak-to-valley height, whatever the loads."""
    height = rough_reference_surface(36).values * 3e-6
    pressure = np.zeros((1, 36, 36))
    pressure[0, 3:6, 3:6] = 1e5
    stats = contact_statistics(solution(pressure, np.ones_like(pressure), height, (2e-6, 1e-6)))
    pressures, gaps = (stats[f"{name}_bin_bounds"].values for name in ("pressure", "gap"))
    scale = MODULUS * float(stats["rms_gradient"])
    np.testing.assert_allclose(pressures[[0, -1], 1], [1e-3 * scale, 1e3 * scale], rtol=1e-13)
    valley = height.max() - height.min()
    np.testing.assert_allclose(gaps[[0, -1], 1], [1e-4 * valley, valley], rtol=1e-13)


def test_the_bins_of_a_flat_map_are_scaled_by_modulus_and_pitch():
    fields = np.full((1, 4, 6), 2e6)
    stats = contact_statistics(solution(fields, 0 * fields, np.zeros((4, 6)), (7e-6, 3e-6)))
    assert stats["pressure_bin_bounds"].values[-1, 1] == pytest.approx(1e3 * MODULUS, rel=1e-13)
    assert stats["gap_bin_bounds"].values[-1, 1] == pytest.approx(3e-6, rel=1e-13, abs=0)


def test_gaps_are_counted_where_nothing_touches():
    """Half of the open points have a gap in one bin, half in another; what is left in contact is rounding."""
    height = np.array([[0.0, -1e-6, -0.5e-6, 0.0]])
    pressure, gap = np.array([[[4e6, 0.0, 0.0, 2e6]]]), np.array([[[1e-9, 4e-7, 8e-7, 1e-9]]])
    stats = contact_statistics(solution(pressure, gap, height, (1e-6, 1e-6)), gap_bins=1)
    bounds = stats["gap_bin_bounds"].values
    shares = stats["gap_density"].values[0] * np.diff(bounds).ravel()
    np.testing.assert_allclose(shares, [0, 0, 0, 0, 1.0], atol=1e-15)
    assert stats["mean_gap"].item() == pytest.approx(3e-7, rel=1e-14, abs=0)
    assert stats["mean_contact_pressure"].item() == 3e6
    assert stats["pressure_std"].item() == 1e6
    assert stats["relative_contact_area_pixels"].item() == 0.5


def test_any_positive_pressure_is_contact_and_none_is_not():
    height = np.array([[0.0, -1e-6, -1e-6, -1e-6]])
    pressure = np.array([[[1e6, 1e-300, 0.0, 0.0]]])
    stats = contact_statistics(solution(pressure, np.zeros_like(pressure), height, (1e-6, 1e-6)))
    assert stats["relative_contact_area_pixels"].item() == 0.5


def test_isolated_points_keep_more_than_half_of_their_area():
    """Four switches is the most that a point can have: the corrected area never reaches zero."""
    board = (np.add.outer(np.arange(8), np.arange(6)) % 2) == 0
    assert contact_geometry.count_switches(board) == (48, 48)
    expected = 0.5 * (1 - 4 * C)
    assert contact_geometry.relative_contact_area(board) == pytest.approx(expected, rel=1e-14)
    assert contact_geometry.relative_contact_area(board) > 0.26


def test_full_contact_of_a_rough_map():
    height = rough_reference_surface(64).values * 1e-4
    steps = (1e-3, 2e-3)
    fluctuation = closed_forms.full_contact_fluctuation(height, steps, MODULUS)
    mean = -1.5 * fluctuation.min()
    stats = contact_statistics(solution((mean + fluctuation)[None], np.zeros((1, 64, 64)), height, steps))
    gradient = float(stats["rms_gradient"])
    assert stats["relative_contact_area"].item() == 1.0
    assert stats["contact_stiffness"].item() == np.inf
    assert stats["contact_perimeter"].item() == 0.0
    assert stats["contact_clusters"].item() == 1
    assert stats["pressure_std"].item() == pytest.approx(MODULUS * gradient / 2, rel=1e-12)
    energy = closed_forms.full_contact_energy(height, steps, MODULUS)
    assert stats["elastic_energy"].item() == pytest.approx(energy, rel=1e-12)
    assert np.isnan(stats["gap_density"]).all()


@pytest.mark.parametrize("shape", [(8, 8), (7, 5), (1, 9)])
def test_flat_map(shape):
    fields = np.full((2, *shape), 2e6)
    fields[1] *= 3
    stats = contact_statistics(solution(fields, np.zeros_like(fields), np.full(shape, 0.3), (1e-6, 1e-6)))
    assert float(stats["rms_gradient"]) == 0.0
    np.testing.assert_array_equal(stats["relative_pressure"], np.inf)
    np.testing.assert_array_equal(stats["relative_contact_area"], 1.0)
    np.testing.assert_array_equal(stats["elastic_energy"], 0.0)
    np.testing.assert_array_equal(stats["pressure_std"], 0.0)
    np.testing.assert_array_equal(stats["area_persson"], 1.0)
    assert np.isnan(stats["area_greenwood_williamson"]).all()
    assert np.isnan(stats["points_per_shortest_wavelength"]).all()


# --- the dataset -------------------------------------------------------------------------------------------


def test_bins_and_numbers_do_not_depend_on_the_other_loads():
    contact = westergaard([0.1, 0.6, 1.4], rows=2, points=128)
    statistics_of_all = contact_statistics(contact)
    for index in range(3):
        xr.testing.assert_identical(
            contact_statistics(contact.isel(load=[index])), statistics_of_all.isel(load=[index])
        )


def test_relative_numbers_do_not_depend_on_the_units():
    contact = westergaard([0.1, 0.6], rows=3, points=128)
    metre, pascal = 2.0**20, 2.0**-20  # about micrometres and megapascals; rounding stays as it is
    scaled = solution(
        contact["pressure"].values * pascal,
        contact["gap"].values * metre,
        contact["height"].values * metre,
        (3e-6 * metre, WAVELENGTH / 128 * metre),
        modulus=MODULUS * pascal,
    )
    reference, scaled_statistics = contact_statistics(contact), contact_statistics(scaled)
    powers = {"m": metre, "Pa": pascal, "m-1": 1 / metre, "Pa-1": 1 / pascal, "1": 1.0, "degree": 1.0}
    powers |= {"m2": metre**2, "m-2": metre**-2, "Pa m-1": pascal / metre, "J m-2": pascal * metre}
    for name, variable in reference.data_vars.items():
        np.testing.assert_allclose(
            scaled_statistics[name], variable * powers[variable.attrs["units"]], rtol=1e-9, err_msg=name
        )


def test_solver_columns_are_handed_on_and_everything_is_described():
    contact = westergaard([0.1, 0.6], rows=2, points=64)
    contact["iterations"] = ("load", [4, 7])
    contact["error_bound"] = ("load", [1e-5, 2e-6])
    contact["converged"] = ("load", np.array([1, 0], np.int8))
    stats = contact_statistics(contact)
    for name in ("iterations", "error_bound", "converged"):
        np.testing.assert_array_equal(stats[name], contact[name])
    assert stats.attrs == contact.attrs
    bounds = {f"{kind}_bin_bounds" for kind in ("pressure", "gap", "patch")}
    assert {"units", "long_name"} <= set.intersection(
        *(set(stats[name].attrs) for name in stats.variables if name not in bounds)
    )
    assert not {"y", "x"} & set(stats.dims)
    assert stats["pressure_bin_centre"].attrs["bounds"] == "pressure_bin_bounds"


def test_the_window_has_its_size_and_its_place():
    contact = westergaard([0.3], rows=4, points=64)
    contact["height"].attrs |= {"window_offset_x": 5e-6, "window_offset_y": 7e-6}
    stats = contact_statistics(contact)
    assert stats["window_length_x"].item() == pytest.approx(WAVELENGTH, rel=1e-12)
    assert stats["window_length_y"].item() == pytest.approx(4 * 3e-6, rel=1e-12)
    assert (stats["window_offset_x"].item(), stats["window_offset_y"].item()) == (5e-6, 7e-6)


@pytest.mark.parametrize("turned", [False, True])
def test_theories_of_asperities_say_nothing_of_a_profile(turned):
    contact = westergaard([0.1], rows=1, points=128)
    if turned:
        contact = contact.rename(y="x", x="y").transpose("load", "y", "x")
    stats = contact_statistics(contact)
    assert np.isnan(stats["area_bush_gibson_thomas"]).all()
    assert np.isnan(stats["area_greenwood_williamson"]).all()
    assert np.isfinite(stats["area_persson"]).all()


def test_contact_on_filled_points():
    contact = westergaard([0.3], rows=4, points=64)
    assert contact_statistics(contact)["contact_on_filled_points"].item() == 0.0
    filled = np.zeros((4, 64), np.int8)
    filled[0] = 1
    marked = contact.assign_coords(filled=(("y", "x"), filled))
    assert contact_statistics(marked)["contact_on_filled_points"].item() == 0.25


@pytest.mark.parametrize("bins", [0, -3, 2.5])
@pytest.mark.parametrize("name", ["pressure_bins", "gap_bins"])
def test_number_of_bins_is_checked(name, bins):
    with pytest.raises(SettingsError, match=rf"{name} = {bins}"):
        contact_statistics(westergaard([0.3], rows=1, points=16), **{name: bins})


# --- with the solver ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [0.1, 0.5])
def test_corrected_area_of_the_product_wave_is_nearer_than_the_pixels(ratio):
    points = 128
    wave = product_wave_surface((points, points), 1 / points, amplitude=0.01, wavelength=1.0)
    # crests half a cell off the points: no accident of the grid
    middle = np.roll(wave.values, 1, 1) / 2 + wave.values / 2
    wave = wave.copy(data=middle / middle.max() * 0.01)
    full = closed_forms.jgh_full_contact_pressure(0.01, 1.0, 1.0)
    stats = solve_contact(
        wave, contact_modulus=1.0, mean_pressure=ratio * full, tolerance=1e-6, reduce=contact_statistics
    )
    truth = closed_forms.JGH_CONTACT_SHARE[ratio]
    corrected = abs(stats["relative_contact_area"].item() - truth)
    raw = abs(stats["relative_contact_area_pixels"].item() - truth)
    assert corrected < 2e-3
    assert corrected < raw / 3
    peak, gap = closed_forms.JGH_PEAK_AND_GAP[ratio]
    assert stats["max_pressure"].item() / (ratio * full) == pytest.approx(peak, rel=5e-3)
    assert stats["mean_gap"].item() / 0.01 == pytest.approx(gap, rel=2e-3)


def test_statistics_while_solving_are_those_of_the_kept_fields():
    wave = rough_reference_surface(64)
    arguments = {"contact_modulus": 1.0, "mean_pressure": [0.05, 0.2]}
    reference = contact_statistics(solve_contact(wave, **arguments))
    once = statistics_function(wave, contact_modulus=1.0)  # the surface counted once for all loads
    for count in (contact_statistics, once):
        reduced = solve_contact(wave, **arguments, reduce=count)
        assert set(reduced.variables) == set(reference.variables) - {
            "pressure",
            "gap",
            "contact",
            "height",
            "x",
            "y",
        }
        for name in reduced.variables:
            np.testing.assert_array_equal(reduced[name].values, reference[name].values, err_msg=name)


@pytest.mark.parametrize("precision", ["single", "double"])
def test_heights_in_single_precision_have_the_same_statistics(precision):
    wave = rough_reference_surface(64)
    arguments = {"contact_modulus": 1.0, "mean_pressure": [0.05, 0.2]}
    expected = contact_statistics(solve_contact(wave, **arguments))
    stats = contact_statistics(solve_contact(wave.astype(np.float32), **arguments, precision=precision))
    for name in ("relative_contact_area", "mean_gap", "rms_gradient", "area_greenwood_williamson"):
        np.testing.assert_allclose(stats[name], expected[name], rtol=1e-3, err_msg=name)


def test_a_load_selected_without_its_dimension_is_refused_with_the_way_out():
    contact = solve_contact(rough_reference_surface(64), contact_modulus=1.0, mean_pressure=[0.05, 0.2])
    area = contact_statistics(contact)["relative_contact_area"].values
    assert contact_statistics(contact.isel(load=[1]))["relative_contact_area"].values == area[1]
    with pytest.raises(SettingsError, match=r"no dimension load.*isel\(load=\[0\]\)"):
        contact_statistics(contact.isel(load=1))


def test_a_transposed_solution_is_refused():
    contact = solve_contact(rough_reference_surface(64), contact_modulus=1.0, mean_pressure=0.1)
    turned = contact.transpose("load", "x", "y").copy(deep=True)
    with pytest.raises(SettingsError, match="the pressure has the dimensions"):
        contact_statistics(turned)
    with pytest.raises(SettingsError, match="the pressure has the dimensions"):
        flash_temperature(turned, friction_coefficient=0.2, speed=1.0, thermal_conductivity=[50, 50])


def test_options_of_the_statistics_by_name_and_with_their_keys():
    contact = solve_contact(rough_reference_surface(64), contact_modulus=1e9, mean_pressure=[5e7, 2e8])
    bodies = [material("steel"), material("aluminium")]
    expected = contact_statistics(contact, bodies=bodies)["thermal_conductance"].values
    named = contact_statistics(contact, bodies=["steel", {"material": "aluminium"}])
    np.testing.assert_array_equal(named["thermal_conductance"], expected)
    seal = {"viscosity": 1e-3, "pressure_difference": 1e5}
    for section, options, words in (
        ("seal", seal, "seal has viscosity, pressure_difference: takes .*; needs width"),
        ("seal", seal | {"length": 1e-2, "width": 1e-2}, "seal has .*length"),
        ("friction", {"friction_coefficient": 0.2}, "friction has friction_coefficient: takes coefficient, "),
        ("friction", {"coefficient": 0.2}, "friction: has no result; add tangential_load, shear_strength or"),
        ("friction", {"speed": 1.0}, "friction.speed: needs the coefficient or shear_strength"),
        ("friction", {"tangential_load": [0.5]}, "friction.tangential_load: needs the coefficient"),
    ):
        with pytest.raises(SettingsError, match=words):
            contact_statistics(contact, **{section: options})


def test_full_contact_leaves_no_gap_at_all():
    wave = rough_reference_surface(64)
    stats = solve_contact(wave, contact_modulus=1.0, mean_pressure=10.0, reduce=contact_statistics)
    assert stats["relative_contact_area"].item() == 1
    assert stats["mean_gap"].item() == 0


def test_an_open_file_is_counted_load_by_load(tmp_path):
    loads = [0.01, 0.02, 0.05]
    contact = solve_contact(rough_reference_surface(96), contact_modulus=1.0, mean_pressure=loads)
    write_dataset(contact, tmp_path / "contact.nc")
    with opened_dataset(tmp_path / "contact.nc") as file:
        counted = contact_statistics(file)
        assert file["pressure"].encoding["chunksizes"][0] == 1
        for name in ("pressure", "gap"):  # never all loads at once
            assert not file[name].variable._in_memory
        xr.testing.assert_identical(counted.load(), contact_statistics(read_dataset(tmp_path / "contact.nc")))


# --- what is asked for, and in which unit -------------------------------------------------------------------


def test_patches_of_oblong_pixels_are_counted_by_their_area():
    touching = np.zeros((8, 9), bool)
    touching[1:3, 1:4] = touching[5, 5] = True
    pressure, steps = np.where(touching, 2e6, 0.0)[None], (2e-6, 5e-6)
    gap = np.where(touching, 0.0, 1e-7)[None]
    statistics = contact_statistics(solution(pressure, gap, -gap[0], steps), flow="never")
    assert statistics["contact_clusters"].item() == 2
    assert statistics["largest_patch_area"].item() == pytest.approx(6e-11)
    assert np.unique(statistics["patch_bin_bounds"])[1] == pytest.approx(1e-11)
    assert statistics.sizes["patch_bin"] == 46  # five per factor of ten of one pixel to 1e9, and what is less


@pytest.mark.cases
def test_the_flow_is_solved_for_seals_and_where_asked_for(flow, seal, has_flow):
    pressure = np.zeros((1, 8, 9))
    pressure[0, 3, 4] = 1e6
    gap = np.where(pressure > 0, 0.0, 1e-7)
    statistics = contact_statistics(solution(pressure, gap, -gap[0], (1e-6, 1e-6)), flow=flow, seal=seal)
    assert ("flow_factor_xx" in statistics) is has_flow


OF_CONDUCTANCE = {"lower": 1.0, "upper": 2.5}


def test_an_interval_of_the_conductance_needs_that_of_the_stiffness():
    loads = {"mean_pressure": ("load", [1e6])}
    numbers = {"conductance_per_conductivity": ("load", [2e5]), "thermal_conductance": ("load", [6e6])}
    statistics = xr.Dataset(numbers, coords=loads)
    without_bounds = with_uncertainty(statistics, xr.Dataset(coords=loads))
    assert set(without_bounds.data_vars) == set(numbers)
    bounds = {
        f"conductance_per_conductivity_{side}": ("load", [1e5 * x]) for side, x in OF_CONDUCTANCE.items()
    }
    result = with_uncertainty(statistics, xr.Dataset(bounds, coords=loads))
    thermal_names = {
        f"thermal_{quantity}_{side}" for quantity in ("conductance", "resistance") for side in OF_CONDUCTANCE
    }
    assert set(result.data_vars) == {*numbers, *bounds, *thermal_names}
    assert result["thermal_conductance_upper"].item() == pytest.approx(7.5e6)
    assert result["thermal_resistance_lower"].item() == pytest.approx(1 / 7.5e6)
