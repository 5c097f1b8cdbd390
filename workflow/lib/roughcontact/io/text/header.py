"""Statements in the header of a text file: sizes, steps, numbers of points, units, instrument.

All of them are collected before any is used, so that those that contradict each other are named.
"""

import math
import re
from collections.abc import Iterable, Iterator
from itertools import chain, combinations, islice
from typing import Any, NamedTuple

from roughcontact.io.units import is_length, metres, same_length
from roughcontact.io.vocabulary import meanings, words

_MAX_LINE_LENGTH = 4096  # characters; longer lines contain no metadata
_MAX_LINES = 100_000  # lines

# those with a text as value
_TEXT_ENTRIES = ("channel", "height_unit", "lateral_unit", "unit", "instrument", "serial", "lens", "date")
LENGTHS = ("length_x", "length_y", "length", "dx", "dy", "step", "size")
_COUNTS = ("nx", "ny", "count")
_REPEATED = ("channel", "instrument", "serial", "lens", "date", "missing", "height_range", "count", "length")
_UNIT_IN_NAME = {"bit2nm": "nm"}  # keys that imply the unit of their value: counts to nanometres
_TWO_VALUES = {"size": ("length_x", "length_y"), "step": ("dx", "dy")}  # entries with two values in one line
_PIXELS = {"length_x": "nx", "length_y": "ny"}  # a size in pixels is a number of them
_PIXEL_WORDS = ("px", "pixel", "pixels", "points", "pts", "samples")
_MEANING = meanings("header") | dict.fromkeys(words("header")["height"], "length_y")
_NUMBER = re.compile(r"[-+]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][-+]?\d+)?")
_BETWEEN_SIDES = re.compile(r"(?<=[\w)\]])(?: (?:x|by|/) |x(?=\d)|(?:;\s*|,\s+)(?=\d))|(?<=[^\W\d])\s+(?=\d)")
_RANGE = re.compile(r"(?:[^\w%]|x|by|to|bis)*\d")  # a second number behind the first: two sides, or limits
_PER_PIXEL = re.compile(r"\s*(?:/|per)\s*(?:pixel|px|point|pt|sample)s?$", re.IGNORECASE)
# its pixels, or steps, are not the map's
_CAMERA = re.compile(r"(?=.*pixel).*\b(?:camera|sensor|detector|ccd)\b|.*\b(?:motor|moteur)\b", re.IGNORECASE)
_HEIGHT_WORD = re.compile(rf"\W*(?:{'|'.join(words('header')['height'])})\b", re.IGNORECASE)
_LONGEST = 60  # characters of a line that a message shows
_SLACK, _WIDEST_SLACK = 1e-3, 1e-2  # relative difference of agreeing lengths: without and with rounding
_ODD_PIXEL = 10.0  # ratio of the sides of a pixel above which two different units of them are doubted


class Statement(NamedTuple):
    """One entry of a header, `rounding` half a unit of its last digit, 0 for a whole number."""

    value: Any  # text or number, NaN where a mark may be a decimal sign or separate thousands
    unit: str  # empty where there is none
    rounding: float
    line: int
    text: str

    def __str__(self) -> str:
        return f"line {self.line} says {self.text!r}"


Stated = dict[str, list[Statement]]


def statements(lines: Iterable[str], *, first: int = 1, sign: str = "") -> Stated:
    """Return the entries of a header that are understood, by meaning, in the order of the lines.

    `first` is the number of the first line in the file, `sign` the decimal sign of its table, empty for whole
    numbers; lines of more than 4096 characters, and those after the first 100 000, are skipped.

    Examples
    --------
    >>> stated = statements(["# Width: 10,5 µm", "dx=0.5 mm, dy=2 mm", "rows=4 columns=5", "colour: red"])
    >>> stated["length_x"][0][:4], stated["dy"][0][:2], stated["nx"][0].value
    ((10.5, 'µm', 0.05, 1), (2.0, 'mm'), 5.0)
    >>> statements(['"XY calibration","692.3","nm/pixel"'])["step"][0][:2]
    (692.3, 'nm')
    >>> print(*statements(["Width: 1,234 µm"], sign=".")["length_x"])
    line 1 says 'Width: 1,234 µm'
    """
    stated: Stated = {}
    for number, line in enumerate(islice(lines, _MAX_LINES), start=first):
        text = line.strip().lstrip("#%;!\\*/ \t").strip()
        if not text or len(line) > _MAX_LINE_LENGTH or _CAMERA.search(text):
            continue
        for key, value in _entries(text):
            for meaning, statement in _statements_of(key, value, sign):
                stated.setdefault(meaning, []).append(statement._replace(line=number, text=text[:_LONGEST]))
    return stated


