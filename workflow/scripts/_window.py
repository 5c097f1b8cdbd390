"""The window of a levelled map, the last file of the rules `prepare` and `superpose`."""

from _job import save, snakemake
from xarray import DataArray

from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.surface.preparation import preparation_of
from roughcontact.surface.window.periodic_window import periodic_window


def write_window(settings: dict) -> None:
    """Cut out of levelled.nc what is solved, a periodic window or a body of finite size: window.nc."""
    with opened_dataset(
        snakemake.output.levelled
    ) as file:  # without the rejected heights, which are as large
        plane = file["height"].drop_vars("rejected_height", errors="ignore").load()
    save(
        preparation_of(plane, settings).window(plane, settings),
        snakemake.output.window,
        settings,
        source=plane.attrs,
    )


def window_as_measured(window: DataArray, settings: dict) -> DataArray | None:
    """Return the window (y, x; m) before it was corrected for the instrument, None of one that was not."""
    if "corrected_for" not in window.attrs:
        return None
    return periodic_window(read_dataset(snakemake.input.levelled)["height"], **settings["window"])
