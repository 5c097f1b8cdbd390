"""Hold the bound of worn heights against random runs: faces, loads, hardness, and few uneven steps.

    python benchmarks/running_in.py             # printed; ten CPU minutes
    python benchmarks/running_in.py --write

The truth is a run of 160 even steps and those of the run itself.
"""

import argparse
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.contact.solve import contact_from, elasticity
from roughcontact.statistics.running_in import Archard, worn_faces

MODULUS = 1e9  # Pa
WEAR = 1e-15  # 1/Pa
PITCH = 1e-6  # m
STEPS, RUNS = 160, 200
TABLE = Path(__file__).parent / "results/running_in.csv"


def rough(points=48, seed=1, **options):
    """Return a self-affine face of rms gradient 0.1, unless stated otherwise."""
    arguments = {"hurst": 0.8, "rms_gradient": 0.1, "longest": 24e-6, "shortest": 6e-6} | options
    return rc.self_affine_surface((points, points), PITCH, seed=seed, **arguments)


def even(distance, steps):
    """Return the ends of so many equal steps."""
    return distance * np.arange(1, steps + 1) / steps


def run_to_the_end(face, distances, *, load, hardness=None):
    """Return heights and bound after the last distance, without the statistics on the way."""
    known = elasticity(MODULUS, hardness=hardness)
    contact = rc.solve_contact(face, contact_modulus=MODULUS, mean_pressure=load, hardness=hardness)
    solve = partial(contact_from, load=load, tolerance=1e-4, threads=1)
    *_, worn = worn_faces(contact, Archard(WEAR, known, solve), distances.tolist(), tolerance=np.inf)
    return worn.contact["height"].values, np.sqrt(worn.squared_error)


def random_run(seed, steps):
    """Return the case of a random run of few uneven steps, its error and its bound over the rms height."""
    rng = np.random.default_rng(seed)
    gradient = float(10 ** rng.uniform(-2, -0.5))
    hurst, longest, shortest = rng.uniform(0.3, 0.95), rng.choice([12, 24, 48]), rng.choice([3, 6])
    waves = {"longest": float(longest) * PITCH, "shortest": float(shortest) * PITCH}
    face = rough(seed=seed, hurst=hurst, rms_gradient=gradient, **waves)
    load = MODULUS * gradient * 10 ** rng.uniform(-2, 0)
    hardness = load * 10 ** rng.uniform(0.1, 1.5) if rng.random() < 0.5 else None
    size = float(face.std())
    distance = size * 10 ** rng.uniform(-2, 0) / (WEAR * load)
    cuts = np.append(np.sort(rng.uniform(0, distance, rng.integers(0, 8))), distance)
    fine = np.union1d(even(distance, steps), cuts)
    (few, bound), (many, _) = (
        run_to_the_end(face, cut, load=load, hardness=hardness) for cut in (cuts, fine)
    )
    return {
        "seed": seed,
        "relative_pressure": load / (MODULUS * gradient),
        "hardness_over_load": np.nan if hardness is None else hardness / load,
        "worn_over_rms": WEAR * load * distance / size,
        "steps": len(cuts),
        "error": np.std(few - many) / size,
        "bound": bound / size,
    }


def random_ratio(seed, steps):
    """Return the bound over the error of a random run."""
    run = random_run(seed, steps)
    return run["bound"] / run["error"]


def main():
    """Print or write the table of all runs, and print what it comes to."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help=f"write {TABLE.name}")
    runs = pd.DataFrame([random_run(seed, STEPS) for seed in range(RUNS)])
    if parser.parse_args().write:
        runs.to_csv(TABLE, index=False, float_format="%.4g")
    ratio = runs["bound"] / runs["error"]
    print(
        f"bound over error: least {ratio.min():.2f}, median {ratio.median():.2f}, largest {ratio.max():.0f}"
    )


if __name__ == "__main__":
    main()
