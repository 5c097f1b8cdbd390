#!/usr/bin/env python3
"""Set up the environment and run: `python3 run.py app` the page of a study, `python3 run.py` the workflow.

`python3 run.py app FOLDER` opens the study in a folder, by default `study`; app.bat and app.command do so by
a double-click. `python3 run.py test` runs the tests.

Needs only Python 3.11 or later. The environment is .venv beside this file; it is installed once, and again
only after pyproject.toml, setup.py or the C source has changed. Further arguments are passed to Snakemake
(`python3 run.py -n`) or, after `test`, to pytest (`python3 run.py test tests/unit`; `python3 run.py test -m
slow` for long tests). `python3 run.py lint` runs only the checks of the source with which `test` begins,
`python3 run.py docs` builds the documentation, `python3 run.py wheels` what a release consists of, to
build/wheels, and `python3 run.py lowest` runs the tests of package and workflow with the lowest versions that
pyproject.toml allows, in .venv-lowest.
"""

import sys

if __name__ == "__main__" and not sys.flags.safe_path:
    del sys.path[0]  # the folder of this file: what lies in it is no module, but perhaps has the name of one

import hashlib
import importlib.util
import os
import shutil
import signal
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
LOWEST = ROOT / ".venv-lowest"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
PACKAGE = ROOT / "workflow/lib/roughcontact"
NO_COMPILER = (
    "There is no C compiler: pip fetches one (ziglang, 100 MB), building the compiled passes, a minute ..."
)
# programs of the checkout, which no wheel has, by the argument that runs them
EVIDENCE = {"validation": "validation", "crosscheck": "validation.crosscheck", "cost": "benchmarks.cost"}
MAX_WORKERS = 4  # of the tests; each of them uses a few hundred megabytes


def main(arguments):
    """Run the job named by the first argument, in an environment that is created if necessary."""
    check_python()
    os.environ["PYTHONSAFEPATH"] = "1"  # of pip and the workflow: nothing in the working folder is code
    jobs = {"test": test, "lint": lint, "docs": docs, "lowest": lowest, "wheels": wheels}
    if arguments and arguments[0] in jobs:
        install("wheels" if arguments[0] == "wheels" else "dev")
        os.chdir(ROOT)
        del os.environ["PYTHONSAFEPATH"]  # tests and benchmarks import what lies beside them
        return jobs[arguments[0]](*arguments[1:])
    install("")
    if arguments and arguments[0] == "app":
        return run([BIN / "roughcontact", "app", *(arguments[1:] or ["study"])])
    if arguments and arguments[0] in EVIDENCE:
        os.environ["PYTHONPATH"] = str(ROOT)
        return run([BIN / "python", "-m", EVIDENCE[arguments[0]], *arguments[1:]])
    return work(*arguments)


def check_python():
    """Exit with a sentence if this Python is too old or cannot create environments."""
    version = f"{sys.version_info[0]}.{sys.version_info[1]}"
    if sys.version_info < (3, 11):  # noqa: UP036 - this file runs before any other check
        sys.exit(f"Python 3.11 or later is needed, this is {version}: try `python3.11 run.py` or later")
    if not (importlib.util.find_spec("venv") and importlib.util.find_spec("ensurepip")):
        sys.exit(
            "This Python cannot create environments. On Debian, Ubuntu: "
            f"`apt install python{version}-venv`;\n"
            "elsewhere use the Python of python.org or of conda. Then run this again."
        )


def install(group):
    """Install the package (editable) and a group of pyproject.toml into .venv, unless installed already."""
    if not (VENV.exists() or os.access(ROOT, os.W_OK)):
        sys.exit(f"{ROOT} is read-only, but .venv is created in it: copy it to a writable folder")
    state = state_of_sources()
    stamps = {name: VENV / f"installed.{name or 'workflow'}" for name in ("", group)}
    current = {name for name, stamp in stamps.items() if stamp.exists() and stamp.read_text() == state}
    if group in current:
        return
    print(f"Installing into {VENV} (a minute or two, once) ...", file=sys.stderr, flush=True)
    if not any(map(shutil.which, (os.environ.get("CC", "").partition(" ")[0], "cc", "gcc", "clang"))):
        print(NO_COMPILER, file=sys.stderr, flush=True)
    pip = [BIN / "python", "-m", "pip", "-qq", "--disable-pip-version-check", "install"]
    steps = [] if current else [[sys.executable, "-m", "venv", "--clear", VENV]]
    wanted = ["--editable", f"{ROOT}[workflow,app{',slurm' if group else ''}]"]  # slurm.sh tests it
    if group:
        steps.append([*pip, "pip>=25.1"])  # the first version with groups
        wanted += ["--group", f"{ROOT / 'pyproject.toml'}:{group}"]
    # with PYTHONDONTWRITEBYTECODE nothing else compiles an editable package
    compiled = [BIN / "python", "-m", "compileall", "-qq", PACKAGE.parent]
    for step in [*steps, [*pip, *wanted], compiled]:
        if run(step):
            sys.exit(f"failed: {' '.join(map(str, step))}")
    for stamp in stamps.values():
        stamp.write_text(state)


