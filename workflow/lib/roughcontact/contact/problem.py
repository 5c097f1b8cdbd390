"""From a labelled map to a dimensionless problem, with all checks of the map."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from roughcontact.checking import LARGEST, SMALLEST, check_labelled
from roughcontact.errors import HeightMapError
from roughcontact.kernels.arrays import DOUBLE, SINGLE, Array, in_precision, like_array
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.waves import gradient_of
from roughcontact.maps import spacing

_Labelled = TypeVar("_Labelled", xr.DataArray, xr.Variable)


@dataclass(frozen=True)
class Problem:
    """The heights of a map, and the units that make them dimensionless: H = (h - h_ref)/(g L).

    H is never made for all of the map in double precision: it would fill memory.
    """

    heights: Array  # (ny, nx), m
    spacing: tuple[float, float]  # (dy, dx), m
    reference: float  # h_ref, m: the middle of the heights, subtracted first to preserve digits
    gradient: float  # g, the spectral rms gradient, 0 of a flat map; E* g is the unit of pressure

    @property
    def lengths_in_metres(self) -> tuple[float, float]:
        """(Ly, Lx) of the periodic cell, m."""
        return self.heights.shape[0] * self.spacing[0], self.heights.shape[1] * self.spacing[1]

    @property
    def unit_length(self) -> float:
        """L = sqrt(Lx Ly), m."""
        return math.sqrt(math.prod(self.lengths_in_metres))

    @property
    def lengths(self) -> tuple[float, float]:
        """(Ly, Lx)/L."""
        ly, lx = self.lengths_in_metres
        return ly / self.unit_length, lx / self.unit_length

    @property
    def scale(self) -> float:
        """The unit of height g L, m; 1 of a flat map."""
        return self.gradient * self.unit_length or 1.0

    @property
    def flat(self) -> bool:
        """Whether the map has no gradient: then there is nothing to solve."""
        return self.gradient == 0.0


def nondimensionalise(
    window: xr.DataArray,
    *,
    precision: str = DOUBLE,
    arrays: Callable[[np.ndarray], Any] | None = None,
    threads: int = 1,
) -> Problem:
    """Return the dimensionless problem of a map (y, x; m), in the library that `arrays` brings it into.

    Its heights are not copied where they can be used as they are, and are in double precision unless map and
    result are in single precision.
    """
    labelled_heights, window = check_labelled(window).data, on_host(window)
    steps = spacing(window)
    dtype = np.float32 if precision == SINGLE and window.dtype == np.float32 else np.float64
    heights = np.require(window.values, dtype=dtype, requirements=["C", "A", "W"])
    if window.data is not labelled_heights:
        heights = like_array(heights, labelled_heights)
    if arrays is not None:
        heights = arrays(heights)
    lowest, highest, missing = kernels_for(heights, threads=threads).extent(heights)
    if missing:
        raise HeightMapError(
            f"{missing} of {window.size} heights are missing or infinite; fill or crop them first "
            "(level fills holes, periodic_window crops missing edges)"
        )
    heights_reach = max(abs(lowest), abs(highest))
    if heights_reach > LARGEST or not SMALLEST <= min(steps) <= max(steps) <= LARGEST:
        raise HeightMapError(
            f"heights of up to {heights_reach:g} m on pixels of {steps[1]:g} m x {steps[0]:g} m are beyond "
            "the computable range; check the units"
        )
    gradient = gradient_of(in_precision(heights, DOUBLE, copy=False), steps, threads=threads)
    if highest > lowest and not SMALLEST <= gradient <= LARGEST:
        raise HeightMapError(
            f"heights from {lowest:g} m to {highest:g} m have an rms gradient of {gradient:g}, beyond the "
            "computable range; check the units"
        )
    return Problem(heights, steps, reference=0.5 * (lowest + highest), gradient=gradient)


def on_host(array: _Labelled) -> _Labelled:
    """Return `array` with its values in a NumPy array, whatever library and device they are of.

    It is returned as it is where nothing has to be copied.
    """
    return array if isinstance(array.data, np.ndarray) else array.as_numpy()
