"""Two faces on one another: signs, mirroring, turning, shifting, resampling, against plain arrays."""

import json

import numpy as np
import pytest
import x3pio
from scipy.interpolate import CubicSpline, RectBivariateSpline

import roughcontact as rc
from roughcontact.arguments.maps import height_map
from roughcontact.errors import HeightMapError, SettingsError
from roughcontact.surface.faces import overlap
from roughcontact.surface.faces.composite import composite
from roughcontact.surface.faces.face import Face
from roughcontact.surface.faces.positions import relative_positions
from roughcontact.surface.levelling.level import level
from roughcontact.surface.synthetic import self_affine_surface
from roughcontact.surface.window.instrument import stated_instrument
from roughcontact.surface.window.periodic_window import periodic_window

STEP = 1e-6


def rough(seed, shape=(64, 64), spacing=STEP, **more):
    """Return a periodic rough map with zero mean."""
    parameters = {"hurst": 0.8, "shortest": 8e-6, "longest": 32e-6, "rms_gradient": 0.1} | more
    surface = self_affine_surface(shape, spacing, **parameters, seed=seed)
    return surface - surface.mean()


def cut(surface, rows, columns):
    """Return a part of a map, with a name: it is no longer periodic."""
    return surface.isel(y=rows, x=columns).assign_attrs(source_file="part")


def off_plane_of(values, *positions):
    """Return values at scattered positions above their least-squares plane, where they are finite."""
    good = np.isfinite(values)
    terms = np.column_stack([np.ones(values.size), *positions])
    return values - terms @ np.linalg.lstsq(terms[good], values[good], rcond=None)[0]


def off_plane(values):
    """Return heights above their least-squares plane, by other means than the package's."""
    y, x = np.indices(values.shape)
    terms = np.column_stack([np.ones(values.size), y.ravel(), x.ravel()])
    plane = terms @ np.linalg.lstsq(terms, values.ravel(), rcond=None)[0]
    return values - plane.reshape(values.shape)


@pytest.mark.parametrize("part", [(slice(64), slice(64)), (slice(3, 50), slice(5, 61))])
def test_a_face_on_its_own_imprint_fits_without_a_gap(part):
    face = cut(rough(1), *part)
    imprint = face.copy(data=-face.values[:, ::-1])
    together = composite(face, imprint)
    assert together.shape == face.shape
    np.testing.assert_allclose(together, 0, atol=1e-14 * float(np.abs(face).max()))


def test_a_peak_on_a_peak_stands_out_twice_and_lies_where_the_mirror_image_has_it():
    face, counter_face = np.zeros((21, 31)), np.zeros((21, 31))
    face[4, 7], counter_face[4, 23] = 1e-6, 2e-6
    together = composite(height_map(face, STEP), height_map(counter_face, STEP))
    assert np.unravel_index(together.values.argmax(), together.shape) == (4, 7)
    assert float(together.max()) == pytest.approx(3e-6, rel=0.05)


def test_the_sum_of_parts_is_that_of_the_arrays_less_one_plane():
    face, counter_face = cut(rough(1), slice(3, 50), slice(5, 61)), cut(rough(2), slice(47), slice(56))
    together = composite(face, counter_face)
    expected = off_plane(face.values + counter_face.values[:, ::-1])
    np.testing.assert_allclose(together, expected, atol=1e-13 * np.abs(expected).max())
    np.testing.assert_allclose(together["x"], face["x"], rtol=1e-14)
    np.testing.assert_allclose(together["y"], face["y"], rtol=1e-14)
    tilted = face + 0.3 * face["x"] - 0.2 * face["y"]
    np.testing.assert_allclose(
        composite(tilted, counter_face), together, atol=1e-19 + 1e-9 * np.abs(expected).max()
    )


