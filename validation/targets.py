"""Inverse questions: the loads of Westergaard's ridges, found from what they bring about."""

from roughcontact.statistics.targets import target_loads
from validation import closed_forms
from validation.lines import Section
from validation.problems import AMPLITUDE, RIDGES_CLOSED, ridge


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of a row of ridges."""
    n, full = finest_grid, RIDGES_CLOSED
    _, height = ridge(n)
    ratios = (0.1, 0.5, 0.9)
    areas = [float(closed_forms.westergaard_contact_share(ratio)) for ratio in ratios]
    gaps = [float(closed_forms.westergaard_mean_gap(AMPLITUDE, ratio)) for ratio in ratios]
    by_area = target_loads(height, contact_modulus=1.0, target_area=areas, tolerance=1e-6)
    by_gap = target_loads(height, contact_modulus=1.0, target_gap=gaps, tolerance=1e-6)
    for ratio, area, first, second in zip(ratios, areas, by_area, by_gap, strict=True):
        section.compare("area", first / full, ratio, 8 / (area * n) + 1e-4, area=area, n=n)
        section.compare("gap", second / full, ratio, 1e-4 + 20 / n**2, r=ratio, n=n)
    (closing,) = target_loads(height, contact_modulus=1.0, target="percolation")
    (yielding,) = target_loads(
        height, contact_modulus=1.0, target="first_yield", hardness=0.6 * full, tolerance=1e-6
    )
    section.compare("closing", closing / full, 1.0, 1e-4 + 20 / n**2, n=n)
    section.compare("yield", yielding / full, 0.09, 1e-3 + 100 / n**2, n=n)
