"""Statistics with loads selected by their pressure, for one surface or all surfaces of a run."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from xarray.indexes import PandasIndex

from roughcontact.errors import InputFileError
from roughcontact.results.storage import read_dataset

# what `Index.sel` returns: the type has no public name, so that one of xarray's own indexes is asked
_Selection: Any = type(PandasIndex([0.0], "load").sel({"load": 0.0}))


def read_statistics(path: str | Path) -> xr.Dataset:
    """Read a file of statistics, ready for `.sel(mean_pressure=..., method="nearest")`.

    Each surface may have been solved at pressures of its own: of several surfaces each gives its own load.

    Parameters
    ----------
    path : str or Path
        `statistics.nc` of one surface, or that of a run.

    Returns
    -------
    Dataset
        what `read_dataset` returns, with an index on `mean_pressure`.

    Raises
    ------
    InputFileError
        where the file is missing, damaged, no netCDF file, or without loads.

    Examples
    --------
    >>> import tempfile
    >>> import xarray as xr
    >>> from roughcontact.results.storage import write_dataset
    >>> loads = {"surface": ["ground", "turned"]}
    >>> loads["mean_pressure"] = (("surface", "load"), [[1e6, 2e6], [3e6, 4e6]])
    >>> gaps = xr.Dataset({"mean_gap": (("surface", "load"), [[4e-7, 3e-7], [2e-7, 1e-7]])}, coords=loads)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_dataset(gaps, f"{folder}/statistics.nc")
    ...     statistics = read_statistics(f"{folder}/statistics.nc")
    >>> statistics.sel(mean_pressure=2.2e6, method="nearest")["mean_gap"].values
    array([3.e-07, 2.e-07])
    >>> statistics.sel(surface="turned").sel(mean_pressure=4e6)["mean_gap"].item()
    1e-07
    """
    statistics = read_dataset(path)
    if "mean_pressure" not in statistics.coords:
        raise InputFileError(f"{path}: has no loads (mean_pressure): is no file of statistics")
    return statistics.set_xindex("mean_pressure", _MeanPressureIndex)


class _MeanPressureIndex(xr.Index):
    """Places of loads by their mean pressure, which may differ between surfaces and cases.

    `name`: of the coordinate; `pressures` (..., load) in Pa: NaN where a list of loads is padded.
    """

    def __init__(self, name: Any, pressures: xr.Variable):
        self.name, self.pressures = name, pressures

    @classmethod
    def from_variables(
        cls, variables: Mapping[Any, xr.Variable], *, options: Mapping[str, Any]
    ) -> "_MeanPressureIndex":
        """Return the index of the one coordinate that is given."""
        ((name, pressures),) = variables.items()
        return cls(name, pressures)

    def create_variables(self, variables: Mapping[Any, xr.Variable] | None = None) -> dict[Any, xr.Variable]:
        """Return the coordinate, or the remaining part of it."""
        return {self.name: self.pressures}

    def isel(self, indexers: Mapping[Any, Any]) -> "_MeanPressureIndex | None":
        """Return the index of a part; None where a single load is left."""
        # a selection by another dimension leaves loads as they are
        pressures = self.pressures.isel(
            {dim: indexer for dim, indexer in indexers.items() if dim in self.pressures.dims}
        )
        return _MeanPressureIndex(self.name, pressures) if "load" in pressures.dims else None

    def sel(self, labels: dict[Any, Any], method: str | None = None, tolerance: float | None = None) -> Any:
        """Return the place of the load at one pressure, or at several, for each surface."""
        ((name, label),) = labels.items()
        if method not in (None, "nearest"):
            raise ValueError(f'{name}: method = {method!r} is not one of None, "nearest"')
        pressures = np.asarray(label, float)
        if pressures.ndim > 1:
            raise ValueError(f"{name}: give a pressure or a list of them, not a table")
        requested_variable = xr.Variable(["asked"] if pressures.ndim else [], pressures)
        distances = abs(self.pressures - requested_variable).fillna(np.inf)
        max_distance = 0.0 if method is None else np.inf if tolerance is None else float(tolerance)
        if not (distances.min("load") <= max_distance).all():
            solved_pressures = np.unique(self.pressures.values[np.isfinite(self.pressures.values)])
            loads_text = ", ".join(f"{pressure:.6g}" for pressure in solved_pressures)
            raise KeyError(f'{name} = {label} Pa is none of the loads {loads_text}; try method="nearest"')
        nearest = distances.argmin("load")
        if pressures.ndim:
            nearest = xr.Variable(["load" if dim == "asked" else dim for dim in nearest.dims], nearest.values)
        elif not nearest.ndim:
            return _Selection({"load": int(nearest)})
        return _Selection({"load": nearest})

    def equals(self, other: xr.Index, **_: Any) -> bool:
        """Return whether another index holds the same pressures."""
        return isinstance(other, _MeanPressureIndex) and self.pressures.equals(other.pressures)
