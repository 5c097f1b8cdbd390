"""From a labelled map to a dimensionless problem, with all checks of the map."""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import LARGEST, SMALLEST, check_labelled
from roughcontact.arguments.maps import spacing
from roughcontact.errors import HeightMapError, HeightMapWarning
from roughcontact.kernels.arrays import DOUBLE, SINGLE, Array, as_precision, like_array
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.waves import spectral_gradient

_JUMP = 1.5  # rms step over a seam, over the largest of all others
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
    window = check_labelled(window)
    window = window if window.chunks is None else window.compute()  # of dask, read piece by piece
    labelled_heights, window = window.data, copy_to_host(window)
    steps = spacing(window)
    # single-precision heights are not made larger where the solution is no better
    dtype = np.float32 if precision == SINGLE and window.dtype == np.float32 else np.float64
    # the kernels in C need contiguous, aligned, writable memory
    heights = np.require(window.values, dtype=dtype, requirements=["C", "A", "W"])
    if window.data is not labelled_heights:  # back to the device it came from, after checks on the host
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
    # in double, because it is the unit of everything that follows
    gradient = spectral_gradient(as_precision(heights, DOUBLE, copy=False), steps, threads=threads)
    if highest > lowest and not SMALLEST <= gradient <= LARGEST:
        raise HeightMapError(
            f"heights from {lowest:g} m to {highest:g} m have an rms gradient of {gradient:g}, beyond the "
            "computable range; check the units"
        )
    return Problem(heights, steps, reference=0.5 * (lowest + highest), gradient=gradient)


def warn_of_seams(window: xr.DataArray, gradient: float, *, stacklevel: int) -> None:
    """Warn the caller of a public function of a map (y, x; m) that jumps where its period begins again.

    There the rms step from the last line to the first is above all others, and above the rms `gradient`. Only
    these two lines are looked at where it is below, as in most periodic maps.
    """
    for axis, (name, pitch) in enumerate(zip("yx", spacing(window), strict=True)):
        lines = np.moveaxis(window.values, axis, 0)
        seam = _rms_step(lines[-1], lines[0])
        if seam <= gradient * pitch or window.attrs.get("periodisation") == "raw":  # kept on purpose
            continue
        if seam > _JUMP * (inside := max(_rms_step(*pair) for pair in pairwise(lines))):
            warnings.warn(
                f"the map is not periodic along {name}: from its last line to its first the heights jump by "
                f"{seam:.3g} m (rms), inside by {inside:.3g} m at most, and the jump is solved as roughness; "
                "level removes a tilt, periodic_window closes the seam",
                HeightMapWarning,
                stacklevel=stacklevel,
            )


def _rms_step(line: np.ndarray, next_line: np.ndarray) -> float:
    """Return the root mean square of the steps between two lines."""
    return float(np.sqrt(np.mean(np.square(next_line - line, dtype=float))))


def copy_to_host(array: _Labelled) -> _Labelled:
    """Return `array` with its values in a NumPy array, whatever library and device they are of.

    It is returned as it is where nothing has to be copied.
    """
    return array if isinstance(array.data, np.ndarray) else array.as_numpy()
