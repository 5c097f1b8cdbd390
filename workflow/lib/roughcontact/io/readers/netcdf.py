"""NetCDF: each variable over two axes, in the units that it and its coordinates carry.

Row j is the j-th y; row 0 is the lowest line.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io.channels import (
    Channel,
    MeasuredFile,
    UnevenPositionsError,
    as_heights,
    even_step,
    scattered,
    unreadable,
)
from roughcontact.io.guards import brief, check_points
from roughcontact.io.interface import Reader, ToldBy
from roughcontact.io.metadata import instrument_words
from roughcontact.io.units import is_length

_CLASSIC = (b"CDF\x01", b"CDF\x02")  # the second one with offsets of 64 bits
_MARKS = (*_CLASSIC, b"CDF\x05", b"\x89HDF\r\n\x1a\n")


def recognises(path: Path, head: bytes) -> bool:
    r"""Return whether a file begins as netCDF does; HDF5 of other kinds is told by its contents before.

    Examples
    --------
    >>> recognises(Path("map.dat"), b"CDF\x01"), recognises(Path("map.nc"), b"\x89HDF")
    (True, False)
    """
    return head.startswith(_MARKS)


def read(path: Path) -> MeasuredFile:
    """Open a netCDF file; a map that this project wrote comes back as it was.

    Parameters
    ----------
    path : Path

    Returns
    -------
    MeasuredFile
        One channel for each variable over two axes (y, x), or over one that is no time or load; those called
        height, heights or z first.

    Raises
    ------
    InputFileError
        For a file that is damaged, cut off, or has no such variable.
    """
    import xarray as xr

    with path.open("rb") as stream:
        classic = stream.read(4) in _CLASSIC
    # In a classic file that was cut off, the netCDF library reads zeros; SciPy misses the bytes.
    engine = "scipy" if classic else "netcdf4"
    try:
        dataset = xr.open_dataset(path, engine=engine, decode_times=False, decode_timedelta=False)
    except (OSError, ValueError, RuntimeError, TypeError, IndexError, KeyError) as error:
        raise InputFileError(f"{path}: damaged or cut off netCDF file ({brief(error)})") from error
    with dataset:
        variables = (_variable(dataset, name, path) for name in dataset.data_vars)
        channels = [channel for channel in variables if channel is not None]
        attributes = dict(dataset.attrs)
        own = dataset["height"].attrs if "height" in dataset else {}
    if not channels:
        raise InputFileError(
            f"{path}: no variable over two axes (y, x) in this netCDF file; "
            f"it has {sorted(map(str, dataset.variables))}"
        )
    channels.sort(key=lambda channel: channel.name not in ("height", "heights", "z"))
    return MeasuredFile(
        "netCDF",
        channels,
        # a file of this project says how the measured file was drawn, and measured with what
        first_row="top" if own.get("first_row") == "top" else "bottom",
        instrument=_instrument(own.get("instrument"), attributes),
    )


def _instrument(own: Any, attributes: dict) -> dict:
    """Return what this project wrote of the instrument, else what the attributes of the file say of it."""
    try:
        stated = json.loads(own)
    except (TypeError, ValueError):
        stated = None
    return stated if isinstance(stated, dict) else instrument_words({}, attributes)


def _variable(dataset: Any, name: Any, path: Path) -> Channel | None:
    """Return one variable as a channel, None where it is no map or profile."""
    variable = dataset[name]
    dims = _axes(variable)
    if dims is None:
        return None
    y, x = dims
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
    words: dict[str, Any] = {"height_unit": unit, "lateral_unit": unit_x or unit_y, "no_height": no_height}
    if variable.dtype.kind not in "iuf":
        refused = f"{path}: variable {name!r} holds {no_height}, not real numbers"
        return Channel(str(name), (ny, nx), unreadable(refused), **words)
    kept = [axis for axis in dims if axis is not None]
    values = variable.squeeze([axis for axis in variable.dims if axis not in kept]).transpose(*kept).values
    values = as_heights(values, str(path))
    if str(variable.attrs.get("positive", "")).lower() == "down":  # CF's word for depths
        values = -values
        words["notes"] = [f"the file counts {name!r} positive downwards: its sign was changed"]
    try:
        dx, first_x, backwards_x = _axis(dataset, x)
        dy, first_y, backwards_y = _axis(dataset, y)
    except UnevenPositionsError as error:
        return _off_grid(dataset, str(name), dims, values, error, path, words)
    values = values[:: -1 if backwards_y else 1, :: -1 if backwards_x else 1]
    return Channel(
        str(name),
        (ny, nx),
        values.copy,
        dx=dx,
        dy=dy,
        first_x=first_x,
        first_y=first_y,
        **words,
    )


def _axes(variable: Any) -> tuple[str | None, str] | None:
    """Return the axes (y, x) of a variable, y None for a profile; None where it is neither."""
    dims = list(variable.dims)
    for axis in variable.dims:  # a time or load axis of one entry is no axis of a map
        if len(dims) > 2 and variable.sizes[axis] == 1:
            dims.remove(axis)
    if len(dims) not in (1, 2) or 0 in variable.shape or (len(dims) == 1 and dims[0] in ("load", "time")):
        return None
    if len(dims) == 1:
        return None, dims[0]
    if dims[0].lower().startswith("x") and dims[1].lower().startswith("y"):
        dims.reverse()
    return dims[0], dims[1]


def _off_grid(
    dataset: Any,
    name: str,
    dims: tuple[str | None, str],
    values: np.ndarray,
    error: UnevenPositionsError,
    path: Path,
    words: dict[str, Any],
) -> Channel:
    """Return the points of a map whose coordinates are not evenly spaced."""
    y, x = (dataset[axis].values if axis in dataset.coords else None for axis in dims)
    if x is None or (y is None and dims[0] is not None):
        raise InputFileError(f"{path}: {error}, and the other axis has no positions") from error
    if y is not None:
        y, x = np.meshgrid(y, x, indexing="ij")
    return scattered(name, x, y, values, error, **words)


def _unit(variable: Any) -> str | None:
    """Return what a variable says of its unit, None where it says nothing."""
    unit = variable.attrs.get("units", variable.attrs.get("unit"))
    return None if unit is None or not str(unit).strip() else str(unit)


def _axis(dataset: Any, name: str | None) -> tuple[float | None, float | None, bool]:
    """Return step, first position, and whether the axis runs backwards, of a coordinate."""
    if name is None or name not in dataset.coords or dataset[name].dtype.kind not in "iuf":
        return None, None, False
    positions = dataset[name].values.astype(float)
    if positions.size == 1:
        return None, float(positions[0]), False
    step = even_step(positions, name)
    return abs(step), float(min(positions[0], positions[-1])), step < 0


READER = Reader(ToldBy.MARK, recognises, read)
