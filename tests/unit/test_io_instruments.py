"""Headers of instruments: files written here byte by byte, and public files beside what others read."""

import json
import struct

import numpy as np
import pytest
from measured_files import gwy, holds, jpk, labelled, matlab, refuses, sdf, steps, warnings_of
from shared_data import DATA

from roughcontact.io.inspection import inspect_file
from roughcontact.io.read import read_height_map

CASES = DATA.parent / "cases"
COUNTS = np.random.default_rng(3).integers(-9000, 9000, (6, 8))
HEIGHTS, SIZE = 1e-9 * COUNTS, (8e-6, 8e-6)  # m


def surf(counts, kind=2, objects=1, *, dy=3.0, units=(b"\xb5m", b"\xb5m", b"nm")):
    """Return one object of a Digital Surf file by its published layout: integers of 0.5 units each."""
    ny, nx = counts.shape
    header = struct.pack("<12s4H60s5H8s", b"DIGITAL SURF", 0, objects, 1, kind, b"", 1, 0, 0, 0, 0, b"")
    lowest, highest = int(counts.min()), int(counts.max())
    header += struct.pack("<H4iI3f", 32, lowest, highest, nx, ny, nx * ny, 2.0, dy, 0.5)
    header += b"".join(name.ljust(16) for name in (b"X", b"Y", b"Z", *units, *units))
    return header.ljust(512, b"\0") + counts.astype("<i4").tobytes()


def test_a_series_of_digital_surf_has_a_channel_for_each_object(read, refused):
    data = surf(COUNTS, 5, 3) + surf(2 * COUNTS) + surf(3 * COUNTS)
    height = read(data)
    assert json.loads(height.attrs["channels"]) == ["object 1", "object 2", "object 3"]
    assert "'object 1', the first height channel of 3, was read" in warnings_of(height)
    holds(read(data, channel="object 3"), 1.5e-9 * COUNTS[::-1], 2e-6, 3e-6, rtol=1e-12)
    refused(surf(COUNTS, 5, 3) + surf(COUNTS), "2 objects where its header states 3")
    for cut in (1, 300):
        refused(data[:-cut], "cut off")


def test_profiles_of_digital_surf(read):
    profile = surf(COUNTS[:1], 1, dy=0.0, units=(b"mm", b"", b"\xb5m"))
    holds(read(profile), 0.5e-6 * COUNTS[:1], 2e-3, rtol=1e-12)
    holds(read(surf(COUNTS, 4), channel="object 2"), 0.5e-9 * COUNTS[1:2], 2e-6, rtol=1e-12)


@pytest.mark.parametrize("micro", [b"\xb5m", "µm".encode(), b"\xe6m", b"um"])
def test_every_micro_sign_of_digital_surf(read, micro):
    height = read(surf(COUNTS, units=(micro, b"nm", micro)))
    holds(height, 0.5e-6 * COUNTS[::-1], 2e-6, 3e-9, rtol=1e-12)  # the unit of each axis
    assert "the axes have different units, " in warnings_of(height)


def test_arbitrary_units_are_no_damage(read, refused):
    data = surf(COUNTS, units=(b"mm", b"mm", b"a.u."))
    refused(data, r"no channel .* holds heights \('Default': values in a\.u\., no")
    assert read(data, height_unit="nm").shape == (6, 8)


def nanoscope(data, *, lines, image, scan="10000 nm", aspect="1:1", planned=8, valid=True, slow=()):
    """Return a Nanoscope file of one channel with these statements on its size."""
    ny, nx = data.shape
    said = [
        *("*File list", "Version: 0x05150107", "Date: 11:47:00 AM Thu Jul 22 2021"),
        *("*Ciao scan list", f"Scan Size: {scan}", f"Samps/line: {nx}", f"Lines: {planned}"),
        *(f"Aspect Ratio: {aspect}", "@Sens. Zsens: V 10.0 nm/V", *slow),
        *("*Ciao image list", "Data offset: 2048", f"Data length: {2 * nx * ny}", "Bytes/pixel: 2"),
        *(f"Samps/line: {nx}", f"Number of lines: {lines}", f"Scan Size: {image}", "Aspect Ratio: 0.516184"),
        *([f"Valid data len Y: {ny}"] if valid else []),
        *('@2:Image Data: S [Height] "Height"', "@2:Z scale: V [Sens. Zsens] (0.006 V/LSB) 6.5536 V"),
        "*File list end",
    ]
    header = "".join(f"\\{line}\r\n" for line in said).encode()
    return header.ljust(2048, b"\0") + data.astype("<i2").tobytes()


