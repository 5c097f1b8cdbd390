"""The head of the page: bodies and loads in words; the picture of the layers."""

import json
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
import pytest

from roughcontact.configuration.generated import changed_settings
from roughcontact.configuration.resolve import resolve
from roughcontact.maps import height_map
from roughcontact.report.asked import describe_problem, planned_in_words, same_loads
from roughcontact.report.stack import stack_of_layers

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
            "contact modulus E* = 1.00 GPa; p̄/(E* g) 0.0100, 0.100",
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
    planned, stated = {"contact": {"contact_modulus": 1e9}}, {"contact": {"mean_pressure": [1e6]}}
    assert same_loads({"rough": stated, "smooth": stated})
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
    seal = "statistics.seal: viscosity 0.00100 Pa s, pressure_difference 100 kPa, width 2.00 mm"
    changed = {case: changed_settings(own) for case, own in settings.items()}
    assert changed == {
        "plain": [seal],
        "cut": ["window.shortest_wavelength: 2.50 µm", seal, "uncertainty.sources: []"],
    }
    words = dict(describe_problem(settings, changed))
    assert words["plain"].endswith(f"hardness 100 MPa; loads planned for each map; {seal}")
    assert words["cut"].count("; ") == 4


def test_loads_that_are_planned_below_the_weight_of_a_sheet_are_explained():
    planned = {"contact": {"contact_modulus": 8e6}}
    loads = {(name, ""): 10.0 * place for place, name in enumerate("abcdefgh", start=8)}
    assert planned_in_words(planned, loads).startswith(
        "The planned loads of a, b begin at 80.0 Pa, less than"
    )
    lightest = dict.fromkeys(loads, 0.5)
    assert planned_in_words(planned, lightest).startswith(
        "The planned loads of a, b, c and 5 more begin at 500 mPa"
    )
    assert not planned_in_words({"contact": {"target_area": 0.1}}, lightest)
    cases = {"soft": planned, "given": {"contact": {"mean_pressure": [1.0]}}}
    assert "of a begin" in planned_in_words(cases, {("a", "soft"): 1.0, ("b", "given"): 1.0})


def test_the_picture_of_the_layers_has_the_settings_in_words_and_to_scale():
    config = {
        "contact": {
            "bodies": [
                STEEL
                | {
                    "name": "tool",
                    "layers": [
                        {"thickness": "5 um", "youngs_modulus": "180 GPa", "poissons_ratio": 0.2},
                        {"thickness": "800 nm", "youngs_modulus": "110 GPa", "poissons_ratio": 0.3},
                    ],
                },
                {
                    "base": "rigid",
                    "layers": [{"thickness": "2 mm", "youngs_modulus": "3 MPa", "poissons_ratio": 0.5}],
                },
            ]
        }
    }
    (found,) = resolve(config).values()
    bodies = found["contact"]["bodies"]
    image, words = stack_of_layers(bodies, height_map(np.zeros((50, 100)), 1e-6))
    expected = [
        "body 1 (tool), from its surface inwards",
        "layer 1: 5.00 µm of 180 GPa, ν 0.20",
        "layer 2: 800 nm of 110 GPa, ν 0.30",
        "elastic base: 210 GPa, ν 0.30",
        "body 2, from its surface inwards",
        "layer 1: 2.00 mm of 3.00 MPa, ν 0.50",
        "rigid base",
        "pixel 1.00 µm",
        "window 100 µm",
    ]
    assert words == "; ".join(expected)
    svg = ElementTree.fromstring(unquote(image.removeprefix("data:image/svg+xml,")))
    drawn = [element.text for element in svg.iter("{http://www.w3.org/2000/svg}text")]
    assert [text for text in drawn if text in expected] == expected
    ends = [
        path.get("d")
        for path in svg.iter("{http://www.w3.org/2000/svg}path")
        if path.get("stroke-width") == "3"
    ]
    places = {
        text: float(end[1:].split()[0]) for text, end in zip(expected[1:4] + expected[5:7], ends, strict=True)
    }
    _, low, high, _ = json.loads(svg.get("data-reading"))["x"]
    width = json.loads(svg.get("data-reading"))["area"][2]
    for text, thickness in zip((expected[1], expected[2], expected[5]), (5.0, 0.8, 2000.0), strict=True):
        assert places[text] == pytest.approx(width * np.log(thickness / low) / np.log(high / low), abs=0.06)
    assert places["rigid base"] == width
    assert "body 2: rigid" in stack_of_layers(bodies[:1], height_map(np.zeros((1, 9)), 1e-6))[1]
