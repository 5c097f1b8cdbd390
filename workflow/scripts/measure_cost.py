"""Measure run time against error on one window: window.nc to cost.csv."""

from _job import snakemake

from roughcontact.cost.measure import run_time_against_error
from roughcontact.pipeline import solver_arguments
from roughcontact.results.storage import read_dataset, write_table

window = read_dataset(snakemake.input[0])["height"]
arguments = solver_arguments(window, snakemake.params.settings["contact"], threads=snakemake.threads)
problem = {
    name: arguments[name] for name in ("contact_modulus", "mean_pressure", "bodies") if name in arguments
}
table = run_time_against_error(window, **problem, threads=snakemake.params.threads)
write_table(table, snakemake.output[0])
