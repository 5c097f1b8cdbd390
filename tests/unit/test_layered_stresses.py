"""Stresses and conduction in bodies with layers: against Navier's and Laplace's equations solved otherwise,
limits of plates and of thin sheets, and what the statistics make of them."""

import json

import navier
import numpy as np
import pytest
from scipy import sparse
from scipy.linalg import expm
from scipy.sparse.linalg import spsolve

import roughcontact as rc
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.variables import describe
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.layers import (
    Layer,
    Material,
    Stack,
    body_stack,
    conducting_pair,
    stress_amplitudes,
)
from roughcontact.contact.elasticity.subsurface import subsurface_stress, tresca, von_mises
from roughcontact.contact.response import linear_response
from roughcontact.report.facts import _first_yield
from roughcontact.report.tables import number_tables
from roughcontact.statistics.subsurface import add_subsurface_yield, profile_depths, stress_columns
from roughcontact.statistics.targets import target_loads
from roughcontact.surface.synthetic import rough_reference_surface
from validation.layered_wave import layered_wave_stresses

STEEL = {"youngs_modulus": 2.0, "poissons_ratio": 0.3, "yield_stress": 0.2}
PLAIN = {"youngs_modulus": 2.0, "poissons_ratio": 0.3}
FILM = {"thickness": 0.02, "youngs_modulus": 6.0, "poissons_ratio": 0.2, "yield_stress": 0.9}
BOND = {"thickness": 0.01, "youngs_modulus": 1.0, "poissons_ratio": 0.35}
COATED = STEEL | {"layers": [FILM, BOND]}
SHEET = {"base": "rigid", "layers": [BOND | {"poissons_ratio": 0.5, "yield_stress": 0.3}]}
PRESSURE = np.random.default_rng(3).random((24, 32))
STEPS = (1 / 24, 1 / 32)


@pytest.mark.parametrize("seed", range(20))
def test_the_stresses_in_any_stack_are_the_solution_of_naviers_equations(seed: int):
    rng = np.random.default_rng(seed)
    layers = navier.random_layers(rng, 1, 3)
    base = None if seed % 3 == 0 else (float(10 ** rng.uniform(-2, 2)), float(rng.choice([0.0, 0.3, 0.5])))
    body = Stack(tuple(Layer(t, Material(e, nu)) for t, e, nu in layers), base and Material(*base))
    q = 10 ** rng.uniform(-3, 1.5, 3)
    stresses = stress_amplitudes(q, body)
    for number, (thickness, modulus, ratio) in enumerate(layers):
        part = float(rng.uniform())
        cut = (thickness * part, modulus, ratio), (thickness * (1 - part), modulus, ratio)
        cut_in_two = [*layers[:number], *cut, *layers[number + 1 :]]
        for column, wavenumber in zip(stresses(number, thickness * part).T, q, strict=True):
            stretch, _, shear, normal = navier.states(float(wavenumber), cut_in_two, base)[number + 1]
            along = ratio / (1 - ratio) * normal + modulus / (1 - ratio**2) * stretch
            reference = wavenumber * np.array([normal, shear, along])
            np.testing.assert_allclose(column, reference, atol=1e-10 * np.abs(reference).max())


@pytest.mark.parametrize("base", [(1.0, 0.3), None])
def test_airys_function_is_the_solution_of_naviers_equations(base):
    layers = [(0.4, 10.0, 0.2), (1.1, 0.3, 0.5)]
    thickness, modulus, ratio = layers[1]
    cut = [layers[0], (0.5, modulus, ratio), (thickness - 0.5, modulus, ratio)]
    for depth, index in ((0.4, 1), (0.9, 2)):
        stretch, _, shear, normal = navier.states(1.0, cut, base)[index]
        _, modulus, ratio = layers[index - 1]
        reference = [normal, shear, ratio / (1 - ratio) * normal + modulus / (1 - ratio**2) * stretch]
        np.testing.assert_allclose(layered_wave_stresses([depth], layers, base)[:, 0], reference, rtol=1e-12)


