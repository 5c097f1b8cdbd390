"""How every number transforms, with scales and with the map, and what names say as integrals and differences.

The table of the laws has an entry for every output variable that a solved surface can have, so that a new
variable without a law fails. Each law is physics, not the program's: p ~ E* h / L.
"""

import re
from typing import NamedTuple

import numpy as np
import pytest
from case_tables import cases_of
from hypothesis import Phase, assume, example, given
from hypothesis import settings as examples
from hypothesis import strategies as st
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact import error_budget, height_map, with_uncertainty
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.variables import VARIABLES
from roughcontact.statistics.contact_statistics import statistics_function
from roughcontact.statistics.decisions import TIGHT
from roughcontact.statistics.subsurface import add_subsurface_yield
from roughcontact.statistics.targets import add_first_yield
from roughcontact.surface.roughness.bearing import BEARING_PARAMETERS
from roughcontact.surface.roughness.parameters import roughness_parameters
from roughcontact.surface.window.periodisation import is_periodic


class Law(NamedTuple):
    """Exponents of heights, lengths and modulus; `similar`: only while slopes stay, as it depends on them."""

    heights: float
    lengths: float
    modulus: float
    similar: bool = False
    repeated: float = 1.0  # by what it is multiplied where the map is laid beside itself, twice each way


LAWS = {name: Law(*law) for *law, names in cases_of("test_laws", "laws")[1] for name in names.split()}
LAWS |= {name: Law(0, 0, 0) for name in VARIABLES if name.endswith("_known")}
# what the solver says of its own work: no property of the surface
OF_THE_SOLVER = {"iterations", "operator_applications", "error_bound", "rounding_floor", "load_error"}
OF_THE_SOLVER |= {"max_penetration", "conductance_error_bound"}
NO_NUMBER = {name for (names,) in cases_of("test_laws", "NO_NUMBER")[1] for name in names.split()}
NO_NUMBER |= {name for name in VARIABLES if "friction_" in name}
# what a user allows, totals of an area or perimeter of his, and the materials'
NO_NUMBER |= {name for name in VARIABLES if name.startswith(("allowed_", "total_"))}
NO_NUMBER |= {name for name in VARIABLES if re.search("_(holds(_from)?|largest_Sq)$", name)}
NO_NUMBER |= {name for name in VARIABLES if "_after" in name}  # of bodies that creep
NO_NUMBER |= {name for name in VARIABLES if name.startswith("local_")}
NO_NUMBER |= {f"greenwood_tripp_{name}" for name in ("contact_area", "loaded_radius", "max_pressure")}
NO_NUMBER |= {f"rms_{name}_before_load" for name in ("height", "gradient", "curvature")}
NO_NUMBER |= {f"{kind}_flow_factor_{axis}" for kind in ("pressure", "shear") for axis in "xy"}
NO_NUMBER |= {
    name for name in VARIABLES if name.startswith("other_") or name.endswith(("_difference", "verdict"))
}
ENDINGS = (
    # of an interval or a magnification curve, of the same kind as its number
    r"_(uncertainty|((map|next|joint|octave|next_part|alone)_)?(lower|upper)|joint|alone|of_maps|parts|half_way|as_solved|estimate|at_cutoff"
    r"|components|shared|as_measured)$"
)

BODIES = (
    {"youngs_modulus": 3e9, "poissons_ratio": 0.3, "yield_stress": 4e7, "thermal_conductivity": 2.0}
    | {"electrical_resistivity": 1e-6},
    {"youngs_modulus": 5e9, "poissons_ratio": 0.4, "yield_stress": 9e7, "thermal_conductivity": 4.0}
    | {"electrical_resistivity": 2e-6},
)
# numbers that are found to a share of themselves, by what is documented of them
SHARES = {name: share for share, names in cases_of("test_laws", "SHARES")[1] for name in names.split()}
HISTOGRAMS = ("gap_density", "pressure_density")
MODULUS = 1 / sum((1 - body["poissons_ratio"] ** 2) / body["youngs_modulus"] for body in BODIES)
HARDNESS = 1.2e8  # Pa, which the largest pressure of the higher loads reaches
SEAL = {"viscosity": 1e-3, "pressure_difference": 1.0, "width": 2e-3}  # a fluid that lifts nothing


