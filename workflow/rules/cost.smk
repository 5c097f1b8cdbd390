# `snakemake cost`: run time against error, measured on the maps themselves.
rule measure_cost:
    """Solve one window on several grids to several tolerances, with times and errors."""
    input:
        of(PLAN.file, "window"),
    output:
        f"{PLAN.folder}/cost.csv",
    log:
        f"{PLAN.logs}/measure_cost.log",
    conda:
        "../envs/roughcontact.yaml"
    threads: os.cpu_count()  # all there are: nothing else may run beside what is timed
    resources:
        mem_mb=lambda wildcards: round(700 + points(wildcards.surface) * 5000 / 1e6),
        runtime=60,
    params:
        settings=of(PLAN.settings, "contact"),
        threads=lambda wildcards: PLAN.threads(wildcards.surface),
        code=code("measure_cost"),
    script:
        "../scripts/measure_cost.py"


rule cost:
    """Draw run time against error, and recommend a grid and a tolerance."""
    input:
        [f"{PLAN.folder}/cost.csv".format(**run._asdict()) for run in PLAN.runs],
    output:
        "results/cost.html",
    log:
        "logs/cost.log",
    conda:
        "../envs/roughcontact.yaml"
    params:
        names=[" · ".join(filter(None, run)) for run in PLAN.runs],
        code=code("cost"),
    script:
        "../scripts/cost.py"
