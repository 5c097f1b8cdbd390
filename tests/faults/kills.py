"""Kill runs of a study at random times, take them up again, and compare what they leave byte by byte.

    .venv/bin/python tests/faults/kills.py               # 200 kills: about an hour
    .venv/bin/python tests/faults/kills.py --kills 12
    .venv/bin/python tests/faults/kills.py --write docs/explanation/kills.csv

A run is killed again and again, each time a little further, until it has come to its end; then its results
are compared with those of a run that was left alone, and the next run begins from nothing. After half of the
kills the same command goes on at once, after the others when no job is left, but for those of the program
alone. What is killed:

- script: one job of the run;
- scheduler: Snakemake alone, whose jobs `roughcontact run` then ends;
- wrapper: the program `roughcontact run` alone: what it has started goes on until the next run ends it;
- terminated: the same program, by SIGTERM, as a service or a container ends one;
- group: the run and all its jobs at once;
- writing: the same, at the moment a result is being written.

Returns 1 where a file was there that is not whole, a run was refused or failed, a job outlived its run, or a
byte differed; each is said when it is seen, and the folder is kept as it was then, with what its runs have
said.
"""

import argparse
import csv
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import psutil
from study import begin, command, environment, results, start_again, write_study

from roughcontact.results.storage import read_dataset

GATHERED = ("results/statistics.nc", "results/summary.csv", "results/uncertainty.csv", "results/report.html")
RULES = ("prepare", "contact", "statistics", "panel", "report")
KINDS = ("script", "scheduler", "wrapper", "terminated", "group", "writing")
HANGS = 900.0  # seconds from which a run that does nothing any more is taken for one that never will
AFTERWARDS = 5.0  # seconds in which jobs have to end with their run
COUNTED = {
    "kills": "kills",
    "script": "of a job",
    "scheduler": "of Snakemake",
    "wrapper": "of roughcontact run alone",
    "terminated": "of roughcontact run alone, by SIGTERM",
    "group": "of everything",
    "writing": "of everything, while a result was written",
    "at once": "after which the run went on at once",
    "half files": "files that were not whole",
    "refused or failed": "runs that were refused afterwards, or failed",
    "hung": "runs that hung",
    "jobs that outlived their run": "jobs that outlived their run",
    "runs": "runs that came to their end",
    "differing files": "files that differed then",
}
FEW = 6  # kills that a run should bear


def kill_at_random(
    folder: Path, kills: int, seed: int, targets: tuple[str, ...] = (), **study
) -> tuple[Counter, list[str]]:
    """Kill runs of a study so many times; return the counts, and what went wrong in words.

    Parameters
    ----------
    folder : Path
        an empty folder.
    kills : int
    seed : int
        of times and kinds.
    targets : tuple of str
        what is run; all where there are none.
    **study
        arguments of `write_study`.
    """
    (left_alone := folder / "left-alone").mkdir()
    (killed := folder / "killed").mkdir()
    counts = Counter(dict.fromkeys(COUNTED, 0))
    wrong: list[str] = []
    for study_folder in (left_alone, killed):
        write_study(study_folder, **study)
    start = time.monotonic()
    subprocess.run(command(left_alone, *targets), env=environment(), check=True, capture_output=True)
    longest = 0.1 * (time.monotonic() - start)
    expected = results(left_alone)
    choose = random.Random(seed)

    def complain(kind: str, *sentences: str) -> None:
        """Count what went wrong and say it, and keep the folder as it is."""
        counts[kind] += len(sentences)
        if sentences:
            copy = folder / f"wrong-{len(wrong) + 1}"
            shutil.copytree(killed, copy, symlinks=True, ignore_dangling_symlinks=True)
            wrong.extend(f"{kind}: {sentence} ({copy})" for sentence in sentences)
            print(*wrong[-len(sentences) :], sep="\n", file=sys.stderr, flush=True)

    while counts["kills"] < kills:
        start_again(killed)
        shutil.rmtree(killed / "said", ignore_errors=True)
        longest = run_with_kills(killed, targets, kills, longest, choose, expected, counts, complain)
        partial_files = [str(path) for path in killed.glob("results/**/.*.partial")]
        counts["runs"] += 1
        differing = differences(expected, killed) + partial_files
        complain("differing files", *(f"after run {counts['runs']}: {name}" for name in differing))
        print(dict(counts), file=sys.stderr, flush=True)
    return counts, wrong


