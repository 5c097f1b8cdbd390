"""What a panel says of itself to the page it will be part of: a line of JSON within the panel.

A panel holds one element `<script type="application/json" class="summary">`, whose text is the JSON object of
a `Summary`. Browsers do not show it; `page` builds its table of verdicts and its links from it.
"""

import json
from html.parser import HTMLParser
from pathlib import Path
from typing import TypedDict

from roughcontact.errors import InputFileError

_PIECE = 4096  # of a panel that is searched at once


class Summary(TypedDict):
    """What the page must know of a panel."""

    identifier: str  # of its section, for links
    name: str  # of the surface, with that of the case
    surface: str
    verdict: str  # a key of `checks.VERDICTS`
    reasons: list[str]  # a sentence for each check that did not pass, the weightiest first
    not_judged: list[str]  # names of the checks that could not be made


class _Finder(HTMLParser):
    """Collects the text of the element that holds the summary."""

    def __init__(self) -> None:
        super().__init__()
        self.text: str | None = None
        self._inside = False
        self.found = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._inside = tag == "script" and ("class", "summary") in attrs
        if self._inside and self.text is None:
            self.text = ""

    def handle_data(self, data: str) -> None:
        if self._inside and self.text is not None:
            self.text += data

    def handle_endtag(self, tag: str) -> None:
        self.found |= self._inside
        self._inside = False


def embedded(summary: Summary) -> str:
    r"""Return a summary as the text of a script element.

    Parameters
    ----------
    summary : dict
        what the page must know of a panel.

    Returns
    -------
    str
        JSON without the character that could end the element.

    Examples
    --------
    >>> said = {"identifier": "1", "name": "<1>", "surface": "1", "verdict": "passed"}
    >>> print(embedded(said | {"reasons": [], "not_judged": ["Band"]}).partition(", ")[2])
    "name": "\u003c1>", "not_judged": ["Band"], "reasons": [], "surface": "1", "verdict": "passed"}
    """
    return json.dumps(summary, sort_keys=True).replace("<", "\\u003c")


def summary_of(panel: str, path: str | Path) -> Summary:
    """Return what a panel says of itself.

    Parameters
    ----------
    panel : str
        the HTML that `write_panel` wrote.
    path : path
        where it was read, for the message.

    Returns
    -------
    dict
        `identifier`, `name`, `surface`, `verdict`, `reasons`, `not_judged`.

    Raises
    ------
    InputFileError
        where `panel` is something else.

    Examples
    --------
    >>> said = '{"identifier": "one", "name": "one", "reasons": [], "verdict": "passed"}'
    >>> panel = f'<section><script type="application/json" class="summary">{said}</script></section>'
    >>> summary_of(panel, "panel.html")["verdict"]
    'passed'
    """
    finder = _Finder()
    for start in range(0, len(panel), _PIECE):  # it stands near the beginning, before the pictures
        finder.feed(panel[start : start + _PIECE])
        if finder.found:
            break
    if finder.text is None:
        raise InputFileError(f"{path}: is no part of a report; delete it and run again")
    return json.loads(finder.text)
