"""The head of the page: bodies and loads in words."""

import pytest

from roughcontact.report.asked import asked_in_words

STEEL = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
COATED = STEEL | {"layers": [{"thickness": 2e-6, "youngs_modulus": 1.8e11, "poissons_ratio": 0.2}]}
SHEET = {"base": "rigid", "youngs_modulus": None, "layers": [{"thickness": 1e-3, "youngs_modulus": 6e6}]}
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
            "2.00 µm of 180 GPa over 210 GPa (ν 0.30) on 1.00 mm of 6.00 MPa over a rigid base; " + PLANNED,
        ),
    ],
)
def test_bodies_and_loads(contact, words):
    assert asked_in_words({"contact": contact}) == [("", words)]


def test_each_case_has_its_own():
    cases = {
        name: {"contact": {"contact_modulus": modulus, "target_gap": [1e-6]}}
        for name, modulus in (("soft", 1e6), ("stiff", 1e9))
    }
    assert asked_in_words(cases) == [
        ("soft", "contact modulus E* = 1.00 MPa; mean gap 1.00 µm"),
        ("stiff", "contact modulus E* = 1.00 GPa; mean gap 1.00 µm"),
    ]
