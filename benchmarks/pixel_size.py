"""Does the interval of the pixel size hold the truth, at loads left out and from a part of the window too?

    python benchmarks/pixel_size.py --number 48

Made maps of 512 x 512 points, whose truth is the solution with pixels a quarter as large. Prints at each of
the loads in how many of the maps the interval holds it and its median half-width in percent: that from the
whole map, and from a part of half the sides.
"""

import argparse
import itertools
import json
import warnings

import numpy as np

import roughcontact as rc
from roughcontact.maps import refined
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.uncertainty import discretisation
from roughcontact.uncertainty.answers import ANSWERS, headline_and_answers
from roughcontact.uncertainty.headline import QUANTITIES

SIZE = 512
SPECTRA = list(itertools.product((0.3, 0.8), (SIZE, SIZE / 8), (2.5, 4.0, 16.0)))  # Hurst, longest, shortest
SLOPE, MODULUS = 0.1, 1e9
MOST_POINTS = {"whole": SIZE**2, "part": SIZE**2 // 4}
NAMES = (*QUANTITIES, *ANSWERS)


def counted(contact):
    """Return what the budget counts of each load of a window."""
    return discretisation.grid_marks(contact).merge(headline_and_answers(contact)[list(ANSWERS)])


def held(seed: int, loads: list[float]) -> dict[str, dict[str, tuple[np.ndarray, np.ndarray]]]:
    """Return whether the intervals of one map hold the truth at each load, and their relative half-widths."""
    hurst, longest, shortest = SPECTRA[seed % len(SPECTRA)]
    lengths = {"longest": longest * 1e-6, "shortest": shortest * 1e-6}
    window = self_affine_surface((SIZE, SIZE), 1e-6, hurst=hurst, rms_gradient=SLOPE, seed=seed, **lengths)
    pressures = [MODULUS * SLOPE * load for load in loads]
    problem = {"contact_modulus": MODULUS, "mean_pressure": pressures, "threads": 1}
    solved = rc.solve_contact(window, **problem, reduce=counted)
    truth = rc.solve_contact(refined(window, 4), **problem, tolerance=3e-4, reduce=headline_and_answers)
    found = {}
    for name, most in MOST_POINTS.items():
        discretisation._MOST_POINTS = most
        widths = discretisation.discretisation_uncertainty(window, contact=problem, solved=solved)
        found[name] = {
            quantity: (
                np.abs(solved[quantity].values - truth[quantity].values) <= widths[quantity].values,
                (widths[quantity] / solved[quantity].where(solved[quantity] > 0)).values,
            )
            for quantity in NAMES
        }
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description="Intervals of the pixel size: do they hold the truth?")
    parser.add_argument("--number", type=int, default=48, help="of maps")
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument(
        "--loads", type=float, nargs="+", default=np.geomspace(0.003, 0.3, 8).tolist(), help="p/(E* g)"
    )
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.number)
    rows = [held(seed, arguments.loads) for seed in seeds]
    warnings.simplefilter("ignore", RuntimeWarning)  # of a narrowest place that is closed in all maps
    for name, quantity in itertools.product(MOST_POINTS, NAMES):
        holds = np.mean([row[name][quantity][0] for row in rows], axis=0)
        widths = np.nanmedian([row[name][quantity][1] for row in rows], axis=0)
        print(f"{name:6} {quantity:28} {100 * holds.mean():5.1f} %", end=" ")
        print(*(json.dumps((100 * each).round(3).tolist()) for each in (holds, widths)))


if __name__ == "__main__":
    main()
