"""The results of `roughcontact solve` as a file, of which the ending says the kind; whole or not at all."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

from roughcontact.command_line.running import surface_names
from roughcontact.errors import SettingsError

if TYPE_CHECKING:
    import xarray as xr

    from roughcontact.pipeline import Chain

# what a file of an ending holds
KINDS = {
    ".nc": "all numbers with their intervals, as statistics.nc of a surface (rc.read_statistics, compare)",
    ".csv": "a row for each load, the columns of summary.csv",
    ".html": "the report, a page by itself",
    ".png": "a figure: area and pressures against the load; pressure and gap at the largest load",
    ".vti": "maps of height, pressure, gap and contact for ParaView",
    ".tiff": "the same maps for Gwyddion or ImageJ, a page each",
}
_BESIDE = re.compile(", or see <a .*? beside this page")  # what the page says of the files of a run
_WITH_MAPS = (".html", ".png", ".vti", ".tiff")


class Results(NamedTuple):
    """Where results go.

    Attributes
    ----------
    output : Path
        the file.
    folder : Path
        for files on the way to it.
    """

    output: Path
    folder: Path

    @property
    def contact(self) -> Path:
        """The file for the solution with its maps."""
        return self.folder / "contact.nc"

    @property
    def need_maps(self) -> bool:
        """Whether that file is needed."""
        return self._ending in _WITH_MAPS

    @property
    def _ending(self) -> str:
        return self.output.suffix.lower()

    def write(
        self, source: str | Path, height: "xr.DataArray", chain: "Chain", settings: dict[str, Any]
    ) -> None:
        """Write the file, from all that the chain has made of the map `height` of the file `source`."""
        from roughcontact.results.storage import opened_dataset, write_dataset

        if self._ending == ".nc":
            write_dataset(chain.statistics, self.output)
        elif self._ending == ".csv":
            self._write_rows(source, chain)
        elif self._ending == ".html":
            self._write_page(source, height, chain, settings)
        elif self._ending == ".png":
            self._write_figure(source, chain)
        else:
            from roughcontact.results.exchange import write_tiff, write_vti

            with opened_dataset(self.contact) as contact:
                (write_vti if self._ending == ".vti" else write_tiff)(contact, self.output)

    def _write_rows(self, source: str | Path, chain: "Chain") -> None:
        """Write a row for each load."""
        from roughcontact.results.collect import collect_statistics, summary_table
        from roughcontact.results.storage import write_dataset, write_table

        (name,), path = surface_names([source]), self.folder / "statistics.nc"
        write_dataset(chain.statistics, path)
        found = collect_statistics([{"surface": name, "case": None, "statistics": path}])
        write_table(summary_table(found), self.output)

    def _write_page(
        self, source: str | Path, height: "xr.DataArray", chain: "Chain", settings: dict[str, Any]
    ) -> None:
        """Write the report of a run that is made in the folder."""
        from roughcontact.report.gather import write_results
        from roughcontact.report.panel import write_panel
        from roughcontact.results.storage import write_dataset, write_text

        (name,) = surface_names([source])
        made = {"height": height, **chain._asdict()}
        files = {part: self.folder / name / f"{part}.nc" for part in made}
        for part, path in files.items():
            write_dataset(made[part], path)
        panel = self.folder / name / "panel.html"
        write_panel(
            panel,
            surface=name,
            height=files["height"],
            levelled=files["levelled"],
            window=files["window"],
            contact=self.contact,
            statistics=files["statistics"],
            settings=settings,
            linked=False,
        )
        write_results(
            self.folder,
            finished=[{"surface": name, "case": None, "statistics": files["statistics"], "panel": panel}],
            title=settings["report"]["title"],
            settings=settings,
            settings_of_statistics=settings,
            groups={},
        )
        text = (self.folder / "report.html").read_text(encoding="utf-8")
        write_text(_BESIDE.sub("", text), self.output)

    def _write_figure(self, source: str | Path, chain: "Chain") -> None:
        """Write a figure."""
        from roughcontact import plot
        from roughcontact.report.figures import new_figure
        from roughcontact.results.storage import opened_dataset, whole

        rough = float(chain.statistics["rms_gradient"]) > 0  # a flat map has no curves
        with new_figure(10.5, 8.5 if rough else 4.3) as figure, opened_dataset(self.contact) as contact:
            axes = list(figure.subplots(1 + rough, 2).flat)
            if rough:
                plot.area(chain.statistics, axes.pop(0))
                plot.pressure(chain.statistics, axes.pop(0))
            largest = int(contact["mean_pressure"].values.argmax())
            plot.maps(contact, axes[0], load=largest)
            plot.maps(contact, axes[1], quantity="gap", load=largest)
            figure.suptitle(Path(source).name)
            with whole(self.output, size=2**20) as partial:
                figure.savefig(partial, format="png", dpi=144)


def check_output(output: Path, files: Sequence[str]) -> None:
    """Raise a SettingsError where results cannot be written there, before anything is solved.

    Examples
    --------
    >>> check_output(Path("result.xlsx"), ["ground.txt"])
    Traceback (most recent call last):
    roughcontact.errors.SettingsError: -o result.xlsx: end it with one of .nc, .csv, .html, .png, .vti, .tiff
    """
    if output.suffix.lower() not in KINDS:
        raise SettingsError(f"-o {output}: end it with one of {', '.join(KINDS)}")
    if len(files) > 1:
        raise SettingsError(
            f"-o {output}: is of one map, {len(files)} are given; `roughcontact init` and `run` write the "
            "results of several"
        )
    if output.exists() and (output.is_dir() or output.samefile(files[0])):
        what = "a folder" if output.is_dir() else "the measured file itself"
        raise SettingsError(f"-o {output}: is {what}; choose another name")


@contextmanager
def results_for(output: Path) -> Iterator[Results]:
    """Yield what writes the results to a file of a checked name."""
    with TemporaryDirectory() as folder:
        yield Results(output, Path(folder))
