"""The grid kernels of the iteration, for any array library.

They use the library of their arrays (Python array API standard: NumPy, CuPy and others) and write to
preallocated arrays. This module implements `roughcontact.kernels.protocol.Kernels` and defines what each
kernel computes.
"""

from collections.abc import Sequence
from typing import Any

from roughcontact.kernels.arrays import Array
from roughcontact.kernels.protocol import Arrangement, Factors, Weights

CLOSED = 1e-30  # replaces a gap of zero at a point of the active set
NEGLIGIBLE_LOAD = 1e-5  # share of the load of a cell; smaller loads of its parts are rounding errors
_ALL_BUT_MEAN = (0, slice(1, None)), (slice(1, None), slice(None))  # of a spectrum


def mean(field: Array) -> float:
    """Return the mean of a field, summed in double precision.

    Parameters
    ----------
    field : array

    Returns
    -------
    float
    """
    return _sum(field.__array_namespace__(), field) / field.size


def multiply(spectrum: Array, symbol: Array) -> None:
    """Multiply `spectrum` by `symbol`; q = 0 becomes zero.

    Parameters
    ----------
    spectrum : array (ny, nx//2 + 1), complex
        multiplied in place.
    symbol : array (ny, nx//2 + 1)
        of an operator.
    """
    for part in _ALL_BUT_MEAN:
        spectrum[part] *= symbol[part]
    spectrum[0, 0] = 0


def divide(spectrum: Array, symbol: Array, weights: Array) -> float:
    """Divide `spectrum` by `symbol`; q = 0 becomes zero.

    Parameters
    ----------
    spectrum : array (ny, nx//2 + 1), complex
        divided in place.
    symbol : array (ny, nx//2 + 1)
        of an operator.
    weights : array (nx//2 + 1,)
        number of waves of the full plane per column.

    Returns
    -------
    float
        sum of |s|^2 / symbol over the waves but q = 0, in double precision.
    """
    xp, energy = spectrum.__array_namespace__(), 0.0
    for part in _ALL_BUT_MEAN:
        energy += _sum(xp, weights[part[1]] * (_power(xp, spectrum[part]) / symbol[part]))
        spectrum[part] /= symbol[part]
    spectrum[0, 0] = 0
    return energy


def _power(xp: Any, spectrum: Array) -> Array:
    return xp.real(spectrum) ** 2 + xp.imag(spectrum) ** 2


def slope_power(spectrum: Array, weights: Array, along_y: Array, along_x: Array) -> float:
    """Return the weighted sum of |s|^2 (y + x) over the waves, in double precision.

    y is the value of `along_y` for the row, x that of `along_x` for the column; both and `weights` are in
    float64.

    Parameters
    ----------
    spectrum : array (ny, nx//2 + 1), complex
    weights : array (nx//2 + 1,)
        number of waves of the full plane per column.
    along_y : array (ny,)
        by row.
    along_x : array (nx//2 + 1,)
        by column, float64.

    Returns
    -------
    float
    """
    xp = spectrum.__array_namespace__()
    return _sum(xp, _power(xp, spectrum) * (weights * (along_y[:, None] + along_x)))


def extent(field: Array) -> tuple[float, float, int]:
    """Return the smallest and the largest value, and the number of non-finite values.

    The first two are meaningless if there are non-finite values.

    Parameters
    ----------
    field : array (ny, nx)

    Returns
    -------
    least, largest : float
    missing : int
        number of infinite values and NaN.
    """
    xp = field.__array_namespace__()
    finite = xp.isfinite(field)
    missing = field.size - int(xp.count_nonzero(finite))
    return float(xp.min(field)), float(xp.max(field)), missing


def make_dimensionless(heights: Array, reference: float, unit: float, out: Array) -> None:
    """Write (`heights` - `reference`) / `unit` to `out`.

    Parameters
    ----------
    heights : array (ny, nx)
        in their own unit.
    reference : float
        height of zero in dimensionless units.
    unit : float
        unit of height.
    out : array
        output.
    """
    xp = heights.__array_namespace__()
    out[...] = xp.astype((heights - reference) / unit, out.dtype)


