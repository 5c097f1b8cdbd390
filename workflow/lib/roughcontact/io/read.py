"""Reading a measured file as a height map in metres.

The format is told by the content of a file, never by its name. Units are converted once, here. What a file
does not say is never guessed: it is given as an argument (or in the table of surfaces), or the file is
refused.

Row j of a map is row j of the file, and y grows from row to row. Where the instrument's software draws row 0,
at the top or at the bottom of its picture, is kept in the attribute `first_row`.
"""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

<<<<<<< HEAD
from roughcontact.checking import check_choice
from roughcontact.choices import Resampling
from roughcontact.errors import HeightMapError, InputFileError, SettingsError
from roughcontact.io import arrays, exchange, instrument, instrument_kinds, text
from roughcontact.io.channels import Channel, SourceFile, choose_channel
from roughcontact.io.guards import brief, check_archive, check_file, sha256
from roughcontact.io.plausibility import quantisation_step, roughness_off_plane, suspicions
from roughcontact.io.resampling import resampled
from roughcontact.io.units import is_length, metres
=======
from roughcontact.io.conversion import convert
from roughcontact.io.guards import sha256
from roughcontact.io.plausibility import suspicions
from roughcontact.io.registry import open_file
from roughcontact.io.request import Request
>>>>>>> 3df81f8 (Reading by ideas: readers found in a folder, the scale, the request, the conversion and the two verbs in a module each)

if TYPE_CHECKING:
    import xarray as xr


def read_height_map(
    path: str | Path,
    *,
    channel: str | None = None,
    dx: float | None = None,
    dy: float | None = None,
    unit: str | None = None,
    height_unit: str | None = None,
    resample: str | None = None,
) -> "xr.DataArray":
    r"""Read a measured height map (or a profile) into metres.

    Parameters
    ----------
    path : str or Path
        An instrument file, X3P, SDF, text (matrix, list of points, profile), `.npy` or netCDF.
    channel : str, optional
        Name of the channel; without it the first one that holds heights.
    dx, dy : float, optional
        Steps from point to point, in `unit`. They win over what the file says, with a warning.
    unit : str, optional
        Unit of `dx` and `dy`, or of the file's own steps where `dx` and `dy` are not given; also that of the
        heights where neither `height_unit` nor the file says it.
    height_unit : str, optional
        Unit of the file's heights.
    resample : str, optional
        ``linear``: points that lie on no even grid are interpolated to one of steps `dx` and `dy` (where they
        are not given: the mean distance of the points). Without it such a file is refused.

    Returns
    -------
    DataArray (y, x), m
        `height`, NaN where not measured; coordinates are cell centres in m, evenly spaced and increasing. A
        profile has one row. Attributes: `units`, `source_file`, `source_sha256`, `source_format`, `channel`,
        `channels` (JSON list), `instrument` (JSON object), `first_row` ("top" or "bottom": where the
        instrument's software draws row 0), `missing_points`, `missing_share`, `ingest_warnings` (JSON list of
        sentences).

    Raises
    ------
    InputFileError
        For a file that is missing, damaged, cut off, of unknown format, or silent about its size or units.
    HeightMapError
        For a map without a measured point, or of one point.
    SettingsError
        For an argument that has no meaning.

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
    >>> round(1e9 * float(height.max()), 3)
    8.0
    >>> folder.cleanup()
    """
    import xarray as xr

    path = Path(path)
    request = Request(channel, dx, dy, unit, height_unit, resample)
    file = open_file(path)
    converted = convert(file, request, path)
    notes = list(converted.notes)
    if len(file.channels) > 1 and request.channel is None:
        notes.append(f"channel {converted.choice}, was read; name another one with channel")
    notes += suspicions(converted.heights, converted.dx, converted.dy, kind=file.kind)
    x, y = converted.centres()
    missing = int(np.isnan(converted.heights).sum())
    return xr.DataArray(
        converted.heights,
        dims=("y", "x"),
        coords={"x": ("x", x, {"units": "m"}), "y": ("y", y, {"units": "m"})},
        name="height",
        attrs={
            "units": "m",
            "source_file": path.name,
            "source_sha256": sha256(path),
            "source_format": file.format,
            "channel": converted.channel.name,
            "channels": json.dumps([each.name for each in file.channels], ensure_ascii=False),
            "instrument": json.dumps(file.instrument, ensure_ascii=False, sort_keys=True),
            "first_row": file.first_row,
            "missing_points": missing,
            "missing_share": missing / converted.heights.size,
            "ingest_warnings": json.dumps(notes, ensure_ascii=False),
        },
    )
