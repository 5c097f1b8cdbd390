LINKS = [
    f"results/{case}/{surface}/{stage}.nc"
    for case in CASES
    for surfaces, stages in STAGES.values()
    for surface in surfaces
    for stage in stages
    if stage in SHARED[case]
]


for case, owners_of in SHARED.items():
    for kind, (surfaces, stages) in STAGES.items():
        shared = {stage: owners_of[stage] for stage in stages if stage in owners_of}
        surfaces = [surface for surface in surfaces if surface not in SMALL]
        if shared and surfaces:

            rule:
                name:
                    f"share_{case}{kind}"
                # links what other cases have computed
                input:
                    [
                        f"results/{first}/{{surface}}/{stage}.nc"
                        for stage, first in shared.items()
                    ],
                output:
                    [f"results/{case}/{{surface}}/{stage}.nc" for stage in shared],
                log:
                    f"logs/{case}/{{surface}}/share.log",
                wildcard_constraints:
                    surface=one_of(surfaces),
                localrule: True
                conda:
                    "../envs/roughcontact.yaml"
                script:
                    "../scripts/share.py"


from roughcontact.report import ONE_PAGE


rule panel:
    """Draw one surface's part of the report."""
    input:
        height=stage_file("height"),
        counter_face=counter_face,
        levelled=stage_file("levelled"),
        window=stage_file("window"),
        contact=stage_file("contact"),
        statistics=stage_file("statistics"),
        crosscheck=crosscheck_file,
    output:
        shown("panel"),
    log:
        f"{LOGS}/panel.log",
    wildcard_constraints:
        surface=(stagewise(SOLVED) if CROSSCHECK["code"] == "none" else one_of(SOLVED)),
    group:
        "surface"
    conda:
        "../envs/roughcontact.yaml"
    resources:
        mem_mb=memory(bytes_per_point=80),
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
        **(
            {
                "pairs": report(
                    "results/pairs.csv",
                    caption="../report/pairs.rst",
                    category="All surfaces",
                    labels={"holds": "pairs of faces", "file": "table"},
                )
            }
            if MEMBERS
            else {}
        ),
        statistics=report(
            "results/statistics.nc",
            caption="../report/statistics.rst",
            category="All surfaces",
            labels={"holds": "all numbers", "file": "netCDF"},
        ),
        summary=report(
            "results/summary.csv",
            caption="../report/summary.rst",
            category="All surfaces",
            labels={"holds": "all numbers", "file": "table"},
        ),
    log:
        "logs/collect.log",
    localrule: True
    conda:
        "../envs/roughcontact.yaml"
    resources:
        mem_mb=memory_of_all,
        runtime=minutes_of_all,
    params:
        entries=[{"case": None, **run} for run in RUNS],
        pairs={name: member.pair for name, member in MEMBERS.items()},
        settings=run_settings(lambda settings: settings_of(settings, "statistics")),
        code=code("collect"),
    script:
        "../scripts/collect.py"


rule report:
    """Put the parts together to one self-contained page."""
    input:
        statistics="results/statistics.nc",
        pairs=["results/pairs.csv"] if MEMBERS else [],
        panels=[f"{FOLDER}/panel.html".format(**run) for run in RUNS],
    output:
        report(
            "results/report.html",
            caption="../report/page.rst",
            category="All surfaces",
            labels={"holds": "figures, numbers, checks", "file": "page"},
        ),
        **({"pages": directory("results/pages")} if len(RUNS) > ONE_PAGE else {}),
    log:
        "logs/report.log",
    conda:
        "../envs/roughcontact.yaml"
    resources:
        mem_mb=memory_of_all,
        runtime=minutes_of_all,
    params:
        title=CASES[next(iter(CASES))]["report"]["title"],
        settings=run_settings(),
        code=code("report"),
    script:
        "../scripts/report.py"
