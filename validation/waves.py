"""Regular waves: Westergaard's ridges, and the product wave of Johnson, Greenwood and Higginson."""

import numpy as np

from roughcontact.arguments.quantities import number
from validation import closed_forms, drawing
from validation.lines import Figure, Section
from validation.problems import (
    AMPLITUDE,
    RIDGES_CLOSED,
    WAVE_CLOSED,
    Solution,
    product_wave,
    ridge,
    solve,
)

_LOW, _HIGH = 0.002, 0.98  # loads at which the product wave is compared with its asymptotes


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines and figures of a row of ridges, and of the product wave on a grid half as fine."""
    _ridges(section, finest_grid)
    _crests(section, finest_grid // 2)


def _ridges(section: Section, points: int) -> None:
    """Add lines and figure of Westergaard's wave, one row of `points` points."""
    x, height = ridge(points)
    ratios = (0.05, 0.3, 0.5, 0.9, 1.0, 2.0)
    contacts = solve(height, [ratio * RIDGES_CLOSED for ratio in ratios], 1e-9)
    solved = dict(zip(ratios, contacts, strict=True))
    for ratio, contact in solved.items():
        if ratio < 1:
            _partly_closed(section, ratio, x, contact)
            continue
        exact = closed_forms.westergaard_pressure(x, 1.0, ratio * RIDGES_CLOSED, ratio)
        section.compare(
            "closed pressure", contact.pressure[0] / RIDGES_CLOSED, exact / RIDGES_CLOSED, 1e-12, r=ratio
        )
        section.compare("closed energy", *_energies(ratio, contact), 1e-12, r=ratio)
    centred = (x + 0.5) % 1 - 0.5
    thin = np.argsort(centred)[:: max(1, points // 128)]
    fine = np.linspace(-0.5, 0.5, 801)
    open_ratios = [ratio for ratio in ratios if ratio < 1]
    exact_lines = [(fine, closed_forms.westergaard_pressure(fine, 1.0, r, r)) for r in open_ratios]
    image = drawing.chart(
        [("closed form", *exact_lines[0])],
        [
            (f"computed, r = {r:g}", centred[thin], solved[r].pressure[0, thin] / RIDGES_CLOSED)
            for r in open_ratios
        ],
        x="x / λ",
        y="p / p*",
        more=exact_lines[1:],
    )
    caption = "Pressure under Westergaard's ridges at four loads."
    section.figures.append(Figure("Westergaard: pressure", image, caption))


def _partly_closed(section: Section, ratio: float, x: np.ndarray, contact: Solution) -> None:
    """Add the lines of Westergaard's wave below the load of full contact."""
    share = closed_forms.westergaard_contact_share(ratio)
    gap = closed_forms.westergaard_mean_gap(AMPLITUDE, ratio) / AMPLITUDE
    pressure = closed_forms.westergaard_pressure(x, 1.0, ratio * RIDGES_CLOSED, ratio) / RIDGES_CLOSED
    # gap = u - h + approach, the mean of h being zero: counted from the crest at rest
    displacement = contact.approach / AMPLITUDE - 1
    computed, points = contact.pressure[0] / RIDGES_CLOSED, x.size
    across = share * points
    for name, value, known, tolerance in (
        ("ridge share", contact.touching.mean(), share, 1 / points),
        ("ridge pressure", computed, pressure, 0.5 / across),
        ("ridge peak", computed.max(), 2 * np.sqrt(ratio), 2 * across**-2),
        ("ridge gap", contact.mean_gap / AMPLITUDE, gap, 2 / points**2),
        ("ridge displacement", displacement, gap - 1, 2 / points**2),
        ("ridge energy", *_energies(ratio, contact), 2 * across**-2),
    ):
        section.compare(name, value, known, tolerance, r=ratio, n=points, across=across)


def _energies(ratio: float, contact: Solution) -> tuple[float, float]:
    """Return the energy of Westergaard's wave over D p*, found and known."""
    unit = AMPLITUDE * RIDGES_CLOSED
    return contact.energy / unit, closed_forms.westergaard_energy(AMPLITUDE, 1.0, 1.0, ratio) / unit


def _crests(section: Section, points: int) -> None:
    """Add lines and figure of the product wave, `points` x `points`."""
    table = closed_forms.JGH_CONTACT_SHARE
    ratios = sorted({_LOW, 0.005, 0.01, 0.02, 0.7, _HIGH, *table})
    contacts = solve(product_wave(points), [ratio * WAVE_CLOSED for ratio in ratios], 1e-7)
    solved = dict(zip(ratios, contacts, strict=True))
    areas = {ratio: contact.area for ratio, contact in solved.items()}
    deviations = []
    for ratio, share in table.items():
        line = section.compare("crest area", areas[ratio], share, 2e-4 + 0.2 / points, r=ratio, n=points)
        deviations.append(line.deviation)
        if ratio in closed_forms.JGH_PEAK_AND_GAP:
            computed = (
                solved[ratio].pressure.max() / (ratio * WAVE_CLOSED),
                solved[ratio].mean_gap / AMPLITUDE,
            )
            known = closed_forms.JGH_PEAK_AND_GAP[ratio]
            for name, value, expected in zip(("crest peak", "crest gap"), computed, known, strict=True):
                rounded = 0.5e-5 / expected  # the table has five decimals
                section.compare(name, value, expected, 1e-5 + rounded + 8 / points**2, r=ratio, n=points)
    low, high = closed_forms.jgh_contact_share_low, closed_forms.jgh_contact_share_high
    section.compare("crest low", areas[_LOW], low(_LOW), _LOW ** (2 / 3) + 1 / points, r=_LOW, n=points)
    section.compare(
        "crest high", 1 - areas[_HIGH], 1 - high(_HIGH), (1 - _HIGH) + 1 / points, r=_HIGH, n=points
    )
    line_loads = np.geomspace(1e-3, 1, 200)
    left, right = line_loads[line_loads < 0.4], line_loads[line_loads > 0.6]
    image = drawing.chart(
        [("low asymptote", left, low(left)), ("high asymptote", right, high(right))],
        [("computed", ratios, [areas[ratio] for ratio in ratios])],
        published=[("independent code", list(table), list(table.values()))],
        x="r = p̄ / p*",
        y="relative contact area A/A₀",
        scales=("log", "log"),
        note=f"largest deviation of the area {number(max(deviations), digits=2)}",
    )
    caption = "Contact area of the product wave over the whole load range, with both asymptotes."
    section.figures.append(Figure("Product wave: area against load", image, caption))
