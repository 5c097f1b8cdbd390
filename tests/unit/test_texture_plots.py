"""The figures of spectrum and texture show what they say."""

import base64
import io
import re
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from roughcontact.levelling.level import level
from roughcontact.maps import height_map
from roughcontact.references.synthetic import self_affine_surface
from roughcontact.report import texture_plots
from roughcontact.window.periodic_window import periodic_window


def window(shape=(96, 128), **options):
    rough = self_affine_surface(
        shape, 1e-6, hurst=0.8, shortest=6e-6, longest=60e-6, rms_height=2e-7, stretch=4.0, seed=2
    )
    return periodic_window(level(rough, outlier_threshold=None), **options)


def svg(uri):
    kind, _, text = uri.partition(",")
    assert kind == "data:image/svg+xml"
    text = unquote(text)
    ElementTree.fromstring(text)  # well formed
    return text


def pixels(uri):
    """Return the picture in a figure, (rows, columns, RGB)."""
    (coded,) = re.findall(r'href="data:image/png;base64,([^"]*)"', svg(uri))
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(coded))).convert("RGB")).astype(int)


def test_what_was_taken_out_is_shaded():
    assert "taken out" not in svg(texture_plots.spectrum(window()))
    for options in ({"shortest_wavelength": 12e-6}, {"longest_wavelength": 30e-6}):
        assert "taken out" in svg(texture_plots.spectrum(window(**options)))
    text = svg(texture_plots.spectrum(window()))
    assert "reliable: two pixels" in text
    assert re.search(r"wavelength \(.m\)", text)


def test_the_same_picture_a_second_time():
    for draw in (
        texture_plots.spectrum,
        texture_plots.directional_spectrum,
        texture_plots.autocorrelation_map,
    ):
        assert draw(window()) == draw(window())


def test_waves_along_x_light_up_along_x():
    """Ridges along y (stretch): the waves run along x, where the picture is bright."""
    picture = pixels(texture_plots.directional_spectrum(window()))
    brightness = picture.sum(axis=2)
    middle_y, middle_x = (n // 2 for n in brightness.shape)
    along_x = brightness[middle_y - 1 : middle_y + 2, :].mean()
    along_y = brightness[:, middle_x - 1 : middle_x + 2].mean()
    assert along_x > 1.3 * along_y


@pytest.mark.parametrize("shape", [(1, 300), (300, 1)])
def test_profiles_are_drawn_as_lines(shape):
    rough = self_affine_surface((1, 300), 1e-6, hurst=0.8, shortest=6e-6, longest=60e-6, rms_height=2e-7)
    profile = periodic_window(level(height_map(rough.values.reshape(shape), 1e-6), outlier_threshold=None))
    assert "0.2: Sal" in svg(texture_plots.autocorrelation_map(profile))
    assert "wavenumber q" in svg(texture_plots.spectrum(profile))


@pytest.mark.parametrize("shape", [(8, 8), (9, 200), (5, 7)])
def test_small_and_long_maps_are_drawn(shape):
    height = periodic_window(level(height_map(np.random.default_rng(0).standard_normal(shape), 1e-6)))
    for draw in (texture_plots.directional_spectrum, texture_plots.autocorrelation_map):
        assert pixels(draw(height)).shape[2] == 3
    assert svg(texture_plots.spectrum(height))
