"""Laws that hold whatever settings meet: each pair of settings that change a number is in one of the cases.

Each setting was tested by itself; here it meets every other one that `resolve` admits beside it. The laws:
another system of units gives the same numbers, a transposed map the transposed ones; a setting that is stated
so that it does nothing changes nothing, whatever else is stated; and intervals stay within what is possible.
"""

import itertools
import re
import warnings
from typing import NamedTuple

import numpy as np
import pytest
from known_surfaces import self_affine
from test_laws import LAWS, NO_NUMBER, OF_THE_SOLVER, Law, kind_of, same, swapped

from roughcontact import SettingsError, height_map
from roughcontact.arguments.answers import ALLOWED_VALUES
from roughcontact.arguments.settings.models import Settings
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.evaluation.pipeline import run_chain
from roughcontact.evaluation.running_in import worn_in_a_run
from roughcontact.evaluation.sliding import slid_in_a_run

PITCH, SHAPE = (1.5e-6, 1e-6), (30, 33)
LENGTHS, MODULI = 2.0**-2, 2.0**3  # units of the second system, whose rounding is the same


class Setting(NamedTuple):
    """A value of a setting, how it scales with lengths and moduli, and a value with which it does nothing.

    One that `adds` brings numbers of its own, and changes no other one.
    """

    value: object
    scale: tuple[int, int] = (0, 0)
    neutral: object = None
    adds: bool = False


