"""Hold the answers of groups of maps against batches whose truth is known.

    python benchmarks/groups.py             # printed; some minutes
    python benchmarks/groups.py --write

The maps are real solves: of each of three finishes (self-affine, ground, honed) 150 surfaces are made, a map
of a third of their length is cut out of each, tilted, with spots missing, then levelled, made periodic and
solved at ten loads (E* = 1). A part of a batch is one of these maps, drawn at random, its heights multiplied
by a log-normal factor of the scatter between parts. That needs no further solve: heights f times as large
touch under the pressure p as the map does under p/f, and their gap is f times as large. The truth is the mean
over all maps and all factors, by quadrature.

Every batch goes through `group_statistics`, every pair of batches through `compare_groups`. Pairs of faces
are solved one by one: a map of each face in four placements with their error budgets, held against a new
placement of new maps of the same faces.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import pages
import pandas as pd
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.statistics.contact_statistics import with_uncertainty
from roughcontact.uncertainty.groups import from_scale, to_scale
from roughcontact.validation.masters import cut_out, master_surface

KINDS = {"random": "self-affine", "ground": "ground", "honed": "honed"}
POOL, MASTER, SIDE = 150, 192, 64
GRID = np.geomspace(2e-4, 0.12, 10)  # loads of the solves
LOADS = (2e-3, 0.01)  # loads of the batches; the rms gradient is 0.1
NAMES = ("relative_contact_area", "mean_gap")
COUNTS = (3, 5, 10)
SCATTERS = (0.0, 0.1, 0.2, 0.3)
BATCHES = 60  # of each kind, count and scatter
PAIRS = 500
FACES = 40
SOURCES = ("solver", "discretisation", "window", "processing")
NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(31)


def pool(kind: str, size: int = POOL) -> dict[str, np.ndarray]:
    """Return the results (map, load) of maps of a finish, on their scales, at `GRID`."""
    generator = np.random.default_rng(7)
    rows: dict[str, list] = {name: [] for name in NAMES}
    for seed in range(size):
        master = master_surface(kind, MASTER, longest=1 / 6, seed=10_000 + seed)
        window = rc.periodic_window(rc.level(cut_out(master, SIDE, generator)))
        contact = {"contact_modulus": 1.0, "mean_pressure": list(GRID), "tolerance": 1e-3}
        found = rc.solve_contact(window, **contact, reduce=rc.contact_statistics)
        for name in NAMES:
            rows[name].append(to_scale(name, found[name].values))
    return {name: np.array(values) for name, values in rows.items()}


def results(solved: dict, maps: np.ndarray, factors: np.ndarray, loads=LOADS) -> dict[str, np.ndarray]:
    """Return the results (map, load) on their scales of maps with multiplied heights."""
    at = np.log(np.array(loads)[None, :] / factors[:, None])
    found = {}
    for name in NAMES:
        curves = solved[name][maps]
        found[name] = np.array(
            [np.interp(x, np.log(GRID), curve) for x, curve in zip(at, curves, strict=True)]
        )
    found["mean_gap"] += np.log(factors)[:, None]
    return found


def truth(solved: dict, scatter: float) -> dict[str, np.ndarray]:
    """Return the mean (load,) of a finish on its scale, over all maps and factors."""
    maps = np.arange(len(solved[NAMES[0]]))
    total: dict[str, np.ndarray] = {name: np.zeros(len(LOADS)) for name in NAMES}
    for node, weight in zip(NODES, WEIGHTS / WEIGHTS.sum(), strict=True):
        found = results(solved, maps, np.full(maps.size, np.exp(scatter * node)))
        for name in NAMES:
            total[name] += weight * found[name].mean(axis=0)
    return total


def drawn(
    solved: dict, parts: list[int], generator, *, scatter: float, within: float = 0.0, shift=0.0
) -> dict:
    """Return the results of a batch: so many maps of each part, the heights `shift` (ln) larger."""
    part = np.repeat(np.arange(len(parts)), parts)
    of_part = scatter * generator.standard_normal(len(parts))
    factors = np.exp(of_part[part] + within * generator.standard_normal(part.size) + shift)
    return results(solved, generator.integers(0, len(solved[NAMES[0]]), part.size), factors)


def group_of(found: dict, parts: list[int] | None = None, loads: int = len(LOADS)) -> xr.Dataset:
    """Return the group of a batch."""
    datasets = [
        xr.Dataset(
            {name: ("load", from_scale(name, found[name][place, :loads])) for name in NAMES},
            {"mean_pressure": ("load", list(LOADS[:loads]))},
        )
        for place in range(len(found[NAMES[0]]))
    ]
    labels = [f"p{part}" for part, count in enumerate(parts or []) for _ in range(count)] or None
    return rc.group_statistics(datasets, parts=labels)


def inside(group: xr.Dataset, name: str, ending: str, value: np.ndarray) -> np.ndarray:
    """Return whether an interval of a group holds a value on the scale, load by load."""
    low, high = (group[f"{name}_{ending}{end}"].values for end in ("lower", "upper"))
    value = from_scale(name, value)
    return (low <= value) & (value <= high)


def coverage(solved: dict[str, dict], batches: int = BATCHES) -> pd.DataFrame:
    """Return the share of the intervals of the mean and of the next map that hold the truth."""
    rows = []
    for kind, finish in KINDS.items():
        for scatter in SCATTERS:
            expected = truth(solved[kind], scatter)
            for count in COUNTS:
                generator = np.random.default_rng([count, round(100 * scatter), *map(ord, finish)])
                for _ in range(batches):
                    batch = [1] * count
                    group = group_of(drawn(solved[kind], batch, generator, scatter=scatter))
                    further = drawn(solved[kind], [1], generator, scatter=scatter)
                    rows += [
                        {
                            "finish": finish,
                            "scatter": f"{round(100 * scatter)} %",
                            "maps": count,
                            "mean": float(inside(group, name, "", expected[name])[place]),
                            "next": float(inside(group, name, "next_", further[name][0])[place]),
                        }
                        for name in NAMES
                        for place in range(len(LOADS))
                    ]
    return pd.DataFrame(rows)


def nested(solved: dict[str, dict], batches: int = 400) -> pd.DataFrame:
    """Return the same for several maps of each part: equally many, and not."""
    rows = []
    scatter, within = 0.15, 0.05
    for words, parts in {
        "3 parts of 3": [3] * 3,
        "5 parts of 3": [3] * 5,
        "5 parts of 1 to 4": [1, 4, 2, 3, 1],
    }.items():
        generator = np.random.default_rng(len(words) + sum(parts))
        for batch in range(batches):
            kind = list(KINDS)[batch % len(KINDS)]
            # the two scatters together, and those of the maps, are the population
            expected = truth(solved[kind], float(np.hypot(scatter, within)))
            group = group_of(drawn(solved[kind], parts, generator, scatter=scatter, within=within), parts)
            further = drawn(solved[kind], [1], generator, scatter=scatter, within=within)
            name, place = NAMES[batch % 2], (batch // 2) % 2
            rows.append(
                {
                    "batch": words,
                    "mean": float(inside(group, name, "", expected[name])[place]),
                    "next": float(inside(group, name, "next_", further[name][0])[place]),
                }
            )
    return pd.DataFrame(rows)


def differences(solved: dict[str, dict], pairs: int = PAIRS) -> pd.DataFrame:
    """Return the share of pairs of finishes that "differ": equal ones, and such with 30 % between them.

    Maps of equal finishes are drawn from all maps of theirs; those of different ones are one map with other
    heights, so that their scatter is that of the heights, 10 %, and nothing else.
    """
    rows = []
    for words, shift in (("equal", 0.0), ("30 % apart", np.log(1.3))):
        for count in COUNTS:
            generator, differ = np.random.default_rng(11 + count), np.zeros(2, int)
            for pair in range(pairs):
                finish = solved[list(KINDS)[pair % len(KINDS)]]
                if shift:
                    place = generator.integers(0, len(finish[NAMES[0]]), 1)
                    finish = {name: curves[place] for name, curves in finish.items()}
                groups = [
                    group_of(drawn(finish, [1] * count, generator, scatter=0.1, shift=own))
                    for own in (0.0, shift)
                ]
                for loads in (1, 2):
                    found = rc.compare_groups(*(group.isel(load=slice(loads)) for group in groups))
                    differ[loads - 1] += bool((found["outcome"].sel(quantity=NAMES[0]) == "differ").any())
            rows.append(
                {"finishes": words, "maps": count, "pairs": pairs}
                | {
                    f"differ, {key} (%)": 100 * n / pairs
                    for key, n in zip(("one load", "two loads"), differ, strict=True)
                }
            )
    return pd.DataFrame(rows)


def faces(count: int = FACES) -> pd.DataFrame:
    """Return the share of intervals of a pair that hold a new placement of new maps of the same faces."""
    rows = []
    loads = [2e-3, 0.01]
    contact = {"contact_modulus": 1.0, "mean_pressure": loads, "tolerance": 1e-3}
    for trial in range(count):
        generator = np.random.default_rng(trial)
        kinds = [list(KINDS)[(trial + side) % len(KINDS)] for side in (0, 1)]
        masters = [
            master_surface(kind, MASTER, longest=1 / 6, seed=20_000 + 2 * trial + side)
            for side, kind in enumerate(kinds)
        ]

        def placed(number: int, masters=masters, generator=generator, trial=trial) -> list:
            cut = [rc.level(cut_out(master, 96, generator)) for master in masters]
            where = rc.relative_positions(*cut, shifts=number, rotations=[0], overlap=0.75, seed=trial)
            return [rc.composite(*cut, **each) for each in where]

        members = []
        for levelled in placed(4):
            window = rc.periodic_window(levelled)
            counted = rc.solve_contact(window, **contact, reduce=rc.contact_statistics)
            settings = {"level": {}, "window": {}, "contact": contact}
            budget = rc.error_budget(levelled, window, settings, sources=SOURCES)
            members.append(with_uncertainty(counted, budget))
        pair = rc.group_statistics(members, placements=True)
        (other,) = placed(1)
        window = rc.periodic_window(other)
        found = rc.solve_contact(window, **contact, reduce=rc.contact_statistics)
        rows += [
            {
                "quantity": name,
                "inside": float(inside(pair, name, "", to_scale(name, found[name].values))[place]),
            }
            for name in NAMES
            for place in range(len(loads))
        ]
    return pd.DataFrame(rows)


def shares(frame: pd.DataFrame, by: str) -> pd.DataFrame:
    """Return the shares inside in percent, by a column."""
    found = 100 * frame.groupby(by, sort=False)[["mean", "next"]].mean()
    found.insert(0, "intervals", frame.groupby(by, sort=False).size())
    return found.rename(columns={"mean": "mean inside (%)", "next": "next map inside (%)"}).reset_index()


def main() -> None:
    """Measure, and print or write the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help="write tables and pages")
    parser.add_argument("--quick", action="store_true", help="a tenth of everything")
    options = parser.parse_args()
    share = 10 if options.quick else 1
    solved = {kind: pool(kind, POOL // share) for kind in KINDS}
    single = coverage(solved, BATCHES // share)
    of_parts = nested(solved, 400 // share)
    found = pd.concat(
        [
            shares(single, by).rename(columns={by: "batches"}).astype({"batches": str})
            for by in ("maps", "scatter", "finish")
        ]
        + [shares(of_parts, "batch").rename(columns={"batch": "batches"})]
    )
    found["batches"] = [
        f"{name} maps" if name.isdigit() else f"scatter {name}" if "%" in name else name
        for name in found["batches"]
    ]
    placements = faces(FACES // share)
    inside_pairs = 100 * placements.groupby("quantity", sort=False)["inside"].mean()
    words = {"relative_contact_area": "area", "mean_gap": "mean gap"}
    of_faces = pd.DataFrame(
        {
            "quantity": [words[name] for name in inside_pairs.index],
            "pairs": FACES // share,
            "inside (%)": inside_pairs.values,
        }
    )
    forms = dict.fromkeys(
        (
            *("mean inside (%)", "next map inside (%)", "inside (%)"),
            *("differ, one load (%)", "differ, two loads (%)"),
        ),
        ".1f",
    )
    tables = {
        "coverage": pages.text(found, forms),
        "differences": pages.text(differences(solved, PAIRS // share), forms),
        "faces": pages.text(of_faces, forms),
    }
    if options.write:
        pages.publish("groups", tables)
    pages.show(tables)


if __name__ == "__main__":
    main()
