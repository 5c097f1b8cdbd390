"""The workflow as a module of somebody else's, and what Snakemake draws without being told of cores."""

import json
import subprocess
import sys

import pandas as pd
import pytest
from small_project import SETTINGS, TABLE, write_maps

OTHER = """
module contact:
    snakefile: "{workflow}/Snakefile"
    config: {settings}
    prefix: "contact"


use rule * from contact as contact_*


rule largest_area:
    default_target: True
    input:
        "contact/results/summary.csv",
        "contact/results/report.html",
    output:
        "largest.txt",
    run:
        import pandas as pd
        largest = pd.read_csv(input[0])["relative_contact_area"].max()
        with open(output[0], "w") as file:
            file.write(str(largest))
"""


def snakemake(folder, *arguments):
    command = [sys.executable, "-m", "snakemake", "--directory", str(folder), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_another_workflow_takes_it_in_with_a_prefix_and_settings_of_its_own(tmp_path, checkout):
    (tmp_path / "measured").mkdir()
    write_maps(tmp_path / "measured")
    (tmp_path / "surfaces.tsv").write_text("\n".join(TABLE[:2]) + "\n")
    settings = SETTINGS | {"uncertainty": {"sources": []}}
    (tmp_path / "Snakefile").write_text(OTHER.format(workflow=checkout / "workflow", settings=settings))
    done = snakemake(tmp_path, "--snakefile", tmp_path / "Snakefile", "--cores", "2")
    assert done.returncode == 0, done.stderr
    summary = pd.read_csv(tmp_path / "contact/results/summary.csv")
    assert list(summary["surface"]) == ["ground", "ground"]
    assert float((tmp_path / "largest.txt").read_text()) == pytest.approx(
        summary["relative_contact_area"].max()
    )
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize("drawing", ["--rulegraph", "--dag", "--filegraph"])
def test_drawings_need_no_number_of_cores(finished, drawing):
    done = snakemake(
        finished.folder,
        "--snakefile",
        finished.checkout / "Snakefile",
        "--configfile",
        finished.path("settings.yaml"),
        drawing,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("digraph")


def test_the_report_of_snakemake_has_each_surface_with_captions_and_labels(finished):
    page = finished.path("snakemake-report.html")
    done = finished.run("--report", page)
    assert done.returncode == 0, done.stderr
    text = page.read_text(encoding="utf-8")
    shown = text[text.index('<script id="categories">') :].partition("</script>")[0]
    categories = json.loads(shown[shown.index("{") : shown.rindex("}") + 1])
    assert list(categories) == ["All surfaces", "ground", "turned"]
    of_ground = [f"results/ground/{name}" for name in ("panel.html", "statistics.nc")]
    assert sorted(path for paths in categories["ground"].values() for path in paths) == of_ground
    assert sum(map(len, categories["All surfaces"].values())) == 3
    for words in (
        "figures and checks",
        "what touches: maps, area and gap against load",
    ):  # a label, a caption
        assert words in text


def test_the_installed_package_has_the_snakefile_for_a_module(tmp_path):
    (tmp_path / "measured").mkdir()
    write_maps(tmp_path / "measured")
    (tmp_path / "surfaces.tsv").write_text("\n".join(TABLE[:2]) + "\n")
    there = 'snakefile: "{workflow}/Snakefile"'
    assert there in OTHER
    named = OTHER.replace(there, "snakefile: str(workflow_file())").format(settings=SETTINGS)
    first = "from roughcontact.command_line.running import workflow_file\n"
    (tmp_path / "Snakefile").write_text(first + named)
    done = snakemake(tmp_path, "--snakefile", tmp_path / "Snakefile", "--dry-run")
    assert done.returncode == 0, done.stderr
    assert "contact/results/ground/statistics.nc" in done.stderr + done.stdout
