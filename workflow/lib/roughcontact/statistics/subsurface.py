"""Where below the surface a contact strains its material most."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.elasticity.subsurface import subsurface_stress, tresca, von_mises

_DEPTHS_PER_DECADE = 6
_DEEPEST = 0.25  # of the shorter side: deeper down the periodic copies act as one pressure
_FINE = 0.01  # to which share the depth of the largest stress is found, and to which a load has the stress

Bodies = Sequence[Mapping[str, float | None]]


def profile_depths(shape: Sequence[int], steps: tuple[float, float]) -> np.ndarray:
    """Return the depths at which stresses are looked for: the surface, and half a pixel to a quarter side.

    Contact spots are from one pixel to the whole map across, and the stress of each is largest at about half
    its radius; depths in equal ratios find them all, whatever the load.

    Parameters
    ----------
    shape : (ny, nx)
        of the map.
    steps : (dy, dx), m
        pitch of the points.

    Returns
    -------
    array (depths), m

    Examples
    --------
    >>> depths = profile_depths((256, 256), (1e-6, 1e-6))
    >>> print(depths.size, depths[1], depths[-1])
    15 5e-07 6.4e-05
    """
    sides = [n * d for n, d in zip(shape, steps, strict=True) if n > 1]
    first = min(d for n, d in zip(shape, steps, strict=True) if n > 1) / 2
    last = max(_DEEPEST * min(sides), 2 * first)
    count = math.ceil(_DEPTHS_PER_DECADE * math.log10(last / first)) + 1
    return np.append(0.0, np.geomspace(first, last, count))


def strained_body(bodies: Bodies | None) -> Mapping[str, float | None] | None:
    """Return the body that yields first: that of the lower yield stress, else of the lower Young's modulus.

    Parameters
    ----------
    bodies : sequence of two mappings, or None
        `poissons_ratio`, and as far as known `yield_stress` (Pa) and `youngs_modulus` (Pa).

    Returns
    -------
    mapping or None

    Examples
    --------
    >>> soft, hard = {"poissons_ratio": 0.4, "yield_stress": 1e8}, {"poissons_ratio": 0.3}
    >>> strained_body([hard, soft])["poissons_ratio"]
    0.4
    """
    if not bodies:
        return None
    return min(
        bodies, key=lambda body: (body.get("yield_stress") or np.inf, body.get("youngs_modulus") or np.inf)
    )


def stress_columns(
    pressure: np.ndarray,
    steps: tuple[float, float],
    *,
    poissons_ratio: float,
    yield_stress: float | None = None,
) -> dict[str, Any]:
    """Return the largest stresses below a pressure, where they act, and how they change with depth.

    Parameters
    ----------
    pressure : array (ny, nx), Pa
        periodic.
    steps : (dy, dx), m
        pitch of the points.
    poissons_ratio : float
        of the body.
    yield_stress : float, Pa, optional
        in tension.

    Returns
    -------
    dict
        `von_mises_profile` (depths) Pa, the largest at each of the `profile_depths`;
        `max_von_mises_stress`, `max_tresca_stress` (Pa), `max_von_mises_depth` (m), `max_von_mises_x`,
        `max_von_mises_y` (m from the first point); with a yield stress `volume_above_yield` (m), the volume
        by area where von Mises' stress exceeds it.

    Examples
    --------
    Below a wave of amplitude 1, without its mean, von Mises' stress is largest near the depth 1/q:

    >>> wave = np.cos(2 * np.pi * np.arange(64) / 64)[None, :]
    >>> found = stress_columns(wave, (1.0, 1.0), poissons_ratio=0.5)
    >>> print(f"{found['max_von_mises_stress']:.4f} {found['max_von_mises_depth'] * 2 * np.pi / 64:.2f}")
    0.6372 1.00
    """
    stress_at = subsurface_stress(pressure, steps, poissons_ratio=poissons_ratio)
    depths = profile_depths(pressure.shape, steps)
    profile, shear = np.zeros(depths.size), np.zeros(depths.size)
    volume, higher_up = 0.0, None
    for index, depth in enumerate(depths):
        stress = stress_at(depth)
        equivalent = von_mises(stress)
        profile[index], shear[index] = equivalent.max(), _largest_tresca(stress, equivalent)
        if yield_stress is not None:
            if higher_up is not None:
                thickness = depth - depths[index - 1]
                volume += thickness * _share_above(higher_up, equivalent, yield_stress)
            higher_up = equivalent
    best = int(profile.argmax())
    depth, stress = float(depths[best]), stress_at(float(depths[best]))
    if 0 < best < depths.size - 1:
        from scipy.optimize import minimize_scalar  # takes longer to import than a small map to solve

        found = minimize_scalar(
            lambda z: -von_mises(stress_at(z)).max(),
            bounds=(float(depths[best - 1]), float(depths[best + 1])),
            method="bounded",
            options={"xatol": _FINE * depth},
        )
        if -found.fun > profile[best]:
            depth, stress = float(found.x), stress_at(float(found.x))
    equivalent = von_mises(stress)
    row, column = np.unravel_index(int(equivalent.argmax()), equivalent.shape)
    columns: dict[str, Any] = {
        "max_von_mises_stress": float(equivalent.max()),
        "max_von_mises_depth": depth,
        "max_von_mises_x": column * steps[1],
        "max_von_mises_y": row * steps[0],
        "max_tresca_stress": max(_largest_tresca(stress, equivalent), float(shear.max())),
        "von_mises_profile": profile,
    }
    if yield_stress is not None:
        columns["volume_above_yield"] = volume
    return columns


def with_subsurface_yield(statistics: xr.Dataset, bodies: Bodies | None) -> xr.Dataset:
    """Return the statistics with the mean pressure at which a body begins to yield below its surface.

    There the largest stress of von Mises reaches the yield stress. Between the two loads that have it between
    them, stress and load are interpolated as powers of one another.

    Parameters
    ----------
    statistics : Dataset
        `max_von_mises_stress` (load) Pa, coordinate `mean_pressure` (load) Pa.
    bodies : sequence of two mappings, or None
        of which one at least states a `yield_stress` (Pa).

    Returns
    -------
    Dataset
        with `first_subsurface_yield_pressure` (Pa), NaN where no load has it and no two have it between
        them; unchanged without stresses or without a yield stress.

    Examples
    --------
    The stress below a sphere grows with the third root of the load:

    >>> import xarray as xr
    >>> loads = {"mean_pressure": ("load", [1e6, 8e6])}
    >>> sphere = xr.Dataset({"max_von_mises_stress": ("load", [1e8, 2e8])}, coords=loads)
    >>> found = with_subsurface_yield(sphere, [{"yield_stress": 1.5e8}, {"yield_stress": 3e8}])
    >>> print(f"{found['first_subsurface_yield_pressure'].item():.4g}")
    3.375e+06
    """
    body = strained_body(bodies) or {}
    limit = body.get("yield_stress")
    if limit is None or "max_von_mises_stress" not in statistics:
        return statistics
    order = np.argsort(statistics["mean_pressure"].values)
    load, stress = (statistics[name].values[order] for name in ("mean_pressure", "max_von_mises_stress"))
    nearest = int(np.argmin(np.abs(stress / limit - 1)))
    if abs(stress[nearest] / limit - 1) < _FINE:  # a load that was looked for, just beside it
        return statistics.assign(first_subsurface_yield_pressure=float(load[nearest]))
    first = int(np.argmax(stress >= limit))  # 0 also where none is
    pair = slice(first - 1, first + 1)
    pressure = (
        float(np.exp(np.interp(np.log(limit), np.log(stress[pair]), np.log(load[pair]))))
        if first > 0
        else math.nan
    )
    return statistics.assign(first_subsurface_yield_pressure=pressure)


def _share_above(upper: np.ndarray, lower: np.ndarray, limit: float) -> float:
    """Return the share of a layer above a limit, of stresses that change linearly between its two faces."""
    least, most = np.minimum(upper, lower), np.maximum(upper, lower)
    steep = most > least
    share = np.divide(most - limit, most - least, out=(most > limit).astype(float), where=steep)
    return float(np.clip(share, 0.0, 1.0).mean())


def _largest_tresca(stress: np.ndarray, equivalent: np.ndarray) -> float:
    """Return the largest stress of Tresca, which is never more than 2/√3 of von Mises' at the same point."""
    near = equivalent >= np.sqrt(3) / 2 * equivalent.max()
    return float(tresca(stress[:, near]).max())
