"""Time and peak memory of each part of `rc.evaluate`: levelling, window, solve and statistics, the ±.

    python benchmarks/parts.py --points 1024
    python benchmarks/parts.py --points 8192 --threads 2 --write

The map is that of `chain.py`, with three loads. Parts are told apart by what `progress` is called with, so
that the last one, the ±, has the verdicts with it. Peak memory is that of the process during the part, the
map and what earlier parts have left included; where no peak can be reset (Linux does) it is that so far.
"""

import argparse
import resource
import sys
import time
from contextlib import suppress
from pathlib import Path

import pandas as pd
from cases import surface

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc

SLOPE, MODULUS = 0.1, 1e9  # rms gradient of the map, whose points are 1 um apart; E* in Pa
LOADS = (0.01, 0.05, 0.2)  # over E* and the rms gradient
PARTS = {"levelling": "level", "periodic window": "window", "solving": "solve", "error budget": "±, verdicts"}
TABLE = Path(__file__).parent / "results/parts.csv"


class Clock:
    """Takes the time of each part; an instance is given to `evaluate` as `progress`."""

    def __init__(self):
        self.rows, self._part, self._began = [], "", (0.0, 0.0)

    def __call__(self, done, total, text):
        """Begin a part where the text is the first word of one: within a part there are others."""
        if text in PARTS:
            self.end()
            self._part = PARTS[text]

    def end(self):
        """End the part that is at work, and begin to measure anew."""
        now = time.process_time(), time.perf_counter()
        if self._part:
            cpu, wall = (end - start for end, start in zip(now, self._began, strict=True))
            row = {"part": self._part, "CPU s": cpu, "wall s": wall, "peak memory (MB)": peak_memory()}
            self.rows.append(row)
            print({key: value if isinstance(value, str) else round(value, 2) for key, value in row.items()})
        with suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5")  # the peak begins again
        self._began = now


def peak_memory():
    """Return the largest memory (MB) of this process since its peak was reset, or since it began."""
    with suppress(OSError):
        lines = Path("/proc/self/status").read_text().splitlines()
        return next(float(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1e3
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def measured(points, *, threads=1):
    """Return a row for each part of the evaluation of a map of so many points per side."""
    height = rc.height_map(SLOPE * points * surface(points, 0), 1.0, unit="um")
    clock = Clock()
    rc.evaluate(
        height, contact_modulus=MODULUS, relative_pressure=list(LOADS), threads=threads, progress=clock
    )
    clock.end()
    return [{"points per side": points, "threads": threads, **row} for row in clock.rows]


def main(*, points, threads, write):
    """Print the table of one map, or write it."""
    table = pd.DataFrame(measured(points, threads=threads)).round(1)
    if write:
        table.to_csv(TABLE, index=False)
    print(table.to_string(index=False))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--points", type=int, default=1024, help="per side")
    parser.add_argument("--threads", type=int, default=1, help="of the solver")
    parser.add_argument("--write", action="store_true")
    main(**vars(parser.parse_args()))
