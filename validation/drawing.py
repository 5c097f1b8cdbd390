"""The figures of the validation page."""

import base64
import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from roughcontact.report.charts import COLOURS, MARKERS
from roughcontact.report.figures import new_figure

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d.axes3d import Axes3D

Curve = tuple[str, ArrayLike, ArrayLike]  # label, x values, y values

_KNOWN: dict[str, Any] = {"color": "#444444", "linewidth": 1.2}
_SHADES = ("#444444", "#7a4a00", "#00563d", "#96210a")  # a dark colour for each theory
_LINES = ("-", "--", ":", "-.")


def chart(
    expected: Sequence[Curve],
    computed: Sequence[Curve],
    *,
    x: str,
    y: str,
    published: Sequence[Curve] = (),
    scales: tuple[str, str] = ("linear", "linear"),
    note: str | None = None,
    more: Sequence[tuple[ArrayLike, ArrayLike]] = (),
) -> str:
    """Draw what is known as dark lines and what was computed as coloured marks; return a data URI.

    Numbers of others (`published`) are open circles around the marks, `more` are lines like the first of
    `known` without a label, and `note` is printed into the picture.
    """
    with new_figure(4.3, 3.4) as figure:
        axes = figure.add_subplot()
        for index, (label, horizontal, vertical) in enumerate(expected):
            axes.plot(horizontal, vertical, linestyle=_LINES[index % len(_LINES)], label=label, **_KNOWN)
        for index, (label, horizontal, vertical) in enumerate(computed):
            axes.plot(
                horizontal,
                vertical,
                linestyle="none",
                marker=MARKERS[index],
                markersize=4,
                color=COLOURS[index],
                label=label,
            )
        for label, horizontal, vertical in published:
            style: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 9, "fillstyle": "none"}
            axes.plot(horizontal, vertical, color="#444444", label=label, **style)
        for horizontal, vertical in more:
            axes.plot(horizontal, vertical, **_KNOWN)
        axes.set(xscale=scales[0], yscale=scales[1], xlabel=x, ylabel=y)
        if note:
            axes.set_title(note, fontsize=9, color=COLOURS[1], loc="left")
        axes.legend()
        return as_svg(figure)


def error_chart(
    errors: Sequence[tuple[str, np.ndarray, float]],
    sizes: Sequence[int],
    *,
    y: str,
) -> str:
    """Draw errors over the number of points, logarithmic, beside lines of slope 1 and 2; return a data URI.

    `errors` are labels, errors at the sizes, and fitted orders.
    """
    with new_figure(4.3, 3.8) as figure:
        axes = figure.add_subplot()
        largest = max(float(np.max(values)) for _, values, _ in errors)
        for order in (1, 2):
            guide = largest * 2 * (sizes[0] / np.asarray(sizes, float)) ** order
            axes.plot(sizes, guide, linestyle=_LINES[order], label=f"order {order}", **_KNOWN)
        for index, (label, values, fitted) in enumerate(errors):
            axes.plot(
                sizes,
                values,
                marker=MARKERS[index],
                markersize=4,
                linewidth=0.8,
                color=COLOURS[index],
                label=f"{label}: {fitted:.2f}",
            )
        axes.set(xscale="log", yscale="log", xlabel="points per wave", ylabel=y)
        axes.set_xticks(sizes, [str(size) for size in sizes])
        axes.minorticks_off()
        figure.legend(loc="outside lower center", ncols=2, title="fitted orders", title_fontsize=8)
        return as_svg(figure)


def area_chart(
    line_loads: np.ndarray,
    theories: Mapping[str, np.ndarray],
    loads: np.ndarray,
    areas: np.ndarray,
) -> str:
    """Draw area over load p' = p̄/(E* g), so that slopes are heights; return a data URI.

    `areas` (map, load) are those of an ensemble at the loads, `theories` those at the loads of their lines.
    """
    with new_figure(5.2, 3.8) as figure:
        axes = figure.add_subplot()
        for index, (label, values) in enumerate(theories.items()):
            style = _KNOWN | {"color": _SHADES[index], "linestyle": _LINES[index]}
            axes.plot(line_loads, values / line_loads, label=label, **style)
        low, high = areas.min(axis=0) / loads, areas.max(axis=0) / loads
        axes.fill_between(loads, low, high, color=COLOURS[0], alpha=0.25, linewidth=0)
        mean = areas.mean(axis=0) / loads
        axes.plot(loads, mean, "o", color=COLOURS[0], markersize=5, label="solved: mean and range")
        axes.set(xscale="log", ylim=(0, None))
        axes.set_xlabel("relative pressure p′ = p̄ / (E* g)")
        axes.set_ylabel("(A/A₀) / p′")
        axes.legend(loc="lower left")
        return as_svg(figure)


def pressure_relief(
    x: np.ndarray, y: np.ndarray, pressure: np.ndarray, *, labels: tuple[str, str, str], note: str
) -> str:
    """Draw a pressure (y, x) over one period as a relief, like figure 2 of the paper; return a data URI."""
    with new_figure(4.6, 3.8, layout=None) as figure:
        axes = cast("Axes3D", figure.add_axes((0.0, 0.02, 0.88, 0.9), projection="3d"))
        axes.plot_surface(*np.meshgrid(x, y), pressure, cmap="viridis", rcount=64, ccount=64, linewidth=0)
        axes.set_xlabel(labels[0])
        axes.set_ylabel(labels[1])
        axes.set_zlabel(labels[2])
        figure.text(0.02, 0.95, note, fontsize=9, color=COLOURS[1])
        return as_png(figure)


def as_png(figure: Figure) -> str:
    """Return a figure as PNG with a palette, which takes a third of the size and has no date, a data URI.

    The palette covers all colours, not the frequent ones: the colour bar stays smooth.
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