def kind_of(name):
    """Return the name of the number that a variable is about."""
    # on the scale of a group: a logarithm
    if name.endswith(("_sensitivity", "_between", "_within")):
        return "sensitivity"
    return re.sub(ENDINGS, "", name)


def law_of(name):
    return LAWS[kind_of(name)]


def made(seed, shape=(36, 48), pitch=(1.5e-6, 1e-6), lay=0.4):
    """Return a rough periodic map with an oblique lay: nothing about it is symmetric."""
    rough = self_affine(shape, pitch, (6e-6, 40e-6), hurst=0.7, rms_gradient=0.05, seed=seed).values
    y, x = np.indices(shape)
    waves = np.cos(2 * np.pi * (2 * x / shape[1] - y / shape[0]) + 0.5)
    heights = rough + lay * rough.std() * waves + 0.2 * rough.std() * waves**2
    return height_map(heights - heights.mean(), pitch)


def solved(window, *, scale=1.0, yields=1.0, energy=1.0, hardness=None, budget=False):
    """Return every number of a periodic map at three loads; `yields`, `energy` scale what materials bear."""
    scales = {"youngs_modulus": scale, "yield_stress": yields}
    bodies = [body | {key: body[key] * by for key, by in scales.items()} for body in BODIES]
    levelled = rc.level(window, form="mean", outlier_threshold=None, line_alignment="none")
    window = rc.periodic_window(levelled)
    gradient = roughness_parameters(window)["rms_gradient"]
    contact = {
        "contact_modulus": MODULUS * scale,
        "mean_pressure": [share * MODULUS * scale * gradient for share in (0.02, 0.1, 0.3)],
        "tolerance": 1e-9,
    }
    if hardness is not None:
        contact["hardness"] = hardness
    count = statistics_function(
        window,
        contact_modulus=contact["contact_modulus"],
        bodies=bodies,
        flow="always",
        stress="always",
        seal=SEAL,
        work_of_adhesion=0.05 * energy,
    )
    result = add_first_yield(rc.solve_contact(window, **contact, reduce=count), window, contact)
    if budget:
        verbs = {"level": {"form": "mean", "outlier_threshold": None, "line_alignment": "none"}, "window": {}}
        verbs["contact"] = contact | {"contact_modulus_uncertainty": 0.05}
        result = with_uncertainty(result, error_budget(levelled, window, verbs, windows=4))
    return add_subsurface_yield(result, bodies)


def same(actual, expected, name, points=np.inf, core=0.0, outside=np.inf):
    """Whether two numbers are one, up to the tolerance of the solution and to rounding.

    Parameters of the curve through the heights of so many points are so beside the height of its `core`, and
    those of what lies `outside` of it, a share of the points, to one of these points.
    """
    actual, expected = np.asarray(actual, float), np.asarray(expected, float)
    # of the curve through the sorted heights few are peaks
    rtol = (
        points**-0.5 + 1 / (points * outside) + 1e-9 if name in BEARING_PARAMETERS else SHARES.get(name, 2e-5)
    )
    assert actual.shape == expected.shape, name
    scale = np.abs(expected[np.isfinite(expected)]).max(initial=0.0)
    if name in BEARING_PARAMETERS and np.isfinite(points):
        scale = max(scale, 1.0 if name.startswith("Smr") else core)
    np.testing.assert_allclose(actual, expected, rtol=rtol, atol=rtol * scale + 1e-300, err_msg=name)


def same_histogram(actual, expected, name):
    """Whether two results have the same histogram, but for a point at the edge of a class, by rounding."""
    shares = []
    for result in (actual, expected):
        widths = np.diff(result[name.replace("density", "bin_bounds")].values)[..., 0]
        shares.append(result[name].values * widths)
    one_point = np.where(shares[1] > 0, shares[1], np.inf).min(axis=-1, keepdims=True)
    moved = np.abs(np.cumsum(shares[0] - shares[1], axis=-1))
    assert (moved <= 1.01 * one_point).all(), name


