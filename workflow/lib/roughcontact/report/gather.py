"""The results of all surfaces of a run: one dataset, one table, one page."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

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
from roughcontact.uncertainty.combination import uncertainty_table


class Finished(Entry):
    """The statistics of one surface (and case), with its part of the report."""

    panel: str | Path


def write_results(
    folder: str | Path,
    *,
    finished: Sequence[Finished],
    title: str,
    settings: dict[str, Any],
    settings_of_statistics: dict[str, Any],
    pairs: Mapping[str, str],
    failures: Sequence[Failure] = (),
    seen_from: str | Path | None = None,
) -> None:
    """Write the datasets, tables and page of all surfaces of a run.

    These are `statistics.nc`, `summary.csv`, `uncertainty.csv`, `pairs.csv` and `report.html`.

    Parameters
    ----------
    folder : path
        where they are written.
    finished : sequence of dict
        the finished surfaces, in the order of the tables; one at least.
    title : str
        of the page.
    settings, settings_of_statistics : dict
        of the run (of each case, where there are cases), whole and as far as the statistics depend on them.
    pairs : mapping
        name of a member -> name of its pair; empty where there are no pairs.
    failures : sequence of dict
        surfaces (and cases) without results, with the reason; table, page and dataset name them.
    seen_from : path or None
        the folder to which the files will be moved, for the links of the page; None where they stay.
    """
    folder = Path(folder)
    statistics = collect_statistics(finished)
    checksums = statistics.attrs["source_sha256"]
    attrs = provenance(settings_of_statistics, source_sha256=checksums, stage="statistics")
    if failures:
        attrs["failed"] = json.dumps(list(failures), sort_keys=True)
    write_dataset(statistics.assign_attrs(attrs), folder / "statistics.nc")
    summary = summary_table(statistics)
    write_table(with_failures(summary, failures), folder / "summary.csv")
    write_table(budget_table(statistics), folder / "uncertainty.csv")
    known = {member: pair for member, pair in pairs.items() if member in set(summary["surface"])}
    if known:
        write_table(pairs_table(summary, known), folder / "pairs.csv")
    write_report(
        folder / "report.html",
        panels=[entry["panel"] for entry in finished],
        statistics=folder / "statistics.nc",
        title=title,
        settings=settings,
        pairs=folder / "pairs.csv" if known else None,
        failures=failures,
        folder=seen_from,
    )


def budget_table(statistics: xr.Dataset) -> pd.DataFrame:
    """Return the components of every interval of the surfaces (and cases) of `collect_statistics`."""
    tables = []
    dims = [dim for dim in ("case", "surface") if dim in statistics.dims]
    for place in np.ndindex(*(statistics.sizes[dim] for dim in dims)):
        one = statistics.isel(dict(zip(dims, place, strict=True)))
        table = uncertainty_table(one.isel(load=np.isfinite(one["mean_pressure"].values)))
        for number, dim in enumerate(dims):
            table.insert(number, dim, one[dim].item())
        tables.append(table)
    return pd.concat(tables, ignore_index=True)
