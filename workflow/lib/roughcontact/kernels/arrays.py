"""Arrays of any library: precision, allocation and conversion."""

from typing import Any

import numpy as np

from roughcontact.kernels.memory import store

Array = Any  # of any library that follows the Python array API standard, which defines no type for it
SINGLE, DOUBLE = "float32", "float64"  # precisions, by the names that every array library uses


def precision_of(field: Array) -> str:
    """Return the precision, `SINGLE` or `DOUBLE`, of a real field of any library."""
    return SINGLE if field.dtype == field.__array_namespace__().float32 else DOUBLE


def empty(like: Array, precision: str, shape: tuple[int, ...] | None = None) -> Array:
    """Return an uninitialised array of the library and on the device of `like`, by default of its shape."""
    shape = like.shape if shape is None else shape
    if isinstance(like, np.ndarray):
        return store.empty(shape, precision)
    xp = like.__array_namespace__()
    return xp.empty(shape, dtype=getattr(xp, precision), device=like.device)


def in_precision(field: Array, precision: str, *, copy: bool = True) -> Array:
    """Return `field` in a precision; `copy`: also where it already has that precision."""
    xp = field.__array_namespace__()
    return xp.astype(field, getattr(xp, precision), copy=copy)
