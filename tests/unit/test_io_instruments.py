"""Headers of instruments: files written here byte by byte, and public files beside what others read."""

import io
import json
import re
import struct
import zlib

import h5py
import numpy as np
import pytest
from measured_files import gwy, holds, jpk, labelled, matlab, refuses, sdf, steps, warnings_of, x3p
from shared_data import DATA

from roughcontact import inspect_file, read_height_map

CASES = DATA.parent / "cases"
COUNTS = np.random.default_rng(3).integers(-9000, 9000, (6, 8))
HEIGHTS, SIZE = 1e-9 * COUNTS, (8e-6, 8e-6)  # m


def surf(counts, kind=2, objects=1, *, dy=3.0, units=(b"\xb5m", b"\xb5m", b"nm"), streams=0, names=b""):
    """Return one object of a Digital Surf file by its published layout: integers of 0.5 units each."""
    ny, nx = counts.shape
    mark = b"DSCOMPRESSED" if streams else b"DIGITAL SURF"
    header = struct.pack("<12s4H60s5H8s", mark, 0, objects, 1, kind, names, 1, 0, 0, 0, 0, b"")
    lowest, highest = int(counts.min()), int(counts.max())
    header += struct.pack("<H4iI3f", 32, lowest, highest, nx, ny, nx * ny, 2.0, dy, 0.5)
    header += b"".join(name.ljust(16) for name in (b"X", b"Y", b"Z", *units, *units))
    points = counts.astype("<i4").tobytes()
    if streams:
        step = -(-len(points) // streams)
        pieces = [points[start : start + step] for start in range(0, len(points), step)]
        packed = [zlib.compress(piece) for piece in pieces]
        sizes = [
            struct.pack("<2I", len(piece), len(part)) for piece, part in zip(pieces, packed, strict=True)
        ]
        points = struct.pack("<I", len(packed)) + b"".join(sizes + packed)
    return header.ljust(512, b"\0") + points


def test_packed_points_of_digital_surf(read, refusal):
    for streams in (1, 3):
        data = surf(COUNTS, streams=streams)
        holds(read(data), 0.5e-9 * COUNTS[::-1], 2e-6, 3e-6, rtol=1e-12)
        refusal(data[:-1], "it was cut off")
    series = surf(COUNTS, 5, 2, streams=1) + surf(2 * COUNTS, streams=2)
    holds(read(series, channel="object 2"), 1e-9 * COUNTS[::-1], rtol=1e-12)
    assert read(surf(COUNTS, 4, streams=1), channel="object 2").shape == (1, 8)
    for position, message in ((512 + 4, "states 48 points"), (512 + 40, "its packed points are damaged")):
        damaged = bytearray(surf(COUNTS, streams=1))
        damaged[position] ^= 1
        refusal(bytes(damaged), message)
    oversized = bytearray(surf(COUNTS, streams=1))
    oversized[108:120] = struct.pack("<2iI", 60_000, 60_000, 60_000**2 % 2**32)
    refusal(bytes(oversized), "states .* points of 32 bits in 60000 rows")


def test_images_of_digital_surf_are_no_heights(read, refusal):
    data = surf(COUNTS, 13, 1, streams=1) + surf(COUNTS, 10, units=(b"mm", b"mm", b""))
    assert read(data).attrs["channel"] == "object 1"
    refusal(data, "channel 'object 2' holds no heights .*an image", channel="object 2")


def test_two_programs_mark_every_file_of_digital_surf_as_an_imprint(read):
    for names, client, is_imprint in (
        (b"", b"", True),
        (b"SCRATCH".ljust(30) + b"csm".ljust(30), b"", False),  # Gwyddion
        (b"", b"Exported by surfalize", False),
    ):
        data = bytearray(surf(COUNTS, names=names))
        data[288], data[338 : 338 + len(client)] = 1, client
        assert ("an imprint (replica)" in warnings_of(read(bytes(data)))) == is_imprint


def test_a_series_of_digital_surf_has_a_channel_for_each_object(read, refusal):
    data = surf(COUNTS, 5, 3) + surf(2 * COUNTS) + surf(3 * COUNTS)
    height = read(data)
    assert json.loads(height.attrs["channels"]) == ["object 1", "object 2", "object 3"]
    assert "'object 1', the first height channel of 3, was read" in warnings_of(height)
    holds(read(data, channel="object 3"), 1.5e-9 * COUNTS[::-1], 2e-6, 3e-6, rtol=1e-12)
    refusal(surf(COUNTS, 5, 3) + surf(COUNTS), "2 objects where its header states 3")
    for cut in (1, 300):
        refusal(data[:-cut], "cut off")


def test_profiles_of_digital_surf(read):
    profile = surf(COUNTS[:1], 1, dy=0.0, units=(b"mm", b"", b"\xb5m"))
    holds(read(profile), 0.5e-6 * COUNTS[:1], 2e-3, rtol=1e-12)
    holds(read(surf(COUNTS, 4), channel="object 2"), 0.5e-9 * COUNTS[1:2], 2e-6, rtol=1e-12)


@pytest.mark.parametrize("micro", [b"\xb5m", "µm".encode(), b"\xe6m", b"um"])
def test_every_micro_sign_of_digital_surf(read, micro):
    height = read(surf(COUNTS, units=(micro, b"nm", micro)))
    holds(height, 0.5e-6 * COUNTS[::-1], 2e-6, 3e-9, rtol=1e-12)  # the unit of each axis
    assert "the axes have different units, " in warnings_of(height)


def test_arbitrary_units_are_no_damage(read, refusal):
    data = surf(COUNTS, units=(b"mm", b"mm", b"a.u."))
    refusal(data, r"no channel .* holds heights \('Default': values in a\.u\., no")
    assert read(data, height_unit="nm").shape == (6, 8)


def nanoscope(data, *, lines, image, scan="10000 nm", aspect="1:1", planned=8, valid=True, slow=()):
    """Return a Nanoscope file of one channel with these statements on its size."""
    ny, nx = data.shape
    header_lines = [
        *("*File list", "Version: 0x05150107", "Date: 11:47:00 AM Thu Jul 22 2021"),
        *("*Ciao scan list", f"Scan Size: {scan}", f"Samps/line: {nx}", f"Lines: {planned}"),
        *(f"Aspect Ratio: {aspect}", "@Sens. Zsens: V 10.0 nm/V", *slow),
        *("*Ciao image list", "Data offset: 2048", f"Data length: {2 * nx * ny}", "Bytes/pixel: 2"),
        *(f"Samps/line: {nx}", f"Number of lines: {lines}", f"Scan Size: {image}", "Aspect Ratio: 0.516184"),
        *([f"Valid data len Y: {ny}"] if valid else []),
        *('@2:Image Data: S [Height] "Height"', "@2:Z scale: V [Sens. Zsens] (0.006 V/LSB) 6.5536 V"),
        "*File list end",
    ]
    header = "".join(f"\\{line}\r\n" for line in header_lines).encode()
    return header.ljust(2048, b"\0") + data.astype("<i2").tobytes()


@pytest.mark.cases
def test_lines_and_length_of_nanoscope(read, statements, length):
    height = read(nanoscope(COUNTS, **statements))
    holds(height, 1e-12 * COUNTS, 1.25e-6, 1e-6 * length / 6, rtol=1e-12)
    is_consistent = statements["lines"] == 6 and f"10 {length:g} ~m" == statements["image"]
    assert ("the header states" in warnings_of(height)) == (not is_consistent and "slow" not in statements)


def test_a_sensitivity_of_nanoscope_in_micrometres(read):
    data = nanoscope(COUNTS, lines=6, image="10 10 ~m", planned=6)
    holds(read(data.replace(b"V 10.0 nm/V", b"V 0.01 ~m/V")), 1e-12 * COUNTS, 1.25e-6, 10e-6 / 6, rtol=1e-12)


def nanonis(*images, direction="down", side="both"):
    """Return a Nanonis file of such images (in the order of the scan) of one channel, and their header."""
    ny, nx = images[0].shape
    header = {
        "NANONIS_VERSION": "2",
        "SCANIT_TYPE": "              FLOAT            MSBFIRST",
        "REC_DATE": " 05.10.2015",
        "SCAN_PIXELS": f"       {nx}       {ny}",
        "SCAN_RANGE": "           8.000000E-6           3.000000E-6",
        "SCAN_DIR": direction,
        "Z-CONTROLLER": "\tName\ton\n\tlog Current\t1",
        "DATA_INFO": f"\tChannel\tName\tUnit\tDirection\tCalibration\n\t14\tZ\tm\t{side}\t-1.0E+0\n",
        "SCANIT_END": "\n",
    }
    text = "".join(f":{key}:\n{value}\n" for key, value in header.items())
    return text.encode() + b"\x1a\x04" + b"".join(image.astype(">f4").tobytes() for image in images)


def test_scans_of_nanonis(read, refusal):
    """Values are metres as they lie; the backward scan begins at the right, one upwards at the bottom."""
    heights = HEIGHTS.astype("f4").astype(float)
    stopped = np.where(np.arange(6)[:, None] < 4, heights, np.nan)
    data = nanonis(stopped, 2 * stopped[:, ::-1])
    holds(read(data), stopped[::-1], 1e-6, 0.5e-6, rtol=1e-12)
    holds(read(data, channel="Z (backward)"), 2 * stopped[::-1], rtol=1e-12)
    upwards = read(nanonis(heights, direction="up", side="forward"))
    holds(upwards, heights, rtol=1e-12)
    assert upwards.attrs["first_row"] == "bottom"
    for damaged, message in (
        (data[:-40], "it was cut off"),
        (data[:200], "the header of this Nanonis file has no end"),
        (data.replace(b"MSBFIRST", b"LSBFIRST"), "not FLOAT MSBFIRST"),
        (data.replace(b"8.000000E-6", b"0.000000E-6"), "are no map"),
        (data.replace(b"both", b"none"), "its header is damaged"),
    ):
        refusal(damaged, message)


def test_a_scan_of_nanoscope_that_did_not_move(refusal):
    refusal(
        nanoscope(COUNTS, lines=6, image="0 0 ~m", scan="0 nm"), "its scan size is 0 0 ~m: it did not move"
    )


@pytest.mark.parametrize(
    "data",
    [
        x3p(HEIGHTS, edit=lambda main: re.sub(rb"<Increment>[^<]*</Increment>", b"", main)),
        gwy({"a": (HEIGHTS, "m")}, (0.0, 0.0)),
    ],
)
def test_steps_that_a_file_does_not_state_are_asked_for(read, refusal, data):
    refusal(data, r"does not say its size \(its heights are in m\); give dx, dy, unit")
    steps_given = {"dx": 2, "dy": 3, "unit": "um", "height_unit": "m"}
    assert steps(read(data, **steps_given)) == pytest.approx([2e-6, 3e-6], rel=1e-12)


def test_a_picture_of_other_programs_is_no_damaged_scan(refusal):
    """With texts as names of its tags, on which the library's reader of JPK fails."""
    tags = [(256, 4, 1, 4), (257, 4, 1, 4), (273, 4, 1, 200), (279, 4, 1, 16), (50000, 12, 3, 220)]
    page = struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", *tag) for tag in tags)
    refusal((b"II*\0" + struct.pack("<I", 8) + page).ljust(400, b"\0"), "a TIFF picture, but none of Park")


@pytest.mark.shared_data
def test_steps_of_a_camera_that_was_not_calibrated(tmp_path):
    """The side of a pixel in Zygo's MetroPro files is 0 where it is unknown."""
    data = bytearray((DATA / "metropro-1.dat").read_bytes())
    calibrated = read_height_map(DATA / "metropro-1.dat")
    data[184:188] = bytes(4)
    (tmp_path / "map.dat").write_bytes(data)
    refuses("does not say its size .*; give dx, dy, unit", tmp_path / "map.dat")
    height = read_height_map(tmp_path / "map.dat", dx=2, dy=2, unit="um", height_unit="m")
    np.testing.assert_array_equal(height.values, calibrated.values)


def test_bytes_of_nanoscope_that_are_no_lines_are_named(read):
    data = nanoscope(COUNTS, lines=6, image="10 10 ~m", planned=6).replace(b"length: 96", b"length: 99")
    message = "3 of the 99 bytes of channel 'Height' are no part of its 6 lines"
    assert message in warnings_of(read(data + b"abc"))


def test_a_softgauge_of_one_profile(read, refusal):
    holds(read(sdf(COUNTS[:1], 5e-7, 0, 1e-9, "aNPL-V1.0")), 1e-9 * COUNTS[:1], 5e-7, rtol=1e-12)
    refusal(sdf(COUNTS[:1], 5e-7, 0, 0, "aNPL-V1.0"), "Zscale = 0.0, the height of a count")


def zygo(resolution):
    head = ["Zygo XYZ Data File - Format 1", '0 8 0 0 "today"', "0 0 0 0 0 0", "0 0 8 6", '""', '""', '""']
    head += [f"0 0.5 6.328e-07 0 1 0 {resolution} 0", "8 6", "0", "1", "0", "1", "#"]
    values = ["No Data" if (x, y) == (3, 2) else COUNTS[y, x] / 1e3 for y in range(6) for x in range(8)]
    return "\n".join([*head, *(f"{n % 8} {n // 8} {z}" for n, z in enumerate(values)), "#", ""])


def test_zygo_xyz_of_format_1(read, refusal):
    heights = 1e-9 * COUNTS
    heights[2, 3] = np.nan
    holds(read(zygo("2e-06")), heights, 2e-6, 2e-6, rtol=1e-12)
    refusal(zygo("0"), "give dx, dy, unit")  # a camera that was not calibrated
    refusal("\n".join(zygo("2e-06").split("\n")[:-10]), "40 lines of points where the header needs 8 x 6")


def test_a_map_of_three_axes_is_chosen_by_its_index(read, tmp_path):
    values = 1e-9 * np.stack([COUNTS, 2 * COUNTS, 3 * COUNTS])
    scans = labelled(values, name="z")
    for path, dims in ((tmp_path / "first.nc", ("t", "y", "x")), (tmp_path / "last.nc", ("y", "x", "t"))):
        scans.transpose(*dims).to_netcdf(path)
        holds(read_height_map(path, channel="z[t=2]"), values[2], rtol=1e-12)
        assert "'z[t=0]', the first height channel of 3, was read" in warnings_of(read_height_map(path))
    scans.transpose("y", "x", "t").rename(y="r", x="c").to_netcdf(path)
    refuses("nothing says which axes of 'z' are those of a map: name two of r, c, t y and x", path)
    second_page = read(matlab({"z": values.transpose(1, 2, 0)}), channel="z(:,:,2)", dx=1, dy=1, unit="m")
    holds(second_page, values[1], rtol=1e-12)


def images(**units):
    """Return a file of Gwyddion with the map under these titles and in these units."""
    return gwy({title: (HEIGHTS, unit) for title, unit in units.items()}, SIZE)


def test_images_of_gwyddion_in_other_units(read, refusal, tmp_path):
    data = images(a="V", b="")
    refusal(data, r"\('a': values in V, .*'b': values in no unit.* height_unit")
    refusal(data, r"channel 'a' holds no heights .* give height_unit", channel="a")
    holds(read(data, channel="a", height_unit="m"), HEIGHTS[::-1], rtol=1e-12)
    assert read(images(a="V", b="m")).attrs["channel"] == "b"
    listed = inspect_file(tmp_path / "map.dat")["channels"]
    assert [(channel["name"], channel["height_unit"]) for channel in listed] == [("a", "V"), ("b", "m")]


@pytest.mark.parametrize(("stored", "title"), [(b"cZ", "Z"), (b"i\x07\0\0\0", "7")])
def test_a_title_of_gwyddion_that_is_no_text(read, stored, title):
    """The Python package gwyfile stores a text of one letter as type c."""
    data = images(AAAAA="m").replace(b"sAAAAA\0", stored)
    size = int.from_bytes(data[17:21], "little") + len(stored) - 7
    height = read(data[:17] + size.to_bytes(4, "little") + data[21:])
    assert height.attrs["channel"] == title
    holds(height, HEIGHTS[::-1], rtol=1e-12)


def test_images_of_gwyddion_by_their_names_and_under_a_mask(read):
    assert read(images(Error="m", b="m")).attrs["channel"] == "b"
    twice = gwy({"a": (HEIGHTS, "m"), "b": (2 * HEIGHTS, "m")}, SIZE).replace(b"sb\0", b"sa\0")
    assert json.loads(read(twice).attrs["channels"]) == ["a", "a (2)"]
    holds(read(twice, channel="a (2)"), 2 * HEIGHTS[::-1], rtol=1e-12)
    masked = read(gwy({"a": (HEIGHTS, "m")}, SIZE, [COUNTS > 8000]))
    holds(masked, np.where(COUNTS > 8000, np.nan, HEIGHTS)[::-1])
    assert masked.attrs["missing_points"] == int((COUNTS > 8000).sum()) > 0
    assert "the mask in the file was applied" in warnings_of(masked)


# counts of JPK's fast scans: points, frames
FRAMES = np.random.default_rng(4).integers(-(2**30), 2**30, (12, 2), dtype=np.int32)


def scan(points=12, unit="m", **grid):
    grid = {"ilength": 4, "jlength": 3, "ulength": 8e-7, "vlength": 9e-7} | grid
    channels = (
        ("phase", "Lock-In Phase", 1e-7, 0.0, "deg"),
        ("amplitude", "Lock-In Amplitude", 1e-17, 0.0, "m"),
        ("height", "Height", -3e-16, 4e-7, unit),
        ("measuredHeight", "Height (measured)", 2e-15, 1e-7, unit),
    )
    return jpk(FRAMES[:points], channels, **grid)


def test_frames_and_quantities_are_channels(read, tmp_path):
    height = read(scan())
    holds(height, 2e-15 * FRAMES[:, 0].reshape(3, 4) + 1e-7, 2e-7, 3e-7)
    assert height.attrs["channel"] == "Height (measured) (retrace, frame 1)"
    assert height.attrs["first_row"] == "bottom"
    assert json.loads(height.attrs["instrument"])["probe"] == "USC"
    second_frame = read(scan(), channel="Height (trace, frame 2)")
    holds(second_frame, -3e-16 * FRAMES[:, 1].reshape(3, 4) + 4e-7)
    reasons = {
        channel["name"]: channel["reason"] for channel in inspect_file(tmp_path / "map.dat")["channels"]
    }
    assert reasons["Lock-In Phase (trace, frame 1)"] == "values in deg, no length"
    assert reasons["Lock-In Amplitude (retrace, frame 1)"] == "by its name no topography"


def test_what_is_wrong_in_a_scan_is_named(read, refusal):
    refusal(scan(points=11), "no 3 x 4 points of each frame")
    refusal(scan(unit="V"), "no channel of this file holds heights")
    refusal(scan(ulength=0.0), "does not say its size")
    turned = scan(theta=0.5)
    assert "the scan is turned" in warnings_of(read(turned))
    refusal(turned[: int(0.6 * len(turned))], "damaged or cut off HDF5 file")


# file: steps (µm), and what of the truth it holds
SHARED = {
    "rs_series.sur": ([0.5, 0.75], np.s_[:]),
    "rs_profile.pro": ([0.5], np.s_[7:8]),
    "surfalize.sur": ([0.5, 0.75], np.s_[:]),
    "npl_profile.sdf": ([0.5], np.s_[7:8]),
    "zygo_xyz.xyz": ([0.5, 0.5], np.s_[:]),
}


@pytest.mark.shared_data
@pytest.mark.parametrize("name", SHARED)
def test_files_of_other_programs_hold_the_map_behind_them(name):
    """But for a constant, which programs add to heights as they like."""
    height = read_height_map(CASES / name)
    spacing, part = SHARED[name]
    truth = np.load(CASES / "truth.npy")[part]
    measured = np.isfinite(height.values)
    assert int((~measured).sum()) == (18 if name == "zygo_xyz.xyz" else 0)
    deviation = (1e6 * height.values - truth)[measured]
    assert np.ptp(deviation) < 1e-6
    assert steps(height) == pytest.approx([1e-6 * step for step in spacing])


@pytest.mark.shared_data
def test_a_strip_of_nanoscope_has_all_its_lines():
    height = read_height_map(CASES / "nanoscope_16to1_32_lines.001")
    assert height.shape == (32, 512)
    assert np.multiply(steps(height), (512, 32)) == pytest.approx([65e-6, 4.0625e-6])


@pytest.mark.shared_data
@pytest.mark.cases
def test_a_real_scan_of_jpk_as_afmreader_reads_it(channel, rms):
    height = read_height_map(DATA.parent / "more_data" / "sample_0.h5-jpk", channel=channel)
    assert height.shape == (128, 128)
    assert float(height.std()) == pytest.approx(rms, rel=1e-9)
    assert steps(height)[0] == pytest.approx(1.171875e-9, rel=1e-12)


def imagej(values, description, *, resolution=(2.5, 4.0)):
    """Return a TIFF of one image with such a description, as ImageJ writes it."""
    from PIL import Image, TiffImagePlugin

    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags[270] = "ImageJ=1.54f\n" + description
    tags[282], tags[283] = map(TiffImagePlugin.IFDRational, resolution)
    content = io.BytesIO()
    Image.fromarray(values).save(content, "TIFF", tiffinfo=tags)
    return content.getvalue()


def test_images_of_imagej(read, refusal):
    heights = (0.5 * COUNTS).astype("f4")
    for unit in ("micron", "um", "\\u00B5m"):
        data = imagej(heights, f"unit={unit}\nmin=-9000.0\n")
        holds(read(data, height_unit="nm"), 0.5e-9 * COUNTS[::-1], 0.4e-6, 0.25e-6, rtol=1e-12)
    refusal(data, "does not say the unit of its heights; give height_unit")
    refusal(data[:-9], "was cut off", height_unit="nm")
    counts = (COUNTS + 9000).astype("u2")
    calibrated = imagej(counts, "unit=nm\ncf=0\nc0=-4500.0\nc1=0.5\nvunit=nm\n")
    holds(read(calibrated), 0.5e-9 * COUNTS[::-1], 0.4e-9, 0.25e-9, rtol=1e-12)
    refusal(imagej(counts, "unit=nm\ncf=3\n"), "calibrated by a curve")
    refusal(imagej(heights, "unit=pixel\n"), "give dx, dy, unit, height_unit")
    refusal(imagej(counts.astype("u1"), "unit=nm\n"), "whose shades are no heights")


def test_pages_of_imagej_are_channels(read, refusal):
    from PIL import Image

    def stack(count):
        pages = [Image.fromarray((number * COUNTS).astype("f4")) for number in range(1, count + 1)]
        content = io.BytesIO()
        pages[0].save(content, "TIFF", save_all=True, append_images=pages[1:], description="ImageJ=1.54f\n")
        return content.getvalue()

    height = read(stack(2), channel="page 2", dx=1, dy=1, unit="um", height_unit="nm")
    holds(height, 2e-9 * COUNTS[::-1], 1e-6, 1e-6, rtol=1e-6)
    refusal(stack(257), "257 pages, more than the 256 that are read")


def test_the_image_of_topostats_comes_before_its_masks(read):
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        file["full_mask_tensor"], file["image"] = np.zeros((6, 8, 3)), 1.0 * COUNTS
    height = read(content.getvalue(), dx=1, dy=1, unit="um", height_unit="nm")
    holds(height, 1e-9 * COUNTS, 1e-6, 1e-6, rtol=1e-12)
    assert height.attrs["channel"] == "image"
