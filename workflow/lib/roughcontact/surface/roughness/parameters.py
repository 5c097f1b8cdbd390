"""Roughness parameters of a periodic height map.

Slopes and curvatures are spectral (Parseval), consistent with the half-space of the solver: in full contact
the standard deviation of the pressure is exactly E* g / 2 with the rms gradient g below. For a map that is
not periodic the step at its seam counts as roughness; use its periodic window instead.
"""

import math

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import dimensions, spacing
from roughcontact.arguments.si import as_si
from roughcontact.kernels import fourier
from roughcontact.kernels.waves import each_wave, spectral_gradient, wave_power

# At most this share of the mean square gradient lies beyond the cut-off of a spectrum, ...
_SHARE_BEYOND_CUTOFF = 1e-2
# ... which is extended until the gradient per wavenumber drops to this share of its previous mean.
_EDGE_DROP = 0.1


@as_si
def rms_height(height: xr.DataArray) -> float:
    """Return the root mean square height, sqrt(mean (h - mean h)^2): Sq of ISO 25178-2.

    Parameters
    ----------
    height : DataArray (y, x), m

    Returns
    -------
    float, m

    Examples
    --------
    >>> from roughcontact.arguments.maps import height_map
    >>> rms_height(height_map([[1.0, 3.0], [3.0, 1.0]], 1.0))
    1.0
    """
    return float(np.std(_from_the_first(height)))


@as_si
def rms_gradient(height: xr.DataArray, *, threads: int = 1) -> float:
    """Return the root mean square gradient g = sqrt(sum |q|^2 |h(q)|^2), spectral.

    Waves at the Nyquist limit count with their |q|, as in the half-space.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.
    threads : int
        for the transform.

    Returns
    -------
    float, dimensionless

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 64), 2 * math.pi / 64, amplitude=1.0, wavelength=2 * math.pi)
    >>> round(rms_gradient(wave) ** 2, 6)
    0.5
    """
    heights = np.require(height.values, dtype=float, requirements=["C", "A", "W"])
    return spectral_gradient(heights, spacing(height), threads=threads)


@as_si
def interior_rms_gradient(height: xr.DataArray) -> float:
    """Return the root mean square gradient of a map that is not periodic, spectral.

    It is that of the map continued by its mirror images, without a step: along each axis the sum of
    (pi k / (n d))^2 |c_k|^2 over the cosine series c of the lines. The interior counts as in `rms_gradient`,
    a step from one edge to the other does not.

    Parameters
    ----------
    height : DataArray (y, x), m
        without missing points.

    Returns
    -------
    float, dimensionless

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> tilted = height_map(0.1 * np.arange(200.0)[None, :], 1.0)
    >>> round(interior_rms_gradient(tilted), 2), round(rms_gradient(tilted), 2)
    (0.1, 1.66)
    """
    from scipy.fft import dct

    values, total = _from_the_first(height), 0.0
    for axis, (points, pitch) in enumerate(zip(values.shape, spacing(height), strict=True)):
        series = dct(values, norm="ortho", axis=axis)
        q = np.pi / (points * pitch) * np.arange(points)
        total += float(np.square(series, out=series).sum(axis=1 - axis) @ q**2) / values.size
    return math.sqrt(total)


@as_si
def steepest_share(height: xr.DataArray, *, share: float = 0.01) -> float:
    """Return the contribution of the steepest points to the mean square gradient of a periodic map.

    The gradient is computed from the steps to the next points along x and y. For isotropic, normally
    distributed slopes the steepest 1 % of the points contribute 0.01 (1 - ln 0.01) = 5.6 %.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.
    share : float, 0 to 1
        of the points; at least one point counts.

    Returns
    -------
    float, 0 to 1
        0 for a flat map.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> step = height_map(np.repeat([[0.0, 1.0]], 50, axis=1), 1.0)  # up in the middle, down at the seam
    >>> steepest_share(step, share=0.01), steepest_share(step, share=0.02)
    (0.5, 1.0)
    """
    squares = np.zeros(height.shape)
    for axis, pitch in enumerate(spacing(height)):
        steps = np.roll(np.asarray(height.values, dtype=float), -1, axis)
        steps -= height.values
        steps /= pitch
        squares += np.square(steps, out=steps)
    del steps  # memory may not hold more than is needed of a large map
    total = squares.sum()
    if total == 0:
        return 0.0
    count = max(1, round(share * squares.size))
    steepest = squares.ravel()
    steepest.partition(-count)  # a partial sort: the count highest, in any order
    return float(steepest[-count:].sum() / total)


