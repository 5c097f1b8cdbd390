"""The benchmark of groups multiplies heights without a solve, and counts what it says."""

import groups
import numpy as np
import pytest

import roughcontact as rc
from roughcontact import height_map, self_affine_surface
from roughcontact.uncertainty.groups import to_scale


def test_multiplied_heights_need_no_further_solve(monkeypatch):
    waves = {"hurst": 0.8, "shortest": 1 / 4, "longest": 1 / 2, "rms_gradient": 0.1}
    height = self_affine_surface((32, 32), 1 / 32, **waves, seed=1)
    factor = 1.25
    loads = (0.004 * factor, 0.008 * factor)

    def counted(surface, pressures):
        contact = {"contact_modulus": 1.0, "mean_pressure": list(pressures), "tolerance": 1e-6}
        statistics = rc.solve_contact(surface, **contact, reduce=rc.contact_statistics)
        return {name: to_scale(name, statistics[name].values) for name in groups.NAMES}

    monkeypatch.setattr(groups, "GRID", np.array([0.004, 0.008]))
    monkeypatch.setattr(groups, "LOADS", loads)
    solved = {name: values[None] for name, values in counted(height, groups.GRID).items()}
    expected = counted(height_map(height.values * factor, 1 / 32), loads)
    results = groups.results(solved, np.array([0]), np.array([factor]))
    for name in groups.NAMES:
        np.testing.assert_allclose(results[name][0], expected[name], rtol=1e-4, err_msg=name)


def test_normal_batches_are_inside_as_often_as_stated(monkeypatch):
    monkeypatch.setattr(groups, "BATCHES", 2000)
    generator = np.random.default_rng(2)
    shape = (4, 2000, len(groups.LOADS))
    values = {name: -1.5 + 0.2 * generator.standard_normal(shape) for name in groups.NAMES}
    further = {name: -1.5 + 0.2 * generator.standard_normal(shape[1:]) for name in groups.NAMES}
    expected = {name: np.full(len(groups.LOADS), -1.5) for name in groups.NAMES}
    for is_inside in groups.inside(values, [1] * 4, expected, further):
        for name in groups.NAMES:
            assert is_inside[name].mean() == pytest.approx(0.95, abs=3 * np.sqrt(0.95 * 0.05 / 4000))
