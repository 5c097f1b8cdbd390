"""The plan of a run: which result is made of which files, and what each job asks for.

A *result* is a folder, `ground` or `soft/ground` under a case. Surfaces are *single* ones, the *faces* of a
pair, or its *placements*. A case has its own files only where settings that they depend on are new.
"""

import json
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any, NamedTuple

from roughcontact.arguments.bodies import relaxation_table
from roughcontact.arguments.settings.generated import changed_settings
from roughcontact.arguments.settings.messages import NAME
from roughcontact.arguments.settings.stages import (
    AFTER,
    SECTIONS,
    origin_id,
    owner,
    stage_settings,
    stages_after,
)
from roughcontact.arguments.stacks import located_materials
from roughcontact.study.table.pairs import Placement, placements
from roughcontact.study.table.read import measured
from roughcontact.study.table.row import Surface
from roughcontact.study.table.same_area import same_area_pairs

Rule = str  # a key of STAGES, or "report"

# the stages whose files a rule writes; a case runs it where it differs in the settings of the decisive one
STAGES: dict[Rule, tuple[str, ...]] = {
    "prepare": ("height", "levelled", "window"),
    "prepare_with_overview": ("height", "levelled", "window", "overview"),
    "prepare_face": ("height", "levelled"),
    "superpose": ("levelled", "window"),
    "contact": ("contact", "uncertainty", "statistics"),
    "statistics": ("uncertainty", "statistics"),
    "panel": (),
    "unload": ("residual",),
    "wear": ("worn",),
    "slide": ("sliding",),
}
_DECISIVE = dict.fromkeys(("prepare", "prepare_with_overview", "superpose"), "window")
_DECISIVE |= {"prepare_face": "levelled", "contact": "contact"}
_NOT_OF_ALL = ("counter_height", "overview")  # files that only some surfaces have
NO_NAME = "(?!)"  # the pattern that no name matches

BASE_MEMORY = 700  # MB: a script and, on a cluster, the two Snakemakes that start it
_SMALL = 4.0  # MB of a measured file, below which jobs run side by side, with one thread each


class Role(NamedTuple):
    """What a name stands for: a single map, a face of a pair, or a placement of its faces."""

    row: Surface  # of the table, of a face its measured file
    cells: Mapping[str, Any]  # what its files record of the table
    last_stage: str  # of its preparation
    jobs: tuple[tuple[Rule, str], ...]  # of the preparation, each with one of the files that it makes
    files: Mapping[str, tuple[str, str]] = {}  # by other names -> surface and stage


