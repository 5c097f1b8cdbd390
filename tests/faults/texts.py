"""Write known maps and profiles as people and programs write them, and count how the texts are read.

    .venv/bin/python tests/faults/texts.py                     # 5 000 texts, two minutes
    .venv/bin/python tests/faults/texts.py --texts 300 --seed 3 --kind columns --show 5

The words come from `phrases.tsv` (13 languages), the layouts from `exports.txt` (more than eighty exports of
programs): neither looks at the words that the readers know. Each text comes with the right heights and steps,
and with whether it states them. It is read without arguments; where that is refused, with the answers that a
user would give to what the refusal asks for, and to nothing else. A wrong map is *wrong in silence* unless a
word of its warnings concerns what is wrong.
"""

import argparse
import csv
import json
import random
import re
import sys
import tempfile
import warnings
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from roughcontact import RoughContactError, read_height_map

HERE = Path(__file__).parent
UNITS = {"nm": 1e-9, "um": 1e-6, "mm": 1e-3, "m": 1.0, "Å": 1e-10}
CODES = {
    "Polish": "cp1250",
    "Russian": "cp1251",
    "Chinese": "gb18030",
    "Japanese": "cp932",
    "Korean": "cp949",
}
MARKS = ["NaN", "nan", "---", "***", "BAD", "#N/A", "NA", "n/a", "1.70141e+38", "-", "1.#QNAN", "Masked"]
MARKS += ["9.91E+37", "No data", "out of range"]
UNSTATED = ["-9999", "1e30", "32767", "-32768", "0", "99999.9", "lowest"]  # numbers that nothing declares
FIXED, SIGNED, SCIENTIFIC, LARGE = "{:.%df}", "{:+.%df}", "{:.%de}", "{:.%dE}"


def _phrases() -> tuple[dict[tuple[str, str], list[str]], dict[str, float], dict[str, str]]:
    """Return phrases by item and language, factors of spelled units, and what is said of a trap."""
    phrases, units, patterns = {}, {}, {}
    with (HERE / "phrases.tsv").open(encoding="utf-8") as file:
        for line in csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE):
            item, language, listed = line["item"], line["language"], line["phrases"].split(" ¦ ")
            if item == "unit":
                units |= dict.fromkeys(listed, float(language))
            elif not language.isalpha():
                patterns[item] = language
            phrases[item, language] = listed
    return phrases, units, patterns


PHRASES, SPELLED, PATTERNS = _phrases()
LANGUAGES = sorted({language for item, language in PHRASES if item == "width"})


def _exports() -> list[tuple[str, dict[str, str], list[str]]]:
    """Return name, options and lines of each export."""
    exports = []
    for part in (HERE / "exports.txt").read_text(encoding="utf-8").split("\n==== ")[1:]:
        title, *lines = part.rstrip("\n").split("\n")
        name, _, options = title.partition(" | ")
        words = [word.partition("=") for word in options.split(" ")]
        exports.append((name, {key: value for key, _, value in words}, lines))
    return exports


EXPORTS = _exports()


class Text(NamedTuple):
    """A text: its bytes, right heights (m, row 0 lowest; None: no map) and steps (m), answers.

    `full` if all is stated; `word` is a pattern that its warnings have to hold.
    """

    data: bytes
    heights: np.ndarray | None
    steps: tuple[float, float]
    answers: dict[str, Any]
    full: bool
    word: str
    kind: str


class Length(float):
    """A length that is written in the unit of a format, as `{:um}`, `{:U}` or `{:Z}`."""

    writer: "Writer"

    def __format__(self, unit: str) -> str:
        return self.writer.number(self / self.writer.factor(unit))