def state_of_sources():
    """Return a text that changes with what an installation depends on."""
    sources = sorted((PACKAGE / "kernels/c").glob("*.[ch]"))
    files = [ROOT / "pyproject.toml", ROOT / "setup.py", *sources]
    settings = b"".join(file.read_bytes() for file in files) + sys.version.encode() + str(ROOT).encode()
    return hashlib.sha256(settings).hexdigest()


def work(*arguments):
    """Run the workflow in the working directory."""
    return run([BIN / "roughcontact", "run", *arguments])


def lint():
    """Check format, style, docstrings, types and the order of the folders; return 1 if a check fails."""
    checks = [
        [BIN / "ruff", "format", "--check", "."],
        [BIN / "ruff", "check", "."],
        [
            BIN / "numpydoc",
            "lint",
            *sorted([*PACKAGE.parent.rglob("*.py"), *(ROOT / "validation").glob("*.py")]),
        ],
        [BIN / "mypy"],
        [BIN / "lint-imports", "--no-logo"],
        [BIN / "snakefmt", "--check", "Snakefile", "workflow/Snakefile", "workflow/rules"],
        [BIN / "snakemake", "--lint"],
    ]
    codes = [run(check) for check in checks]  # all of them, even after a failure
    return int(any(codes))


def test(*arguments):
    """Check the source, then run the tests side by side."""
    failed = lint()
    return failed | int(run([BIN / "python", "-m", "pytest", *side_by_side(), *arguments]) != 0)


def side_by_side():
    """Return the options of pytest for as many workers as there are cores, up to a limit."""
    workers = str(min(os.cpu_count() or 1, MAX_WORKERS))
    return ["-n", workers, "--dist", "loadfile", "--no-loadscope-reorder"]


def docs():
    """Build the documentation and print the path of its first page."""
    failed = run([BIN / "sphinx-build", "-W", "--keep-going", "-b", "html", "docs", "build/docs"])
    if not failed:
        print(ROOT / "build/docs/index.html")
    return failed


def wheels(*platforms):
    """Build and check the wheels of the platforms, by default of all, and the source distribution."""
    return run([BIN / "python", "release/wheels.py", *platforms])


def lowest(*arguments):
    """Run the tests of package and workflow with the lowest versions, in an environment of their own."""
    programs = LOWEST / BIN.name
    python = programs / "python"
    wanted = ["--resolution", "lowest-direct", "--editable", f"{ROOT}[workflow,slurm]", "--group", "test"]
    tests = ["tests/unit", "tests/property", "tests/workflow", *side_by_side(), *arguments]
    return (
        run([sys.executable, "-m", "venv", "--clear", LOWEST])
        or run([BIN / "uv", "pip", "install", "--quiet", "--python", python, *wanted])
        or run([python, "-m", "pytest", *tests], programs)
    )


def run(command, programs=BIN):
    """Run a command with an environment's programs first on the path, and return its exit status.

    A termination of this program is handed on to the command, and ends both.
    """
    environment = os.environ | {"PATH": f"{programs}{os.pathsep}{os.environ.get('PATH', '')}"}
    process = subprocess.Popen(command, env=environment)
    terminated = []

    def terminate(*_):
        terminated.append(True)
        process.terminate()

    before = signal.signal(signal.SIGTERM, terminate)
    while True:
        try:
            code = process.wait()
        except KeyboardInterrupt:  # the program was interrupted as well and is closing down
            continue
        signal.signal(signal.SIGTERM, before)
        if terminated:
            sys.exit(128 + signal.SIGTERM)
        return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
