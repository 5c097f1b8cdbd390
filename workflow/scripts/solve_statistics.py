"""Solve and count at once: window.nc and uncertainty.nc to contact.nc, without maps, and statistics.nc."""

from _job import save, snakemake
from _solver import solver_arguments

from roughcontact.contact.solve import solve_contact
from roughcontact.results.storage import read_dataset
from roughcontact.statistics.checks import with_verdicts
from roughcontact.statistics.contact_statistics import SOLUTION_COLUMNS, statistics_of, with_uncertainty
from roughcontact.statistics.first_yield import with_first_yield
from roughcontact.statistics.subsurface import with_subsurface_yield

settings = snakemake.params.settings
window = read_dataset(snakemake.input.window)["height"]
budget = read_dataset(snakemake.input.uncertainty)
arguments, bodies = solver_arguments(window, settings["contact"]), settings["contact"]["bodies"]
modulus = arguments["contact_modulus"]
count = statistics_of(window, contact_modulus=modulus, bodies=bodies, **settings["statistics"])
result = solve_contact(window, **arguments, reduce=count)
yielding = with_first_yield(result, window, settings["contact"], threads=snakemake.threads)
complete = with_subsurface_yield(with_uncertainty(yielding, budget), bodies)
save(with_verdicts(complete, window), snakemake.output.statistics, settings, source=window.attrs)
save(result[[*SOLUTION_COLUMNS]], snakemake.output.contact, settings, source=window.attrs)
