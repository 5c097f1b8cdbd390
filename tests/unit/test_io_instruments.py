"""Headers of instruments: files written here byte by byte, and small public shapes of the shared folder."""

import json
import struct
import zipfile

import numpy as np
import pytest
import scipy.io
from measured_files import gwy, labelled, refuses, saved, steps, warnings_of
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
    third = read(data, channel="object 3")
    np.testing.assert_allclose(third.values[::-1], 1.5e-9 * COUNTS, rtol=1e-12)
    assert steps(third) == pytest.approx([2e-6, 3e-6])
    refused(surf(COUNTS, 5, 3) + surf(COUNTS), "2 objects where its header states 3")
    for cut in (1, 300):
        refused(data[:-cut], "cut off")


def test_profiles_of_digital_surf(read):
    profile = read(surf(COUNTS[:1], 1, dy=0.0, units=(b"mm", b"", b"\xb5m")))
    np.testing.assert_allclose(profile.values, 0.5e-6 * COUNTS[:1], rtol=1e-12)
    assert steps(profile) == pytest.approx([2e-3])
    several = read(surf(COUNTS, 4), channel="object 2")
    np.testing.assert_allclose(several.values, 0.5e-9 * COUNTS[1:2], rtol=1e-12)


@pytest.mark.parametrize("micro", [b"\xb5m", "µm".encode(), b"\xe6m", b"um"])
def test_every_micro_sign_of_digital_surf(read, micro):
    height = read(surf(COUNTS, units=(micro, b"nm", micro)))
    np.testing.assert_allclose(height.values[::-1], 0.5e-6 * COUNTS, rtol=1e-12)
    assert steps(height) == pytest.approx([2e-6, 3e-9])  # the unit of each axis
    assert "the axes have different units, " in warnings_of(height)


def test_arbitrary_units_are_no_damage(tmp_path):
    path = saved(tmp_path, surf(COUNTS, units=(b"mm", b"mm", b"a.u.")))
    refuses(r"no channel .* holds heights \('Default': values in a\.u\., no", path)
    assert read_height_map(path, height_unit="nm").shape == (6, 8)


def nanoscope(data, *, lines, image, scan="10000 nm", aspect="1:1", planned=8, valid=True, slow=""):
    """Return a Nanoscope file of one channel with these statements on its size."""
    ny, nx = data.shape
    said = [
        *("*File list", "Version: 0x05150107", "Date: 11:47:00 AM Thu Jul 22 2021"),
        *("*Ciao scan list", f"Scan Size: {scan}", f"Samps/line: {nx}", f"Lines: {planned}"),
        *(
            f"Aspect Ratio: {aspect}",
            "@Sens. Zsens: V 10.0 nm/V",
            *([f"Slow Axis Size: {slow}"] if slow else []),
        ),
        *("*Ciao image list", "Data offset: 2048", f"Data length: {2 * nx * ny}", "Bytes/pixel: 2"),
        *(f"Samps/line: {nx}", f"Number of lines: {lines}", f"Scan Size: {image}", "Aspect Ratio: 0.516184"),
        *([f"Valid data len Y: {ny}"] if valid else []),
        *('@2:Image Data: S [Height] "Height"', "@2:Z scale: V [Sens. Zsens] (0.006 V/LSB) 6.5536 V"),
        "*File list end",
    ]
    return (
        "".join(f"\\{line}\r\n" for line in said).encode().ljust(2048, b"\0") + data.astype("<i2").tobytes()
    )


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
        ({"lines": 6, "image": "10 10 ~m", "slow": "10000 nm"}, 7.5),
    ],
)
def test_lines_and_length_of_nanoscope(read, stated, length):
    height = read(nanoscope(COUNTS, **stated))
    np.testing.assert_allclose(height.values, 1e-12 * COUNTS, rtol=1e-12)
    assert steps(height) == pytest.approx([1.25e-6, 1e-6 * length / 6])
    whole = stated["lines"] == 6 and f"10 {length:g} ~m" == stated["image"]
    assert ("the header states" in warnings_of(height)) == (not whole and "slow" not in stated)


def test_bytes_of_nanoscope_that_are_no_lines_are_named(read):
    data = (
        nanoscope(COUNTS, lines=6, image="10 10 ~m", planned=6).replace(b"length: 96", b"length: 99") + b"abc"
    )
    assert "3 of the 99 bytes of channel 'Height' are no part of its 6 lines" in warnings_of(read(data))


def test_a_softgauge_of_one_profile(read, refused):
    head = ["aNPL-V1.0", "ManuFacID = Softgauges", "CreateDate = 210520051200", "ModDate = 210520051200"]
    head += ["NumPoints = 8", "NumProfiles = 1", "Xscale = 5E-07", "Yscale = 0", "Zscale = 1E-09"]
    head += ["Zresolution = -1", "Compression = 0", "DataType = 5", "CheckType = 0", "*"]
    text = "\n".join([*head, *map(str, COUNTS[0]), "*", "*", ""])
    profile = read(text)
    np.testing.assert_allclose(profile.values, 1e-9 * COUNTS[:1], rtol=1e-12)
    assert steps(profile) == pytest.approx([5e-7])
    refused(text.replace("Zscale = 1E-09", "Zscale = 0"), "Zscale = 0.0, the height of a count")


