"""TIFF of ImageJ: an image of floats or 16-bit counts is a channel, in the unit of its description, if any.

The description (tag 270) begins with ``ImageJ=``; it has the unit of length, and for calibrated values their
unit and straight line. The resolution is a number of pixels for each unit; row 0 is the upper one.
"""

import mmap
import re
from functools import partial
from pathlib import Path

import numpy as np

from roughcontact.io.channels import Channel, MeasuredFile, as_heights, stated_length
from roughcontact.io.guards import refusal, refuse_more, refusing
from roughcontact.io.instruments.containers import TIFF, check_tiff, tiff_end, tiff_tags
from roughcontact.io.interface import Reader, RecognisedBy
from roughcontact.io.units import is_length

_DESCRIPTION, _RESOLUTIONS = 270, (282, 283)  # tags, of these along x and y
_MODES = ("F", "I;16", "I;16B")  # of Pillow; images of 8 bits and colours are pictures
_STRAIGHT_LINE = 0  # the function of calibrated values, c0 + c1 value; those from 20 on are none
_NO_FUNCTION = 20
_MAX_PAGES = 256  # a page is found through those before it


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is a TIFF that ImageJ described."""
    return head.startswith(TIFF) and _description(path).startswith("ImageJ=")


def read(path: Path) -> MeasuredFile:
    """Open a file; only the sizes of its images are read."""
    from PIL.TiffImagePlugin import TiffImageFile

    properties = dict(re.findall(r"^(\w+)=(.*)$", _description(path), re.MULTILINE))
    unit = properties.get("unit", "").encode().decode("unicode_escape", "replace").strip()
    function = int(properties.get("cf", _NO_FUNCTION))
    if _STRAIGHT_LINE < function < _NO_FUNCTION:
        raise refusal("curve of ImageJ")
    line = float(properties.get("c0", 0.0)), float(properties.get("c1", 1.0))
    height_unit = properties.get("vunit") if function == _STRAIGHT_LINE else None
    lateral_unit = unit if is_length(unit) else None
    channels = []
    with refusing("looks like a TIFF of ImageJ, but is damaged"), TiffImageFile(path) as image:
        refuse_more(f"{image.n_frames} pages", image.n_frames, _MAX_PAGES, "save one")
        for number in range(image.n_frames):
            image.seek(number)
            if image.mode not in _MODES:
                raise refusal("picture of ImageJ", mode=image.mode)
            name = f"page {number + 1}" if image.n_frames > 1 else "height"
            values = partial(_read, path, number, line if function == _STRAIGHT_LINE else None)
            channel = Channel(name, image.size[::-1], values, height_unit, lateral_unit=lateral_unit)
            if lateral_unit:
                densities = [stated_length(image.tag_v2.get(tag)) for tag in _RESOLUTIONS]
                channel.dx, channel.dy = (density and 1 / density for density in densities)
            channels.append(channel)
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        return MeasuredFile("ImageJ TIFF", channels, "top", required_size=tiff_end(data))


def _description(path: Path) -> str:
    """Return the description of the first image."""
    check_tiff(path)
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        tag = next((tag for tag in tiff_tags(data) if tag.number == _DESCRIPTION), None)
        return data[tag.place : tag.place + tag.length].decode("latin-1").rstrip("\0") if tag else ""


def _read(path: Path, number: int, line: tuple[float, float] | None) -> np.ndarray:
    """Return the values of one image."""
    from PIL.TiffImagePlugin import TiffImageFile

    with refusing("its image is damaged"), TiffImageFile(path) as image:
        image.seek(number)
        values = as_heights(np.asarray(image))
    return values if line is None else line[0] + line[1] * values


READER = Reader(RecognisedBy.CONTENTS, recognises, read, binary=True)
