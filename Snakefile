"""The workflow, for `snakemake` in the checkout's own folder; all of it lies in workflow/Snakefile."""


include: "workflow/Snakefile"


# what is included sets no default target
rule default:
    default_target: True
    input:
        rules.all.input,
