"""Numbers far from any surface: a clear error or a right answer, never an exception of the machinery."""

import re
import warnings

import numpy as np
import pytest
import xarray as xr

from data_samples.make_samples import turned_surface
from roughcontact import errors
from roughcontact.arguments.maps import height_map
from roughcontact.contact.loads import plan_loads
from roughcontact.contact.solve import solve_contact
from roughcontact.evaluation.evaluate import contact_table, evaluate
from roughcontact.results.storage import read_dataset, write_dataset
from roughcontact.statistics.contact_statistics import contact_statistics
from roughcontact.surface import synthetic
from roughcontact.surface.levelling.level import level
from roughcontact.surface.window.periodic_window import periodic_window
from validation.surfaces import ground_surface, product_wave_surface

BAND = {"hurst": 0.8, "shortest": 4e-6, "longest": 16e-6, "rms_gradient": 0.1}
SURFACE = synthetic.self_affine_surface((32, 32), 1e-6, **BAND, seed=1)
PROFILE = synthetic.self_affine_surface((1, 256), 1e-6, **BAND | {"longest": 64e-6}, seed=2)
MODULUS, PRESSURE = 1e9, 1e6


def solved(window=SURFACE, **options):
    return solve_contact(window, **{"contact_modulus": MODULUS, "mean_pressure": PRESSURE} | options)


def on_pixels(values, pixel):
    return height_map(values, pixel)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"hardness": PRESSURE * (1 + 1e-9)}, "1000000 Pa is less than one part in a million below"),
        ({"hardness": PRESSURE * (1 + 1e-12)}, "below the hardness 1000000 Pa: all of the surface"),
        ({"hardness": PRESSURE}, "is not below the hardness"),
        ({"mean_pressure": 1e-300}, "mean_pressure = 1e-300 is beyond the computable range"),
        ({"mean_pressure": 5e-324}, "is beyond the computable range"),
        ({"mean_pressure": 1e-30}, "rounding allows 1e-10 to 1e"),
        ({"mean_pressure": 1e30}, "check the units of load, modulus and heights"),
        ({"contact_modulus": 1e300}, "contact_modulus = 1e.300 is beyond the computable range"),
        ({"contact_modulus": 1e-300}, "contact_modulus = 1e-300 is beyond the computable range"),
        ({"contact_modulus": 1e60}, "rounding allows"),
        ({"tolerance": None}, "tolerance = None: give a number"),
        ({"tolerance": "x"}, "tolerance = 'x'"),
        ({"mean_pressure": True}, "mean_pressure = True"),
        ({"mean_pressure": [1e6, True]}, "mean_pressure = True"),
        ({"contact_modulus": True}, "contact_modulus = True"),
        ({"hardness": True}, "hardness = True"),
        ({"mean_pressure": 1e6 + 1j}, "is not a number"),
    ],
)
def test_a_setting_that_nothing_can_be_made_of(options, message):
    with pytest.raises(errors.SettingsError, match=message):
        solved(**options)


@pytest.mark.parametrize(
    ("window", "message"),
    [
        (on_pixels(SURFACE.values, 1e-300), "on pixels of 1e-300 m x 1e-300 m are beyond"),
        (on_pixels(SURFACE.values, 1e300), "are beyond the computable range; check the units"),
        (SURFACE * 1e207, "heights of up to 5.30119e.200 m"),
        (SURFACE * 1e307, "check the units"),
        (on_pixels(np.where(SURFACE.values > 0, 5e-324, 0), 1e-6), "rms gradient of 0"),
        (SURFACE * 1e-293, "rms gradient of 0"),
    ],
)
def test_a_map_that_nothing_can_be_made_of(window, message):
    with pytest.raises(errors.HeightMapError, match=message):
        solved(window)


