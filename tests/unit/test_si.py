"""Maps in any unit of length, numbers as text with a unit: what the public functions make of them."""

import warnings

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact import HeightMapError, HeightMapWarning, SettingsError, self_affine_surface
from roughcontact.arguments import units
from roughcontact.arguments.settings.fields import section_model
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.settings.plausible import setting_base
from roughcontact.arguments.si import labelled_in_si
from roughcontact.arguments.units import BASES
from roughcontact.surface.roughness import heights, parameters, spectrum, summits, texture, traces

LENGTHS = units.spellings("m")
CONTACT = {"contact_modulus": 1e9, "mean_pressure": 2e7}
SOLVER_ONLY = {"sources": ["solver"]}


@pytest.fixture(scope="module")
def surface():
    surface_map = self_affine((24, 30), 1e-6, (4e-6, 24e-6), rms_height=2e-7)
    # no wave is rounding alone
    noise = 1e-9 * np.random.default_rng(0).standard_normal(surface_map.shape)
    return surface_map.copy(data=surface_map.values + noise).assign_attrs(source_file="made")


def restated(surface, lateral, of_heights, y=None):
    """Return the same surface with positions and heights in other units."""
    scaled = surface.copy(data=surface.values / LENGTHS[of_heights]).assign_attrs(units=of_heights)
    for axis, unit in (("x", lateral), ("y", y or lateral)):
        scaled = scaled.assign_coords({axis: (axis, surface[axis].values / LENGTHS[unit], {"units": unit})})
    return scaled


def numbers(statistics):
    names = ("relative_contact_area", "mean_gap", "max_pressure", "rms_gradient", "Sq", "window_length_x")
    return np.array([float(statistics[name].squeeze()) for name in names])


@pytest.mark.parametrize("unit", LENGTHS)
def test_a_file_and_its_array_are_the_same_map_in_every_spelling(surface, unit, tmp_path):
    for array in (restated(surface, unit, "nm"), restated(surface, "um", unit)):
        array.to_netcdf(tmp_path / "array.nc")
        read, converted = rc.read_height_map(tmp_path / "array.nc"), labelled_in_si(array)
        for name in ("x", "y"):
            np.testing.assert_allclose(converted[name], read[name], rtol=1e-12)
        np.testing.assert_allclose(converted, read, rtol=1e-12)
        np.testing.assert_allclose(converted, surface, rtol=1e-12)


@pytest.mark.parametrize("lateral", list({value: name for name, value in reversed(LENGTHS.items())}.values()))
def test_an_array_and_its_file_give_the_same_numbers_in_every_unit(surface, lateral, tmp_path):
    expected = numbers(rc.evaluate(surface, contact=CONTACT, uncertainty=SOLVER_ONLY))
    words = [*LENGTHS]
    of_heights = words[(words.index(lateral) + 17) % len(words)]
    array = restated(surface, lateral, of_heights)
    array.to_netcdf(tmp_path / "array.nc")
    for source in (array, tmp_path / "array.nc"):
        values = numbers(rc.evaluate(source, contact=CONTACT, uncertainty=SOLVER_ONLY))
        np.testing.assert_allclose(values, expected, rtol=1e-9)


def every_verb(height, levelled, window, contact):
    """Return what each public function makes of maps: an array of numbers by name."""
    problem = {"level": {}, "window": {}, "contact": CONTACT}
    solved = rc.solve_contact(window, **CONTACT)
    at = {"shift": (2e-6, 3e-6), "rotation": 0.0}
    results = {
        "level": rc.level(height).values,
        "periodic_window": rc.periodic_window(levelled).values,
        "solve_contact": solved["pressure"].values,
        "contact_statistics": rc.contact_statistics(contact)["mean_gap"].values,
        "composite": rc.composite(levelled, levelled, **at).values,
        "relative_positions": [position["shift"] for position in rc.relative_positions(levelled, levelled)],
        "first_yield_pressure": rc.first_yield_pressure(window, contact_modulus=1e9, hardness=3e8),
        "error_budget": rc.error_budget(levelled, window, problem, sources=["discretisation"])[
            "mean_gap_lower"
        ].values,
    }
    for module in (heights, parameters, spectrum, summits, texture, traces):
        for name, function in vars(module).items():
            if getattr(function, "__wrapped__", None) and function.__module__ == module.__name__:
                result = function(window)
                result = tuple(result.values()) if isinstance(result, dict) else result
                parts = result if isinstance(result, tuple) else (result,)
                results[name] = np.concatenate([np.ravel(part) for part in parts])
    return results


