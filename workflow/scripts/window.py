"""Cut out a window without missing points and make it periodic: levelled.nc to window.nc."""

from _job import save, snakemake

from roughcontact.results.storage import opened_dataset
from roughcontact.window.periodic_window import periodic_window

settings = snakemake.params.settings
with opened_dataset(snakemake.input[0]) as file:  # without what levelling has rejected, which is as large
    levelled = file["height"].drop_vars("rejected_height", errors="ignore").load()
window = periodic_window(levelled, **settings["window"])
save(window, snakemake.output[0], settings, source=levelled.attrs)
