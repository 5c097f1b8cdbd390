"""An overview as a control variate: what it shows of other places, against the surface that is known."""

import numpy as np
import pytest
import xarray as xr

import roughcontact as rc
from roughcontact import HeightMapError, self_affine_surface
from roughcontact.surface.faces.placing import overview_with_place, recorded_place
from roughcontact.surface.preparation.region import read_overview
from roughcontact.uncertainty.calibration import overview_arms, table
from roughcontact.uncertainty.combination import uncertainty_table
from roughcontact.uncertainty.differences import compare_maps
from roughcontact.uncertainty.ensemble import Result, solve_member
from roughcontact.uncertainty.overview import (
    GRADIENT,
    Transfer,
    View,
    field_ratios,
    transfers_of,
    window_of_place,
    windows_of_places,
)
from roughcontact.uncertainty.scales import AREA, CONDUCTANCE, GAP, to_scale

PITCH = 1e-6
NAMES = (AREA, GAP, "conductance_per_conductivity")
PLACE = (slice(96, 192), slice(96, 192))
SOURCES = {"sources": ["solver", "discretisation", "window"]}


@pytest.fixture(scope="module")
def field():
    """Return a rough field of 3 x 3 maps, whose longest waves one map does not hold."""
    options = {"hurst": 0.8, "shortest": 6 * PITCH, "longest": 250 * PITCH, "rms_height": 1e-6, "seed": 11}
    return self_affine_surface((360, 360), PITCH, **options)[:288, :288]


@pytest.fixture(scope="module")
def answers(field):
    """Return the statistics of the middle of the field by itself, and with the field at a quarter."""
    load = {"contact_modulus": 1e9, "relative_pressure": [0.02, 0.1], "uncertainty": SOURCES}
    overview = field.coarsen(y=3, x=3).mean()
    return [rc.evaluate(field[PLACE], overview=each, **load) for each in (None, overview)]


def test_it_moves_the_gap_towards_that_of_the_other_places_and_narrows_it(field, answers):
    alone, both = answers
    loads = {"contact_modulus": 1e9, "mean_pressure": alone["mean_pressure"].values}
    parts = [field[y : y + 96, x : x + 96] for y in (0, 96, 192) for x in (0, 96, 192)]
    windows = [rc.periodic_window(rc.level(part)) for part in parts]
    truth = np.mean([to_scale(GAP, solve_member(w, loads, names=[GAP])[GAP]) for w in windows], axis=0)
    errors = [np.abs(np.log(each["mean_gap"].values) - truth) for each in answers]
    assert (errors[1] < errors[0]).all()
    assert errors[1] == pytest.approx(0, abs=0.1)
    widths = [np.log(each["mean_gap_upper"] / each["mean_gap_lower"]).values for each in answers]
    assert (widths[1] < 0.6 * widths[0]).all()
    low, high = (np.log(both[f"mean_gap_{end}"].values) for end in ("lower", "upper"))
    assert ((low < truth) & (truth < high)).all()


def test_a_joint_that_flows_touches_at_least_on_load_over_hardness(field):
    around = np.pad(np.ones((96, 96)), 96, constant_values=3.0)  # rougher than the map
    load, hardness = 5e6, 5e7
    found = rc.evaluate(
        field[PLACE],
        overview=(field * around).coarsen(y=3, x=3).mean(),
        uncertainty={"sources": ["window"]},
        contact={"contact_modulus": 1e9, "mean_pressure": [load], "hardness": hardness},
    )
    joint = found["relative_contact_area_joint"].item()
    assert joint >= load / hardness * (1 - 1e-12)
    assert found["relative_contact_area_joint_lower"].item() <= joint * (1 + 1e-12)


def test_the_joint_as_large_as_the_overview_is_an_answer_of_its_own(field, answers):
    _, both = answers
    loads = {"contact_modulus": 1e9, "mean_pressure": both["mean_pressure"].values}
    whole = solve_member(rc.periodic_window(rc.level(field)), loads, names=[GAP])[GAP]
    assert np.log(both["mean_gap_joint"].values / whole) == pytest.approx(0, abs=0.15)
    assert (both["mean_gap_joint_lower"] < whole).all()
    assert (whole < both["mean_gap_joint_upper"]).all()


