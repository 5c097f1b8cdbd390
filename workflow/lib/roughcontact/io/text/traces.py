"""Profiles below one another in one list, and profiles that turn back: where the positions do not rise."""

from collections.abc import Sequence

import numpy as np

from roughcontact.quantities import several

_FEW = 4  # points; fewer are no trace
_SAME = 1.5  # steps within which traces begin, or end, at one place
_SHORTEST = 0.5  # of a trace, over the longest


def runs(x: np.ndarray) -> list[slice]:
    """Return the pieces of a list in which the positions (n,) rise, or fall, from point to point.

    Examples
    --------
    >>> runs(np.array([0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 1.0, 0.0]))
    [slice(0, 3, None), slice(3, 6, None), slice(6, 8, None)]
    """
    signs = np.sign(np.diff(x))
    found, start = [], 0
    while start < x.size:
        direction = signs[start] if start < signs.size else 0.0
        turns = np.flatnonzero(signs[start:] != direction)
        stop = start + 1 + (int(turns[0]) if turns.size else signs.size - start) if direction else start + 1
        found.append(slice(start, stop))
        start = stop
    return found


def are_traces(x: np.ndarray, pieces: Sequence[slice]) -> bool:
    """Return whether pieces of a list are traces over the same positions."""
    sizes = [piece.stop - piece.start for piece in pieces]
    if min(sizes) < max(_FEW, _SHORTEST * max(sizes)):
        return False
    step = _SAME * max(np.median(np.abs(np.diff(x[piece]))) for piece in pieces)
    ends = np.array([(x[piece].min(), x[piece].max()) for piece in pieces])
    return bool(min(np.ptp(ends, axis=0)) <= step < min(np.ptp(ends, axis=1)))


def turn(x: np.ndarray, pieces: Sequence[slice], lines: Sequence[int]) -> str:
    """Return a sentence on the place where positions do not go on; `lines` are those of the file."""
    place = pieces[1].start
    before, after = x[place - 1], x[place]
    how = "repeats" if before == after else "restarts" if are_traces(x, pieces) else "turns back"
    return f"x {how} at line {lines[place]}, from {before:g} to {after:g}"


def question(x: np.ndarray, pieces: Sequence[slice], lines: Sequence[int]) -> str:
    """Return the question for a list of several traces."""
    return (
        f"{turn(x, pieces, lines)}: {several(len(pieces), 'profile')} below one another, 'profile 1' to "
        f"'profile {len(pieces)}'"
    )
