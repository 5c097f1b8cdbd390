"""Check of the header of netCDF's classic formats (CDF-1, CDF-2, CDF-5) against itself and the file.

The netCDF library trusts every count of CDF-5, and reads zeros where a classic file was cut off.
"""

from collections.abc import Iterator
from math import prod
from pathlib import Path
from typing import BinaryIO

from roughcontact.io.guards import refusing

# mark -> bytes of a count, bytes of a position
_WIDTHS = {b"CDF\x01": (4, 4), b"CDF\x02": (4, 8), b"CDF\x05": (8, 8)}
MARKS = tuple(_WIDTHS)
# type -> bytes per value
_BYTES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 4, 6: 8, 7: 1, 8: 2, 9: 4, 10: 8, 11: 8}
_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12
_MAX_AXES = 1024


def check_header(path: Path) -> int | None:
    """Refuse a netCDF classic file whose header contradicts itself; return its size (bytes), None if open.

    The NetCDF Classic Format Specification, appendix B of the NetCDF User's Guide (Unidata); the lists, axes
    and sizes of variables are checked, and that they lie in the file.
    """
    with refusing("damaged or cut off netCDF file"), path.open("rb") as stream:
        return _stated_size(_Header(stream, path.stat().st_size))


class _Header:
    """A header, read from its beginning to its end."""

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self.stream, self.size = stream, size
        self.count, self.position = _WIDTHS[stream.read(4)]

    def number(self, length: int = 0) -> int:
        """Return the next number, big-endian; without a length, a count."""
        length = length or self.count
        data = self.stream.read(length)
        _require(len(data) == length, "its header is not whole")
        return int.from_bytes(data, "big")

    def skip(self, length: int) -> None:
        """Skip so many bytes and the padding to a multiple of four."""
        length += -length % 4
        _require(length <= self.size - self.stream.tell(), "its header counts more than the file has")
        self.stream.seek(length, 1)

    def entries(self, tag: int) -> Iterator[int]:
        """Yield the numbers of the entries of a list, behind their names; each has at least eight bytes."""
        list_tag, count = self.number(4), self.number()
        is_list = list_tag == tag or (list_tag == 0 and not count)
        _require(is_list and count <= self.size // 8, "its header has no list where one is due")
        for index in range(count):
            self.skip(self.number())  # the name
            yield index

    def value_bytes(self) -> int:
        """Return the bytes of a value of the next type."""
        number_type = self.number(4)
        _require(number_type in _BYTES, "a variable or an attribute has an unknown type")
        return _BYTES[number_type]

    def skip_attributes(self) -> None:
        """Skip a list of attributes."""
        for _ in self.entries(_ATTRIBUTES):
            self.skip(self.value_bytes() * self.number())


def _require(condition: bool, why: str) -> None:
    """Raise the error for a damaged file."""
    if not condition:
        raise ValueError(why)


def _stated_size(header: _Header) -> int | None:
    """Check a header, and return the size of the file that it describes."""
    records = header.number()
    lengths = [header.number() for _ in header.entries(_DIMENSIONS)]
    header.skip_attributes()
    largest = 256**header.count - 4  # larger ones state nothing
    fixed_sizes: list[tuple[int, int]] = []  # where a variable begins, and its bytes
    record_sizes: list[tuple[int, int]] = []  # the same of its first record
    for _ in header.entries(_VARIABLES):
        count = header.number()
        _require(count <= _MAX_AXES, "a variable has too many axes")
        axes = [header.number() for _ in range(count)]
        _require(all(axis < len(lengths) for axis in axes), "a variable has an axis that does not exist")
        header.skip_attributes()
        sizes = [lengths[axis] for axis in axes]
        has_records = sizes[:1] == [0]
        length = header.value_bytes() * prod(sizes[has_records:])
        header_size, padded_size = header.number(), length + -length % 4
        agrees = header_size in (padded_size, length) or padded_size > largest
        _require(agrees, f"a variable of {length} bytes is said to have {header_size}")
        (record_sizes if has_records else fixed_sizes).append((header.number(header.position), length))
    streaming = records == 256**header.count - 1
    # the records of a single variable are not padded (the specification's exception)
    step = sum(length + -length % (4 if len(record_sizes) > 1 else 1) for _, length in record_sizes)
    has_last = records and not streaming
    last = [(start + step * (records - 1), length) for start, length in record_sizes if has_last]
    stop = max([header.stream.tell(), *map(sum, fixed_sizes + last)])
    _require(stop <= header.size, "numbers lie behind the end of the file")
    return None if streaming and record_sizes else min(stop + -stop % 4, header.size)
