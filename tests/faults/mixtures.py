"""Write texts that hold more than one thing, or state it twice, and count how they are read.

    .venv/bin/python tests/faults/mixtures.py                  # 2 000 texts
    .venv/bin/python tests/faults/mixtures.py --texts 100 --seed 3

Each text has two or three tables, several traces, named columns of several languages, a header that repeats
or contradicts itself, or positions beside a matrix. What it holds is known: it is read right, or refused in a
sentence with the line, the column or the key that is in question.
"""

import json
import random
import re
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from texts import arguments

from roughcontact import RoughContactError, read_height_map

ROUGH = np.round(400.0 * np.random.default_rng(8).standard_normal((12, 15)), 2)  # nm
_Y, _X = np.indices(ROUGH.shape)
SMOOTH = np.round(300 * np.sin(0.31 * _X + 0.2) * np.cos(0.27 * _Y) + 7.3 * _X - 4.1 * _Y + 0.02 * ROUGH, 2)
DX, DY = 1.25, 0.625  # µm
# headings of x, of the heights, and of an index, in several languages
WORDS = {
    "English": ("X", "Height", "Index", "Profile"),
    "English, long": ("Position", "Altitude", "Counter", "Raw profile"),
    "German": ("Messweg", "Höhe", "Nr.", "Profil"),
    "French": ("Abscisse", "Hauteur", "Numéro", "Profil"),
    "Spanish": ("Posición", "Altura", "Número", "Perfil"),
    "Italian": ("Posizione", "Altezza", "Numero", "Profilo"),
    "Polish": ("Położenie", "Wysokość", "Index", "Profil"),
    "Russian": ("Положение", "Высота", "Номер", "Профиль"),
    "Japanese": ("位置", "高さ", "番号", "プロファイル"),
}
SIZES = {
    "English": ("Channel", "Width", "Height", "Value units"),
    "German": ("Kanal", "Breite", "Höhe", "Werteinheiten"),
    "French": ("Canal", "Largeur", "Hauteur", "Unité Z"),
    "Japanese": ("チャネル", "幅", "高さ", "値の単位"),
}
UNITS = {"nm": 1.0, "µm": 1e3, "um": 1e3, "mm": 1e6}  # nm


class Mixture(NamedTuple):
    """A text and what it holds: the right heights (m) and steps (m), or None where it has to be refused.

    `asked` is a pattern of a refusal that is as good, or the only right one.
    """

    text: str
    arguments: dict[str, Any]
    heights: np.ndarray | None
    steps: tuple[float, ...]
    asked: str
    kind: str


class Writer:
    """Random choices of one text: decimal sign, separator, surface, unit of the heights."""

    def __init__(self, number: int, seed: int) -> None:
        self.choose = random.Random(f"{seed} {number} mixture")
        self.decimal = self.choose.choice(".,")
        self.separator = self.choose.choice(["\t", ";", *([",", " "] if self.decimal == "." else [])])
        self.newline = self.choose.choice(["\n", "\n", "\r\n"])
        self.heights = self.choose.choice([ROUGH, SMOOTH]).copy()
        if self.choose.random() < 0.3:
            self.heights[[0, 2, 11], [4, 3, 14]] = np.nan  # not measured
        self.unit = self.choose.choice(list(UNITS))

    def number(self, value: float, form: str = "{:.9g}") -> str:
        return form.format(value).replace(".", self.decimal)

    def rows(self, table: np.ndarray) -> list[str]:
        return [self.separator.join(map(self.number, row)) for row in table]

    def text(self, lines: list[str]) -> str:
        return self.newline.join(lines) + self.newline

    def in_unit(self, heights: np.ndarray) -> np.ndarray:
        return heights / UNITS[self.unit]

    def sizes(self, shape: tuple[int, int], title: str = "", unit: str = "") -> list[str]:
        """Return a header in the manner of Gwyddion."""
        sign, colon = self.choose.choice(["# ", "", "; "]), self.choose.choice([": ", " = ", "： "])
        words = SIZES[self.choose.choice(list(SIZES))]
        values = (
            title,
            f"{self.number(shape[1] * DX)} µm",
            f"{self.number(shape[0] * DY)} µm",
            unit or self.unit,
        )
        return [f"{sign}{word}{colon}{value}" for word, value in zip(words, values, strict=True) if value]


