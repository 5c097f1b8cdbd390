"""Formats that are added, those that are refused by their names, and what messages say."""

import gzip
import io
import json

import numpy as np
import openpyxl
import pytest
from measured_files import (
    GIVEN,
    archive,
    holds,
    keyence,
    matlab,
    refuses,
    saved,
    steps,
    tmd,
    warnings_of,
    x3p,
)
from PIL import Image
from shared_data import DATA

from roughcontact import SettingsError, read_height_map
from roughcontact.interface.program import main

MORE = DATA.parent / "more_data"
HEIGHTS = np.random.default_rng(5).normal(size=(6, 9)).astype(np.float32)
SIZE = 1.8, 0.9  # mm


@pytest.mark.parametrize("comment", [b"", b"Created by TrueMap v6\r\n", b"of another length"])
def test_truemap_with_any_comment(read, comment):
    height = read(tmd(HEIGHTS, SIZE, comment))
    holds(height, 1e-3 * HEIGHTS[::-1].astype(float), rtol=1e-12)
    assert steps(height) == pytest.approx([2e-4, 1.5e-4])


def test_truemap_that_is_damaged(refusal):
    refusal(tmd(HEIGHTS, SIZE)[:-1], "272 bytes where its header needs 273: it was cut off")
    refusal(tmd(HEIGHTS, SIZE)[:40], "it was cut off")
    refusal(tmd(HEIGHTS, SIZE, version=b"v3.0"), r"another version than 2\.0")
    refusal(tmd(HEIGHTS[:, :0], SIZE), "its header is damaged: 6 x 0 points on")


@pytest.mark.parametrize("compressed", [False, True])
def test_matrices_of_matlab(read, refusal, compressed):
    heights = np.where(HEIGHTS > 1.5, np.nan, HEIGHTS)
    content = {"comment": "text", "x": np.arange(9.0), "mask": HEIGHTS > 0, "z": heights, "q": HEIGHTS * 1j}
    data = matlab(content, do_compression=compressed)
    height = read(data, dx=2, dy=3, unit="um", height_unit="nm")
    holds(height, 1e-9 * heights, 2e-6, 3e-6, rtol=1e-7)
    assert json.loads(height.attrs["channels"])[0] == "z"
    holds(read(data, channel="x", dx=1, unit="um"), 1e-6 * np.arange(9.0)[None], 1e-6)
    refusal(data, "give dx, dy, unit")
    warnings = warnings_of(read(matlab({"z": [np.arange(9.0), *HEIGHTS]}), dx=2, dy=3, unit="um"))
    assert "the first row (0, 1, 2 ...) may be numbers or positions" in warnings
    assert "left out" not in warnings
    for cut in (0.3, 0.6, 0.9):
        refusal(data[: int(cut * len(data))], r"map\.", channel="z", dx=2, dy=3, unit="um")


def test_a_bomb_in_matlab(refusal, monkeypatch):
    data = matlab({"z": np.zeros((2000, 2000))}, do_compression=True)
    assert len(data) < 10**5
    monkeypatch.setattr("roughcontact.io.readers.matlab.MAX_UNPACKED_BYTES", 10**7)
    refusal(data, "unpack to .* more than", **GIVEN)


def picture(kind):
    stream = io.BytesIO()
    Image.fromarray((np.arange(400) % 255).astype(np.uint8).reshape(20, 20)).save(stream, kind)
    return stream.getvalue()


def names(*listed):
    return archive(dict.fromkeys(listed, b"1 2 3 4\n"))


def workbook(*sheets):
    return archive({"xl/workbook.xml": "".join(f'<sheet name="{sheet}" sheetId="1"/>' for sheet in sheets)})


def test_a_workbook_of_one_sheet_is_read_as_its_table(tmp_path):
    book = openpyxl.Workbook()
    for row in (["Profil links", None], ["x [mm]", "z [µm]"], *([0.5 * n, n * n % 7 / 4] for n in range(12))):
        book.active.append(row)
    book.save(tmp_path / "map.dat")
    height = read_height_map(tmp_path / "map.dat")
    holds(height, 1e-6 * (np.arange(12)[None] ** 2 % 7 / 4), 0.5e-3, rtol=1e-12)
    assert height.attrs["source_format"] == "Excel workbook (text profile (x, z))"
    book.create_sheet("second")
    book.save(tmp_path / "two.xlsx")
    refuses(r"the heights as CSV .*: 'Sheet', 'second'\)", tmp_path / "two.xlsx")


def locked(packed):
    """Return an archive whose only member is marked as encrypted."""
    marked = bytearray(packed)
    marked[6] |= 1
    marked[marked.find(b"PK\x01\x02") + 8] |= 1
    return bytes(marked)


