"""Removing metadata from a file never narrows its ±: what it says of its instrument is no statement."""

import json

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.surface.synthetic import self_affine_surface

NAMES = ("relative_contact_area", "mean_gap", "mean_contact_pressure", "max_pressure")
METADATA = (
    {"numerical_aperture": 0.15},
    {"comment": "20x, NA: 0.60", "lens": "50x"},
    {"name": "AFM", "probe": "tip of 8 nm", "acquisition_time": "2011-07-23T16:49:36"},
)
SOURCES = ["window", "instrument", "unresolved"]


def widths(seed, **attrs):
    """Return the half-widths of all quantities of a map whose file has such metadata (quantity, end)."""
    waves = {"hurst": 0.8, "shortest": 3e-6, "longest": 40e-6, "rms_height": 3e-7, "seed": seed}
    height = self_affine_surface((72, 72), 1e-6, **waves).assign_attrs(attrs)
    options = {"contact_modulus": 1e9, "relative_pressure": 0.1, "uncertainty": {"sources": SOURCES}}
    found = rc.evaluate(height, **options)
    return np.array(
        [found[f"{name}_upper"].item() - found[f"{name}_lower"].item() for name in NAMES]
        + [found[f"{name}_map_upper"].item() - found[f"{name}_map_lower"].item() for name in NAMES]
    )


@pytest.mark.parametrize("seed", [1, 2])
def test_without_its_metadata_a_map_has_no_narrower_interval(seed):
    bare = widths(seed)
    for metadata in METADATA:
        assert (bare >= widths(seed, instrument=json.dumps(metadata)) * (1 - 1e-9)).all()
