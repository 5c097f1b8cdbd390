"""Solve the contact problem for every load: window.nc to contact.nc, which is written load by load."""

from _job import save, snakemake
from _solver import solver_arguments

from roughcontact.contact.solve import solve_contact
from roughcontact.results.storage import read_dataset, written_load_by_load

settings = snakemake.params.settings
window = read_dataset(snakemake.input[0])["height"]
arguments = solver_arguments(window, settings["contact"])
with written_load_by_load(snakemake.output[0], arguments["mean_pressure"], window) as file:
    contact = solve_contact(window, **arguments, reduce=file.keep)
    save(contact.assign(height=window), snakemake.output[0], settings, source=window.attrs, into=file)