@dataclass(frozen=True, eq=False)
class Plan:
    """The plan of a run, from the settings of each case (`resolve`) and the table (`read_surfaces`)."""

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
    def placements(self) -> dict[str, Placement]:
        """Name -> placement of a pair."""
        composite = self.common["composite"]
        return placements(self.table, composite["shifts"] * len(composite["rotations"]))

    @cached_property
    def roles(self) -> dict[str, Role]:
        """Name -> what it stands for: all measured files and placements."""
        roles = {
            name: Role(file, file.read_arguments, "levelled", (("prepare_face", "levelled"),))
            for name, file in self.measured.items()
        }
        for name, row in self.table.items():
            rule = "prepare_with_overview" if name in self.with_overview else "prepare"
            roles[name] = Role(row, row.read_arguments, "window", ((rule, "window"),))
        for name, placement in self.placements.items():
            face, counter_face = sides = placement.face, placement.counter_face
            cells = vars(placement) | {"composite": self.common["composite"]}
            cells["sides"] = {side: self.measured[side].read_arguments for side in sides}
            jobs = ("prepare_face", "face"), ("prepare_face", "counter_face"), ("superpose", "window")
            files = {"height": (face, "height"), "counter_height": (counter_face, "height")}
            files |= {"face": (face, "levelled"), "counter_face": (counter_face, "levelled")}
            roles[name] = Role(self.table[placement.pair], cells, "window", jobs, files)
        return roles

    @cached_property
    def pairs(self) -> dict[str, list[str]]:
        """Name of each pair of faces -> its placements."""
        pairs: dict[str, list[str]] = {}
        for name, placement in self.placements.items():
            pairs.setdefault(placement.pair, []).append(name)
        return pairs

    @cached_property
    def solved(self) -> list[str]:
        """The names of the solved surfaces, in the order of the table."""
        return [name for row in self.table for name in self.pairs.get(row, [row])]

    @cached_property
    def with_overview(self) -> list[str]:
        """The surfaces around which there are coarser maps."""
        return [name for name, row in self.table.items() if row.read_arguments.get("overview")]

    @cached_property
    def groups(self) -> dict[str, dict[str, str]]:
        """Name -> group of maps, each with its specimen: placements of two faces have one, their row."""
        groups: dict[str, dict[str, str]] = {}
        for surface in self.solved:
            row = self.row(surface)
            if row.group:
                groups.setdefault(row.group, {})[surface] = row.specimen or row.name
        return groups

    @cached_property
    def same_area_pairs(self) -> list[tuple[str, str]]:
        """The names of every two surfaces that are the same specimen at two times, the earlier one first."""
        return same_area_pairs(self.table)

    @cached_property
    def results(self) -> list[str]:
        """The folders of all results of the run, case by case."""
        return [_result(case, surface) for case in self.cases for surface in self.solved]

    def further_rules(self, case: str) -> list[Rule]:
        """Return the rules that the settings of a case ask for, beside those of every study."""
        return [rule for rule in STAGES if {*STAGES[rule]} & {*stages_after(self.cases[case])}]

    def further_files(self, result: str) -> list[str]:
        """Return the paths of what these rules write for a result."""
        return [f"results/{result}/{stage}.nc" for stage in stages_after(self.cases[split(result)[0]])]

    def row(self, surface: str) -> Surface:
        """Return the row of the table from which a surface comes, or the measured file of a face."""
        return self.roles[surface].row

    def pattern(self, rule: Rule) -> str:
        r"""Return the regular expression of the results that a rule makes.

        It has the names of cases, of pairs and of maps with an overview alone: one of all names slows
        Snakemake down.
        """
        owners = self._owners
        stage = _DECISIVE.get(rule)
        cases = [case for case in self.cases if stage is None or owners[case, stage] == case]
        if rule == "statistics":
            cases = [case for case in self.cases if owners[case, "contact"] != case]
        if {*STAGES.get(rule, ())} & {*AFTER}:
            cases = [case for case in self.cases if rule in self.further_rules(case)]
        pairs, last = regex_of_names(self.pairs), max(map(len, self.pairs.values()), default=0)
        face = f"{pairs}-(?:counter-)?face"
        placement = f"{pairs}-{regex_of_names(map(str, range(1, last + 1)))}"
        surveyed = regex_of_names(self.with_overview)
        others = f"{face}|{placement}|{surveyed}"  # without pairs, or overviews, these match nothing
        name = {
            "prepare": f"(?!(?:{others})(?:/|$)){NAME}",
            "prepare_with_overview": surveyed,
            "prepare_face": face,
            "superpose": placement,
        }.get(rule, f"(?!{face}(?:/|$)){NAME}")
        return name if "" in cases else f"{regex_of_names(cases)}/{name}"

    @cached_property
    def _owners(self) -> dict[tuple[str, str], str]:
        """The first case with the same settings, of each case and stage."""
        return {(case, stage): owner(self.cases, case, stage) for stage in SECTIONS for case in self.cases}

    def file(self, name: str, result: str) -> str:
        """Return the path of a file that a result uses, of the first case with the same settings.

        The name is a stage; of a placement also "face", "counter_face", "counter_height" (else empty), and
        of a map with an overview "overview" (else empty).
        """
        case, surface = split(result)
        role = self.roles[surface]
        if name in role.files:
            side, stage = role.files[name]
            return self.file(stage, _result(case, side))
        prepared = {stage for rule, _ in role.jobs for stage in STAGES[rule]}
        if name in _NOT_OF_ALL and name not in prepared:
            return ""
        stage = role.last_stage if name in prepared else name  # one job makes them all
        owner_case = self._owners.get((case, stage), case)  # what follows the contact no other case shares
        return f"results/{_result(owner_case, surface)}/{name}.nc"

    def other_case(self, stage: str, result: str) -> str:
        """Return the case whose file of a stage a result uses, empty where it is its own."""
        case, _ = split(result)
        owner_case = self._owners[case, stage]
        return owner_case if owner_case != case else ""

    def sources(self, rule: Rule, result: str) -> list[str]:
        """Return the paths of the measured files that a job reads: maps, or a relaxation."""
        case, surface = split(result)
        if rule.startswith("prepare"):
            row = self.measured[surface]
            keys = ("repeats", "along", "place", "overview")
            further_paths = (entry["path"] for key in keys for entry in row.read_arguments.get(key, ()))
            return [*dict.fromkeys([str(row.path), *further_paths])]
        is_solving = rule in ("contact", "statistics") and not self.other_case("uncertainty", result)
        path = (
            relaxation_table(self.cases[case]["contact"]["bodies"]) if is_solving or rule == "slide" else ""
        )
        return [path] if path else []

    def all_sources(self, result: str) -> list[str]:
        """Return the paths of the measured files that contribute to a result."""
        return [path for job in self.contributing(result) for path in self.sources(*job)]

    def settings(self, stage: str, result: str) -> dict[str, Any]:
        """Return all settings on which a stage of a result depends, as its file records them.

        The stage is one of `SECTIONS`; the key `surface` has the cells of the table.
        """
        case, surface = split(result)
        return {"surface": {"name": surface, **self.roles[surface].cells}, **self._plan_settings(case, stage)}

    @cache  # noqa: B019 - there is one plan
    def _plan_settings(self, case: str, stage: str) -> dict[str, Any]:
        return stage_settings(self.cases[case], stage)

    @cached_property
    def jobs(self) -> list[tuple[Rule, str]]:
        """Rule and result of all jobs of the chain."""
        return [*dict.fromkeys(job for result in self.results for job in self.contributing(result))]

    @cached_property
    def files(self) -> list[str]:
        """The paths of all files that the jobs of the chain write."""
        files = [f"results/{folder}/{stage}.nc" for rule, folder in self.jobs for stage in STAGES[rule]]
        files += [f"results/{result}/panel.{kind}" for result in self.results for kind in ("html", "json")]
        return files

    def origin(self, name: str, result: str, checksum: Callable[[str], str]) -> str:
        """Return the origin (`origin_id`) of a file that a result uses; `checksum` is of a measured file."""
        file = self.file(name, result)
        jobs = [job for job in self.contributing(_folder(file)) if job[0].startswith("prepare")]
        checksums = " + ".join(checksum(self.sources(*job)[0]) for job in jobs)
        return origin_id(json.dumps(self.settings(Path(file).stem, _folder(file)), sort_keys=True), checksums)

    def report_arguments(self) -> dict[str, Any]:
        """Return the keyword arguments of `write_results` that the settings and the table give."""
        settings = dict(self.cases)
        of_statistics = {case: stage_settings(entry, "statistics") for case, entry in settings.items()}
        return {
            "title": self.common["report"]["title"],
            "settings": settings.get("", settings),
            "settings_of_statistics": of_statistics.get("", of_statistics),
            "changed": {case: changed_settings(entry) for case, entry in settings.items()},
            "groups": self.groups,
            "pairs": self.pairs,
            "same_area_pairs": self.same_area_pairs,
        }

    def threads(self, result: str) -> int:
        """Return the threads of the solver: one for small maps, where jobs run side by side instead."""
        # of the measured file alone: sums over the grid round by the number of threads, and results must not
        # depend on the computer
        return 1 if megabytes(self.row(split(result)[1]).path) < _SMALL else 4

    def loads(self, case: str = "") -> int:
        """Return the number of loads; a load plan for the map has about ten."""
        contact = self.cases[case]["contact"]
        return len(contact["mean_pressure"] or contact["relative_pressure"] or range(10))

    def memory(self, rule: Rule, result: str, *, points: int) -> float:
        """Return the memory (MB) of a job for a measured map of about so many `points`, including a margin.

        docs/how-to/cluster.md compares it with measurements.
        """
        if rule == "report":  # each result takes 0.15 to 0.25 MB and 0.08 s
            return BASE_MEMORY + len(self.results) / 2
        case, surface = split(result)
        millions = points / 1e6
        if rule == "superpose":
            return BASE_MEMORY + 400 * millions
        if rule.startswith("prepare"):
            row = self.row(surface)
            extra_bytes = {"repeats": 130, "place": 230}  # bytes a point
            bytes_each = max([90, *(extra_bytes[key] for key in extra_bytes if key in row.read_arguments)])
            expansion = 10 if row.path.suffix == ".npy" else 50  # other files may be compressed
            return BASE_MEMORY + max(expansion * megabytes(row.path), bytes_each * millions)
        if rule == "panel":  # a map or two at a time
            return BASE_MEMORY + 115 * millions
        # the error budget takes 200 bytes for each of the first million points, and no more for larger maps
        return BASE_MEMORY + (115 + self._bytes_of_statistics(case)) * millions + 200 * min(millions, 1)

    @cache  # noqa: B019
    def _bytes_of_statistics(self, case: str) -> int:
        """Return the memory (bytes) for each point that flow and stresses take, where they are computed."""
        statistics, bodies = self.cases[case]["statistics"], self.cases[case]["contact"]["bodies"] or ()
        flow = statistics["flow"] == "always" or (statistics["flow"] == "auto" and bool(statistics["seal"]))
        yields = any(material["yield_stress"] for _, material in located_materials(bodies))
        stress = statistics["stress"] == "always" or (statistics["stress"] == "auto" and yields)
        return 1800 * flow + 200 * stress

    def minutes(self, rule: Rule, result: str, *, points: int) -> float:
        """Return the run time (minutes) of a job after its start, including a margin, as `memory` does."""
        if rule == "report":
            return len(self.results) / 300
        case, surface = split(result)
        wear, sliding = self.cases[case]["wear"], self.cases[case]["sliding"]
        seconds = {  # of a million points
            "unload": 60 * self.loads(case),
            # steps to each distance, and the same of the parts
            "wear": 400 * len(wear["distance"] or ()),
            # some fifteen contacts for each speed, the same of the parts and the instrument
            "slide": 900 * len(sliding["direction"]) * len(sliding["speed"] or ()),
        }
        if rule in seconds:
            return seconds[rule] * points / 60e6
        if rule.startswith("prepare") or rule in ("superpose", "panel"):
            return 40 * points / 60e6 + megabytes(self.row(surface).path) / 100
        return (240 + 190 * self.loads(case)) * points / 60e6

    def contributing(self, result: str) -> list[tuple[Rule, str]]:
        """Return rule and result of all jobs of the chain that contribute to a result, in their order."""
        _, surface = split(result)
        jobs = [(rule, _folder(self.file(name, result))) for rule, name in self.roles[surface].jobs]
        for stage in ("contact", "uncertainty", "statistics"):
            folder = _folder(self.file(stage, result))
            case, _ = split(folder)
            jobs.append(("contact" if self._owners[case, "contact"] == case else "statistics", folder))
        jobs.append(("statistics" if self.other_case("contact", result) else "contact", result))
        jobs += [(rule, result) for rule in (*self.further_rules(split(result)[0]), "panel")]
        return list(dict.fromkeys(jobs))

    def expected(self, points: Callable[[str], int]) -> dict[tuple[Rule, str], tuple[float, int]]:
        """Return minutes and threads of the jobs of the chain, by rule and result; `points` of a result."""
        return {
            (rule, result): (
                self.minutes(rule, result, points=points(result)),
                self.threads(result) if rule in ("contact", "statistics") else 1,
            )
            for rule, result in self.jobs
        }

    def log_files(self, result: str) -> list[str]:
        """Return the paths of the logs of all jobs that contribute to a result, in their order."""
        return [f"logs/{folder}/{rule}.log" for rule, folder in self.contributing(result)]


def split(result: str) -> tuple[str, str]:
    """Return the case, empty where there are none, and the surface of a result: of "soft/ground" both."""
    case, _, surface = result.rpartition("/")
    return case, surface


def _result(case: str, surface: str) -> str:
    return f"{case}/{surface}" if case else surface


def _folder(file: str) -> str:
    return file.removeprefix("results/").rpartition("/")[0]


def regex_of_names(names: Iterable[str]) -> str:
    r"""Return the regular expression of some names, a tree by letters; without names nothing matches."""
    branches: dict[str, list[str]] = {}
    for name in names:
        branches.setdefault(name[:1], []).append(name[1:])
    if not branches:
        return NO_NAME
    may_end = branches.pop("", None) is not None
    alternatives = [re.escape(letter) + regex_of_names(remainders) for letter, remainders in branches.items()]
    pattern = "|".join(alternatives)
    if len(alternatives) > 1 or (alternatives and may_end):
        return f"(?:{pattern})" + "?" * may_end
    return pattern


def megabytes(path: str | Path) -> float:
    """Return the size of a file in MB, 0 where there is none."""
    return Path(path).stat().st_size / 1e6 if Path(path).exists() else 0.0
