"""What a run leaves where surfaces have failed: dataset, tables and page of the rest, which name them."""

import json
import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from roughcontact.report.page import write_report
from roughcontact.results.collect import (
    Entry,
    Failure,
    collect_statistics,
    pairs_table,
    summary_table,
    with_failures,
)
from roughcontact.results.storage import provenance, write_dataset, write_table


def write_rest(
    folder: str | Path,
    *,
    staging: str | Path,
    entries: Sequence[Entry],
    panels: Sequence[str | Path],
    failures: Sequence[Failure],
    title: str,
    settings: dict[str, Any],
    settings_of_statistics: dict[str, Any],
    pairs: Mapping[str, str],
) -> None:
    """Write `statistics.nc`, `summary.csv`, `pairs.csv` and `report.html` of what a run has finished.

    They are dated before what they are made of, so that the next run makes them again whatever has changed,
    and before they come to their place, so that this holds where the run is killed meanwhile.

    Parameters
    ----------
    folder : path
        where they come to lie.
    staging : path
        a folder of the same disk in which they are written first; what is in it is removed.
    entries : sequence of dict
        what is finished, as `collect_statistics` takes it; one at least.
    panels : sequence of paths
        of the same.
    failures : sequence of dict
        what is not, with the reason.
    title : str
        of the page.
    settings, settings_of_statistics : dict
        of the run (of each case, where there are cases), whole and as far as the statistics depend on them.
    pairs : mapping
        name of a member -> name of its pair; empty where there are no pairs.
    """
    folder, staging = Path(folder), Path(staging)
    shutil.rmtree(staging, ignore_errors=True)
    staging.mkdir(parents=True)
    statistics = collect_statistics(entries)
    checksums = statistics.attrs["source_sha256"]
    origin = provenance(settings_of_statistics, source_sha256=checksums, stage="statistics")
    named = {"failed": json.dumps(list(failures), sort_keys=True)}
    write_dataset(statistics.assign_attrs(origin | named), staging / "statistics.nc")
    summary = summary_table(statistics)
    write_table(with_failures(summary, failures), staging / "summary.csv")
    known = {member: pair for member, pair in pairs.items() if member in set(summary["surface"])}
    if known:
        write_table(pairs_table(summary, known), staging / "pairs.csv")
    write_report(
        staging / "report.html",
        panels=panels,
        statistics=staging / "statistics.nc",
        title=title,
        settings=settings,
        pairs=staging / "pairs.csv" if known else None,
        failures=failures,
        folder=folder,
    )
    sources = [*(entry["statistics"] for entry in entries), *panels]
    before = min(Path(source).stat().st_mtime for source in sources) - 1
    shutil.rmtree(folder / "pages", ignore_errors=True)
    for path in staging.iterdir():
        os.utime(path, (before, before))
        path.replace(folder / path.name)
    staging.rmdir()
