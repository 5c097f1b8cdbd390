"""The window of a levelled map, the last file of the rules `prepare` and `superpose`."""

from _job import save, snakemake

from roughcontact.profiles.surface import solved_window
from roughcontact.results.storage import opened_dataset


def write_window(settings: dict) -> None:
    """Cut out of levelled.nc what is solved, a periodic window or a body of finite size: window.nc."""
    with opened_dataset(
        snakemake.output.levelled
    ) as file:  # without the rejected heights, which are as large
        plane = file["height"].drop_vars("rejected_height", errors="ignore").load()
    save(solved_window(plane, settings), snakemake.output.window, settings, source=plane.attrs)
