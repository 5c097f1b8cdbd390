"""Contacts of layered bodies: what they share with half-spaces, the certificate, the approach, bad input."""

import numpy as np
import pytest
import xarray as xr
from known_surfaces import self_affine

from roughcontact import SettingsError, height_map, solve_contact
from roughcontact.arguments.maps import spacing
from roughcontact.contact.dataset import recorded_elasticity, recorded_medium
from roughcontact.contact.elasticity.energy import elastic_energy
from roughcontact.contact.elasticity.halfspace import HalfSpace
from roughcontact.contact.elasticity.influence import Elasticity
from roughcontact.contact.elasticity.media import elastic_medium
from roughcontact.contact.elasticity.medium import HALF_SPACES
from roughcontact.contact.response import linear_response
from roughcontact.surface.synthetic import rough_reference_surface

STEEL = {"youngs_modulus": 2.0, "poissons_ratio": 0.3}
RIGID = {"youngs_modulus": 1e20, "poissons_ratio": 0.3}


def layer(thickness: float, youngs_modulus: float, poissons_ratio: float = 0.3) -> dict[str, float]:
    return {"thickness": thickness, "youngs_modulus": youngs_modulus, "poissons_ratio": poissons_ratio}


RUBBER_SHEET = {"base": "rigid", "layers": [layer(0.05, 1.0, 0.5)]}
COATED = STEEL | {"layers": [layer(0.03, 5.0, 0.2)]}
PAINTED = STEEL | {"layers": [layer(0.04, 0.1, 0.4), layer(0.01, 0.3, 0.35)]}
BODIES = {"sheet": [RUBBER_SHEET], "coated": [COATED, STEEL], "painted": [PAINTED, COATED]}


@pytest.mark.parametrize("influence", ["sampled", "elements"])
def test_a_layer_like_its_base_is_the_half_space_bit_by_bit(influence):
    height = rough_reference_surface(64)
    like = STEEL | {"layers": [STEEL | {"thickness": 0.01}, STEEL | {"thickness": 0.2}]}
    with_layers, without_layers = (
        solve_contact(height, bodies=[body, STEEL], mean_pressure=[0.02, 0.3], influence=influence)
        for body in (like, STEEL)
    )
    xr.testing.assert_identical(with_layers, without_layers)
    assert recorded_medium(with_layers.attrs) is HALF_SPACES


def test_bodies_without_layers_are_their_contact_modulus():
    height = rough_reference_surface(64)
    by_bodies = solve_contact(height, bodies=[STEEL, STEEL], mean_pressure=0.1)
    by_modulus = solve_contact(height, contact_modulus=1 / 0.91, mean_pressure=0.1)
    xr.testing.assert_allclose(by_bodies, by_modulus, rtol=1e-9)


@pytest.mark.parametrize("bodies", list(BODIES.values()), ids=list(BODIES))
@pytest.mark.parametrize("influence", ["sampled", "elements"])
def test_the_solution_obeys_the_conditions_of_contact(bodies, influence):
    height = rough_reference_surface(64)
    contact = solve_contact(
        height, bodies=bodies, mean_pressure=0.05, tolerance=1e-8, influence=influence
    ).isel(load=0)
    layers = recorded_medium(contact.attrs)
    assert layers is not None
    halfspace = HalfSpace((64, 64), (1.0, 1.0), recorded_elasticity(contact))
    pressure = contact["pressure"].values
    displaced = halfspace.displacement(pressure) / layers.modulus
    gap = displaced - height.values
    gap -= gap[pressure > 0].mean()
    scale = float(np.ptp(height.values))
    np.testing.assert_allclose(gap, contact["gap"], atol=1e-8 * scale)
    assert np.abs(gap[pressure > 0]).max() < 1e-7 * scale
    assert gap.min() > -1e-7 * scale
    assert pressure.mean() == pytest.approx(0.05, rel=1e-12)


def random_problem(rng: np.random.Generator) -> tuple[xr.DataArray, list[dict], float]:
    """Return a small map, layered bodies and a load, all drawn at random."""
    shape = ((48, 48), (1, 128), (35, 60))[rng.integers(3)]
    steps = 10 ** rng.uniform(-0.5, 0.5, 2)
    y, x = (np.fft.fftfreq(n, d) for n, d in zip(shape, steps, strict=True))
    waves = np.hypot(y[:, None], x)
    roll_off = np.where(waves > 0, waves, np.inf) ** -rng.uniform(1.2, 2.2)
    height = np.fft.ifft2(np.fft.fft2(rng.normal(size=shape)) * roll_off).real
    window = height_map(height / height.std(), float(steps[1])).assign_coords(
        y=np.arange(shape[0]) * steps[0]
    )

    def material() -> dict[str, float]:
        return {"youngs_modulus": 10 ** rng.uniform(-1, 1), "poissons_ratio": rng.choice([0.0, 0.3, 0.5])}

    layers = [
        material() | {"thickness": float(10 ** rng.uniform(-0.5, 1.5))} for _ in range(rng.integers(1, 4))
    ]
    base = {"base": "rigid"} if rng.random() < 0.4 else material()
    return window, [base | {"layers": layers}, material()], float(10 ** rng.uniform(-2, 0))