def test_every_variable_has_a_law():
    named = {kind_of(name) for name in VARIABLES}
    assert named - set(LAWS) - OF_THE_SOLVER - NO_NUMBER == set()
    assert set(LAWS) <= named  # and no law is left over


def numbers(dataset):
    """Return the names that a law can say something of."""
    return [str(name) for name in dataset.variables if name not in OF_THE_SOLVER | NO_NUMBER]


def without_tight(name, scaled_result, reference, factor):
    """Return a number over its factor, and that of the reference; leaks of nothing have no scale."""
    scaled, expected = (result[name].values for result in (scaled_result, reference))
    if name.startswith("leak_rate"):
        is_tight = (scaled == TIGHT) | (expected == TIGHT)
        scaled, expected = (np.where(is_tight, np.nan, values) for values in (scaled, expected))
    return scaled / factor, expected


@examples(max_examples=4, deadline=None, phases=[Phase.generate])
@given(
    seed=st.integers(0, 10**6),
    heights=st.floats(-2, 2),
    lengths=st.floats(-3, 3),
    modulus=st.floats(-3, 3),
    yielding=st.booleans(),
    budget=st.booleans(),
)
def test_numbers_follow_the_scales(seed, heights, lengths, modulus, yielding, budget):
    # with powers of two even the rounding is the same, on which members of an ensemble depend by whole pixels
    base = 2.0 if budget else 10.0
    a, b, c = (base ** (round(power) if budget else power) for power in (heights, lengths, modulus))
    window = made(seed)
    limit = HARDNESS if yielding else None
    reference = solved(window, hardness=limit, budget=budget)
    scaled = height_map(a * window.values, tuple(b * step for step in spacing(window)))
    pressure = c * a / b
    scaled_result = solved(
        scaled,
        scale=c,
        yields=pressure,
        energy=pressure * a,
        hardness=limit and limit * pressure,
        budget=budget,
    )
    assert set(scaled_result.variables) == set(reference.variables)
    for name in numbers(reference):
        law = law_of(name)
        if name in HISTOGRAMS:
            same_histogram(scaled_result, reference, name)
        elif not law.similar:
            factor = a**law.heights * b**law.lengths * c**law.modulus
            same(*without_tight(name, scaled_result, reference, factor), name)


@examples(max_examples=2, deadline=None, phases=[Phase.generate])
@given(seed=st.integers(0, 10**6), unit=st.floats(-3, 3))
def test_numbers_of_slopes_follow_where_slopes_stay(seed, unit):
    window, factor = made(seed), 10.0**unit
    reference = solved(window)
    scaled = height_map(factor * window.values, tuple(factor * step for step in spacing(window)))
    scaled_result = solved(scaled, energy=factor)
    for name in numbers(reference):
        law = law_of(name)
        if name in HISTOGRAMS:
            same_histogram(scaled_result, reference, name)
            continue
        same(
            *without_tight(name, scaled_result, reference, factor ** (law.heights + law.lengths)),
            name,
        )


def swapped(name):
    """Return what a number is called when x and y change places."""
    exchange = {"x": "y", "y": "x"}
    return re.sub(
        r"_(x|y|xx|yy)(?=$|_)", lambda match: "_" + "".join(exchange[axis] for axis in match[1]), name
    )


def mirrored_angle(angle):
    return (180 - angle) % 180


OVER_THE_EDGES = ("row_jitter", "Sdq", "Sdr")  # differences of neighbours of the measured map leave these out
# what is done -> to the heights, whether x and y change places, the sign of the cross flow, the angles
CHANGES = {
    "mirrored along x": (lambda v: v[:, ::-1], False, -1, mirrored_angle),
    "mirrored along y": (lambda v: v[::-1], False, -1, mirrored_angle),
    "turned by half a turn": (lambda v: v[::-1, ::-1], False, 1, lambda angle: angle),
    "transposed": (lambda v: v.T, True, 1, lambda angle: (90 - angle) % 180),
    "turned by a right angle": (lambda v: v.T[:, ::-1], True, -1, lambda angle: (90 + angle) % 180),
    "moved": (lambda v: np.roll(v, (7, -11), (0, 1)), False, 1, lambda angle: angle),
}


