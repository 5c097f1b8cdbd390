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
from roughcontact.io import instrument_kinds
from roughcontact.io.channels import Channel, SourceFile, UnevenPositions, as_heights, even_step, scattered
from roughcontact.io.guards import ARCHIVE_ERRORS, brief, check_memory, check_points
from roughcontact.io.metadata import instrument_words


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
    channels = _x3p_channels(file, path)
    for channel in channels:
        channel.notes += _x3p_rotation(file.placement)
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


def _x3p_channels(file, path) -> list[Channel]:
    import x3pio

    units = {"height_unit": "m", "lateral_unit": "m"}
    if isinstance(file, x3pio.PointCloud):
        cloud = UnevenPositions("this X3P file holds a point cloud, not a map")
        return [scattered("height", file.layer.x, file.layer.y, file.layer.z, cloud, **units)]
    names = [f"layer {number}" for number in range(1, len(file.layers) + 1)]
    channels = []
    for name, layer in zip(names if len(names) > 1 else ["height"], file.layers, strict=True):
        z = np.atleast_2d(layer.z)
        check_points(z.shape, path)
        try:
            dx = _x3p_step(layer.x, file.header.x, "x", z.shape)
            dy = _x3p_step(layer.y, file.header.y, "y", z.shape) if z.shape[0] > 1 else None
        except UnevenPositions as error:
            x, y = (_x3p_positions(file, layer, axis, z.shape) for axis in ("x", "y"))
            heights = as_heights(z, str(path))
            channels.append(scattered(name, x, y if z.shape[0] > 1 else None, heights, error, **units))
            continue
        # A negative increment counts the columns or rows backwards.
        flipped = z[:: -1 if dy is not None and dy < 0 else 1, :: -1 if dx < 0 else 1]
        channels.append(
            Channel(
                name,
                z.shape,
                lambda values=flipped: as_heights(values, str(path)),
                dx=abs(dx),
                dy=None if dy is None else abs(dy),
                **units,
            )
        )
    return channels


def _x3p_step(stored, axis, name, shape):
    if stored is None:
        return float(axis.increment)
    stored = np.asarray(stored, dtype=float).reshape(shape)
    along = stored if name == "x" else stored.T
    step = even_step(along[0], name)
    if not np.nanmax(np.abs(along - along[0])) <= 0.02 * abs(step):
        raise UnevenPositions("the points do not lie on a rectangular grid")
    return step


def _x3p_positions(file, layer, name, shape):
    """Return the position of every point along one axis, stored or counted."""
    stored = getattr(layer, name)
    if stored is not None:
        return np.asarray(stored, dtype=float).reshape(shape)
    return getattr(file.header, name).increment * np.indices(shape)[1 if name == "x" else 0]


def _x3p_rotation(placement) -> list[str]:
    """Return a sentence where the file turns its map: a mirrored or overturned one shows only there."""
    rotation = np.asarray(placement.rotation, dtype=float).reshape(3, 3)
    if not placement.has_rotation or np.allclose(rotation, np.eye(3), atol=1e-3):
        return []
    if rotation[2, 2] < 0:
        return ["the file turns its map upside down (Rotation): check that peaks point up; not applied"]
    return ["the file turns its map (Rotation): that is not applied, x and y are those of the instrument"]


def _x3p_instrument(metadata):
    if metadata is None:
        return {}
    instrument, probe = metadata.instrument, metadata.probing_system
    contacting = str(getattr(probe, "type", "")) == "Contacting"
    optical = str(getattr(probe, "type", "")) == "NonContacting"
    return instrument_words(
        {
            "kind": instrument_kinds.OPTICAL.name
            if optical
            else instrument_kinds.STYLUS.name
            if contacting
            else None,
            "vendor": instrument and instrument.manufacturer,
            "name": instrument and instrument.model,
            "serial": instrument and instrument.serial,
            "software": instrument and instrument.version,
            "lens" if optical else "probe": probe and probe.identification,
            "acquisition_time": metadata.date,
            "calibration_time": metadata.calibration_date,
            "comment": metadata.comment,
        }
    )


def read_sdf(path: Path) -> SourceFile:
    """Open an SDF file with sdfio: ASCII and binary, the BCR and ISO revisions, bad points as missing."""
    import sdfio

    size = path.stat().st_size
    check_memory(size * 12, f"{size} bytes of SDF", path)
    try:
        file = sdfio.read(path)
    except (sdfio.SdfError, ValueError, ArithmeticError) as error:
        raise InputFileError(f"{path}: not readable as SDF: {brief(error)}") from error
    header = file.header
    check_points(file.data.shape, path)

    def step(value):  # zero or a negative number stands for "not said"
        return float(value) if value and np.isfinite(value) and value > 0 else None

    instrument = instrument_words(
        {
            "vendor": header.manufacturer_id,
            "acquisition_time": header.create_date,
            "modified": header.mod_date,
        }
    )
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