NO_MAPS = {
    "array": (SURFACE.values, "type ndarray, its pixel size is unknown"),
    "list": ([[1.0, 2.0], [3.0, 4.0]], "type list"),
    "without coordinates": (xr.DataArray(SURFACE.values, dims=("y", "x")), "no coordinate 'y'"),
    "complex": (SURFACE.copy(data=SURFACE.values + 1j), "type complex128: heights are real numbers"),
    "text": (SURFACE.copy(data=SURFACE.values.astype(str)), "type <U32: heights are real numbers"),
    "true and false": (SURFACE.copy(data=SURFACE.values > 0), "type bool: heights are real numbers"),
    "objects": (SURFACE.copy(data=SURFACE.values.astype(object)), "type object: heights"),
}


@pytest.mark.parametrize("verb", [solved, level, periodic_window], ids=["solve", "level", "window"])
@pytest.mark.parametrize("what", NO_MAPS)
def test_what_is_no_height_map(verb, what):
    value, message = NO_MAPS[what]
    with pytest.raises(errors.HeightMapError, match=message):
        verb(value)


@pytest.mark.parametrize("verb", [solved, level, periodic_window])
def test_positions_in_words_are_refused(verb):
    words = SURFACE.assign_coords(x=SURFACE.x.astype(str))
    with pytest.raises(errors.HeightMapError, match="coordinate 'x' of the map holds values of type <U"):
        verb(words)


def test_relative_loads_are_numbers_too():
    with pytest.raises(errors.SettingsError, match="relative_pressure = True"):
        plan_loads(SURFACE, contact_modulus=MODULUS, relative_pressure=True)


@pytest.mark.parametrize("scale", [1e-90, 1e-60, 1e60, 1e90])
def test_the_unit_of_length_and_pressure_is_free_within_a_wide_range(scale):
    expected = solved()
    for scaled in (
        solved(SURFACE * scale, mean_pressure=PRESSURE * scale),
        solved(contact_modulus=MODULUS * scale, mean_pressure=PRESSURE * scale),
        solved(on_pixels(SURFACE.values, 1e-6 * scale), mean_pressure=PRESSURE / scale),
    ):
        np.testing.assert_array_equal(scaled["contact"], expected["contact"])
        share = scaled["pressure"] / scaled["mean_pressure"]
        np.testing.assert_allclose(share, expected["pressure"] / PRESSURE, rtol=1e-9)


@pytest.mark.parametrize("window", [SURFACE, PROFILE], ids=["surface", "profile"])
def test_the_lightest_load_rests_on_the_highest_point_alone(window):
    contact = solved(window, mean_pressure=1e-8 * MODULUS * 0.1)
    (y, x) = np.unravel_index(window.values.argmax(), window.shape)
    assert contact["contact"].values[0].sum() == 1
    assert contact["contact"].values[0, y, x]
    assert contact["pressure"].values[0, y, x] == pytest.approx(1e-8 * MODULUS * 0.1 * window.size)


def test_the_heaviest_load_closes_every_gap():
    """In full contact the waves of the pressure are E* |q|/2 times those of the heights (Johnson, 13.2)."""
    contact = solved(mean_pressure=1e9 * MODULUS * 0.1)
    assert contact["contact"].values.all()
    frequencies = np.fft.fftfreq(32, 1e-6) * 2 * np.pi
    stiffness = MODULUS * np.hypot(frequencies[:, None], frequencies) / 2
    waves = np.fft.ifft2(stiffness * np.fft.fft2(SURFACE.values)).real
    np.testing.assert_allclose(
        contact["pressure"].values[0] - 1e9 * MODULUS * 0.1, waves, atol=1e-6 * waves.std() * 10
    )


def test_just_below_the_hardness_nearly_all_of_it_yields():
    contact = solved(hardness=PRESSURE * (1 + 1e-5))
    assert contact["pressure"].values.mean() == pytest.approx(PRESSURE, rel=1e-12)
    assert contact["pressure"].values.max() <= PRESSURE * (1 + 1e-5) * (1 + 1e-12)
    assert contact["error_bound"] <= 1e-4


