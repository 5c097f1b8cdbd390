"""Row jitter: rows of a scanned map that are shifted against one another at random.

What rows share over their whole length is a shift of the rows, or a lay along them. A shift jumps from row to
row, so that its waves across the rows are as strong down to two rows as they are up to eight; a lay that is
sampled well is smooth across the rows, and one that is not still has weaker short waves than long ones.
"""

from typing import Literal, NamedTuple

import numpy as np

from roughcontact.levelling.robust import robust_scale

Evidence = Literal["none", "doubtful", "clear"]

_BLOCKS = 8  # pieces of a row whose mean steps are compared
_LEAST_ROWS, _LEAST_BLOCK = 32, 4  # rows of a map, points of a piece; with fewer nothing is said
_CLIP = 4.0  # standard deviations; edges and particles have no more weight than that
_SURE = 4.0  # standard deviations that the shared part must be off zero, and its least share
_LEAST_SHARE = 0.1
# Power of the waves of two to four rows over that of four to eight, and the shared power of pieces far apart
# over that of neighbours: 1 for shifts, 0.4 for straight profiles of H = 0.1. (Any, scanning instrument)
_FLAT, _ALONG = (0.55, 0.4), (0.6, 0.4)
_LAY = 0.3  # flatness below which what rows share is taken for a lay, unless the instrument scans
_SMALLEST = 2e-3  # of the rms height; less is no matter


class RowJitter(NamedTuple):
    """Shifts of the rows of a map.

    Attributes
    ----------
    rms : float, m
        root mean square of the shifts; 0 where there is no evidence of any.
    evidence : {"none", "doubtful", "clear"}
        doubtful: what the rows share could be a lay or a drift as well.
    offsets : array (ny,), m
        estimate of the shifts; 0 without evidence.
    residual_offsets : array (ny,), m
        shifts as large as the error of the estimate, at random: one example of what it may be off.
    """

    rms: float
    evidence: Evidence
    offsets: np.ndarray
    residual_offsets: np.ndarray


def find_row_jitter(values: np.ndarray, *, scanned: bool = False) -> RowJitter:
    """Find shifts of the rows of a map against one another, independent from row to row.

    Rows are cut into eight pieces. The second difference across the rows, averaged over a piece, holds the
    shifts and what is left there of the surface. The cross-spectrum of pieces half a row or more apart holds
    what they share: the variance of the shifts is its mean over the waves of two to four rows. There is
    evidence where their coherence, wave by wave, stands four standard deviations off zero, as independent
    pieces would have it, and is a tenth or more. It is clear where the waves of four to eight rows are no
    stronger, and neighbouring pieces share no more than distant ones. Where they are a little stronger it is
    doubtful, and where they are much stronger a lay, or doubtful for a scanning instrument, which may drift.

    The shifts are estimated wave by wave, as Wiener's filter [1]_ does: the mean row's own waves, times the
    variance of the shifts over the power of the wave. Long waves, in which the surface is stronger, stay.

    Parameters
    ----------
    values : array (ny, nx), m
        NaN where missing; without tilt or with.
    scanned : bool
        measured line by line along x, as by a probe or a stylus.

    Returns
    -------
    RowJitter

    References
    ----------
    .. [1] Wiener, N. (1949), Extrapolation, Interpolation, and Smoothing of Stationary Time Series.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> heights = rough_reference_surface(96).values
    >>> shifts = 0.002 * np.random.default_rng(0).standard_normal(96)
    >>> for rows in (heights, heights + shifts[:, None], shifts[:, None] + np.zeros(96)):
    ...     found = find_row_jitter(rows)
    ...     print(found.evidence, f"{found.rms:.4f}")
    none 0.0000
    clear 0.0017
    clear 0.0017
    """
    ny, nx = values.shape
    nothing = RowJitter(0.0, "none", np.zeros(ny), np.zeros(ny))
    if ny < _LEAST_ROWS or nx < _BLOCKS * _LEAST_BLOCK:
        return nothing
    bends = values[:-2] - 2 * values[1:-1] + values[2:]
    measured = bends[~np.isnan(bends)]
    if not measured.size or not np.ptp(measured) > 0:
        return nothing
    middle = float(np.median(measured))
    limit = _CLIP * (robust_scale(measured - middle, overwrite=True) or float(measured.std()))
    del measured  # of a large map there is no room for what is needed no more
    np.clip(bends, middle - limit, middle + limit, out=bends)
    pieces = np.stack([_row_means(part) for part in np.array_split(bends, _BLOCKS, axis=1)], axis=1)
    variance, evidence = _shared(pieces, scanned=scanned)
    rms = float(np.sqrt(variance))
    if evidence == "none" or rms <= _SMALLEST * float(values[~np.isnan(values)].std()):
        return nothing
    means = _row_means(bends)
    # the steps at both ends, less the tilt of the map: the row heights that the bends add up to have none
    first, last = (_end_step(step, limit) for step in (values[1] - values[0], values[-2] - values[-1]))
    profile = np.cumsum(np.concatenate([[0.0], first + np.cumsum(np.concatenate([[0.0], means]))]))
    number = np.arange(ny) - (ny - 1) / 2
    tilt = float(number @ profile / (number @ number))
    means = np.concatenate([[first - tilt], means, [last + tilt]])
    return RowJitter(rms, evidence, *_estimate(means, variance))