def test_every_public_function_converts_maps(surface):
    levelled = rc.level(surface)
    window = rc.periodic_window(levelled)
    contact = rc.solve_contact(window, **CONTACT)
    expected = every_verb(surface, levelled, window, contact)
    maps = [restated(height, "mm", "nm", y="um") for height in (surface, levelled, window)]
    gap = contact["gap"].copy(data=contact["gap"].values * 1e9).assign_attrs(units="nm")
    pressure = contact["pressure"].copy(data=contact["pressure"].values * 1e-6).assign_attrs(units="MPa")
    axes = {a: (a, contact[a].values * 1e6, {"units": "um"}) for a in "xy"}
    other_units = contact.assign(gap=gap, pressure=pressure).assign_coords(axes)
    results = every_verb(*maps, other_units)
    assert len(results) >= 24
    for name, values in expected.items():
        np.testing.assert_allclose(
            results[name], values, rtol=1e-6, atol=1e-9 * np.nanmax(np.abs(values)), err_msg=name
        )


@pytest.mark.parametrize("what", ["heights", "y", "x"])
def test_other_units_are_refused_with_the_known_ones(surface, what):
    if what == "heights":
        wrong = surface.assign_attrs(units="V")
    else:
        wrong = surface.assign_coords({what: (what, surface[what].values, {"units": "V"})})
    for verb in (rc.level, rc.periodic_window, lambda height: rc.solve_contact(height, **CONTACT)):
        with pytest.raises(HeightMapError, match=rf"{what}.* of made: unknown length unit 'V'.*µm, nm"):
            verb(wrong)
    with pytest.raises(HeightMapError, match="unknown length unit 'V'"):
        rc.evaluate(wrong, contact=CONTACT)