def test_single_precision_that_cannot_reach_the_tolerance_says_so_before_the_first_step():
    with pytest.raises(
        errors.ConvergenceError, match=r"single precision allows no error bound below .* double"
    ):
        solved(precision="single", tolerance=1e-7)
    flagged = solved(precision="single", tolerance=1e-7, on_failure="flag")
    assert not flagged["converged"]
    assert flagged["error_bound"] < 2 * flagged["rounding_floor"]  # as good as single precision can be
    assert flagged["operator_applications"] < 20


def test_a_tolerance_just_above_the_floor_of_single_precision_is_reached():
    floor = float(solved(precision="single", tolerance=1e-4)["rounding_floor"][0])
    assert solved(precision="single", tolerance=1.02 * floor)["error_bound"] <= 1.02 * floor


def test_reducing_to_an_unknown_variable_is_refused_after_the_first_load():
    calls = []
    with pytest.raises(
        errors.RoughContactError, match=r"no description for the output variables \['mean_depth'\]"
    ):
        solve_contact(
            SURFACE,
            contact_modulus=MODULUS,
            mean_pressure=[1e6, 2e6],
            reduce=lambda contact: contact[["gap"]].mean(("y", "x")).rename(gap="mean_depth"),
            progress=lambda *progress_values: calls.append(progress_values),
        )
    assert not calls


def test_a_quantity_of_the_users_own_keeps_its_description(tmp_path):
    def deepest(contact):
        depth = contact["gap"].max(("y", "x")).assign_attrs(units="m", long_name="deepest gap")
        return contact[[]].assign(deepest_gap=depth)

    solution = solve_contact(SURFACE, contact_modulus=MODULUS, mean_pressure=[1e6, 2e6], reduce=deepest)
    write_dataset(solution, tmp_path / "own.nc")
    stored = read_dataset(tmp_path / "own.nc")["deepest_gap"]
    assert stored.attrs["long_name"] == "deepest gap"
    fields = solve_contact(SURFACE, contact_modulus=MODULUS, mean_pressure=[1e6, 2e6])
    np.testing.assert_array_equal(stored, fields["gap"].max(("y", "x")))


@pytest.mark.cases
def test_a_filter_that_no_map_has(settings, message):
    with pytest.raises(errors.SettingsError, match=message):
        level(SURFACE, **settings)


@pytest.mark.parametrize("verb", [level, periodic_window])
def test_heights_that_no_surface_has(verb):
    for factor, message in ((1e207, r"5.30119e\+200"), (1e-313, "5.3.*e-320")):
        with pytest.raises(
            errors.HeightMapError, match=rf"the map has heights of {message} m: check the unit"
        ):
            verb(SURFACE * factor)


@pytest.mark.parametrize("form", ["sphere", "cylinder"])
def test_a_needle_is_no_ball(form):
    with pytest.raises(
        errors.HeightMapError, match=f"a {form} cannot have a range of heights of .*: check the unit"
    ):
        level(SURFACE * 1e20, form=form)


@pytest.mark.parametrize("shape", [(1, 2), (2, 1), (2, 2), (3, 3), (3, 5)])
def test_a_map_of_few_points_is_solved_with_a_warning(shape):
    small_map = on_pixels(1e-7 * np.random.default_rng(3).standard_normal(shape), 1e-6)
    message = rf"^the map has {shape[0]} x {shape[1]} points: .* check how it was cut or read$"
    with pytest.warns(errors.HeightMapWarning, match=message):
        contact = solved(small_map)
    with pytest.warns(errors.HeightMapWarning, match=message):
        contact_statistics(contact)


@pytest.mark.parametrize("factor", [31.0, 1e30])
def test_slopes_beyond_any_surface_are_solved_with_a_warning(factor):
    steep = SURFACE * factor
    with pytest.warns(errors.HeightMapWarning, match="the units of heights and positions differ") as caught:
        contact = solved(steep, mean_pressure=0.1 * factor * PRESSURE)
    assert [warning.filename for warning in caught] == [__file__]
    with pytest.warns(errors.HeightMapWarning, match=re.escape(f"is {0.1 * factor:.3g}, steeper")):
        contact_statistics(contact)


