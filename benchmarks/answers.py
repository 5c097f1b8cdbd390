"""Hold the ± of conductance and narrowest places against made surfaces of three times the length of the map.

    python benchmarks/answers.py --seeds 1 2 3 [--write]

Surfaces of eight kinds, with waves from an eighth to three times the length of the map, are solved whole:
that is the truth. Two maps are cut out of each and processed as if they were the measurement, error budget
included, at the same mean pressures. The table has the share of the intervals that hold the truth, and that
of the intervals without an upper end, which hold it where it is not below the lower one.
"""

import argparse
import itertools
import warnings

import numpy as np
import pages
import pandas as pd
from intervals import KINDS, LONGEST, cut_out, made_surface

import roughcontact as rc
from roughcontact.uncertainty.answers import ANSWERS, headline_and_answers

SIDE, PLACES = 96, 2  # points of a map, maps of each surface
GROOVED = ("ground", "honed")
QUANTITIES = (*ANSWERS, "mean_gap")


def held(kind: str, longest: float, seed: int) -> list[dict]:
    """Return for each quantity and load of some maps whether the interval holds, and has no upper end."""
    surface, loads = made_surface(kind, longest, seed, SIDE)
    problem = {"contact_modulus": 1.0, "mean_pressure": loads}
    truth = rc.solve_contact(surface, **problem, tolerance=1e-3, reduce=headline_and_answers)
    generator = np.random.default_rng(seed)
    rows = []
    for _ in range(PLACES):
        levelled = rc.level(cut_out(surface, SIDE, generator, fault="none"))
        settings = {"level": {}, "window": {}, "contact": problem}
        budget = rc.error_budget(levelled, rc.periodic_window(levelled), settings)
        for name in QUANTITIES:
            ends = (budget[f"{name}_{end}"].values for end in ("lower", "upper"))
            for lower, upper, true in zip(*ends, truth[name].values, strict=True):
                if np.isfinite(true) and np.isfinite(lower):  # the conductance of full contact is not
                    inside = lower <= true and not upper < true
                    rows.append({"quantity": shown(name, kind), "inside": inside, "open": np.isnan(upper)})
    return [row | {"waves": "up to the map" if longest <= 1 else "three times the map"} for row in rows]


def shown(name: str, kind: str) -> str:
    """Return the name of a quantity in the table: narrowest places stand apart for kinds with grooves."""
    if name.startswith("critical_constriction"):
        return f"narrowest places, {'with' if kind in GROOVED else 'without'} grooves"
    return "mean gap" if name == "mean_gap" else "conductance"


def main() -> None:
    """Measure all surfaces, and print or write the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3], help="of the surfaces")
    parser.add_argument("--write", action="store_true", help="write the table and its page; else print")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    cases = itertools.product(KINDS, LONGEST, options.seeds)
    rows = pd.DataFrame([row for case in cases for row in held(*case)])
    shares = 100 * rows.groupby(["quantity", "waves"])[["inside", "open"]].mean()
    table = shares.rename(columns={"inside": "inside (%)", "open": "without an upper end (%)"}).reset_index()
    tables = {"answers": pages.text(table, dict.fromkeys(table.columns[2:], ".0f"))}
    if options.write:
        pages.publish("coverage", tables)
    else:
        pages.show(tables)


if __name__ == "__main__":
    main()
