"""Put the statistics of all surfaces into results/statistics.nc and results/summary.csv."""

import json

from _job import save, snakemake

from roughcontact.collect import collect_statistics, summary_table
from roughcontact.storage import read_dataset, write_text

files = zip(snakemake.params.entries, snakemake.input, strict=True)
entries = [{**entry, "statistics": path} for entry, path in files]
checksums = {entry["surface"]: read_dataset(entry["statistics"]).attrs["source_sha256"] for entry in entries}
source = {"source_sha256": json.dumps(checksums, sort_keys=True)}
statistics = collect_statistics(entries)
save(statistics, snakemake.output.statistics, snakemake.params.settings, source=source)
write_text(summary_table(statistics).to_csv(index=False, float_format="%.10g"), snakemake.output.summary)