@pytest.mark.parametrize(("rotation", "turns"), [(90, -1), (180, 2), (270, 1), (-90, 1), (360, 0)])
def test_right_angles_turn_the_mirror_image_from_x_towards_y(rotation, turns):
    face, counter_face = cut(rough(1), slice(48), slice(48)), cut(rough(2), slice(2, 50), slice(7, 55))
    together = composite(face, counter_face, rotation=rotation)
    # np.rot90 turns from the first axis, y, towards the second, x
    expected = off_plane(face.values + np.rot90(counter_face.values[:, ::-1], turns))
    np.testing.assert_allclose(together, expected, atol=1e-13 * np.abs(expected).max())


def test_maps_that_are_not_square_lie_across_at_a_right_angle():
    face, counter_face = cut(rough(1), slice(20), slice(48)), cut(rough(2), slice(48), slice(20))
    expected = off_plane(face.values + np.rot90(counter_face.values[:, ::-1], -1))
    np.testing.assert_allclose(composite(face, counter_face, rotation=90), expected, atol=1e-18)


@pytest.mark.parametrize("shift", [(0, 0), (5, -11), (-70, 3)])
def test_periodic_faces_make_a_periodic_one_at_every_shift(shift):
    face, counter_face = rough(1), rough(2)
    together = composite(face, counter_face, shift=[s * STEP for s in shift])
    expected = face.values + np.roll(counter_face.values[:, ::-1], shift, axis=(0, 1))
    np.testing.assert_allclose(together, expected, atol=1e-13 * np.abs(expected).max())
    assert periodic_window(together).attrs["periodisation"] == "none"
    assert together.attrs["form"] == "mean"
    assert together.attrs["covered_share"] == pytest.approx(1)


def test_periodic_faces_stay_periodic_after_levelling():
    face, counter_face = rough(1), rough(2)
    levelled = [level(side + 1e-3 * side["x"] * 0, form="plane") for side in (face, counter_face)]
    together = composite(*levelled, shift=(3e-6, 4e-6))
    expected = face.values + np.roll(counter_face.values[:, ::-1], (3, 4), axis=(0, 1))
    np.testing.assert_allclose(together, expected, atol=1e-9 * np.abs(expected).max())


def test_independent_faces_add_in_squares():
    rms = []
    for seed in range(12):
        pair = [
            rough(100 + 2 * seed + k, (128, 128), longest=16e-6, rms_gradient=0.1 * (k + 1)) for k in (0, 1)
        ]
        rms.append([*(float(np.std(side)) for side in pair), float(np.std(composite(*pair)))])
    rms_face, rms_counter_face, together = np.array(rms).T
    # 12 pairs of maps that hold 8 x 8 of their longest waves: two standard errors are 2 %
    assert np.mean(together**2 / (rms_face**2 + rms_counter_face**2)) == pytest.approx(1, abs=0.02)


def test_a_shift_between_points_is_interpolated_as_the_waves_go():
    y, x = np.indices((64, 64)) * STEP
    face, counter_face = np.zeros((64, 64)), 1e-6 * np.sin(2 * np.pi * (2 * x + y) / 32e-6)
    turned_over = lambda y, x: 1e-6 * np.sin(2 * np.pi * (2 * (63 * STEP - x) + y) / 32e-6)  # noqa: E731
    shift = (2.3e-6, -4.6e-6)
    together = composite(height_map(face, STEP), height_map(counter_face, STEP), shift=shift)
    expected = turned_over(y - shift[0], x - shift[1])
    assert together.shape == (64, 64)  # both are periodic, the flat one too
    np.testing.assert_allclose(together, expected, atol=2e-9)


