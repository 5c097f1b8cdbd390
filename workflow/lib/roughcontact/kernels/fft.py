"""Common interface to the real two-dimensional FFT of several libraries.

NumPy arrays are transformed by the compiled kernels (`kernels/c/transforms.h`) where sides have no prime
factors other than 2, 3 and 5, else by SciPy; other arrays by their own library.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from roughcontact.kernels.arrays import Array, empty, n_elements, namespace
from roughcontact.kernels.choose import library_available
from roughcontact.kernels.compiled import run_pass
from roughcontact.kernels.fourier import has_few_factors
from roughcontact.kernels.memory import store
from roughcontact.kernels.threads import threads_for

MIN_SIDE = 16  # points, for transforms in C: for shorter sides most vector lanes are empty


class Plan:
    """Transforms of real fields by their own library.

    `like` is an array of the shape, library and device of the fields. Every transform may overwrite the work
    array `scratch` (ny, nx).
    """

    def __init__(self, like: Array, precision: str, *, threads: int = 1):
        self.shape = tuple(like.shape)
        self.threads = threads_for(n_elements(like), threads)
        self.scratch = empty(like, precision)

    def forward(self, field: Array, *, offset: float = 0.0) -> Array:
        """Return the spectrum of `field` - `offset` in the layout of `numpy.fft.rfft2`.

        The next call may overwrite it.
        """
        return namespace(field).fft.rfftn(field - offset, axes=(0, 1))

    def inverse(self, spectrum: Array, out: Array) -> None:
        """Write the inverse transform, with the factor 1/(ny nx), to `out`.

        The spectrum may be overwritten.
        """
        out[...] = namespace(out).fft.irfftn(spectrum, s=self.shape, axes=(0, 1))


class PlanInPlace(Plan):
    """Transforms of NumPy arrays in preallocated memory.

    If a plan `share` of the same shape and higher precision is given, the spectrum uses its memory. The
    scratch array uses the memory of the spectrum.
    """

    def __init__(self, like: Array, precision: str, *, threads: int = 1, share: "PlanInPlace | None" = None):
        self.shape = like.shape
        self.threads = threads_for(n_elements(like), threads)
        waves = (self.shape[0], self.shape[1] // 2 + 1)
        complex_dtype = np.result_type(precision, np.complex64)
        if share is None:
            self.spectrum: np.ndarray = store.empty(waves, complex_dtype)
        else:
            self.spectrum = _within(share.spectrum, waves, complex_dtype)
        self.scratch = _within(self.spectrum, self.shape, precision)


class ScipyPlan(PlanInPlace):
    """Transforms by SciPy, rows in blocks that stay in the cache until they are copied, columns in place."""

    # `scipy.fft.rfft2` allocates memory for every result, which the system must clear first: up to twice the
    # time
    BLOCK = 2**18  # bytes of the spectrum per thread in a block of rows
    LARGE = 2**22  # points above which SciPy's threads, woken for every block, save time

    def __init__(self, like: Array, precision: str, *, threads: int = 1, share: PlanInPlace | None = None):
        super().__init__(like, precision, threads=threads if like.size >= self.LARGE else 1, share=share)

    def forward(self, field: Array, *, offset: float = 0.0) -> Array:
        # on demand: the import takes a fifth of the time to a first solution
        import scipy.fft

        for rows in self._blocks():
            self.spectrum[rows] = scipy.fft.rfft(field[rows] - offset, axis=1, workers=self.threads)
        return self._columns(scipy.fft.fft, self.spectrum)

    def inverse(self, spectrum: Array, out: Array) -> None:
        import scipy.fft

        spectrum = self._columns(scipy.fft.ifft, spectrum)
        for rows in self._blocks():
            out[rows] = scipy.fft.irfft(
                spectrum[rows], n=self.shape[1], axis=1, workers=self.threads, overwrite_x=True
            )

    def _columns(self, transform: Callable[..., Array], spectrum: Array) -> Array:
        return transform(spectrum, axis=0, workers=self.threads, overwrite_x=True)

    def _blocks(self) -> list[slice]:
        """Return slices of a few rows each."""
        step = max(1, self.threads * self.BLOCK // self.spectrum[0].nbytes)  # at least a row, however long
        return [slice(start, start + step) for start in range(0, self.shape[0], step)]


class CompiledPlan(PlanInPlace):
    """Transforms by the compiled kernels, with two rows or one column in each vector lane."""

    def forward(self, field: Array, *, offset: float = 0.0) -> Array:
        field = np.require(field, self.scratch.dtype, ["C", "A", "W"])
        (ny, nx), roots = self.shape, _roots(self.shape[1], field.dtype)
        # 1/(ny nx) is applied on the way back
        self._run("rows_forward", ny * field.itemsize, nx, (field, self.spectrum, roots), offset, ny, nx)
        self._columns(self.spectrum, backward=False)
        return self.spectrum

    def inverse(self, spectrum: Array, out: Array) -> None:
        (ny, nx), roots = self.shape, _roots(self.shape[1], out.dtype)
        spectrum, output = (np.require(array, requirements=["C", "A", "W"]) for array in (spectrum, out))
        self._columns(spectrum, backward=True)
        self._run("rows_backward", ny * out.itemsize, nx, (output, spectrum, roots), 1 / out.size, ny, nx)
        if output is not out:
            out[...] = output

    def _columns(self, spectrum: Array, *, backward: bool) -> None:
        (ny, waves), roots = spectrum.shape, _roots(self.shape[0], spectrum.real.dtype)
        self._run("columns", waves * spectrum.itemsize, ny, (spectrum, roots), ny, waves, backward)

    def _run(self, name: str, breadth: int, length: int, *arguments: Any) -> None:
        """Run a pass over lines of `length` points that span `breadth` bytes, in blocks of 128 bytes."""
        run_pass(name, -(-breadth // 128), 32 * length + 8, *arguments, threads=self.threads)


@lru_cache(maxsize=64)
def _roots(n: int, precision: np.dtype) -> np.ndarray:
    """Return real and imaginary parts of exp(-2 pi i k / n) for k from 0 to n - 1."""
    # long double, and the angle within half a turn: each root is right to its last digit
    turns = np.arange(n, dtype=np.longdouble) / n
    angles = -2 * np.arccos(np.longdouble(-1)) * (turns - np.round(turns))
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1).astype(precision)


def make_plan(like: Array, precision: str, *, threads: int = 1, share: Plan | None = None) -> Plan:
    """Return the fastest available plan for fields like the array `like`.

    The memory of `share`, a plan of the same shape and higher precision, is used if possible.
    """
    if not isinstance(like, np.ndarray):
        return Plan(like, precision, threads=threads)
    plan = share if isinstance(share, PlanInPlace) else None
    # the compiled transforms know prime factors up to 5
    in_c = library_available() and min(like.shape) >= MIN_SIDE and all(map(has_few_factors, like.shape))
    return (CompiledPlan if in_c else ScipyPlan)(like, precision, threads=threads, share=plan)


def _within(memory: np.ndarray, shape: tuple[int, ...], dtype: DTypeLike) -> np.ndarray:
    """Return an array of `shape` and `dtype` at the start of the memory of the array `memory`."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    return memory.reshape(-1).view(np.uint8)[:size].view(dtype).reshape(shape)