GIVEN = {"dx": DX, "dy": DY, "unit": "um"}
STEPS = 1e-6 * DY, 1e-6 * DX
LINE = r"line {}\b"


def metres(heights: np.ndarray) -> np.ndarray:
    return 1e-9 * heights


def map_of(heights: np.ndarray) -> np.ndarray:
    """Return a matrix as it is read: its first line is the upper one."""
    return metres(heights)[::-1]


def two_tables(write: Writer) -> Mixture:
    """Two or three tables below one another, with headings, with words, or without."""
    choose, heights = write.choose, write.heights
    how = choose.choice(["sizes", "sizes", "words", "nothing", "empty cells", "size, then words"])
    further_tables = [heights[:, ::-1] * 0.5, np.cos(heights)[:8]][: choose.choice([1, 2])]
    first_rows = write.rows(write.in_unit(heights))
    lines, title = [], choose.choice(["Topography", "Height", "Z sensor"])
    arguments = GIVEN | {"height_unit": write.unit}
    if how.startswith("size"):
        lines, arguments = write.sizes(heights.shape, title), {}
    elif how == "words":
        lines = [title]
    lines += first_rows
    start = 0
    for number, table in enumerate(further_tables):
        blank = choose.choice([1, 1, 2]) if how != "sizes" else choose.choice([0, 1, 2])
        empty = write.separator * (heights.shape[1] - 1) if how == "empty cells" else ""
        lines += [empty] * blank
        start = start or len(lines) + 1
        if how == "sizes":
            unit = choose.choice(["deg", "V", "nm"])
            lines += write.sizes(table.shape, f"Channel {number}", unit)
        elif "words" in how:
            lines.append(f"Signal {number}")
        lines += write.rows(write.in_unit(table))
    right = None if how in ("nothing", "empty cells") else map_of(heights)
    if right is not None and choose.random() < 0.3:
        arguments["channel"] = title
    return Mixture(write.text(lines), arguments, right, STEPS, LINE.format(start), f"two tables, {how}")


def one_table(write: Writer) -> Mixture:
    """One map with empty lines in it: between all rows, or between the scan lines of a list of points."""
    heights = write.in_unit(write.heights)
    if write.choose.random() < 0.4:
        blank = write.choose.choice([1, 2])
        lines = [line for row in write.rows(heights) for line in (row, *[""] * blank)]
        given = GIVEN | {"height_unit": write.unit}
        return Mixture(write.text(lines), given, map_of(write.heights), STEPS, "", "an empty line everywhere")
    lines = (
        [write.separator.join(["x (µm)", "y (µm)", f"z ({write.unit})"])]
        if write.choose.random() < 0.5
        else []
    )
    arguments = {} if lines else {"unit": "um", "height_unit": write.unit}
    comment = write.choose.choice(["", "", "# scan line"])
    for j, row in enumerate(heights):
        lines += write.rows(np.array([[i * DX, j * DY, z] for i, z in enumerate(row)]))
        lines += [""] * write.choose.choice([1, 2]) + ([comment] if comment else [])
    return Mixture(write.text(lines), arguments, metres(write.heights), STEPS, "", "points in blocks")


