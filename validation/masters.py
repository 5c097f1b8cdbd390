"""Large periodic surfaces of many kinds, and maps cut out of them with the faults that measurements have.

The kinds are what workshops make: random (Gaussian), worn (deep valleys, no peaks), eroded (high peaks, no
valleys), honed (crossing grooves), dimpled (a lattice of dimples), ground (a strong lay), turned (parallel
grooves) and grainy (bumps of scattered size). Each has long waves of a length that is asked for.
"""

from typing import Literal, get_args

import numpy as np
import xarray as xr

from roughcontact.arguments.maps import height_map
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import self_affine_surface

Kind = Literal["random", "worn", "eroded", "honed", "dimpled", "ground", "turned", "grainy"]
KINDS: tuple[Kind, ...] = get_args(Kind)
Fault = Literal["none", "bow", "spikes"]
FAULTS: tuple[Fault, ...] = get_args(Fault)

_GRADIENT = 0.1
_SHORTEST = 6.0  # points


def master_surface(kind: Kind, points: int, *, longest: float, seed: int, hurst: float = 0.8) -> xr.DataArray:
    """Return a periodic surface of a kind, of unit side and rms gradient 0.1.

    `longest` is the wavelength of the longest waves over the side; `hurst` is that of the roughness.

    Examples
    --------
    >>> worn, eroded = (master_surface(kind, 64, longest=0.5, seed=1) for kind in ("worn", "eroded"))
    >>> bool((worn**3).mean() < 0 < (eroded**3).mean())
    True
    """
    generator = np.random.default_rng(seed)
    longest = max(longest * points, 2 * _SHORTEST)
    waves = _waves(points, longest, hurst, seed)
    if kind == "worn":
        heights = -np.exp(0.5 * waves)
    elif kind == "eroded":
        heights = np.exp(0.4 * waves)
    elif kind == "honed":
        fine = _waves(points, max(longest / 4, 2 * _SHORTEST), hurst, seed + 1)
        heights = 0.3 * fine + 0.3 * waves + _honing(points, generator)
    elif kind == "dimpled":
        heights = waves - 4 * _dimples(points)
    elif kind == "ground":
        heights = _waves(points, longest, hurst, seed, stretch=8.0)
    elif kind == "turned":
        fine = _waves(points, 4 * _SHORTEST, hurst, seed + 1)
        heights = grooves(points, points // 24, 0.15, generator) + 0.1 * fine + 0.15 * waves
    elif kind == "grainy":
        heights = 0.5 * waves + _grains(points, generator)
    else:
        heights = waves
    surface = height_map(heights - heights.mean(), 1 / points)
    return surface * (_GRADIENT / rms_gradient(surface))


def cut_out(
    master: xr.DataArray, side: int, generator: np.random.Generator, *, fault: Fault = "none"
) -> xr.DataArray:
    """Return a map as an instrument would deliver it: cut out of a surface, tilted, with spots missing.

    `side` is in points; `generator` draws place, tilt, spots and fault. A bow is a paraboloid on top, 0.4 rms
    heights high; spikes are ten points that are 6 to 20 rms heights off.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> found = cut_out(rough_reference_surface(64), 32, np.random.default_rng(1))
    >>> found.shape, bool(0.01 <= found.isnull().mean() < 0.1)
    ((32, 32), True)
    """
    starts = generator.integers(0, master.shape[0], 2)
    heights = np.roll(master.values, -starts, (0, 1))[:side, :side].copy()
    rms = heights.std()
    y, x = (axis / side - 0.5 for axis in np.mgrid[:side, :side])
    slopes = 5 * rms * generator.standard_normal(2)
    heights += slopes[0] * y + slopes[1] * x
    if fault == "bow":
        heights += 0.8 * rms * generator.choice((-1, 1)) * (x**2 + y**2)
    elif fault == "spikes":
        rows, columns = generator.integers(1, side - 1, (2, 10))
        heights[rows, columns] += rms * generator.uniform(6, 20, 10) * generator.choice((-1, 1), 10)
    missing = np.zeros(heights.shape, bool)
    while missing.mean() < 0.01:
        at, radius = generator.uniform(0, side, 2), generator.uniform(1, 4)
        rows, columns = np.mgrid[:side, :side]
        missing |= np.hypot(rows - at[0], columns - at[1]) < radius
    heights[missing] = np.nan
    return height_map(heights, float(master["x"][1] - master["x"][0]))


def _waves(points: int, longest: float, hurst: float, seed: int, *, stretch: float = 1.0) -> np.ndarray:
    """Return self-affine roughness of unit rms height; lengths in points."""
    return self_affine_surface(
        (points, points),
        1.0,
        hurst=hurst,
        shortest=_SHORTEST,
        longest=longest,
        rms_height=1.0,
        stretch=stretch,
        seed=seed,
    ).values


def _distance(points: int, middle: float) -> np.ndarray:
    """Return the distance of each place along a periodic side from one of them, with its sign."""
    return (np.arange(points) - middle + points / 2) % points - points / 2


def _honing(points: int, generator: np.random.Generator) -> np.ndarray:
    """Return crossing grooves of scattered width and depth, 30 in each direction."""
    rows, columns = np.mgrid[:points, :points]
    heights = np.zeros((points, points))
    for sign in (1, -1):
        for _ in range(30):
            middle, width, depth = (
                generator.uniform(0, points),
                generator.uniform(2, 6),
                generator.exponential(1.5),
            )
            across = (columns + sign * rows - middle + points / 2) % points - points / 2
            heights = np.minimum(heights, -depth * np.exp(-((across / width) ** 2) / 4))
    return heights


def _dimples(points: int) -> np.ndarray:
    """Return the depth of parabolic dimples of unit depth on a square lattice, 12 along each side."""
    across = (np.arange(points) * 12 / points) % 1 - 0.5
    return np.clip(1 - (across[:, None] ** 2 + across[None, :] ** 2) / 0.3**2, 0, None)


def grooves(points: int, count: int, scatter: float, generator: np.random.Generator) -> np.ndarray:
    """Return parabolic grooves along y (1, points) of unit depth, which scatters by so much."""
    x = (np.arange(points) + 0.5) * count / points
    depth = scatter * generator.standard_normal(count)
    groove = np.floor(x).astype(int)
    # neighbouring passes cut into each other: the lowest parabola is what stays
    passes = [4 * (x - groove - s - 0.5) ** 2 + depth[(groove + s) % count] for s in (-1, 0, 1)]
    return np.min(passes, axis=0)[None, :]


def _grains(points: int, generator: np.random.Generator) -> np.ndarray:
    """Return bumps of scattered place, width and height, about one on a square of 40 points."""
    heights = np.zeros((points, points))
    for _ in range(round((points / 40) ** 2)):
        row, column = generator.uniform(0, points, 2)
        width, height = generator.uniform(2, 6), generator.exponential(1.0)
        y, x = _distance(points, row)[:, None], _distance(points, column)[None, :]
        heights += height * np.exp(-(x**2 + y**2) / (2 * width**2))
    return heights
