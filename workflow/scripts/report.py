"""Put all surfaces together: datasets, tables and report.html of all surfaces, groups and pairs."""

from pathlib import Path

from _job import say, snakemake

from roughcontact.report.gather import write_results

residuals = {Path(path).parent: path for path in snakemake.input.residuals}
params, files = snakemake.params, zip(snakemake.input.statistics, snakemake.input.panels, strict=True)
finished = []
for result, (statistics, panel) in zip(params.results, files, strict=True):
    case, _, surface = result.rpartition("/")
    finished.append({"surface": surface, "case": case or None, "statistics": statistics, "panel": panel})
    finished[-1]["residual"] = residuals.get(Path(statistics).parent)
left_out = write_results(Path(snakemake.output.page).parent, finished=finished, **params.arguments)
for text in left_out:
    say(f"warning: {text}")
