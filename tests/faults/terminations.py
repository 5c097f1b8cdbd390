"""End `roughcontact run` by SIGTERM on a loaded machine, and look for processes that it leaves.

Half of the times are random ones of the run, the others those at which a job is just being started.

    .venv/bin/python tests/faults/terminations.py                 # 50 tries: about ten minutes
    .venv/bin/python tests/faults/terminations.py --tries 5 --load 8

The processes are looked for at the moment at which the program has ended, without a time in which they might
notice it by themselves. Returns 1 where there was one, or where the program went on after the signal.
"""

import argparse
import random
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import psutil
from kills import session, words
from study import begin, command, environment, start_again, write_study

TARGETS = tuple(f"results/surface-{number}/window.nc" for number in range(1, 4))
LONGEST = 60.0  # seconds in which a run has to end


@contextmanager
def load(processes: int):
    """Keep the processor busy with so many processes."""
    busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(processes)]
    try:
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


def end_at_random(folder: Path, tries: int, seed: int) -> list[str]:
    """End so many runs of a study at random times, and return what went wrong, a sentence each.

    `folder` is an empty one.
    """
    write_study(folder, sides=(40,) * len(TARGETS), cases=False)
    choose, wrong = random.Random(seed), []
    start = time.monotonic()
    subprocess.run(command(folder, *TARGETS), env=environment(), check=True, capture_output=True)
    longest = time.monotonic() - start
    for number in range(1, tries + 1):
        start_again(folder)
        delay = choose.uniform(0, longest)
        run = begin(command(folder, *TARGETS), folder / "said.txt")
        if number % 2:
            time.sleep(delay)
        else:
            delay = wait_for_a_job(run, folder)
            time.sleep(further := choose.uniform(0, 0.05))
            delay += further
        run.terminate()
        try:
            run.wait(timeout=LONGEST)
        except subprocess.TimeoutExpired:
            wrong.append(f"try {number}, after {delay:.2f} s: still at work {LONGEST:g} s later")
        survivors = session(run)
        wrong += [
            f"try {number}, after {delay:.2f} s: left {words(process_left)}" for process_left in survivors
        ]
        for process in survivors:
            process.kill()
        run.wait()
        psutil.wait_procs(survivors)
        print(f"try {number}: ended after {delay:.2f} s, {len(wrong)} wrong so far", flush=True)
    return wrong


def wait_for_a_job(run, folder):
    """Wait until a job has begun, which opens its log first; return the time taken."""
    start = time.monotonic()
    while run.poll() is None and not list(folder.glob("logs/**/*.log")):
        time.sleep(0.001)
    return time.monotonic() - start


def main() -> int:
    """End as many runs as the command line says, and say what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--tries", type=int, default=50)
    parser.add_argument("--load", type=int, default=4, help="processes that keep the machine busy")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    with tempfile.TemporaryDirectory() as folder, load(arguments.load):
        wrong = end_at_random(Path(folder), arguments.tries, arguments.seed)
    print(*wrong, f"{len(wrong)} wrong in {arguments.tries} tries", sep="\n")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
