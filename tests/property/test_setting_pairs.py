"""Laws that hold whatever settings meet: each pair of settings that change a number is in one of the cases.

The settings are those of the models, nested ones as well. Each was tested by itself; here it meets every
other one that `resolve` admits beside it. The laws: another system of units gives the same numbers, a
transposed map the transposed ones; a setting that is stated so that it does nothing changes nothing, whatever
else is stated; and intervals stay within what is possible. The first cases meet most pairs, the slow ones
those of settings that exclude one another: five ways of stating a load, four of what bodies are made of.
"""

import itertools
import random
import re
import tempfile
import warnings
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple, get_args

import numpy as np
import pytest
import xarray as xr
from case_tables import cases_of
from known_surfaces import self_affine
from test_laws import LAWS, NO_NUMBER, OF_THE_SOLVER, Law, kind_of, same, swapped

import roughcontact as rc
from roughcontact import SettingsError, height_map
from roughcontact.arguments.answers import ALLOWED_VALUES
from roughcontact.arguments.relaxation import KEYS as RELAXATION_KEYS
from roughcontact.arguments.relaxation import relaxation_of
from roughcontact.arguments.settings.models import Section, Settings
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.arguments.variables import VARIABLES
from roughcontact.evaluation.courses import Face, slid_in_a_run, worn_in_a_run
from roughcontact.evaluation.pipeline import run_chain
from roughcontact.statistics.unloading import evaluate_unloading
from roughcontact.surface.preparation.periodic_map import MapPreparation

PITCH, SHAPE = (1.5e-6, 1e-6), (30, 33)
LENGTHS, MODULI = 2.0**-2, 2.0**3  # units of the second system, whose rounding is the same
FILES = Path(tempfile.mkdtemp())


class Setting(NamedTuple):
    """A value of a setting, how it scales with lengths and moduli, and a value with which it does nothing.

    One that `adds` brings numbers of its own, and changes no other one. It is stated with those that it
    `needs`.
    """

    value: object
    scale: tuple[int, int] = (0, 0)
    neutral: object = None
    adds: bool = False
    needs: tuple[str, ...] = ()


LENGTH, AREA_SCALE, PRESSURE, FORCE, ENERGY = (1, 0), (2, 0), (0, 1), (2, 1), (1, 1)
AREA, LOAD, FORCE_ON_BODY = 2.0**-18, 4e6, 4e-4
RUBBER = {"long_time_modulus": 2.0**29, "moduli": [2.0**31], "times": [1e-4]}
BODIES, LAYERS, SERIES = "contact.bodies", "contact.bodies.layers", "contact.bodies.relaxation:series"
FREE, SCALE = "contact:free", ":local scale"
SEAL, JOINT, FRICTION = "statistics.seal:flow", "statistics.joint:area", "statistics.friction:slip"
CONDUCTS, RESISTS = "contact.bodies.thermal_conductivity", "contact.bodies.electrical_resistivity"
WEAR, SLIDING, FORM, LENS = "wear:worn", "sliding.speed", "level.form", "instrument.numerical_aperture"
# of one or more keys, which stand after a colon where there are several, or the same with other ones
SETTINGS = {key: Setting(*row) for key, *row in cases_of("test_setting_pairs", "SETTINGS")[1]}
RELAXATIONS, TEMPERATURE = (
    (SERIES, "contact.bodies.relaxation.table"),
    "contact.bodies.relaxation:temperature",
)
STATED_LOADS = ("contact.mean_pressure", "contact.relative_pressure", "contact:area", FREE, SCALE)
# those that need one of some others, which is the first where none is stated
ONE_OF = {
    "contact.tolerance": (BODIES, "contact.contact_modulus"),
    **dict.fromkeys([BODIES, "contact.contact_modulus"], STATED_LOADS),
    **dict.fromkeys(["contact.time", SLIDING, TEMPERATURE], RELAXATIONS),
    "contact.unload": ("contact.hardness", "contact.bodies.hardness"),
}
# which have no number: what they are about has its own tests
WITHOUT_NUMBER = {
    **dict.fromkeys(["contact.bodies.name", "contact.bodies.layers.name", "report.title"], "of the page"),
    **dict.fromkeys(["level.max_missing", "window.min_share"], "refuse a map"),
    "surfaces": "path of the table",
    "cases": "settings as these",
    "contact.on_failure": "of a load that is not solved",
    "contact.keep_fields": "what is written",
}
OF_FIRST_BODY = (*RELAXATIONS, TEMPERATURE, "contact.bodies.base")
OF_ALL_MATERIALS = (CONDUCTS, RESISTS)
# pairs that are refused where the map is known, later than by `resolve`
APART = [
    {"overview", FREE},
    *({"composite", name} for name in ("overview", WEAR, SLIDING, "instrument.correct")),
]
# what of settings of several numbers has a unit
WITHIN = {
    name: tuple(scale)
    for *scale, names in cases_of("test_setting_pairs", "WITHIN")[1]
    for name in names.split()
}
# of the numbers that have laws of their own here, since all lengths and forces are scaled
FURTHER_LAWS = {
    name: Law(0, *scale)
    for *scale, names in cases_of("test_setting_pairs", "laws")[1]
    for name in names.split(", ")
}
FURTHER_LAWS |= {f"{name}_holds_from": Law(0, 0, 1) for name in ALLOWED_VALUES}
FURTHER_LAWS |= {f"{name}_holds": Law(0, 0, 0) for name in ALLOWED_VALUES}
FURTHER_LAWS |= {name: Law(0, 1, 0) for name in VARIABLES if name.endswith("_largest_Sq")}