def first_of(stated: Stated) -> dict[str, Any]:
    """Return the first value of each meaning; of numbers that mark missing points all."""
    first_values = {meaning: repeated[0].value for meaning, repeated in stated.items()}
    if "missing" in stated:
        first_values["missing"] = [statement.value for statement in stated["missing"]]
    return first_values


def lengths_along(stated: Stated, axis: str, count: int) -> list[tuple[Statement, int]]:
    """Return the first step and size along an axis of `count` points, and how many steps each has."""
    keys = {"d" + axis: 1, "step": 1, "length_" + axis: count}
    return [(stated[key][0], points) for key, points in keys.items() if key in stated]


def disagreeing(stated: Stated) -> str:
    """Return a sentence on repeated units, numbers of points and factors that do not agree, else nothing."""
    for scaled, bare in zip(stated.get("z_factor", []), stated.get("height_unit", []), strict=False):
        if is_length(scaled.unit) and is_length(bare.value):  # of the products, or of the numbers
            product = scaled.value * metres(scaled.unit)
            if not same_length(scaled.unit, bare.value) and not math.isclose(product, metres(bare.value)):
                return f"{scaled}, {bare}: they do not agree; correct one of them"
    for factor in stated.get("factor", []):
        if not is_length(factor.unit) and factor.value != 1 and "z_factor" not in stated:
            return f"{factor}: name a factor of the heights 'Z factor', with the unit of the products"
    without_lengths = {meaning: repeated for meaning, repeated in stated.items() if meaning not in LENGTHS}
    return next((f"{wrong}; correct one of them" for wrong in _repeated(without_lengths)), "")


def contradiction(stated: Stated, shape: tuple[int, int]) -> str:
    """Return a sentence on statements that contradict each other or the table (ny, nx); empty where none do.

    Examples
    --------
    >>> contradiction(statements(["Pixel size: 0.5 µm", "Width: 13 µm"]), (9, 13))
    "line 1 says 'Pixel size: 0.5 µm', line 2 says 'Width: 13 µm': they do not agree for 13 columns"
    >>> contradiction(statements(["Pixel size: 0.5 µm", "Width: 6.5 µm"]), (9, 13))
    ''
    """
    lengths = {meaning: repeated for meaning, repeated in stated.items() if meaning in LENGTHS}
    return next(chain(_repeated(lengths), _units_apart(stated), _lengths_apart(stated, shape)), "")


def _repeated(stated: Stated) -> Iterator[str]:
    """Yield sentences on numbers of two meanings, unknown units, and repeated entries that differ."""
    for meaning, (first, *repeats) in stated.items():
        for statement in (first, *repeats):
            if isinstance(statement.value, float) and math.isnan(statement.value):
                yield f"{statement}: its mark may be the decimal sign or separate thousands"
            elif meaning in LENGTHS and statement.unit and not is_length(statement.unit):
                yield f"{statement}: {statement.unit!r} is no unit of length"
        for statement in repeats if meaning not in _REPEATED else ():
            if not _equal(first, statement, stated):
                yield f"{first}, {statement}: they do not agree"


def _units_apart(stated: Stated) -> Iterator[str]:
    """Yield sentences on lengths in another unit than the one that is stated for all of them."""
    for general in stated.get("lateral_unit", [])[:1]:
        for length in (stated[meaning][0] for meaning in LENGTHS if meaning in stated):
            if is_length(length.unit) and not same_length(length.unit, general.value):
                yield f"{length}, {general}: their units do not agree"


