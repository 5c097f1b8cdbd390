"""Which reader knows a file: told by its content, never by its name."""

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from roughcontact.io.channels import MeasuredFile
from roughcontact.io.guards import check_archive, check_file
from roughcontact.io.interface import Reader, head_of

_READERS = "roughcontact.io.readers"


def readers() -> list[tuple[str, Reader]]:
    """Return the readers and the names of their modules, in the order in which they are asked.

    Every module of the folder `readers` is one. The order is that of `roughcontact.io.interface.ToldBy`,
    which gives the reasons, and alphabetical where readers are told in the same way.

    Returns
    -------
    list of (str, Reader)

    Examples
    --------
    >>> readers()[-1][0]  # takes what no other knows
    'unmarked'
    """
    package = import_module(_READERS)
    names = sorted(module.name for module in iter_modules(package.__path__))
    found = [(name, import_module(f"{_READERS}.{name}").READER) for name in names]
    return sorted(found, key=lambda named: named[1].told_by)


def recognised(path: Path) -> tuple[str, Reader]:
    """Return the reader that knows a file, and the name of its module.

    Parameters
    ----------
    path : Path
        A file that `check_file` and `check_archive` let through.

    Returns
    -------
    tuple of str and Reader
        The last of the readers takes what no other knows, and refuses it where it cannot read it either.

    Raises
    ------
    InputFileError
        A container (HDF5) that is damaged beyond recognition.
    """
    head = head_of(path)
    return next((name, reader) for name, reader in readers() if reader.recognises(path, head))


def open_file(path: Path) -> MeasuredFile:
    """Open a measured file of any format: check what it is, recognise it, and read its channels.

    Returns
    -------
    MeasuredFile
        The channels as they lie in the file, in its own units.

    Raises
    ------
    InputFileError
        A file that is missing, damaged, cut off, hostile, too large, or of unknown format.
    """
    check_file(path)
    check_archive(path)
    _, reader = recognised(path)
    return reader.read(path)
