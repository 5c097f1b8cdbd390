"""From a file, or several, to numbers by the chain of the workflow, as plain values, with a progress bar."""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import xarray as xr

from roughcontact.arguments.answers import ANSWERS
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.settings.stages import stage_settings
from roughcontact.arguments.variables import VARIABLES
from roughcontact.errors import HeightMapError, RoughContactError, path_message
from roughcontact.evaluation.pipeline import run_chain, with_positions
from roughcontact.interface.command_line import saving
from roughcontact.io.read import read_height_map
from roughcontact.statistics import checks
from roughcontact.statistics.outcome import VERDICTS, worst_result
from roughcontact.surface.levelling.record import removed_and_filled
from roughcontact.surface.window.band import shortest_reliable_wave
from roughcontact.uncertainty.groups import group_statistics, is_range

_CREPT = ("load", "time")  # dimensions of what a contact has become
# attributes of the levelled map on removed and filled points
_LEVELLED = (
    *("form", "outliers_rejected", "filled_points", "filled_share", "largest_hole"),
    *("line_alignment", "row_jitter"),
)
_LEVELLED_JSON = ("outlier_kinds", "form_removed")

Progress = Callable[[int, int | None, str], None]


def solve_files(
    paths: Sequence[str | Path],
    read_arguments: Mapping[str, Any],
    settings: Mapping[str, Any],
    *,
    threads: int = 1,
) -> tuple[dict[str, Any], xr.Dataset | None]:
    """Solve several maps of a finish; return `maps` (`solve_file`), numbers of the `group`, and its answer.

    For maps that are no group, and have no answer, `none` has the reason.
    """
    results = [solve_file(path, read_arguments, settings, threads=threads) for path in paths]
    maps = [result for result, _ in results]
    try:
        answer = group_statistics([statistics for _, statistics in results], names=[*map(str, paths)])
    except RoughContactError as error:  # what was computed is not lost
        return {"maps": maps, "group": {"maps": len(maps), "none": str(error)}}, None
    numbers = {str(name): v.values.tolist() for name, v in answer.variables.items() if v.dims == ("load",)}
    loads = [dict(zip(numbers, row, strict=True)) for row in zip(*numbers.values(), strict=True)]
    return {
        "maps": maps,
        "group": {
            "maps": len(maps),
            "range": is_range(answer),
            "remarks": json_attribute(answer.attrs, "remarks"),
            "loads": loads,
            "units": {name: VARIABLES[name][0] for name in numbers},
        },
    }, answer


def solve_file(
    path: str | Path,
    read_arguments: Mapping[str, Any],
    settings: Mapping[str, Any],
    *,
    threads: int = 1,
    output: Path | None = None,
    overviews: Sequence[Path] = (),
    overview_position: str = "",
) -> tuple[dict[str, Any], xr.Dataset]:
    """Read, level, window and solve one map; return its numbers as plain values (SI), and its statistics.

    `read_arguments` are those of `read_height_map`, `settings` one case of `resolve`; `output` is a file of
    one of the kinds of `saving`, `overviews` those of coarser maps of a field around the map, where
    `overview_position` states it (`arguments.positions`).
    """
    with _progress() as show, TemporaryDirectory() as folder:
        show(0, None, "reading")
        height = read_height_map(path, **read_arguments)
        fields = Path(folder, "contact.nc") if output and saving.needs_maps(output) else None
        try:
            coarser = with_positions(overviews, overview_position)
            chain = run_chain(
                height, settings, threads=threads, progress=show, fields=fields, overviews=coarser
            )
        except HeightMapError as error:
            raise HeightMapError(path_message(error, str(path))) from error
        if output:
            show(0, None, "writing")
            saving.save(output, Path(folder), chain, source=path, height=height, settings=dict(settings))
    level_map_result, window, statistics, _ = chain
    ny, nx = window.shape
    outcome = checks.window_checks(statistics, window)
    result = {
        "file": str(path),
        "source_sha256": height.attrs["source_sha256"],
        "measured": {"ny": height.shape[0], "nx": height.shape[1], "format": height.attrs["source_format"]},
        "levelled": {name: level_map_result.attrs[name] for name in _LEVELLED}
        | {name: json_attribute(level_map_result.attrs, name) for name in _LEVELLED_JSON}
        | {"removed_and_filled": removed_and_filled(level_map_result.attrs)},
        "window": {
            "ny": ny,
            "nx": nx,
            "periodisation": window.attrs.get("periodisation", "none"),
            "share": float(window.attrs.get("window_share", 1.0)),
            "corrected_for": window.attrs.get("corrected_for"),
            "shortest_wavelength": shortest_reliable_wave(window) if "cutoff" in statistics.dims else None,
        },
        **_plain_numbers(
            statistics,
            checks.load_flags(statistics, window.size),
            json_attribute(statistics.attrs, "verdicts"),
        ),
        "checks": [
            {key: getattr(check, key) for key in ("name", "outcome", "sentence", "answers")}
            for check in outcome
        ],
        "verdict": VERDICTS[worst_result(outcome)],
        "verdicts": {answer.words: VERDICTS[worst_result(outcome, name)] for name, answer in ANSWERS.items()},
        **{name: statistics.attrs.get(name, "") for name in ("halve", "halved", "places", "overview")},
        "warnings": json_attribute(height.attrs, "ingest_warnings"),
        "settings": {key: settings[key] for key in stage_settings(settings, "statistics")},
    }
    return result, statistics


