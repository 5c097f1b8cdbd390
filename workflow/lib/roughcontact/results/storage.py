"""Result files: netCDF, written whole or not at all, byte-identical for identical content."""

import errno
import json
import os
import platform
import re
import shutil
import subprocess
import zlib
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact import __version__
from roughcontact.arguments.measurement import file_attributes, map_attributes
from roughcontact.arguments.settings.stages import origin_id
from roughcontact.arguments.si import labelled_in_si
from roughcontact.arguments.variables import describe
from roughcontact.errors import InputFileError, OutputFileError, RoughContactError
from roughcontact.io.guards import brief
from roughcontact.io.seal import WAY_OUT, check_seal, seal

if TYPE_CHECKING:
    import netCDF4

FAILURE = "failure"  # attribute of a file of wear, sliding or unloading that came to nothing: why
_FORMULA = tuple("=+-@\t\r")  # first letters of a formula in a spreadsheet
_UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")  # no characters of XML


_COMPRESSED_FROM = 4096  # elements; below that a compressed chunk costs more than it saves
_COMPRESSION: dict[str, Any] = {"zlib": True, "complevel": 1, "shuffle": True}
_MAP_CHUNK = (1, 512, 1024)  # chunk of a map: loads are read one by one
_SAMPLE = 2**14  # elements that tell whether an array shrinks
_SHRUNK = 0.7  # of nearly random digits compression saves a sixth, and takes longer than the solution
_CACHE = 2**20  # bytes of a variable that are kept in memory: less than a chunk
_BYTES_OF_MAPS = 17  # at most, of a point under one load: pressure, gap and contact


# packages that may affect a number, as far as they are installed; Snakemake started the jobs
_PACKAGES = (
    "numpy scipy xarray netCDF4 h5py pandas pydantic SurfaceTopography x3pio sdfio matplotlib snakemake"
)
# `.sel` alone does not know the pressures, which may differ from surface to surface
_LOADS_BY_PRESSURE = (
    "roughcontact.read_statistics(path) selects loads by their pressure in Pa: "
    '.sel(mean_pressure=2e6, method="nearest"); .sel(surface=...) selects a surface, where there are several.'
)
# titles of the files of a surface
_TITLES = {
    "height": "Heights as measured",
    "levelled": "Levelled heights",
    "window": "Periodic window",
    "overview": "Coarser maps around",
    "contact": "Solution of the contact",
    "uncertainty": "Error budget of the contact",
    "statistics": "Statistics of the contact",
    "residual": "Surface after the load",
    "worn": "Surfaces worn by sliding",
    "sliding": "Friction of sliding rubber",
}


def provenance(
    settings: dict[str, Any],
    *,
    source_sha256: str = "",
    stage: str = "",
    subject: str = "",
    history: str = "",
) -> dict[str, str]:
    """Return the attributes that record the origin of a file: settings, versions, checksum of the input."""
    program = f"roughcontact {__version__}"
    how = {"comment": _LOADS_BY_PRESSURE} if stage == "statistics" else {}
    title = _TITLES.get(stage, "Result of roughcontact")
    # no wall clock and no host name, so that two equal runs write equal files
    attributes = {
        "Conventions": "CF-1.11",
        "title": f"{title}: {subject}" if subject else title,
        "history": "\n".join(filter(None, [history, f"{title} by {program}"])),
        "source": program,
        "settings": json.dumps(settings, sort_keys=True),
        "versions": _versions(),
        "source_sha256": source_sha256,
    }
    if commit := _commit():
        attributes["commit"] = commit
    return attributes | how


@cache
def _versions() -> str:
    """Return the versions of all packages with a part in the numbers, as JSON."""
    versions = {"roughcontact": __version__, "python": platform.python_version()}
    for name in _PACKAGES.split():
        with suppress(PackageNotFoundError):
            versions[name] = version(name)
    return json.dumps(versions, sort_keys=True)


