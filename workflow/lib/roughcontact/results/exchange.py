"""Results as files of other programs: VTK for ParaView, TIFF, Gwyddion's simple field, workbooks, CalculiX.

Files of maps hold the height of the window and, for each load, pressure, gap and contact, in SI units.
"""

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact.arguments.maps import spacing
from roughcontact.errors import SettingsError
from roughcontact.results.storage import as_words, atomic_write, write_text

_UNITS = {"height": "m", "pressure": "Pa", "gap": "m", "contact": "1"}
_MAX_TIFF_BYTES = 2**32 - 2**20  # bytes, whose places have 32 bits


def write_vti(contact: xr.Dataset, path: str | Path) -> None:
    """Write the maps as VTK image data (XML, appended binary, double precision), a point for each pixel.

    Parameters
    ----------
    contact : Dataset
        of `solve_contact`, or an opened contact.nc, of which one map at a time is in memory.
    path : str or Path

    Notes
    -----
    Point data are called `height`, `pressure`, `gap` and `contact`, the last three with the number of the
    load at the end where there are several (`pressure_1`). The field data `mean_pressure` has the loads (Pa).

    References
    ----------
    .. [1] VTK File Formats, https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html

    Examples
    --------
    >>> import tempfile
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> solved = solve_contact(rough_reference_surface(64), contact_modulus=1.0, mean_pressure=[0.1, 0.2])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_vti(solved, f"{folder}/maps.vti")
    ...     Path(folder, "maps.vti").read_bytes().count(b"<DataArray ")
    8
    """
    height = contact["height"]
    (ny, nx), (dy, dx) = height.shape, spacing(height)
    extent = f"0 {nx - 1} 0 {ny - 1} 0 0"
    origin = f"{float(height['x'][0])!r} {float(height['y'][0])!r} 0"
    has_loads = contact.sizes["load"] > 1
    names = [
        name + (f"_{load + 1}" if load is not None and has_loads else "") for name, load, _ in _maps(contact)
    ]
    loads = contact["mean_pressure"].values
    room = 8 + 8 * height.size  # of a map, its length before it
    arrays = [
        f'<DataArray type="Float64" Name="{name}" format="appended" offset="{number * room}"/>'
        for number, name in enumerate(names)
    ]
    head = (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n'
        # the third axis has one point, and needs a pitch all the same
        f'<ImageData WholeExtent="{extent}" Origin="{origin}" Spacing="{dx!r} {dy!r} {dx!r}">\n'
        f'<FieldData><DataArray type="Float64" Name="mean_pressure" NumberOfTuples="{loads.size}" '
        f'format="ascii">{" ".join(map(repr, loads.tolist()))}</DataArray></FieldData>\n'
        f'<Piece Extent="{extent}"><PointData Scalars="height">\n' + "\n".join(arrays) + "\n"
        "</PointData></Piece>\n</ImageData>\n"
        '<AppendedData encoding="raw">\n_'
    )
    with atomic_write(path, size=len(names) * room) as partial, partial.open("wb") as file:
        file.write(head.encode())
        for _, _, field in _maps(contact):
            file.write(np.uint64(8 * height.size).astype("<u8").tobytes())
            file.write(field.values.astype("<f8").tobytes())
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def write_tiff(contact: xr.Dataset, path: str | Path) -> None:
    """Write the maps as TIFF, single precision, a page for each, the picture of the surface upright.

    Parameters
    ----------
    contact : Dataset
        of `solve_contact`, or an opened contact.nc, of which one map at a time is in memory.
    path : str or Path

    Raises
    ------
    SettingsError
        for maps of more than 4 GB, which no TIFF holds.

    Notes
    -----
    The description of a page has the quantity, its unit and the mean pressure (Pa); the resolution is that of
    the pixels (per centimetre).

    Examples
    --------
    >>> import tempfile
    >>> from PIL import Image
    >>> from roughcontact.contact.solve import solve_contact
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> solved = solve_contact(rough_reference_surface(64), contact_modulus=1.0, mean_pressure=0.1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_tiff(solved, f"{folder}/maps.tiff")
    ...     with Image.open(f"{folder}/maps.tiff") as pages:
    ...         pages.seek(1)
    ...         pages.n_frames, pages.mode, pages.tag_v2[270]
    (4, 'F', 'pressure (Pa) at a mean pressure of 0.1 Pa')
    """
    dy, dx = spacing(contact["height"])
    size = 4 * contact["height"].size * (1 + 3 * contact.sizes["load"])
    if size > _MAX_TIFF_BYTES:  # before anything is written
        raise SettingsError(f"{path}: the maps take {size / 1e9:.3g} GB, a TIFF holds 4 GB: choose .vti")
    with atomic_write(path, size=size) as partial, partial.open("w+b") as stream:
        _write_pages(contact, stream, dy, dx)


