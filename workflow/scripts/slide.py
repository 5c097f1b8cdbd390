"""Let rubber slide over the face: window.nc to sliding.nc, friction and contact over the speed."""

from _job import save, snakemake

from roughcontact.evaluation.sliding import slid_in_a_run
from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.surface.window.periodic_window import periodic_window

paths, settings = snakemake.input, snakemake.params.settings["sliding"]
window = read_dataset(paths.window)["height"]
with opened_dataset(paths.contact) as contact:
    load = settings["sliding"]["mean_pressure"] or float(contact["mean_pressure"].max())
as_measured = (
    periodic_window(read_dataset(paths.levelled)["height"], **settings["window"])
    if "corrected_for" in window.attrs
    else None
)
slid = slid_in_a_run(window, settings, mean_pressure=load, as_measured=as_measured, threads=snakemake.threads)
save(slid, snakemake.output.sliding, settings, source=window.attrs)
