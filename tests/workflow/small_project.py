"""A small project to run the workflow in: two maps, a table and settings, in a folder of its own."""

import csv
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import yaml

from roughcontact.surface.synthetic import self_affine_surface

ROOT = Path(__file__).parents[2]
SETTINGS = {
    "surfaces": "surfaces.tsv",
    "contact": {"contact_modulus": "1e9", "relative_pressure": [0.05, 0.2], "tolerance": "1e-6"},
}
QUICK = SETTINGS | {"uncertainty": {"sources": []}}
# as `roughcontact run` does
FORKS = ("--executor", "roughcontact", "--scheduler", "greedy") if sys.platform == "linux" else ()
TABLE = (
    "surface\tpath\tunit\tdx\tdy",
    "ground\tmeasured/ground.npy\tum\t2\t1",
    "turned\tmeasured/turned.txt\tum\t1\t1",
)


class Project:
    """A folder with measured maps, a table and settings, in which the workflow is run."""

    def __init__(self, folder: Path, checkout: Path):
        self.folder, self.checkout = folder, checkout
        (folder / "measured").mkdir(parents=True, exist_ok=True)

    def write(self, settings=SETTINGS, table=TABLE):
        """Write the settings and the table of surfaces."""
        self.settings = settings
        (self.folder / "settings.yaml").write_text(yaml.safe_dump(settings, sort_keys=False))
        (self.folder / "surfaces.tsv").write_text("\n".join(table) + "\n")

    def command(self, *arguments):
        """Return the command that runs the workflow here, from any folder."""
        options = ["--directory", self.folder, "--configfile", self.folder / "settings.yaml"]
        words = [sys.executable, "-m", "snakemake", "--snakefile", self.checkout / "Snakefile", *options]
        return [str(word) for word in (*words, "--cores", "2", *arguments)]

    def run(self, *arguments) -> subprocess.CompletedProcess:
        """Run the workflow; the result's `stderr` is all that was said."""
        run = subprocess.run(self.command(*arguments), capture_output=True, text=True, check=False)
        run.stderr += run.stdout
        return run

    def succeed(self, *arguments) -> subprocess.CompletedProcess:
        """Run the workflow to its end, without an error."""
        run = self.run(*FORKS, *arguments)
        assert run.returncode == 0, run.stderr
        return run

    def start(self, *arguments, **options) -> psutil.Popen:
        """Start the workflow and return its process; what it says goes to the file `said`."""
        with self.path("said").open("w") as output:
            return psutil.Popen(self.command(*arguments), stdout=output, stderr=output, **options)

    def wait_for(self, run, condition):
        """Return the first value of a function that is true, while a run is at work."""
        while not (value := condition()):
            assert run.poll() is None, self.path("said").read_text()
            time.sleep(0.002)
        return value

    def jobs(self, *arguments) -> dict[str, int]:
        """Return how many jobs of each rule a run would have, the final target left out."""
        return counted(self.run("--dry-run", *arguments))

    def path(self, name: str) -> Path:
        """Return the path of a file of this folder."""
        return self.folder / name

    def rows(self, name: str) -> list[dict[str, str]]:
        """Return the rows of a table of the results."""
        with self.path(f"results/{name}").open(newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))


def counted(run) -> dict[str, int]:
    """Return the jobs of each rule as a run announced them, the final target left out."""
    assert run.returncode == 0, run.stderr
    _, _, table = run.stderr.partition("Job stats:\n")
    rows = re.findall(r"^([\w-]+) +(\d+)$", table.partition("\n\n")[0], re.MULTILINE)
    return {rule: int(count) for rule, count in rows if rule not in ("all", "default", "total")}


def write_maps(folder: Path):
    """Write two small measured maps in micrometres: an array of NumPy, and a matrix in text."""
    parameters = {"hurst": 0.8, "shortest": 8, "longest": 32, "rms_gradient": 0.1}
    ground, turned = (self_affine_surface((64, 64), 1.0, **parameters, seed=seed).values for seed in (1, 2))
    np.save(folder / "ground.npy", ground)
    np.savetxt(folder / "turned.txt", turned, fmt="%.6g")


def project_with_maps(folder, checkout, settings=SETTINGS, table=TABLE):
    """A project with two maps, table and settings in which nothing has run."""
    project = Project(folder, checkout)
    write_maps(project.path("measured"))
    project.write(settings, table)
    return project


def project_of_cases(folder, checkout, contact, cases):
    """A project of one map without a ±, under cases that differ in what follows the contact."""
    return project_with_maps(folder, checkout, QUICK | {"contact": contact, "cases": cases}, TABLE[:2])