def measure(
    separation: Array,
    heights: Array,
    reference: float,
    unit: float,
    start: Array,
    before: Array,
    offset: float,
    pressure: Array,
    cap: float,
) -> Array:
    """Turn a displacement into the separation, by subtracting the heights, and return sums over the grid.

    The dimensionless height is (height - `reference`) / `unit`. The six sums, in double precision, are:
    pressure x displacement; displacement squared; separation over the free contact {0 < p < cap}, and the
    number of its points; change of pressure x separation `before` the step, and after it, both less `offset`,
    which cancels except for rounding. The change of pressure is relative to `start`.

    Parameters
    ----------
    separation : array (ny, nx)
        displacement; overwritten by the separation.
    heights : array (ny, nx)
        in their own unit.
    reference : float
        height of zero in dimensionless units.
    unit : float
        unit of height.
    start : array (ny, nx)
        pressure before the last step.
    before : array (ny, nx)
        separation before the last step.
    offset : float
        separation of a closed gap.
    pressure : array (ny, nx)
        dimensionless.
    cap : float
        largest pressure allowed.

    Returns
    -------
    tuple of float
        the six sums.
    """
    xp = pressure.__array_namespace__()
    displaced = xp.asarray(separation, copy=True)
    separation -= (heights - reference) / unit
    free = (pressure > 0) & (pressure < cap)
    change = pressure - start
    return (
        _sum(xp, pressure * displaced),
        _sum(xp, displaced * displaced),
        _sum(xp, xp.where(free, separation, xp.zeros_like(separation))),
        int(xp.count_nonzero(free)),
        _sum(xp, change * (before - offset)),
        _sum(xp, change * (separation - offset)),
    )


def masked_residual(pressure: Array, separation: Array, offset: float, cap: float, values: Array) -> int:
    """Write the gap on the active set to `values`, zero elsewhere; return the number of active points.

    See `active_set`. A gap of zero on the active set is replaced by `CLOSED`, so that the values are zero at
    inactive points only.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    separation : array (ny, nx)
        displacement less height.
    offset : float
        separation of a closed gap.
    cap : float
        largest pressure allowed.
    values : array (ny, nx)
        output.

    Returns
    -------
    int
    """
    xp = pressure.__array_namespace__()
    gap = separation - offset
    active = active_set(pressure, gap, cap)
    values[...] = xp.astype(xp.where(active, gap, xp.zeros_like(gap)), values.dtype)
    values[...] = xp.where(active & (values == 0), xp.full_like(values, CLOSED), values)
    return int(xp.count_nonzero(active))


def predict_active(
    pressure: Array, residual: Array, weights: Weights, stiffness: float, cap: float, values: Array
) -> int:
    """Set `values` to zero where a point is predicted to lose contact; return the number of active points.

    The predicted pressure is p - `stiffness` (residual - mean over its eight neighbours), as in a primal-dual
    active-set method [1]_, with the stiffness of a single point relative to its neighbours. Points at the cap
    remain active.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    residual : array (ny, nx)
        interpolated to all points.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    stiffness : float
        pressure over the height of a point above its neighbours.
    cap : float
        largest pressure allowed.
    values : array (ny, nx)
        zero at inactive points; updated.

    Returns
    -------
    int

    References
    ----------
    .. [1] Hintermueller, Ito and Kunisch (2002), SIAM J. Optim. 13, 865.
    """
    xp = pressure.__array_namespace__()
    mean_around = xp.empty_like(residual)
    neighbours(residual, weights, mean_around)
    foreseen = pressure - stiffness * (residual - mean_around)
    active = (values != 0) & ((foreseen > 0) | (pressure >= cap))
    values[...] = xp.where(active, values, xp.zeros_like(values))
    return int(xp.count_nonzero(active))


