"""Rough surfaces on which tests are made, and the problems on which the error budget is tried."""

import numpy as np

from roughcontact.surface.synthetic import self_affine_surface

GRADIENT = 0.1
MEANS = ("relative_contact_area", "mean_gap", "mean_contact_pressure")


def self_affine(shape, spacing, band, *, hurst=0.8, **options):
    """Return a rough surface with waves from the shorter to the longer wavelength of a band."""
    return self_affine_surface(shape, spacing, hurst=hurst, shortest=band[0], longest=band[1], **options)


def surface(points, *, longest=32.0, seed=0, hurst=0.8):
    return self_affine((points, points), 1.0, (8.0, longest), hurst=hurst, rms_gradient=GRADIENT, seed=seed)


def noisy(height, noise, seed=0):
    """Return a map plus white noise of a draw that is not one of the program's."""
    return height.copy(data=height.values + noise * np.random.default_rng(seed).standard_normal(height.shape))


def contact(*relative_pressures):
    return {
        "contact_modulus": 1.0,
        "mean_pressure": [GRADIENT * p for p in relative_pressures],
        "tolerance": 1e-4,
    }
