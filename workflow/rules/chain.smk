# The chain: read, level, window in the job `prepare`; solve, count, draw in the job `contact`; the report of all.
# A pair of faces is prepared face by face, and then as each member, the ways in which its faces lie on one another.
from roughcontact.report import ONE_PAGE


rule prepare:
    """Read the measured file, level the map, cut out the periodic window."""
    input:
        unpack(files_of("prepare")),
    output:
        **outputs_of("prepare", "single"),
    log:
        f"{PLAN.logs}/prepare.log",
    wildcard_constraints:
        surface=one_of(PLAN.names("single")),
        case="|".join(PLAN.preparing),
    priority: 1  # before all others, so that every file that cannot be read is known soon
    conda:
        "../envs/roughcontact.yaml"
    resources:
        **needs_of("prepare"),
    params:
        **params_of("prepare"),
    script:
        "../scripts/prepare.py"


use rule prepare as prepare_face with:
    output:
        **outputs_of("prepare", "face"),
    wildcard_constraints:
        surface=one_of(PLAN.names("face")),
        case="|".join(PLAN.cases),


use rule prepare as prepare_member with:
    output:
        **outputs_of("prepare", "member"),
    wildcard_constraints:
        surface=one_of(PLAN.names("member")),
        case="|".join(PLAN.preparing),
    priority: 0


rule contact:
    """Bound the error, solve the contact for every load and count in it, draw the panel."""
    input:
        unpack(files_of("contact")),
    output:
        **outputs_of("contact", "single"),
    log:
        f"{PLAN.logs}/contact.log",
    wildcard_constraints:
        surface=one_of(PLAN.solved),
        case="|".join(PLAN.preparing),
    conda:
        "../envs/roughcontact.yaml"
    threads: lambda wildcards: PLAN.threads(wildcards.surface)
    resources:
        **needs_of("contact"),
    params:
        **params_of("contact"),
    script:
        "../scripts/contact.py"


# A case that reads nothing, and prepares nothing that another one takes, does all in one job.
use rule contact as contact_whole with:
    output:
        **outputs_of("contact", "single", whole=True),
    wildcard_constraints:
        surface=one_of(PLAN.names("single") if PLAN.following else []),
        case="|".join(PLAN.following),


use rule contact as contact_whole_member with:
    output:
        **outputs_of("contact", "member", whole=True),
    wildcard_constraints:
        surface=one_of(PLAN.names("member") if PLAN.following else []),
        case="|".join(PLAN.following),


rule report:
    """Put all surfaces into one dataset, one table, and one self-contained page."""
    input:
        statistics=[PLAN.file("statistics", *run) for run in PLAN.runs],
        panels=[PLAN.panel(*run) for run in PLAN.runs],
        # which are read beside the panels
        summaries=[PLAN.summary(*run) for run in PLAN.runs],
    output:
        **(
            {
                "pairs": for_report(
                    "results/pairs.csv",
                    "pairs",
                    "All surfaces",
                    holds="pairs of faces",
                    file="table",
                )
            }
            if PLAN.members
            else {}
        ),
        **(outputs_of_groups() if PLAN.groups or PLAN.same_places else {}),
        **({"pages": directory("results/pages")} if len(PLAN.runs) > ONE_PAGE else {}),
        statistics=for_report(
            "results/statistics.nc",
            "statistics",
            "All surfaces",
            holds="all numbers",
            file="netCDF",
        ),
        summary=for_report(
            "results/summary.csv",
            "summary",
            "All surfaces",
            holds="all numbers",
            file="table",
        ),
        budget=for_report(
            "results/uncertainty.csv",
            "uncertainty",
            "All surfaces",
            holds="components of every interval",
            file="table",
        ),
        page=for_report(
            "results/report.html",
            "page",
            "All surfaces",
            holds="figures, numbers, checks",
            file="page",
        ),
    log:
        "logs/report.log",
    conda:
        "../envs/roughcontact.yaml"
    resources:
        # each result takes 0.15 to 0.25 MB and 0.08 s
        mem_mb=lambda wildcards, attempt: round(attempt * (700 + len(PLAN.runs) / 2)),
        runtime=lambda wildcards, attempt: round(5 + attempt * len(PLAN.runs) / 300),
    params:
        runs=[list(run) for run in PLAN.runs],
        groups={name: [*group] for name, group in PLAN.groups.items()},
        same_places=[list(pair) for pair in PLAN.same_places],
        # of a function, in whose result braces stay
        title=lambda wildcards: PLAN.common["report"]["title"],
        settings=PLAN.all_settings(),
        changed={case: changed_settings(own) for case, own in PLAN.cases.items()},
        settings_of_statistics=PLAN.all_settings(
            lambda settings: settings_of(settings, "statistics")
        ),
        code=code("report"),
    script:
        "../scripts/report.py"