def _end_step(step: np.ndarray, limit: float) -> float:
    """Return the mean step between two rows over the points that are on both; 0 where none is."""
    known = step[~np.isnan(step)]
    if not known.size:
        return 0.0
    middle = float(np.median(known))
    return float(np.clip(known, middle - limit, middle + limit).mean())


def _row_means(part: np.ndarray) -> np.ndarray:
    """Return the mean of each row over the points that are there; 0 where none is."""
    known = ~np.isnan(part)
    return np.where(known, part, 0.0).sum(axis=1) / np.maximum(known.sum(axis=1), 1)


def _shared(pieces: np.ndarray, *, scanned: bool) -> tuple[float, Evidence]:
    """Return the variance of the shifts that the pieces (rows, blocks) share, and what speaks for it."""
    rows, blocks = pieces.shape
    taper = np.sin(np.pi * (np.arange(rows) + 0.5) / rows) ** 2
    taper /= np.sqrt(np.sum(taper**2))
    waves = np.fft.rfft(pieces * taper[:, None], axis=0)
    frequency = np.fft.rfftfreq(rows)
    short, longer = frequency >= 0.25, (frequency >= 0.125) & (frequency < 0.25)
    # of the shifts themselves, not of their second differences
    transfer = (2 - 2 * np.cos(2 * np.pi * frequency)) ** 2

    def power(distances: range) -> np.ndarray:
        pairs = [(k, k + d) for d in distances for k in range(blocks - d)]
        products = [waves[:, k] * waves[:, other].conj() for k, other in pairs]
        return np.asarray(np.mean(products, axis=0).real)

    far, near, own = power(range(blocks // 2, blocks)), power(range(1, 2)), power(range(1))
    # a taper leaves two thirds of the waves independent, and far pieces make so many pairs
    independent = np.count_nonzero(short) / 1.5 * sum(blocks - d for d in range(blocks // 2, blocks))
    coherence = np.mean(far[short] / np.maximum(own[short], np.finfo(float).tiny))
    # of the shifts themselves, not of their second differences
    variance = float(np.mean(far[short] / transfer[short]))
    if variance <= 0 or coherence <= max(_LEAST_SHARE, _SURE / np.sqrt(independent)):
        return 0.0, "none"
    flatness = variance / max(float(np.mean(far[longer] / transfer[longer])), variance / 2)
    along = variance / max(float(np.mean(near[short] / transfer[short])), variance / 2)
    if flatness >= _FLAT[scanned] and along >= _ALONG[scanned]:
        return variance, "clear"
    if scanned or flatness >= _LAY:
        return variance, "doubtful"
    return 0.0, "none"


def _estimate(bends: np.ndarray, variance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the shifts, and an example of their error; `bends` are the second differences of all rows.

    The first and the last are the step to the row beside, as of a map reflected at its ends.
    """
    from scipy.fft import dct, idct

    rows = bends.size
    waves = dct(bends, norm="ortho")
    waves[0] = 0.0
    transfer = 2 - 2 * np.cos(np.pi * np.arange(rows) / rows)
    waves[1:] /= -transfer[1:]
    power, scatter = _smooth_power(waves[1:] ** 2)
    # a wave is held to be shifts alone until its power says otherwise; not so in what is left open
    gain, sure = (
        variance / (variance + np.maximum(power - variance * (1 + margin), 0.0))
        for margin in (2 * scatter, 0.0)
    )
    waves[1:] *= gain
    left = np.zeros(rows)
    left[1:] = np.sqrt(variance * (1 - sure)) * np.random.default_rng(0).standard_normal(rows - 1)
    return idct(waves, norm="ortho"), idct(left, norm="ortho")


def _smooth_power(power: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean power around each wave, and its relative standard deviation for independent waves.

    Waves of number k have the weight k^2, half-way between what is flat and what falls with k^-4, so that the
    long ones of a surface do not spill into the short ones.
    """
    number = np.arange(1, power.size + 1)
    low = np.maximum(np.minimum(np.floor(number / 1.3), number - 3).astype(int), 1) - 1
    high = np.minimum(np.maximum(np.ceil(number * 1.3), number + 3).astype(int), power.size)

    def within(values: np.ndarray) -> np.ndarray:
        sums = np.concatenate([[0.0], np.cumsum(values)])
        return sums[high] - sums[low]

    weight = number.astype(float) ** 2
    return within(weight * power) / within(weight), np.sqrt(2 * within(weight**2)) / within(weight)
