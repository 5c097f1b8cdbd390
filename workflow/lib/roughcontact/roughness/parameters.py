"""Roughness parameters of a periodic height map.

Slopes and curvatures are spectral (Parseval), the same as the solver's half-space sees: in full contact the
standard deviation of the pressure is E* g / 2 with the rms gradient g below, exactly. A map that is not
periodic gets the step at its seam counted as roughness; use its periodic window instead.
"""

import math

import numpy as np
import xarray as xr

from roughcontact import fourier
from roughcontact.kernels.arrays import DOUBLE, empty
from roughcontact.kernels.choose import kernels_for
from roughcontact.kernels.fft import make_plan
from roughcontact.maps import spacing

# The cut-off of a spectrum: beyond it lies at most this share of the mean square gradient ...
_SHARE_BEYOND_CUTOFF = 1e-2
# ... and it ends where the gradient per wavenumber falls below this share of that just before.
_CLIFF = 0.1


def rms_height(height: xr.DataArray) -> float:
    """Root mean square height, sqrt(mean (h - mean h)^2), in m (Sq of ISO 25178-2)."""
    return float(np.std(_from_first_point(height.values)))


def height_parameters(height: xr.DataArray) -> dict[str, float]:
    """Return the height parameters of ISO 25178-2, and Sdq, of a levelled map that need not be periodic.

    With z the height above the mean of all measured points:

    * `Sa` = mean |z|, `Sq` = sqrt(mean z^2), m
    * `Ssk` = mean z^3 / Sq^3, `Sku` = mean z^4 / Sq^4; NaN for a flat map
    * `Sp` = max z, `Sv` = -min z, `Sz` = Sp + Sv, m
    * `Sdq` = sqrt(mean (dz/dx)^2 + mean (dz/dy)^2) with the differences of neighbouring points, each
      direction averaged over its own pairs of measured points. It depends on the pitch (`rms_gradient` is
      spectral).

    Parameters
    ----------
    height : DataArray (y, x), m
        NaN where missing; such points do not count.

    Notes
    -----
    ISO 25178-2:2021, 4.1 and 4.2.
    """
    values = height.values
    z = values[~np.isnan(values)]
    z = z - z[0]  # exactly zero for a flat map, wherever it lies
    z -= z.mean()
    sq = math.sqrt(np.mean(z**2))
    slopes = 0.0
    for axis, pitch in enumerate(spacing(height)):
        steps = np.diff(values, axis=axis)
        steps = steps[~np.isnan(steps)]
        if steps.size:
            slopes += float(np.mean((steps / pitch) ** 2))
    return {
        "Sa": float(np.mean(np.abs(z))),
        "Sq": sq,
        "Ssk": float(np.mean((z / sq) ** 3)) if sq > 0 else math.nan,
        "Sku": float(np.mean((z / sq) ** 4)) if sq > 0 else math.nan,
        "Sp": float(z.max()),
        "Sv": float(-z.min()),
        "Sz": float(np.ptp(z)),
        "Sdq": math.sqrt(slopes),
    }


def rms_gradient(height: xr.DataArray, *, threads: int = 1) -> float:
    """Root mean square gradient g = sqrt(sum |q|^2 |h(q)|^2), spectral, dimensionless.

    The waves at the Nyquist limit count with their |q|, as they do in the half-space.
    """
    given = np.require(height.values, dtype=float, requirements=["C", "A", "W"])
    values, kernels = empty(given, DOUBLE), kernels_for(given, threads=threads)
    kernels.make_dimensionless(given, given.flat[0], 1.0, values)  # a flat map is then exactly zero
    spectrum = make_plan(values, DOUBLE, threads=threads).forward(values)
    weights = fourier.halfplane_weights(height.shape)[0]
    qy, qx = fourier.wavevectors(height.shape, spacing(height))
    return math.sqrt(kernels.slope_power(spectrum, weights, qy[:, 0] ** 2, qx[0] ** 2)) / height.size


