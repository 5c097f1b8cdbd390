"""Measure this solver against others: time to a true error, work, sweeps, memory, what shortcuts save.

    python benchmarks/speed.py --page docs/explanation/benchmark.md

For each case a solution by this solver to 1e-10 is the truth. Each code then climbs a ladder of its own
tolerances, factor 2 apart; the loosest rung whose pressure is within 1e-4 of the truth (relative L2) is what
it is timed at, several times, the codes taking turns. Every code sits in a warm process of its own.

Results are kept in the output folder after every case; a later call adds to them or replaces the cases it
measures again, so that the long measurement can be cut into pieces.
"""

import argparse
import csv
import json
import os
import platform
import re
import statistics
import sys
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import page
from cases import LOADS, SIZES, TRUE_ERROR, relative_error, surface
from worker import Worker

HERE = Path(__file__).parent
SCRIPTS = {
    "roughcontact": HERE / "own_worker.py",
    page.SINGLE: HERE / "own_worker.py",
    "ASPHER": HERE / "rival_aspher.py",
    "Tamaas": HERE / "rival_tamaas.py",
}
OPTIONS = {page.SINGLE: {"precision": "single"}}
FIRST_RUNG = {"roughcontact": 2.0**-6, page.SINGLE: 2.0**-6, "ASPHER": 2.0**-10, "Tamaas": 2.0**-11}
LAST_RUNG = 2.0**-40
LARGEST = {"ASPHER": 2048, "Tamaas": 1024}  # a solve of Tamaas takes minutes above
LARGEST_IN_MEMORY = {"ASPHER": 4096, "Tamaas": 1024, "roughcontact": 8192}
THREADS_USED = {"Tamaas": 1}  # codes that use this many threads, whatever they are given
TRUTH_TOLERANCE = 1e-10
LONG = 10.0  # seconds: solves that take longer are repeated less often, and not rehearsed
PAUSE = 0.25  # seconds before a solve: idle threads of the code before may spin for so long


def measure_case(workers, work, *, size, load, seed, threads, repeats, finest) -> list[dict]:
    """Return one record per solve of one case by every code: the ladders, then the timed repeats."""
    heights = _heights(work, size, seed)
    truth = np.load(_truth(workers["roughcontact"], work, heights, size, load, seed))

    def run(code, tolerance, purpose, *, rehearse=False):
        time.sleep(PAUSE)
        answer = workers[code].ask(
            heights=str(heights),
            load=load,
            tolerance=tolerance,
            pressure=str(work / "pressure.npy"),
            options=OPTIONS.get(code, {}),
            rehearse=rehearse,
        )
        case = {"code": code, "size": size, "load": load, "seed": seed, "threads": threads}
        record = case | {"tolerance": tolerance, "purpose": purpose} | answer
        if "failure" not in answer:
            record["true_error"] = relative_error(np.load(work / "pressure.npy"), truth)
        print(_line(record), flush=True)
        return record

    records, rungs = [], {}
    for code in workers:
        if size > LARGEST.get(code, size) or threads > THREADS_USED.get(code, threads):
            continue
        ladder = climb(lambda tolerance, code=code: run(code, tolerance, "ladder"), FIRST_RUNG[code], finest)
        records += ladder
        met = [record for record in ladder if record.get("true_error", np.inf) <= TRUE_ERROR]
        if met:
            rungs[code] = max(met, key=lambda record: record["tolerance"])
    for repeat in range(repeats):
        for code, rung in rungs.items():
            brief = rung["seconds"] < LONG
            if brief or repeat < min(repeats, 2):
                records.append(run(code, rung["tolerance"], "timed", rehearse=brief))
    return records


