"""The instrument formats: their marks, vendors, and header entries that the library skips.

The library's readers that accept any bytes (hgt, h5, mat, npz, xyz, asc) are left out.
"""

import mmap
import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.io.instrument_kinds import OPTICAL, PROBE, STYLUS, UNKNOWN, Kind
from roughcontact.io.instruments import nanoscope, sizes
from roughcontact.io.instruments.containers import OLE, TIFF, ZIP, tiff_tags
from roughcontact.io.instruments.sizes import Header
from roughcontact.io.interface import RecognisedBy
from roughcontact.io.text.lines import looks_like_text


@dataclass(frozen=True)
class Format:
    """One format that SurfaceTopography reads."""

    name: str  # in the library
    # first bytes, perhaps of several formats; without one only an attempt to read tells
    marks: tuple[bytes, ...] = ()
    kind: Kind = UNKNOWN  # of the instrument that writes it
    vendor: str = ""  # where only one uses the format
    offset: int = 0  # position of the mark, bytes
    text_header: bool = False  # plain text; otherwise a text that begins with the mark is a text
    binary_data: bool = False  # after a text header: a file that is text to its end is an export
    # CONTENTS for the mark of a container, in which another reader looks
    recognised_by: RecognisedBy = RecognisedBy.MARK
    # bytes of the file by its header and the points of a channel
    size: Callable[[mmap.mmap, Header, int], int | None] = lambda data, header, points: None

    def has_mark(self, head: bytes) -> bool:
        """Return whether a file that begins with `head` has the mark of this format."""
        return head.startswith(self.marks, self.offset) and (self.text_header or not looks_like_text(head))

    def is_plausible(self, header: Header) -> bool:
        """Return whether a header from the library can be of this format: guards against chance matches."""
        return True

    def corrected(self, channels: list[Any], path: Path) -> list[str]:
        """Correct the channels that the library found, in place, and return what was changed."""
        return []

    def steps(self, header: Header, steps: np.ndarray) -> np.ndarray:
        """Return the steps (dx, dy), from those that the library found."""
        return steps

    def not_measured(self, header: Header, heights: np.ndarray) -> np.ndarray | bool:
        """Return a mask (ny, nx) of points with a code for missing points that the library does not know."""
        return False

    def instrument(self, path: Path) -> dict[str, Any]:
        """Return the file's metadata of the instrument beyond those that the library finds, by label."""
        return {}

    def contradiction(self, path: Path, header: Header) -> str:
        """Return which statements of the header contradict each other; empty where none do."""
        return ""

    def sign_notes(self, header: Header) -> list[str]:
        """Return a sentence where the header says that heights were inverted, masked, or of an imprint."""
        return []


INVERTED = "the header says that the map was inverted or mirrored: check that peaks point up"
IMPRINT = (
    "the header says that an imprint (replica) was measured: hills of the map are valleys of the surface"
)


class _Igor(Format):
    def contradiction(self, path, header):
        # the 16-bit words of both headers of version 5 add up to zero (WaveMetrics, Technical Note 003)
        with path.open("rb") as stream:
            numbers = np.frombuffer(stream.read(384), "<u2")
        numbers = numbers if numbers[0] == 5 else numbers.byteswap()
        return "the checksum of its header does not match its content" if int(numbers.sum()) & 0xFFFF else ""


class _MetroPro(Format):
    def contradiction(self, path, header):
        points = header["cn_org_width"] * header["cn_org_height"]
        if header["cn_n_bytes"] == 4 * points:
            return ""
        return f"its header counts {header['cn_n_bytes']} bytes of heights, which are no {points} points"

    def sign_notes(self, header):
        return [INVERTED] if int(header.get("sign") or 0) else []


class _MicroProf(Format):
    def not_measured(self, header, heights):
        # counts below the first or above the last valid one are codes; the library knows only one
        scale = (header.get("0x6c") or {}).get("height_scale_factor")
        limits = header.get("0x70")
        if not scale or not limits:
            return False
        counts = np.rint(heights / scale)
        return (counts < limits["first_valid"]) | (counts > limits["last_valid"])


_PARK_DATA = 50434  # tag of TIFF
_DATE_OF_NANOFOCUS = 1076  # position in the header, bytes


class _NanoFocus(Format):
    def is_plausible(self, header):
        steps = np.array([header["dx_mm"], header["dy_mm"]])
        span = header["zmax"] - header["zmin"]
        return bool(np.all((steps > 1e-3) & (steps < 1e6)) and 0 < span < 1e5)

    def steps(self, header, steps):
        # nanometres, where the library reads millimetres (fields of 160 m, not 160 µm)
        return np.array([header["dx_mm"], header["dy_mm"]]) * 1e-3

    def instrument(self, path):
        with path.open("rb") as stream:
            stream.seek(_DATE_OF_NANOFOCUS)
            date = re.match(rb"\d{4}-\d\d-\d\dT\d\d:\d\d", stream.read(16))
        return {"acquisition_time": date and date[0].decode()}


