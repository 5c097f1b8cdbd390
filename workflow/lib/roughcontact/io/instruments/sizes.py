"""Sizes of instrument files (bytes) by their own headers and directories; None where they do not say it.

The heights behind lost or added bytes moved.
"""

import mmap
import re
import struct
from collections.abc import Mapping
from configparser import RawConfigParser
from typing import Any

from roughcontact.io.instruments import nanoscope
from roughcontact.io.instruments.containers import tiff_end

Header = Mapping[str, Any]


def metropro(data: mmap.mmap, header: Header, points: int) -> int:
    """Count header, intensities (two bytes a point, in each bucket) and phases (four bytes)."""
    intensities = header["ac_n_buckets"] * header["ac_org_height"] * header["ac_org_width"]
    return header["header_size"] + 2 * intensities + 4 * points


def nanofocus(data: mmap.mmap, header: Header, points: int) -> int:
    """Count header and heights (two bytes), behind which lie whole images of a byte a point."""
    images = max(0, round((len(data) - 3468) / points) - 2)
    return 3468 + (2 + images) * points


def alicona(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count up to the end of the texture, a byte a point in rows of a multiple of eight bytes."""
    start = int(header.get("TextureImageOffset") or 0)
    row = -(-int(header["Cols"]) // 8) * 8
    planes = int(header.get("NumberOfPlanes") or len(str(header.get("TexturePtr", "")).split(";")))
    return start + planes * int(header["Rows"]) * row if start else None


def sensofar(data: mmap.mmap, header: Header, points: int) -> int:
    """Count the layers: their size, heights, extremes, and images of three bytes a point."""
    layout = header["measurement_configuration"]
    start = 500 if layout["area_type"] != 6 else 496
    counted = start + layout["num_layers"] * (16 + points * (4 + 3 * layout["num_images"]))
    return max(counted, len(data))  # blocks that nothing counts follow


def wsxm(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count the header, whose size it states, and the points."""
    match = re.search(rb"Image header size:\s*(\d+)", data[:4096])
    data_type = header["General Info"].get("Image Data Type", "short")
    width = {"short": 2, "integer": 2, "float": 4, "double": 8}.get(data_type)
    return int(match[1]) + width * points if match and width else None


def bcr(data: mmap.mmap, header: Header, points: int) -> int:
    """Count a header of a stated number of characters, and the points."""
    file_format = str(header["fileformat"])
    characters = int(header.get("headersize", 2048))
    width = 4 if file_format.startswith("bcrf") else 2
    return characters * (2 if file_format.endswith("unicode") else 1) + width * points


def molecular_imaging(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count the header up to its last line, and all buffers."""
    last = re.search(rb"^data {10}(BINARY|BINARY_32)?\r?\n", data, re.MULTILINE)
    if last is None:
        return None
    buffers = len(re.findall(rb"^bufferLabel", data[: last.start()], re.MULTILINE))
    return last.end() + buffers * points * (4 if last[1] == b"BINARY_32" else 2)


def microprof(data: mmap.mmap, header: Header, points: int) -> int:
    """Count the tagged blocks."""
    entry = struct.Struct("<HI" if data[12:16] == b"1.00" else "<HQ")
    (blocks,) = struct.unpack_from("<H", data, 16)
    offset = 18
    for _ in range(blocks):
        if offset + entry.size > len(data):
            return offset + entry.size
        offset += entry.size + entry.unpack_from(data, offset)[1]
    return offset


def wyko(data: mmap.mmap, header: Header, points: int) -> int:
    """Count the directory and the blocks that it lists."""
    entry = struct.Struct("<16shiH")
    size = 2 + entry.unpack_from(data, 2)[2]
    for offset in range(2 + entry.size, min(size, len(data) - entry.size + 1), entry.size):
        size += max(0, entry.unpack_from(data, offset)[2])
    return size


def bruker(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count up to the end of the last block that a section of the header places."""
    text = data[: max(0, data.find(nanoscope.END))]
    blocks = [block for block in nanoscope.sections(text) if "data offset" in block]
    ends = [int(block["data offset"]) + int(block["data length"]) for block in blocks]
    return max(ends) if ends else None


def nanosurf(data: mmap.mmap, header: Header, points: int) -> int | None:
    """Count the header up to its mark, and every data set that it lists."""
    begin = data.find(b"\r\n#!")
    if begin < 0:
        return None
    sections = RawConfigParser(delimiters=("=",), allow_no_value=True, strict=False)
    sections.read_string(data[:begin].decode("latin-1"))
    size = begin + 4
    for key, name in sections["DataSet"].items():
        if re.fullmatch(r"gr\d+-ch\d+", key) and sections.has_option(name, "SaveBits"):
            points = sections.getint(name, "Points") * sections.getint(name, "Lines")
            size += points * sections.getint(name, "SaveBits") // 8
    return size


def park(data: mmap.mmap, header: Header, points: int) -> int:
    """Count up to the end of the last page, value or strip of the TIFF."""
    return tiff_end(data)
