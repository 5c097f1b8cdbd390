"""Laws that hold whatever settings meet: each pair of settings that change a number is in one of the cases.

Each setting was tested by itself; here it meets every other one that `resolve` admits beside it. The laws:
another system of units gives the same numbers, a transposed map the transposed ones; a setting that is stated
so that it does nothing changes nothing, whatever else is stated; and intervals stay within what is possible.
"""

import itertools
import warnings
from typing import NamedTuple

import numpy as np
import pytest
from test_laws import LAWS, NO_NUMBER, OF_THE_SOLVER, Law, kind_of, same, swapped

import roughcontact as rc
from roughcontact.arguments.maps import height_map
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.errors import SettingsError
from roughcontact.surface.synthetic import self_affine_surface

PITCH, SHAPE = (1.5e-6, 1e-6), (32, 36)
LENGTHS, MODULI = 2.0**-2, 2.0**3  # units of the second system, whose rounding is the same


class Setting(NamedTuple):
    """A value of a setting, how it scales with lengths and moduli, and a value with which it does nothing."""

    value: object
    scale: tuple[int, int] = (0, 0)
    neutral: object = None


LENGTH, PRESSURE, FORCE = (1, 0), (0, 1), (2, 1)
MATERIAL = {"youngs_modulus": 2.0**31, "poissons_ratio": 0.25}
CONDUCTOR = {"thermal_conductivity": 20.0, "electrical_resistivity": 1e-7}
FILM = MATERIAL | CONDUCTOR | {"thickness": 4e-6}
SETTINGS = {
    "level.form": Setting("polynomial"),
    "level.robust": Setting(True),
    "level.outlier_threshold": Setting(5.0),
    "level.line_alignment": Setting("median"),
    "level.scar_threshold": Setting(4.0),
    "level.s_filter": Setting(4e-6, LENGTH),
    "level.l_filter": Setting(25e-6, LENGTH),
    "window.method": Setting("mirror"),
    "window.width": Setting(0.2),
    "window.shortest_wavelength": Setting(5e-6, LENGTH),
    "window.longest_wavelength": Setting(30e-6, LENGTH),
    "contact.layers": Setting({"youngs_modulus": 2.0**32}, neutral={}),
    "contact.hardness": Setting(6e7, PRESSURE, 2e10),
    "contact.influence": Setting("elements"),
    "contact.zero_frequency": Setting("nogi-kato"),
    "contact.contact_modulus_uncertainty": Setting(0.05, neutral=1e-13),
    "contact.mean_pressure_uncertainty": Setting(0.02, neutral=1e-13),
    "form.edges": Setting(True),
    "form.local_scale": Setting(True),
    "contact.boundary": Setting("free"),
    "statistics.pressure_bins": Setting(7),
    "statistics.gap_bins": Setting(9),
    "statistics.flow": Setting("always"),
    "statistics.stress": Setting("always"),
    "statistics.work_of_adhesion": Setting(0.05, (1, 1)),
    "statistics.seal": Setting({"viscosity": 1e-3, "pressure_difference": 1e5, "width": 2e-3}),
    "statistics.joint": Setting({"gas_conductivity": 0.026, "temperature_jump": 3.7e-7}),
    "statistics.friction": Setting({"coefficient": 0.3, "tangential_load": [0.4]}),
    "uncertainty.windows": Setting(4),
    "instrument.noise": Setting(4e-9, LENGTH, 1e-12),
    "instrument.resolution": Setting(3.5e-6, LENGTH),
    "instrument.tip_radius": Setting(2e-6, LENGTH, 1e-12),
    "instrument.amplification_z": Setting(0.02, neutral=1e-13),
    "instrument.amplification_xy": Setting(0.01, neutral=1e-13),
    "instrument.correct": Setting(True),
}
# what of settings of several numbers has a unit
WITHIN = {
    "temperature_jump": LENGTH,
    "pressure_difference": PRESSURE,
    "width": LENGTH,
    "thickness": LENGTH,
    "youngs_modulus": PRESSURE,
    "force": FORCE,
    "radius": LENGTH,
    "mean_pressure": PRESSURE,
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
}


def measured(transposed=False, unit=1.0):
    """Return a map as an instrument has it: a tilt, a spike, missing points."""
    rough = self_affine_surface(
        SHAPE, PITCH, hurst=0.7, shortest=6e-6, longest=30e-6, rms_gradient=0.05, seed=3
    ).values.copy()
    y, x = np.indices(SHAPE)
    rough += 2e-9 * x - 1e-9 * y
    rough[20, 7] += 2e-6
    rough[24:26, 12:15] = np.nan
    values, steps = (rough.T, PITCH[::-1]) if transposed else (rough, PITCH)
    return height_map(unit * values, tuple(unit * step for step in steps))


def in_units(value, units, scale=(0, 0)):
    """Return a value, or those within it, in another system of units (length, modulus)."""
    if isinstance(value, dict):
        return {key: in_units(entry, units, WITHIN.get(key, (0, 0))) for key, entry in value.items()}
    if isinstance(value, list):
        return [in_units(entry, units, scale) for entry in value]
    return value * units[0] ** scale[0] * units[1] ** scale[1] if isinstance(value, float) else value


