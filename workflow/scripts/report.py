"""Put all surfaces together: results/statistics.nc, summary.csv, pairs.csv and report.html."""

from pathlib import Path

from _job import snakemake

from roughcontact.report.gather import write_results

params, files = snakemake.params, zip(snakemake.input.statistics, snakemake.input.panels, strict=True)
write_results(
    Path(snakemake.output.page).parent,
    finished=[
        {"surface": surface, "case": case or None, "statistics": statistics, "panel": panel}
        for (surface, case), (statistics, panel) in zip(params.runs, files, strict=True)
    ],
    title=params.title,
    settings=params.settings,
    settings_of_statistics=params.settings_of_statistics,
    pairs=params.pairs,
)