def test_a_rotation_askew_turns_the_waves():
    face, counter_face = np.zeros((80, 80)), np.zeros((80, 80))
    face += 1e-12 * np.random.default_rng(1).standard_normal(face.shape)  # not periodic, as good as flat
    y, x = (np.indices(counter_face.shape) - 39.5) * STEP
    counter_face = 1e-6 * np.sin(2 * np.pi * x / 30.7e-6)
    together = composite(height_map(face, STEP), height_map(counter_face, STEP), rotation=30)
    along = x * np.cos(np.pi / 6) + y * np.sin(np.pi / 6)
    expected = 1e-6 * np.sin(-2 * np.pi * along / 30.7e-6)
    measured = np.isfinite(together.values)
    deviation = (together.values - expected)[measured]
    yy, xx = np.nonzero(measured)
    terms = np.column_stack([np.ones(deviation.size), yy, xx])
    deviation -= terms @ np.linalg.lstsq(terms, deviation, rcond=None)[0]
    np.testing.assert_allclose(deviation, 0, atol=2.5e-9)  # next to the edges, where the spline is straight
    assert np.sqrt(np.mean(deviation**2)) < 1e-9
    # the corners of the face reach beyond the turned counter-face
    assert np.isnan(together.values[0, 0])
    assert measured.mean() == pytest.approx(0.82, abs=0.06)


def test_the_closer_points_are_kept():
    fine = rough(3, (256, 256), 0.5e-6, shortest=8e-6)
    coarse = fine[::2, ::2].copy()
    face = rough(1, (128, 128), STEP)
    together = composite(face, fine)
    assert together.shape == (256, 256)
    assert float(together["x"][1] - together["x"][0]) == pytest.approx(0.5e-6)
    # a face that is coarser than the other, both periodic: the sum of the two fields in between as well
    back = composite(coarse, fine.copy(data=-fine.values[:, ::-1]), shift=(0.25e-6, 0.25e-6))
    assert float(np.std(back)) < 0.01 * float(np.std(fine))
    part = composite(cut(face, slice(100), slice(100)), cut(fine, slice(90), slice(120)))
    assert part.shape == (89, 119)  # points between those of the finer map, within its edges
    assert float(part["y"][0]) > float(face["y"][0])


def test_parts_that_overlap_in_part_leave_that_part():
    face, counter_face = cut(rough(1), slice(40), slice(50)), cut(rough(2), slice(40), slice(50))
    together = composite(face, counter_face, shift=(10e-6, -20e-6))
    expected = off_plane(face.values[10:, :30] + counter_face.values[:30, ::-1][:, 20:])
    np.testing.assert_allclose(together, expected, atol=1e-13 * np.abs(expected).max())
    assert together.attrs["covered_share"] == pytest.approx(30 * 30 / 2000)
    np.testing.assert_allclose(together["y"], face["y"][10:], rtol=1e-14)
    with pytest.raises(HeightMapError, match="do not overlap"):
        composite(face, counter_face, shift=(45e-6, 0))


@pytest.mark.parametrize("larger", ["face", "counter-face"])
def test_pixels_and_sizes_of_both_faces_are_known(larger):
    large, small = rough(1, (128, 128), STEP), cut(rough(2, (128, 128), STEP / 2), slice(40), slice(60))
    together = composite(*((large, small) if larger == "face" else (small, large)))
    assert sorted(together.attrs["face_pitches"]) == pytest.approx([STEP / 2, STEP])
    share = 40 * 60 / 4 / 128**2  # within half a pixel at each end
    assert together.attrs["covered_share_of_larger"] == pytest.approx(share, rel=0.06)


def test_missing_and_filled_points_of_either_face_count():
    face, counter_face = (cut(rough(seed), slice(60), slice(50)) for seed in (1, 2))
    face.values[20, 10] = np.nan
    counter_face.values[40:42, 4] = np.nan
    for shift, holes in (((0, 0), 3), ((0, 0.5e-6), 5)):
        together = composite(face, counter_face, shift=shift)
        assert int(np.isnan(together).sum()) == holes
    levelled = [level(side) for side in (face, counter_face)]
    together = composite(*levelled)
    assert int(together["filled"].sum()) == together.attrs["filled_points"] == 3
    assert together["filled"].values[20, 10] == together["filled"].values[40, 45] == 1
    assert not np.isnan(together).any()


