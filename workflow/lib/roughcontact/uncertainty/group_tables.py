"""Groups of maps, and their comparisons, as one dataset and as tables."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.arguments.answers import ENDS
from roughcontact.arguments.measurement import json_attribute, json_attributes
from roughcontact.uncertainty.differences import COMPARED
from roughcontact.uncertainty.members import MEMBERS, Members
from roughcontact.uncertainty.scales import headline_names

_ENDINGS = ("", *(f"{key}{suffix}" for key in ("", "_next", "_next_part") for suffix in ENDS[1:]))


class NamedGroup(NamedTuple):
    """The answer of a group, under a case."""

    name: str  # of the group, or of the pair of faces
    case: str | None  # None in a run without cases
    answer: xr.Dataset  # from `group_statistics`

    @property
    def label(self) -> str:
        """The name, with that of the case where there are cases."""
        return self.name if self.case is None else f"{self.name} · {self.case}"

    @property
    def members(self) -> Members:
        """What its maps are to one another."""
        return MEMBERS[self.answer.attrs["members"]]


def joined_groups(groups: Sequence[NamedGroup]) -> xr.Dataset:
    """Return the answers of several groups in one dataset ([case,] group, load, map, source, component).

    Groups of fewer maps or loads are padded with NaN; `remarks` is JSON, by case ("" for none) and group.

    Examples
    --------
    >>> from roughcontact.uncertainty.groups import group_statistics
    >>> one = xr.Dataset({"mean_gap": ("load", [2e-6]), "mean_pressure": ("load", [1e6])})
    >>> other = one.assign(mean_gap=2 * one["mean_gap"])
    >>> found = joined_groups([NamedGroup("ground", None, group_statistics([one, other]))])
    >>> found["mean_gap_of_maps"].dims, found["maps"].values.tolist()
    (('group', 'load', 'map'), [2.0])
    """
    names = list(dict.fromkeys(group.name for group in groups))
    cases = list(dict.fromkeys(group.case for group in groups)) or [None]
    sizes = {dim: max((group.answer.sizes[dim] for group in groups), default=0) for dim in ("load", "map")}
    columns: dict[str, tuple[tuple[str, ...], np.ndarray]] = {}
    remarks: dict[str, dict[str, list[str]]] = {case or "": {} for case in cases}
    for group in groups:
        position = cases.index(group.case), names.index(group.name)
        remarks[group.case or ""][group.name] = json_attribute(group.answer.attrs, "remarks")
        numbers = group.answer.reset_coords()
        numbers = numbers.drop_vars(["source", "component", "map", "content"]).assign(
            map_name=("map", group.answer["map"].values), maps=group.answer.sizes["map"]
        )
        for name, variable in numbers.transpose("load", "map", "source", "component").data_vars.items():
            text = variable.dtype.kind not in "fiu"
            full = tuple(sizes.get(str(dim), variable.sizes[dim]) for dim in variable.dims)
            shape = (len(cases), len(names), *full)
            empty = np.full(shape, "", object) if text else np.full(shape, np.nan)
            _, values = columns.setdefault(str(name), (("case", "group", *map(str, variable.dims)), empty))
            corner: tuple[int | slice, ...] = (*position, *(slice(size) for size in variable.shape))
            values[corner] = variable.values
    labels = {f"group{suffix}": ("group", np.array(names, object)) for suffix in ("", "_name")}
    labels |= {f"case{suffix}": ("case", np.array(cases, object)) for suffix in ("", "_name")}
    if groups:
        labels |= {dim: (dim, groups[0].answer[dim].values.astype(object)) for dim in ("source", "component")}
    result = xr.Dataset(columns, labels, json_attributes({"remarks": remarks}))
    result = result.set_coords([name for name in ("mean_pressure", "map_name", "part") if name in result])
    return result if cases != [None] else result.isel(case=0, drop=True)


def groups_table(groups: Sequence[NamedGroup]) -> pd.DataFrame:
    """Return one row for each group (, case) and load, in SI units, with `{quantity}` and its ends.

    They also stand for the next map (`..._next_lower`) and the next part (`..._next_part_lower`).
    """
    rows = []
    for name, case, answer in groups:
        head: dict[str, Any] = {} if case is None else {"case": case}
        head |= {"group": name, "maps": answer.sizes["map"], "parts": len(set(answer["part"].values))}
        names = [f"{quantity}{ending}" for quantity in headline_names(answer) for ending in _ENDINGS]
        for index, load in enumerate(answer["mean_pressure"].values):
            row = head | {"mean_pressure_Pa": load}
            rows.append(row | {column: answer[column].values[index] for column in names})
    return pd.DataFrame(rows, columns=None if rows else ["group", "maps", "parts", "mean_pressure_Pa"])


def comparisons_table(comparisons: Mapping[tuple[str, str], xr.Dataset]) -> pd.DataFrame:
    """Return one row for each comparison (by the names of both, as of `compare_all`), quantity and load."""
    rows = [
        {"first": reference, "second": partner, "quantity": quantity, "mean_pressure_Pa": load}
        | {key: comparison[key].values[row, column] for key in COMPARED}
        for (reference, partner), comparison in comparisons.items()
        for row, quantity in enumerate(comparison["quantity"].values)
        for column, load in enumerate(comparison["mean_pressure"].values)
    ]
    return pd.DataFrame(rows, columns=["first", "second", "quantity", "mean_pressure_Pa", *COMPARED])
