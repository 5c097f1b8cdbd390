"""The grid kernels of the iteration, for any array library: this module defines what each of them computes.

They use the functions of the Python array API on fields (ny, nx) and spectra (ny, nx//2 + 1) as of
`numpy.fft.rfft2`, and write to preallocated arrays. All quantities are dimensionless, sums in double
precision. Recurring arguments:

- `separation`: displacement less height; `offset`: separation of a closed gap; - `cap`: upper limit of the
pressure, possibly infinite; - `factors` (fy, fx): cells of the fine grid in a cell of the coarse one;
`coarse`: field over the coarse cells; - `weights`: those of a neighbour across y, across x, and diagonal; -
`empty`: 1 - weight of each cell, where the weight is the relative linear size of its contact; - `active`,
`free`: nonzero on the active set, and where the pressure lies between its bounds; `out`: output.
"""

from collections.abc import Sequence
from typing import Any

from roughcontact.kernels.arrays import Array, n_elements, namespace
from roughcontact.kernels.protocol import Arrangement, Cells, Factors, Former, Heights, Weights

CLOSED = 1e-30  # replaces a gap of zero at a point of the active set
NEGLIGIBLE_LOAD = 1e-5  # share of the load of a cell; smaller loads of its parts are rounding errors
_ALL_BUT_MEAN = (0, slice(1, None)), (slice(1, None), slice(None))  # of a spectrum


def mean(field: Array) -> float:
    """Return the mean of a field, summed in double precision."""
    return _sum(namespace(field), field) / n_elements(field)


def multiply(spectrum: Array, symbol: Array) -> None:
    """Multiply the complex `spectrum` in place by the `symbol` of an operator; q = 0 becomes zero."""
    for block in _ALL_BUT_MEAN:
        spectrum[block] *= symbol[block]
    spectrum[0, 0] = 0


def divide(spectrum: Array, symbol: Array, weights: Array) -> float:
    """Divide the complex `spectrum` in place by the `symbol` of an operator; q = 0 becomes zero.

    Returns the sum of |s|^2 / symbol over the waves but q = 0. `weights`, shape (nx//2 + 1,), are the numbers
    of waves of the full plane per column.
    """
    xp, energy = namespace(spectrum), 0.0
    for block in _ALL_BUT_MEAN:
        # before the division: u p, not p squared
        energy += _sum(xp, weights[block[1]] * (_power(xp, spectrum[block]) / symbol[block]))
        spectrum[block] /= symbol[block]
    spectrum[0, 0] = 0
    return energy


def _power(xp: Any, spectrum: Array) -> Array:
    return xp.real(spectrum) ** 2 + xp.imag(spectrum) ** 2


def inverse_root(along_y: Array, along_x: Array, out: Array) -> None:
    """Write 2 / sqrt(y + x) to `out`: y of `along_y`, shape (ny,), for the row, x for the column.

    It is infinite where the sum is zero, as the symbol 2/|q| of a half-space is.
    """
    xp = namespace(out)
    square = along_y[:, None] + along_x
    # of q = 0, without a division by zero
    out[...] = xp.where(square == 0, xp.full_like(square, float("inf")), 2 / xp.sqrt(_or_one(xp, square)))


def slope_power(spectrum: Array, weights: Array, along_y: Array, along_x: Array) -> float:
    """Return the weighted sum of |s|^2 (y + x) over the waves.

    y is the value of `along_y`, shape (ny,), for the row, x that of `along_x`, shape (nx//2 + 1,), for the
    column; both and `weights`, the numbers of waves of the full plane per column, are in float64.
    """
    xp = namespace(spectrum)
    return _sum(xp, _power(xp, spectrum) * (weights * (along_y[:, None] + along_x)))


def extent(field: Array) -> tuple[float, float, int]:
    """Return the smallest and the largest value, and the number of infinite values and NaN.

    The first two are meaningless if there are non-finite values.
    """
    xp = namespace(field)
    finite = xp.isfinite(field)
    missing = n_elements(field) - int(xp.count_nonzero(finite))
    return float(xp.min(field)), float(xp.max(field)), missing


