"""The facts beside the checks of a surface: each is the number it is called after, in its unit."""

import json

import numpy as np
import pytest
import xarray as xr
from case_tables import cases_of

from roughcontact.arguments.maps import height_map
from roughcontact.report.facts import levelled_caption, spectrum_caption, surface_facts


def numbers(**further):
    """Return statistics of three loads at which the gap closes along x between the last two."""
    single = {
        "rms_height": 4e-7,
        "rms_gradient": 0.125,
        "contact_modulus": 115e9,
        "Sal": 1.2e-5,
        "Str": 0.25,
        "Std": 150.0,
        "hardness": 3e9,
        "first_yield_pressure": 2e6,
        "first_subsurface_yield_pressure": 5e6,
    }
    loads = {
        "mean_pressure": ("load", [1e6, 5e6, 2e7]),
        "points_per_shortest_wavelength": ("load", [4.6] * 3),
        "gap_percolates_x": ("load", [1.0, 1.0, 0.0]),
        "gap_percolates_y": ("load", [1.0, 1.0, 1.0]),
    }
    return xr.Dataset(single | loads | further)


def known(value, unit):
    return {"value": value, "units": unit}


def facts(measured=None, levelled=None, window=None, **settings):
    """Return the facts of a map of 40 x 30 points with these attributes, of a pitch of 2 and 1 µm."""
    maps = [height_map(np.eye(30, 40) * 1e-6, (2e-6, 1e-6)) for _ in range(3)]
    attrs = (measured or {}, levelled or {}, window or {})
    faces = (face.assign_attrs(a) for face, a in zip(maps, attrs, strict=True))
    return {name: text for name, text in surface_facts(*faces, numbers(**settings)).items() if text}


def test_all_that_is_known_of_a_surface():
    measured = {
        "source_file": "a.x3p",
        "source_format": "X3P",
        "channel": "height",
        "instrument": json.dumps({"lens": "50x", "numerical_aperture": 0.4}),
        "missing_share": 0.0125,
    }
    levelled = {
        "form": "plane",
        "form_removed": json.dumps({"slope_x": known(-0.02, "1"), "mean": known(1.5e-6, "m")}),
        "line_alignment": "median",
        "line_shift_rms": 2.5e-8,
        "filters_removed": json.dumps(
            {"s_filter": {"nesting_index": known(8e-6, "m"), "rms_removed": known(3e-8, "m")}}
        ),
        "Sa": 3e-7,
        "Sq": 4e-7,
        "Sz": 5e-6,
        "Ssk": -0.5,
        "Sku": 3.2,
        "Sdq": 0.2,
        "Sk": 9e-7,
        "Spk": 2e-7,
        "Svk": 6e-7,
    }
    expected = dict(cases_of("test_facts", "test_all_that_is_known_of_a_surface")[1])
    assert facts(measured, levelled, {"periodisation": "cross-fade"}) == expected


def test_how_a_counter_face_lies_on_the_face():
    levelled = {
        "counter_face": "b.x3p",
        "shift_y": -3e-6,
        "shift_x": 2e-6,
        "rotation": 90.0,
        "covered_share": 0.75,
    }
    assert facts(levelled=levelled)["Counter-face"] == (
        "b.x3p, its middle at 2.00 µm, −3.00 µm (x, y) from that of the face, turned by 90°, "
        "on 75.0 % of the face"
    )


@pytest.mark.cases
def test_the_form_that_was_taken_off(name, value, unit, number_text):
    removed = facts(levelled={"form": "some", "form_removed": json.dumps({name: known(value, unit)})})
    assert removed["Removed form"] == f"some: {name.replace('_', ' ')} {number_text}"


@pytest.mark.cases
def test_between_which_loads_the_gap_closes(is_open, message):
    loads = {f"gap_percolates_{axis}": ("load", opening) for axis, opening in zip("xy", is_open, strict=True)}
    assert facts(**loads)["Gap closes"] == message


def test_of_a_profile_nothing_is_said_of_closing():
    assert "Gap closes" not in facts(Std=np.nan)


@pytest.mark.parametrize(("aspect", "lay"), [(0.5, "60° from x towards y"), (0.51, "none")])
def test_half_as_long_across_as_along_is_a_lay(aspect, lay):
    assert facts(Str=aspect)["Sal, Str, lay"].split(", ")[2] == lay


def test_what_the_captions_of_the_maps_say():
    levelled = height_map(np.zeros((3, 4)), 1e-6).assign_attrs(filled_points=9, largest_hole=4)
    frame = " The red frame is the solved window."
    assert levelled_caption(levelled) == f"9 points filled in (largest hole 4), 0 outliers rejected.{frame}"
    assert frame not in levelled_caption(levelled[:1])
    band = {
        "band_shortest": 2e-6,
        "band_longest": 1e-4,
        "band_removed_rms_height": 3e-8,
        "band_removed_rms_gradient": 0.05,
    }
    assert spectrum_caption(levelled[:1].assign_attrs(band), numbers()).startswith("Waves from 2.00 µm")
    assert spectrum_caption(levelled.assign_attrs(band), numbers()) == (
        "Mean over all directions. Waves from 2.00 µm to 100 µm are solved; "
        "removed: rms height 0.0300 µm, rms gradient 0.0500."
    )
