"""Whether the records of Snakemake, which decide what a run makes again, are those of the results."""

import json
import time
from contextlib import suppress
from pathlib import Path

from roughcontact.io.seal import stated_seal

# An input of the first jobs, as old as the records of Snakemake. Without these, as in a copy of results/
# alone, Snakemake compares dates only: this file is new there, so that all is made again
RECORDS = Path(".snakemake/roughcontact-records")
# what the last run left in results/, to know results of another folder that are copied over them
LAST_RESULTS = Path(".snakemake/roughcontact-results")


def lost_records() -> str:
    """Return why Snakemake's records are not of the results, which begin anew then; empty where they are."""
    reason, last = "", {}
    with suppress(OSError, ValueError):
        last = json.loads(LAST_RESULTS.read_text("utf-8"))
    if not RECORDS.exists():
        if any(Path("results").glob("*/*.nc")) or any(Path("results").glob("*/*/*.nc")):
            reason = "came without .snakemake, which records the settings behind it"
    elif last and (replaced := [path for path, seal in _seals().items() if seal != last.get(path, seal)]):
        reason = f"is not what the last run here has left ({replaced[0]} differs)"
    if reason or not RECORDS.exists():
        with suppress(OSError):
            RECORDS.parent.mkdir(exist_ok=True)
            # of a small file Snakemake compares the content as well
            RECORDS.write_text(f"{time.time_ns()}\n", "utf-8")
    return reason


def note_results() -> None:
    """Note the results that a run leaves at its end; until then, and where it was killed, none are noted."""
    with suppress(OSError):
        LAST_RESULTS.write_text(json.dumps(_seals()), "utf-8")


def _seals() -> dict[str, str]:
    """Return the seal of the statistics of each result, as far as they can be read and have one."""
    seals: dict[str, str] = {}
    for path in (path for depth in ("*", "*/*") for path in Path("results").glob(f"{depth}/statistics.nc")):
        with suppress(OSError):
            seals[path.as_posix()] = stated_seal(path)
    return {path: seal for path, seal in seals.items() if seal}
