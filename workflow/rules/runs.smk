# What a run says where a job fails, and how it is known whether a run is at work in a folder.
import logging
import re
import signal
import socket
import threading
import time

try:
    import fcntl
except ImportError:  # not on Windows
    fcntl = None


def hold():
    """Lock .snakemake/running for as long as this process lives, and return the open file.

    The system frees the lock when the process ends, in whatever way: by this a job knows that its run is gone
    (`_job.py`), and `run.py` that the locks of Snakemake are those of a run that was killed. The file names
    computer and run, so that a job of a run that was killed does not take the next one for its own.
    """
    if fcntl is None or not workflow.is_main_process or workflow.output_settings.dryrun:
        return None
    os.environ.pop("ROUGHCONTACT_RUN", None)  # of a run that this one is a part of
    try:
        os.makedirs(".snakemake", exist_ok=True)
        file = open(".snakemake/running", "a+", encoding="utf-8")
        # a moment, since the jobs of a run that was just killed have to notice it
        for _ in range(20):
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                time.sleep(0.1)
        else:
            return None  # another run: Snakemake refuses this one
        run = f"{os.getpid()}-{time.time_ns()}"
        line = f"{socket.gethostname()} {run}\n".encode()
        # in place, then cut: a kill in between leaves the computer's name
        with open(".snakemake/running", "r+b", buffering=0) as content:
            content.write(line)
            content.truncate(len(line))
        os.environ.update(ROUGHCONTACT_RUN=run)  # for its jobs
        return file
    except OSError:  # a folder that cannot be written, or one without locks
        return None


RUNNING = hold()


def without_limit(record):
    """Lift Snakemake's limit of 100 jobs a second when a run begins, before which its settings are not known.

    Under a limit every job that ends starts a clock that looks for work each second until nothing is left that can
    begin: after some hundred jobs that takes longer than the jobs. A limit of the user's own stays.
    """
    if getattr(record, "event", None) == "workflow_started":
        limit = workflow.scheduling_settings.max_jobs_per_timespan
        if limit is not None and (limit.max_jobs, limit.timespan) == (100, 1):
            workflow.scheduling_settings.max_jobs_per_timespan = None
    return True


logging.getLogger("snakemake.logging").addFilter(without_limit)


KILLED = []  # what was said of jobs that could not say it themselves


# what Snakemake calls the files of our rules in its messages
OURS = {
    HERE.join(path.name).get_path_or_uri(secret_free=True)
    for path in (ROOT / "workflow/rules").glob("*.smk")
}


class OneLine(logging.Filter):
    """Leave of a failed job the one line that its script has said, or say that it was killed.

    Snakemake says of each failed script the command with a temporary path, then the job with its files.
    """

    def __init__(self):
        super().__init__()
        self.ended = threading.local()  # both come from the thread of the job
        self.over = False

    def filter(self, record):
        event = getattr(record, "event", None)
        text = str(record.msg)
        if text.startswith("Exiting because a job execution failed"):
            # Snakemake before 9.26 says all errors once more below
            self.over = True
            record.msg = text.replace("below", "above")
        elif self.over and event in ("job_error", "group_error"):
            return False
        if event == "run_info":  # for screens that show surfaces instead of jobs
            record.surfaces = surfaces_of_jobs()
        failed = re.search('CalledProcessError in file "(.+?)", line', text)
        if event == "error" and failed and failed[1] in OURS:
            self.ended.how = text
            return False
        if event == "job_error" and getattr(self.ended, "how", None):
            how, self.ended.how = self.ended.how, None
            if (line := last_words(record, how)) is None:
                return False
            record.event, record.msg = "error", line
            KILLED.append(line)
        elif event == "group_error" and of_ours(record.job_error_info[0]["jobid"]):
            return last_words_of_a_group(record)
        elif event == "job_error" and record.indent and of_ours(record.jobid):
            return False  # one of a group, which has said it
        elif event == "job_error" and (line := last_words_on_a_cluster(record)):
            record.event, record.msg = "error", line
            KILLED.append(line)
        elif text.startswith("--keep-incomplete") and keeps_files():
            return False  # nothing that is kept is incomplete
        return True


