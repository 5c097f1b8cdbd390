"""Check of the header of netCDF's classic formats (CDF-1, CDF-2, CDF-5) against itself and the file.

The netCDF library trusts every count of CDF-5, and reads zeros where a classic file was cut off.
"""

from collections.abc import Callable
from math import prod
from pathlib import Path
from typing import BinaryIO, NamedTuple, NoReturn

from roughcontact.errors import InputFileError

# mark -> bytes of a count, bytes of a position
_WIDTHS = {b"CDF\x01": (4, 4), b"CDF\x02": (4, 8), b"CDF\x05": (8, 8)}
MARKS = tuple(_WIDTHS)
# type -> bytes per value
_BYTES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 4, 6: 8, 7: 1, 8: 2, 9: 4, 10: 8, 11: 8}
_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12
_MOST_AXES = 1024


class _Placed(NamedTuple):
    """One variable: where it begins, its bytes (those of one record), its stated bytes, and of what kind."""

    begin: int
    length: int
    stated: int
    recorded: bool


def check_header(path: Path) -> int | None:
    """Refuse a file with one of `MARKS` whose header contradicts itself or counts more than the file holds.

    Checked are the lists, the axes of the variables, their stated sizes against their axes, and that they lie
    in the file.

    The result is the size of the file by its header, bytes; None where the number of records is left open.

    References
    ----------
    Unidata, The NetCDF Classic Format Specification, appendix B of the NetCDF User's Guide.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        return _Header(stream, size, path).check()


class _Header:
    """A header, read from its beginning to its end."""

    def __init__(self, stream: BinaryIO, size: int, path: Path) -> None:
        self.stream, self.size, self.path = stream, size, path
        self.count, self.position = _WIDTHS[stream.read(4)]

    def refuse(self, why: str) -> NoReturn:
        """Raise the error for a damaged file."""
        raise InputFileError(f"{self.path}: damaged or cut off netCDF file ({why})")

    def number(self, length: int = 0) -> int:
        """Return the next number, big-endian; without a length, a count."""
        length = length or self.count
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
        """Read a list; each entry has at least eight bytes."""
        list_tag, count = self.number(4), self.number()
        if list_tag not in (tag, 0) or (list_tag == 0 and count) or count > self.size // 8:
            self.refuse("its header has no list where one is due")
        for _ in range(count):
            read()

    def attribute(self) -> None:
        """Skip an attribute."""
        self.skip(self.number())
        number_type, count = self.number(4), self.number()
        if number_type not in _BYTES:
            self.refuse("an attribute has an unknown type")
        self.skip(_BYTES[number_type] * count)

    def check(self) -> int | None:
        """Read the header, check it, and return the size of the file that it describes."""
        records = self.number()
        lengths: list[int] = []
        placed: list[_Placed] = []

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
            number_type, stated, begin = self.number(4), self.number(), self.number(self.position)
            if number_type not in _BYTES:
                self.refuse("a variable has an unknown type")
            sizes = [lengths[axis] for axis in axes]
            recorded = bool(sizes) and sizes[0] == 0
            placed.append(
                _Placed(begin, _BYTES[number_type] * prod(sizes[1:] if recorded else sizes), stated, recorded)
            )

        self.entries(_DIMENSIONS, dimension)
        self.entries(_ATTRIBUTES, self.attribute)
        self.entries(_VARIABLES, variable)
        streaming = records == 256**self.count - 1
        required_size = self.place(placed, 0 if streaming else records)
        return (
            None
            if streaming and any(placed_variable.recorded for placed_variable in placed)
            else required_size
        )

    def place(self, placed: list[_Placed], records: int) -> int:
        """Check where the variables lie, and return the end of the last one."""
        largest = 256**self.count - 4  # larger ones state nothing
        for variable in placed:
            padded = variable.length + -variable.length % 4
            if variable.stated not in (padded, variable.length) and padded <= largest:
                self.refuse(f"a variable of {variable.length} bytes is said to have {variable.stated}")
        alone = sum(variable.recorded for variable in placed) == 1
        step = sum(
            variable.length + (0 if alone else -variable.length % 4)
            for variable in placed
            if variable.recorded
        )
        stored = [variable for variable in placed if records or not variable.recorded]
        ends = (
            variable.begin + variable.length + (step * (records - 1) if variable.recorded else 0)
            for variable in stored
        )
        end = max([self.stream.tell(), *ends])
        if end > self.size:
            self.refuse("numbers lie behind the end of the file")
        return min(end + -end % 4, self.size)