def make_dimensionless(heights: Array, reference: float, unit: float, out: Array) -> None:
    """Write (`heights` - `reference`) / `unit` to `out`; all three in one unit of height."""
    xp = namespace(heights)
    out[...] = xp.astype((heights - reference) / unit, out.dtype)


def measure(separation: Array, heights: Heights, former: Former, pressure: Array, cap: float) -> Array:
    """Subtract the heights from the displacement in `separation`, in place; return six sums over the grid.

    They are: pressure x displacement; displacement squared; separation over the free contact {0 < p < cap},
    and the number of its points; change of pressure x separation before the step, and after it, both less
    the offset, which cancels except for rounding. Heights count as (height - reference) / unit.
    """
    xp, (field, reference, unit), (start, previous, offset) = namespace(pressure), heights, former
    displacement = xp.asarray(separation, copy=True)  # overwritten below
    separation -= (field - reference) / unit
    free = (pressure > 0) & (pressure < cap)
    change = pressure - start
    return (
        _sum(xp, pressure * displacement),
        _sum(xp, displacement * displacement),
        _sum(xp, xp.where(free, separation, xp.zeros_like(separation))),
        int(xp.count_nonzero(free)),
        _sum(xp, change * (previous - offset)),
        _sum(xp, change * (separation - offset)),
    )


def masked_residual(
    pressure: Array, separation: Array, offset: float, cap: float, values: Array, cells: Cells
) -> None:
    """Write the gap on the active set to `values`, zero elsewhere.

    See `active_set`. A gap of zero on the active set is replaced by `CLOSED`, so that the values are zero at
    inactive points only. The share of active points, and the mean of the values, go to the `cells`.
    """
    xp = namespace(pressure)
    gap = separation - offset
    active = active_set(pressure, gap, cap)
    values[...] = xp.astype(xp.where(active, gap, xp.zeros_like(gap)), values.dtype)
    # zero stands for "not active": an active point whose gap is closed needs another value
    values[...] = xp.where(active & (values == 0), xp.full_like(values, CLOSED), values)
    _to_cells(values, cells)


def predict_active(
    pressure: Array,
    residual: Array,
    weights: Weights,
    stiffness: float,
    cap: float,
    values: Array,
    cells: Cells,
) -> None:
    """Set `values` to zero where points are predicted to lose contact; the rest as in `masked_residual`.

    The predicted pressure is p - `stiffness` (residual - mean over its eight neighbours), as in a primal-dual
    active-set method (Hintermueller, Ito and Kunisch 2002, SIAM J. Optim. 13, 865). Points at the cap remain
    active.
    """
    xp = namespace(pressure)
    mean_around = xp.empty_like(residual)
    neighbours(residual, weights, mean_around)
    # the stiffness of a single point: pressure over its height above its neighbours
    prediction = pressure - stiffness * (residual - mean_around)
    # what bears the cap does not lose its contact
    active = (values != 0) & ((prediction > 0) | (pressure >= cap))
    values[...] = xp.where(active, values, xp.zeros_like(values))
    _to_cells(values, cells)


def advance(
    pressure: Array,
    correction: Array,
    inflow: Array,
    coarse: Array,
    factors: Factors,
    mean: float,
    length: float,
    cap: float,
    out: Array,
    values: Array,
    share: Array,
) -> None:
    """Write p - `length` (c - `mean`), projected onto [0, `cap`], to `out`; c is as in `finish_restriction`.

    `values` are zero at inactive points, which keep the pressure of the cap or become zero; they become 1
    between the bounds, else 0, and `share`, which may be `coarse`, their mean over blocks. `correction` takes
    the pressure removed.
    """
    xp = namespace(pressure)
    active, full = values != 0, pressure >= cap
    full_correction = correction + (inflow + _distributed(coarse, factors, pressure.shape))
    next_pressure = xp.astype(pressure, out.dtype)
    next_pressure[full] = cap  # what yields bears the cap exactly, whatever rounding has made of it
    next_pressure -= xp.where(active, length * (full_correction - mean), xp.zeros_like(full_correction))
    projection = _clipped(xp, next_pressure, cap)
    # inactive points stay without load
    projection = xp.where(active | full, projection, xp.zeros_like(projection))
    out[...] = projection
    values[...] = xp.astype((projection > 0) & (projection < cap), values.dtype)
    correction[...] = xp.astype(next_pressure - projection, correction.dtype)
    block_mean(values, factors, share)