def run_with_kills(folder, targets, kills, longest, choose, expected, counts, complain):
    """Kill one run again and again until it has come to its end; return the longest time to wait for a kill.

    It grows while kills come too early for any progress, and falls where a run bore few of them, so that it
    suits the machine and what else it does.
    """
    kind, kills_before = "none", counts["kills"]
    (folder / "said").mkdir()
    while True:
        result_count = len(results(folder))
        file = folder / f"said/{counts['kills'] - kills_before}.txt"
        run = begin(command(folder, *targets), file)
        enough = counts["kills"] >= kills
        delay = choose.uniform(0, longest)
        previous, kind, at_once = kind, choose.choice(KINDS), choose.random() < 0.5
        victims = [] if enough else wait_and_find(run, folder, kind, delay)
        if not victims:
            if end_of(run):
                complain("refused or failed", f"after a kill of {previous}: {file.read_text()[-2000:]}")
            return longest * (0.7 if counts["kills"] - kills_before < FEW else 1.0)
        for victim in victims:
            with suppress(psutil.NoSuchProcess):
                victim.send_signal(signal.SIGTERM if kind == "terminated" else signal.SIGKILL)
        counts["kills"] += 1
        counts[kind] += 1
        # where a job alone was killed, or the run was asked to end, it ends by itself
        if end_of(run) == -signal.SIGKILL and kind in ("script", "terminated"):
            complain("hung", f"after a kill of {kind}: {file.read_text()[-2000:]}")
        if at_once or kind == "wrapper":
            counts["at once"] += 1
        else:
            _, outlived = psutil.wait_procs(session(run), timeout=AFTERWARDS)
            complain("jobs that outlived their run", *(f"after a kill of {kind}: {job}" for job in outlived))
            psutil.wait_procs(outlived)
        half = [
            name
            for name, content in results(folder).items()
            if content != expected.get(name) and not (name in GATHERED and is_whole(folder / name))
        ]
        complain("half files", *(f"after a kill of {kind}: {name}" for name in half))
        if len(results(folder)) == result_count:
            longest *= 1.03
        print(dict(counts), f"{longest:.1f} s", file=sys.stderr, flush=True)


def end_of(run):
    """Return the exit status of a run that is left alone; that of a kill where it hangs."""
    try:
        return run.wait(timeout=HANGS)
    except subprocess.TimeoutExpired:
        os.killpg(run.pid, signal.SIGKILL)
        return run.wait()


def wait_and_find(run, folder, kind, delay):
    """Wait until the time has come, and return the processes to kill; none where the run has ended before."""
    until = time.monotonic() + delay
    while time.monotonic() < until and run.poll() is None:
        time.sleep(0.01)
    while run.poll() is None and time.monotonic() < until + HANGS:
        if kind != "writing" or list(folder.glob("results/**/.*.partial")):
            everyone = family(run)
            scripts = [process for process in everyone if is_job(process)]
            scheduler = [process for process in everyone if " snakemake --snakefile " in words(process)]
            of_kind = {"scheduler": scheduler, "script": scripts[:1]}
            processes = of_kind | dict.fromkeys(("wrapper", "terminated"), everyone[:1])
            processes = processes.get(kind, everyone)
            if processes:
                return processes
            time.sleep(0.05)
        time.sleep(0.002)
    return []


def family(run):
    """Return a process and all its descendants."""
    try:
        parent = psutil.Process(run.pid)
        return [parent, *parent.children(recursive=True)]
    except psutil.NoSuchProcess:
        return []


def session(run):
    """Return the processes that a run has started, also those whose parent is gone."""
    processes = []
    for process in psutil.process_iter():
        try:
            # one that has ended, but is not reaped yet, has no command line
            if os.getsid(process.pid) == run.pid and words(process):
                processes.append(process)
        except ProcessLookupError:
            continue
    return processes


def is_job(process, *rules):
    """Return whether a process is a job, of some rules alone: a fork named after one, or a script."""
    rules = rules or RULES
    try:
        command_line = words(process)
        is_fork = process.name() in rules and "server.py" in command_line
        return is_fork or command_line.endswith(tuple(f".{rule}.py" for rule in rules))
    except psutil.Error:
        return False


def jobs_at_work(run, rule, log):
    """Wait until a run has jobs of a rule, and return them; `log` is what it says."""
    while not (jobs := [process for process in family(run) if is_job(process, rule)]):
        assert run.poll() is None, log.read_text()
        time.sleep(0.002)
    return jobs


def words(process):
    """Return the command line of a process, empty where it is gone."""
    try:
        return " ".join(process.cmdline())
    except psutil.Error:
        return ""


def is_whole(path):
    """Return whether a file that gathers the surfaces is complete: it may be made of some of them."""
    if path.suffix == ".nc":
        return len(read_dataset(path).variables) > 0
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".html":
        return text.rstrip().endswith("</html>")
    return text.endswith("\n") and len({len(row) for row in csv.reader(text.splitlines())}) == 1


def differences(expected, folder):
    """Return the names of files that are not as expected, or that stand on one side only."""
    results_here = results(folder)
    return [
        name for name in sorted({*results_here, *expected}) if results_here.get(name) != expected.get(name)
    ]


def main() -> int:
    """Kill as many times as the command line says, and say what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", type=Path, help="write the counts as CSV")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    folder = Path(tempfile.mkdtemp(prefix="killed-"))
    counts, wrong = kill_at_random(folder, arguments.kills, arguments.seed)
    if arguments.write:
        with arguments.write.open("w", newline="", encoding="utf-8") as stream:
            rows = [(COUNTED[name], number) for name, number in counts.items()]
            csv.writer(stream, lineterminator="\n").writerows([("what", "count"), *rows])
    print(*(f"{number:5d} {COUNTED[name]}" for name, number in counts.items()), *wrong, sep="\n")
    if not wrong:
        shutil.rmtree(folder)
    return int(bool(wrong))


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main())
