"""Put the parts together to one self-contained page: results/report.html."""

from _job import snakemake

from roughcontact.report.page import write_report

write_report(
    snakemake.output[0],
    panels=list(snakemake.input.panels),
    statistics=snakemake.input.statistics,
    pairs=next(iter(snakemake.input.pairs), None),
    title=snakemake.params.title,
    settings=snakemake.params.settings,
)