def redistribute(
    field: Array, inflow: Array, coarse: Array, factors: Factors, free: Array, cap: float
) -> tuple[float, float]:
    """Add `inflow`, and `coarse` distributed over its fine cells, to `field` where `free` is not zero.

    Returns the sum of the absolute excess of the field beyond [0, `cap`], and the sum of the field projected
    onto this interval.
    """
    xp = namespace(field)
    incoming = inflow + _distributed(coarse, factors, field.shape)
    field += xp.astype(incoming * (1 - _zero_indicator(free)), field.dtype)
    projection = _clipped(xp, field, cap)
    return _sum(xp, xp.abs(field - projection)), _sum(xp, projection)


def project(
    field: Array, cap: float, removed_load: Array, free: Array, factors: Factors, share: Array
) -> None:
    """Project `field` in place onto [0, `cap`] and write the removed part to `removed_load`.

    `free` becomes 1 between the bounds and 0 elsewhere, `share` its mean over blocks of `factors` cells.
    """
    xp = namespace(field)
    projection = _clipped(xp, field, cap)
    removed_load[...] = xp.astype(field - projection, removed_load.dtype)
    free[...] = xp.astype((projection > 0) & (projection < cap), free.dtype)
    field[...] = projection
    block_mean(free, factors, share)


def rescale(field: Array, factor: float, cap: float) -> float:
    """Project `field` in place onto [0, `cap`] and multiply it by `factor`; return its sum."""
    xp = namespace(field)
    field[...] = _clipped(xp, field, cap) * factor
    return _sum(xp, field)


def product(u: Array, v: Array) -> float:
    """Return the sum of `u` x `v` over the grid."""
    return _sum(namespace(u), u * v)


def project_residual(pressure: Array, separation: Array, offset: float, cap: float, values: Array) -> float:
    """Project `values` onto the residuals that a certificate admits; return the sum of squared changes.

    Admitted are values <= gap where p = 0 and >= gap at the cap.
    """
    xp = namespace(pressure)
    gap = xp.astype(separation - offset, values.dtype)
    projection = xp.where(pressure <= 0, xp.minimum(values, gap), values)
    projection = xp.where(pressure >= cap, xp.maximum(projection, gap), projection)
    change = projection - values
    values[...] = projection
    return _sum(xp, change * change)


def restore_units(
    pressure: Array, gap: Array, offset: float, pressure_unit: float, gap_unit: float, contact: Array
) -> tuple[float, float]:
    """Subtract `offset` from the gap, multiply gap and pressure by their units, and mark the contact.

    `contact` becomes 1 where the pressure is positive, 0 elsewhere. Returns the smallest gap and the sum of
    the pressure, in their units.
    """
    xp = namespace(pressure)
    gap -= offset
    gap *= gap_unit
    pressure *= pressure_unit
    contact[...] = xp.astype(pressure > 0, contact.dtype)
    return float(xp.min(gap)), _sum(xp, pressure)


def block_mean(field: Array, factors: Factors, out: Array) -> None:
    """Write the means of `field` over blocks of `factors` cells to `out`.

    Missing cells in the last block of a row or a column count as zero.
    """
    xp = namespace(field)
    for axis in (0, 1):
        # the last block may be incomplete: what is missing counts as zero
        missing = out.shape[axis] * factors[axis] - field.shape[axis]
        if missing:
            shape = (missing, field.shape[1]) if axis == 0 else (field.shape[0], missing)
            field = xp.concat([field, xp.zeros(shape, dtype=field.dtype, device=field.device)], axis=axis)
    (ny, nx), (fy, fx) = out.shape, factors
    out[...] = xp.mean(xp.reshape(field, (ny, fy, nx, fx)), axis=(1, 3))


