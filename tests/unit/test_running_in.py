"""Running-in: closed forms of wear, laws of scaling, and a bound in time that is never below the error."""

import numpy as np
import pytest
from running_in import MODULUS, PITCH, WEAR, even, random_ratio, rough, run_to_the_end

import roughcontact as rc
from roughcontact.statistics.running_in import running_in_distance


def run(face, distances, *, tolerance=np.inf, wear=WEAR, modulus=MODULUS, load=5e6, **options):
    """Return a run in single steps to each of the distances, unless a tolerance is stated."""
    statistics = {"flow": "never"}
    return rc.run_in(
        face,
        contact_modulus=modulus,
        mean_pressure=load,
        wear_coefficient=wear,
        sliding_distance=np.asarray(distances).tolist(),
        tolerance=tolerance,
        statistics=statistics,
        **options,
    )


def error(worn, reference):
    """Return the rms difference (m) of the last face from another one, whose means are equal."""
    return float(np.std(worn["height"].values[-1] - reference))


@pytest.fixture(scope="module")
def face():
    return rough()


@pytest.fixture(scope="module")
def far(face):
    """Return the distance that wears off 0.3 times the rms height."""
    return 0.3 * float(face.std()) / (WEAR * 5e6)


@pytest.mark.parametrize("steps", [1, 4, 16])
def test_a_wave_in_full_contact_decays_exponentially(steps):
    """A wave pressed flat loses k E* q/2 of its amplitude by distance; a step divides by 1 + that."""
    points, length, amplitude = 32, 1e-3, 1e-6
    wave = amplitude * np.cos(2 * np.pi * np.arange(points) / points) + np.zeros((points, 1))
    rate = WEAR * MODULUS * np.pi / length
    worn = run(rc.height_map(wave, length / points), even(1 / rate, steps), load=1e8)
    left = np.ptp(worn["height"].values[-1]) / 2
    assert left == pytest.approx(amplitude * (1 + 1 / steps) ** -steps, rel=1e-12)
    np.testing.assert_allclose(worn["worn_volume"], WEAR * 1e8 * worn["sliding_distance"].values, rtol=1e-12)
    of_steps = abs(left - amplitude / np.e) / np.sqrt(2)  # rms
    assert of_steps <= float(worn["time_error_bound"][-1]) <= 3 * of_steps


def test_worn_volume_is_that_of_archard(face, far):
    worn = run(face, [0, 0.1 * far, far], tolerance=0.1, hardness=3e7)
    np.testing.assert_allclose(worn["worn_volume"], WEAR * 5e6 * worn["sliding_distance"].values, rtol=1e-12)
    np.testing.assert_allclose(worn["worn_volume"], face.mean() - worn["height"].mean(("y", "x")), atol=1e-20)
    assert float(worn["max_pressure"].max()) <= 3e7
    assert (np.diff(worn["max_worn_depth"]) > 0).all()


def test_stiff_bodies_wear_as_the_truncated_abbott_curve(face):
    """Without elasticity all above a height is worn off, which the volume alone determines."""
    removed = 0.02 * float(face.std())
    heights = np.sort(face.values, axis=None)[::-1]
    volumes = np.cumsum(heights) - heights * np.arange(1, heights.size + 1)  # above each height
    level = np.interp(removed * heights.size, volumes, heights)  # linear between: within a pixel's height
    worn = run(face, [removed / (WEAR * 5e6)], modulus=1e16, solver_tolerance=1e-8)
    height = worn["height"].values[0]
    np.testing.assert_array_equal(height < face.values, face.values > level)
    np.testing.assert_allclose(height, np.minimum(face.values, level), atol=1e-5 * removed)


@pytest.fixture(scope="module")
def fine(face, far):
    """Return the heights after 160 steps."""
    return run_to_the_end(face, even(far, 160), load=5e6)[0]


