"""The benchmark of windows runs, and measures what it says."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from roughcontact.roughness.parameters import rms_gradient

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def benchmark():
    """The script `benchmarks/window.py` as a module."""
    sys.path.insert(0, str(ROOT / "benchmarks"))
    yield importlib.import_module("window")
    sys.path.remove(str(ROOT / "benchmarks"))


@pytest.mark.parametrize("kind", ["isotropic", "anisotropic", "turned", "bimodal"])
def test_masters_are_periodic_and_of_unit_gradient(benchmark, kind):
    surface = benchmark.master(kind, 3, 192)
    assert rms_gradient(surface) == pytest.approx(1.0)
    across = np.diff(surface.values, axis=1)
    seam = surface.values[:, 0] - surface.values[:, -1]
    assert np.sqrt(np.mean(seam**2)) < 2 * np.sqrt((across**2).mean(axis=0).max())


def test_area_and_rim_of_known_pressures(benchmark):
    full = np.ones((40, 40))
    assert benchmark.area(full) == 1
    assert benchmark.rim_load(full) == 1
    edge = np.zeros((100, 100))
    edge[:3] = 2.0
    rim_points = 10000 - 94 * 94
    assert benchmark.rim_load(edge) == pytest.approx(2 * 300 / rim_points)
    # a square of 10 x 10: 40 switches; at the corner of the map half of them go over the period
    square = np.zeros((40, 40))
    square[:10, :10] = 1.0
    correction = (np.pi - 1 + np.log(2)) / 24
    assert benchmark.area(square) == pytest.approx((100 - 40 * correction) / 1600)
    assert benchmark.area(square, periodic=False) == pytest.approx((100 - 20 * correction) / 1600)


@pytest.mark.slow
def test_quick_run(benchmark, monkeypatch):
    monkeypatch.setattr(benchmark, "KINDS", ("isotropic", "turned"))
    sizes = {"points": 256, "side": 128}
    results = {
        part: sizes
        | {"seeds": 1, "rows": benchmark.run(part, seeds=range(1), say=lambda *a, **k: None, **sizes)}
        for part in benchmark.PARTS
    }
    misses = benchmark.misses(pd.DataFrame(results["methods"]["rows"]))
    assert set(misses.index) == set(benchmark.METHODS)
    assert misses["peak"]["raw"] > 3 * misses["peak"]["smooth-cross-fade"]
    assert misses["gradient"]["raw"] > 0.2 > misses["gradient"]["smooth-cross-fade"]
    assert misses["rim"]["taper"] > 0.5
    assert benchmark.about(results)["nearest method"] != "raw"
    tables = benchmark.tables(results)
    assert set(tables["methods"]["method"].value_counts()) == {len(benchmark.LOADS)}
    assert "isotropic, bump" in set(tables["placements"]["maps"])
    assert not any(frame.eq("nan").any(axis=None) for frame in tables.values())
