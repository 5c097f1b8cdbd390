"""Numbers of a file that are unlike all others in it: a sign of damage where a format has no checksum."""

import numpy as np

_LOW_BITS = np.uint64(2**29 - 1)  # of a double, which single precision does not have
_FEW = 100  # points of a map below which they are not compared
_SHARE = 1e-3  # of the points that may be unlike the others; more of them are no accident
_AT_LEAST = 4  # points that may be so in a small map
_SAMPLE = 2**18  # points from which the levels are found
_OFF = 1e-10  # of a step between levels, beyond rounding
_BEYOND = 20.0  # times the usual deviation from the levels


def odd_numbers(values: np.ndarray) -> list[str]:
    """Return a warning where few numbers lack a property that all others in the file have.

    Parameters
    ----------
    values : array (ny, nx)
        As the file has them, before any scale; NaN where not measured.

    Returns
    -------
    list of str

    Examples
    --------
    >>> values = np.arange(900.0).reshape(30, 30) % 97
    >>> odd_numbers(values)
    []
    >>> values[3, 4] += 0.25
    >>> odd_numbers(values)
    ['1 of 900 numbers lies between the levels, 1 apart, of all others: damaged in the file, or filled in']
    """
    measured = values[np.isfinite(values)]
    if measured.size < _FEW:
        return []
    most = max(_AT_LEAST, int(_SHARE * measured.size))
    finer = np.count_nonzero(measured.view(np.uint64) & _LOW_BITS)
    if 0 < finer <= most:
        have = "has" if finer == 1 else "have"
        sentence = (
            f"{finer} of {measured.size} numbers {have} more digits than single precision, unlike all "
            "others: damaged in the file, or filled in"
        )
        return [sentence]
    between, step = _between_levels(measured, most)
    least, off_plane = "", ""
    rows = max(2, _SAMPLE // values.shape[1])
    if not step and _between_levels(_mixed(values[:rows]), 4 * most)[1]:
        # each number within a map is in four differences, in a profile in three
        between, step = _between_levels(_mixed(values), 4 * most)
        between, least, off_plane = -(-between // 4), "at least ", " but for a plane"
    if not between:
        return []
    lie = "lies" if between == 1 else "lie"
    sentence = (
        f"{least}{between} of {measured.size} numbers {lie} between the levels, {step:.4g} apart{off_plane}, "
        "of all others: damaged in the file, or filled in"
    )
    return [sentence]


def _mixed(values: np.ndarray) -> np.ndarray:
    """Return differences along rows and columns, which a plane, or lines, taken off a map do not change."""
    mixed = np.diff(np.diff(values, axis=1), axis=0 if len(values) > 1 else 1)
    return mixed[np.isfinite(mixed)]


def _between_levels(measured: np.ndarray, most: int) -> tuple[int, float]:
    """Return how many numbers are no multiples of the step of all others, and that step, 0 without levels."""
    sample = measured[:: max(1, measured.size // _SAMPLE)]
    if not sample.size:
        return 0, 0.0
    gaps = np.diff(np.unique(sample))
    # levels that single precision cannot distinguish are one level
    gaps = np.sort(gaps[gaps > 4e-7 * np.abs(sample).max()])
    if gaps.size <= 4 * most:
        return 0, 0.0
    smallest = gaps[2 * most]  # a number between two levels makes two smaller gaps
    step = np.median(gaps[(gaps > smallest / 1.5) & (gaps < 1.5 * smallest)])
    middle = np.partition(sample, sample.size // 2)[sample.size // 2]
    for _ in range(3):  # the step, from many numbers
        places = (sample - middle) / step
        counts = np.rint(places)
        near = np.abs(places - counts) < 0.1
        if near.mean() < 0.9 or not counts[near].any():
            return 0, 0.0
        step = (counts[near] @ (sample - middle)[near]) / (counts[near] @ counts[near])
    off = (measured - middle) / step
    far = np.abs(off)
    off -= np.rint(off)
    np.abs(off, out=off)
    # rounding grows with the number
    usual, usually_far = (np.partition(each, -most - 1)[-most - 1] for each in (off, far))
    between = np.count_nonzero(off > np.maximum(far / usually_far, 1.0) * max(_OFF, _BEYOND * usual))
    return int(between), float(step)
