"""What is known of the instrument, from the settings, the table and a repeat, reaches the results."""

import numpy as np
import pandas as pd
import pytest
from small_project import SETTINGS, Project

from roughcontact.references.synthetic import self_affine_surface
from roughcontact.results.storage import read_dataset

NOISE = 5e-9  # m


@pytest.fixture(scope="module")
def project(tmp_path_factory, checkout):
    """Return a finished project: a map measured twice, and another one."""
    project = Project(tmp_path_factory.mktemp("project"), checkout)
    waves = {"hurst": 0.8, "shortest": 6e-6, "longest": 32e-6, "rms_gradient": 0.05}
    surface = self_affine_surface((64, 64), 1e-6, **waves).values
    generator = np.random.default_rng(0)
    for name in ("first", "second", "third"):
        noise = NOISE * generator.standard_normal(surface.shape)
        np.save(project.path(f"measured/{name}.npy"), 1e6 * (surface + noise))
    table = ["surface\tpath\tunit\tdx\tdy\trepeat_of\tnoise"]
    table += [
        f"{name}\tmeasured/{name}.npy\tum\t1\t1\t{rest}"
        for name, rest in (("first", "second\t"), ("second", "\t"), ("third", "\t20 nm"))
    ]
    contact = SETTINGS["contact"] | {"contact_modulus_uncertainty": 0.05}
    project.write(SETTINGS | {"contact": contact, "instrument": {"amplification_z": 0.01}}, table)
    project.last = project.run()
    assert project.last.returncode == 0, project.last.stderr
    return project


def test_repeats_give_the_noise_of_both(project):
    for name in ("first", "second"):
        attrs = read_dataset(project.path(f"results/{name}/height.nc"))["height"].attrs
        assert attrs["instrument_noise"] == pytest.approx(NOISE, rel=0.05)
    third = read_dataset(project.path("results/third/height.nc"))["height"].attrs
    assert third["instrument_noise"] == pytest.approx(20e-9)


def test_all_sources_are_in_every_table(project):
    table = pd.read_csv(project.path("results/uncertainty.csv"))
    area = table[(table["surface"] == "first") & (table["quantity"] == "relative_contact_area")]
    sources = [
        "solver",
        "discretisation",
        "window",
        "processing",
        "instrument",
        "material",
        "unresolved",
        "combined",
    ]
    assert sorted(set(area["source"])) == sorted(sources)
    summary = pd.read_csv(project.path("results/summary.csv"))
    combined = table[(table["source"] == "combined") & (table["quantity"] == "mean_gap")]
    assert combined["lower"].to_numpy() == pytest.approx(summary["mean_gap_lower_m"].to_numpy(), rel=1e-12)


def test_a_repeat_that_changes_is_measured_again(project):
    path = project.path("measured/second.npy")
    np.save(path, np.load(path)[::-1])
    assert project.jobs()["prepare"] == 2
