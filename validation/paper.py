"""The paper "A numerical approach to the contact of nominally flat surfaces": figures, and its three steps.

A wave of amplitude Δ and length λ along x and along y; unit pressure P = π E* Δ/λ. Lengths in units of λ, or
of the contact radius a_H in figure 1; pressures in units of E*.
"""

from pathlib import Path

import numpy as np
import xarray as xr

from roughcontact.arguments.choices import ZeroFrequency
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.quantities import number, percent
from roughcontact.contact.elasticity.free_space import TruncatedKernel
from roughcontact.contact.elasticity.halfspace import HalfSpace, zero_frequency_compliance
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.solve import solve_contact
from roughcontact.io.read import read_height_map
from roughcontact.report import map_plots
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.surface.levelling.level import level
from roughcontact.surface.roughness import parameters
from roughcontact.surface.window.periodic_window import periodic_window
from validation import closed_forms, drawing
from validation.lines import Figure, Section
from validation.problems import solve
from validation.surfaces import sum_wave_surface

ROUNDING = 1e-12
_MODULUS = 1e9  # E* of the measured map, Pa
_SERIES = 2048  # waves along each axis in the sum of figure 1
_CELL = 4.5  # of the pressure alone, in radii: its diameter, and the distance where the kernel vanishes
_AMPLITUDE = 0.01  # Δ/λ
_UNIT = np.pi * _AMPLITUDE  # P/E*


