"""The kernels of `roughcontact.kernels.array_api`, compiled by Numba: one sweep through memory each.

What they compute is said there; tests compare the two. Every kernel works on the rows from `first` to `last`,
and has a twin, at the end of this file, that shares the rows among threads. One thread takes the kernel
itself, which works in a process that was forked, too.

All is in one file because Numba compiles anew only what stands in a file that has changed. The twins are
written out because it keeps no compiled code of functions that are made by another.
"""

import os
from contextlib import contextmanager, nullcontext
from functools import cache
from itertools import pairwise
from threading import Lock
from typing import Any

import numba
import numpy as np

from roughcontact.kernels.array_api import CLOSED
from roughcontact.kernels.memory import store
from roughcontact.kernels.protocol import Arrangement
from roughcontact.kernels.threads import threads_for

# Sums may be reordered, for the sake of vector instructions; infinities and NaN keep their meaning.
_options: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"reassoc", "contract", "nsz"},
}
_compile: Any = numba.njit(**_options)
_compile_shared: Any = numba.njit(parallel=True, **_options)
_config: Any = numba.config
_turn = Lock()
SCATTERED, ALONG_A_LINE = int(Arrangement.SCATTERED), int(Arrangement.ALONG_A_LINE)
_NUMBA_DEFAULT = ["tbb", "omp", "workqueue"]
SMALL_GRID = 64 * 64  # cells up to which the grids of a hierarchy are passed over in one call


