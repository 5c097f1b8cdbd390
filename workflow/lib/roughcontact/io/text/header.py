"""Metadata from the header of a text file: sizes, steps, numbers of points, units, instrument."""

import re
from collections.abc import Iterable
from itertools import islice, pairwise
from typing import Any

from roughcontact.io.units import is_length

_MAX_LINE_LENGTH = 4096  # characters; longer lines contain no metadata
_MAX_LINES = 100_000  # lines

# entries of a header: meaning -> spellings (lower case, without _ and -)
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
        # as localised programs write it
        *("breite", "largeur", "larghezza", "anchura", "ancho", "largura", "breedte", "bredd", "šířka"),
        *("szerokość", "szélesség", "genişlik", "ширина", "幅", "宽度", "너비"),
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
        *("höhe", "hoehe", "hauteur", "altezza", "altura", "alto", "hoogte", "höjd", "výška"),
        *("wysokość", "magasság", "yükseklik", "высота", "高さ", "高度", "높이"),
    ),
    "step": (
        "pixel size",
        "pixelsize",
        "cell size",
        "cellsize",
        "spacing",
        "step",
        "resolution",
        "xy calibration",
        "xy kalibrierung",
    ),
    "size": ("size", "scan size", "image size", "field", "field size", "field of view", "measured area"),
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
    "nx": (
        "w",
        "nx",
        "columns",
        "ncols",
        "x pixels",
        "xpixels",
        "x points",
        "samples",
        "points per line",
        "horizontal",
    ),
    "ny": ("h", "ny", "rows", "nrows", "y pixels", "ypixels", "y points", "lines", "vertical", "vertikal"),
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
            "vertical unit",
            "vertical units",
        ),
        *("unit z", "units z", "unit of z", "z einheit", "einheit z", "unité z", "unité des valeurs"),
        *("exported image units", "image units", "image data unit", "heights in"),
        *(
            "werteinheit",
            "werteinheiten",
            "werteeinheit",
            "werteeinheiten",
            "werte einheiten",
            "einheit der werte",
            "einheiten der werte",
        ),
    ),
    "lateral_unit": (
        "lateral unit",
        "lateral units",
        "xy unit",
        "xy units",
        "x unit",
        "xunit",
        "horizontal unit",
        "horizontal units",
    ),
    "unit": ("unit", "units", "einheit", "einheiten", "unité", "unidad", "unità"),
    "count": ("number of points", "points", "num points", "numpoints", "data points", "number of samples"),
    "z_factor": ("bit2nm", "height conversion factor", "z factor", "zfactor"),
    "missing": ("nodata value", "nodata", "missing value", "no data value"),
    "channel": (
        "channel",
        "channel name",
        "kanal",
        "canal",
        "canale",
        "kanaal",
        "kanał",
        "канал",
        "チャンネル",
    ),
    "instrument": ("instrument", "instrument name", "microscope", "device"),
    "serial": ("serial", "serial number", "serial no", "instrument serial number"),
    "lens": ("lens", "objective", "objective lens"),
    "date": ("date", "date time", "acquisition date", "acquisition time", "measured"),
}
# those with a text as value
_WORDS = (
    "channel",
    "height_unit",
    "lateral_unit",
    "unit",
    "instrument",
    "serial",
    "lens",
    "date",
)
_UNIT_IN_NAME = {"bit2nm": "nm"}  # keys that imply the unit of their value: counts to nanometres
_BOTH = {"size": ("width", "height"), "step": ("dx", "dy")}  # entries that give two values in one line
_MEANING = {word: meaning for meaning, words in _HEADER_WORDS.items() for word in words}
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


