"""Slips of unit: what real materials and loads are passes, the same numbers in another unit are doubted."""

import pytest
from case_tables import cases_of

from roughcontact.arguments import materials
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.errors import SettingsError

# Young's modulus, Poisson's ratio, hardness: figures of handbooks, rounded (Ashby 2011; Tabor 1951; Johnson
# 1985; Levental, Georges and Janmey 2007 for tissue; Klein and Cardinale 1993 for diamond)
REAL = {name: numbers for name, *numbers in cases_of("test_plausible", "REAL")[1]}
RIGID = {"youngs_modulus": 1e20, "poissons_ratio": 0.3}


def body(material):
    """Return a material as the settings have it."""
    return dict(zip(("youngs_modulus", "poissons_ratio", "hardness"), REAL[material], strict=True))


def lines(contact, **sections):
    """Return the mistakes of a configuration."""
    with pytest.raises(SettingsError) as caught:
        resolve({"contact": contact, **sections})
    return [str(mistake) for mistake in caught.value.mistakes]


@pytest.mark.parametrize("against", [*REAL, "rigid"])
@pytest.mark.parametrize("material", REAL)
def test_real_pairs_under_real_loads_are_never_doubted(material, against):
    counter_body = RIGID if against == "rigid" else body(against)
    settings = resolve({"contact": {"bodies": [body(material), counter_body]}})[""]["contact"]
    modulus = settings["contact_modulus"]
    assert materials.doubt_of_modulus(modulus) is None
    loads = [max(100.0, 1e-8 * modulus * (1 + 1e-12)), 1e-4 * modulus, 0.01 * modulus, 0.3 * modulus]
    # below the weight of a centimetre of water a load needs its unit
    written = [load if load >= 100 else f"{load} Pa" for load in loads]
    resolve({"contact": {"contact_modulus": modulus, "mean_pressure": written}})


@pytest.mark.parametrize(
    "material", [name for name, (stiffness, *_) in REAL.items() if 1e9 <= stiffness < 1e12]
)
def test_a_modulus_in_gigapascal_is_asked_for(material):
    stiffness, ratio, hardness = REAL[material]
    wrong = {"youngs_modulus": stiffness / 1e9, "poissons_ratio": ratio, "hardness": hardness / 1e9}
    questions = lines({"bodies": [body(material), wrong]})
    for line, key, value in zip(
        questions, ("youngs_modulus", "hardness"), (stiffness, hardness), strict=True
    ):
        assert line.startswith(f"contact.bodies[1].{key} = ")
        assert materials.quantity(value, "Pa") in line.partition("did you mean ")[2].partition("?")[0]


@pytest.mark.parametrize("material", ["aluminium alloy", "glass", "mild steel", "tungsten carbide"])
def test_a_youngs_modulus_in_megapascal_is_that_of_a_gel_with_the_wrong_poissons_ratio(material):
    stiffness, ratio, _ = REAL[material]
    doubt = materials.doubt_of_body(stiffness / 1e6, ratio)
    assert doubt.candidates == (pytest.approx(stiffness),)
    assert "as soft as a gel" in doubt.question()


@pytest.mark.parametrize("load", [0.5, 1, 5, 20])
@pytest.mark.parametrize("material", ["peek", "aluminium alloy", "mild steel", "alumina"])
def test_a_load_in_megapascal_is_asked_for(material, load):
    stiffness = REAL[material][0]
    (question,) = lines({"contact_modulus": stiffness, "mean_pressure": load})
    assert question.startswith(f"contact.mean_pressure[0] = {load}: ")
    assert f"did you mean {materials.quantity(load * 1e6, 'Pa')}" in question
    assert "write the unit" in question


