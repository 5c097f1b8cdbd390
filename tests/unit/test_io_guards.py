"""Files that are damaged, foreign or hostile, and maps that look wrong."""

import io
import json
import os
import zipfile

import numpy as np
import pytest
import sdfio
import x3pio
import xarray as xr

from roughcontact.errors import HeightMapError, InputFileError, RoughContactError
from roughcontact.io import guards, read_height_map
from roughcontact.io.plausibility import suspicions


def saved(tmp_path, data, name="map.x3p"):
    path = tmp_path / name
    path.write_bytes(data)
    return path


def x3p(change=lambda name, data: data, extra=(), folder=""):
    stream, packed = io.BytesIO(), io.BytesIO()
    x3pio.write(stream, np.arange(12.0).reshape(3, 4) * 1e-6, x_scale=1e-6, y_scale=1e-6)
    with zipfile.ZipFile(stream) as old, zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr(folder + name, change(name, old.read(name)))
        for name, data in extra:
            new.writestr(name, data)
    return packed.getvalue()


def test_what_is_no_file(tmp_path):
    with pytest.raises(InputFileError, match="no such file"):
        read_height_map(tmp_path / "absent.x3p")
    with pytest.raises(InputFileError, match="is a folder"):
        read_height_map(tmp_path)
    with pytest.raises(InputFileError, match="the file is empty"):
        read_height_map(saved(tmp_path, b""))
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputFileError, match="no regular file"):
        read_height_map(tmp_path / "pipe")


@pytest.mark.parametrize("size", [1, 64, 512, 2 * 64 * 64, 2 * 128 * 128, 8 * 100 * 100])
@pytest.mark.parametrize("kind", ["zeros", "ones", "random"])
def test_rubbish_is_never_a_map(tmp_path, size, kind):
    data = {"zeros": bytes(size), "ones": b"\xff" * size, "random": np.random.default_rng(size).bytes(size)}[
        kind
    ]
    with pytest.raises(InputFileError) as caught:
        read_height_map(saved(tmp_path, data, "map.hgt"), dx=1, dy=1, unit="um")
    assert len(str(caught.value)) < 400


