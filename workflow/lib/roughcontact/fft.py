"""One interface to the real two-dimensional FFT, whoever computes it.

`scipy.fft` always works. `mkl_fft` is used where it is installed: of the libraries that need no planning it
was the fastest in every measurement, most of all because it writes into memory that is there already.
"""

from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec

import numpy as np
import scipy.fft

_SMALL = 128 * 128  # points; below that starting threads costs more than they save


class Plan:
    """Transforms of real fields of one shape and precision, between three buffers.

    `forward` takes `field` (ny, nx) to `spectrum` (ny, nx//2 + 1), the layout of `numpy.fft.rfft2`; `inverse`
    takes `spectrum` to `result` (ny, nx), with the factor 1/(ny nx). `field` is kept; the spectrum may be
    destroyed, and both outputs are overwritten by the next call. A plan that is to `share` lies in the memory
    of another one of the same shape and higher precision, so that only one of the two holds anything.
    """

    def __init__(self, shape: tuple[int, int], dtype, *, threads: int = 1, share: "Plan | None" = None):
        self.shape, self.threads = shape, threads if np.prod(shape) >= _SMALL else 1
        self.field = _room(shape, dtype, None if share is None else share.field)
        self.spectrum = self.result = None

    def forward(self) -> None:
        self.spectrum = scipy.fft.rfft2(self.field, workers=self.threads)

    def inverse(self) -> None:
        self.result = scipy.fft.irfft2(self.spectrum, s=self.shape, workers=self.threads, overwrite_x=True)


class MklPlan(Plan):
    """The same by MKL."""

    def __init__(self, shape, dtype, *, threads=1, share=None):
        super().__init__(shape, dtype, threads=threads, share=share)
        complex_type = np.result_type(dtype, np.complex64)
        waves = (shape[0], shape[1] // 2 + 1)
        self.spectrum = _room(waves, complex_type, None if share is None else share.spectrum)
        self.result = _room(shape, dtype, None if share is None else share.result)

    def forward(self):
        import mkl_fft

        with _mkl_threads(self.threads):
            mkl_fft.rfft2(self.field, out=self.spectrum)

    def inverse(self):
        import mkl_fft

        with _mkl_threads(self.threads):
            mkl_fft.irfft2(self.spectrum, s=self.shape, out=self.result)


@contextmanager
def _mkl_threads(threads):
    """Let MKL use so many threads; left alone it takes all, and rounds differently with each number."""
    import mkl

    before = mkl.set_num_threads_local(threads)
    try:
        yield
    finally:
        mkl.set_num_threads_local(before)


@cache
def mkl_is_installed() -> bool:
    """Return whether `mkl_fft` can be imported here."""
    return find_spec("mkl_fft") is not None


def make_plan(shape: tuple[int, int], dtype, *, threads: int = 1, share: Plan | None = None) -> Plan:
    """Return the fastest plan for fields of `shape` and `dtype`; a single row or column is left to SciPy."""
    kind = MklPlan if mkl_is_installed() and min(shape) > 1 else Plan
    return kind(tuple(shape), np.dtype(dtype), threads=threads, share=share)


def _room(shape, dtype, shared):
    """Return an array of `shape` and `dtype`, in the memory of the array `shared` where one is given."""
    if shared is None:
        return np.empty(shape, dtype=dtype)
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    return shared.reshape(-1).view(np.uint8)[:size].view(dtype).reshape(shape)
