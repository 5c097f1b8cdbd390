"""X3P, ISO 25178-72: a ZIP archive of one main.xml and its data, in metres; row 0 is the lowest line."""

import hashlib
import io
import re
import zipfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.io import instrument_kinds
from roughcontact.io.channels import Channel, MeasuredFile, as_heights, unreadable
from roughcontact.io.guards import brief, check_count, check_points, refusing
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.positions import channel_on_grid, scattered

# key of `roughcontact.io.metadata` -> name in x3pio
_INSTRUMENT = {"vendor": "manufacturer", "name": "model", "serial": "serial", "software": "version"}
_MEASUREMENT = {"acquisition_time": "date", "calibration_time": "calibration_date", "comment": "comment"}
_INSTRUMENT_KINDS = {"NonContacting": instrument_kinds.OPTICAL, "Contacting": instrument_kinds.STYLUS}


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is an archive with a main.xml, in any of its folders."""
    return head.startswith(b"PK") and zipfile.is_zipfile(path) and bool(_main_xmls(path))


def read(path: Path) -> MeasuredFile:
    """Open an X3P file with x3pio: checksums verified, integer and XML data, infinite heights as missing.

    There is one channel for each layer.
    """
    import x3pio

    with refusing("not readable as X3P"):
        name = _main_xmls(path)[0]
        with zipfile.ZipFile(path) as archive:
            main = archive.read(name)
        # before x3pio makes the array that main.xml claims
        _check_claimed_size(main)
        try:
            file, stale = x3pio.read(_normalised_archive(path, name, main)), ""
        except x3pio.X3pChecksumError as error:
            file, stale = x3pio.read(_normalised_archive(path, name, main), verify=False), brief(error)
    channels = [*_channels(file, main)]
    for channel in channels:
        channel.notes += _rotation_notes(file.placement)
    # <Origin>NW</Origin>, as x3ptools writes it; by a negative increment the lines are in rising order now
    at_top = re.search(rb"<Origin>\s*N[WE]\s*</Origin>", main) and not file.header.y.increment < 0
    first_row, instrument = "top" if at_top else "bottom", _instrument(file.metadata)
    return MeasuredFile("X3P (ISO 25178-72)", channels, first_row, instrument, stale=stale)


def _main_xmls(path: Path) -> list[str]:
    """Return the names of every main.xml in an archive, the outermost first."""
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
    is_main = re.compile(r"(?!.*__MACOSX)(?:.*[/\\])?main\.xml", re.DOTALL).fullmatch
    return sorted(filter(is_main, names), key=_depth)


def _depth(name: str) -> int:
    """Return the folder depth of a member of an archive."""
    return name.replace("\\", "/").count("/")


def _check_claimed_size(main: bytes) -> None:
    """Refuse layers whose stated number or size in all is above the limit, before they are read."""
    sizes = [re.search(rb"<(?:\w+:)?Size%c>\s*(\d{1,15})\s*<" % axis, main) for axis in b"XYZ"]
    nx, ny, layers = (int(size[1]) if size else 1 for size in sizes)
    check_points((ny, nx), maps=layers)
    check_count(layers)


def _normalised_archive(path: Path, name: str, main: bytes) -> Path | io.BytesIO:
    """Return an archive that x3pio can read: the file itself, or one repacked in memory.

    Repacked are main.xml more than one folder deep, or of another root than ISO5436_2, as some tools write
    it; its checksum becomes that of the new one.
    """
    folder = name.removesuffix("main.xml")
    normalised = re.sub(rb"(</?)(\w+:)?ISO5436(?=[\s>])", rb"\1\2ISO5436_2", main)
    # x3pio reads most files as they are; only what others write beside the standard is repacked
    if _depth(folder) <= 1 and normalised == main:
        return path
    buffer = io.BytesIO()
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(buffer, "w") as tidy:
        for entry in archive.infolist():
            inner = entry.filename.removeprefix(folder)
            if entry.is_dir() or not entry.filename.startswith(folder):
                continue
            content = normalised if inner == "main.xml" else archive.read(entry)
            if inner.lower().endswith("md5checksum.hex"):
                content = content.lower().replace(_md5(main), _md5(normalised))
            tidy.writestr(inner, content)
    buffer.seek(0)
    return buffer


def _md5(content: bytes) -> bytes:
    """Return the checksum that an archive states of its main.xml."""
    return hashlib.md5(content, usedforsecurity=False).hexdigest().encode()


def _channels(file: Any, main: bytes) -> Iterator[Channel]:
    """Yield the layers of a file."""
    import x3pio

    if isinstance(file, x3pio.PointCloud):
        cloud: Any = file.layer
        uneven = "this X3P file holds a point cloud, not a map"
        channel = Channel("height", (1, 1), unreadable(uneven), "m", lateral_unit="m")
        yield scattered(channel, cloud.x, cloud.y, cloud.z, uneven)
        return
    count = len(file.layers)
    names = [f"layer {number}" for number in range(1, count + 1)] if count > 1 else ["height"]
    for layer, name in zip(file.layers, names, strict=True):
        z = np.atleast_2d(layer.z)
        channel = Channel(name, z.shape, partial(as_heights, z), "m", lateral_unit="m")
        x, y = (_positions(file, main, layer, axis) for axis in "xy")
        # a negative increment counts the columns or rows backwards
        yield channel_on_grid(channel, x, y if z.shape[0] > 1 else None)


def _positions(file: Any, main: bytes, layer: Any, axis: str) -> np.ndarray | float | None:
    """Return the positions along an axis, or its step; None without either (x3pio then has 1 m)."""
    if (positions := getattr(layer, axis)) is not None:
        return np.asarray(positions, dtype=float).reshape(np.atleast_2d(layer.z).shape)
    increment = re.search(rb"C%c>(?:(?!</(?:\w+:)?C).)*Increment>" % axis.upper().encode(), main, re.DOTALL)
    return float(getattr(file.header, axis).increment) if increment else None


def _rotation_notes(placement: Any) -> list[str]:
    """Return a note where the file rotates its map: only this shows a mirrored or overturned one."""
    rotation = np.asarray(placement.rotation, dtype=float).reshape(3, 3)
    if not placement.has_rotation or np.allclose(rotation, np.eye(3), atol=1e-3):
        return []
    if rotation[2, 2] < 0:
        return ["the file turns its map upside down (Rotation): check that peaks point up; not applied"]
    return ["the file turns its map (Rotation): that is not applied, x and y are those of the instrument"]


def _instrument(metadata: Any) -> dict:
    """Return the instrument metadata."""
    if metadata is None:
        return {}
    probe = metadata.probing_system
    kind = _INSTRUMENT_KINDS.get(str(getattr(probe, "type", "")))
    facts = {key: getattr(metadata.instrument, name, None) for key, name in _INSTRUMENT.items()}
    facts |= {key: getattr(metadata, name) for key, name in _MEASUREMENT.items()}
    facts["lens" if kind is instrument_kinds.OPTICAL else "probe"] = getattr(probe, "identification", None)
    return facts | {"kind": kind and kind.name}


READER = Reader(RecognisedBy.CONTENTS, recognises, read)
