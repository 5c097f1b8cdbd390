"""Hold the answers of groups of maps against batches whose truth is known.

    python benchmarks/groups.py             # printed; six CPU minutes
    python benchmarks/groups.py --write

The maps are real solves: of each of three finishes (self-affine, ground, honed) 100 surfaces are made, a map
of a third of their length is cut out of each, tilted, with spots missing, then levelled, made periodic and
solved at eight loads (E* = 1). A part of a batch is one of these maps, drawn at random, its heights
multiplied by a log-normal factor of the scatter between parts. That needs no further solve: heights f times
as large touch under the pressure p as the map does under p/f, and their gap is f times as large. The truth is
the mean over all maps and all factors, by quadrature.

Batches go through `group_statistics`, pairs of finishes through the functions that `compare_groups` uses;
since every load is treated by itself, each of many batches stands in the place of a load. Pairs of faces are
solved one by one: a map of each face in four placements with their error budgets, held against a new
placement of new maps of the same faces.
"""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pages
import pandas as pd
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.statistics.contact_statistics import with_uncertainty
from roughcontact.uncertainty.groups import from_scale, to_scale
from roughcontact.uncertainty.random_effects import (
    SIGNIFICANCE,
    adjust_over_loads,
    p_value,
    random_effects,
    welch,
)
from validation.masters import cut_out, master_surface

KINDS = {"random": "self-affine", "ground": "ground", "honed": "honed"}
POOL, MASTER, SIDE = 100, 192, 64
GRID = np.geomspace(5e-4, 0.04, 8)  # loads of the solves
LOADS = (2e-3, 0.01)  # loads of the batches; the rms gradient is 0.1
NAMES = {"relative_contact_area": "area", "mean_gap": "mean gap"}
COUNTS = (3, 5, 10)
SCATTERS = (0.0, 0.1, 0.2, 0.3)
BATCHES = 500  # of each kind, count, scatter and load
PAIRS = 4000  # of each kind
FACES = 200  # pairs of faces, unless the command says more
SOURCES = ("solver", "discretisation", "window")
INSIDE = ("mean inside (%)", "next map inside (%)")
INSIDE_PAIRS = "new placement inside (%)"
DIFFER = ("differ at one load (%)", "differ at any of two loads (%)")
NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(31)


def pool(kind: str) -> dict[str, np.ndarray]:
    """Return the results (map, load) of maps of a finish, on their scales, at `GRID`."""
    generator = np.random.default_rng(7)
    rows: dict[str, list] = {name: [] for name in NAMES}
    for seed in range(POOL):
        master = master_surface(kind, MASTER, longest=1 / 6, seed=10_000 + seed)
        window = rc.periodic_window(rc.level(cut_out(master, SIDE, generator)))
        contact = {"contact_modulus": 1.0, "mean_pressure": list(GRID), "tolerance": 1e-3}
        statistics = rc.solve_contact(window, **contact, reduce=rc.contact_statistics)
        for name in NAMES:
            rows[name].append(to_scale(name, statistics[name].values))
    return {name: np.array(values) for name, values in rows.items()}


def results(solved: dict, maps: np.ndarray, factors: np.ndarray) -> dict[str, np.ndarray]:
    """Return the results (map, load) on their scales of maps with multiplied heights."""
    grid = np.log(GRID)
    at = (np.log(np.array(LOADS)[None, :] / factors[:, None]) - grid[0]) / (grid[1] - grid[0])
    below = np.clip(at.astype(int), 0, grid.size - 2)
    results_by_name = {}
    for name in NAMES:
        lower, right = (solved[name][maps[:, None], below + step] for step in (0, 1))
        results_by_name[name] = lower + (at - below) * (right - lower)
    results_by_name["mean_gap"] = results_by_name["mean_gap"] + np.log(factors)[:, None]
    return results_by_name


def truth(solved: dict, scatter: float) -> dict[str, np.ndarray]:
    """Return the mean (load,) of a finish on its scale, over all maps and factors."""
    maps = np.arange(POOL)
    total: dict[str, np.ndarray] = {name: np.zeros(len(LOADS)) for name in NAMES}
    for node, weight in zip(NODES, WEIGHTS / WEIGHTS.sum(), strict=True):
        results_of_maps = results(solved, maps, np.full(maps.size, np.exp(scatter * node)))
        for name in NAMES:
            total[name] += weight * results_of_maps[name].mean(axis=0)
    return total


