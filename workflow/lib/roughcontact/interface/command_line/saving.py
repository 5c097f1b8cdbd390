"""Results as a file, of which the ending says the kind; whole or not at all.

`roughcontact solve -o` writes them of the map that it has solved, `roughcontact export` of a finished run.
"""

from collections.abc import Collection, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.arguments.measurement import Instrument, json_attribute
from roughcontact.arguments.rows import rows_beside
from roughcontact.errors import InputFileError, SettingsError

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from roughcontact.evaluation.pipeline import Chain

_FILES = rows_beside(__file__, "exports.tsv")
# what can be made of a result in a folder, or of two, and the arguments of the program that make it
EXPORTS = {name: (holds, arguments) for name, arguments, holds in _FILES if arguments}
# what a file of an ending holds, and the same of a run, which has written two of them already
CONTENT_BY_ENDING = {name: holds for name, _, holds in _FILES if name.startswith(".")}
EXPORTED_BY_ENDING = {name: holds for name, holds in CONTENT_BY_ENDING.items() if name in EXPORTS}
_WITHOUT_MAPS = (".nc", ".csv", ".xlsx")


def check_output(output: Path, files: Sequence[str]) -> None:
    """Raise a SettingsError where results cannot be written there, before anything is solved."""
    check_ending(output, CONTENT_BY_ENDING)
    if len(files) > 1:
        raise SettingsError(
            f"-o {output}: is of one map, {len(files)} are given; `roughcontact init` and `run` write the "
            "results of several"
        )
    if output.exists() and (output.is_dir() or output.samefile(files[0])):
        obstacle = "a folder" if output.is_dir() else "the measured file itself"
        raise SettingsError(f"-o {output}: is {obstacle}; choose another name")


def check_ending(output: Path, endings: Collection[str]) -> None:
    """Raise a SettingsError for a file with another ending."""
    if output.suffix.lower() not in endings:
        raise SettingsError(f"-o {output}: end it with one of {', '.join(endings)}")


def needs_maps(output: Path) -> bool:
    """Return whether a file needs the maps of pressure and gap."""
    return output.suffix.lower() not in _WITHOUT_MAPS


def save(
    output: Path,
    folder: Path,
    chain: "Chain",
    *,
    source: str | Path,
    height: "xr.DataArray",
    settings: dict[str, Any],
) -> None:
    """Write a file of results, from all that the chain has made of the map `height` of the file `source`.

    `folder` is for files on the way to it; contact.nc is there if the maps are needed.
    """
    from roughcontact.interface.command_line.project import surface_names
    from roughcontact.results.storage import write_dataset, write_text

    (name,), ending = surface_names([source]), output.suffix.lower()
    if ending == ".nc":
        write_dataset(chain.statistics, output)
    elif ending == ".html":
        write_text(_page(name, folder, chain, height, settings), output)
    else:
        write_dataset(chain.statistics, folder / "statistics.nc")
        write(output, folder, surface=name, title=Path(source).name)


def write(output: Path, folder: Path, *, surface: str, title: str) -> None:
    """Write a file of results from statistics.nc and, for maps, contact.nc of a folder."""
    from roughcontact.results.storage import opened_dataset, read_dataset, write_table

    ending = output.suffix.lower()
    if ending in _WITHOUT_MAPS:
        from roughcontact.results.collect import collect_statistics, result_entry, summary_table

        summary = summary_table(collect_statistics([result_entry(surface, folder / "statistics.nc")]))
        (write_table if ending == ".csv" else partial(_write_workbook, folder))(summary, output)
        return
    from roughcontact.results.exchange import write_gsf, write_tiff, write_vti

    if not (folder / "contact.nc").is_file():
        raise InputFileError(
            f"{folder}: has no contact.nc; name the folder of the first case with the same contact, or run "
            "again to make it"
        )
    with opened_dataset(folder / "contact.nc") as contact:
        if "pressure" not in contact:
            raise InputFileError(
                f"{folder / 'contact.nc'}: has no maps; set contact.keep_fields to true and run again"
            )
        if ending == ".png":
            _draw(output, read_dataset(folder / "statistics.nc"), contact, title=title)
        elif ending == ".gsf":
            largest = contact.isel(load=int(contact["mean_pressure"].values.argmax()))
            write_gsf(largest["pressure"].load(), output)
        else:
            (write_vti if ending == ".vti" else write_tiff)(contact, output)


