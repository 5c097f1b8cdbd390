"""Both ends of a warm worker process: one request a line in, one answer a line out, both JSON.

A request names a file of heights, a load, a tolerance and where to write the pressure. The answer holds the
seconds of the solve alone: neither imports, nor reading and writing of files, nor the first call are in it;
whatever a code sets up anew for a solve (plans, operators, grids) is. With `rehearse`, the same is solved
before, untimed, again and again for half a second: a process that has waited while others worked takes up to
twice as long for its next tenths of a second, whatever it does. `processor_seconds` are those of its own
process, which others on the machine hardly change. `peak_bytes` is how far the memory of the
process rose above what it held before the solve.

Only NumPy is needed here: the environments of all codes import this file.
"""

import json
import os
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np

REHEARSAL = 0.5  # seconds
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def serve(pose, solve, versions: dict) -> None:
    """Answer requests until standard input ends.

    `pose(heights)` makes the input that a code wants, untimed; `solve(problem, load, tolerance, **options)`
    returns the pressure (ny, nx) and a function that gives, untimed, a dict of what else the code says of it.
    """
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what a library prints must not end up among the answers
    print(json.dumps(versions), file=answers)
    path, problem = None, None
    for line in sys.stdin:
        request = json.loads(line)
        if request["heights"] != path:
            path, problem = request["heights"], pose(np.load(request["heights"]))
        run = partial(solve, problem, request["load"], request["tolerance"], **request.get("options", {}))
        memory_before = _memory("VmRSS", reset_peak=True)
        try:
            start = time.perf_counter()
            while request.get("rehearse") and time.perf_counter() - start < REHEARSAL:
                run()
            start, processor_start = time.perf_counter(), time.process_time()
            pressure, details = run()
        except Exception as error:  # a failed solve is a result of the benchmark, not its end
            print(json.dumps({"failure": f"{type(error).__name__}: {error}"}), file=answers)
            continue
        times = {
            "seconds": time.perf_counter() - start,
            "processor_seconds": time.process_time() - processor_start,
        }
        peak = _memory("VmHWM") - memory_before
        if request.get("pressure"):
            np.save(request["pressure"], pressure)
        print(json.dumps(times | {"peak_bytes": peak} | details()), file=answers)


def _memory(name: str, *, reset_peak: bool = False) -> int:
    """Return VmRSS (memory held now) or VmHWM (its peak) of this process in bytes, as Linux counts them."""
    if reset_peak:
        Path("/proc/self/clear_refs").write_text("5")
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(name + ":"):
            return int(line.split()[1]) * 1024
    raise OSError(f"/proc/self/status has no line {name}")


class Worker:
    """A process that solves with one code on a fixed number of threads; `versions` is what it runs on."""

    def __init__(self, script: Path, *, python: str, threads: int):
        environment = os.environ | dict.fromkeys(THREAD_VARIABLES, str(threads))
        self.process = subprocess.Popen(
            [python, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )
        self.versions = json.loads(self._line())

    def ask(self, **request) -> dict:
        """Send a request and return the answer."""
        print(json.dumps(request), file=self.process.stdin, flush=True)
        return json.loads(self._line())

    def _line(self) -> str:
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"the worker ended with exit status {self.process.wait()}")
        return line

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.stdin.close()
        self.process.wait()
