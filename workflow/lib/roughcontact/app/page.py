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
    """The page of a study: `said` are the last words of its buttons."""

    def __init__(self) -> None:
        self.run = commands.Run()
        self.inspections: dict[str, dict] = {}
        self.said = dict.fromkeys(("add", "write", "command", "look"), "")
        self.revision = 0  # of the rows: their fields are made anew where not the user has changed them

    def first(self, name: str) -> str:
        """Return the page of the study folder, under a name; without one that of a study open elsewhere."""
        shown: dict[str, Any] = {"name": name, "config": {}, "rows": []}
        try:
            shown["config"], rows = study.read_folder()
            shown["rows"] = [(row, {}) for row in rows]  # the script asks for the rest at once
        except RoughContactError as error:
            shown["problem"] = str(error)
        return self.html(_SECTIONS if name else (), **shown)

    def after(self, action: str, form: QueryParams) -> str:
        """Return the page after the action of a button."""
        texts = dict(form.items()) | ({form["page.more"]: ""} if action == "more" else {})
        config = fields.grouped(texts)
        rows, ours = config.pop("rows", []), config.pop("page", {})
        chosen = {*map(int, form.getlist("page.selected"))}
        if action == "state":
            return self.html(("run",) if self.run.running() else ("run", "look"), ours=ours)
        if action == "add":
            paths = form.getlist("page.dropped") or [ours["path"]]
            rows, self.said["add"] = measurements.add(paths, rows)
        elif action == "set":
            cell = {ours["column"]: ours["cell"]}
            rows = [row | cell if number in chosen else row for number, row in enumerate(rows)]
        elif action == "remove":
            rows, chosen = [row for number, row in enumerate(rows) if number not in chosen], set()
        elif action == "all":
            chosen = {*range(len(rows))}
        elif action == "cancel":
            self.run.cancel()
        elif action == "export":
            words = [ours.get(name, "") for name in ("result", "form", "before")]
            self.said["command"], self.said["look"] = commands.export(*words)
        checked = study.check({name: texts[name] for name in texts if name.split(".")[0] in config}, rows)
        if action in ("write", "start"):
            if checked["mistakes"]:
                raise SettingsError("nothing is written: correct first what stands under 3 Write")
            self.said["write"] = study.write(checked["files"])
        if action == "start":
            self.run.start()
        self.revision += action in ("set", "remove", "all")
        shown = checked | {"config": config, "ours": ours, "chosen": chosen}
        shown["rows"] = measurements.inspected(rows, self.inspections, patience=_PATIENCE)
        sections = _SECTIONS[1:] if action == "check" else _SECTIONS  # what has gone wrong stays
        return self.html(sections, **shown)

    def html(self, sections: Sequence[str], **context: Any) -> str:
        """Return sections of the page."""
        shown: dict[str, Any] = {"files": {}, "mistakes": {}, "bodies": [], "ours": {}, "chosen": ()}
        shown |= {"name": "", "problem": "", "sections": sections, "folder": Path.cwd()}
        shown["in_terminal"] = shlex.join(["cd", str(Path.cwd())])
        return _TEMPLATE.render(_SHARED | vars(self) | shown | {"run": self.run.state()} | context)
