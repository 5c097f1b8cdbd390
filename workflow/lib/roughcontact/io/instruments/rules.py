"""What SurfaceTopography does not know of some formats: sizes of files, contradictions, codes, corrections.

Heights behind lost or added bytes moved, so the size of a file (bytes) is counted by its header, or by its
own directory; None where neither says it.
"""

import io
import mmap
import re
import struct
from collections.abc import Callable, Mapping
from configparser import RawConfigParser
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from roughcontact.io.instruments import nanoscope
from roughcontact.io.instruments.containers import tiff_end, tiff_tags

INVERTED = "the header says that the map was inverted or mirrored: check that peaks point up"
IMPRINT = "the header says that an imprint (replica) was measured: its hills are valleys of the surface"
Header = Mapping[str, Any]
_PARK_DATA = 50434  # tag of TIFF
_DATE_OF_NANOFOCUS = 1076  # position in the header, bytes
_HEADER_OF_NANOFOCUS = 3468  # bytes


class Rules(NamedTuple):
    """What is asked of a format, of the bytes of a file, its header and the points of a channel."""

    size: Callable[[mmap.mmap, Header, int], int | None] = lambda data, header, points: None
    # which statements of the header do not agree
    contradiction: Callable[[mmap.mmap, Header], str] = lambda data, header: ""
    source: Callable[[Path], str | io.BytesIO] = str  # what the library reads
    # guards against chance matches
    is_plausible: Callable[[Header], bool] = lambda header: True
    # corrects the channels in place, and returns what was changed
    corrected: Callable[[list[Any], Path], list[str]] = lambda channels, path: []
    steps: Callable[[Header, np.ndarray], np.ndarray] = lambda header, steps: steps  # (dx, dy)
    # mask of points (ny, nx) with a code for missing ones
    not_measured: Callable[[Header, np.ndarray], np.ndarray | bool] = lambda header, heights: False
    instrument: Callable[[mmap.mmap], dict[str, Any]] = lambda data: {}
    is_inverted: Callable[[Header], bool] = lambda header: False


def _metropro_size(data: mmap.mmap, header: Header, points: int) -> int:
    """Count header, intensities (two bytes a point, in each bucket) and phases (four bytes)."""
    intensities = header["ac_n_buckets"] * header["ac_org_height"] * header["ac_org_width"]
    return header["header_size"] + 2 * intensities + 4 * points


def _metropro(data: mmap.mmap, header: Header) -> str:
    points, n_bytes = header["cn_org_width"] * header["cn_org_height"], header["cn_n_bytes"]
    wrong = f"its header counts {n_bytes} bytes of heights, which are no {points} points"
    return "" if n_bytes == 4 * points else wrong


def _nanofocus_size(data: mmap.mmap, header: Header, points: int) -> int:
    """Count header and heights (two bytes), behind which lie whole images of a byte a point."""
    return _HEADER_OF_NANOFOCUS + max(2, round((len(data) - _HEADER_OF_NANOFOCUS) / points)) * points


def _nanofocus_steps(header: Header, steps: np.ndarray) -> np.ndarray:
    # nanometres, where the library reads millimetres (fields of 160 m, not 160 µm)
    return np.array([header["dx_mm"], header["dy_mm"]]) * 1e-3


def _is_nanofocus(header: Header) -> bool:
    steps = np.array([header["dx_mm"], header["dy_mm"]])
    return bool(np.all((steps > 1e-3) & (steps < 1e6)) and 0 < header["zmax"] - header["zmin"] < 1e5)


def _nanofocus_instrument(data: mmap.mmap) -> dict[str, Any]:
    date = re.match(rb"\d{4}-\d\d-\d\dT\d\d:\d\d", data[_DATE_OF_NANOFOCUS:][:16])
    return {"acquisition_time": date and date[0].decode()}