LENGTH, PRESSURE, FORCE, ENERGY = (1, 0), (0, 1), (2, 1), (1, 1)
MATERIAL = {"youngs_modulus": 2.0**31, "poissons_ratio": 0.25}
CONDUCTOR = {"thermal_conductivity": 20.0, "electrical_resistivity": 1e-7}
FILM = MATERIAL | CONDUCTOR | {"thickness": 4e-6}
AREA, LOAD, FORCE_ON_BODY = 2.0**-18, 4e6, 4e-4
RUBBER = {"long_time_modulus": 2.0**29, "moduli": [2.0**31], "times": [1e-4]}
# the name of a setting, and of a group of those that belong together after a colon
SETTINGS = {
    "level.form": Setting("polynomial"),
    "level.order": Setting(3),
    "level.robust": Setting(True),
    "level.outlier_threshold": Setting(5.0),
    "level.line_alignment": Setting("median"),
    "level.scar_threshold": Setting(4.0),
    "level.s_filter": Setting(4e-6, LENGTH),
    "level.l_filter": Setting(25e-6, LENGTH),
    "level.fill": Setting("none"),
    "window.placement": Setting("whole-periods"),
    "window.method": Setting("mirror"),
    "window.width": Setting(0.2),
    "window.shortest_wavelength": Setting(5e-6, LENGTH),
    "window.longest_wavelength": Setting(30e-6, LENGTH),
    "window.reliable_band": Setting(True),
    "contact.layers": Setting({"youngs_modulus": 2.0**32}, neutral={}),
    "contact.hardness": Setting(6e7, PRESSURE, 2e10),
    "contact.hardness_uncertainty": Setting([0.1, 0.2], neutral=1e-13),
    "contact.influence": Setting("elements"),
    "contact.zero_frequency": Setting("nogi-kato"),
    "contact.contact_modulus_uncertainty": Setting(0.05, neutral=1e-13),
    "contact.mean_pressure_uncertainty": Setting(0.02, neutral=1e-13),
    "contact.area": Setting(AREA, (2, 0), AREA),  # and a force instead of the pressure
    "contact.target_area": Setting([0.12], adds=True),
    "contact.target_gap": Setting([1.2e-7], LENGTH, adds=True),
    "contact.time": Setting([1e-4]),  # and a relaxation
    "contact.precision": Setting("single", neutral="double"),
    "bodies.creep_modulus": Setting({"3600": 2.0**30}, PRESSURE, adds=True),
    "bodies.youngs_modulus_uncertainty": Setting([0.1, 0.2], neutral=1e-13),
    "bodies.yield_stress": Setting(4e7, PRESSURE, adds=True),
    "bodies.thermal_conductivity_uncertainty": Setting(0.1, neutral=1e-13),
    "bodies.electrical_resistivity_uncertainty": Setting([0.1, 0.2], neutral=1e-13),
    "form.radius": Setting([2e-3, 3e-3], LENGTH),
    "form.edges": Setting(True),
    "form.local_scale": Setting(True),
    "contact.boundary": Setting("free"),
    "statistics.pressure_bins": Setting(7),
    "statistics.gap_bins": Setting(9),
    "statistics.flow": Setting("always", adds=True),
    "statistics.stress": Setting("always", adds=True),
    "statistics.work_of_adhesion": Setting(0.05, ENERGY, adds=True),
    "statistics.allowed_pressure": Setting(9e7, PRESSURE, adds=True),
    "statistics.seal": Setting({"viscosity": 1e-3, "pressure_difference": 1e5, "width": 2e-3}, adds=True),
    "statistics.seal:whole": Setting({"perimeter": 0.1, "allowed_leak": 1e-12}, adds=True),
    "statistics.seal:gas": Setting({"outlet_pressure": 1e5, "mean_free_path": 7e-8}),
    "statistics.joint": Setting({"gas_conductivity": 0.026, "temperature_jump": 3.7e-7}, adds=True),
    "statistics.joint:film": Setting({"film_thickness": 5e-9, "film_conductivity": 2.0}),
    "statistics.joint:whole": Setting({"area": AREA, "heat_flow": 1.0}, adds=True),
    "statistics.joint:allowed": Setting(
        {"allowed_resistance": 1e-3, "allowed_temperature_drop": 2.0}, adds=True
    ),
    "statistics.friction": Setting({"coefficient": 1, "tangential_load": [0.4]}, adds=True),
    "statistics.friction:area": Setting(
        {"shear_strength": 5e6, "shear_strength_uncertainty": [0.1, 0.2]}, adds=True
    ),
    "statistics.friction:heat": Setting({"speed": 1, "thermal_diffusivity": 1e-5}, adds=True),
    "wear": Setting({"coefficient": 1e-14, "distance": [0.02], "mean_pressure": LOAD}, adds=True),
    "sliding": Setting({"speed": [0.1], "direction": 30, "mean_pressure": LOAD}, adds=True),
    "uncertainty.windows": Setting(4),
    "instrument.noise": Setting(4e-9, LENGTH, 1e-12),
    "instrument.resolution": Setting(3.5e-6, LENGTH),
    "instrument.numerical_aperture": Setting(0.2),
    "instrument.wavelength": Setting(6e-7, LENGTH),
    "instrument.tip_radius": Setting(2e-6, LENGTH, 1e-12),
    "instrument.amplification_z": Setting(0.02, neutral=1e-13),
    "instrument.amplification_xy": Setting(0.01, neutral=1e-13),
    "instrument.correct": Setting(True),
    "overview": Setting(True),
}
ELSEWHERE = {
    "of every case": ["contact.contact_modulus", "contact.bodies", "contact.mean_pressure", "contact.force"],
    "of every case as well": ["contact.tolerance", "uncertainty.sources"],
    "no number": ["level.max_missing", "window.min_share", "contact.keep_fields", "contact.on_failure"],
    "test_second_ways.py": ["contact.unload", "contact.relative_pressure", "statistics.requirement"],
    "test_second_ways.py as well": ["contact.target"],
    "test_faces.py": ["composite.shifts", "composite.rotations", "composite.overlap", "composite.seed"],
    "test_uncertainty_instrument.py": ["instrument.finer_spectrum"],
}
NEEDS = {
    "level.order": ["level.form"],
    "contact.hardness_uncertainty": ["contact.hardness"],
    "form.radius": ["contact.boundary"],
    "form.edges": ["contact.boundary"],
    "statistics.seal:whole": ["statistics.seal"],
    "statistics.seal:gas": ["statistics.seal"],
    "statistics.joint:film": ["statistics.joint"],
    "statistics.joint:allowed": ["statistics.joint:whole"],
    "statistics.friction:heat": ["statistics.friction:area"],
    "instrument.wavelength": ["instrument.numerical_aperture"],
    "instrument.correct": ["instrument.resolution"],
    "sliding": ["contact.time"],  # the relaxation
}
# what of settings of several numbers has a unit
WITHIN = {
    **dict.fromkeys(["temperature_jump", "width", "thickness", "radius", "perimeter", "gap"], LENGTH),
    **dict.fromkeys(["mean_free_path", "film_thickness", "thermal_diffusivity", "distance"], LENGTH),
    **dict.fromkeys(["pressure_difference", "outlet_pressure", "youngs_modulus"], PRESSURE),
    **dict.fromkeys(["mean_pressure", "shear_strength", "long_time_modulus", "moduli"], PRESSURE),
    "force": FORCE,
    "area": (2, 0),
    "allowed_leak": (3, 1),
    **dict.fromkeys(["allowed_resistance", "allowed_temperature_drop"], (-1, 0)),
    "coefficient": (0, -1),  # of wear; that of friction, and its speed, are whole numbers without a unit
    "speed": LENGTH,  # of rubber
}
# of the numbers that have laws of their own here, since all lengths and forces are scaled
FURTHER_LAWS = {
    "force": Law(0, 2, 1),
    **dict.fromkeys(["contact_area", "local_contact_area", "greenwood_tripp_contact_area"], Law(0, 2, 0)),
    **dict.fromkeys(["contact_radius", "hertz_radius", "loaded_radius", "hertz_approach"], Law(0, 1, 0)),
    **dict.fromkeys(["greenwood_tripp_loaded_radius", "local_mean_gap"], Law(0, 1, 0)),
    **dict.fromkeys(["hertz_max_pressure", "greenwood_tripp_max_pressure"], Law(0, 0, 1)),
    "local_mean_contact_pressure": Law(0, 0, 1),
    **dict.fromkeys(["gas_conductance", "joint_conductance"], Law(0, -1, 0)),
    **dict.fromkeys(["leak_rate_x", "leak_rate_y"], Law(0, 2, 1)),
    "leak_rate_by_cube": Law(0, -1, 1),
    "total_force": Law(0, 2, 1),
    **dict.fromkeys(["total_leak_rate_x", "total_leak_rate_y"], Law(0, 3, 1)),
    **dict.fromkeys(["total_electrical_resistance", "total_thermal_resistance"], Law(0, -1, 0)),
    "temperature_drop": Law(0, -1, 0),
    **dict.fromkeys([f"{name}_holds_from" for name in ALLOWED_VALUES], Law(0, 0, 1)),
    **dict.fromkeys([f"{name}_holds" for name in ALLOWED_VALUES], Law(0, 0, 0)),
    "gap_largest_Sq": Law(0, 1, 0),
    "stick_share": Law(0, 0, 0),
    **dict.fromkeys(["friction_coefficient", "adhesive_friction_coefficient"], Law(0, 0, 0)),
    **dict.fromkeys(["hysteretic_friction_coefficient", "persson_friction_coefficient"], Law(0, 0, 0)),
    **dict.fromkeys(["mean_flash_temperature", "max_flash_temperature"], Law(0, 1, 1)),
    "slid max_flash_temperature": Law(0, 2, 1),  # by a speed that is scaled
    "tangential_stiffness": Law(0, -1, 1),
    "dissipated_energy": Law(0, 1, 1),
    **dict.fromkeys(["worn_volume", "max_worn_depth"], Law(0, 1, 0)),
}


