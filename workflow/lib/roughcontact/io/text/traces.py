"""Profiles below one another in one list, and profiles that turn back: where the positions do not rise."""

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from roughcontact.io.guards import MAX_CHANNELS

_FEW_POINTS = 4  # points; fewer are no trace
_SAME_STEPS = 1.5  # steps within which traces begin, or end, at one place
_SHORTEST = 0.5  # of a trace, over the longest


def runs(x: np.ndarray) -> list[slice]:
    """Return the pieces, 10 001 at most, of a list in which the positions (n,) rise, or fall, throughout.

    Examples
    --------
    >>> runs(np.array([0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 1.0, 0.0]))
    [slice(0, 3, None), slice(3, 6, None), slice(6, 8, None)]
    """
    signs = np.nan_to_num(np.sign(np.diff(x)))
    stops = [*(np.flatnonzero(np.diff(signs)) + 1).tolist(), signs.size]  # of equal signs
    run_slices: list[slice] = []
    start = 0
    # heights taken for positions turn at every point: a file of millions of runs is refused, not listed
    while start < x.size and len(run_slices) <= MAX_CHANNELS:
        stop = stops[bisect_right(stops, start)] + 1 if start < signs.size and signs[start] else start + 1
        run_slices.append(slice(start, stop))
        start = stop
    return run_slices


def are_traces(x: np.ndarray, traces: Sequence[slice]) -> bool:
    """Return whether pieces of a list are traces over the same positions."""
    sizes = [trace.stop - trace.start for trace in traces]
    if min(sizes) < max(_FEW_POINTS, _SHORTEST * max(sizes)):
        return False
    step = _SAME_STEPS * max(np.median(np.abs(np.diff(x[trace]))) for trace in traces)
    extremes = np.array([(x[trace].min(), x[trace].max()) for trace in traces])
    return bool(min(np.ptp(extremes, axis=0)) <= step < min(np.ptp(extremes, axis=1)))


def turn(x: np.ndarray, traces: Sequence[slice], lines: Sequence[int]) -> str:
    """Return a sentence on the place where positions do not go on; `lines` are those of the file."""
    index = traces[1].start
    previous, following = x[index - 1], x[index]
    how = "repeats" if previous == following else "restarts" if are_traces(x, traces) else "turns back"
    return f"x {how} at line {lines[index]}, from {previous:g} to {following:g}"
