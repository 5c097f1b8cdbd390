"""Arrays of any library: their precision, and new ones like them."""

from typing import Any

import numpy as np

from roughcontact.kernels.memory import store

Array = Any  # of any library that keeps to the Python array API; its standard has no type to name yet
SINGLE, DOUBLE = "float32", "float64"  # precisions, by the names that every array library uses


def precision_of(field: Array) -> str:
    """Return the precision of a real field.

    Parameters
    ----------
    field : array
        real, of any library.

    Returns
    -------
    str
        `SINGLE` or `DOUBLE`.
    """
    return SINGLE if field.dtype == field.__array_namespace__().float32 else DOUBLE


def empty(like: Array, precision: str, shape: tuple[int, ...] | None = None) -> Array:
    """Return a new array of a precision, of the library and on the device of `like`, and of its shape.

    Parameters
    ----------
    like : array
        of the library and the device.
    precision : str
        `SINGLE` or `DOUBLE`.
    shape : tuple of int, optional
        where it is another one.

    Returns
    -------
    array
        its content undefined.
    """
    shape = like.shape if shape is None else shape
    if isinstance(like, np.ndarray):
        return store.empty(shape, precision)
    xp = like.__array_namespace__()
    return xp.empty(shape, dtype=getattr(xp, precision), device=like.device)


def in_precision(field: Array, precision: str, *, copy: bool = True) -> Array:
    """Return `field` in a precision; itself where it has that already and no `copy` is wanted.

    Parameters
    ----------
    field : array
    precision : str
        `SINGLE` or `DOUBLE`.
    copy : bool
        whether it must be a new array.

    Returns
    -------
    array
    """
    xp = field.__array_namespace__()
    return xp.astype(field, getattr(xp, precision), copy=copy)
