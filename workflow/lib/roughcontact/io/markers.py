"""Numbers that programs write for a missing point."""

from collections.abc import Iterable

import numpy as np

# Numbers without unit or scale that no height reaches.
_VALUES = (
    1.70141e38,  # Surfer: blanked node of a grid
    3.40282e38,  # C, float.h: FLT_MAX; the NODATA_value of Arc/Info grids with either sign
    1.79769e308,  # C, float.h: DBL_MAX
    9.91e37,  # SCPI-99, volume 1, 7.2.1: not a number
    9.9e37,  # SCPI-99, volume 1, 7.2.1: infinity, with either sign
    9.96921e36,  # netCDF, netcdf.h: NC_FILL_FLOAT and NC_FILL_DOUBLE
)


def remove_marker_values(values: np.ndarray, further_markers: Iterable[float] = ()) -> None:
    """Replace infinite values, markers of a missing point, and `further_markers` by NaN, in place.

    Examples
    --------
    >>> heights = np.array([1.5, 9.91e37, -9999.0])
    >>> remove_marker_values(heights, [-9999])
    >>> heights
    array([1.5, nan, nan])
    """
    # the largest double is infinite where its last digit was rounded up
    values[np.isinf(values)] = np.nan
    for value in further_markers:
        values[values == value] = np.nan
    for value in _VALUES:
        values[np.abs(np.abs(values) / value - 1) < 1e-5] = np.nan
