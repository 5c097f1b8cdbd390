"""Row jitter: random shifts between the rows of a scanned map.

They have a white spectrum across the rows: waves of two rows are as strong as waves of eight. Even an
undersampled lay along the rows has weaker short waves than long ones.
"""

from typing import Literal, NamedTuple

import numpy as np

from roughcontact.surface.levelling.robust import robust_scale

Evidence = Literal["none", "doubtful", "clear"]

_BLOCKS = 8  # pieces of a row whose means are compared
_MIN_ROWS, _MIN_BLOCK_POINTS = 32, 4  # rows of a map, points of a piece
_CLIP = 4.0  # standard deviations; limits the weight of edges and particles
_MIN_SIGNIFICANCE = 4.0  # standard deviations by which the coherence must differ from zero
_MIN_COHERENCE = 0.1
# Power of the waves of two to four rows over that of four to eight, and the common power of distant pieces
# over that of neighbours: 1 for shifts, 0.4 for straight profiles of H = 0.1. (Any, scanning instrument)
_CLEAR_FLATNESS, _CLEAR_UNIFORMITY = (0.55, 0.4), (0.6, 0.4)
_LAY_FLATNESS = 0.3  # flatness below which the common part is a lay, unless the instrument scans
_MIN_RELATIVE_RMS = 2e-3  # of the rms height; smaller shifts are negligible


class RowJitter(NamedTuple):
    """Random shifts of the rows of a map, 0 without evidence."""

    rms: float  # root mean square of the shifts, m
    evidence: Evidence  # `doubtful`: the common part of the rows could also be a lay or a drift
    offsets: np.ndarray  # (ny,), m


def find_row_jitter(values: np.ndarray, *, is_scan: bool = False) -> RowJitter:
    """Find random shifts of the rows of a map (ny, nx; m; NaN missing), independent from row to row.

    The variance of the shifts is the mean over the waves of two to four rows of the cross-spectrum of pieces
    half a row or more apart. The evidence is clear if waves of four to eight rows are no stronger and
    neighbouring pieces have no more in common than distant ones, doubtful if these are somewhat stronger or,
    much stronger, the map was `is_scan` along x, which may drift. The shifts are estimated wave by wave with
    a Wiener filter (Wiener 1949, Extrapolation, Interpolation, and Smoothing of Stationary Time Series),
    which keeps the long waves of the surface.
    """
    ny, nx = values.shape
    no_jitter = RowJitter(0.0, "none", np.zeros(ny))
    if ny < _MIN_ROWS or nx < _BLOCKS * _MIN_BLOCK_POINTS:
        return no_jitter
    second_differences = values[:-2] - 2 * values[1:-1] + values[2:]
    finite = second_differences[~np.isnan(second_differences)]
    if not finite.size or not np.ptp(finite) > 0:
        return no_jitter
    middle = float(np.median(finite))
    limit = _CLIP * (robust_scale(finite - middle, overwrite=True) or float(finite.std()))
    del finite  # memory may not hold more than is needed of a large map
    np.clip(second_differences, middle - limit, middle + limit, out=second_differences)
    blocks = np.array_split(second_differences, _BLOCKS, axis=1)
    block_means = np.stack([_row_means(block) for block in blocks], axis=1)
    variance, evidence = _shared_variance(block_means, is_scan=is_scan)
    rms = float(np.sqrt(variance))
    if evidence == "none" or rms <= _MIN_RELATIVE_RMS * float(values[~np.isnan(values)].std()):
        return no_jitter
    row_means = _row_means(second_differences)
    # steps at both ends, less the tilt of the row heights obtained by summing the second differences
    first_step, last = (_end_step(step, limit) for step in (values[1] - values[0], values[-2] - values[-1]))
    profile = np.cumsum(np.concatenate([[0.0], first_step + np.cumsum(np.concatenate([[0.0], row_means]))]))
    number = np.arange(ny) - (ny - 1) / 2
    tilt = float(number @ profile / (number @ number))
    row_means = np.concatenate([[first_step - tilt], row_means, [last + tilt]])
    return RowJitter(rms, evidence, _estimate(row_means, variance))


def _end_step(step: np.ndarray, limit: float) -> float:
    """Return the mean step between two rows over their common points; 0 without common points."""
    finite = step[~np.isnan(step)]
    if not finite.size:
        return 0.0
    middle = float(np.median(finite))
    return float(np.clip(finite, middle - limit, middle + limit).mean())


