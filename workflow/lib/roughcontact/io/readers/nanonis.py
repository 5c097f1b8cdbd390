r"""Nanonis SXM, of scanning tunnelling and force microscopes: a header of entries, and 4-byte floats.

An entry is a line ``:NAME:`` and the lines below it. Behind ``SCANIT_END`` and the bytes 0x1a 0x04 lie the
images of all channels of ``DATA_INFO``, of ``both`` directions forward and then backward, big-endian, as they
were scanned: lines from the top where ``SCAN_DIR`` is down, backward ones from the right.
"""

import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from roughcontact.io.channels import NO_TOPOGRAPHY, Channel, MeasuredFile, on_field, stored_floats
from roughcontact.io.guards import refusal, refusing
from roughcontact.io.instrument_kinds import PROBE
from roughcontact.io.interface import HEADER_BYTES, Reader, RecognisedBy, begins_with, read_head
from roughcontact.io.units import is_length

_MARK = b":NANONIS_VERSION:"
_END = b":SCANIT_END:"
_ENTRY = re.compile(r"^:([^:\n]+):\r?\n(.*?)(?=^:|\Z)", re.DOTALL | re.MULTILINE)
_START = b"\x1a\x04"  # of the images
_DIRECTIONS = {"both": ("forward", "backward"), "forward": ("forward",), "backward": ("backward",)}


def read(path: Path) -> MeasuredFile:
    """Open a file; each image is a channel."""
    text, _, behind = read_head(path, HEADER_BYTES).partition(_END)
    if _START not in behind:
        raise refusal("cut Nanonis")
    start = len(text) + len(_END) + behind.index(_START) + len(_START)
    entries = dict(_ENTRY.findall(text.decode("latin-1")))
    with refusing("looks like Nanonis SXM, but its header is damaged"):
        channels = [*_channels(entries, start, path)]
        first_row = {"down": "top", "up": "bottom"}[entries["SCAN_DIR"].strip()]
        acquired_at = f"{entries.get('REC_DATE', '').strip()} {entries.get('REC_TIME', '').strip()}".strip()
    size = start + sum(4 * channel.shape[0] * channel.shape[1] for channel in channels)
    instrument = {"kind": PROBE.name, "vendor": "SPECS", "acquisition_time": acquired_at}
    return MeasuredFile("Nanonis SXM", channels, first_row, instrument, required_size=size)


def _channels(entries: dict[str, str], start: int, path: Path) -> Iterator[Channel]:
    """Yield the images, one behind the other from the byte `start` on."""
    if entries["SCANIT_TYPE"].split() != ["FLOAT", "MSBFIRST"]:
        raise refusal("numbers of Nanonis", kind=entries["SCANIT_TYPE"].strip())
    nx, ny = map(int, entries["SCAN_PIXELS"].split())
    field = [*map(float, entries["SCAN_RANGE"].split())]
    names, *rows = (line.split("\t") for line in entries["DATA_INFO"].splitlines() if line.strip())
    for row in rows:
        entry = dict(zip(map(str.strip, names), map(str.strip, row), strict=True))
        unit = entry["Unit"] or "no unit"
        is_other = is_length(unit) and NO_TOPOGRAPHY.search(entry["Name"])
        why = "by its name no topography" if is_other else ""
        for direction in _DIRECTIONS[entry["Direction"].lower()]:
            name = f"{entry['Name']} ({direction})"
            image = partial(_read, path, start, (ny, nx), reverse=direction == "backward")
            yield on_field(Channel(name, (ny, nx), image, unit, no_height=why), field, "m")
            start += 4 * nx * ny


def _read(path: Path, start: int, shape: tuple[int, int], *, reverse: bool) -> np.ndarray:
    """Return the values of one image, NaN in lines that were not scanned."""
    heights = stored_floats(path, ">f4", shape, start)
    return heights[:, ::-1].copy() if reverse else heights


READER = Reader(RecognisedBy.MARK, begins_with(_MARK), read, binary=True)
