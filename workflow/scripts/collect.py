"""Put the statistics of all surfaces into results/statistics.nc and results/summary.csv."""

from _job import save, snakemake

from roughcontact.results.collect import collect_statistics, pairs_table, summary_table
from roughcontact.results.storage import write_table

files = zip(snakemake.params.entries, snakemake.input, strict=True)
entries = [{**entry, "statistics": path} for entry, path in files]
statistics = collect_statistics(entries)
save(statistics, snakemake.output.statistics, snakemake.params.settings, source=statistics.attrs)
summary = summary_table(statistics)
write_table(summary, snakemake.output.summary)
if snakemake.params.pairs:
    write_table(pairs_table(summary, snakemake.params.pairs), snakemake.output.pairs)
