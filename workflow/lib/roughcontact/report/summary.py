"""What the page takes of a panel: its summary, a JSON file beside it, and its text with links to files."""

import html
import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypedDict, cast, get_origin
from urllib.parse import quote

from roughcontact.errors import InputFileError
from roughcontact.results.storage import write_text

_MAX_BYTES = 2**20
_LINK = re.compile(r'<a class="file" href="([^"]*)"')


class Summary(TypedDict):
    """The content of `panel.json`."""

    identifier: str  # of the section of the panel, for links
    name: str  # of the surface, with that of the case
    surface: str
    answer: str  # what is asked for, in one line
    verdict: str  # a key of `outcome.VERDICTS`
    reasons: list[str]  # of each check that did not pass, the most important first
    doubts: list[str]  # the names of these checks
    main_reason: str  # the first reason that concerns what is asked, in one line of the table
    halve: str  # what would halve the ± of what is asked for; empty where there is none
    halved: str  # whose ± that is: "leak"
    places: str  # how many make it known to ± 10 %; empty where it is
    overview: str  # how well gap and area are known with and without the overview; empty without one
    loads: list[int]  # indices of those shown in tables, loads rising
    measured: str  # date of the measurement, ISO 8601; empty where the file states none
    waves: str  # for which the numbers hold, in words


def write_summary(summary: Mapping[str, Any], panel: str | Path) -> None:
    """Write a `Summary` of a panel beside it, under its name with the ending `.json`."""
    write_text(json.dumps(summary, sort_keys=True) + "\n", Path(panel).with_suffix(".json"))


def read_summary(panel: str | Path) -> Summary:
    """Return the summary of a panel; `InputFileError` where its file is missing or damaged."""
    path = Path(panel).with_suffix(".json")
    try:
        is_small = path.is_file() and path.stat().st_size < _MAX_BYTES
        result = json.loads(path.read_text(encoding="utf-8") if is_small else "")
    except (OSError, ValueError, RecursionError):
        result = None
    kinds = {key: get_origin(kind) or kind for key, kind in Summary.__annotations__.items()}
    if not isinstance(result, dict) or {key: type(value) for key, value in result.items()} != kinds:
        raise InputFileError(f"{path}: no summary of a panel; delete {panel} and run again")
    return cast(Summary, result)


def relative_links(panel: str | Path, files: Mapping[str, str | Path]) -> list[tuple[str, str, str]]:
    """Return (content, name, address) of the files of a surface, seen from its panel.

    Examples
    --------
    >>> relative_links("results/soft/one/panel.html", {"solved window": "results/hard/one/window.nc"})
    [('solved window', 'window.nc', '../../hard/one/window.nc')]
    """
    return [(holds, Path(file).name, _address(file, Path(panel).parent)) for holds, file in files.items()]


def _address(file: str | Path, folder: str | Path) -> str:
    """Return the address of a file as seen from a page in a folder."""
    return quote(Path(os.path.relpath(file, folder)).as_posix())


def from_page(text: str, panel: str | Path, folder: str | Path) -> str:
    """Return the text of a panel with its links to files as seen from a page in `folder`.

    Examples
    --------
    >>> link = '<a class="file" href="window.nc">'
    >>> from_page(link, "results/one/panel.html", "results")
    '<a class="file" href="one/window.nc">'
    >>> from_page(link, "results/one/panel.html", "results/pages")
    '<a class="file" href="../one/window.nc">'
    """
    route = _address(Path(panel).parent, folder)

    def moved(link: re.Match[str]) -> str:
        address = os.path.normpath(f"{route}/{html.unescape(link[1])}")
        return f'<a class="file" href="{html.escape(Path(address).as_posix())}"'

    return _LINK.sub(moved, text)
