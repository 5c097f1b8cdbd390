"""Running-in in a run: the ± of its answers, and its part of the page."""

import numpy as np
import pytest
from known_surfaces import self_affine

import roughcontact as rc
from roughcontact.arguments.answers import AREA
from roughcontact.arguments.quantities import number
from roughcontact.evaluation.courses import FEW_STEPS, WORN, Face, levelled_parts, worn_in_a_run
from roughcontact.report.courses import course_sections
from roughcontact.results.storage import write_dataset
from roughcontact.uncertainty.combination import SOURCES
from roughcontact.uncertainty.scales import to_scale

LOAD, WEAR = 5e6, 1e-15


def face(points=96, seed=3):
    return self_affine((points, points), 1e-6, (6e-6, 24e-6), rms_gradient=0.1, seed=seed)


def settings(window, *, factor=1.0):
    far = float(window.std()) / (WEAR * LOAD)
    wear = {
        "coefficient": WEAR,
        "coefficient_factor": factor,
        "distance": (far * np.geomspace(1e-2, 10, 7)).tolist(),
    }
    contact = {"contact_modulus": 1e9, "bodies": None, "hardness": None, "influence": "sampled"}
    contact |= {"zero_frequency": "zero"}
    sources = {"wear": wear, "uncertainty": {"sources": [*SOURCES]}}
    return sources | {"contact": contact, "statistics": {"flow": "never"}, "instrument": {}}


@pytest.fixture(scope="module")
def worn():
    window = face()
    return worn_in_a_run(Face(window), settings(window), mean_pressure=LOAD)


def test_the_interval_holds_another_face_of_the_same_finish(worn):
    """Faces of one spectrum: nearly all answers of a second one lie within both their intervals together."""
    other = face(seed=4)
    options = settings(other)["wear"]
    again = rc.run_in(
        other,
        contact_modulus=1e9,
        mean_pressure=LOAD,
        wear_coefficient=WEAR,
        sliding_distance=[0.0, *worn["sliding_distance"].values[1:].tolist()],
        statistics={"flow": "never"},
    )
    assert options["distance"][0] == pytest.approx(float(worn["sliding_distance"][1]), rel=0.2)
    inside = []
    for name in WORN[:-1]:
        middle, lower, upper = (
            to_scale(name, worn[f"{name}{end}"].values) for end in ("", "_lower", "_upper")
        )
        apart = to_scale(name, again[name].values) - middle
        known = worn["relative_contact_area"].values < 0.99  # beyond, all faces are flat
        assert known.sum() >= 5, name
        assert (lower <= middle)[known].all()
        inside += [*(np.abs(apart) <= np.sqrt(2) * (upper - middle))[known]]
    assert np.mean(inside) > 0.85


def test_the_coefficient_moves_the_distances_alone(worn):
    window = face()
    wider = worn_in_a_run(Face(window), settings(window, factor=3.0), mean_pressure=LOAD)
    name = "running_in_distance"
    assert float(wider[f"{name}_lower"]) == pytest.approx(float(worn[f"{name}_lower"]) / 3)
    assert float(wider[f"{name}_upper"]) == pytest.approx(float(worn[f"{name}_upper"]) * 3)
    for answer in WORN[:-1]:
        np.testing.assert_array_equal(wider[f"{answer}_upper"], worn[f"{answer}_upper"])


def test_the_page_says_when_it_is_run_in(worn, tmp_path):
    write_dataset(worn, tmp_path / "worn.nc")
    part = course_sections("ground", worn, tmp_path, tmp_path)["wear"]
    (text,) = part["sentences"]
    low, high = (float(worn[f"running_in_distance_{end}"]) for end in ("lower", "upper"))
    assert low < float(worn["running_in_distance"]) < high
    low, middle, high = map(number, (low, float(worn["running_in_distance"]), high))
    assert text.startswith(f"Run in after about {middle} m ({low} to {high}): ")
    assert "the rms height below 1.00 nm, before " in text  # 6 pm: finer than atoms
    assert part["link"] == "worn.nc"
    assert [*part["images"]][:2] == [
        "heights before wear",
        f"heights after {worn['sliding_distance'].values[-1]:.3g} m",
    ]
    assert "contact area over the distance" in part["images"]
    # where a part of the map has no such distance
    unknown = {f"running_in_distance_{end}": np.nan for end in ("lower", "upper")}
    write_dataset(worn.assign(unknown), tmp_path / "worn.nc")
    (text,) = course_sections("ground", worn, tmp_path, tmp_path)["wear"]["sentences"]
    assert f"about {middle} m (without ±: a part of the map is not run in after " in text


@pytest.mark.parametrize(
    ("section", "stated", "again"),
    [
        ("contact", {"mean_pressure_uncertainty": 0.2}, {"mean_pressure": 1.2 * LOAD}),
        ("contact", {"contact_modulus_uncertainty": [0.1, 0.2]}, {"contact_modulus": 0.9e9}),
        ("instrument", {"amplification_z": 0.1}, {"heights": 0.9}),
    ],
)
def test_a_stated_range_is_part_of_the_interval(section, stated, again):
    """Its end, solved here on the part that stands for all, adds by its square where it enlarges the area."""
    window = face(points=48)
    full = settings(window)
    full["wear"]["distance"] = full["wear"]["distance"][2:4]
    exact, with_range = (
        worn_in_a_run(Face(window), full | {section: full[section] | each}, mean_pressure=LOAD)
        for each in ({}, stated)
    )
    part = levelled_parts(window)[0]
    options = {"wear_coefficient": WEAR, "sliding_distance": [0.0, *full["wear"]["distance"]]}
    options |= {"contact_modulus": 1e9, "mean_pressure": LOAD, "statistics": {"flow": "never"}} | FEW_STEPS
    changed = part.copy(data=again.pop("heights", 1.0) * part.values)
    solved, at_end = (
        to_scale(AREA, rc.run_in(each, **options | more)[AREA].values)
        for each, more in ((part, {}), (changed, again))
    )
    middle, *upper = (
        to_scale(AREA, result[name].values)
        for result, name in ((exact, AREA), (exact, f"{AREA}_upper"), (with_range, f"{AREA}_upper"))
    )
    width, wider = (end - middle for end in upper)
    np.testing.assert_allclose(wider, np.hypot(width, at_end - solved), rtol=1e-3)
    assert (wider > width).all()
