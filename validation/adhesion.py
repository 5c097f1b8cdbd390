"""Adhesion at a glance: the energy that presses a wave and a rough surface flat."""

import numpy as np

from roughcontact.arguments.maps import height_map
from roughcontact.contact.elasticity.influence import HALF_SPACE, Elasticity
from roughcontact.statistics.adhesion import adhesion_numbers
from roughcontact.surface.synthetic import self_affine_surface
from validation.lines import Section

_MODULUS, _WORK = 2e6, 0.05  # rubber, Pa and J/m²
_WAVELENGTH = 1e-5


def add_lines(section: Section, *, finest_grid: int) -> None:
    """Add the lines of waves, and of self-affine maps on a grid a quarter as fine."""
    phase = 2 * np.pi * np.arange(64) / 64
    critical = np.sqrt(4 * _WORK * _WAVELENGTH / (np.pi * _MODULUS))
    for ratio in (0.5, 1.0, 2.0):
        wave = height_map(ratio * critical * np.cos(phase)[None, :], _WAVELENGTH / 64)
        computed = adhesion_numbers(wave, Elasticity(_MODULUS), work_of_adhesion=_WORK)
        section.compare(
            "wave", computed["effective_work_of_adhesion"] / _WORK, 1 - ratio**2, 1e-12, ratio=ratio
        )
    points, rms = finest_grid // 4, 1e-3
    first, last = points // 16, points // 4  # waves per side
    low, band = 2 * np.pi * first, first / last
    for hurst in (0.3, 0.8):
        height = self_affine_surface(
            (points, points), 1 / points, hurst=hurst, shortest=1 / last, longest=1 / first, rms_height=rms
        )
        power = 2 * hurst - 1
        mean_wavenumber = low * 2 * hurst / power * (1 - band**power) / (1 - band ** (2 * hurst))
        energy = adhesion_numbers(height, HALF_SPACE)["conforming_energy"] / (rms**2 * low)
        fields = {"hurst": hurst, "first": first, "last": last}
        section.compare("rough", energy, mean_wavenumber / (4 * low), 0.1 / np.sqrt(first), **fields)
