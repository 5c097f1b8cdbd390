"""Flow of a thin viscous fluid through the gap: the flow factors of Reynolds' equation."""

import math
from collections import deque
from collections.abc import Mapping
from functools import partial
from itertools import islice

import numpy as np
import numpy.typing as npt

from roughcontact.statistics.sealing.connectivity import connected_regions
from roughcontact.statistics.sealing.gas import slip_factor
from roughcontact.statistics.sealing.multigrid import Network, Solver, factorised, minimised, multigrid

_MAX_STEPS = 500
# steps of the multigrid after which a network of at most so many points is factorised, in up to 1600 bytes a
# point: of 432 x 576 points in light contact 13 steps take 0.7 s and factors 2.7 s, of a third in contact 500
# steps 66 s and factors 0.7 s
_FEW_STEPS, _MAX_FACTORISED = 20, 2**20
_STEPS_COMPARED = 4  # steps that together must gain next to nothing
_GAINED = 0.1  # share of the tolerance that they may gain: where convergence is slow, more is left


def flow_columns(gap: np.ndarray, steps: tuple[float, float], *, tolerance: float = 1e-7) -> dict[str, float]:
    """Return the flow factors of a periodic gap (ny, nx; m): its flow over that of plates at its mean.

    The flux of a thin viscous fluid is -g³/(12 η) ∇P with ∇·(g³ ∇P) = 0 (Patir and Cheng 1978, ASME J. Lubr.
    Technol. 100, 12), Φ ū³/(12 η) times the mean gradient. Φ is a symmetric tensor, 0 along an axis without
    percolation, NaN where the last steps still change it by more than `tolerance`. `shear_flow_x`,
    `shear_flow_y`, the shares of the mean gap whose fluid moves with a sliding rough face rather than at half
    its speed, are by reciprocity 1 - <g G>/<g>, G the pressure gradient over its mean (Patir and Cheng 1979,
    ASME J. Lubr. Technol. 101, 220), within 2e-4 on 640 gaps; 1 without percolation. Two neighbours of
    constant height conduct in series, exact for channels along the axes; where paths are a pixel wide the
    factors are correct only to an order of magnitude.
    """
    gap = np.asarray(gap, float)  # that of a single precision is too coarse for the tolerance
    region, around = connected_regions(gap > 0)
    axes = np.flatnonzero(around.any(axis=0))
    factors, driven = np.zeros((2, 2)), np.zeros(2)
    if axes.size:
        is_open = around[region].any(axis=-1)  # pockets that no flow passes have no part in it
        open_gap = np.where(is_open, gap, 0) / gap.mean()
        factors[np.ix_(axes, axes)], driven[axes] = _tensor(open_gap, steps, axes, tolerance)
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
    outlet_pressure: float | None = None,
    mean_free_path: float | None = None,
) -> dict[str, np.ndarray]:
    """Return the leak rate per length of a seal (m2/s) along x and y: Φ ū³ Δp/(12 η w).

    ū and w in m, the viscosity η in Pa s, Δp in Pa. An ideal gas, behind whose seal is the pressure p₂ of its
    outlet (Pa), leaks (p₁² - p₂²)/(2 p₂) instead of Δp in volume at p₂, by Darcy's law; with its mean free
    path (m) at p₂ it slips (`slip_factor`), at the narrowest place, a column of `flow_factors`, and at the
    mean pressure.

    Examples
    --------
    Water between plates 1 µm apart, 1 bar over 10 mm:

    >>> plates = {"flow_factor_xx": 1.0, "flow_factor_yy": 1.0}
    >>> found = leak_columns(1e-6, plates, viscosity=1e-3, pressure_difference=1e5, width=1e-2)
    >>> print(f"{found['leak_rate_x'] * 1e6 * 3600:.2f} ml per hour and metre")
    3.00 ml per hour and metre
    """
    # an ideal gas expands along the way: its mean density is that between inlet and outlet
    expansion = 1 + pressure_difference / (2 * outlet_pressure) if outlet_pressure else 1.0
    by_flow = np.asarray(mean_gap, float) ** 3 * pressure_difference * expansion / (12 * viscosity * width)
    path = (mean_free_path or 0.0) / expansion
    return {
        f"leak_rate_{axis}": by_flow
        * np.asarray(flow_factors[f"flow_factor_{axis}{axis}"])
        * (slip_factor(flow_factors[f"critical_constriction_{axis}"], path) if path else 1.0)
        for axis in "xy"
    }