def rough(by, periods=1):
    """Return a periodic surface at every so many quarters of the pitch, laid beside itself."""
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


def pair_of_faces(settings, unit=1.0):
    """Return the heights of a face and a finer counter-face of it, levelled each by itself."""
    faces = [measured(unit=unit), as_map(rough(1)[:36, :40], 0.5, False, unit)]
    faces = [rc.level(face, **settings["level"]) for face in faces]
    return rc.composite(*faces, **rc.relative_positions(*faces, **settings["composite"])[-1])


@cache
def table_of_rubber(modulus):
    """Return the file of the storage and loss moduli of `RUBBER`, in units of moduli."""
    frequency = np.geomspace(1, 1e6, 30)
    young = 0.75 * relaxation_of(RUBBER).contact_modulus(2 * np.pi * frequency) * modulus
    path = FILES / f"rubber {modulus}.csv"
    rows = [f"{f!r},{e.real!r},{e.imag!r}" for f, e in zip(frequency.tolist(), young.tolist(), strict=True)]
    path.write_text("\n".join(["frequency,storage_modulus,loss_modulus", *rows]), encoding="utf-8")
    return str(path)


def in_units(value, units, scale=(0, 0)):
    """Return a value, or those within it, in another system of units (length, modulus)."""
    if isinstance(value, dict):
        return {key: in_units(entry, units, WITHIN.get(key, scale)) for key, entry in value.items()}
    if isinstance(value, list):
        return [in_units(entry, units, scale) for entry in value]
    return value * units[0] ** scale[0] * units[1] ** scale[1] if isinstance(value, float) else value


def put(group, path, value):
    """Put a value, or those within it, at a path of keys."""
    if isinstance(value, Mapping):
        for key, entry in value.items():
            put(group, [*path, key], entry)
        return
    for key in path[:-1]:
        group = group.setdefault(key, {})
    group[path[-1]] = value


def complete(names):
    """Return names of settings with those without which they say nothing."""
    chosen, before = {"contact.tolerance", *names}, set()
    while chosen != before:
        before = {*chosen}
        chosen |= {need for name in before for need in SETTINGS[name].needs}
        chosen |= {ONE_OF[name][0] for name in before if name in ONE_OF and not chosen & {*ONE_OF[name]}}
    return tuple(name for name in SETTINGS if name in chosen)


def sections(names, *, units=(1.0, 1.0), neutral=()):
    """Return the sections of the settings for some of `SETTINGS`, in a system of units."""
    chosen, body, counter_body, layer = {}, {}, {}, {}
    for name in complete(names):
        setting, path = SETTINGS[name], [key for key in name.partition(":")[0].split(".") if key]
        value = in_units(setting.neutral if name in neutral else setting.value, units, setting.scale)
        if path[:2] != ["contact", "bodies"]:
            put(chosen, path, value)
        elif path[2:3] == ["layers"]:
            put(layer, path[3:], value)
        else:
            put(body, path[2:], value)
            if name not in OF_FIRST_BODY:
                put(counter_body, path[2:], value)
            if name in OF_ALL_MATERIALS and LAYERS in complete(names):
                put(layer, path[2:], value)
    chosen.pop("overview", None)  # a column of the table
    if "relaxation" in body:  # a rubber, which is softer than its counter-body
        body["youngs_modulus"] /= 4
        counter_body["youngs_modulus"] *= 64
        if "table" in body["relaxation"]:
            body["relaxation"]["table"] = table_of_rubber(units[1])
    if "base" in body:
        for key in ("youngs_modulus", "poissons_ratio", "youngs_modulus_uncertainty"):
            body.pop(key, None)
    if body:
        chosen["contact"]["bodies"] = [body | ({"layers": [layer]} if layer else {}), counter_body]
    if chosen["contact"].get("precision") == "single":
        chosen["contact"]["tolerance"] = 1e-4
    return chosen


