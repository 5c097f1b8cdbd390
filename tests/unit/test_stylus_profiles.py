"""The surface behind profiles: spectra, heights and slopes that are known, seeds, warnings, the answer."""

import json

import numpy as np
import pytest
import scipy
import xarray as xr

import roughcontact as rc
from roughcontact import HeightMapError, SettingsError, height_map
from roughcontact.arguments.quantities import percent
from roughcontact.kernels.fourier import halfplane_weights
from roughcontact.statistics import map_checks
from roughcontact.surface.preparation.profiles import ProfilesPreparation
from roughcontact.surface.profiles import finish
from roughcontact.surface.profiles.finish import draw, fit_statistics
from roughcontact.surface.profiles.spectrum import ProfileFit
from roughcontact.surface.profiles.surface import profile_pieces, stacked
from roughcontact.surface.roughness.parameters import rms_gradient

SIDE = 256
BAND = {"hurst": 0.8, "shortest": 6.0, "longest": 40.0, "rms_height": 1.0}
CONTACT = {"contact_modulus": "1 GPa", "mean_pressure": ["2 MPa", "10 MPa"]}


def rough(seed=1, stretch=1.0, side=SIDE):
    return rc.self_affine_surface((side, side), 1.0, **BAND, stretch=stretch, seed=seed)


def rows(surface, number=5):
    return [height_map(row, 1.0) for row in surface.values[:: SIDE // number][:number]]


def fitted(surface, number):
    return ProfileFit([profile_pieces(rows(surface, number))], 1)


def density_of(surface):
    """Return wavenumbers (cycles per point) and spectral density of a periodic surface, wave by wave."""
    side = len(surface)
    f = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side))
    return f, np.abs(np.fft.rfft2(surface)) ** 2 / side**2


def test_a_known_spectrum_is_recovered():
    surface = rough(side=512)
    spectrum = ProfileFit([profile_pieces([surface[[row]] for row in range(512)])], 1).best
    f, density = density_of(surface.values)
    for low, high in ((1 / 38, 1 / 24), (1 / 24, 1 / 16), (1 / 16, 1 / 11), (1 / 11, 1 / 7)):
        ring = (f > low) & (f < high)
        assert np.mean(spectrum.at(f[ring])) == pytest.approx(np.mean(density[ring]), rel=0.1)
    weights = halfplane_weights((512, 512)) * spectrum.at(f) / 512**2
    assert np.sqrt(weights.sum()) == pytest.approx(float(surface.std()), rel=0.03)
    gradient = np.sqrt(np.sum(weights * (2 * np.pi * f) ** 2))
    assert gradient == pytest.approx(rms_gradient(surface), rel=0.02)


def test_long_waves_that_levelling_took_from_each_line_are_put_back():
    # of the waves as long as the profiles a parabola leaves little: their periodogram falls to a tenth
    side, length, waves = 1024, 256, {**BAND, "longest": 1024.0}
    surface = rc.self_affine_surface((side, side), 1.0, **waves, seed=3)
    pieces = surface.values[::16].reshape(-1, length)
    basis = np.linalg.qr(np.vander(np.arange(length), 3))[0]
    spectra = {}
    for order in (0, 2):
        removed = basis[:, 2 - order :]
        spectra[order] = ProfileFit([(pieces - (pieces @ removed) @ removed.T, 1.0)], order)
    assert spectra[2].measured[0] < 0.5 * spectra[0].measured[0]
    f, density = density_of(surface.values)
    for low, high in ((1 / 256, 1 / 64), (1 / 64, 1 / 16)):
        ring = (f > low) & (f < high)
        level_of_waves = np.mean(spectra[2].best.at(f[ring]))
        assert level_of_waves == pytest.approx(np.mean(density[ring]), rel=0.2)


def test_the_density_along_a_line_is_the_integral_in_closed_form():
    # of f^-3: integral of (q^2 + y^2)^-3/2 over |y| < 1/2 is 1/(q^2 sqrt(q^2 + 1/4))
    fit = fitted(rough(), 5)
    q = np.arange(SIDE + 1) / (2 * SIDE)
    middle = slice(20, SIDE)
    line = fit._lines(SIDE).sum(axis=1)[middle]
    q = q[middle]
    np.testing.assert_allclose(line, 1 / (q**2 * np.sqrt(q**2 + 0.25)), rtol=0.02)


