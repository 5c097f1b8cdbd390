"""Put the statistics of all surfaces into results/statistics.nc and results/summary.csv."""

import json

from _job import save, snakemake

from roughcontact.collect import collect_statistics, summary_table
from roughcontact.storage import read_dataset, write_table

files = zip(snakemake.params.entries, snakemake.input, strict=True)
entries = [{**entry, "statistics": path} for entry, path in files]
checksums = {entry["surface"]: read_dataset(entry["statistics"]).attrs["source_sha256"] for entry in entries}
source = {"source_sha256": json.dumps(checksums, sort_keys=True)}
statistics = collect_statistics(entries)
save(statistics, snakemake.output.statistics, snakemake.params.settings, source=source)
write_table(summary_table(statistics), snakemake.output.summary)
