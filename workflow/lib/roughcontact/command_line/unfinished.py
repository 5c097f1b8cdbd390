"""Report after a run in which surfaces have failed: `python -m roughcontact.command_line.unfinished`.

The workflow calls it with configuration and folders as JSON; it names the missing surfaces.
"""

import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from roughcontact.configuration.plan import Plan
from roughcontact.configuration.study import read_study
from roughcontact.errors import RoughContactError
from snakemake_logger_plugin_roughcontact.screen import BAR, ERASE

PAGE = Path("results/report.html")


def start_partial_report(config: Mapping[str, Any], folders: Sequence[str | Path], root: Path) -> None:
    """Write the partial report by a process of its own: that of Snakemake imports nothing that computes.

    `config` is the content of the configuration, `folders` the search path of the table, `root` the checkout.
    """
    study = {"config": config, "folders": folders, "measured_in": [".", root]}
    path = os.pathsep.join([str(root / "workflow/lib"), *sys.path])
    subprocess.run(
        [sys.executable, "-m", "roughcontact.command_line.unfinished"],
        input=json.dumps(study, default=str),
        text=True,
        env=os.environ | {"PYTHONPATH": path, "PYTHONSAFEPATH": "1"},
        check=False,
    )


def main() -> int:
    """Write the partial report, and print on standard error the missing surfaces and the next steps.

    The exit code is 0.
    """
    from roughcontact.report.partial import write_partial_results

    study = json.load(sys.stdin)
    try:
        plan = Plan(*read_study(**study, checked=True))
        failures = write_partial_results(plan)
    except (RoughContactError, OSError) as error:
        print(
            f"Not finished, and no report of what is finished can be written: {error}",
            file=sys.stderr,
        )
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


if __name__ == "__main__":
    sys.exit(main())
