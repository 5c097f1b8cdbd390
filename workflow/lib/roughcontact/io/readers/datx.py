"""Zygo's DATX: HDF5 with a group MetaData, read through SurfaceTopography."""

from pathlib import Path

from roughcontact.io import hdf5
from roughcontact.io.instruments.library import instrument_reader
from roughcontact.io.interface import RecognisedBy


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is HDF5 with the group that Zygo's have."""
    return hdf5.holds(path, head, lambda file: "MetaData" in file)


READER = instrument_reader(RecognisedBy.CONTENTS, recognises)
