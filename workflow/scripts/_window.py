"""The window of a levelled map, the last file of the rules `prepare` and `superpose`."""

from _job import save, snakemake

from roughcontact.results.storage import opened_dataset
from roughcontact.surface.preparation import preparation_of


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
