"""Zygo's DATX: HDF5 with a group MetaData, read through SurfaceTopography."""

from pathlib import Path

from roughcontact.errors import InputFileError
from roughcontact.io.channels import MeasuredFile
from roughcontact.io.guards import brief
from roughcontact.io.instruments.formats import marked
from roughcontact.io.instruments.library import read_as
from roughcontact.io.interface import Reader, ToldBy, head_of

_HDF5 = b"\x89HDF\r\n\x1a\n"


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file is HDF5 with the group that Zygo's have.

    Raises
    ------
    InputFileError
        For an HDF5 file that cannot be opened, whoever wrote it.
    """
    if not head.startswith(_HDF5):
        return False
    import h5py

    try:
        with h5py.File(path) as file:
            return "MetaData" in file
    except OSError as error:
        raise InputFileError(f"{path}: damaged or cut off HDF5 file ({brief(error)})") from error


def read(path: Path) -> MeasuredFile:
    """Open a file with SurfaceTopography.

    Parameters
    ----------
    path : Path

    Returns
    -------
    MeasuredFile

    Raises
    ------
    InputFileError
        For a file that is damaged, cut off, or holds no map.
    """
    return read_as(path, marked(head_of(path)))


READER = Reader(ToldBy.CONTENTS, recognises, read)
