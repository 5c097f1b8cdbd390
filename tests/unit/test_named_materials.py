"""Materials by name: the table against physics and books, and how settings and commands take a name."""

import re

import numpy as np
import pytest
import xarray as xr

from roughcontact import SettingsError, evaluate, material, solve_contact
from roughcontact.arguments import materials, named_materials
from roughcontact.arguments.measurement import json_attributes
from roughcontact.arguments.ranges import ends, shares_of_range
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.interface.command_line.options import parse_bodies
from roughcontact.report.asked import bodies_in_words
from roughcontact.statistics.conductance import conductivity_ranges
from roughcontact.statistics.contact_checks import units
from roughcontact.statistics.outcome import PASSED, REVIEW
from roughcontact.surface.synthetic import rough_reference_surface

PURE = [
    "copper",
    "gold",
    "silver",
    "aluminium",
    "tin",
    "nickel",
    "platinum",
    "lead",
    "zinc",
    "molybdenum",
    "tungsten",
]


@pytest.mark.parametrize("name", named_materials.material_names())
def test_values_lie_in_their_ranges_and_are_plausible(name):
    properties = named_materials._properties(name)
    for value, lowest, highest in properties.values():
        assert 0 < lowest <= value <= highest
    modulus, ratio = properties["youngs_modulus"].value, properties["poissons_ratio"].value
    assert materials.doubt_of_body(modulus, ratio) is None
    if "hardness" in properties:
        assert materials.doubt_of_hardness(properties["hardness"].value, modulus) is None
        assert properties["hardness"].highest <= 0.15 * modulus  # fused silica comes nearest
    assert named_materials._row(name)["source"]
    resolve({"contact": {"bodies": [name, name]}})


@pytest.mark.parametrize("name", PURE)
def test_metals_obey_the_law_of_wiedemann_and_franz(name):
    """Conductivity times resistivity is 2.44e-8 V2/K2 times the temperature, to a quarter."""
    properties = material(name)
    product = properties["thermal_conductivity"] * properties["electrical_resistivity"]
    assert product == pytest.approx(2.44e-8 * 295, rel=0.25)


@pytest.mark.parametrize(
    ("name", "shore"),
    [("NBR", 70), ("EPDM", 70), ("FKM", 75), ("silicone", 50), ("natural-rubber", 50), ("polyurethane", 90)],
)
def test_moduli_of_elastomers_follow_from_their_hardness(name, shore):
    """Gent (1958), with five degrees of Shore A on either side for the range."""

    def gent(hardness):
        return 1e6 * 0.0981 * (56 + 7.62336 * hardness) / (0.137505 * (254 - 2.54 * hardness))

    modulus = named_materials._properties(name)["youngs_modulus"]
    np.testing.assert_allclose(modulus, [gent(shore + offset) for offset in (0, -5, 5)], rtol=0.05)


def test_an_elastomer_has_the_modulus_of_its_hardness():
    """The row of the table is that of 70 Shore A; each five degrees are a quarter or more of the modulus."""
    named, of_table = named_materials._properties("NBR 70 Shore A"), named_materials._properties("NBR")
    np.testing.assert_allclose(named["youngs_modulus"], of_table["youngs_modulus"], rtol=0.02)
    seal, plain = material("nitrile-60 ShA"), material("NBR")
    assert seal["name"] == "NBR 60 Shore A"
    assert {**plain, "name": "", "youngs_modulus": 0} == {**seal, "name": "", "youngs_modulus": 0}
    assert parse_bodies([["NBR", "70", "Shore", "A"], ["steel"]]) == ["NBR 70 Shore A", "steel"]
    for name, words in (("steel 70", "is no elastomer"), ("NBR 99 Shore A", "from 20 to 95")):
        with pytest.raises(SettingsError, match=words):
            material(name)


@pytest.mark.parametrize(
    ("name", "key", "book"),
    [  # Incropera's table of metals (300 K), and tables of strength of Philpot (2017)
        ("gold", "thermal_conductivity", 317),
        ("lead", "thermal_conductivity", 35.3),
        ("silver", "thermal_conductivity", 429),
        ("silicon", "thermal_conductivity", 148),
        ("aluminium-6061", "yield_stress", 276e6),
        ("titanium-6Al-4V", "yield_stress", 827e6),
        ("stainless-steel", "youngs_modulus", 193e9),
        ("ductile-iron", "youngs_modulus", 168e9),
    ],
)
def test_values_are_those_of_books(name, key, book):
    assert material(name)[key] == pytest.approx(book, rel=0.005)


def test_a_name_is_a_body_and_what_is_stated_goes_before_the_table():
    steel, seal = named_materials.named_bodies(["Mild Steel", {"material": "nbr", "youngs_modulus": 8e6}])
    assert steel["name"] == "steel"
    assert seal["youngs_modulus"] == 8e6
    assert seal["poissons_ratio"] == 0.5
    # an insulator: nothing of the current is asked
    assert "electrical_resistivity" not in steel
    assert steel["thermal_conductivity"] == 52.0