def advance(
    pressure: Array, correction: Array, mean: float, length: float, cap: float, out: Array, values: Array
) -> None:
    """Write p - length (correction - mean), projected onto [0, `cap`], to `out`.

    Inactive points at the cap keep their pressure, in the precision of `out`; the pressure of the others
    becomes zero. The pressure removed by the projection is written to `correction`. `values` become 1 between
    the bounds, 0 elsewhere.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    correction : array (ny, nx)
        of the pressure; overwritten.
    mean : float
        of the correction over the active set.
    length : float
        of the step.
    cap : float
        largest pressure allowed.
    out : array
        output.
    values : array (ny, nx)
        zero at inactive points; overwritten.
    """
    xp = pressure.__array_namespace__()
    active, full = values != 0, pressure >= cap
    moved = xp.astype(pressure, out.dtype)
    moved[full] = cap
    moved -= xp.where(active, length * (correction - mean), xp.zeros_like(correction))
    projected = xp.clip(moved, 0, None if cap == float("inf") else cap)
    projected = xp.where(active | full, projected, xp.zeros_like(projected))
    out[...] = projected
    values[...] = xp.astype((projected > 0) & (projected < cap), values.dtype)
    correction[...] = xp.astype(moved - projected, correction.dtype)


def redistribute(
    field: Array, passed: Array, coarse: Array, factors: Factors, free: Array, cap: float
) -> tuple[float, float]:
    """Add `passed`, and `coarse` distributed over its fine cells, to `field` where `free` is not zero.

    Parameters
    ----------
    field : array (ny, nx)
        receives the load.
    passed : array (ny, nx)
        load from the neighbours.
    coarse : array
        over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    free : array (ny, nx)
        nonzero where the field may receive load.
    cap : float
        largest pressure allowed.

    Returns
    -------
    outside, total : float
        sum of the absolute excess of the field beyond [0, `cap`], and sum of the field projected onto this
        interval, in double precision.
    """
    xp = field.__array_namespace__()
    shared = repeat(coarse, factors, field.shape) / (factors[0] * factors[1])
    field += xp.astype((passed + shared) * (1 - _zeros_of(free)), field.dtype)
    projected = xp.clip(field, 0, None if cap == float("inf") else cap)
    return _sum(xp, xp.abs(field - projected)), _sum(xp, projected)


def project(field: Array, cap: float, taken: Array, free: Array) -> None:
    """Project `field` onto [0, `cap`] and write the removed part to `taken`.

    `free` becomes 1 between the bounds and 0 elsewhere.

    Parameters
    ----------
    field : array (ny, nx)
        overwritten.
    cap : float
        largest pressure allowed.
    taken : array (ny, nx)
        output.
    free : array (ny, nx)
        output.
    """
    xp = field.__array_namespace__()
    projected = xp.clip(field, 0, None if cap == float("inf") else cap)
    taken[...] = xp.astype(field - projected, taken.dtype)
    free[...] = xp.astype((projected > 0) & (projected < cap), free.dtype)
    field[...] = projected


def rescale(field: Array, factor: float, cap: float) -> None:
    """Project `field` onto [0, `cap`] and multiply it by `factor`.

    Parameters
    ----------
    field : array (ny, nx)
        overwritten.
    factor : float
    cap : float
        largest pressure allowed.
    """
    xp = field.__array_namespace__()
    field[...] = xp.clip(field, 0, None if cap == float("inf") else cap) * factor


def project_residual(pressure: Array, separation: Array, offset: float, cap: float, values: Array) -> float:
    """Project `values` onto the residuals admitted by a certificate: <= gap where p = 0, >= gap at the cap.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    separation : array (ny, nx)
        displacement less height.
    offset : float
        separation of a closed gap.
    cap : float
        largest pressure allowed.
    values : array (ny, nx)
        overwritten.

    Returns
    -------
    float
        sum of the squared changes.
    """
    xp = pressure.__array_namespace__()
    gap = xp.astype(separation - offset, values.dtype)
    projected = xp.where(pressure <= 0, xp.minimum(values, gap), values)
    projected = xp.where(pressure >= cap, xp.maximum(projected, gap), projected)
    change = projected - values
    values[...] = projected
    return _sum(xp, change * change)


