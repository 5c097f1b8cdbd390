"""The code blocks of README, CONTRIBUTING and docs run as they stand, page by page, in a scratch folder.

A page is read in one terminal, whose folder and variables stay from block to block, for Python too. Of the
optional packages there are those that the page installs. Python blocks are executed, doctests among them
compared; `bash` blocks are run, `console` blocks run and what follows a line `$ command` is compared; YAML
blocks are settings, are checked, and are written to the file that a comment in their first line names, or a
job for GitHub Actions, whose commands are run where it begins. A block that cannot run here has `<!-- skip:
next "why" -->` before it and is counted below.
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

from roughcontact.arguments.settings.resolve import resolve

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
    "README.md": 2,
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
# every Python of a page begins with this: packages of extras, by the words that install them
HIDDEN = """\
import sys
from pathlib import Path
asked_for = Path(__file__).with_name("asked-for").read_text()
for name, extra in {"rocrate": "crate", "starlette": "app", "uvicorn": "app"}.items():
    if name not in asked_for and extra not in asked_for:
        sys.modules[name] = None
"""
COMMAND = re.compile(r"\$ |(python3?|pip|snakemake|roughcontact|git|bash) ")


def name_of(page):
    return page.relative_to(ROOT).as_posix()


class Terminal:
    """The shell in which a reader runs the blocks of a page, begun in the working directory."""

    def __init__(self):
        self.home, self.printed = Path.cwd(), Path(".printed").absolute()
        self.bash = subprocess.Popen(
            ["bash", "-euo", "pipefail"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, command):
        """Run a command and return what it printed on standard output; fail with all it printed.

        Python follows into the folder where the shell then is.
        """
        printed = shlex.quote(str(self.printed))
        block = f"{{\n{command}\n}} </dev/null >{printed} 2>{printed}.errors\npwd"
        print(block, file=self.bash.stdin, flush=True)
        folder = self.bash.stdout.readline().rstrip("\n")  # nothing where a command has failed
        output = self.printed.read_text(encoding="utf-8")
        assert folder, f"{command}\n{output}\n{self.printed.with_suffix('.errors').read_text()}"
        os.chdir(folder)
        return output

    def run_bash(self, example):
        self.run(example.parsed)

    def run_console(self, example):
        """Run the commands of a block, lines `$ command`, and compare what each prints with what follows."""
        assert example.parsed.startswith("$ ")
        for part in re.split(r"^\$ ", example.parsed, flags=re.MULTILINE)[1:]:
            command, _, expected = part.partition("\n")
            got = self.run(command)
            if not OutputChecker().check_output(expected, got, OPTIONS):
                return f"$ {command}\nwanted:\n{expected}\ngot:\n{got}"
        return None

    def run_yaml(self, example):
        """Take a block with jobs for one of GitHub Actions, all others for settings."""
        (self.run_job if "\njobs:" in example.parsed else write_settings)(example)

    def run_job(self, example):
        """Run the commands of a job of GitHub Actions, in the folder that it names."""
        (job,) = yaml.safe_load(example.parsed)["jobs"].values()
        folder = shlex.quote(str(self.home / job["defaults"]["run"]["working-directory"]))
        for step in job["steps"]:
            if "run" in step:
                self.run(f"(cd {folder}\n{step['run']}\n)")


def write_settings(example):
    """Check settings, and write them to the file that the first line of the block names, if it names one."""
    resolve(yaml.safe_load(example.parsed))
    named = re.match(r"# (\S+\.yaml)\n", example.parsed)
    if named:
        Path(named.group(1)).write_text(example.parsed, encoding="utf-8")


def parsed(page, terminal):
    """Return the examples of a page, for a terminal."""
    parsers = [
        SkipParser(),
        PythonCodeBlockParser(doctest_optionflags=OPTIONS),
        CodeBlockParser("bash", terminal.run_bash),
        CodeBlockParser("console", terminal.run_console),
        CodeBlockParser("yaml", terminal.run_yaml),
    ]
    return Sybil(parsers).parse(page)


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A copy of the checkout with this environment on the path, as working directory.

    `python3 run.py`, `roughcontact` and `pip` are those of this checkout, in this environment, and install
    nothing: `.ci/run` does that, from nothing. Optional packages that `pip` was not asked for are hidden.
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
        "roughcontact": f'exec {python} -m roughcontact.interface "$@"',
        "pip": f'[ "$1" = install ]\necho "$@" >> {shlex.quote(str(programs / "asked-for"))}',
    }
    (programs / "asked-for").touch()
    (programs / "sitecustomize.py").write_text(HIDDEN, encoding="utf-8")
    for name, script in scripts.items():
        (programs / name).write_text(f"#!/bin/sh\n{script}\n")
        (programs / name).chmod(0o755)
    path = [str(programs), str(Path(sys.executable).parent), os.environ["PATH"]]
    monkeypatch.setenv("PATH", os.pathsep.join(path))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(programs), str(ROOT / "workflow/lib")]))
    monkeypatch.chdir(tmp_path)


def page_of(page):
    """Return the parameter of a page; .ci/run runs the blocks of install.md once more, from the wheel."""
    marks = [pytest.mark.slow] if name_of(page) in LONG else []
    return pytest.param(page, id=name_of(page), marks=marks)


@pytest.mark.parametrize("page", [page_of(path) for path in PAGES])
@pytest.mark.usefixtures("checkout")
def test_the_blocks_of_a_page_run(page):
    skipped = []
    for example in parsed(page, Terminal()).examples():
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
    foreign_fences = [
        body for language, body in fences if language not in ("bash", "console", "python", "yaml")
    ]
    outside = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    indented = re.findall(r"^    +(.*)", outside, flags=re.MULTILINE)
    lines = [*indented, *(line for body in foreign_fences for line in body.splitlines())]
    assert [line for line in lines if COMMAND.match(line)] == []


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_relative_links_lead_to_files(page):
    """Sphinx sees those between pages of the site; README and others are read where they lie."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    targets = [link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text)]
    assert [link for link in targets if link and not (page.parent / link).exists()] == []