@pytest.mark.parametrize("change", CHANGES)
@examples(max_examples=2, deadline=None, phases=[Phase.generate])
@given(seed=st.integers(0, 10**6), yielding=st.booleans())
def test_numbers_follow_the_map(change, seed, yielding):
    turn, across, cross_flow, direction = CHANGES[change]
    # rows are those of the scan
    not_of = {
        "transposed": ["row_jitter"],
        "turned by a right angle": ["row_jitter"],
        "moved": OVER_THE_EDGES,
    }
    window = made(seed)
    steps = spacing(window)
    limit = HARDNESS if yielding else None
    reference = solved(window, hardness=limit)
    index = height_map(turn(np.arange(window.size).reshape(window.shape)), 1.0).values.astype(int)
    turned_result = solved(height_map(turn(window.values), steps[::-1] if across else steps), hardness=limit)
    assert set(turned_result.variables) == set(reference.variables)
    for name in numbers(reference):
        if name in not_of.get(change, ()) or name in ("max_von_mises_x", "max_von_mises_y"):
            continue
        actual, expected = turned_result[swapped(name) if across else name].values, reference[name].values
        if name == "flow_factor_xy":
            expected = cross_flow * expected
        if name == "Std":
            deviation = (actual - direction(expected) + 90) % 180 - 90
            assert abs(deviation) < 1e-6, name
            continue
        if name in HISTOGRAMS:
            same_histogram(turned_result, reference, name)
            continue
        same(actual, expected, name)
    # the most strained point is the same point of the surface
    for load in range(reference.sizes["load"]):
        rows, columns = (
            int(float(result[f"max_von_mises_{axis}"][load]) / step)
            for result, axis, step in ((reference, "y", steps[0]), (reference, "x", steps[1]))
        )
        after_steps = steps[::-1] if across else steps
        row, column = (
            int(float(turned_result[f"max_von_mises_{axis}"][load]) / step)
            for axis, step in zip("yx", after_steps, strict=True)
        )
        assert index[row, column] == rows * window.shape[1] + columns


@examples(max_examples=3, deadline=None, phases=[Phase.generate])
@given(seed=st.integers(0, 10**6))
def test_a_map_beside_itself_has_the_same_contact(seed):
    window = made(seed)
    four = np.tile(window.values, (2, 2))
    # of more lines it is judged more strictly: one seed in a hundred or two fails
    assume(is_periodic(window.values) and is_periodic(four))
    single = solved(window)
    repeated = solved(height_map(four, spacing(window)))
    for name in numbers(single):
        if name in (
            "depth",
            "von_mises_profile",
            "max_von_mises_depth",
            "max_von_mises_x",
            "max_von_mises_y",
            "Std",
            *OVER_THE_EDGES,
        ):
            # depths are those of the longer window, between which a maximum is flat: stresses equal to 1e-5
            # lie up to 5 % apart; of four equal places any may be named, and angles of waves are told apart
            # as finely as the window is long
            continue
        actual, expected = (
            result[name].isel(load=slice(2), missing_dims="ignore").values for result in (repeated, single)
        )
        same(actual, law_of(name).repeated * expected, name, points=window.size, core=float(single["Sk"]))


# patches are those of a line; Nayak's parameter is that of an isotropic surface, or of a line
NOT_OF_PROFILES = ("window_length", "contact_clusters", "nayak_parameter", "patch_")


