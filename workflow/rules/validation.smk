# `snakemake validation`: the program against what is known from elsewhere. Nothing here depends on the surfaces.
from roughcontact.validation import PARTS


rule validate:
    """Compute one part of the validation and compare it line by line."""
    input:
        sample=ROOT / "data_samples/sandblasted.x3p",
    output:
        "results/validation/{part}.json",
    log:
        "logs/validation/{part}.validate.log",
    wildcard_constraints:
        part="|".join(PARTS),
    conda:
        "../envs/roughcontact.yaml"
    resources:
        mem_mb=2000,
        runtime=20,
    params:
        settings=PLAN.common["validation"],
        code=code("validate"),
    script:
        "../scripts/validate.py"


rule validation_page:
    """Put the parts of the validation together to one page and one table."""
    input:
        expand("results/validation/{part}.json", part=PARTS),
    output:
        page="results/validation/validation.html",
        table="results/validation/lines.csv",
    log:
        "logs/validation/validation_page.log",
    localrule: True
    conda:
        "../envs/roughcontact.yaml"
    params:
        code=code("validation_page"),
    script:
        "../scripts/validation_page.py"


# no output: it is asked anew each time, and fails each time, until all lines hold
rule validation:
    """Fail where a line of the validation deviates beyond its tolerance; the page is there all the same."""
    input:
        parts=expand("results/validation/{part}.json", part=PARTS),
        page="results/validation/validation.html",
    log:
        "logs/validation/validation.log",
    localrule: True
    conda:
        "../envs/roughcontact.yaml"
    params:
        code=code("validation"),
    script:
        "../scripts/validation.py"
