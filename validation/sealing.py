"""Sealing: flow through channels, what two phases conduct, and the contact area at which a gap closes."""

import numpy as np
import xarray as xr
from scipy.integrate import quad
from scipy.optimize import brentq

from roughcontact.arguments.maps import spacing
from roughcontact.arguments.quantities import number, percent
from roughcontact.contact.solve import solve_contact
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.statistics.sealing.connectivity import percolates
from roughcontact.statistics.sealing.flow import flow_columns, leak_columns
from roughcontact.statistics.sealing.percolation import percolation_columns
from roughcontact.surface.roughness.parameters import rms_gradient
from roughcontact.surface.synthetic import self_affine_surface
from validation import closed_forms
from validation.lines import Section, Table
from validation.problems import AMPLITUDE, Solution, solve, solved_ridges

_ROW = 256  # points across a channel along an axis, where the answer is exact
_SEEDS = 8
_SEAL = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-2}  # water, 1 bar, 10 mm
_LOADS = (0.02, 0.05, 0.1, 0.15, 0.2)


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add lines and table: gaps on grids an eighth as fine, random heights on a quarter."""
    points = finest_grid // 8
    _channels(section, points)
    _two_phases(section, points)
    _low_roughness(section, points)
    _gaussian_roughness(section)
    _leaks(section, points)
    _random_heights(section, 2 * points)
    _closing(section)
    section.tables.append(_effective_medium())


def _channels(section: Section, points: int) -> None:
    """Add the lines of channels along an axis, and at 45° on a square of so many points a side."""
    x, row = (2 * np.pi * np.arange(n) / n for n in (points, _ROW))
    steps = (1 / points, 1 / points)
    for depth in (0.5, 0.9):
        along, across = closed_forms.channel_flow_factors(depth)
        computed = flow_columns((1 + depth * np.cos(row)) * np.ones((8, 1)), steps, tolerance=1e-9)
        section.compare("channel along", computed["flow_factor_yy"], along, 1e-8, depth=depth)
        section.compare("channel across", computed["flow_factor_xx"], across, 1e-8, depth=depth)
        fine = 1 + depth * np.cos(2 * np.pi * np.arange(4 * _ROW) / (4 * _ROW))
        share = flow_columns(fine[None], (1.0, 1.0), tolerance=1e-9)["shear_flow_x"]
        section.compare("driven", share, closed_forms.driven_share(depth), 1e-5, depth=depth)
    along, across = closed_forms.channel_flow_factors(0.5)
    computed = flow_columns(1 + 0.5 * np.cos(x[:, None] + x[None, :]), steps, tolerance=1e-9)
    for axes, expected in (("xx", (along + across) / 2), ("xy", (across - along) / 2)):
        section.compare(
            "diagonal", computed[f"flow_factor_{axes}"], expected, 100 / points**2, axes=axes, n=points
        )


def _two_phases(section: Section, points: int) -> None:
    """Add the lines of a checkerboard, and of the narrowest place between crossed waves."""
    board = np.where((np.indices((points, points)) // (points // 2)).sum(axis=0) % 2, 1.0, 3.0) ** (1 / 3)
    factor = flow_columns(board, (1 / points, 1 / points), tolerance=1e-9)["flow_factor_xx"]
    section.compare("board", factor * board.mean() ** 3, np.sqrt(3), 0.5 * points**-1.2, n=points)
    x = 2 * np.pi * np.arange(points) / points
    crossed = 1 + (np.cos(x)[:, None] + np.cos(x)[None, :]) / 2
    section.compare("saddle", percolation_columns(crossed)["critical_constriction_x"], 1.0, 1e-12)


def gaussian_heights(along: int, across: int, *, points: int, seed: int) -> np.ndarray:
    """Return normally distributed heights with an rms of 1, correlated linearly up to so many points."""
    lag = np.minimum(np.arange(points), points - np.arange(points))
    correlation = np.maximum(1 - lag[:, None] / across, 0) * np.maximum(1 - lag / along, 0)
    noise = np.fft.fft2(np.random.default_rng(seed).standard_normal((points, points)))
    height = np.fft.ifft2(noise * np.sqrt(np.maximum(np.fft.fft2(correlation).real, 0))).real
    return (height - height.mean()) / height.std()


def _gaussian_roughness(section: Section) -> None:
    """Add the lines of Gaussian roughness with a linear correlation, as Patir and Cheng made theirs."""
    for gamma, along, across in ((1 / 9, 6, 54), (1.0, 16, 16), (9.0, 54, 6)):
        for gap in (3.0, 6.0):
            factors = []
            for seed in range(_SEEDS // 2):
                local = np.maximum(gap + gaussian_heights(along, across, points=_ROW, seed=seed), 0)
                factor = flow_columns(local, (1.0, 1.0), tolerance=1e-5)["flow_factor_xx"]
                factors.append(factor * (local.mean() / gap) ** 3)
            expected = closed_forms.patir_cheng_flow_factor(gap, gamma)
            section.compare(
                "gaussian",
                np.mean(factors),
                expected,
                0.03 if gamma >= 1 else 0.08,
                gamma=f"{along}:{across}",
                gap=gap,
                maps=len(factors),
            )


def _low_roughness(section: Section, points: int) -> None:
    """Add the lines of a gap with roughness of a twentieth of it."""
    relative = 0.05
    height = self_affine_surface(
        (points, points), 1.0, hurst=0.8, shortest=8.0, longest=points / 4, rms_height=relative
    )
    gap = 1 + height.values
    factors = flow_columns(gap, (1.0, 1.0), tolerance=1e-9)
    mean = (factors["flow_factor_xx"] + factors["flow_factor_yy"]) / 2
    expected = closed_forms.isotropic_flow_factor(relative) - 1
    section.compare("low", mean - 1, expected, relative)
    section.compare("medium", closed_forms.effective_medium_flow_factor(gap) - 1, expected, relative)


def _leaks(section: Section, points: int) -> None:
    """Add the lines of leak rates: between plates, and along the gap of ridges that touch."""
    expected = 1e-18 * _SEAL["pressure_difference"] / (12 * _SEAL["viscosity"] * _SEAL["width"])
    plates = leak_columns(1e-6, flow_columns(np.full((4, 4), 1e-6), (1e-6, 1e-6)), **_SEAL)
    section.compare("slit", plates["leak_rate_x"], expected, 1e-12)
    for ratio, contact in solved_ridges(points, (0.1, 0.5)).items():
        gap = _open_gap(contact)
        leak = leak_columns(gap.mean(), flow_columns(gap, contact.pixel), **_SEAL)["leak_rate_y"]
        cubed, _ = quad(
            lambda x, ratio=ratio: closed_forms.westergaard_gap(x, 1.0, AMPLITUDE, ratio) ** 3, 0.0, 0.5
        )
        relative = leak / (expected * (AMPLITUDE / 1e-6) ** 3)
        section.compare("ridges", relative, 2 * cubed / AMPLITUDE**3, 20 / points**2, r=ratio, n=points)


def _open_gap(contact: Solution) -> np.ndarray:
    """Return the gap of a contact, zero where it touches."""
    return np.where(contact.touching, 0.0, contact.gap)


def _random_heights(section: Section, points: int) -> None:
    """Add the line of the threshold at which random heights percolate: mean over maps and axes."""
    levels = [
        list(percolation_columns(np.random.default_rng(seed).random((points, points))).values())[2:]
        for seed in range(_SEEDS)
    ]
    tolerance = 3 * (0.7 * points**-0.75 / np.sqrt(2 * _SEEDS))
    fields = {"maps": _SEEDS, "values": 2 * _SEEDS, "n": points}
    section.compare("sites", 1 - np.mean(levels), 0.592746, tolerance, **fields)


def _isotropic(seed: int) -> xr.DataArray:
    """Return a surface with two octaves of waves."""
    return self_affine_surface(
        (256, 256), 1.0, hurst=0.8, shortest=8.0, longest=32.0, rms_height=1e-3, seed=seed
    )


def _closing(section: Section) -> None:
    """Add the line of the contact area at which gaps close: mean of some small surfaces."""
    areas = [_closing_area(seed) for seed in range(_SEEDS)]
    scatter = number(float(np.std(areas, ddof=1)), digits=2)
    section.compare("closing", np.mean(areas), 0.42, 0.03, maps=_SEEDS, scatter=scatter)


def _closing_area(seed: int) -> float:
    """Return the contact area at which the gap of one surface closes."""
    height = _isotropic(seed)
    gradient = rms_gradient(height)

    def touching(relative: float) -> np.ndarray:
        (contact,) = solve(height, [relative * gradient], 1e-3)
        return contact.touching

    closed = brentq(
        lambda relative: 1.0 if any(percolates(~touching(relative))) else -1.0, 0.1, 0.4, xtol=1e-3
    )
    return relative_contact_area(touching(closed))


def _effective_medium() -> Table:
    """Return the table of flow factors beside those of Bruggeman's effective medium."""
    height = _isotropic(seed=0)
    loads = [relative * rms_gradient(height) for relative in _LOADS]
    contact = solve_contact(height, contact_modulus=1.0, mean_pressure=loads)
    rows = []
    for pressure, gap in zip(contact["pressure"].values, contact["gap"].values, strict=True):
        open_gap = np.where(pressure > 0, 0.0, gap)
        factors = flow_columns(open_gap, spacing(height))
        medium = closed_forms.effective_medium_flow_factor(open_gap)
        values = (factors["flow_factor_xx"], factors["flow_factor_yy"], medium)
        rows.append((percent(relative_contact_area(pressure > 0)), *map(number, values)))
    return Table(
        "Flow factors beside Bruggeman's effective medium",
        ("contact area", "Φxx", "Φyy", "effective medium"),
        rows,
        "The effective medium of Dapp, Lücke, Persson and Müser (2012), Phys. Rev. Lett. 108, 244301, in two "
        "dimensions: Σ (g³ − s)/(g³ + s) = 0, closed from half contact on. One isotropic surface.",
    )
