"""The periodic elastic half-space: displacement of its surface under a pressure, and the inverse.

A pressure wave p exp(i q x) displaces it by u = 2 p / (E* |q|) exp(i q x) (Johnson 1985, Contact Mechanics,
chapter 13). All is dimensionless, as `roughcontact.contact.problem` scales it: lengths over L, heights over g
L, pressures over E* g.
"""

import math
from functools import cached_property

import numpy as np

from roughcontact.arguments.choices import ZeroFrequency, check_choice
from roughcontact.contact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.errors import SettingsError
from roughcontact.kernels.arrays import (
    DOUBLE,
    SINGLE,
    Array,
    empty,
    get_precision,
    like_array,
    n_elements,
    namespace,
)
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.fft import Plan, make_plan
from roughcontact.kernels.fourier import halfplane_weights, wavevectors

# Displacement at q = 0 of a point force in a square period, in L/E*, with which a single contact has its
# approach in free space: -1/π times the sum of 1/n over the square lattice (Glasser and Zucker 1980)
LATTICE_CONSTANT = 3.900264920001956 / math.pi


class HalfSpace:
    """The operators u = G p, of symbol 2/|q|, and p = G^-1 u, of symbol |q|/2, on one grid (ny, nx).

    Both omit the mean (q = 0): see `zero_frequency_compliance`. The fields are dimensionless, their precision
    that of the argument, on the device of `like`; `lengths` (Ly, Lx) and the thicknesses of layers share a
    unit. `applications` counts pairs of forward and inverse transforms.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        lengths: tuple[float, float],
        elasticity: Elasticity = HALF_SPACE,
        *,
        threads: int = 1,
        like: Array | None = None,
    ):
        self.shape, self.lengths = shape, lengths
        self.threads = threads
        self.applications = 0.0
        # says shape and library, without memory
        self._like = np.broadcast_to(np.float32(0), self.shape) if like is None else like
        self.elasticity = elasticity
        self._kernels = kernels_for(self._like, threads=threads)
        self._symbols: dict[str, tuple[Array, Array]] = {}
        self._plans: dict[str, Plan] = {}

    @cached_property
    def mean_stiffness(self) -> float:
        """The mean of the symbol |q|/2 of G^-1 over the half-plane, for estimates of rounding errors."""
        values, _ = self._symbol(SINGLE)
        return float(namespace(values).mean(1 / values))

    @cached_property
    def largest_stiffness(self) -> float:
        """The largest value of the symbol |q|/2 of G^-1, for a coarse bound."""
        return 1 / self._kernels.extent(self._symbol(SINGLE)[0])[0]

    @cached_property
    def compliances(self) -> tuple[float, float]:
        """The mean and the largest value of the symbol 2/|q| of G over the half-plane without q = 0."""
        (values, _), xp = self._symbol(SINGLE), namespace(self._like)
        # q = 0, which has no operator, counts as nothing
        values = xp.where(xp.isfinite(values), values, xp.zeros_like(values))
        return float(xp.mean(values)), float(xp.max(values))

    def displacement(self, pressure: Array, *, out: Array | None = None) -> Array:
        """Return u = G p with zero mean, in the array `out` if it is given."""
        precision = get_precision(pressure)
        spectrum = self._transform(pressure)
        self._kernels.multiply(spectrum, self._symbol(precision)[0])
        return self.spectrum_to_field(spectrum, precision, out=out)

    def pressure(self, displacement: Array, *, out: Array | None = None) -> Array:
        """Return p = G^-1 u with zero mean, in the array `out` if it is given."""
        spectrum, _ = self.pressure_spectrum(displacement)
        return self.spectrum_to_field(spectrum, get_precision(displacement), out=out)

    def pressure_spectrum(self, displacement: Array) -> tuple[Array, float]:
        """Return the unnormalised spectrum (ny, nx//2 + 1) of p = G^-1 u, and the mean of u p.

        The next application, or the `scratch` array, may overwrite it.
        """
        precision = get_precision(displacement)
        spectrum = self._transform(displacement)
        energy = self._kernels.divide(spectrum, *self._symbol(precision))
        # Parseval: of a transform without a factor
        return spectrum, float(energy) / n_elements(displacement) ** 2

    def spectrum_to_field(self, spectrum: Array, precision: str, *, out: Array | None = None) -> Array:
        """Return the field of a spectrum, which is overwritten: half an application."""
        if out is None:
            out = empty(self._like, precision)
        self._plan(precision).inverse(spectrum, out)
        self.applications += 0.5
        return out

    def scratch(self, precision: str) -> Array:
        """Return a work array (ny, nx) that the next application overwrites."""
        return self._plan(precision).scratch

    def release(self) -> None:
        """Release the memory of symbols and transforms; they are allocated again on demand."""
        self._symbols.clear()
        self._plans.clear()

    def _transform(self, field: Array) -> Array:
        self.applications += 0.5  # half an application: a pair of transforms is one
        return self._plan(get_precision(field)).forward(field)

    def _plan(self, precision: str) -> Plan:
        if precision not in self._plans:
            if precision == DOUBLE:  # the plan in single precision is made anew and shares its memory
                self._plans.pop(SINGLE, None)
            share = self._plans.get(DOUBLE)
            self._plans[precision] = make_plan(self._like, precision, threads=self.threads, share=share)
        return self._plans[precision]

    def _symbol(self, precision: str) -> tuple[Array, Array]:
        """Return the symbol of G, (ny, nx//2 + 1), and the number of waves that each column stands for.

        Both operators suppress q = 0.
        """
        if precision not in self._symbols:
            # of the cell, in the unit of the lengths
            spacing = self.lengths[0] / self.shape[0], self.lengths[1] / self.shape[1]
            qy, qx = (q.astype(precision) for q in wavevectors(self.shape, spacing))
            counts = halfplane_weights(self.shape)[0].astype(precision)
            symbol = self.elasticity.symbol(qy, qx, spacing, self._like)
            self._symbols[precision] = symbol, like_array(counts, self._like)
        return self._symbols[precision]


def zero_frequency_compliance(rule: ZeroFrequency, *, lengths: tuple[float, float]) -> float:
    """Return E* times the mean (q = 0) displacement per mean pressure (m), of a cell (Ly, Lx) in m.

    The approach depends on the rule; pressure and contact area do not. `zero`: relative to the mean.
    `nogi-kato`: the mean of 2/|q| over the zero-frequency cell of the reciprocal lattice (Nogi and Kato 1997,
    ASME J. Tribol. 119, 493). `lattice`: the approach of one localised contact per square period is that of
    an isolated contact.
    """
    check_choice("zero_frequency", rule, ZeroFrequency)
    ly, lx = lengths
    if rule == "zero":
        return 0.0
    if rule == "nogi-kato":
        a, b = math.pi / lx, math.pi / ly
        # 2/|q| integrated over the rectangle of q = 0 in the plane of waves, over its area
        return lx * ly / (4 * math.pi**2) * 8 * (a * math.asinh(b / a) + b * math.asinh(a / b))
    if not math.isclose(lx, ly, rel_tol=1e-6):
        raise SettingsError(
            f"zero_frequency 'lattice' is defined for a square period, this one is {lx:g} m x {ly:g} m; "
            "use 'zero' or 'nogi-kato'",
            keys=["zero_frequency"],
        )
    return LATTICE_CONSTANT * lx
