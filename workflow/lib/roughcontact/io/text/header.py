"""Statements in the header of a text file: sizes, steps, numbers of points, units, instrument.

All of them are collected before any is used, so that those that contradict each other are named.
"""

import math
import re
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import chain, combinations, dropwhile, islice
from typing import Any, NamedTuple

from roughcontact.io.guards import refusal
from roughcontact.io.units import is_length, metres, same_length
from roughcontact.io.vocabulary import meanings, pattern, words

MAX_LINE_LENGTH = 4096  # characters; longer lines contain no metadata
_MAX_LINES = 10_000  # lines

_INSTRUMENT = ("name", "serial", "lens", "acquisition_time")  # keys of `roughcontact.io.metadata`
# those with a text as value
_TEXT_ENTRIES = ("channel", "height_unit", "lateral_unit", "unit", *_INSTRUMENT)
LENGTHS = ("length_x", "length_y", "length", "dx", "dy", "step", "size")
_COUNTS = ("nx", "ny", "count")
_REPEATED = ("channel", "missing", "height_range", "count", "length", *_INSTRUMENT)
# keys that imply the unit of their value: counts or pixels to nanometres
_UNIT_IN_NAME = {"bit2nm": "nm", "pixel_to_nm_scaling": "nm"}
_ORDERS = {row: pattern("order", row) for row in words("order")}
_DENIAL = re.compile(r"\b(?:not?|non|nicht|kein\w*|pas|false)\b", re.IGNORECASE)
_TWO_VALUES, _BY_UNIT = words("values"), words("either")
_PIXELS = {"length_x": "nx", "length_y": "ny"}  # a size in pixels is a number of them
_PIXEL_WORDS = ("px", "pixel", "pixels", "points", "pts", "samples", "lines", "rows", "columns")
_MEANING = meanings("header") | dict.fromkeys(words("header")["height"], "length_y")
_COMPOSED, _PART = meanings("composed"), meanings("part")
_SIDES = {axis: "|".join(words("side")[axis]) for axis in "xy"}
_SIDE = f"(?:{_SIDES['x']}|{_SIDES['y']})"
_ORDER = re.compile(rf"\(?(?<!\w)(d?{_SIDE})\s*[x×,;/*]\s*(d?{_SIDE})(?!\w)\)?", re.IGNORECASE)
# the name of a side before its number, or behind it; an x between numbers is none
_LABEL = re.compile(
    rf"(?i)(?:^|(?<=[,;/(]))\s*({_SIDE})\b\s*[=:]?\s*(?=[-+.\d])|(?<=\s)({_SIDE})\s*[=:]\s*(?=[-+.\d])|"
    rf"(?:\s*[(\[]|\s+)(?:in |along |en )?({_SIDE})\b[)\]]?(?=\s*(?:$|[,;/×]|(?:x|by|and|und|et)\b))"
)
_TWO_SIDES = re.compile(rf"(?i)([^\d:=]*?[^\W\d])\W*?[\s:=]\s*((?:{_SIDE}\b\s*[=:]?\s*)?[-+.\d].*)")
_BEFORE_A_NUMBER = re.compile(r"([^\d;,]*[^\W\d])\s+([\[(]?[-+.]?\d.*)")
# a length among the words that name it: "rows are 0.6 µm apart", "0.4 µm per pixel"
_AROUND = re.compile(
    r"([^\d:=;,]*?)\s*\b((?:[\d.,]+\s*[^\W\d_]*?\s*(?:[x×*/]|by)\s*)?[\d.,]+\s*([^\W\d_]+[²2]?))(?:\s*/\s*|\s+)([^\d:=;,(]+)"
)
_IS_X = re.compile(f"d?(?:{_SIDES['x']})", re.IGNORECASE)
_UNKNOWN_ORDER = re.compile(r"[(\[]\s*([^\W\d]\w*)\s*[x×,;/*]\s*[^\W\d]\w*\s*[)\]]")
_WIDE_MARKS = {ord(wide): mark for wide, mark in zip("，、；", (", ", ", ", "; "), strict=True)}
_ONE_AXIS = re.compile(rf"({_SIDE})(?:[\s-]*(?:axis|direction))?\s*:\s*(.+,.+)", re.IGNORECASE)
_AXIS = meanings("axis")
_NO_HEADINGS = re.compile(r"[^(\[/]*(?::|\b(?:and|und|et)\b)[^(\[/]*")
# between the entries of a line, not within brackets
_PIECES = re.compile(
    r"(?:[;,]|\.(?=\s+[^\W\d_]{3}))\s+(?=[^\W\d]|\d+\s*(?:[x×]\s*\d+)?\s+[^\W\d])(?![^(\[]*[)\]])"
)
# "18 columns"
_COUNTED = re.compile(r"(\d+(?:\s*[x×]\s*\d+)?)\s+([^\W\d]+)(?:\s*(?:[x×]|\band\b|\bby\b)\s*|$)")
_MAX_UNIT = 20  # characters of a unit behind words
_MAX_PHRASE = 200  # characters of an entry in words; the patterns take the square of their number
NUMBER = re.compile(r"[-+]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][-+]?\d+)?")
_BETWEEN_SIDES = re.compile(
    r"(?<=[\w)\].])\s{0,3}(?:\bx\b|x(?=\d)|\b(?:by|and|und|et|sur|par|per|por|en)\b|(?<=\D)[/|](?=\s?[\d.])|[/|](?=\s?\d*[.,]\d)|;(?=\s*\d)|,(?=\s+\d))\s*|"
    r"(?<=[^\W\d])\s+(?=\d)"
)
_RANGE = re.compile(r"(?:[^\w%]|x|by|to|bis)*\d")  # a second number behind the first: two sides, or limits
_PER_PIXEL = re.compile(r"\s*(?:/|per)\s*(?:p[ií]xel|pix|px|point|pt|sample)s?$", re.IGNORECASE)
_DENSITY = re.compile(
    r"(?i)\b(?:pixels?|px|points?|pts|samples?|punkte)\s*(?:/|per|pro|par|por)\s*([^\W\d]+)"
)
_PER_COUNT = re.compile(r"(?i)\s*(?:/|per|pro|par|por)\s*(?:digit|count|lsb|inc|increment|bit)s?$")
# of one axis, above several entries: "Axis: X"
_SECTION = re.compile(
    r"(?i)\[?(?:(?:axis|achse|axe|asse|eje)\s*[:=]?\s*([xyz])|([xyz])[ -]?(?:axis|achse))\]?:?"
)
_FORTRAN = re.compile(r"(\d\.\d*)[dD]([-+]\d\d)(?!\w)")  # double precision, 1.5D-03
_CAMERA, _ASIDES = pattern("aside", "camera"), pattern("aside")  # all words that may concern the map
_HEIGHT_WORDS = "|".join(words("header")["height"] + words("part")["height"])
_HEIGHT_WORD = re.compile(rf"\W*(?:{_HEIGHT_WORDS})\b", re.IGNORECASE)
LONGEST_QUOTE = 60  # characters of a line that a message shows
_AMBIGUOUS = "its mark may be the decimal sign or separate thousands"
SLACK, WIDEST_SLACK = 1e-3, 1e-2  # relative difference of agreeing lengths: without and with rounding
_ODD_PIXEL = 10.0  # ratio of the sides of a pixel above which two different units of them are doubted


