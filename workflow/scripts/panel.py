"""Draw the section of one result in the report: all files of a result to panel.html, panel.json."""

from _job import result_of_job, snakemake

from roughcontact.report.panel import write_panel

paths = snakemake.input
case, _, surface = result_of_job().rpartition("/")
files = {
    name: paths[name] or None
    for name in ("height", "levelled", "window", "overview", "contact", "statistics")
}
write_panel(
    snakemake.output.panel,
    surface=surface,
    case=case or None,
    settings=snakemake.params.settings["statistics"],
    courses=paths.courses,
    counter_faces=[paths.counter_height] if paths.counter_height else [],
    **files,
)
