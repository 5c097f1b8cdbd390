"""Style and layout of Matplotlib figures, and their conversion to the source of an image.

A source is a data URI, the same for the same data, so that a page needs no other file and does not change
when it is drawn again.
"""

import base64
import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

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


@contextmanager
def new_figure(
    width: float, height: float, *, layout: Literal["constrained"] | None = "constrained"
) -> Iterator[Figure]:
    """Yield a figure (inches) in the style of the pages; with `layout` None the caller places the axes.

    Examples
    --------
    >>> with new_figure(4.3, 3.6) as figure:
    ...     lines = figure.add_subplot().plot([1, 2], [3, 4])
    ...     as_svg(figure)[:26]
    'data:image/svg+xml;base64,'
    """
    with matplotlib.rc_context(_STYLE):
        yield Figure(figsize=(width, height), layout=layout)


def as_png(figure: Figure) -> str:
    """Return a figure as PNG with a palette: a third of the size, and no dates or versions inside.

    The palette covers all colours, not the frequent ones: the colour bar stays smooth. The result is a data
    URI.
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
    """Return a figure as SVG without a date, a data URI."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    return "data:image/svg+xml;base64," + base64.b64encode(buffer.getvalue()).decode()