@as_si
def rms_curvature(height: xr.DataArray) -> float:
    """Return the root mean square of the mean curvature (h_xx + h_yy) / 2, spectral.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.

    Returns
    -------
    float, 1/m

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 64), 2 * math.pi / 64, amplitude=1.0, wavelength=2 * math.pi)
    >>> round(rms_curvature(wave) ** 2, 6)  # of -cos(x) / 2
    0.125
    """
    return math.sqrt(_moments(height, wave_power(height.values))[2]) / 2


@as_si
def spectral_moments(height: xr.DataArray) -> tuple[float, float, float]:
    """Return Nayak's moments: variances of height, slope and curvature of profiles [1]_, [2]_.

    m0 = sum |h(q)|^2, m2 = sum |q|^2 |h(q)|^2 / 2, m4 = 3/8 sum |q|^4 |h(q)|^2. They are averaged over
    profiles in all directions (mean cos^2 = 1/2, mean cos^4 = 3/8); for an isotropic surface all directions
    are equal. The moments of a profile are its own, without these factors.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.

    Returns
    -------
    m0 : float, m^2
    m2 : float, dimensionless
    m4 : float, m^-2

    References
    ----------
    .. [1] Longuet-Higgins, M. S. (1957), Phil. Trans. R. Soc. A 249, 321.
    .. [2] Nayak, P. R. (1971), J. Lubr. Technol. 93, 398.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 64), 2 * math.pi / 64, amplitude=1.0, wavelength=2 * math.pi)
    >>> [round(moment, 6) for moment in spectral_moments(wave)]
    [0.5, 0.5, 0.5]
    """
    return _profile_moments(height, _moments(height, wave_power(height.values)))


@as_si
def shortest_wavelength(height: xr.DataArray) -> float:
    """Return the shortest wavelength of the map, from the cut-off of its spectrum.

    It is 2 pi / q_s. Waves with |q| > q_s contribute at most 1 % of the mean square gradient; from there q_s
    is increased up to the edge of the spectrum, where the gradient per wavenumber falls below a tenth of its
    mean over the preceding third of an octave. For a surface with a sharp cut-off this is the cut-off, also
    after cutting out and periodisation; for a measured map whose spectrum reaches the Nyquist limit it is
    two pixels.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.

    Returns
    -------
    float, m
        NaN for a flat map.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import self_affine_surface
    >>> height = self_affine_surface((128, 128), 0.5, hurst=0.8, shortest=4.0, longest=32.0, rms_height=1.0)
    >>> round(shortest_wavelength(height), 6)
    4.0
    """
    return _cutoff_wavelength(height, wave_power(height.values), spacing(height))


