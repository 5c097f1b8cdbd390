"""Files that are damaged, foreign or hostile, and maps that look wrong."""

import json
import os

import numpy as np
import pytest
import x3pio
from measured_files import GIVEN, archive, array, labelled, members, refuses, warnings_of, x3p

from roughcontact import HeightMapError, composite, height_map, inspect_file, level, read_height_map
from roughcontact.io import guards, instrument_kinds
from roughcontact.io.plausibility import quantisation_step, roughness_off_plane, suspicions
from roughcontact.statistics.instrument_checks import quantisation

HEIGHTS = np.arange(12.0).reshape(3, 4) * 1e-6


def test_what_is_no_file(refusal, tmp_path):
    refuses("no such file", tmp_path / "absent.x3p")
    refuses("is a folder", tmp_path)
    refusal(b"", "the file is empty")
    os.mkfifo(tmp_path / "pipe")
    refuses("no regular file", tmp_path / "pipe")


@pytest.mark.parametrize("size", [1, 64, 512, 2 * 64 * 64, 2 * 128 * 128, 8 * 100 * 100])
def test_rubbish_is_never_a_map(refusal, size):
    for data in (bytes(size), b"\xff" * size, np.random.default_rng(size).bytes(size)):
        message = refusal(data, "map", name="map.hgt", **GIVEN)
        assert len(message) < 400
        assert "\n" not in message


PROFILE = "".join(f"{0.5 * i}\t{i * i % 7}\n" for i in range(12))


def test_of_many_profiles_the_first_ones_are_named(refusal):
    message = refusal("x (µm)\tz (nm)\n" + 30 * PROFILE, "profiles of one surface")
    assert "are 'profile 1; profile 2; ...'" in message
    assert len(message) < 600


@pytest.mark.parametrize("heading", ["{}\tz (nm)\n", "x (µm)\tz (nm) {}\n"])
def test_of_tables_below_one_another_long_headings_are_cut(refusal, heading):
    tables = [heading.format("abcd " * 60 + name) + PROFILE for name in "ABCD"]
    assert len(refusal("".join(tables), "4 tables below one another")) < 600


BOMB = '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;">]><a>&y;</a>'
BLANKS, DOCTYPE, WHOLE = b" " * 2**21, "DOCTYPE, which is refused", x3p(HEIGHTS)
DEEP = x3p(HEIGHTS, edit=lambda main: main.replace(b"<SizeZ>1<", b"<SizeZ>100000000<"))  # layers
WIDE = x3p(HEIGHTS, edit=lambda main: main.replace(b"<SizeX>4<", b"<SizeX>400000000<"))
MANY = x3p(HEIGHTS, edit=lambda main: main.replace(b"<SizeZ>1<", b"<SizeZ>10001<"))
# a file, words of its refusal
NO_X3P = [
    (x3p(HEIGHTS, edit=lambda _: BOMB.encode("utf-8")), DOCTYPE),
    (x3p(HEIGHTS, edit=lambda _: BOMB.encode("utf-16")), DOCTYPE),
    (archive({"main.xml": b"<a>" + BLANKS + b"<!DOCTYPE a>"}), DOCTYPE),
    (archive({"main.xml": BLANKS + b"<p:ISO5436_2/>"}), "begins with .* bytes of blanks: it is no XML"),
    (WIDE, "3 x 400000000 points, more than the 134217728 that are read"),  # before any is read
    (DEEP, "100000000 maps of 3 x 4 points, more than the 134217728 that are read"),
    (MANY, "more than the 10000 that are read"),
    (WHOLE[: int(0.6 * len(WHOLE))], "without its end"),
]


@pytest.mark.parametrize(("data", "words"), NO_X3P, ids=[words for _, words in NO_X3P])
def test_damaged_or_hostile_x3p_is_refused(refusal, data, words):
    refusal(data, words)


def test_zip_bomb_is_refused_before_it_unpacks(read, refusal, monkeypatch):
    monkeypatch.setattr(guards, "MAX_UNPACKED_BYTES", 10**6)
    bomb = archive(members(x3p(HEIGHTS)) | {"vendor/one.bin": bytes(12 * 10**5)})
    assert len(bomb) < 10**5
    refusal(bomb, "the archive would unpack to")
    assert read(x3p(HEIGHTS)).shape == (3, 4)


def rough(n=64, seed=0):
    """A smooth random map of about 1 µm rms on a field of 64 µm."""
    rng = np.random.default_rng(seed)
    q = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.fftfreq(n)[None, :])
    spectrum = np.fft.fft2(rng.standard_normal((n, n))) * np.exp(-((q * 12) ** 2))
    height = np.fft.ifft2(spectrum).real
    return 1e-6 * height / height.std()


def words(height, dx=1e-6, dy=1e-6, kind=instrument_kinds.UNKNOWN):
    return "\n".join(map(str, suspicions(height, dx, dy, kind=kind)))


def test_a_sound_map_raises_no_suspicion_unless_its_pixels_have_an_odd_ratio():
    for dy in (1e-6, 1.005e-6, 2e-6, 0.25e-6):
        assert suspicions(rough(), 1e-6, dy) == []
    assert "the pixels are not square: dx = 1.000 µm, dy = 1.020 µm" in words(rough(), dy=1.02e-6)


