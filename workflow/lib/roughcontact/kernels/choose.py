"""Choice of the kernel implementation for an array."""

import warnings
from functools import cache
from typing import Any

import numpy as np

from roughcontact.kernels import array_api, compiled
from roughcontact.kernels.arrays import Array
from roughcontact.kernels.threads import threads_for


def kernels_for(field: Array, *, threads: int = 1) -> Any:
    """Return what has the functions of `array_api` for arrays like `field`: for NumPy `Compiled`, if there.

    `field` determines library and size, `threads` is the maximum number.
    """
    if isinstance(field, np.ndarray) and library_available():
        return compiled.Compiled(threads_for(field.size, threads))
    return array_api


@cache
def library_available() -> bool:
    """Return whether the compiled kernels are available; warn, once, if they are not."""
    try:
        compiled.library()
    except OSError as problem:
        warnings.warn(
            f"no compiled kernels ({problem}): a solve takes several times as long. Install a C compiler, or "
            "the package ziglang, and then roughcontact again",
            stacklevel=2,  # where the solution was called
        )
        return False
    return True
