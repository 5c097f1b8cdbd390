"""Rows shifted at random: found, measured, taken off; a lay is left alone; the rest is in the interval."""

import json

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from data_samples.make_samples import turned_surface
from roughcontact.arguments.maps import height_map
from roughcontact.contact.solve import solve_contact
from roughcontact.io.instrument_kinds import PROBE
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.statistics.map_checks import scan_lines
from roughcontact.statistics.outcome import PASSED, REVIEW
from roughcontact.surface.levelling.level import level
from roughcontact.surface.levelling.row_jitter import find_row_jitter
from roughcontact.surface.synthetic import self_affine_surface
from roughcontact.surface.window.periodic_window import periodic_window
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.budget_inputs import budget_inputs

ROWS = 192


def whole(seed, hurst=0.8, shortest=6.0, longest=96.0, stretch=1.0):
    """Return heights of a periodic surface of unit rms height."""
    waves = {"hurst": hurst, "shortest": shortest, "longest": longest, "stretch": stretch}
    return self_affine_surface((2 * ROWS, 2 * ROWS), 1.0, **waves, rms_height=1.0, seed=seed).values


def rough(hurst=0.8, shortest=6.0, longest=96.0, seed=0, stretch=1.0):
    """Return heights of a part of a larger surface, of unit rms height."""
    part = whole(seed, hurst, shortest, longest, stretch)[:ROWS, :ROWS]
    return part / part.std()


def shifts(size, seed=0):
    return size * np.random.default_rng(seed).standard_normal(ROWS)


def laid():
    """Return surfaces whose lay runs along the rows, and one with a step along them."""
    turned = {"nose_radius": 200.0, "seed": 3}
    shape = (ROWS, ROWS)
    surfaces = {f"ground {stretch}": rough(stretch=stretch, seed=2).T for stretch in (4.0, 8.0, 30.0)}
    surfaces |= {
        "turned": turned_surface(
            shape, 1.0, feed=16.0, groove_scatter=0.05, rms_roughness=0.02, **turned
        ).values.T,
        "turned, fine": turned_surface(shape, 1.0, feed=5.0, groove_scatter=0.02, **turned).values.T,
        "arcs": turned_surface(
            shape, 1.0, feed=16.0, groove_scatter=0.05, rms_roughness=0.02, arc_radius=3000.0, **turned
        ).values.T,
        "straight profile": np.repeat(
            self_affine_surface(
                (1, 2 * ROWS), 1.0, hurst=0.7, shortest=3.0, longest=90.0, rms_height=1.0, seed=3
            ).values[0, :ROWS, None],
            ROWS,
            axis=1,
        ),
        "step": rough() + 3 * (np.arange(ROWS)[:, None] > 70),
        "slope": rough() + 0.2 * np.arange(ROWS)[:, None],
        "bow": rough() + 1e-3 * (np.arange(ROWS)[:, None] - 90.0) ** 2,
        "flat": np.zeros(shape),
        "tilt": np.arange(ROWS)[:, None] + np.zeros(ROWS),
    }
    return surfaces


@pytest.mark.parametrize(("hurst", "shortest"), [(0.3, 2.2), (0.5, 4.0), (0.8, 6.0), (0.9, 12.0)])
@pytest.mark.parametrize("longest", [30.0, 200.0])
def test_surfaces_without_shifts_are_left_alone(hurst, shortest, longest):
    for seed in range(6):
        jitter = find_row_jitter(rough(hurst, shortest, longest, seed=seed))
        assert (jitter.evidence, jitter.rms) == ("none", 0.0)
        assert not jitter.offsets.any()


@pytest.mark.parametrize("name", laid())
def test_a_lay_along_the_rows_is_no_jitter(name):
    surface = laid()[name]
    assert find_row_jitter(surface).evidence == "none"
    levelled = level(height_map(surface, 1.0))
    assert levelled.attrs["line_alignment"] == "none"
    assert levelled.attrs["row_jitter"] == 0
    assert "line_offset" not in levelled.coords


@pytest.mark.parametrize("size", [0.05, 0.1, 0.5, 5.0])
@pytest.mark.parametrize("hurst", [0.5, 0.8])
def test_random_shifts_are_measured(size, hurst):
    for seed in range(4):
        moved = shifts(size, seed=seed + 10)
        jitter = find_row_jitter(rough(hurst, seed=seed) + moved[:, None])
        assert jitter.evidence == "clear"
        assert jitter.rms == pytest.approx(moved.std(), rel=0.25)


@pytest.mark.parametrize("surface", ["isotropic", "lay along y", "lay along x"])
def test_the_estimate_leaves_a_fourteenth_of_the_rms_height(surface):
    heights = rough(stretch=1.0 if surface == "isotropic" else 8.0, seed=1)
    heights = heights.T if surface == "lay along x" else heights
    errors = []
    for seed in range(8):
        moved = shifts(0.1, seed=seed)
        errors.append(np.std(moved - find_row_jitter(heights + moved[:, None]).offsets))
    assert np.mean(errors) < 0.07


