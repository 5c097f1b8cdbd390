"""MATLAB's MAT files of version 5 to 7: each real matrix is a channel, without steps and units.

Row j is the j-th y; row 0 is the lowest line.
"""

import zlib
from functools import partial
from math import prod
from pathlib import Path
from typing import Literal

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, MeasuredFile, as_heights, oversized
from roughcontact.io.guards import MAX_POINTS, MAX_UNPACKED_BYTES, refusing
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
        _check_unpacked_size(path)
        variables = whosmat(str(path))
    # those named height, heights or z come first
    channels = []
    for name, shape, value_type in variables:
        if value_type not in _NUMBERS or len(shape) not in (2, 3) or shape[0] * shape[1] < 2:
            continue
        ny, nx = (1, max(shape[:2])) if min(shape[:2]) == 1 else shape[:2]
        if prod(shape) > MAX_POINTS:
            channels.append(oversized(name, shape))
            continue
        for index in range(*shape[2:]) if len(shape) == 3 else [None]:
            label = name if index is None else f"{name}(:,:,{index + 1})"
            channels.append(Channel(label, (ny, nx), partial(_read, path, name, (ny, nx), index)))
    if not channels:
        listed = ", ".join(f"{name} ({value_type})" for name, _, value_type in variables[:8])
        raise InputFileError(f"no matrix of real numbers in this MATLAB file; it has {listed or 'nothing'}")
    channels.sort(key=lambda channel: channel.name.lower().partition("(")[0] not in _FIRST)
    return MeasuredFile("MATLAB matrix", channels, first_row="bottom", first_row_assumed=True)


def _read(path: Path, name: str, shape: tuple[int, int], index: int | None) -> np.ndarray:
    """Return one variable, or one matrix of it."""
    from scipy.io import loadmat

    with refusing(f"variable {name!r} is damaged"):
        values = np.asarray(loadmat(str(path), variable_names=[name])[name])
    refuse_points(values)
    return as_heights((values if index is None else values[:, :, index]).reshape(shape))


def _check_unpacked_size(path: Path) -> None:
    """Refuse a file that was cut off, or whose variables, unpacked piece by piece, are more than 1 GiB."""
    total, size = 0, path.stat().st_size
    with path.open("rb") as stream:
        order: Literal["little", "big"] = "little" if stream.read(_HEADER_BYTES)[126:128] == b"IM" else "big"
        while len(tag := stream.read(8)) == 8:
            data_type, count = (int.from_bytes(field, order) for field in (tag[:4], tag[4:]))
            if data_type not in (_MATRIX, _COMPRESSED):
                raise InputFileError(
                    f"damaged MATLAB file: no variable begins {stream.tell() - 8} bytes from its "
                    "beginning, where the one before ends; copy or save it again"
                )
            if stream.tell() + count > size:
                raise InputFileError("the last variable of this MATLAB file is not whole: it was cut off")
            if data_type != _COMPRESSED:
                stream.seek(count, 1)
                continue
            packed, unpacker = stream.read(count), zlib.decompressobj()
            while packed:
                total += len(unpacker.decompress(packed, 2**20))
                packed = unpacker.unconsumed_tail
                if total > MAX_UNPACKED_BYTES:
                    raise InputFileError(
                        f"its variables unpack to more than the {MAX_UNPACKED_BYTES} bytes allowed"
                    )
        if tag:
            raise InputFileError(
                f"damaged MATLAB file: {len(tag)} bytes follow its last variable; copy or save it again"
            )


READER = Reader(RecognisedBy.MARK, begins_with(_MARK), read)