class Compiled:
    """The kernels, run by up to `threads` threads."""

    def __init__(self, threads: int = 1):
        self.threads = threads

    def multiply(self, spectrum, symbol):
        self._run(_multiply, _share_multiply, len(spectrum), spectrum, symbol)
        spectrum[0, 0] = 0

    def divide(self, spectrum, symbol, weights):
        spectrum[0, 0] = 0
        return self._run(_divide, _share_divide, len(spectrum), spectrum, symbol, weights)

    def slope_power(self, spectrum, weights, along_y, along_x):
        arguments = spectrum, weights, along_y, along_x
        return self._run(_slope_power, _share_slope_power, len(spectrum), *arguments)

    def extent(self, field):
        least, most, missing = self._run(_extent, _share_extent, len(field), field)
        return least, most, int(missing)

    def make_dimensionless(self, heights, reference, unit, out):
        kind = heights.dtype.type
        arguments = heights, kind(reference), kind(1 / unit), out
        self._run(_make_dimensionless, _share_make_dimensionless, len(out), *arguments)

    def measure(self, separation, heights, reference, unit, before_pressure, before, offset, pressure, cap):
        kind = pressure.dtype.type
        heights = heights, heights.dtype.type(reference), heights.dtype.type(1 / unit)
        arguments = before_pressure, before, kind(offset), pressure, kind(cap)
        return tuple(self._run(_measure, _share_measure, len(pressure), separation, *heights, *arguments))

    def masked_residual(self, pressure, separation, offset, cap, values):
        kind = separation.dtype.type
        arguments = pressure, separation, kind(offset), kind(cap), values
        return self._run(_masked_residual, _share_masked_residual, len(pressure), *arguments)

    def advance(self, pressure, separation, correction, offset, mean, length, cap, out, free):
        kind, inner = pressure.dtype.type, correction.dtype.type
        scalars = kind(offset), inner(mean), inner(length), kind(cap)
        arguments = pressure, separation, correction, *scalars, out, free
        self._run(_advance, _share_advance, len(out), *arguments)

    def redistribute(self, field, passed, coarse, factors, free, cap):
        arguments = field, passed, coarse, *factors, free, field.dtype.type(cap)
        return self._run(_redistribute, _share_redistribute, len(coarse), *arguments)

    def project(self, field, cap, taken, free):
        self._run(_project, _share_project, len(field), field, field.dtype.type(cap), taken, free)

    def rescale(self, field, factor, cap):
        kind = field.dtype.type
        self._run(_rescale, _share_rescale, len(field), field, kind(factor), kind(cap))

    def project_residual(self, pressure, separation, offset, cap, values):
        kind = separation.dtype.type
        arguments = pressure, separation, kind(offset), kind(cap), values
        return self._run(_project_residual, _share_project_residual, len(values), *arguments)

    def restore_units(self, pressure, gap, offset, pressure_unit, gap_unit, contact):
        kind = pressure.dtype.type
        scalars = kind(offset), kind(pressure_unit), kind(gap_unit)
        arguments = pressure, gap, *scalars, contact
        return self._run(_restore_units, _share_restore_units, len(pressure), *arguments)

    def block_mean(self, field, factors, out):
        self._run(_block_mean, _share_block_mean, len(out), field, *factors, out)

    def active_share(self, active, factors, out):
        self._run(_active_share, _share_active_share, len(out), active, *factors, out)

    def weigh(self, weight, share, factors, arrangement, empty, gain):
        arguments = weight, share, *factors, int(arrangement), empty, gain
        self._run(_weigh, _share_weigh, len(share), *arguments)

    def weighted_mean(self, field, factors, gain, out):
        self._run(_weighted_mean, _share_weighted_mean, len(out), field, *factors, gain, out)

    def mix(self, values, empty, coarse, factors, out):
        self._run(_mix, _share_mix, len(coarse), values, empty, coarse, *factors, out)

    def neighbours(self, field, weights, out):
        self._run(_neighbours, _share_neighbours, len(out), field, *_cast(weights, field), out)

    def fill(self, values, empty, mixed, weights, out):
        self._run(_fill, _share_fill, len(out), values, empty, mixed, *_cast(weights, mixed), out)

    def fill_from(self, values, active, coarse, factors, weights, out):
        arguments = values, active, coarse, *factors, *_cast(weights, coarse), out
        self._run(_fill_from, _share_fill_from, len(out), *arguments)

    def empty_neighbours(self, field, empty, weights, out):
        arguments = field, empty, *_cast(weights, field), out
        self._run(_empty_neighbours, _share_empty_neighbours, len(out), *arguments)

    def gather(self, field, empty, factors, out):
        self._run(_gather, _share_gather, len(out), field, empty, *factors, out)

    def empty_from(self, field, active, weights, passed, factors, coarse):
        arguments = *_cast(weights, field), passed, *factors, coarse
        self._run(_empty_from, _share_empty_from, len(coarse), field, active, *arguments)

    def spread(self, field, gain, coarse, factors):
        self._run(_spread, _share_spread, len(coarse), field, gain, coarse, *factors)

    def finish_restriction(self, field, passed, coarse, factors, active):
        arguments = field, passed, coarse, *factors, active
        return self._run(_finish_restriction, _share_finish_restriction, len(coarse), *arguments)

    def small_grids(self, grids, stores, ends):
        cells = [end - start for start, end in pairwise(ends)]
        first = sum(count > SMALL_GRID for count in cells)
        return SmallGrids(grids, stores, ends, first) if first < len(grids) else None

    def refine(self, coarse, factors, out):
        square = store.empty(coarse.shape, coarse.dtype)
        self._run(_continue, _share_continue, len(coarse), coarse, square)
        self._run(_refine, _share_refine, len(coarse), coarse, square, *factors, out)

    def _run(self, kernel, shared, rows, *arguments):
        """Run a kernel over `rows` rows, shared among threads where its first argument is large.

        Returns what the kernel returns, put together from the shares.
        """
        if threads_for(arguments[0].size, self.threads) == 1:
            return kernel(0, rows, *arguments)
        _prefer_openmp()
        if numba.get_num_threads() == self.threads and numba.threading_layer() != "workqueue":
            # the usual case: to set what is set already takes as long as a small pass
            return shared(self.threads, rows, arguments)
        with _threads(self.threads) as threads:
            return shared(threads, rows, arguments)


class SmallGrids:
    """The grids of a hierarchy from number `first` on, in the form that one call takes."""

    def __init__(self, grids, stores, ends, first):
        self.first = first
        table = [
            (*grid.empty.shape, *grid.factors, start, int(grid.arrangement))
            for grid, start in zip(grids[first:], ends[first:-1], strict=True)
        ]
        weights = np.array([grid.weights for grid in grids[first:]], dtype=stores[0].dtype)
        self._packed = *stores, np.array(table), weights

    def weigh(self):
        _weigh_small(*self._packed)

    def prolong(self, sweeps, work, other):
        _prolong_small(*self._packed, sweeps, work, other)

    def restrict(self, sweeps, work, other):
        _restrict_small(*self._packed, sweeps, work, other)


def _cast(weights, field):
    return tuple(field.dtype.type(weight) for weight in weights)


@cache
def _prefer_openmp() -> None:
    """Ask Numba for OpenMP before its first threads start, unless the user has chosen something.

    It is the quickest to start, and one pool of threads with MKL (`roughcontact.kernels.fft`).
    """
    chosen = {"NUMBA_THREADING_LAYER", "NUMBA_THREADING_LAYER_PRIORITY"} & set(os.environ)
    if not chosen and _config.THREADING_LAYER_PRIORITY == _NUMBA_DEFAULT:
        _config.THREADING_LAYER_PRIORITY = ["omp", "tbb", "workqueue"]


