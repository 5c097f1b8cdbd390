"""Effects of an instrument on a surface: transfer functions and their inverse, tips, measurement noise.

The terms are those of ISO 25178-600:2019: measurement noise N_M, topographic spatial resolution W_R.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import spacing
from roughcontact.arguments.quantities import quantity
from roughcontact.kernels.fourier import halfplane_weights, wavenumbers
from roughcontact.surface.levelling.filters import gaussian_mean_surface
from roughcontact.surface.levelling.record import s_index
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.window.band import LIGHT_WAVELENGTH, removed_by_band

CORRECTED = ("noise", "resolution", "numerical_aperture")  # what a map can be corrected for
MIN_TRANSFER = 0.2  # waves of which less is transmitted are hidden in noise and are not restored further
_SCALES = 2 ** np.arange(7)  # points; distances at which curvatures are compared with a tip
_BINOMIAL = np.array([1, 4, 6, 4, 1]) / 16
_SMOOTHINGS = 5  # twenty change the rms gradient by less than 1 %
_POINTS_PER_BLOCK = 2**16  # few enough to stay in the cache
_STREAM = 25178  # draws of noise: of other random numbers than a map that was made from a small seed


def transfer(frequency: np.ndarray, instrument: Mapping[str, Any]) -> np.ndarray:
    """Return the share (0 to 1) of the amplitude of waves (cycles per m) that an instrument transmits.

    A lens of aperture NA in incoherent light of the wavelength L transmits (2/pi) (acos v - v sqrt(1 - v^2)),
    v = f L/(2 NA) (Goodman 1968, Introduction to Fourier Optics, section 6-3); a stated `resolution` W_R (m)
    is a Gaussian that transmits half at W_R.

    Examples
    --------
    >>> import numpy as np
    >>> lens = {"numerical_aperture": 0.5, "wavelength": 0.5e-6}
    >>> transfer(np.array([0.0, 1e6, 2e6]), lens).round(3).tolist()
    [1.0, 0.391, 0.0]
    >>> transfer(np.array([1e6]), {"resolution": 1e-6}).round(3).tolist()
    [0.5]
    """
    share = np.ones_like(frequency)
    if aperture := instrument.get("numerical_aperture"):
        # beyond the cut-off nothing passes
        v = np.clip(frequency * (instrument.get("wavelength") or LIGHT_WAVELENGTH) / (2 * aperture), 0.0, 1.0)
        share = share * 2 / np.pi * (np.arccos(v) - v * np.sqrt(1 - v**2))
    if resolution := instrument.get("resolution"):
        # half of the amplitude at the resolution, a Gaussian
        share = share * 0.5 ** ((frequency * resolution) ** 2)
    return share


def shortest_transmitted(instrument: Mapping[str, Any]) -> float:
    """Return the shortest wavelength (m) that is transmitted to a fifth or more; 0 where nothing is stated.

    Examples
    --------
    >>> f"{shortest_transmitted({'resolution': 1e-6}):.3g}"
    '6.57e-07'
    """
    scale = instrument.get("resolution") or 0.0
    if aperture := instrument.get("numerical_aperture"):
        # the cut-off of a lens, two apertures per wavelength of its light, is at half of this scale
        scale = max((instrument.get("wavelength") or LIGHT_WAVELENGTH) / aperture, scale)
    if not scale:
        return 0.0
    frequency = np.linspace(0.0, 4 / scale, 4001)
    return float(1 / frequency[np.flatnonzero(transfer(frequency, instrument) >= MIN_TRANSFER)[-1]])


def restored(
    window: xr.DataArray, instrument: Mapping[str, Any], *, noise: float = 0.0, equalise: bool = False
) -> xr.DataArray:
    """Return a periodic map (y, x; m) with its instrument's transfer undone as far as it carries signal.

    Waves are divided by the transfer T, by no less than a fifth, where the power P of their ring is at least
    twice that of the noise (m, rms), the stated one or, where the lens transmits nothing of the shortest
    waves, the measured one. `equalise` multiplies by sqrt((P - N)/P)/T instead (power spectrum equalisation,
    Cannon 1976, IEEE Trans. Acoust. Speech Signal Process. 24, 58).

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 64), 1e-6, amplitude=1e-7, wavelength=8e-6)
    >>> found = restored(wave * 0.5, {"resolution": 8e-6})
    >>> bool(np.allclose(found - found.mean(), wave - wave.mean(), atol=1e-12))
    True
    """
    values = window.values
    q = wavenumbers(values.shape, spacing(window))
    frequency = q / (2 * np.pi)
    share = transfer(frequency, instrument)
    spectrum = np.fft.rfft2(values)
    power, counts = np.abs(spectrum) ** 2, np.broadcast_to(halfplane_weights(values.shape), q.shape)
    floor = of_noise = values.size * (noise * _share_kept(window, q)) ** 2  # at each frequency
    hidden = share < 0.01
    # what is there where nothing can have been transmitted is noise
    if hidden.any():
        floor = np.maximum(floor, float(np.median(np.repeat(power[hidden], counts[hidden].astype(int)))))
    # the mean over waves of about one length tells signal from noise
    rings = np.rint(frequency / frequency.max() * max(values.shape)).astype(int)
    total, waves = (np.bincount(rings.ravel(), weights.ravel()) for weights in (counts * power, counts))
    mean = (total / np.maximum(waves, 1))[rings]
    gain = np.where((mean >= 2 * floor) & ~hidden, 1 / np.maximum(share, MIN_TRANSFER), 1.0)
    if equalise:
        # of a noisy power the share that is signal: Wiener's filter, as an amplitude
        gain *= np.sqrt(np.maximum(1 - np.divide(of_noise, mean, out=np.ones_like(mean), where=mean > 0), 0))
        gain[0, 0] = 1.0  # the mean height
    return window.copy(data=np.fft.irfft2(spectrum * gain, s=values.shape))


def corrected(window: xr.DataArray, instrument: Mapping[str, Any]) -> xr.DataArray:
    """Return a periodic map corrected for stated noise and transfer; `corrected_for` has both in words."""
    causes = []
    for key in CORRECTED:
        if size := instrument.get(key):
            text = f"{size:g}" if key == "numerical_aperture" else quantity(size, "m")
            causes.append(f"{key.replace('_', ' ')} of {text}")
    result = restored(window, instrument, noise=instrument.get("noise") or 0.0, equalise=True)
    return result.assign_attrs(corrected_for=", ".join(causes))


def undone(window: xr.DataArray, instrument: Mapping[str, Any]) -> dict[str, xr.DataArray]:
    """Return maps without the effect of a lens, and of a tip, by that cause; a corrected map has no first.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> list(undone(rough_reference_surface(64), {"resolution": 0.1, "tip_radius": None}))
    ['lens']
    """
    maps = {}
    is_blurred = instrument.get("numerical_aperture") or instrument.get("resolution")
    if is_blurred and "corrected_for" not in window.attrs:
        maps["lens"] = restored(window, instrument, noise=instrument.get("noise") or 0.0)
    if tip_radius := instrument.get("tip_radius"):
        maps["tip"] = eroded(window, tip_radius)
    return maps


def add_noise(window: xr.DataArray, noise: float, *, seed: int = 0) -> xr.DataArray:
    """Return a map plus white noise (m, rms; negative: the opposite draw), filtered as the map was."""
    draw = noise * np.random.default_rng((_STREAM, seed)).standard_normal(window.shape)  # a stream of its own
    share = _share_kept(window, wavenumbers(window.shape, spacing(window)))
    return window.copy(data=window.values + np.fft.irfft2(np.fft.rfft2(draw) * share, s=draw.shape))


def noise_that_remains(window: xr.DataArray, noise: float) -> tuple[float, float]:
    """Return the expected rms height (m) and gradient of white noise (m, rms) once filtered as a map was.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> window = height_map(np.zeros((8, 8)), 1e-6)
    >>> noise_that_remains(window, 1e-9)[0]
    1e-09
    >>> banded = window.assign_attrs(band_reason="window.shortest_wavelength", band_shortest=8e-6)
    >>> noise_that_remains(banded, 1e-9)[0] ** 2 * 64  # the mean, and one wave along either axis, twice
    5e-18
    """
    q = wavenumbers(window.shape, spacing(window))
    power = halfplane_weights(window.shape) * _share_kept(window, q) ** 2 / window.size
    return noise * math.sqrt(power.sum()), noise * math.sqrt((power * q**2).sum())


def share_of_noise(window: xr.DataArray, noise: float) -> float:
    """Return the expected share of white noise (m, rms) in the mean square gradient of a map."""
    gradient = rms_gradient(window)
    return (noise_that_remains(window, noise)[1] / gradient) ** 2 if gradient else math.inf


def _share_kept(window: xr.DataArray, q: np.ndarray) -> np.ndarray:
    """Return the share (0 to 1) of the amplitude of waves (rad/m) that S-filter and band leave in a map."""
    share = np.ones_like(q)
    if s_filter := s_index(window.attrs):  # of one point on a line: what the filter makes of white noise
        along_y, along_x = (
            np.abs(np.fft.fft(gaussian_mean_surface(np.eye(1, n, n // 2), (d, d), s_filter)[0]))
            for n, d in zip(window.shape, spacing(window), strict=True)
        )
        share = along_y[:, None] * along_x[: q.shape[1]]
    return np.where(removed_by_band(q, window.attrs), 0.0, share)


def eroded(window: xr.DataArray, tip_radius: float) -> xr.DataArray:
    """Return the highest surface that a spherical tip could have traced as this periodic map (y, x; m).

    It is the erosion by the tip: exact where the tip touched, else an upper bound (Villarrubia 1997, J. Res.
    Natl. Inst. Stand. Technol. 102, 425).
    """
    values, steps = window.values, spacing(window)
    reach = np.ptp(values)  # no part of the tip above this height touches anything
    radius = math.sqrt(max(2 * tip_radius * reach - reach**2, 0.0)) if reach < tip_radius else tip_radius
    halves = [min(int(radius / step), n // 2) for n, step in zip(values.shape, steps, strict=True)]
    y, x = (np.arange(-k, k + 1) * step for k, step in zip(halves, steps, strict=True))
    above = tip_radius - np.sqrt(np.maximum(tip_radius**2 - y[:, None] ** 2 - x**2, 0.0))
    around, surface = np.pad(values, [(k, k) for k in halves], mode="wrap"), values.copy()
    rows = max(1, _POINTS_PER_BLOCK // values.shape[1])
    for start in range(0, len(values), rows):
        block = surface[start : start + rows]
        neighbourhood = around[start : start + len(block) + 2 * halves[0]]
        # a shift that lowers no point of the block need not be tried
        for i, j in np.argwhere((above < block.max() - neighbourhood.min()) & (above < tip_radius)):
            shifted_block = neighbourhood[i : i + block.shape[0], j : j + block.shape[1]]
            np.minimum(block, shifted_block + above[i, j], out=block)
    return window.copy(data=surface)


def unrounded(window: xr.DataArray, step: float) -> xr.DataArray:
    """Return the smoothest map whose heights lie within half a step (m) of those of a rounded map.

    Smoothing and taking back, in turns, are projections onto convex sets (Youla and Webb 1982, IEEE Trans.
    Med. Imaging 1, 81): terraces become slopes.
    """
    from scipy.ndimage import convolve1d

    # the surface was anywhere within half a step of what was recorded
    low, high = window.values - step / 2, window.values + step / 2
    smooth = window.values
    for _ in range(_SMOOTHINGS):
        for axis in (0, 1):
            smooth = convolve1d(smooth, _BINOMIAL, axis=axis, mode="wrap")
        smooth = np.clip(smooth, low, high)
    return window.copy(data=smooth)


def reliability_length(window: xr.DataArray, tip_radius: float) -> float:
    """Return the wavelength (m) below which a map traced by a tip (m) is not reliable; 0 if all waves are.

    A map counts as shaped by the tip at distances at which its sharpest valley has a curvature of 1/(2R) or
    more (Sanner, Nöhring, Thimons, Jacobs and Pastewka 2022, Appl. Surf. Sci. Adv. 7, 100190); waves are
    twice as long.
    """
    longest = 0.0
    for axis, (points, step) in enumerate(zip(window.shape, spacing(window), strict=True)):
        for scale in _SCALES[points // 4 >= _SCALES]:
            around = sum(np.roll(window.values, shift, axis) for shift in (-scale, scale))
            # a tip of radius R bridges valleys that curve more than 1/R
            if (around - 2 * window.values).max() * 2 * tip_radius >= (scale * step) ** 2:
                longest = max(longest, float(2 * scale * step))
    return longest
