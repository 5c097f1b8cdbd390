"""Interface of the grid kernels of the solver, which `roughcontact.kernels.array_api` defines.

Every kernel writes to preallocated arrays; `roughcontact.kernels.compiled` has them in C, for NumPy arrays.
"""

from collections.abc import Sequence
from enum import IntEnum
from typing import Any, Protocol

from roughcontact.kernels.arrays import Array


class Arrangement(IntEnum):
    """Arrangement of contacts in a coarse cell, which determines the weight of a cell in partial contact."""

    UNKNOWN = 0
    SCATTERED = 1  # far apart, as for rough surfaces in large cells
    ALONG_A_LINE = 2  # of a profile: each is a line contact


Factors = tuple[int, int]
Weights = tuple[float, float, float]


class Kernels(Protocol):
    """The kernels: passes over the points of a grid."""

    # over the waves of a spectrum
    def multiply(self, spectrum: Array, symbol: Array) -> None: ...
    def divide(self, spectrum: Array, symbol: Array, weights: Array) -> float: ...
    def inverse_root(self, along_y: Array, along_x: Array, out: Array) -> None: ...
    def slope_power(self, spectrum: Array, weights: Array, along_y: Array, along_x: Array) -> float: ...

    # before and after the iteration
    def extent(self, field: Array) -> tuple[float, float, int]: ...
    def make_dimensionless(self, heights: Array, reference: float, unit: float, out: Array) -> None: ...
    def restore_units(
        self,
        pressure: Array,
        gap: Array,
        offset: float,
        pressure_unit: float,
        gap_unit: float,
        contact: Array,
    ) -> tuple[float, float]: ...

    # a step of the iteration
    def measure(
        self,
        separation: Array,
        heights: Array,
        reference: float,
        unit: float,
        start: Array,
        before: Array,
        offset: float,
        pressure: Array,
        cap: float,
    ) -> tuple[float, ...]: ...
    def masked_residual(
        self,
        pressure: Array,
        separation: Array,
        offset: float,
        cap: float,
        values: Array,
        factors: Factors,
        share: Array,
        cell_means: Array,
    ) -> None: ...
    def project_residual(
        self, pressure: Array, separation: Array, offset: float, cap: float, values: Array
    ) -> float: ...
    def predict_active(
        self,
        pressure: Array,
        residual: Array,
        weights: Weights,
        stiffness: float,
        cap: float,
        values: Array,
        factors: Factors,
        share: Array,
        cell_means: Array,
    ) -> None: ...
    def advance(
        self,
        pressure: Array,
        correction: Array,
        passed: Array,
        coarse: Array,
        factors: Factors,
        mean: float,
        length: float,
        cap: float,
        out: Array,
        values: Array,
        share: Array,
    ) -> None: ...
    def redistribute(
        self, field: Array, passed: Array, coarse: Array, factors: Factors, free: Array, cap: float
    ) -> tuple[float, float]: ...
    def project(
        self, field: Array, cap: float, removed_load: Array, free: Array, factors: Factors, share: Array
    ) -> None: ...
    def rescale(self, field: Array, factor: float, cap: float) -> float: ...
    def product(self, first: Array, second: Array) -> float: ...

    # prolongation and restriction on a hierarchy of grids
    def block_mean(self, field: Array, factors: Factors, out: Array) -> None: ...
    def weigh(
        self,
        fine_share: Array,
        share: Array,
        factors: Factors,
        arrangement: Arrangement,
        empty: Array,
        gain: Array,
        next_factors: Factors,
        next_parts: Array,
        next_share: Array,
    ) -> None: ...
    def mix(self, values: Array, empty: Array, coarse: Array, factors: Factors, out: Array) -> None: ...
    def neighbours(self, field: Array, weights: Weights, out: Array) -> None: ...
    def fill(self, values: Array, empty: Array, mixed: Array, weights: Weights, out: Array) -> None: ...
    def fill_from(
        self, values: Array, active: Array, coarse: Array, factors: Factors, weights: Weights, out: Array
    ) -> None: ...
    def empty_neighbours(self, field: Array, empty: Array, weights: Weights, out: Array) -> None: ...
    def gather(self, field: Array, empty: Array, factors: Factors, out: Array) -> None: ...
    def empty_from(
        self, field: Array, active: Array, weights: Weights, passed: Array, factors: Factors, coarse: Array
    ) -> None: ...
    def spread(self, field: Array, gain: Array, coarse: Array, factors: Factors) -> None: ...
    def finish_restriction(
        self, field: Array, passed: Array, coarse: Array, factors: Factors, active: Array
    ) -> float: ...
    def refine(
        self,
        coarse: Array,
        factors: Factors,
        heights: Array,
        weights: Weights,
        stiffness: float,
        cap: float,
        out: Array,
    ) -> None: ...

    def small_grids(
        self, grids: Sequence[Any], stores: Sequence[Array], ends: Sequence[int]
    ) -> "SmallGrids | None": ...


class SmallGrids(Protocol):
    """The coarsest grids of a hierarchy, from number `first` on, processed in one call.

    For kernels whose call overhead exceeds their work on few cells; None stands for kernels that process each
    grid separately.
    """

    first: int

    def weigh(self) -> None:
        """Compute the weights of the cells of each grid from the contact on the next finer one."""

    def prolong(self, sweeps: int, work: Array, scratch: Array) -> None:
        """Interpolate from the coarsest of the grids to the first.

        `sweeps` is the number of smoothing sweeps on the coarsest grid. `work` and `other` are work memory of
        its shape, overwritten.
        """

    def restrict(self, sweeps: int, work: Array, scratch: Array) -> None:
        """Apply the transpose of `prolong`."""
