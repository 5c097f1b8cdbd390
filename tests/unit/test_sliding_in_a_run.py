"""Sliding rubber in a run: the ± of its answers, and its part of the page."""

import numpy as np
import pandas as pd
import pytest
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact.arguments.answers import AREA, FRICTION, GAP, PEAK
from roughcontact.arguments.quantities import number
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.evaluation.courses import SLID, Face, levelled_parts, slid_in_a_run
from roughcontact.kernels.fourier import wavenumbers
from roughcontact.report.courses import course_sections
from roughcontact.results.storage import write_dataset
from roughcontact.surface.faces.placing import overview_with_place
from roughcontact.surface.window.transfer import corrected as window_corrected
from roughcontact.surface.window.transfer import transfer
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.scales import to_scale

LOAD, SPEEDS = 5e4, [1e-3, 1e-2, 1e-1]


def face(points=96, seed=3):
    return self_affine((points, points), 1e-6, (6e-6, 24e-6), rms_gradient=0.1, seed=seed)


def table(highest=1e7):
    frequency = np.geomspace(1, highest, 60)
    phase = 2j * np.pi * frequency * 1e-4
    young = 3e6 + 27e6 * phase / (1 + phase)
    return pd.DataFrame({"frequency": frequency, "storage_modulus": young.real, "loss_modulus": young.imag})


def settings(highest=1e7):
    rubber = {"relaxation": table(highest), "poissons_ratio": 0.5, "thermal_conductivity": 0.25}
    return {
        "contact": {"bodies": [rubber, {"thermal_conductivity": 1.5}]},
        "sliding": {"speed": SPEEDS, "direction": 0.0},
        "statistics": {"friction": {"shear_strength": 1e6}, "seal": None},
        "instrument": {},
        "uncertainty": {"sources": [*SOURCES]},
    }


@pytest.fixture(scope="module")
def slid():
    return slid_in_a_run(Face(face()), settings(), mean_pressure=LOAD)


def test_the_sources_that_are_asked_for_add_up(slid):
    """On the logarithm by their squares; of none there is no interval."""
    full = settings()

    def upper(*sources):
        asked = full | {"uncertainty": {"sources": [*sources]}}
        course = slid_in_a_run(Face(face()), asked, mean_pressure=LOAD)
        return np.log(course[f"{FRICTION}_upper"].values / course[FRICTION].values)

    assert np.isnan(upper()).all()
    asked = ("solver", "discretisation", "window", "material")
    alone = [upper(source) for source in asked]
    assert all((width > 0).all() for width in alone[:3])  # the table of the relaxation leaves nothing out
    np.testing.assert_allclose(np.sqrt(np.sum(np.square(alone), axis=0)), upper(*asked), rtol=1e-9)
    np.testing.assert_allclose(np.log(slid[f"{FRICTION}_upper"] / slid[FRICTION]), upper(*asked), rtol=1e-9)


def test_the_interval_holds_other_faces_of_the_same_finish(slid):
    """Faces of one spectrum: nearly all answers lie within both their intervals together."""
    inside = []
    for seed in (4, 5, 6):
        again = rc.sliding_friction(
            face(seed=seed), relaxation=table(), speed=SPEEDS, mean_pressure=LOAD, tolerance=1e-3
        )
        for name in SLID:
            middle, lower, upper = (
                to_scale(name, slid[f"{name}{end}"].values) for end in ("", "_lower", "_upper")
            )
            assert (np.diff([lower, middle, upper], axis=0) > 0).all(), name
            apart = to_scale(name, again[name].values) - middle
            inside += [*(np.abs(apart) <= np.sqrt(2) * (upper - middle))]
    assert np.mean(inside) > 0.85


@pytest.mark.parametrize(("name", "factor"), [(AREA, 0.8), (PEAK, 1.2)])
def test_a_range_of_the_modulus_is_part_of_the_interval(name, factor):
    """Its end, solved here with another rubber on the part that stands for all, adds by its square."""
    window, full = face(points=48), settings()
    stated = {"contact_modulus_uncertainty": 0.2}
    exact, with_range = (
        slid_in_a_run(Face(window), full | {"contact": full["contact"] | each}, mean_pressure=LOAD)
        for each in ({}, stated)
    )
    part, rubber = levelled_parts(window)[0], table()
    moduli = ["storage_modulus", "loss_modulus"]
    other = rubber.assign(**{key: factor * rubber[key] for key in moduli})
    solved, at_end = (
        rc.sliding_friction(part, relaxation=each, speed=SPEEDS, mean_pressure=LOAD, tolerance=1e-3)[name]
        for each in (rubber, other)
    )
    middle, width, wider = (
        to_scale(name, result[key].values)
        for result, key in ((exact, name), (exact, f"{name}_upper"), (with_range, f"{name}_upper"))
    )
    expected = np.hypot(width - middle, to_scale(name, at_end.values) - to_scale(name, solved.values))
    np.testing.assert_allclose(wider - middle, expected, rtol=0.01)
    assert (wider > width).all()


