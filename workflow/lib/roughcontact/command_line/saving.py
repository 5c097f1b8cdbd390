"""The results of `roughcontact solve` as a file, of which the ending says the kind; whole or not at all."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.command_line.project import surface_names
from roughcontact.errors import SettingsError

if TYPE_CHECKING:
    import xarray as xr

    from roughcontact.pipeline import Chain

# what a file of an ending holds
CONTENT_BY_ENDING = {
    ".nc": "all numbers with their intervals, as statistics.nc of a surface (rc.read_statistics, compare)",
    ".csv": "a row for each load, the columns of summary.csv",
    ".xlsx": "a workbook: the columns of summary.csv, the components of the ±, the settings, a sheet each",
    ".html": "the report, a page by itself",
    ".png": "a figure: area and pressures against the load; pressure and gap at the largest load",
    ".vti": "maps of height, pressure, gap and contact for ParaView",
    ".tiff": "the same maps for Gwyddion or ImageJ, a page each",
    ".gsf": "the map of pressure at the largest load for Gwyddion",
}
_WITHOUT_MAPS = (".nc", ".csv", ".xlsx")
_LINKS_BESIDE = re.compile(", or see <a .*? beside this page")  # what the page says of the files of a run


def check_output(output: Path, files: Sequence[str]) -> None:
    """Raise a SettingsError where results cannot be written there, before anything is solved.

    Examples
    --------
    >>> try:
    ...     check_output(Path("result.doc"), ["ground.txt"])
    ... except SettingsError as error:
    ...     print(error)
    -o result.doc: end it with one of .nc, .csv, .xlsx, .html, .png, .vti, .tiff, .gsf
    """
    if output.suffix.lower() not in CONTENT_BY_ENDING:
        raise SettingsError(f"-o {output}: end it with one of {', '.join(CONTENT_BY_ENDING)}")
    if len(files) > 1:
        raise SettingsError(
            f"-o {output}: is of one map, {len(files)} are given; `roughcontact init` and `run` write the "
            "results of several"
        )
    if output.exists() and (output.is_dir() or output.samefile(files[0])):
        obstacle = "a folder" if output.is_dir() else "the measured file itself"
        raise SettingsError(f"-o {output}: is {obstacle}; choose another name")


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
    from roughcontact.results.exchange import write_gsf, write_tiff, write_vti, write_workbook
    from roughcontact.results.storage import opened_dataset, write_dataset, write_table, write_text

    (name,), ending = surface_names([source]), output.suffix.lower()
    if ending == ".nc":
        write_dataset(chain.statistics, output)
    elif ending in (".csv", ".xlsx"):
        import pandas as pd

        from roughcontact.pipeline import SECTIONS
        from roughcontact.results.collect import collect_statistics, summary_table
        from roughcontact.uncertainty.combination import uncertainty_table

        path = folder / "statistics.nc"
        write_dataset(chain.statistics, path)
        summary = summary_table(collect_statistics([{"surface": name, "case": None, "statistics": path}]))
        if ending == ".csv":
            write_table(summary, output)
        else:
            stated = [
                (f"{section}.{key}", str(settings[section][key]))
                for section in SECTIONS
                for key in settings[section]
            ]
            sheets = {
                "summary": summary,
                "uncertainty": uncertainty_table(chain.statistics),
                "settings": pd.DataFrame(stated, columns=["setting", "value"]),
            }
            write_workbook(sheets, output)
    elif ending == ".html":
        write_text(_LINKS_BESIDE.sub("", _page(name, folder, chain, height, settings)), output)
    else:
        with opened_dataset(folder / "contact.nc") as contact:
            if ending == ".png":
                _draw(output, chain.statistics, contact, title=Path(source).name)
            elif ending == ".gsf":
                largest = contact.isel(load=int(contact["mean_pressure"].values.argmax()))
                write_gsf(largest["pressure"].load(), output)
            else:
                (write_vti if ending == ".vti" else write_tiff)(contact, output)


def _page(name: str, folder: Path, chain: "Chain", height: "xr.DataArray", settings: dict[str, Any]) -> str:
    """Return the page of a run of this surface alone, which is made in the folder."""
    from roughcontact.configuration.generated import changed_settings
    from roughcontact.report.gather import write_results
    from roughcontact.report.panel import write_panel
    from roughcontact.results.storage import write_dataset

    datasets = {"height": height, **chain._asdict()}
    files = {stage: folder / name / f"{stage}.nc" for stage in datasets}
    for stage, path in files.items():
        write_dataset(datasets[stage], path)
    panel: dict[str, Any] = files | {"contact": folder / "contact.nc", "linked": False}
    write_panel(folder / name / "panel.html", surface=name, settings=settings, **panel)
    entry: Any = {"surface": name, "case": None, "statistics": files["statistics"]}
    write_results(
        folder,
        finished=[entry | {"panel": folder / name / "panel.html"}],
        title=settings["report"]["title"],
        settings=settings,
        changed={"": changed_settings(settings)},
        settings_of_statistics=settings,
        groups={},
    )
    return (folder / "report.html").read_text(encoding="utf-8")


def _draw(output: Path, statistics: "xr.Dataset", contact: "xr.Dataset", *, title: str) -> None:
    """Write a figure."""
    from roughcontact import plot
    from roughcontact.report.figures import new_figure
    from roughcontact.results.storage import whole

    rough = float(statistics["rms_gradient"]) > 0  # a flat map has no curves
    with new_figure(10.5, 8.5 if rough else 4.3) as figure, whole(output, size=2**20) as partial:
        axes = list(figure.subplots(1 + rough, 2).flat)
        if rough:
            plot.area(statistics, axes.pop(0))
            plot.pressure(statistics, axes.pop(0))
        largest = int(contact["mean_pressure"].values.argmax())
        plot.maps(contact, axes[0], load=largest)
        plot.maps(contact, axes[1], quantity="gap", load=largest)
        figure.suptitle(title)
        figure.savefig(partial, format="png", dpi=144)