class Writer:
    """The choices of one text: a surface, its units, decimal sign, separator and form of numbers."""

    def __init__(self, number: int, seed: int) -> None:
        self.choose = random.Random(f"{seed} {number} text")
        self.random = np.random.default_rng([seed, number])
        self.decimal, self.separator = self.choose.choice(
            [(".", "\t"), (".", ","), (".", " "), (",", ";"), (".", ";")]
        )
        self.units("um", self.choose.choice(["nm", "nm", "um", "mm", "m"]))
        self.shape = self.choose.choice([(9, 14), (12, 10), (14, 18), (11, 11)])
        self.dx = 1e-6 * self.choose.choice([0.4, 0.05, 1.25, 2, 12.5])
        self.dy = self.dx * self.choose.choice([1, 1, 1.5, 0.8])
        self.slope = self.choose.choice([0.001, 0.02, 0.3])
        self.form, self.thousands, self.counts = FIXED, "", False
        self.marks: list[str] = []
        self.language = self.choose.choice(LANGUAGES)
        self.word = ""

    def units(self, lateral: str, height: str) -> None:
        """Set the units as they are spelled."""
        self.lateral, self.height = lateral, height

    def factor(self, unit: str) -> float:
        unit = {"U": self.lateral, "Z": self.height}.get(unit, unit)
        return SPELLED[unit]

    def number(self, value: float, form: str = "{:.7g}") -> str:
        return form.format(value).replace(".", self.decimal)

    def surface(self, shape: tuple[int, int]) -> None:
        """Make the heights (m), in the order in which rows are written, and their cells."""
        smooth, rough = self.random.standard_normal((2, *shape))
        smooth = np.fft.irfft2(
            np.fft.rfft2(smooth)
            * np.exp(-8 * np.hypot(*np.ix_(np.fft.fftfreq(shape[0]), np.fft.rfftfreq(shape[1])))),
            shape,
        )
        heights = smooth / smooth.std() + 0.05 * rough + self.choose.choice([0, 0, 3])
        unit = 1e-10 if self.counts else self.factor(self.height)
        heights *= self.slope * self.dx / unit
        if self.counts:
            heights *= max(1.0, 300 / np.abs(heights).max())
        digits = 0 if self.counts else max(0, int(np.ceil(3.5 - np.log10(heights.std()))))
        form = self.form % (digits if self.form in (FIXED, SIGNED) else 6)
        texts = [[form.format(value) for value in row] for row in heights]
        self.heights = np.array([[float(text) for text in row] for row in texts]) * unit
        if self.thousands:
            texts = [
                [f"{float(text):,.{digits}f}".replace(",", self.thousands) for text in row] for row in texts
            ]
        self.cells = [[text.replace(".", self.decimal) for text in row] for row in texts]
        row, column = np.unravel_index(self.heights.argmin(), shape)
        lowest = self.cells[row][column]
        if self.marks and shape[0] <= min(row for row, _, _ in self.marks):
            self.word = ""  # no point is marked
        for row, column, mark in self.marks:
            if row < shape[0]:
                columns = range(shape[1]) if column is None else [column]
                for column_index in columns:
                    self.cells[row][column_index] = lowest if mark == "lowest" else mark
                    self.heights[row, column_index] = np.nan

    def fields(self) -> dict[str, Any]:
        """Return what phrases may name."""
        ny, nx = self.heights.shape
        dx, dy = self.dx, self.dy
        lengths = {
            "dx": dx,
            "dy": dy,
            "hx": dx / 2,
            "lx": nx * dx,
            "ly": ny * dy,
            "LX": 40 * dx,
            "LY": 40 * dy,
            "fx": nx * dx / 3,
            "fy": ny * dy / 2,
            "low": np.nanmin(self.heights),
            "high": np.nanmax(self.heights),
        }
        fields = {"nx": nx, "ny": ny, "n": nx * ny, "U": self.lateral, "Z": self.height}
        fields["c"] = self.number(0.1)  # of a count, nm
        for name, value in lengths.items():
            fields[name] = Length(value)
            fields[name].writer = self
        return fields

    def phrase(self, item: str, language: str | None = None) -> str:
        """Return one of the phrases of an item, filled in."""
        return self.choose.choice(PHRASES[item, self.language if language is None else language]).format_map(
            self.fields()
        )

    def noise(self, lines: int) -> list[str]:
        """Return lines that say nothing about size and units."""
        phrases = PHRASES["noise", self.language]
        return self.choose.sample(phrases, min(lines, len(phrases)))

    def places(self) -> tuple[list[str], list[str]]:
        """Return the positions along x and y as they are written."""
        ny, nx = self.heights.shape
        unit_factor = self.factor(self.lateral)
        return tuple(
            [self.number(step * index / unit_factor) for index in range(n)]
            for step, n in ((self.dx, nx), (self.dy, ny))
        )

    def table(self, how: str) -> tuple[list[list[str]], bool]:
        """Return the rows of cells of a table, and whether its first row is the uppermost."""
        name, _, detail = how.partition(" ")
        x, y = self.places()
        cells = self.cells
        ny, nx = len(cells), len(cells[0])
        if name in ("matrix", "columns"):
            return ((cells, True), ([*map(list, zip(*cells, strict=True))], False))[name == "columns"]
        if name == "other":
            return [
                [self.number(round(float(value), 3)) for value in row]
                for row in 100 + self.random.random((ny, nx))
            ], True
        if name in ("points", "blocks", "frame"):
            columns = "xyz" if name != "points" else detail.replace(" ", "")
            rows = [
                [{"x": x[i], "y": y[j], "z": cells[j][i]}[key] for key in columns]
                for j in range(ny)
                for i in range(nx)
            ]
            if name == "blocks":
                rows = [row for j in range(ny) for row in [*rows[j * nx : (j + 1) * nx], []]]
            if name == "frame":
                rows = [
                    detail.split(","),
                    *([str(number), *row] for number, row in enumerate(rows, detail.startswith('"'))),
                ]
            return rows, False
        if name == "profile":
            return [[position, cell] for position, cell in zip(x, cells[0], strict=True)], False
        if name == "rtable":
            names, numbers = [f"V{i + 1}" for i in range(nx)], [str(j + 1) for j in range(ny)]
            if self.choose.random() < 0.7:
                names, numbers = [f'"{name}"' for name in names], [f'"{name}"' for name in numbers]
            header_row = names if detail == "short" else ['""', *names]
            return [header_row, *([name, *row] for name, row in zip(numbers, cells, strict=True))], True
        if name == "var":
            return [[f"{detail}{i + 1}" for i in range(nx)], *cells], True
        if name == "ptable":
            return [["", *map(str, range(nx))], *([str(j), *row] for j, row in enumerate(cells))], True
        corner = {"pivot": detail, "gnuplot": str(nx), "femtoscan": ""}[name]
        return [[corner, *x], *([position, *row] for position, row in zip(y, cells, strict=True))], False

    def answers(self) -> dict[str, Any]:
        """Return what a user would answer who knows the instrument."""
        plain = {value: key for key, value in UNITS.items()}
        unit_factor = self.factor(self.lateral)
        return {
            "dx": round(self.dx / unit_factor, 9),
            "dy": round(self.dy / unit_factor, 9),
            "unit": plain[unit_factor],
            "height_unit": "nm" if self.counts else plain[self.factor(self.height)],
            "missing_value": "-9999",
            "first_row": "top",
            "channel": "Height",
        }

    def text(
        self,
        kind: str,
        lines: list[str],
        *,
        full: bool,
        top: bool,
        code: str = "utf-8",
        newline: str = "",
        refused: bool = False,
    ) -> Text:
        """Return a text of lines."""
        newline = newline or self.choose.choices(["\n", "\r\n", "\r"], [8, 6, 1])[0]
        content = (
            newline.join(lines)
            + self.choose.choices([newline, "", 3 * newline, newline + "\x1a"], [20, 4, 4, 1])[0]
        )
        try:
            data = content.encode(code)
        except UnicodeEncodeError:
            data = content.encode("utf-8")
        heights = self.heights[::-1] if top else self.heights
        return Text(
            data, None if refused else heights, (self.dx, self.dy), self.answers(), full, self.word, kind
        )