def test_the_periodogram_of_white_profiles_is_their_variance():
    fit = fitted(rough(), 5)
    kernel = fit._kernel(np.array([40]), SIDE)
    assert kernel.sum() * SIDE == pytest.approx(SIDE, rel=1e-9)
    assert kernel.argmax() == 80


def test_a_surface_keeps_the_spectra_of_its_profiles_and_of_the_fit():
    """Against the periodogram of SciPy, whose density is of one side, at the waves that stand alone."""
    profiles = rows(rough())
    drawn = rc.surface_from_profiles(profiles, spacing=0.5)
    spectra = {key: np.array(values) for key, values in json.loads(drawn.attrs["profile_spectra"]).items()}
    pieces, pitch = profile_pieces(profiles)
    taper = np.sin(np.pi * (np.arange(SIDE) + 0.5) / SIDE) ** 2
    frequency, density = scipy.signal.periodogram(pieces, 1 / pitch, window=taper, detrend=False)
    resolved_waves = slice(1, 6)
    np.testing.assert_allclose(spectra["wavenumber"][:5], 2 * np.pi * frequency[resolved_waves], rtol=1e-12)
    np.testing.assert_allclose(spectra["profiles"][:5], density.mean(axis=0)[resolved_waves] / 2, rtol=1e-9)
    powers = [scipy.integrate.trapezoid(spectra[key], spectra["wavenumber"]) for key in ("profiles", "fit")]
    assert powers[1] == pytest.approx(powers[0], rel=0.1)  # the scatter of single waves is not fitted


def test_normal_heights_stay_normal_and_skewed_ones_stay_skewed():
    rng, scores = np.random.default_rng(0), finish._SCORES
    normal = finish._heights(rng.standard_normal(500), 500.0)
    near = np.abs(scores) < 2
    assert np.abs(normal - scores)[near].max() < 0.15
    sample = np.sort(rng.exponential(size=4000))
    skewed = finish._heights(sample, 4000.0)
    exact = -np.log1p(-scipy.special.ndtr(scores)) - 1  # mean 0, standard deviation 1
    assert np.abs(skewed - exact)[near].max() < 0.15


def test_the_tail_is_extrapolated_linearly_over_the_score():
    heights = finish._heights(np.random.default_rng(0).exponential(size=400), 40.0)
    tail = -scipy.special.ndtri(0.5 / 40) < finish._SCORES
    steps = np.diff(heights[tail])
    assert steps.min() > 0
    np.testing.assert_allclose(steps, steps[0], rtol=1e-6)


def test_a_drawn_surface_has_the_amplitudes_and_the_skewness():
    surface = rough()
    plateaus = surface.copy(data=-np.exp(-0.6 * surface.values))
    fit = fitted(plateaus, 20)
    profile_statistics = fit_statistics(fit)
    drawn = draw(profile_statistics, SIDE, 1.0, np.random.default_rng(0))
    f, density = density_of(drawn)
    expected = profile_statistics.spectrum.at(f)
    np.testing.assert_allclose(density, expected, atol=1e-9 * expected.max())
    # the amplitudes, which come last, take a part of it
    skewness = [scipy.stats.skew(heights, axis=None) for heights in (drawn, plateaus.values)]
    assert 0.6 < skewness[0] / skewness[1] < 1.1
    steps, tops = np.diff(drawn, axis=1) ** 2, drawn[:, 1:] > np.quantile(drawn, 0.9)
    true_steps = np.diff(plateaus.values, axis=1) ** 2
    true_tops = plateaus.values[:, 1:] > np.quantile(plateaus.values, 0.9)
    ratio, true = steps[tops].mean() / steps.mean(), true_steps[true_tops].mean() / true_steps.mean()
    assert ratio == pytest.approx(true, abs=0.15)  # 0.2: flat tops, where independent slopes would give 1
    assert ratio < 0.5


