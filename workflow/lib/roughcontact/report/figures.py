"""What all figures have in common: style, colours, layout, and how they become the source of an image.

A source is a data URI, the same for the same data, so that a page needs no other file and does not change
when it is drawn again.
"""

import base64
import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

# Okabe and Ito (2008): eight colours that colour-blind people can tell apart (yellow left out: too pale for
# lines)
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")

_STYLE: dict[Any, Any] = {
    "svg.hashsalt": "roughcontact",
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": True,
    "legend.framealpha": 0.75,
    "legend.edgecolor": "none",
    "legend.fontsize": 8,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
}
_WIDTH = 2.55  # of a square picture, inches
_HIGHEST = 3.6  # of a picture, inches
_LONGEST_ASPECT = 4.0  # longer pictures are drawn out of scale


class Picture(NamedTuple):
    """A figure with room for a map and for its colour bar."""

    figure: Figure
    axes: Axes
    beside: Axes  # of the colour bar
    in_scale: bool  # whether both axes have the same scale

    def add_colour_bar(
        self, image: AxesImage, label: str, *, extend: Literal["neither", "both", "min", "max"] = "neither"
    ) -> None:
        """Draw the colour bar of an image, with arrows where the colours end before the values do."""
        bar: Colorbar = self.figure.colorbar(image, cax=self.beside, extend=extend, label=label)
        bar.outline.set_linewidth(0.5)


@contextmanager
def new_figure(
    width: float, height: float, *, layout: Literal["constrained"] | None = "constrained"
) -> Iterator[Figure]:
    """Yield a figure that belongs to no window and no other figure, in the style of the pages.

    Parameters
    ----------
    width, height : float, inches
    layout : {"constrained"} or None
        who places the axes; None where the caller does.

    Yields
    ------
    Figure

    Examples
    --------
    >>> with new_figure(4.3, 3.6) as figure:
    ...     lines = figure.add_subplot().plot([1, 2], [3, 4])
    ...     as_svg(figure)[:26]
    'data:image/svg+xml;base64,'
    """
    with matplotlib.rc_context(_STYLE):
        yield Figure(figsize=(width, height), layout=layout)


@contextmanager
def new_picture(aspect: float, *, left: float = 0.7) -> Iterator[Picture]:
    """Yield axes for a map with a colour bar beside; maps of one shape come out alike.

    Parameters
    ----------
    aspect : float
        height over width of the map; a long map is drawn out of scale.
    left : float, inches
        room for the labels of the vertical axis.

    Yields
    ------
    Picture
    """
    in_scale = 1 / _LONGEST_ASPECT <= aspect <= _LONGEST_ASPECT
    aspect = aspect if in_scale else 1.0
    # margins in inches, so that the labels always fit
    width = min(_WIDTH, _HIGHEST / aspect)
    full = (_WIDTH + 1.65, width * aspect + 0.65)
    bottom, height = 0.5 / full[1], width * aspect / full[1]
    with new_figure(*full, layout=None) as figure:
        axes = figure.add_axes((left / full[0], bottom, width / full[0], height))
        axes.grid(False)
        beside = figure.add_axes(((left + 0.1 + width) / full[0], bottom, 0.12 / full[0], height))
        yield Picture(figure, axes, beside, in_scale)


def as_png(figure: Figure) -> str:
    """Return a figure as PNG with a palette: a third of the size, and no dates or versions inside.

    The palette covers all the colours there are, not the frequent ones: the colour bar stays smooth.

    Parameters
    ----------
    figure : Figure
        of `new_figure`.

    Returns
    -------
    str
        data URI.
    """
    from PIL import Image

    figure.set_dpi(144)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    thrifty = image.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    thrifty.save(buffer, "png", optimize=True)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()


def as_svg(figure: Figure) -> str:
    """Return a figure as SVG without a date.

    Parameters
    ----------
    figure : Figure
        of `new_figure`.

    Returns
    -------
    str
        data URI.
    """
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    return "data:image/svg+xml;base64," + base64.b64encode(buffer.getvalue()).decode()