def rough(by, periods=1):
    """Return a periodic surface at every so many halves of the pitch, laid beside itself."""
    fine = self_affine(
        [2 * points for points in SHAPE],
        [step / 2 for step in PITCH],
        (6e-6, 24e-6),
        hurst=0.7,
        rms_gradient=0.05,
        seed=3,
    )
    return np.tile(fine.values, (periods, periods))[::by, ::by].copy()


def as_map(heights, coarser, transposed, unit):
    values, steps = (heights.T, PITCH[::-1]) if transposed else (heights, PITCH)
    return height_map(unit * values, tuple(coarser * unit * step for step in steps))


def measured(transposed=False, unit=1.0):
    """Return a map as an instrument has it: a tilt, a spike, missing points."""
    heights = rough(2)
    y, x = np.indices(SHAPE)
    heights += 2e-9 * x - 1e-9 * y
    heights[4, 3] += 2e-6
    heights[2:4, 1:3] = np.nan
    return as_map(heights, 1, transposed, unit)


def field_around(transposed=False, unit=1.0):
    """Return a coarser map of three by three faces, and the place of the middle one in it."""
    field = as_map(rough(3, periods=3), 1.5, transposed, unit)
    y, x = (0.5 * points * float(field[axis].diff(axis)[0]) for axis, points in field.sizes.items())
    return field, f"{1e6 * x!r} {1e6 * y!r} um"


