"""Files made to hang a reader, to fill the memory or to bring in other files; each is written by code."""

import io
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import h5py
import netCDF4
import numpy as np
import x3pio

HEIGHTS = 1e-7 * np.random.default_rng(0).standard_normal((16, 16))


def _hdf5(change: Callable[[h5py.File], None], *, beside_a_map: bool = True) -> Callable[[Path], None]:
    """Return what writes an HDF5 file, a good map in it or not."""

    def write(path: Path) -> None:
        with h5py.File(path, "w") as file:
            if beside_a_map:
                file["height"] = HEIGHTS
                file["height"].attrs["units"] = "m"
            change(file)

    return write


def _netcdf(change: Callable[[netCDF4.Dataset], None]) -> Callable[[Path], None]:
    """Return what writes a netCDF file."""

    def write(path: Path) -> None:
        with netCDF4.Dataset(path, "w") as file:
            change(file)

    return write


def _bytes(*pieces: bytes) -> Callable[[Path], None]:
    """Return what writes a file of these bytes."""

    def write(path: Path) -> None:
        with path.open("wb") as stream:
            for piece in pieces:
                stream.write(piece)

    return write


def _archive(**members: list[bytes]) -> Callable[[Path], None]:
    """Return what writes an X3P archive with other members."""

    def write(path: Path) -> None:
        stream = io.BytesIO()
        x3pio.write(stream, HEIGHTS, x_scale=1e-6, y_scale=1e-6)
        with zipfile.ZipFile(stream) as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
            for name in old.namelist():
                with new.open(name, "w") as member:
                    for piece in members.pop(name.replace(".", "_"), [old.read(name)]):
                        member.write(piece)
            for name, pieces in members.items():
                with new.open(name, "w") as member:
                    for piece in pieces:
                        member.write(piece)

    return write


def _good_map(file: netCDF4.Dataset) -> netCDF4.Variable:
    for axis in ("y", "x"):
        file.createDimension(axis, 16)
        coordinate = file.createVariable(axis, "f8", (axis,))
        coordinate.units = "m"
        coordinate[:] = 1e-6 * np.arange(16)
    variable = file.createVariable("height", "f8", ("y", "x"))
    variable.units = "m"
    variable[:] = HEIGHTS
    return variable


def _long_coordinate(file: netCDF4.Dataset) -> None:
    file.createDimension("x", 10**10)
    for name in ("x", "z"):
        file.createVariable(name, "f8", ("x",), chunksizes=(1024,))


def _long_coordinates(file: netCDF4.Dataset) -> None:
    _good_map(file)
    for number in range(20):
        file.createDimension(f"d{number}", 10**8)
        file.createVariable(f"d{number}", "f8", (f"d{number}",), chunksizes=(10**5,), zlib=True)


def _unread_variables(file: netCDF4.Dataset) -> None:
    _good_map(file)
    file.createDimension("high", 11585)
    file.createDimension("wide", 11585)
    for number in range(6):
        file.createVariable(f"z{number}", "f8", ("high", "wide"), chunksizes=(64, 64)).units = "m"


def _brackets(file: netCDF4.Dataset) -> None:
    _good_map(file).instrument = "[" * 200_000


def _circle(file: h5py.File) -> None:
    file.create_group("a")["b"] = file["/"]


def _circle_of_names(file: h5py.File) -> None:
    file.create_group("a")["b"] = h5py.SoftLink("/")


def _doubled(file: h5py.File) -> None:
    group = file.create_group("g0")
    for number in range(40):
        inner = file.create_group(f"g{number + 1}")
        group["left"] = group["right"] = inner
        group = inner


def _deep(file: h5py.File) -> None:
    group = file
    for _ in range(5000):
        group = group.create_group("g")


def _outside_storage(file: h5py.File) -> None:
    file.create_dataset("z", (16, 16), "u1", external=[("/etc/passwd", 0, 256)])


def _outside_link(file: h5py.File) -> None:
    file.create_group("deep/deeper")["z"] = h5py.ExternalLink("/etc/passwd", "/z")


def _outside_array(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((16, 16), "f8")
    layout[:] = h5py.VirtualSource("/etc/passwd", "z", (16, 16))
    file.create_virtual_dataset("z", layout)


def _tiff(following: int) -> bytes:
    tags = [(256, 4, 1, 4), (257, 4, 1, 4), (273, 4, 1, 200), (279, 4, 1, 16)]
    page = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags)
    return (b"II*\0" + struct.pack("<I", 8) + page + struct.pack("<I", following)).ljust(300, b"\0")