def _alicona_size(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count up to the end of the texture, a byte a point in rows of a multiple of eight bytes."""
    start = int(header.get("TextureImageOffset") or 0)
    row = -(-int(header["Cols"]) // 8) * 8
    planes = int(header.get("NumberOfPlanes") or len(str(header.get("TexturePtr", "")).split(";")))
    return start + planes * int(header["Rows"]) * row if start else None


def _sensofar_size(data: mmap.mmap, header: Header, points: int) -> int:
    """Count the layers: their size, heights, extremes, and images of three bytes a point."""
    layout = header["measurement_configuration"]
    start = 500 if layout["area_type"] != 6 else 496
    # blocks that nothing counts follow
    return max(start + layout["num_layers"] * (16 + points * (4 + 3 * layout["num_images"])), len(data))


def _wsxm_size(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count the header, whose size it states, and the points."""
    match = re.search(rb"Image header size:\s*(\d+)", data[:4096])
    data_type = header["General Info"].get("Image Data Type", "short")
    width = {"short": 2, "integer": 2, "float": 4, "double": 8}.get(data_type)
    return int(match[1]) + width * points if match and width else None


def _bcr_size(data: mmap.mmap, header: Header, points: int) -> int:
    """Count a header of a stated number of characters, and the points."""
    form, characters = str(header["fileformat"]), int(header.get("headersize", 2048))
    return characters * (1 + form.endswith("unicode")) + points * (4 if form.startswith("bcrf") else 2)


def _molecular_imaging_size(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count the header up to its last line, and all buffers."""
    last = re.search(rb"^data {10}(BINARY|BINARY_32)?\r?\n", data, re.MULTILINE)
    if last is None:
        return None
    buffers = len(re.findall(rb"^bufferLabel", data[: last.start()], re.MULTILINE))
    return last.end() + buffers * points * (4 if last[1] == b"BINARY_32" else 2)


def _microprof_size(data: mmap.mmap, header: Header, points: int) -> int:
    """Count the tagged blocks."""
    entry = struct.Struct("<HI" if data[12:16] == b"1.00" else "<HQ")
    offset = 18
    for _ in range(int.from_bytes(data[16:18], "little")):
        if offset + entry.size > len(data):
            return offset + entry.size
        offset += entry.size + entry.unpack_from(data, offset)[1]
    return offset


def _microprof_codes(header: Header, heights: np.ndarray) -> np.ndarray | bool:
    # counts below the first or above the last valid one are codes; the library knows only one
    scale, limits = (header.get("0x6c") or {}).get("height_scale_factor"), header.get("0x70")
    if not scale or not limits:
        return False
    counts = np.rint(heights / scale)
    return (counts < limits["first_valid"]) | (counts > limits["last_valid"])


def _wyko_size(data: mmap.mmap, header: Header, points: int) -> int:
    """Count the directory and the blocks that it lists."""
    entry = struct.Struct("<16shiH")
    size = 2 + entry.unpack_from(data, 2)[2]
    for offset in range(2 + entry.size, min(size, len(data) - entry.size + 1), entry.size):
        size += max(0, entry.unpack_from(data, offset)[2])
    return size


def _wyko_instrument(data: mmap.mmap) -> dict[str, Any]:
    """Return lens and numerical aperture from the block MeasurementSet of the newer kind of file."""
    # length of the name (4 bytes), name, then 0x12 0x01, a length and a text, or 0x0d and a double
    lens = re.search(rb"\x09\0\0\0Objective\x12\x01([\x01-\x40])", data)
    aperture = re.search(rb"\x05\0\0\0ObjNa\x0d(.{8})", data, re.DOTALL)
    name = data[lens.end() : lens.end() + lens[1][0]].decode("latin-1") if lens else None
    return {"lens": name, "numerical_aperture": struct.unpack("<d", aperture[1])[0] if aperture else None}


def _bruker_size(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count up to the end of the last block that a section of the header places."""
    sections = nanoscope.sections(data[: max(0, data.find(nanoscope.END))])
    blocks = (section for section in sections if "data offset" in section)
    return max((int(block["data offset"]) + int(block["data length"]) for block in blocks), default=None)


def _nanosurf_size(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count the header up to its mark, and every data set that it lists."""
    begin = data.find(b"\r\n#!")
    if begin < 0:
        return None
    sections = RawConfigParser(delimiters=("=",), allow_no_value=True, strict=False)
    sections.read_string(data[:begin].decode("latin-1"))
    size = begin + 4
    for key, name in sections["DataSet"].items():
        if re.fullmatch(r"gr\d+-ch\d+", key) and sections.has_option(name, "SaveBits"):
            points, lines, bits = (sections.getint(name, each) for each in ("Points", "Lines", "SaveBits"))
            size += points * lines * bits // 8
    return size


def _park(data: mmap.mmap, header: Header) -> str:
    points = header["nb_grid_pts_x"] * header["nb_grid_pts_y"]
    stored_bytes = next((tag.length for tag in tiff_tags(data) if tag.number == _PARK_DATA), 0)
    required_size = points * (2 if header.get("data_type", 0) == 0 else 4)
    wrong = f"its tag of the heights has {stored_bytes} bytes where {points} points need {required_size}"
    return "" if stored_bytes == required_size else wrong


def _igor(data: mmap.mmap, header: Header) -> str:
    # the 16-bit words of both headers of version 5 add up to zero (WaveMetrics, Technical Note 003)
    numbers = np.frombuffer(data[:384], "<u2")
    total = int((numbers if numbers[0] == 5 else numbers.byteswap()).sum())
    return "the checksum of its header does not match its content" if total & 0xFFFF else ""


def _is_set(key: str, header: Header) -> bool:
    """Return whether an entry of a header is neither 0, nor no, nor empty."""
    return str(header.get(key) or "").strip().lower() not in ("", "0", "no")


#: By the library's name of the format.
RULES = {
    "di": Rules(_bruker_size, source=nanoscope.with_micro_signs, corrected=nanoscope.corrected),
    "ezd": Rules(_nanosurf_size),
    "mi": Rules(_molecular_imaging_size),
    "al3d": Rules(_alicona_size),
    "frt": Rules(_microprof_size, not_measured=_microprof_codes),
    "wsxm": Rules(_wsxm_size),
    "ps": Rules(lambda data, header, points: tiff_end(data), _park),
    "bcr": Rules(_bcr_size),
    "metropro": Rules(_metropro_size, _metropro, is_inverted=partial(_is_set, "sign")),
    "opd": Rules(_wyko_size, instrument=_wyko_instrument, is_inverted=partial(_is_set, "Data_Invert")),
    "ibw": Rules(contradiction=_igor),
    "plu": Rules(_sensofar_size),
    "nms": Rules(
        _nanofocus_size, is_plausible=_is_nanofocus, steps=_nanofocus_steps, instrument=_nanofocus_instrument
    ),
}