def surfaces_of_jobs():
    """Return the row of the table that each job waiting to run works for: job -> name."""
    rows = dict(zip(MEASURED, MEASURED)) | {
        name: member.pair for name, member in MEMBERS.items()
    }
    for member in MEMBERS.values():
        rows |= {member.face: member.pair, member.counter_face: member.pair}
    return {
        job.jobid: rows[name]
        for job in workflow.dag.needrun_jobs()
        if (name := job.wildcards_dict.get("surface")) in rows
    }


def last_words_on_a_cluster(record):
    """Return what to say about a job of SLURM, from the log that SLURM keeps of it; None where it tells nothing."""
    text = kept_by_slurm(record.log)
    job = job_of(record.jobid)
    if why := why_killed(text, job):
        return f"[{job_name(job)}] ERROR: {why}"
    said = said_in(text)
    return said[-1] if said else None


def last_words_of_a_group(record):
    """Say what the jobs of a group have said that failed, or why the group was killed; return whether to say it."""
    text = kept_by_slurm(record.aux_logs)
    jobs = [job_of(info["jobid"]) for info in record.job_error_info]
    left = [job for job in jobs if not is_done(job)]
    lines = [line for line in said_in(text) if line not in KILLED]
    if left and (why := why_killed(text, workflow.dag.get_job_group(left[0]))):
        found = {job.wildcards.surface for job in left}
        names = [name for name in (*MEASURED, *MEMBERS) if name in found]
        more = f" and {len(names) - 3} more" * (len(names) > 3)
        lines.append(f"[{', '.join(names[:3])}{more}] ERROR: {why}")
        KILLED.extend(f"[{job_name(job)}] ERROR: {why}" for job in left)
    KILLED.extend(lines)
    record.event, record.msg = "error", "\n".join(lines)
    return bool(lines)


def kept_by_slurm(logs):
    """Return the log that SLURM keeps of a job, empty where there is none."""
    kept = [path for path in map(str, logs) if "/slurm_logs/" in path]
    try:
        with open(kept[-1], encoding="utf-8", errors="replace") as file:
            return file.read()
    except (IndexError, OSError):
        return ""


def said_in(text):
    """Return the lines by which scripts have said why they failed."""
    return list(dict.fromkeys(re.findall(r"^\[.*?\] ERROR: .+$", text, re.M)))


def why_killed(text, job):
    """Return why SLURM has killed a job or a group, by its log; None where it has not."""
    asked = job.resources
    if re.search("exceeded .*memory limit|oom.kill", text, re.I):
        why = f"took more memory than the {asked.get('mem_mb')} MB it had asked for"
    elif "DUE TO TIME LIMIT" in text:
        why = f"took longer than the {asked.get('runtime')} minutes it had asked for"
    else:
        return None
    again = job.attempt <= (job.restart_times or 0)
    return f"killed, {why}" + ("; it is tried again with more" if again else "")


def job_of(number):
    """Return the job of a number, by which records of Snakemake's logger name it."""
    return next(job for job in workflow.dag.jobs if job.jobid == number)


def of_ours(number):
    """Return whether a job is of this workflow, by its number."""
    return ours(job_of(number).rule)


def job_name(job):
    """Return rule and wildcards of a job."""
    return " ".join([job.rule.name, *map(str, job.wildcards)])


def last_words(record, how):
    """Return what to say about a job that was ended; None where its script has said why it failed."""
    status = re.search(r"<Signals\.(\w+)|exit status (\d+)", how)
    code = int(status[2] or 0) if status else 1
    if code == 1:  # that of an error in Python
        return None
    try:  # above 128 a shell in between reports a signal
        ended_by = signal.Signals(code - 128).name if code > 128 else status[1]
    except ValueError:
        ended_by = None
    ended_by = ended_by or f"status {code}"
    job = job_of(record.jobid)
    name = job_name(job)
    for file in job.output:  # what it was writing, load by load say, goes with it
        Path(file).with_name(f".{Path(file).name}.partial").unlink(missing_ok=True)
    if ended_by == "SIGKILL":
        # the target cost has asked for nothing
        asked = job.resources.get("mem_mb")
        asked = f": it had asked for {asked} MB" if asked else ""
        return (
            f"[{name}] ERROR: killed; probably out of memory{asked}. "
            "Free some memory, or run fewer jobs at once (--cores 1), and run again"
        )
    if ended_by in ("SIGTERM", "SIGINT", "SIGHUP"):
        return (
            f"[{name}] ERROR: was ended from outside ({ended_by}); run again to go on"
        )
    return (
        f"[{name}] ERROR: ended without a word ({ended_by}); run again, and where it "
        f"comes back please report it with {', '.join(record.log)}"
    )