class Statement(NamedTuple):
    """One entry of a header, `rounding` half a unit of its last digit, 0 for a whole number."""

    value: Any  # text or number, NaN where a mark may be a decimal sign or separate thousands
    unit: str = ""
    rounding: float = 0.0
    line: int = 0
    text: str = ""

    def __str__(self) -> str:
        return f"line {self.line} says {self.text[:LONGEST_QUOTE]!r}"


Entries = Iterator[tuple[str, Statement]]  # with their meanings


class Stated(dict[str, list[Statement]]):
    """The entries of a header that are understood, by meaning, in the order of the lines."""

    def first(self, *meanings: str) -> Any:
        """Return the value of the first entry with one of some meanings, the first that there is."""
        return next((self[meaning][0].value for meaning in meanings if meaning in self), None)

    def lengths_along(self, axis: str, count: int) -> list[tuple[Statement, int]]:
        """Return the steps and sizes along an axis of `count` points, each once, with its number of steps."""
        single, common, sizes = (self.get(key, []) for key in ("d" + axis, "step", "length_" + axis))
        if {length.line for length in single} & {length.line for length in common}:
            common = []  # "spacing ...; line spacing ..."
        # a size without a unit beside a step, or a step beside a size, may be their number
        single, sizes = (
            [each for each in lengths if each.unit or each.value != count or not common + others]
            for lengths, others in ((single, sizes), (sizes, single))
        )
        distinct: dict[tuple, tuple[Statement, int]] = {}
        for length, points in (*((step, 1) for step in single + common), *((size, count) for size in sizes)):
            distinct.setdefault((*length[:3], points), (length, points))
        return [*distinct.values()]


