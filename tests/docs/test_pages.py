"""The code blocks of README, CONTRIBUTING and docs run as they stand, page by page, in a scratch folder.

Python blocks are executed, doctests among them compared; `bash` blocks are run, `console` blocks run and what
follows a line `$ command` is compared; YAML blocks are settings, are checked, and are written to the file
that a comment in their first line names, or a job for GitHub Actions, whose commands are run. A block that
cannot run here has `<!-- skip: next "why" -->` before it and is counted below.
"""

import doctest
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from unittest import SkipTest

import pytest
import yaml
from sybil import Sybil
from sybil.evaluators.doctest import OutputChecker
from sybil.parsers.myst import CodeBlockParser, PythonCodeBlockParser, SkipParser

from roughcontact.configuration.resolve import resolve

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "config/README.md")),
    *sorted(p for p in (ROOT / "docs").rglob("*.md") if not {"generated", "api"} & set(p.parts)),
]
LONG = (
    *(f"docs/how-to/{page}.md" for page in ("before-and-after", "install", "studies")),
    "docs/tutorial/index.md",
)
# blocks that do not run here, page by page; the comment before each of them says why
SKIPPED = {
    "README.md": 1,
    "CONTRIBUTING.md": 1,
    "config/README.md": 1,
    "docs/explanation/trust.md": 2,
    "docs/explanation/validation.md": 1,
    "docs/how-to/app.md": 1,
    "docs/how-to/cluster.md": 3,
    "docs/how-to/groups.md": 1,
    "docs/how-to/install.md": 1,
    "docs/how-to/studies.md": 1,
    "docs/tutorial/index.md": 2,
}
OPTIONS = doctest.ELLIPSIS
COMMAND = re.compile(r"\$ |(python3?|pip|snakemake|roughcontact|git|bash) ")


def name_of(page):
    return page.relative_to(ROOT).as_posix()


def shell(command):
    """Run a command of a page and return what it printed on standard output; fail with all it printed."""
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", command], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def run_bash(example):
    shell(example.parsed)


def run_console(example):
    """Run the commands of a block, lines `$ command`, and compare what each prints with what follows it."""
    assert example.parsed.startswith("$ ")
    for part in re.split(r"^\$ ", example.parsed, flags=re.MULTILINE)[1:]:
        command, _, wanted = part.partition("\n")
        got = shell(command)
        if not OutputChecker().check_output(wanted, got, OPTIONS):
            return f"$ {command}\nwanted:\n{wanted}\ngot:\n{got}"
    return None


def run_yaml(example):
    """Take a block with jobs for one of GitHub Actions, all others for settings."""
    (run_job if "\njobs:" in example.parsed else write_settings)(example)


def run_job(example):
    """Run the commands of a job of GitHub Actions, in the folder that it names."""
    (job,) = yaml.safe_load(example.parsed)["jobs"].values()
    folder = job["defaults"]["run"]["working-directory"]
    for step in job["steps"]:
        if "run" in step:
            shell(f"cd {shlex.quote(folder)}\n{step['run']}")


def write_settings(example):
    """Check settings, and write them to the file that the first line of the block names, if it names one."""
    resolve(yaml.safe_load(example.parsed))
    named = re.match(r"# (\S+\.yaml)\n", example.parsed)
    if named:
        Path(named.group(1)).write_text(example.parsed, encoding="utf-8")


def parsed(page):
    """Return the examples of a page."""
    parsers = [
        SkipParser(),
        PythonCodeBlockParser(doctest_optionflags=OPTIONS),
        CodeBlockParser("bash", run_bash),
        CodeBlockParser("console", run_console),
        CodeBlockParser("yaml", run_yaml),
    ]
    return Sybil(parsers).parse(page)


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A copy of the checkout with this environment on the path, as working directory.

    `python3 run.py`, `roughcontact` and `pip` are those of this checkout, in this environment, and install
    nothing: `.ci/run` does that, from nothing.
    """
    for name in ("run.py", "Snakefile", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path)
    for name in ("config", "data_samples"):
        shutil.copytree(ROOT / name, tmp_path / name)
    for name in ("workflow", "benchmarks", "validation"):
        if not (tmp_path / name).exists():
            (tmp_path / name).symlink_to(ROOT / name)
    programs = tmp_path / ".programs"
    programs.mkdir()
    python = shlex.quote(sys.executable)
    start = "import pathlib, run, sys; run.install = lambda *_: None; "
    start += "run.BIN = pathlib.Path(sys.executable).parent; sys.exit(run.main(sys.argv[1:]))"
    start = shlex.quote(start)
    scripts = {
        "python3": f'[ "$1" = run.py ] || exec {python} "$@"\nshift\nexec {python} -c {start} "$@"',
        "roughcontact": f'exec {python} -m roughcontact.command_line "$@"',
        "pip": '[ "$1" = install ]',
    }
    for name, script in scripts.items():
        (programs / name).write_text(f"#!/bin/sh\n{script}\n")
        (programs / name).chmod(0o755)
    path = [str(programs), str(Path(sys.executable).parent), os.environ["PATH"]]
    monkeypatch.setenv("PATH", os.pathsep.join(path))
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "workflow/lib"))
    monkeypatch.chdir(tmp_path)


def page_of(page):
    """Return the parameter of a page; .ci/run runs the blocks of install.md once more, from the wheel."""
    marks = [pytest.mark.slow] if name_of(page) in LONG else []
    return pytest.param(page, id=name_of(page), marks=marks)


@pytest.mark.parametrize("page", [page_of(path) for path in PAGES])
@pytest.mark.usefixtures("checkout")
def test_the_blocks_of_a_page_run(page):
    skipped = []
    for example in parsed(page).examples():
        try:
            example.evaluate()
        except SkipTest as reason:
            skipped.append(str(reason))
    assert len(skipped) == SKIPPED.get(name_of(page), 0)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_no_command_hides_outside_of_a_block_that_runs(page):
    """Commands in indented text, or in fences of another language, would be run by nobody."""
    text = page.read_text(encoding="utf-8")
    fences = re.findall(r"^```(\S*)[^\n]*\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)
    others = [body for language, body in fences if language not in ("bash", "console", "python", "yaml")]
    outside = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    indented = re.findall(r"^    +(.*)", outside, flags=re.MULTILINE)
    lines = [*indented, *(line for body in others for line in body.splitlines())]
    assert [line for line in lines if COMMAND.match(line)] == []


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_relative_links_lead_to_files(page):
    """Sphinx sees those between pages of the site; README and others are read where they lie."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    targets = [link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text)]
    assert [link for link in targets if link and not (page.parent / link).exists()] == []
