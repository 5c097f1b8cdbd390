import inspect
import os
import re
import sys
import time
from functools import cache
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.sourcecache import LocalSourceFile

# the folder of this file, also where another workflow imports this one: workflow/rules of a checkout, or on a host
HERE = workflow.current_basedir


def installed():
    """Fetch this workflow, and return the folder of the installed package that stands for its checkout.

    Snakemake fetches file by file, which a package cannot be: that which is installed must be of the same commit.
    """
    host = getattr(HERE, "host", None)
    source = f" @ git+https://{host}/{HERE.repo}@{HERE.ref}" if host else ""
    command = f"pip install 'roughcontact[workflow]{source}'"
    try:
        from roughcontact import __version__
        from roughcontact.command_line.running import workflow_file
    except ImportError:
        sys.exit(f"{HERE}: needs the package, which is not installed: {command}")
    folder = workflow_file().parent
    for path in sorted([*folder.glob("rules/*.smk"), *folder.glob("scripts/*.py")]):
        # a script finds the others that it imports where all of them were fetched to
        try:
            fetched = workflow.source_path(f"../{path.relative_to(folder).as_posix()}")
            text = Path(fetched).read_text("utf-8")
        except WorkflowError:
            text = ""
        if text.strip() != path.read_text("utf-8").strip():
            sys.exit(
                f"{HERE}: is another version than roughcontact {__version__}, which is installed "
                f"({path.name} differs): {command}"
            )
    return folder.parent


if isinstance(HERE, LocalSourceFile):
    ROOT = Path(HERE).parents[1]
    sys.path.insert(0, str(ROOT / "workflow/lib"))
else:
    ROOT = installed()

from roughcontact.errors import SettingsError
from roughcontact.configuration.dependencies import PACKAGE, source_digest
from roughcontact.configuration.stages import SECTIONS, STEPS, owner, settings_of
from roughcontact.configuration.study import read_study
from roughcontact.configuration.surfaces import find, measured, members
from roughcontact.garbage import collect_rarely
from roughcontact.io.size import estimate_points

# a plan of thousands of jobs is millions of objects that stay
collect_rarely()

# Without --configfile: the configuration of the working directory, else the one that comes with the workflow.
# One file only, never two laid over each other, so that what a file says is all that is set.
if not workflow.configfiles:

    configfile: find("config/config.yaml", [".", ROOT])


# Relative paths: in the working directory, then beside the file that names them, then in this checkout.
FOLDERS = (
    [".", Path(workflow.configfiles[-1]).parent, ROOT]
    if workflow.configfiles
    else [".", ROOT]
)

try:
    # without cases: {"": settings}
    CASES, TABLE = read_study(config, FOLDERS, measured_in=[".", ROOT])
    COMPOSITE = CASES[next(iter(CASES))]["composite"]  # the same for all cases
    # what is measured, and the ways in which the faces of each pair lie on one another
    MEASURED = measured(TABLE)
    MEMBERS = members(TABLE, COMPOSITE["shifts"] * len(COMPOSITE["rotations"]))
except SettingsError as error:
    # the sentences alone: a WorkflowError comes with lines of this file
    sys.exit(str(error))

STUDY = "" not in CASES
TOGETHER = CASES[next(iter(CASES))]["together"]  # the same for all cases
CROSSCHECK = CASES[next(iter(CASES))]["crosscheck"]  # the same for all cases
FOLDER = "results/{case}/{surface}" if STUDY else "results/{surface}"
LOGS = FOLDER.replace("results", "logs", 1)
# stage -> case -> the case that computes it
OWNERS = {
    stage: {case: owner(CASES, case, stage) for case in CASES} for stage in SECTIONS
}
# what is solved, in the order of the table
SOLVED = [
    surface
    for row in TABLE
    for surface in (
        [row]
        if row in MEASURED
        else [name for name, member in MEMBERS.items() if member.pair == row]
    )
]
RUNS = [
    {"surface": surface, "case": case} if STUDY else {"surface": surface}
    for case in CASES
    for surface in SOLVED
]


def called_often(function):
    """Return a function of the wildcards that keeps its signature, which Snakemake looks at before every call."""
    function.__signature__ = inspect.signature(function)
    return function


