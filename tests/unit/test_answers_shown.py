"""What follows from the contact stands in the tables and facts of the report, where it is known."""

import pytest

import roughcontact as rc
from roughcontact.maps import height_map
from roughcontact.references.synthetic import rough_reference_surface
from roughcontact.report.facts import surface_facts
from roughcontact.report.tables import number_tables
from roughcontact.statistics.subsurface import with_subsurface_yield

BODIES = [
    {"poissons_ratio": 0.3, "yield_stress": 2e8, "thermal_conductivity": 50.0},
    {"poissons_ratio": 0.4, "yield_stress": 9e8, "thermal_conductivity": 0.3},
]


@pytest.fixture(scope="module")
def maps():
    height = height_map(1e-5 * rough_reference_surface(64).values, 1e-5 / 64)
    levelled = rc.level(height)
    return height, levelled, rc.periodic_window(levelled)


def shown(maps, **more):
    """Return titles and cells of the tables of numbers, and the facts, of two loads."""
    contact = rc.solve_contact(maps[2], contact_modulus=4e9, mean_pressure=[1e4, 2e8])
    numbers = with_subsurface_yield(rc.contact_statistics(contact, **more), more.get("bodies"))
    units, cells = {}, [{}, {}]
    for table in number_tables(numbers, [[], []]):
        units |= {title: unit for title, unit, _ in table["header"]}
        for known, row in zip(cells, table["rows"], strict=True):
            known |= {column[0]: cell for column, cell in zip(table["header"], row["cells"], strict=True)}
    return units, cells, dict(surface_facts(*maps, numbers))


def test_answers_that_need_materials_and_a_seal(maps):
    seal = {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}
    units, cells, facts = shown(maps, bodies=BODIES, seal=seal, work_of_adhesion=0.05)
    assert units["thermal conductance"].endswith("W/(m² K)")
    assert units["largest von Mises stress"] in ("MPa", "GPa")
    assert units["leak rate along x"] == "m²/s"
    assert float(cells[0]["narrowest place along x"]) > float(cells[1]["narrowest place along x"])
    assert facts["Adhesion"].startswith("not sticky")
    assert facts["First yield below the surface"].endswith("mean pressure")


def test_answers_that_nobody_asked_for_take_no_room(maps):
    units, _, facts = shown(maps, flow="never")
    assert "narrowest place along x" in units
    asked = {"thermal conductance", "largest von Mises stress", "leak rate along x", "flow factor along x"}
    assert not asked & set(units)
    assert not {"Adhesion", "First yield below the surface"} & set(facts)


def test_a_load_of_first_yield_that_is_not_known_is_said_so(maps):
    bodies = [body | {"yield_stress": 1.0} for body in BODIES]
    assert shown(maps, bodies=bodies)[2]["First yield below the surface"] == "not between the loads solved"
