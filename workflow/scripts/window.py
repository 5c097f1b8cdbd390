"""Cut out a window without missing points and make it periodic: levelled.nc to window.nc."""

from _job import save, snakemake

from roughcontact.results.storage import read_dataset
from roughcontact.window.periodic_window import periodic_window

settings = snakemake.params.settings
levelled = read_dataset(snakemake.input[0])["height"]
window = periodic_window(levelled, **settings["window"])
save(window, snakemake.output[0], settings, source=levelled.attrs)
