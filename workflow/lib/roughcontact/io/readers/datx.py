"""Zygo's DATX: HDF5 with a group MetaData, read through SurfaceTopography."""

from pathlib import Path

from roughcontact.io import hdf5
from roughcontact.io.channels import MeasuredFile
from roughcontact.io.instruments.formats import marked
from roughcontact.io.instruments.library import BYTES_PER_BYTE, read_as
from roughcontact.io.interface import Reader, RecognisedBy, head_of


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is HDF5 with the group that Zygo's have."""
    if not head.startswith(hdf5.MARK):
        return False
    with hdf5.opened(path) as file:
        return "MetaData" in file


def read(path: Path) -> MeasuredFile:
    """Open a file with SurfaceTopography."""
    hdf5.datasets(path)
    return read_as(path, marked(head_of(path)))


READER = Reader(RecognisedBy.CONTENTS, recognises, read, memory_per_byte=BYTES_PER_BYTE, binary=True)
