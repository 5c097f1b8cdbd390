"""Bodies of finite size: this solver beside ContactMechanics and ASPHER, and its bound beside the error.

    python benchmarks/free_bodies.py compare --rivals PYTHON [--points 256]  # ten bodies, pixel by pixel
    python benchmarks/free_bodies.py bound [--bodies 1000] [--points 48]     # bound over true error
    python benchmarks/free_bodies.py speed --rivals PYTHON [--points 512]    # CPU s at an equal true error

PYTHON is that of `setup_rivals.sh`. Tables go to `benchmarks/results/free_bodies`. Every code takes one
thread. The true error is the L2 error of the pressure against this solver's own solution to 1e-9 of the same
discrete problem (`influence: elements`), which `compare` shows to be that of the others.
"""

import argparse
import csv
import tempfile
import time
from pathlib import Path

import numpy as np
from worker import Worker

from roughcontact.contact.elasticity import free_space
from roughcontact.contact.elasticity.halfspace import HalfSpace
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.free_boundary import FreeBody
from roughcontact.errors import HeightMapError

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results" / "free_bodies"
RIVALS = {"ASPHER": "rival_free_aspher.py", "ContactMechanics": "rival_free_contactmechanics.py"}
# tolerances of each code for a solution that all digits of the comparison need, and for the race
TIGHT = {"ASPHER": 1e-13, "ContactMechanics": 1e-9}  # ContactMechanics: penetration over the range of heights
LADDERS = {
    "ASPHER": (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9),
    "ContactMechanics": (1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
    "roughcontact": (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5),
}
TARGET = 1e-4  # true error of the race
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)


def rough_body(seed: int, points: int) -> tuple[np.ndarray, float]:
    """Return the heights of a rough ball, block or ellipsoid on a square of side 1, and a force over E*."""
    rng = np.random.default_rng(seed)
    x = (np.arange(points) + 0.5) / points - 0.5
    y = x[:, None]
    waves = np.fft.fftfreq(points, 1 / points)
    k = np.hypot(waves[:, None], waves)
    band = (k >= rng.integers(2, 10)) & (k <= max(points / 6, 10))
    decay = np.where(band, np.maximum(k, 1) ** -(1 + rng.uniform(0.4, 1)), 0)
    rough = np.fft.ifft2(np.fft.fft2(rng.standard_normal((points, points))) * decay).real
    rough *= 10 ** rng.uniform(-4, -2.3) / rough.std()
    if seed % 3 == 0:
        form, force = -(x**2 + y**2) / 10, 4 / 15 * rng.uniform(0.08, 0.35) ** 3
    elif seed % 3 == 1:
        side = rng.uniform(0.1, 0.3)
        form = np.where(np.maximum(abs(x), abs(y)) < side, 0.0, -0.3)
        force = 4 * side**2 * rough.std() * rng.uniform(0.5, 20)
    else:
        form, force = -(x**2 / 0.5 + y**2 / 4) / 2, 10 ** rng.uniform(-4, -2.2)
    return rough + form, force


def solved(heights: np.ndarray, force: float, tolerance: float, influence: str = "elements"):
    """Return this solver's solution on a square of side 1."""
    step = 1 / heights.shape[0]
    body = FreeBody(heights, (step, step), Elasticity(influence=influence))
    solution = body.solve(force, tolerance=tolerance)
    body.check_border(solution.pressure, force)
    return solution


def forget_kernels() -> None:
    """Remove the kernels that are kept between solves: each code sets up a solve anew."""
    for cached in (free_space.transform_of_pixels, free_space._cut_off):
        cached.cache_clear()


def relative(pressure: np.ndarray, exact: np.ndarray) -> float:
    """Return the relative L2 error."""
    return float(np.linalg.norm(pressure - exact) / np.linalg.norm(exact))


def ask(
    worker: Worker, folder: Path, name: str, heights: np.ndarray, force: float, tolerance: float, **options
):
    """Return the answer of another code, and its pressure."""
    files = folder / f"{name}.npy", folder / "pressure.npy"
    np.save(files[0], heights)
    answer = worker.ask(
        heights=str(files[0]), load=force, tolerance=tolerance, pressure=str(files[1]), **options
    )
    if "failure" in answer:
        raise SystemExit(f"{name}: {answer['failure']}")
    return answer, np.load(files[1]).reshape(heights.shape)


