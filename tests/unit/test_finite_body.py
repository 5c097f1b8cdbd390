"""Bodies of finite size in a study: form, numbers beside Hertz, settings that do not fit."""

import re
from functools import cache
from unittest.mock import Mock

import numpy as np
import pytest
from known_surfaces import self_affine
from read_charts import read_chart
from scipy.integrate import quad
from scipy.interpolate import CubicSpline
from scipy.special import ellipk

import roughcontact as rc
from roughcontact import height_map, read_dataset
from roughcontact.arguments.finite_body import recover_roughness
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.settings.stages import stage_settings
from roughcontact.contact.elasticity.closed_forms import hertz, hertz_ellipse
from roughcontact.contact.elasticity.free_space import love
from roughcontact.evaluation import pipeline
from roughcontact.evaluation.kinds import local_scale
from roughcontact.evaluation.pipeline import run_chain
from roughcontact.interface.program import main
from roughcontact.report.budget_plots import beyond_in_words, shown_budget
from roughcontact.report.facts import surface_facts
from roughcontact.report.glance import LOAD, Cell, asked_columns, glance_rows, headings_of
from roughcontact.report.load_plots import area_against_load
from roughcontact.report.map_plots import pressure_map
from roughcontact.report.panel import _fields
from roughcontact.report.tables import number_tables
from roughcontact.statistics.contact_checks import plasticity
from roughcontact.statistics.contact_geometry import PERIMETER_CORRECTION
from roughcontact.statistics.finite_body import hertz_contact
from roughcontact.surface.synthetic import westergaard_surface
from roughcontact.surface.window.finite_body import finite_body
from roughcontact.uncertainty.scales import AREA, CONDUCTANCE, GAP

FREE = {"contact_modulus": 115e9, "boundary": "free", "force": "5 N"}


def ground(rms_height, shape=(160, 200)):
    return self_affine(shape, 5e-6, (20e-6, 200e-6), rms_height=rms_height, seed=3)


@cache
def pressed(rms_height, *radii):
    """Return the answer for a ball, or an ellipsoid, with this roughness under 5 N."""
    return rc.evaluate(ground(rms_height), contact=FREE, form={"radius": list(radii)})


@pytest.mark.parametrize(("radius", "warns"), [("2 mm", True), (None, False)])
def test_a_ball_is_in_the_map_or_in_the_settings(radius, warns):
    """A map that is a ball itself, with a radius stated as well, has half the radius."""
    coordinate = (np.arange(64) - 31.5) * 1e-6
    ball = rc.height_map(-(coordinate**2 + coordinate[:, None] ** 2) / 4e-3, 1e-6)
    contact = {"contact_modulus": "100 GPa", "boundary": "free", "force": "20 mN"}
    statistics = rc.evaluate(ball, contact=contact, form={"radius": radius})
    assert ('"Form"' in statistics.attrs["reasons"]) == warns
    hertz = (0.75 * 0.02 * (1e-3 if warns else 2e-3) / 100e9) ** (1 / 3)
    assert statistics["contact_radius"].item() == pytest.approx(hertz, rel=0.05)


def test_smooth_ball_is_that_of_hertz():
    answer = pressed(1e-10, "5 mm")
    exact = hertz(5.0, 5e-3, 115e9)
    assert answer["hertz_radius"].item() == pytest.approx(exact["contact_radius"])
    # the edge lies anywhere in its pixels: of nine forces the area is .9 % off (rms)
    assert answer["contact_radius"].item() == pytest.approx(exact["contact_radius"], rel=5e-3)
    assert -answer["approach"].item() == pytest.approx(exact["approach"], rel=2e-3)
    # the apex lies between four points, 1.2 nm above the highest
    assert answer["mutual_approach"].item() == pytest.approx(exact["approach"], rel=3e-3)
    low, high = (answer[f"mutual_approach_{end}"].item() for end in ("lower", "upper"))
    assert low <= exact["approach"] <= high < 1.01 * low
    assert answer["max_pressure"].item() == pytest.approx(answer["hertz_max_pressure"].item(), rel=5e-3)
    # dF/dδ = 2 E* a over the area of the map, and the energy 2/5 F δ
    area = 160 * 200 * 25e-12
    stiffness = 2 * 115e9 * exact["contact_radius"] / area
    assert answer["contact_stiffness"].item() == pytest.approx(stiffness, rel=0.02)
    assert answer["conductance_per_conductivity"].item() == pytest.approx(stiffness / 115e9, rel=0.02)
    assert answer["elastic_energy"].item() * area == pytest.approx(exact["energy"], rel=5e-3)


def test_heat_through_a_ball_has_gas_beside_spots_and_film():
    steel = {"youngs_modulus": 210e9, "poissons_ratio": 0.3, "thermal_conductivity": 50.0}
    gas, film = {"gas_conductivity": 0.026, "temperature_jump": "0.37 um"}, 5e-8 / 0.2
    contact = rc.solve_contact(
        finite_body(ground(2e-7), radius=[5e-3]), bodies=[steel, steel], boundary="free", force="5 N"
    )
    with_film = {"film_thickness": 5e-8, "film_conductivity": 0.2}
    answers = [
        rc.contact_statistics(contact, bodies=[steel, steel], joint=gas | film_options)
        for film_options in ({}, with_film)
    ]
    gap = contact["gap"].values[0]
    gas_beside = (0.026 / (gap + 0.37e-6))[contact["pressure"].values[0] == 0].sum() / gap.size
    for answer, added in zip(answers, (0.0, film), strict=True):
        assert answer["gas_conductance"].item() == pytest.approx(gas_beside)
        spots = 1 / (answer["thermal_resistance"] + added / answer["relative_contact_area"])
        assert answer["joint_conductance"].item() == pytest.approx(gas_beside + spots.item(), rel=1e-9)