PLY = b"ply\nformat ascii 1.0\nproperty float z\nend_header\n1 2 3\n"
XLS = b"\xd0\xcf\x11\xe0" + bytes(600) + "Workbook".encode("utf-16-le")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"MATLAB 7.3 MAT-file, Platform" + bytes(500), r"version 7\.3 \(HDF5\).*'-v7'"),
        (gzip.compress(b"1 2 3", mtime=0), "packed file; unpack it first"),
        (b"Wyko ASCII Data File Format\t0\t0\t1\nX Size\t2\n1\t2\n", "counted in waves.*take the OPD file"),
        (b"Zygo ASCII Data File - Format 2\n0 1 1 20\n", "counts of the phase.*take the DAT or DATX file"),
        (b"Zygo XYZ Data File - Format 2\n0 1 1 20\n", "export it as format 1"),
        (b"DSAA\n2 2\n0 1\n0 1\n0 1\n1 2\n3 4\n", "grid of Surfer.*save it as ASCII XYZ"),
        (PLY, "a mesh .PLY., whose columns may be"),
        (b"DSBB" + bytes(50), "grid of Surfer"),
        (b"ISO 5436 - 2000\r\n\x03\r\n1.0\r\n\x03", "a profile in the form of ISO 5436-2"),
        (locked(names("main.xml")), "the ZIP archive asks for a password; unpack it first"),
        (picture("PNG"), "a picture, whose colours are no heights"),
        (picture("JPEG"), "a picture, whose colours are no heights"),
        (picture("TIFF"), "a TIFF picture, but none of Park Systems, JPK or Olympus LEXT"),
        (names("a.txt", "b/c.001"), r"none of the formats that are known .*it holds 'a\.txt', 'b/c\.001'"),
        (names("[Content_Types].xml", "xl/workbook.xml"), "Mitutoyo"),
        (names("[Content_Types].xml", "xl/other.xml"), "Excel workbook.* the sheet with the heights as CSV"),
        (workbook("A &amp; B", "C"), r"the heights as CSV .*: 'A & B', 'C'\)"),
        (workbook("heights"), "a damaged Excel workbook"),
        (workbook("DATA"), r"the heights as CSV .*: 'DATA'\)"),
        (names("word/document.xml"), "an Office document"),
        (names("z.npy"), r"NumPy arrays \(npz\); save the array of heights alone"),
        (XLS, "an Excel workbook; save the sheet"),
        (matlab({"comment": "text"}), r"no matrix of real numbers .* it has comment \(char\)"),
    ],
)
def test_what_is_known_and_not_read_is_named(refusal, data, message):
    assert "NMM), but is damaged" not in refusal(data, message, **GIVEN)


def test_a_film_of_high_speed_microscopy_is_named(refusal):
    refusal(bytes(range(256)) * 9, r"\(asd\) is not read: save a frame as text or GWY", name="film.asd")


@pytest.mark.parametrize("inner_folder", ["", "a/b/"])
def test_a_stale_checksum_is_read_on_request(tmp_path, inner_folder, capsys):
    edited = x3p(HEIGHTS * 1e-6, edit=lambda main: main + b"\n", restate=False, folder=inner_folder)
    path = saved(tmp_path, edited)
    refuses(r"checksum of main\.xml does not match .*give checksum = ignore", path)
    height = read_height_map(path, checksum="ignore")
    np.testing.assert_allclose(height.values, HEIGHTS * 1e-6, rtol=1e-6)
    assert "read nevertheless, as asked (checksum = ignore)" in warnings_of(height)
    refuses("checksum = 'no'", path, error=SettingsError, checksum="no")
    for options, words in ((["--checksum", "ignore"], "read nevertheless"), ([], "give checksum = ignore")):
        assert main(["inspect", str(path), *options]) == 0
        assert words in " ".join(capsys.readouterr().out.split())


@pytest.mark.shared_data
def test_a_real_file_with_a_stale_checksum():
    refuses("give checksum = ignore", MORE / "csafe-logo.x3p")
    assert read_height_map(MORE / "csafe-logo.x3p", checksum="ignore").shape == (419, 741)


def test_paths_too_long_for_any_file(tmp_path, capsys):
    for name in ("a" * 300, "/".join(["a" * 50] * 100)):
        assert len(refuses("longer than any file's; check the path", tmp_path / name)) < 200
    assert main(["inspect", "a" * 5000]) == 2
    assert "5000 characters" in capsys.readouterr().err


@pytest.mark.parametrize("wrapped", ["", "VK6", "VK7"])
def test_keyence_alone_and_within_an_archive(read, refusal, wrapped):
    counts = np.random.default_rng(8).integers(0, 2**20, (5, 7))
    data = keyence(counts, 250_000, 250_000, 100)
    if wrapped:
        data = wrapped.encode() + b"\x01" + bytes(range(1, 200)) + archive({"Vk4File": data})
    holds(read(data), 1e-10 * counts[::-1], 250e-9, 250e-9, rtol=1e-12)
    refusal(data[: int(0.6 * len(data))], r"map\.")