@pytest.mark.parametrize(
    ("stated", "length"),
    [
        ({"lines": 6, "image": "10 10 ~m", "planned": 6}, 10.0),  # a whole scan with long pixels
        ({"lines": 6, "image": "10 5 ~m", "planned": 6, "aspect": "2:1"}, 5.0),
        ({"lines": 6, "image": "10 10 ~m", "planned": 6, "aspect": "2:1"}, 5.0),
        ({"lines": 6, "image": "10 10 ~m"}, 7.5),  # stopped after six of eight lines
        ({"lines": 6, "image": "10 5 ~m", "aspect": "2:1"}, 3.75),
        ({"lines": 8, "image": "10 10 ~m", "planned": 3, "aspect": "16:1"}, 7.5),  # lines by the data alone
        ({"lines": 3, "image": "10 10 ~m", "planned": 3, "valid": False}, 7.5),
        ({"lines": 6, "image": "10 10 ~m", "slow": ["Slow Axis Size: 10000 nm"]}, 7.5),
    ],
)
def test_lines_and_length_of_nanoscope(read, stated, length):
    height = read(nanoscope(COUNTS, **stated))
    holds(height, 1e-12 * COUNTS, 1.25e-6, 1e-6 * length / 6, rtol=1e-12)
    whole = stated["lines"] == 6 and f"10 {length:g} ~m" == stated["image"]
    assert ("the header states" in warnings_of(height)) == (not whole and "slow" not in stated)


def test_bytes_of_nanoscope_that_are_no_lines_are_named(read):
    data = nanoscope(COUNTS, lines=6, image="10 10 ~m", planned=6).replace(b"length: 96", b"length: 99")
    said = "3 of the 99 bytes of channel 'Height' are no part of its 6 lines"
    assert said in warnings_of(read(data + b"abc"))


def test_a_softgauge_of_one_profile(read, refused):
    holds(read(sdf(COUNTS[:1], 5e-7, 0, 1e-9, "aNPL-V1.0")), 1e-9 * COUNTS[:1], 5e-7, rtol=1e-12)
    refused(sdf(COUNTS[:1], 5e-7, 0, 0, "aNPL-V1.0"), "Zscale = 0.0, the height of a count")


def zygo(resolution):
    head = ["Zygo XYZ Data File - Format 1", '0 8 0 0 "today"', "0 0 0 0 0 0", "0 0 8 6", '""', '""', '""']
    head += [f"0 0.5 6.328e-07 0 1 0 {resolution} 0", "8 6", "0", "1", "0", "1", "#"]
    values = ["No Data" if (x, y) == (3, 2) else COUNTS[y, x] / 1e3 for y in range(6) for x in range(8)]
    return "\n".join([*head, *(f"{n % 8} {n // 8} {z}" for n, z in enumerate(values)), "#", ""])


def test_zygo_xyz_of_format_1(read, refused):
    heights = 1e-9 * COUNTS
    heights[2, 3] = np.nan
    holds(read(zygo("2e-06")), heights, 2e-6, 2e-6, rtol=1e-12)
    refused(zygo("0"), "give dx, dy, unit")  # a camera that was not calibrated
    refused("\n".join(zygo("2e-06").split("\n")[:-10]), "40 lines of points where the header needs 8 x 6")


