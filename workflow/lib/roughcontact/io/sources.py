"""Where each thing that a map needs comes from, and the lines of a header that none of them comes from.

Steps, units, sign, marker of missing points and order of rows come from a line of the file, from the standard
of its format, or from the user. Another line with a number or a unit is named as not used; where it may
concern the map, that is a question or a warning until the user answers it.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from roughcontact.arguments.checking import marker_values
from roughcontact.arguments.quantities import counted_noun, quantity
from roughcontact.errors import InputFileError, SettingsError
from roughcontact.io.channels import NO_TOPOGRAPHY, Channel, MeasuredFile
from roughcontact.io.plausibility import counted_levels, frequent_levels, isolated_ends
from roughcontact.io.request import Request
from roughcontact.io.text.header import LONGEST_QUOTE, NUMBER, SLACK, WIDEST_SLACK, number_and_rounding
from roughcontact.io.units import is_length, metres
from roughcontact.io.vocabulary import pattern, rows_of, words

#: Column of the table -> what it states.
THINGS = {column: names[0] for column, names in words("thing").items()}
_SAYS = {matter: pattern("aside", matter) for matter in words("aside")}
_NO_HEIGHTS = re.compile(  # "Data type: phase", "Slope in mrad"
    rf"(?i)(?:data|signal|type|image|quantity|values)\W*(?:[:=]|are)\W*(?:{NO_TOPOGRAPHY.pattern})|"
    rf"^\W*(?:{NO_TOPOGRAPHY.pattern})\w*\s+(?:in\b|[\[(])"
)
_DENIED = re.compile(r"\b(?:(?:no|none|false|off|nein|non)\W*|0\s*)$", re.IGNORECASE)
_NUMBER = rf"(?>{NUMBER.pattern})"
_QUANTITY = re.compile(rf"(?:(?P<number>{_NUMBER})\s*|(?<!\w))(?P<unit>[^\W\d_]+)(?![\w^])")
_SIDES = re.compile(rf"(?<![\w.,])({_NUMBER})\s*(?:[x×*/,;|]|by)\s*({_NUMBER})\s*([^\W\d_]+)")
_PER = re.compile(r"\d\s*[^\W\d_]+\s*/\s*\Z")  # before a unit, as in 40 N/m
_SPEED = re.compile(r"\s*/\s*(?:s|sec|min|h)\b")
_PLAIN = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
# that stands for itself, neither in a name nor before a unit at the end of the line
_ALONE = re.compile(rf"(?<![^\s:=;,])(?>{_PLAIN.pattern})(?=[\s;,).]|$)(?!\s*([^\W\d]{{1,3}})\W*$)")
_TOLERANCE = re.compile(r"(?:\+/-|±)\s*[\d.,]+\s*\w*")
_COUNTS = re.compile(r"(?<![\d.,])(\d+)\s*[x×*]\s*(\d+)(?![.,]?\d|\s*(?!point|pixel)[^\W\d_])")
_COUNT = re.compile(r"[:=\s]\s*(\d{1,9})\W*$")
_MAX_QUOTED = 3  # lines in a question
# what a line may concern -> the keys that it asks for, and the sentence; of several the first counts
_DOUBTS = {matter: (keys.split(), sentence) for matter, keys, sentence in rows_of("doubts.tsv")}


class Length(NamedTuple):
    """A length in a line; NaN where its number is ambiguous or absent."""

    value: float  # m
    rounding: float  # relative
    unit: str
    bare: bool  # its number does not stand before the unit

    def agrees(self, lengths: Sequence[float]) -> bool:
        """Return whether it is one of some lengths (m) within its rounding."""
        slack = SLACK + min(self.rounding, WIDEST_SLACK)
        return any(abs(abs(self.value) - abs(length)) <= slack * abs(length) for length in lengths)


def parse_lengths(text: str) -> list[Length]:
    """Return the lengths in a line; a unit without a number is that of the numbers without a unit.

    Examples
    --------
    >>> [(round(length.value, 12), length.unit) for length in parse_lengths("Sampling (µm): 0.4, at 2 mm/s")]
    [(4e-07, 'µm')]
    >>> [length[::2] for length in parse_lengths("4 x 2 mm, heights in nm")]
    [(0.004, 'mm'), (0.002, 'mm'), (nan, 'nm')]
    """
    quantities, loose, text = [], [], _SIDES.sub(r"\1 \3 \2 \3", _TOLERANCE.sub("", text))
    text = re.sub(r"(?<!\d),|,(?!\d)", " ", text)  # between cells
    for match in _QUANTITY.finditer(text):
        unit, number = match["unit"], match["number"]
        if not is_length(unit) or (unit == "in" and not number):
            loose += [number] if number else []
        elif not _SPEED.match(text, match.end()) and not _PER.search(text, 0, match.start()):
            quantities.append((number, unit))
    loose += [match[0] for match in NUMBER.finditer(_QUANTITY.sub(" ", text))]
    lengths = []
    for number, unit in quantities:
        for token in [number] if number else (loose or [None]):
            value, rounding = number_and_rounding(token.rstrip(".,"), "") if token else (math.nan, 0.0)
            lengths.append(Length(value * metres(unit), rounding / abs(value or 1), unit, not number))
    return lengths


def ignored_lines(request: Request) -> set[int]:
    """Return the numbers of the lines that do not concern the map, as the user says."""
    return {*map(int, marker_values(request.ignore_lines, "ignore_lines"))}


def open_lines(channel: Channel, request: Request) -> Iterator[tuple[str, list[Length]]]:
    """Yield the lines with lengths that nothing uses, but for those of something else."""
    exempt = ignored_lines(request)
    for number, text in channel.unused:
        lengths = parse_lengths(text)
        if lengths and number not in exempt and "elsewhere" not in _matters(text):
            yield f"line {number} says {text[:LONGEST_QUOTE]!r}", lengths


def quoted(channel: Channel, request: Request) -> str:
    """Return the lines that a question about size and units has to show; nothing where there are none."""
    lines = [where for where, _ in open_lines(channel, request)][:_MAX_QUOTED]
    return f" ({', '.join(lines)}, which is not used)" if lines else ""


def says_another_unit(channel: Channel, request: Request, lengths_used: Sequence[float]) -> bool:
    """Return whether a line that nothing uses has another unit than that of the user for x and y."""
    factor = metres(str(request.unit), where="unit", error=SettingsError)
    lengths = (length for _, lengths in open_lines(channel, request) for length in lengths)
    return any(metres(length.unit) != factor and not length.agrees(lengths_used) for length in lengths)


def _matters(text: str) -> set[str]:
    """Return what a line may concern; `elsewhere`: the lens, the tip, the specimen or the like."""
    return {matter for matter, says in _SAYS.items() if says.search(text)}


def _count_beyond(heights: np.ndarray, limits: Sequence[float]) -> int:
    """Return how many heights lie outside two limits, or beyond one: on the side that has the fewer of them.

    Examples
    --------
    >>> _count_beyond(np.array([0.1, 0.2, 0.3, 9.0]), [5.0]), _count_beyond(np.arange(5.0), [1, 3])
    (1, 2)
    """
    outside = [np.count_nonzero(heights < min(limits)), np.count_nonzero(heights > max(limits))]
    return int(min(outside) if len(limits) == 1 else sum(outside))


def _number_alone(text: str) -> float:
    """Return the last number of a line that stands for itself; NaN where there is none.

    Examples
    --------
    >>> [_number_alone(text) for text in ("bad points are -9999", "Force: 5 nN", "Operator: user1")]
    [-9999.0, nan, nan]
    """
    return [math.nan, *(float(number[0]) for number in _ALONE.finditer(text.replace(",", ".")))][-1]


def marker_of(text: str) -> float:
    """Return the number in a line that says which one marks missing points; NaN for any other line.

    Examples
    --------
    >>> [marker_of(text) for text in ("Fehlstellen: -999", "Invalid if below -5", "Bad: 3 nm")]
    [-999.0, nan, nan]
    """
    matters = _matters(text)
    return _number_alone(text) if "marker" in matters and not matters & {"limit", "elsewhere"} else math.nan


def conspicuous(heights: np.ndarray) -> set[float]:
    """Return heights as of a marker: of many more points than chance brings there, or far from all others.

    Examples
    --------
    >>> sorted(conspicuous(np.append(np.arange(0.5, 100.0), [7.0, 7.0, 7.0, -999.0])))
    [-999.0, 7.0]
    """
    levels, counts = counted_levels(heights)
    return {*isolated_ends(levels), *(level for level, _ in frequent_levels(levels, counts, minimum=3))}


def sources(file: MeasuredFile, channel: Channel, request: Request) -> dict[str, str]:
    """Return where each thing that a map needs comes from, by the columns that state it."""
    fallback = "assumed" if channel.sources else file.format.partition(" (")[0]
    origins = {}
    for column in THINGS:
        if getattr(request, column, None) is not None or (column == "unit" and request.dx is not None):
            origins[column] = "stated by the user"
        elif column == "height_unit" and channel.height_unit is None:
            origins[column] = "stated by the user for x and y"
        elif column == "first_row" and (channel.first_row or file.first_row_assumed):
            origins[column] = "assumed"
        elif column != "dy" or channel.shape[0] > 1:
            origins[column] = channel.sources.get(column, fallback)
    return origins


def in_words(origins: Mapping[str, Any]) -> str:
    """Return `sources` for people; nothing where all comes from the format.

    Examples
    --------
    >>> in_words({"dx": "line 2", "dy": "line 2", "height_unit": "line 3", "not used": []})
    'step along x, step along y: line 2; unit of heights: line 3'
    """
    things: dict[str, list[str]] = {}
    for column, source in origins.items():
        if column in THINGS:
            things.setdefault(source, []).append(THINGS[column])
    parts = [f"{', '.join(names)}: {source}" for source, names in things.items()]
    return "; ".join(parts) if len(parts) > 1 else ""


def lines_not_used(
    channel: Channel, request: Request, steps: tuple[float, float], height_factor: float, numbers: np.ndarray
) -> tuple[list[str], list[str]]:
    """Return the lines with a number or a unit that nothing uses, and warnings of what they may concern.

    Refused are a factor that is not understood above whole numbers, and a step that is none of `steps` (m).
    """
    (ny, nx), (dx, dy) = channel.shape, steps
    finite = numbers[np.isfinite(numbers)] if channel.unused else np.empty(0)
    # whole numbers may be counts, for which a factor that nobody applied is fatal
    is_integer = bool(finite.size) and "factor" not in channel.sources and not np.any(finite % 1)
    extremes = [finite.min(), finite.max(), np.ptp(finite), 1.0] if finite.size else []
    sides = [dx, dy, nx * dx, ny * dy, (nx - 1) * dx, (ny - 1) * dy]
    lengths_used = [*sides, *(height_factor * height for height in extremes)]
    step_sources = channel.sources.get("dx", "") + channel.sources.get("dy", "")
    steps_from_lines = "line" in step_sources and not request.has_steps(channel.shape)
    lateral_factor = metres(unit) if is_length(unit := channel.lateral_unit or request.unit) else None
    texts = {"dx": quantity(dx, "m"), "dy": quantity(dy, "m")}
    lines = ((f"line {number}: {text[:LONGEST_QUOTE]}", text) for number, text in channel.unused)
    listing = [line for line, text in lines if parse_lengths(text) or _PLAIN.search(text)]
    exempt, strange_levels, notes = ignored_lines(request), conspicuous(finite), []
    for number, text in (line for line in channel.unused if line[0] not in exempt):
        lengths = parse_lengths(text)
        values = [float(match) for match in _PLAIN.findall(text.replace(",", "."))]
        matters = _matters(text)
        elsewhere, is_step, is_fraction = (matter in matters for matter in ("elsewhere", "step", "fraction"))
        with_number = [length for length in lengths if length.value == length.value]
        used = sides if is_step else lengths_used
        strange = not elsewhere and not all(length.agrees(used) for length in with_number)
        odd_size = any({*map(int, pair)} != {nx, ny} for pair in _COUNTS.findall(text))
        contradicts = steps_from_lines and not elsewhere and (strange or odd_size)
        is_count = "points" in matters and not matters & {"marker", "elsewhere"}
        # in words that are not known
        strange_count = is_count and any(int(n) not in (0, 1, nx, ny, nx * ny) for n in _COUNT.findall(text))
        is_factor = "factor" in matters and not {*values[-1:]} <= {0.0, 1.0}
        is_scaled = "scaled" in matters and not {*values} <= {0.0, 1.0}
        is_limit = matters >= {"limit", "validity"} and "lateral" not in matters and "%" not in text
        limits = [length.value / height_factor for length in with_number] or values
        beyond_count = _count_beyond(finite, limits) if is_limit and limits else 0
        marker = _number_alone(text)
        may_be_marker = "marker" in matters or (not elsewhere and marker in strange_levels)
        marker_count = int(np.count_nonzero(finite == marker)) if may_be_marker else 0
        if is_limit and not beyond_count and not marker_count:
            continue
        bare = [length for length in lengths if length.bare and not length.agrees(lengths_used)]
        # the number of a lens, a filter ... is none of the map; a unit alone may be that of all numbers
        factors = {metres(length.unit) for length in bare if not elsewhere or length.value != length.value}
        own_factor = lateral_factor if "lateral" in matters else height_factor
        is_other = own_factor not in factors or not factors <= {lateral_factor, height_factor}
        off_step = strange and is_step and "positions" in channel.sources.values()
        is_denied = _DENIED.search(text)
        # what the line may concern, as in the table of doubts
        applies = {
            "limit": beyond_count,
            "marker": marker_count > 1 or (marker_count and marker),
            "zero": marker_count,
            "counts": is_integer and (is_factor or is_fraction or (strange and not is_step)),
            "turned": not is_denied and ("turned" in matters or _NO_HEIGHTS.search(text)),
            "step": contradicts and is_step,
            "pixels": not is_denied and "pixels" in matters and values != [1],
            "size": contradicts or off_step or strange_count or (odd_size and is_count),
            "unit": (factors and own_factor and is_other)
            or (is_fraction and lengths)
            or is_scaled
            # beside one that is used
            or (is_factor and "factor" in channel.sources),
        }
        # a line is quoted once
        if doubt := next((_DOUBTS[matter] for matter in _DOUBTS if applies[matter]), None):
            count = beyond_count or marker_count
            points = f"there {'is' if count == 1 else 'are'} {counted_noun(count, 'point')}"
            sentence = doubt[1].format(number=number, text=text[:LONGEST_QUOTE], points=points, **texts)
            if keys := doubt[0]:
                raise InputFileError(sentence, keys=keys)
            notes.append(sentence)
    return listing, notes
