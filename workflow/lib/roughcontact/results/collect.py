"""All surfaces (and cases) of a run in one dataset and one table."""

import json
import re
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NotRequired, TypedDict

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.arguments.answers import ANSWERS, AREA, ENDS, answer_name
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.variables import VARIABLES
from roughcontact.errors import SettingsError
from roughcontact.results.storage import check_origin, read_dataset
from roughcontact.statistics.outcome import VERDICTS
from roughcontact.statistics.precision import relative_half_width

_BINS = ("pressure_bin", "gap_bin", "patch_bin")
_COORDINATES = (
    *("mean_pressure", "profile_depth", "interface_depth"),
    *(f"{bins}_{value}" for bins in _BINS for value in ("centre", "bounds")),
)
_LEADING = ("mean_pressure", "relative_pressure", AREA, f"{AREA}_pixels")
_OF_ROWS = ("case", "surface", "load")  # dimensions of a table
# labels of a dimension that are the same for all surfaces
_COMMON_LABELS = dict.fromkeys(("source", "input", "component"), object)
_COMMON_LABELS |= dict.fromkeys(("hardness_over_modulus", "tangential_load"), float)
# attributes of each file
_BANDS = ("band_shortest", "band_longest", "band_reason", "corrected_for", "measured_by", "stresses_of")
_VALUES = ("value", "lower", "upper")
_WHOLE_NUMBERS = ("contact_clusters", "iterations", "converged", "gap_percolates_x", "gap_percolates_y")
_VERDICT_WORDS = np.array(list(VERDICTS.values()), object)


class Entry(TypedDict):
    """The file of statistics of a surface (and case), beside which are all others of the result."""

    surface: str
    case: str | None
    statistics: str | Path
    origin: NotRequired[str]  # which the file must have (`check_origin`)


class Failure(TypedDict):
    """A surface and case without results, and the reason."""

    surface: str
    case: str | None
    reason: str


def result_entry(result: str, statistics: str | Path, origin: str = "") -> Entry:
    """Return the entry of a result, named by its folder: "ground", or "soft/ground" under a case."""
    case, _, surface = result.rpartition("/")
    return Entry(surface=surface, case=case or None, statistics=statistics, origin=origin)


def file_of(entry: Entry, name: str) -> Path:
    """Return the path of another file of a result."""
    return Path(entry["statistics"]).with_name(name)


def collect_statistics(entries: Sequence[Entry]) -> xr.Dataset:
    """Return the statistics of all surfaces (and cases) in one dataset ([case,] surface, load, ...).

    Shorter lists of loads and bins are padded with NaN; `mean_pressure` and the bins depend on the surface.
    The attributes are JSON: `source_sha256` by surface, `verdicts`, `reasons` and `bands` by case ("" for
    none) and surface.
    """
    surfaces = list(dict.fromkeys(entry["surface"] for entry in entries))
    cases = list(dict.fromkeys(entry["case"] for entry in entries))
    datasets: dict[tuple[int, int], xr.Dataset] = {}
    checksums = {}
    attributes: dict[str, dict[str, dict[str, Any]]] = {case or "": {} for case in cases}
    for entry in entries:
        statistics = read_dataset(entry["statistics"])
        check_origin(statistics.attrs, entry["statistics"], entry.get("origin", ""))
        datasets[cases.index(entry["case"]), surfaces.index(entry["surface"])] = statistics
        checksums[entry["surface"]] = statistics.attrs.get("source_sha256", "")
        attributes[entry["case"] or ""][entry["surface"]] = statistics.attrs
    # times of creep may differ from case to case: each has its own place
    times = sorted(
        {time for dataset in datasets.values() if "time" in dataset for time in dataset["time"].values}
    )
    datasets = {
        position: dataset.reindex(time=times) if "time" in dataset else dataset
        for position, dataset in datasets.items()
    }
    sizes: dict[Hashable, int] = {}
    dims: dict[Hashable, tuple[Hashable, ...]] = {}
    for dataset in datasets.values():
        sizes |= {dim: max(size, sizes.get(dim, 0)) for dim, size in dataset.sizes.items()}
        dims |= {name: array.dims for name, array in dataset.variables.items()}
    columns = {}
    for name, names_of_dim in dims.items():
        # the coordinate of a dimension cannot vary by surface
        if name in sizes and name != "depth":
            continue
        # padding of shorter lists of loads, and of surfaces without this number
        values = np.full((len(cases), len(surfaces), *(sizes[dim] for dim in names_of_dim)), np.nan)
        for position, dataset in datasets.items():
            if name in dataset.variables:
                array = dataset.variables[name]
                values[(*position, ...)][tuple(map(slice, array.shape))] = array.values
        # depths differ from surface to surface: a coordinate, no dimension
        columns["profile_depth" if name == "depth" else name] = (("case", "surface", *names_of_dim), values)
    coordinates = _labels("surface", surfaces) | ({"time": times} if times else {})
    result = xr.Dataset(columns, coords=coordinates)
    result = result.set_coords([name for name in _COORDINATES if name in columns])
    for name, label_kind in _COMMON_LABELS.items():
        labels = [dataset[name].values for dataset in datasets.values() if name in dataset.variables]
        # cases may state other tangential loads
        if labels and all(np.array_equal(labels[0], labels_of_file) for labels_of_file in labels):
            result = result.assign_coords({name: labels[0].astype(label_kind)})
    result.attrs["source_sha256"] = json.dumps(checksums, sort_keys=True)
    selectors: dict[str, Callable[[Mapping[str, Any]], Any]] = {
        "verdicts": lambda attrs: json.loads(attrs["verdicts"]),
        "reasons": lambda attrs: json.loads(attrs["reasons"]),
        "bands": lambda attrs: {key: attrs[key] for key in _BANDS if key in attrs},
    }
    for name, pick in selectors.items():
        with suppress(KeyError):  # of files without verdicts
            by_case = {
                case: {surface: pick(attrs) for surface, attrs in by_surface.items()}
                for case, by_surface in attributes.items()
            }
            # floats of NumPy are no JSON
            result.attrs[name] = json.dumps(by_case, default=float, ensure_ascii=False)
    if cases == [None]:
        return result.isel(case=0)
    return result.assign_coords(_labels("case", cases))