def spelled(write: Writer, share: float = 0.5, *, columns: bool = False) -> None:
    """Spell both units in one of their many ways."""
    for name in ("lateral", "height"):
        if write.choose.random() >= share:
            factor = write.factor(getattr(write, name))
            units = [unit for unit, value in SPELLED.items() if value == factor]
            # behind a number nobody writes a power of ten or a lone prefix
            plain = [unit for unit in units if re.match(r"[^\W\d]|.*\\", unit) and unit not in ("µ", "mu")]
            setattr(
                write, name, write.choose.choice([u for u in units if "&" not in u] if columns else plain)
            )


def marked(write: Writer, rows: tuple[int, int, int] = (2, 7, 5)) -> str:
    """Take out some points, or a row; return a line that declares their mark, or ""."""
    choose = write.choose
    if choose.random() > 0.25:
        return ""
    blank = [""] if write.separator.strip(" ") and not write.thousands else []
    mark = choose.choice([*MARKS, *2 * UNSTATED, "-9999 declared", "-9999 declared", *blank])
    value = mark.removesuffix(" declared")
    row_a, row_b, third = rows
    is_whole_row = third and choose.random() < 0.2
    write.marks = [(row_a, 3, value), (row_b, 5, value), (third, None if is_whole_row else 1, value)]
    if mark in UNSTATED:  # of as many points as nobody takes for chance
        write.marks += [(row_b, column, value) for column in (0, 2, 6, 7, 8)]
        write.word = "-9999|−9999|missing|far from|lowest|span"
    return choose.choice(PHRASES["missing", write.language]) if " " in mark else ""


