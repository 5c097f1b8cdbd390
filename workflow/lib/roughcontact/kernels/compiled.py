"""The kernels of `roughcontact.kernels.array_api` in C: one pass through memory each.

The library is built from `c` at installation, does not depend on Python and distributes rows over its own
threads. Arrays must be contiguous in memory.
"""

import ctypes
import sys
from functools import cache
from itertools import pairwise
from pathlib import Path
from struct import Struct

import numpy as np

from roughcontact.kernels.memory import store
from roughcontact.kernels.threads import threads_for

LIBRARY = Path(__file__).with_name(
    # names that the builds of all systems give it
    "libkernels" + {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
)
_SOURCES = "c"  # folder beside this file; naming it here includes it in the digest of the sources
# Arguments of each pass, as in its struct in C: first arrays, a letter each, then floats (d) and integers
# (q). Arrays with the same letter have the same precision; c: complex numbers of the precision of r; D: 8
# bytes, b: one byte an item.
_ARGUMENTS = {
    "multiply": ("cr", "q"),
    "divide": ("crr", "q"),
    "inverse_root": ("rrr", "q"),
    "slope_power": ("cDDD", "q"),
    "extent": ("r", "q"),
    "make_dimensionless": ("oi", "ddq"),
    "measure": ("oiooo", "ddddq"),
    "masked_residual": ("ooiii", "ddqqqq"),
    "predict_active": ("oiiii", "dddddqqqq"),
    "advance": ("siiitii", "dddqqqq"),
    "redistribute": ("oiii", "dqqqq"),
    "project": ("oiii", "dqqqq"),
    "rescale": ("r", "ddq"),
    "product": ("rr", "q"),
    "project_residual": ("ooi", "ddq"),
    "restore_units": ("rrb", "dddq"),
    "block_mean": ("rr", "qqqq"),
    "weigh": ("rrrrrr", "qqqqqq"),
    "mix": ("rrrr", "qqqq"),
    "neighbours": ("rr", "dddqq"),
    "fill": ("rrrr", "dddqq"),
    "fill_from": ("rrrr", "dddqqqq"),
    "empty_neighbours": ("rrr", "dddqq"),
    "gather": ("rrr", "qqqq"),
    "empty_from": ("rrrr", "dddqqqq"),
    "spread": ("rrr", "qqqq"),
    "finish_restriction": ("rrrr", "qqqq"),
    "weigh_small": ("rrrrDr", "qq"),
    "prolong_small": ("rrrrrrDr", "qqq"),
    "restrict_small": ("rrrrrrDr", "qqq"),
    "continue_square": ("rr", "qq"),
    "refine": ("rrrr", "dddddqqqq"),
    "rows_forward": ("rcr", "dqq"),
    "rows_backward": ("rcr", "dqq"),
    "columns": ("cr", "qqq"),
    "percolates": ("rDD", "dqq"),
    "medians": ("rr", "qq"),
}
_structs = {name: Struct("P" * len(arrays) + scalars) for name, (arrays, scalars) in _ARGUMENTS.items()}
_pack = {name: struct.pack for name, struct in _structs.items()}
# cells; coarser grids of a hierarchy are processed in one call, by one thread
SMALL_GRID = {"one thread": 2**62, "several threads": 64 * 64}
_Results = ctypes.c_double * 8  # six sums, the smallest and the largest value
_view, _address = (ctypes.c_char * 0).from_buffer, ctypes.addressof


@cache
def library() -> ctypes.CDLL:
    """Return the library of the passes.

    Raises `OSError` where it is missing, or was built from other sources.
    """
    compiled_library = ctypes.CDLL(str(LIBRARY))
    try:
        # a library of other sources may have other arguments, which would be read as if they were these
        find = compiled_library.find_pass_given
        find.argtypes, find.restype = (ctypes.c_char_p, ctypes.c_int64), ctypes.c_void_p
        # name of the pass in single precision: a letter for each kind of array
        types = {
            name: "f" * len(set(arrays.replace("c", "r")) - set("Db"))
            for name, (arrays, _) in _ARGUMENTS.items()
        }
        fits = all(find(f"{name}_{types[name]}".encode(), _structs[name].size) for name in _ARGUMENTS)
    except AttributeError:
        fits = False
    if not fits:
        raise OSError(f"{LIBRARY} was built from other sources")
    numbers = [ctypes.c_int64] * 3
    compiled_library.run_pass.argtypes = ctypes.c_void_p, *numbers, ctypes.c_char_p, ctypes.POINTER(_Results)
    return compiled_library


@cache
def _find(name, widths):
    """Return the address of the pass for the given item sizes of its arrays."""
    bytes_of = {"D": 8, "b": 1}
    for letter, width in zip(_ARGUMENTS[name][0], widths, strict=True):
        key, real_width = ("r", width // 2) if letter == "c" else (letter, width)
        # the first array of a letter fixes the width of its kind
        if bytes_of.setdefault(key, real_width) != real_width:
            raise TypeError(f"{name}: arrays with items of {widths} bytes cannot be combined")
    types = "".join({4: "f", 8: "d"}[width] for key, width in bytes_of.items() if key not in "Db")
    # two letters, as in the names of the passes in C
    address = library().find_pass_given(f"{name}_{types}".encode(), _structs[name].size)
    if address is None:
        raise TypeError(f"{name}: there is no pass for precisions {types}")
    return address


class Compiled:
    """The kernels, run by up to `threads` threads."""

    def __init__(self, threads: int = 1):
        self.threads = threads

    def multiply(self, spectrum, symbol):
        self._over_lines("multiply", (spectrum, symbol))

    def divide(self, spectrum, symbol, weights):
        return self._over_lines("divide", (spectrum, symbol, weights))[0]

    def inverse_root(self, along_y, along_x, out):
        rows, nx = out.shape
        # the threads are chosen by the size of the first array
        run_pass("inverse_root", rows, 0, (along_y, along_x, out), nx, threads=self.threads)

    def slope_power(self, spectrum, weights, along_y, along_x):
        return self._over_lines("slope_power", (spectrum, weights, along_y, along_x))[0]

    def extent(self, field):
        missing, *_, lowest, highest = self._over_lines("extent", (field,), lines=2)
        return lowest, highest, int(missing)

    # a product takes less time than a quotient
    def make_dimensionless(self, heights, reference, unit, out):
        self._over_lines("make_dimensionless", (heights, out), reference, 1 / unit)

    def measure(self, separation, heights, former, pressure, cap):
        (field, reference, unit), (start, previous, offset) = heights, former
        arrays = separation, field, start, previous, pressure
        return tuple(self._over_lines("measure", arrays, reference, 1 / unit, offset, cap)[:6])

    def masked_residual(self, pressure, separation, offset, cap, values, cells):
        factors, share, means = cells
        arrays = pressure, separation, values, share, means
        self._over_grid("masked_residual", arrays, offset, cap, factors=factors, blocks=share)

    def predict_active(self, pressure, residual, weights, stiffness, cap, values, cells):
        factors, share, means = cells
        arrays, numbers = (pressure, residual, values, share, means), (*weights, stiffness, cap)
        self._over_grid("predict_active", arrays, *numbers, factors=factors, blocks=share, lines=3)

    def advance(self, pressure, correction, inflow, coarse, factors, mean, length, cap, out, values, share):
        arrays = pressure, correction, inflow, coarse, out, values, share
        self._over_grid("advance", arrays, mean, length, cap, factors=factors, blocks=share)

    def redistribute(self, field, inflow, coarse, factors, free, cap):
        arrays = field, inflow, coarse, free
        return tuple(self._over_grid("redistribute", arrays, cap, factors=factors, blocks=coarse)[:2])

    def project(self, field, cap, removed_load, free, factors, share):
        self._over_grid("project", (field, removed_load, free, share), cap, factors=factors, blocks=share)

    def rescale(self, field, factor, cap):
        return self._over_lines("rescale", (field,), factor, cap)[0]

    def product(self, u, v):
        return self._over_lines("product", (u, v))[0]

    def project_residual(self, pressure, separation, offset, cap, values):
        return self._over_lines("project_residual", (pressure, separation, values), offset, cap)[0]

    def restore_units(self, pressure, gap, offset, pressure_unit, gap_unit, contact):
        arrays, numbers = (pressure, gap, contact), (offset, pressure_unit, gap_unit)
        total, *_, lowest, _ = self._over_lines("restore_units", arrays, *numbers, lines=1)
        return lowest, total

    def block_mean(self, field, factors, out):
        self._over_grid("block_mean", (field, out), factors=factors, blocks=out)

    def weigh(self, fine_share, share, factors, arrangement, empty, gain, coarser):
        next_factors, next_parts, next_share = coarser
        arrays, (fy, fx) = (fine_share, share, empty, gain, next_parts, next_share), factors
        numbers = fy * fx, arrangement, *next_factors
        self._over_grid("weigh", arrays, factors=numbers, blocks=next_share, lines=next_factors[0] + 1)

    def mix(self, values, empty, coarse, factors, out):
        self._over_grid("mix", (values, empty, coarse, out), factors=factors, blocks=coarse)

    def neighbours(self, field, weights, out):
        self._over_grid("neighbours", (field, out), *weights)

    def fill(self, values, empty, source, weights, out):
        self._over_grid("fill", (values, empty, source, out), *weights, lines=2)

    def fill_from(self, values, active, coarse, factors, weights, out):
        self._over_grid("fill_from", (values, active, coarse, out), *weights, factors=factors, lines=5)

    def empty_neighbours(self, field, empty, weights, out):
        self._over_grid("empty_neighbours", (field, empty, out), *weights, lines=4)

    def gather(self, field, empty, factors, out):
        self._over_grid("gather", (field, empty, out), factors=factors, blocks=out)

    def empty_from(self, field, active, weights, inflow, factors, coarse):
        arrays = field, active, inflow, coarse
        self._over_grid("empty_from", arrays, *weights, factors=factors, blocks=coarse, lines=5)

    def spread(self, field, gain, coarse, factors):
        self._over_grid("spread", (field, gain, coarse), factors=factors, blocks=coarse)

    def finish_restriction(self, field, inflow, coarse, factors, active):
        arrays = field, inflow, coarse, active
        return self._over_grid("finish_restriction", arrays, factors=factors, blocks=coarse)[0]

    def small_grids(self, grids, stores, stops):
        cells = [stop - start for start, stop in pairwise(stops)]
        limit = SMALL_GRID["one thread" if self.threads == 1 else "several threads"]
        # large grids take several threads each, so that they are called one by one
        small = sum(count > limit for count in cells)
        return CompiledSmallGrids(grids, stores, stops, small) if small < len(grids) else None

    def refine(self, coarse, factors, heights, weights, stiffness, cap, out):
        square, (ny, nx), (fy, fx) = store.empty(coarse.shape, coarse.dtype), coarse.shape, factors
        self._over_grid("continue_square", (coarse, square), lines=10)
        arrays, scratch = (coarse, square, heights, out), (fy + 1) * nx * fx + (fy * fx + 4) * nx + 4
        numbers, threads = (*weights, stiffness, cap, ny, nx, fy, fx), threads_for(coarse.size, self.threads)
        run_pass("refine", ny, scratch, arrays, *numbers, threads=threads)

    def _over_lines(self, name, arrays, *numbers, lines=0):
        """Run a pass over the rows of the first array, each point by itself; return its sums."""
        (rows, nx), threads = arrays[0].shape, threads_for(arrays[0].size, self.threads)
        return run_pass(name, rows, lines * nx, arrays, *numbers, nx, threads=threads)

    def _over_grid(self, name, arrays, *numbers, factors=(), blocks=None, lines=1):
        """Run a pass over the grid of the first array, or over its blocks of `factors`; return its sums.

        `blocks` is an array of the coarse cells; the work memory is of so many `lines` of the grid.
        """
        ny, nx = arrays[0].shape
        rows, threads = ny if blocks is None else len(blocks), threads_for(arrays[0].size, self.threads)
        return run_pass(name, rows, lines * (nx + 2), arrays, *numbers, ny, nx, *factors, threads=threads)


class Regions:
    """Connected regions of a periodic map above a level."""

    def __init__(self, field: np.ndarray):
        self._field = np.require(field, requirements=["C", "A", "W"])
        ny, nx = field.shape
        self._trees = np.empty((2, ny * (nx // 2 + 1)), np.int64)

    def percolates(self, level: float) -> tuple[bool, bool]:
        """Return whether a connected region of points at or above `level` percolates along y, and along x."""
        ny, nx = self._field.shape
        arrays = self._field, *self._trees
        results = run_pass("percolates", 1, 6 * (nx // 2 + 1), arrays, level, ny, nx)
        return bool(results[0]), bool(results[1])


def median_filter(field: np.ndarray) -> np.ndarray:
    """Return the medians of 5 x 5 points of a field (ny, nx), of those two points from its edges or more."""
    ny, nx = field.shape
    medians = store.empty((ny - 4, nx - 4), field.dtype)
    run_pass("medians", ny - 4, 0, (np.require(field, requirements=["C", "A", "W"]), medians), ny, nx)
    return medians


class CompiledSmallGrids:
    """The coarsest grids of a hierarchy, from number `first` on, as arguments of a single call.

    Its overhead would exceed the work on their few cells.
    """

    def __init__(self, grids, stores, stops, small):
        self.first = small
        table = [
            (*grid.empty.shape, *grid.factors, start, grid.arrangement)
            for grid, start in zip(grids[small:], stops[small:-1], strict=True)
        ]
        weights = np.array([grid.weights for grid in grids[small:]], dtype=stores[0].dtype)
        self._arrays = (*stores, np.array(table, dtype=np.int64), weights)
        self._counts, self._longest = (len(table), small == 0), max(row[1] for row in table)
        # the coarsest is weighed row by row
        rows = [*(row[2] for row in table[1:]), 1]
        # work memory of the widest block of rows, over all small grids
        self._scratch = max((height + 1) * row[1] for height, row in zip(rows, table, strict=True))

    def weigh(self):
        """Compute the weights of the cells of each grid from the contact on the next finer one."""
        run_pass("weigh_small", 1, self._scratch, self._arrays, *self._counts)

    def prolong(self, sweeps, work, scratch):
        """Interpolate from the coarsest grid, with so many smoothing sweeps there, to the first."""
        arrays = work, scratch, *self._arrays
        run_pass("prolong_small", 1, 2 * self._longest + 2, arrays, *self._counts, sweeps)

    def restrict(self, sweeps, work, scratch):
        """Apply the transpose of `prolong`; `work` and `scratch`, of the coarsest shape, are overwritten."""
        arrays = work, scratch, *self._arrays
        run_pass("restrict_small", 1, 4 * self._longest + 2, arrays, *self._counts, sweeps)


def run_pass(name, rows, scratch, arrays, *numbers, threads=1):
    """Run a pass over a number of rows; return its six sums, the smallest and the largest value.

    `scratch` is the number of floats of work memory for each thread, `threads` the maximum number.
    """
    # one packed struct: ctypes would convert every argument by itself
    arguments = _pack[name](*[_address(_view(array)) for array in arrays], *numbers)
    address = _find(name, tuple([array.itemsize for array in arrays]))
    results = _Results()
    if library().run_pass(address, threads, rows, 8 * scratch, arguments, results):
        raise MemoryError(f"no work memory for the pass {name}")
    return results
