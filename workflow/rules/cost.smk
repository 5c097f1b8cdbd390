# `snakemake cost`: run time against error, measured on the maps themselves.
rule measure_cost:
    """Solve one window on several grids to several tolerances, with times and errors."""
    input:
        stage_file("window"),
    output:
        f"{FOLDER}/cost.csv",
    log:
        f"{LOGS}/measure_cost.log",
    conda:
        "../envs/roughcontact.yaml"
    threads: os.cpu_count()  # all there are: nothing else may run beside what is timed
    resources:
        mem_mb=memory(bytes_per_point=5000),
        runtime=60,
    params:
        settings=stage_settings("contact"),
        threads=solver_threads,
        code=code("measure_cost"),
    script:
        "../scripts/measure_cost.py"


rule cost:
    """Draw run time against error, and recommend a grid and a tolerance."""
    input:
        [f"{FOLDER}/cost.csv".format(**run) for run in RUNS],
    output:
        "results/cost.html",
    log:
        "logs/cost.log",
    conda:
        "../envs/roughcontact.yaml"
    params:
        names=[
            " · ".join(filter(None, (run["surface"], run.get("case")))) for run in RUNS
        ],
        code=code("cost"),
    script:
        "../scripts/cost.py"