def traces(write: Writer) -> Mixture:
    """Several traces in one list: from the start again, there and back, below headings, or turning back."""
    choose = write.choose
    how = choose.choice(
        ["restart", "there and back", "repeated end", "headings", "empty line", "turn", "step back"]
    )
    unit = write.choose.choice(["µm", "mm"])
    factor = UNITS["µm"] / UNITS[unit]
    z = write.in_unit(write.heights)
    x = factor * DX * np.arange(z.shape[1])
    named = how == "headings" or choose.random() < 0.7
    heading = [write.separator.join([f"x ({unit})", f"z ({write.unit})"])] if named else []
    arguments: dict[str, Any] = {} if named else {"unit": unit, "height_unit": write.unit}
    count = choose.choice([2, 3, 4])
    profiles = [write.rows(np.column_stack([x, row])) for row in z[:count]]
    chosen = choose.randrange(count)
    if how in ("turn", "step back"):
        turning_point = choose.randrange(4, 12)
        positions = x.copy()
        positions[turning_point:] = x[turning_point - 1] + (x[turning_point:] - x[turning_point - 1]) * (
            -1 if how == "turn" else 1
        )
        if how == "step back":
            positions[turning_point:] -= 1.6 * DX * factor
        if how == "turn":
            positions[turning_point + 2 :] = x[turning_point + 2 :]
        lines = heading + write.rows(np.column_stack([positions, z[0]]))
        message = LINE.format(len(heading) + 1 + turning_point)
        if choose.random() < 0.5:
            arguments["resample"] = "linear"
        return Mixture(write.text(lines), arguments, None, (), message, f"traces, {how}")
    lines, second_line = list(heading), 0
    for number, profile in enumerate(profiles):
        back = how in ("there and back", "repeated end") and number % 2
        if how == "headings":
            lines = lines if number else []
            lines += ([""] if number and choose.random() < 0.7 else []) + (
                [] if number and choose.random() < 0.3 else [f"Trace {number}"]
            )
            second_line = second_line or (
                len(lines) if number and lines[-1].startswith("Trace") else len(lines) + 1 if number else 0
            )
            lines += heading
        elif how == "empty line" and number:
            lines.append("")
        written = profile[::-1] if back else profile
        if how == "there and back" and number:
            written = written[1:]
        second_line = second_line or (len(lines) + 1 if number else 0)
        lines += written
    right, steps = None, (1e-6 * DX,)
    if choose.random() < 0.5 and how not in ("headings", "there and back"):
        arguments["channel"] = f"profile {chosen + 1}"
        right = metres(write.heights[chosen : chosen + 1])
    elif choose.random() < 0.3:
        arguments["resample"] = "linear"
    return Mixture(write.text(lines), arguments, right, steps, LINE.format(second_line), f"traces, {how}")


def named_columns(write: Writer) -> Mixture:
    """A profile, several, or points, with named columns and their units."""
    choose = write.choose
    position_word, height, index, profile = WORDS[choose.choice(list(WORDS))]
    unit = choose.choice(["µm", "mm", "um", "nm"])
    brackets = choose.choice(
        ["{} [{}]", "{} ({})", "{}_[{}]", "{} in {}"] if write.separator != " " else ["{} ({})", "{} [{}]"]
    )
    x = UNITS["µm"] / UNITS[unit] * DX * np.arange(write.heights.shape[1])
    count = choose.choice([1, 2, 3, 4])
    units = [choose.choice(list(UNITS)) for _ in range(count)]
    z = [write.heights[row] / UNITS[units[row]] for row in range(count)]
    names = [height] if count == 1 else [f"{profile} {row + 1}" for row in range(count)]
    if write.separator == " ":
        position_word, names, index = (
            position_word.replace(" ", ""),
            [name.replace(" ", "") for name in names],
            index.replace(" ", ""),
        )
    cells = [brackets.format(position_word, unit), *map(brackets.format, names, units)]
    columns = [x, *z]
    if choose.random() < 0.5:
        cells, columns = [index, *cells], [np.arange(x.size) + choose.choice([0, 1, 37]), *columns]
    if choose.random() < 0.3 and count > 1:
        cells, columns = [*cells, "Signal (V)"], [*columns, np.cos(x)]
    shift = choose.randrange(len(cells)) if choose.random() < 0.3 else 0
    cells, columns = cells[shift:] + cells[:shift], columns[shift:] + columns[:shift]
    lines = [choose.choice(["", "measured on Monday"]), write.separator.join(cells)]
    lines += write.rows(np.column_stack(columns))
    arguments, right = {}, metres(write.heights[:1])
    chosen = choose.randrange(count)
    if count > 1 and choose.random() < 0.5:
        arguments, right = {"channel": names[chosen]}, metres(write.heights[chosen : chosen + 1])
    elif count > 1:
        right = None
    if right is None and choose.random() < 0.3:
        arguments = GIVEN  # as the user gives them who takes it for a map
    message = "" if right is not None else rf"{re.escape(names[0])}.*channel"
    return Mixture(write.text(lines), arguments, right, (1e-6 * DX,), message, f"{count} named columns")