def test_steps_converge_in_first_order_and_keep_the_bound(face, far, fine):
    runs = [run(face, even(far, steps)) for steps in (4, 8, 16)]
    errors = [error(worn, fine) for worn in runs]
    assert 1.7 < errors[0] / errors[1] < 2.5
    assert 1.7 < errors[1] / errors[2] < 2.5
    for worn, missed in zip(runs, errors, strict=True):
        assert missed < float(worn["time_error_bound"][-1])


@pytest.mark.parametrize(("tolerance", "most_steps"), [(0.1, 12), (0.02, 25), (0.002, 250)])
def test_steps_are_chosen_by_the_bound(face, far, fine, tolerance, most_steps):
    worn = run(face, [0.01 * far, far], tolerance=tolerance)
    assert error(worn, fine) < float(worn["time_error_bound"][-1]) <= tolerance * float(face.std())
    assert int(worn["wear_steps"][-1]) <= most_steps


def test_the_bound_keeps_to_the_tolerance_however_far_it_slides(face, far):
    worn = run(face, [1e8 * far], tolerance=0.02, load=1e6)
    assert float(worn["time_error_bound"][-1]) <= 0.02 * float(face.std())
    assert worn["relative_contact_area"][-1] == 1


def test_a_solver_that_leaves_more_open_than_the_tolerance_is_refused(face, far):
    with pytest.raises(rc.ConvergenceError, match="give a smaller solver_tolerance"):
        run(face, [far], tolerance=1e-9, solver_tolerance=0.5)


def test_the_running_in_distance_of_an_area_that_grows_as_the_logarithm():
    """A = a (1 + ln s): A(2 s)/A(s) = 1.1 at ln s = 10 ln 2 - 1."""
    distances = np.geomspace(1, 4000, 7)
    found = running_in_distance(distances, 0.1 * (1 + np.log(distances)))
    assert found == pytest.approx(1024 / np.e, rel=1e-12)


def test_the_bound_of_random_runs_is_never_below_the_error():
    ratios = [random_ratio(seed, steps=50) for seed in range(12)]
    assert min(ratios) >= 1
    assert np.median(ratios) <= 4


def test_an_error_of_the_measured_map_never_grows(face, far):
    noise = 0.05 * float(face.std()) * np.random.default_rng(0).standard_normal(face.shape)
    runs = [run(each, even(far, 4), solver_tolerance=1e-7)["height"] for each in (face, face + noise)]
    unlike = np.append(noise.std(), (runs[1] - runs[0]).std(("y", "x")))
    assert (np.diff(unlike) < 0).all()


@pytest.mark.parametrize(
    ("scaled", "factor"),
    [
        ({"wear": 3 * WEAR, "distance": 1 / 3}, 1.0),  # k s alone counts
        ({"modulus": 3 * MODULUS, "load": 1.5e7, "distance": 1 / 3}, 1.0),  # k p s
        ({"lengths": 3.0, "distance": 3.0}, 3.0),
    ],
)
def test_laws_of_scaling(face, far, scaled, factor):
    distances, lengths = np.array([0.1, 1.0]) * far, scaled.pop("lengths", 1.0)
    stretched = rc.height_map(face.values * lengths, PITCH * lengths)
    one, other = (
        run(face, distances, tolerance=0.1),
        run(stretched, distances * scaled.pop("distance"), tolerance=0.1, **scaled),
    )
    np.testing.assert_allclose(
        one["height"].values * factor, other["height"].values, atol=1e-4 * far * WEAR * 5e6
    )
    np.testing.assert_allclose(one["relative_contact_area"], other["relative_contact_area"], rtol=1e-3)
    np.testing.assert_array_equal(one["wear_steps"], other["wear_steps"])


def test_the_worn_face_is_a_map_to_measure_and_solve(face, far):
    worn = run(face, [0, far], tolerance=0.1).isel(sliding_distance=1)
    again = rc.solve_contact(worn["height"], contact_modulus=MODULUS, mean_pressure=5e6)
    counted = rc.contact_statistics(again, flow="never").isel(load=0)
    for name in ("relative_contact_area", "mean_gap", "contact_stiffness", "max_pressure"):
        assert float(counted[name]) == pytest.approx(float(worn[name]), rel=2e-3), name
    assert float(rc.parameters(worn["height"])["Spk"]) == pytest.approx(float(worn["Spk"]), rel=1e-9)


