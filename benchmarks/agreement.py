"""Solve the same problem with every code to a tight tolerance and print how far the pressures differ.

python benchmarks/agreement.py --sizes 256 512
"""

import argparse
import itertools
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from cases import relative_error, surface
from race import LOADS
from speed import HERE, SCRIPTS
from worker import Worker

TIGHT = {"roughcontact": 1e-10, "ASPHER": 1e-14, "Tamaas": 1e-11}  # each on its own scale


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="*", default=[256, 512], help="points per side")
    parser.add_argument("--seed", type=int, default=0, help="of the random phases")
    parser.add_argument(
        "--rivals", type=Path, default=HERE / ".rivals/bin/python", help="Python that has ASPHER and Tamaas"
    )
    options = parser.parse_args()
    python = str(options.rivals.absolute())
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        workers = {
            code: stack.enter_context(
                Worker(script, python=sys.executable if code == "roughcontact" else python, threads=1)
            )
            for code, script in SCRIPTS.items()
        }
        for size, load in itertools.product(options.sizes, LOADS):
            heights = folder / f"heights_{size}.npy"
            np.save(heights, surface(size, options.seed))
            pressures = {}
            for code, worker in workers.items():
                target = folder / f"{code}.npy"
                worker.ask(heights=str(heights), load=load, tolerance=TIGHT[code], pressure=str(target))
                pressures[code] = np.load(target)
            differences = (
                f"{one} - {other} {relative_error(pressures[one], pressures[other]):.1e}"
                for one, other in itertools.combinations(pressures, 2)
            )
            print(f"{size:5d} {load:6g}  " + "  ".join(differences), flush=True)


if __name__ == "__main__":
    main()