def test_usual_maps_are_solved_without_a_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error", errors.HeightMapWarning)
        for window in (SURFACE, PROFILE, SURFACE * 29, SURFACE[:4, :4]):
            contact_statistics(solved(window))


def test_evaluate_says_each_of_it_once():
    small_map = on_pixels(1e-7 * np.random.default_rng(3).standard_normal((3, 3)), 1e-6)
    with pytest.warns(errors.HeightMapWarning, match="3 x 3 points") as caught:
        evaluate(small_map, contact={"contact_modulus": MODULUS, "mean_pressure": [PRESSURE]})
    assert sum("3 x 3" in str(warning.message) for warning in caught) == 1


def wave(points):
    """Return one wave over so many points, its crest on the first."""
    return on_pixels(1e-7 * np.cos(2 * np.pi * np.arange(points) / points)[None, :], 1e-6)


PERIODIC = {
    "rough": SURFACE,
    "profile": PROFILE,
    "reference": synthetic.rough_reference_surface(64),
    "lay": ground_surface((48, 64), 1e-6, hurst=0.8, shortest=4e-6, longest=6e-5, rms_height=1e-7),
    "grooves": turned_surface((4, 160), 1e-6, feed=4e-5, nose_radius=4e-4, groove_scatter=1e-7),
    "one groove": turned_surface((1, 64), 1e-6, feed=64e-6, nose_radius=4e-4),
    "product": product_wave_surface((32, 48), 1e-6, amplitude=1e-7, wavelength=16e-6),
    "coarse": product_wave_surface((4, 4), 1e-6, amplitude=1e-7, wavelength=4e-6),
    "three points": wave(3),
    "noise": on_pixels(1e-8 * np.random.default_rng(0).standard_normal((40, 60)), 1e-6),
    "noise of a line": on_pixels(1e-8 * np.random.default_rng(0).standard_normal((1, 60)), 1e-6),
    "steps": on_pixels(1e-7 * (np.arange(64) // 16 % 2)[None, :], 1e-6),
    "cut off": wave(64).clip(max=5e-8),
    "on a plateau": wave(64) + 1.0,
    "flat": on_pixels(np.zeros((8, 8)), 1e-6),
    "in single precision": SURFACE.astype(np.float32),
}


@pytest.mark.parametrize("name", PERIODIC)
@pytest.mark.parametrize("turned", [False, True])
def test_periodic_maps_are_solved_without_a_warning(name, turned):
    height = PERIODIC[name]
    height = height.rename(y="x", x="y").T if turned else height
    for shift in (0, 5):
        rolled = height.roll(x=shift, y=shift)
        with warnings.catch_warnings():
            warnings.filterwarnings("error", "the map is not periodic", errors.HeightMapWarning)
            solved(rolled)


def tilted(height, slope):
    return height + slope * (height["x"] - height["x"][0])


@pytest.mark.parametrize(
    "height",
    [
        tilted(SURFACE, 0.05),
        tilted(SURFACE, -0.02),
        SURFACE[:, :20],
        tilted(PROFILE, 0.05),
        tilted(wave(64), 1e-3),
        on_pixels(1e-9 * np.arange(64.0)[None, :] ** 2, 1e-6),
    ],
)
@pytest.mark.parametrize("turned", [False, True])
def test_a_map_that_jumps_at_its_border_is_solved_with_a_warning(height, turned):
    turned_height = height.rename(y="x", x="y").T if turned else height
    along = "y" if turned else "x"
    with pytest.warns(
        errors.HeightMapWarning, match=f"not periodic along {along}: .* periodic_window"
    ) as caught:
        solved(turned_height)
    assert [warning.filename for warning in caught] == [__file__] * len(caught)
    with warnings.catch_warnings():
        warnings.simplefilter("error", errors.HeightMapWarning)
        solved(periodic_window(turned_height, method="raw"))  # on purpose
    with pytest.warns(errors.HeightMapWarning, match=f"not periodic along {along}"):
        contact_table(turned_height, contact_modulus=MODULUS, loads=1)
