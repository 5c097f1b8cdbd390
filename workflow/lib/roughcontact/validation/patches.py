"""Patches of the contact, and the material ratio curve of the heights."""

import numpy as np
from scipy.special import ndtri

from roughcontact.connectivity import region_sizes
from roughcontact.contact.solve import solve_contact
from roughcontact.references import closed_forms
from roughcontact.roughness.bearing import bearing_parameters
from roughcontact.validation import waves
from roughcontact.validation.lines import Evidence, Part, compare

TITLE = "Patches and material ratio"
_RMS = 1e-6

STRIP = Evidence(
    "one strip for each wave, (2/π) arcsin √r of its length",
    "Westergaard (1939); Johnson (1985), sec. 13.2",
    "references.closed_forms.westergaard_contact_share",
    "tests/unit/test_patches.py::test_ridges_touch_in_one_patch_each",
)
CURVE = Evidence(
    "Sk = 12 σ [erf(t)/(2√π) − 0.4 φ(t)]/0.4³, t = Φ⁻¹(0.7); Spk, Svk, volumes: integrals of Φ",
    "ISO 13565-2:1996 and ISO 25178-2:2021, annex B, for normal heights",
    "references.closed_forms.gaussian_bearing",
    "tests/unit/test_bearing.py::test_closed_form_of_normal_heights_by_quadrature",
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
    lines = []
    full = closed_forms.westergaard_full_contact_pressure(waves.AMPLITUDE, 1.0, 1.0)
    _, ridge = waves.ridge(finest_grid)
    for ratio in (0.1, 0.5, 0.9):
        contact = solve_contact(ridge, contact_modulus=1.0, mean_pressure=ratio * full, tolerance=1e-8)
        touching = np.tile(contact["pressure"].values[0] > 0, (1, 3))
        lines.append(
            compare(
                f"Three ridges, r = {ratio:g}: largest patch / λ",
                region_sizes(touching).max() / finest_grid,
                closed_forms.westergaard_contact_share(ratio),
                tolerance=2 / finest_grid,
                reason=f"2/n, n = {finest_grid}: either end is known to one point",
                evidence=STRIP,
                measure="absolute",
            )
        )
    points = finest_grid**2
    heights = _RMS * ndtri((np.arange(points) + 0.5) / points)
    found, known = bearing_parameters(heights), closed_forms.gaussian_bearing(_RMS)
    for name, reference in known.items():
        lines.append(
            compare(
                f"Normal heights: {name}" + ("" if name.startswith("Smr") else " / Sq"),
                found[name] / (1 if name.startswith("Smr") else _RMS),
                reference / (1 if name.startswith("Smr") else _RMS),
                tolerance=4 / finest_grid,
                reason=f"4/n of n² = {points} heights: where the flattest 40 % begin",
                evidence=CURVE,
            )
        )
    text = (
        "Each of Westergaard's ridges touches in one strip. Heights that are normally distributed have a "
        "material ratio curve whose parameters are known in closed form."
    )
    return Part("patches", TITLE, text, lines)
