"""Garbage collection in short-lived processes that import large libraries."""

import atexit
import gc


def collect_rarely() -> None:
    """Reduce the frequency of garbage collection, and skip it at exit.

    By default Python searches for unreachable objects whenever some hundreds of new objects exist, and
    several times at exit. Nearly all objects are modules, classes and functions, which are never freed: the
    search takes a third of the time of a process that imports xarray and SciPy. Arrays are not affected:
    reference counting frees them at once.

    Examples
    --------
    >>> import subprocess, sys
    >>> script = "from roughcontact.command_line.garbage import collect_rarely as run, gc; run(); "
    >>> script += "print(gc.get_threshold()[0])"
    >>> print(subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout.strip())
    200000
    """
    gc.set_threshold(200_000, 50, 100)
    atexit.register(gc.freeze)
