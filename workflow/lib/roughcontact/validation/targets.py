"""Inverse questions: the loads of Westergaard's ridges, found from what they bring about."""

from roughcontact.references import closed_forms
from roughcontact.statistics.targets import target_loads
from roughcontact.validation import waves
from roughcontact.validation.lines import Evidence, Part, compare

TITLE = "Loads by what they do"

_WAVES = "tests/unit/test_reference.py"
AREA = Evidence(
    "A/A₀ = (2/π) asin √r",
    "Westergaard (1939)",
    "references.closed_forms.westergaard_contact_share",
    "tests/unit/test_targets.py::test_area_and_gap_of_a_wave",
)
GAP = Evidence(
    "ū = D (1 − r + r ln r)",
    "Westergaard (1939); Johnson (1985), sec. 13.2",
    "references.closed_forms.westergaard_mean_gap",
    f"{_WAVES}::test_westergaard_gap_closes_at_the_edge_and_has_the_stated_mean",
)
CLOSING = Evidence(
    "the gap along the ridges closes at p*",
    "Westergaard (1939)",
    "references.closed_forms.westergaard_full_contact_pressure",
    "tests/unit/test_targets.py::test_ridges_are_closed_across_at_once_and_along_at_full_contact",
)
YIELD = Evidence(
    "2 √(p̄ p*) = H",
    "Westergaard (1939)",
    "references.closed_forms.westergaard_pressure",
    "tests/unit/test_targets.py::test_first_yield_of_a_wave_by_its_hardness",
)


def part(*, finest_grid: int) -> Part:
    """Return the lines of this part.

    Parameters
    ----------
    finest_grid : int
        points along the finest grid.

    Returns
    -------
    Part
    """
    full = closed_forms.westergaard_full_contact_pressure(waves.AMPLITUDE, 1.0, 1.0)
    _, height = waves.ridge(finest_grid)
    ratios = (0.1, 0.5, 0.9)
    areas = [float(closed_forms.westergaard_contact_share(ratio)) for ratio in ratios]
    gaps = [float(closed_forms.westergaard_mean_gap(waves.AMPLITUDE, ratio)) for ratio in ratios]
    by_area = target_loads(height, contact_modulus=1.0, target_area=areas, tolerance=1e-6)
    by_gap = target_loads(height, contact_modulus=1.0, target_gap=gaps, tolerance=1e-6)
    lines = []
    for ratio, area, first, second in zip(ratios, areas, by_area, by_gap, strict=True):
        lines += [
            compare(
                f"Ridges: load of the area {area:.3f} / p*",
                first / full,
                ratio,
                tolerance=8 / (area * finest_grid) + 1e-4,
                reason=f"the area jumps by points of {finest_grid}, and 1e-4 of the search",
                evidence=AREA,
            ),
            compare(
                f"Ridges: load of the mean gap at r = {ratio:g} / p*",
                second / full,
                ratio,
                tolerance=1e-4 + 20 / finest_grid**2,
                reason=f"1e-4 of the search, and 20/n², n = {finest_grid}",
                evidence=GAP,
            ),
        ]
    (closing,) = target_loads(height, contact_modulus=1.0, target="percolation")
    (yielding,) = target_loads(
        height, contact_modulus=1.0, target="first_yield", hardness=0.6 * full, tolerance=1e-6
    )
    lines += [
        compare(
            "Ridges: load that closes the gap / p*",
            closing / full,
            1.0,
            tolerance=1e-4 + 20 / finest_grid**2,
            reason=f"1e-4 of the search, and the last point of {finest_grid}: 20/n²",
            evidence=CLOSING,
        ),
        compare(
            "Ridges: load at which the largest pressure is 0.6 p* / p*",
            yielding / full,
            0.09,
            tolerance=1e-3 + 100 / finest_grid**2,
            reason=f"1e-3 of the search, and the peak between points of {finest_grid}: 100/n²",
            evidence=YIELD,
        ),
    ]
    text = "The area, the mean gap, the closing and the largest pressure of ridges each belong to one load."
    return Part("targets", TITLE, text, lines)