def test_what_this_map_gives_by_itself_stays_in_the_result(answers):
    alone, both = answers
    for end in ("lower", "upper"):
        assert np.allclose(both[f"mean_gap_alone_{end}"], alone[f"mean_gap_{end}"], rtol=1e-6)
        assert np.allclose(both[f"mean_gap_map_{end}"], alone[f"mean_gap_map_{end}"], rtol=1e-6)
    assert both["mean_gap_as_solved"].values == pytest.approx(alone["mean_gap_as_solved"].values)


def test_further_places_are_promised_to_narrow_it_with_overviews_of_their_own(answers):
    for each, has_overview in zip(answers, (False, True), strict=True):
        assert "more place" in each.attrs["halve"]
        for words in (each.attrs["halve"], each.attrs["places"]):
            assert ("of this size, each with its overview" in words) == has_overview


def test_stiffness_and_conductance_stay_one_number(answers):
    for each in answers:
        ratio = each["contact_stiffness"] / each["conductance_per_conductivity"]
        assert ratio.values == pytest.approx(1e9)


def test_one_line_says_what_it_has_brought(answers):
    alone, both = answers
    assert "overview" not in alone.attrs
    assert both.attrs["overview"].startswith("gap known to ")
    assert "without the overview" in both.attrs["overview"]
    assert "3.0 × 3.0 fields" in both.attrs["window_reason"]
    assert both.attrs["overview_correlation"] > 0.99
    offsets = [both.attrs[f"overview_offset_{axis}"] for axis in "xy"]
    assert offsets == pytest.approx([96 * PITCH] * 2, abs=PITCH)
    assert both.attrs["overview_scale"] == pytest.approx(1, abs=0.02)  # of 32 points


def test_gap_and_conductance_are_narrower_and_the_largest_pressure_stays(answers):
    alone, both = answers
    assert both["max_pressure"].values == pytest.approx(alone["max_pressure"].values)
    for end in ("lower", "upper"):  # its arms are read at the area, which the overview moves
        of_peak = [each[f"max_pressure_{end}"].values for each in answers]
        assert of_peak[1] == pytest.approx(of_peak[0], rel=1e-2)
    for name in NAMES[1:]:  # at light loads the area is not
        ends = [both[f"{name}{key}_{end}"].values for key in ("", "_alone") for end in ("lower", "upper")]
        low, high, low_alone, high_alone = (to_scale(name, each) for each in ends)
        assert (high - low <= (high_alone - low_alone) * (1 + 1e-9)).all()


@pytest.fixture(scope="module")
def of_some(field):
    """Return what several overviews, and those of other positions, leave of the gap (its estimate, width)."""
    load = {"contact_modulus": 1e9, "relative_pressure": [0.1], "uncertainty": SOURCES}
    coarse, coarser = (field.coarsen(y=n, x=n).mean() for n in (3, 4))
    kinds = {
        "around": ([coarse], ""),
        "two": ([coarse, coarser], ""),
        "elsewhere": ([coarse], "elsewhere"),
        "alike": ([coarse, coarse], "; elsewhere"),
        "stated": ([coarse], "144 144 um"),
    }
    found = {
        key: rc.evaluate(field[PLACE], overview=overviews, overview_position=position, **load)
        for key, (overviews, position) in kinds.items()
    }
    return {
        key: (
            float(each["mean_gap"][0]),
            float(np.log(each["mean_gap_upper"] / each["mean_gap_lower"])[0]),
            each.attrs["window_reason"],
        )
        for key, each in found.items()
    }


def test_a_load_has_the_interval_by_an_overview_that_it_has_alone(answers, of_some):
    beside_another = answers[1].isel(load=1)
    width = float(np.log(beside_another["mean_gap_upper"] / beside_another["mean_gap_lower"]))
    assert of_some["around"][:2] == pytest.approx((float(beside_another["mean_gap"]), width), rel=1e-5)


