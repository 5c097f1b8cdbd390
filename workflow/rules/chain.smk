# The chain: read, level, window in the job `prepare`; solve, evaluate in the job `contact`; draw in
# the job `panel`, so that another word or colour solves nothing again; the report of all.
# {result} is the folder of a result: `ground`, or `soft/ground` under a case. A case that agrees with an earlier one in
# the settings that a file depends on has no such file: `file_of` names that of the earlier case.
from roughcontact.report import ONE_PAGE

# what is solved, and what it was made of
PREPARED = {
    name: file_of(name)
    for name in ("height", "counter_height", "levelled", "window", "overview")
}


# of a pair its faces, which are windowed together; of a map with an overview also that
for RULE in ("prepare", "prepare_face", "prepare_with_overview"):

    rule:
        """Read the measured file, level the map, cut out the periodic window."""
        name:
            RULE
        input:
            sources=sources_of(RULE),
        output:
            **written_by(RULE),
        log:
            f"logs/{{result}}/{RULE}.log",
        wildcard_constraints:
            result=pattern_of(RULE),
        priority: 1  # before all others, so that every file that cannot be read is known soon
        conda:
            "../envs/roughcontact.yaml"
        resources:
            **resources_of(RULE),
        params:
            **params_of(RULE),
        script:
            "../scripts/prepare.py"


rule superpose:
    """Lay the two levelled faces of a pair on one another, in one of their relative positions."""
    input:
        sources=sources_of("superpose"),
        face=file_of("face"),
        counter_face=file_of("counter_face"),
    output:
        **written_by("superpose"),
    log:
        "logs/{result}/superpose.log",
    wildcard_constraints:
        result=pattern_of("superpose"),
    conda:
        "../envs/roughcontact.yaml"
    resources:
        **resources_of("superpose"),
    params:
        **params_of("superpose"),
    script:
        "../scripts/superpose.py"


# a case with other settings of statistics or uncertainty evaluates the solution of an earlier case
for RULE in ("contact", "statistics"):

    rule:
        """Solve the contact for every load, bound its error, compute the statistics."""
        name:
            RULE
        input:
            **PREPARED,
            sources=sources_of(RULE),
            contact=file_of("contact", earlier=True),
            uncertainty=file_of("uncertainty", earlier=True),
            statistics=file_of("statistics", earlier=True),
        output:
            **written_by(RULE),
        log:
            f"logs/{{result}}/{RULE}.log",
        wildcard_constraints:
            result=pattern_of(RULE),
        conda:
            "../envs/roughcontact.yaml"
        threads: threads_of()
        resources:
            **resources_of(RULE),
        params:
            **params_of(RULE),
        script:
            "../scripts/contact.py"


rule panel:
    """Draw the section of one result in the report: figures, checks, tables."""
    input:
        **PREPARED,
        sources=sources_of("panel"),
        contact=file_of("contact"),
        statistics="results/{result}/statistics.nc",
        courses=lambda wildcards: PLAN.further_files(wildcards.result),
    output:
        panel=shown(
            "results/{result}/panel.html", "surface_panel", "figures and checks"
        ),
        summary="results/{result}/panel.json",
    log:
        "logs/{result}/panel.log",
    wildcard_constraints:
        result=pattern_of("panel"),
    priority: 1  # a result is complete before the next one is solved
    conda:
        "../envs/roughcontact.yaml"
    resources:
        **resources_of("panel"),
    params:
        **params_of("panel"),
    script:
        "../scripts/panel.py"


# what follows the contact: the surface that plastic flow has left, those that sliding leaves, the friction of rubber
for RULE in ("unload", "wear", "slide"):

    rule:
        """Take the load off, or let a smooth face, or rubber, slide over the face."""
        name:
            RULE
        input:
            sources=sources_of(RULE),
            levelled=file_of("levelled"),
            window=file_of("window"),
            overview=file_of("overview"),
            contact=file_of("contact"),
        output:
            **written_by(RULE),
        log:
            f"logs/{{result}}/{RULE}.log",
        wildcard_constraints:
            result=pattern_of(RULE),
        priority: 1  # the panel waits for it
        conda:
            "../envs/roughcontact.yaml"
        threads: threads_of()
        resources:
            **resources_of(RULE),
        params:
            **params_of(RULE),
        script:
            f"../scripts/{SCRIPTS.get(RULE, RULE)}.py"


# files that only some studies have
FURTHER = {}
if PLAN.groups or PLAN.pairs or PLAN.same_area_pairs:
    FURTHER["groups"] = shown("results/groups.nc", "groups", "results of groups")
    FURTHER["groups_table"] = shown("results/groups.csv", "groups", "results of groups")
    FURTHER["comparisons"] = shown(
        "results/comparisons.csv", "comparisons", "differences of groups"
    )
if len(PLAN.results) > ONE_PAGE:
    FURTHER["pages"] = directory("results/pages")


rule report:
    """Put all results into one dataset, one table, and one self-contained page."""
    input:
        statistics=expand("results/{result}/statistics.nc", result=PLAN.results),
        # which are read beside the statistics
        panels=expand("results/{result}/panel.html", result=PLAN.results),
        summaries=expand("results/{result}/panel.json", result=PLAN.results),
        further=[f for result in PLAN.results for f in PLAN.further_files(result)],
    output:
        **FURTHER,
        statistics=shown("results/statistics.nc", "statistics", "all numbers"),
        summary=shown("results/summary.csv", "summary", "all numbers"),
        budget=shown(
            "results/uncertainty.csv", "uncertainty", "components of every interval"
        ),
        page=shown("results/report.html", "page", "figures, numbers, checks"),
    log:
        "logs/report.log",
    conda:
        "../envs/roughcontact.yaml"
    resources:
        **resources_of("report"),
    params:
        **params_of("report"),
    script:
        "../scripts/report.py"
