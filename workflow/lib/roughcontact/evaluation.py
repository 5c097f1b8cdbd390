"""One call from a measured file to its numbers, with the settings of the configuration."""

import warnings
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import xarray as xr

from roughcontact.checking import check_labelled, warn_of_map
from roughcontact.configuration.resolve import resolve
from roughcontact.errors import HeightMapWarning, SettingsError
from roughcontact.io.read import read_height_map
from roughcontact.pipeline import run_chain
from roughcontact.si import labelled_in_si


def evaluate(
    source: str | Path | xr.DataArray,
    *,
    level: Mapping[str, Any] | None = None,
    window: Mapping[str, Any] | None = None,
    contact: Mapping[str, Any] | None = None,
    statistics: Mapping[str, Any] | None = None,
    uncertainty: Mapping[str, Any] | None = None,
    instrument: Mapping[str, Any] | None = None,
    threads: int = 1,
    **file: Any,
) -> xr.Dataset:
    """Read, level, window, solve and count one map, and return its statistics with their intervals.

    Parameters
    ----------
    source : str, Path or DataArray (y, x), m
        a measured file, or a height map as `read_height_map` or `height_map` returns it.
    level, window, contact, statistics, uncertainty, instrument : mapping, optional
        sections of the configuration, with numbers possibly as text with a unit ("115 GPa"); missing keys
        have their defaults. `contact` states the elasticity, as `contact_modulus` or `bodies`.
    threads : int
        threads of the solver.
    **file
        what a file does not say, as for `read_height_map`: ``channel="Height"``, ``missing_value=-9999``.

    Returns
    -------
    Dataset
        dims (load, ...), the content of statistics.nc: `{quantity}` for each load, `{quantity}_uncertainty`
        (load, source), `{quantity}_lower` and `{quantity}_upper` (load), numbers of the map, SI units, and
        the flag `verdict` (load): 0 use, 1 review, 2 do not use. Its attributes hold settings, versions, for
        a file its checksum, and `reasons`, JSON: a list of ``{"check", "loads", "text"}``, the checks that
        did not pass, each with the indices of the loads concerned and a sentence.

    Raises
    ------
    SettingsError
        for settings that the configuration does not accept.
    InputFileError
        for a file that cannot be read.
    HeightMapError
        for a map that cannot be levelled, windowed or solved.
    ConvergenceError
        where a load misses the tolerance and `contact` says ``on_failure: raise``.

    Examples
    --------
    >>> from roughcontact.references.synthetic import rough_reference_surface
    >>> found = evaluate(
    ...     rough_reference_surface(64),
    ...     contact={"contact_modulus": "1 GPa", "relative_pressure": 0.1},
    ...     uncertainty={"sources": ["solver"]},
    ... )
    >>> f"{found['relative_contact_area'].item():.2f}"
    '0.21'
    >>> bool(found["mean_gap_lower"] <= found["mean_gap"])
    True
    >>> int(found["verdict"].item()), found["verdict"].attrs["flag_meanings"]
    (2, 'use review do_not_use')
    """
    if not isinstance(source, str | PathLike):
        source = labelled_in_si(check_labelled(source))
    sections = {
        "level": level,
        "window": window,
        "contact": contact,
        "statistics": statistics,
        "uncertainty": uncertainty,
        "instrument": instrument,
    }
    if file and isinstance(source, xr.DataArray):
        raise SettingsError(f"{', '.join(file)}: of a file, the source is a map; read it with them")
    full = resolve({section: dict(values) for section, values in sections.items() if values is not None})[""]
    height = source if isinstance(source, xr.DataArray) else read_height_map(source, **file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", HeightMapWarning)  # of every solution; said once below
        result = run_chain(height, full, threads=threads)
    warn_of_map(result.window.shape, float(result.statistics["rms_gradient"]), stacklevel=3)
    return result.statistics