def dressed(write: Writer, rows: list[list[str]], *, names: int = 0) -> list[str]:
    """Return the lines of a table as programs and people write them, with what follows it."""
    choose, separator = write.choose, write.separator
    wide = separator.strip(" ") != ""
    columns = max(map(len, rows))
    how = (
        choose.choice(["plain", "plain", "plain", "quoted", "blanks", "closed", "remarks", "remarks"])
        if wide
        else "plain"
    )
    if how == "remarks" and columns <= 4:
        texts = [write.phrase("notes") if choose.random() < 0.3 else "" for _ in rows[names:]]
        if choose.random() < 0.4:
            texts = [choose.choice(["ok", "OK", "good"]) if choose.random() < 0.9 else "bad" for _ in texts]
        heads = [write.phrase("note")] if names and "" not in rows[0] else [""]
        texts = heads * min(names, 1) + [""] * max(names - 1, 0) + texts
        rows = [[*row, text] for row, text in zip(rows, texts, strict=True)]
    lines = [separator.join(row) for row in rows]
    if how == "quoted":
        lines = [separator.join(f'"{cell.strip(chr(34))}"' for cell in row) if row else "" for row in rows]
    elif how == "blanks":
        lines = [f" {separator} ".join(row) for row in rows]
    elif how == "closed":
        lines = [line + separator if line else "" for line in lines]
    choice = choose.random()
    if choice < 0.08:
        lines += [write.phrase("foot")]
    elif choice < 0.13:
        lines += [*([""] * choose.randrange(2)), *choose.sample(PHRASES["results", write.language], 1)]
    return lines


