"""The cases of the benchmark: a surface, nine pairs of size and load, and what a good answer is.

Only NumPy is needed, so that the environment of the other codes can read it too. `python benchmarks/cases.py
--size 512 --seed 0 heights.npy` writes a surface for a code that is not measured here.
"""

import argparse

import numpy as np

SIZES = (512, 1024, 2048)
LOADS = (0.003, 0.03, 0.3)  # mean pressure over contact modulus; the rms gradient is 1
TRUE_ERROR = 1e-4  # relative L2 error of the pressure that every code is timed to
HURST = 0.8
LONGEST = 4  # waves per side of the longest waves
POINTS_PER_SHORTEST_WAVE = 8


def surface(size: int, seed: int = 0) -> np.ndarray:
    """Return heights (size, size) of a periodic surface of unit side and unit rms gradient.

    Self-affine with random phases: |h_q| ~ |q|^-(1 + H), H = 0.8, from 4 to size/8 waves per side, zero
    elsewhere. The larger the map, the more of the spectrum is in it: eight points per shortest wave always.
    """
    ky = np.fft.fftfreq(size, 1 / size)[:, None]
    kx = np.fft.rfftfreq(size, 1 / size)[None, :]
    k = np.hypot(ky, kx)
    inside = (k >= LONGEST) & (k <= size / POINTS_PER_SHORTEST_WAVE)
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal((size, size)))
    spectrum = np.zeros_like(noise)
    spectrum[inside] = noise[inside] / np.abs(noise[inside]) * k[inside] ** -(1 + HURST)
    columns = np.full(kx.shape, 2.0)  # of the full plane that a column of the half plane stands for
    columns[0, 0] = columns[0, -1] = 1
    gradient = np.sqrt((columns * (2 * np.pi * k * np.abs(spectrum)) ** 2).sum())
    return np.fft.irfft2(spectrum / gradient * size**2, s=(size, size))


def relative_error(pressure: np.ndarray, truth: np.ndarray) -> float:
    """Return the relative L2 error of a pressure, ||p - p*|| / ||p*||."""
    return float(np.linalg.norm(pressure - truth) / np.linalg.norm(truth))


def main() -> None:
    parser = argparse.ArgumentParser(description="Write a surface of the benchmark as a NumPy file.")
    parser.add_argument("path", help="file to write (.npy)")
    parser.add_argument("--size", type=int, default=512, help="points per side (default 512)")
    parser.add_argument("--seed", type=int, default=0, help="of the random phases (default 0)")
    arguments = parser.parse_args()
    np.save(arguments.path, surface(arguments.size, arguments.seed))


if __name__ == "__main__":
    main()
