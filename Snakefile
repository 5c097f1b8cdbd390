"""The workflow, for `snakemake` in the checkout's own folder; all of it lies in workflow/Snakefile."""

import sys

# Snakemake puts this folder first on the path; what lies in it beside the maps is no code.
sys.path[:] = [path for path in sys.path if path != str(workflow.basedir)]


include: "workflow/Snakefile"


# what is included sets no default target
rule default:
    input:
        rules.all.input,