@examples(max_examples=3, deadline=None, phases=[Phase.explicit, Phase.generate])
@given(seed=st.integers(0, 10**6), along=st.sampled_from(["x", "y"]))
@example(seed=419442, along="x")  # four or five points are its valleys
def test_a_profile_is_the_surface_that_does_not_vary_across_it(seed, along):
    line = made(seed, shape=(1, 96), pitch=1e-6, lay=0).values
    profile, extruded = line, np.repeat(line, 8, axis=0)
    assume(is_periodic(line) and is_periodic(extruded))
    if along == "y":
        profile, extruded = profile.T, extruded.T
    profile_result, extruded_result = (solved(height_map(values, 1e-6)) for values in (profile, extruded))
    outside = {"Spk": float(extruded_result["Smr1"]), "Svk": 1 - float(extruded_result["Smr2"])}
    for name in numbers(profile_result):
        if not np.isnan(profile_result[name].values.astype(float)).all() and not name.startswith(
            NOT_OF_PROFILES
        ):
            same(
                profile_result[name].values,
                extruded_result[name].values,
                name,
                points=line.size,
                core=float(extruded_result["Sk"]),
                outside=max(outside.get(name, np.inf), 1 / line.size),
            )


# --- what the names say -----------------------------------------------------------------------------------


def near(window, load, *, hardness=None, relative=2e-3):
    """Return the numbers of three loads that lie close, the middle one being the load."""
    loads = [load * (1 - relative), load, load * (1 + relative)]
    contact = {"contact_modulus": MODULUS, "mean_pressure": loads, "tolerance": 1e-10, "hardness": hardness}
    return rc.contact_statistics(rc.solve_contact(window, **contact), flow="never")


def change(numbers, name):
    return float(numbers[name][2] - numbers[name][0])


@pytest.mark.parametrize("share", [0.01, 0.05, 0.3])
def test_stiffness_and_energy_are_differences_of_gap_and_approach(share):
    window = made(3, shape=(64, 64), pitch=1e-6)
    nearby = near(window, share * MODULUS * roughness_parameters(window)["rms_gradient"])
    loads = change(nearby, "mean_pressure")
    stiffness = float(nearby["contact_stiffness"][1])
    assert stiffness == pytest.approx(-loads / change(nearby, "mean_gap"), rel=0.02)
    # the surfaces approach one another by as much as the gap closes, displacements counted from their mean
    assert change(nearby, "approach") == pytest.approx(change(nearby, "mean_gap"), rel=1e-6)
    # what the load does on its way is in the body: dW = p dp / K
    load = float(nearby["mean_pressure"][1])
    assert change(nearby, "elastic_energy") == pytest.approx(-load * change(nearby, "approach"), rel=1e-3)


def test_stiffness_of_further_loading_is_a_difference_where_points_have_yielded():
    window = made(3, shape=(64, 64), pitch=1e-6)
    load = 0.2 * MODULUS * roughness_parameters(window)["rms_gradient"]
    nearby = near(window, load, hardness=0.6 * HARDNESS)
    assert float(nearby["load_share_above_hardness"][1]) > 0.4
    expected = -change(nearby, "mean_pressure") / change(nearby, "mean_gap")
    assert float(nearby["loading_stiffness"][1]) == pytest.approx(expected, rel=0.02)
    assert float(nearby["contact_stiffness"][1]) > 1.05 * expected  # which is that of unloading
    assert "loading_stiffness" not in near(window, load)  # where nothing yields there is one stiffness


def test_densities_are_of_what_they_name():
    window = made(4, shape=(64, 64), pitch=1e-6)
    load = 0.1 * MODULUS * roughness_parameters(window)["rms_gradient"]
    contact = rc.solve_contact(window, contact_modulus=MODULUS, mean_pressure=load, tolerance=1e-8)
    statistics = rc.contact_statistics(contact).isel(load=0)
    pressure, gap = contact["pressure"].values[0], contact["gap"].values[0]
    touching = pressure > 0
    patches = (
        float(statistics["relative_contact_area_pixels"])
        * window.size
        * 1e-12
        / statistics["contact_clusters"]
    )
    for kind, mean in (
        ("pressure", pressure[touching].mean()),
        ("gap", gap[~touching].mean()),
        ("patch_area", float(patches)),
    ):
        density = statistics[f"{kind}_density"].values
        edges = statistics[f"{kind.removesuffix('_area')}_bin_bounds"].values
        widths = np.diff(edges, axis=-1).ravel()
        assert (density * widths).sum() == pytest.approx(1, rel=1e-9)
        highest = (density * widths * edges[:, 1]).sum()
        lowest = (density * widths * edges[:, 0]).sum()
        assert lowest <= mean <= highest
    assert float(statistics["mean_gap"]) == pytest.approx(gap.mean(), rel=1e-9)
    assert float(statistics["mean_contact_pressure"]) == pytest.approx(pressure[touching].mean(), rel=1e-12)