def climb(run, first: float, finest: float) -> list[dict]:
    """Return the records of a ladder: from a rung that misses the true error to one within `finest`.

    A solve longer than `LONG` seconds ends the ladder as soon as the true error of the benchmark is met, one
    that rounding keeps from its tolerance ends it at once.
    """
    records = [run(first)]
    while records[0].get("true_error", np.inf) <= TRUE_ERROR and records[0]["tolerance"] < 0.25:
        records.insert(0, run(2 * records[0]["tolerance"]))
    while records[-1]["tolerance"] > LAST_RUNG:
        last = records[-1]
        wanted = TRUE_ERROR if last.get("seconds", 0) > LONG else finest
        if last.get("true_error", np.inf) <= wanted or not last.get("converged", True):
            break
        records.append(run(last["tolerance"] / 2))
    return records


def measure_sweep(worker, work, *, size, seed, threads, number=20, tolerance=1e-4) -> dict:
    """Return time and work of a sweep of log-spaced loads from 0.1 % to 95 % contact, and of cold solves."""
    heights = str(_heights(work, size, seed))
    lowest, highest = (_load_for(worker, work, heights, share) for share in (0.001, 0.95))
    loads = np.geomspace(lowest, highest, number).tolist()
    options = {"fields": False}
    warm = worker.ask(heights=heights, load=loads, tolerance=tolerance, options=options)
    cold = [worker.ask(heights=heights, load=load, tolerance=tolerance, options=options) for load in loads]
    return {
        "size": size,
        "seed": seed,
        "threads": threads,
        "loads": [lowest, highest],
        "seconds": warm["seconds"],
        "operator_applications": warm["operator_applications"],
        "error_bound": warm["error_bound"],
        "cold_seconds": sum(answer["seconds"] for answer in cold),
        "cold_operator_applications": sum(answer["operator_applications"] for answer in cold),
    }


def _load_for(worker, work, heights, share):
    """Return the load at which about `share` of the pixels are in contact, by bisection."""
    low, high = 1e-5, 10.0
    for _ in range(12):
        load = float(np.sqrt(low * high))
        answer = worker.ask(heights=heights, load=load, tolerance=1e-2)
        low, high = (load, high) if answer["contact_share"] < share else (low, load)
    return load


def measure_memory(pythons, work, *, sizes, seed, load=0.03) -> list[dict]:
    """Return the peak memory of one solve per code and size, each in a fresh process on one thread."""
    found = []
    small = str(_heights(work, 64, seed))
    for size in sizes:
        heights = str(_heights(work, size, seed))
        for code, python in pythons.items():
            if size > LARGEST_IN_MEMORY.get(code, size):
                continue
            tolerance, options = {"ASPHER": 4e-6}.get(code, 1e-4), OPTIONS.get(code, {})
            with Worker(SCRIPTS[code], python=python, threads=1) as worker:
                for path in (small, heights):  # the first loads what is loaded once
                    answer = worker.ask(heights=path, load=load, tolerance=tolerance, options=options)
            bytes_per_pixel = answer["peak_bytes"] / size**2
            found.append(
                {"code": code, "size": size, "bytes_per_pixel": bytes_per_pixel, "seconds": answer["seconds"]}
            )
            print(f"memory {code} {size}: {bytes_per_pixel:.0f} bytes per pixel", flush=True)
    return found


def measure_shortcuts(worker, work, *, size, seed, repeats) -> list[dict]:
    """Return what each thing that is skipped saves: seconds and work with and without it."""
    rough = _heights(work, size, seed)
    row = np.load(rough)[:1]
    flat = _save(work / f"flat_{size}.npy", np.zeros((size, size)))
    profile = _save(work / f"row_{size}_{seed}.npy", row)
    lay = _save(work / f"lay_{size}_{seed}.npy", np.repeat(row, size, axis=0))
    high, low, light = 10.0, 0.3, 0.03

    def ask(heights, load, tolerance=1e-4, **options):
        request = {"heights": str(heights), "load": load, "tolerance": tolerance, "options": options}
        answers = [worker.ask(rehearse=True, **request) for _ in range(repeats)]
        return {
            "seconds": statistics.median(answer["seconds"] for answer in answers),
            "operator_applications": answers[-1]["operator_applications"],
        }

    pairs = [
        ("full contact: closed form", (rough, high), "half contact: iteration", (rough, low), {}),
        ("flat map: no solve", (flat, light), "rough map", (rough, light), {}),
        ("profile of one row", (profile, light), "the same, repeated over a square map", (lay, light), {}),
        ("no fields kept", (rough, light), "fields kept", (rough, light), {"fields": False}),
        ("tolerance 1e-2", (rough, light, 1e-2), "tolerance 1e-4", (rough, light), {}),
    ]
    found = []
    for name, with_it, against, without, options in pairs:
        fast, slow = ask(*with_it, **options), ask(*without)
        found.append({"shortcut": name, "against": against, "size": size, "with": fast, "without": slow})
        print(f"{name}: {fast['seconds']:.4f} s; {against}: {slow['seconds']:.4f} s", flush=True)
    return found


