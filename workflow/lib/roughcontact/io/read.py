"""Reading a measured file as a height map in metres, in a format that its content tells, never its name.

Missing units and sizes are never guessed: they are given as arguments (or in the table of surfaces), or the
file is refused. Every map is right-handed, row 0 the bottom line of the instrument's picture; the attribute
`first_row` keeps where the file's first row lies.
"""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import xarray as xr

from roughcontact.arguments.measurement import Instrument, attributes_of_record
from roughcontact.errors import InputFileError
from roughcontact.io.conversion import convert
from roughcontact.io.guards import naming, sha256, unchanged
from roughcontact.io.registry import open_file
from roughcontact.io.request import Request


def read_height_map(
    path: str | Path,
    *,
    channel: str | None = None,
    dx: float | str | None = None,
    dy: float | str | None = None,
    unit: str | None = None,
    height_unit: str | None = None,
    resample: str | None = None,
    checksum: str | None = None,
    first_row: str | None = None,
    missing_value: float | str | None = None,
    ignore_lines: int | str | None = None,
    lay: str | None = None,
    instrument: Mapping[str, float] | None = None,
) -> xr.DataArray:
    r"""Read a measured height map (or a profile) into metres.

    Parameters
    ----------
    path : str or Path
        An instrument file, X3P, SDF, text (matrix, list of points, profile), `.npy` or netCDF.
    channel : str, optional
        Name of the channel; without it the first one that holds heights. Of profiles with a `lay` several
        names, between semicolons: they become the rows of one array.
    dx, dy : float or str, optional
        Steps from point to point, in `unit`, or with a unit of their own: ``"1.5 um"``. They override the
        file, with a warning.
    unit : str, optional
        Unit of `dx` and `dy`, or of the file's own steps where `dx` and `dy` are not given; also that of the
        heights where neither `height_unit` nor the file gives it.
    height_unit : str, optional
        Unit of the file's heights.
    resample : str, optional
        ``linear``: points that form no even grid are interpolated to a grid with steps `dx` and `dy` (by
        default the mean distance of the points). Without it such a file is refused.
    checksum : str, optional
        ``ignore``: a file whose content differs from its own checksum (an X3P edited by hand), or that is
        longer than its header says, is read, with a warning. Without it such a file is refused.
    first_row : str, optional
        ``top`` or ``bottom``: position of the file's first row in the picture of the surface. For files that
        do not state it (NumPy, MATLAB, numbers without a header); it overrides the file, with a warning.
    missing_value : float or str, optional
        Number that marks missing points, in the unit of the file's heights; several as text, ``"-9999 0"``.
    ignore_lines : int or str, optional
        Numbers of lines of a header that do not concern the map, ``"5 7"``: no question or warning.
    lay : str, optional
        Of a profile: ``across`` a lay, whose ridges are endless, or ``none`` for a surface that has none;
        kept as the attribute `lay`.
    instrument : mapping, optional
        What is known of the instrument beside the file, for the error budget: `noise`, `resolution`,
        `wavelength`, `tip_radius` (m), `numerical_aperture`, `amplification_z`, `amplification_xy`; kept as
        the attributes `instrument_noise` and so on.

    Returns
    -------
    DataArray (y, x), m
        `height`, NaN where not measured; coordinates are cell centres in m, evenly spaced, x to the right and
        upwards. A profile has one row. Attributes: `units`, `source_file`, `source_sha256`, `source_format`,
        `channel`, `channels` (JSON list), `instrument` (JSON object), `y_axis` ("up"), `first_row` ("top" or
        "bottom" of the picture: position of the file's first row), `first_row_assumed` (1 where it is only
        the usual convention of the format), `missing_points`, `missing_share`, `ingest_warnings` (JSON list
        of sentences), `ingest_facts` (those of them that say what was asked for or chosen), `ingest_spikes`
        (JSON object: those about spikes, and each without the advice to remove them), `ingest_sources` (JSON
        object: where steps, units, sign, marker and order of rows come from, and the lines `not used`).

    Raises
    ------
    InputFileError
        For a file that is missing, damaged, cut off, of unknown format, without size or units, or that
        changes while it is read.
    HeightMapError
        For a map without a measured point, or of one point.
    SettingsError
        For an invalid argument.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = Path(folder.name) / "map.txt"
    >>> _ = path.write_text("Width: 4 um\nHeight: 2 um\nValue units: nm\n1 2 3 4\n5 6 BAD 8\n")
    >>> height = read_height_map(path)
    >>> height.shape, height.attrs["source_format"], height.attrs["missing_points"]
    ((2, 4), 'text matrix', 1)
    >>> [round(1e6 * float(x), 3) for x in height.x]
    [0.5, 1.5, 2.5, 3.5]
    >>> print(1e9 * height.values.round(12))  # the last line of the text is the lowest
    [[ 5.  6. nan  8.]
     [ 1.  2.  3.  4.]]
    >>> folder.cleanup()
    """
    path = Path(path)
    request = Request(
        channel, dx, dy, unit, height_unit, resample, checksum, first_row, missing_value, ignore_lines, lay
    )
    if request.lay and ";" in (request.channel or ""):
        return _together(path, request, instrument)
    with naming(path):
        height = _read(path, request)
    facts = Instrument(**{key: float(value) for key, value in (instrument or {}).items()}).attributes()
    return height.assign_attrs(facts if request.lay is None else {"lay": request.lay} | facts)


