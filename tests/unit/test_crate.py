"""A finished run described as an RO-Crate."""

import json
import os
import sys
from pathlib import Path

import pytest
import xarray as xr
import yaml

from roughcontact.errors import InputFileError
from roughcontact.interface.program import main
from roughcontact.io.guards import sha256
from roughcontact.results.storage import provenance, write_dataset, write_text
from roughcontact.study.crate import write_crate
from roughcontact.study.inputs import copy_inputs
from roughcontact.study.plan import Plan
from roughcontact.study.study import read_study

NEWEST = 1_700_000_000  # 2023-11-14 22:13:20 UTC, as `date -u -d @1700000000` says
SHA = "ab" * 32
SETTINGS = {"contact": {"tolerance": 1e-4}}


@pytest.fixture
def results(tmp_path):
    """Return the folder of a run of one surface, its newest file with a known time."""
    folder = tmp_path / "results"
    height = xr.DataArray([[0.0, 1e-6]], dims=("y", "x"), name="height")
    height.attrs = {"source_file": "my ground.x3p", "source_sha256": SHA, "source_format": "X3P"}
    attrs = provenance(SETTINGS, source_sha256=SHA, stage="height", subject="ground")
    write_dataset(height.to_dataset().assign_attrs(attrs), folder / "ground/height.nc")
    statistics = xr.Dataset({"mean_gap": ("load", [2e-7])})
    write_dataset(statistics.assign_attrs(provenance(SETTINGS, stage="statistics")), folder / "statistics.nc")
    write_text("<!doctype html>", folder / "report.html")
    write_text("", folder / ".hidden/scratch.csv")
    for age, path in enumerate(sorted(folder.rglob("*.*"))):
        os.utime(path, (NEWEST - age, NEWEST - age))
    os.utime(folder / "report.html", (NEWEST, NEWEST))
    return folder


def described(folder, **options):
    """Return what the crate says, by identifier."""
    crate = json.loads(write_crate(folder, **options).read_text(encoding="utf-8"))
    return {entity["@id"]: entity for entity in crate["@graph"]}


def test_the_crate_names_files_sources_settings_and_program(results):
    pytest.importorskip("rocrate")
    entities = described(results, terms="https://creativecommons.org/licenses/by/4.0/")
    root, run = entities["./"], entities["#run"]
    assert [part["@id"] for part in root["hasPart"]] == ["ground/height.nc", "report.html", "statistics.nc"]
    assert [part["@id"] for part in run["result"]] == ["ground/height.nc", "report.html", "statistics.nc"]
    assert entities["ground/height.nc"]["name"] == "Heights as measured: ground"
    assert entities["report.html"]["encodingFormat"] == "text/html"
    assert entities["report.html"]["contentSize"] == "15"
    assert root["license"] == {"@id": "https://creativecommons.org/licenses/by/4.0/"}
    assert root["license"]["@id"] in entities
    assert root["datePublished"] == run["endTime"] == "2023-11-14T22:13:20+00:00"
    measured, settings = (entities[entity["@id"]] for entity in run["object"])
    assert (measured["name"], measured["sha256"]) == ("my ground.x3p", SHA)
    assert json.loads(settings["value"]) == SETTINGS
    program = entities[run["instrument"]["@id"]]
    attrs = provenance(SETTINGS)
    version = json.loads(attrs["versions"])["roughcontact"]
    commit = attrs.get("commit")
    assert program["softwareVersion"] == (f"{version}, commit {commit}" if commit else version)
    packages = {entities[entity["@id"]]["name"] for entity in program["softwareRequirements"]}
    assert {"numpy", "scipy", "netCDF4", "python"} <= packages
    assert root["conformsTo"]["@id"] == "https://w3id.org/ro/wfrun/process/0.5"


def test_a_result_of_an_earlier_table_does_not_go_into_the_crate(results):
    pytest.importorskip("rocrate")
    write_text("", results / "hard/ground/panel.html")
    bands = {"bands": json.dumps({"hard": {"ground": {}}})}
    attrs = provenance(SETTINGS, stage="statistics")
    write_dataset(xr.Dataset({"mean_gap": ("load", [2e-7])}, attrs=attrs | bands), results / "statistics.nc")
    assert "hard/ground/panel.html" in described(results)
    write_text("", results / "soft/ground/panel.html")
    with pytest.raises(InputFileError, match="soft/ground: is of an earlier run, "):
        write_crate(results)


CONTACT = {"bodies": [{"relaxation": "dma.csv"}, "rigid"], "mean_pressure": ["5 MPa"]}


