"""Which implementation of the kernels serves an array."""

import warnings
from functools import cache

import numpy as np

from roughcontact.kernels import array_api, compiled
from roughcontact.kernels.arrays import Array
from roughcontact.kernels.protocol import Kernels
from roughcontact.kernels.threads import threads_for


def kernels_for(field: Array, *, threads: int = 1) -> Kernels:
    """Return the kernels for arrays like one: compiled for NumPy's, where they were built.

    Parameters
    ----------
    field : array (ny, nx)
        of the library and the size that the fields will have.
    threads : int
        allowed.

    Returns
    -------
    Kernels
        an implementation.
    """
    if isinstance(field, np.ndarray) and library_is_there():
        return compiled.Compiled(threads_for(field.size, threads))
    return array_api


@cache
def library_is_there() -> bool:
    """Return whether the compiled kernels can be used here; say so, once, where they cannot.

    Returns
    -------
    bool
    """
    try:
        compiled.library()
    except OSError as problem:
        warnings.warn(
            f"no compiled kernels ({problem}): a solve takes several times as long. Install a C compiler, or "
            "the package ziglang, and then roughcontact again",
            stacklevel=2,
        )
        return False
    return True
