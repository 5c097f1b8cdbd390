"""The working set of points, and the operators restricted to it."""

import numpy as np

from roughcontact.contact.extension import ELONGATED, Extension
from roughcontact.contact.state import scale_to_load
from roughcontact.halfspace import HalfSpace


class ContactSet:
    """Operators on a set C of grid points; fields on C are vectors, in the order of `points`.

    `certifying` says that <r, precondition(r)> is the norm of the certificate
    (`roughcontact.contact.certificate`); it is not where residuals are extended beyond C.
    """

    def __init__(self, halfspace: HalfSpace, active: np.ndarray):
        self.halfspace = halfspace
        self.active = active
        self.points = np.flatnonzero(active)
        pitches = [length / n for length, n in zip(halfspace.lengths, halfspace.shape, strict=True)]
        elongated = max(pitches) > ELONGATED * min(pitches) and min(halfspace.shape) > 1
        self._extension = Extension(active, halfspace.lengths) if elongated and not active.all() else None
        self._lines = int(np.argmin(pitches)) if elongated else None
        self.certifying = self._extension is None

    def take(self, field: np.ndarray) -> np.ndarray:
        """Return the values of a field (ny, nx) on C."""
        return field.ravel()[self.points]

    def spread(self, values: np.ndarray) -> np.ndarray:
        """Return the field (ny, nx) that is `values` on C and zero elsewhere."""
        field = np.zeros(self.halfspace.shape, dtype=values.dtype)
        field.ravel()[self.points] = values
        return field

    def displacement(self, values: np.ndarray) -> np.ndarray:
        """Return the displacement (ny, nx) of the whole surface under pressures on C."""
        return self.halfspace.displacement_of(values, self.points)

    def precondition(self, values: np.ndarray) -> np.ndarray:
        """Return nearly the pressures on C, of mean zero, that displace C by `values`, of mean zero."""
        if self._extension is None:
            return centred(self.take(self.halfspace.pressure_of(values, self.points)))
        field = self.halfspace.pressure(self._extension.extend(self.spread(values)))
        return centred(self.take(self._extension.transpose(field)))

    def clip(self, pressure: np.ndarray, mean_pressure: float) -> np.ndarray:
        """Return the pressure (ny, nx) without its negative part, scaled to the prescribed mean.

        Where pixels are elongated every line along the finer axis keeps its own load first: lines hardly
        share load, so that a common factor would spoil what the iteration has found.
        """
        positive = np.maximum(pressure, 0)
        if self._lines is not None:
            gained = positive.sum(axis=self._lines, keepdims=True)
            wanted = np.maximum(pressure.sum(axis=self._lines, keepdims=True), 0)
            positive *= np.divide(wanted, gained, out=np.zeros_like(gained), where=gained > 0)
        return scale_to_load(positive, mean_pressure)


def centred(values: np.ndarray) -> np.ndarray:
    """Return `values` less their mean, taken in double precision."""
    return values - values.dtype.type(values.mean(dtype=float))
