"""Relaxation of a rubber: tables of a DMA, Prony series, the shift to another temperature."""

import numpy as np
import pandas as pd
import pytest

from roughcontact.arguments.bodies import relaxation_table
from roughcontact.arguments.named_materials import compound, compound_names, modulus_of_hardness
from roughcontact.arguments.relaxation import MAX_MISFIT, read_relaxation, relaxation_of
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.errors import SettingsError
from roughcontact.report.asked import bodies_in_words

SERIES = {"long_time_modulus": 3e6, "moduli": [1e7, 5e7, 2e8], "times": [1e-2, 1e-4, 1e-6]}


def table(frequency=None):
    frequency = np.geomspace(1e-1, 1e7, 49) if frequency is None else frequency
    young = relaxation_of(SERIES).contact_modulus(2 * np.pi * frequency) * 0.75
    return pd.DataFrame({"frequency": frequency, "storage_modulus": young.real, "loss_modulus": young.imag})


def test_a_series_is_that_of_maxwell():
    """A single term has E' = E1 (ωτ)²/(1 + (ωτ)²), E'' = E1 ωτ/(1 + (ωτ)²) above the plateau."""
    rubber = relaxation_of({"long_time_modulus": 1e6, "moduli": [4e6], "times": [0.5]}, poissons_ratio=0.0)
    omega = np.array([0.0, 2.0, -2.0])
    np.testing.assert_allclose(rubber.contact_modulus(omega), [1e6, 3e6 + 2e6j, 3e6 - 2e6j])


def test_times_and_moduli_may_have_units():
    stated = {
        "long_time_modulus": "3 MPa",
        "moduli": ["10 MPa", "0.05 GPa", 2e8],
        "times": ["10 ms", "100 µs", 1e-6],
    }
    omega = np.geomspace(1, 1e7, 9)
    expected = relaxation_of(SERIES).contact_modulus(omega)
    np.testing.assert_allclose(relaxation_of(stated).contact_modulus(omega), expected)


def test_a_table_gives_back_its_material():
    rubber = relaxation_of(table())
    assert rubber.misfit < 0.01
    omega = 2 * np.pi * np.geomspace(1, 1e6, 31)
    np.testing.assert_allclose(
        rubber.contact_modulus(omega), relaxation_of(SERIES).contact_modulus(omega), rtol=0.03
    )
    assert rubber.frequencies == pytest.approx((2 * np.pi * 0.1, 2 * np.pi * 1e7))


def test_moduli_that_no_causal_material_has_are_told():
    """A loss of ten times what the slope of the storage modulus allows."""
    broken = table().assign(loss_modulus=lambda rows: 10 * rows["loss_modulus"])
    assert relaxation_of(broken).misfit > MAX_MISFIT > relaxation_of(table()).misfit


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_headings_state_units(tmp_path, separator):
    path = tmp_path / "dma.csv"
    rows = table(np.array([1.0, 10.0, 100.0]))
    moduli = rows[["storage_modulus", "loss_modulus"]] / 1e6
    moduli.insert(0, "ω (rad/s)", 2 * np.pi * rows["frequency"])
    moduli.columns = ["ω (rad/s)", "E' [MPa]", "E'' [MPa]"]
    moduli.insert(0, "temperature", 20.0)
    moduli.to_csv(path, index=False, sep=separator)
    read = read_relaxation(path)
    expected = rows.assign(frequency=2 * np.pi * rows["frequency"])
    np.testing.assert_allclose(read, expected)


@pytest.mark.cases
def test_tables_as_instruments_write_them(tmp_path, headings, form):
    """Each has the same three rows: decimals with commas, wide gaps, units in a row of their own, Latin-1."""
    expected = table(np.array([1.5, 10.0, 100.0]))
    rows = expected / [1e3, 1e6, 1e6]
    if first := form.pop("first", None):
        rows.insert(0, "T", first)
    if omega := form.pop("omega", None):
        rows.insert(1, "omega", omega * rows["frequency"])
    gap = form.pop("gap", None)
    text = rows.to_csv(index=False, header=False, float_format="%.9f", **form)
    path = tmp_path / "dma.csv"
    path.write_text(f"{headings}\n{text.replace(',', gap) if gap else text}", "latin-1")
    read = read_relaxation(path)
    np.testing.assert_allclose(read, expected.assign(frequency=2 * np.pi * expected["frequency"]), rtol=1e-6)