def test_large_shifts_hide_little_of_the_surface():
    """Shifts of five rms heights: what is left of them is below the surface."""
    moved = shifts(5.0, seed=3)
    jitter = find_row_jitter(rough() + moved[:, None])
    assert np.std(moved - jitter.offsets) < 1.0


def test_shifts_among_missing_points_and_of_missing_rows():
    moved = shifts(0.2)
    values = rough() + moved[:, None]
    values[np.random.default_rng(1).random(values.shape) < 0.2] = np.nan
    values[60:63] = np.nan
    values[:20, :40] = np.nan
    jitter = find_row_jitter(values)
    assert jitter.evidence == "clear"
    assert np.isfinite(jitter.offsets).all()
    measured_rows = np.r_[:55, 68:ROWS]
    assert np.std((jitter.offsets - moved)[measured_rows]) < 0.6 * moved.std()


def test_small_maps_and_profiles_say_nothing():
    for shape in ((1, 500), (500, 1), (20, 200), (200, 20)):
        values = np.random.default_rng(0).standard_normal(shape[0])[:, None] + np.zeros(shape)
        jitter = find_row_jitter(values)
        assert (jitter.evidence, jitter.rms) == ("none", 0.0)
        assert jitter.offsets.shape == (shape[0],)


def test_units_and_offsets_do_not_matter():
    values = rough() + shifts(0.1)[:, None]
    jitter, scaled = find_row_jitter(values), find_row_jitter(1e-9 * values + 1e-3)
    assert scaled.rms == pytest.approx(1e-9 * jitter.rms, rel=1e-5)
    np.testing.assert_allclose(scaled.offsets, 1e-9 * jitter.offsets, atol=1e-15)


def probed(values):
    return height_map(values, 1.0, instrument={"kind": PROBE.name})


def drifting():
    """Return a map whose rows drift: each is shifted against the one before."""
    return rough() + np.cumsum(shifts(0.05))[:, None]


def test_drift_is_in_doubt_where_an_instrument_scans():
    assert find_row_jitter(drifting(), is_scan=True).evidence == "doubtful"
    for height, evidence in ((probed(drifting()), "doubtful"), (height_map(drifting(), 1.0), "none")):
        levelled = level(height)
        assert levelled.attrs["row_jitter_evidence"] == evidence
        assert levelled.attrs["line_alignment"] == "none"
        assert (levelled.attrs["row_jitter"] > 0.01) == (evidence == "doubtful")


def test_levelling_aligns_by_default_where_it_is_clear():
    clean, moved = rough(seed=4), shifts(0.1, seed=2)
    height = height_map(clean + moved[:, None], 1.0)
    levelled, unaligned = level(height), level(height, line_alignment="none")
    for height_map_levelled, alignment, by in ((levelled, "jitter", "default"), (unaligned, "none", "user")):
        assert height_map_levelled.attrs["line_alignment"] == alignment
        assert height_map_levelled.attrs["line_alignment_by"] == by
        assert height_map_levelled.attrs["row_jitter_evidence"] == "clear"
        assert height_map_levelled.attrs["row_jitter"] == pytest.approx(moved.std() / clean.std(), rel=0.2)
    plain = level(height_map(clean, 1.0)).values
    assert np.std(levelled.values - plain) < 0.5 * np.std(unaligned.values - plain)
    np.testing.assert_allclose(
        levelled.attrs["line_shift_rms"], np.sqrt(np.mean(levelled["line_offset"] ** 2)), rtol=1e-12
    )
    # nothing else was done to the map
    together = levelled.values + levelled["line_offset"].values[:, None] - height.values
    y, x = np.indices(together.shape)
    plane = np.stack([np.ones(y.size), y.ravel(), x.ravel()]).T
    residual = together.ravel() - plane @ np.linalg.lstsq(plane, together.ravel(), rcond=None)[0]
    assert np.abs(residual).max() < 1e-12
    assert json.loads(levelled.attrs["outlier_kinds"]) == {}


@pytest.mark.parametrize(
    ("attributes", "outcome", "word"),
    [
        ({}, PASSED, "No random shift"),
        (
            {"evidence": "clear", "alignment": "jitter"},
            REVIEW,
            "Compare without aligned lines (level.line_alignment: none)",
        ),
        (
            {"evidence": "clear", "alignment": "none"},
            REVIEW,
            "Compare with every row aligned (level.line_alignment: jitter)",
        ),
        ({"evidence": "clear", "alignment": "median", "by": "user"}, PASSED, "as asked (median)"),
        ({"evidence": "clear", "alignment": "jitter", "jitter": 0.01}, PASSED, "1.00 %"),
        ({"evidence": "doubtful", "alignment": "none"}, REVIEW, "drift of the scanner or a lay"),
        ({"evidence": "doubtful", "alignment": "none", "jitter": 0.005}, PASSED, "0.500 %"),
    ],
)
def test_the_check_says_what_was_found_and_done(attributes, outcome, word):
    check = scan_lines(
        {
            "row_jitter": attributes.get("jitter", 0.1) if attributes else 0.0,
            "row_jitter_evidence": attributes.get("evidence", "none"),
            "line_alignment": attributes.get("alignment", "none"),
            "line_alignment_by": attributes.get("by", "default"),
        }
    )
    assert check.outcome == outcome
    assert word in check.sentence