def test_a_layer_has_a_name_and_its_hardness_is_that_of_the_surface():
    coated = {"material": "copper", "layers": [{"material": "gold", "thickness": "2 um"}]}
    contact = resolve({"contact": {"bodies": [coated, "hard-gold"]}})[""]["contact"]
    (layer,) = contact["bodies"][0]["layers"]
    gold, copper, hard = map(material, ("gold", "copper", "hard-gold"))
    assert layer["youngs_modulus"] == gold["youngs_modulus"]
    assert layer["electrical_resistivity"] == gold["electrical_resistivity"]
    assert bodies_in_words(contact).startswith("2.00 µm of gold (77.0 GPa, ν 0.42) over copper (115 GPa, ")
    assert contact["bodies"][0]["electrical_resistivity"] == copper["electrical_resistivity"]
    assert contact["hardness"] == min(gold["hardness"], hard["hardness"]) != copper["hardness"]
    assert contact["contact_modulus"] == pytest.approx(materials.contact_modulus([gold, hard]))
    # no wave feels another stack than gold or copper alone, with the wider of both ranges
    ranges = [
        named_materials.modulus_uncertainty(named_materials.named_bodies([name, "hard-gold"]))
        for name in ("gold", "copper")
    ]
    assert max(ranges) <= contact["contact_modulus_uncertainty"] < 1.2 * max(ranges)
    assert contact["hardness_uncertainty"] == shares_of_range(
        *named_materials._properties("gold")["hardness"]
    )
    assert resolve({"contact": {"bodies": [coated | {"hardness": 2e9}, "copper"]}})[""]["contact"][
        "hardness"
    ] == min(2e9, copper["hardness"])


def test_a_hardness_of_the_contact_goes_before_those_of_the_table():
    contact_settings = {"bodies": ["steel", {"material": "PEEK"}], "hardness": "1 GPa"}
    contact = resolve({"contact": contact_settings})[""]["contact"]
    assert contact["hardness"] == 1e9
    assert [body["hardness"] for body in contact["bodies"]] == [None, None]


def test_a_layer_of_numbers_leaves_the_hardness_and_the_conductivities_of_its_base_out():
    layer = {"thickness": "2 um", "youngs_modulus": "180 GPa", "poissons_ratio": 0.2}
    bodies = resolve({"contact": {"bodies": [{"material": "steel", "layers": [layer]}, "copper"]}})
    contact = bodies[""]["contact"]
    assert contact["hardness"] == material("copper")["hardness"]
    assert [body["thermal_conductivity"] for body in contact["bodies"]] == [None, None]


def test_the_range_of_the_modulus_becomes_the_uncertainty_of_the_contact_modulus():
    contact = resolve({"contact": {"bodies": ["steel", "PTFE"]}})[""]["contact"]
    assert contact["contact_modulus_uncertainty"] == 0.15  # PTFE: 0.40 to 0.55 of 0.5 GPa, steel is stiff
    equal_bodies = named_materials.modulus_uncertainty(named_materials.named_bodies(["steel", "steel"]))
    assert equal_bodies == pytest.approx(15 / 2 / 207 / np.sqrt(2), abs=6e-4)
    settings = resolve({"contact": {"bodies": ["steel", "PTFE"], "contact_modulus_uncertainty": 0.02}})[""]
    assert settings["contact"]["contact_modulus_uncertainty"] == 0.02
    own_body = {"material": "PTFE", "youngs_modulus": "0.6 GPa"}
    steel = resolve({"contact": {"bodies": ["steel", own_body]}})[""]["contact"]
    assert steel["contact_modulus_uncertainty"] < 1e-3


def test_a_range_is_stated_in_three_ways_and_goes_before_that_of_the_table():
    for own in (
        {"hardness": ["1.2 GPa", "1.8 GPa"]},
        {"hardness": "1.2..1.8GPa"},
        {"hardness": 1.5e9, "hardness_uncertainty": 0.2},
    ):
        contact = resolve({"contact": {"bodies": ["hard-gold", {"material": "steel", **own}]}})[""]["contact"]
        assert contact["bodies"][1]["hardness"] == 1.5e9
        lowest, highest = ends(contact["hardness"], contact["hardness_uncertainty"])
        # the softer of the two: of hard gold, 1.3 to 2.1 GPa, and of this steel
        assert (lowest, highest) == pytest.approx((1.2e9, 1.8e9), rel=1e-5)
    exact = {"material": "steel", "hardness": "1.5 GPa"}
    contact = resolve({"contact": {"bodies": [exact, exact]}})[""]["contact"]
    assert contact["hardness_uncertainty"] is None
    settings = {"bodies": ["steel", "steel"], "hardness_uncertainty": 0.1}
    assert resolve({"contact": settings})[""]["contact"]["hardness_uncertainty"] == [0.1]