def refusal(names):
    """Return the sentence by which settings are refused together, nothing where they are admitted."""
    try:
        resolve(sections(names))
    except SettingsError as error:
        return str(error)
    return "where the map is known" if any(pair <= {*complete(names)} for pair in APART) else ""


@cache
def covering():
    """Return cases, tuples of names, in which every pair that is admitted occurs, and the refused pairs."""
    pairs = {frozenset(pair) for pair in itertools.combinations(SETTINGS, 2)}
    refused = {pair: text for pair in pairs if (text := refusal(pair))}
    remaining, cases = pairs - refused.keys(), []

    def met(names):
        return {frozenset(pair) for pair in itertools.combinations(names, 2)}

    while remaining:
        case = [*min(remaining, key=sorted)]
        for name in SETTINGS:
            present, longer = {*complete(case)}, complete([*case, name])
            added = itertools.product({*longer} - present, longer)
            if any(frozenset(pair) in remaining for pair in added) and not refusal([*case, name]):
                case.append(name)
        cases.append(complete(case))
        remaining -= met(cases[-1])
    # the fewest of them, those first that meet most pairs
    pairs_of, remaining, chosen = {case: met(case) for case in cases}, pairs - refused.keys(), []
    while remaining:
        chosen.append(max(cases, key=lambda case: len(pairs_of[case] & remaining)))
        remaining -= pairs_of[chosen[-1]]
    return chosen, refused


def names_in(model, where=""):
    """Yield the name of each setting of a model, in the groups within it as well."""
    for key, field in model.model_fields.items():
        groups = sections_of_type(field.annotation)
        for group in groups:
            yield from names_in(group, f"{where}{key}.")
        if not groups:
            yield f"{where}{key}"