def test_ratios_are_those_of_the_numbers_that_they_name():
    window = made(5)
    statistics = solved(window, hardness=HARDNESS)
    modulus, gradient = float(statistics["contact_modulus"]), float(statistics["rms_gradient"])
    ratios = {
        "relative_pressure": statistics["mean_pressure"] / (modulus * gradient),
        "max_pressure_over_modulus": statistics["max_pressure"] / modulus,
        "conductance_per_conductivity": statistics["contact_stiffness"] / modulus,
        "thermal_conductance": statistics["contact_stiffness"] / modulus * 2 * 2.0 * 4.0 / (2.0 + 4.0),
        "electrical_conductance": statistics["contact_stiffness"] / modulus * 2 / (1e-6 + 2e-6),
        "thermal_resistance": 1 / statistics["thermal_conductance"],
        "electrical_resistance": 1 / statistics["electrical_conductance"],
        "effective_work_of_adhesion": 0.05 - statistics["conforming_energy"],
        "leak_rate_x": statistics["flow_factor_xx"] * statistics["mean_gap"] ** 3 / (12 * 1e-3 * 2e-3),
        "leak_rate_y": statistics["flow_factor_yy"] * statistics["mean_gap"] ** 3 / (12 * 1e-3 * 2e-3),
        "leak_rate_by_cube": 1 / (12 * 1e-3 * 2e-3),
    }
    for name, expected in ratios.items():
        np.testing.assert_allclose(statistics[name], expected, rtol=1e-9, err_msg=name)


def test_at_the_load_of_first_yield_it_begins():
    window = made(6)
    statistics = solved(window, hardness=HARDNESS)
    contact = {"contact_modulus": MODULUS, "tolerance": 1e-8}
    load = float(statistics["first_yield_pressure"])
    at_yield = rc.solve_contact(window, mean_pressure=load, **contact)
    assert float(at_yield["pressure"].max()) == pytest.approx(HARDNESS, rel=2e-3)
    load = float(statistics["first_subsurface_yield_pressure"])
    if np.isfinite(load):
        at_yield = rc.solve_contact(window, mean_pressure=load, **contact)
        stress = rc.contact_statistics(at_yield, bodies=BODIES, stress="always")["max_von_mises_stress"]
        assert float(stress[0]) == pytest.approx(BODIES[0]["yield_stress"], rel=0.05)


@pytest.mark.parametrize("further", [[1e6, 8e6, 4e8], [3e8, 9e7]])
def test_a_load_has_the_result_and_the_interval_that_it_has_alone(further):
    """But of the largest pressure, whose ends at one load bound those at heavier or lighter ones."""
    rough = made(3, shape=(64, 64), lay=0.0) * 10
    stated = {
        "bodies": [{"material": "steel", "hardness": "2 GPa", "hardness_uncertainty": 0.1}, "rigid"],
        "instrument": {"noise": "10 nm", "resolution": "3 um"},
    }
    alone = rc.evaluate(rough, mean_pressure=[1e8], **stated)
    beside = rc.evaluate(rough, mean_pressure=[*further, 1e8], **stated).isel(load=[-1])
    names = [
        name
        for name, values in alone.data_vars.items()
        if "load" in values.dims and values.dtype.kind == "f" and name != "operator_applications"
    ]
    assert {"relative_contact_area_lower", "mean_gap_next_upper", "max_pressure_parts"} <= {*names}
    for name in names:
        if name.startswith("max_pressure_") and name.endswith(("lower", "upper", "known", "uncertainty")):
            continue
        np.testing.assert_allclose(beside[name], alone[name], rtol=1e-5, err_msg=name)