def restore_units(
    pressure: Array, gap: Array, offset: float, pressure_unit: float, gap_unit: float, contact: Array
) -> tuple[float, float]:
    """Subtract `offset` from the gap, multiply gap and pressure by their units, and mark the contact.

    Parameters
    ----------
    pressure : array (ny, nx)
        multiplied in place.
    gap : array (ny, nx)
        multiplied in place.
    offset : float
        separation of a closed gap.
    pressure_unit : float
        unit of pressure.
    gap_unit : float
        unit of gap.
    contact : array (ny, nx)
        receives 1 where the pressure is positive, 0 elsewhere.

    Returns
    -------
    least_gap, load : float
        smallest gap and sum of the pressure, in their units and in double precision.
    """
    xp = pressure.__array_namespace__()
    gap -= offset
    gap *= gap_unit
    pressure *= pressure_unit
    contact[...] = xp.astype(pressure > 0, contact.dtype)
    return float(xp.min(gap)), _sum(xp, pressure)


def block_mean(field: Array, factors: Factors, out: Array) -> None:
    """Write the means of `field` over blocks of `factors` cells to `out`.

    Missing cells in the last block of a row or a column count as zero.

    Parameters
    ----------
    field : array (ny, nx)
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    out : array
        over the coarse cells; output.
    """
    xp = field.__array_namespace__()
    for axis in (0, 1):
        missing = out.shape[axis] * factors[axis] - field.shape[axis]
        if missing:
            shape = (missing, field.shape[1]) if axis == 0 else (field.shape[0], missing)
            field = xp.concat([field, xp.zeros(shape, dtype=field.dtype, device=field.device)], axis=axis)
    (ny, nx), (fy, fx) = out.shape, factors
    out[...] = xp.mean(xp.reshape(field, (ny, fy, nx, fx)), axis=(1, 3))


def active_share(active: Array, factors: Factors, out: Array) -> None:
    """Write the share of points where `active` is not zero, over blocks of `factors` cells, to `out`.

    Parameters
    ----------
    active : array (ny, nx)
        nonzero on the active set.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    out : array
        over the coarse cells; output.
    """
    xp = active.__array_namespace__()
    block_mean(xp.astype(active != 0, out.dtype), factors, out)


def weigh(
    weight: Array, share: Array, factors: Factors, arrangement: Arrangement, empty: Array, gain: Array
) -> None:
    """Compute the weight of every cell from the mean weight of its parts; write their ratio to `gain`.

    The weight is the relative linear size of the contact in a cell. If the contact covers the area `share` in
    one piece, this is the root of the share; if its parts are far apart, it is the sum of their sizes,
    reduced by mutual shielding at smaller distances. For an unknown arrangement the geometric mean is used.
    The displacement beside a line contact varies as the logarithm of the distance: each coarser grid adds a
    constant to the reciprocal of the weight, and contacts add like conductors in parallel.
    1 - weight is written to `empty`. Cells out of contact, with zero weight, are included.

    Parameters
    ----------
    weight : array
        mean weight of the parts of every cell; overwritten by that of the cell.
    share : array
        share of every cell in contact.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    arrangement : Arrangement
        of the contacts in the cells.
    empty : array
        output.
    gain : array
        output.
    """
    xp, parts = share.__array_namespace__(), factors[0] * factors[1]
    gain[...] = 1 / xp.where(weight > 0, weight, xp.ones_like(weight))
    if arrangement == Arrangement.ALONG_A_LINE:
        weight[...] = parts * weight / (1 + (parts - 1) * weight)
    else:
        whole, apart = xp.sqrt(share), weight * parts**0.5
        pieces = apart / (1 + apart - whole)
        weight[...] = pieces if arrangement == Arrangement.SCATTERED else xp.sqrt(whole * pieces)
    gain *= weight
    empty[...] = 1 - weight