def sections_of_type(annotation):
    """Return the groups of settings that a type holds."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return [annotation]
    return [group for part in get_args(annotation) for group in sections_of_type(part)]


ALL_NAMES = {name for name in names_in(Settings) if name != "contact.bodies.relaxation"}
ALL_NAMES |= {f"contact.bodies.relaxation.{key}" for key in RELAXATION_KEYS}


def stated(value, where=""):
    """Return the names of the settings that sections state."""
    if where in ALL_NAMES:
        return {where}
    entries = value.items() if isinstance(value, Mapping) else [("", entry) for entry in value]
    return set().union(*(stated(entry, ".".join(filter(None, [where, key]))) for key, entry in entries))


def test_every_pair_of_settings_meets_in_a_case_or_is_refused():
    """Of all settings of the models: one that is added without a value here fails."""
    cases, refused = covering()
    assert len(cases) <= len(NUMBERS)
    of_cases = [stated(sections(names)) for names in cases]
    assert set().union(*of_cases) == ALL_NAMES - WITHOUT_NUMBER.keys()
    met = {pair for names in of_cases for pair in itertools.combinations(sorted(names), 2)}
    parts = {name: stated(sections([name])) for name in SETTINGS}
    apart = {pair for first, second in refused for pair in itertools.product(parts[first], parts[second])}
    for pair in itertools.combinations(sorted(set().union(*of_cases)), 2):
        assert pair in met or pair in apart or pair[::-1] in apart, pair


def test_a_pair_that_is_refused_is_told_by_name():
    for (first, second), text in covering()[1].items():
        keys = {name.rpartition(".")[2] for name in stated(sections([first])) | stated(sections([second]))}
        assert "where the map is known" in text or any(key in text for key in keys), (first, second, text)


FEW = 4  # cases that meet four fifths of the pairs, of settings that exclude one another one each
NUMBERS = [pytest.param(number, marks=[pytest.mark.slow] * (number >= FEW)) for number in range(27)]


def case_of(number):
    """Return the names of a case, of which there may be fewer than numbers."""
    cases, _ = covering()
    if number >= len(cases):
        pytest.skip("fewer cases meet all pairs")
    return cases[number]


def evaluated(names, *, transposed=False, unit=1.0, extra=None, **options):
    """Return the statistics of the map by the settings of some names, and those of what follows a contact."""
    chosen, names = sections(names, **options), complete(names)
    if transposed:
        chosen.get("form", {}).get("radius", []).reverse()
    for section, values in (extra or {}).items():
        chosen[section] = chosen.get(section, {}) | values
    full = resolve(chosen)[""]
    if transposed:
        angles = full["sliding"]["direction"]
        full["sliding"]["direction"] = [90.0 - angle for angle in angles]  # the same of the face
    height, overviews = measured(transposed, unit), []
    further, fields = {}, FILES / "contact.nc"
    with warnings.catch_warnings(), pytest.MonkeyPatch.context() as patch:
        warnings.simplefilter("ignore")
        if "overview" in names:
            overviews = [field_around(transposed, unit)]
        if "composite" in names:  # of faces that are levelled one by one
            height = pair_of_faces(full, unit)
            patch.setattr(MapPreparation, "level", lambda self, height, options: height)
        chain = run_chain(
            height, full, overviews=overviews, fields=fields if "contact.unload" in names else None
        )
        heaviest = float(chain.statistics["mean_pressure"].max())
        for prefix, name, run in (("worn", WEAR, worn_in_a_run), ("slid", SLIDING, slid_in_a_run)):
            if name in names:
                load = full[name.partition(":")[0].partition(".")[0]]["mean_pressure"] or heaviest
                further[prefix] = run(Face(chain.window), full, mean_pressure=load)
        if "contact.unload" in names:
            with xr.open_dataset(fields) as contact:
                further["left"] = evaluate_unloading(contact.load(), chain.window, full)
    maps = {"height", "pressure", "gap", "plastic_depth"}
    renamed = [
        data.drop_vars(maps, errors="ignore").rename(
            {name: f"{prefix} {name}" for name in {*data.variables, *data.dims} - maps}
        )
        for prefix, data in further.items()
    ]
    return chain.statistics.assign({key: value for data in renamed for key, value in data.variables.items()})


@pytest.fixture(scope="module")
def results():
    """The numbers of each case, computed once."""
    return cache(evaluated)


def law_of(name):
    """Return how a number scales, None of one that says nothing of the surface."""
    kind = kind_of(re.sub("_after$|_after(?=_(lower|upper)$)", "", name.rpartition(" ")[2]))
    if found := FURTHER_LAWS.get(name) or FURTHER_LAWS.get(kind):
        return found
    return None if kind in OF_THE_SOLVER | NO_NUMBER else LAWS[kind]


def lawful(dataset):
    return [str(name) for name, data in dataset.variables.items() if data.dtype.kind == "f" and law_of(name)]


@pytest.mark.parametrize("number", NUMBERS)
def test_another_system_of_units_gives_the_same_numbers(results, number):
    names = case_of(number)
    check_units(names, results(names))


def check_units(names, reference):
    """Assert that the numbers of a case, in another system of units, are the same."""
    converted = evaluated(names, unit=LENGTHS, units=(LENGTHS, MODULI))
    # what is closed is so by the size of molecules and by a leak that counts as none, which no unit changes
    for name in set(lawful(reference)) - {"sealing_known"}:
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
BY_PLACES = {"composite"}  # which are drawn along y, then along x
DATASETS = {WEAR, SLIDING, "contact.unload"}  # computed from what the others give
ALONE = {"overview"}  # of intervals
NOT_NEUTRAL = {
    FREE: {LAYERS},  # further positions of a body with layers are not solved
    "contact.bodies.base": {LAYERS},
    # single points, which members of a tolerance of 1e-3 close or not, are a hundredth of their area
    "composite": {"instrument.noise", "instrument.tip_radius"},
    "instrument.correct": {"instrument.noise", "instrument.tip_radius"},  # they limit what is corrected
}
# of members, which are solved less exactly
ENDINGS = ("lower", "upper", "uncertainty", "estimate", "components", "parts", "known", "joint", "alone")


def by_members(name):
    """Whether a number is corrected, or of an interval, in which finer pixels and parts have a share."""
    name = re.sub("_after$|_after(?=_(lower|upper)$)", "", name)
    return name.startswith("local_") or name.endswith((*ENDINGS, *HEADLINE, "max_pressure_over_modulus"))


def same_or_unknown(actual, expected, name):
    """Whether two numbers are one where the second is known, those of intervals to a hundredth.

    Members are solved to 1e-3, and what they say of finer pixels and other places is extrapolated.
    Half-widths are differences of two of them, between which one point of a thousand may close.
    """
    is_known = np.isfinite(expected)
    if by_members(name):
        share = 0.05 if name.endswith("_uncertainty") else 0.01
        atol = share * np.abs(expected[is_known]).max(initial=0.0)
        np.testing.assert_allclose(actual[is_known], expected[is_known], rtol=0.01, atol=atol, err_msg=name)
    else:
        same(actual[is_known], expected[is_known], name)


@pytest.mark.parametrize("number", NUMBERS)
def test_the_numbers_of_a_transposed_map_are_transposed(number):
    check_transposed(case_of(number))


def check_transposed(names):
    """Assert that a case gives the transposed numbers of a transposed map."""
    symmetric = tuple(name for name in names if name not in BY_ROWS | BY_PLACES | ALONE)
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


@pytest.mark.parametrize("number", NUMBERS)
def test_what_is_stated_to_do_nothing_changes_nothing(number):
    check_neutral(case_of(number))


def check_neutral(names):
    """Assert that neither a neutral value changes a number, nor what is asked for besides."""
    adding = {name for name in names if SETTINGS[name].adds}
    adding |= {name for name in names if adding & {*SETTINGS[name].needs}}
    neutral = {name for name in names if SETTINGS[name].neutral is not None}
    neutral -= set().union(*(NOT_NEUTRAL.get(name, set()) for name in names))
    plain = evaluated(tuple(name for name in names if name not in neutral | adding))
    # between more loads corrections are interpolated, and the heaviest says which part is refined
    left_out = DATASETS | {"contact.target_area", "contact.target_gap", "contact.target"}
    left_out |= {name for name in names if left_out & {*SETTINGS[name].needs}}
    with_neutral = evaluated(tuple(name for name in names if name not in left_out), neutral=neutral)
    # without the load of a target; of a force over an area it has another last digit
    stated = np.isclose(with_neutral["mean_pressure"], plain["mean_pressure"].values[0], rtol=1e-12)
    with_neutral = with_neutral.isel(load=stated)
    for name in lawful(plain):
        # on a mirrored map the flow across is rounding, and equal points share the largest stress
        exceptions = ("sensitivity", "components", "flow_factor_xy", "von_mises_x", "von_mises_y")
        exceptions += ("depth", "von_mises_profile")  # depths are also those of interfaces
        exceptions += ("sealing_known",) * (SEAL in adding)  # with a fluid a gap is closed that hardly leaks
        if name in with_neutral and not name.endswith(exceptions):
            same_or_unknown(with_neutral[name].values, plain[name].values, name)


def test_a_noise_of_a_picometre_leaves_the_precision_of_a_rubber_as_it_is():
    """What the wider tolerance of members leaves open is none of its effects."""
    plain, noisy = (
        evaluated(names, neutral={"instrument.noise"})
        for names in ((BODIES, SERIES), (BODIES, SERIES, "instrument.noise"))
    )
    for name in plain:
        if name.endswith("_known"):
            np.testing.assert_allclose(noisy[name], plain[name], rtol=1e-3, err_msg=name)


@pytest.mark.parametrize("number", NUMBERS)
def test_intervals_stay_within_what_is_possible(results, number):
    check_intervals(results(case_of(number)))


def check_intervals(numbers):
    """Assert that answers and their intervals are possible, and agree with one another."""
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


TRIPLES = [
    pytest.param(number, marks=[pytest.mark.slow] * (number >= 12)) for number in range(200)
]  # each a seed


def random_triple(seed):
    """Return three settings that are admitted together, with those that they need.

    A lens has the wavelength of its light, which by default is a length that no system of units changes. A
    body has edges, because some of these touch up to the border of their map.
    """
    choose = random.Random(seed)
    while True:
        triple = choose.sample([*SETTINGS], 3)
        if LENS in triple:
            triple.append("instrument.wavelength")
        if FREE in complete(triple):
            triple.append("form.edges")
        if not refusal(triple):
            return complete(triple)


@pytest.mark.parametrize("seed", TRIPLES)
def test_three_settings_obey_the_laws_of_two(seed):
    """In the cases of pairs many settings meet, and one may hide what another one changes."""
    names = random_triple(seed)
    numbers = evaluated(names)
    check_intervals(numbers)
    laws = (
        lambda: check_units(names, numbers),
        lambda: check_neutral(names),
        lambda: check_transposed(names),
    )
    laws[seed % len(laws)]()
