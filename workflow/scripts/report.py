"""Put all surfaces together: datasets, tables and report.html of all surfaces, groups and pairs."""

from pathlib import Path

from _job import say, snakemake

from roughcontact.report.gather import write_results

params, files = snakemake.params, zip(snakemake.input.statistics, snakemake.input.panels, strict=True)
left_out = write_results(
    Path(snakemake.output.page).parent,
    finished=[
        {"surface": surface, "case": case or None, "statistics": statistics, "panel": panel}
        for (surface, case), (statistics, panel) in zip(params.runs, files, strict=True)
    ],
    title=params.title,
    settings=params.settings,
    changed=params.changed,
    settings_of_statistics=params.settings_of_statistics,
    groups=params.groups,
    same_places=params.same_places,
)
for text in left_out:
    say(f"warning: {text}")