def program(write: Writer) -> Text:
    """An export of a program."""
    choose = write.choose
    name, options, lines = choose.choice(EXPORTS)
    write.separator = {"tab": "\t", "space": " "}.get(options["sep"], options["sep"])
    write.decimal = choose.choice(options.get("decimals", "."))
    write.units(choose.choice(options["u"].split(",")), choose.choice(options["z"].split(",")))
    write.form = SCIENTIFIC if options.get("form") == "sci" or write.factor(write.height) == 1 else FIXED
    write.language = next((language for language in LANGUAGES if language in name), "English")
    if "square" in options:
        write.dy = write.dx
    if any("Keyence" in part for part in (name,)) and choose.random() < 0.3:
        write.marks = [(2, 3, "-99999.9999"), (6, 1, "-99999.9999")]
    elif "NODATA" in "".join(lines).upper():
        write.marks = [(1, 2, "-9999")]
    profile = any(line.startswith("@profile") for line in lines)
    write.surface((1, 60) if profile else write.shape)
    if profile:
        write.dy = write.dx
    result, top = [], True
    for line in lines:
        if line.startswith("@"):
            rows, upper_first = write.table(line[1:])
            top = upper_first if line != "@other" else top
            if "quoted" in options:
                rows = [[f'"{cell}"' for cell in row] for row in rows]
            result += [write.separator.join(row) for row in rows]
        else:
            result.append(line.format_map(write.fields()))
    lacks = [key for key in options.get("lacks", "").split(",") if key]
    if "refuse" in options:
        write.word = options["refuse"]
    code = choose.choice(options.get("encodings", "utf-8").split(","))
    newline = "\r\n" if options.get("newline") == "crlf" else "\n"
    return write.text(
        f"program: {name}",
        result,
        full=not lacks and "refuse" not in options,
        top=top,
        code=code,
        newline=newline,
        refused="refuse" in options,
    )


def _headed(write: Writer, lines: list[str]) -> list[str]:
    """Return header lines with the key signs and remark signs of one file."""
    choose = write.choose
    sign = choose.choice(["# ", "#", "; ", "% ", "// ", "", "", ""])
    if sign == "; " and write.separator == ";":
        sign = "# "
    colon = choose.choice([": ", ": ", ": ", " = ", "=", "\t", " : "])
    if write.separator == ";" and sign == "" and choose.random() < 0.5:
        colon = ";"
        lines = [re.sub(r"^([^:]*: [-\d.,]+) (?=\S+$)", r"\1;", line) for line in lines]
    return [sign + line.replace(": ", colon, 1) for line in lines]


def header(write: Writer) -> Text:
    """A matrix below a header that somebody wrote, or a program nobody knows."""
    choose = write.choose
    spelled(write)
    write.form = choose.choice([FIXED, FIXED, FIXED, SIGNED, SCIENTIFIC, LARGE])
    if write.factor(write.height) >= 1e-3:
        write.form = SCIENTIFIC
    declared = marked(write)
    write.surface(write.shape)
    how = choose.choice(["each step", "each step", "steps", "steps", "each size", "sizes", "sizes", "both"])
    steps = {
        "each step": ["dx", "dy"],
        "steps": ["steps"],
        "each size": ["width", "height"],
        "sizes": ["sizes"],
        "both": choose.choice([["dx", "dy", "sizes"], ["width", "height", "steps"]]),
    }[how]
    items = [*steps, "z"]
    lacking = ""
    if choose.random() < 0.25:
        lacking = choose.choice(["z", "steps"])
        items = [item for item in items if (item == "z") != (lacking == "z")]
    if choose.random() < 0.3:
        items += choose.choice([["nx", "ny"], ["points"]])
    lines = [write.phrase(item) for item in items]
    if how.startswith("each") and lacking != "steps" and choose.random() < 0.15:
        lines = [write.phrase(item) for item in ("xy", *items)]
        lines[1:3] = [re.sub(r"(:.*) \S+$", r"\1", line) for line in lines[1:3]]
        how += ", unit apart"
    lines += write.noise(choose.randrange(4))
    choose.shuffle(lines)
    if declared:
        lines.append(declared)
    lines = _headed(
        write,
        [
            line.replace(",", ".")
            if write.decimal == "." and re.search(r"\d,\d", line) and ", " not in line
            else line
            for line in lines
        ],
    )
    if choose.random() < 0.3:
        lines.append("")
    lines += dressed(write, write.cells)
    code = choose.choice(["utf-8", "utf-8", "utf-8-sig", "utf-16", CODES.get(write.language, "cp1252")])
    return write.text(
        f"header: {how}{', without ' * bool(lacking)}{lacking}",
        lines,
        full=not lacking and not write.word,
        top=True,
        code=code,
    )