@contextmanager
def _threads(wanted):
    """Let Numba use `wanted` threads, or as many as it has; say how many."""
    before = numba.get_num_threads()
    numba.set_num_threads(min(wanted, _config.NUMBA_NUM_THREADS))
    try:
        # one of Numba's ways to thread must not be entered twice at a time
        with _turn if numba.threading_layer() == "workqueue" else nullcontext():
            yield numba.get_num_threads()
    finally:
        numba.set_num_threads(before)


@_compile
def _multiply(first, last, spectrum, symbol):
    for i in range(first, last):
        for j in range(symbol.shape[1]):
            spectrum[i, j] *= symbol[i, j]


@_compile
def _divide(first, last, spectrum, symbol, weights):
    energy = 0.0
    for i in range(first, last):
        for j in range(symbol.shape[1]):
            wave = spectrum[i, j]
            factor = 1 / symbol[i, j]  # to divide complex numbers takes many times as long
            energy += (wave.real * wave.real + wave.imag * wave.imag) * factor * weights[j]
            spectrum[i, j] = wave * factor
    return energy


@_compile
def _slope_power(first, last, spectrum, weights, along_y, along_x):
    total = 0.0
    for i in range(first, last):
        for j in range(spectrum.shape[1]):
            wave = spectrum[i, j]
            total += (wave.real * wave.real + wave.imag * wave.imag) * (
                weights[j] * (along_y[i] + along_x[j])
            )
    return total


@_compile
def _extent(first, last, field):
    # one minimum for every column: that becomes vector instructions
    least, most = field[first].copy(), field[first].copy()
    missing = 0
    for i in range(first, last):
        for j in range(field.shape[1]):
            value = field[i, j]
            least[j] = min(least[j], value)
            most[j] = max(most[j], value)
            missing += not np.isfinite(value)
    return np.float64(least.min()), np.float64(most.max()), np.float64(missing)


@_compile
def _make_dimensionless(first, last, heights, reference, scale, out):
    for i in range(first, last):
        for j in range(out.shape[1]):
            out[i, j] = (heights[i, j] - reference) * scale


@_compile
def _measure(
    first, last, separation, heights, reference, scale, before_pressure, before, offset, pressure, cap
):
    work = square = free_sum = slope = slope_after = 0.0
    free = 0
    for i in range(first, last):
        for j in range(pressure.shape[1]):
            p, u = pressure[i, j], separation[i, j]
            v = u - (heights[i, j] - reference) * scale
            change = p - before_pressure[i, j]
            slope += change * (before[i, j] - offset)
            slope_after += change * (v - offset)
            separation[i, j] = v
            work += p * u
            square += u * u
            is_free = (p > 0) & (p < cap)
            free += is_free
            free_sum += v if is_free else 0 * v
    return work, square, free_sum, float(free), slope, slope_after


@_compile
def _masked_residual(first, last, pressure, separation, offset, cap, values):
    count = 0
    zero, closed = values.dtype.type(0), values.dtype.type(CLOSED)
    for i in range(first, last):
        for j in range(pressure.shape[1]):
            p, gap = pressure[i, j], separation[i, j] - offset
            lower, upper = p <= 0, p >= cap
            active = (lower & (gap < 0)) | (upper & (gap > 0)) | ((not lower) & (not upper))
            value = values.dtype.type(gap)
            value = closed if value == zero else value
            values[i, j] = value if active else zero
            count += active
    return count


@_compile
def _advance(first, last, pressure, separation, correction, offset, mean, length, cap, out, free):
    zero, one = out.dtype.type(0), free.dtype.type(1)
    for i in range(first, last):
        for j in range(pressure.shape[1]):
            p, gap = pressure[i, j], separation[i, j] - offset
            lower, upper = p <= 0, p >= cap
            active = (lower & (gap < 0)) | (upper & (gap > 0)) | ((not lower) & (not upper))
            moved = p - length * (correction[i, j] - mean) if active else p
            projected = min(max(moved, zero), cap)
            out[i, j] = projected
            correction[i, j] = moved - projected
            free[i, j] = one if (projected > zero) & (projected < cap) else one - one


