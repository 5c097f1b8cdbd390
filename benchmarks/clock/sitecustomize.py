"""Write down, at the end of every Python process with this folder on its path, what it has taken."""

import atexit
import json
import os
import sys
import time

_BEGIN = time.time()


def _record():
    import resource  # late: most processes do not write

    used = resource.getrusage(resource.RUSAGE_SELF)
    entry = {
        "command": sys.orig_argv,
        "script": getattr(sys.modules["__main__"], "__file__", ""),  # of a fork that of its job
        "seconds": time.time() - _BEGIN,
        "cpu": used.ru_utime + used.ru_stime,
        "peak_MB": used.ru_maxrss / 1024,
    }
    with open(os.environ["CLOCK"], "a", encoding="utf-8") as file:  # noqa: PTH123 - one write, of one line
        file.write(json.dumps(entry) + "\n")


if "CLOCK" in os.environ:
    atexit.register(_record)
