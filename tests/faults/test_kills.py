"""The short form of the kills; the full one is a command of its own (see docs/explanation/reliability.md)."""

import fcntl
import re
import signal
import socket
import subprocess
import sys
import time

import psutil
import pytest
from kills import family, kill_at_random, session, words
from study import ROOT, command, environment, write_study
from terminations import end_at_random, load


def test_a_killed_run_goes_on_and_leaves_the_same_bytes(tmp_path):
    counts, wrong = kill_at_random(
        tmp_path, kills=3, seed=3, targets=("results/surface-2/levelled.nc",), cases=False
    )
    assert not wrong
    assert counts["kills"] == 3


RUN_PY = """
import sys
sys.path.insert(0, sys.argv[1])
import run
sys.exit(run.run(sys.argv[2:]))
"""


@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("wrapper", ["roughcontact run", "run.py", "in the background"])
def test_nothing_goes_on_after_the_program_alone_was_ended(tmp_path, by, wrapper):
    """Of a termination Snakemake has cleaned up as after Ctrl-C; after a kill the next run continues."""
    write_study(tmp_path, sides=(48,), cases=False)
    words_of_it = command(tmp_path, "results/surface-1/levelled.nc")
    if wrapper == "run.py":
        words_of_it = [sys.executable, "-c", RUN_PY, str(ROOT), *words_of_it]
    with (tmp_path / "said.txt").open("w") as said:
        run = subprocess.Popen(
            words_of_it,
            env=environment(),
            stdout=said,
            stderr=said,
            start_new_session=True,
            preexec_fn=deaf_to_interruptions if wrapper == "in the background" else None,  # noqa: PLW1509
        )
    try:
        while not any(words(each).endswith(".prepare.py") for each in family(run)):
            assert run.poll() is None, (tmp_path / "said.txt").read_text()
            time.sleep(0.002)
        started = family(run)[1:]
        assert len(started) >= 2
        run.send_signal(by)
        assert run.wait(timeout=60) == (143 if by == signal.SIGTERM else -signal.SIGKILL)
        _, left = psutil.wait_procs([*started, *session(run)], timeout=30)
        assert [words(each) for each in left] == []
        said = (tmp_path / "said.txt").read_text()
        assert "Traceback" not in said
        if by == signal.SIGTERM:
            assert not list(tmp_path.glob(".snakemake/locks/*"))
        assert not list(tmp_path.glob("results/**/*.nc"))
    finally:
        for each in session(run):
            each.kill()