@pytest.fixture
def run(results, monkeypatch):
    """A function that copies the inputs of a run, of which some may have changed since; and their folder."""
    study = results.parent
    monkeypatch.chdir(study)
    for name in ("a.npy", "b.npy"):
        (study / name).write_text(name)
    for factor, name in enumerate(("dma.csv", "id_rsa"), start=1):
        rows = [f"{10**k:g},{factor * (3 + 2 * k)},{0.5 + k}" for k in range(6)]
        (study / name).write_text("\n".join(["f (Hz),E' (MPa),E'' (MPa)", *rows]))
    config = {"surfaces": "t.tsv", "contact": CONTACT}
    table = "surface\tpath\tunit\na\ta.npy\tum\n"
    (study / "t.tsv").write_text(table)
    plan = Plan(*read_study(config, ["."], measured_in=["."]))
    attrs = provenance(plan.settings("statistics", "a"), stage="statistics")
    write_dataset(xr.Dataset({"mean_gap": ("load", [2e-7])}, attrs=attrs), results / "a/statistics.nc")

    def copy(read=("a.npy", "dma.csv"), table=table, **changed):
        (study / "c.yaml").write_text(yaml.safe_dump(config | changed))
        (study / "t.tsv").write_text(table)
        return copy_inputs(Path("results"), Path("c.yaml"), {sha256(Path(name)) for name in read})

    return copy, results / "run_inputs"


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (
            {"contact": CONTACT | {"bodies": [{"relaxation": "id_rsa"}, "rigid"]}},
            "a: its settings, or its row, have changed",
        ),
        ({"contact": CONTACT | {"mean_pressure": ["50 MPa"]}}, "a: its settings, or its"),
        ({"table": "surface\tpath\tunit\na\ta.npy\tnm\n"}, "a: its settings, or its row, have changed"),
        ({"table": "surface\tpath\tunit\na\tb.npy\tum\n"}, "b.npy: is not the file that the run has read"),
        ({"table": "surface\tpath\tunit\na\tid_rsa\tum\n"}, "id_rsa: is not the file that the run has"),
        ({"read": ("a.npy",)}, "dma.csv: is not the file that the run has read; repeat the run first"),
    ],
)
def test_a_crate_packs_what_the_run_has_read_as_it_has_read_it(run, changed, words):
    copy, packed = run
    config = copy()
    assert yaml.safe_load(config.read_text())["contact"]["mean_pressure"] == ["5 MPa"]
    assert sorted(path.name for path in packed.glob("measured/*/*")) == ["a.npy", "dma.csv"]
    with pytest.raises(InputFileError, match=words):
        copy(**changed)
    assert not list(packed.rglob("id_rsa"))


def test_what_a_run_has_read_is_found_beside_a_link_to_its_results(run, tmp_path_factory):
    """Results may lie on a disk for large files."""
    copy, packed = run
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "results"
    Path("results").rename(elsewhere)
    Path("results").symlink_to(elsewhere)
    copy()
    assert sorted(path.name for path in packed.glob("measured/*/*")) == ["a.npy", "dma.csv"]


@pytest.mark.parametrize("name", ["run_inputs", "ground/panel.html", "key.txt"])
def test_a_link_to_elsewhere_goes_into_no_crate(results, tmp_path, name):
    """What copies or packs the folder would follow it."""
    pytest.importorskip("rocrate")
    (tmp_path / "elsewhere").mkdir()
    (results / name).unlink(missing_ok=True)
    (results / name).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputFileError, match=f"{name}: is a link, whose target an archive would hold"):
        write_crate(results, configuration=tmp_path / "c.yaml")
    assert not list((tmp_path / "elsewhere").iterdir())


def test_the_crate_says_whose_it_is(results):
    pytest.importorskip("rocrate")
    address = "https://orcid.org/0000-0002-1825-0097"
    entities = described(results, author=f"Ada Example <{address}>", publisher="Institute of Examples")
    assert entities["./"]["author"] == entities["#run"]["agent"] == {"@id": address}
    assert entities[address] == {"@id": address, "@type": "Person", "name": "Ada Example"}
    organisation = entities[entities["./"]["publisher"]["@id"]]
    assert (organisation["@type"], organisation["name"]) == ("Organization", "Institute of Examples")
    assert organisation["@id"] == "#Institute-of-Examples"
    assert not {"author", "publisher"} & set(described(results)["./"])


def test_a_second_crate_of_the_same_files_is_the_first_one(results):
    rocrate = pytest.importorskip("rocrate.rocrate")
    first_crate = write_crate(results).read_bytes()
    assert write_crate(results).read_bytes() == first_crate
    read = rocrate.ROCrate(results)  # by the library that others read it with
    assert {entity.id for entity in read.data_entities} == {
        "ground/height.nc",
        "report.html",
        "statistics.nc",
    }


def test_results_of_two_commits_have_two_programs(results):
    pytest.importorskip("rocrate")
    attrs = provenance(SETTINGS, stage="window", subject="ground") | {"commit": "0" * 40}
    write_dataset(
        xr.Dataset({"mean_gap": ("load", [2e-7])}).assign_attrs(attrs), results / "ground/window.nc"
    )
    programs = described(results)["#run"]["instrument"]
    assert len(programs) == 2
    assert any(program["@id"].endswith("0" * 40) for program in programs)


def test_the_command_says_where_it_is_or_what_is_missing(results, tmp_path, monkeypatch, capsys):
    assert main(["crate", str(tmp_path)]) == 2
    assert capsys.readouterr().err == (
        f"roughcontact: {tmp_path}: no statistics.nc is in it; name the folder of a finished run\n"
    )
    with monkeypatch.context() as patched:
        patched.setitem(sys.modules, "rocrate", None)  # as if it were not installed
        assert main(["crate", str(results)]) == 2
    assert "pip install 'roughcontact[crate]'" in capsys.readouterr().err
    pytest.importorskip("rocrate")
    assert main(["crate", str(results), "--license", "CC0", "--author", "Ada Example"]) == 0
    assert capsys.readouterr().out == f"{results / 'ro-crate-metadata.json'}\n"
    assert '"name": "Ada Example"' in (results / "ro-crate-metadata.json").read_text(encoding="utf-8")