def zygo(resolution):
    head = ["Zygo XYZ Data File - Format 1", '0 8 0 0 "today"', "0 0 0 0 0 0", "0 0 8 6", '""', '""', '""']
    head += [f"0 0.5 6.328e-07 0 1 0 {resolution} 0", "8 6", "0", "1", "0", "1", "#"]
    values = ["No Data" if (x, y) == (3, 2) else COUNTS[y, x] / 1e3 for y in range(6) for x in range(8)]
    return "\n".join([*head, *(f"{n % 8} {n // 8} {z}" for n, z in enumerate(values)), "#", ""])


def test_zygo_xyz_of_format_1(read, refused):
    height = read(zygo("2e-06"))
    right = np.where((np.arange(8) == 3) & (np.arange(6)[:, None] == 2), np.nan, 1e-9 * COUNTS)
    np.testing.assert_allclose(height.values, right, rtol=1e-12)
    assert steps(height) == pytest.approx([2e-6, 2e-6])
    refused(zygo("0"), "give dx, dy, unit")  # a camera that was not calibrated
    refused("\n".join(zygo("2e-06").split("\n")[:-10]), "40 lines of points where the header needs 8 x 6")


def test_a_plain_workbook_is_named_with_its_sheets(tmp_path):
    for name in ("A & B", "DATA"):  # that of Mitutoyo's heights
        with zipfile.ZipFile(tmp_path / "map.xlsx", "w") as book:
            book.writestr("xl/workbook.xml", f'<sheet name="{name.replace("&", "&amp;")}" sheetId="1"/>')
        refuses(rf"save the sheet with the heights as CSV .*: '{name}'\)", tmp_path / "map.xlsx")


def test_a_map_of_three_axes_is_chosen_by_its_index(tmp_path):
    values = 1e-9 * np.stack([COUNTS, 2 * COUNTS, 3 * COUNTS])
    scans = labelled(values, name="z")
    for path, dims in ((tmp_path / "first.nc", ("t", "y", "x")), (tmp_path / "last.nc", ("y", "x", "t"))):
        scans.transpose(*dims).to_netcdf(path)
        np.testing.assert_allclose(read_height_map(path, channel="z[t=2]").values, values[2], rtol=1e-12)
        assert "'z[t=0]', the first height channel of 3, was read" in warnings_of(read_height_map(path))
    scipy.io.savemat(tmp_path / "map.mat", {"z": values.transpose(1, 2, 0)})
    given = {"dx": 1, "dy": 1, "unit": "m"}
    second = read_height_map(tmp_path / "map.mat", channel="z(:,:,2)", **given)
    np.testing.assert_allclose(second.values, values[1], rtol=1e-12)


def test_images_of_gwyddion_in_other_units_and_under_a_mask(read, tmp_path):
    path = saved(tmp_path, gwy({"a": (HEIGHTS, "V"), "b": (HEIGHTS, "")}, SIZE))
    refuses(r"\('a': values in V, .*'b': values in no unit.* height_unit", path)
    refuses(r"channel 'a' holds no heights .* give height_unit", path, channel="a")
    asked = read_height_map(path, channel="a", height_unit="m")
    np.testing.assert_allclose(asked.values[::-1], HEIGHTS, rtol=1e-12)
    listed = inspect_file(saved(tmp_path, gwy({"a": (HEIGHTS, "V"), "b": (HEIGHTS, "m")}, SIZE)))
    assert [(each["name"], each["height_unit"]) for each in listed["channels"]] == [("a", "V"), ("b", "m")]
    assert listed["channel"] == "b"
    by_name = read(gwy({"Error": (HEIGHTS, "m"), "b": (HEIGHTS, "m")}, SIZE))
    assert by_name.attrs["channel"] == "b"
    twice = saved(
        tmp_path, gwy({"a": (HEIGHTS, "m"), "b": (2 * HEIGHTS, "m")}, SIZE).replace(b"sb\0", b"sa\0")
    )
    assert json.loads(read_height_map(twice).attrs["channels"]) == ["a", "a (2)"]
    np.testing.assert_allclose(read_height_map(twice, channel="a (2)").values[::-1], 2 * HEIGHTS, rtol=1e-12)
    masked = read(gwy({"a": (HEIGHTS, "m")}, SIZE, [COUNTS > 8000]))
    assert masked.attrs["missing_points"] == int((COUNTS > 8000).sum()) > 0
    assert "the mask in the file was applied" in warnings_of(masked)


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
