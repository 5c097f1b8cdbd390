"""Add up the two levelled faces of a pair in one of their relative positions: levelled.nc, window.nc."""

from _job import save, snakemake
from _window import write_window

from roughcontact.results.storage import read_dataset
from roughcontact.surface.faces.composite import composite
from roughcontact.surface.faces.positions import relative_positions

settings, paths = snakemake.params.settings, snakemake.input
faces = [read_dataset(path)["height"] for path in (paths.face, paths.counter_face)]
pair = settings["levelled"]["surface"]
position = relative_positions(*faces, **pair["composite"])[pair["number"] - 1]
levelled = composite(*faces, **position)
save(levelled, snakemake.output.levelled, settings["levelled"], source=levelled.attrs)
del faces, levelled
write_window(settings["window"])
