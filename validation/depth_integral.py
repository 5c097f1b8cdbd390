"""Stresses below a pressure by potentials, and the volume above a limit by a sum over very many depths.

It shares no line with `elasticity.subsurface` and `statistics.subsurface`, which it is there to check.
"""

from collections.abc import Sequence

import numpy as np

_STEP = 0.02  # of ln(1 + z/z0), z0 a thirtieth of a point: half of it changes a volume by less than 1e-3
_FINEST = 1 / 30


def von_mises_below(
    pressure: np.ndarray, steps: tuple[float, float], depth: float, *, poissons_ratio: float
) -> np.ndarray:
    """Return the stress of von Mises at a depth below a periodic pressure without friction.

    With the harmonic ψ whose second derivative in depth is the pressure without its mean, there are::

        σzz = -ψ,zz + z ψ,zzz      σxx = (1 - 2ν) ψ,xx - 2ν ψ,zz + z ψ,xxz      σxz = z ψ,xzz
        σxy = (1 - 2ν) ψ,xy + z ψ,xyz                                           σyz = z ψ,yzz

    and besides the mean pressure p̄ across the surface, p̄ ν/(1 - ν) along it: the potentials of Boussinesq,
    Johnson (1985), Contact Mechanics, section 3.2.

    Parameters
    ----------
    pressure : array (ny, nx), Pa
        periodic.
    steps : (dy, dx), m
        of the points.
    depth : float, m
    poissons_ratio : float
        ν.

    Returns
    -------
    array (ny, nx), Pa

    Examples
    --------
    At the depth 1/q below a wave, of a body that keeps its volume: √3/e everywhere along the wave

    >>> import numpy as np
    >>> wave = np.cos(2 * np.pi * np.arange(4) / 4)[None, :]
    >>> print(von_mises_below(wave, (1.0, 1.0), 4 / (2 * np.pi), poissons_ratio=0.5).round(4))
    [[0.6372 0.6372 0.6372 0.6372]]
    """
    ky, kx = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(pressure.shape, steps, strict=True))
    ky, kx = np.meshgrid(ky, kx, indexing="ij")
    k = np.sqrt(kx**2 + ky**2)
    mean = pressure.mean()
    with np.errstate(divide="ignore", invalid="ignore"):
        potential = np.where(k > 0, np.fft.fft2(pressure) * np.exp(-k * depth) / k**2, 0)

    def derivative(x: int, y: int, z: int) -> np.ndarray:
        """Return a derivative of ψ: so many times along each axis."""
        computed = potential * (1j * kx) ** x * (1j * ky) ** y * (-k) ** z
        # the shortest wave of an even side has no slope at the points
        if x % 2 and pressure.shape[1] % 2 == 0:
            computed[:, pressure.shape[1] // 2] = 0
        if y % 2 and pressure.shape[0] % 2 == 0:
            computed[pressure.shape[0] // 2] = 0
        return np.fft.ifft2(computed).real

    nu, across = poissons_ratio, derivative(0, 0, 2)
    zz = -across + depth * derivative(0, 0, 3) - mean
    xx = (1 - 2 * nu) * derivative(2, 0, 0) - 2 * nu * across + depth * derivative(2, 0, 1)
    yy = (1 - 2 * nu) * derivative(0, 2, 0) - 2 * nu * across + depth * derivative(0, 2, 1)
    xx, yy = xx - nu / (1 - nu) * mean, yy - nu / (1 - nu) * mean
    xy = (1 - 2 * nu) * derivative(1, 1, 0) + depth * derivative(1, 1, 1)
    xz, yz = depth * derivative(1, 0, 2), depth * derivative(0, 1, 2)
    middle = (xx + yy + zz) / 3
    normal = (xx - middle) ** 2 + (yy - middle) ** 2 + (zz - middle) ** 2
    return np.sqrt(1.5 * (normal + 2 * (xy**2 + xz**2 + yz**2)))


def volume_above(
    pressure: np.ndarray, steps: tuple[float, float], *, poissons_ratio: float, limits: Sequence[float]
) -> tuple[float, np.ndarray]:
    """Return the largest stress of von Mises below a pressure, and the volumes where it exceeds limits.

    A column of material below each point, through hundreds of depths down to twice the longer side: it is
    above the limit between two depths that are, and up to where a straight line has the limit beside one.

    Parameters
    ----------
    pressure : array (ny, nx), Pa
        periodic.
    steps : (dy, dx), m
        of the points.
    poissons_ratio : float
    limits : sequence of float, Pa

    Returns
    -------
    largest : float, Pa
        at the depths of the sum.
    volumes : array (limits), m
        by area.

    Examples
    --------
    >>> import numpy as np
    >>> wave = np.cos(2 * np.pi * np.arange(4) / 4)[None, :]
    >>> most, volumes = volume_above(wave, (1.0, 1.0), poissons_ratio=0.5, limits=[0.5])
    >>> print(f"{most:.4f} {volumes[0] * 2 * np.pi / 4:.4f}")  # Lambert's W has 1.4115
    0.6372 1.4115
    """
    long = [(n * d, d) for n, d in zip(pressure.shape, steps, strict=True) if n > 1]
    finest = _FINEST * min(d for _, d in long)
    last = np.log1p(2 * max(side for side, _ in long) / finest)
    depths = finest * np.expm1(np.linspace(0, last, int(last / _STEP) + 2))
    largest, volumes = 0.0, np.zeros(len(limits))
    above = None
    for index, depth in enumerate(depths):
        stress = von_mises_below(pressure, steps, depth, poissons_ratio=poissons_ratio)
        largest = max(largest, float(stress.max()))
        if above is not None:
            for place, limit in enumerate(limits):
                part = np.zeros(stress.shape)
                part[(above > limit) & (stress > limit)] = 1
                crossing = (above > limit) != (stress > limit)
                high, low = (f(above, stress)[crossing] for f in (np.maximum, np.minimum))
                part[crossing] = (high - limit) / (high - low)
                volumes[place] += (depth - depths[index - 1]) * part.mean()
        above = stress
    return largest, volumes
