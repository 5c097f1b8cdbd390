"""Wear the face by sliding: window.nc to worn.nc, the faces over the distance and their contact."""

from _job import save, snakemake
from _window import window_as_measured

from roughcontact.evaluation.courses import worn_in_a_run
from roughcontact.results.storage import opened_dataset, read_dataset

paths, settings = snakemake.input, snakemake.params.settings["worn"]
window = read_dataset(paths.window)["height"]
with opened_dataset(paths.contact) as contact:
    load = settings["wear"]["mean_pressure"] or float(contact["mean_pressure"].max())
as_measured = window_as_measured(window, settings)
worn = worn_in_a_run(window, settings, mean_pressure=load, as_measured=as_measured, threads=snakemake.threads)
save(worn, snakemake.output.worn, settings, source=window.attrs)