def deaf_to_interruptions():
    """Ignore SIGINT, as shells let programs do that they start in the background."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def test_a_termination_ends_jobs_whose_parent_has_gone(tmp_path):
    """As that of a shell that was ended while it started its program."""
    write_study(tmp_path, sides=(48,), cases=False)
    with (tmp_path / "said.txt").open("w") as said:
        run = subprocess.Popen(
            command(tmp_path, "results/surface-1/levelled.nc"), env=environment(), stdout=said, stderr=said
        )
    while not (started := [each for each in family(run) if words(each).endswith(".prepare.py")]):
        assert run.poll() is None, (tmp_path / "said.txt").read_text()
        time.sleep(0.002)
    orphan = subprocess.Popen(["sleep", "600"], env=started[0].environ())
    try:
        run.terminate()
        assert run.wait(timeout=60) == 143
        assert orphan.wait(timeout=1) == -signal.SIGTERM
    finally:
        orphan.kill()


@pytest.mark.parametrize(("host", "ends"), [(socket.gethostname(), True), ("node-7", False)])
def test_a_job_that_begins_after_its_run_has_ended_ends_as_well(tmp_path, host, ends):
    """But one on another computer of a cluster goes on."""
    (tmp_path / ".snakemake").mkdir()
    (tmp_path / ".snakemake/running").touch()  # as a run leaves it that has ended in order
    script = tmp_path / "job.py"
    script.write_text(
        "import sys, time, types\n"
        f"sys.path.append({str(ROOT / 'workflow/scripts')!r})\n"
        "snakemake = types.SimpleNamespace(rule='prepare', wildcards=[], log=['log'], resources={},\n"
        "                                  input={}, output={})\n"
        "import _job\n"
        "print('at work', flush=True)\n"
        "time.sleep(600)\n"
    )
    variables = environment(ROUGHCONTACT_RUN=f"{host} 1-1")
    job = subprocess.Popen(
        [sys.executable, script], cwd=tmp_path, env=variables, stdout=subprocess.PIPE, text=True
    )
    try:
        job.stdout.readline()
        if ends:
            assert job.wait(timeout=30) == 1
        else:
            with pytest.raises(subprocess.TimeoutExpired):
                job.wait(timeout=2)
    finally:
        job.kill()
        job.communicate()


@pytest.mark.slow
def test_no_termination_on_a_busy_machine_leaves_a_process(tmp_path):
    with load(2):
        assert end_at_random(tmp_path, tries=4, seed=1) == []


@pytest.mark.parametrize("started_by", ["roughcontact run", "snakemake"])
def test_beside_a_run_at_work_none_begins_and_its_locks_stay(tmp_path, started_by):
    write_study(tmp_path, sides=(48,), cases=False)
    first = command(tmp_path, "results/surface-1/levelled.nc")
    if started_by == "snakemake":
        first[2:4] = ["snakemake", "--snakefile", str(ROOT / "Snakefile")]
    with (tmp_path / "said.txt").open("w") as said:
        run = subprocess.Popen(first, env=environment(), stdout=said, stderr=said, start_new_session=True)
    try:
        while not (jobs := [each for each in family(run) if words(each).endswith(".prepare.py")]):
            assert run.poll() is None, (tmp_path / "said.txt").read_text()
            time.sleep(0.002)
        jobs[0].suspend()
        locks = {*tmp_path.glob(".snakemake/locks/*.lock")}
        assert locks
        if started_by == "snakemake":  # which keeps others out itself
            refused = subprocess.run(
                command(tmp_path), env=environment(), capture_output=True, text=True, check=False
            )
            assert refused.returncode == 1
            assert "Directory cannot be locked" in refused.stdout + refused.stderr
        else:
            for beside in (command(tmp_path), command(tmp_path, "--unlock"), command(tmp_path, "--nolock")):
                refused = subprocess.run(
                    beside, env=environment(), capture_output=True, text=True, check=False
                )
                assert refused.returncode == 2
                said = f"a run is at work there (process {run.pid} on {socket.gethostname()})"
                assert said in refused.stderr
                assert len(refused.stderr.splitlines()) == 1
        assert {*tmp_path.glob(".snakemake/locks/*.lock")} == locks
        jobs[0].resume()
        assert run.wait(timeout=60) == 0, (tmp_path / "said.txt").read_text()
    finally:
        for each in session(run):
            each.kill()


@pytest.mark.slow
def test_a_job_that_is_killed_says_how_much_memory_it_had_asked_for(tmp_path):
    write_study(tmp_path, sides=(40,), cases=False)
    with (tmp_path / "said.txt").open("w") as said:
        run = subprocess.Popen(
            command(tmp_path, "results/summary.csv"), env=environment(), stdout=said, stderr=said
        )
    while not (reporting := [each for each in family(run) if words(each).endswith(".report.py")]):
        assert run.poll() is None, (tmp_path / "said.txt").read_text()
        time.sleep(0.002)
    reporting[0].kill()
    assert run.wait(timeout=60)
    said = (tmp_path / "said.txt").read_text()
    asked = r"\n\[report\] ERROR: killed; probably out of memory: it had asked for \d+ MB\. Free some memory"
    assert re.search(asked, said)
    assert "Traceback" not in said


@pytest.mark.slow
def test_a_job_of_a_killed_run_does_not_take_the_next_run_for_its_own(tmp_path):
    write_study(tmp_path, sides=(48,), cases=False)
    run = subprocess.Popen(
        command(tmp_path, "results/surface-1/levelled.nc"),
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    while not (jobs := [each for each in family(run) if words(each).endswith(".prepare.py")]):
        assert run.poll() is None
        time.sleep(0.002)
    (job,) = jobs
    job.suspend()  # it cannot notice that its run is gone
    others = [each for each in family(run) if each != job]
    for each in others:
        each.kill()
    run.wait()
    psutil.wait_procs(others)
    with (tmp_path / ".snakemake/running").open("r+") as held:  # as the next run does
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        held.write(f"{socket.gethostname()} another\n")
        held.truncate()
        held.flush()
        job.resume()
        psutil.wait_procs([job], timeout=20)
        assert not job.is_running()
    assert not list(tmp_path.glob("results/**/*.nc"))