def _row_means(differences: np.ndarray) -> np.ndarray:
    """Return the mean of each row over its measured points; 0 without measured points."""
    is_measured = ~np.isnan(differences)
    return np.where(is_measured, differences, 0.0).sum(axis=1) / np.maximum(is_measured.sum(axis=1), 1)


def _shared_variance(block_means: np.ndarray, *, is_scan: bool) -> tuple[float, Evidence]:
    """Return the variance of the shifts common to the pieces (rows, blocks), and its evidence."""
    rows, blocks = block_means.shape
    # a taper: long waves would leak into the short ones, where the shifts show
    taper = np.sin(np.pi * (np.arange(rows) + 0.5) / rows) ** 2
    taper /= np.sqrt(np.sum(taper**2))
    waves = np.fft.rfft(block_means * taper[:, None], axis=0)
    frequency = np.fft.rfftfreq(rows)
    short, longer = frequency >= 0.25, (frequency >= 0.125) & (frequency < 0.25)
    # of the shifts themselves, not of their second differences
    transfer = (2 - 2 * np.cos(2 * np.pi * frequency)) ** 2

    def power(distances: range) -> np.ndarray:
        pairs = [(k, k + d) for d in distances for k in range(blocks - d)]
        # what two pieces of a row share is no roughness, whose waves there are independent
        products = [waves[:, k] * waves[:, partner].conj() for k, partner in pairs]
        return np.asarray(np.mean(products, axis=0).real)

    distant = range(blocks // 2, blocks)
    distant_power, adjacent_power, block_power = (power(d) for d in (distant, range(1, 2), range(1)))
    # two thirds of the tapered waves are independent, times the number of pairs of distant pieces
    independent = np.count_nonzero(short) / 1.5 * sum(blocks - d for d in distant)
    coherence = np.mean(distant_power[short] / np.maximum(block_power[short], np.finfo(float).tiny))
    # of the shifts themselves, not of their second differences
    variance = float(np.mean(distant_power[short] / transfer[short]))
    if variance <= 0 or coherence <= max(_MIN_COHERENCE, _MIN_SIGNIFICANCE / np.sqrt(independent)):
        return 0.0, "none"
    # at most 2: a common part that is flatter than white says no more
    flatness = variance / max(float(np.mean(distant_power[longer] / transfer[longer])), variance / 2)
    uniformity = variance / max(float(np.mean(adjacent_power[short] / transfer[short])), variance / 2)
    if flatness >= _CLEAR_FLATNESS[is_scan] and uniformity >= _CLEAR_UNIFORMITY[is_scan]:
        return variance, "clear"
    if is_scan or flatness >= _LAY_FLATNESS:
        return variance, "doubtful"
    return 0.0, "none"


def _estimate(second_differences: np.ndarray, variance: float) -> np.ndarray:
    """Return the shifts from the second differences of all rows.

    The first and the last are the steps to the neighbouring row, as for a map reflected at its ends.
    """
    from scipy.fft import dct, idct

    rows = second_differences.size
    waves = dct(second_differences, norm="ortho")
    waves[0] = 0.0  # the mean is no shift
    transfer = 2 - 2 * np.cos(np.pi * np.arange(rows) / rows)  # of second differences, for a cosine series
    waves[1:] /= -transfer[1:]
    power, scatter = _smooth_power(waves[1:] ** 2)
    # a wave is attributed to shifts unless its power is significantly larger
    waves[1:] *= variance / (variance + np.maximum(power - variance * (1 + 2 * scatter), 0.0))
    return idct(waves, norm="ortho")


def _smooth_power(power: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean power around each wave, and its relative standard deviation for independent waves.

    Waves of number k have the weight k^2, a compromise between a white spectrum and one that falls as k^-4,
    so that the long waves of a surface do not leak into the short ones.
    """
    number = np.arange(1, power.size + 1)
    # from the frequency over 1.3 to 1.3 times it, seven waves at least
    low = np.maximum(np.minimum(np.floor(number / 1.3), number - 3).astype(int), 1) - 1
    high = np.minimum(np.maximum(np.ceil(number * 1.3), number + 3).astype(int), power.size)

    def within(values: np.ndarray) -> np.ndarray:
        sums = np.concatenate([[0.0], np.cumsum(values)])
        return sums[high] - sums[low]

    weight = number.astype(float) ** 2
    return within(weight * power) / within(weight), np.sqrt(2 * within(weight**2)) / within(weight)
