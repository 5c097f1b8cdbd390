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

_BLOCK = 1 << 16  # elements of the symbol that are made at a time: they stay in the cache


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
        spacing = (lengths[0] / shape[0], lengths[1] / shape[1])
        qy, qx = wavevectors(shape, spacing)
        # The real and the imaginary part of a coefficient share a factor: keep q_x^2 twice, so that a
        # spectrum seen as real numbers is multiplied without a detour over complex numbers.
        self._q2 = {
            np.dtype(dtype): ((qy**2).astype(dtype), np.repeat(qx**2, 2, axis=1).astype(dtype))
            for dtype in (np.float32, np.float64)
        }
        self.mean_wavenumber = float(np.hypot(qy, qx).mean())  # over the half plane, for rounding estimates
        self._plans = {}
        self._held_by = {}

    def displacement(self, pressure: np.ndarray, *, dtype=None) -> np.ndarray:
        """Return u = G p, shape (ny, nx), mean zero, in the precision `dtype`, or in that of `pressure`."""
        plan = self._plan(dtype or pressure.dtype)
        self._held_by[plan.field.dtype] = None
        plan.field[...] = pressure
        return self._apply(plan, _comply)

    def pressure(self, displacement: np.ndarray) -> np.ndarray:
        """Return p = G^-1 u, shape (ny, nx), mean zero, in the precision of `displacement`."""
        plan = self._plan(displacement.dtype)
        self._held_by[plan.field.dtype] = None
        plan.field[...] = displacement
        return self._apply(plan, _resist)

    def displacement_of(self, values: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return G of the field that is `values` at the flat indices `points` and zero elsewhere."""
        return self._apply(self._fill(values, points), _comply)

    def pressure_of(self, values: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Return G^-1 of the field that is `values` at the flat indices `points` and zero elsewhere."""
        return self._apply(self._fill(values, points), _resist)

    def _plan(self, dtype):
        dtype = np.dtype(dtype)
        if dtype not in self._plans:
            self._plans[dtype] = make_plan(self.shape, dtype, threads=self.threads)
        return self._plans[dtype]

    def _fill(self, values, points):
        """Put values into the plan's field, zero elsewhere already if the same points were last filled."""
        plan = self._plan(values.dtype)
        if self._held_by.get(plan.field.dtype) is not points:
            plan.field.fill(0)
            self._held_by[plan.field.dtype] = points
        plan.field.ravel()[points] = values
        return plan

    def _apply(self, plan, multiply):
        plan.forward()
        dtype = plan.field.dtype
        parts = plan.spectrum.view(dtype)
        q2_y, q2_x = self._q2[dtype]
        step = max(1, _BLOCK // q2_x.size)
        for start in range(0, self.shape[0], step):
            rows = slice(start, start + step)
            q = np.add(q2_y[rows], q2_x)
            np.sqrt(q, out=q)
            if start == 0:
                q[0, :2] = 1
            multiply(parts[rows], q)
        parts[0, :2] = 0
        plan.inverse()
        self.applications += 1
        return plan.result


def _comply(parts, q):
    """Multiply a block of the spectrum by |q|^-1, times 2."""
    np.divide(2, q, out=q)
    parts *= q


def _resist(parts, q):
    """Multiply a block of the spectrum by |q|/2."""
    q *= 0.5
    parts *= q


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