def interior_rms_gradient(height: xr.DataArray) -> float:
    """Root mean square gradient of a map that is not periodic, spectral, dimensionless.

    That of the map and its mirror images, which meet without a step: along each axis the sum of
    (pi k / (n d))^2 |c_k|^2 over the cosine series c of the lines. What happens inside counts as in
    `rms_gradient`, a step from one edge to the other does not.
    """
    values = _from_first_point(height.values)
    total = 0.0
    for axis, pitch in enumerate(spacing(height)):
        lines = np.moveaxis(values, axis, -1)
        mirrored = np.concatenate([lines, lines[..., ::-1]], axis=-1)
        power = np.abs(np.fft.rfft(mirrored)) ** 2 * fourier.halfplane_weights(mirrored.shape)
        q = 2 * np.pi * np.fft.rfftfreq(mirrored.shape[-1], pitch)
        total += float((power @ q**2).mean()) / mirrored.shape[-1] ** 2
    return math.sqrt(total)


def steepest_share(height: xr.DataArray, *, share: float = 0.01) -> float:
    """Return how much of the mean square gradient of a periodic map its steepest points make up, 0 to 1.

    The gradient is that of the steps to the next point along x and y. Of a map with normally distributed
    slopes, alike in all directions, the steepest 1 % of the points make up 0.01 (1 - ln 0.01) = 5.6 %.

    Parameters
    ----------
    height : DataArray (y, x), m
    share : float
        of the points; at least one point is taken.
    """
    squares = np.zeros(height.shape)
    for axis, pitch in enumerate(spacing(height)):
        squares += ((np.roll(height.values, -1, axis) - height.values) / pitch) ** 2
    total = squares.sum()
    if total == 0:
        return 0.0
    count = max(1, round(share * squares.size))
    return float(np.partition(squares, -count, axis=None)[-count:].sum() / total)


def rms_curvature(height: xr.DataArray) -> float:
    """Root mean square of the mean curvature (h_xx + h_yy) / 2, spectral, in 1/m."""
    return math.sqrt(_moments(height, _power(height.values))[2]) / 2


def spectral_moments(height: xr.DataArray) -> tuple[float, float, float]:
    """Return Nayak's moments (m0, m2, m4): variances of height, slope and curvature of profiles.

    In m^2, 1 and m^-2: m0 = sum |h(q)|^2, m2 = sum |q|^2 |h(q)|^2 / 2, m4 = 3/8 sum |q|^4 |h(q)|^2. They are
    the mean over profiles in all directions (mean cos^2 = 1/2, mean cos^4 = 3/8), for an isotropic surface
    the same in each. For a profile they are its own: no factors.

    Notes
    -----
    Longuet-Higgins, Phil. Trans. R. Soc. A 249 (1957) 321; Nayak, J. Lubr. Technol. 93 (1971) 398.
    """
    return _of_profiles(height, *_moments(height, _power(height.values)))


def nayak_parameter(height: xr.DataArray) -> float:
    """Nayak's bandwidth parameter m0 m4 / m2^2, dimensionless; NaN for a flat map.

    1.5 is the least for an isotropic surface (a single wavelength), 1 for a profile; the wider the band the
    larger (Nayak, J. Lubr. Technol. 93 (1971) 398).
    """
    return _bandwidth(*spectral_moments(height))


def shortest_wavelength(height: xr.DataArray) -> float:
    """Shortest wavelength that the map holds, in m; NaN for a flat map.

    2 pi / q_s, where the waves with |q| > q_s carry at most 1 % of the mean square gradient; from there q_s
    goes on up to the edge of the spectrum, where the gradient per wavenumber falls below a tenth of its mean
    over the third of an octave before. For a surface with a sharp cut-off that is the cut-off, also after
    it was cut out and made periodic; for a measured map whose spectrum reaches the Nyquist limit it is two
    pixels.
    """
    return _cutoff_wavelength(height, _power(height.values), spacing(height))


def points_per_shortest_wavelength(height: xr.DataArray) -> float:
    """Points that sample the shortest wave that the map holds; at least 2; NaN for a flat map.

    The wavelength of `shortest_wavelength`, taken in pixels along each axis, so that it counts the points in
    the direction that samples the map worst where the pixels are not square.
    """
    return _cutoff_wavelength(height, _power(height.values), (1.0, 1.0))


