"""This project beside other codes, in one table: pressures, flow factors, traction with friction.

    python benchmarks/oracles.py [--rivals PYTHON]

Without PYTHON the other codes are installed into an environment of their own first (`setup_rivals.sh`). The
table goes to `benchmarks/results/oracles.csv`; the exit status is 1 where a deviation is larger than allowed.
"""

import argparse
import csv
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from free_bodies import ask, relative, rough_body, solved
from worker import Worker

from roughcontact import height_map, partial_slip, self_affine_surface, solve_contact, unload
from roughcontact.statistics.sealing.flow import flow_columns
from roughcontact.surface.synthetic import rough_reference_surface

HERE = Path(__file__).resolve().parent
TABLE = HERE / "results" / "oracles.csv"
POINTS = 128
FRICTION, SHARES = 0.3, (0.3, 0.7)

Row = tuple[str, str, float, float]  # what, code with version, deviation, allowed


def pressures(python: str, folder: Path) -> Iterator[Row]:
    """Yield how the pressures of rough maps and of rough bodies without neighbours differ."""
    height, load = rough_reference_surface(POINTS), 0.05
    ours = solve_contact(height, contact_modulus=1.0, mean_pressure=load, tolerance=1e-8)["pressure"].values[
        0
    ]
    for code, script, tolerance in (
        ("Tamaas", "rival_tamaas.py", 1e-12),
        ("ASPHER", "rival_aspher.py", 1e-13),
    ):
        with Worker(HERE / script, python=python, threads=1) as worker:
            _, theirs = ask(worker, folder, code, height.values, load, tolerance)
            what = f"pressure, rough map of {POINTS} x {POINTS}"
            yield what, f"{code} {worker.versions[code]}", relative(theirs, ours), 1e-5
    heights, force = rough_body(0, POINTS)
    ours = solved(heights, force, 1e-9).pressure
    for code, script, tolerance in (
        ("ASPHER", "rival_free_aspher.py", 1e-13),
        ("ContactMechanics", "rival_free_contactmechanics.py", 1e-9 * np.ptp(heights)),
    ):
        with Worker(HERE / script, python=python, threads=1) as worker:
            _, theirs = ask(worker, folder, f"free {code}", heights, force, tolerance)
            yield "pressure, rough ball", f"{code} {worker.versions[code]}", relative(theirs, ours), 1e-6


def flattening(python: str, folder: Path) -> Iterator[Row]:
    """Yield how the pressures of a sphere and of a rough map differ, under a hardness and after the load."""
    x = (np.arange(POINTS) + 0.5) / POINTS - 0.5
    sphere = np.maximum(-(x[:, None] ** 2 + x**2) / 4, -0.04)
    cases = (
        ("sphere", height_map(sphere, 1 / POINTS), 4e-3 / 6, 0.02),  # Hertz: 0.032
        ("rough map", rough_reference_surface(POINTS), 0.12, 0.4),
    )
    with Worker(HERE / "rival_tamaas.py", python=python, threads=1) as worker:
        code = f"Tamaas {worker.versions['Tamaas']}"
        for name, height, load, hardness in cases:
            ours = solve_contact(
                height, contact_modulus=1.0, mean_pressure=load, hardness=hardness, tolerance=1e-8
            )
            options = {"hardness": hardness}
            _, theirs = ask(worker, folder, name, height.values, load, 1e-10, options=options)
            yield (
                f"pressure up to a hardness, {name}",
                code,
                relative(theirs, ours["pressure"].values[0]),
                1e-5,
            )
            residual = unload(ours, mean_pressure=load / 4, tolerance=1e-8)
            _, theirs = ask(
                worker, folder, f"flattened {name}", residual["residual_height"].values, load / 4, 1e-12
            )
            yield (
                f"pressure after the load, {name}",
                code,
                relative(theirs, residual["pressure"].values[0]),
                1e-5,
            )


def flow(python: str, folder: Path) -> Iterator[Row]:
    """Yield how the flow factors of the gap of a rough map differ, at three loads."""
    loads = [0.01, 0.05, 0.1]
    solution = solve_contact(
        rough_reference_surface(POINTS), contact_modulus=1.0, mean_pressure=loads, tolerance=1e-6
    )
    gaps = solution["gap"].where(solution["pressure"] == 0, 0.0).values  # within the contact it is rounding
    with Worker(HERE / "rival_reynoldsflow.py", python=python, threads=1) as worker:
        code = f"reynoldsflow {worker.versions['reynoldsflow']}"
        for load, gap in zip(loads, gaps, strict=True):
            scaled = np.maximum(gap, 0) / gap.mean()
            factors = flow_columns(scaled, (1 / POINTS, 1 / POINTS), tolerance=1e-7)
            for axis, oriented in (("yy", scaled), ("xx", scaled.T)):
                file, result = folder / f"gap {load} {axis}.npy", folder / "flux.npy"
                np.save(file, oriented)
                answer = worker.ask(heights=str(file), load=1.0, tolerance=1e-10, pressure=str(result))
                if "failure" in answer:
                    raise SystemExit(f"{code}: {answer['failure']}")
                theirs, ours = float(np.load(result)[0]), factors[f"flow_factor_{axis}"]
                yield f"flow factor {axis}, p/E* = {load:g}", code, abs(theirs / ours - 1), 1e-5


def friction(python: str, folder: Path) -> Iterator[Row]:
    """Yield how the tractions of two rough balls differ, without coupling (nu = 0).

    The other code has no neighbours; here the period is twenty times as long as the contact, whose pressure
    they change by less than 1e-4.
    """
    points = 256
    x = (np.arange(points) + 0.5) / points - 0.5
    radius = 0.05
    load = 4 * radius**3 / 6  # of a smooth ball of radius 2
    with Worker(HERE / "rival_friction_aspher.py", python=python, threads=1) as worker:
        for seed in (0, 1):
            rough = self_affine_surface(
                (points, points), 1 / points, hurst=0.8, shortest=0.02, longest=0.1, rms_height=1, seed=seed
            ).values
            heights = -(x[:, None] ** 2 + x**2) / 4 + 2e-5 * rough
            normal = solve_contact(
                height_map(heights, 1 / points),
                contact_modulus=1.0,
                mean_pressure=load,
                tolerance=1e-8,
                influence="elements",
            )
            ours = partial_slip(normal, friction_coefficient=FRICTION, tangential_load=SHARES)
            for index, share in enumerate(SHARES):
                _, theirs = ask(
                    worker, folder, f"friction {seed}", heights, load, 1e-10, options={"share": share}
                )
                difference = relative(theirs, ours["shear_traction"].values[index])
                what = f"traction of rough ball {seed}, Q = {share:g} mu P"
                yield what, f"ASPHER {worker.versions['ASPHER']}", difference, 1e-3


def main() -> int:
    """Print and write the table, and return whether a deviation is larger than allowed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rivals", help="Python of their environment")
    python = parser.parse_args().rivals
    if python is None:
        folder = HERE / ".rivals"
        subprocess.run(["bash", HERE / "setup_rivals.sh", folder, sys.executable], check=True)
        python = str(folder / "bin" / "python")
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as name:
        for compared in (pressures, flattening, flow, friction):
            for row in compared(python, Path(name)):
                rows.append(row)
                print("{:45s} {:28s} {:.1e}  (allowed {:.0e})".format(*row), flush=True)
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["what", "code", "deviation", "allowed"])
        writer.writerows((what, code, f"{deviation:.2e}", allowed) for what, code, deviation, allowed in rows)
    return int(any(not deviation <= allowed for _, _, deviation, allowed in rows))


if __name__ == "__main__":
    sys.exit(main())
