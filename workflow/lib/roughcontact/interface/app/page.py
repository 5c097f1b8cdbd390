"""What each button of the page does, and the page after it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from roughcontact.arguments import named_materials, rectangles, units
from roughcontact.arguments.settings import fields, generated, models, plausible
from roughcontact.errors import SettingsError
from roughcontact.interface.app import commands, measurements, study
from roughcontact.report.template import template
from roughcontact.statistics import outcome
from roughcontact.study.table import columns

# what the templates read of the settings, the table and the results
_MODULES = (
    *(commands, fields, generated, models, named_materials, outcome, plausible, rectangles),
    *(columns, study, units),
)
_OF_ROWS = ("add", "set", "remove", "undo", "all")  # buttons that change what the rows hold
_PLAIN = ("check", "look", "all")  # buttons that change neither settings nor table


class Page:
    """The page of a study: `messages` are what its buttons have done, `name` is that of the last one."""

    def __init__(self) -> None:
        self.name, self.is_open = "", False
        self.is_unread = False  # whether files of the study could not be read
        self.run, self.reader = commands.Run(), measurements.Reader()
        self.messages = {"add": "", "write": ""}
        self.revision = 0  # of the rows: their fields are made anew where not the user has changed them
        self.context: dict[str, Any] = {"config": {}, "table": [], "job": "", "form": {}, "plan": None}
        self.omitted: list[study.Row] = []  # rows that were left out last
        self.aside: dict[str, str] = {}  # loads of another question
        self.shown: tuple[object, ...] = ()  # the news when the page was last drawn

    def first(self, name: str) -> str:
        """Return the page of the study folder, under a name."""
        self.name, self.is_open, problem = name, True, ""
        try:
            self.context |= zip(("config", "table", "job"), study.read_folder(), strict=True)
        except Exception as error:  # the files may be of anybody
            self.is_unread, problem = True, study.error_in_words(error)
        self.context |= study.check()
        return self.html(problem=problem)

    def with_bar(self, report: Path, home: str) -> str:
        """Return a page of the results below the bar of this one, which lies at `home`."""
        # before all of the report, which may be of anybody: nothing in it is left open around the bar
        return self.filled("bar", home=home) + report.read_text(encoding="utf-8", errors="replace")

    def after(self, action: str, form: Mapping[str, str]) -> str:
        """Return the page after the action of a button."""
        if action == "state":
            return self.html() if self.shown != self._news() else ""
        texts = {name: text for name, text in form.items() if not name.startswith("page.")}
        texts |= {form["page.more"]: ""} if action == "more" else {}
        job = form.get("page.job", self.context["job"])
        if job in study.JOBS and job != self.context["job"]:
            texts = study.texts_for(job, texts, self.aside)
        config = fields.grouped(texts)
        rows = self._rows_after(action, form, config.pop("rows", []))
        if action == "cancel":
            self.run.cancel()
        elif action not in _PLAIN:
            settings = {name: text for name, text in texts.items() if not name.startswith("rows.")}
            self.messages["write"] = study.save(settings, rows, job=job, keep=self.is_unread)
            self.is_unread = False
        self.context |= {"config": config, "table": rows, "job": job, "form": form} | study.check()
        if action == "start":
            if self.context["mistakes"]:
                raise SettingsError("nothing is started: correct first what is listed under 4 Run")
            self.run.start()
        return self.html(problem="")

    def _rows_after(self, action: str, form: Mapping[str, str], rows: list[study.Row]) -> list[study.Row]:
        """Return the rows after the action of a button."""
        self.revision += action in _OF_ROWS
        ticked_rows = [row for row in rows if study.TICKED in row]
        if action == "add":
            new, self.messages["add"] = measurements.further(form["page.path"].split("\n"), rows)
            unticked_rows = [{name: row[name] for name in row if name != study.TICKED} for row in rows]
            return [*unticked_rows, *({**row, study.TICKED: "on"} for row in new)]
        if action == "set":
            cell = {form["page.column"]: form["page.cell"]}
            return [row | cell if row in ticked_rows else row for row in rows]
        if action == "remove":
            self.omitted, self.messages["add"] = ticked_rows, f"{len(ticked_rows)} left out"
            return [row for row in rows if row not in ticked_rows]
        if action == "undo":
            returned, self.omitted = self.omitted, []
            self.messages["add"] = f"{len(returned)} back"
            return [*rows, *returned]
        return [row | {study.TICKED: "on"} for row in rows] if action == "all" else rows

    def html(self, **variables: Any) -> str:
        """Return the page."""
        self.shown = self._news()
        rows = self.reader.inspected(self.context["table"])
        return self.filled("page", rows=rows, screen=self.run.state(), **variables)

    def _news(self) -> tuple[object, ...]:
        """Return what changes without a button: files that are read, the screen of the run, its report."""
        reports = [path.stat().st_mtime_ns for path in commands.RESULTS.glob("report.html")]
        read = sum(reading.done() for reading in self.reader.readings.values())
        return read, self.run.state(), reports

    def filled(self, name: str, **variables: Any) -> str:
        """Return one of the templates, with what all of them may need and variables of its own."""
        modules = {module.__name__.rpartition(".")[2]: module for module in _MODULES}
        values = modules | vars(self) | self.context | {"folder": Path.cwd()} | variables
        return template(f"{name}.html", folder=study.FOLDER).render(values)
