"""Charts: values lie where the axes say, and the colours are those they are named after."""

import base64
import io
import re
from urllib.parse import unquote
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from PIL import Image

from roughcontact.arguments.maps import height_map as labelled
from roughcontact.report.charts import Axis, Chart, tick_text
from roughcontact.report.colours import colour_scale, coloured
from roughcontact.report.map_plots import height_map

SVG = "{http://www.w3.org/2000/svg}"


def drawn(chart):
    return ElementTree.fromstring(unquote(chart.source().partition(",")[2]))


def legend(chart):
    """Return the samples and labels of the legend of a chart."""
    return list(drawn(chart).find(f"{SVG}g[@id='legend']"))


def chart(x=Axis("x", 1.0, 100.0, log=True), y=Axis("y", 0.0, 2.0), **options):  # noqa: B008 - not changed
    return Chart(x, y, size=(300.0, 200.0), margins=(50.0, 20.0, 50.0, 30.0), **options)


def test_a_line_goes_through_its_points():
    """The area is 200 x 150 pixels: 10 lies half way along a logarithmic axis from 1 to 100."""
    drawing = chart()
    drawing.line(np.array([1.0, 10.0, 100.0]), np.array([0.0, 0.5, 2.0]), colour="#123456")
    (path,) = [p for p in drawn(drawing).iter(f"{SVG}path") if p.get("stroke") == "#123456"]
    assert path.get("d") == "M0 150L100 112.5L200 0"


def test_a_line_is_interrupted_where_values_are_missing():
    drawing = chart(x=Axis("x", 0.0, 5.0))
    drawing.line(np.arange(6.0), np.array([0, 1, np.nan, 1, 2, np.nan]), colour="#123456")
    (path,) = [p for p in drawn(drawing).iter(f"{SVG}path") if p.get("stroke") == "#123456"]
    assert path.get("d").count("M") == 2


def test_a_bar_without_an_upper_end_has_an_arrow_at_the_edge():
    drawing = chart(x=Axis("x", 0.0, 4.0), y=Axis("y", 0.0, 2.0))
    lower = np.array([0.5, 0.5, np.nan])
    drawing.bars(np.array([1.0, 2.0, 3.0]), lower, np.array([1.0, np.nan, np.nan]), colour="#123456")
    (path,) = [p for p in drawn(drawing).iter(f"{SVG}path") if p.get("stroke") == "#123456"]
    bars = re.findall(r"M[-\d.]+ ([-\d.]+)V([-\d.]+)", path.get("d"))
    assert [(float(low), float(high)) for low, high in bars] == [(112.5, 75.0), (112.5, 1.0)]
    assert path.get("d").count("l4-7 4 7") == 1


def test_a_long_line_keeps_its_extremes():
    values = np.zeros(40_000)
    values[12_345], values[23_456] = 2.0, -2.0
    drawing = chart(x=Axis("x", 0.0, 40_000.0), y=Axis("y", -2.0, 2.0))
    drawing.line(np.arange(40_000.0), values, colour="#123456")
    (path,) = [p for p in drawn(drawing).iter(f"{SVG}path") if p.get("stroke") == "#123456"]
    heights = [float(y) for y in re.findall(r"[ML][-\d.]+ ([-\d.]+)", path.get("d"))]
    assert (min(heights), max(heights)) == (0.0, 150.0)
    assert len(heights) < 3500


@pytest.mark.parametrize(
    ("axis", "written"),
    [
        (Axis("", 0.0, 1.0), [0, 0.2, 0.4, 0.6, 0.8, 1]),
        (Axis("", -0.3, 0.31), [-0.2, 0, 0.2]),
        (Axis("", 700.0, 0.0), [0, 200, 400, 600]),
        (Axis("", 0.3, 4.0, log=True), [0.5, 1, 2]),
        (Axis("", 0.6, 0.9, log=True), [0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9]),
        (Axis("", 350.0, 110.0, log=True), [150, 200, 250, 300, 350]),
        (Axis("", 1e-9, 1e-1, log=True), [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1][1::2]),
        (Axis("", 300.0, 3.0, log=True), [5, 10, 20, 50, 100, 200]),
    ],
)
def test_ticks_are_round_numbers_within_the_ends(axis, written):
    ticks, between = axis.ticks()
    assert np.allclose(ticks, written, rtol=1e-12, atol=1e-15)
    low, high = sorted((axis.low, axis.high))
    assert all(low * (1 - 1e-9) <= value <= high * (1 + 1e-9) for value in between)