def _labels(dim: str, names: Sequence[str | None]) -> dict[str, Any]:
    """Return the names along a dimension: its own coordinate, for `.sel`, and one that is kept by `.isel`."""
    values = (dim, np.array(names, dtype=object))
    return {dim: values, f"{dim}_name": values}


def table(statistics: xr.Dataset) -> pd.DataFrame:
    """Return statistics as a table: one row per load (of each surface and case), the columns of summary.csv.

    Parameters
    ----------
    statistics : Dataset
        of one surface, as `evaluate` or `contact_statistics` return them, or of a run.

    Returns
    -------
    DataFrame
        plain numbers, in columns named with their unit, ``mean_gap_m``; `surface` and `case` where there are
        any.

    Raises
    ------
    SettingsError
        where loads were selected from statistics with verdicts, and for anything else than statistics.

    Examples
    --------
    >>> gaps = xr.Dataset({"mean_gap": ("load", [3e-7, 2e-7])}, {"mean_pressure": ("load", [1e6, 2e6])})
    >>> print(table(gaps).to_string(index=False))
     mean_pressure_Pa   mean_gap_m
            1000000.0 3.000000e-07
            2000000.0 2.000000e-07
    """
    if "load" not in statistics.dims or {"map", "y", "x"} & {*statistics.dims}:
        raise SettingsError(
            "table: give statistics with the dimension load, as of evaluate or contact_statistics"
        )
    statistics = statistics.drop_indexes("mean_pressure", errors="ignore")
    single = "surface" not in statistics.coords
    if single:  # the attributes of a run are by case and surface
        attributes = {"verdicts": json_attribute(statistics.attrs, "verdicts"), "bands": statistics.attrs}
        texts = {
            key: json.dumps({"": {"": value}}, default=str) for key, value in attributes.items() if value
        }
        statistics = statistics.assign_coords(surface="").assign_attrs(texts)
    for dim in ("surface", "case"):  # one of them may be selected
        if dim in statistics.coords and dim not in statistics.dims:
            names = [str(statistics[dim].item())]
            statistics = statistics.drop_vars([dim, f"{dim}_name"], errors="ignore").expand_dims(dim)
            statistics = statistics.assign_coords(_labels(dim, names))
    frame = summary_table(statistics)
    return frame.drop(columns="surface") if single else frame


