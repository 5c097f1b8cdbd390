"""Solve and count at once: window.nc and uncertainty.nc to contact.nc, without maps, and statistics.nc."""

from functools import partial

from _job import save, snakemake
from _solver import solver_arguments

from roughcontact.contact.solve import solve_contact
from roughcontact.results.storage import read_dataset
from roughcontact.statistics.checks import with_verdicts
from roughcontact.statistics.contact_statistics import SOLUTION_COLUMNS, contact_statistics, with_uncertainty
from roughcontact.statistics.first_yield import with_first_yield
from roughcontact.statistics.subsurface import with_subsurface_yield

settings = snakemake.params.settings
window = read_dataset(snakemake.input.window)["height"]
budget = read_dataset(snakemake.input.uncertainty)
bodies = settings["contact"]["bodies"]
count = partial(contact_statistics, bodies=bodies, **settings["statistics"])
result = solve_contact(window, **solver_arguments(window, settings["contact"]), reduce=count)
yielding = with_first_yield(result, window, settings["contact"], threads=snakemake.threads)
complete = with_subsurface_yield(with_uncertainty(yielding, budget), bodies)
save(with_verdicts(complete, window), snakemake.output.statistics, settings, source=window.attrs)
save(result[[*SOLUTION_COLUMNS]], snakemake.output.contact, settings, source=window.attrs)