def test_without_units_numbers_are_taken_as_they_are(surface):
    bare = xr.DataArray(surface.values, {"y": surface["y"].values, "x": surface["x"].values}, ("y", "x"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_array_equal(rc.level(bare).values, rc.level(surface).values)
        rc.level(surface - surface.mean())  # arithmetic drops the units of the heights, m beside m
    with pytest.warns(HeightMapWarning, match="the heights of the map: no attribute units, taken in m"):
        levelled_map = rc.level(restated(surface, "um", "m").assign_attrs(units=""))
    np.testing.assert_allclose(levelled_map.values, rc.level(surface).values, atol=1e-18)


def test_positions_without_a_unit_are_questioned_beside_heights_in_metres(surface):
    """Heights in m over numbers of µm would be a flat face, all of it in contact."""
    micrometres = surface.assign_coords({axis: surface[axis].values * 1e6 for axis in "yx"})
    for verb in (rc.level, lambda height: rc.evaluate(height, contact=CONTACT, uncertainty=SOLVER_ONLY)):
        with pytest.warns(HeightMapWarning, match="no unit of heights or positions"):
            verb(micrometres)


def test_the_map_that_is_given_stays_as_it_is(surface):
    height = restated(surface, "um", "nm")
    original = height.copy(deep=True)
    rc.level(height)
    xr.testing.assert_identical(height, original)


@pytest.mark.cases
def test_a_map_from_an_array(options, way):
    values = np.ma.masked_equal([[1, 2, 3], [4, -1, 6]], -1)
    height = rc.height_map(values, way, **options)
    np.testing.assert_allclose(height["y"], [0.25e-6, 0.75e-6])
    np.testing.assert_allclose(height["x"], [0.125e-6, 0.375e-6, 0.625e-6])
    np.testing.assert_allclose(height, [[1e-9, 2e-9, 3e-9], [4e-9, np.nan, 6e-9]])
    assert {height[axis].attrs["units"] for axis in "xy"} | {height.attrs["units"]} == {"m"}
    assert height.attrs["missing_points"] == 1
    assert rc.height_map([1.0, 2.0], 1.0).shape == (1, 2)


@pytest.mark.parametrize(
    ("values", "way", "options", "error", "text"),
    [
        (np.zeros((2, 2, 2)), 1.0, {}, HeightMapError, r"shape \(2, 2, 2\)"),
        ([], 1.0, {}, HeightMapError, "no map"),
        ([[1j, 2]], 1.0, {}, HeightMapError, "complex128"),
        ([["a", "b"]], 1.0, {}, HeightMapError, "no map of real numbers"),
        ([[1.0, 2.0]], 0.0, {}, SettingsError, "spacing = 0"),
        ([[1.0, 2.0]], "1 xm", {}, SettingsError, "spacing = '1 xm'.*did you mean 'm'"),
        ([[1.0, 2.0]], 1.0, {"unit": "xm"}, SettingsError, "unknown length unit 'xm'"),
        ([[1.0, 2.0]], 1.0, {"height_unit": "V"}, SettingsError, "unknown length unit 'V'"),
    ],
)
def test_what_is_no_map(values, way, options, error, text):
    with pytest.raises(error, match=text):
        rc.height_map(values, way, **options)


def test_an_array_without_labels_is_named_alike_by_all():
    messages = set()
    for verb in (rc.level, rc.evaluate, rc.periodic_window):
        with pytest.raises(HeightMapError, match=r"roughcontact\.height_map\(values, spacing\)") as caught:
            verb(np.zeros((4, 4)))
        messages.add(str(caught.value))
    assert len(messages) == 1


def test_numbers_may_be_text_with_a_unit(surface):
    levelled = rc.level(surface, s_filter="2.5 um", l_filter="0.02 mm")
    xr.testing.assert_identical(levelled, rc.level(surface, s_filter=2.5e-6, l_filter=2e-5))
    window = rc.periodic_window(levelled, shortest_wavelength="4 um")
    xr.testing.assert_identical(window, rc.periodic_window(levelled, shortest_wavelength=4e-6))
    layer = {"thickness": "3 um", "youngs_modulus": "2 GPa", "poissons_ratio": 0.3}
    bodies = [{"youngs_modulus": "1 GPa", "poissons_ratio": 0.3, "layers": [layer]}]
    plain = {"youngs_modulus": 2e9, "poissons_ratio": 0.3, "thickness": 3e-6}
    in_pascal = [{"youngs_modulus": 1e9, "poissons_ratio": 0.3, "layers": [plain]}]
    contact = rc.solve_contact(window, bodies=bodies, mean_pressure=["1 MPa", 2e6], hardness="1 GPa")
    expected = rc.solve_contact(window, bodies=in_pascal, mean_pressure=[1e6, 2e6], hardness=1e9)
    np.testing.assert_array_equal(contact["pressure"], expected["pressure"])
    first_yield = rc.first_yield_pressure(window, contact_modulus="1 GPa", hardness="300 MPa")
    assert first_yield == rc.first_yield_pressure(window, contact_modulus=1e9, hardness=3e8)
    settings = {"level": {}, "window": {}, "contact": {"contact_modulus": "1 GPa", "mean_pressure": "20 MPa"}}
    budget = rc.error_budget(levelled, window, settings, sources=["solver"])
    assert budget["mean_pressure"].item() == 2e7
    with pytest.raises(SettingsError, match=r"contact_modulus = '115 Mpa'.*did you mean 'MPa'"):
        rc.solve_contact(window, contact_modulus="115 Mpa", mean_pressure=1e6)
    with pytest.raises(SettingsError, match=r"hardness = '2 um'.*pressure unit"):
        rc.solve_contact(window, contact_modulus=1e9, mean_pressure=1e6, hardness="2 um")


def test_the_names_of_quantities_are_those_of_the_settings():
    quantities = {}

    def walk(section, inside=""):
        for name, field in section.model_fields.items():
            if base := setting_base(field):
                quantities[f"{inside}{name}"] = base
            if below := section_model(field):
                walk(below, f"{name}." if name in ("seal", "joint", "requirement") else "")

    walk(Settings)
    missing = {name: base for name, base in quantities.items() if BASES.get(name) != base}
    # not arguments of a public function that takes a map; run_in has wear_coefficient, sliding_distance
    of_runs = {"target_gap", "force", "area", "unload", "radius", "coefficient", "distance", "time"}
    of_runs |= {"creep_modulus"}
    assert missing.keys() <= of_runs, missing


def test_settings_below_sections_keep_the_units_of_their_arrays():
    """An array in a list or in a mapping of a section says its unit as one that stands by itself does."""
    text = {"youngs_modulus": "210 GPa", "pressure": "300 Pa", "viscosity": "1 mPa s"}
    array = {
        key: xr.DataArray(float(number), attrs={"units": unit})
        for key, (number, unit) in ((key, quantity.split(" ", 1)) for key, quantity in text.items())
    }
    surface = self_affine_surface((48, 48), 1e-6, hurst=0.8, rms_height=1e-8, shortest=6e-6, longest=24e-6)
    by_text, by_array = (
        rc.evaluate(
            surface,
            contact={
                "bodies": [{"youngs_modulus": quantity["youngs_modulus"], "poissons_ratio": 0.3}, "steel"],
                "mean_pressure": [quantity["pressure"]],
            },
            statistics={
                "seal": {"viscosity": quantity["viscosity"], "pressure_difference": 1e5, "width": 1e-3}
            },
            uncertainty={"sources": []},
        )
        for quantity in (text, array)
    )
    np.testing.assert_allclose(numbers(by_array), numbers(by_text), rtol=1e-9)
    assert by_text["leak_rate_x"].item() > 0
    assert by_array["leak_rate_x"].item() == pytest.approx(by_text["leak_rate_x"].item(), rel=1e-9, abs=0)


def test_statistics_are_of_a_solution(surface):
    for wrong, text in ((surface, "type DataArray"), (xr.Dataset({"height": surface}), "has no pressure")):
        with pytest.raises(SettingsError, match=f"{text}.*solution of solve_contact"):
            rc.contact_statistics(wrong)


# --- a unit that nobody states -----------------------------------------------------------------------------


def bare(surface, factor):
    """Return a surface with positions and heights times a factor, without a unit."""
    positions = {axis: surface[axis].values * factor for axis in "yx"}
    return xr.DataArray(surface.values * factor, positions, ("y", "x"))


def as_array(height):
    return rc.height_map(height.values, float(height["x"][1] - height["x"][0]))


ENTRANCES = {
    "evaluate": lambda height: rc.evaluate(height, contact=CONTACT, uncertainty=SOLVER_ONLY),
    "level": rc.level,
    "periodic_window": rc.periodic_window,
    "height_map": as_array,
}


@pytest.mark.parametrize("entrance", ENTRANCES)
def test_micrometres_without_a_unit_are_warned_of(surface, entrance):
    with pytest.warns(
        HeightMapWarning, match=r"a field of 29 m with heights of 0\.2 m .*unit='um'"
    ) as caught:
        ENTRANCES[entrance](bare(surface, 1e6))
    assert [warning.filename for warning in caught] == [__file__]


@pytest.mark.parametrize("entrance", ENTRANCES)
def test_metres_and_stated_units_are_not(surface, entrance):
    large = restated(bare(surface, 1e6), "m", "m")
    with warnings.catch_warnings():
        warnings.simplefilter("error", HeightMapWarning)
        ENTRANCES[entrance](bare(surface, 1.0))
        if entrance != "height_map":
            ENTRANCES[entrance](large)
        rc.height_map(large.values, 1.0, unit="m")
        rc.solve_contact(bare(surface, 1e6), contact_modulus=1.0, mean_pressure=0.02)  # in any units


def test_a_map_of_dask_is_the_same_map(surface):
    pytest.importorskip("dask")  # no dependency: with it every import takes longer
    in_pieces = surface.chunk(y=7)
    assert rc.solve_contact(in_pieces, **CONTACT).identical(rc.solve_contact(surface, **CONTACT))
    expected = rc.evaluate(surface, contact=CONTACT, uncertainty=SOLVER_ONLY)
    assert rc.evaluate(in_pieces, contact=CONTACT, uncertainty=SOLVER_ONLY).identical(expected)


class Quantity(np.ndarray):
    """An array as those of pint are."""

    magnitude = None


def test_quantities_of_pint_are_refused_with_the_way_to_their_units(surface):
    with pytest.raises(SettingsError, match="quantities of pint would lose their unit"):
        rc.height_map(surface.values.view(Quantity), 1e-6)
    with pytest.raises(SettingsError, match="quantities of pint would lose their unit"):
        rc.height_map(surface.values, np.array(1.0).view(Quantity))


@pytest.mark.parametrize(
    ("change", "way"),
    [
        (lambda height: height.rename(y="northing", x="easting"), "rename.*'northing': 'y', 'easting': 'x'"),
        (lambda height: height.rename(x="column"), r"rename\({'column': 'x'}\)"),
        (lambda height: height.expand_dims("time"), r"select one map, height\.isel\(time=0\)"),
        (lambda height: height.T, r"transpose it to \('y', 'x'\)"),
        (lambda height: height[0], "dimensions \\('x',\\)"),
    ],
)
def test_other_dimensions_are_answered_by_what_makes_a_map_of_them(surface, change, way):
    with pytest.raises(HeightMapError, match=way):
        rc.level(change(surface))