def test_answers_over_the_distance_run_in(face, far):
    worn = run(face, np.geomspace(1e-3, 100, 16) * far, tolerance=0.1)
    assert (np.diff(worn["relative_contact_area"])[:-3] > 0).all()
    assert worn["relative_contact_area"][-1] == 1
    assert (np.diff(worn["max_pressure"]) < 0).all()
    assert (np.diff(worn["mean_gap"])[:-3] < 0).all()
    settled = float(worn["running_in_distance"])

    def area(s):
        return np.interp(np.log(s), np.log(worn["sliding_distance"]), worn["relative_contact_area"])

    assert area(2 * settled) / area(settled) == pytest.approx(1.1, abs=0.03)


def test_units_are_those_of_the_trade(face, far):
    by_text = rc.run_in(
        face,
        contact_modulus="1 GPa",
        mean_pressure="5 MPa",
        wear_coefficient="1e-6 mm³/(N m)",
        sliding_distance=[f"{1e3 * far} mm"],
        tolerance=0.1,
    )
    np.testing.assert_allclose(by_text["height"], run(face, [far], tolerance=0.1)["height"], atol=1e-12)


def test_what_cannot_be_worn_is_refused(face):
    with pytest.raises(rc.SettingsError, match="sum of two rough faces, which changes while one slides"):
        run(face.assign_attrs(counter_face="b.npy"), [1.0])
    with pytest.raises(rc.SettingsError, match="the smooth counterface is worn evenly"):
        run(face, [1.0], wear=[WEAR, WEAR])
    with pytest.raises(rc.SettingsError, match="in rising order"):
        run(face, [2.0, 1.0])
    with pytest.raises(rc.SettingsError, match="wear_coefficient = '1 mm': unknown wear coefficient unit"):
        run(face, [1.0], wear="1 mm")


def test_a_layer_of_either_body_is_not_worn_through_without_a_word(face, far):
    """The order of the bodies does not say on which of them the face is."""
    coated = {"youngs_modulus": 2e9, "poissons_ratio": 0.3}
    coated |= {"layers": [{"thickness": "0.1 µm", "youngs_modulus": 3e9, "poissons_ratio": 0.2}]}
    bodies = [coated, {"youngs_modulus": 2e9, "poissons_ratio": 0.3}]
    worn = run(face, [0.01 * far], modulus=None, bodies=bodies, tolerance=0.1)
    assert float(worn["max_worn_depth"][0]) < 1e-7
    message = (
        r"after 2\.\d+ m .* has lost .* nm, and the outermost layer of the {} body is 100 nm thick; give"
    )
    for which, order in (("first", bodies), ("second", bodies[::-1])):
        with pytest.raises(rc.SettingsError, match=message.format(which)):
            run(face, [far], modulus=None, bodies=order, tolerance=0.1)


def test_the_height_parameters_of_all_distances_are_those_of_the_window(face):
    """The levelled map that it is cut from has others; Sq is the root mean square (ISO 25178-2)."""
    levelled = rc.level(face[:, : face.shape[1] // 2])
    window = rc.periodic_window(levelled)
    assert abs(levelled.attrs["Sq"] / float(window.std()) - 1) > 0.02
    worn = run(window, [0.0, 1e-9], tolerance=0.1)
    np.testing.assert_allclose(worn["Sq"], float(window.std()), rtol=1e-6)


def test_a_flat_face_wears_evenly():
    flat = rc.height_map(np.zeros((8, 8)), PITCH)
    worn = run(flat, [1.0], tolerance=0.02)
    np.testing.assert_allclose(worn["height"], -WEAR * 5e6, rtol=1e-12)
    assert float(worn["time_error_bound"][0]) == 0
    # heights of no more than rounding, far from zero
    worn = run(flat + np.pi * 1e-6, [1.0, 3.0], tolerance=0.02)
    np.testing.assert_array_equal(worn["wear_steps"], [1, 2])