def test_a_force_over_an_area_is_judged_as_the_pressure_that_it_is():
    steel = {"contact_modulus": "115 GPa"}
    (question,) = lines(steel | {"force": "50 N", "area": 3})
    assert question.startswith("contact.area = 3: force by area, 16.7 Pa is next to no load on")
    assert "A bare number is in m²: write the unit" in question
    (question,) = lines(steel | {"force": 30, "area": "3 m2"})
    assert question.startswith("contact.force[0] = 30: force by area, 10.0 Pa is next to no load on")
    assert "A bare number is in N: write the unit" in question
    resolve({"contact": steel | {"force": "30 N", "area": "3 m2"}})


def test_that_of_diamond_is_that_of_a_gel_with_the_wrong_poissons_ratio():
    stiffness, ratio, _ = REAL["diamond"]
    wrong = {"youngs_modulus": stiffness / 1e9, "poissons_ratio": ratio, "hardness": "100 GPa"}
    (line,) = lines({"bodies": [body("diamond"), wrong]})
    assert line.startswith("contact.bodies[1].youngs_modulus = 1143.0: 1.14 kPa is as soft as a gel")


def test_both_unit_errors_of_a_run_are_reported_at_once():
    modulus, load = lines({"contact_modulus": 115, "mean_pressure": 1})
    assert modulus.startswith("contact.contact_modulus = 115: 115 Pa is softer than any gel")
    assert "did you mean 115 GPa or 115 MPa?" in modulus
    assert load.startswith("contact.mean_pressure[0] = 1: 1.00 Pa is next to no load (100 Pa)")
    assert "did you mean 1.00 MPa or 1.00 kPa?" in load


def test_a_modulus_in_megapascal_is_asked_for_where_the_load_or_the_hardness_speaks_against_a_gel():
    """115000 may be a gel of 115 kPa: under 1 kPa it is, under 1 MPa, or with a hardness of 2 GPa, steel."""
    for load in (1e2, 1e3, 3e4, 1e5):
        resolve({"contact": {"contact_modulus": 115000, "mean_pressure": load}})
    for load in (1e6, "1 MPa", [1e5, 1e8]):
        (question,) = lines({"contact_modulus": 115000, "mean_pressure": load})
        assert question.startswith("contact.contact_modulus = 115000: 115 kPa ")
        assert "did you mean 115 GPa" in question
    (question,) = lines({"contact_modulus": 115000, "relative_pressure": 0.1, "hardness": "2 GPa"})
    assert "does not bear 2.00 GPa; did you mean 115 GPa?" in question
    # meant, and then it is the load that is asked for
    (question,) = lines({"contact_modulus": "115 kPa", "mean_pressure": 1e6})
    assert question.startswith("contact.mean_pressure[0] = 1000000.0: 1.00 MPa ")


def test_modulus_and_load_in_megapascal_are_asked_for_together():
    for load in (2, 20):  # a laboratory may load a gel so, and writes the unit
        (line,) = lines({"contact_modulus": 115_000, "mean_pressure": load})
        assert f": {load}" in line
        assert f"did you mean {materials.quantity(load * 1e6, 'Pa')} or " in line
        resolve({"contact": {"contact_modulus": "115 kPa", "mean_pressure": f"{load} Pa"}})


def test_unit_errors_are_named_beside_mistakes_of_other_kinds():
    named = lines({"contact_modulus": 115, "mean_pressure": [1, 2], "tolerance": 2}, level={"from": "plane"})
    assert [line.split(" = ")[0].split(":")[0].strip() for line in named] == [
        "level.from",
        "contact.contact_modulus",
        "contact.mean_pressure[0]",
        "contact.mean_pressure[1]",
        "contact.tolerance",
    ]


