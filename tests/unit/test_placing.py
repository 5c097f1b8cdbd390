"""The place of a map in its overview, found by correlation, against places that are known."""

import re

import numpy as np
import pytest
import scipy

from roughcontact import HeightMapError, height_map, level, self_affine_surface
from roughcontact.arguments.maps import spacing
from roughcontact.surface.faces import placing

PITCH = 1e-6
FINE = (slice(90, 200), slice(150, 270))  # rows, columns of the field


@pytest.fixture(scope="module")
def field():
    """Return a rough field that is no period of itself along its sides."""
    options = {"hurst": 0.7, "shortest": 6 * PITCH, "longest": 200 * PITCH, "rms_height": 1e-6, "seed": 3}
    return self_affine_surface((420, 450), PITCH, **options)[:330, :360]


def overview_of(field, *, factor=3, rotation=0.0, scale=1.0, noise=0.02):
    """Return the field as a coarse, noisy instrument has it, turned and stretched about its middle."""
    angle, middle = np.radians(rotation), (np.array(field.shape) - 1) / 2
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) / scale
    heights = scipy.ndimage.affine_transform(
        field.values, turn, offset=middle - turn @ middle, order=3, mode="nearest"
    )
    heights = scipy.ndimage.gaussian_filter(heights, 0.6 * factor)
    merged = field.copy(data=heights).coarsen(y=factor, x=factor, boundary="trim").mean()
    generator = np.random.default_rng(0)
    return level(merged + generator.normal(0, noise * float(field.std()), merged.shape))


@pytest.mark.parametrize(("rotation", "scale"), [(0.0, 1.0), (2.0, 1.0), (-1.5, 1.02), (0.0, 0.97)])
def test_a_map_is_found_where_it_was_cut_out(field, rotation, scale):
    fine = level(field[FINE])
    place = placing.place_of(fine, overview_of(field, rotation=rotation, scale=scale))
    angle = np.radians(rotation)
    turn = scale * np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    middles = [np.array([float(each[axis].mean()) for axis in "yx"]) for each in (field, field[FINE])]
    expected = middles[0] + turn @ (middles[1] - middles[0])
    assert [place.y, place.x] == pytest.approx(expected, abs=1.5 * PITCH)  # half a pixel of the overview
    assert place.rotation == pytest.approx(rotation, abs=0.7)
    assert place.scale == pytest.approx(scale, abs=0.005)
    assert place.correlation > 0.95
    assert place.uncertainty < placing.MAX_UNCERTAINTY


@pytest.mark.cases
def test_a_map_turned_or_stretched_beyond_the_search_is_said_to_be_so(field, rotation, scale, words):
    place = placing.place_of(level(field[FINE]), overview_of(field, rotation=rotation, scale=scale))
    assert words in str(place)


@pytest.mark.parametrize("unit", [1.0, 0.1, 1e6, 7.3])
def test_where_pixels_of_both_coincide_the_place_is_exact_in_every_unit(field, unit):
    """Of 40 x 40 pixels of the overview none is lost by the rounding of coordinates."""
    fine, overview = field[90:210, 150:270], field.coarsen(y=3, x=3).mean()
    in_unit = [each.assign_coords(x=unit * each.x, y=unit * each.y) for each in (fine, overview)]
    place = placing.place_of(*in_unit)
    assert (place.scale, place.rotation) == (1.0, 0.0)
    assert place.correlation == pytest.approx(1, abs=1e-9)
    expected = [unit * float(fine[axis].mean()) for axis in "yx"]
    assert [place.y, place.x] == pytest.approx(expected, abs=0.05 * unit * PITCH)


def test_the_height_scale_and_the_form_of_the_other_instrument_count_for_nothing(field):
    overview, fine = overview_of(field), level(field[FINE])
    y, x = np.meshgrid(*(overview[axis] for axis in "yx"), indexing="ij")
    tilted = overview.copy(data=7 * overview.values + 0.02 * y - 0.01 * x + 1e-5)
    one, other = placing.place_of(fine, overview), placing.place_of(fine, tilted)
    assert (other.y, other.x, other.correlation) == pytest.approx((one.y, one.x, one.correlation))


def test_another_place_is_refused_in_one_sentence(field):
    elsewhere = level(field[FINE].copy(data=field[FINE].values[::-1, ::-1]))
    elsewhere.attrs["source_file"] = "fine.x3p"
    overview = overview_of(field).assign_attrs(source_file="overview.x3p")
    with pytest.raises(HeightMapError) as caught:
        placing.place_of(elsewhere, overview)
    assert re.fullmatch(
        r"overview: overview.x3p does not show the place of fine.x3p: it fits best at \(.*, .*\),.* "
        r"correlation 0\.\d+, and has to have 0.8; measure both without moving the part, the map in the "
        r"middle of the overview, or state overview_position: x and y, or elsewhere",
        str(caught.value),
    )


