"""How readers are found, in which order they are asked, and what reading imports."""

import io
import subprocess
import sys
import zipfile
from itertools import groupby

import h5py
import numpy as np
import pytest
import sdfio
import xarray as xr
from measured_files import array, refuses, x3p

from roughcontact.errors import InputFileError
from roughcontact.io import readers as room
from roughcontact.io.interface import RecognisedBy, head_of
from roughcontact.io.read import read_height_map
from roughcontact.io.registry import open_file, readers, recognised

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


def test_one_file_adds_a_format(tmp_path, another_format):
    path = tmp_path / "map.xyz"
    path.write_bytes(b"ANOTHER\0" + bytes([4]) + (1e9 * HEIGHTS).tobytes())
    height = read_height_map(path)
    np.testing.assert_allclose(height.values[::-1], HEIGHTS, rtol=1e-12)
    assert float(height.x[1] - height.x[0]) == pytest.approx(2e-6)
    assert height.attrs["source_format"] == "another"
    path.write_bytes(path.read_bytes()[:-8])
    refuses("cut off", path)


def archive():
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed:
        packed.writestr("index.xml", "<xml/>")
    return stream.getvalue()


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
FILES = {
    "X3P": (lambda: x3p(HEIGHTS), "x3p"),
    "another archive": (archive, "instruments"),
    "HDF5 of Zygo": (lambda: hdf5("MetaData"), "datx"),
    "other HDF5": (lambda: hdf5("Height"), "netcdf"),
    "HDF5 without the whole mark": (lambda: b"\x89HDF" + BINARY, "unmarked"),
    "netCDF": (lambda: b"CDF\x01" + BINARY, "netcdf"),
    "NumPy": (lambda: array(HEIGHTS), "npy"),
    "SDF in text": (lambda: sdf(sdfio.FileFormat.ASCII), "sdf"),
    "SDF": (lambda: sdf(sdfio.FileFormat.BINARY), "sdf"),
    "text": (lambda: TEXT, "text"),
    "text in UTF-16": (lambda: TEXT.decode().encode("utf-16"), "text"),
    "instrument with a header in text": (lambda: b"\\*File list" + TEXT + BINARY, "instruments"),
    "its export as text": (lambda: b"\\*File list" + TEXT, "text"),
    "instrument with a header in UTF-16": (lambda: "fileformat = bcrstm".encode("utf-16"), "instruments"),
    "Digital Surf": (lambda: b"DIGITAL SURF" + BINARY, "digital_surf"),
    "text that begins with its mark": (lambda: b"DIGITAL SURF" + TEXT, "text"),
    "instrument": (lambda: b"KPK0" + BINARY, "instruments"),
    "text that begins with the mark of a binary format": (lambda: b"KPK0" + TEXT, "text"),
    "instrument whose mark lies further on": (lambda: b"\x01\0Directory" + BINARY, "instruments"),
    "no format": (lambda: BINARY, "unmarked"),
}


@pytest.mark.parametrize("kind", FILES)
def test_each_file_has_its_reader_whatever_the_order_among_equals(tmp_path, kind):
    made, expected = FILES[kind]
    path = tmp_path / "file.dat"
    path.write_bytes(made())
    assert recognised(path)[0] == expected
    head = head_of(path)
    claims = [(reader.recognised_by, name) for name, reader in readers() if reader.recognises(path, head)]
    assert claims[-1] == (RecognisedBy.NOTHING, "unmarked")
    for _, equals in groupby(claims, key=lambda claim: claim[0]):
        assert len(list(equals)) == 1


def test_the_order_is_the_documented_one():
    ranks = [reader.recognised_by for _, reader in readers()]
    assert ranks == sorted(ranks)
    assert [rank.name for rank in RecognisedBy] == ["CONTENTS", "MARK", "TEXT", "NOTHING"]
    assert ranks.count(RecognisedBy.NOTHING) == 1


@pytest.mark.parametrize(("before", "after"), [("x3p", "instruments"), ("datx", "netcdf"), ("sdf", "text")])
def test_the_order_matters_where_two_readers_claim_a_file(tmp_path, before, after):
    made = {
        "x3p": lambda: x3p(HEIGHTS),
        "datx": lambda: hdf5("MetaData"),
        "sdf": lambda: sdf(sdfio.FileFormat.ASCII),
    }[before]
    path = tmp_path / "file.dat"
    path.write_bytes(made())
    claims = [name for name, reader in readers() if reader.recognises(path, head_of(path))]
    assert claims[:2] == [before, after]


def test_damaged_hdf5_is_refused_whoever_wrote_it(tmp_path):
    path = tmp_path / "file.dat"
    path.write_bytes(hdf5("MetaData")[:200])
    with pytest.raises(InputFileError, match="damaged or cut off HDF5 file"):
        open_file(path)


def test_values_that_are_no_numbers_are_refused_in_a_sentence(tmp_path):
    path = tmp_path / "words.nc"
    xr.DataArray([["a", "b"], ["c", "d"]], dims=("y", "x"), name="words").to_netcdf(path)
    refuses(
        r"variable 'words' holds values of type .*, not real numbers",
        path,
        dx=1,
        dy=1,
        unit="um",
        height_unit="um",
    )


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
