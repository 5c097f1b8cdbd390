"""Adhesion at a glance: the energy that presses a wave and a rough surface flat."""

import numpy as np

from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.statistics.adhesion import adhesion_numbers
from roughcontact.validation.lines import Evidence, Part, compare

TITLE = "Adhesion"
_MODULUS, _WORK = 2e6, 0.05  # rubber, Pa and J/m²
_WAVELENGTH = 1e-5

_TESTS = "tests/unit/test_adhesion.py"
WAVE = Evidence(
    "U = π E* D²/(4λ)",
    "Westergaard (1939); Johnson (1985), sec. 13.2: half of p* cos(qx) times D cos(qx)",
    "statistics.adhesion.adhesion_numbers",
    f"{_TESTS}::test_energy_is_the_work_of_full_contact",
)
ROUGH = Evidence(
    "U = (E* σ²/4) q₀ 2H/(2H − 1) [1 − (q₀/q₁)^(2H − 1)]/[1 − (q₀/q₁)^(2H)]",
    "Persson and Tosatti (2001), J. Chem. Phys. 115, 5597, with waves between q₀ and q₁ alone",
    "statistics.adhesion.adhesion_numbers",
    f"{_TESTS}::test_energy_is_the_work_of_full_contact",
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
    phase = 2 * np.pi * np.arange(64) / 64
    critical = np.sqrt(4 * _WORK * _WAVELENGTH / (np.pi * _MODULUS))
    lines = []
    for ratio in (0.5, 1.0, 2.0):
        wave = height_map(ratio * critical * np.cos(phase)[None, :], _WAVELENGTH / 64)
        found = adhesion_numbers(wave, contact_modulus=_MODULUS, work_of_adhesion=_WORK)
        lines.append(
            compare(
                f"Wave of {ratio:g} of the amplitude at which nothing is left: effective work / w",
                found["effective_work_of_adhesion"] / _WORK,
                1 - ratio**2,
                measure="absolute",
                tolerance=1e-12,
                reason="rounding",
                evidence=WAVE,
            )
        )
    points, rms = finest_grid // 4, 1e-3
    first, last = points // 16, points // 4  # waves per side
    low = 2 * np.pi * first
    for hurst in (0.3, 0.8):
        height = self_affine_surface(
            (points, points), 1 / points, hurst=hurst, shortest=1 / last, longest=1 / first, rms_height=rms
        )
        ratio, power = first / last, 2 * hurst - 1
        mean_wavenumber = low * 2 * hurst / power * (1 - ratio**power) / (1 - ratio ** (2 * hurst))
        found = adhesion_numbers(height, contact_modulus=1.0)
        lines.append(
            compare(
                f"Self-affine, H = {hurst:g}: energy that presses it flat / (E* σ² q₀)",
                found["conforming_energy"] / (rms**2 * low),
                mean_wavenumber / (4 * low),
                tolerance=0.1 / np.sqrt(first),
                reason=f"the sum over a lattice of waves, {first} to {last} per side, for an integral",
                evidence=ROUGH,
            )
        )
    text = (
        "What it costs to press a surface flat, beside what its adhesion pays: of a wave, and of rough "
        "surfaces between two wavelengths."
    )
    return Part("adhesion", TITLE, text, lines)
