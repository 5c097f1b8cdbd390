"""Flow of a thin viscous fluid through the gap: the flow factors of Reynolds' equation."""

from collections import deque
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from roughcontact.sealing.connectivity import connected_regions
from roughcontact.sealing.multigrid import minimised, multigrid

_MAX_STEPS = 500
_STEPS_COMPARED = 4  # steps that together must gain no more than the tolerance


def flow_columns(gap: np.ndarray, steps: tuple[float, float], *, tolerance: float = 1e-5) -> dict[str, float]:
    """Return the flow factors of a periodic gap: its flow over that between parallel plates at its mean.

    The flux of a thin viscous fluid is -g³/(12 η) ∇P, and ∇·(g³ ∇P) = 0 [1]_. Under a mean pressure gradient,
    with fluctuations of the period of the map, the mean flux is Φ ū³/(12 η) times that gradient; Φ is a
    symmetric tensor, because a lay deflects the fluid sideways. Points in contact are impermeable, and so are
    points whose region does not run around the period.

    Points are cells of constant height; two neighbours conduct in series. The result is exact for channels
    along the axes, both across and along them. The narrowest places of a path dominate: where they are a
    pixel wide, the factors are correct only to an order of magnitude. The pressure is found by conjugate
    gradients with multigrid; the flow decreases with every step.

    `gap` (ny, nx) in m: periodic; zero or less where the surfaces touch; `steps` (dy, dx) in m: pitch of the
    points; `tolerance`: largest total change of each of the two diagonal factors in the last four steps of
    the iteration, relative to the factor. Returns `flow_factor_xx`, `flow_factor_yy`, `flow_factor_xy`; 0
    along an axis without percolation, NaN where the iteration does not reach its tolerance. `shear_flow_x`
    and `shear_flow_y` are the shares of the mean gap whose fluid moves with a sliding rough face rather than
    with half its speed: 1 - <g G>/<g>, G the pressure gradient over its mean, since by reciprocity the flow
    that a sliding face drives follows from that which a pressure drives; 1 without percolation [2]_.

    References
    ----------
    .. [1] Patir and Cheng (1978), An average flow model for determining effects of three-dimensional
       roughness on partial hydrodynamic lubrication, ASME J. Lubr. Technol. 100, 12.
    .. [2] Patir and Cheng (1979), Application of average flow model to lubrication between rough sliding
       surfaces, ASME J. Lubr. Technol. 101, 220.

    Examples
    --------
    Ridges across x hinder a flow along x, and help one along y:

    >>> import numpy as np
    >>> gap = (1 + 0.5 * np.cos(2 * np.pi * np.arange(64) / 64)) * np.ones((4, 1))
    >>> found = flow_columns(gap, (1e-6, 1e-6))
    >>> print(f"{found['flow_factor_xx']:.4f} {found['flow_factor_yy']:.4f}")
    0.4330 1.3750
    """
    region, around = connected_regions(gap > 0)
    axes = np.flatnonzero(around.any(axis=0))
    factors, driven = np.zeros((2, 2)), np.zeros(2)
    if axes.size:
        is_open = around[region].any(axis=-1)
        factors[np.ix_(axes, axes)], driven[axes] = _tensor(
            np.where(is_open, gap, 0) / gap.mean(), steps, axes, tolerance
        )
    return {
        "flow_factor_xx": factors[1, 1],
        "flow_factor_yy": factors[0, 0],
        "flow_factor_xy": factors[0, 1],
        "shear_flow_x": round(1 - driven[1], 12),  # along ridges it is rounding
        "shear_flow_y": round(1 - driven[0], 12),
    }


