"""Result files: netCDF, written whole or not at all, byte-identical for identical content."""

import json
import os
import platform
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from roughcontact import __version__
from roughcontact.errors import InputFileError
from roughcontact.variables import describe

_COMPRESSED_FROM = 4096  # elements; below that a compressed chunk costs more than it saves


def provenance(settings: dict, *, source_sha256: str = "") -> dict:
    """Return the attributes that say how a file came about: settings, versions, checksum of the input.

    No wall clock and no host name, so that two equal runs write equal files.
    """
    packages = ("numpy", "scipy", "xarray", "netCDF4")
    versions = {"roughcontact": __version__, "python": platform.python_version()}
    versions |= {name: version(name) for name in packages}
    return {
        "Conventions": "CF-1.11",
        "source": f"roughcontact {__version__}",
        "settings": json.dumps(settings, sort_keys=True),
        "versions": json.dumps(versions, sort_keys=True),
        "source_sha256": source_sha256,
    }


def write_dataset(dataset: xr.Dataset | xr.DataArray, path: str | Path) -> None:
    """Write `dataset` to `path` (netCDF-4), to a temporary name first, so that no half file is ever seen.

    Every variable gets its unit and description from `roughcontact.variables`; a name that is not in that
    table is refused. Arrays of 4096 elements and more are compressed (zlib level 1, byte shuffle).
    """
    if isinstance(dataset, xr.DataArray):
        dataset = dataset.to_dataset(name=dataset.name or "height", promote_attrs=True)
    dataset = describe(dataset)
    encoding = {}
    for name, variable in dataset.variables.items():
        encoding[name] = {"_FillValue": None}
        if name in dataset.data_vars and np.issubdtype(variable.dtype, np.floating):
            encoding[name] = {"_FillValue": np.nan}
        if variable.size >= _COMPRESSED_FROM and variable.dtype.kind in "fiub":
            encoding[name] |= {"zlib": True, "complevel": 1, "shuffle": True}
    with _whole(path) as partial:
        dataset.to_netcdf(partial, engine="netcdf4", encoding=encoding)


def read_dataset(path: str | Path) -> xr.Dataset:
    """Read one of the project's own result files into memory.

    Raises
    ------
    InputFileError
        where the file is missing or is no netCDF file.
    """
    try:
        with xr.open_dataset(path, engine="netcdf4") as dataset:
            return dataset.load()
    except OSError as error:
        raise InputFileError(f"{path}: not readable as netCDF ({error}); delete it and run again") from error


def write_table(frame: pd.DataFrame, path: str | Path) -> None:
    """Write `frame` to `path` as CSV (UTF-8, ten digits), whole or not at all."""
    write_text(frame.to_csv(index=False, float_format="%.10g", lineterminator="\n"), path)


def write_text(text: str, path: str | Path) -> None:
    """Write `text` to `path` as UTF-8, whole or not at all."""
    with _whole(path) as partial:
        partial.write_bytes(text.encode())


@contextmanager
def _whole(path: str | Path):
    """Yield a temporary name beside `path` that takes its place at the end: no half file is ever seen.

    The name is always the same, so that what a killed job has left is written over.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.partial")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
