"""The tables of the report: each cell is the number it is called after, with its sign and in its unit."""

import re

import numpy as np
import pytest
import xarray as xr
from case_tables import cases_of

from roughcontact.arguments.answers import UNITS
from roughcontact.arguments.variables import VARIABLES
from roughcontact.report.glance import Cell, Remark, glance_rows
from roughcontact.report.tables import number_tables
from roughcontact.report.template import template
from roughcontact.report.units import unit_of

# of one load: variable -> value in SI, and as the tables of a steel part of 1 mm write it, with its unit
SHOWN = {name: shown for name, *shown in cases_of("test_report_tables", "SHOWN")[1]}
SURFACE = {
    "contact_modulus": 115e9,
    "rms_height": 4e-7,
    "rms_gradient": 0.1,
    "Std": 0.0,
    "window_length_x": 1e-3,
    "window_length_y": 8e-4,
}


def one_load(**further):
    """Return the statistics of the load that `SHOWN` has."""
    data = {name: ("load", [value]) for name, (value, *_) in SHOWN.items()}
    return xr.Dataset(data | SURFACE | further)


def test_every_number_is_in_the_unit_of_its_column():
    tables = number_tables(one_load(), [["coarse patches", "not converged"]])
    cells_by_title = {}
    for table in tables:
        (row,) = table["rows"]
        assert row["flags"] == "coarse patches, not converged"
        assert table["header"][0][0] == "mean pressure"
        for (title, unit, meaning), cell in zip(table["header"], row["cells"], strict=True):
            assert meaning
            cells_by_title[title] = cell, unit
    assert list(cells_by_title.values()) == [(cell, unit) for _, cell, unit in SHOWN.values()]
    assert list(cells_by_title)[-2:] == ["error bound of the pressure", "contact on filled points"]
    titles = ["Contact", "Pressure", "Stress below the surface", "Gap and conductance", "Sealing", "Solution"]
    assert [table["title"] for table in tables] == titles
    body = {"contact_radius": ("load", [2e-4]), "force": ("load", [2.0])}
    for without_flow in ({"Std": np.nan, "window_length_y": np.nan}, body):
        tables = number_tables(one_load(**without_flow), [[]])
        assert [table["title"] for table in tables] == [title for title in titles if title != "Sealing"]


def test_columns_hold_their_loads_and_intervals():
    loads = {"mean_pressure": ("load", [1e6, 4e6]), "mean_gap": ("load", [2e-6, 1e-6])}
    bounds = {"mean_gap_lower": ("load", [1.8e-6, 0.7e-6]), "mean_gap_upper": ("load", [2.2e-6, 1.01e-6])}
    (table,) = number_tables(xr.Dataset(loads | bounds), [[], ["coarse patches"]])
    assert table["rows"] == [
        {"cells": ["1.00", "2.00 ± 0.20"], "flags": ""},
        {"cells": ["4.00", "1.000 −0.30 +0.010"], "flags": "coarse patches"},
    ]


@pytest.mark.parametrize(
    ("variables_dropped", "conducts"),
    [
        ((), Cell("8400 kW/(m² K)", "heat")),
        (("thermal_conductance",), Cell("5500 GS/m²", "current")),
        (("thermal_conductance", "electrical_conductance"), Cell("917 mm⁻¹", "by conductivity")),
    ],
)
def test_the_answers_at_a_glance(variables_dropped, conducts):
    limits = {"hardness": 8.76e8, "mean_gap_lower": ("load", [1.6e-6]), "mean_gap_upper": ("load", [1.8e-6])}
    open_along_y = {"gap_percolates_x": ("load", [0.0]), "gap_percolates_y": ("load", [1.0])}
    (row,) = glance_rows(one_load(**limits, **open_along_y).drop_vars(variables_dropped))
    space = "\N{NO-BREAK SPACE}"
    assert [*row.values()] == [
        Cell("2.50 MPa"),
        Cell("3.21 %"),
        Cell("77.9 MPa"),
        Cell("1.70 µm", "± 0.10", precision="to ± 10 %"),
        Cell(
            "seals along x, leaks along y",
            f"leak rate 0.0180{space}ml/(h{space}m) (y)",
            further=(f"narrowest place 0.830{space}µm (y)",),
        ),
        Cell("yes", "yielded asperities carry 25.0 % of the load"),
        Cell("876 MPa", "the hardness as stated"),
        conducts,
        Cell("not judged"),  # the radius of a body of finite size
        Cell("not judged"),  # its approach
        Cell("not judged"),  # friction
        Cell("not judged"),  # how warm it gets
    ]


def test_a_largest_pressure_below_the_hardness_has_its_interval():
    limits = {"hardness": 1e9, "max_pressure_lower": ("load", [8.6e8]), "max_pressure_upper": ("load", [9e8])}
    (row,) = glance_rows(one_load(**limits, load_share_above_hardness=("load", [0.0])))
    assert row["max_pressure"] == Cell("876 MPa", "−16 +24", precision="to ± 10 %")


@pytest.mark.parametrize(("name", "unit"), UNITS.items())
def test_every_number_of_the_tables_has_a_unit_of_its_dimension(name, unit):
    """Such as the kelvins of flash temperatures; "%" and "m along" are ways to write a share and a length."""
    assert unit_of(xr.Dataset(), unit).factor > 0
    assert unit.replace("%", "1").removesuffix(" along") == VARIABLES[name][0]


def test_a_cell_of_a_page_shows_all_its_parts():
    cell = Cell("1.43 %", "−0.2 +0.3", precision="to ± 20 %", remarks=(Remark("hardness"),))
    shown = re.sub(r"<[^>]*>", "|", str(template("cell.html").module.content(cell)))
    assert re.split(r"\|+", shown.strip("|")) == [cell.text, cell.details, cell.precision, str(*cell.remarks)]
    assert str(template("cell.html").module.content(Cell("no"))) == "no"
