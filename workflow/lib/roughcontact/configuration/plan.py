"""The plan of a run: files and owners of all stages, and inputs, outputs and resources of each job.

A surface has two jobs: `prepare` reads, levels and cuts out the window, `contact` bounds the error, solves,
counts and draws the panel. Each case has a folder of its own with all files: those that an earlier case has
computed with the same settings are linked. A case with nothing to prepare, or only for itself, has a single
job, `contact`, for all of its files.

Surfaces are of three kinds: *single* ones, the two *faces* of a pair, which are measured and levelled, and
the *members* of a pair, the relative positions of its faces, which are windowed and solved.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple

from roughcontact.configuration.stages import SECTIONS, owner, settings_of
from roughcontact.configuration.surfaces import Member, Surface, measured, members, same_places

Kind = Literal["single", "face", "member"]
Part = Literal["prepare", "contact"]

PREPARED: dict[Kind, tuple[str, ...]] = {
    "single": ("height", "levelled", "window"),
    "face": ("height", "levelled"),
    "member": ("levelled", "window"),
}
SOLVED = ("uncertainty", "contact", "statistics", "panel")
# files that are read to make each file; the heights of a member are those of its face
_READ = {
    "height": (),
    "levelled": ("height",),
    "window": ("levelled",),
    "uncertainty": ("levelled", "window"),
    "contact": ("window",),
    "statistics": ("window", "contact", "uncertainty"),
    "panel": ("height", "counter_face", "levelled", "window", "contact", "statistics"),
}
NOTHING = "(?!)"  # the pattern that no name matches

BASE_MEMORY = 700  # MB: a script and, on a cluster, the two Snakemakes that start it
_SMALL = 4.0  # MB of a measured file, below which jobs run side by side, with one thread each


class Job(NamedTuple):
    """The steps of one job of a surface under one case.

    Attributes
    ----------
    steps : list of str
        the files it computes, in their order, by their names without ending.
    links : list of str
        the files it links, since another case has computed them.
    inputs : dict
        name -> path: files that the steps read and do not make themselves, and the targets of the links.
    sources : list of str
        paths of the files from outside that the steps read.
    """

    steps: list[str]
    links: list[str]
    inputs: dict[str, str]
    sources: list[str]


class Run(NamedTuple):
    """One surface under one case: a row of the results.

    The case is empty in a run without cases.
    """

    surface: str
    case: str


class Group(NamedTuple):
    """Maps that have one answer together.

    Attributes
    ----------
    parts : dict
        name of a solved surface -> the part that it is of.
    placements : bool
        whether they are the relative positions of two faces.
    """

    parts: dict[str, str]
    placements: bool


@dataclass(frozen=True)
class Plan:
    """The plan of a run.

    Attributes
    ----------
    cases : mapping
        name -> full settings, as `resolve` returns them.
    table : mapping
        name -> Surface, as `read_surfaces` returns them.

    Examples
    --------
    >>> from roughcontact.configuration.resolve import resolve
    >>> two = {"a": {}, "b": {"level": {"order": 3}}}
    >>> cases = resolve({"contact": {"contact_modulus": 1e9}, "cases": two})
    >>> plan = Plan(cases, {"ground": Surface("ground", Path("ground.x3p"), "line 2", {})})
    >>> plan.file("height", "ground", "b")
    'results/a/ground/height.nc'
    >>> plan.job("contact", "ground", "b").links
    ['height']
    """

    cases: Mapping[str, dict[str, Any]]
    table: Mapping[str, Surface]

    @cached_property
    def common(self) -> dict[str, Any]:
        """The common settings of all cases, which are those of the first."""
        return self.cases[next(iter(self.cases))]

    @cached_property
    def measured(self) -> dict[str, Surface]:
        """Name -> measured file: single surfaces and faces."""
        return measured(self.table)

    @cached_property
    def members(self) -> dict[str, Member]:
        """Name -> member of a pair."""
        composite = self.common["composite"]
        return members(self.table, composite["shifts"] * len(composite["rotations"]))

    @cached_property
    def solved(self) -> list[str]:
        """The names of the solved surfaces, in the order of the table."""
        of_pair: dict[str, list[str]] = {}
        for name, member in self.members.items():
            of_pair.setdefault(member.pair, []).append(name)
        return [name for row in self.table for name in of_pair.get(row, [row])]

    @cached_property
    def groups(self) -> dict[str, Group]:
        """Name -> group of maps: those of the table, then the pairs of faces with their members."""
        found: dict[str, Group] = {}
        for surface in self.solved:
            member = self.members.get(surface)
            row = self.row(surface)
            if row.group:
                group = found.setdefault(row.group, Group({}, placements=False))
                # placements of two faces are of one pair of parts
                group.parts[surface] = row.part or (member.pair if member else surface)
        for surface, member in self.members.items():
            found.setdefault(member.pair, Group({}, placements=True)).parts[surface] = surface
        return found

    @cached_property
    def same_places(self) -> list[tuple[str, str]]:
        """The names of every two surfaces that are the same place, the earlier one first."""
        return same_places(self.table)

    @cached_property
    def runs(self) -> list[Run]:
        """Every result of the run, case by case."""
        return [Run(surface, case) for case in self.cases for surface in self.solved]

    @cached_property
    def folder(self) -> str:
        """Pattern of the folder of a surface, with wildcards."""
        return "results/{surface}" if "" in self.cases else "results/{case}/{surface}"

    @cached_property
    def logs(self) -> str:
        """Pattern of the folder of the logs of a surface."""
        return self.folder.replace("results", "logs", 1)

    @cached_property
    def owners(self) -> dict[str, dict[str, str]]:
        """The case that computes a stage of a case: stage -> case -> case."""
        return {stage: {case: owner(self.cases, case, stage) for case in self.cases} for stage in SECTIONS}

    def kind(self, surface: str) -> Kind:
        """Return whether a name is that of a single surface, a face or a member."""
        if surface in self.members:
            return "member"
        return "single" if surface in self.table else "face"

    def row(self, surface: str) -> Surface:
        """Return the row of the table from which a surface comes, or the measured file of a face."""
        return self.table[self.members[surface].pair] if surface in self.members else self.measured[surface]

    def names(self, *kinds: Kind) -> list[str]:
        """Return the names of all surfaces of some kinds."""
        return [name for name in [*self.measured, *self.members] if self.kind(name) in kinds]

    @cached_property
    def preparing(self) -> list[str]:
        """The cases with a job `prepare`: the first, which reads, and those whose files others link."""
        taken = {
            self.owners[stage][case]
            for stage in PREPARED["single"]
            for case in self.cases
            if self.owners[stage][case] != case
        }
        first = next(iter(self.cases))
        return [case for case in self.cases if case == first or case in taken]

    @cached_property
    def following(self) -> list[str]:
        """The cases whose job `contact` also makes, or links, the files of `prepare`."""
        return [case for case in self.cases if case not in self.preparing]

    def job(self, part: Part, surface: str, case: str = "") -> Job:
        """Return the files that a job ("prepare" or "contact") computes, links and reads."""
        kind = self.kind(surface)
        alone = part == "contact" and case in self.preparing
        made = [*(() if alone else PREPARED[kind]), *(SOLVED if part == "contact" else ())]
        steps = [name for name in made if name not in SECTIONS or self.owners[name][case] == case]
        links = [name for name in made if name not in steps]
        read = [name for step in steps for name in self._read(step, kind) if name not in steps]
        inputs = {name: self.file(name, surface, case) for name in sorted({*read, *links})}
        return Job(steps, links, inputs, self._sources(steps, surface, case))

    def _sources(self, steps: Iterable[str], surface: str, case: str) -> list[str]:
        """Return the files from outside that some steps read: maps, repeats of them, finer maps."""
        found = []
        if "height" in steps:
            row = self.measured[surface]
            repeat = row.given.get("repeat")
            found += [str(row.path), *([repeat["path"]] if repeat else [])]
        finer = self.cases[case]["instrument"]["finer_spectrum"]
        return found + ([finer] if finer and "uncertainty" in steps else [])

    def _read(self, step: str, kind: Kind) -> tuple[str, ...]:
        """Return the files that are read to make a file of a surface of some kind."""
        if kind == "member":
            return ("face", "facing") if step == "levelled" else _READ[step]
        return tuple(name for name in _READ[step] if name != "counter_face")

    def file(self, name: str, surface: str, case: str = "") -> str:
        """Return the path of a file of a surface, in the folder of the case that computes it.

        The name is that of a stage, or "panel"; for a member also "counter_face" (the heights of
        the counter-face), "face" and "facing" (both faces, levelled).
        """
        if name == "panel":
            return f"{self.folder}/panel.html".format(surface=surface, case=case)
        if surface in self.members:
            face, facing = self.members[surface].face, self.members[surface].counter_face
            name, surface = {
                "height": ("height", face),
                "counter_face": ("height", facing),
                "face": ("levelled", face),
                "facing": ("levelled", facing),
            }.get(name, (name, surface))
        return f"{self.folder}/{name}.nc".format(surface=surface, case=self.owners[name][case])

    def panel(self, surface: str, case: str = "") -> str:
        """Return the path of the panel for the report."""
        return f"{self.folder}/panel.html".format(surface=surface, case=case)

    def summary(self, surface: str, case: str = "") -> str:
        """Return the path of the summary of `panel`: verdict and reasons, as JSON."""
        return self.panel(surface, case).removesuffix("html") + "json"

    def outputs(self, part: Part, kind: Kind, *, whole: bool = False) -> dict[str, str]:
        """Return the files of a job ("prepare" or "contact"), name -> path with wildcards.

        `whole`: those of the job `contact` of a case without a job `prepare`.
        """
        names = (
            *(PREPARED[kind] if part == "prepare" or whole else ()),
            *(SOLVED if part == "contact" else ()),
        )
        files = {name: f"{self.folder}/{name}.{'html' if name == 'panel' else 'nc'}" for name in names}
        return files | ({"summary": f"{self.folder}/panel.json"} if part == "contact" else {})

    def links(self) -> list[str]:
        """Return the links of all cases, so that every folder is complete."""
        return [
            self.folder.format(surface=surface, case=case) + f"/{stage}.nc"
            for case in self.cases
            for surface in [*self.measured, *self.members]
            for stage in self._stages(self.kind(surface))
            if self.owners[stage][case] != case
        ]

    def _stages(self, kind: Kind) -> list[str]:
        """Return the stages with files for surfaces of a kind."""
        return [*PREPARED[kind], *(name for name in SOLVED if name in SECTIONS and kind != "face")]

    def settings(self, stage: str, surface: str, case: str = "") -> dict[str, Any]:
        """Return all settings on which a stage of a surface depends, as its file records them.

        The stage is one of `SECTIONS`. The result has a key for each section; `surface` has the cells of the
        table.
        """
        if surface in self.members:
            row = {**vars(self.members[surface]), "composite": self.common["composite"]}
        else:
            row = self.measured[surface].given
        return {"surface": {"name": surface, **row}, **settings_of(self.cases[case], stage)}

    def all_settings(self, part: Callable[[dict[str, Any]], dict[str, Any]] = dict) -> dict[str, Any]:
        """Return the settings of the whole run, or a `part` of them: of each case, if there are cases."""
        if "" in self.cases:
            return part(self.cases[""])
        return {case: part(settings) for case, settings in self.cases.items()}

    def threads(self, surface: str) -> int:
        """Return the threads of the solver: one for small maps, where jobs run side by side instead.

        It depends on the measured file alone: rounding of sums over the grid depends on the number of
        threads, and results must not depend on the computer.
        """
        return 1 if megabytes(self.row(surface).path) < _SMALL else 4

    def loads(self, case: str = "") -> int:
        """Return the number of loads; a load plan for the map has about ten."""
        contact = self.cases[case]["contact"]
        return len(contact["mean_pressure"] or contact["relative_pressure"] or range(10))

    def memory(self, part: Part, surface: str, case: str = "", *, points: int) -> float:
        """Return the memory (MB) of a job for a measured map of about so many `points`, including a margin.

        docs/how-to/cluster.md compares it with measurements.
        """
        millions = points / 1e6
        if part == "prepare" and surface in self.members:
            return BASE_MEMORY + 400 * millions
        reading = 0.0 if surface in self.members else reading_memory(self.row(surface).path)
        prepare = max(reading, (130 if "repeat" in self.row(surface).given else 90) * millions)
        if part == "prepare":
            return BASE_MEMORY + prepare
        statistics, bodies = self.cases[case]["statistics"], self.cases[case]["contact"]["bodies"] or ()
        flow = statistics["flow"] == "always" or (statistics["flow"] == "auto" and bool(statistics["seal"]))
        materials = [material for body in bodies for material in (body, *(body["layers"] or ()))]
        yields = any(material["yield_stress"] for material in materials)
        stress = statistics["stress"] == "always" or (statistics["stress"] == "auto" and yields)
        # the error budget takes 200 bytes for each of the first million points, and no more for larger maps
        solving = (115 + 1800 * flow + 200 * stress) * millions + 200 * min(millions, 1)
        return BASE_MEMORY + max(solving, 0 if case in self.preparing else prepare)

    def minutes(self, part: Part, surface: str, case: str = "", *, points: int) -> float:
        """Return the run time (minutes) of a job after its start, including a margin, as `memory` does."""
        prepare = 40 * points / 60e6 + megabytes(self.row(surface).path) / 100
        if part == "prepare":
            return prepare
        solving = (240 + 190 * self.loads(case)) * points / 60e6
        return solving + (0 if case in self.preparing else prepare)

    def expected(self, points: Callable[[str], int]) -> dict[tuple[str, str, str], tuple[float, int]]:
        """Return minutes and threads of the chain's jobs by part, surface and case; `points` of a surface."""
        jobs: list[tuple[Part, str, str]] = [("contact", *run) for run in self.runs]
        jobs += [
            ("prepare", name, case) for name in [*self.measured, *self.members] for case in self.preparing
        ]
        return {
            job: (
                self.minutes(*job, points=points(job[1])),
                self.threads(job[1]) if job[0] == "contact" else 1,
            )
            for job in jobs
        }

    def sources(self, run: Run) -> list[str]:
        """Return the paths of all files from outside that contribute to a result, each once."""
        return list(dict.fromkeys(path for job in self._contributing(run) for path in self.job(*job).sources))

    def log_files(self, run: Run) -> list[str]:
        """Return the paths of the logs of all jobs that contribute to a result, in their order.

        Some of these jobs may not exist.
        """
        return [
            f"{self.logs}/{part}.log".format(surface=surface, case=case)
            for part, surface, case in self._contributing(run)
        ]

    def _contributing(self, run: Run) -> list[tuple[Part, str, str]]:
        """Return part, surface and case of all jobs that contribute to a result; some may not exist."""
        member = self.members.get(run.surface)
        faces = [member.face, member.counter_face] if member else []
        jobs: dict[tuple[Part, str, str], None] = {}  # each once
        for stage in SECTIONS:
            case = self.owners[stage][run.case]
            for face in faces if stage in PREPARED["face"] else ():
                jobs["prepare", face, case] = None
            if not (member and stage == "height"):
                first = stage in PREPARED["single"] and case in self.preparing
                jobs["prepare" if first else "contact", run.surface, case] = None
        jobs["contact", run.surface, run.case] = None
        return list(jobs)


def one_of(names: Iterable[str]) -> str:
    r"""Return the pattern of some names, letter by letter, which matches thousands of them as fast as a few.

    Nothing matches the pattern of no names.

    Examples
    --------
    >>> one_of(["ground-1", "ground-2", "turned"])
    '(?:ground\\-(?:1|2)|turned)'
    """
    branches: dict[str, list[str]] = {}
    for name in names:
        branches.setdefault(name[:1], []).append(name[1:])
    if not branches:
        return NOTHING
    may_end = branches.pop("", None) is not None
    each = [re.escape(letter) + one_of(rests) for letter, rests in branches.items()]
    pattern = "|".join(each)
    if len(each) > 1 or (each and may_end):
        return f"(?:{pattern})" + "?" * may_end
    return pattern


def megabytes(path: str | Path) -> float:
    """Return the size of a file in MB, 0 where there is none."""
    return Path(path).stat().st_size / 1e6 if Path(path).exists() else 0.0


def reading_memory(path: str | Path) -> float:
    """Return the memory (MB) for the content of a measured file.

    NumPy files are not compressed, others may be.
    """
    return (10 if str(path).endswith(".npy") else 50) * megabytes(path)
