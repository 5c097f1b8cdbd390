"""Report after a run in which surfaces have failed: `python -m roughcontact.study.failures`.

Each job leaves a record by its log, `logs/ground/contact.json`: what it has read, how many warnings it gave,
whether it has come to its end or why not. So the report has the finished surfaces, and names the others.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputFileError, RoughContactError
from roughcontact.study.checksums import checksum
from roughcontact.study.places import PARTIAL
from roughcontact.study.plan import Plan
from roughcontact.study.study import read_study
from snakemake_logger_plugin_roughcontact.screen import BAR, ERASE, read_record

if TYPE_CHECKING:
    from roughcontact.results.collect import Failure

PAGE = Path("results/report.html")


def main() -> int:
    """Write the report, and print on standard error the missing surfaces and the next steps.

    The workflow gives configuration and folders as JSON; the exit code is 0.
    """
    study = json.load(sys.stdin)
    try:
        plan = Plan(*read_study(**study, checked=True))
        failures = report_finished(plan)
    except (RoughContactError, OSError) as error:
        print(f"Not finished, and no report of what is finished can be written: {error}", file=sys.stderr)
        return 0
    names = ", ".join(dict.fromkeys(failure["surface"] for failure in failures)) or "the report"
    lines = [f"Not finished: {names}. The lines with ERROR above give the reasons; logs/ has more."]
    if 0 < len(failures) < len(plan.results):
        lines += [
            "results/report.html and results/summary.csv have the others, and name these with the reason.",
            "Correct the cause and run again; finished jobs are not repeated.",
        ]
    else:
        lines += [
            "A row of the table of surfaces that starts with # is ignored: run again without these rows for",
            "the report of the others; finished jobs are not repeated.",
            *["results/report.html and the tables beside it are of an earlier run."] * PAGE.exists(),
        ]
    bar = ERASE if sys.stderr.isatty() or BAR in os.environ else ""  # which stands where they begin
    print(bar + "\n".join(lines), file=sys.stderr)
    return 0


def report_finished(plan: Plan) -> "list[Failure]":
    """Write the report of the finished surfaces, and return a `Failure` for each of the others.

    Of all or none nothing is written.
    """
    from roughcontact.report.gather import write_results
    from roughcontact.results.collect import Failure, result_entry

    reasons = {result: failure_reason(plan, result) for result in plan.results}
    finished = [
        result_entry(result, f"results/{result}/statistics.nc") for result in reasons if not reasons[result]
    ]
    failures = []
    for result, reason in reasons.items():
        if reason:
            case, _, surface = result.rpartition("/")
            failures.append(Failure(surface=surface, case=case or None, reason=reason))
    if finished and failures:
        # before anything is written: the next run makes the report again, also where the disk is full now
        PARTIAL.write_text(f"{time.time_ns()}\n", encoding="utf-8")
        write_results(PAGE.parent, finished=finished, **plan.report_arguments(), failures=failures)
    return failures


def failure_reason(plan: Plan, result: str) -> str:
    """Return why a result is missing: an error of a job, a file that is gone; empty for a finished one.

    Finished is a result whose files exist, are not older than what they are made of, and record the settings
    and checksums of this run.
    """
    from roughcontact.results.storage import check_origin, read_dataset

    jobs = [(log, record) for log in plan.log_files(result) if (record := read_record(log))]  # begun ones
    for log, record in jobs:
        if record.get("error"):
            return str(record["error"])
        if not record["done"]:
            return f"ended without a word, as a job does that is killed: {log}"
    sources = plan.all_sources(result)
    if missing := [path for path in sources if not Path(path).exists()]:
        return f"{missing[0]}: is gone since the run began; put it back and run again"
    folder, statistics = Path("results", result), f"results/{result}/statistics.nc"
    solved = [*(plan.file(stage, result) for stage in ("height", "levelled", "window")), statistics]

    def date(path: str | Path) -> int:
        return Path(path).stat().st_mtime_ns

    checksums = {path: digest for _, record in jobs for path, digest in record["sources"].items()}
    try:
        dates = [*map(date, solved), *sorted(map(date, plan.further_files(result)))]
        dates += [date(folder / name) for name in ("panel.html", "panel.json")]
        attrs = read_dataset(statistics).attrs
        check_origin(attrs, statistics, plan.origin("statistics", result, checksum))
    except (OSError, InputFileError):
        return "not finished"
    of_this_run = dates == sorted(dates) and all(checksums.get(path) == checksum(path) for path in sources)
    return "" if of_this_run else "not finished"


def start_partial_report(config: Mapping[str, Any], folders: Sequence[str | Path], root: Path) -> None:
    """Write the report by a process of its own: that of Snakemake imports nothing that computes.

    `config` is the content of the configuration, `folders` the search path of the table, `root` the checkout.
    """
    study = {"config": config, "folders": folders, "measured_in": [".", root]}
    path = os.pathsep.join([str(root / "workflow/lib"), *sys.path])
    subprocess.run(
        [sys.executable, "-m", "roughcontact.study.failures"],
        input=json.dumps(study, default=str),
        text=True,
        env=os.environ | {"PYTHONPATH": path, "PYTHONSAFEPATH": "1"},
        check=False,
    )


if __name__ == "__main__":
    sys.exit(main())
