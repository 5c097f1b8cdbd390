"""What the kernels of `array_api` and `compiled` share with the solver: factors, weights, arrangements."""

from enum import IntEnum
from typing import Any

Factors = tuple[int, int]  # (fy, fx): cells of a fine grid in a cell of the coarse one
Weights = tuple[float, float, float]  # of a neighbour across y, across x, and diagonal
Cells = tuple[Factors, Any, Any]  # of a coarser grid, and fields of its cells: share of contact, and means
Heights = tuple[Any, float, float]  # a field, the height from which it counts, and its unit
Former = tuple[Any, Any, float]  # pressure, separation and offset before a step


class Arrangement(IntEnum):
    """Arrangement of contacts in a coarse cell, which determines the weight of a cell in partial contact."""

    UNKNOWN = 0
    SCATTERED = 1  # far apart, as for rough surfaces in large cells
    ALONG_A_LINE = 2  # of a profile: each is a line contact