@cache
def megabytes(path):
    """Return the size of a measured file in MB, 0 where there is none."""
    return os.path.getsize(path) / 1e6 if os.path.exists(path) else 0


def row(surface):
    """Return the row of the table that a surface comes from."""
    return TABLE[MEMBERS[surface].pair] if surface in MEMBERS else MEASURED[surface]


# Small maps go through several stages in one job, the others have a job for each stage.
SMALL = {name for name in [*MEASURED, *MEMBERS] if megabytes(row(name).path) < TOGETHER}
# What each case shares with another one is a link into that case's folder, so that every folder is complete.
SHARED = {
    case: {
        stage: OWNERS[stage][case] for stage in SECTIONS if OWNERS[stage][case] != case
    }
    for case in CASES
}
# Which stages the measured faces of a pair, its members, and single surfaces have.
STAGES = {
    "": ([name for name in SOLVED if name in MEASURED], list(SECTIONS)),
    "_faces": (
        [name for name in MEASURED if name not in SOLVED],
        ["height", "levelled"],
    ),
    "_members": (list(MEMBERS), list(SECTIONS)[1:]),
}


def one_of(names):
    """Return the pattern of some names, letter by letter: thousands of them one after another take long to match."""
    branches = {}
    for name in names:
        branches.setdefault(name[:1], []).append(name[1:])
    may_end = branches.pop("", None)
    each = [re.escape(letter) + one_of(rests) for letter, rests in branches.items()]
    pattern = "|".join(each)
    return (
        f"(?:{pattern})" + "?" * bool(may_end)
        if len(each) > 1 or (each and may_end)
        else pattern
    )


wildcard_constraints:
    surface=one_of([*MEASURED, *MEMBERS]),
    case="|".join(CASES),


def stagewise(names):
    """Return the constraint on `surface` that admits those of `names` that have a job for each stage."""
    return one_of(name for name in names if name not in SMALL) or "(?!)"


def owners(stage, **wanted):
    """Return the constraint on `case` that admits the cases which compute `stage` themselves."""
    return "|".join(
        case
        for case in CASES
        if OWNERS[stage][case] == case
        and wanted.items() <= CASES[case]["contact"].items()
    )


def stage_file(stage, side="face"):
    """Return the input function that finds `stage` in the folder of the case which computes it.

    What was measured of a member of a pair is in the folder of its face (or its counter-face, as `side` says).
    """

    def path(wildcards):
        case, surface = OWNERS[stage][wildcards.get("case", "")], wildcards["surface"]
        if stage == "height" and surface in MEMBERS:
            surface = getattr(MEMBERS[surface], side)
        return f"{FOLDER}/{stage}.nc".format(case=case, surface=surface)

    return path


def levelled_faces(wildcards):
    """Return the levelled maps of the two faces of a member of a pair."""
    member, levelled = MEMBERS[wildcards.surface], stage_file("levelled")
    sides = (member.face, member.counter_face)
    return [levelled({**dict(wildcards), "surface": side}) for side in sides]


def counter_face(wildcards):
    """Return the measured counter-face; none where there is a single face."""
    return (
        stage_file("height", "counter_face")(wildcards)
        if wildcards.surface in MEMBERS
        else []
    )


# what the report of Snakemake shows of each surface
SHOWN = {
    "panel": ("html", "figures and checks", "page"),
    "statistics": ("nc", "all numbers", "netCDF"),
}


def shown(name):
    """Return a file of a surface as an output that `snakemake --report` shows, under the surface's name."""
    ending, holds, kind = SHOWN[name]
    return report(
        f"{FOLDER}/{name}.{ending}",
        caption=f"../report/surface_{name}.rst",
        category="{surface}",
        labels={
            **({"case": "{case}"} if STUDY else {}),
            "holds": holds,
            "file": kind,
        },
    )


def stage_settings(stage):
    """Return the parameter function that gives all the settings on which `stage` depends."""

    def settings(wildcards):
        name = wildcards.surface
        if name in MEMBERS:
            surface = {**vars(MEMBERS[name]), "composite": COMPOSITE}
        else:
            surface = MEASURED[name].given
        return {
            "surface": {"name": name, **surface},
            **settings_of(CASES[wildcards.get("case", "")], stage),
        }

    return settings


