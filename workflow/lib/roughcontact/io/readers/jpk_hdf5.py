"""JPK's fast scans in HDF5: one channel for each quantity, direction and frame.

Groups ``Measurement_000`` ... have a grid (``position-pattern.grid.*``); their ``Channel_000`` ... counts, a
row for each point (x fastest), a column for each frame, and ``net-encoder.scaling.*`` from counts to the
quantity.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.io import hdf5, instrument_kinds
from roughcontact.io.channels import Channel, MeasuredFile, as_heights, on_field
from roughcontact.io.guards import refusal
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.units import is_length

_SCALE = "net-encoder.scaling."
_GRID = "position-pattern.grid."
_HEIGHTS = ("measuredHeight", "height", "capacitiveSensorHeight")  # the measured one first
_TURNED = "the scan is turned in its file (theta): x and y are those of the scan"


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is HDF5 whose attributes name it a JPK scan."""
    return hdf5.holds(path, head, lambda file: "JPK" in _stated(file, "file-format-info"))


def read(path: Path) -> MeasuredFile:
    """Open a file of one or more measurements; only sizes and scales are read.

    There is one channel for each quantity, direction and frame; the measured heights come first.
    """
    # for its checks alone: links into other files are refused before anything is read
    hdf5.datasets(path)
    with hdf5.opened(path) as file:
        measurements = [file[name] for name in sorted(file) if name.startswith("Measurement_")]
        groups = [each[name] for each in measurements for name in sorted(each) if name.startswith("Channel_")]
        groups.sort(key=_rank)
        channels = [channel for group in groups for channel in _frames(group, len(measurements) > 1, path)]
        if not channels:
            raise refusal("no map of JPK")
        facts, size = {"kind": instrument_kinds.PROBE.name, "vendor": "JPK"}, hdf5.stated_size(path)
        header = measurements[0].attrs
        return MeasuredFile("JPK (HDF5)", channels, "bottom", facts, required_size=size, header=header)


def _rank(group: Any) -> int:
    """Return the place of a quantity in the order of the channels."""
    quantity = _stated(group, "channel.name")
    return _HEIGHTS.index(quantity) if quantity in _HEIGHTS else len(_HEIGHTS)


def _frames(group: Any, several: bool, path: Path) -> Iterator[Channel]:
    """Yield a channel for each frame of a group, of a measurement that is named where there are several."""
    measurement = group.parent
    grid = {key.removeprefix(_GRID): value for key, value in measurement.attrs.items()}
    nx, ny = int(grid["ilength"]), int(grid["jlength"])
    arrays = [name for name in group if name != "thumbnail"]
    if len(arrays) != 1:
        raise refusal("arrays of JPK", name=group.name, count=len(arrays))
    array = group[arrays[0]]
    if array.ndim != 2 or array.shape[0] != nx * ny or array.dtype.kind not in "iuf":
        raise refusal("shape of JPK", name=array.name, shape=array.shape, nx=nx, ny=ny)
    unit = _stated(group, _SCALE + "unit.unit")
    scale = float(group.attrs[_SCALE + "multiplier"]), float(group.attrs[_SCALE + "offset"])
    direction = "retrace" if _stated(group, "retrace") == "true" else "trace"
    no_height = "by its name no topography" * (is_length(unit) and _rank(group) == len(_HEIGHTS))
    prefix = f"{measurement.name[1:]} " if several else ""
    label = prefix + _stated(group, "channel.fancy-name", _stated(group, "channel.name", array.name))
    field = [float(grid[key]) or None for key in ("ulength", "vlength")]
    lateral_unit, frames = _stated(measurement, _GRID + "unit.unit", "m"), array.shape[1]
    notes = [_TURNED] * (abs(float(grid.get("theta", 0.0))) > 1e-3)
    for frame in range(frames):
        name = f"{label} ({direction}{f', frame {frame + 1}' if frames > 1 else ''})"
        image = partial(_read, path, array.name, frame, (ny, nx), scale)
        channel = Channel(name, (ny, nx), image, unit or "no unit", no_height=no_height, notes=notes)
        yield on_field(channel, field, lateral_unit)


def _read(path: Path, name: str, frame: int, shape: tuple[int, int], scale: Sequence[float]) -> np.ndarray:
    """Return the values of one frame."""
    with hdf5.opened(path) as file:
        counts = file[name][:, frame]
    return as_heights(counts.reshape(shape) * scale[0] + scale[1])


def _stated(group: Any, name: str, fallback: str = "") -> str:
    """Return an attribute of a group or file as text."""
    value = group.attrs.get(name, fallback)
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


READER = Reader(RecognisedBy.CONTENTS, recognises, read)