def _write_pages(contact: xr.Dataset, stream: BinaryIO, dy: float, dx: float) -> None:
    """Write the maps to a stream that outlives the writer, which returns to it when it is deleted."""
    from PIL import Image
    from PIL.TiffImagePlugin import AppendingTiffWriter, IFDRational, ImageFileDirectory_v2

    file = AppendingTiffWriter(stream)
    for name, load, field in _maps(contact):
        text = f"{name} ({_UNITS[name]})"
        if load is not None:
            text += f" at a mean pressure of {float(contact['mean_pressure'][load]):.6g} Pa"
        tags: Any = ImageFileDirectory_v2()
        tags[270] = text
        # resolution in pixels per cm, code 3
        tags[282], tags[283], tags[296] = IFDRational(1e-2 / dx), IFDRational(1e-2 / dy), 3
        picture = field.values[::-1].astype(np.float32)
        # the first row of a picture is its top
        Image.fromarray(picture).save(file, format="TIFF", tiffinfo=tags)
        file.newFrame()


def write_gsf(values: xr.DataArray, path: str | Path) -> None:
    """Write one map as a Gwyddion simple field, single precision, the picture of the surface upright.

    Parameters
    ----------
    values : DataArray (y, x)
        with evenly spaced coordinates in m; its name and its attribute `units` go into the header.
    path : str or Path

    References
    ----------
    .. [1] Gwyddion user guide, file formats, https://gwyddion.net/documentation/user-guide-en/gsf.html

    Examples
    --------
    >>> import tempfile
    >>> from roughcontact import read_height_map
    >>> from roughcontact.surface.synthetic import rough_reference_surface
    >>> height = rough_reference_surface(64)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_gsf(height, f"{folder}/height.gsf")
    ...     print(abs(read_height_map(f"{folder}/height.gsf") - height.values).max().item() < 1e-8)
    True
    """
    (ny, nx), (dy, dx) = values.shape, spacing(values)
    fields = {
        "XRes": nx,
        "YRes": ny,
        "XReal": nx * dx,
        "YReal": ny * dy,
        # the border of the first pixel, not its middle
        "XOffset": float(values["x"][0]) - dx / 2,
        "YOffset": float(values["y"][0]) - dy / 2,
        "Title": values.name or "map",
        "XYUnits": "m",
        "ZUnits": values.attrs.get("units", ""),
    }
    head = "Gwyddion Simple Field 1.0\n" + "".join(f"{name} = {value}\n" for name, value in fields.items())
    header = head.encode()
    # one to four zeros, so that the numbers begin at a multiple of four
    header += bytes(4 - len(header) % 4)
    with atomic_write(path, size=len(header) + 4 * values.size) as partial:
        partial.write_bytes(header + values.values[::-1].astype("<f4").tobytes())


