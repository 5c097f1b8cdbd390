"""Put all surfaces together: datasets, tables and report.html of all surfaces, groups and pairs."""

from pathlib import Path

from _job import say, snakemake

from roughcontact.report.gather import write_results
from roughcontact.results.collect import entry_of

params, files = snakemake.params, snakemake.input.statistics
finished = [entry_of(result, path) for result, path in zip(params.results, files, strict=True)]
left_out = write_results(Path(snakemake.output.page).parent, finished=finished, **params.arguments)
for text in left_out:
    say(f"warning: {text}")
