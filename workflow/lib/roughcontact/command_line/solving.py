"""One file to numbers: the verbs of the workflow's stages, one after the other, with a bar for long work."""

import json
import sys
from contextlib import contextmanager
from functools import partial

from roughcontact.contact.loads import plan_loads
from roughcontact.contact.solve import SOLVER_SETTINGS, solve_contact
from roughcontact.io.read import read_height_map
from roughcontact.levelling.level import level
from roughcontact.statistics import checks
from roughcontact.statistics.contact_statistics import contact_statistics, with_uncertainty
from roughcontact.uncertainty.budget import error_budget
from roughcontact.variables import VARIABLES
from roughcontact.window.periodic_window import periodic_window


def solve_file(path, given: dict, settings: dict, *, threads: int = 1) -> dict:
    """Read, level, window and solve one map, and return the headline numbers.

    Parameters
    ----------
    path : str or Path
    given : dict
        Keyword arguments of `read_height_map`.
    settings : dict
        As `roughcontact.configuration.resolve` returns them, for one case.
    threads : int
        Threads of the Fourier transforms.

    Returns
    -------
    dict of plain values, SI units
        `file`, `source_sha256`, `measured`, `window` (numbers of points), `surface` (name -> number),
        `loads` (one dict per load, name -> number, `{name}_uncertainty` -> source -> half-width, with the
        words `flags`), `units` (name -> unit),
        `checks` (name, outcome, sentence), `verdict`, `settings`.
    """
    contact = settings["contact"]
    with _progress() as show:
        show(0, None, "reading")
        height = read_height_map(path, **given)
        show(0, None, "levelling")
        levelled = level(height, **settings["level"])
        show(0, None, "periodic window")
        window = periodic_window(levelled, **settings["window"])
        elastic = {"contact_modulus": contact["contact_modulus"]}
        loads = plan_loads(
            window, **elastic, **{key: contact[key] for key in ("mean_pressure", "relative_pressure")}
        )
        show(0, len(loads), "solving")
        solver = elastic | {"mean_pressure": loads} | {key: contact[key] for key in SOLVER_SETTINGS}
        solver["threads"] = threads
        statistics = solve_contact(
            window, **solver, reduce=partial(contact_statistics, **settings["statistics"]), progress=show
        )
        show(len(loads), len(loads), "error budget")
        verbs = {"level": settings["level"], "window": settings["window"], "contact": solver}
        budget = error_budget(levelled, window, verbs, **settings["uncertainty"])
    statistics = with_uncertainty(statistics, budget)
    outcome = checks.surface_checks(
        statistics, height=height.attrs, levelled=levelled.attrs, window=window.attrs, points=window.size
    )
    surface, per_load = (
        [name for name in statistics.variables if statistics[name].dims == dims] for dims in ((), ("load",))
    )
    uncertain = [name for name in statistics.variables if name.endswith("_uncertainty")]
    by_source = statistics[uncertain].to_dict()["data_vars"]
    sources = statistics["source"].values.tolist() if uncertain else []
    flags = checks.load_flags(statistics, window.size)
    return {
        "file": str(path),
        "source_sha256": height.attrs["source_sha256"],
        "measured": {"ny": height.shape[0], "nx": height.shape[1], "format": height.attrs["source_format"]},
        "window": {
            **{"ny": window.shape[0], "nx": window.shape[1]},
            "periodisation": window.attrs.get("periodisation", "none"),
            "share": float(window.attrs.get("window_share", 1.0)),
        },
        "surface": {name: float(statistics[name]) for name in surface},
        "loads": [
            {name: statistics[name].values[index].item() for name in per_load}
            | {name: dict(zip(sources, by_source[name]["data"][index], strict=True)) for name in uncertain}
            | {"flags": words}
            for index, words in enumerate(flags)
        ],
        "units": {name: VARIABLES[name][0] for name in (*surface, *per_load, *uncertain)},
        "checks": [check._asdict() for check in outcome],
        "verdict": checks.VERDICTS[checks.verdict(outcome)],
        "warnings": json.loads(height.attrs["ingest_warnings"]),
        "settings": {
            key: settings[key] for key in ("contact", "level", "window", "statistics", "uncertainty")
        },
    }


@contextmanager
def _progress():
    """Yield a function (done, total, text) that moves a bar on standard error, if that is a terminal."""
    if not sys.stderr.isatty():
        yield lambda done, total, text: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (
        SpinnerColumn(),  # turns while a single load takes long
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[loads]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None, loads="")

        def show(done, total, text):
            loads = f"{done} of {total} loads" if total else ""
            # one load has no parts to count: the bar then only shows that work goes on
            several = total if total and total > 1 else None
            bar.update(task, completed=done, total=several, description=text, loads=loads)

        yield show
