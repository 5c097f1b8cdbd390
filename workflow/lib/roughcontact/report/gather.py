"""The results of all surfaces of a run: one dataset, one table, one page."""

import json
import shutil
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr

from roughcontact.errors import RoughContactError
from roughcontact.report.asked import contacts
from roughcontact.report.page import write_report
from roughcontact.results.collect import (
    Entry,
    Failure,
    collect_statistics,
    file_of,
    pairs_table,
    solved_results,
    summary_table,
    with_failures,
)
from roughcontact.results.storage import provenance, table_text, write_dataset, write_table, write_text
from roughcontact.uncertainty.combination import is_of_budget, uncertainty_table
from roughcontact.uncertainty.differences import case_pairs, compare_all, compare_maps
from roughcontact.uncertainty.group_tables import NamedGroup, comparisons_table, groups_table, joined_groups
from roughcontact.uncertainty.groups import group_statistics, needed_for_groups


def write_results(
    folder: str | Path,
    *,
    finished: Sequence[Entry],
    title: str,
    settings: dict[str, Any],
    settings_of_statistics: dict[str, Any],
    groups: Mapping[str, tuple[Mapping[str, str], bool]],
    same_area_pairs: Sequence[Sequence[str]] = (),
    changed: Mapping[str, Sequence[str]] | None = None,
    failures: Sequence[Failure] = (),
    link_folder: str | Path | None = None,
) -> list[str]:
    """Write the datasets, tables and page of all surfaces of a run; return why groups were left out.

    `groups` are those of `Plan.groups`, `same_area_pairs` names of every two surfaces of the same area, the
    earlier one first, `changed` the settings in words by case, `failures` surfaces without results, and
    `link_folder` the folder to which the files will be moved, for the links.
    """
    folder = Path(folder)
    remove_earlier(folder)
    contact_of_case = dict(contacts(settings))
    for entry in finished:
        if contact_of_case[entry["case"] or ""].get("unload") is None:  # of an earlier run
            file_of(entry, "residual.nc").unlink(missing_ok=True)
    statistics = collect_statistics(finished)
    attrs = provenance(settings_of_statistics, source_sha256=statistics.source_sha256, stage="statistics")
    if failures:
        attrs["failed"] = json.dumps(list(failures), sort_keys=True)
    write_dataset(statistics.assign_attrs(attrs), folder / "statistics.nc")
    summary = summary_table(statistics)
    text = table_text(with_failures(summary, failures))
    write_text(text, folder / "summary.csv")
    write_table(budget_table(statistics), folder / "uncertainty.csv")
    pair_of_placement = {
        placement: name
        for name, (components, placements) in groups.items()
        if placements
        for placement in components
        if placement in set(summary["surface"])
    }
    if pair_of_placement:
        write_table(pairs_table(summary, pair_of_placement), folder / "pairs.csv")
    requested = {name for pair in same_area_pairs for name in pair}.union(
        *(components for components, _ in groups.values())
    )
    solved = _by_map(statistics, requested)
    answers, omitted = group_answers(solved, groups)
    compared, not_compared = comparisons(answers, same_area_pairs)
    of_maps, not_shared = map_comparisons(solved, groups, same_area_pairs)
    compared, omitted = compared | of_maps, omitted + not_compared + not_shared
    if groups or same_area_pairs:
        attrs["left_out"] = json.dumps(omitted, ensure_ascii=False)
        attrs = {key: text for key, text in attrs.items() if key != "comment"} | {"title": "Groups of maps"}
        write_dataset(joined_groups(answers).assign_attrs(attrs), folder / "groups.nc")
        write_table(groups_table(answers), folder / "groups.csv")
        write_table(comparisons_table(compared), folder / "comparisons.csv")
    write_report(
        folder / "report.html",
        finished=finished,
        statistics=statistics,
        summary=text,
        title=title,
        settings=settings,
        changed=changed,
        groups=answers,
        compared=compared,
        omissions=omitted,
        failures=failures,
        folder=link_folder,
    )
    return omitted


def remove_earlier(folder: Path) -> None:
    """Remove the files that only some studies have: they would pass for those of a later run."""
    shutil.rmtree(folder / "pages", ignore_errors=True)
    for name in ("groups.nc", "groups.csv", "comparisons.csv", "pairs.csv"):
        (folder / name).unlink(missing_ok=True)