def headers(write: Writer) -> Mixture:
    """A matrix below a header that says its size more than once."""
    choose, heights = write.choose, write.heights
    ny, nx = heights.shape
    table = write.rows(write.in_unit(heights))
    size = {
        "width": f"Width: {write.number(nx * DX)} µm",
        "height": f"Height: {write.number(ny * DY)} µm",
        "dx": f"dx = {write.number(DX)} µm",
        "dy": f"dy = {write.number(DY)} µm",
        "mm": f"dx = {write.number(DX / 1e3)} mm",
        "nx": f"nx: {nx}",
        "ny": f"ny: {ny}",
        "both": write.number(DX).join(["Pixel size: ", choose.choice([" µm x ", " by ", " µm / ", "; "])])
        + f"{write.number(DY)} µm",
        "range": f"X range: 0 - {write.number(nx * DX)} µm",
        "field": f"Scan size: {write.number(nx * DX)} x {write.number(ny * DY)} µm",
        "pairs": f"dx={write.number(DX / 1e3)} mm, dy={write.number(DY / 1e3)} mm",
        "optical": f"Resolution: {write.number(0.35)} µm",
        "motor": f"Step: {write.number(3)}",
        "pixels": f"X pixels: {nx}",
    }
    good = choose.choice(
        [["width", "height"], ["dx", "dy"], ["both"], ["field"], ["pairs"], ["width", "height", "dx"]]
    )
    good += choose.sample(
        ["width", "height", "dx", "mm", "nx", "ny", "both", "field", "optical", "motor", "pixels", "range"], 3
    )
    wrong = {
        "width twice": f"Width: {write.number(nx * DX * choose.choice([2, 0.5, 1.1, 1e3]))} µm",
        "another step": f"dx = {write.number(DX * choose.choice([2, 0.5, 0.9, 10]))} µm",
        "another unit": f"dx = {write.number(DX)} {choose.choice(['nm', 'mm'])}",
        "another height": f"Height: {write.number(ny * DY * 1.3)} µm",
        "lateral unit": "XY unit: nm",
        "another number": f"nx: {nx + choose.choice([1, -1, 10])}",
        "unit of the heights": "Z unit: m",
        "units of the axes": f"X unit: µm{write.newline}Y unit: mm",
        "scale": f"Z scale: {write.number(choose.choice([0.1, 1000]))}",
        "two meanings": f"Width: 1{',' if write.decimal == '.' else '.'}{choose.randrange(100, 1000)} µm",
    }
    statement = choose.choice([*wrong, *["agreeing"] * 6, "optical alone", "motor alone"])
    if statement.endswith("alone"):
        lines = [size[statement.split()[0]], f"Z unit: {write.unit}"]
        message = "give dx, dy, unit"
        return Mixture(write.text([*lines, *table]), {}, None, STEPS, message, f"header, {statement}")
    lines = list(dict.fromkeys(size[key] for key in good))
    choose.shuffle(lines)
    lines.append(f"Z unit: {write.unit}")
    if statement == "agreeing":
        return Mixture(write.text([*lines, *table]), {}, map_of(heights), STEPS, "", "header, agreeing")
    if statement == "another step" and not {"dx", "dy", "both", "pairs", "width", "field", "mm"} & {*good}:
        return headers(write)
    lines.insert(choose.randrange(len(lines)), wrong[statement])
    return Mixture(
        write.text([*lines, *table]), {}, None, STEPS, r"line \d+|header says", f"header, {statement}"
    )


