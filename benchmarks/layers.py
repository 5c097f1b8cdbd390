"""Contacts of layered bodies: transform pairs by stack, and the error bound against the true error.

`python benchmarks/layers.py pairs` writes results/layers_pairs.csv, `... bound` results/layers_bound.csv.
"""

import csv
import sys
import time
from pathlib import Path

import numpy as np
import xarray as xr

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.contact.elasticity.energy import elastic_energy
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.media import elastic_medium
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import self_affine_surface

RESULTS = Path(__file__).parent / "results"
RIGID = {"youngs_modulus": 1e20, "poissons_ratio": 0.3}
POINTS, TOLERANCE = 512, 1e-4
RELATIVE_PRESSURES = (0.003, 0.03, 0.3)
THICKNESSES, RATIOS = (4, 32), (0.0, 0.1, 0.5, 2.0, 5.0, 20.0, 100.0)
SOLVES = 1000


def body(thickness: float, ratio: float) -> dict:
    """Return a layer of Young's modulus 1 on a base `ratio` times softer, rigid for 0."""
    layer = {"thickness": thickness, "youngs_modulus": 1.0, "poissons_ratio": 0.3}
    base = {"base": "rigid"} if ratio == 0 else {"youngs_modulus": 1 / ratio, "poissons_ratio": 0.3}
    return base | {"layers": [layer]}


def pairs() -> list[dict]:
    """Return the transform pairs that a tolerance of 1e-4 takes on a random surface, by stack and load."""
    modulus = 1 / (1 - 0.3**2)
    window = self_affine_surface(
        (POINTS, POINTS),
        1 / POINTS,
        hurst=0.8,
        rms_gradient=1.0,
        shortest=6 / POINTS,
        longest=0.25,
        seed=1,
    )
    rows = []
    stacks = [(0, 1.0), *((thickness, ratio) for thickness in THICKNESSES for ratio in RATIOS)]
    for thickness, ratio in stacks:
        bodies = [
            body(thickness / POINTS, ratio) if thickness else {"youngs_modulus": 1.0, "poissons_ratio": 0.3}
        ]
        contact = rc.solve_contact(
            window,
            bodies=[*bodies, RIGID],
            mean_pressure=[modulus * load for load in RELATIVE_PRESSURES],
            tolerance=TOLERANCE,
        )
        rows += [
            {
                "thickness_in_pixels": thickness,
                "modulus_ratio": ratio,
                "relative_pressure": load,
                "pairs": f"{count:.1f}",
                "area_in_pixels": f"{area:.5f}",
            }
            for load, count, area in zip(
                RELATIVE_PRESSURES,
                contact["operator_applications"].values,
                contact["contact"].mean(("y", "x")).values,
                strict=True,
            )
        ]
        print(thickness, ratio, [row["pairs"] for row in rows[-3:]], flush=True)
    return rows


def random_problem(rng: np.random.Generator) -> tuple[xr.DataArray, list[dict], float]:
    """Return a small map, layered bodies and a load over E* g, all drawn at random."""
    shape = ((48, 48), (64, 64), (1, 128), (35, 60))[rng.integers(4)]
    steps = 10 ** rng.uniform(-0.5, 0.5, 2)
    y, x = (np.fft.fftfreq(n, d) for n, d in zip(shape, steps, strict=True))
    waves = np.hypot(y[:, None], x)
    roll_off = np.where(waves > 0, waves, np.inf) ** -rng.uniform(1.2, 2.2)
    height = np.fft.ifft2(np.fft.fft2(rng.normal(size=shape)) * roll_off).real
    window = height_map(height / height.std(), (float(steps[0]), float(steps[1])))

    def material() -> dict[str, float]:
        return {
            "youngs_modulus": float(10 ** rng.uniform(-1, 1)),
            "poissons_ratio": float(rng.choice([0.0, 0.3, 0.5])),
        }

    def stack() -> dict:
        layers = [
            material() | {"thickness": float(10 ** rng.uniform(-0.5, 1.5))} for _ in range(rng.integers(1, 4))
        ]
        return ({"base": "rigid"} if rng.random() < 0.4 else material()) | {"layers": layers}

    bodies = [stack(), stack() if rng.random() < 0.3 else material()]
    return window, bodies, float(10 ** rng.uniform(-2, 0.3))


def bound() -> list[dict]:
    """Return the error bound over the true error, in the energy norm, of random layered solves."""
    rows = []
    for seed in range(SOLVES):
        rng = np.random.default_rng(seed)
        window, bodies, load = random_problem(rng)
        pair = elastic_medium(bodies)
        assert pair is not None
        pressure = load * pair.modulus * rms_gradient(window)
        hardness = pressure * float(10 ** rng.uniform(0.3, 1.5)) if rng.random() < 0.3 else None
        coarse, exact = (
            rc.solve_contact(
                window,
                bodies=bodies,
                mean_pressure=pressure,
                tolerance=tolerance,
                hardness=hardness,
                on_failure="flag",
            )
            for tolerance in (10 ** rng.uniform(-3, -1), 1e-11)
        )
        difference, total = (
            elastic_energy(field, spacing(window), Elasticity(pair.modulus, medium=pair))
            for field in (
                coarse["pressure"].values[0] - exact["pressure"].values[0],
                exact["pressure"].values[0],
            )
        )
        error = float(np.sqrt(difference / total)) if total > 0 else 0.0
        rows.append(
            {
                "seed": seed,
                "points": window.size,
                "bound": f"{coarse['error_bound'].item():.4e}",
                "error": f"{error:.4e}",
                "bound_of_the_reference": f"{exact['error_bound'].item():.1e}",
                "pairs": f"{coarse['operator_applications'].item():.1f}",
            }
        )
    return rows


def main(part: str) -> None:
    """Run one part and write its table."""
    start = time.perf_counter()
    rows = {"pairs": pairs, "bound": bound}[part]()
    with (RESULTS / f"layers_{part}.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"{len(rows)} rows in {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main(sys.argv[1])
