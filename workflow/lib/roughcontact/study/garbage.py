"""Garbage collection in short-lived processes that import large libraries."""

import atexit
import gc


def collect_rarely() -> None:
    """Reduce the frequency of garbage collection, and skip it at exit: a third of the time of the imports.

    Examples
    --------
    >>> import subprocess, sys
    >>> script = "from roughcontact.study.garbage import collect_rarely as run, gc; run(); "
    >>> script += "print(gc.get_threshold()[0])"
    >>> print(subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout.strip())
    400000
    """
    # nearly all objects are modules, classes and functions, never freed, 200 000 to 250 000 for a map; arrays
    # go by reference counting
    gc.set_threshold(400_000, 50, 100)
    atexit.register(gc.freeze)