<<<<<<< HEAD


def inspect_file(path, *, channel=None, dx=None, dy=None, unit=None, height_unit=None, resample=None) -> dict:
    """Return what is in a file, without asking for units that it does not say.

    The arguments are those of `read_height_map`.

    Returns
    -------
    dict
        `file`, `bytes`, `sha256`, `format`, `first_row`, `instrument`; `channel` (the one that would be read,
        or None) and `channel_choice` (why); `channels`, one dict per channel with `name`, `ny`, `nx`, `dx`,
        `dy`, `lateral_unit`, `height_unit` (None where the file is silent), `is_height`, `reason`, and for
        heights `missing_points`, `missing_share`, `rms_height`, `lowest`, `highest` (in `height_unit`);
        `map`, what `read_height_map` would return, None where it would not: `ny`, `nx`, `dx`, `dy`, `size_x`,
        `size_y`, `missing_points`, `missing_share`, `lowest`, `highest`, `rms_height` and `rms_gradient` (off
        the mean plane), `quantisation_step` (None where heights are not quantised), in m;
        `problem`: what `read_height_map` would say, or None; `warnings`.

    Raises
    ------
    InputFileError
        as for `read_height_map`, but not for units and sizes that the file does not say.
    """
    path = Path(path)
    check_file(path)
    source = _open(path)
    given = {"dx": dx, "dy": dy, "unit": unit, "height_unit": height_unit}
    problem, warnings, name, sentence, measured = None, list(source.warnings), None, None, None
    try:
        chosen, sentence, heights, steps, warnings = _read(source, path, channel, resample, given)
        name, measured = chosen.name, _measured(heights, steps)
        warnings += suspicions(heights, *steps, kind=instrument_kinds.of_name(source.instrument.get("kind")))
    except (InputFileError, HeightMapError) as error:
        problem = str(error)
        if _given(channel) is None:
            name = next((each.name for each in source.channels if not each.no_height), None)
    return {
        "file": path.name,
        "bytes": path.stat().st_size,
        "sha256": sha256(path),
        "format": source.format,
        "first_row": source.first_row,
        "instrument": source.instrument,
        "channel": name,
        "channel_choice": sentence,
        "channels": [_described(each) for each in source.channels],
        "map": measured,
        "problem": problem,
        "warnings": warnings,
    }


def _read(source: SourceFile, path, channel, resample, given):
    """Return channel, why it was chosen, heights (m), steps (dx, dy) in m, and sentences for the user."""
    given = {key: _given(value) for key, value in given.items()}
    chosen, sentence = choose_channel(
        source, _given(channel), str(path), unit_given=given["height_unit"] is not None
    )
    notes = source.warnings + chosen.notes
    if chosen.no_height:
        notes.append(f"channel {chosen.name!r} is read at the user's word ({chosen.no_height})")
    if chosen.points is not None:
        chosen, done = _on_even_grid(chosen, path, _given(resample), given)
        notes.append(done)
        given |= {"dx": None, "dy": None}
    steps, height_factor = _scales(chosen, path, **given, notes=notes)
    return chosen, sentence, _checked(chosen.read() * height_factor, path), steps, notes


def _on_even_grid(channel: Channel, path, resample, given) -> tuple[Channel, str]:
    """Return the channel on an even grid, where the user asks for that, and a sentence that says it."""
    if resample is None:
        raise InputFileError(
            f"{path}: {channel.uneven}; give resample = linear (table of surfaces or argument) to "
            "interpolate to an even grid, or interpolate and export it with the instrument's software"
        )
    check_choice(f"{path}: resample", resample, Resampling)
    steps = [None if given[name] is None else _positive(given[name], name, path) for name in ("dx", "dy")]
    if any(steps):  # the steps are in `unit`: so shall be the positions
        own = _unit_of_steps(given["unit"], f"dx = {given['dx']}, dy = {given['dy']}", path)
        if is_length(channel.lateral_unit):
            x, y, z = channel.points
            factor = metres(channel.lateral_unit) / own
            channel = replace(channel, points=(x * factor, None if y is None else y * factor, z))
        channel = replace(channel, lateral_unit=given["unit"])
    return resampled(channel, tuple(steps), path)