def run_settings(part=dict):
    """Return the settings of the whole run: of each case, where there are cases."""
    return (
        {case: part(settings) for case, settings in CASES.items()}
        if STUDY
        else part(CASES[""])
    )


@cache
def code(script):
    """Return the checksum of the modules that a rule's script depends on."""
    return source_digest(ROOT / "workflow/scripts" / f"{script}.py")


def points(wildcards):
    """Return about how many points the measured map of a surface has, which is known before anything ran."""
    return points_in(row(wildcards.surface).path)


@cache
def points_in(path):
    """Return about how many points a measured file holds."""
    return estimate_points(path)


def loads(wildcards):
    """Return how many loads are solved; a plan that is made for the map has about ten."""
    contact = CASES[wildcards.get("case", "")]["contact"]
    return len(contact["mean_pressure"] or contact["relative_pressure"] or range(10))


# MB: a script and, on a cluster, the two Snakemakes that start it
BASE_MEMORY = 700


def reading_memory(path):
    """Return the memory (MB) for the content of a measured file: arrays of NumPy lie plain, others may be packed."""
    return (10 if str(path).endswith(".npy") else 50) * megabytes(path)


def flows(wildcards):
    """Return whether the flow through the gap is solved for, however large the map."""
    asked = CASES[wildcards.get("case", "")]["statistics"]
    return asked["flow"] == "always" or (
        asked["flow"] == "auto" and bool(asked["seal"])
    )


def memory(*, bytes_per_point, and_load=0, and_flow=0, up_to_a_million=0):
    """Return the resource function that estimates memory (MB): a running Python, and so much for every point.

    `up_to_a_million` is for each of the first million points, of what does not grow with larger maps.
    """

    @called_often
    def estimate(wildcards, attempt):
        each = bytes_per_point + and_load * loads(wildcards)
        each += and_flow if flows(wildcards) else 0
        millions = points(wildcards) / 1e6
        needed = each * millions + up_to_a_million * min(millions, 1)
        return round(attempt * (BASE_MEMORY + needed))

    return estimate


def minutes(*, microseconds_per_point, and_load=0):
    """Return the resource function that estimates the run time (minutes): a start, and so much for every point."""

    @called_often
    def estimate(wildcards, attempt):
        each = microseconds_per_point + and_load * loads(wildcards)
        return round(5 + attempt * each * points(wildcards) / 60e6)

    return estimate


def memory_of_all(wildcards, attempt):
    """Return the memory (MB) of a job on the results of all surfaces, each of which takes 0.15 to 0.25 MB."""
    return round(attempt * (BASE_MEMORY + 0.5 * len(RUNS)))


def minutes_of_all(wildcards, attempt):
    """Return the run time (minutes) of a job on the results of all surfaces, each of which takes 0.04 s."""
    return round(5 + attempt * len(RUNS) / 600)


def measured_file(wildcards):
    """Return the measured file; none where it is from the future, which every result would be older than.

    It is where it is: neither the prefix of a module nor a default storage is for it.
    """
    path = MEASURED[wildcards.surface].path
    return [] if from_the_future(wildcards) else local(str(path))


@called_often
def from_the_future(wildcards):
    """Return the time of a measured file that is later than now, by a wrong clock; None for all others.

    As a parameter it shows an edit of such a file.
    """
    if wildcards.surface in MEMBERS:
        return None
    changed = os.path.getmtime(MEASURED[wildcards.surface].path)
    return changed if changed > time.time() else None


@called_often
def place_in_table(wildcards, input):
    """Return path and place of a measured file, for messages: with `input`, so that another line reruns nothing."""
    if wildcards.surface in MEMBERS:
        return None
    file = MEASURED[wildcards.surface]
    return {"path": str(file.path), "origin": file.origin}


def solver_threads(wildcards):
    """Return the threads of the solver: one for small maps, where jobs run side by side instead.

    Depends on the measured file alone: sums over the grid are rounded by the number of threads, and so a run
    comes out the same wherever there are as many cores.
    """
    return 1 if megabytes(row(wildcards.surface).path) < 4 else 4


def crosscheck_file(wildcards):
    """Return the file of the cross-check; none where there is no other code."""
    file = f"{FOLDER}/crosscheck.nc".format(**wildcards)
    return [] if CROSSCHECK["code"] == "none" else file