def _read(path: Path, request: Request) -> xr.DataArray:
    """Return the height map of a file."""
    # the digest is taken within: it is that of the bytes that were read
    with unchanged(path), closing(open_file(path)) as file:
        result = convert(file, request)
        digest = sha256(path)
    notes, facts = list(result.notes), list(result.facts)
    if len(file.channels) > 1 and request.channel is None:
        facts.append(f"channel {result.choice}, was read; name another one with channel")
        notes.append(facts[-1])
    notes += map(str, result.doubts)
    facts += [str(doubt) for doubt in result.doubts if doubt.kind == "pixels"]
    spikes = {str(doubt): doubt.finding for doubt in result.doubts if doubt.kind == "spikes"}
    x, y = result.centres()
    missing = int(np.isnan(result.heights).sum())
    source = {"source_file": path.name, "source_sha256": digest, "source_format": file.format}
    channels = {"channel": result.channel.name, "channels": [channel.name for channel in file.channels]}
    instrument = {"instrument": dict(sorted(file.instrument.items())), "ingest_sources": result.sources}
    rows = {"y_axis": "up", "first_row": result.first_row, "first_row_assumed": int(result.first_row_assumed)}
    points = {"missing_points": missing, "missing_share": missing / result.heights.size}
    findings = {"ingest_warnings": notes, "ingest_facts": facts, "ingest_spikes": spikes}
    record = {"units": "m", **source, **channels, **instrument, **rows, **points, **findings}
    coordinates = {"x": ("x", x, {"units": "m"}), "y": ("y", y, {"units": "m"})}
    return xr.DataArray(result.heights, coordinates, ("y", "x"), "height", attributes_of_record(record))


def _together(path: Path, request: Request, instrument: Mapping[str, float] | None) -> xr.DataArray:
    """Return several profiles of a file, whose channels stand between semicolons, as rows of one array."""
    names = [name.strip() for name in str(request.channel).split(";") if name.strip()]
    arguments = [asdict(replace(request, channel=name)) for name in names]
    rows = [read_height_map(path, **options, instrument=instrument) for options in arguments]
    if any(row.shape != (1, rows[0].size) for row in rows):
        raise InputFileError(f"{path}: channel = {request.channel}: are no profiles of one length; name one")
    stack = xr.concat(rows, "y", join="override", combine_attrs="override")
    # profiles have no places across: a step of theirs keeps the rows apart, and `lay` says what they are
    step = float(rows[0]["x"][1] - rows[0]["x"][0])
    stack = stack.assign_coords(y=("y", (np.arange(len(rows)) + 0.5) * step, {"units": "m"}))
    missing = sum(row.attrs["missing_points"] for row in rows)
    facts = {"missing_points": missing, "missing_share": missing / stack.size, "profiles": len(rows)}
    return stack.assign_attrs(facts | {"channel": "; ".join(names)})