def test_a_map_of_three_axes_is_chosen_by_its_index(read, tmp_path):
    values = 1e-9 * np.stack([COUNTS, 2 * COUNTS, 3 * COUNTS])
    scans = labelled(values, name="z")
    for path, dims in ((tmp_path / "first.nc", ("t", "y", "x")), (tmp_path / "last.nc", ("y", "x", "t"))):
        scans.transpose(*dims).to_netcdf(path)
        holds(read_height_map(path, channel="z[t=2]"), values[2], rtol=1e-12)
        assert "'z[t=0]', the first height channel of 3, was read" in warnings_of(read_height_map(path))
    scans.transpose("y", "x", "t").rename(y="r", x="c").to_netcdf(path)
    refuses("nothing says which axes of 'z' are those of a map: name two of r, c, t y and x", path)
    second = read(matlab({"z": values.transpose(1, 2, 0)}), channel="z(:,:,2)", dx=1, dy=1, unit="m")
    holds(second, values[1], rtol=1e-12)


def images(**units):
    """Return a file of Gwyddion with the map under these titles and in these units."""
    return gwy({title: (HEIGHTS, unit) for title, unit in units.items()}, SIZE)


def test_images_of_gwyddion_in_other_units(read, refused, tmp_path):
    data = images(a="V", b="")
    refused(data, r"\('a': values in V, .*'b': values in no unit.* height_unit")
    refused(data, r"channel 'a' holds no heights .* give height_unit", channel="a")
    holds(read(data, channel="a", height_unit="m"), HEIGHTS[::-1], rtol=1e-12)
    assert read(images(a="V", b="m")).attrs["channel"] == "b"
    listed = inspect_file(tmp_path / "map.dat")["channels"]
    assert [(each["name"], each["height_unit"]) for each in listed] == [("a", "V"), ("b", "m")]


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
    other = read(scan(), channel="Height (trace, frame 2)")
    holds(other, -3e-16 * FRAMES[:, 1].reshape(3, 4) + 4e-7)
    reasons = {each["name"]: each["reason"] for each in inspect_file(tmp_path / "map.dat")["channels"]}
    assert reasons["Lock-In Phase (trace, frame 1)"] == "values in deg, no length"
    assert reasons["Lock-In Amplitude (retrace, frame 1)"] == "by its name no topography"


def test_what_is_wrong_in_a_scan_is_named(read, refused):
    refused(scan(points=11), "no 3 x 4 points of each frame")
    refused(scan(unit="V"), "no channel of this file holds heights")
    refused(scan(ulength=0.0), "are impossible; give dx, dy and unit")
    turned = scan(theta=0.5)
    assert "the scan is turned" in warnings_of(read(turned))
    refused(turned[: int(0.6 * len(turned))], "damaged or cut off HDF5 file")


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
    spacing, some = SHARED[name]
    truth = np.load(CASES / "truth.npy")[some]
    measured = np.isfinite(height.values)
    assert int((~measured).sum()) == (18 if name == "zygo_xyz.xyz" else 0)
    off = (1e6 * height.values - truth)[measured]
    assert np.ptp(off) < 1e-6
    assert steps(height) == pytest.approx([1e-6 * step for step in spacing])


@pytest.mark.shared_data
def test_a_strip_of_nanoscope_has_all_its_lines():
    height = read_height_map(CASES / "nanoscope_16to1_32_lines.001")
    assert height.shape == (32, 512)
    assert np.multiply(steps(height), (512, 32)) == pytest.approx([65e-6, 4.0625e-6])


@pytest.mark.shared_data
@pytest.mark.parametrize(
    ("channel", "rms"),
    [
        ("Height (trace, frame 1)", 3.153759787322164e-9),
        ("Height (trace, frame 4)", 2.385664846424173e-9),
        ("Height (retrace, frame 2)", 2.527799639881413e-9),
    ],
)
def test_a_real_scan_of_jpk_as_afmreader_reads_it(channel, rms):
    height = read_height_map(DATA.parent / "more_data" / "sample_0.h5-jpk", channel=channel)
    assert height.shape == (128, 128)
    assert float(height.std()) == pytest.approx(rms, rel=1e-9)
    assert steps(height)[0] == pytest.approx(1.171875e-9, rel=1e-12)
