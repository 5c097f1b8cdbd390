"""Solve the same problem by another code: window.nc, contact.nc and statistics.nc to crosscheck.nc."""

from _job import save, snakemake

from roughcontact.crosscheck.crosscheck import crosscheck
from roughcontact.results.storage import read_dataset

files = ("window", "contact", "statistics")
window, contact, statistics = (read_dataset(snakemake.input[name]) for name in files)
result = crosscheck(window["height"], contact, statistics, **snakemake.params.crosscheck)
settings = snakemake.params.settings | {"crosscheck": {"code": snakemake.params.crosscheck["code"]}}
save(result, snakemake.output[0], settings, source=statistics.attrs)
