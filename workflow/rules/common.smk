# Settings, table and plan of the run, and what the rules ask for; roughcontact.study.rule_arguments computes it.
import gc
import os
from functools import cache, partial

from snakemake.io import IOFile
from snakemake.logging import logger

from roughcontact.study.failures import start_partial_report
from roughcontact.study.records import (
    LAST_RESULTS,
    files_of_run,
    note_results,
    replaced_files,
)
from roughcontact.study.rule_arguments import RuleArguments
from roughcontact.study.places import check_places, find_file, stale_results
from roughcontact.study.plan import STAGES, Plan
from roughcontact.study.study import read_study
from roughcontact.study.yaml_text import check_yaml
from roughcontact.errors import SettingsError
from roughcontact.io.guards import listed
from roughcontact.study.notes import write_notes
from roughcontact.study.garbage import collect_rarely

# a plan of thousands of jobs is millions of objects that stay: no garbage is looked for until it is complete (onstart)
collect_rarely()
gc.disable()

# Without --configfile: the configuration of the working directory, else the one that comes with the workflow.
# One file only, never two laid over each other, so that what a file says is all that is set.
DEFAULT = find_file("config/config.yaml", [".", ROOT])
# as Snakemake has made them absolute, before it changed to --directory. Its documentation names no way to learn which
# files the configuration comes from; messages, checks of the YAML and paths relative to these files need it.
STATED = workflow.configfiles
# Relative paths: in the working directory, then beside the file that names them, then in this checkout.
FOLDERS = [".", *(Path(file).parent for file in STATED[-1:]), ROOT]
# of another workflow, which has this one as a module, the files are its own
IS_MODULE = Path(workflow.basedir).resolve() not in (
    ROOT.resolve(),
    ROOT.resolve() / "workflow",
)
# what --config states is laid over the configuration of the working directory
HAS_OWN = os.path.isfile("config/config.yaml") and not IS_MODULE
DEFAULTS = not STATED and (HAS_OWN or not {"surfaces", "contact"} & set(config))
ORIGIN = "the settings"
try:
    check_places(Path())
    if not IS_MODULE:
        for file in STATED or [DEFAULT]:
            check_yaml(Path(file))
        # no job, here or on a cluster, takes for code what lies in the working folder
        os.environ.update(PYTHONSAFEPATH="1")
        ORIGIN = ", ".join(map(str, STATED or [DEFAULT]))
except SettingsError as error:
    # the sentences alone: a WorkflowError comes with lines of this file
    sys.exit(str(error))

if DEFAULTS:

    configfile: DEFAULT


try:
    PLAN = Plan(*read_study(config, FOLDERS, measured_in=[".", ROOT], origin=ORIGIN))
except SettingsError as error:
    sys.exit(str(error))
ARGUMENTS = RuleArguments(PLAN, ROOT / "workflow/scripts")
pattern_of, file_of, params_of = PLAN.pattern, ARGUMENTS.file_of, ARGUMENTS.params_of
resources_of, threads_of = ARGUMENTS.resources_of, ARGUMENTS.threads_of
# jobs run without the note
REPLACED = replaced_files() if workflow.is_main_process else []


@cache
def distrust_files():
    """Have made again what the last run has not left, or Snakemake has no record of, as after a power failure.

    It is told so as it tells itself of incomplete files, while it builds the graph: no option says this.
    """
    if not workflow.is_main_process:  # but a job of it
        return
    recorded, files = workflow.persistence.metadata, files_of_run(PLAN)
    files = filter(os.path.isfile, (f"{PREFIX}{path}" for path in files))
    unknown = [path for path in files if recorded(IOFile(path)) is None]
    if unknown:
        logger.info(f"Without a record of Snakemake, made again: {listed(unknown)}")
    workflow.dag.forcefiles.update(REPLACED, unknown)


sources_of = partial(ARGUMENTS.sources_of, local=local, before=distrust_files)

if DEFAULTS and not os.path.isfile("config/config.yaml"):
    table = find_file(PLAN.common["surfaces"], FOLDERS)
    logger.info(
        f"There is no config/config.yaml here: settings of {DEFAULT}, surfaces of {table} "
        f"({len(PLAN.measured)} maps)."
    )
if REPLACED:
    logger.info(f"Not left by the last run here, made again: {listed(REPLACED)}")
if stale := stale_results(PLAN.results):
    logger.info(
        f"Not in the table: {', '.join(stale[:5])}{' ...' if len(stale) > 5 else ''}. They stay as an earlier run left "
        "them; report.html, summary.csv and statistics.nc are of the table alone."
    )


def courses_of(wildcards):
    """Return the files of unloading, wear and sliding of a result."""
    return PLAN.further_files(wildcards.result)


def shown(path, caption, holds):
    """Return a file as an output that `snakemake --report` shows."""
    category = "{result}" if "{result}" in path else "All surfaces"
    file = {"html": "page", "csv": "table", "nc": "netCDF"}[path.rpartition(".")[2]]
    return report(
        path,
        caption=f"../report/{caption}.rst",
        category=category,
        labels={"holds": holds, "file": file},
    )
