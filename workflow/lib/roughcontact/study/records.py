"""What the last run has left in results/, so that files of another one that replace them are noticed."""

import json
import os
import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any

from roughcontact.io.guards import file_state
from roughcontact.io.seal import stated_seal
from roughcontact.study.plan import Plan

LAST_RESULTS = Path(".snakemake/roughcontact-results")
_OF_ALL = [f"results/{name}.nc" for name in ("statistics", "groups")] + ["results/report.html"]
_OF_ALL += [f"results/{name}.csv" for name in ("summary", "uncertainty", "groups", "comparisons")]


def replaced_files() -> list[str]:
    """Return the files that are not as the last run has left them; of all together also those not noted."""
    last, changes = dict[str, Any](), list[str]()
    with suppress(OSError, ValueError, TypeError):  # damaged, or of anybody
        last = dict(json.loads(LAST_RESULTS.read_text("utf-8")))
        states = (path for path, (state, _) in last.items() if file_state(path) not in (state, None))
        changes = [path for path in states if _content(path) != last[path][1]]
    return [*(path for path in _OF_ALL if path not in last and Path(path).exists()), *changes]


def files_of_run(plan: Plan) -> list[str]:
    """Return the paths of all files that a run may leave."""
    return [*plan.files, *_OF_ALL]


def note_results(plan: Plan) -> None:
    """Note the results that a run leaves at its end; until then, and where it was killed, none are noted."""
    with suppress(OSError):
        files = filter(os.path.exists, files_of_run(plan))
        record = {path: (file_state(path), _content(path)) for path in files}
        LAST_RESULTS.write_text(json.dumps(record), "utf-8")


def _content(path: str) -> str:
    """Return the seal of a netCDF file, the checksum of any other."""
    return stated_seal(Path(path)) if path.endswith(".nc") else f"{zlib.crc32(Path(path).read_bytes()):08x}"