def test_the_pitch_of_a_surface_is_chosen_and_its_spectrum_kept():
    profiles = rows(rough())
    fine = rc.surface_from_profiles(profiles, points=400, spacing=0.5)
    coarse = rc.surface_from_profiles(profiles, points=200)
    assert fine.shape == (400, 400)
    assert float(fine["x"][1] - fine["x"][0]) == pytest.approx(0.5)
    assert rms_gradient(fine) == pytest.approx(rms_gradient(coarse), rel=0.03)


def test_the_seed_makes_the_surface():
    profiles = rows(rough())
    surface, repetition, other_seed = (rc.surface_from_profiles(profiles, seed=seed) for seed in (1, 1, 2))
    xr.testing.assert_identical(surface, repetition)
    assert np.corrcoef(surface.values.ravel(), other_seed.values.ravel())[0, 1] < 0.2


def test_profiles_of_several_lengths_and_with_missing_points():
    long, short, holed = rows(rough(), 3)
    holed = holed.copy(data=holed.values)
    holed[0, :40] = np.nan
    pieces, _ = profile_pieces([long, short[:, :100], holed])
    assert pieces.shape == (5, 100)  # 256 // 100, 1 and 216 // 100


def test_columns_are_profiles_as_well():
    row = rows(rough(), 1)[0]
    column = row.rename(x="y", y="x").transpose("y", "x")
    expected = rc.surface_from_profiles([row])
    xr.testing.assert_allclose(expected, rc.surface_from_profiles([column]))
    xr.testing.assert_allclose(expected, rc.surface_from_profiles(row))
    stretches = [rc.surface_from_profiles(row, along=along).attrs["stretch"] for along in (column, [column])]
    np.testing.assert_allclose(stretches, 1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda profiles: [], "profiles: have no points"),
        (lambda profiles: [rough()], "profiles: have 256 x 256 points; give one-row maps"),
        (lambda profiles: [profiles[0], height_map(profiles[1].values, 2.0)], "give profiles of one pitch"),
        (lambda profiles: [profiles[0][:, :50]], "50 points in one stretch are too few"),
        (lambda profiles: [0 * profiles[0]], "is flat"),
    ],
)
def test_profiles_without_a_surface(change, message):
    with pytest.raises(HeightMapError, match=message):
        rc.surface_from_profiles(change(rows(rough())))


@pytest.mark.cases
def test_other_lays_have_no_surface(lay, message):
    with pytest.raises(SettingsError, match=message):
        rc.surface_from_profiles(rows(rough()), lay=lay)


def test_sizes_that_are_none():
    profiles = rows(rough())
    for wrong, words in (
        ({"points": 0}, "points = 0: give a whole number"),
        ({"points": 64.5}, "points = 64.5: give a whole number"),
        ({"points": [64, 64]}, r"points = \[64, 64\]: give a whole number"),
        ({"points": np.nan}, "points = nan: give a whole number"),
        ({"seed": -1}, "seed = -1: give a whole number of 0 or more"),
        ({"spacing": 0.0}, "spacing = 0 must be a positive"),
        ({"spacing": "2 kg"}, "unknown length unit 'kg'"),
        ({"points": 64, "spacing": 1e6}, "points = 64: at this spacing the surface has none of the waves"),
    ):
        with pytest.raises(SettingsError, match=words):
            rc.surface_from_profiles(profiles, **wrong)


def test_a_pitch_may_be_text_and_a_surface_small():
    profiles = rows(rough())
    assert rc.surface_from_profiles(profiles, points=4).shape == (4, 4)
    with_unit, plain = (
        rc.surface_from_profiles(profiles, points=64, spacing=step) for step in ("500 mm", 0.5)
    )
    np.testing.assert_array_equal(with_unit, plain)


def warnings_of(profiles):
    return json.loads(rc.surface_from_profiles(profiles).attrs["profile_warnings"])


def test_good_profiles_have_no_warnings():
    assert warnings_of(rows(rough())) == []