@as_si
def roughness_parameters(height: xr.DataArray, power: np.ndarray | None = None) -> dict[str, float]:
    """Return the roughness parameters of a periodic map for its statistics.

    Nayak's bandwidth parameter m0 m4 / m2^2 (`spectral_moments`) is least for a single wavelength, 1.5 for an
    isotropic surface and 1 for a profile. The points per shortest wavelength are those in the direction with
    the poorest sampling (`shortest_wavelength`, with lengths in pixels along each axis). Both are NaN for a
    flat map.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.
    power : array (ny, nx // 2 + 1), m^2, optional
        from `roughcontact.kernels.waves.wave_power`; computed where it is not given.

    Returns
    -------
    dict of float
        `rms_height` (m), `rms_gradient`, `rms_curvature` (1/m), `nayak_parameter` and
        `points_per_shortest_wavelength`.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> found = roughness_parameters(westergaard_surface((1, 64), 1.0, amplitude=1.0, wavelength=16.0))
    >>> round(found["rms_height"], 6), round(found["points_per_shortest_wavelength"], 6)
    (0.707107, 16.0)
    """
    power = wave_power(height.values) if power is None else power
    moments = _moments(height, power)
    m0, m2, m4 = _profile_moments(height, moments)
    return {
        "rms_height": rms_height(height),
        "rms_gradient": math.sqrt(moments[1]),
        "rms_curvature": math.sqrt(moments[2]) / 2,
        # in this order, so that no product leaves the range of doubles
        "nayak_parameter": m0 / m2 * (m4 / m2) if m2 > 0 else math.nan,
        "points_per_shortest_wavelength": _cutoff_wavelength(height, power, (1.0, 1.0)),
    }


def _from_the_first(height: xr.DataArray) -> np.ndarray:
    """Return heights less the first, exactly zero for a flat map, in double: small integers would wrap."""
    return np.subtract(height.values, height.values.flat[0], dtype=float)


def _moments(height: xr.DataArray, power: np.ndarray) -> tuple[float, float, float]:
    """Return sum |q|^(2k) |h(q)|^2 for k = 0, 1, 2."""
    m0, gradient, laplacian = 0.0, 0.0, 0.0
    for q2, weight in each_wave(power, height.shape, spacing(height)):
        slope = q2 * weight
        m0 += float(weight.sum())
        gradient += float(slope.sum())
        laplacian += float((q2 * slope).sum())
    return m0, gradient, laplacian


def _profile_moments(height: xr.DataArray, moments: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the moments of profiles from those of the surface."""
    m0, gradient, laplacian = moments
    # of an isotropic surface: the mean of cos^2 is 1/2, that of cos^4 is 3/8
    return moments if dimensions(height.shape) == 1 else (m0, gradient / 2, laplacian * 3 / 8)


def _cutoff_wavelength(height: xr.DataArray, power: np.ndarray, unit: tuple[float, float]) -> float:
    """Return the shortest wavelength in a system of lengths in which the pitch is `unit` = (dy, dx)."""
    # shells as wide as the fundamental, centred on its multiples, so that a cut-off at a whole number of
    # waves is reproduced exactly
    fundamental = 2 * np.pi / max(n * d for n, d in zip(height.shape, unit, strict=True))
    qy, qx = fourier.wavevectors(height.shape, unit)
    last = int(np.rint(np.sqrt((qy**2).max() + qx[0, -1] ** 2) / fundamental))
    share = np.zeros(last + 1)
    systems = (each_wave(power, height.shape, steps) for steps in (spacing(height), unit))
    for (square, weight), (squared_in_unit, _) in zip(*systems, strict=True):
        # the boundary between two shells belongs to the lower one, whatever the rounding
        shell = np.ceil(np.sqrt(squared_in_unit) / fundamental - (0.5 + 1e-9)).astype(int)
        share += np.bincount(shell.ravel(), weights=(square * weight).ravel(), minlength=last + 1)
    total = share.sum()
    if not total > 0:
        return math.nan
    share /= total
    remaining = np.cumsum(share[::-1])[::-1]
    edge = int(np.nonzero(remaining > _SHARE_BEYOND_CUTOFF)[0][-1])
    # over a third of an octave below the edge, the mean of a band as acoustics has it
    level_below_edge = share[int(np.ceil(edge / 2 ** (1 / 3))) : edge + 1].mean()
    while edge + 1 < share.size and share[edge + 1] > _EDGE_DROP * level_below_edge:
        edge += 1
    return float(max(2 * np.pi / (fundamental * edge), 2 * min(unit)))