def _save(path: Path, values: np.ndarray) -> Path:
    """Write an array, whole or not at all."""
    temporary = path.with_name("part_" + path.name)
    np.save(temporary, values)
    return temporary.replace(path)


def _heights(work: Path, size: int, seed: int) -> Path:
    path = work / f"heights_{size}_{seed}.npy"
    return path if path.exists() else _save(path, surface(size, seed))


def _truth(worker, work, heights, size, load, seed) -> Path:
    """Return the file of the converged pressure, made at the first call and kept."""
    path = work / f"truth_{size}_{seed}_{load}.npy"
    if not path.exists():
        temporary = work / f"part_{path.name}"
        answer = worker.ask(
            heights=str(heights), load=load, tolerance=TRUTH_TOLERANCE, pressure=str(temporary)
        )
        if not answer.get("converged"):
            raise RuntimeError(f"no converged solution of {size}, load {load}, seed {seed}: {answer}")
        temporary.replace(path)
    return path


def _line(record: dict) -> str:
    case = (
        "{code:13s} {size:5d} {load:6g} seed {seed} threads {threads} {purpose:6s} {tolerance:8.1e}".format(
            **record
        )
    )
    if "failure" in record:
        return f"{case}  {record['failure']}"
    return f"{case}  {record['seconds']:8.3f} s  true error {record['true_error']:.1e}"


def machine() -> dict:
    """Return the kind of machine, without its name."""
    processor = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists() and (match := re.search(r"model name\s*:\s*(.+)", info.read_text())):
        processor = match[1]
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return {
        "processor": processor,
        "cores": len(os.sched_getaffinity(0)),
        "memory_GiB": round(memory),
        "system": platform.system(),
        "python": platform.python_version(),
    }


