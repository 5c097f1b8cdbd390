"""Profiles in the table of surfaces: those along a lay are solved with those across it in their group."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from roughcontact.arguments.profiles.lays import MAX_POINTS, lay_facts
from roughcontact.errors import SettingsError
from roughcontact.study.table.columns import BEFORE, GROUP, PAIR, REPEAT
from roughcontact.study.table.row import Surface, in_cell
from roughcontact.study.table.same_area import same_area_pairs


def mistakes_in_profiles(surfaces: Mapping[str, Surface]) -> Iterator[SettingsError]:
    """Yield what is wrong with profiles along a lay, which serve those across it alone."""
    groups = {row.group for row in _with_lay(surfaces, "across")} - {""}
    of_same_area = {name for pair in same_area_pairs(surfaces) for name in pair}
    for row in _with_lay(surfaces, "along"):
        if row.group not in groups:
            yield in_cell(
                row,
                "lay",
                "lay = along: a profile along the lay runs on one ridge and shows nothing of the others; "
                f"give it the {GROUP} of profiles with lay = across",
            )
        if row.name in of_same_area or row.faces:
            text = f"lay = along: {row.name} is not solved by itself; leave {PAIR}, {REPEAT} and {BEFORE} out"
            yield in_cell(row, "lay", text)


def with_profiles(surfaces: Mapping[str, Surface]) -> dict[str, Surface]:
    """Return the rows without profiles along a lay, which those across it in their group are given.

    Those of which a surface behind them is solved have its points.
    """
    along: dict[str, list[dict[str, Any]]] = {}
    remaining_rows = {**surfaces}
    for row in _with_lay(surfaces, "along"):
        arguments = row.read_arguments | {"path": str(row.path), "lay": "across"}
        along.setdefault(row.group, []).append(arguments)
        del remaining_rows[row.name]
    sizes = Counter(row.group for row in remaining_rows.values())
    for row in _with_lay(surfaces, "across"):
        if row.group in along:
            arguments = row.read_arguments | {"along": along[row.group]}
            group = row.group if sizes[row.group] > 1 else ""  # of a single surface there is no group
            remaining_rows[row.name] = replace(row, read_arguments=arguments, group=group)
    for name, row in remaining_rows.items():
        if lay_facts(row.read_arguments).has_surface_behind or "along" in row.read_arguments:
            remaining_rows[name] = replace(row, min_points=MAX_POINTS**2)
    return remaining_rows


def _with_lay(surfaces: Mapping[str, Surface], lay: str) -> list[Surface]:
    """Return the rows of profiles in a direction to the lay."""
    return [row for row in surfaces.values() if row.read_arguments.get("lay") == lay]
