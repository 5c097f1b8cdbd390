"""Files of measured maps by the published descriptions of their formats, and what is read from them."""

import hashlib
import io
import json
import struct
import zipfile

import h5py
import numpy as np
import pytest
import scipy.io
import x3pio
import xarray as xr

from roughcontact import InputFileError, read_height_map

GIVEN = {"dx": 1, "dy": 1, "unit": "um"}
_AXES = (("y", -2), ("x", -1))


def saved(folder, content, name="map.dat", encoding="utf-8"):
    """Write a file of bytes, or of a text; its name says nothing."""
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
    return folder / name


def refuses(words, path, *, error=InputFileError, **arguments):
    """Require that a file is refused in a sentence with such words, and return it."""
    with pytest.raises(error, match=words) as caught:
        read_height_map(path, **arguments)
    return str(caught.value)


def holds(height, heights, *spacing, rtol=1e-15):
    """Require such heights (m; the lowest row first), and steps (m) along x, and along y."""
    np.testing.assert_allclose(height.values, heights, rtol=rtol)
    assert not spacing or steps(height) == pytest.approx(spacing, rel=1e-9)


def warnings_of(height):
    """Return the warnings of reading in one text."""
    return " | ".join(json.loads(height.attrs["ingest_warnings"]))


def steps(height):
    """Return the steps (m) along x, and along y of a map."""
    return [float(height[axis][1] - height[axis][0]) for axis in "xy" if height.sizes[axis] > 1]


def cells(rows, separator="\t", form="{:g}"):
    """Return a table as text."""
    return "".join(separator.join(map(form.format, row)) + "\n" for row in rows)


def points(heights, dx=1.0, dy=1.0):
    """Return a list of points: x, y and height."""
    y, x = np.indices(heights.shape)
    return np.column_stack([dx * x.ravel(), dy * y.ravel(), heights.ravel()])


def labelled(heights, unit="m", name="height", **attrs):
    """Return heights (..., y, x) with positions 1 µm apart."""
    axes = {axis: (axis, 1e-6 * np.arange(heights.shape[index]), {"units": "m"}) for axis, index in _AXES}
    dims = ("t", "y", "x")[-heights.ndim :]
    return xr.DataArray(heights, axes, dims, name, {"units": unit} | attrs)


