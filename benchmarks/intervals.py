"""Hold the ± against surfaces whose results are known: real maps, cut into parts, and made ones.

    python benchmarks/intervals.py FOLDER ... --page docs/explanation/coverage.md
    python benchmarks/intervals.py FOLDER --only plu-1.plu      # one map, printed

Every map in the folders that is read without being told anything, and has at least 400 points along each
side, is solved whole, by default settings: that is the truth, of the pressure in contact the load over the
contact area. It is cut into 3 x 3 parts, and each part is processed as if it were the measurement, its own
error budget included, at the same mean pressures. Maps that are smaller, from 192 points on, make a second
group. Made surfaces of eight kinds, with waves from an eighth to three times the length of the map, are cut
in the same way, some with faults.
"""

import argparse
import json
import sys
import warnings
from functools import partial
from pathlib import Path

import coverage_page
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.contact.loads import plan_loads
from roughcontact.errors import RoughContactError
from roughcontact.statistics import checks
from roughcontact.statistics.contact_statistics import with_uncertainty
from roughcontact.uncertainty.headline import QUANTITIES
from roughcontact.validation.masters import FAULTS, KINDS, cut_out, master_surface

LOADS = (0.02, 0.1, 0.4)  # of E* times the rms gradient of the whole map
CUTS = 3
LARGE, SMALL = 400, 192  # points along each side, at least
LONGEST = (1 / 8, 1 / 3, 1, 3)  # waves of made surfaces, of the length of the map
MADE_SIDE = 192
PLACES = 4  # maps of each made surface
WORK = Path(__file__).parent / "work" / "coverage.json"


def solve(height, loads) -> dict:
    """Return window and statistics of a map by default settings, at the given mean pressures (E* = 1)."""
    levelled = rc.level(height)
    window = rc.periodic_window(levelled)
    contact = {"contact_modulus": 1.0, "mean_pressure": list(loads)}
    statistics = rc.solve_contact(window, **contact, reduce=rc.contact_statistics)
    return {"levelled": levelled, "window": window, "contact": contact, "statistics": statistics}


def measure(height, loads, truth) -> dict:
    """Return results, intervals and errors of one map; the message where it is refused."""
    try:
        found = solve(height, loads)
    except RoughContactError as error:
        return {"refused": str(error)}
    levelled, window = found["levelled"], found["window"]
    settings = {"level": {}, "window": {}, "contact": found["contact"]}
    statistics = with_uncertainty(found["statistics"], rc.error_budget(levelled, window, settings))
    outcome = checks.surface_checks(
        statistics, height=height.attrs, levelled=levelled.attrs, window=window.attrs, points=window.size
    )
    return {
        "asked": [check.name for check in checks.reasons(outcome)],
        **{
            name: {
                "truth": truth[name],
                "result": statistics[name].values.tolist(),
                "lower": statistics[f"{name}_lower"].values.tolist(),
                "upper": statistics[f"{name}_upper"].values.tolist(),
            }
            for name in QUANTITIES
        },
    }


def truth_of(statistics) -> dict:
    """Return the four quantities (load) as plain lists.

    The mean over whole pixels is known to fall short of the pressure in contact. What its interval is for is
    the load over the area.
    """
    found = {name: statistics[name].values.tolist() for name in QUANTITIES}
    over_area = statistics["mean_pressure"] / statistics["relative_contact_area"]
    return found | {"mean_contact_pressure": over_area.values.tolist()}


def real_map(path: Path) -> dict | None:
    """Return the rows of the parts of one file; None where it is no map, or too small a one."""
    try:
        height = rc.read_height_map(path).astype(float)
        if min(height.shape) < SMALL:
            return None
        window = rc.periodic_window(rc.level(height))
    except RoughContactError:
        return None
    loads = plan_loads(window, contact_modulus=1.0, relative_pressure=list(LOADS))
    truth = truth_of(solve(height, loads)["statistics"])
    edges = [np.arange(CUTS + 1) * n // CUTS for n in height.shape]
    rows = [
        measure(height[top:bottom, left:right], loads, truth)
        for top, bottom in zip(edges[0][:-1], edges[0][1:], strict=True)
        for left, right in zip(edges[1][:-1], edges[1][1:], strict=True)
    ]
    return {"group": "large" if min(height.shape) >= LARGE else "small", "name": path.name, "parts": rows}


def made_map(kind: str, longest: float, seed: int) -> dict:
    """Return the rows of maps cut out of a made surface of three times their length."""
    master = master_surface(
        kind, CUTS * MADE_SIDE, longest=longest / CUTS, seed=seed, hurst=(0.5, 0.7, 0.9)[seed % 3]
    )
    loads = plan_loads(master, contact_modulus=1.0, relative_pressure=list(LOADS))
    contact = {"contact_modulus": 1.0, "mean_pressure": list(loads)}
    truth = truth_of(rc.solve_contact(master, **contact, reduce=rc.contact_statistics))
    generator = np.random.default_rng(seed)
    rows = [
        measure(cut_out(master, MADE_SIDE, generator, fault=FAULTS[place % len(FAULTS)]), loads, truth)
        for place in range(PLACES)
    ]
    return {"group": "made", "name": kind, "longest": longest, "seed": seed, "parts": rows}


def main() -> None:
    """Measure what is asked for, keep the rows, write the page."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folders", nargs="*", type=Path, help="folders of instrument files")
    parser.add_argument("--only", nargs="+", help="names of files; they are printed and not kept")
    parser.add_argument("--seeds", nargs="*", type=int, default=[1], help="of the made surfaces")
    parser.add_argument("--work", type=Path, default=WORK, help="where the rows are kept")
    parser.add_argument("--page", type=Path, help="the page that is written")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    files = sorted({path for folder in arguments.folders for path in folder.iterdir() if path.is_file()})
    if arguments.only:
        found = [real_map(path) for path in files if path.name in arguments.only]
        print(coverage_page.tables([each for each in found if each]))
        return
    kept = json.loads(arguments.work.read_text()) if arguments.work.exists() else []
    jobs = [(path.name, partial(real_map, path)) for path in files]
    jobs += [
        (f"{kind}, waves of {longest:.3g}, seed {seed}", partial(made_map, kind, longest, seed))
        for seed in arguments.seeds
        for kind in KINDS
        for longest in LONGEST
    ]
    done = {each["job"] for each in kept}
    arguments.work.parent.mkdir(parents=True, exist_ok=True)
    for job, run in jobs:
        if job in done:
            continue
        found = run() or {"group": "none"}
        kept.append(found | {"job": job})
        print(job, found["group"], flush=True)
        arguments.work.write_text(json.dumps(kept))
    if arguments.page:
        coverage_page.write([each for each in kept if each["group"] != "none"], arguments.page)


if __name__ == "__main__":
    main()
