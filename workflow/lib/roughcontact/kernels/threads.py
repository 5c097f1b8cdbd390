"""Number of threads for a pass over a grid."""

import os

MIN_POINTS = 2**16  # of a grid for several threads: for fewer points distributing the work costs more
_process = {"forked": False}


def threads_for(size: int, threads: int) -> int:
    """Return the number of threads, at most `threads`, for a grid of `size` points.

    It is 1 in a forked process: worker threads do not survive a fork, and waiting for them would never end.
    """
    return threads if size >= MIN_POINTS and not _process["forked"] else 1


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _process.update(forked=True))