def _measured(heights, steps) -> dict:
    """Return what is known of a map (m) before anything is done to it."""
    (ny, nx), missing = heights.shape, int(np.isnan(heights).sum())
    rms_height, rms_gradient = roughness_off_plane(heights, *steps)
    return {
        "ny": ny,
        "nx": nx,
        "dx": steps[0],
        "dy": steps[1],
        "size_x": nx * steps[0],
        "size_y": ny * steps[1],
        "missing_points": missing,
        "missing_share": missing / heights.size,
        "lowest": float(np.nanmin(heights)),
        "highest": float(np.nanmax(heights)),
        "rms_height": rms_height,
        "rms_gradient": rms_gradient,
        "quantisation_step": quantisation_step(heights),
    }


def _open(path: Path) -> SourceFile:
    with open(path, "rb") as stream:
        head = stream.read(4096)
    check_archive(path)
    if head.startswith(b"PK") and zipfile.is_zipfile(path) and exchange.main_xml_of(path):
        return exchange.read_x3p(path)
    if head.startswith(b"\x93NUMPY"):
        return arrays.read_npy(path)
    if head.startswith(_NETCDF):
        return _open_hdf(path, head)
    if head.startswith(_SDF):
        return exchange.read_sdf(path)
    if text.looks_like_text(head) and not head.startswith(_TEXT_WITH_BINARY):
        return text.read_text(path)
    return instrument.read_instrument(path, head)


def _open_hdf(path, head):
    """Open what begins as netCDF or HDF5; Zygo's DATX is HDF5 too, with a group MetaData."""
    if head.startswith(b"\x89HDF"):
        import h5py

        try:
            with h5py.File(path) as file:
                zygo = "MetaData" in file
        except OSError as error:
            raise InputFileError(f"{path}: damaged or cut off HDF5 file ({brief(error)})") from error
        if zygo:
            return instrument.read_instrument(path, head)
    return arrays.read_netcdf(path)


def _given(value):
    """Return None for what an empty cell of a table may hand over."""
    if value is None or (isinstance(value, str) and not value.strip()) or value != value:
        return None
    return value


def _scales(channel: Channel, path, *, dx, dy, unit, height_unit, notes) -> tuple[tuple[float, float], float]:
    """Return the steps (dx, dy) in m and the metres per unit of the file's heights.

    An argument wins over the file; where both speak and differ, `notes` gets a sentence.
    """
    if channel.no_height and height_unit is None and not is_length(channel.height_unit):
        raise InputFileError(f"{path}: channel {channel.name!r} holds no heights ({channel.no_height})")
    lateral = _lateral_factor(channel, path, unit, notes, needed=None in (dx, dy))
    profile = channel.shape[0] == 1
    steps = {}
    for name, argument, stated in (("dx", dx, channel.dx), ("dy", dy, channel.dy)):
        if argument is None:
            steps[name] = None if stated is None or lateral is None else stated * lateral
            continue
        steps[name] = _positive(argument, name, path) * _unit_of_steps(unit, f"{name} = {argument}", path)
        if stated is not None and channel.lateral_unit is not None and is_length(channel.lateral_unit):
            in_file = stated * metres(channel.lateral_unit)
            if abs(in_file / steps[name] - 1) > 1e-3:
                notes.append(
                    f"{name} = {steps[name]:.6g} m as given by the user, where the file says {in_file:.6g} m"
                )
    if profile and steps["dy"] is None:
        steps["dy"] = steps["dx"]
    if None in steps.values():
        raise InputFileError(_what_is_missing(channel, path))
    if channel.steps_from_size and dx is None and dy is None:
        _refuse_cut_matrix(channel, steps, path)
    return (steps["dx"], steps["dy"]), _height_factor(channel, path, unit, height_unit, notes)


def _lateral_factor(channel, path, unit, notes, *, needed) -> float | None:
    """Return the metres per unit of the file's own steps, None where nobody says it."""
    stated = channel.lateral_unit
    if unit is None:
        return metres(stated, where=f"{path}: lateral unit") if stated is not None and needed else None
    factor = metres(unit, where=f"{path}: unit", error=SettingsError)
    if (
        needed
        and stated is not None
        and channel.dx is not None
        and (not is_length(stated) or metres(stated) != factor)
    ):
        notes.append(f"the steps are taken in {unit} as given by the user, where the file says {stated}")
    return factor


