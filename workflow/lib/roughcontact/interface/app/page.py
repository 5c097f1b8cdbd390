"""What each button of the page does, and the page after it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jinja2 import Template

from roughcontact.arguments import named_materials, rectangles, units
from roughcontact.arguments.settings import fields, generated, models, plausible
from roughcontact.errors import SettingsError
from roughcontact.interface.app import commands, jobs, measurements, study
from roughcontact.report.template import template
from roughcontact.statistics import outcome
from roughcontact.study.plan import Plan
from roughcontact.study.table import columns

FOLDER = Path(__file__).with_name("page")
_PAGE, _BAR, _COMPARED = (template(f"{name}.html", folder=FOLDER) for name in ("page", "bar", "compared"))
# what the templates read of the settings, the table and the results
_MODULES = (
    *(commands, fields, generated, jobs, models, named_materials, outcome, plausible, rectangles),
    *(columns, units),
)
_PICK = "page.pick."  # of a row that is ticked, its number
_OF_ROWS = ("add", "set", "remove", "undo", "all")
_PLAIN = ("check", "state", "look", "all")  # buttons that change neither settings nor table


class Page:
    """The page of a study: `messages` are what its buttons have done, `name` is that of the last one."""

    def __init__(self) -> None:
        self.name, self.is_open = "", False
        self.run, self.reader = commands.Run(), measurements.Reader()
        self.messages = {"add": "", "write": ""}
        self.plan: Plan | None = None  # of the form when it last had no mistakes
        self.revision = 0  # of the rows: their fields are made anew where not the user has changed them
        self.context: dict[str, Any] = {"config": {}, "table": [], "job": "", "files": {}, "mistakes": {}}
        self.context |= {"bodies": [], "form": {}, "chosen": {*()}}
        self.omitted: list[study.Row] = []  # rows that were left out last
        self.aside: dict[str, str] = {}  # loads of another question
        self.shown: tuple[object, ...] = ()  # the news when the page was last drawn
        self.is_unread = False  # whether files of the study could not be read

    def first(self, name: str) -> str:
        """Return the page of the study folder, under a name."""
        self.name, self.is_open = name, True
        try:
            self.context |= zip(("config", "table", "job"), study.read_folder(), strict=True)
            return self.html(problem="")  # the script asks for the rest at once
        except Exception as error:  # the files may be of anybody
            self.is_unread = True
            return self.html(problem=study.error_in_words(error))

    def with_bar(self, report: Path, home: str) -> str:
        """Return a page of the results below the bar of this one, which lies at `home`."""
        style = (FOLDER / "bar.css").read_text(encoding="utf-8")
        text = report.read_text(encoding="utf-8", errors="replace")
        # before all of the report, which may be of anybody: nothing in it is left open around the bar
        return f"<!DOCTYPE html><style>{style}</style>{self._filled(_BAR, home=home)}{text}"

    def compared(self, result: str) -> str:
        """Return the page of what a result may be compared with."""
        return self._filled(_COMPARED, result=result, names=commands.panels(self.plan))

    def after(self, action: str, form: Mapping[str, str]) -> str:
        """Return the page after the action of a button."""
        if action == "state":
            return self.html() if self.shown != self._news() else ""
        texts = {name: text for name, text in form.items() if not name.startswith("page.")}
        texts |= {form["page.more"]: ""} if action == "more" else {}
        job = form.get("page.job", self.context["job"])
        if job in jobs.JOBS and job != self.context["job"]:
            texts = jobs.texts_for(job, texts, self.aside)
        config = fields.grouped(texts)
        rows = config.pop("rows", [])
        chosen = {int(name.removeprefix(_PICK)) for name in form if name.startswith(_PICK)}
        rows, chosen = self._rows_after(action, form, rows, chosen)
        if action == "cancel":
            self.run.cancel()
        settings = {name: text for name, text in texts.items() if not name.startswith("rows.")}
        report = study.check(settings, rows, job=job)
        self.plan = report["plan"] or self.plan
        self.context = report | {"config": config, "table": rows, "job": job, "form": form, "chosen": chosen}
        if action not in _PLAIN:
            if len(report["files"]) < 2:
                raise SettingsError(f"nothing is saved: {next(iter(report['mistakes'].values()))[0]}")
            self.messages["write"] = study.write(report["files"], keep=self.is_unread)
            self.is_unread = False
        if action == "start":
            if report["mistakes"]:
                raise SettingsError("nothing is started: correct first what is listed under 4 Run")
            self.run.start()
        return self.html(**{} if action == "check" else {"problem": ""})  # what has gone wrong stays

    def _rows_after(
        self, action: str, form: Mapping[str, str], rows: list[study.Row], chosen: set[int]
    ) -> tuple[list[study.Row], set[int]]:
        """Return the rows, and the numbers of those that are ticked, after the action of a button."""
        self.revision += action in _OF_ROWS
        if action == "add":  # those that are new are ticked
            new, self.messages["add"] = measurements.further(form["page.path"].split("\n"), rows)
            return [*rows, *new], {*range(len(rows), len(rows) + len(new))}
        if action == "set":
            cell = {form["page.column"]: form["page.cell"]}
            return [row | cell if number in chosen else row for number, row in enumerate(rows)], chosen
        if action == "remove":
            self.omitted = [row for number, row in enumerate(rows) if number in chosen]
            self.messages["add"] = f"{len(self.omitted)} left out"
            return [row for number, row in enumerate(rows) if number not in chosen], {*()}
        if action == "undo":
            returned, self.omitted = self.omitted, []
            self.messages["add"] = f"{len(returned)} back"
            return [*rows, *returned], {*()}
        return rows, {*range(len(rows))} if action == "all" else chosen

    def html(self, **variables: Any) -> str:
        """Return the page."""
        self.shown = self._news()
        rows = self.reader.inspected(self.context["table"])
        return self._filled(_PAGE, rows=rows, screen=self.run.state(), **variables)

    def _news(self) -> tuple[object, ...]:
        """Return what changes without a button: files that are read, the screen of the run, its report."""
        reports = [path.stat().st_mtime_ns for path in commands.RESULTS.glob("report.html")]
        return self.reader.count(), self.run.state(), reports

    def _filled(self, template: Template, **variables: Any) -> str:
        """Return a template with what all of them may need."""
        modules = {module.__name__.rpartition(".")[2]: module for module in _MODULES}
        return template.render(modules | vars(self) | self.context | {"folder": Path.cwd()} | variables)