def test_profiles_of_two_directions_are_flagged():
    lay = rough(stretch=8)
    across, along = height_map(lay.values[10], 1.0), height_map(lay.values[:, 10], 1.0)
    assert any("two directions" in text for text in warnings_of([across, along]))
    assert not any(
        "two directions" in text for text in warnings_of([across, height_map(lay.values[99], 1.0)])
    )


@pytest.mark.parametrize("seed", [1, 2])
def test_a_moderate_lay_is_flagged_by_three_profiles_each(seed):
    lay = rough(seed, stretch=2)
    columns = [height_map(lay.values[:, number], 1.0) for number in (20, 120, 200)]
    assert any("two directions" in text for text in warnings_of([*rows(lay, 3), *columns]))


@pytest.mark.parametrize("stretch", [2.0, 4.0])
def test_profiles_of_both_directions_have_one_surface(stretch):
    """Its slopes, its autocorrelation and its contact area are those of the surface with this lay."""
    lay = rough(stretch=stretch, side=384)
    across = [height_map(lay.values[row], 1.0) for row in range(30, 384, 70)]
    along = [height_map(lay.values[::2, column], 2.0) for column in range(30, 384, 70)]
    drawn = rc.surface_from_profiles(across, along=along)
    assert "stretched" not in drawn.attrs["profile_warnings"]
    assert drawn.attrs["stretch"] == pytest.approx(stretch, rel=0.15)
    for axis in (0, 1):
        slopes = [np.diff(surface.values, axis=axis).std() for surface in (drawn, lay)]
        assert slopes[0] == pytest.approx(slopes[1], rel=0.1)
    assert drawn.values.std() == pytest.approx(lay.values.std(), rel=0.15)
    load = {"contact_modulus": 1.0, "mean_pressure": 0.1 * rms_gradient(lay), "tolerance": 1e-3}
    areas = [rc.solve_contact(surface, **load)["contact"].mean().item() for surface in (drawn, lay)]
    assert areas[0] == pytest.approx(areas[1], rel=0.1)


def test_fine_roughness_alike_in_all_directions_over_ridges_is_no_stretched_spectrum():
    fine = rough(side=384).values
    ridges = fine + 4 * np.sin(2 * np.pi * np.arange(384) / 96)
    drawn = rc.surface_from_profiles([height_map(ridges[5], 1.0)], along=[height_map(ridges[:, 5], 1.0)])
    assert "not a stretched one" in drawn.attrs["profile_warnings"]


def test_a_drawn_surface_is_not_cut_into_profiles_again():
    drawn = rc.surface_from_profiles(rows(rough()))
    with pytest.raises(HeightMapError, match="was drawn from profiles"):
        rc.evaluate(drawn.assign_attrs(units="m"), contact=CONTACT)


def test_short_profiles_are_flagged():
    assert "correlation lengths" in warnings_of([rows(rough())[0][:, :64]])[0]


def test_a_step_in_a_trace_is_flagged():
    profile = rows(rough())[0]
    profile[0, 100:] += 10
    assert any("single step" in text for text in warnings_of([profile]))


def test_waves_longer_than_the_surface_are_flagged():
    wave = 30 * np.sin(np.arange(4096) / 400)
    profile = height_map(np.resize(rough().values[5], 4096) + wave, 1.0)
    assert any("Waves longer than the surface" in text for text in warnings_of([profile]))


@pytest.fixture(scope="module")
def answers():
    surface = rough().assign_coords(x=np.arange(SIDE) * 1e-6, y=np.arange(SIDE) * 1e-6) * 3e-7
    surface.attrs["units"] = "m"
    profiles = [surface[[row]] for row in (20, 70, 120, 170, 220)]
    options = {"contact": CONTACT, "uncertainty": {"sources": ["solver", "window"], "windows": 5}}
    return {
        "surface": rc.evaluate(surface, contact=CONTACT, uncertainty={"sources": []}),
        "five": rc.evaluate(profiles, lay="none", **options),
        "one": rc.evaluate(profiles[0], lay="none", **options),
        "across": rc.evaluate(profiles[0], lay="across", **options),
        "unstated": rc.evaluate(profiles[0], **options),
    }