def test_a_comma_is_a_decimal_one_where_no_number_has_a_point(tmp_path):
    """Beside points, or within quotes, it could also separate thousands."""
    path = tmp_path / "dma.csv"
    path.write_text("freq. (kHz);E' (MPa);E'' (MPa)\n0,001;0,0015;0,1\n0,01;2;0,2\n0,1;3;0,3")
    rows = [[1, 1500, 1e5], [10, 2e6, 2e5], [100, 3e6, 3e5]]
    np.testing.assert_allclose(read_relaxation(path), rows * np.array([2 * np.pi, 1, 1]))
    for text in ("f;E';E''\n1,000;2e6;2.5e5", "f,E',E''\n\"1,000\",3e6,3e5"):
        path.write_text(text)
        with pytest.raises(SettingsError, match="column 'f': '1,000' is not a number"):
            read_relaxation(path)


def test_separators_at_the_ends_of_lines_are_no_column(tmp_path):
    """As spreadsheets write them; a further number, as decimals with commas between commas make, is none."""
    path = tmp_path / "dma.csv"
    path.write_text("f,E',E'',\n1,2e6,3e5,\n2,3e6,3e5,\n3,3e6,4e5,\n,,,\n")
    assert read_relaxation(path)["loss_modulus"].tolist() == [3e5, 3e5, 4e5]
    path.write_text("f;E';E'';\nHz;MPa;MPa;\n0,1;2;0,3;\n2;3;0,3;\n3;3;0,4;")
    assert read_relaxation(path)["loss_modulus"].tolist() == [3e5, 3e5, 4e5]
    path.write_text("f,E',E''\n1,5,2,6,0,3\n2,5,3,6,0,3")
    with pytest.raises(SettingsError, match="3 columns passed, passed data had 6"):
        read_relaxation(path)


@pytest.mark.parametrize("text", ["", "\n# nothing\n", "f,E',E''"])
def test_a_table_without_rows_is_told(tmp_path, text):
    (tmp_path / "dma.csv").write_text(text)
    with pytest.raises(SettingsError, match="not read as a table: no rows of numbers below a heading; give"):
        read_relaxation(tmp_path / "dma.csv")


def test_the_softest_rubber_has_a_kilopascal():
    sweep = pd.DataFrame({"f": [1, 10, 100], "E' (Pa)": [1e3, 2e3, 3e3], "E''": [1e3, 1e3, 1e3]})
    assert read_relaxation(sweep)["storage_modulus"].min() == 1e3
    for column in ("E' (Pa)", "E''"):
        with pytest.raises(SettingsError, match=r"999\.5 Pa is softer than any rubber"):
            read_relaxation(sweep.replace({column: {1e3: 999.5}}))


def test_a_frequency_in_inverse_seconds_is_of_its_heading():
    """1/s of f is Hz, of ω rad/s."""
    moduli = {"E' (MPa)": [1, 2, 3], "E'' (MPa)": [0.1, 0.2, 0.3]}
    for heading, factor in (("f (1/s)", 2 * np.pi), ("ω (1/s)", 1.0)):
        read = read_relaxation(pd.DataFrame({heading: [1, 10, 100]} | moduli))
        np.testing.assert_allclose(read["frequency"], factor * np.array([1, 10, 100]))


def test_the_shift_is_that_of_williams_landel_and_ferry():
    shift = {"wlf": [8.86, 101.6], "reference_temperature": 20.0, "temperature": 40.0}
    warm, cold = relaxation_of(SERIES | shift), relaxation_of(SERIES)
    factor = 10 ** (-8.86 * 20 / 121.6)
    omega = np.geomspace(1, 1e6, 7)
    np.testing.assert_allclose(warm.contact_modulus(omega), cold.contact_modulus(omega * factor))


