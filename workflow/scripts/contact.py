"""Solve, bound the error, evaluate: window.nc to contact.nc, uncertainty.nc, statistics.nc.

Of an earlier case with the same settings the solution, the error budget and the statistics are taken over.
"""

from _job import check_sources, earlier_cases, progress, remove_superseded, save, snakemake

from roughcontact.evaluation import pipeline
from roughcontact.evaluation.kinds import kind_of
from roughcontact.evaluation.kinds.periodic_map import SolvedMap
from roughcontact.results.storage import opened_dataset, read_dataset, written_load_by_load
from roughcontact.surface.faces.placing import separate_overviews

paths, output, recorded = snakemake.input, snakemake.output, snakemake.params.settings
settings, threads = recorded["statistics"], snakemake.threads
window = read_dataset(paths.window)["height"]
kind = kind_of(window, settings)
solver = kind.solver_arguments(window, settings, threads=threads)
statistics = for_budget = None
solution = paths.get("contact") or output.contact
if not paths.get("contact"):
    with_progress = solver | {"progress": progress}
    if settings["contact"]["keep_fields"]:
        with written_load_by_load(solution, solver[kind.facts.load], window) as file:
            result = pipeline.solve_and_evaluate(window, settings, with_progress, store=file.write_maps)
            fields = result.solution.assign(height=window)
            save(fields, solution, recorded["contact"], source=window.attrs, into=file)
    else:
        result = pipeline.solve_and_evaluate(window, settings, with_progress)
        save(result.solution, solution, recorded["contact"], source=window.attrs)
    statistics, for_budget = result.statistics, result.for_budget
elif not paths.statistics:
    with opened_dataset(solution) as contact:  # load by load: the maps are large
        statistics = pipeline.statistics_of_settings(window, settings)(contact).load()

overviews = separate_overviews(read_dataset(paths.overview)) if paths.overview else ()
with opened_dataset(paths.levelled) as levelled:  # read on demand, not beside the solution
    solved = SolvedMap(levelled["height"], window, settings, solver, for_budget, overviews)
    budget = read_dataset(paths.uncertainty) if paths.uncertainty else kind.budget(solved)
    save(budget, output.uncertainty, recorded["uncertainty"], source=window.attrs)
    if statistics is None:
        complete = read_dataset(paths.statistics)
    else:
        complete = pipeline.complete_statistics(statistics, window, budget, settings, solver)
        complete = pipeline.after_creep(complete, solved)
complete = complete.assign_attrs(earlier_cases())
save(complete, output.statistics, recorded["statistics"], source=window.attrs)
remove_superseded(output.statistics)
check_sources()