def weighted_mean(field: Array, factors: Factors, gain: Array, out: Array) -> None:
    """Write `gain` x the means of `field` over blocks of `factors` cells to `out`.

    Parameters
    ----------
    field : array (ny, nx)
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    gain : array
        by cell.
    out : array
        over the coarse cells; output.
    """
    block_mean(field, factors, out)
    out *= gain


def mix(values: Array, empty: Array, coarse: Array, factors: Factors, out: Array) -> None:
    """Write `values` + `empty` x `coarse`, each coarse cell repeated `factors` times, to `out`.

    Parameters
    ----------
    values : array (ny, nx)
    empty : array
        1 - weight of each cell.
    coarse : array
        over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    out : array
        output.
    """
    out[...] = values + empty * repeat(coarse, factors, values.shape)


def neighbours(field: Array, weights: Weights, out: Array) -> None:
    """Write the weighted means of the eight neighbours, with periodic boundaries, to `out`.

    Parameters
    ----------
    field : array (ny, nx)
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    out : array
        output.
    """
    xp = field.__array_namespace__()
    across_y, across_x, diagonal = weights
    column = xp.roll(field, 1, axis=0) + xp.roll(field, -1, axis=0)
    row = across_x * field + diagonal * column
    out[...] = xp.roll(row, 1, axis=1) + xp.roll(row, -1, axis=1) + across_y * column


def fill(values: Array, empty: Array, mixed: Array, weights: Weights, out: Array) -> None:
    """Write `values` + `empty` x the neighbours' means of `mixed` to `out`.

    Parameters
    ----------
    values : array (ny, nx)
    empty : array
        1 - weight of each cell.
    mixed : array (ny, nx)
        field whose neighbours are averaged.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    out : array
        output.
    """
    neighbours(mixed, weights, out)
    out[...] = values + empty * out


def fill_from(
    values: Array, active: Array, coarse: Array, factors: Factors, weights: Weights, out: Array
) -> None:
    """Write `values` + empty x the neighbours' means of the mixture of `values` and `coarse` to `out`.

    The mixture is `values` + empty x `coarse`, each coarse cell repeated `factors` times, with empty 1 where
    `active` is zero and 0 elsewhere.

    Parameters
    ----------
    values : array (ny, nx)
    active : array (ny, nx)
        nonzero on the active set.
    coarse : array
        over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    out : array
        output.
    """
    empty = _zeros_of(active)
    fill(values, empty, values + empty * repeat(coarse, factors, values.shape), weights, out)


def empty_neighbours(field: Array, empty: Array, weights: Weights, out: Array) -> None:
    """Write the neighbours' means of `empty` x `field` to `out`, the transpose of filling.

    Parameters
    ----------
    field : array (ny, nx)
    empty : array
        1 - weight of each cell.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    out : array
        output.
    """
    neighbours(empty * field, weights, out)


def gather(field: Array, empty: Array, factors: Factors, out: Array) -> None:
    """Write the sums of `empty` x `field` over blocks of cells to `out`, the transpose of mixing.

    Parameters
    ----------
    field : array (ny, nx)
    empty : array
        1 - weight of each cell.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    out : array
        over the coarse cells; output.
    """
    block_mean(empty * field, factors, out)
    out *= factors[0] * factors[1]


def empty_from(
    field: Array, active: Array, weights: Weights, passed: Array, factors: Factors, coarse: Array
) -> None:
    """Write the neighbours' means of empty x `field` to `passed`, and gather them into `coarse`.

    `empty` is defined as in `fill_from`; together with `finish_restriction` this is the transpose of that.

    Parameters
    ----------
    field : array (ny, nx)
    active : array (ny, nx)
        nonzero on the active set.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    passed : array (ny, nx)
        output.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    coarse : array
        over the coarse cells; output.
    """
    empty = _zeros_of(active)
    empty_neighbours(field, empty, weights, passed)
    gather(passed, empty, factors, coarse)


