"""Areal parameters and power spectrum of a map, as statistics and report of a run have them."""

import xarray as xr

from roughcontact.arguments.maps import dimensions
from roughcontact.arguments.si import as_si
from roughcontact.arguments.variables import describe
from roughcontact.surface.roughness.heights import HEIGHT_PARAMETERS
from roughcontact.surface.roughness.spectrum import isotropic_spectrum
from roughcontact.surface.roughness.texture import texture_parameters
from roughcontact.surface.window.periodic_window import periodic_window


@as_si
def parameters(height: xr.DataArray) -> xr.Dataset:
    """Return the areal parameters of ISO 25178-2 [1]_ of a map.

    Those of heights and material ratio (`Sa`, `Sq`, `Sz`, `Sdr`, `Sk` ..., `surface.roughness.heights`)
    are of the measured points as they are given, without filled ones; `Sal`, `Str`, `Std` and `Ssw`
    (`roughcontact.surface.roughness.texture`) of the periodic window.

    Parameters
    ----------
    height : DataArray (y, x), m
        from `level`: form and tilt count as height. NaN where not measured.

    Returns
    -------
    Dataset
        numbers with `units` and `long_name`: m, degree or none; NaN where the map has no such parameter.

    Raises
    ------
    HeightMapError
        for a map without two measured neighbours.

    References
    ----------
    .. [1] ISO 25178-2:2021.

    Examples
    --------
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> wave = westergaard_surface((64, 64), 1e-6, amplitude=1e-6, wavelength=16e-6)
    >>> result = parameters(wave)
    >>> f"{result['Sq'].item():.3g} {result['Sq'].attrs['units']}, {result['Sal'].item():.3g} m"
    '7.07e-07 m, 3.49e-06 m'
    """
    # spectral parameters need a period, and those of height are of the same part of the map
    window = periodic_window(height)
    height_numbers = {name: window.attrs[name] for name in HEIGHT_PARAMETERS}
    return describe(xr.Dataset(height_numbers | texture_parameters(window)))


@as_si
def power_spectrum(height: xr.DataArray) -> xr.DataArray:
    """Return the power spectrum C(q) of a map, the mean over all directions.

    It is that of the periodic window (`surface.roughness.spectrum.isotropic_spectrum`): the mean square
    height is the integral of C(q) q dq / (2 pi), of a profile that of C(q) dq / pi.

    Parameters
    ----------
    height : DataArray (y, x), m
        from `level`, or a window of `periodic_window`.

    Returns
    -------
    DataArray (wavenumber)
        in m4, of a profile in m3, over the angular wavenumber in rad/m.

    Raises
    ------
    HeightMapError
        for a map without two measured neighbours.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.surface.synthetic import westergaard_surface
    >>> spectrum = power_spectrum(westergaard_surface((64, 64), 1e-6, amplitude=1e-6, wavelength=16e-6))
    >>> f"{2 * np.pi / spectrum.idxmax('wavenumber').item():.2g} m", spectrum.attrs["units"]
    ('1.6e-05 m', 'm4')
    """
    window = periodic_window(height)
    wavenumber, power = isotropic_spectrum(window)
    axis = xr.Variable("wavenumber", wavenumber, {"units": "rad m-1", "long_name": "angular wavenumber"})
    attrs = {
        "units": f"m{2 + dimensions(window.shape)}",
        "long_name": "power spectral density, mean over all directions",
    }
    return xr.DataArray(power, {"wavenumber": axis}, name="power_spectrum", attrs=attrs)
