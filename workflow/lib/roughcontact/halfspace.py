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
from roughcontact.fourier import wavevectors
from roughcontact.influence import INFLUENCE
from roughcontact.kernels import kernels_for

_SINGLE, _DOUBLE = np.dtype(np.float32), np.dtype(np.float64)


class HalfSpace:
    """The operators u = G p, with symbol 2/|q|, and its inverse p = G^-1 u, with symbol |q|/2, on one grid.

    `influence` names another symbol (`roughcontact.influence`).
    The mean (q = 0) is left out of both: it is a matter of reference, see `zero_frequency_compliance`. What
    an operator returns lies in a buffer: it holds until the next application. `applications` counts forward
    and inverse transform pairs.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        lengths: tuple[float, float],
        *,
        influence: str = "sampled",
        threads: int = 1,
    ):
        self.shape = tuple(shape)
        self.lengths = tuple(lengths)
        self.threads = threads
        self._influence = INFLUENCE[influence]
        self.applications = 0.0
        self._kernels = kernels_for(np.empty(self.shape, dtype=np.float32), threads=threads)
        self._symbols, self._plans = {}, {}
        symbol = self._symbol(np.dtype(np.float32))
        # of the inverse operator, over the half plane: for estimates of rounding, and for a coarse bound
        stiffness = np.divide(1, symbol)
        self.mean_stiffness = float(stiffness.mean(dtype=float))
        self.largest_stiffness = float(stiffness.max())

    def displacement(self, pressure):
        """Return u = G p, shape (ny, nx), mean zero, in the precision of `pressure`."""
        plan = self._load(pressure)
        plan.forward()
        self._kernels.scale(plan.spectrum, self._symbol(pressure.dtype), False)
        return self._finish(plan)

    def pressure(self, displacement):
        """Return p = G^-1 u, shape (ny, nx), mean zero, in the precision of `displacement`."""
        plan = self._load(displacement)
        plan.forward()
        self._kernels.scale(plan.spectrum, self._symbol(displacement.dtype), True)
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
            plan = make_plan(self.shape, dtype, threads=self.threads, share=self._plans.get(_DOUBLE))
            if dtype == _DOUBLE and _SINGLE in self._plans:  # give up its memory and lie in this one's
                self._plans[_SINGLE] = make_plan(self.shape, _SINGLE, threads=self.threads, share=plan)
            self._plans[dtype] = plan
        return self._plans[dtype]

    def _symbol(self, dtype):
        """Return the symbol of G, shape (ny, nx//2 + 1); q = 0 is let through by neither operator."""
        if dtype not in self._symbols:
            spacing = [length / n for length, n in zip(self.lengths, self.shape, strict=True)]
            qy, qx = (q.astype(dtype) for q in wavevectors(self.shape, spacing))
            self._symbols[dtype] = self._influence(qy, qx, spacing)
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
