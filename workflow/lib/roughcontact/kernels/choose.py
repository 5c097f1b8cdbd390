"""Which implementation of the kernels serves an array."""

from functools import cache
from importlib.util import find_spec

import numpy as np

from roughcontact.kernels import array_api
from roughcontact.kernels.arrays import Array
from roughcontact.kernels.protocol import Kernels
from roughcontact.kernels.threads import threads_for


def kernels_for(field: Array, *, threads: int = 1) -> Kernels:
    """Return the kernels for arrays like one: compiled for NumPy's, where Numba is installed.

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
    if isinstance(field, np.ndarray) and numba_is_installed():
        from roughcontact.kernels.numba_cpu import Compiled

        return Compiled(threads_for(field.size, threads))
    return array_api


@cache
def numba_is_installed() -> bool:
    """Return whether `numba` can be imported here."""
    return find_spec("numba") is not None
