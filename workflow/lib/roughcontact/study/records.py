"""Whether the records of Snakemake, which decide what a run makes again, are those of the results."""

import json
import os
import zlib
from contextlib import suppress
from pathlib import Path

from roughcontact.io.guards import file_state
from roughcontact.io.seal import stated_seal
from roughcontact.study.places import date_back
from roughcontact.study.plan import Plan

# An input of every job, empty, dated of the present run: Snakemake makes again what it has no record of, as
# after a power failure. Where it has one, it compares the content, which stays.
RECORDS = Path(".snakemake/roughcontact-records")
# what the last run left in results/, to know files of another run that are copied over them, and cut ones
LAST_RESULTS = Path(".snakemake/roughcontact-results")
_ALL = "statistics.nc groups.nc summary.csv uncertainty.csv groups.csv comparisons.csv pairs.csv report.html"


def renew_records(plan: Plan) -> list[str]:
    """Have files made again that Snakemake has no record of; return those that the last run has not left."""
    changed_files: list[str] = []
    with suppress(OSError, ValueError):
        last = json.loads(LAST_RESULTS.read_text("utf-8"))
        changes = (path for path, (state, _) in last.items() if file_state(path) not in (state, None))
        changed_files = [path for path in changes if _content(path) != last[path][1]]
    if not RECORDS.exists():  # results that came without .snakemake
        changed_files = list(filter(os.path.exists, plan.files))
    with suppress(OSError):  # a dry run, in a folder of somebody else
        RECORDS.parent.mkdir(exist_ok=True)
        RECORDS.touch()
        for path in changed_files:
            date_back(path)
    return changed_files


def note_results(plan: Plan) -> None:
    """Note the results that a run leaves at its end; until then, and where it was killed, none are noted."""
    files = filter(os.path.exists, [*plan.files, *(f"results/{name}" for name in _ALL.split())])
    with suppress(OSError):
        record = {path: (file_state(path), _content(path)) for path in files}
        LAST_RESULTS.write_text(json.dumps(record), "utf-8")


def _content(path: str) -> str:
    """Return the seal of a netCDF file, the checksum of any other."""
    return stated_seal(Path(path)) if path.endswith(".nc") else f"{zlib.crc32(Path(path).read_bytes()):08x}"
