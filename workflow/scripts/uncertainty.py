"""Ask how far the results may be off, source by source: levelled.nc and window.nc to uncertainty.nc."""

from _job import save, snakemake
from _solver import solver_arguments

from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.uncertainty.budget import error_budget

settings = snakemake.params.settings
window = read_dataset(snakemake.input.window)["height"]
contact = solver_arguments(window, settings["contact"]) | {"progress": None}
verbs = {"level": settings["level"], "window": settings["window"], "contact": contact}
# read when it is wanted, not beside the first solve
with opened_dataset(snakemake.input.levelled) as levelled:
    budget = error_budget(levelled["height"], window, verbs, **settings["uncertainty"])
save(budget, snakemake.output[0], settings, source=window.attrs)