def columns(write: Writer) -> Text:
    """Named columns of a profile or of points."""
    choose = write.choose
    write.units(choose.choice(["um", "mm"]), choose.choice(["nm", "um"]))
    spelled(write, columns=True)
    layout = choose.choice(["profile", "profile", "points x y z", "points y x z"])
    if choose.random() < 0.15 and layout == "profile":
        write.units("um", "nm")
        write.dx, write.slope = 12.5e-6, 0.3
        write.thousands = choose.choice([" ", "\u00a0", "'", "\u202f"])
    if layout == "profile":
        write.dy = write.dx
    elif write.separator == " " and write.thousands == " ":
        write.separator = "\t"
    if write.thousands and write.separator == " ":
        write.separator = ";"
    marked(write, (0, 0, 0) if layout == "profile" else (2, 7, 5))
    write.surface((1, 60) if layout == "profile" else write.shape)
    rows, top = write.table(layout)
    keys = "xz" if layout == "profile" else layout.removeprefix("points ").replace(" ", "")
    names = [write.phrase({"z": "nz"}.get(key, key)) for key in keys]
    units = [write.height if key == "z" else write.lateral for key in keys]
    style = choose.choice(
        ["{} [{}]", "{} [{}]", "{} ({})", "{} ({})", "{}/{}", "{} in {}", "{}_{}", "below", "none", "z only"]
    )
    bare = style in ("none", "z only")
    if style == "below":
        heads = [names, units]
    elif bare:
        heads = [
            [
                f"{name} [{unit}]" if key == "z" and style == "z only" else name
                for key, name, unit in zip(keys, names, units, strict=True)
            ]
        ]
    else:
        if write.separator == " ":
            style = "{}[{}]"
            names, units = (
                [text.replace(" ", blank) for text in texts] for texts, blank in ((names, "_"), (units, ""))
            )
        heads = [[style.format(name, unit.strip("[]()")) for name, unit in zip(names, units, strict=True)]]
    lines = write.noise(choose.choice([0, 0, 1, 2]))
    lines = _headed(write, lines) + dressed(write, heads + rows, names=len(heads))
    code = choose.choice(["utf-8", "utf-8", "utf-8-sig", CODES.get(write.language, "cp1252")])
    return write.text(
        f"columns: {layout.partition(' ')[0]}, {style}",
        lines,
        full=not bare and not write.word,
        top=top,
        code=code,
    )


def bare(write: Writer) -> Text:
    """Columns without names, or a matrix, below a title, units, or nothing."""
    choose = write.choose
    write.units("mm" if choose.random() < 0.3 else "um", choose.choice(["nm", "nm", "um"]))
    spelled(write, 0.8)
    layout = choose.choice(["profile", "points x y z", "matrix"])
    above = choose.choice(["nothing", "heights alone", "units of axes"])
    if layout == "profile":
        write.dy = write.dx
    if layout != "points x y z" and above == "units of axes":
        above = "heights alone"
    write.surface((1, 60) if layout == "profile" else write.shape)
    rows, top = write.table(layout)
    lines = []
    if above != "nothing":
        lines = [write.phrase(above, PATTERNS[above])]
        if choose.random() < 0.7:
            lines = [choose.choice(["# ", "% ", "// "]) + line for line in lines]
    lines += dressed(write, rows)
    return write.text(
        f"bare: {layout.partition(' ')[0]}, {above}",
        lines,
        full=above == "units of axes",
        top=top,
        code=choose.choice(["utf-8", "utf-8-sig"]),
    )


