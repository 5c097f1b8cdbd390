"""The two ISO exchange formats: X3P (ISO 25178-72) and SDF (ISO 25178-71). Both are in metres.

In both standards y grows from row to row in a right-handed system, so row 0 is the lowest line of the map and
is drawn at the bottom.
"""

import hashlib
import io
import re
import zipfile
from pathlib import Path, PurePosixPath

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.guards import ARCHIVE_ERRORS, brief, check_points
from roughcontact.io.source import Channel, SourceFile, as_heights, even_step


def main_xml_of(path: Path) -> str | None:
    """Return the name of the archive's outermost main.xml, or None where it has none."""
    with zipfile.ZipFile(path) as archive:
        names = [
            name for name in archive.namelist() if PurePosixPath(name.replace("\\", "/")).name == "main.xml"
        ]
    names = [name for name in names if "__MACOSX" not in name]
    return min(names, key=lambda name: name.replace("\\", "/").count("/"), default=None)


def read_x3p(path: Path) -> SourceFile:
    """Open an X3P file with x3pio: checksums verified, integer and XML data, infinite heights as missing."""
    import x3pio

    try:
        with zipfile.ZipFile(path) as archive:
            main = archive.read(main_xml_of(path))
        _check_claimed_size(main, path)
        file = x3pio.read(_tidied(path, main))
    except InputFileError:
        raise
    except (x3pio.X3pError, ValueError, *ARCHIVE_ERRORS) as error:
        raise InputFileError(f"{path}: not readable as X3P: {brief(error)}") from error
    if isinstance(file, x3pio.PointCloud):
        raise InputFileError(
            f"{path}: this X3P file holds a point cloud, not a map; "
            "interpolate it to an even grid and export it again"
        )
    several = len(file.layers) > 1
    channels = [
        _x3p_channel(layer, file.header, f"layer {number}" if several else "height", path)
        for number, layer in enumerate(file.layers, start=1)
    ]
    # A <Origin>NW</Origin>, as x3ptools writes it, says that the first line is the upper one.
    top = re.search(rb"<Origin>\s*N[WE]\s*</Origin>", main) is not None
    return SourceFile(
        format="X3P (ISO 25178-72)",
        channels=channels,
        first_row="top" if top else "bottom",
        instrument=_x3p_instrument(file.metadata),
    )


def _check_claimed_size(main: bytes, path: Path):
    sizes = [re.search(rb"<Size%s>\s*(\d{1,15})\s*<" % axis, main) for axis in (b"X", b"Y")]
    if all(sizes):
        check_points([int(size[1]) for size in sizes], path)


def _tidied(path: Path, main: bytes):
    """Return what x3pio can read: the file itself, or the archive repacked in memory.

    Repacked are archives whose main.xml lies more than one folder deep, and those whose root element is not
    called ISO5436_2 (written by some tools). The checksum of main.xml is compared before it is changed; those
    of the data stay in it.
    """
    name = main_xml_of(path)
    folder = name[: -len("main.xml")]
    strange_root = re.search(rb"<(?:\w+:)?ISO5436[\s>]", main) is not None
    if folder.replace("\\", "/").count("/") <= 1 and not strange_root:
        return path
    packed = io.BytesIO()
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(packed, "w") as tidy:
        for member in archive.infolist():
            inner = member.filename.removeprefix(folder)
            if member.is_dir() or not member.filename.startswith(folder) or inner == "main.xml":
                continue
            content = archive.read(member)
            if inner.lower().endswith("md5checksum.hex"):
                _check_md5(main, content, path)
                continue
            tidy.writestr(inner, content)
        root = rb"(</?)(\w+:)?ISO5436(?=[\s>])"
        tidy.writestr("main.xml", re.sub(root, rb"\1\2ISO5436_2", main) if strange_root else main)
    packed.seek(0)
    return packed


def _check_md5(main, content, path):
    stated = re.match(rb"\s*([0-9a-fA-F]{32})", content)
    if stated and stated[1].decode().lower() != hashlib.md5(main, usedforsecurity=False).hexdigest():
        raise InputFileError(
            f"{path}: the checksum of main.xml does not match: the file was changed or damaged"
        )


def _x3p_channel(layer, header, name, path):
    z = np.atleast_2d(layer.z)
    check_points(z.shape, path)
    dx = _x3p_step(layer.x, header.x, "x", z.shape, path)
    dy = _x3p_step(layer.y, header.y, "y", z.shape, path) if z.shape[0] > 1 else None
    # A negative increment counts the columns or rows backwards.
    flipped = z[:: -1 if dy is not None and dy < 0 else 1, :: -1 if dx < 0 else 1]
    return Channel(
        name=name,
        shape=z.shape,
        read=lambda: as_heights(flipped, str(path)),
        height_unit="m",
        dx=abs(dx),
        dy=None if dy is None else abs(dy),
        lateral_unit="m",
    )


def _x3p_step(stored, axis, name, shape, path):
    if stored is None:
        return float(axis.increment)
    stored = np.asarray(stored, dtype=float).reshape(shape)
    along = stored if name == "x" else stored.T
    step = even_step(along[0], name, str(path))
    if not np.nanmax(np.abs(along - along[0])) <= 0.02 * abs(step):
        raise InputFileError(
            f"{path}: the points do not lie on a rectangular grid; export the map on an even grid"
        )
    return step


def _x3p_instrument(metadata):
    if metadata is None:
        return {}
    instrument, probe = metadata.instrument, metadata.probing_system
    stated = {
        "vendor": instrument and instrument.manufacturer,
        "name": instrument and instrument.model,
        "serial": instrument and instrument.serial,
        "software": instrument and instrument.version,
        "probe": probe and probe.identification,
        "acquisition_time": metadata.date and metadata.date.isoformat(),
        "comment": metadata.comment,
    }
    return {key: value for key, value in stated.items() if value and value != "not available"}


def read_sdf(path: Path) -> SourceFile:
    """Open an SDF file with sdfio: ASCII and binary, the BCR and ISO revisions, bad points as missing."""
    import sdfio

    try:
        file = sdfio.read(path)
    except (sdfio.SdfError, ValueError, ArithmeticError) as error:
        raise InputFileError(f"{path}: not readable as SDF: {brief(error)}") from error
    header = file.header
    check_points(file.data.shape, path)

    def step(value):  # zero or a negative number stands for "not said"
        return float(value) if value and np.isfinite(value) and value > 0 else None

    dates = {"acquisition_time": header.create_date, "modified": header.mod_date}
    instrument = {key: date.isoformat() for key, date in dates.items() if date is not None}
    if header.manufacturer_id.strip():
        instrument["vendor"] = header.manufacturer_id.strip()
    channel = Channel(
        name="height",
        shape=file.data.shape,
        read=lambda: as_heights(file.data, str(path)),
        height_unit="m",
        dx=step(header.x_scale),
        dy=step(header.y_scale) if file.data.shape[0] > 1 else None,
        lateral_unit="m",
    )
    return SourceFile("SDF (ISO 25178-71)", [channel], first_row="bottom", instrument=instrument)
