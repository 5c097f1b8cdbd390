"""Power spectra of a periodic map: areal and radially averaged."""

import numpy as np
import xarray as xr

from roughcontact.maps import spacing


def areal_spectrum(height: xr.DataArray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the power spectrum of a periodic map for every wave, C(q) = A |h(q)|^2 [1]_.

    h(q) are the amplitudes of h(r) = sum h(q) exp(i q.r) and A is the area of the map (for a profile its
    length), so that the mean square height is the sum of C(q) / A, or the integral of C(q) d^2q / (2 pi)^2.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.

    Returns
    -------
    qy, qx : arrays (ny,) and (nx,), rad/m
        in the order of `numpy.fft.fftfreq`.
    power : array (ny, nx), m^4; of a profile m^3

    References
    ----------
    .. [1] Jacobs, T. D. B., Junge, T., Pastewka, L. (2017), Surf. Topogr.: Metrol. Prop. 5, 013001, eqs. (4)
       and (8).

    Examples
    --------
    >>> from roughcontact.references.synthetic import westergaard_surface
    >>> wave = westergaard_surface((1, 8), 0.5, amplitude=2.0, wavelength=4.0)
    >>> qy, qx, power = areal_spectrum(wave)
    >>> print(np.round(power, 6), round(float(power.sum()) / 4.0, 6))  # the mean square height is 2
    [[0. 4. 0. 0. 0. 0. 0. 4.]] 2.0
    """
    step = spacing(height)
    values = height.values - height.values.flat[0]
    values = values - values.mean()
    amplitude = np.fft.fft2(values) / values.size
    area = np.prod([n * d for n, d in zip(values.shape, step, strict=True) if n > 1])
    qy, qx = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(values.shape, step, strict=True))
    return qy, qx, area * (amplitude.real**2 + amplitude.imag**2)


def isotropic_spectrum(height: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    """Return the radially averaged power spectrum C(q): the mean of C over all waves of about the same |q|.

    The shells are one fundamental wave of the longer side wide; the last is the largest that fits between the
    Nyquist limits. q is the mean of |q| in the shell.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic.

    Returns
    -------
    q : array (shells,), rad/m
        rising.
    power : array (shells,), m^4; of a profile m^3

    Examples
    --------
    >>> from roughcontact.references.synthetic import westergaard_surface
    >>> q, power = isotropic_spectrum(westergaard_surface((1, 8), 0.5, amplitude=2.0, wavelength=4.0))
    >>> print(np.round(q * 4.0 / (2 * np.pi), 6), np.round(power, 6))
    [1. 2. 3. 4.] [4. 0. 0. 0.]
    """
    qy, qx, power = areal_spectrum(height)
    lengths = [n * d for n, d in zip(height.shape, spacing(height), strict=True) if n > 1]
    limits = [np.pi / d for n, d in zip(height.shape, spacing(height), strict=True) if n > 1]
    fundamental = 2 * np.pi / max(lengths)
    wavenumber = np.hypot(qy[:, None], qx[None, :]).ravel()
    shell = np.rint(wavenumber / fundamental).astype(int)
    last = max(int(min(limits) / fundamental * (1 + 1e-9)), 1)
    count = np.bincount(shell, minlength=last + 1)[1 : last + 1]
    total = np.bincount(shell, weights=power.ravel(), minlength=last + 1)[1 : last + 1]
    mean = np.bincount(shell, weights=wavenumber, minlength=last + 1)[1 : last + 1]
    some = count > 0
    return mean[some] / count[some], total[some] / count[some]


def angular_spectrum(height: xr.DataArray, *, step: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """Return how the power of a periodic map is spread over the directions of its waves.

    f(theta) = integral of C(q) q dq along the ray in the direction theta, from the first wave of the shorter
    side to the smaller Nyquist limit, C interpolated between the waves of the map.

    Parameters
    ----------
    height : DataArray (y, x), m
        periodic; not a profile.
    step : float, degree
        between the directions.

    Returns
    -------
    theta : array, degree
        from x towards y, 0 to 180.
    power : array, m^2 per radian
        both ends of the wavevector counted.

    Examples
    --------
    >>> from roughcontact.references.synthetic import westergaard_surface
    >>> wave = westergaard_surface((64, 64), 1.0, amplitude=1.0, wavelength=8.0)
    >>> theta, power = angular_spectrum(wave)
    >>> float(theta[np.argmax(power)])  # the wave runs along x
    0.0
    """
    from scipy.ndimage import map_coordinates

    qy, qx, power = areal_spectrum(height)
    dqy, dqx = (2 * np.pi / (n * d) for n, d in zip(height.shape, spacing(height), strict=True))
    theta = np.arange(0, 180, step)
    radius = np.arange(1, np.pi / max(spacing(height)) / min(dqy, dqx)) * min(dqy, dqx)
    radius = radius[radius >= max(dqy, dqx) * (1 - 1e-9)]
    across = np.deg2rad(theta)[:, None]
    centred = np.fft.fftshift(power)
    rows = radius * np.sin(across) / dqy + qy.size // 2
    columns = radius * np.cos(across) / dqx + qx.size // 2
    rays = map_coordinates(centred, [rows, columns], order=1, mode="nearest")
    return theta, 2 * (rays * radius).sum(axis=1) * min(dqy, dqx) / (2 * np.pi) ** 2