def test_the_contact_of_the_surface_behind_profiles(answers):
    true = answers["surface"]
    for name in ("five", "one"):
        result = answers[name]
        for quantity in ("relative_contact_area", "mean_gap"):
            assert (result[f"{quantity}_lower"] < true[quantity]).all()
            assert (true[quantity] < result[f"{quantity}_upper"]).all()
        assert "surfaces with this spectrum" in result.attrs["window_reason"]
    area = answers["five"]["relative_contact_area"] / true["relative_contact_area"]
    assert np.abs(area - 1).max() < 0.15
    assert (answers["across"]["relative_contact_area"] > 1.3 * true["relative_contact_area"]).all()


@pytest.fixture(scope="module")
def both_directions():
    """Return a surface with a lay, and its contact by profiles across the lay and along it."""
    lay = rough(2, stretch=4.0).assign_coords(x=np.arange(SIDE) * 1e-6, y=np.arange(SIDE) * 1e-6) * 3e-7
    across = [lay[[row]] for row in (20, 70, 120, 170, 220)]
    along = [height_map(lay.values[:, column], 1e-6) for column in (40, 140, 240)]
    options = {"contact": CONTACT, "lay": "across", "uncertainty": {"sources": ["solver", "window"]}}
    return lay, rc.evaluate(across, along=along, **options), rc.evaluate(across[0], along=along[0], **options)


def test_the_contact_of_the_surface_behind_profiles_of_both_directions(both_directions):
    lay, several, single = both_directions
    true = rc.evaluate(lay, contact=CONTACT, uncertainty={"sources": []})
    for result in (several, single):
        for quantity in ("relative_contact_area", "mean_gap"):
            assert (result[f"{quantity}_lower"] < true[quantity]).all()
            assert (true[quantity] < result[f"{quantity}_upper"]).all()
    area = several["relative_contact_area"] / true["relative_contact_area"]
    assert np.abs(area - 1).max() < 0.15
    assert several.attrs["lay"] == "both"
    assert "that 8 profiles might have shown" in several.attrs["window_reason"]
    reasons = {reason["check"]: reason["text"] for reason in json.loads(several.attrs["reasons"])}
    assert "two directions" not in reasons.get("Lay", "")


def test_profiles_along_keep_their_pitch_beside_those_across():
    lay = rough(stretch=4.0)
    across, along = rows(lay, 3), [height_map(lay.values[::2, column], 2.0) for column in (40, 140)]
    options = {"form": "plane", "l_filter": 100.0}
    levelled = ProfilesPreparation().level(stacked(across, along), options)
    window = ProfilesPreparation().window(levelled, {"window": {}})
    expected = rc.surface_from_profiles(
        [rc.level(profile, **options) for profile in across],
        along=[rc.level(profile, **options) for profile in along],
    )
    np.testing.assert_allclose(window.values, expected.values, atol=1e-9 * float(expected.std()))
    assert (window.attrs["stretch"], window.attrs["profiles"]) == (
        pytest.approx(expected.attrs["stretch"]),
        5,
    )
    assert levelled.attrs["missing_points"] == 0


def test_the_scatter_of_both_directions_is_larger_by_that_of_the_stretch():
    lay = rough(stretch=4.0).values
    across, along = lay[:200:40], lay[:, :200:40].T
    fit = ProfileFit([(across, 1.0), (along, 1.0)], 1)
    drawn = [fit_statistics(fit, np.random.default_rng(seed)) for seed in range(30)]
    stretches = np.log([fit_drawn.stretch / fit.stretch for fit_drawn in drawn])
    # the chance of the rms slope, from the mean square slopes of the pieces of both directions
    pieces = [np.diff(profiles[:, :255].reshape(25, -1)) for profiles in (across, along)]
    chances = [np.mean(piece**2, axis=1).std() / np.mean(piece**2) / 2 / np.sqrt(25) for piece in pieces]
    assert stretches.std() == pytest.approx(np.hypot(*chances), rel=0.4)
    assert abs(stretches.mean()) < np.hypot(*chances)


