"""Content of a measured file, and the map that it would give."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact.errors import HeightMapError, InputFileError
from roughcontact.io.channels import Channel, MeasuredFile
from roughcontact.io.conversion import Converted, convert
from roughcontact.io.guards import MAX_POINTS, naming, sha256
from roughcontact.io.plausibility import quantisation_step, roughness_off_plane
from roughcontact.io.registry import open_file
from roughcontact.io.request import Request

_LARGE = 2**24  # points


def inspect_file(path: str | Path, **request: Any) -> dict:
    r"""Return the content of a file, without asking for missing units.

    Parameters
    ----------
    path : str or Path
    **request
        As for `read_height_map`, but for `instrument`.

    Returns
    -------
    dict
        `file`, `bytes`, `sha256`, `format`, `first_row` and `first_row_assumed` (as `read_height_map` gives
        them), `instrument`; `channel` (the one that would be read, or None) and `channel_choice` (why);
        `channels`, one dict per channel with `name`, `ny`, `nx`, `dx`, `dy`, `lateral_unit`, `height_unit`
        (None where the file does not state it), `is_height`, `reason`, and for heights `missing_points`,
        `missing_share`, `rms_height`, `lowest`, `highest` (in `height_unit`);
        `map`, the result of `read_height_map`, None where it would fail: `ny`, `nx`, `dx`, `dy`, `size_x`,
        `size_y`, `missing_points`, `missing_share`, `lowest`, `highest`, `rms_height` and `rms_gradient` (off
        the mean plane), `quantisation_step` (None where heights are not quantised), in m;
        `problem`: the error message of `read_height_map`, or None; `needed`: the arguments that it asks for;
        `warnings`; `sources`, as the attribute
        `ingest_sources` of `read_height_map`.

    Raises
    ------
    InputFileError
        As for `read_height_map`, but not for missing units and sizes.
    SettingsError
        For an invalid argument.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = Path(folder.name) / "map.txt"
    >>> _ = path.write_text("Value units: nm\n1 2 3 4\n5 6 BAD 8\n")
    >>> found = inspect_file(path)
    >>> found["format"], found["map"], found["channels"][0]["height_unit"]
    ('text matrix', None, 'nm')
    >>> found["problem"].partition(";")[2]
    ' give dx, dy, unit in the table of surfaces or as arguments'
    >>> inspect_file(path, dx=1, dy=1, unit="um")["map"]["size_x"]
    4e-06
    >>> folder.cleanup()
    """
    return inspect_heights(Path(path), Request(**request))[0]


def inspect_heights(path: Path, request: Request) -> tuple[dict, np.ndarray | None]:
    """Return the content of a file, and the heights (ny, nx; m) of `read_height_map`, None where it fails."""
    with naming(path), closing(open_file(path)) as file:
        content = {"file": path.name, "bytes": path.stat().st_size, "sha256": sha256(path)}
        content |= {"format": file.format, "first_row": file.first_row}
        content |= {"first_row_assumed": file.first_row_assumed, "instrument": file.instrument}
        map_content, heights = _map(path, request, file)
        channels = list(_descriptions(file.channels, path, chosen=map_content["channel"]))
    return content | map_content | {"channels": channels}, heights


def _map(path: Path, request: Request, file: MeasuredFile) -> tuple[dict, np.ndarray | None]:
    """Return what is known of the map that an open file would give, and its heights."""
    content = dict.fromkeys(("channel", "channel_choice", "channels", "map", "problem"))
    content |= {"needed": [], "warnings": list(file.warnings), "sources": {}}
    try:
        with naming(path):
            result = convert(file, request)
    except (InputFileError, HeightMapError) as error:
        # the channel is shown although it cannot be converted: that is why people look
        heights = (channel.name for channel in file.channels if not (channel.no_height or request.channel))
        content |= {"channel": next(heights, None), "problem": str(error), "needed": [*error.keys]}
        return content, None
    content |= {"channel": result.channel.name, "channel_choice": result.choice, "map": _measured(result)}
    content |= {key: getattr(result, key) for key in ("sources", "first_row", "first_row_assumed")}
    return content | {"warnings": [*result.notes, *map(str, result.doubts)]}, result.heights


def _measured(result: Converted) -> dict:
    """Return properties of a map (m) as measured."""
    heights, dx, dy = result.heights, result.dx, result.dy
    ny, nx = heights.shape
    rms_height, rms_gradient = roughness_off_plane(heights, dx, dy)
    properties = {"ny": ny, "nx": nx, "dx": dx, "dy": dy, "size_x": nx * dx, "size_y": ny * dy}
    properties |= _extent(heights) | {"rms_height": rms_height, "rms_gradient": rms_gradient}
    return properties | {"quantisation_step": quantisation_step(heights)}


def _descriptions(channels: list[Channel], path: Path, *, chosen: str | None) -> Iterator[dict]:
    """Yield properties of the channels, in the units of the file, with those of the heights that are read.

    Of large channels, and of many, the chosen one alone is read.
    """
    total = 0
    for channel in channels:
        ny, nx = channel.shape
        total += ny * nx
        properties = {"name": channel.name, "ny": ny, "nx": nx}
        properties |= {key: getattr(channel, key) for key in ("dx", "dy", "lateral_unit", "height_unit")}
        properties |= {"is_height": not channel.no_height, "reason": channel.no_height}
        is_read = (ny * nx <= _LARGE and total <= MAX_POINTS) or channel.name == chosen
        if is_read and not channel.no_height:
            try:
                with naming(path):
                    values = channel.count_height * channel.read()
                if np.isfinite(values).any():
                    properties |= _extent(values) | {"rms_height": float(np.nanstd(values))}
            except InputFileError as error:
                properties["reason"] = str(error)
        yield properties


def _extent(heights: np.ndarray) -> dict:
    """Return number and share of the missing points, the lowest and the highest height."""
    missing = int(np.isnan(heights).sum())
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    share = missing / heights.size
    return {"missing_points": missing, "missing_share": share, "lowest": low, "highest": high}
