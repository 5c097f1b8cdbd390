"""Put all surfaces together: datasets, tables and report.html of all surfaces, groups and pairs."""

from pathlib import Path

from _job import snakemake, warn

from roughcontact.report.gather import write_results
from roughcontact.results.collect import result_entry

params, files = snakemake.params, snakemake.input.statistics
finished = list(map(result_entry, params.results, files, params.results.values()))
left_out = write_results(Path(snakemake.output.page).parent, finished=finished, **params.arguments)
for text in left_out:
    warn(text)
