"""One result has one face: every exit has the same digits of a number, and the same words for it.

The truth is the number in the file of statistics, which the exits round by its own interval.
"""

import re

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact import self_affine_surface, summary, table, with_interval
from roughcontact.arguments.answers import (
    ANSWERS,
    AREA,
    COMPARED,
    GAP,
    PEAK,
    PRESSURE,
    QUANTITIES,
    TITLES,
    UNITS,
)
from roughcontact.arguments.variables import VARIABLES
from roughcontact.interface.command_line import answers
from roughcontact.report.glance import (
    HEADINGS,
    LOAD,
    NOT_JUDGED,
    answer_line,
    asked_columns,
    glance_rows,
    headings_of,
)
from roughcontact.report.groups import group_headings, group_rows
from roughcontact.report.methods import methods_paragraph
from roughcontact.report.panel import each_load
from roughcontact.report.tables import number_tables
from roughcontact.report.units import unit_of
from roughcontact.uncertainty.group_tables import NamedGroup

ENDS = ("", "_lower", "_upper")
STEEL = {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3}
CONDUCTOR = {"thermal_conductivity": 50, "electrical_resistivity": 1e-7}
COATING = {"thickness": "4 um", "youngs_modulus": "70 GPa", "poissons_ratio": 0.2}
KINDS = {
    "periodic map": {"contact_modulus": "1 GPa", "relative_pressure": [0.02, 0.3]},
    "hardness": {"contact_modulus": "1 GPa", "relative_pressure": [0.02, 0.3], "hardness": "0.2 GPa"},
    "layers": {"bodies": [STEEL | {"layers": [COATING]}, STEEL], "mean_pressure": ["500 MPa"]},
    "seal and joint": {
        "bodies": [
            STEEL | {"thermal_conductivity": 50, "electrical_resistivity": 1e-7, "yield_stress": "3 GPa"}
        ]
        * 2,
        "mean_pressure": ["50 MPa", "1 GPa"],
    },
    "finite body": {"contact_modulus": "2 GPa", "boundary": "free", "force": ["1 mN", "4 mN"]},
    "profile": {"contact_modulus": "1 GPa", "relative_pressure": [0.05]},
    "pair": {"contact_modulus": "1 GPa", "relative_pressure": [0.05, 0.2]},
}


def top_material(kind):
    """Return a map that is solved in no time: waves of 4 µm and longer, on 32 µm."""
    shape = (1, 256) if kind == "profile" else (32, 32)
    waves = {"hurst": 0.8, "shortest": 6e-6, "longest": 3.2e-5, "seed": 5}
    height = self_affine_surface(shape, 1e-6, rms_height=1e-7, **waves)
    if kind == "pair":  # the heights of both faces together
        return height + self_affine_surface(shape, 1e-6, rms_height=1e-7, **waves | {"seed": 6}).values
    return height * 0.05 if kind == "finite body" else height


@pytest.fixture(scope="module", params=KINDS)
def result(request):
    kind = request.param
    settings = {"form": {"radius": "1 mm"}} if kind == "finite body" else {}
    if kind == "seal and joint":
        settings["statistics"] = {"seal": {"viscosity": 1e-3, "pressure_difference": 1e5, "width": 1e-3}}
    return rc.evaluate(top_material(kind), contact=KINDS[kind], **settings)


def words(text):
    """Return a text with plain spaces, as cells are wrapped."""
    return " ".join(text.split())


def marked(text):
    """Return a text without the bar of p̄, a character that takes no room."""
    return text.replace("\N{COMBINING MACRON}", "")


def expected(result, name, load):
    """Return the digits of a number with its interval, from the file, and its unit."""
    unit = unit_of(result, UNITS[name])
    ends = [float(result[f"{name}{end}"][load]) if f"{name}{end}" in result else np.nan for end in ENDS]
    hardness = float(result.get("hardness", np.inf))
    if name == PEAK and ends[0] >= hardness * (1 - 1e-9):  # is exact, as the hardness is
        ends[1:] = np.nan, np.nan
    return with_interval(*(unit.factor * end for end in ends)), unit.symbol


def loads_of(result):
    return range(result.sizes["load"])


def test_the_page_has_the_digits_of_the_file(result):
    for load, cells in zip(loads_of(result), glance_rows(result, indices=loads_of(result)), strict=True):
        for name in COMPARED:
            cell, (digits, unit) = cells[name], expected(result, name, load)
            number, _, interval = digits.partition(" ")
            assert cell.text == f"{number} {unit}"
            assert cell.details in (interval.strip("()"), "the hardness as stated")