def positions(write: Writer) -> Mixture:
    """A matrix with positions in its first row, its first column, or both."""
    choose, heights = write.choose, write.heights
    where = choose.choice(["row", "column", "both", "both"])
    starts = [choose.choice([0, 0, 0.5, -3, 100]) for _ in "yx"]
    signs = [choose.choice([1, 1, -1]) for _ in "yx"]
    y, x = (
        start + sign * step * np.arange(n)
        for start, sign, step, n in zip(starts, signs, (DY, DX), heights.shape, strict=True)
    )
    rows = [[*map(write.number, row)] for row in write.in_unit(heights)]
    if where != "row":
        rows = [[write.number(position), *row] for position, row in zip(y, rows, strict=True)]
    corner = choose.choice(["0", "", "none", "y/x", "0"]) if where == "both" else "none"
    if corner == "none" and where == "both" and write.separator != " ":
        corner = ""
    if where != "column":
        top_row = [*map(write.number, x)]
        if where == "both" and corner != "none":
            top_row = [corner, *top_row]
        rows = [top_row, *rows]
    if corner == "" and write.separator == " ":
        return positions(write)
    right = metres(heights)[:, :: signs[1] if where != "column" else 1]
    right = right[:: signs[0]] if where != "row" else right[::-1]
    statement = choose.choice(["given", "given", "header", "unit"])
    lines, arguments = [], GIVEN | {"height_unit": write.unit}
    message = ""
    if statement == "header":
        lines, arguments = write.sizes(heights.shape), {}
    elif statement == "unit":
        arguments = {"unit": "um", "height_unit": write.unit}
        if where != "both":
            message = "give d[xy]|give dx, dy and unit"
    lines += [write.separator.join(row) for row in rows]
    return Mixture(
        write.text(lines),
        arguments,
        right,
        STEPS,
        message,
        f"positions, {where}, {statement}, corner {corner!r}",
    )


def repeated_positions(write: Writer) -> Mixture:
    """Maps beside or below one another, told by their positions, columns without names, uneven positions."""
    choose, left_half = write.choose, write.in_unit(write.heights)
    right_half = left_half[:, ::-1]
    x, y = (step * np.arange(n) for step, n in zip((DX, DY), left_half.shape[::-1], strict=True))
    how = choose.choice(
        [
            "rows",
            "columns",
            "both",
            "beside",
            "profiles",
            "pairs",
            "among",
            "among columns",
            "in rows",
            "uneven",
        ]
    )
    table = {
        "among": lambda: np.vstack([left_half, x, right_half]),
        "among columns": lambda: np.column_stack([left_half, y, right_half]),
        "in rows": lambda: np.vstack([x, np.nan_to_num(left_half[0])]),
        "uneven": lambda: np.column_stack([np.r_[7, y], np.vstack([(x + DX) ** 1.3, left_half])]),
        "rows": lambda: np.vstack([x, left_half, x, right_half]),
        "columns": lambda: np.column_stack([np.r_[y, y], np.vstack([left_half, right_half])]),
        "both": lambda: np.column_stack([np.r_[0, y, 0, y], np.vstack([x, left_half, x, right_half])]),
        "beside": lambda: np.vstack([np.r_[x, x], np.hstack([left_half, right_half])]),
        "profiles": lambda: np.column_stack([x, *left_half[:3]]),
        "pairs": lambda: np.column_stack([x, left_half[0], x, left_half[1]]),
    }[how]()
    arguments = GIVEN | {"height_unit": write.unit}
    if how == "profiles":
        arguments = {"unit": "um", "height_unit": write.unit}
    message = {
        "profiles": "name the columns",
        "in rows": r"line 1\b.* positions",
        "uneven": "row .* not even",
    }.get(how, r"begins? anew")
    return Mixture(write.text(write.rows(table)), arguments, None, (), message, f"positions again, {how}")


