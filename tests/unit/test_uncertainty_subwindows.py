"""The subwindows of a map: where they lie, what their scatter tells, what is said where it tells little."""

import numpy as np
import pytest
from known_surfaces import GRADIENT, contact, self_affine, surface

from roughcontact import SettingsError, height_map, level, periodic_window
from roughcontact.surface.roughness.texture import texture_parameters
from roughcontact.uncertainty import subwindows
from roughcontact.uncertainty.ensemble import Result, solve_member
from roughcontact.uncertainty.scales import AREA, CONSTRICTIONS, GAP, PEAK, to_scale
from roughcontact.uncertainty.subwindows import divided, scatter_of_subwindows

NAMES = (AREA, GAP, PEAK, *CONSTRICTIONS)


def crop(master, points, number):
    """Return one of the squares of a master that lie side by side, levelled."""
    row, column = (points * n for n in divmod(number, master.shape[1] // points))
    return level(height_map(master.values[row : row + points, column : column + points], 1.0))


def scattered(levelled, problem, **options):
    """Return the results of a map's window, and the scatter of its subwindows."""
    arguments = options.pop("arguments", {})
    window = periodic_window(levelled, **arguments)
    values = solve_member(window, problem, tolerance=1e-3, names=NAMES)
    result = Result(window, problem, values)
    return values, scatter_of_subwindows(result, levelled, arguments=arguments, **options)


def flag(levelled):
    """Return what the subwindows of a map do not tell."""
    aspect = texture_parameters(periodic_window(levelled))["Str"]
    _, scatter = scattered(levelled, contact(0.1))
    return subwindows.sample_attributes(scatter, levelled, aspect=aspect)["window_flag"]


def test_subwindows_lie_side_by_side_in_the_window():
    levelled = crop(surface(256, longest=32.0), 128, 1)
    window = periodic_window(levelled)
    _, scatter = scattered(levelled, contact(0.1))
    covered = np.zeros(levelled.shape, dtype=int)
    for part in scatter.slices:
        covered[part["y"], part["x"]] += 1
    y, x = (round(window.attrs[f"window_offset_{d}"]) for d in "yx")
    assert (covered[y : y + 108, x : x + 108] == 1).all()
    assert covered.sum() == 108**2


@pytest.mark.cases
def test_the_cut_is_square_and_no_part_too_small(sides, step, number, shortest, cut):
    parts = divided({"y": slice(0, sides[0]), "x": slice(0, sides[1])}, step, number, shortest)
    assert (len({part["y"].start for part in parts}), len({part["x"].start for part in parts})) == cut


def test_each_subwindow_is_solved_as_if_it_had_been_measured_alone():
    levelled, problem = crop(surface(256, longest=32.0), 128, 2), contact(0.05, 0.2)
    _, scatter = scattered(levelled, problem)
    for index in (0, 4):
        cut = level(levelled.isel(scatter.slices[index]), form="plane")
        reference = solve_member(periodic_window(cut), problem, tolerance=1e-4, names=NAMES)
        for name in (AREA, GAP):
            np.testing.assert_allclose(scatter.members[name][index], reference[name], rtol=0.02)


def test_scatter_and_trend_are_those_of_the_members_on_the_scale():
    values, scatter = scattered(crop(surface(256, longest=64.0), 128, 0), contact(0.02, 0.1))
    deviations = {
        name: to_scale(name, scatter.members[name]) - to_scale(name, values[name]) for name in (AREA, PEAK)
    }
    spread = np.hypot(deviations[AREA].std(axis=0, ddof=1), 0.02)
    trend = deviations[PEAK].mean(axis=0)
    for name in (AREA, GAP, PEAK):  # the scatter of the area counts for all
        np.testing.assert_allclose(scatter.features[name]["scatter"], np.log(spread), rtol=1e-6)
    np.testing.assert_allclose(scatter.features[PEAK]["trend"], trend, rtol=1e-6)
    assert "trend" not in scatter.features[GAP]


def test_copies_of_a_tile_do_not_scatter():
    tile = surface(64, longest=32.0).values
    _, scatter = scattered(level(height_map(np.tile(tile, (3, 3)), 1.0)), contact(0.05, 0.2))
    for name in (AREA, GAP, PEAK):
        np.testing.assert_allclose(scatter.features[name]["scatter"], np.log(0.02), atol=0.05)


def test_variances_of_independent_samples_lead_to_that_of_the_map():
    """var(n) = a + b n: a stationary surface has a = 0, one whose places differ on every length b = 0."""
    numbers = (4, 9, 16, 36)
    stationary = subwindows._extrapolate_deviation({n: 0.01 * n for n in numbers})
    assert stationary == pytest.approx(0.5 * np.log(0.01 + 1e-4))
    different = subwindows._extrapolate_deviation(dict.fromkeys(numbers, 0.09))
    assert different == pytest.approx(0.5 * np.log(0.09 + 1e-4))
    assert subwindows._extrapolate_deviation({4: 0.3}) == pytest.approx(np.log(0.1))


def test_the_scatter_of_the_gradient_tells_a_stationary_surface_from_one_whose_places_differ():
    """White-ish noise whose amplitude is the same everywhere, and one that grows across the map."""
    noise = surface(256, longest=16.0).values[:192, :192]
    growing = noise * np.linspace(0.3, 3.0, 192)[None, :]
    even, uneven = (
        scattered(level(height_map(heights, 1.0)), contact(0.1))[1].features[AREA]["gradient"]
        for heights in (noise, growing)
    )
    assert even < np.log(0.05)
    assert uneven > np.log(0.3)


@pytest.mark.parametrize("method", ["mirror", "periodic-plus-smooth", "raw"])
def test_any_way_to_make_periodic(method):
    levelled = crop(surface(256, longest=32.0), 96, 1)
    _, scatter = scattered(levelled, contact(0.1), arguments={"method": method})
    assert len(scatter.slices) == 9
    assert np.isfinite(scatter.members[AREA]).all()


def test_profile_is_cut_into_nine():
    profile = self_affine((1, 1024), 1.0, (8.0, 64.0), rms_gradient=GRADIENT, seed=3)
    _, scatter = scattered(level(profile[:, :700]), contact(0.1))
    assert len(scatter.slices) == 9
    assert np.isfinite(scatter.features[AREA]["gradient"])


def test_a_small_map_has_few_parts_and_a_smaller_one_none():
    problem = contact(0.1)
    _, few_parts = scattered(crop(surface(128, longest=16.0), 32, 5), problem)
    assert len(few_parts.slices) == 4
    levelled = crop(surface(64, longest=16.0), 16, 5)
    _, none = scattered(levelled, problem)
    assert len(none.slices) == 1
    assert none.features == {}
    attrs = subwindows.sample_attributes(none, levelled, aspect=1.0)
    assert "too small" in attrs["window_reason"]
    assert "Measure more places" in attrs["window_flag"]
    with pytest.raises(SettingsError, match="windows = 3"):
        scattered(levelled, problem, number=3)


def test_isolated_features_are_noticed():
    """Pits that hold most of the mean square height: one map does not tell how many there are elsewhere."""
    smooth = surface(256, longest=32.0)[:128, :128]
    y, x = np.mgrid[:128, :128]
    pit = -20 * float(smooth.std()) * np.exp(-((y - 70) ** 2 + (x - 60) ** 2) / 18)
    flags = []
    for heights in (smooth, smooth + pit):
        levelled = level(heights)
        flags.append(flag(levelled))
    assert flags[0] == ""
    assert "Sku" in flags[1]


def test_a_lay_leaves_few_independent_parts():
    ridges = surface(256, longest=16.0)[:192, 100].values[:, None]
    roughness = 0.05 * surface(256, longest=32.0, seed=3)[:192, :192].values
    flags = []
    for heights in (ridges + roughness, 10 * roughness):
        levelled = level(height_map(heights, 1.0))
        flags.append(flag(levelled))
    assert "no more than three independent ones" in flags[0]
    assert flags[1] == ""


def test_a_member_that_misses_its_tolerance_is_no_result():
    levelled, problem = crop(surface(64, longest=32.0), 64, 0), contact(0.1)
    window = periodic_window(levelled)
    results = solve_member(window, problem | {"tolerance": 1e-15}, tolerance=1e-15, names=NAMES)
    assert all(np.isnan(results[name]).all() for name in NAMES)


def test_a_window_that_is_flat_up_to_rounding_is_flat():
    """A part that has no roughness is levelled to rounding, and touches everywhere; a step does not."""
    heights = np.zeros((1, 210))
    heights[0, 100:] = 1e-6
    rounding = 1e-22 * np.random.default_rng(1).normal(size=(1, 64))
    problem = {"contact_modulus": 1e9, "mean_pressure": [1e3, 1e5]}
    flat, rough = (
        solve_member(height_map(h, 1e-6), problem, tolerance=1e-3, names=(AREA, GAP))
        for h in (rounding, heights)
    )
    assert flat[AREA].tolist() == [1, 1]
    assert flat[GAP].tolist() == [0, 0]
    assert (rough[AREA] < 1).all()
