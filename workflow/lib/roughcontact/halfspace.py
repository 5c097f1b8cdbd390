"""The periodic elastic half-space: what a pressure does to its surface.

A pressure wave p exp(i q x) displaces the surface of a half-space by u = 2 p / (E* |q|) exp(i q x)
(Johnson 1985, Contact Mechanics, chapter 13; seed paper eq. 10 with 1/E* = (1 - nu^2)/E). Everything here
is dimensionless: lengths over a length L, heights over g L, pressures over E* g, so that the symbol is
2/|q| with q in units of 1/L. `roughcontact.contact.problem` does the scaling.
"""

import math

import numpy as np

from roughcontact.errors import SettingsError
from roughcontact.fft import make_plan
from roughcontact.fourier import wavenumbers


class HalfSpace:
    """The operators u = G p, with symbol 2/|q|, and its inverse p = G^-1 u, with symbol |q|/2, on one grid.

    The mean (q = 0) is left out of both: it is a matter of reference, see `zero_frequency_compliance`. What
    an operator returns lies in a buffer, one per precision: it holds until the next application in that
    precision. `applications` counts forward and inverse transform pairs.
    """

    def __init__(self, shape: tuple[int, int], lengths: tuple[float, float], *, threads: int = 1):
        self.shape = tuple(shape)
        self.lengths = tuple(lengths)
        self.threads = threads
        self.applications = 0.0
        q = wavenumbers(shape, [length / n for length, n in zip(lengths, shape, strict=True)])
        self.mean_wavenumber = float(q.mean())  # over the half plane, for rounding estimates
        self.stiffest = float(q.max()) / 2  # largest symbol of G^-1
        q[0, 0] = np.inf
        self._symbols = {np.dtype(np.float64): np.divide(2, q, out=q)}
        self._plans = {}

    def displacement(self, pressure):
        """Return u = G p, shape (ny, nx), mean zero, in the precision of `pressure`."""
        plan = self._load(pressure)
        plan.forward()
        plan.spectrum *= self._symbol(pressure.dtype)
        return self._finish(plan)

    def pressure(self, displacement):
        """Return p = G^-1 u, shape (ny, nx), mean zero, in the precision of `displacement`."""
        plan = self._load(displacement)
        plan.forward()
        plan.spectrum[0, 0] = 0
        symbol = self._symbol(displacement.dtype)
        plan.spectrum[0, 1:] /= symbol[0, 1:]
        plan.spectrum[1:] /= symbol[1:]
        return self._finish(plan)

    def room(self, dtype):
        """Return the array from which the next application reads: what is put there is not copied."""
        return self._plan(dtype).field

    def _load(self, field):
        plan = self._plan(field.dtype)
        if field is not plan.field:
            plan.field[...] = field
        return plan

    def _finish(self, plan):
        plan.inverse()
        self.applications += 1
        return plan.result

    def _plan(self, dtype):
        dtype = np.dtype(dtype)
        if dtype not in self._plans:
            self._plans[dtype] = make_plan(self.shape, dtype, threads=self.threads)
        return self._plans[dtype]

    def _symbol(self, dtype):
        if dtype not in self._symbols:
            self._symbols[dtype] = self._symbols[np.dtype(np.float64)].astype(dtype)
        return self._symbols[dtype]


def zero_frequency_compliance(rule: str, *, lengths: tuple[float, float]) -> float:
    """Return E* times the mean displacement per mean pressure (m), the part that q = 0 leaves open.

    ``zero``: the displacement is counted from its own mean. ``nogi-kato``: the mean of 2/|q| over the
    zero-frequency cell of the reciprocal lattice (Nogi and Kato 1997; seed paper eq. 14), in closed form
    (Lx Ly / 4 pi^2) 8 [a asinh(b/a) + b asinh(a/b)] with a = pi/Lx, b = pi/Ly. ``lattice``: the value for
    which one localised contact per square period approaches as it would in free space,
    3.900265/pi L (lattice constant of a square array of point loads).

    `lengths` = (Ly, Lx) in metres; pressure and area do not depend on the rule, the approach does.

    Raises
    ------
    SettingsError
        for an unknown rule, or for ``lattice`` on a period that is not square.
    """
    ly, lx = lengths
    if rule == "zero":
        return 0.0
    if rule == "nogi-kato":
        a, b = math.pi / lx, math.pi / ly
        return lx * ly / (4 * math.pi**2) * 8 * (a * math.asinh(b / a) + b * math.asinh(a / b))
    if rule == "lattice":
        if not math.isclose(lx, ly, rel_tol=1e-6):
            raise SettingsError(
                f"zero_frequency 'lattice' holds for a square period, this one is {lx:g} m x {ly:g} m; "
                "use 'zero' or 'nogi-kato'"
            )
        return 3.900265 / math.pi * lx
    raise SettingsError(f"unknown zero_frequency {rule!r}; choose zero, nogi-kato or lattice")