@cache
def _commit() -> str:
    """Return the commit of the source: of its checkout, or the one that was noted when a wheel was built."""
    package = Path(__file__).resolve().parents[1]
    with suppress(OSError):
        return (package / "_commit.txt").read_text(encoding="ascii").strip()
    checkout = package.parents[2]
    if not (checkout / ".git").exists():  # an environment within another project
        return ""
    command = ["git", "-C", str(checkout), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    with suppress(OSError, subprocess.SubprocessError):
        return subprocess.check_output(command, text=True, stderr=subprocess.DEVNULL, timeout=10).strip()
    return ""


def write_dataset(dataset: xr.Dataset | xr.DataArray, path: str | Path) -> None:
    """Write a dataset as netCDF-4, to a temporary name first, so that no half file is ever seen.

    Every variable gets its unit and description from `arguments.variables`; lengths and pressures that
    state another unit are converted. Arrays of 4096 elements and more are compressed (fastest zlib, byte
    shuffle) where that saves a third. The last line is a checksum, which every function that reads results
    compares.

    Parameters
    ----------
    dataset : Dataset or DataArray
        an array without a name is a height.
    path : str or Path
        its folder is made where it is missing.

    Raises
    ------
    RoughContactError
        where a variable is not in the table of `roughcontact.arguments.variables`.
    OutputFileError
        where the disk is full or the folder may not be written.

    Examples
    --------
    >>> import tempfile, xarray as xr
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_dataset(xr.Dataset({"mean_gap": ("load", [2e-7])}), f"{folder}/statistics.nc")
    ...     read_dataset(f"{folder}/statistics.nc")["mean_gap"].attrs["units"]
    'm'
    """
    # a map alone is a dataset whose attributes the file shows, too
    if isinstance(dataset, xr.DataArray):
        name = dataset.name or "height"
        result = labelled_in_si(dataset.to_dataset(name=name))
        result = result.assign_attrs(result[name].attrs)
    else:
        result = labelled_in_si(dataset)
    dataset = describe(result)
    with atomic_write(path, size=dataset.nbytes) as partial, _created(partial) as file:
        _write(file, dataset)


@contextmanager
def _created(path: Path) -> Iterator["netCDF4.Dataset"]:
    """Create a netCDF file, which is closed at the end, with the checksum of all of it."""
    from netCDF4 import Dataset

    with _uncached(), Dataset(path, "w") as file:
        yield file
    seal(path)


def _write(file: "netCDF4.Dataset", dataset: xr.Dataset) -> None:
    """Write a described dataset to an open file, beside what it holds."""
    dataset = _with_attributes(dataset.copy(deep=False), file_attributes)
    _define(file, dataset)
    # unlike in `to_netcdf` after all definitions: each return to them goes through all variables again
    for name, variable in dataset.variables.items():
        is_text = variable.dtype.kind == "U"
        file[str(name)][...] = variable.values.astype(object) if is_text else variable.values


def _define(file: "netCDF4.Dataset", dataset: xr.Dataset) -> None:
    """Define the variables of a dataset that a file does not have yet, and their attributes."""
    variables = dataset.variables
    auxiliary = {name: {*variables[name].dims} for name in dataset.coords if name not in dataset.dims}
    remaining = {*auxiliary}  # coordinates of no variable are named by the file
    # whose unit is that of the bins
    bounds = {variable.attrs.get("bounds") for variable in variables.values()}
    for dimension in dict.fromkeys(dim for variable in variables.values() for dim in variable.dims):
        if dimension not in file.dimensions:
            file.createDimension(str(dimension), dataset.sizes[dimension])
    for name, variable in variables.items():
        attached = {
            coordinate
            for coordinate, dims in auxiliary.items()
            if name not in auxiliary and name not in variable.dims and dims <= {*variable.dims}
        }
        remaining -= attached
        if name not in file.variables:
            is_text, is_float = variable.dtype.kind in "UO", variable.dtype.kind == "f"
            file.createVariable(
                str(name),
                str if is_text else variable.dtype,
                [*map(str, variable.dims)],
                fill_value=np.nan if is_float and name in dataset.data_vars else None,
                **({} if is_text or variable.size < _COMPRESSED_FROM else _packed(variable)),
            )
        attrs = {key: value for key, value in variable.attrs.items() if key != "units" or name not in bounds}
        file[str(name)].setncatts(_naming(attrs, attached))
    file.setncatts(_naming(dataset.attrs, remaining))
    file.set_auto_maskandscale(False)


def _naming(attrs: Mapping[str, Any], coordinates: Iterable[Hashable]) -> dict[str, Any]:
    """Return attributes that name coordinates, as CF does."""
    names = " ".join(sorted(map(str, coordinates)))
    return {**attrs, "coordinates": names} if names else {**attrs}


def _with_attributes(
    dataset: xr.Dataset, change: Callable[[Mapping[str, Any]], dict[str, Any]]
) -> xr.Dataset:
    """Change the attributes of a dataset with a height map, and of the map; return the dataset."""
    if "height" in dataset.variables:
        dataset.attrs = change(dataset.attrs)
        dataset["height"].attrs = change(dataset["height"].attrs)
    return dataset


def _packed(variable: xr.Variable | xr.DataArray) -> dict[str, Any]:
    """Return the encoding of a large variable; maps of loads in chunks of one load."""
    middle = variable.values.reshape(-1)[variable.size // 2 :][:_SAMPLE]
    shuffled = middle.view(np.uint8).reshape(middle.size, -1).T.tobytes()
    encoding = _COMPRESSION if len(zlib.compress(shuffled, 1)) < _SHRUNK * len(shuffled) else {}
    if variable.dims[1:] != ("y", "x"):
        return encoding
    return encoding | {"chunksizes": tuple(map(min, _MAP_CHUNK, variable.shape))}


class LoadByLoad:
    """A solution that is written as it is found: the maps of a few loads are larger than the memory.

    `file`: empty and open; `loads` that will be solved (Pa, or N), in the order of the file.
    """

    def __init__(self, file: "netCDF4.Dataset", loads: Sequence[float]):
        self._file = file
        file.createDimension("load", len(loads))
        # the file has the order that was asked for
        self._indices = iter(np.argsort(loads, kind="stable"))  # `solve_contact` solves them rising

    def write_maps(self, solution: xr.Dataset) -> xr.Dataset:
        """Write the maps of a load, and return an empty dataset: no map is kept in memory.

        To be given to `solve_contact` as `reduce`.
        """
        maps = describe(solution[[name for name in solution.data_vars if solution[name].ndim == 3]])
        index = next(self._indices)
        if not self._file.variables:
            _define(self._file, maps)
        for name, field in maps.data_vars.items():
            self._file[str(name)][index] = field.values[0]
        return xr.Dataset()

    def complete(self, dataset: xr.Dataset) -> None:
        """Write all the rest, attributes of the file included."""
        _write(self._file, describe(dataset))


@contextmanager
def written_load_by_load(
    path: str | Path, loads: Sequence[float], window: xr.DataArray
) -> Iterator[LoadByLoad]:
    """Open a file for the maps of loads (Pa) on a window (y, x; m), which appears at the end."""
    size = len(loads) * window.size * _BYTES_OF_MAPS
    with atomic_write(path, size=size) as partial, _created(partial) as file:
        yield LoadByLoad(file, loads)


def read_dataset(path: str | Path) -> xr.Dataset:
    """Read one of the project's own result files into memory.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Dataset

    Raises
    ------
    InputFileError
        where the file is missing, damaged or no netCDF file.
    """
    from netCDF4 import Dataset

    # in two thirds of the time of `xarray.open_dataset`, which decodes what these files do not have
    with _readable(path), _uncached(), Dataset(path) as file:
        file.set_auto_maskandscale(False)
        attrs, variables = _attributes(file), {}
        for name, variable in file.variables.items():
            values = variable[...].astype(str) if variable.dtype is str else variable[...]
            variables[name] = xr.Variable(variable.dimensions, values, _attributes(variable))
    holders = [attrs, *(variable.attrs for variable in variables.values())]
    coordinates = {name for entry in holders for name in entry.pop("coordinates", "").split()}
    dataset = xr.Dataset(variables, attrs=attrs).set_coords(coordinates & {*variables})
    return _with_attributes(dataset, map_attributes)


def _attributes(entry: "netCDF4.Dataset | netCDF4.Variable") -> dict[str, Any]:
    """Return the attributes of a file, or of a variable in it."""
    return {key: entry.getncattr(key) for key in entry.ncattrs() if key != "_FillValue"}


def read_attributes(path: str | Path) -> dict[str, Any]:
    """Return the attributes of one of the project's own result files, whose variables are not read."""
    from netCDF4 import Dataset

    with _readable(path), Dataset(path) as file:
        return _attributes(file)


@contextmanager
def opened_dataset(path: str | Path) -> Iterator[xr.Dataset]:
    """Open one of the project's own result files, to read a part of it.

    `InputFileError` for a missing or damaged file may also be raised within the block.
    """
    with _readable(path):
        with _uncached():
            dataset = xr.open_dataset(path, engine="netcdf4")
        with dataset:
            yield _with_attributes(dataset, map_attributes)


@contextmanager
def _uncached() -> Iterator[None]:
    """Keep no chunks of opened files in memory: of each variable 64 MB would be kept.

    All of a map is read or written at once, so that no chunk is needed again.
    """
    from netCDF4 import get_chunk_cache, set_chunk_cache

    previous = get_chunk_cache()
    set_chunk_cache(_CACHE)
    try:
        yield
    finally:
        set_chunk_cache(*previous)


@contextmanager
def _readable(path: str | Path) -> Iterator[None]:
    """Raise an `InputFileError` where a result file cannot be read within the block."""
    seal_size = 0
    try:
        seal_size = check_seal(path)
        if not Path(path).is_file():  # the library would wait for a pipe
            raise OSError("no regular file")
        yield
    except (RoughContactError, ImportError):
        raise
    except Exception as error:  # the libraries raise errors of many types on what is damaged
        if seal_size:  # the content is as it was written: something else is wrong
            raise
        if isinstance(error, FileNotFoundError):
            raise InputFileError(f"{path}: no such file; check the path") from error
        why = brief(error)
        raise InputFileError(f"{path}: not readable as netCDF ({why}); {WAY_OUT}") from error


def check_origin(attrs: Mapping[str, Any], path: str | Path, origin: str) -> None:
    """Raise an `InputFileError` where the attributes of a file are not of an `origin` that is not empty."""
    if origin and origin_id(str(attrs.get("settings")), str(attrs.get("source_sha256"))) != origin:
        raise InputFileError(f"{path}: belongs to other settings or another measured file; {WAY_OUT}")


def write_table(frame: pd.DataFrame, path: str | Path) -> None:
    """Write a table as CSV (UTF-8), as of `table_text`, whole or not at all."""
    write_text(table_text(frame), path)


def table_text(frame: pd.DataFrame) -> str:
    r"""Return a table as CSV with ten digits, without its index.

    Examples
    --------
    >>> import pandas as pd
    >>> table_text(pd.DataFrame({"surface": ["=1"], "load": [1 / 3]}))
    "surface,load\n'=1,0.3333333333\n"
    """
    return str(frame.map(as_words).to_csv(index=False, float_format="%.10g", lineterminator="\n"))


def as_words(cell: Any) -> Any:
    r"""Return a cell whose text no spreadsheet takes for a formula, without characters that it cannot hold.

    Examples
    --------
    >>> as_words("=1"), as_words("\x1b[31m"), as_words(2.5)
    ("'=1", '\ufffd[31m', 2.5)
    """
    if not isinstance(cell, str):
        return cell
    cell = _UNPRINTABLE.sub("\ufffd", cell)
    return f"'{cell}" if cell[:1] in _FORMULA else cell


def write_text(text: str, path: str | Path) -> None:
    """Write a text as UTF-8, whole or not at all; the folder is made where it is missing."""
    content = text.encode()
    with atomic_write(path, size=len(content)) as partial:
        partial.write_bytes(content)


@contextmanager
def atomic_write(path: str | Path, *, size: int) -> Iterator[Path]:
    """Yield a temporary name beside `path` that takes its place at the end: no half file is ever seen.

    `size` is an upper estimate of the bytes: where fewer are free, that is given as the reason of a failure.
    """
    path = Path(path)
    # always the same, so that a later run replaces what a killed job left
    partial = path.with_name(f".{path.name}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.unlink(missing_ok=True)  # a link would lead elsewhere
        yield partial
        partial.replace(path)
    except (OSError, RuntimeError) as error:  # netCDF says RuntimeError, and nothing about the reason
        if (reason := _why_not_written(path.parent, error, size)) is None:
            raise
        raise OutputFileError(f"{path}: cannot be written, {reason}") from error
    finally:
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def _why_not_written(folder: Path, error: Exception, size: int) -> str | None:
    """Return why nothing can be written to a folder, and the way out; None for other reasons."""
    if os.sep == "/" and "\\" in str(folder.absolute()):
        return "netCDF takes the backslash in its path for a separator: rename that folder"
    code = getattr(error, "errno", None)
    existing = next(path for path in (folder, *folder.absolute().parents) if path.is_dir())
    free, may_write = shutil.disk_usage(existing).free, os.access(existing, os.W_OK)
    # of a full disk netCDF says as well that it has no permission
    if code in (errno.ENOSPC, errno.EDQUOT) or (may_write and free < size):
        shortage = f"the disk is full ({free / 1e6:.3g} MB free)"
        return f"{shortage}: make room and run again, what is done is not done again"
    if code == errno.EFBIG or "NetCDF: HDF error" in str(error):
        return "a limit of the size of files (`ulimit -f`) or a quota is reached: raise it and run again"
    if code in (errno.EROFS, errno.EACCES, errno.EPERM) or not may_write:
        return (
            f"the folder {existing} is read-only for you: choose another one (with the workflow: --directory)"
        )
    return None
