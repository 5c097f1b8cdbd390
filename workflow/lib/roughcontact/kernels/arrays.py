"""Arrays of any library: their precision, and new ones like them."""

import numpy as np

from roughcontact.kernels.memory import store

SINGLE, DOUBLE = "float32", "float64"  # precisions, by the names that every array library uses


def precision_of(field) -> str:
    """Return the precision of a real field."""
    return SINGLE if field.dtype == field.__array_namespace__().float32 else DOUBLE


def empty(like, precision: str, shape=None):
    """Return a new array of a precision, of the library and on the device of `like`, and of its shape."""
    shape = like.shape if shape is None else shape
    if isinstance(like, np.ndarray):
        return store.empty(shape, precision)
    xp = like.__array_namespace__()
    return xp.empty(shape, dtype=getattr(xp, precision), device=like.device)


def in_precision(field, precision: str, *, copy: bool = True):
    """Return `field` in a precision; itself where it has that already and no `copy` is wanted."""
    xp = field.__array_namespace__()
    return xp.astype(field, getattr(xp, precision), copy=copy)
