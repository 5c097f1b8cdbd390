"""After the load: closed forms of unloading, and the laws of plastic flow that is confined to pixels."""

import numpy as np
import pytest
from read_charts import read_chart
from scipy.optimize import brentq

import roughcontact as rc
from roughcontact.arguments.answers import TITLES
from roughcontact.report.courses import course_sections
from roughcontact.results.storage import write_dataset
from roughcontact.statistics.unloading import evaluate_unloading
from roughcontact.surface.synthetic import rough_reference_surface

HARDNESS = 0.4


def bump(points):
    """Return a paraboloid in the middle of a period of side 1."""
    x = (np.arange(points) - points / 2 + 0.5) / points
    square = x[:, None] ** 2 + x[None] ** 2
    return rc.height_map(np.where(square < 0.16, -0.25 * square, -0.04), 1 / points)


@pytest.fixture(scope="module")
def cycle():
    """Return the contact on the way up, in the end with a quarter of the area at the hardness, and back."""
    loads = 0.12 * np.linspace(0.01, 1, 40) ** 1.5
    up = rc.solve_contact(
        rough_reference_surface(64),
        contact_modulus=1.0,
        mean_pressure=loads,
        hardness=HARDNESS,
        tolerance=1e-8,
    )
    return up, rc.unload(up, mean_pressure=loads[::-1], tolerance=1e-8)


def test_a_flattened_summit_recovers_as_johnson_says():
    """From a uniform pressure H over a circle, by superposition of flat punches (Johnson 1985, section 3.4).

    At the share 2/pi (asin b - b sqrt(1 - b2)) of the load, the radius is that share b of the first, and the
    approach has recovered 2 H a/E* sqrt(1 - b2).
    """
    hardness, load, shares = 0.002, 6e-5, np.array([1, 0.8, 0.5, 0.2, 0.05, 0.01])
    # by the rule `lattice` the approach is that of an isolated contact
    loaded = rc.solve_contact(
        bump(256),
        contact_modulus=1.0,
        mean_pressure=load,
        hardness=hardness,
        tolerance=1e-8,
        zero_frequency="lattice",
    )
    assert float(loaded["yielded_area"][0]) > 0.98 * (loaded["pressure"].values > 0).mean()
    unloaded = rc.unload(loaded, mean_pressure=load * shares)
    radii = [
        brentq(lambda b, s=s: 2 / np.pi * (np.arcsin(b) - b * np.sqrt(1 - b * b)) - s, 0, 1) for s in shares
    ]
    areas = (unloaded["pressure"].values > 0).mean((1, 2))
    np.testing.assert_allclose(areas / areas[0], np.square(radii), atol=0.02)  # the rim is a few pixels
    recovery = unloaded["approach"].values - unloaded["approach"].values[0]
    radius = np.sqrt(load / hardness / np.pi)
    np.testing.assert_allclose(
        recovery, 2 * hardness * radius * np.sqrt(1 - np.square(radii)), rtol=3e-3, atol=1e-12
    )


def test_the_residual_surface_returns_the_pressure(cycle):
    up, down = cycle
    change = down["pressure"].values[0] - up["pressure"].values[-1]
    assert np.linalg.norm(change) <= 1e-6 * np.linalg.norm(up["pressure"].values[-1])
    assert down["pressure"].max() <= HARDNESS * (1 + 1e-5)


def test_the_area_is_never_below_that_of_loading_and_the_gap_never_above(cycle):
    counted = [rc.contact_statistics(contact, flow="never") for contact in cycle]
    areas, gaps = (
        [statistics[name].values for statistics in counted] for name in ("relative_contact_area", "mean_gap")
    )
    assert (areas[1][::-1] >= areas[0] - 1e-12).all()
    assert (gaps[1][::-1] <= gaps[0] * (1 + 1e-9)).all()
    assert areas[1][::-1][10] > 1.3 * areas[0][10]  # far from the largest load much more remains


def test_the_energy_lost_is_the_area_between_the_curves(cycle):
    down = cycle[1]
    work = [abs(np.trapezoid(c["mean_pressure"].values, c["approach"].values)) for c in cycle]
    assert float(down["dissipated_energy"]) == pytest.approx(work[0] - work[1], rel=5e-3)
    assert float(down["dissipated_energy"]) == pytest.approx(HARDNESS * float(down["plastic_depth"].mean()))


