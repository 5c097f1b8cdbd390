"""X3P, ISO 25178-72: a ZIP archive of one main.xml and its data, in metres; row 0 is the lowest line."""

import hashlib
import io
import re
import zipfile
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from roughcontact.io import instrument_kinds
from roughcontact.io.channels import (
    Channel,
    MeasuredFile,
    UnevenPositionsError,
    as_heights,
    even_step,
    scattered,
    unreadable,
)
from roughcontact.io.guards import brief, check_points, refusing
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.metadata import instrument_metadata

_INSTRUMENT_KINDS = {"NonContacting": instrument_kinds.OPTICAL, "Contacting": instrument_kinds.STYLUS}


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is an archive with a main.xml, in any of its folders."""
    return head.startswith(b"PK") and zipfile.is_zipfile(path) and bool(_main_xmls(path))


def read(path: Path) -> MeasuredFile:
    """Open an X3P file with x3pio: checksums verified, integer and XML data, infinite heights as missing.

    There is one channel for each layer.
    """
    with refusing("not readable as X3P"):
        name = _main_xmls(path)[0]
        with zipfile.ZipFile(path) as archive:
            main = archive.read(name)
        _check_claimed_size(main)
        file, stale = _parsed(path, name, main)
    channels = _channels(file)
    for channel in channels:
        channel.notes += _rotation_notes(file.placement)
    return MeasuredFile(
        format="X3P (ISO 25178-72)",
        channels=channels,
        first_row="top" if _starts_at_top(main, file) else "bottom",
        instrument=_instrument(file.metadata),
        stale=stale,
    )


def _starts_at_top(main: bytes, file: Any) -> bool:
    """Return whether the first line is the upper one: <Origin>NW</Origin>, as x3ptools writes it.

    Where the increment along y is negative the lines are in rising order by then.
    """
    return re.search(rb"<Origin>\s*N[WE]\s*</Origin>", main) is not None and not file.header.y.increment < 0


def _parsed(path: Path, name: str, main: bytes) -> tuple[Any, str]:
    """Return the file, and which of its checksums differs from its content."""
    import x3pio

    try:
        return x3pio.read(_normalised_archive(path, name, main, verify=True)), ""
    except x3pio.X3pChecksumError as error:
        return x3pio.read(_normalised_archive(path, name, main, verify=False), verify=False), brief(error)


def _main_xmls(path: Path) -> list[str]:
    """Return the names of every main.xml in an archive, the outermost first."""
    with zipfile.ZipFile(path) as archive:
        names = [
            name for name in archive.namelist() if PurePosixPath(name.replace("\\", "/")).name == "main.xml"
        ]
    names = [name for name in names if "__MACOSX" not in name]
    return sorted(names, key=_depth)


def _depth(name: str) -> int:
    """Return the folder depth of a member of an archive."""
    return name.replace("\\", "/").count("/")


def _check_claimed_size(main: bytes) -> None:
    """Refuse a map whose stated size is above the limit, before it is read."""
    sizes = [re.search(rb"<Size%s>\s*(\d{1,15})\s*<" % axis, main) for axis in (b"X", b"Y")]
    nx, ny = (int(size[1]) if size else 0 for size in sizes)
    check_points((ny, nx))


def _normalised_archive(path: Path, name: str, main: bytes, *, verify: bool) -> Path | io.BytesIO:
    """Return an archive that x3pio can read: the file itself, or one repacked in memory.

    Repacked are main.xml more than one folder deep, or of another root than ISO5436_2, as some tools write
    it; the checksum of main.xml is compared before, those of the data stay in it.
    """
    folder = name[: -len("main.xml")]
    strange_root = re.search(rb"<(?:\w+:)?ISO5436[\s>]", main) is not None
    if _depth(folder) <= 1 and not strange_root:
        return path
    packed = io.BytesIO()
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(packed, "w") as tidy:
        for entry in archive.infolist():
            inner = entry.filename.removeprefix(folder)
            if entry.is_dir() or not entry.filename.startswith(folder) or inner == "main.xml":
                continue
            content = archive.read(entry)
            if inner.lower().endswith("md5checksum.hex"):
                if verify:
                    _check_md5(main, content)
                continue
            tidy.writestr(inner, content)
        root = rb"(</?)(\w+:)?ISO5436(?=[\s>])"
        tidy.writestr("main.xml", re.sub(root, rb"\1\2ISO5436_2", main) if strange_root else main)
    packed.seek(0)
    return packed


def _check_md5(main: bytes, content: bytes) -> None:
    """Refuse a main.xml whose checksum differs from the one in the archive, as x3pio does."""
    import x3pio

    stated = re.match(rb"\s*([0-9a-fA-F]{32})", content)
    if stated and stated[1].decode().lower() != hashlib.md5(main, usedforsecurity=False).hexdigest():
        raise x3pio.X3pChecksumError("the checksum of main.xml does not match its content")


def _channels(file: Any) -> list[Channel]:
    """Return the layers of a file."""
    import x3pio

    if isinstance(file, x3pio.PointCloud):
        cloud: Any = file.layer
        error = UnevenPositionsError("this X3P file holds a point cloud, not a map")
        channel = Channel("height", (1, 1), unreadable(str(error)), "m", lateral_unit="m")
        return [scattered(channel, cloud.x, cloud.y, cloud.z, error)]
    several = len(file.layers) > 1
    return [
        _channel(file, layer, f"layer {number}" if several else "height")
        for number, layer in enumerate(file.layers, 1)
    ]


def _channel(file: Any, layer: Any, name: str) -> Channel:
    """Return one layer; a negative increment counts the columns or rows backwards."""
    z = np.atleast_2d(layer.z)
    check_points(z.shape)
    channel, is_map = Channel(name, z.shape, partial(as_heights, z), "m", lateral_unit="m"), z.shape[0] > 1
    try:
        dx = _step(layer.x, file.header.x, "x", z.shape)
        dy = _step(layer.y, file.header.y, "y", z.shape) if is_map else 0.0
    except UnevenPositionsError as error:
        x, y = (_positions(file, layer, axis, z.shape) for axis in ("x", "y"))
        return scattered(channel, x, y if is_map else None, channel.read(), error)
    channel.read = partial(as_heights, z[:: -1 if dy < 0 else 1, :: -1 if dx < 0 else 1])
    channel.dx, channel.dy = abs(dx), abs(dy) or None
    return channel


def _step(stored: np.ndarray | None, axis: Any, name: str, shape: tuple[int, ...]) -> float:
    """Return the step along one axis, stated or between stored positions; negative where it runs back."""
    if stored is None:
        return float(axis.increment)
    stored = np.asarray(stored, dtype=float).reshape(shape)
    along = stored if name == "x" else stored.T
    step = even_step(along[0], name)
    if not np.nanmax(np.abs(along - along[0])) <= 0.02 * abs(step):
        raise UnevenPositionsError("the points do not lie on a rectangular grid")
    return step


def _positions(file: Any, layer: Any, name: str, shape: tuple[int, ...]) -> np.ndarray:
    """Return the position of every point along one axis, stored or counted."""
    stored = getattr(layer, name)
    if stored is not None:
        return np.asarray(stored, dtype=float).reshape(shape)
    return getattr(file.header, name).increment * np.indices(shape)[1 if name == "x" else 0]


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
    instrument, probe = metadata.instrument, metadata.probing_system
    kind = _INSTRUMENT_KINDS.get(str(getattr(probe, "type", "")))
    return instrument_metadata(
        {
            "kind": kind and kind.name,
            "vendor": instrument and instrument.manufacturer,
            "name": instrument and instrument.model,
            "serial": instrument and instrument.serial,
            "software": instrument and instrument.version,
            "lens" if kind is instrument_kinds.OPTICAL else "probe": probe and probe.identification,
            "acquisition_time": metadata.date,
            "calibration_time": metadata.calibration_date,
            "comment": metadata.comment,
        }
    )


READER = Reader(RecognisedBy.CONTENTS, recognises, read)
