"""NetCDF: each variable with two axes, in the units of the variable and its coordinates.

Row 0 is the line of the smallest y; without positions it is assumed to be the lowest one.
"""

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io import classic, hdf5
from roughcontact.io.channels import (
    Channel,
    MeasuredFile,
    UnevenPositionsError,
    as_heights,
    even_step,
    oversized,
    scattered,
    unreadable,
)
from roughcontact.io.guards import MAX_POINTS, check_points, refusing
from roughcontact.io.interface import Reader, RecognisedBy, begins_with, head_of
from roughcontact.io.metadata import instrument_metadata
from roughcontact.io.seal import check_seal
from roughcontact.io.units import same_length
from roughcontact.si import unit_of

_SCIPY = (b"CDF\x01", b"CDF\x02")  # read without the netCDF library


def read(path: Path) -> MeasuredFile:
    """Open a netCDF file; a map that this project wrote is restored unchanged.

    There is one channel for each variable over two axes (y, x), or one that is no time, load or peak of the
    load, and for each index of a third; those named height, heights or z come first.
    """
    head = head_of(path)
    sealed = check_seal(path)
    required_size = classic.check_header(path) if head.startswith(classic.MARKS) else hdf5.stated_size(path)
    arrays = hdf5.datasets(path) if head.startswith(hdf5.MARK) else {}
    engine = "scipy" if head.startswith(_SCIPY) else "netcdf4"
    too_long = {} if engine == "scipy" else _oversized_variables(path)
    with _opened(path, engine, too_long) as dataset:
        opener = partial(_opened, path, engine, too_long)
        channels = [
            _variable(dataset, name, axes, selection, opener)
            for name in dataset.data_vars
            for axes, selection in _maps(dataset[name])
        ]
        attributes = dict(dataset.attrs)
        height_attrs = dict(dataset["height"].attrs) if "height" in dataset else {}
        names = sorted(map(str, dataset.variables))
    channels += [oversized(name, shape) for name, shape in too_long.items()]
    if not channels:
        raise InputFileError(_no_map_message(arrays, names))
    channels.sort(key=lambda channel: channel.name.partition("[")[0] not in ("height", "heights", "z"))
    return MeasuredFile(
        "netCDF",
        channels,
        first_row="bottom",
        instrument=_instrument(height_attrs.get("instrument"), attributes),
        required_size=required_size and required_size + sealed,
    )


@contextmanager
def _opened(path: Path, engine: Any, left_out: Iterable[str]) -> Iterator[Any]:
    """Open a file as a dataset; errors, also those within the block, are raised as `InputFileError`."""
    import xarray as xr

    with (
        refusing("damaged or cut off netCDF file"),
        xr.open_dataset(
            path, engine=engine, decode_times=False, decode_timedelta=False, drop_variables=list(left_out)
        ) as dataset,
    ):
        yield dataset


def _oversized_variables(path: Path) -> dict[str, tuple[int, ...]]:
    """Return the shapes of variables above the size limit, since opening alone would read coordinates."""
    import netCDF4

    with refusing("damaged or cut off netCDF file"), netCDF4.Dataset(path) as file:
        shapes = {name: tuple(variable.shape) for name, variable in file.variables.items()}
    return {name: shape for name, shape in shapes.items() if prod(shape) > MAX_POINTS}


def _no_map_message(arrays: dict[str, tuple[int, ...]], names: list[str]) -> str:
    """Return the error message for a file without a map."""
    if arrays:
        listed = ", ".join(
            f"{name} ({' x '.join(map(str, shape)) or '1'})" for name, shape in sorted(arrays.items())[:5]
        )
        remainder = f" and {len(arrays) - 5} more" if len(arrays) > 5 else ""
        return (
            f"an HDF5 file, but neither netCDF nor one of Zygo's or JPK's, so that nothing says "
            f"which of its arrays are heights; it has {listed}{remainder}; save the heights as .npy or netCDF"
        )
    if not names:
        return "an empty netCDF or HDF5 file: it has no variable at all"
    return f"no variable over two axes (y, x) in this netCDF file; it has {', '.join(names)}"


def _instrument(height_attrs: Any, attributes: dict) -> dict:
    """Return the instrument metadata that this project wrote, otherwise those in the file attributes."""
    try:
        stated = json.loads(height_attrs)
    except (TypeError, ValueError, RecursionError):
        stated = None
    return stated if isinstance(stated, dict) else instrument_metadata({}, attributes)


