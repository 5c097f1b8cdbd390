"""What is known of the instrument, from the settings, the table and a repeat, reaches the results."""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from small_project import SETTINGS, Project

from roughcontact import InputFileError, read_dataset, self_affine_surface
from roughcontact.io.guards import sha256
from roughcontact.study.crate import write_crate
from roughcontact.study.failures import report_finished
from roughcontact.study.plan import Plan
from roughcontact.study.study import read_study

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
        f"{name}\tmeasured/{name}.npy\tum\t1\t1\t{cells}"
        for name, cells in (("first", "second\t"), ("second", "\t"), ("third", "\t20 nm"))
    ]
    frequency = np.geomspace(1, 1e7, 40)
    phase = 2j * np.pi * frequency * 1e-4
    young = 3e3 + 27e3 * phase / (1 + phase)
    rows = [f"{f:.6g},{e.real:.6g},{e.imag:.6g}" for f, e in zip(frequency, young, strict=True)]
    project.path("measured/dma.csv").write_text("\n".join(["f (Hz),E' (MPa),E'' (MPa)", *rows]) + "\n")
    contact = {"bodies": [{"relaxation": "measured/dma.csv"}, "rigid"], "mean_pressure_uncertainty": 0.05}
    contact |= {key: SETTINGS["contact"][key] for key in ("relative_pressure", "tolerance")}
    project.write(SETTINGS | {"contact": contact, "instrument": {"amplification_z": 0.01}}, table)
    project.last = project.succeed()
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
    sources = ["solver", "discretisation", "window", "instrument", "material", "combined"]
    assert sorted(set(area["source"])) == sorted(sources)
    summary = pd.read_csv(project.path("results/summary.csv"))
    combined = table[(table["source"] == "combined") & (table["quantity"] == "mean_gap")]
    assert combined["lower"].to_numpy() == pytest.approx(summary["mean_gap_lower_m"].to_numpy(), rel=1e-12)


def test_the_results_name_all_that_was_read_and_a_crate_packs_it(project, monkeypatch):
    pytest.importorskip("rocrate")
    monkeypatch.chdir(project.folder)
    read = {path.stem: sha256(path) for path in Path("measured").iterdir()}
    for file, further in (
        ("first/height", "second"),
        ("second/window", "first"),
        ("third/height", None),
        ("third/statistics", "dma"),
    ):
        assert read_dataset(f"results/{file}.nc").attrs.get("further_sha256") == read.get(further), file
    write_crate("results", configuration="settings.yaml")
    copies = [path for path in Path("results/run_inputs/measured").rglob("*") if path.is_file()]
    assert sorted(map(sha256, copies)) == sorted(read.values())
    Path("measured/dma.csv").rename("aside")
    Path("measured/dma.csv").write_bytes(Path("aside").read_bytes() + b"\n")
    with pytest.raises(InputFileError, match=r"dma\.csv: is not the file that the run has read"):
        write_crate("results", configuration="settings.yaml")
    Path("aside").rename("measured/dma.csv")


def test_a_table_that_is_replaced_by_an_older_one_is_read_again(project):
    path = project.path("measured/dma.csv")
    text_before = path.read_text()
    path.write_text(text_before + "\n")
    os.utime(path, (1e9, 1e9))
    assert project.jobs() == {"contact": 3, "panel": 3, "report": 1}
    path.write_text(text_before)
    assert project.jobs() == {}


def test_of_a_table_that_was_replaced_no_result_is_in_a_partial_report(project, monkeypatch):
    monkeypatch.chdir(project.folder)
    plan = Plan(*read_study(yaml.safe_load(Path("settings.yaml").read_text()), ["."], measured_in=["."]))
    assert report_finished(plan) == []
    path, text_before = Path("measured/dma.csv"), Path("measured/dma.csv").read_text()
    path.write_text(text_before + "\n")
    os.utime(path, (1e9, 1e9))
    failures = report_finished(plan)
    path.write_text(text_before)
    assert [(failure["surface"], failure["reason"]) for failure in failures] == [
        (name, "not finished") for name in ("first", "second", "third")
    ]


def test_a_table_that_is_not_there_is_named_before_anything_runs(project):
    path = project.path("measured/dma.csv")
    path.rename(aside := path.with_name("aside"))
    run = project.run()
    aside.rename(path)
    assert run.returncode
    assert "relaxation = measured/dma.csv: " in run.stderr
    assert "Traceback" not in run.stderr


def test_a_repeat_that_changes_is_measured_again_whatever_its_date(project):
    path = project.path("measured/second.npy")
    np.save(path, np.load(path)[::-1])
    os.utime(path, (1e9, 1e9))
    jobs = project.jobs()
    np.save(path, np.load(path)[::-1])
    assert jobs["prepare"] == 2


def test_a_case_that_is_corrected_has_its_own_window_and_says_so(tmp_path, checkout):
    project = Project(tmp_path / "project", checkout)
    project.path("measured").mkdir(parents=True, exist_ok=True)
    waves = {"hurst": 0.8, "shortest": 6e-6, "longest": 32e-6, "rms_gradient": 0.05}
    noise = NOISE * np.random.default_rng(0).standard_normal((64, 64))
    np.save(
        project.path("measured/one.npy"), 1e6 * (self_affine_surface((64, 64), 1e-6, **waves).values + noise)
    )
    cases = {"measured": {}, "corrected": {"instrument": {"correct": True}}}
    settings = SETTINGS | {"uncertainty": {"sources": []}, "instrument": {"noise": NOISE}, "cases": cases}
    project.write(settings, ["surface\tpath\tunit\tdx\tdy", "one\tmeasured/one.npy\tum\t1\t1"])
    project.succeed()
    window, corrected = (
        read_dataset(project.path(f"results/{case}/one/window.nc"))["height"] for case in cases
    )
    assert corrected.attrs["corrected_for"] == "noise of 5.00 nm"
    assert "corrected_for" not in window.attrs
    assert float(corrected.std()) < float(window.std())
    summary = pd.read_csv(project.path("results/summary.csv")).groupby("case")
    assert summary["corrected_for"].first().dropna().to_dict() == {"corrected": "noise of 5.00 nm"}
    gradient = summary["rms_gradient"].first()
    assert gradient["corrected"] < gradient["measured"]
    assert "corrected for noise of 5.00 nm" in project.path("results/report.html").read_text(encoding="utf-8")
    assert project.jobs() == {}
