"""The tables of the report: each cell is the number it is called after, with its sign and in its unit."""

import json

import numpy as np
import xarray as xr

from roughcontact.maps import height_map
from roughcontact.report.tables import crosscheck_table, score_table
from roughcontact.results.storage import write_dataset


def test_the_cross_check_says_by_how_much_the_other_code_is_off(tmp_path):
    """Peak 2 % less and gap 3 % more at the lower load, which the file has in the second place."""
    numbers = xr.Dataset(
        {
            "mean_pressure": ("load", [1e6, 4e6]),
            "relative_contact_area_pixels": ("load", [0.05, 0.2]),
            "max_pressure": ("load", [1e8, 2e8]),
            "mean_gap": ("load", [1e-6, 0.0]),
        }
    )
    other = xr.Dataset(
        {
            "other_max_pressure": ("load", [2e8, 0.98e8]),
            "other_mean_gap": ("load", [1e-9, 1.03e-6]),
            "other_contact_area_pixels": ("load", [0.2, 0.0625]),
            "contact_difference": ("load", [np.nan, 7.0]),
            "pressure_difference": ("load", [np.nan, 4.2e-3]),
        },
        attrs={"code": "Tamaas", "version": "2.9"},
    )
    write_dataset(other, tmp_path / "crosscheck.nc")
    table = crosscheck_table(tmp_path / "crosscheck.nc", numbers, np.array([1, 0]))
    assert table["code"] == "Tamaas 2.9"
    assert table["rows"] == [
        ["1.00 MPa", "5.0000 %", "6.2500 %", "7", "0.0042", "−0.020", "0.030"],
        ["4.00 MPa", "20.0000 %", "20.0000 %", "–", "–", "0", "0"],
    ]


def test_of_a_window_shares_are_in_percent_and_mismatches_are_not():
    solved = {
        "points": [40, 60],
        "offset": [2e-6, 5e-6],
        "score": 0.123,
        "largest_rectangle": False,
        "height_mismatch": 0.5,
        "slope_mismatch": 0.25,
        "missing": 0.01,
        "stationarity": 0.1,
        "representativeness": 0.2,
        "size": 0.3,
    }
    largest = solved | {"points": [64, 96], "offset": [0.0, 0.0], "score": 0.5, "largest_rectangle": True}
    window = height_map(np.zeros((2, 2)), 1e-6).assign_attrs(window_scores=json.dumps([solved, largest]))
    first, second = score_table(window)["rows"]
    cells = ["0.50", "0.25", "1.00 %", "10.0 %", "20.0 %", "30.0 %"]
    # x before y, as everywhere on the page
    assert first == {"cells": ["60 × 40", "5.00 µm, 2.00 µm", "0.123", *cells], "words": "solved"}
    assert second == {"cells": ["96 × 64", "0 m, 0 m", "0.500", *cells], "words": "largest rectangle"}