def test_two_overviews_are_averaged(of_some):
    (gap, width, reason), (one, width_of_one, _) = of_some["two"], of_some["around"]
    assert gap == pytest.approx(one, rel=0.1)
    assert gap != one
    assert 0.5 * width_of_one < width < 2 * width_of_one
    assert reason.count("An overview") == 2


def test_one_of_another_position_counts_with_its_larger_interval(of_some):
    (gap, width, reason), (placed_gap, placed_width, _) = of_some["elsewhere"], of_some["around"]
    assert gap == pytest.approx(placed_gap, rel=0.1)  # no lens lies between them
    assert width > 1.2 * placed_width
    assert "another position of the face" in reason


def test_one_of_another_position_is_held_against_one_around_the_map_with_its_pixels(of_some):
    assert of_some["alike"][:2] == pytest.approx(of_some["around"][:2], rel=1e-6)


def test_a_stated_place_is_that_which_is_found(of_some):
    assert of_some["stated"][:2] == pytest.approx(of_some["around"][:2], rel=1e-6)


def test_places_are_windows_as_large_as_the_map(field):
    fine, overview = rc.level(field[PLACE]), rc.level(field.coarsen(y=3, x=3).mean())
    shown = overview_with_place(fine, overview)
    own = window_of_place(fine, shown, recorded_place(shown))
    places = windows_of_places((32, 32), shown)
    assert own == {"y": slice(32, 64), "x": slice(32, 64)}
    assert len(places) == 9
    assert {(each["y"].stop - each["y"].start) for each in places} == {32}
    assert field_ratios(fine, shown) == pytest.approx((3, 3))


def test_what_an_overview_shows_has_no_unit(field):
    fine, overview = rc.level(field[PLACE]), rc.level(field.coarsen(y=3, x=3).mean())
    window = rc.periodic_window(fine)
    contact = {"contact_modulus": 1.0, "mean_pressure": [0.01, 0.03]}
    result = Result(window, contact, solve_member(window, contact, names=NAMES))
    shown = overview_with_place(fine, overview)
    own = shown.isel(window_of_place(fine, shown, recorded_place(shown)))
    transfers = transfers_of(result, 1, own, shown, {})
    assert set(transfers) == {*NAMES, GRADIENT}
    for transfer in transfers.values():
        assert np.isfinite(np.array(transfer)).all()
        assert (transfer.places > 0).all()
    scaled = Result(window, contact | {"contact_modulus": 5.0, "mean_pressure": [0.05, 0.15]}, result.values)
    again = transfers_of(scaled, 1, own, shown, {})
    assert again[GAP].surface == pytest.approx(transfers[GAP].surface, abs=2e-3)


def test_a_gap_follows_its_overview_where_the_conductance_is_not_known():
    """As of layered bodies: the other changes count, and the conductance tells nothing."""
    one, unknown = np.ones(2), np.full(2, np.nan)
    transfers = {name: Transfer(one, one, 0.1 * one, 0.2 * one) for name in (GAP, CONDUCTANCE, GRADIENT)}
    both = View(transfers, 4.0, True, 9.0)
    of_layers = View(transfers | {CONDUCTANCE: Transfer(unknown, unknown, unknown, unknown)}, 4.0, True, 9.0)
    area = np.array([0.02, 0.1])
    shares = table()["overview"]["surface"][GAP]["4"]["shares"]
    for view, count in ((both, sum(shares)), (of_layers, sum(shares) - shares[1])):
        centre, down, up = view.numbers("surface", GAP, area, np.log(0.1))
        assert centre == pytest.approx(np.full(2, count))
        assert np.isfinite([down, up]).all()


