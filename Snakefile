"""From measured height maps to contact area and contact pressure: one folder of results per surface."""

from snakemake.utils import min_version

min_version("9.0")


report: "workflow/report/workflow.rst"


include: "workflow/rules/common.smk"
include: "workflow/rules/runs.smk"
include: "workflow/rules/surface.smk"
include: "workflow/rules/contact.smk"
include: "workflow/rules/crosscheck.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/validation.smk"
include: "workflow/rules/cost.smk"


rule all:
    default_target: True
    input:
        "results/summary.csv",
        "results/statistics.nc",
        "results/report.html",
        LINKS,


onerror:
    print(unfinished(), file=sys.stderr)