def test_what_is_written_with_its_unit_is_meant():
    settings = resolve({"contact": {"contact_modulus": "115 Pa", "mean_pressure": ["1 mbar", "1e-3 Pa"]}})[""]
    assert settings["contact"]["contact_modulus"] == 115.0
    assert settings["contact"]["mean_pressure"] == [100.0, 1e-3]
    (question,) = lines({"contact_modulus": "115 GPa", "mean_pressure": ["1 Pa", 1]})
    assert question.startswith("contact.mean_pressure[1] = 1: ")
    slow = {"youngs_modulus": "210 kPa", "poissons_ratio": 0.3, "hardness": "2 Pa"}
    assert resolve({"contact": {"bodies": [slow, body("peek")]}})[""]["contact"]["hardness"] == 2.0


def test_a_number_with_a_unit_is_taken_wherever_a_quantity_is_set():
    config = {
        "contact": {
            "bodies": [
                {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3, "hardness": "2 kN/mm2"},
                {"youngs_modulus": "4000 N/mm2", "poissons_ratio": "0.4"},
            ],
            "mean_pressure": ["1 MPa", "0.5 N/mm2", 3e6, "2e6"],
        },
        "level": {"s_filter": "2.5 µm", "l_filter": "0.8 mm"},
        "window": {"shortest_wavelength": "2 um", "longest_wavelength": "100000 nm"},
        "composite": {"rotations": ["90 deg", 45, "3.141592653589793 rad"]},
    }
    settings = resolve(config)[""]
    assert [body_settings["youngs_modulus"] for body_settings in settings["contact"]["bodies"]] == [
        2.1e11,
        4e9,
    ]
    assert settings["contact"]["hardness"] == 2e9
    assert settings["contact"]["mean_pressure"] == [1e6, 5e5, 3e6, 2e6]
    assert (settings["level"]["s_filter"], settings["level"]["l_filter"]) == (2.5e-6, 8e-4)
    assert settings["window"]["shortest_wavelength"] == 2e-6
    assert settings["window"]["longest_wavelength"] == 1e-4
    assert settings["composite"]["rotations"] == [90.0, 45.0, 180.0]
    contact = resolve({"contact": {"contact_modulus": "115 GPa", "hardness": "7.5 GPa"}})[""]["contact"]
    assert (contact["contact_modulus"], contact["hardness"]) == (115e9, 7.5e9)


def test_a_slip_in_a_case_is_named_as_its_own():
    config = {"contact": {"contact_modulus": 1e9}, "cases": {"fine": {}, "steel": {"contact": {}}}}
    config["cases"]["steel"]["contact"]["contact_modulus"] = 115
    with pytest.raises(SettingsError) as caught:
        resolve(config)
    (mistake,) = caught.value.mistakes
    assert str(mistake).startswith("cases.steel.contact.contact_modulus = 115: ")
    assert mistake.keys == ("contact.contact_modulus",)


def test_a_load_that_the_softer_body_does_not_bear_is_refused_before_anything_runs():
    pair = [body("peek"), body("bearing steel")]
    resolve({"contact": {"bodies": pair, "mean_pressure": "299 MPa"}})
    (line,) = lines({"bodies": pair, "mean_pressure": ["1 MPa", "300 MPa"]})
    assert line == (
        "contact.mean_pressure = 3e+08 Pa is not below the hardness 3e+08 Pa: no contact carries it"
    )


def test_the_softer_body_gives_the_hardness():
    for pair in ([body("peek"), body("bearing steel")], [body("bearing steel"), body("peek")]):
        assert resolve({"contact": {"bodies": pair}})[""]["contact"]["hardness"] == 3e8
    bodies = [body("natural rubber"), body("bearing steel")]
    assert resolve({"contact": {"bodies": bodies}})[""]["contact"]["hardness"] == 7.5e9
    none = [body("natural rubber"), body("silicone")]
    assert resolve({"contact": {"bodies": none}})[""]["contact"]["hardness"] is None
    assert resolve({"contact": {"bodies": none, "hardness": 1e7}})[""]["contact"]["hardness"] == 1e7
    (line,) = lines({"bodies": bodies, "hardness": 2e9})
    assert line.startswith("contact: hardness given of the contact and of a body")
