"""Full contact of rough maps: exact for the discrete problem, whatever the map."""

import xarray as xr

from roughcontact.contact.solve import solve_contact
from roughcontact.elasticity.energy import conforming_energy, elastic_energy
from roughcontact.maps import spacing
from roughcontact.references import closed_forms, synthetic
from roughcontact.roughness import parameters
from roughcontact.validation.lines import Evidence, Line, Part, compare, compare_largest

TITLE = "Full contact of rough maps"
ROUNDING, EXACT = 1e-12, "rounding: the discrete answer is exact"

_TEST = "tests/unit/test_reference.py::test_full_contact_flattens_the_map"
_SOURCE = "Johnson (1985), sec. 13.2, one wave at a time"


def _evidence(formula: str, function: str) -> Evidence:
    """Return the evidence of a formula that holds wave by wave."""
    return Evidence(formula, _SOURCE, function, _TEST)


PRESSURE = _evidence(
    "p̂(q) = (E*|q|/2) ĥ(q), q ≠ 0; full from p̄ = −min of it on",
    "references.closed_forms.full_contact_fluctuation",
)
SPREAD = _evidence("std(p) = E* g/2, g² = Σ |q|² |ĥ(q)|²", "roughness.parameters.rms_gradient")
ENERGY = _evidence("U = (E*/4) Σ |q| |ĥ(q)|²", "references.closed_forms.full_contact_energy")

CONFORMING = Evidence(
    "U = (E*/4) Σ |q| |ĥ(q)|², without a solution; w − U is left of a work of adhesion w",
    "Persson and Tosatti (2001), J. Chem. Phys. 115, 5597",
    "elasticity.energy.conforming_energy",
    "tests/unit/test_adhesion.py::test_energy_is_the_work_of_full_contact",
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
    points = finest_grid // 8
    maps = {
        "isotropic, odd size": synthetic.self_affine_surface(
            (points + 1, points - 1),
            1.0,
            hurst=0.8,
            shortest=4.0,
            longest=points / 4,
            rms_gradient=0.1,
            seed=1,
        ),
        "ground, pixels 1:3": synthetic.ground_surface(
            (points, 2 * points),
            (3.0, 1.0),
            hurst=0.7,
            shortest=4.0,
            longest=points / 4,
            rms_height=0.5,
            skewness_power=1.5,
            seed=2,
        ),
        "rough reference case": synthetic.rough_reference_surface(points + 32),
    }
    lines = [line for name, height in maps.items() for line in _lines(name, height)]
    text = (
        "Once everything touches, each wave of the map carries its own wave of pressure. No iteration is "
        "needed, and the answer must agree to rounding; just below that load a point must open."
    )
    return Part("full_contact", TITLE, text, lines)


def _lines(name: str, height: xr.DataArray) -> list[Line]:
    """Return the lines of one map."""
    fluctuation = closed_forms.full_contact_fluctuation(height.values, spacing(height), 1.0)
    least = -fluctuation.min()
    loads = [0.999 * least, (1 + 1e-9) * least, 5 * least]
    contact = solve_contact(height, contact_modulus=1.0, mean_pressure=loads, tolerance=1e-6)
    just, far = contact["pressure"].values[1:]
    open_points = (contact["pressure"].values == 0).sum(axis=(1, 2))
    return [
        compare_largest(
            f"{name}, {label}: pressure / E*, every point",
            pressure,
            load + fluctuation,
            tolerance=ROUNDING,
            reason=EXACT,
            evidence=PRESSURE,
        )
        for label, load, pressure in (("just closed", loads[1], just), ("5 × that load", loads[2], far))
    ] + [
        compare(
            f"{name}: standard deviation of p / E*",
            far.std(),
            parameters.rms_gradient(height) / 2,
            tolerance=ROUNDING,
            reason=EXACT,
            evidence=SPREAD,
        ),
        compare(
            f"{name}: energy / (E* × length)",
            elastic_energy(far, spacing(height), contact_modulus=1.0),
            closed_forms.full_contact_energy(height.values, spacing(height), 1.0),
            tolerance=ROUNDING,
            reason=EXACT,
            evidence=ENERGY,
        ),
        compare(
            f"{name}: energy of full conformity, without solving / (E* × length)",
            conforming_energy(height.values, spacing(height), contact_modulus=1.0),
            elastic_energy(far, spacing(height), contact_modulus=1.0),
            tolerance=ROUNDING,
            reason=EXACT,
            evidence=CONFORMING,
        ),
        compare(
            f"{name}: closed at 1 + 1e-9 of the least full load and open at 0.999 (1 = yes)",
            open_points[0] > 0 and open_points[1] == 0,
            1.0,
            measure="absolute",
            tolerance=0.0,
            reason="yes or no",
            evidence=PRESSURE,
        ),
    ]
