"""Hold the ± of conductance and narrowest places against made surfaces of three times the length of the map.

    python benchmarks/answers.py --seeds 1 2 3

Surfaces of eight kinds, with waves from an eighth to three times the length of the map, are solved whole:
that is the truth. Two maps are cut out of each and processed as if they were the measurement, error budget
included, at the same mean pressures. Printed is the share of the intervals that hold the truth, by the length
of the longest waves, for kinds with grooves and for the others, and after the stroke the share of those that
have no upper end, which hold it where it is not below the lower one.
"""

import argparse
import sys
import warnings
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.contact.loads import plan_loads
from roughcontact.uncertainty.answers import ANSWERS, headline_and_answers
from roughcontact.validation.masters import KINDS, cut_out, master_surface

LOADS = (0.02, 0.1, 0.4)  # of E* times the rms gradient of the surface
LONGEST = (1 / 8, 1 / 3, 1, 3)  # waves, of the length of the map
SIDE, TIMES, PLACES = 96, 3, 2  # points of a map, length of the surface over it, maps of each surface
GROOVED = ("ground", "honed")
QUANTITIES = (*ANSWERS, "mean_gap")


def held(kind: str, longest: float, seed: int) -> dict[str, list[tuple[bool, bool]]]:
    """Return for each quantity whether the interval holds, and has no upper end, of all maps and loads."""
    surface = master_surface(
        kind, TIMES * SIDE, longest=longest / TIMES, seed=seed, hurst=(0.5, 0.7, 0.9)[seed % 3]
    )
    loads = plan_loads(surface, contact_modulus=1.0, relative_pressure=list(LOADS))
    problem = {"contact_modulus": 1.0, "mean_pressure": list(loads)}
    truth = rc.solve_contact(surface, **problem, tolerance=1e-3, reduce=headline_and_answers)
    generator = np.random.default_rng(seed)
    found: dict[str, list[tuple[bool, bool]]] = {name: [] for name in QUANTITIES}
    for _ in range(PLACES):
        levelled = rc.level(cut_out(surface, SIDE, generator, fault="none"))
        settings = {"level": {}, "window": {}, "contact": problem}
        budget = rc.error_budget(levelled, rc.periodic_window(levelled), settings)
        for name, inside in found.items():
            lower, upper, true = (
                data.values for data in (budget[f"{name}_lower"], budget[f"{name}_upper"], truth[name])
            )
            known = np.isfinite(true) & np.isfinite(lower)  # the conductance of full contact is not
            open_ended = np.isnan(upper)
            holds = (lower <= true) & ((true <= upper) | open_ended)
            inside.extend(zip(holds[known], open_ended[known], strict=True))
    return found


def main() -> None:
    """Measure all surfaces and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3], help="of the surfaces")
    seeds = parser.parse_args().seeds
    warnings.simplefilter("ignore")
    print("kinds    quantity                      " + "".join(f"{longest:>11.3g}" for longest in LONGEST))
    for title, kinds in (
        ("others", [kind for kind in KINDS if kind not in GROOVED]),
        ("grooved", list(GROOVED)),
    ):
        rows = [[held(kind, longest, seed) for kind in kinds for seed in seeds] for longest in LONGEST]
        for name in QUANTITIES:
            shares = [np.mean([hit for each in column for hit in each[name]], axis=0) for column in rows]
            print(f"{title:8} {name:30}" + "".join(f"{100 * a:5.0f} /{100 * b:3.0f}%" for a, b in shares))


if __name__ == "__main__":
    main()