def _objects(path: Path) -> None:
    """Write a NumPy array of Python objects, which only running code of the file could read."""
    with path.open("wb") as stream:
        np.save(stream, np.array([{"a": 1}], dtype=object))


def _packed_matrix(path: Path, size: int) -> None:
    """Write a MATLAB file of one compressed variable that unpacks to so many bytes."""
    packer = zlib.compressobj(9)
    packed = b"".join(packer.compress(bytes(2**20)) for _ in range(size // 2**20)) + packer.flush()
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H2s", 0x0100, b"IM")
    path.write_bytes(head + struct.pack("<2I", 15, len(packed)) + packed)


def _sparse(path: Path, size: int) -> None:
    """Write a file with a hole of so many bytes."""
    with path.open("wb") as stream:
        stream.truncate(size)


_ROWS = b"1 2 3 4\n" * 5
_BLANKS = [b" " * 2**20] * 250
_BOMB = b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;&x;">]><a>&y;</a>'


# name -> what writes the file, and whether it shall be refused (else: a map or a refusal)
def _cdf5(*, attributes: int = 0, axes: int = 0) -> bytes:
    """Return a CDF-5 file of one variable whose header counts more than it has."""
    name = (1).to_bytes(8, "big") + b"z\0\0\0"
    listed = (12).to_bytes(4, "big") + attributes.to_bytes(8, "big") if attributes else bytes(12)
    variable = name + axes.to_bytes(8, "big") + listed + (6).to_bytes(4, "big") + bytes(16)
    variables = (11).to_bytes(4, "big") + (1).to_bytes(8, "big") + variable
    return b"CDF\x05" + bytes(8) + bytes(12) + bytes(12) + variables + bytes(1000)


FILES: dict[str, tuple[Callable[[Path], None], bool]] = {
    "text: blanks in a header": (_bytes(b"width(->" + b" " * 100_000 + b"x: 3\n", _ROWS), False),
    "text: 300 000 letters": (_bytes(b"a" * 300_000 + b"\n", _ROWS), False),
    "text: blanks between two letters": (_bytes(b"a" + b" " * 300_000 + b"b\n", _ROWS), False),
    "text: signs of equality": (_bytes(b"a=" * 150_000 + b"\n", _ROWS), False),
    "text: 50 000 headings": (_bytes(b"a,b\n" * 50_000, _ROWS), False),
    "text: brackets": (_bytes(b"[" * 300_000 + b"\n", _ROWS), False),
    "text: 5 MB of empty lines": (_bytes(b"\n" * 5_000_000, _ROWS), False),
    "text: 20 MB in one line": (_bytes(b"1 " * 10_000_000), False),
    "text: a header without an end": (_bytes(b"so it goes\n" * 400_000), True),
    "TIFF: a page that is its own next one": (_bytes(_tiff(8)), True),
    "TIFF: a page outside the file": (_bytes(_tiff(10**8)), True),
    "netCDF: a coordinate of 10¹⁰ points": (_netcdf(_long_coordinate), True),
    "netCDF: 20 coordinates of 10⁸ points": (_netcdf(_long_coordinates), True),
    "netCDF: six variables of 11 585²": (_netcdf(_unread_variables), False),
    "netCDF: 200 000 brackets in an attribute": (_netcdf(_brackets), False),
    "netCDF: 2³⁰ axes of a variable (CDF-5)": (_bytes(_cdf5(axes=2**30)), True),
    "netCDF: 2⁶⁰ attributes (CDF-5)": (_bytes(_cdf5(attributes=2**60)), True),
    "HDF5: a group that contains itself": (_hdf5(_circle), True),
    "HDF5: a link in a circle": (_hdf5(_circle_of_names), True),
    "HDF5: groups doubled 40 times": (_hdf5(_doubled), True),
    "HDF5: 5000 groups deep": (_hdf5(_deep), True),
    "HDF5: external storage": (_hdf5(_outside_storage), True),
    "HDF5: link into another file": (_hdf5(_outside_link), True),
    "HDF5: virtual array": (_hdf5(_outside_array, beside_a_map=False), True),
    "X3P: entities": (_archive(main_xml=[_BOMB]), True),
    "X3P: 250 MB of blanks": (_archive(main_xml=[*_BLANKS, b"<a/>"]), True),
    "X3P: a name that leads out of the archive": (_archive(**{"../../outside": [b"no"]}), False),
    "X3P: 50 000 members": (_archive(**{f"m{number}": [b""] for number in range(50_000)}), False),
    "MAT: 2 GB packed": (lambda path: _packed_matrix(path, 2 * 2**30), True),
    "NumPy: Python objects": (_objects, True),
    "4 GiB of nothing": (lambda path: _sparse(path, 2**32 + 1), True),
}
