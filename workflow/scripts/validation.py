"""Fail where a line of the validation does not hold."""

from _job import say, snakemake

from roughcontact.validation.page import check, read_parts

count = check(read_parts(snakemake.input.parts), snakemake.input.page)
say(f"all {count} lines hold: {snakemake.input.page}")
