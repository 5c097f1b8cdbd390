"""Lay the two faces of a pair on one another in one of the ways of the ensemble: two levelled.nc to one."""

from _job import save, snakemake

from roughcontact.faces.composite import composite
from roughcontact.faces.positions import relative_positions
from roughcontact.results.storage import read_dataset

settings = snakemake.params.settings
pair = settings["surface"]
faces = [read_dataset(path)["height"] for path in snakemake.input]
position = relative_positions(*faces, **pair["composite"])[pair["number"] - 1]
result = composite(*faces, **position)
save(result, snakemake.output[0], settings, source=result.attrs)