def trap(write: Writer) -> Text:
    """A header with one line on which the meaning of the numbers turns."""
    choose = write.choose
    kind = choose.choice(
        [
            "sign",
            "factor",
            "counts",
            "swapped steps",
            "swapped sizes",
            "length and width",
            "size of the whole map",
            "size of the specimen",
            "binning",
        ]
    )
    write.units(choose.choice(["um", "µm", "mm"]), choose.choice(["nm", "um"]))
    write.counts = kind in ("factor", "counts")
    write.dy = write.dx if kind in ("size of the whole map", "binning") else 1.5 * write.dx
    write.surface(write.shape)
    write.language = write.language if kind == "counts" else "English"
    lines = write.phrase(kind, PATTERNS.get(kind)).split(" ¬ ")
    if kind == "binning" and "Binning" in lines[-1]:
        write.dx = write.dy = write.dx / 2
        write.word = "[Bb]inn"
    if kind == "sign":
        write.word = "(?i)" + PATTERNS[kind]
    if kind in ("sign", "factor", "counts"):
        lines += choose.choice(
            [[write.phrase("dx"), write.phrase("dy")], [write.phrase("width"), write.phrase("height")]]
        )
    if not write.counts:
        lines.append(write.phrase("z"))
    if choose.random() < 0.5 and not lines[0].startswith("["):
        choose.shuffle(lines)
    sign = choose.choice(["# ", "", "% "])
    lines = [sign + line for line in lines] + [write.separator.join(row) for row in write.cells]
    return write.text(
        f"trap: {kind}",
        lines,
        full=kind.startswith(("swapped", "counts")),
        top=True,
        code=choose.choice(["utf-8", "utf-8-sig"]),
    )


def beside(write: Writer) -> Text:
    """Words or results in cells beside the first points."""
    choose = write.choose
    write.separator = choose.choice([";", ",", "\t"])
    write.decimal = "." if write.separator == "," else write.decimal
    write.units(choose.choice(["um", "mm", "µm"]), choose.choice(["nm", "um"]))
    layout = choose.choice(["profile", "points x y z"])
    if layout == "profile":
        write.dy = write.dx
    write.surface((1, 60) if layout == "profile" else write.shape)
    rows, top = write.table(layout)
    head = [
        [
            f"{key} [{write.height if key == 'z' else write.lateral}]"
            for key in ("xz" if layout == "profile" else "xyz")
        ]
    ]
    heads = choose.choice([head, head, []])
    how = choose.choice(["remark", "remark", "results", "named remark"])
    for number in choose.sample(range(3), choose.choice([1, 1, 2])):
        extra = [write.phrase("notes")] if "remark" in how else ["", "Ra [µm]", write.number(0.25)]
        rows[number] = [*rows[number], *extra]
    if how == "named remark" and heads:
        heads = [[*heads[0], write.phrase("note")]]
    widest = max(map(len, rows))
    if choose.random() < 0.5:
        rows = [[*row, *[""] * (widest - len(row))] for row in rows]
    return write.text(
        f"beside: {layout.partition(' ')[0]}, {how}, {'named' if heads else 'bare'}",
        [write.separator.join(row) for row in heads + rows],
        full=bool(heads),
        top=top,
    )


KINDS = (program, program, program, header, header, header, columns, columns, bare, trap, beside)


def text_of(number: int, seed: int = 1) -> Text:
    """Return a random text, of one kind after the other."""
    return KINDS[number % len(KINDS)](Writer(number, seed))