def keep(results: dict, folder: Path) -> None:
    """Write the results as JSON, and the solves as a tidy table."""
    text = json.dumps(results, indent=1)
    temporary = folder / "results.json.part"
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(folder / "results.json")
    columns = ["code", "size", "load", "seed", "threads", "purpose", "tolerance", "seconds", "true_error"]
    columns += ["error_bound", "operator_applications", "converged", "peak_bytes", "failure"]
    with (folder / "solves.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, columns, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(results["solves"])


def replace(old: list[dict], new: list[dict], keys: tuple[str, ...]) -> list[dict]:
    """Return `old` without the entries that `new` measured again, and `new`."""
    again = {tuple(entry[key] for key in keys) for entry in new}
    return [entry for entry in old if tuple(entry[key] for key in keys) not in again] + new


def parse(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    add = parser.add_argument
    add("--sizes", type=int, nargs="*", default=list(SIZES), help="points per side, all codes")
    add("--codes", nargs="*", default=list(SCRIPTS), help="beside this solver, as it is by default")
    add("--larger", type=int, nargs="*", default=[4096], help="points per side, work of this solver alone")
    add("--loads", type=float, nargs="*", default=list(LOADS), help="mean pressure over contact modulus")
    add("--seeds", type=int, nargs="*", default=[0], help="of the random phases")
    add("--threads", type=int, nargs="*", default=[1, 2], help="the same number for every code")
    add("--repeats", type=int, default=5, help="timed solves per code and case (2 where they take > 10 s)")
    add("--finest", type=float, default=1e-5, help="true error at which the ladders of the plot end")
    add("--sweep-sizes", type=int, nargs="*", default=[1024], help="points per side of the load sweep")
    add("--memory-sizes", type=int, nargs="*", default=[1024, 2048], help="points per side, peak memory")
    add("--shortcut-size", type=int, default=1024, help="points per side, what shortcuts save; 0 for none")
    add("--rivals", type=Path, default=HERE / ".rivals", help="environment made by setup_rivals.sh")
    add("--output", type=Path, default=HERE / "work", help="folder of results and converged solutions")
    add("--page", type=Path, help="Markdown page to write, with its figure beside it")
    return parser.parse_args(arguments)


def main() -> None:
    options = parse()
    options.output.mkdir(parents=True, exist_ok=True)
    work = options.output.resolve()
    stored = work / "results.json"
    results = json.loads(stored.read_text(encoding="utf-8")) if stored.exists() else {}
    for part in ("solves", "sweeps", "memory", "shortcuts"):
        results.setdefault(part, [])
    results["machine"] = machine()
    results.setdefault("versions", {})

    pythons = {"roughcontact": sys.executable, page.SINGLE: sys.executable}
    rival_python = options.rivals.absolute() / "bin" / "python"
    if rival_python.exists():
        pythons |= {"ASPHER": str(rival_python), "Tamaas": str(rival_python)}
    else:
        print(
            f"ASPHER and Tamaas are left out: no environment in {options.rivals}. "
            f"Make it with: bash {Path(__file__).parent.name}/setup_rivals.sh {options.rivals}"
        )

    pythons = {code: python for code, python in pythons.items() if code in {"roughcontact", *options.codes}}
    for threads in options.threads:
        with ExitStack() as stack:
            workers = {
                code: stack.enter_context(Worker(SCRIPTS[code], python=python, threads=threads))
                for code, python in pythons.items()
            }
            for code, worker in workers.items():
                if code != page.SINGLE:
                    results["versions"][code] = worker.versions
                for size in {64, *options.sizes}:  # untimed: what only the first call pays
                    if size <= LARGEST.get(code, size):
                        heights = str(_heights(work, size, options.seeds[0]))
                        # to the last digits on the smallest: whatever is compiled at its first use then is
                        worker.ask(heights=heights, load=0.03, tolerance=1e-6 if size == 64 else 0.1)
            own = {"roughcontact": workers["roughcontact"]}
            larger = options.larger if threads == max(options.threads) else []
            for size in sorted({*options.sizes, *larger}):
                chosen = workers if size in options.sizes else own
                for seed in options.seeds:
                    for load in options.loads:
                        records = measure_case(
                            chosen,
                            work,
                            size=size,
                            load=load,
                            seed=seed,
                            threads=threads,
                            repeats=options.repeats if size in options.sizes else 0,
                            finest=options.finest if size in options.sizes else TRUE_ERROR,
                        )
                        keys = ("code", "size", "load", "seed", "threads")
                        results["solves"] = replace(results["solves"], records, keys)
                        keep(results, work)
            for size in options.sweep_sizes:
                found = measure_sweep(
                    own["roughcontact"], work, size=size, seed=options.seeds[0], threads=threads
                )
                results["sweeps"] = replace(results["sweeps"], [found], ("size", "threads"))
                keep(results, work)
            if options.shortcut_size and threads == min(options.threads):
                results["shortcuts"] = measure_shortcuts(
                    own["roughcontact"],
                    work,
                    size=options.shortcut_size,
                    seed=options.seeds[0],
                    repeats=options.repeats,
                )
    memory = measure_memory(pythons, work, sizes=options.memory_sizes, seed=options.seeds[0])
    results["memory"] = replace(results["memory"], memory, ("code", "size"))
    keep(results, work)
    print(page.table(results))
    if options.page:
        page.write(results, options.page)


if __name__ == "__main__":
    main()
