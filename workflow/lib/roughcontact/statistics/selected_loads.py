"""Some loads of a dataset of statistics, which checks read as they read the dataset."""

import numpy as np
import numpy.typing as npt
import xarray as xr


class SelectedLoads(dict[str, xr.Variable]):
    """Bare variables: a dataset finds one in twenty times as long."""

    def __init__(self, statistics: xr.Dataset, loads: list[int]):
        for name, variable in statistics.variables.items():
            self[str(name)] = variable[{"load": loads}] if "load" in variable.dims else variable
        self.attrs, self.sizes = statistics.attrs, {**statistics.sizes, "load": len(loads)}


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
