"""Lines and sizes of Nanoscope's channels, from all that its header states of them.

The stated lines and second size may be those of the planned scan: the length of the data says how many lines
there are.
"""

import io
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from roughcontact.arguments.quantities import number
from roughcontact.errors import InputFileError
from roughcontact.io.interface import HEADER_BYTES, read_head

END = b"\\*File list end"


def sections(header: bytes) -> Iterator[dict[str, str]]:
    r"""Yield the sections of a header, each with its entries by lower-case names, and its ``name``.

    Examples
    --------
    >>> [*sections(b"\\*Ciao scan list\r\n\\Samps/line: 512\r\n\\*File list end")]
    [{'name': 'ciao scan list', 'samps/line': '512'}]
    """
    for body in header.partition(END)[0].decode("latin-1").split("\\*")[1:]:
        entries = re.findall(r"^\\([^:\r\n]+): ?(.*)$", body, re.MULTILINE)
        name = body.partition("\n")[0].strip().lower()
        yield {"name": name} | {key.lower(): value.strip() for key, value in entries}


def with_micro_signs(path: Path) -> str | io.BytesIO:
    """Return a file for the library, which knows ``~m`` in sizes but takes a sensitivity in it for none."""
    header, end, behind = path.read_bytes().partition(END)
    return io.BytesIO(header.replace(b"~m", b"\xb5m") + end + behind) if b"~m/" in header else str(path)


def corrected(channels: list[Any], path: Path) -> list[str]:
    """Give the library's channels, in place, the lines and sizes of the file; return what was changed.

    The length of y is that of the scanned lines of the planned ones; pixels are square where more lines are
    there.
    """
    from SurfaceTopography.IO.Reader import ChannelInfo

    scan = next((section for section in sections(read_head(path, HEADER_BYTES)) if "lines" in section), {})
    notes = []
    for index, info in enumerate(channels):
        image = info.info["raw_metadata"]
        (nx, ny), (x, y) = info.nb_grid_pts, info.physical_sizes
        if not x * y:
            raise InputFileError(f"its scan size is {image['scan size']}: it did not move over the surface")
        n_bytes, bytes_of_line = int(image["data length"]), nx * info.tags["elsize"]
        lines = n_bytes // bytes_of_line
        # a block of another length than whole lines holds more than this image: the header decides
        if lines * bytes_of_line != n_bytes or lines != int(image.get("valid data len y", lines)):
            lines = ny
        length = y * lines / ny if "slow axis size" in scan else x * _aspect(scan, nx, lines, image)
        if unread := n_bytes - lines * bytes_of_line:
            remainder = f"{unread} of the {n_bytes} bytes of channel {info.name!r}"
            notes.append(f"{remainder} are no part of its {lines} lines")
        if lines == ny and abs(length / y - 1) < 1e-9:
            continue
        unit = info.unit[0] if isinstance(info.unit, tuple) else info.unit
        points = f"{image['samps/line']} x {image['number of lines']} points on {image['scan size']}"
        data = f"{lines} lines of {nx}, on {number(x)} x {number(length)} {unit}"
        notes.append(f"the header states {points}; the data are {data}")
        names = ("name", "height_scale_factor", "unit", "info", "tags")
        attributes = {name: getattr(info, name) for name in names}
        grid = {"dim": 2, "nb_grid_pts": (nx, lines), "physical_sizes": (x, length)}
        channels[index] = ChannelInfo(info.reader, index, periodic=False, uniform=True, **grid, **attributes)
    return list(dict.fromkeys(notes))


def _aspect(scan: dict[str, str], nx: int, lines: int, image: dict[str, str]) -> float:
    """Return the length along y over that along x."""
    sizes = re.match(r"([\d.]+) +([\d.]+)", image["scan size"])
    header_aspect = float(sizes[2]) / float(sizes[1]) if sizes else 1.0
    if int(scan.get("samps/line", 0)) != nx:
        return header_aspect
    ratio = re.match(r"([\d.]+):([\d.]+)", scan.get("aspect ratio", ""))
    aspect = float(ratio[2]) / float(ratio[1]) if ratio else 1.0
    planned_lines = int(scan["lines"])
    if lines == planned_lines:
        return aspect if header_aspect == 1 else header_aspect
    return aspect * lines / planned_lines if lines < planned_lines else lines / nx
