"""One interface to the real two-dimensional FFT, whoever computes it.

`scipy.fft` always works. `mkl_fft` is used where it is installed: it takes a tenth less. Arrays of another
library (CuPy, say) are transformed by that library.
"""

import os
from collections.abc import Callable, Iterator
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
        """Return the spectrum (ny, nx//2 + 1) in the layout of `numpy.fft.rfft2`, lost with the next call.

        Parameters
        ----------
        field : array (ny, nx)
            real.

        Returns
        -------
        array (ny, nx//2 + 1), complex
        """
        return field.__array_namespace__().fft.rfftn(field, axes=(0, 1))

    def inverse(self, spectrum: Array, out: Array) -> None:
        """Put the field, with the factor 1/(ny nx), into `out`; the spectrum may be lost.

        Parameters
        ----------
        spectrum : array (ny, nx//2 + 1), complex
        out : array (ny, nx)
            is written.
        """
        out[...] = out.__array_namespace__().fft.irfftn(spectrum, s=self.shape, axes=(0, 1))


class PlanInPlace(Plan):
    """The same for NumPy's arrays, between arrays that are there already.

    The spectrum lies in the memory of the plan `share`, where one of the same shape and higher precision is
    given, and the scratch array in that of the spectrum.
    """

    def __init__(self, like: Array, precision: str, *, threads: int = 1, share: "PlanInPlace | None" = None):
        self.shape = like.shape
        self.threads = threads_for(like.size, threads)
        waves = (self.shape[0], self.shape[1] // 2 + 1)
        kind = np.result_type(precision, np.complex64)
        self.spectrum: np.ndarray = (
            store.empty(waves, kind) if share is None else _within(share.spectrum, waves, kind)
        )
        self.scratch = _within(self.spectrum, self.shape, precision)


class ScipyPlan(PlanInPlace):
    """By SciPy.

    Its own rfft2 puts every result into memory that the system has to wipe first, and takes up to twice as
    long for that. So rows are transformed a few at a time, which stay in the cache until they are copied, and
    columns in place.
    """

    BLOCK = 2**18  # bytes of a spectrum that are transformed along the rows at a time, for each thread

    def forward(self, field: Array) -> Array:
        for rows in self._blocks():
            self.spectrum[rows] = scipy.fft.rfft(field[rows], axis=1, workers=self.threads)
        return self._columns(scipy.fft.fft, self.spectrum)

    def inverse(self, spectrum: Array, out: Array) -> None:
        spectrum = self._columns(scipy.fft.ifft, spectrum)
        for rows in self._blocks():
            out[rows] = scipy.fft.irfft(
                spectrum[rows], n=self.shape[1], axis=1, workers=self.threads, overwrite_x=True
            )

    def _columns(self, transform: Callable[..., Array], spectrum: Array) -> Array:
        return transform(spectrum, axis=0, workers=self.threads, overwrite_x=True)

    def _blocks(self) -> list[slice]:
        """Return slices of few rows each."""
        step = max(1, self.threads * self.BLOCK // self.spectrum[0].nbytes)
        return [slice(start, start + step) for start in range(0, self.shape[0], step)]


class MklPlan(PlanInPlace):
    """By MKL."""

    def __init__(self, like: Array, precision: str, *, threads: int = 1, share: PlanInPlace | None = None):
        _choose_mkl_threading()
        super().__init__(like, precision, threads=threads, share=share)

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
    """Before MKL is loaded, say how its threads wait, where the user has not said it in the environment.

    They would go on waiting busily after a transform, for 200 ms; this spans the gap between two.
    """
    os.environ.setdefault("KMP_BLOCKTIME", "1")


@cache
def mkl_is_installed() -> bool:
    """Return whether `mkl_fft` can be imported here.

    Returns
    -------
    bool
    """
    return find_spec("mkl_fft") is not None


def make_plan(like: Array, precision: str, *, threads: int = 1, share: Plan | None = None) -> Plan:
    """Return the fastest plan for fields like the array `like`; a single row or column is left to SciPy.

    A plan that may lie in the memory of `share`, of the same shape and higher precision, does.

    Parameters
    ----------
    like : array (ny, nx)
        of the shape, the library and the device of the fields.
    precision : str
        `SINGLE` or `DOUBLE`.
    threads : int
        to be used at most.
    share : Plan, optional
        whose memory may be used.

    Returns
    -------
    Plan
    """
    if not isinstance(like, np.ndarray):
        return Plan(like, precision, threads=threads)
    shared = share if isinstance(share, PlanInPlace) else None
    kind = MklPlan if mkl_is_installed() and min(like.shape) > 1 else ScipyPlan
    return kind(like, precision, threads=threads, share=shared)


def _within(memory: np.ndarray, shape: tuple[int, ...], dtype: DTypeLike) -> np.ndarray:
    """Return an array of `shape` and `dtype` that begins where the array `memory` begins."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    return memory.reshape(-1).view(np.uint8)[:size].view(dtype).reshape(shape)
