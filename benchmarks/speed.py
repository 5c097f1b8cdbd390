"""Measure the solver on made and measured maps, alone and against others.

    python benchmarks/speed.py FOLDER ... --write
    python benchmarks/speed.py FOLDER ... --held-out --write      # maps that played no part in any choice

FOLDER holds measured maps, files of instruments of any kind; those that cannot be read, or are too small, are
left out. Without folders, made maps alone are measured. Records are kept in `benchmarks/work` one by one, and
what stands there is not measured again unless `--again` says so: a long measurement can be cut into pieces
(`--only PART`) and goes on after it was stopped.
"""

import argparse
import json
import os
import platform
import re
import sys
import warnings
from contextlib import ExitStack
from functools import cache
from pathlib import Path

import cases
import certificate
import clocks
import counts
import numpy as np
import pages
import race
import speed_tables
from worker import Worker

from roughcontact.arguments.maps import spacing
from roughcontact.surface.roughness.parameters import rms_gradient

HERE = Path(__file__).parent
SCRIPTS = {
    "roughcontact": HERE / "own_worker.py",
    "ASPHER": HERE / "rival_aspher.py",
    "Tamaas": HERE / "rival_tamaas.py",
}
COUNTS = {
    part.__name__: part for part in (counts.maps, counts.made, counts.hard, counts.growth, counts.memory)
}
COUNTS |= {"random": certificate.random, "dense": certificate.dense}
TIMES = {"starts": clocks.starts, "pair": clocks.pair, "sweep": clocks.sweep, "race": race.race}
PARTS = COUNTS | {"rungs": race.rungs, "agreement": race.agreement} | TIMES
GROUPS = {"counts": [*COUNTS, "rungs"], "times": list(TIMES)}


class Study:
    """What is measured, and where it is kept.

    Attributes
    ----------
    pythons : dict
        interpreter of each code that is here.
    results : dict
        records by part and name.
    """

    def __init__(self, options: argparse.Namespace):
        """Open the folder of earlier results."""
        self.work = options.work.resolve()
        self.surfaces = self.work / "surfaces"
        self.surfaces.mkdir(parents=True, exist_ok=True)
        self.folders = options.folders
        self.sizes, self.seeds, self.threads = options.sizes, options.seeds, options.threads
        self.growth_sizes, self.memory_sizes = options.growth_sizes, options.memory_sizes
        self.repeats = options.repeats
        self.load = os.getloadavg()[0]  # before anything is measured
        self.file = self.work / "speed.json"
        self.results = json.loads(self.file.read_text(encoding="utf-8")) if self.file.exists() else {}
        self.pythons = {"roughcontact": sys.executable}
        if options.rivals.exists():
            self.pythons |= dict.fromkeys(("ASPHER", "Tamaas"), str(options.rivals.absolute()))
        self.workers = ExitStack()
        self.warm_worker = cache(self._warm_worker)
        self.maps, self.squares = cache(self._maps), cache(self._squares)

    def measure(self, part: str, *, again: bool) -> None:
        """Make the records of a part that are not there, each kept as soon as it is there."""
        if again:
            self.results.pop(part, None)
        records = self.results.setdefault(part, {})
        about = self.results.setdefault("about", {})
        about["machine"] = machine()
        if part in TIMES:
            about.setdefault("load", {})[part] = self.load
        for name, job in PARTS[part](self):
            if name not in records:
                records[name] = job()
                self.keep()
                print(f"{part}: {name}", flush=True)
        self.keep()

    def keep(self) -> None:
        """Write all records, whole or not at all."""
        unfinished = self.file.with_suffix(".part")
        unfinished.write_text(json.dumps(self.results, indent=1), encoding="utf-8")
        unfinished.replace(self.file)

    def made(self, size: int, seed: int) -> Path:
        """Return the file of a made surface."""
        path = self.surfaces / f"made {size} {seed}.npy"
        return path if path.exists() else saved(path, cases.surface(size, seed))

    def _maps(self) -> list:
        """Return name, window and square window (or None) of all measured maps."""
        return list(cases.measured_maps(self.folders))

    def _squares(self) -> list:
        """Return name, file of heights over the side, and rms gradient of all square windows."""
        squares = []
        for name, _, window in self.maps():
            if window is not None:
                side = window.shape[1] * spacing(window)[1]
                path = self.measured(name, window.values / side)
                squares.append((name, path, rms_gradient(window)))
        return squares

    def measured(self, name: str, heights: np.ndarray) -> Path:
        """Return the file of a square window; where it has changed, what was known of it is dropped."""
        path = self.surfaces / f"measured {name}.npy"
        if path.exists() and np.array_equal(np.load(path), heights):
            return path
        for truth in self.surfaces.glob("truth *.npy"):
            if truth.name.endswith(path.name):
                truth.unlink()
        for part in ("rungs", "race"):
            records = self.results.get(part, {})
            for key in [key for key in records if key.startswith(f"{name} ")]:
                del records[key]
        return saved(path, heights)

    def worker(self, code: str, threads: int) -> Worker:
        """Return a new process that solves with a code."""
        worker = Worker(SCRIPTS[code], python=self.pythons[code], threads=threads)
        self.results["about"].setdefault("versions", {})[code] = worker.versions
        return worker

    def _warm_worker(self, code: str, threads: int) -> Worker:
        """Return a process that has solved before, and stays."""
        worker = self.workers.enter_context(self.worker(code, threads))
        worker.ask(heights=str(self.made(64, 0)), load=0.03, tolerance=1e-6)
        return worker


