"""How readers are found, in which order they are asked, and what reading imports."""

import io
import subprocess
import sys

import h5py
import numpy as np
import pytest
import sdfio
import xarray as xr
from measured_files import GIVEN, archive, array, holds, refuses, saved, x3p

from roughcontact.io import readers as room
from roughcontact.io.interface import RecognisedBy, read_head
from roughcontact.io.registry import readers, recognised

HEIGHTS = np.arange(12.0).reshape(3, 4) * 1e-6

NEW_FORMAT = '''
"""Maps of another instrument: a mark, the number of columns, the heights in nanometres."""

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, MeasuredFile
from roughcontact.io.interface import Reader, RecognisedBy


def recognises(path, head):
    return head.startswith(b"ANOTHER\\0")


def read(path):
    data = path.read_bytes()
    columns = data[8]
    heights = np.frombuffer(data, "<f8", offset=9)
    if heights.size % columns:
        raise InputFileError(f"{path}: cut off")
    heights = heights.reshape(-1, columns)
    steps = {"dx": 2.0, "dy": 2.0, "lateral_unit": "um"}
    channel = Channel("height", heights.shape, heights.copy, height_unit="nm", **steps)
    return MeasuredFile("another", [channel], first_row="top")


READER = Reader(RecognisedBy.MARK, recognises, read)
'''


@pytest.fixture
def another_format(tmp_path, monkeypatch):
    """Add a format by one file in a folder that counts as part of `readers`."""
    folder = tmp_path / "more_readers"
    folder.mkdir()
    (folder / "another.py").write_text(NEW_FORMAT, encoding="utf-8")
    monkeypatch.setattr(room, "__path__", [*room.__path__, str(folder)])
    yield
    sys.modules.pop("roughcontact.io.readers.another", None)


def test_one_file_adds_a_format(read, refusal, another_format):
    data = b"ANOTHER\0" + bytes([4]) + (1e9 * HEIGHTS).tobytes()
    height = read(data, name="map.xyz")
    holds(height, HEIGHTS[::-1], 2e-6, 2e-6, rtol=1e-12)
    assert height.attrs["source_format"] == "another"
    refusal(data[:-8], "cut off", name="map.xyz")


def hdf5(*groups):
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        for group in groups:
            file.create_group(group)
    return stream.getvalue()


def sdf(file_format):
    stream = io.BytesIO()
    sdfio.write(stream, HEIGHTS, x_scale=1e-6, y_scale=1e-6, format=file_format)
    return stream.getvalue()


TEXT = b"\n1.5 2.5 3.5\n4.5 5.5 7.5\n"
BINARY = bytes(range(256))
# content of a file, and the readers that claim it, the first of which reads it
FILES = {
    "X3P": (x3p(HEIGHTS), "x3p", "instruments"),
    "another archive": (archive({"index.xml": "<xml/>"}), "instruments"),
    "HDF5 of Zygo": (hdf5("MetaData"), "datx", "netcdf"),
    "other HDF5": (hdf5("Height"), "netcdf"),
    "HDF5 without the whole mark": (b"\x89HDF" + BINARY,),
    "netCDF": (b"CDF\x01" + BINARY, "netcdf"),
    "NumPy": (array(HEIGHTS), "npy"),
    "SDF in text": (sdf(sdfio.FileFormat.ASCII), "sdf", "text"),
    "SDF": (sdf(sdfio.FileFormat.BINARY), "sdf"),
    "text": (TEXT, "text"),
    "text in UTF-16": (TEXT.decode().encode("utf-16"), "text"),
    "instrument with a header in text": (b"\\*File list" + TEXT + BINARY, "instruments"),
    "its export as text": (b"\\*File list" + TEXT, "text"),
    "instrument with a header in UTF-16": ("fileformat = bcrstm".encode("utf-16"), "instruments", "text"),
    "Digital Surf": (b"DIGITAL SURF" + BINARY, "digital_surf"),
    "text that begins with its mark": (b"DIGITAL SURF" + TEXT, "text"),
    "instrument": (b"KPK0" + BINARY, "instruments"),
    "text that begins with the mark of a binary format": (b"KPK0" + TEXT, "text"),
    "instrument whose mark lies further on": (b"\x01\0Directory" + BINARY, "instruments"),
    "no format": (BINARY,),
}


@pytest.mark.parametrize("kind", FILES)
def test_each_file_has_its_reader_whatever_the_order_among_equals(tmp_path, kind):
    content, *expected = FILES[kind]
    path = saved(tmp_path, content)
    head = read_head(path)
    claims = [(reader.recognised_by, name) for name, reader in readers() if reader.recognises(path, head)]
    assert [name for _, name in claims] == [*expected, "unmarked"]
    assert recognised(path)[0] == claims[0][1]
    assert claims[-1][0] == RecognisedBy.NOTHING
    assert len({rank for rank, _ in claims}) == len(claims)


def test_the_order_is_the_documented_one():
    ranks = [reader.recognised_by for _, reader in readers()]
    assert ranks == sorted(ranks)
    assert [rank.name for rank in RecognisedBy] == ["CONTENTS", "MARK", "TEXT", "NOTHING"]
    assert ranks.count(RecognisedBy.NOTHING) == 1


def test_damaged_or_empty_hdf5_is_refused_whoever_wrote_it(refusal):
    refusal(hdf5("MetaData")[:200], "damaged or cut off HDF5 file")
    refusal(hdf5("a"), "it has no variable at all")


def test_values_that_are_no_numbers_are_refused_in_a_sentence(tmp_path):
    path = tmp_path / "words.nc"
    xr.DataArray([["a", "b"], ["c", "d"]], dims=("y", "x"), name="words").to_netcdf(path)
    refuses(r"variable 'words' holds values of type .*, not real numbers", path, **GIVEN, height_unit="um")


def test_reading_an_array_imports_no_library_of_instruments(tmp_path):
    np.save(tmp_path / "map.npy", HEIGHTS)
    program = (
        "import sys; from roughcontact import read_height_map;"
        "read_height_map(sys.argv[1], dx=1, dy=1, unit='um');"
        "print(*{'SurfaceTopography', 'x3pio', 'sdfio', 'h5py', 'netCDF4', 'scipy'} & set(sys.modules))"
    )
    run = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "map.npy")], capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == []


def test_recognising_a_file_imports_nothing_that_computes(tmp_path):
    """A run that has new files waits for it before its first job."""
    np.save(tmp_path / "map.npy", HEIGHTS)
    program = (
        "import sys; from pathlib import Path; from roughcontact.io.registry import recognised;"
        "print(recognised(Path(sys.argv[1]))[0], *{'xarray', 'pandas', 'scipy'} & set(sys.modules))"
    )
    run = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "map.npy")], capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == ["npy"]