def weigh(
    fine_share: Array,
    share: Array,
    factors: Factors,
    arrangement: Arrangement,
    empty: Array,
    gain: Array,
    coarser: Cells,
) -> None:
    """Compute the weight of every cell from the mean weight of its parts; write their ratio to `gain`.

    The weight is the relative linear size of the contact: the root of its `share` in one piece, the sum of
    the sizes of its parts if they are far apart, reduced by mutual shielding; the geometric mean for an
    unknown arrangement. `empty`, which may be the array `fine_share`, becomes 1 - weight, and the means over
    blocks, and those of the share, go to the cells of the `coarser` grid.
    """
    xp, count = namespace(share), factors[0] * factors[1]
    if arrangement == Arrangement.ALONG_A_LINE:
        # the displacement beside a line varies as the logarithm of the distance: each coarser grid adds a
        # constant to the reciprocal of the weight, and contacts add like conductors in parallel
        weight = count * fine_share / (1 + (count - 1) * fine_share)
    else:
        root_share, perimeter = xp.sqrt(share), fine_share * count**0.5
        clusters = perimeter / (1 + perimeter - root_share)
        weight = clusters if arrangement == Arrangement.SCATTERED else xp.sqrt(root_share * clusters)
    gain[...] = weight / _or_one(xp, fine_share)
    empty[...] = 1 - weight
    next_factors, next_parts, next_share = coarser
    block_mean(weight, next_factors, next_parts)
    block_mean(share, next_factors, next_share)


def mix(values: Array, empty: Array, coarse: Array, factors: Factors, out: Array) -> None:
    """Write `values` + `empty` x `coarse`, each coarse cell repeated `factors` times, to `out`."""
    out[...] = values + empty * repeat(coarse, factors, values.shape)


def neighbours(field: Array, weights: Weights, out: Array) -> None:
    """Write the weighted means of the eight neighbours, with periodic boundaries, to `out`."""
    xp = namespace(field)
    across_y, across_x, diagonal = weights
    # three passes instead of nine: the stencil is the same on both sides
    column = xp.roll(field, 1, axis=0) + xp.roll(field, -1, axis=0)
    row = across_x * field + diagonal * column
    out[...] = xp.roll(row, 1, axis=1) + xp.roll(row, -1, axis=1) + across_y * column


def fill(values: Array, empty: Array, source: Array, weights: Weights, out: Array) -> None:
    """Write `values` + `empty` x the neighbours' means of `source` to `out`."""
    neighbours(source, weights, out)
    out[...] = values + empty * out


def fill_from(
    values: Array, active: Array, coarse: Array, factors: Factors, weights: Weights, out: Array
) -> None:
    """Write `values` + empty x the neighbours' means of the mixture of `values` and `coarse` to `out`.

    The mixture is `values` + empty x `coarse`, each coarse cell repeated `factors` times, with empty 1 where
    `active` is zero and 0 elsewhere.
    """
    empty = _zero_indicator(active)
    fill(values, empty, values + empty * repeat(coarse, factors, values.shape), weights, out)


def empty_neighbours(field: Array, empty: Array, weights: Weights, out: Array) -> None:
    """Write the neighbours' means of `empty` x `field` to `out`, the transpose of filling."""
    neighbours(empty * field, weights, out)


def gather(field: Array, empty: Array, factors: Factors, out: Array) -> None:
    """Write the sums of `empty` x `field` over blocks of cells to `out`, the transpose of mixing."""
    block_mean(empty * field, factors, out)
    out *= factors[0] * factors[1]


def empty_from(
    field: Array, active: Array, weights: Weights, inflow: Array, factors: Factors, coarse: Array
) -> None:
    """Write the neighbours' means of empty x `field` to `inflow`, and gather them into `coarse`.

    `empty` is defined as in `fill_from`; together with `finish_restriction` this is the transpose of that.
    """
    empty = _zero_indicator(active)
    empty_neighbours(field, empty, weights, inflow)
    gather(inflow, empty, factors, coarse)


def spread(field: Array, gain: Array, coarse: Array, factors: Factors) -> None:
    """Add `coarse`, distributed over its fine cells, to `field`, and multiply the sum by `gain`."""
    field += _distributed(coarse, factors, field.shape)
    field *= gain