def test_the_edge_of_a_strip_on_a_film_by_finite_differences():
    """Laplace's equation in a film, grounded below, with the electrode on the right half of its face."""
    currents = []
    for across in (32, 64):
        along = 8 * across
        down, across_film = (
            2 * sparse.eye(n) - sparse.eye(n, k=1) - sparse.eye(n, k=-1) for n in (across, along)
        )
        matrix = sparse.lil_matrix(
            sparse.kron(down, sparse.eye(along)) + sparse.kron(sparse.eye(across), across_film)
        )
        cells = np.arange(across * along).reshape(across, along)
        electrode = np.arange(along) >= along // 2
        diagonal = matrix.diagonal().reshape(across, along)
        diagonal[:, [0, -1]] -= 1  # insulated ends
        # half a cell to the grounded face and to the electrode, nothing to the insulation
        diagonal[-1] += 1
        diagonal[0] += np.where(electrode, 1, -1)
        matrix.setdiag(diagonal.ravel())
        source = np.append(2.0 * electrode, np.zeros((across - 1) * along))
        field = spsolve(matrix.tocsc(), source)
        currents.append(2 * field[cells[-1]].sum())
    coarse, fine = currents
    assert 2 * fine - coarse - 4 == pytest.approx(2 * np.log(2) / np.pi, rel=3e-3)


def test_layers_like_their_base_have_the_stresses_of_the_half_space():
    material = {"youngs_modulus": 2.0, "poissons_ratio": 0.3}
    body = body_stack(material | {"layers": [material | {"thickness": 0.04}, material | {"thickness": 0.3}]})
    layered = subsurface_stress(PRESSURE, STEPS, body=body)
    half_space = subsurface_stress(PRESSURE, STEPS, poissons_ratio=0.3)
    for number, face in enumerate((0.0, 0.04, 0.34)):
        for depth in (0.0, 0.01, 0.04, 3.0)[: 3 + (number == 2)]:
            np.testing.assert_allclose(layered(depth, number), half_space(face + depth), atol=1e-13)


@pytest.mark.parametrize("body", [COATED, SHEET, PLAIN | {"layers": [FILM | {"youngs_modulus": 2e3}]}])
def test_tractions_and_displacements_do_not_jump_at_interfaces(body):
    stack = body_stack(body)
    stress_at = subsurface_stress(PRESSURE, STEPS, body=stack)
    for number, (layer, below) in enumerate(zip(stack.layers, stack.materials[1:], strict=False)):
        sides = stress_at(layer.thickness, number), stress_at(0.0, number + 1)
        np.testing.assert_allclose(sides[0][2:5], sides[1][2:5], atol=1e-12)
        # the displacements within the interface by their strains, Hooke's law
        strains = []
        for (xx, yy, zz, _, _, xy), (modulus, ratio) in zip(sides, (layer.material, below), strict=True):
            strains.append(
                np.array([xx - ratio * (yy + zz), yy - ratio * (xx + zz), (1 + ratio) * xy]) / modulus
            )
        np.testing.assert_allclose(*strains, atol=1e-11)


def test_equilibrium_within_a_layer():
    """Differences along x, y (spectral) and z of a random pressure's stresses add up to no force."""
    stress_at = subsurface_stress(PRESSURE, STEPS, body=body_stack(COATED))
    step, depth = 1e-4, 0.012
    above, in_between, below = (stress_at(depth + shift) for shift in (-step, 0.0, step))
    across = (below - above) / (2 * step)
    waves = [2j * np.pi * np.fft.fftfreq(n, d) for n, d in zip(PRESSURE.shape, STEPS, strict=True)]
    # not at the Nyquist limits, where a wave has no derivative
    waves[0][12] = waves[1][16] = np.nan
    along_y, along_x = (np.fft.fft2(in_between) * wave for wave in (waves[0][:, None], waves[1][None, :]))
    down = np.fft.fft2(across)
    (xx, _, _, _, xz_x, xy_x), (_, yy, _, yz_y, _, xy_y) = along_x, along_y
    for force in (xx + xy_y + down[4], xy_x + yy + down[3], xz_x + yz_y + down[2]):
        inside = np.isfinite(force)
        assert np.abs(force[inside]).max() < 2e-3 * np.nanmax(np.abs(along_x))


