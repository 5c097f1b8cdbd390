"""Solve, bound the error, evaluate, draw: window.nc to contact.nc, uncertainty.nc, statistics.nc, panel.html.

Of an earlier case with the same settings the solution, the error budget and the statistics are taken over.
"""

from _job import check_sources, earlier_cases, progress, remove_superseded, result_of_job, save, snakemake

from roughcontact import pipeline
from roughcontact.report.panel import write_panel
from roughcontact.results.storage import opened_dataset, read_dataset, written_load_by_load

paths, output, recorded = snakemake.input, snakemake.output, snakemake.params.settings
settings, threads = recorded["statistics"], snakemake.threads
window = read_dataset(paths.window)["height"]
solver = pipeline.solver_arguments(window, settings, threads=threads)

statistics = for_budget = None
solution = paths.get("contact") or output.contact
if not paths.get("contact"):
    with_progress = solver | {"progress": progress}
    if settings["contact"]["keep_fields"]:
        with written_load_by_load(solution, pipeline.loads_of(solver), window) as file:
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

if paths.uncertainty:
    budget = read_dataset(paths.uncertainty)
else:
    with opened_dataset(paths.levelled) as levelled:  # read on demand, not beside the solution
        budget = pipeline.bound_error(levelled["height"], window, settings, solver, for_budget)
save(budget, output.uncertainty, recorded["uncertainty"], source=window.attrs)

if statistics is None:
    complete = read_dataset(paths.statistics)
else:
    budget = read_dataset(output.uncertainty)
    complete = pipeline.complete_statistics(statistics, window, budget, settings, threads=threads)
complete = complete.assign_attrs(earlier_cases())
save(complete, output.statistics, recorded["statistics"], source=window.attrs)
del window, statistics, complete, budget, for_budget

case, _, surface = result_of_job().rpartition("/")
drawn = {name: paths[name] for name in ("height", "levelled", "window")}
drawn |= {"contact": solution, "statistics": output.statistics, "counter_face": paths.counter_height or None}
remove_superseded(output.statistics)
write_panel(output.panel, surface=surface, case=case or None, settings=settings, **drawn)
check_sources()
