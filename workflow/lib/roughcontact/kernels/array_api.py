"""The passes over the grid that the iteration is made of, for any array library.

They ask their arrays for the library they belong to (the Python array API: NumPy, CuPy and others) and write
into arrays that are there already: an implementation of `roughcontact.kernels.protocol.Kernels`, and the
definition of what each kernel computes.
"""

from collections.abc import Sequence
from typing import Any

from roughcontact.kernels.arrays import Array
from roughcontact.kernels.protocol import Arrangement, Factors, Weights

CLOSED = 1e-30  # stands for a gap of zero at a point of the active set
SPECK = 1e-5  # share of the load of a refined cell that is none: it would be rounding alone
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
        is multiplied in place.
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
        is divided in place.
    symbol : array (ny, nx//2 + 1)
        of an operator.
    weights : array (nx//2 + 1,)
        how often the waves of a column count.

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
    """Return the sum of |s|^2 (y + x) over the waves, in double precision.

    y is the entry of `along_y` for the row; the entries for the column, x of `along_x` and how often the wave
    counts of `weights`, come in float64 too.

    Parameters
    ----------
    spectrum : array (ny, nx//2 + 1), complex
    weights : array (nx//2 + 1,)
        how often the waves of a column count.
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
    """Return the least and the largest value, and how many are infinite or no number.

    Where there are any of those, the other two tell nothing.

    Parameters
    ----------
    field : array (ny, nx)

    Returns
    -------
    least, largest : float
    missing : int
        how many are infinite or no number.
    """
    xp = field.__array_namespace__()
    finite = xp.isfinite(field)
    missing = field.size - int(xp.count_nonzero(finite))
    return float(xp.min(field)), float(xp.max(field)), missing


def make_dimensionless(heights: Array, reference: float, unit: float, out: Array) -> None:
    """Put (`heights` - `reference`) / `unit` into `out`.

    Parameters
    ----------
    heights : array (ny, nx)
        in their own unit.
    reference : float
        height that counts as zero.
    unit : float
        height that counts as one.
    out : array
        is written.
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
    """Take the heights off the displacement that `separation` holds; return what that pass can tell.

    A height counts as (height - `reference`) / `unit`. The separation itself is in `separation` afterwards.
    Six sums, in double precision: pressure x displacement; displacement squared; separation over the free
    contact {0 < p < cap}, and the number of its points; change of pressure x separation `before`, and after,
    both less `offset`, which drops out but for rounding. The change is that from the pressure `start`.

    Parameters
    ----------
    separation : array (ny, nx)
        holds the displacement; becomes the separation.
    heights : array (ny, nx)
        in their own unit.
    reference : float
        height that counts as zero.
    unit : float
        height that counts as one.
    start : array (ny, nx)
        pressure before the last step.
    before : array (ny, nx)
        separation before the last step.
    offset : float
        separation that counts as closed.
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
    """Put the gap over the active set into `values`, zero elsewhere; return the number of its points.

    The active set is where the gap should vanish: `active_set`. A gap that does vanish there stands as
    `CLOSED`, so that the values are zero at inactive points alone.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    separation : array (ny, nx)
        displacement less height.
    offset : float
        separation that counts as closed.
    cap : float
        largest pressure allowed.
    values : array (ny, nx)
        is written.

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
    """Make `values` zero where a point is foreseen to lose its contact; return how many are left.

    What is foreseen is the pressure p - `stiffness` (residual - mean of its eight neighbours), as in a
    primal-dual active-set method [1]_, with a stiffness for what one point has more than those around it.
    Points at the cap stay.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    residual : array (ny, nx)
        interpolated to all points.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    stiffness : float
        pressure over the gap by which a point stands out.
    cap : float
        largest pressure allowed.
    values : array (ny, nx)
        zero at inactive points; is written.

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
    """Put p - length (correction - mean), projected onto [0, `cap`], into `out`.

    Of the inactive points, those at the cap keep their pressure, in the precision of `out`; the others have
    none afterwards. What all that took away comes into `correction`. `values` become 1 between the bounds, 0
    elsewhere.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    correction : array (ny, nx)
        of the pressure; written over.
    mean : float
        of the correction over the active set.
    length : float
        of the step.
    cap : float
        largest pressure allowed.
    out : array
        is written.
    values : array (ny, nx)
        zero at inactive points; is written.
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
    """Add `passed` and `coarse`, shared out, to `field` where `free` is not zero.

    Parameters
    ----------
    field : array (ny, nx)
        gets the load.
    passed : array (ny, nx)
        what neighbours pass back.
    coarse : array
        over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    free : array (ny, nx)
        where it is zero the field gets load.
    cap : float
        largest pressure allowed.

    Returns
    -------
    outside, total : float
        how much of the field lies outside of 0 and `cap`, and the sum of it projected between them, in double
        precision.
    """
    xp = field.__array_namespace__()
    shared = repeat(coarse, factors, field.shape) / (factors[0] * factors[1])
    field += xp.astype((passed + shared) * (1 - _zeros_of(free)), field.dtype)
    projected = xp.clip(field, 0, None if cap == float("inf") else cap)
    return _sum(xp, xp.abs(field - projected)), _sum(xp, projected)


def project(field: Array, cap: float, taken: Array, free: Array) -> None:
    """Project `field` onto [0, `cap`]; what that takes away comes into `taken`.

    `free` becomes 1 between the bounds and 0 elsewhere.

    Parameters
    ----------
    field : array (ny, nx)
        is written over.
    cap : float
        largest pressure allowed.
    taken : array (ny, nx)
        is written.
    free : array (ny, nx)
        is written.
    """
    xp = field.__array_namespace__()
    projected = xp.clip(field, 0, None if cap == float("inf") else cap)
    taken[...] = xp.astype(field - projected, taken.dtype)
    free[...] = xp.astype((projected > 0) & (projected < cap), free.dtype)
    field[...] = projected


def rescale(field: Array, factor: float, cap: float) -> None:
    """Project `field` onto [0, `cap`] and multiply it by a number.

    Parameters
    ----------
    field : array (ny, nx)
        is written over.
    factor : float
    cap : float
        largest pressure allowed.
    """
    xp = field.__array_namespace__()
    field[...] = xp.clip(field, 0, None if cap == float("inf") else cap) * factor


def project_residual(pressure: Array, separation: Array, offset: float, cap: float, values: Array) -> float:
    """Project `values` onto what a certificate allows: at most the gap where p = 0, at least it at the cap.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    separation : array (ny, nx)
        displacement less height.
    offset : float
        separation that counts as closed.
    cap : float
        largest pressure allowed.
    values : array (ny, nx)
        is written over.

    Returns
    -------
    float
        sum of the squares of what that changes.
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
    """Take `offset` off the gap, multiply it and the pressure by their units, and mark the contact.

    Parameters
    ----------
    pressure : array (ny, nx)
        is multiplied in place.
    gap : array (ny, nx)
        is multiplied in place.
    offset : float
        separation that counts as closed.
    pressure_unit : float
        pressure that counts as one.
    gap_unit : float
        gap that counts as one.
    contact : array (ny, nx)
        is written: 1 where the pressure is positive.

    Returns
    -------
    least_gap, load : float
        least gap and sum of the pressure, in their units and in double precision.
    """
    xp = pressure.__array_namespace__()
    gap -= offset
    gap *= gap_unit
    pressure *= pressure_unit
    contact[...] = xp.astype(pressure > 0, contact.dtype)
    return float(xp.min(gap)), _sum(xp, pressure)


def block_mean(field: Array, factors: Factors, out: Array) -> None:
    """Put the means of `field` over blocks of `factors` cells into `out`.

    The last block of a row or a column may lack cells: they count as zero.

    Parameters
    ----------
    field : array (ny, nx)
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    out : array
        over the coarse cells; is written.
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
    """Put the share of points where `active` is not zero, over blocks of `factors` cells, into `out`.

    Parameters
    ----------
    active : array (ny, nx)
        not zero on the active set.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    out : array
        over the coarse cells; is written.
    """
    xp = active.__array_namespace__()
    block_mean(xp.astype(active != 0, out.dtype), factors, out)


def weigh(
    weight: Array, share: Array, factors: Factors, arrangement: Arrangement, empty: Array, gain: Array
) -> None:
    """Make the weight of every cell of the mean weight of its parts; put the ratio of the two into `gain`.

    The linear size of a contact that covers the `share` of a cell is the root of that, if it is in one piece,
    and the sum of the sizes of its parts, if they are far apart; the nearer they are, the more they shield
    each other. Where it is not known how contacts lie, something between is taken. The displacement beside a
    line contact goes with the logarithm of the distance: each coarser grid adds a constant to the reciprocal
    of its weight, and contacts add up as conductors in parallel do.
    What the weight leaves of 1 goes into `empty`. All hold for cells out of contact, whose weight is zero.

    Parameters
    ----------
    weight : array
        mean weight of the parts of every cell; becomes that of the cell.
    share : array
        of every cell that is in contact.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    arrangement : Arrangement
        of the contacts in the cells.
    empty : array
        is written.
    gain : array
        is written.
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
    """Put `gain` x the means of `field` over blocks of `factors` cells into `out`.

    Parameters
    ----------
    field : array (ny, nx)
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    gain : array
        by cell.
    out : array
        over the coarse cells; is written.
    """
    block_mean(field, factors, out)
    out *= gain


def mix(values: Array, empty: Array, coarse: Array, factors: Factors, out: Array) -> None:
    """Put `values` + `empty` x `coarse`, each coarse cell repeated `factors` times, into `out`.

    Parameters
    ----------
    values : array (ny, nx)
    empty : array
        share of a cell that counts as gap.
    coarse : array
        over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    out : array
        is written.
    """
    out[...] = values + empty * repeat(coarse, factors, values.shape)


def neighbours(field: Array, weights: Weights, out: Array) -> None:
    """Put the weighted means of the eight neighbours, over the periodic boundary, into `out`.

    Parameters
    ----------
    field : array (ny, nx)
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    out : array
        is written.
    """
    xp = field.__array_namespace__()
    across_y, across_x, diagonal = weights
    column = xp.roll(field, 1, axis=0) + xp.roll(field, -1, axis=0)
    row = across_x * field + diagonal * column
    out[...] = xp.roll(row, 1, axis=1) + xp.roll(row, -1, axis=1) + across_y * column


def fill(values: Array, empty: Array, mixed: Array, weights: Weights, out: Array) -> None:
    """Put `values` + `empty` x the neighbours' means of `mixed` into `out`.

    Parameters
    ----------
    values : array (ny, nx)
    empty : array
        share of a cell that counts as gap.
    mixed : array (ny, nx)
        field whose neighbours are taken.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    out : array
        is written.
    """
    neighbours(mixed, weights, out)
    out[...] = values + empty * out


def fill_from(
    values: Array, active: Array, coarse: Array, factors: Factors, weights: Weights, out: Array
) -> None:
    """Put `values` + empty x the neighbours' means of the mixture of `values` and `coarse` into `out`.

    The mixture is `values` + empty x `coarse`, each coarse cell repeated `factors` times, with empty 1 where
    `active` is zero and 0 elsewhere.

    Parameters
    ----------
    values : array (ny, nx)
    active : array (ny, nx)
        not zero on the active set.
    coarse : array
        over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    out : array
        is written.
    """
    empty = _zeros_of(active)
    fill(values, empty, values + empty * repeat(coarse, factors, values.shape), weights, out)


def empty_neighbours(field: Array, empty: Array, weights: Weights, out: Array) -> None:
    """Put the neighbours' means of `empty` x `field` into `out`, the transpose of filling.

    Parameters
    ----------
    field : array (ny, nx)
    empty : array
        share of a cell that counts as gap.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    out : array
        is written.
    """
    neighbours(empty * field, weights, out)


def gather(field: Array, empty: Array, factors: Factors, out: Array) -> None:
    """Put the sums of `empty` x `field` over blocks of cells into `out`, the transpose of mixing.

    Parameters
    ----------
    field : array (ny, nx)
    empty : array
        share of a cell that counts as gap.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    out : array
        over the coarse cells; is written.
    """
    block_mean(empty * field, factors, out)
    out *= factors[0] * factors[1]


def empty_from(
    field: Array, active: Array, weights: Weights, passed: Array, factors: Factors, coarse: Array
) -> None:
    """Put the neighbours' means of empty x `field` into `passed`, and gather that into `coarse`.

    Empty as in `fill_from`, of which this is, with `finish_restriction`, the transpose.

    Parameters
    ----------
    field : array (ny, nx)
    active : array (ny, nx)
        not zero on the active set.
    weights : (float, float, float)
        of a neighbour across y, across x, and diagonal.
    passed : array (ny, nx)
        is written.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    coarse : array
        over the coarse cells; is written.
    """
    empty = _zeros_of(active)
    empty_neighbours(field, empty, weights, passed)
    gather(passed, empty, factors, coarse)


def spread(field: Array, gain: Array, coarse: Array, factors: Factors) -> None:
    """Add `coarse`, each cell shared out among its fine ones, to `field`, and multiply that by `gain`.

    Parameters
    ----------
    field : array (ny, nx)
        is written over.
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
    """Add `passed` and `coarse`, shared out, to `field` where `active` is not zero; elsewhere make it zero.

    Parameters
    ----------
    field : array (ny, nx)
        is written over.
    passed : array (ny, nx)
        what neighbours pass back.
    coarse : array
        over the coarse cells.
    factors : (int, int)
        fy and fx, from the fine grid to the coarse one.
    active : array (ny, nx)
        not zero on the active set.

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
    """Put the pressure `coarse` onto a grid `factors` times finer, into `out`, with edges and detail.

    Towards the edge of a contact the pressure falls as the root of the distance (Johnson 1985, chapter 4), so
    that its square is linear there and can be continued beyond: it is interpolated linearly, and its root
    shares out the load of every coarse cell among its fine ones. To that comes what the finer grid adds: a
    height that stands out from the mean of its neighbours takes `stiffness` times as much pressure. What all
    parts of a cell have too much is taken off evenly, but for those that come to zero, and what they have
    beyond the cap is handed to its other parts: each cell keeps its load.

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
        pressure over the height that stands out.
    cap : float
        largest pressure allowed.
    out : array
        is written.
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
    parts *= xp.astype(parts > (SPECK * load)[:, None, :, None], parts.dtype)
    total = xp.sum(parts, axis=(1, 3))
    parts *= (load / xp.where(total == 0, xp.ones_like(total), total))[:, None, :, None]
    lost = xp.where(total == 0, coarse, xp.zeros_like(coarse))  # where rounding leaves nothing
    parts += lost[:, None, :, None]
    if cap < float("inf"):
        parts = _held(xp, parts, load, cap)
        parts[xp.broadcast_to((coarse >= cap)[:, None, :, None], parts.shape)] = cap
    out[...] = xp.reshape(parts, out.shape)


def _level(xp: Any, parts: Array, load: Array) -> Array:
    """Return the number to take off the parts of every cell so that what is left above zero is its `load`."""
    level = xp.full_like(load, -float("inf"))[:, None, :, None]
    for _ in range(parts.shape[1] * parts.shape[3]):  # each time the lowest parts fall out, if any
        above = xp.astype(parts > level, parts.dtype)
        count = xp.sum(above, axis=(1, 3))
        some = xp.where(count == 0, xp.ones_like(count), count)
        found = (xp.sum(above * parts, axis=(1, 3)) - load) / some
        level = xp.where((count > 0)[:, None, :, None], found[:, None, :, None], level)
    return level


def _held(xp: Any, parts: Array, load: Array, cap: float) -> Array:
    """Return the parts of every cell held at the cap; its others carry what is missing in its `load`."""
    count = parts.shape[1] * parts.shape[3]
    for _ in range(count):  # each time more of them may reach the cap
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
    """Return `square`, continued linearly from the contact {> 0} into the cells beside it, below zero."""
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
    """Return `field` with every cell repeated `factors` times, as far as a field of `shape` goes.

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
    """Return the active set: the points where the gap should vanish and may not yet.

    They carry a pressure below the cap, overlap without pressure, or gape at the cap.

    Parameters
    ----------
    pressure : array (ny, nx)
        dimensionless.
    gap : array (ny, nx)
        is multiplied in place.
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
    """Return None: every grid of a hierarchy is passed over by itself.

    Parameters
    ----------
    grids : sequence of CoarseGrid
        the hierarchy.
    stores : list of array
        memory of its fields.
    ends : list of int
        where each grid ends in it.

    Returns
    -------
    None
        where nothing passes over several grids in one call; else a `SmallGrids`.
    """