def test_texts_cannot_break_out():
    drawing = chart(title="<b> & co")
    drawing.line(np.array([1.0, 2.0]), np.array([1.0, 2.0]), colour="#123456", label="<script>")
    texts = [text.text for text in drawn(drawing).iter(f"{SVG}text")]
    assert "<b> & co" in texts
    assert "<script>" in texts


@pytest.mark.parametrize("name", ["viridis", "cividis"])
def test_scales_of_colours_are_those_they_are_named_after(name):
    reference = 255 * matplotlib.colormaps[name](np.linspace(0, 1, 256))[:, :3]
    anchors = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in colour_scale(name)])
    interpolated = np.column_stack([np.interp(np.arange(256), np.arange(0, 256, 15), c) for c in anchors.T])
    assert np.abs(interpolated - reference).max() <= 12  # of 255


def test_every_point_of_a_large_map_is_in_its_picture():
    values = np.random.default_rng(5).random((1000, 1300))
    values[3:5, 7:100] = np.nan
    source = coloured(values, (0.0, 1.0), "viridis", bad="#ff0000")[0]
    picture = Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2])))
    picture.verify()  # the checksums
    picture = Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2])))
    assert picture.size == (1300, 1000)
    drawn = np.asarray(picture.convert("RGB"))
    missing = np.isnan(values)
    assert np.array_equal((drawn == (255, 0, 0)).all(axis=-1), missing)
    expected = 255 * matplotlib.colormaps["viridis"](values)[..., :3]
    assert np.abs(drawn - expected)[~missing].max() <= 14  # as the scale, and half a step of it


def test_values_beyond_the_ends_have_the_colours_of_the_ends():
    source = coloured(np.array([[-3.0, 0.0, 1.0, 7.0]]), (0.0, 1.0), "cividis")[0]
    picture = Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2]))).convert("RGB")
    below, low, high, above = (picture.getpixel((column, 0)) for column in range(4))
    assert below == low == (0, 34, 78)
    assert above == high == (254, 232, 56)


def test_a_million_is_a_power_of_ten():
    assert [tick_text(value) for value in (-999999.0, 1e6, 1e-4, 1.5e-4)] == [
        "−999999",
        "10⁶",
        "10⁻⁴",
        "0.00015",
    ]


def test_a_label_that_has_no_room_below_the_chart_is_shortened():
    drawing = chart()
    drawing.line(np.array([1.0, 9.0]), np.array([1.0, 1.0]), colour="#123456", label=30 * "long ")
    (text,) = [part.text for part in legend(drawing) if (part.text or "").startswith("long")]
    assert text.endswith("…")
    assert 25 < len(text) < 30  # in 300 pixels, of 8 pixels each


@pytest.mark.parametrize(
    ("letter", "letters", "columns"),
    [("x", 5, 3), ("x", 11, 2), ("x", 12, 1), ("x", 28, 1), ("l", 21, 2), ("l", 22, 1)],
)
def test_a_legend_has_as_many_columns_as_its_labels_leave(letter, letters, columns):
    """Of 300 pixels 12 at either side, 44 for each sample and 8.4 for each letter, 4.2 for narrow ones."""
    drawing = chart()
    for number in range(3):
        label = str(number).ljust(letters, letter)
        drawing.line(np.array([1.0, 9.0]), np.array([1.0, 1.0]), colour="#123456", label=label)
    texts = [part for part in legend(drawing) if (part.text or "").endswith(2 * letter)]
    assert len({part.get("x") for part in texts}) == columns
    assert all(len(part.text) == letters for part in texts)


