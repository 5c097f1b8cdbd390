"""Narrowest places whose interval has no upper end, in tables and between runs."""

import numpy as np
import pytest
import xarray as xr

from roughcontact.report.glance import _seals, glance_units
from roughcontact.results.comparison import _half_width
from roughcontact.uncertainty.scales import ANSWERS


def test_the_table_says_or_more_where_there_is_no_bound_and_doubts_a_closed_gap():
    columns = {"gap_percolates_x": [1.0, 0.0], "gap_percolates_y": [0.0, 0.0], "mean_gap": [2e-6, 1e-6]}
    columns |= {"critical_constriction_x": [1e-6, 0.0], "critical_constriction_y": [0.0, 0.0]}
    columns |= {
        "critical_constriction_x_lower": [0.8e-6, 0.0],
        "critical_constriction_x_upper": [np.nan, np.nan],
    }
    numbers = xr.Dataset({name: ("load", values) for name, values in columns.items()})
    leaks, seals = (_seals(numbers, *glance_units([numbers]), index) for index in (0, 1))
    assert leaks.text == "seals along y, leaks along x"
    assert leaks.details.replace("\N{NO-BREAK SPACE}", " ") == "narrowest place 1.00 (0.80 or more) µm (x)"
    assert seals.text == "seals"
    doubted = "gap closed along x and y; narrowest place 0 or more µm (x)"
    assert seals.all_details.replace("\N{NO-BREAK SPACE}", " ") == doubted
    rates = {"leak_rate_x": [2e-12, 0.0], "leak_rate_y": [0.0, 0.0]}
    rates |= {"leak_rate_x_lower": [0.0, 0.0], "leak_rate_x_upper": [9.2e-11, 9.2e-11]}
    numbers = numbers.assign({name: ("load", values) for name, values in rates.items()})
    leaks, seals = (_seals(numbers, *glance_units([numbers]), index).all_details for index in (0, 1))
    rate = "(0 to 0.33) ml/(h m)".replace(" ", "\N{NO-BREAK SPACE}")
    assert leaks.startswith(f"leak rate 0.0072\N{NO-BREAK SPACE}{rate} (x); narrowest")
    assert f"; leak rate 0\N{NO-BREAK SPACE}{rate} (x); narrowest" in seals


def test_two_runs_do_not_differ_where_one_of_them_has_no_bound():
    """The narrowest place of the new run is above that of the old one, whose grooves leave the map."""
    name = ANSWERS[1]

    def run(value, lower, upper):
        variables = {name: value, f"{name}_lower": lower, f"{name}_upper": upper, "mean_pressure": 1e6}
        half_widths = ("source", [upper - value])
        return xr.Dataset(variables | {f"{name}_uncertainty": half_widths}, coords={"source": ["combined"]})

    old, new = run(1e-6, 0.8e-6, np.nan), run(5e-6, 4.9e-6, 5.1e-6)
    assert _half_width(old, name, 5e-6) == np.inf
    assert _half_width(old, name, 0.5e-6) == pytest.approx(0.2e-6)
    assert _half_width(new, name, 1e-6) == pytest.approx(0.1e-6)
