"""What the rules of the workflow ask for: input functions, params and resources of jobs."""

import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from roughcontact.study.checksums import checksum
from roughcontact.study.dependencies import source_digest
from roughcontact.study.places import PARTIAL
from roughcontact.study.plan import STAGES, Plan, Rule, split
from roughcontact.study.points import estimate_points
from roughcontact.study.readers import reader_digest

InputFunction = Callable[[Any], list[str] | str]  # of the wildcards
# the scripts of rules that use those of others
_SCRIPTS = {"prepare_with_overview": "prepare", "prepare_face": "prepare", "statistics": "contact"}
_SCRIPTS |= {"wear": "course", "slide": "course"}


def _for_result(function: Callable[[str], Any]) -> Callable[[Any], Any]:
    """Return a function of the wildcards from one of the result."""
    return lambda wildcards: function(wildcards.result)


def _checksums(paths: list[str]) -> dict[str, str]:
    """Return the checksum of each file."""
    return {path: checksum(path) for path in paths}


class RuleArguments:
    """The arguments of the rules of one run, from its plan and the folder of the scripts."""

    def __init__(self, plan: Plan, scripts: Path):
        self.plan, self.scripts = plan, scripts

    def file_of(self, name: str, *, earlier: bool = False) -> InputFunction | list[str] | str:
        """Return the input function of a file: the own one, or that of the first case with the same settings.

        None where only pairs, or maps with an overview, have it, or with `earlier` where it is the own one.
        """
        # text takes Snakemake less time
        is_plain = not self.plan.pairs and len(self.plan.cases) == 1
        if is_plain and (name != "overview" or not self.plan.with_overview):
            nothing = earlier or name in ("counter_height", "overview")
            return [] if nothing else f"results/{{result}}/{name}.nc"

        def file(result: str) -> list[str] | str:
            is_own = earlier and not self.plan.other_case(name, result)
            return [] if is_own else self.plan.file(name, result) or []

        return _for_result(file)

    def sources_of(
        self, rule: Rule, *, local: Callable[[str], str], before: Callable[[], None]
    ) -> InputFunction:
        """Return the input function of measured files, `local` ones even where results have a prefix.

        `before` is called first: each job depends on one that reads.
        """

        def files(result: str) -> list[str]:
            before()
            time_now = time.time()
            # left out, but counted by checksum: files from the future, by a wrong clock, and braces, which
            # mark wildcards
            paths = [path for path in self.plan.sources(rule, result) if "{" not in path]
            return [local(path) for path in paths if Path(path).stat().st_mtime <= time_now]

        return _for_result(files)

    def params_of(self, rule: Rule) -> dict[str, Any]:
        """Return the params of a job: settings of its files, checksums of the measured files and of its code.

        A change of these runs it again, but for the row of the table, which depends on `input`.
        """
        plan, code = self.plan, source_digest(self.scripts / f"{_SCRIPTS.get(rule, rule)}.py")
        if rule == "report":  # a function, in whose result braces stay
            arguments = plan.report_arguments()
            return {
                "results": {result: plan.origin("statistics", result, checksum) for result in plan.results},
                "arguments": lambda wildcards: arguments,
                "code": code,
                "partial": PARTIAL.read_text("utf-8") if PARTIAL.exists() else "",
            }

        def row(wildcards: Any, input: Any) -> dict[str, str]:  # noqa: A002 - a name of Snakemake
            source = plan.measured.get(split(wildcards.result)[1])
            return {"path": str(source.path), "origin": source.origin} if source else {}

        def settings(result: str) -> dict[str, Any]:
            return {stage: plan.settings(stage, result) for stage in STAGES[rule] or ("statistics",)}

        params: dict[str, Any] = {"settings": _for_result(settings), "code": code}
        params["sources"] = _for_result(lambda result: _checksums(plan.sources(rule, result)))
        if rule.startswith("prepare"):
            params["readers"] = _for_result(lambda result: [*map(reader_digest, plan.sources(rule, result))])
        else:
            # of files made before: by dates alone a copy of a run that was killed may look complete
            params["measured"] = _for_result(lambda result: _checksums(plan.all_sources(result)))
            params["origin"] = _for_result(lambda result: plan.origin("window", result, checksum))
        has_row = rule.startswith("prepare") or rule in ("contact", "statistics")
        return params | ({"row": row} if has_row else {})

    def resources_of(self, rule: Rule) -> dict[str, Callable[..., int] | None]:
        """Return memory (MB) and run time (minutes) of a job, by the size of its map.

        No job writes temporary files; for the folder of these Snakemake would ask once more for each job.
        """

        def growing(number: Callable[..., float], min_value: int = 0) -> Callable[..., int]:
            """Return the function of a number that a job asks for again after each failure."""

            def of_wildcards(wildcards: Any, attempt: int) -> int:
                result = wildcards.get("result", "")
                return round(min_value + attempt * number(rule, result, points=self.points(result)))

            return of_wildcards

        return {"mem_mb": growing(self.plan.memory), "runtime": growing(self.plan.minutes, 5), "tmpdir": None}

    def threads_of(self) -> Callable[[Any], int]:
        """Return the function of the threads of the solver."""
        return _for_result(self.plan.threads)

    @cache  # noqa: B019 - there is one plan
    def points(self, result: str) -> int:
        """Return about how many points a measured map has, which is known before anything ran."""
        if not result:
            return 0
        row = self.plan.row(split(result)[1])
        return max(estimate_points(row.path), row.min_points)