def summit_statistics(height: xr.DataArray) -> dict[str, float]:
    """Summits of the map, as the model of Greenwood and Williamson takes them.

    A summit is a point higher than its eight neighbours, over the periodic boundary; its curvature is the
    spectral mean curvature -(h_xx + h_yy) / 2 there.

    Returns
    -------
    dict with `density` (m^-2), `mean_radius` (m, 1 / mean curvature), `height_std` (m, standard deviation
    of the summit heights), `mean_height` (m, above the mean plane). A profile has no summits: all NaN; so
    are the last three where there is no summit.

    Notes
    -----
    Greenwood, Williamson, Proc. R. Soc. A 295 (1966) 300.
    """
    names = ("density", "mean_radius", "height_std", "mean_height")
    if min(height.shape) == 1:
        return dict.fromkeys(names, math.nan)
    values = height.values - height.values.mean()
    summit = _is_summit(values)
    count = int(summit.sum())
    dy, dx = spacing(height)
    result = dict.fromkeys(names, math.nan) | {"density": count / (values.size * dy * dx)}
    if count:
        q = fourier.wavenumbers(values.shape, (dy, dx))
        curvature = np.fft.irfft2(q**2 / 2 * np.fft.rfft2(values), s=values.shape)[summit]
        result["mean_radius"] = float(1 / curvature.mean())
        result["height_std"] = float(values[summit].std())
        result["mean_height"] = float(values[summit].mean())
    return result


def roughness_parameters(height: xr.DataArray) -> dict[str, float]:
    """Return `rms_height`, `rms_gradient`, `rms_curvature`, `nayak_parameter` and
    `points_per_shortest_wavelength` of a periodic map, in SI units."""
    power = _power(height.values)
    m0, gradient, laplacian = _moments(height, power)
    return {
        "rms_height": rms_height(height),
        "rms_gradient": math.sqrt(gradient),
        "rms_curvature": math.sqrt(laplacian) / 2,
        "nayak_parameter": _bandwidth(*_of_profiles(height, m0, gradient, laplacian)),
        "points_per_shortest_wavelength": _cutoff_wavelength(height, power, (1.0, 1.0)),
    }


def _from_first_point(values):
    """Return the heights above the first one: exactly zero for a flat map, wherever it lies."""
    return values - values.flat[0]


def _power(values):
    """Return |h(q)|^2 of each wave, both half-planes counted, mean removed; their sum is the variance."""
    values = _from_first_point(values)
    values -= values.mean()
    power = np.abs(np.fft.rfft2(values)) ** 2
    power *= fourier.halfplane_weights(values.shape)
    power /= values.size**2
    return power


def _moments(height, power):
    """Return sum |q|^(2k) |h(q)|^2 for k = 0, 1, 2."""
    q2 = fourier.wavenumbers(height.shape, spacing(height)) ** 2
    return float(power.sum()), float((q2 * power).sum()), float((q2 * q2 * power).sum())


def _of_profiles(height, m0, gradient, laplacian):
    if min(height.shape) == 1:
        return m0, gradient, laplacian
    return m0, gradient / 2, laplacian * 3 / 8


def _bandwidth(m0, m2, m4):
    return m0 / m2 * (m4 / m2) if m2 > 0 else math.nan


def _cutoff_wavelength(height, power, unit):
    """Return the shortest wavelength, lengths measured with the pitch `unit` = (dy, dx)."""
    slope = power * fourier.wavenumbers(height.shape, spacing(height)) ** 2
    total = slope.sum()
    if not total > 0:
        return math.nan
    q = fourier.wavenumbers(height.shape, unit)
    # shells one fundamental wide, each named by its middle, so that a cut-off at a whole number of waves
    # comes out as just that
    fundamental = 2 * np.pi / max(n * d for n, d in zip(height.shape, unit, strict=True) if n > 1)
    shell = np.rint(q / fundamental).astype(int)
    share = np.bincount(shell.ravel(), weights=slope.ravel()) / total
    beyond = np.cumsum(share[::-1])[::-1]
    edge = int(np.nonzero(beyond > _SHARE_BEYOND_CUTOFF)[0][-1])
    before = share[int(np.ceil(edge / 2 ** (1 / 3))) : edge + 1].mean()
    while edge + 1 < share.size and share[edge + 1] > _CLIFF * before:
        edge += 1
    cutoff = fundamental * edge
    pitch = min(d for n, d in zip(height.shape, unit, strict=True) if n > 1)
    return float(max(2 * np.pi / cutoff, 2 * pitch))


def _is_summit(values):
    """Return where a point is higher than its eight neighbours; of equal neighbours one counts."""
    summit = np.ones(values.shape, dtype=bool)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            neighbour = np.roll(values, (dy, dx), axis=(0, 1))
            if (dy, dx) > (0, 0):
                summit &= values > neighbour
            elif (dy, dx) < (0, 0):
                summit &= values >= neighbour
    return summit
