"""What each button of the page does, and the page after it."""

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from starlette.datastructures import QueryParams

from roughcontact import named_materials
from roughcontact.app import commands, measurements, study
from roughcontact.configuration import fields, generated, models, surfaces
from roughcontact.errors import RoughContactError, SettingsError
from roughcontact.report.template import template
from roughcontact.statistics import outcome

FOLDER = Path(__file__).with_name("page")
_TEMPLATE = template("page.html", folder=FOLDER)
_MODULES = (commands, fields, generated, measurements, models, named_materials, outcome, surfaces)
_SHARED = {module.__name__.rpartition(".")[2]: module for module in _MODULES}
_SECTIONS = ("problem", "files", "bodies", "write", "run", "look")
_PATIENCE = 0.5  # s of an answer in which files are read; further ones are read in the next


class Page:
    """The page of a study: `messages` are what its buttons have done."""

    def __init__(self) -> None:
        self.run = commands.Run()
        self.inspections: dict[str, dict] = {}
        self.messages = dict.fromkeys(("add", "write", "command", "look"), "")
        self.of_study: list[str] | None = None  # names of results, where the form has no mistakes
        self.revision = 0  # of the rows: their fields are made anew where not the user has changed them

    def first(self, name: str) -> str:
        """Return the page of the study folder, under a name; without one that of a study open elsewhere."""
        context: dict[str, Any] = {"name": name, "config": {}, "rows": []}
        try:
            context["config"], rows = study.read_folder()
            context["rows"] = [(row, {}) for row in rows]  # the script asks for the rest at once
        except RoughContactError as error:
            context["problem"] = str(error)
        return self.html(_SECTIONS if name else (), **context)

    def after(self, action: str, form: QueryParams) -> str:
        """Return the page after the action of a button."""
        texts = dict(form.items()) | ({form["page.more"]: ""} if action == "more" else {})
        config = fields.grouped(texts)
        rows, controls = config.pop("rows", []), config.pop("page", {})
        chosen = {*map(int, form.getlist("page.selected"))}
        if action == "state":
            return self.html(("run",) if self.run.running() else ("run", "look"), controls=controls)
        if action == "add":
            paths = form.getlist("page.dropped") or [controls["path"]]
            rows, self.messages["add"] = measurements.add(paths, rows)
        elif action == "set":
            cell = {controls["column"]: controls["cell"]}
            rows = [row | cell if number in chosen else row for number, row in enumerate(rows)]
        elif action == "remove":
            rows, chosen = [row for number, row in enumerate(rows) if number not in chosen], set()
        elif action == "all":
            chosen = {*range(len(rows))}
        elif action == "cancel":
            self.run.cancel()
        elif action == "export":
            choices = [controls.get(name, "") for name in ("result", "form", "before")]
            self.messages["command"], self.messages["look"] = commands.export(*choices, names=self.of_study)
        checked = study.check({name: texts[name] for name in texts if name.split(".")[0] in config}, rows)
        self.of_study = checked["results"] or self.of_study
        if action in ("write", "start"):
            if checked["mistakes"]:
                raise SettingsError("nothing is written: correct first what stands under 3 Write")
            self.messages["write"] = study.write(checked["files"])
        if action == "start":
            self.run.start()
        self.revision += action in ("set", "remove", "all")
        context = checked | {"config": config, "controls": controls, "chosen": chosen}
        context["rows"] = measurements.inspected(rows, self.inspections, patience=_PATIENCE)
        sections = _SECTIONS[1:] if action == "check" else _SECTIONS  # what has gone wrong stays
        return self.html(sections, **context)

    def html(self, sections: Sequence[str], **variables: Any) -> str:
        """Return sections of the page."""
        defaults: dict[str, Any] = {"files": {}, "mistakes": {}, "bodies": [], "controls": {}, "chosen": ()}
        defaults |= {"name": "", "problem": "", "sections": sections, "folder": Path.cwd()}
        defaults["in_terminal"] = shlex.join(["cd", str(Path.cwd())])
        return _TEMPLATE.render(_SHARED | vars(self) | defaults | {"run": self.run.state()} | variables)
