"""The benchmark of windows runs, and measures what it says."""

import numpy as np
import pandas as pd
import pytest
import window

from roughcontact.surface.roughness.parameters import rms_gradient


@pytest.mark.parametrize("kind", [*window.KINDS, *window.REPEATING])
def test_masters_are_periodic_and_of_unit_gradient(kind):
    surface = window.master(kind, 3, 192)
    assert rms_gradient(surface) == pytest.approx(1.0)
    across = np.diff(surface.values, axis=1)
    seam = surface.values[:, 0] - surface.values[:, -1]
    assert np.sqrt(np.mean(seam**2)) < 2 * np.sqrt((across**2).mean(axis=0).max())


def test_area_and_rim_of_known_pressures():
    full = np.ones((40, 40))
    assert window.area(full) == 1
    assert window.rim_load(full) == 1
    edge = np.zeros((100, 100))
    edge[:3] = 2.0
    rim_points = 10000 - 94 * 94
    assert window.rim_load(edge) == pytest.approx(2 * 300 / rim_points)
    # a square of 10 x 10: 40 switches; at the corner of the map half of them go over the period
    square = np.zeros((40, 40))
    square[:10, :10] = 1.0
    correction = (np.pi - 1 + np.log(2)) / 24
    assert window.area(square) == pytest.approx((100 - 40 * correction) / 1600)
    assert window.area(square, periodic=False) == pytest.approx((100 - 20 * correction) / 1600)


@pytest.mark.slow
def test_quick_run(monkeypatch):
    monkeypatch.setattr(window, "KINDS", ("isotropic", "turned"))
    sizes = {"points": 256, "side": 128}
    results = {
        part: sizes
        | {"seeds": 1, "rows": window.run(part, seeds=range(1), say=lambda *a, **k: None, **sizes)}
        for part in window.PARTS
    }
    misses = window.misses(pd.DataFrame(results["methods"]["rows"]))
    assert set(misses.index) == set(window.METHODS)
    assert misses["peak"]["raw"] > 3 * misses["peak"]["smooth-cross-fade"]
    assert misses["gradient"]["raw"] > 0.2 > misses["gradient"]["smooth-cross-fade"]
    assert misses["rim"]["taper"] > 0.5
    assert window.about(results)["nearest method"] != "raw"
    tables = window.tables(results)
    assert set(tables["methods"]["method"].value_counts()) == {len(window.LOADS)}
    assert set(tables["placements"]["maps"]) == {"isotropic", "turned", *window.REPEATING}
    assert not any(frame.eq("nan").any(axis=None) for frame in tables.values())