def sections(names, *, units=(1.0, 1.0), neutral=()):
    """Return the sections of the settings for some of `SETTINGS`, in a system of units."""
    by_force = {"contact.boundary", "form.local_scale"} & {*names}
    bodies = [MATERIAL | CONDUCTOR, MATERIAL | CONDUCTOR]
    loads = {"force": [2e-4, 5e-4]} if by_force else {"mean_pressure": [1e6, 6e6]}
    chosen = {"contact": in_units(loads | {"tolerance": 1e-7}, units)}
    if by_force:
        chosen["form"] = in_units({"radius": [2e-3]}, units)
    for name in names:
        setting, (section, key) = SETTINGS[name], name.split(".")
        value = setting.neutral if name in neutral else setting.value
        if key == "layers":
            bodies[0] = bodies[0] | {"layers": [FILM | value]}
        else:
            chosen.setdefault(section, {})[key] = in_units(value, units, setting.scale)
    chosen["contact"]["bodies"] = in_units(bodies, units)
    return chosen


def admitted(names):
    """Whether `resolve` takes these settings together."""
    try:
        resolve(sections(names))
    except SettingsError:
        return False
    return True


def covering_cases():
    """Return cases, tuples of names, in which every pair that is admitted occurs, and the refused pairs."""
    pairs = {frozenset(pair) for pair in itertools.combinations(SETTINGS, 2)}
    needs = {"form.edges": ["contact.boundary"], "instrument.correct": ["instrument.resolution"]}

    def with_needs(names):
        return list(dict.fromkeys([*names, *(need for name in names for need in needs.get(name, ()))]))

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


def evaluated(height, names, *, extra=None, **options):
    chosen = sections(names, **options)
    for section, values in (extra or {}).items():
        chosen[section] = chosen.get(section, {}) | values
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return rc.evaluate(height, **chosen)


@pytest.fixture(scope="module")
def results():
    """The numbers of each case, computed once."""
    cache = {}

    def result(names):
        if names not in cache:
            cache[names] = evaluated(measured(), names)
        return cache[names]

    return result


def lawful(dataset):
    names = (str(name) for name in dataset.variables)
    excluded = (OF_THE_SOLVER | NO_NUMBER) - {*FURTHER_LAWS}
    return [name for name in names if kind_of(name) not in excluded and dataset[name].dtype.kind == "f"]


@pytest.mark.parametrize("names", CASES)
def test_another_system_of_units_gives_the_same_numbers(results, names):
    reference = results(names)
    converted = evaluated(measured(unit=LENGTHS), names, units=(LENGTHS, MODULI))
    for name in lawful(reference):
        law = FURTHER_LAWS.get(kind_of(name)) or LAWS[kind_of(name)]
        factor = LENGTHS ** (law.heights + law.lengths) * MODULI**law.modulus
        actual, expected = converted[name].values / factor, reference[name].values
        if name == "flow_factor_xy":  # of a mirrored map it is rounding beside the flow along the axes
            along = np.hypot(reference["flow_factor_xx"].values, reference["flow_factor_yy"].values)
            actual, expected = actual / along, expected / along
            np.testing.assert_allclose(actual, expected, rtol=2e-5, atol=1e-9, err_msg=name)
            continue
        same(actual, expected, name)


HEADLINE = ("relative_contact_area", "mean_gap", "max_pressure", "mean_contact_pressure", "contact_stiffness")
BY_ROWS = {"level.line_alignment", "level.scar_threshold"}
NOT_NEUTRAL = {
    "contact.boundary": {"contact.layers"},  # further positions of a body with layers are not solved
    "instrument.correct": {"instrument.noise", "instrument.tip_radius"},  # they limit what is corrected
}
# of members, which are solved less exactly
ENDINGS = ("lower", "upper", "uncertainty", "estimate", "components", "parts", "known", "sensitivity")


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
    symmetric = tuple(name for name in names if name not in BY_ROWS)
    extra = {"level": {"line_alignment": "none"}, "uncertainty": {"sources": []}}
    plain, transposed_result = (
        evaluated(measured(transposed), symmetric, extra=extra) for transposed in (False, True)
    )
    # windows are faded along one axis after the other, robust fits end at a tolerance
    for name in plain.variables:
        if name.endswith(("_x", "_y", "_xx", "_yy")) or name in HEADLINE:
            if name.startswith(("max_von_mises", "window_offset")):
                continue  # of points that equally strained ones share; of the first corner
            np.testing.assert_allclose(transposed_result[swapped(name)], plain[name], rtol=0.01, err_msg=name)


@pytest.mark.parametrize("names", CASES)
def test_what_is_stated_to_do_nothing_changes_nothing(names):
    neutral = {name for name in names if SETTINGS[name].neutral is not None}
    neutral -= set().union(*(NOT_NEUTRAL.get(name, set()) for name in names))
    plain = evaluated(measured(), tuple(name for name in names if name not in neutral))
    with_neutral = evaluated(measured(), names, neutral=neutral)
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
