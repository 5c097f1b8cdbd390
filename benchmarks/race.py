"""Time of this solver against others, on made and measured maps, to the same true error.

Each code is timed at the loosest of its own tolerances, a factor of 2 apart, that brings the pressure within
1e-4 (relative L2) of the truth, which is a solution of this solver to 1e-10. `rungs` looks for these
tolerances, and needs no quiet machine; `race` takes the times, the codes taking turns.
"""

import math
import statistics
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from cases import relative_error

CODES = ("roughcontact", "ASPHER", "Tamaas")
LOADS = (0.003, 0.03, 0.3)  # p' of the made maps
LOAD_OF_MEASURED = 0.03
TRUE_ERROR = 1e-4
TRUTH_TOLERANCE = 1e-10
FIRST_RUNG = {"roughcontact": 2.0**-11, "ASPHER": 2.0**-16, "Tamaas": 2.0**-16}  # where the search begins
LAST_RUNG = 2.0**-40
TIGHT = {"ASPHER": 1e-14, "Tamaas": 1e-11}  # each on its own scale
LARGEST = {"ASPHER": 2048, "Tamaas": 512}  # points per side; it takes minutes above
THREADS_USED = {"Tamaas": 1}  # codes that use this many threads, whatever they are given
PAUSE = 0.1  # seconds before a solve: idle threads of the code before may spin for so long
REHEARSED = 2.0  # seconds: solves that take longer are not rehearsed
REPEATS = ((5.0, 1), (2.0, 2))  # solves that take longer than so many seconds are timed so often at most


@dataclass(frozen=True)
class Case:
    """A square map of unit side, and its load over E*."""

    name: str
    group: str  # made or measured
    size: int
    load: float  # p'
    pressure: float
    heights: Path

    @property
    def key(self) -> str:
        """What the records of the case are kept by."""
        return f"{self.name} {self.load:g}"

    @property
    def truth(self) -> Path:
        """Where the converged pressure is kept."""
        return self.heights.with_name(f"truth {self.load:g} {self.heights.name}")


def all_cases(study) -> Iterator[Case]:
    """Yield the cases, the quick ones first."""
    for size in study.sizes:
        for seed in study.seeds:
            for load in LOADS:
                yield Case(f"made {size} {seed}", "made", size, load, load, study.made(size, seed))
        if size == min(study.sizes, key=lambda size: abs(size - 512)):
            for name, heights, gradient in study.squares():
                size_here = len(np.load(heights, mmap_mode="r"))
                pressure = LOAD_OF_MEASURED * gradient
                yield Case(name, "measured", size_here, LOAD_OF_MEASURED, pressure, heights)


def codes_for(study, case: Case, threads: int = 1) -> list[str]:
    """Return the codes that take part."""
    return [
        code
        for code in CODES
        if code in study.pythons
        and case.size <= LARGEST.get(code, case.size)
        and threads <= THREADS_USED.get(code, threads)
    ]


def rungs(study):
    """Yield the jobs of finding, for each case and other code, the loosest tolerance that will do."""
    guesses: dict = {}  # what one map takes is a good guess for the next
    for case in all_cases(study):
        for code in codes_for(study, case):
            if code != "roughcontact":
                yield rung_key(case, code), partial(rung, study, case, code, guesses)


def rung_key(case: Case, code: str) -> str:
    """Return what the tolerance of a code is kept by."""
    return f"{case.key} {code}"


def rung(study, case: Case, code: str, guesses: dict) -> dict:
    """Return the loosest tolerance, a power of two, at which a code meets the true error, and its solve."""
    make_truth(study, case)
    start_tolerance = guesses.get((code, case.load), FIRST_RUNG[code])
    solve_found = loosest(lambda tolerance: solve(study, case, code, tolerance), start_tolerance)
    guesses[code, case.load] = solve_found.get("tolerance", start_tolerance)
    return solve_found


def loosest(run, start: float) -> dict:
    """Return the solve at the largest tolerance, by factors of 2 from `start`, that meets the true error.

    `run(tolerance)` returns a dict with `true_error`; so does this, with `tolerance`; it is empty where even
    the smallest tolerance does not do, or where a solve fails: a smaller tolerance would only take it longer.
    """
    tolerance, solves = start, {start: run(start)}
    while tolerance < 0.25 and solves[tolerance]["true_error"] <= TRUE_ERROR:
        tolerance *= 2
        solves[tolerance] = run(tolerance)
    while solves[tolerance]["true_error"] > TRUE_ERROR:
        if math.isinf(solves[tolerance]["true_error"]):
            return {}
        tolerance /= 2
        if tolerance < LAST_RUNG:
            return {}
        if tolerance not in solves:
            solves[tolerance] = run(tolerance)
    return {"tolerance": tolerance} | solves[tolerance]