def _tensor(
    gap: np.ndarray, steps: tuple[float, float], axes: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return along some axes the flow factors of a gap in units of its mean, and <g G> of each axis."""
    cubes = gap**3
    is_open = cubes >= np.finfo(float).tiny  # the cube of a gap may underflow
    unknowns = int(is_open.sum())
    number = np.empty(gap.shape, int)
    number[is_open] = np.arange(unknowns)
    links = []
    for axis in (0, 1):
        ahead = np.roll(cubes, -1, axis)
        is_link = is_open & np.roll(is_open, -1, axis)
        cubed_gap, cubed_ahead = cubes[is_link], ahead[is_link]
        # half a cell of each in series; the product of the cubes may underflow
        share = cubed_ahead / (cubed_gap + cubed_ahead)
        conductance = 2 * cubed_gap * share * steps[1 - axis] / steps[axis]
        # half the sum of both gaps, over the width of the link: what a sliding face carries through it
        mean_gap = (gap[is_link] + np.roll(gap, -1, axis)[is_link]) / 2 * steps[1 - axis]
        links.append((number[is_link], np.roll(number, -1, axis)[is_link], conductance, mean_gap))
    start, stop, conductance = (np.concatenate([link[side] for link in links]) for side in range(3))
    network = Network(start, stop, conductance, unknowns)
    solver = multigrid(network, np.argwhere(is_open))
    max_steps = _FEW_STEPS if unknowns <= _MAX_FACTORISED else _MAX_STEPS
    count = links[0][2].size
    sides = slice(count), slice(count, None)
    drops, driven = np.empty((axes.size, conductance.size)), np.empty(axes.size)
    for row, axis in enumerate(axes):
        uniform_drop, carried = np.zeros((2, conductance.size))  # over each link, for a unit gradient
        uniform_drop[sides[axis]] = steps[axis]
        carried[sides[axis]] = links[axis][3]
        solve = partial(_driven_flow, network, uniform_drop, carried, tolerance=tolerance)
        drops[row], driven[row] = solve(solver, max_steps=max_steps)
        if max_steps < _MAX_STEPS and np.isnan(driven[row]):
            solver, max_steps = (solver[0], factorised(solver[0])), _MAX_STEPS  # for the other axis as well
            drops[row], driven[row] = solve(solver, max_steps=max_steps)
    area = gap.size * steps[0] * steps[1]
    return (conductance * drops) @ drops.T / area, driven / area


def _driven_flow(
    network: Network,
    uniform_drop: np.ndarray,
    carried: np.ndarray,
    solver: Solver,
    *,
    tolerance: float,
    max_steps: int,
) -> tuple[np.ndarray, float]:
    """Return the pressure drops over the links for uniform ones, and the sum of what they drive.

    `carried` is what a sliding face carries through each link for a unit pressure drop over it. NaN where the
    energy, or this sum, which is linear in the pressure and so less exact, do not settle.
    """
    uniform_flow, response = float(carried @ uniform_drop), network.inflow(carried)
    energy = float((network.conductance * uniform_drop) @ uniform_drop)
    gains: deque[float] = deque(maxlen=_STEPS_COMPARED)
    driven: deque[float] = deque(maxlen=_STEPS_COMPARED)
    matrix, cycle = solver
    steps = minimised(matrix, -network.inflow(network.conductance * uniform_drop), cycle)
    for pressure, gain, _ in islice(steps, max_steps):
        energy -= gain
        if not math.isfinite(energy):
            break  # rounding alone: NaN says so
        gains.append(gain)
        driven.append(uniform_flow + float(response @ pressure))
        if (
            len(gains) == _STEPS_COMPARED
            and sum(gains) <= _GAINED * tolerance * energy
            and max(driven) - min(driven) <= tolerance * uniform_flow
        ):
            return uniform_drop + pressure[network.stop] - pressure[network.start], driven[-1]
    return np.full_like(uniform_drop, np.nan), math.nan
