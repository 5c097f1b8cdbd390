"""NetCDF: each variable with two axes, in the units of the variable and its coordinates.

Row 0 is the line of the smallest y; without positions it is assumed to be the lowest one.
"""

from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.arguments.measurement import json_attribute, map_attributes
from roughcontact.io import classic, hdf5
from roughcontact.io.channels import Channel, MeasuredFile, as_heights, oversized, unreadable
from roughcontact.io.guards import MAX_POINTS, check_count, refusal, refuse_more, refusing
from roughcontact.io.interface import Reader, RecognisedBy, begins_with, read_head
from roughcontact.io.metadata import instrument_metadata
from roughcontact.io.positions import channel_on_grid
from roughcontact.io.seal import check_seal
from roughcontact.io.units import same_length

_DAMAGED = "damaged or cut off netCDF file"
_MAX_POSITIONS = MAX_POINTS // 4  # of all coordinates; copies are made of them
_FIRST = ("height", "heights", "z")
_ALONG = (["time"], ["peak"], ["sliding_distance"])  # numbers along these are no profile


def read(path: Path) -> MeasuredFile:
    """Open a netCDF file; a map that this project wrote is restored unchanged.

    There is one channel for each variable over two axes (y, x), or one that is no time, load, peak of the
    load or sliding distance, and for each index of a third; those named height, heights or z come first.
    """
    import xarray as xr

    head = read_head(path)
    seal_size = check_seal(path)
    required_size = classic.check_header(path) if head.startswith(classic.MARKS) else hdf5.stated_size(path)
    arrays = hdf5.datasets(path) if head.startswith(hdf5.MARK) else {}
    options: Any = {"decode_times": False, "decode_timedelta": False, "cache": False}
    # closed only after a failure: channels read from the open dataset, until the file is closed
    with refusing(_DAMAGED), ExitStack() as after_failure:
        too_long = _oversized_variables(path)
        dataset = xr.open_dataset(path, engine="netcdf4", drop_variables=list(too_long), **options)
        after_failure.enter_context(dataset)
        channels = [*_channels(dataset)]
        instrument = _instrument(dataset)
        names = sorted(map(str, dataset.variables))
        after_failure.pop_all()
    channels += [oversized(name, shape) for name, shape in too_long.items()]
    if not channels:
        raise _no_map(arrays, names)
    channels.sort(key=lambda channel: (channel.name.partition("[")[0] not in _FIRST, bool(channel.doubt)))
    size = required_size and required_size + seal_size
    return MeasuredFile("netCDF", channels, "bottom", instrument, required_size=size, close=dataset.close)


def _channels(dataset: Any) -> Iterator[Channel]:
    """Yield the channels of all variables, while the points that this reads are not too many in all."""
    total = count = 0
    for name in dataset.data_vars:
        for axes, selection in _maps(dataset.variables[name]):
            yield (channel := _variable(dataset, name, axes, selection))
            sizes = [dataset.variables[name].sizes[axis] for axis in axes if axis]
            total += sum(sizes) + (prod(sizes) if channel.points else 0)  # positions, and uneven maps
            refuse_more(f"maps with {total} positions", total, MAX_POINTS, "save the map alone")
            check_count(count := count + 1)


def _instrument(dataset: Any) -> dict[str, Any]:
    """Return the instrument metadata that this project wrote, otherwise those in the file attributes."""
    with suppress(KeyError, TypeError, ValueError, RecursionError):
        attrs = map_attributes(dataset["height"].attrs)
        return json_attribute({"instrument": attrs["instrument"]}, "instrument")
    return instrument_metadata({}, dataset.attrs)


def _oversized_variables(path: Path) -> dict[str, tuple[int, ...]]:
    """Return the shapes of variables above the size limit; refuse coordinates that are above it in all.

    Opening alone would read all coordinates.
    """
    import netCDF4

    with netCDF4.Dataset(path) as file:
        shapes = {name: tuple(variable.shape) for name, variable in file.variables.items()}
        axes = [name for name in shapes if file[name].dimensions == (name,)]
    too_long = {name: shape for name, shape in shapes.items() if prod(shape) > MAX_POINTS}
    total = sum(prod(shapes[name]) for name in axes if name not in too_long)
    refuse_more(f"coordinates of {total} points", total, _MAX_POSITIONS, "save the map alone")
    return too_long


def _no_map(arrays: dict[str, tuple[int, ...]], names: list[str]) -> Exception:
    """Return the error for a file without a map."""
    if arrays:
        sizes = [f"{name} ({' x '.join(map(str, shape)) or '1'})" for name, shape in sorted(arrays.items())]
        listing = ", ".join(sizes[:5]) + (f" and {len(sizes) - 5} more" if len(sizes) > 5 else "")
        return refusal("HDF5 without a map", listing=listing)
    if not names:
        return refusal("empty netCDF")
    return refusal("no map in netCDF", names=", ".join(names))


