"""Take the load off again: contact.nc to residual.nc, the surface that is left and the way back."""

from functools import partial

from _job import save_course, snakemake

from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.statistics.unloading import evaluate_unloading

paths, settings = snakemake.input, snakemake.params.settings["residual"]
window = read_dataset(paths.window)["height"]
with opened_dataset(paths.contact) as contact:
    unload = partial(evaluate_unloading, contact, window, settings, threads=snakemake.threads)
    save_course(unload, snakemake.output.residual, settings, source=window.attrs)
