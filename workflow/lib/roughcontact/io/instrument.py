"""Instrument formats, through SurfaceTopography, fenced.

Only formats that can be told by their content are asked for; readers that accept any bytes (hgt, h5, mat,
npz, xyz, asc) are not. A physical size, unit or scale is never handed to the library, so what is missing in
the file stays missing. Its heights are indexed [x, y] and arranged so that their transpose, drawn as a
picture, looks as in the instrument's software (and as in Gwyddion): row 0 of the transpose is the upper line
of that picture. Only the transpose is taken here, so that row j is also row j of every other reader; y grows
from row to row, downwards in the picture.
"""

import logging
import mmap
import re
import struct
import warnings
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io import instrument_kinds
from roughcontact.io.channels import Channel, SourceFile, UnevenPositions, as_heights, scattered
from roughcontact.io.guards import brief, check_memory, check_points
from roughcontact.io.metadata import instrument_words
from roughcontact.io.units import is_length

_TIFF = (b"II*\0", b"MM\0*")
_ZIP = (b"PK\x03\x04",)
# first bytes -> formats to try; none of these readers is asked about a file that starts otherwise
_BY_FIRST_BYTES = {
    (b"\\*",): ("di",),
    (b"[DataSet]",): ("ezd",),
    (b"fileType",): ("mi",),
    (b"DIGITAL SURF",): ("sur",),
    (b"AliconaImaging",): ("al3d",),
    (b"FRTM_GLIDERV",): ("frt",),
    (b"WSxM",): ("wsxm",),
    (b"Binary TrueMap",): ("tmd",),
    (b"GWYP",): ("gwy",),
    (b"\x01\xb0\x93\xff",): ("mdt",),
    (b"Zeta-Instruments",): ("zmg",),
    (b"KPK0", b"KPK1"): ("zon",),
    (b"VK3_", b"VK4_", b"VK6", b"VK7"): ("vk",),
    (b"VCA DATA",): ("opdx",),
    (b"\x89HDF",): ("datx",),
    (b"\xd0\xcf\x11\xe0",): ("mnt",),
    (b"OLYMPUSRAWFORMAT",): ("oir",),
    _TIFF: ("ps", "jpk", "lext"),
    _ZIP: ("plux", "nmm", "poir", "qep", "mitutoyo"),
}
_BY_MAGIC = ("bcr", "metropro", "opd", "os3d")  # whose mark lies elsewhere or has several encodings
_BYTES_PER_BYTE = 8  # memory for each byte of a file: integers of two bytes become numbers of eight, twice
_NMS_DATE = 1076  # where the header of NanoFocus has it, bytes
_BY_STRUCTURE = ("ibw", "plu", "nms")  # no mark: told by a header that must agree with the file

_NO_HEIGHT_NAME = re.compile(
    r"phase|amplitude|deflection|error|friction|lateral|current|potential|voltage|intensity|modulation|stiffness|"
    r"adhesion|dissipation|temperature|image|colou?r|mask|quality",
    re.IGNORECASE,
)


