"""Safe reading of the formats of `formats.tsv` with SurfaceTopography, without sizes or units passed to it.

The transpose of its heights [x, y], drawn as a picture, looks as in the instrument's software: row 0 is the
upper line.
"""

import logging
import mmap
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io import hdf5, instrument_kinds
from roughcontact.io.channels import NO_TOPOGRAPHY, Channel, MeasuredFile, as_heights, unreadable
from roughcontact.io.guards import brief, check_points, refusal
from roughcontact.io.instruments import containers
from roughcontact.io.instruments.rules import INVERTED, RULES, Header, Rules
from roughcontact.io.interface import Reader, read_head
from roughcontact.io.positions import scattered
from roughcontact.io.text.lines import looks_like_text
from roughcontact.io.units import is_length
from roughcontact.io.vocabulary import marks, rows_of

_BYTES_PER_BYTE = 8  # memory for each byte of a file: two-byte integers become double precision, twice


class Format(NamedTuple):
    """One row of the table."""

    name: str  # in the library
    marks: tuple[bytes, ...]
    offset: int
    kind: instrument_kinds.Kind  # of the instrument that writes it
    text: str  # `no`, `text`, `binary`
    vendor: str
    rules: Rules  # what the library does not know of the format


FORMATS = [
    Format(key, marks(first), int(at), getattr(instrument_kinds, kind), text, vendor, RULES.get(key, Rules()))
    for key, first, at, kind, text, vendor in rows_of("formats.tsv")
]


def marked(head: bytes) -> list[Format]:
    """Return the formats whose mark a file has, in the order in which they are tried.

    Examples
    --------
    >>> [each.name for each in marked(b"II*" + bytes(100))]
    ['ps', 'jpk', 'lext']
    >>> marked(b"KPK0 is how this text begins")
    []
    """
    kinds = ("text", "binary") if looks_like_text(head) else ("no", "text", "binary")
    return [each for each in FORMATS if head.startswith(each.marks, each.offset) and each.text in kinds]


def read_instrument(path: Path) -> MeasuredFile:
    """Open a file by the first of the formats with its mark that can read it.

    A file without a mark, as a container too damaged to be examined may be, is tried as each format without.
    """
    head = read_head(path)
    if head.startswith(containers.TIFF):
        containers.check_tiff(path)
    if head.startswith(hdf5.MARK):  # links into other files are refused before the library follows them
        hdf5.datasets(path)
    formats = marked(head) or [format_ for format_ in FORMATS if not format_.marks]
    if head.startswith(containers.ZIP):
        names = containers.formats_within(path)
        formats = [format_ for format_ in formats if format_.name in names]
    failures: list[tuple[str, Exception]] = []
    with _silence():
        from SurfaceTopography.Exceptions import FileFormatMismatch
        from SurfaceTopography.IO import lookup_reader_by_format

        for format_ in formats:
            library = lookup_reader_by_format[format_.name]
            try:
                return _open(library(format_.rules.source(path)), format_, path)
            except (InputFileError, ImportError, MemoryError):
                raise
            except FileFormatMismatch:
                continue
            except Exception as error:  # a reader may fail on foreign bytes in any way
                without_tags = isinstance(error, IndexError | KeyError | AttributeError | TypeError)
                # a container that holds something else than this format
                is_foreign = format_.marks == containers.TIFF and without_tags
                if format_.name != "mitutoyo" and not is_foreign:
                    failures.append((library.name(), error))
    if not failures and (foreign_format := containers.foreign(path, head)):
        raise foreign_format
    if failures and marked(head):
        candidate, reason = failures[0]
        has_number = isinstance(reason, OSError) and reason.errno is not None  # of the operating system
        cause = "it refers to a place outside the file" if has_number else brief(reason)
        raise refusal("damaged instrument file", format=candidate, cause=cause) from reason
    name = "film of high-speed AFM" if path.suffix.lower() == ".asd" else "unknown format"
    raise refusal(name) from (failures[0][1] if failures else None)


@contextmanager
def _silence() -> Iterator[None]:
    """Keep the library's warnings and log lines (whole byte arrays among them) off the screen."""
    previous_level = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with warnings.catch_warnings(action="ignore"), np.errstate(all="ignore"):
            yield
    finally:
        logging.disable(previous_level)