logging.getLogger("snakemake.logging").addFilter(OneLine())


def unfinished():
    """Return what to tell a user whose run ended with an error."""
    names = [
        name
        for name in SOLVED
        if not all(
            os.path.exists(stage_file(stage)({**run, "surface": name}))
            for run in RUNS
            for stage in SECTIONS
        )
    ]
    names = ", ".join(names) or "the report"
    said = (
        f"Not finished: {names}. The lines with ERROR above say why; logs/ has more.\n"
    )
    if report_of_the_rest():
        return (
            f"{said}results/report.html and results/summary.csv have the others, and name these with the reason.\n"
            "Run again when it is mended; what is done is not done again."
        )
    if not workflow.execution_settings.keep_going:
        said += "The other surfaces go on to their end, and the report is made of them, with --keep-going.\n"
    return (
        f"{said}A row of the table of surfaces that starts with # is left out: so run again for the report\n"
        "of the rest, what is done is not done again."
    )


def report_of_the_rest():
    """Write dataset, table and page of what a run with --keep-going has finished; return whether there is any."""
    waiting = [
        job for job in workflow.dag.needrun_jobs() if not workflow.dag.finished(job)
    ]
    asked = any(job.rule.name == "report" for job in waiting)
    if not (asked and workflow.execution_settings.keep_going):
        return False
    missing = {str(file) for job in waiting if not is_done(job) for file in job.output}
    entries, panels, failures = [], [], []
    for run in RUNS:
        run = {"case": None, **run}
        statistics = stage_file("statistics")({**run, "case": run["case"] or ""})
        panel = f"{FOLDER}/panel.html".format(**run)
        if missing & {statistics, panel}:
            failures.append({**run, "reason": reason(**run)})
        else:
            entries.append({**run, "statistics": statistics})
            panels.append(panel)
    if not entries:
        return False
    from roughcontact.report.rest import write_rest

    # without what is known of their last jobs, by which unchanged contents count as unchanged whatever the date
    for job in workflow.dag.jobs:
        if job.rule.name in ("collect", "report"):
            for file in job.output:
                workflow.persistence.cleanup_metadata(file)
    write_rest(
        "results",
        staging=".snakemake/rest",
        entries=entries,
        panels=panels,
        failures=failures,
        title=CASES[next(iter(CASES))]["report"]["title"],
        settings=run_settings(),
        settings_of_statistics=run_settings(
            lambda settings: settings_of(settings, "statistics")
        ),
        pairs={name: member.pair for name, member in MEMBERS.items()},
    )
    return True


def reason(surface, case):
    """Return why a surface has no results under a case: what the first of its scripts that failed has said."""
    surfaces = [surface]
    if surface in MEMBERS:
        surfaces += [MEMBERS[surface].face, MEMBERS[surface].counter_face]
    cases = [case, *(other for other in CASES if other != case)] if STUDY else [None]
    for case in cases:
        for name in surfaces:
            folder = LOGS.format(case=case, surface=name)
            for step in [*STEPS, "crosscheck"]:
                if os.path.exists(log := f"{folder}/{step}.log"):
                    with open(log, encoding="utf-8", errors="replace") as file:
                        said = re.findall(r"^\[.*?\] ERROR: (.+)$", file.read(), re.M)
                    if said:
                        return said[-1]
            for line in KILLED:
                job, _, said = line.partition("] ERROR: ")
                if {name, *filter(None, [case])} <= set(job.strip("[").split()):
                    return said
    return "not finished"