def test_the_steps_of_both_faces_add_up():
    faces = [cut(rough(seed), slice(60), slice(50)) for seed in (1, 2)]
    rounded = [
        side.copy(data=np.rint(side.values / step) * step)
        for side, step in zip(faces, (2e-7, 3e-7), strict=True)
    ]
    together = composite(*(level(side) for side in rounded))
    assert together.attrs["quantisation_step"] == pytest.approx(5e-7)
    assert "quantisation_step" not in composite(*rounded).attrs


def test_profiles_shift_along_their_length():
    face, counter_face = (cut(rough(seed, (1, 400)), slice(1), slice(300)) for seed in (1, 2))
    together = composite(face, counter_face, shift=(0, 30e-6))
    sum_of_both = face.values[0, 30:] + counter_face.values[0, ::-1][:-30]
    x = np.arange(270)
    np.testing.assert_allclose(
        together.values[0], sum_of_both - np.polyval(np.polyfit(x, sum_of_both, 1), x), atol=1e-18
    )
    assert together.attrs["covered_share"] == pytest.approx(270 / 300)
    for wrong in ({"rotation": 90}, {"shift": (1e-6, 0)}):
        with pytest.raises(SettingsError, match="profiles"):
            composite(face, counter_face, **wrong)
    with pytest.raises(HeightMapError, match="a map and a profile"):
        composite(face, rough(1))


def test_a_profile_gets_the_closer_points_of_the_other_one():
    face = cut(rough(1, (1, 400)), slice(1), slice(100))
    fine = cut(rough(2, (1, 800), STEP / 2), slice(1), slice(300))
    together = composite(face, fine)
    assert together.shape == (1, 199)  # from the first point of the face to its last
    np.testing.assert_allclose(together["x"][::2], face["x"], rtol=1e-12)
    drawn = np.array([position["shift"] for position in relative_positions(face, fine)])
    assert (drawn[:, 0] == 0).all()  # along its length alone
    assert (drawn[:, 1] != 0).all()


@pytest.mark.parametrize("relative_change", [-5e-7, 5e-7])
def test_steps_that_agree_to_a_millionth_are_one(relative_change):
    face, counter_face = cut(rough(1), slice(40), slice(50)), cut(rough(2), slice(44), slice(54))
    stretched = counter_face.assign_coords(
        x=counter_face["x"] * (1 + relative_change), y=counter_face["y"] * (1 + relative_change)
    )
    on_points = [
        [position["shift"] for position in relative_positions(face, partner, shifts=20)]
        for partner in (counter_face, stretched)
    ]
    np.testing.assert_allclose(*on_points, atol=1e-3 * STEP)
    together = composite(face, stretched)
    assert together.shape == face.shape
    np.testing.assert_allclose(
        together, composite(face, counter_face), atol=1e-4 * float(np.abs(counter_face).max())
    )


def test_periods_of_a_few_nanometres_are_told_apart():
    """Of 64 and 62 nm the sum does not repeat; of twice 64 nm it does."""
    face, same = (rough(seed, (64, 64), 1e-9, shortest=8e-9, longest=32e-9) for seed in (1, 2))
    shorter = rough(3, (62, 62), 1e-9, shortest=8e-9, longest=31e-9)
    assert composite(face, same).attrs["form"] == "mean"
    assert composite(face, shorter).attrs["form"] == "plane"


def test_two_points_along_an_axis_are_an_overlap_and_one_is_none():
    face, counter_face = cut(rough(1), slice(40), slice(50)), cut(rough(2), slice(40), slice(50))
    assert composite(face, counter_face, shift=(38 * STEP, 0)).shape == (2, 50)
    with pytest.raises(HeightMapError, match="do not overlap"):
        composite(face, counter_face, shift=(39 * STEP, 0))


def test_steps_that_differ_too_much_are_refused_before_they_fill_the_memory():
    coarse = height_map(np.random.default_rng(1).standard_normal((60, 60)) * 1e-6, 1e-3)
    narrow = height_map(np.random.default_rng(2).standard_normal((2, 40000)) * 1e-6, (0.03, 1e-6))
    with pytest.raises(HeightMapError, match="steps of the two maps are too different"):
        composite(coarse, narrow, rotation=45)


