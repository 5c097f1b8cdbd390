"""The window as a sample of its surface: formulas, places of the parts, coverage of known surfaces."""

import numpy as np
import pytest
from known_surfaces import GRADIENT, MEANS, contact, surface
from scipy import special, stats

from roughcontact.contact.solve import solve_contact
from roughcontact.errors import ConvergenceError, SettingsError
from roughcontact.levelling.level import level
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.roughness.texture import texture_parameters
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.uncertainty.ensemble import solve_member
from roughcontact.uncertainty.headline import QUANTITIES, headline
from roughcontact.uncertainty.window_sampling import window_uncertainty
from roughcontact.window.periodic_window import periodic_window


def sampled(levelled, problem, window=None, **options):
    """Return the result of a map's window, and its uncertainty as a sample."""
    window = window or {}
    solved = solve_contact(periodic_window(levelled, **window), **problem, reduce=headline)
    return solved, window_uncertainty(levelled, window=window, contact=problem, solved=solved, **options)


def crop(master, points, place):
    row, column = (points * n for n in divmod(place, master.shape[1] // points))
    return level(height_map(master.values[row : row + points, column : column + points], 1.0))


def effort(area):
    """Return the load over E* g at which Persson's law has this area, up to a factor."""
    return special.erfinv(area)


def gap_of_higher(levelled, problem, growth):
    """Return n u(p/n): the gap of heights n times as large, from the map itself under other loads."""
    loads = np.array(problem["mean_pressure"]) / growth
    window = periodic_window(levelled)
    return (
        growth * solve_contact(window, **(problem | {"mean_pressure": list(loads)}), reduce=headline).mean_gap
    )


def test_identical_parts_leave_what_the_size_adds():
    """Nine copies of a periodic map: the parts do not scatter, what they differ from the whole goes on."""
    tile = surface(64, longest=32.0).values
    levelled = level(height_map(np.tile(tile, (3, 3)), 1.0))
    problem = contact(0.05, 0.2)
    solved, found = sampled(levelled, problem)
    for name in MEANS:
        members = found[f"{name}_members"].values
        assert members.shape == (9, 2)
        np.testing.assert_allclose(members, members[:1].repeat(9, axis=0), rtol=1e-6)
        # waves of a sixth of the map: next to nothing grows, and the least exponent is that of the change
        if name == "mean_gap":
            growth = found.attrs["growth"]
            assert 1 < growth < 1.02
            ends = 1.25 * (gap_of_higher(levelled, problem, growth) - solved[name]), 0
        else:
            area = solved["relative_contact_area"].values
            own, part = effort(area), effort(found["relative_contact_area_members"].values[0])
            factor = np.exp(0.25 * abs(np.log(own / part)))
            lower, upper = special.erf(own / factor), special.erf(own * factor)
            load = np.array(problem["mean_pressure"])
            ends = (
                (upper - area, area - lower)
                if name == "relative_contact_area"
                else (load / lower - load / area, load / area - load / upper)
            )
            assert (found[name] < 0.02 * solved[name]).all()
        for end, expected in zip(("up", "down"), ends, strict=True):
            half_width = found[f"{name}_{end}"] / solved[name]
            # the growth is solved quickly, to a share of the gap
            atol = 5e-4 if name == "mean_gap" else 1e-4
            np.testing.assert_allclose(half_width, expected / solved[name], rtol=1e-3, atol=atol)


def test_what_another_gradient_does_to_the_area_is_the_same_at_all_loads():
    """Heights a quarter larger take 1/5 off the effort at every load; off the area less and less."""
    height = surface(256, longest=64.0)
    problem = contact(0.02, 0.1, 0.4, 1.0)
    areas = [
        solve_contact(factor * height, **problem, reduce=headline).relative_contact_area.values
        for factor in (1.0, 1.25)
    ]
    np.testing.assert_allclose(effort(areas[1]) / effort(areas[0]), 0.8, atol=0.03)
    assert areas[1][0] / areas[0][0] < 0.83
    assert areas[1][-1] / areas[0][-1] > 0.9


def test_no_interval_of_an_area_holds_more_than_all_or_nothing():
    levelled = crop(surface(512, longest=512.0), 128, 0)
    solved, found = sampled(levelled, contact(0.1, 0.5, 1.0, 2.0))
    area = solved["relative_contact_area"]
    assert area[-1] > 0.98
    assert (area + found["relative_contact_area_up"] <= 1).all()
    assert (area - found["relative_contact_area_down"] > 0).all()
    # the load over the ends of the area
    ends = solved["mean_pressure"] / (area - found["relative_contact_area_down"])
    upper = solved["mean_pressure"] / area + found["mean_contact_pressure_up"]
    np.testing.assert_allclose(upper, ends, rtol=1e-9)


def test_the_gap_of_higher_waves_grows_by_more_than_their_height():
    """The exact n u(p/n) by another solution, and to first order in n - 1 from the stiffness."""
    levelled = crop(surface(512, longest=512.0), 128, 0)
    problem = contact(0.02, 0.2) | {"tolerance": 1e-8}
    window = periodic_window(levelled)
    solved = solve_contact(window, **problem, reduce=contact_statistics)
    pressure, gap = (solved[name].values for name in ("mean_pressure", "mean_gap"))
    rate = 1 + pressure / (solved["contact_stiffness"].values * gap)
    assert (rate > 1.2).all()
    slightly = gap_of_higher(levelled, problem, 1.001).values
    np.testing.assert_allclose(np.log(slightly / gap) / np.log(1.001), rate, rtol=0.01)
    result, found = sampled(levelled, problem)
    growth = found.attrs["growth"]
    assert growth > 1.3
    scatter = found["mean_gap_down"] / (1 - found["mean_gap_down"] / result["mean_gap"])
    up = np.hypot(scatter, 1.25 * (gap_of_higher(levelled, problem, growth) - result["mean_gap"]))
    np.testing.assert_allclose(found["mean_gap_up"], up, rtol=1e-3)


@pytest.mark.parametrize(("longest", "extent"), [(32.0, 3.0), (32.0, 10.0), (512.0, 3.0)])
def test_formula_from_the_members(longest, extent):
    levelled = crop(surface(512, longest=longest), 128, 0)
    solved, found = sampled(levelled, contact(0.05, 0.2), extent=extent)
    window = periodic_window(levelled)
    flatness = min(1, 2 * texture_parameters(window)["Str"])
    dimensions = 1 + flatness
    t = stats.t.ppf(0.975, 3**dimensions - 1)
    assert found.attrs["coverage_factor"] == pytest.approx(t)
    assert found.attrs["degrees_of_freedom"] == pytest.approx(3**dimensions - 1)
    growth = np.log(found.attrs["growth"])
    assert (growth > 0.25) == (longest == 512.0)
    hurst = np.clip(growth / np.log(extent), 0.25, 1)
    scale = t * 3 ** (-(1 - hurst) * dimensions / 2) * np.sqrt(1 + extent ** (-(1 - hurst) * dimensions))
    deviation = {
        name: np.log(found[f"{name}_members"].values).std(axis=0, ddof=1)
        for name in ("mean_gap", "max_pressure")
    }
    ends = {}
    gap, peak, area = (solved[name].values for name in ("mean_gap", "max_pressure", "relative_contact_area"))
    scatter = 1.25 * scale * deviation["mean_gap"]
    grown = gap_of_higher(levelled, contact(0.05, 0.2), found.attrs["growth"]).values
    ends["mean_gap"] = gap * np.exp(-scatter), gap + np.hypot(gap * np.expm1(scatter), 1.25 * (grown - gap))
    down = t * deviation["max_pressure"]
    most = down + np.sqrt(6) / np.pi * deviation["max_pressure"] * dimensions * np.log(extent)
    ends["max_pressure"] = peak * np.exp(-down), peak * np.exp(most)
    members, main = (np.log(effort(a)) for a in (found["relative_contact_area_members"].values, area))
    going_on = hurst * (main - members.mean(axis=0)) * np.log(extent) / np.log(3)
    both = np.hypot(scale * members.std(axis=0, ddof=1), going_on)
    lower, upper = (special.erf(np.exp(main + side * both)) for side in (-1, 1))
    ends["relative_contact_area"] = lower, upper
    load = solved["mean_pressure"].values
    off = solved["mean_contact_pressure"].values - load / area  # the result is a mean over whole pixels
    ends["mean_contact_pressure"] = load / upper + off, load / lower + off
    for name in QUANTITIES:
        # the growth is solved quickly
        rtol = 1e-3 if name == "mean_gap" else 1e-9
        for side, end in zip(("down", "up"), ends[name], strict=True):
            half_width = np.abs(end - solved[name].values)
            np.testing.assert_allclose(found[f"{name}_{side}"], half_width, rtol=rtol)
        np.testing.assert_array_equal(found[name], np.maximum(found[f"{name}_down"], found[f"{name}_up"]))


def test_a_longer_surface_has_a_wider_interval():
    """Of gap and largest pressure on every map, of area and pressure in contact on the whole.

    Heights that grow with the length leave less contact: on some maps that takes more off the upper end of
    the area than the scatter adds.
    """
    wider = []
    for place in range(6):
        levelled = crop(surface(512, longest=512.0), 128, place)
        three, ten = (sampled(levelled, contact(0.05), extent=extent)[1] for extent in (3.0, 10.0))
        wider.append([(ten[f"{name}_up"] / three[f"{name}_up"]).item() for name in QUANTITIES])
    growth = dict(zip(QUANTITIES, np.transpose(wider), strict=True))
    assert min(growth["mean_gap"].min(), growth["max_pressure"].min()) > 1
    assert all(np.exp(np.log(each).mean()) > 1.1 for each in growth.values())
    assert "over 10.0 times the length of the map" in ten.attrs["reason"]
    with pytest.raises(SettingsError, match=r"extent = 0\.5"):
        sampled(levelled, contact(0.05), extent=0.5)


def test_isolated_features_are_noticed():
    """Pits that hold most of the mean square height: one map does not tell how many there are elsewhere."""
    smooth = surface(256, longest=32.0)[:128, :128]
    y, x = np.mgrid[:128, :128]
    pit = -20 * float(smooth.std()) * np.exp(-((y - 70) ** 2 + (x - 60) ** 2) / 18)
    flags = [sampled(level(map_), contact(0.1))[1].attrs["flag"] for map_ in (smooth, smooth + pit)]
    assert not flags[0]
    assert "Sku" in flags[1]


def test_a_lay_leaves_few_independent_parts():
    ridges = surface(256, longest=16.0)[:192, 100].values[:, None]
    roughness = 0.05 * surface(256, longest=32.0, seed=3)[:192, :192].values
    flags = []
    for heights in (ridges + roughness, 10 * roughness):
        _, found = sampled(level(height_map(heights, 1.0)), contact(0.1))
        assert (found.attrs["degrees_of_freedom"] < 2.5) == bool(found.attrs["flag"])
        flags.append(found.attrs["flag"])
    assert "no more than three independent ones" in flags[0]
    assert not flags[1]


def test_parts_lie_side_by_side_in_the_window():
    levelled = crop(surface(256, longest=32.0), 128, 1)
    _, found = sampled(levelled, contact(0.1))
    window = periodic_window(levelled)
    offset = window.attrs["window_offset_y"], window.attrs["window_offset_x"]
    covered = np.zeros(levelled.shape, dtype=int)
    for part in range(9):
        y, x, ny, nx = (
            round(float(found[f"member_{what}_{d}"][part])) for what in ("offset", "length") for d in "yx"
        )
        covered[y : y + ny, x : x + nx] += 1
    y, x = (round(o) for o in offset)
    assert (covered[y : y + 108, x : x + 108] == 1).all()
    assert covered.sum() == 108**2
    assert found.attrs["map_share"] == pytest.approx(108**2 / 128**2)


@pytest.mark.parametrize("method", ["mirror", "periodic-plus-smooth", "raw"])
def test_any_way_to_make_periodic(method):
    _, found = sampled(crop(surface(256, longest=32.0), 96, 1), contact(0.1), window={"method": method})
    assert found.sizes["member"] == 9
    for name in QUANTITIES:
        assert (found[name] > 0).all()
    assert found.attrs["map_share"] <= 1


def test_relative_numbers_do_not_depend_on_units():
    levelled = crop(surface(256, longest=32.0), 96, 0)
    problem = contact(0.1)
    _, one = sampled(levelled, problem)
    larger = height_map(levelled.values * 1e-6, 1e-6)
    _, other = sampled(level(larger), problem | {"contact_modulus": 1e9, "mean_pressure": [0.1e9 * GRADIENT]})
    factors = dict(zip(QUANTITIES, (1, 1e-6, 1e9, 1e9), strict=True))
    for name, factor in factors.items():
        np.testing.assert_allclose(other[name], one[name] * factor, rtol=1e-6)


def test_profile_is_cut_into_nine():
    profile = self_affine_surface(
        (1, 1024), 1.0, hurst=0.8, shortest=8.0, longest=64.0, rms_gradient=GRADIENT, seed=3
    )
    _, found = sampled(level(profile[:, :700]), contact(0.1))
    assert found.sizes["member"] == 9
    assert (found["member_length_y"] == 1).all()
    assert (found["relative_contact_area"] > 0).all()


def test_small_map_has_few_parts_and_a_wide_interval():
    _, found = sampled(crop(surface(128, longest=16.0), 32, 5), contact(0.1))
    assert found.sizes["member"] == 4
    assert found.attrs["coverage_factor"] == pytest.approx(stats.t.ppf(0.975, 3))
    assert np.isfinite(found["relative_contact_area"]).all()
    assert found.attrs["flag"] == ""


def test_map_too_small_for_parts_says_so():
    _, found = sampled(crop(surface(64, longest=16.0), 16, 5), contact(0.1))
    assert found.sizes["member"] == 1
    for name in QUANTITIES:
        assert np.isnan(found[name]).all()
    assert "too small" in found.attrs["reason"]
    assert "Measure more places" in found.attrs["flag"]


def test_heights_grow_where_waves_are_longer_than_the_map():
    growth = {}
    for longest in (32.0, 512.0):
        master = surface(512, longest=longest, seed=2)
        growth[longest] = [
            sampled(crop(master, 128, place), contact(0.05))[1].attrs["growth"] for place in range(4)
        ]
    assert max(growth[32.0]) < 1.25
    assert min(growth[512.0]) > 1.25


def test_number_of_parts():
    levelled = crop(surface(256, longest=32.0), 128, 0)
    assert sampled(levelled, contact(0.1), number=5)[1].sizes["member"] == 4
    with pytest.raises(SettingsError, match="windows = 3"):
        sampled(levelled, contact(0.1), number=3)


def test_a_member_that_misses_its_tolerance_is_no_result():
    window, problem = surface(64, longest=32.0), contact(0.1) | {"tolerance": 1e-15}
    with pytest.raises(ConvergenceError):
        solve_member(window, problem, tolerance=1e-15)
    flagged = solve_member(window, problem | {"on_failure": "flag"}, tolerance=1e-15)
    assert all(np.isnan(flagged.values[name]).all() for name in QUANTITIES)
    assert flagged.work > 0


def over_area(solved):
    """Return a result with the load over the area as its pressure in contact: what the interval is about."""
    return solved.assign(mean_contact_pressure=solved["mean_pressure"] / solved["relative_contact_area"])


@pytest.mark.slow
def test_interval_covers_the_surface_that_the_map_was_taken_from():
    """48 maps of three surfaces, four times as long as the maps: at least 90 % of the 95 % intervals hold.
    Together with processing, on faulty maps: test_uncertainty_processing.py."""
    errors, intervals = [], []
    problem = contact(0.1)
    for seed, (hurst, longest) in enumerate(((0.5, 16.0), (0.7, 24.0), (0.9, 48.0))):
        master = surface(384, longest=longest, seed=seed, hurst=hurst)
        truth = over_area(solve_contact(master, **problem, reduce=headline))
        for place in range(16):
            solved, found = sampled(crop(master, 96, place), problem)
            solved = over_area(solved)
            errors.append([abs(float(solved[name][0] / truth[name][0]) - 1) for name in MEANS])
            intervals.append([float(found[name][0] / truth[name][0]) for name in MEANS])
    errors, intervals = np.array(errors), np.array(intervals)
    assert ((errors <= intervals).mean(axis=0) >= 0.9).all()
    width = np.median(intervals, axis=0) / np.quantile(errors, 0.95, axis=0)
    # the margin of the gap is that of measured surfaces, which scatter more than these
    widest = [2.5 if name == "mean_gap" else 2.0 for name in MEANS]
    assert ((width > 0.7) & (width < widest)).all(), width


def test_a_part_of_a_map_that_is_flat_up_to_rounding_is_flat():
    """A part that has no roughness is levelled to rounding, and touches everywhere; a step does not."""
    heights = np.zeros((1, 210))
    heights[0, 100:] = 1e-6
    parts = [
        height_map(1e-22 * np.random.default_rng(1).normal(size=(1, 64)), 1e-6),
        height_map(heights, 1e-6),
    ]
    problem = {"contact_modulus": 1e9, "mean_pressure": [1e3, 1e5]}
    flat, rough = (solve_member(part, problem, tolerance=1e-3).values for part in parts)
    assert flat["relative_contact_area"].tolist() == [1, 1]
    assert flat["mean_gap"].tolist() == [0, 0]
    assert (rough["relative_contact_area"] < 1).all()


def test_between_close_loads_the_relative_half_widths_are_interpolated():
    levelled = crop(surface(512, longest=64.0), 128, 3)
    few, more = contact(0.01, 0.04), contact(0.01, 0.02, 0.04)
    _, at_ends = sampled(levelled, few)
    solved, found = sampled(levelled, more)
    for name in QUANTITIES:
        members = found[f"{name}_members"].values
        assert np.isnan(members[:, 1]).all()
        np.testing.assert_allclose(members[:, [0, 2]], at_ends[f"{name}_members"], rtol=1e-2)
        for side in ("down", "up"):
            relative = (found[f"{name}_{side}"] / solved[name]).values
            np.testing.assert_allclose(relative[1], relative[[0, 2]].mean(), rtol=1e-9)
            # of the growth of the gap the solution at the lower load is another one
            np.testing.assert_allclose(found[f"{name}_{side}"][[0, 2]], at_ends[f"{name}_{side}"], rtol=0.05)


def test_the_growth_between_close_loads_is_that_of_the_solution():
    levelled = crop(surface(512, longest=512.0), 128, 0)
    problem = contact(0.1, 0.2)
    solved, found = sampled(levelled, problem)
    scatter = found["mean_gap_down"] / (1 - found["mean_gap_down"] / solved["mean_gap"])
    growth = gap_of_higher(levelled, problem, found.attrs["growth"]) - solved["mean_gap"]
    added = np.sqrt(found["mean_gap_up"] ** 2 - scatter**2) / 1.25
    np.testing.assert_allclose(added, growth, rtol=0.02)