def test_the_ranges_of_conductivities_are_of_the_mean_of_both_bodies():
    """In series their resistances add: half the variances where both bodies have the same range."""
    ranges = conductivity_ranges(named_materials.named_bodies(["steel", "steel"]))
    mean, lowest, highest = ranges["electrical_resistivity"]
    assert (mean, lowest, highest) == pytest.approx(
        (160e-9, 160e-9 - 20e-9 / np.sqrt(2), 160e-9 + 40e-9 / np.sqrt(2)), rel=1e-5
    )
    mean, lowest, highest = ranges["thermal_conductivity"]
    resistance = np.array([1 / 45, 1 / 60]) - 1 / 52
    assert (1 / lowest, 1 / highest) == pytest.approx(1 / 52 + resistance / np.sqrt(2), rel=1e-5)
    with_film = {"material": "steel", "layers": [{"material": "hard-gold", "thickness": "2 um"}]}
    mean, lowest, highest = conductivity_ranges(named_materials.named_bodies([with_film, "steel"]))[
        "electrical_resistivity"
    ]
    assert (lowest / mean, highest / mean) == pytest.approx((0.8, 4 / 3), rel=1e-5)  # of the gold
    assert conductivity_ranges([{"electrical_resistivity": 1e-7}] * 2) == {}


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(SettingsError, match=r"contact\.bodies: 'stel' is no material .* did you mean steel"):
        resolve({"contact": {"bodies": ["stel", "NBR"]}})
    with pytest.raises(SettingsError, match="or give youngs_modulus and poissons_ratio"):
        material("unobtainium")


def test_the_option_takes_a_name():
    assert parse_bodies([["steel"], ["4GPa", "0.4"]])[0] == "steel"
    gold = {"material": "copper", "layers": [{"thickness": "2um", "material": "gold"}]}
    assert parse_bodies([["copper", "layer=2um,gold"], ["steel"]])[0] == gold
    with pytest.raises(SettingsError, match="210GPa: has 1 values; give the name of a material"):
        parse_bodies([["210GPa"], ["steel"]])
    unequal = parse_bodies([["4GPa", "0.4", "youngs_modulus_uncertainty=0.1 0.2"], ["steel"]])
    contact = resolve({"contact": {"bodies": unequal, "mean_pressure": 1e6}})[""]["contact"]
    assert contact["bodies"][0]["youngs_modulus_uncertainty"] == [0.1, 0.2]


@pytest.mark.parametrize("name", ["", " ", "-", None])
def test_no_name_is_no_material(name):
    with pytest.raises(SettingsError, match=rf"{name!r} is no material of the table"):
        material(name)


def test_names_and_numbers_give_the_same_contact():
    height = rough_reference_surface(64) * 1e-7
    height = height.assign_coords(y=height["y"] * 1e-6, x=height["x"] * 1e-6)
    bodies = [material("steel"), material("brass")]
    named, numbers = (
        evaluate(height, contact={"bodies": pair, "mean_pressure": 1e7}, uncertainty={"sources": []})
        for pair in (["steel", "brass"], bodies)
    )
    assert named["relative_contact_area"].item() == numbers["relative_contact_area"].item()
    assert re.search("brass", str(named.attrs))
    directly = solve_contact(height, bodies=["steel", "brass"], mean_pressure=1e7)
    assert float(directly["contact_modulus"]) == pytest.approx(materials.contact_modulus(bodies))


@pytest.mark.parametrize(
    ("name", "melting"),
    [  # K, of Incropera's tables of metallic and nonmetallic solids
        *(("gold", 1336), ("silver", 1235), ("copper", 1358), ("tin", 505), ("nickel", 1728), ("lead", 601)),
        *(("platinum", 2045), ("zinc", 693), ("titanium", 1953), ("molybdenum", 2894), ("tungsten", 3660)),
        *(("silicon", 1685), ("alumina", 2323), ("stainless-steel", 1670), ("aluminium-7075", 775)),
    ],
)
def test_solids_end_where_books_have_them_melt(name, melting):
    """An alloy begins to melt below the one number that the book has."""
    limits = named_materials.temperature_limits([material(name)])[name]
    share = 0.05 if "-" in name else 0.01
    assert limits["highest"] + 273.15 == pytest.approx(melting, rel=share)
    assert limits["lowest"] <= -273


@pytest.mark.cases
def test_temperatures_beyond_the_range_of_a_material_are_a_sentence(bodies, numbers, words):
    stated = {"relaxation": {"temperature": numbers.get("relaxation")}}
    named = [{"name": name, **stated} for name in bodies]
    statistics = xr.Dataset(
        {name: ("load", [value]) for name, value in numbers.items() if name != "relaxation"}
        | {"contact_modulus": 1e9, "mean_pressure": ("load", [1e6])},
        attrs=json_attributes({"temperatures": named_materials.temperature_limits(named)}),
    )
    check = units(statistics)
    assert check.outcome == (REVIEW if words else PASSED)
    assert words in check.sentence


def test_a_run_warns_of_a_surface_that_melts():
    friction = {"coefficient": 0.5, "speed": "0.1 m/s"}
    result = evaluate(
        rough_reference_surface(64),
        contact={"bodies": ["lead", "steel"], "mean_pressure": "5 MPa"},
        statistics={"friction": friction},
        uncertainty={"sources": []},
    )
    assert float(result["max_flash_temperature"].max()) > 307
    assert "takes lead from room temperature beyond 327 °C" in result.attrs["reasons"]
