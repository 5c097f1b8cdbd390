"""One interface to the real two-dimensional FFT, whoever computes it.

`scipy.fft` always works. `mkl_fft` is used where it is installed: of the libraries that need no planning it
was the fastest in every measurement, most of all because it writes into memory that is there already. Arrays
of another library (CuPy, say) are transformed by that library.
"""

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec

import numpy as np
import scipy.fft
from numpy.typing import DTypeLike

from roughcontact.kernels.arrays import Array, empty
from roughcontact.kernels.memory import store
from roughcontact.kernels.threads import threads_for


class Plan:
    """Transforms of real fields, by the library that they belong to.

    Parameters
    ----------
    like : array (ny, nx)
        of the shape, the library and the device of the fields.
    precision : str
        of the fields.
    threads : int
        allowed.

    Attributes
    ----------
    scratch : array (ny, nx)
        like the fields; every transform may overwrite it.
    """

    def __init__(self, like: Array, precision: str, *, threads: int = 1):
        self.shape = tuple(like.shape)
        self.threads = threads_for(like.size, threads)
        self.scratch = empty(like, precision)

    def forward(self, field: Array) -> Array:
        """Return the spectrum (ny, nx//2 + 1) in the layout of `numpy.fft.rfft2`, lost with the next call."""
        return field.__array_namespace__().fft.rfftn(field, axes=(0, 1))

    def inverse(self, spectrum: Array, out: Array) -> None:
        """Put the field, with the factor 1/(ny nx), into `out`; the spectrum may be lost."""
        out[...] = out.__array_namespace__().fft.irfftn(spectrum, s=self.shape, axes=(0, 1))


class ScipyPlan(Plan):
    """The same for NumPy's arrays, by SciPy."""

    def forward(self, field: Array) -> Array:
        return scipy.fft.rfft2(field, workers=self.threads)

    def inverse(self, spectrum: Array, out: Array) -> None:
        out[...] = scipy.fft.irfft2(spectrum, s=self.shape, workers=self.threads, overwrite_x=True)


class MklPlan(Plan):
    """The same for NumPy's arrays, by MKL, between arrays that are there already.

    The spectrum lies in the memory of the plan `share`, where one of the same shape and higher precision is
    given, and the scratch array in that of the spectrum.
    """

    def __init__(self, like: Array, precision: str, *, threads: int = 1, share: "MklPlan | None" = None):
        _choose_mkl_threading()
        self.shape = like.shape
        self.threads = threads_for(like.size, threads)
        waves = (self.shape[0], self.shape[1] // 2 + 1)
        kind = np.result_type(precision, np.complex64)
        self.spectrum: np.ndarray = (
            store.empty(waves, kind) if share is None else _within(share.spectrum, waves, kind)
        )
        self.scratch = _within(self.spectrum, self.shape, precision)

    def forward(self, field: Array) -> Array:
        import mkl_fft

        with _mkl_threads(self.threads):
            # one axis after the other: rfft2 is never faster, and slower on small grids
            spectrum = mkl_fft.rfft(field, axis=1, out=self.spectrum)
            return mkl_fft.fft(spectrum, axis=0, out=spectrum)

    def inverse(self, spectrum: Array, out: Array) -> None:
        import mkl_fft

        with _mkl_threads(self.threads):
            mkl_fft.ifft(spectrum, axis=0, out=spectrum)  # in place, as irfft2 is not
            mkl_fft.irfft(spectrum, n=self.shape[1], axis=1, out=out)


@contextmanager
def _mkl_threads(threads: int) -> Iterator[None]:
    """Let MKL use so many threads; left alone it takes all, and rounds differently with each number."""
    import mkl

    before = mkl.set_num_threads_local(threads)
    try:
        yield
    finally:
        mkl.set_num_threads_local(before)


@cache
def _choose_mkl_threading() -> None:
    """Before MKL is loaded, say how it threads, where the user has not said it in the environment."""
    try:
        # one pool of threads with Numba: two pools take the cores from each other
        ctypes.CDLL("libgomp.so.1")
        os.environ.setdefault("MKL_THREADING_LAYER", "GNU")
    except OSError:
        # Intel's threads go on waiting busily after a transform, for 200 ms; this spans the gap between two
        os.environ.setdefault("KMP_BLOCKTIME", "1")


@cache
def mkl_is_installed() -> bool:
    """Return whether `mkl_fft` can be imported here."""
    return find_spec("mkl_fft") is not None


def make_plan(like: Array, precision: str, *, threads: int = 1, share: Plan | None = None) -> Plan:
    """Return the fastest plan for fields like the array `like`; a single row or column is left to SciPy.

    A plan that may lie in the memory of `share`, of the same shape and higher precision, does.
    """
    if not isinstance(like, np.ndarray):
        return Plan(like, precision, threads=threads)
    if mkl_is_installed() and min(like.shape) > 1:
        shared = share if isinstance(share, MklPlan) else None
        return MklPlan(like, precision, threads=threads, share=shared)
    return ScipyPlan(like, precision, threads=threads)


def _within(memory: np.ndarray, shape: tuple[int, ...], dtype: DTypeLike) -> np.ndarray:
    """Return an array of `shape` and `dtype` that begins where the array `memory` begins."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    return memory.reshape(-1).view(np.uint8)[:size].view(dtype).reshape(shape)
