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
from small_project import ROOT, TABLE, write_maps

# a rule of the other workflow, on what the module has made
OWN_RULE = """

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
def other(tmp_path, checkout):
    """A folder for somebody else's workflow, with a map in a table and a checkout of this one."""
    (tmp_path / "measured").mkdir()
    write_maps(tmp_path / "measured")
    (tmp_path / "surfaces.tsv").write_text("\n".join(TABLE[:2]) + "\n")
    (tmp_path / "roughcontact").symlink_to(checkout)
    return tmp_path


def run_with_own_rule(folder, text, **variables):
    """Run another workflow to the file of its own rule, and look at what the module has left."""
    (folder / "Snakefile").write_text(text + OWN_RULE)
    done = snakemake(folder, "--snakefile", folder / "Snakefile", "--cores", "2", **variables)
    assert done.returncode == 0, done.stderr
    summary = pd.read_csv(folder / "contact/results/summary.csv")
    assert list(summary["surface"]) == ["ground"]
    area = float((folder / "largest.txt").read_text())
    assert area == pytest.approx(summary["relative_contact_area"].max())
    assert not (folder / "results").exists()


@pytest.mark.slow
def test_another_workflow_takes_it_in_with_a_prefix_and_settings_of_its_own(other):
    run_with_own_rule(other, module('"roughcontact/workflow/Snakefile"'))


def test_the_installed_package_has_the_snakefile_for_a_module(other):
    (other / "Snakefile").write_text(module("str(workflow_file())"))
    done = snakemake(other, "--snakefile", other / "Snakefile", "--dry-run")
    assert done.returncode == 0, done.stderr
    assert "contact/results/ground/statistics.nc" in done.stderr + done.stdout


@pytest.fixture
def hosted(tmp_path_factory):
    """The files of this workflow as a host has them, without the package."""
    folder = tmp_path_factory.mktemp("hosted")
    left_out = shutil.ignore_patterns("lib", "__pycache__")
    shutil.copytree(ROOT / "workflow", folder / "workflow", ignore=left_out)
    return folder


@pytest.mark.slow
def test_a_hosted_source_is_fetched_and_runs_with_the_installed_package(other, hosted):
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
    run_with_own_rule(other, module("github("), **variables)
    page = other / "page.html"
    done = snakemake(other, "--snakefile", other / "Snakefile", "--report", page, **variables)
    assert done.returncode == 0, done.stderr
    assert "figures and checks" in page.read_text(encoding="utf-8")


@pytest.fixture
def served(other, hosted):
    """The hosted files on a web server of this computer, which the workflow in `other` names."""
    handler = partial(http.server.SimpleHTTPRequestHandler, directory=hosted)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        address = f'"http://127.0.0.1:{server.server_port}/workflow/Snakefile"'
        (other / "Snakefile").write_text(re.sub(r"github\(.*\)", address, module("github(")))
        yield hosted
        server.shutdown()


@pytest.mark.usefixtures("served")
def test_a_hosted_source_does_a_dry_run_of_all(other):
    done = snakemake(other, "--snakefile", other / "Snakefile", "--dry-run")
    assert done.returncode == 0, done.stderr
    assert "contact/results/ground/statistics.nc" in done.stderr + done.stdout


@pytest.mark.usefixtures("served")
def test_a_hosted_source_needs_the_package(other):
    (other / "roughcontact.py").write_text("")  # what is found in place of the package
    done = snakemake(other, "--snakefile", other / "Snakefile", "--dry-run", PYTHONPATH=other)
    assert done.returncode != 0
    assert "needs the package, which is not installed: pip install 'roughcontact[workflow]'" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_hosted_source_of_another_version_is_refused(other, served):
    with (served / "workflow/scripts/prepare.py").open("a") as script:
        script.write("further = 1\n")
    done = snakemake(other, "--snakefile", other / "Snakefile", "--dry-run")
    assert done.returncode != 0
    assert "is another version than roughcontact" in done.stderr
    assert "(prepare.py differs): pip install" in done.stderr


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
    assert sum(map(len, categories["All surfaces"].values())) == 4
    for words in (
        "figures and checks",
        "what touches: maps, area and gap against load",
    ):  # a label, a caption
        assert words in text