@pytest.mark.parametrize("wrong", [{"shift": (0, np.nan)}, {"shift": (0, 1, 2)}, {"rotation": np.inf}])
def test_positions_without_meaning(wrong):
    with pytest.raises(SettingsError):
        composite(rough(1), rough(2), **wrong)


def test_both_files_and_the_position_are_recorded():
    face = rough(1).assign_attrs(source_file="a.x3p", source_sha256="aa", ingest_warnings='["steep"]')
    blunt = json.dumps({"numerical_aperture": 0.01})
    counter_face = rough(2).assign_attrs(source_file="b.x3p", source_sha256="bb", instrument=blunt)
    together = composite(face, counter_face, shift=(2e-6, 3e-6), rotation=90)
    attrs = together.attrs
    assert attrs["source_file"] == "a.x3p + b.x3p"
    assert attrs["source_sha256"] == "aa + bb"
    assert attrs["counter_face"] == "b.x3p"
    assert (attrs["shift_y"], attrs["shift_x"], attrs["rotation"]) == (2e-6, 3e-6, 90.0)
    assert json.loads(attrs["ingest_warnings"]) == ["a.x3p: steep"]
    assert attrs["instrument"] == blunt  # of the one that resolves less
    rejected = {
        "outliers_rejected": 3,
        "outlier_kinds": '{"spike": 3}',
        "missing_share": 0.25,
        "row_jitter": 0.1,
    }
    further_attrs = {
        "outliers_rejected": 4,
        "outlier_kinds": '{"spike": 2, "scar": 2}',
        "missing_share": 0.125,
    }
    for pair in (
        (face.assign_attrs(rejected), counter_face.assign_attrs(further_attrs)),
        (face, counter_face),
    ):
        attributes = composite(*pair).attrs
        has_rejections = pair[0] is not face
        assert json.loads(attributes["outlier_kinds"]) == ({"spike": 5, "scar": 2} if has_rejections else {})
        assert attributes["outliers_rejected"] == (7 if has_rejections else 0)
        assert attributes["missing_share"] == (0.25 if has_rejections else 0)
        assert attributes.get("row_jitter") == (0.1 if has_rejections else None)
    assert attrs["Sq"] == pytest.approx(float(np.std(together)))


def test_the_sum_of_two_faces_shows_what_both_instruments_show():
    """Whichever face is the first."""
    fine = rough(1).assign_attrs(
        instrument_resolution=2e-6, instrument_numerical_aperture=0.5, instrument_amplification_z=0.03
    )
    coarse = rough(2).assign_attrs(
        instrument_resolution=5e-6, instrument_numerical_aperture=0.3, instrument_wavelength=7e-7
    )
    expected = {"resolution": 5e-6, "numerical_aperture": 0.3, "wavelength": 7e-7, "amplification_z": 0.03}
    for faces in ((fine, coarse), (coarse, fine)):
        assert stated_instrument(composite(*faces), {}) == expected


def test_the_noise_of_two_faces_is_that_of_their_sum():
    faces = [rough(1).assign_attrs(instrument_noise=3e-9), rough(2).assign_attrs(instrument_noise=4e-9)]
    instrument = {"noise": 1e-9}
    assert stated_instrument(composite(*faces), instrument)["noise"] == pytest.approx(5e-9)
    assert stated_instrument(composite(rough(1), rough(2)), instrument)["noise"] == pytest.approx(
        2**0.5 * 1e-9
    )
    assert stated_instrument(rough(1), instrument)["noise"] == 1e-9


