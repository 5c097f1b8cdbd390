"""The choices of processing: which are tried, what they make of the interval, how holes are filled."""

import numpy as np
import pytest
from known_surfaces import GRADIENT, MEANS, contact, surface

from roughcontact.contact.solve import solve_contact
from roughcontact.levelling.level import level
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.uncertainty.headline import QUANTITIES, headline
from roughcontact.uncertainty.processing import processing_uncertainty, rough_filling
from roughcontact.uncertainty.window_sampling import window_uncertainty
from roughcontact.window.periodic_window import periodic_window

FORM_2, OTHER_METHOD, FILLED = (
    "form of order 2",
    "made periodic by periodic-plus-smooth",
    "holes filled with roughness",
)


def processed(height, problem, *, form=None, window=None):
    """Return the result of a map, and its uncertainty from processing."""
    form, window = form or {}, window or {}
    levelled = level(height, **form)
    solved = solve_contact(periodic_window(levelled, **window), **problem, reduce=headline)
    found = processing_uncertainty(levelled, level=form, window=window, contact=problem, solved=solved)
    return solved, found


def crop(master, points, place):
    row, column = (points * n for n in divmod(place, master.shape[1] // points))
    return height_map(master.values[row : row + points, column : column + points], 1.0)


def with_holes(height, count, seed, *, size=8):
    values, generator = height.values.copy(), np.random.default_rng(seed)
    for row, column in generator.integers(2, len(values) - size - 2, (count, 2)):
        rows, columns = generator.integers(2, size, 2)
        values[row : row + rows, column : column + columns] = np.nan
    return height_map(values, 1.0)


@pytest.mark.parametrize(
    ("form", "window", "names"),
    [
        ({}, {}, [FORM_2, OTHER_METHOD]),
        ({"form": "mean"}, {}, ["form of order 1", OTHER_METHOD]),
        (
            {"form": "polynomial", "order": 2},
            {},
            ["form of order 3", "form of order 1", OTHER_METHOD],
        ),
        ({"form": "polynomial", "order": 1}, {"method": "cross-fade"}, None),
        ({"form": "sphere"}, {"method": "periodic-plus-smooth"}, None),
    ],
)
def test_choices(form, window, names):
    height = crop(surface(192), 96, 0)
    if form.get("form") == "sphere":
        y, x = np.indices(height.shape)
        height = height_map(height.values - ((x - 48.0) ** 2 + (y - 48.0) ** 2) / 200, 1.0)
    if names is None:
        other = [name for name in ("smooth-cross-fade", "periodic-plus-smooth") if name != window["method"]]
        names = [FORM_2, *(f"made periodic by {name}" for name in other)]
    _, found = processed(height, contact(0.1), form=form, window=window)
    assert list(found["choice"].values) == ["as chosen", *names]


@pytest.mark.parametrize("shape", [(48, 64), (1, 300), (5, 40)])
def test_a_map_that_is_all_form_is_flat_without_it(shape):
    """A made paraboloid: a polynomial of the second order leaves rounding alone, which is no roughness."""
    y, x = ((np.arange(n) - n / 2) * (n > 1) for n in shape)
    bowl = height_map(-1e-3 * (y[:, None] ** 2 + x[None, :] ** 2), 1.0)
    solved, found = processed(bowl, {"contact_modulus": 1.0, "mean_pressure": [1e-4]})
    assert solved["relative_contact_area"].item() < 0.1
    assert found["relative_contact_area_members"].sel(choice=FORM_2).item() > 0.9
    assert found["relative_contact_area"].item() > 0.9  # which of both it is decides


def test_periodic_map_has_no_choices():
    solved, found = processed(surface(96), contact(0.1))
    assert list(found["choice"].values) == ["as chosen"]
    for name in QUANTITIES:
        assert float(found[name][0]) == 0
        assert float(found[f"{name}_members"][0, 0]) == float(solved[name][0])
    assert "no alternative" in found.attrs["reason"]


def test_lower_order_is_tried_only_where_it_leaves_no_bow():
    height = crop(surface(192), 96, 0)
    y, _ = np.indices(height.shape)
    bowed = height_map(height.values + (y - 48.0) ** 2 / 100, 1.0)
    order_2 = {"form": "polynomial", "order": 2}
    _, found = processed(bowed, contact(0.1), form=order_2)
    assert "form of order 1" not in found["choice"]
    # whoever takes off a plane alone is told
    solved, plane = processed(bowed, contact(0.1))
    flat = found["relative_contact_area_members"].values[0, 0]
    assert abs(float(solved["relative_contact_area"][0]) - flat) <= float(plane["relative_contact_area"][0])
    assert float(plane["relative_contact_area"][0]) > 0.3 * float(solved["relative_contact_area"][0])


def test_interval_from_the_choices():
    height = with_holes(crop(surface(256, longest=64.0), 128, 1), 20, seed=1)
    solved, found = processed(height, contact(0.05, 0.3))
    assert list(found["choice"].values) == ["as chosen", FORM_2, OTHER_METHOD, FILLED]
    for name in QUANTITIES:
        members = found[f"{name}_members"].values
        np.testing.assert_allclose(members[0], solved[name].values, rtol=1e-12)
        squares = ((members[1:] - members[0]) ** 2).sum(axis=0)
        np.testing.assert_allclose(found[name].values, 2 * np.sqrt(squares / 3), rtol=1e-9)
    assert FILLED in found.attrs["reason"]


def test_differences_on_the_coarse_grid_are_those_of_the_whole():
    """Gap and area of the choices, solved at half the points and scaled, against solves at all points."""
    height, problem = crop(surface(512, longest=64.0, seed=4), 256, 0), contact(0.1, 0.4)
    solved, found = processed(height, problem)
    order_2 = periodic_window(level(height, form="polynomial", order=2))
    shown = periodic_window(level(height))
    offset = [round(shown.attrs[f"window_offset_{d}"]) for d in "yx"]
    part = level(height)[tuple(slice(o, o + n) for o, n in zip(offset, shown.shape, strict=True))]
    other = periodic_window(part, method="periodic-plus-smooth")
    for index, window in ((1, order_2), (2, other)):
        whole = solve_contact(window, **problem, reduce=headline)
        for name, allowed in (("mean_gap", 0.02), ("relative_contact_area", 0.01)):
            coarse = found[f"{name}_members"].values[index]
            assert np.abs(coarse - whole[name].values).max() <= allowed * solved[name].values.max()


def test_holes_become_as_rough_as_the_map():
    complete = level(crop(surface(512, longest=64.0, seed=2), 256, 0))
    levelled = level(with_holes(complete, 150, seed=3, size=20))
    rough = rough_filling(levelled)
    filled = levelled["filled"].values == 1
    assert 0.15 < filled.mean() < 0.4
    np.testing.assert_array_equal(rough.values[~filled], levelled.values[~filled])
    inside = filled[1:-1, 1:-1]

    def bend(values):
        return (
            values[:-2, 1:-1]
            + values[2:, 1:-1]
            + values[1:-1, :-2]
            + values[1:-1, 2:]
            - 4 * values[1:-1, 1:-1]
        )

    curvature = [np.std(bend(each.values)[inside]) for each in (complete, levelled, rough)]
    assert curvature[1] < 0.5 * curvature[0]
    assert curvature[2] == pytest.approx(curvature[0], rel=0.3)


def test_holes_at_the_border_are_left_alone():
    values = crop(surface(256), 128, 0).values.copy()
    values[:20, :30] = np.nan
    values[100:105, 95:100] = np.nan  # the half turn of this hole lies in the missing corner's neighbourhood
    values[60:64, 60:64] = np.nan
    levelled = level(height_map(values, 1.0))
    rough = rough_filling(levelled)
    np.testing.assert_array_equal(np.isnan(rough.values), np.isnan(levelled.values))
    changed = (rough.values != levelled.values) & ~np.isnan(rough.values)
    assert changed.any()
    assert (levelled["filled"].values[changed] == 1).all()
    assert np.abs(rough.values[changed]).max() < 2 * np.nanmax(np.abs(levelled.values))


def test_profile():
    profile = self_affine_surface(
        (1, 1024), 1.0, hurst=0.8, shortest=8.0, longest=64.0, rms_gradient=GRADIENT, seed=1
    )[:, :700]
    profile.values[0, 300:310] = np.nan
    _, found = processed(profile, contact(0.1))
    assert list(found["choice"].values) == ["as chosen", FORM_2, OTHER_METHOD, FILLED]
    assert np.isfinite(found["relative_contact_area"]).all()


@pytest.mark.slow
def test_filling_covers_what_holes_hide():
    """The result of 32 maps with holes lies within the interval of filling from that without holes."""
    problem = contact(0.1)
    inside = []
    for seed in range(32):
        complete = crop(surface(256, longest=64.0, seed=seed), 128, seed % 4)
        truth = solve_contact(periodic_window(level(complete)), **problem, reduce=headline)
        solved, found = processed(with_holes(complete, 40, seed=seed), problem)
        inside.append(
            [abs(float(solved[name][0] - truth[name][0])) <= float(found[name][0]) for name in MEANS]
        )
    assert (np.mean(inside, axis=0) >= 0.9).all()


@pytest.mark.nightly
def test_window_and_processing_cover_the_surface_behind_a_faulty_map():
    """32 maps with tilt, noise and dropouts, of two surfaces four times as long: 95 % intervals."""
    errors, intervals = [], []
    problem = contact(0.1)
    for seed, hurst in enumerate((0.5, 0.8)):
        master = surface(512, longest=32.0 * (1 + seed), seed=seed, hurst=hurst)
        truth = solve_contact(master, **problem, reduce=headline)
        for place in range(16):
            height = with_holes(crop(master, 128, place), 8, seed=place)
            y, x = np.indices(height.shape)
            noise = np.random.default_rng(place).standard_normal(height.shape)
            height = height_map(height.values + 3 + 0.02 * x - 0.01 * y + 0.002 * noise, 1.0)
            solved, found = processed(height, problem)
            sampling = window_uncertainty(level(height), window={}, contact=problem, solved=solved)
            true = [float(truth[name][0]) for name in MEANS]
            errors.append([abs(float(solved[name][0]) / t - 1) for name, t in zip(MEANS, true, strict=True)])
            intervals.append(
                [
                    float(np.hypot(found[name], sampling[name])[0]) / t
                    for name, t in zip(MEANS, true, strict=True)
                ]
            )
    errors, intervals = np.array(errors), np.array(intervals)
    held = (errors <= intervals).mean(axis=0)
    assert (held >= 0.9).all(), held
    width = np.median(intervals, axis=0) / np.quantile(errors, 0.95, axis=0)
    assert ((width > 0.8) & (width < 2.2)).all(), width