def parse_header(lines: Iterable[str]) -> dict[str, Any]:
    """Return the entries of the header that are understood.

    Every line is read once from its beginning to its end. Lines of more than 4096 characters, and those after
    the first 100 000, are skipped.

    Returns
    -------
    dict
        The keys are `length_x`, `length_y`, `step`, `dx`, `dy`, `nx`, `ny`, `count`, `z_factor`, `missing`
        (numbers), `height_unit`, `lateral_unit`, `unit`, `channel`, `instrument`, `serial`, `lens`, `date`
        (texts); a key with ``_unit`` appended gives the unit of that value; with ``_rounding`` appended,
        half a unit of the last digit of a length. Of repeated entries the first one counts.

    Examples
    --------
    >>> said = parse_header(["# Width: 10,5 µm", "# Value units: nm", "rows=4 columns=5", "colour: red"])
    >>> said["length_x"], said["length_x_unit"], said["length_x_rounding"]
    (10.5, 'µm', 0.05)
    >>> said["height_unit"], said["ny"], said["nx"]
    ('nm', 4.0, 5.0)
    >>> parse_header(['"XY calibration","692.3","nm/pixel"'])
    {'step': 692.3, 'step_unit': 'nm'}
    """
    said: dict[str, Any] = {}
    for line in islice(lines, _MAX_LINES):
        if len(line) > _MAX_LINE_LENGTH or not (plain := line.strip().lstrip("#%;!\\*/ \t").strip()):
            continue
        text = re.sub(r"(\d),(\d)", r"\1.\2", plain)
        pairs = _pairs(text)
        if len(pairs) > 1:  # "h=305 w=75"
            for key, value in pairs:
                _record_entry(said, key, "", value)
        elif (end := min((text.find(sign) for sign in ":=\t" if sign in text), default=-1)) > 0:
            key, unit = _key_and_unit(text[:end])
            _record_entry(said, key, unit, text[end + 1 :].strip())
        elif any(sign in plain for sign in ";,") and (entry := _row(plain)):
            _record_entry(said, *entry)
        elif len(words := text.split()) == 2:
            _record_entry(said, words[0], "", words[1])
    return said


def _pairs(text: str) -> list[tuple[str, str]]:
    """Return the pairs of a line such as ``h=305 w=75``."""
    parts = text.split("=")
    pairs = []
    for before, after in pairwise(parts):
        keys, values = before.split(), after.split()
        if keys and values:
            pairs.append((keys[-1], values[0]))
    return pairs


def _key_and_unit(key: str) -> tuple[str, str]:
    """Return a key without its brackets, and the unit in these."""
    name, opening, rest = key.replace("[", "(").partition("(")
    unit = rest.replace("]", ")").partition(")")[0].strip() if opening else ""
    return name, unit.removeprefix("->").strip()


def _row(text: str) -> tuple[str, str, str] | None:
    """Return key, unit and value of a line of a table, as ``"Width";"640,5";"µm"``; None for other lines."""
    cells = [cell.strip().strip('"').strip() for cell in text.split(";" if ";" in text else '","')]
    if len(cells) == 1:
        cells = [cell.strip().strip('"').strip() for cell in text.split(",")]
    key, unit = _key_and_unit(cells[0])
    if len(cells) < 2 or _meaning(key) is None:
        return None
    value = re.sub(r"(\d),(\d)", r"\1.\2", cells[1])
    return key, unit or (cells[2] if len(cells) > 2 else ""), value


def _meaning(key: str) -> str | None:
    """Return the meaning of a key, or None for an unknown key."""
    return _MEANING.get(re.sub(r"[\s_-]+", " ", key).strip().strip('"').lower())


def _record_entry(said: dict[str, Any], key: str, unit: str, value: str) -> None:
    """Record the meaning of one header entry in `said`, unless it is unknown or already recorded."""
    meaning, value = _meaning(key), value.strip().strip('"').strip()
    if meaning is None or meaning in said:
        return
    if meaning in _WORDS:
        if value and (meaning != "unit" or is_length(value)):
            said[meaning] = value
        return
    both = re.split(r" x |(?<=\d)x(?=\d)", value.replace("×", "x").replace("*", "x"))
    if len(both) == 2 and meaning in _BOTH:
        _record_pair(said, _BOTH[meaning], *both)
        return
    match = re.match(rf"({_NUMBER})\s*(.*)$", value)
    if match and meaning != "size":
        said[meaning] = float(match[1])
        if meaning.startswith("length"):
            said[meaning + "_rounding"] = _half_last_digit(match[1])
        unit = match[2].strip().strip("()[]") or unit or _UNIT_IN_NAME.get(key.strip().lower(), "")
        unit = re.sub(r"\s*/\s*(pixel|px|point|pt|sample)s?$", "", unit, flags=re.IGNORECASE)
        if unit:
            said[meaning + "_unit"] = unit


def _record_pair(said: dict[str, Any], keys: tuple[str, str], along_x: str, along_y: str) -> None:
    """Record lengths along x and y, as in ``20 µm x 18 µm``; without a unit, numbers of points."""
    unit = re.sub(rf"^{_NUMBER}\s*", "", along_y.strip())
    for key, value in zip(keys, (along_x, along_y), strict=True):
        if is_length(unit):
            _record_entry(said, key, unit, value)


def _half_last_digit(number: str) -> float:
    """Return half a unit of the last digit of a number; 0 for a number without decimals."""
    mantissa, _, exponent = number.lower().partition("e")
    if "." not in mantissa:
        return 0.0
    decimals = len(mantissa.partition(".")[2])
    return 0.5 * 10.0 ** max(min(int(exponent or 0) - decimals, 300), -300)