@pytest.mark.parametrize("seed", range(8))
def test_the_bound_is_never_below_the_error(seed: int):
    window, bodies, load = random_problem(np.random.default_rng(seed))
    if 1 in window.shape:
        window = window.isel(y=[0])
    pair = elastic_medium(bodies)
    assert pair is not None
    gradient = solve_contact(window, bodies=bodies, mean_pressure=load * pair.modulus)
    unit = float(load * pair.modulus / gradient["relative_pressure"][0]) / load
    solutions = [
        solve_contact(window, bodies=bodies, mean_pressure=load * unit, tolerance=tolerance)
        for tolerance in (1e-2, 1e-10)
    ]
    coarse, exact = (solution["pressure"].values[0] for solution in solutions)
    steps = spacing(window)
    energy = [
        elastic_energy(field, steps, Elasticity(pair.modulus, medium=pair))
        for field in (coarse - exact, exact)
    ]
    error = np.sqrt(energy[0] / energy[1])
    assert error <= solutions[0]["error_bound"].item() * (1 + 1e-6)


@pytest.mark.parametrize("bodies", list(BODIES.values()), ids=list(BODIES))
def test_units_do_not_matter(bodies):
    height, length, stress = rough_reference_surface(48), 1e-5, 3e9

    def in_units(body):
        scaled = {key: value for key, value in body.items() if key != "layers"}
        if "youngs_modulus" in scaled:
            scaled["youngs_modulus"] *= stress
        layers = [
            film
            | {"thickness": film["thickness"] * length, "youngs_modulus": film["youngs_modulus"] * stress}
            for film in body.get("layers", [])
        ]
        return scaled | {"layers": layers}

    small = (height * length).assign_coords({axis: height[axis] * length for axis in "xy"})
    reference = solve_contact(height, bodies=bodies, mean_pressure=0.05, tolerance=1e-6)
    converted = solve_contact(
        small, bodies=[in_units(body) for body in bodies], mean_pressure=0.05 * stress, tolerance=1e-6
    )
    np.testing.assert_allclose(converted["pressure"] / stress, reference["pressure"], atol=1e-9)
    np.testing.assert_allclose(converted["approach"] / length, reference["approach"], rtol=1e-7)


def test_the_approach_of_a_sheet_on_a_rigid_base_is_absolute():
    flat = height_map(np.zeros((8, 8)), 1.0)
    sheet = {"base": "rigid", "layers": [layer(0.5, 2.0, 0.3), layer(0.25, 1.0, 0.45)]}
    contact = solve_contact(flat, bodies=[sheet], mean_pressure=0.1)
    sheets = ((0.5, 2.0, 0.3), (0.25, 1.0, 0.45))
    springs = sum(t * (1 + nu) * (1 - 2 * nu) / (e * (1 - nu)) for t, e, nu in sheets)
    assert contact["approach"].item() == pytest.approx(-0.1 * springs, rel=1e-12)


@pytest.mark.parametrize("influence", ["sampled", "elements"])
@pytest.mark.parametrize("bodies", [None, *BODIES.values()], ids=["half-space", *BODIES])
def test_the_stiffness_lies_between_the_differences_of_the_gap(bodies, influence):
    height = rough_reference_surface(64)
    elastic = {"contact_modulus": 1.0} if bodies is None else {"bodies": bodies}
    loads = np.array([0.02, 0.0202])
    contact = solve_contact(height, mean_pressure=loads, tolerance=1e-9, influence=influence, **elastic)
    touching = contact["pressure"].values > 0
    gaps = np.where(touching, 0.0, contact["gap"].values).mean((1, 2))
    pair = recorded_medium(contact.attrs)
    modulus = float(contact["contact_modulus"])
    stiffness = [
        1 / linear_response(contact_set, spacing(height), Elasticity(modulus, influence, pair), 1e-5)[0]
        for contact_set in touching
    ]
    between = np.diff(loads)[0] / -np.diff(gaps)[0]
    assert stiffness[0] * (1 - 1e-6) <= between <= stiffness[1] * (1 + 1e-6)


