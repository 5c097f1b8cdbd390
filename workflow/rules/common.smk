# Settings, table and plan of the run, and the functions of the wildcards that rules ask for. What they compute stands
# in roughcontact.configuration.plan, with its tests.
import json
import os
import subprocess
import sys
import time
from functools import cache
from pathlib import Path

from snakemake.io import contains_wildcard
from snakemake.logging import logger

from roughcontact.configuration.dependencies import source_digest
from roughcontact.configuration.generated import changed_settings
from roughcontact.configuration.places import check_places, left_over
from roughcontact.configuration.plan import Plan, one_of
from roughcontact.configuration.stages import settings_of
from roughcontact.configuration.study import read_study
from roughcontact.configuration.surfaces import find
from roughcontact.configuration.yaml_text import check_yaml
from roughcontact.errors import SettingsError
from roughcontact.garbage import collect_rarely
from roughcontact.io.checksums import checksum
from roughcontact.io.size import estimate_points

# a plan of thousands of jobs is millions of objects that stay
collect_rarely()

# Without --configfile: the configuration of the working directory, else the one that comes with the workflow.
# One file only, never two laid over each other, so that what a file says is all that is set.
DEFAULT = find("config/config.yaml", [".", ROOT])
ORIGIN, ELSEWHERE = "the settings", False
try:
    check_places(Path())
    # of another workflow, which has this one as a module, the files are its own
    if Path(workflow.basedir).resolve() in (
        ROOT.resolve(),
        ROOT.resolve() / "workflow",
    ):
        for file in filter(os.path.isfile, workflow.configfiles or [DEFAULT]):
            check_yaml(Path(file))
        # no job, here or on a cluster, takes for code what lies in the working folder
        os.environ.update(PYTHONSAFEPATH="1")
        ELSEWHERE = not (workflow.configfiles or os.path.isfile("config/config.yaml"))
        ORIGIN = ", ".join(map(str, workflow.configfiles or [DEFAULT]))
except SettingsError as error:
    # the sentences alone: a WorkflowError comes with lines of this file
    sys.exit(str(error))

if not workflow.configfiles:

    configfile: DEFAULT


# Relative paths: in the working directory, then beside the file that names them, then in this checkout.
FOLDERS = [".", *(Path(file).parent for file in workflow.configfiles[-1:]), ROOT]

try:
    PLAN = Plan(*read_study(config, FOLDERS, measured_in=[".", ROOT], origin=ORIGIN))
except SettingsError as error:
    sys.exit(str(error))

if ELSEWHERE:
    table = find(PLAN.common["surfaces"], FOLDERS)
    logger.info(
        f"There is no config/config.yaml here: settings of {DEFAULT}, surfaces of {table} "
        f"({len(PLAN.measured)} maps)."
    )
if left := left_over(PLAN.panel(*run) for run in PLAN.runs):
    logger.info(
        f"Not in the table: {', '.join(left[:5])}{' ...' if len(left) > 5 else ''}. They stay as an earlier run left "
        "them; report.html, summary.csv and statistics.nc are of the table alone."
    )

# what the command is told that makes the report of a run in which surfaces have failed
UNFINISHED = [sys.executable, "-m", "roughcontact.command_line.unfinished"]
STATED = json.dumps(
    {
        "config": config,
        "folders": [*map(str, FOLDERS)],
        "measured_in": [".", str(ROOT)],
    },
    default=str,
)
WITH_PACKAGE = {
    "PYTHONPATH": os.pathsep.join([str(ROOT / "workflow/lib"), *sys.path]),
    "PYTHONSAFEPATH": "1",
}


wildcard_constraints:
    surface=one_of(PLAN.names("single", "face", "member")),
    case="|".join(PLAN.cases),


@cache
def job(part, surface, case):
    """Return what a job computes, links and reads."""
    return PLAN.job(part, surface, case)


def files_of(part):
    """Return the input function of a job of the chain: its files by name.

    Files from outside are where they are: neither the prefix of a module nor a default storage is for them. Two kinds
    are left out, whose content counts all the same, by its checksum: those from the future, by a wrong clock, since
    every result would be older, and those with braces in their names, which Snakemake would take for wildcards.
    """

    def files(wildcards):
        asked = of(job, part)(wildcards)
        now = time.time()
        past = [path for path in asked.sources if os.path.getmtime(path) <= now]
        named = [path for path in past if not contains_wildcard(path)]
        return asked.inputs | {"sources": [local(path) for path in named]}

    return files


def place_in_table(wildcards, input):
    """Return path and place of a measured file, for messages: with `input`, so that another line reruns nothing."""
    file = PLAN.measured.get(wildcards.surface)
    return file and {"path": str(file.path), "origin": file.origin}


def of(function, *first, **named):
    """Return the function of the wildcards that asks the plan for a surface under a case."""
    return lambda wildcards: function(
        *first, wildcards.surface, wildcards.get("case", ""), **named
    )


def params_of(part):
    """Return the parameters of a job of the chain: an edit of what they say runs it again."""
    return {
        "steps": lambda wildcards: of(job, part)(wildcards).steps,
        "links": lambda wildcards: of(job, part)(wildcards).links,
        "settings": lambda wildcards: {
            step: of(PLAN.settings, "statistics" if step == "panel" else step)(
                wildcards
            )
            for step in of(job, part)(wildcards).steps
        },
        "file": place_in_table,
        "sources": lambda wildcards: {
            path: checksum(path) for path in of(job, part)(wildcards).sources
        },
        "code": code(part),
    }


def needs_of(part):
    """Return memory (MB) and run time (minutes) of a job of the chain, by the size of its map."""

    def mem_mb(wildcards, attempt):
        asked = of(PLAN.memory, part, points=points(wildcards.surface))(wildcards)
        return round(attempt * asked)

    def runtime(wildcards, attempt):
        asked = of(PLAN.minutes, part, points=points(wildcards.surface))(wildcards)
        return round(5 + attempt * asked)

    return {"mem_mb": mem_mb, "runtime": runtime}


@cache
def points(surface):
    """Return about how many points the measured map of a surface has, which is known before anything ran."""
    return estimate_points(PLAN.row(surface).path)


@cache
def code(script):
    """Return the checksum of the modules that a rule's script depends on."""
    return source_digest(ROOT / "workflow/scripts" / f"{script}.py")


def for_report(path, caption, category, **labels):
    """Return a file as an output that `snakemake --report` shows."""
    case = {"case": "{case}"} if "{case}" in path else {}
    return report(
        path,
        caption=f"../report/{caption}.rst",
        category=category,
        labels=case | labels,
    )


def outputs_of_groups():
    """Return the files of groups of maps, and of pairs of faces, by name."""
    files = {
        "groups": ("results/groups.nc", "netCDF", "answers of groups"),
        "groups_table": ("results/groups.csv", "table", "answers of groups"),
        "comparisons": ("results/comparisons.csv", "table", "differences of groups"),
    }
    return {
        name: for_report(
            path,
            "comparisons" if name == "comparisons" else "groups",
            "All surfaces",
            holds=holds,
            file=file,
        )
        for name, (path, file, holds) in files.items()
    }


def outputs_of(part, kind, **which):
    """Return the output files of a job of the chain, by name."""
    files = PLAN.outputs(part, kind, **which)
    shown = {
        "panel": {"holds": "figures and checks", "file": "page"},
        "statistics": {"holds": "all numbers", "file": "netCDF"},
    }
    return {
        name: (
            for_report(path, f"surface_{name}", "{surface}", **shown[name])
            if name in shown
            else path
        )
        for name, path in files.items()
    }
