"""Traces of the instrument in a map: a spectrum that ends early, rounded peaks, repeated heights, noise.

Frequencies are counted in units of the Nyquist frequency of each axis: these traces belong to the pixels.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions, spacing
from roughcontact.arguments.si import as_si
from roughcontact.kernels.waves import wave_power

# exponent of the areal spectrum beyond which it is taken to end: see `statistics.instrument_checks`
MAX_GRADIENT = -7.0
_EDGES = 2.0 ** np.arange(-4, 0.01, 0.25)  # of the bands of frequency, four per octave
_WAVES = 8  # in a band, fewer say little
# bands over which an exponent is taken: less than an octave, so that noise hides little of a fall
_ACROSS = 3
_LOWEST = 0.19  # frequency from which on exponents are judged: below it a small map has few waves in a band
_OCTAVES = (0.25, 0.5, 1.0)  # frequencies of the last two octaves
_SAMPLE = 2**18  # quantiles are estimated from about so many points, medians from so many waves
_TAIL, _SHOULDER = 0.001, 0.01  # quantiles of the curvature: its ends, and where these begin
_TAIL_OVER_SHOULDER = 1.328  # their ratio for a normal distribution
_HALF, _TOP = (0.5, 0.6), (0.85, 1.0)  # frequencies of the highest octave
_SMALLEST = 0.001  # quantile of the steps between neighbours that is a quantum, where there is one
_FEW_STEPS = 0.03  # of the median step between neighbours: steps up to it are counted beside those of zero
_QUANTA = 0.7  # scale of the exponential distribution of steps in units of their median: ln 2
_COARSE = 0.4  # quantum over median step from which on most steps of zero are those of the quantisation
_STEP_TOLERANCE = 1e-6  # of the median step: equal, but for rounding


@as_si
def instrument_traces(height: xr.DataArray) -> dict[str, float]:
    """Return what the waves and curvatures of a periodic map (ny, nx; m) say of the instrument.

    * `spectrum_exponent`: of the steepest fall of the areal power spectrum over less than an octave, and
      `spectrum_end` (m), the wavelength where it falls more steeply than `MAX_GRADIENT`, or is steepest
    * `spectrum_bend`: upper end of the 95 % interval of its change from the last octave but one to the last
    * `rounded_peaks`: how much blunter peaks are than valleys, in powers of two, and `sharpest_peak_radius`
      (m), which 0.1 % of the points fall below
    * `top_exponent`: over the highest octave, again as of an areal spectrum
    * `noise_floor`, `pixel_roughness` (m): rms of white noise with the power of the shortest waves, with the
      second differences of the map

    Empty for a map with too few waves, or without heights.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import self_affine_surface
    >>> waves = {"longest": 1e-4, "rms_height": 1e-7}
    >>> rough = self_affine_surface((128, 128), 1e-6, hurst=0.8, shortest=2e-6, **waves)
    >>> found = instrument_traces(rough)
    >>> f"{found['spectrum_exponent']:.1f}, {found['top_exponent']:.1f}"
    '-3.6, -3.6'
    """
    values, steps = np.asarray(height.values, dtype=float), spacing(height)
    power, ny, nx = wave_power(values), *values.shape
    # 1 for the Nyquist frequency of an axis
    frequency = 2 * np.hypot(np.fft.fftfreq(ny)[:, None], np.fft.rfftfreq(nx))
    mean, median, error = _bands(power, frequency)
    exponents, wavelengths = _exponents(mean, median)
    if exponents.size == 0 or not np.ptp(values):
        return {}
    profile = dimensions(values.shape) == 1
    steep = exponents < MAX_GRADIENT + profile  # areal: a profile's exponent is larger by one
    fall = int(np.argmax(steep) if steep.any() else np.argmin(exponents))
    floor, top = _floor(power, frequency)
    curvatures, seconds = _curvatures(values, steps)
    # of white noise second differences have six times the variance of the heights
    noise = [
        np.mean(second_difference**2) * d**4 / 6
        for second_difference, d in zip(seconds, steps[-len(seconds) :], strict=True)
    ]
    return {
        "spectrum_exponent": float(exponents.min()) - profile,
        # a frequency of 1 is two pixels
        "spectrum_end": float(2 * max(steps) / wavelengths[fall]),
        "spectrum_bend": _bend(mean, median, error),
        "rounded_peaks": float(np.mean([_roundness(curvature) for curvature in curvatures])),
        "sharpest_peak_radius": float(-1 / np.mean([np.quantile(c, _TAIL) for c in curvatures])),
        "top_exponent": top - profile,
        "noise_floor": float(np.sqrt(floor * values.size)),
        "pixel_roughness": float(np.sqrt(min(noise))),
        "pixel_pitch": float(max(steps)),
    }


def repeated_heights(values: np.ndarray) -> float:
    """Return how often neighbours along x have equal heights (ny, nx; NaN missing), over the expected.

    A median filter takes every height from a pixel nearby. About 1 for quantised heights, 0 where no height
    is repeated, for fewer than 1000 steps and for coarsely quantised heights.
    """
    # every n-th row: neighbours along x stay neighbours
    rows = values[:: max(1, values.size // _SAMPLE)]
    with np.errstate(invalid="ignore"):  # between infinite heights, which are missing
        step = np.abs(np.diff(rows, axis=1)).ravel()
    step = step[np.isfinite(step)]
    if step.size < 1000 or not step.any():
        return 0.0
    # steps of rounding are steps of zero
    distinct_steps = step[step > _STEP_TOLERANCE * np.median(step[step > 0])]
    median, quantum = np.median(distinct_steps), np.quantile(distinct_steps, _SMALLEST)
    if quantum > _COARSE * median:
        return 0.0
    # steps of zero are compared with the smallest ones, as of exponentially distributed steps
    few_steps = np.count_nonzero(distinct_steps <= max(_FEW_STEPS * median, 1.5 * quantum))
    expected_share = 0.5 * np.exp(_QUANTA * quantum / median)
    return float((step.size - distinct_steps.size) / few_steps / expected_share)


def _bands(power: np.ndarray, frequency: np.ndarray) -> Iterator[np.ndarray]:
    """Yield mean and median power in each band of frequency, and the relative standard error of the mean.

    All are NaN in bands of too few waves.
    """
    band = np.digitize(frequency, _EDGES).ravel()
    number, waves = _EDGES.size + 1, power.ravel()
    count, total, squares = (
        np.bincount(band, minlength=number, weights=weights) for weights in (None, waves, waves**2)
    )
    stride = max(1, power.size // _SAMPLE)
    sampled_band, values = band[::stride], waves[::stride]
    in_bands = [values[sampled_band == k] for k in range(number)]
    median = np.array([np.median(in_band) if in_band.size else np.nan for in_band in in_bands])
    sufficient = np.where(count >= _WAVES, 1.0, np.nan)
    mean = total / np.maximum(count, 1)  # a band without waves has no mean, and no division by zero
    # a few strong waves, as of a texture, tell little of the others
    error = np.sqrt(squares) / np.where(total > 0, total, np.nan)
    for statistic in (mean, median, error):
        yield (statistic * sufficient)[1:-1]


def _exponents(mean: np.ndarray, median: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the exponents of the spectrum, and the frequencies they belong to.

    A periodic texture has peaks in the mean, and waves that a strong lay leaves empty pull the median down:
    the less steep of the two counts.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        falls = [np.log2(power[_ACROSS:] / power[:-_ACROSS]) / (_ACROSS / 4) for power in (mean, median)]
    # the less steep of mean and median: a few strong waves change the one, a noise floor the other
    exponents = np.fmax(*falls)
    wavelengths = np.sqrt(_EDGES[1 + _ACROSS :] * _EDGES[: -1 - _ACROSS])
    is_valid = (wavelengths >= _LOWEST) & np.isfinite(exponents)
    return exponents[is_valid], wavelengths[is_valid]


def _bend(mean: np.ndarray, median: np.ndarray, error: np.ndarray) -> float:
    """Return by how much the exponent changes in the last octave, plus twice its standard error.

    As in `_exponents` the less steep of mean and median counts. 0 where bands are empty.
    """
    centre = np.sqrt(_EDGES[1:] * _EDGES[:-1])
    previous, last = ((centre > low) & (centre < high) for low, high in pairwise(_OCTAVES))
    frequency = np.log2(centre[last])
    weight = (frequency - frequency.mean()) / frequency.var() / frequency.size  # of a regression line
    with np.errstate(divide="ignore", invalid="ignore"):
        changes = [weight @ np.log2(power[last] / power[previous]) for power in (mean, median)]
    variance = sum(((weight * error[octave] / np.log(2)) ** 2).sum() for octave in (previous, last))
    bend = max(changes) + 2 * np.sqrt(variance)
    return float(bend) if np.isfinite(bend) else 0.0


def _floor(power: np.ndarray, frequency: np.ndarray) -> tuple[float, float]:
    """Return the power of the shortest waves, and the exponent of the spectrum down to them."""
    levels = []
    for low, high in (_HALF, _TOP):
        inside = (frequency >= low) & (frequency <= high)
        if np.count_nonzero(inside) < _WAVES:
            return 0.0, -np.inf
        # the power of white noise is distributed exponentially: its mean is the median over ln 2
        levels.append((np.median(power[inside]) / np.log(2), np.exp(np.mean(np.log(frequency[inside])))))
    (lower, start), (floor, stop) = levels
    if floor == 0 or lower == 0:
        return 0.0, -np.inf
    return float(floor), float(np.log(floor / lower) / np.log(stop / start))


def _curvatures(values: np.ndarray, steps: tuple[float, float]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return curvatures of normal sections and second derivatives along each axis at some points of the map.

    The curvature of a normal section of a sphere is the same at all slopes: a tip of radius R leaves no peak
    with one below -1/R (Villarrubia 1997, J. Res. NIST 102, 425); the second derivative does fall below it.
    """
    # points far apart, whose derivatives are hardly correlated
    places = np.unravel_index(np.arange(0, values.size, max(1, values.size // _SAMPLE)), values.shape)
    slopes, seconds = [], []
    for axis, (pitch, points) in enumerate(zip(steps, values.shape, strict=True)):
        if points > 1:
            behind, sample, ahead = (
                values[*places[:axis], (places[axis] + step) % points, *places[axis + 1 :]]
                for step in (-1, 0, 1)
            )
            slopes.append((ahead - behind) / (2 * pitch))
            seconds.append((behind + ahead - 2 * sample) / pitch**2)
    # the normal is tilted against the z axis
    length = np.sqrt(1 + sum(slope**2 for slope in slopes))
    sections = zip(slopes, seconds, strict=True)
    return [second_difference / (1 + slope**2) / length for slope, second_difference in sections], seconds


def _roundness(curvature: np.ndarray) -> float:
    """Return how much blunter peaks are than valleys, in powers of two.

    The sharpest valleys are compared with the sharpest peaks, and these with less sharp ones. Both ratios
    grow where a tip has bounded the curvature of the peaks: many then have the curvature of the tip.
    """
    peak, shoulder, valley = np.quantile(curvature, (_TAIL, _SHOULDER, 1 - _TAIL))
    if not peak < shoulder < 0 < valley:  # not a shape of which peaks and valleys are the two tails
        return 0.0
    return float(np.log2(valley / -peak) + np.log2(_TAIL_OVER_SHOULDER * shoulder / peak))
