"""Some loads of a dataset of statistics, which checks read as they read the dataset."""

from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr


class SelectedLoads(Mapping[str, xr.Variable]):
    """Bare variables: a dataset finds and cuts one in twenty times as long."""

    def __init__(self, statistics: xr.Dataset, loads: list[int] | int):
        self._statistics, self._loads = statistics, loads
        self.attrs, self.sizes = statistics.attrs, {**statistics.sizes, "load": np.size(loads)}

    def __getitem__(self, name: str) -> xr.Variable:
        variable = self._statistics.variables[name]
        return variable[{"load": self._loads}] if "load" in variable.dims else variable

    def __iter__(self) -> Iterator[str]:
        return map(str, self._statistics.variables)

    def __len__(self) -> int:
        return len(self._statistics.variables)

    def isel(self, *, load: int) -> "SelectedLoads":
        """Return one of these loads."""
        return SelectedLoads(self._statistics, np.atleast_1d(self._loads)[load])


Statistics = xr.Dataset | SelectedLoads


def largest_of_loads(values: npt.ArrayLike) -> float:
    """Return the largest number of the loads at which it is known; NaN where at none.

    Examples
    --------
    >>> largest_of_loads([0.1, float("nan"), 0.3])
    0.3
    """
    # of the bare values: labelled ones take several times as long
    return float(np.fmax.reduce(np.asarray(values), axis=None))