@_compile
def _redistribute(first, last, field, passed, coarse, fy, fx, free, cap):
    # rows are counted on the coarse grid
    row = np.empty(field.shape[1], dtype=passed.dtype)
    share = passed.dtype.type(1 / (fy * fx))
    nothing, zero = free.dtype.type(0), field.dtype.type(0)
    outside = total = 0.0
    for block in range(first, last):
        _unfold(coarse[block], fx, share, row)
        for i in range(block * fy, block * fy + fy):
            for j in range(row.size):
                change = passed[i, j] + row[j]
                value = field[i, j] + (change if free[i, j] != nothing else nothing)
                field[i, j] = value
                projected = min(max(value, zero), cap)
                outside += abs(value - projected)
                total += projected
    return outside, total


@_compile
def _project(first, last, field, cap, taken, free):
    zero, one = field.dtype.type(0), free.dtype.type(1)
    for i in range(first, last):
        for j in range(field.shape[1]):
            value = field[i, j]
            projected = min(max(value, zero), cap)
            field[i, j] = projected
            taken[i, j] = value - projected
            free[i, j] = one if (projected > zero) & (projected < cap) else one - one


@_compile
def _rescale(first, last, field, factor, cap):
    zero = field.dtype.type(0)
    for i in range(first, last):
        for j in range(field.shape[1]):
            field[i, j] = min(max(field[i, j], zero), cap) * factor


@_compile
def _project_residual(first, last, pressure, separation, offset, cap, values):
    total = 0.0
    for i in range(first, last):
        for j in range(pressure.shape[1]):
            p, r = pressure[i, j], values[i, j]
            gap = values.dtype.type(separation[i, j] - offset)
            projected = min(r, gap) if p <= 0 else r
            projected = max(projected, gap) if p >= cap else projected
            total += (projected - r) * (projected - r)
            values[i, j] = projected
    return total


@_compile
def _restore_units(first, last, pressure, gap, offset, pressure_unit, gap_unit, contact):
    least = np.full(gap.shape[1], np.inf, dtype=gap.dtype)
    total = 0.0
    for i in range(first, last):
        for j in range(pressure.shape[1]):
            p = pressure[i, j] * pressure_unit
            g = (gap[i, j] - offset) * gap_unit
            pressure[i, j], gap[i, j] = p, g
            contact[i, j] = p > 0
            total += p
            least[j] = min(least[j], g)
    return float(least.min()), total


@_compile
def _fold(columns, factor, share, out):
    """Put the sums of `factor` neighbours, times `share`, into `out`."""
    if factor == 2:  # known to the compiler, it becomes vector instructions
        for j in range(out.size):
            out[j] = (columns[2 * j] + columns[2 * j + 1]) * share
        return
    for j in range(out.size):
        total = columns[j * factor]
        for k in range(1, factor):
            total += columns[j * factor + k]
        out[j] = total * share


@_compile
def _unfold(coarse, factor, share, out):
    """Put every entry of `coarse`, times `share`, into `out`, `factor` times."""
    if factor == 2:
        for j in range(coarse.size):
            value = coarse[j] * share
            out[2 * j] = value
            out[2 * j + 1] = value
        return
    for j in range(coarse.size):
        for k in range(factor):
            out[j * factor + k] = coarse[j] * share


@_compile
def _block_mean(first, last, field, fy, fx, out):
    columns = np.empty(field.shape[1], dtype=field.dtype)
    share = out.dtype.type(1 / (fy * fx))
    for i in range(first, last):
        columns[:] = field[i * fy]
        for k in range(1, fy):
            for j in range(field.shape[1]):
                columns[j] += field[i * fy + k, j]
        _fold(columns, fx, share, out[i])


@_compile
def _active_share(first, last, active, fy, fx, out):
    columns = np.empty(active.shape[1], dtype=out.dtype)
    zero, one = out.dtype.type(0), out.dtype.type(1)
    share = out.dtype.type(1 / (fy * fx))
    for i in range(first, last):
        columns[:] = 0
        for k in range(fy):
            for j in range(columns.size):
                columns[j] += zero if active[i * fy + k, j] == zero else one
        _fold(columns, fx, share, out[i])


@_compile
def _weigh(first, last, weight, share, fy, fx, arrangement, empty, gain):
    zero, one = share.dtype.type(0), share.dtype.type(1)
    root, parts = share.dtype.type(np.sqrt(fy * fx)), share.dtype.type(fy * fx)
    for i in range(first, last):
        for j in range(share.shape[1]):
            mean = weight[i, j]
            if arrangement == ALONG_A_LINE:
                value = parts * mean / (one + (parts - one) * mean)
            else:
                whole, apart = np.sqrt(share[i, j]), mean * root
                pieces = apart / (one + apart - whole)
                value = pieces if arrangement == SCATTERED else np.sqrt(whole * pieces)
            weight[i, j] = value
            empty[i, j] = one - value
            gain[i, j] = value / (mean if mean > zero else one)


