"""Rejected points: what they were is kept, and the load that they would carry is known."""

import numpy as np

from roughcontact.arguments.maps import height_map
from roughcontact.contact.solve import solve_contact
from roughcontact.surface.faces.composite import composite
from roughcontact.surface.levelling.level import level
from roughcontact.surface.levelling.rejected import rejected_points, restore_rejected
from roughcontact.surface.synthetic import self_affine_surface
from roughcontact.surface.window.periodic_window import periodic_window
from roughcontact.uncertainty.budget import error_budget
from roughcontact.uncertainty.ensemble import rejected_load_share

LOADS = [2e-3, 2e-2]
PROBLEM = {"contact_modulus": 1.0, "mean_pressure": LOADS, "tolerance": 1e-4}


def rough(seed=0, shape=(96, 96)):
    return self_affine_surface(
        (128, 128), 1.0, hurst=0.8, shortest=6.0, longest=40.0, rms_gradient=0.1, seed=seed
    ).values[: shape[0], : shape[1]]


def spiked(count=12, height=4.0, seed=1, surface=None):
    """Return a map with spikes far apart, and where they are."""
    values = (rough() if surface is None else surface).copy()
    indices = np.random.default_rng(seed).permutation(
        [(r, c) for r in range(8, 90, 12) for c in range(8, 90, 12)]
    )
    spikes = np.zeros(values.shape, dtype=bool)
    spikes[tuple(indices[:count].T)] = True
    values[spikes] += height
    return values, spikes


def test_levelling_keeps_what_it_rejected():
    values, spikes = spiked()
    levelled = level(height_map(values, 1.0), line_alignment="none")
    np.testing.assert_array_equal(rejected_points(levelled), spikes)
    np.testing.assert_array_equal(~np.isnan(levelled["rejected_height"].values), spikes)
    # the plane of the others is off the rejected ones, too
    restored = restore_rejected(levelled)
    difference = values - restored.values
    y, x = np.indices(values.shape)
    plane = np.linalg.lstsq(
        np.stack([np.ones(y.size), y.ravel(), x.ravel()]).T, difference.ravel(), rcond=None
    )
    assert (
        np.abs(np.stack([np.ones(y.size), y.ravel(), x.ravel()]).T @ plane[0] - difference.ravel()).max()
        < 1e-12
    )
    np.testing.assert_array_equal(restored["filled"].values != 0, spikes)
    assert "rejected_height" not in level(height_map(rough(), 1.0)).coords


def test_filters_act_on_rejected_points_as_on_others():
    values, spikes = spiked()
    levelled = level(height_map(values, 1.0), l_filter=30.0)
    unfiltered = level(height_map(values, 1.0), outlier_threshold=None, l_filter=30.0)
    difference = levelled["rejected_height"].values - unfiltered.values
    assert np.abs(difference[spikes]).max() < 0.05


def test_share_of_the_load_is_that_of_a_solution_with_the_points_kept():
    """The same map levelled without rejection, made periodic and solved: pressures summed on the spikes."""
    values, spikes = rough().copy(), np.zeros((96, 96), dtype=bool)
    spikes[20:80:20, 20:80:15] = True  # off the edges that are blended
    values[spikes] += 1.5
    height = height_map(values, 1.0)
    levelled = level(height, form="none")
    assert 5 < rejected_points(levelled).sum() <= spikes.sum()
    share = rejected_load_share(levelled, window={}, contact=PROBLEM)
    unfiltered = periodic_window(level(height, form="none", outlier_threshold=None))
    rows, columns = (np.rint(unfiltered[d].values - 0.5).astype(int) for d in ("y", "x"))
    pressure = solve_contact(unfiltered, **PROBLEM)["pressure"].values
    direct = pressure[:, rejected_points(levelled)[np.ix_(rows, columns)]].sum(axis=1) / pressure.sum(
        axis=(1, 2)
    )
    assert 0.05 < direct[1] < direct[0] < 0.95
    np.testing.assert_allclose(share, direct, rtol=2e-3)


def test_one_spike_above_all_carries_everything():
    values, _ = spiked(count=1, height=1000.0)
    share = rejected_load_share(level(height_map(values, 1.0)), window={}, contact=PROBLEM)
    np.testing.assert_allclose(share, 1.0, atol=1e-6)


def test_what_lies_low_or_is_kept_carries_nothing():
    values, _ = spiked(height=-4.0)
    height = height_map(values, 1.0)
    assert level(height).attrs["outliers_rejected"] == 12
    np.testing.assert_array_equal(rejected_load_share(level(height), window={}, contact=PROBLEM), 0)
    height = height_map(spiked()[0], 1.0)
    unfiltered = level(height, outlier_threshold=None)
    np.testing.assert_array_equal(rejected_load_share(unfiltered, window={}, contact=PROBLEM), 0)


def test_points_that_the_window_leaves_out_carry_nothing():
    values = rough()
    values[:30, :30] = np.nan
    values[10, 10] = 50.0  # alone, open to the border
    levelled = level(height_map(values, 1.0))
    assert levelled.attrs["outliers_rejected"] == 1
    np.testing.assert_array_equal(rejected_load_share(levelled, window={}, contact=PROBLEM), 0)


def test_the_budget_hands_it_on_whatever_its_sources():
    levelled = level(height_map(spiked(height=1.5)[0], 1.0))
    window, settings = periodic_window(levelled), {"level": {}, "window": {}, "contact": PROBLEM}
    expected = rejected_load_share(levelled, window={}, contact=PROBLEM)
    for sources in ([], ["solver"]):
        budget = error_budget(levelled, window, settings, sources=sources)
        np.testing.assert_array_equal(budget["rejected_load_share"], expected)
    forgotten = levelled.drop_vars("rejected_height")
    assert error_budget(forgotten, window, settings, sources=[])["rejected_load_share"].isnull().all()


def test_pairs_know_what_was_rejected_on_either_face():
    values, spikes = spiked()
    face, counter_face = level(height_map(values, 1.0)), level(height_map(rough(seed=3), 1.0))
    for pair, mirrored in (((face, counter_face), False), ((counter_face, face), True)):
        together = composite(*pair)
        expected = spikes[:, ::-1] if mirrored else spikes
        np.testing.assert_array_equal(rejected_points(together), expected)
        assert (together["rejected_height"].values[expected] > 3 * float(together.std())).all()
    assert "rejected_height" not in composite(counter_face, counter_face).coords