def finish_restriction(field: Array, inflow: Array, coarse: Array, factors: Factors, active: Array) -> float:
    """Add `inflow` and distributed `coarse` to `field` on the active set, and return the sum of the field.

    The field becomes zero elsewhere.
    """
    xp = namespace(field)
    incoming = inflow + _distributed(coarse, factors, field.shape)
    field[...] = (field + incoming) * (1 - _zero_indicator(active))
    return _sum(xp, field)


def refine(
    coarse: Array,
    factors: Factors,
    heights: Array,
    weights: Weights,
    stiffness: float,
    cap: float,
    out: Array,
) -> None:
    """Prolongate the pressure `coarse` to a grid `factors` times finer; each coarse cell keeps its load.

    The square of the pressure, linear towards the edge of a contact (Johnson 1985, chapter 4), is
    interpolated beyond it, and its root distributes the load of a cell. Fine detail is added: the height
    above the mean of the neighbours, times `stiffness`; excess is subtracted evenly from parts above zero,
    load beyond the cap passed on in the cell.
    """
    xp = namespace(coarse)
    # the pressure of a smooth contact falls as a root at its edge: its square is nearly linear there
    square = _continued(xp, coarse * coarse)
    (fy, fx), (ny, nx) = factors, coarse.shape
    neighbours(heights, weights, out)
    detail = xp.reshape(stiffness * (heights - out), (ny, fy, nx, fx))
    blocks = xp.reshape(out, (ny, fy, nx, fx))
    for ky in range(fy):
        for kx in range(fx):
            # position of the fine cell, in coarse cells from the middle of its own
            at_y, at_x = (ky + 0.5) / fy - 0.5, (kx + 0.5) / fx - 0.5
            along_x = _shifted(xp, square, at_x, 1)
            blocks[:, ky, :, kx] = xp.sqrt(xp.clip(_shifted(xp, along_x, at_y, 0), 0, None))
    total = xp.sum(blocks, axis=(1, 3))
    load = fy * fx * coarse
    blocks *= (load / _or_one(xp, total))[:, None, :, None]
    # height above the neighbours carries more, as much as a single point would
    blocks += detail
    blocks -= _level(xp, blocks, load)
    # a sliver of load would keep a point in contact that should leave it
    blocks *= xp.astype(blocks > (NEGLIGIBLE_LOAD * load)[:, None, :, None], blocks.dtype)
    total = xp.sum(blocks, axis=(1, 3))
    blocks *= (load / _or_one(xp, total))[:, None, :, None]
    lost = xp.where(total == 0, coarse, xp.zeros_like(coarse))  # where rounding leaves no load
    blocks += lost[:, None, :, None]
    if cap < float("inf"):
        blocks = _limit_to_cap(xp, blocks, load, cap)
        # a coarse cell that yields as a whole does so in all its parts
        blocks[xp.broadcast_to((coarse >= cap)[:, None, :, None], blocks.shape)] = cap
    out[...] = xp.reshape(blocks, out.shape)


def _level(xp: Any, blocks: Array, load: Array) -> Array:
    """Return the level whose subtraction from the parts of every cell leaves its `load` above zero."""
    level = xp.full_like(load, -float("inf"))[:, None, :, None]
    for _ in range(blocks.shape[1] * blocks.shape[3]):  # each round excludes the lowest parts
        above = xp.astype(blocks > level, blocks.dtype)
        count = xp.sum(above, axis=(1, 3))
        candidate = (xp.sum(above * blocks, axis=(1, 3)) - load) / _or_one(xp, count)
        level = xp.where((count > 0)[:, None, :, None], candidate[:, None, :, None], level)
    return level


def _limit_to_cap(xp: Any, blocks: Array, load: Array, cap: float) -> Array:
    """Return the parts of every cell limited to the cap; its other parts carry the remaining `load`."""
    count = blocks.shape[1] * blocks.shape[3]
    for _ in range(count):  # each round more parts may reach the cap
        below = blocks < cap
        number = xp.sum(xp.astype(below, load.dtype), axis=(1, 3))
        remaining_load = xp.clip(load - cap * (count - number), 0, None)
        free_load = xp.sum(xp.where(below, blocks, xp.zeros_like(blocks)), axis=(1, 3))
        factor = remaining_load / xp.where(free_load > 0, free_load, xp.ones_like(free_load))
        share = remaining_load / _or_one(xp, number)
        even = xp.where(free_load > 0, xp.zeros_like(share), share)
        even_share = blocks * factor[:, None, :, None] + even[:, None, :, None]
        blocks = xp.where(below, even_share, xp.full_like(blocks, cap))
        if not xp.any(blocks > cap):
            break
    return blocks


