"""What each button of the page does, and the page after it."""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from starlette.datastructures import QueryParams

from roughcontact.arguments import named_materials
from roughcontact.arguments.settings import fields, generated, models
from roughcontact.errors import SettingsError
from roughcontact.interface.app import commands, jobs, measurements, study
from roughcontact.report.template import template
from roughcontact.statistics import outcome
from roughcontact.study import surfaces

FOLDER = Path(__file__).with_name("page")
_TEMPLATE = template("page.html", folder=FOLDER)
# what the templates read of the settings, the table and the results
_SHARED = {
    module.__name__.rpartition(".")[2]: module for module in (commands, fields, generated, jobs, measurements)
}
_SHARED |= {
    module.__name__.rpartition(".")[2]: module for module in (models, named_materials, outcome, surfaces)
}
_SECTIONS = ("problem", "question", "files", "fields", "run", "look")
_PLAIN = ("check", "state", "export", "look", "all")  # buttons that change neither settings nor table


class Page:
    """The page of a study: `messages` are what its buttons have done."""

    def __init__(self) -> None:
        self.run, self.reader = commands.Run(), measurements.Reader()
        self.messages = dict.fromkeys(("add", "write", "command", "look"), "")
        self.of_study: dict[str, Any] | None = None  # settings of results, where the form has no mistakes
        self.revision = 0  # of the rows: their fields are made anew where not the user has changed them
        self.context: dict[str, Any] = {"config": {}, "table": [], "job": ""}
        self.omitted: list[study.Row] = []  # rows that were left out last
        self.aside: dict[str, str] = {}  # loads of another question
        self.files_read = 0  # when the table was drawn
        self.is_unread = False  # whether files of the study could not be read

    def first(self, name: str) -> str:
        """Return the page of the study folder, under a name; without one that of a study open elsewhere."""
        sections = _SECTIONS if name else ()
        try:
            config, rows, job = study.read_folder()
            self.context = {"config": config, "table": rows, "job": job}
            return self.html(sections, name=name)  # the script asks for the rest at once
        except Exception as error:  # the files may be of anybody
            self.is_unread = True
            return self.html(sections, name=name, problem=study.error_in_words(error))

    def after(self, action: str, form: QueryParams) -> str:
        """Return the page after the action of a button."""
        if action == "state":
            is_new = self.reader.count != self.files_read
            return self.html(["files"] * is_new + ["run"] + ["look"] * (not self.run.running()))
        texts = dict(form.items()) | ({form["page.more"]: ""} if action == "more" else {})
        controls = fields.grouped(texts).get("page", {})
        job = controls.get("job", self.context["job"])
        if job in jobs.JOBS and job != self.context["job"]:
            texts = jobs.texts_for(job, texts, self.aside, former=self.context["job"])
        config = fields.grouped(texts)
        rows, chosen = config.pop("rows", []), {*map(int, form.getlist("page.selected"))}
        config.pop("page", None)
        self.revision += action in ("set", "remove", "undo", "all")
        if action == "add":
            paths = form.getlist("page.dropped") or [controls["path"]]
            rows, self.messages["add"] = measurements.add(paths, rows)
        elif action == "set":
            cell = {controls["column"]: controls["cell"]}
            rows = [row | cell if number in chosen else row for number, row in enumerate(rows)]
        elif action in ("remove", "undo"):
            rows, chosen = self._leave_out(rows, chosen if action == "remove" else None), set()
        elif action == "all":
            chosen = {*range(len(rows))}
        elif action == "cancel":
            self.run.cancel()
        elif action == "export":
            choices = [controls.get(name, "") for name in ("result", "form", "before")]
            self.messages["command"], self.messages["look"] = commands.export(*choices, names=self.of_study)
        settings = {name: texts[name] for name in texts if name.split(".")[0] in config}
        report = study.check(settings, rows, job=job)
        self.of_study = report["results"] or self.of_study
        self.context = report | {"config": config, "table": rows, "job": job}
        self.context |= {"controls": controls, "chosen": chosen}
        if action not in _PLAIN:
            if len(report["files"]) < 2:
                raise SettingsError(f"nothing is saved: {next(iter(report['mistakes'].values()))[0]}")
            self.messages["write"] = study.write(report["files"], keep=self.is_unread)
            self.is_unread = False
        if action == "start":
            if report["mistakes"]:
                raise SettingsError("nothing is started: correct first what is listed under 4 Run")
            self.run.start()
        return self.html(_SECTIONS[1:] if action == "check" else _SECTIONS)  # what has gone wrong stays

    def _leave_out(self, rows: list[study.Row], chosen: set[int] | None) -> list[study.Row]:
        """Return rows without those that are chosen; where that is None, with those left out last."""
        if chosen is not None:
            self.omitted = [row for number, row in enumerate(rows) if number in chosen]
            self.messages["add"] = f"{len(chosen)} left out"
            return [row for number, row in enumerate(rows) if number not in chosen]
        returned, self.omitted, self.messages["add"] = self.omitted, [], f"{len(self.omitted)} back"
        return [*rows, *returned]

    def html(self, sections: Sequence[str], **variables: Any) -> str:
        """Return sections of the page."""
        defaults: dict[str, Any] = {"files": {}, "mistakes": {}, "bodies": [], "controls": {}, "chosen": ()}
        defaults |= {"name": "", "problem": "", "sections": sections, "folder": Path.cwd()}
        defaults["in_terminal"] = shlex.join(["cd", str(Path.cwd())])
        context = _SHARED | vars(self) | defaults | {"screen": self.run.state()} | self.context
        if "files" in sections:
            self.files_read = self.reader.count
            context["rows"] = self.reader.inspected(self.context["table"])
        return _TEMPLATE.render(context | variables)