@pytest.mark.parametrize("first", [0, 1])
def test_of_the_face_that_states_nothing_the_settings_are(first):
    """A noisy, coarse face on one whose instrument is that of the settings, whichever is the first."""
    noisy = rough(1).assign_attrs(instrument_noise=4e-9, instrument_resolution=2e-6)
    faces = [noisy, rough(2)] if first == 0 else [rough(2), noisy]
    settings = {"noise": 3e-9, "resolution": 5e-6, "tip_radius": 1e-6}
    stated = stated_instrument(composite(*faces), settings)
    assert stated == pytest.approx({"noise": 5e-9, "resolution": 5e-6, "tip_radius": 1e-6})
    assert stated_instrument(composite(*faces), {})["noise"] == pytest.approx(4e-9)
    lens = {"numerical_aperture": 0.3, "wavelength": 6e-7}
    coarse = [
        face.assign_attrs(instrument_numerical_aperture=0.5) if face is noisy else face for face in faces
    ]
    assert stated_instrument(composite(*coarse), lens).items() >= lens.items()
    assert "wavelength" not in stated_instrument(composite(*coarse), {"numerical_aperture": 0.3})


def test_an_ensemble_of_positions():
    face, counter_face = cut(rough(1), slice(40), slice(50)), cut(rough(2), slice(33), slice(64))
    drawn = relative_positions(face, counter_face, shifts=40, rotations=[0, 90], overlap=0.8, seed=3)
    assert [position["rotation"] for position in drawn] == [0.0] * 40 + [90.0] * 40
    for rotation, sides in ((0, (33, 64)), (90, (64, 33))):
        shifts = (
            np.array([position["shift"] for position in drawn if position["rotation"] == rotation]) / STEP
        )
        for values, a, b in zip(shifts.T, (40, 50), sides, strict=True):
            reach = abs(a - b) / 2 + 0.2 * min(a, b)
            assert 0.8 * reach < np.abs(values).max() <= reach + 0.5
            # points on points: halves where one number of points is odd
            np.testing.assert_allclose((values - (a - b) / 2) % 1 % 0.999999, 0, atol=1e-5)
    fewer = relative_positions(face, counter_face, shifts=2, rotations=[0, 90], overlap=0.8, seed=3)
    assert fewer == drawn[:2] + drawn[40:42]
    assert relative_positions(face, counter_face, shifts=1, overlap=0.8, seed=3) == drawn[:1]
    assert fewer != relative_positions(face, counter_face, shifts=2, rotations=[0, 90], overlap=0.8, seed=4)
    together = composite(face, counter_face, **drawn[50])
    assert not np.isnan(together).any()
    periodic = relative_positions(rough(1), rough(2), shifts=50)
    assert 28 * STEP < np.abs([position["shift"] for position in periodic]).max() <= 32 * STEP


def test_a_shift_is_moved_to_the_nearest_points():
    """By half a step at most from where it was drawn, which is where faces of other steps lie."""
    face, counter_face = cut(rough(1), slice(40), slice(50)), cut(rough(2), slice(33), slice(64))
    stretched = counter_face.assign_coords(x=counter_face["x"] * (1 + 1e-5), y=counter_face["y"] * (1 + 1e-5))
    on_points, drawn = (
        np.array([position["shift"] for position in relative_positions(face, partner, shifts=20)])
        for partner in (counter_face, stretched)
    )
    distance = np.abs(on_points - drawn) / STEP
    assert 0.4 < distance.max() < 0.501


@pytest.mark.cases
def test_ensembles_without_meaning(wrong, message):
    with pytest.raises(SettingsError, match=message):
        relative_positions(rough(1), rough(2), **wrong)


def test_a_common_grid_has_no_more_points_than_a_file_may_have(monkeypatch):
    faces = rough(1, (16, 20)), rough(2, (16, 20))
    monkeypatch.setattr(overlap, "_MAX_POINTS", 16 * 20)
    assert composite(*faces).shape == (16, 20)
    monkeypatch.setattr(overlap, "_MAX_POINTS", 16 * 20 - 1)
    with pytest.raises(HeightMapError, match="16 x 20 points, more than the limit of 319"):
        composite(*faces)


