"""Simulators of instruments: what a measurement makes of a true height map.

Every function takes a height map (y, x; m) and returns one with the attributes of the true map. Maps are
continued by their mirror images where a point outside is needed.
"""

import numpy as np
import xarray as xr
from scipy import ndimage

from roughcontact.arguments.maps import height_map, spacing


def add_noise(height: xr.DataArray, rms: float, seed: int) -> xr.DataArray:
    """Add white Gaussian noise of a given `rms` (m)."""
    noise = rms * np.random.default_rng(seed).standard_normal(height.shape)
    return height.copy(data=height.values + noise)


def rounded(height: xr.DataArray, step: float) -> xr.DataArray:
    """Return the map as an instrument with a digitisation step (m) stores it."""
    return height.copy(data=np.rint(height.values / step) * step)


def through_lens(height: xr.DataArray, numerical_aperture: float, wavelength: float) -> xr.DataArray:
    """Return the map as an ideal microscope with incoherent light of a `wavelength` (m) transmits it.

    The amplitudes of the waves, of the map and its mirror images, are multiplied by `transfer`.
    """
    values = height.values
    doubled = np.pad(values, [(0, n) for n in values.shape], mode="symmetric")
    frequencies = (np.fft.fftfreq(n, d) for n, d in zip(doubled.shape, spacing(height), strict=True))
    passed = transfer(np.hypot(*np.meshgrid(*frequencies, indexing="ij")), numerical_aperture, wavelength)
    blurred = np.fft.ifft2(np.fft.fft2(doubled) * passed).real
    return height.copy(data=blurred[: values.shape[0], : values.shape[1]])


def transfer(frequency: np.ndarray, numerical_aperture: float, wavelength: float) -> np.ndarray:
    """Return the modulation transfer of a circular pupil at spatial frequencies (m-1).

    It vanishes from 2 NA / wavelength on, and is the overlap of two unit circles over their area (Goodman
    2005, Introduction to Fourier Optics, 6.3).
    """
    share = np.clip(np.asarray(frequency) * wavelength / (2 * numerical_aperture), 0, 1)
    return 2 / np.pi * (np.arccos(share) - share * np.sqrt(1 - share**2))


def traced_by(height: xr.DataArray, tip_radius: float) -> xr.DataArray:
    """Return the lowest positions of a spherical tip of a radius (m) that touches the map: its grey dilation.

    The flank of the tip beyond its half sphere is vertical.
    """
    values, steps = height.values, spacing(height)
    range_ = np.ptp(values)
    # points further away than this lie deeper under the tip than the map is high
    reach = tip_radius if range_ >= tip_radius else np.sqrt(range_ * (2 * tip_radius - range_))
    points = [min(int(reach / d), n - 1) for n, d in zip(values.shape, steps, strict=True)]
    y, x = (d * np.arange(-n, n + 1) for n, d in zip(points, steps, strict=True))
    square = y[:, None] ** 2 + x[None, :] ** 2
    tip = np.sqrt(np.maximum(tip_radius**2 - square, 0)) - tip_radius
    inside = square <= tip_radius**2
    traced = ndimage.grey_dilation(
        values, footprint=inside, structure=np.where(inside, tip, 0), mode="reflect"
    )
    return height.copy(data=traced)


def coarser(height: xr.DataArray, factor: int) -> xr.DataArray:
    """Return the means of square blocks of `factor` by `factor` points."""
    blocks = height.coarsen(y=factor, x=factor, boundary="trim").mean()
    return blocks.assign_attrs(height.attrs)


def finer(height: xr.DataArray, factor: int) -> xr.DataArray:
    """Return the map with pixels `factor` times as small, interpolated by cubic splines as software does."""
    shape = [factor * n for n in height.shape]
    # places of the new cell centres, in points of the map
    positions = [(np.arange(n) + 0.5) / factor - 0.5 for n in shape]
    grid = np.meshgrid(*positions, indexing="ij")
    values = ndimage.map_coordinates(height.values, grid, order=3, mode="reflect")
    coordinates = {
        axis: height[axis].values[0] + coordinate * step
        for axis, coordinate, step in zip("yx", positions, spacing(height), strict=True)
    }
    return xr.DataArray(values, coordinates, ("y", "x"), name=height.name, attrs=height.attrs)


def scaled(height: xr.DataArray, z: float = 1.0, xy: float = 1.0) -> xr.DataArray:
    """Return the map with its heights times `z`, and its lengths times `xy`."""
    coordinates = {axis: xy * height[axis].values for axis in "yx"}
    return height.copy(data=z * height.values).assign_coords(coordinates)


def median_filtered(height: xr.DataArray, points: int) -> xr.DataArray:
    """Return the medians of the squares of `points` by `points` around each point."""
    return height.copy(data=ndimage.median_filter(height.values, points, mode="reflect"))


def gauss_filtered(height: xr.DataArray, points: float) -> xr.DataArray:
    """Return the map after a Gaussian filter with a standard deviation of some `points`."""
    return height.copy(data=ndimage.gaussian_filter(height.values, points, mode="reflect"))


def with_dust(height: xr.DataArray, peak: float, width: float, spot: tuple[int, int]) -> xr.DataArray:
    """Add a Gaussian bell at a `spot` (row, column), `peak` (m) high, with a deviation of `width` points."""
    rows, columns = np.ogrid[: height.shape[0], : height.shape[1]]
    square = (rows - spot[0]) ** 2 + (columns - spot[1]) ** 2
    return height.copy(data=height.values + peak * np.exp(-square / (2 * width**2)))


def with_compressed_peaks(height: xr.DataArray, share: float, factor: float) -> xr.DataArray:
    """Return the map with the heights of its highest `share` of points, above the rest, times `factor`."""
    limit = float(np.quantile(height.values, 1 - share))
    return height.copy(data=np.where(height > limit, limit + factor * (height - limit), height))


def other_surface(kind: str, points: int, longest: float, *, hurst: float, seed: int) -> xr.DataArray:
    """Return a periodic surface of a kind that is not among `validation.masters`, of unit pitch.

    "cratered": dents of scattered size, as by shot peening; "conical": cones of scattered height, as of
    abrasive grains; "stretched": self-affine with a lay, waves three times as long along y; "lognormal": the
    exponential of a self-affine surface. All have roughness down to two points; `longest` (points) is the
    length of the longest waves.
    """
    generator, shape = np.random.default_rng(seed), (points, points)
    along, across = np.fft.fftfreq(points)[:, None], np.fft.fftfreq(points)[None, :]
    frequency = np.hypot(3 * along if kind == "stretched" else along, across)
    amplitude = np.maximum(frequency, 1 / longest) ** -(1 + hurst)
    fine = np.fft.ifft2(np.fft.fft2(generator.standard_normal(shape)) * amplitude).real
    fine /= fine.std()
    if kind == "stretched":
        return height_map(fine, 1.0)
    if kind == "lognormal":
        return height_map(np.exp(0.5 * fine), 1.0)
    coarse, positions = np.zeros(shape), np.arange(points)
    for _ in range(400):
        radius, centre = longest / 2 * generator.uniform(0.2, 1.0), generator.uniform(0, points, 2)
        rows, columns = (np.abs((positions - at + points / 2) % points - points / 2) for at in centre)
        distance = np.hypot(rows[:, None], columns[None, :]) / radius
        if kind == "cratered":
            coarse = np.minimum(coarse, radius * (distance**2 - 1))
        else:
            coarse = np.maximum(coarse, radius * (1 - distance))
    return height_map(coarse / coarse.std() + 0.3 * fine, 1.0)