@_compile
def _weighted_mean(first, last, field, fy, fx, gain, out):
    _block_mean(first, last, field, fy, fx, out)
    for i in range(first, last):
        for j in range(out.shape[1]):
            out[i, j] *= gain[i, j]


@_compile
def _mix(first, last, values, empty, coarse, fy, fx, out):
    # rows are counted on the coarse grid
    row = np.empty(out.shape[1], dtype=out.dtype)
    for block in range(first, last):
        _unfold(coarse[block], fx, out.dtype.type(1), row)
        for i in range(block * fy, block * fy + fy):
            for j in range(out.shape[1]):
                out[i, j] = values[i, j] + empty[i, j] * row[j]


@_compile
def _around(up, here, down, across_y, across_x, diagonal, row, result):
    """Put the weighted means of the eight neighbours of the row `here` into `result`."""
    nx = here.size
    for j in range(nx):
        column = up[j] + down[j]
        row[j + 1] = across_x * here[j] + diagonal * column
        result[j] = across_y * column
    row[0], row[nx + 1] = row[nx], row[1]
    for j in range(nx):
        result[j] += row[j] + row[j + 2]


@_compile
def _neighbours(first, last, field, across_y, across_x, diagonal, out):
    ny, nx = field.shape
    row = np.empty(nx + 2, dtype=field.dtype)
    for i in range(first, last):
        up, down = field[_before(i, ny)], field[_after(i, ny)]
        _around(up, field[i], down, across_y, across_x, diagonal, row, out[i])


@_compile
def _fill(first, last, values, empty, mixed, across_y, across_x, diagonal, out):
    ny, nx = mixed.shape
    row, result = np.empty(nx + 2, dtype=mixed.dtype), np.empty(nx, dtype=mixed.dtype)
    for i in range(first, last):
        up, down = mixed[_before(i, ny)], mixed[_after(i, ny)]
        _around(up, mixed[i], down, across_y, across_x, diagonal, row, result)
        for j in range(nx):
            out[i, j] = values[i, j] + empty[i, j] * result[j]


