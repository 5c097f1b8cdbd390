"""From a labelled map to a dimensionless problem, with every check the numbers need."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.kernels.arrays import DOUBLE, SINGLE
from roughcontact.kernels.choose import kernels_for
from roughcontact.maps import spacing
from roughcontact.roughness.parameters import rms_gradient


@dataclass(frozen=True)
class Problem:
    """The heights h (ny, nx) on a cell of `lengths` = (Ly, Lx)/L, and what makes them dimensionless.

    H = (h - h_ref)/(g L) is never made for all of the map in double precision: it would fill memory.
    `reference` h_ref is the middle of the height range: subtracting it first keeps an offset of metres from
    eating the digits of nanometres. `scale` = g L (m) is the unit of height, L = sqrt(Lx Ly) that of length,
    E* g that of pressure; `gradient` g is the spectral rms gradient. A flat map has g = 0 and no scale.
    """

    heights: np.ndarray
    lengths: tuple[float, float]
    unit_length: float
    reference: float
    gradient: float
    spacing: tuple[float, float]

    @property
    def scale(self) -> float:
        return self.gradient * self.unit_length

    @property
    def flat(self) -> bool:
        return self.gradient == 0.0


def check_map(window: xr.DataArray) -> None:
    """Raise HeightMapError unless `window` is an evenly spaced map (y, x) of at least two cells."""
    if window.dims != ("y", "x"):
        raise HeightMapError(f"the height map has dimensions {window.dims}; it must have ('y', 'x')")
    if window.size < 2:
        raise HeightMapError("the height map has one pixel only: a contact needs at least two")
    for axis in ("y", "x"):
        if axis not in window.coords:
            raise HeightMapError(f"the height map has no coordinate {axis!r}: its pixel size is unknown")
        steps = np.diff(window[axis].values)
        if steps.size and not (steps > 0).all():
            raise HeightMapError(f"coordinate {axis!r} does not increase strictly")
        # coordinates are sums of rounded steps: allow for their rounding, not for uneven sampling
        if steps.size and np.ptp(steps) > 1e-3 * steps.mean():
            raise HeightMapError(
                f"coordinate {axis!r} is not evenly spaced (steps {steps.min():g} to {steps.max():g}); "
                "resample the map first"
            )


def pose(window: xr.DataArray, *, precision: str = DOUBLE, threads: int = 1) -> Problem:
    """Return the dimensionless problem of the map `window` (y, x).

    Its heights are not copied where they can be used as they are; in single precision for a result in that.
    Heights of another array library stay where they are.
    """
    given, window = window.data, on_host(window)
    check_map(window)
    steps = spacing(window)
    lengths = tuple(n * d for n, d in zip(window.shape, steps, strict=True))
    kind = np.float32 if precision == SINGLE and window.dtype == np.float32 else np.float64
    heights = np.require(window.values, dtype=kind, requirements=["C", "A", "W"])
    if window.data is not given:
        heights = given.__array_namespace__().asarray(heights, device=given.device)
    least, most, missing = kernels_for(heights, threads=threads).extent(heights)
    if missing:
        raise HeightMapError(
            f"{missing} of {window.size} heights are missing or infinite; fill or crop them first "
            "(level fills holes, periodic_window crops missing edges)"
        )
    unit = float(np.sqrt(lengths[0] * lengths[1]))
    gradient = rms_gradient(window, threads=threads)
    return Problem(
        heights=heights,
        lengths=(lengths[0] / unit, lengths[1] / unit),
        unit_length=unit,
        reference=0.5 * (least + most),
        gradient=gradient,
        spacing=steps,
    )


def on_host(array: xr.DataArray | xr.Variable):
    """Return `array` with its values in a NumPy array, whatever library and device they are of."""
    return array if isinstance(array.data, np.ndarray) else array.as_numpy()


def check_positive(name: str, value, *, unit: str) -> float:
    """Return `value` as a float, or raise SettingsError where it is no finite positive number."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise SettingsError(f"{name} = {value!r} is not a number; give a positive number in {unit}") from None
    if not (np.isfinite(number) and number > 0):
        raise SettingsError(f"{name} = {number:g} must be a positive finite number in {unit}")
    return number
