"""What it takes to begin: CPU time and modules of imports and of the first map, each in a process of its own.

python benchmarks/imports.py            # printed; a CPU minute
python benchmarks/imports.py --write
"""

import argparse
import os
import resource
import subprocess
import sys
from pathlib import Path
from statistics import median

import pandas as pd

ROOT = Path(__file__).parents[1]
TABLE = Path(__file__).parent / "results/imports.csv"
MAP = """import roughcontact as rc
waves = {"hurst": 0.8, "rms_gradient": 0.1, "longest": 32e-6, "shortest": 4e-6}
rc.evaluate(rc.self_affine_surface((128, 128), 1e-6, **waves), contact_modulus=1e9, mean_pressure=1e6)
"""
WAYS = {
    "numpy": "import numpy",
    "xarray, with pandas": "import xarray",
    "roughcontact": "import roughcontact",
    "roughcontact.evaluation.pipeline": "import roughcontact.evaluation.pipeline",
    "roughcontact.report.panel": "import roughcontact.report.panel",
    "evaluate of 128²": MAP,
}


def cpu_time(code):
    """Return the CPU time (s) of a Python process, all its threads together."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = usage.ru_utime + usage.ru_stime
    subprocess.run([sys.executable, "-c", code], check=True, env=variables())
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime - began


def variables():
    """Return the environment of a job: linear algebra on one thread."""
    return os.environ | {"PYTHONPATH": str(ROOT / "workflow/lib"), "OMP_NUM_THREADS": "1"}


def modules(code):
    """Return how many modules a process has imported."""
    process = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(len(sys.modules))"],
        check=True, env=variables(), capture_output=True, text=True,
    )  # fmt: skip
    return int(process.stdout)


def main(*, write):
    """Print the table, or write it."""
    rows = [(what, median(cpu_time(code) for _ in range(5)), modules(code)) for what, code in WAYS.items()]
    table = pd.DataFrame(rows, columns=["what", "CPU time (s)", "modules"]).round(2)
    if write:
        table.to_csv(TABLE, index=False)
    print(table.to_string(index=False))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--write", action="store_true")
    main(**vars(parser.parse_args()))
