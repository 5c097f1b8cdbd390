"""Links from a surface's part of the report to its result files, from wherever that part is placed."""

import html
import os
import re
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import quote

_LINK = re.compile(r'<a class="file" href="([^"]*)"')


def relative_links(panel: str | Path, files: Mapping[str, str | Path]) -> list[tuple[str, str, str]]:
    """Return (content, name, address) of the files of a surface, seen from its panel.

    Examples
    --------
    >>> relative_links("results/soft/one/panel.html", {"solved window": "results/hard/one/window.nc"})
    [('solved window', 'window.nc', '../../hard/one/window.nc')]
    """
    folder = Path(panel).parent
    return [
        (holds, Path(file).name, quote(Path(os.path.relpath(file, folder)).as_posix()))
        for holds, file in files.items()
    ]


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
    route = quote(Path(os.path.relpath(Path(panel).parent, folder)).as_posix())

    def moved(link: re.Match[str]) -> str:
        address = os.path.normpath(f"{route}/{html.unescape(link[1])}")
        return f'<a class="file" href="{html.escape(Path(address).as_posix())}"'

    return _LINK.sub(moved, text)
