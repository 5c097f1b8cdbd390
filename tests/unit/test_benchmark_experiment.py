"""The experiment of benchmarks/experiment.py on a made fracture: closure, interval, flow."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.surface.synthetic import self_affine_surface

STEP = 2.5e-4


@pytest.fixture(scope="module")
def experiment():
    sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
    yield importlib.import_module("experiment")
    sys.path.pop(0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder of a fracture whose measured closure is that of the whole square."""
    folder = tmp_path_factory.mktemp("fracture")
    heights = self_affine_surface((96, 96), STEP, hurst=0.8, shortest=2e-3, longest=8e-3, rms_height=5e-5)
    microns = np.round(1e6 * (heights.values.max() - heights.values)).astype("uint16")
    np.savez(folder / "granodiorite-1.npz", aperture_um=microns, dx=STEP, dy=STEP)
    loads = [0.5, 1.5, 3.0, 6.0]
    rows = [f"{load},{100 * load**0.5}" for load in (*loads, *loads[-2::-1])]
    (folder / "granodiorite-1-closure.csv").write_text("\n".join(["MPa,um", *rows]))
    return folder


def test_the_closure_of_the_whole_square_is_that_of_the_solver(experiment, folder):
    table = experiment.specimen(folder, 1, cuts=(1, 2))
    up = table[table["way"] == "up"]
    aperture, dy, dx, measured = experiment.read_specimen(folder, 1)
    np.testing.assert_allclose(up["measured_m"], measured[:4, 1] - measured[1, 1])
    windows = [experiment.parts_of(aperture, dy, dx, cut=cut) for cut in (1, 2)]
    assert [len(parts) for parts in windows] == [1, 4]
    expected = [
        np.mean(
            [
                rc.solve_contact(window, contact_modulus=youngs / 1.7822, mean_pressure=measured[:4, 0])[
                    "approach"
                ].values
                for window in parts
                for youngs in (10e9, 12e9)
            ],
            axis=0,
        )
        for parts in windows
    ]
    expected = np.mean(expected, axis=0)
    np.testing.assert_allclose(up["closure_m"], expected[1] - expected, rtol=1e-6, atol=1e-12)
    down = table[table["way"] == "down, hardness 200 MPa"]
    assert (np.diff(down["mean_pressure_Pa"]) < 0).all()


def test_the_interval_adds_up_scatter_cut_and_modulus(experiment):
    generator = np.random.default_rng(0)
    whole_areas, parts = np.array([[[10.0]], [[14.0]]]), generator.normal(20, 3, (2, 4, 1))
    mean, half = experiment.interval([whole_areas, parts])
    assert mean[0] == pytest.approx((12 + parts.mean()) / 2)
    of_moduli = [(10 + parts[0].mean()) / 2, (14 + parts[1].mean()) / 2]
    variance = np.mean([part.var(ddof=1) / 4 for part in parts])
    variance += ((parts.mean() - 12) ** 2 + np.diff(of_moduli)[0] ** 2) / 12
    assert half[0] == pytest.approx(3.1824463 * np.sqrt(variance))  # Student's t of three degrees of freedom


def test_a_rise_of_the_fluid_pressure_is_that_between_discs(experiment, folder, monkeypatch):
    """The pump between discs 20 um apart: 6 eta Q ln(R/r)/(pi h^3)."""
    rise = 6 * 1e-3 * experiment.PUMPED * np.log(experiment.RADII_RATIO) / (np.pi * (20e-6) ** 3)
    monkeypatch.setattr(experiment, "FLUID_PRESSURE", {1: (1e5, 1e5 + rise)})
    computed, reference = experiment.hydraulic_apertures(folder, 1)
    assert reference == pytest.approx(20e-6)
    aperture, dy, dx, _ = experiment.read_specimen(folder, 1)
    (window,) = experiment.parts_of(aperture, dy, dx, cut=1)
    solved = rc.solve_contact(window, contact_modulus=11e9 / 1.7822, mean_pressure=6e6)
    assert 0 < computed < float(solved["gap"].mean())