def _variable(
    dataset: Any,
    name: Any,
    dims: tuple[str | None, str],
    selection: dict[str, int],
    opener: Callable[[], Any],
) -> Channel:
    """Return one variable, at some index of its other axes, as a channel that is read on demand."""
    variable = dataset[name]
    label = str(name) + "".join(
        f"[{axis}={index}]" for axis, index in selection.items() if variable.sizes[axis] > 1
    )
    y, x = dims
    shape = variable.sizes[y] if y else 1, variable.sizes[x]
    if prod(shape) > MAX_POINTS:
        return oversized(label, shape)
    unit_x, unit_y = (unit_of(dataset[axis].attrs) if axis in dataset.coords else None for axis in (x, y))
    if unit_x and unit_y and not same_length(unit_x, unit_y):
        raise InputFileError(f"the axes {x} and {y} have different units, {unit_x!r} and {unit_y!r}")
    positive_down = str(variable.attrs.get("positive", "")).lower() == "down"  # the CF convention for depths

    def read(turned: Any = ...) -> np.ndarray:
        """Return the values over the axes, with the sign of heights, and reversed axes flipped."""
        with opener() as again:
            stored = again[name].isel(selection)
            check_points((1, prod(stored.shape)))
            values = as_heights(stored.transpose(*filter(None, dims)).values)[turned].copy()
            low, high = _valid_range(stored)
            values[(values < low) | (values > high)] = np.nan
        return -values if positive_down else values

    channel = Channel(label, shape, read, unit_of(variable.attrs), lateral_unit=unit_x or unit_y)
    positions = [axis for axis in "xy" if axis in dataset and dataset[axis].dims == variable.dims != (axis,)]
    if variable.dtype.kind not in "iuf":
        channel.no_height = f"values of type {variable.dtype}"
        channel.read = unreadable(f"variable {name!r} holds {channel.no_height}, not real numbers")
        return channel
    if positions and name not in positions:
        channel.doubt = (
            f"the positions {' and '.join(positions)} of {name!r} are variables over its axes; make "
            "them coordinates of a grid, or save the points as text x, y, z"
        )
        channel.read = unreadable(channel.doubt)
        return channel
    if positive_down:
        channel.notes = [f"the file counts {name!r} positive downwards: its sign was changed"]
    try:
        along_x, along_y = _axis(dataset, x), _axis(dataset, y)
    except UnevenPositionsError as error:
        return channel if channel.no_height else _off_grid(dataset, dims, channel, error)
    (channel.dx, channel.first_x, backwards_x), (channel.dy, channel.first_y, backwards_y) = along_x, along_y
    channel.read = partial(read, np.s_[:: -1 if backwards_y else 1, :: -1 if backwards_x else 1])
    channel.first_row = "" if channel.first_y is not None else "bottom"  # assumed without positions
    return channel


def _valid_range(variable: Any) -> np.ndarray:
    """Return the lowest and the highest value that is no missing point (NetCDF Users Guide, appendix A).

    Limits of the type of packed values are packed too; half a step of these is allowed for rounding.
    """
    stated, packing = variable.attrs, variable.encoding
    with refusing(f"the valid_range, valid_min or valid_max of {variable.name!r} is no number"):
        low, high = stated.get(
            "valid_range", (stated.get("valid_min", -np.inf), stated.get("valid_max", np.inf))
        )
        limits = np.array([low, high], dtype=float)
    scale = packing.get("scale_factor", 1.0)
    if any(np.asarray(limit).dtype.kind in "iu" for limit in (low, high)):
        limits = np.sort(limits * scale + packing.get("add_offset", 0.0))
    return limits + np.array([-0.5, 0.5]) * (np.abs(scale) if "scale_factor" in packing else 0.0)


def _maps(variable: Any) -> Iterator[tuple[tuple[str | None, str], dict[str, int]]]:
    """Yield the axes (y, x) of each map or profile of a variable, y None for a profile, and its index.

    An axis of one entry is none of a map, and so is one of loads or their peaks; of three axes the others
    than y and x, by their names or as the last two, count the maps.
    """
    dims = list(variable.dims)
    selection = {}
    for axis in variable.dims:
        if len(dims) > 2 and variable.sizes[axis] == 1:
            dims.remove(axis)
            selection[axis] = 0
    if len(dims) not in (1, 2, 3) or 0 in variable.shape or "load" in dims or dims in (["time"], ["peak"]):
        return
    if len(dims) == 1:
        yield (None, dims[0]), selection
        return
    named = [axis for axis in dims if str(axis).lower().startswith(("x", "y"))]
    plane = named if len(named) == 2 else dims[-2:]
    if plane[0].lower().startswith("x") and plane[1].lower().startswith("y"):
        plane = plane[::-1]
    count = next((axis for axis in dims if axis not in plane), None)
    for index in range(variable.sizes[count] if count else 1):
        yield (plane[0], plane[1]), selection | ({count: index} if count else {})


def _off_grid(
    dataset: Any, dims: tuple[str | None, str], channel: Channel, error: UnevenPositionsError
) -> Channel:
    """Return a channel as the points of a map whose coordinates are not evenly spaced."""
    y, x = (dataset[axis].values if axis in dataset.coords else None for axis in dims)
    if x is None or (y is None and dims[0] is not None):
        raise InputFileError(f"{error}, and the other axis has no positions") from error
    if y is not None:
        y, x = np.meshgrid(y, x, indexing="ij")
    return scattered(channel, x, y, channel.read(), error)


def _axis(dataset: Any, name: str | None) -> tuple[float | None, float | None, bool]:
    """Return step and first position of a coordinate, and whether the axis is reversed."""
    if name is None or name not in dataset.coords or dataset[name].dtype.kind not in "iuf":
        return None, None, False
    positions = dataset[name].values.astype(float)
    if positions.size == 1:
        return None, float(positions[0]), False
    step = even_step(positions, name)
    return abs(step), float(min(positions[0], positions[-1])), step < 0


READER = Reader(RecognisedBy.MARK, begins_with(*classic.MARKS, hdf5.MARK), read)
