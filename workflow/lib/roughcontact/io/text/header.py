"""What the header of a text file says: sizes, steps, numbers of points, units, and of the instrument."""

import re
from collections.abc import Iterable
from typing import Any

# what a line of the header may say: meaning -> spellings (lower case, without _ and -)
_HEADER_WORDS = {
    "length_x": (
        "width",
        "x size",
        "size x",
        "xsize",
        "x length",
        "length x",
        "scan width",
        "x range",
        "range x",
    ),
    "length_y": (
        "height",
        "y size",
        "size y",
        "ysize",
        "y length",
        "length y",
        "scan height",
        "y range",
        "range y",
    ),
    "step": ("pixel size", "pixelsize", "cell size", "cellsize", "spacing", "step", "resolution"),
    "dx": (
        "dx",
        "x step",
        "step x",
        "xstep",
        "pixel width",
        "x spacing",
        "spacing x",
        "x increment",
        "xscale",
    ),
    "dy": (
        "dy",
        "y step",
        "step y",
        "ystep",
        "pixel height",
        "y spacing",
        "spacing y",
        "y increment",
        "yscale",
    ),
    "nx": ("w", "nx", "columns", "ncols", "x pixels", "xpixels", "x points", "samples", "points per line"),
    "ny": ("h", "ny", "rows", "nrows", "y pixels", "ypixels", "y points", "lines"),
    "height_unit": (
        *(
            "value units",
            "value unit",
            "z unit",
            "z units",
            "zunit",
            "height unit",
            "height units",
            "data unit",
        ),
        *("exported image units", "image units", "image data unit", "heights in"),
    ),
    "lateral_unit": ("lateral unit", "lateral units", "xy unit", "xy units", "x unit", "xunit"),
    "z_factor": ("height conversion factor", "z factor", "zfactor"),
    "missing": ("nodata value", "nodata", "missing value", "no data value"),
    "channel": ("channel", "channel name"),
    "instrument": ("instrument", "instrument name", "microscope", "device"),
    "serial": ("serial", "serial number", "serial no", "instrument serial number"),
    "lens": ("lens", "objective", "objective lens"),
    "date": ("date", "date time", "acquisition date", "acquisition time", "measured"),
}
# those that are no numbers
_WORDS = (
    "channel",
    "height_unit",
    "lateral_unit",
    "instrument",
    "serial",
    "lens",
    "date",
)
_MEANING = {word: meaning for meaning, words in _HEADER_WORDS.items() for word in words}
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


def parse_header(lines: Iterable[str]) -> dict[str, Any]:
    """Return what the header says.

    Parameters
    ----------
    lines : iterable of str

    Returns
    -------
    dict
        Meaning -> value; meaning with ``_unit`` appended -> unit of that value. The meanings are `length_x`,
        `length_y`, `step`, `dx`, `dy`, `nx`, `ny`, `z_factor`, `missing` (numbers), `height_unit`,
        `lateral_unit`, `channel`, `instrument`, `serial`, `lens`, `date` (words). What is said twice counts
        as it is said first.

    Examples
    --------
    >>> parse_header(["# Width: 10,5 µm", "# Value units: nm", "rows=4 columns=5", "colour: red"])
    {'length_x': 10.5, 'length_x_unit': 'µm', 'height_unit': 'nm', 'ny': 4.0, 'nx': 5.0}
    """
    said: dict[str, Any] = {}
    for line in lines:
        text = re.sub(r"(\d),(\d)", r"\1.\2", line.strip().lstrip("#%;!\\*/ \t").strip())
        pairs = re.findall(r"(\w+)\s*=\s*(\S+)", text)
        if len(pairs) > 1:  # "h=305 w=75"
            for key, value in pairs:
                _note(said, key, "", value)
            continue
        match = re.match(r"([^:=\t]+?)\s*[:=\t]\s*(.*)$", text) or re.match(r"(\w+)\s+(\S+)$", text)
        if match:
            key, value = match.groups()
            unit = re.search(r"[(\[]\s*(?:->)?\s*([^)\]]+?)\s*[)\]]", key)
            _note(said, re.sub(r"[(\[].*", "", key), unit[1] if unit else "", value)
    return said


def _note(said: dict[str, Any], key: str, unit: str, value: str) -> None:
    """Note in `said` what one entry of the header means, unless it means nothing or was said before."""
    meaning = _MEANING.get(re.sub(r"[\s_-]+", " ", key).strip().lower())
    if meaning is None or meaning in said:
        return
    if meaning in _WORDS:
        if value.strip():
            said[meaning] = value.strip()
        return
    match = re.match(rf"({_NUMBER})\s*(.*)$", value.strip())
    if match:
        said[meaning] = float(match[1])
        unit = match[2].strip().strip("()[]") or unit
        if unit:
            said[meaning + "_unit"] = unit


def column_units(lines: list[str], count: int, delimiter: str | None) -> list[str | None] | None:
    """Return the unit of each column from a line of column names, as ``x (µm)``, ``X_[mm]`` or ``z/nm``.

    Parameters
    ----------
    lines : list of str
        The header.
    count : int
        Number of columns of the table.
    delimiter : str or None
        What separates them; None for white space, at which names are not told apart.

    Returns
    -------
    list of str or None
        One entry per column, None for a column without a unit; None where no line names the columns.

    Examples
    --------
    >>> column_units(["a trace", "X (µm);z/nm"], 2, ";")
    ['µm', 'nm']
    """
    for line in reversed(lines):
        names = line.strip().lstrip("#%").strip().split(delimiter)
        if len(names) != count or delimiter is None:
            continue
        units = [re.search(r"[(\[]\s*([^)\]]+?)\s*[)\]]|/\s*(\S+)$", name) for name in names]
        return [match and (match[1] or match[2]) for match in units]
    return None