def _variable(dataset: Any, name: Any, dims: tuple[str | None, str], selection: dict[str, int]) -> Channel:
    """Return one variable, at some index of its other axes, as a channel that is read on demand."""
    from roughcontact.arguments.si import unit_of  # late: xarray, of which recognising a file needs nothing

    variable = dataset.variables[name]  # a DataArray of each would look through all others
    counts = {axis: variable.sizes[axis] for axis in selection if variable.sizes[axis] > 1}
    label = str(name) + "".join(f"[{axis}={selection[axis]}]" for axis in counts)
    y, x = dims
    shape = variable.sizes[y] if y else 1, variable.sizes[x]
    units = {axis: unit_of(dataset.variables[axis].attrs) for axis in (x, y) if axis in dataset.coords}
    unit_x, unit_y = units.get(x), units.get(y)
    if unit_x and unit_y and not same_length(unit_x, unit_y):
        raise refusal("units of axes", x=x, y=y, unit_x=unit_x, unit_y=unit_y)
    positive_down = str(variable.attrs.get("positive", "")).lower() == "down"  # the CF convention for depths

    def read() -> np.ndarray:
        """Return the values over the axes, with the sign of heights."""
        with refusing(_DAMAGED):
            values = as_heights(variable.isel(selection).transpose(*filter(None, dims)).values)
            low, high = _valid_range(name, variable)
            values[(values < low) | (values > high)] = np.nan
        return -values if positive_down else values

    channel = Channel(label, shape, read, unit_of(variable.attrs), lateral_unit=unit_x or unit_y)
    axes_in_file = [axis for axis in "xy" if axis in dataset]
    positions = [axis for axis in axes_in_file if dataset.variables[axis].dims == variable.dims != (axis,)]
    unread = ""
    if variable.dtype.kind not in "iuf":
        channel.no_height = f"values of type {variable.dtype}"
        unread = f"variable {name!r} holds {channel.no_height}, not real numbers"
    # a last axis shorter than all others is hardly x, but as in (y, x, wavelength)
    elif counts and not str(x).lower().startswith("x") and shape[1] < min(shape[0], *counts.values()):
        unread = str(refusal("axes of anything", name=name, axes=", ".join(map(str, variable.dims))))
    elif positions and name not in positions:
        unread = str(refusal("positions over axes", name=name, positions=" and ".join(positions)))
    if unread:
        return replace(channel, read=unreadable(unread), doubt="" if channel.no_height else unread)
    if positive_down:
        channel.notes = [f"the file counts {name!r} positive downwards: its sign was changed"]
    along_x, along_y = _axis(dataset, x), _axis(dataset, y)
    channel.first_x = None if along_x is None else float(min(along_x[0], along_x[-1]))
    channel.first_y = None if along_y is None else float(min(along_y[0], along_y[-1]))
    channel.first_row = "bottom" if along_y is None else ""  # assumed without positions
    return channel_on_grid(channel, along_x, along_y, (str(x), str(y)))


def _valid_range(name: Any, variable: Any) -> np.ndarray:
    """Return the lowest and the highest value that is no missing point (NetCDF Users Guide, appendix A).

    Limits of the type of packed values are packed too; half a step of these is allowed for rounding.
    """
    attrs, packing = variable.attrs, variable.encoding
    with refusing(f"the valid_range, valid_min or valid_max of {name!r} is no number"):
        outer = attrs.get("valid_min", -np.inf), attrs.get("valid_max", np.inf)
        low, high = attrs.get("valid_range", outer)
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
    several = max(0, variable.ndim - 2)
    selection = dict.fromkeys([axis for axis in variable.dims if variable.sizes[axis] == 1][:several], 0)
    dims = [axis for axis in variable.dims if axis not in selection]
    if len(dims) not in (1, 2, 3) or 0 in variable.shape or "load" in dims or dims in _ALONG:
        return
    if len(dims) == 1:
        yield (None, dims[0]), selection
        return
    plane_axes = [axis for axis in dims if str(axis).lower().startswith(("x", "y"))]
    plane = plane_axes if len(plane_axes) == 2 else dims[-2:]
    if plane[0].lower().startswith("x") and plane[1].lower().startswith("y"):
        plane = plane[::-1]
    count = next((axis for axis in dims if axis not in plane), None)
    for index in range(variable.sizes[count] if count else 1):
        yield (plane[0], plane[1]), selection | ({count: index} if count else {})


def _axis(dataset: Any, name: str | None) -> np.ndarray | None:
    """Return the positions of a coordinate, None where there are none."""
    if name is None or name not in dataset.coords or dataset.variables[name].dtype.kind not in "iuf":
        return None
    return dataset.variables[name].values.astype(float)


READER = Reader(RecognisedBy.MARK, begins_with(*classic.MARKS, hdf5.MARK), read)