@pytest.mark.parametrize("ratio", [5, 8, 1000, 1234])
def test_long_pixels_are_named_whatever_their_ratio(read, ratio):
    """Whole ratios too: a width in mm beside a height in µm. In a pair each face says it."""
    height = read(array(1e-6 * rough()), dx=f"{ratio} um", dy="1 um", height_unit="m")
    (message,) = [note for note in json.loads(height.attrs["ingest_warnings"]) if "not square" in note]
    assert f"one is {ratio}" in message.replace(".00 times", "")
    assert message not in json.loads(height.attrs["ingest_facts"])  # a warning, no mere note
    pair = composite(height, height)
    assert sum(message in note for note in json.loads(pair.attrs["ingest_warnings"])) == 2


def changed(index, value):
    height = rough()
    height[index] = value
    return height


@pytest.mark.parametrize(
    ("height", "message"),
    [
        (1e3 * rough(), "more than the field"),
        (changed((10, 20), -5e-5), "1 point lies far below all others (down to −50.0 µm"),
        (changed((5, slice(5, 8)), 4e-5), "3 points lie far above all others"),
        (changed((1, 20), 4e-5)[:2], "1 point lies far above all others (up to 40.0 µm"),
        (changed((1, 20), 4e-5)[:2, :32], "1 point lies far above all others (up to 40.0 µm"),
        (np.minimum(rough(), 1.5e-6), "exactly the highest height"),
        (np.maximum(rough(), -1.5e-6), "exactly the lowest height"),
        (2e-6 * np.exp(np.round(rough() / 2e-7) / 5), "different heights occur, at odd distances"),
        (changed([7, 30], 0.0), "2 of 64 rows are constant"),
        (changed(np.s_[:, 12], rough()[:, 11]), "1 of 64 columns repeat the one before exactly"),
        (np.vstack([rough()[:8]] * 2), "second half of the rows repeats the first exactly"),
        (1e-7 * np.random.default_rng(5).standard_normal((64, 64)), "neighbouring points are unrelated"),
        (np.zeros((8, 8)), "all heights are equal"),
        (changed(np.s_[20:28, 30:36], rough().mean()), "1.17 % of the points have exactly the height"),
        (changed(np.s_[0, ::10], 1e-7)[:3, :32], "4.17 % of the points have exactly the height"),
    ],
)
def test_what_looks_wrong_is_said(height, message):
    assert message in words(height)


def test_levels_of_one_step_are_judged_later():
    assert "different heights occur" not in words(2e-7 * np.round(rough() / 2e-7))


def test_a_single_bad_point_is_no_matter_of_units():
    warnings = words(changed((7, 9), -1.0))
    assert "1 point lies far below all others" in warnings
    assert "more than the field" not in warnings
    assert "check the height unit" not in warnings


def test_absurd_heights_are_refused(refusal):
    message = "are no measurement: the height unit is wrong, the number marks"
    refusal(array(1e12 * rough()), message, error=HeightMapError, dx=1e-6, dy=1e-6, unit="m")


@pytest.mark.parametrize(
    ("kind", "scale", "step", "message"),
    [
        (instrument_kinds.PROBE, 1e-2, 1e-8, None),
        (instrument_kinds.PROBE, 1e-2, 1e-5, "steps of 10.0 µm are unusual for a scanning probe microscope"),
        (instrument_kinds.PROBE, 100, 5e-6, "heights that span"),
        (instrument_kinds.OPTICAL, 1, 1e-6, None),
        (instrument_kinds.OPTICAL, 1e-3, 1e-9, "steps of 1.00 nm are unusual for an optical profiler"),
        (instrument_kinds.OPTICAL, 1, 2e-2, "a field of 1.28 m is unusual for an optical profiler"),
        (instrument_kinds.STYLUS, 1, 1e-6, None),
        (instrument_kinds.STYLUS, 1, 2e-3, "steps of 2.00 mm are unusual for a stylus profiler"),
        (instrument_kinds.STYLUS, 1e-6, 1e-6, "heights that span"),
        (instrument_kinds.UNKNOWN, 1, 2e-2, "a field of 1.28 m is unusual for a roughness measurement"),
    ],
)
def test_ranges_of_the_kind_of_instrument(kind, scale, step, message):
    warnings = words(scale * rough(), step, step, kind)
    assert "unusual" not in warnings if message is None else message in warnings


def test_the_kind_comes_from_the_file(read):
    """Steps of 1 nm are no matter for an unknown instrument; with light they cannot be."""
    probing = x3pio.ProbingSystem(type=x3pio.ProbingType.NON_CONTACTING, identification="50x")
    metadata = x3pio.Metadata(
        instrument=x3pio.Instrument(model="maker 1", serial="7"), probing_system=probing
    )
    light = read(x3p(1e-3 * rough(), 1e-9, 1e-9, metadata=metadata))
    assert "unusual for an optical profiler" in warnings_of(light)
    instrument = json.loads(light.attrs["instrument"])
    assert (instrument["name"], instrument["serial"], instrument["lens"]) == ("maker 1", "7", "50x")
    assert warnings_of(read(x3p(1e-3 * rough(), 1e-9, 1e-9))) == ""