def statements(lines: Iterable[str], *, start: int = 1, sign: str = "") -> Stated:
    """Return the entries of a header that are understood, by meaning, in the order of the lines.

    `start` is the number of the first line in the file, `sign` the decimal sign of its table, empty for whole
    numbers; lines of more than 4096 characters, and those after the first 10 000, are skipped.

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
    by_meaning, section = Stated(), ""
    for number, line in enumerate(islice(lines, _MAX_LINES), start=start):
        text = line.translate(_WIDE_MARKS).strip().lstrip("#%;!\\*/' \t").strip()
        if found := _SECTION.fullmatch(text):
            section = (found[1] or found[2]).lower()
        quoted = text
        key = re.match(r"[^\d:=\t]*[^\W\d](?=\W*[:=\t])", text[:_MAX_PHRASE]) if section else None
        if key and _meaning(f"{key[0]} {section}"):
            text = f"{key[0]} {section}{text[key.end() :]}"
        if len(text) > _MAX_PHRASE:
            text = re.sub(r"(\s)\s+", r"\1", text)
        if not text or len(line) > MAX_LINE_LENGTH or _CAMERA.search(text):
            continue
        text = re.sub(r"\b(?:d?x\s*=\s*d?y)\s*(?==)", "step ", text)  # "dx = dy = 2 µm"
        text = _FORTRAN.sub(r"\1e\2", text)
        if re.search("[\"']:", text):  # JSON, or a dict of Python
            text = re.sub("[\"']", "", text.strip("{}, "))
        pieces = _PIECES.split(text) if len(text) < _MAX_PHRASE else [text]
        if len(pieces) > 1 and (axis := _ONE_AXIS.fullmatch(text)):  # "x axis: 18 points, step 0.4 µm"
            pieces = [re.sub(r"^(\d+)\s+([^\W\d]+)$", r"\2 \1", piece) for piece in _PIECES.split(axis[2])]
            pieces = [re.sub(r"^([^\d:=]*[^\W\d])", rf"\1 {axis[1]}", piece) for piece in pieces]
        is_single = len(pieces) == 1
        pairs = ((piece, [*_parsed(piece, sign, alone=is_single)]) for piece in pieces)
        # but for a title
        entries = [entry for _, entry in dropwhile(lambda pair: not pair[1] and _is_prose(pair[0]), pairs)]
        # all pieces are entries, or the line is one
        is_whole = is_single or (entries and all(entries))
        for meaning, statement in chain(*entries) if is_whole else _parsed(text, sign):
            by_meaning.setdefault(meaning, []).append(statement._replace(line=number, text=quoted))
    return by_meaning


def _is_prose(text: str) -> bool:
    """Return whether a piece has neither a number, a unit of length, nor a word that may concern the map."""
    tokens = {*re.findall(r"\w+", text)} - {"in"}
    return not (re.search(r"\d", text) or any(map(is_length, tokens)) or _ASIDES.search(text))


def _parsed(text: str, sign: str, *, alone: bool = True) -> Entries:
    """Yield the meanings and statements of a line, or of a piece that does not stand alone in one."""
    for key, value in _entries(text, alone=alone):
        yield from _parse_entry(key, value, sign)
    first_rows = [row for row, says in _ORDERS.items() if len(text) < _MAX_PHRASE and says.search(text)]
    if len(first_rows) == 1 and not _DENIAL.search(text):
        yield "first_row", Statement(first_rows[0])


def check_agreement(by_meaning: Stated) -> None:
    """Refuse repeated units, numbers of points and factors that do not agree."""
    for ratio, bare in zip(by_meaning.get("z_factor", []), by_meaning.get("height_unit", []), strict=False):
        # of the products, or of the numbers, as radians; a factor of 1 makes no lengths of volts
        if is_length(ratio.unit) and (is_length(bare.value) or ratio.value == 1):
            stated_unit = metres(bare.value) if is_length(bare.value) else math.nan
            is_product = math.isclose(ratio.value * metres(ratio.unit), stated_unit)
            if not is_product and not same_length(ratio.unit, bare.value):
                raise refusal("no agreement", first=ratio, second=bare)
    for factor in by_meaning.get("factor", []):
        if not is_length(factor.unit) and factor.value != 1 and "z_factor" not in by_meaning:
            raise refusal("factor", factor=factor)
    for meaning, (first, *repeats) in by_meaning.items():
        for statement in (first, *repeats) if meaning not in LENGTHS else ():
            if statement.value != statement.value:
                raise refusal("ambiguous", statement=statement, why=_AMBIGUOUS)
            if meaning not in _REPEATED and not _agree((first, 1), (statement, 1)):
                raise refusal("no agreement", first=first, second=statement)


def contradiction(by_meaning: Stated, shape: tuple[int, int]) -> str:
    """Return a sentence on statements that contradict each other or the table (ny, nx); empty where none do.

    Examples
    --------
    >>> contradiction(statements(["Pixel size: 0.5 µm", "Width: 13 µm"]), (9, 13))
    "line 1 says 'Pixel size: 0.5 µm', line 2 says 'Width: 13 µm': they do not agree for 13 columns"
    >>> contradiction(statements(["Pixel size: 0.5 µm", "Width: 6.5 µm"]), (9, 13))
    ''
    """
    return next(chain(_no_lengths(by_meaning), _lengths_apart(by_meaning, shape)), "")


def _no_lengths(stated: Stated) -> Iterator[str]:
    """Yield sentences on ambiguous lengths, and on those whose unit is none or not that of all."""
    lateral = next(iter(stated.get("lateral_unit", ())), None)
    for length in (length for meaning in LENGTHS for length in stated.get(meaning, ())):
        if length.value != length.value:
            yield f"{length}: {_AMBIGUOUS}"
        elif length.unit and not is_length(length.unit):
            yield f"{length}: {length.unit!r} is no unit of length"
        elif length.unit and lateral and not same_length(length.unit, lateral.value):
            yield f"{length}, {lateral}: their units do not agree"


def _lengths_apart(by_meaning: Stated, shape: tuple[int, int]) -> Iterator[str]:
    """Yield sentences on sizes and steps that differ, may be numbers of points, or have units far apart."""
    general = by_meaning.first("lateral_unit", "unit") or ""
    used = []
    for axis, count, name in (("x", shape[1], "columns"), ("y", shape[0], "rows")):
        lengths = by_meaning.lengths_along(axis, count) if count > 1 else []
        for one, another in combinations(lengths, 2):
            if not _agree(one, another, general):
                yield f"{one[0]}, {another[0]}: they do not agree for {count} {name}"
        used += lengths[:1]
        bare = not {"d" + axis, "step", "n" + axis, "lateral_unit"} & {*by_meaning}
        for length, _ in lengths if bare else ():
            if not length.unit and length.value == count:
                yield f"{length}, and there are {count} {name}: a size without a unit, or their number"
    for height in by_meaning.get("length_y", ())[:1] if shape[0] > 1 else ():
        alone = not {"length_x", "dy", "step"} & {*by_meaning}
        third = by_meaning.get("length", by_meaning.get("dx", []) if alone else [])
        if third and is_length(third[0].unit) and _HEIGHT_WORD.match(height.text):
            yield f"{third[0]}, {height}: a side of the map, or the range of its heights"
    if len(used) < 2:
        return
    for size in by_meaning.get("size", []):  # of one side, or of both
        if not any(_agree((size, n), side, general) for n, side in zip(shape[::-1], used, strict=True)):
            yield f"{size}, {used[0][0]}: they do not agree for {shape[1]} columns and {shape[0]} rows"
    (width, nx), (height, ny) = used
    if all(is_length(length.unit) and length.value > 0 for length in (width, height)):
        ratio = width.value / nx / (height.value / ny)
        pixel = ratio * metres(width.unit) / metres(height.unit)
        if abs(math.log(pixel)) > max(math.log(_ODD_PIXEL), abs(math.log(ratio))):
            yield f"{width}, {height}: their units make pixels of {pixel:.3g} : 1"


def _agree(first: tuple[Statement, int], second: tuple[Statement, int], general: str = "") -> bool:
    """Return whether two texts are the same, or two numbers of so many steps, by default in one unit."""
    if isinstance(first[0].value, str):
        return same_length(first[0].value, second[0].value)
    units = [statement.unit or general for statement, _ in (first, second)]
    factors = [*map(metres, units)] if all(map(is_length, units)) else [1.0, 1.0]
    steps, slack = [], SLACK
    for (statement, points), factor in zip((first, second), factors, strict=True):
        steps.append(statement.value * factor / points)
        slack += min(statement.rounding / abs(statement.value or 1), WIDEST_SLACK)
    count = second[1]
    between_ends = 1 - (first[1] != count) / count  # a length from the first point to the last
    return any(math.isclose(steps[0] * ratio, steps[1], rel_tol=slack) for ratio in (1, between_ends))


def _phrases(text: str) -> list[tuple[str, str]]:
    """Return the keys and values of a line with two sides, units of axes, or numbers among its words."""
    pair = _TWO_SIDES.fullmatch(text) if len(text) < _MAX_PHRASE else None
    name, sides = pair.groups() if pair else ("", text[:_MAX_PHRASE] if text[:1].isdigit() else "")
    labels = ["".join(groups) for groups in _LABEL.findall(sides)]
    if not name and not {*labels} & {"x", "y", *_PIXEL_WORDS}:
        name = "size"  # "7 µm wide, 8 µm high"
    one_each = sorted(bool(_IS_X.fullmatch(label)) for label in labels) == [False, True]
    if one_each and _meaning(name) in _TWO_VALUES:
        return [(name, sides)]
    if axes := _units_of_axes(text):
        return axes
    if text[:1].isdigit() and not _COUNTED.sub("", text):
        return [(word, number) for number, word in _COUNTED.findall(text)]
    around = _AROUND.fullmatch(text) if len(text) < _MAX_PHRASE else None
    if around and is_length(around[3].rstrip("²2")) and _meaning(name := f"{around[1]} {around[4]}"):
        return [(name, around[2])]
    return []


def _entries(text: str, *, alone: bool) -> Iterable[tuple[str, str]]:
    """Return the keys and values of a line: one, as ``Width: 5 mm``, or several, as ``h=305 w=75``."""
    # from the strictest form to the loosest: each takes lines that the next would misread
    if phrases := _phrases(text):
        return phrases
    head, *value_texts = re.split(r"\s*[:=]\s*", text)
    keys, values = [head], []
    # "h=305 w=75" is two entries; "file = C:/map" is one, as its second value is no number
    numbers = all(NUMBER.match(text.lstrip("([")) or is_length(text.split(" ")[0]) for text in value_texts)
    for value_text in value_texts[:-1] if numbers else ():  # a value, its unit, the next key
        stops = [blank.span() for blank in re.finditer(r"[\s;]+|,\s+", value_text)] or [(0, 0)]
        before_keys = (span for span in stops if _meaning(value_text[span[1] :].partition("(")[0]))
        stop, start = next(before_keys, stops[-1])
        values.append(value_text[:stop])
        keys.append(value_text[start:])
    if values and all(key[:1].isalpha() for key in keys) and ("=" in text or _meaning(head)):
        return zip(keys, [*values, value_texts[-1]], strict=True)
    if (stop := min((text.find(sign) for sign in ":=\t" if sign in text), default=-1)) > 0:
        return [(text[:stop], text[stop + 1 :])]
    if behind := _BEFORE_A_NUMBER.fullmatch(text):
        return [(behind[1], behind[2])]
    if any(sign in text for sign in ";,"):  # a line of a table, as "Width";"640,5";"µm"
        separator = next(sign for sign in (";", '","', ",") if sign in text)
        key, *cells = (cell.strip().strip('"').strip() for cell in text.split(separator))
        both_numbers = len(cells) > 1 and all(map(NUMBER.fullmatch, cells[:2]))
        return [(key, (";" if both_numbers else " ").join(cells[:2]))]
    # "heights in nm"
    lengths = (stop for stop in range(max(1, len(text) - _MAX_UNIT), len(text)) if is_length(text[stop:]))
    name = text[: next(lengths, 0)]
    # "z nm" is a heading, "z values nm" is none
    is_heading = alone and not re.search(r"\w[\s_-]+\w", name) and _meaning(name) in ("z", "length_y")
    return [(name, text[len(name) :])] if name and not is_heading else []


def _units_of_axes(text: str) -> list[tuple[str, str]]:
    """Return keys and values of a line that only says the units of axes and names no columns; else none.

    Examples
    --------
    >>> _units_of_axes("x, y: mm; z: nm"), _units_of_axes("Units: mm, nm"), _units_of_axes("x (mm), z (nm)")
    ([('lateral unit', 'mm'), ('height unit', 'nm')], [('lateral unit', 'mm'), ('height unit', 'nm')], [])
    """
    tokens = re.findall(r"[^\W\d_]+", text) if len(text) < _MAX_PHRASE and not re.search(r"\d", text) else []
    units = [token for token in tokens if is_length(token) and token != "in"]
    signs = ("1" if token in units else _AXIS.get(_PART.get(token.lower(), ""), "?") for token in tokens)
    order = "".join(signs).replace("-", "")  # x: along x or y; z: height; u: the word unit; 1: one of length
    no_headings = "u" in order or "xx" in order or _NO_HEADINGS.fullmatch(text)
    if re.fullmatch("u+(x+z+)?u*11+", order) and len(units) <= 3 and same_length(units[0], units[-2]):
        axes = ["x"] * (len(units) - 1) + ["z"]
    elif re.fullmatch("(u*x+u*1u*)+(u*z+u*1u*)*", order) and no_headings:
        axes = re.findall("([xz])u*1", order)
    else:
        return []
    keys = {"x": "lateral unit", "z": "height unit"}
    return [(keys[axis], unit) for axis, unit in zip(axes, units, strict=True)]


@cache
def _parts() -> re.Pattern[str]:
    """Return the pattern of the words that compose keys: it takes 0.1 s, and is for text files alone."""
    letter = "[a-zß-ՙ]"
    forms: tuple[list[str], list[str]] = [], []
    for part in sorted(_PART, key=len, reverse=True):
        anywhere = ord(part[-1]) > 0x2E7F  # in languages without blanks
        forms[anywhere].append(re.escape(part) + f"(?!{letter})" * (part[-1].isalpha() and not anywhere))
    # one look behind for all of them: most positions in a line end there
    return re.compile(rf"(?<!{letter})(?:{'|'.join(forms[False])})|{'|'.join(forms[True])}")


@cache
def _meaning(key: str) -> str | None:
    """Return the meaning of a key: a word, or composed of such; None for an unknown key."""
    apart = re.sub(r"[\s_-]+|(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", key)
    name = apart.strip().strip('"').lower()
    name = lower if (lower := key.strip().lower()) in _MEANING else name  # "dX"
    words = _parts().findall(name[:_MAX_PHRASE])
    if name in _MEANING or not words:
        return _MEANING.get(name)
    parts = {_PART[part] for part in words} - {"none"}
    bare_name = _parts().sub(lambda part: part[0] * (_PART[part[0]] != "none"), name[:_MAX_PHRASE])
    is_phrase = len(name) < _MAX_PHRASE and not re.search(r"\w", _parts().sub("", name))
    composites = (_COMPOSED.get(" ".join(sorted(kinds))) for kinds in (parts, parts - {"in"}) if is_phrase)
    return next(filter(None, (*composites, _MEANING.get(" ".join(bare_name.split())))), None)


def _parse_entry(key: str, value: str, sign: str) -> Entries:
    """Yield the meanings and statements of one entry; none where it is not understood."""
    value = value.strip(" \"\t;,'")  # a spreadsheet fills lines with separators
    density, number = _DENSITY.search(value) or _DENSITY.search(key), NUMBER.match(value)
    if density and number and is_length(density[1]):  # "Sampling: 2500 px/mm", "Pixels per mm: 2500"
        step = f"{1 / (number_and_rounding(number[0], sign)[0] or math.nan):.9e}".replace(".", sign or ".")
        key, value = _DENSITY.sub("", key).strip() or "pixel size", f"{step} {density[1]}/pixel"
    key, value, axes = _strip_sides(key, value)
    name, unit = _name_and_unit(key)
    meaning = _meaning(name)
    if meaning == "length_y" and is_length(value) and _HEIGHT_WORD.fullmatch(name.strip()):
        meaning = "height_unit"  # "Height: nm", without a number, is no side of the map
    elif meaning == "z":
        meaning = "height_unit" if is_length(value) else None
    product, per_count = NUMBER.match(value), _PER_COUNT.search(value)
    if product and (per_count or (meaning == "height_unit" and not is_length(value))):
        value = _PER_COUNT.sub("", value)  # "Heights in 0.1 nm"
        meaning = "z_factor" if is_length(value[product.end() :].strip()) else None
    if meaning in _TEXT_ENTRIES:
        no_unit = meaning in ("unit", "lateral_unit") and not is_length(value)
        no_date = meaning == "acquisition_time" and not re.search(r"\d\d", value)  # a heading
        if value and not no_unit and not no_date:
            yield meaning, Statement(value)
    elif meaning:
        of_counts = _UNIT_IN_NAME.get(name.strip().lower(), "")
        if of_counts and product:  # SPIP: the lengths too
            yield "lateral_unit", Statement(of_counts)
        yield from _parse_quantities(meaning, (key, value, axes), unit or of_counts, sign)


def _name_and_unit(key: str) -> tuple[str, str]:
    """Return a key without its unit, and the unit.

    Examples
    --------
    >>> _name_and_unit("Pixel size (µm)"), _name_and_unit("Pixel size (x)"), _name_and_unit("width_um")
    (('Pixel size ', 'µm'), ('Pixel size  x', ''), ('width', 'um'))
    """
    name, opening, remainder = key.replace("[", "(").partition("(")
    unit = remainder.replace("]", ")").partition(")")[0].removeprefix("->").strip() if opening else ""
    if unit.lower() in ("x", "y"):  # a side
        return f"{name} {unit}", ""
    head, _, last = re.sub(r"[\s_/]+(?:in[\s_]+)?(?=[^\s_/]+$)", "\0", name.strip()).partition("\0")
    has_unit = not opening and last != "in" and is_length(last) and _meaning(head)
    return (head, last) if has_unit else (name, unit)


def _parse_quantities(meaning: str, entry: tuple[str, str, str], unit: str, sign: str) -> Entries:
    """Yield the meanings and statements of the one or two numbers of an entry: its key, value and axes."""
    key, value, axes = entry
    value = re.sub(r"[\[(](?=[-+.\d])|(?<=\d)[\])]", "", value.replace("×", "x").replace("*", "x"))
    sides = _BETWEEN_SIDES.split(value)
    if len(sides) == 1 or meaning not in _TWO_VALUES:
        if match := NUMBER.match(value):
            yield from _parse_numbers(meaning, match, unit, sign)
        return
    axes = axes[::-1] if meaning == "shape" else axes  # of NumPy: rows first
    order = _UNKNOWN_ORDER.search(key)
    is_known = order is None or is_length(order[1])
    sides[-1] = re.sub(r"(?<=[^\W\d])(?:²|\^?2)$", "", sides[-1])  # "0.4 x 0.6 µm²"
    units = [_PER_PIXEL.sub("", NUMBER.sub("", side, count=1).strip()) for side in sides]
    common = units[1] or unit
    kinds, first_kinds = (
        (is_length(candidate), candidate.lower() in _PIXEL_WORDS, not candidate)
        for candidate in (common, units[0].partition(" ")[0] or common)
    )
    form = next((form for form, is_kind in zip(_TWO_VALUES[meaning], kinds, strict=True) if is_kind), "-")
    form = form if kinds == first_kinds else "-"  # "2 µm, binned to 4 µm"
    texts = [side if unit_text else f"{side} {common}" for side, unit_text in zip(sides, units, strict=True)]
    numbers = [number for text in texts if (number := NUMBER.match(text))]
    is_whole = is_known and form != "-" and len(sides) == len(numbers) == 2
    for axis, number in zip(axes, numbers, strict=True) if is_whole else ():
        yield from _parse_numbers(form.format(axis), number, unit, sign)


def _strip_sides(key: str, value: str) -> tuple[str, str, str]:
    """Return a key and a value without the names of the sides of a map, and the axes of its two numbers.

    Examples
    --------
    >>> _strip_sides("Size (height x width)", "5 x 7 µm"), _strip_sides("Pixel", "3 µm (x), 4 µm (y)")
    (('Size ', '5 x 7 µm', 'yx'), ('Pixel', '3 µm , 4 µm', 'xy'))
    """
    if len(key) + len(value) > _MAX_PHRASE:
        return key, value, "xy"
    order = _ORDER.search(key) or _ORDER.search(value)  # behind the name, or behind the numbers
    bare_key, bare_value = _ORDER.sub("", key), _ORDER.sub("", value)
    labels = ["".join(groups) for groups in _LABEL.findall(bare_value)]
    names = [*(order.groups() if order else ()), *labels][-2:]
    axes = "".join("x" if _IS_X.fullmatch(name) else "y" for name in names)
    if sorted(map(str.lower, names)) == ["h", "v"]:  # beside a vertical side h is the horizontal one
        axes = "".join("x" if name in "hH" else "y" for name in names)
    if axes not in ("xy", "yx"):
        return key, value, "xy"
    if order and not bare_key.strip():
        bare_key = "step" if order[1][0] in "dD" else "size" * (len(order[1]) > 1)
    return bare_key, _LABEL.sub(" ", bare_value).strip("[( "), axes


def _parse_numbers(meaning: str, match: re.Match[str], unit: str, sign: str) -> Entries:
    """Yield the meaning and statement of a number at the beginning of a value; two where its units differ."""
    suffix = match.string[match.end() :].strip().strip("()[]")
    value_unit = _PER_PIXEL.sub("", suffix).partition(" ")[0].strip("()[],;")
    if meaning in _BY_UNIT:  # "Pixel x: 0.4 µm" is a step, "Pixel x: 18" a number of them
        meaning = _BY_UNIT[meaning][not is_length(_PER_PIXEL.sub("", value_unit or unit))]
    number, rounding = number_and_rounding(match[0].rstrip(".,"), sign)
    if meaning in _COUNTS:  # 1,024 and 18.0000001
        number = float(re.sub(r"\D", "", match[0])) if math.isnan(number) else round(number, 6)
    if meaning == "per_pixel" and _PER_PIXEL.search(suffix or unit):
        meaning = "step"
    unit = _PER_PIXEL.sub("", unit)
    value_unit = value_unit or unit
    if meaning in _PIXELS and value_unit.lower() in _PIXEL_WORDS:
        meaning, value_unit = _PIXELS[meaning], ""
    if meaning in _COUNTS and number % 1:
        return
    unclear = meaning in ("per_pixel", "-") or (meaning == "size" and not is_length(value_unit))
    if unclear or (meaning in LENGTHS and _RANGE.match(suffix)):
        return
    yield meaning, Statement(number, value_unit, rounding)
    # both are named as they differ
    if is_length(value_unit) and is_length(unit) and not same_length(value_unit, unit):
        yield meaning, Statement(number, unit, rounding)


def number_and_rounding(text: str, sign: str) -> tuple[float, float]:
    """Return a number and half a unit of its last digit; NaN where a mark in it may have two meanings.

    A mark of the other kind, or a repeated one, separates thousands; a single one before three digits does so
    perhaps, unless it is the decimal sign of the table, or a point where that has whole numbers.
    """
    mantissa, _, exponent = text.lower().partition("e")
    marks = [mark for mark in mantissa if mark in ".,"]
    decimal = marks[-1] if marks and marks.count(marks[-1]) == 1 else ""
    is_open = marks != [sign or "."] and re.fullmatch(r"[-+]?[1-9]\d{0,2}[.,]\d{3}", mantissa)
    if is_open or (len(marks) > 1 and not re.fullmatch(r"[-+]?\d{1,3}([.,]\d{3})+([.,]\d*)?", mantissa)):
        return math.nan, 0.0
    integer_part, _, decimals = mantissa.partition(decimal) if decimal else (mantissa, "", "")
    digits = re.sub("[.,]", "", integer_part) + "." + decimals
    power = max(min(int(exponent or 0), 400), -400)
    rounding = 0.5 * 10.0 ** max(min(power - len(decimals), 300), -300) if decimals else 0.0
    return float(f"{digits}e{power}"), rounding