def in_units(value, units, scale=(0, 0)):
    """Return a value, or those within it, in another system of units (length, modulus)."""
    if isinstance(value, dict):
        return {key: in_units(entry, units, WITHIN.get(key, scale)) for key, entry in value.items()}
    if isinstance(value, list):
        return [in_units(entry, units, scale) for entry in value]
    return value * units[0] ** scale[0] * units[1] ** scale[1] if isinstance(value, float) else value


def sections(names, *, units=(1.0, 1.0), neutral=()):
    """Return the sections of the settings for some of `SETTINGS`, in a system of units."""
    bodies, chosen = [MATERIAL | CONDUCTOR] * 2, {"contact": {"tolerance": 1e-7}}
    if by_force := {"contact.boundary", "form.local_scale"} & {*names}:
        chosen["form"] = {"radius": [in_units(2e-3, units, LENGTH)]}
    if by_force or "contact.area" in names:
        chosen["contact"]["force"] = [in_units(FORCE_ON_BODY if by_force else LOAD * AREA, units, FORCE)]
    else:
        chosen["contact"]["mean_pressure"] = [in_units(LOAD, units, PRESSURE)]
    if "contact.time" in names:
        bodies = [
            body | {"youngs_modulus": modulus}
            for body, modulus in zip(bodies, (2.0**29, 2.0**37), strict=True)
        ]
        bodies[0]["relaxation"] = RUBBER
    if "contact.precision" in {*names} - {*neutral}:
        chosen["contact"]["tolerance"] = 1e-4
    bodies = in_units(bodies, units)
    for name in names:
        setting, (section, _, key) = SETTINGS[name], name.partition(":")[0].partition(".")
        value = in_units(setting.neutral if name in neutral else setting.value, units, setting.scale)
        if key == "layers":
            bodies[0] = bodies[0] | {"layers": [in_units(FILM, units) | value]}
        elif section == "bodies":
            bodies = [body | {key: value} for body in bodies]
        elif isinstance(value, dict):
            group = chosen.setdefault(section, {})
            group |= {key: group.get(key, {}) | value} if key else value
        elif section != "overview":
            chosen.setdefault(section, {})[key] = value
    chosen["contact"]["bodies"] = bodies
    return chosen


APART = [("overview", "contact.boundary")]


def admitted(names):
    """Whether `resolve` takes these settings together."""
    try:
        resolve(sections(names))
    except SettingsError:
        return False
    return not any({*pair} <= {*names} for pair in APART)


def covering_cases():
    """Return cases, tuples of names, in which every pair that is admitted occurs, and the refused pairs."""
    pairs = {frozenset(pair) for pair in itertools.combinations(SETTINGS, 2)}

    def with_needs(names):
        needed = [need for name in names for need in NEEDS.get(name, ())]
        return [*dict.fromkeys([*names, *needed])]

    refused = {pair for pair in pairs if not admitted(with_needs(sorted(pair)))}
    remaining, cases = pairs - refused, []
    while remaining:
        case = with_needs(sorted(min(remaining, key=sorted)))
        for name in SETTINGS:
            longer = with_needs([*case, name])
            gain = {frozenset(pair) for pair in itertools.combinations(longer, 2)} & remaining
            gain -= {frozenset(pair) for pair in itertools.combinations(case, 2)}
            if name not in case and gain and admitted(longer):
                case = longer
        remaining -= {frozenset(pair) for pair in itertools.combinations(case, 2)}
        cases.append(tuple(case))
    return cases, refused


CASES, REFUSED = covering_cases()


