"""Profiles below one another in one list, and profiles that turn back: where the positions do not rise."""

from collections.abc import Sequence

import numpy as np

_FEW_POINTS = 4  # points; fewer are no trace
_SAME_STEPS = 1.5  # steps within which traces begin, or end, at one place
_SHORTEST = 0.5  # of a trace, over the longest


def runs(x: np.ndarray) -> list[slice]:
    """Return the pieces of a list in which the positions (n,) rise, or fall, from point to point.

    Examples
    --------
    >>> runs(np.array([0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 1.0, 0.0]))
    [slice(0, 3, None), slice(3, 6, None), slice(6, 8, None)]
    """
    signs = np.sign(np.diff(x))
    run_slices, start = [], 0
    while start < x.size:
        direction = signs[start] if start < signs.size else 0.0
        turns = np.flatnonzero(signs[start:] != direction)
        stop = start + 1 + (int(turns[0]) if turns.size else signs.size - start) if direction else start + 1
        run_slices.append(slice(start, stop))
        start = stop
    return run_slices


def are_traces(x: np.ndarray, traces: Sequence[slice]) -> bool:
    """Return whether pieces of a list are traces over the same positions."""
    sizes = [trace.stop - trace.start for trace in traces]
    if min(sizes) < max(_FEW_POINTS, _SHORTEST * max(sizes)):
        return False
    step = _SAME_STEPS * max(np.median(np.abs(np.diff(x[trace]))) for trace in traces)
    ends = np.array([(x[trace].min(), x[trace].max()) for trace in traces])
    return bool(min(np.ptp(ends, axis=0)) <= step < min(np.ptp(ends, axis=1)))


def turn(x: np.ndarray, traces: Sequence[slice], lines: Sequence[int]) -> str:
    """Return a sentence on the place where positions do not go on; `lines` are those of the file."""
    index = traces[1].start
    before, after = x[index - 1], x[index]
    how = "repeats" if before == after else "restarts" if are_traces(x, traces) else "turns back"
    return f"x {how} at line {lines[index]}, from {before:g} to {after:g}"
