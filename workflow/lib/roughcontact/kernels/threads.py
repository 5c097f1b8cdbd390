"""Number of threads for a pass over a grid."""

import os

MIN_POINTS = 2**16  # of a grid for several threads: for fewer points distributing the work costs more
_process = {"started": False, "forked": False}  # worker threads; a fork of a process that had some


def threads_for(size: int, threads: int) -> int:
    """Return the number of threads, at most `threads`, for a grid of `size` points.

    It is 1 in a fork of a process that had used several: worker threads do not survive a fork, and waiting
    for them would never end.
    """
    if size < MIN_POINTS or threads == 1 or _process["forked"]:
        return 1
    _process["started"] = True
    return threads


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _process.update(forked=_process["started"]))