@pytest.mark.parametrize(
    ("texture", "hidden"),
    [
        ({"Str": 0.05, "Std": 92.0}, True),
        ({"Str": 0.05, "Std": 0.0}, False),
        ({"Str": 0.8, "Std": 90.0}, False),
        ({"Str": np.nan, "Std": np.nan}, False),
    ],
)
def test_a_lay_along_the_rows_is_said_to_hide_shifts(texture, hidden):
    check = scan_lines({"row_jitter_evidence": "none"}, xr.Dataset(texture))
    assert check.outcome == PASSED
    assert ("would not show" in check.sentence) == hidden


def test_statistics_carry_the_figure():
    window = periodic_window(level(height_map(rough() + shifts(0.1)[:, None], 1.0)))
    contact = solve_contact(window, contact_modulus=1.0, mean_pressure=0.01)
    assert float(contact_statistics(contact)["row_jitter"]) == pytest.approx(0.1, rel=0.2)


def masters():
    """Return (name, heights) of twelve periodic surfaces, 384 x 384."""
    size = 2 * ROWS
    y, x = np.indices((size, size))
    normal = whole(1)
    rank = np.clip(stats.norm.cdf(normal), 1e-6, 1 - 1e-6)
    yield "Gaussian", whole(0)
    yield "Gaussian, H = 0.5", whole(2, 0.5, 4.0, 64.0)
    yield "Weibull", stats.weibull_min.ppf(rank, 1.8)
    yield "lognormal", np.exp(0.5 * normal)
    yield "Student", stats.t.ppf(rank, 4)
    yield "ground along y", whole(3, 0.75, 5.0, 60.0, 8.0)
    yield "ground along x", whole(4, 0.75, 5.0, 60.0, 8.0).T
    honed = whole(5)
    yield "honed", np.minimum(honed, 0.5) - 0.5 * np.maximum(0, -honed - 1)
    for along, seed in ((x, 6), (y, 7)):
        yield f"turned {seed}", np.cos(2 * np.pi * along / 24) + 0.3 * whole(seed, 0.8, 4.0, 24.0)
    yield "dimples", 0.3 * whole(8) - 2 * np.exp(-((np.hypot(y % 48 - 24, x % 48 - 24) / 9) ** 4))
    grains = 0.3 * whole(9, 0.5, 4.0, 64.0)
    for row, column in np.random.default_rng(0).uniform(0, size, (250, 2)):
        distances = [(axis - centre + size / 2) % size - size / 2 for axis, centre in ((y, row), (x, column))]
        grains += 1.5 * np.exp(-(distances[0] ** 2 + distances[1] ** 2) / (2 * 1.6**2))
    yield "grains", grains


@pytest.mark.nightly
def test_the_interval_of_a_map_with_shifted_rows_covers_the_surface_behind_it():
    """Twelve surfaces, a quarter of each measured with shifts of 0.1 Sq: the area is held in 11 of 12."""
    problem = {"contact_modulus": 1.0, "mean_pressure": [0.002, 0.01, 0.04], "tolerance": 1e-4}
    coverage = []
    for number, (_, heights) in enumerate(masters()):
        steps = [np.roll(heights, 1, axis) - heights for axis in (0, 1)]
        surface = 0.1 * (heights - heights.mean()) / np.sqrt(np.mean(steps[0] ** 2 + steps[1] ** 2))
        truth = solve_contact(height_map(surface, 1.0), **problem, reduce=budget_inputs)
        generator = np.random.default_rng(100 + number)
        start = generator.integers(0, 2 * ROWS, 2)
        part = np.roll(surface, -start, (0, 1))[:ROWS, :ROWS]
        part = part + 0.1 * surface.std() * generator.standard_normal(ROWS)[:, None]
        levelled = level(height_map(part + 0.01 * np.arange(ROWS), 1.0))
        assert levelled.attrs["row_jitter"] == pytest.approx(0.1, rel=0.5)
        window = periodic_window(levelled)
        solved = solve_contact(window, **problem, reduce=budget_inputs)
        budget = error_budget(levelled, window, {"level": {}, "window": {}, "contact": problem})
        coverage.append(
            [
                np.abs(solved[name] - truth[name]).values
                <= budget[f"{name}_uncertainty"].sel(source="combined").values
                for name in ("relative_contact_area", "mean_contact_pressure")
            ]
        )
    assert (np.sum(np.all(coverage, axis=2), axis=0) >= 11).all()