def compare(points: int, python: str, bodies: int = 10) -> list[dict]:
    """Return, for each rough body, how the pressures of the other codes differ."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for code, script in RIVALS.items():
            with Worker(HERE / script, python=python, threads=1) as worker:
                version = worker.versions[code]
                for seed in range(bodies):
                    heights, force = rough_body(seed, points)
                    ours = solved(heights, force, 1e-9).pressure
                    tolerance = TIGHT[code] * (np.ptp(heights) if code == "ContactMechanics" else 1)
                    options = {"options": {"precision": "double"}} if code == "ASPHER" else {}
                    _, theirs = ask(
                        worker, Path(name), f"{code}-{seed}", heights, force, tolerance, **options
                    )
                    rows.append(
                        {
                            "code": f"{code} {version}",
                            "body": seed,
                            "points": points,
                            "contact_pixels": int((ours > 0).sum()),
                            "pixels_that_differ": int(((ours > 0) != (theirs > 0)).sum()),
                            "pressure_L2": f"{relative(theirs, ours):.2e}",
                        }
                    )
                    print(rows[-1])
    return rows


def bound(points: int, bodies: int) -> list[dict]:
    """Return, for each tolerance, the bound over the error of so many random bodies in the energy norm."""
    periodic = HalfSpace((points, points), (1.0, 1.0))

    def norm(pressure: np.ndarray) -> float:
        return float(np.sqrt((pressure * periodic.displacement(pressure)).mean()))

    ratios: dict[float, list[float]] = {tolerance: [] for tolerance in TOLERANCES}
    passes: dict[float, list[int]] = {tolerance: [] for tolerance in TOLERANCES}
    refused = seed = 0
    while seed - refused < bodies:
        heights, force = rough_body(seed, points)
        seed += 1
        try:
            exact = solved(heights, force, 1e-9, "sampled").pressure
        except HeightMapError:  # contact at the border of the map
            refused += 1
            continue
        for tolerance in TOLERANCES:
            solution = solved(heights, force, tolerance, "sampled")
            error = norm(solution.pressure - exact) / norm(exact)
            passes[tolerance].append(solution.passes)
            if error > 1e-8:
                ratios[tolerance].append(solution.error_bound / error)
    return [
        {
            "tolerance": tolerance,
            "bodies": bodies,
            "with_error_above_1e-8": len(values),
            "refused": refused,
            "below_1": int((np.array(values) < 1).sum()),
            "least": f"{min(values):.4f}",
            "median": f"{np.median(values):.4f}",
            "largest": f"{max(values):.4f}",
            "median_solutions": int(np.median(passes[tolerance])),
            "most_solutions": max(passes[tolerance]),
        }
        for tolerance, values in ratios.items()
    ]


def speed(points: int, python: str, repeats: int = 5) -> list[dict]:
    """Return the least processor seconds, median of repeats, of each code to a true error of `TARGET`."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for seed in (0, 1, 2, 3):
            heights, force = rough_body(seed, points)
            exact = solved(heights, force, 1e-9).pressure
            times: dict[str, float] = {}
            for code in (*RIVALS, "roughcontact"):
                script = RIVALS.get(code)
                worker = Worker(HERE / script, python=python, threads=1) if script else None
                for tolerance in LADDERS[code]:
                    scaled = tolerance * (np.ptp(heights) if code == "ContactMechanics" else 1)
                    seconds = []
                    for repeat in range(1 + repeats):
                        if worker:
                            answer, pressure = ask(
                                worker, Path(name), f"{code}-{seed}", heights, force, scaled
                            )
                            seconds.append(answer["processor_seconds"])
                        else:
                            forget_kernels()
                            start = time.process_time()
                            pressure = solved(heights, force, tolerance).pressure
                            seconds.append(time.process_time() - start)
                        if repeat == 0 and relative(pressure, exact) > TARGET:
                            break
                    error = relative(pressure, exact)
                    if error <= TARGET:
                        times[code] = float(np.median(seconds[1:]))
                        rows.append(
                            {
                                "body": seed,
                                "points": points,
                                "code": code,
                                "tolerance": tolerance,
                                "error": f"{error:.1e}",
                                "seconds": f"{times[code]:.4f}",
                            }
                        )
                        print(rows[-1], flush=True)
                        break
                if worker:
                    worker.__exit__()
            print(
                {code: f"{times[code] / times['roughcontact']:.1f} times" for code in RIVALS if code in times}
            )
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=["compare", "bound", "speed"])
    parser.add_argument("--points", type=int)
    parser.add_argument("--bodies", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--rivals", default=str(HERE / ".rivals/bin/python"))
    options = parser.parse_args()
    if options.what == "compare":
        rows = compare(options.points or 256, options.rivals)
    elif options.what == "bound":
        rows = bound(options.points or 48, options.bodies)
    else:
        rows = speed(options.points or 512, options.rivals, options.repeats)
    RESULTS.mkdir(parents=True, exist_ok=True)
    with (RESULTS / f"{options.what}.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    for row in rows:
        print(row)


if __name__ == "__main__":
    main()
