"""Wear the face by sliding: window.nc to worn.nc, the faces over the distance and their contact."""

from functools import partial

from _job import save_course, snakemake
from _window import window_as_measured

from roughcontact.evaluation.courses import Face, worn_in_a_run
from roughcontact.results.storage import opened_dataset, read_dataset

paths, settings = snakemake.input, snakemake.params.settings["worn"]
window = read_dataset(paths.window)["height"]
with opened_dataset(paths.contact) as contact:
    load = settings["wear"]["mean_pressure"] or float(contact["mean_pressure"].max())
face = Face(window, window_as_measured(window, settings))
worn = partial(worn_in_a_run, face, settings, mean_pressure=load, threads=snakemake.threads)
save_course(worn, snakemake.output.worn, settings, source=window.attrs)
