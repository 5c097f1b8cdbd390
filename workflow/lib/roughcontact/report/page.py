"""The page of a run: verdicts, comparison and the panel of every surface in one self-contained HTML file."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from roughcontact import materials
from roughcontact.quantities import number, percent, quantity
from roughcontact.report.load_plots import compare_areas
from roughcontact.report.summary import summary_of
from roughcontact.report.tables import pair_table
from roughcontact.report.template import template
from roughcontact.results.collect import Failure
from roughcontact.results.storage import read_dataset, write_text
from roughcontact.statistics import checks

# the numbers of a surface at the top of the page, as `_headline` gives them
_HEADINGS = ("rms height", "rms gradient g", "mean pressure p̄", "contact area A/A₀", "largest pressure")


def write_report(
    path: str | Path,
    *,
    panels: Sequence[str | Path],
    statistics: str | Path,
    title: str,
    settings: dict,
    pairs: str | Path | None = None,
    failures: Sequence[Failure] = (),
) -> None:
    """Write the one self-contained page of a run: verdicts, comparison, and the part of every surface.

    Parameters
    ----------
    path : path
        where to write.
    panels : sequence of paths
        what `write_panel` wrote, in the order they shall appear.
    statistics : path
        what `collect_statistics` put together.
    title : str
        of the page.
    settings : dict
        the settings of the run (of each case, where there are cases).
    pairs : path or None
        the table of pairs of faces (`collect.pairs_table`), where there are any.
    failures : sequence of dict
        surfaces (and cases) without results, with the reason.

    Raises
    ------
    InputFileError
        for a file that is not readable, or is no panel.
    """
    parts = [Path(panel).read_text(encoding="utf-8") for panel in panels]
    summaries = [summary_of(part, panel) for part, panel in zip(parts, panels, strict=True)]
    series = _series(read_dataset(statistics))
    rows = [{**summary, "numbers": _headline(series[summary["name"]])} for summary in summaries]
    lines = [
        (name, data["relative_pressure"].values, data["relative_contact_area"].values)
        for name, data in series.items()
        if np.isfinite(data["relative_pressure"]).all()
    ]
    html = template("report.html").render(
        title=title,
        rows=rows,
        headings=_HEADINGS,
        words=checks.VERDICTS,
        counts={outcome: sum(row["verdict"] == outcome for row in rows) for outcome in checks.VERDICTS},
        comparison=compare_areas(lines) if lines else None,
        parts=parts,
        failures=[
            {"name": _name(failure["surface"], failure["case"]), "reason": failure["reason"]}
            for failure in failures
        ],
        pairs=pair_table(pairs) if pairs else None,
        settings=json.dumps(settings, indent=1, sort_keys=True),
        limits={
            "points": checks.CONTACT_POINTS,
            "overcount": f"{100 * checks.OVERCOUNT:g} %",
            "filled": [f"{100 * share:g} %" for share in checks.FILLED_IN_CONTACT],
            "rejected": f"{100 * checks.REJECTED_LOAD:g} %",
            "jitter": f"{100 * checks.ROW_JITTER:g} %",
            "gradient": f"{100 * checks.GRADIENT_CHANGE:g} %",
            "heights": f"{100 * checks.HEIGHT_CHANGE:g} %",
            "form": f"{100 * checks.FORM:g} %",
            "window": f"{100 * checks.WINDOW_SHARE:g} %",
            "lengths": checks.LENGTHS,
            "steep": number(checks.STEEP, digits=1),
            "places": f"{100 * checks.STEEP_PLACES:g} %",
            "too_steep": number(checks.TOO_STEEP, digits=1),
            "metals": [number(limit, digits=1) for limit in materials.METALS],
            "hardest": number(materials.HARDEST, digits=1),
        },
    )
    write_text(html, path)


def _series(statistics: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return {name: statistics of its loads} of every surface (and case), loads rising, padding left out."""
    series = {}
    cases = statistics["case_name"].values if "case" in statistics.dims else [None]
    for place, case in enumerate(cases):
        of_case = statistics if case is None else statistics.isel(case=place)
        for index, surface in enumerate(statistics["surface_name"].values):
            one = of_case.isel(surface=index)
            one = one.isel(load=np.isfinite(one["mean_pressure"].values))
            if not one.sizes["load"]:  # failed under this case
                continue
            name = _name(surface, case)
            series[name] = one.isel(load=np.argsort(one["mean_pressure"].values))
    return series


def _name(surface: str, case: str | None) -> str:
    """Return what a surface, under a case, is called on the page."""
    return str(surface) if case is None else f"{surface} · {case}"


def _headline(data: xr.Dataset) -> list[str]:
    """Return the few numbers of a surface that stand at the top of the page."""
    return [
        quantity(float(data["rms_height"]), "m"),
        number(float(data["rms_gradient"])),
        _span(data["mean_pressure"].values, lambda value: quantity(value, "Pa")),
        _span(data["relative_contact_area"].values, percent),
        quantity(float(data["max_pressure"].max()), "Pa"),
    ]


def _span(values: np.ndarray, show: Callable[[float], str]) -> str:
    """Return the least and the largest of some values in words."""
    low, high = (show(float(f(values))) for f in (np.min, np.max))
    return low if low == high else f"{low} to {high}"
