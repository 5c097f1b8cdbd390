"""Let rubber slide over the face: window.nc to sliding.nc, friction and contact over the speed."""

from functools import partial

from _job import save_course, snakemake
from _window import window_as_measured

from roughcontact.evaluation.courses import Face, slid_in_a_run
from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.surface.faces.placing import separate_overviews

paths, settings = snakemake.input, snakemake.params.settings["sliding"]
window = read_dataset(paths.window)["height"]
with opened_dataset(paths.contact) as contact:
    load = settings["sliding"]["mean_pressure"] or float(contact["mean_pressure"].max())
with opened_dataset(paths.levelled) as levelled:  # read for an overview alone
    overviews = separate_overviews(read_dataset(paths.overview)) if paths.overview else ()
    face = Face(window, window_as_measured(window, settings), levelled["height"], overviews)
    slid = partial(slid_in_a_run, face, settings, mean_pressure=load, threads=snakemake.threads)
    save_course(slid, snakemake.output.sliding, settings, source=window.attrs)