def add_lines(section: Section, sample: str | Path, *, finest_grid: int) -> None:
    """Add lines and figures: figures 1 to 3, and the three steps on the measured file `sample`."""
    _figure_1(section, finest_grid)
    _figures_2_and_3(section, finest_grid // 8)
    _three_steps(section, sample)


def full_contact_of_the_wave(points: int, mean_pressure: float, unit: float) -> np.ndarray:
    """Return the pressure in full contact of the paper's wave, p̄ + P [cos(2πx/λ) + cos(2πy/λ)], eq. (4).

    `points` is that of a wavelength, `mean_pressure` is p̄, `unit` P = π E* Δ/λ.

    Examples
    --------
    At p̄ = 2P the hollow just closes.

    >>> full_contact_of_the_wave(4, 2.0, 1.0)[:3, :3].round(6)
    array([[4., 3., 2.],
           [3., 2., 1.],
           [2., 1., 0.]])
    """
    wave = np.cos(2 * np.pi * np.arange(points) / points)
    return mean_pressure + unit * (wave[:, None] + wave[None, :])


def hertz_displacement_on_a_grid(
    period: float, points: int, rule: ZeroFrequency
) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacement by the Hertz pressure of a = p₀ = E* = 1, repeated with a square period.

    It is that of the package's half-space; `period` is in units of the contact radius, and `rule` the one for
    q = 0 of `elasticity.halfspace.zero_frequency_compliance`.

    Returns
    -------
    x : array (points)
    displacement : array (points)
        at (x, 0), the middle of the contact being (0, 0).

    Examples
    --------
    In the middle of a single contact it is π/2, the approach of the spheres.

    >>> x, displacement = hertz_displacement_on_a_grid(16.0, 256, "lattice")
    >>> round(float(displacement[128]), 2)
    1.57
    """
    x = (np.arange(points) - points // 2) * period / points
    inside = 1 - x[None, :] ** 2 - x[:, None] ** 2
    pressure = np.sqrt(np.maximum(inside, 0))
    lengths = (period, period)
    displaced = HalfSpace((points, points), lengths).displacement(pressure)[points // 2]
    return x, displaced + zero_frequency_compliance(rule, lengths=lengths) * pressure.mean()


def hertz_displacement_alone(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Return x and the displacement at (x, 0) by one Hertz pressure of a = p₀ = E* = 1, free boundaries.

    Examples
    --------
    >>> x, displacement = hertz_displacement_alone(256)
    >>> round(float(displacement[128]), 2)
    1.57
    """
    x = (np.arange(points) - points // 2) * _CELL / points
    pressure = np.sqrt(np.maximum(1 - x[None, :] ** 2 - x[:, None] ** 2, 0))
    kernel = TruncatedKernel(2.0)  # the diameter
    shape, lengths = (points, points), (_CELL, _CELL)
    displaced = HalfSpace(shape, lengths, Elasticity(influence=kernel)).displacement(pressure)[points // 2]
    mean = kernel.mean_displacement(shape, (_CELL / points, _CELL / points))
    return x, displaced + mean * pressure.mean()


def hertz_displacement_by_series(x: np.ndarray, period: float, zero_frequency: float) -> np.ndarray:
    """Return the displacement of `hertz_displacement_on_a_grid` by its exact Fourier coefficients.

    Lengths are in units of the contact radius; `zero_frequency` is displacement over mean pressure at q = 0.
    """
    waves = 2 * np.pi * np.arange(_SERIES + 1) / period
    q = np.hypot(waves[:, None], waves[None, :])
    q[0, 0] = 1.0
    coefficients = 2 / q * closed_forms.hertz_spectrum(q, 1.0, 1.0) / period**2
    coefficients[0, 0] = 0
    twice = np.where(waves > 0, 2.0, 1.0)  # the waves of the other signs
    along_x = twice * (twice @ coefficients)
    return np.cos(np.outer(x, waves)) @ along_x + zero_frequency * 2 * np.pi / 3 / period**2


def _figure_1(section: Section, finest_grid: int) -> None:
    """Add lines and figure: displacement by a Hertz pressure repeated with period 2a, and alone."""
    points, period = finest_grid // 4, 2.0
    approach = closed_forms.hertz_displacement(0.0, 1.0, 1.0, 1.0)
    x, found = hertz_displacement_on_a_grid(period, points, "nogi-kato")
    zero = closed_forms.nogi_kato_zero_frequency(period, period, 1.0)
    known = hertz_displacement_by_series(x, period, zero) / approach
    found = found / approach
    x_alone, alone = hertz_displacement_alone(points)
    inside = np.abs(x_alone) <= 1
    x_alone, alone = x_alone[inside], alone[inside] / approach
    formula = closed_forms.hertz_displacement(x_alone, 1.0, 1.0, 1.0) / approach
    radius = points / _CELL
    repeated = section.compare("repeated", found, known, 4 * points**-1.5, n=points)
    single = section.compare("alone", alone, formula, 0.5 * radius**-1.5, n=radius)
    step, few = max(1, points // 64), max(1, x_alone.size // 32)
    image = drawing.chart(
        [("periodic: sum over q", x, known), ("non-periodic: eq. 16, corrected", x_alone, formula)],
        [
            ("periodic, computed", x[::step], found[::step]),
            ("non-periodic, computed", x_alone[::few], alone[::few]),
        ],
        x="x / a_H",
        y="u / δ_H",
        note=f"largest relative deviation {number(max(repeated.deviation, single.deviation), digits=2)}",
    )
    caption = (
        "Displacement along x under a Hertz pressure that repeats with period 2a_H, and under a single one. "
        "The paper's eq. (16) has 2E*a in the denominator, which would put the dashed line at twice its "
        "height: at the middle it must be the Hertz approach, 1 here."
    )
    section.figures.append(Figure("Figure 1", image, caption))


def _wave(points: int) -> xr.DataArray:
    """Return one period of the paper's wave, in units of λ."""
    return sum_wave_surface(
        (points, points), 1 / points, amplitudes=(_AMPLITUDE, _AMPLITUDE), wavelengths=(1.0, 1.0)
    )


def _figures_2_and_3(section: Section, points: int) -> None:
    """Add lines and figures: pressure on the closed wave at p̄ = 2P and 4P, onset of full contact."""
    partly, just, far = solve(_wave(points), [0.6 * _UNIT, 2 * _UNIT, 4 * _UNIT], 1e-8)
    _closed_wave(section, just.pressure, 2, "2 and 3a")
    _closed_wave(section, far.pressure, 4, "3b")
    section.compare("onset", _onset_of_full_contact(), 2.0, 1e-6)
    tolerance = 5e-4 + 0.15 / points
    section.compare("area", partly.area, closed_forms.JGH_CONTACT_SHARE[0.3], tolerance, n=points)


def _closed_wave(section: Section, pressure: np.ndarray, factor: int, figure: str) -> None:
    """Add line and figures of the pressure on the closed wave at p̄ = factor P."""
    points, mean = len(pressure), factor * _UNIT
    pressure, exact = pressure / mean, full_contact_of_the_wave(points, mean, _UNIT) / mean
    line = section.compare("full wave", pressure, exact, ROUNDING, figure=figure, factor=factor)
    note = f"p̄ = {factor}P, largest relative deviation {number(line.deviation, digits=2)}"
    x = np.arange(-points // 2, points // 2) / points  # the crest in the middle, as in the paper
    middle = np.roll(pressure, (points // 2, points // 2), (0, 1))
    if figure.startswith("2"):
        image = drawing.pressure_relief(x, x, middle, labels=("x / λ", "y / λ", "p / p_m"), note=note)
        section.figures.append(Figure("Figure 2", image, "Pressure on one period, computed, at p̄ = 2P."))
    fine = np.linspace(-0.5, 0.5, 201)
    some = slice(None, None, max(1, points // 32))
    image = drawing.chart(
        [("eq. 4", fine, (mean + _UNIT * (np.cos(2 * np.pi * fine) + 1)) / mean)],
        [("computed", x[some], middle[points // 2, some])],
        x="x / λ",
        y="p / p_m",
        note=note,
    )
    caption = f"Pressure along x through a crest at p̄ = {factor}P."
    section.figures.append(Figure(f"Figure {figure[-2:]}", image, caption))


def _onset_of_full_contact(points: int = 64) -> float:
    """Return the least p̄/P at which every point of the wave touches, by bisection."""
    height, low, high = _wave(points), 1.9, 2.1
    while high - low > 1e-7:
        middle = (low + high) / 2
        (contact,) = solve(height, [middle * np.pi * 0.01], 1e-10)
        low, high = (low, middle) if contact.touching.all() else (middle, high)
    return (low + high) / 2


def _three_steps(section: Section, sample: str | Path) -> None:
    """Add lines and figures of a map that goes through the paper's three steps."""
    window = periodic_window(level(read_height_map(sample), form="polynomial"))
    steps = spacing(window)
    unit = _MODULUS * parameters.rms_gradient(window)
    fluctuation = closed_forms.full_contact_fluctuation(window.values, steps, _MODULUS)
    loads = [0.05 * unit, 0.2 * unit, -1.01 * fluctuation.min()]
    contact = solve_contact(window, contact_modulus=_MODULUS, mean_pressure=loads, tolerance=1e-8)
    low, high, full = contact["pressure"].values
    _contact_conditions(section, window, low, 0.05, loads[0])
    _contact_conditions(section, window, high, 0.2, loads[1])
    section.compare("full map", full / loads[2], 1 + fluctuation / loads[2], ROUNDING)
    area = percent(relative_contact_area(low > 0))
    caption = "The sample map, form and outliers off, holes filled, made periodic."
    section.figures.append(
        Figure("Steps 1 and 2: the window", map_plots.height_map(window).source(), caption)
    )
    caption = f"Contact pressure at p̄ = 0.05 E* g, E* = 1 GPa: {area} of the area in contact."
    image = map_plots.pressure_map(window, low).source()
    section.figures.append(Figure("Step 3: the solution of one period", image, caption))


def _contact_conditions(
    section: Section, window: xr.DataArray, pressure: np.ndarray, relative: float, load: float
) -> None:
    """Add the lines of what a solution must satisfy; `load` is the mean pressure in Pa."""
    rms = parameters.rms_height(window)
    gap = closed_forms.gap_left_by(pressure, window.values, spacing(window), _MODULUS) / rms
    for name, value, known in (
        ("mean", pressure.mean() / load, 1.0),
        ("least", min(pressure.min() / load, 0.0), 0.0),
        ("overlap", max(-gap.min(), 0.0), 0.0),
        ("product", (pressure * np.abs(gap)).mean() / load, 0.0),
    ):
        section.compare(name, value, known, 1e-7, load=relative)