def test_the_residual_heights_are_a_map(cycle):
    up, down = cycle
    lowered = up["height"] - down["residual_height"]
    np.testing.assert_allclose(lowered, down["plastic_depth"], atol=1e-15)
    assert (down["plastic_depth"] >= 0).all()
    assert float(down["max_plastic_depth"]) == down["plastic_depth"].max()
    assert float(down["plastic_volume"]) == pytest.approx(float(down["mean_plastic_depth"]))  # window: 1 m2
    second_contact = rc.solve_contact(
        down["residual_height"], contact_modulus=1.0, mean_pressure=0.03, tolerance=1e-8
    )
    unloading = rc.unload(up, mean_pressure=0.03, tolerance=1e-8)
    np.testing.assert_allclose(second_contact["pressure"], unloading["pressure"], atol=1e-6 * HARDNESS)


def test_what_flows_of_a_profile_has_no_volume():
    x = np.linspace(0, 1, 64, endpoint=False)
    profile = rc.height_map(1e-7 * np.cos(2 * np.pi * x), 1e-6)
    down = rc.unload(rc.solve_contact(profile, contact_modulus=1e9, mean_pressure=2e6, hardness=5e6))
    assert float(down["mean_plastic_depth"]) > 0
    assert np.isnan(float(down["plastic_volume"]))


def test_layers_unload_as_layers():
    layer = {"thickness": 0.05, "youngs_modulus": 3.0, "poissons_ratio": 0.3}
    bodies = [
        {"youngs_modulus": 1.0, "poissons_ratio": 0.3, "layers": [layer]},
        {"youngs_modulus": 1e6, "poissons_ratio": 0.3},
    ]
    up = rc.solve_contact(
        rough_reference_surface(64), bodies=bodies, mean_pressure=0.2, hardness=1.0, tolerance=1e-8
    )
    assert float(up["yielded_area"][0]) > 0.01
    down = rc.unload(up)
    np.testing.assert_allclose(down["pressure"], up["pressure"], atol=2e-5)
    assert down["mean_pressure"].values.tolist() == [0.2]


def test_what_cannot_be_unloaded_is_refused(cycle):
    up, _ = cycle
    with pytest.raises(rc.SettingsError, match=r"0\.5 Pa is more than the largest load, 0\.12 Pa"):
        rc.unload(up, mean_pressure=[0.1, 0.5])
    with pytest.raises(rc.SettingsError, match="has no hardness"):
        rc.unload(up.drop_vars("hardness"))
    with pytest.raises(rc.SettingsError, match="the dataset has no pressure"):
        rc.unload(up.drop_vars("pressure"))


def test_the_area_of_each_load_is_that_of_the_statistics(cycle):
    down = cycle[1]
    counted = rc.contact_statistics(down, flow="never")["relative_contact_area"]
    np.testing.assert_array_equal(down["relative_contact_area"], counted)


def both_ways(folder, statistics, contact, peak):
    """Return the words and the chart of the area of a page, with a correction of the areas of loading."""
    settings = {"contact": {"unload": [peak], "contact_modulus": 1.0, "bodies": None}, "statistics": {}}
    write_dataset(evaluate_unloading(contact, contact["height"], settings), folder / "residual.nc")
    corrected = {"relative_contact_area_as_solved": statistics["relative_contact_area"]}
    corrected["relative_contact_area"] = 0.9 * statistics["relative_contact_area"]
    page = course_sections("ground", statistics.assign(corrected), folder, folder)["unloading"]
    return page["sentences"][0], read_chart(page["images"][TITLES["relative_contact_area"]], log="xy")


def test_both_ways_on_the_page_are_as_solved_and_meet_at_the_peak(tmp_path, cycle):
    contact = cycle[0].isel(load=slice(20, None, 6))
    statistics = rc.contact_statistics(contact)
    words, chart = both_ways(tmp_path, statistics, contact, float(contact["mean_pressure"].max()))
    up, down = chart.lines
    assert up.y[up.x.argmax()] == pytest.approx(down.y[down.x.argmax()], rel=0.01)
    lowest = 100 * float(statistics["relative_contact_area"][0])
    assert f" is {lowest:.1f} % on loading" in words


def test_a_load_below_those_solved_has_no_area_of_loading_on_the_page(tmp_path, cycle):
    contact = cycle[0].isel(load=slice(20, None, 6))
    lowest = float(contact["mean_pressure"][0])
    words, _ = both_ways(tmp_path, rc.contact_statistics(contact), contact, lowest / 2)
    assert "on unloading" in words
    assert "on loading" not in words
