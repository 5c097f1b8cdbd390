"""Remove form and outliers and fill in missing points: height.nc to levelled.nc."""

from _job import save, snakemake

from roughcontact.levelling.level import level
from roughcontact.results.storage import read_dataset

settings = snakemake.params.settings
height = read_dataset(snakemake.input[0])["height"]
levelled = level(height, **settings["level"])
save(levelled, snakemake.output[0], settings, source=height.attrs)
