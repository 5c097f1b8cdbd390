"""Times of this solver alone: from the first second, over one transform pair, of many loads in one call."""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.arguments.maps import height_map
from roughcontact.kernels.fft import make_plan

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "workflow" / "lib"
FIRST_SIZE = 256
LOAD = 0.03
PAIR_SIZES = (512, 1024, 2048)
SWEEP_SIZES = (512, 1024)
SWEEP = np.geomspace(0.001, 1.0, 20).tolist()
ENOUGH = 0.5  # seconds that something is repeated for

# one process, one solve: where its time goes
PROCESS = """
import time
start = time.perf_counter()
import numpy, roughcontact, roughcontact.arguments.maps
heights = roughcontact.arguments.maps.height_map(numpy.load({heights!r}), 1 / {size})
imported = time.perf_counter()
for _ in range(2):
    before = time.perf_counter()
    roughcontact.solve_contact(heights, contact_modulus=1.0, mean_pressure={load})
    print(time.perf_counter() - before)
print(imported - start)
"""


def starts(study):
    """Yield the jobs of the first seconds: of a new installation, and of a process when all is warm."""
    yield "installation", partial(installation, study)
    yield "process", partial(process, study)


def installation(study) -> dict:
    """Return the times of installing the package, beside what it needs, and of its first two processes."""
    with tempfile.TemporaryDirectory() as folder:
        target, home = Path(folder) / "packages", Path(folder) / "home"
        home.mkdir()
        start = time.perf_counter()
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(target)]
        subprocess.run([*command, str(ROOT)], check=True)
        installed = time.perf_counter() - start
        environment = {"PATH": os.environ["PATH"], "HOME": str(home), "OMP_NUM_THREADS": "1"}
        times_first, times_second = (one_process(study, target, environment) for _ in range(2))
    return {
        "pip install of the package beside its dependencies, the compiled passes built": installed,
        "its first process: imports, a solve of 256²": times_first["whole"],
        "its second process": times_second["whole"],
    }


def process(study) -> dict:
    """Return the median times of a process that solves one map, everything being there."""
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    runs = [one_process(study, PACKAGE, environment) for _ in range(max(5, study.repeats))]
    names = {
        "whole": "a process of an environment in use (median)",
        "imports": "of which imports",
        "first": "of which the first solve",
        "second": "the same solve again",
    }
    return {heading: statistics.median(run[name] for run in runs) for name, heading in names.items()}


def one_process(study, package: Path, environment: dict) -> dict:
    """Return the seconds of a process that imports the package and solves one map twice."""
    code = PROCESS.format(heights=str(study.made(FIRST_SIZE, 0)), size=FIRST_SIZE, load=LOAD)
    start = time.perf_counter()
    completed_process = subprocess.run(
        [sys.executable, "-c", code],
        env=environment | {"PYTHONPATH": str(package)},
        cwd=study.work,
        check=True,
        capture_output=True,
        text=True,
    )
    total = time.perf_counter() - start
    time_first, time_second, imports = map(float, completed_process.stdout.split())
    return {"whole": total - time_second, "imports": imports, "first": time_first, "second": time_second}


def pair(study):
    """Yield the jobs of the time of a solve over that of one transform pair of its map."""
    for size in PAIR_SIZES:
        for threads in study.threads:
            yield f"{size} threads {threads}", partial(over_one_pair, study, size, threads)


def over_one_pair(study, size: int, threads: int) -> dict:
    """Return the median seconds of a solve and of a pair of transforms of the same map, taking turns."""
    values = np.load(study.made(size, 0))
    window = height_map(values, 1 / size)
    plan, out = make_plan(values, "float64", threads=threads), np.empty_like(values)
    options = {"contact_modulus": 1.0, "mean_pressure": LOAD, "threads": threads, "fields": True}

    def transform():
        plan.inverse(plan.forward(values), out)

    times = {"pair (ms)": [], "solve (ms)": []}
    for _ in range(study.repeats):
        times["pair (ms)"] += repeated(transform)
        times["solve (ms)"] += repeated(lambda: rc.solve_contact(window, **options))
    work = float(rc.solve_contact(window, **options)["operator_applications"].sum())
    medians = {name: 1000 * statistics.median(seconds) for name, seconds in times.items()}
    over = {"solve / pair": medians["solve (ms)"] / medians["pair (ms)"]}
    return {"points per side": size, "threads": threads} | medians | {"pairs": work} | over


def repeated(run) -> list[float]:
    """Return the seconds of repeated calls, the first half second of them left out."""
    seconds, start = [], time.perf_counter()
    while (start_of_call := time.perf_counter()) < start + 2 * ENOUGH or not seconds:
        run()
        if start_of_call > start + ENOUGH or time.perf_counter() > start + 2 * ENOUGH:
            seconds.append(time.perf_counter() - start_of_call)
    return seconds


def sweep(study):
    """Yield the jobs of many loads in one call against as many calls."""
    for size in SWEEP_SIZES:
        for threads in study.threads:
            yield f"{size} threads {threads}", partial(one_call_or_many, study, size, threads)


def one_call_or_many(study, size: int, threads: int) -> dict:
    """Return median seconds and pairs of one call for all loads, and of a call for each, taking turns."""
    worker = study.warm_worker("roughcontact", threads)
    ask = partial(worker.ask, heights=str(study.made(size, 0)), tolerance=1e-4, options={"fields": False})
    ask(load=SWEEP)
    calls = {"one call (ms)": [SWEEP], "20 calls (ms)": [[load] for load in SWEEP]}
    times, work = {name: [] for name in calls}, {}
    for _ in range(study.repeats):
        for name, loads in calls.items():
            answers = [ask(load=load) for load in loads]
            times[name].append(1000 * sum(answer["seconds"] for answer in answers))
            work[name] = sum(answer["operator_applications"] for answer in answers)
    medians = {name: statistics.median(seconds) for name, seconds in times.items()}
    single, several = calls
    shares = {
        "share of time (%)": medians[single] / medians[several],
        "share of pairs (%)": work[single] / work[several],
    }
    percent = {name: 100 * share for name, share in shares.items()}
    return {"points per side": size, "threads": threads} | medians | percent