def test_the_contact_of_two_faces_is_that_of_their_sum():
    face, counter_face = rough(1), rough(2)
    load = {"contact_modulus": 1e9, "mean_pressure": 1e7}
    together = rc.solve_contact(periodic_window(rc.composite(face, counter_face)), **load)
    summed = rc.solve_contact(face.copy(data=face.values + counter_face.values[:, ::-1]), **load)
    np.testing.assert_allclose(
        together["pressure"], summed["pressure"], atol=1e-3 * float(summed["pressure"].max())
    )


# --- measured files of any format --------------------------------------------------------------------------


def as_points(path, values):
    y, x = np.indices(values.shape) * STEP * 1e6
    table = np.column_stack([x.ravel(), y.ravel(), 1e6 * values.ravel()])
    np.savetxt(path, table, fmt="%.15g", delimiter="\t", header="x (um)\ty (um)\tz (um)", comments="")
    return {}


def as_picture(path, values):
    ny, nx = values.shape
    header = f"# Width: {nx * STEP * 1e6} um\n# Height: {ny * STEP * 1e6} um\n# Value units: m"
    np.savetxt(path, values[::-1], fmt="%.15g", delimiter="\t", header=header, comments="")
    return {}


def as_x3p(path, values):
    x3pio.write(path, values, x_scale=STEP, y_scale=STEP)
    return {}


def as_array(path, values):
    with path.open("wb") as stream:
        np.save(stream, values)
    return {"dx": STEP, "dy": STEP, "unit": "m"}


def as_array_from_the_top(path, values):
    return as_array(path, values[::-1]) | {"first_row": "top"}


FORMATS = (as_points, as_picture, as_x3p, as_array, as_array_from_the_top)


def measured(folder, values, written):
    """Return a map (y upwards) after a way through a file."""
    path = folder / f"{written.__name__}.dat"
    options = written(path, values)
    return level(rc.read_height_map(path, **options), outlier_threshold=None, line_alignment="none")


def oblique():
    """Return heights with a lay that runs from the lower left to the upper right, y upwards."""
    y, x = np.indices((48, 64)) * STEP
    return cut(rough(5), slice(48), slice(64)).values + 1e-6 * np.cos(2 * np.pi * (3 * x - 5 * y) / 64e-6)


@pytest.mark.parametrize("format_counter_face", FORMATS)
@pytest.mark.parametrize("format_face", FORMATS)
def test_a_face_fits_on_its_imprint_whatever_their_formats(tmp_path, format_face, format_counter_face):
    heights = oblique()
    face = measured(tmp_path, heights, format_face)
    imprint = measured(tmp_path, -heights[:, ::-1], format_counter_face)
    np.testing.assert_allclose(composite(face, imprint), 0, atol=1e-11 * np.ptp(heights))


@pytest.mark.slow
def test_the_contact_of_a_pair_depends_neither_on_formats_nor_on_the_order(tmp_path):
    face_values, counter_values = (
        oblique(),
        0.7 * oblique()[:, ::-1] + cut(rough(6), slice(48), slice(64)).values,
    )
    load = {"contact_modulus": 1e9, "mean_pressure": 1e7}
    areas, heights = [], []
    for format_face, format_counter_face in (
        (as_x3p, as_x3p),
        (as_picture, as_picture),
        (as_points, as_picture),
    ):
        pair = (
            measured(tmp_path, face_values, format_face),
            measured(tmp_path, counter_values, format_counter_face),
        )
        laid = composite(*pair, shift=(4 * STEP, 6 * STEP))
        heights.append(laid.values)
        # the one that lies on top is turned over: seen from it, the pair is its mirror image
        turned = composite(*pair[::-1], shift=(-4 * STEP, 6 * STEP))
        np.testing.assert_allclose(turned.values[:, ::-1], heights[-1], atol=1e-9 * np.ptp(face_values))
        for arrangement in (laid, turned):
            solved = rc.solve_contact(periodic_window(arrangement, method="raw"), **load)
            areas.append(float(rc.contact_statistics(solved)["relative_contact_area"][0]))
    np.testing.assert_allclose(heights, [heights[0]] * 3, atol=1e-9 * np.ptp(face_values))
    np.testing.assert_allclose(areas, areas[0], rtol=2e-3)
    assert 0.02 < areas[0] < 0.5