def spread(field: Array, gain: Array, coarse: Array, factors: Factors) -> None:
    """Add `coarse`, distributed over its fine cells, to `field`, and multiply the sum by `gain`.

    Parameters
    ----------
    field : array (ny, nx)
        overwritten.
    gain : array
        by cell.
    coarse : array
        over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    """
    field += repeat(coarse, factors, field.shape) / (factors[0] * factors[1])
    field *= gain


def finish_restriction(field: Array, passed: Array, coarse: Array, factors: Factors, active: Array) -> float:
    """Add `passed` and distributed `coarse` to `field` on the active set; set it to zero elsewhere.

    Parameters
    ----------
    field : array (ny, nx)
        overwritten.
    passed : array (ny, nx)
        load from the neighbours.
    coarse : array
        over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    active : array (ny, nx)
        nonzero on the active set.

    Returns
    -------
    float
        sum of the field, in double precision.
    """
    xp = field.__array_namespace__()
    shared = repeat(coarse, factors, field.shape) / (factors[0] * factors[1])
    field[...] = (field + (passed + shared)) * (1 - _zeros_of(active))
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
    """Prolongate the pressure `coarse` to a grid `factors` times finer, with contact edges and fine detail.

    Towards the edge of a contact the pressure falls as the root of the distance (Johnson 1985, chapter 4), so
    that its square is linear there and can be extrapolated beyond the edge: the square is interpolated
    linearly, and its root distributes the load of every coarse cell over its fine cells. Fine detail is
    added: the height above the mean of the neighbours, times `stiffness`. The excess load of a cell is
    subtracted evenly from its parts, those that reach zero excepted, and load beyond the cap is passed to
    other parts of the cell: each cell keeps its load.

    Parameters
    ----------
    coarse : array
        pressure over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    heights : array
        of the finer grid, dimensionless.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    stiffness : float
        pressure over the height above the neighbours.
    cap : float
        largest pressure allowed.
    out : array
        output.
    """
    xp = coarse.__array_namespace__()
    square = _continued(xp, coarse * coarse)
    (fy, fx), (ny, nx) = factors, coarse.shape
    neighbours(heights, weights, out)
    detail = xp.reshape(stiffness * (heights - out), (ny, fy, nx, fx))
    parts = xp.reshape(out, (ny, fy, nx, fx))
    for ky in range(fy):
        for kx in range(fx):
            at_y, at_x = (ky + 0.5) / fy - 0.5, (kx + 0.5) / fx - 0.5
            along_x = _between(xp, square, at_x, 1)
            parts[:, ky, :, kx] = xp.sqrt(xp.clip(_between(xp, along_x, at_y, 0), 0, None))
    total = xp.sum(parts, axis=(1, 3))
    load = fy * fx * coarse
    parts *= (load / xp.where(total == 0, xp.ones_like(total), total))[:, None, :, None]
    parts += detail
    parts -= _level(xp, parts, load)
    parts *= xp.astype(parts > (NEGLIGIBLE_LOAD * load)[:, None, :, None], parts.dtype)
    total = xp.sum(parts, axis=(1, 3))
    parts *= (load / xp.where(total == 0, xp.ones_like(total), total))[:, None, :, None]
    lost = xp.where(total == 0, coarse, xp.zeros_like(coarse))  # where rounding leaves no load
    parts += lost[:, None, :, None]
    if cap < float("inf"):
        parts = _held(xp, parts, load, cap)
        parts[xp.broadcast_to((coarse >= cap)[:, None, :, None], parts.shape)] = cap
    out[...] = xp.reshape(parts, out.shape)


def _level(xp: Any, parts: Array, load: Array) -> Array:
    """Return the level whose subtraction from the parts of every cell leaves its `load` above zero."""
    level = xp.full_like(load, -float("inf"))[:, None, :, None]
    for _ in range(parts.shape[1] * parts.shape[3]):  # each round excludes the lowest parts
        above = xp.astype(parts > level, parts.dtype)
        count = xp.sum(above, axis=(1, 3))
        some = xp.where(count == 0, xp.ones_like(count), count)
        found = (xp.sum(above * parts, axis=(1, 3)) - load) / some
        level = xp.where((count > 0)[:, None, :, None], found[:, None, :, None], level)
    return level