def write_workbook(sheets: Mapping[str, pd.DataFrame], path: str | Path) -> None:
    """Write tables as a workbook (Office Open XML), a sheet each; those without rows are left out.

    Parameters
    ----------
    sheets : mapping
        name -> DataFrame, with the units in its headings.
    path : str or Path
        ending in .xlsx.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_workbook({"summary": pd.DataFrame({"mean_gap_m": [1e-7]})}, f"{folder}/result.xlsx")
    ...     pd.read_excel(f"{folder}/result.xlsx", sheet_name="summary")["mean_gap_m"].item()
    1e-07
    """
    content = io.BytesIO()
    with pd.ExcelWriter(content, engine="openpyxl") as book:
        for name, frame in sheets.items():
            if len(frame):
                frame.map(as_words).to_excel(book, sheet_name=name, index=False, freeze_panes=(1, 0))
    with atomic_write(path, size=content.tell()) as partial:
        partial.write_bytes(content.getvalue())


def write_contact_law(table: xr.Dataset, path: str | Path) -> None:
    """Write a contact law as rows of CalculiX and Abaqus, in mm, N, s, MPa and mW/(mm2 K), to be included.

    Parameters
    ----------
    table : Dataset
        of `contact_table`.
    path : str or Path

    Notes
    -----
    `*SURFACE BEHAVIOR` has the pressure over what the bodies have come closer, flow included, from where the
    tangent at the lightest load comes to no pressure. `*GAP CONDUCTANCE` has `joint_conductance`, else
    `thermal_conductance`, over the pressure, and its tangent at the lightest load down to no pressure; over
    the mean gap it follows as a comment, since CalculiX would read these rows as pressures.

    Examples
    --------
    >>> import tempfile
    >>> law = {"mean_pressure": [1e6, 2e6], "contact_stiffness": [1e12, 2e12], "approach": [3e-6, 2.4e-6]}
    >>> table = xr.Dataset({name: ("mean_gap", row) for name, row in law.items()})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_contact_law(table, f"{folder}/law.inp")
    ...     print(*Path(folder, "law.inp").read_text().splitlines()[2:6], sep="; ")
    *SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR; 0, 0; 1, 0.001; 2, 0.0016
    """
    pressure, stiffness, approach = (
        table[name].values for name in ("mean_pressure", "contact_stiffness", "approach")
    )
    # the first load is approached from where both faces touch, along its own stiffness
    closer = approach[0] + pressure[0] / stiffness[0] - approach
    lines = [
        "** mm, N, s, MPa, mW/(mm2 K); include it in *SURFACE INTERACTION",
        "** pressure, overclosure from where both faces touch",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR",
        *_rows(np.append(0.0, pressure) * 1e-6, np.append(0.0, closer) * 1e3),
    ]
    names = [name for name in ("joint_conductance", "thermal_conductance") if name in table]
    if names and pressure.size > 1:
        conductance = table[names[0]].values
        slope = (conductance[1] - conductance[0]) / (pressure[1] - pressure[0])
        # extrapolated to no load, below which no conductance is known
        unloaded = max(0.0, conductance[0] - slope * pressure[0])
        is_known = np.append(True, np.isfinite(conductance))
        rows = np.append(unloaded, conductance)[is_known] * 1e-3, np.append(0.0, pressure)[is_known] * 1e-6
        lines += ["** conductance, pressure", "*GAP CONDUCTANCE, PRESSURE", *_rows(*rows)]
        by_gap = _rows(conductance[is_known[1:]] * 1e-3, table["mean_gap"].values[is_known[1:]] * 1e3)
        lines += ["** conductance, mean gap", *(f"** {row}" for row in by_gap)]
    write_text("\n".join(lines) + "\n", path)


def _rows(*columns: np.ndarray) -> list[str]:
    """Return lines of numbers."""
    return [", ".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]


def _maps(contact: xr.Dataset) -> Iterator[tuple[str, int | None, xr.DataArray]]:
    """Yield the maps (y, x), not read yet: name, and index of the load, None for the height."""
    yield "height", None, contact["height"]
    for load in range(contact.sizes["load"]):
        for name in ("pressure", "gap", "contact"):
            yield name, load, contact[name].isel(load=load)