@contextmanager
def _silence():
    """Keep the library's warnings and log lines (whole byte arrays among them) off the user's screen."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(before)


def read_instrument(path: Path, head: bytes) -> SourceFile:
    """Open an instrument file by its content.

    Raises
    ------
    InputFileError
        where no reader knows the file, or the one that knows it finds it damaged.
    """
    size = path.stat().st_size
    check_memory(size * _BYTES_PER_BYTE, f"{size} bytes of this format", path)
    _refuse_converted_line_ends(path)
    with _silence():
        from SurfaceTopography.Exceptions import FileFormatMismatch
        from SurfaceTopography.IO import lookup_reader_by_format
        from SurfaceTopography.IO.Reader import MagicMatch

        marked = [
            name for marks, names in _BY_FIRST_BYTES.items() if head.startswith(marks) for name in names
        ]
        if not marked:
            marked = [
                name for name in _BY_MAGIC if lookup_reader_by_format[name].can_read(head) == MagicMatch.YES
            ]
        failures = []
        for name in marked or _BY_STRUCTURE:
            try:
                reader = lookup_reader_by_format[name](str(path))
                if _is_plausible(reader, name):
                    return _open(reader, name, path)
            except InputFileError:
                raise
            except Exception as error:  # a reader may fail on foreign bytes in any way
                if not isinstance(error, FileFormatMismatch):
                    failures.append((lookup_reader_by_format[name].name(), error))
        if marked and failures:
            known, error = failures[0]
            raise InputFileError(
                f"{path}: looks like {known}, but is damaged, cut off or of a kind that holds no map "
                f"({brief(error)})"
            ) from error
        raise InputFileError(
            f"{path}: the format is not known, or the file is damaged (told by content, not by extension); "
            "export the map as X3P, SDF, netCDF or a text matrix with its size and units"
        ) from (failures[0][1] if failures else None)


def _refuse_converted_line_ends(path: Path):
    """Refuse a binary file that went through a text-mode transfer: every line feed follows a carriage return.

    One byte in 256 of binary data is a line feed, so that in more than 50 of them none without a carriage
    return does not happen by chance. Only the end of the file is looked at, where no header is.
    """
    size = path.stat().st_size
    with open(path, "rb") as stream:
        stream.seek(max(size // 2, size - 2**24))
        data = stream.read()
    feeds = data.count(b"\n")
    if feeds > 50 and feeds == data.count(b"\r\n"):
        raise InputFileError(
            f"{path}: every line feed in this binary file follows a carriage return: it was transferred as "
            "text and is damaged; copy it again in binary mode"
        )


def _is_plausible(reader, name) -> bool:
    """Return whether a file without a mark is what its header fields say: guards against chance matches."""
    if name != "nms":
        return True
    header = reader.channels[0].info["raw_metadata"]
    steps = np.array([header["dx_mm"], header["dy_mm"]])
    span = header["zmax"] - header["zmin"]
    return bool(np.all((steps > 1e-3) & (steps < 1e6)) and 0 < span < 1e5)


def _open(reader, name, path) -> SourceFile:
    infos = list(reader.channels)
    if not infos:
        raise InputFileError(f"{path}: this {reader.name()} file holds no map")
    # Heights are read once here: a channel that the file ends in the middle of shows that it was cut off.
    channels = [_channel(info, name, path) for info in infos]
    _check_rest(infos[0], name, path)
    return SourceFile(reader.name(), channels, first_row="top", instrument=_instrument(infos[0], name, path))


def _channel(info, name, path) -> Channel:
    from SurfaceTopography.Exceptions import CorruptFile

    shape = (1, info.nb_grid_pts[0]) if len(info.nb_grid_pts) == 1 else tuple(info.nb_grid_pts[::-1])
    check_points(shape, path)
    # (lateral unit, unit of the values) where they differ; some readers state the first for the second
    lateral_unit, unit = info.unit if isinstance(info.unit, tuple) else (info.unit, info.data_unit)
    channel = Channel(info.channel_id, shape, lambda: None, height_unit=unit, lateral_unit=lateral_unit)
    if (
        isinstance(info.unit, tuple)
        or not info.is_height_channel
        or (unit is not None and not is_length(unit))
    ):
        channel.height_unit = unit or "no unit"
        channel.no_height = f"values in {channel.height_unit}, no length"
    elif _NO_HEIGHT_NAME.search(info.name):
        channel.no_height = "by its name no topography"
    try:
        topography = info.topography()
        values = topography.heights()
    except CorruptFile as error:
        raise InputFileError(
            f"{path}: channel {info.channel_id!r} is not whole: the file was cut off"
        ) from error
    except Exception as error:
        if not channel.no_height:
            raise InputFileError(
                f"{path}: channel {info.channel_id!r} cannot be read ({brief(error)})"
            ) from error
        return channel
    if isinstance(topography.unit, str):
        channel.lateral_unit = topography.unit  # the library brings steps and heights to one unit
        if is_length(channel.height_unit):
            channel.height_unit = topography.unit
    if not topography.is_uniform:
        words = {key: getattr(channel, key) for key in ("lateral_unit", "height_unit", "no_height")}
        uneven = UnevenPositions("the positions along x are not evenly spaced")
        return scattered(channel.name, topography.positions(), None, values, uneven, **words)
    heights = as_heights(values, str(path))
    if topography.dim == 2:
        heights = heights.T
    sizes = topography.physical_sizes
    channel.shape = heights.shape
    outside = _outside_range(info, name, heights)
    if outside is not None:
        heights[outside] = np.nan
    channel.read = lambda: heights
    channel.notes = _sign_notes(info, name)
    if sizes is not None:
        steps = np.asarray(sizes, dtype=float) / np.asarray(topography.nb_grid_pts)
        if name == "nms":
            # The header gives nanometres where the library reads millimetres (fields of 160 m, not 160 µm).
            header = info.info["raw_metadata"]
            steps = np.array([header["dx_mm"], header["dy_mm"]]) * 1e-3
        channel.dx = float(steps[0])
        channel.dy = float(steps[1]) if steps.size > 1 else None
    return channel


def _check_rest(info, name, path):
    """Refuse files whose header claims more bytes than there are, after the heights: they were cut off."""
    header = info.info.get("raw_metadata") or {}
    claimed = 0
    if name == "al3d" and int(header.get("TextureImageOffset", 0)):
        planes = len(str(header.get("TexturePtr", "")).split(";"))
        claimed = int(header["TextureImageOffset"]) + planes * int(header["Rows"]) * int(header["Cols"])
    elif name == "plu":
        nx, ny = info.nb_grid_pts
        layout = header["measurement_configuration"]
        claimed = layout["num_layers"] * nx * ny * (4 + 3 * layout["num_images"])
    if path.stat().st_size < claimed:
        raise InputFileError(
            f"{path}: {path.stat().st_size} bytes where its header needs {claimed}: it was cut off"
        )


def _instrument(info, name, path) -> dict:
    """Return vendor, name, serial number, lens, date and the like."""
    kind, vendor = instrument_kinds.of_format(name)
    stated = dict(info.info.get("instrument") or {})
    stated.setdefault("vendor", vendor)
    stated |= {"kind": kind.name, "acquisition_time": info.info.get("acquisition_time")}
    if name == "nms":  # the library passes the date over
        with open(path, "rb") as stream:
            stream.seek(_NMS_DATE)
            date = re.match(rb"\d{4}-\d\d-\d\dT\d\d:\d\d", stream.read(16))
        stated["acquisition_time"] = date and date[0].decode()
    if name == "opd":
        stated = _wyko_lens(path) | stated
    if info.info.get("comment"):
        stated["comment"] = info.info["comment"]
    return instrument_words(stated, info.info.get("raw_metadata"))


def _wyko_lens(path) -> dict:
    """Return lens and numerical aperture where a Wyko file of the newer kind holds them.

    They are among the named values of its block MeasurementSet, which the library passes over: the length of
    the name (4 bytes), the name, then 0x12 0x01, a length and a text, or 0x0d and a double.
    """
    with open(path, "rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        lens = re.search(rb"\x09\0\0\0Objective\x12\x01([\x01-\x40])", data)
        aperture = re.search(rb"\x05\0\0\0ObjNa\x0d(.{8})", data, re.DOTALL)
        found = {}
        if lens:
            text = data[lens.end() : lens.end() + lens[1][0]]
            found["lens"] = text.decode("latin-1")
        if aperture:
            found["numerical_aperture"] = struct.unpack("<d", aperture[1])[0]
    return found


def _sign_notes(info, name) -> list[str]:
    """Return a sentence where the header says that heights were inverted, or are those of an imprint."""
    header = info.info.get("raw_metadata") or {}
    notes = []
    if name == "sur" and int(header.get("imprint") or 0):
        notes.append(
            "the header says that an imprint (replica) was measured: hills of the map are valleys of the "
            "surface"
        )
    inverted = {
        "sur": int(header.get("inversion") or 0) != 0,
        "metropro": int(header.get("sign") or 0) != 0,
        "opd": str(header.get("Data_Invert", "No")).strip().lower() not in ("no", ""),
    }
    if inverted.get(name):
        notes.append("the header says that the map was inverted or mirrored: check that peaks point up")
    return notes


def _outside_range(info, name, heights) -> np.ndarray | None:
    """Return which points of a FRT file carry one of the codes that its header sets apart, None elsewhere.

    Counts below `first_valid` and above `last_valid` are no heights; the library knows only one of the codes.
    """
    header = info.info.get("raw_metadata") or {}
    scale = (header.get("0x6c") or {}).get("height_scale_factor")
    limits = header.get("0x70")
    if name != "frt" or not scale or not limits:
        return None
    counts = np.rint(heights / scale)
    return (counts < limits["first_valid"]) | (counts > limits["last_valid"])