def test_temperatures_may_have_their_scale():
    kelvin = {"table": "PIB", "temperature": "273.15 K"}
    np.testing.assert_allclose(
        relaxation_of(kelvin).times, relaxation_of({"table": "PIB", "temperature": "0"}).times
    )
    both = {"wlf": [8.86, "101.6 K"], "reference_temperature": "20 °C", "temperature": "313.15 K"}
    plain = {"wlf": [8.86, 101.6], "reference_temperature": 293.15, "temperature": 313.15}
    np.testing.assert_allclose(relaxation_of(SERIES | both).times, relaxation_of(SERIES | plain).times)


@pytest.mark.parametrize("name", compound_names())
def test_a_named_rubber_is_a_causal_material_within_the_range_of_its_data(name):
    rubber = relaxation_of(name)
    assert min(rubber.long_time_modulus, *rubber.moduli) > 0
    np.testing.assert_allclose(np.diff(np.log10(rubber.times)), 1, atol=1e-12)
    low, high = rubber.frequencies
    assert 0.05 / high < rubber.times[0] < rubber.times[-1] < 10 / low
    assert 0 < rubber.misfit < MAX_MISFIT
    loss = rubber.contact_modulus(np.geomspace(low, high, 50))
    assert (loss.imag > 0.05 * loss.real).all()
    assert (
        relaxation_table([{"relaxation": name}]) == relaxation_table([{"relaxation": {"table": name}}]) == ""
    )


def test_a_named_rubber_has_the_moduli_of_its_source():
    """Rows of the files at 25 °C (E = 3 G), and of -20.2 and -62 °C by the shifts of Catsiff and Tobolsky.

    Their tension of 0.1 Pa and hours is that at 25 °C by the ratio of the absolute temperatures.
    """
    frequency, storage, loss = np.transpose(
        [(0.0139, 3.065e6, 3.789e5), (1, 4.262e6, 5.015e5), (10, 5.152e6, 5.762e5), (100, 5.739e6, 7.501e5)]
    )
    rubber = relaxation_of("EPDM-70")
    young = rubber.contact_modulus(2 * np.pi * frequency) * 0.75
    np.testing.assert_allclose(young.real, 3 * storage, rtol=rubber.misfit)
    np.testing.assert_allclose(young.imag, 3 * loss, rtol=2 * rubber.misfit)
    # its hardness is measured within seconds, and has an error of five degrees
    soft, hard = (modulus_of_hardness(degrees) for degrees in (65, 75))
    assert soft < rubber.at_rest() < 1.1 * hard
    polymer = relaxation_of("PIB")
    for kelvin, hours, shift, stress in [(252.8, 0.00627, 2.34, 7.269e6), (211.0, 0.00906, 7.06, 2.077e8)]:
        time = 3600 * hours / 10**shift
        relaxed = polymer.long_time_modulus + polymer.moduli @ np.exp(-time / polymer.times)
        assert relaxed == pytest.approx(0.1 * stress * 298 / kelvin, rel=0.12)
    glass = polymer.contact_modulus(np.array(polymer.frequencies[1])).real * 0.75
    assert glass == pytest.approx(0.1 * 10**10.48, rel=0.15)


@pytest.mark.parametrize("modulus", [{}, {"youngs_modulus": 1e7, "poissons_ratio": 0.5}])
def test_a_mistake_is_named_by_the_bodies_and_beside_a_modulus_hides_no_other(modulus):
    bodies = [{"relaxation": "nowhere.csv"} | modulus, "granite"]
    words = r"contact\.bodies: relaxation = nowhere\.csv: not read as a table"
    with pytest.raises(SettingsError, match=words) as raised:
        resolve({"contact": {"bodies": bodies, "mean_pressure": [1e5, 1e5]}})
    # without its modulus no body is complete, and nothing of the loads is checked
    assert ("occurs twice" in str(raised.value)) == bool(modulus)