def archive(members):
    """Return a ZIP archive with the content of its members by their names."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in members.items():
            packed.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)  # of 1980, whenever
    return stream.getvalue()


def members(packed):
    """Return the content of the members of an archive by their names."""
    with zipfile.ZipFile(io.BytesIO(packed)) as opened:
        return {name: opened.read(name) for name in opened.namelist()}


def array(heights):
    """Return a file of NumPy."""
    stream = io.BytesIO()
    np.save(stream, heights)
    return stream.getvalue()


def matlab(variables, **options):
    """Return a file of MATLAB."""
    stream = io.BytesIO()
    scipy.io.savemat(stream, variables, **options)
    return stream.getvalue()


def x3p(heights, dx=1e-6, dy=1e-6, *, edit=None, restate=True, folder="", **options):
    """X3P, perhaps in a folder of its archive; `edit` changes main.xml, with its checksum or against it."""
    stream = io.BytesIO()
    x3pio.write(stream, heights, x_scale=dx, **({"y_scale": dy} if np.ndim(heights) > 1 else {}), **options)
    content = members(stream.getvalue())
    main = content["main.xml"]
    edited = edit(main) if edit else main
    digest = hashlib.md5(edited if restate else main).hexdigest().encode()
    content |= {"main.xml": edited, "md5checksum.hex": digest + b" *main.xml"}
    return archive({folder + name: part for name, part in content.items()})


def sdf(counts, dx, dy, dz, mark="aISO-1.0"):
    """ISO 25178-71 in ASCII: whole numbers of dz (m), by its published description."""
    ny, nx = counts.shape
    header = [mark, "ManufacID = maker", "CreateDate = 010120200000", "ModDate = 010120200000"]
    header += [
        f"NumPoints = {nx}",
        f"NumProfiles = {ny}",
        f"Xscale = {dx}",
        f"Yscale = {dy}",
        f"Zscale = {dz}",
    ]
    header += ["Zresolution = -1", "Compression = 0", "DataType = 6", "CheckType = 0", "*"]
    return "\n".join([*header, *map(str, np.rint(counts).astype(int).ravel()), "*", "*", ""])


def tmd(heights, size, comment=b"", version=b"v2.0"):
    """TrueMap: heights and size (along x, y) in mm."""
    header = struct.pack("<2I4f", *heights.shape[::-1], *size, 0, 0)
    mark = b"Binary TrueMap Data File " + version + b"\r\n\0"
    return mark + comment + b"\0" + header + heights.astype("<f4").tobytes()


def gsf(heights, **entries):
    """Gwyddion Simple Field: header, zeros to a multiple of four, 4-byte floats."""
    sizes = dict(zip(("YRes", "XRes"), heights.shape, strict=True)) | {"XYUnits": "m", "ZUnits": "m"}
    lines = [f"{key} = {value}" for key, value in (sizes | entries).items() if value is not None]
    header = "\n".join(["Gwyddion Simple Field 1.0", *lines, ""]).encode()
    return header + bytes(4 - len(header) % 4) + heights.astype("<f4").tobytes()


def gwy(images, size, masks=()):
    """Gwyddion: objects of named, typed components; images are by title: heights and their unit."""

    def packed(name, components):
        data = b"".join(key.encode() + b"\0" + value for key, value in components.items())
        return name.encode() + b"\0" + struct.pack("<I", len(data)) + data

    def field(values, unit):
        lengths = dict(zip(("xreal", "yreal"), size, strict=True))
        numbers = {key: b"d" + struct.pack("<d", length) for key, length in lengths.items()}
        points = dict(zip(("yres", "xres"), values.shape, strict=True))
        numbers |= {key: b"i" + struct.pack("<i", count) for key, count in points.items()}
        for key, text in (("si_unit_xy", "m"), ("si_unit_z", unit)):
            numbers[key] = b"o" + packed("GwySIUnit", {"unitstr": b"s" + text.encode() + b"\0"})
        data = b"D" + struct.pack("<I", values.size) + values.astype("<f8").tobytes()
        return b"o" + packed("GwyDataField", numbers | {"data": data})

    container = {}
    for number, (title, (values, unit)) in enumerate(images.items()):
        container[f"/{number}/data"] = field(values, unit)
        container[f"/{number}/data/title"] = b"s" + title.encode() + b"\0"
    container |= {f"/{number}/mask": field(mask, "") for number, mask in enumerate(masks)}
    return b"GWYP" + packed("GwyContainer", container)


def keyence(counts, dx, dy, scale):
    """VK4: offsets from byte 12, steps and scale (pm) from 252."""
    ny, nx = counts.shape
    head = bytearray(600)
    head[:12] = b"VK4_\0\0\0\0\0\0\0\0"
    struct.pack_into("<I", head, 12 + 4 * 6, len(head))  # of the first image of heights
    struct.pack_into("<7I", head, 84, 300, 2020, 5, 17, 12, 30, 0)
    struct.pack_into("<3I", head, 252, dx, dy, scale)
    image = struct.pack("<7I", nx, ny, 32, 0, 4 * nx * ny, 0, 2**32 - 1) + bytes(768)
    return bytes(head) + image + counts.astype("<u4").tobytes()


JPK_CHANNEL = ("measuredHeight", "Height (measured)", 1e-12, 0.0, "m")


def jpk(counts, channels=(JPK_CHANNEL,), **grid):
    """JPK in HDF5: counts (points, frames); of a channel name, label, scale, offset and unit."""
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        file.attrs["file-format-info"] = np.bytes_("JPK SCAN")
        measurement = file.create_group("Measurement_000")
        for name, value in ({"theta": 0.0} | grid).items():
            measurement.attrs[f"position-pattern.grid.{name}"] = value
        measurement.attrs["environment.cantilever-calibration-info.cantilever-name"] = np.bytes_("USC")
        for number, (name, label, scale, offset, unit) in enumerate(channels):
            channel = measurement.create_group(f"Channel_{number:03}")
            texts = {"channel.name": name, "channel.fancy-name": label, "net-encoder.scaling.unit.unit": unit}
            texts["retrace"] = "true" if number % 2 else "false"
            channel.attrs.update({key: np.bytes_(text) for key, text in texts.items()})
            channel.attrs["net-encoder.scaling.multiplier"] = scale
            channel.attrs["net-encoder.scaling.offset"] = offset
            channel["Counts"] = counts
            channel["thumbnail"] = np.zeros((4, 1), dtype=np.int32)
    return stream.getvalue()
