"""Safe opening of HDF5 containers: data in other files are refused, and no number is read here."""

import mmap
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from roughcontact.io.guards import refusal, refusing

MARK = b"\x89HDF\r\n\x1a\n"
_HEAP = b"GCOL\x01\0\0\0"
_HEAP_HEAD = 16  # bytes; of a heap and of each of its objects
_MAX_HEAP_OBJECTS = 1_000_000
_MAX_OBJECTS = 10_000
_MAX_DEPTH = 32  # nested groups; the netCDF library is recursive


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Open an HDF5 file for reading.

    A file that is damaged or cut off is refused, also where that shows only within the block.
    """
    import h5py

    with refusing("damaged or cut off HDF5 file"), h5py.File(path, "r") as file:
        yield file


def holds(path: Path, head: bytes, is_kind: Callable[[Any], bool]) -> bool:
    """Return whether a file that begins with `head` is HDF5 of some kind."""
    if not head.startswith(MARK):
        return False
    with opened(path) as file:
        return is_kind(file)


def stated_size(path: Path) -> int | None:
    """Return the bytes of a file by its superblock (HDF5 File Format Specification 3.0, II.A), or None."""
    with path.open("rb") as stream:
        head = stream.read(64)
    version = head[8] if len(head) == 64 else -1
    # the address of the end of the file is the third one, behind so many bytes by version
    offset = {0: 24, 1: 28, 2: 12, 3: 12}.get(version)
    if offset is None or head[13 if version < 2 else 9] != 8:  # bytes of an address
        return None
    base, _, end_of_file = struct.unpack_from("<3Q", head, offset)
    return end_of_file if base == 0 else None


def datasets(path: Path) -> dict[str, tuple[int, ...]]:
    """Return the shapes of all arrays of a file by full name, and refuse links and data outside the file."""
    # heights must not be bytes of other files of this computer
    _check_heaps(path)
    with opened(path) as file:
        return dict(_arrays(file))


def _check_heaps(path: Path) -> None:
    """Refuse a heap (of values of any length) with free space of zero bytes: the library would loop.

    A heap has a mark, a version, its size, then objects: a number (0 for the free space), a count, a size.
    """
    # of all heaps: each may be small, and there may be millions
    remaining = _MAX_HEAP_OBJECTS
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        start = data.find(_HEAP)
        while start >= 0:
            offset = start + _HEAP_HEAD
            stop = start + int.from_bytes(data[start + len(_HEAP) : offset], "little")
            while offset + _HEAP_HEAD <= min(stop, len(data)):
                number, size = struct.unpack_from("<H6xQ", data, offset)
                remaining -= 1
                if remaining == 0 or (number == 0 and size == 0):
                    raise refusal("heap without end")
                offset += _HEAP_HEAD + size + -size % 8 if number else size
            start = data.find(_HEAP, start + 1)


def _arrays(file: Any) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Yield name and shape of every array; groups found twice are refused, as they may form a loop."""
    import h5py

    groups: list[tuple[Any, int]] = [(file, 0)]
    addresses = {h5py.h5o.get_info(file.id).addr}
    while groups:
        group, depth = groups.pop()
        for name in group:
            link, full_name = group.get(name, getlink=True), f"{group.name.rstrip('/')}/{name}"
            if isinstance(link, h5py.ExternalLink):
                raise refusal("outside", what=f"{full_name} is a link into another file")
            try:
                entry = group[name]
            except (KeyError, OSError, RuntimeError):
                if isinstance(link, h5py.SoftLink):  # a dangling link
                    continue
                raise
            address = h5py.h5o.get_info(entry.id).addr
            if isinstance(entry, h5py.Group) and (address in addresses or depth == _MAX_DEPTH):
                raise refusal("groups without end", name=full_name, depth=_MAX_DEPTH)
            if address in addresses:
                continue
            addresses.add(address)
            if len(addresses) > _MAX_OBJECTS:
                raise refusal("many objects", limit=_MAX_OBJECTS)
            if isinstance(entry, h5py.Group):
                groups.append((entry, depth + 1))
            elif isinstance(entry, h5py.Dataset):
                _check_array(entry)
                yield entry.name, entry.shape or ()


def _check_array(array: Any) -> None:
    """Refuse an array whose numbers lie in other files, and one on which the netCDF library crashes."""
    import h5py

    if array.external:
        raise refusal("outside", what=f"the numbers of {array.name} lie in another file")
    if array.is_virtual:
        raise refusal("outside", what=f"{array.name} is put together from other files")
    if array.shape == () and h5py.h5ds.is_scale(array.id):
        raise refusal("scale of one number", name=array.name)
