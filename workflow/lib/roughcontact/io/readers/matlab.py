"""MATLAB's MAT files of version 5 to 7: each real matrix is a channel, without steps and units.

Row j is the j-th y; row 0 is the lowest line.
"""

import io
import zlib
from collections.abc import Callable, Iterator
from functools import cache, partial
from math import prod
from pathlib import Path
from typing import Literal

import numpy as np

from roughcontact.io.channels import Channel, MeasuredFile, as_heights, counted_channels, oversized
from roughcontact.io.guards import MAX_POINTS, MAX_UNPACKED_BYTES, refusal, refuse_more, refusing
from roughcontact.io.interface import Reader, RecognisedBy, begins_with
from roughcontact.io.text.axes import refuse_points

_MARK = b"MATLAB 5.0 MAT-file"
_HEADER_BYTES = 128
_FIRST = ("height", "heights", "z")
_MATRIX, _COMPRESSED = 14, 15  # types of a variable
_NUMBERS = ("double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64")


def read(path: Path) -> MeasuredFile:
    """Open a file with a channel for each matrix, vector or page; only names and sizes are read."""
    from scipy.io import whosmat

    with refusing("damaged or cut off MATLAB file"):
        ranges = [*_places(path)]
        variables = whosmat(str(path))
    channels = counted_channels(
        channel
        for byte_range, (name, shape, value_type) in zip(ranges, variables, strict=True)
        if value_type in _NUMBERS and len(shape) in (2, 3) and shape[0] * shape[1] > 1
        for channel in _channels(path, byte_range, name, shape)
    )
    if not channels:
        names = ", ".join(f"{name} ({value_type})" for name, _, value_type in variables[:8])
        raise refusal("no matrix of MATLAB", names=names or "nothing")
    # those named height, heights or z come first
    channels.sort(key=lambda channel: channel.name.lower().partition("(")[0] not in _FIRST)
    return MeasuredFile("MATLAB matrix", channels, first_row="bottom", first_row_assumed=True)


def _channels(path: Path, byte_range: slice, name: str, shape: tuple[int, ...]) -> Iterator[Channel]:
    """Yield the channels of a variable, one for each page, which are read from one copy of it."""
    ny, nx = (1, max(shape[:2])) if min(shape[:2]) == 1 else shape[:2]
    if prod(shape) > MAX_POINTS:
        yield oversized(name, shape)
        return
    load = cache(partial(_load, path, byte_range, name))
    for index in range(*shape[2:]) if len(shape) == 3 else [None]:
        label = name if index is None else f"{name}(:,:,{index + 1})"
        yield Channel(label, (ny, nx), partial(_read, load, (ny, nx), index))


def _load(path: Path, byte_range: slice, name: str) -> np.ndarray:
    """Return one variable, from its place in a file: to look for it would read all before it."""
    from scipy.io import loadmat

    with refusing(f"variable {name!r} is damaged"), path.open("rb") as stream:
        header = stream.read(_HEADER_BYTES)
        stream.seek(byte_range.start)
        variable_file = io.BytesIO(header + stream.read(byte_range.stop - byte_range.start))
        values = np.asarray(loadmat(variable_file, variable_names=[name])[name])
    refuse_points(values)
    return values


def _read(load: Callable[[], np.ndarray], shape: tuple[int, int], index: int | None) -> np.ndarray:
    """Return one variable, or one matrix of it."""
    values = load()
    return as_heights((values if index is None else values[:, :, index]).reshape(shape))


def _places(path: Path) -> Iterator[slice]:
    """Yield the bytes of each variable of a file.

    A file that was cut off, or whose variables, unpacked piece by piece, are more than 1 GiB, is refused.
    """
    total, size = 0, path.stat().st_size
    with path.open("rb") as stream:
        order: Literal["little", "big"] = "little" if stream.read(_HEADER_BYTES)[126:128] == b"IM" else "big"
        while len(tag := stream.read(8)) == 8:
            data_type, count = (int.from_bytes(field, order) for field in (tag[:4], tag[4:]))
            if data_type not in (_MATRIX, _COMPRESSED):
                raise refusal("no variable of MATLAB", place=stream.tell() - 8)
            byte_range = slice(stream.tell() - 8, stream.tell() + count)
            if byte_range.stop > size:
                raise refusal("cut MATLAB")
            yield byte_range
            if data_type != _COMPRESSED:
                stream.seek(count, 1)
                continue
            # unpacked in pieces that are thrown away: a few bytes may claim to be many gigabytes
            block, unpacker = stream.read(count), zlib.decompressobj()
            while block:
                total += len(unpacker.decompress(block, 2**20))
                block = unpacker.unconsumed_tail
                refuse_more(f"its variables unpack to {total} bytes", total, MAX_UNPACKED_BYTES)
        if tag:
            raise refusal("bytes behind MATLAB", count=len(tag))


READER = Reader(RecognisedBy.MARK, begins_with(_MARK), read)
