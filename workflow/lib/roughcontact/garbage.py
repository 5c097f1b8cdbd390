"""Collection of garbage in a process that imports much, keeps it, and lives for seconds."""

import atexit
import gc


def collect_rarely() -> None:
    """Look for unreachable objects rarely, and not once more through all that is left at the end.

    Python looks through its objects each time that some hundreds of them have come up, and several times
    while it ends. Nearly all of them are modules, classes and functions, which stay: a third of the time of a
    process that imports xarray and SciPy goes into that. Arrays are given back as before, as soon as nobody
    refers to them.

    Examples
    --------
    >>> import subprocess, sys
    >>> script = "import gc, roughcontact.garbage as own; own.collect_rarely(); print(gc.get_threshold()[0])"
    >>> print(subprocess.run([sys.executable, "-c", script], capture_output=True, text=True).stdout.strip())
    200000
    """
    gc.set_threshold(200_000, 50, 100)
    atexit.register(gc.freeze)
