"""JPK's fast scans in HDF5: one channel for each quantity, direction and frame.

Groups ``Measurement_000`` ... have a grid (``position-pattern.grid.*``); their ``Channel_000`` ... counts, a
row for each point (x fastest), a column for each frame, and ``net-encoder.scaling.*`` from counts to the
quantity.
"""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io import hdf5, instrument_kinds
from roughcontact.io.channels import Channel, MeasuredFile, as_heights
from roughcontact.io.guards import check_points
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.metadata import instrument_metadata
from roughcontact.io.units import is_length

_SCALE = "net-encoder.scaling."
_GRID = "position-pattern.grid."
_HEIGHTS = ("measuredHeight", "height", "capacitiveSensorHeight")  # the measured one first


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is HDF5 whose attributes name it a JPK scan."""
    if not head.startswith(hdf5.MARK):
        return False
    with hdf5.opened(path) as file:
        return "JPK" in _text(file.attrs.get("file-format-info", ""))


def read(path: Path) -> MeasuredFile:
    """Open a file of one or more measurements; only sizes and scales are read.

    There is one channel for each quantity, direction and frame; the measured heights come first.
    """
    hdf5.datasets(path)
    channels: list[tuple[int, Channel]] = []
    instrument: dict[str, Any] = {}
    with hdf5.opened(path) as file:
        measurements = [name for name in sorted(file) if name.startswith("Measurement_")]
        for name in measurements:
            measurement = file[name]
            attrs_of_measurement = dict(measurement.attrs.items())
            before = f"{name} " if len(measurements) > 1 else ""
            for group in sorted(measurement):
                if group.startswith("Channel_"):
                    channels += _frames(measurement[group], attrs_of_measurement, before, path)
            instrument = instrument or _instrument(attrs_of_measurement)
    if not channels:
        raise InputFileError("this JPK file holds no map")
    channels.sort(key=lambda ranked: ranked[0])
    return MeasuredFile(
        "JPK (HDF5)",
        [channel for _, channel in channels],
        "bottom",
        instrument,
        required_size=hdf5.stated_size(path),
    )


def _frames(
    group: Any, attrs_of_measurement: dict[str, Any], before: str, path: Path
) -> list[tuple[int, Channel]]:
    """Return a channel for each frame of a group, with its place in the order."""
    attributes = dict(group.attrs.items())
    nx, ny = int(attrs_of_measurement[_GRID + "ilength"]), int(attrs_of_measurement[_GRID + "jlength"])
    check_points((ny, nx))
    arrays = [name for name in group if name != "thumbnail"]
    if len(arrays) != 1:
        raise InputFileError(f"{group.name} of this JPK file has {len(arrays)} arrays, not one")
    array = group[arrays[0]]
    if array.ndim != 2 or array.shape[0] != nx * ny or array.dtype.kind not in "iuf":
        raise InputFileError(
            f"{array.name} has the shape {array.shape}, which is no {ny} x {nx} points of each frame"
        )
    unit = _text(attributes.get(_SCALE + "unit.unit", ""))
    scale = float(attributes[_SCALE + "multiplier"]), float(attributes[_SCALE + "offset"])
    lateral_unit = _text(attrs_of_measurement.get(_GRID + "unit.unit", "m"))
    quantity = _text(attributes.get("channel.name", array.name))
    direction = "retrace" if _text(attributes.get("retrace", "")) == "true" else "trace"
    turned = abs(float(attrs_of_measurement.get(_GRID + "theta", 0.0))) > 1e-3
    notes = ["the scan is turned in its file (theta): x and y are those of the scan"] if turned else []
    rank = _HEIGHTS.index(quantity) if quantity in _HEIGHTS else len(_HEIGHTS)
    frames = array.shape[1]
    no_height = "by its name no topography" if is_length(unit) and rank == len(_HEIGHTS) else ""
    label = _text(attributes.get("channel.fancy-name", quantity))
    attributes_of_channel: dict[str, Any] = {
        "height_unit": unit or "no unit",
        "dx": float(attrs_of_measurement[_GRID + "ulength"]) / nx,
        "dy": float(attrs_of_measurement[_GRID + "vlength"]) / ny,
        "lateral_unit": lateral_unit,
        "no_height": no_height,
    }
    channels = []
    for frame in range(frames):
        name = f"{before}{label} ({direction}{f', frame {frame + 1}' if frames > 1 else ''})"
        read_frame = partial(_read, path, array.name, frame, (ny, nx), scale)
        channels.append((rank, Channel(name, (ny, nx), read_frame, notes=[*notes], **attributes_of_channel)))
    return channels


def _read(
    path: Path, name: str, frame: int, shape: tuple[int, int], scale: tuple[float, float]
) -> np.ndarray:
    """Return the values of one frame."""
    with hdf5.opened(path) as file:
        counts = file[name][:, frame]
    return as_heights(counts.reshape(shape) * scale[0] + scale[1])


def _instrument(attrs_of_measurement: dict[str, Any]) -> dict[str, Any]:
    """Return the instrument metadata from the attributes of a measurement."""
    return instrument_metadata(
        {
            "kind": instrument_kinds.PROBE.name,
            "vendor": "JPK",
            "name": _text(attrs_of_measurement.get("description.instrument", "")),
            "probe": _text(
                attrs_of_measurement.get("environment.cantilever-calibration-info.cantilever-name", "")
            ),
            "acquisition_time": _text(attrs_of_measurement.get("start-time", "")),
            "software": _text(attrs_of_measurement.get("description.source-software", "")),
            "comment": _text(attrs_of_measurement.get("description.comment", "")),
        }
    )


def _text(value: Any) -> str:
    """Return an attribute as text."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


READER = Reader(RecognisedBy.CONTENTS, recognises, read)
