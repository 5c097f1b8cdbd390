"""What profiles tell of a surface: its spectrum, and the distributions of heights and slopes.

Surfaces are drawn with both in turns (Schreiber and Schmitz 1996, Phys. Rev. Lett. 77, 635); their slopes
have the distribution of those of the profiles at the same height: plateaus are flat, flanks of pits steep.
"""

from typing import NamedTuple

import numpy as np
import scipy

from roughcontact.errors import SettingsError
from roughcontact.kernels.fourier import halfplane_weights, sums_of_products
from roughcontact.surface.profiles.spectrum import ProfileFit, Spectrum
from roughcontact.surface.roughness.texture import DECAY

_TURNS = 6
_CLASSES = 6  # of height, equally frequent, in which slopes have a distribution of their own
_SCORES = np.linspace(-5.2, 5.2, 257)  # normal scores at which the distribution of heights is stored
_SLOPE_RANKS = (np.arange(400) + 0.5) / 400
_TAIL = 0.5  # of an independent height: beyond this expected number a quantile is extrapolated
# n times the mean square deviation of n normal heights from their quantiles: one sample in twenty
_CHANCE = 3.0
_BLOCKS = 5  # of each profile, which are drawn anew for the scatter


class Finish(NamedTuple):
    """A spectrum, and heights and slopes over their standard deviation."""

    spectrum: Spectrum
    heights: np.ndarray  # (scores,), at `_SCORES`
    slopes: np.ndarray  # (classes of height, lowest first; ranks), of neighbouring points
    stretch: float  # how many times as long waves are along y


def fit_statistics(fit: ProfileFit, rng: np.random.Generator | None = None) -> Finish:
    """Return what levelled profiles tell, or what others of the same surface might, by pieces drawn anew.

    Then the spectrum scatters as that of a Gaussian surface does, and with the mean square slope of the
    pieces, the stretch with those of both directions.
    """
    spectrum, stretch, (across, *along) = fit.best, fit.stretch, [pieces for pieces, _ in fit.directions]
    # heights within a correlation length say the same
    independent = across.size / (2 * correlation_length(across))  # one height in two correlation lengths
    if rng is not None:
        across, change = _redrawn(across, rng)
        # by chance the power of a band is a chi-square with its degrees of freedom
        chance = rng.gamma(fit.freedom / 2) / (fit.freedom / 2)
        spectrum = fit.spectrum(spectrum.fitted * chance * change)
        for pieces in along:
            stretch *= np.sqrt(change / _redrawn(pieces, rng)[1])
    return Finish(spectrum, _heights(across, independent), _slopes(across), stretch)


