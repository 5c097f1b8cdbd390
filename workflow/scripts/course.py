"""Let a smooth face or rubber slide over the face: window.nc to worn.nc over the distance, or sliding.nc."""

from functools import partial
from pathlib import Path

from _job import save_course, snakemake
from _window import window_as_measured

from roughcontact.arguments.settings.stages import AFTER
from roughcontact.evaluation.courses import COURSES, Face
from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.surface.faces.placing import separate_overviews

paths, stage = snakemake.input, Path(snakemake.output[0]).stem
settings = snakemake.params.settings[stage]
section, *_ = AFTER[stage]
window = read_dataset(paths.window)["height"]
with opened_dataset(paths.contact) as contact:
    load = settings[section]["mean_pressure"] or float(contact["mean_pressure"].max())
with opened_dataset(paths.levelled) as levelled:  # read for an overview alone
    overviews = separate_overviews(read_dataset(paths.overview)) if paths.overview else ()
    face = Face(window, window_as_measured(window, settings), levelled["height"], overviews)
    course = partial(COURSES[section], face, settings, mean_pressure=load, threads=snakemake.threads)
    save_course(course, snakemake.output[0], settings, source=window.attrs)