def _lengths_apart(stated: Stated, shape: tuple[int, int]) -> Iterator[str]:
    """Yield sentences on sizes and steps that differ, may be numbers of points, or have units far apart."""
    first = {meaning: repeated[0] for meaning, repeated in stated.items()}
    used = []
    for axis, count, name in (("x", shape[1], "columns"), ("y", shape[0], "rows")):
        lengths = lengths_along(stated, axis, count) if count > 1 else []
        for (length, points), (second, second_points) in combinations(lengths, 2):
            if not _equal(length, second, stated, (points, second_points)):
                yield f"{length}, {second}: they do not agree for {count} {name}"
        used += lengths[:1]
        bare = not {"d" + axis, "step", "n" + axis, "lateral_unit"} & {*first}
        for length, _ in lengths if bare else ():
            if not length.unit and length.value == count:
                yield f"{length}, and there are {count} {name}: a size without a unit, or their number"
    if (height := first.get("length_y")) and _HEIGHT_WORD.match(height.text) and shape[0] > 1:
        third = first.get("length") or (not {"length_x", "dy", "step"} & {*first} and first.get("dx"))
        if third and is_length(third.unit):
            yield f"{third}, {height}: a side of the map, or the range of its heights"
    if len(used) < 2:
        return
    (width, nx), (height, ny) = used
    side = first.get("size")  # of one side, or of both
    sides = (width, (shape[1], nx)), (height, (shape[0], ny))
    if side and not any(_equal(side, length, stated, points) for length, points in sides):
        yield f"{side}, {width}: they do not agree for {shape[1]} columns and {shape[0]} rows"
    if all(is_length(length.unit) and length.value > 0 for length in (width, height)):
        ratio = width.value / nx / (height.value / ny)
        pixel = ratio * metres(width.unit) / metres(height.unit)
        if abs(math.log(pixel)) > max(math.log(_ODD_PIXEL), abs(math.log(ratio))):
            yield f"{width}, {height}: their units make pixels of {pixel:.3g} : 1"


def _equal(first: Statement, second: Statement, stated: Stated, points: tuple[int, int] = (1, 1)) -> bool:
    """Return whether two statements agree: texts, or lengths of so many points."""
    if isinstance(first.value, str):
        return same_length(first.value, second.value)
    general = next((stated[key][0].value for key in ("lateral_unit", "unit") if key in stated), "")
    units = [statement.unit or general for statement in (first, second)]
    in_metres = all(map(is_length, units))
    steps, slack = [], _SLACK
    for statement, unit, number in zip((first, second), units, points, strict=True):
        steps.append(statement.value * (metres(unit) if in_metres else 1.0) / number)
        slack += min(statement.rounding / abs(statement.value or 1), _WIDEST_SLACK)
    slack *= max(map(abs, steps))
    between_ends = 1 - (points[0] != points[1]) / points[1]  # a length from the first point to the last
    return any(abs(steps[0] * ratio - steps[1]) <= slack for ratio in (1, between_ends))


def _entries(text: str) -> Iterator[tuple[str, str]]:
    """Yield the keys and values of a line: one, as ``Width: 5 mm``, or several, as ``h=305 w=75``."""
    first, *value_texts = re.split(r"\s*[:=]\s*", text)
    keys, values = [first], []
    numbers = all(map(_NUMBER.match, value_texts))
    for value_text in value_texts[:-1] if numbers else ():  # a value, its unit, the next key
        tokens = re.split(r"[\s;]+|,\s+", value_text)
        ends = [" ".join(tokens[start:]).partition("(")[0] for start in range(len(tokens))]
        start = next((start for start in range(1, len(tokens)) if _meaning(ends[start])), len(tokens) - 1)
        values.append(" ".join(tokens[:start]))
        keys.append(" ".join(tokens[start:]))
    if values and all(key[:1].isalpha() for key in keys) and ("=" in text or _meaning(first)):
        yield from zip(keys, [*values, value_texts[-1]], strict=True)
    elif (end := min((text.find(sign) for sign in ":=\t" if sign in text), default=-1)) > 0:
        yield text[:end], text[end + 1 :]
    elif any(sign in text for sign in ";,"):  # a line of a table, as "Width";"640,5";"µm"
        separator = next(sign for sign in (";", '","', ",") if sign in text)
        key, *cells = (cell.strip().strip('"').strip() for cell in text.split(separator))
        yield key, " ".join(cells[:2])
    elif len(tokens := text.split()) == 2:
        yield tokens[0], tokens[1]