def summary(result: xr.Dataset) -> pd.DataFrame:
    """Return what a load is asked for, each quantity with its 95 % interval in a row of its own.

    Parameters
    ----------
    result : Dataset
        of one surface, as `evaluate` returns it, or of a run.

    Returns
    -------
    DataFrame
        a row for each `quantity` and `load` (mean pressure in Pa, of a body of finite size the force in N):
        `value`, `lower` and `upper` in the unit of the variable, `known` (larger half-width over the value,
        NaN where nothing bounds it) and `verdict` (use, review, do not use) on what the quantity belongs to;
        `surface`, `case` and, of bodies that creep, `time` (s) where there are any.

    Raises
    ------
    SettingsError
        for statistics without intervals and verdicts.

    Examples
    --------
    >>> from roughcontact.arguments.variables import describe
    >>> gaps = {"mean_gap": 3e-7, "mean_gap_lower": 2e-7, "mean_gap_upper": 3.5e-7, "verdict": 0}
    >>> loads = {"mean_pressure": ("load", [1e6])}
    >>> result = xr.Dataset({name: ("load", [value]) for name, value in gaps.items()}, loads)
    >>> print(summary(result).round(3).to_string(index=False))
    quantity      load  value  lower  upper  known verdict
    mean_gap 1000000.0    0.0    0.0    0.0  0.333     use
    """
    frames = []
    for labels, statistics in solved_results(result):
        loads = statistics["force" if "force" in statistics else "mean_pressure"].values
        # numbers of each load, and time, alone: densities and profiles have no interval
        crept = [name for name, variable in statistics.items() if "time" in variable.dims]
        times = [(time, statistics[crept].sel(time=time)) for time in statistics.get("time", ())]
        for time, numbers in ((None, statistics), *times):
            of_loads = [str(name) for name, variable in numbers.items() if variable.dims == ("load",)]
            for name in of_loads:
                if {f"{name}_lower", f"{name}_upper"} <= {*numbers} and "verdict" in statistics:
                    verdict = statistics.get(f"{answer_name(name)}_verdict", statistics["verdict"])
                    values = [numbers[f"{name}{suffix}"].values for suffix in ENDS]
                    columns = {"quantity": name, "load": loads, **dict(zip(_VALUES, values, strict=True))}
                    columns |= {"known": relative_half_width(*values)}
                    columns |= {"verdict": _VERDICT_WORDS[verdict.astype(int)]}
                    of_time = {} if time is None else {"time": float(time)}
                    frames.append(pd.DataFrame(labels | columns | of_time))
    if not frames:
        raise SettingsError(
            "summary: the dataset has no interval with a verdict; give the result of evaluate, with its "
            "uncertainty, or of read_statistics"
        )
    return pd.concat(frames, ignore_index=True)


def summary_table(statistics: xr.Dataset) -> pd.DataFrame:
    """Return one row per (case,) surface and load of `collect_statistics`, each column named with its unit.

    Without densities; the last columns are verdicts, `reasons` joined by " | ", and `corrected_for`.
    """
    statistics = _add_budget_columns(statistics).drop_vars(["surface", "case"], errors="ignore")
    names = [
        name
        for name in map(str, statistics.variables)
        # verdicts stand there in words
        if not name.endswith(("_name", "_estimate", "verdict"))
        and {*statistics.variables[name].dims} <= {*_OF_ROWS}
    ]
    names.sort(key=lambda name: _LEADING.index(name) if name in _LEADING else len(_LEADING))
    order = [dim for dim in _OF_ROWS if dim in statistics.dims]
    columns = statistics[names].reset_coords().to_dataframe(dim_order=order).reset_index()
    labels = [dim for dim in ("case", "surface") if f"{dim}_name" in statistics.coords]
    frame = pd.DataFrame({dim: statistics[f"{dim}_name"].values[columns[dim]] for dim in labels})
    # of a source, or of a time
    variables = {name: re.sub(r"_from_\w+$|_[\d.e+-]+s$", "", name) for name in names}
    units = {name: (VARIABLES.get(name) or VARIABLES[variable])[0] for name, variable in variables.items()}
    numbers = {column_name(name, unit): columns[name].to_numpy() for name, unit in units.items()}
    frame = pd.concat([frame, pd.DataFrame(numbers)], axis="columns")
    real = np.isfinite(columns["mean_pressure"].to_numpy())
    frame = frame[real].reset_index(drop=True)
    cases = frame["case"] if "case" in frame else [""] * len(frame)
    if "verdicts" in statistics.attrs:
        verdicts = json_attribute(statistics.attrs, "verdicts")
        rows = [*zip(cases, frame["surface"], columns["load"][real], strict=True)]
        # verdicts are stored by position
        if len(rows) != sum(len(verdicts[case][surface]) for case, surface in {row[:2] for row in rows}):
            raise SettingsError(
                "the verdicts are of other loads: select rows of the table, not loads before it"
            )
        verdict_rows = [verdicts[case][surface][load] for case, surface, load in rows]
        for name in filter(statistics.__contains__, (f"{answer}_verdict" for answer in ANSWERS)):
            codes = statistics[name].transpose(*order).values.ravel()[real]
            frame[name] = _VERDICT_WORDS[codes.astype(int)]
        frame["verdict"] = [verdict for verdict, _ in verdict_rows]
        frame["reasons"] = [" | ".join(reasons) for _, reasons in verdict_rows]
    # padding made counts and flags floating; where none is missing they are whole numbers again
    for name in _WHOLE_NUMBERS:
        if name in frame and frame[name].notna().all():
            frame[name] = frame[name].astype(int)
    bands = json_attribute(statistics.attrs, "bands")
    corrections = [
        bands.get(c, {}).get(s, {}).get("corrected_for") for c, s in zip(cases, frame["surface"], strict=True)
    ]
    return frame.assign(corrected_for=corrections) if any(corrections) else frame


