"""Files of scientific Python: NumPy arrays and netCDF. Row j is the j-th y; row 0 is the lowest line."""

from pathlib import Path

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.guards import brief, check_points
from roughcontact.io.source import Channel, SourceFile, as_heights, even_step
from roughcontact.io.units import is_length


def read_npy(path: Path) -> SourceFile:
    """Open a `.npy` file of one real array, (ny, nx) or (nx,), without pickle and without units."""
    try:
        values = np.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as error:  # NumPy parses the header as Python text and may fail in any way of the parser
        raise InputFileError(
            f"{path}: not readable as a NumPy array ({brief(error)}); "
            "save a plain float64 array with numpy.save"
        ) from error
    shape = (1, *values.shape) if values.ndim == 1 else values.shape
    if len(shape) != 2 or 0 in shape:
        raise InputFileError(
            f"{path}: an array of shape {values.shape}; a map has two axes (y, x), a profile one"
        )
    check_points(shape, path)
    kind = "" if values.dtype.kind in "iuf" else f"values of type {values.dtype}, not real numbers"
    channel = Channel("height", shape, lambda: as_heights(values, str(path)), no_height=kind)
    return SourceFile("NumPy array", [channel], first_row="bottom")


def read_netcdf(path: Path) -> SourceFile:
    """Open a netCDF file: each variable over two axes, with the units that it and its coordinates carry."""
    import xarray as xr

    with open(path, "rb") as stream:
        classic = stream.read(4) in (b"CDF\x01", b"CDF\x02")
    # In a classic file that was cut off, the netCDF library reads zeros; SciPy misses the bytes.
    engine = "scipy" if classic else "netcdf4"
    try:
        dataset = xr.open_dataset(path, engine=engine, decode_times=False, decode_timedelta=False)
    except (OSError, ValueError, RuntimeError, TypeError, IndexError, KeyError) as error:
        raise InputFileError(f"{path}: damaged or cut off netCDF file ({brief(error)})") from error
    with dataset:
        channels = [
            channel for name in dataset.data_vars if (channel := _variable(dataset, name, path)) is not None
        ]
        attributes = {
            key: str(value) for key, value in dataset.attrs.items() if isinstance(value, str | int | float)
        }
    if not channels:
        raise InputFileError(
            f"{path}: no variable over two axes (y, x) in this netCDF file; "
            f"it has {sorted(map(str, dataset.variables))}"
        )
    instrument = {key: attributes[key] for key in ("instrument", "title", "history") if key in attributes}
    channels.sort(key=lambda channel: channel.name not in ("height", "heights", "z"))
    return SourceFile("netCDF", channels, first_row="bottom", instrument=instrument)


def _variable(dataset, name, path):
    variable = dataset[name]
    long = [axis for axis in variable.dims if variable.sizes[axis] != 1]
    dims = list(variable.dims)
    for axis in list(dims):  # a time or load axis of one entry is no axis of a map
        if len(dims) > 2 and axis not in long:
            dims.remove(axis)
    if len(dims) not in (1, 2) or 0 in variable.shape or (len(dims) == 1 and dims[0] in ("load", "time")):
        return None
    if len(dims) == 2 and dims[0].lower().startswith("x") and dims[1].lower().startswith("y"):
        dims.reverse()
    x, y = dims[-1], dims[0] if len(dims) == 2 else None
    ny, nx = variable.sizes[y] if y else 1, variable.sizes[x]
    check_points((ny, nx), path)
    unit = _unit(variable)
    no_height = ""
    if variable.dtype.kind not in "iuf":
        no_height = f"values of type {variable.dtype}"
    elif unit is not None and not is_length(unit):
        no_height = f"values in {unit!r}, no length"
    dx, first_x, backwards_x, unit_x = _axis(dataset, x, path)
    dy, first_y, backwards_y, unit_y = _axis(dataset, y, path) if y else (None, None, False, None)
    if unit_x and unit_y and unit_x != unit_y:
        raise InputFileError(f"{path}: the axes {x} and {y} have different units, {unit_x!r} and {unit_y!r}")
    values = None
    if not no_height:
        values = (
            variable.squeeze([axis for axis in variable.dims if axis not in dims]).transpose(*dims).values
        )
        values = np.atleast_2d(values)[:: -1 if backwards_y else 1, :: -1 if backwards_x else 1].copy()
    return Channel(
        name=str(name),
        shape=(ny, nx),
        read=lambda: as_heights(values, str(path)),
        height_unit=unit,
        dx=dx,
        dy=dy,
        lateral_unit=unit_x or unit_y,
        first_x=first_x,
        first_y=first_y,
        no_height=no_height,
    )


def _unit(variable):
    unit = variable.attrs.get("units", variable.attrs.get("unit"))
    return None if unit is None or not str(unit).strip() else str(unit)


def _axis(dataset, name, path):
    """Return step, first position, whether the axis runs backwards, and the unit, of a coordinate."""
    if name not in dataset.coords or dataset[name].dtype.kind not in "iuf":
        return None, None, False, None
    positions = dataset[name].values.astype(float)
    unit = _unit(dataset[name])
    if positions.size == 1:
        return None, float(positions[0]), False, unit
    step = even_step(positions, name, str(path))
    return abs(step), float(min(positions[0], positions[-1])), step < 0, unit
