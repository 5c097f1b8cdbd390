"""The surfaces and problems on which the ensembles of the error budget are tried."""

import numpy as np

from roughcontact.surface.synthetic import self_affine_surface

GRADIENT = 0.1
MEANS = ("relative_contact_area", "mean_gap", "mean_contact_pressure")


def surface(points, *, longest=32.0, seed=0, hurst=0.8):
    return self_affine_surface(
        (points, points),
        1.0,
        hurst=hurst,
        shortest=8.0,
        longest=longest,
        rms_gradient=GRADIENT,
        seed=seed,
    )


def noisy(height, noise, seed=0):
    """Return a map plus white noise of a draw that is not one of the program's."""
    return height.copy(data=height.values + noise * np.random.default_rng(seed).standard_normal(height.shape))


def contact(*relative_pressures):
    return {
        "contact_modulus": 1.0,
        "mean_pressure": [GRADIENT * p for p in relative_pressures],
        "tolerance": 1e-4,
    }