def _write_workbook(folder: Path, summary: "pd.DataFrame", output: Path) -> None:
    """Write the numbers of a result, the components of their ± and the settings behind them, a sheet each."""
    import pandas as pd

    from roughcontact.results.exchange import write_workbook
    from roughcontact.results.storage import read_dataset
    from roughcontact.uncertainty.combination import uncertainty_table

    statistics = read_dataset(folder / "statistics.nc")
    settings: dict[str, dict[str, Any]] = json_attribute(statistics.attrs, "settings")
    rows = [(f"{name}.{key}", str(value)) for name, keys in settings.items() for key, value in keys.items()]
    rows += [  # the table of surfaces prevails over the settings
        (f"instrument.{key} of this map", str(value))
        for key, value in Instrument.read(statistics.attrs).properties().items()
    ]
    sheets = {
        "answers": _answers(statistics),
        "summary": summary,
        "uncertainty": uncertainty_table(statistics),
        "settings": pd.DataFrame(rows, columns=["setting", "value"]),
    }
    write_workbook(sheets, output)


def _answers(statistics: "xr.Dataset") -> "pd.DataFrame":
    """Return what each load is asked for, as people read it: value, unit, both sides of the ±, in words."""
    import pandas as pd

    from roughcontact.report import glance
    from roughcontact.report.units import interval_at

    rising = statistics.isel(load=statistics["mean_pressure"].argsort().values)
    (units,), rows, stated_as = glance.glance_units([rising]), [], glance.load_heading([rising])
    for index, cells in enumerate(glance.glance_rows(rising, units, indices=range(rising.sizes["load"]))):
        load = cells.pop(glance.LOAD).text
        for name, cell in cells.items():
            if cell.text == glance.NOT_JUDGED:
                continue
            row: dict[str, Any] = {stated_as: load, "answer": glance.HEADINGS[name], "value": cell.text}
            if name in units:
                factor = units[name].factor
                value, lower, upper = (factor * number for number in interval_at(rising, name, index))
                row |= {"value": value, "unit": units[name].symbol, "-": value - lower, "+": upper - value}
            rows.append(row | {"known": cell.known, "details": cell.all_details})
    columns = [stated_as, "answer", "value", "-", "+", "unit", "known", "details"]
    return pd.DataFrame(rows, columns=columns)


def _page(name: str, folder: Path, chain: "Chain", height: "xr.DataArray", settings: dict[str, Any]) -> str:
    """Return the page of a run of this surface alone, which is made in the folder."""
    from roughcontact.arguments.settings.generated import changed_settings
    from roughcontact.report.gather import write_results
    from roughcontact.report.panel import write_panel
    from roughcontact.results.collect import result_entry
    from roughcontact.results.storage import write_dataset
    from roughcontact.surface.faces.placing import joined_overviews

    datasets = {"height": height, **chain._asdict()}
    if overviews := datasets.pop("overviews"):
        datasets["overview"] = joined_overviews(overviews)
    files = {stage: folder / name / f"{stage}.nc" for stage in datasets}
    for stage, path in files.items():
        write_dataset(datasets[stage], path)
    panel: dict[str, Any] = files | {"contact": folder / "contact.nc", "linked": False}
    write_panel(folder / name / "panel.html", surface=name, settings=settings, **panel)
    write_results(
        folder,
        finished=[result_entry(name, files["statistics"])],
        title=settings["report"]["title"],
        settings=settings,
        changed={"": changed_settings(settings)},
        settings_of_statistics=settings,
        groups={},
        linked=False,
    )
    return (folder / "report.html").read_text(encoding="utf-8")


def _draw(output: Path, statistics: "xr.Dataset", contact: "xr.Dataset", *, title: str) -> None:
    """Write a figure."""
    from roughcontact.report import plot
    from roughcontact.report.figures import new_figure
    from roughcontact.results.storage import atomic_write

    rough = float(statistics["rms_gradient"]) > 0  # a flat map has no curves
    with new_figure(10.5, 8.5 if rough else 4.3) as figure, atomic_write(output, size=2**20) as partial:
        axes = list(figure.subplots(1 + rough, 2).flat)
        if rough:
            plot.area(statistics, axes.pop(0))
            plot.pressure(statistics, axes.pop(0))
        largest = int(contact["mean_pressure"].values.argmax())
        plot.maps(contact, axes[0], load=largest)
        plot.maps(contact, axes[1], quantity="gap", load=largest)
        figure.suptitle(title)
        figure.savefig(partial, format="png", dpi=144)