def _plain_numbers(
    statistics: xr.Dataset, flags: list[list[str]], verdicts: list[tuple[str, list[str]]]
) -> dict[str, Any]:
    """Return the numbers of a surface, those of its loads, and the units of both, as plain values."""
    variables = {str(name): variable for name, variable in statistics.variables.items()}
    # the verdicts stand below in words
    names = [name for name in variables if not name.endswith("verdict")]
    surface, per_load, crept = (
        [name for name in names if variables[name].dims == dims] for dims in ((), ("load",), _CREPT)
    )
    uncertain = [name for name in names if name.endswith("_uncertainty")]
    by_source = {name: variables[name].values.tolist() for name in uncertain}
    sources = variables["source"].values.tolist() if uncertain else []
    loads = [
        {name: variables[name].values[index].item() for name in per_load}
        | {name: dict(zip(sources, by_source[name][index], strict=True)) for name in uncertain}
        | _after(variables, index)
        | {"flags": flag, "verdict": verdict, "reasons": reasons}
        for index, (flag, (verdict, reasons)) in enumerate(zip(flags, verdicts, strict=True))
    ]
    return {
        "surface": {name: float(variables[name]) for name in surface},
        "loads": loads,
        "units": {name: VARIABLES[name][0] for name in (*surface, *per_load, *uncertain, *crept)},
    }


def _after(variables: Mapping[str, xr.Variable], load: int) -> dict[str, Any]:
    """Return what a load has become after each time of creep, nothing where no body creeps."""
    if not (crept := {name: entry.values[load] for name, entry in variables.items() if entry.dims == _CREPT}):
        return {}
    times = variables["time"].values.tolist()
    rows = [{name: float(row[index]) for name, row in crept.items()} for index in range(len(times))]
    return {"after": [{"time": time, **row} for time, row in zip(times, rows, strict=True)]}


@contextmanager
def _progress() -> Iterator[Progress]:
    """Yield a function (done, total, text) that moves a bar on standard error, if that is a terminal."""
    if not sys.stderr.isatty():
        yield lambda solved_loads, total, text: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (
        SpinnerColumn(),  # moves during a single long load
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[loads]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None, loads="")

        def show(solved_loads: int, total: int | None, text: str) -> None:
            loads = f"{solved_loads} of {total} loads" if total else ""
            # one load has no parts to count: the bar then only shows activity
            number_of_loads = total if total and total > 1 else None
            bar.update(task, completed=solved_loads, total=number_of_loads, description=text, loads=loads)

        yield show
