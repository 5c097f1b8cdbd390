"""Files of scientific Python: NumPy arrays and netCDF. Row j is the j-th y; row 0 is the lowest line."""

import json
from pathlib import Path

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import Channel, SourceFile, UnevenPositions, as_heights, even_step, scattered
from roughcontact.io.guards import brief, check_points
from roughcontact.io.metadata import instrument_words
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
        attributes = dict(dataset.attrs)
        own = dataset["height"].attrs if "height" in dataset else {}
    if not channels:
        raise InputFileError(
            f"{path}: no variable over two axes (y, x) in this netCDF file; "
            f"it has {sorted(map(str, dataset.variables))}"
        )
    channels.sort(key=lambda channel: channel.name not in ("height", "heights", "z"))
    return SourceFile(
        "netCDF",
        channels,
        # a file of this project says how its own source was drawn, and measured with what
        first_row="top" if own.get("first_row") == "top" else "bottom",
        instrument=_instrument(own.get("instrument"), attributes),
    )


def _instrument(own, attributes) -> dict:
    """Return what this project wrote of the instrument, else what the attributes of the file say of it."""
    try:
        stated = json.loads(own)
    except (TypeError, ValueError):
        stated = None
    return stated if isinstance(stated, dict) else instrument_words({}, attributes)


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
    unit_x, unit_y = (_unit(dataset[axis]) if axis in dataset.coords else None for axis in (x, y))
    if unit_x and unit_y and unit_x != unit_y:
        raise InputFileError(f"{path}: the axes {x} and {y} have different units, {unit_x!r} and {unit_y!r}")
    words = {"height_unit": unit, "lateral_unit": unit_x or unit_y, "no_height": no_height}
    if variable.dtype.kind not in "iuf":
        return Channel(str(name), (ny, nx), lambda: None, **words)
    values = variable.squeeze([axis for axis in variable.dims if axis not in dims]).transpose(*dims).values
    values = as_heights(values, str(path))
    if str(variable.attrs.get("positive", "")).lower() == "down":  # CF's word for depths
        values = -values
        words["notes"] = [f"the file counts {name!r} positive downwards: its sign was changed"]
    try:
        dx, first_x, backwards_x = _axis(dataset, x)
        dy, first_y, backwards_y = _axis(dataset, y)
    except UnevenPositions as error:
        return _off_grid(dataset, str(name), (y, x), values, error, path, words)
    values = values[:: -1 if backwards_y else 1, :: -1 if backwards_x else 1]
    return Channel(
        str(name),
        (ny, nx),
        lambda: values.copy(),
        dx=dx,
        dy=dy,
        first_x=first_x,
        first_y=first_y,
        **words,
    )


def _off_grid(dataset, name, dims, values, error, path, words):
    """Return the points of a map whose coordinates are not evenly spaced."""
    y, x = (dataset[axis].values if axis in dataset.coords else None for axis in dims)
    if x is None or (y is None and dims[0] is not None):
        raise InputFileError(f"{path}: {error}, and the other axis has no positions") from error
    if y is not None:
        y, x = np.meshgrid(y, x, indexing="ij")
    return scattered(name, x, y, values, error, **words)


def _unit(variable):
    unit = variable.attrs.get("units", variable.attrs.get("unit"))
    return None if unit is None or not str(unit).strip() else str(unit)


def _axis(dataset, name):
    """Return step, first position, and whether the axis runs backwards, of a coordinate."""
    if name not in dataset.coords or dataset[name].dtype.kind not in "iuf":
        return None, None, False
    positions = dataset[name].values.astype(float)
    if positions.size == 1:
        return None, float(positions[0]), False
    step = even_step(positions, name)
    return abs(step), float(min(positions[0], positions[-1])), step < 0
