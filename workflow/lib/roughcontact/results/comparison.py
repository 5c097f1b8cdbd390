"""Comparison of two runs: the numbers that differ by more than their uncertainties."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.arguments.si import as_declared
from roughcontact.arguments.variables import VARIABLES
from roughcontact.errors import InputFileError, SettingsError
from roughcontact.results.collect import solved_results
from roughcontact.statistics.load_pairs import paired_loads

_LABELS = ("case", "surface")
# how a load was solved and judged, not results
_NOT_COMPARED = {
    *("iterations", "operator_applications", "error_bound", "rounding_floor", "max_penetration"),
    *("load_error", "converged", "verdict"),
}
_NOT_SOLVED = xr.Dataset({"mean_pressure": ("load", np.empty(0))})
_BUDGET = ("_uncertainty", "_lower", "_upper", "_parts")


@as_declared
def compare_statistics(before: xr.Dataset, after: xr.Dataset, *, share: float | None = None) -> pd.DataFrame:
    """Return which numbers of two files of statistics differ, and by how much they may.

    Without `share` a number that has an uncertainty is judged, by the E_n number of interlaboratory
    comparisons [1]_: it differs where its change is more than the root of the sum of the squares of both
    uncertainties. With `share` every number is judged, and differs where its change is more than that share
    of the larger of the two.

    Parameters
    ----------
    before, after : Dataset
        from `contact_statistics` or `collect_statistics`, both of one kind. Surfaces and cases belong
        together by name, loads by `statistics.load_pairs`.
    share : float, optional
        largest change allowed, over the number itself.

    Returns
    -------
    DataFrame
        a row for each number judged: `case` and `surface` where the files have them, `mean_pressure` (Pa, of
        the load before), `quantity`, `unit`, `before`, `after`, `allowed` (largest change) and `differs`. A
        load that only one of the files has is a row of its `mean_pressure`, NaN in the other. A number that
        the second file lacks has differed; one that only the second file has is not judged.

    Raises
    ------
    InputFileError
        where one file holds a single surface and the other several, or nothing in them can be judged.

    References
    ----------
    .. [1] ISO/IEC 17043:2023, Conformity assessment. General requirements for the competence of proficiency
       testing providers, annex B.

    Examples
    --------
    >>> import xarray as xr
    >>> def run(gap):
    ...     half_width = (("load", "source"), [[3e-9]])
    ...     data = {"mean_gap": ("load", [gap]), "mean_gap_uncertainty": half_width}
    ...     return xr.Dataset(data, coords={"mean_pressure": ("load", [1e6]), "source": ["combined"]})
    >>> compare_statistics(run(200e-9), run(204e-9))["differs"].tolist()
    [False]
    >>> compare_statistics(run(200e-9), run(205e-9))["differs"].tolist()
    [True]
    """
    if share is not None and not share >= 0:
        raise SettingsError(f"share = {share:g}: give a relative difference, 0 or more", keys=["share"])
    earlier, later = _surfaces(before), _surfaces(after)
    labels = [dim for dim in _LABELS if dim in before.dims]
    if labels != [dim for dim in _LABELS if dim in after.dims]:
        raise InputFileError(
            "one file holds a single surface, the other a whole run or several cases: compare two of a kind"
        )
    rows: list[dict[str, Any]] = []
    for name in dict.fromkeys([*earlier, *later]):
        for old, new in _pairs(earlier.get(name, _NOT_SOLVED), later.get(name, _NOT_SOLVED)):
            rows += [dict(zip(labels, name, strict=True)) | row for row in _judged(old, new, share)]
    if not rows:
        raise InputFileError(
            "nothing to compare: one of the files holds no ± (uncertainty: {sources: []} in its settings); "
            "give the share by which numbers may differ, 0.01"
        )
    columns = [*labels, "mean_pressure", "quantity", "unit", "before", "after", "allowed", "differs"]
    return pd.DataFrame(rows)[columns]


def _surfaces(statistics: xr.Dataset) -> dict[tuple[str, ...], xr.Dataset]:
    """Return the numbers of each surface by its labels, without the padding of shorter lists of loads."""
    return {tuple(labels.values()): result for labels, result in solved_results(statistics)}


def _pairs(earlier: xr.Dataset, later: xr.Dataset) -> Iterator[tuple[xr.Dataset, xr.Dataset]]:
    """Yield the loads of both that belong together; one without a partner comes with an empty dataset."""
    # by the one rule for all comparisons
    partners = dict(zip(*(indices.tolist() for indices in paired_loads(earlier, later)), strict=True))
    for index in range(earlier.sizes["load"]):
        partner = later.isel(load=partners[index]) if index in partners else xr.Dataset()
        yield earlier.isel(load=index), partner
    for index in {*range(later.sizes["load"])} - {*partners.values()}:
        yield xr.Dataset(), later.isel(load=index)


def _judged(old: xr.Dataset, new: xr.Dataset, share: float | None) -> Iterator[dict[str, Any]]:
    """Yield a row for each number of a load that can be judged, or one for a load without a partner."""
    pressures = [float(side["mean_pressure"]) if "mean_pressure" in side else np.nan for side in (old, new)]
    if np.isnan(pressures).any():
        yield _row(np.nanmax(pressures), "mean_pressure", *pressures, tolerance=0.0)
        return
    for name in _numbers(old):
        values = float(old[name]), float(new.get(name, np.nan))
        if share is not None:
            # a stated share counts for both values alike
            yield _row(pressures[0], name, *values, tolerance=share * max(map(abs, values)))
        elif f"{name}_uncertainty" in old and name not in new:
            yield _row(pressures[0], name, *values, tolerance=_half_width(old, name, values[0]))
        elif f"{name}_uncertainty" in old and f"{name}_uncertainty" in new:
            # two independent results: their half-widths add in squares
            tolerance = float(np.hypot(_half_width(old, name, values[1]), _half_width(new, name, values[0])))
            yield _row(pressures[0], name, *values, tolerance=tolerance)


def _numbers(old: xr.Dataset) -> list[str]:
    """Return the names of the numbers that describe the surface."""
    return [
        name
        for name in map(str, old.data_vars)
        if not old[name].dims
        and old[name].dtype.kind in "fiu"
        and name not in _NOT_COMPARED
        and not name.endswith(_BUDGET)
    ]


def _half_width(side: xr.Dataset, name: str, value: float) -> float:
    """Return the half-width of a number's interval on the side of the other run's number."""
    bound = f"{name}_upper" if value > float(side[name]) else f"{name}_lower"
    if bound in side:
        reach = abs(float(side[bound]) - float(side[name]))
        # an interval that the map does not bound upwards holds all that is more
        return np.inf if np.isnan(reach) and np.isfinite(side[f"{name}_lower"]) else reach
    return float(side[f"{name}_uncertainty"].sel(source="combined"))


def _row(pressure: float, name: str, before: float, after: float, *, tolerance: float) -> dict[str, Any]:
    """Return one row of the table."""
    is_equal = before == after or (np.isnan(before) and np.isnan(after))  # NaN in both is no difference
    change = abs(after - before)
    return {
        "mean_pressure": pressure,
        "quantity": name,
        "unit": VARIABLES[name][0] if name in VARIABLES else "1",
        "before": before,
        "after": after,
        "allowed": tolerance,
        "differs": bool(not is_equal and not (change <= tolerance and np.isfinite(change))),
    }
