"""The results of all surfaces of a run: one dataset, one table, one page."""

import shutil
from collections.abc import Collection, Mapping, Sequence
from itertools import chain, product
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pandas as pd
import xarray as xr

from roughcontact.arguments.measurement import json_attribute, json_attributes
from roughcontact.arguments.settings.stages import AFTER, stages_after
from roughcontact.errors import RoughContactError
from roughcontact.report.groups import name_under
from roughcontact.report.page import write_report
from roughcontact.results import collect
from roughcontact.results.storage import provenance, table_text, write_dataset, write_table, write_text
from roughcontact.uncertainty.combination import TABLE_VARIABLES, uncertainty_table
from roughcontact.uncertainty.differences import case_pairs, compare_all, compare_maps
from roughcontact.uncertainty.group_tables import NamedGroup, comparisons_table, groups_table, joined_groups
from roughcontact.uncertainty.groups import group_statistics, needed_for_groups

# comparisons by the names of what is compared, and a sentence for each that cannot be made
Comparisons = tuple[dict[tuple[str, str], xr.Dataset], list[str]]


def write_results(
    folder: str | Path,
    *,
    finished: Sequence[collect.Entry],
    settings: dict[str, Any],
    settings_of_statistics: dict[str, Any],
    groups: Mapping[str, Mapping[str, str]],
    pairs: Mapping[str, Sequence[str]] = MappingProxyType({}),
    same_area_pairs: Sequence[Sequence[str]] = (),
    failures: Sequence[collect.Failure] = (),
    **of_page: Any,
) -> list[str]:
    """Write the datasets, tables and page of all surfaces of a run; return why groups were left out.

    `groups` and `pairs` are those of `Plan`, `same_area_pairs` names of every two surfaces of the same area,
    the earlier one first, `failures` surfaces without results; `of_page` are further arguments of
    `write_report`: `title`, the settings `changed` in words by case, whether the page is `linked` to files.
    """
    folder = Path(folder)
    remove_earlier(folder)
    for entry in finished:
        of_case = settings if entry["case"] is None else settings[entry["case"]]
        for stage in AFTER.keys() - stages_after(of_case):  # of an earlier run
            collect.file_of(entry, f"{stage}.nc").unlink(missing_ok=True)
    statistics = collect.collect_statistics(finished)
    attrs = provenance(settings_of_statistics, source_sha256=statistics.source_sha256, stage="statistics")
    if failures:
        attrs |= json_attributes({"failed": list(failures)})
    write_dataset(statistics.assign_attrs(attrs), folder / "statistics.nc")
    text = table_text(collect.append_failures(collect.summary_table(statistics), failures))
    write_text(text, folder / "summary.csv")
    write_table(budget_table(statistics), folder / "uncertainty.csv")
    names_requested = {*chain.from_iterable((*same_area_pairs, *groups.values(), *pairs.values()))}
    by_case = _split_by_map(statistics, names_requested)
    answers, omissions = group_answers(by_case, groups, pairs)
    of_groups = comparisons(answers, same_area_pairs)
    compared, not_compared = _joined([of_groups, map_comparisons(by_case, pairs, same_area_pairs)])
    omissions += not_compared
    if names_requested:
        attrs |= json_attributes({"left_out": omissions})
        attrs = {key: text for key, text in attrs.items() if key != "comment"} | {"title": "Groups of maps"}
        write_dataset(joined_groups(answers).assign_attrs(attrs), folder / "groups.nc")
        write_table(groups_table(answers), folder / "groups.csv")
        write_table(comparisons_table(compared), folder / "comparisons.csv")
    write_report(
        folder / "report.html",
        finished=finished,
        statistics=statistics,
        summary=text,
        settings=settings,
        groups=answers,
        compared=compared,
        omissions=omissions,
        failures=failures,
        **of_page,
    )
    return omissions


def remove_earlier(folder: Path) -> None:
    """Remove the files that only some studies have: they would pass for those of a later run."""
    shutil.rmtree(folder / "pages", ignore_errors=True)
    for name in ("groups.nc", "groups.csv", "comparisons.csv", "pairs.csv"):
        (folder / name).unlink(missing_ok=True)


