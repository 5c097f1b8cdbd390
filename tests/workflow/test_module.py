"""The workflow as a module of somebody else's, and what Snakemake draws without being told of cores."""

import http.server
import json
import os
import re
import shutil
import subprocess
import sys
import threading
from functools import partial

import pandas as pd
import pytest
from small_project import ROOT, TABLE, counted, write_maps

# the target of the other workflow, first as usual, and a rule on what the module has made
TARGET = """
rule all:
    input:
        "largest.txt",


"""
OWN_RULE = """

rule largest_area:
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


def module(source):
    """Return what docs/how-to/install.md has another workflow say to take this one in from `source`.

    The page has the whole text for the installed package, and what takes its place for other sources.
    """
    page = (ROOT / "docs/how-to/install.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"^```text\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    if source in text:
        return text
    (snakefile,) = (code for code in re.findall(r"`([^`\n]+)`", page) if code.startswith(source))
    installed = "from roughcontact import workflow_file\n\n"
    assert text.startswith(installed)
    return text.removeprefix(installed).replace("str(workflow_file())", snakefile)


def snakemake(folder, *arguments, **variables):
    command = [sys.executable, "-m", "snakemake", "--directory", str(folder), *map(str, arguments)]
    environment = os.environ | {name: str(value) for name, value in variables.items()}
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


@pytest.fixture
def host(tmp_path, checkout):
    """A folder for somebody else's workflow, with a map in a table and a checkout of this one."""
    (tmp_path / "measured").mkdir()
    write_maps(tmp_path / "measured")
    (tmp_path / "surfaces.tsv").write_text("\n".join(TABLE[:2]) + "\n")
    (tmp_path / "roughcontact").symlink_to(checkout)
    return tmp_path


def written(folder, text):
    """Write another workflow and return its file."""
    (folder / "Snakefile").write_text(text)
    return folder / "Snakefile"


def run_with_own_rule(folder, text, **variables):
    """Run another workflow to the file of its own rule, and look at what the module has left."""
    process = snakemake(
        folder, "--snakefile", written(folder, TARGET + text + OWN_RULE), "--cores", "2", **variables
    )
    assert process.returncode == 0, process.stderr
    summary = pd.read_csv(folder / "contact/results/summary.csv")
    assert list(summary["surface"]) == ["ground"]
    area = float((folder / "largest.txt").read_text())
    assert area == pytest.approx(summary["relative_contact_area"].max())
    assert not (folder / "results").exists()


@pytest.mark.slow
def test_another_workflow_takes_it_in_with_a_prefix_and_settings_of_its_own(host):
    run_with_own_rule(host, module('"roughcontact/workflow/Snakefile"'))


@pytest.mark.parametrize(
    ("source", "has_own_rule"), [("str(workflow_file())", True), ('"roughcontact/workflow/Snakefile"', False)]
)
def test_the_first_rule_of_the_other_workflow_stays_its_target(host, source, has_own_rule):
    """Where it has none, that is all results of the module."""
    text = TARGET + module(source) + OWN_RULE if has_own_rule else module(source)
    process = snakemake(host, "--snakefile", written(host, text), "--dry-run")
    process.stderr += process.stdout
    expected = dict.fromkeys(["contact_prepare", "contact_contact", "contact_panel", "contact_report"], 1)
    expected |= {"largest_area": 1} if has_own_rule else {"contact_all": 1}
    assert counted(process) == expected


@pytest.fixture
def hosted(tmp_path_factory):
    """The files of this workflow as a host has them, without the package."""
    folder = tmp_path_factory.mktemp("hosted")
    ignore = shutil.ignore_patterns("lib", "__pycache__")
    shutil.copytree(ROOT / "workflow", folder / "workflow", ignore=ignore)
    return folder


