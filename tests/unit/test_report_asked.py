"""The head of the page: bodies and loads in words."""

import pytest

from roughcontact.arguments.settings.generated import changed_settings
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.report.asked import describe_problem, same_loads

STEEL = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
COATED = STEEL | {"layers": [{"thickness": 2e-6, "youngs_modulus": 1.8e11, "poissons_ratio": 0.2}]}
RUBBER = {"thickness": 1e-3, "youngs_modulus": 6e6, "poissons_ratio": 0.5}
SHEET = {"base": "rigid", "youngs_modulus": None, "layers": [RUBBER]}
COATED_STEEL = "2.00 µm of 180 GPa (ν 0.20) over 210 GPa (ν 0.30)"
CLOSING, PLANNED = "contact area 10.0 % and the load at which the gap closes", "loads planned for each map"


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        (
            {"contact_modulus": 1e9, "relative_pressure": [0.01, 0.1]},
            "contact modulus E* = 1.00 GPa; relative pressure 0.0100, 0.100",
        ),
        (
            {"contact_modulus": 1e9, "hardness": 3e8, "target_area": 0.1, "target": ["percolation"]},
            "contact modulus E* = 1.00 GPa, hardness 300 MPa; " + CLOSING,
        ),
        (
            {"bodies": [COATED, SHEET], "mean_pressure": None},
            f"{COATED_STEEL} on 1.00 mm of 6.00 MPa (ν 0.50) over a rigid base; {PLANNED}",
        ),
    ],
)
def test_bodies_and_loads(contact, words):
    assert describe_problem({"contact": contact}) == [("", words)]


def test_each_case_has_its_own():
    cases = {
        name: {"contact": {"contact_modulus": modulus, "target_gap": [1e-6]}}
        for name, modulus in (("soft", 1e6), ("stiff", 1e9))
    }
    assert describe_problem(cases) == [
        ("soft", "contact modulus E* = 1.00 MPa; mean gap 1.00 µm"),
        ("stiff", "contact modulus E* = 1.00 GPa; mean gap 1.00 µm"),
    ]


def test_planned_loads_are_not_the_same_in_order():
    planned, with_loads = {"contact": {"contact_modulus": 1e9}}, {"contact": {"mean_pressure": [1e6]}}
    assert same_loads({"rough": with_loads, "smooth": with_loads})
    assert not same_loads({"rough": planned, "smooth": planned})


def test_settings_that_differ_from_their_defaults_follow_each_with_its_unit():
    config = {
        "contact": {"contact_modulus": 1e9, "hardness": 1e8, "tolerance": 0.0001},
        "statistics": {"seal": {"viscosity": "1 mPa s", "pressure_difference": "1 bar", "width": "2 mm"}},
        "report": {"title": "Trial"},
        "cases": {
            "plain": {},
            "cut": {"window": {"shortest_wavelength": "2.5 um"}, "uncertainty": {"sources": []}},
        },
    }
    settings = resolve(config)
    seal = "statistics.seal: viscosity 1.00 mPa s, pressure_difference 100 kPa, width 2.00 mm"
    changed = {case: changed_settings(case_settings) for case, case_settings in settings.items()}
    assert changed == {
        "plain": [seal],
        "cut": ["window.shortest_wavelength: 2.50 µm", seal, "uncertainty.sources: []"],
    }
    words = dict(describe_problem(settings, changed))
    of_seal = "seal: viscosity 1.00 mPa s, pressure difference 100 kPa, width 2.00 mm"
    assert words["plain"].endswith(f"hardness 100 MPa; loads planned for each map; {of_seal}")
    assert words["cut"].count("; ") == 4


def test_units_and_ranges_are_those_that_people_read():
    joint = {"area": "4 cm2", "heat_flow": 20, "gas_conductivity": 0.026, "temperature_jump": "3.7 um"}
    steel = {"youngs_modulus": 2e11, "poissons_ratio": 0.3, "thermal_conductivity": 50}
    contact = {"bodies": [steel, steel], "hardness": 2e9, "hardness_uncertainty": [0.2, 0.3]}
    contact |= {"mean_pressure_uncertainty": 0.05, "mean_pressure": 1e6}
    seal = {"perimeter": 0.1, "allowed_leak": "1 ml/h", "viscosity": 1e-3, "pressure_difference": "1 bar"}
    config = {"contact": contact, "statistics": {"joint": joint, "seal": seal | {"width": "2 mm"}}}
    text = "; ".join(changed_settings(resolve(config)[""]))
    for words in (
        *("hardness_uncertainty: −20.0 % +30.0 %", "mean_pressure_uncertainty: ± 5.00 %"),
        *("area 400 mm²", "heat_flow 20.0 W", "gas_conductivity 0.0260 W/(m K)", "allowed_leak 1.00 ml/h"),
    ):
        assert words in text
