# What each case shares with another one is a link into that case's folder, so that every folder is complete.
SHARED = {
    case: {
        stage: OWNERS[stage][case] for stage in SECTIONS if OWNERS[stage][case] != case
    }
    for case in CASES
}
LINKS = [
    f"results/{case}/{surface}/{stage}.nc"
    for case in CASES
    for surface in SURFACES
    for stage in SHARED[case]
]


localrules:
    all,
    collect,


for case, owners_of in SHARED.items():
    if owners_of:

        rule:
            name:
                f"share_{case}"
            # links what other cases have computed
            input:
                [
                    f"results/{first}/{{surface}}/{stage}.nc"
                    for stage, first in owners_of.items()
                ],
            output:
                [f"results/{case}/{{surface}}/{stage}.nc" for stage in owners_of],
            log:
                f"logs/{case}/{{surface}}/share.log",
            localrule: True
            conda:
                "../envs/roughcontact.yaml"
            script:
                "../scripts/share.py"


rule panel:
    """Draw one surface's part of the report."""
    input:
        height=stage_file("height"),
        levelled=stage_file("levelled"),
        window=stage_file("window"),
        contact=stage_file("contact"),
        statistics=stage_file("statistics"),
        crosscheck=crosscheck_file,
    output:
        f"{FOLDER}/panel.html",
    log:
        f"{LOGS}/panel.log",
    conda:
        "../envs/roughcontact.yaml"
    resources:
        mem_mb=memory(bytes_per_point=300, and_load=50),
        runtime=minutes(microseconds_per_point=20),
    params:
        settings=stage_settings("statistics"),
        code=code("panel"),
    script:
        "../scripts/panel.py"


rule collect:
    """Put the statistics of all surfaces into one dataset and one table."""
    input:
        [stage_file("statistics")(run) for run in RUNS],
    output:
        statistics=report(
            "results/statistics.nc",
            caption="../report/statistics.rst",
            category="Data",
        ),
        summary=report(
            "results/summary.csv", caption="../report/summary.rst", category="Data"
        ),
    log:
        "logs/collect.log",
    conda:
        "../envs/roughcontact.yaml"
    params:
        entries=[{"case": None, **run} for run in RUNS],
        settings=run_settings(lambda settings: settings_of(settings, "statistics")),
        code=code("collect"),
    script:
        "../scripts/collect.py"


rule report:
    """Put the parts together to one self-contained page."""
    input:
        statistics="results/statistics.nc",
        panels=[f"{FOLDER}/panel.html".format(**run) for run in RUNS],
    output:
        report("results/report.html", caption="../report/page.rst", category="Page"),
    log:
        "logs/report.log",
    conda:
        "../envs/roughcontact.yaml"
    params:
        title=CASES[next(iter(CASES))]["report"]["title"],
        settings=run_settings(),
        code=code("report"),
    script:
        "../scripts/report.py"
