"""Solve the same problem by another code: crosscheck.nc, and the panel of the surface with the comparison."""

from _job import FILES, save, snakemake

from roughcontact.crosscheck.crosscheck import crosscheck
from roughcontact.report.panel import write_panel
from roughcontact.results.storage import read_dataset

window, contact, statistics = (read_dataset(FILES[name]) for name in ("window", "contact", "statistics"))
result = crosscheck(window["height"], contact, statistics, **snakemake.params.crosscheck)
settings = snakemake.params.settings
asked = {"crosscheck": {"code": snakemake.params.crosscheck["code"]}}
save(result, snakemake.output.crosscheck, settings | asked, source=statistics.attrs)
write_panel(
    snakemake.output.panel,
    surface=snakemake.wildcards.surface,
    case=snakemake.wildcards.get("case"),
    settings=settings,
    crosscheck=snakemake.output.crosscheck,
    **{name: path for name, path in snakemake.input.items() if name != "program" and path},
)
