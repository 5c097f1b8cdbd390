"""Put the parts of the validation together: results/validation/validation.html and lines.csv."""

from _job import snakemake

from roughcontact.validation.page import read_parts, write_page, write_table

parts = read_parts(snakemake.input)
write_page(snakemake.output.page, parts)
write_table(snakemake.output.table, parts)
