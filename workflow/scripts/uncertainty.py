"""Ask how far the results may be off, source by source: levelled.nc and window.nc to uncertainty.nc."""

from _job import save, snakemake
from _solver import solver_arguments

from roughcontact.results.storage import read_dataset
from roughcontact.uncertainty.budget import error_budget

settings = snakemake.params.settings
levelled, window = (read_dataset(snakemake.input[name])["height"] for name in ("levelled", "window"))
contact = solver_arguments(window, settings["contact"]) | {"progress": None}
verbs = {"level": settings["level"], "window": settings["window"], "contact": contact}
budget = error_budget(levelled, window, verbs, **settings["uncertainty"])
save(budget, snakemake.output[0], settings, source=window.attrs)
