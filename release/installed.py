"""Install a wheel or the source distribution as a stranger does, and run a sample to the report.

    python release/installed.py build/wheels/roughcontact-0.1.0.tar.gz
    python release/installed.py --passes build/wheels/...whl

The environment is empty at first and a compiler is not on its path. The compiled passes must be there in the
end: without them the package works, but slowly. Prints sizes and times. With `--passes` that is all: NumPy is
the only dependency that is installed, for platforms where not all dependencies have wheels.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COMPILER = re.compile(r"(.*-)?(cc|gcc|g\+\+|c\+\+|clang|clang\+\+|c89|c99|tcc|zig)(-[\d.]+)?")
SETTINGS = "surfaces: surfaces.tsv\ncontact: {contact_modulus: 1 GPa, relative_pressure: [0.05]}\n"
PASSES = "from roughcontact.kernels.compiled import library; library()"


def main(distribution, *, passes_only):
    """Install into a temporary folder and run there; end with the exit status of what fails."""
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder, "study")
        study.mkdir()
        environment = study.parent / "contact"
        programs = environment / ("Scripts" if os.name == "nt" else "bin")
        variables = {name: value for name, value in os.environ.items() if name not in ("CC", "PYTHONPATH")}
        variables["PATH"] = os.pathsep.join([str(programs), *path_without_compiler(Path(folder, "path"))])
        python = str(programs / "python")

        def run(*command):
            began, before = time.perf_counter(), os.times()
            done = subprocess.run(command, cwd=study, env=variables, check=False)
            if done.returncode:
                sys.exit(f"failed: {' '.join(command)}")
            now = os.times()
            spent = sum(now[2:4]) - sum(before[2:4])
            print(f"{time.perf_counter() - began:6.1f} s, CPU {spent:6.1f} s  {' '.join(command[1:])[:90]}")

        run(sys.executable, "-m", "venv", str(environment))
        pip = (python, "-m", "pip", "-qq", "--disable-pip-version-check", "install")
        file = str(Path(distribution).resolve())
        if passes_only:
            run(*pip, "numpy")
            run(*pip, "--no-deps", file)
            run(python, "-c", PASSES)
            return
        run(*pip, f"{file}[workflow]")
        run(python, "-c", PASSES)
        Path(study, "surfaces.tsv").write_text(
            f"surface\tpath\nperiodic\t{ROOT / 'data_samples/periodic.nc'}\n"
        )
        Path(study, "settings.yaml").write_text(SETTINGS)
        run(python, "-m", "roughcontact.interface", "run", "--configfile", "settings.yaml")
        if not (study / "results/report.html").stat().st_size:
            sys.exit("the report is empty")
        size = sum(path.lstat().st_size for path in environment.rglob("*") if path.is_file())
        print(f"{size / 1e6:.0f} MB in the environment; the report is there")


def path_without_compiler(folder):
    """Return the folders of a path to every program of here but the compilers."""
    if os.name == "nt":  # where links need a right, and the build asks for none but ziglang
        return os.environ["PATH"].split(os.pathsep)
    folder.mkdir()
    for place in map(Path, os.environ["PATH"].split(os.pathsep)):
        for program in place.iterdir() if place.is_dir() else ():
            link = folder / program.name
            if not COMPILER.fullmatch(program.name) and not link.is_symlink():
                link.symlink_to(program)
    return [str(folder)]


if __name__ == "__main__":
    main(sys.argv[-1], passes_only="--passes" in sys.argv)
