"""The figures of spectrum and texture show what they say."""

import re
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
import pytest
from known_surfaces import self_affine
from read_charts import read_chart

from roughcontact import height_map, level, periodic_window, self_affine_surface
from roughcontact.report import texture_plots
from roughcontact.report.charts import COLOURS, DASHED, DOTTED
from roughcontact.surface.roughness.parameters import shortest_wavelength
from roughcontact.surface.roughness.spectrum import isotropic_spectrum


def window(shape=(96, 128), *, longest=60e-6, **options):
    rough = self_affine(shape, 1e-6, (6e-6, longest), rms_height=2e-7, stretch=4.0, seed=2)
    return periodic_window(level(rough, outlier_threshold=None), **options)


def svg(uri):
    kind, _, text = uri.partition(",")
    assert kind == "data:image/svg+xml"
    text = unquote(text)
    ElementTree.fromstring(text)  # well formed
    return text


def test_what_was_taken_out_is_shaded():
    assert "removed" not in svg(texture_plots.spectrum(window()))
    for options in ({"shortest_wavelength": 12e-6}, {"longest_wavelength": 30e-6}):
        assert "removed" in svg(texture_plots.spectrum(window(**options)))
    text = svg(texture_plots.spectrum(window()))
    assert "reliable: two pixels" in text
    assert re.search(r"wavelength \(.m\)", text)


def test_the_spectrum_is_drawn_where_its_axes_say():
    """Of a map in nm² µm² and of a profile in nm² µm, at its wavenumbers in rad/µm."""
    for shape, unit, factor in (((48, 64), "nm² µm²", 1e30), ((1, 64), "nm² µm", 1e24)):
        rough = self_affine(shape, 1e-6, (4e-6, 30e-6), rms_height=2e-6, seed=2)
        window_map = periodic_window(level(rough, outlier_threshold=None))
        drawn = read_chart(texture_plots.spectrum(window_map), log="xy")
        assert {f"C(q) ({unit})", "wavenumber q (rad/µm)", "wavelength (µm)"} <= set(drawn.texts)
        (line,) = [curve for curve in drawn.lines if curve.colour == COLOURS[0]]
        q, power = isotropic_spectrum(window_map)
        # waves that the map does not have are rounding, and not drawn
        is_drawn = power > 1e-9 * power.max()
        assert line.x == pytest.approx(q[is_drawn] * 1e-6, rel=0.01)
        assert np.log10(line.y) == pytest.approx(np.log10(power[is_drawn] * factor), abs=0.03)


def test_the_band_of_the_spectrum_is_marked_at_its_wavelengths():
    window_map = window(shortest_wavelength=12e-6, longest_wavelength=40e-6)
    drawn = read_chart(texture_plots.spectrum(window_map), log="xy")
    marked = {line.style: line.x for line in drawn.lines if line.style}
    assert marked[DASHED] == pytest.approx(2 * np.pi / 2, rel=0.01)  # of two pixels, 2 µm
    assert marked[DOTTED] == pytest.approx(2 * np.pi / (1e6 * shortest_wavelength(window_map)), rel=0.01)
    longest, shortest = (2e-6 * np.pi / window_map.attrs[f"band_{side}"] for side in ("longest", "shortest"))
    assert sorted(drawn.bands) == [
        (pytest.approx(drawn.x_ends[0], rel=0.01), pytest.approx(longest, rel=0.02)),
        (pytest.approx(shortest, rel=0.02), pytest.approx(drawn.x_ends[1], rel=0.01)),
    ]
    (line,) = [curve for curve in drawn.lines if curve.colour == COLOURS[0]]
    assert 2 * np.pi / line.x.max() == pytest.approx(12, rel=0.1)
    assert 2 * np.pi / line.x.min() == pytest.approx(40, rel=0.1)


def test_the_same_picture_a_second_time():
    assert texture_plots.spectrum(window()) == texture_plots.spectrum(window())


@pytest.mark.parametrize("shape", [(1, 300), (300, 1)])
def test_profiles_are_drawn_as_lines(shape):
    rough = self_affine_surface((1, 300), 1e-6, hurst=0.8, shortest=6e-6, longest=60e-6, rms_height=2e-7)
    profile = periodic_window(level(height_map(rough.values.reshape(shape), 1e-6), outlier_threshold=None))
    assert "wavenumber q" in svg(texture_plots.spectrum(profile))


@pytest.mark.parametrize("shape", [(8, 8), (9, 200), (5, 7)])
def test_small_and_long_maps_are_drawn(shape):
    height = periodic_window(level(height_map(np.random.default_rng(0).standard_normal(shape), 1e-6)))
    assert svg(texture_plots.spectrum(height))
