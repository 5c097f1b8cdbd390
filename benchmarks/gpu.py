"""Measure the solve on a GPU beside the compiled kernels, and hold its pressures against theirs.

    python benchmarks/gpu.py [--sizes 1024 2048 4096 8192] [--libraries torch cupy] [--threads 1 16] [--write]

Self-affine maps at p' = 0.03 to the default tolerance, all through `solve_contact`: the ways to the device
and back, and labels, are in the times. Median of three to fifteen solves after one that is not timed, all on
one machine. The difference of the pressures, in their root mean square, is that of solutions to 1e-8.
"""

import argparse
import os
import statistics
import time
from functools import partial
from importlib import import_module

import cases
import numpy as np
import pages
import pandas as pd

import roughcontact as rc
from roughcontact.arguments.maps import height_map

LOAD = 0.03
TIGHT = 1e-8  # tolerance of the solutions that are compared
BUDGET = 12.0  # seconds of repeats for each size and code
LEAST, MOST = 3, 15  # repeats


def device_of(library: str):
    """Return the function that brings an array of NumPy to the GPU by a library, and the name of the GPU."""
    module = import_module(library)
    if library == "torch":
        return partial(module.asarray, device="cuda"), module.cuda.get_device_name()
    return module.asarray, module.cuda.runtime.getDeviceProperties(0)["name"].decode()


def solve(window, **options):
    """Return the contact at one load, and the seconds that it took."""
    start = time.perf_counter()
    contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=LOAD, **options)
    return contact, time.perf_counter() - start


def timed(window, **options) -> tuple[float, float]:
    """Return the median of the seconds of a solve, and its error bound."""
    solve(window, **options)
    seconds = []
    while len(seconds) < LEAST or (len(seconds) < MOST and sum(seconds) < BUDGET):
        contact, elapsed = solve(window, **options)
        seconds.append(elapsed)
    return statistics.median(seconds), contact["error_bound"].item()


def measure(size: int, ways: dict, reference: str) -> dict:
    """Return the times of all ways to solve a map of `size`² points, compared with the `reference`."""
    window = height_map(cases.surface(size), 1 / size, unit="m")
    exact = solve(window, tolerance=TIGHT, **ways[reference])[0]["pressure"].values
    row, differences, bounds = {"points per side": size}, [], []
    for name, options in ways.items():
        seconds, bound = timed(window, **options)
        row[f"{name} (ms)"] = f"{1e3 * seconds:.0f}"
        bounds.append(bound)
        if "arrays" in options:
            pressure = solve(window, tolerance=TIGHT, **options)[0]["pressure"].values
            differences.append(np.sqrt(np.mean((pressure - exact) ** 2) / np.mean(exact**2)))
    row |= {"difference of pressures": f"{max(differences):.1e}", "error bound": f"{max(bounds):.1e}"}
    print(row, flush=True)
    return row


def main() -> None:
    """Measure all sizes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[1024, 2048, 4096, 8192])
    parser.add_argument("--libraries", nargs="+", default=["torch", "cupy"])
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 16])
    parser.add_argument("--write", action="store_true", help="write the table and the pages that show it")
    options = parser.parse_args()
    ways = {f"C, {count} thread{'s'[: count > 1]}": {"threads": count} for count in options.threads}
    reference = list(ways)[-1]
    about = {"cores": os.cpu_count()}
    for library in options.libraries:
        arrays, about["GPU"] = device_of(library)
        about[library] = import_module(library).__version__
        ways[library] = {"arrays": arrays, "threads": max(options.threads)}
    table = pd.DataFrame([measure(size, ways, reference) for size in options.sizes])
    print(about, table.to_string(index=False), sep="\n")
    if options.write:
        pages.publish("gpu", {"solve": table}, about)


if __name__ == "__main__":
    main()