def _wrong(text: Text, height: Any) -> str:
    """Return a pattern of the words that concern what is wrong with a map, or "" if it is right."""
    if text.heights is None:
        return text.word
    if height.shape != text.heights.shape:
        return "row|line|column|point|left out|cell|not used"
    values, right = height.values, text.heights
    if not np.array_equal(np.isnan(values), np.isnan(right)):
        return "missing|marker|lowest|highest|far from|-9999|−9999|span"
    if not np.allclose(values, right, rtol=1e-6, atol=1e-9 * np.nanmax(np.abs(right)), equal_nan=True):
        return "height|unit|factor|scale|slope|span|first_row|sign"
    steps = [float(height[axis][1] - height[axis][0]) for axis in "xy" if height.sizes[axis] > 1]
    if not np.allclose(steps, text.steps[: len(steps)], rtol=1e-5):
        return "size|step|field|pixel"
    return ""


def outcome(text: Text, folder: Path) -> tuple[str, str]:
    """Read a text, with the answers to what is asked; return what came of it, and what was said."""
    path = folder / "text.txt"
    path.write_bytes(text.data)
    answers, messages = {}, []
    for _ in range(4):
        try:
            height = read_height_map(path, **answers)
        except RoughContactError as error:
            message = str(error).replace(str(path), "")
            messages.append(message)
            request = re.search(r"\b(give|state|name)\b.*", message, re.DOTALL)
            names = [key for key in text.answers if request and re.search(rf"\b{key}\b", request[0])]
            if not {*names} - {*answers}:
                return "refused", " ¦ ".join(messages)
            answers |= {key: text.answers[key] for key in names}
            continue
        except Exception as error:  # what a user would meet as a traceback
            return "CRASH", repr(error)
        words = [
            word
            for word in json.loads(height.attrs["ingest_warnings"])
            if not word.startswith("the pixels are not square")
        ]
        messages += [f"{answers} {words}"]
        about = _wrong(text, height)
        concerned = any(re.search(text.word if text.word and not about else about, word) for word in words)
        if not about and (concerned or not text.word):
            return ("read" if not answers else "read when answered"), " ¦ ".join(messages)
        return ("wrong with a word" if concerned else "WRONG IN SILENCE"), " ¦ ".join(messages)
    return "refused", " ¦ ".join(messages)


def counted(texts: int, seed: int, folder: Path, kind: str = "") -> list[tuple[Text, str, str]]:
    """Return so many texts, what came of each, and what was said."""
    texts_made = (text_of(number, seed) for number in range(texts))
    return [(text, *outcome(text, folder)) for text in texts_made if kind in text.kind]


def arguments(doc: str | None, texts: int) -> argparse.ArgumentParser:
    """Return the arguments of a command that reads so many texts."""
    parser = argparse.ArgumentParser(description=str(doc).partition("\n")[0])
    parser.add_argument("--texts", type=int, default=texts)
    parser.add_argument("--seed", type=int, default=1)
    return parser


def main() -> int:
    """Count the outcomes by kind, and print texts that went wrong."""
    parser = arguments(__doc__, 5000)
    parser.add_argument("--kind", default="", help="part of the name of the kinds that are read")
    parser.add_argument("--outcome", default="S", help="outcome of the texts that are shown")
    parser.add_argument("--show", type=int, default=10)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        outcomes = counted(options.texts, options.seed, Path(folder), options.kind)
    kinds = Counter((text.kind.partition(",")[0], result) for text, result, _ in outcomes)
    for (kind, result), number in sorted(kinds.items()):
        print(f"{number:5d}  {kind:45s} {result}")
    for text, result, words in [
        outcome_of_text for outcome_of_text in outcomes if options.outcome in outcome_of_text[1]
    ][: options.show]:
        print(f"---- {text.kind}: {result}: {words}\n{text.data[:900]!r}")
    full = [result for text, result, _ in outcomes if text.full]
    print(
        "; ".join(
            f"{result}: {number}"
            for result, number in Counter(result for _, result, _ in outcomes).most_common()
        )
    )
    print(f"of {len(full)} that state all, {full.count('read') / max(1, len(full)):.1%} are read at once")
    return int(any(result.isupper() for _, result, _ in outcomes))


if __name__ == "__main__":
    sys.exit(main())
