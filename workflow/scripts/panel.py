"""Draw one surface's part of the report: panel.html."""

from _job import snakemake

from roughcontact.report.panel import write_panel

write_panel(
    snakemake.output[0],
    surface=snakemake.wildcards.surface,
    case=snakemake.wildcards.get("case"),
    settings=snakemake.params.settings,
    **dict(snakemake.input.items()),
)