def test_every_setting_is_in_the_table():
    """Or another file has its laws; what is in the table is in a case."""
    assert {*SETTINGS} == {*itertools.chain(*CASES)}
    named = {name.partition(":")[0] for name in SETTINGS}.union(*ELSEWHERE.values())
    for section, field in Settings.model_fields.items():
        if section not in named | {"surfaces", "report", "cases"}:
            assert {f"{section}.{key}" for key in field.annotation.model_fields} <= named


def evaluated(names, *, transposed=False, unit=1.0, extra=None, **options):
    """Return the statistics of the map by the settings of some names, and those of wear and sliding."""
    chosen = sections(names, **options)
    if transposed and "form.radius" in names:
        chosen["form"]["radius"].reverse()
    for section, values in (extra or {}).items():
        chosen[section] = chosen.get(section, {}) | values
    full = resolve(chosen)[""]
    overviews = [field_around(transposed, unit)] if "overview" in names else []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        chain = run_chain(measured(transposed, unit), full, overviews=overviews)
        further = {}
        if "wear" in names:
            further["worn"] = worn_in_a_run(chain.window, full, mean_pressure=full["wear"]["mean_pressure"])
        if "sliding" in names:
            full["sliding"]["direction"] = 60.0 if transposed else 30.0  # the same of the face
            pressure = full["sliding"]["mean_pressure"]
            further["slid"] = slid_in_a_run(chain.window, full, mean_pressure=pressure)
    renamed = [
        data.drop_vars(["height", "pressure", "gap"], errors="ignore").rename(
            {
                name: f"{prefix} {name}"
                for name in {*data.variables, *data.dims} - {"height", "pressure", "gap"}
            }
        )
        for prefix, data in further.items()
    ]
    return chain.statistics.assign({key: value for data in renamed for key, value in data.variables.items()})


@pytest.fixture(scope="module")
def results():
    """The numbers of each case, computed once."""
    cache = {}

    def result(names):
        if names not in cache:
            cache[names] = evaluated(names)
        return cache[names]

    return result


def law_of(name):
    """Return how a number scales, None of one that says nothing of the surface."""
    kind = kind_of(re.sub("_after$|_after(?=_(lower|upper)$)", "", name.rpartition(" ")[2]))
    if found := FURTHER_LAWS.get(name) or FURTHER_LAWS.get(kind):
        return found
    return None if kind in OF_THE_SOLVER | NO_NUMBER else LAWS[kind]


def lawful(dataset):
    return [str(name) for name, data in dataset.variables.items() if data.dtype.kind == "f" and law_of(name)]


@pytest.mark.parametrize("names", CASES)
def test_another_system_of_units_gives_the_same_numbers(results, names):
    reference = results(names)
    converted = evaluated(names, unit=LENGTHS, units=(LENGTHS, MODULI))
    for name in lawful(reference):
        law = law_of(name)
        factor = LENGTHS ** (law.heights + law.lengths) * MODULI**law.modulus
        actual, expected = converted[name].values / factor, reference[name].values
        if name.endswith("flow_factor_xy"):  # of a mirrored map it is rounding beside the flow along the axes
            along = np.hypot(reference["flow_factor_xx"].values, reference["flow_factor_yy"].values).min()
            actual, expected = actual / along, expected / along
            np.testing.assert_allclose(actual, expected, rtol=2e-5, atol=1e-9, err_msg=name)
            continue
        same(actual, expected, name)


HEADLINE = ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure", "contact_stiffness")
BY_ROWS = {"level.line_alignment", "level.scar_threshold"}
DATASETS = {"wear", "sliding"}  # computed from what the others give
ALONE = {"overview"}  # of intervals
NOT_NEUTRAL = {
    "contact.boundary": {"contact.layers"},  # further positions of a body with layers are not solved
    "instrument.correct": {"instrument.noise", "instrument.tip_radius"},  # they limit what is corrected
}
# of members, which are solved less exactly
ENDINGS = ("lower", "upper", "uncertainty", "estimate", "components", "parts", "known", "joint", "alone")


def by_members(name):
    """Whether a number is corrected, or of an interval, in which finer pixels and parts have a share."""
    return name.startswith("local_") or name.endswith((*ENDINGS, *HEADLINE, "max_pressure_over_modulus"))


