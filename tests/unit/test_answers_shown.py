"""What follows from the contact stands in the tables and facts of the report, where it is known."""

import re
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact import height_map, self_affine_surface, write_dataset
from roughcontact.arguments.answers import AREA, ENDS
from roughcontact.report import glance, load_plots
from roughcontact.report.allowed import allowed_in_words
from roughcontact.report.charts import COLOURS
from roughcontact.report.facts import _closing, surface_facts
from roughcontact.report.tables import number_tables
from roughcontact.report.units import unit_of
from roughcontact.results.collect import collect_statistics, result_entry, solved_results
from roughcontact.statistics.subsurface import add_subsurface_yield
from roughcontact.surface.synthetic import rough_reference_surface

BODIES = [
    {"poissons_ratio": 0.3, "yield_stress": 2e8, "thermal_conductivity": 50.0},
    {"poissons_ratio": 0.4, "yield_stress": 9e8, "thermal_conductivity": 0.3},
]


@pytest.fixture(scope="module")
def maps():
    height = height_map(1e-5 * rough_reference_surface(64).values, 1e-5 / 64)
    levelled = rc.level(height)
    return height, levelled, rc.periodic_window(levelled)


def shown(maps, **options):
    """Return titles and cells of the tables of numbers, and the facts, of two loads."""
    contact = rc.solve_contact(maps[2], contact_modulus=4e9, mean_pressure=[1e4, 2e8])
    numbers = add_subsurface_yield(rc.contact_statistics(contact, **options), options.get("bodies"))
    units, cells = {}, [{}, {}]
    for table in number_tables(numbers, [[], []]):
        units |= {title: unit for title, unit, _ in table["header"]}
        for numbers_of_load, row in zip(cells, table["rows"], strict=True):
            numbers_of_load |= {
                column[0]: cell for column, cell in zip(table["header"], row["cells"], strict=True)
            }
    facts = surface_facts(*maps, numbers)
    return units, cells, {name: text for name, text in facts.items() if text}


def test_answers_that_need_materials_and_a_seal(maps):
    seal = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}
    units, cells, facts = shown(maps, bodies=BODIES, seal=seal, work_of_adhesion=0.05)
    assert units["thermal conductance"].endswith("W/(m² K)")
    assert units["largest von Mises stress"] == "MPa"
    assert units["leak rate along x"].endswith("l/(h m)")
    assert units["narrowest place along x"] == units["mean gap"]
    assert float(cells[0]["narrowest place along x"]) > float(cells[1]["narrowest place along x"])
    assert facts["Adhesion"].startswith("not sticky")
    assert facts["First yield below the surface"].endswith("mean pressure")


def test_answers_that_nobody_asked_for_take_no_room(maps):
    units, _, facts = shown(maps, flow="never")
    assert "narrowest place along x" in units
    unwanted = {"thermal conductance", "largest von Mises stress", "leak rate along x", "flow factor along x"}
    assert not unwanted & set(units)
    assert not {"Adhesion", "First yield below the surface"} & set(facts)


def test_a_load_of_first_yield_that_is_not_known_is_said_so(maps):
    for stress, side in ((1.0, "below"), (1e15, "above")):
        bodies = [body | {"yield_stress": stress} for body in BODIES]
        facts = shown(maps, bodies=bodies)[2]
        assert facts["First yield below the surface"] == f"{side} the loads solved"