def test_stresses_below_a_smooth_ball_are_those_of_hertz():
    """Largest stresses on the axis (Johnson 1985, section 4.2): 0.310 p0 of shear at 0.48 a for nu = 0.3."""
    steel = {"youngs_modulus": "210 GPa", "poissons_ratio": 0.3, "yield_stress": "700 MPa"}
    contact = {"bodies": [steel, steel], "boundary": "free", "force": ["5 N", "40 N"]}
    answer = rc.evaluate(ground(1e-10), contact=contact, form={"radius": "5 mm"})
    for load, force in enumerate((5.0, 40.0)):
        exact, numbers = hertz(force, 5e-3, 210e9 / 0.91 / 2), answer.isel(load=load)
        largest = 2 * 0.31001 * exact["max_pressure"]
        assert numbers["max_tresca_stress"].item() == pytest.approx(largest, rel=5e-3)
        assert numbers["max_von_mises_stress"].item() == pytest.approx(largest, rel=5e-3)
        depth = numbers["max_von_mises_depth"].item()
        assert depth == pytest.approx(0.481 * exact["contact_radius"], rel=0.03)
        middle = [(n - 1) / 2 * 5e-6 for n in (160, 200)]
        assert numbers["max_von_mises_y"].item() == pytest.approx(middle[0], abs=1e-5)
        assert numbers["max_von_mises_x"].item() == pytest.approx(middle[1], abs=1e-5)
    # the force of first yield, where p0 = 700 MPa/0.62: F = pi^3 R^2 p0^3/(6 E*^2)
    force = np.pi**3 * 25e-6 * (700e6 / 0.62) ** 3 / (6 * (210e9 / 1.82) ** 2)
    first_yield = answer["first_subsurface_yield_pressure"].item() * 160 * 200 * 25e-12
    assert first_yield == pytest.approx(force, rel=0.02)


def test_volume_above_yield_of_a_body_is_over_the_area_of_the_map():
    """The volume does not depend on how much of the flat around the contact is in the map."""
    bodies = [{"youngs_modulus": 210e9, "poissons_ratio": 0.3, "yield_stress": 4e8}]
    volumes = []
    for points in (128, 192):
        body = finite_body(ground(1e-12, (points, points)), radius=[5e-3])
        contact = rc.solve_contact(body, **FREE | {"force": 2.0})
        statistics = rc.contact_statistics(contact, bodies=bodies)
        volumes.append(statistics["volume_above_yield"].item() * points**2)
    assert volumes[0] == pytest.approx(volumes[1], rel=2e-3)


def test_stresses_in_layers_of_a_body_are_refused():
    film = {"thickness": 1e-6, "youngs_modulus": 4e11, "poissons_ratio": 0.2, "yield_stress": 5e9}
    layered = {"youngs_modulus": 210e9, "poissons_ratio": 0.3, "layers": [film]}
    contact = rc.solve_contact(finite_body(ground(1e-8, (64, 64)), radius=[5e-3]), **FREE | {"force": 0.2})
    assert "max_von_mises_stress" not in rc.contact_statistics(contact, bodies=[layered, layered])
    with pytest.raises(rc.SettingsError, match=r"stresses in layers .* finite size"):
        rc.contact_statistics(contact, bodies=[layered, layered], stress="always")


def test_coated_ball_in_a_study():
    """A stiff coating narrows the contact; what is of half-spaces has no value."""
    steel = {"youngs_modulus": 210e9, "poissons_ratio": 0.3}
    coated = steel | {"layers": [{"thickness": 20e-6, "youngs_modulus": 400e9, "poissons_ratio": 0.2}]}
    answers = [
        rc.evaluate(
            ground(5e-8, (96, 96)),
            contact={"bodies": [body, steel], "boundary": "free", "force": "2 N"},
            form={"radius": "5 mm"},
        )
        for body in (steel, coated)
    ]
    assert answers[1]["contact_radius"] < 0.97 * answers[0]["contact_radius"]
    assert answers[1]["max_pressure"] > answers[0]["max_pressure"]
    assert answers[1]["contact_stiffness"] > 0
    assert answers[1]["relative_contact_area_lower"] < answers[1]["relative_contact_area"]
    assert "hertz_radius" not in answers[1]
    assert answers[1][["loaded_radius", "conductance_per_conductivity"]].to_array().isnull().all()


def test_roughness_lowers_the_area_and_raises_the_pressure():
    answer = pressed(1.5e-7, "5 mm", "10 mm")
    smooth = hertz_ellipse(5.0, (5e-3, 10e-3), 115e9)
    assert answer["hertz_radius"].item() == pytest.approx((smooth["major"] * smooth["minor"]) ** 0.5)
    assert answer["contact_radius"] < answer["hertz_radius"]
    assert answer["max_pressure"] > 1.2 * answer["hertz_max_pressure"]
    assert answer["relative_contact_area_lower"] < answer["relative_contact_area"]
    assert answer["area_persson"].isnull().all()
    assert answer["gap_percolates_x"].isnull().all()
    assert answer["verdict"].item() in (0, 1)


def test_loaded_radius_and_theory_beside_hertz():
    answer, rough = pressed(1e-10, "5 mm"), pressed(1.5e-7, "5 mm")
    assert answer["loaded_radius"].item() == pytest.approx(answer["hertz_radius"].item(), rel=2e-3)
    assert rough["loaded_radius"].item() > 1.01 * rough["hertz_radius"].item()
    # the theory has the same form: a wider circle, under a lower nominal pressure
    assert rough["greenwood_tripp_loaded_radius"].item() == pytest.approx(
        rough["loaded_radius"].item(), rel=0.1
    )
    assert rough["greenwood_tripp_max_pressure"] < rough["hertz_max_pressure"]
    assert rough["greenwood_tripp_contact_area"] < np.pi * rough["hertz_radius"] ** 2
    assert "greenwood_tripp_loaded_radius" not in pressed(1.5e-7, "5 mm", "10 mm")


def test_roughness_of_a_body_is_the_map():
    map_ = ground(1e-7, (40, 50))
    for form in ({"radius": [2e-3, 3e-3]}, {"edges": True}, {"radius": [2e-3], "edges": True}):
        roughness = recover_roughness(finite_body(map_, **form))
        np.testing.assert_allclose(roughness.values, map_.values, atol=1e-18 + 1e-9 * np.ptp(map_.values))


