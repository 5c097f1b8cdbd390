"""Solve, count, bound the error, draw: window.nc to contact.nc, uncertainty.nc, statistics.nc, panel.*."""

from _job import FILES, check_sources, link, progress, save, snakemake
from _preparing import prepare

from roughcontact import pipeline
from roughcontact.report.panel import write_panel
from roughcontact.results.storage import opened_dataset, read_dataset, written_load_by_load

link()
prepare()  # if this case has no job of its own for it

steps, of_step = snakemake.params.steps, snakemake.params.settings
settings = of_step["panel"]  # all sections
if "statistics" in steps:
    window = read_dataset(FILES["window"])["height"]
    solver = pipeline.solver_arguments(window, settings["contact"], threads=snakemake.threads)

for_budget = None
if "contact" in steps:
    shown = solver | {"progress": progress}
    path, own = FILES["contact"], of_step["contact"]
    if settings["contact"]["keep_fields"]:
        with written_load_by_load(path, pipeline.mean_pressures(window, solver), window) as file:
            solution, statistics_of_loads, for_budget = pipeline.solve_and_evaluate(
                window, settings, shown, store=file.keep
            )
            save(solution.assign(height=window), path, own, source=window.attrs, into=file)
    else:
        solution, statistics_of_loads, for_budget = pipeline.solve_and_evaluate(window, settings, shown)
        save(solution, path, own, source=window.attrs)
elif "statistics" in steps:
    with opened_dataset(FILES["contact"]) as contact:  # load by load: the maps are large
        statistics_of_loads = pipeline.statistics_of_settings(window, settings)(contact).load()

if "uncertainty" in steps:
    with opened_dataset(FILES["levelled"]) as levelled:  # read on demand, not beside the solution
        budget = pipeline.bound_error(levelled["height"], window, settings, solver, for_budget)
    save(budget, FILES["uncertainty"], of_step["uncertainty"], source=window.attrs)

if "statistics" in steps:
    budget = read_dataset(FILES["uncertainty"])
    statistics = pipeline.complete_statistics(
        statistics_of_loads, window, budget, settings, threads=snakemake.threads
    )
    save(statistics, FILES["statistics"], of_step["statistics"], source=window.attrs)
    del window, statistics_of_loads

drawn = ("height", "counter_face", "levelled", "window", "contact", "statistics")
write_panel(
    snakemake.output.panel,
    surface=snakemake.wildcards.surface,
    case=snakemake.wildcards.get("case"),
    settings=settings,
    **{name: FILES[name] for name in drawn if name in FILES},
)
check_sources()