def _add_budget_columns(statistics: xr.Dataset) -> xr.Dataset:
    """Return the statistics with the error budget as columns: combined, and of the area by source.

    What has crept has columns of each time.
    """
    if "time" in statistics.dims:
        crept = [name for name, variable in statistics.items() if "time" in variable.dims]
        after = {
            f"{name}_{time:.12g}s": statistics[name].isel(time=index, drop=True)
            for index, time in enumerate(statistics["time"].values)
            for name in crept
        }
        statistics = statistics.drop_dims("time").assign(after)
    if "source" not in statistics.dims:
        return statistics
    columns = {
        name: statistics[name].sel(source="combined", drop=True)
        for name, variable in statistics.variables.items()
        if "source" in variable.dims and str(name).endswith("_uncertainty")
    }
    area = statistics["relative_contact_area_uncertainty"]
    for source in statistics["source"].drop_sel(source="combined").values:
        columns[f"{area.name}_from_{source}"] = area.sel(source=source, drop=True)
    return statistics.drop_dims("source").assign(columns)


def column_name(name: str, unit: str | None) -> str:
    """Return the name of a column of a table: that of its variable, and the unit.

    Examples
    --------
    >>> column_name("gas_conductance", "W m-2 K-1"), column_name("mean_gap", "m"), column_name("Str", "1")
    ('gas_conductance_W_per_m2_K', 'mean_gap_m', 'Str')
    """
    factors = [] if unit in (None, "1") else str(unit).split()
    above = [factor for factor in factors if "-" not in factor]
    below = [factor.removesuffix("-1").replace("-", "") for factor in factors if "-" in factor]
    return "_".join([name, *above, *(["per", *below] if below else [])])


def solved_results(statistics: xr.Dataset) -> Iterator[tuple[dict[str, str], xr.Dataset]]:
    """Yield labels (`case` and `surface`, as far as there are any) and statistics of each solved surface."""
    dims = [dim for dim in ("case", "surface") if dim in statistics.dims]
    for index in np.ndindex(*(statistics.sizes[dim] for dim in dims)):
        result = statistics.isel(dict(zip(dims, index, strict=True)))
        is_solved = np.isfinite(result["mean_pressure"].values)  # the others are padding
        if is_solved.any():
            labels = {dim: str(result[f"{dim}_name"].values) for dim in dims}
            yield labels, result if is_solved.all() else result.isel(load=is_solved)


def append_failures(summary: pd.DataFrame, failures: Sequence[Failure]) -> pd.DataFrame:
    """Return the table with a last row for each failure, of verdict "failed" and without numbers."""
    if not failures:
        return summary
    rows = pd.DataFrame(failures).rename(columns={"reason": "reasons"}).assign(verdict="failed")
    rows = rows if "case" in summary else rows.drop(columns="case")
    return pd.concat([summary, rows], ignore_index=True)