@pytest.mark.parametrize("form", [{"radius": "5 mm"}, {"edges": True}])
def test_numbers_of_the_map_are_those_of_the_roughness(form, monkeypatch):
    once = Mock(wraps=pipeline.solve_contact)
    monkeypatch.setattr(pipeline, "solve_contact", once)
    answer = rc.evaluate(ground(1e-7), contact=FREE, form=form, uncertainty={"sources": []})
    once.assert_called_once()  # without a budget nothing has to be solved for it
    measured = rc.level(ground(1e-7))
    assert answer["rms_height"].item() == pytest.approx(measured.attrs["Sq"], rel=0.02)
    expected = answer["mean_pressure"] / (115e9 * answer["rms_gradient"])
    assert answer["relative_pressure"].item() == pytest.approx(expected.item())


def test_budget_of_a_ball_has_its_sources():
    uncertainties = {"contact_modulus_uncertainty": 0.1}
    answer = rc.evaluate(
        ground(1.5e-7), contact=FREE | uncertainties, form={"radius": "5 mm"}, instrument={"noise": "2 nm"}
    )
    area = answer["relative_contact_area_uncertainty"].isel(load=0)
    assert (area.sel(source=["solver", "discretisation", "window", "instrument", "material"]) > 0).all()
    assert area.sel(source="unresolved").isnull()
    # a modulus 10 % higher is a force 10 % lower, apart from the heights of the roughness
    lower = rc.evaluate(
        ground(1.5e-7), contact=FREE | {"contact_modulus": 1.1 * 115e9}, form={"radius": "5 mm"}
    )
    change = answer["relative_contact_area_as_solved"] - lower["relative_contact_area_as_solved"]
    below = answer["relative_contact_area_components"].isel(load=0).sel(source="material", component="down")
    assert below.item() == pytest.approx(change.item(), rel=0.1)
    # this position is known better than another one
    assert answer["max_pressure_map_upper"] < answer["max_pressure_next_upper"]
    assert answer["max_pressure_octave_upper"].isnull().all()


def test_other_positions_lie_in_the_interval():
    """Balls at places that the budget has not solved: 15 of 16 numbers lie in the interval of 95 %."""
    answer = pressed(1.5e-7, "5 mm")
    names = ("relative_contact_area", "mutual_approach")
    rng, inside = np.random.default_rng(7), dict.fromkeys(names, 0)
    for _ in range(16):
        roughness = ground(1.5e-7)
        shift = rng.integers(-50, 50, 2)
        moved = roughness.copy(data=np.roll(roughness.values, shift, (0, 1)))
        contact = rc.solve_contact(finite_body(moved, radius=[5e-3]), **FREE)
        numbers = rc.contact_statistics(contact, flow="never")
        for name in names:
            low, high = (answer[f"{name}_next_{side}"].item() for side in ("lower", "upper"))
            inside[name] += low <= numbers[name].item() <= high
    assert min(inside.values()) >= 15


def test_half_as_large_pixels_agree_with_hertz():
    """The correction for pixels takes the area of a smooth ball nearer to Hertz's, over nine forces."""
    forces = np.geomspace(2.0, 8.0, 9)
    contact, options = FREE | {"force": forces.tolist()}, {"sources": ["discretisation"]}
    answer = rc.evaluate(
        ground(1e-10, (96, 96)), contact=contact, form={"radius": "5 mm"}, uncertainty=options
    )
    exact = [np.pi * hertz(force, 5e-3, 115e9)["contact_radius"] ** 2 for force in forces]
    area = {
        key: answer[f"relative_contact_area_{key}"].values * (96 * 96 * 25e-12) / exact
        for key in ("estimate", "as_solved", "lower", "upper")
    }
    rms = {key: np.sqrt(np.mean((ratio - 1) ** 2)) for key, ratio in area.items()}
    assert rms["estimate"] < 0.7 * rms["as_solved"] < 0.7 * 0.015
    assert ((area["lower"] <= 1) & (area["upper"] >= 1)).sum() >= 8


def test_no_other_positions_on_a_map_little_larger_than_the_contact():
    answer = rc.evaluate(ground(1.5e-8, (48, 48)), contact=FREE, form={"radius": "5 mm"})
    assert answer["relative_contact_area_uncertainty"].sel(source="window").isnull().all()
    assert answer["relative_contact_area_next_upper"].isnull().all()
    assert answer["relative_contact_area_upper"].notnull().all()


def test_ellipse_of_hertz_on_the_map_of_pressure():
    body = finite_body(ground(1e-10, (128, 160)), radius=[10e-3, 5e-3])
    contact = rc.solve_contact(body, **FREE | {"force": 2.0})
    ellipse = hertz_contact(body, contact, 0)
    for axis in "xy":
        touching = contact["contact"][0].any("y" if axis == "x" else "x").sum().item() * 5e-6 / 2
        assert touching == pytest.approx(ellipse[f"axis_{axis}"], abs=5e-6)
    pressure = contact["pressure"].values[0]
    outline = max(pressure_map(body, pressure, ellipse=ellipse).source().split("%3C"), key=len)
    assert outline != max(pressure_map(body, pressure).source().split("%3C"), key=len)