def same_or_unknown(actual, expected, name):
    """Whether two numbers are one where the second is known, those of intervals to a hundredth.

    Members are solved to 1e-3, and what they say of finer pixels and other places is extrapolated.
    """
    is_known = np.isfinite(expected)
    if by_members(name):
        scale = np.abs(expected[is_known]).max(initial=0.0)
        np.testing.assert_allclose(
            actual[is_known], expected[is_known], rtol=0.01, atol=0.01 * scale, err_msg=name
        )
    else:
        same(actual[is_known], expected[is_known], name)


@pytest.mark.parametrize("names", CASES)
def test_the_numbers_of_a_transposed_map_are_transposed(names):
    symmetric = tuple(name for name in names if name not in BY_ROWS | ALONE)
    extra = {"level": {"line_alignment": "none"}, "uncertainty": {"sources": []}}
    plain, transposed_result = (
        evaluated(symmetric, transposed=transposed, extra=extra).sortby(
            "mean_pressure"
        )  # the axis that closes first
        for transposed in (False, True)
    )
    # windows are faded along one axis after the other, robust fits end at a tolerance
    for name in plain.variables:
        if name.endswith(("_x", "_y", "_xx", "_yy", "friction_coefficient", *HEADLINE)):
            if "max_von_mises" in name or name.startswith("window_offset"):
                continue  # of points that equally strained ones share; of the first corner
            rtol = 0.02 if name.startswith("worn ") else 0.01  # by steps of a tolerance
            np.testing.assert_allclose(transposed_result[swapped(name)], plain[name], rtol=rtol, err_msg=name)


@pytest.mark.parametrize("names", CASES)
def test_what_is_stated_to_do_nothing_changes_nothing(names):
    """Neither a neutral value, nor what is asked for besides."""
    adding = {name for name in names if SETTINGS[name].adds}
    adding |= {name for name in names if adding & {*NEEDS.get(name, ())}}
    neutral = {name for name in names if SETTINGS[name].neutral is not None}
    neutral -= set().union(*(NOT_NEUTRAL.get(name, set()) for name in names))
    plain = evaluated(tuple(name for name in names if name not in neutral | adding))
    left_out = DATASETS | {"contact.target_gap"}  # between more loads corrections are interpolated
    with_neutral = evaluated(tuple(name for name in names if name not in left_out), neutral=neutral)
    # without the load of a target; of a force over an area it has another last digit
    stated = np.isclose(with_neutral["mean_pressure"], plain["mean_pressure"].values[0], rtol=1e-12)
    with_neutral = with_neutral.isel(load=stated)
    for name in lawful(plain):
        # on a mirrored map the flow across is rounding, and equal points share the largest stress
        exceptions = ("sensitivity", "components", "flow_factor_xy", "von_mises_x", "von_mises_y")
        exceptions += ("depth", "von_mises_profile")  # depths are also those of interfaces
        if name in with_neutral and not name.endswith(exceptions):
            same_or_unknown(with_neutral[name].values, plain[name].values, name)


@pytest.mark.parametrize("names", CASES)
def test_intervals_stay_within_what_is_possible(results, names):
    numbers = results(names)
    span = 2 * float(np.nanmax(measured()) - np.nanmin(measured()))
    highest = {"relative_contact_area": 1.0, "mean_gap": span, "max_pressure": 1e12}
    for name in ("relative_contact_area", "mean_gap", "mean_contact_pressure", "max_pressure"):
        value, lower, upper = (numbers[f"{name}{suffix}"].values for suffix in ("", "_lower", "_upper"))
        assert (lower >= 0).all(), name
        assert (lower <= value * (1 + 1e-9)).all(), name
        assert (
            np.isnan(upper) | ((value <= upper * (1 + 1e-9)) & (upper <= highest.get(name, np.inf)))
        ).all(), name
    assert (numbers["max_pressure"] >= numbers["mean_contact_pressure"]).all()
    pressure = numbers["mean_contact_pressure_as_solved"]
    carried = pressure * numbers["relative_contact_area_pixels"]
    np.testing.assert_allclose(carried, numbers["mean_pressure"], rtol=1e-6)