def saved(path: Path, values: np.ndarray) -> Path:
    """Write an array, whole or not at all; return its path."""
    unfinished = path.with_name(f"unfinished {path.name}")
    np.save(unfinished, values)
    return unfinished.replace(path)


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


def parse(arguments=None) -> argparse.Namespace:
    """Return the options of the command."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    add = parser.add_argument
    add("folders", nargs="*", type=Path, help="folders of measured maps")
    add(
        "--only",
        nargs="*",
        choices=[*GROUPS, *PARTS],
        default=list(GROUPS),
        help="parts to measure; none: tables alone",
    )
    add("--again", action="store_true", help="measure what is there already, too")
    add("--rivals", type=Path, default=HERE / ".rivals/bin/python", help="Python that has ASPHER and Tamaas")
    add("--sizes", type=int, nargs="*", default=[256, 512, 1024, 2048], help="points per side of the race")
    add("--seeds", type=int, nargs="*", default=[0, 1, 2], help="of the made maps of the race")
    add("--threads", type=int, nargs="*", default=[1, 2], help="the same number for every code")
    add(
        "--repeats", type=int, default=3, help="timed solves of each code and case; fewer where they are long"
    )
    add("--growth-sizes", type=int, nargs="*", default=[512, 1024, 2048, 4096], help="points per side")
    add("--memory-sizes", type=int, nargs="*", default=[1024, 2048, 4096], help="points per side")
    add("--work", type=Path, default=HERE / "work", help="where records and converged solutions are kept")
    add("--held-out", action="store_true", help="pairs and race of these maps alone, in tables of their own")
    add("--write", action="store_true", help="write tables and pages; else print")
    chosen = parser.parse_args(arguments)
    if chosen.held_out:
        chosen.work, chosen.seeds = chosen.work / "held_out", []
        chosen.only = ["maps", "rungs", "race"] if chosen.only == list(GROUPS) else chosen.only
    return chosen


def main() -> None:
    """Measure what is asked for, and print or write its tables."""
    options = parse()
    warnings.simplefilter("ignore")
    study = Study(options)
    if options.only and "ASPHER" not in study.pythons:
        print(
            f"ASPHER and Tamaas are left out: there is no {options.rivals}; "
            f"{HERE.name}/setup_rivals.sh makes it"
        )
    with study.workers:
        for part in dict.fromkeys(part for name in options.only for part in GROUPS.get(name, [name])):
            study.measure(part, again=options.again)
    tables = speed_tables.tables(study.results)
    if options.write and options.held_out:
        tables_kept = {name: tables[name] for name in ("pairs", "bounds", "race", "ratios") if name in tables}
        pages.publish("speed_held_out", tables_kept, {"maps": len(study.results["maps"])})
    elif options.write:
        pages.publish("speed", tables, speed_tables.about(study.results))
    else:
        pages.show(tables)


if __name__ == "__main__":
    main()