def test_arms_between_the_pixels_of_the_bank_lie_between():
    known = table()["overview"]["surface"][GAP]
    area = np.array([0.1])
    ends = [overview_arms("surface", GAP, pixels, area) for pixels in (1.5, 2.0, 3.0, 4.0, 20.0, 8.0, 9.0)]
    assert ends[0][0] == pytest.approx(known["2"]["shares"])
    assert ends[1][0] == pytest.approx(known["2"]["shares"])
    assert (np.minimum(ends[1][0], ends[3][0]) <= ends[2][0]).all()
    assert (ends[2][0] <= np.maximum(ends[1][0], ends[3][0])).all()
    for side in (1, 2):
        low, middle, high = sorted(float(ends[index][side][0]) for index in (1, 2, 3))
        assert low <= middle <= high
        assert middle == pytest.approx(float(ends[2][side][0]))
        assert np.isinf(ends[4][side])  # the bank has no such pixels
        assert ends[6][side] == pytest.approx(ends[5][side])


def without_effect(field, place, pixels, **settings):
    """Hold a map with an overview that tells nothing against the same one without, and the words for it."""
    options = {"contact_modulus": 1e9, "relative_pressure": [0.1], "uncertainty": SOURCES} | settings
    overview = field.coarsen(y=pixels, x=pixels, boundary="trim").mean()
    position = {"overview_position": options.pop("overview_position", "")}
    alone = rc.evaluate(field[place], **options)
    both = rc.evaluate(field[place], overview=overview, **position, **options)
    assert both["mean_gap"].values == pytest.approx(alone["mean_gap"].values)
    assert "The overview counts for nothing: " in both.attrs["window_flag"]
    assert "The overview counts for nothing: " in both.attrs["reasons"]
    assert not [name for name in both if "_alone" in name or "_joint" in name]
    assert both["verdict"].item() > 0


@pytest.mark.parametrize(
    "settings",
    [{"uncertainty": {"sources": ["solver"]}}, {"window": {"shortest_wavelength": 25 * PITCH}}],
    ids=["without its source", "a map too small for parts"],
)
def test_an_overview_that_counts_for_nothing_says_so(field, settings):
    without_effect(field, PLACE, 3, **settings)


def test_an_overview_of_another_position_with_pixels_that_the_bank_does_not_know_says_so(field):
    without_effect(field, (slice(96, 216), slice(96, 216)), 6, overview_position="elsewhere")


def test_a_body_of_finite_size_has_no_overview(field):
    with pytest.raises(
        HeightMapError, match="overview: is of a map of a surface that goes on, not of a finite body"
    ):
        rc.evaluate(
            field[PLACE],
            overview=field.coarsen(y=3, x=3).mean(),
            contact_modulus=1e9,
            boundary="free",
            force=1e-3,
            form={"radius": 1e-3},
        )


def test_a_place_differs_from_itself_by_nothing_that_an_overview_shows(answers):
    alone, both = answers
    # in the file of a run a map has the variables of all others
    alone = alone.assign({name: np.nan * alone["mean_gap"] for name in both if name.endswith("_alone")})
    for pair in ((alone, both), (both, alone)):
        compared, _ = compare_maps({("a", "b"): pair}, of_place=[("a", "b")])
        table = compared["a", "b"].sel(quantity=[*NAMES, "mean_contact_pressure"])
        assert table["ratio"].values == pytest.approx(1, abs=1e-6)
        assert (table["ratio_lower"] <= 1).all()
        assert (table["ratio_upper"] >= 1).all()
    corrections = [
        uncertainty_table(each).query("quantity == 'mean_gap'").set_index(["mean_pressure_Pa", "source"])
        for each in (alone, both)
    ]
    of_pixels, of_places = (
        [table["correction"].xs(source, level="source").values for table in corrections]
        for source in ("discretisation", "window")
    )
    assert of_pixels[1] == pytest.approx(of_pixels[0], rel=1e-6)
    assert (of_places[0] == 0).all()
    shown = both["mean_gap"].values - alone["mean_gap"].values
    assert of_places[1] == pytest.approx(shown, rel=1e-6)


