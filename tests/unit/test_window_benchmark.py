"""The benchmark of windows runs, measures what it says, and writes its page."""

import importlib
import sys
from pathlib import Path

import numpy as np
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
def test_quick_run_and_page(benchmark, tmp_path, monkeypatch):
    monkeypatch.setattr(benchmark, "KINDS", ("isotropic", "turned"))
    sizes = {"points": 256, "side": 128}
    results = {
        part: sizes
        | {"seeds": 1, "rows": benchmark.run(part, seeds=range(1), say=lambda *a, **k: None, **sizes)}
        for part in benchmark.PARTS
    }
    rows = results["methods"]["rows"]
    page = importlib.import_module("window_page")
    misses = page.worst_misses(rows)
    assert set(misses) == set(benchmark.METHODS)
    assert misses["raw"]["peak"] > 3 * misses["smooth-cross-fade"]["peak"]
    assert misses["raw"]["gradient"] > 0.2 > misses["smooth-cross-fade"]["gradient"]
    assert misses["taper"]["rim"] > 0.5
    assert page.best_method(rows) != "raw"
    page.write(results, tmp_path / "window.md")
    text = (tmp_path / "window.md").read_text(encoding="utf-8")
    assert (tmp_path / "window.png").stat().st_size > 10_000
    for method in benchmark.METHODS:
        assert text.count(f"| `{method}` |") == len(benchmark.LOADS) + 1 + 2
    assert "isotropic, bump" in text
    assert "nan" not in text
