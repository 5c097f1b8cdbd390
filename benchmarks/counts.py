"""What needs no clock: transform pairs, error bounds held against true errors, growth of the work, memory.

Each function yields names of jobs and what to call for their records, which `speed.py` keeps.
"""

import sys
from functools import partial
from pathlib import Path

import cases
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.arguments.maps import height_map, spacing
from roughcontact.contact.loads import plan_loads
from roughcontact.kernels.fourier import halfplane_weights, wavenumbers

TOLERANCES = (1e-4, 1e-8)
TRUTH = 1e-12
RESOLVED = 0.05  # largest bound of the reference over that of the solution
HARDNESS = (1.05, 2.0, 10.0)  # over the mean pressure
SEEDS = 3  # of made and hard maps
MADE_SIZES = (128, 256, 512)
MEMORY_LOAD = 0.03
ASPHER_TOLERANCE = 4e-6  # its own, which meets a true error of about 1e-4
MAX_IN_MEMORY = {"ASPHER": 4096}  # points per side; it takes minutes above


def maps(study):
    """Yield the jobs of all measured maps: pairs and bounds by default settings, and pairs with options."""
    for name, window, _ in study.maps():
        yield name, partial(of_map, name, window)


def of_map(name: str, window) -> dict:
    """Return shape and solves of a window at all loads: by default settings, then with options."""
    ways = {"elements": {"influence": "elements"}, "single precision": {"precision": "single"}}
    solves = []
    for relative, load in loads_of(window):
        solves += [result | {"load": relative} for result in certified(window, load)]
        hard = {f"hardness {ratio:g} p̄": {"hardness": ratio * load} for ratio in HARDNESS}
        for way, options in (ways | hard).items():
            result = solved(window, load, tolerance=TOLERANCES[0], **options)
            solves.append(pairs(result) | {"load": relative, "way": way, "tolerance": TOLERANCES[0]})
    return {"name": name, "shape": list(window.shape), "solves": solves}


def hard(study):
    """Yield the jobs of the hard maps: pairs and bounds."""
    for name in cases.hard_surfaces():
        yield name, partial(of_hard, name)


def of_hard(name: str) -> dict:
    """Return the solves of a hard map, all seeds together."""
    solves = []
    for seed in range(SEEDS):
        window = cases.hard_surfaces(seed)[name]
        for relative, load in loads_of(window):
            solves += [result | {"load": relative, "seed": seed} for result in certified(window, load)]
    return {"name": name, "solves": solves}


def made(study):
    """Yield the jobs of made maps of a few hundred points per side: pairs."""
    for size in MADE_SIZES:
        yield f"{size}", partial(of_made, size)


def of_made(size: int) -> dict:
    """Return the solves of made maps of a size at all loads, all seeds together."""
    solves = []
    for seed in range(SEEDS):
        window = height_map(cases.surface(size, seed), 1 / size)
        for relative, load in loads_of(window):
            for tolerance in TOLERANCES:
                result = pairs(solved(window, load, tolerance=tolerance, fields=False))
                solves.append(result | {"load": relative, "seed": seed, "tolerance": tolerance})
    return {"name": f"{size}²", "solves": solves}


def growth(study):
    """Yield the jobs of made maps of all sizes, and of the largest measured map enlarged to them."""
    windows = {"made": None}
    if measured := [window for _, window, _ in study.maps()]:
        windows["measured"] = max(measured, key=lambda window: window.size)
    for kind, window in windows.items():
        for size in study.growth_sizes:
            for relative in cases.LOADS[:3]:
                yield f"{kind} {size} {relative:g}", partial(of_size, kind, window, size, relative)


def of_size(kind: str, window, size: int, relative: float) -> dict:
    """Return the pairs to both tolerances on a made map, or on a window enlarged by its spectrum."""
    is_synthetic = kind == "made"
    large = height_map(cases.surface(size), 1 / size) if is_synthetic else cases.enlarged(window, size)
    load = plan_loads(large, contact_modulus=1.0, relative_pressure=[relative])
    results = [solved(large, load, tolerance=tolerance, fields=False) for tolerance in TOLERANCES]
    return {
        "kind": kind,
        "size": size,
        "load": relative,
        "pairs": [pairs(result)["pairs"] for result in results],
    }


def memory(study):
    """Yield the jobs of peak memory, each in a fresh process on one thread."""
    ways = [("roughcontact", {}), ("roughcontact, single precision", {"precision": "single"}), ("ASPHER", {})]
    for size in study.memory_sizes:
        for name, options in ways:
            code = name.split(",")[0]
            if code in study.pythons and size <= MAX_IN_MEMORY.get(code, size):
                yield f"{name} {size}", partial(peak, study, code, name, size, options)


def peak(study, code: str, name: str, size: int, options: dict) -> dict:
    """Return the bytes per point of one solve."""
    with study.worker(code, threads=1) as worker:
        for points in (64, size):  # the first loads what is loaded once
            answer = worker.ask(
                heights=str(study.made(points, 0)),
                load=MEMORY_LOAD,
                tolerance=ASPHER_TOLERANCE if code == "ASPHER" else TOLERANCES[0],
                options=options,
            )
    return {"code": name, "size": size, "bytes_per_point": answer["peak_bytes"] / size**2}


def loads_of(window) -> list[tuple[float, float]]:
    """Return p' and mean pressure (E* = 1) of all loads."""
    planned = plan_loads(window, contact_modulus=1.0, relative_pressure=list(cases.LOADS))
    return list(zip(cases.LOADS, planned, strict=True))


def solved(window, load, **options):
    """Return the contact of one load, flagged where it misses its tolerance."""
    contact = rc.solve_contact(window, contact_modulus=1.0, mean_pressure=load, on_failure="flag", **options)
    return contact.isel(load=0)


def pairs(solution) -> dict:
    """Return the transform pairs of a solution, and whether it met its tolerance."""
    return {
        "pairs": float(solution["operator_applications"]),
        "converged": bool(solution["converged"]),
        "floor": float(solution["rounding_floor"]),
    }


def certified(window, load: float) -> list[dict]:
    """Return pairs, bound and true error of a load at both tolerances."""
    reference = solved(window, load, tolerance=TRUTH)
    records = []
    for tolerance in TOLERANCES:
        solution = solved(window, load, tolerance=tolerance)
        comparison = compare(solution, reference, spacing(window))
        records.append(pairs(solution) | comparison | {"way": "default", "tolerance": tolerance})
    return records


def energy_norm(field: np.ndarray, steps) -> float:
    """Return ||field||_G, the energy norm without the mean (up to a factor that cancels in ratios)."""
    q = wavenumbers(field.shape, steps)
    q[0, 0] = np.inf
    power = halfplane_weights(field.shape) * np.abs(np.fft.rfft2(field - field.mean())) ** 2
    return float(np.sqrt((power / q).sum()))


def compare(solution, reference, steps) -> dict:
    """Return bound and true error of a solution of one load, by a `reference` of the same load.

    The true error is relative, in the energy norm without the mean. The reference is certified: a solution
    is `resolved` where its bound is at least 20 times that of its reference.
    """
    pressure, exact = solution["pressure"].values, reference["pressure"].values
    scale = energy_norm(pressure, steps)
    bound, error = float(solution["error_bound"]), energy_norm(pressure - exact, steps) / scale
    reference_error = float(reference["error_bound"]) * energy_norm(exact, steps) / scale
    return {
        "bound": bound,
        "true_error": error,
        "reference_error": reference_error,
        "ratio": bound / max(error, reference_error, np.finfo(float).tiny),
        "resolved": bool(solution["converged"]) and reference_error < RESOLVED * bound,
    }