@pytest.mark.parametrize("share", [2.0, 0.9, 0.7])
@pytest.mark.parametrize("rms_height", [0.0, 3e-8])
def test_energy_and_loaded_radius_are_those_of_the_pressure(share, rms_height):
    """By Love's rectangles, summed directly; what has flowed is no elastic displacement."""
    n, step, modulus, radius = 49, 2e-6, 1e11, 1e-3
    exact = hertz(force := 4 * modulus * (30e-6) ** 3 / (3 * radius), radius, modulus)
    x = (np.arange(n) - n // 2) * step
    ball = -(x[:, None] ** 2 + x**2) / (2 * radius) + rms_height / 3e-8 * ground(3e-8, (n, n)).values
    contact = rc.solve_contact(
        height_map(ball, step),
        **FREE | {"contact_modulus": modulus, "force": force},
        hardness=share * exact["max_pressure"],
        influence="elements",
        tolerance=1e-8,
    )
    numbers = rc.contact_statistics(contact)
    pressure = contact["pressure"].values[0]
    response = love((n, n), (step, step)) / modulus
    rows, columns = (np.abs(np.subtract.outer(np.arange(n), np.arange(n))),) * 2
    displacement = np.einsum("ijkl,jl->ik", response[rows][:, :, columns], pressure)
    energy = (pressure * displacement).mean() / 2
    assert numbers["elastic_energy"].item() == pytest.approx(energy, rel=1e-6)
    loaded = 0.75 * force / modulus / displacement[n // 2, n // 2]
    assert numbers["loaded_radius"].item() == pytest.approx(loaded, rel=1e-6)
    assert (contact["yielded_area"].item() > 0) == ((pressure >= 0.999 * contact["hardness"].item()).any())


def test_a_ball_that_flows_throughout_is_a_disc_of_constant_pressure():
    """Closed forms of Johnson (1985), section 3.4a: in the middle 2 H a/E*, at the edge 4 H a/(π E*)."""
    modulus, radius, hardness, a = 1e11, 1e-3, 3e7, 60e-6
    x = (np.arange(97) - 48) * 2e-6
    contact = rc.solve_contact(
        height_map(-(x[:, None] ** 2 + x**2) / (2 * radius), 2e-6),
        **FREE | {"contact_modulus": modulus, "force": np.pi * a**2 * hardness},
        hardness=hardness,
    )
    numbers = rc.contact_statistics(contact, flow="never")
    map_area = (97 * 2e-6) ** 2
    assert numbers["contact_area"].item() == pytest.approx(np.pi * a**2, rel=0.01)
    assert contact["yielded_area"].item() * map_area == pytest.approx(np.pi * a**2, rel=0.01)
    energy = 8 / 3 * hardness**2 * a**3 / modulus
    assert numbers["elastic_energy"].item() * map_area == pytest.approx(energy, rel=1e-3)
    assert numbers["loaded_radius"].item() == pytest.approx(3 * np.pi * a / 8, rel=1e-3)
    approach = a**2 / (2 * radius) + 4 * hardness * a / (np.pi * modulus)
    assert numbers["mutual_approach"].item() == pytest.approx(approach, rel=3e-3)
    assert numbers["max_pressure"].item() == pytest.approx(hardness, rel=1e-9)


def test_points_at_the_hardness_have_yielded_whatever_the_rounding():
    coordinate = (np.arange(41) - 20) * 2e-6
    ball = height_map(-(coordinate[:, None] ** 2 + coordinate**2) / 2e-3, 2e-6)
    force = 0.1 * (1 + np.array([7, 8, 9]) / 37)  # of the second, pressures end one bit below the hardness
    contact = rc.solve_contact(
        ball, contact_modulus=1e11, hardness=4e8, boundary="free", force=force.tolist()
    )
    at_hardness = (contact["pressure"] >= 4e8 * (1 - 1e-12)).mean(("y", "x"))
    np.testing.assert_array_equal(contact["yielded_area"], at_hardness)
    assert (at_hardness > 0.01).all()


def test_a_smooth_ball_has_no_roughness_from_rounding_and_yields_under_a_force(tmp_path, capsys):
    """The theory of summits has no value, first yield at and below the surface is Hertz's force."""
    flat = height_map(np.zeros((64, 64)), 1e-6)
    rc.write_dataset(flat.rename("height"), file := tmp_path / "flat.nc")
    command = ["solve", str(file), *(2 * ["--body", "steel", "yield_stress=700MPa"])]
    command += ["--boundary", "free", "--form-radius", "1mm", "--uncertainty-sources", "--force", "0.9N"]
    assert main([*command, "0.3N"]) == 0
    screen, modulus = capsys.readouterr().out, 207e9 / 0.91 / 2
    assert "rms height        0 µm" in screen
    # Johnson (1985), section 6.1
    for place, largest in (("at", 1.4e9), ("below", 700e6 / 0.62)):
        force, unit = re.search(rf"First yield {place} the surface +at ([\d.]+) (m?N)\n", screen).groups()
        exact = np.pi**3 * 1e-6 * largest**3 / (6 * modulus**2)
        assert float(force) * (1e-3 if unit == "mN" else 1) == pytest.approx(exact, rel=0.02)
    assert main(command) == 0
    assert "First yield below the surface  below the loads solved" in capsys.readouterr().out
    settings = {"contact": FREE | {"force": [0.3, 0.9], "hardness": 1.4e9}, "form": {"radius": "1 mm"}}
    answer = rc.evaluate(flat, **settings, uncertainty={"sources": []})
    assert answer[["rms_gradient", "rms_height"]].to_array().values.tolist() == [0.0, 0.0]
    assert answer["greenwood_tripp_max_pressure"].isnull().all()
    facts = surface_facts(flat, rc.level(flat), flat, answer)
    assert "Greenwood" not in facts["Body of finite size"]
    force = f"{answer['first_yield_pressure'].item() * (64e-6) ** 2:.2f} N"
    assert facts["First yield at the surface"] == f"at {force}"
    assert f"First yield at a force of {force}." in plasticity(answer).sentence


def test_hardness_limits_the_pressure_of_a_study():
    answer = rc.evaluate(ground(1.5e-7), contact=FREE | {"hardness": "1 GPa"}, form={"radius": "5 mm"})
    assert answer["max_pressure"].item() == pytest.approx(1e9)
    assert answer["error_bound"].item() <= 1e-4


def test_first_yield_beyond_the_map_is_left_out_and_refuses_no_load(tmp_path, capsys):
    form = {"radius": "5 mm"}
    contact = FREE | {"hardness": "20 GPa", "force": "0.5 N"}  # touches over 1.7 mm at first yield
    answer = rc.evaluate(ground(1e-9), contact=contact, form=form, uncertainty={"sources": []})
    assert "first_yield_pressure" not in answer
    assert "First yield" not in plasticity(answer).sentence
    softer = rc.evaluate(
        ground(1e-9), contact=contact | {"hardness": "2 GPa"}, form=form, uncertainty={"sources": []}
    )
    assert "First yield" in plasticity(softer).sentence
    rc.write_dataset(ground(1e-9).rename("height"), file := tmp_path / "ball.nc")
    options = ["--contact-modulus", "115GPa", "--hardness", "20GPa", "--boundary", "free"]
    options += ["--force", "0.5N", "0.2N", "--form-radius", "5mm", "--uncertainty-sources"]
    assert main(["solve", str(file), *options]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "Hardness 20.0 GPa" in out
    assert "First yield" not in out
    assert " ± for " not in out  # nothing has one
    assert "at 200 mN" not in out  # the table has the other loads
    assert "at 500 mN" in out


def test_flat_punch_with_the_edges_of_the_map(tmp_path, capsys):
    """F = pi C E* δ, with the capacitance C = 0.36679 of a square of side 1 (Read 1997)."""
    flat = height_map(1e-12 * np.indices((128, 128)).sum(axis=0) % 2e-12, 5e-6)
    answer = rc.evaluate(flat, contact=FREE, form={"edges": True}, level={"form": "mean"})
    side = 128 * 5e-6
    assert answer["contact_area"].item() == pytest.approx(side**2, rel=0.02)
    rc.write_dataset(flat[:20, :30].rename("height"), file := tmp_path / "punch.nc")
    options = ["--contact-modulus", "115GPa", "--boundary", "free", "--force", "5N", "--form-edges", "true"]
    main(["solve", str(file), *options, "--level-form", "mean", "--uncertainty-sources"])
    assert "30 × 20 points, 150 µm × 100 µm, 100 % of the map" in capsys.readouterr().out
    levelled = rc.level(flat, form="mean")
    facts = surface_facts(flat, levelled, finite_body(levelled, edges=True), answer)
    assert facts["Window"].startswith("640 µm × 640 µm, 128 × 128 points")
    stiffness = -5.0 / (115e9 * side * answer["approach"].item())
    assert stiffness == pytest.approx(np.pi * 0.3667896, rel=4e-3)


@pytest.mark.parametrize(("points", "modulus"), [(65, 115e9), (65, 1e8)])
def test_a_flat_punch_touches_with_all_of_its_area(points, modulus):
    """A soft half-space takes it in by more than its side; nothing lies beyond its edges."""
    side, pressure = points * 1e-6, 5e6
    contact = FREE | {"contact_modulus": modulus, "force": pressure * side**2}
    flat = height_map(np.zeros((points, points)), 1e-6)
    answer = rc.evaluate(flat, contact=contact, form={"edges": True}, level={"form": "none"})
    exact = {"relative_contact_area": 1, "mean_pressure": pressure, "mean_contact_pressure": pressure}
    exact |= {"mean_gap": 0, "contact_area": side**2, "contact_clusters": 1, "load_error": 0}
    for name, value in exact.items():
        assert answer[name].item() == pytest.approx(value, rel=1e-12, abs=1e-12), name
    assert answer["relative_contact_area_lower"] > 0.999
    assert answer["elastic_energy"].item() == pytest.approx(-pressure * answer["approach"].item() / 2)
    stiffness = np.pi * 0.3667896 * modulus * side
    assert answer["contact_stiffness"].item() * side**2 == pytest.approx(stiffness, rel=8e-3)


@pytest.mark.parametrize("hardness", [None, 5e8])
def test_numbers_of_a_body_with_edges_are_those_of_the_same_one_far_above_its_surroundings(hardness):
    """What is by area is over the area of the body, whatever the surroundings; the rest is the same."""
    steel = {"youngs_modulus": 210e9, "poissons_ratio": 0.3, "thermal_conductivity": 50.0}
    steel |= {"yield_stress": 4e8}
    joint = {"gas_conductivity": 0.026, "temperature_jump": 0.37e-6}
    face, margin, steps = ground(5e-8, (48, 60)), 12, (5e-6, 6e-6)
    face = height_map(face.values, steps)
    around = height_map(np.pad(face.values, margin, constant_values=-1e-3), steps)
    inside, bodies = (slice(margin, -margin),) * 2, [steel, steel]
    problem = {"boundary": "free", "bodies": bodies, "force": 4.0, "hardness": hardness, "tolerance": 1e-7}
    numbers = []
    for body in (finite_body(face, edges=True), around):
        contact = rc.solve_contact(body, **problem)
        numbers.append(rc.contact_statistics(contact, bodies=bodies, joint=joint))
    punch, surrounded = numbers
    pressure, gap = (contact[name].values[0][inside] for name in ("pressure", "gap"))
    touching, area = pressure > 0, face.size * np.prod(steps)
    inner = sum(np.count_nonzero(np.diff(touching, axis=axis)) for axis in (0, 1))
    exact = {
        "mean_pressure": 4.0 / area,
        "mean_gap": np.where(touching, 0, gap).mean(),
        "gas_conductance": 0.026 * (1 / (gap[~touching] + 0.37e-6)).sum() / face.size,
        "relative_contact_area_pixels": touching.mean(),
        "relative_contact_area": touching.mean() - PERIMETER_CORRECTION * inner / face.size,
    }
    larger = around.size / face.size
    for name in ("contact_stiffness", "thermal_conductance", "elastic_energy", "volume_above_yield"):
        exact[name] = larger * surrounded[name].item()
    exact |= {"yielded_area": larger * surrounded["yielded_area"].item()}
    same = ("approach", "max_pressure", "mean_contact_pressure", "contact_perimeter", "largest_patch_area")
    exact |= {name: surrounded[name].item() for name in (*same, "max_von_mises_stress", "loaded_radius")}
    exact |= {"contact_clusters": surrounded["contact_clusters"].item(), "window_length_x": 60 * 6e-6}
    for name, value in exact.items():
        assert punch[name].item() == pytest.approx(value, rel=3e-4), name
    assert (hardness is None) == (punch["yielded_area"].item() == 0)


def test_the_budget_of_a_body_with_edges_is_over_its_area():
    contact, form = FREE | {"force": "0.3 N"}, {"edges": True}
    contact_with_range = contact | {"mean_pressure_uncertainty": 0.1}
    face, sources = ground(5e-8, (48, 60)), {"sources": ["solver", "discretisation", "material"]}
    answer = rc.evaluate(face, contact=contact_with_range, form=form, uncertainty=sources)
    forces = contact | {"force": [0.27, 0.33]}
    extremes = rc.evaluate(face, contact=forces, form=form, uncertainty={"sources": []})
    for name in ("relative_contact_area", "mean_gap"):
        change = abs(extremes[name] - answer[f"{name}_as_solved"].item()).max().item()
        width = answer[f"{name}_uncertainty"].isel(load=0).sel(source="material")
        assert width.item() == pytest.approx(change, rel=0.03), name
        assert 0.5 < answer[f"{name}_lower"].item() / answer[name].item() < 1, name


def test_the_height_of_edges_is_no_steep_map(recwarn):
    rough = self_affine((48, 48), 1e-6, (8e-6, 48e-6), rms_gradient=0.1, seed=3)
    settings = {"contact": FREE | {"force": "10 mN"}, "form": {"edges": True}, "uncertainty": {"sources": []}}
    assert rc.evaluate(rough, **settings)["rms_gradient"] < 0.2
    assert not recwarn
    with pytest.warns(rc.HeightMapWarning, match="steeper than any measured surface"):
        rc.evaluate(100 * rough, **settings)


def test_form_is_added_to_the_map():
    map_ = ground(1e-7, (40, 50))
    y, x = (map_[axis].values - map_[axis].values.mean() for axis in "yx")
    body = finite_body(map_, radius=[2.0, 3.0])
    np.testing.assert_allclose(body.values, map_.values - x**2 / 4 - y[:, None] ** 2 / 6)
    np.testing.assert_allclose(body["x"].values, map_["x"].values)
    punch = finite_body(map_, edges=True)
    np.testing.assert_array_equal(punch.values, map_.values)
    np.testing.assert_allclose(punch["x"].values, map_["x"].values)


def test_map_smaller_than_the_contact_is_refused_with_a_size():
    with pytest.raises(rc.HeightMapError, match=r"reaches the border .* a map of 411 µm × 411 µm would do"):
        rc.evaluate(ground(1e-9, (40, 40)), contact=FREE | {"force": "200 N"}, form={"radius": "5 mm"})

    with pytest.raises(rc.HeightMapError, match=r"state form\.radius .* or set form\.edges: true"):
        rc.evaluate(ground(1e-7, (40, 40)), contact=FREE)
    # a form flatter than the roughness is curved
    with pytest.raises(rc.HeightMapError, match=r"radius of curvature, 5\.00 m, touches over 1\.09 mm"):
        rc.evaluate(ground(1e-7, (40, 40)), contact=FREE, form={"radius": 5})


def test_a_force_that_no_contact_carries_is_refused_with_the_largest():
    hard = {"contact_modulus": 115e9, "hardness": 1e9}
    with pytest.raises(rc.SettingsError, match=r"carries at the hardness 1e\+09 Pa: stay below 40 N"):
        rc.evaluate(ground(1e-7, (40, 40)), contact=hard | FREE | {"force": 50.0}, form={"edges": True})
    with pytest.raises(
        rc.SettingsError, match=r"force = 50000 N: .* \(Hertz\), .* stay below (\d+) N"
    ) as error:
        rc.evaluate(ground(1e-7, (40, 40)), contact=hard | {"force": [5.0, "50 kN"]}, form=LOCAL)
    limit = float(re.search(r"stay below (\d+) N", str(error.value)).group(1))
    assert limit == pytest.approx(np.pi**3 * 0.05**2 * 1e27 / (6 * 115e9**2), rel=1e-2)  # Johnson, eq. 4.24

    with pytest.raises(rc.SettingsError, match=r"force 1e-20 N: below 4.8e-14 N the contact is lost"):
        rc.solve_contact(finite_body(ground(1e-7, (40, 40)), radius=[5e-3]), **FREE | {"force": 1e-20})


def test_friction_of_a_finite_body_is_refused_before_it_is_solved():
    options = {"contact": FREE, "form": {"radius": "5 mm"}}
    friction = {"coefficient": 0.2, "tangential_load": [0.5], "speed": 1.0}
    with pytest.raises(
        rc.SettingsError, match=r"friction.tangential_load = \[0.5\]: is for periodic maps, and boundary"
    ):
        rc.evaluate(ground(1e-7), **options, statistics={"friction": friction})


LOCAL = {"radius": "50 mm", "local_scale": True}
WITHOUT_BUDGET = {"level": {"form": "mean", "outlier_threshold": None}, "uncertainty": {"sources": []}}


@pytest.mark.parametrize("ratio", [0.3, 0.9])
def test_local_scale_of_a_wave_is_the_integral_of_its_closed_form(ratio):
    """Westergaard (1939): A/A0 = (2/pi) arcsin sqrt(p/p*), over the pressures of Hertz's ellipse."""
    radii, forces = (0.05, 0.08), np.array([50.0, 6.0])
    smooth = [hertz_ellipse(force, radii, 115e9) for force in forces]
    amplitude = smooth[0]["max_pressure"] / ratio * 100e-6 / np.pi / 115e9
    wave = westergaard_surface((4, 1024), 100e-6 / 1024, amplitude=amplitude, wavelength=100e-6)
    answer = rc.evaluate(
        wave,
        window={"method": "raw"},
        contact={"contact_modulus": 115e9, "force": forces.tolist()},
        form={"radius": list(radii), "local_scale": True},
        **WITHOUT_BUDGET,
    )
    np.testing.assert_allclose(answer["force"], forces)
    np.testing.assert_allclose(answer["hertz_approach"], [body["approach"] for body in smooth])
    for load, body in enumerate(smooth):
        a, b, middle = body["major"], body["minor"], body["max_pressure"] / smooth[0]["max_pressure"]
        share = quad(lambda s, p=ratio * middle: 4 / np.pi * s * np.arcsin(np.sqrt(s * p)), 0, 1)[0]
        assert answer["local_contact_area"][load] == pytest.approx(np.pi * a * b * share, rel=2e-3)
        assert answer["hertz_radius"][load] == pytest.approx(np.sqrt(a * b))
    assert answer["local_mean_gap"][0] > answer["mean_gap"][0]  # lowest in the middle
    assert np.all(answer["local_mean_gap"] < amplitude)
    assert "Roughness has to be small against the form" in answer.attrs["reasons"]


def test_local_scale_of_a_smooth_map_is_the_contact_of_hertz():
    flat = height_map(1e-12 * np.indices((32, 32)).sum(axis=0) % 2e-12, 1e-6)
    answer = rc.evaluate(flat, contact={"contact_modulus": 115e9, "force": 50}, form=LOCAL, **WITHOUT_BUDGET)
    exact = np.pi * hertz(50.0, 0.05, 115e9)["contact_radius"] ** 2
    assert answer["local_contact_area"].item() == pytest.approx(exact, rel=1e-9)
    assert answer["local_mean_gap"].item() < 1e-15
    holm = 2 * hertz(50.0, 0.05, 115e9)["contact_radius"]  # 1/(2 a k)
    assert answer["local_conductance_per_conductivity"].item() == pytest.approx(holm, rel=1e-9)
    assert "local_contact_area_lower" not in answer
    # 1/(4 a k) on either side (Carslaw and Jaeger 1959, section 8.2), ρ/(4 a) by Holm
    conductors = [
        {"thermal_conductivity": k, "electrical_resistivity": rho} for k, rho in ((400, 2e-8), (50, 2e-7))
    ]
    bodies = [{"youngs_modulus": 2e11, "poissons_ratio": 0.3} | properties for properties in conductors]
    joined = rc.evaluate(flat, contact={"bodies": bodies, "force": 50}, form=LOCAL, **WITHOUT_BUDGET)
    radius = joined["hertz_radius"].item()
    heat, current = (1 / 400 + 1 / 50) / (4 * radius), 2.2e-7 / (4 * radius)
    assert joined["local_thermal_resistance"].item() == pytest.approx(heat)
    assert joined["local_electrical_resistance"].item() == pytest.approx(current)
    contact = {"contact_modulus": 115e9, "force": 50, "contact_modulus_uncertainty": 0.05}
    bounded = rc.evaluate(flat, contact=contact, form=LOCAL)
    lower, upper = (
        bounded[f"local_conductance_per_conductivity_{side}"].item() for side in ("lower", "upper")
    )
    # a flux like the pressure, and 2 a, are changed by the modulus as its cube root
    assert [lower, upper] == pytest.approx([holm / 1.2, holm / 0.95 ** (1 / 3)], rel=1e-3)
    wider = rc.evaluate(
        ground(1e-8), contact={"contact_modulus": 115e9, "force": 5}, form=LOCAL, **WITHOUT_BUDGET
    )
    assert "larger than the contact, with boundary: free" in wider.attrs["reasons"]


ROUGH = ground(1e-7, (96, 96))
CONTACT = {"contact_modulus": 115e9, "tolerance": 1e-6}
MEAN = {"form": "mean", "outlier_threshold": None}


def test_ends_of_the_local_scale_are_those_of_the_map_over_the_pressures_of_hertz():
    """The quadrature is that of SciPy over an interpolation between 9 loads, instead of six nodes."""
    options = {
        "level": MEAN,
        "uncertainty": {"sources": ["solver", "discretisation", "window"], "windows": 4},
    }
    local = rc.evaluate(ROUGH, **options, contact=CONTACT | {"force": 40.0}, form=LOCAL)
    smooth = hertz(40.0, 0.05, 115e9)
    loads = smooth["max_pressure"] * np.geomspace(0.07, 1, 9)
    curve = rc.evaluate(ROUGH, **options, contact=CONTACT | {"mean_pressure": loads.tolist()})

    def over_hertz(values):
        spline = CubicSpline(np.log(loads / loads[-1]), np.log(values))
        return quad(lambda s: 2 * s * np.exp(spline(np.log(s))), 1e-2, 1)[0]

    area = np.pi * smooth["contact_radius"] ** 2
    for suffix in ("", "_lower", "_upper"):
        of_map = {
            name: over_hertz(curve[f"{name}{suffix}"])
            for name in ("relative_contact_area", "mean_gap", "conductance_per_conductivity")
        }
        assert local[f"local_contact_area{suffix}"].item() == pytest.approx(
            area * of_map["relative_contact_area"], rel=0.03
        )
        assert local[f"local_mean_gap{suffix}"].item() == pytest.approx(of_map["mean_gap"], rel=0.03)
        if suffix != "_lower":  # by Thomson
            series = 1 / (area * of_map["conductance_per_conductivity"]) + 1 / (2 * smooth["contact_radius"])
            conductance = local[f"local_conductance_per_conductivity{suffix}"].item()
            assert 1 / conductance == pytest.approx(series, rel=0.03)
    for name, value in local.items():
        if f"{name}_lower" in local and name.startswith("local_"):
            assert local[f"{name}_lower"].item() < value.item() < local[f"{name}_upper"].item()


@pytest.mark.parametrize(("setting", "changed"), [("contact_modulus", 1), ("mean_pressure", 0)])
def test_material_of_the_local_scale_is_the_difference_of_two_solves(setting, changed):
    options = {"level": MEAN, "form": LOCAL}
    bodies = {"uncertainty": {"sources": ["material"]}}
    contact = CONTACT | {"force": 40.0}
    local = rc.evaluate(ROUGH, **options, **bodies, contact=contact | {f"{setting}_uncertainty": 0.1})
    extremes = [
        rc.evaluate(
            ROUGH,
            **options,
            uncertainty={"sources": []},
            contact=contact | ({"contact_modulus": 115e9 * by} if changed else {"force": 40.0 * by}),
        )
        for by in (0.9, 1.1)
    ]
    for name in ("local_contact_area", "local_mean_gap"):
        extreme_values = sorted(result[name].item() for result in extremes)
        np.testing.assert_allclose(
            [local[f"{name}_{result}"].item() for result in ("lower", "upper")], extreme_values, rtol=1e-4
        )


@pytest.mark.parametrize("power", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("biot", [0.1, 1.0, 30.0])
def test_resistance_of_the_whole_contact_lies_between_rayleigh_and_thomson(power, biot):
    """The flux q through spots h = (1 - r²)^power and a disc of a half-space solves an integral equation.

    Rings have the potential (2/π) ∫ q(s) s/(r + s) K(4 r s/(r + s)²) ds per conductivity, here of two bodies.
    """
    edges = np.sin(np.linspace(0, np.pi / 2, 241))
    middle, (nodes, weights) = (edges[1:] + edges[:-1]) / 2, np.polynomial.legendre.leggauss(24)
    s = middle[:, None] + np.diff(edges)[:, None] / 2 * nodes
    r = middle[:, None, None]
    kernel = s / (r + s) * ellipk(np.clip(4 * r * s / (r + s) ** 2, 0, 1 - 1e-15))
    rings = 4 / np.pi * (kernel * weights).sum(axis=2) * np.diff(edges) / 2
    conductance = biot * (1 - middle**2) ** power
    flux = np.linalg.solve(rings + np.diag(1 / conductance), np.ones(middle.size))
    exact = 1 / (np.pi * np.diff(edges**2) @ flux)
    shares, _ = local_scale._nodes()
    smooth = {"area": np.array([np.pi]), "conductance": np.array([2.0])}
    spots = dict.fromkeys((AREA, GAP), shares) | {CONDUCTANCE: biot * shares ** (2 * power)}
    lower, upper = (
        1
        / local_scale._whole(spots, smooth, flux_as_pressure=by)["local_conductance_per_conductivity"].item()
        for by in (False, True)
    )
    assert lower < exact < upper
    assert lower == pytest.approx(exact, rel=0.11)


def test_window_depends_on_form_of_finite_bodies_alone():
    free = resolve({"contact": FREE, "form": {"radius": 5e-3}})[""]
    assert stage_settings(free, "window")["form"]["radius"] == [5e-3]
    periodic = resolve({"contact": {"contact_modulus": 1e9}})[""]
    assert "form" not in stage_settings(periodic, "window")


def test_what_is_solved_for_periodic_maps_refuses_finite_bodies():
    body = finite_body(ground(1e-7, (48, 48)), radius=[5e-3])
    contact = rc.solve_contact(body, hardness=1e9, **FREE | {"force": 0.1})
    for verb in (
        rc.unload,
        lambda solution: rc.partial_slip(solution, friction_coefficient=0.2, tangential_load=0.5),
    ):
        with pytest.raises(rc.SettingsError, match="body of finite size"):
            verb(contact)


@pytest.mark.parametrize("pitch", [5e-6, 5.7e-7, 6.7e-7])  # n d d and n (d d) differ in the last bit of some
def test_maps_of_a_finite_body_are_written_with_any_pitch(tmp_path, pitch):
    body = height_map(ground(1e-8, (64, 64)).values, pitch)
    contact = FREE | {"force": [2e-3, 1e-3]}
    chosen = {"contact": contact, "form": {"edges": True}, "uncertainty": {"sources": []}}
    chain = run_chain(body, resolve(chosen)[""], fields=tmp_path / "contact.nc")
    solution = read_dataset(tmp_path / "contact.nc")
    force = solution["pressure"].sum(("y", "x")) * pitch**2
    np.testing.assert_allclose(force, [2e-3, 1e-3], rtol=1e-9)
    np.testing.assert_array_equal(solution["mean_pressure"], chain.statistics["mean_pressure"])


@pytest.mark.parametrize(
    ("form", "red"),
    [({"radius": 5e-3}, "; red: the contact of the smooth bodies (Hertz)"), ({"edges": True}, "")],
)
def test_the_caption_of_a_map_says_what_is_outlined(tmp_path, form, red):
    chosen = {"contact": FREE | {"force": [2e-3]}, "form": form, "uncertainty": {"sources": []}}
    path = tmp_path / "contact.nc"
    chain = run_chain(ground(1e-8, (64, 64)), resolve(chosen)[""], fields=path)
    ((caption, *_),) = _fields(path, chain.window, chain.statistics, {0: 0})
    assert caption.partition("touch")[2] == red


def test_the_page_of_a_body_shows_force_and_radius_and_no_empty_interval():
    sources = {"uncertainty": {"sources": ["solver", "discretisation", "window"]}}
    contact = FREE | {"force": ["20 mN", "50 mN"]}
    answer = rc.evaluate(ground(1e-8, (64, 64)), contact=contact, form={"radius": "5 mm"}, **sources)
    # force, contact radius, approach and largest pressure come first; the mean pressure over the map is none
    rows = glance_rows(answer)
    assert [row[LOAD]._replace(outcome="") for row in rows] == [Cell("20.0 mN"), Cell("50.0 mN")]
    headings = headings_of(asked_columns([answer]), [answer])
    assert headings == ["force", "contact radius", "approach", "largest pressure"]
    approach = rows[1]["mutual_approach"]
    distance, _, unit = approach.text.partition(" ")
    assert float(distance) * 1e-9 == pytest.approx(answer["mutual_approach"][1].item(), rel=5e-3)
    assert (unit, approach.details[0], approach.precision) == ("nm", "−", "to ± 20 %")
    table = number_tables(answer, [[], []])[0]
    titles = [title for title, *_ in table["header"]]
    cells = dict(zip(titles, table["rows"][1]["cells"], strict=True))
    assert cells["force F"] == "0.0500"
    radius, below, above = cells["contact radius"].split()
    assert float(radius) == pytest.approx(1e6 * answer["contact_radius"][1].item(), rel=5e-3)
    ends = [1e6 * answer[f"contact_radius_{end}"][1].item() for end in ("lower", "upper")]
    assert [float(radius) - float(below[1:]), float(radius) + float(above)] == pytest.approx(ends, rel=0.01)
    # theories and flow are of half-spaces under a uniform pressure
    assert {row["sealing"] for row in glance_rows(answer)} == {Cell("not judged", "a body of finite size")}
    drawn = read_chart(area_against_load(answer, ground(1e-8, (64, 64))), log="xy")
    assert set(drawn.legend) == {"solved, corrected", "solved, pixels counted"}
    budget = shown_budget(answer, [0, 1])
    assert not any("– " in line for line in beyond_in_words(answer).values())
    assert not any("– " in cell for row in budget["intervals"]["rows"] for cell in row)