@pytest.mark.parametrize(
    ("body", "key", "words"),
    [
        ({"base": "rigid"}, "bodies[0].base", "youngs_modulus 1e20"),
        ({"base": "steel", "layers": [layer(1, 1)]}, "bodies[0].base", "must be 'rigid'"),
        ({"base": layer(1, 1)}, "bodies[0].base", "an elastic base is the body itself"),
        (STEEL | {"base": "rigid", "layers": [layer(1, 1)]}, "bodies[0]", "give one of them"),
        ({"layers": [layer(1, 1)]}, "bodies[0].youngs_modulus", "base: rigid"),
        (STEEL | {"layers": [layer(0, 1)]}, "bodies[0].layers[0].thickness", "must be a positive"),
        (STEEL | {"layers": [layer(-1, 1)]}, "bodies[0].layers[0].thickness = -1", "must be a positive"),
        (STEEL | {"layers": [layer(1, 1, 0.6)]}, "layers[0].poissons_ratio = 0.6", "at most 0.5"),
        (STEEL | {"layers": [layer(1, 1, -1)]}, "layers[0].poissons_ratio = -1", "above -1"),
        (STEEL | {"layers": [STEEL]}, "layers[0].thickness", "missing"),
        (STEEL | {"layers": layer(1, 1)}, "bodies[0].layers", "list of layers"),
    ],
)
def test_bad_bodies_get_one_sentence(body, key, words):
    with pytest.raises(SettingsError) as caught:
        solve_contact(rough_reference_surface(64), bodies=[body, STEEL], mean_pressure=0.1)
    message = str(caught.value)
    assert key in message
    assert words in message
    assert "\n" not in message


def test_bodies_and_modulus_must_agree():
    height = rough_reference_surface(64)
    with pytest.raises(SettingsError, match="give one of them"):
        solve_contact(height, contact_modulus=5.0, bodies=[STEEL, STEEL], mean_pressure=0.1)
    with pytest.raises(SettingsError, match="neither contact_modulus nor bodies"):
        solve_contact(height, mean_pressure=0.1)
    with pytest.raises(SettingsError, match="list of two bodies"):
        solve_contact(height, bodies=[STEEL] * 3, mean_pressure=0.1)
    agreed = solve_contact(height, contact_modulus=1 / 0.91, bodies=[STEEL, STEEL], mean_pressure=0.1)
    assert agreed["contact_modulus"] == pytest.approx(1 / 0.91)


@pytest.mark.parametrize("pixels", [4, 32])
@pytest.mark.parametrize("ratio", [0.1, 0.5, 2.0, 5.0])
def test_a_layer_takes_at_most_half_as_many_transforms_more_than_a_half_space(ratio, pixels):
    height = self_affine((256, 256), 1 / 256, (6 / 256, 0.25), rms_gradient=1.0, seed=1)
    film = STEEL | {"layers": [layer(pixels / 256, STEEL["youngs_modulus"] * ratio)]}
    pairs = []
    for body in (STEEL, film):
        modulus = (STEEL if body is STEEL else film["layers"][0])["youngs_modulus"] / 0.91
        loads = [modulus * load for load in (0.003, 0.03, 0.3)]
        contact = solve_contact(height, bodies=[body, RIGID], mean_pressure=loads)
        pairs.append(contact["operator_applications"].values)
    assert (pairs[1] <= 1.5 * pairs[0]).all()


@pytest.mark.parametrize("pixels", [4, 32])
def test_stiff_films_and_rigid_bases_stay_within_bounds(pixels):
    height = self_affine((256, 256), 1 / 256, (6 / 256, 0.25), rms_gradient=1.0, seed=1)
    sheet = {"base": "rigid", "layers": [layer(pixels / 256, 2.0)]}
    film = STEEL | {"layers": [layer(pixels / 256, 40.0)]}
    for body, max_applications in ((sheet, 16), (film, 40)):
        modulus = body["layers"][0]["youngs_modulus"] / 0.91
        loads = [modulus * load for load in (0.003, 0.03, 0.3)]
        contact = solve_contact(height, bodies=[body, RIGID], mean_pressure=loads)
        assert contact["operator_applications"].max() <= max_applications


@pytest.mark.parametrize(("ratio", "hardness"), [(60, 6.0), (150, 1.8), (500, 3.0)])
def test_a_stiff_film_that_yields_takes_tens_of_transforms(ratio, hardness):
    height = self_affine((128, 128), 1 / 128, (6 / 128, 0.25), rms_gradient=1.0, seed=1)
    body = {"youngs_modulus": 0.91 / ratio, "poissons_ratio": 0.3, "layers": [layer(4 / 128, 0.91)]}
    contact = solve_contact(height, bodies=[body, RIGID], mean_pressure=0.03, hardness=0.03 * hardness)
    assert contact["yielded_area"] > 0
    assert contact["error_bound"] <= 1e-4
    assert contact["operator_applications"] <= 75