def _held(xp: Any, parts: Array, load: Array, cap: float) -> Array:
    """Return the parts of every cell limited to the cap; its other parts carry the remaining `load`."""
    count = parts.shape[1] * parts.shape[3]
    for _ in range(count):  # each round more parts may reach the cap
        below = parts < cap
        number = xp.sum(xp.astype(below, load.dtype), axis=(1, 3))
        rest = xp.clip(load - cap * (count - number), 0, None)
        others = xp.sum(xp.where(below, parts, xp.zeros_like(parts)), axis=(1, 3))
        factor = rest / xp.where(others > 0, others, xp.ones_like(others))
        even = xp.where(
            others > 0, xp.zeros_like(rest), rest / xp.where(number > 0, number, xp.ones_like(number))
        )
        shared = parts * factor[:, None, :, None] + even[:, None, :, None]
        parts = xp.where(below, shared, xp.full_like(parts, cap))
        if not xp.any(parts > cap):
            break
    return parts


def _continued(xp: Any, square: Array) -> Array:
    """Return `square`, extrapolated linearly from the contact {> 0} to negative values in the next cells."""
    total, count = xp.zeros_like(square), xp.zeros_like(square)
    for ey in (-1, 0, 1):
        for ex in (-1, 0, 1):
            if (ey, ex) != (0, 0):
                near = xp.roll(square, (ey, ex), axis=(0, 1))
                far = xp.roll(square, (2 * ey, 2 * ex), axis=(0, 1))
                guess = xp.where(far > 0, 2 * near - far, -near)
                total += xp.where(near > 0, guess, xp.zeros_like(near))
                count += xp.astype(near > 0, square.dtype)
    beyond = xp.clip(total / xp.where(count == 0, xp.ones_like(count), count), None, 0)
    return xp.where(square > 0, square, beyond)


def _between(xp: Any, field: Array, offset: float, axis: int) -> Array:
    """Return `field` interpolated linearly at `offset` cells, |offset| < 1, along an axis."""
    share = abs(offset)
    return (1 - share) * field + share * xp.roll(field, -1 if offset > 0 else 1, axis=axis)


def repeat(field: Array, factors: Factors, shape: tuple[int, ...]) -> Array:
    """Return `field` with every cell repeated `factors` times, cropped to `shape`.

    Parameters
    ----------
    field : array (ny, nx)
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    shape : (int, int)
        of the result.

    Returns
    -------
    array
    """
    xp = field.__array_namespace__()
    return xp.repeat(xp.repeat(field, factors[0], axis=0), factors[1], axis=1)[: shape[0], : shape[1]]


def active_set(pressure: Array, gap: Array, cap: float) -> Array:
    """Return the active set: the points whose gap must vanish in the solution, as far as is known.

    They carry a pressure below the cap, overlap without pressure, or have a positive gap at the cap.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    gap : array (ny, nx)
        separation less offset.
    cap : float
        largest pressure allowed.

    Returns
    -------
    array of bool
    """
    none, full = pressure <= 0, pressure >= cap
    return (none & (gap < 0)) | (full & (gap > 0)) | ~(none | full)


def _zeros_of(field: Array) -> Array:
    """Return 1 where `field` is zero and 0 elsewhere."""
    xp = field.__array_namespace__()
    return xp.astype(field == 0, field.dtype)


def _sum(xp: Any, field: Array) -> float:
    return float(xp.sum(field, dtype=xp.float64))


def small_grids(grids: Sequence[Any], stores: Sequence[Array], ends: Sequence[int]) -> None:
    """Return None: these kernels process every grid of a hierarchy separately.

    Parameters
    ----------
    grids : sequence of CoarseGrid
        the hierarchy.
    stores : list of array
        memory of its fields.
    ends : list of int
        end of each grid in that memory.

    Returns
    -------
    None
        other implementations return a `SmallGrids`.
    """