@_compile
def _mixed_row(i, values, active, coarse, fy, fx, row, out):
    zero = out.dtype.type(0)
    _unfold(coarse[i // fy], fx, out.dtype.type(1), row)
    for j in range(out.size):
        out[j] = values[i, j] + (row[j] if active[i, j] == zero else zero)


@_compile
def _fill_from(first, last, values, active, coarse, fy, fx, across_y, across_x, diagonal, out):
    ny, nx = values.shape
    zero = out.dtype.type(0)
    row, result = np.empty(nx + 2, dtype=out.dtype), np.empty(nx, dtype=out.dtype)
    mixed = np.empty((3, nx), dtype=out.dtype)  # the row before, this one and the next, in turns
    _mixed_row(_before(first, ny), values, active, coarse, fy, fx, result, mixed[2])
    _mixed_row(first, values, active, coarse, fy, fx, result, mixed[0])
    for i in range(first, last):
        here = (i - first) % 3
        _mixed_row(_after(i, ny), values, active, coarse, fy, fx, result, mixed[(here + 1) % 3])
        up, down = mixed[(here + 2) % 3], mixed[(here + 1) % 3]
        _around(up, mixed[here], down, across_y, across_x, diagonal, row, result)
        for j in range(nx):
            out[i, j] = values[i, j] + (result[j] if active[i, j] == zero else zero)


@_compile
def _empty_neighbours(first, last, field, empty, across_y, across_x, diagonal, out):
    ny, nx = field.shape
    row = np.empty(nx + 2, dtype=field.dtype)
    for i in range(first, last):
        up, down = _before(i, ny), _after(i, ny)
        for j in range(nx):
            column = field[up, j] * empty[up, j] + field[down, j] * empty[down, j]
            row[j + 1] = across_x * (field[i, j] * empty[i, j]) + diagonal * column
            out[i, j] = across_y * column
        row[0], row[nx + 1] = row[nx], row[1]
        for j in range(nx):
            out[i, j] += row[j] + row[j + 2]


@_compile
def _gather(first, last, field, empty, fy, fx, out):
    columns = np.empty(field.shape[1], dtype=field.dtype)
    for block in range(first, last):
        columns[:] = 0
        for i in range(block * fy, block * fy + fy):
            for j in range(field.shape[1]):
                columns[j] += field[i, j] * empty[i, j]
        _fold(columns, fx, out.dtype.type(1), out[block])


@_compile
def _empty_row(i, field, active, out):
    zero = out.dtype.type(0)
    for j in range(out.size):
        out[j] = field[i, j] if active[i, j] == zero else zero


@_compile
def _empty_from(first, last, field, active, across_y, across_x, diagonal, passed, fy, fx, coarse):
    # rows are counted on the coarse grid
    ny, nx = field.shape
    zero = field.dtype.type(0)
    row, columns = np.empty(nx + 2, dtype=field.dtype), np.empty(nx, dtype=field.dtype)
    gaps = np.empty((3, nx), dtype=field.dtype)  # the row before, this one and the next, in turns
    start = first * fy
    _empty_row(_before(start, ny), field, active, gaps[2])
    _empty_row(start, field, active, gaps[0])
    for block in range(first, last):
        columns[:] = 0
        for i in range(block * fy, block * fy + fy):
            here = (i - start) % 3
            _empty_row(_after(i, ny), field, active, gaps[(here + 1) % 3])
            up, down = gaps[(here + 2) % 3], gaps[(here + 1) % 3]
            _around(up, gaps[here], down, across_y, across_x, diagonal, row, passed[i])
            for j in range(nx):
                columns[j] += passed[i, j] if active[i, j] == zero else zero
        _fold(columns, fx, coarse.dtype.type(1), coarse[block])


@_compile
def _spread(first, last, field, gain, coarse, fy, fx):
    # rows are counted on the coarse grid
    row = np.empty(field.shape[1], dtype=field.dtype)
    share = field.dtype.type(1 / (fy * fx))
    for block in range(first, last):
        _unfold(coarse[block], fx, share, row)
        for i in range(block * fy, block * fy + fy):
            for j in range(row.size):
                field[i, j] = gain[i, j] * (field[i, j] + row[j])


@_compile
def _finish_restriction(first, last, field, passed, coarse, fy, fx, active):
    # rows are counted on the coarse grid
    row = np.empty(field.shape[1], dtype=field.dtype)
    share = field.dtype.type(1 / (fy * fx))
    total = 0.0
    zero = field.dtype.type(0)
    for block in range(first, last):
        _unfold(coarse[block], fx, share, row)
        for i in range(block * fy, block * fy + fy):
            for j in range(row.size):
                z = field[i, j] + (passed[i, j] + row[j])
                z = zero if active[i, j] == zero else z
                field[i, j] = z
                total += z
    return total


@_compile
def _grid(store, table, number):
    """Return one grid of a store that holds the small grids of a pyramid one after the other."""
    ny, nx, start = table[number, 0], table[number, 1], table[number, 4]
    return store[start : start + ny * nx].reshape((ny, nx))


@_compile
def _weigh_small(empty, gain, means, work, table, weights):
    for number in range(len(table)):
        weight, share = _grid(means, table, number), _grid(work, table, number)
        more = number + 1 < len(table)
        if more:
            after = _grid(work, table, number + 1)
            fy, fx = table[number + 1, 2], table[number + 1, 3]
            _block_mean(0, len(after), share, fy, fx, after)
        gaps, gains = _grid(empty, table, number), _grid(gain, table, number)
        factors_y, factors_x, arrangement = table[number, 2], table[number, 3], table[number, 5]
        _weigh(0, len(share), weight, share, factors_y, factors_x, arrangement, gaps, gains)
        if more:
            after = _grid(means, table, number + 1)
            _block_mean(0, len(after), weight, fy, fx, after)


@_compile
def _mean_over_contact(field, empty):
    """Return the sum of `field` over that of the weights, which `empty` leaves of 1."""
    zero, one = field.dtype.type(0), field.dtype.type(1)
    total = weight = zero
    for i in range(field.shape[0]):
        for j in range(field.shape[1]):
            total += field[i, j]
            weight += one - empty[i, j]
    return total / weight if weight > zero else zero


@_compile
def _prolong_small(empty, gain, means, work, table, weights, sweeps, one, other):
    last = len(table) - 1
    for number in range(last):
        coarse = _grid(means, table, number + 1)
        fy, fx = table[number + 1, 2], table[number + 1, 3]
        _weighted_mean(
            0, len(coarse), _grid(means, table, number), fy, fx, _grid(gain, table, number + 1), coarse
        )
    for number in range(last, -1, -1):
        field, gaps, mixed = (
            _grid(means, table, number),
            _grid(empty, table, number),
            _grid(work, table, number),
        )
        across_y, across_x, diagonal = weights[number]
        if number == last:
            offset = _mean_over_contact(field, gaps)
            for i in range(field.shape[0]):
                for j in range(field.shape[1]):
                    mixed[i, j] = field[i, j] + gaps[i, j] * offset
            for sweep in range(1, sweeps):
                swept = one if sweep % 2 else other
                _fill(0, len(field), field, gaps, mixed, across_y, across_x, diagonal, swept)
                mixed = swept
        else:
            coarse = _grid(means, table, number + 1)
            fy, fx = table[number + 1, 2], table[number + 1, 3]
            _mix(0, len(coarse), field, gaps, coarse, fy, fx, mixed)
        _neighbours(0, len(field), mixed, across_y, across_x, diagonal, field)


@_compile
def _restrict_small(empty, gain, means, work, table, weights, sweeps, one, other):
    last = len(table) - 1
    for number in range(last + 1):
        total, gaps = _grid(work, table, number), _grid(empty, table, number)
        across_y, across_x, diagonal = weights[number]
        _neighbours(0, len(total), _grid(means, table, number), across_y, across_x, diagonal, total)
        if number < last:
            after = _grid(means, table, number + 1)
            _gather(0, len(after), total, gaps, table[number + 1, 2], table[number + 1, 3], after)
            continue
        passed = one
        passed[:] = total
        for sweep in range(1, sweeps):
            swept = other if sweep % 2 else one
            _empty_neighbours(0, len(total), passed, gaps, across_y, across_x, diagonal, swept)
            total += swept
            passed = swept
        total += _mean_over_contact(gaps * passed, gaps)
        total *= _grid(gain, table, number)
    for number in range(last - 1, -1, -1):
        fy, fx = table[number + 1, 2], table[number + 1, 3]
        coarse = _grid(work, table, number + 1)
        _spread(0, len(coarse), _grid(work, table, number), _grid(gain, table, number), coarse, fy, fx)


@_compile
def _continue(first, last, coarse, square):
    ny, nx = coarse.shape
    zero = coarse.dtype.type(0)
    most = np.empty(nx + 2, dtype=coarse.dtype)  # of the three cells in each column, one beyond each end
    for i in range(first, last):
        up, row, down = coarse[_wrap(i - 1, ny)], coarse[i], coarse[_wrap(i + 1, ny)]
        for j in range(nx):
            square[i, j] = row[j] * row[j]
            most[j + 1] = max(up[j], row[j], down[j])
        most[0], most[nx + 1] = most[nx], most[1]
        for j in range(nx):
            if row[j] > 0 or max(most[j], most[j + 1], most[j + 2]) <= 0:
                continue  # in contact, or far from any
            total, count = zero, 0
            for ey in range(-1, 2):
                for ex in range(-1, 2):
                    near = coarse[_wrap(i + ey, ny), _wrap(j + ex, nx)]
                    if near > 0:
                        far = coarse[_wrap(i + 2 * ey, ny), _wrap(j + 2 * ex, nx)]
                        total += near * near - (far * far - near * near if far > 0 else 2 * near * near)
                        count += 1
            if count:
                square[i, j] = min(total / count, zero)


@_compile
def _refine(first, last, coarse, square, fy, fx, out):
    # rows are counted on the coarse grid
    ny, nx = coarse.shape
    zero, one, half = coarse.dtype.type(0), coarse.dtype.type(1), coarse.dtype.type(0.5)
    roots = np.empty((fy, fx), dtype=coarse.dtype)
    out[first * fy : last * fy] = zero
    for i in range(first, last):
        for j in range(nx):
            if coarse[i, j] <= 0:
                continue
            total = zero
            for ky in range(fy):
                at_y = (ky + half) / fy - half
                beside_y = _wrap(i + 1 if at_y > 0 else i - 1, ny)
                share_y = abs(at_y)
                for kx in range(fx):
                    at_x = (kx + half) / fx - half
                    beside_x = _wrap(j + 1 if at_x > 0 else j - 1, nx)
                    share_x = abs(at_x)
                    here = (one - share_x) * square[i, j] + share_x * square[i, beside_x]
                    there = (one - share_x) * square[beside_y, j] + share_x * square[beside_y, beside_x]
                    roots[ky, kx] = np.sqrt(max((one - share_y) * here + share_y * there, zero))
                    total += roots[ky, kx]
            share = fy * fx * coarse[i, j] / total if total > 0 else zero
            for ky in range(fy):
                for kx in range(fx):
                    out[i * fy + ky, j * fx + kx] = share * roots[ky, kx] if total > 0 else coarse[i, j]


@_compile
def _before(i, ny):
    return i - 1 if i > 0 else ny - 1


@_compile
def _after(i, ny):
    return i + 1 if i < ny - 1 else 0


@_compile
def _wrap(index, size):
    """Return an index at most two periods off, brought back into the period."""
    while index < 0:
        index += size
    while index >= size:
        index -= size
    return index


@_compile
def _edge(share, shares, rows):
    return rows * share // shares


@_compile_shared
def _share_multiply(shares, rows, arguments):
    for share in numba.prange(shares):
        _multiply(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_divide(shares, rows, arguments):
    parts = np.empty(shares)
    for share in numba.prange(shares):
        parts[share] = _divide(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)
    return parts.sum()


@_compile_shared
def _share_slope_power(shares, rows, arguments):
    parts = np.empty(shares)
    for share in numba.prange(shares):
        parts[share] = _slope_power(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)
    return parts.sum()


@_compile_shared
def _share_extent(shares, rows, arguments):
    parts = np.empty((3, shares))
    for share in numba.prange(shares):
        part = _extent(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)
        for k in range(3):
            parts[k, share] = part[k]
    return parts[0].min(), parts[1].max(), parts[2].sum()


@_compile_shared
def _share_make_dimensionless(shares, rows, arguments):
    for share in numba.prange(shares):
        _make_dimensionless(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_measure(shares, rows, arguments):
    parts = np.empty((shares, 6))
    for share in numba.prange(shares):
        part = _measure(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)
        for k in range(6):
            parts[share, k] = part[k]
    return parts.sum(axis=0)


@_compile_shared
def _share_masked_residual(shares, rows, arguments):
    parts = np.empty(shares, dtype=np.int64)
    for share in numba.prange(shares):
        parts[share] = _masked_residual(
            _edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments
        )
    return parts.sum()


@_compile_shared
def _share_advance(shares, rows, arguments):
    for share in numba.prange(shares):
        _advance(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_redistribute(shares, rows, arguments):
    parts = np.empty((2, shares))
    for share in numba.prange(shares):
        part = _redistribute(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)
        parts[0, share], parts[1, share] = part
    return parts[0].sum(), parts[1].sum()


@_compile_shared
def _share_project(shares, rows, arguments):
    for share in numba.prange(shares):
        _project(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_rescale(shares, rows, arguments):
    for share in numba.prange(shares):
        _rescale(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_project_residual(shares, rows, arguments):
    parts = np.empty(shares)
    for share in numba.prange(shares):
        parts[share] = _project_residual(
            _edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments
        )
    return parts.sum()


@_compile_shared
def _share_restore_units(shares, rows, arguments):
    parts = np.empty((2, shares))
    for share in numba.prange(shares):
        part = _restore_units(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)
        parts[0, share], parts[1, share] = part
    return parts[0].min(), parts[1].sum()


@_compile_shared
def _share_block_mean(shares, rows, arguments):
    for share in numba.prange(shares):
        _block_mean(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_active_share(shares, rows, arguments):
    for share in numba.prange(shares):
        _active_share(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_weigh(shares, rows, arguments):
    for share in numba.prange(shares):
        _weigh(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_weighted_mean(shares, rows, arguments):
    for share in numba.prange(shares):
        _weighted_mean(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_mix(shares, rows, arguments):
    for share in numba.prange(shares):
        _mix(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_neighbours(shares, rows, arguments):
    for share in numba.prange(shares):
        _neighbours(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_fill(shares, rows, arguments):
    for share in numba.prange(shares):
        _fill(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_fill_from(shares, rows, arguments):
    for share in numba.prange(shares):
        _fill_from(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_empty_neighbours(shares, rows, arguments):
    for share in numba.prange(shares):
        _empty_neighbours(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_gather(shares, rows, arguments):
    for share in numba.prange(shares):
        _gather(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_empty_from(shares, rows, arguments):
    for share in numba.prange(shares):
        _empty_from(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_spread(shares, rows, arguments):
    for share in numba.prange(shares):
        _spread(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_finish_restriction(shares, rows, arguments):
    parts = np.empty(shares)
    for share in numba.prange(shares):
        parts[share] = _finish_restriction(
            _edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments
        )
    return parts.sum()


@_compile_shared
def _share_continue(shares, rows, arguments):
    for share in numba.prange(shares):
        _continue(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)


@_compile_shared
def _share_refine(shares, rows, arguments):
    for share in numba.prange(shares):
        _refine(_edge(share, shares, rows), _edge(share + 1, shares, rows), *arguments)