def test_where_a_gap_closes_and_whether_that_is_in_doubt():
    numbers = xr.Dataset(
        {
            "mean_pressure": ("load", [1e6, 2e6, 5e6]),
            "relative_contact_area": ("load", [0.01, 0.1, 0.4]),
            "gap_percolates_x": ("load", [1.0, 1.0, 0.0]),
            "gap_percolates_y": ("load", [1.0, 0.0, 0.0]),
            "critical_constriction_x": ("load", [2e-6, 1e-6, 0.0]),
            "critical_constriction_y": ("load", [1e-6, 0.0, 0.0]),
            "critical_constriction_x_lower": ("load", [1.8e-6, 0.0, 0.0]),
            "critical_constriction_x_upper": ("load", [2.2e-6, 2e-6, 0.0]),
            "rms_gradient": 0.1,
            "Std": 0.0,
        }
    )
    (units,) = glance.glance_units([numbers])
    cells = [glance._seals(numbers, units, index) for index in range(3)]
    assert cells[0] == glance.Cell(
        "leaks", "narrowest place 2.00_±_0.20_µm (x), 1.00_µm (y)".replace("_", "\N{NO-BREAK SPACE}")
    )
    closed = numbers.assign({f"critical_constriction_{axis}": ("load", [2e-6, 0.0, 0.0]) for axis in "xy"})
    without_x = closed.drop_vars([f"critical_constriction_x_{side}" for side in ("lower", "upper")])
    assert glance._seals(without_x, units, 0).details == "narrowest place 2.00\N{NO-BREAK SPACE}µm (x and y)"
    assert cells[1].text == "seals along y, leaks along x"
    ends = {f"critical_constriction_y_{end}": ("load", [0.0, 0.0, 0.0]) for end in ("lower", "upper")}
    words = [glance._seals(numbers.assign(ends), units, index).precision for index in range(3)]
    assert words == ["decided", "not decided", "decided"]
    assert cells[2] == glance.Cell("seals", "gap closed along x and y")
    assert _closing(numbers) == "along x between 2.00 MPa and 5.00 MPa; along y between 1.00 MPa and 2.00 MPa"
    assert glance._seals(numbers.assign(window_length_y=float("nan")), units, 0).text == glance.NOT_JUDGED
    assert glance._seals(numbers.drop_vars("gap_percolates_x"), units, 0).text == glance.NOT_JUDGED


def test_the_leak_rate_of_a_seal_stands_beside_the_answer():
    """1 mm²/s by length is 3.6 litres an hour for each metre."""
    numbers = xr.Dataset(
        {
            "mean_pressure": ("load", [1e6]),
            "rms_gradient": 0.1,
            "gap_percolates_x": ("load", [1.0]),
            "gap_percolates_y": ("load", [0.0]),
            "critical_constriction_x": ("load", [2e-6]),
            "critical_constriction_y": ("load", [0.0]),
            "leak_rate_x": ("load", [1e-6]),
            "leak_rate_y": ("load", [0.0]),
        }
    )
    cell = glance._seals(numbers, *glance.glance_units([numbers]), 0)
    assert cell.text == "seals along y, leaks along x"
    assert cell.all_details.replace("\N{NO-BREAK SPACE}", " ") == (
        "leak rate 3600 ml/(h m) (x); narrowest place 2.00 µm (x)"
    )
    unsolved = numbers.assign(leak_rate_x=("load", [np.nan]))  # its flow did not converge
    two_loads = xr.concat([numbers, unsolved], "load", data_vars="minimal")
    details = glance._seals(two_loads, *glance.glance_units([numbers]), 1).all_details
    assert details.startswith("leak rate not known (x); narrowest place")


def test_lengths_of_the_table_have_one_unit_and_pressures_that_of_the_stiffest(maps):
    contacts = [
        rc.solve_contact(maps[2] * factor, contact_modulus=modulus, mean_pressure=[1e-4 * modulus])
        for factor, modulus in ((1.0, 4e9), (0.02, 4e9), (1.0, 4e6))
    ]
    results = [rc.contact_statistics(contact) for contact in contacts]
    rows = [glance.glance_rows(*pair)[0] for pair in zip(results, glance.glance_units(results), strict=True)]
    units_of_cells = [[cell.text.partition(" ")[2] for cell in [*row.values()][:4]] for row in rows]
    assert units_of_cells == [["MPa", "%", "MPa", units_of_cells[0][3]]] * 3
    assert glance.glance_rows(results[2])[0][glance.LOAD].text == "0.400 kPa"  # alone


