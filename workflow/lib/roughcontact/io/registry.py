"""Choice of the reader for a file, by its content, never by its name."""

from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from roughcontact.io import guards
from roughcontact.io.channels import MeasuredFile
from roughcontact.io.interface import Reader, read_head

_READERS = "roughcontact.io.readers"


def readers() -> list[tuple[str, Reader]]:
    """Return readers and names of their modules in the folder `readers`, by `RecognisedBy`, then by name.

    Examples
    --------
    >>> readers()[-1][0]  # takes what no other knows
    'unmarked'
    """
    names = sorted(module.name for module in iter_modules(import_module(_READERS).__path__))
    entries = [(name, import_module(f"{_READERS}.{name}").READER) for name in names]
    return sorted(entries, key=lambda entry: entry[1].recognised_by)


def recognised(path: Path) -> tuple[str, Reader]:
    """Return the reader that recognises a file (the last takes every file), and the name of its module."""
    head = read_head(path)
    return next((name, reader) for name, reader in readers() if reader.recognises(path, head))


def open_file(path: Path) -> MeasuredFile:
    """Open a measured file of any format, checked and recognised; its channels are in its own units."""
    with guards.naming(path):
        # before any reader: it has to be safe to open the file at all
        guards.check_file(path)
        reader, size = recognised(path)[1], path.stat().st_size
        guards.check_memory(size * reader.memory_per_byte, f"{size} bytes of this format")
        if reader.binary:
            guards.check_line_ends(path)
        file = reader.read(path)
        for channel in file.channels:
            # the shape of a doubtful channel is that of its points, or none
            if not channel.doubt:
                guards.check_points(channel.shape)
        # a wrong checksum already says that the file is not as it was written
        if file.required_size is not None and not file.stale:
            file.stale, notes = guards.compare_size(path, file.required_size)
            file.warnings += notes
    return file
