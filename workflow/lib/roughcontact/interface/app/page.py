"""What each change of a field and each button does, and the page after it."""

from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

from roughcontact.arguments import named_materials, rectangles, units
from roughcontact.arguments.settings import fields, generated, models, plausible
from roughcontact.errors import SettingsError
from roughcontact.interface.app import commands, measurements, study
from roughcontact.report import colours
from roughcontact.report.template import template
from roughcontact.statistics import outcome
from roughcontact.study.table import columns

# what the templates read of the settings, the table and the results
_MODULES = (
    *(commands, fields, generated, measurements, models, named_materials, outcome, plausible, rectangles),
    *(colours, columns, study, units),
)


class Page:
    """The page of a study, the same in each window: its fields as they were typed, and what was done."""

    def __init__(self) -> None:
        self.texts: dict[str, str] = {}  # of the settings, by dotted names
        self.rows: list[study.Row] = []
        self.job = self.look = ""  # the question, and the row that is looked at
        self.problem = self.added = self.saved = self.changed = ""  # messages
        self.aside: dict[str, str] = {}  # loads of another question
        self.omitted: list[study.Row] = []  # rows that were left out last
        self.run, self.reader, self.revision = commands.Run(), measurements.Reader(), 0
        self._read()

    def _read(self) -> None:
        """Take over what the files of the study folder say."""
        # what others write between the two is found to be new the next time
        self.problem, self.checked = "", study.check()
        try:
            self.texts, self.rows, self.job = study.read_folder()
        except Exception as error:  # the files may be of anybody
            self.problem = study.error_in_words(error)

    def _read_again(self) -> dict[int, int | None]:
        """Take over what others have changed in the files; return where each row is now, None where gone."""
        files, former_rows = self.checked["files"], self.rows
        changed = [str(path) for path, text in study.contents(files).items() if text != files[path]]
        if not changed:
            return {}
        self._read()
        self.look = ""
        self.changed = f"{' and '.join(changed)}: changed outside this page, and read again"
        self.revision += 1
        ticked = {row.get("surface") for row in former_rows if row.get(study.TICKED)}
        self.rows = [row | {study.TICKED: "on"} if row.get("surface") in ticked else row for row in self.rows]
        numbers = {row.get("surface"): number for number, row in enumerate(self.rows)}
        return {number: numbers.get(row.get("surface")) for number, row in enumerate(former_rows)}

    def after(self, form: Mapping[str, str]) -> str:
        """Return the page after changes of fields, by their names, and what a button does."""
        self.changed = ""
        places = self._read_again()
        action, job, texts = form.get("page.do", ""), form.get("page.job", self.job), self.texts
        self.look = form.get("page.look", self.look)
        names = [name for name in form if not name.startswith(("rows.", "page."))]
        changes = {study.name_of_field(name): form[name] for name in names}
        # what stood in the place of a group or a list goes
        former = [name for name in texts if any(key.startswith(f"{name}.") for key in changes)]
        texts = {name: text for name, text in texts.items() if name not in former} | changes
        # after what was typed before, which may come with it
        if job in study.JOBS and job != self.job:
            texts = study.texts_for(job, texts, self.aside)
        cells = defaultdict[int, study.Row](dict)
        for _, number, column in (name.split(".", 2) for name in form if name.startswith("rows.")):
            place = places.get(int(number), int(number))
            if place is None:
                self.changed += f"; {column} is not set: its row is in the table no more"
            else:
                cells[place][column] = form[f"rows.{number}.{column}"]
        rows = [row | cells.pop(number, {}) for number, row in enumerate(self.rows)] + [*cells.values()]
        rows = self._rows_after(action, form, rows)
        if (texts, rows, job) != (self.texts, self.rows, self.job):
            self.saved = study.save(texts, rows, job=job, keep=bool(self.problem))
            self.problem = ""
        self.texts, self.rows, self.job = texts, rows, job
        self.checked = study.check()
        self.revision += 1
        if action == "cancel":
            self.run.cancel()
        if action == "start":
            if self.checked["mistakes"] or 0 < len(rows) == len(
                measurements.unread(self.reader.inspected(rows))
            ):
                raise SettingsError("nothing is started: correct first what is listed under 4 Run")
            self.run.start()
        return self.html()

    def _rows_after(self, action: str, form: Mapping[str, str], rows: list[study.Row]) -> list[study.Row]:
        """Return the rows after the action of a button."""
        ticked = [row for row in rows if row.get(study.TICKED)]
        if action == "add":
            new, self.added = measurements.further(form["page.path"].split("\n"), rows)
            return [row | {study.TICKED: ""} for row in rows] + [row | {study.TICKED: "on"} for row in new]
        if action == "set":
            cell = {form["page.column"]: form["page.cell"]}
            return [row | cell if row in ticked else row for row in rows]
        if action == "remove":
            self.omitted, self.added = ticked, f"{len(ticked)} left out"
            return [row for row in rows if row not in ticked]
        if action == "undo":
            returned, self.omitted = self.omitted, []
            self.added = f"{len(returned)} back"
            return [*rows, *returned]
        return [row | {study.TICKED: "on"} for row in rows] if action == "all" else rows

    def since(self, news: str = "") -> str:
        """Return the page, or nothing where it is as it was with such `news`."""
        self._read_again()
        return "" if news == self.news() else self.html()

    def news(self) -> str:
        """Return a text that changes with the page: fields, files that are read, the run, its report."""
        reports = [path.stat().st_mtime_ns for path in commands.RESULTS.glob("report.html")]
        read = sum(reading.done() for reading in self.reader.readings.values())
        return f"{hash(repr((self.revision, read, self.run.state(), reports))):x}"

    def html(self) -> str:
        """Return the page."""
        news, rows = self.news(), self.reader.inspected(self.rows)  # what comes meanwhile is news
        config, screen = fields.grouped(self.texts), self.run.state()
        return self.filled("page", news=news, rows=rows, config=config, screen=screen)

    def with_bar(self, report: Path, home: str) -> str:
        """Return a page of the results below the bar of this one, which lies at `home`."""
        # before all of the report, which may be of anybody: nothing in it is left open around the bar
        return self.filled("bar", home=home) + report.read_text(encoding="utf-8", errors="replace")

    def filled(self, name: str, **variables: object) -> str:
        """Return one of the templates, with what all of them may need and variables of its own."""
        modules = {module.__name__.rpartition(".")[2]: module for module in _MODULES}
        values = modules | vars(self) | self.checked | {"folder": Path.cwd(), "home": ""}
        return template(f"{name}.html", folder=study.FOLDER).render(values | variables)
