"""Take the load off again: contact.nc to residual.nc, the surface that is left and the way back."""

from _job import save, snakemake

from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.statistics.unloading import evaluate_unloading

paths, settings = snakemake.input, snakemake.params.settings["residual"]
window = read_dataset(paths.window)["height"]
with opened_dataset(paths.contact) as contact:
    residual = evaluate_unloading(contact, window, settings, threads=snakemake.threads)
save(residual, snakemake.output.residual, settings, source=window.attrs)