def group_answers(
    solved: Mapping[str, Mapping[str, xr.Dataset]], groups: Mapping[str, tuple[Mapping[str, str], bool]]
) -> tuple[list[NamedGroup], list[str]]:
    """Return the answer of each group under each case, and a sentence for each that has none.

    `solved` has the statistics of each map by case ("" without cases) and name.
    """
    answers, omitted = [], []
    for name, (components, placements) in groups.items():
        for case, of_case in solved.items():
            selected = {map_: of_case[map_] for map_ in components if map_ in of_case}
            if not selected:
                continue
            try:
                result = group_statistics(
                    list(selected.values()),
                    names=list(selected),
                    parts=[components[map_] for map_ in selected],
                    group=name,
                    placements=placements,
                )
            except RoughContactError as error:
                omitted.append(f"{error}{f' (case {case})' if case else ''}")
            else:
                answers.append(NamedGroup(name, case or None, result, placements))
    return answers, omitted


def comparisons(
    answers: Sequence[NamedGroup], same_area_pairs: Sequence[Sequence[str]] = ()
) -> tuple[dict[tuple[str, str], xr.Dataset], list[str]]:
    """Return the comparisons of every two groups under a case, and of the cases (`case_pairs`) of a group.

    Groups of the same areas are compared map by map, placements under two cases alone; with them comes a
    sentence for each that cannot be made.
    """
    result: dict[tuple[str, str], xr.Dataset] = {}
    omitted: list[str] = []
    for case in dict.fromkeys(group.case for group in answers):
        of_case = [group for group in answers if group.case == case and not group.placements]
        selected = {group.label: group.answer for group in of_case}
        compared, reasons = compare_all(selected, same_area_pairs=same_area_pairs)
        result, omitted = result | compared, omitted + reasons
    for name in dict.fromkeys(group.name for group in answers):
        selected = {group.label: group.answer for group in answers if group.name == name}
        if len(selected) > 1 and any(answer.sizes["map"] > 1 for answer in selected.values()):
            compared, reasons = compare_all(selected, cases=case_pairs(list(selected)))
            result, omitted = result | compared, omitted + reasons
    return result, omitted


def map_comparisons(
    solved: Mapping[str, Mapping[str, xr.Dataset]],
    groups: Mapping[str, tuple[Mapping[str, str], bool]],
    same_area_pairs: Sequence[Sequence[str]],
) -> tuple[dict[tuple[str, str], xr.Dataset], list[str]]:
    """Return the comparisons under each case of maps of a place, and of the first placement with the others.

    With them comes a sentence for each that cannot be made.
    """
    pairs = [(earlier, later) for earlier, later in same_area_pairs]
    for first, *remaining in (list(components) for components, placements in groups.values() if placements):
        pairs += [(first, second) for second in remaining]
    result: dict[tuple[str, str], xr.Dataset] = {}
    omitted: list[str] = []
    for case, of_case in solved.items():
        shared = {}
        for pair in pairs:
            if of_case.keys() >= {*pair}:
                first, second = (f"{name} · {case}" if case else name for name in pair)
                shared[first, second] = of_case[pair[0]], of_case[pair[1]]
        compared, reasons = compare_maps(shared)
        result, omitted = result | compared, omitted + reasons
    return result, omitted


def _by_map(statistics: xr.Dataset, names: Collection[str]) -> dict[str, dict[str, xr.Dataset]]:
    """Return what groups and differences need of some solved maps, by case ("" without cases) and name."""
    bands = json.loads(statistics.attrs["bands"])
    needed = statistics[needed_for_groups(map(str, statistics.variables))].drop_attrs(deep=False)
    solved: dict[str, dict[str, xr.Dataset]] = {}
    for labels, result in solved_results(needed):
        case, surface = labels.get("case", ""), labels["surface"]
        if surface in names:
            solved.setdefault(case, {})[surface] = result.assign_attrs(bands[case][surface])
    return solved


def budget_table(statistics: xr.Dataset) -> pd.DataFrame:
    """Return the components of every interval of the surfaces (and cases) of `collect_statistics`."""
    of_budget = statistics[[name for name in statistics.variables if is_of_budget(str(name))]]
    tables = [uncertainty_table(result).assign(**labels) for labels, result in solved_results(of_budget)]
    joined = pd.concat(tables, ignore_index=True)
    labels = [dim for dim in ("case", "surface") if dim in joined]
    return joined[labels + [column for column in joined if column not in labels]]