@pytest.mark.slow
def test_a_hosted_source_is_fetched_and_runs_with_the_installed_package(host, hosted):
    """Git takes a repository of this computer for the one on the host."""
    tag = re.search(r'tag="(.+?)"', module("github("))[1]
    somebody = ["-c", "user.name=Somebody", "-c", "user.email=somebody@example.org"]
    commit = [*somebody, "commit", "--quiet", "--message", "The workflow"]
    for words in (["init", "--quiet"], ["add", "."], commit, ["tag", tag]):
        subprocess.run(["git", "-C", hosted, *words], check=True)
    variables = {
        "GIT_CONFIG_COUNT": 1,
        "GIT_CONFIG_KEY_0": f"url.{hosted.as_uri()}.insteadOf",
        "GIT_CONFIG_VALUE_0": "https://github.com/OWNER/roughcontact",
        "XDG_CACHE_HOME": hosted / "cache",
    }
    run_with_own_rule(host, module("github("), **variables)
    page = host / "page.html"
    process = snakemake(host, "--snakefile", host / "Snakefile", "--report", page, **variables)
    assert process.returncode == 0, process.stderr
    assert "figures and checks" in page.read_text(encoding="utf-8")


@pytest.fixture
def served(host, hosted):
    """The hosted files on a web server of this computer, which the workflow in `other` names."""
    handler = partial(http.server.SimpleHTTPRequestHandler, directory=hosted)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f'"http://127.0.0.1:{server.server_port}/workflow/Snakefile"'
        (host / "Snakefile").write_text(re.sub(r"github\(.*\)", address, module("github(")))
        yield hosted
        server.shutdown()


@pytest.mark.usefixtures("served")
def test_a_hosted_source_does_a_dry_run_of_all(host):
    process = snakemake(host, "--snakefile", host / "Snakefile", "--dry-run")
    assert process.returncode == 0, process.stderr
    assert "contact/results/ground/statistics.nc" in process.stderr + process.stdout


@pytest.mark.usefixtures("served")
def test_a_hosted_source_needs_the_package(host):
    (host / "roughcontact.py").write_text("")  # what is found in place of the package
    process = snakemake(host, "--snakefile", host / "Snakefile", "--dry-run", PYTHONPATH=host)
    assert process.returncode != 0
    assert "needs the package, which is not installed: pip install 'roughcontact[workflow]'" in process.stderr
    assert "Traceback" not in process.stderr


def test_a_hosted_source_of_another_version_is_refused(host, served):
    with (served / "workflow/scripts/prepare.py").open("a") as script:
        script.write("further = 1\n")
    process = snakemake(host, "--snakefile", host / "Snakefile", "--dry-run")
    assert process.returncode != 0
    assert "is another version than roughcontact" in process.stderr
    assert "(prepare.py differs): pip install" in process.stderr


@pytest.mark.parametrize("drawing", ["--rulegraph", "--dag", "--filegraph"])
def test_drawings_need_no_number_of_cores(finished, drawing):
    process = snakemake(
        finished.folder,
        "--snakefile",
        finished.checkout / "Snakefile",
        "--configfile",
        finished.path("settings.yaml"),
        drawing,
    )
    assert process.returncode == 0, process.stderr
    assert process.stdout.startswith("digraph")


def test_the_report_of_snakemake_has_each_surface_with_captions_and_labels(finished):
    page = finished.path("snakemake-report.html")
    finished.succeed("--report", page)
    text = page.read_text(encoding="utf-8")
    script = text[text.index('<script id="categories">') :].partition("</script>")[0]
    categories = json.loads(script[script.index("{") : script.rindex("}") + 1])
    assert list(categories) == ["All surfaces", "ground", "turned"]
    of_ground = [f"results/ground/{name}" for name in ("panel.html", "statistics.nc")]
    assert sorted(path for paths in categories["ground"].values() for path in paths) == of_ground
    assert sum(map(len, categories["All surfaces"].values())) == 4
    for words in (
        "figures and checks",
        "what touches: maps, area and gap against load",
    ):  # a label, a caption
        assert words in text