@pytest.mark.cases
def test_a_hardness_that_sliding_rubber_would_not_have_is_refused(rubber, contact, refused):
    series = {"long_time_modulus": 3e6, "moduli": [27e6], "times": [1e-4]}
    bodies = [{"relaxation": series} | rubber, "steel"]
    sections = {"contact": {"bodies": bodies, "mean_pressure": 1e5} | contact, "sliding": {"speed": 0.1}}
    if refused:
        with pytest.raises(
            rc.SettingsError, match=r"sliding.speed: .* and the hardness is 5e\+06 Pa; leave it"
        ):
            resolve(sections)
    else:
        assert resolve(sections)[""]["contact"]["hardness"] > 1e9


def test_the_friction_by_the_area_has_the_range_of_the_shear_strength():
    """Independent of the interval of the area, whose distance on the logarithm it adds to by squares."""
    window, full = face(points=48), settings()
    friction = {"shear_strength": 1e6, "shear_strength_uncertainty": [0.2, 0.5]}
    stated = full | {"statistics": {"friction": friction, "seal": None}}
    exact, ranged = (slid_in_a_run(Face(window), each, mean_pressure=LOAD) for each in (full, stated))
    name = "adhesive_friction_coefficient"
    for end, factor in (("lower", 0.8), ("upper", 1.5)):
        by_area = np.log(exact[f"{AREA}_{end}"] / exact[AREA])
        np.testing.assert_allclose(np.log(exact[f"{name}_{end}"] / exact[name]), by_area)
        both = np.abs(np.log(ranged[f"{name}_{end}"] / ranged[name]))
        np.testing.assert_allclose(both, np.hypot(by_area, np.log(factor)))


def test_what_the_table_does_not_reach_is_in_the_interval(slid):
    short = slid_in_a_run(Face(face()), settings(highest=5e2), mean_pressure=LOAD)
    share = short["friction_share_beyond_table"].values
    assert share[2] > 0.5 > slid["friction_share_beyond_table"].values[2]
    half = np.log(short[f"{FRICTION}_upper"] / short[FRICTION]).values
    assert (half >= share).all()


@pytest.mark.parametrize("position", ["36 36 um", pytest.param("elsewhere", marks=pytest.mark.slow)])
def test_an_overview_adds_what_other_places_of_the_surface_change(position):
    """Nine fields of long waves, of which a map shows one: the mean of all, solved, is in its interval.

    Of 16 such surfaces the intervals hold 0.83 of the frictions without it, 0.65 of the gaps; with it all.
    """
    points, whole = 72, self_affine((216, 216), 1e-6, (6e-6, 1.2e-4), rms_gradient=0.1, hurst=0.7, seed=0)
    begins = range(0, 216, points)
    fields = [
        rc.level(whole.isel(y=slice(y, y + points), x=slice(x, x + points))) for y in begins for x in begins
    ]
    coarse = overview_with_place(fields[0], rc.level(whole.coarsen(y=3, x=3).mean()), position)
    rubber = {"relaxation": table(), "speed": SPEEDS, "mean_pressure": LOAD, "tolerance": 1e-3}
    everywhere = [rc.sliding_friction(rc.periodic_window(field), fields=False, **rubber) for field in fields]
    window = rc.periodic_window(fields[0])
    alone = slid_in_a_run(Face(window), settings(), mean_pressure=LOAD)
    both = slid_in_a_run(Face(window, None, fields[0], [coarse]), settings(), mean_pressure=LOAD)
    for name in (FRICTION, AREA, GAP):
        mean = np.mean([to_scale(name, of_field[name].values) for of_field in everywhere], axis=0)
        lower, upper = (to_scale(name, both[f"{name}_{end}"].values) for end in ("lower", "upper"))
        assert (lower <= mean).all(), name
        assert (mean <= upper).all(), name
        width = [np.log(each[f"{name}_upper"] / each[f"{name}_lower"]) for each in (alone, both)]
        assert (width[1] > width[0]).all(), name
    np.testing.assert_array_equal(both[f"{PEAK}_upper"], alone[f"{PEAK}_upper"])


@pytest.mark.parametrize("corrected", [False, True])
def test_the_interval_of_a_noisy_blurred_map_holds_what_it_is_without(slid, corrected):
    """Noise of 4 % of Sq and a Gaussian of 4 pixels; the friction of the face itself is that of `slid`."""
    clean, noise, resolution = face(), 0.04 * float(face().std()), 4e-6
    q = wavenumbers(clean.shape, (1e-6, 1e-6)) / (2 * np.pi)
    blurred = np.fft.irfft2(np.fft.rfft2(clean) * transfer(q, {"resolution": resolution}), s=clean.shape)
    measured = clean.copy(data=blurred + noise * np.random.default_rng(1).standard_normal(clean.shape))
    instrument = {"noise": noise, "resolution": resolution}
    stated, unstated = (settings() | {"instrument": each} for each in (instrument, {}))
    if corrected:
        both_maps = Face(window_corrected(measured, instrument), measured)
        again = slid_in_a_run(both_maps, stated, mean_pressure=LOAD)
    else:
        again = slid_in_a_run(Face(measured), stated, mean_pressure=LOAD)
        alone = slid_in_a_run(Face(measured), unstated, mean_pressure=LOAD)
        assert (
            again[f"{FRICTION}_upper"] - again[f"{FRICTION}_lower"]
            > 1.05 * (alone[f"{FRICTION}_upper"] - alone[f"{FRICTION}_lower"])
        ).all()
    for name in SLID:
        assert (again[f"{name}_lower"] <= slid[name]).all(), name
        assert (slid[name] <= again[f"{name}_upper"]).all(), name


