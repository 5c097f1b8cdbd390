"""NetCDF: each variable with two axes, in the units of the variable and its coordinates.

Row 0 is the line of the smallest y; without positions it is assumed to be the lowest one.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import InputFileError
from roughcontact.io import classic, hdf5
from roughcontact.io.channels import Channel, MeasuredFile, as_heights, oversized, placed, unreadable
from roughcontact.io.guards import MAX_POINTS, refusing
from roughcontact.io.interface import Reader, RecognisedBy, begins_with, head_of
from roughcontact.io.metadata import instrument_metadata, stored_instrument
from roughcontact.io.seal import check_seal
from roughcontact.io.units import same_length
from roughcontact.si import unit_of


def read(path: Path) -> MeasuredFile:
    """Open a netCDF file; a map that this project wrote is restored unchanged.

    There is one channel for each variable over two axes (y, x), or one that is no time, load or peak of the
    load, and for each index of a third; those named height, heights or z come first.
    """
    head = head_of(path)
    sealed = check_seal(path)
    required_size = classic.check_header(path) if head.startswith(classic.MARKS) else hdf5.stated_size(path)
    arrays = hdf5.datasets(path) if head.startswith(hdf5.MARK) else {}
    too_long = _oversized_variables(path)
    opener = partial(_opened, path, too_long)
    with opener() as dataset:
        channels = [
            _variable(dataset, name, axes, selection, opener)
            for name in dataset.data_vars
            for axes, selection in _maps(dataset[name])
        ]
        instrument = _instrument(dataset)
        names = sorted(map(str, dataset.variables))
    channels += [oversized(name, shape) for name, shape in too_long.items()]
    if not channels:
        raise InputFileError(_no_map_message(arrays, names))
    channels.sort(key=lambda channel: channel.name.partition("[")[0] not in ("height", "heights", "z"))
    return MeasuredFile(
        "netCDF",
        channels,
        first_row="bottom",
        instrument=instrument,
        required_size=required_size and required_size + sealed,
    )


def _instrument(dataset: Any) -> dict[str, Any]:
    """Return the instrument metadata that this project wrote, otherwise those in the file attributes."""
    with suppress(KeyError, TypeError, ValueError, RecursionError):
        return stored_instrument({"instrument": dataset["height"].attrs["instrument"]})
    return instrument_metadata({}, dataset.attrs)


@contextmanager
def _opened(path: Path, left_out: Iterable[str]) -> Iterator[Any]:
    """Open a file as a dataset; errors, also those within the block, are raised as `InputFileError`."""
    import xarray as xr

    with (
        refusing("damaged or cut off netCDF file"),
        xr.open_dataset(
            path, engine="netcdf4", decode_times=False, decode_timedelta=False, drop_variables=list(left_out)
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

    def read() -> np.ndarray:
        """Return the values over the axes, with the sign of heights."""
        with opener() as again:
            stored = again[name].isel(selection)
            values = as_heights(stored.transpose(*filter(None, dims)).values)
            low, high = _valid_range(stored)
            values[(values < low) | (values > high)] = np.nan
        return -values if positive_down else values

    channel = Channel(label, shape, read, unit_of(variable.attrs), lateral_unit=unit_x or unit_y)
    positions = [axis for axis in "xy" if axis in dataset and dataset[axis].dims == variable.dims != (axis,)]
    if variable.dtype.kind not in "iuf":
        channel.no_height = f"values of type {variable.dtype}"
        channel.read = unreadable(f"variable {name!r} holds {channel.no_height}, not real numbers")
        return channel
    counts = [variable.sizes[axis] for axis in selection if variable.sizes[axis] > 1]
    if counts and not str(x).lower().startswith("x") and shape[1] < min(shape[0], counts[0]):
        axes = ", ".join(map(str, variable.dims))
        channel.doubt = f"nothing says which axes of {name!r} are those of a map: name two of {axes} y and x"
    elif positions and name not in positions:
        channel.doubt = (
            f"the positions {' and '.join(positions)} of {name!r} are variables over its axes; make "
            "them coordinates of a grid, or save the points as text x, y, z"
        )
    if channel.doubt:
        channel.read = unreadable(channel.doubt)
        return channel
    if positive_down:
        channel.notes = [f"the file counts {name!r} positive downwards: its sign was changed"]
    along_x, along_y = _axis(dataset, x), _axis(dataset, y)
    channel.first_x, channel.first_y = (
        None if along is None else float(min(along[0], along[-1])) for along in (along_x, along_y)
    )
    channel.first_row = "bottom" if along_y is None else ""  # assumed without positions
    return placed(channel, along_x, along_y, (str(x), str(y)))


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


def _axis(dataset: Any, name: str | None) -> np.ndarray | None:
    """Return the positions of a coordinate, None where there are none."""
    if name is None or name not in dataset.coords or dataset[name].dtype.kind not in "iuf":
        return None
    return dataset[name].values.astype(float)


READER = Reader(RecognisedBy.MARK, begins_with(*classic.MARKS, hdf5.MARK), read)
