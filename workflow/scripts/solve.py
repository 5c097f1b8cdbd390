"""Solve the contact problem for every load: window.nc to contact.nc."""

from _job import save, snakemake
from _solver import solver_arguments

from roughcontact.contact.solve import solve_contact
from roughcontact.results.storage import read_dataset

settings = snakemake.params.settings
window = read_dataset(snakemake.input[0])["height"]
contact = solve_contact(window, **solver_arguments(window, settings["contact"]))
save(contact, snakemake.output[0], settings, source=window.attrs)