def test_the_label_of_a_colour_bar_stays_within_the_picture():
    drawing = chart()
    drawing.colour_bar(Axis("height", 123456.1, 123456.9), ["#000000", "#ffffff"])
    (label,) = [text for text in drawn(drawing).iter(f"{SVG}text") if text.text == "height"]
    assert float(re.match(r"translate\(([\d.]+) ", label.get("transform"))[1]) <= 297


def test_a_title_stands_above_the_middle_of_the_chart():
    (title,) = [text for text in drawn(chart(title="area")).iter(f"{SVG}text") if text.text == "area"]
    assert (title.get("x"), title.get("text-anchor")) == ("150.0", "middle")
    assert 0 < float(title.get("y")) < 20  # above the margin


def test_a_colour_bar_rises_evenly_from_the_first_colour_to_the_last():
    drawing = chart()
    drawing.colour_bar(Axis("height", 0.0, 8.0), ["#000000", "#777777", "#999999", "#ffffff"])
    (gradient,) = drawn(drawing).iter(f"{SVG}linearGradient")
    assert [gradient.get(attribute) for attribute in ("x1", "y1", "x2", "y2")] == [
        "0",
        "1",
        "0",
        "0",
    ]  # upwards
    assert [(float(stop.get("offset")), stop.get("stop-color")) for stop in gradient] == [
        (0.0, "#000000"),
        (pytest.approx(1 / 3, abs=1e-3), "#777777"),
        (pytest.approx(2 / 3, abs=1e-3), "#999999"),
        (1.0, "#ffffff"),
    ]


def test_a_label_of_the_legend_stands_beside_its_sample():
    drawing = chart()
    for name, colour in (("one", "#123456"), ("two", "#654321")):
        drawing.line(np.array([1.0, 9.0]), np.array([1.0, 1.0]), colour=colour, label=name)
    parts = legend(drawing)
    for name, colour in (("one", "#123456"), ("two", "#654321")):
        (text,) = [part for part in parts if part.text == name]
        (sample,) = [part for part in parts if part.get("stroke") == colour]
        x, y = (float(value) for value in re.match(r"M([\d.]+) ([\d.]+)h26$", sample.get("d")).groups())
        assert 26 < float(text.get("x")) - x < 40
        assert 0 < float(text.get("y")) - y < 6  # the foot of letters of 15 pixels


@pytest.mark.parametrize("shape", [(1449, 1449), (2, 20000), (3000, 100)])
def test_a_picture_is_no_larger_than_a_browser_draws(shape):
    source = coloured(np.zeros(shape), (0, 1), "cividis")[0]
    width, height = Image.open(io.BytesIO(base64.b64decode(source.partition(",")[2]))).size
    assert width * height <= 2**21
    assert max(width, height) <= 8192
    together = -(-shape[1] // width)
    assert (height, width) == (-(-shape[0] // together), -(-shape[1] // together))
    assert (together == 1) == (shape == (3000, 100))


def test_few_points_are_told_from_many():
    assert coloured(np.zeros((200, 100)), (0, 1), "cividis")[1]
    assert not coloured(np.zeros((300, 100)), (0, 1), "cividis")[1]


@pytest.mark.parametrize("extent", [2e-9, 5e-7, 3e-4])
def test_the_label_of_colours_is_whole_in_whatever_unit(extent):
    heights = labelled(np.linspace(-extent, extent, 64).reshape(8, 8), 1e-6)
    picture = ElementTree.fromstring(unquote(height_map(heights).source().partition(",")[2]))
    turned = [text for text in picture.iter(f"{SVG}text") if "rotate" in text.get("transform", "")]
    assert len(turned) == 2
    for text in turned:
        right = float(re.match(r"translate\(([\d.]+) ", text.get("transform"))[1])
        assert 12 <= right <= float(picture.get("width")) - 3
