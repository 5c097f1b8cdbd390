"""Write the golden numbers of the sample maps anew: `python tests/golden/make_golden.py`.

Runs the workflow on `data_samples` with the shipped configuration, but elastic and under the same relative
pressures, from sparse to full contact, to an error bound of 1e-8 and without the error budget: the numbers
belong to the surfaces, not to a material or the steps of the solver. A further column is asked
for by its name in the first line of a table. Look at what changed (`git diff tests/golden`) and commit it
together with the change that explains it.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import pandas as pd
import yaml

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[1]
DIGITS = 7
STEEL_ON_STEEL = {"contact_modulus": 1.154e11}
LOADS = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0]
CONVERGED = {"contact": {"tolerance": 1e-8}}
KEYS = {"surfaces": ["surface"], "loads": ["surface", "relative_pressure"]}


def run_samples(folder: Path, **cases: dict) -> dict[str, dict[str, pd.DataFrame]]:
    """Run the workflow on the sample maps in `folder` and return the two tables of each case.

    Parameters
    ----------
    folder : Path
        an empty folder.
    **cases
        name of a case -> settings that differ from the shipped configuration.
    """
    settings = yaml.safe_load((ROOT / "config/config.yaml").read_text())
    settings["uncertainty"]["sources"] = []
    settings["contact"] |= STEEL_ON_STEEL | {
        "bodies": None,
        "mean_pressure": None,
        "relative_pressure": LOADS,
    }
    settings["cases"] = cases
    (folder / "settings.yaml").write_text(yaml.safe_dump(settings))
    command = [sys.executable, "-m", "snakemake", "--snakefile", ROOT / "Snakefile", "--directory", folder]
    command += ["--configfile", folder / "settings.yaml", "--cores", "2", "results/summary.csv"]
    run = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    if run.returncode:
        raise RuntimeError(f"the run on the sample maps failed:\n{run.stderr}")
    summary = pd.read_csv(folder / "results/summary.csv")
    return {case: tables(summary[summary["case"] == case]) for case in cases}


def tables(summary: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the two tables of one case, with the columns of those that are kept."""
    return {
        table: summary[[*KEYS[table], *golden]]
        .drop_duplicates(KEYS[table])
        .set_index(KEYS[table])
        .astype(float)
        for table, golden in read_golden().items()
    }


def read_golden() -> dict[str, pd.DataFrame]:
    """Return the two tables as they are kept."""
    return {table: pd.read_csv(FOLDER / f"{table}.csv", index_col=keys) for table, keys in KEYS.items()}


def main():
    with tempfile.TemporaryDirectory() as folder:
        for table, frame in run_samples(Path(folder), converged=CONVERGED)["converged"].items():
            frame.to_csv(FOLDER / f"{table}.csv", float_format=f"%.{DIGITS}g")


if __name__ == "__main__":
    main()
