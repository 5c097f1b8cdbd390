"""Compute one part of the validation: results/validation/{part}.json."""

from _job import snakemake

from roughcontact.results.storage import write_text
from roughcontact.validation.lines import to_json
from roughcontact.validation.parts import validate

part = validate(snakemake.wildcards.part, snakemake.input.sample, **snakemake.params.settings)
write_text(to_json(part), snakemake.output[0])
