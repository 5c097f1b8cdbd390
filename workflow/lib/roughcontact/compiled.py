"""The kernels of `roughcontact.kernels`, compiled by Numba: one sweep through memory each.

What they compute is said there; tests compare the two. Every function works on the rows from `first` to
`last`, so that threads can share a grid: Numba releases Python's lock meanwhile.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise

import numba
import numpy as np

# Sums may be reordered, for the sake of vector instructions; infinities and NaN keep their meaning.
_compile = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})


class Compiled:
    """The kernels, run by `threads` threads."""

    SMALL = 256 * 256  # points below which starting threads costs more than they save

    def __init__(self, threads: int = 1):
        self.threads = threads

    def scale(self, spectrum, symbol, inverse):
        self._share(_scale, len(spectrum), spectrum, symbol, inverse)
        spectrum[0, 0] = 0

    def measure(
        self, displaced, heights, before_pressure, before_separation, level, pressure, separation, cap
    ):
        kind = pressure.dtype.type
        before = before_pressure, before_separation, kind(level)
        after = pressure, separation, kind(cap)
        parts = self._share(_measure, len(pressure), displaced, heights, *before, *after)
        return tuple(sum(part) for part in zip(*parts, strict=True))

    def remainder(self, pressure, separation, level, cap, values, empty):
        kind = separation.dtype.type
        return sum(
            self._share(
                _remainder, len(pressure), pressure, separation, kind(level), kind(cap), values, empty
            )
        )

    def advance(self, pressure, separation, product, level, mean, length, cap, block, out, wanted, found):
        kind, inner = pressure.dtype.type, product.dtype.type
        scalars = kind(level), inner(mean), inner(length), kind(cap)
        arrays = pressure, separation, product, *scalars, *block, out, wanted, found
        self._share(_advance, len(wanted), *arrays)

    def rescale(self, field, share, block, cap):
        self._share(_rescale, len(share), field, share, *block, field.dtype.type(cap))

    def hold(self, pressure, separation, level, cap, values):
        kind = separation.dtype.type
        return sum(self._share(_hold, len(values), pressure, separation, kind(level), kind(cap), values))

    def block_mean(self, field, factors, out):
        self._share(
            _block_mean, len(out), field, *factors, out, out.dtype.type(1 / (factors[0] * factors[1]))
        )

    def mix(self, values, empty, coarse, factors, out):
        self._share(_mix, len(coarse), values, empty, coarse, *factors, out)

    def neighbours(self, field, weights, out):
        self._share(_neighbours, len(out), field, *_cast(weights, field), out)

    def fill(self, values, empty, mixed, weights, out):
        self._share(_fill, len(out), values, empty, mixed, *_cast(weights, mixed), out)

    def empty_neighbours(self, field, empty, weights, out):
        self._share(_empty_neighbours, len(out), field, empty, *_cast(weights, field), out)

    def gather(self, field, empty, factors, out):
        self._share(_gather, len(out), field, empty, *factors, out)

    def spread(self, field, coarse, factors, share):
        self._share(_spread, len(coarse), field, coarse, *factors, field.dtype.type(share))

    def conclude(self, field, passed, values, empty):
        parts = self._share(_conclude, len(field), field, passed, values, empty)
        return tuple(sum(part) for part in zip(*parts, strict=True))

    def refine(self, coarse, factors, out):
        square = np.empty_like(coarse)
        self._share(_continue, len(coarse), coarse, square)
        self._share(_refine, len(coarse), coarse, square, *factors, out)

    def _share(self, kernel, rows, *arguments):
        """Return the results of a kernel on equal shares of `rows` rows."""
        if self.threads == 1:
            return [kernel(0, rows, *arguments)]
        edges = [rows * k // self.threads for k in range(self.threads + 1)]
        jobs = [
            _pool(self.threads).submit(kernel, first, last, *arguments) for first, last in pairwise(edges[1:])
        ]
        return [kernel(0, edges[1], *arguments), *(job.result() for job in jobs)]


def _cast(weights, field):
    return tuple(field.dtype.type(weight) for weight in weights)


@cache
def _pool(threads):
    return ThreadPoolExecutor(threads - 1)


@_compile
def _scale(first, last, spectrum, symbol, inverse):
    for i in range(first, last):
        for j in range(symbol.shape[1]):
            factor = symbol[i, j]
            spectrum[i, j] = spectrum[i, j] / factor if inverse else spectrum[i, j] * factor


@_compile
def _measure(first, last, displaced, heights, before_pressure, before, level, pressure, separation, cap):
    work = square = free_sum = slope = slope_after = 0.0
    free = 0
    for i in range(first, last):
        for j in range(pressure.shape[1]):
            p, u = pressure[i, j], displaced[i, j]
            v = u - heights[i, j]
            change = p - before_pressure[i, j]
            slope += change * (before[i, j] - level)
            slope_after += change * (v - level)
            separation[i, j] = v
            work += p * u
            square += u * u
            is_free = (p > 0) & (p < cap)
            free += is_free
            free_sum += v if is_free else 0 * v
    return work, square, free_sum, free, slope, slope_after


@_compile
def _remainder(first, last, pressure, separation, level, cap, values, empty):
    count = 0
    zero, one = values.dtype.type(0), values.dtype.type(1)
    for i in range(first, last):
        for j in range(pressure.shape[1]):
            p, gap = pressure[i, j], separation[i, j] - level
            none, full = p <= 0, p >= cap
            unsettled = (none & (gap < 0)) | (full & (gap > 0)) | ((not none) & (not full))
            values[i, j] = gap if unsettled else zero
            empty[i, j] = zero if unsettled else one
            count += unsettled
    return count


@_compile
def _advance(
    first, last, pressure, separation, product, level, mean, length, cap, by, bx, out, wanted, found
):
    # rows are counted in blocks
    zero = out.dtype.type(0)
    row_wanted = np.empty(out.shape[1], dtype=out.dtype)
    row_found = np.empty(out.shape[1], dtype=out.dtype)
    for block in range(first, last):
        row_wanted[:] = 0
        row_found[:] = 0
        for i in range(block * by, block * by + by):
            for j in range(pressure.shape[1]):
                p, gap = pressure[i, j], separation[i, j] - level
                none, full = p <= 0, p >= cap
                unsettled = (none & (gap < 0)) | (full & (gap > 0)) | ((not none) & (not full))
                moved = p - length * (product[i, j] - mean) if unsettled else p
                held = min(max(moved, zero), cap)
                beyond = held >= cap
                out[i, j] = held
                row_wanted[j] += moved - held if beyond else moved
                row_found[j] += zero if beyond else held
        for column in range(wanted.shape[1]):
            total = total_found = 0.0
            for j in range(column * bx, column * bx + bx):
                total += row_wanted[j]
                total_found += row_found[j]
            wanted[block, column], found[block, column] = total, total_found


@_compile
def _rescale(first, last, field, share, by, bx, cap):
    # rows are counted in blocks
    factor = np.empty(field.shape[1], dtype=field.dtype)
    for block in range(first, last):
        for j in range(field.shape[1]):
            factor[j] = share[block, j // bx]
        for i in range(block * by, block * by + by):
            for j in range(field.shape[1]):
                value = field[i, j]
                field[i, j] = value * factor[j] if value < cap else value


@_compile
def _hold(first, last, pressure, separation, level, cap, values):
    total = 0.0
    for i in range(first, last):
        for j in range(pressure.shape[1]):
            p, r = pressure[i, j], values[i, j]
            gap = values.dtype.type(separation[i, j] - level)
            held = min(r, gap) if p <= 0 else r
            held = max(held, gap) if p >= cap else held
            total += (held - r) * (held - r)
            values[i, j] = held
    return total


@_compile
def _block_mean(first, last, field, fy, fx, out, share):
    columns = np.empty(field.shape[1], dtype=field.dtype)
    for i in range(first, last):
        columns[:] = field[i * fy]
        for k in range(1, fy):
            for j in range(field.shape[1]):
                columns[j] += field[i * fy + k, j]
        for j in range(out.shape[1]):
            total = columns[j * fx]
            for k in range(1, fx):
                total += columns[j * fx + k]
            out[i, j] = total * share


@_compile
def _mix(first, last, values, empty, coarse, fy, fx, out):
    # rows are counted on the coarse grid
    row = np.empty(out.shape[1], dtype=out.dtype)
    for i in range(first, last):
        for j in range(coarse.shape[1]):
            for k in range(fx):
                row[j * fx + k] = coarse[i, j]
        for k in range(fy):
            for j in range(out.shape[1]):
                out[i * fy + k, j] = values[i * fy + k, j] + empty[i * fy + k, j] * row[j]


@_compile
def _neighbour_row(i, field, across_y, across_x, diagonal, row, result):
    ny, nx = field.shape
    up, down = i - 1 if i > 0 else ny - 1, i + 1 if i < ny - 1 else 0
    for j in range(nx):
        column = field[up, j] + field[down, j]
        row[j + 1] = across_x * field[i, j] + diagonal * column
        result[j] = across_y * column
    row[0], row[nx + 1] = row[nx], row[1]
    for j in range(nx):
        result[j] += row[j] + row[j + 2]


@_compile
def _neighbours(first, last, field, across_y, across_x, diagonal, out):
    row = np.empty(field.shape[1] + 2, dtype=field.dtype)
    for i in range(first, last):
        _neighbour_row(i, field, across_y, across_x, diagonal, row, out[i])


@_compile
def _fill(first, last, values, empty, mixed, across_y, across_x, diagonal, out):
    row = np.empty(mixed.shape[1] + 2, dtype=mixed.dtype)
    result = np.empty(mixed.shape[1], dtype=mixed.dtype)
    for i in range(first, last):
        _neighbour_row(i, mixed, across_y, across_x, diagonal, row, result)
        for j in range(mixed.shape[1]):
            out[i, j] = values[i, j] + empty[i, j] * result[j]


@_compile
def _empty_neighbours(first, last, field, empty, across_y, across_x, diagonal, out):
    ny, nx = field.shape
    row = np.empty(nx + 2, dtype=field.dtype)
    for i in range(first, last):
        up, down = i - 1 if i > 0 else ny - 1, i + 1 if i < ny - 1 else 0
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
    for i in range(first, last):
        columns[:] = 0
        for k in range(fy):
            for j in range(field.shape[1]):
                columns[j] += field[i * fy + k, j] * empty[i * fy + k, j]
        for j in range(out.shape[1]):
            total = columns[j * fx]
            for k in range(1, fx):
                total += columns[j * fx + k]
            out[i, j] = total


@_compile
def _spread(first, last, field, coarse, fy, fx, share):
    # rows are counted on the coarse grid
    row = np.empty(field.shape[1], dtype=field.dtype)
    for i in range(first, last):
        for j in range(coarse.shape[1]):
            for k in range(fx):
                row[j * fx + k] = share * coarse[i, j]
        for k in range(fy):
            for j in range(field.shape[1]):
                field[i * fy + k, j] += row[j]


@_compile
def _conclude(first, last, field, passed, values, empty):
    total = product = 0.0
    zero = field.dtype.type(0)
    for i in range(first, last):
        for j in range(field.shape[1]):
            z = field[i, j] + passed[i, j]
            z = zero if empty[i, j] > zero else z
            field[i, j] = z
            total += z
            product += z * values[i, j]
    return total, product


@_compile
def _continue(first, last, coarse, square):
    ny, nx = coarse.shape
    zero = coarse.dtype.type(0)
    for i in range(first, last):
        for j in range(nx):
            here = coarse[i, j]
            square[i, j] = here * here
            if here > 0:
                continue
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
def _wrap(index, size):
    """Return an index at most two periods off, brought back into the period."""
    while index < 0:
        index += size
    while index >= size:
        index -= size
    return index