def test_whether_a_body_yields_is_answered_where_it_can_be():
    load = xr.Dataset(
        {
            "contact_modulus": 1e11,
            "mean_contact_pressure": 2e9,
            "max_pressure": 5e9,
            "max_pressure_over_modulus": 0.05,
            "load_share_above_hardness": 0.25,
            "area_share_above_hardness": 0.1,
            "volume_above_yield": 1e-9,
        }
    )

    def answer(numbers):
        of_bodies = numbers[[name for name in ("contact_modulus", "hardness") if name in numbers]]
        of_load = numbers.drop_vars([*of_bodies]).expand_dims("load")
        return glance._yields(of_load.merge(of_bodies), {}, 0)

    flows = glance.Cell("yes", "yielded asperities carry 25.0 % of the load")
    assert answer(load.assign(hardness=3e9)) == flows
    below_surface = load.assign(load_share_above_hardness=0.0, hardness=3e9)
    assert answer(below_surface) == glance.Cell("yes", "below the surface")
    limited = below_surface.assign(volume_above_yield=0.0, max_pressure=3e9)
    assert answer(limited) == glance.Cell("no", "hardness just reached")
    elastic = below_surface.assign(volume_above_yield=0.0, max_pressure=1e9)
    assert answer(elastic.assign(max_pressure_upper=2e9)) == glance.Cell(
        "no", "hardness nowhere reached", precision="decided"
    )
    assert answer(elastic.assign(max_pressure_upper=3e9)) == glance.Cell(
        "no", "hardness nowhere reached", precision="not decided"
    )
    assert answer(load.assign(volume_above_yield=0.0)) == glance.Cell("no", "yield stress nowhere reached")
    assert answer(load.assign(volume_above_yield=np.inf)) == glance.Cell("yes", "below the surface")
    unknown = load.drop_vars("volume_above_yield")
    assert answer(unknown) == glance.Cell(glance.NOT_JUDGED, "no hardness stated; metals would yield")
    assert answer(unknown.assign(contact_modulus=1e6)) == glance.Cell(glance.NOT_JUDGED, "rubber-like")


@pytest.mark.parametrize("scale", [1e-4, 1.0, 100.0])
def test_the_axis_of_the_gap_spans_what_is_drawn(scale):
    gaps = {"mean_pressure": ("load", [1e6, 2e6]), "mean_gap": ("load", scale * np.array([6e-7, 3e-7]))}
    source = load_plots.gap_against_load(xr.Dataset(gaps).assign(rms_height=5e-7 * scale)).source()
    axes = ElementTree.fromstring(unquote(source.partition(",")[2])).find("{http://www.w3.org/2000/svg}svg")
    line = next(path for path in axes if path.get("stroke") == COLOURS[2])
    start, last = re.findall(r"(-?[\d.]+) (-?[\d.]+)", line.get("d"))
    share = (float(last[1]) - float(start[1])) / float(axes.get("height"))
    assert share == pytest.approx(np.log(2) / np.log(2 * 1.6**2), rel=0.01)


def test_periodic_results_beside_those_of_a_finite_body(tmp_path):
    """A case of the one kind has NaN for what only the other has, in the dataset of all."""
    contacts = {
        "whole": {"mean_pressure": "1 MPa"},
        "free": {"boundary": "free", "force": "1 mN"},
        "free2": {"boundary": "free", "force": "2 mN"},
    }
    runs = []
    for case, contact in contacts.items():
        result = rc.evaluate(
            self_affine_surface((48, 48), 1e-6, hurst=0.8, shortest=6e-6, longest=4e-5, rms_height=5e-9),
            contact={"contact_modulus": "2 GPa"} | contact,
            form={"radius": "1 mm"} if "force" in contact else None,
            uncertainty={"sources": []},
        )
        write_dataset(result, tmp_path / case / "a" / "statistics.nc")
        runs.append(result_entry(f"{case}/a", tmp_path / case / "a" / "statistics.nc"))
    series = {
        (labels["surface"], labels["case"]): data for labels, data in solved_results(collect_statistics(runs))
    }
    loads = {case: glance.glance_rows(data)[0][glance.LOAD].text for (_, case), data in series.items()}
    assert loads == {"whole": "1.00 MPa", "free": "1.00 mN", "free2": "2.00 mN"}
    assert glance.load_heading([*series.values()]) == "load"