def test_a_named_rubber_at_another_temperature():
    cool, warm = relaxation_of({"table": "PIB", "temperature": 0.0}), relaxation_of("polyisobutylene")
    factor = 10 ** (5.96 * 25 / (159.7 - 25))
    np.testing.assert_allclose(cool.times, factor * warm.times)
    np.testing.assert_allclose(cool.frequencies, np.array(warm.frequencies) / factor)
    with pytest.raises(SettingsError, match="another temperature needs wlf"):
        relaxation_of({"table": "EPDM-70", "temperature": 0.0})
    bodies = resolve({"contact": {"bodies": [{"relaxation": {"table": "pib", "temperature": 0}}, "granite"]}})
    assert bodies_in_words(bodies[""]["contact"]).startswith("polyisobutylene (")
    assert compound("EPDM 70 Shore A") == compound("epdm-70") != compound("dma.csv") == {}


@pytest.mark.parametrize(
    ("relaxation", "text"),
    [
        ({"moduli": [1e6], "times": [1.0]}, "relaxation.long_time_modulus: missing"),
        (SERIES | {"times": [1.0]}, "3 moduli and 1 times"),
        (SERIES | {"wlf": [8.86, 101.6]}, "needs wlf = .C1, C2"),
        (
            SERIES | {"wlf": [8.86, 101.6], "reference_temperature": 20, "temperature": -90},
            "110 K below its reference",
        ),
        (
            SERIES | {"wlf": [8.86, 101.6], "reference_temperature": 20, "temperature": 293},
            "273 K above its reference, .* both in °C or both in K",
        ),
        ({"table": "PIB", "temperature": 293}, "268 K above its reference"),
        ({"table": "PIB", "temperature": "60 F"}, "'60 F': unknown temperature scale 'F'"),
        (SERIES | {"tau": [1.0]}, "relaxation.tau: unknown"),
        (SERIES | {"table": "PIB"}, "a table and long_time_modulus of a Prony series given"),
        ("nowhere.csv", "relaxation = nowhere.csv: not read as a table: .*, or a name: EPDM-70, poly"),
        (pd.DataFrame({"f": [1.0], "E'": [1e6]}), "no column 'loss_modulus'"),
        (pd.DataFrame({"f": [1.0], "E' (MPA)": [1.0], "E''": [1.0]}), "unit 'MPA'"),
        (table().head(2), "2 frequencies; give a sweep over three or more"),
        (table().assign(frequency=10.0), "1 frequencies; give a sweep"),  # over strains
        (
            table().assign(f=10.0),
            "columns 'frequency' and 'f' are unlike, and both are the frequency; leave one out",
        ),
        (
            pd.DataFrame({"f (Hz)": [1, 10, 100], "E' (Pa)": [6.5, 6.6, 6.7], "E'' (Pa)": [5.4, 5.5, 5.6]}),
            r"column \"E' \(Pa\)\": 6.5 Pa is softer than any rubber: give moduli, no logarithms",
        ),
        (
            table().replace({"storage_modulus": {table()["storage_modulus"][3]: np.inf}}),
            "storage_modulus inf",
        ),
        (
            table().replace({"loss_modulus": {table()["loss_modulus"][3]: np.nan}}),
            "loss_modulus nan; complete",
        ),
        (None, "relaxation = None: .*; give a table .path or DataFrame., a mapping, or a name"),
        (
            SERIES | {"times": ["1 min", "1 fortnight", 1.0]},
            "relaxation.times = '1 fortnight': unknown time unit",
        ),
        (
            table() / [1, 1e6, 1e6],
            "'storage_modulus': 3.* Pa is softer than any rubber: .* with their unit, storage modulus .MPa.",
        ),
        (table().astype(str).replace("0.1", "1,000"), "'frequency': '1,000' is not a number"),
        (table().assign(T=np.arange(49)), "temperatures are 0 to 48; give the rows of one, or of a master"),
    ],
)
def test_mistakes_are_named(relaxation, text):
    with pytest.raises(SettingsError, match=text):
        relaxation_of(relaxation)