def test_missing_points_of_a_profile_without_a_lay_are_filled_and_its_ends_left_out():
    options = {"lay": "none", "contact": CONTACT, "uncertainty": {"sources": ["solver"]}}
    profile = rough()[[20]].assign_coords(x=np.arange(SIDE) * 1e-6) * 3e-7
    holed = profile.copy()
    holed[0, 100:103] = np.nan
    cut, ended = profile[:, 4:], profile.where(profile.x >= 4e-6)
    intact, filled = (rc.evaluate(heights, **options) for heights in (profile, holed))
    np.testing.assert_allclose(filled["relative_contact_area"], intact["relative_contact_area"], rtol=0.05)
    column = rc.evaluate(profile.rename(x="y", y="x").transpose("y", "x"), **options)
    np.testing.assert_allclose(column["relative_contact_area"], intact["relative_contact_area"])
    areas = [rc.evaluate(heights, **options)["relative_contact_area"].values for heights in (cut, ended)]
    np.testing.assert_allclose(*areas)


def test_the_lay_decides_and_is_asked_for(answers):
    def reasons(name):
        return {reason["check"]: reason["text"] for reason in json.loads(answers[name].attrs["reasons"])}

    assert not {"Lay"} & ({*reasons("five")} | {*reasons("across")})
    assert "State lay = across" in reasons("unstated")["Lay"]
    assert (answers["unstated"]["verdict"] >= 1).all()
    ridges, isotropic = (
        answers["unstated"][f"relative_contact_area{suffix}"].values for suffix in ("", "_if_isotropic")
    )
    np.testing.assert_allclose(ridges, answers["across"]["relative_contact_area"])
    np.testing.assert_allclose(isotropic, answers["one"]["relative_contact_area"], rtol=0.25)
    for area in (ridges[0], isotropic[0]):
        assert percent(area) in reasons("unstated")["Lay"]


def test_a_lay_is_of_profiles():
    with pytest.raises(HeightMapError, match="lay = none: is of profiles, and this is a map of 256 x 256"):
        rc.evaluate(rough(), lay="none", contact=CONTACT)
    with pytest.raises(
        HeightMapError, match="lay = across: several profiles have one answer where lay = none"
    ):
        rc.evaluate(rows(rough()), lay="across", contact=CONTACT)
    with pytest.raises(SettingsError, match="along: is of a surface with a lay, and lay = 'none'; state lay"):
        rc.evaluate(rows(rough()), lay="none", along=rows(rough()), contact=CONTACT)
    with pytest.raises(HeightMapError, match="lay = not stated: several profiles"):
        rc.evaluate(rows(rough()), contact=CONTACT)
    contact = {"contact_modulus": 1e9, "boundary": "free", "force": 1.0}
    with pytest.raises(HeightMapError, match="drawn at random: its ± on a body of finite size is unknown"):
        rc.evaluate(rows(rough())[0] * 1e-6, lay="none", contact=contact, form={"radius": 1.0})
    with pytest.raises(SettingsError, match="shows nothing of the others"):
        rc.evaluate(rows(rough())[0], lay="along", contact=CONTACT)
    profile = rows(rough())[0].assign_attrs(source_file="a.csv")
    with pytest.raises(
        SettingsError,
        match=r"instrument\.correct = true: a\.csv is of profiles with a surface behind them, on which the "
        "noise of lines is not white; leave it out: the ± then includes noise and lens",
    ):
        rc.evaluate(profile, lay="none", contact=CONTACT, instrument={"noise": 1e-3, "correct": True})


def test_the_check_names_what_is_wrong_with_the_profiles():
    check = map_checks.lay(xr.Dataset(), {"lay": "none", "profile_warnings": '["Too short."]'})
    assert (check.outcome, check.sentence) == ("review", "Too short.")
    ridge = xr.Dataset({"window_length_x": 1.0, "window_length_y": np.nan})
    assert map_checks.lay(ridge, {"lay": "across"}).outcome == "passed"
    assert map_checks.lay(ridge.assign(window_length_y=1.0), {}) is None