def test_the_page_says_where_friction_is_highest(slid, tmp_path):
    write_dataset(slid, tmp_path / "sliding.nc")
    part = course_sections("ground", slid, tmp_path, tmp_path)["sliding"]
    (text,) = part["sentences"]
    speed = SPEEDS[int(slid[FRICTION].values.argmax())]
    assert f"the friction of the hysteresis is highest at {speed:.2g} m/s, μ" in text.replace(
        "0.0100", "0.01"
    )
    at_speed = slid.isel(speed=int(slid[FRICTION].values.argmax()))
    by_area = (at_speed[f"adhesive_friction_coefficient{end}"] for end in ("", "_lower", "_upper"))
    middle, low, high = (number(float(value)) for value in by_area)
    assert f"whose shear strength alone would make μ = {middle} ({low} to {high}). " in text
    assert "Proven: the solver leaves no error of μ above" in text
    assert "Waves up to 4.00 µm, the shortest octave that was measured, make " in text
    assert "The friction warms the contact by less than 10 K at all speeds." in text
    assert part["link"] == "sliding.nc"
    hot = slid.assign(max_flash_temperature=("speed", [1.0, 100.0, 1e4]))
    write_dataset(hot, tmp_path / "sliding.nc")
    (text,) = course_sections("ground", hot, tmp_path, tmp_path)["sliding"]["sentences"]
    from_speed = number(10**-2.5)  # half way between 1 mm/s and 10 mm/s
    assert f"by up to 10 K from {from_speed} m/s on" in text
    assert [*part["images"]][:3] == [
        "coefficient of friction over the speed",
        f"pressure at {speed:.3g} m/s",
        "share of the friction by wavelength",
    ]


@pytest.mark.parametrize(
    ("speeds", "words"), [([0], "only"), ([0, 1], "fastest"), ([1, 2], "slowest"), ([0, 1, 2], "")]
)
def test_a_friction_that_is_highest_at_an_end_of_the_speeds_says_so(slid, tmp_path, speeds, words):
    assert int(slid[FRICTION].values.argmax()) == 1
    write_dataset(slid.isel(speed=speeds), tmp_path / "sliding.nc")
    (text,) = course_sections("ground", slid, tmp_path, tmp_path)["sliding"]["sentences"]
    assert f" m/s, the {words} speed, μ = " in text or not words
    assert text.count(" speed, ") == bool(words)


def test_both_ways_have_their_own_intervals_and_are_side_by_side_on_the_page(tmp_path):
    window, full = face(points=48), settings()

    def slid_along(angles):
        return slid_in_a_run(
            Face(window), full | {"sliding": full["sliding"] | {"direction": angles}}, mean_pressure=LOAD
        )

    both, back = slid_along([0.0, 180.0]), slid_along([180.0])
    for name in (FRICTION, f"{FRICTION}_lower", f"{FRICTION}_upper", f"{GAP}_upper"):
        np.testing.assert_array_equal(both[name].sel(direction=180), back[name])
        assert not np.allclose(both[name][0], back[name], rtol=1e-4, atol=0), name
    write_dataset(both, tmp_path / "sliding.nc")
    (text,) = course_sections("ground", both, tmp_path, tmp_path)["sliding"]["sentences"]
    highest = both[FRICTION].max("speed")
    first = int(highest.argmax())
    assert f" in the direction {180 * first}°, μ = {number(highest[first].item())} (" in text
    assert f"; at {180 - 180 * first}° μ = {number(highest[1 - first].item())} (" in text


def test_a_direction_of_the_settings_may_be_both_ways():
    series = {"long_time_modulus": 3e6, "moduli": [27e6], "times": [1e-4]}
    sections = {"contact": {"bodies": [{"relaxation": series}, "steel"], "mean_pressure": 1e5}}

    def directions(stated):
        return resolve(sections | {"sliding": {"speed": 0.1, "direction": stated}})[""]["sliding"][
            "direction"
        ]

    assert directions("both ways") == [0.0, 180.0]
    assert directions("30 deg") == [30.0]
    assert directions([0, "1.5707963267948966 rad"]) == pytest.approx([0, 90])
    with pytest.raises(rc.SettingsError, match=r"sliding\.direction: give each direction once"):
        directions([30, 30])
