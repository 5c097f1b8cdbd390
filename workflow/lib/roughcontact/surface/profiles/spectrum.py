"""The isotropic spectrum of a surface from profiles of it, by non-negative least squares.

    C(f) = sum_j a_j r_j hat_j(ln f) f_j^3 / f^3,     y_b = sum_j A_bj a_j + error,     a >= 0,

y_b the mean periodogram in a band. A is the way from the surface to y: the integral over all directions that
a line crosses at one frequency (Nayak 1971, J. Lubr. Technol. 93, 398), the removed polynomial, the taper:
what was removed of long waves is put back. Errors are those of chi-square (Lawson and Hanson 1974, Solving
Least Squares Problems, chapter 23), second differences of a are damped by cross-validation (Wahba 1990,
Spline Models for Observational Data, chapter 4).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

_HATS_PER_DECADE = 12
_BANDS_PER_DECADE = 14
_LONGEST = 4.0  # wavelength of the first hat over the length of the profiles: longer waves tilt them
_FREQUENCIES = 24  # of a band, at most, at which the transfer is computed
_DIRECTIONS = 96  # nodes of the integral over the waves that a line crosses
_LINES = 300  # frequencies at which that integral is computed
_DAMPING = 10.0 ** np.arange(-2.0, 4.1)
_FOLDS = 4
_WEIGHTINGS = 8  # passes, each with the variances of the fit before
_NEGLIGIBLE = 1e-3  # of the largest density of slopes: weaker waves change no contact
_REFERENCES, _SMOOTH = 2, 1.5  # fits that give the reference of the next, and its smoothing over the hats
_CORRELATED = 1.94  # neighbouring ordinates of a Hann taper: 1 + 2 (2/3)^2 + 2 (1/6)^2
_HIGHEST = np.sqrt(0.5)  # cycles per point, in the corner of a grid


class Spectrum(NamedTuple):
    """The spectrum of a surface; frequencies in cycles per point of the profiles, heights in m."""

    frequency: np.ndarray  # (hats,)
    density: np.ndarray  # (hats,), m^2 points^2; times frequency^3 it is linear in ln f
    fitted: np.ndarray  # (bands + 2,), periodograms, mean squares of steps and heights

    def at(self, frequency: np.ndarray) -> np.ndarray:
        """Return the density at some frequencies, cycles per point; 0 at 0 and beyond the last node."""
        inside = (frequency > 0) & (frequency <= self.frequency[-1])
        f = np.maximum(frequency, self.frequency[0])
        values = np.interp(np.log(f), np.log(self.frequency), self.density * self.frequency**3)
        return np.where(inside, values / f**3, 0.0)


class ProfileFit:
    """Periodograms of profiles, and the way to them from the spectrum of a surface.

    `directions` are `pieces` (number, points; m) and `pitch` (m) across a lay and along it, where given;
    waves are `stretch` times as long along it. `band` (bands,) are frequencies, `measured` (bands + 2,) mean
    periodograms (m^2 points) and mean squares of steps and heights (m^2), with their degrees of `freedom`.
    """

    def __init__(self, directions: Sequence[tuple[np.ndarray, float]], order: int) -> None:
        """Take levelled profiles, from which polynomials of an order were removed."""
        self.directions, (along, pitch_along) = directions, directions[-1]
        self.pieces, self.pitch = profiles, pitch = directions[0]
        # slopes along a lay are gentler by the ratio of the waves' lengths
        self.stretch = float(np.diff(profiles).std() / np.diff(along).std() * (pitch_along / pitch))
        number, points = profiles.shape
        # the polynomials that levelling has removed, as an orthonormal basis
        self._basis = np.linalg.qr(np.polynomial.legendre.legvander(np.linspace(-1, 1, points), order))[0]
        taper = np.sin(np.pi * (np.arange(points) + 0.5) / points) ** 2
        self._taper = taper / np.sqrt(np.mean(taper**2))
        # with the mean square of the taper: the variance is kept
        power = np.abs(np.fft.rfft(profiles * self._taper, axis=1)) ** 2 / points
        waves = points // 2 + 1
        edges = np.geomspace(1, waves, int(_BANDS_PER_DECADE * np.log10(waves)) + 1)
        edges = np.unique(edges.round().astype(int))
        # the mean and what is below the first edge are left out
        bands = np.split(np.arange(waves), edges)[1:-1]
        size = np.diff(edges)
        self.band = np.sqrt(edges[:-1] * (edges[1:] - 1)) / points
        self.measured = np.array([power[:, band].mean() for band in bands])
        self._fold = np.append(np.arange(size.size) % _FOLDS, [-1, -1])  # mean squares are never left out
        freedom = 2 * number * size
        squares = np.array([np.mean(np.diff(profiles) ** 2), np.mean(profiles**2)])  # of steps and heights
        shares = [size * self.measured * self.band**2, size * self.measured]
        counts = [share.sum() ** 2 / np.sum(share**2 / freedom) for share in shares]
        # a Hann taper correlates neighbouring waves, of which a band has that many fewer
        self.freedom = np.append(freedom / np.minimum(_CORRELATED, 1 + 0.44 * (size - 1)), counts)
        lowest = 1 / (_LONGEST * points)
        nodes = int(_HATS_PER_DECADE * np.log10(_HIGHEST / lowest)) + 2
        self._frequency = np.geomspace(lowest, _HIGHEST, nodes)
        floor = np.maximum(self.measured, 1e-9 * self.measured.max())
        level = np.interp(np.log(self._frequency), np.log(self.band), np.log(floor / self.band))
        kernels = np.array([self._kernel(band, points) for band in bands])
        lines = np.vstack([kernels, self._squares(points)]) @ self._lines(points) * self._frequency**3
        floor = _NEGLIGIBLE * np.max(self.measured * self.band**2) / self.band**2
        self._floor = np.append(floor, _NEGLIGIBLE * squares)
        self.measured = np.append(self.measured, squares)
        # the fit is relative to a smooth reference, since densities range over many powers of ten
        for _ in range(_REFERENCES):
            self._reference = np.exp(scipy.ndimage.gaussian_filter1d(level, _SMOOTH, mode="nearest"))
            self._matrix = lines * self._reference
            density = self._solve(self.measured, 1.0) * self._reference
            weakest = _NEGLIGIBLE * np.max(density * self._frequency**4) / self._frequency**4
            level = np.log(np.maximum(density, weakest))
        # by cross-validation: as smooth as bands that were left out allow
        self._damping = min(_DAMPING, key=self._deviance)
        self.best = self.spectrum(self.measured)

    def spectrum(self, values: np.ndarray) -> Spectrum:
        """Return the spectrum by measured values (bands + 2,), those of the profiles or of others."""
        factors = self._solve(values, self._damping)
        return Spectrum(self._frequency, factors * self._reference, self._matrix @ factors)

    def _lines(self, points: int) -> np.ndarray:
        """Return the density along a line of each hat at the frequencies k/(2 points), (points + 1, hats)."""
        q = np.maximum(np.arange(points + 1), 0.25) / (2 * points)
        nodes = np.geomspace(q[0], q[-1], _LINES)
        t = np.linspace(0, 1, _DIRECTIONS) * np.arcsinh(0.5 / nodes)[:, None]  # across: q sinh t, up to 1/2
        f = nodes[:, None] * np.cosh(t)
        step = np.log(self._frequency[1] / self._frequency[0])
        position = np.maximum(np.log(f / self._frequency[0]) / step, 0.0)
        hats = np.maximum(0.0, 1 - np.abs(position[..., None] - np.arange(self._frequency.size)))
        density = f * np.maximum(f, self._frequency[0]) ** -3.0
        # a profile crosses waves of all directions: the line integral of the isotropic spectrum
        across = 2 * np.trapezoid(density[..., None] * hats, t[..., None], axis=1)
        # times q^2 the integral is flat enough to be interpolated
        smooth = scipy.interpolate.interp1d(np.log(nodes), across * nodes[:, None] ** 2, axis=0)
        return smooth(np.clip(np.log(q), *np.log(nodes[[0, -1]]))) / q[:, None] ** 2

    def _kernel(self, band: np.ndarray, points: int) -> np.ndarray:
        """Return the weights (points + 1,) of the frequencies k/(2 points) in the periodogram of a band."""
        waves = band[np.linspace(0, band.size - 1, min(band.size, _FREQUENCIES)).round().astype(int)]
        sums = self._taper * np.exp(-2j * np.pi / points * waves[:, None] * np.arange(points))
        sums -= (sums @ self._basis) @ self._basis.T  # of the levelled profile
        power = np.mean(np.abs(np.fft.fft(sums, 2 * points)) ** 2, axis=0)
        power[1:points] += power[:points:-1]  # both signs of a frequency
        return power[: points + 1] / (2 * points**2)

    def _squares(self, points: int) -> np.ndarray:
        """Return the weights (2, points + 1) in the mean square of steps, and of levelled heights."""
        weights = np.full(points + 1, 1 / points)
        weights[[0, -1]] /= 2
        steps = 2 - 2 * np.cos(np.pi / points * np.arange(points + 1))
        removal = np.sum(np.abs(np.fft.fft(self._basis.T, 2 * points)) ** 2, axis=0)[: points + 1] / points
        return np.array([weights * steps, weights * (1 - removal)])

    def _solve(self, values: np.ndarray, damping: float, fold: int | None = None) -> np.ndarray:
        """Return the factors a (hats,) of measured values (bands + 2,), perhaps with a fold left out."""
        used = self._fold != fold
        # second differences of the factors: smooth where the profiles say nothing
        smooth = np.sqrt(damping) * np.diff(np.eye(self._frequency.size), 2, axis=0)
        model = values
        for _ in range(_WEIGHTINGS):
            # by the variance that chance gives a band, which goes with its power
            weight = 1 / np.hypot(model / np.sqrt(self.freedom / 2), self._floor)
            rows = np.vstack([(self._matrix * weight[:, None])[used], smooth])
            right = np.concatenate([(values * weight)[used], np.zeros(len(smooth))])
            factors, _ = scipy.optimize.nnls(rows, right)
            # half a step in logarithms: whole ones alternate
            model = np.sqrt(model * np.maximum(self._matrix @ factors, 1e-2 * model))
        return factors

    def _deviance(self, damping: float) -> float:
        """Return how badly bands that are left out are predicted by the others: Whittle's deviance."""
        total = 0.0
        for fold in range(_FOLDS):
            prediction = self._matrix @ self._solve(self.measured, damping, fold=fold)
            ratio = (self.measured + self._floor) / (prediction + self._floor)
            total += np.sum((self.freedom / 2 * (ratio - np.log(ratio)))[self._fold == fold])
        return float(total)
