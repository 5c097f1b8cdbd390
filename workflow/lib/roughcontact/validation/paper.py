"""The paper "A numerical approach to the contact of nominally flat surfaces": figures, and its three steps.

A wave of amplitude Δ and length λ along x and along y; unit pressure P = π E* Δ/λ. Lengths in units of λ, or
of the contact radius a_H in figure 1; pressures in units of E*.
"""

from pathlib import Path

import numpy as np

from roughcontact.choices import ZeroFrequency
from roughcontact.contact.solve import solve_contact
from roughcontact.elasticity.halfspace import HalfSpace, zero_frequency_compliance
from roughcontact.io.read import read_height_map
from roughcontact.levelling.level import level
from roughcontact.maps import spacing
from roughcontact.quantities import number, percent
from roughcontact.references import closed_forms, synthetic
from roughcontact.report import map_plots
from roughcontact.roughness import parameters
from roughcontact.statistics.contact_geometry import relative_contact_area
from roughcontact.validation import drawing
from roughcontact.validation.lines import Evidence, Figure, Line, Part, compare, compare_largest
from roughcontact.window.periodic_window import periodic_window

TITLE = "The paper's figures and its three steps"
PAPER = "A numerical approach to the contact of nominally flat surfaces"
ROUNDING = 1e-12
_MODULUS = 1e9  # E* of the measured map, Pa
_SERIES = 2048  # waves along each axis in the sum of figure 1

_CLOSED_FORMS = "tests/unit/test_contact_closed_forms.py"
HERTZ_SERIES = Evidence(
    "u(x) = Σ_q 2/(E*|q|) p̂(q)/L² cos(q·x), p̂ = 2π p₀ a² [sin(qa) − qa cos(qa)]/(qa)³; q = 0: mean of "
    "2/(E*|q|) over its cell (eq. 14)",
    f"{PAPER}, fig. 1, eqs. (9) to (15)",
    "references.closed_forms.hertz_spectrum, references.closed_forms.nogi_kato_zero_frequency",
    "tests/unit/test_reference.py::test_hertz_spectrum_by_quadrature",
)
HERTZ_ALONE = Evidence(
    "u(r) = π p₀ (2a² − r²)/(4 E* a), r ≤ a",
    f"Johnson (1985), eq. (3.41a); {PAPER}, eq. (16), whose 2E*a must read 4E*a",
    "references.closed_forms.hertz_displacement",
    "tests/unit/test_reference.py::test_hertz_displacement_is_the_approach_less_the_sphere",
)
FULL_WAVE = Evidence(
    "p = p̄ + P [cos(2πx/λ) + cos(2πy/λ)], P = π E* Δ/λ, from p̄ = 2P on",
    f"{PAPER}, eqs. (4) and (5), figs. 2 and 3; Johnson (1985), sec. 13.2",
    "validation.paper.full_contact_of_the_wave",
    f"{_CLOSED_FORMS}::test_seed_figures_full_contact_of_the_wave",
)
TURNED = Evidence(
    "the wave turned by 45° is D cos(2πx/λ′) cos(2πy/λ′) with D = 2Δ, λ′ = √2 λ, p* = 2P; A/A₀ = 0.51418 at "
    "p̄ = 0.3 p*",
    "Johnson, Greenwood and Higginson (1985); share by an independent code at 512 × 512, ± 2e-4",
    "references.closed_forms.JGH_CONTACT_SHARE",
    f"{_CLOSED_FORMS}::test_johnson_greenwood_higginson_wave",
)
CONDITIONS = Evidence(
    "p ≥ 0, gap ≥ 0, p · gap = 0, mean(p) = p̄, gap = u − h + const, û = 2 p̂/(E*|q|)",
    f"{PAPER}, sec. 2 and 4; Polonsky and Keer (1999)",
    "references.closed_forms.gap_left_by",
    "tests/unit/test_validation.py::test_the_gap_of_a_pressure_is_that_of_the_solver",
)
FULL_MAP = Evidence(
    "p̂(q) = (E*|q|/2) ĥ(q), q ≠ 0",
    f"{PAPER}, eq. (3), wave by wave; Johnson (1985), sec. 13.2",
    "references.closed_forms.full_contact_fluctuation",
    "tests/unit/test_reference.py::test_full_contact_flattens_the_map",
)