def drawn(
    solved: dict,
    parts: list[int],
    batches: int,
    generator,
    *,
    scatter: float,
    deviation_within: float = 0.0,
    shift=0.0,
) -> dict[str, np.ndarray]:
    """Return the results (map, batch, load) of batches of so many maps of each part.

    The heights scatter between the parts and within one, and are `shift` (ln) larger.
    """
    part = np.repeat(np.arange(len(parts)), parts)
    of_part = scatter * generator.standard_normal((len(parts), batches))
    factors = np.exp(
        of_part[part] + deviation_within * generator.standard_normal((part.size, batches)) + shift
    )
    maps = generator.integers(0, len(solved["mean_gap"]), factors.size)
    results_of_maps = results(solved, maps, factors.ravel())
    return {name: values.reshape(part.size, batches, -1) for name, values in results_of_maps.items()}


def inside(
    results_by_name: dict, parts: list[int], expected: dict, further: dict
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return whether the intervals of mean and next map hold theirs, by quantity (batch, load)."""
    labels = [f"part {part}" for part, count in enumerate(parts) for _ in range(count)]
    shape = results_by_name["mean_gap"].shape[1:]
    datasets = [
        xr.Dataset(
            {name: ("load", from_scale(name, results_by_name[name][index].ravel())) for name in NAMES},
            {"mean_pressure": ("load", 1.01 ** np.arange(np.prod(shape)))},  # none is the same as the next
        )
        for index in range(len(labels))
    ]
    group = rc.group_statistics(datasets, parts=labels)
    hits = []
    for ending, values in (("", expected), ("next_", further)):
        hits.append({})
        for name in NAMES:
            low, high = (group[f"{name}_{ending}{side}"].values.reshape(shape) for side in ("lower", "upper"))
            value = from_scale(name, np.broadcast_to(values[name], shape))
            hits[-1][name] = (low <= value) & (value <= high)
    return hits[0], hits[1]


def coverage(solved: dict[str, dict]) -> pd.DataFrame:
    """Return the share of the intervals of the mean and of the next map that hold the truth."""
    rows = []
    for kind, finish in KINDS.items():
        for scatter in SCATTERS:
            expected = truth(solved[kind], scatter)
            for count in COUNTS:
                generator = np.random.default_rng([count, round(100 * scatter), *map(ord, finish)])
                batch = [1] * count
                results_by_name = drawn(solved[kind], batch, BATCHES, generator, scatter=scatter)
                further = drawn(solved[kind], [1], BATCHES, generator, scatter=scatter)
                mean, next_map = inside(
                    results_by_name, batch, expected, {n: v[0] for n, v in further.items()}
                )
                rows += [
                    {
                        "finish": finish,
                        "scatter": f"scatter {round(100 * scatter)} %",
                        "maps": f"{count} maps",
                        "quantity": words,
                        "batches": BATCHES * len(LOADS),
                        "mean": mean[name].mean(),
                        "next": next_map[name].mean(),
                    }
                    for name, words in NAMES.items()
                ]
    return pd.DataFrame(rows)


def nested(solved: dict[str, dict]) -> pd.DataFrame:
    """Return the same for several maps of each part: equally many, and not."""
    rows = []
    scatter, deviation_within = 0.15, 0.05
    for words, parts in (("3 × 3", [3] * 3), ("5 × 3", [3] * 5), ("1 + 4 + 2 + 3 + 1", [1, 4, 2, 3, 1])):
        for kind in KINDS:
            generator = np.random.default_rng([sum(parts), *map(ord, kind)])
            # every map is of another place: the scatter of the places is within the parts
            expected = truth(solved[kind], float(np.hypot(scatter, deviation_within)))
            results_by_name = drawn(
                solved[kind], parts, BATCHES, generator, scatter=scatter, deviation_within=deviation_within
            )
            further = drawn(
                solved[kind], [1], BATCHES, generator, scatter=scatter, deviation_within=deviation_within
            )
            mean, next_map = inside(results_by_name, parts, expected, {n: v[0] for n, v in further.items()})
            rows += [
                {
                    "maps of each part": words,
                    "batches": BATCHES * len(LOADS),
                    "mean": mean[name].mean(),
                    "next": next_map[name].mean(),
                }
                for name in NAMES
            ]
    return pd.DataFrame(rows)


def differences(solved: dict[str, dict]) -> pd.DataFrame:
    """Return the share of pairs of finishes whose areas "differ": equal ones, and some that do.

    Maps of equal finishes are drawn from all maps of theirs; those of different ones are one map with other
    heights, so that their scatter is that of the heights, 10 %, and nothing else.
    """
    rows = []
    name = "relative_contact_area"
    for words, shift in (("equal", 0.0), ("30 % apart", np.log(1.3))):
        for count in COUNTS:
            generator = np.random.default_rng(11 + count)
            p_values, together = [], []
            for kind in KINDS:
                finish = solved[kind]
                if shift:
                    indices = generator.integers(0, POOL, 1)
                    finish = {key: curves[indices] for key, curves in finish.items()}
                groups = [
                    drawn(finish, [1] * count, PAIRS, generator, scatter=0.1, shift=shift_of_finish)[name]
                    for shift_of_finish in (0.0, shift)
                ]
                parts = [str(k) for k in range(count)]
                effects = (random_effects(group.reshape(count, -1), parts) for group in groups)
                p_values.append(p_value(*welch(*effects)).reshape(PAIRS, len(LOADS)))
                together += [adjust_over_loads(values) for values in p_values[-1]]
            adjusted, together = np.concatenate(p_values), np.array(together)
            shares = (
                100 * np.mean(adjusted[:, 0] < SIGNIFICANCE),
                100 * np.mean((together < SIGNIFICANCE).any(axis=1)),
            )
            rows.append(
                {"finishes": words, "maps": count, "pairs": len(adjusted)}
                | dict(zip(DIFFER, shares, strict=True))
            )
    return pd.DataFrame(rows)


def pair_of_faces(trial: int) -> dict[str, list[bool]]:
    """Return by quantity whether the interval of a pair holds a new placement of new maps of its faces."""
    generator = np.random.default_rng(trial)
    contact = {"contact_modulus": 1.0, "mean_pressure": list(LOADS), "tolerance": 1e-3}
    masters = [
        master_surface(list(KINDS)[(trial + side) % 3], MASTER, longest=1 / 6, seed=20_000 + 2 * trial + side)
        for side in (0, 1)
    ]

    def placed(number: int) -> list:
        cut = [rc.level(cut_out(master, SIDE, generator)) for master in masters]
        where = rc.relative_positions(*cut, shifts=number, rotations=[0], overlap=0.75, seed=trial)
        return [rc.composite(*cut, **position) for position in where]

    def counted(levelled) -> tuple:
        window = rc.periodic_window(levelled)
        return window, rc.solve_contact(window, **contact, reduce=rc.contact_statistics)

    members = []
    for levelled in placed(4):
        window, statistics = counted(levelled)
        settings = {"level": {}, "window": {}, "contact": contact}
        members.append(
            with_uncertainty(statistics, rc.error_budget(levelled, window, settings, sources=SOURCES))
        )
    pair = rc.group_statistics(members, placements=True)
    _, statistics_of_new = counted(placed(1)[0])
    return {
        name: [
            bool(low <= value <= high)
            for low, value, high in zip(
                pair[f"{name}_lower"].values,
                statistics_of_new[name].values,
                pair[f"{name}_upper"].values,
                strict=True,
            )
        ]
        for name in NAMES
    }


def shares(frame: pd.DataFrame, by: str, title: str) -> pd.DataFrame:
    """Return the shares inside in percent, by a column."""
    shares_by = (
        frame.groupby(by, sort=False).agg({"batches": "sum", "mean": "mean", "next": "mean"}).reset_index()
    )
    shares_by[["mean", "next"]] *= 100
    return shares_by.rename(columns={by: title, "mean": INSIDE[0], "next": INSIDE[1]})


def main() -> None:
    """Measure, and print or write the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help="write tables and pages")
    parser.add_argument("--faces", type=int, default=FACES, help="pairs of faces that are solved")
    options = parser.parse_args()
    with ProcessPoolExecutor(4) as processes:
        pools = {kind: processes.submit(pool, kind) for kind in KINDS}
        trials = list(processes.map(pair_of_faces, range(options.faces)))
        solved = {kind: table.result() for kind, table in pools.items()}
    single, of_parts = coverage(solved), nested(solved)
    share_tables = [shares(single, by, "batches of") for by in ("maps", "scatter", "finish", "quantity")]
    share_tables.append(shares(of_parts, "maps of each part", "batches of"))
    table = pd.concat([frame.rename(columns={"batches": "number"}) for frame in share_tables])
    faces = [
        {
            "quantity": words,
            "pairs": options.faces,
            INSIDE_PAIRS: 100 * np.mean([trial[name] for trial in trials]),
        }
        for name, words in NAMES.items()
    ]
    forms = dict.fromkeys((*INSIDE, INSIDE_PAIRS, *DIFFER), ".1f")
    tables = {
        "coverage": pages.text(table, forms),
        "differences": pages.text(differences(solved), forms),
        "faces": pages.text(pd.DataFrame(faces), forms),
    }
    if options.write:
        pages.publish("groups", tables)
    pages.show(tables)


if __name__ == "__main__":
    main()
