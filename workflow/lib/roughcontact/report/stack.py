"""The layers of the bodies as a picture: each as long as it is thick, beside a pixel and the window."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from roughcontact.maps import side_lengths, spacing
from roughcontact.quantities import number, quantity
from roughcontact.report.charts import COLOURS, DASHED, DOTTED, GREY, INK, Axis, Chart, log_axis
from roughcontact.report.units import length_unit

_ROW = 30.0  # pixels
_LONGEST = 58  # characters that a row has room for


class _Rows(Axis):
    """An axis of rows, without values."""

    def ticks(self, max_count: int = 6) -> tuple[list[float], list[float]]:
        return [], []


def stack_of_layers(bodies: Sequence[Mapping[str, Any]], window: xr.DataArray) -> tuple[str, str]:
    """Return the picture (data URI) of bodies as the settings have them, and the same in words."""
    rows: list[tuple[str, float, str]] = []  # text, thickness, colour
    for index, body in enumerate(bodies, start=1):
        layers = body.get("layers") or []
        name = f"body {index} ({body['name']})" if body.get("name") else f"body {index}"
        rows += [(f"{name}, from its surface inwards", 0.0, GREY)] * bool(layers)
        for layer_index, layer in enumerate(layers):
            material = ", ".join(filter(None, [layer.get("name"), _material(layer)]))
            text = f"layer {layer_index + 1}: {quantity(layer['thickness'], 'm')} of {material}"
            rows.append((text, layer["thickness"], COLOURS[layer_index % len(COLOURS)]))
        if body.get("base") == "rigid":
            rows.append(("rigid base", math.inf, INK))
        else:
            rows.append((f"{'elastic base' if layers else name}: {_material(body)}", math.inf, GREY))
    if len(bodies) == 1:
        rows.append(("body 2: rigid", math.inf, INK))
    steps = [step for step, points in zip(spacing(window), window.shape, strict=True) if points > 1]
    marks = {"pixel": math.prod(steps) ** (1 / len(steps)), "window": max(side_lengths(window))}
    available = [*marks.values(), *(thickness for _, thickness, _ in rows if 0 < thickness < math.inf)]
    unit = length_unit(marks["window"])
    x = log_axis(f"thickness ({unit.symbol}), logarithmic", np.array(available) * unit.factor, room=3)
    chart = Chart(
        x,
        _Rows("", len(rows), 0.0),
        letters=12.0,
        size=(430.0, 58 + _ROW * len(rows)),
        margins=(12.0, 8.0, 12.0, 50.0),
        grid=False,
    )
    for row, (_, thickness, colour) in enumerate(rows):
        end, faces = min(thickness * unit.factor, x.high), row + np.array([0.6, 0.95])
        if end:
            chart.shade(np.array([x.low, end]), *np.repeat(faces[:, None], 2, axis=1), colour=colour)
            chart.line(np.full(2, end), faces, colour=colour, width=3, read=False)
    descriptions = [text for text, *_ in rows]
    for (name, length), dash in zip(marks.items(), (DOTTED, DASHED), strict=True):
        descriptions.append(f"{name} {quantity(length, 'm')}")
        chart.across(x=length * unit.factor, label=descriptions[-1], dash=dash)
    for row, (text, *_) in enumerate(rows):
        short = text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"
        chart.write(4.0, _ROW * (row + 0.45), short)
    return chart.source(), "; ".join(descriptions)


def _material(properties: Mapping[str, Any]) -> str:
    return (
        f"{quantity(properties['youngs_modulus'], 'Pa')}, ν {number(properties['poissons_ratio'], digits=2)}"
    )