def test_a_stiff_film_bends_as_a_plate():
    """Biot (1937): w = p/(D q^4 + E2* q/2); the stress at the faces of the plate is E1* q^2 w t/2."""
    q, film, soft = 0.01, Material(1e6, 0.3), Material(1.0, 0.5)
    stress = stress_amplitudes(np.array([q]), Stack((Layer(1.0, film),), soft))
    deflection = 1 / (film.plane_modulus * q**4 / 12 + soft.plane_modulus * q / 2)
    bending = film.plane_modulus * q**2 * deflection / 2
    assert stress(0, 0.0)[2, 0] == pytest.approx(-bending, rel=0.01)
    assert stress(0, 1.0)[2, 0] == pytest.approx(bending, rel=0.01)


def test_a_thin_incompressible_sheet_flows_along_its_base():
    """A long wave squeezes it as a viscous film: the shear grows from the free face to q t p at the base."""
    q = 1e-4
    shear = [
        stress_amplitudes(np.array([q]), Stack((Layer(1.0, Material(3.0, 0.5)),), None))(0, z)[1, 0]
        for z in (0.0, 0.5, 1.0)
    ]
    np.testing.assert_allclose(shear, [0.0, -q / 2, -q], rtol=1e-6, atol=1e-12)


def test_many_waves_are_interpolated_without_loss():
    q = np.geomspace(0.3, 3e3, 20000)
    stack = body_stack(COATED)
    at_all_waves, at_few_waves = stress_amplitudes(q, stack), stress_amplitudes(q[::100], stack)
    for number, depth in ((0, 0.0), (0, 0.02), (1, 0.004), (2, 0.1)):
        np.testing.assert_allclose(
            at_all_waves(number, depth)[:, ::100], at_few_waves(number, depth), atol=1e-10
        )


@pytest.mark.parametrize("body", [COATED | {"yield_stress": 0.4}, SHEET], ids=["coated", "sheet"])
def test_the_largest_stresses_of_materials_and_interfaces(body):
    """Against hundreds of depths in each material; the volume by their sum."""
    columns = stress_columns(PRESSURE, STEPS, **body)
    stack = body_stack(body)
    stress_at = subsurface_stress(PRESSURE, STEPS, body=stack)
    limits = [layer.get("yield_stress", np.inf) for layer in body["layers"]]
    limits += [body["yield_stress"]] if stack.base else []
    volume, face = 0.0, 0.0
    for number, limit in enumerate(limits):
        last = number == len(stack.layers)
        thickness = 2 - face if last else stack.layers[number].thickness
        depths = thickness * np.linspace(0, 1, 801) ** (3 if last else 1)
        stresses = [stress_at(depth, number) for depth in depths]
        equivalent = np.array([von_mises(stress) for stress in stresses])
        largest = equivalent.max(axis=(1, 2))
        assert columns["material_von_mises_stress"][number] == pytest.approx(largest.max(), rel=1e-3)
        depth = columns["material_von_mises_depth"][number] - face
        assert von_mises(stress_at(depth, number)).max() == pytest.approx(largest.max(), rel=1e-3)
        volume += np.trapezoid((equivalent > limit).mean(axis=(1, 2)), depths)
        if not last:
            shear = np.hypot(stresses[-1][3], stresses[-1][4]).max()
            assert columns["interface_shear_stress"][number] == pytest.approx(shear, rel=1e-12)
            assert columns["interface_normal_stress"][number] == pytest.approx(
                stresses[-1][2].max(), rel=1e-12
            )
        face += thickness
    assert volume > 0
    assert columns["volume_above_yield"] == pytest.approx(volume, rel=0.01)
    assert columns["von_mises_profile"].shape == profile_depths(PRESSURE.shape, STEPS, body).shape
    assert columns["max_von_mises_stress"] == max(columns["material_von_mises_stress"])


def test_a_hardened_case_yields_where_it_ends():
    """A layer that differs from its base by its yield stress alone: the contact is that of half-spaces."""
    case = PLAIN | {"thickness": 0.05, "yield_stress": 4.0}
    body = STEEL | {"layers": [case]}
    height = rough_reference_surface(64)
    contact = rc.solve_contact(height, bodies=[body, PLAIN], mean_pressure=0.1)
    statistics = rc.contact_statistics(contact, bodies=[body, PLAIN], flow="never")
    plain = rc.contact_statistics(contact, bodies=[STEEL, PLAIN], flow="never")
    np.testing.assert_allclose(statistics["max_von_mises_stress"], plain["max_von_mises_stress"], rtol=1e-3)
    below = np.interp(0.05, plain["depth"], plain["von_mises_profile"][0])
    assert statistics["material_von_mises_stress"][0, 1] == pytest.approx(below, rel=0.02)
    assert statistics["conductance_per_conductivity"].item() > 0


