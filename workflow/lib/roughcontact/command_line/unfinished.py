"""What a run leaves in which surfaces have failed: `python -m roughcontact.command_line.unfinished`.

The workflow calls it when it ends with an error, and states configuration and folders as JSON on standard
input. It writes the report of what is finished and says what is not.
"""

import json
import sys

from roughcontact.configuration.plan import Plan
from roughcontact.configuration.study import read_study
from roughcontact.report.partial import write_partial_results


def main() -> int:
    """Write the partial report, and say on standard error what is missing and how to go on.

    Returns
    -------
    int
        exit code 0.
    """
    stated = json.load(sys.stdin)
    plan = Plan(*read_study(stated["config"], stated["folders"], measured_in=stated["measured_in"]))
    failures = write_partial_results(plan)
    names = ", ".join(dict.fromkeys(failure["surface"] for failure in failures)) or "the report"
    lines = [f"Not finished: {names}. The lines with ERROR above say why; logs/ has more."]
    if 0 < len(failures) < len(plan.runs):
        lines += [
            "results/report.html and results/summary.csv have the others, and name these with the reason.",
            "Run again when it is mended; what is done is not done again.",
        ]
    else:
        lines += [
            "A row of the table of surfaces that starts with # is left out: so run again for the report",
            "of the rest, what is done is not done again.",
        ]
    print(*lines, sep="\n", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