def test_a_remark_of_several_answers_stands_once_in_the_line():
    ends = {"relative_contact_area_lower": 0.18, "relative_contact_area_upper": 0.22}
    ends |= {"mean_contact_pressure_lower": 4.5e7, "mean_contact_pressure_upper": 5.5e7}
    load = {"mean_pressure": 1e7, "relative_contact_area": 0.2, "mean_contact_pressure": 5e7} | ends
    load |= {"max_pressure": 1e8, "mean_gap": 1e-7, "load_share_above_hardness": 0.3}
    names = {name: ("load", [value]) for name, value in load.items()}
    numbers = xr.Dataset(names | {"hardness": 1e8, "contact_modulus": 1e9})
    line = glance.answer_line(numbers, 0, glance.glance_rows(numbers, indices=[0])[0])
    assert line.count("uncertainty of the hardness not included") == 1
    assert line.endswith("; uncertainty of the hardness not included.")


@pytest.mark.parametrize(("resistance", "text"), [(1.5e-8, "15.0 nΩ"), (2e-5, "20.0 µΩ"), (0.3, "300 mΩ")])
def test_a_resistance_has_the_prefix_that_brings_it_between_1_and_1000(resistance, text):
    numbers = {"total_electrical_resistance": [resistance], "resistance_holds": [1.0], "mean_pressure": [1e6]}
    numbers |= {"allowed_resistance": 1e-3, "contact_modulus": 1e11}
    bounds = {f"resistance_holds_from{end}": 1e6 for end in ENDS}
    words = str(allowed_in_words(numbers, "resistance", 0, brief=True))
    assert words == "of at most 1.00 mΩ: holds"  # below the number
    assert str(allowed_in_words(numbers | bounds, "resistance", 0)).startswith(
        f"resistance {text} at 1.00 MPa, "
    )
    assert unit_of(numbers, "Ohm").text(resistance) == text
    of_heat = unit_of({"total_thermal_resistance": [resistance]}, "K W-1").text(resistance)
    assert of_heat == text.replace("Ω", "K/W")


def test_the_total_of_a_joint_comes_first_with_what_is_allowed():
    joint = {"total_electrical_resistance": 5e-6, "resistance_holds": 1.0, "mean_pressure": 1e6}
    joint |= {"total_electrical_resistance_lower": 4e-6, "total_electrical_resistance_upper": 6e-6}
    joint |= {
        "relative_contact_area": 0.2,
        "max_pressure": 1e8,
        "mean_gap": 1e-7,
        "mean_contact_pressure": 5e6,
    }
    surface = {"allowed_resistance": 1e-3, "resistance_holds_from": 1e6, "contact_modulus": 1e11}
    surface |= {"resistance_holds_from_lower": 0.0, "resistance_holds_from_upper": 1e6}
    numbers = xr.Dataset({name: ("load", [value]) for name, value in joint.items()} | surface)
    line = glance.answer_line(numbers, 0, glance.glance_rows(numbers, indices=[0])[0])
    assert line == "Resistance 5.0 ± 1.0 µΩ at 1.00 MPa, of at most 1.00 mΩ: holds, from 1.00 MPa or less on."


def test_the_number_of_which_something_is_allowed_stands_in_the_place_of_the_conductance():
    """The resistance in µΩ, not a conductance in GS/m²."""
    joint = {"electrical_conductance": 5e9, "electrical_resistance": 2e-10, "mean_pressure": 1e6}
    joint |= {"total_electrical_resistance": 5e-6, "resistance_holds": 1.0, "relative_contact_area": 0.2}
    joint |= {"total_electrical_resistance_lower": 4e-6, "total_electrical_resistance_upper": 6e-6}
    joint |= {"max_pressure": 1e8, "mean_gap": 1e-7, "mean_contact_pressure": 5e6}
    limit = {"allowed_resistance": 1e-3, "joint_area": 4e-5, "contact_modulus": 1e11}
    limit |= dict.fromkeys([f"resistance_holds_from{end}" for end in ENDS], 1e6)
    numbers = xr.Dataset({name: ("load", [value]) for name, value in joint.items()} | limit)
    cell = glance.glance_rows(numbers)[0]["conductance"]
    assert (cell.text, cell.details) == ("5.0 µΩ", "± 1.0")
    assert cell.all_details == "± 1.0; of at most 1.00 mΩ: holds"
    assert [*map(str, cell.remarks)] == ["uncertainty of the resistivity not included"]
    assert glance.headings_of(["conductance"], [numbers]) == ["mean pressure", "resistance of the joint"]
    assert glance.headings_of(["conductance"], [numbers, numbers.drop_vars("resistance_holds")])[1] == (
        "conductance"
    )


