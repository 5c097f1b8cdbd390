"""One interface to the real two-dimensional FFT, whoever computes it.

`scipy.fft` always works and is the reference. `mkl_fft` is used where it is installed, because it was the
fastest in every measurement (see `benchmarks/`); it follows the thread count of MKL.
"""

from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec

import scipy.fft

_SMALL = 128 * 128  # points; below that starting threads costs more than they save


@dataclass(frozen=True)
class Transform:
    """A pair of functions: `forward(field) -> spectrum`, `inverse(spectrum, shape) -> field`.

    The spectrum has the layout of `numpy.fft.rfft2`; the inverse carries the factor 1/(ny nx) and may
    overwrite its argument. Both keep the precision of their argument (single or double).
    """

    name: str
    forward: callable
    inverse: callable


def _scipy(threads: int) -> Transform:
    def workers(size):
        return threads if size >= _SMALL else 1

    def forward(field):
        return scipy.fft.rfft2(field, workers=workers(field.size))

    def inverse(spectrum, shape):
        return scipy.fft.irfft2(spectrum, s=shape, workers=workers(2 * spectrum.size), overwrite_x=True)

    return Transform("scipy", forward, inverse)


def _mkl(threads: int) -> Transform:
    import mkl_fft

    scalar = _scipy(1)  # MKL's planner refuses an axis of one point

    def forward(field):
        if 1 in field.shape:
            return scalar.forward(field)
        return mkl_fft.rfft2(field)

    def inverse(spectrum, shape):
        if 1 in shape:
            return scalar.inverse(spectrum, shape)
        return mkl_fft.irfft2(spectrum, s=shape)

    return Transform("mkl_fft", forward, inverse)


_BACKENDS = {"mkl_fft": _mkl, "scipy": _scipy}


@cache
def available() -> tuple[str, ...]:
    """Return the names of the backends that can be imported here, fastest first."""
    return tuple(name for name in _BACKENDS if name == "scipy" or find_spec(name) is not None)


def transform(*, threads: int = 1, backend: str | None = None) -> Transform:
    """Return the fastest installed transform, or the named one."""
    return _BACKENDS[backend or available()[0]](threads)