def options_of(code: str, size: int) -> dict:
    """Return what a code wants to know of a grid: ASPHER's has so many points times a power of 2."""
    if code != "ASPHER":
        return {}
    while size % 2 == 0 and size >= 48:
        size //= 2
    return {"coarsest": size}


def make_truth(study, case: Case) -> None:
    """Write the converged pressure of a case, unless it is there."""
    if case.truth.exists():
        return
    unfinished = study.work / "unfinished.npy"
    request = {"heights": str(case.heights), "load": case.pressure, "tolerance": TRUTH_TOLERANCE}
    answer = study.warm_worker("roughcontact", 1).ask(**request, pressure=str(unfinished))
    if not answer.get("converged"):
        raise RuntimeError(f"no converged solution of {case.key}: {answer}")
    unfinished.replace(case.truth)


def solve(
    study, case: Case, code: str, tolerance: float, *, threads: int = 1, rehearse: bool = False
) -> dict:
    """Return seconds and true error of one solve, both infinite where it fails."""
    target = study.work / "pressure.npy"
    answer = study.warm_worker(code, threads).ask(
        heights=str(case.heights),
        load=case.pressure,
        tolerance=tolerance,
        pressure=str(target),
        rehearse=rehearse,
        options=options_of(code, case.size),
    )
    if "failure" in answer:
        return {"seconds": math.inf, "true_error": math.inf}
    error = relative_error(np.load(target), np.load(case.truth))
    return {"seconds": answer["seconds"], "true_error": error}


def agreement(study):
    """Yield the jobs of the true errors of the other codes at a tight tolerance, on synthetic maps."""
    for case in all_cases(study):
        if case.group == "made" and case.size <= min(LARGEST.values()):
            for code in filter(TIGHT.get, codes_for(study, case)):
                yield rung_key(case, code), partial(converged, study, case, code)


def converged(study, case: Case, code: str) -> dict:
    """Return the true error of a code at a tight tolerance."""
    make_truth(study, case)
    error = solve(study, case, code, TIGHT[code])["true_error"]
    return {"code": code, "size": case.size, "load": case.load, "true_error": error}


def race(study):
    """Yield the jobs of timing all codes on each case."""
    guesses: dict = {}
    for case in all_cases(study):
        known_solves: dict = {}
        for threads in study.threads:
            yield f"{case.key} threads {threads}", partial(times, study, case, threads, known_solves, guesses)


def times(study, case: Case, threads: int, memo: dict, guesses: dict) -> dict:
    """Return median seconds and largest true error of all codes, taking turns.

    `memo` gets the solve of each code at its tolerance: those of the other codes are kept by `rungs`, this
    solver's own is looked for anew, because it may have changed since.
    """
    rung_solves = study.results.setdefault("rungs", {})
    codes = codes_for(study, case, threads)
    for code in codes:
        if code not in memo:
            key = rung_key(case, code)
            memo[code] = rung_solves[key] if key in rung_solves else rung(study, case, code, guesses)
            if code != "roughcontact":
                rung_solves[key] = memo[code]
    solves: dict = {code: [] for code in codes if memo[code]}
    for repeat in range(study.repeats):
        for code, of_code in solves.items():
            last = of_code[-1] if of_code else memo[code]  # the first guess may be of a busy machine
            if repeat == 0 or repeat < most_repeats(last["seconds"]):
                time.sleep(PAUSE)
                brief, tolerance = last["seconds"] < REHEARSED, memo[code]["tolerance"]
                of_code.append(solve(study, case, code, tolerance, threads=threads, rehearse=brief))
    return {
        "name": case.name,
        "group": case.group,
        "size": case.size,
        "load": case.load,
        "threads": threads,
        "codes": {
            code: {
                "seconds": statistics.median(solve_of_code["seconds"] for solve_of_code in of_code),
                "true_error": max(solve_of_code["true_error"] for solve_of_code in of_code),
            }
            for code, of_code in solves.items()
        },
    }


def most_repeats(seconds: float) -> int:
    """Return how often a solve that takes about so many seconds is timed at most."""
    return next((count for long, count in REPEATS if seconds > long), sys.maxsize)
