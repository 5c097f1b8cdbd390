"""The captions of the pictures of the contact: each number is of the load that the caption names."""

import numpy as np
import pytest
import xarray as xr

from roughcontact.quantities import Unit
from roughcontact.report import captions


def numbers(**more):
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
    } | more
    data = xr.Dataset({name: ("load", values) for name, values in loads.items() if np.ndim(values)})
    single = {name: value for name, value in loads.items() if not np.ndim(value)}
    return data.assign(single | {"rms_height": 1e-6, "window_length_x": 2e-5, "window_length_y": 4e-5})


def test_what_is_said_of_the_lowest_and_of_the_highest_load():
    found = numbers()
    assert captions.area_caption(found) == (
        "1.00 % of the area touch at 1.00 MPa, 20.0 % at 20.0 MPa; the theory of Xu et al. says 22.0 % there."
    )
    assert captions.gap_caption(found) == (
        "The mean gap is 2.00 µm at 1.00 MPa, 0.300 µm at 20.0 MPa: 2.00 and 0.300 of the rms height."
    )
    assert captions.pressure_caption(found) == (
        "Mean pressure in contact 100 MPa at 1.00 MPa, 200 MPa at 20.0 MPa; largest 500 MPa at 5.00 MPa."
    )


def test_what_is_said_of_the_highest_load():
    found = numbers()
    # 50 MPa, where the pixels in contact carry 20/0.25 MPa
    assert captions.distribution_caption(found) == (
        "At 20.0 MPa the pressure scatters by 62.5 % of its mean over the contact."
    )
    # of 0.25 times 20 µm times 40 µm in contact
    assert captions.patch_caption(found) == (
        "At 20.0 MPa 7 patches touch; the largest, 20.0 µm², has 10.0 % of the contact."
    )
    # 0.3 µm over what the contact of 20 % leaves
    assert captions.open_caption(found) == "At 20.0 MPa 80.0 % of the area are apart, by 0.375 µm on average."
    closed = numbers(
        relative_contact_area=[0.01, 0.05, 1.0],
        relative_contact_area_pixels=[0.02, 0.1, 1.0],
        contact_clusters=[3, 12, 1],
    )
    assert captions.open_caption(closed) == "At 20.0 MPa nothing is apart."
    assert captions.patch_caption(closed) == "At 20.0 MPa a single patch of 20.0 µm² touches."


def test_of_a_single_load_nothing_is_said_twice():
    found = numbers().isel(load=[1]).drop_vars("area_xu")
    assert captions.area_caption(found) == "5.00 % of the area touch at 5.00 MPa."
    assert captions.gap_caption(found) == "The mean gap is 1.00 µm at 5.00 MPa: 1.00 of the rms height."


@pytest.mark.parametrize(
    ("share", "said"),
    [
        (0.0, "the pressure scatters by 62.5 % of its mean over the contact."),
        (0.4, "40.0 % of the contact carry the hardness."),
    ],
)
def test_where_the_pressure_reaches_the_hardness(share, said):
    found = numbers(hardness=4e8, max_pressure=[3e8, 4e8, 4e8], area_share_above_hardness=[0.0, 0.1, share])
    assert captions.distribution_caption(found) == f"At 20.0 MPa {said}"
    assert captions.pressure_caption(found).endswith("; largest 400 MPa, the hardness, from 5.00 MPa on.")
    rounded = numbers(hardness=4e8, max_pressure=[4e8 * (1 - 1e-15), 4e8, 4e8])
    assert captions.pressure_caption(rounded).endswith("; largest 400 MPa, the hardness, from 1.00 MPa on.")
    below = numbers(hardness=6e8)
    assert captions.pressure_caption(below).endswith("; largest 500 MPa at 5.00 MPa.")


def test_surfaces_are_compared_at_the_highest_load_that_all_have():
    loads = np.array([1.0, 2.0, 4.0])
    series = [
        ("a", loads, np.array([0.1, 0.2, 0.4])),
        ("b", 2 * loads, np.array([0.3, 0.6, 0.9])),
        ("c", loads / 2, np.array([0.05, 0.1, 0.25])),
    ]
    # at 2: a has 0.2, b 0.3, c 0.25
    assert captions.comparison_caption(series) == "At p′ = 2.00, 20.0 % (a) to 30.0 % (b) of the area touch."
    pascal = captions.comparison_caption(series, Unit(1e3, "mPa"))
    assert pascal.startswith("At p̄ = 2000 mPa, 20.0 % (a)")
    assert captions.comparison_caption(series[:1]) == ""
    alike = [(f"a · {case}", *series[0][1:]) for case in ("soft", "hard")]
    assert captions.comparison_caption(alike) == "At p′ = 4.00, 40.0 % of the area touch in all."
    apart = ("e", np.array([1.0, 3.0]), np.array([0.1, 0.5]))  # 0.3 at 2, which was not solved
    assert captions.comparison_caption([series[0], apart, series[2]]).endswith(
        "At p′ = 2.00, 20.0 % (a) to 30.0 % (e) of the area touch, interpolated between the loads solved."
    )
    beyond = ("d", np.array([2.5, 5.0]), np.array([0.1, 0.2]))  # a load of 2 was not solved
    assert captions.comparison_caption([*series, beyond]) == ""


def test_bars_are_explained_where_there_are_any():
    assert captions.reading_of(numbers()) == ""
    gap = numbers(mean_gap_lower=[1e-6, 1e-6, 1e-7], mean_gap_upper=[2e-6, 2e-6, 2e-6])
    assert captions.reading_of(gap) == captions.reading_of(gap, "max_pressure") == ""
    assert captions.reading_of(gap, "mean_gap", "max_pressure") == "Bars: the ±."
    gap["mean_gap_upper"][1] = np.nan
    assert captions.reading_of(gap, "mean_gap") == "Bars: the ±; an arrow: nothing bounds it upwards."