def group_answers(
    by_case: Mapping[str, Mapping[str, xr.Dataset]],
    groups: Mapping[str, Mapping[str, str]],
    pairs: Mapping[str, Sequence[str]],
) -> tuple[list[NamedGroup], list[str]]:
    """Return the answer of each group, and of each pair of faces, under each case, or a sentence without one.

    `by_case` has the statistics of each map by case ("" without cases) and name.
    """
    answers, omissions = [], []
    members = {**groups, **{pair: dict(zip(names, names, strict=True)) for pair, names in pairs.items()}}
    for (name, parts), (case, of_case) in product(members.items(), by_case.items()):
        solved = [map_ for map_ in parts if map_ in of_case]
        if not solved:
            continue
        maps, parts_solved = [of_case[map_] for map_ in solved], [parts[map_] for map_ in solved]
        try:
            result = group_statistics(
                maps, names=solved, parts=parts_solved, group=name, placements=name in pairs
            )
        except RoughContactError as error:
            omissions.append(f"{error}{f' (case {case})' if case else ''}")
        else:
            answers.append(NamedGroup(name, case or None, result))
    return answers, omissions


def comparisons(answers: Sequence[NamedGroup], same_area_pairs: Sequence[Sequence[str]] = ()) -> Comparisons:
    """Return the comparisons of every two groups under a case, and of the cases (`case_pairs`) of a group.

    Groups of the same areas are compared map by map, placements under two cases alone; with them comes a
    sentence for each that cannot be made.
    """
    found: list[Comparisons] = []
    for case in dict.fromkeys(group.case for group in answers):
        of_case = [group for group in answers if group.case == case and group.members.is_compared]
        answers_by_label = {group.label: group.answer for group in of_case}
        found.append(compare_all(answers_by_label, same_area_pairs=same_area_pairs))
    for name in dict.fromkeys(group.name for group in answers):
        answers_by_label = {group.label: group.answer for group in answers if group.name == name}
        if len(answers_by_label) > 1 and any(answer.sizes["map"] > 1 for answer in answers_by_label.values()):
            found.append(compare_all(answers_by_label, cases=case_pairs(list(answers_by_label))))
    return _joined(found)


def map_comparisons(
    by_case: Mapping[str, Mapping[str, xr.Dataset]],
    pairs: Mapping[str, Sequence[str]],
    same_area_pairs: Sequence[Sequence[str]],
) -> Comparisons:
    """Return the comparisons under each case of maps of a place, and of the first placement with the others.

    With them comes a sentence for each that cannot be made.
    """
    one_place = [*map(tuple, same_area_pairs)]
    of_faces = [(reference, partner) for reference, *partners in pairs.values() for partner in partners]
    found: list[Comparisons] = []
    for case, of_case in by_case.items():
        results, of_place = {}, set()
        for first, second in one_place + of_faces:
            if {first, second} <= of_case.keys():
                labels = name_under(first, case), name_under(second, case)
                results[labels] = of_case[first], of_case[second]
                of_place |= {labels} if (first, second) in one_place else set()
        found.append(compare_maps(results, of_place=of_place))
    return _joined(found)


def _joined(found: Sequence[Comparisons]) -> Comparisons:
    """Return all of some comparisons, and all sentences on those that cannot be made."""
    compared = {labels: result for results, _ in found for labels, result in results.items()}
    return compared, [reason for _, reasons in found for reason in reasons]


def _split_by_map(statistics: xr.Dataset, names: Collection[str]) -> dict[str, dict[str, xr.Dataset]]:
    """Return what groups and differences need of some solved maps, by case ("" without cases) and name."""
    bands = json_attribute(statistics.attrs, "bands")
    variables_needed = statistics[needed_for_groups(map(str, statistics.variables))].drop_attrs(deep=False)
    by_case: dict[str, dict[str, xr.Dataset]] = {}
    for labels, result in collect.solved_results(variables_needed):
        case, surface = labels.get("case", ""), labels["surface"]
        if surface in names:
            by_case.setdefault(case, {})[surface] = result.assign_attrs(bands[case][surface])
    return by_case


def budget_table(statistics: xr.Dataset) -> pd.DataFrame:
    """Return the components of every interval of the surfaces (and cases) of `collect_statistics`."""
    of_budget = statistics[[name for name in statistics.variables if name in TABLE_VARIABLES]]
    results = collect.solved_results(of_budget)
    tables = [uncertainty_table(data).assign(**labels) for labels, data in results]
    table = pd.concat(tables, ignore_index=True)
    return table.set_index([dim for dim in ("case", "surface") if dim in table]).reset_index()
