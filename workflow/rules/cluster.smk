# On a cluster all jobs of a surface are one job (group "surface"), and several small surfaces are one (group
# "small_surfaces", as many as --group-components says). Snakemake would give up the whole group with its first job that
# fails, and take away what the others have written. Here those go on (--keep-going inside the group), what they have
# written stays (--keep-incomplete: every file is whole or is not there), and the next attempt has only the rest to do.
import logging
import os

BEGUN = set()  # numbers of the jobs that were handed to the cluster


class Groups(logging.Filter):
    """Follow the run: its settings are known when it begins, what it hands over when it says so."""

    def filter(self, record):
        event = getattr(record, "event", None)
        if event == "workflow_started" and not workflow.is_main_process:
            in_a_group()
        elif (
            event == "workflow_started" and not workflow.group_settings.group_components
        ):
            for each in filter(ours, workflow.rules):
                each.group = None  # groups cost a plan time, where there is no cluster
        elif event == "job_info" and keeps_files() and record.jobid not in BEGUN:
            job = job_of(record.jobid)
            if ours(job.rule):
                BEGUN.add(record.jobid)
                without_the_last(job)
        return True


def ours(rule):
    """Return whether a rule is of this workflow, which may be a module of another one."""
    return str(rule.basedir) == str(HERE)


def in_a_group():
    """Let a Snakemake that a cluster has started take its jobs independently of one another, and only those left."""
    asked = workflow.dag_settings.target_jobs
    rules_asked = [workflow.get_rule(each.rulename) for each in asked]
    if not all(map(ours, rules_asked)):
        return
    workflow.execution_settings.keep_going = True
    # all that were handed over together, whatever their number
    workflow.group_settings.group_components = {"small_surfaces": 10**6}
    # no more at once than were asked for: not every cluster keeps a job from the other cores of its node
    if cores := os.environ.get("SLURM_CPUS_PER_TASK"):
        workflow.global_resources["_cores"] = int(cores)
    if workflow.execution_settings.attempt > 1:
        left = [
            each
            for each, rule_asked in zip(asked, rules_asked)
            if not all(
                map(os.path.exists, rule_asked.expand_output(each.wildcards_dict)[0])
            )
        ]
        workflow.dag_settings.target_jobs = left or asked


def without_the_last(job):
    """Take away what earlier runs have left of a job that is handed to a cluster.

    Snakemake does so when a job begins. One that is killed before, with files that stay, would leave old ones as new.
    """
    for file in job.output:
        if os.path.isfile(file) or os.path.islink(file):
            os.unlink(file)


def keeps_files():
    """Return whether this run hands its jobs to a cluster, and what some of a failed group have written stays."""
    return (
        workflow.is_main_process
        and workflow.non_local_exec
        and workflow.execution_settings.keep_incomplete
    )


def is_done(job):
    """Return whether a job of a group that has failed has left all its files in this run."""
    return job.jobid in BEGUN and all(map(os.path.exists, job.output))


logging.getLogger("snakemake.logging").addFilter(Groups())
