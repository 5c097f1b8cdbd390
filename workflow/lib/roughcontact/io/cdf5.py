"""Check of the header of netCDF's variant CDF-5, in which the netCDF library trusts every count."""

from collections.abc import Callable
from math import prod
from pathlib import Path
from typing import BinaryIO, NoReturn

from roughcontact.errors import InputFileError

MARK = b"CDF\x05"
# type -> bytes per value
_BYTES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 4, 6: 8, 7: 1, 8: 2, 9: 4, 10: 8, 11: 8}
_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12
_MOST_AXES = 1024
_STREAMING = 2**64 - 1  # number of records: as many as the file holds


def check_header(path: Path) -> None:
    """Refuse a file with `MARK` whose header claims more entries than the file holds, or data outside it.

    References
    ----------
    Unidata, The NetCDF Classic Format Specification, appendix B of the NetCDF User's Guide.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        _Header(stream, size, path).check()


class _Header:
    """A header, read from its beginning to its end."""

    def __init__(self, stream: BinaryIO, size: int, path: Path) -> None:
        self.stream, self.size, self.path = stream, size, path
        self.stream.seek(len(MARK))

    def refuse(self, why: str) -> NoReturn:
        """Raise the error for an incomplete file."""
        raise InputFileError(f"{self.path}: damaged or cut off netCDF file ({why})")

    def number(self, length: int = 8) -> int:
        """Return the next number, big-endian."""
        data = self.stream.read(length)
        if len(data) < length:
            self.refuse("its header is not whole")
        return int.from_bytes(data, "big")

    def skip(self, length: int) -> None:
        """Skip so many bytes and the padding to a multiple of four."""
        length += -length % 4
        if length > self.size - self.stream.tell():
            self.refuse("its header counts more than the file has")
        self.stream.seek(length, 1)

    def entries(self, tag: int, read: Callable[[], None]) -> None:
        """Read a list; each entry has more than eight bytes."""
        found, count = self.number(4), self.number()
        if found not in (tag, 0) or (found == 0 and count) or count > self.size // 8:
            self.refuse("its header has no list where one is due")
        for _ in range(count):
            read()

    def attribute(self) -> None:
        """Skip an attribute."""
        self.skip(self.number())
        kind, count = self.number(4), self.number()
        if kind not in _BYTES:
            self.refuse("an attribute has an unknown type")
        self.skip(_BYTES[kind] * count)

    def check(self) -> None:
        """Read the header, and check that all data lie within the file."""
        records = self.number()
        lengths: list[int] = []
        placed: list[tuple[int, int, bool]] = []

        def dimension() -> None:
            self.skip(self.number())
            lengths.append(self.number())

        def variable() -> None:
            self.skip(self.number())
            count = self.number()
            if count > _MOST_AXES:
                self.refuse("a variable has too many axes")
            axes = [self.number() for _ in range(count)]
            if any(axis >= len(lengths) for axis in axes):
                self.refuse("a variable has an axis that does not exist")
            self.entries(_ATTRIBUTES, self.attribute)
            kind, _, begin = self.number(4), self.number(), self.number()
            if kind not in _BYTES:
                self.refuse("a variable has an unknown type")
            sizes = [lengths[axis] for axis in axes]
            recorded = bool(sizes) and sizes[0] == 0
            placed.append((begin, _BYTES[kind] * prod(sizes[1:] if recorded else sizes), recorded))

        self.entries(_DIMENSIONS, dimension)
        self.entries(_ATTRIBUTES, self.attribute)
        self.entries(_VARIABLES, variable)
        alone = sum(recorded for *_, recorded in placed) == 1
        step = sum(length + (0 if alone else -length % 4) for _, length, recorded in placed if recorded)
        count = 0 if records == _STREAMING else records
        for begin, length, recorded in placed:
            end = begin + ((count - 1) * step + length if recorded and count else 0 if recorded else length)
            if end > self.size:
                self.refuse("numbers lie behind the end of the file")