def test_a_grating_fits_at_several_places():
    x = np.arange(360) * PITCH
    grating = height_map(np.tile(1e-6 * np.sin(2 * np.pi * x / (30 * PITCH)), (330, 1)), PITCH)
    with pytest.raises(HeightMapError, match="fits into a map at several places"):
        placing.place_of(level(grating[FINE]), level(grating.coarsen(y=3, x=3).mean()))


def test_of_a_grating_the_place_may_be_stated():
    x = np.arange(360) * PITCH
    grating = height_map(np.tile(1e-6 * np.sin(2 * np.pi * x / (30 * PITCH)), (330, 1)), PITCH)
    fine, overview = level(grating[FINE]), level(grating.coarsen(y=3, x=3).mean())
    place = placing.place_of(fine, overview, near=(212e-6, 147e-6))
    assert place.x == pytest.approx(float(fine.x.mean()), abs=1.5 * PITCH)
    assert place.y == pytest.approx(147e-6, abs=0.1 * 110 * PITCH + 1.5 * PITCH)


def test_a_stated_place_beyond_the_overview_or_with_other_heights_is_refused(field):
    fine, overview = level(field[FINE]), overview_of(field)
    with pytest.raises(HeightMapError, match="with its middle at y = 310 µm the map reaches"):
        placing.place_of(fine, overview, near=(210e-6, 310e-6))
    with pytest.raises(HeightMapError, match="does not show the place of a map"):
        placing.place_of(fine, overview, near=(120e-6, 200e-6))


def test_an_overview_of_another_position_has_no_place(field):
    fine, overview = level(field[FINE]), overview_of(field)
    shown = placing.overview_with_place(fine, overview, "elsewhere")
    assert placing.recorded_place(shown) is None
    assert placing.frame_of_place(shown, fine) is None
    joined = placing.joined_overviews([shown, placing.overview_with_place(fine, overview)])
    one, other = placing.separate_overviews(joined)
    assert one.equals(shown.reset_coords(drop=True))
    assert [placing.recorded_place(each) is None for each in (one, other)] == [True, False]


@pytest.mark.parametrize(
    ("cut", "factor", "reason"),
    [
        ((slice(0, 300), slice(0, 300)), 3, "measure a field at least twice as long"),
        (FINE, 12, "needs 16"),
        (FINE, 1, "pixels are hardly larger"),
        ((slice(0, 1), slice(0, 100)), 3, "a profile has no overview"),
    ],
)
def test_an_overview_that_shows_too_little_is_refused(field, cut, factor, reason):
    with pytest.raises(HeightMapError, match=reason):
        placing.place_of(field[cut], field.coarsen(y=factor, x=factor, boundary="trim").mean())


@pytest.mark.parametrize("what", ["whole", "origin", "missing border", "masked border", "part"])
def test_a_position_is_of_the_middle_of_the_map_from_the_corner_of_the_overview(what):
    """On a grating any other place of the same phase fits as well, so that the position alone tells."""
    x = np.arange(360) * PITCH
    grating = height_map(np.tile(1e-6 * np.sin(2 * np.pi * x / (20 * PITCH)), (330, 1)), PITCH)
    fine, overview, middle = grating[FINE].copy(), grating.coarsen(y=3, x=3).mean(), None
    if what == "origin":  # as files with axes have it
        overview = overview.assign_coords(x=overview.x - 7e-4, y=overview.y + 2e-4)
    elif what == "missing border":
        overview[:, :20] = np.nan
    elif what == "masked border":
        fine[:, :40] = np.nan
    elif what == "part":
        fine, middle = fine[:, 40:], placing.middle_of(fine)
    shown = placing.overview_with_place(
        level(fine, fill="none"), level(overview, fill="none"), "210 145 um", middle
    )
    left = {"masked border": 40, "part": 40}.get(what, 0)
    assert placing.recorded_place(shown).x == pytest.approx((150 + left + 270) / 2 * PITCH, abs=PITCH)
    assert placing.place_attributes([shown], level(fine, fill="none"))["offset_x"] == pytest.approx(
        (150 + left) * PITCH, abs=1.5 * PITCH
    )


def test_missing_points_are_left_out(field):
    holed = field.copy(deep=True)
    holed[:40] = np.nan
    whole = placing.measured_rectangle(holed)
    assert whole.shape == (290, 360)
    assert spacing(whole) == spacing(field)
    place = placing.place_of(level(field[FINE]), whole.coarsen(y=3, x=3, boundary="trim").mean())
    assert place.y == pytest.approx(float(field[FINE].y.mean()), abs=PITCH)
