"""Does a part of a window show as well as all of it what the pixel size leaves open?

    python benchmarks/part.py --number 48

Made maps of 512 x 512 points, whose truth is the solution with pixels a quarter as large. Prints in how many
of them the interval holds the truth at each load: that from the whole map, and from a part of half the sides.
"""

import argparse
import itertools
import json

import numpy as np

import roughcontact as rc
from roughcontact.maps import refined
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.uncertainty import discretisation
from roughcontact.uncertainty.headline import QUANTITIES, headline

SIZE = 512
SPECTRA = list(itertools.product((0.3, 0.8), (SIZE, SIZE / 8), (2.5, 4.0, 16.0)))  # Hurst, longest, shortest
PROBLEM = {"contact_modulus": 1e9, "mean_pressure": [1e6, 5e6, 2e7], "threads": 1}
MOST_POINTS = {"whole": SIZE**2, "part": SIZE**2 // 4}


def held(seed: int) -> dict[str, dict[str, np.ndarray]]:
    """Return whether the intervals of one map hold the truth at each load."""
    hurst, longest, shortest = SPECTRA[seed % len(SPECTRA)]
    lengths = {"longest": longest * 1e-6, "shortest": shortest * 1e-6}
    window = self_affine_surface((SIZE, SIZE), 1e-6, hurst=hurst, rms_gradient=0.1, seed=seed, **lengths)
    solved = rc.solve_contact(window, **PROBLEM, reduce=discretisation.grid_marks)
    truth = rc.solve_contact(refined(window, 4), **PROBLEM, tolerance=3e-4, reduce=headline)
    off = {name: np.abs(solved[name].values - truth[name].values) for name in QUANTITIES}
    found = {}
    for name, most in MOST_POINTS.items():
        discretisation._MOST_POINTS = most
        widths = discretisation.discretisation_uncertainty(window, contact=PROBLEM, solved=solved)
        found[name] = {quantity: off[quantity] <= widths[quantity].values for quantity in QUANTITIES}
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description="Intervals of the pixel size from a part of a window.")
    parser.add_argument("--number", type=int, default=48, help="of maps")
    rows = [held(seed) for seed in range(parser.parse_args().number)]
    for name, quantity in itertools.product(MOST_POINTS, QUANTITIES):
        shares = np.mean([row[name][quantity] for row in rows], axis=0)
        print(f"{name:6} {quantity:25} held at each load: {json.dumps(shares.round(3).tolist())}")


if __name__ == "__main__":
    main()