def _meaning(key: str) -> str | None:
    """Return the meaning of a key, or None for an unknown key."""
    return _MEANING.get(re.sub(r"[\s_-]+", " ", key).strip().strip('"').lower())


def _statements_of(key: str, value: str, sign: str) -> Iterator[tuple[str, Statement]]:
    """Yield the meanings and statements of one entry; none where it is not understood."""
    name, opening, remainder = key.replace("[", "(").partition("(")
    unit = remainder.replace("]", ")").partition(")")[0].removeprefix("->").strip() if opening else ""
    meaning, value = _meaning(name), value.strip(' "\t;,')  # a spreadsheet fills lines with separators
    if meaning is None:
        return
    if meaning in _TEXT_ENTRIES:
        if value and (meaning != "unit" or is_length(value)):
            yield meaning, Statement(value, "", 0.0, 0, "")
        return
    sides = _BETWEEN_SIDES.split(value.replace("×", "x").replace("*", "x"))
    if len(sides) > 1 and meaning in _TWO_VALUES:
        units = [_NUMBER.sub("", side, count=1).strip() for side in sides]
        both = units[1] or unit
        unit_known = is_length(both) or (both.lower() in _PIXEL_WORDS and meaning == "size")
        understood = unit_known and len(sides) == 2
        for axis, side, own in zip(_TWO_VALUES[meaning], sides, units, strict=True) if understood else ():
            yield from _statements_of(words("header")[axis][0], side if own else f"{side} {both}", sign)
    elif match := _NUMBER.match(value):
        unit = unit or _UNIT_IN_NAME.get(name.strip().lower(), "")
        yield from _numbers_of(meaning, match, unit, sign)


def _numbers_of(meaning: str, match: re.Match[str], unit: str, sign: str) -> Iterator[tuple[str, Statement]]:
    """Yield the meaning and statement of a number at the beginning of a value; two where its units differ."""
    number, rounding = _number(match[0].rstrip(".,"), sign)
    if meaning in _COUNTS and math.isnan(number):
        number = float(re.sub(r"\D", "", match[0]))
    after = match.string[match.end() :].strip().strip("()[]")
    value_unit = _PER_PIXEL.sub("", after).partition(" ")[0].strip("()[],;")
    if meaning == "per_pixel" and _PER_PIXEL.search(after or unit):
        meaning = "step"
    unit = _PER_PIXEL.sub("", unit)
    value_unit = value_unit or unit
    if meaning in _PIXELS and value_unit.lower() in _PIXEL_WORDS:
        meaning, value_unit = _PIXELS[meaning], ""
    bare_size = meaning == "size" and not is_length(value_unit)
    if bare_size or meaning == "per_pixel" or (meaning in LENGTHS and _RANGE.match(after)):
        return
    yield meaning, Statement(number, value_unit, rounding, 0, "")
    # both are named as they differ
    if is_length(value_unit) and is_length(unit) and not same_length(value_unit, unit):
        yield meaning, Statement(number, unit, rounding, 0, "")


def _number(text: str, sign: str) -> tuple[float, float]:
    """Return a number and half a unit of its last digit; NaN where a mark in it may have two meanings.

    A mark of the other kind, or a repeated one, separates thousands; a single one before three digits does so
    perhaps, unless it is the decimal sign of the table, or a point where that has whole numbers.
    """
    mantissa, _, exponent = text.lower().partition("e")
    marks = [mark for mark in mantissa if mark in ".,"]
    decimal = marks[-1] if marks and marks.count(marks[-1]) == 1 else ""
    if decimal and len(marks) == 1 and decimal != (sign or "."):
        if re.fullmatch(r"[-+]?[1-9]\d{0,2}[.,]\d{3}", mantissa):
            return math.nan, 0.0
    elif len(marks) > 1 and not re.fullmatch(r"[-+]?\d{1,3}([.,]\d{3})+([.,]\d*)?", mantissa):
        return math.nan, 0.0
    integer_part, _, decimals = mantissa.partition(decimal) if decimal else (mantissa, "", "")
    digits = re.sub("[.,]", "", integer_part) + "." + decimals
    power = max(min(int(exponent or 0), 400), -400)
    rounding = 0.5 * 10.0 ** max(min(power - len(decimals), 300), -300) if decimals else 0.0
    return float(f"{digits}e{power}"), rounding