def _height_factor(channel, path, unit, height_unit, notes) -> float:
    stated = channel.height_unit
    if height_unit is not None:
        factor = metres(height_unit, where=f"{path}: height_unit", error=SettingsError)
        if stated is not None and (not is_length(stated) or metres(stated) != factor):
            notes.append(
                f"the heights are taken in {height_unit} as given by the user, where the file says {stated}"
            )
        return factor
    if stated is not None:
        return metres(stated, where=f"{path}: height unit")
    if unit is None:
        raise InputFileError(
            f"{path}: the file does not say the unit of its heights; give height_unit (or unit) "
            "in the table of surfaces or as an argument"
        )
    return metres(unit, where=f"{path}: unit", error=SettingsError)


def _unit_of_steps(unit, argument, path) -> float:
    """Return the metres per unit of steps that the user gives."""
    if unit is None:
        raise SettingsError(f"{path}: {argument} is given without a unit; give unit as well")
    return metres(unit, where=f"{path}: unit", error=SettingsError)


def _positive(value, name, path) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = np.nan
    if not (np.isfinite(number) and number > 0) or isinstance(value, bool):
        raise SettingsError(f"{path}: {name} = {value!r} must be a positive number")
    return number


def _what_is_missing(channel, path) -> str:
    ny, nx = channel.shape
    kind = f"a profile of {nx} points" if ny == 1 else f"a map of {ny} x {nx} points"
    known = f" (its heights are in {channel.height_unit})" if channel.height_unit else ""
    stated = {"dx": channel.dx} if ny == 1 else {"dx": channel.dx, "dy": channel.dy}
    absent = [name for name, step in stated.items() if step is None]
    return (
        f"{path}: {kind} that does not say its {'size' if absent else 'lateral unit'}{known}; "
        f"give {', '.join([*absent, 'unit'])} in the table of surfaces or as arguments"
    )


def _refuse_cut_matrix(channel, steps, path):
    """Refuse a text matrix that seems to have lost its last lines.

    Its header gives the size of the whole field and not the number of lines, so that a file that was cut off
    shows only in pixels that are too long along y. Scans with every second, third ... line are let through.
    """
    ratio = steps["dy"] / steps["dx"]
    if ratio > 1.01 and abs(ratio / round(ratio) - 1) > 0.01:
        ny, nx = channel.shape
        raise InputFileError(
            f"{path}: {ny} lines of {nx} numbers do not fit the size in the header: the pixels would be "
            f"{steps['dx']:.6g} m x {steps['dy']:.6g} m; the file seems to be cut off. If it is whole, "
            "give dx, dy and unit"
        )


def _checked(heights, path) -> np.ndarray:
    if heights.size == 1:
        raise HeightMapError(f"{path}: the map has a single point; a map or a profile needs at least two")
    if not np.isfinite(heights).any():
        raise HeightMapError(f"{path}: all {heights.size} points of the map are missing; check the channel")
    largest = np.nanmax(np.abs(heights))
    if largest > _LARGEST_HEIGHT:
        raise HeightMapError(
            f"{path}: heights up to {largest:.3g} m are no measurement; the height unit is wrong or the file "
            "is damaged (for instance a binary file whose line ends were converted)"
        )
    return heights


def _centres(count, step, first, factor) -> np.ndarray:
    """Return cell centres in m: from where the file puts the first one, else from half a step."""
    start = 0.5 * step if first is None or factor is None else first * factor
    return start + step * np.arange(count)


def _described(channel: Channel) -> dict:
    described = {
        "name": channel.name,
        "ny": channel.shape[0],
        "nx": channel.shape[1],
        "dx": channel.dx,
        "dy": channel.dy,
        "lateral_unit": channel.lateral_unit,
        "height_unit": channel.height_unit,
        "is_height": not channel.no_height,
        "reason": channel.no_height,
    }
    values = None if channel.no_height else channel.read()
    if values is not None and np.isfinite(values).any():
        missing = int(np.isnan(values).sum())
        described |= {
            "missing_points": missing,
            "missing_share": missing / values.size,
            "rms_height": float(np.nanstd(values)),
            "lowest": float(np.nanmin(values)),
            "highest": float(np.nanmax(values)),
        }
    return described
=======
>>>>>>> 3df81f8 (Reading by ideas: readers found in a folder, the scale, the request, the conversion and the two verbs in a module each)