def test_exchanged_sizes():
    message = "they would be with 64 rows of 48 points: rows and columns, or the two sizes, were exchanged"
    assert message in words(rough()[:48], dx=48e-6 / 64, dy=64e-6 / 48)


def test_slopes_that_cannot_be():
    _, gradient = roughness_off_plane(rough(), 1e-6, 1e-6)
    # above 72 degrees nothing is measured; below 1e-8 nothing is polished
    for steep, is_named in ((2.9, False), (3.1, True)):
        assert ("steeper than anything that is measured" in words(steep / gradient * rough())) == is_named
    assert "(rms gradient 3.10, 72°): check the units" in words(3.1 / gradient * rough())
    for flat, is_named in ((0.9e-8, True), (1.1e-8, False)):
        assert ("smaller than those of polished optics" in words(flat / gradient * rough())) == is_named


def test_roughness_off_the_plane():
    """A tilted wave of whole periods: rms a/√2 and gradient √2 π a/λ, whatever the tilt."""
    y, x = np.indices((64, 128)) * 1e-6
    wave = 2e-7 * np.cos(2 * np.pi * x / 32e-6)
    tilted = wave + 0.01 * x - 0.02 * y + 5e-4
    rms_height, rms_gradient = roughness_off_plane(tilted, 1e-6, 1e-6)
    assert rms_height == pytest.approx(2e-7 / np.sqrt(2), rel=1e-3)
    # a central difference over one step shrinks the slope by sin(πd/λ)/(πd/λ)
    exact = np.sqrt(2) * np.pi * 2e-7 / 32e-6 * np.sinc(1 / 32)
    assert rms_gradient == pytest.approx(exact, rel=1 / 127)  # 127 differences are no whole periods
    tilted[10:20, 30:50] = np.nan
    assert roughness_off_plane(tilted, 1e-6, 1e-6)[0] == pytest.approx(rms_height, rel=2e-2)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_quantisation_step_is_found(dtype):
    height = (np.round(rough(128) / 3.7e-8) * 3.7e-8).astype(dtype).astype(float)
    assert quantisation_step(height) == pytest.approx(3.7e-8, rel=1e-3)
    assert quantisation_step(rough(128).astype(dtype).astype(float)) is None
    assert quantisation_step(np.zeros((8, 8))) is None


def test_heights_far_from_zero_in_single_precision_have_its_steps():
    height = 0.7 + 0.1 * rough(128)
    assert quantisation_step(height) is None
    assert quantisation_step(height.astype(np.float32).astype(float)) == pytest.approx(2.0**-24, rel=1e-3)
    assert quantisation_step(1e-6 * (1e6 * height).astype(np.float32).astype(float)) == pytest.approx(
        2.0**-4 * 1e-6
    )


def test_quantisation_is_compared_with_the_roughness_and_not_with_the_tilt():
    tilt = 1e-3 * np.arange(64) * 1e-4
    height = height_map(np.round((rough() * 1e-2 + tilt) / 2e-9) * 2e-9, 1e-6)
    check = quantisation(level(height).attrs)
    assert check.outcome == "review"
    assert check.sentence.startswith("The heights are multiples of 2.0 nm, 2")


def test_memory_is_asked_for_before_reading(read, refusal, monkeypatch):
    monkeypatch.setattr(guards, "memory_bytes", lambda: 2.0**17)
    refusal(array(rough(128)), r"128 x 128 points need 0.0 GiB of memory to be read", **GIVEN)
    for data in (b"1.5 2.5\n" * 2000, b"aISO-1.0" + bytes(20000), b"AliconaImaging\0" + bytes(20000)):
        refusal(data, r"bytes of this format need", **GIVEN)
    monkeypatch.undo()
    assert guards.memory_bytes() > 2**20
    assert read(array(rough(128)), **GIVEN).shape == (128, 128)


def test_depths_are_turned_into_heights(tmp_path):
    labelled(rough(), name="depth", positive="down").to_netcdf(tmp_path / "map.nc")
    height = read_height_map(tmp_path / "map.nc")
    np.testing.assert_array_equal(height.values, -rough())
    assert "its sign was changed" in height.attrs["ingest_warnings"]


@pytest.mark.parametrize(
    ("turn", "message"),
    [(np.diag([1.0, -1.0, -1.0]), "upside down"), (np.diag([-1.0, -1.0, 1.0]), "turns its map")],
)
def test_a_turned_map_is_said(tmp_path, turn, message):
    file = x3pio.Surface.from_array(rough(), x_scale=1e-6, y_scale=1e-6)
    file.with_placement(x3pio.Placement(rotation=turn)).save(tmp_path / "map.x3p")
    height = read_height_map(tmp_path / "map.x3p")
    np.testing.assert_array_equal(height.values, rough())
    assert message in height.attrs["ingest_warnings"]
    assert any(message in note for note in inspect_file(tmp_path / "map.x3p")["warnings"])