class _Nanoscope(Format):
    def corrected(self, channels, path):
        return nanoscope.corrected(channels, path)


class _Park(Format):
    def contradiction(self, path, header):
        points = header["nb_grid_pts_x"] * header["nb_grid_pts_y"]
        with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            stored = next((tag.length for tag in tiff_tags(data) if tag.number == _PARK_DATA), 0)
        required_size = points * (2 if header.get("data_type", 0) == 0 else 4)
        if stored == required_size:
            return ""
        return f"its tag of the heights has {stored} bytes where {points} points need {required_size}"


class _Wyko(Format):
    def instrument(self, path):
        """Return lens and numerical aperture from the block MeasurementSet of the newer kind of file."""
        with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            # length of the name (4 bytes), name, then 0x12 0x01, a length and a text, or 0x0d and a double
            lens = re.search(rb"\x09\0\0\0Objective\x12\x01([\x01-\x40])", data)
            aperture = re.search(rb"\x05\0\0\0ObjNa\x0d(.{8})", data, re.DOTALL)
            instrument = {}
            if lens:
                instrument["lens"] = data[lens.end() : lens.end() + lens[1][0]].decode("latin-1")
            if aperture:
                instrument["numerical_aperture"] = struct.unpack("<d", aperture[1])[0]
        return instrument

    def sign_notes(self, header):
        inverted = str(header.get("Data_Invert", "No")).strip().lower() not in ("no", "")
        return [INVERTED] if inverted else []


_METROPRO = (b"\x88\x1b\x03\x6f", b"\x88\x1b\x03\x70", b"\x88\x1b\x03\x71")
_BCR = ("fileformat".encode("utf-16-le"), "\ufefffileformat".encode("utf-16-le"))

# Formats with the same mark, or without one, are tried in this order.
FORMATS = (
    _Nanoscope("di", (b"\\*",), PROBE, "Bruker", text_header=True, binary_data=True, size=sizes.bruker),
    Format("ezd", (b"[DataSet]",), PROBE, "Nanosurf", text_header=True, size=sizes.nanosurf),
    Format("mi", (b"fileType",), PROBE, "Molecular Imaging", text_header=True, size=sizes.molecular_imaging),
    Format("al3d", (b"AliconaImaging",), OPTICAL, "Alicona", size=sizes.alicona),
    _MicroProf("frt", (b"FRTM_GLIDERV",), OPTICAL, "FRT", size=sizes.microprof),
    Format("wsxm", (b"WSxM",), PROBE, "Nanotec", text_header=True, binary_data=True, size=sizes.wsxm),
    Format("mdt", (b"\x01\xb0\x93\xff",), PROBE, "NT-MDT"),
    Format("zmg", (b"Zeta-Instruments",), OPTICAL, "KLA Zeta"),
    Format("zon", (b"KPK0", b"KPK1"), OPTICAL, "Keyence"),
    Format("vk", (b"VK3_", b"VK4_", b"VK6", b"VK7"), OPTICAL, "Keyence"),
    Format("opdx", (b"VCA DATA",), STYLUS, "Bruker"),
    Format("datx", (b"\x89HDF",), OPTICAL, "Zygo", recognised_by=RecognisedBy.CONTENTS),
    Format("mnt", OLE),
    Format("oir", (b"OLYMPUSRAWFORMAT",), OPTICAL, "Olympus"),
    _Park("ps", TIFF, PROBE, "Park Systems", size=sizes.park),
    Format("jpk", TIFF, PROBE, "JPK"),
    Format("lext", TIFF, OPTICAL, "Olympus"),
    Format("plux", ZIP, OPTICAL, "Sensofar"),
    Format("nmm", ZIP, PROBE),
    Format("poir", ZIP, OPTICAL, "Olympus"),
    Format("qep", ZIP, STYLUS, "Mahr"),
    Format("mitutoyo", ZIP, STYLUS, "Mitutoyo"),
    Format("bcr", (b"fileformat", *_BCR), text_header=True, size=sizes.bcr),
    _MetroPro("metropro", _METROPRO, OPTICAL, "Zygo", size=sizes.metropro),
    _Wyko("opd", (b"Directory",), OPTICAL, "Wyko", offset=2, size=sizes.wyko),
    Format("os3d", (b"OmniSurf3D",)),
    _Igor("ibw", (), PROBE),
    Format("plu", (), OPTICAL, "Sensofar", size=sizes.sensofar),
    _NanoFocus("nms", (), OPTICAL, "NanoFocus", size=sizes.nanofocus),
)


def marked(head: bytes) -> list[Format]:
    """Return the formats whose mark a file has, in the order in which they are tried.

    Examples
    --------
    >>> [each.name for each in marked(b"II*" + bytes(100))]
    ['ps', 'jpk', 'lext']
    >>> marked(b"KPK0 is how this text begins")
    []
    """
    return [format_ for format_ in FORMATS if format_.has_mark(head)]