def test_message_of_an_unknown_format_is_one_sentence(tmp_path):
    with pytest.raises(InputFileError, match="the format is not known") as caught:
        read_height_map(saved(tmp_path, bytes(range(256)) * 20, "map.dat"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_entities_are_refused(tmp_path, encoding):
    bomb = '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;">]><a>&y;</a>'
    with pytest.raises(InputFileError, match="DOCTYPE, which is refused"):
        read_height_map(
            saved(tmp_path, x3p(lambda name, data: bomb.encode(encoding) if name == "main.xml" else data))
        )


def test_zip_bomb_is_refused_before_it_unpacks(tmp_path, monkeypatch):
    monkeypatch.setattr(guards, "MAX_UNPACKED_BYTES", 10**6)
    bomb = x3p(extra=[(f"vendor/{number}.bin", bytes(4 * 10**5)) for number in range(3)])
    assert len(bomb) < 10**5
    with pytest.raises(InputFileError, match="the archive would unpack to"):
        read_height_map(saved(tmp_path, bomb))
    assert read_height_map(saved(tmp_path, x3p())).shape == (3, 4)


def test_claimed_size_is_checked_before_reading(tmp_path):
    def claim(name, data):
        return data.replace(b"<SizeX>4<", b"<SizeX>400000000<") if name == "main.xml" else data

    with pytest.raises(InputFileError, match="more than the 134217728 that are read"):
        read_height_map(saved(tmp_path, x3p(claim)))


def test_cut_archive_and_other_archives(tmp_path):
    data = x3p()
    with pytest.raises(InputFileError, match="without its end"):
        read_height_map(saved(tmp_path, data[: int(0.6 * len(data))]))
    stream = io.BytesIO()
    np.savez(stream, a=np.ones((4, 4)))
    with pytest.raises(InputFileError):
        read_height_map(saved(tmp_path, stream.getvalue(), "map.npz"), dx=1, dy=1, unit="um")


def made(kind) -> bytes:
    heights = rough(16)
    stream = io.BytesIO()
    if kind == "x3p":
        x3pio.write(stream, heights, x_scale=1e-6, y_scale=1e-6)
    elif kind == "x3p in a folder":
        return x3p(folder="a/b/")
    elif kind == "sdf":
        sdfio.write(stream, heights, x_scale=1e-6, y_scale=1e-6)
    elif kind == "npy":
        np.save(stream, heights)
    elif kind == "netCDF":
        axes = {axis: (axis, 1e-6 * np.arange(16), {"units": "m"}) for axis in ("y", "x")}
        return bytes(
            xr.DataArray(heights, coords=axes, dims=("y", "x"), name="z").to_netcdf(format="NETCDF3_CLASSIC")
        )
    return stream.getvalue()


@pytest.mark.parametrize("kind", ["x3p", "x3p in a folder", "sdf", "npy", "netCDF"])
def test_flipped_bytes_give_a_map_or_an_error_of_ours(tmp_path, kind):
    rng = np.random.default_rng(7)
    data = made(kind)
    given = {"dx": 1, "dy": 1, "unit": "um", "height_unit": "m"}
    for number in range(60):
        damaged = bytearray(data)
        for place in rng.integers(0, len(data) if number % 2 else min(len(data), 300), 1 + number % 5):
            damaged[place] = rng.integers(256)
        said = None
        try:
            height = read_height_map(saved(tmp_path, bytes(damaged), "map"), **given)
        except RoughContactError as error:
            said = str(error)
        assert height.dims == ("y", "x") if said is None else len(said) < 500


def rough(n=64, seed=0):
    """A smooth random map of about 1 µm rms on a field of 64 µm."""
    rng = np.random.default_rng(seed)
    q = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.fftfreq(n)[None, :])
    spectrum = np.fft.fft2(rng.standard_normal((n, n))) * np.exp(-((q * 12) ** 2))
    height = np.fft.ifft2(spectrum).real
    return 1e-6 * height / height.std()


def words(height, dx=1e-6, dy=1e-6):
    return "\n".join(suspicions(height, dx, dy))


def test_a_sound_map_raises_no_suspicion():
    assert suspicions(rough(), 1e-6, 1e-6) == []


def test_heights_larger_than_the_field():
    assert "more than the field" in words(1e3 * rough())


def test_pixels_that_are_not_square():
    assert "the pixels are not square" in words(rough(), dy=1.02e-6)
    assert "dx = 1.000 µm, dy = 1.020 µm" in words(rough(), dy=1.02e-6)
    for dy in (1.005e-6, 2e-6, 0.125e-6):
        assert suspicions(rough(), 1e-6, dy) == []


def test_sentinels_and_spikes():
    height = rough()
    height[10, 20] = -1e-3 * 0.05
    assert "1 points lie far below all others (down to −50.0 µm" in words(height)
    height = rough()
    height[5, 5:8] = 4e-5
    assert "3 points lie far above all others" in words(height)


def test_saturation_and_quantisation():
    assert "exactly the highest height" in words(np.minimum(rough(), 1.5e-6))
    assert "exactly the lowest height" in words(np.maximum(rough(), -1.5e-6))
    assert "different heights occur" in words(np.round(rough() / 2e-7) * 2e-7)


def test_lost_lines():
    height = rough()
    height[[7, 30]] = 0.0
    assert "2 of 64 rows are constant" in words(height)
    height = rough()
    height[:, 12] = height[:, 11]
    assert "1 of 64 columns repeat the one before exactly" in words(height)


def test_noise_and_flatness():
    noise = np.random.default_rng(5).standard_normal((64, 64)) * 1e-7
    assert "neighbouring points are unrelated" in words(noise)
    assert "all heights are equal" in words(np.zeros((8, 8)))


def test_absurd_heights_are_refused(tmp_path):
    np.save(tmp_path / "map.npy", rough() * 1e12)
    with pytest.raises(HeightMapError, match="are no measurement; the height unit is wrong"):
        read_height_map(tmp_path / "map.npy", dx=1e-6, dy=1e-6, unit="m")


def test_suspicions_reach_the_user(tmp_path):
    path = tmp_path / "map.npy"
    np.save(path, rough() * 1e3)
    height = read_height_map(path, dx=1e-6, dy=1e-6, unit="m")
    assert any("more than the field" in note for note in json.loads(height.attrs["ingest_warnings"]))