def leak_columns(
    mean_gap: npt.ArrayLike,
    flow_factors: Mapping[str, npt.ArrayLike],
    *,
    viscosity: float,
    pressure_difference: float,
    width: float,
) -> dict[str, np.ndarray]:
    """Return the leak rate of a seal of the surface per length of the seal: Φ ū³ Δp/(12 η w).

    Parameters
    ----------
    mean_gap : array, m
        ū.
    flow_factors : mapping
        `flow_factor_xx` and `flow_factor_yy`, arrays of the shape of `mean_gap`.
    viscosity : float, Pa s
        η, dynamic, of an incompressible Newtonian fluid.
    pressure_difference : float, Pa
        Δp, between both sides of the seal.
    width : float, m
        w, of the seal in the direction of the flow.

    Returns
    -------
    dict of array
        `leak_rate_x`, `leak_rate_y`: volume by time and by length of the seal, m2 s-1, for a flow along x and
        along y.

    Examples
    --------
    Water between plates 1 µm apart, 1 bar over 10 mm:

    >>> plates = {"flow_factor_xx": 1.0, "flow_factor_yy": 1.0}
    >>> found = leak_columns(1e-6, plates, viscosity=1e-3, pressure_difference=1e5, width=1e-2)
    >>> print(f"{found['leak_rate_x'] * 1e6 * 3600:.2f} ml per hour and metre")
    3.00 ml per hour and metre
    """
    by_flow = np.asarray(mean_gap, float) ** 3 * pressure_difference / (12 * viscosity * width)
    return {
        f"leak_rate_{axis}": by_flow * np.asarray(flow_factors[f"flow_factor_{axis}{axis}"]) for axis in "xy"
    }


def _tensor(
    gap: np.ndarray, steps: tuple[float, float], axes: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return along some axes the flow factors of a gap in units of its mean, and <g G> of each axis."""
    cubed = gap**3
    is_open = cubed >= np.finfo(float).tiny
    unknowns = int(is_open.sum())
    number = np.empty(gap.shape, int)
    number[is_open] = np.arange(unknowns)
    links = []
    for axis in (0, 1):
        ahead = np.roll(cubed, -1, axis)
        linked = is_open & np.roll(is_open, -1, axis)
        cubed_gap, cubed_ahead = cubed[linked], ahead[linked]
        # half a cell of each in series; the product of the cubes may underflow
        conductance = (
            2 * cubed_gap * (cubed_ahead / (cubed_gap + cubed_ahead)) * steps[1 - axis] / steps[axis]
        )
        # half the sum of both gaps, over the width of the link: what a sliding face carries through it
        carried = (gap[linked] + np.roll(gap, -1, axis)[linked]) / 2 * steps[1 - axis]
        links.append((number[linked], np.roll(number, -1, axis)[linked], conductance, carried))
    start, end = (np.concatenate([link[side] for link in links]) for side in (0, 1))
    conductance = np.concatenate([link[2] for link in links])
    # mean pressure drop over each link, for a unit gradient along each of the axes
    drops = np.zeros((conductance.size, axes.size))
    first = links[0][2].size
    sides, carried = (slice(first), slice(first, None)), [link[3] for link in links]
    for column, axis in enumerate(axes):
        drops[sides[axis], column] = steps[axis]
    root = np.sqrt(conductance)
    rows = np.tile(np.arange(root.size), 2)
    difference = sp.coo_array(
        (np.concatenate([-root, root]), (rows, np.concatenate([start, end]))), shape=(root.size, unknowns)
    ).tocsr()
    drops *= root[:, None]
    # what a sliding face drives is linear in the pressure, and so less exact than the energy: watched, too
    weights = np.zeros_like(drops)
    for column, axis in enumerate(axes):
        weights[sides[axis], column] = carried[axis] / root[sides[axis]]
    undisturbed, response = (weights * drops).sum(axis=0), difference.T @ weights
    energy = (drops**2).sum(axis=0)
    gains: deque[np.ndarray] = deque(maxlen=_STEPS_COMPARED)
    driven: deque[np.ndarray] = deque(maxlen=_STEPS_COMPARED)
    matrix, cycle = multigrid(difference, np.argwhere(is_open))
    solutions = minimised(matrix, -(difference.T @ drops), cycle)
    for step, (pressure, gain) in enumerate(solutions):
        gains.append(gain)
        energy -= gain
        driven.append(undisturbed + (response * pressure).sum(axis=0))
        if (
            len(gains) == _STEPS_COMPARED
            and (sum(gains) <= tolerance * energy).all()
            and (np.ptp(driven, axis=0) <= tolerance * undisturbed).all()
        ):
            drops += difference @ pressure
            area = gap.size * steps[0] * steps[1]
            return drops.T @ drops / area, driven[-1] / area
        if step == _MAX_STEPS or not np.isfinite(energy).all():
            break
    return np.full((axes.size, axes.size), np.nan), np.full(axes.size, np.nan)
