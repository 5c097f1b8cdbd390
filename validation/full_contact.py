"""Full contact of rough maps: exact for the discrete problem, whatever the map."""

import xarray as xr

from roughcontact.arguments.maps import spacing
from roughcontact.contact.elasticity.energy import conforming_energy
from roughcontact.contact.elasticity.influence import HALF_SPACE
from roughcontact.surface import synthetic
from roughcontact.surface.roughness import parameters
from validation import closed_forms
from validation.lines import Section
from validation.problems import solve
from validation.surfaces import ground_surface

ROUNDING = 1e-12


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of three rough maps on grids about an eighth as fine."""
    points = finest_grid // 8
    band = {"shortest": 4.0, "longest": points / 4}
    isotropic = synthetic.self_affine_surface(
        (points + 1, points - 1), 1.0, hurst=0.8, **band, rms_gradient=0.1, seed=1
    )
    ground = ground_surface(
        (points, 2 * points), (3.0, 1.0), hurst=0.7, **band, rms_height=0.5, skewness_power=1.5, seed=2
    )
    _lines(section, "isotropic, odd size", isotropic)
    _lines(section, "ground, pixels 1:3", ground)
    _lines(section, "rough reference case", synthetic.rough_reference_surface(points + 32))


def _lines(section: Section, name: str, height: xr.DataArray) -> None:
    """Add the lines of one map."""
    fluctuation = closed_forms.full_contact_fluctuation(height.values, spacing(height), 1.0)
    least = -fluctuation.min()
    loads = [0.999 * least, (1 + 1e-9) * least, 5 * least]
    below, just, far = solve(height, loads, 1e-6)
    energy = closed_forms.full_contact_energy(height.values, spacing(height), 1.0)
    conforming = conforming_energy(height.values, spacing(height), HALF_SPACE)
    for word, load, contact in (("just closed", loads[1], just), ("5 × that load", loads[2], far)):
        section.compare("pressure", contact.pressure, load + fluctuation, ROUNDING, map=name, load=word)
    section.compare("spread", far.pressure.std(), parameters.rms_gradient(height) / 2, ROUNDING, map=name)
    section.compare("energy", far.energy, energy, ROUNDING, map=name)
    section.compare("conforming", conforming, far.energy, ROUNDING, map=name)
    closes = just.touching.all() and not below.touching.all()
    section.compare("closed", closes, 1.0, 0.0, map=name)
