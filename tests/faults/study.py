"""A small study with a report, and the command that runs it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import yaml

from roughcontact.surface.synthetic import self_affine_surface

ROOT = Path(__file__).parents[2]
SETTINGS = {
    "surfaces": "surfaces.tsv",
    "contact": {"contact_modulus": 1e9, "relative_pressure": [0.05, 0.2]},
    "uncertainty": {"sources": ["solver"]},
}
CASES = {"base": {}, "fine": {"statistics": {"gap_bins": 30}}}


def write_study(folder: Path, *, sides: tuple[int, ...] = (40, 48), cases: bool = True) -> None:
    """Write maps of so many points along their sides, a table and settings."""
    (folder / "measured").mkdir(parents=True)
    band = {"hurst": 0.8, "shortest": 8, "longest": 24, "rms_gradient": 0.1}
    rows = ["surface\tpath\tunit\tdx\tdy"]
    for number, side in enumerate(sides, 1):
        heights = self_affine_surface((side, side), 1.0, **band, seed=number).values
        np.save(folder / f"measured/{number}.npy", heights)
        rows.append(f"surface-{number}\tmeasured/{number}.npy\tum\t1\t1")
    (folder / "surfaces.tsv").write_text("\n".join(rows) + "\n")
    write_settings(folder, SETTINGS | ({"cases": CASES} if cases else {}))


def write_settings(folder: Path, settings: dict) -> None:
    """Write the configuration of the study."""
    (folder / "settings.yaml").write_text(yaml.safe_dump(settings, sort_keys=False))


def command(folder: Path, *arguments: str) -> list[str]:
    """Return the command that runs the study; to be started with `environment()`."""
    words = [sys.executable, "-m", "roughcontact.interface", "run", *arguments, "--cores", "2"]
    return [*words, "--directory", str(folder), "--configfile", str(folder / "settings.yaml")]


def environment(**extra: str) -> dict[str, str]:
    """Return the variables that `command` needs."""
    return os.environ | {"PYTHONPATH": str(ROOT / "workflow/lib"), "OMP_NUM_THREADS": "1"} | extra


def begin(words: list[str], log: Path, **options) -> subprocess.Popen:
    """Return a command of the study at work, in a session of its own, what it says in a file."""
    with log.open("w") as output:  # a pipe that nobody reads would stop the run
        options = {"stdout": output, "stderr": output, "start_new_session": True} | options
        return subprocess.Popen(words, env=environment(), **options)


def start_again(folder: Path) -> None:
    """Remove what runs have left."""
    for name in ("results", "logs", ".snakemake"):
        shutil.rmtree(folder / name, ignore_errors=True)


def results(folder: Path) -> dict[str, bytes]:
    """Return the content of every result, hidden files left out."""
    paths = (path for path in (folder / "results").rglob("*") if path.is_file())
    return {
        str(path.relative_to(folder)): path.read_bytes() for path in paths if not path.name.startswith(".")
    }