@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
def test_a_rotated_pair_is_the_same_from_both_sides(rotation):
    """The way that leads to the counter-face leads back, mirrored: shifts turn, the rotation stays."""
    face, counter_face = cut(rough(1), slice(50), slice(60)), cut(rough(2), slice(52), slice(54))
    sy, sx = 3e-6, -4e-6
    cosine, sine = np.cos(np.radians(rotation)), np.sin(np.radians(rotation))
    forward = composite(face, counter_face, shift=(sy, sx), rotation=rotation)
    back = composite(
        counter_face, face, shift=(sine * sx - cosine * sy, cosine * sx + sine * sy), rotation=rotation
    )
    middle = [float(face[d][[0, -1]].mean()) for d in ("y", "x")]
    y, x = (forward[d].values - m for d, m in zip(("y", "x"), middle, strict=True))
    v, u = np.meshgrid(y - sy, x - sx, indexing="ij")
    positions = [
        p + float(counter_face[d][[0, -1]].mean())
        for d, p in (("y", v * cosine - u * sine), ("x", -(u * cosine + v * sine)))
    ]
    seen = back.interp(
        y=("points", positions[0].ravel()), x=("points", positions[1].ravel())
    )  # on its points
    difference = off_plane_of(forward.values.ravel() - seen.values, v.ravel(), u.ravel())
    assert np.isfinite(difference).mean() > 0.5
    assert np.nanmax(np.abs(difference)) < 1e-9 * float(np.ptp(face.values))


def test_a_face_whose_file_does_not_say_where_it_begins_is_named(tmp_path):
    pair = [measured(tmp_path, oblique(), written) for written in (as_x3p, as_array)]
    rows = "as_array.dat: the first row is taken as the bottom of the picture; if it is not, give first_row"
    assert rows in json.loads(composite(*pair).attrs["ingest_warnings"])
    pair[1] = measured(tmp_path, oblique(), as_array_from_the_top)
    warnings = json.loads(composite(*pair).attrs["ingest_warnings"])
    assert not any("first row" in text for text in warnings)


@pytest.mark.parametrize("shape", [(60, 70), (1, 90), (64, 3)])
@pytest.mark.parametrize("points", [8.0, 12.0, 24.0])
def test_the_spline_is_a_not_a_knot_spline_at_the_rim_too(shape, points):
    """Waves of so many points, between the points of a map that is not periodic."""
    y, x = np.indices(shape)
    wavenumbers = {"y": 2 * np.pi / (1.3 * points), "x": 2 * np.pi / points}

    def surface(y, x):
        return 6e-7 * np.sin(wavenumbers["x"] * x + 0.3) * np.cos(wavenumbers["y"] * y + 0.2) + 3e-8 * x

    heights = surface(y, x)
    face = Face(height_map(heights, STEP))
    assert not face.periodic
    rng = np.random.default_rng(0)
    positions = rng.uniform(0, 1, (2, 500)) * (np.array(shape)[:, None] - 1)
    positions[:, :250] %= 1.0  # within a point of the rim
    values, _ = face.at(*((p - (n - 1) / 2) * STEP for p, n in zip(positions, shape, strict=True)))
    if shape[0] == 1:
        expected = CubicSpline(np.arange(shape[1]), heights[0])(positions[1])
    else:
        degrees = [min(3, n - 1) for n in shape]
        spline = RectBivariateSpline(*map(np.arange, shape), heights, kx=degrees[0], ky=degrees[1])
        expected = spline.ev(*positions)
    np.testing.assert_allclose(values, expected, atol=1e-9 * np.ptp(heights))
    if min(shape) != 3:  # range of a wave: 0.53 % at the rim for 8 points, 0.1 % for 12
        assert np.abs(values - surface(*positions)).max() < 25 * points**-4 * 1.2e-6