def one_column(write: Writer) -> Mixture:
    """One height in each line, below a step, a length or both: a profile."""
    row = write.heights[write.choose.randrange(12)]
    entries = [
        f"Spacing: {write.number(DX)} µm",
        f"Width: {write.number(row.size * DX)} µm",
        f"Points: {row.size}",
    ]
    lines = write.choose.sample(entries[:2], write.choose.choice([1, 2])) + write.choose.choice(
        [[], entries[2:]]
    )
    text = write.text([*lines, f"Z unit: {write.unit}", *write.rows(write.in_unit(row[:, None]))])
    return Mixture(text, {}, metres(row[None]), (1e-6 * DX,), "may be a decimal sign", "one column")


KINDS: tuple[Callable[[Writer], Mixture], ...] = (
    two_tables,
    one_table,
    traces,
    named_columns,
    headers,
    positions,
    repeated_positions,
    one_column,
)


def dressed(text: Mixture, write: Writer) -> Mixture:
    """Return a text whose rows of numbers are quoted, spaced out, closed, or as wide as all other lines."""
    separator = write.separator
    how = write.choose.choice(
        ["plain", "plain", "indented", *(["quoted", "blanks", "closed", "filled"] * (separator != " "))]
    )
    lines = text.text.removesuffix(write.newline).split(write.newline)
    widest = max(line.count(separator) for line in lines)
    for number, line in enumerate(lines):
        cells = line.split(separator)
        if how == "filled":
            lines[number] = line + separator * (widest - len(cells) + 1)
        elif len(cells) > 1 and re.fullmatch(r"(?:[-+\d.,;eE\s]|nan)+", line):
            lines[number] = {
                "plain": line,
                "indented": " " + line,
                "quoted": separator.join(f'"{cell}"' for cell in cells),
                "blanks": f" {separator} ".join(cells),
                "closed": line + separator,
            }[how]
    return text._replace(text=write.text(lines), kind=f"{text.kind}, {how}")


def mixture(number: int, seed: int = 1) -> Mixture:
    """Return a random text of one kind after the other."""
    write = Writer(number, seed)
    return dressed(KINDS[number % len(KINDS)](write), write)


def outcome(text: Mixture, folder: Path) -> str:
    """Read a text, and return what came of it."""
    path = folder / "mixture.txt"
    path.write_bytes(text.text.encode("utf-8"))
    try:
        height = read_height_map(path, **text.arguments)
    except RoughContactError as error:
        if text.asked and re.search(text.asked, str(error).replace(str(path), "")):
            return "asked"
        return f"refused otherwise: {str(error).replace(str(path), '')}"
    if text.heights is not None and height.shape == text.heights.shape:
        right = np.allclose(height.values, text.heights, rtol=1e-8, atol=1e-18, equal_nan=True)
        steps = [float(height[axis][1] - height[axis][0]) for axis in "yx" if height.sizes[axis] > 1]
        if right and np.allclose(steps, text.steps[-len(steps) :], rtol=1e-6):
            return "read right"
    warned = json.loads(height.attrs["ingest_warnings"])
    return f"wrong, with a warning: {warned}" if warned else "wrong in silence"


def counted(texts: int, seed: int, folder: Path) -> tuple[Counter[str], list[tuple[Mixture, str]]]:
    """Return the outcomes of so many texts, and those that were neither read right nor asked about."""
    counts, wrong = Counter(), []
    for number in range(texts):
        text = mixture(number, seed)
        result = outcome(text, folder)
        counts[result.partition(":")[0]] += 1
        if result not in ("read right", "asked"):
            wrong.append((text, result))
    return counts, wrong


def described(mixture_and_outcome: tuple[Mixture, str]) -> str:
    """Return kind and arguments of a text, and what came of it."""
    text, result = mixture_and_outcome
    return f"{text.kind} {text.arguments}: {result}"


if __name__ == "__main__":
    options = arguments(__doc__, 2000).parse_args()
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as place:
        outcomes, unread = counted(options.texts, options.seed, Path(place))
    print("\n".join(map(described, unread)))
    print("; ".join(f"{name}: {number}" for name, number in outcomes.most_common()))
    sys.exit(bool(unread))