def part(sample: str | Path, *, finest_grid: int) -> Part:
    """Return the lines and figures of this part.

    Parameters
    ----------
    sample : str or Path
        measured file of the three steps.
    finest_grid : int
        points along the finest grid.

    Returns
    -------
    Part
    """
    first = _figure_1(finest_grid)
    waves = _figures_2_and_3(finest_grid // 8)
    steps = _three_steps(sample)
    text = (
        "Figures 1, 2, 3a and 3b of the paper, in its axes: lines are formulas, marks are computed. In full "
        "contact the discrete answer is exact, so that the agreement must be to rounding. Below, the three "
        "steps it proposes (measure, pick a window, solve one period) on the sample map sandblasted.x3p."
    )
    lines, figures = [*first[0], *waves[0], *steps[0]], [*first[1], *waves[1], *steps[1]]
    return Part("paper", TITLE, text, lines, figures)


def full_contact_of_the_wave(points: int, mean_pressure: float, unit: float) -> np.ndarray:
    """Return the pressure in full contact of the paper's wave, p̄ + P [cos(2πx/λ) + cos(2πy/λ)], eq. (4).

    Parameters
    ----------
    points : int
        per wavelength.
    mean_pressure : float, Pa
        p̄.
    unit : float, Pa
        P = π E* Δ/λ.

    Returns
    -------
    array (points, points), Pa

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

    It is that of the package's half-space.

    Parameters
    ----------
    period : float
        in units of the contact radius.
    points : int
        along the period.
    rule : {"zero", "nogi-kato", "lattice"}
        for q = 0, as `elasticity.halfspace.zero_frequency_compliance` has them.

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


def hertz_displacement_by_series(x: np.ndarray, period: float, zero_frequency: float) -> np.ndarray:
    """Return the displacement of `hertz_displacement_on_a_grid` by its exact Fourier coefficients.

    Parameters
    ----------
    x : array (n)
    period : float
        in units of the contact radius.
    zero_frequency : float
        displacement over mean pressure at q = 0.

    Returns
    -------
    array (n)
        at (x, 0).
    """
    waves = 2 * np.pi * np.arange(_SERIES + 1) / period
    q = np.hypot(waves[:, None], waves[None, :])
    q[0, 0] = 1.0
    coefficients = 2 / q * closed_forms.hertz_spectrum(q, 1.0, 1.0) / period**2
    coefficients[0, 0] = 0
    twice = np.where(waves > 0, 2.0, 1.0)  # the waves of the other signs
    along_x = twice * (twice @ coefficients)
    return np.cos(np.outer(x, waves)) @ along_x + zero_frequency * 2 * np.pi / 3 / period**2


def _figure_1(finest_grid: int) -> tuple[list[Line], list[Figure]]:
    """Return lines and figure: displacement by a Hertz pressure repeated with period 2a, and alone."""
    points, alone_points = finest_grid // 4, finest_grid
    period, wide = 2.0, 32.0
    x, found = hertz_displacement_on_a_grid(period, points, "nogi-kato")
    known = hertz_displacement_by_series(
        x, period, closed_forms.nogi_kato_zero_frequency(period, period, 1.0)
    )
    x_alone, alone = hertz_displacement_on_a_grid(wide, alone_points, "lattice")
    inside = np.abs(x_alone) <= 1
    x_alone, alone = x_alone[inside], alone[inside]
    formula = closed_forms.hertz_displacement(x_alone, 1.0, 1.0, 1.0)
    approach = closed_forms.hertz_displacement(0.0, 1.0, 1.0, 1.0)
    radius = alone_points / wide
    periodic = compare_largest(
        "Fig. 1: displacement under a Hertz pressure repeated with period 2a",
        found / approach,
        known / approach,
        tolerance=4 * points**-1.5,
        reason=f"sampling of the root at the edge, 4/n^1.5, n = {points}",
        evidence=HERTZ_SERIES,
    )
    single = compare_largest(
        f"Fig. 1: displacement under a single Hertz pressure (period {wide:g}a)",
        alone / approach,
        formula / approach,
        tolerance=0.5 * radius**-1.5 + wide**-3,
        reason=f"sampling, 0.5/n^1.5 with n = {radius:g} points per radius, and the neighbours, (a/L)³",
        evidence=HERTZ_ALONE,
    )
    step = max(1, points // 64)
    few = max(1, x_alone.size // 32)
    image = drawing.chart(
        [
            ("periodic: sum over q", x, known / approach),
            ("non-periodic: eq. 16, corrected", x_alone, formula / approach),
        ],
        [
            ("periodic, computed", x[::step], found[::step] / approach),
            ("non-periodic, computed", x_alone[::few], alone[::few] / approach),
        ],
        x="x / a_H",
        y="u / δ_H",
        note=f"largest relative deviation {number(max(periodic.deviation, single.deviation), digits=2)}",
    )
    caption = (
        "Displacement along x under a Hertz pressure that repeats with period 2a_H, and under a single one. "
        "The paper's eq. (16) has 2E*a in the denominator, which would put the dashed line at twice its "
        "height: at the middle it must be the Hertz approach, 1 here."
    )
    return [periodic, single], [Figure("Figure 1", image, caption)]


def _figures_2_and_3(points: int) -> tuple[list[Line], list[Figure]]:
    """Return lines and figures: pressure on the closed wave at p̄ = 2P and 4P, onset of full contact."""
    amplitude = 0.01
    unit = np.pi * amplitude
    height = synthetic.sum_wave_surface(
        (points, points), 1 / points, amplitudes=(amplitude, amplitude), wavelengths=(1.0, 1.0)
    )
    loads = [0.6 * unit, 2 * unit, 4 * unit]
    contact = solve_contact(height, contact_modulus=1.0, mean_pressure=loads, tolerance=1e-8)
    pressures = contact["pressure"].values
    lines, figures = [], []
    x = np.arange(-points // 2, points // 2) / points  # the crest in the middle, as in the paper
    for load, factor, letter in ((1, 2, "a"), (2, 4, "b")):
        exact = full_contact_of_the_wave(points, factor * unit, unit)
        line = compare_largest(
            f"Fig. {'2 and 3a' if factor == 2 else '3b'}: pressure at p̄ = {factor}P, every point",
            pressures[load] / loads[load],
            exact / loads[load],
            tolerance=ROUNDING,
            reason="rounding: the discrete answer is exact",
            evidence=FULL_WAVE,
        )
        lines.append(line)
        note = f"p̄ = {factor}P, largest relative deviation {number(line.deviation, digits=2)}"
        middle = np.roll(pressures[load], (points // 2, points // 2), (0, 1)) / loads[load]
        if factor == 2:
            image = drawing.pressure_relief(x, x, middle, labels=("x / λ", "y / λ", "p / p_m"), note=note)
            figures.append(Figure("Figure 2", image, "Pressure on one period, computed, at p̄ = 2P."))
        fine = np.linspace(-0.5, 0.5, 201)
        image = drawing.chart(
            [("eq. 4", fine, (factor * unit + unit * (np.cos(2 * np.pi * fine) + 1)) / loads[load])],
            [("computed", x[:: max(1, points // 32)], middle[points // 2, :: max(1, points // 32)])],
            x="x / λ",
            y="p / p_m",
            note=note,
        )
        figures.append(
            Figure(f"Figure 3{letter}", image, f"Pressure along x through a crest at p̄ = {factor}P.")
        )
    lines.append(
        compare(
            "Eq. (5): least p̄/P that closes every point",
            _onset_of_full_contact(),
            2.0,
            tolerance=1e-6,
            reason="bisection to 1e-7; the hollow lies on a point of the grid",
            evidence=FULL_WAVE,
        )
    )
    lines.append(
        compare(
            "Below eq. (5), p̄ = 0.6P: contact area",
            relative_contact_area(pressures[0] > 0),
            closed_forms.JGH_CONTACT_SHARE[0.3],
            measure="absolute",
            tolerance=5e-4 + 0.15 / points,
            reason=f"5e-4 of the reference at worst, and 0.15/n, n = {points}",
            evidence=TURNED,
        )
    )
    return lines, figures


def _onset_of_full_contact(points: int = 64) -> float:
    """Return the least p̄/P at which every point of the wave touches, by bisection."""
    height = synthetic.sum_wave_surface(
        (points, points), 1 / points, amplitudes=(0.01, 0.01), wavelengths=(1.0, 1.0)
    )
    low, high = 1.9, 2.1
    while high - low > 1e-7:
        middle = (low + high) / 2
        contact = solve_contact(
            height, contact_modulus=1.0, mean_pressure=middle * np.pi * 0.01, tolerance=1e-10
        )
        closed = bool((contact["contact"] > 0).all())
        low, high = (low, middle) if closed else (middle, high)
    return (low + high) / 2


def _three_steps(sample: str | Path) -> tuple[list[Line], list[Figure]]:
    """Return lines and figures of a map that goes through the paper's three steps."""
    window = periodic_window(level(read_height_map(sample), form="polynomial"))
    steps, rms = spacing(window), parameters.rms_height(window)
    unit = _MODULUS * parameters.rms_gradient(window)
    fluctuation = closed_forms.full_contact_fluctuation(window.values, steps, _MODULUS)
    loads = [0.05 * unit, 0.2 * unit, -1.01 * fluctuation.min()]
    contact = solve_contact(window, contact_modulus=_MODULUS, mean_pressure=loads, tolerance=1e-8)
    pressures = contact["pressure"].values
    lines = []
    for load, pressure, name in zip(loads[:2], pressures[:2], ("0.05", "0.2"), strict=True):
        gap = closed_forms.gap_left_by(pressure, window.values, steps, _MODULUS) / rms
        checks = (
            ("mean pressure over the prescribed one", pressure.mean() / load, 1.0),
            ("least pressure over the mean", min(pressure.min() / load, 0.0), 0.0),
            ("deepest overlap over the rms height", max(-gap.min(), 0.0), 0.0),
            ("Σ p·gap over Σ p × rms height", (pressure * np.abs(gap)).mean() / load, 0.0),
        )
        lines += [
            compare(
                f"Measured map, p′ = {name}: {what}",
                value,
                known,
                measure="absolute",
                tolerance=1e-7,
                reason="ten times the solver's tolerance of 1e-8",
                evidence=CONDITIONS,
            )
            for what, value, known in checks
        ]
    lines.append(
        compare_largest(
            "Measured map, full contact: pressure at every point",
            pressures[2] / loads[2],
            1 + fluctuation / loads[2],
            tolerance=ROUNDING,
            reason="rounding: the discrete answer is exact",
            evidence=FULL_MAP,
        )
    )
    area = percent(relative_contact_area(pressures[0] > 0))
    figures = [
        Figure(
            "Steps 1 and 2: the window",
            map_plots.height_map(window),
            "The sample map, form and outliers off, holes filled, made periodic.",
        ),
        Figure(
            "Step 3: the solution of one period",
            map_plots.pressure_map(window, pressures[0]),
            f"Contact pressure at p̄ = 0.05 E* g, E* = 1 GPa: {area} of the area in contact.",
        ),
    ]
    return lines, figures
