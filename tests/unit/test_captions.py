"""The captions of the pictures of the contact: each number is of the load that the caption names."""

import numpy as np
import xarray as xr

from roughcontact.report import captions


def numbers(**further):
    """Return statistics of three loads; the largest pressure is that of the second one."""
    loads = {
        "mean_pressure": [1e6, 5e6, 2e7],
        "relative_contact_area": [0.01, 0.05, 0.2],
        "relative_contact_area_pixels": [0.02, 0.1, 0.25],
        "mean_gap": [2e-6, 1e-6, 3e-7],
        "mean_contact_pressure": [1e8, 1.1e8, 2e8],
        "max_pressure": [3e8, 5e8, 4e8],
        "pressure_std": [1e7, 2e7, 5e7],
        "contact_clusters": [3, 12, 7],
        "largest_patch_area": [1e-12, 5e-12, 2e-11],
        "area_xu": [0.011, 0.055, 0.22],
    } | further
    data = xr.Dataset({name: ("load", values) for name, values in loads.items() if np.ndim(values)})
    single = {name: value for name, value in loads.items() if not np.ndim(value)}
    return data.assign(single | {"rms_height": 1e-6, "window_length_x": 2e-5, "window_length_y": 4e-5})


def test_a_caption_has_the_lowest_and_the_highest_load():
    found = numbers()
    area = captions.answers_caption(found, "relative_contact_area")
    assert area == "Contact area 1.00 % at 1.00 MPa, 20.0 % at 20.0 MPa."
    pressures = captions.answers_caption(found, "mean_contact_pressure", "max_pressure")
    assert pressures == (
        "Pressure in contact 100 MPa at 1.00 MPa, 200 MPa at 20.0 MPa; "
        "largest pressure 300 MPa at 1.00 MPa, 400 MPa at 20.0 MPa."
    )
    patches = captions.answers_caption(found, "contact_clusters", "largest_patch_area")
    assert patches.startswith("Contact patches 3 at 1.00 MPa, 7 at 20.0 MPa; largest patch 1.00 µm² at")
    alone = captions.answers_caption(found.isel(load=[1]), "mean_gap", "area_share_above_hardness")
    assert alone == "Mean gap 1.00 µm at 5.00 MPa."  # of a single load nothing is said twice


def test_the_digits_of_a_caption_are_those_that_its_interval_carries():
    ends = {"mean_gap_lower": [1e-6, 5e-7, 2e-7], "mean_gap_upper": [3e-6, 1.5e-6, 4e-7]}
    text = captions.answers_caption(numbers(**ends), "mean_gap")
    assert text == "Mean gap 2.0 ± 1.0 µm at 1.00 MPa, 0.30 ± 0.10 µm at 20.0 MPa."
    limited = {"hardness": 4e8, "max_pressure_lower": [2e8, 3e8, 3e8], "max_pressure_upper": [4e8, 4e8, 4e8]}
    assert captions.answers_caption(numbers(**limited), "max_pressure").endswith(", 400 MPa at 20.0 MPa.")


def test_bars_are_explained_where_there_are_any():
    assert captions.bars_in_words(numbers()) == ""
    gap = numbers(mean_gap_lower=[1e-6, 1e-6, 1e-7], mean_gap_upper=[2e-6, 2e-6, 2e-6])
    assert captions.bars_in_words(gap) == captions.bars_in_words(gap, "max_pressure") == ""
    assert captions.bars_in_words(gap, "mean_gap", "max_pressure") == "Bars: the ±."
    gap["mean_gap_upper"][1] = np.nan
    assert captions.bars_in_words(gap, "mean_gap") == "Bars: the ±; an arrow: nothing bounds it upwards."