def _header(info: Any) -> Header:
    """Return the file's own header, which the library stores with a channel."""
    return info.info.get("raw_metadata") or {}


def _open(reader: Any, file_format: Format, path: Path) -> MeasuredFile:
    """Return the content of a file as read by the library."""
    from SurfaceTopography.Exceptions import FileFormatMismatch

    infos, rules = reader.channels, file_format.rules
    if not infos and file_format.marks != containers.TIFF:
        raise InputFileError(f"this {reader.name()} file holds no map")
    if not infos or not rules.is_plausible(_header(infos[0])):  # a picture, or bytes of something else
        raise FileFormatMismatch
    notes = rules.corrected(infos, path)
    # Heights are read once here: an incomplete channel shows that the file was cut off.
    channels = [_channel(info, file_format) for info in infos]
    header = _header(infos[0])
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        expected_size = rules.size(data, header, int(np.prod(infos[0].nb_grid_pts)))
        stale, beyond = rules.contradiction(data, header), rules.instrument(data)
    facts = beyond | _instrument(infos[0], file_format)
    return MeasuredFile(reader.name(), channels, "top", facts, notes, stale, expected_size, header=header)


def _channel(info: Any, file_format: Format) -> Channel:
    """Return one channel of a file, with its heights already read."""
    from SurfaceTopography.Exceptions import CorruptFile

    shape = (1, info.nb_grid_pts[0]) if len(info.nb_grid_pts) == 1 else tuple(info.nb_grid_pts[::-1])
    check_points(shape)
    lateral_unit, unit, no_height = _units(info)
    name = info.channel_id
    channel = Channel(name, shape, unreadable(""), unit, lateral_unit=lateral_unit, no_height=no_height)
    try:
        topography = info.topography()
        values = topography.heights()
    except CorruptFile as error:
        raise InputFileError(f"channel {name!r} is incomplete: the file was cut off") from error
    except (ImportError, MemoryError):
        raise
    except Exception as error:
        reason = f"channel {name!r} cannot be read ({brief(error)})"
        if not no_height:
            raise InputFileError(reason) from error
        return replace(channel, read=unreadable(reason))
    if isinstance(topography.unit, str):  # the library converts steps and heights to one unit
        channel.lateral_unit = topography.unit
        channel.height_unit = topography.unit if is_length(unit) else unit
    if not topography.is_uniform:
        uneven = "the positions along x are not evenly spaced"
        return scattered(channel, topography.positions(), None, values, uneven)
    heights = as_heights(values.T)
    header, rules = _header(info), file_format.rules
    heights[rules.not_measured(header, heights)] = np.nan
    if info.physical_sizes is not None:
        steps = np.asarray(topography.physical_sizes, dtype=float) / np.asarray(topography.nb_grid_pts)
        channel.dx, channel.dy = [*map(float, rules.steps(header, steps)), None][:2]  # a profile has one
    return replace(channel, read=lambda: heights, notes=[INVERTED] if rules.is_inverted(header) else [])


def _units(info: Any) -> tuple[str | None, str | None, str]:
    """Return the lateral unit of a channel, that of its values, and why they are not heights."""
    # (lateral unit, unit of the values) where they differ; some readers give the first for both
    differ = isinstance(info.unit, tuple)
    lateral_unit, unit = info.unit if differ else (info.unit, info.data_unit)
    if differ or not info.is_height_channel or (unit is not None and not is_length(unit)):
        unit = unit or "no unit"
        return lateral_unit, unit, f"values in {unit}, no length"
    return lateral_unit, unit, "by its name no topography" if NO_TOPOGRAPHY.search(info.name) else ""


def _instrument(info: Any, file_format: Format) -> dict[str, Any]:
    """Return what the library knows of the instrument: vendor, name, serial number, date and the like."""
    facts = {"vendor": file_format.vendor, **(info.info.get("instrument") or {})}
    facts |= {key: info.info[key] for key in ("acquisition_time", "comment") if info.info.get(key)}
    return facts | {"kind": file_format.kind.name}


#: Makes a reader, by the way in which it recognises files.
instrument_reader = partial(Reader, read=read_instrument, memory_per_byte=_BYTES_PER_BYTE, binary=True)
