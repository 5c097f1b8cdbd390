"""How many threads a pass over a grid takes."""

import os

SMALL = 2**15  # points; below that handing out shares costs more than it saves
_here = {"forked": False}


def threads_for(size: int, threads: int) -> int:
    """Return the number of threads for a grid of `size` points where `threads` are allowed.

    One in a process that was forked from another: threads do not live on in it, and waiting for them would
    take for ever.

    Parameters
    ----------
    size : int
        points of the grid.
    threads : int
        allowed.

    Returns
    -------
    int
    """
    return threads if size >= SMALL and not _here["forked"] else 1


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _here.update(forked=True))