def test_the_screen_has_the_cells_of_the_page(result, monkeypatch):
    monkeypatch.setattr(answers, "_TABLE_WIDTH", 2000)  # no cell is wrapped
    rows = glance_rows(result, indices=loads_of(result))
    every_load = glance_rows(result, indices=range(result.sizes["load"]))
    lines = [marked(line) for line in answers.answers(result, every_load, [[]] * result.sizes["load"])]
    columns = asked_columns([result])
    judged, asked = {}, headings_of(columns, [result])
    for heading, name in zip(asked, [LOAD, *columns], strict=True):
        cells = [row[name] for row in rows]
        if any(cell.text != NOT_JUDGED for cell in cells):
            texts = [text for cell in cells for text in (cell.text, cell.all_details, cell.known)]
            judged[marked(heading)] = marked(words(" ".join([heading, *texts])))
    table, unanswered = lines, ""
    if lines[-1].startswith(f"  {NOT_JUDGED} "):
        *table, unanswered = lines
    starts = [table[0].index(heading) for heading in judged]
    for start, end, text in zip(starts, [*starts[1:], None], judged.values(), strict=True):
        assert words(" ".join(line[start:end] for line in table)) == text
    missing = [heading for heading in asked if marked(heading) not in judged]
    assert missing == re.findall(r"seals\?|yields\?|conductance", unanswered)


def test_the_words_of_each_load_are_those_of_its_cells(result):
    rows = glance_rows(result, indices=loads_of(result))
    for index, (cells, (_, text, *_)) in enumerate(zip(rows, each_load(result, []), strict=True)):
        assert text.startswith(answer_line(result, index, cells, alone=True))
        for name, cell in cells.items():
            # what is not asked for needs no words at each load
            words = f"{ANSWERS[name].words if name in ANSWERS else HEADINGS[name]} {cell.text}".lower()
            if name in asked_columns([result]):
                assert all(
                    part in text for part in (cell.text, *cell.all_details.split("; "), cell.precision)
                )
            else:
                assert name == LOAD or words not in text.lower()


def test_all_numbers_have_the_same_digits(result):
    columns = {}
    for section in number_tables(result, [[]] * result.sizes["load"]):
        for (title, unit, _), *cells in zip(
            section["header"], *(row["cells"] for row in section["rows"]), strict=True
        ):
            columns.setdefault(title, (unit, cells))
    for name in COMPARED:
        digits, units = zip(*(expected(result, name, load) for load in loads_of(result)), strict=True)
        assert columns[TITLES[name]] == (units[0], list(digits))


def test_a_group_of_one_map_has_the_cells_of_the_map(result):
    answer = rc.group_statistics([result])
    (row,) = group_rows([NamedGroup("one", None, answer)], columns=COMPARED)
    loads = loads_of(result) if result.sizes["load"] <= 3 else None
    for cells, of_group in zip(glance_rows(result, indices=loads), row["rows"], strict=True):
        grouped = dict(zip(group_headings(COMPARED).values(), of_group, strict=True))
        for name in COMPARED:
            assert grouped[TITLES[name]] == cells[name]._replace(outcome="")


def test_the_methods_have_the_digits_of_the_page(result):
    text = methods_paragraph(result)
    for load in loads_of(result):
        area, pressure, gap = (" ".join(expected(result, name, load)) for name in (AREA, PRESSURE, GAP))
        assert f"gives a true contact area of {area} of the" in text
        assert f"a mean pressure in contact of {pressure} and a mean gap of {gap}." in text


def test_the_files_have_the_numbers_behind_the_words(result):
    rows = summary(result).set_index(["quantity", "load"])
    frame = table(result)
    loads = result["force" if "force" in result else "mean_pressure"].values
    for index, cells in enumerate(glance_rows(result, indices=loads_of(result))):
        for name, cell in ((name, cells[name]) for name in ANSWERS):
            if not ANSWERS[name].quantity or f"{ANSWERS[name].quantity}_lower" not in result:
                continue
            known = float(result[f"{name}_known"][index])
            np.testing.assert_equal(known, frame[f"{name}_known"][index])
            np.testing.assert_equal(known, rows.loc[(ANSWERS[name].quantity, loads[index]), "known"])
            if name in COMPARED and cell.precision.startswith("to ±"):
                assert float(cell.precision.split()[2]) >= 100 * known
            elif name in COMPARED and cell.precision:
                assert not known <= 0.3


@pytest.mark.parametrize("name", QUANTITIES)
def test_a_quantity_of_the_table_is_a_variable_with_a_unit(name):
    assert VARIABLES[name][0]
    assert name not in UNITS or unit_of(xr.Dataset(), UNITS[name]).factor > 0