def _continued(xp: Any, square: Array) -> Array:
    """Return `square`, extrapolated linearly from the contact {> 0} to negative values in the next cells."""
    total, count = xp.zeros_like(square), xp.zeros_like(square)
    for ey in (-1, 0, 1):
        for ex in (-1, 0, 1):
            if (ey, ex) != (0, 0):
                neighbour = xp.roll(square, (ey, ex), axis=(0, 1))
                second_neighbour = xp.roll(square, (2 * ey, 2 * ex), axis=(0, 1))
                # by two cells in a row where there are two, else mirrored to the opposite sign
                guess = xp.where(second_neighbour > 0, 2 * neighbour - second_neighbour, -neighbour)
                total += xp.where(neighbour > 0, guess, xp.zeros_like(neighbour))
                count += xp.astype(neighbour > 0, square.dtype)
    extrapolation = xp.clip(total / _or_one(xp, count), None, 0)
    return xp.where(square > 0, square, extrapolation)


def _shifted(xp: Any, field: Array, offset: float, axis: int) -> Array:
    """Return `field` interpolated linearly at `offset` cells, |offset| < 1, along an axis."""
    share = abs(offset)
    return (1 - share) * field + share * xp.roll(field, -1 if offset > 0 else 1, axis=axis)


def repeat(field: Array, factors: Factors, shape: tuple[int, ...]) -> Array:
    """Return `field` with every cell repeated `factors` times, cropped to `shape`."""
    xp = namespace(field)
    return xp.repeat(xp.repeat(field, factors[0], axis=0), factors[1], axis=1)[: shape[0], : shape[1]]


def active_set(pressure: Array, gap: Array, cap: float) -> Array:
    """Return the active set: the points whose gap must vanish in the solution, as far as is known.

    They carry a pressure below the cap, overlap without pressure, or have a positive gap at the cap.
    """
    no_load, at_cap = pressure <= 0, pressure >= cap
    # points that bear nothing but overlap, points at the cap that have opened, and all in between
    return (no_load & (gap < 0)) | (at_cap & (gap > 0)) | ~(no_load | at_cap)


def _to_cells(values: Array, cells: Cells) -> None:
    """Write the share of `values` that are not zero, and their mean, to the fields of `cells`."""
    factors, share, means = cells
    block_mean(namespace(values).astype(values != 0, share.dtype), factors, share)
    block_mean(values, factors, means)


def _distributed(coarse: Array, factors: Factors, shape: tuple[int, ...]) -> Array:
    """Return the load of coarse cells, shared evenly by their fine cells."""
    return repeat(coarse, factors, shape) / (factors[0] * factors[1])


def _clipped(xp: Any, pressure: Array, cap: float) -> Array:
    """Return a pressure projected onto [0, `cap`]."""
    return xp.clip(pressure, 0, None if cap == float("inf") else cap)


def _or_one(xp: Any, field: Array) -> Array:
    """Return a divisor: `field`, and 1 where it is zero."""
    return xp.where(field == 0, xp.ones_like(field), field)


def _zero_indicator(field: Array) -> Array:
    """Return 1 where `field` is zero and 0 elsewhere."""
    xp = namespace(field)
    return xp.astype(field == 0, field.dtype)


def _sum(xp: Any, field: Array) -> float:
    return float(xp.sum(field, dtype=xp.float64))


def small_grids(grids: Sequence[Any], stores: Sequence[Array], stops: Sequence[int]) -> None:
    """Return None, not `CompiledSmallGrids`: these kernels process every grid of a hierarchy separately.

    `stores` is the memory of the fields of all `grids`, `stops` the end of each grid in it.
    """
