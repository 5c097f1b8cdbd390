"""Coverage of the discretisation uncertainty, at loads left out and from a part of the window, too.

    python benchmarks/pixel_size.py --first 48 [--write]

Synthetic maps of 512 x 512 points, whose truth is the solution with pixels a quarter as large. Prints by load
the share of the intervals that hold the truth, and the median half-width over the result, both in percent:
those from the whole map, and from a part of half the sides.
"""

import argparse
import itertools
import warnings

import numpy as np
import pages
import pandas as pd

import roughcontact as rc
from roughcontact.maps import refined
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.uncertainty import discretisation
from roughcontact.uncertainty.answers import ANSWERS, headline_and_answers

SIZE = 512
SPECTRA = list(itertools.product((0.3, 0.8), (SIZE, SIZE / 8), (2.5, 4.0, 16.0)))  # Hurst, longest, shortest
SLOPE, MODULUS = 0.1, 1e9
MOST_POINTS = {"whole": SIZE**2, "part": SIZE**2 // 4}
NAMES = {
    "relative_contact_area": "area",
    "mean_gap": "mean gap",
    "max_pressure": "peak",
    "mean_contact_pressure": "pressure in contact",
    **dict(zip(ANSWERS, ("conductance", "narrowest places", "narrowest places"), strict=True)),
}


def counted(contact):
    """Return what the budget counts of each load of a window."""
    return discretisation.resolution_indicators(contact).merge(headline_and_answers(contact)[list(ANSWERS)])


def intervals(seed: int, loads: list[float]) -> list[dict]:
    """Return whether the intervals of one map hold the truth at each load, and their relative half-widths."""
    hurst, longest, shortest = SPECTRA[seed % len(SPECTRA)]
    lengths = {"longest": longest * 1e-6, "shortest": shortest * 1e-6}
    window = self_affine_surface((SIZE, SIZE), 1e-6, hurst=hurst, rms_gradient=SLOPE, seed=seed, **lengths)
    pressures = [MODULUS * SLOPE * load for load in loads]
    problem = {"contact_modulus": MODULUS, "mean_pressure": pressures, "threads": 1}
    solved = rc.solve_contact(window, **problem, reduce=counted)
    truth = rc.solve_contact(refined(window, 4), **problem, tolerance=3e-4, reduce=headline_and_answers)
    rows = []
    for part, most in MOST_POINTS.items():
        discretisation._MAX_POINTS = most
        widths = discretisation.discretisation_uncertainty(window, contact=problem, solved=solved)
        for quantity, shown in NAMES.items():
            inside = abs(solved[quantity] - truth[quantity]) <= widths[quantity]
            share = widths[quantity] / solved[quantity].where(solved[quantity] > 0)
            rows += [
                {"window": part, "quantity": shown, "load": load, "inside": held, "width": width}
                for load, held, width in zip(loads, inside.values, share.values, strict=True)
            ]
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description="Intervals of the pixel size: do they hold the truth?")
    parser.add_argument("--number", type=int, default=48, help="of maps")
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument(
        "--loads", type=float, nargs="+", default=np.geomspace(0.003, 0.3, 8).tolist(), help="p/(E* g)"
    )
    parser.add_argument("--write", action="store_true", help="write the table and its page")
    options = parser.parse_args()
    warnings.simplefilter("ignore", RuntimeWarning)  # of a narrowest place that is closed in all maps
    seeds = range(options.first, options.first + options.number)
    rows = pd.DataFrame([row for seed in seeds for row in intervals(seed, options.loads)])
    of_load = rows.groupby(["window", "quantity", "load"], sort=False)
    print((100 * of_load.agg({"inside": "mean", "width": "median"})).round(3).to_string())
    shares = 100 * rows.groupby(["window", "quantity"], sort=False)["inside"].mean().unstack(sort=False)
    tables = {"pixels": pages.text(shares.reset_index(), dict.fromkeys(NAMES.values(), ".0f"))}
    if options.write:
        pages.publish("coverage", tables)
    else:
        pages.show(tables)


if __name__ == "__main__":
    main()
