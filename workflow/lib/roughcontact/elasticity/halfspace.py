"""The periodic elastic half-space: what a pressure does to its surface.

A pressure wave p exp(i q x) displaces the surface of a half-space by u = 2 p / (E* |q|) exp(i q x)
(Johnson 1985, Contact Mechanics, chapter 13; seed paper eq. 10 with 1/E* = (1 - nu^2)/E). Everything here
is dimensionless: lengths over a length L, heights over g L, pressures over E* g, so that the symbol is
2/|q| with q in units of 1/L. `roughcontact.contact.problem` does the scaling.
"""

import math

import numpy as np

from roughcontact.checking import check_choice
from roughcontact.choices import Influence, ZeroFrequency
from roughcontact.elasticity.influence import INFLUENCE
from roughcontact.errors import SettingsError
from roughcontact.fourier import halfplane_weights, wavevectors
from roughcontact.kernels.arrays import DOUBLE, SINGLE, empty, precision_of
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.fft import make_plan


class HalfSpace:
    """The operators u = G p, with symbol 2/|q|, and its inverse p = G^-1 u, with symbol |q|/2, on one grid.

    `influence` names another symbol (`roughcontact.elasticity.influence`). `like` is an array (ny, nx) of the
    library, and on the device, that the fields will have; NumPy's where none is given.
    The mean (q = 0) is left out of both: it is a matter of reference, see `zero_frequency_compliance`.
    `applications` counts forward and inverse transform pairs.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        lengths: tuple[float, float],
        *,
        influence: Influence = "sampled",
        threads: int = 1,
        like=None,
    ):
        self.shape = tuple(shape)
        self.lengths = tuple(lengths)
        self.threads = threads
        self.applications = 0.0
        self._like = np.broadcast_to(np.float32(0), self.shape) if like is None else like
        self._influence = INFLUENCE[influence]
        self._kernels = kernels_for(self._like, threads=threads)
        self._symbols, self._counts, self._plans = {}, {}, {}
        symbol = self._symbol(SINGLE)
        # of the inverse operator, over the half plane: for estimates of rounding, and for a coarse bound
        xp, stiffness = symbol.__array_namespace__(), 1 / symbol
        self.mean_stiffness = float(xp.mean(stiffness))
        self.largest_stiffness = float(xp.max(stiffness))

    def displacement(self, pressure, *, out=None):
        """Return u = G p, shape (ny, nx), mean zero, in the precision of `pressure`, in the array `out`."""
        precision = precision_of(pressure)
        spectrum = self._transform(pressure)
        self._kernels.multiply(spectrum, self._symbol(precision))
        return self.field_of(spectrum, precision, out=out)

    def pressure(self, displacement, *, out=None):
        """Return p = G^-1 u, shape (ny, nx), mean zero, in the precision of `displacement`, in `out`."""
        spectrum, _ = self.pressure_spectrum(displacement)
        return self.field_of(spectrum, precision_of(displacement), out=out)

    def pressure_spectrum(self, displacement) -> tuple:
        """Return the spectrum of p = G^-1 u and the mean of u p: half an application.

        The next application, and who writes into the `scratch` array, may overwrite the spectrum.
        """
        precision = precision_of(displacement)
        spectrum = self._transform(displacement)
        energy = self._kernels.divide(spectrum, self._symbol(precision), self._counts_in(precision))
        return spectrum, float(energy) / displacement.size**2

    def field_of(self, spectrum, precision: str, *, out=None):
        """Return the field of a `spectrum`, which is lost, in the array `out`: half an application."""
        if out is None:
            out = empty(self._like, precision)
        self._plan(precision).inverse(spectrum, out)
        self.applications += 0.5
        return out

    def scratch(self, precision: str):
        """Return an array (ny, nx) in `precision` that the next application overwrites."""
        return self._plan(precision).scratch

    def _transform(self, field):
        self.applications += 0.5
        return self._plan(precision_of(field)).forward(field)

    def _plan(self, precision):
        if precision not in self._plans:
            if precision == DOUBLE:  # that in single precision, made anew, will lie in its memory
                self._plans.pop(SINGLE, None)
            share = self._plans.get(DOUBLE)
            self._plans[precision] = make_plan(self._like, precision, threads=self.threads, share=share)
        return self._plans[precision]

    def _symbol(self, precision):
        """Return the symbol of G, shape (ny, nx//2 + 1); q = 0 is let through by neither operator."""
        if precision not in self._symbols:
            spacing = [length / n for length, n in zip(self.lengths, self.shape, strict=True)]
            qy, qx = (q.astype(precision) for q in wavevectors(self.shape, spacing))
            symbol = self._influence(qy, qx, spacing)
            self._symbols[precision] = self._like.__array_namespace__().asarray(symbol)
        return self._symbols[precision]

    def _counts_in(self, precision):
        """Return how many waves of the full plane each column of a spectrum stands for."""
        if precision not in self._counts:
            counts = halfplane_weights(self.shape)[0].astype(precision)
            self._counts[precision] = self._like.__array_namespace__().asarray(counts)
        return self._counts[precision]


def zero_frequency_compliance(rule: ZeroFrequency, *, lengths: tuple[float, float]) -> float:
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
    check_choice("zero_frequency", rule, ZeroFrequency)
    ly, lx = lengths
    if rule == "zero":
        return 0.0
    if rule == "nogi-kato":
        a, b = math.pi / lx, math.pi / ly
        return lx * ly / (4 * math.pi**2) * 8 * (a * math.asinh(b / a) + b * math.asinh(a / b))
    if not math.isclose(lx, ly, rel_tol=1e-6):
        raise SettingsError(
            f"zero_frequency 'lattice' holds for a square period, this one is {lx:g} m x {ly:g} m; "
            "use 'zero' or 'nogi-kato'",
            keys=["zero_frequency"],
        )
    return 3.900265 / math.pi * lx
