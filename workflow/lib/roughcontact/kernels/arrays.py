"""Arrays of any library: precision, allocation and conversion."""

import math
from typing import Any

import numpy as np

from roughcontact.kernels.memory import store

Array = Any  # of any library that has the functions of the Python array API, which defines no type for it
SINGLE, DOUBLE = "float32", "float64"  # precisions, by the names that every array library uses


def namespace(field: Array) -> Any:
    """Return the functions of the library of an array, by the names of the Python array API."""
    if isinstance(field, np.ndarray):
        return np
    # arrays of CuPy and PyTorch have no `__array_namespace__`, and names of their own
    import array_api_compat

    return array_api_compat.array_namespace(field)


def n_elements(field: Array) -> int:
    """Return the number of elements of an array: its `size`, which is a method in PyTorch."""
    return math.prod(field.shape)


def like_array(values: np.ndarray, like: Array) -> Array:
    """Return the values of a NumPy array in the library and on the device of `like`."""
    # NumPy needs no transfer, and not the import of the other libraries' interface
    return values if isinstance(like, np.ndarray) else namespace(like).asarray(values, device=like.device)


def to_numpy(field: Array) -> np.ndarray:
    """Return an array of any library and device as one of NumPy, the same memory where that is possible."""
    try:
        return np.asarray(field)
    except TypeError:  # it is on a device whose memory NumPy cannot reach
        import array_api_compat

        return np.asarray(array_api_compat.to_device(field, "cpu"))


def get_precision(field: Array) -> str:
    """Return the precision, `SINGLE` or `DOUBLE`, of a real field of any library."""
    # all other types are computed in double
    return SINGLE if field.dtype == namespace(field).float32 else DOUBLE


def empty(like: Array, precision: str, shape: tuple[int, ...] | None = None) -> Array:
    """Return an uninitialised array of the library and on the device of `like`, by default of its shape."""
    shape = like.shape if shape is None else shape
    # from the pool: in every solve the same arrays are needed again
    if isinstance(like, np.ndarray):
        return store.empty(shape, precision)
    xp = namespace(like)
    return xp.empty(shape, dtype=getattr(xp, precision), device=like.device)


def as_precision(field: Array, precision: str, *, copy: bool = True) -> Array:
    """Return `field` in a precision; `copy`: also where it already has that precision."""
    xp = namespace(field)
    return xp.astype(field, getattr(xp, precision), copy=copy)