@pytest.fixture(scope="module")
def judged():
    """Return statistics of a coated body at loads of which some are without yield."""
    height, bodies = rough_reference_surface(64), [PLAIN, COATED]
    contact = rc.solve_contact(height, bodies=bodies, mean_pressure=[0.001, 0.0025, 0.003, 0.2])
    statistics = rc.contact_statistics(contact, bodies=bodies, flow="never")
    return height, bodies, describe(add_subsurface_yield(statistics, bodies))


def test_first_yield_is_that_of_the_first_material(judged):
    height, bodies, statistics = judged
    pressures = statistics["material_first_yield_pressure"].values
    lowest = statistics["first_subsurface_yield_pressure"].item()
    assert np.isnan(pressures[1])  # its yield stress is not known
    assert lowest == np.nanmin(pressures)
    (searched,) = target_loads(
        height, contact_modulus=float(statistics["contact_modulus"]), target="first_yield", bodies=bodies
    )
    assert searched == pytest.approx(lowest, rel=0.01)
    at = rc.solve_contact(height, bodies=bodies, mean_pressure=searched)
    at_yield = rc.contact_statistics(at, bodies=bodies, flow="never")["material_von_mises_stress"].values[0]
    assert max(at_yield[0] / 0.9, at_yield[2] / 0.2) == pytest.approx(1, rel=0.02)


def test_the_report_names_materials_and_interfaces(judged):
    _, _, statistics = judged
    (table,) = [
        candidate
        for candidate in number_tables(statistics, [[]] * 4)
        if candidate["title"].startswith("Stress")
    ]
    assert table["title"] == "Stress below the surface: body 2, of the lowest yield stress stated"
    titles = [title for title, _, _ in table["header"]]
    assert titles[3:6] == ["von Mises in layer 1", "von Mises in layer 2", "von Mises in the base"]
    assert titles[6:] == [f"{kind} below layer {n}" for kind in ("shear", "normal stress") for n in (1, 2)]
    where = "layer 1" if np.nanargmin(statistics["material_first_yield_pressure"]) == 0 else "the base"
    assert f", in {where}" in _first_yield(statistics, "first_subsurface_yield_pressure")


def test_stresses_of_layers_where_nobody_asks():
    height = rough_reference_surface(48)
    bodies = [PLAIN | {"layers": [BOND]}, PLAIN]
    contact = rc.solve_contact(height, bodies=bodies, mean_pressure=0.1)
    assert "max_von_mises_stress" not in rc.contact_statistics(contact, bodies=bodies)
    statistics = rc.contact_statistics(contact, bodies=bodies, stress="always")
    assert "volume_above_yield" not in statistics
    assert statistics["interface_shear_stress"].shape == (1, 1)


def direct(q: float, layers: list[tuple[float, float]], base: float) -> float:
    """Return temperature over flux of the surface of a stack, by exponentials of Laplace's equation."""
    temperature, flux = 1 / (base * q), 1.0
    for thickness, k in reversed(layers):
        # d/dz (T, j) = -(j/k, k q^2 T), integrated from the lower to the upper face
        temperature, flux = expm(thickness * np.array([[0, 1 / k], [k * q * q, 0]])) @ (temperature, flux)
    return temperature / flux


def test_waves_of_heat_through_layers():
    layers = [(0.3, 2.0), (0.1, 0.05)]
    body = {
        "thermal_conductivity": 7.0,
        "layers": [{"thickness": t, "thermal_conductivity": k} for t, k in layers],
    }
    pair = conducting_pair([body, {"thermal_conductivity": 3.0}], "thermal_conductivity")
    q = np.geomspace(1e-3, 30, 20)
    reference = [direct(wavenumber, layers, 7.0) + 1 / (3.0 * wavenumber) for wavenumber in q]
    np.testing.assert_allclose(2 * pair.factor(q) / (pair.modulus * q), reference, rtol=1e-10)


