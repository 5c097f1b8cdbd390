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
STATISTICS = shown(
    "results/{result}/statistics.nc", "surface_statistics", "all numbers"
)


rule prepare:
    """Read the measured file, level the map, cut out the periodic window."""
    input:
        sources=sources_of("prepare"),
    output:
        height="results/{result}/height.nc",
        levelled="results/{result}/levelled.nc",
        window="results/{result}/window.nc",
    log:
        "logs/{result}/prepare.log",
    wildcard_constraints:
        result=pattern_of("prepare"),
    priority: 1  # before all others, so that every file that cannot be read is known soon
    conda:
        "../envs/roughcontact.yaml"
    resources:
        **resources_of("prepare"),
    params:
        **params_of("prepare"),
    script:
        "../scripts/prepare.py"


use rule prepare as prepare_face with:
    output:
        height="results/{result}/height.nc",
        levelled="results/{result}/levelled.nc",
    log:
        "logs/{result}/prepare_face.log",
    wildcard_constraints:
        result=pattern_of("prepare_face"),
    params:
        **params_of("prepare_face"),


use rule prepare as prepare_with_overview with:
    output:
        height="results/{result}/height.nc",
        levelled="results/{result}/levelled.nc",
        window="results/{result}/window.nc",
        overview="results/{result}/overview.nc",
    log:
        "logs/{result}/prepare_with_overview.log",
    wildcard_constraints:
        result=pattern_of("prepare_with_overview"),
    params:
        **params_of("prepare_with_overview"),


rule superpose:
    """Lay the two levelled faces of a pair on one another, in one of their relative positions."""
    input:
        sources=sources_of("superpose"),
        face=file_of("face"),
        counter_face=file_of("counter_face"),
    output:
        levelled="results/{result}/levelled.nc",
        window="results/{result}/window.nc",
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


rule contact:
    """Solve the contact for every load, bound its error, compute the statistics."""
    input:
        **PREPARED,
        sources=sources_of("contact"),
        uncertainty=file_of("uncertainty", earlier=True),
    output:
        contact="results/{result}/contact.nc",
        uncertainty="results/{result}/uncertainty.nc",
        statistics=STATISTICS,
    log:
        "logs/{result}/contact.log",
    wildcard_constraints:
        result=pattern_of("contact"),
    conda:
        "../envs/roughcontact.yaml"
    threads: threads_of()
    resources:
        **resources_of("contact"),
    params:
        **params_of("contact"),
    script:
        "../scripts/contact.py"


# a case with other settings of statistics or uncertainty evaluates the solution of an earlier case
use rule contact as statistics with:
    input:
        **PREPARED,
        sources=sources_of("statistics"),
        contact=file_of("contact"),
        uncertainty=file_of("uncertainty", earlier=True),
        statistics=file_of("statistics", earlier=True),
    output:
        uncertainty="results/{result}/uncertainty.nc",
        statistics=STATISTICS,
    log:
        "logs/{result}/statistics.log",
    wildcard_constraints:
        result=pattern_of("statistics"),
    resources:
        **resources_of("statistics"),
    params:
        **params_of("statistics"),


rule panel:
    """Draw the section of one result in the report: figures, checks, tables."""
    input:
        **PREPARED,
        sources=sources_of("panel"),
        contact=file_of("contact"),
        statistics="results/{result}/statistics.nc",
        courses=courses_of,
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


rule unload:
    """Take the load off: the surface that plastic flow has left, and the contact on the way back."""
    input:
        sources=sources_of("unload"),
        window=file_of("window"),
        contact=file_of("contact"),
    output:
        residual="results/{result}/residual.nc",
    log:
        "logs/{result}/unload.log",
    wildcard_constraints:
        result=pattern_of("unload"),
    priority: 1  # the panel waits for it
    conda:
        "../envs/roughcontact.yaml"
    threads: threads_of()
    resources:
        **resources_of("unload"),
    params:
        **params_of("unload"),
    script:
        "../scripts/unload.py"


# what follows the contact in a run: the surfaces that sliding against a smooth face leaves, and the friction of rubber
for RULE in ("wear", "slide"):

    rule:
        """Let a smooth face, or rubber, slide over the face: its contact over the distance, or over the speed."""
        name:
            RULE
        input:
            sources=sources_of(RULE),
            levelled=file_of("levelled"),
            window=file_of("window"),
            overview=file_of("overview"),
            contact=file_of("contact"),
        output:
            f"results/{{result}}/{STAGES[RULE][0]}.nc",
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
            "../scripts/course.py"


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
