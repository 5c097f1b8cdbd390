"""Report after a run in which surfaces have failed: `python -m roughcontact.command_line.unfinished`.

The workflow calls it when it ends with an error, with configuration and folders as JSON on standard input. It
writes the partial report and names the missing surfaces.
"""

import json
import sys

from roughcontact.configuration.generated import changed_settings
from roughcontact.configuration.plan import Plan
from roughcontact.configuration.study import read_study
from roughcontact.errors import RoughContactError
from roughcontact.report.partial import write_partial_results


def main() -> int:
    """Write the partial report, and print on standard error the missing surfaces and the next steps.

    The exit code is 0.
    """
    stated = json.load(sys.stdin)
    try:
        plan = Plan(*read_study(**stated, checked=True))
        changed = {case: changed_settings(settings) for case, settings in plan.cases.items()}
        failures = write_partial_results(plan, changed=changed)
    except (RoughContactError, OSError) as error:
        print(
            f"Not finished, and no report of what is finished can be written: {error}",
            file=sys.stderr,
        )
        return 0
    names = ", ".join(dict.fromkeys(failure["surface"] for failure in failures)) or "the report"
    lines = [f"Not finished: {names}. The lines with ERROR above give the reasons; logs/ has more."]
    if 0 < len(failures) < len(plan.runs):
        lines += [
            "results/report.html and results/summary.csv have the others, and name these with the reason.",
            "Correct the cause and run again; finished jobs are not repeated.",
        ]
    else:
        lines += [
            "A row of the table of surfaces that starts with # is ignored: run again without these rows for",
            "the report of the others; finished jobs are not repeated.",
        ]
    print(*lines, sep="\n", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