def test_heat_through_layers_flows_through_touching_points_only():
    """By the dense system of the contact points, as for half-spaces."""
    bodies = [
        PLAIN | {"thermal_conductivity": 7.0, "electrical_resistivity": 1 / 7, "layers": [FILM]},
        PLAIN | {"thermal_conductivity": 3.0, "electrical_resistivity": 1 / 3},
    ]
    bodies[0]["layers"] = [FILM | {"thermal_conductivity": 0.5, "electrical_resistivity": 2.0}]
    height = rough_reference_surface(64).coarsen(x=2, y=2).mean()
    contact = rc.solve_contact(height, bodies=bodies, mean_pressure=0.1, tolerance=1e-8)
    statistics = rc.contact_statistics(contact, bodies=bodies, flow="never", stress="never")
    touching = contact["pressure"].values[0] > 0
    q = 2 * np.pi * np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(32, 1 / 32)], indexing="ij"))
    q[0, 0] = np.inf
    lengths, indices = np.unique(q, return_inverse=True)
    waves = [
        0.0 if wavenumber == np.inf else direct(wavenumber, [(0.02, 0.5)], 7.0) + 1 / (3 * wavenumber)
        for wavenumber in lengths
    ]
    kernel = np.fft.ifft2(np.array(waves)[indices].reshape(q.shape)).real
    indices = np.argwhere(touching)
    offsets = indices[:, None] - indices[None, :]
    matrix = kernel[offsets[..., 0] % 32, offsets[..., 1] % 32]
    bordered = np.block(
        [[matrix, np.ones((len(indices), 1))], [np.ones((1, len(indices))), np.zeros((1, 1))]]
    )
    drop = -np.linalg.solve(bordered, np.append(np.zeros(len(indices)), touching.size))[-1]
    for name in ("thermal_conductance", "electrical_conductance"):
        assert statistics[name].item() == pytest.approx(1 / drop, rel=2e-4)
    assert np.isnan(statistics["conductance_per_conductivity"]).all()


def test_a_layer_that_conducts_like_its_base_changes_nothing():
    touching = rough_reference_surface(64).values > 0.01
    steel = {"thermal_conductivity": 50.0}
    body = steel | {"layers": [steel | {"thickness": 0.1}]}
    pair = conducting_pair([body, {"thermal_conductivity": 400.0}], "thermal_conductivity")
    response, _ = linear_response(touching, (1 / 64, 1 / 64), Elasticity(pair.modulus, medium=pair))
    reference, _ = linear_response(touching, (1 / 64, 1 / 64), Elasticity(2 * 50 * 400 / 450))
    assert response == pytest.approx(reference, rel=1e-6)


def test_settings_ask_for_the_properties_of_all_materials_or_none():
    film = {"thickness": 1e-6, "youngs_modulus": 1.8e11, "poissons_ratio": 0.2, "yield_stress": 4e9}
    steel = {"youngs_modulus": 2.1e11, "poissons_ratio": 0.3, "thermal_conductivity": 50.0}
    with pytest.raises(rc.SettingsError) as caught:
        resolve({"contact": {"bodies": [steel | {"layers": [film]}, steel]}})
    assert (
        "contact.bodies[0].layers[0].thermal_conductivity: missing, though another material has it; "
        "give it for all or none" in str(caught.value)
    )
    plain = {key: value for key, value in steel.items() if key != "thermal_conductivity"}
    (settings,) = resolve(
        {"contact": {"bodies": [plain | {"layers": [film]}, plain], "target": "first_yield"}}
    ).values()
    assert settings["contact"]["bodies"][0]["layers"][0]["yield_stress"] == 4e9
    assert json.dumps(settings)


def test_principal_stresses_of_a_layer_are_those_of_its_tensor():
    columns = stress_columns(PRESSURE, STEPS, **COATED)
    stress_at = subsurface_stress(PRESSURE, STEPS, body=body_stack(COATED))
    largest = max(
        tresca(stress_at(depth, number)).max()
        for number, thickness in enumerate((0.02, 0.01))
        for depth in np.linspace(0, thickness, 200)
    )
    assert columns["max_tresca_stress"] == pytest.approx(largest, rel=1e-3)