def test_the_line_of_a_joint_with_an_area_has_its_resistance():
    """5.0e9 S/m² on 2 mm² are 0.1 mΩ."""
    joint = {"electrical_conductance": 5e9, "electrical_resistance": 2e-10, "mean_pressure": 1e6}
    joint |= {"total_electrical_resistance": 1e-4, "relative_contact_area": 0.2, "max_pressure": 1e8}
    joint |= {"mean_gap": 1e-7, "mean_contact_pressure": 5e6}
    loads = {name: ("load", [value]) for name, value in joint.items()}
    numbers = xr.Dataset(loads | {"contact_modulus": 1e11, "joint_area": 2e-6})
    line = glance.answer_line(numbers, 0, glance.glance_rows(numbers, indices=[0])[0])
    assert (
        line.replace("\N{NO-BREAK SPACE}", " ")
        == "At 1.00 MPa: conductance 5.00 GS/m² (current, 100 µΩ of the joint)."
    )
    # of metals heat is known as well: 1e5 W/(m² K) on 2 mm² are 5 K/W
    heat = {"thermal_conductance": 1e5, "thermal_resistance": 1e-5, "total_thermal_resistance": 5.0}
    both = numbers.assign({name: ("load", [value]) for name, value in heat.items()})
    cells = glance.glance_rows(both, indices=[0])[0]
    expected = "At 1.00 MPa: conductance 100 kW/(m² K) (heat, 5.00 K/W of the joint, 100 µΩ of the joint)."
    assert glance.answer_line(both, 0, cells).replace("\N{NO-BREAK SPACE}", " ") == expected
    # unless a flow of heat is stated
    asked = both.assign(temperature_drop=("load", [0.5]))
    assert "Ω" not in glance.glance_rows(asked, indices=[0])[0]["conductance"].details


def test_the_conductance_of_a_joint_is_that_with_its_gas():
    heat = {
        "thermal_conductance": 2.3e5,
        "joint_conductance": 2.6e5,
        "mean_pressure": 1e6,
    }
    heat |= {
        "relative_contact_area": 0.2,
        "max_pressure": 1e8,
        "mean_gap": 1e-7,
        "mean_contact_pressure": 5e6,
    }
    load = {name: ("load", [value]) for name, value in heat.items()}
    (cells,) = glance.glance_rows(xr.Dataset(load | {"contact_modulus": 1e11}), indices=[0])
    cell = cells["conductance"]
    assert cell.text == "260 kW/(m² K)"
    assert cell.details.endswith("heat through the joint")


def test_friction_says_what_it_takes_for_granted_and_how_warm_it_gets():
    """The ± of τ A/p̄ is that of the area: its largest cause is that of the area, τ without a range exact."""
    budget = {f"{AREA}_uncertainty": (("load", "source"), [[0.02, 0.03, 0.036]])}
    ends = {
        f"friction_coefficient{end}": ("load", [mu]) for end, mu in zip(ENDS, (0.2, 0.15, 0.25), strict=True)
    }
    numbers = xr.Dataset(
        budget
        | ends
        | {AREA: ("load", [0.1]), f"{AREA}_lower": ("load", [0.08]), "mean_gap": ("load", [1e-7])},
        {"mean_pressure": ("load", [5e7]), "source": ["window", "hardness", "combined"]},
    )
    numbers = numbers.assign(contact_modulus=1e11, rms_height=1e-7, hardness_lower=4e8)
    numbers["max_flash_temperature"] = "load", [12.0]
    columns = glance.asked_columns([numbers])
    assert columns == ["friction_coefficient", "max_flash_temperature"]
    units = glance.glance_units([numbers])[0]
    friction, warm = (glance.interval_cell(numbers, name, units, 0) for name in columns)
    assert [*map(str, friction.remarks)] == [
        "uncertainty mainly from the hardness",
        "uncertainty of the shear strength not included",
    ]
    assert (warm.text, warm.details) == ("12.0 K", "no ±")