def test_the_gas_of_a_joint_follows_the_gap_that_an_overview_shows(field):
    """Its interval holds the joints of all places of the field, solved on their own, in the mean."""
    body = {"youngs_modulus": 1.5e9, "poissons_ratio": 0.3, "thermal_conductivity": 0.2}
    settings = {
        "contact": {"bodies": [body, body], "mean_pressure": [1e6, 3e6, 2e7]},
        "statistics": {"flow": "never", "joint": {"gas_conductivity": 0.026, "temperature_jump": 0.37e-6}},
    }
    found = rc.evaluate(
        field[PLACE], overview=field.coarsen(y=3, x=3).mean(), uncertainty=SOURCES, **settings
    )
    parts = [field[y : y + 96, x : x + 96] for y in (0, 96, 192) for x in (0, 96, 192)]
    joints = [
        rc.evaluate(part, uncertainty={"sources": []}, **settings)["joint_conductance"] for part in parts
    ]
    truth, alone = np.mean(joints, axis=0), joints[4]  # the place of the map is the middle one
    assert (found["joint_conductance_lower"].values < truth).all()
    assert (truth < found["joint_conductance_upper"].values).all()
    errors = [np.abs(np.log(values / truth)).mean() for values in (found["joint_conductance"].values, alone)]
    assert errors[0] < 0.5 * errors[1]


def test_an_overview_without_a_size_is_asked_to_state_it_in_its_file(field, tmp_path):
    """Where the row has the pixel size of the map, and none of its overview."""
    path, heights = tmp_path / "field.txt", 1e6 * field[:64, :64].values
    np.savetxt(path, heights)
    asked = r"the size of an overview is stated in its file: .*# Width: 300 um"
    with pytest.raises(rc.InputFileError, match=asked):
        rc.evaluate(field[PLACE], overview=path, contact_modulus=1e9, relative_pressure=0.02)
    np.savetxt(path, heights, header="Width: 64 um\nHeight: 64 um\nValue units: um")
    np.testing.assert_allclose(read_overview(path)[::-1], field[:64, :64].values, rtol=1e-12)


def test_the_next_map_of_a_group_scatters_as_maps_do_and_not_as_the_means_of_their_overviews():
    """Three maps in one overview agree on its mean; by themselves they differ by a factor of four."""
    loads = {"mean_pressure": ("load", [1e6])}
    gaps, means = (0.5, 1.0, 2.0), (0.99, 1.0, 1.01)
    plain = rc.group_statistics([xr.Dataset({GAP: ("load", [gap]), **loads}) for gap in gaps])
    unbounded = {f"{GAP}_alone_{end}": ("load", [np.nan]) for end in ("lower", "upper")}
    shown = rc.group_statistics(
        [
            xr.Dataset({GAP: ("load", [mean]), f"{GAP}_alone": ("load", [gap]), **unbounded, **loads})
            for mean, gap in zip(means, gaps, strict=True)
        ]
    )
    width, width_of_plain, of_mean = (
        float(np.log(group[f"{GAP}{key}_upper"] / group[f"{GAP}{key}_lower"])[0])
        for group, key in ((shown, "_next"), (plain, "_next"), (shown, ""))
    )
    assert width == pytest.approx(width_of_plain)
    assert of_mean < 0.1


def test_of_two_maps_with_overviews_the_next_one_is_expected_to_scatter_as_their_own_intervals_say():
    def made(value, half_width, single, single_half_width):
        ends = {"": 1.0, "_lower": np.exp(-single_half_width), "_upper": np.exp(single_half_width)}
        numbers = {f"{GAP}_alone{key}": ("load", [single * factor]) for key, factor in ends.items()}
        sides = np.zeros((1, 8, 4))
        sides[:, 2, :2] = value * np.array([1 - np.exp(-half_width), np.exp(half_width) - 1])
        numbers |= {GAP: ("load", [value]), f"{GAP}_components": (("load", "source", "component"), sides)}
        return xr.Dataset(numbers, {"mean_pressure": ("load", [1e6])})

    narrow, wide = (
        rc.group_statistics([made(1.0, 0.1, 1.0, width), made(1.01, 0.1, 1.1, width)]) for width in (0.1, 1.0)
    )
    widths = [
        float(np.log(each[f"{GAP}_next_upper"] / each[f"{GAP}_next_lower"])[0]) for each in (narrow, wide)
    ]
    assert widths[1] > 5 * widths[0]
    assert narrow[f"{GAP}_upper"].values == pytest.approx(wide[f"{GAP}_upper"].values)
