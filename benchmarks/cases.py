"""The surfaces of the benchmark of speed: made ones, hard ones, measured maps and one of these enlarged."""

import contextlib
import sys
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr

sys.path.insert(0, str(Path(__file__).parents[1] / "workflow" / "lib"))

import roughcontact as rc
from roughcontact.arguments.maps import height_map, side_lengths, spacing
from roughcontact.errors import RoughContactError
from roughcontact.kernels.fourier import wavenumbers
from roughcontact.surface.roughness.spectrum import isotropic_spectrum
from roughcontact.surface.synthetic import self_affine_surface

LOADS = (0.003, 0.03, 0.3, 1.0)  # p' = mean pressure over E* times the rms gradient
HURST = 0.8
LONGEST = 4  # waves per side of the longest waves
POINTS_PER_SHORTEST_WAVE = 8
MIN_CASE_POINTS = 1000  # of a measured map that is counted: smaller ones are solved at once
# the work does not depend on the scale: what a file does not say of it may be anything
SCALES = ({}, {"unit": "um"}, {"dx": 1, "dy": 1, "unit": "um"})


def surface(size: int, seed: int = 0) -> np.ndarray:
    """Return heights (size, size) of a periodic surface of unit side and unit rms gradient.

    Self-affine with random phases: |h_q| ~ |q|^-(1 + H), H = 0.8, from 4 to size/8 waves per side, zero
    elsewhere. The larger the map, the more of the spectrum is in it: eight points per shortest wave always.
    """
    band = {"shortest": POINTS_PER_SHORTEST_WAVE / size, "longest": 1 / LONGEST}
    heights = self_affine_surface((size, size), 1 / size, hurst=HURST, rms_gradient=1.0, seed=seed, **band)
    return heights.values


def measured_maps(folders: Sequence[Path]) -> Iterator[tuple[str, xr.DataArray, xr.DataArray | None]]:
    """Yield name, window and square window of every map in the folders, by default levelling and window."""
    for path in sorted(path for folder in folders for path in folder.iterdir() if path.is_file()):
        for scale in SCALES:
            with contextlib.suppress(RoughContactError):
                levelled = rc.level(rc.read_height_map(path, **scale).astype(float))
                window = rc.periodic_window(levelled)
                if window.size >= MIN_CASE_POINTS:
                    yield path.name, window, square_window(levelled) if min(window.shape) > 1 else None
                break


def square_window(levelled: xr.DataArray) -> xr.DataArray | None:
    """Return the window of the largest square in the middle of a map; None where it is not a square, too."""
    side = min(levelled.shape)
    top, left_column = ((n - side) // 2 for n in levelled.shape)
    try:
        window = rc.periodic_window(levelled[top : top + side, left_column : left_column + side])
    except RoughContactError:
        return None
    height, width = side_lengths(window)
    return window if window.shape[0] == window.shape[1] and abs(height / width - 1) < 1e-3 else None


def enlarged(window, size: int, seed: int = 0):
    """Return a map of size x size points of the same pitch and spectrum as a window, with random phases.

    The spectrum is averaged over all directions; waves longer than the window are as strong as its longest.
    """
    pitch = min(spacing(window))
    window_wavenumbers, power = isotropic_spectrum(window)
    q = wavenumbers((size, size), (pitch, pitch))
    power = np.where(q > 0, np.interp(q, window_wavenumbers, power, right=0.0), 0.0)
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal((size, size)))
    amplitude = np.sqrt(power) / (size * pitch)
    return height_map(np.fft.irfft2(noise * amplitude * size, s=(size, size)), pitch)


def hard_surfaces(seed: int = 0) -> dict:
    """Return maps that are hard to solve, by name: long ones, primes, profiles, heights of no surface."""
    generator = np.random.default_rng(seed)
    rough = partial(self_affine_surface, hurst=HURST, shortest=4.0, rms_gradient=1.0, seed=seed)
    square = rough((256, 256), 1.0, longest=64.0)
    heights = square.values
    bowed = rough((180, 720), 1.0, longest=45.0)
    bow = np.cos(2 * np.pi * np.arange(720) / 720) * np.sqrt(2 * 99) * bowed.values.std()
    spike = heights.copy()
    spike[128, 128] += 1000 * heights.std()
    walk = np.cumsum(generator.choice([-1.0, 1.0], 100_000))
    walk -= walk[-1] * np.arange(1, walk.size + 1) / walk.size  # ends where it begins
    return {
        "2 × 500 points": rough((2, 500), 1.0, longest=125.0),
        "251 × 257 points, both prime": rough((251, 257), 1.0, longest=64.0),
        "256 × 256 pixels of 1 : 100": rough((256, 256), (100.0, 1.0), longest=64.0),
        "256 × 256 pixels of 1 : 1000": rough((256, 256), (1000.0, 1.0), longest=64.0),
        "180 × 720 points, a bow of 99 % of the variance": height_map(bowed.values + bow, 1.0),
        "profile of 100 000 points, white noise": height_map(generator.standard_normal((1, 100_000)), 1.0),
        "profile of 100 000 points, H = 0.8": rough((1, 100_000), 1.0, longest=25_000.0),
        "profile of 100 000 points, random walk": height_map(walk[None], 1.0),
        "profile of 99 991 points (prime), H = 0.8": rough((1, 99_991), 1.0, longest=25_000.0),
        "256 × 256 points, one of them 1000 Sq high": height_map(spike, 1.0),
        "256 × 256 points, chessboard": height_map(np.indices((256, 256)).sum(0) % 2.0, 1.0),
        "256 × 256 points, plateaus (upper 40 % cut off)": height_map(
            np.minimum(heights, np.quantile(heights, 0.6)), 1.0
        ),
        "256 × 256 points, two heights": height_map(np.where(heights > 0, 1.0, 0.0), 1.0),
        "256 × 256 points, heights in steps of Sq / 4": height_map(
            np.rint(heights / heights.std() * 4) * heights.std() / 4, 1.0
        ),
    }


def relative_error(pressure: np.ndarray, truth: np.ndarray) -> float:
    """Return the relative L2 error of a pressure, ||p - p*|| / ||p*||."""
    return float(np.linalg.norm(pressure - truth) / np.linalg.norm(truth))