def _redrawn(profiles: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """Return pieces (number, points; m) drawn with replacement, their mean square slope over that of all."""
    # in blocks, within which the waves stay as they are
    length = profiles.shape[1] // _BLOCKS
    blocks = profiles[:, : length * _BLOCKS].reshape(-1, length)
    sample = blocks[rng.integers(len(blocks), size=len(blocks))]
    return sample, np.mean(np.diff(sample) ** 2) / np.mean(np.diff(blocks) ** 2)


def correlation_length(profiles: np.ndarray) -> int:
    """Return the number of points within which the correlation of profiles (number, points) falls to 0.2."""
    correlation = sums_of_products(profiles)
    # beyond the last shift where it never falls so far
    return int(np.argmax(np.append(correlation < DECAY * correlation[0], True)))


def draw(finish: Finish, points: int, ratio: float, rng: np.random.Generator) -> np.ndarray:
    """Return the heights (points, points; m) of a periodic surface of `ratio` times the profiles' pitch."""
    shape, full, stretch = (points, points), points**2, finish.stretch
    fx, fy = np.fft.rfftfreq(points), np.fft.fftfreq(points)[:, None]
    # stretched along y, with the same variance
    amplitude = full * np.sqrt(stretch * finish.spectrum.at(np.hypot(fx, fy * stretch) / ratio))
    amplitude /= points * ratio
    weights = halfplane_weights(shape) * (amplitude / full) ** 2
    if (rms := np.sqrt(weights.sum())) == 0:
        raise SettingsError(
            f"points = {points}: at this spacing the surface has none of the waves of the profiles; give "
            "more points, or a spacing near that of the profiles",
            keys=["points", "spacing"],
        )
    # from one point to the next, along x and along y
    steps = np.array(np.broadcast_arrays(*(np.exp(2j * np.pi * f) - 1 for f in (fx, fy))))
    powers = np.abs(steps) ** 2
    slopes = np.sqrt(np.sum(weights * powers, axis=(1, 2)))
    square = np.maximum(powers.sum(axis=0), 1e-300)  # the mean has no step
    ranks = (np.arange(full) + 0.5) / full
    heights = np.interp(scipy.special.ndtri(ranks), _SCORES, finish.heights)
    # the rms height is that of the waves which fit into the surface
    heights = (heights - heights.mean()) * (rms / heights.std())
    edges = heights[np.arange(1, _CLASSES) * full // _CLASSES]

    def with_amplitudes(waves: np.ndarray) -> np.ndarray:
        return waves * (amplitude / np.maximum(np.abs(waves), 1e-300))

    # amplitudes and ranks cannot both be met at once: in turns
    waves = with_amplitudes(np.fft.rfft2(rng.standard_normal(shape)))
    for _ in range(_TURNS):
        candidate = _impose_ranks(np.fft.irfft2(waves, s=shape), heights)
        waves = with_amplitudes(np.fft.rfft2(candidate))
        group = np.digitize(np.fft.irfft2(waves, s=shape), edges)
        rises = np.fft.irfft2(waves * steps, s=shape)
        for rise, slope in zip(rises, slopes, strict=True):
            for number, quantiles in enumerate(finish.slopes):
                inside = group == number
                rise[inside] = _impose_ranks(rise[inside], slope * quantiles)
        # the field whose steps are nearest to both: a Poisson equation, wave by wave
        cross_spectrum = np.sum(np.fft.rfft2(rises) * steps.conj(), axis=0)
        waves = with_amplitudes(cross_spectrum / square)
    return np.fft.irfft2(waves, s=shape)


def _impose_ranks(values: np.ndarray, quantiles: np.ndarray) -> np.ndarray:
    """Return values of which each has the quantile of its rank."""
    ranks = (np.arange(values.size) + 0.5) / values.size * quantiles.size - 0.5
    result = np.empty(values.size)
    result[np.argsort(values, axis=None)] = np.interp(ranks, np.arange(quantiles.size), quantiles)
    return result.reshape(values.shape)


def _heights(profiles: np.ndarray, independent: float) -> np.ndarray:
    """Return the quantiles of heights at `_SCORES`, extrapolated linearly beyond those that a sample shows.

    The deviation from a normal distribution counts where it is larger than chance gives: nearly all of it
    where its mean square is twice as large.
    """
    values = np.sort(profiles, axis=None)
    scores = scipy.special.ndtri((np.arange(values.size) + 0.5) / values.size)
    deviation = (values - values.mean()) / values.std() - scores
    # a small sample deviates from a normal distribution by chance: that share is left out
    share = max(0.0, 1 - (_CHANCE / (independent * np.mean(deviation**2))) ** 4)
    quantiles = _SCORES + np.interp(_SCORES, scores, share * deviation)
    # quantiles of fewer than half a height are not seen
    limit = -scipy.special.ndtri(min(0.2, _TAIL / independent))
    for side in (-1, 1):
        u = side * _SCORES
        tail = np.flatnonzero((u <= limit) & (u > limit - 1))
        slope = max(np.polyfit(_SCORES[tail], quantiles[tail], 1)[0], 0.0)
        edge = tail[-1 if side > 0 else 0]
        quantiles[u > limit] = quantiles[edge] + slope * (_SCORES[u > limit] - _SCORES[edge])
    return np.maximum.accumulate(quantiles)  # a quantile never falls


def _slopes(profiles: np.ndarray) -> np.ndarray:
    """Return the quantiles (classes, ranks) of the steps between neighbours, alike in both directions."""
    steps = np.diff(profiles).ravel()
    order = np.argsort((profiles[:, 1:] + profiles[:, :-1]).ravel(), kind="stable")
    groups = np.array_split(steps[order], _CLASSES)
    # in both directions: a profile may be read backwards
    quantiles = [np.quantile(np.concatenate([group, -group]), _SLOPE_RANKS) for group in groups]
    return np.array(quantiles) / steps.std()
